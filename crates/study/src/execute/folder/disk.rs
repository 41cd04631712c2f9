//! Results in a folder of the disk.

use std::fs::{File, TryLockError};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use super::manifest::{Entry, MANIFEST, Manifest};
use super::replace::{Renamed, replace};
use super::{BLOCKS, Content, Place, io_error};
use crate::digest;
use crate::error::StudyError;

/// Locked while a run writes into the folder.
const LOCK: &str = ".luenberger.lock";

/// The temporary folder. One that is there at the start was left by a run that was killed.
const ASIDE: &str = ".luenberger.partial";

/// A folder that this process has locked.
pub(super) struct Open {
    root: PathBuf,
    aside: PathBuf,
    before: Option<Manifest>,
    /// Holds the lock; none on file systems that have no locks.
    _lock: Option<File>,
}

impl Open {
    pub(super) fn new(root: PathBuf, force: bool) -> Result<Self, StudyError> {
        admit(&root, force)?;
        let lock = lock(&root)?;
        // Read again under the lock: another run may have finished in between.
        let before = Manifest::read(&root).map_err(io_error(&root.join(MANIFEST)))?;
        let aside = root.join(ASIDE);
        match std::fs::remove_dir_all(&aside) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(StudyError::io(&aside, error)),
            _ => {}
        }
        std::fs::create_dir(&aside).map_err(io_error(&aside))?;
        Ok(Self { root, aside, before, _lock: lock })
    }
}

impl Place for Open {
    fn create(&self, name: &str) -> io::Result<Box<dyn Content>> {
        let path = self.aside.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)?;
        }
        Ok(Box::new(BufWriter::new(File::create(path)?)))
    }

    fn entry(&self, name: &str) -> io::Result<Entry> {
        let path = self.aside.join(name);
        let (bytes, sha256) = (path.metadata()?.len(), digest::of_file(&path)?);
        Ok(Entry { name: name.to_owned(), bytes, sha256 })
    }

    fn publish(&self, new: &Manifest) -> Result<Renamed, StudyError> {
        replace(&self.root, &self.aside, self.before.as_ref(), new)
    }

    fn root(&self) -> Option<&Path> {
        Some(&self.root)
    }

    fn temporary(&self, name: &str) -> Option<PathBuf> {
        Some(self.aside.join(format!(".{name}")))
    }
}

impl Drop for Open {
    /// Removes the temporary folder.
    fn drop(&mut self) {
        // If that fails, the next run removes it.
        _ = std::fs::remove_dir_all(&self.aside);
    }
}

/// Creates a results folder if it is missing. A folder with other files and without a manifest is an error unless
/// `force`.
pub(in crate::execute) fn admit(root: &Path, force: bool) -> Result<(), StudyError> {
    if root.metadata().is_ok_and(|found| !found.is_dir()) {
        return Err(StudyError::NotAFolder { path: root.to_owned() });
    }
    std::fs::create_dir_all(root).map_err(io_error(root))?;
    if !force && Manifest::read(root).map_err(io_error(&root.join(MANIFEST)))?.is_none() && !is_empty(root)? {
        return Err(StudyError::ForeignFolder { path: root.to_owned() });
    }
    Ok(())
}

/// Whether a folder has no file, except hidden ones and the blocks of a sweep.
fn is_empty(root: &Path) -> Result<bool, StudyError> {
    for entry in std::fs::read_dir(root).map_err(io_error(root))? {
        let name = entry.map_err(io_error(root))?.file_name();
        if !name.as_encoded_bytes().starts_with(b".") && name != BLOCKS {
            return Ok(false);
        }
    }
    Ok(true)
}

fn lock(root: &Path) -> Result<Option<File>, StudyError> {
    let path = root.join(LOCK);
    let file = File::options().create(true).truncate(false).write(true).open(&path).map_err(io_error(&path))?;
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(TryLockError::WouldBlock) => Err(StudyError::FolderInUse { path: root.to_owned() }),
        // Some network file systems have no locks.
        Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => Ok(None),
        Err(TryLockError::Error(error)) => Err(StudyError::io(&path, error)),
    }
}
