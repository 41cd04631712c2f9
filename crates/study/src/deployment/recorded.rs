//! Observers of a study as programs: each is made again over the scalar that records, with the same constructor and the
//! same numbers, and its body writes the program.

use luenberger_export::extension::RecordedObserver;
use luenberger_export::step::RecordedStep;
use luenberger_expression::{ExpressionPlant, Recorded, Recording, RecordingError, record};
use luenberger_observers::{
    CubicObserver, ImmersionInvarianceObserver, Integral, KklObserver, LinearInverse, LinearKkl, LinearObserver,
    MeanValueObserver, Observer, ObserverDimensions, ObserverError, SampledIntervalGains, SampledIntervalObserver,
    SampledJumps, SampledObserver, SlidingModeObserver, UnknownInputObserver,
};
use luenberger_plants::Plant;
use nalgebra::{DMatrix, DVector, Dyn, convert};

use super::Refusal;
use crate::design::{self, Runnable};
use crate::maps::{ResetSpec, high_gain};
use crate::model::Model;
use crate::runnable::WithoutDisturbance;
use crate::study::{ObserverKind, ObserverSpec};

/// The observer in continuous time that has a sampled form, for samples with this period.
///
/// # Errors
/// Why it has none.
pub(super) fn observer(
    observer: &ObserverSpec,
    runnable: &Runnable,
    (plant, period): (&ExpressionPlant, f64),
) -> Result<RecordedObserver, Refusal> {
    let plain = |why: String| (why, Vec::new());
    let refused = |error: ObserverError| plain(error.to_string());
    plant.record(|recording| match (&observer.kind, runnable) {
        (_, Runnable::ReducedOrder(observer)) => {
            let (maps, inverse) = (observer.map(), observer.map().inverse());
            let inverse =
                LinearInverse::new(cast(inverse.m()), cast(inverse.n()), cast(inverse.t())).map_err(refused)?;
            let maps = LinearKkl::<Recorded, Dyn, Dyn, Dyn, Dyn, _>::new(
                cast(maps.d()),
                cast(maps.b()),
                cast(maps.e()),
                inverse,
            );
            recorded(recording, &KklObserver::new(maps.map_err(refused)?))
        }
        (_, Runnable::KklMaps(observer)) => recorded(recording, observer.as_ref()),
        (ObserverKind::Pebo(spec) | ObserverKind::KklPeb(spec), _) => {
            let observer = design::peb::observer::<Recorded>(spec).map_err(refused)?;
            match spec.reset {
                Some(ResetSpec { period: reset, .. }) => {
                    let samples = samples_between(reset, period).map_err(plain)?;
                    recorded(recording, &SampledJumps::<_, Dyn>::new(observer, samples))
                }
                None => recorded(recording, &observer),
            }
        }
        (ObserverKind::ImmersionInvariance(spec), _) => {
            recorded(recording, &ImmersionInvarianceObserver::new(plant.clone(), spec.maps.clone()))
        }
        (ObserverKind::MeanValue { eta, internal_error, printed: Some(_), .. }, _) => {
            let start = DVector::from_column_slice(internal_error).map(convert);
            let observer = MeanValueObserver::new(plant.clone(), convert(*eta), Integral, start);
            recorded(recording, &observer.map_err(refused)?)
        }
        (_, Runnable::HighGainMaps(given)) => recorded(recording, &high_gain::recorded(given).map_err(refused)?),
        (_, Runnable::UnknownInput(decoupled)) => {
            let LinearObserver { a, b, c, d, l } = decoupled.inner();
            let inner = LinearObserver { a: cast(a), b: cast(b), c: cast(c), d: d.as_ref().map(cast), l: cast(l) };
            recorded(recording, &without_disturbance(decoupled, inner).map_err(refused)?)
        }
        (_, Runnable::UnknownInputCubic(decoupled)) => {
            let CubicObserver { a, b, c, d, l, n, theta } = decoupled.inner();
            let (a, b, c, d) = (cast(a), cast(b), cast(c), d.as_ref().map(cast));
            let inner = CubicObserver { a, b, c, d, l: cast(l), n: cast(n), theta: cast(theta) };
            recorded(recording, &without_disturbance(decoupled, inner).map_err(refused)?)
        }
        _ => Err(plain("the observer has no given maps".to_owned())),
    })
}

fn cast(m: &DMatrix<f64>) -> DMatrix<Recorded> {
    m.map(convert)
}

fn without_disturbance<O, I>(
    decoupled: &WithoutDisturbance<O>,
    inner: I,
) -> Result<UnknownInputObserver<I, Recorded, Dyn, Dyn, Dyn>, ObserverError>
where
    I: Observer<Recorded>,
{
    UnknownInputObserver::new(inner, cast(decoupled.h()), decoupled.d().map(cast))
}

/// The program of an observer.
fn recorded<O>(recording: &mut Recording, observer: &O) -> Result<RecordedObserver, Refusal>
where
    O: Observer<Recorded, Input = DVector<Recorded>, Output = DVector<Recorded>, Estimate = DVector<Recorded>>,
{
    RecordedObserver::new(recording, observer).map_err(|error| no_program(&error))
}

/// The step of a sliding-mode observer.
///
/// # Errors
/// Why it has none.
pub(super) fn sliding_mode(
    observer: &SlidingModeObserver<Model, f64, Dyn, Dyn, Dyn>,
    plant: &ExpressionPlant,
) -> Result<RecordedStep<f64>, Refusal> {
    let (rule, period) = (observer.discretisation(), observer.period());
    plant.record(|recording| {
        let gains = observer.gains().map(convert);
        let same: SlidingModeObserver<Model, Recorded, Dyn, Dyn, Dyn> =
            SlidingModeObserver::new(observer.plant().clone(), gains, convert(period), rule)
                .map_err(|error| (error.to_string(), Vec::new()))?;
        let size = same.dimensions();
        let step = |t, xhat: &[Recorded], u: &[Recorded], y: &[Recorded]| {
            let mut xhat = DVector::from_column_slice(xhat);
            same.step(t, &mut xhat, &DVector::from_column_slice(u), &DVector::from_column_slice(y));
            xhat.as_slice().to_vec()
        };
        let output = |t, xhat: &[Recorded]| {
            plant.output(t, &DVector::from_column_slice(xhat), &DVector::zeros(size.inputs)).as_slice().to_vec()
        };
        RecordedStep::new(recording, size, period, step, output).map_err(|error| no_program(&error))
    })
}

/// The step of a sampled interval observer, whose state is the estimate, the half-widths of its bounds and rho.
///
/// # Errors
/// None is expected of an observer that was made.
pub(super) fn interval(
    observer: &SampledIntervalObserver<f64, Dyn, Dyn, Dyn, Dyn, Dyn>,
) -> Result<RecordedStep<f64>, String> {
    record(|recording| {
        let SampledIntervalGains { f, g, c, l, blocks, constant, of_estimate, of_input, h, outward, start, period } =
            observer.gains();
        let same = SampledIntervalObserver::<Recorded, Dyn, Dyn, Dyn, Dyn, Dyn>::new(SampledIntervalGains {
            f: cast(f),
            g: cast(g),
            c: cast(c),
            l: cast(l),
            blocks: cast(blocks),
            constant: constant.map(convert),
            of_estimate: cast(of_estimate),
            of_input: cast(of_input),
            h: cast(h),
            outward: convert(*outward),
            start: start.map(convert),
            period: convert(*period),
        })
        .map_err(|error| error.to_string())?;
        let n = f.nrows();
        let size = same.dimensions();
        let size = ObserverDimensions { state: size.state + n, estimate: size.state + n, ..size };
        let step = |t, z: &[Recorded], u: &[Recorded], y: &[Recorded]| {
            let (xhat, rho) = (z.iter().take(n), z.iter().skip(2 * n));
            let mut state = DVector::from_vec(xhat.chain(rho).copied().collect());
            same.step(t, &mut state, &DVector::from_column_slice(u), &DVector::from_column_slice(y));
            let widths = same.half_widths(state.as_slice());
            let (xhat, rho) = (state.iter().take(n), state.iter().skip(n));
            xhat.chain(widths.iter()).chain(rho).copied().collect()
        };
        let output =
            |_, z: &[Recorded]| (cast(c) * DVector::from_iterator(n, z.iter().take(n).copied())).as_slice().to_vec();
        RecordedStep::new(recording, size, *period, step, output).map_err(|error| error.to_string())
    })
}

fn no_program(error: &RecordingError) -> Refusal {
    (format!("the observer has no program: {error}"), Vec::new())
}

/// The samples from one reset to the next.
fn samples_between(reset: f64, period: f64) -> Result<usize, String> {
    let count = (reset / period).round();
    if count >= 1.0 && (count * period - reset).abs() <= 1e-9 * reset {
        Ok(count as usize)
    } else {
        Err(format!("the period of its resets, {reset}, is not a multiple of the sampling period {period}"))
    }
}
