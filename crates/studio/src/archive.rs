//! `zip`: all files in one archive.

use std::io::{Cursor, Write};

use serde_json::json;
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipWriter};

use crate::error::StudioError;
use crate::message::Message;

/// The name of the archive.
const NAME: &str = "archive.zip";

/// The files of the request in an archive without times: the same files give the same bytes.
pub(crate) fn zip(request: Message) -> Result<Message, StudioError> {
    let options = SimpleFileOptions::default().last_modified_time(DateTime::DEFAULT);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in request.files {
        archive.start_file(name, options)?;
        archive.write_all(&bytes).map_err(::zip::result::ZipError::from)?;
    }
    let bytes = archive.finish()?.into_inner();
    Ok(Message::new(json!({})).with([(NAME.to_owned(), bytes)]))
}
