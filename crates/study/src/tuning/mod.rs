//! The numbers of the tuning rules of `luenberger advise`, from prior information.

mod information;
mod value;

pub(crate) use information::{Basis, Information, period, ranges, speed};
pub use information::{InformationKind, PriorInformation};
pub(crate) use value::object;
pub use value::{Keys, Value};

use luenberger_design::{DiscreteDesign, LinearDesign};
use luenberger_linalg::{PolePattern, eigenvalues, poles_from};
use luenberger_plants::Differentiable;
use luenberger_proof::wording::{rounded, significant};
use nalgebra::{Complex, DMatrix, DVector};

use crate::study::Study;

/// What a rule may use.
#[derive(Debug, Clone, Copy)]
pub struct Context<'a> {
    pub(crate) study: &'a Study,
    pub(crate) information: &'a Information,
}

impl Context<'_> {
    /// The study.
    pub fn study(&self) -> &Study {
        self.study
    }

    /// The settling time that is asked for.
    pub fn settling(&self) -> f64 {
        self.information.settling
    }

    /// The decay rate with which an error settles in this time.
    pub fn rate(&self) -> f64 {
        self.information.rate
    }
}

/// What an output error of one standard deviation may add to L by a cubic term.
pub(crate) const CUBIC_SHARE: f64 = 0.125;

/// States up to which the middle of the region is examined beside its corners; of twice as many all corners are.
pub(crate) const MANY: usize = 4;

/// Times of the run at which a plant that depends on the time is examined.
pub(crate) const INSTANTS: usize = 16;

/// How often a decay rate is halved before the rate 0 is tried.
const HALVINGS: i32 = 5;

/// Intensities that are quoted with a few digits, so that a study that is written has the numbers that were used.
pub(crate) fn short(x: f64) -> f64 {
    rounded(x, 4)
}

/// A plant that the linear kinds take: a linear one, or one with an operating point.
pub(crate) fn linear(context: &Context<'_>) -> Result<(), String> {
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
pub(crate) fn variation(context: &Context<'_>) -> Option<(String, f64, f64)> {
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
pub(crate) fn nonlinear(context: &Context<'_>) -> Result<(), String> {
    if context.study.plant.model.linear().is_none() {
        return Ok(());
    }
    let n = context.study.plant.states.len();
    Err(format!("the plant is linear: its one {n} x {n} Jacobian makes this the observer luenberger-lmi"))
}

/// Poles for the plant and `further` states: its modes that are fast enough stay, the others become Bessel poles.
pub(crate) fn poles(context: &Context<'_>, further: usize) -> Result<Keys, String> {
    Ok(vec![("poles", listed(&placed(context, further)?))])
}

/// These poles, as they are written.
pub(crate) fn placed(context: &Context<'_>, further: usize) -> Result<Vec<Complex<f64>>, String> {
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
    Ok(poles.into_iter().map(written).collect())
}

/// A pole in continuous time, or its image in discrete time.
pub(crate) fn sampled(pole: Complex<f64>, dt: Option<f64>) -> Complex<f64> {
    dt.map_or(pole, |dt| (pole * dt).exp())
}

/// A pole as it is written. Rounding errors of an eigenvalue are no imaginary part.
fn written(pole: Complex<f64>) -> Complex<f64> {
    let im = if pole.im.abs() <= 1e-9 * pole.norm() { 0.0 } else { short(pole.im) };
    Complex::new(short(pole.re), im)
}

pub(crate) fn listed(poles: &[Complex<f64>]) -> Value {
    let value = |pole: &Complex<f64>| {
        let Complex { re, im } = written(*pole);
        if im == 0.0 { Value::Number(re) } else { Value::numbers([re, im]) }
    };
    Value::List(poles.iter().map(value).collect())
}

pub(crate) fn intensity(context: &Context<'_>) -> Value {
    Value::numbers(context.information.intensity.iter().copied())
}

/// Decay rates from this one down.
pub(crate) fn rates(rate: f64) -> impl Iterator<Item = f64> {
    (0..=HALVINGS).map(move |k| short(rate * 0.5f64.powi(k))).chain([0.0])
}

/// Noise on every output.
pub(crate) fn noisy(context: &Context<'_>) -> Result<(), String> {
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
pub(crate) fn process_noise(context: &Context<'_>) -> Result<DMatrix<f64>, String> {
    let w =
        context.information.w.clone().map_err(|why| format!("no Kalman gain exists at the first estimate: {why}"))?;
    Ok(context.study.plant.dt.map_or(w.clone(), |dt| w * dt))
}

/// The covariance of a sample.
pub(crate) fn covariance(context: &Context<'_>) -> Value {
    Value::numbers(context.information.noise.iter().map(|deviation| deviation * deviation))
}

/// W, V and P0 of a filter for samples.
pub(crate) fn filter(context: &Context<'_>) -> Result<Keys, String> {
    noisy(context)?;
    let p0 = context.information.first_error.iter().map(|deviation| short(deviation * deviation));
    Ok(vec![
        ("w", Value::weight(&process_noise(context)?)),
        ("v", covariance(context)),
        ("p0", Value::numbers(p0)),
        ("period", Value::Number(context.information.period)),
    ])
}

/// theta, and what a strength of 1 adds to L at one standard deviation of the output error, of the design with these
/// poles; `normalised` for the gain `P^-1 C' (C P^-1 C')^-1`.
pub(crate) fn unit_strength(
    context: &Context<'_>,
    poles: &[Complex<f64>],
    normalised: bool,
) -> Result<(Vec<f64>, f64), String> {
    noisy(context)?;
    let (study, information) = (context.study, context.information);
    let of_point = || study.operating_point.as_ref().map(|point| &point.linear);
    let plant = study.plant.model.linear().or_else(of_point).ok_or("no linear plant")?;
    let (l, p) = match study.plant.dt {
        None => LinearDesign::with_poles(plant, poles).map(|design| (design.l().clone(), design.p.clone())),
        Some(dt) => DiscreteDesign::with_poles(plant, dt, poles).map(|design| (design.l().clone(), design.p.clone())),
    }
    .map_err(|error| error.to_string())?;
    let c = &information.linearised.1;
    let missing = || "its linear part has no P > 0".to_owned();
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
pub(crate) fn continuous(context: &Context<'_>) -> Result<(), String> {
    match context.study.plant.dt {
        Some(dt) => Err(format!("it is for plants in continuous time, and this one has dt = {dt}")),
        None => Ok(()),
    }
}

/// E of the disturbance.
pub(crate) fn disturbance<'a>(context: &'a Context<'_>) -> Result<&'a DMatrix<f64>, String> {
    let missing = "the study does not say where an unknown disturbance enters: 0 columns of E (`e` in [advise])";
    context.information.e.as_ref().ok_or_else(|| missing.to_owned())
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
pub(crate) fn over_region(context: &Context<'_>, rate: &'static str) -> Result<Vec<Keys>, String> {
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
