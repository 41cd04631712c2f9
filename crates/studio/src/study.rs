//! The study of a request.

use luenberger_study::{Format, Study};
use serde_json::Value;

use crate::error::StudioError;
use crate::message::Message;

/// The longest study that is read: an editor and its highlighting are slow beyond.
pub(crate) const LONGEST: usize = 4 << 20;

/// A study as it is written, with its name and format.
pub(crate) struct Written {
    pub(crate) name: String,
    pub(crate) text: String,
    pub(crate) format: Format,
}

impl Written {
    /// That of a request.
    pub(crate) fn of(request: &Message) -> Result<Self, StudioError> {
        let expected = "the text of a study".to_owned();
        let text = text(request, "study")?.ok_or(StudioError::Key { key: "study", expected })?;
        if text.len() > LONGEST {
            return Err(StudioError::Long { found: text.len(), limit: LONGEST });
        }
        let name = self::text(request, "name")?.unwrap_or("study.toml");
        let format = match self::text(request, "format")? {
            Some("toml") => Format::Toml,
            Some("json") => Format::Json,
            Some(_) => return Err(StudioError::Key { key: "format", expected: "toml or json".to_owned() }),
            None if name.to_ascii_lowercase().ends_with(".json") => Format::Json,
            None => Format::Toml,
        };
        Ok(Self { name: name.to_owned(), text: text.to_owned(), format })
    }

    /// The study, with the files of the request.
    pub(crate) fn study(&self, files: Vec<(String, Vec<u8>)>) -> Result<Study, StudioError> {
        Ok(Study::with_files(&self.name, &self.text, self.format, files.into_iter().collect())?)
    }
}

/// The study of a request that needs one.
pub(crate) fn of(request: Message) -> Result<Study, StudioError> {
    Written::of(&request)?.study(request.files)
}

/// A text of a request, if it has one.
pub(crate) fn text<'a>(request: &'a Message, key: &'static str) -> Result<Option<&'a str>, StudioError> {
    match request.json.get(key) {
        None | Some(Value::Null) => Ok(None),
        Some(Value::String(text)) => Ok(Some(text)),
        Some(_) => Err(StudioError::Key { key, expected: "a text".to_owned() }),
    }
}

/// A positive number of a request, if it has one.
pub(crate) fn positive(request: &Message, key: &'static str) -> Result<Option<f64>, StudioError> {
    match request.json.get(key) {
        None | Some(Value::Null) => Ok(None),
        Some(value) => match value.as_f64().filter(|x| *x > 0.0 && x.is_finite()) {
            Some(x) => Ok(Some(x)),
            None => Err(StudioError::Key { key, expected: "a positive number".to_owned() }),
        },
    }
}

/// A switch of a request, with its default.
pub(crate) fn truth(request: &Message, key: &'static str, default: bool) -> Result<bool, StudioError> {
    match request.json.get(key) {
        None | Some(Value::Null) => Ok(default),
        Some(Value::Bool(truth)) => Ok(*truth),
        Some(_) => Err(StudioError::Key { key, expected: "true or false".to_owned() }),
    }
}
