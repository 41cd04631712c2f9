//! An `[[observer]]` as text, and a study with further observers.

use crate::error::StudyError;
use crate::read::{self, Format};
use crate::study::Study;
use crate::tuning::{Keys, Value, object};

/// A basic string of TOML, which is one of JSON too.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// An observer to be added to a study.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Block {
    pub(crate) name: String,
    pub(crate) kind: &'static str,
    /// The specification but for name, kind and first estimate.
    pub(crate) keys: Keys,
    pub(crate) initial: Vec<f64>,
    /// Written above it in TOML.
    pub(crate) comment: String,
}

impl Block {
    fn toml(&self) -> String {
        let comment = if self.comment.is_empty() { String::new() } else { format!("# {}\n", self.comment) };
        let head = format!("{comment}[[observer]]\nname = {}\nkind = {}\n", quoted(&self.name), quoted(self.kind));
        let keys = self.keys.iter().map(|(key, value)| format!("{key} = {}\n", value.toml()));
        let initial = format!("initial = {}\n", Value::numbers(self.initial.iter().copied()).toml());
        head + &keys.collect::<String>() + &initial
    }

    fn inline(&self) -> String {
        let keys: Vec<String> = self.keys.iter().map(|(key, value)| format!("{key} = {}", value.toml())).collect();
        let initial = Value::numbers(self.initial.iter().copied()).toml();
        let (name, kind) = (quoted(&self.name), quoted(self.kind));
        format!("{{ name = {name}, kind = {kind}, {}, initial = {initial} }}", keys.join(", "))
    }

    fn json(&self) -> serde_json::Value {
        let mut all = object(&self.keys);
        all.insert("name".to_owned(), self.name.clone().into());
        all.insert("kind".to_owned(), self.kind.into());
        all.insert("initial".to_owned(), self.initial.iter().copied().collect());
        all.into()
    }
}

/// The text of a study with these observers behind its own; comments and order of a TOML file are kept.
pub(crate) fn text_with(study: &Study, blocks: &[Block]) -> Result<String, StudyError> {
    let text = study.source.text();
    if study.format == Format::Json {
        let mut root: serde_json::Value = serde_json::from_str(text)?;
        if let Some(root) = root.as_object_mut() {
            let list = root.entry("observer").or_insert_with(|| serde_json::Value::Array(Vec::new()));
            if let Some(list) = list.as_array_mut() {
                list.extend(blocks.iter().map(Block::json));
            }
        }
        return Ok(serde_json::to_string_pretty(&root)? + "\n");
    }
    // `observer = [..]` takes no `[[observer]]` after it; a comment may be the last in it.
    if let Some(start) = start_of_inline_list(text) {
        let added = blocks.iter().map(|block| block.inline() + ", ").collect::<String>();
        return Ok(format!("{}{added}{}", &text[..start], &text[start..]));
    }
    let blocks = blocks.iter().flat_map(|block| ["\n".to_owned(), block.toml()]).collect::<String>();
    Ok(format!("{}\n{blocks}", text.trim_end()))
}

/// The position after the opening bracket of `observer = [..]`, if the study is written so.
fn start_of_inline_list(text: &str) -> Option<usize> {
    let table = toml::de::DeTable::parse(text).ok()?;
    let span = table.get_ref().get("observer")?.span();
    let is_inline = text[..span.start].trim_end().ends_with('=') && text[span.start..].starts_with('[');
    is_inline.then_some(span.start + 1)
}

/// The study with these observers, without its log, on which no design depends.
pub(crate) fn study_with(study: &Study, blocks: &[Block]) -> Result<Study, StudyError> {
    read::without_log(study, &text_with(study, blocks)?)
}
