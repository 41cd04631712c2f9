//! The cubic observer of least cost for given noise and a given set of first errors, beside the linear optimum.
//!
//! Plant `x' = A x + B u + w`, `y = C x + v`; v and w are constant over periods h, independent from period to period, v
//! of standard deviations sigma, w of covariance W/h. The first errors are the ellipsoid `e = diag(d) s`, |s| = 1. With
//! a weight T >= 0 and a horizon tau
//! ```text
//! J = mean over e(0) of int_0^inf e'Te dt, without noise,  +  tau E e'Te in the long run, from e(0) = 0.
//! ```
//! It is the cost of a run of length tau from a first error, except for what first error and noise do together.
//!
//! **The linear part is convex.** For N = 0 and h -> 0, `J = trace(T Z)` with `F Z + Z F' + diag(d)^2/n + tau (W + L V
//! L') = 0`, `V = h diag(sigma)^2`: tau times the covariance of a filter for process noise `W + diag(d)^2/(n tau)`. Its
//! minimum is Kalman's gain, one gain for every T. For h > 0, J has a closed form; a descent from Kalman's gain
//! corrects for the period.
//!
//! **The cubic part is not.** No bound of J by a quadratic V shows what the cubic term saves: it adds `-2 (r'theta r)
//! r'Sr <= 0` to V', which is 0 where `C e = 0`, asks for `PN = -C'S`, and adds to the effect of noise, so that the
//! optimum of such a bound is N = 0. J itself is evaluated: the transient by quadrature over the ellipsoid (exact for
//! the linear observer), the effect of noise along one fixed sequence, beside that of the linear observer on it.
//! The search has no claim to a global optimum; its starts and steps are fixed, so that it gives the same answer every
//! time. N = 0 is the answer where no cubic term is better by a thousandth, under noise that the search has not seen.

pub(crate) mod cost;
mod flow;
mod search;

use luenberger_clock::Instant;
use luenberger_linalg::{RealMatrixView, spectral_abscissa};
use luenberger_observers::CubicObserver;
use luenberger_plants::StateSpace;
use luenberger_random::{Draws, Purpose, Stream};
use nalgebra::{DMatrix, DVector, Dyn};

pub use self::cost::Cost;
use self::cost::{Noise, Scaled, directions};
use self::flow::Gains;
use self::search::{Budget, Point};
use crate::certificate::certified;
use crate::check;
use crate::cubic::{CubicDesign, CubicGain};
use crate::error::DesignError;
use crate::linear::{LinearDesign, LyapunovWeight};
use luenberger_proof::certificate::Certificate;
use luenberger_proof::wording::rounded;

/// The estimation problem of an optimal observer: initial errors, noise, horizon and weight.
#[derive(Debug, Clone, PartialEq)]
pub struct EstimationProblem {
    /// d, the semi-axes of the ellipsoid of first errors, n positive numbers.
    pub first_errors: Vec<f64>,
    /// sigma, standard deviations of the measurement noise, p positive numbers.
    pub noise: Vec<f64>,
    /// Whether the measurement noise is uniform; else it is Gaussian.
    pub is_uniform: bool,
    /// h, the time for which a value of the noise is held.
    pub period: f64,
    /// W, intensity of the process noise, n x n.
    pub process: DMatrix<f64>,
    /// tau, the time of operation after an initial error.
    pub horizon: f64,
    /// T, n x n, positive semidefinite and not 0.
    pub weight: DMatrix<f64>,
}

/// Evaluations of J for each coordinate and each start.
const EVALUATIONS: usize = 100;
/// The answer is judged along a sequence that is longer by this factor.
const LONGER: f64 = 5.0;
/// Savings below this fraction are not counted.
const LEAST_SAVING: f64 = 1e-3;

/// The draws along which an answer is judged.
fn judged_along(seed: u64) -> Draws {
    Stream::new(seed, Purpose::JudgedCost, 0).draws(0)
}

impl EstimationProblem {
    /// Measurement noise only, Gaussian, with T the identity in units of the first errors: `e'Te = sum (e_i/d_i)^2`.
    pub fn new(first_errors: &[f64], noise: &[f64], period: f64, horizon: f64) -> Self {
        let n = first_errors.len();
        let weight = DVector::from_iterator(n, first_errors.iter().map(|d| 1.0 / (d * d)));
        Self {
            first_errors: first_errors.to_vec(),
            noise: noise.to_vec(),
            is_uniform: false,
            period,
            process: DMatrix::zeros(n, n),
            horizon,
            weight: DMatrix::from_diagonal(&weight),
        }
    }

    /// J of the linear observer of gain L, in closed form.
    ///
    /// ```
    /// use luenberger_design::EstimationProblem;
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::dmatrix;
    /// // x' = 0, y = x + v: the transient is d^2/(2 l), and for short periods the variance sigma^2 h l/2.
    /// let plant = StateSpace::new(dmatrix![0.0], nalgebra::DMatrix::zeros(1, 0), dmatrix![1.0])?;
    /// let problem = EstimationProblem { weight: dmatrix![1.0], ..EstimationProblem::new(&[2.0], &[0.1], 1e-4, 50.0) };
    /// let cost = problem.linear(&plant, &dmatrix![3.0])?;
    /// assert!((cost.transient - 4.0 / 6.0).abs() < 1e-12);
    /// assert!((cost.mean_square - 0.01 * 1e-4 * 1.5).abs() < 1e-3 * cost.mean_square);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`DesignError::NotHurwitz`] for a gain that does not stabilise; numbers and shapes that do not fit.
    pub fn linear<'a>(&self, plant: &StateSpace, l: impl Into<RealMatrixView<'a>>) -> Result<Cost, DesignError> {
        let l = &check::owned(l);
        let scaled = self.scaled(plant)?;
        check::matrix("L", l, (plant.a.nrows(), plant.c.nrows()))?;
        check::hurwitz("A - L C", (&plant.a, l, &plant.c))?;
        scaled.linear(&self.gain_in_units(l)).ok_or_else(too_fast)
    }

    /// J of a cubic observer along one sequence of noise: the seed chooses it. None is that of the search; seed 0 has
    /// the one along which the answer of a search is judged.
    ///
    /// # Errors
    /// As [`linear`](Self::linear); [`DesignError::Undecided`] where the error changes too fast for the integration.
    pub fn cubic(&self, observer: &CubicObserver<f64, Dyn, Dyn, Dyn>, seed: u64) -> Result<Cost, DesignError> {
        let plant = observer.plant();
        let scaled = self.scaled(&plant)?;
        let slowest = -check::hurwitz("A - L C", (&plant.a, &observer.l, &plant.c))?;
        let noise = Noise::new(&scaled, slowest, LONGER, judged_along(seed)).judging();
        let gains = self.gains_in_units((&observer.l, &observer.n, &observer.theta));
        scaled.cubic(&gains, &directions(plant.a.nrows()), &noise, f64::INFINITY).ok_or_else(too_fast)
    }

    /// The problem in units of the first errors and of the noise.
    fn scaled(&self, plant: &StateSpace) -> Result<Scaled, DesignError> {
        check::plant(plant)?;
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let row = |x: &[f64]| DMatrix::from_row_slice(1, x.len(), x);
        check::matrix("the first errors", &row(&self.first_errors), (1, n))?;
        check::matrix("the standard deviations of the noise", &row(&self.noise), (1, p))?;
        for d in &self.first_errors {
            check::positive("a first error", *d)?;
        }
        for sigma in &self.noise {
            check::positive("the standard deviation of the noise of an output", *sigma)?;
        }
        check::positive("the period of the noise", self.period)?;
        check::positive("the horizon", self.horizon)?;
        let process = check::positive_semidefinite("W", &self.process, n)?;
        let weight = check::positive_semidefinite("T", &self.weight, n)?;
        check::positive("the trace of T", weight.trace())?;
        let (d, sigma) = (&self.first_errors, &self.noise);
        let in_units = |m: &DMatrix<f64>, left: &dyn Fn(usize) -> f64, right: &dyn Fn(usize) -> f64| {
            DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| left(i) * m[(i, j)] * right(j))
        };
        let by_d = |i: usize| 1.0 / d[i];
        Ok(Scaled {
            a: in_units(&plant.a, &by_d, &|j| d[j]),
            c: in_units(&plant.c, &|i| 1.0 / sigma[i], &|j| d[j]),
            weight: in_units(&weight, &|i| d[i], &|j| d[j]),
            process: in_units(&process, &by_d, &by_d),
            horizon: self.horizon,
            period: self.period,
            uniform: self.is_uniform,
        })
    }

    /// An n x p gain in the units of the problem.
    fn gain_in_units(&self, l: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(l.nrows(), l.ncols(), |i, j| l[(i, j)] * self.noise[j] / self.first_errors[i])
    }

    fn gains_in_units(&self, (l, n, theta): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>)) -> Gains {
        let theta =
            DMatrix::from_fn(theta.nrows(), theta.ncols(), |i, j| theta[(i, j)] * self.noise[i] * self.noise[j]);
        Gains { l: self.gain_in_units(l), n: self.gain_in_units(n), theta }
    }

    /// The same in the units of the plant, with few digits: what is stored is what is printed.
    fn gain_of_plant(&self, l: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(l.nrows(), l.ncols(), |i, j| rounded(l[(i, j)] * self.first_errors[i] / self.noise[j], 6))
    }
}

fn too_fast() -> DesignError {
    DesignError::Undecided {
        what: "the cost of an observer whose error changes too fast for its integration,",
        why: luenberger_proof::UndecidedReason::NotByThisMatrix { name: "L" },
        best: f64::NAN,
        seen: None,
    }
}

certified!(OptimalCubicDesign);

/// The observer of least cost that the search found, with its certificate, beside the linear optimum.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct OptimalCubicDesign {
    /// L with its Lyapunov pair: the linear part of the cubic observer, or the linear optimum where that is the answer.
    pub linear: LinearDesign,
    /// The cubic observer; none where no cubic term is better than the linear optimum.
    pub cubic: Option<CubicDesign>,
    /// Its cost, under noise that the search has not seen.
    pub cost: Cost,
    /// The gain of the linear optimum, n x p.
    pub linear_gain: DMatrix<f64>,
    /// The cost of the linear optimum, in closed form.
    pub linear_cost: Cost,
    /// Kalman's gain, from which the linear optimum was found: the optimum for short periods of the noise.
    pub kalman_gain: DMatrix<f64>,
    /// Its cost.
    pub kalman_cost: Cost,
    /// How many cubic observers the search evaluated.
    pub evaluations: usize,
    /// The certificate of the observer.
    pub certificate: Certificate,
}

impl OptimalCubicDesign {
    /// The optimum of `problem`. Stops at the instant `end`, with an error.
    ///
    /// Cost: some hundred evaluations of J for n = 2, each along up to 4000 periods of the noise; at most 100 for each
    /// entry of L, Q, S and theta and each of two starts.
    ///
    /// ```
    /// use luenberger_design::{EstimationProblem, OptimalCubicDesign};
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::{DMatrix, dmatrix};
    /// let plant = StateSpace::new(dmatrix![0.0], DMatrix::zeros(1, 0), dmatrix![1.0])?;
    /// // A first error of 1, noise of 0.02 that changes every 0.01, and 100 units of time of operation.
    /// let problem = EstimationProblem::new(&[1.0], &[0.02], 0.01, 100.0);
    /// let found = OptimalCubicDesign::new(&plant, &problem, None)?;
    /// assert!(found.cubic.is_some() && found.cost.total < 0.6 * found.linear_cost.total);
    /// assert!(found.certificate.is_proved());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// Numbers and shapes that do not fit; those of [`LinearDesign::kalman`] for a plant that is not detectable;
    /// [`DesignError::DependentOutputs`]; [`DesignError::Undecided`] where J could not be evaluated, or the time is
    /// over.
    pub fn new(plant: &StateSpace, problem: &EstimationProblem, end: Option<Instant>) -> Result<Self, DesignError> {
        let scaled = problem.scaled(plant)?;
        check::independent_outputs(&plant.c)?;
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let start = scaled.kalman(&DMatrix::identity(n, n))?;
        let kalman = problem.gain_of_plant(&start);
        let kalman_cost = scaled.linear(&start).ok_or_else(too_fast)?;
        let (mut used, mut ignored) = (0, 0);
        let budget = Budget { last_step: 1e-4, evaluations: 400 * n * p, end };
        let is_late = || end.is_some_and(|end| Instant::now() >= end);
        let of_linear = |z: &[f64], _most: f64| {
            if is_late() {
                return f64::INFINITY;
            }
            let l = DMatrix::from_column_slice(n, p, z);
            scaled.linear(&l).map_or(f64::INFINITY, |cost| cost.total)
        };
        let steps: Vec<f64> = search::steps(&start)[..n * p].to_vec();
        let (z, _) = search::descend(of_linear, start.as_slice().to_vec(), &steps, &budget, &mut ignored);
        let linear_gain = problem.gain_of_plant(&DMatrix::from_column_slice(n, p, &z));
        let linear_cost = problem.linear(plant, &linear_gain)?;

        let slowest = -spectral_abscissa(&(&plant.a - &linear_gain * &plant.c))?;
        let noise = Noise::new(&scaled, slowest, 1.0, Stream::new(0, Purpose::SearchedCost, 0).draws(0));
        let first_errors = directions(n);
        let of_cubic = |z: &[f64], most: f64| {
            if is_late() {
                return f64::INFINITY;
            }
            let found = search::point(&scaled, z).and_then(|at| scaled.cubic(&at.gains, &first_errors, &noise, most));
            found.map_or(f64::INFINITY, |cost| cost.total)
        };
        let mut starts = starts(&scaled, &problem.gain_in_units(&linear_gain), &of_cubic, &mut used);
        starts.truncate(2);
        let mut best: Option<(f64, Vec<f64>)> = None;
        for (_, z, l) in starts {
            let budget = Budget { last_step: 0.03, evaluations: used + EVALUATIONS * z.len(), end };
            let (z, value) = search::descend(of_cubic, z, &search::steps(&l), &budget, &mut used);
            if best.as_ref().is_none_or(|(least, _)| value < *least) {
                best = Some((value, z));
            }
        }
        if is_late() {
            return Err(too_fast());
        }
        let cubic = best.and_then(|(_, z)| search::point(&scaled, &z)).map(|at| certify(plant, problem, &at));
        let judged = match cubic.transpose()? {
            Some((linear, cubic)) => {
                let gains = problem.gains_in_units((cubic.l(), &cubic.observer.n, &cubic.observer.theta));
                let fresh = Noise::new(&scaled, slowest, LONGER, judged_along(0)).judging();
                let cost = scaled.cubic(&gains, &first_errors, &fresh, f64::INFINITY).ok_or_else(too_fast)?;
                Some((linear, cubic, cost))
            }
            None => None,
        };
        let (linear, cubic, cost) = match judged {
            Some((linear, cubic, cost)) if cost.total < (1.0 - LEAST_SAVING) * linear_cost.total => {
                (linear, Some(cubic), cost)
            }
            _ => (LinearDesign::with_gain(plant, &linear_gain)?, None, linear_cost),
        };
        let certificate = cubic.as_ref().map_or(&linear.certificate, |cubic| &cubic.certificate).clone();
        Ok(Self {
            linear,
            cubic,
            cost,
            linear_gain,
            linear_cost,
            kalman_gain: kalman,
            kalman_cost,
            evaluations: used,
            certificate,
        })
    }

    /// The observer gain L, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        self.linear.l()
    }

    /// The share of the cost of the linear optimum that the cubic term saves; 0 where there is none.
    pub fn cost_reduction(&self) -> f64 {
        1.0 - self.cost.total / self.linear_cost.total
    }
}

/// Starts of the search, the best first, in the units of the problem: each L with the better Q of two and the best
/// strength of eight.
///
/// L is the linear optimum, or Kalman's gain for a share of the first errors, or for those parts of them that no output
/// sees: the cubic term leaves these. Q is the identity, or nearly `C'C`, of which N acts on what is measured.
fn starts(
    scaled: &Scaled,
    linear_gain: &DMatrix<f64>,
    cost: &impl Fn(&[f64], f64) -> f64,
    used: &mut usize,
) -> Vec<(f64, Vec<f64>, DMatrix<f64>)> {
    let n = scaled.a.nrows();
    let identity = DMatrix::identity(n, n);
    let mut hidden = identity.clone();
    if let Some(gram) = (&scaled.c * scaled.c.transpose()).cholesky() {
        hidden -= scaled.c.transpose() * gram.solve(&scaled.c);
    }
    let mut gains = vec![linear_gain.clone()];
    for shares in [&identity / 16.0, &identity / 256.0, &hidden + &identity * 1e-4, &hidden / 16.0 + &identity * 1e-5] {
        gains.extend(scaled.kalman(&shares));
    }
    // The mean square of y - C xhat at first, and the rate of the linear optimum.
    let gram = scaled.c.transpose() * &scaled.c;
    let square = gram.trace() / n as f64;
    let rate = (&scaled.a - linear_gain * &scaled.c).norm();
    let measured = &gram / gram.norm() + &identity * 1e-3;
    let mut starts = Vec::new();
    for l in gains {
        let pairs = [&identity, &measured].into_iter().flat_map(|q| (-2..=5).map(move |k| (q, k)));
        let mut best = (f64::INFINITY, Vec::new());
        for (q, k) in pairs {
            let strength = rate / square * 10.0_f64.powf(0.5 * f64::from(k));
            let Some(z) = search::coordinates(&l, q, strength) else { continue };
            *used += 1;
            let value = cost(&z, best.0);
            if value < best.0 {
                best = (value, z);
            }
        }
        if best.0.is_finite() {
            starts.push((best.0, best.1, l));
        }
    }
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    starts
}

/// The observer in the units of the plant, its numbers with six digits, and its certificate.
fn certify(
    plant: &StateSpace,
    problem: &EstimationProblem,
    at: &Point,
) -> Result<(LinearDesign, CubicDesign), DesignError> {
    let (d, sigma) = (&problem.first_errors, &problem.noise);
    let by = |m: &DMatrix<f64>, unit: &[f64]| {
        DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| rounded(m[(i, j)] / (unit[i] * unit[j]), 6))
    };
    let linear = LinearDesign::with_gain_and_weight(
        plant,
        &problem.gain_of_plant(&at.gains.l),
        LyapunovWeight::Matrix(by(&at.q, d)),
    )?;
    let s = CubicGain::General(by(&at.s, sigma));
    let cubic = CubicDesign::new(&linear, &by(&at.gains.theta, sigma), &s)?;
    Ok((linear, cubic))
}
