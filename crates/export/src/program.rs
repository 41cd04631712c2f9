//! The observers that can be exported, and their steps in the format of the target.

use luenberger_observers::{
    DiscreteLinearObserver, ObserverDimensions, ObserverError, SampledCubicGains, SampledCubicObserver, SampledObserver,
};
use luenberger_plants::LinearPlant;
use nalgebra::{DMatrix, DVector, Dyn, RealField};

use crate::error::ExportError;

/// The format of numbers on the target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    /// IEEE 754 binary32, `float`.
    Binary32,
    /// IEEE 754 binary64, `double`.
    Binary64,
}

impl Scalar {
    /// `f32` or `f64`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Binary32 => "f32",
            Self::Binary64 => "f64",
        }
    }

    /// Bytes of a number.
    pub fn bytes(self) -> usize {
        match self {
            Self::Binary32 => 4,
            Self::Binary64 => 8,
        }
    }

    /// The nearest number of the format; infinite beyond its range.
    pub fn round(self, x: f64) -> f64 {
        match self {
            Self::Binary32 => f64::from(x as f32),
            Self::Binary64 => x,
        }
    }
}

/// An observer that is stepped once per sample, with numbers as designed.
#[derive(Debug, Clone, PartialEq)]
pub enum Program {
    /// `xhat+ = Ad xhat + Bd u + Ld (y - C xhat)`.
    Linear(DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>),
    /// The sampled cubic observer.
    Cubic(SampledCubicObserver<f64, Dyn, Dyn, Dyn>),
}

impl Program {
    /// Lengths of the columns.
    pub fn dimensions(&self) -> ObserverDimensions {
        match self {
            Self::Linear(observer) => observer.dimensions(),
            Self::Cubic(observer) => observer.dimensions(),
        }
    }

    /// The sampling period.
    pub fn period(&self) -> f64 {
        match self {
            Self::Linear(observer) => observer.period(),
            Self::Cubic(observer) => observer.period(),
        }
    }

    /// The matrices that the step uses, by the names they have in the emitted code.
    pub fn matrices(&self) -> Vec<(&'static str, &DMatrix<f64>)> {
        let mut all = match self {
            Self::Linear(observer) => {
                let plant = observer.plant();
                vec![("A", &plant.a), ("B", &plant.b), ("C", &plant.c), ("L", observer.l())]
            }
            Self::Cubic(observer) => vec![
                ("A", observer.ad()),
                ("B", observer.bd()),
                ("C", observer.c()),
                ("L", observer.ld()),
                ("N", observer.n()),
                ("THETA", observer.theta()),
            ],
        };
        all.extend(self.feedthrough().map(|d| ("D", d)));
        all
    }

    /// A, B and C of the plant.
    pub(crate) fn plant(&self) -> Option<(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>)> {
        Some(match self {
            Self::Linear(observer) => (&observer.plant().a, &observer.plant().b, &observer.plant().c),
            Self::Cubic(observer) => (observer.ad(), observer.bd(), observer.c()),
        })
    }

    /// Feedthrough, if there is one.
    pub fn feedthrough(&self) -> Option<&DMatrix<f64>> {
        match self {
            Self::Linear(observer) => observer.plant().d.as_ref(),
            Self::Cubic(observer) => observer.d(),
        }
    }

    /// The scalars that the step uses, by the names they have in the emitted code; the period is one of them.
    pub fn scalars(&self) -> Vec<(&'static str, f64)> {
        match self {
            Self::Linear(observer) => vec![("PERIOD", observer.period())],
            Self::Cubic(observer) => vec![("PERIOD", observer.period()), ("W", observer.w())],
        }
    }

    /// Checks that the format can store every number, and that the rounded ones still make an observer.
    pub(crate) fn check(&self, scalar: Scalar) -> Result<(), ExportError> {
        for (name, matrix) in self.matrices() {
            if let Some(k) = matrix.iter().position(|x| !scalar.round(*x).is_finite()) {
                let (row, column) = (k % matrix.nrows(), k / matrix.nrows());
                let what = format!("{name}({row}, {column}) = {}", matrix[(row, column)]);
                return Err(ExportError::Format { what, format: scalar.name() });
            }
        }
        for (name, x) in self.scalars() {
            if !scalar.round(x).is_finite() {
                return Err(ExportError::Format { what: format!("{name} = {x}"), format: scalar.name() });
            }
        }
        let checked = match scalar {
            Scalar::Binary32 => self.cast::<f32>().map(|_| ()),
            Scalar::Binary64 => Ok(()),
        };
        checked.map_err(|error| ExportError::Rounded { format: scalar.name(), error })
    }

    /// The observer over the scalar `T`.
    pub(crate) fn cast<T: RealField + Copy>(&self) -> Result<Cast<T>, ObserverError> {
        let cast = |m: &DMatrix<f64>| m.map(nalgebra::convert::<f64, T>);
        Ok(match self {
            Self::Linear(observer) => {
                let LinearPlant { a, b, c, d } = observer.plant();
                let plant = LinearPlant::new(cast(a), cast(b), cast(c))?;
                let plant = match d {
                    Some(d) => plant.with_feedthrough(cast(d))?,
                    None => plant,
                };
                let period = nalgebra::convert(observer.period());
                Cast::Linear(DiscreteLinearObserver::new(plant, cast(observer.l()), period)?)
            }
            Self::Cubic(observer) => {
                let same = SampledCubicObserver::new(SampledCubicGains {
                    ad: cast(observer.ad()),
                    bd: cast(observer.bd()),
                    c: cast(observer.c()),
                    ld: cast(observer.ld()),
                    n: cast(observer.n()),
                    theta: cast(observer.theta()),
                    w: nalgebra::convert(observer.w()),
                    period: nalgebra::convert(observer.period()),
                })?;
                Cast::Cubic(match observer.d() {
                    Some(d) => same.with_feedthrough(cast(d))?,
                    None => same,
                })
            }
        })
    }

    /// Floating-point operations of one step.
    pub(crate) fn operations(&self) -> usize {
        let ObserverDimensions { state: n, inputs: m, outputs: p, .. } = self.dimensions();
        let product = |rows: usize, columns: usize| if columns == 0 { 0 } else { rows * (2 * columns - 1) };
        let innovation = product(p, n) + p + self.feedthrough().map_or(0, |_| product(p, m) + p);
        let linear = product(n, n) + product(n, m) + product(n, p) + 2 * n;
        match self {
            Self::Linear(_) => innovation + linear,
            // The flow: direction, quadratic form, two roots, three divisions; then the impulse.
            Self::Cubic(_) => innovation + linear + 3 * p + product(p, p) + product(1, p) + 15 + product(n, p) + n,
        }
    }
}

/// An observer over the scalar of the target.
#[derive(Debug, Clone)]
pub(crate) enum Cast<T: RealField + Copy> {
    Linear(DiscreteLinearObserver<T, Dyn, Dyn, Dyn>),
    Cubic(SampledCubicObserver<T, Dyn, Dyn, Dyn>),
}

impl<T: RealField + Copy> Cast<T> {
    pub(crate) fn step(&self, xhat: &mut DVector<T>, u: &DVector<T>, y: &DVector<T>) {
        match self {
            Self::Linear(observer) => observer.step(T::zero(), xhat, u, y),
            Self::Cubic(observer) => observer.step(T::zero(), xhat, u, y),
        }
    }
}
