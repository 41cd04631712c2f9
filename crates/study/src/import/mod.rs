//! State-space models as MATLAB, python-control and numpy users save them.
//!
//! | file | how it is written |
//! |---|---|
//! | MATLAB's `.mat`, version 5 (`-v6`, `-v7`) | `save model.mat A B C D`, or one structure with these fields |
//! | MATLAB's `.mat`, version 4 (`-v4`) | `save -v4 model.mat A B C D` |
//! | Octave's text | `save model.mat A B C D`, or one structure with these fields |
//! | numpy's `.npz` | `np.savez("model.npz", A=A, B=B, C=C, D=D)`, compressed or not |
//! | JSON | `json.dump({"A": sys.A.tolist(), ...}, file)` |
//!
//! Names may be in upper or lower case. `A` (n x n) and `C` (p x n) are required; `B` (n x m) and `D`
//! (p x m) are optional. A regular `E` of `E x' = A x + B u` is multiplied into A and B. A sampling time (`dt`, `Ts`)
//! above zero makes the plant one in discrete time; true, a period left open, counts samples: 1. Zero, none and false
//! mean continuous time. Complex matrices whose imaginary part is zero are real. Names of the columns are kept: lists
//! of texts with MATLAB's names (`StateName`, `InputName`, `OutputName`), python-control's (`state_labels`, ..) or
//! those of a study (`states`, ..), where they are distinct and as many as there are columns. Sparse matrices are
//! converted to dense ones. All other variables are ignored, and listed.
//!
//! The format is recognized from the first bytes. Memory is bounded by [`LONGEST_FILE`], [`LARGEST_MATRIX`] and
//! [`INFLATED`]: a file that declares more is rejected before memory is allocated, and no input makes the reader panic.

mod error;
mod json;
mod matlab;
mod model;
mod npz;
mod octave;
mod study;
mod variable;

use std::fs::File;
use std::io::Read;
use std::path::Path;

pub use error::ImportError;
pub use model::Model;

/// The maximal length of a file in bytes.
pub const LONGEST_FILE: u64 = 256 << 20;

/// The maximal number of entries of one matrix: order 4096.
pub const LARGEST_MATRIX: usize = 1 << 24;

/// The maximal total length of decompressed data of one file, in bytes.
pub const INFLATED: u64 = 1 << 30;

/// The model in a file.
///
/// # Errors
/// [`ImportError`]: the file cannot be read, has an unknown format, is damaged, or is not a plant `x' = A x + B u`, `y
/// = C x`.
///
/// # Example
/// ```no_run
/// let model = luenberger_study::import::import("model.mat".as_ref())?;
/// std::fs::write("study.toml", model.study("model"))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn import(path: &Path) -> Result<Model, ImportError> {
    let unreadable = |error: std::io::Error| ImportError::Read { message: error.to_string() };
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    file.take(LONGEST_FILE + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > LONGEST_FILE {
        return Err(ImportError::TooLong { limit: LONGEST_FILE });
    }
    read(&bytes)
}

/// The model in the bytes of a file.
///
/// # Errors
/// As [`import()`].
///
/// # Example
/// ```
/// let model = luenberger_study::import::read(br#"{"A": [[0, 1], [-2, -3]], "B": [[0], [1]], "C": [[1, 0]]}"#)?;
/// assert_eq!((model.a.nrows(), model.b.ncols(), model.c.nrows()), (2, 1, 1));
/// # Ok::<(), luenberger_study::import::ImportError>(())
/// ```
pub fn read(bytes: &[u8]) -> Result<Model, ImportError> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let found = if bytes.starts_with(b"PK\x03\x04") {
        npz::read(bytes)?
    } else if bytes.starts_with(b"\x93NUMPY") {
        return Err(ImportError::OneArray);
    } else if bytes.starts_with(b"\x89HDF\r\n\x1a\n") || bytes.starts_with(b"MATLAB 7.3") {
        return Err(ImportError::Hdf5);
    } else if matlab::is_version_5(bytes) {
        matlab::read(bytes)?
    } else if text.starts_with(b"{") || text.starts_with(b"[") {
        json::read(text)?
    } else if octave::is_octave(text) {
        octave::read(text)?
    } else if matlab::is_version_4(bytes) {
        matlab::read_version_4(bytes)?
    } else if bytes.is_empty() {
        return Err(ImportError::Empty);
    } else {
        return Err(ImportError::UnknownKind { bytes: bytes.len(), first: bytes.iter().take(8).copied().collect() });
    };
    Model::new(found)
}
