//! `about`: what the module knows without a study.

use luenberger_study::kinds::registry;
use luenberger_study::{TEMPLATES, Template, schema};
use serde_json::{Value, json};

use crate::error::StudioError;
use crate::message::Message;

/// Version, schema of studies, kinds of observers and templates. Files of a template are named `TEMPLATE/FILE`.
#[expect(clippy::unnecessary_wraps, reason = "as the other requests")]
pub(crate) fn about() -> Result<Message, StudioError> {
    let template = |template: &Template| {
        let Template { name, about, text, files } = template;
        let title = text.lines().find_map(|line| line.strip_prefix("title = ")).map(|title| title.trim_matches('"'));
        let files: Vec<&str> = files.iter().map(|(file, _)| *file).collect();
        json!({ "name": name, "title": title, "about": about, "text": text, "files": files })
    };
    let kinds: Vec<Value> = registry()
        .iter()
        .map(|kind| json!({ "name": kind.name, "about": kind.about, "plant": kind.plant.to_string(), "source": kind.source }))
        .collect();
    let json = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "schema": schema::json_schema(),
        "kinds": kinds,
        "templates": TEMPLATES.iter().map(template).collect::<Vec<Value>>(),
    });
    let files = TEMPLATES.iter().flat_map(|template| {
        template.files.iter().map(|(file, text)| (format!("{}/{file}", template.name), text.as_bytes().to_vec()))
    });
    Ok(Message::new(json).with(files))
}
