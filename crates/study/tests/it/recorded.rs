//! Exported C has the bits of the observer that runs, whatever is measured: numbers far beyond the plant, below the
//! normal ones, and none at all.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicBool;

use luenberger_export::extension::SampledExtension;
use luenberger_export::{Export, ExportableObserver, File, FixedPointFormat, FixedPointFormats, Scalar, golden};
use luenberger_expression::ExpressionPlant;
use luenberger_observers::{
    CubicObserver, HighGainObserver, ImmersionInvarianceObserver, InterSampleObserver, KklObserver, LinearObserver,
    MeanValueObserver, Observer, ObserverDimensions, SampledCubicObserver, SampledIntervalObserver, SampledJumps,
    SampledObserver, SlidingModeObserver,
};
use luenberger_study::deployment::{ExportOptions, Precision, program};
use luenberger_study::design::{Designed, design};
use luenberger_study::kinds::{
    Declaration, PebObserver, PrintedMean, ReducedOrderObserver, WithFeedthrough, WithoutDisturbance, registry,
};
use luenberger_study::maps::{HighGainMaps, ImmersionMaps, KklMaps};
use luenberger_study::model::Model;
use luenberger_study::study::ObserverSpec;
use luenberger_study::{Study, TEMPLATES};
use nalgebra::{DVector, Dyn};

use crate::studies::read;
use crate::{composed, filters, kkl_numerical, maps, reduced_order, resets, varying_periods};

/// What a sensor may report for one sample.
const HOSTILE: [f64; 8] = [1e13, -1e13, 1e30, -1e30, 5e-324, 1e-310, f64::NAN, f64::INFINITY];

type Samples = Vec<(Vec<f64>, Vec<f64>)>;

/// Smooth inputs and outputs, of which one sample of an output and one of an input is `hostile`.
fn samples(export: &Export, hostile: f64, at: usize) -> Samples {
    let smooth = |k: usize, j: usize| 0.4 + 0.3 * (0.37 * k as f64 + 1.3 * j as f64).sin();
    let (observer, outputs) = (export.observer(), export.observer().dimensions().outputs);
    (0..14)
        .map(|k| {
            let mut u: Vec<f64> = (0..observer.plant_inputs()).map(|j| smooth(k, j + 3)).collect();
            let mut y: Vec<f64> = (0..outputs).map(|j| smooth(k, j)).collect();
            if k == 3 {
                y[at % outputs] = hostile;
            }
            if k == 8 && !u.is_empty() {
                let inputs = u.len();
                u[at % inputs] = hostile;
            }
            u.extend(observer.takes_time().then(|| observer.period() * smooth(k, 5)));
            (u, y)
        })
        .collect()
}

/// The exported files in C, compiled with a program that takes samples and returns estimates as binary numbers of this
/// type. `times` is 1 for a step that takes the time since the last sample behind the inputs, otherwise 0.
fn compiled(
    files: Vec<File>,
    name: &str,
    number: &str,
    (inputs, outputs, times): (usize, usize, usize),
    folder: &Path,
) -> PathBuf {
    _ = std::fs::remove_dir_all(folder);
    std::fs::create_dir_all(folder).unwrap();
    for file in files {
        std::fs::write(folder.join(file.name), file.text).unwrap();
    }
    let main = format!(
        "#include <stdio.h>
#include \"{name}.h\"
int main(void)
{{
    {number} in[{all}];
    {number} xhat[{upper}_STATES];
    {name}_state state;
    {name}_reset(&state);
    while (fread(in, sizeof in, 1, stdin) == 1) {{
        {name}_step(&state, in, in + {known}, {time}xhat);
        fwrite(xhat, sizeof xhat, 1, stdout);
    }}
    return 0;
}}
",
        upper = name.to_uppercase(),
        all = inputs + times + outputs,
        known = inputs + times,
        time = if times > 0 { format!("in[{inputs}], ") } else { String::new() },
    );
    std::fs::write(folder.join("main.c"), main).unwrap();
    let built = Command::new("cc")
        .current_dir(folder)
        .args(["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-O1"])
        .args([&format!("{name}.c"), "main.c", "-o", "run", "-lm"])
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    folder.join("run")
}

/// What the compiled program answers.
fn answered(program: &Path, bytes: &[u8]) -> Vec<u8> {
    let mut child = Command::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(bytes).unwrap();
    child.wait_with_output().unwrap().stdout
}

/// The estimates of the compiled program.
fn driven(program: &Path, export: &Export, samples: &Samples) -> Vec<Vec<f64>> {
    let numbers = samples.iter().flat_map(|(u, y)| u.iter().chain(y));
    let numbers: Vec<f64> = if export.scalar() == Scalar::Binary32 {
        let answer = answered(program, &numbers.flat_map(|x| (*x as f32).to_le_bytes()).collect::<Vec<u8>>());
        answer.chunks_exact(4).map(|x| f32::from_le_bytes(x.try_into().unwrap()).into()).collect()
    } else {
        let answer = answered(program, &numbers.flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
        answer.chunks_exact(8).map(|x| f64::from_le_bytes(x.try_into().unwrap())).collect()
    };
    numbers.chunks_exact(export.observer().dimensions().estimate).map(<[f64]>::to_vec).collect()
}

/// The estimates of an observer that is stepped at the same samples.
fn stepped<O>(observer: &O, initial: &[f64], samples: &Samples) -> Vec<Vec<f64>>
where
    O: SampledObserver<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>,
{
    let size = observer.dimensions();
    let (u, y) = (DVector::zeros(size.inputs), DVector::zeros(size.outputs));
    let mut state = observer.initial(0.0, &DVector::from_column_slice(initial), &u, &y);
    let mut estimates = Vec::new();
    for (k, (u, y)) in samples.iter().enumerate() {
        let t = k as f64 * observer.period();
        observer.step(t, &mut state, &DVector::from_column_slice(u), &DVector::from_column_slice(y));
        estimates.push(observer.estimate(&state).as_slice().to_vec());
    }
    estimates
}

/// The sampled form of an observer in continuous time, as the export has it.
fn sampled_form<O>(
    observer: &O,
    form: &SampledExtension<f64>,
    plant: ExpressionPlant,
    initial: &[f64],
    samples: &Samples,
) -> Vec<Vec<f64>>
where
    O: Observer<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>,
{
    let same: InterSampleObserver<_, _, f64, Dyn, Dyn, Dyn, Dyn, Dyn> =
        InterSampleObserver::new(plant, observer, form.period(), form.substeps()).unwrap();
    stepped(&same, initial, samples)
}

/// An interval observer whose estimate is xhat, the half-widths of its bounds and rho.
struct WithBounds<'a>(&'a SampledIntervalObserver<f64, Dyn, Dyn, Dyn, Dyn, Dyn>);

impl SampledObserver<f64> for WithBounds<'_> {
    type State = DVector<f64>;
    type Input = DVector<f64>;
    type Output = DVector<f64>;
    type Estimate = DVector<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        self.0.dimensions()
    }

    fn period(&self) -> f64 {
        self.0.period()
    }

    fn step(&self, t: f64, state: &mut DVector<f64>, u: &DVector<f64>, y: &DVector<f64>) {
        self.0.step(t, state, u, y);
    }

    fn estimate(&self, state: &DVector<f64>) -> DVector<f64> {
        let (widths, n) = (self.0.half_widths(state.as_slice()), self.0.dimensions().estimate);
        let all = state.iter().take(n).chain(widths.iter()).chain(state.iter().skip(n));
        DVector::from_vec(all.copied().collect())
    }

    fn initial(&self, t: f64, xhat: &DVector<f64>, u: &DVector<f64>, y: &DVector<f64>) -> DVector<f64> {
        self.0.initial(t, xhat, u, y)
    }
}

/// The estimates at the samples of an observer whose estimate has the measurement of its sample, each with the next
/// state of the observer behind it.
fn at_samples(designed: &Designed, of: &ObserverSpec, samples: &Samples) -> Vec<Vec<f64>> {
    let runnable = &designed.runnable;
    let size = runnable.dimensions();
    let first = match of.kind.functions() {
        Some((k, _)) => (k * DVector::from_column_slice(&of.initial)).as_slice().to_vec(),
        None => of.initial.clone(),
    };
    let mut state = runnable.initial(0.0, &first, &vec![0.0; size.inputs], &vec![0.0; size.outputs]).unwrap();
    let mut found = Vec::new();
    for (u, y) in samples {
        let mut xhat = vec![0.0; size.estimate];
        runnable.any().correct(&state, u, y, &[], &mut xhat);
        state = runnable.motion(0.0, &state, u, y).unwrap();
        found.push([&xhat[..], &state[..state.len() - xhat.len()]].concat());
    }
    found
}

/// The estimates of the observer that runs: of those that are recorded, that of the study in its sampled form; of
/// others the observer of the export itself.
fn running(
    study: &Study,
    observer: &ObserverSpec,
    designed: &Designed,
    export: &Export,
    samples: &Samples,
) -> Vec<Vec<f64>> {
    let (initial, plant, runnable) = (&observer.initial, study.plant.model.expressions().ok(), &designed.runnable);
    if let Some(observer) = runnable.of::<SlidingModeObserver<Model, f64, Dyn, Dyn, Dyn>>() {
        return stepped(observer, initial, samples);
    }
    if let Some(observer) = runnable.of::<SampledIntervalObserver<f64, Dyn, Dyn, Dyn, Dyn, Dyn>>() {
        return stepped(&WithBounds(observer), initial, samples);
    }
    if matches!(export.observer(), ExportableObserver::Step(step) if step.is_of_sample()) {
        return at_samples(designed, observer, samples);
    }
    let form = if let ExportableObserver::Extension(form) = export.observer() { Some(form) } else { None };
    let Some((form, plant)) = form.zip(plant) else {
        return match runnable.of::<SampledCubicObserver<f64, Dyn, Dyn, Dyn>>() {
            Some(observer) => stepped(observer, initial, samples),
            None => golden::replay(export, samples).unwrap(),
        };
    };
    if let Some(observer) = runnable.of::<PebObserver>() {
        let Some(reset) = observer.reset() else { return sampled_form(observer, form, plant, initial, samples) };
        let every = (reset.period / form.period()).round() as usize;
        let observer = SampledJumps::<_, Dyn>::new(observer.clone(), every);
        return sampled_form(&observer, form, plant, initial, samples);
    }
    macro_rules! forms {
        ($($of:ty),*) => {
            $(if let Some(observer) = runnable.of::<$of>() {
                return sampled_form(observer, form, plant, initial, samples);
            })*
        };
    }
    forms!(
        KklObserver<KklMaps>,
        ReducedOrderObserver,
        WithFeedthrough<ReducedOrderObserver>,
        ImmersionInvarianceObserver<Model, ImmersionMaps>,
        HighGainObserver<HighGainMaps, f64, Dyn>,
        WithoutDisturbance<LinearObserver<f64, Dyn, Dyn, Dyn>>,
        WithoutDisturbance<CubicObserver<f64, Dyn, Dyn, Dyn>>,
        MeanValueObserver<Model, PrintedMean, f64, Dyn, Dyn, Dyn>
    );
    panic!("{runnable:?} is recorded")
}

/// Bits that agree; all that is not a number counts as one.
fn agree(found: &[f64], expected: &[f64]) -> bool {
    let same = |(x, y): (&f64, &f64)| x.to_bits() == y.to_bits() || (x.is_nan() && y.is_nan());
    found.len() == expected.len() && found.iter().zip(expected).all(same)
}

/// Where the exported C of an observer has other bits than the observer that runs in binary64, and in binary32 than its
/// program.
fn differences(name: &str, study: &Study, observer: &ObserverSpec, period: f64) -> Vec<String> {
    let found = design(study, observer, &AtomicBool::new(false));
    let designed = found.unwrap_or_else(|why| panic!("{name}: {why:?}"));
    let period = Some(observer.kind.period().or(study.plant.dt).unwrap_or(period));
    let mut differences = Vec::new();
    for format in [Precision::Binary64, Precision::Binary32] {
        let options = ExportOptions { format, period, designed: Some(&designed), ..ExportOptions::default() };
        let export = program(study, Some(&observer.name), &options, None).unwrap_or_else(|why| panic!("{name}: {why}"));
        let (scalar, size) = (export.scalar(), export.observer().dimensions());
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("recorded-{name}-{}", scalar.name()));
        let number = if scalar == Scalar::Binary32 { "float" } else { "double" };
        let inputs = export.observer().plant_inputs();
        let size = (inputs, size.outputs, size.inputs - inputs);
        let program = compiled(export.c().unwrap(), export.identifier(), number, size, &folder);
        let mut finite = 0;
        for (at, hostile) in HOSTILE.into_iter().chain([0.5]).enumerate() {
            let samples = samples(&export, hostile, at);
            let found = driven(&program, &export, &samples);
            let expected = match scalar {
                Scalar::Binary64 => running(study, observer, &designed, &export, &samples),
                Scalar::Binary32 => golden::replay(&export, &samples).unwrap(),
            };
            assert_eq!(found.len(), samples.len(), "{name}");
            finite += found.iter().flatten().filter(|x| x.is_finite()).count();
            let differs = found.iter().zip(&expected).position(|(found, expected)| !agree(found, expected));
            differences.extend(differs.map(|k| {
                let (found, expected) = (&found[k], &expected[k]);
                format!("{name}, {}, {hostile:e}, sample {k}: C {found:?}, observer {expected:?}", scalar.name())
            }));
        }
        assert!(finite > 0, "{name}: nothing is finite");
    }
    differences
}

/// The exported C of the first observer of a study has the bits of the observer that runs.
#[track_caller]
fn has_the_bits(name: &str, text: &str, period: f64) {
    let study = read(text).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert_eq!(differences(name, &study, &study.observers[0], period), Vec::<String>::new());
}

/// Four parameters, by both extensions of DREM.
const FOUR: &str = r#"
[plant]
f = ["x2 + x3*u1 + x4*u1^2 + x5*u1^3 - x1", "-x1", "u1 - x1", "x1^2", "sin(x1)"]
h = ["x1"]
[[observer]]
kind = "pebo"
phi = ["x2", "x3", "x4", "x5"]
b = ["-y1", "u1 - y1", "y1^2", "sin(y1)"]
left_inverse = ["y1", "xi1", "xi2", "xi3", "xi4"]
s = ["y1"]
g = ["xi1 + xi2*u1 + xi3*u1^2 + xi4*u1^3 - y1"]
m = [["1", "u1", "u1^2", "u1^3"]]
alpha = 2
region = { states = [[-2, 2], [-2, 2], [-2, 2], [-2, 2], [-2, 2]], inputs = [[-1, 1]] }
"#;

#[test]
fn kkl_and_peb_observers_have_the_bits_of_their_export() {
    for (name, maps) in [("kkl", maps::KKL), ("pebo", maps::PEBO), ("both", maps::BOTH)] {
        has_the_bits(name, &format!("{}{maps}", maps::PLANT), 1e-5);
    }
    // An exponential of xi, and a parameter with a bound.
    has_the_bits("sixth", &maps::SIXTH.replace("alpha = 1\n", "alpha = 1\ninitial = [0.5, 0, 0]\n"), 0.01);
    let reset = |text: &str, above: &str| format!("{text}reset = {{ period = 0.04{above} }}\n");
    has_the_bits("reset", &reset(resets::STUDY, ", above = 0.1"), 0.01);
    let drem = resets::STUDY.replace("kind = \"gradient\"", "kind = \"drem\", forgetting = 1");
    has_the_bits("reset-drem", &reset(&drem, ""), 0.01);
    // The filters begin again.
    let scaled = resets::STUDY.replace("m = [1]", "m = [2]\nmissing = [\"2*theta1\"]");
    has_the_bits("restarted", &reset(&scaled, ""), 0.01);
    let four = |estimator: &str| format!("{FOUR}estimator = {{ kind = \"drem\", {estimator}, gain = 2 }}\n");
    has_the_bits("forgetting", &four("forgetting = 1"), 0.01);
    has_the_bits("filters", &four("filters = [1, 2, 3]"), 0.01);
}

/// A pendulum with a lookup table for its friction.
const PENDULUM: &str = r#"
[plant]
f = ["x2", "-9.81*sin(x1) - friction(x2) + u1"]
h = ["x1"]
[plant.tables.friction]
x = [-2, -0.1, 0, 0.1, 2]
y = [-1, -0.3, 0, 0.3, 1]
extrapolation = "linear"
[[observer]]
kind = "sliding-mode"
bound = 15
period = 0.01
"#;

#[test]
fn sliding_mode_observers_have_the_bits_of_their_export() {
    let chain = |n: usize| {
        let rates: Vec<String> =
            (2..=n).map(|i| format!("\"x{i}\"")).chain(["\"-x1 + u1*sin(x1)\"".to_owned()]).collect();
        format!(
            "[plant]\nf = [{}]\nh = [\"x1\"]\n[[observer]]\nkind = \"sliding-mode\"\nbound = 2\nperiod = 0.01\n",
            rates.join(", ")
        )
    };
    has_the_bits("pendulum", PENDULUM, 0.01);
    for n in 1..=4 {
        has_the_bits(&format!("implicit{n}"), &chain(n), 0.01);
        has_the_bits(&format!("explicit{n}"), &format!("{}discretisation = \"explicit\"\n", chain(n)), 0.01);
    }
}

/// Bounds at the samples.
const INTERVAL: &str = r#"
[plant]
a = [[0.9, 0.05], [-0.1, 0.7]]
b = [[0.01], [0.2]]
c = [[1, 0]]
dt = 0.05
[[observer]]
kind = "interval"
initial_bounds = [2, 2]
poles = [0.5, 0.6]
bounds = { disturbance = [0.01], e = [[1], [0]], noise = [0.05] }
"#;

/// Four rows, and a lookup table in the plant.
const ROWS: &str = r#"
[plant]
f = ["x2", "-soft(x1) - x2 + u1", "x4 - x3", "-x3 - x4 + x1", "x3 - x5"]
h = ["x1"]
[plant.tables.soft]
x = [-2, 0, 1, 3]
y = [-1, 0, 2, 3]
[[observer]]
kind = "immersion-invariance"
region = { states = [[-2, 2], [-2, 2], [-2, 2], [-2, 2], [-2, 2]], inputs = [[-1, 1]] }
beta = ["chi1 + sin(chi2)/8 + 2*y1", "chi2 + chi3*chi1/20", "chi3 + chi4^2/8 - y1", "chi4 + cos(chi1)/9"]
phi = ["x2", "x3", "x4", "x5"]
left_inverse = ["y1", "z1", "z2", "z3", "z4"]
start = ["x2 - 2*x1", "x3", "x4 + x1", "x5"]
"#;

#[test]
fn observers_that_contain_the_plant_have_the_bits_of_their_export() {
    for (k, (text, period)) in composed::texts().iter().zip([1e-5, 1e-5, 1e-5, 2e-3, 2e-3, 2e-3]).enumerate() {
        has_the_bits(&format!("composed{k}"), text, period);
    }
    has_the_bits("rows", ROWS, 1e-2);
    has_the_bits("reduced-order", reduced_order::OGATA, 2e-3);
    has_the_bits("reduced-order-fed", &reduced_order::OGATA.replace("[input]", "d = [[0.5]]\n[input]"), 2e-3);
}

/// Kinds and forms that no template has.
pub(crate) fn others() -> Vec<(&'static str, String)> {
    let pendulum = |observer: &str| {
        format!("[plant]\nf = [\"x2\", \"-9.81*sin(x1) - 0.3*x2 + u1\"]\nh = [\"x1\"]\n[[observer]]\n{observer}\n")
    };
    // With an output that has a curvature.
    let ranged = |keys: &str| {
        pendulum(&format!("kind = \"iterated-extended-kalman\"\n{keys}"))
            .replace("[\"x1\"]", "[\"sqrt(1 + (x1 - 2)^2)\"]")
    };
    let noise = "w = [1e-4, 1e-2]\nv = 0.04\nperiod = 0.05";
    let motor = |observer: &str| {
        format!(
            "[plant]\na = [[0.9, 0.05], [-0.1, 0.7]]\nb = [[0.01], [0.2]]\nc = [[1, 0]]\nd = [[0.1]]\ndt = 0.05\n[[observer]]\n{observer}\n"
        )
    };
    let map = |observer: &str| {
        format!(
            "[plant]\nf = [\"x1 + 0.1*x2\", \"x2 - 0.981*sin(x1) + 0.1*u1\"]\nh = [\"x1\"]\ndt = 0.1\n[[observer]]\n{observer}\n"
        )
    };
    // The first state is an angle, and the output that is this state.
    let of_angles = |text: String| text.replace("[plant]\n", "[plant]\nangles = [\"x1\"]\n");
    // The weight of the pendulum is a state.
    let of_parameter = |text: &str| {
        let text =
            text.replace("sin(x1)", "weight*sin(x1)").replace("[plant]\n", "[plant]\nparameters = { weight = 1 }\n");
        format!("{text}[estimate]\nparameters = [\"weight\"]\np0 = [0.1]\nw = [1e-3]\n")
    };
    let noise_of_map = "w = [1e-3, 1e-2]\nv = 0.01\nperiod = 0.1";
    vec![
        ("ukf", pendulum(&format!("kind = \"ukf\"\n{noise}"))),
        ("ukf-negative-weight", pendulum(&format!("kind = \"ukf\"\nalpha = 0.1\n{noise}"))),
        ("ukf-of-a-map", filters::MAP.to_owned()),
        ("ekf-gate", pendulum(&format!("kind = \"extended-kalman\"\ngate = 0.99\n{noise}"))),
        ("ekf-of-a-map", map(&format!("kind = \"extended-kalman\"\n{noise_of_map}"))),
        ("mhe-of-a-map", map(&format!("kind = \"mhe\"\nwindow = 3\n{noise_of_map}"))),
        (
            "gain-of-a-map",
            map("kind = \"lpv\"\ngain = [[1], [2]]\nregion = { states = [[-0.5, 0.5], [-5, 5]], inputs = [[-1, 1]] }"),
        ),
        ("iterated", ranged(&format!("gate = 1.5\n{noise}"))),
        ("iterated-of-a-map", ranged(&format!("iterations = 5\n{noise}")).replace("[plant]\n", "[plant]\ndt = 0.05\n")),
        (
            "error-state",
            pendulum(&format!(
                "kind = \"error-state-kalman\"\nunit_vectors = [[\"x1\", \"x2\"]]\ninitial = [0.6, 0.8]\n{noise}"
            )),
        ),
        (
            "error-state-of-a-map",
            map(&format!(
                "kind = \"error-state-kalman\"\nunit_vectors = [[\"x1\", \"x2\"]]\ninitial = [0.6, 0.8]\n{noise_of_map}"
            )),
        ),
        ("mhe", pendulum(&format!("kind = \"mhe\"\nwindow = 4\n{noise}"))),
        ("mhe-bounds", pendulum(&format!("kind = \"mhe\"\nwindow = 3\nstate_bounds = [[-1, 1], [-inf, 2]]\n{noise}"))),
        ("ekf-angles", of_angles(pendulum(&format!("kind = \"extended-kalman\"\ngate = 0.99\n{noise}")))),
        ("iterated-angles", of_angles(ranged(noise)).replace("angles = [\"x1\"]", "angles = [\"x1\", \"y1\"]")),
        ("ukf-angles", of_angles(pendulum(&format!("kind = \"ukf\"\ngate = 2\n{noise}")))),
        (
            "ukf-angles-of-a-map",
            of_angles(map(&format!("kind = \"ukf\"\n{noise_of_map}"))).replace("x1 + 0.1*x2", "wrap(x1 + 0.1*x2)"),
        ),
        ("mhe-angles", of_angles(pendulum(&format!("kind = \"mhe\"\nwindow = 4\n{noise}")))),
        (
            "mhe-angles-of-a-map",
            of_angles(map(&format!("kind = \"mhe\"\nwindow = 3\n{noise_of_map}")))
                .replace("x1 + 0.1*x2", "wrap(x1 + 0.1*x2)"),
        ),
        ("ekf-parameter", of_parameter(&pendulum(&format!("kind = \"extended-kalman\"\n{noise}")))),
        ("mhe-parameter", of_parameter(&pendulum(&format!("kind = \"mhe\"\nwindow = 3\n{noise}")))),
        ("chain", pendulum("kind = \"high-gain\"\nr = 0.1")),
        ("discrete", motor("kind = \"luenberger\"\npoles = [0.5, 0.6]")),
        ("cubic-of-samples", motor("kind = \"sampled-cubic\"\npoles = [0.5, 0.6]\ngamma = 1\nperiod = 0.05")),
        ("disturbance-of-samples", motor("kind = \"proportional-integral\"\ne = [[1], [0]]\npoles = [0.5, 0.6, 0.7]")),
        ("state-of-disturbance", motor("kind = \"extended-state\"\ne = [[1], [0]]\npoles = [0.5, 0.6, 0.7]")),
        ("h2-of-samples", motor("kind = \"h2\"\ne = [[1, 0], [0.5, 0]]\nd = [[0, 1]]")),
        ("h-infinity-of-samples", motor("kind = \"h-infinity\"\ne = [[1, 0], [0.5, 0]]\nd = [[0, 1]]")),
        ("interval-of-samples", INTERVAL.to_owned()),
        ("reduced-order-of-samples", motor("kind = \"reduced-order\"\npoles = [0.3]")),
        ("functional", motor("kind = \"functional\"\nk = [[0.5, 1]]\npoles = [0.3]\ninitial = [0.25, -0.125]")),
        ("decoupled", motor("kind = \"unknown-input\"\ne = [[1], [0]]\npoles = [0.7, 0.2]\ninitial = [0.25, -0.125]")),
        (
            "decoupled-outputs",
            // A - E C = [0.5 0.05; 0 0.7].
            motor("kind = \"unknown-input\"\ne = [[0.4], [-0.1]]\nf = [[1]]\npoles = [0.5, 0.7]"),
        ),
        ("filter-form", motor("kind = \"kalman\"\nw = [1e-4, 1e-2]\nv = 0.04\nform = \"filter\"")),
        ("varying", varying_periods::STUDY.to_owned()),
        ("held", kkl_numerical::FORCED.replace("points = 17", "points = 9")),
        ("embedded", kkl_numerical::FORCED.replace("points = 17", "points = 9\nform = \"embedded\"")),
        ("four-states", kkl_numerical::COUPLED.replace("points = 6", "points = 5\nform = \"embedded\"")),
    ]
}

/// The kinds without a step, for plants in discrete time or not: a study of each, and why it has none.
const WITHOUT_STEP: [(&str, bool, &str, &str); 5] = [
    (
        "functional",
        false,
        "[plant]\na = [[0, 1], [-2, -3]]\nc = [[1, 0]]\n[[observer]]\nkind = \"functional\"\nk = [[0.5, 1]]\npoles = [-4]\n",
        "no prediction of the output",
    ),
    (
        "particle",
        false,
        "[plant]\nf = [\"-x1\"]\nh = [\"x1\"]\n[[observer]]\nkind = \"particle\"\nw = 1\nv = 1\nperiod = 0.02\n",
        "draws random numbers",
    ),
    (
        "particle",
        true,
        "[plant]\nf = [\"x1/2\"]\nh = [\"x1\"]\ndt = 0.02\n[[observer]]\nkind = \"particle\"\nw = 1\nv = 1\nperiod = 0.02\n",
        "draws random numbers",
    ),
    (
        "imm",
        false,
        "[plant]\nf = [\"-x1\"]\nh = [\"x1\"]\n[[observer]]\nkind = \"imm\"\nw = 1\nv = 1\nperiod = 0.02\nmodels = [{}, { w = 9 }]\ntransitions = [[0.9, 0.1], [0.1, 0.9]]\n",
        "have no kernel in C",
    ),
    (
        "imm",
        true,
        "[plant]\nf = [\"x1/2\"]\nh = [\"x1\"]\ndt = 0.02\n[[observer]]\nkind = \"imm\"\nw = 1\nv = 1\nperiod = 0.02\nmodels = [{}, { w = 9 }]\ntransitions = [[0.9, 0.1], [0.1, 0.9]]\n",
        "have no kernel in C",
    ),
];

/// All that `luenberger new --list` names, in continuous time and where they are for such plants in discrete time.
#[test]
fn every_kind_has_the_bits_of_its_export() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("templates");
    let mut seen = BTreeSet::new();
    let mut found = Vec::new();
    for template in TEMPLATES {
        let study = Study::from_path(&folder.join(format!("{}.toml", template.name))).unwrap();
        let simulation = study.simulation.as_ref();
        let period = match template.name {
            "cuk-observers" | "cuk-table-1" => 1e-5,
            _ => simulation.map_or(0.01, |simulation| simulation.hold.unwrap_or(simulation.duration / 500.0)),
        };
        for observer in &study.observers {
            let name = format!("{}-{}", template.name, observer.name.replace(|c: char| !c.is_alphanumeric(), "-"));
            found.extend(differences(&name, &study, observer, period));
            seen.insert((observer.kind.name().to_owned(), study.plant.dt.is_some()));
        }
    }
    for (name, text) in others() {
        let study = read(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
        found.extend(differences(name, &study, &study.observers[0], 0.02));
        seen.insert((study.observers[0].kind.name().to_owned(), study.plant.dt.is_some()));
    }
    assert_eq!(found, Vec::<String>::new());
    for (kind, is_discrete, text, why) in WITHOUT_STEP {
        let study = read(text).unwrap_or_else(|error| panic!("{kind}: {error}"));
        assert_eq!((study.observers[0].kind.name(), study.plant.dt.is_some()), (kind, is_discrete));
        let options = ExportOptions { period: Some(0.02), ..ExportOptions::default() };
        let refusal = program(&study, None, &options, None).unwrap_err().to_string();
        assert!(refusal.contains(why), "{kind}: {refusal}");
        assert!(seen.insert((kind.to_owned(), is_discrete)), "{kind} has a step");
    }
    let times = |kind: &Declaration| [Some(false), kind.plant.time().discrete.then_some(true)];
    let all = registry().into_iter().flat_map(|kind| times(kind).map(|time| time.map(|time| (kind.name, time))));
    let missing: Vec<_> = all.flatten().filter(|(kind, time)| !seen.contains(&((*kind).to_owned(), *time))).collect();
    assert_eq!(missing, [], "kinds, in discrete time or not, of which no step has been compared");
}

/// Integers at the ends of their range, in formats of 32, 24 and 9 bits.
#[test]
fn fixed_point_observers_have_the_bits_of_their_export() {
    let text = "[plant]\na = [[0.9, 0.05], [-0.1, 0.7]]\nb = [[0.01], [0.2]]\nc = [[1, 0]]\nd = [[0.1]]\ndt = 0.05\n[[observer]]\nkind = \"luenberger\"\npoles = [0.5, 0.6]\n";
    let study = read(text).unwrap();
    let export = program(&study, None, &ExportOptions::default(), None).unwrap();
    for (signals, gains) in [((16, 16), (4, 28)), ((8, 16), (2, 14)), ((5, 4), (2, 7))] {
        let format = |(integer, fraction)| FixedPointFormat::new(integer, fraction).unwrap();
        let formats = FixedPointFormats { signals: format(signals), gains: format(gains) };
        let fixed = export.fixed_point(formats).unwrap();
        let (smallest, largest) = (formats.signals.smallest(), formats.signals.largest());
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("recorded-fixed-{}", signals.0));
        let program = compiled(fixed.c(), export.identifier(), "int32_t", (1, 1, 0), &folder);
        let (observer, mut state) = (fixed.observer(), fixed.observer().start(fixed.initial().clone()));
        let ends = [0, 1, -1, smallest, largest, smallest + 1, largest - 1, largest / 3, i32::MIN, i32::MAX];
        let samples: Vec<[i32; 2]> = ends.iter().flat_map(|u| ends.iter().map(|y| [*u, *y])).collect();
        let bytes: Vec<u8> = samples.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        let answer = answered(&program, &bytes);
        let found: Vec<i32> = answer.chunks_exact(4).map(|x| i32::from_le_bytes(x.try_into().unwrap())).collect();
        let expected: Vec<i32> = samples
            .iter()
            .flat_map(|[u, y]| {
                observer.step(&mut state, &DVector::from_element(1, *u), &DVector::from_element(1, *y));
                state.xhat.as_slice().to_vec()
            })
            .collect();
        assert_eq!(found, expected);
    }
}
