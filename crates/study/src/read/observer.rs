//! The tables [[observer]].

use luenberger_design::numerical_kkl::MOST_NODES;
use luenberger_design::{CubicGain, LyapunovWeight, Periods, Region, Sector, SystemNorm, bandwidth_poles};
use luenberger_observers::{Horizon, SigmaPoints};
use luenberger_plants::Dimensions;
use luenberger_proof::certificate::MOST_MISSES;
use luenberger_proof::wording::counted;
use nalgebra::{Complex, DMatrix};

use super::tree::Node;
use super::{Reader, check, disturbance, interval, maps, norm_filter, optimal};
use crate::design::{LONGEST_WINDOW, PrintedMean};
use crate::diagnostic::Source;
use crate::model::PlantModel;
use crate::study::{
    GainLimits, GainSpec, KklSpec, LinearSpec, MovingHorizonSpec, ObserverKind, ObserverSpec, RateSpec,
    SlidingModeSpec, UnscentedSpec,
};

/// The observers; none if one has mistakes.
pub(super) fn observers(
    root: &Node,
    plant: &PlantModel,
    start: &[f64],
    source: &Source,
    reader: &mut Reader,
) -> Option<Vec<ObserverSpec>> {
    let Some(list) = root.get("observer") else { return Some(Vec::new()) };
    let read: Vec<Option<ObserverSpec>> =
        list.list()?.iter().map(|node| observer(node, plant, start, (root, source), reader)).collect();
    let observers: Vec<ObserverSpec> = read.into_iter().collect::<Option<_>>()?;
    names(&observers, list, root, reader).then_some(observers)
}

/// Checks that each observer has a name of its own, which can also name its files.
fn names(observers: &[ObserverSpec], list: &Node, root: &Node, reader: &mut Reader) -> bool {
    // The run on a log is written to `log-NAME`, beside that of the simulation.
    let prefixes: &[&str] = match (root.get("simulation"), root.get("log")) {
        (Some(_), Some(_)) => &["", "log-"],
        _ => &[""],
    };
    let before = reader.mistakes.len();
    let mut taken: Vec<(String, &str)> = Vec::new();
    for (observer, node) in observers.iter().zip(list.list().unwrap_or(&[])) {
        let name = observer.name.as_str();
        let span = node.get("name").map_or_else(|| check::head(node), |name| name.span.clone());
        let files: Vec<String> =
            prefixes.iter().map(|prefix| format!("{prefix}{}", file_name(name)).to_ascii_lowercase()).collect();
        let same = taken.iter().find(|(file, _)| files.contains(file)).map(|(_, other)| *other);
        match same {
            Some(other) if other == name => {
                let message = format!("two observers are named {name:?}");
                reader.wrong(span, message, "expected different names");
            }
            Some(other) => {
                let message = format!("{other:?} and {name:?} give the same file names");
                let expected = "expected names that differ in more than case and punctuation";
                reader.wrong(span, message, expected);
            }
            None if file_name(name).is_empty() => {
                reader.wrong(
                    span,
                    format!("{name:?} cannot be part of a file name"),
                    "expected a letter or a digit (ASCII)",
                );
            }
            None if is_reserved(&file_name(name)) => {
                let message = format!("{name:?} cannot be part of a file name: Windows reserves it for a device");
                reader.wrong(span, message, "expected another name");
            }
            None => {}
        }
        taken.extend(files.into_iter().map(|file| (file, name)));
    }
    reader.mistakes.len() == before
}

/// Whether Windows reserves the name, with any extension.
fn is_reserved(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let numbered =
        |device: &str| name.strip_prefix(device).is_some_and(|rest| matches!(rest.as_bytes(), [b'1'..=b'9']));
    ["con", "prn", "aux", "nul"].contains(&name.as_str()) || ["com", "lpt"].into_iter().any(numbered)
}

/// The name as part of a file name: letters, digits, `-` and `_`; all other characters become `-`.
pub(crate) fn file_name(name: &str) -> String {
    let plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).collect();
    plain.split('-').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
}

fn observer(
    node: &Node,
    plant: &PlantModel,
    start: &[f64],
    (root, source): (&Node, &Source),
    reader: &mut Reader,
) -> Option<ObserverSpec> {
    let (size, kind_name) = (plant.model.size(), node.get("kind")?.text()?);
    let name = node.get("name").and_then(Node::text).unwrap_or(kind_name).to_owned();
    let initial = match node.get("initial") {
        Some(initial) => reader.numbers(initial, "initial", size.states, "state"),
        None => Some(start.to_vec()),
    };
    let kind = match kind_name {
        "kkl" => maps::kkl(node, plant, reader),
        "immersion-invariance" => maps::immersion(node, plant, reader),
        "pebo" => maps::peb(node, plant, reader).map(|peb| ObserverKind::Pebo(Box::new(peb))),
        "optimal-cubic" => optimal::problem(node, size, root, reader),
        "kkl-peb" => maps::peb(node, plant, reader).map(|peb| ObserverKind::KklPeb(Box::new(peb))),
        "high-gain" => high_gain(node, plant, reader),
        "functional" => functional(node, (&name, size), root, reader),
        _ => kind(node, kind_name, size, reader),
    };
    let limits = limits(node, size, reader);
    let bounds = disturbance::bounds(node, size, root, reader);
    smooth(node, root, reader)?;
    let place = source.place(check::head(node).start);
    Some(ObserverSpec { name, initial: initial?, kind: kind?, limits: limits?, bounds: bounds.ok()?, place })
}

/// `max_gain` and `noise`, which apply to gains that an inequality chooses.
fn limits(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<GainLimits> {
    let given = ["max_gain", "noise"].iter().find_map(|key| node.entry(key));
    let fixed = ["bandwidth", "poles", "kalman", "gain"].iter().find_map(|key| node.entry(key));
    if let (Some(limit), Some(fixed)) = (given, fixed) {
        let message = format!("`{}` conflicts with `{}`, which determines the gain", limit.key, fixed.key);
        reader.wrong(limit.span.clone(), message, "expected `decay_rate`, `lmi` or `fastest` with it");
        return None;
    }
    let noise = match node.get("noise") {
        Some(v) => Some(reader.weight(
            v,
            "noise",
            size.outputs,
            &format!("the plant has {}", counted(size.outputs, "output")),
        )?),
        None => None,
    };
    Some(GainLimits { max_gain: node.get("max_gain").and_then(Node::number), noise })
}

fn kind(node: &Node, name: &str, size: Dimensions, reader: &mut Reader) -> Option<ObserverKind> {
    let (n, p) = (size.states, size.outputs);
    let number = |key: &str| node.get(key).and_then(Node::number);
    let positive = |key: &str, otherwise: f64| match node.get(key) {
        Some(value) => value.number(),
        None => Some(otherwise),
    };
    let of_states = format!("the plant has {}", counted(n, "state"));
    Some(match name {
        "luenberger" => ObserverKind::Luenberger(linear(node, size, reader)?),
        "kalman" => ObserverKind::Kalman(linear(node, size, reader)?),
        "cubic" => {
            let linear = linear(node, size, reader);
            let theta = theta(node, p, reader);
            let correction = correction(node, p, reader);
            ObserverKind::Cubic { linear: linear?, theta: theta?, correction: correction? }
        }
        "sampled-cubic" => {
            let linear = linear(node, size, reader);
            let theta = theta(node, p, reader);
            let correction = sampled_correction(node, p, reader);
            let period = number("period")?;
            let varying = match node.get("jitter").or_else(|| node.get("misses")) {
                Some(_) => Some(periods(node, period, reader)?).filter(|periods| !periods.is_constant()),
                None => None,
            };
            ObserverKind::SampledCubic { linear: linear?, theta: theta?, correction: correction?, period, varying }
        }
        "proportional-integral" | "extended-state" => disturbance::proportional_integral(node, size, reader)?,
        "reduced-order" => reduced_order(node, size, reader)?,
        "h-infinity" => norm_filter::norm_filter(SystemNorm::HInfinity, node, size, reader)?,
        "h2" => norm_filter::norm_filter(SystemNorm::H2, node, size, reader)?,
        "unknown-input" => disturbance::unknown_input(node, size, reader)?,
        "interval" => interval::interval(node, size, reader)?,
        "sliding-mode" => sliding_mode(node, size, reader)?,
        "lpv" => {
            let region = region(node, size, reader);
            alternatives(node, &["decay_rate", "fastest", "gain"], false, reader)?;
            let rate = match (node.get("fastest"), node.get("gain")) {
                (Some(ceiling), _) => RateSpec::Fastest(ceiling.number()?),
                (_, Some(gain)) => RateSpec::Gain(this_gain(gain, size, reader)?, 0.0),
                _ => RateSpec::Rate(positive("decay_rate", 0.0)?),
            };
            ObserverKind::Lpv { region: region?, rate }
        }
        "lipschitz" => {
            let region = region(node, size, reader);
            let gain = match node.get("gain") {
                Some(gain) => Some(this_gain(gain, size, reader)?),
                None => None,
            };
            let split = match (node.entry("a"), node.entry("sectors")) {
                (None, None) => None,
                (Some(a), Some(sectors)) => {
                    let a = reader.matrix(&a.node, "a", (Some(n), Some(n)), &of_states);
                    let sectors: Vec<Option<Sector>> =
                        sectors.node.list()?.iter().map(|node| sector(node, n, reader)).collect();
                    Some((a?, sectors.into_iter().collect::<Option<Vec<_>>>()?))
                }
                (Some(one), None) | (None, Some(one)) => {
                    let message = format!("`{}` alone: `a` and `sectors` define the plant together", one.key);
                    reader.wrong(one.span.clone(), message, "expected both, or neither");
                    return None;
                }
            };
            ObserverKind::Lipschitz { split, region: region?, rate: positive("decay_rate", 0.0)?, gain }
        }
        "mean-value" => {
            let region = region(node, size, reader);
            let internal_error = match node.get("internal_error") {
                Some(error) => reader.numbers(error, "internal_error", n, "state"),
                None => Some(vec![0.0; n]),
            };
            let printed = match node.get("as_printed") {
                Some(printed) => Some(printed_mean(node, printed, reader)?),
                None => None,
            };
            ObserverKind::MeanValue {
                region: region?,
                rate: positive("decay_rate", 0.0)?,
                eta: positive("eta", 1.0)?,
                internal_error: internal_error?,
                printed,
            }
        }
        "extended-kalman" => {
            let Filter { w, v, p0, period, substeps, gate, smooth } = filter(node, size, reader)?;
            ObserverKind::ExtendedKalman { w, v, p0, period, substeps, gate, smooth }
        }
        "ukf" => {
            let filter = filter(node, size, reader);
            let standard = SigmaPoints::default();
            let number = |key: &str, otherwise: f64| node.get(key).map_or(Some(otherwise), Node::number);
            let sigma = SigmaPoints {
                alpha: number("alpha", standard.alpha)?,
                beta: number("beta", standard.beta)?,
                kappa: number("kappa", standard.kappa)?,
            };
            if sigma.weights::<f64>(n).is_err() {
                let key = node.entry("kappa").or_else(|| node.entry("alpha"))?;
                let message = format!(
                    "`{}` leaves no sigma points: alpha = {}, kappa = {}, and the plant has {}",
                    key.key,
                    sigma.alpha,
                    sigma.kappa,
                    counted(n, "state")
                );
                reader.wrong(
                    key.span.clone(),
                    message,
                    format!("expected kappa > -{n} and an alpha of about 1e-3 to 1"),
                );
                return None;
            }
            let Filter { w, v, p0, period, substeps, gate, smooth } = filter?;
            ObserverKind::Unscented(Box::new(UnscentedSpec { w, v, p0, sigma, period, substeps, gate, smooth }))
        }
        "mhe" => moving_horizon(node, size, reader)?,
        "kkl-numerical" => {
            let domain = finite_bounds(node.get("domain")?, "domain", (n, "state"), reader)?;
            let inputs = match node.get("inputs") {
                Some(inputs) => finite_bounds(inputs, "inputs", (size.inputs, "input"), reader)?,
                None => Vec::new(),
            };
            if inputs.is_empty()
                && let Some(nodes) = node.entry("nodes")
            {
                let message = "`nodes` without `inputs`";
                reader.wrong(nodes.span.clone(), message, "expected `inputs`, the range of each input");
                return None;
            }
            let count = |key: &str, otherwise: usize| node.get(key).map_or(Some(otherwise), Node::count);
            let nodes = count("nodes", 5)?;
            if nodes > MOST_NODES {
                let message = format!("`nodes` is {nodes}");
                reader.wrong(node.get("nodes")?.span.clone(), message, format!("expected at most {MOST_NODES}"));
                return None;
            }
            ObserverKind::KklNumerical(KklSpec {
                inputs,
                nodes,
                domain,
                cutoff: number("cutoff"),
                escape: number("escape"),
                points: match node.get("points") {
                    Some(points) => Some(points.count()?),
                    None => None,
                },
                leaves: count("leaves", 32)?,
                degree: count("degree", 4)?,
                samples: count("samples", 8000)?,
                embedded: node.get("form").and_then(Node::text) == Some("embedded"),
            })
        }
        // The description of the kinds has no other.
        _ => return None,
    })
}

/// The keys that the filters have in common.
struct Filter {
    w: DMatrix<f64>,
    v: DMatrix<f64>,
    p0: DMatrix<f64>,
    period: f64,
    substeps: usize,
    gate: Option<f64>,
    smooth: bool,
}

fn filter(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<Filter> {
    let (n, p) = (size.states, size.outputs);
    let (of_states, of_outputs) =
        (format!("the plant has {}", counted(n, "state")), format!("the plant has {}", counted(p, "output")));
    let w = reader.weight(node.get("w")?, "w", n, &of_states);
    let v = reader.weight(node.get("v")?, "v", p, &of_outputs);
    let p0 = match node.get("p0") {
        Some(p0) => reader.weight(p0, "p0", n, &of_states),
        None => Some(DMatrix::identity(n, n)),
    };
    let substeps = node.get("substeps").map_or(Some(4), Node::count)?;
    let gate = match node.get("gate") {
        Some(gate) => Some(gate.number()?),
        None => None,
    };
    let smooth = node.get("smooth").and_then(Node::truth).unwrap_or(false);
    let period = node.get("period")?.number()?;
    Some(Filter { w: w?, v: v?, p0: p0?, period, substeps, gate, smooth })
}

fn moving_horizon(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<ObserverKind> {
    let filter = filter(node, size, reader);
    let count = |key: &str, otherwise: usize| node.get(key).map_or(Some(otherwise), Node::count);
    let horizon = Horizon { window: count("window", 10)?, iterations: count("iterations", 2)? };
    if let Some(entry) = node.entry("window").filter(|_| horizon.window > LONGEST_WINDOW) {
        let message = format!("`window` is {}", horizon.window);
        reader.wrong(entry.node.span.clone(), message, format!("expected at most {LONGEST_WINDOW} samples"));
        return None;
    }
    let bounds = match node.entry("state_bounds") {
        Some(entry) => {
            let bounds = bounds(&entry.node, "state_bounds", size.states, "state", reader)?;
            if let Some(k) = bounds.iter().position(|(low, high)| low >= high) {
                let message = format!("pair {} of `state_bounds` is from {} to {}", k + 1, bounds[k].0, bounds[k].1);
                reader.wrong(entry.node.span.clone(), message, "expected the lower bound below the upper one");
                return None;
            }
            Some(bounds)
        }
        None => None,
    };
    let Filter { w, v, p0, period, substeps, .. } = filter?;
    Some(ObserverKind::MovingHorizon(Box::new(MovingHorizonSpec { w, v, p0, period, substeps, horizon, bounds })))
}

/// Smoothed estimates are of logs.
fn smooth(node: &Node, root: &Node, reader: &mut Reader) -> Option<()> {
    let Some(entry) = node.entry("smooth").filter(|entry| entry.node.truth() == Some(true)) else { return Some(()) };
    if root.get("log").is_some() {
        return Some(());
    }
    let message = "`smooth` is for estimates on a log, and the study has none";
    reader.wrong(entry.span.clone(), message, "expected a table [log], or no `smooth`");
    None
}

/// The mean of the Jacobian of the observer as printed, which has no gain to be designed.
fn printed_mean(node: &Node, printed: &Node, reader: &mut Reader) -> Option<PrintedMean> {
    if let Some(given) = ["decay_rate", "region", "max_gain", "noise"].iter().find_map(|key| node.entry(key)) {
        let message = format!("`{}` has no effect: the observer as printed has no gain to be designed", given.key);
        reader.wrong(given.span.clone(), message, "expected it without `as_printed`");
        return None;
    }
    Some(match printed.text()? {
        "least-squares" => PrintedMean::LeastSquares,
        "root" => PrintedMean::Root,
        _ => PrintedMean::Integral,
    })
}

/// At most one of these keys, or exactly one; an error names those that are present.
pub(super) fn alternatives(node: &Node, keys: &[&str], needed: bool, reader: &mut Reader) -> Option<()> {
    let there: Vec<_> = node.entries().iter().filter(|entry| keys.contains(&entry.key.as_str())).collect();
    match &there[..] {
        [first, second, ..] => {
            let message = format!("`{}` conflicts with `{}`", second.key, first.key);
            reader.wrong(second.span.clone(), message, format!("expected one of {}", keys.join(", ")));
            None
        }
        [] if needed => {
            let message = "the observer has no gain specification";
            reader.absent(check::head(node), message, format!("expected one of {}", keys.join(", ")));
            None
        }
        _ => Some(()),
    }
}

fn linear(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<LinearSpec> {
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
            reader.wrong(
                entry.node.span.clone(),
                "`lmi` is false",
                "expected true, or another specification of the gain",
            );
            return None;
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
        reader.wrong(given.node.span.clone(), message, "expected `poles`, `kalman` or `gain` with it");
        return None;
    }
    let is_filter = node.get("form").and_then(Node::text) == Some("filter");
    Some(LinearSpec { gain, weight, is_filter })
}

/// The poles of a reduced-order observer.
fn reduced_order(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<ObserverKind> {
    let (n, p) = (size.states, size.outputs);
    if reader.dt.is_some() {
        reader.wrong(check::head(node), "this kind is for plants in continuous time", "expected another kind");
        return None;
    }
    if p >= n {
        let message =
            format!("the plant has {} and {}: no state is left to estimate", counted(n, "state"), counted(p, "output"));
        reader.wrong(check::head(node), message, "expected a plant with fewer outputs than states");
        return None;
    }
    let left = format!("of {} the outputs leave {}", counted(n, "state"), n - p);
    match poles(node.get("poles")?, n - p, &left, reader)? {
        GainSpec::Poles(poles) => Some(ObserverKind::ReducedOrder(poles)),
        _ => None,
    }
}

/// K and the poles of a functional observer.
fn functional(node: &Node, (name, size): (&str, Dimensions), root: &Node, reader: &mut Reader) -> Option<ObserverKind> {
    if reader.dt.is_some() {
        reader.wrong(check::head(node), "this kind is for plants in continuous time", "expected another kind");
        return None;
    }
    let table = ["log", "sweep"].into_iter().find(|table| root.get(table).is_some());
    if let Some(table) = table {
        let message =
            format!("this kind estimates functions of the state, and [{table}] compares estimates of the state");
        reader.wrong(
            check::head(node),
            message,
            format!("expected no [{table}], or another kind such as reduced-order"),
        );
        return None;
    }
    let fed = root.get("input").and_then(|input| input.get("feedback")?.get("observer")?.text());
    if fed == Some(name) {
        let message = "the feedback u = r - K xhat has the estimate of the whole state";
        reader.wrong(check::head(node), message, "expected the feedback of another observer");
        return None;
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
        reader.wrong(node.span.clone(), message, format!("expected {}", counted(n, "pole")));
        return None;
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

fn correction(node: &Node, p: usize, reader: &mut Reader) -> Option<CubicGain> {
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
fn sampled_correction(node: &Node, p: usize, reader: &mut Reader) -> Option<CubicGain> {
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
fn periods(node: &Node, period: f64, reader: &mut Reader) -> Option<Periods> {
    let misses = match node.get("misses") {
        Some(misses) => misses.count()?,
        None => 0,
    };
    if misses > MOST_MISSES {
        let span = node.get("misses")?.span.clone();
        reader.wrong(span, format!("`misses` is {misses}"), format!("expected at most {MOST_MISSES}"));
        return None;
    }
    let Some(jitter) = node.get("jitter") else {
        return Some(Periods { shortest: period, longest: period, misses });
    };
    let (shortest, longest) = bound(jitter)?;
    if !(shortest > 0.0 && shortest <= period && period <= longest && longest.is_finite()) {
        let message = format!("`jitter` is from {shortest} to {longest}, and `period` is {period}");
        reader.wrong(jitter.span.clone(), message, "expected positive, finite bounds that contain the period");
        return None;
    }
    Some(Periods { shortest, longest, misses })
}

fn general(node: &Node, p: usize, reader: &mut Reader) -> Option<CubicGain> {
    let of_outputs = format!("the plant has {}", counted(p, "output"));
    Some(CubicGain::General(reader.matrix(node.get("s")?, "s", (Some(p), Some(p)), &of_outputs)?))
}

pub(super) fn region(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<Region> {
    let Some(table) = node.get("region") else { return Some(Region::everywhere(size.states)) };
    let mut region = match table.get("states") {
        Some(states) => Region::new(&bounds(states, "states", size.states, "state", reader)?),
        None => Region::everywhere(size.states),
    };
    if let Some(inputs) = table.get("inputs") {
        region = region.inputs(&bounds(inputs, "inputs", size.inputs, "input", reader)?);
    }
    if let Some(time) = table.get("time") {
        let (from, to) = bound(time)?;
        region = region.time(from, to);
    }
    Some(region)
}

pub(super) fn bound(node: &Node) -> Option<(f64, f64)> {
    match node.list()? {
        [lower, upper] => Some((lower.number()?, upper.number()?)),
        _ => None,
    }
}

fn bounds(node: &Node, name: &str, length: usize, of: &str, reader: &mut Reader) -> Option<Vec<(f64, f64)>> {
    pairs(node, name, (length, of, "the plant"), reader)
}

/// The same with finite ends, the lower one less.
fn finite_bounds(node: &Node, name: &str, (length, of): (usize, &str), reader: &mut Reader) -> Option<Vec<(f64, f64)>> {
    let pairs = bounds(node, name, length, of, reader)?;
    if let Some(k) = pairs.iter().position(|(low, high)| !(low.is_finite() && high.is_finite() && low < high)) {
        let message = format!("pair {} of `{name}` is from {} to {}", k + 1, pairs[k].0, pairs[k].1);
        reader.wrong(node.span.clone(), message, "expected finite ends, the lower one less");
        return None;
    }
    Some(pairs)
}

/// As many pairs as `whose` has of `of`.
pub(super) fn pairs(
    node: &Node,
    name: &str,
    (length, of, whose): (usize, &str, &str),
    reader: &mut Reader,
) -> Option<Vec<(f64, f64)>> {
    let bounds: Vec<(f64, f64)> = node.list()?.iter().map(bound).collect::<Option<_>>()?;
    if bounds.len() != length {
        let message =
            format!("`{name}` has {}, and {whose} has {}", counted(bounds.len(), "pair"), counted(length, of));
        reader.wrong(node.span.clone(), message, format!("expected {}", counted(length, "pair")));
        return None;
    }
    Some(bounds)
}

fn sector(node: &Node, n: usize, reader: &mut Reader) -> Option<Sector> {
    let why = format!("the plant has {}", counted(n, "state"));
    let g = reader.matrix(node.get("g")?, "g", (Some(n), None), &why);
    let h = reader.matrix(node.get("h")?, "h", (None, Some(n)), &why);
    let (low, high) = (node.get("low")?.number()?, node.get("high")?.number()?);
    if low > high {
        reader.absent(check::head(node), format!("the sector goes from {low} to {high}"), "expected low <= high");
        return None;
    }
    Some(Sector::slope(g?, h?, low, high))
}

fn sliding_mode(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<ObserverKind> {
    let gains = match node.get("k") {
        Some(gains) => Some(reader.numbers(gains, "k", size.states, "state")?),
        None => None,
    };
    let spec = SlidingModeSpec {
        bound: node.get("bound")?.number()?,
        gains,
        period: node.get("period")?.number()?,
        explicit: node.get("discretisation").and_then(Node::text) == Some("explicit"),
    };
    if reader.dt.is_some() {
        reader.wrong(check::head(node), "this kind is for plants in continuous time", "expected another kind");
        return None;
    }
    Some(ObserverKind::SlidingMode(spec))
}

fn high_gain(node: &Node, plant: &PlantModel, reader: &mut Reader) -> Option<ObserverKind> {
    let size = plant.model.size();
    let p = size.outputs;
    let given = node.get("drift").map(|drift| drift.list().map_or(0, <[Node]>::len));
    if given.is_none()
        && let Some(entry) = ["shape", "estimate", "start"].iter().find_map(|key| node.entry(key))
    {
        let message = format!("`{}` is given, and `drift` is not", entry.key);
        reader.wrong(entry.span.clone(), message, "expected `drift`, the right-hand side without corrections");
        return None;
    }
    let (n, whose) = match given {
        Some(order) => (order, format!("`drift` has {}", counted(order, "row"))),
        None => (size.states, format!("the plant has {}", counted(size.states, "state"))),
    };
    let chains = match node.entry("chains") {
        Some(entry) => {
            let lengths = reader.numbers(&entry.node, "chains", p, "output")?;
            if lengths.iter().any(|length| length.fract() != 0.0) || lengths.iter().sum::<f64>() != n as f64 {
                let message = format!("`chains` is {}, and {whose}", listed(&lengths));
                reader.wrong(entry.node.span.clone(), message, format!("expected whole numbers that add to {n}"));
                return None;
            }
            lengths.into_iter().map(|length| length as usize).collect()
        }
        None if p == 1 => vec![n],
        None => {
            let message =
                format!("the plant has {}, and `chains` does not assign the states to them", counted(p, "output"));
            reader.absent(check::head(node), message, format!("expected `chains`, {p} lengths that add to {n}"));
            return None;
        }
    };
    let alpha = match node.get("alpha") {
        Some(alpha) if given.is_some() => {
            let alpha_i = alpha.numbers()?;
            if alpha_i.len() != n {
                let message = format!("`alpha` has length {}, and {whose}", alpha_i.len());
                reader.wrong(alpha.span.clone(), message, format!("expected length {n}"));
                return None;
            }
            alpha_i
        }
        Some(alpha) => reader.numbers(alpha, "alpha", n, "state")?,
        None => chains.iter().flat_map(|length| binomials(*length)).collect(),
    };
    let maps = match given {
        Some(_) => Some(Box::new(maps::high_gain(node, plant, &chains, reader)?)),
        None => None,
    };
    Some(ObserverKind::HighGain { r: node.get("r")?.number()?, chains, alpha, maps })
}

/// `[1, 2.5]`.
fn listed(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(", "))
}

/// The coefficients of `(s + 1)^length` after the first.
fn binomials(length: usize) -> Vec<f64> {
    let next = |last: &f64, k: usize| last * (length - k) as f64 / (k + 1) as f64;
    let mut row = vec![1.0];
    for k in 0..length {
        row.push(next(&row[k], k));
    }
    row.split_off(1)
}
