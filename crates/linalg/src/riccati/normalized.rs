//! A Riccati equation in coordinates of the state in which its solution is near the identity.
//!
//! Few inputs and many unstable states make `X` grow in some directions and not in others, by twelve decades for 100 states and three inputs. The invariant subspace, accurate
//! beside the norm of the Hamiltonian matrix, then leaves few digits or none of what is small, and Newton's iteration starts too far away. With `X = V W V'`
//! (eigenvalues W) and `T = V W^-1/2`, the equation of `A T = T A^`, `B = T B^`, `Q^ = T'Q T` has the solution `X^ = T'X T` near `I`: its closed
//! loop satisfies `(A^ - B^ K^) + (A^ - B^ K^)' = -(Q^ + K^'R K^)`, is as large as these, and nothing in it is drowned. Solved there, the equation gives an X from which
//! still better coordinates come: the digits are back after one pass or two.

use super::scaled::Scaled;
use super::{NEWTON_STEPS, hamiltonian};
use crate::argument::symmetric_part;
use crate::product::view;
use crate::sequential::hermitian_eigen;
use crate::{LinalgError, Result};
use nalgebra::{DMatrix, DVector};

/// Each pass takes the coordinates from the solution of the one before.
const PASSES: usize = 4;

/// The solution by `method`, in the coordinates of `problem` if these serve, and its relative residual.
pub(super) fn solve(problem: &Scaled, method: impl Fn(&Scaled) -> Result<DMatrix<f64>>) -> Result<(DMatrix<f64>, f64)> {
    let (mut best, failure) = match method(problem) {
        Ok(x) => (refine(problem, x)?, None),
        // No eigenvalue of the plant explains it: rounding, perhaps.
        Err(failure @ LinalgError::NotStabilizing { .. }) if !problem.discrete => match hamiltonian::guess(problem) {
            Some(x) => ((x, f64::INFINITY), Some(failure)),
            None => return Err(failure),
        },
        Err(failure) => return Err(failure),
    };
    // What a good method and a Newton step leave.
    let good = 10.0 * problem.a.nrows() as f64 * f64::EPSILON;
    for _ in 0..PASSES {
        if best.1 <= good {
            break;
        }
        let Some(frame) = Frame::of(&best.0) else { break };
        let local = problem.in_coordinates(&frame.t, &frame.inverse);
        let Ok(x) = method(&local) else { break };
        let x = frame.back(&refine(&local, x)?.0);
        let found = problem.residual(&x);
        if found.is_nan() || found >= best.1 {
            break;
        }
        let gained = found < 0.5 * best.1;
        best = (x, found);
        if !gained {
            break;
        }
    }
    match failure {
        Some(failure) if best.1.is_infinite() => Err(failure),
        _ => Ok(best),
    }
}

/// Newton's iteration as long as it lowers the residual.
fn refine(problem: &Scaled, mut x: DMatrix<f64>) -> Result<(DMatrix<f64>, f64)> {
    let mut residual = problem.residual(&x);
    for _ in 0..NEWTON_STEPS {
        let Some(better) = problem.newton_step(&x)? else { break };
        let found = problem.residual(&better);
        if found.is_nan() || found >= residual {
            break;
        }
        (x, residual) = (better, found);
    }
    Ok((x, residual))
}

/// `T` with `T'X T` near the identity, and its inverse.
struct Frame {
    t: DMatrix<f64>,
    inverse: DMatrix<f64>,
}

impl Frame {
    /// `None` for an X that is zero or not finite.
    fn of(x: &DMatrix<f64>) -> Option<Self> {
        let n = x.nrows();
        let (values, vectors) = hermitian_eigen(view(x))?;
        let sizes = DVector::from_fn(n, |i, _| values[i].abs());
        let largest = sizes.amax();
        if largest == 0.0 || !largest.is_finite() {
            return None;
        }
        // Below its rounding an eigenvalue has no size, and where X vanishes no coordinates are asked for.
        let root = sizes.map(|w| w.max(largest * f64::EPSILON).sqrt());
        let t = DMatrix::from_fn(n, n, |i, j| vectors[(i, j)] / root[j]);
        let inverse = DMatrix::from_fn(n, n, |i, j| vectors[(j, i)] * root[i]);
        Some(Self { t, inverse })
    }

    /// `T^-T X^ T^-1`.
    fn back(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        symmetric_part(&(self.inverse.tr_mul(x) * &self.inverse))
    }
}
