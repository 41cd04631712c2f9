//! Kalman's decomposition: the four parts of a plant that are controllable or not, and observable or not.
//!
//! With `x = T w` the plant `x' = A x + B u, y = C x` becomes (Kalman, SIAM J. Control 1, 1963; Chen, Linear System
//! Theory and Design, 6.4)
//!
//! ```text
//!            [A11  0   A13  0 ]             [B1]                                 moved    seen
//! T^-1 A T = [A21 A22  A23 A24]   T^-1 B  = [B2]   C T = [C1 0 C3 0]    1 :      yes      yes
//!            [ 0   0   A33  0 ]             [ 0]                        2 :      yes      no
//!            [ 0   0   A43 A44]             [ 0]                        3 :      no       yes
//!                                                                       4 :      no       no
//! ```
//! and the transfer function is that of the first part alone, `C1 (s I - A11)^-1 B1`. The orders of the parts and their
//! eigenvalues do not depend on the choice of T.
//!
//! Method: three orthogonal staircases. `(A, B)` gives the reachable subspace R and its complement; within R the
//! unobservable part N1 and its complement; modulo N1 the rest of the unobservable subspace, which is a graph over part
//! of the complement of R. The bases of the parts are orthonormal each, 2 within the unobservable and the reachable
//! subspace; only 1 and 4 may be oblique to one another, and the condition of T says how much.

use faer::Mat;
use nalgebra::{Complex, DMatrix};

use crate::argument::{RealMatrixView, owned};
use crate::observability::{default_tolerance, staircase_within};
use crate::rosenbrock::Rosenbrock;
use crate::spectrum::eigenvalues;
use crate::staircase::compress_rows;
use crate::units::shift;
use crate::{LinalgError, Result};

/// One of the four parts.
#[derive(Debug, Clone, PartialEq)]
pub struct KalmanPart {
    /// Index of its first coordinate in `w`, from 0.
    pub start: usize,
    /// Its order, the number of its coordinates.
    pub order: usize,
    /// The eigenvalues of its diagonal block.
    pub eigenvalues: Vec<Complex<f64>>,
}

/// `x = T w` with the four parts of the plant one after the other in `w`.
#[derive(Debug, Clone, PartialEq)]
pub struct KalmanDecomposition {
    /// T, n x n: its columns span the parts.
    pub transformation: DMatrix<f64>,
    /// `T^-1 A T`, its zero blocks exactly zero.
    pub a: DMatrix<f64>,
    /// `T^-1 B`, its zero blocks exactly zero.
    pub b: DMatrix<f64>,
    /// `C T`, its zero blocks exactly zero.
    pub c: DMatrix<f64>,
    /// The controllable and observable part: the minimal realisation of the transfer function.
    pub controllable_observable: KalmanPart,
    /// The controllable, unobservable part.
    pub controllable_unobservable: KalmanPart,
    /// The observable, uncontrollable part.
    pub uncontrollable_observable: KalmanPart,
    /// The uncontrollable, unobservable part.
    pub uncontrollable_unobservable: KalmanPart,
    /// Norm of all that was set to zero, relative to `|[A B; C 0]|` (Frobenius), in the units chosen: rounding, times
    /// [`Self::condition`].
    pub residual: f64,
    /// `cond_2(T)` in the units chosen: 1 where the orthogonal bases suffice.
    pub condition: f64,
    /// The relative tolerance of the rank decisions.
    pub tolerance: f64,
}

impl KalmanDecomposition {
    /// `(A11, B1, C1)`: a plant of the least order with the same transfer function.
    pub fn minimal(&self) -> (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>) {
        let k = self.controllable_observable.order;
        (self.a.view((0, 0), (k, k)).into_owned(), self.b.rows(0, k).into_owned(), self.c.columns(0, k).into_owned())
    }

    /// The four parts in the order of `w`.
    pub fn parts(&self) -> [&KalmanPart; 4] {
        [
            &self.controllable_observable,
            &self.controllable_unobservable,
            &self.uncontrollable_observable,
            &self.uncontrollable_unobservable,
        ]
    }
}

/// Kalman's decomposition of `x' = A x + B u, y = C x` (in discrete time the same).
///
/// `a` is n x n, `b` n x m, `c` p x n; m = 0 or p = 0 is allowed. Ranks are decided as in [`crate::observability()`],
/// in units chosen from all three matrices.
///
/// These units make small entries as large as the others. In coordinates that turn a part by an angle of less than about
/// a hundredth, the rounding with which they were computed then counts: parts that it alone couples may be found as one,
/// with the same transfer function up to that rounding.
///
/// # Errors
/// [`LinalgError::NotSquare`], [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], [`LinalgError::Empty`];
/// [`LinalgError::Singular`] if rounding decides the ranks so that the parts do not fill the space;
/// [`LinalgError::Overflow`].
///
/// # Cost
/// Three staircases with the margins of their modes, about `150 n^3` flops.
///
/// # Example
/// ```
/// use luenberger_linalg::kalman_decomposition;
/// use nalgebra::dmatrix;
///
/// // -1 is moved and seen, -2 moved only, -3 seen only, -4 neither.
/// let a = dmatrix![-1.0, 0.0, 0.0, 0.0; 0.0, -2.0, 0.0, 0.0; 0.0, 0.0, -3.0, 0.0; 0.0, 0.0, 0.0, -4.0];
/// let (b, c) = (dmatrix![1.0; 1.0; 0.0; 0.0], dmatrix![1.0, 0.0, 1.0, 0.0]);
/// let parts = kalman_decomposition(&a, &b, &c)?;
/// let found: Vec<f64> = parts.parts().iter().map(|part| part.eigenvalues[0].re).collect();
/// let residual = (&a * &parts.transformation - &parts.transformation * &parts.a).norm();
/// println!("{found:?}, residual {residual:e}, blocks {:e}", parts.residual);
/// assert!(residual < 1e-14 && parts.residual < 1e-15);
/// for (x, y) in found.iter().zip([-1.0, -2.0, -3.0, -4.0]) {
///     assert!((x - y).abs() < 1e-14);
/// }
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Kalman, SIAM J. Control 1, 1963; Boley, IEEE TAC 29, 1984, for the orthogonal staircases.
pub fn kalman_decomposition<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
) -> Result<KalmanDecomposition> {
    decomposed(&owned(a), &owned(b), &owned(c))
}

fn decomposed(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<KalmanDecomposition> {
    let plant = Rosenbrock::new(a, b, c, &DMatrix::zeros(c.nrows(), b.ncols()))?;
    let (n, m, p) = (a.nrows(), b.ncols(), c.nrows());
    let tolerance = default_tolerance(n, m.max(p));
    let size = plant.size;

    let reach = staircase_within(&plant.a.transpose(), &plant.b.transpose(), tolerance, size)?;
    let reached = reach.q.columns(0, reach.rank).into_owned();
    let rest = reach.q.columns(reach.rank, n - reach.rank).into_owned();
    let (seen, hidden) = split(&plant, &reached, tolerance)?;
    // Modulo what is reached and hidden.
    let mut quotient = DMatrix::zeros(n, seen.ncols() + rest.ncols());
    quotient.columns_mut(0, seen.ncols()).copy_from(&seen);
    quotient.columns_mut(seen.ncols(), rest.ncols()).copy_from(&rest);
    let (_, blind) = split(&plant, &quotient, tolerance)?;
    // What of the rest it is a graph over, and what of the rest that leaves.
    let mut projected = rest.transpose() * &blind;
    let mut turned = rest;
    compress_rows(&mut projected, 0.0, |reflection, row| reflection.act_on_columns(&mut turned, row));
    if blind.ncols() > turned.ncols() {
        return Err(LinalgError::Singular { what: "the transformation to Kalman's form", condition: f64::INFINITY });
    }
    let alone = turned.columns(blind.ncols(), turned.ncols() - blind.ncols()).into_owned();

    let orders = [seen.ncols(), hidden.ncols(), alone.ncols(), blind.ncols()];
    let starts = [0, orders[0], orders[0] + orders[1], orders[0] + orders[1] + orders[2]];
    let mut t = DMatrix::zeros(n, n);
    for (basis, start) in [seen, hidden, alone, blind].iter().zip(starts) {
        t.columns_mut(start, basis.ncols()).copy_from(basis);
    }
    let condition = condition(&t)?;
    let lu = t.clone().lu();
    let solve = |right: DMatrix<f64>| {
        lu.solve(&right)
            .filter(|x| x.iter().all(|x| x.is_finite()))
            .ok_or(LinalgError::Singular { what: "the transformation to Kalman's form", condition })
    };
    let (mut at, mut bt, mut ct) = (solve(&plant.a * &t)?, solve(plant.b.clone())?, &plant.c * &t);

    let mut dropped = 0.0_f64;
    let mut drop = |block: &mut DMatrix<f64>, from: (usize, usize), shape: (usize, usize)| {
        let mut view = block.view_mut(from, shape);
        dropped = dropped.hypot(view.norm());
        view.fill(0.0);
    };
    // Rows: which parts a column of parts does not drive.
    for (row, column) in [(0, 1), (0, 3), (2, 0), (2, 1), (2, 3), (3, 0), (3, 1)] {
        drop(&mut at, (starts[row], starts[column]), (orders[row], orders[column]));
    }
    drop(&mut bt, (starts[2], 0), (orders[2] + orders[3], m));
    drop(&mut ct, (0, starts[1]), (p, orders[1]));
    drop(&mut ct, (0, starts[3]), (p, orders[3]));

    let back = |x: f64| shift(x, plant.time());
    let part = |k: usize| -> Result<KalmanPart> {
        let block = at.view((starts[k], starts[k]), (orders[k], orders[k])).into_owned();
        let eigenvalues = eigenvalues(&block)?.into_iter().map(|x| Complex::new(back(x.re), back(x.im))).collect();
        Ok(KalmanPart { start: starts[k], order: orders[k], eigenvalues })
    };
    let found = KalmanDecomposition {
        controllable_observable: part(0)?,
        controllable_unobservable: part(1)?,
        uncontrollable_observable: part(2)?,
        uncontrollable_unobservable: part(3)?,
        transformation: plant.states_back(&t),
        a: at.map(back),
        b: plant.driven_back(&bt),
        c: plant.outputs_back(&ct),
        residual: if size > 0.0 { dropped / size } else { 0.0 },
        condition,
        tolerance,
    };
    let all = [&found.transformation, &found.a, &found.b, &found.c];
    if all.iter().any(|m| m.iter().any(|x| !x.is_finite())) {
        return Err(LinalgError::Overflow { what: "Kalman's form in the units given" });
    }
    Ok(found)
}

/// The plant restricted to the span of orthonormal columns (modulo a hidden invariant subspace orthogonal to it): what
/// of the span is seen, what is not.
fn split(plant: &Rosenbrock, basis: &DMatrix<f64>, tolerance: f64) -> Result<(DMatrix<f64>, DMatrix<f64>)> {
    let k = basis.ncols();
    if k == 0 {
        return Ok((basis.clone(), basis.clone()));
    }
    let (a, c) = (basis.transpose() * &plant.a * basis, &plant.c * basis);
    let staircase = staircase_within(&a, &c, tolerance, plant.size)?;
    let turned = basis * &staircase.q;
    let rank = staircase.rank;
    Ok((turned.columns(0, rank).into_owned(), turned.columns(rank, k - rank).into_owned()))
}

/// `cond_2`.
fn condition(t: &DMatrix<f64>) -> Result<f64> {
    let n = t.nrows();
    let sigma = Mat::from_fn(n, n, |i, j| t[(i, j)]).singular_values().map_err(|_| LinalgError::NotConverged {
        method: "singular values of the transformation",
        iterations: 0,
        remaining: f64::NAN,
        allowed: f64::EPSILON,
    })?;
    Ok(match (sigma.first(), sigma.last()) {
        (Some(largest), Some(smallest)) if *smallest > 0.0 => largest / smallest,
        _ => f64::INFINITY,
    })
}
