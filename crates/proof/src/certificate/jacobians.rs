//! Whether the data of a theorem contain every Jacobian of an enclosure.
//!
//! The theorems about mean Jacobians hold for a set of pairs (A, C): the hull of boxes, or A with the slopes of its
//! sectors. That the mean Jacobians of a plant lie in this set is their hypothesis. Where an enclosure bounds them
//! entry by entry, what is decided here is whether the set contains all of these bounds. The answer is yes only where
//! that is certain: bounds of the data are rounded inwards, and sums of slopes are exact.
//!
//! *Hulls.* Let S be the entries whose bounds every box of the data contains, V the others. If for each choice of one
//! end of the bounds for every entry of V some box of the data has these ends, the hull contains the enclosure: with
//! the entries of S fixed, these points are the corners of the remaining entries.
//!
//! *Sectors.* A sector `[low, high]` whose G and H have one entry that is not 0 each adds `g h [low, high]` to one
//! entry of A. Another sector counts as no slope, which has to be one of its own: `low <= 0 <= high`.

use super::theorem::{SectorConvergence, SectorTerm, Theorem, Vertex};
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::number::Datum;
use crate::ring::Ring;

/// How many corners of an enclosure are looked for at most; where there are more, nothing is certain.
const MOST_CORNERS: usize = 1 << 16;

impl Theorem {
    /// Whether every pair (A, C) between these bounds, n x n and p x n, is among those that the theorem is about: the
    /// convex hull of the vertices of a polytope of Jacobians, or A with all slopes within its sectors. `false` where
    /// that is not certain, and for theorems of another kind.
    ///
    /// ```
    /// use luenberger_proof::certificate::{JacobianPolytope, Theorem, Vertex};
    /// use luenberger_proof::{Interval, Matrix};
    /// let one = |x: f64| Matrix::from_rows([[x]]);
    /// let between = |lo, hi| Matrix::from_rows([[Interval::new(lo, hi).expect("in order")]]);
    /// let vertices = vec![Vertex::exactly(&one(-2.0), &one(1.0))?, Vertex::exactly(&one(-1.0), &one(1.0))?];
    /// let theorem = Theorem::from(JacobianPolytope { vertices, l: one(0.0), p: one(1.0), rate: 0.5 });
    /// assert!(theorem.contains_jacobians(&between(-2.0, -1.0), &between(1.0, 1.0)));
    /// assert!(!theorem.contains_jacobians(&between(-2.0, (-1.0f64).next_up()), &between(1.0, 1.0)));
    /// # Ok::<(), luenberger_proof::ProofError>(())
    /// ```
    pub fn contains_jacobians(&self, a: &Matrix<Interval>, c: &Matrix<Interval>) -> bool {
        match self {
            Self::JacobianPolytope(theorem) => hull_contains(&theorem.vertices, a, c),
            Self::DiscreteJacobianPolytope(theorem) => hull_contains(&theorem.vertices, a, c),
            Self::SectorConvergence(theorem) => sectors_contain(theorem, a, c),
            _ => false,
        }
    }
}

/// Bounds of numbers that all belong to a datum; empty, the lower above the upper, for a number that binary64 has not.
fn inner(datum: &Datum) -> (f64, f64) {
    let (lo, hi) = match datum {
        Datum::Number(x) => (x, x),
        Datum::Between(lo, hi) => (lo, hi),
    };
    (lo.enclosure().hi(), hi.enclosure().lo())
}

/// Whether every matrix between these bounds is among those that the data stand for.
pub(super) fn data_contain(data: &Matrix<Datum>, bounds: &Matrix<Interval>) -> bool {
    data.shape() == bounds.shape()
        && data.as_slice().iter().zip(bounds.as_slice()).all(|(datum, bounds)| {
            let (lo, hi) = inner(datum);
            lo <= bounds.lo() && bounds.hi() <= hi
        })
}

/// Which ends of one entry of the enclosure the boxes of the data have, box by box: `[lower, upper]`.
type Ends = Vec<[bool; 2]>;

fn hull_contains(vertices: &[Vertex], a: &Matrix<Interval>, c: &Matrix<Interval>) -> bool {
    if !vertices.iter().all(|vertex| vertex.a.shape() == a.shape() && vertex.c.shape() == c.shape()) {
        return false;
    }
    let bounds: Vec<&Interval> = a.as_slice().iter().chain(c.as_slice()).collect();
    // Boxes without either end of an entry have no corner of the enclosure.
    let boxes: Vec<Ends> = vertices
        .iter()
        .map(|vertex| {
            let data = vertex.a.as_slice().iter().chain(vertex.c.as_slice());
            let ends = data.zip(&bounds).map(|(datum, bounds)| {
                let (lo, hi) = inner(datum);
                [bounds.lo(), bounds.hi()].map(|end| lo <= end && end <= hi)
            });
            ends.collect()
        })
        .filter(|ends: &Ends| ends.iter().all(|[lower, upper]| *lower || *upper))
        .collect();
    let varying: Vec<Ends> = (0..bounds.len())
        .map(|entry| boxes.iter().map(|ends| ends[entry]).collect())
        .filter(|ends: &Ends| ends.iter().any(|ends| *ends != [true, true]))
        .collect();
    has_corners(&(0..boxes.len()).collect::<Vec<_>>(), &varying, &mut 0)
}

/// Whether for each choice of ends of the entries some of these boxes has them.
fn has_corners(boxes: &[usize], entries: &[Ends], found: &mut usize) -> bool {
    if boxes.is_empty() || *found >= MOST_CORNERS {
        return false;
    }
    let Some((ends, others)) = entries.split_first() else {
        *found += 1;
        return true;
    };
    [0, 1].into_iter().all(|end| {
        let with: Vec<usize> = boxes.iter().copied().filter(|&k| ends[k][end]).collect();
        has_corners(&with, others, found)
    })
}

fn sectors_contain(theorem: &SectorConvergence, a: &Matrix<Interval>, c: &Matrix<Interval>) -> bool {
    theorem.a.shape() == a.shape() && data_contain(&theorem.c, c) && slopes_contain(theorem, a).unwrap_or(false)
}

/// Entry by entry; none for numbers that are not finite.
fn slopes_contain(theorem: &SectorConvergence, a: &Matrix<Interval>) -> Option<bool> {
    let n = a.cols();
    let ends = theorem.a.as_slice().iter().map(|datum| {
        let (lo, hi) = inner(datum);
        Some([Exact::from_f64(lo)?, Exact::from_f64(hi)?])
    });
    let mut ends: Vec<[Exact; 2]> = ends.collect::<Option<_>>()?;
    for term in &theorem.terms {
        let Some((row, column, factor)) = slope_of_one_entry(term) else {
            if term.low <= 0.0 && term.high >= 0.0 {
                continue;
            }
            return Some(false);
        };
        let mut slopes = [factor.mul(&Exact::from_f64(term.low)?), factor.mul(&Exact::from_f64(term.high)?)];
        slopes.sort();
        let [lower, upper] = ends.get_mut(row * n + column)?;
        (*lower, *upper) = (lower.add(&slopes[0]), upper.add(&slopes[1]));
    }
    let mut contained = true;
    for ([lower, upper], bounds) in ends.iter().zip(a.as_slice()) {
        contained &= *lower <= Exact::from_f64(bounds.lo())? && Exact::from_f64(bounds.hi())? <= *upper;
    }
    Some(contained)
}

/// The entry of `G s H` that is not 0, with its factor of s, for a column G and a row H of one such entry each.
fn slope_of_one_entry(term: &SectorTerm) -> Option<(usize, usize, Exact)> {
    let one = |m: &Matrix<f64>| {
        let mut entries = m.as_slice().iter().enumerate().filter(|(_, x)| **x != 0.0);
        let (k, x) = entries.next()?;
        entries.next().is_none().then_some((k, Exact::from_f64(*x)?))
    };
    if term.g.cols() != 1 || term.h.rows() != 1 {
        return None;
    }
    let ((row, g), (column, h)) = (one(&term.g)?, one(&term.h)?);
    Some((row, column, g.mul(&h)))
}
