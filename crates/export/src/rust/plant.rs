//! A nonlinear plant as Rust, and its observers.

use std::fmt::Write;

use luenberger_expression::{Dialect, Language, Routine, Routines};
use luenberger_observers::{Horizon, MatrixName, SigmaPoints};
use nalgebra::DVector;

use super::of;
use crate::exportable_observer::tables;
use crate::extension::ExtensionMaps;
use crate::moving_horizon::{MovingHorizon, bounds};
use crate::scalar::Scalar;
use crate::{Export, number};

/// How the graphs of an export are written as Rust.
pub(super) fn dialect(scalar: Scalar) -> Dialect<'static> {
    let literal = |x: f64, single: bool| number::rust(x, if single { Scalar::Binary32 } else { Scalar::Binary64 });
    Dialect { language: Language::Rust, single: scalar == Scalar::Binary32, prefix: "", of_target: false, literal }
}

/// The body of `observer()` for the observer with a constant gain.
pub(super) fn sampled_nonlinear(text: &mut String, export: &Export) {
    let gain = of(export, MatrixName::L).unwrap_or_default();
    let substeps = export.observer.substeps().unwrap_or(1);
    _ = writeln!(text, "    SampledNonlinearObserver::new(Model, {gain}, {}, {substeps})", period(export));
}

/// The body of `observer()` for the observer in discrete time.
pub(super) fn discrete(text: &mut String, export: &Export) {
    let gain = of(export, MatrixName::L).unwrap_or_default();
    _ = writeln!(text, "    DiscreteNonlinearObserver::new(Model, {gain}, {})", period(export));
}

/// The body of `observer()` for the extended Kalman filter.
pub(super) fn kalman(text: &mut String, export: &Export, iterations: usize) {
    let new = match export.observer.substeps() {
        Some(substeps) => format!("ExtendedKalmanFilter::new(Model, noises, {}, {substeps})", period(export)),
        None => format!("ExtendedKalmanFilter::discrete(Model, noises, {})", period(export)),
    };
    let iterated = if iterations > 1 { format!("?.with_iterations({iterations})") } else { String::new() };
    let gate = gate(export);
    _ = writeln!(
        text,
        "{}    let noises = NoiseModel {{ w, v, p0 }};
    {new}{iterated}{gate}{}{}",
        noises(export, [MatrixName::W, MatrixName::V, MatrixName::P0]),
        angles(export),
        unit_vectors(export)
    );
}

/// The body of `observer()` for the unscented Kalman filter.
pub(super) fn unscented(text: &mut String, export: &Export, sigma: SigmaPoints) {
    let SigmaPoints { alpha, beta, kappa } = sigma;
    let prediction = match export.observer.substeps() {
        Some(substeps) => format!("Prediction::RungeKutta({substeps})"),
        None => "Prediction::Discrete".to_owned(),
    };
    let gate = gate(export);
    _ = writeln!(
        text,
        "    // The lower triangular factors of W, V and P(0).
{}    let factors = NoiseModel {{ w, v, p0 }};
    let sigma = SigmaPoints {{ alpha: {alpha:?}, beta: {beta:?}, kappa: {kappa:?} }};
    UnscentedKalmanFilter::from_factors(Model, factors, sigma, {}, {prediction}){gate}{}",
        noises(export, [MatrixName::RootW, MatrixName::RootV, MatrixName::RootP0]),
        period(export),
        angles(export)
    );
}

/// The body of `observer()` for the moving-horizon estimator.
pub(super) fn moving_horizon(text: &mut String, export: &Export, estimator: &MovingHorizon<f64>) {
    let Horizon { window, iterations } = estimator.horizon();
    let new = match export.observer.substeps() {
        Some(substeps) => format!("new(Model, noises, horizon, {}, {substeps})", period(export)),
        None => format!("discrete(Model, noises, horizon, {})", period(export)),
    };
    let limits = |is_lower: bool| {
        let found = bounds(estimator);
        let one = |axis| {
            let bound = found.iter().find(|bound| bound.axis == axis && bound.is_lower == is_lower);
            match bound {
                Some(bound) => number::rust(export.scalar.round(bound.value), export.scalar),
                None => format!("{}::{}INFINITY", export.scalar.name(), if is_lower { "NEG_" } else { "" }),
            }
        };
        (0..export.observer.dimensions().estimate).map(one).collect::<Vec<_>>().join(", ")
    };
    let bounded = if bounds(estimator).is_empty() {
        String::new()
    } else {
        format!("?\n        .with_bounds(SVector::from([{}]), SVector::from([{}]))", limits(true), limits(false))
    };
    _ = writeln!(
        text,
        "{}    let noises = NoiseModel {{ w, v, p0 }};
    let horizon = Horizon {{ window: {window}, iterations: {iterations} }};
    MovingHorizonEstimator::{new}{bounded}{}",
        noises(export, [MatrixName::W, MatrixName::V, MatrixName::P0]),
        angles(export)
    );
}

/// The matrices of a noise model, as `w`, `v` and `p0`.
fn noises(export: &Export, matrices: [MatrixName; 3]) -> String {
    let [w, v, p0] = matrices.map(|which| of(export, which).unwrap_or_default());
    format!("    let w = {w};\n    let v = {v};\n    let p0 = {p0};\n")
}

/// A column of a constructor.
fn column(export: &Export, entries: &DVector<f64>) -> String {
    let entries = entries.iter().map(|x| number::rust(export.scalar.round(*x), export.scalar));
    format!("SVector::from([{}])", entries.collect::<Vec<_>>().join(", "))
}

/// The numbers of the unit vectors of a filter that has some.
fn unit_vectors(export: &Export) -> String {
    let vectors = export.observer.unit_vectors().map(|vectors| column(export, vectors));
    vectors.map_or_else(String::new, |vectors| format!("?\n        .with_unit_vectors({vectors})"))
}

/// The full turns of a filter with angles.
fn angles(export: &Export) -> String {
    let column = |turns: DVector<f64>| column(export, &turns);
    export.observer.turns().map_or_else(String::new, |(outputs, states)| {
        let states = states.map_or_else(String::new, |states| format!(", {}", column(states)));
        format!("?\n        .with_angles({}{states})", column(outputs))
    })
}

/// The gate of a filter that has one.
fn gate(export: &Export) -> String {
    let gate = export.scalars().into_iter().find(|(name, _)| *name == "GATE");
    gate.map_or_else(String::new, |(_, gate)| format!("?.with_gate({})", number::rust(gate, export.scalar)))
}

fn period(export: &Export) -> String {
    number::rust(export.scalar.round(export.observer.period()), export.scalar)
}

/// The type `Model`: the plant with its Jacobians.
pub(super) fn model(text: &mut String, export: &Export, routines: &Routines) {
    let scalar = export.scalar.name();
    let size = export.observer.dimensions();
    let (n, m, p) = (size.estimate, size.inputs, size.outputs);
    _ = write!(
        text,
        "
/// The plant x' = f(t, x, u), y = h(t, x, u), or x+ = f(t, x, u) in discrete time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model;

luenberger_observers::straight_line_plant!(Model, {scalar}, {n}, {m}, {p}, f, h, motion, measurement);
"
    );
    let dialect = dialect(export.scalar);
    let all = [
        ("f", "f(t, x, u)", &routines.f),
        ("h", "h(t, x, u)", &routines.h),
        ("motion", "f(t, x, u) and Df, row by row", &routines.motion),
        ("measurement", "h(t, x, u) and Dh, row by row", &routines.measurement),
    ];
    for (name, what, routine) in all {
        function(text, (name, what), routine, &dialect, (n, m));
    }
    let own = export.observer.extension();
    let own = own.iter().flat_map(ExtensionMaps::all);
    for (number, table, used) in tables(&all.map(|(_, _, routine)| routine).into_iter().chain(own).collect::<Vec<_>>())
    {
        _ = write!(text, "\n{}", table.source(number, &dialect, used));
    }
}

pub(super) fn function(
    text: &mut String,
    (name, what): (&str, &str),
    routine: &Routine,
    dialect: &Dialect,
    (n, m): (usize, usize),
) {
    let scalar = dialect.number();
    let of = |used: bool, name: &str| if used { name.to_owned() } else { format!("_{name}") };
    let (t, x, u) = (of(routine.uses_time(), "t"), of(routine.uses_states(), "x"), of(routine.uses_inputs(), "u"));
    // The lengths are known, so that no index can be out of bounds.
    let inputs = if routine.uses_inputs() {
        format!("    let Some(u) = u.first_chunk::<{m}>() else {{ return }};\n")
    } else {
        String::new()
    };
    _ = write!(
        text,
        "
/// {what}.
#[allow(unused_parens, clippy::all, clippy::pedantic)]
fn {name}({t}: {scalar}, {x}: &[{scalar}; {n}], {u}: &[{scalar}], out: &mut [{scalar}; {}]) {{
{inputs}{}}}
",
        routine.len(),
        routine.source(dialect)
    );
}
