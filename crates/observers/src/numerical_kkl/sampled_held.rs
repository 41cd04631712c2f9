//! The numerical KKL observer for held inputs stepped once per sample: `z' = D z + B w` between samples, with an output
//! w that a copy of the plant predicts from the last measurement.
//!
//! ```text
//! x' = f(x, u_k),                 x(t_k) = xhat_k
//! z' = D z + B (y_k + h(x, u_k) - h(xhat_k, u_k))
//! xhat_k+1 = T^-L(z(t_k+1), u_k)
//! ```
//!
//! The estimate for the next sample belongs to the input that was held until then. Where the input jumps at a sample,
//! the copy of the plant still starts at that estimate, and `e = z - T(x, u)` begins anew.

use luenberger_plants::Plant;
use nalgebra::{RealField, SVector};

use crate::error::ObserverError;
use crate::numerical_kkl::held_inputs::HeldInputInverse;
use crate::numerical_kkl::held_trees::HeldInputTrees;
use crate::numerical_kkl::{Node, SampledFilter, TensorSpline};
use crate::observer::{ObserverDimensions, SampledObserver};

/// A left inverse for held inputs: with tables or with trees alone.
pub trait HeldStateInverse<T, const N: usize, const M: usize, const Z: usize> {
    /// `T^-L(z, u)`, in the box.
    fn state(&self, z: &SVector<T, Z>, u: &SVector<T, M>) -> SVector<T, N>;

    /// `T(x, u)`.
    fn target(&self, x: &SVector<T, N>, u: &SVector<T, M>) -> SVector<T, Z>;
}

impl<T, K, V, S, const N: usize, const M: usize, const Z: usize, const ZM: usize> HeldStateInverse<T, N, M, Z>
    for HeldInputInverse<T, K, V, S, N, M, Z, ZM>
where
    T: RealField + Copy,
    K: AsRef<[Node<T>]>,
    V: AsRef<[T]>,
    S: AsRef<[TensorSpline<T, V, N, Z>]>,
{
    fn state(&self, z: &SVector<T, Z>, u: &SVector<T, M>) -> SVector<T, N> {
        self.state(z, u)
    }

    fn target(&self, x: &SVector<T, N>, u: &SVector<T, M>) -> SVector<T, Z> {
        self.tables().target(x, u)
    }
}

impl<T, K, V, const N: usize, const M: usize, const Z: usize, const ZM: usize, const NM: usize>
    HeldStateInverse<T, N, M, Z> for HeldInputTrees<T, K, V, N, M, Z, ZM, NM>
where
    T: RealField + Copy,
    K: AsRef<[Node<T>]>,
    V: AsRef<[T]>,
{
    fn state(&self, z: &SVector<T, Z>, u: &SVector<T, M>) -> SVector<T, N> {
        self.state(z, u)
    }

    fn target(&self, x: &SVector<T, N>, u: &SVector<T, M>) -> SVector<T, Z> {
        self.target(x, u)
    }
}

/// The sampled numerical KKL observer for held inputs of a plant `S` with the left inverse `I`; see the
/// [module](self). Its state is (z, xhat), `ZN = Z + N`.
///
/// Fields are read through methods, because the constructor has checked them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledHeldKkl<S, T, I, const N: usize, const M: usize, const P: usize, const Z: usize, const ZN: usize> {
    plant: S,
    filter: SampledFilter<T, P, Z>,
    inverse: I,
}

impl<S, T, I, const N: usize, const M: usize, const P: usize, const Z: usize, const ZN: usize>
    SampledHeldKkl<S, T, I, N, M, P, Z, ZN>
where
    S: Plant<T, State = SVector<T, N>, Input = SVector<T, M>, Output = SVector<T, P>>,
    T: RealField + Copy,
    I: HeldStateInverse<T, N, M, Z>,
{
    /// The observer with this filter and this left inverse.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for entries that are not finite, [`ObserverError::Period`],
    /// [`ObserverError::Substeps`]; [`ObserverError::Table`] unless `ZN = Z + N`.
    pub fn new(plant: S, filter: SampledFilter<T, P, Z>, inverse: I) -> Result<Self, ObserverError> {
        filter.check()?;
        if ZN != Z + N {
            let what = "the state of the observer, target states and estimate";
            return Err(ObserverError::Table { what, expected: Z + N, found: ZN });
        }
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

    /// (z, xhat) with the estimate for z at u.
    fn joined(&self, z: &SVector<T, Z>, u: &SVector<T, M>) -> SVector<T, ZN> {
        let xhat = self.inverse.state(z, u);
        SVector::from_fn(|i, _| if i < Z { z[i] } else { xhat[i - Z] })
    }
}

impl<S, T, I, const N: usize, const M: usize, const P: usize, const Z: usize, const ZN: usize> SampledObserver<T>
    for SampledHeldKkl<S, T, I, N, M, P, Z, ZN>
where
    S: Plant<T, State = SVector<T, N>, Input = SVector<T, M>, Output = SVector<T, P>>,
    T: RealField + Copy,
    I: HeldStateInverse<T, N, M, Z>,
{
    type State = SVector<T, ZN>;
    type Input = SVector<T, M>;
    type Output = SVector<T, P>;
    type Estimate = SVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: ZN, inputs: M, outputs: P, estimate: N }
    }

    fn period(&self) -> T {
        self.filter.period
    }

    fn step(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        let mut z = SVector::from_fn(|i, _| state[i]);
        self.filter.advance(&self.plant, t, (&mut z, self.estimate(state)), (u, y));
        *state = self.joined(&z, u);
    }

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        SVector::from_fn(|i, _| state[Z + i])
    }

    /// At the input `u`.
    fn initial(&self, _t: T, estimate: &Self::Estimate, u: &Self::Input, _y: &Self::Output) -> Self::State {
        self.joined(&self.inverse.target(estimate, u), u)
    }
}
