//! Random observers as C, compared with the Rust observer bit by bit over 1000 steps, under several compilers and
//! options. Without a C compiler these tests say so and pass.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use luenberger_export::moving_horizon::MovingHorizon;
use luenberger_export::{Export, ExportableObserver, File, Names, Scalar, c_math, golden};
use luenberger_expression::{
    ExpressionPlant, Extrapolation, Interpolation, LookupTable, MathFunction, Parameters, Scope, Surface, Table, Tables,
};
use luenberger_observers::{
    DiscreteNonlinearObserver, ExtendedKalmanFilter, Horizon, InterSampleObserver, NoiseModel,
    SampledNonlinearObserver, SigmaPoints, UnscentedKalmanFilter,
};
use luenberger_random::Random;
use nalgebra::{DMatrix, DVector};

use crate::compiled::{self, SANITISERS, can_sanitise, compilers, has_haswell, is_complete};
use crate::kkl;
use crate::rows::{self, Rows};

const STEPS: usize = 1000;

/// An expression that is defined everywhere, of every kind of operation.
fn expression(random: &mut Random, depth: usize, (n, m): (usize, usize)) -> String {
    if depth == 0 {
        return match random.below(6) {
            0 if m > 0 => format!("u{}", 1 + random.below(m)),
            1 => format!("({:.3})", 2.0 * random.unit()),
            2 => ["k", "pi", "t", "J"][random.below(4)].to_owned(),
            _ => format!("x{}", 1 + random.below(n)),
        };
    }
    let mut of = || expression(random, depth - 1, (n, m));
    let (a, b) = (of(), of());
    match random.below(30) {
        0 => format!("sin({a})"),
        1 => format!("cos({a})"),
        2 => format!("tan(0.5*tanh({a}))"),
        3 => format!("exp(tanh({a}))"),
        4 => format!("ln(1 + ({a})^2)"),
        5 => format!("log10(1.5 + abs({a}))"),
        6 => format!("asin(tanh({a}))"),
        7 => format!("acos(0.9*sin({a}))"),
        8 => format!("atan({a})"),
        9 => format!("atan2({a}, {b})"),
        10 => format!("sinh(sat({a}, -2, 1.5))"),
        11 => format!("cosh(tanh({a}))"),
        12 => format!("asinh({a})"),
        13 => format!("acosh(1.5 + ({a})^2)"),
        14 => format!("atanh(0.9*tanh({a}))"),
        15 => format!("sqrt(1 + abs({a}))"),
        16 => format!("(1 + abs(tanh({a})))^(sin({b}))"),
        17 => format!("({a})/(1 + ({b})^2)"),
        18 => format!("min({a}, {b})"),
        19 => format!("max({a}, {b})"),
        20 => format!("if({a} < {b} || !({a} > 0.5), {b}, -({a}))"),
        21 => format!("line({a}) + surface({b}, {a})"),
        22 => format!("cubic({a})"),
        23 => format!("sign({a}) + step({b})"),
        24 => format!("ln(0.5 + exp({a}))"),
        25 => format!("(tanh({a}))^({})", 2 + random.below(6)),
        26 => format!("({a}) * tanh({b})"),
        27 => format!("wrap(7*({a})) - mod({b}, 0.7) + 0.1*floor({a})"),
        28 => format!("({a}) - ({b})"),
        _ => format!("({a}) + ({b})"),
    }
}

fn tables() -> Tables {
    let (x, y) = ([-2.0, -0.5, 0.25, 1.5, 3.0], [1.0, -0.5, 0.25, 2.0, 2.5]);
    let table =
        |interpolation, extrapolation| LookupTable::from(Table::new(&x, &y, interpolation, extrapolation).unwrap());
    let z: Vec<Vec<f64>> = y.iter().map(|a| y[..4].iter().map(|b| 0.5 * a * b + 0.1 * a).collect()).collect();
    let surface = Surface::new(&x, &x[..4], &z, Extrapolation::Linear);
    Tables::from([
        ("line".to_owned(), table(Interpolation::Linear, Extrapolation::Hold)),
        ("cubic".to_owned(), table(Interpolation::MonotoneCubic, Extrapolation::Linear)),
        ("surface".to_owned(), surface.unwrap().into()),
    ])
}

/// A damped nonlinear plant of n states, m inputs and p outputs.
pub(crate) fn plant(random: &mut Random, (n, m, p): (usize, usize, usize)) -> ExpressionPlant {
    let parameters = Parameters::from([("k".to_owned(), 0.7), ("J".to_owned(), -1.3)]);
    let scope = Scope::plant(n, m).with(&parameters).unwrap().tables(&tables()).unwrap();
    let mut row = |linear: String| {
        let depth = 1 + random.below(3);
        format!("{linear} + 0.3*tanh({})", expression(random, depth, (n, m)))
    };
    let f: Vec<String> = (1..=n).map(|i| row(format!("-0.5*x{i}"))).collect();
    let h: Vec<String> = (0..p).map(|i| row(format!("x{}", 1 + i % n))).collect();
    ExpressionPlant::within(&f, &h, &scope).unwrap_or_else(|error| panic!("{f:?} {h:?}: {error}"))
}

/// A recorded observer, which may have lookup tables, as its plant.
fn extension(random: &mut Random) -> ExportableObserver {
    let (n, m, p, z) = (1 + random.below(4), random.below(3), 1 + random.below(2), 1 + random.below(3));
    let mut own = |(states, inputs, outputs): (usize, usize, usize)| {
        let parameters = Parameters::from([("k".to_owned(), 0.7), ("J".to_owned(), -1.3)]);
        let scope = Scope::plant(states, inputs).with(&parameters).unwrap().tables(&tables()).unwrap();
        let mut row = |linear: String| {
            let depth = 1 + random.below(3);
            format!("{linear} + 0.3*tanh({})", expression(random, depth, (states, inputs)))
        };
        let f: Vec<String> = (1..=states).map(|i| row(format!("-0.5*x{i}"))).collect();
        let h: Vec<String> = (0..outputs).map(|i| row(format!("x{}", 1 + i % states))).collect();
        ExpressionPlant::within(&f, &h, &scope).unwrap_or_else(|error| panic!("{f:?} {h:?}: {error}"))
    };
    let (flow, start) = (own((z, m + p, n)), own((n, p, z)));
    let jump = own((z, m + p, z));
    let jump = (random.below(2) == 0).then_some(jump);
    let (period, substeps) = (0.02 + 0.01 * random.below(5) as f64, 1 + random.below(3));
    let plant = plant(random, (n, m, p));
    let observer = Rows { flow, start, jump, outputs: p }.recorded(&plant);
    ExportableObserver::Extension(InterSampleObserver::new(plant, observer, period, substeps).unwrap())
}

/// An observer whose step is given by expressions, with the outputs that its first states predict.
fn step(random: &mut Random) -> ExportableObserver {
    let (n, m, p) = (2 + random.below(3), random.below(3), 1 + random.below(2));
    let parameters = Parameters::from([("k".to_owned(), 0.7), ("J".to_owned(), -1.3)]);
    let scope = Scope::plant(n, m + p).with(&parameters).unwrap().tables(&tables()).unwrap();
    let f: Vec<String> = (1..=n)
        .map(|i| {
            let depth = 1 + random.below(3);
            let rest = expression(random, depth, (n, m + p));
            format!("0.5*x{i} + 0.1*abs(u{}) + 0.3*tanh({rest})", m + 1)
        })
        .collect();
    let h: Vec<String> = (1..=p).map(|i| format!("x{i}")).collect();
    let flow = ExpressionPlant::within(&f, &h, &scope).unwrap_or_else(|error| panic!("{f:?}: {error}"));
    ExportableObserver::Step(rows::step(&flow, m, 0.02 + 0.01 * random.below(5) as f64))
}

/// An observer of a nonlinear plant.
pub(crate) fn nonlinear(random: &mut Random) -> ExportableObserver {
    if random.below(6) == 0 {
        return ExportableObserver::Kkl(kkl::plain(random));
    }
    if random.below(6) == 0 {
        return step(random);
    }
    let (n, m, p) = (1 + random.below(4), random.below(3), 1 + random.below(2));
    let plant = plant(random, (n, m, p));
    let (period, substeps) = (0.02 + 0.01 * random.below(5) as f64, 1 + random.below(3));
    let kind = random.below(6);
    if kind < 2 {
        let l = DMatrix::from_fn(n, p, |_, _| 0.5 * random.unit());
        return ExportableObserver::SampledNonlinear(
            SampledNonlinearObserver::new(plant, l, period, substeps).unwrap(),
        );
    }
    if kind == 2 {
        // In discrete time the same right-hand side is a contraction as well.
        let l = DMatrix::from_fn(n, p, |_, _| 0.2 * random.unit());
        return ExportableObserver::Discrete(DiscreteNonlinearObserver::new(plant, l, period).unwrap());
    }
    let mut diagonal = |order, size: f64| {
        DMatrix::from_fn(order, order, |i, j| if i == j { size * (1.0 + 0.5 * random.unit()) } else { 0.0 })
    };
    let noises = NoiseModel { w: diagonal(n, 0.1), v: diagonal(p, 0.05), p0: diagonal(n, 1.0) };
    if kind == 3 {
        // The second has a centre with a negative weight.
        let sigma = [SigmaPoints::default(), SigmaPoints { alpha: 0.5, ..SigmaPoints::default() }][random.below(2)];
        let filter = match random.below(3) {
            0 => UnscentedKalmanFilter::discrete(plant, noises, sigma, period),
            _ => UnscentedKalmanFilter::new(plant, noises, sigma, period, substeps),
        };
        let filter = filter.unwrap();
        let filter = match random.below(2) {
            0 => filter.with_angles(turns(random, p), turns(random, n)).unwrap(),
            _ => filter,
        };
        return ExportableObserver::Unscented(if random.below(3) == 0 {
            filter.with_gate(2.0).unwrap()
        } else {
            filter
        });
    }
    let filter = match random.below(4) {
        0 => ExtendedKalmanFilter::discrete(plant, noises, period),
        _ => ExtendedKalmanFilter::new(plant, noises, period, substeps),
    };
    let filter = filter.unwrap().with_iterations(1 + random.below(3)).unwrap();
    let filter = if random.below(2) == 0 { filter.with_angles(turns(random, p)).unwrap() } else { filter };
    // Of two and more states, of which some are in a unit vector and some in another.
    let filter = if n > 1 && random.below(3) == 0 {
        let number = |i: usize| if i < 2 { 1.0 } else { [0.0, 2.0, 2.0, 1.0][i % 4] };
        let numbers = DVector::from_fn(n, |i, _| number(i));
        filter.with_unit_vectors(numbers).unwrap()
    } else {
        filter
    };
    ExportableObserver::Kalman(if random.below(3) == 0 { filter.with_gate(2.0).unwrap() } else { filter })
}

/// Full turns of a column, so short that the differences of a run go beyond half of one; 0 of every third.
fn turns(random: &mut Random, length: usize) -> DVector<f64> {
    DVector::from_fn(length, |_, _| if random.below(3) == 0 { 0.0 } else { 0.4 + 0.3 * random.unit() })
}

/// A moving-horizon estimator; two of three have bounds, which the estimates of the golden vectors reach.
pub(crate) fn moving_horizon(random: &mut Random) -> MovingHorizon<f64> {
    let (n, m, p) = (1 + random.below(3), random.below(3), 1 + random.below(2));
    let plant = plant(random, (n, m, p));
    let (period, substeps) = (0.02 + 0.01 * random.below(5) as f64, 1 + random.below(2));
    let horizon = Horizon { window: 1 + random.below(5), iterations: 1 + random.below(3) };
    let mut root = |order: usize, size: f64| {
        let root = DMatrix::from_fn(order, order, |i, j| size * random.unit() + if i == j { 2.0 * size } else { 0.0 });
        &root * root.transpose()
    };
    let noises = NoiseModel { w: root(n, 0.2), v: root(p, 0.1), p0: root(n, 0.5) };
    let estimator = match random.below(3) {
        0 => MovingHorizon::discrete(plant, noises, horizon, period),
        _ => MovingHorizon::new(plant, noises, horizon, period, substeps),
    };
    let estimator = estimator.unwrap();
    let estimator = match random.below(2) {
        0 => estimator.with_angles(turns(random, p), turns(random, n)).unwrap(),
        _ => estimator,
    };
    if random.below(3) == 0 {
        return estimator;
    }
    let mut side = |sign: f64| {
        let one = |_: usize, _: usize| match random.below(3) {
            0 => sign * f64::INFINITY,
            _ => sign * 0.05 * (1.0 + random.unit()) + sign * 1e-3,
        };
        DVector::from_fn(n, one)
    };
    let (lower, upper) = (side(-1.0), side(1.0));
    estimator.with_bounds(lower, upper).unwrap()
}

pub(crate) fn export(name: &str, program: ExportableObserver, scalar: Scalar) -> Export {
    let size = program.dimensions();
    let initial: Vec<f64> = (0..size.estimate).map(|i| 0.1 * i as f64 - 0.3).collect();
    let names = Names::numbered(size.estimate, program.plant_inputs(), size.outputs);
    Export::new(name, program, scalar, &initial, names).unwrap()
}

/// A program that steps each export over the samples in `in.bin` and writes the estimates to `out.bin`, as double.
fn driver(exports: &[Export], steps: usize) -> String {
    let mut text = "#include <stdio.h>\n".to_owned();
    let names: Vec<String> = (0..exports.len()).map(|k| format!("p{k}")).collect();
    for name in &names {
        _ = writeln!(text, "#include \"{name}.h\"");
    }
    text.push_str("int main(void)\n{\n    FILE *in = fopen(\"in.bin\", \"rb\");\n    FILE *out = fopen(\"out.bin\", \"wb\");\n    double x;\n    int i;\n    int k;\n    if ((in == 0) || (out == 0)) { return 2; }\n");
    for (name, export) in names.iter().zip(exports) {
        let size = export.observer().dimensions();
        let (n, m, p) = (size.estimate, size.inputs, size.outputs);
        let number = if export.scalar() == Scalar::Binary32 { "float" } else { "double" };
        let elapsed = if export.observer().takes_time() { format!("u[{}], ", m - 1) } else { String::new() };
        _ = write!(
            text,
            "    {{
        {name}_state state;
        {number} u[{}];
        {number} y[{p}];
        {number} xhat[{n}];
        {name}_reset(&state);
        for (k = 0; k < {steps}; ++k) {{
            for (i = 0; i < {m}; ++i) {{ if (fread(&x, sizeof x, 1, in) != 1) {{ return 3; }} u[i] = ({number})x; }}
            for (i = 0; i < {p}; ++i) {{ if (fread(&x, sizeof x, 1, in) != 1) {{ return 3; }} y[i] = ({number})x; }}
            {name}_step(&state, u, y, {elapsed}xhat);
            for (i = 0; i < {n}; ++i) {{ x = (double)xhat[i]; (void)fwrite(&x, sizeof x, 1, out); }}
        }}
    }}
",
            m.max(1)
        );
    }
    text.push_str("    (void)fclose(in);\n    (void)fclose(out);\n    return 0;\n}\n");
    text
}

/// Compiles the exports, whose names are p0, p1, ..., runs them over their samples, and compares every bit.
#[track_caller]
pub(crate) fn compare(folder: &Path, exports: &[Export], runs: &[Vec<golden::Step>], compiler: &str, flags: &[&str]) {
    let names: Vec<String> = (0..exports.len()).map(|k| format!("p{k}.c")).collect();
    let built = Command::new(compiler)
        .current_dir(folder)
        .args(["-std=c99", "-ffp-contract=off", "-Wall", "-Wextra", "-Wconversion", "-Werror"])
        .args(flags)
        .args(&names)
        .args(["main.c", "-o", "run", "-lm"])
        .output()
        .unwrap();
    assert!(built.status.success(), "{compiler} {flags:?}: {}", String::from_utf8_lossy(&built.stderr));
    let ran = Command::new(folder.join("run")).current_dir(folder).output().unwrap();
    assert!(ran.status.success(), "{compiler} {flags:?}: {}", String::from_utf8_lossy(&ran.stderr));
    let bytes = std::fs::read(folder.join("out.bin")).unwrap();
    let mut found = bytes.chunks_exact(8).map(|bytes| f64::from_ne_bytes(bytes.try_into().unwrap()));
    for (k, run) in runs.iter().enumerate() {
        for (step, golden::Step { estimate, .. }) in run.iter().enumerate() {
            for (i, expected) in estimate.iter().enumerate() {
                let found = found.next().unwrap();
                let same = found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan();
                assert!(same, "{compiler} {flags:?}: p{k}, step {step}, x{}: {found:?}, expected {expected:?}", i + 1);
            }
        }
    }
    assert!(found.next().is_none());
}

pub(crate) fn write(folder: &Path, exports: &[Export], runs: &[Vec<golden::Step>]) {
    for export in exports {
        for File { name, text } in export.c().unwrap_or_else(|error| panic!("{error}")) {
            std::fs::write(folder.join(name), text).unwrap();
        }
    }
    std::fs::write(folder.join("main.c"), driver(exports, runs.first().map_or(0, Vec::len))).unwrap();
    let mut bytes = Vec::new();
    for step in runs.iter().flatten() {
        step.u.iter().chain(&step.y).for_each(|x| bytes.extend(x.to_ne_bytes()));
    }
    std::fs::write(folder.join("in.bin"), bytes).unwrap();
}

/// Observers of one seed with their runs: linear ones of up to eight states, copies and filters of nonlinear plants.
/// Those that diverge are left out.
fn stable(seed: u64, count: usize) -> (Vec<Export>, Vec<Vec<golden::Step>>) {
    let mut random = Random(seed);
    let mut one = || {
        let scalar = if random.below(2) == 0 { Scalar::Binary32 } else { Scalar::Binary64 };
        let program = if random.below(4) == 0 {
            let (n, m) = (1 + random.below(8), random.below(4));
            let p = 1 + random.below(n.min(4));
            let (is_cubic, fed) = (random.below(2) == 0, random.below(2) == 0 && m > 0);
            compiled::program(random.bits(), (n, m, p), is_cubic, fed)
        } else {
            nonlinear(&mut random)
        };
        (program, scalar)
    };
    let (mut exports, mut runs) = (Vec::new(), Vec::new());
    let mut own = Random(!seed);
    let extensions =
        (0..count / 4).map(|k| (extension(&mut own), if k % 2 == 0 { Scalar::Binary32 } else { Scalar::Binary64 }));
    for (program, scalar) in (0..count).map(|_| one()).chain(extensions) {
        let export = export(&format!("p{}", exports.len()), program, scalar);
        if let Ok(run) = golden::steps(&export, STEPS) {
            exports.push(export);
            runs.push(run);
        }
    }
    (exports, runs)
}

#[test]
fn random_observers_agree_with_the_design_over_a_thousand_steps() {
    let compilers = compilers();
    let Some(first) = compilers.first() else {
        eprintln!("SKIPPED: no C compiler");
        return;
    };
    let folder = compiled::folder("fuzz");
    let sanitised = can_sanitise(first);
    if !sanitised {
        eprintln!("SKIPPED: {first} has no sanitizers here");
    }
    let mut flags: Vec<&[&str]> = vec![&["-O0"], &["-O2"], &["-Os"]];
    if has_haswell() {
        flags.push(&["-O2", "-march=haswell"]);
    }
    if sanitised {
        flags.push(&SANITISERS);
    }
    let mut count = 0;
    let batches = if is_complete() { 8 } else { 1 };
    if batches == 1 {
        flags.retain(|flags| *flags == ["-O0"] || flags.contains(&"-march=haswell") || *flags == SANITISERS);
    }
    for batch in 0..batches {
        let (exports, runs) = stable(batch as u64, 12);
        write(&folder, &exports, &runs);
        // All options for the first batch; the others take turns.
        let turn: Vec<_> = if batch == 0 { flags.clone() } else { vec![flags[batch % flags.len()]] };
        for flags in turn {
            compare(&folder, &exports, &runs, compilers[batch % compilers.len()], flags);
        }
        if batch == 0 {
            for compiler in &compilers[1..] {
                compare(&folder, &exports, &runs, compiler, &["-O2"]);
            }
        }
        count += exports.len();
    }
    assert!(count >= 11 * batches, "only {count} observers in {batches} batches are stable");
}

/// NaN and infinities in u and y come out of C as of Rust. A filter and an observer with a constant gain do not use
/// such an output, and their estimates stay finite.
#[test]
fn what_is_not_finite_comes_out_the_same() {
    let Some(compiler) = compilers().into_iter().next() else {
        eprintln!("SKIPPED: no C compiler");
        return;
    };
    let folder = compiled::folder("not-finite");
    let (exports, mut runs) = stable(77, 18);
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let (mut spoiled, mut filters, mut bounded) = (0, 0, 0);
    for (k, (export, run)) in exports.iter().zip(&mut runs).enumerate() {
        let bad = bad[k % bad.len()];
        if k % 4 == 3 && !run[0].u.is_empty() {
            run[STEPS / 2].u[0] = bad;
        } else {
            run[STEPS / 2].y[0] = bad;
        }
        let samples: Vec<_> = run.iter().map(|step| (step.u.clone(), step.y.clone())).collect();
        for (step, estimate) in run.iter_mut().zip(golden::replay(export, &samples).unwrap()) {
            step.estimate = estimate;
        }
        let is_spoiled = |step: &golden::Step| step.estimate.iter().any(|x| !x.is_finite());
        assert!(!run[..STEPS / 2].iter().any(is_spoiled));
        let passes_over = export.observer().leaves_out_missing();
        filters += usize::from(passes_over);
        if let ExportableObserver::Kkl(_) = export.observer() {
            // The estimate stays in its box.
            assert!(!run.iter().any(is_spoiled));
            bounded += 1;
            continue;
        }
        let after = run[STEPS / 2..].iter().filter(|step| is_spoiled(step)).count();
        // An observer of expressions may not read what is not finite.
        if k % 4 != 3 && !matches!(export.observer(), ExportableObserver::Extension(_) | ExportableObserver::Step(_)) {
            assert!(passes_over && after == 0, "p{k}, {bad}: {after}");
        }
        spoiled += usize::from(after > 0);
    }
    assert!(filters >= 10, "{filters} of {}", exports.len());
    let others = exports.len() - filters - bounded;
    assert!(2 * spoiled >= others, "{spoiled} of {others}");
    write(&folder, &exports, &runs);
    compare(&folder, &exports, &runs, compiler, &[compiled::optimisation()]);
}

/// Samples of which every output, or one of two, is NaN or infinite: C has the bits of Rust, the estimates are those of
/// a run in which these outputs are missed, and from the next sample on they are corrected again.
#[test]
fn what_is_not_finite_is_passed_over() {
    let Some(compiler) = compilers().into_iter().next() else {
        eprintln!("SKIPPED: no C compiler");
        return;
    };
    let folder = compiled::folder("passed-over");
    let diagonal = |order: usize, entry: f64| DMatrix::from_diagonal_element(order, order, entry);
    let noises = || NoiseModel { w: diagonal(2, 0.1), v: diagonal(2, 0.05), p0: diagonal(2, 1.0) };
    let plant = || crate::moving_horizon::plant(&["x2", "-sin(x1) - 0.1*x2 + u1"], &["x1", "x2 + 0.1*x1*x1"], 1);
    let extended = || ExtendedKalmanFilter::new(plant(), noises(), 0.1, 2).unwrap();
    let unscented = |sigma| UnscentedKalmanFilter::new(plant(), noises(), sigma, 0.1, 2).unwrap();
    let small = SigmaPoints { alpha: 0.5, ..SigmaPoints::default() };
    let map = || crate::moving_horizon::plant(&["x1 + 0.1*x2", "0.9*x2 - 0.1*sin(x1) + u1"], &["x1", "x2"], 1);
    let v = DMatrix::from_row_slice(2, 2, &[0.05, 0.02, 0.02, 0.03]);
    let horizon = Horizon { window: 3, iterations: 2 };
    let moving = MovingHorizon::new(plant(), NoiseModel { v, ..noises() }, horizon, 0.1, 2).unwrap();
    let bounds = || DVector::from_vec(vec![0.3, f64::INFINITY]);
    let programs = [
        ExportableObserver::Kalman(extended()),
        ExportableObserver::Kalman(extended().with_gate(50.0).unwrap()),
        ExportableObserver::Kalman(ExtendedKalmanFilter::discrete(map(), noises(), 0.1).unwrap()),
        ExportableObserver::Kalman(extended().with_angles(DVector::from_vec(vec![0.5, 0.0])).unwrap()),
        ExportableObserver::Kalman(extended().with_unit_vectors(DVector::from_element(2, 1.0)).unwrap()),
        ExportableObserver::Unscented(unscented(SigmaPoints::default())),
        ExportableObserver::Unscented(unscented(small).with_gate(50.0).unwrap()),
        ExportableObserver::Unscented(UnscentedKalmanFilter::discrete(map(), noises(), small, 0.1).unwrap()),
        ExportableObserver::MovingHorizon(moving.clone()),
        ExportableObserver::MovingHorizon(moving.with_bounds(-bounds(), bounds()).unwrap()),
    ];
    let gain = || DMatrix::from_row_slice(2, 2, &[2.0, 0.1, 0.5, 1.5]);
    let copy = SampledNonlinearObserver::new(plant(), gain(), 0.1, 2).unwrap();
    let copy_of_map = DiscreteNonlinearObserver::new(map(), gain() * 0.25, 0.1).unwrap();
    let with_constant_gain = [
        ExportableObserver::SampledNonlinear(copy),
        ExportableObserver::Discrete(copy_of_map),
        compiled::program(3, (3, 2, 2), false, true),
        compiled::program(3, (3, 2, 2), true, true),
        compiled::semi_implicit(11, (3, 2, 2), true),
        compiled::varying(&compiled::program(7, (3, 2, 2), true, true)),
    ];
    let update = DMatrix::from_fn(3, 2, |i, j| 0.4 / (1.0 + i as f64) - 0.1 * j as f64);
    let (mut exports, mut runs) = (Vec::new(), Vec::new());
    // The linear one in filter form as well.
    let all = programs.into_iter().chain(with_constant_gain).map(|program| (program, false));
    for (program, in_filter_form) in all.chain([(compiled::program(5, (3, 2, 2), false, true), true)]) {
        for scalar in [Scalar::Binary32, Scalar::Binary64] {
            let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
            let all = if is_complete() { &bad[..] } else { &bad[exports.len() % bad.len()..][..1] };
            for &bad in all {
                let export = export(&format!("p{}", exports.len()), program.clone(), scalar);
                let export = if in_filter_form { export.with_update(&update).unwrap() } else { export };
                assert!(export.observer().leaves_out_missing());
                let mut run = golden::steps(&export, STEPS).unwrap();
                let healthy: Vec<_> = run.iter().map(|step| step.estimate.clone()).collect();
                for (output, at) in [(0, 0), (0, STEPS / 4), (1, STEPS / 4 + 1), (0, STEPS / 4 + 2)] {
                    run[at].y[output] = bad;
                }
                let at = STEPS / 3;
                run[at].y.fill(bad);
                let samples: Vec<_> = run.iter().map(|step| (step.u.clone(), step.y.clone())).collect();
                for (step, estimate) in run.iter_mut().zip(golden::replay(&export, &samples).unwrap()) {
                    step.estimate = estimate;
                }
                assert!(run.iter().all(|step| step.estimate.iter().all(|x| x.is_finite())), "{bad}");
                // What the lost samples would have said is forgotten in the end.
                let apart = |k: usize| (run[k].estimate[0] - healthy[k][0]).abs();
                assert!(apart(at) > 0.0 && apart(STEPS - 1) < 1e-4, "{} {}", apart(at), apart(STEPS - 1));
                exports.push(export);
                runs.push(run);
            }
        }
    }
    write(&folder, &exports, &runs);
    compare(&folder, &exports, &runs, compiler, &[compiled::optimisation()]);
}

/// An observer of each kind with all options: gates, a negative centre, active bounds, a search, a semi-implicit step.
fn of_every_kernel() -> [ExportableObserver; 5] {
    let (one, two) = (DMatrix::from_element(1, 1, 0.05), DMatrix::from_diagonal_element(2, 2, 0.1));
    let noises = || NoiseModel { w: two.clone(), v: one.clone(), p0: two.clone() };
    let plant =
        |inputs: &str, count| crate::moving_horizon::plant(&["x2", &format!("-x1 - 0.1*x2{inputs}")], &["x1"], count);
    let forced = || plant(" + u1", 1);
    let small = SigmaPoints { alpha: 0.5, ..SigmaPoints::default() };
    let horizon = Horizon { window: 3, iterations: 2 };
    let estimator = MovingHorizon::new(forced(), noises(), horizon, 0.1, 2).unwrap();
    let bound = DVector::from_element(2, 0.1);
    [
        ExportableObserver::Kalman(
            ExtendedKalmanFilter::new(forced(), noises(), 0.1, 2)
                .unwrap()
                .with_gate(3.0)
                .unwrap()
                .with_angles(DVector::from_element(1, 360.0))
                .unwrap()
                .with_unit_vectors(DVector::from_element(2, 1.0))
                .unwrap(),
        ),
        ExportableObserver::Unscented(
            UnscentedKalmanFilter::new(forced(), noises(), small, 0.1, 2).unwrap().with_gate(3.0).unwrap(),
        ),
        ExportableObserver::MovingHorizon(estimator.with_bounds(-&bound, bound).unwrap()),
        ExportableObserver::Kkl(kkl::of_plant(&mut Random(5), &plant("", 0), 1)),
        compiled::semi_implicit(11, (3, 2, 2), true),
    ]
}

/// Routines for doubles in software, of the names that compilers for ARM call.
fn is_of_doubles(routine: &str) -> bool {
    let name = routine.strip_prefix("__aeabi_").unwrap_or_default();
    name.starts_with('d') || name.starts_with("cd") || name.ends_with("2d")
}

/// On a processor with single precision alone an observer in f32, with any of the elementary functions, calls no
/// routine for doubles.
#[test]
fn in_f32_a_cortex_m4_computes_no_double() {
    const COMPILER: &str = "arm-none-eabi-gcc";
    if Command::new(COMPILER).arg("--version").output().is_err() {
        eprintln!("SKIPPED: no {COMPILER}");
        return;
    }
    let folder = compiled::folder("singles");
    let mut random = Random(8);
    let programs: Vec<_> = (0..6).map(|_| nonlinear(&mut random)).chain(of_every_kernel()).collect();
    let mut sources = Vec::new();
    for (k, program) in programs.into_iter().enumerate() {
        // Two in f64 for comparison.
        for scalar in [Scalar::Binary32, Scalar::Binary64].into_iter().take(if k < 2 { 2 } else { 1 }) {
            let name = format!("{}{k}", if scalar == Scalar::Binary32 { "single" } else { "double" });
            // Some diverge.
            for File { name, text } in export(&name, program.clone(), scalar).c().unwrap_or_default() {
                std::fs::write(folder.join(name), text).unwrap();
            }
            sources.extend(folder.join(format!("{name}.c")).exists().then_some(name));
        }
    }
    let all = c_math::source("all", Scalar::Binary32, MathFunction::ALL).replace("static float all_", "float all_");
    std::fs::write(folder.join("single.c"), format!("{}{all}", c_math::INCLUDES)).unwrap();
    assert!(sources.len() > 8, "{sources:?}");
    sources.push("single".to_owned());
    for name in sources {
        let built = Command::new(COMPILER)
            .current_dir(&folder)
            .args(["-std=c99", "-O2", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"])
            .args(["-c", &format!("{name}.c"), "-o", "object.o"])
            .output()
            .unwrap();
        assert!(built.status.success(), "{name}: {}", String::from_utf8_lossy(&built.stderr));
        let called = Command::new("arm-none-eabi-nm").current_dir(&folder).args(["-u", "object.o"]).output().unwrap();
        let called = String::from_utf8(called.stdout).unwrap();
        let doubles: Vec<&str> = called.split_whitespace().filter(|name| is_of_doubles(name)).collect();
        assert_eq!(doubles.is_empty(), name.starts_with("single"), "{name} calls {doubles:?}");
    }
}

/// Emitted C keeps MISRA's rules but for the deviations of `docs/deploy.md`.
#[test]
fn misra_rules_hold_but_for_the_documented_deviations() {
    if Command::new("cppcheck").arg("--version").output().is_err() {
        eprintln!("SKIPPED: no cppcheck");
        return;
    }
    let folder = compiled::folder("misra");
    let own = ["2.2", "2.5", "8.7", "8.9", "15.5"];
    let of_libm = ["9.3", "10.1", "10.3", "10.6", "10.8", "12.1", "12.2", "14.4", "15.5", "21.15"];
    let mut random = Random(3);
    let (count, least) = if is_complete() { (3, 5) } else { (0, 3) };
    let programs = (0..count).map(|_| nonlinear(&mut random)).collect::<Vec<_>>().into_iter().chain(of_every_kernel());
    // The checker takes a second or two for each.
    let programs = programs.step_by(if is_complete() { 1 } else { 2 });
    let mut checked = 0;
    for (k, program) in programs.enumerate() {
        let export = export("plant", program, if k % 2 == 0 { Scalar::Binary32 } else { Scalar::Binary64 });
        let Ok(files) = export.c() else { continue };
        for File { name, text } in &files {
            std::fs::write(folder.join(name), text).unwrap();
        }
        let source = &files.iter().find(|file| file.name == "plant.c").unwrap().text;
        let found = checked_by_cppcheck(&folder, "plant.c");
        for line in found.lines() {
            // The lines below a finding show its place.
            if line.starts_with(' ') || line.is_empty() {
                continue;
            }
            let finding = line.rsplit_once('[').and_then(|(_, rest)| rest.strip_suffix(']'));
            let Some(finding) = finding else { continue };
            let rule = finding.strip_prefix("misra-c2012-").unwrap_or(finding);
            let mut place = line.split(':');
            let (name, number) = (place.next().unwrap(), place.next().unwrap().parse::<usize>().unwrap());
            let is_header = Path::new(name).extension().is_some_and(|e| e == "h");
            let allowed = if is_header || !is_of_libm(source, number) { &own[..] } else { &of_libm };
            let text = if is_header { "" } else { source.lines().nth(number - 1).unwrap_or_default() };
            assert!(allowed.contains(&rule) || own.contains(&rule), "{line}\n{text}");
        }
        checked += 1;
        if checked > 2 {
            continue;
        }
        // A file that breaks a rule in its last lines: found, unless the checker stops before it.
        std::fs::write(folder.join("broken.c"), format!("{source}{BROKEN}")).unwrap();
        let found = checked_by_cppcheck(&folder, "broken.c");
        for expected in ["misra-c2012-10.4", "unusedVariable"] {
            assert!(found.contains(expected), "{expected} is not in {found}");
        }
    }
    assert!(checked >= least, "{checked}");
}

/// Whether a line, from 1, lies in an elementary function, whose names begin with that of the export.
fn is_of_libm(source: &str, line: usize) -> bool {
    let functions = source.lines().take(line).filter(|line| line.ends_with(')') && !line.starts_with([' ', '#', '/']));
    functions.last().is_some_and(|function| function.starts_with("static") && function.contains(" plant_"))
}

/// A function with an unused variable and an addition of a signed and an unsigned number.
const BROKEN: &str = "
int broken(int a);
int broken(int a)
{
    int unused;
    return (int)(a + 1u);
}
";

/// Findings of style that are no rules of MISRA: a loop over one state or output has constant conditions, and kernels
/// declare their counters once for all.
const STYLE: [&str; 3] = ["knownConditionTrueFalse", "moduloofone", "variableScope"];

/// All findings but these. The checker does not read `float.h`: without its values the guards of the source would leave
/// nothing of the file.
fn checked_by_cppcheck(folder: &Path, file: &str) -> String {
    let output = Command::new("cppcheck")
        .current_dir(folder)
        .args(["--addon=misra", "--std=c99", "--quiet", "--inline-suppr", "--suppress=missingIncludeSystem"])
        .args(["--enable=warning,style,performance,portability,information", "--suppress=checkersReport"])
        .args(STYLE.map(|finding| format!("--suppress={finding}")))
        .args(["--suppress=unmatchedSuppression", "-DFLT_MANT_DIG=24", "-DDBL_MANT_DIG=53", "-DFLT_EVAL_METHOD=0"])
        .arg(file)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && !text.contains("noValidConfiguration"), "{file} is not analysed: {text}");
    text
}
