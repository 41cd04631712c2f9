//! Invariant zeros of a plant `x' = A x + B u, y = C x + D u`, and its normal rank.
//!
//! `S(lambda) = [A - lambda I, B; C, D]` has the rank `n + r` for almost every lambda, r the normal rank of
//! `C (lambda I - A)^-1 B + D`. The invariant zeros are the finite lambda with a smaller rank: for an initial state x0
//! and an input `u0 e^{lambda t}` the state is `x0 e^{lambda t}` and y = 0. They comprise the transmission zeros and
//! the uncontrollable or unobservable modes (all of these if the plant is square and not degenerate). Neither `A - B K`
//! nor `A - L C` moves them; with high gain, closed-loop poles tend to them, and they are poles of an unknown-input
//! observer.
//!
//! Method: Emami-Naeini and Van Dooren, Automatica 18, 1982 (SLICOT AB08ND). States that zero outputs force to zero for
//! every input are removed until D has full row rank; then the same for the transposed plant until D is square and
//! regular. All steps are orthogonal, ranks are found by QR with column pivoting. The zeros are the generalised
//! eigenvalues of the remaining pencil, by the QZ method (faer) or, if that fails, by the Schur form of `E^-1 A`.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::ComputeEigenvectors;
use faer::linalg::gevd::{GevdParams, gevd_real, gevd_scratch};
use faer::{Auto, Mat, Par, Spec};
use nalgebra::{Complex, DMatrix};

use crate::argument::{RealMatrixView, owned};
use crate::observability::default_tolerance;
use crate::rosenbrock::Rosenbrock;
use crate::spectrum::eigenvalues;
use crate::staircase::compress_rows;
use crate::units::shift;
use crate::{LinalgError, Result};

/// The finite invariant zeros of `(A, B, C, D)`.
#[derive(Debug, Clone, PartialEq)]
pub struct InvariantZeros {
    /// The zeros, each as often as its algebraic multiplicity; complex ones in conjugate pairs.
    pub zeros: Vec<Complex<f64>>,
    /// For each zero `sigma_{n+r}(S(zero)) / (|S(0)| + |zero|)` in balanced units (Frobenius norm): zero for an exact
    /// loss of rank.
    pub residuals: Vec<f64>,
    /// r: rank of the transfer function `C (s I - A)^-1 B + D` for almost every s.
    pub normal_rank: usize,
    /// Number of inputs.
    pub inputs: usize,
    /// Number of outputs.
    pub outputs: usize,
    /// The relative tolerance of the rank decisions.
    pub tolerance: f64,
}

impl InvariantZeros {
    /// Whether the pencil `S(lambda)` is degenerate: its rank is not full for any lambda. Then a nonzero combination of
    /// the inputs has no effect on the outputs, and a nonzero combination of the outputs does not depend on the inputs.
    pub fn is_degenerate(&self) -> bool {
        self.normal_rank < self.inputs.min(self.outputs)
    }

    /// Whether every zero has a negative real part: a minimum phase plant in continuous time.
    pub fn is_minimum_phase(&self) -> bool {
        self.zeros.iter().all(|z| z.re < 0.0)
    }
}

/// Invariant zeros of `x' = A x + B u, y = C x + D u`, or of `x+ = A x + B u`: the lambda for which
/// `[A - lambda I, B; C, D]` loses rank.
///
/// `a` is n x n, `b` n x m, `c` p x n, `d` p x m (zero for a plant without feedthrough). m = 0 or p = 0 is allowed: the
/// zeros are then the unobservable (for p = 0 the uncontrollable) modes. Ranks are determined with the relative
/// tolerance `10 max(n + m, n + p) eps` in balanced units, see [`mod@crate::observability`].
///
/// A degenerate pencil is no error: its zeros are the lambda at which the rank is below the normal rank, and
/// [`InvariantZeros::is_degenerate`] is true.
///
/// # Errors
/// [`LinalgError::NotSquare`], [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], [`LinalgError::Empty`]
/// (no state); [`LinalgError::NotConverged`] if an iteration for eigenvalues or singular values does not converge;
/// [`LinalgError::Overflow`] if a zero overflows.
///
/// # Cost
/// `O((n + m) (n + p) n)` for the reduction, `66 k^3` for k zeros, and the singular values of one matrix of order
/// `n + max(m, p)` for each zero and its residual.
///
/// # Example
/// `(s - 1) / ((s + 2)(s + 3))`.
/// ```
/// use luenberger_linalg::invariant_zeros;
/// use nalgebra::dmatrix;
///
/// let (a, b, c, d) = (dmatrix![0.0, 1.0; -6.0, -5.0], dmatrix![0.0; 1.0], dmatrix![-1.0, 1.0], dmatrix![0.0]);
/// let found = invariant_zeros(&a, &b, &c, &d)?;
/// println!("zero {}, residual {:e}, normal rank {}", found.zeros[0], found.residuals[0], found.normal_rank);
/// assert!((found.zeros[0] - 1.0).norm() < 1e-14 && found.residuals[0] < 1e-15);
/// assert!(!found.is_minimum_phase());
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Emami-Naeini and Van Dooren, Automatica 18, 1982; Svaricek, IEEE TAC 30, 1985, for the normal rank.
pub fn invariant_zeros<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    d: impl Into<RealMatrixView<'a>>,
) -> Result<InvariantZeros> {
    zeros_of(&owned(a), &owned(b), &owned(c), &owned(d))
}

fn zeros_of(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>, d: &DMatrix<f64>) -> Result<InvariantZeros> {
    let scaled = Rosenbrock::new(a, b, c, d)?;
    let (n, m, p) = (a.nrows(), b.ncols(), c.nrows());
    let tolerance = default_tolerance(n + m, n + p);
    let floor = tolerance * scaled.size;
    let whole = System { a: scaled.a.clone(), b: scaled.b.clone(), c: scaled.c.clone(), d: scaled.d.clone() };
    let core = whole.without_forced_states(floor).dual().without_forced_states(floor).dual();
    let normal_rank = core.d.nrows();
    let mut zeros = core.zeros_of_regular_feedthrough()?;
    let mut residuals: Vec<f64> = Vec::with_capacity(zeros.len());
    for (k, zero) in zeros.iter().enumerate() {
        let twin =
            if k > 0 && zero.im != 0.0 && zeros[k - 1] == zero.conj() { residuals.last().copied() } else { None };
        residuals.push(match twin {
            Some(residual) => residual,
            None => residual(&scaled, *zero, n + normal_rank)?,
        });
    }
    for zero in &mut zeros {
        *zero = Complex::new(shift(zero.re, scaled.time()), shift(zero.im, scaled.time()));
        if !(zero.re.is_finite() && zero.im.is_finite()) {
            return Err(LinalgError::Overflow { what: "an invariant zero" });
        }
    }
    Ok(InvariantZeros { zeros, residuals, normal_rank, inputs: m, outputs: p, tolerance })
}

/// Relative residual `sigma_rank(S(zero)) / (|S(0)| + |zero|)`.
fn residual(system: &Rosenbrock, zero: Complex<f64>, rank: usize) -> Result<f64> {
    let (n, m, p) = (system.a.nrows(), system.b.ncols(), system.c.nrows());
    let entry = |i: usize, j: usize| match (i < n, j < n) {
        (true, true) => Complex::from(system.a[(i, j)]) - if i == j { zero } else { Complex::from(0.0) },
        (true, false) => Complex::from(system.b[(i, j - n)]),
        (false, true) => Complex::from(system.c[(i - n, j)]),
        (false, false) => Complex::from(system.d[(i - n, j - n)]),
    };
    let sigma = Mat::from_fn(n + p, n + m, entry).singular_values().map_err(|_| LinalgError::NotConverged {
        method: "singular values of the system matrix",
        iterations: 0,
        remaining: f64::NAN,
        allowed: f64::EPSILON * system.size,
    })?;
    let size = system.size + zero.norm();
    let at = rank.checked_sub(1).and_then(|k| sigma.get(k)).copied().unwrap_or(0.0);
    Ok(if size > 0.0 { at / size } else { 0.0 })
}

/// The plant during the reduction.
struct System {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
}

impl System {
    fn dual(&self) -> Self {
        Self { a: self.a.transpose(), b: self.c.transpose(), c: self.b.transpose(), d: self.d.transpose() }
    }

    /// Reduction to D of full row rank, with the same zeros and the same normal rank.
    ///
    /// Outputs without feedthrough, `0 = C2 x`, force the states they contain to zero; the derivatives of those states
    /// are then outputs, `0 = A21 x + B2 u`. Each pass removes at least one state.
    fn without_forced_states(mut self, floor: f64) -> Self {
        loop {
            let Self { a, b, c, d } = &mut self;
            let fed = compress_rows(d, floor, |reflection, row| reflection.act_on_rows(c, row));
            let (n, m, p) = (a.nrows(), b.ncols(), c.nrows());
            let mut unfed = c.rows(fed, p - fed).transpose();
            let mut rest = c.rows(0, fed).into_owned();
            let forced = compress_rows(&mut unfed, floor, |reflection, row| {
                reflection.act_on_rows(a, row);
                reflection.act_on_columns(a, row);
                reflection.act_on_rows(b, row);
                reflection.act_on_columns(&mut rest, row);
            });
            let left = n - forced;
            let mut outputs = DMatrix::zeros(fed + forced, left);
            outputs.rows_mut(0, fed).copy_from(&rest.columns(forced, left));
            outputs.rows_mut(fed, forced).copy_from(&a.view((0, forced), (forced, left)));
            let mut feedthrough = DMatrix::zeros(fed + forced, m);
            feedthrough.rows_mut(0, fed).copy_from(&d.rows(0, fed));
            feedthrough.rows_mut(fed, forced).copy_from(&b.rows(0, forced));
            self = Self {
                a: a.view((forced, forced), (left, left)).into_owned(),
                b: b.rows(forced, left).into_owned(),
                c: outputs,
                d: feedthrough,
            };
            if forced == 0 {
                return self;
            }
        }
    }

    /// Zeros if D is square and regular: with `[C D] W = [R 0]`, W orthogonal, they satisfy
    /// `(A W1 + B W2) v = lambda W1 v`.
    fn zeros_of_regular_feedthrough(&self) -> Result<Vec<Complex<f64>>> {
        let (n, r) = (self.a.nrows(), self.d.nrows());
        if n == 0 {
            return Ok(Vec::new());
        }
        let mut rows = DMatrix::zeros(n + r, r);
        rows.rows_mut(0, n).copy_from(&self.c.transpose());
        rows.rows_mut(n, r).copy_from(&self.d.transpose());
        let mut pencil = DMatrix::zeros(2 * n, n + r);
        pencil.view_mut((0, 0), (n, n)).copy_from(&self.a);
        pencil.view_mut((0, n), (n, r)).copy_from(&self.b);
        pencil.view_mut((n, 0), (n, n)).fill_with_identity();
        compress_rows(&mut rows, 0.0, |reflection, row| reflection.act_on_columns(&mut pencil, row));
        generalised_eigenvalues(&pencil.view((0, r), (n, n)).into_owned(), &pencil.view((n, r), (n, n)).into_owned())
    }
}

/// Below this order faer's QZ takes its unblocked path; the blocked one does not converge on some pencils of order 76
/// to 100.
const UNBLOCKED: usize = 400;

/// Eigenvalues of the pencil, `det(A - lambda E) = 0`, E regular.
///
/// If QZ does not converge or returns an infinite eigenvalue (observed at order 90, although E is regular), the
/// eigenvalues of `E^-1 A` are used. They suffer from the condition of E; the residuals show it.
fn generalised_eigenvalues(a: &DMatrix<f64>, e: &DMatrix<f64>) -> Result<Vec<Complex<f64>>> {
    if let Some(found) = qz(a, e) {
        return Ok(found);
    }
    let quotient = e.clone().lu().solve(a).filter(|m| m.iter().all(|x| x.is_finite()));
    eigenvalues(&quotient.ok_or(LinalgError::Overflow { what: "an invariant zero" })?)
}

/// Eigenvalues by faer's QZ; `None` if it does not converge or an eigenvalue is infinite.
fn qz(a: &DMatrix<f64>, e: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    let n = a.nrows();
    let (mut left, mut right) = (Mat::from_fn(n, n, |i, j| a[(i, j)]), Mat::from_fn(n, n, |i, j| e[(i, j)]));
    let (mut re, mut im, mut beta) = (Diag::<f64>::zeros(n), Diag::<f64>::zeros(n), Diag::<f64>::zeros(n));
    let mut params = <GevdParams as Auto<f64>>::auto();
    params.schur.blocking_threshold = UNBLOCKED.max(params.schur.blocking_threshold);
    let params: Spec<GevdParams, f64> = Spec::new(params);
    let none = ComputeEigenvectors::No;
    let mut memory = MemBuffer::new(gevd_scratch::<f64>(n, none, none, Par::Seq, params));
    gevd_real(
        left.as_mut(),
        right.as_mut(),
        re.as_mut(),
        im.as_mut(),
        beta.as_mut(),
        None,
        None,
        Par::Seq,
        MemStack::new(&mut memory),
        params,
    )
    .ok()?;
    let (re, im, beta) = (re.column_vector(), im.column_vector(), beta.column_vector());
    let mut found = Vec::with_capacity(n);
    for k in 0..n {
        let zero = Complex::new(re[k] / beta[k], im[k] / beta[k]);
        if !(zero.re.is_finite() && zero.im.is_finite()) {
            return None;
        }
        // The two eigenvalues of a pair have separate betas: the upper one defines both, so that they are exact
        // conjugates.
        if zero.im > 0.0 {
            found.extend([zero, zero.conj()]);
        } else if zero.im == 0.0 {
            found.push(zero);
        }
    }
    (found.len() == n).then_some(found)
}
