//! Results folder of a run.
//!
//! A run writes into a temporary folder within the results folder, and at its end moves the files into place: the
//! results of the run before stay complete until those of this one are, and nothing of them stays afterwards. The
//! manifest says which files are results. All other files are left alone.

mod manifest;
mod replace;

use std::fs::{File, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use luenberger_figures::figure::static_figure;
use luenberger_figures::table::TableError;
use luenberger_figures::{Figure, Table};
use zip::result::ZipError;

use crate::digest;
use crate::error::StudyError;
pub(super) use manifest::is_absent;
use manifest::{Entry, MANIFEST, Manifest};
use replace::Renamed;

/// Locked while a run writes into the folder.
const LOCK: &str = ".luenberger.lock";

/// The temporary folder. One that is there at the start was left by a run that was killed.
const ASIDE: &str = ".luenberger.partial";

/// The folder of the blocks in the results folder of a sweep.
pub const BLOCKS: &str = "blocks";

/// A folder, or none if nothing is to be written.
pub(super) struct Folder {
    open: Option<Open>,
    written: Mutex<Vec<Entry>>,
}

/// A file that is written piece by piece; nothing is written without a folder.
pub(super) struct Stream {
    to: Option<(BufWriter<File>, PathBuf)>,
    name: String,
    digest: digest::Running,
    bytes: u64,
}

impl Stream {
    pub(super) fn write(&mut self, bytes: &[u8]) -> Result<(), StudyError> {
        let path = self.to.as_ref().map_or_else(PathBuf::new, |(_, path)| path.clone());
        self.write_all(bytes).map_err(io_error(&path))
    }
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some((file, _)) = &mut self.to {
            file.write_all(bytes)?;
            self.digest.add(bytes);
            self.bytes += bytes.len() as u64;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.as_mut().map_or(Ok(()), |(file, _)| file.flush())
    }
}

/// Why a table is not in its file.
fn of_table(path: &Path, name: &str, error: TableError) -> StudyError {
    match error {
        TableError::Io(error) | TableError::Zip(ZipError::Io(error)) => StudyError::io(path, error),
        TableError::Csv(error) if error.is_io_error() => {
            let why = error.to_string();
            match error.into_kind() {
                csv::ErrorKind::Io(error) => StudyError::io(path, error),
                _ => StudyError::Output { what: name.to_owned(), why },
            }
        }
        error => StudyError::Output { what: name.to_owned(), why: error.to_string() },
    }
}

/// A folder that this process has locked.
struct Open {
    root: PathBuf,
    aside: PathBuf,
    before: Option<Manifest>,
    /// Holds the lock; none on file systems that have no locks.
    _lock: Option<File>,
}

impl Folder {
    /// Opens the folder, which is created if missing. A folder with other files and without a manifest is an error
    /// unless `force`.
    pub(super) fn open(root: Option<PathBuf>, force: bool) -> Result<Self, StudyError> {
        let open = root.map(|root| Open::new(root, force)).transpose()?;
        Ok(Self { open, written: Mutex::new(Vec::new()) })
    }

    pub(super) fn is_wanted(&self) -> bool {
        self.open.is_some()
    }

    /// Its path, if there is one.
    pub(super) fn root(&self) -> Option<&Path> {
        self.open.as_ref().map(|open| open.root.as_path())
    }

    /// A path within the temporary folder, which is deleted at the end.
    pub(super) fn temporary(&self, name: &str) -> Option<PathBuf> {
        self.open.as_ref().map(|open| open.aside.join(format!(".{name}")))
    }

    fn entries(&self) -> MutexGuard<'_, Vec<Entry>> {
        self.written.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes a file of the folder; the parts of the name are separated by `/`.
    pub(super) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StudyError> {
        let Some(Open { root, aside, .. }) = &self.open else { return Ok(()) };
        let path = aside.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(io_error(parent))?;
        }
        // Messages name the file as the user knows it.
        std::fs::write(&path, bytes).map_err(io_error(&root.join(name)))?;
        let mut entries = self.entries();
        entries.retain(|entry| entry.name != name);
        entries.push(Entry::of(name, bytes));
        Ok(())
    }

    /// A file of the folder that is written piece by piece.
    pub(super) fn stream(&self, name: &str) -> Result<Stream, StudyError> {
        let open = |Open { root, aside, .. }: &Open| {
            let path = root.join(name);
            let file = File::create(aside.join(name)).map_err(io_error(&path))?;
            Ok::<_, StudyError>((BufWriter::new(file), path))
        };
        let to = self.open.as_ref().map(open).transpose()?;
        Ok(Stream { to, name: name.to_owned(), digest: digest::Running::default(), bytes: 0 })
    }

    /// Ends such a file.
    pub(super) fn finish_stream(&self, stream: Stream) -> Result<(), StudyError> {
        let Stream { to: Some((mut file, path)), name, digest, bytes } = stream else { return Ok(()) };
        file.flush().map_err(io_error(&path))?;
        let mut entries = self.entries();
        entries.retain(|entry| entry.name != name);
        entries.push(Entry { name, bytes, sha256: digest.finish() });
        Ok(())
    }

    /// The files written so far, sorted by name.
    pub(super) fn written(&self) -> Vec<String> {
        let mut written: Vec<String> = self.entries().iter().map(|entry| entry.name.clone()).collect();
        written.sort();
        written
    }

    /// Moves the files into place, with a manifest that names the command and the study. Returns which other files had
    /// to be renamed.
    pub(super) fn finish(&self, command: &str, study: (&str, &str)) -> Result<Renamed, StudyError> {
        let Some(Open { root, aside, before, .. }) = &self.open else { return Ok(Renamed::new()) };
        let (name, text) = study;
        let new = Manifest::new(command, Entry::of(name, text.as_bytes()), self.entries().clone());
        replace::replace(root, aside, before.as_ref(), &new)
    }

    /// A table as CSV and npz: `NAME.csv`, `NAME.npz`. Both are written piece by piece: as text a long table is several
    /// times its size.
    pub(super) fn table(&self, name: &str, table: &Table) -> Result<(), StudyError> {
        let Some(Open { root, aside, .. }) = &self.open else { return Ok(()) };
        let (csv, npz) = (format!("{name}.csv"), format!("{name}.npz"));
        if let Some(parent) = aside.join(name).parent() {
            std::fs::create_dir_all(parent).map_err(io_error(parent))?;
        }
        let mut stream = self.stream(&csv)?;
        table.write_csv(&mut stream).map_err(|error| of_table(&root.join(&csv), name, error))?;
        self.finish_stream(stream)?;
        let (path, known) = (aside.join(&npz), root.join(&npz));
        let mut to = BufWriter::new(File::create(&path).map_err(io_error(&known))?);
        table.write_npz(&mut to).map_err(|error| of_table(&known, name, error))?;
        to.flush().map_err(io_error(&known))?;
        let bytes = to.get_ref().metadata().map_err(io_error(&known))?.len();
        let sha256 = digest::of_file(&path).map_err(io_error(&known))?;
        let mut entries = self.entries();
        entries.retain(|entry| entry.name != npz);
        entries.push(Entry { name: npz, bytes, sha256 });
        Ok(())
    }

    /// A figure as SVG and PNG.
    pub(super) fn figure(&self, id: &str, figure: &Figure) -> Result<(), StudyError> {
        let failed = |why: luenberger_figures::figure::FigureError| StudyError::Output {
            what: id.to_owned(),
            why: why.to_string(),
        };
        self.write(&format!("figures/{id}.svg"), static_figure::svg(figure).map_err(failed)?.as_bytes())?;
        self.write(&format!("figures/{id}.png"), &static_figure::png(figure).map_err(failed)?)
    }
}

impl Open {
    fn new(root: PathBuf, force: bool) -> Result<Self, StudyError> {
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

impl Drop for Open {
    /// Removes the temporary folder.
    fn drop(&mut self) {
        // If that fails, the next run removes it.
        _ = std::fs::remove_dir_all(&self.aside);
    }
}

/// Creates a results folder if it is missing. A folder with other files and without a manifest is an error unless
/// `force`.
pub(super) fn admit(root: &Path, force: bool) -> Result<(), StudyError> {
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

/// The error of an operation on `path`.
pub(super) fn io_error(path: &Path) -> impl Fn(io::Error) -> StudyError {
    let path = path.to_owned();
    move |error| StudyError::io(&path, error)
}

fn rename(from: &Path, to: &Path) -> Result<(), StudyError> {
    std::fs::rename(from, to).map_err(io_error(to))
}
