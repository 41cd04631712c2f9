//! A plant behind a reference, so that the module has the code of simulation and of observers once.

use luenberger_plants::{Differentiable, Dimensions, Plant, Shape};
use nalgebra::{DMatrix, DVector, Dyn};

/// Any plant with columns of dynamic length.
#[derive(Clone, Copy)]
pub(crate) struct AnyPlant<'a>(pub(crate) &'a (dyn Differentiable<f64, Dyn, Dyn, Dyn> + Send + Sync));

type Pair = (DVector<f64>, DVector<f64>);

impl Shape for AnyPlant<'_> {
    fn dimensions(&self) -> Dimensions {
        self.0.dimensions()
    }
}

// Every method is that of the plant, also those with a default: the same to the last bit, and as fast.
impl Plant<f64> for AnyPlant<'_> {
    type State = DVector<f64>;
    type Input = DVector<f64>;
    type Output = DVector<f64>;

    fn derivative(&self, t: f64, x: &DVector<f64>, u: &DVector<f64>) -> DVector<f64> {
        self.0.derivative(t, x, u)
    }

    fn output(&self, t: f64, x: &DVector<f64>, u: &DVector<f64>) -> DVector<f64> {
        self.0.output(t, x, u)
    }

    fn is_affine(&self) -> bool {
        self.0.is_affine()
    }

    fn derivative_into(&self, t: f64, x: &[f64], u: &[f64], slope: &mut [f64]) -> bool {
        self.0.derivative_into(t, x, u, slope)
    }

    fn output_into(&self, t: f64, x: &[f64], u: &[f64], y: &mut [f64]) -> bool {
        self.0.output_into(t, x, u, y)
    }
}

impl Differentiable<f64, Dyn, Dyn, Dyn> for AnyPlant<'_> {
    fn directional(&self, t: f64, x: &DVector<f64>, u: &DVector<f64>, v: &DVector<f64>) -> Pair {
        self.0.directional(t, x, u, v)
    }

    fn output_directional(&self, t: f64, x: &DVector<f64>, u: &DVector<f64>, v: &DVector<f64>) -> Pair {
        self.0.output_directional(t, x, u, v)
    }

    fn state_jacobian(&self, t: f64, x: &DVector<f64>, u: &DVector<f64>) -> DMatrix<f64> {
        self.0.state_jacobian(t, x, u)
    }

    fn output_jacobian(&self, t: f64, x: &DVector<f64>, u: &DVector<f64>) -> DMatrix<f64> {
        self.0.output_jacobian(t, x, u)
    }

    fn is_linear_between_samples(&self) -> bool {
        self.0.is_linear_between_samples()
    }

    fn motion_into(&self, t: f64, x: &[f64], u: &[f64], f: &mut [f64], df: &mut [f64]) -> bool {
        self.0.motion_into(t, x, u, f, df)
    }

    fn measurement_into(&self, t: f64, x: &[f64], u: &[f64], h: &mut [f64], dh: &mut [f64]) -> bool {
        self.0.measurement_into(t, x, u, h, dh)
    }
}
