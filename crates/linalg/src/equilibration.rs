//! A matrix with its rows and columns in units, powers of two, in which the largest entry of each is about one.
//!
//! Whether `M x = b` has one solution does not depend on the units of the equations and of the unknowns; the condition
//! number does, and is near its least value here (van der Sluis, Numer. Math. 14, 1969). Method: first the units that
//! fit the most entries ([`Balance::fitted`]), since largest entries of one say nothing of a diagonal beside couplings;
//! then Ruiz (RAL-TR-2001-034), each step of which divides by the roots of the largest entries, in logarithms.

use crate::balance::{Balance, are_near, sizes};
use crate::units::shift;
use nalgebra::DMatrix;

/// The distance of the logarithms from zero halves with each step: from 600, to less than one in ten.
const STEPS: usize = 12;

/// `R M C`.
pub(crate) struct Equilibrated {
    pub(crate) matrix: DMatrix<f64>,
    /// Powers of two of R.
    pub(crate) rows: Vec<i32>,
    /// Powers of two of C.
    pub(crate) columns: Vec<i32>,
}

impl Equilibrated {
    pub(crate) fn new(m: &DMatrix<f64>) -> Self {
        if are_near(m.iter()) && is_level(m) {
            // Only the size of the whole, half of it in each unit.
            let power = m.amax().log2().round() as i32;
            let (of_rows, of_columns) = (-(power / 2), power / 2 - power);
            let matrix = m.map(|x| shift(x, -power));
            return Self { matrix, rows: vec![of_rows; m.nrows()], columns: vec![of_columns; m.ncols()] };
        }
        let logarithms = sizes(m);
        // Unknowns drive equations.
        let (n, all) = (m.nrows(), m.nrows() + m.ncols());
        let mut both = DMatrix::zeros(all, all);
        both.view_mut((0, n), m.shape()).copy_from(m);
        let mut fitted = Balance::fitted(&both).apart().map_or_else(|| vec![0; all], |balance| balance.0);
        fitted[..n].iter_mut().for_each(|e| *e = -*e);
        let mut powers = fitted.into_iter().map(f64::from);
        let mut rows: Vec<f64> = powers.by_ref().take(n).collect();
        let mut columns: Vec<f64> = powers.collect();
        let half = |largest: f64| if largest.is_finite() { 0.5 * largest } else { 0.0 };
        for _ in 0..STEPS {
            let scaled = DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| logarithms[(i, j)] + rows[i] + columns[j]);
            for (row, entries) in rows.iter_mut().zip(scaled.row_iter()) {
                *row -= half(entries.max());
            }
            for (column, entries) in columns.iter_mut().zip(scaled.column_iter()) {
                *column -= half(entries.max());
            }
        }
        // Factors within four gain nothing, and cost something in error bounds.
        let powers = |list: Vec<f64>| {
            let (least, most) = list.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, u), &x| (l.min(x), u.max(x)));
            let common = (most - least <= 2.0).then_some(0.5 * (least + most));
            list.into_iter().map(|x| common.unwrap_or(x).round() as i32).collect::<Vec<_>>()
        };
        let (rows, columns) = (powers(rows), powers(columns));
        let matrix = DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| shift(m[(i, j)], rows[i] + columns[j]));
        Self { matrix, rows, columns }
    }

    /// `M^-1 = C (R M C)^-1 R`.
    pub(crate) fn inverse_back(&self, inverse: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(inverse.nrows(), inverse.ncols(), |i, j| {
            shift(inverse[(i, j)], self.columns[i] + self.rows[j])
        })
    }
}

/// Whether the largest entries of all rows and columns are within a factor of four of each other.
fn is_level(m: &DMatrix<f64>) -> bool {
    let largest = m.amax();
    let least = 0.25 * largest;
    let rows = m.nrows();
    let entries = m.as_slice();
    largest.is_normal()
        && m.column_iter().all(|column| column.iter().any(|x| x.abs() >= least))
        && (0..rows).all(|i| entries[i..].iter().step_by(rows).any(|x| x.abs() >= least))
}
