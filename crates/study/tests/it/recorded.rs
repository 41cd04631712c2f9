//! Exported C has the bits of the observer that runs, whatever is measured: numbers far beyond the plant, below the
//! normal ones, and none at all.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use luenberger_export::{Export, Scalar, golden};
use luenberger_expression::ExpressionPlant;
use luenberger_observers::{
    CubicObserver, HighGainObserver, ImmersionInvarianceObserver, InterSampleObserver, KklObserver, LinearObserver,
    MeanValueObserver, Observer, ObserverDimensions, SampledIntervalObserver, SampledJumps, SampledObserver,
    SlidingModeObserver,
};
use luenberger_study::Study;
use luenberger_study::deployment::{self, Sampled};
use luenberger_study::design::Designed;
use luenberger_study::kinds::{PebObserver, PrintedMean, ReducedOrderObserver, WithoutDisturbance};
use luenberger_study::maps::{HighGainMaps, ImmersionMaps, KklMaps};
use luenberger_study::model::Model;
use nalgebra::{DVector, Dyn};

use crate::studies::{designed, extension, read};
use crate::{composed, maps, reduced_order, resets};

/// What a sensor may report for one sample.
const HOSTILE: [f64; 8] = [1e13, -1e13, 1e30, -1e30, 5e-324, 1e-310, f64::NAN, f64::INFINITY];

type Samples = Vec<(Vec<f64>, Vec<f64>)>;

/// Smooth inputs and outputs, of which one sample of an output and one of an input is `hostile`.
fn samples((inputs, outputs): (usize, usize), hostile: f64, at: usize) -> Samples {
    let smooth = |k: usize, j: usize| 0.4 + 0.3 * (0.37 * k as f64 + 1.3 * j as f64).sin();
    (0..14)
        .map(|k| {
            let mut u: Vec<f64> = (0..inputs).map(|j| smooth(k, j + 3)).collect();
            let mut y: Vec<f64> = (0..outputs).map(|j| smooth(k, j)).collect();
            if k == 3 {
                y[at % outputs] = hostile;
            }
            if k == 8 && inputs > 0 {
                u[at % inputs] = hostile;
            }
            (u, y)
        })
        .collect()
}

/// The C of an export, compiled, with a program that takes samples and returns estimates as binary numbers.
fn compiled(export: &Export, folder: &Path) -> std::path::PathBuf {
    _ = std::fs::remove_dir_all(folder);
    std::fs::create_dir_all(folder).unwrap();
    for file in export.c().unwrap() {
        std::fs::write(folder.join(file.name), file.text).unwrap();
    }
    let name = export.identifier();
    let (upper, size) = (name.to_uppercase(), export.observer().dimensions());
    let number = if export.scalar() == Scalar::Binary32 { "float" } else { "double" };
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
        {name}_step(&state, in, in + {m}, xhat);
        fwrite(xhat, sizeof xhat, 1, stdout);
    }}
    return 0;
}}
",
        all = size.inputs + size.outputs,
        m = size.inputs,
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

/// The estimates of the compiled program.
fn driven(program: &Path, export: &Export, samples: &Samples) -> Vec<Vec<f64>> {
    let mut child = Command::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let numbers = samples.iter().flat_map(|(u, y)| u.iter().chain(y));
    let is_single = export.scalar() == Scalar::Binary32;
    let bytes: Vec<u8> = if is_single {
        numbers.flat_map(|x| (*x as f32).to_le_bytes()).collect()
    } else {
        numbers.flat_map(|x| x.to_le_bytes()).collect()
    };
    child.stdin.take().unwrap().write_all(&bytes).unwrap();
    let output = child.wait_with_output().unwrap().stdout;
    let numbers: Vec<f64> = if is_single {
        output.chunks_exact(4).map(|x| f32::from_le_bytes(x.try_into().unwrap()).into()).collect()
    } else {
        output.chunks_exact(8).map(|x| f64::from_le_bytes(x.try_into().unwrap())).collect()
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
    sampled: &Sampled,
    plant: ExpressionPlant,
    initial: &[f64],
    samples: &Samples,
) -> Vec<Vec<f64>>
where
    O: Observer<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>,
{
    let form = extension(sampled);
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

/// The estimates of the observer of the study, sampled.
fn running(study: &Study, designed: &Designed, sampled: &Sampled, samples: &Samples) -> Vec<Vec<f64>> {
    let (observer, plant) = (&study.observers[0], study.plant.model.expressions().unwrap());
    let initial = &observer.initial;
    macro_rules! form {
        ($observer:expr) => {
            sampled_form($observer, sampled, plant, initial, samples)
        };
    }
    let runnable = &designed.runnable;
    macro_rules! forms {
        ($($of:ty),*) => {
            $(if let Some(observer) = runnable.of::<$of>() {
                return form!(observer);
            })*
        };
    }
    if let Some(observer) = runnable.of::<PebObserver>() {
        let Some(reset) = observer.reset() else { return form!(observer) };
        let every = (reset.period / extension(sampled).period()).round() as usize;
        return form!(&SampledJumps::<_, Dyn>::new(observer.clone(), every));
    }
    if let Some(observer) = runnable.of::<SlidingModeObserver<Model, f64, Dyn, Dyn, Dyn>>() {
        return stepped(observer, initial, samples);
    }
    if let Some(observer) = runnable.of::<SampledIntervalObserver<f64, Dyn, Dyn, Dyn, Dyn, Dyn>>() {
        return stepped(&WithBounds(observer), initial, samples);
    }
    forms!(
        KklObserver<KklMaps>,
        ReducedOrderObserver,
        ImmersionInvarianceObserver<Model, ImmersionMaps>,
        HighGainObserver<HighGainMaps, f64, Dyn>,
        WithoutDisturbance<LinearObserver<f64, Dyn, Dyn, Dyn>>,
        WithoutDisturbance<CubicObserver<f64, Dyn, Dyn, Dyn>>,
        MeanValueObserver<Model, PrintedMean, f64, Dyn, Dyn, Dyn>
    );
    panic!("{runnable:?}")
}

/// The exported C of the first observer of a study has the bits of the observer that runs in binary64, and in binary32
/// those of its program.
#[track_caller]
fn has_the_bits(name: &str, text: &str, period: f64) {
    let study = read(text).unwrap_or_else(|error| panic!("{name}: {error}"));
    let observer = &study.observers[0];
    let designed = designed(&study).unwrap_or_else(|why| panic!("{name}: {why:?}"));
    let own = observer.kind.period().or(study.plant.dt);
    let sampled = deployment::sampled(&study, observer, own.or(Some(period)), None)
        .unwrap_or_else(|why| panic!("{name}: {why:?}"));
    for scalar in [Scalar::Binary64, Scalar::Binary32] {
        let export = deployment::exported(&study, observer, sampled.design.clone(), scalar, None).unwrap();
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("recorded-{name}-{}", scalar.name()));
        let program = compiled(&export, &folder);
        let size = export.observer().dimensions();
        let mut finite = 0;
        for (at, hostile) in HOSTILE.into_iter().chain([0.5]).enumerate() {
            let samples = samples((size.inputs, size.outputs), hostile, at);
            let found = driven(&program, &export, &samples);
            let expected = match scalar {
                Scalar::Binary64 => running(&study, &designed, &sampled, &samples),
                Scalar::Binary32 => golden::replay(&export, &samples).unwrap(),
            };
            assert_eq!(found.len(), samples.len(), "{name}");
            for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
                assert_eq!(found.len(), expected.len(), "{name}");
                let same = |(x, y): (&f64, &f64)| x.to_bits() == y.to_bits() || (x.is_nan() && y.is_nan());
                let agree = found.iter().zip(expected).all(same);
                assert!(agree, "{name}, {hostile:e}, sample {k}: C {found:?}, observer {expected:?}");
                finite += found.iter().filter(|x| x.is_finite()).count();
            }
        }
        assert!(finite > 0, "{name}: nothing is finite");
    }
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

#[test]
fn interval_observers_have_the_bits_of_their_export() {
    let motor = r#"
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
    has_the_bits("interval", motor, 0.05);
}

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
}
