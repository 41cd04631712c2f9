//! Constraints for which (D) has no interior: `tr(F_k Y) = 0` with `F_k >= 0` confines Y to a face of the cone.
//! Then `Y > 0` is impossible, and a feasible Y cannot be verified. Graph partitioning (`e e'`) and quadratic
//! assignment problems are of this kind.
//!
//! No claim depends on this; it only avoids a futile search.

use faer::Mat;
use luenberger_proof::Ring;
use luenberger_proof::semidefinite::{Entry, Program};

use super::dual::middle;
use crate::sequential::Cholesky;

/// Whether a constraint with zero on the right has a matrix that is semidefinite, to rounding. Cost: a Cholesky
/// factorisation of its rows that are not zero.
pub fn confines_dual(program: &Program) -> bool {
    program.costs().iter().enumerate().any(|(k, c)| {
        let entries = program.matrix(k + 1);
        c.is_zero() && !entries.is_empty() && (is_semidefinite(entries, 1.0) || is_semidefinite(entries, -1.0))
    })
}

fn is_semidefinite(entries: &[Entry], sign: f64) -> bool {
    let place = |row: usize, e: &Entry| (e.block, row);
    let mut rows: Vec<(usize, usize)> = entries.iter().filter(|e| e.row == e.column).map(|e| place(e.row, e)).collect();
    rows.sort_unstable();
    let find = |at: (usize, usize)| rows.binary_search(&at).ok();
    let mut matrix: Mat<f64> = Mat::zeros(rows.len(), rows.len());
    for e in entries {
        // An entry whose row has nothing on the diagonal makes the matrix indefinite.
        let (Some(i), Some(j)) = (find(place(e.row, e)), find(place(e.column, e))) else { return false };
        let value = sign * middle(e);
        if i == j && value <= 0.0 {
            return false;
        }
        matrix[(j.max(i), j.min(i))] = value;
    }
    let n = rows.len();
    let trace: f64 = (0..n).map(|i| matrix[(i, i)]).sum();
    for i in 0..n {
        // What the factorisation's own rounding may take.
        matrix[(i, i)] += 4.0 * n as f64 * f64::EPSILON * trace;
    }
    Cholesky::of(&matrix).is_some()
}
