//! Frequency responses of the linear observers of a study, and of the loop with its feedback: margins, tables, figures.
//!
//! Frequencies are in radians per unit of time; a plant in discrete time has `z = e^{jw dt}`.

use luenberger_design::recovery::realization;
use luenberger_design::{DesignError, loop_transfer_recovery, recovery_obstacle};
use luenberger_figures::{Dash, Figure, Hue, Mark, Panel, Series, Table};
use luenberger_linalg::{
    FrequencyAxis, HInfinityNorm, LinalgError, LoopMargins, LoopTransfer, ObserverTransfer, Realization,
    StabilityMargins, unwrapped_phase,
};
use luenberger_proof::wording::significant;
use nalgebra::{Complex, DMatrix};
use std::fmt::Write as _;

use super::pictures::{figure, place};
use crate::kinds::LinearForm;
use crate::read::file_name;
use crate::results::{
    ChannelMargins, Crossing, FrequencyReport, LoopReport, ObserverFrequencies, OpenedLoop, Peak, RecoveryReport,
};
use crate::signal::Input;
use crate::study::{FrequencySpec, GainSpec, Study};
use crate::trajectory::Member;

/// With at most so many pairs of a state and an output, each has its magnitude and its phase.
const BODE_PAIRS: usize = 4;

/// With at most so many, each has its magnitude.
const PAIRS: usize = 12;

/// What was computed.
pub(super) struct Responses {
    pub(super) report: FrequencyReport,
    /// Files by their names.
    pub(super) tables: Vec<(String, Table)>,
    pub(super) figures: Vec<(String, Figure)>,
    pub(super) warnings: Vec<String>,
}

/// A margin of a loop; an infinite frequency is none.
fn crossing(frequency: f64, margin: f64) -> Crossing {
    Crossing { frequency: Some(frequency).filter(|w| w.is_finite()), margin }
}

fn peak(found: HInfinityNorm) -> Peak {
    Peak { norm: found.norm, frequency: Some(found.frequency).filter(|w| w.is_finite()) }
}

/// A linear observer of the study.
struct Linear<'a> {
    member: &'a Member<'a>,
    plant: Realization,
    form: LinearForm,
    transfer: ObserverTransfer,
}

/// The responses of the linear observers among these.
pub(super) fn responses(study: &Study, spec: &FrequencySpec, members: &[Member<'_>]) -> Responses {
    let frequencies = FrequencyAxis::new(study.plant.dt);
    let mut warnings = Vec::new();
    let mut failed =
        |name: &str, error: &dyn std::fmt::Display| warnings.push(format!("{name}: no frequency response: {error}"));
    let mut linear: Vec<Linear<'_>> = Vec::new();
    for member in members {
        let Some(form) = member.designed.runnable.linear() else { continue };
        let plant = realization(&form.plant);
        let transfer = match &form.update {
            None => ObserverTransfer::new(&plant, &form.l),
            Some(update) => ObserverTransfer::with_update(&plant, &form.l, update),
        };
        match transfer {
            Ok(transfer) => linear.push(Linear { member, plant, form, transfer }),
            Err(error) => failed(&member.requested.name, &error),
        }
    }
    let fed = match &study.input {
        Input::Feedback { observer, gain, .. } => {
            linear.iter().find(|one| one.member.requested.name == *observer).map(|one| (one, gain))
        }
        _ => None,
    };
    let opened = fed.filter(|(one, _)| one.form.update.is_none()).and_then(|(one, gain)| {
        let found = LoopTransfer::new(&one.plant, &one.form.l, gain);
        found.map_err(|error| failed(&one.member.requested.name, &error)).ok().map(|transfer| (one, gain, transfer))
    });
    let mut features: Vec<Complex<f64>> = Vec::new();
    for one in &linear {
        features.extend(poles(&one.plant.a).iter().chain(&poles(&one.transfer.estimate.a)));
    }
    if let Some((_, _, transfer)) = &opened {
        features.extend(poles(&transfer.compensator.a));
    }
    let grid = frequencies.grid(&features, [spec.from, spec.to], spec.points);
    let mut found = Responses {
        report: FrequencyReport {
            range: [grid.first(), grid.last()].map(|w| w.copied().unwrap_or_default()),
            observers: Vec::new(),
            feedback: None,
        },
        tables: Vec::new(),
        figures: Vec::new(),
        warnings: Vec::new(),
    };
    let mut drawn = Vec::new();
    for one in &linear {
        let name = &one.member.requested.name;
        match observer(study, frequencies, one, &grid) {
            Ok((report, table, columns)) => {
                found.report.observers.push(report);
                found.tables.push((format!("frequency/{}", file_name(name)), table));
                drawn.push((name.as_str(), columns));
            }
            Err(error) => failed(name, &error),
        }
    }
    found.figures.extend(of_observers(study, &grid, &drawn));
    if let Some((one, gain, transfer)) = opened {
        let name = &one.member.requested.name;
        match feedback(study, frequencies, spec, (one, gain, &transfer), &grid) {
            Ok((report, tables, figures)) => {
                found.report.feedback = Some(report);
                found.tables.extend(tables);
                found.figures.extend(figures);
            }
            Err(error) => failed(name, &error),
        }
    } else if let Some((one, _)) = fed.filter(|(one, _)| one.form.update.is_some()) {
        warnings.push(format!(
            "{}: no frequency response of the loop: it is computed for the estimate before the measurement of its sample, form = \"predictor\"",
            one.member.requested.name
        ));
    }
    found.warnings = warnings;
    found
}

/// The eigenvalues, if they can be computed: they choose what is drawn.
fn poles(a: &DMatrix<f64>) -> Vec<Complex<f64>> {
    luenberger_linalg::eigenvalues(a).unwrap_or_default()
}

/// A magnitude and a phase in degrees, at each frequency.
struct Bode {
    magnitude: Vec<f64>,
    phase: Vec<f64>,
}

impl Bode {
    fn of(values: impl Iterator<Item = Complex<f64>> + Clone) -> Self {
        let phase = unwrapped_phase(values.clone()).into_iter().map(f64::to_degrees).collect();
        Self { magnitude: values.map(Complex::norm).collect(), phase }
    }

    fn decibels(&self) -> Vec<f64> {
        self.magnitude.iter().map(|x| 20.0 * x.log10()).collect()
    }
}

/// The responses of an observer from each output to each estimate, by states and in them by outputs.
type Pairs = Vec<Bode>;

fn observer(
    study: &Study,
    frequencies: FrequencyAxis,
    one: &Linear<'_>,
    grid: &[f64],
) -> Result<(ObserverFrequencies, Table, Pairs), LinalgError> {
    let response = frequencies.response(&one.transfer.estimate)?;
    let at: Vec<DMatrix<Complex<f64>>> = grid.iter().map(|w| response.at(frequencies.angle(*w))).collect();
    let (states, outputs, inputs) = (&study.plant.states, &study.plant.outputs, &study.plant.inputs);
    let p = one.form.l.ncols();
    let mut table = Table::new().column("w", grid);
    let mut pairs = Vec::new();
    for (i, state) in states.iter().enumerate() {
        for (j, from) in outputs.iter().chain(inputs).enumerate() {
            let bode = Bode::of(at.iter().map(|m| m[(i, j)]));
            table = column(table, format!("magnitude_{state}_{from}"), &bode.magnitude);
            table = column(table, format!("phase_{state}_{from}"), &bode.phase);
            if j < p {
                pairs.push(bode);
            }
        }
    }
    let whole = &one.transfer.noise_to_error;
    let row = |i: usize| {
        let (c, d) = (whole.c.rows(i, 1).into_owned(), whole.d.rows(i, 1).into_owned());
        Ok(peak(frequencies.h_infinity_norm(&Realization { c, d, ..whole.clone() })?))
    };
    let noise_peaks = (0..states.len()).map(row).collect::<Result<Vec<Peak>, LinalgError>>()?;
    let observer = one.member.requested.name.clone();
    Ok((ObserverFrequencies { observer, noise_peaks }, table, pairs))
}

/// With one more column; at a pole on the axis there is no value.
fn column(table: Table, name: String, values: &[f64]) -> Table {
    table.column_with_missing(name, values.iter().map(|x| Some(*x).filter(|x| x.is_finite())))
}

/// The label of the axis of frequencies.
fn axis(study: &Study) -> String {
    match &study.plant.time_unit {
        Some(unit) => format!("frequency w (rad/{unit})"),
        None => "frequency w (rad per unit of time)".to_owned(),
    }
}

/// A curve of the values that are finite.
fn curve(name: &str, grid: &[f64], values: &[f64]) -> Option<Series> {
    let finite = grid.iter().zip(values).filter(|(_, y)| y.is_finite());
    let (x, y): (Vec<f64>, Vec<f64>) = finite.map(|(x, y)| (*x, *y)).unzip();
    (x.len() > 1).then(|| Series::line(name, &x, &y))
}

/// From the outputs to the estimates, every observer in one figure.
fn of_observers(study: &Study, grid: &[f64], drawn: &[(&str, Pairs)]) -> Option<(String, Figure)> {
    let (states, outputs) = (&study.plant.states, &study.plant.outputs);
    let count = states.len() * outputs.len();
    let panel = |pair: usize, label: String, of: &dyn Fn(&Bode) -> Vec<f64>| {
        let curves = drawn
            .iter()
            .filter_map(|(name, pairs)| Some(curve(name, grid, &of(pairs.get(pair)?))?.numbered(place(study, name))));
        curves.fold(Panel::new(axis(study), label).log_x(), Panel::series)
    };
    let mut panels = Vec::new();
    for pair in (0..count).take(PAIRS) {
        let name = format!("{} to {}", outputs[pair % outputs.len()], states[pair / outputs.len()]);
        panels.push(panel(pair, format!("{name} (dB)"), &Bode::decibels));
        if count <= BODE_PAIRS {
            panels.push(panel(pair, format!("{name}, phase (degrees)"), &|bode| bode.phase.clone()));
        }
    }
    let mut caption = "Frequency responses of the observers from the measured outputs to the estimates; with the other sign they are those from measurement noise to the errors.".to_owned();
    if count > PAIRS {
        _ = write!(caption, " The first {PAIRS} of {count} pairs; the tables in `frequency/` have all.");
    }
    figure("frequency-observers", "Frequency responses of the observers", &caption, panels)
}

/// Report, tables and figures of the loop.
type Loop = (LoopReport, Vec<(String, Table)>, Vec<(String, Figure)>);

fn feedback(
    study: &Study,
    frequencies: FrequencyAxis,
    spec: &FrequencySpec,
    (one, gain, transfer): (&Linear<'_>, &DMatrix<f64>, &LoopTransfer),
    grid: &[f64],
) -> Result<Loop, DesignError> {
    let mut opened = Vec::new();
    let (mut tables, mut figures) = (Vec::new(), Vec::new());
    for (at, open, names) in
        [("inputs", &transfer.at_inputs, &study.plant.inputs), ("outputs", &transfer.at_outputs, &study.plant.outputs)]
    {
        opened.push(margins(at, &frequencies.margins(open)?, names));
        let curves = Curves::of(frequencies, open, grid)?;
        tables.push((format!("frequency/loop-{at}"), curves.table(grid)));
        let target = if at == "inputs" { Some(Curves::of(frequencies, &transfer.state_feedback, grid)?) } else { None };
        figures.extend(of_loop(study, grid, at, &curves, target.as_ref()));
    }
    let (recovery, obstacle, figure) = recovered(study, frequencies, spec, (one, gain, transfer), grid)?;
    figures.extend(figure);
    let observer = one.member.requested.name.clone();
    Ok((LoopReport { observer, opened, recovery, obstacle }, tables, figures))
}

fn margins(at: &'static str, found: &LoopMargins, names: &[String]) -> OpenedLoop {
    let channel = |(name, found): (&String, &StabilityMargins)| {
        let gain = |one: luenberger_linalg::GainMargin| crossing(one.frequency, one.factor);
        let phase = |one: luenberger_linalg::PhaseMargin| crossing(one.frequency, one.angle.to_degrees());
        ChannelMargins {
            channel: name.clone(),
            gain_margin: found.gain_margin().map(gain),
            gain_reduction: found.gain_reduction().map(gain),
            phase_margin: found.phase_margin().map(phase),
            delay_margin: found.delay_margin().map(|one| crossing(one.frequency, one.delay)),
            gain: found.gain.iter().copied().map(gain).collect(),
            phase: found.phase.iter().copied().map(phase).collect(),
        }
    };
    let all_gains = found.guaranteed_gain().map(|(low, high)| [low, high]).into_iter().flatten();
    OpenedLoop {
        at,
        stable: found.sensitivity.is_some(),
        channels: names.iter().zip(&found.channels).map(channel).collect(),
        all_gains: all_gains.filter(|factor| factor.is_finite()).collect(),
        all_phases: found.guaranteed_phase().map(f64::to_degrees),
        sensitivity: found.sensitivity.map(peak),
        complementary_sensitivity: found.complementary.map(peak),
    }
}

/// Largest and smallest singular values over the frequencies.
#[derive(Default)]
struct Sigma {
    largest: Vec<f64>,
    smallest: Vec<f64>,
}

impl Sigma {
    fn push(&mut self, m: &DMatrix<Complex<f64>>) {
        let finite = m.iter().all(|z| z.re.is_finite() && z.im.is_finite());
        let values = if finite { Some(m.singular_values()) } else { None };
        self.largest.push(values.as_ref().map_or(f64::NAN, nalgebra::Matrix::max));
        self.smallest.push(values.as_ref().map_or(f64::NAN, nalgebra::Matrix::min));
    }
}

fn decibels(values: &[f64]) -> Vec<f64> {
    values.iter().map(|x| 20.0 * x.log10()).collect()
}

/// The singular values of L, S and T, and the phase of a loop of one channel.
struct Curves {
    open: Sigma,
    sensitivity: Sigma,
    complementary: Sigma,
    phase: Option<Vec<f64>>,
}

impl Curves {
    fn of(frequencies: FrequencyAxis, open: &Realization, grid: &[f64]) -> Result<Self, LinalgError> {
        let response = frequencies.response(open)?;
        let at: Vec<DMatrix<Complex<f64>>> = grid.iter().map(|w| response.at(frequencies.angle(*w))).collect();
        let count = open.b.ncols();
        let identity = DMatrix::<Complex<f64>>::identity(count, count);
        let mut phase = (count == 1).then(|| Bode::of(at.iter().map(|m| m[(0, 0)])).phase);
        // The branch on which -180 degrees is the critical angle of a loop that lags.
        if let Some(phase) = phase.as_mut().filter(|phase| phase.first().is_some_and(|first| *first > 0.0)) {
            for angle in phase {
                *angle -= 360.0;
            }
        }
        let (mut l, mut s, mut t) = (Sigma::default(), Sigma::default(), Sigma::default());
        let none = || DMatrix::from_element(count, count, Complex::from(f64::NAN));
        for m in at {
            let inverse = (&identity + &m).try_inverse().unwrap_or_else(none);
            t.push(&(&identity - &inverse));
            s.push(&inverse);
            l.push(&m);
        }
        Ok(Self { open: l, sensitivity: s, complementary: t, phase })
    }

    fn table(&self, grid: &[f64]) -> Table {
        let mut table = Table::new().column("w", grid);
        for (name, sigma) in [("L", &self.open), ("S", &self.sensitivity), ("T", &self.complementary)] {
            table = column(table, format!("largest_{name}"), &sigma.largest);
            table = column(table, format!("smallest_{name}"), &sigma.smallest);
        }
        match &self.phase {
            Some(phase) => column(table, "phase_L".to_owned(), phase),
            None => table,
        }
    }
}

fn of_loop(
    study: &Study,
    grid: &[f64],
    at: &str,
    curves: &Curves,
    target: Option<&Curves>,
) -> Option<(String, Figure)> {
    let panel = |label: &str| Panel::new(axis(study), label).log_x();
    let both = |panel: Panel, name: &str, sigma: &Sigma, number: usize| {
        let is_single = sigma.largest == sigma.smallest;
        let smallest = if is_single { None } else { Some(&sigma.smallest) };
        let all = std::iter::once(&sigma.largest).chain(smallest);
        all.filter_map(|values| curve(name, grid, &decibels(values)))
            .fold(panel, |panel, series| panel.series(series.numbered(number)))
    };
    let state_feedback = |panel: Panel, values: &[f64]| match curve("state feedback", grid, values) {
        Some(series) => panel.series(series.hue(Hue::Grey).dash(Dash::Dashed)),
        None => panel,
    };
    let mut open = both(panel("loop L (dB)").mark(Mark::horizontal(0.0)), "with the observer", &curves.open, 0);
    if let Some(target) = target {
        open = state_feedback(open, &decibels(&target.open.largest));
    }
    let mut panels = vec![open];
    if let Some(phase) = &curves.phase {
        let phase_of = panel("phase of L (degrees)").mark(Mark::horizontal(-180.0));
        let phase_of = match curve("with the observer", grid, phase) {
            Some(series) => phase_of.series(series.numbered(0)),
            None => phase_of,
        };
        panels.push(match target.and_then(|target| target.phase.as_ref()) {
            Some(phase) => state_feedback(phase_of, phase),
            None => phase_of,
        });
    }
    let closed = both(panel("S and T (dB)").mark(Mark::horizontal(0.0)), "sensitivity S", &curves.sensitivity, 1);
    panels.push(both(closed, "complementary sensitivity T", &curves.complementary, 2));
    let caption = format!(
        "The loop of the feedback, opened at the {at} of the plant: singular values of L, of S = (I + L)^-1 and of T = L (I + L)^-1."
    );
    figure(&format!("frequency-loop-{at}"), &format!("The loop, opened at the {at}"), &caption, panels)
}

/// The table of recovery, why it is not complete, and its figure.
type Recovered = (Vec<RecoveryReport>, Option<String>, Option<(String, Figure)>);

fn recovered(
    study: &Study,
    frequencies: FrequencyAxis,
    spec: &FrequencySpec,
    (one, gain, transfer): (&Linear<'_>, &DMatrix<f64>, &LoopTransfer),
    grid: &[f64],
) -> Result<Recovered, DesignError> {
    let of = one.member.requested.kind.whole_gain().map(|spec| &spec.gain);
    let (Some(GainSpec::Kalman(noise)), false) = (of, spec.recovery.is_empty()) else {
        return Ok((Vec::new(), None, None));
    };
    let obstacle = recovery_obstacle(&one.form.plant)?.map(|obstacle| obstacle.to_string());
    let found = loop_transfer_recovery(&one.form.plant, noise, gain, &spec.recovery)?;
    let report = |one: &luenberger_design::Recovery| RecoveryReport {
        q: one.q,
        difference: one.difference.norm,
        sensitivity: one.margins.sensitivity.map(|peak| peak.norm),
        phase_margin: one
            .margins
            .channels
            .iter()
            .filter_map(StabilityMargins::phase_margin)
            .map(|margin| margin.angle.to_degrees())
            .min_by(|x, y| x.abs().total_cmp(&y.abs())),
        gain: one.l.clone().singular_values().max(),
    };
    let mut panel = Panel::new(axis(study), "largest singular value of L (dB)").log_x().mark(Mark::horizontal(0.0));
    for (k, step) in found.iter().enumerate() {
        let with = LoopTransfer::new(&one.plant, &step.l, gain)?;
        let curves = Curves::of(frequencies, &with.at_inputs, grid)?;
        let name = format!("q = {}", significant(step.q, 4));
        if let Some(series) = curve(&name, grid, &decibels(&curves.open.largest)) {
            let share = k as f64 / found.len().max(2) as f64;
            panel = panel.series(series.hue(Hue::Ramp(0.9 * share)));
        }
    }
    let target = Curves::of(frequencies, &transfer.state_feedback, grid)?;
    if let Some(series) = curve("state feedback", grid, &decibels(&target.open.largest)) {
        panel = panel.series(series.hue(Hue::Grey).dash(Dash::Dashed).width(2.0));
    }
    let caption = "The loop opened at the inputs, with the Kalman filter for the process noise W + q^2 B B', and that of state feedback.";
    let figure = figure("recovery", "Loop transfer recovery", caption, vec![panel]);
    Ok((found.iter().map(report).collect(), obstacle, figure))
}
