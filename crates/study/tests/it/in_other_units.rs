//! Every design of a linear plant in other units of states, inputs, outputs, disturbances and time: the verdict and the
//! gain, in its units, stay the same. The property is written once, in `tests/scaling` of the crate linalg.

#[path = "../../../linalg/tests/scaling/mod.rs"]
mod scaling;

use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;

use luenberger_study::design::design;
use nalgebra::{DMatrix, dmatrix};
use proptest::prelude::*;
use scaling::Axis::{Disturbance, Input, One, Output, State};
use scaling::{Answer, Unit, Units, difference, unit};

use crate::studies;

const A: Unit = unit((State, 1), (State, -1), -1);
const B: Unit = unit((State, 1), (Input, -1), -1);
const C: Unit = unit((Output, 1), (State, -1), 0);
const E: Unit = unit((State, 1), (Disturbance, -1), -1);
const D: Unit = unit((Output, 1), (Disturbance, -1), 0);
const H: Unit = unit((One, 1), (State, -1), 0);
const L: Unit = unit((State, 1), (Output, -1), -1);
/// Intensities.
const W: Unit = unit((State, 1), (State, 1), -1);
const V: Unit = unit((Output, 1), (Output, 1), 1);
/// Columns.
const X: Unit = unit((State, 1), (One, 0), 0);
const Y: Unit = unit((Output, 1), (One, 0), 0);

/// Programs find their objective to about this squared, and a gain at the optimum to its root.
const PROGRAM: f64 = 1e-4;
const COMPUTED: f64 = 1e-9;

/// A plant in its own units, whose numbers are about one.
#[derive(Debug, Clone)]
struct Plant {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    e: DMatrix<f64>,
    /// The period in discrete time.
    dt: Option<f64>,
}

impl Plant {
    /// In discrete time, with its input and its disturbance held over a short period, to first order.
    fn in_steps(self) -> Self {
        let dt = 0.125;
        let a = DMatrix::identity(self.a.nrows(), self.a.nrows()) + self.a * dt;
        Self { a, b: self.b * dt, e: self.e * dt, dt: Some(dt), ..self }
    }

    /// The units of its matrices: in discrete time the step is the unit of time.
    fn units(&self, units: &Units) -> Units {
        if self.dt.is_some() { units.clone().discrete() } else { units.clone() }
    }
}

fn plants() -> [Plant; 3] {
    [
        // A spring and a mass, a damper; position measured.
        Plant {
            a: dmatrix![0.0, 1.0; -2.0, -0.6],
            b: dmatrix![0.0; 1.0],
            c: dmatrix![1.0, 0.0],
            e: dmatrix![0.0; 1.0],
            dt: None,
        },
        // A motor with its current; angle measured.
        Plant {
            a: dmatrix![0.0, 1.0, 0.0; 0.0, -0.5, 1.5; 0.0, -0.75, -2.0],
            b: dmatrix![0.0; 0.0; 1.0],
            c: dmatrix![1.0, 0.0, 0.0],
            e: dmatrix![0.0; 1.0; 0.0],
            dt: None,
        },
        // Three tanks in a row, the levels of two of them measured.
        Plant {
            a: dmatrix![-1.0, 0.5, 0.0; 0.5, -1.25, 0.75; 0.0, 0.75, -1.5],
            b: dmatrix![1.0, 0.0; 0.0, 0.0; 0.0, 1.0],
            c: dmatrix![1.0, 0.0, 0.0; 0.0, 1.0, 0.0],
            e: dmatrix![0.0; 1.0; 0.0],
            dt: None,
        },
    ]
}

/// A setting of an observer: as text in the units asked for.
type Setting = fn(&Plant, &Units) -> String;

/// What is asked of a design: kind, settings, and the accuracy of its gain, if that is determined.
struct Case {
    kind: &'static str,
    settings: &'static [Setting],
    gain: Option<Accuracy>,
}

/// The accuracy of a gain.
#[derive(Clone, Copy)]
enum Accuracy {
    /// With poles; those of several outputs do not determine it, and one of good condition in the units given is taken.
    OneOutput(f64),
    Any(f64),
    /// A sum of variances of states is least, which have one unit therefore.
    OneUnit(f64),
}

const fn case(kind: &'static str, settings: &'static [Setting], gain: Option<Accuracy>) -> Case {
    Case { kind, settings, gain }
}

fn rows(m: &DMatrix<f64>) -> String {
    let rows: Vec<String> = m
        .row_iter()
        .map(|row| format!("[{}]", row.iter().map(|x| format!("{x:e}")).collect::<Vec<_>>().join(", ")))
        .collect();
    format!("[{}]", rows.join(", "))
}

fn list(m: &DMatrix<f64>) -> String {
    format!("[{}]", m.iter().map(|x| format!("{x:e}")).collect::<Vec<_>>().join(", "))
}

fn rates(plant: &Plant, count: usize, units: &Units, first: f64) -> String {
    let pole = |k: usize| {
        let rate = -first - 0.75 * k as f64;
        plant.dt.map_or_else(|| units.frequency(rate.into(), 1).re, |dt| (rate * dt).exp())
    };
    format!("poles = [{}]", (0..count).map(|k| format!("{:e}", pole(k))).collect::<Vec<_>>().join(", "))
}

fn poles(plant: &Plant, units: &Units) -> String {
    rates(plant, plant.a.nrows(), units, 2.0)
}

/// The zero of the tanks from their disturbance is -1.5.
fn poles_with_a_zero(plant: &Plant, units: &Units) -> String {
    rates(plant, plant.a.nrows(), units, 1.5)
}

fn poles_of_a_reduced_order(plant: &Plant, units: &Units) -> String {
    rates(plant, plant.a.nrows() - plant.c.nrows(), units, 2.0)
}

fn poles_with_a_disturbance(plant: &Plant, units: &Units) -> String {
    rates(plant, plant.a.nrows() + 1, units, 2.0)
}

fn bandwidth(_: &Plant, units: &Units) -> String {
    format!("bandwidth = {:e}", units.frequency(3.0.into(), 1).re)
}

fn decay_rate(_: &Plant, units: &Units) -> String {
    format!("decay_rate = {:e}", units.frequency(1.5.into(), 1).re)
}

fn program(_: &Plant, _: &Units) -> String {
    "lmi = true".to_owned()
}

/// A factor of P's inverse: any number.
fn cubic(_: &Plant, _: &Units) -> String {
    "gamma = 1".to_owned()
}

fn noise(plant: &Plant, units: &Units) -> String {
    let units = plant.units(units);
    // Variances of the measurements.
    format!(
        "noise = {}",
        list(&units.apply(&DMatrix::from_element(plant.c.nrows(), 1, 0.5), unit((Output, 2), (One, 0), 1), 1))
    )
}

fn intensities(plant: &Plant, units: &Units) -> String {
    let (n, p) = (plant.a.nrows(), plant.c.nrows());
    let units = plant.units(units);
    format!(
        "w = {}\nv = {}",
        rows(&units.apply(&(DMatrix::identity(n, n) * 0.5 + DMatrix::from_element(n, n, 0.25)), W, 1)),
        rows(&units.apply(&DMatrix::from_fn(p, p, |i, j| if i == j { 1.0 } else { 0.25 }), V, 1)),
    )
}

fn disturbance(plant: &Plant, units: &Units) -> String {
    format!("e = {}", rows(&plant.units(units).apply(&plant.e, E, 1)))
}

fn functional(plant: &Plant, units: &Units) -> String {
    let k = DMatrix::from_fn(1, plant.a.nrows(), |_, j| 1.0 + 0.5 * j as f64);
    format!("k = {}\npoles = [{:e}]", rows(&units.apply(&k, H, 1)), units.frequency((-2.0).into(), 1).re)
}

fn functional_of_least_order(plant: &Plant, units: &Units) -> String {
    let k = DMatrix::from_fn(1, plant.a.nrows(), |_, j| 1.0 + 0.5 * j as f64);
    format!("k = {}\norder = \"least\"\n{}", rows(&units.apply(&k, H, 1)), rates(plant, plant.a.nrows(), units, 2.0))
}

/// It enters the last output as well.
fn disturbance_of_outputs(plant: &Plant, units: &Units) -> String {
    let p = plant.c.nrows();
    let f = DMatrix::from_fn(p, 1, |i, _| if i + 1 == p { 0.5 } else { 0.0 });
    format!("{}\nf = {}", disturbance(plant, units), rows(&units.apply(&f, D, 1)))
}

/// The gain of a filter.
fn filter(plant: &Plant, units: &Units) -> String {
    format!("kalman = {{ {} }}", intensities(plant, units).replace('\n', ", "))
}

/// A disturbance of the states and noise of the outputs, beside each other.
fn both(plant: &Plant, units: &Units, white: bool) -> String {
    let (n, p) = (plant.a.nrows(), plant.c.nrows());
    let e = plant.e.clone().resize_horizontally(1 + p, 0.0);
    let d = DMatrix::from_fn(p, 1 + p, |i, j| if j == i + 1 { 0.5 } else { 0.0 });
    let h = DMatrix::from_fn(1, n, |_, j| if j == 0 { 1.0 } else { 0.5 });
    // White noise of unit intensity is no quantity: E has the root of time in its unit.
    let units = if white { Units { disturbance: vec![-units.time / 2; 3], ..units.clone() } } else { units.clone() };
    format!(
        "e = {}\nd = {}\nh = {}",
        rows(&units.apply(&e, E, 1)),
        rows(&units.apply(&d, D, 1)),
        rows(&units.apply(&h, H, 1))
    )
}

fn white_noise(plant: &Plant, units: &Units) -> String {
    both(plant, units, true)
}

/// Disturbances of one unit, which gamma has.
fn energy(plant: &Plant, units: &Units) -> String {
    both(plant, &Units { disturbance: vec![units.disturbance[0]; 3], ..units.clone() }, false)
}

fn widths(plant: &Plant, units: &Units) -> String {
    let (n, p) = (plant.a.nrows(), plant.c.nrows());
    format!(
        "initial_bounds = {}\nbounds = {{ noise = {} }}",
        list(&units.apply(&DMatrix::from_element(n, 1, 0.5), X, 1)),
        list(&units.apply(&DMatrix::from_element(p, 1, 0.25), Y, 1)),
    )
}

fn noise_bound(plant: &Plant, units: &Units) -> String {
    format!("bounds = {{ noise = {} }}", list(&units.apply(&DMatrix::from_element(plant.c.nrows(), 1, 0.25), Y, 1)))
}

const CASES: [Case; 17] = [
    case("luenberger", &[poles], Some(Accuracy::OneOutput(COMPUTED))),
    case("luenberger", &[poles, noise_bound], Some(Accuracy::OneOutput(COMPUTED))),
    case("luenberger", &[program], None),
    case("luenberger", &[decay_rate], None),
    case("luenberger", &[decay_rate, noise], Some(Accuracy::OneUnit(PROGRAM))),
    case("kalman", &[intensities], Some(Accuracy::Any(COMPUTED))),
    case("cubic", &[poles, cubic], Some(Accuracy::OneOutput(COMPUTED))),
    case("interval", &[poles, widths], Some(Accuracy::OneOutput(COMPUTED))),
    case("functional", &[functional], None),
    case("reduced-order", &[poles_of_a_reduced_order], None),
    case("proportional-integral", &[poles_with_a_disturbance, disturbance], None),
    case("extended-state", &[bandwidth, disturbance], None),
    case("unknown-input", &[poles_with_a_zero, disturbance], None),
    case("functional", &[functional_of_least_order], None),
    case("unknown-input", &[filter, disturbance_of_outputs], None),
    case("h2", &[white_noise], Some(Accuracy::Any(PROGRAM))),
    case("h-infinity", &[energy], None),
];

const IN_STEPS: [Case; 11] = [
    case("luenberger", &[poles], Some(Accuracy::OneOutput(COMPUTED))),
    case("luenberger", &[poles, noise_bound], Some(Accuracy::OneOutput(COMPUTED))),
    case("luenberger", &[program], None),
    case("luenberger", &[decay_rate], None),
    case("luenberger", &[decay_rate, noise], Some(Accuracy::OneUnit(PROGRAM))),
    case("kalman", &[intensities], Some(Accuracy::Any(COMPUTED))),
    case("proportional-integral", &[poles_with_a_disturbance, disturbance], None),
    case("extended-state", &[bandwidth, disturbance], None),
    case("reduced-order", &[poles_of_a_reduced_order], None),
    case("functional", &[functional_of_least_order], None),
    case("unknown-input", &[filter, disturbance_of_outputs], None),
];

/// The plants in continuous time and in discrete time, each with its cases.
fn all() -> Vec<(Plant, &'static [Case])> {
    let continuous = plants().map(|plant| (plant, &CASES[..]));
    continuous.into_iter().chain(plants().map(|plant| (plant.in_steps(), &IN_STEPS[..]))).collect()
}

/// The study of one observer in these units.
fn study(plant: &Plant, case: &Case, units: &Units) -> String {
    let own = plant.units(units);
    let mut text = format!(
        "[plant]\na = {}\nb = {}\nc = {}\n{}[[observer]]\nname = \"it\"\nkind = \"{}\"\n",
        rows(&own.apply(&plant.a, A, 1)),
        rows(&own.apply(&plant.b, B, 1)),
        rows(&own.apply(&plant.c, C, 1)),
        plant.dt.map_or_else(String::new, |dt| format!("dt = {:e}\n", units.duration(dt))),
        case.kind
    );
    for setting in case.settings {
        _ = writeln!(text, "{}", setting(plant, units));
    }
    text
}

fn answer(plant: &Plant, case: &Case, units: &Units) -> Answer {
    let study = studies::study(&study(plant, case, units));
    match design(&study, &study.observers[0], &AtomicBool::new(false)) {
        Ok(designed) => {
            let answer = Answer::verdict(designed.report.verdict.word());
            let gain = designed.report.matrices.iter().find(|matrix| matrix.name == "L");
            let accuracy = match case.gain {
                Some(Accuracy::OneOutput(_)) if plant.c.nrows() > 1 => None,
                Some(Accuracy::OneOutput(x) | Accuracy::Any(x) | Accuracy::OneUnit(x)) => Some(x),
                None => None,
            };
            match (accuracy, gain) {
                (Some(accuracy), Some(gain)) => {
                    let (n, p) = (gain.rows.len(), gain.rows[0].len());
                    answer.value(&DMatrix::from_fn(n, p, |i, j| gain.rows[i][j]), L, accuracy)
                }
                (Some(_), None) => Answer::verdict("no gain"),
                _ => answer,
            }
        }
        Err(none) if none.is_interrupted() => Answer::verdict("interrupted"),
        // The numbers of a refusal have units.
        Err(failure) => {
            let words =
                failure.hypothesis.split_whitespace().filter(|word| !word.contains(|c: char| c.is_ascii_digit()));
            Answer::verdict(words.collect::<Vec<_>>().join(" "))
        }
    }
}

/// As [`Units::drawn`], with an even power for time, whose root units of white noise have.
fn units() -> impl Strategy<Value = Units> {
    prop::collection::vec(-1.0..1.0f64, 30).prop_map(|numbers| {
        let drawn = Units::drawn(&numbers);
        Units { time: drawn.time / 2 * 2, ..drawn }
    })
}

/// No unit at all.
fn own() -> Units {
    Units::drawn(&[0.0])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn designs_do_not_depend_on_units(units in units()) {
        let mut wrong = String::new();
        for (k, (plant, cases)) in all().iter().enumerate() {
            for case in *cases {
                let units = match case.gain {
                    // The real T of the theorem is known up to intervals, which may leave it undecided in units further
                    // apart.
                    _ if case.kind == "unknown-input" => {
                        Units { state: units.state.iter().map(|power| power / 4).collect(), ..units.clone() }
                    }
                    Some(Accuracy::OneUnit(_)) => Units { state: vec![units.state[0]; 6], ..units.clone() },
                    _ => units.clone(),
                };
                let (first, other) = (answer(plant, case, &own()), answer(plant, case, &units));
                if let Some(found) = difference(&first, &other, &plant.units(&units)) {
                    _ = writeln!(wrong, "plant {k}, {}: {found}\n{}", case.kind, study(plant, case, &units));
                }
            }
        }
        prop_assert!(wrong.is_empty(), "{wrong}");
    }
}

/// The cases are no refusals.
#[test]
fn designs_in_their_own_units_are_proved() {
    for (plant, cases) in &all() {
        for case in *cases {
            let verdict = match (case.kind, plant.a.nrows()) {
                // An unknown input must enter an output's derivative.
                ("unknown-input", _)
                    if (&plant.c * &plant.e).amax() == 0.0 && !study(plant, case, &own()).contains("f = ") =>
                {
                    continue;
                }
                // One number of three states takes an observer with two.
                ("functional", 3) if plant.c.nrows() == 1 && !study(plant, case, &own()).contains("least") => continue,
                ("functional", _) => "none",
                _ => "proved",
            };
            assert_eq!(answer(plant, case, &own()).verdict, verdict, "{}", study(plant, case, &own()));
        }
    }
}
