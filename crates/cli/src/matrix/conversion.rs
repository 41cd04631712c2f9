//! `luenberger c2d` and `luenberger d2c`.

use super::{from, json_output};
use crate::answer::Answer;
use crate::arguments::{ConversionInput, Method, SamplingInput};
use crate::failure::Failure;
use crate::input::given::StateSpace;
use crate::input::json;
use crate::numbers;
use luenberger_linalg::{Discretization, Realization};
use luenberger_proof::wording::counted;
use nalgebra::DMatrix;
use serde::Serialize;

#[derive(Serialize)]
struct Model {
    a: Vec<Vec<f64>>,
    b: Vec<Vec<f64>>,
    c: Vec<Vec<f64>>,
    d: Vec<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    period: Option<f64>,
    /// The delays of the inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    delays: Option<Vec<f64>>,
    /// The delays of the outputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    output_delays: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    transfer: Option<Transfer>,
}

/// Zeros, poles and gain of `matched`.
#[derive(Serialize)]
struct Transfer {
    zeros: Vec<[f64; 2]>,
    poles: Vec<[f64; 2]>,
    gain: f64,
}

/// Continuous to discrete time.
pub(crate) fn c2d(sampling: &SamplingInput) -> Result<Answer, Failure> {
    let input = &sampling.conversion;
    fits(input, false)?;
    if !(sampling.delay.is_empty() && sampling.output_delay.is_empty()) {
        return delayed(sampling);
    }
    let system = read(input)?;
    let period = Some(input.period);
    if input.method == Method::Matched {
        let found = luenberger_linalg::c2d_matched(&system, input.period).map_err(from(input.data.given()))?;
        let model = found.realization();
        let text = format!(
            "x+ = A x + B u, y = C x + D u, period {}\n{}{}{}gain {}\n",
            numbers::number(input.period),
            matrices(&model),
            numbers::list("zeros", &found.zeros),
            numbers::list("poles", &found.poles),
            numbers::number(found.gain)
        );
        let (zeros, poles) = (json_output::pairs(&found.zeros), json_output::pairs(&found.poles));
        let transfer = Some(Transfer { zeros, poles, gain: found.gain });
        return Ok(Answer::new(text, &Model { period, transfer, ..json(&model) })?);
    }
    let method = discretization(input);
    let model = luenberger_linalg::c2d(&system, input.period, method).map_err(from(input.data.given()))?;
    let head = format!("x+ = A x + B u, y = C x + D u, period {}\n", numbers::number(input.period));
    Ok(Answer::new(head + &matrices(&model), &Model { period, ..json(&model) })?)
}

/// Zero-order hold with delays of inputs and outputs; one delay is that of each of them.
fn delayed(SamplingInput { conversion: input, delay, output_delay }: &SamplingInput) -> Result<Answer, Failure> {
    if input.method != Method::Zoh {
        return Err(Failure::Usage("--delay and --output-delay belong to --method zoh"));
    }
    let system = read(input)?;
    let ((n, m), p) = (system.b.shape(), system.c.nrows());
    let each = |given: &[f64], number: usize| match given {
        [] => vec![0.0; number],
        [delay] => vec![*delay; number],
        several => several.to_vec(),
    };
    let (inputs, outputs) = (each(delay, m), each(output_delay, p));
    let model =
        luenberger_linalg::c2d_delayed(&system, input.period, &inputs, &outputs).map_err(from(input.data.given()))?;
    let past = model.a.nrows() - n;
    let past = match (delay.is_empty(), output_delay.is_empty()) {
        (false, true) => counted(past, "past input"),
        (true, _) => counted(past, "past output"),
        (false, false) => format!("{past} past inputs and outputs"),
    };
    let text = format!(
        "x+ = A x + B u, y = C x + D u, period {}; x has {} of the plant and {past}\n{}",
        numbers::number(input.period),
        counted(n, "state"),
        matrices(&model)
    );
    let given = |delays: Vec<f64>, is_given: bool| is_given.then_some(delays);
    let (delays, output_delays) = (given(inputs, !delay.is_empty()), given(outputs, !output_delay.is_empty()));
    Ok(Answer::new(text, &Model { period: Some(input.period), delays, output_delays, ..json(&model) })?)
}

/// Discrete to continuous time.
pub(crate) fn d2c(input: &ConversionInput) -> Result<Answer, Failure> {
    fits(input, true)?;
    let system = read(input)?;
    let model =
        luenberger_linalg::d2c(&system, input.period, discretization(input)).map_err(from(input.data.given()))?;
    Ok(Answer::new(format!("x' = A x + B u, y = C x + D u\n{}", matrices(&model)), &json(&model))?)
}

/// The model of the input; without `c` its output is its state, without `d` D is 0.
fn read(input: &ConversionInput) -> Result<Realization, Failure> {
    let [a, b, c, d] = json::some_matrices(input.data.given(), StateSpace::KEYS, 2)?;
    let (a, b) = (a.unwrap_or_default(), b.unwrap_or_default());
    let c = c.unwrap_or_else(|| DMatrix::identity(a.nrows(), a.nrows()));
    let d = d.unwrap_or_else(|| DMatrix::zeros(c.nrows(), b.ncols()));
    Realization::new(&a, &b, &c, &d).map_err(from(input.data.given()))
}

fn discretization(input: &ConversionInput) -> Discretization {
    match input.method {
        Method::Zoh | Method::Matched => Discretization::ZeroOrderHold,
        Method::Foh => Discretization::FirstOrderHold,
        Method::Impulse => Discretization::Impulse,
        Method::Tustin => input.prewarp.map_or(Discretization::Tustin, Discretization::TustinPrewarped),
    }
}

fn matrices(model: &Realization) -> String {
    [("A", &model.a), ("B", &model.b), ("C", &model.c), ("D", &model.d)]
        .map(|(name, m)| numbers::matrix(name, m))
        .concat()
}

fn json(model: &Realization) -> Model {
    let [a, b, c, d] = [&model.a, &model.b, &model.c, &model.d].map(json_output::rows);
    Model { a, b, c, d, period: None, delays: None, output_delays: None, transfer: None }
}

/// Checks the combination of options: `matched` has no inverse, and prewarping belongs to Tustin's method.
fn fits(input: &ConversionInput, is_inverse: bool) -> Result<(), Failure> {
    match input.method {
        Method::Matched if is_inverse => {
            Err(Failure::Usage("d2c has no method matched: choose zoh, foh, tustin or impulse"))
        }
        Method::Tustin => Ok(()),
        _ if input.prewarp.is_some() => Err(Failure::Usage("--prewarp belongs to --method tustin")),
        _ => Ok(()),
    }
}
