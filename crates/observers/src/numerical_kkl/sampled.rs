//! The numerical KKL observer stepped once per sample: `z' = D z + B w` between samples, with an
//! output w that a copy of the plant predicts from the last measurement.
//!
//! ```text
//! x' = f(x),                      x(t_k) = xhat = T^-L(z)
//! z' = D z + B (y_k + h(x) - h(xhat))
//! ```
//!
//! by so many steps of the classical Runge-Kutta method. T^-L amplifies what z has wrong; a measurement that is held
//! instead delays z by half a period. With the error e of the estimate small, w differs from y by `O(h |e|)`.
//!
//! Source of the prediction: I. Karafyllis and C. Kravaris, From continuous-time design to sampled-data design of
//! observers, IEEE Transactions on Automatic Control 54, 2009.

use luenberger_plants::Plant;
use luenberger_plants::error::check_matrix;
use nalgebra::{RealField, SMatrix, SVector, convert};

use crate::dense::times;
use crate::error::ObserverError;
use crate::numerical_kkl::{BoxMap, InterpolatedInverse, Node, PolynomialInverse};
use crate::observer::{ObserverDimensions, SampledObserver};
use crate::runge_kutta;

/// The filter `z' = D z + B w` and how it is stepped; see the [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledFilter<T, const P: usize, const Z: usize> {
    /// D.
    pub d: SMatrix<T, Z, Z>,
    /// B.
    pub b: SMatrix<T, Z, P>,
    /// The sampling period.
    pub period: T,
    /// Runge-Kutta steps between two samples.
    pub substeps: usize,
}

impl<T: RealField + Copy, const P: usize, const Z: usize> SampledFilter<T, P, Z> {
    /// # Errors
    /// [`ObserverError::Matrix`] for entries that are not finite, [`ObserverError::Period`],
    /// [`ObserverError::Substeps`].
    pub(super) fn check(&self) -> Result<(), ObserverError> {
        check_matrix("D", &self.d, (Z, Z))?;
        check_matrix("B", &self.b, (Z, P))?;
        if !(self.period.is_finite() && self.period > T::zero()) {
            return Err(ObserverError::Period { period: self.period.to_subset_unchecked() });
        }
        if self.substeps == 0 { Err(ObserverError::Substeps) } else { Ok(()) }
    }

    /// z one period after the sample at `t`, with the output that the plant predicts from its state x on.
    pub(super) fn advance<S, const N: usize, const M: usize>(
        &self,
        plant: &S,
        t: T,
        (z, mut x): (&mut SVector<T, Z>, SVector<T, N>),
        (u, y): (&SVector<T, M>, &SVector<T, P>),
    ) where
        S: Plant<T, State = SVector<T, N>, Input = SVector<T, M>, Output = SVector<T, P>>,
    {
        let tau = self.period / convert::<f64, T>(self.substeps as f64);
        let offset = y - plant.output(t, &x, u);
        for k in 0..self.substeps {
            let now = t + tau * convert::<f64, T>(k as f64);
            runge_kutta::step(now, tau, (z, &mut x), |t, z, x| {
                let w = offset + plant.output(t, x, u);
                (times(&self.d, z) + times(&self.b, &w), plant.derivative(t, x, u))
            });
        }
    }
}

/// A left inverse for fixed sizes: the embedded or the interpolated form.
pub trait StateInverse<T, const N: usize, const Z: usize> {
    /// `T^-L(z)`, in the box.
    fn state(&self, z: &SVector<T, Z>) -> SVector<T, N>;

    /// `T(x)`.
    fn target(&self, x: &SVector<T, N>) -> SVector<T, Z>;
}

impl<T, K, V, const N: usize, const Z: usize> StateInverse<T, N, Z> for PolynomialInverse<T, K, V, N, Z>
where
    T: RealField + Copy,
    K: AsRef<[Node<T>]>,
    V: AsRef<[T]>,
{
    fn state(&self, z: &SVector<T, Z>) -> SVector<T, N> {
        self.state(z)
    }

    fn target(&self, x: &SVector<T, N>) -> SVector<T, Z> {
        self.target(x)
    }
}

impl<T, K, V, S, const N: usize, const Z: usize> StateInverse<T, N, Z> for InterpolatedInverse<T, K, V, N, Z, S>
where
    T: RealField + Copy,
    K: AsRef<[Node<T>]>,
    V: AsRef<[T]>,
    S: BoxMap<T, N, Z>,
{
    fn state(&self, z: &SVector<T, Z>) -> SVector<T, N> {
        self.state(z)
    }

    fn target(&self, x: &SVector<T, N>) -> SVector<T, Z> {
        self.target(x)
    }
}

/// The sampled numerical KKL observer of a plant `S` with the left inverse `I`; see the [module](self).
///
/// Fields are read through methods, because the constructor has checked them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledKkl<S, T, I, const N: usize, const M: usize, const P: usize, const Z: usize> {
    plant: S,
    filter: SampledFilter<T, P, Z>,
    inverse: I,
}

impl<S, T, I, const N: usize, const M: usize, const P: usize, const Z: usize> SampledKkl<S, T, I, N, M, P, Z>
where
    S: Plant<T, State = SVector<T, N>, Input = SVector<T, M>, Output = SVector<T, P>>,
    T: RealField + Copy,
    I: StateInverse<T, N, Z>,
{
    /// The observer with this filter and this left inverse.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for entries that are not finite, [`ObserverError::Period`],
    /// [`ObserverError::Substeps`].
    pub fn new(plant: S, filter: SampledFilter<T, P, Z>, inverse: I) -> Result<Self, ObserverError> {
        filter.check()?;
        Ok(Self { plant, filter, inverse })
    }

    /// The plant.
    pub fn plant(&self) -> &S {
        &self.plant
    }

    /// The filter.
    pub fn filter(&self) -> &SampledFilter<T, P, Z> {
        &self.filter
    }

    /// The left inverse.
    pub fn inverse(&self) -> &I {
        &self.inverse
    }
}

impl<S, T, I, const N: usize, const M: usize, const P: usize, const Z: usize> SampledObserver<T>
    for SampledKkl<S, T, I, N, M, P, Z>
where
    S: Plant<T, State = SVector<T, N>, Input = SVector<T, M>, Output = SVector<T, P>>,
    T: RealField + Copy,
    I: StateInverse<T, N, Z>,
{
    type State = SVector<T, Z>;
    type Input = SVector<T, M>;
    type Output = SVector<T, P>;
    type Estimate = SVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: Z, inputs: M, outputs: P, estimate: N }
    }

    fn period(&self) -> T {
        self.filter.period
    }

    fn step(&self, t: T, z: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        let x = self.inverse.state(z);
        self.filter.advance(&self.plant, t, (z, x), (u, y));
    }

    fn estimate(&self, z: &Self::State) -> Self::Estimate {
        self.inverse.state(z)
    }

    fn initial(&self, _t: T, estimate: &Self::Estimate, _u: &Self::Input, _y: &Self::Output) -> Self::State {
        self.inverse.target(estimate)
    }
}
