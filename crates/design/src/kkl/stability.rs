//! Stability of the part of Lambda that must be stable: `P > 0` and `Lambda'P + P Lambda < 0`, for every Lambda over
//! the box. This is a statement about `e' = Lambda e`, which is the error of the observer if B does not depend on xi;
//! otherwise see [`coupling`](super::coupling).

use luenberger_linalg::{LinalgError, eigenvalues, lyapunov, symmetric_part};
use luenberger_proof::certificate::{Certificate, Certified, HurwitzStability};
use luenberger_proof::{Interval, Matrix, Ring};
use nalgebra::{Complex, DMatrix};

use super::error::KklError;
use crate::error::DesignError;
use luenberger_lmi::proof_matrix;

/// Stability of Lambda over the box.
#[derive(Debug, Clone, PartialEq)]
pub struct Stability {
    /// Lambda, entry by entry, over the box of states and inputs.
    pub lambda: Matrix<Interval>,
    /// The entries of xi that are only integrated: their rows and columns of Lambda are 0 on the whole box. They are
    /// what a [KKL+PEB]O estimates.
    pub integrated: Vec<usize>,
    /// Eigenvalues of the rest of Lambda, in the middle of the enclosure; the one with the largest real part first.
    pub eigenvalues: Vec<Complex<f64>>,
    /// For a diagonal rest, the interval of each entry of it over the box; else none. Negative entries are what
    /// Proposition 1 asks for.
    pub diagonal: Option<Vec<Interval>>,
    /// P, of the order of the rest; none where there is no rest, or no P for the middle.
    pub p: Option<DMatrix<f64>>,
    /// That the rest of Lambda is Hurwitz, with one P for every matrix in its enclosure; no theorem where there is no
    /// rest, or no P for the middle. It does not say that the enclosure is that of the design's Lambda.
    pub certificate: Certificate,
}

impl Certified for Stability {
    fn certificate(&self) -> &Certificate {
        &self.certificate
    }
}

impl Stability {
    /// The rest of Lambda: its rows and columns without those that are only integrated.
    pub fn rest(&self) -> Matrix<Interval> {
        let rest: Vec<usize> = (0..self.lambda.rows()).filter(|i| !self.integrated.contains(i)).collect();
        Matrix::from_fn(rest.len(), rest.len(), |i, j| self.lambda[(rest[i], rest[j])])
    }

    /// Whether the rest of Lambda is proved to forget: the solutions of `e' = Lambda e` decay exponentially, however
    /// Lambda moves in its enclosure.
    pub fn is_proved(&self) -> bool {
        let has_rest = self.integrated.len() < self.lambda.rows();
        !has_rest || self.certificate.is_proved()
    }
}

/// The eigenvalues of the middle of a matrix between bounds, the largest real part first, and the P that is to prove
/// all of it Hurwitz.
pub(crate) struct HurwitzAnalysis {
    pub(crate) spectrum: Vec<Complex<f64>>,
    pub(crate) p: Option<DMatrix<f64>>,
    /// The theorem, where there is a P.
    pub(crate) certificate: Certificate,
}

/// `P > 0` and `F'P + P F < 0`, for every F between the bounds, with P from the middle; and the eigenvalues of the
/// middle, the largest real part first. No theorem where the middle is not Hurwitz.
pub(crate) fn hurwitz(f: &Matrix<Interval>) -> Result<HurwitzAnalysis, DesignError> {
    let order = f.rows();
    let matrix = DMatrix::from_fn(order, order, |i, j| f[(i, j)].midpoint());
    let mut spectrum = eigenvalues(&matrix)?;
    spectrum.sort_by(|x, y| y.re.total_cmp(&x.re));
    if order == 0 || spectrum.first().is_some_and(|largest| largest.re >= 0.0) {
        return Ok(HurwitzAnalysis { spectrum, p: None, certificate: Certificate::default() });
    }
    let p = match lyapunov(&matrix, &DMatrix::identity(order, order)) {
        Ok(solution) => symmetric_part(&solution.p),
        // Hurwitz to rounding only.
        Err(LinalgError::SingularEquation { .. } | LinalgError::UndecidedEquation { .. }) => {
            return Ok(HurwitzAnalysis { spectrum, p: None, certificate: Certificate::default() });
        }
        Err(error) => return Err(error.into()),
    };
    let certificate = Certificate::of([HurwitzStability::within(f, &proof_matrix(&p))?])?;
    Ok(HurwitzAnalysis { spectrum, p: Some(p), certificate })
}

/// Stability of this Lambda.
pub(super) fn stability(lambda: Matrix<Interval>) -> Result<Stability, DesignError> {
    let order = lambda.rows();
    let nothing = |i: usize| (0..order).all(|j| lambda[(i, j)].is_zero() && lambda[(j, i)].is_zero());
    let (integrated, rest): (Vec<usize>, Vec<usize>) = (0..order).partition(|&i| nothing(i));
    let moving = Matrix::from_fn(rest.len(), rest.len(), |i, j| lambda[(rest[i], rest[j])]);
    let bounded = moving.as_slice().iter().all(Interval::is_bounded);
    let HurwitzAnalysis { spectrum: eigenvalues, p, certificate } = if rest.is_empty() || !bounded {
        HurwitzAnalysis { spectrum: Vec::new(), p: None, certificate: Certificate::default() }
    } else {
        hurwitz(&moving)?
    };
    let off_diagonal = |i: usize| (0..rest.len()).all(|j| i == j || moving[(i, j)].is_zero());
    let is_diagonal = !rest.is_empty() && (0..rest.len()).all(off_diagonal);
    let diagonal = is_diagonal.then(|| (0..rest.len()).map(|i| moving[(i, i)]).collect());
    Ok(Stability { lambda, integrated, eigenvalues, diagonal, p, certificate })
}

impl Stability {
    /// An error that names the eigenvalue, unless the whole of Lambda is proved stable.
    pub(super) fn required(&self) -> Result<(), KklError> {
        let zero = Complex::new(0.0, 0.0);
        if !self.integrated.is_empty() {
            return Err(KklError::NotHurwitz { what: "Lambda", eigenvalue: zero });
        }
        require_decay("Lambda", &self.eigenvalues, &self.certificate)
    }
}

/// The error of a matrix with this spectrum, the largest real part first, unless this proves it Hurwitz.
pub(crate) fn require_decay(
    what: &'static str,
    spectrum: &[Complex<f64>],
    certificate: &Certificate,
) -> Result<(), KklError> {
    let eigenvalue = spectrum.first().copied().unwrap_or(Complex::new(f64::NAN, f64::NAN));
    match certificate.facts().find(|fact| !fact.verdict.is_proved()) {
        Some(fact) => Err(KklError::HurwitzUndecided { what, eigenvalue, verdict: fact.verdict.clone() }),
        None if certificate.is_proved() => Ok(()),
        None => Err(KklError::NotHurwitz { what, eigenvalue }),
    }
}
