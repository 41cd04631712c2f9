//! Principal logarithm of a matrix.

use nalgebra::DMatrix;

use super::inverse;
use crate::argument::{RealMatrixView, owned, square};
use crate::discretize::expm;
use crate::spectrum::eigenvalues;
use crate::units::{Units, shift};
use crate::{LinalgError, Result};

/// Nodes of the Gauss-Legendre rule with 8 points on [-1, 1] and their weights (positive half; Abramowitz and Stegun,
/// table 25.4).
const RULE: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Below this the approximant of degree 8 has relative error below the unit roundoff (Higham, Functions of Matrices,
/// table 11.1: 0.264 for degree 7).
const NEAR: f64 = 0.25;

/// Most square roots, and most steps of the iteration for one.
const ROOTS: i32 = 100;
const STEPS: usize = 60;

/// Principal logarithm of `A`: the real `X` with `e^X = A` whose eigenvalues have imaginary parts in (-pi, pi).
///
/// `a` is n x n, finite. It exists and is unique iff no eigenvalue of `A` is zero or a negative real number.
///
/// Method: square roots until `A` is near the identity, the Pade approximant of degree 8 in partial fractions, and
/// doubling back (inverse scaling and squaring; Kenney and Laub, SIMAX 10, 1989; Higham, Functions of Matrices, chapter
/// 11; the roots by the product form of the iteration of Denman and Beavers, (6.29) there).
///
/// # Errors
/// [`LinalgError::NotSquare`], [`LinalgError::NotFinite`], [`LinalgError::NoLogarithm`] with the eigenvalue;
/// [`LinalgError::NotConverged`] if `e^X` misses `A` by more than `1e-9 |A|` in balanced units, for an eigenvalue very
/// near the negative axis.
///
/// # Cost
/// `O(n^3)`, about 200 n^3 flops.
///
/// # Example
/// ```
/// use luenberger_linalg::{expm, logm};
/// use nalgebra::dmatrix;
///
/// let a = dmatrix![-0.2, 1.0; -4.0, -0.4];
/// let residual = (logm(&expm(&a)?)? - a).norm();
/// println!("residual {residual:e}");
/// assert!(residual < 1e-13);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn logm<'a>(a: impl Into<RealMatrixView<'a>>) -> Result<DMatrix<f64>> {
    let a = owned(a);
    let n = square("A", &a)?;
    if n == 0 {
        return Ok(a);
    }
    if let Some(eigenvalue) = eigenvalues(&a)?.into_iter().find(|z| z.im == 0.0 && z.re <= 0.0) {
        return Err(LinalgError::NoLogarithm { eigenvalue });
    }
    // In balanced units of the state.
    let units = Units::of(&a, &DMatrix::zeros(0, n));
    let similar = |m: &DMatrix<f64>, sign: i32| {
        DMatrix::from_fn(n, n, |i, j| shift(m[(i, j)], sign * (units.state[j] - units.state[i])))
    };
    Ok(similar(&of_balanced(&similar(&a, 1))?, -1))
}

fn of_balanced(a: &DMatrix<f64>) -> Result<DMatrix<f64>> {
    let n = a.nrows();
    let identity = DMatrix::identity(n, n);
    let (mut root, mut roots) = (a.clone(), 0);
    while roots < ROOTS && norm(&(&root - &identity)) > NEAR {
        root = square_root(&root)?;
        roots += 1;
    }
    // log(I + E) = int_0^1 E (I + x E)^-1 dx.
    let e = root - &identity;
    let mut log = DMatrix::zeros(n, n);
    for (node, weight) in RULE.into_iter().flat_map(|(x, w)| [(x, w), (-x, w)]) {
        let shifted = &identity + &e * f64::midpoint(1.0, node);
        log += &e * inverse("I + x (A^(1/2^k) - I)", &shifted)? * (weight / 2.0);
    }
    log *= 2f64.powi(roots);
    let allowed = 1e-9 * norm(a);
    let remaining = norm(&(expm(&log)? - a));
    if remaining <= allowed {
        return Ok(log);
    }
    Err(LinalgError::NotConverged { method: "the matrix logarithm", iterations: roots as usize, remaining, allowed })
}

/// The square root with eigenvalues in the right half plane.
fn square_root(a: &DMatrix<f64>) -> Result<DMatrix<f64>> {
    let identity = DMatrix::identity(a.nrows(), a.nrows());
    let (mut x, mut m) = (a.clone(), a.clone());
    let mut before = f64::INFINITY;
    for _ in 0..STEPS {
        let inverted = inverse("the iterate of a square root", &m)?;
        x = (&x + &x * &inverted) * 0.5;
        m = (&identity + (&m + inverted) * 0.5) * 0.5;
        let distance = norm(&(&m - &identity));
        // Quadratic convergence down to rounding, after which nothing is gained.
        if distance <= f64::EPSILON || (distance < 1e-6 && distance >= 0.5 * before) {
            return Ok(x);
        }
        before = distance;
    }
    Err(LinalgError::NotConverged {
        method: "the matrix square root",
        iterations: STEPS,
        remaining: before,
        allowed: f64::EPSILON,
    })
}

fn norm(m: &DMatrix<f64>) -> f64 {
    m.column_iter().map(|column| column.lp_norm(1)).fold(0.0, f64::max)
}
