//! Gains of observers of linear plants: poles, noise, cubic terms.

use std::ops::Range;

use luenberger_design::{KalmanNoise, LyapunovWeight, bandwidth_poles};
use luenberger_plants::Dimensions;
use luenberger_proof::wording::{counted, shortest};
use nalgebra::{Complex, DMatrix};

use super::tree::Node;
use super::{Given, Reader, check};
use crate::study::{GainSpec, LinearSpec};
use crate::tuning::sampled;

/// At most one of these keys, or exactly one; an error names those that are present.
pub(crate) fn alternatives(node: &Node, keys: &[&str], needed: bool, reader: &mut Reader) -> Option<()> {
    let there: Vec<_> = node.entries().iter().filter(|entry| keys.contains(&entry.key.as_str())).collect();
    match &there[..] {
        [first, second, ..] => {
            let message = format!("`{}` conflicts with `{}`", second.key, first.key);
            reader.refuse(second.span.clone(), message, format!("expected one of {}", keys.join(", ")))
        }
        [] if needed => {
            let message = "the observer has no gain specification";
            reader.absent(check::head(node), message, format!("expected one of {}", keys.join(", ")));
            None
        }
        _ => Some(()),
    }
}

pub(crate) fn linear(given: &Given<'_>, reader: &mut Reader) -> Option<LinearSpec> {
    let size = given.size();
    linear_of(given.node, size, &format!("the plant has {}", counted(size.states, "state")), reader)
}

/// As [`linear`], for the plant whose number of states is what `of_states` says.
pub(crate) fn linear_of(node: &Node, size: Dimensions, of_states: &str, reader: &mut Reader) -> Option<LinearSpec> {
    let (n, p) = (size.states, size.outputs);
    let of_outputs = format!("the plant has {}", counted(p, "output"));
    let intensities = |node: &Node, reader: &mut Reader| {
        let g = match node.get("g") {
            Some(g) => Some(reader.matrix(g, "g", (Some(n), None), of_states)?),
            None => None,
        };
        let q = g.as_ref().map_or(n, DMatrix::ncols);
        let of_noise = g.as_ref().map_or_else(|| of_states.to_owned(), |_| format!("`g` has {}", counted(q, "column")));
        let w = reader.weight(node.get("w")?, "w", q, &of_noise);
        let v = reader.weight(node.get("v")?, "v", p, &of_outputs);
        let s = match node.get("s") {
            Some(s) => Some(reader.matrix(s, "s", (Some(q), Some(p)), &format!("{of_noise} and {of_outputs}"))?),
            None => None,
        };
        if let (Some(entry), Some(dt)) = (node.entry("recovery"), reader.dt) {
            not_recovered(dt, entry.span.clone(), reader);
            return None;
        }
        let recovery = node.get("recovery").and_then(Node::number).unwrap_or(0.0);
        Some(GainSpec::Kalman(KalmanNoise { w: w?, v: v?, g, s, recovery }))
    };
    let gain = if node.get("w").is_some() || node.get("v").is_some() {
        intensities(node, reader)
    } else {
        if let Some(entry) = node.entry("lmi").filter(|entry| entry.node.truth() == Some(false)) {
            return reader.refuse(
                entry.node.span.clone(),
                "`lmi` is false",
                "expected true, or another specification of the gain",
            );
        }
        let ways = ["bandwidth", "poles", "decay_rate", "lmi", "kalman", "gain"];
        let has_bandwidth = node.get("kind").and_then(Node::text) == Some("extended-state");
        alternatives(node, if has_bandwidth { &ways } else { &ways[1..] }, true, reader)?;
        if let Some(omega) = node.get("bandwidth") {
            let poles = bandwidth_poles(n, p, omega.number()?).into_iter().map(Complex::from);
            Some(GainSpec::Poles(poles.map(|pole| sampled(pole, reader.dt)).collect()))
        } else if let Some(poles) = node.get("poles") {
            self::poles(poles, n, of_states, reader)
        } else if let Some(rate) = node.get("decay_rate") {
            Some(GainSpec::DecayRate(rate.number()?))
        } else if let Some(kalman) = node.get("kalman") {
            intensities(kalman, reader)
        } else if let Some(gain) = node.get("gain") {
            reader
                .matrix(gain, "gain", (Some(n), Some(p)), &format!("{of_states} and {}", counted(p, "output")))
                .map(GainSpec::Given)
        } else {
            Some(GainSpec::Lmi)
        }
    };
    alternatives(node, &["rho", "q"], false, reader)?;
    let weight = match (node.get("rho"), node.get("q")) {
        (_, Some(q)) => Some(LyapunovWeight::Matrix(reader.matrix(q, "q", (Some(n), Some(n)), of_states)?)),
        (Some(rho), None) => Some(LyapunovWeight::Identity(rho.number()?)),
        (None, None) => None,
    };
    let gain = gain?;
    if matches!(gain, GainSpec::Lmi | GainSpec::DecayRate(_))
        && let Some(given) = ["rho", "q"].iter().find_map(|&name| node.entry(name))
    {
        let message = "`rho` and `q` have no effect: the matrix inequality determines P together with the gain";
        return reader.refuse(given.node.span.clone(), message, "expected `poles`, `kalman` or `gain` with it");
    }
    let is_filter = node.get("form").and_then(Node::text) == Some("filter");
    Some(LinearSpec { gain, weight, is_filter })
}

pub(crate) fn poles(node: &Node, n: usize, of_states: &str, reader: &mut Reader) -> Option<GainSpec> {
    let pole = |node: &Node| match node.list() {
        Some([re, im]) => Some(Complex::new(re.number()?, im.number()?)),
        Some(_) => None,
        None => Some(Complex::new(node.number()?, 0.0)),
    };
    let list = node.list()?;
    let poles: Vec<Complex<f64>> = list.iter().map(pole).collect::<Option<_>>()?;
    if poles.len() != n {
        let message = format!("`poles` has length {}, and {of_states}", poles.len());
        return reader.refuse(node.span.clone(), message, format!("expected {}", counted(n, "pole")));
    }
    let mut sound = true;
    for (pole, entry) in poles.iter().zip(list) {
        let times = |wanted: Complex<f64>| poles.iter().filter(|pole| **pole == wanted).count();
        if !reader.fits_time {
            // Neither half plane nor circle is the right place.
        } else if reader.dt.is_some() && pole.norm() >= 1.0 {
            let message = format!("the pole {} is not inside the unit circle", shown(*pole));
            reader.wrong(entry.span.clone(), message, "expected a modulus below 1: the plant is in discrete time");
            sound = false;
        } else if reader.dt.is_none() && pole.re >= 0.0 {
            let message = format!("the pole {} is not in the open left half plane", shown(*pole));
            reader.wrong(entry.span.clone(), message, "expected a negative real part");
            sound = false;
        } else if pole.im != 0.0 && times(*pole) != times(pole.conj()) {
            let message = format!("the pole {} has no conjugate", shown(*pole));
            let expected = format!("expected [{}, {}] as often", pole.re, -pole.im);
            reader.wrong(entry.span.clone(), message, expected);
            sound = false;
        }
    }
    sound.then_some(GainSpec::Poles(poles))
}

fn shown(pole: Complex<f64>) -> String {
    if pole.im == 0.0 { pole.re.to_string() } else { format!("[{}, {}]", pole.re, pole.im) }
}

/// That `recovery` is for continuous time.
pub(crate) fn not_recovered(dt: f64, span: Range<usize>, reader: &mut Reader) {
    let message = format!("`recovery` is for plants in continuous time, and this one has dt = {}", shortest(dt));
    reader.wrong(span, message, "expected no `recovery`: the loop around a predictor is not recovered");
}
