//! A plant from one sample to the next, as filters predict: the next state, the transition matrix, the covariance of
//! the noise.
//!
//! ```text
//! x' = f(t, x, u),  Phi' = F Phi,  Phi(t) = I,  Q' = F Q + Q F' + W,  Q(t) = 0        F = Df along the trajectory
//! P+ = Phi P Phi' + Q
//! ```
//!
//! [`Prediction`] says how. `P+` is a congruence and a sum, so that P stays positive semidefinite where Q is.
//!
//! **With error control**, the default of a filter on a computer:
//!
//! - A plant that is linear between samples ([`is_linear_between_samples`]) takes one step, which is
//!   exact to rounding for any period and any stiffness: `exp(F tau)`, `phi_1(F tau) tau f` and Van Loan's integral by
//!   scaling and doubling (`exponential`).
//! - Any other takes steps of Dormand and Prince, order 5(4), from `(x, I, 0)` on; a step is halved until its error is
//!   below [`SHARE`] of the standard deviation and of the step's own movement, state by state, and that of `P+` below
//!   [`COVARIANCE_SHARE`] of `sigma_i sigma_j`.
//! - Where the fastest mode would need hundreds of such steps, they are linearly implicit in its place: by the
//!   exponential of the Jacobian (local linearisation, A-stable, order 2), compared with two of half the length, to
//!   [`STIFF_SHARES`]. The covariance of a fast mode then has a relative error of the order of the ratio of slow to
//!   fast rates in addition, which no estimate sees.
//!
//! All decisions compare numbers of the same unit: they do not depend on the units of states and time.
//!
//! **With a number of steps**, for a target: the classical Runge-Kutta method for x and Phi in steps of `tau`, and
//! Simpson's rule for Q, whose weights are positive:
//!
//! ```text
//! Q = tau/6 (Phi W Phi' + 4 H W H' + W),   H = Phi(t + tau, t + tau/2) = I + A + A^2/2 + A^3/6,   A = (F3 + F4) tau/4
//! ```
//!
//! with the Jacobians F3 and F4 of the third and fourth stage. It is stable for modes with `|lambda| tau` below 2.78,
//! and nothing is checked on the way: whoever chooses the number compares with the prediction that controls its error.
//!
//! Sources: C. F. Van Loan, Computing integrals involving the matrix exponential, IEEE Transactions on Automatic
//! Control 23, 1978; E. Hairer, S. P. Norsett and G. Wanner, Solving Ordinary Differential Equations I, table II.5.2;
//! R. J. Biscay et al., Local linearization method for the numerical solution of stochastic differential equations,
//! Annals of the Institute of Statistical Mathematics 48, 1996.
//!
//! [`is_linear_between_samples`]: luenberger_plants::Differentiable::is_linear_between_samples

#![cfg_attr(
    not(feature = "alloc"),
    allow(dead_code, unused_variables, reason = "what the control of the error asks for")
)]

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, convert};

#[cfg(feature = "alloc")]
use crate::dense::Factor;
use crate::dense::{are_finite, times, times_transpose};
#[cfg(feature = "alloc")]
use crate::exponential::{Exponential, balanced_norm};
use crate::gaussian::symmetrise;
use crate::triangular::add;

/// The share of the standard deviation that a step with error control may be wrong by.
pub const SHARE: f64 = 1e-9;

/// The share of the product of two standard deviations that a covariance may be wrong by.
pub const COVARIANCE_SHARE: f64 = 1e-6;

/// The same two for the steps of stiff plants.
pub const STIFF_SHARES: [f64; 2] = [1e-5, 1e-4];

/// A plant counts as stiff where the norm of its Jacobian, in balanced coordinates, times the duration is above this.
#[cfg(feature = "alloc")]
const STIFF: f64 = 500.0;

/// Most steps of a prediction with error control.
pub const MOST_STEPS: usize = 5000;

/// How a filter gets from one sample to the next; see the module `transition`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prediction {
    /// The plant is in discrete time.
    Discrete,
    /// As many steps as the error needs; one exact step for a plant that is linear between samples. Not for targets:
    /// with the feature `alloc`.
    #[cfg(feature = "alloc")]
    ErrorControlled,
    /// So many steps of the classical Runge-Kutta method in a period.
    RungeKutta(usize),
}

impl Prediction {
    /// The number of Runge-Kutta steps in a period, where it is fixed.
    pub fn substeps(self) -> Option<usize> {
        if let Self::RungeKutta(substeps) = self { Some(substeps) } else { None }
    }

    /// Runge-Kutta steps for a duration: as many as are fixed for each period, or part of one.
    pub(crate) fn steps<T: RealField + Copy>(self, duration: T, period: T) -> usize {
        let substeps = self.substeps().unwrap_or(1);
        let mut count = substeps;
        // The last period may be longer by rounding.
        let mut reach = period * convert(1.0 + 1e-6);
        while reach < duration && count < MOST_STEPS {
            count += substeps;
            reach += period;
        }
        count
    }
}

/// The exact discretisation of `x' = A x + B u + w` with the input held and w white of intensity W: over tau, `x+ = phi
/// x + integral B u + w+` with w+ of covariance `noise`. Exact to rounding, of the order of `epsilon |A| tau`.
///
/// ```
/// use luenberger_observers::transition::ExactDiscretisation;
/// use nalgebra::{Matrix2, Vector2};
/// let (a, w) = (Matrix2::new(0.0, 1.0, 0.0, 0.0), Matrix2::new(0.0, 0.0, 0.0, 3.0));
/// let ExactDiscretisation { phi, integral, noise } = ExactDiscretisation::new(&a, &w, 2.0);
/// assert_eq!((phi, integral * Vector2::new(0.0, 1.0)), (Matrix2::new(1.0, 2.0, 0.0, 1.0), Vector2::new(2.0, 2.0)));
/// assert_eq!(noise, Matrix2::new(8.0, 6.0, 6.0, 6.0));
/// ```
#[cfg(feature = "alloc")]
#[derive(Clone, Debug, PartialEq)]
pub struct ExactDiscretisation<T: RealField + Copy, N: Dim>
where
    DefaultAllocator: Allocator<N, N>,
{
    /// `exp(A tau)`, n x n.
    pub phi: OMatrix<T, N, N>,
    /// `int_0^tau exp(A s) ds`, n x n.
    pub integral: OMatrix<T, N, N>,
    /// `int_0^tau exp(A s) W exp(A' s) ds`, n x n.
    pub noise: OMatrix<T, N, N>,
}

#[cfg(feature = "alloc")]
impl<T: RealField + Copy, N: Dim> ExactDiscretisation<T, N>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    /// Over the time `tau`. Entries are NaN where A, W or tau is not finite.
    pub fn new(a: &OMatrix<T, N, N>, w: &OMatrix<T, N, N>, tau: T) -> Self {
        let Exponential { growth, average, noise, .. } = Exponential::new(a, w, tau);
        let order = a.shape_generic().0;
        Self { phi: OMatrix::identity_generic(order, order) + growth, integral: average * tau, noise }
    }
}

/// Where a prediction leads.
#[derive(Clone, Debug)]
pub(crate) struct Transition<T: RealField + Copy, N: Dim>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    /// The next state.
    pub(crate) next: OVector<T, N>,
    /// Phi, the derivative of the next state by this one.
    pub(crate) phi: OMatrix<T, N, N>,
    /// Q, the covariance of the noise on the way.
    pub(crate) noise: OMatrix<T, N, N>,
}

impl<T: RealField + Copy, N: Dim> Transition<T, N>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    /// No way at all.
    pub(crate) fn none(x: &OVector<T, N>) -> Self {
        let order = x.shape_generic().0;
        let phi = OMatrix::identity_generic(order, order);
        Self { next: x.clone(), phi, noise: OMatrix::zeros_generic(order, order) }
    }

    /// `Phi P Phi' + Q`.
    pub(crate) fn spread(&self, p: &OMatrix<T, N, N>) -> OMatrix<T, N, N> {
        let mut spread = times_transpose(&times(&self.phi, p), &self.phi) + &self.noise;
        symmetrise(&mut spread);
        spread
    }

    /// Both, one after the other.
    fn then(self, next: Self) -> Self {
        let noise = next.spread(&self.noise);
        Self { next: next.next, phi: times(&next.phi, &self.phi), noise }
    }

    fn is_finite(&self) -> bool {
        [self.next.as_slice(), self.phi.as_slice(), self.noise.as_slice()].into_iter().all(are_finite)
    }
}

/// What a prediction needs to know: f and Df at a time and a state (the input is held), and the noise.
pub(crate) struct Motion<'m, T: RealField + Copy, N: Dim, F>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    /// `f(t, x)` and `Df(t, x)`.
    pub(crate) field: F,
    /// Whether f is linear in x until the next sample, and free of t.
    pub(crate) is_linear: bool,
    /// The intensity W; in discrete time the covariance per sample.
    pub(crate) w: &'m OMatrix<T, N, N>,
    /// False where the next state alone is asked for; Phi and Q have no meaning then.
    pub(crate) with_covariance: bool,
}

/// A step of the classical Runge-Kutta method: the next state, Phi, and H from its middle to its end.
struct ClassicalStep<T: RealField + Copy, N: Dim>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    next: OVector<T, N>,
    phi: OMatrix<T, N, N>,
    halfway: OMatrix<T, N, N>,
}

impl<T: RealField + Copy, N: Dim, F> Motion<'_, T, N, F>
where
    F: Fn(T, &OVector<T, N>) -> (OVector<T, N>, OMatrix<T, N, N>),
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    /// From `x` with the covariance `p` at time t over a duration, of which `period` is what a number of steps refers
    /// to; none if f or Df is not finite on the way, a number overflows, or [`MOST_STEPS`] are not enough. In discrete
    /// time to the next sample, whatever the duration.
    pub(crate) fn over(
        &self,
        prediction: Prediction,
        (t, duration, period): (T, T, T),
        x: &OVector<T, N>,
        p: &OMatrix<T, N, N>,
    ) -> Option<Transition<T, N>> {
        let found = match prediction {
            Prediction::Discrete => {
                let (next, phi) = (self.field)(t, x);
                Transition { next, phi, noise: self.w.clone() }
            }
            #[cfg(feature = "alloc")]
            Prediction::ErrorControlled if self.is_linear => self.linear_step(duration, x, &(self.field)(t, x)),
            #[cfg(feature = "alloc")]
            Prediction::ErrorControlled => self.controlled(t, duration, x, p)?,
            Prediction::RungeKutta(_) => self.classical(t, duration, prediction.steps(duration, period), x),
        };
        found.is_finite().then_some(found)
    }

    /// Whether the steps from x on are linearly implicit.
    #[cfg(feature = "alloc")]
    pub(crate) fn is_stiff(&self, t: T, duration: T, x: &OVector<T, N>) -> bool {
        is_stiff(&(self.field)(t, x).1, duration)
    }

    /// Where points around `x` lead, of a distribution with the covariance `p` about it, and the covariance of the
    /// noise on the way of `x`; none as of [`over`](Self::over). `point` is the motion for the next state alone.
    ///
    /// A linear plant has one transition. Where the way of `x` is stiff the points take its kind of steps, because
    /// steps of two kinds would add their errors to the differences of the points.
    #[cfg(feature = "alloc")]
    #[allow(clippy::type_complexity, reason = "the map of a point, a covariance")]
    pub(crate) fn around<'m, G>(
        &'m self,
        point: &'m Motion<'m, T, N, G>,
        prediction: Prediction,
        during: (T, T, T),
        (x, p): (&'m OVector<T, N>, &'m OMatrix<T, N, N>),
    ) -> Option<(impl Fn(&OVector<T, N>) -> Option<OVector<T, N>> + 'm, OMatrix<T, N, N>)>
    where
        G: Fn(T, &OVector<T, N>) -> (OVector<T, N>, OMatrix<T, N, N>),
    {
        let Transition { next, phi, noise } = self.over(prediction, during, x, p)?;
        let is_controlled = prediction == Prediction::ErrorControlled;
        let is_exact = is_controlled && self.is_linear;
        let is_stiff = is_controlled && !is_exact && self.is_stiff(during.0, during.1, x);
        let image = move |at: &OVector<T, N>| {
            if is_exact {
                return Some(&next + times(&phi, &(at - x)));
            }
            let found =
                if is_stiff { self.over(prediction, during, at, p) } else { point.over(prediction, during, at, p) };
            found.map(|found| found.next)
        };
        Some((image, noise))
    }

    /// The step that is exact if f is linear, with this value and this Jacobian at x.
    #[cfg(feature = "alloc")]
    fn linear_step(
        &self,
        tau: T,
        x: &OVector<T, N>,
        (f, jacobian): &(OVector<T, N>, OMatrix<T, N, N>),
    ) -> Transition<T, N> {
        let Exponential { growth, average, noise, .. } = Exponential::new(jacobian, self.w, tau);
        let order = x.shape_generic().0;
        Transition { next: x + times(&average, f) * tau, phi: OMatrix::identity_generic(order, order) + growth, noise }
    }

    /// One step of the classical Runge-Kutta method.
    fn classical_step(&self, t: T, tau: T, x: &OVector<T, N>) -> ClassicalStep<T, N> {
        let order = x.shape_generic().0;
        let identity = OMatrix::<T, N, N>::identity_generic(order, order);
        let number = |x: f64| convert::<f64, T>(x);
        let (middle, sixth, quarter) = (tau * number(0.5), tau * number(1.0 / 6.0), tau * number(0.25));
        let (two, half, third) = (number(2.0), number(0.5), number(1.0 / 3.0));
        let (k1, f1) = (self.field)(t, x);
        let (k2, f2) = (self.field)(t + middle, &(x + &k1 * middle));
        let (k3, f3) = (self.field)(t + middle, &(x + &k2 * middle));
        let (k4, f4) = (self.field)(t + tau, &(x + &k3 * tau));
        let next = x + (k1 + (k2 + k3) * two + k4) * sixth;
        if !self.with_covariance {
            return ClassicalStep { next, phi: identity.clone(), halfway: identity };
        }
        let m2 = &f2 + times(&f2, &f1) * middle;
        let m3 = &f3 + times(&f3, &m2) * middle;
        let m4 = &f4 + times(&f4, &m3) * tau;
        let phi = &identity + (f1 + (m2 + &m3) * two + m4) * sixth;
        let a = (f3 + f4) * quarter;
        let inner = &identity + &a * third;
        let inner = &identity + times(&a, &inner) * half;
        let halfway = identity + times(&a, &inner);
        ClassicalStep { next, phi, halfway }
    }

    /// `count` steps of the classical Runge-Kutta method.
    pub(crate) fn classical(&self, t: T, duration: T, count: usize, x: &OVector<T, N>) -> Transition<T, N> {
        let tau = duration / convert::<f64, T>(count as f64);
        let mut way = Transition::none(x);
        for k in 0..count {
            let ClassicalStep { next, phi, halfway } =
                self.classical_step(t + tau * convert::<f64, T>(k as f64), tau, &way.next);
            if !self.with_covariance {
                way.next = next;
                continue;
            }
            let whole = times_transpose(&times(&phi, self.w), &phi);
            let middle = times_transpose(&times(&halfway, self.w), &halfway);
            let (four, sixth): (T, T) = (convert(4.0), convert(1.0 / 6.0));
            let mut noise = ((whole + middle * four) + self.w) * (tau * sixth);
            symmetrise(&mut noise);
            let step = Transition { next, phi, noise };
            way = if k == 0 { step } else { way.then(step) };
        }
        way
    }

    /// The same, with `factor` the lower triangular factor of W, and that of Q in place of Q: its columns are added one
    /// by one, and no factorisation can fail.
    pub(crate) fn classical_by_factors(
        &self,
        (t, duration): (T, T),
        count: usize,
        x: &OVector<T, N>,
        factor: &OMatrix<T, N, N>,
    ) -> Transition<T, N> {
        let tau = duration / convert::<f64, T>(count as f64);
        let weight = (tau * convert::<f64, T>(1.0 / 6.0)).sqrt();
        let two = T::one() + T::one();
        let mut way = Transition::none(x);
        for k in 0..count {
            let ClassicalStep { next, phi, halfway } =
                self.classical_step(t + tau * convert::<f64, T>(k as f64), tau, &way.next);
            let mut sum = factor * weight;
            let mut columns = [times(&halfway, factor) * (two * weight), times(&phi, factor) * weight];
            for columns in &mut columns {
                for j in 0..columns.ncols() {
                    add(&mut sum, &mut columns.column(j).into_owned());
                }
            }
            if k > 0 {
                let before = times(&phi, &way.noise);
                for j in 0..before.ncols() {
                    add(&mut sum, &mut before.column(j).into_owned());
                }
            }
            let phi = if k == 0 { phi } else { times(&phi, &way.phi) };
            way = Transition { next, phi, noise: sum };
        }
        way
    }

    /// Steps whose errors are compared with the standard deviations.
    #[cfg(feature = "alloc")]
    fn controlled(&self, t: T, duration: T, x: &OVector<T, N>, p: &OMatrix<T, N, N>) -> Option<Transition<T, N>> {
        let mut way = Transition::none(x);
        let mut covariance = p.clone();
        let mut at = (self.field)(t, x);
        // In parts of the duration, which are powers of two: `done` are over, the next has the length `part`.
        let (mut done, mut part) = (T::zero(), T::one());
        let two = T::one() + T::one();
        let is_stiff = is_stiff(&at.1, duration);
        let shares = if is_stiff { STIFF_SHARES } else { [SHARE, COVARIANCE_SHARE] };
        for _ in 0..MOST_STEPS {
            if done >= T::one() {
                return Some(way);
            }
            let (now, tau) = (t + duration * done, duration * part);
            let (step, error, end) = if is_stiff {
                self.local_linearisation(now, tau, &way.next, &at)
            } else {
                self.dormand_prince(now, tau, &way.next, &at)
            };
            let excess = self.excess(&step, &error, (&way.next, &at, tau), &covariance, shares);
            let is_within = excess <= T::one();
            if !is_within {
                if part <= convert(1e-12) {
                    return None;
                }
                part /= if excess > convert(64.0) { two * two } else { two };
                continue;
            }
            done += part;
            // Powers of two add exactly. A longer step starts at a multiple of its length.
            let longer = part * two;
            // The error of a step is of the order of its length to the power 6, or 2.
            let small = if is_stiff { convert(1.0 / 8.0) } else { convert::<f64, T>(1.0 / 64.0) };
            if excess < small && (done / longer).fract() == T::zero() && done + longer <= T::one() {
                part = longer;
            }
            if self.with_covariance {
                covariance = step.spread(&covariance);
                way = way.then(step);
            } else {
                way.next = step.next;
            }
            at = end;
        }
        None
    }

    /// How many times the error of a step is larger than it may be; NaN if it is no number.
    #[cfg(feature = "alloc")]
    #[allow(clippy::type_complexity, reason = "where the step starts: state, f and Df, length")]
    fn excess(
        &self,
        step: &Transition<T, N>,
        error: &Transition<T, N>,
        (x, (f, jacobian), tau): (&OVector<T, N>, &(OVector<T, N>, OMatrix<T, N, N>), T),
        p: &OMatrix<T, N, N>,
        shares: [f64; 2],
    ) -> T {
        let n = x.nrows();
        let epsilon = T::default_epsilon();
        let [share, of_covariance] = shares.map(|share| convert::<f64, T>(share).max(epsilon * convert(64.0)));
        let after = if self.with_covariance { step.spread(p) } else { p.clone() };
        // d Phi P Phi' + (d Phi P Phi')' + d Q.
        let mut spread = times_transpose(&times(&error.phi, p), &step.phi);
        spread = &spread + spread.transpose() + &error.noise;
        let mut excess = T::zero();
        for i in 0..n {
            if !(after[(i, i)].is_finite() && step.next[i].is_finite()) {
                return convert(f64::NAN);
            }
            // What the terms of f move in the step, though they cancel.
            let moved = (0..n).fold(f[i].abs(), |sum, j| sum + (jacobian[(i, j)] * x[j]).abs()) * tau;
            let deviation = after[(i, i)].max(T::zero()).sqrt();
            let allowed = share * (deviation + moved) + epsilon * convert(8.0) * x[i].abs().max(step.next[i].abs());
            let ratio = |error: T, allowed: T| if error == T::zero() { error } else { error / allowed };
            excess = excess.max(ratio(error.next[i].abs(), allowed));
            for j in 0..=i {
                let scale = deviation * after[(j, j)].max(T::zero()).sqrt();
                if scale > T::zero() {
                    excess = excess.max(ratio(spread[(i, j)].abs(), of_covariance * scale));
                }
            }
        }
        excess
    }

    /// A step of order 5, its difference from order 4, and f and Df at its end.
    #[cfg(feature = "alloc")]
    #[allow(clippy::type_complexity, reason = "step, error, and f and Df at the end")]
    fn dormand_prince(
        &self,
        t: T,
        tau: T,
        x: &OVector<T, N>,
        at: &(OVector<T, N>, OMatrix<T, N, N>),
    ) -> (Transition<T, N>, Transition<T, N>, (OVector<T, N>, OMatrix<T, N, N>)) {
        let start = Transition::none(x);
        let first = Transition { next: at.0.clone(), phi: at.1.clone(), noise: self.w.clone() };
        let mut slopes: [Transition<T, N>; 7] = core::array::from_fn(|_| first.clone());
        let moved = |from: Option<&Transition<T, N>>, slopes: &[Transition<T, N>], weights: &[f64]| {
            let zero = start.noise.clone();
            let mut sum =
                from.cloned().unwrap_or_else(|| Transition { next: x * T::zero(), phi: zero.clone(), noise: zero });
            for (slope, weight) in slopes.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
                let weight = tau * convert::<f64, T>(*weight);
                sum.next += &slope.next * weight;
                if self.with_covariance {
                    sum.phi += &slope.phi * weight;
                    sum.noise += &slope.noise * weight;
                }
            }
            sum
        };
        let (mut place, mut end) = (start.clone(), at.clone());
        for (stage, (node, weights)) in STAGES.iter().enumerate() {
            place = moved(Some(&start), &slopes[..=stage], weights);
            end = (self.field)(t + tau * convert(*node), &place.next);
            let (f, jacobian) = &end;
            if !self.with_covariance {
                slopes[stage + 1].next.copy_from(f);
                continue;
            }
            let fq = times(jacobian, &place.noise);
            slopes[stage + 1] =
                Transition { next: f.clone(), phi: times(jacobian, &place.phi), noise: fq.transpose() + fq + self.w };
        }
        // The last stage is the result.
        symmetrise(&mut place.noise);
        (place, moved(None, &slopes, &ERRORS), end)
    }

    /// Two exponential steps of half the length, their difference from one, and f and Df at the end. x is linearised at
    /// the start of each step; Phi and Q belong to the Jacobian at its end, by which fast modes follow slow ones.
    #[cfg(feature = "alloc")]
    #[allow(clippy::type_complexity, reason = "step, error, and f and Df at the end")]
    fn local_linearisation(
        &self,
        t: T,
        tau: T,
        x: &OVector<T, N>,
        at: &(OVector<T, N>, OMatrix<T, N, N>),
    ) -> (Transition<T, N>, Transition<T, N>, (OVector<T, N>, OMatrix<T, N, N>)) {
        let half = tau * convert::<f64, T>(0.5);
        // f at the start, and how much the time alone changes it in the step.
        let moved =
            |exponential: &Exponential<T, N>, tau: T, x: &OVector<T, N>, f: &OVector<T, N>, later: OVector<T, N>| {
                let change = later - f;
                x + times(&exponential.average, f) * tau + times(&exponential.ramp, &change) * tau
            };
        let alone = |t: T, x: &OVector<T, N>| (self.field)(t, x).0;
        let first = Exponential::new(&at.1, self.w, half);
        let whole = moved(&first.doubled(), tau, x, &at.0, alone(t + tau, x));
        let halfway = moved(&first, half, x, &at.0, alone(t + half, x));
        let centre = (self.field)(t + half, &halfway);
        let second = Exponential::new(&centre.1, self.w, half);
        let last = moved(&second, half, &halfway, &centre.0, alone(t + tau, &halfway));
        let error = (&last - &whole) * convert::<f64, T>(1.0 / 3.0);
        let last = last + &error;
        let end = (self.field)(t + tau, &last);
        let third = Exponential::new(&end.1, self.w, half);
        let along = |exponential: Exponential<T, N>| {
            let order = x.shape_generic().0;
            let phi = OMatrix::identity_generic(order, order) + exponential.growth;
            Transition { next: last.clone(), phi, noise: exponential.noise }
        };
        let coarse = along(third.doubled());
        let mut step = along(second).then(along(third));
        let error = Transition { next: error, phi: &step.phi - &coarse.phi, noise: &step.noise - &coarse.noise };
        // Of order 2, where what is left of Q is definite.
        let noise = &step.noise + &error.noise;
        if Factor::new(&noise).is_some() {
            step.noise = noise;
        }
        step.phi += &error.phi;
        (step, error, end)
    }
}

#[cfg(feature = "alloc")]
fn is_stiff<T: RealField + Copy, N: Dim>(jacobian: &OMatrix<T, N, N>, duration: T) -> bool
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    balanced_norm(jacobian) * duration > convert(STIFF)
}

/// Nodes and weights of the stages of Dormand and Prince after the first; the last row is the result of order 5.
#[cfg(feature = "alloc")]
const STAGES: [(f64, [f64; 6]); 6] = [
    (1.0 / 5.0, [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    (3.0 / 10.0, [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0]),
    (4.0 / 5.0, [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0]),
    (8.0 / 9.0, [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0]),
    (1.0, [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0]),
    (1.0, [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0]),
];

/// The weights of order 5 minus those of order 4.
#[cfg(feature = "alloc")]
const ERRORS: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];
