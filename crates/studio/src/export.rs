//! `export`: an observer as code for its target.

use luenberger_export::fmu::Version;
use luenberger_study::deployment::{self, ExportOptions, Language, Precision};
use luenberger_study::{MemoryFolder, write_folder};
use serde_json::json;

use crate::error::StudioError;
use crate::message::Message;
use crate::study::{self, positive, text, truth};

/// What an observer can be written as.
pub(crate) const LANGUAGES: [&str; 4] = ["c", "rust", "fmu2", "fmu3"];

/// The files of the command `luenberger export`. FMUs have no binaries: a page has no compiler.
pub(crate) fn export(request: Message) -> Result<Message, StudioError> {
    let (to, fmi) = match text(&request, "language")? {
        None | Some("c") => (Language::C, None),
        Some("rust") => (Language::Rust, None),
        Some("fmu" | "fmu2") => (Language::Fmu, Some(Version::Two)),
        Some("fmu3") => (Language::Fmu, Some(Version::Three)),
        Some(_) => return Err(StudioError::Key { key: "language", expected: LANGUAGES.join(", ") }),
    };
    let format = text(&request, "scalar")?.map(str::parse::<Precision>).transpose();
    let format = format.map_err(|expected| StudioError::Key { key: "scalar", expected })?;
    let options = ExportOptions {
        to,
        fmi,
        period: positive(&request, "period")?,
        format: format.unwrap_or(Precision::Binary64),
        feedback: truth(&request, "feedback", false)?,
        unproved: truth(&request, "unproved", false)?,
        ..ExportOptions::default()
    };
    options.check()?;
    let observer = text(&request, "observer")?.map(str::to_owned);
    let study = study::of(request)?;
    let exported = deployment::export(&study, observer.as_deref(), &options)?;
    let folder = MemoryFolder::default();
    write_folder(folder.clone(), false, "export", &study, &exported.files)?;
    let json = json!({
        "observer": exported.observer,
        "text": exported.in_words("the archive"),
        "proved": exported.proved,
        "statement": exported.statement,
        "notes": exported.notes,
        "results": serde_json::to_value(&exported)?,
    });
    Ok(Message::new(json).with(folder.take()))
}
