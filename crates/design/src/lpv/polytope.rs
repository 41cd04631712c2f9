//! The polytope of an enclosure: finitely many pairs `(A_k, C_k)` whose convex hull contains every pair of mean
//! Jacobians.

use core::fmt;

use luenberger_proof::certificate::Vertex as Corner;
use luenberger_proof::{Interval, Matrix, ProofError};
use nalgebra::DMatrix;

use super::error::{LpvError, VaryingEntries};
use crate::enclosure::{Entry, JacobianEnclosure};
use luenberger_proof::wording::significant;

/// Maximal number of varying entries: 2^12 = 4096 vertices, each with its own proof.
pub const MAX_VARYING: usize = 12;

/// A corner of the polytope.
#[derive(Debug, Clone, PartialEq)]
pub struct Vertex {
    /// `A_k`, n x n.
    pub a: DMatrix<f64>,
    /// `C_k`, p x n.
    pub c: DMatrix<f64>,
    /// The varying entries, at the end where this vertex has them.
    pub at: Vec<(Entry, f64)>,
}

impl fmt::Display for Vertex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ends: Vec<String> =
            self.at.iter().map(|(entry, end)| format!("{entry} = {}", significant(*end, 6))).collect();
        f.write_str(&if ends.is_empty() { "the only vertex".to_owned() } else { ends.join(", ") })
    }
}

/// The convex hull of the pairs `(A_k, C_k)`, with the enclosure that it covers.
#[derive(Debug, Clone, PartialEq)]
pub struct Polytope {
    /// Every mean Jacobian lies in these intervals.
    pub enclosure: JacobianEnclosure,
    /// The entries that vary; there are 2^(their number) vertices.
    pub varying: VaryingEntries,
    /// The vertices.
    pub vertices: Vec<Vertex>,
}

impl Polytope {
    /// The vertices of the interval hull: every varying entry at either of its ends.
    ///
    /// # Errors
    /// [`LpvError::TooManyVertices`] when more than [`MAX_VARYING`] entries vary.
    pub fn new(enclosure: JacobianEnclosure) -> Result<Self, LpvError> {
        let varying: Vec<Entry> = enclosure.varying().collect();
        if varying.len() > MAX_VARYING {
            return Err(LpvError::TooManyVertices {
                varying: varying.len(),
                allowed: MAX_VARYING,
                entries: VaryingEntries(varying),
            });
        }
        let (a, c) = (floats(&enclosure.a), floats(&enclosure.c));
        let vertices = (0..1usize << varying.len())
            .map(|which| {
                let end = |(bit, entry): (usize, &Entry)| {
                    let interval = enclosure.interval(*entry);
                    (*entry, if which >> bit & 1 == 1 { interval.hi() } else { interval.lo() })
                };
                let at: Vec<(Entry, f64)> = varying.iter().enumerate().map(end).collect();
                let mut vertex = Vertex { a: a.clone(), c: c.clone(), at };
                for (entry, end) in &vertex.at {
                    let matrix = if entry.of_output { &mut vertex.c } else { &mut vertex.a };
                    matrix[(entry.row, entry.column)] = *end;
                }
                vertex
            })
            .collect();
        Ok(Self { enclosure, varying: VaryingEntries(varying), vertices })
    }

    /// The pairs around vertex k: the varying entries at its ends, the others in their whole interval. The hull of
    /// these boxes over all k is the enclosure.
    pub(crate) fn around(&self, k: usize) -> (Matrix<Interval>, Matrix<Interval>) {
        let (mut a, mut c) = (self.enclosure.a.clone(), self.enclosure.c.clone());
        for (entry, end) in &self.vertices[k].at {
            let matrix = if entry.of_output { &mut c } else { &mut a };
            matrix[(entry.row, entry.column)] = Interval::of(*end);
        }
        (a, c)
    }

    /// The boxes [`around`](Self::around) all vertices, for a theorem.
    pub(super) fn corners(&self) -> Result<Vec<Corner>, ProofError> {
        let corner = |k| {
            let (a, c) = self.around(k);
            Corner::within(&a, &c)
        };
        (0..self.vertices.len()).map(corner).collect()
    }

    /// A pair in the enclosure: its middle, with 0 wherever a varying entry may vanish if asked so.
    pub(crate) fn inner(&self, vanishing: bool) -> (DMatrix<f64>, DMatrix<f64>) {
        let middle = |interval: &Interval| {
            if vanishing && interval.contains(0.0) { 0.0 } else { interval.midpoint() }
        };
        let of = |m: &Matrix<Interval>| DMatrix::from_fn(m.rows(), m.cols(), |i, j| middle(&m[(i, j)]));
        (of(&self.enclosure.a), of(&self.enclosure.c))
    }
}

fn floats(m: &Matrix<Interval>) -> DMatrix<f64> {
    DMatrix::from_fn(m.rows(), m.cols(), |i, j| m[(i, j)].midpoint())
}
