//! Emitted C, compiled by the compilers of the machine and compared with the Rust observer bit by bit. Without a C
//! compiler these tests say so and pass.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use luenberger_export::golden::Stepper;
use luenberger_export::{Export, ExportError, ExportableObserver, ExportedMatrix, Names, Scalar, golden};
use luenberger_expression::{ExpressionPlant, Parameters};
use luenberger_observers::{
    DiscreteLinearObserver, DiscreteNonlinearObserver, ExtendedKalmanFilter, NoiseModel, OutputFeedback,
    SampledCubicGains, SampledCubicObserver, SampledObserver, StationaryKalmanFilter, VaryingPeriodObserver, cubic,
};
use luenberger_plants::StateSpace;
use luenberger_random::Random;
use nalgebra::{DMatrix, DVector, SMatrix, SVector, dmatrix};

/// Whether `EVERY_C_COMPILER` is set, as by `cargo xtask firmware`: every compiler, option and random observer.
/// Otherwise a part of each, since these tests spend their time in compilers.
pub(crate) fn is_complete() -> bool {
    std::env::var_os("EVERY_C_COMPILER").is_some()
}

/// The optimisation of a build whose options are not what is tested.
pub(crate) fn optimisation() -> &'static str {
    if is_complete() { "-O2" } else { "-O1" }
}

/// The C compiler of this machine; in a complete run both gcc and clang.
pub(crate) fn compilers() -> Vec<&'static str> {
    let there = |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success());
    let most = if is_complete() { 2 } else { 1 };
    ["gcc", "clang"].into_iter().filter(there).take(most).collect()
}

pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("export-{name}"));
    _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Compiles the files of an export with these flags and runs the golden test.
#[track_caller]
fn agrees(export: &Export, folder: &Path, compiler: &str, flags: &[&str]) {
    let (good, text) = golden_test(export, folder, compiler, flags);
    assert!(good, "{compiler} {flags:?}: {text}");
    assert!(text.contains("64 of 64 steps agree to the last bit"), "{text}");
}

/// Whether the golden test succeeds, and what it prints.
#[track_caller]
fn golden_test(export: &Export, folder: &Path, compiler: &str, flags: &[&str]) -> (bool, String) {
    for file in export.c().unwrap() {
        std::fs::write(folder.join(file.name), file.text).unwrap();
    }
    let built = Command::new(compiler)
        .current_dir(folder)
        .args(["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Werror"])
        .args(flags)
        .args(["plant.c", "test_plant.c", "-o", "test", "-lm"])
        .output()
        .unwrap();
    assert!(built.status.success(), "{compiler} {flags:?}: {}", String::from_utf8_lossy(&built.stderr));
    let ran = Command::new(folder.join("test")).output().unwrap();
    (ran.status.success(), String::from_utf8_lossy(&[ran.stdout, ran.stderr].concat()).into_owned())
}

pub(crate) const SANITISERS: [&str; 3] = ["-O1", "-fsanitize=undefined,address", "-fno-sanitize-recover=all"];

/// Whether the libraries of the sanitizers are there.
pub(crate) fn can_sanitise(compiler: &str) -> bool {
    static FOUND: Mutex<BTreeMap<String, bool>> = Mutex::new(BTreeMap::new());
    let mut found = FOUND.lock().unwrap();
    *found.entry(compiler.to_owned()).or_insert_with(|| {
        let folder = folder(&format!("empty-{compiler}"));
        std::fs::write(folder.join("empty.c"), "int main(void) { return 0; }\n").unwrap();
        let mut command = Command::new(compiler);
        let built = command.current_dir(folder).args(SANITISERS).args(["empty.c", "-o", "empty"]).output();
        built.is_ok_and(|built| built.status.success())
    })
}

/// Whether this processor runs code for Haswell, which has fused multiply-adds.
pub(crate) fn has_haswell() -> bool {
    #[cfg(target_arch = "x86_64")]
    let there = std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    let there = false;
    there
}

/// An observer of these sizes with entries without pattern. `Ad - Ld C` is small, so that it is stable.
pub(crate) fn program(seed: u64, (n, m, p): (usize, usize, usize), is_cubic: bool, fed: bool) -> ExportableObserver {
    let mut random = Random(seed);
    let mut matrix = |rows, columns, size: f64| random.matrix(rows, columns) * size;
    let (ad, bd, c) = (matrix(n, n, 0.4 / n as f64), matrix(n, m, 1.0), matrix(p, n, 1.0));
    let (ld, d) = (matrix(n, p, 0.4 / (n * p) as f64), matrix(p, m, 1.0));
    if is_cubic {
        let mut gain = matrix(n, p, 1.0);
        // C N = -w I: for one output every N is radial; for several, N = -w C^+.
        if p > 1 {
            gain = c.clone().pseudo_inverse(1e-12).unwrap() * -0.7;
        } else if cubic::rate(&c, &gain) < 0.0 {
            gain = -gain;
        }
        let root = matrix(p, p, 1.0);
        let theta = &root * root.transpose() + DMatrix::identity(p, p);
        let w = cubic::rate(&c, &gain);
        let gains = SampledCubicGains { ad, bd, c, ld, n: gain, theta, w, period: 0.05 };
        let observer = SampledCubicObserver::new(gains).unwrap();
        return ExportableObserver::Cubic(if fed { observer.with_feedthrough(d).unwrap() } else { observer });
    }
    let plant = StateSpace::new(ad, bd, c).unwrap();
    let plant = if fed { plant.with_feedthrough(d).unwrap() } else { plant };
    ExportableObserver::Linear(DiscreteLinearObserver::new(plant, ld, 0.05).unwrap())
}

/// The same plant as of [`program`], with a cubic gain that is not radial.
pub(crate) fn semi_implicit(seed: u64, sizes: (usize, usize, usize), fed: bool) -> ExportableObserver {
    let ExportableObserver::Cubic(radial) = program(seed, sizes, true, fed) else { unreachable!("a cubic observer") };
    let p = sizes.2;
    let turn = DMatrix::from_fn(p, p, |i, j| if i == j { 1.5 } else { 0.4 * (i as f64 - j as f64) });
    let gains = SampledCubicGains {
        ad: radial.ad().clone(),
        bd: radial.bd().clone(),
        c: radial.c().clone(),
        ld: radial.ld().clone(),
        n: radial.n() * turn,
        theta: radial.theta().clone(),
        w: 0.0,
        period: 0.05,
    };
    let coupling = luenberger_observers::semi_implicit::coupling(&gains.c, &gains.n);
    let observer = SampledCubicObserver::semi_implicit(gains, coupling).unwrap();
    ExportableObserver::Cubic(match radial.d() {
        Some(d) => observer.with_feedthrough(d.clone()).unwrap(),
        None => observer,
    })
}

/// The cubic observer of another program at varying periods, whose prediction takes several substeps.
pub(crate) fn varying(nominal: &ExportableObserver) -> ExportableObserver {
    let ExportableObserver::Cubic(nominal) = nominal else { unreachable!("a cubic observer") };
    let n = nominal.ad().nrows();
    let a = nominal.ad() * 5.0 - DMatrix::identity(n, n) * 6.0;
    let (b, k) = (nominal.bd().clone(), nominal.ld().clone());
    let observer = VaryingPeriodObserver::new(nominal.clone(), a, b, k, 0.3).unwrap();
    assert!(observer.substeps() > 1);
    ExportableObserver::varying(&observer).unwrap()
}

/// Golden vectors at varying times, and a prediction that is split.
#[test]
fn the_step_at_varying_periods_gives_the_same_bits() {
    let compilers = compilers();
    if compilers.is_empty() {
        eprintln!("SKIPPED: no C compiler");
    }
    let programs = [
        program(7, (2, 1, 1), true, false),
        program(7, (3, 2, 2), true, true),
        program(7, (2, 0, 1), true, false),
        semi_implicit(11, (3, 2, 2), true),
    ];
    let folder = folder("varying");
    for scalar in [Scalar::Binary32, Scalar::Binary64] {
        for (turn, program) in programs.iter().enumerate() {
            let export = export(varying(program), scalar);
            let steps = golden::steps(&export, 64).unwrap();
            let times: Vec<f64> = steps.iter().map(|step| step.u[export.observer().plant_inputs()]).collect();
            assert!(times.iter().all(|dt| (0.074..0.301).contains(dt)) && times[0] != times[1], "{times:?}");
            for compiler in &compilers {
                let sanitised = can_sanitise(compiler);
                with_options(&export, turn, &folder, compiler, sanitised);
            }
        }
    }
    let export = export(varying(&programs[0]), Scalar::Binary32);
    let header = export.c().unwrap().remove(0).text;
    assert!(header.contains("#define PLANT_INPUTS 1\n"), "{header}");
    let step = "void plant_step(plant_state *state, const float *u, const float *y, float dt, float *xhat);";
    assert!(header.contains(step), "{header}");
    assert!(header.contains("void plant_predict(plant_state *state, const float *u, float dt);"), "{header}");
    assert!(matches!(export.fmu(luenberger_export::fmu::Version::Two), Err(ExportError::VaryingPeriods { .. })));
    assert!(matches!(export.with_feedback(&dmatrix![0.1, 0.1]), Err(ExportError::VaryingPeriods { .. })));
}

/// With one piece of time the series is the zero-order hold: `exp(A t)` and its integral, as scipy 1.17.1
/// `scipy.signal.cont2discrete` gives them for `A = [0 1; -2 -3]`, `B = (0, 1)` and 0.25.
#[test]
fn the_exported_prediction_is_the_zero_order_hold() {
    let gains = SampledCubicGains {
        ad: dmatrix![1.0, 0.0; 0.0, 1.0],
        bd: dmatrix![0.0; 1.0],
        c: dmatrix![1.0, 0.0],
        ld: dmatrix![0.0; 0.0],
        n: dmatrix![0.0; 0.0],
        theta: dmatrix![1.0],
        w: 0.0,
        period: 0.25,
    };
    let nominal = SampledCubicObserver::new(gains).unwrap();
    let (a, b, k) = (dmatrix![0.0, 1.0; -2.0, -3.0], dmatrix![0.0; 1.0], dmatrix![0.0; 0.0]);
    let observer = VaryingPeriodObserver::new(nominal, a, b, k, 0.5).unwrap();
    let program = ExportableObserver::varying(&observer).unwrap();
    let names = Names::numbered(2, 1, 1);
    let export = Export::new("plant", program, Scalar::Binary64, &[1.0, 0.0], names).unwrap();
    let mut stepper = golden::Stepper::new(&export).unwrap();
    let found = stepper.step(&[0.5, 0.25], &[7.0]);
    let expected = [0.963_303_179_822_632_2, -0.258_405_185_038_157_2];
    assert!((found[0] - expected[0]).abs() < 1e-14 && (found[1] - expected[1]).abs() < 1e-14, "{found:?}");
}

pub(crate) fn export(program: ExportableObserver, scalar: Scalar) -> Export {
    let size = program.dimensions();
    let initial: Vec<f64> = (0..size.state).map(|i| 0.1 * i as f64 - 0.3).collect();
    let names = Names::numbered(size.state, program.plant_inputs(), size.outputs);
    Export::new("plant", program, scalar, &initial, names).unwrap()
}

/// The same with a small feedback gain, which leaves the loop stable.
pub(crate) fn with_feedback(export: Export) -> Export {
    let size = export.observer().dimensions();
    let k = DMatrix::from_fn(size.inputs, size.estimate, |i, j| 0.03 * (i as f64 + 1.0) - 0.01 * j as f64);
    export.with_feedback(&k).unwrap()
}

const OPTIONS: [&[&str]; 4] = [&["-O0"], &["-Os"], &["-O2"], &["-O3", "-march=haswell"]];

/// With every option for the first export; the others are built with one of them in turn, and in a complete run also
/// with the sanitizers, otherwise the option or the sanitizers take turns.
#[track_caller]
fn with_options(export: &Export, turn: usize, folder: &Path, compiler: &str, sanitised: bool) {
    let options = &OPTIONS[..if has_haswell() { 4 } else { 3 }];
    let is_sanitised = sanitised && (is_complete() || turn.is_multiple_of(2));
    for (k, flags) in options.iter().enumerate() {
        if turn == 0 || (turn % options.len() == k && (is_complete() || !is_sanitised)) {
            agrees(export, folder, compiler, flags);
        }
    }
    if is_sanitised {
        agrees(export, folder, compiler, &SANITISERS);
    }
}

#[test]
fn optimised_and_sanitised_builds_give_the_same_bits() {
    let compilers = compilers();
    if compilers.is_empty() {
        eprintln!("SKIPPED: no C compiler");
    }
    let folder = folder("flags");
    for compiler in compilers {
        let sanitised = can_sanitise(compiler);
        if !sanitised {
            eprintln!("SKIPPED: {compiler} has no sanitizers here");
        }
        let mut turns = 0..;
        let mut built = |export: &Export| {
            let turn = turns.next().unwrap_or(0);
            with_options(export, turn, &folder, compiler, sanitised);
        };
        for (sizes, is_cubic, fed) in
            [((2, 1, 1), false, false), ((3, 2, 2), true, true), ((2, 0, 1), true, false), ((1, 1, 1), true, false)]
        {
            for scalar in [Scalar::Binary32, Scalar::Binary64] {
                let export = export(program(7, sizes, is_cubic, fed), scalar);
                built(&export);
                // The step of the observer is the same function in the block.
                if sizes.1 > 0 {
                    agrees(&with_feedback(export), &folder, compiler, if sanitised { &SANITISERS } else { &["-O2"] });
                }
            }
        }
        for sizes in [(1, 1, 1), (3, 2, 2), (6, 1, 4)] {
            for scalar in [Scalar::Binary32, Scalar::Binary64] {
                let export = export(semi_implicit(11, sizes, sizes.1 == 2), scalar);
                built(&export);
            }
        }
        for seed in 0..3 {
            let program = crate::fuzz::nonlinear(&mut Random(seed));
            let export = crate::fuzz::export("plant", program, Scalar::Binary64);
            built(&export);
            if export.observer().dimensions().inputs > 0 {
                agrees(&with_feedback(export), &folder, compiler, &[optimisation()]);
            }
        }
    }
}

/// The reference of the golden vectors has sizes known at run time; those of a target are known at compile time.
#[test]
fn sizes_known_at_compile_time_give_the_same_bits() {
    fn compare<const N: usize, const M: usize, const P: usize>(seed: u64) {
        let size = (N, M, P);
        let programs = [false, true].map(|is_cubic| program(seed, size, is_cubic, M > 0));
        for program in programs.into_iter().chain([semi_implicit(seed, size, M > 0)]) {
            let steps = golden::steps(&export(program.clone(), Scalar::Binary64), 200).unwrap();
            let mut xhat = SVector::<f64, N>::from_fn(|i, _| 0.1 * i as f64 - 0.3);
            for step in steps {
                let (u, y) = (SVector::<f64, M>::from_column_slice(&step.u), SVector::from_column_slice(&step.y));
                match &program {
                    ExportableObserver::Linear(o) => {
                        o.to_static::<f64, N, M, P>().unwrap().step(0.0, &mut xhat, &u, &y);
                    }
                    ExportableObserver::Cubic(o) => o.to_static::<f64, N, M, P>().unwrap().step(0.0, &mut xhat, &u, &y),
                    _ => unreachable!("a linear plant"),
                }
                let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(xhat.as_slice()), bits(&step.estimate), "{N} {M} {P}");
            }
        }
    }
    compare::<1, 1, 1>(1);
    compare::<2, 0, 1>(2);
    compare::<3, 2, 2>(3);
    compare::<4, 1, 4>(4);
    compare::<6, 3, 2>(5);
    compare::<8, 1, 3>(6);
}

/// In filter form: emitted C, and the filter of the observers with sizes known at compile time.
#[test]
fn the_filter_form_returns_the_estimate_with_the_measurement_of_its_sample() {
    let filter = |seed, sizes: (usize, usize, usize), scalar| {
        let export = export(program(seed, sizes, false, sizes.1 > 0), scalar);
        export.with_update(&DMatrix::from_fn(sizes.0, sizes.2, |i, j| 0.4 / (1.0 + i as f64) - 0.1 * j as f64)).unwrap()
    };
    let folder = folder("filter-form");
    for compiler in compilers() {
        let sanitised = can_sanitise(compiler);
        let mut turns = 0..;
        for sizes in [(2, 1, 1), (3, 2, 2), (1, 0, 1), (6, 1, 3)] {
            for scalar in [Scalar::Binary32, Scalar::Binary64] {
                with_options(&filter(11, sizes, scalar), turns.next().unwrap_or(0), &folder, compiler, sanitised);
            }
        }
    }
    let export = filter(11, (3, 2, 2), Scalar::Binary64);
    let (ExportableObserver::Linear(predictor), matrices) = (export.observer(), export.matrices()) else {
        unreachable!()
    };
    let (_, k) = matrices.iter().find(|(which, _)| *which == ExportedMatrix::Update).unwrap();
    let predictor = predictor.to_static::<f64, 3, 2, 2>().unwrap();
    let static_filter = StationaryKalmanFilter::new(predictor, SMatrix::from_fn(|i, j| k[(i, j)])).unwrap();
    let mut prediction = SVector::<f64, 3>::from_fn(|i, _| 0.1 * i as f64 - 0.3);
    for step in golden::steps(&export, 200).unwrap() {
        let (u, y) = (SVector::from_column_slice(&step.u), SVector::from_column_slice(&step.y));
        let estimate = static_filter.estimate_at(&prediction, &u, &y);
        static_filter.step(0.0, &mut prediction, &u, &y);
        let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(estimate.as_slice()), bits(&step.estimate));
    }
    let refused = [
        export.clone().with_feedback(&DMatrix::zeros(2, 3)).unwrap_err(),
        export.fixed_point(luenberger_export::FixedPointFormat::new(16, 16).unwrap().into()).unwrap_err(),
        self::export(program(3, (2, 1, 1), true, false), Scalar::Binary64)
            .with_update(&dmatrix![1.0; 0.0])
            .unwrap_err(),
    ];
    for (error, what) in refused.iter().zip(["feedback", "fixed point", "Sampled cubic observer"]) {
        assert!(error.to_string().ends_with(&format!("not with {what}")), "{error}");
    }
    let wrong = self::export(program(3, (2, 1, 1), false, false), Scalar::Binary64);
    let error = wrong.clone().with_update(&dmatrix![1.0, 0.0]).unwrap_err();
    assert_eq!(error.to_string(), "K must be 2 x 1, found 1 x 2");
    let error = wrong.with_update(&dmatrix![f64::INFINITY; 0.0]).unwrap_err();
    assert!(error.to_string().ends_with("of K is beyond the range of f64"), "{error}");
}

#[test]
fn what_cannot_be_exported_is_an_error() {
    let good = program(3, (2, 1, 1), false, false);
    let names = || Names::numbered(2, 1, 1);
    for name in ["", "for", "2nd", "a b", "fn"] {
        let error = Export::new(name, good.clone(), Scalar::Binary64, &[0.0, 0.0], names()).unwrap_err();
        assert!(error.to_string().contains("is not an identifier of C and Rust"), "{error}");
    }
    let error = Export::new("a", good.clone(), Scalar::Binary64, &[0.0], names()).unwrap_err();
    assert_eq!(error.to_string(), "the first estimate has 1 entries where the observer has 2");
    let error = Export::new("a", good, Scalar::Binary32, &[1e39, 0.0], names()).unwrap_err();
    assert_eq!(error.to_string(), "entry 1 of the first estimate is beyond the range of f32");

    let (ad, bd, c) = (dmatrix![0.5, 0.0; 0.0, 0.5], dmatrix![0.0; 1e39], dmatrix![1.0, 0.0]);
    let plant = StateSpace::new(ad, bd, c).unwrap();
    let program = ExportableObserver::Linear(DiscreteLinearObserver::new(plant, dmatrix![0.1; 0.1], 0.1).unwrap());
    let error = Export::new("a", program, Scalar::Binary32, &[0.0, 0.0], names()).unwrap_err();
    assert!(error.to_string().ends_with("is beyond the range of f32"), "{error}");

    // Ad - Ld C has the eigenvalue 3e5: the golden vectors leave the range of binary32.
    let plant = StateSpace::new(dmatrix![3e5], dmatrix![1.0], dmatrix![1.0]).unwrap();
    let program = ExportableObserver::Linear(DiscreteLinearObserver::new(plant, dmatrix![0.0], 0.1).unwrap());
    let unstable = Export::new("a", program, Scalar::Binary32, &[1.0], Names::numbered(1, 1, 1)).unwrap();
    assert!(unstable.c().unwrap_err().to_string().contains("the observer is unstable"));
    assert!(unstable.rust().is_err());
}

/// The golden vectors of the block are those of the block of `observers`, with sizes known at compile time.
#[test]
fn the_block_is_that_of_the_observers() {
    for is_cubic in [false, true] {
        let program = program(13, (3, 2, 2), is_cubic, true);
        let export = with_feedback(export(program.clone(), Scalar::Binary64));
        let k = export.matrices().into_iter().find(|(which, _)| *which == ExportedMatrix::Feedback).unwrap().1;
        let k = SMatrix::<f64, 2, 3>::from_fn(|i, j| k[(i, j)]);
        let mut xhat = SVector::<f64, 3>::from_fn(|i, _| 0.1 * i as f64 - 0.3);
        for step in golden::steps(&export, 100).unwrap() {
            let (r, y) = (SVector::<f64, 2>::from_column_slice(&step.u), SVector::from_column_slice(&step.y));
            let u = match &program {
                ExportableObserver::Linear(o) => {
                    OutputFeedback::new(o.to_static::<f64, 3, 2, 2>().unwrap(), k).unwrap().step(0.0, &mut xhat, &r, &y)
                }
                ExportableObserver::Cubic(o) => {
                    OutputFeedback::new(o.to_static::<f64, 3, 2, 2>().unwrap(), k).unwrap().step(0.0, &mut xhat, &r, &y)
                }
                _ => unreachable!("a linear plant"),
            };
            let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(xhat.as_slice()), bits(&step.estimate));
            assert_eq!(bits(u.as_slice()), bits(&step.applied));
        }
    }
    let export = export(program(13, (3, 2, 2), false, false), Scalar::Binary32);
    let error = export.clone().with_feedback(&DMatrix::zeros(3, 2)).unwrap_err();
    assert_eq!(error.to_string(), "K must be 2 x 3, found 3 x 2");
    let error = export.with_feedback(&DMatrix::from_element(2, 3, 1e39)).unwrap_err();
    assert!(error.to_string().ends_with("of K is beyond the range of f32"), "{error}");
}

/// With the functions of the C library of this machine the golden test agrees to half of the digits, and notices
/// another function; the observer has none of its own, and its header says what is lost.
#[test]
fn the_functions_of_the_target_are_called() {
    let compilers = compilers();
    if compilers.is_empty() {
        eprintln!("SKIPPED: no C compiler");
    }
    for (scalar, name) in [(Scalar::Binary32, "sinf"), (Scalar::Binary64, "sin")] {
        let folder = folder(&format!("target-{name}"));
        let own = crate::fuzz::export("plant", pendulum(), scalar);
        let of_target = own.clone().with_functions_of_target();
        let files = of_target.c().unwrap();
        let text = |name: &str| &files.iter().find(|file| file.name == name).unwrap().text;
        let (c, header) = (text("plant.c"), text("plant.h"));
        assert!(c.contains(&format!("= {name}(")) && !c.contains(&format!("plant_{name}(")), "{c}");
        let lost = "not those of the design to the last bit, and no bound and no comparison counts the errors";
        let header = header.replace("\n *", "");
        assert!(header.contains(lost) && !header.contains("The results are those of"), "{header}");
        assert!(text("README.md").contains("to half of the digits"));
        // Other results are another export.
        assert_ne!(of_target.digest(), own.digest());
        for compiler in &compilers {
            let (good, text) = golden_test(&of_target, &folder, compiler, &[]);
            assert!(good && text.contains("64 of 64 steps agree to half of the digits"), "{text}");
            let other = format!("-D{name}={}", name.replace("sin", "tan"));
            assert!(!golden_test(&of_target, &folder, compiler, &[&other]).0);
        }
        assert!(own.c().unwrap().iter().any(|file| file.text.contains(&format!("plant_{name}("))));
        let linear = export(program(3, (2, 1, 1), false, false), scalar);
        assert_eq!(linear.clone().with_functions_of_target().c().unwrap(), linear.c().unwrap());
        let refused = own.fixed_point(luenberger_export::FixedPointFormat::new(8, 16).unwrap().into()).unwrap_err();
        assert!(refused.to_string().ends_with("not for the extended Kalman filter"), "{refused}");
    }
}

/// A filter of a pendulum.
fn pendulum() -> ExportableObserver {
    let plant = crate::moving_horizon::plant(&["x2", "-9.81*sin(x1) - 0.1*x2 + u1"], &["x1"], 1);
    let (one, two) = (DMatrix::from_element(1, 1, 0.05), DMatrix::from_diagonal_element(2, 2, 0.1));
    let noises = NoiseModel { w: two.clone(), v: one, p0: two };
    ExportableObserver::Kalman(ExtendedKalmanFilter::new(plant, noises, 0.1, 2).unwrap())
}

/// A linear observer with an output that is not finite is the one without its column of the gain, whatever that output
/// is; without any output it is the plant. An input that is not finite spoils the estimate for good.
#[test]
fn a_missing_output_leaves_its_column_of_the_gain_out() {
    let ExportableObserver::Linear(observer) = program(5, (3, 1, 2), false, true) else { unreachable!("linear") };
    let without = |columns: &[usize]| {
        let mut l = observer.l().clone();
        for column in columns {
            l.column_mut(*column).fill(0.0);
        }
        DiscreteLinearObserver::new(observer.plant().clone(), l, 0.05).unwrap()
    };
    let (start, u) = (DVector::from_column_slice(&[0.3, -0.2, 0.7]), DVector::from_element(1, 0.1));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for missing in [&[0][..], &[1], &[0, 1]] {
            let y = DVector::from_fn(2, |i, _| if missing.contains(&i) { bad } else { 0.5 - i as f64 });
            let mut found = start.clone();
            observer.step(0.0, &mut found, &u, &y);
            let mut expected = start.clone();
            without(missing).step(
                0.0,
                &mut expected,
                &u,
                &DVector::from_element(2, 17.0).zip_map(&y, |other, y| if y.is_finite() { y } else { other }),
            );
            assert_eq!(found, expected, "{bad}, {missing:?}");
            // The same of outputs that are said to be missing, whatever stands there.
            let measured: Vec<bool> = (0..2).map(|i| !missing.contains(&i)).collect();
            let mut said = start.clone();
            observer.step_partial(0.0, &mut said, &u, &y.map(|y| if y.is_finite() { y } else { 1e3 }), &measured);
            assert_eq!(found, said, "{bad}, {missing:?}");
        }
    }
    let mut spoiled = start.clone();
    observer.step(0.0, &mut spoiled, &DVector::from_element(1, f64::NAN), &DVector::from_element(2, 0.5));
    observer.step(0.0, &mut spoiled, &u, &DVector::from_element(2, 0.5));
    assert!(spoiled.iter().all(|x| x.is_nan()), "{spoiled}");
}

/// What headers say of a missing output, with one output and with several.
#[test]
fn the_header_says_what_a_missing_output_does() {
    for (sizes, said) in [((3, 1, 2), "its column of the gain is left out"), ((2, 0, 1), "the step then only predicts")]
    {
        for is_cubic in [false, true] {
            let header = export(program(3, sizes, is_cubic, false), Scalar::Binary64).c().unwrap().remove(0).text;
            let text = header.replace("\n *", "");
            assert!(text.contains(said) && text.contains("Nothing is proved of such a sample"), "{text}");
            assert!(
                text.contains("A value of u that is not finite makes the estimate not finite, for good."),
                "{text}"
            );
            assert!(text.contains("so large that a sum leaves the range of double: call plant_reset"), "{text}");
        }
    }
}

/// The time in binary32 is the number of the sample times the period, both rounded: the header states by how much.
#[test]
fn the_time_in_binary32_is_rounded_as_stated() {
    let plant = crate::moving_horizon::plant(&["x2", "-x1 - x2 + sin(t)"], &["x1"], 0);
    let copy = luenberger_observers::SampledNonlinearObserver::new(plant, dmatrix![1.0; 0.5], 0.1, 2).unwrap();
    for (scalar, is_said) in [(Scalar::Binary32, true), (Scalar::Binary64, false)] {
        let header = export(ExportableObserver::SampledNonlinear(copy.clone()), scalar).c().unwrap()[0].text.clone();
        assert!(header.contains("uint64_t sample;"), "{header}");
        assert_eq!(header.contains("rounded by up to 1.8e-7 of itself"), is_said, "{header}");
    }
    let mut random = Random(3);
    let mut largest = 0.0_f64;
    for _ in 0..100_000 {
        let (sample, period) = (random.below(1 << 40), random.unit().abs() + 1e-3);
        let time = f64::from(sample as f32 * period as f32);
        largest = largest.max((time / (sample as f64 * period) - 1.0).abs());
    }
    assert!((1.2e-7..1.8e-7).contains(&largest), "{largest:e}");
}

/// A finite output can lose the estimate for good: by an overflow, or where it takes it to the root of a negative
/// number. The header says so.
#[test]
fn the_header_says_which_finite_values_lose_the_estimate() {
    let lost = |export: &Export, y: f64| {
        let mut stepper = golden::Stepper::new(export).unwrap();
        stepper.step(&[], &[y]);
        (0..100).for_each(|_| drop(stepper.step(&[], &[0.6])));
        stepper.estimate().iter().any(|x| !x.is_finite())
    };
    let said = |export: &Export| export.c().unwrap()[0].text.replace("\n *", "");
    // A - L C = 0.1.
    let plant = StateSpace::new(dmatrix![6.0], DMatrix::zeros(1, 0), dmatrix![1.0]).unwrap();
    let observer = DiscreteLinearObserver::new(plant, dmatrix![5.9], 0.1).unwrap();
    let linear = ExportableObserver::Linear(observer);
    let names = || Names::numbered(1, 0, 1);
    for (scalar, large) in [(Scalar::Binary32, 3e38), (Scalar::Binary64, 1.7e308)] {
        let export = Export::new("plant", linear.clone(), scalar, &[0.5], names()).unwrap();
        assert!(lost(&export, large) && !lost(&export, 0.7), "{scalar:?}");
        assert!(said(&export).contains("so large that a sum leaves the range of"), "{}", said(&export));
    }
    let tank = crate::moving_horizon::plant(&["-sqrt(x1)"], &["x1"], 0);
    let copy = luenberger_observers::SampledNonlinearObserver::new(tank, dmatrix![1.0], 0.1, 2).unwrap();
    let export = Export::new("plant", ExportableObserver::SampledNonlinear(copy), Scalar::Binary64, &[0.5], names());
    let export = export.unwrap().samples(vec![(vec![], vec![0.6]); 3]);
    assert!(lost(&export, -20.0) && !lost(&export, 0.7));
    assert!(said(&export).contains("to where the plant has no finite result"), "{}", said(&export));
}

/// A name of several lines is one line of the comment at the head, whichever way its lines end.
#[test]
fn a_name_cannot_end_a_line_of_a_comment() {
    for end in ["\n", "\r\n", "\r"] {
        let mut names = Names::numbered(2, 1, 1);
        names.states[1] = format!("b{end}#error");
        names.inputs[0] = format!("u{end}#error");
        names.outputs[0] = format!("y{end}#error");
        names.units = vec![format!("m{end}#error"), String::new()];
        names.time_unit = format!("s{end}#error");
        let export = Export::new("plant", program(9, (2, 1, 1), true, false), Scalar::Binary32, &[0.0, 0.0], names);
        let export = export.unwrap().source(&format!("a{end}#error"), "0123");
        let header = &export.c().unwrap()[0].text;
        let (comment, code) = header.split_once("*/").unwrap();
        assert_eq!(comment.matches("#error").count(), 6, "{header}");
        // As a text: the octal digits of its bytes.
        let escaped = if end == "\r\n" {
            "\\015\\012"
        } else if end == "\n" {
            "\\012"
        } else {
            "\\015"
        };
        assert!(code.contains(&format!("#define PLANT_STATE_NAMES {{ \"x1\", \"b{escaped}#error\" }}\n")), "{header}");
        let head = header.lines().skip(1).take_while(|line| line.trim() != "*/");
        for line in head {
            assert!(line.starts_with(" *") && !line.contains('\r'), "{end:?} in {line:?} of {header}");
        }
    }
}

/// The numbers of xorshift64* from 0x9e3779b97f4a7c15, as Python computes them with integers: the high 53 bits of the
/// product as a fraction of 4, less 2.
const NOISE: [f64; 6] = [
    -1.7888365065659673,
    -0.6755188759925859,
    0.6292694229649958,
    -0.04015838397581817,
    0.2632348291847082,
    0.4672124529510362,
];

/// Inputs and outputs are the numbers of the generator in their order; without samples of a nonlinear plant they are a
/// twentieth of it, and the outputs are added to those that the estimate predicts.
#[test]
fn golden_vectors_are_those_of_the_generator() {
    let linear = golden::steps(&export(program(13, (3, 1, 2), false, false), Scalar::Binary64), 2).unwrap();
    let numbers: Vec<f64> = linear.iter().flat_map(|step| [&step.u[..], &step.y[..]].concat()).collect();
    assert_eq!(numbers, NOISE);
    let plant = ExpressionPlant::new(&["x2", "-x1 + u1"], &["x1*x2"], 1, &Parameters::new()).unwrap();
    let copy = DiscreteNonlinearObserver::new(plant, dmatrix![0.1; 0.1], 0.1).unwrap();
    let export = export(ExportableObserver::Discrete(copy), Scalar::Binary64);
    let mut stepper = Stepper::new(&export).unwrap();
    let mut noise = NOISE.into_iter().map(|x| 0.05 * x);
    for step in golden::steps(&export, 3).unwrap() {
        let (u, more) = (noise.next().unwrap(), noise.next().unwrap());
        let [x1, x2] = stepper.estimate()[..] else { panic!("two states") };
        assert_eq!((&step.u[..], &step.y[..]), (&[u][..], &[x1 * x2 + more][..]));
        // xhat+ = f(xhat, u) + L (y - h(xhat)).
        let (next, expected) = (stepper.step(&step.u, &step.y), [x2 + 0.1 * more, -x1 + u + 0.1 * more]);
        assert!(next.iter().zip(expected).all(|(x, expected)| (x - expected).abs() < 1e-15), "{next:?} {expected:?}");
        assert_eq!((&next, &stepper.estimate()), (&step.estimate, &step.estimate));
    }
}

/// What a file is of stands at its head, and is the type that its crate builds on.
#[test]
fn the_files_of_a_linear_observer_and_of_its_filter_form_say_which_they_are() {
    let predictor = export(program(11, (2, 1, 1), false, false), Scalar::Binary64);
    let filter = predictor.clone().with_update(&dmatrix![0.4; 0.2]).unwrap();
    for (export, kind, block) in [
        (predictor, "Sampled linear observer", "StaticDiscreteLinearObserver"),
        (filter, "Stationary Kalman filter", "StaticStationaryKalmanFilter"),
    ] {
        let header = &export.c().unwrap()[0].text;
        assert!(header.contains(kind), "{header}");
        let files = export.rust().unwrap();
        let text = |name: &str| &files.iter().find(|file| file.name == name).unwrap().text;
        assert!(text("README.md").contains(kind), "{}", text("README.md"));
        assert!(text("src/lib.rs").contains(block), "{}", text("src/lib.rs"));
        assert_eq!(text("src/lib.rs").contains("StationaryKalmanFilter"), block.contains("Kalman"));
    }
}

/// A filter says what it does with a measurement that is not finite; with a gate that is another sentence.
#[test]
fn the_header_of_a_filter_says_what_happens_to_a_bad_measurement() {
    let header = |outputs: &[&str]| {
        let plant = ExpressionPlant::new(&["x2", "-x1"], outputs, 0, &Parameters::new()).unwrap();
        let v = DMatrix::identity(outputs.len(), outputs.len());
        let noises = NoiseModel { w: DMatrix::identity(2, 2), v, p0: DMatrix::identity(2, 2) };
        let filter = ExtendedKalmanFilter::new(plant, noises, 0.1, 1).unwrap();
        let export = crate::fuzz::export("plant", ExportableObserver::Kalman(filter), Scalar::Binary64);
        let text = export.c().unwrap()[0].text.clone();
        text.replace("\n *", "")
    };
    let (one, two) = (header(&["x1"]), header(&["x1", "x2"]));
    let (passed, partial) = ("A sample with a value of y that is not finite is passed over", "counts as not measured");
    assert!(one.contains(passed) && !one.contains(partial), "{one}");
    assert!(two.contains(partial) && !two.contains(passed), "{two}");
}

/// Most inputs and outputs have a magnitude up to 2, which no column leaves that is a hundred times smaller; one in
/// sixteen steps has one up to 2000, where sums round differently.
#[test]
fn some_golden_vectors_of_a_linear_plant_are_large() {
    for scalar in [Scalar::Binary32, Scalar::Binary64] {
        let steps = golden::steps(&export(program(13, (3, 2, 2), false, false), scalar), 64).unwrap();
        let largest = |step: &golden::Step| step.u.iter().chain(&step.y).fold(0.0, |most: f64, x| most.max(x.abs()));
        let (large, usual): (Vec<_>, Vec<_>) = (0..64).partition(|k| k % 16 == 7);
        assert!(usual.iter().all(|&k| largest(&steps[k]) <= 2.0));
        assert!(large.iter().all(|&k| (20.0..=2000.0).contains(&largest(&steps[k]))));
        assert_eq!(large.len(), 4);
    }
}

#[test]
fn names_cannot_end_a_comment() {
    let mut names = Names::numbered(2, 1, 1);
    names.states = vec!["a */ int x; /*".to_owned(), "b\n#error".to_owned()];
    names.units = vec!["m".to_owned(), String::new()];
    names.input_units = vec!["N".to_owned()];
    names.output_units = vec!["V */".to_owned()];
    let sentences = ["proved */ or not".to_owned()];
    let export = Export::new("plant", program(9, (2, 1, 1), true, false), Scalar::Binary32, &[0.0, 0.0], names);
    let export = export.unwrap().statement(&sentences).source("a */ study", "0123");
    let header = &export.c().unwrap()[0];
    assert!(!header.text.contains("a */") && !header.text.contains("proved */"), "{}", header.text);
    let columns: Vec<&str> = header.text.lines().filter(|line| line.contains("s: ")).collect();
    assert!(columns.iter().any(|line| line.contains("Inputs:  u1 (N)")), "{columns:?}");
    assert!(columns.iter().any(|line| line.contains("Outputs: y1 (V")), "{columns:?}");
    assert!(!header.text.contains("()"), "{}", header.text);
    assert!(
        header.text.contains(r#"#define PLANT_STATE_NAMES { "a \052/ int x; /\052", "b\012#error" }"#),
        "{}",
        header.text
    );
    if let Some(compiler) = compilers().into_iter().next() {
        agrees(&export, &folder("comments"), compiler, &[optimisation()]);
    }
}
