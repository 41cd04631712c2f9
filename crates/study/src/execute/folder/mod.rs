//! Results folder of a run: on the disk, or in memory.
//!
//! On the disk, a run writes into a temporary folder within the results folder, and at its end moves the files into
//! place: the results of the run before stay complete until those of this one are, and nothing of them stays
//! afterwards. The manifest says which files are results. All other files are left alone. In memory, names and bytes
//! are the same.

mod disk;
mod manifest;
mod memory;
mod replace;

use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use luenberger_figures::figure::static_figure;
use luenberger_figures::table::TableError;
use luenberger_figures::{Figure, Table};
use zip::result::ZipError;

use crate::digest;
use crate::error::StudyError;
use disk::Open;
pub(super) use disk::admit;
pub(super) use manifest::is_absent;
use manifest::{Entry, Manifest};
pub use memory::MemoryFolder;
use replace::Renamed;

/// The folder of the blocks in the results folder of a sweep.
pub const BLOCKS: &str = "blocks";

/// Where the results of a run go.
#[derive(Debug, Clone)]
pub enum Output {
    /// A folder of the disk, created if missing. Files of an earlier run are replaced.
    Folder(PathBuf),
    /// A folder in memory, with the same files.
    Memory(MemoryFolder),
}

impl From<PathBuf> for Output {
    fn from(path: PathBuf) -> Self {
        Self::Folder(path)
    }
}

impl From<&Path> for Output {
    fn from(path: &Path) -> Self {
        Self::Folder(path.to_owned())
    }
}

impl From<MemoryFolder> for Output {
    fn from(folder: MemoryFolder) -> Self {
        Self::Memory(folder)
    }
}

/// What holds the files of a run.
trait Place: Send + Sync {
    /// A new file, in place of one of the same name.
    fn create(&self, name: &str) -> io::Result<Box<dyn Content>>;

    /// Size and digest of a file that is written.
    fn entry(&self, name: &str) -> io::Result<Entry>;

    /// Moves the files into place, with the manifest. Returns which other files had to be renamed.
    fn publish(&self, new: &Manifest) -> Result<Renamed, StudyError>;

    /// Its path on the disk, if it has one.
    fn root(&self) -> Option<&Path> {
        None
    }

    /// A path on the disk that is deleted at the end, if it has one.
    fn temporary(&self, _name: &str) -> Option<PathBuf> {
        None
    }
}

/// A file while it is written.
trait Content: Write + Seek + Send {}

impl<T: Write + Seek + Send> Content for T {}

/// A folder, or none if nothing is to be written.
pub(super) struct Folder {
    place: Option<Box<dyn Place>>,
    written: Mutex<Vec<Entry>>,
}

/// A file that is written piece by piece; nothing is written without a folder.
pub(super) struct Stream {
    to: Option<(Box<dyn Content>, PathBuf)>,
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

impl Folder {
    /// Opens the folder, which is created if missing. A folder with other files and without a manifest is an error
    /// unless `force`. One in memory is emptied.
    pub(super) fn open(output: Option<Output>, force: bool) -> Result<Self, StudyError> {
        let place: Option<Box<dyn Place>> = match output {
            None => None,
            Some(Output::Folder(root)) => Some(Box::new(Open::new(root, force)?)),
            Some(Output::Memory(folder)) => {
                folder.take();
                Some(Box::new(folder))
            }
        };
        Ok(Self { place, written: Mutex::new(Vec::new()) })
    }

    pub(super) fn is_wanted(&self) -> bool {
        self.place.is_some()
    }

    /// Its path on the disk, if there is one.
    pub(super) fn root(&self) -> Option<&Path> {
        self.place.as_ref()?.root()
    }

    /// A path on the disk within the temporary folder, which is deleted at the end.
    pub(super) fn temporary(&self, name: &str) -> Option<PathBuf> {
        self.place.as_ref()?.temporary(name)
    }

    /// A file as the user knows it.
    fn known(&self, name: &str) -> PathBuf {
        self.root().map_or_else(|| PathBuf::from(name), |root| root.join(name))
    }

    fn entries(&self) -> MutexGuard<'_, Vec<Entry>> {
        self.written.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records a file that is written.
    fn add(&self, entry: Entry) {
        let mut entries = self.entries();
        entries.retain(|other| other.name != entry.name);
        entries.push(entry);
    }

    /// Writes a file of the folder; the parts of the name are separated by `/`.
    pub(super) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StudyError> {
        let Some(place) = &self.place else { return Ok(()) };
        let write = || {
            let mut file = place.create(name)?;
            file.write_all(bytes)?;
            file.flush()
        };
        write().map_err(io_error(&self.known(name)))?;
        self.add(Entry::of(name, bytes));
        Ok(())
    }

    /// A file of the folder that is written piece by piece.
    pub(super) fn stream(&self, name: &str) -> Result<Stream, StudyError> {
        let path = self.known(name);
        let file = self.place.as_ref().map(|place| place.create(name).map_err(io_error(&path))).transpose()?;
        let to = file.map(|file| (file, path));
        Ok(Stream { to, name: name.to_owned(), digest: digest::Running::default(), bytes: 0 })
    }

    /// Ends such a file.
    pub(super) fn finish_stream(&self, stream: Stream) -> Result<(), StudyError> {
        let Stream { to: Some((mut file, path)), name, digest, bytes } = stream else { return Ok(()) };
        file.flush().map_err(io_error(&path))?;
        self.add(Entry { name, bytes, sha256: digest.finish() });
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
        let Some(place) = &self.place else { return Ok(Renamed::new()) };
        let (name, text) = study;
        place.publish(&Manifest::new(command, Entry::of(name, text.as_bytes()), self.entries().clone()))
    }

    /// A table as CSV and npz: `NAME.csv`, `NAME.npz`. Both are written piece by piece: as text a long table is several
    /// times its size.
    pub(super) fn table(&self, name: &str, table: &Table) -> Result<(), StudyError> {
        let Some(place) = &self.place else { return Ok(()) };
        let (csv, npz) = (format!("{name}.csv"), format!("{name}.npz"));
        let mut stream = self.stream(&csv)?;
        table.write_csv(&mut stream).map_err(|error| of_table(&self.known(&csv), name, error))?;
        self.finish_stream(stream)?;
        let known = self.known(&npz);
        let mut file = place.create(&npz).map_err(io_error(&known))?;
        table.write_npz(&mut file).map_err(|error| of_table(&known, name, error))?;
        file.flush().map_err(io_error(&known))?;
        drop(file);
        self.add(place.entry(&npz).map_err(io_error(&known))?);
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

/// The error of an operation on `path`.
pub(super) fn io_error(path: &Path) -> impl Fn(io::Error) -> StudyError {
    let path = path.to_owned();
    move |error| StudyError::io(&path, error)
}

fn rename(from: &Path, to: &Path) -> Result<(), StudyError> {
    std::fs::rename(from, to).map_err(io_error(to))
}
