//! Sliding-mode observers of a chain of integrators, stepped once per sample without chattering: super-twisting, and
//! the robust exact differentiator of any order.
//!
//! Plant `x1' = x2, .., x_n' = f(t, x, u) + d`, `y = x1`, with f and d known up to a bound D of what f leaves open. In
//! continuous time, with `e = y - xhat1`,
//! ```text
//! xhat_i' = xhat_(i+1) + k_i |e|^((n-i)/n) sign(e),    xhat_n' = f(t, xhat, u) + k_n sign(e).
//! ```
//! n = 1 is the first-order sliding mode, n = 2 the super-twisting observer; with f = 0 it is the differentiator of
//! order n - 1. The usual gains are `k_i = c_i D^(i/n)`.
//!
//! **Step.** Between samples the chain moves exactly for a constant f. At a sample with the innovation z = y - xhat1
//! the correction is that of the implicit Euler method: with `sigma`, what is left of the innovation after it, `r =
//! |sigma|^(1/n)`, and s in the set-valued sign of sigma,
//! ```text
//! sigma + s (h k_1 r^(n-1) + .. + h^(n-1) k_(n-1) r + h^n k_n) = z,
//! xhat_i <- xhat_i + s (h k_i r^(n-i) + h^2 k_(i+1) r^(n-i-1) + .. + beta_i h^(n-i+1) k_n).
//! ```
//! For `|z| <= h^n k_n` this is sigma = 0 with `s = z/(h^n k_n)`: the estimate of x1 is exact, and s is continuous in z
//! instead of a sign that changes at every sample; with the weights beta of [the deadbeat
//! observer](SlidingModeObserver), all 1 for n up to 2, what is left of an error is gone after n samples (with 1 for
//! all of them, the sign keeps switching for n above 3). Otherwise r is the positive root of a polynomial with a single
//! change of sign: in closed form for n up to 2, else by [`NEWTON`] steps of Newton's method from above, which
//! converges monotonically. The explicit method, which evaluates the sign of z, is there for comparison; it chatters
//! with an amplitude that its period determines.
//!
//! Once sigma = 0 at two samples in a row and `k_2 >= D`, the super-twisting observer stays there without noise: the
//! error of x1 is 0 at all samples, and that of x2 is at most h D/2 (proof: docs/sliding-mode.md).
//!
//! Sources: A. Levant, Higher-order sliding modes, differentiation and output-feedback control, International Journal
//! of Control 76, 2003; J. Davila, L. Fridman, A. Levant, Second-order sliding-mode observer for mechanical systems,
//! IEEE TAC 50, 2005; V. Acary, B. Brogliato, Implicit Euler numerical scheme and chattering-free implementation of
//! sliding mode systems, Systems and Control Letters 59, 2010; M. R. Mojallizadeh, B. Brogliato, V. Acary,
//! Time-discretizations of differentiators: design of implicit algorithms and comparative analysis, International
//! Journal of Robust and Nonlinear Control 31, 2021.

use luenberger_plants::error::check_matrix;
use luenberger_plants::{Plant, PlantError, Size};
use nalgebra::{Const, DefaultAllocator, Dim, OVector, RealField, U1, convert};

use crate::dense::{branches, choose};
use crate::error::ObserverError;
use crate::observer::{ObserverDimensions, SampledObserver, state_is_estimate};

/// Steps of Newton's method for orders above 2: from within a factor n of the root to rounding, for n up to 6.
pub const NEWTON: usize = 16;

/// How the discontinuous correction is discretised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Discretisation {
    /// By the implicit Euler method: does not chatter.
    Implicit,
    /// By the explicit Euler method, for comparison.
    Explicit,
}

/// The sliding-mode observer of a plant `S`, a chain of N integrators with M inputs and the output x1; P is 1.
///
/// ```
/// use luenberger_observers::sliding_mode::{Discretisation, StaticSlidingModeObserver};
/// use luenberger_observers::SampledObserver;
/// use nalgebra::{Vector1, Vector2};
/// // A double integrator with an unknown force up to 1, here 0.8: after the reaching phase the position is exact at
/// // every sample, and the velocity up to h/2.
/// let (plant, h) = (luenberger_plants::double_integrator(), 0.01);
/// let gains = Vector2::new(2.1, 1.1);
/// let observer = StaticSlidingModeObserver::<_, f64, 2, 1>::new(plant, gains, h, Discretisation::Implicit)?;
/// let (mut x, mut xhat) = (Vector2::new(1.0, -0.5), Vector2::zeros());
/// for k in 0..1000 {
///     observer.step(0.0, &mut xhat, &Vector1::zeros(), &Vector1::new(x[0]));
///     x = Vector2::new(x[0] + h * x[1] + 0.4 * h * h, x[1] + 0.8 * h);
///     // The prediction lacks the force over a period.
///     if k > 800 {
///         assert!((x[0] - xhat[0]).abs() < h * h && (x[1] - xhat[1]).abs() < 1.5 * h);
///     }
/// }
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SlidingModeObserver<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    plant: S,
    gains: OVector<T, N>,
    direction: OVector<T, N>,
    h: T,
    discretisation: Discretisation,
    sizes: core::marker::PhantomData<(M, P)>,
}

/// A sliding-mode observer whose sizes are known at compile time; its one output is no parameter.
pub type StaticSlidingModeObserver<S, T, const N: usize, const M: usize> =
    SlidingModeObserver<S, T, Const<N>, Const<M>, U1>;

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> SlidingModeObserver<S, T, N, M, P>
where
    S: Plant<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>>,
    DefaultAllocator: Size<N, M, P>,
{
    /// The observer with the gains k, n positive numbers, and the sampling period h. That the plant is a chain of
    /// integrators is not checked: only the last entry of its right-hand side is used.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for another number of gains, [`ObserverError::NotPositive`] for a gain,
    /// [`ObserverError::Period`].
    pub fn new(plant: S, gains: OVector<T, N>, h: T, discretisation: Discretisation) -> Result<Self, ObserverError> {
        let size = plant.dimensions();
        check_matrix("k", &gains, (size.states, 1))?;
        if size.outputs != 1 || size.states == 0 {
            let (expected, found) = ((1, 1), (size.outputs, 1));
            return Err(PlantError::DimensionMismatch { what: "y", expected, found }.into());
        }
        if let Some(gain) = gains.iter().find(|gain| **gain <= T::zero()) {
            let value = gain.to_subset_unchecked();
            return Err(ObserverError::NotPositive { what: "a gain of a sliding-mode observer", value });
        }
        if !(h.is_finite() && h > T::zero()) {
            return Err(ObserverError::Period { period: h.to_subset_unchecked() });
        }
        let direction = deadbeat(&gains);
        Ok(Self { plant, gains, direction, h, discretisation, sizes: core::marker::PhantomData })
    }

    /// The plant.
    pub fn plant(&self) -> &S {
        &self.plant
    }

    /// The gains k, n x 1.
    pub fn gains(&self) -> &OVector<T, N> {
        &self.gains
    }

    /// How the correction is discretised.
    pub fn discretisation(&self) -> Discretisation {
        self.discretisation
    }

    fn gain(&self, i: usize) -> T {
        self.gains.get(i).copied().unwrap_or_else(T::zero)
    }

    /// `h^n k_n`: innovations up to this are corrected to 0.
    pub fn boundary_layer(&self) -> T {
        let n = self.gains.len();
        (0..n).fold(self.gain(n.saturating_sub(1)), |layer, _| layer * self.h)
    }

    /// `r = |sigma|^(1/n)` and s for an innovation.
    pub fn resolved(&self, z: T) -> (T, T) {
        let (n, zero) = (self.gains.len(), T::zero());
        let sign = branches(|| {
            if z > zero {
                T::one()
            } else if z < zero {
                -T::one()
            } else {
                zero
            }
        });
        if self.discretisation == Discretisation::Explicit {
            return (root(z.abs(), n), sign);
        }
        let layer = self.boundary_layer();
        let rest = z.abs() - layer;
        let solved = || match n {
            1 => rest,
            2 => {
                let a = self.h * self.gain(0);
                (rest + rest) / (a + (a * a + convert::<f64, T>(4.0) * rest).sqrt())
            }
            _ => self.newton(rest),
        };
        let r = branches(|| if rest > zero { solved() } else { zero });
        (r, choose(|| rest > zero, sign, z / layer))
    }

    /// The positive root of `r^n + h k_1 r^(n-1) + .. + h^(n-1) k_(n-1) r = rest`.
    fn newton(&self, rest: T) -> T {
        let n = self.gains.len();
        // Each term alone is at most the sum: an upper bound of the root, within a factor n.
        let mut power = self.h;
        let mut r = root(rest, n);
        for j in 1..n {
            let bound = root(rest / (power * self.gain(j - 1)), n - j);
            r = choose(|| bound < r, bound, r);
            power *= self.h;
        }
        for _ in 0..NEWTON {
            // Horner's scheme for the value and the slope.
            let (mut value, mut slope, mut power) = (T::one(), T::zero(), self.h);
            for j in 1..n {
                slope = slope * r + value;
                value = value * r + power * self.gain(j - 1);
                power *= self.h;
            }
            slope = slope * r + value;
            value = value * r - rest;
            let next = r - value / slope;
            r = choose(|| next > T::zero(), next, r);
        }
        r
    }

    /// The corrected entry i of the estimate.
    fn corrected(&self, i: usize, xhat: T, (r, s): (T, T)) -> T {
        let n = self.gains.len();
        if self.discretisation == Discretisation::Explicit {
            return xhat + self.h * self.gain(i) * (i + 1..n).fold(T::one(), |power, _| power * r) * s;
        }
        let (mut sum, mut power) = (T::zero(), self.h);
        for j in i..n {
            let weight = if j + 1 == n { self.direction.get(i).copied().unwrap_or_else(T::zero) } else { T::one() };
            sum += weight * power * self.gain(j) * (j + 1..n).fold(T::one(), |power, _| power * r);
            power *= self.h;
        }
        xhat + sum * s
    }
}

/// `beta_i = p^(i-1)(0)` of the polynomial p of degree n - 1 with p(0) = 1 and the zeros -1, .., -(n-1): a correction
/// in this direction is that of the deadbeat observer.
fn deadbeat<T: RealField + Copy, N: Dim>(gains: &OVector<T, N>) -> OVector<T, N>
where
    DefaultAllocator: nalgebra::allocator::Allocator<N>,
{
    let n = gains.len();
    let mut direction = OVector::<T, N>::zeros_generic(gains.shape_generic().0, Const);
    let entries = direction.as_mut_slice();
    if let Some(first) = entries.first_mut() {
        *first = T::one();
    }
    for zero in 1..n {
        for i in (1..n).rev() {
            let before = entries.get(i - 1).copied().unwrap_or_else(T::zero);
            if let Some(entry) = entries.get_mut(i) {
                *entry += before / crate::cubic::count(zero);
            }
        }
    }
    let mut factorial = T::one();
    for (i, entry) in entries.iter_mut().enumerate().skip(1) {
        factorial *= crate::cubic::count(i);
        *entry *= factorial;
    }
    direction
}

/// The root of a number of 0 or more.
fn root<T: RealField + Copy>(x: T, order: usize) -> T {
    match order {
        0 | 1 => x,
        2 => x.sqrt(),
        4 => x.sqrt().sqrt(),
        order => x.powf(T::one() / crate::cubic::count(order)),
    }
}

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> SampledObserver<T> for SlidingModeObserver<S, T, N, M, P>
where
    S: Plant<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>>,
    DefaultAllocator: Size<N, M, P>,
{
    state_is_estimate! { SampledObserver }

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.plant.dimensions();
        ObserverDimensions { state: size.states, inputs: size.inputs, outputs: 1, estimate: size.states }
    }

    fn period(&self) -> T {
        self.h
    }

    fn step(&self, t: T, xhat: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        let n = self.gains.len();
        let f = self.plant.derivative(t, xhat, u);
        let f = f.get(n.saturating_sub(1)).copied().unwrap_or_else(T::zero);
        let first = |v: Option<&T>| v.copied().unwrap_or_else(T::zero);
        let resolved = self.resolved(first(y.as_slice().first()) - first(xhat.get(0)));
        for (i, entry) in xhat.iter_mut().enumerate() {
            *entry = self.corrected(i, *entry, resolved);
        }
        // x_i + h x_(i+1) + h^2/2 x_(i+2) + .., the last with f; entries above i are those before the motion.
        for i in 0..n {
            let (mut moved, mut weight, mut degree) = (first(xhat.get(i)), T::one(), T::zero());
            for j in i + 1..=n {
                degree += T::one();
                weight = weight * self.h / degree;
                moved += weight * if j < n { first(xhat.get(j)) } else { f };
            }
            if let Some(entry) = xhat.get_mut(i) {
                *entry = moved;
            }
        }
    }
}

/// The gains of Levant for the bound D, `k_i = c_i D^(i/n)`, in the form in which every correction has the innovation
/// as its argument: of the recursive form with 1.1, 1.5, 2, 3, 5, 8 from the last.
///
/// `None` for orders above 6 and for a bound that is not positive.
pub fn levant_gains<T: RealField + Copy, N: Dim>(order: N, bound: T) -> Option<OVector<T, N>>
where
    DefaultAllocator: nalgebra::allocator::Allocator<N>,
{
    const RECURSIVE: [f64; 6] = [1.1, 1.5, 2.0, 3.0, 5.0, 8.0];
    let n = order.value();
    if n == 0 || n > RECURSIVE.len() || !(bound > T::zero() && bound.is_finite()) {
        return None;
    }
    // With l_0 = 1.1, l_1 = 1.5, ..: c_1 = l_(n-1), c_(i+1) = l_(n-1-i) c_i^((n-1-i)/(n-i)).
    let mut c: T = convert(RECURSIVE[n - 1]);
    let mut found = OVector::<T, N>::zeros_generic(order, Const);
    for i in 0..n {
        if i > 0 {
            let exponent = crate::cubic::count::<T>(n - 1 - i) / crate::cubic::count::<T>(n - i);
            c = convert::<f64, T>(RECURSIVE[n - 1 - i]) * c.powf(exponent);
        }
        let power: T = crate::cubic::count::<T>(i + 1) / crate::cubic::count::<T>(n);
        if let Some(entry) = found.get_mut(i) {
            *entry = c * bound.powf(power);
        }
    }
    Some(found)
}
