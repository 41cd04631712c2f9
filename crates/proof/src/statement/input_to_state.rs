//! Input-to-state stability of the linear and of the cubic observer, with explicit constants.
//!
//! Plant `x' = A x + B u + E w`, `y = C x + D w`; w contains the disturbances and the measurement noise,
//! `|w_i| <= W_i`. Observer `xhat' = A xhat + B u + L r - (r'theta r) N r`, `r = y - C xhat` (the sign of N is that of
//! the error equation below). With `F = A - LC`, `G = E - LD`, `q = r'theta r`, the error `e = x - xhat` obeys
//! ```text
//! e' = F e + G w + q N r,    r = C e + D w.
//! ```
//! Let `P > 0` and `P N = -C'S`, and let numbers `lambda`, `mu` (one for each w_i) and `kappa >= 0` satisfy
//! ```text
//! [F'P + PF + 2 alpha P, PG; *, -diag(lambda)] < 0,                                                       (linear)
//! theta >= 0,    theta <= kappa (S + S')/2,    [diag(mu), D'S; *, (S + S')/2] >= 0.                       (cubic)
//! ```
//! The linear part adds at most `-2 alpha V + sum lambda_i w_i^2` to `V'`, `V = e'Pe`. The cubic part adds
//! `2 q e'P N r = -2 q (r - Dw)'S r = -2 q a^2 + 2 q (Dw)'S r` with `a^2 = r'Sr`. The last block inequality is the
//! Cauchy-Schwarz inequality `|w'D'S r| <= s a` with `s^2 = sum mu_i w_i^2`, so that the cubic part is at most
//! `2 q a (s - a)`: negative where a > s, else at most `2 kappa a^3 (s - a) <= 27/128 kappa s^4`, attained at
//! `a = 3s/4`. Hence
//! ```text
//! V' <= -2 alpha V + beta,    beta = sum lambda_i W_i^2 + 27/128 kappa (sum mu_i W_i^2)^2,
//! ```
//! `V(t) <= exp(-2 alpha t) V(0) + U` for every `U >= beta/(2 alpha)`, and `limsup |e_i| <= b_i` for every b_i with
//! `b_i^2 P >= U 1_i 1_i'`, which is `b_i^2 >= U (P^-1)_ii` (1_i is the i-th unit vector). The linear inequality is
//! affine in (A, E): proved at the vertices of a polytope it holds on the convex hull, also for time-varying A and E.
//!
//! A stored N is a rounding of `-P^-1 C'S`. The matrix `P~ = C'XC + (I - T)(P - C'XC)(I - T)` of
//! [`deployed_cubic`](super::deployed_cubic) has `P~ N = -C'S~` with `S~ = -X C N` **exactly**: all inequalities are
//! decided for P~, which is enclosed, and S~. Without a cubic term P~ is P.
//!
//! In discrete time, `e+ = F e + G w` of the linear observer, `[q^2 P, 0, F'P; *, diag(lambda), G'P; *, *, P] > 0` and
//! `sum lambda_i W_i^2 <= (1 - q^2) U` take the places of the linear inequality and of the level: the head of
//! `certificate/theorem/discrete_input_to_state.rs`.

use super::deployed_cubic::{Dissipated, structured_for};
use super::{EXACT_ORDER, Expression, embed, embed_symmetric};
use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::{UndecidedReason, Verdict};

/// Error system: `e' = (A - LC)e + (E - LD)w + (r'theta r) N r`, `r = Ce + Dw`.
#[derive(Debug, Clone, Copy)]
pub struct DisturbedObserver<'a> {
    /// A n x n and E n x m at each vertex, as intervals.
    pub vertices: &'a [(Matrix<Interval>, Matrix<Interval>)],
    /// C, p x n.
    pub c: &'a Matrix<f64>,
    /// D, p x m.
    pub d: &'a Matrix<Interval>,
    /// L, n x p, as stored.
    pub l: &'a Matrix<f64>,
}

/// A cubic term with the constants of its bound.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicTerm {
    /// N, n x p, as stored, of full column rank.
    pub n: Matrix<f64>,
    /// theta, p x p, symmetric.
    pub theta: Matrix<f64>,
    /// X of P~, p x p, symmetric.
    pub x: Matrix<f64>,
    /// kappa >= 0.
    pub kappa: f64,
    /// mu, one number for each disturbance.
    pub mu: Vec<f64>,
}

/// The constants that prove a bound of the error.
#[derive(Debug, Clone, Copy)]
pub struct ErrorBound<'a> {
    /// P, n x n, symmetric.
    pub p: &'a Matrix<f64>,
    /// The rate alpha, positive; in discrete time the factor q, below 1.
    pub decay: f64,
    /// lambda, one number for each disturbance.
    pub lambda: &'a [f64],
    /// W: bounds of the disturbances, >= 0.
    pub disturbances: &'a [f64],
    /// U: ultimate bound of V, positive.
    pub level: f64,
    /// `b_i`: ultimate bounds of the components of the error, positive.
    pub limsup: &'a [f64],
}

/// Verdicts on the inequalities.
#[derive(Debug, Clone, PartialEq)]
pub struct InputToState {
    /// `P~ > 0`.
    pub positive: Verdict<Direction>,
    /// The linear inequality at each vertex.
    pub decrease: Vec<Verdict<Direction>>,
    /// With a cubic term: `theta >= 0`, `kappa (S~ + S~') - 2 theta >= 0`, `[2 diag(mu), 2 D'S~; *, S~ + S~'] >= 0`.
    pub cubic: Option<[Verdict<Direction>; 3]>,
    /// `256 rate level - 128 sum lambda_i W_i^2 - 27 kappa (sum mu_i W_i^2)^2 >= 0`.
    pub level: Verdict<Direction>,
    /// `b_i^2 P~ - level 1_i 1_i' > 0`, for each i.
    pub components: Vec<Verdict<Direction>>,
}

/// Bound of the error under bounded disturbances, for L, N and theta exactly as stored: see the head of this module.
///
/// ```
/// use luenberger_proof::{Interval, Matrix, statement::{DisturbedObserver, ErrorBound, input_to_state}};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // x' = w_1, y = x + w_2, xhat' = 2 (y - xhat): e' = -2 e + w_1 - 2 w_2, |w_1| <= 1, |w_2| <= 1/2, so |e| <= 1.
/// let point = |x: f64| Matrix::from_rows([[Interval::of(x)]]);
/// let one = Matrix::from_rows([[1.0]]);
/// let vertices = [(point(0.0), Matrix::from_rows([[Interval::of(1.0), Interval::of(0.0)]]))];
/// let d = Matrix::from_rows([[Interval::of(0.0), Interval::of(1.0)]]);
/// let l = Matrix::from_rows([[2.0]]);
/// let observer = DisturbedObserver { vertices: &vertices, c: &one, d: &d, l: &l };
/// let proved = |bound: f64| {
///     let limsup = [bound];
///     let numbers = ErrorBound {
///         p: &one, decay: 1.0, lambda: &[1.0001, 4.0001], disturbances: &[1.0, 0.5], level: 1.001, limsup: &limsup,
///     };
///     input_to_state(&observer, None, &numbers)
/// };
/// assert!(proved(1.01)?.components[0].is_proved() && proved(0.99)?.components[0].is_refuted());
/// # Ok(())
/// # }
/// ```
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or matrices that are not symmetric.
pub fn input_to_state(
    observer: &DisturbedObserver<'_>,
    cubic: Option<&CubicTerm>,
    bound: &ErrorBound<'_>,
) -> Result<InputToState, ProofError> {
    check(observer, bound)?;
    let (order, outputs, count) = (bound.p.rows(), observer.c.rows(), bound.disturbances.len());
    let metric = match cubic {
        None => Some(Matrix::<Interval>::embed(bound.p, "P")?),
        Some(term) => {
            embed::<Interval>(&term.n, "N", (order, outputs))?;
            embed_symmetric::<Interval>(&term.x, "X", outputs)?;
            embed_symmetric::<Interval>(&term.theta, "theta", outputs)?;
            structured_for(bound.p, observer.c, &term.x, &term.n)?
        }
    };
    let dissipation = cubic.map(|term| cubic_part(observer, term, count)).transpose()?;
    let Some(metric) = metric else {
        let unproved = || Verdict::Undecided { why: UndecidedReason::NotByThisMatrix { name: "P" }, best: f64::NAN };
        return Ok(InputToState {
            positive: unproved(),
            decrease: observer.vertices.iter().map(|_| unproved()).collect(),
            cubic: dissipation,
            level: level(cubic, bound).decide(Sense::PositiveSemidefinite)?,
            components: bound.limsup.iter().map(|_| unproved()).collect(),
        });
    };
    let mut decrease = Vec::with_capacity(observer.vertices.len());
    for (a, e) in observer.vertices {
        a.expect_shape("A", (order, order))?;
        e.expect_shape("E", (order, count))?;
        decrease.push(decided(&Decrease { metric: &metric, a, e, observer, bound }, Sense::NegativeDefinite)?);
    }
    Ok(InputToState {
        positive: decided(&Metric(&metric), Sense::PositiveDefinite)?,
        decrease,
        cubic: dissipation,
        level: level(cubic, bound).decide(Sense::PositiveSemidefinite)?,
        components: components(&metric, bound)?,
    })
}

/// The same in discrete time, of the linear observer: `level` is `(1 - q^2) level - sum lambda_i W_i^2 >= 0`.
///
/// ```
/// use luenberger_proof::{Interval, Matrix, statement::{DisturbedObserver, ErrorBound, input_to_state_in_steps}};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // x+ = x + w, y = x, xhat+ = xhat + (y - xhat)/2: e+ = e/2 + w, |w| <= 1, so |e| <= 2.
/// let one = Matrix::from_rows([[1.0]]);
/// let point = Matrix::from_rows([[Interval::of(1.0)]]);
/// let zero = Matrix::from_rows([[Interval::of(0.0)]]);
/// let (vertices, l) = ([(point.clone(), point)], Matrix::from_rows([[0.5]]));
/// let observer = DisturbedObserver { vertices: &vertices, c: &one, d: &zero, l: &l };
/// let proved = |bound: f64| {
///     let limsup = [bound];
///     // q^2 = 1/2, (q^2 - 1/4)(lambda - 1) > 1/4.
///     let numbers = ErrorBound {
///         p: &one, decay: 0.5f64.sqrt(), lambda: &[2.01], disturbances: &[1.0], level: 4.03, limsup: &limsup,
///     };
///     input_to_state_in_steps(&observer, &numbers)
/// };
/// assert!(proved(2.01)?.decrease[0].is_proved() && proved(2.01)?.components[0].is_proved());
/// assert!(proved(1.99)?.components[0].is_refuted());
/// # Ok(())
/// # }
/// ```
/// # Errors
/// As [`input_to_state`].
pub fn input_to_state_in_steps(
    observer: &DisturbedObserver<'_>,
    bound: &ErrorBound<'_>,
) -> Result<InputToState, ProofError> {
    check(observer, bound)?;
    let (order, count) = (bound.p.rows(), bound.disturbances.len());
    let metric = Matrix::<Interval>::embed(bound.p, "P")?;
    let mut decrease = Vec::with_capacity(observer.vertices.len());
    for (a, e) in observer.vertices {
        a.expect_shape("A", (order, order))?;
        e.expect_shape("E", (order, count))?;
        let step = Step { metric: &metric, a, e, observer, bound };
        decrease.push(decided(&step, Sense::PositiveDefinite)?);
    }
    Ok(InputToState {
        positive: decided(&Metric(&metric), Sense::PositiveDefinite)?,
        decrease,
        cubic: None,
        level: StepLevel(bound).decide(Sense::PositiveSemidefinite)?,
        components: components(&metric, bound)?,
    })
}

/// Shapes, but for those of the vertices.
fn check(observer: &DisturbedObserver<'_>, bound: &ErrorBound<'_>) -> Result<(), ProofError> {
    let (order, outputs, count) = (bound.p.rows(), observer.c.rows(), bound.disturbances.len());
    embed_symmetric::<Interval>(bound.p, "P", order)?;
    embed::<Interval>(observer.c, "C", (outputs, order))?;
    embed::<Interval>(observer.l, "L", (order, outputs))?;
    observer.d.expect_shape("D", (outputs, count))?;
    for (what, length, expected) in [("lambda", bound.lambda.len(), count), ("the bounds", bound.limsup.len(), order)] {
        if length != expected {
            return Err(ProofError::DimensionMismatch { what, expected: (expected, 1), found: (length, 1) });
        }
    }
    Ok(())
}

/// The bounds of the components of e.
fn components(metric: &Matrix<Interval>, bound: &ErrorBound<'_>) -> Result<Vec<Verdict<Direction>>, ProofError> {
    let component = |(row, &limsup): (usize, &f64)| {
        decided(&Component { metric, row, limsup, level: bound.level }, Sense::PositiveDefinite)
    };
    bound.limsup.iter().enumerate().map(component).collect()
}

/// The three inequalities of the cubic term.
fn cubic_part(
    observer: &DisturbedObserver<'_>,
    term: &CubicTerm,
    count: usize,
) -> Result<[Verdict<Direction>; 3], ProofError> {
    if term.mu.len() != count {
        let (expected, found) = ((count, 1), (term.mu.len(), 1));
        return Err(ProofError::DimensionMismatch { what: "mu", expected, found });
    }
    Ok([
        definite::decide(&term.theta, Sense::PositiveSemidefinite)?,
        Dominated { term, c: observer.c }.decide(Sense::PositiveSemidefinite)?,
        decided(&NoisePart { term, observer }, Sense::PositiveSemidefinite)?,
    ])
}

/// A ring that contains data given as intervals.
trait Data: Ring {
    fn datum(x: &Interval) -> Option<Self>;
}

impl Data for Interval {
    fn datum(x: &Interval) -> Option<Self> {
        Some(*x)
    }
}

/// Only point intervals are exact numbers.
impl Data for Exact {
    fn datum(x: &Interval) -> Option<Self> {
        if x.is_point() { Self::from_f64(x.lo()) } else { None }
    }
}

fn data<R: Data>(m: &Matrix<Interval>) -> Option<Matrix<R>> {
    let entries = m.as_slice().iter().map(R::datum).collect::<Option<Vec<R>>>()?;
    Matrix::from_row_major(m.rows(), m.cols(), entries).ok()
}

/// A symmetric matrix as an expression in interval data; `None` if the ring does not contain the data.
trait Form {
    fn evaluate<R: Data>(&self) -> Result<Option<Matrix<R>>, ProofError>;
}

fn decided(form: &impl Form, sense: Sense) -> Result<Verdict<Direction>, ProofError> {
    let why = UndecidedReason::Overflow;
    let Some(enclosed) = form.evaluate::<Interval>()? else { return Ok(Verdict::Undecided { why, best: f64::NAN }) };
    let verdict = definite::decide(&enclosed, sense)?;
    if matches!(verdict, Verdict::Undecided { .. })
        && enclosed.rows() <= EXACT_ORDER
        && let Some(exact) = form.evaluate::<Exact>()?
    {
        return definite::decide(&exact, sense);
    }
    Ok(verdict)
}

struct Metric<'a>(&'a Matrix<Interval>);

impl Form for Metric<'_> {
    fn evaluate<R: Data>(&self) -> Result<Option<Matrix<R>>, ProofError> {
        Ok(data(self.0))
    }
}

/// `[F'P + PF + 2 rate P, PG; *, -diag(lambda)]`.
struct Decrease<'a> {
    metric: &'a Matrix<Interval>,
    a: &'a Matrix<Interval>,
    e: &'a Matrix<Interval>,
    observer: &'a DisturbedObserver<'a>,
    bound: &'a ErrorBound<'a>,
}

impl Form for Decrease<'_> {
    fn evaluate<R: Data>(&self) -> Result<Option<Matrix<R>>, ProofError> {
        let (Some(p), Some(a), Some(e), Some(d)) =
            (data::<R>(self.metric), data::<R>(self.a), data::<R>(self.e), data::<R>(self.observer.d))
        else {
            return Ok(None);
        };
        let (l, c) = (Matrix::<R>::embed(self.observer.l, "L")?, Matrix::<R>::embed(self.observer.c, "C")?);
        let rate = super::number::<R>(self.bound.decay, "the rate")?;
        let f = a.difference(&l.product(&c)?)?.sum(&Matrix::scalar(p.rows(), &rate))?;
        let corner = p.product(&e.difference(&l.product(&d)?)?)?;
        let last = diagonal::<R>(self.bound.lambda, "lambda")?.negative();
        Ok(Some(p.product(&f)?.plus_transpose()?.bordered(&corner, &last)?))
    }
}

/// `[q^2 P, 0, F'P; *, diag(lambda), G'P; *, *, P]`.
struct Step<'a> {
    metric: &'a Matrix<Interval>,
    a: &'a Matrix<Interval>,
    e: &'a Matrix<Interval>,
    observer: &'a DisturbedObserver<'a>,
    bound: &'a ErrorBound<'a>,
}

impl Form for Step<'_> {
    fn evaluate<R: Data>(&self) -> Result<Option<Matrix<R>>, ProofError> {
        let (Some(p), Some(a), Some(e), Some(d)) =
            (data::<R>(self.metric), data::<R>(self.a), data::<R>(self.e), data::<R>(self.observer.d))
        else {
            return Ok(None);
        };
        let (l, c) = (Matrix::<R>::embed(self.observer.l, "L")?, Matrix::<R>::embed(self.observer.c, "C")?);
        let factor = super::number::<R>(self.bound.decay, "the factor")?;
        let flow = p.product(&a.difference(&l.product(&c)?)?)?;
        let driven = p.product(&e.difference(&l.product(&d)?)?)?;
        let nothing = Matrix::from_fn(p.rows(), e.cols(), |_, _| R::zero());
        let first = p.scaled(&factor.mul(&factor)).bordered(&nothing, &diagonal::<R>(self.bound.lambda, "lambda")?)?;
        let (n, m) = e.shape();
        let corner =
            Matrix::from_fn(n + m, n, |i, j| if i < n { flow[(j, i)].clone() } else { driven[(j, i - n)].clone() });
        Ok(Some(first.bordered(&corner, &p)?))
    }
}

fn diagonal<R: Ring>(entries: &[f64], what: &'static str) -> Result<Matrix<R>, ProofError> {
    let entries = entries.iter().map(|x| super::number::<R>(*x, what)).collect::<Result<Vec<R>, _>>()?;
    Ok(Matrix::from_fn(entries.len(), entries.len(), |i, j| if i == j { entries[i].clone() } else { R::zero() }))
}

/// `limsup^2 P - level 1_i 1_i'`.
struct Component<'a> {
    metric: &'a Matrix<Interval>,
    row: usize,
    limsup: f64,
    level: f64,
}

impl Form for Component<'_> {
    fn evaluate<R: Data>(&self) -> Result<Option<Matrix<R>>, ProofError> {
        let Some(p) = data::<R>(self.metric) else { return Ok(None) };
        let limsup = super::number::<R>(self.limsup, "limsup")?;
        let mut m = p.scaled(&limsup.mul(&limsup));
        let entry = m[(self.row, self.row)].sub(&super::number(self.level, "the level")?);
        m[(self.row, self.row)] = entry;
        Ok(Some(m))
    }
}

/// `kappa (S~ + S~') - 2 theta`.
struct Dominated<'a> {
    term: &'a CubicTerm,
    c: &'a Matrix<f64>,
}

impl Expression for Dominated<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let s = Dissipated { x: &self.term.x, c: self.c, n: &self.term.n }.evaluate::<R>()?;
        let theta = Matrix::<R>::embed(&self.term.theta, "theta")?;
        s.scaled(&super::number(self.term.kappa, "kappa")?).difference(&theta.sum(&theta)?)
    }
}

/// `[2 diag(mu), 2 D'S~; *, S~ + S~']`.
struct NoisePart<'a> {
    term: &'a CubicTerm,
    observer: &'a DisturbedObserver<'a>,
}

impl Form for NoisePart<'_> {
    fn evaluate<R: Data>(&self) -> Result<Option<Matrix<R>>, ProofError> {
        let Some(d) = data::<R>(self.observer.d) else { return Ok(None) };
        let CubicTerm { n, x, mu, .. } = self.term;
        let image = Matrix::<R>::embed(self.observer.c, "C")?.product(&Matrix::embed(n, "N")?)?;
        let s = Matrix::<R>::embed(x, "X")?.product(&image)?.negative();
        let corner = d.transpose().product(&s)?;
        let first = diagonal::<R>(mu, "mu")?;
        Ok(Some(first.sum(&first)?.bordered(&corner.sum(&corner)?, &s.plus_transpose()?)?))
    }
}

/// `256 rate level - 128 sum lambda_i W_i^2 - 27 kappa (sum mu_i W_i^2)^2`, 1 x 1.
struct Level<'a> {
    cubic: Option<&'a CubicTerm>,
    bound: &'a ErrorBound<'a>,
}

fn level<'a>(cubic: Option<&'a CubicTerm>, bound: &'a ErrorBound<'a>) -> Level<'a> {
    Level { cubic, bound }
}

impl Expression for Level<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let number = |x: f64| super::number::<R>(x, "the level");
        let weighted = |weights: &[f64]| squares::<R>(weights, self.bound.disturbances);
        let reached = number(256.0)?.mul(&number(self.bound.decay)?.mul(&number(self.bound.level)?));
        let mut spent = number(128.0)?.mul(&weighted(self.bound.lambda)?);
        if let Some(term) = self.cubic {
            let square = weighted(&term.mu)?;
            spent = spent.add(&number(27.0)?.mul(&number(term.kappa)?.mul(&square.mul(&square))));
        }
        Matrix::from_row_major(1, 1, vec![reached.sub(&spent)])
    }
}

/// `sum weight_i W_i^2`.
fn squares<R: Ring>(weights: &[f64], bounds: &[f64]) -> Result<R, ProofError> {
    let number = |x: f64| super::number::<R>(x, "the level");
    let mut sum = R::zero();
    for (weight, w) in weights.iter().zip(bounds) {
        let w = number(*w)?;
        sum = sum.add(&number(*weight)?.mul(&w.mul(&w)));
    }
    Ok(sum)
}

/// `(1 - q^2) level - sum lambda_i W_i^2`, 1 x 1.
struct StepLevel<'a>(&'a ErrorBound<'a>);

impl Expression for StepLevel<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let (number, bound) = (|x: f64| super::number::<R>(x, "the level"), self.0);
        let factor = number(bound.decay)?;
        let kept = number(1.0)?.sub(&factor.mul(&factor)).mul(&number(bound.level)?);
        let spent = squares::<R>(bound.lambda, bound.disturbances)?;
        Matrix::from_row_major(1, 1, vec![kept.sub(&spent)])
    }
}
