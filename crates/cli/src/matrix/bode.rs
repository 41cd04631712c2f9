//! `luenberger bode`: frequency responses of a plant, of its observer or of the loop, with margins.

use super::{from, json_output};
use crate::answer::Answer;
use crate::arguments::BodeInput;
use crate::failure::Failure;
use crate::input::given::LoopProblem;
use crate::input::json;
use crate::numbers;
use luenberger_linalg::{
    FrequencyAxis, HInfinityNorm, LinalgError, LoopMargins, LoopTransfer, ObserverTransfer, Realization,
    StabilityMargins, eigenvalues, unwrapped_phase,
};
use nalgebra::{Complex, DMatrix, DVector};
use serde::Serialize;
use std::fmt::Write as _;

#[derive(Serialize)]
struct Bode {
    #[serde(skip_serializing_if = "Option::is_none")]
    period: Option<f64>,
    frequencies: Vec<f64>,
    responses: Vec<Response>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    loops: Vec<Loop>,
}

/// A response; entries of an output and an input, each over the frequencies. At a pole nothing is known.
#[derive(Serialize)]
struct Response {
    name: &'static str,
    magnitude: Vec<Vec<Vec<f64>>>,
    phase: Vec<Vec<Vec<f64>>>,
    singular_values: Vec<Vec<f64>>,
}

#[derive(Serialize)]
struct Loop {
    name: &'static str,
    stable: bool,
    poles: Vec<[f64; 2]>,
    channels: Vec<Channel>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sensitivity: Option<Peak>,
    #[serde(skip_serializing_if = "Option::is_none")]
    complementary_sensitivity: Option<Peak>,
}

#[derive(Serialize)]
struct Channel {
    /// Each `[frequency, factor]`; the frequency is null where it is infinite.
    gain_margins: Vec<[f64; 2]>,
    /// Each `[frequency, degrees, delay]`.
    phase_margins: Vec<[f64; 3]>,
}

#[derive(Serialize)]
struct Peak {
    norm: f64,
    frequency: f64,
}

impl Peak {
    fn of(found: HInfinityNorm) -> Self {
        Self { norm: found.norm, frequency: found.frequency }
    }
}

/// Of (A, B, C, D) the plant; with L its observer; with K the loop of state feedback; with both the loop `u = -K xhat`.
pub(crate) fn bode(input: &BodeInput) -> Result<Answer, Failure> {
    let source = input.data.given();
    let axis = range(input)?;
    let [a, c, b, d, l, k] = json::some_matrices(source, LoopProblem::KEYS, 2)?;
    let [a, c] = [a, c].map(Option::unwrap_or_default);
    if b.is_none() && (l.is_none() || k.is_some()) {
        return Err(Failure::Usage("b is needed, except for the observer of a plant without inputs"));
    }
    let b = b.unwrap_or_else(|| DMatrix::zeros(a.nrows(), 0));
    let d = d.unwrap_or_else(|| DMatrix::zeros(c.nrows(), b.ncols()));
    let plant = Realization::new(&a, &b, &c, &d).map_err(from(source))?;
    let systems = systems(&plant, l.as_ref(), k.as_ref()).map_err(from(source))?;
    answer(input, axis, &plant, &systems).map_err(from(source))?
}

/// The axis of frequencies, after a check of what needs no plant.
fn range(input: &BodeInput) -> Result<FrequencyAxis, Failure> {
    let is_wrong = |x: &f64| !(*x > 0.0 && x.is_finite());
    if input.period.as_ref().is_some_and(is_wrong) {
        return Err(Failure::Usage("--period must be positive"));
    }
    if [input.from, input.to].iter().flatten().any(is_wrong) {
        return Err(Failure::Usage("--from and --to are positive frequencies"));
    }
    if let (Some(from), Some(to)) = (input.from, input.to)
        && from >= to
    {
        return Err(Failure::Usage("--from must be below --to"));
    }
    let axis = FrequencyAxis::new(input.period);
    if ![input.from, input.to].iter().flatten().all(|w| axis.contains(*w)) {
        return Err(Failure::Usage("in discrete time frequencies are at most pi/period"));
    }
    if input.points < 2 {
        return Err(Failure::Usage("--points must be 2 or more"));
    }
    Ok(axis)
}

/// A system, by its name, and whether it is a loop that is closed.
type System = (&'static str, Realization, bool);

fn systems(
    plant: &Realization,
    l: Option<&DMatrix<f64>>,
    k: Option<&DMatrix<f64>>,
) -> Result<Vec<System>, LinalgError> {
    Ok(match (l, k) {
        (None, None) => vec![("u to y", plant.clone(), false)],
        (Some(l), None) => {
            let ObserverTransfer { estimate, .. } = ObserverTransfer::new(plant, l)?;
            let p = plant.c.nrows();
            let columns = |first: usize, count: usize| Realization {
                b: estimate.b.columns(first, count).into_owned(),
                d: estimate.d.columns(first, count).into_owned(),
                ..estimate.clone()
            };
            let mut all = vec![("y to xhat", columns(0, p), false)];
            if plant.b.ncols() > 0 {
                all.push(("u to xhat", columns(p, plant.b.ncols()), false));
            }
            all
        }
        (None, Some(k)) => {
            let none = DMatrix::zeros(plant.a.nrows(), plant.c.nrows());
            let LoopTransfer { state_feedback, .. } = LoopTransfer::new(plant, &none, k)?;
            vec![("loop K (s I - A)^-1 B of state feedback", state_feedback, true)]
        }
        (Some(l), Some(k)) => {
            let LoopTransfer { at_inputs, at_outputs, .. } = LoopTransfer::new(plant, l, k)?;
            vec![("loop at the inputs", at_inputs, true), ("loop at the outputs", at_outputs, true)]
        }
    })
}

fn answer(
    input: &BodeInput,
    axis: FrequencyAxis,
    plant: &Realization,
    systems: &[System],
) -> Result<Result<Answer, Failure>, LinalgError> {
    let mut features = eigenvalues(&plant.a)?;
    for (_, system, _) in systems {
        features.extend(eigenvalues(&system.a)?);
    }
    let grid = axis.grid(&features, [input.from, input.to], input.points);
    let (mut text, mut responses, mut loops) = (String::new(), Vec::new(), Vec::new());
    for (name, system, is_loop) in systems {
        text.push_str(name);
        if *is_loop {
            let margins = axis.margins(system)?;
            text += &in_words(&margins);
            loops.push(described(name, &margins));
        } else {
            text.push('\n');
        }
        let response = axis.response(system)?;
        let at: Vec<DMatrix<Complex<f64>>> = grid.iter().map(|w| response.at(axis.angle(*w))).collect();
        let values: Vec<DVector<f64>> = grid.iter().map(|w| response.singular_values(axis.angle(*w))).collect();
        text += &table(&grid, &at, &values);
        responses.push(tabulated(name, &at, &values));
    }
    let all = Bode { period: input.period, frequencies: grid, responses, loops };
    Ok(Answer::new(text, &all).map_err(Failure::from))
}

fn decibels(x: f64) -> f64 {
    20.0 * x.log10()
}

/// Magnitude and phase of a response with one output and one input, else its singular values.
fn table(grid: &[f64], at: &[DMatrix<Complex<f64>>], values: &[DVector<f64>]) -> String {
    let is_single = at.iter().all(|m| m.len() == 1);
    let count = values.first().map_or(0, DVector::len);
    let mut rows = DMatrix::zeros(grid.len(), 1 + if is_single { 2 } else { count });
    let phase = if is_single { unwrapped_phase(at.iter().map(|m| m[(0, 0)])) } else { Vec::new() };
    for (k, (w, values)) in grid.iter().zip(values).enumerate() {
        rows[(k, 0)] = *w;
        for (j, value) in values.iter().enumerate() {
            rows[(k, 1 + j)] = decibels(*value);
        }
        if let Some(phase) = phase.get(k) {
            rows[(k, 2)] = phase.to_degrees();
        }
    }
    let head = if is_single { "w, magnitude (dB), phase (degrees)" } else { "w, singular values (dB)" };
    numbers::matrix(head, &rows)
}

fn tabulated(name: &'static str, at: &[DMatrix<Complex<f64>>], values: &[DVector<f64>]) -> Response {
    let (p, m) = at.first().map_or((0, 0), DMatrix::shape);
    let over = |of: &dyn Fn(usize, usize) -> Vec<f64>| -> Vec<Vec<Vec<f64>>> {
        (0..p).map(|i| (0..m).map(|j| of(i, j)).collect()).collect()
    };
    Response {
        name,
        magnitude: over(&|i, j| at.iter().map(|g| g[(i, j)].norm()).collect()),
        phase: over(&|i, j| unwrapped_phase(at.iter().map(|g| g[(i, j)])).into_iter().map(f64::to_degrees).collect()),
        singular_values: values.iter().map(|values| values.iter().copied().collect()).collect(),
    }
}

fn described(name: &'static str, margins: &LoopMargins) -> Loop {
    let channel = |found: &StabilityMargins| Channel {
        gain_margins: found.gain.iter().map(|one| [one.frequency, one.factor]).collect(),
        phase_margins: found.phase.iter().map(|one| [one.frequency, one.angle.to_degrees(), one.delay]).collect(),
    };
    Loop {
        name,
        stable: margins.sensitivity.is_some(),
        poles: json_output::pairs(&margins.poles),
        channels: margins.channels.iter().map(channel).collect(),
        sensitivity: margins.sensitivity.map(Peak::of),
        complementary_sensitivity: margins.complementary.map(Peak::of),
    }
}

/// The margins, a line each.
fn in_words(margins: &LoopMargins) -> String {
    let at = numbers::number;
    let stable = if margins.sensitivity.is_some() { "stable" } else { "not stable" };
    let mut text = format!(": closed, it is {stable}\n");
    for (i, found) in margins.channels.iter().enumerate() {
        if margins.channels.len() > 1 {
            _ = writeln!(text, "channel {}, the others closed", i + 1);
        }
        let mut gain = |what: &str, one: Option<luenberger_linalg::GainMargin>| {
            if let Some(one) = one {
                let (factor, db) = (numbers::number(one.factor), numbers::number(decibels(one.factor)));
                _ = writeln!(text, "  {what} {factor} ({db} dB) at {}", at(one.frequency));
            }
        };
        gain("gain margin", found.gain_margin());
        gain("gain may fall to", found.gain_reduction());
        if let Some(one) = found.phase_margin() {
            let degrees = numbers::number(one.angle.to_degrees());
            _ = writeln!(text, "  phase margin {degrees} degrees at {}", at(one.frequency));
        }
        if let Some(one) = found.delay_margin() {
            let delay = numbers::number(one.delay);
            _ = writeln!(text, "  delay margin {delay} at {}", at(one.frequency));
        }
        if found.gain.is_empty() && found.phase.is_empty() {
            text += "  no crossover: any gain and any phase\n";
        }
    }
    if let (Some(s), Some(t)) = (margins.sensitivity, margins.complementary) {
        _ = writeln!(
            text,
            "  peak of S {} at {}, of T {} at {}",
            numbers::number(s.norm),
            at(s.frequency),
            numbers::number(t.norm),
            at(t.frequency)
        );
    }
    text
}
