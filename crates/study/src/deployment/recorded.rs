//! Observers of a study as programs: each is made again over the scalar that records, with the same constructor and the
//! same numbers, and its body writes the program.

use luenberger_export::extension::RecordedObserver;
use luenberger_export::step::RecordedStep;
use luenberger_expression::{ExpressionPlant, Recorded, Recording, RecordingError, record};
use luenberger_observers::{
    Observer, ObserverDimensions, ObserverError, SampledIntervalGains, SampledIntervalObserver, SampledJumps,
    SampledObserver, SlidingModeObserver,
};
use luenberger_plants::Plant;
use nalgebra::{DMatrix, DVector, Dyn, convert};

use super::Refusal;
use crate::design::{self, Runnable};
use crate::maps::{ResetSpec, composed};
use crate::model::Model;
use crate::study::{ObserverKind, ObserverSpec, Study};

/// The observer in continuous time that has a sampled form, for samples with this period.
///
/// # Errors
/// Why it has none.
pub(super) fn observer(
    study: &Study,
    observer: &ObserverSpec,
    runnable: &Runnable,
    (plant, period): (&ExpressionPlant, f64),
) -> Result<RecordedObserver, Refusal> {
    let plain = |why: String| (why, Vec::new());
    let refused = |error: ObserverError| plain(error.to_string());
    record(Some(plant), |recording| match (&observer.kind, runnable) {
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
        _ => {
            let written = match (&observer.kind, runnable) {
                (ObserverKind::ImmersionInvariance(spec), _) => composed::immersion(&study.plant, &spec.maps),
                (ObserverKind::MeanValue { eta, internal_error, printed: Some(_), .. }, _) => {
                    composed::printed_mean_value(&study.plant, *eta, internal_error)
                }
                (_, Runnable::HighGainMaps(given)) => {
                    composed::high_gain(&study.plant, given.map(), given.gain().as_slice())
                }
                (_, Runnable::UnknownInput(decoupled)) => {
                    let inner = composed::Decoupled::Linear(decoupled.inner());
                    composed::unknown_input(&inner, decoupled.h(), decoupled.d(), study.plant.model.size())
                }
                (_, Runnable::UnknownInputCubic(decoupled)) => {
                    let inner = composed::Decoupled::Cubic(decoupled.inner());
                    composed::unknown_input(&inner, decoupled.h(), decoupled.d(), study.plant.model.size())
                }
                _ => Err("it has no given maps".to_owned()),
            };
            let written = written.map_err(|why| plain(format!("the observer has no source code: {why}")))?;
            recorded(recording, &written)
        }
    })
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
    record(Some(plant), |recording| {
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
    record(None, |recording| {
        let cast = |m: &DMatrix<f64>| m.map(convert::<f64, Recorded>);
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
