//! `manifest.json`: what the command has written into a results folder. Only these files are replaced or removed by the
//! next run.

use std::io;
use std::path::{Component, Path};

use serde::{Deserialize, Serialize};

use crate::digest;

/// The name of the manifest in its folder.
pub(super) const MANIFEST: &str = "manifest.json";

/// The version of the format.
const FORMAT: u32 = 1;

/// Content of `manifest.json`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Manifest {
    pub(super) format: u32,
    /// Version of the command.
    pub(super) luenberger: String,
    /// `run`, `certify`, ...
    pub(super) command: String,
    pub(super) study: Entry,
    /// Sorted by name. While a run replaces the files of another, a name may be listed twice, with either content.
    pub(super) files: Vec<Entry>,
}

/// A file: its name relative to the folder, with `/` between the parts, its size in bytes, and its digest.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) struct Entry {
    pub(super) name: String,
    pub(super) bytes: u64,
    /// SHA-256 in hexadecimal digits.
    pub(super) sha256: String,
}

impl Entry {
    pub(super) fn of(name: &str, content: &[u8]) -> Self {
        Self { name: name.to_owned(), bytes: content.len() as u64, sha256: digest::sha256(content) }
    }

    /// Whether the file at `path` has this content.
    pub(super) fn is_at(&self, path: &Path) -> io::Result<bool> {
        let kind = match path.symlink_metadata() {
            Ok(kind) => kind,
            Err(error) if is_absent(&error) => return Ok(false),
            Err(error) => return Err(error),
        };
        Ok(kind.is_file() && kind.len() == self.bytes && digest::of_file(path)? == self.sha256)
    }
}

/// Whether there is nothing at a path.
pub(in crate::execute) fn is_absent(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

impl Manifest {
    pub(super) fn new(command: &str, study: Entry, mut files: Vec<Entry>) -> Self {
        files.sort();
        Self {
            format: FORMAT,
            luenberger: env!("CARGO_PKG_VERSION").to_owned(),
            command: command.to_owned(),
            study,
            files,
        }
    }

    /// The manifest of a folder; none if it has none, or a file of that name that this command did not write.
    pub(super) fn read(root: &Path) -> io::Result<Option<Self>> {
        let text = match std::fs::read_to_string(root.join(MANIFEST)) {
            Ok(text) => text,
            Err(error) if is_absent(&error) || error.kind() == io::ErrorKind::InvalidData => return Ok(None),
            Err(error) => return Err(error),
        };
        let manifest: Option<Self> = serde_json::from_str(&text).ok();
        Ok(manifest
            .filter(|manifest| manifest.format == FORMAT && manifest.files.iter().all(|entry| is_within(&entry.name))))
    }

    pub(super) fn text(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

/// Whether a name stays within the folder: a manifest is read from a folder that others may write to.
fn is_within(name: &str) -> bool {
    !name.is_empty() && Path::new(name).components().all(|part| matches!(part, Component::Normal(_)))
}
