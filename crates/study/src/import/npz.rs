//! numpy's npz archives: a zip file with one npy file for each array.
//!
//! An npy file has a magic number, a version, the length of a header, a Python dictionary with `descr`, `fortran_order`
//! and `shape`, and the numbers. The crate npyz, used for writing tables, is not used for reading: for a damaged header
//! it multiplies the dimensions without an overflow check, and it parses nested brackets by recursion.
//!
//! Source: NumPy Enhancement Proposal 1.

use super::model::unread;
use super::variable::{NONE, Value, Variable, entries, is_known, names_of};
use super::{INFLATED, ImportError, LARGEST_MATRIX};
use nalgebra::DMatrix;
use std::io::{Cursor, Read};
use zip::ZipArchive;

/// The maximal number of members that are read.
const MEMBERS: usize = 4096;

/// The maximal length of a header that numpy reads by default.
const LONGEST_HEADER: usize = 10_000;

/// The variables of an archive.
pub(super) fn read(bytes: &[u8]) -> Result<Vec<Variable>, ImportError> {
    let damaged = |error: &dyn std::fmt::Display| ImportError::Archive { message: error.to_string() };
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(&error))?;
    let mut left = INFLATED;
    let mut variables = Vec::new();
    for index in 0..archive.len().min(MEMBERS) {
        let member = archive.by_index(index).map_err(|error| damaged(&error))?;
        let file = member.name().map_err(|error| damaged(&error))?.into_owned();
        let Some(name) = file.strip_suffix(".npy") else { continue };
        if !is_known(name) {
            variables.push(unread(name.to_owned()));
            continue;
        }
        let mut data = Vec::new();
        // At most the size of the largest complex matrix, whatever the archive claims.
        let limit = left.min(16 * LARGEST_MATRIX as u64 + LONGEST_HEADER as u64);
        member.take(limit + 1).read_to_end(&mut data).map_err(|error| damaged(&error))?;
        left = left.checked_sub(data.len() as u64).ok_or(ImportError::Inflated { limit: INFLATED })?;
        let value = array(name, &data)?;
        variables.push(Variable { name: name.to_owned(), value });
    }
    Ok(variables)
}

/// The array of an npy file.
fn array(name: &str, data: &[u8]) -> Result<Value, ImportError> {
    let damaged = |what| ImportError::Damaged { what, at: 0 };
    let cut = || damaged("an array of the archive whose header is cut short");
    let rest = data.strip_prefix(b"\x93NUMPY").ok_or_else(|| damaged("a member of the archive that is no array"))?;
    let (version, rest) = rest.split_first_chunk::<2>().ok_or_else(cut)?;
    let (length, rest) = if version[0] == 1 {
        let (length, rest) = rest.split_first_chunk::<2>().ok_or_else(cut)?;
        (usize::from(u16::from_le_bytes(*length)), rest)
    } else {
        let (length, rest) = rest.split_first_chunk::<4>().ok_or_else(cut)?;
        (u32::from_le_bytes(*length) as usize, rest)
    };
    if length > LONGEST_HEADER {
        return Err(damaged("an array of the archive with a header of more than 10000 bytes"));
    }
    let (header, numbers) = rest.split_at_checked(length).ok_or_else(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| damaged("an array of the archive whose header is no text"))?;
    let header = Header::parse(header).ok_or_else(|| damaged("an array of the archive whose header is not numpy's"))?;
    if names_of(name).is_some() {
        return Ok(header.names(numbers));
    }
    let (rows, columns) = match header.shape[..] {
        // One dimension: row or column is not specified; for one entry it does not matter.
        [] | [1] => (1, 1),
        [rows, columns] => (rows, columns),
        _ => return Ok(Value::Other(format!("an array of the shape {:?}", header.shape))),
    };
    let count = entries(name, rows, columns)?;
    if header.kind == "|O" && is_none(numbers) {
        return Ok(Value::Other(NONE.to_owned()));
    }
    let Some(width) = header.width() else { return Ok(Value::Other(format!("of the type {:?}", header.kind))) };
    if numbers.len() != count * width {
        return Err(damaged("an array of the archive whose numbers are not as many as its shape says"));
    }
    let mut values = header.numbers(numbers);
    if header.is_complex() {
        let (parts, _) = values.as_chunks::<2>();
        if parts.iter().any(|[_, imaginary]| *imaginary != 0.0) {
            return Ok(Value::Other("complex".to_owned()));
        }
        values = parts.iter().map(|[real, _]| *real).collect();
    }
    let (rows, columns) = (rows as usize, columns as usize);
    Ok(Value::Matrix(if header.is_fortran {
        DMatrix::from_vec(rows, columns, values)
    } else {
        DMatrix::from_row_slice(rows, columns, &values)
    }))
}

/// Whether a pickled array of one object holds `None`: a list, perhaps memorised, to which `None` is appended.
fn is_none(pickle: &[u8]) -> bool {
    let is_list = |at: usize| matches!(pickle[..at], [.., b']'] | [.., b']', b'\x94'] | [.., b']', b'q', _]);
    pickle.windows(3).enumerate().any(|(at, window)| window == b"Nat" && is_list(at))
}

/// The content of a header.
struct Header {
    /// `<f8`: the byte order, a letter and the width.
    kind: String,
    is_fortran: bool,
    shape: Vec<u64>,
}

impl Header {
    fn parse(text: &str) -> Option<Self> {
        let value = |key: &str| {
            let at = text.find(&format!("'{key}'"))?;
            text[at + key.len() + 2..].trim_start().strip_prefix(':').map(str::trim_start)
        };
        // A record has a list here, and is not a matrix; its first bytes serve as its name.
        let kind = value("descr")?;
        let kind = match kind.strip_prefix('\'') {
            Some(quoted) => quoted.split('\'').next()?.to_owned(),
            None => kind.chars().take(20).collect(),
        };
        let order = value("fortran_order")?;
        let is_fortran = order.starts_with("True");
        if !is_fortran && !order.starts_with("False") {
            return None;
        }
        let shape = value("shape")?.strip_prefix('(')?.split(')').next()?;
        let sizes = shape.split(',').map(str::trim).filter(|size| !size.is_empty());
        let shape = sizes.map(|size| size.parse().ok()).collect::<Option<Vec<u64>>>()?;
        Some(Self { kind, is_fortran, shape })
    }

    /// The texts of an array of one dimension, `<U12`: characters of four bytes, padded with zeros.
    fn names(&self, data: &[u8]) -> Value {
        let other = || Value::Other(format!("of the type {:?}", self.kind));
        let ([count], Some(width)) =
            (&self.shape[..], self.kind.strip_prefix("<U").and_then(|n| n.parse::<usize>().ok()))
        else {
            return other();
        };
        let bytes = width.saturating_mul(4);
        if bytes == 0 || data.len() != (*count as usize).saturating_mul(bytes) {
            return other();
        }
        let text = |name: &[u8]| -> String {
            let letters = name.as_chunks::<4>().0.iter().map(|letter| u32::from_le_bytes(*letter));
            letters.take_while(|letter| *letter != 0).map(|letter| char::from_u32(letter).unwrap_or('?')).collect()
        };
        Value::Names(data.chunks_exact(bytes).map(text).collect())
    }

    fn is_complex(&self) -> bool {
        matches!(self.kind.get(1..), Some("c8" | "c16"))
    }

    /// The width of an entry, for kinds that are numbers.
    fn width(&self) -> Option<usize> {
        match self.kind.get(1..)? {
            "b1" | "i1" | "u1" => Some(1),
            "i2" | "u2" => Some(2),
            "f4" | "i4" | "u4" => Some(4),
            "f8" | "i8" | "u8" | "c8" => Some(8),
            "c16" => Some(16),
            _ => None,
        }
    }

    fn numbers(&self, data: &[u8]) -> Vec<f64> {
        let is_reversed = self.kind.starts_with('>');
        macro_rules! each {
            ($number:ty, $width:literal, $as:expr) => {{
                let number = |bytes: &[u8; $width]| {
                    let mut bytes = *bytes;
                    if is_reversed {
                        bytes.reverse();
                    }
                    $as(<$number>::from_le_bytes(bytes))
                };
                data.as_chunks::<$width>().0.iter().map(number).collect()
            }};
        }
        match self.kind.get(1..).unwrap_or_default() {
            "i1" => each!(i8, 1, f64::from),
            "b1" | "u1" => each!(u8, 1, f64::from),
            "i2" => each!(i16, 2, f64::from),
            "u2" => each!(u16, 2, f64::from),
            "i4" => each!(i32, 4, f64::from),
            "u4" => each!(u32, 4, f64::from),
            "f4" | "c8" => each!(f32, 4, f64::from),
            "f8" | "c16" => each!(f64, 8, f64::from),
            "i8" => each!(i64, 8, |x: i64| x as f64),
            _ => each!(u64, 8, |x: u64| x as f64),
        }
    }
}
