//! Observers of a plant of the user's, whose own numbers stand next to it: the copies with a constant gain and the
//! filters; and the observer of deviations.

use luenberger_plants::{Differentiable, Plant, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OVector, RealField};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Rows, matrix, rows};
use crate::error::ObserverError;
use crate::observer::SampledObserver;
use crate::{
    DeviationObserver, DiscreteNonlinearObserver, ExtendedKalmanFilter, NoiseModel, NonlinearLuenbergerObserver,
    Prediction, SampledNonlinearObserver, SigmaPoints, UnscentedKalmanFilter,
};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Deviation<O, T> {
    inner: O,
    x0: Rows<T>,
    u0: Rows<T>,
    y0: Rows<T>,
}

impl<O, T, N: Dim, M: Dim, P: Dim> Serialize for DeviationObserver<O, T, N, M, P>
where
    O: Serialize,
    T: RealField + Copy + Serialize,
    DefaultAllocator: Allocator<N> + Allocator<M> + Allocator<P>,
{
    fn serialize<R: Serializer>(&self, serializer: R) -> Result<R::Ok, R::Error> {
        let (x0, u0, y0) = (rows(self.x0()), rows(self.u0()), rows(self.y0()));
        Deviation { inner: self.inner(), x0, u0, y0 }.serialize(serializer)
    }
}

impl<'de, O, T, N: Dim, M: Dim, P: Dim> Deserialize<'de> for DeviationObserver<O, T, N, M, P>
where
    O: Deserialize<'de>,
    T: RealField + Copy + Deserialize<'de>,
    DefaultAllocator: Allocator<N> + Allocator<M> + Allocator<P>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Deviation { inner, x0, u0, y0 } = Deviation::<O, T>::deserialize(deserializer)?;
        let build = || Self::new(inner, matrix("x0", &x0)?, matrix("u0", &u0)?, matrix("y0", &y0)?);
        build().map_err(D::Error::custom)
    }
}

/// In continuous time; the sampled forms have a period, and the number of Runge-Kutta steps.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Constant<S, T> {
    plant: S,
    l: Rows<T>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Discrete<S, T> {
    plant: S,
    l: Rows<T>,
    period: T,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sampled<S, T> {
    plant: S,
    l: Rows<T>,
    period: T,
    substeps: usize,
}

impl<S, T, N: Dim, M: Dim, P: Dim> Serialize for NonlinearLuenbergerObserver<S, T, N, M, P>
where
    S: Serialize,
    T: RealField + Copy + Serialize,
    DefaultAllocator: Size<N, M, P>,
{
    fn serialize<R: Serializer>(&self, serializer: R) -> Result<R::Ok, R::Error> {
        Constant { plant: self.plant(), l: rows(self.l()) }.serialize(serializer)
    }
}

impl<'de, S, T, N: Dim, M: Dim, P: Dim> Deserialize<'de> for NonlinearLuenbergerObserver<S, T, N, M, P>
where
    S: Plant<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>> + Deserialize<'de>,
    T: RealField + Copy + Deserialize<'de>,
    DefaultAllocator: Size<N, M, P>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Constant { plant, l } = Constant::<S, T>::deserialize(deserializer)?;
        let build = || Self::new(plant, matrix("L", &l)?);
        build().map_err(D::Error::custom)
    }
}

impl<S, T, N: Dim, M: Dim, P: Dim> Serialize for DiscreteNonlinearObserver<S, T, N, M, P>
where
    S: Plant<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>> + Serialize,
    T: RealField + Copy + Serialize,
    DefaultAllocator: Size<N, M, P>,
{
    fn serialize<R: Serializer>(&self, serializer: R) -> Result<R::Ok, R::Error> {
        Discrete { plant: self.plant(), l: rows(self.l()), period: self.period() }.serialize(serializer)
    }
}

impl<'de, S, T, N: Dim, M: Dim, P: Dim> Deserialize<'de> for DiscreteNonlinearObserver<S, T, N, M, P>
where
    S: Plant<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>> + Deserialize<'de>,
    T: RealField + Copy + Deserialize<'de>,
    DefaultAllocator: Size<N, M, P>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Discrete { plant, l, period } = Discrete::<S, T>::deserialize(deserializer)?;
        let build = || Self::new(plant, matrix("L", &l)?, period);
        build().map_err(D::Error::custom)
    }
}

impl<S, T, N: Dim, M: Dim, P: Dim> Serialize for SampledNonlinearObserver<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P> + Serialize,
    T: RealField + Copy + Serialize,
    DefaultAllocator: Size<N, M, P>,
{
    fn serialize<R: Serializer>(&self, serializer: R) -> Result<R::Ok, R::Error> {
        let (l, period, substeps) = (rows(self.l()), self.period(), self.substeps());
        Sampled { plant: self.plant(), l, period, substeps }.serialize(serializer)
    }
}

impl<'de, S, T, N: Dim, M: Dim, P: Dim> Deserialize<'de> for SampledNonlinearObserver<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P> + Deserialize<'de>,
    T: RealField + Copy + Deserialize<'de>,
    DefaultAllocator: Size<N, M, P>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Sampled { plant, l, period, substeps } = Sampled::<S, T>::deserialize(deserializer)?;
        let build = || Self::new(plant, matrix("L", &l)?, period, substeps);
        build().map_err(D::Error::custom)
    }
}

/// A prediction as two fields: without `substeps` that of a plant in discrete time, or one that controls its error.
fn fields(prediction: Prediction) -> (Option<usize>, bool) {
    (prediction.substeps(), prediction == Prediction::ErrorControlled)
}

/// The prediction of two [`fields`].
fn prediction(substeps: Option<usize>, error_controlled: bool) -> Prediction {
    match substeps {
        Some(substeps) => Prediction::RungeKutta(substeps),
        None if error_controlled => Prediction::ErrorControlled,
        None => Prediction::Discrete,
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Extended<S, T> {
    plant: S,
    w: Rows<T>,
    v: Rows<T>,
    p0: Rows<T>,
    period: T,
    #[serde(skip_serializing_if = "Option::is_none")]
    substeps: Option<usize>,
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    error_controlled: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    gate: Option<T>,
    /// Of an iterated filter.
    #[serde(skip_serializing_if = "Option::is_none")]
    iterations: Option<usize>,
}

impl<S, T, N: Dim, M: Dim, P: Dim> Serialize for ExtendedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P> + Serialize,
    T: RealField + Copy + Serialize,
    DefaultAllocator: Size<N, M, P>,
{
    fn serialize<R: Serializer>(&self, serializer: R) -> Result<R::Ok, R::Error> {
        let NoiseModel { w, v, p0 } = self.noise_model();
        let (substeps, error_controlled) = fields(self.prediction());
        let form = Extended {
            plant: self.plant(),
            w: rows(w),
            v: rows(v),
            p0: rows(p0),
            period: self.h(),
            substeps,
            error_controlled,
            gate: self.gate(),
            iterations: Some(self.iterations()).filter(|iterations| *iterations > 1),
        };
        form.serialize(serializer)
    }
}

impl<'de, S, T, N: Dim, M: Dim, P: Dim> Deserialize<'de> for ExtendedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P> + Deserialize<'de>,
    T: RealField + Copy + Deserialize<'de>,
    DefaultAllocator: Size<N, M, P>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Extended { plant, w, v, p0, period, substeps, error_controlled, gate, iterations } =
            Extended::<S, T>::deserialize(deserializer)?;
        let build = || -> Result<Self, ObserverError> {
            let noises = NoiseModel { w: matrix("W", &w)?, v: matrix("V", &v)?, p0: matrix("P(0)", &p0)? };
            let filter = Self::discrete(plant, noises, period)?
                .with_prediction(prediction(substeps, error_controlled))?
                .with_iterations(iterations.unwrap_or(1))?;
            match gate {
                Some(gate) => filter.with_gate(gate),
                None => Ok(filter),
            }
        };
        build().map_err(D::Error::custom)
    }
}

/// The factors of the covariances, so that no bit is lost.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Unscented<S, T> {
    plant: S,
    root_w: Rows<T>,
    root_v: Rows<T>,
    root_p0: Rows<T>,
    alpha: f64,
    beta: f64,
    kappa: f64,
    period: T,
    #[serde(skip_serializing_if = "Option::is_none")]
    substeps: Option<usize>,
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    error_controlled: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    gate: Option<T>,
}

impl<S, T, N: Dim, M: Dim, P: Dim> Serialize for UnscentedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P> + Serialize,
    T: RealField + Copy + Serialize,
    DefaultAllocator: Size<N, M, P>,
{
    fn serialize<R: Serializer>(&self, serializer: R) -> Result<R::Ok, R::Error> {
        let (NoiseModel { w, v, p0 }, SigmaPoints { alpha, beta, kappa }) = (self.factors(), self.sigma_points());
        let (substeps, error_controlled) = fields(self.prediction());
        let form = Unscented {
            plant: self.plant(),
            root_w: rows(w),
            root_v: rows(v),
            root_p0: rows(p0),
            alpha,
            beta,
            kappa,
            period: self.h(),
            substeps,
            error_controlled,
            gate: self.gate(),
        };
        form.serialize(serializer)
    }
}

impl<'de, S, T, N: Dim, M: Dim, P: Dim> Deserialize<'de> for UnscentedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P> + Deserialize<'de>,
    T: RealField + Copy + Deserialize<'de>,
    DefaultAllocator: Size<N, M, P>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let form = Unscented::<S, T>::deserialize(deserializer)?;
        let build = || -> Result<Self, ObserverError> {
            let factors = NoiseModel {
                w: matrix("W^(1/2)", &form.root_w)?,
                v: matrix("V^(1/2)", &form.root_v)?,
                p0: matrix("P(0)^(1/2)", &form.root_p0)?,
            };
            let sigma = SigmaPoints { alpha: form.alpha, beta: form.beta, kappa: form.kappa };
            let filter = Self::from_factors(
                form.plant,
                factors,
                sigma,
                form.period,
                prediction(form.substeps, form.error_controlled),
            )?;
            match form.gate {
                Some(gate) => filter.with_gate(gate),
                None => Ok(filter),
            }
        };
        build().map_err(D::Error::custom)
    }
}
