//! Why there is no stabilizing solution: the Popov-Belevitch-Hautus test at the eigenvalues of `A`.
//!
//! `lambda` cannot be moved iff `[A - lambda I, B]` loses rank, and is unobservable through `Q` iff `[A - lambda I; Q]`
//! does. The margin is the smallest singular value of that matrix, with `B` and `Q` scaled to the norm of `A`. A hidden
//! mode counts as one on the boundary within the accuracy of its own eigenvalue: a slow mode decays.

use super::scaled::Scaled;
use crate::balance::Balance;
use crate::placement::sensitivity::conditions;
use crate::sequential::singular_values;
use crate::{LinalgError, Result, schur};
use faer::MatRef;
use nalgebra::{Complex, DMatrix};

/// Signed distance to the stability boundary, positive on the stable side.
fn distance(problem: &Scaled, eigenvalue: Complex<f64>) -> f64 {
    if problem.discrete { 1.0 - eigenvalue.norm() } else { -eigenvalue.re }
}

/// Smallest singular value of `[A - lambda I; C]`, `C` scaled to the norm of `A`.
///
/// Each singular value of the complex matrix `M + i N` appears twice among those of the real `[M -N; N M]`.
fn margin(a: &DMatrix<f64>, c: &DMatrix<f64>, lambda: Complex<f64>) -> f64 {
    let (n, p) = (a.nrows(), c.nrows());
    let size = a.norm();
    let scale = if size > 0.0 && c.norm() > 0.0 { size / c.norm() } else { 1.0 };
    let mut m = DMatrix::zeros(2 * (n + p), 2 * n);
    for (row, col) in [(0, 0), (n + p, n)] {
        m.view_mut((row, col), (n, n)).copy_from(a);
        m.view_mut((row + n, col), (p, n)).copy_from(&(c * scale));
        for i in 0..n {
            m[(row + i, col + i)] -= lambda.re;
        }
    }
    for i in 0..n {
        m[(i, n + i)] += lambda.im;
        m[(n + p + i, i)] -= lambda.im;
    }
    let view = MatRef::from_column_major_slice(m.as_slice(), 2 * (n + p), 2 * n);
    // If the singular values do not converge (no such case is known), infinity excludes this eigenvalue.
    singular_values(view).and_then(|s| s.into_iter().reduce(f64::min)).unwrap_or(f64::INFINITY)
}

/// Error for the eigenvalue of smallest margin, if that margin is at most `tolerance` times the norm of `A`.
/// In the units of the states that fit A and Q: those of the computation balance neither what nothing drives nor what
/// drives nothing.
fn offender(problem: &Scaled, tolerance: f64) -> Result<Option<LinalgError>> {
    let Scaled { a, b, q, .. } = problem;
    let (a, b, q) = match Balance::of_weighted(a, q) {
        Some(units) => (&units.similar(a), units.driven(b), units.form(q)),
        None => (a, b.clone(), q.clone()),
    };
    let n = a.nrows() as f64;
    let size = a.norm().max(f64::MIN_POSITIVE);
    let unit = n * if problem.discrete { size.max(1.0) } else { size };
    let form = schur(a)?;
    let conditions = conditions(&form, &vec![0; a.nrows()]);
    let mut worst: Option<(f64, LinalgError)> = None;
    let mut consider = |margin: f64, error: LinalgError| {
        if margin <= tolerance * size && worst.as_ref().is_none_or(|w| margin < w.0) {
            worst = Some((margin, error));
        }
    };
    // A conjugate pair has one margin.
    for (lambda, condition) in form.eigenvalues().into_iter().zip(conditions).filter(|(lambda, _)| lambda.im >= 0.0) {
        // Accuracy of this eigenvalue; of a double one the root of eps.
        let near = unit * (10.0 * f64::EPSILON * condition).min(f64::EPSILON.sqrt());
        let distance = distance(problem, lambda);
        let eigenvalue = lambda / problem.time;
        if distance <= near {
            let found = margin(&a.transpose(), &b.transpose(), lambda);
            consider(found, LinalgError::NotStabilizable { eigenvalue, margin: found / problem.time });
        }
        if distance.abs() <= near {
            let found = margin(a, &q, lambda);
            consider(found, LinalgError::NotWeighted { eigenvalue, margin: found / problem.time });
        }
    }
    Ok(worst.map(|w| w.1))
}

/// Error for an equation whose solution failed; `nearest` is the eigenvalue of the closed loop near the boundary or
/// beyond it, if one is known.
pub(super) fn explain(problem: &Scaled, nearest: Option<Complex<f64>>) -> LinalgError {
    // The margin of a defective eigenvalue stays at rounding level although the computed eigenvalue itself is
    // inaccurate. The tolerance is only 1e3 n eps, so that a stiff plant is not reported as uncontrollable.
    match offender(problem, 1e3 * f64::EPSILON * problem.a.nrows() as f64) {
        Ok(Some(found)) => found,
        Ok(None) => nearest.map_or(LinalgError::NoStabilizingSolution, |nearest| LinalgError::NotStabilizing {
            eigenvalue: nearest / problem.time,
            distance: distance(problem, nearest) / problem.time,
        }),
        Err(error) => error,
    }
}

/// The closed-loop pole nearest to the stability boundary or furthest beyond it, with its signed distance.
pub(super) fn nearest(problem: &Scaled, poles: &[Complex<f64>]) -> Option<(Complex<f64>, f64)> {
    let with_distance = poles.iter().map(|&pole| (pole, distance(problem, pole)));
    with_distance.min_by(|x, y| x.1.total_cmp(&y.1))
}

/// Error if a closed-loop pole is nearer to the boundary than `rounding`.
pub(super) fn resolved(problem: &Scaled, poles: &[Complex<f64>], rounding: f64) -> Result<()> {
    match nearest(problem, poles) {
        Some((nearest, least)) if least <= rounding => Err(explain(problem, Some(nearest))),
        _ => Ok(()),
    }
}

/// Error unless the closed-loop `poles` (in the units of computation) are stable, beyond the rounding error of an
/// eigenvalue on the boundary.
pub(super) fn confirm(problem: &Scaled, poles: &[Complex<f64>]) -> Result<()> {
    let Some((nearest, least)) = nearest(problem, poles) else { return Ok(()) };
    if least.is_nan() || least <= 0.0 {
        return Err(explain(problem, Some(nearest)));
    }
    let n = problem.a.nrows() as f64;
    if least <= f64::EPSILON.sqrt() * n * problem.a.norm()
        && let Some(error) = offender(problem, 10.0 * n * f64::EPSILON)?
    {
        return Err(error);
    }
    Ok(())
}
