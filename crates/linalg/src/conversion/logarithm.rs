//! Principal logarithm of a matrix.

use nalgebra::DMatrix;

use super::inverse;
use crate::argument::{RealMatrixView, owned, square};
use crate::balance::are_near;
use crate::discretize::{expm, one_norm as norm};
use crate::spectrum::eigenvalues;
use crate::units::{Units, shift};
use crate::{LinalgError, Result, balanced, schur};

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
/// 11; the roots by the product form of the iteration of Denman and Beavers, (6.29) there). If that does not converge,
/// as for eigenvalues many decades apart, the same in a real Schur form, whose square roots are computed block by block
/// (Higham, section 6.2).
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
    let units = if are_near(a.iter()) { Units::given(n, 0) } else { Units::of(&a, &DMatrix::zeros(0, n)) };
    let similar = |m: &DMatrix<f64>, sign: i32| {
        DMatrix::from_fn(n, n, |i, j| shift(m[(i, j)], sign * (units.state[j] - units.state[i])))
    };
    let within = similar(&a, 1);
    let log = near_identity(&within, square_root)
        .and_then(|(log, roots)| verified(&within, log, roots))
        .or_else(|error| of_schur_form(&within).ok_or(error))?;
    Ok(similar(&log, -1))
}

/// The logarithm by square roots, and their number.
fn near_identity(
    a: &DMatrix<f64>,
    square_root: impl Fn(&DMatrix<f64>) -> Result<DMatrix<f64>>,
) -> Result<(DMatrix<f64>, i32)> {
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
    Ok((log * 2f64.powi(roots), roots))
}

/// The logarithm, if its exponential is A.
fn verified(a: &DMatrix<f64>, log: DMatrix<f64>, roots: i32) -> Result<DMatrix<f64>> {
    let allowed = 1e-9 * norm(a);
    let remaining = norm(&(expm(&log)? - a));
    if remaining <= allowed {
        return Ok(log);
    }
    Err(LinalgError::NotConverged { method: "the matrix logarithm", iterations: roots as usize, remaining, allowed })
}

/// The logarithm from the Schur form: real eigenvalues are its diagonal entries, of any size beside each other. Those
/// that are isolated come to the diagonal first, so that the form keeps them. `None` if it cannot be verified.
fn of_schur_form(a: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    let order = balanced(a).ok()?.permutation;
    let form = schur(&DMatrix::from_fn(n, n, |i, j| a[(order[i], order[j])])).ok()?;
    // First row and order of each diagonal block.
    let mut blocks: Vec<(usize, usize)> = Vec::new();
    let mut first = 0;
    while first < n {
        let size = if first + 1 < n && form.t[(first + 1, first)] != 0.0 { 2 } else { 1 };
        blocks.push((first, size));
        first += size;
    }
    let unknown = || LinalgError::Overflow { what: "the square root of the Schur form" };
    let root = |t: &DMatrix<f64>| root_by_blocks(t, &blocks).ok_or_else(unknown);
    let (mut log, roots) = near_identity(&form.t, root).ok()?;
    for &(k, _) in blocks.iter().filter(|(_, size)| *size == 1) {
        log[(k, k)] = form.t[(k, k)].ln();
    }
    let turned = &form.q * log * form.q.transpose();
    let mut back = DMatrix::zeros(n, n);
    for j in 0..n {
        for i in 0..n {
            back[(order[i], order[j])] = turned[(i, j)];
        }
    }
    verified(a, back, roots).ok()
}

/// The square root R of an upper quasi-triangular matrix, of the same form: its blocks in each column, from the diagonal
/// upwards, solve `R_ii X + X R_jj = T_ij - sum R_ik R_kj`.
fn root_by_blocks(t: &DMatrix<f64>, blocks: &[(usize, usize)]) -> Option<DMatrix<f64>> {
    let n = t.nrows();
    let mut r = DMatrix::zeros(n, n);
    for (k, &(column, width)) in blocks.iter().enumerate() {
        let below = root_of_block(&t.view((column, column), (width, width)).into_owned());
        r.view_mut((column, column), (width, width)).copy_from(&below);
        for &(row, height) in blocks[..k].iter().rev() {
            let (next, between) = (row + height, column - row - height);
            let known = r.view((row, next), (height, between)) * r.view((next, column), (between, width));
            let right = t.view((row, column), (height, width)) - known;
            let left = r.view((row, row), (height, height)).into_owned();
            let map = DMatrix::<f64>::identity(width, width).kronecker(&left)
                + below.transpose().kronecker(&DMatrix::<f64>::identity(height, height));
            let x = map.lu().solve(&DMatrix::from_column_slice(height * width, 1, right.as_slice()))?;
            r.view_mut((row, column), (height, width)).copy_from_slice(x.as_slice());
        }
    }
    r.iter().all(|x: &f64| x.is_finite()).then_some(r)
}

/// The square root of a positive number, or of a block of order two with the eigenvalues `theta +- i mu`.
fn root_of_block(t: &DMatrix<f64>) -> DMatrix<f64> {
    if t.nrows() == 1 {
        return t.map(f64::sqrt);
    }
    let theta = f64::midpoint(t[(0, 0)], t[(1, 1)]);
    let half = 0.5 * (t[(0, 0)] - t[(1, 1)]);
    let mu = (-(half * half + t[(0, 1)] * t[(1, 0)])).max(0.0).sqrt();
    let modulus = theta.hypot(mu);
    // The real part of the root.
    let alpha = if theta > 0.0 { (0.5 * (theta + modulus)).sqrt() } else { mu / (2.0 * (modulus - theta)).sqrt() };
    let identity = DMatrix::identity(2, 2);
    &identity * alpha + (t - &identity * theta) / (2.0 * alpha)
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
