//! Observers of a plant of the user's: the copies with a constant gain, and the filters.

#[cfg(feature = "serde")]
use luenberger_plants::serialization::{Rows, rows};
use luenberger_plants::{Differentiable, Plant, Size};
use nalgebra::{Const, DMatrix, DefaultAllocator, Dim, OVector, RealField, U1};
#[cfg(feature = "serde")]
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _, ser::SerializeStruct as _};

use crate::error::ObserverError;
use crate::observer::SampledObserver as _;
#[cfg(feature = "serde")]
use crate::serialization::matrix;
use crate::static_size::{dynamic, rounded, same_sizes, sized};
use crate::transition::Prediction;
use crate::{
    DiscreteNonlinearObserver, ExtendedKalmanFilter, NoiseModel, NonlinearLuenbergerObserver, SampledNonlinearObserver,
    SigmaPoints, UnscentedKalmanFilter,
};

/// A plant whose columns have N states, M inputs and P outputs.
pub trait SizedPlant<T: RealField + Copy, N: Dim, M: Dim, P: Dim>:
    Plant<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>>
where
    DefaultAllocator: Size<N, M, P>,
{
}

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> SizedPlant<T, N, M, P> for S
where
    S: Plant<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>>,
    DefaultAllocator: Size<N, M, P>,
{
}

/// The prediction of a filter with so many Runge-Kutta steps between two samples; without them that of a plant in
/// discrete time, or one that controls its error.
fn prediction(substeps: Option<usize>, error_controlled: Option<bool>) -> Prediction {
    match substeps {
        Some(substeps) => Prediction::RungeKutta(substeps),
        None if error_controlled == Some(true) => Prediction::ErrorControlled,
        None => Prediction::Discrete,
    }
}

numbers_of_plant! {
    NonlinearLuenbergerObserver as Constant where S: SizedPlant;
    |o, plant| { l: matrix(L) = o.l() }
    designed o.l().shape();
    NonlinearLuenbergerObserver::new(plant, l);

    DiscreteNonlinearObserver as Discrete where S: SizedPlant;
    |o, plant| { l: matrix(L) = o.l(), period: number = o.period() }
    designed o.l().shape();
    DiscreteNonlinearObserver::new(plant, l, period);

    SampledNonlinearObserver as Sampled where S: Differentiable;
    |o, plant| { l: matrix(L) = o.l(), period: number = o.period(), substeps: plain(usize) = o.substeps() }
    designed o.l().shape();
    SampledNonlinearObserver::new(plant, l, period, substeps);

    ExtendedKalmanFilter as Extended where S: Differentiable;
    |o, plant| {
        w: matrix(W) = &o.noise_model().w,
        v: matrix(V) = &o.noise_model().v,
        p0: matrix(P0) = &o.noise_model().p0,
        period: number = o.h(),
        substeps: option(usize) = o.prediction().substeps(),
        error_controlled: option(bool) = (o.prediction() == Prediction::ErrorControlled).then_some(true),
        gate: maybe_number = o.gate(),
        iterations: option(usize) = Some(o.iterations()).filter(|iterations| *iterations > 1),
        turns: maybe(Turns) = o.turns(),
        unit_vectors: maybe(UnitVectors) = o.unit_vectors(),
    }
    designed (o.noise_model().w.nrows(), o.noise_model().v.nrows());
    {
        let filter = ExtendedKalmanFilter::<_, T, N, M, P>::discrete(plant, NoiseModel { w, v, p0 }, period)?;
        let filter = filter.with_prediction(prediction(substeps, error_controlled))?;
        let filter = filter.with_iterations(iterations.unwrap_or(1))?;
        let filter = match turns {
            Some(turns) => filter.with_angles(turns)?,
            None => filter,
        };
        let filter = match unit_vectors {
            Some(vectors) => filter.with_unit_vectors(vectors)?,
            None => filter,
        };
        match gate {
            Some(gate) => filter.with_gate(gate),
            None => Ok(filter),
        }
    };

    /// The factors of the covariances are rounded, not the covariances; files have the factors too, so that no bit is
    /// lost.
    UnscentedKalmanFilter as Unscented where S: Differentiable;
    |o, plant| {
        root_w: matrix(RootW) = &o.factors().w,
        root_v: matrix(RootV) = &o.factors().v,
        root_p0: matrix(RootP0) = &o.factors().p0,
        alpha: plain(f64) = o.sigma_points().alpha,
        beta: plain(f64) = o.sigma_points().beta,
        kappa: plain(f64) = o.sigma_points().kappa,
        period: number = o.h(),
        substeps: option(usize) = o.prediction().substeps(),
        error_controlled: option(bool) = (o.prediction() == Prediction::ErrorControlled).then_some(true),
        gate: maybe_number = o.gate(),
        turns: maybe(Turns) = o.turns(),
        state_turns: maybe(StateTurns) = o.state_turns(),
    }
    designed (o.factors().w.nrows(), o.factors().v.nrows());
    {
        let factors = NoiseModel { w: root_w, v: root_v, p0: root_p0 };
        let (sigma, prediction) = (SigmaPoints { alpha, beta, kappa }, prediction(substeps, error_controlled));
        let filter = UnscentedKalmanFilter::<_, T, N, M, P>::from_factors(plant, factors, sigma, period, prediction)?;
        let filter = if turns.is_some() || state_turns.is_some() {
            let (rows, columns) = (filter.factors().v.shape_generic().0, filter.factors().w.shape_generic().0);
            let outputs = turns.unwrap_or_else(|| OVector::zeros_generic(rows, U1));
            filter.with_angles(outputs, state_turns.unwrap_or_else(|| OVector::zeros_generic(columns, U1)))?
        } else {
            filter
        };
        match gate {
            Some(gate) => filter.with_gate(gate),
            None => Ok(filter),
        }
    };
}
