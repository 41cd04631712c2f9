//! numpy's npz archives: an uncompressed zip file with an `.npy` file for each array, as `numpy.savez` writes it.
//!
//! The archive has no time stamps: the same arrays give the same bytes.

use std::io::{self, Seek, SeekFrom, Write};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Writes each array of float64 under its name, and each text as a file, which `numpy.load` returns as bytes.
///
/// ```
/// let mut file = std::io::Cursor::new(Vec::new());
/// luenberger_figures::npz::write(&mut file, [("x", &[1.0, f64::INFINITY][..])], &[("about.txt", "two numbers")])?;
/// assert!(file.into_inner().starts_with(b"PK"));
/// # Ok::<(), zip::result::ZipError>(())
/// ```
/// # Errors
/// [`ZipError`]: two arrays with one name, I/O.
pub fn write<'a>(
    to: impl Write + Seek,
    arrays: impl IntoIterator<Item = (&'a str, &'a [f64])>,
    texts: &[(&str, &str)],
) -> Result<(), ZipError> {
    // The default of zip is the current time.
    let stored = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::DEFAULT);
    let mut archive = ZipWriter::new(UpToError { to, position: 0, end: 0, error: None });
    for (name, text) in texts {
        archive.start_file(*name, stored)?;
        archive.write_all(text.as_bytes())?;
    }
    for (name, values) in arrays {
        archive.start_file(format!("{name}.npy"), stored)?;
        archive.write_all(&npy_header(values.len()))?;
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        archive.write_all(&bytes)?;
    }
    match archive.finish()?.error {
        Some(error) => Err(error.into()),
        None => Ok(()),
    }
}

/// A writer that keeps its first error and takes what follows without writing it: a zip writer that has seen an error
/// finishes its archive once more when it is dropped, and prints the error of that.
struct UpToError<W> {
    to: W,
    position: u64,
    end: u64,
    error: Option<io::Error>,
}

impl<W: Write> Write for UpToError<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.error.is_none() {
            self.error = self.to.write_all(bytes).err();
        }
        self.position += bytes.len() as u64;
        self.end = self.end.max(self.position);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.error.is_none() {
            self.error = self.to.flush().err();
        }
        Ok(())
    }
}

impl<W: Write + Seek> Seek for UpToError<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = match to {
            SeekFrom::Start(position) => Some(position),
            SeekFrom::Current(offset) => self.position.checked_add_signed(offset),
            SeekFrom::End(offset) => self.end.checked_add_signed(offset),
        };
        self.position = position.ok_or(io::ErrorKind::InvalidInput)?;
        if self.error.is_none() {
            self.error = self.to.seek(SeekFrom::Start(self.position)).err();
        }
        Ok(self.position)
    }
}

/// The numbers of an `.npy` file that [`write()`] has written; none for any other.
pub fn numbers(npy: &[u8]) -> Option<Vec<f64>> {
    let rest = npy.strip_prefix(MAGIC)?;
    let (length, rest) = rest.split_first_chunk::<2>()?;
    let (_, rest) = rest.split_at_checked(usize::from(u16::from_le_bytes(*length)))?;
    let (numbers, []) = rest.as_chunks::<8>() else { return None };
    (npy[..npy.len() - rest.len()] == npy_header(numbers.len()))
        .then(|| numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
}

/// Magic number and version 1.0.
const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";

/// The header of a one-dimensional array of float64 in an `.npy` file of version 1.0: magic number, version, length of
/// the text, and the text, padded with spaces so that the data begin at a multiple of 64 bytes.
fn npy_header(rows: usize) -> Vec<u8> {
    let text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows},), }}");
    let mut header = MAGIC.to_vec();
    let filled = (header.len() + 2 + text.len() + 1).next_multiple_of(64) - header.len() - 3;
    // The text has at most 78 characters.
    header.extend((filled as u16 + 1).to_le_bytes());
    header.extend(format!("{text:filled$}\n").bytes());
    header
}
