//! The simulation of an experiment for given positions of the sliders.

use luenberger_expression::{Expression, ExpressionPlant, Scope};
use luenberger_observers::{
    DeviationObserver, ExtendedKalmanFilter, LinearObserver, NoiseModel, NonlinearLuenbergerObserver,
    SampledCubicGains, SampledCubicObserver, SampledObserver,
};
use luenberger_plants::StateSpace;
use luenberger_sim::{Between, Errors, Noise, Samples, Scenario, ScoreGrid, Sensor, Signal, row_times};
use nalgebra::{DMatrix, DVector, Dyn};

use crate::any_plant::AnyPlant;
use crate::experiment::{
    Experiment, Feedback, FeedbackOf, Observer, ObserverKind, OperatingPoint, Plant, Rows, Sliders,
};

type Result<T> = core::result::Result<T, String>;

/// What the page draws.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Outcome {
    /// One run for each observer, in the order of the experiment.
    pub runs: Vec<Run>,
}

/// The run of one observer.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Run {
    /// The observer.
    pub name: String,
    /// Why it ended early or did not run; the rest is empty then.
    pub failure: Option<String>,
    /// The times.
    pub t: Vec<f64>,
    /// The states, one list for each.
    pub x: Rows,
    /// The estimates, one list for each.
    pub xhat: Rows,
    /// The norm of the error.
    pub norm: Vec<f64>,
    /// The scores of the norm.
    pub scores: Option<Scores>,
}

/// Scores of the norm of the error.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Scores {
    /// The root mean square.
    pub rms: f64,
    /// The largest value.
    pub peak: f64,
    /// From when on it stays within the band; none if it does not.
    pub settled: Option<f64>,
    /// The value at the end.
    pub last: f64,
}

/// The experiment with these positions of the sliders. An observer whose run fails leaves the others unchanged.
pub fn run(experiment: &Experiment, sliders: &Sliders) -> Outcome {
    let runs = experiment.observers.iter().map(|observer| {
        one(experiment, observer, sliders).unwrap_or_else(|failure| Run {
            name: observer.name.clone(),
            failure: Some(failure),
            ..Run::default()
        })
    });
    Outcome { runs: runs.collect() }
}

fn matrix(rows: &Rows) -> DMatrix<f64> {
    let columns = rows.first().map_or(0, Vec::len);
    DMatrix::from_fn(rows.len(), columns, |i, j| rows[i].get(j).copied().unwrap_or(f64::NAN))
}

fn text(error: impl core::fmt::Display) -> String {
    error.to_string()
}

impl Experiment {
    /// Whether its expressions can be read.
    ///
    /// # Errors
    /// What is wrong with the plant or the input.
    pub fn check(&self) -> Result<()> {
        if let Plant::Expressions { .. } = &self.plant {
            self.expression_plant()?;
        }
        self.inputs().map(|_| ())
    }

    fn expression_plant(&self) -> Result<ExpressionPlant> {
        match &self.plant {
            Plant::Expressions { states, inputs, f, h } => {
                ExpressionPlant::named(f, h, states, inputs, &self.parameters).map_err(text)
            }
            Plant::Linear { .. } => Err("a plant without expressions".to_owned()),
        }
    }

    fn linear_plant(a: &Rows, b: &Rows, c: &Rows, d: Option<&Rows>) -> Result<StateSpace> {
        let plant = StateSpace::new(matrix(a), matrix(b), matrix(c)).map_err(text)?;
        match d {
            Some(d) => plant.with_feedthrough(matrix(d)).map_err(text),
            None => Ok(plant),
        }
    }

    /// The inputs as a function of time.
    fn inputs(&self) -> Result<Inputs> {
        if let Some(table) = &self.table {
            let between = if table.line { Between::Line } else { Between::Hold };
            let samples = Samples::new(table.t.clone(), matrix(&table.rows), between).map_err(text)?;
            return self.as_many(samples.values().ncols()).map(|()| Inputs::Table(samples));
        }
        let scope = Scope::time().with(&self.parameters).map_err(text)?;
        let parsed = self.input.iter().map(|row| Expression::parse(row, &scope));
        let rows: Vec<Expression> = parsed.collect::<core::result::Result<_, _>>().map_err(text)?;
        if rows.is_empty() {
            return Ok(Inputs::Zero);
        }
        self.as_many(rows.len()).map(|()| Inputs::Expressions(rows))
    }

    fn as_many(&self, signals: usize) -> Result<()> {
        let inputs = self.plant.inputs();
        if signals == inputs { Ok(()) } else { Err(format!("{signals} signals for {inputs} inputs")) }
    }
}

/// The inputs as a function of time.
enum Inputs {
    Zero,
    Expressions(Vec<Expression>),
    Table(Samples),
}

impl Inputs {
    fn at(&self, t: f64, u: &mut [f64]) {
        match self {
            Self::Zero => u.fill(0.0),
            Self::Expressions(rows) => {
                for (u, row) in u.iter_mut().zip(rows) {
                    *u = row.evaluate(t, &[], &[]);
                }
            }
            Self::Table(samples) => samples.at(t, u),
        }
    }
}

/// The input of a run, with the feedback if there is one.
fn signal(experiment: &Experiment, name: &str, inputs: Inputs) -> Signal<'static> {
    let is_zero = matches!(inputs, Inputs::Zero);
    let Some(feedback) = &experiment.feedback else {
        return if is_zero { Signal::zero() } else { Signal::function(move |t, u| inputs.at(t, u)) };
    };
    let gain = matrix(&feedback.gain);
    let mut signal = match &feedback.of {
        FeedbackOf::EachEstimate => Signal::feedback(name, gain),
        FeedbackOf::Estimate(observer) => Signal::feedback(observer, gain),
        FeedbackOf::State => Signal::state_feedback(gain),
    };
    if !is_zero {
        signal = signal.plus(move |t, r| inputs.at(t, r));
    }
    if !feedback.shift.is_empty() {
        let shift = feedback.shift.clone();
        signal = signal.plus(move |_, u| u.copy_from_slice(&shift));
    }
    signal
}

fn one(experiment: &Experiment, observer: &Observer, sliders: &Sliders) -> Result<Run> {
    match &experiment.plant {
        Plant::Expressions { .. } => {
            with_plant(experiment, observer, sliders, AnyPlant(&experiment.expression_plant()?))
        }
        Plant::Linear { a, b, c, d } => {
            with_plant(experiment, observer, sliders, AnyPlant(&Experiment::linear_plant(a, b, c, d.as_ref())?))
        }
    }
}

fn with_plant(experiment: &Experiment, observer: &Observer, sliders: &Sliders, plant: AnyPlant<'_>) -> Result<Run> {
    let mut scenario = scenario(experiment, sliders, plant, &observer.name)?;
    if let Some(Feedback { of: FeedbackOf::Estimate(name), .. }) = &experiment.feedback
        && *name != observer.name
    {
        let fed = experiment.observers.iter().find(|fed| fed.name == *name);
        let fed = fed.ok_or_else(|| format!("the observer {name} in the feedback loop is not in the page"))?;
        (scenario, _) = join(scenario, experiment, fed, sliders, plant)?;
    }
    let (scenario, period) = join(scenario, experiment, observer, sliders, plant)?;
    finished(experiment, observer, sliders, scenario, period)
}

/// The scenario with one more observer, and the period of a sampled one.
fn join<'a>(
    scenario: Scenario<'a>,
    experiment: &Experiment,
    observer: &Observer,
    sliders: &Sliders,
    plant: AnyPlant<'a>,
) -> Result<(Scenario<'a>, Option<f64>)> {
    let (name, start) = (observer.name.as_str(), start(experiment, observer, sliders));
    let scaled = sliders.gain != 1.0;
    Ok(match &observer.kind {
        ObserverKind::Linear(linear) => {
            let mut linear = linear.as_ref().clone();
            if scaled {
                linear = LinearObserver::of(linear.plant(), linear.l() * sliders.gain).map_err(text)?;
            }
            let scenario = match &observer.point {
                None => scenario.observer(name, linear, &start),
                Some(point) => scenario.observer(name, deviation(linear, point)?, &start),
            };
            (scenario, None)
        }
        ObserverKind::Cubic(cubic) => {
            let mut cubic = cubic.as_ref().clone();
            if scaled || sliders.cubic != 1.0 {
                let (l, n) = (cubic.l() * sliders.gain, &cubic.n * sliders.cubic);
                cubic = luenberger_observers::CubicObserver::of(cubic.plant(), l, n, cubic.theta).map_err(text)?;
            }
            let scenario = match &observer.point {
                None => scenario.observer(name, cubic, &start),
                Some(point) => scenario.observer(name, deviation(cubic, point)?, &start),
            };
            (scenario, None)
        }
        ObserverKind::SampledCubic { observer: sampled, a, b } => {
            let sampled = sampled_cubic(sampled, (a, b), sliders)?;
            let period = SampledObserver::<f64>::period(&sampled);
            let scenario = match &observer.point {
                None => scenario.sampled_observer(name, sampled, &start),
                Some(point) => scenario.sampled_observer(name, deviation(sampled, point)?, &start),
            };
            (scenario, Some(period))
        }
        ObserverKind::Copy { l } => {
            let l = matrix(l);
            let l = if scaled { l * sliders.gain } else { l };
            let copy = NonlinearLuenbergerObserver::new(plant, l).map_err(text)?;
            (scenario.observer(name, copy, &start), None)
        }
        ObserverKind::Kalman { w, v, p0, period, substeps } => {
            let w = if scaled { matrix(w) * sliders.gain } else { matrix(w) };
            let noises = NoiseModel { w, v: matrix(v), p0: matrix(p0) };
            let period = sliders.period * period;
            let filter = ExtendedKalmanFilter::new(plant, noises, period, *substeps).map_err(text)?;
            (scenario.sampled_observer(name, filter, &start), Some(period))
        }
    })
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
fn start(experiment: &Experiment, observer: &Observer, sliders: &Sliders) -> Vec<f64> {
    let moved = |(x, xhat): (&f64, &f64)| if sliders.error == 1.0 { *xhat } else { x + sliders.error * (xhat - x) };
    experiment.x0.iter().zip(&observer.initial).map(moved).collect()
}

fn scenario<'a>(
    experiment: &Experiment,
    sliders: &Sliders,
    plant: AnyPlant<'a>,
    observer: &str,
) -> Result<Scenario<'a>> {
    let [rtol, atol] = experiment.tolerances;
    let inputs = experiment.inputs()?;
    let mut scenario = Scenario::new(plant).initial_state(&experiment.x0).tolerances(rtol, atol);
    if let Inputs::Table(samples) = &inputs {
        let within = |t: &f64| (0.0..experiment.duration).contains(t);
        let breakpoints: Vec<f64> = samples.times().iter().copied().filter(within).collect();
        scenario = scenario.breakpoints(&breakpoints);
    }
    scenario = scenario.input(signal(experiment, observer, inputs));
    if let Some(hold) = experiment.hold {
        scenario = scenario.hold_input(hold);
    }
    if let Some(noise) = experiment.noise.as_ref().filter(|_| sliders.noise > 0.0) {
        let amplitude: Vec<f64> = noise.amplitude.iter().map(|amplitude| sliders.noise * amplitude).collect();
        let with = if noise.gaussian { Noise::gaussian } else { Noise::uniform };
        scenario = scenario.noise(with(&amplitude, noise.period, noise.seed));
    }
    for of in &experiment.sensors {
        let sensor = Sensor::new(of.output, of.period).offset(of.offset);
        let amplitude = sliders.noise * of.amplitude;
        let sensor = if of.gaussian { sensor.gaussian(amplitude, of.seed) } else { sensor.uniform(amplitude, of.seed) };
        scenario = scenario.sensor(sensor);
    }
    Ok(scenario)
}

/// The instants that all observers are scored at.
fn grid(experiment: &Experiment, sliders: &Sliders) -> Result<ScoreGrid> {
    if let Some(period) = experiment.score_period {
        return Ok(ScoreGrid::Samples { period });
    }
    let period = |observer: &Observer| match &observer.kind {
        ObserverKind::SampledCubic { observer, .. } => {
            Some(SampledObserver::<f64>::period(observer.as_ref()) * sliders.period)
        }
        ObserverKind::Kalman { period, .. } => Some(period * sliders.period),
        ObserverKind::Linear(_) | ObserverKind::Cubic(_) | ObserverKind::Copy { .. } => None,
    };
    let periods: Vec<Option<f64>> = experiment.observers.iter().map(period).collect();
    ScoreGrid::common(&periods, experiment.duration).map_err(text)
}

fn finished(
    experiment: &Experiment,
    observer: &Observer,
    sliders: &Sliders,
    scenario: Scenario<'_>,
    period: Option<f64>,
) -> Result<Run> {
    let (mut times, end) = row_times(experiment.duration, experiment.samples, period);
    let shown = times.len();
    times.extend(end);
    let trajectory = scenario.times(&times).run().map_err(text)?;
    let name = observer.name.as_str();
    let columns = |m: &DMatrix<f64>| -> Rows {
        m.column_iter().map(|column| column.iter().take(shown).copied().collect()).collect()
    };
    let estimate = &trajectory.observer(name).map_err(text)?.estimate;
    let norm = |k: usize| {
        let unit = |i: usize| experiment.scale.as_ref().and_then(|scale| scale.get(i)).copied().unwrap_or(1.0);
        let share = |i: usize| (trajectory.x[(k, i)] - estimate[(k, i)]) / unit(i);
        (0..experiment.x0.len()).map(|i| share(i) * share(i)).sum::<f64>().sqrt()
    };
    let errors = Errors::of(&trajectory, name, grid(experiment, sliders)?).map_err(text)?;
    let merits = errors.norm(experiment.scale.as_deref(), experiment.band).map_err(text)?;
    let scores = Scores { rms: merits.rms, peak: merits.peak, settled: merits.settling_last, last: merits.last };
    Ok(Run {
        name: name.to_owned(),
        failure: None,
        norm: (0..shown).map(norm).collect(),
        x: columns(&trajectory.x),
        xhat: columns(estimate),
        scores: Some(scores),
        t: times.into_iter().take(shown).collect(),
    })
}
