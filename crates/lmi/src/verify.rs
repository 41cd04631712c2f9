//! Verification of the constraints at given values: the user's expression is evaluated at the returned binary64 values
//! with outward rounding, then exactly if needed, and definiteness is proved by `luenberger-proof`.
//!
//! The proved statement is `v'F(x)v > 0` for every v other than 0, which concerns the symmetric part of F(x).

use luenberger_proof::definite::Entry;
use luenberger_proof::{Exact, Interval, Matrix, Ring, Verdict, positive_definite};
use nalgebra::DMatrix;

use crate::coefficients::{Rounded, evaluate};
use crate::expression::Expression;
use crate::problem::Problem;
use crate::solution::Margin;
use crate::variable::Variable;

/// The margins of all constraints at the given values.
pub(crate) fn verify(problem: &Problem, values: &[(Variable, DMatrix<f64>)]) -> Vec<Margin> {
    problem
        .constraints
        .iter()
        .map(|(name, inequality)| {
            let positive = &inequality.positive;
            let estimate = smallest_eigenvalue(positive, values);
            let proved = proved_margin::<Interval>(positive, values).or_else(|| {
                // A clearly negative eigenvalue needs no exact arithmetic to stay unproved.
                let hope = estimate > -1e-6 * size(positive, values);
                if hope { proved_margin::<Exact>(positive, values) } else { None }
            });
            Margin { constraint: name.clone(), proved, estimate }
        })
        .collect()
}

/// A rigorous positive lower bound on the smallest eigenvalue, if there is one in this arithmetic.
fn proved_margin<R: Ring + Entry>(e: &Expression, values: &[(Variable, DMatrix<f64>)]) -> Option<f64> {
    // F + F', twice the symmetric part, has no rounding error from a division; halving its margin has none either,
    // unless it underflows.
    let twice: Matrix<R> = evaluate::<R>(e, values).ok()?.plus_transpose().ok()?;
    match positive_definite(&twice) {
        Ok(Verdict::Proved { margin }) if margin > 2.0 * f64::MIN_POSITIVE => Some(0.5 * margin),
        _ => None,
    }
}

/// `None` if a value is not finite.
fn rounded(e: &Expression, values: &[(Variable, DMatrix<f64>)]) -> Option<DMatrix<f64>> {
    let m = evaluate::<Rounded>(e, values).ok()?;
    Some(DMatrix::from_fn(m.rows(), m.cols(), |i, j| 0.5 * m[(i, j)].0 + 0.5 * m[(j, i)].0))
}

fn size(e: &Expression, values: &[(Variable, DMatrix<f64>)]) -> f64 {
    rounded(e, values).map_or(0.0, |m| m.amax())
}

/// The smallest eigenvalue in floating point; minus infinity if it cannot be computed.
fn smallest_eigenvalue(e: &Expression, values: &[(Variable, DMatrix<f64>)]) -> f64 {
    rounded(e, values).and_then(|m| luenberger_linalg::lambda_min(&m).ok()).unwrap_or(f64::NEG_INFINITY)
}
