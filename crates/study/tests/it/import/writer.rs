//! Writes the files that the readers are tested with: MATLAB's version 5 and numpy's npz.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use nalgebra::DMatrix;
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// How a MATLAB file is written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mat {
    pub(super) is_little: bool,
    pub(super) is_compressed: bool,
}

impl Mat {
    pub(super) fn u32(self, x: u32) -> [u8; 4] {
        if self.is_little { x.to_le_bytes() } else { x.to_be_bytes() }
    }

    fn f64(self, x: f64) -> [u8; 8] {
        if self.is_little { x.to_le_bytes() } else { x.to_be_bytes() }
    }

    fn i16(self, x: i16) -> [u8; 2] {
        if self.is_little { x.to_le_bytes() } else { x.to_be_bytes() }
    }

    /// A file of these variables.
    pub(super) fn file(self, variables: &[Vec<u8>]) -> Vec<u8> {
        let mut file = vec![b' '; 124];
        file[..19].copy_from_slice(b"MATLAB 5.0 MAT-file");
        file.extend(if self.is_little { [0, 1, b'I', b'M'] } else { [1, 0, b'M', b'I'] });
        for variable in variables {
            if self.is_compressed {
                let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
                encoder.write_all(variable).unwrap();
                let data = encoder.finish().unwrap();
                file.extend(self.u32(15));
                file.extend(self.u32(data.len() as u32));
                file.extend(data);
            } else {
                file.extend(variable);
            }
        }
        file
    }

    /// An element: small data in the tag, other data after it, padded.
    pub(super) fn element(self, kind: u32, data: &[u8]) -> Vec<u8> {
        let mut element = Vec::new();
        if !data.is_empty() && data.len() <= 4 {
            element.extend(self.u32(((data.len() as u32) << 16) | kind));
            element.extend(data);
            element.resize(8, 0);
        } else {
            element.extend(self.u32(kind));
            element.extend(self.u32(data.len() as u32));
            element.extend(data);
            element.resize(element.len().next_multiple_of(8), 0);
        }
        element
    }

    /// Flags, dimensions and name of a variable, then its parts.
    pub(super) fn array(self, flags: u32, dimensions: &[u32], name: &str, parts: &[Vec<u8>]) -> Vec<u8> {
        let mut data = self.element(6, &[self.u32(flags), self.u32(0)].concat());
        data.extend(self.element(5, &dimensions.iter().flat_map(|size| self.u32(*size)).collect::<Vec<_>>()));
        data.extend(self.element(1, name.as_bytes()));
        data.extend(parts.concat());
        self.element(14, &data)
    }

    /// Numbers as doubles, or in two bytes where all are such integers, as MATLAB does.
    fn numbers(self, values: &[f64]) -> Vec<u8> {
        if values.iter().all(|x| x.fract() == 0.0 && x.abs() < 32768.0) {
            self.element(3, &values.iter().flat_map(|x| self.i16(*x as i16)).collect::<Vec<_>>())
        } else {
            self.element(9, &values.iter().flat_map(|x| self.f64(*x)).collect::<Vec<_>>())
        }
    }

    pub(super) fn full(self, name: &str, m: &DMatrix<f64>) -> Vec<u8> {
        self.array(6, &[m.nrows() as u32, m.ncols() as u32], name, &[self.numbers(m.as_slice())])
    }

    /// A text without a name, in characters of two bytes.
    pub(super) fn text(self, text: &str) -> Vec<u8> {
        let units: Vec<u8> = text.encode_utf16().flat_map(|unit| self.i16(unit.cast_signed())).collect();
        self.array(4, &[1, text.encode_utf16().count() as u32], "", &[self.element(4, &units)])
    }

    pub(super) fn sparse(self, name: &str, m: &DMatrix<f64>) -> Vec<u8> {
        let (mut rows, mut starts, mut values) = (Vec::new(), vec![0], Vec::new());
        for column in m.column_iter() {
            for (row, x) in column.iter().enumerate().filter(|(_, x)| **x != 0.0) {
                rows.push(row as u32);
                values.push(*x);
            }
            starts.push(rows.len() as u32);
        }
        let counts = |list: &[u32]| self.element(5, &list.iter().flat_map(|x| self.u32(*x)).collect::<Vec<_>>());
        let parts = [counts(&rows), counts(&starts), self.numbers(&values)];
        self.array(5, &[m.nrows() as u32, m.ncols() as u32], name, &parts)
    }

    /// A structure of fields that are variables without a name.
    pub(super) fn structure(self, name: &str, fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let mut names = Vec::new();
        for (field, _) in fields {
            let mut padded = field.as_bytes().to_vec();
            padded.resize(32, 0);
            names.extend(padded);
        }
        let mut parts = vec![self.element(5, &self.u32(32)), self.element(1, &names)];
        parts.extend(fields.iter().map(|field| field.1.clone()));
        self.array(2, &[1, 1], name, &parts)
    }
}

/// An npy file with the numbers of `m` as doubles.
pub(super) fn npy(m: &DMatrix<f64>, is_fortran: bool, kind: &str) -> Vec<u8> {
    let order = if is_fortran { "True" } else { "False" };
    let shape = format!("({}, {})", m.nrows(), m.ncols());
    let values: Vec<f64> =
        if is_fortran { m.iter().copied().collect() } else { m.transpose().iter().copied().collect() };
    let numbers: Vec<u8> =
        values.iter().flat_map(|x| if kind.starts_with('>') { x.to_be_bytes() } else { x.to_le_bytes() }).collect();
    npy_of(&format!("{{'descr': '{kind}', 'fortran_order': {order}, 'shape': {shape}, }}"), &numbers)
}

/// An npy file with any header and data.
pub(super) fn npy_of(header: &str, numbers: &[u8]) -> Vec<u8> {
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.as_bytes());
    file.extend(numbers);
    file
}

/// An archive of such files.
pub(super) fn npz(arrays: &[(&str, Vec<u8>)], is_compressed: bool) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let method = if is_compressed { CompressionMethod::Deflated } else { CompressionMethod::Stored };
    // As numpy does: sizes of 64 bits, whatever the size.
    let options = SimpleFileOptions::default().compression_method(method).large_file(true);
    for (name, data) in arrays {
        archive.start_file(format!("{name}.npy"), options).unwrap();
        archive.write_all(data).unwrap();
    }
    archive.finish().unwrap().into_inner()
}
