//! Enclosure of the exact solution of a Lyapunov or Stein equation: approximated by `linalg`, refined by one residual
//! correction, and enclosed by `proof`.

use luenberger_linalg::{RealMatrixView, lyapunov, stein};
use luenberger_proof::certificate::{CertificateFile, Equation, SolutionWithin};
use luenberger_proof::statement::{Enclosure, lyapunov_solution, stein_solution};
use luenberger_proof::{Exact, Interval, Matrix};
use nalgebra::DMatrix;

use crate::check::owned;
use crate::error::DesignError;
use luenberger_lmi::proof_matrix;

/// The exact P of `A'P + PA + Q = 0`, entry by entry in an interval, with the proof that it exists and is unique.
///
/// A and Q are n x n, Q symmetric; the numbers are taken as exact. The width is that of the binary64 numbers around
/// each entry where the condition of the equation leaves the second residual that small. Undecided where uniqueness
/// could not be proved: two eigenvalues that add to zero, or nearly.
///
/// ```
/// use luenberger_design::enclosed_lyapunov;
/// use nalgebra::dmatrix;
///
/// // A'P + PA + I = 0 has P = [5/4, 1/4; 1/4, 1/4] exactly.
/// let found = enclosed_lyapunov(&dmatrix![0.0, 1.0; -2.0, -3.0], &dmatrix![1.0, 0.0; 0.0, 1.0])?;
/// let p = &found.enclosed().expect("Hurwitz").p;
/// assert!(p[(0, 0)].contains(1.25) && p[(0, 1)].contains(0.25) && p[(1, 1)].width() < 1e-15);
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
/// # Errors
/// [`DesignError::Linalg`] where no floating-point solution is found, [`DesignError::Proof`].
pub fn enclosed_lyapunov<'a>(
    a: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
) -> Result<Enclosure, DesignError> {
    let (a, q) = (&owned(a), &owned(q));
    let (parts, w) = lyapunov_proposal(a, q)?;
    Ok(lyapunov_solution(&points(a)?, &points(q)?, &parts, Some(&w))?)
}

/// The exact P of `A'PA - P + Q = 0`, as [`enclosed_lyapunov`].
///
/// ```
/// use luenberger_design::enclosed_stein;
/// use nalgebra::dmatrix;
///
/// let found = enclosed_stein(&dmatrix![0.5], &dmatrix![3.0])?;
/// assert!(found.enclosed().expect("stable").p[(0, 0)].contains(4.0));
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
/// # Errors
/// As [`enclosed_lyapunov`].
pub fn enclosed_stein<'a>(
    a: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
) -> Result<Enclosure, DesignError> {
    let (a, q) = (&owned(a), &owned(q));
    let (parts, w) = stein_proposal(a, q)?;
    Ok(stein_solution(&points(a)?, &points(q)?, &parts, Some(&w))?)
}

/// Matrices whose sum is near the solution, and one that shows A stable where it is.
type Proposal = (Vec<Matrix<f64>>, Matrix<f64>);

pub(crate) fn lyapunov_proposal(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Proposal, DesignError> {
    let p = lyapunov(a, q)?.p;
    let residual = residual(a, q, &p, |x, a| x.product(a)?.plus_transpose())?;
    let parts = parts(&p, lyapunov(a, &residual).ok().map(|found| found.p));
    let w = lyapunov(a, &DMatrix::identity(a.nrows(), a.nrows()))?.p;
    Ok((parts, proof_matrix(&w)))
}

pub(crate) fn stein_proposal(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Proposal, DesignError> {
    let p = stein(a, q)?.p;
    let residual = residual(a, q, &p, |x, a| a.transpose().product(&x.product(a)?)?.difference(x))?;
    let parts = parts(&p, stein(a, &residual).ok().map(|found| found.p));
    let w = stein(a, &DMatrix::identity(a.nrows(), a.nrows()))?.p;
    Ok((parts, proof_matrix(&w)))
}

type Operator = fn(&Matrix<Exact>, &Matrix<Exact>) -> Result<Matrix<Exact>, luenberger_proof::ProofError>;

/// `T(P) + Q`, rounded once.
fn residual(
    a: &DMatrix<f64>,
    q: &DMatrix<f64>,
    p: &DMatrix<f64>,
    operator: Operator,
) -> Result<DMatrix<f64>, DesignError> {
    let numbers = |m: &DMatrix<f64>, what| Matrix::<Exact>::embed(&proof_matrix(m), what);
    let sum = operator(&numbers(p, "P")?, &numbers(a, "A")?)?.sum(&numbers(q, "Q")?)?;
    let n = a.nrows();
    Ok(DMatrix::from_fn(n, n, |i, j| sum[(i.max(j), i.min(j))].round_down()))
}

fn parts(p: &DMatrix<f64>, rest: Option<DMatrix<f64>>) -> Vec<Matrix<f64>> {
    let mut parts = vec![proof_matrix(p)];
    if let Some(rest) = rest.filter(|rest| rest.iter().all(|x| x.is_finite())) {
        parts.push(proof_matrix(&rest));
    }
    parts
}

pub(crate) fn points(m: &DMatrix<f64>) -> Result<Matrix<Interval>, DesignError> {
    Ok(Matrix::embed(&proof_matrix(m), "a matrix of the equation")?)
}

/// The certificate file of the exact P of `A'P + PA + Q = 0`: that it is the only one, and lies in the intervals of
/// [`enclosed_lyapunov`](crate::enclosed_lyapunov).
///
/// ```
/// use luenberger_design::lyapunov_certificate_file;
/// use luenberger_proof::certificate::verify;
/// use nalgebra::dmatrix;
///
/// let (a, q) = (dmatrix![0.0, 1.0; -2.0, -3.0], dmatrix![1.0, 0.0; 0.0, 1.0]);
/// let file = lyapunov_certificate_file("a damped oscillator", &a, &q)?.to_json();
/// assert_eq!(verify(file.as_bytes())?.facts[0].inequality, "A'P + PA + Q = 0 has one solution, and it lies in P");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// # Errors
/// [`DesignError::CertificateFile`] where uniqueness could not be proved; those of
/// [`enclosed_lyapunov`](crate::enclosed_lyapunov).
pub fn lyapunov_certificate_file<'a>(
    title: &str,
    a: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
) -> Result<CertificateFile, DesignError> {
    let (a, q) = (&owned(a), &owned(q));
    let (parts, w) = lyapunov_proposal(a, q)?;
    Ok(CertificateFile::prove(
        title,
        SolutionWithin::derive(Equation::Lyapunov, &points(a)?, &points(q)?, &parts, Some(&w))?,
    )?)
}

/// The certificate file of the exact P of `A'PA - P + Q = 0`, as [`lyapunov_certificate_file`].
///
/// # Errors
/// As [`lyapunov_certificate_file`].
pub fn stein_certificate_file<'a>(
    title: &str,
    a: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
) -> Result<CertificateFile, DesignError> {
    let (a, q) = (&owned(a), &owned(q));
    let (parts, w) = stein_proposal(a, q)?;
    Ok(CertificateFile::prove(
        title,
        SolutionWithin::derive(Equation::Stein, &points(a)?, &points(q)?, &parts, Some(&w))?,
    )?)
}
