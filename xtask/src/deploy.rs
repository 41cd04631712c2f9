//! Exports in the hands of a user: each is built and run as `docs/deploy.md` says, and its golden vectors are compared
//! bit by bit. What is left out for lack of a tool is said.
//!
//! - C with CMake and with the C compiler alone.
//! - FMUs 2.0 and 3.0 with fmpy, which validates and simulates them. It is installed, at the version below, into a
//!   virtual environment under `target`.
//! - The Rust crate with its own test, and its static library with the test in C.

use crate::step::{Failure, build_command, cargo, is_installed, luenberger, program, root};
use std::fs;
use std::path::{Path, PathBuf};

/// Pinned, so that a failure can be repeated.
const FMPY: &str = "fmpy==0.3.32";

/// A plant with an observer in the loop.
pub(crate) const LOOP: &str = r#"
[plant]
a = [[0, 1], [0, 0]]
b = [[0], [1]]
c = [[1, 0]]
states = ["position", "velocity"]
units = ["m", "m/s"]
time_unit = "s"

[input]
feedback = { k = [[4, 4]], observer = "block" }

[simulation]
x0 = [1, 0]
duration = 5
samples = 101
hold = 0.05

[[observer]]
name = "block"
kind = "luenberger"
poles = [-6, -7]
"#;

/// A filter in the loop of a plant that depends on the time.
pub(crate) const TIMED: &str = r#"
[plant]
states = ["angle", "speed"]
inputs = ["torque"]
outputs = ["measured"]
f = ["speed", "-sin(angle) - 0.1*speed + torque + 0.1*sin(t)"]
h = ["angle"]
time_unit = "s"

[input]
feedback = { k = [[1, 1]], observer = "timed" }

[simulation]
x0 = [0.3, 0]
duration = 10
samples = 101
hold = 0.05

[[observer]]
name = "timed"
kind = "extended-kalman"
w = 1e-4
v = 1e-4
period = 0.05
"#;

/// A Kalman filter in filter form, of a plant with a feedthrough.
pub(crate) const FILTERED: &str = r#"
[plant]
a = [[0, 1], [-2, -1]]
b = [[0], [1]]
c = [[1, 0], [-2, -1]]
d = [[0], [1]]
states = ["position", "velocity"]
inputs = ["force"]
outputs = ["measured", "acceleration"]
time_unit = "s"

[input]
expressions = ["sin(t)"]

[simulation]
x0 = [1, 0]
duration = 10
samples = 101
hold = 0.05

[[observer]]
name = "filtered"
kind = "kalman"
w = [0, 0.1]
v = [0.001, 0.01]
form = "filter"
"#;

/// A moving-horizon estimator of a plant that depends on the time; the bound of the speed is active in the run.
pub(crate) const BOUNDED: &str = r#"
[plant]
states = ["angle", "speed"]
inputs = ["torque"]
outputs = ["measured"]
f = ["speed", "-sin(angle) - 0.1*speed + torque + 0.1*sin(t)"]
h = ["angle"]
time_unit = "s"

[input]
expressions = ["0.1*cos(t)"]

[simulation]
x0 = [0.3, 0]
duration = 10
samples = 101
hold = 0.05
noise = { amplitude = [0.05], period = 0.05, seed = 4 }

[[observer]]
name = "bounded"
kind = "mhe"
w = [0, 1e-2]
v = 1e-3
period = 0.05
substeps = 1
window = 3
iterations = 1
state_bounds = [[-inf, inf], [-0.2, 0.2]]
"#;

/// A numerical KKL observer with its interpolated left inverse.
pub(crate) const INTERPOLATED: &str = r#"
[plant]
f = ["x2^3", "-x1"]
h = ["x1"]

[simulation]
x0 = [0.5, 0.5]
duration = 20
samples = 401
rtol = 1e-7
atol = 1e-8

[[observer]]
name = "interpolated"
kind = "kkl-numerical"
domain = [[-1, 1], [-1, 1]]
cutoff = 1.5
points = 21
leaves = 16
samples = 4000
form = "interpolated"
"#;

/// Cubic observers at varying periods, with the closed form and with the semi-implicit step.
const VARYING: &str = include_str!("../../crates/study/tests/studies/varying_periods.toml");

/// A numerical KKL observer for an input that is held, with tables.
const HELD: &str = r#"
[plant]
f = ["x2", "-x1 - 0.5*x1^3 + u1"]
h = ["x1"]

[input]
expressions = ["0.4"]

[simulation]
x0 = [0.5, 0.1]
duration = 10
samples = 201

[[observer]]
name = "held"
kind = "kkl-numerical"
domain = [[-1.5, 1.5], [-1.5, 1.5]]
inputs = [[-0.5, 0.5]]
nodes = 3
cutoff = 3
points = 13
leaves = 8
samples = 1000
"#;

/// A numerical KKL observer for five states, with a table of low rank.
const LOW_RANK: &str = r#"
[plant]
f = ["x2", "-x1 - 0.1*x1^3 - 0.2*x2 + x3 + x5", "2*x4", "-2*x3", "-0.05*x5"]
h = ["x1"]

[simulation]
x0 = [0.2, 0.1, 0.2, 0, 0.1]
duration = 5
samples = 51

[[observer]]
name = "low rank"
kind = "kkl-numerical"
domain = [[-0.5, 0.5], [-0.8, 0.8], [-0.3, 0.3], [-0.3, 0.3], [-0.2, 0.2]]
cutoff = 4
points = 5
rank = 8
leaves = 1
degree = 2
samples = 500
"#;

/// An observer of a study and how it is exported.
struct Case {
    study: PathBuf,
    observer: &'static str,
    /// The name of its files.
    name: &'static str,
    options: &'static [&'static str],
    /// Whether it has an FMU.
    has_fmu: bool,
}

pub(crate) fn run() -> Result<(), Failure> {
    let folder = root().join("target/deploy");
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    build_command()?;
    let [cart, converter] = ["cart.toml", "converter.toml"].map(|name| folder.join(name));
    luenberger(&["new", "--force", "-o"]).argument(&cart).step("study")?;
    luenberger(&["new", "--plant", "cuk", "--force", "-o"]).argument(&converter).step("study")?;
    let write = |name: &str, text: &str| {
        let file = folder.join(name);
        fs::write(&file, text).map(|()| file.clone()).map_err(|source| Failure::io(&file, source))
    };
    let (looped, timed) = (write("loop.toml", LOOP)?, write("timed.toml", TIMED)?);
    let (filtered, interpolated) = (write("filtered.toml", FILTERED)?, write("interpolated.toml", INTERPOLATED)?);
    let (varying, held) = (write("varying.toml", VARYING)?, write("held.toml", HELD)?);
    let (bounded, low_rank) = (write("bounded.toml", BOUNDED)?, write("low_rank.toml", LOW_RANK)?);
    let tanks = write("tanks.toml", &of_the_page()?)?;
    let case = |study: &PathBuf, observer, name, options| {
        let study = study.clone();
        Case { study, observer, name, options, has_fmu: true }
    };
    let of_cart = |name, options| case(&cart, name, name, options);
    // Its step takes the time, an FMU has a fixed one.
    let at_varying = |name, options| Case { has_fmu: false, ..case(&varying, name, name, options) };
    let cases = [
        case(&tanks, "one gain", "one_gain", &[]),
        case(&converter, "filter", "filter", &["--unproved"]),
        of_cart("linear", &[]),
        of_cart("cubic", &["--format", "f32"]),
        of_cart("sampled", &[]),
        case(&looped, "block", "block", &["--feedback"]),
        case(&timed, "timed", "timed", &["--feedback", "--unproved"]),
        case(&bounded, "bounded", "bounded", &["--unproved"]),
        case(&filtered, "filtered", "filtered", &[]),
        case(&interpolated, "interpolated", "interpolated", &["--unproved", "--period", "0.01"]),
        at_varying("radial", &["--format", "f32"]),
        at_varying("weighted", &[]),
        case(&held, "held", "held", &["--unproved", "--period", "0.01"]),
        case(&low_rank, "low rank", "low_rank", &["--unproved", "--period", "0.02"]),
    ];
    let mut skipped = Vec::new();
    let compiler = ["cc", "gcc", "clang"].into_iter().find(|name| is_installed(name));
    let python = if compiler.is_some() { fmpy(&mut skipped) } else { None };
    if compiler.is_none() {
        skipped.push("everything in C: no C compiler is installed");
    } else if !is_installed("cmake") {
        skipped.push("C with CMake, which is not installed");
    }
    for case in &cases {
        if let Some(compiler) = compiler {
            c(&folder, case, compiler)?;
        }
        if let Some(python) = python.as_ref().filter(|_| case.has_fmu) {
            for version in ["2", "3"] {
                let out = case.export(&folder, "fmu", &["--fmi", version])?;
                let name = format!("{}, FMI {version}", case.observer);
                program(python).argument(out.join(format!("test_{}.py", case.name))).step(&name)?;
            }
        }
        rust(&folder, case, compiler)?;
    }
    for what in skipped {
        eprintln!("── NOT RUN: {what}");
    }
    Ok(())
}

/// The study in the block of the page `docs/deploy.md`.
fn of_the_page() -> Result<String, Failure> {
    let page = root().join("docs/deploy.md");
    let text = fs::read_to_string(&page).map_err(|source| Failure::io(&page, source))?;
    let block = text.split("```toml tanks.toml\n").nth(1).and_then(|rest| rest.split("```").next());
    let missing = || Failure::io(&page, std::io::Error::other("the page has no block tanks.toml"));
    block.map(str::to_owned).ok_or_else(missing)
}

impl Case {
    fn export(&self, folder: &Path, to: &str, more: &[&str]) -> Result<PathBuf, Failure> {
        let out = folder.join(format!("{}-{to}{}", self.name, more.concat()));
        luenberger(&["export", "--observer", self.observer, "--to", to, "--force", "-o"])
            .argument(&out)
            .arguments(self.options)
            .arguments(more)
            .argument(&self.study)
            .quiet_output(&format!("{} --to {to}", self.observer))?;
        Ok(out)
    }
}

/// The Python of a virtual environment with fmpy.
fn fmpy(skipped: &mut Vec<&'static str>) -> Option<PathBuf> {
    let environment = root().join("target/fmpy-venv");
    let python = environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let made = python.exists()
        || program("python3").arguments(&["-m", "venv"]).argument(&environment).step("virtual environment").is_ok();
    if made && program(&python).arguments(&["-m", "pip", "install", "--quiet", FMPY]).step("fmpy").is_ok() {
        return Some(python);
    }
    skipped.push("FMUs with fmpy, which cannot be installed (python3 with venv and the network are needed)");
    None
}

fn c(folder: &Path, case: &Case, compiler: &str) -> Result<(), Failure> {
    let out = case.export(folder, "c", &[])?;
    let name = case.name;
    let (source, test) = (format!("{name}.c"), format!("test_{name}.c"));
    program(compiler)
        .folder(&out)
        .arguments(&["-std=c99", "-O2", &source, &test, "-lm", "-o", "golden"])
        .step(&format!("{name} in C: {compiler}"))?;
    program(out.join("golden")).step(&format!("{name} in C"))?;
    if is_installed("cmake") {
        let build = ["-S", ".", "-B", "build", "-DCMAKE_BUILD_TYPE=Release"];
        program("cmake").folder(&out).arguments(&build).quiet_output(&format!("{name} in C: cmake"))?;
        program("cmake").folder(&out).arguments(&["--build", "build"]).quiet_output(&format!("{name} in C: build"))?;
        program(out.join("build").join(format!("test_{name}"))).step(&format!("{name} in C by CMake"))?;
        part_of_a_project(folder, case, &out)?;
    }
    Ok(())
}

/// The export as a folder of another project, by its target `NAME::NAME`: for this computer, without its test, and,
/// where the compiler is installed, for a Cortex-M4 without an operating system.
fn part_of_a_project(folder: &Path, case: &Case, export: &Path) -> Result<(), Failure> {
    let (name, upper) = (case.name, case.name.to_uppercase());
    let parent = folder.join(format!("{name}-parent"));
    let written = |file: &str, text: String| {
        let path = parent.join(file);
        fs::create_dir_all(&parent).and_then(|()| fs::write(&path, text)).map_err(|source| Failure::io(&path, source))
    };
    written(
        "CMakeLists.txt",
        format!(
            "cmake_minimum_required(VERSION 3.10)\nproject(parent C)\nadd_subdirectory(\"{}\" observer)\n\
             add_library(parent STATIC parent.c)\ntarget_link_libraries(parent PRIVATE {name}::{name})\n\
             if(TARGET test_{name})\n  message(FATAL_ERROR \"the test is built\")\nendif()\n",
            export.display()
        ),
    )?;
    written(
        "parent.c",
        format!(
            "#include \"{name}.h\"\n\nconst char *const names[] = {upper}_STATE_NAMES;\n\
             const char *const digest = {upper}_DIGEST;\nconst double period = {upper}_PERIOD;\n\
             {name}_state observer;\n\nvoid start(void)\n{{\n    {name}_reset(&observer);\n}}\n"
        ),
    )?;
    let mut builds = vec![("build", Vec::new(), format!("{name} in C: part of a project"))];
    if is_installed("arm-none-eabi-gcc") {
        let toolchain = "set(CMAKE_SYSTEM_NAME Generic)\nset(CMAKE_SYSTEM_PROCESSOR arm)\n\
                         set(CMAKE_C_COMPILER arm-none-eabi-gcc)\nset(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)\n\
                         set(CMAKE_C_FLAGS_INIT \"-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16\")\n";
        written("cortex-m4.cmake", toolchain.to_owned())?;
        let chosen = vec!["-DCMAKE_TOOLCHAIN_FILE=cortex-m4.cmake"];
        builds.push(("build-m4", chosen, format!("{name} in C: part of a project for a Cortex-M4")));
    }
    for (build, chosen, what) in builds {
        let configure = program("cmake").folder(&parent).arguments(&["-S", ".", "-B", build]).arguments(&chosen);
        configure.quiet_output(&what)?;
        program("cmake").folder(&parent).arguments(&["--build", build]).step(&what)?;
    }
    Ok(())
}

/// The crate finds `luenberger-observers` in this workspace.
fn rust(folder: &Path, case: &Case, compiler: Option<&str>) -> Result<(), Failure> {
    let out = case.export(folder, "rust", &[])?;
    let name = case.name;
    let observers = root().join("crates/observers");
    let patch = format!("patch.crates-io.luenberger-observers.path={:?}", observers.display().to_string());
    let built = folder.join("rust-target");
    let at = |step: crate::step::Step, folder: &Path| {
        step.arguments(&["--quiet", "--config", &patch, "--target-dir"]).argument(&built).folder(folder)
    };
    at(cargo(&["test"]), &out).step(&format!("{name} in Rust"))?;
    let Some(compiler) = compiler else { return Ok(()) };
    at(cargo(&["build", "--release"]), &out.join("c")).step(&format!("{name} as a static library"))?;
    program(compiler)
        .folder(out.join("c"))
        .arguments(&["-std=c99", &format!("test_{name}.c")])
        .argument(built.join(format!("release/lib{name}.a")))
        .arguments(&["-lm", "-o", "golden"])
        .step(&format!("{name} as a static library: {compiler}"))?;
    program(out.join("c/golden")).step(&format!("{name} as a static library in C"))
}
