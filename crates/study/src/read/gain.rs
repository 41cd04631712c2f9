//! Gains of observers of linear plants: poles, noise, cubic terms.

use luenberger_design::{CubicGain, LyapunovWeight, Periods, bandwidth_poles};
use luenberger_plants::Dimensions;
use luenberger_proof::certificate::MOST_MISSES;
use luenberger_proof::wording::counted;
use nalgebra::{Complex, DMatrix};

use super::region::bound;
use super::tree::Node;
use super::{Reader, check};
use crate::study::{GainSpec, LinearSpec, ObserverKind};

/// At most one of these keys, or exactly one; an error names those that are present.
pub(super) fn alternatives(node: &Node, keys: &[&str], needed: bool, reader: &mut Reader) -> Option<()> {
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

pub(super) fn linear(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<LinearSpec> {
    linear_of(node, size, &format!("the plant has {}", counted(size.states, "state")), reader)
}

/// As [`linear`], for the plant whose number of states is what `of_states` says.
pub(super) fn linear_of(node: &Node, size: Dimensions, of_states: &str, reader: &mut Reader) -> Option<LinearSpec> {
    let (n, p) = (size.states, size.outputs);
    let of_outputs = format!("the plant has {}", counted(p, "output"));
    let intensities = |node: &Node, reader: &mut Reader| {
        let w = reader.weight(node.get("w")?, "w", n, of_states);
        let v = reader.weight(node.get("v")?, "v", p, &of_outputs);
        Some(GainSpec::Kalman { w: w?, v: v? })
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
            let poles = bandwidth_poles(n, p, omega.number()?);
            Some(GainSpec::Poles(poles.into_iter().map(Complex::from).collect()))
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

/// The poles of a reduced-order observer.
pub(super) fn reduced_order(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<ObserverKind> {
    let (n, p) = (size.states, size.outputs);
    if reader.dt.is_some() {
        return reader.refuse(check::head(node), "this kind is for plants in continuous time", "expected another kind");
    }
    if p >= n {
        let message =
            format!("the plant has {} and {}: no state is left to estimate", counted(n, "state"), counted(p, "output"));
        return reader.refuse(check::head(node), message, "expected a plant with fewer outputs than states");
    }
    let left = format!("of {} the outputs leave {}", counted(n, "state"), n - p);
    match poles(node.get("poles")?, n - p, &left, reader)? {
        GainSpec::Poles(poles) => Some(ObserverKind::ReducedOrder(poles)),
        _ => None,
    }
}

/// K and the poles of a functional observer.
pub(super) fn functional(
    node: &Node,
    (name, size): (&str, Dimensions),
    root: &Node,
    reader: &mut Reader,
) -> Option<ObserverKind> {
    if reader.dt.is_some() {
        return reader.refuse(check::head(node), "this kind is for plants in continuous time", "expected another kind");
    }
    let table = ["log", "sweep"].into_iter().find(|table| root.get(table).is_some());
    if let Some(table) = table {
        let message =
            format!("this kind estimates functions of the state, and [{table}] compares estimates of the state");
        return reader.refuse(
            check::head(node),
            message,
            format!("expected no [{table}], or another kind such as reduced-order"),
        );
    }
    let fed = root.get("input").and_then(|input| input.get("feedback")?.get("observer")?.text());
    if fed == Some(name) {
        let message = "the feedback u = r - K xhat has the estimate of the whole state";
        return reader.refuse(check::head(node), message, "expected the feedback of another observer");
    }
    let why = format!("the plant has {}", counted(size.states, "state"));
    let k = reader.matrix(node.get("k")?, "k", (None, Some(size.states)), &why)?;
    let rows = format!("`k` has {}", counted(k.nrows(), "row"));
    match poles(node.get("poles")?, k.nrows(), &rows, reader)? {
        GainSpec::Poles(poles) => Some(ObserverKind::Functional { k, poles }),
        _ => None,
    }
}

pub(super) fn poles(node: &Node, n: usize, of_states: &str, reader: &mut Reader) -> Option<GainSpec> {
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
        if reader.dt.is_some() && pole.norm() >= 1.0 {
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

pub(super) fn this_gain(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<DMatrix<f64>> {
    let (n, p) = (size.states, size.outputs);
    let why = format!("the plant has {} and {}", counted(n, "state"), counted(p, "output"));
    reader.matrix(node, "gain", (Some(n), Some(p)), &why)
}

pub(super) fn theta(node: &Node, p: usize, reader: &mut Reader) -> Option<DMatrix<f64>> {
    match node.get("theta") {
        Some(theta) => reader.weight(theta, "theta", p, &format!("the plant has {}", counted(p, "output"))),
        None => Some(DMatrix::identity(p, p)),
    }
}

pub(super) fn correction(node: &Node, p: usize, reader: &mut Reader) -> Option<CubicGain> {
    alternatives(node, &["gamma", "radial", "s"], true, reader)?;
    if let Some(gamma) = node.get("gamma") {
        return Some(CubicGain::Gamma(gamma.number()?));
    }
    if let Some(w) = node.get("radial") {
        return Some(CubicGain::Radial(w.number()?));
    }
    general(node, p, reader)
}

/// As [`correction`], where `gamma` is the strength of a radial gain.
pub(super) fn sampled_correction(node: &Node, p: usize, reader: &mut Reader) -> Option<CubicGain> {
    alternatives(node, &["gamma", "weighted", "s"], true, reader)?;
    if let Some(w) = node.get("gamma") {
        return Some(CubicGain::Radial(w.number()?));
    }
    if let Some(gamma) = node.get("weighted") {
        return Some(CubicGain::Gamma(gamma.number()?));
    }
    general(node, p, reader)
}

/// `jitter` and `misses`.
pub(super) fn periods(node: &Node, period: f64, reader: &mut Reader) -> Option<Periods> {
    let misses = match node.get("misses") {
        Some(misses) => misses.count()?,
        None => 0,
    };
    if misses > MOST_MISSES {
        let span = node.get("misses")?.span.clone();
        return reader.refuse(span, format!("`misses` is {misses}"), format!("expected at most {MOST_MISSES}"));
    }
    let Some(jitter) = node.get("jitter") else {
        return Some(Periods { shortest: period, longest: period, misses });
    };
    let (shortest, longest) = bound(jitter)?;
    if !(shortest > 0.0 && shortest <= period && period <= longest && longest.is_finite()) {
        let message = format!("`jitter` is from {shortest} to {longest}, and `period` is {period}");
        return reader.refuse(jitter.span.clone(), message, "expected positive, finite bounds that contain the period");
    }
    Some(Periods { shortest, longest, misses })
}

fn general(node: &Node, p: usize, reader: &mut Reader) -> Option<CubicGain> {
    let of_outputs = format!("the plant has {}", counted(p, "output"));
    Some(CubicGain::General(reader.matrix(node.get("s")?, "s", (Some(p), Some(p)), &of_outputs)?))
}
