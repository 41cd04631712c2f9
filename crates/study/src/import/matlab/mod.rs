//! MATLAB's files of version 5, which `save` writes with `-v6` and (compressed) `-v7`.
//!
//! A header of 128 bytes, then elements: a tag (type, length) and data, padded to 8 bytes. A variable is an element of
//! the type `miMATRIX`, or one compressed by zlib. Numbers are stored in the smallest type that holds them, whatever
//! the class of the matrix; files of big-endian machines have every number reversed.
//!
//! Source: MathWorks, MAT-File Format (MATLAB documentation), chapter 1.

mod array;
mod element;
mod version_4;

use super::ImportError;
use super::variable::Variable;
use array::array;
use element::{COMPRESSED, Elements, MATRIX, Order};
use flate2::read::ZlibDecoder;
use std::io::Read;

pub(super) use version_4::{is_version_4, read as read_version_4};

const HEADER: usize = 128;

/// Whether the file begins as one of version 5: the version and the byte order at the end of the header.
pub(super) fn is_version_5(bytes: &[u8]) -> bool {
    matches!(bytes.get(124..HEADER), Some([0, 1, b'I', b'M'] | [1, 0, b'M', b'I']))
}

/// The variables of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Vec<Variable>, ImportError> {
    let order = if bytes.get(126) == Some(&b'I') { Order::Little } else { Order::Big };
    let mut variables = Vec::new();
    let mut inflated = super::INFLATED;
    let mut elements = Elements::new(bytes.get(HEADER..).unwrap_or_default(), HEADER, order);
    while let Some(element) = elements.next_unpadded_if_compressed()? {
        match element.kind {
            MATRIX => variables.extend(array(element.data, element.at, order)?),
            COMPRESSED => {
                let data = inflate(element.data, element.at, &mut inflated)?;
                let mut inner = Elements::inside(&data, element.at, order);
                if let Some(inner) = inner.next_element()?.filter(|inner| inner.kind == MATRIX) {
                    variables.extend(array(inner.data, element.at, order)?);
                }
            }
            // MATLAB writes nothing else at the top level; anything else is skipped.
            _ => {}
        }
    }
    Ok(variables)
}

/// The data of a compressed element; `left` is the remaining limit for all decompressed data.
fn inflate(data: &[u8], at: usize, left: &mut u64) -> Result<Vec<u8>, ImportError> {
    let mut inflated = Vec::new();
    // Reading to the end verifies zlib's checksum.
    let read = ZlibDecoder::new(data).take(*left + 1).read_to_end(&mut inflated);
    read.map_err(|_| ImportError::Damaged { what: "compressed data that cannot be inflated", at })?;
    *left = left.checked_sub(inflated.len() as u64).ok_or(ImportError::Inflated { limit: super::INFLATED })?;
    Ok(inflated)
}
