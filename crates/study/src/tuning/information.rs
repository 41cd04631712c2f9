//! The prior information of every kind of observer: given in the study, or derived from it by a rule that is printed.

use luenberger_design::Region;
use luenberger_linalg::{discrete_kalman_gain, kalman_gain};
use luenberger_plants::Differentiable;
use luenberger_proof::wording::{at_least, at_most, rounded, shortest, significant};
use luenberger_sim::Trajectory;
use nalgebra::{Complex, DMatrix, DVector};
use serde::Serialize;

use crate::study::{AdviseSpec, OutputNoise, Simulation, Study};

/// One item of the information, as text.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PriorInformation {
    /// What it is.
    pub what: &'static str,
    /// Its value.
    pub value: String,
    /// Where it is from.
    pub from: String,
}

/// The parts of the information of which a tuning rule may use some. Plant, input, first estimate and sampling period
/// are known to all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum InformationKind {
    /// The settling time.
    Settling,
    /// The level of the measurement noise.
    Noise,
    /// The intensity of the process noise.
    ProcessNoise,
    /// The size of the first error.
    FirstError,
    /// The region.
    Region,
    /// E of an unknown disturbance.
    Disturbance,
    /// Bounds of a disturbance.
    Bounds,
    /// What the study says of this observer: maps, or a whole specification.
    Study,
}

impl InformationKind {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Settling => "settling time",
            Self::Noise => "noise level",
            Self::ProcessNoise => "process noise",
            Self::FirstError => "size of the first error",
            Self::Region => "region",
            Self::Disturbance => "disturbance matrix",
            Self::Bounds => "bounds of the disturbance",
            Self::Study => "its specification in the study",
        }
    }
}

/// The information in numbers.
#[derive(Debug, Clone)]
pub(crate) struct Information {
    /// Standard deviation of a sample of each output.
    pub(crate) noise: Vec<f64>,
    /// Intensity of the noise of each output: variance times hold period.
    pub(crate) intensity: Vec<f64>,
    /// Bound of a sample of each output.
    pub(crate) largest: Vec<f64>,
    /// The shortest time for which a value of the noise is held.
    pub(crate) held: f64,
    pub(crate) period: f64,
    pub(crate) settling: f64,
    pub(crate) band: f64,
    pub(crate) rate: f64,
    /// Of the kinds for linear plants: the rate, or twice that of the slowest mode of the plant if this is faster.
    pub(crate) linear_rate: f64,
    pub(crate) region: Region,
    pub(crate) initial: Vec<f64>,
    /// Standard deviations of the first error.
    pub(crate) first_error: Vec<f64>,
    /// Per unit of time, in continuous and in discrete time; none if no filter exists for it, with the reason.
    pub(crate) w: Result<DMatrix<f64>, String>,
    pub(crate) e: Option<DMatrix<f64>>,
    /// Bounds of |w|, and E of E w.
    pub(crate) acting: Option<(Vec<f64>, DMatrix<f64>)>,
    /// Units of the states in norms.
    pub(crate) scale: Vec<f64>,
    /// A and C at the first estimate.
    pub(crate) linearised: (DMatrix<f64>, DMatrix<f64>),
    /// The same in words.
    pub(crate) lines: Vec<PriorInformation>,
}

/// Half of the widths of the run that the derived region adds on each side.
const MARGIN: f64 = 0.5;

/// Standard deviations of the first error that fit into the width of the region.
const DEVIATIONS: f64 = 4.0;

/// Standard deviations of Gaussian noise that count as its bound.
const LARGEST: f64 = 4.0;

/// The range of the intensity of the process noise relative to rate times squared scale: in one time constant 1/rate
/// the process noise moves a state by a thousandth of its scale, or by all of it.
const LEAST: f64 = 1e-6;
const MOST: f64 = 1.0;

/// Where the largest intensity does not give the rate: the share of the rate that it gives.
const REACHED: f64 = 0.9;

/// The first estimate and its source.
pub(crate) fn initial(study: &Study, spec: &AdviseSpec) -> (Vec<f64>, String) {
    if let Some(initial) = &spec.initial {
        return (initial.clone(), "advise.initial".to_owned());
    }
    match (study.observers.first(), &study.operating_point) {
        (Some(first), _) => (first.initial.clone(), format!("initial of the observer {:?}", first.name)),
        (None, Some(point)) => (point.x.as_slice().to_vec(), "the operating point".to_owned()),
        (None, None) => (vec![0.0; study.plant.states.len()], "default".to_owned()),
    }
}

/// The sampling period and its source, of a simulation.
pub(crate) fn period(study: &Study, simulation: &Simulation, spec: &AdviseSpec) -> (f64, String) {
    let shortest = simulation.sensors.iter().map(|sensor| sensor.period).fold(f64::INFINITY, f64::min);
    period_or(study, spec, || match &simulation.noise {
        Some(noise) if simulation.sensors.is_empty() => (noise.period, "simulation.noise".to_owned()),
        _ => (shortest, "the fastest sensor".to_owned()),
    })
}

/// The sampling period and its source, with the one that takes the place of what the study does not say.
fn period_or(study: &Study, spec: &AdviseSpec, other: impl Fn() -> (f64, String)) -> (f64, String) {
    if let Some(dt) = study.plant.dt {
        return (dt, "plant.dt".to_owned());
    }
    if let Some(period) = spec.period {
        return (period, "advise.period".to_owned());
    }
    let sampled = study.observers.iter().find_map(|observer| Some((observer.kind.period()?, &observer.name)));
    if let Some((period, name)) = sampled {
        return (period, format!("period of the observer {name:?}"));
    }
    other()
}

/// What the information of a study is derived from.
#[derive(Debug, Clone)]
pub(crate) struct Basis {
    /// The noise of each output, and where it is from.
    pub(crate) noises: (Vec<Option<OutputNoise>>, String),
    /// The least and the largest value of each state, where they are known, and of which run.
    pub(crate) states: Option<(Vec<(f64, f64)>, String)>,
    /// Those of each input, and the input at the start.
    pub(crate) inputs: (Vec<(f64, f64)>, Vec<f64>),
    /// The sampling period and its source.
    pub(crate) period: (f64, String),
    /// Units of the states, if they are given.
    pub(crate) scale: Option<Vec<f64>>,
    pub(crate) duration: f64,
    pub(crate) band: f64,
    /// W per unit of time that is used unless [advise] gives one, and its source.
    pub(crate) w: Option<(DMatrix<f64>, String)>,
}

/// The least and the largest entry of each column.
pub(crate) fn ranges(columns: &DMatrix<f64>) -> Vec<(f64, f64)> {
    columns.column_iter().map(|column| (column.min(), column.max())).collect()
}

impl Basis {
    /// A simulation, with the run of its plant.
    pub(crate) fn of_simulation(study: &Study, simulation: &Simulation, spec: &AdviseSpec, run: &Trajectory) -> Self {
        let noises = (0..study.plant.outputs.len()).map(|output| simulation.noise_of(output)).collect();
        let mut start = vec![0.0; study.plant.inputs.len()];
        if let Some(program) = study.input.program() {
            program.at(0.0, &mut start);
        }
        let own = study.truth.as_ref().and_then(|truth| truth.disturbances.process_noise.as_ref());
        let w = own.filter(|noise| noise.variances().iter().any(|variance| *variance > 0.0)).map(|noise| {
            let each = DVector::from_vec(noise.variances()) * noise.period();
            (DMatrix::from_diagonal(&each), "truth.process_noise: variance times period".to_owned())
        });
        Self {
            noises: (noises, "simulation".to_owned()),
            states: Some((ranges(&run.x), "the run of the plant".to_owned())),
            inputs: (ranges(&run.u), start),
            period: period(study, simulation, spec),
            scale: simulation.scale.clone(),
            duration: simulation.duration,
            band: simulation.band,
            w,
        }
    }

    /// The sampling period of a log, with the one of its rows for what the study does not say.
    pub(crate) fn period_of_log(study: &Study, spec: &AdviseSpec, median: f64) -> (f64, String) {
        period_or(study, spec, || (median, "the median period of the log".to_owned()))
    }
}

impl Information {
    /// The information of a study, derived from this basis; none if nothing bounds the states.
    pub(crate) fn of(study: &Study, spec: &AdviseSpec, basis: &Basis) -> Option<Self> {
        let plant = &study.plant;
        let unit = plant.time_unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
        let (noises, noise_from) = &basis.noises;
        let noise: Vec<f64> = noises.iter().map(|noise| noise.map_or(0.0, |noise| noise.variance().sqrt())).collect();
        let intensity: Vec<f64> =
            noises.iter().map(|noise| noise.map_or(0.0, |noise| noise.variance() * noise.period)).collect();
        let bound = |noise: &OutputNoise| noise.amplitude * if noise.gaussian { LARGEST } else { 1.0 };
        let largest: Vec<f64> = noises.iter().map(|noise| noise.as_ref().map_or(0.0, bound)).collect();
        let (initial, initial_from) = initial(study, spec);
        let (period, period_from) = basis.period.clone();
        let (region, region_from) = region(study, spec, basis, &initial)?;
        let widths: Vec<f64> = region.states().iter().map(|(low, high)| high - low).collect();
        let scale = basis.scale.clone().unwrap_or_else(|| widths.clone());
        let (settling, settling_from) = match spec.settling {
            Some(settling) => (settling, "advise.settling".to_owned()),
            None => (basis.duration / 4.0, "a quarter of the duration".to_owned()),
        };
        let band = basis.band;
        let rate = -band.ln() / settling;
        let linearised = linearised(study, &initial, &basis.inputs.1);
        let linear_rate = rate.max(2.0 * slowest(&linearised.0, plant.dt).unwrap_or(0.0));
        let first_error: Vec<f64> = widths.iter().map(|width| width / DEVIATIONS).collect();
        let (w, w_from) =
            process_noise(study, (spec, basis), &linearised, (&intensity, &noise), (&scale, rate, period));
        let (e, e_from) = disturbance(study, spec);
        let acting = acting(study, spec);

        let each = |names: &[String], values: &[f64]| {
            let one = |(name, x): (&String, &f64)| format!("{name} {}", significant(*x, 4));
            names.iter().zip(values).map(one).collect::<Vec<_>>().join(", ")
        };
        let boxed = |(name, (low, high)): (&String, &(f64, f64))| {
            format!("{name} in [{}, {}]", significant(*low, 4), significant(*high, 4))
        };
        let mut bounds: Vec<String> = plant.states.iter().zip(region.states()).map(boxed).collect();
        bounds.extend(plant.inputs.iter().zip(region.input_bounds().unwrap_or_default()).map(boxed));
        let mut lines = Vec::new();
        let mut tell = |what, value: String, from: String| lines.push(PriorInformation { what, value, from });
        let held = noises.iter().flatten().map(|noise| noise.period).fold(f64::INFINITY, f64::min);
        tell(
            InformationKind::Noise.name(),
            format!("standard deviation {}, held {}{unit}", each(&plant.outputs, &noise), shortest(held)),
            noise_from.clone(),
        );
        tell("sampling period", format!("{}{unit}", shortest(period)), period_from);
        tell("first estimate", each(&plant.states, &initial), initial_from);
        tell(InformationKind::Region.name(), bounds.join(", "), region_from);
        tell(
            InformationKind::FirstError.name(),
            format!("standard deviation {}", each(&plant.states, &first_error)),
            "a quarter of the width of the region".to_owned(),
        );
        let percent = shortest(100.0 * band);
        let per = if unit.is_empty() { String::new() } else { format!(" per{unit}") };
        tell(
            InformationKind::Settling.name(),
            format!("{}{unit} to {percent} %, decay rate {}{per}", significant(settling, 4), significant(rate, 4)),
            settling_from,
        );
        let intensity_words = match &w {
            Ok(w) => format!("intensity {}", each(&plant.states, w.diagonal().as_slice())),
            Err(why) => format!("none: {why}"),
        };
        tell(InformationKind::ProcessNoise.name(), intensity_words, w_from);
        if let Some(e) = &e {
            let columns = if e.ncols() == 1 { "column" } else { "columns" };
            tell(InformationKind::Disturbance.name(), format!("E with {} {columns}", e.ncols()), e_from);
        }
        if let Some((bounds, _, from)) = &acting {
            let bounds: Vec<String> = bounds.iter().map(|bound| shortest(*bound)).collect();
            tell(InformationKind::Bounds.name(), format!("|w| <= ({})", bounds.join(", ")), from.clone());
        }
        Some(Self {
            noise,
            intensity,
            largest,
            held,
            period,
            settling,
            band,
            rate,
            linear_rate,
            region,
            initial,
            first_error,
            w,
            e,
            acting: acting.map(|(bounds, e, _)| (bounds, e)),
            scale,
            linearised,
            lines,
        })
    }
}

/// An interval with ends of few digits that contains this one.
fn outward(low: f64, high: f64) -> (f64, f64) {
    const DIGITS: usize = 3;
    (at_least(low, DIGITS).parse().unwrap_or(low), at_most(high, DIGITS).parse().unwrap_or(high))
}

/// The region, with bounds of all inputs, and its source; none if nothing bounds the states.
fn region(study: &Study, spec: &AdviseSpec, basis: &Basis, initial: &[f64]) -> Option<(Region, String)> {
    let is_bounded = |region: &Region| region.states().iter().all(|(low, high)| low.is_finite() && high.is_finite());
    let own = study.observers.iter().find_map(|observer| {
        let region = observer.kind.region().filter(is_bounded)?;
        Some((region, format!("region of the observer {:?}", observer.name)))
    });
    let (mut region, from) = match (&spec.region, own) {
        (Some(region), _) => (region.clone(), "advise.region".to_owned()),
        (None, Some(own)) => own,
        (None, None) => {
            let (ranges, of) = basis.states.as_ref()?;
            let bound = |i: usize| {
                let (low, high) = (ranges[i].0.min(initial[i]), ranges[i].1.max(initial[i]));
                // A state at rest has a region of the size of its value.
                let width = if high > low { high - low } else { high.abs().max(1.0) };
                outward(low - MARGIN * width, high + MARGIN * width)
            };
            let states: Vec<(f64, f64)> = (0..study.plant.states.len()).map(bound).collect();
            (Region::new(&states), format!("{of} and the first estimate, widened by half on each side"))
        }
    };
    let is_finite = |bounds: &[(f64, f64)]| bounds.iter().all(|(low, high)| low.is_finite() && high.is_finite());
    if !study.plant.inputs.is_empty() && !region.input_bounds().is_some_and(is_finite) {
        let bound = |j: usize| {
            let (low, high) = basis.inputs.0[j];
            let margin = 0.05 * if high > low { high - low } else { high.abs().max(1.0) };
            outward(low - margin, high + margin)
        };
        region = region.inputs(&(0..study.plant.inputs.len()).map(bound).collect::<Vec<_>>());
    }
    Some((region, from))
}

/// A and C at the first estimate, under the input at the start.
fn linearised(study: &Study, initial: &[f64], input: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
    let model = &study.plant.model;
    if let Some(linear) = model.linear() {
        return (linear.a.clone(), linear.c.clone());
    }
    if let Some(point) = &study.operating_point {
        return (point.linear.a.clone(), point.linear.c.clone());
    }
    let (x, u) = (DVector::from_column_slice(initial), DVector::from_column_slice(input));
    (model.state_jacobian(0.0, &x, &u), model.output_jacobian(0.0, &x, &u))
}

/// How fast a mode decays, in continuous time or with this sampling period.
pub(crate) fn speed(eigenvalue: Complex<f64>, dt: Option<f64>) -> f64 {
    dt.map_or(-eigenvalue.re, |dt| -eigenvalue.norm().ln() / dt)
}

/// The decay rate of the slowest mode; none if the eigenvalues do not exist.
fn slowest(a: &DMatrix<f64>, dt: Option<f64>) -> Option<f64> {
    let all = luenberger_linalg::eigenvalues(a).ok()?;
    Some(all.iter().map(|eigenvalue| speed(*eigenvalue, dt)).fold(f64::INFINITY, f64::min))
        .filter(|rate| rate.is_finite())
}

/// E and its source.
fn disturbance(study: &Study, spec: &AdviseSpec) -> (Option<DMatrix<f64>>, String) {
    if let Some(e) = &spec.e {
        return (Some(e.clone()), "advise.e".to_owned());
    }
    let own = study.observers.iter().find_map(|observer| {
        let e = observer.kind.unknown_disturbance()?;
        Some((Some(e.clone()), format!("e of the observer {:?}", observer.name)))
    });
    own.unwrap_or((None, String::new()))
}

/// Bounds of a disturbance, its E, and their source.
fn acting(study: &Study, spec: &AdviseSpec) -> Option<(Vec<f64>, DMatrix<f64>, String)> {
    if let (Some(bounds), Some(e)) = (&spec.disturbance, &spec.e) {
        return Some((bounds.clone(), e.clone(), "advise.disturbance".to_owned()));
    }
    study.observers.iter().find_map(|observer| {
        let bounds = observer.bounds.as_ref().filter(|bounds| !bounds.disturbance.is_empty())?;
        let from = format!("bounds of the observer {:?}", observer.name);
        Some((bounds.disturbance.clone(), bounds.e.clone(), from))
    })
}

/// The intensity of the process noise and its source.
fn process_noise(
    study: &Study,
    (spec, basis): (&AdviseSpec, &Basis),
    (a, c): &(DMatrix<f64>, DMatrix<f64>),
    (intensity, noise): (&[f64], &[f64]),
    (scale, rate, period): (&[f64], f64, f64),
) -> (Result<DMatrix<f64>, String>, String) {
    if let Some(w) = &spec.w {
        return (Ok(w.clone()), "advise.w".to_owned());
    }
    if let Some((w, from)) = &basis.w {
        return (Ok(w.clone()), from.clone());
    }
    let from = "the least multiple of the squared scales of the states with which the stationary Kalman filter settles in time";
    let unit = DMatrix::from_diagonal(&DVector::from_iterator(scale.len(), scale.iter().map(|s| s * s)));
    // The decay rate of the stationary filter with W = q unit.
    let decay = |q: f64| {
        let (w, diagonal) = (&unit * q, |v: &[f64]| DMatrix::from_diagonal(&DVector::from_column_slice(v)));
        if study.plant.dt.is_some() {
            let found =
                discrete_kalman_gain(a, c, &(w * period), &diagonal(&noise.iter().map(|s| s * s).collect::<Vec<_>>()))?;
            let slowest = found.poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
            return Ok(-slowest.ln() / period);
        }
        let found = kalman_gain(a, c, &w, &diagonal(intensity))?;
        Ok::<f64, luenberger_linalg::LinalgError>(
            -found.poles.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max),
        )
    };
    let (mut low, mut high) = ((LEAST * rate).log10(), (MOST * rate).log10());
    let ends = (decay(10f64.powf(low)), decay(10f64.powf(high)));
    let (slow, fast) = match ends {
        (Err(error), _) | (_, Err(error)) => {
            return (Err(study.plant.names().with(|| error.to_string())), from.to_owned());
        }
        (Ok(slow), Ok(fast)) => (slow, fast),
    };
    let (target, from) = if fast < rate {
        let target = REACHED * fast;
        (target, format!("{from}; the rate is {}, nine tenths of what it can reach", significant(target, 3)))
    } else {
        (rate, from.to_owned())
    };
    if slow >= target {
        high = low;
    }
    while high - low > 1e-6 {
        let middle = f64::midpoint(low, high);
        if decay(10f64.powf(middle)).is_ok_and(|found| found >= target) { high = middle } else { low = middle }
    }
    let q = 10f64.powf(high);
    // Three digits, so that the study that is written has the number that was used.
    (Ok(unit * rounded(q, 3)), from)
}
