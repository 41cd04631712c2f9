//! An observer as the sliders have it, added to a scenario.

use luenberger_observers::sliding_mode::Discretisation;
use luenberger_observers::{
    ComparisonSystem, CubicObserver, DeviationObserver, DiscreteLinearObserver, DiscreteNonlinearObserver,
    ExtendedKalmanFilter, IntervalObserver, LinearObserver, NoiseModel, NonlinearLuenbergerObserver,
    ProportionalIntegralObserver, SampledCubicGains, SampledCubicObserver, SampledObserver, SlidingModeObserver,
    StationaryKalmanFilter, UnknownInputObserver,
};
use luenberger_sim::Scenario;
use nalgebra::{DMatrix, DVector, Dyn};

use crate::any_plant::AnyPlant;
use crate::experiment::{Experiment, ObserverKind, OperatingPoint, Sliders, StoredObserver};
use crate::plants::{Result, text};
use crate::rows::{Rows, matrix};

type Linear = LinearObserver<f64, Dyn, Dyn, Dyn>;
type Cubic = CubicObserver<f64, Dyn, Dyn, Dyn>;
type Interval = IntervalObserver<Linear, f64, Dyn, Dyn, Dyn>;
type SlidingMode<'a> = SlidingModeObserver<AnyPlant<'a>, f64, Dyn, Dyn, Dyn>;

/// The scenario with one more observer.
pub(crate) fn join<'a>(
    scenario: Scenario<'a>,
    experiment: &Experiment,
    observer: &StoredObserver,
    sliders: &Sliders,
    plant: AnyPlant<'a>,
) -> Result<Scenario<'a>> {
    let (name, start) = (observer.name.as_str(), start(experiment, observer, sliders));
    let (states, gain) = (Dyn(experiment.x0.len()), sliders.gain);
    let vector = |entries: &[f64]| DVector::from_column_slice(entries);
    Ok(match &observer.kind {
        ObserverKind::Linear(inner) => match (linear(inner, sliders)?, &observer.point) {
            (linear, None) => scenario.observer(name, linear, &start),
            (linear, Some(point)) => scenario.observer(name, deviation(linear, point)?, &start),
        },
        ObserverKind::Cubic(inner) => match (cubic(inner, sliders)?, &observer.point) {
            (cubic, None) => scenario.observer(name, cubic, &start),
            (cubic, Some(point)) => scenario.observer(name, deviation(cubic, point)?, &start),
        },
        ObserverKind::SampledCubic { observer: sampled, a, b } => {
            match (sampled_cubic(sampled, (a, b), sliders)?, &observer.point) {
                (sampled, None) => scenario.sampled_observer(name, sampled, &start),
                (sampled, Some(point)) => scenario.sampled_observer(name, deviation(sampled, point)?, &start),
            }
        }
        ObserverKind::ProportionalIntegral { observer: inner } => {
            let with = ProportionalIntegralObserver::new(linear(inner, sliders)?, states).map_err(text)?;
            scenario.observer(name, with, &start)
        }
        ObserverKind::ProportionalIntegralCubic { observer: inner } => {
            let with = ProportionalIntegralObserver::new(cubic(inner, sliders)?, states).map_err(text)?;
            scenario.observer(name, with, &start)
        }
        ObserverKind::ProportionalIntegralDiscrete { observer: inner } => {
            let with = ProportionalIntegralObserver::of_samples(discrete(inner, gain)?, states).map_err(text)?;
            scenario.sampled_observer(name, with, &start)
        }
        ObserverKind::UnknownInput { observer: inner, h, d } => {
            let d = d.as_ref().map(matrix);
            let without = UnknownInputObserver::new(linear(inner, sliders)?, matrix(h), d).map_err(text)?;
            scenario.observer(name, without, &start)
        }
        ObserverKind::UnknownInputCubic { observer: inner, h, d } => {
            let d = d.as_ref().map(matrix);
            let without = UnknownInputObserver::new(cubic(inner, sliders)?, matrix(h), d).map_err(text)?;
            scenario.observer(name, without, &start)
        }
        ObserverKind::Interval { observer: inner, k, g, h, start: rho } => {
            let comparison = ComparisonSystem { k: matrix(k), g: vector(g), h: matrix(h), start: vector(rho) };
            let interval = Interval::new(linear(inner, sliders)?, comparison).map_err(text)?;
            scenario.observer(name, interval, &start)
        }
        ObserverKind::SlidingMode { gains, period, explicit } => {
            let gains = if gain == 1.0 { vector(gains) } else { vector(gains) * gain };
            let by = if *explicit { Discretisation::Explicit } else { Discretisation::Implicit };
            let sliding = SlidingMode::new(plant, gains, sliders.period * period, by).map_err(text)?;
            scenario.sampled_observer(name, sliding, &start)
        }
        ObserverKind::DiscreteLinear(inner) => scenario.sampled_observer(name, discrete(inner, gain)?, &start),
        ObserverKind::StationaryKalman(filter) => {
            let scaled = if gain == 1.0 { filter.k().clone() } else { filter.k() * gain };
            let filter = StationaryKalmanFilter::new(discrete(filter.predictor(), gain)?, scaled).map_err(text)?;
            scenario.sampled_observer(name, filter, &start)
        }
        ObserverKind::DiscreteNonlinear { l, period } => {
            let l = if gain == 1.0 { matrix(l) } else { matrix(l) * gain };
            let copy = DiscreteNonlinearObserver::new(plant, l, *period).map_err(text)?;
            scenario.sampled_observer(name, copy, &start)
        }
        ObserverKind::NonlinearLuenberger { l } => {
            let l = if gain == 1.0 { matrix(l) } else { matrix(l) * gain };
            let copy = NonlinearLuenbergerObserver::new(plant, l).map_err(text)?;
            scenario.observer(name, copy, &start)
        }
        ObserverKind::Kalman { w, v, p0, period, discrete, gate } => {
            let w = if gain == 1.0 { matrix(w) } else { matrix(w) * gain };
            let noises = NoiseModel { w, v: matrix(v), p0: matrix(p0) };
            let filter = if *discrete {
                ExtendedKalmanFilter::discrete(plant, noises, *period)
            } else {
                ExtendedKalmanFilter::error_controlled(plant, noises, sliders.period * period)
            };
            let filter = match (filter.map_err(text)?, gate) {
                (filter, Some(gate)) => filter.with_gate(*gate).map_err(text)?,
                (filter, None) => filter,
            };
            scenario.sampled_observer(name, filter, &start)
        }
    })
}

fn linear(observer: &Linear, sliders: &Sliders) -> Result<Linear> {
    if sliders.gain == 1.0 {
        return Ok(observer.clone());
    }
    LinearObserver::of(observer.plant(), observer.l() * sliders.gain).map_err(text)
}

fn cubic(observer: &Cubic, sliders: &Sliders) -> Result<Cubic> {
    if (sliders.gain, sliders.cubic) == (1.0, 1.0) {
        return Ok(observer.clone());
    }
    let (l, n) = (observer.l() * sliders.gain, &observer.n * sliders.cubic);
    CubicObserver::of(observer.plant(), l, n, observer.theta.clone()).map_err(text)
}

type Discrete = DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>;

fn discrete(observer: &Discrete, gain: f64) -> Result<Discrete> {
    if gain == 1.0 {
        return Ok(observer.clone());
    }
    let period = SampledObserver::<f64>::period(observer);
    DiscreteLinearObserver::new(observer.plant().clone(), observer.l() * gain, period).map_err(text)
}

fn deviation<O>(observer: O, point: &OperatingPoint) -> Result<DeviationObserver<O, f64, Dyn, Dyn, Dyn>> {
    let [x, u, y] = [&point.x, &point.u, &point.y].map(|entries| DVector::from_column_slice(entries));
    DeviationObserver::new(observer, x, u, y).map_err(text)
}

type SampledCubic = SampledCubicObserver<f64, Dyn, Dyn, Dyn>;

/// The sampled cubic observer with scaled gains and, at another period, with the discretisation of the plant at it.
fn sampled_cubic(observer: &SampledCubic, (a, b): (&Rows, &Rows), sliders: &Sliders) -> Result<SampledCubic> {
    if (sliders.gain, sliders.cubic, sliders.period) == (1.0, 1.0, 1.0) {
        return Ok(observer.clone());
    }
    let (mut ad, mut bd) = (observer.ad().clone(), observer.bd().clone());
    let period = SampledObserver::<f64>::period(observer) * sliders.period;
    if sliders.period != 1.0 {
        let (a, b) = (matrix(a), matrix(b));
        let (n, m) = (a.nrows(), bd.ncols());
        let mut both = DMatrix::zeros(n + m, n + m);
        both.view_mut((0, 0), (n, n)).copy_from(&(a * period));
        if m > 0 {
            both.view_mut((0, n), (n, m)).copy_from(&(b * period));
        }
        let exponential = both.exp();
        ad = exponential.view((0, 0), (n, n)).into_owned();
        bd = exponential.view((0, n), (n, m)).into_owned();
    }
    let gains = SampledCubicGains {
        ad,
        bd,
        c: observer.c().clone(),
        ld: observer.ld() * sliders.gain,
        n: observer.n() * sliders.cubic,
        theta: observer.theta().clone(),
        w: observer.w() * sliders.cubic,
        period,
    };
    let scaled = match observer.coupling() {
        None => SampledCubicObserver::new(gains),
        Some(coupling) => SampledCubicObserver::semi_implicit(gains, coupling * sliders.cubic),
    };
    let scaled = scaled.map_err(text)?;
    match observer.d() {
        None => Ok(scaled),
        Some(d) => scaled.with_feedthrough(d.clone()).map_err(text),
    }
}

/// The initial estimate.
pub(crate) fn start(experiment: &Experiment, observer: &StoredObserver, sliders: &Sliders) -> Vec<f64> {
    let moved = |(x, xhat): (&f64, &f64)| if sliders.error == 1.0 { *xhat } else { x + sliders.error * (xhat - x) };
    experiment.x0.iter().zip(&observer.initial).map(moved).collect()
}
