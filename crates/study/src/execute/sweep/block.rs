//! The runs of a block, and their form on disk.
//!
//! A block is an npz archive: the file `block.json` with the [`Header`], an array for each column of scores, and at the
//! end, as the comment of the archive, the SHA-256 of all bytes before it. `numpy.load` reads it as it is. A settling
//! time of infinity is a run that does not settle; a run that ended early has no scores, which are NaN.

use std::io::{Cursor, Read};

use luenberger_figures::npz;
use serde::{Deserialize, Serialize};
use zip::ZipArchive;

use super::plan::FORMAT;
use crate::digest;
use crate::error::sweep::Fault;
use crate::execute::excursion::FirstExit;

/// The name of the header in the archive.
const HEADER: &str = "block.json";

/// Columns before those of the scores: the number of the run in its ensemble, whether it finished, and whether it left
/// the region of the design.
const OWN: [&str; 3] = ["run", "finished", "left_region"];

/// Bytes of the digest.
const SUM: usize = 64;

/// What a block is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Header {
    /// The version of the format.
    pub(super) format: u32,
    /// The digest of the plan.
    pub(super) plan: String,
    /// The number of the block, from 0.
    pub(super) block: u64,
    /// The number of its first run in the ensemble.
    pub(super) first: u64,
    /// The number of its runs; none if there is no design.
    pub(super) count: u64,
    /// The observer, with the value of the parameter.
    pub(super) observer: String,
    pub(super) parameter: String,
    pub(super) value: f64,
    /// Why there are no runs, if there are none.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub(super) failure: Option<String>,
    /// Runs that ended early.
    pub(super) ended: Vec<Ended>,
    /// The first run that left the region of the design.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub(super) left: Option<FirstExit>,
}

/// A run that ended early.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Ended {
    /// Its place in the block.
    pub(super) index: usize,
    pub(super) why: String,
}

/// The runs of a block.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Block {
    pub(super) header: Header,
    /// Whether each run left the region of the design.
    pub(super) left: Vec<bool>,
    /// For each score the values of the runs.
    pub(super) scores: Vec<Vec<f64>>,
}

impl Block {
    /// Whether a run of the block finished, by its place.
    pub(super) fn ended(&self, index: usize) -> Option<&str> {
        let ended = &self.header.ended;
        let at = ended.binary_search_by_key(&index, |ended| ended.index).ok()?;
        Some(&ended[at].why)
    }

    /// The values of those runs that finished.
    pub(super) fn finished(&self, values: &[f64]) -> Vec<f64> {
        values.iter().enumerate().filter(|(index, _)| self.ended(*index).is_none()).map(|(_, x)| *x).collect()
    }

    /// The bytes of the file; the columns have these names.
    pub(super) fn encode(&self, names: &[String]) -> Result<Vec<u8>, zip::result::ZipError> {
        let json = serde_json::to_string(&self.header).map_err(std::io::Error::from)?;
        let (first, count) = (self.header.first, self.header.count as usize);
        let truth = |is_true: bool| f64::from(u8::from(is_true));
        let own = [
            (0..count).map(|index| (first + index as u64) as f64).collect(),
            (0..count).map(|index| truth(self.ended(index).is_none())).collect(),
            self.left.iter().map(|left| truth(*left)).collect::<Vec<f64>>(),
        ];
        let own = OWN.into_iter().zip(own.iter().map(Vec::as_slice));
        let scores = names.iter().map(String::as_str).zip(self.scores.iter().map(Vec::as_slice));
        let mut bytes = Cursor::new(Vec::new());
        npz::write(&mut bytes, own.chain(scores), &[(HEADER, &json)])?;
        let mut bytes = bytes.into_inner();
        // The archive ends with the length of its comment.
        let end = bytes.len() - 2;
        bytes.splice(end.., (SUM as u16).to_le_bytes());
        let sum = digest::sha256(&bytes);
        bytes.extend(sum.as_bytes());
        Ok(bytes)
    }

    /// The block of this number and plan in a file.
    pub(super) fn decode(bytes: &[u8], block: u64, plan: &str, names: &[String]) -> Result<Self, Fault> {
        let (content, sum) = bytes.len().checked_sub(SUM).map(|end| bytes.split_at(end)).ok_or(Fault::Truncated)?;
        if !sum.iter().all(|byte| byte.is_ascii_digit() || (b'a'..=b'f').contains(byte)) {
            return Err(Fault::Truncated);
        }
        if digest::sha256(content).as_bytes() != sum {
            return Err(Fault::Damaged);
        }
        // With the right checksum it is what somebody has written: if it is not understood, it is of another kind.
        let read = Self::content(bytes, names).ok_or(Fault::Foreign)?;
        match &read.header {
            header if header.plan != plan || header.format != FORMAT => Err(Fault::Foreign),
            header if header.block != block => Err(Fault::Other { block: header.block }),
            _ => Ok(read),
        }
    }

    fn content(bytes: &[u8], names: &[String]) -> Option<Self> {
        let mut archive = ZipArchive::new(Cursor::new(bytes)).ok()?;
        let mut member = |name: &str| {
            let mut content = Vec::new();
            archive.by_name(name).ok()?.read_to_end(&mut content).ok()?;
            Some(content)
        };
        let header: Header = serde_json::from_slice(&member(HEADER)?).ok()?;
        let mut column = |name: &str| {
            let values = npz::numbers(&member(&format!("{name}.npy"))?)?;
            (values.len() as u64 == header.count).then_some(values)
        };
        let left = column(OWN[2])?.into_iter().map(|left| left != 0.0).collect();
        let scores = names.iter().map(|name| column(name)).collect::<Option<_>>()?;
        Some(Self { header, left, scores })
    }
}
