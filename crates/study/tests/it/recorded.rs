//! Exported C has the bits of the observer that runs, whatever is measured: numbers far beyond the plant, below the
//! normal ones, and none at all.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use luenberger_export::{Export, Scalar, golden};
use luenberger_expression::ExpressionPlant;
use luenberger_observers::{
    InterSampleObserver, Observer, ObserverDimensions, SampledIntervalObserver, SampledJumps, SampledObserver,
};
use luenberger_study::Study;
use luenberger_study::deployment::{self, Sampled};
use luenberger_study::design::{Designed, Runnable};
use nalgebra::{DVector, Dyn};

use crate::studies::{designed, extension, read};

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
    match &designed.runnable {
        Runnable::KklMaps(observer) => form!(observer.as_ref()),
        Runnable::ReducedOrder(observer) => form!(observer.as_ref()),
        Runnable::Peb(observer) => match observer.reset() {
            Some(reset) => {
                let every = (reset.period / extension(sampled).period()).round() as usize;
                form!(&SampledJumps::<_, Dyn>::new(observer.as_ref().clone(), every))
            }
            None => form!(observer.as_ref()),
        },
        Runnable::Immersion(observer) => form!(observer.as_ref()),
        Runnable::HighGainMaps(observer) => form!(observer.as_ref()),
        Runnable::UnknownInput(observer) => form!(observer.as_ref()),
        Runnable::UnknownInputCubic(observer) => form!(observer.as_ref()),
        Runnable::PrintedMeanValue(observer) => form!(observer.as_ref()),
        Runnable::SlidingMode(observer) => stepped(observer.as_ref(), initial, samples),
        Runnable::SampledInterval(observer) => stepped(&WithBounds(observer), initial, samples),
        other => panic!("{other:?}"),
    }
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

const CONVERTER: &str = r#"
[plant]
states = ["i1", "v2", "i3", "v4"]
f = ["(E - (1 - duty)*v2)/L1", "((1 - duty)*i1 + duty*i3)/C2", "(-duty*v2 - v4)/L3", "(i3 - G*v4)/C4"]
h = ["v2", "i3"]
parameters = { L1 = 0.01, C2 = 22.0e-6, L3 = 0.01, C4 = 22.9e-6, G = 0.0447, E = 12.0 }
inputs = ["duty"]
outputs = ["v2", "i3"]
[[observer]]
region = { states = [[-5, 5], [0, 60], [-5, 5], [-60, 0]], inputs = [[0.2, 0.8]] }
initial = [0, 24, -0.5, 0]
"#;

const KKL: &str = r#"kind = "kkl"
phi = ["v4", "L1*i1 - C2*v2"]
lambda = ["-G/C4", "-(1 - duty)/L1"]
b = ["i3/C4", "E - duty*i3 - (1 + C2/L1)*(1 - duty)*v2"]
left_inverse = ["(xi2 + C2*v2)/L1", "v2", "i3", "xi1"]
"#;

const PEBO: &str = r#"kind = "pebo"
phi = ["i1", "v4 - G*L3/C4*i3"]
b = ["(E - (1 - duty)*v2)/L1", "(i3 + G*duty*v2)/C4"]
left_inverse = ["xi1", "v2", "i3", "xi2 + G*L3/C4*i3"]
s = ["v2", "i3"]
g = ["((1 - duty)*xi1 + duty*i3)/C2", "-(duty*v2 + xi2 + G*L3/C4*i3)/L3"]
m = ["(1 - duty)/C2", "-1/L3"]
alpha = 0.5
estimator = { kind = "gradient", gain = [0.001, 100] }
"#;

/// Proposition 6 of the [KKL+PEB] paper: an exponential of xi, and a parameter with a bound.
const SIXTH: &str = r#"
[plant]
f = ["exp(x3) - x1^3", "x1^2 + sin(x1) - x2", "1/(x1^2 + 1) + x1*u1"]
h = ["x1"]
[[observer]]
kind = "kkl-peb"
region = { states = [[-2, 3], [-1, 8], [-4, 3]], inputs = [[-1.1, -0.4]] }
phi = ["x2", "x3"]
lambda = [-1, 0]
b = ["y1^2 + sin(y1)", "u1*y1 + 1/(y1^2 + 1)"]
left_inverse = ["y1", "xi1", "xi2"]
s = ["y1"]
g = ["-y1^3"]
m = ["exp(xi2)"]
missing = ["0", "ln(theta1)"]
theta = [[0.2, 5]]
theta_min = [1e-12]
theta_start = 1
alpha = 1
estimator = { kind = "gradient", gain = 5 }
initial = [0.5, -0.5, -0.5]
"#;

/// Van der Pol's oscillator with resets of its integral.
const RESETS: &str = r#"
[plant]
f = ["x2", "(1 - x1^2)*x2 - x1"]
h = ["x1"]
[[observer]]
kind = "pebo"
phi = ["x2 - x1 + x1^3/3"]
b = ["-y1"]
left_inverse = ["y1", "xi1 + y1 - y1^3/3"]
s = ["y1"]
g = ["xi1 + y1 - y1^3/3"]
m = [1]
alpha = 2
estimator = { kind = "drem", forgetting = 1, gain = 2 }
region = { states = [[-3, 3], [-4, 4]] }
initial = [2, 1]
reset = { period = 0.04, above = 0.1 }
"#;

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
    has_the_bits("kkl", &format!("{CONVERTER}{KKL}"), 1e-5);
    has_the_bits("pebo", &format!("{CONVERTER}{PEBO}"), 1e-5);
    has_the_bits("sixth", SIXTH, 0.01);
    has_the_bits("resets", RESETS, 0.01);
    let gradient = RESETS.replace("\"drem\", forgetting = 1", "\"gradient\"");
    has_the_bits("gradient", &gradient, 0.01);
    // The filters begin again.
    let scaled = gradient.replace("m = [1]", "m = [2]\nmissing = [\"2*theta1\"]").replace(", above = 0.1", "");
    has_the_bits("restarted", &scaled, 0.01);
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

#[test]
fn other_observers_have_the_bits_of_their_export() {
    let region = "region = { states = [[-5, 5], [0, 60], [-5, 5], [-60, 0]], inputs = [[0.2, 0.8]] }\n";
    let converter = |observer: &str| format!("{}{observer}", CONVERTER.replace(region, ""));
    has_the_bits(
        "high-gain",
        &converter(
            r#"kind = "high-gain"
r = 0.005
chains = [2, 2]
alpha = [2, 1, 2, 1]
drift = ["((1 - duty)*xi2 + duty*i3)/C2", "(E - (1 - duty)*v2)/L1", "-(duty*v2 + xi4)/L3", "(i3 - G*xi4)/C4"]
shape = [1, "C2/(1 - duty)", 1, "-L3"]
estimate = ["xi2", "v2", "i3", "xi4"]
start = ["v2", "i1", "i3", "v4"]
"#,
        ),
        1e-5,
    );
    has_the_bits(
        "printed",
        r#"
[plant]
f = ["x2", "-48.6*x1 - 1.25*x2 + 48.6*x3 + 21.6*u1", "x4", "19.5*x1 - 19.5*x3 - 3.33*sin(x3) - 0.1*x4^3"]
h = ["x1", "x2"]
[[observer]]
kind = "mean-value"
eta = 1.5
internal_error = [0.1, 0, 0.2, 0]
as_printed = "integral"
"#,
        2e-3,
    );
    let linear = r#"
[plant]
a = [[0, 1, 0], [-2, -3, 1], [0, 0, -1]]
b = [[0], [1], [0.5]]
c = [[1, 0, 0], [0, 1, 0]]
d = [[0.25], [0]]
[[observer]]
kind = "unknown-input"
e = [[0], [1], [0]]
poles = [-1, -3, -4]
"#;
    has_the_bits("unknown-input", linear, 2e-3);
    let reduced = linear.replace(
        "kind = \"unknown-input\"\ne = [[0], [1], [0]]\npoles = [-1, -3, -4]",
        "kind = \"reduced-order\"\npoles = [-3]",
    );
    has_the_bits("reduced-order", &reduced.replace("d = [[0.25], [0]]\n", ""), 2e-3);
    has_the_bits("unknown-cubic", &format!("{linear}gamma = 0.7\n"), 2e-3);
}

#[test]
fn immersion_and_invariance_observers_have_the_bits_of_their_export() {
    let immersion = |rest: &str| format!("{CONVERTER}kind = \"immersion-invariance\"\n{rest}");
    has_the_bits(
        "shifted",
        &immersion(
            r#"beta = ["chi1 + C2*50*v2", "chi2 - L3*i3"]
phi = ["i1", "v4"]
left_inverse = ["z1", "v2", "i3", "z2"]
"#,
        ),
        1e-5,
    );
    // chi has a third entry, which beta does not see at the start.
    has_the_bits(
        "wide",
        &immersion(
            r#"order = 3
beta = ["chi1 + chi3^2/8 + C2*50*v2", "chi2 + sin(chi1)/4 - L3*i3"]
phi = ["i1", "v4"]
left_inverse = ["z1", "v2", "i3", "z2"]
start = ["i1 - C2*50*v2", "v4 + L3*i3 - sin(i1 - C2*50*v2)/4", "0"]
q = ["-chi1", "duty", "-3*chi3 + v2/10"]
rho = ["chi3", "-chi1*duty"]
"#,
        ),
        1e-5,
    );
    // Four rows, and a lookup table in the plant.
    has_the_bits(
        "four-rows",
        r#"
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
"#,
        1e-2,
    );
}
