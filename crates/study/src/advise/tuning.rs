//! The numbers of the tuning rules.

use std::sync::atomic::AtomicBool;

use luenberger_linalg::{PolePattern, eigenvalues, poles_from};
use luenberger_plants::{Differentiable, Plant};
use luenberger_proof::wording::{counted, rounded, significant};
use nalgebra::{Complex, DMatrix, DVector};

use super::block::{Block, Keys, Value, study_with};
use super::information::{Information, speed};
use crate::design::{self, NoDesign};
use crate::study::Study;

/// What a rule may use.
pub(super) struct Context<'a> {
    pub(super) study: &'a Study,
    pub(super) information: &'a Information,
}

/// What an output error of one standard deviation may add to L by a cubic term.
const CUBIC_SHARE: f64 = 0.125;

/// States up to which the middle of the region is examined beside its corners; of twice as many all corners are.
const MANY: usize = 4;

/// Times of the run at which a plant that depends on the time is examined.
const INSTANTS: usize = 16;

/// How often a decay rate is halved before the rate 0 is tried.
const HALVINGS: i32 = 5;

/// Intensities that are quoted with a few digits, so that a study that is written has the numbers that were used.
fn short(x: f64) -> f64 {
    rounded(x, 4)
}

/// A plant that the linear kinds take: a linear one, or one with an operating point.
fn linear(context: &Context<'_>) -> Result<(), String> {
    let study = context.study;
    if study.plant.model.linear().is_some() || study.operating_point.is_some() {
        return Ok(());
    }
    let why = "the plant is nonlinear and the study has no [operating_point]";
    Err(match variation(context) {
        Some((name, low, high)) => {
            format!("{why}; {name} alone goes from {} to {} over the region", significant(low, 3), significant(high, 3))
        }
        None => why.to_owned(),
    })
}

/// The derivative that differs most between points of the region, relative to the largest, with its extremes.
fn variation(context: &Context<'_>) -> Option<(String, f64, f64)> {
    let (plant, region) = (&context.study.plant, &context.information.region);
    let n = plant.states.len();
    let inputs: Vec<f64> =
        region.input_bounds().unwrap_or_default().iter().map(|(l, h)| f64::midpoint(*l, *h)).collect();
    // Inside of the region, where the derivatives are finite: the lower part, the middle and the upper part of each
    // axis.
    let shares: &[f64] = if n <= MANY { &[0.05, 0.5, 0.95] } else { &[0.05, 0.95] };
    let points = shares.len().pow(n.min(2 * MANY) as u32);
    let at = |k: usize| {
        let x = region.states().iter().enumerate().map(|(i, (low, high))| {
            let share = shares[k / shares.len().pow(i.min(2 * MANY) as u32) % shares.len()];
            low + share * (high - low)
        });
        plant.model.state_jacobian(0.0, &DVector::from_iterator(n, x), &DVector::from_column_slice(&inputs))
    };
    let all: Vec<DMatrix<f64>> = (0..points).map(at).filter(|a| a.iter().all(|entry| entry.is_finite())).collect();
    let range = |i: usize, j: usize| {
        all.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), a| (low.min(a[(i, j)]), high.max(a[(i, j)])))
    };
    let entries = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let most = entries.map(|(i, j)| (i, j, range(i, j))).max_by(|one, other| {
        let spread = |(low, high): (f64, f64)| high - low;
        spread(one.2).total_cmp(&spread(other.2))
    });
    let differs = |(low, high): (f64, f64)| high - low > 1e-9 * high.abs().max(low.abs());
    let (i, j, (low, high)) = most.filter(|most| differs(most.2))?;
    Some((format!("d({}')/d({})", plant.states[i], plant.states[j]), low, high))
}

/// A plant for which a kind of nonlinear plants is another one than a linear kind.
pub(super) fn nonlinear(context: &Context<'_>) -> Result<(), String> {
    if context.study.plant.model.linear().is_none() {
        return Ok(());
    }
    let n = context.study.plant.states.len();
    Err(format!("the plant is linear: its one {n} x {n} Jacobian makes this the observer luenberger-lmi"))
}

/// Poles for the plant and `further` states: its modes that are fast enough stay, the others become Bessel poles.
pub(super) fn poles(context: &Context<'_>, further: usize) -> Result<Keys, String> {
    linear(context)?;
    let (dt, information) = (context.study.plant.dt, context.information);
    let modes = eigenvalues(&information.linearised.0).map_err(|error| error.to_string())?;
    let fast = |mode: &&Complex<f64>| speed(**mode, dt) >= information.linear_rate;
    let mut poles: Vec<Complex<f64>> = modes.iter().filter(fast).copied().collect();
    let order = modes.len() - poles.len() + further;
    let settling = -information.band.ln() / information.linear_rate;
    let moved =
        poles_from(PolePattern::Bessel, order, settling, information.band).map_err(|error| error.to_string())?;
    poles.extend(moved.into_iter().map(|pole| sampled(pole, dt)));
    Ok(vec![("poles", listed(&poles))])
}

/// A pole in continuous time, or its image in discrete time.
fn sampled(pole: Complex<f64>, dt: Option<f64>) -> Complex<f64> {
    dt.map_or(pole, |dt| (pole * dt).exp())
}

fn listed(poles: &[Complex<f64>]) -> Value {
    // Rounding errors of an eigenvalue are no imaginary part.
    let value = |pole: &Complex<f64>| {
        if pole.im.abs() <= 1e-9 * pole.norm() {
            Value::Number(short(pole.re))
        } else {
            Value::numbers([short(pole.re), short(pole.im)])
        }
    };
    Value::List(poles.iter().map(value).collect())
}

fn intensity(context: &Context<'_>) -> Value {
    Value::numbers(context.information.intensity.iter().copied())
}

/// Decay rates from this one down.
fn rates(rate: f64) -> impl Iterator<Item = f64> {
    (0..=HALVINGS).map(move |k| short(rate * 0.5f64.powi(k))).chain([0.0])
}

pub(super) fn least_noise(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    linear(context)?;
    if let Some(dt) = context.study.plant.dt {
        return Err(format!("its matrix inequality is for plants in continuous time, and this one has dt = {dt}"));
    }
    noisy(context)?;
    let keys = |rate: f64| vec![("decay_rate", Value::Number(rate)), ("noise", intensity(context))];
    Ok(rates(context.information.linear_rate).filter(|rate| *rate > 0.0).map(keys).collect())
}

/// Noise on every output.
fn noisy(context: &Context<'_>) -> Result<(), String> {
    let information = context.information;
    match information.noise.iter().position(|deviation| *deviation == 0.0) {
        Some(output) => {
            let name = &context.study.plant.outputs[output];
            Err(format!("the noise level of {name} is 0, and a covariance V > 0 is needed"))
        }
        None => Ok(()),
    }
}

/// The intensity of the process noise, of a sample for a plant in discrete time.
fn process_noise(context: &Context<'_>) -> Result<DMatrix<f64>, String> {
    let w =
        context.information.w.clone().map_err(|why| format!("no Kalman gain exists at the first estimate: {why}"))?;
    Ok(context.study.plant.dt.map_or(w.clone(), |dt| w * dt))
}

/// The covariance of a sample.
fn covariance(context: &Context<'_>) -> Value {
    Value::numbers(context.information.noise.iter().map(|deviation| deviation * deviation))
}

pub(super) fn kalman(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    linear(context)?;
    noisy(context)?;
    let v = if context.study.plant.dt.is_some() { covariance(context) } else { intensity(context) };
    Ok(vec![vec![("w", Value::weight(&process_noise(context)?)), ("v", v)]])
}

/// W, V and P0 of a filter for samples.
pub(super) fn filter(context: &Context<'_>) -> Result<Keys, String> {
    noisy(context)?;
    let p0 = context.information.first_error.iter().map(|deviation| short(deviation * deviation));
    Ok(vec![
        ("w", Value::weight(&process_noise(context)?)),
        ("v", covariance(context)),
        ("p0", Value::numbers(p0)),
        ("period", Value::Number(context.information.period)),
    ])
}

/// A filter over a window, with the region as bounds of the states.
pub(super) fn moving_horizon(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    let mut keys = filter(context)?;
    keys.push(("state_bounds", Value::pairs(context.information.region.states())));
    Ok(vec![keys])
}

/// theta, and what a strength of 1 adds to L at one standard deviation of the output error, of the design with these
/// poles; `normalised` for the gain `P^-1 C' (C P^-1 C')^-1`.
fn unit_strength(context: &Context<'_>, poles: &Keys, normalised: bool) -> Result<(Vec<f64>, f64), String> {
    noisy(context)?;
    let (study, information) = (context.study, context.information);
    let block = Block {
        name: "linear part".to_owned(),
        kind: "luenberger",
        keys: poles.clone(),
        initial: information.initial.clone(),
        comment: String::new(),
    };
    let with = study_with(study, std::slice::from_ref(&block)).map_err(|error| error.to_string())?;
    let spec = with.observer(&block.name).ok_or("no design")?;
    let designed = design::attempt(&with, spec, &AtomicBool::new(false), None).map_err(|none| match none {
        NoDesign::Misfit(failure) => failure.hypothesis,
        NoDesign::Interrupted => "interrupted".to_owned(),
    })?;
    let named = |name: &str| {
        let found = designed.report.matrices.iter().find(|matrix| matrix.name == name)?;
        let columns = found.rows.first()?.len();
        Some(DMatrix::from_row_iterator(found.rows.len(), columns, found.rows.iter().flatten().copied()))
    };
    let missing = || "its linear part has no L and P".to_owned();
    let (l, p) = (named("L").ok_or_else(missing)?, named("P").ok_or_else(missing)?);
    let c = &information.linearised.1;
    let pc = p.cholesky().ok_or_else(missing)?.solve(&c.transpose());
    let theta: Vec<f64> = information.noise.iter().map(|deviation| short(1.0 / (deviation * deviation))).collect();
    let direction = if normalised {
        let inverse = (c * &pc).try_inverse().ok_or_else(missing)?;
        &pc * inverse
    } else {
        &pc * DMatrix::from_diagonal(&DVector::from_column_slice(&theta))
    };
    // At one standard deviation of each output y~'theta y~ is their number.
    Ok((theta.clone(), theta.len() as f64 * direction.norm() / l.norm()))
}

/// A plant in continuous time.
fn continuous(context: &Context<'_>) -> Result<(), String> {
    match context.study.plant.dt {
        Some(dt) => Err(format!("it is for plants in continuous time, and this one has dt = {dt}")),
        None => Ok(()),
    }
}

pub(super) fn cubic(context: &Context<'_>) -> Result<Keys, String> {
    continuous(context)?;
    let mut keys = poles(context, 0)?;
    let (theta, unit) = unit_strength(context, &keys, false)?;
    keys.push(("theta", Value::numbers(theta)));
    keys.push(("gamma", Value::Number(short(CUBIC_SHARE / unit))));
    Ok(keys)
}

pub(super) fn sampled_cubic(context: &Context<'_>) -> Result<Keys, String> {
    let mut keys = poles(context, 0)?;
    let (theta, unit) = unit_strength(context, &keys, true)?;
    keys.push(("theta", Value::numbers(theta)));
    keys.push(("gamma", Value::Number(short(CUBIC_SHARE / unit))));
    keys.push(("period", Value::Number(context.information.period)));
    Ok(keys)
}

/// Semi-axes of the ellipsoid whose points have the standard deviations of the first error, `sqrt(n)` of them.
pub(super) fn optimal_cubic(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    continuous(context)?;
    linear(context)?;
    noisy(context)?;
    let information = context.information;
    let axes = (information.first_error.len() as f64).sqrt();
    // Outputs whose noise is held for a longer time have the same intensity here.
    let deviations = information.intensity.iter().map(|intensity| short((intensity / information.held).sqrt()));
    let weight = information.scale.iter().map(|scale| short(1.0 / (scale * scale)));
    Ok(vec![vec![
        ("first_errors", Value::numbers(information.first_error.iter().map(|deviation| short(axes * deviation)))),
        ("noise_deviation", Value::numbers(deviations)),
        ("noise_period", Value::Number(information.held)),
        ("process_noise", Value::weight(&process_noise(context)?)),
        ("weight", Value::numbers(weight)),
    ]])
}

pub(super) fn interval(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    let mut keys = poles(context, 0)?;
    let information = context.information;
    let first = information
        .initial
        .iter()
        .zip(information.region.states())
        .map(|(x, (low, high))| (high - x).max(x - low).max(0.0));
    let mut bounds = vec![("noise", Value::numbers(information.largest.iter().copied()))];
    if let Some((disturbance, e)) = &information.acting {
        bounds.push(("disturbance", Value::numbers(disturbance.iter().copied())));
        bounds.push(("e", Value::rows(e)));
    }
    keys.push(("initial_bounds", Value::numbers(first)));
    keys.push(("bounds", Value::Table(bounds)));
    Ok(vec![keys])
}

/// D of the reaching time: from an error e2 without a disturbance the default gains for two states reach 0 after the
/// time 0.99 e2/D.
pub(super) fn sliding_mode(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    continuous(context)?;
    let (plant, information) = (&context.study.plant, context.information);
    let last = plant.states.len() - 1;
    let open =
        spread(context, last).ok_or_else(|| format!("{}' is not finite anywhere in the region", plant.states[last]))?;
    let acting = information.acting.as_ref().map_or(0.0, |(bounds, e)| {
        bounds.iter().zip(e.row(last).iter()).map(|(bound, e)| (bound * e).abs()).sum::<f64>()
    });
    let reaching = information.first_error[last] / information.settling;
    let bound = (open + acting).max(reaching);
    Ok(vec![vec![("bound", Value::Number(short(bound))), ("period", Value::Number(information.period))]])
}

/// By how much the derivative of a state differs at most between points of a grid over the region, under one input and
/// at one time.
fn spread(context: &Context<'_>, state: usize) -> Option<f64> {
    let (plant, region) = (&context.study.plant, &context.information.region);
    let (n, inputs) = (plant.states.len(), region.input_bounds().unwrap_or_default());
    // At least the corners, the middle and the quarters of each axis, and a few thousand points.
    let steps = (4000f64.powf(1.0 / n as f64) as usize).clamp(2, 64);
    let points = (steps + 1).pow(n.min(2 * MANY) as u32);
    let derivative = |k: usize, t: f64, u: &DVector<f64>| {
        let x = region.states().iter().enumerate().map(|(i, (low, high))| {
            let share = k / (steps + 1).pow(i.min(2 * MANY) as u32) % (steps + 1);
            low + share as f64 / steps as f64 * (high - low)
        });
        plant.model.derivative(t, &DVector::from_iterator(n, x), u)[state]
    };
    let duration = context.study.simulation.as_ref().map_or(0.0, |simulation| simulation.duration);
    let instants = if plant.model.structure().explicit_time().is_some() { INSTANTS } else { 1 };
    let corners = 0..1usize << inputs.len().min(MANY);
    let cases = corners.flat_map(|corner| (0..instants).map(move |k| (corner, duration * k as f64 / INSTANTS as f64)));
    let widths = cases.filter_map(|(corner, t)| {
        let at = |(j, (low, high)): (usize, &(f64, f64))| if corner >> j & 1 == 0 { *low } else { *high };
        let u = DVector::from_iterator(inputs.len(), inputs.iter().enumerate().map(at));
        let values = (0..points).map(|k| derivative(k, t, &u)).filter(|value| value.is_finite());
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        (low <= high).then_some(high - low)
    });
    widths.reduce(f64::max)
}

/// E of the disturbance.
fn disturbance<'a>(context: &'a Context<'_>) -> Result<&'a DMatrix<f64>, String> {
    let missing = "the study does not say where an unknown disturbance enters: 0 columns of E (`e` in [advise])";
    context.information.e.as_ref().ok_or_else(|| missing.to_owned())
}

pub(super) fn proportional_integral(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    let e = disturbance(context)?;
    let mut keys = vec![("e", Value::rows(e))];
    keys.extend(poles(context, e.ncols())?);
    Ok(vec![keys])
}

/// Order 1: a constant disturbance.
pub(super) fn extended_state(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    let e = disturbance(context)?;
    linear(context)?;
    let settling = -context.information.band.ln() / context.information.linear_rate;
    let order = context.study.plant.states.len() + e.ncols();
    let bandwidth = chain_settling(order, context.information.band) / settling;
    Ok(vec![vec![("e", Value::rows(e)), ("bandwidth", Value::Number(short(bandwidth)))]])
}

pub(super) fn reduced_order(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    linear(context)?;
    let (plant, information) = (&context.study.plant, context.information);
    let order = plant.states.len().saturating_sub(plant.outputs.len());
    if order == 0 {
        return Err(format!("it estimates n - p states, and the plant has n = p = {}", plant.states.len()));
    }
    let settling = -information.band.ln() / information.linear_rate;
    let found =
        poles_from(PolePattern::Bessel, order, settling, information.band).map_err(|error| error.to_string())?;
    let poles: Vec<_> = found.into_iter().map(|pole| sampled(pole, plant.dt)).collect();
    Ok(vec![vec![("poles", listed(&poles))]])
}

/// Process noise and measurement noise as one w of unit intensity, and errors in units of the scale.
pub(super) fn norm(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    linear(context)?;
    noisy(context)?;
    let information = context.information;
    let eigen = process_noise(context)?.symmetric_eigen();
    let root = DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0).sqrt()));
    let entering = &eigen.eigenvectors * root * eigen.eigenvectors.transpose();
    let (n, p) = (entering.nrows(), information.noise.len());
    let of_sample = context.study.plant.dt.is_some();
    let deviation = |j: usize| if of_sample { information.noise[j] } else { information.intensity[j].sqrt() };
    let e = DMatrix::from_fn(n, n + p, |i, j| if j < n { short(entering[(i, j)]) } else { 0.0 });
    let d = DMatrix::from_fn(p, n + p, |i, j| if j == n + i { deviation(i) } else { 0.0 });
    let h = DMatrix::from_fn(n, n, |i, j| if i == j { short(1.0 / information.scale[i]) } else { 0.0 });
    Ok(vec![vec![("e", Value::rows(&e)), ("d", Value::rows(&d)), ("h", Value::rows(&h))]])
}

pub(super) fn unknown_input(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    let e = disturbance(context)?;
    linear(context)?;
    let keys = |rate: f64| vec![("e", Value::rows(e)), ("decay_rate", Value::Number(rate))];
    Ok(rates(context.information.linear_rate).filter(|rate| *rate > 0.0).map(keys).collect())
}

/// A region as a key.
fn region(context: &Context<'_>) -> Value {
    let region = &context.information.region;
    let mut keys = vec![("states", Value::pairs(region.states()))];
    if let Some(inputs) = region.input_bounds() {
        keys.push(("inputs", Value::pairs(inputs)));
    }
    if context.study.plant.model.structure().explicit_time().is_some() {
        let (from, to) = region.time_bounds();
        let end = context.study.simulation.as_ref().map_or(to, |simulation| simulation.duration);
        keys.push(("time", Value::numbers([from.max(0.0), to.min(end)])));
    }
    Value::Table(keys)
}

/// Region, rate and noise; with `fastest` the design searches the rate.
pub(super) fn over_region(context: &Context<'_>, rate: &'static str) -> Result<Vec<Keys>, String> {
    noisy(context)?;
    let keys =
        |value: f64| vec![("region", region(context)), (rate, Value::Number(value)), ("noise", intensity(context))];
    let is_searched = rate == "fastest";
    let all: Vec<Keys> = if is_searched {
        vec![keys(short(context.information.rate))]
    } else {
        rates(context.information.rate).map(keys).collect()
    };
    Ok(all)
}

/// r for each way to cut the states into as many chains as there are outputs.
pub(super) fn high_gain(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    let (n, p) = (context.study.plant.states.len(), context.study.plant.outputs.len());
    if p > n {
        return Err(format!("each chain begins at an output: {} for {}", counted(p, "output"), counted(n, "state")));
    }
    let of = |chains: &Vec<usize>| {
        let longest = chains.iter().copied().max().unwrap_or(1);
        let time = chain_settling(longest, context.information.band);
        let mut keys = vec![("r", Value::Number(short(context.information.settling / time)))];
        if p > 1 {
            keys.push(("chains", Value::numbers(chains.iter().map(|length| *length as f64))));
        }
        keys
    };
    Ok(compositions(n, p).iter().map(of).collect())
}

/// Settling time of the step response of `(s + 1)^-n`, which is `1 - e^-t sum_(k<n) t^k/k!`.
pub fn chain_settling(n: usize, band: f64) -> f64 {
    let rest = |t: f64| {
        let terms = (0..n).scan(1.0, |term, k| {
            let now = *term;
            *term *= t / (k + 1) as f64;
            Some(now)
        });
        (-t).exp() * terms.sum::<f64>()
    };
    // The rest decreases, and at the upper end it is below any band above rounding errors.
    let (mut low, mut high) = (0.0, 40.0 + 4.0 * n as f64);
    while high - low > 1e-9 {
        let middle = f64::midpoint(low, high);
        if rest(middle) > band { low = middle } else { high = middle }
    }
    high
}

/// The ways to write n as an ordered sum of p positive numbers, the even ones first.
pub fn compositions(n: usize, p: usize) -> Vec<Vec<usize>> {
    if p <= 1 {
        return vec![vec![n]];
    }
    let mut all: Vec<Vec<usize>> = (1..=n + 1 - p)
        .flat_map(|first| compositions(n - first, p - 1).into_iter().map(move |rest| [vec![first], rest].concat()))
        .collect();
    all.sort_by_key(|chains| chains.iter().map(|length| length * length).sum::<usize>());
    all.truncate(64);
    all
}
