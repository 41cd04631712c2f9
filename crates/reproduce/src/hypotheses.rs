//! Hypotheses of the papers' theorems as statements for `luenberger-proof`, computed from the data without rounding.

use luenberger_design::Region;
use luenberger_design::enclosure::{IntervalDual, enclose};
use luenberger_linalg::lyapunov;
use luenberger_lmi::proof_matrix;
use luenberger_plants::Plant;
use luenberger_proof::certificate::Number;
use luenberger_proof::statement::hurwitz;
use luenberger_proof::{Direction, Exact, Interval, Matrix, ProofError, Ring, Verdict, definite};
use nalgebra::DMatrix;

use crate::claim::CheckError;
use crate::evidence::Hypothesis;
use crate::value::short;

/// The same numbers, exactly.
fn exact(m: &DMatrix<f64>) -> Result<Matrix<Exact>, ProofError> {
    Matrix::embed(&proof_matrix(m), "the data")
}

/// The decimals that a paper prints, as fractions; none where one is not finite.
pub(crate) fn as_printed(m: &DMatrix<f64>) -> Option<Matrix<Number>> {
    let rows = (0..m.nrows()).flat_map(|i| (0..m.ncols()).map(move |j| (i, j)));
    let entries: Option<Vec<Number>> = rows.map(|(i, j)| Number::of_decimal(m[(i, j)])).collect();
    Matrix::from_row_major(m.nrows(), m.ncols(), entries?).ok()
}

/// `(A, C)` is observable.
pub(crate) fn observable(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<Hypothesis, CheckError> {
    Ok(Hypothesis::proof(OBSERVABLE, &observability(a, c)?))
}

pub(crate) const OBSERVABLE: &str = "(A, C) is observable";

/// The Gram matrix of C, CA, .., CA^(n-1) is positive definite.
pub(crate) fn observability(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<Verdict<Direction>, CheckError> {
    let (a, mut block) = (exact(a)?, exact(c)?);
    let mut gram = block.transpose().product(&block)?;
    for _ in 1..a.rows() {
        block = block.product(&a)?;
        gram = gram.sum(&block.transpose().product(&block)?)?;
    }
    Ok(definite::positive_definite(&gram)?)
}

/// `F` is Hurwitz, shown by the solution of `F'P + PF + I = 0`.
pub(crate) fn stable(name: &str, f: &DMatrix<f64>) -> Result<Hypothesis, CheckError> {
    let n = f.nrows();
    let p = lyapunov(f, &DMatrix::identity(n, n))?.p;
    let p = (&p + p.transpose()) * 0.5;
    Ok(Hypothesis::proof(&format!("{name} is Hurwitz"), &hurwitz(&proof_matrix(f), &proof_matrix(&p))?))
}

/// `M > 0`, for a symmetric M.
pub(crate) fn positive(what: &str, m: &DMatrix<f64>) -> Result<Hypothesis, CheckError> {
    Ok(Hypothesis::proof(what, &definite::positive_definite(&exact(m)?)?))
}

/// `M >= 0`, for a symmetric M.
pub(crate) fn nonnegative(what: &str, m: &DMatrix<f64>) -> Result<Hypothesis, CheckError> {
    Ok(Hypothesis::proof(what, &definite::positive_semidefinite(&exact(m)?)?))
}

/// One hypothesis over many cases: proved if it is in each, with the smallest margin; else as in the first where it is
/// not.
pub(crate) fn in_each(what: &str, verdicts: &[Verdict<Direction>]) -> Hypothesis {
    let mut least = f64::INFINITY;
    for verdict in verdicts {
        match verdict.margin() {
            Some(margin) => least = least.min(margin),
            None => return Hypothesis::proof(what, verdict),
        }
    }
    let how = format!("proved in each of {} cases, with margins from {} up", verdicts.len(), short(least));
    Hypothesis::computed(what, !verdicts.is_empty(), how)
}

/// `D - G < 0` with `G = eta diag(alpha)`, alpha_k the sum of row and column k of |D|: condition (4) of the
/// mean-value-theorem paper with (5), (6), for every D in the intervals. A matrix that is not symmetric is negative as
/// a quadratic form.
pub(crate) fn condition_4(d: &Matrix<Interval>, eta: f64) -> Result<Verdict<Direction>, CheckError> {
    if d.as_slice().iter().all(Interval::is_point) {
        let entry = |i: usize, j: usize| Exact::from_f64(d[(i, j)].lo());
        let entries: Option<Vec<Exact>> =
            (0..d.rows()).flat_map(|i| (0..d.cols()).map(move |j| (i, j))).map(|(i, j)| entry(i, j)).collect();
        let d = Matrix::from_row_major(d.rows(), d.cols(), entries.ok_or("D is not finite")?)?;
        let size = |x: &Exact| if x.signum() < 0 { x.neg() } else { x.clone() };
        return Ok(definite::negative_definite(&condition_4_form(&d, size, eta)?)?);
    }
    Ok(definite::negative_definite(&condition_4_form(d, Interval::abs, eta)?)?)
}

/// `D + D' - 2 G` over any ring.
fn condition_4_form<R: Ring>(d: &Matrix<R>, size: impl Fn(&R) -> R, eta: f64) -> Result<Matrix<R>, CheckError> {
    let eta = R::from_f64(eta).ok_or("η is not finite")?;
    let two = R::from_f64(2.0).ok_or("2 is finite")?;
    let alpha = |k: usize| (0..d.rows()).fold(R::zero(), |sum, j| sum.add(&size(&d[(k, j)])).add(&size(&d[(j, k)])));
    let gain =
        Matrix::from_fn(d.rows(), d.cols(), |i, j| if i == j { eta.mul(&alpha(i)).mul(&two) } else { R::zero() });
    Ok(d.plus_transpose()?.difference(&gain)?)
}

/// f has a bounded derivative wherever the region is, by enclosures in which every elementary function is
/// differentiated.
pub(crate) fn differentiable<S: Plant<IntervalDual>>(plant: &S, region: &Region) -> Hypothesis {
    const WHAT: &str = "f is continuously differentiable";
    match enclose(plant, region) {
        Ok(found) if found.a.as_slice().iter().all(Interval::is_bounded) => {
            let largest = found.a.as_slice().iter().map(Interval::magnitude).fold(0.0, f64::max);
            Hypothesis::computed(
                WHAT,
                true,
                format!("its derivative is enclosed, with entries up to {}", short(largest)),
            )
        }
        Ok(_) => Hypothesis {
            holds: None,
            ..Hypothesis::computed(WHAT, false, "an entry of the enclosure of Df is unbounded")
        },
        Err(error) => Hypothesis { holds: None, ..Hypothesis::computed(WHAT, false, error.to_string()) },
    }
}
