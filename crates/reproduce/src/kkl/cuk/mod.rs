//! The observers of the Cuk converter: the six of Table I of Yi, Ortega and Zhang, corrected, and an exact high-gain
//! observer.
//!
//! Estimated is (i1, v4), the states 0 and 3 of [`CukConverter`], from y = (v2, i3) and the duty cycle u; w = 1 - u.
//! The errors are `e = xhat - x`.
//!
//! | constructor | observer | error, exactly |
//! |---|---|---|
//! | [`kklo`] | KKLO | `e_i1' = -(w/L1) e_i1`, `e_v4' = -(G/C4) e_v4` |
//! | [`pebo`] | PEBO | that of the gradient estimator |
//! | [`kkl_pebo`] | [KKL+PEB]O | that of the gradient estimator for i1, `e_v4' = -(G/C4) e_v4` |
//! | [`immersion_invariance`] | I&IO | `e_i1' = -g1 w e_i1`, `e_v4' = -(G/C4 + g2) e_v4`; g1 = 1/L1, g2 = 0 is the KKLO |
//! | [`kkl_pebo_immersed`] | [KKL+PEB]O written as an I&IO | that of the [KKL+PEB]O, with [`Embedding::Equivalent`] |
//! | [`high_gain_time_varying`] | HGO | `s^2 + (a1/r1) s + w a2/(r1^2 C2)` and `s^2 + (a3/r1 + G/C4) s + a3 G/(r1 C4) + a4/(r1^2 L3)` for w constant |
//! | [`high_gain_differentiator`] | HGO that differentiates y twice | `s^2 + (a1/r2) s + a2/r2^2`, `s^2 + (a3/r2) s + a4/r2^2`, driven by y'': zero in equilibrium only |
//! | [`high_gain_exact`] | HGO with the plant in it | `s^2 + (a1/r2) s + a2/r2^2` and `s^2 + (a3/r2 + G/C4) s + a3 G/(r2 C4) + a4/r2^2` for w constant |
//!
//! As printed, the PEBO, the [KKL+PEB]O, the I&IO and the second HGO do not converge; the printed equations and their
//! errors are in `docs/theory-kkl.md`. For the KKLO, Lambda depends on u, and its entry for i1 is stable because `int w
//! dt` diverges.

mod embedded;
mod high_gain;
mod immersion;
mod kkl;
mod peb;

use luenberger_observers::ObserverError;
use luenberger_observers::estimator::gradient::Gradient;
use luenberger_observers::high_gain::HighGainObserver;
use luenberger_observers::immersion_invariance::ImmersionInvarianceObserver;
use luenberger_observers::kkl::KklObserver;
use luenberger_observers::kkl_peb::KklPebObserver;
use luenberger_plants::CukConverter;
use nalgebra::{Const, Matrix1, Matrix2, RealField, U1, U2, U4, Vector2, Vector4, convert};

pub use embedded::{CukKklPebImmersion, Embedding};
pub use high_gain::{CukHighGain, Form};
pub use immersion::CukImmersion;
pub use kkl::CukKkl;
pub use peb::{CukKklPeb, CukPeb};

/// The numbers of section V.C of the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning<T> {
    /// Pole of the filters F and W, 1/s.
    pub alpha: T,
    /// Gain of the estimator of the [KKL+PEB]O.
    pub gamma: T,
    /// Gains of the estimator of the PEBO, the diagonal of Gamma.
    pub gains: [T; 2],
    /// Gain g1 of the I&IO.
    pub g1: T,
    /// Gain g2 of the I&IO.
    pub g2: T,
    /// Small number of the time-varying high-gain observer.
    pub r1: T,
    /// Small number of the other two.
    pub r2: T,
    /// Coefficients alpha_1 to alpha_4 of the high-gain observers.
    pub coefficients: [T; 4],
}

impl<T: RealField + Copy> Default for Tuning<T> {
    /// As printed: alpha = 0.5, gamma = 0.001, Gamma = diag(0.001, 100), g = (50, 1), r = (0.05, 0.005), alpha_i = (2,
    /// 1, 2, 1).
    fn default() -> Self {
        let number = |value: f64| convert::<f64, T>(value);
        Self {
            alpha: number(0.5),
            gamma: number(0.001),
            gains: [number(0.001), number(100.0)],
            g1: number(50.0),
            g2: number(1.0),
            r1: number(0.05),
            r2: number(0.005),
            coefficients: [number(2.0), number(1.0), number(2.0), number(1.0)],
        }
    }
}

/// The KKLO.
pub type CukKklo = KklObserver<CukKkl>;
/// The PEBO, with a state of length 12: xi, w and `F[g]` of length 2, `F[m]` 2 x 2, theta_hat.
pub type CukPebo<T> = KklPebObserver<CukPeb, Gradient<T, U2>, T>;
/// The [KKL+PEB]O, with a state of length 6: xi of length 2, w, `F[g]`, `F[m]`, theta_hat.
pub type CukKklPebo<T> = KklPebObserver<CukKklPeb, Gradient<T, U1>, T>;
/// The I&IO.
pub type CukImmersionInvariance = ImmersionInvarianceObserver<CukConverter, CukImmersion>;
/// The [KKL+PEB]O written as an I&IO, with a state of length 6: that of the [KKL+PEB]O.
pub type CukImmersedKklPebo = ImmersionInvarianceObserver<CukConverter, CukKklPebImmersion>;
/// One of the high-gain observers.
pub type CukHighGainObserver<T> = HighGainObserver<CukHighGain, T, Const<4>>;

/// The KKLO: `xi1' = -(G/C4) xi1 + y2/C4`, `xi2' = -(w/L1) xi2 - (1 + C2/L1) w y1 + E - u y2`,
/// `xhat = ((xi2 + C2 y1)/L1, xi1)`.
///
/// ```
/// use luenberger_observers::Observer;
/// use luenberger_reproduce::kkl::cuk;
/// use luenberger_plants::{CukConverter, Plant};
/// use nalgebra::{Vector1, Vector2};
/// let converter = CukConverter::default();
/// let observer = cuk::kklo(converter)?;
/// // In the equilibrium, started there, it stays there.
/// let (x, u) = (converter.equilibrium(10.0), Vector1::new(converter.equilibrium_input(10.0)));
/// let y = converter.output(0.0, &x, &u);
/// let xi = observer.initial(0.0, &Vector2::new(x[0], x[3]), &u, &y);
/// // Terms of 12 V, and of 1 A/C4: their rounding.
/// let slope = observer.derivative(0.0, &xi, &u, &y);
/// assert!(slope[0].abs() <= 4.0 * f64::EPSILON / converter.c4 && slope[1].abs() <= 64.0 * f64::EPSILON);
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
/// # Errors
/// [`ObserverError::Matrix`] for a parameter of the converter that is not positive.
pub fn kklo(converter: CukConverter) -> Result<CukKklo, ObserverError> {
    converter.check()?;
    Ok(KklObserver::new(CukKkl { converter }))
}

/// The PEBO: `xi' = ((E - w y1)/L1, (y2 + G u y1)/C4)`, `M = diag(F[w]/C2, -F[1]/L3)`,
/// `Y1 = W[y1] - F[w xi1 + u y2]/C2`, `Y2 = W[y2] + F[(u y1 + xi2)/L3 + (G/C4) y2]`,
/// `xhat = xi + theta_hat + (0, G L3 y2/C4)`, with the gradient estimator.
///
/// # Errors
/// As [`kklo`], and [`ObserverError::NotPositive`], [`ObserverError::NotDefinite`] for the tuning.
pub fn pebo<T: RealField + Copy>(converter: CukConverter, tuning: &Tuning<T>) -> Result<CukPebo<T>, ObserverError> {
    converter.check()?;
    let gain = Matrix2::new(tuning.gains[0], T::zero(), T::zero(), tuning.gains[1]);
    KklPebObserver::new(CukPeb { converter }, Gradient::new(gain)?, tuning.alpha)
}

/// The [KKL+PEB]O: `xi' = ((E - w y1)/L1, (y2 - G xi2)/C4)`, `Y = W[y1] - F[w xi1 + u y2]/C2`, `M = F[w]/C2`,
/// `xhat = (xi1 + theta_hat, xi2)`, with the gradient estimator.
///
/// # Errors
/// As [`pebo`].
pub fn kkl_pebo<T: RealField + Copy>(
    converter: CukConverter,
    tuning: &Tuning<T>,
) -> Result<CukKklPebo<T>, ObserverError> {
    converter.check()?;
    KklPebObserver::new(CukKklPeb { converter }, Gradient::new(Matrix1::new(tuning.gamma))?, tuning.alpha)
}

/// The I&IO with `beta = (chi1 + C2 g1 y1, chi2 - L3 g2 y2)` and `phi = (i1, v4)`:
/// `chi1' = -g1 (w (chi1 + C2 g1 y1) + u y2) + (E - w y1)/L1`, `chi2' = (y2 - G v4hat)/C4 - g2 (u y1 + v4hat)`,
/// `xhat = beta`.
///
/// # Errors
/// As [`kklo`], and [`ObserverError::Matrix`] for gains that are not finite. That `g1 > 0` and `G/C4 + g2 > 0`, which
/// convergence needs, is not checked.
pub fn immersion_invariance<T: RealField + Copy>(
    converter: CukConverter,
    tuning: &Tuning<T>,
) -> Result<CukImmersionInvariance, ObserverError> {
    converter.check()?;
    luenberger_plants::error::check_matrix("(g1, g2)", &Vector2::new(tuning.g1, tuning.g2), (2, 1))?;
    let (g1, g2) = (tuning.g1.to_subset_unchecked(), tuning.g2.to_subset_unchecked());
    Ok(ImmersionInvarianceObserver::new(converter, CukImmersion { converter, g1, g2 }))
}

/// Proposition 5: the [KKL+PEB]O as an I&IO with `beta = (xi1 + theta_hat, xi2)` and `phi = (i1, v4)`, chi being its
/// whole state.
///
/// With [`Embedding::Equivalent`] it is the [KKL+PEB]O, slope by slope; as printed the error of i1 stands still.
/// ```
/// use luenberger_observers::Observer;
/// use luenberger_plants::CukConverter;
/// use luenberger_reproduce::kkl::cuk::{self, Embedding, Tuning};
/// use nalgebra::{Vector1, Vector2, Vector6};
/// let (converter, tuning) = (CukConverter::default(), Tuning::<f64>::default());
/// let original = cuk::kkl_pebo(converter, &tuning)?;
/// let immersed = cuk::kkl_pebo_immersed(converter, &tuning, Embedding::Equivalent)?;
/// let (chi, u, y) = (Vector6::new(0.3, -8.0, 17.0, 0.0, 100.0, 0.1), Vector1::new(0.5), Vector2::new(18.0, 0.25));
/// let slope: Vector6<f64> = immersed.derivative(0.0, &chi, &u, &y);
/// let claimed = original.derivative(0.0, &chi, &u, &y);
/// // Sums of a few terms of the size of the largest.
/// assert!((slope - claimed).amax() <= 16.0 * f64::EPSILON * claimed.amax());
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
/// # Errors
/// As [`kkl_pebo`].
pub fn kkl_pebo_immersed<T: RealField + Copy>(
    converter: CukConverter,
    tuning: &Tuning<T>,
    embedding: Embedding,
) -> Result<CukImmersedKklPebo, ObserverError> {
    kkl_pebo(converter, tuning)?;
    let (alpha, gamma) = (tuning.alpha.to_subset_unchecked(), tuning.gamma.to_subset_unchecked());
    Ok(ImmersionInvarianceObserver::new(converter, CukKklPebImmersion { converter, alpha, gamma, embedding }))
}

/// The high-gain observer with time-varying error dynamics: `xi1' = (w xi2 + u y2)/C2 + (a1/r1) e1`,
/// `xi2' = (E - w y1)/L1 + (a2/r1^2) e1`, `xi3' = -(xi4 + u y1)/L3 + (a3/r1) e2`,
/// `xi4' = (y2 - G xi4)/C4 - (a4/r1^2) e2`, `xhat = (xi2, xi4)`, `e = (y1 - xi1, y2 - xi3)`.
///
/// # Errors
/// As [`kklo`], and [`ObserverError::NotPositive`] for the tuning.
pub fn high_gain_time_varying<T: RealField + Copy>(
    converter: CukConverter,
    tuning: &Tuning<T>,
) -> Result<CukHighGainObserver<T>, ObserverError> {
    high_gain_of(converter, Form::TimeVarying, tuning.coefficients, tuning.r1)
}

/// The high-gain observer with linear time-invariant error dynamics, which differentiates: `xi1' = xi2 + (a1/r2) e1`,
/// `xi2' = (a2/r2^2) e1`, the same for xi3 and xi4, `xhat = ((C2 xi2 - u y2)/w, -L3 xi4 - u y1)`.
///
/// # Errors
/// As [`high_gain_time_varying`].
pub fn high_gain_differentiator<T: RealField + Copy>(
    converter: CukConverter,
    tuning: &Tuning<T>,
) -> Result<CukHighGainObserver<T>, ObserverError> {
    high_gain_of(converter, Form::Differentiator, tuning.coefficients, tuning.r2)
}

/// The exact high-gain observer: that of [`high_gain_time_varying`] with the corrections shaped so that r2 alone sets
/// the poles of the first chain: `xi2' = (E - w y1)/L1 + (C2/w) (a2/r2^2) e1`,
/// `xi4' = (y2 - G xi4)/C4 - L3 (a4/r2^2) e2`. Not in the paper.
///
/// # Errors
/// As [`high_gain_time_varying`].
pub fn high_gain_exact<T: RealField + Copy>(
    converter: CukConverter,
    tuning: &Tuning<T>,
) -> Result<CukHighGainObserver<T>, ObserverError> {
    high_gain_of(converter, Form::Exact, tuning.coefficients, tuning.r2)
}

/// (i1, v4) of the four states.
fn unmeasured<T: RealField + Copy>(x: &Vector4<T>) -> Vector2<T> {
    Vector2::new(x[0], x[3])
}

/// The four states of (i1, v4) and the outputs.
fn complete<T: RealField + Copy>(z: &Vector2<T>, y: &Vector2<T>) -> Vector4<T> {
    Vector4::new(z[0], y[0], y[1], z[1])
}

fn high_gain_of<T: RealField + Copy>(
    converter: CukConverter,
    form: Form,
    coefficients: [T; 4],
    r: T,
) -> Result<CukHighGainObserver<T>, ObserverError> {
    converter.check()?;
    HighGainObserver::<_, T, U4>::new(CukHighGain { converter, form }, Vector4::from(coefficients), r)
}

/// The rates of the plant's states, as far as they are needed, with what is known beside the unknown i1 and v4. This is
/// where the converter's equations stand for all of its observers.
#[derive(Clone, Copy, Debug)]
struct Equations<T> {
    l1: T,
    c2: T,
    l3: T,
    c4: T,
    g: T,
    e: T,
    u: T,
    w: T,
    y1: T,
    y2: T,
}

impl<T: RealField + Copy> Equations<T> {
    fn new(converter: &CukConverter, u: &nalgebra::Vector1<T>, y: &Vector2<T>) -> Self {
        let number = |value: f64| convert::<f64, T>(value);
        Self {
            l1: number(converter.l1),
            c2: number(converter.c2),
            l3: number(converter.l3),
            c4: number(converter.c4),
            g: number(converter.g),
            e: number(converter.e),
            u: u[0],
            w: T::one() - u[0],
            y1: y[0],
            y2: y[1],
        }
    }

    /// `i1' = (E - w y1)/L1`, all of it known.
    fn i1_rate(&self) -> T {
        (self.e - self.w * self.y1) / self.l1
    }

    /// `y1' = (w i1 + u y2)/C2`.
    fn y1_rate(&self, i1: T) -> T {
        (self.w * i1 + self.u * self.y2) / self.c2
    }

    /// `y2' = -(u y1 + v4)/L3`.
    fn y2_rate(&self, v4: T) -> T {
        -(self.u * self.y1 + v4) / self.l3
    }

    /// `v4' = (y2 - G v4)/C4`.
    fn v4_rate(&self, v4: T) -> T {
        (self.y2 - self.g * v4) / self.c4
    }
}
