//! Observability of a linear plant as text: every mode with its margin, and the unobservable directions.

use core::fmt;

use luenberger_linalg::{Mode, Observability};
use luenberger_proof::wording::{complex, significant};
use nalgebra::Complex;

use super::words::direction_in_words;
use crate::number::short;

/// The report on a linear pair `(A, C)` for an engineer: rank, the margin of every mode, hidden directions.
///
/// ```
/// use luenberger_design::nonlinear_observability::InWords;
/// use luenberger_linalg::observability;
/// use nalgebra::dmatrix;
///
/// // Two equal carts on springs, seen by the distance between them.
/// let a = dmatrix![0.0, 0.0, 1.0, 0.0; 0.0, 0.0, 0.0, 1.0; -2.0, 1.0, 0.0, 0.0; 1.0, -2.0, 0.0, 0.0];
/// let seen = observability(&a, &dmatrix![1.0, -1.0, 0.0, 0.0])?;
/// let text = InWords { seen: &seen, names: &["p1", "p2", "v1", "v2"] }.to_string();
/// assert!(text.starts_with("rank 2 of 4"));
/// assert!(text.contains("p1 + p2 is unobservable") && text.ends_with("is unobservable"), "{text}");
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct InWords<'a> {
    /// The result of [`observability`](luenberger_linalg::observability()).
    pub seen: &'a Observability,
    /// Names of the states; missing ones are `x1`, `x2`, ...
    pub names: &'a [&'a str],
}

impl InWords<'_> {
    /// The real directions that a mode spans, in units of the states in which the pair was judged.
    fn directions(&self, mode: &Mode) -> Vec<String> {
        let in_units = |part: fn(&Complex<f64>) -> f64| -> Vec<f64> {
            mode.direction.iter().zip(&self.seen.units).map(|(entry, unit)| part(entry) / unit).collect()
        };
        let size = |v: &[f64]| v.iter().fold(0.0f64, |size, x| size.max(x.abs()));
        let (real, imaginary) = (in_units(|z| z.re), in_units(|z| z.im));
        let mut directions = vec![direction_in_words(&real, self.names)];
        // Nothing but rounding below a millionth.
        if size(&imaginary) > 1e-6 * size(&real) {
            directions.push(direction_in_words(&imaginary, self.names));
        }
        directions
    }
}

impl fmt::Display for InWords<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Observability { order, rank, modes, unobservable, subspace, tolerance, units } = self.seen;
        writeln!(f, "rank {rank} of {order}, margins at or below {} count as zero", significant(*tolerance, 2))?;
        for mode in modes {
            let hidden = mode.margin <= *tolerance;
            let directions = self.directions(mode).join(" and ");
            let word = if hidden { "hidden" } else { "seen" };
            writeln!(
                f,
                "mode {}: margin {}, {word}, least along {directions}",
                complex([mode.eigenvalue.re, mode.eigenvalue.im], 4),
                short(mode.margin)
            )?;
        }
        if rank == order {
            return f.write_str("observable");
        }
        // The reduced echelon form of the subspace has the fewest words.
        let mut first = true;
        for direction in echelon(subspace, units) {
            if !first {
                f.write_str("\n")?;
            }
            first = false;
            write!(f, "{} is unobservable", direction_in_words(&direction, self.names))?;
        }
        // An eigenvalue on the imaginary axis to rounding is not stable.
        let largest = modes.iter().map(|mode| mode.eigenvalue.norm()).fold(0.0, f64::max);
        if unobservable.iter().all(|mode| mode.eigenvalue.re < -tolerance * largest) {
            f.write_str("\nthe unobservable part is stable in continuous time")?;
        }
        Ok(())
    }
}

/// A basis of the span of the columns, in which each vector has a one where the others have zeros; in the units.
pub(super) fn echelon(columns: &nalgebra::DMatrix<f64>, units: &[f64]) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> =
        columns.column_iter().map(|column| column.iter().zip(units).map(|(x, unit)| x / unit).collect()).collect();
    let mut used: Vec<usize> = Vec::new();
    for k in 0..rows.len() {
        let pivot = (0..units.len())
            .filter(|j| !used.contains(j))
            .max_by(|&i, &j| rows[k][i].abs().total_cmp(&rows[k][j].abs()).then(j.cmp(&i)));
        let Some(pivot) = pivot.filter(|&pivot| rows[k][pivot] != 0.0) else { continue };
        used.push(pivot);
        let scale = rows[k][pivot];
        let row: Vec<f64> = rows[k].iter().map(|x| x / scale).collect();
        for (i, other) in rows.iter_mut().enumerate() {
            let factor = other[pivot];
            if i != k {
                for (x, y) in other.iter_mut().zip(&row) {
                    *x -= factor * y;
                }
            }
        }
        rows[k] = row;
    }
    rows
}
