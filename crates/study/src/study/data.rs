//! The files of data that a study names: on the disk, or in memory.

use std::collections::BTreeMap;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// Where the files are that a study names.
#[derive(Debug, Clone)]
pub enum DataFiles {
    /// In a folder, that of the study.
    Folder {
        /// The folder.
        path: PathBuf,
        /// The paths of files that are not in the folder, under the names that the study has.
        copies: BTreeMap<String, PathBuf>,
    },
    /// In memory, by their names relative to the study, with `/` between their parts.
    Memory(Arc<BTreeMap<String, Vec<u8>>>),
}

impl DataFiles {
    /// Files in a folder.
    pub fn folder(path: &Path) -> Self {
        Self::Folder { path: path.to_owned(), copies: BTreeMap::new() }
    }

    /// The path of a file; in memory its name.
    pub fn path(&self, name: &str) -> PathBuf {
        match self {
            Self::Folder { path, copies } => copies.get(name).map_or_else(|| path.join(name), PathBuf::clone),
            Self::Memory(_) => PathBuf::from(name),
        }
    }

    /// The content of a file.
    ///
    /// # Errors
    /// Those of the file; in memory [`io::ErrorKind::NotFound`] for a name that is not there.
    pub fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        match self {
            Self::Folder { .. } => std::fs::read(self.path(name)),
            Self::Memory(files) => {
                let absent = || io::Error::new(io::ErrorKind::NotFound, "there is no file of this name");
                files.get(&plain(name)).cloned().ok_or_else(absent)
            }
        }
    }
}

/// A name without the parts that stay where they are: `./log.csv` is `log.csv`.
fn plain(name: &str) -> String {
    let parts = Path::new(name).components().filter(|part| *part != Component::CurDir);
    let parts: Vec<_> = parts.map(|part| part.as_os_str().to_string_lossy()).collect();
    parts.join("/")
}
