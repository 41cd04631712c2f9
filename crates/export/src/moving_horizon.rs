//! The moving-horizon estimator with its sizes erased, and its bounds as a list.

use luenberger_expression::ExpressionPlant;
use luenberger_observers::{MovingHorizonEstimator, NoiseModel, ObserverError};
use nalgebra::{DMatrix, DVector, Dyn, RealField};

/// The most samples in a window.
pub const LONGEST_WINDOW: usize = 32;

/// The estimator of a plant in expressions.
pub type MovingHorizon<T> = MovingHorizonEstimator<ExpressionPlant, T, Dyn, Dyn, Dyn, Dyn, LONGEST_WINDOW>;

/// A finite bound of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bound {
    /// The state, counted from 0.
    pub(crate) axis: usize,
    pub(crate) is_lower: bool,
    pub(crate) value: f64,
}

/// The finite bounds in the order in which the estimator applies them.
pub(crate) fn bounds(estimator: &MovingHorizon<f64>) -> Vec<Bound> {
    let Some((lower, upper)) = estimator.bounds() else { return Vec::new() };
    let sides = lower.iter().zip(upper).enumerate().flat_map(|(axis, (lower, upper))| {
        [(true, *lower), (false, *upper)].map(|(is_lower, value)| Bound { axis, is_lower, value })
    });
    sides.filter(|bound| bound.value.is_finite()).collect()
}

/// The same estimator over the scalar `T`, without bounds that are all infinite.
pub(crate) fn cast<T: RealField + Copy>(estimator: &MovingHorizon<f64>) -> Result<MovingHorizon<T>, ObserverError> {
    let cast = |m: &DMatrix<f64>| m.map(nalgebra::convert::<f64, T>);
    let (plant, NoiseModel { w, v, p0 }) = (estimator.plant().clone(), estimator.noise_model());
    let noises = NoiseModel { w: cast(w), v: cast(v), p0: cast(p0) };
    let (horizon, period) = (estimator.horizon(), nalgebra::convert(period(estimator)));
    let mut same = MovingHorizon::discrete(plant, noises, horizon, period)?.with_prediction(estimator.prediction())?;
    let column = |column: &DVector<f64>| column.map(nalgebra::convert::<f64, T>);
    if let Some((outputs, states)) = estimator.angles() {
        same = same.with_angles(column(&outputs), column(&states))?;
    }
    match estimator.bounds() {
        Some((lower, upper)) if !bounds(estimator).is_empty() => same.with_bounds(column(lower), column(upper)),
        _ => Ok(same),
    }
}

fn period(estimator: &MovingHorizon<f64>) -> f64 {
    luenberger_observers::SampledObserver::period(estimator)
}
