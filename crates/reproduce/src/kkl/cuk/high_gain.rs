//! The maps of the three high-gain observers: chains (v2, i1) and (i3, v4).

use luenberger_plants::CukConverter;
use nalgebra::{RealField, U1, U2, U4, Vector1, Vector2, Vector4};

use super::Equations;
use luenberger_observers::high_gain::{ChainPosition, HighGainMap};

/// Which of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// The plant's equations, corrections as in Table I.
    TimeVarying,
    /// Two differentiators; the plant's equations only give xhat from the derivatives of y.
    Differentiator,
    /// The plant's equations, corrections divided by what i1 and v4 enter y' with.
    Exact,
}

/// The maps of the high-gain observer of this form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CukHighGain {
    pub(super) converter: CukConverter,
    pub(super) form: Form,
}

impl<T: RealField + Copy> HighGainMap<T> for CukHighGain {
    type Xi = U4;
    type Inputs = U1;
    type Outputs = U2;
    type Estimate = U2;

    fn place(&self, i: usize) -> ChainPosition {
        ChainPosition { output: i / 2, position: 1 + i % 2 }
    }

    fn drift(&self, _t: T, xi: &Vector4<T>, u: &Vector1<T>, y: &Vector2<T>) -> Vector4<T> {
        let known = Equations::new(&self.converter, u, y);
        match self.form {
            Form::Differentiator => Vector4::new(xi[1], T::zero(), xi[3], T::zero()),
            Form::TimeVarying | Form::Exact => {
                Vector4::new(known.y1_rate(xi[1]), known.i1_rate(), known.y2_rate(xi[3]), known.v4_rate(xi[3]))
            }
        }
    }

    fn shape(&self, _t: T, u: &Vector1<T>, y: &Vector2<T>) -> Vector4<T> {
        let known = Equations::new(&self.converter, u, y);
        let one = T::one();
        match self.form {
            Form::Differentiator => Vector4::repeat(one),
            Form::TimeVarying => Vector4::new(one, one, one, -one),
            Form::Exact => Vector4::new(one, known.c2 / divisor(known.w), one, -known.l3),
        }
    }

    fn estimate(&self, _t: T, xi: &Vector4<T>, u: &Vector1<T>, y: &Vector2<T>) -> Vector2<T> {
        let known = Equations::new(&self.converter, u, y);
        match self.form {
            Form::Differentiator => Vector2::new(
                (known.c2 * xi[1] - known.u * known.y2) / divisor(known.w),
                -known.l3 * xi[3] - known.u * known.y1,
            ),
            Form::TimeVarying | Form::Exact => Vector2::new(xi[1], xi[3]),
        }
    }

    fn start(&self, _t: T, estimate: &Vector2<T>, u: &Vector1<T>, y: &Vector2<T>) -> Vector4<T> {
        let known = Equations::new(&self.converter, u, y);
        match self.form {
            Form::Differentiator => Vector4::new(y[0], known.y1_rate(estimate[0]), y[1], known.y2_rate(estimate[1])),
            Form::TimeVarying | Form::Exact => Vector4::new(y[0], estimate[0], y[1], estimate[1]),
        }
    }

    fn divisor(&self, _t: T, u: &Vector1<T>, _y: &Vector2<T>) -> Option<(T, T)> {
        match self.form {
            Form::TimeVarying => None,
            Form::Differentiator | Form::Exact => Some((T::one() - u[0], floor())),
        }
    }
}

/// w as what is divided by: the duty cycle ends below 1, and what lies beyond must not divide by zero.
fn divisor<T: RealField + Copy>(w: T) -> T {
    w.max(floor())
}

/// Half of the digits: below it `1 - u` has no more than the other half.
fn floor<T: RealField + Copy>() -> T {
    T::default_epsilon().sqrt()
}
