//! Separation of a linear matrix equation: an estimate of `1 / ||inverse operator||_1` (Hager, SIAM J. Sci. Stat. Comput. 5,
//! 1984; Higham, ACM TOMS 14, 1988; LAPACK dlacn2; used for matrix equations by SLICOT SB03QD).
//!
//! The norm is found by a few solutions of the equation and of its adjoint, at most eleven. It is a lower bound, so the separation is
//! an upper bound; it is rarely off by more than a factor of three.

use crate::LinalgError;
use crate::argument::unit_scale;
use nalgebra::{Complex, DMatrix};

/// The estimate for the operator on `rows x cols` matrices that `solve` inverts in place, `adjoint` inverting its adjoint.
/// Zero if a solution overflows, infinity if the operator is empty.
pub(crate) fn separation(
    rows: usize,
    cols: usize,
    solve: impl Fn(&mut DMatrix<f64>),
    adjoint: impl Fn(&mut DMatrix<f64>),
) -> f64 {
    let order = rows * cols;
    if order == 0 {
        return f64::INFINITY;
    }
    let norm = |m: &DMatrix<f64>| m.iter().map(|e| e.abs()).sum::<f64>();
    let signs = |m: &DMatrix<f64>| m.map(|e| if e >= 0.0 { 1.0 } else { -1.0 });

    let mut x = DMatrix::from_element(rows, cols, 1.0 / order as f64);
    solve(&mut x);
    let mut estimate = norm(&x);
    let mut sign = signs(&x);
    let mut gradient = sign.clone();
    adjoint(&mut gradient);
    for _ in 0..5 {
        let steepest = gradient.iamax_full();
        let mut unit = DMatrix::zeros(rows, cols);
        unit[steepest] = 1.0;
        solve(&mut unit);
        let found = norm(&unit);
        let next = signs(&unit);
        if found.is_nan() || found <= estimate {
            break;
        }
        estimate = found;
        if next == sign {
            break;
        }
        sign = next;
        gradient.copy_from(&sign);
        adjoint(&mut gradient);
        if gradient.iamax_full() == steepest {
            break;
        }
    }
    // A vector on which the iteration above is known to be blind.
    let spread = (order.max(2) - 1) as f64;
    let mut k = 0.0;
    let mut alternating = DMatrix::zeros(rows, cols);
    for e in alternating.iter_mut() {
        *e = (1.0 + k / spread) * if k % 2.0 == 0.0 { 1.0 } else { -1.0 };
        k += 1.0;
    }
    solve(&mut alternating);
    let other = 2.0 * norm(&alternating) / (3.0 * order as f64);
    let norm = if estimate.is_finite() && other.is_finite() { estimate.max(other) } else { f64::INFINITY };
    1.0 / norm
}

/// The pair of eigenvalues with the smallest `gap`, as the error that says the equation is nearly singular.
pub(crate) fn nearly_singular(
    equation: &'static str,
    first: &[Complex<f64>],
    second: &[Complex<f64>],
    separation: f64,
    gap: impl Fn(Complex<f64>, Complex<f64>) -> f64,
) -> LinalgError {
    let pairs = first.iter().flat_map(|&x| second.iter().map(move |&y| (x, y)));
    let closest = pairs.min_by(|x, y| gap(x.0, x.1).total_cmp(&gap(y.0, y.1)));
    match closest {
        Some((first, second)) => {
            LinalgError::NearlySingular { equation, first, second, gap: gap(first, second), separation }
        }
        None => LinalgError::Empty { what: equation },
    }
}

/// `m := m * up / down` without an intermediate overflow or underflow that the result does not have.
pub(crate) fn rescale(m: &mut DMatrix<f64>, up: f64, down: f64) {
    if (up >= 1.0) == (down >= 1.0) {
        *m *= up / down;
    } else {
        *m *= up;
        *m /= down;
    }
}

/// The Frobenius norm, also where the squares of the entries leave the range.
pub(crate) fn norm(m: &DMatrix<f64>) -> f64 {
    let scale = unit_scale(m);
    (m * scale).norm() / scale
}

/// A bound of the error relative to the solution found, as one relative to the exact solution. From one on, not a digit is known: infinite.
pub(crate) fn of_exact(bound: f64) -> f64 {
    if bound < 1.0 { bound / (1.0 - bound) } else { f64::INFINITY }
}

/// `norm / scale`, and zero where both vanish: the residual of an equation whose terms all are zero.
pub(crate) fn relative(norm: f64, scale: f64) -> f64 {
    if norm == 0.0 { 0.0 } else { norm / scale }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn the_estimate_is_exact_for_diagonal_operators_and_never_below_the_separation() {
        let d = dmatrix![4.0, -2.0; 0.5, 8.0];
        let solve = |x: &mut DMatrix<f64>| x.component_div_assign(&d);
        assert_eq!(separation(2, 2, solve, solve), 0.5);
        // A full operator: X -> X M, whose inverse has the 1-norm of M^-1 transposed.
        let m = dmatrix![1.0, 2.0, 0.0; 0.0, 1.0, 3.0; -1.0, 0.0, 2.0];
        let inverse = m.clone().try_inverse().unwrap();
        let norm = inverse.row_iter().map(|r| r.lp_norm(1)).fold(0.0_f64, f64::max);
        let found = separation(2, 3, |x| *x = &*x * &inverse, |x| *x = &*x * inverse.transpose());
        assert!(found >= 1.0 / norm * (1.0 - 1e-14) && found <= 3.0 / norm, "{found} {}", 1.0 / norm);
    }
}
