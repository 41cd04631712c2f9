//! Output folder. Files are written under a temporary name and moved into place, so that no file is incomplete.

use std::io::Cursor;
use std::path::PathBuf;
use std::sync::Mutex;

use luenberger_figures::figure::still;
use luenberger_figures::{Figure, Table};

use crate::error::StudyError;

/// A folder, or none if nothing is to be written.
pub(super) struct Folder {
    root: Option<PathBuf>,
    written: Mutex<Vec<String>>,
}

impl Folder {
    pub(super) fn new(root: Option<PathBuf>) -> Result<Self, StudyError> {
        if let Some(root) = &root {
            std::fs::create_dir_all(root).map_err(|error| StudyError::io(root, error))?;
        }
        Ok(Self { root, written: Mutex::new(Vec::new()) })
    }

    pub(super) fn is_wanted(&self) -> bool {
        self.root.is_some()
    }

    /// Writes a file of the folder; the parts of the name are separated by `/`.
    pub(super) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StudyError> {
        let Some(root) = &self.root else { return Ok(()) };
        let path = root.join(name);
        let parent = path.parent().unwrap_or(root);
        std::fs::create_dir_all(parent).map_err(|error| StudyError::io(parent, error))?;
        let mut beside = path.as_os_str().to_owned();
        beside.push(".part");
        let beside = PathBuf::from(beside);
        std::fs::write(&beside, bytes).map_err(|error| StudyError::io(&beside, error))?;
        std::fs::rename(&beside, &path).map_err(|error| StudyError::io(&path, error))?;
        let mut written = self.written.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if !written.iter().any(|other| other == name) {
            written.push(name.to_owned());
        }
        Ok(())
    }

    /// The files written so far, sorted by name.
    pub(super) fn written(&self) -> Vec<String> {
        let mut written = self.written.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone();
        written.sort();
        written
    }

    /// A table as CSV and npz: `NAME.csv`, `NAME.npz`.
    pub(super) fn table(&self, name: &str, table: &Table) -> Result<(), StudyError> {
        let failed = |why: luenberger_figures::table::TableError| StudyError::Output {
            what: name.to_owned(),
            why: why.to_string(),
        };
        let mut csv = Vec::new();
        table.write_csv(&mut csv).map_err(failed)?;
        self.write(&format!("{name}.csv"), &csv)?;
        let mut npz = Cursor::new(Vec::new());
        table.write_npz(&mut npz).map_err(failed)?;
        self.write(&format!("{name}.npz"), &npz.into_inner())
    }

    /// A figure as SVG and PNG.
    pub(super) fn figure(&self, id: &str, figure: &Figure) -> Result<(), StudyError> {
        let failed = |why: luenberger_figures::figure::FigureError| StudyError::Output {
            what: id.to_owned(),
            why: why.to_string(),
        };
        self.write(&format!("figures/{id}.svg"), still::svg(figure).map_err(failed)?.as_bytes())?;
        self.write(&format!("figures/{id}.png"), &still::png(figure).map_err(failed)?)
    }
}
