//! The averaged DC-DC Cuk converter, with its state-feedback controller and its equilibria.
//!
//! ```text
//! L1 i1' = -w v2 + E                   w = 1 - u, u the duty cycle in (0, 1)
//! C2 v2' =  w i1 + u i3
//! L3 i3' = -u v2 - v4
//! C4 v4' =  i3 - G v4
//! ```
//!
//! x = (i1, v2, i3, v4): the currents of the two inductors and the voltages of the two capacitors. Measured are y =
//! (v2, i3); v4 < 0 is the output voltage of an inverting converter, whose magnitude |Vd| is the set-point.
//!
//! Sources: B. Yi, R. Ortega and W. Zhang, IEEE Transactions on Automatic Control, 2018, section V.C (the inductance L3
//! is not printed there); H. Rodriguez, R. Ortega and A. Astolfi, American Control Conference 2005, for the controller.

use nalgebra::{RealField, Vector1, Vector2, Vector4, convert};

use crate::error::PlantError;
use crate::plant::{Dimensions, Plant, Shape};

/// The converter: parameters in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CukConverter {
    /// Inductance at the input L1, in H.
    pub l1: f64,
    /// Capacitance of the coupling capacitor C2, in F.
    pub c2: f64,
    /// Inductance at the output L3, in H.
    pub l3: f64,
    /// Capacitance at the output C4, in F.
    pub c4: f64,
    /// Conductance of the load G, in S.
    pub g: f64,
    /// Voltage of the source E, in V.
    pub e: f64,
}

impl Default for CukConverter {
    /// The parameters of the paper; L3, which it does not print, is 10 mH like L1.
    fn default() -> Self {
        Self { l1: 0.01, c2: 22.0e-6, l3: 0.01, c4: 22.9e-6, g: 0.0447, e: 12.0 }
    }
}

/// A duty cycle outside of (0, 1).
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the duty cycle is {u}, which is {beyond:.2e} outside of (0, 1), where the averaged model is not valid")]
pub struct DutyCycleError {
    /// The duty cycle.
    pub u: f64,
    /// Distance of u from the interval [0, 1]: 0 for u = 0 and u = 1; NaN for NaN.
    pub beyond: f64,
}

/// Checks that 0 < u < 1, the range in which the averaged model is valid.
///
/// ```
/// use luenberger_plants::cuk::check_duty_cycle;
/// assert!(check_duty_cycle(0.5).is_ok());
/// assert_eq!(check_duty_cycle(1.25).unwrap_err().beyond, 0.25);
/// assert!(check_duty_cycle(f64::NAN).is_err());
/// ```
/// # Errors
/// [`DutyCycleError`] says how far outside u lies.
pub fn check_duty_cycle(u: f64) -> Result<(), DutyCycleError> {
    if u > 0.0 && u < 1.0 {
        return Ok(());
    }
    let beyond = if u <= 0.0 { -u } else { u - 1.0 };
    Err(DutyCycleError { u, beyond })
}

impl CukConverter {
    /// Checks that all parameters are positive and finite.
    ///
    /// # Errors
    /// [`PlantError::NotPositive`] names the first that is not.
    pub fn check(&self) -> Result<(), PlantError> {
        let parameters =
            [("L1", self.l1), ("C2", self.c2), ("L3", self.l3), ("C4", self.c4), ("G", self.g), ("E", self.e)];
        match parameters.into_iter().find(|&(_, value)| !(value.is_finite() && value > 0.0)) {
            Some((what, value)) => Err(PlantError::NotPositive { what, value }),
            None => Ok(()),
        }
    }

    /// The duty cycle that holds the output at `v4 = -vd`: `u = |Vd|/(|Vd| + E)`.
    pub fn equilibrium_input(&self, vd: f64) -> f64 {
        let vd = vd.abs();
        vd / (vd + self.e)
    }

    /// The equilibrium with output `v4 = -|Vd|`, as (i1, v2, i3, v4).
    ///
    /// ```
    /// use luenberger_plants::{CukConverter, Plant};
    /// use nalgebra::{Vector1, Vector4};
    /// let converter = CukConverter::default();
    /// let (x, u) = (converter.equilibrium(5.0), converter.equilibrium_input(5.0));
    /// assert!((x - Vector4::new(0.093125, 17.0, -0.2235, -5.0)).amax() < 1e-15);
    /// // i' and v' there: rounding of terms of about 10 V over 10 mH, and of 0.1 A over 22 uF.
    /// assert!(converter.derivative(0.0, &x, &Vector1::new(u)).amax() <= 4.0 * f64::EPSILON * 1e4);
    /// ```
    pub fn equilibrium(&self, vd: f64) -> Vector4<f64> {
        let vd = vd.abs();
        Vector4::new(self.g * vd * vd / self.e, vd + self.e, -self.g * vd, -vd)
    }

    /// The controller `u = |Vd|/(|Vd| + E) + lambda q/(1 + q^2)`, `q = G |Vd| v2 + E (i3 - i1)`; it uses i1, which is
    /// not measured. lambda = 0.2 gives the figures of the paper.
    ///
    /// The second term is at most lambda/2 in magnitude. For large set-points that can take u out of (0, 1):
    /// [`check_duty_cycle`] says by how much, and [`input_bounds`](Self::input_bounds) says beforehand whether it can
    /// happen.
    ///
    /// ```
    /// let converter = luenberger_plants::CukConverter::default();
    /// // q = 0 in the equilibrium.
    /// let u = converter.control(&converter.equilibrium(10.0), 10.0, 0.2);
    /// assert!((u - 10.0 / 22.0).abs() < 1e-15);
    /// ```
    pub fn control(&self, x: &Vector4<f64>, vd: f64, lambda: f64) -> f64 {
        let q = self.g * vd.abs() * x[1] + self.e * (x[2] - x[0]);
        // q/(1 + q^2), which does not overflow.
        let bump = if q.abs() > 1.0 { 1.0 / (q + 1.0 / q) } else { q / (1.0 + q * q) };
        self.equilibrium_input(vd) + lambda * bump
    }

    /// Lower and upper bound of [`control`](Self::control) over all states, for this set-point.
    ///
    /// # Errors
    /// [`DutyCycleError`] for the bound that lies outside of (0, 1), if one does: then some states lead to an input
    /// that no converter can have.
    ///
    /// ```
    /// let converter = luenberger_plants::CukConverter::default();
    /// assert!(converter.input_bounds(25.0, 0.2).is_ok());
    /// // 120/132 + 0.1 > 1.
    /// assert!(converter.input_bounds(120.0, 0.2).unwrap_err().u > 1.0);
    /// ```
    pub fn input_bounds(&self, vd: f64, lambda: f64) -> Result<(f64, f64), DutyCycleError> {
        let (middle, half) = (self.equilibrium_input(vd), lambda.abs() / 2.0);
        let (low, high) = (middle - half, middle + half);
        check_duty_cycle(low)?;
        check_duty_cycle(high)?;
        Ok((low, high))
    }
}

impl Shape for CukConverter {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: 4, inputs: 1, outputs: 2 }
    }
}

impl<T: RealField + Copy> Plant<T> for CukConverter {
    type State = Vector4<T>;
    type Input = Vector1<T>;
    type Output = Vector2<T>;

    fn derivative(&self, _t: T, x: &Vector4<T>, u: &Vector1<T>) -> Vector4<T> {
        let number = |value: f64| convert::<f64, T>(value);
        let (u, w) = (u[0], T::one() - u[0]);
        let [i1, v2, i3, v4] = [x[0], x[1], x[2], x[3]];
        Vector4::new(
            (number(self.e) - w * v2) / number(self.l1),
            (w * i1 + u * i3) / number(self.c2),
            -(u * v2 + v4) / number(self.l3),
            (i3 - number(self.g) * v4) / number(self.c4),
        )
    }

    fn output(&self, _t: T, x: &Vector4<T>, _u: &Self::Input) -> Vector2<T> {
        Vector2::new(x[1], x[2])
    }
}

#[cfg(feature = "dual")]
impl crate::jacobian::ByDual for CukConverter {}

/// Without dual numbers: f is affine in x, so that its derivative along v is `f(v) - f(0)`.
#[cfg(not(feature = "dual"))]
impl<T: RealField + Copy> crate::jacobian::Differentiable<T, nalgebra::U4, nalgebra::U1, nalgebra::U2>
    for CukConverter
{
    fn directional(&self, t: T, x: &Vector4<T>, u: &Vector1<T>, v: &Vector4<T>) -> (Vector4<T>, Vector4<T>) {
        (self.derivative(t, x, u), self.derivative(t, v, u) - self.derivative(t, &Vector4::zeros(), u))
    }

    fn output_directional(&self, t: T, x: &Vector4<T>, u: &Vector1<T>, v: &Vector4<T>) -> (Vector2<T>, Vector2<T>) {
        (self.output(t, x, u), self.output(t, v, u))
    }
}
