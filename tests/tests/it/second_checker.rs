//! Two independent checkers of certificate files: `luenberger-verify`, and `tests/second_checker` in Python. Both
//! accept the files of the examples, the templates and the papers; of changed files, neither accepts one that the other
//! refutes.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use luenberger_design::kkl::error_bound;
use luenberger_design::lipschitz::{LipschitzPlant, Sector};
use luenberger_design::mean_value::{ContractingCoordinates, MeanValueDesign};
use luenberger_design::robust::{PolytopicDesign, certify_gain};
use luenberger_design::{
    Certified, CubicDesign, CubicGain, DecoupledPlant, DiscreteDesign, DiscreteLpvDesign, DisturbanceBounds,
    ErrorBound, ErrorCoordinates, FeedbackDesign, GainOptions, GeneralizedPlant, IntervalDesign, IntervalRequirements,
    JacobianEnclosure, LinearDesign, LipschitzDesign, LpvDesign, NormFilterDesign, NormTarget, Periods,
    ReducedOrderDesign, Region, SampledCubicDesign, SampledIntervalDesign, SuperTwistingDesign, SystemNorm, Theorem1,
    TimeDomain, Uncertainty, UnknownInputDesign, VaryingPeriodDesign, at_varying_periods, cubic_lmi_design,
    deployed_linear, theta_from_importance,
};
use luenberger_linalg::lqr;
use luenberger_lmi::{Problem, he, sdpa};
use luenberger_plants::{CukConverter, StateSpace, VanDerPol, flexible_joint, third_order};
use luenberger_proof::certificate::{
    CertificateFile, CubicConvergence, CubicStep, Definiteness, Equation, HurwitzStability, LinearConvergence,
    PlantMatrices, PlantWithin, Rejection, SchurStability, Sign, StructuredCubicConvergence, Theorem,
    VaryingPeriodConvergence, digest, verify,
};
use luenberger_proof::statement::{Format, Formats, Operation, Step};
use luenberger_proof::{Interval, Matrix, Verdict};
use luenberger_random::Random;
use luenberger_study::{Study, TEMPLATES};
use luenberger_tests::kkl_maps::{bound, converter, duffing, exponential_cascade, region, van_der_pol};
use luenberger_tests::solution_certificate;
use nalgebra::{DMatrix, dmatrix};
use serde_json::Value;

use crate::examples::example_1;

/// A folder of its own, empty.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("second_checker").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// What the second checker says of a file.
#[derive(Debug, Clone, PartialEq)]
enum Second {
    Proved,
    /// The file is malformed, or a fact is false.
    Refuted(String),
    /// No proof was found.
    NotShown(String),
}

/// The second checker on these files, in their order; `None` where there is no Python to run it.
fn second(files: &[PathBuf]) -> Option<Vec<Second>> {
    let checker = Path::new(env!("CARGO_MANIFEST_DIR")).join("second_checker").join("check.py");
    let version = Command::new("python3").args(["-c", "import sys; sys.exit(sys.version_info < (3, 10))"]).status();
    if !version.as_ref().is_ok_and(std::process::ExitStatus::success) {
        eprintln!("SKIPPED: the second checker needs python3, version 3.10 or later ({version:?})");
        return None;
    }
    let output = Command::new("python3").arg("-B").arg(&checker).args(files).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), files.len(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    let one = |(path, line): (&PathBuf, &str)| {
        let said = line.strip_prefix(&format!("{}: ", path.display())).unwrap_or_else(|| panic!("{line}"));
        match said.strip_prefix("Rejected: ") {
            None if said == "Proved" => Second::Proved,
            None => Second::Refuted(said.to_owned()),
            Some(why) if why.starts_with("not shown: ") => Second::NotShown(why.to_owned()),
            Some(why) => Second::Refuted(why.to_owned()),
        }
    };
    Some(files.iter().zip(lines).map(one).collect())
}

fn linear(plant: &StateSpace) -> LinearDesign {
    let poles: Vec<f64> = (0..plant.a.nrows()).map(|k| -1.0 - 0.4 * k as f64).collect();
    LinearDesign::with_poles(plant, &poles).unwrap()
}

/// The observers of the cubic paper, of the examples, and the theorems that they leave out.
fn of_linear_plants() -> Vec<CertificateFile> {
    let (plant, example1, cubic) = example_1();
    let joint = cubic_lmi_design(&plant, &dmatrix![1.0], 0.7, 1.0).unwrap();
    let k = lqr(&plant.a, &plant.b, &DMatrix::identity(2, 2), &DMatrix::identity(1, 1)).unwrap().k;
    let feedback = FeedbackDesign::cubic(&cubic, &k).unwrap();
    let step = dmatrix![0.01, 0.0; 0.02, -0.01];
    let polytope = PolytopicDesign::new(&plant, &[&plant.a - &step, &plant.a + &step], 0.3).unwrap();
    let third = third_order::example3().to_dynamic();
    let l = dmatrix![0.267; -1.429; 3.904];
    let gain = certify_gain(&third, &l, &(&l * -10.0)).unwrap();
    // P N = -C' in integers.
    let (l, n, p) = (dmatrix![3.0; 3.0], dmatrix![-1.0; -1.0], dmatrix![2.0, -1.0; -1.0, 1.0]);
    let theorem1 = Theorem1::examine(&plant, &l, &n, &dmatrix![1.0], &p).unwrap();
    // A weight that ignores an output: convergence from an ellipsoid.
    let blind = StateSpace::new(
        dmatrix![0.1, 1.0, 0.0; 0.0, 0.2, 1.0; -1.0, 0.0, 0.3],
        DMatrix::zeros(3, 0),
        dmatrix![1.0, 0.0, 0.0; 0.0, 0.0, 1.0],
    )
    .unwrap();
    let theta = theta_from_importance(&[1.0, 0.0]).unwrap();
    let blind = CubicDesign::new(&linear(&blind), &theta, &CubicGain::Gamma(1.0)).unwrap();
    let sampled = SampledCubicDesign::new(&example1, &dmatrix![1.0], 10.0, 1e-3).unwrap();
    let two = StateSpace::new(DMatrix::identity(2, 2) * 0.3, DMatrix::zeros(2, 0), DMatrix::identity(2, 2)).unwrap();
    let general = CubicGain::General(dmatrix![2.0, 1.0; -1.0, 0.5]);
    let semi_implicit =
        SampledCubicDesign::with_cubic_gain(&linear(&two), &DMatrix::identity(2, 2), &general, 0.1).unwrap();
    let mut files: Vec<CertificateFile> = [
        &example1 as &dyn Certified,
        &cubic,
        &joint,
        &feedback,
        &polytope,
        &gain,
        &theorem1,
        &blind,
        &sampled,
        &semi_implicit,
    ]
    .map(|design| design.certificate_file("a design").unwrap())
    .into();
    let of = GeneralizedPlant { e: dmatrix![0.0, 0.0; 1.0, 0.0], d: dmatrix![0.0, 0.1], h: dmatrix![1.0, 0.5] };
    for (time, norm) in [
        (TimeDomain::Continuous, SystemNorm::HInfinity),
        (TimeDomain::Discrete, SystemNorm::HInfinity),
        (TimeDomain::Continuous, SystemNorm::H2),
        (TimeDomain::Discrete, SystemNorm::H2),
    ] {
        let found = NormFilterDesign::new(&plant, time, norm, &of, &NormTarget::Below(3.0), &GainOptions::default());
        files.push(found.unwrap().certificate_file("a filter").unwrap());
    }
    let reduced = ReducedOrderDesign::with_poles(&third, &[-1.0, -2.0]).unwrap();
    files.push(reduced.certificate_file("a reduced-order observer").unwrap());
    let held = DiscreteDesign::sampled(&example1, 0.1).unwrap();
    let acting = DisturbanceBounds::of_states_and_outputs(&dmatrix![0.0; 1.0], &[0.5], &[0.1]);
    files.push(ErrorBound::discrete(&held.observer, &acting).unwrap().certificate_file("at samples").unwrap());
    let fast = DiscreteDesign::with_decay_rate(held.observer.plant(), 0.1, 3.0).unwrap();
    files.push(fast.certificate_file("with a factor").unwrap());
    let periods = Periods { shortest: 0.08, longest: 0.13, misses: 1 };
    for correction in [CubicGain::Radial(10.0), CubicGain::Gamma(3.0)] {
        let varying = VaryingPeriodDesign::new(&example1, &dmatrix![1.0], &correction, 0.1, &periods).unwrap();
        files.push(varying.certificate_file("varying periods").unwrap());
        files
            .push(CertificateFile::prove("linear", at_varying_periods(&plant, &varying.k, &periods).unwrap()).unwrap());
    }
    let Theorem::CubicConvergence(CubicConvergence { plant, l, theta, p, s, rate, .. }) = files[7].theorem().clone()
    else {
        panic!("{}", files[7].theorem().name())
    };
    let structured = StructuredCubicConvergence { plant, l, theta, p, s, rate };
    files.push(CertificateFile::prove("the real gain", structured).unwrap());
    files.extend(under_disturbances(&example1, &cubic));
    files.extend(without_disturbance());
    files.extend(enclosing());
    for (k, bound) in [([2.1, 1.1], 1.0), ([7.0, 9.0], 5.0)] {
        files.push(SuperTwistingDesign::new(k, bound).unwrap().unwrap().certificate_file("super-twisting").unwrap());
    }
    files.push(sampled.linear_certificate_file("sampled, linear").unwrap());
    files
}

/// Interval observers: modal coordinates with a complex pair, the plant's coordinates, and sampled in both formats.
fn enclosing() -> Vec<CertificateFile> {
    let plant = StateSpace::new(dmatrix![-1.0, 2.0; -4.0, -2.0], dmatrix![0.0; 5.0], dmatrix![1.0, 0.0]).unwrap();
    let acting = DisturbanceBounds::of_states_and_outputs(&dmatrix![1.0; 0.0], &[0.3], &[0.05]);
    let first = [1.0, 1.0];
    let poles = [nalgebra::Complex::new(-4.0, 3.0), nalgebra::Complex::new(-4.0, -3.0)];
    let linear = LinearDesign::with_poles(&plant, &poles).unwrap();
    let modal = IntervalDesign::new(&linear.observer, &acting, ErrorCoordinates::Modal, &first).unwrap();
    let least = IntervalDesign::least_width(&plant, &acting, &first).unwrap();
    let mut files = vec![modal.certificate_file("modal").unwrap(), least.certificate_file("least width").unwrap()];
    let discrete = DiscreteDesign::sampled(&linear, 0.05).unwrap();
    for format in [Format::Binary32, Format::Binary64] {
        let kept =
            IntervalRequirements { initial_error: first.to_vec(), estimates: vec![3.0; 2], inputs: vec![1.0], format };
        let (l, modal) = (discrete.l(), ErrorCoordinates::Modal);
        let held = SampledIntervalDesign::sampled(&plant, 0.05, l, &acting, modal, &kept).unwrap();
        let sampled = discrete.observer.plant();
        let exact = SampledIntervalDesign::of_discrete(sampled, 0.05, l, &acting, modal, &kept).unwrap();
        files.extend([held.certificate_file("held").unwrap(), exact.certificate_file("discrete").unwrap()]);
    }
    files
}

/// Unknown-input observers of a plant with two outputs: linear and cubic, of a disturbance in the outputs, of samples.
fn without_disturbance() -> [CertificateFile; 4] {
    let plant = StateSpace::new(
        dmatrix![0.0, 1.0, 0.3; -1.0, -0.4, 0.1; 0.2, 0.0, -0.7],
        DMatrix::zeros(3, 0),
        dmatrix![1.0, 0.0, 0.1; 0.0, 0.7, 0.0],
    )
    .unwrap();
    let decoupled = DecoupledPlant::new(&plant, &dmatrix![0.3; 1.0; 0.0]).unwrap();
    let design = LinearDesign::lmi(&decoupled.reduced).unwrap();
    let cubic = CubicDesign::new(&design, &DMatrix::identity(2, 2), &CubicGain::Gamma(2.0)).unwrap();
    let (e, f) = (dmatrix![0.3; 1.0; 0.0], dmatrix![0.5; 1.0]);
    let fed = DecoupledPlant::of_outputs(&plant, &e, &f, TimeDomain::Continuous).unwrap();
    let of_outputs = LinearDesign::lmi(&fed.reduced).unwrap();
    let slow = StateSpace::new(&plant.a / 4.0, plant.b.clone(), plant.c.clone()).unwrap();
    let samples = DecoupledPlant::of_outputs(&slow, &e, &f, TimeDomain::Discrete).unwrap();
    let at_samples = DiscreteDesign::kalman(&samples.reduced, 1.0, &DMatrix::identity(3, 3), &DMatrix::identity(2, 2));
    [
        UnknownInputDesign::linear(&decoupled, &design).unwrap().certificate_file("unknown input").unwrap(),
        UnknownInputDesign::cubic(&decoupled, &cubic).unwrap().certificate_file("unknown input").unwrap(),
        UnknownInputDesign::linear(&fed, &of_outputs).unwrap().certificate_file("of the outputs").unwrap(),
        UnknownInputDesign::discrete(&samples, &at_samples.unwrap()).unwrap().certificate_file("of samples").unwrap(),
    ]
}

/// Bounds of the error under disturbances: linear, cubic, with two outputs, and of an uncertain plant.
fn under_disturbances(example1: &LinearDesign, cubic: &CubicDesign) -> [CertificateFile; 4] {
    let e = dmatrix![0.0; 1.0];
    let acting = DisturbanceBounds::of_states_and_outputs(&e, &[0.5], &[0.1]);
    let two = StateSpace::new(
        dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; -1.0, -2.0, 0.5],
        DMatrix::zeros(3, 0),
        dmatrix![1.0, 0.0, 0.0; 0.0, 0.3, 1.0],
    )
    .unwrap();
    let both = CubicDesign::new(&linear(&two), &DMatrix::identity(2, 2), &CubicGain::Gamma(3.0)).unwrap();
    let noise = DisturbanceBounds::of_outputs(3, &[0.2, 0.01]);
    let o = &cubic.observer;
    // x2 is at most 2, and multiplies a number of at most 0.1 in the equation of x2.
    let uncertain = DisturbanceBounds::of_states_and_outputs(&dmatrix![0.0, 0.0; 1.0, 0.1], &[0.5, 2.0], &[0.1]);
    let vertices = [-1.0, 1.0].map(|sign| {
        let mut e = uncertain.e.clone();
        e[(1, 1)] *= sign;
        (o.a.clone(), e)
    });
    let term = Some((&o.n, &o.theta, &cubic.p));
    [
        ErrorBound::linear(&example1.observer, &acting).unwrap(),
        ErrorBound::cubic(cubic, &acting).unwrap(),
        ErrorBound::cubic(&both, &noise).unwrap(),
        ErrorBound::polytope(&vertices, (&o.l, &o.c), term, &uncertain).unwrap(),
    ]
    .map(|bound| bound.certificate_file("under disturbances").unwrap())
}

fn of_nonlinear_plants() -> Vec<CertificateFile> {
    let lpv = LpvDesign::new(flexible_joint::classical(), &Region::everywhere(4), 1.0).unwrap();
    // Van der Pol's right-hand side, read as the next state.
    let square = Region::new(&[(-1.0, 1.0), (-1.0, 1.0)]);
    let discrete = DiscreteLpvDesign::new(VanDerPol { mu: 0.1 }, 0.5, &square, 0.1, &GainOptions::default()).unwrap();
    let a = DMatrix::from_column_slice(4, 4, flexible_joint::classical().linear_part().as_slice());
    let vertices = [-3.33, 3.33].map(|slope| {
        let mut vertex = a.clone();
        vertex[(3, 2)] += slope;
        vertex
    });
    let mean_value = MeanValueDesign::new(&vertices, 2, 1.0).unwrap();
    let sine = Sector::structured(dmatrix![0.0; 0.0; 0.0; 1.0], dmatrix![0.0, 0.0, 1.0, 0.0], 3.33);
    let sectors = LipschitzPlant::new(a, DMatrix::identity(2, 4), vec![sine]).unwrap();
    let lipschitz = LipschitzDesign::new(&sectors, 1.0).unwrap();
    // x1' = x2 - x1/3, y = x1/3: a third is known between two numbers.
    let between = |lo, hi| Interval::new(lo, hi).unwrap();
    let (third, above, zero) = (1.0 / 3.0f64, (1.0 / 3.0f64).next_up(), between(0.0, 0.0));
    let enclosure = JacobianEnclosure {
        a: Matrix::from_rows([[between(-above, -third), between(1.0, 1.0)], [between(-1.0, 1.0), zero]]),
        c: Matrix::from_rows([[between(third, above), zero]]),
        parts: 1,
        excess: 0.0,
        branches: None,
    };
    let enclosed = LipschitzDesign::new(&LipschitzPlant::over(&enclosure).unwrap(), 0.5).unwrap();
    let coordinates = ContractingCoordinates::new(&[dmatrix![-3.0, 2.0; -2.0, 1.0]], 1, 0.5).unwrap();
    [&lpv as &dyn Certified, &discrete, &mean_value, &lipschitz, &enclosed, &coordinates]
        .map(|design| design.certificate_file("a design").unwrap())
        .into()
}

fn of_targets() -> Vec<CertificateFile> {
    let plant = third_order::example3().to_dynamic();
    let design = SampledCubicDesign::new(&linear(&plant), &dmatrix![1.0], 2.0, 0.1).unwrap();
    let o = &design.observer;
    let sampled = StateSpace::new(o.ad().clone(), o.bd().clone(), o.c().clone()).unwrap();
    let (state, input) = (vec![2.0; 3], vec![1.0; plant.b.ncols()]);
    let meets = Operation { state, input, noise: vec![1e-3], error: vec![2.0; 3], deviation: None };
    let fixed = Format::Fixed { integer_bits: 14, fraction_bits: 30 };
    let mut files = vec![];
    // A plant that deviates from its A and B.
    let stiffness = Uncertainty::Polytope(vec![dmatrix![0.0, 0.0, 0.0; 0.01, 0.0, 0.0; 0.0, 0.02, 0.0]]);
    let deviation = Some(stiffness.sampled(&plant, 0.1).unwrap());
    let uncertain = Operation { deviation, ..meets.clone() };
    for step in [Step::Innovation, Step::Joined] {
        let found = deployed_linear(&sampled, o.ld(), step, Format::Binary32.into(), &uncertain).unwrap();
        assert!(found.deployed.ball().is_some(), "{:?}", found.deployed.running);
        files.push(found.certificate_file("deployed").unwrap());
    }
    files.push(design.deployed_certificate_file("deployed", Format::Binary32.into(), &uncertain).unwrap());
    for format in [Format::Binary32, Format::Binary64, fixed] {
        for step in [Step::Innovation, Step::Joined] {
            let found = deployed_linear(&sampled, o.ld(), step, format.into(), &meets).unwrap();
            files.push(found.certificate_file("deployed").unwrap());
        }
        files.push(design.deployed_certificate_file("deployed", format.into(), &meets).unwrap());
    }
    // Sums accumulated, and matrices in a format of their own.
    let q = |integer_bits, fraction_bits| Format::Fixed { integer_bits, fraction_bits };
    for formats in [q(12, 20).into(), Formats { stored: q(4, 28), running: q(8, 16) }] {
        let found = deployed_linear(&sampled, o.ld(), Step::Accumulated, formats, &meets).unwrap();
        assert!(found.deployed.ball().is_some(), "{:?}", found.deployed.running);
        files.push(found.certificate_file("deployed").unwrap());
    }
    files
}

/// Equations, inequalities, programs and matrices.
fn of_matrices() -> Vec<CertificateFile> {
    let (a, q) = (dmatrix![0.0, 1.0; -2.0, -3.0], dmatrix![1.0, 0.25; 0.25, 2.0]);
    let mut files = vec![
        solution_certificate(Equation::Lyapunov, &a, &q).unwrap(),
        solution_certificate(Equation::Stein, &(&a * 0.2), &q).unwrap(),
    ];
    for a in [a.clone(), -&a] {
        let mut lmi = Problem::new();
        let p = lmi.symmetric("P", 2);
        lmi.constrain("P > 0", &p >> 0.0);
        lmi.constrain("the \"decrease\"\u{202e}\u{200b}", he(&p * a) << 0.0);
        let solution = lmi.solve().unwrap();
        files.push(lmi.certificate_file("a Lyapunov inequality", &solution).unwrap());
    }
    // The larger eigenvalue of a swap, with a decimal; a program without a feasible point; one whose dual has none.
    for text in [
        "2\n2\n2 -1\n1.0 0.1\n0 1 1 2 -1.0\n1 1 1 1 1.0\n1 1 2 2 1.0\n2 2 1 1 1.0\n",
        "1\n1\n2\n1.0\n0 1 1 1 1.0\n0 1 2 2 1.0\n1 1 1 1 1.0\n1 1 2 2 -1.0\n",
        "1\n1\n2\n-1.0\n1 1 1 1 1.0\n1 1 2 2 1.0\n",
    ] {
        let program = sdpa::read(text.as_bytes()).unwrap();
        let found = sdpa::solve(&program, &sdpa::Settings::default());
        files.push(found.certificate_file(&program, "a program").unwrap());
    }
    let (a, p) = (Matrix::from_rows([[0.0, 1.0], [-2.0, -3.0]]), Matrix::from_rows([[5.0, 1.0], [1.0, 1.0]]));
    let within = a.map(|x| Interval::around(*x, 0.01).unwrap());
    let identity = Matrix::from_rows([[1.0, 0.0], [0.0, 1.0]]);
    let exactly = |m: &Matrix<f64>| m.map(|x| Interval::around(*x, 0.0).unwrap());
    let output = exactly(&Matrix::from_rows([[1.0, 0.0]]));
    let plant = PlantWithin::within(&within, &exactly(&Matrix::from_fn(2, 0, |_, _| 0.0)), &output).unwrap();
    let l = Matrix::from_rows([[0.1], [0.0]]);
    let theorems: Vec<Theorem> = vec![
        HurwitzStability::new(&a, &p).unwrap().into(),
        HurwitzStability::within(&within, &p).unwrap().into(),
        LinearConvergence { plant, l, p: p.clone(), rate: 0.1 }.into(),
        SchurStability { a: a.map(|x| x * 0.2), p: identity }.into(),
        Definiteness::new(&p, Sign::PositiveDefinite).unwrap().into(),
        Definiteness::new(&p.map(|x| -x), Sign::NegativeSemidefinite).unwrap().into(),
    ];
    files.extend(theorems.into_iter().map(|theorem| CertificateFile::prove("a matrix", theorem).unwrap()));
    files
}

/// Error bounds of KKL observers over a box: the converter, Proposition 6, van der Pol and Duffing.
fn of_expressions() -> Vec<CertificateFile> {
    let one = DMatrix::identity(2, 2);
    let cycle = region(&[(-2.5, 2.5), (-3.0, 3.0)], &[]);
    let cascade = region(&[(-1.0, 1.5), (-2.0, 3.0), (-1.0, 1.0)], &[(-1.0, 1.0)]);
    let operation = region(&[(0.0, 3.0), (10.0, 45.0), (-3.0, 0.0), (-40.0, 0.0)], &[(0.1, 0.8)]);
    let orbit = region(&[(-0.5, 0.5), (-0.8, 0.8)], &[]);
    // Volt and volt seconds.
    let scales = dmatrix![1.0, 0.0; 0.0, 1e6];
    let coupled = dmatrix![1.0, -0.1; -0.1, 1.0];
    // With the modulus of injectivity, for maps that are linear in x.
    let injective = error_bound(&converter(&CukConverter::default()), &operation).unwrap();
    assert!(injective.injectivity.is_some());
    [
        Some(injective),
        bound(&van_der_pol(1.0, [-1.0, -2.0], 0.0), &cycle, &one, 0.9, 5.0),
        bound(&van_der_pol(3.0, [-2.0, -1.0], 0.01), &cycle, &coupled, 0.75, 1.0),
        bound(&exponential_cascade(3.0), &cascade, &one, 0.9, 0.3),
        bound(&converter(&CukConverter::default()), &operation, &scales, 19.0, 50.0),
        bound(&duffing([-10.0, -15.0]), &orbit, &one, 9.0, 1.0),
    ]
    .map(|bound| CertificateFile::prove("a KKL observer", bound.unwrap()).unwrap())
    .into()
}

/// Every observer with a proof of every template, but for the one that takes minutes to design.
fn of_templates() -> Vec<CertificateFile> {
    let mut files = vec![];
    for template in TEMPLATES {
        let folder = scratch(&format!("study-{}", template.name));
        std::fs::write(folder.join("study.toml"), template.text).unwrap();
        for (name, text) in template.files {
            std::fs::write(folder.join(name), text).unwrap();
        }
        let mut study = Study::from_path(&folder.join("study.toml")).unwrap();
        study.observers.retain(|spec| spec.kind.name() != "kkl-numerical");
        for spec in &study.observers {
            let designed = luenberger_study::design::design(&study, spec, &AtomicBool::new(false)).unwrap();
            if let Some(certificate) = designed.certificate {
                files.push(
                    certificate.file(&spec.name).unwrap_or_else(|why| panic!("{} {}: {why}", template.name, spec.name)),
                );
            }
        }
    }
    files
}

/// Made once: the tests run beside each other, and templates are read from files.
fn all() -> &'static [CertificateFile] {
    static ALL: OnceLock<Vec<CertificateFile>> = OnceLock::new();
    ALL.get_or_init(|| {
        [of_linear_plants(), of_nonlinear_plants(), of_targets(), of_matrices(), of_expressions(), of_templates()]
            .concat()
    })
}

fn write(folder: &Path, texts: &[String]) -> Vec<PathBuf> {
    let path = |k: usize| folder.join(format!("{k}.json"));
    for (k, text) in texts.iter().enumerate() {
        std::fs::write(path(k), text).unwrap();
    }
    (0..texts.len()).map(path).collect()
}

#[test]
fn both_checkers_prove_the_files_of_examples_templates_and_papers() {
    let files = all();
    for name in Theorem::NAMES {
        assert!(files.iter().any(|file| file.theorem().name() == *name), "no file states {name}");
    }
    let texts: Vec<String> = files.iter().map(CertificateFile::to_json).collect();
    for (file, text) in files.iter().zip(&texts) {
        verify(text.as_bytes()).unwrap_or_else(|why| panic!("{}: {why}", file.theorem().name()));
    }
    let Some(found) = second(&write(&scratch("files"), &texts)) else { return };
    for (k, (file, found)) in files.iter().zip(found).enumerate() {
        assert_eq!(found, Second::Proved, "file {k}, {}", file.theorem().name());
    }
}

// Mutants: the data of a file changed, with words, labels and digest that agree again, so that the mathematics alone
// can object.

fn number(value: &Value) -> Option<f64> {
    value.as_str()?.parse::<luenberger_proof::certificate::Number>().ok()?.to_f64()
}

fn written(x: f64) -> Value {
    luenberger_proof::certificate::Number::from_f64(x).unwrap().to_string().into()
}

/// The pointers of all numbers, and those of all matrices, below a pointer.
fn places(value: &Value, at: &str, numbers: &mut Vec<String>, matrices: &mut Vec<String>) {
    match value {
        Value::Array(items) => {
            let width = |row: &Value| row.as_array().filter(|row| row.iter().all(Value::is_string)).map(Vec::len);
            if items.first().and_then(width).is_some_and(|n| n > 0 && items.iter().all(|row| width(row) == Some(n))) {
                matrices.push(at.to_owned());
            }
            for (k, item) in items.iter().enumerate() {
                places(item, &format!("{at}/{k}"), numbers, matrices);
            }
        }
        Value::Object(members) => {
            for (name, member) in members.iter().filter(|(name, _)| *name != "margins") {
                places(member, &format!("{at}/{name}"), numbers, matrices);
            }
        }
        _ if number(value).is_some() => numbers.push(at.to_owned()),
        _ => {}
    }
}

/// Puts a number in its place, and in the mirrored one where the matrix was symmetric.
fn put(file: &mut Value, at: &str, x: f64) {
    let parts: Vec<&str> = at.rsplitn(3, '/').collect();
    // A number of the document itself has no row and column.
    let mirrored = match parts[..] {
        [column, row, matrix] => format!("{matrix}/{column}/{row}"),
        _ => at.to_owned(),
    };
    let is_symmetric = mirrored != at && file.pointer(&mirrored).is_some_and(|other| Some(other) == file.pointer(at));
    for at in [Some(at), is_symmetric.then_some(mirrored.as_str())].into_iter().flatten() {
        *file.pointer_mut(at).unwrap() = written(if x.is_finite() { x } else { f64::MAX });
    }
}

/// The data changed in one way that means something.
fn mutate(file: &mut Value, random: &mut Random) -> &'static str {
    let (mut numbers, mut matrices) = (vec![], vec![]);
    places(file, "", &mut numbers, &mut matrices);
    let at = numbers[random.below(numbers.len())].clone();
    let x = number(file.pointer(&at).unwrap()).unwrap();
    match random.below(8) {
        0 => put(file, &at, -x),
        1 => put(file, &at, x * [0.5, 2.0, 1024.0, -4.0][random.below(4)]),
        2 => put(file, &at, x.next_up()),
        3 => put(file, &at, x.next_down()),
        4 => put(file, &at, 0.0),
        5 => {
            let other = numbers[random.below(numbers.len())].clone();
            let y = number(file.pointer(&other).unwrap()).unwrap();
            put(file, &at, y);
            put(file, &other, x);
            return "swapped";
        }
        kind if !matrices.is_empty() => {
            let matrix = file.pointer_mut(&matrices[random.below(matrices.len())]).unwrap();
            let rows: Vec<Vec<Value>> = serde_json::from_value(matrix.clone()).unwrap();
            let factor = [-1.0, 2.0, 0.5, 1.0 / 1024.0][random.below(4)];
            let scaled = |x: &Value| match number(x).map(|x| x * factor) {
                Some(y) if y.is_finite() => written(y),
                _ => x.clone(),
            };
            let changed: Vec<Vec<Value>> = if kind == 6 {
                (0..rows[0].len()).map(|j| rows.iter().map(|row| row[j].clone()).collect()).collect()
            } else {
                rows.iter().map(|row| row.iter().map(scaled).collect()).collect()
            };
            *matrix = serde_json::to_value(changed).unwrap();
            return if kind == 6 { "transposed" } else { "a matrix scaled" };
        }
        _ => put(file, &at, x + 1.0),
    }
    "a number changed"
}

/// With the words, the labels and the digest that the data call for; with the margins that are proved, one of them
/// perhaps larger than it may be.
fn resealed(mut file: Value, random: &mut Random) -> String {
    if let Ok(read) = CertificateFile::read(file.to_string().as_bytes()) {
        file["statement"] = read.theorem().words().into();
        if let Ok(facts) = read.theorem().facts() {
            let excess = random.below(3);
            let chosen = random.below(facts.len());
            let claims = facts.iter().enumerate().map(|(k, fact)| {
                let margin = fact.verdict.margin().unwrap_or(0.0);
                let margin = match excess {
                    0 if k == chosen => margin.next_up(),
                    1 if k == chosen => margin * (1.0 + 1e-6),
                    _ => margin,
                };
                serde_json::json!({ "inequality": fact.inequality, "margin": written(margin) })
            });
            file["margins"] = claims.collect();
        }
    }
    sealed(file)
}

fn sealed(mut file: Value) -> String {
    file["sha256"] = digest(file.to_string().as_bytes()).unwrap().into();
    file.to_string()
}

/// A file whose form is wrong in one way, and says so with a digest that agrees.
fn malformed(mut file: Value, random: &mut Random) -> String {
    let margins = file["margins"].as_array().unwrap().len();
    match random.below(7) {
        // No statement begins with this letter.
        0 => file["statement"] = file["statement"].as_str().unwrap().replacen(char::is_alphabetic, "Q", 1).into(),
        1 => file["statement"] = format!("{} ", file["statement"].as_str().unwrap()).into(),
        2 => file["margins"][random.below(margins)]["inequality"] = "1 > 0".into(),
        3 => drop(file["margins"].as_array_mut().unwrap().pop()),
        4 => file["note"] = "also true".into(),
        5 => file["version"] = 1.into(),
        _ => {
            let text = file.to_string();
            return text.replacen("0x1", "0x0", 1);
        }
    }
    sealed(file)
}

/// Whether the first checker says that the file is wrong, and not only that it found no proof.
fn is_refuted(rejection: &Rejection) -> bool {
    match rejection {
        Rejection::Margin { .. } => false,
        Rejection::NotProved { verdict, .. } => matches!(**verdict, Verdict::Refuted { .. }),
        _ => true,
    }
}

#[test]
fn on_mutants_neither_checker_accepts_what_the_other_refutes() {
    const SEED: u64 = 0x2026_1122;
    let mut random = Random(SEED);
    let (mut texts, mut changes) = (vec![], vec![]);
    for file in all() {
        let text = file.to_json();
        let tree: Value = serde_json::from_str(&text).unwrap();
        // The ball of a deployed observer takes half a second in Python.
        let count = if matches!(file.theorem(), Theorem::DeployedObserver(_)) { 3 } else { 6 };
        for _ in 0..count {
            let mut mutant = tree.clone();
            changes.push((file.theorem().name(), mutate(&mut mutant, &mut random)));
            texts.push(resealed(mutant, &mut random));
        }
        changes.push((file.theorem().name(), "malformed"));
        texts.push(malformed(tree, &mut random));
    }
    let first: Vec<Result<_, Rejection>> = texts.iter().map(|text| verify(text.as_bytes())).collect();
    let Some(found) = second(&write(&scratch("mutants"), &texts)) else { return };
    let (mut both, mut neither) = (0, 0);
    for (k, ((first, second), (name, change))) in first.iter().zip(&found).zip(&changes).enumerate() {
        let wrong = match (first, second) {
            (Ok(_), Second::Refuted(_)) => true,
            (Err(rejection), Second::Proved) => is_refuted(rejection),
            _ => false,
        };
        assert!(!wrong, "seed {SEED:#x}, mutant {k} of {name}, {change}: {second:?}, and {:?}", first.as_ref().err());
        if *change == "malformed" {
            assert!(first.is_err() && matches!(second, Second::Refuted(_)), "mutant {k} of {name}: {second:?}");
        }
        both += usize::from(first.is_ok() && *second == Second::Proved);
        neither += usize::from(first.is_err() && *second != Second::Proved);
    }
    // Neither is a checker that says the same of everything.
    assert!(both > texts.len() / 10 && neither > texts.len() / 4, "{both} accepted, {neither} rejected by both");
}

/// The file that the specification shows is one.
#[test]
fn both_checkers_prove_the_file_of_the_specification() {
    let page = include_str!("../../../docs/certificates.md");
    let text = page.split("```json\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    assert!(verify(text.as_bytes()).unwrap().statement.starts_with("For the plant x' = Ax + Bu, y = Cx"));
    let Some(found) = second(&write(&scratch("specification"), &[text.to_owned()])) else { return };
    assert_eq!(found, [Second::Proved]);
}

/// The command, as a user meets it: exit status and lines.
#[test]
fn the_second_checker_says_what_is_wrong() {
    let file = of_matrices().swap_remove(0).to_json();
    let cut = file[..file.rfind(',').unwrap()].to_owned();
    let forged = file.replacen("\"sha256\": \"", "\"sha256\": \"0", 1);
    let bad_escape = file.replacen("an equation", "an \\n equation", 1);
    let paths = write(&scratch("command"), &[file, cut, forged, bad_escape]);
    let Some(found) = second(&paths) else { return };
    assert_eq!(found[0], Second::Proved);
    let why: Vec<String> = found[1..].iter().map(|found| format!("{found:?}")).collect();
    assert!(why[0].contains("Unreadable: line ") && why[0].contains("the file ends"), "{}", why[0]);
    assert!(why[1].contains("sha256: the digest of the content is"), "{}", why[1]);
    assert!(why[2].contains("a string without control characters"), "{}", why[2]);
    let checker = Path::new(env!("CARGO_MANIFEST_DIR")).join("second_checker").join("check.py");
    let status =
        |path: &PathBuf| Command::new("python3").arg("-B").arg(&checker).arg(path).output().unwrap().status.code();
    assert_eq!(paths.iter().map(status).collect::<Vec<_>>(), [Some(0), Some(2), Some(1), Some(2)]);
}

/// What both refuse for the work that it would be, before the work.
#[test]
fn both_checkers_bound_the_misses_of_many_states() {
    let n = 60;
    let one = Matrix::from_fn(n, n, |i, j| if i == j { 1.0 } else { 0.0 });
    let plant = PlantMatrices { a: one.map(|x| -x), b: Matrix::from_fn(n, 0, |_, _| 0.0), c: one.map(|x| *x) };
    let k = one.map(|x| 0.5 * x);
    let step = CubicStep::Linear;
    let proved =
        VaryingPeriodConvergence { plant, k, step, shortest: 0.5, longest: 0.5, misses: 0, p: one, factor: 0.5 };
    let refused = VaryingPeriodConvergence { misses: 64, ..proved.clone() };
    assert_eq!(
        Theorem::from(refused).facts().unwrap_err().to_string(),
        "the motion of 60 states over 65 spans of time is 14040000 in all, and at most 4194304 is decided"
    );
    let text = CertificateFile::prove("many states", proved).unwrap().to_json();
    let text = text.replace("\"misses\": 0", "\"misses\": 64");
    let why = verify(text.as_bytes()).unwrap_err().to_string();
    assert!(why.contains("60^3 states times 65 spans of time are 14040000; the checker goes up to 4194304"), "{why}");
    let Some(found) = second(&write(&scratch("misses"), &[text])) else { return };
    let why = format!("{found:?}");
    assert!(why.contains("60^3 states times 65 spans of time are 14040000; the checker goes up to 4194304"), "{why}");
}
