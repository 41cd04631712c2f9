//! Results in memory.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::manifest::{Entry, MANIFEST, Manifest};
use super::replace::Renamed;
use super::{Content, Place};
use crate::error::StudyError;

/// A results folder in memory: files with their names, which have `/` between their parts. Clones share the files.
///
/// ```
/// use luenberger_study::{Format, MemoryFolder, RunOptions, Step, Study, execute, template};
/// let text = template::text("double-integrator").ok_or("a template")?;
/// let study = Study::from_text("study.toml", text, Format::Toml, ".".as_ref())?;
/// let folder = MemoryFolder::default();
/// execute(&study, Step::Certify, &RunOptions::default().output(folder.clone().into()))?;
/// let names: Vec<String> = folder.take().into_keys().collect();
/// assert!(names.contains(&"manifest.json".to_owned()) && names.contains(&"study.json".to_owned()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct MemoryFolder(Arc<Mutex<BTreeMap<String, Vec<u8>>>>);

impl MemoryFolder {
    /// The files, which are removed from it.
    pub fn take(&self) -> BTreeMap<String, Vec<u8>> {
        std::mem::take(&mut *self.files())
    }

    fn files(&self) -> MutexGuard<'_, BTreeMap<String, Vec<u8>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A file that is in its folder once it is dropped.
struct File {
    name: String,
    bytes: Cursor<Vec<u8>>,
    folder: MemoryFolder,
}

impl Write for File {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for File {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.bytes.seek(to)
    }
}

impl Drop for File {
    fn drop(&mut self) {
        let bytes = std::mem::take(self.bytes.get_mut());
        self.folder.files().insert(std::mem::take(&mut self.name), bytes);
    }
}

impl Place for MemoryFolder {
    fn create(&self, name: &str) -> io::Result<Box<dyn Content>> {
        Ok(Box::new(File { name: name.to_owned(), bytes: Cursor::default(), folder: self.clone() }))
    }

    fn entry(&self, name: &str) -> io::Result<Entry> {
        let files = self.files();
        let bytes = files.get(name).ok_or(io::ErrorKind::NotFound)?;
        Ok(Entry::of(name, bytes))
    }

    fn publish(&self, new: &Manifest) -> Result<Renamed, StudyError> {
        self.files().insert(MANIFEST.to_owned(), new.text()?.into_bytes());
        Ok(Renamed::new())
    }
}
