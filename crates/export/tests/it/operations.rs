//! The operations of a step that an export states, held against those that its emitted source takes: compiled with a
//! type of numbers that counts them.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use luenberger_export::moving_horizon::MovingHorizon;
use luenberger_export::{Export, ExportableObserver, Scalar};
use luenberger_expression::ExpressionPlant;
use luenberger_observers::{
    DiscreteNonlinearObserver, ExtendedKalmanFilter, Horizon, InterSampleObserver, NoiseModel,
    SampledNonlinearObserver, SigmaPoints, UnscentedKalmanFilter,
};
use luenberger_random::Random;
use nalgebra::{DMatrix, dmatrix, dvector};

use crate::moving_horizon::plant;
use crate::rows::{self, Rows};
use crate::{compiled, fuzz, kkl};

/// Numbers that count the operations with them.
const COUNTING: &str = "#pragma once
#include <cfloat>
#include <cmath>
#include <cstddef>
extern long operations;
struct counted {
    double v;
    counted() = default;
    template <typename T> counted(T x) : v(static_cast<double>(x)) {}
    explicit operator int() const { return static_cast<int>(v); }
};
inline counted operator+(counted a, counted b) { ++operations; return a.v + b.v; }
inline counted operator-(counted a, counted b) { ++operations; return a.v - b.v; }
inline counted operator*(counted a, counted b) { ++operations; return a.v * b.v; }
inline counted operator/(counted a, counted b) { ++operations; return a.v / b.v; }
inline counted operator-(counted a) { return -a.v; }
inline bool operator<(counted a, counted b) { return a.v < b.v; }
inline bool operator>(counted a, counted b) { return a.v > b.v; }
inline bool operator<=(counted a, counted b) { return a.v <= b.v; }
inline bool operator>=(counted a, counted b) { return a.v >= b.v; }
inline bool operator==(counted a, counted b) { return a.v == b.v; }
inline bool operator!=(counted a, counted b) { return a.v != b.v; }
inline counted sqrt(counted a) { ++operations; return std::sqrt(a.v); }
inline counted floor(counted a) { ++operations; return std::floor(a.v); }
inline counted fabs(counted a) { return std::fabs(a.v); }
";

/// Inputs and outputs of a run: the outputs jump in its middle.
const STEPS: usize = 40;

/// The operations of each step of each export, whose names are p0, p1, ..; none without a C++ compiler.
fn counts(folder: &Path, exports: &[Export]) -> Option<Vec<Vec<usize>>> {
    if Command::new("c++").arg("--version").output().is_err() {
        eprintln!("SKIPPED: no C++ compiler");
        return None;
    }
    std::fs::write(folder.join("counting.h"), COUNTING).unwrap();
    let (mut heads, mut body, mut sources) = (String::new(), String::new(), Vec::new());
    for (k, export) in exports.iter().enumerate() {
        for file in export.c().unwrap() {
            // The method of interior points takes all the steps that it may take.
            let text = file.text.replace("(ends == 0)", "(ends >= 0)");
            let text = text.replace("double", "counted").replace("#ifdef __cplusplus", "#if 0");
            let text = text.replace("#include <math.h>", "").replace("#include <float.h>", "");
            let name = file.name.replace(".c", ".cc");
            if name == format!("p{k}.cc") {
                sources.push(name.clone());
            }
            std::fs::write(folder.join(&name), format!("#include \"counting.h\"\n{text}")).unwrap();
        }
        let size = export.observer().dimensions();
        let time = if export.observer().takes_time() { "0.25, " } else { "" };
        _ = writeln!(heads, "#include \"p{k}.h\"");
        _ = write!(
            body,
            "    {{
        p{k}_state state;
        counted u[{}];
        counted y[{}];
        p{k}_reset(&state);
        for (int k = 0; k < {STEPS}; ++k) {{
            for (counted &x : u) {{ x = 0.01; }}
            for (counted &x : y) {{ x = 0.1; }}
            y[0] = (k < {STEPS} / 2) ? 0.05 : 3.0;
            operations = 0;
            p{k}_step(&state, u, y, {time}nullptr);
            std::printf(\"%ld\\n\", operations);
        }}
    }}
",
            size.inputs.max(1),
            size.outputs
        );
    }
    let main = format!("{heads}#include <cstdio>\nlong operations;\nint main()\n{{\n{body}    return 0;\n}}\n");
    std::fs::write(folder.join("main.cc"), main).unwrap();
    let built = Command::new("c++")
        .current_dir(folder)
        .args(["-w", "-fpermissive", "-O1"])
        .args(&sources)
        .args(["main.cc", "-o", "count"])
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let ran = Command::new(folder.join("count")).output().unwrap();
    let found: Vec<usize> = String::from_utf8_lossy(&ran.stdout).lines().map(|line| line.parse().unwrap()).collect();
    Some(found.chunks(STEPS).map(<[usize]>::to_vec).collect())
}

fn three() -> ExpressionPlant {
    plant(&["x2", "x3 - x1*x2 + t*u1", "-0.5*x3"], &["x1 + 0.1*x2*x3", "x2"], 1)
}

/// With a gain of its own it does not diverge, also not as a plant in discrete time.
pub(crate) fn damped() -> ExpressionPlant {
    plant(&["-0.5*x1 + 0.1*x2", "-0.5*x2 + 0.01*x3*x3 + 0.1*u1", "-0.5*x3"], &["x1 + 0.01*x3*x3", "x2"], 1)
}

fn noises() -> NoiseModel<f64, nalgebra::Dyn, nalgebra::Dyn> {
    let diagonal = |order: usize, entry: f64| DMatrix::from_diagonal_element(order, order, entry);
    NoiseModel { w: diagonal(3, 0.1), v: dmatrix![0.05, 0.01; 0.01, 0.02], p0: diagonal(3, 1.0) }
}

/// A recorded observer of two coordinates, with a jump or without.
pub(crate) fn recorded(jumps: bool) -> ExportableObserver {
    // The inputs are (u, y1, y2), and the outputs the estimate.
    let flow = plant(&["x2 - x1 + u2*u2", "u1 - 3*x2 - u3*x1"], &["x1", "x2 + u2", "x1*x2"], 3);
    let (start, jump) = (plant(&["0", "0", "0"], &["x1", "x2"], 2), plant(&["0", "0"], &["x1*u2", "x2"], 3));
    let observer = Rows { flow, start, jump: jumps.then_some(jump), outputs: 2 }.recorded(&damped());
    ExportableObserver::Extension(InterSampleObserver::new(damped(), observer, 0.1, 2).unwrap())
}

/// Over a run at a bound and within, the counts are those of the header but for what is stated beside them: a step
/// whose plant leaves out products with one or takes what occurs twice once, in each linearisation.
#[test]
fn a_moving_horizon_takes_the_operations_that_are_stated() {
    let horizon = |window, iterations| Horizon { window, iterations };
    let far = f64::INFINITY;
    let bounded = |estimator: MovingHorizon<f64>| {
        estimator.with_bounds(dvector![-far, -0.5, -far], dvector![0.4, 0.5, far]).unwrap()
    };
    let single = || plant(&["-0.5*x1 + 0.1*x2", "-0.5*x2"], &["x1"], 0);
    let of_single =
        || NoiseModel { w: dmatrix![0.1, 0.0; 0.0, 0.1], v: dmatrix![0.05], p0: dmatrix![1.0, 0.0; 0.0, 1.0] };
    let estimators = [
        bounded(MovingHorizon::new(three(), noises(), horizon(4, 2), 0.1, 2).unwrap()),
        bounded(MovingHorizon::new(damped(), noises(), horizon(3, 1), 0.1, 3).unwrap()),
        bounded(MovingHorizon::discrete(damped(), noises(), horizon(5, 3), 0.1).unwrap()),
        MovingHorizon::new(single(), of_single(), horizon(2, 2), 0.1, 1).unwrap(),
        MovingHorizon::discrete(single(), of_single(), horizon(6, 1), 0.1).unwrap(),
        bounded(MovingHorizon::new(three(), noises(), horizon(4, 2), 0.1, 2).unwrap())
            .with_angles(dvector![6.25, 0.0], dvector![6.25, 0.0, 6.25])
            .unwrap(),
    ];
    let one =
        |(k, estimator)| fuzz::export(&format!("p{k}"), ExportableObserver::MovingHorizon(estimator), Scalar::Binary64);
    let exports: Vec<Export> = estimators.into_iter().enumerate().map(one).collect();
    let Some(counts) = counts(&compiled::folder("operations-moving-horizon"), &exports) else { return };
    let beyond: Vec<_> = exports
        .iter()
        .zip(&counts)
        .map(|(export, counts)| {
            let (within, most) = (export.operations_within_bounds(), export.operations());
            (within.map(|within| within - counts[STEPS / 2 - 1]), most - counts[STEPS - 1])
        })
        .collect();
    // Nor are all steps shortened by all slacks and multipliers.
    assert_eq!(beyond, [(Some(0), 1420), (Some(1), 1049), (Some(1), 1773), (None, 1), (None, 1), (Some(0), 1420)]);
}

/// The bytes of the state that a header states are those that a compiler gives it, in both formats, with a time in each
/// sample and without.
#[test]
fn the_state_of_a_moving_horizon_has_the_bytes_that_are_stated() {
    let Some(compiler) = compiled::compilers().into_iter().next() else {
        eprintln!("SKIPPED: no C compiler");
        return;
    };
    let folder = compiled::folder("bytes-moving-horizon");
    for (is_timed, window) in [(true, 4), (false, 4), (true, 3), (false, 3)] {
        for scalar in [Scalar::Binary32, Scalar::Binary64] {
            let f = [if is_timed { "0.01*sin(t) - 0.5*x1" } else { "-0.5*x1" }, "0.1*u1 - 0.5*x2", "-0.5*x3"];
            let plant = plant(&f, &["x1", "x2"], 1);
            let estimator = MovingHorizon::new(plant, noises(), Horizon { window, iterations: 2 }, 0.1, 2).unwrap();
            let export = fuzz::export("p0", ExportableObserver::MovingHorizon(estimator), scalar);
            for file in export.c().unwrap() {
                std::fs::write(folder.join(file.name), file.text).unwrap();
            }
            let body = "int main(void) { printf(\"%lu\", (unsigned long)sizeof(p0_state)); return 0; }";
            let main = format!("#include <stdio.h>\n#include \"p0.h\"\n{body}\n");
            std::fs::write(folder.join("bytes.c"), main).unwrap();
            let built = Command::new(compiler).current_dir(&folder).args(["bytes.c", "-o", "bytes"]).output().unwrap();
            assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
            let ran = Command::new(folder.join("bytes")).output().unwrap();
            let bytes = String::from_utf8_lossy(&ran.stdout).into_owned();
            let header = std::fs::read_to_string(folder.join("p0.h")).unwrap();
            assert!(header.contains(&format!("The state has {bytes} bytes")), "{is_timed} {window} {bytes}: {header}");
        }
    }
}

/// The same of the other kinds, of plants without elementary functions, whose calls are stated as one operation each.
#[test]
fn steps_take_the_operations_that_are_stated() {
    let mut programs = Vec::new();
    for (seed, sizes) in [(3, (4, 1, 1)), (5, (5, 2, 3)), (7, (1, 0, 1))] {
        for is_cubic in [false, true] {
            for is_fed in [false, true].into_iter().take(1 + sizes.1.min(1)) {
                programs.push(compiled::program(seed, sizes, is_cubic, is_fed));
            }
        }
    }
    programs.push(compiled::semi_implicit(5, (5, 2, 3), false));
    let l = || DMatrix::from_element(3, 2, 0.1);
    programs.push(ExportableObserver::SampledNonlinear(SampledNonlinearObserver::new(damped(), l(), 0.1, 2).unwrap()));
    programs.push(ExportableObserver::Discrete(DiscreteNonlinearObserver::new(damped(), l(), 0.1).unwrap()));
    let kalman = ExtendedKalmanFilter::new(damped(), noises(), 0.1, 2).unwrap();
    programs.push(ExportableObserver::Kalman(kalman.clone()));
    programs.push(ExportableObserver::Kalman(kalman.clone().with_gate(1e6).unwrap()));
    let iterated = kalman.with_iterations(3).unwrap();
    programs.push(ExportableObserver::Kalman(iterated.clone()));
    programs.push(ExportableObserver::Kalman(iterated.with_gate(1e6).unwrap()));
    programs.push(ExportableObserver::Kalman(ExtendedKalmanFilter::discrete(damped(), noises(), 0.1).unwrap()));
    let unscented = UnscentedKalmanFilter::new(damped(), noises(), SigmaPoints::default(), 0.1, 2).unwrap();
    programs.push(ExportableObserver::Unscented(unscented.clone()));
    programs.push(ExportableObserver::Unscented(unscented.with_gate(1e6).unwrap()));
    let discrete = UnscentedKalmanFilter::discrete(damped(), noises(), SigmaPoints::default(), 0.1).unwrap();
    programs.push(ExportableObserver::Unscented(discrete));
    let (outputs, states) = (dvector![0.0, 6.25], dvector![6.25, 0.0, 6.25]);
    let angles = ExtendedKalmanFilter::new(damped(), noises(), 0.1, 2).unwrap().with_gate(1e6).unwrap();
    let angles = angles.with_iterations(3).unwrap().with_angles(outputs.clone()).unwrap();
    programs.push(ExportableObserver::Kalman(angles.clone()));
    let vectors = angles.with_unit_vectors(dvector![2.0, 1.0, 1.0]).unwrap();
    let vectors = vectors.with_iterations(1).unwrap();
    programs.push(ExportableObserver::Kalman(vectors));
    let angles = UnscentedKalmanFilter::discrete(damped(), noises(), SigmaPoints::default(), 0.1).unwrap();
    programs.push(ExportableObserver::Unscented(angles.with_angles(outputs, states).unwrap()));
    for is_fed in [false, true] {
        programs.push(compiled::varying(&compiled::program(3, (4, 1, 1), true, is_fed)));
        programs.push(compiled::varying(&compiled::semi_implicit(5, (5, 2, 3), is_fed)));
    }
    programs.extend([false, true].map(recorded));
    programs.push(ExportableObserver::Step(rows::step(&plant(&["x2*u1", "x1*x1 - u2"], &["x1"], 2), 1, 0.1)));
    let one = |(k, program): (usize, ExportableObserver)| fuzz::export(&format!("p{k}"), program, Scalar::Binary64);
    let exports: Vec<Export> = programs.into_iter().enumerate().map(one).collect();
    let Some(counts) = counts(&compiled::folder("operations"), &exports) else { return };
    // The statement is a bound: by how much it exceeds the operations of the compiled source.
    // The slopes of copies leave out products with one, and take what occurs twice once, as do filters in each
    // linearisation.
    let beyond = [0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 4, 32, 2, 3, 3, 9, 9, 3, 31, 61, 31, 9, 3, 31, 0, 4, 0, 4, 0, 0, 0];
    let found: Vec<isize> = exports
        .iter()
        .zip(&counts)
        .map(|(export, counts)| export.operations().cast_signed() - counts.iter().max().unwrap().cast_signed())
        .collect();
    assert_eq!(found, beyond);
    let mut wrong = Vec::new();
    for (k, (export, counts)) in exports.iter().zip(&counts).enumerate() {
        let (most, stated) = (*counts.iter().max().unwrap(), export.operations());
        if most > stated || 10 * most < 9 * stated {
            wrong.push(format!("p{k}: {most} operations, {stated} are stated"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The numerical KKL observers, whose searches end early at some samples.
#[test]
fn left_inverses_take_no_more_operations_than_are_stated() {
    let mut random = Random(11);
    let mut exports = Vec::new();
    for states in 2..=6 {
        let f: Vec<String> = (1..=states).map(|i| format!("x{} - 0.5*x{i} + 0.1*x1*x{i}", i % states + 1)).collect();
        let f: Vec<&str> = f.iter().map(String::as_str).collect();
        for form in 0..2 {
            let observer = kkl::of_plant(&mut random, &plant(&f, &["x1"], 0), form);
            exports.push(fuzz::export(
                &format!("p{}", exports.len()),
                ExportableObserver::Kkl(observer),
                Scalar::Binary64,
            ));
        }
    }
    let Some(counts) = counts(&compiled::folder("operations-kkl"), &exports) else { return };
    // By how much the statement exceeds the most of these steps: exactly what the searches leave out.
    let of_steps = |(export, counts): (&Export, &Vec<usize>)| export.operations() - counts.iter().max().unwrap();
    assert_eq!(
        exports.iter().zip(&counts).map(of_steps).collect::<Vec<_>>(),
        [17, 722, 24, 21377, 31, 52944, 38, 14802, 45, 61579]
    );
    let mut wrong = Vec::new();
    for (k, (export, counts)) in exports.iter().zip(&counts).enumerate() {
        let (most, stated) = (*counts.iter().max().unwrap(), export.operations());
        if most > stated || 3 * most < stated {
            wrong.push(format!("p{k}: {most} operations, {stated} are stated: {counts:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What is stored, counted by hand: the matrices of each kind, its scalars, the first estimate, and the state, which
/// has the estimate, and the covariance or its root in filters.
#[test]
fn bytes_are_those_of_what_is_stored() {
    let (n, m, p) = (5, 2, 3);
    let linear = n * n + n * m + p * n + n * p;
    let cubic = linear + n * p + p * p;
    let plain = |observer| fuzz::export("p0", observer, Scalar::Binary64);
    let single = |observer| fuzz::export("p0", observer, Scalar::Binary32);
    let of = |is_cubic, is_fed| compiled::program(5, (n, m, p), is_cubic, is_fed);
    let gain = |rows, columns| DMatrix::from_element(rows, columns, 0.1);
    // f = (x2, -x1) and h = x1 have no constants; Df has 0, 1 and -1, Dh has 0 and 1.
    let free = || plant(&["x2", "-x1"], &["x1"], 0);
    let noises =
        || NoiseModel { w: gain(2, 2) * 0.1 + DMatrix::identity(2, 2), v: dmatrix![0.5], p0: DMatrix::identity(2, 2) };
    let kalman = || ExtendedKalmanFilter::discrete(free(), noises(), 0.1).unwrap();
    let unscented = UnscentedKalmanFilter::discrete(free(), noises(), SigmaPoints::default(), 0.1).unwrap();
    let copy = DiscreteNonlinearObserver::new(free(), gain(2, 1), 0.1).unwrap();
    let filters = 4 + 1 + 4;
    // Numbers of constants with the first estimate, of the state, and their bytes.
    let cases = [
        (plain(of(false, false)), linear + 1 + n, n, 8),
        (single(of(false, false)), linear + 1 + n, n, 4),
        (plain(of(false, true)), linear + p * m + 1 + n, n, 8),
        (plain(of(false, false)).with_feedback(&gain(m, n)).unwrap(), linear + m * n + 1 + n, n, 8),
        // The prediction that the filter keeps begins with the first estimate as well; and its innovation.
        (plain(of(false, false)).with_update(&gain(n, p)).unwrap(), linear + n * p + 1 + n, n + n + p, 8),
        (plain(of(true, false)), cubic + 2 + n, n, 8),
        (plain(compiled::semi_implicit(5, (n, m, p), false)), cubic + p * p + 1 + n, n, 8),
        (plain(ExportableObserver::Kalman(kalman())), filters + 5 + 1 + 2, 2 + 4, 8),
        (plain(ExportableObserver::Kalman(kalman().with_gate(9.0).unwrap())), filters + 5 + 2 + 2, 2 + 4, 8),
        (single(ExportableObserver::Unscented(unscented)), filters + 5 + 2, 2 + 4, 4),
        (plain(ExportableObserver::Discrete(copy)), 2 + 1 + 2, 2, 8),
    ];
    for (k, (export, constants, state, bytes)) in cases.iter().enumerate() {
        assert_eq!(export.bytes(), (constants + state) * bytes, "{k}");
    }
}

/// The arrays over a window of N samples: P, A and the mean (2 n^2 + n), rows, gains and nu/s of p outputs (p (2 n +
/// 1)), the trajectory and the solution (2 n); with b bounds their gains and nu/s (b (n + 1)), slacks and multipliers
/// (2 b), and the step of the interior point (n).
#[test]
fn the_stack_of_a_window_is_counted_by_hand() {
    let window = 4;
    let estimator = || MovingHorizon::new(three(), noises(), Horizon { window, iterations: 2 }, 0.1, 2).unwrap();
    let far = f64::INFINITY;
    let bounded = estimator().with_bounds(dvector![-far, -0.5, -far], dvector![0.4, 0.5, far]).unwrap();
    let of = |estimator, scalar| {
        fuzz::export("p0", ExportableObserver::MovingHorizon(estimator), scalar).stack_of_window().unwrap()
    };
    assert_eq!(of(estimator(), Scalar::Binary64), window * (18 + 3 + 2 * 7 + 6) * 8);
    assert_eq!(of(bounded.clone(), Scalar::Binary64), window * (18 + 3 + 2 * 7 + 6 + 3 * 4 + 2 * 3 + 3) * 8);
    assert_eq!(of(bounded, Scalar::Binary32), window * (18 + 3 + 2 * 7 + 6 + 3 * 4 + 2 * 3 + 3) * 4);
}
