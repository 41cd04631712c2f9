//! The Python package: its wheel, in an environment of its own, tested as its users have it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::step::{Failure, Step, cargo, is_installed, program, root};

/// What the tests compare with, and what builds and checks the package. None of it is part of the wheel.
const PACKAGES: [&str; 16] = [
    "maturin>=1.16,<2",
    "numpy",
    "scipy",
    "control>=0.10.2",
    "slycot",
    "filterpy",
    "pandas",
    "sympy",
    "matplotlib",
    "tqdm",
    "distributed>=2024.8",
    "pytest",
    "mypy",
    "nbclient",
    "nbformat",
    "ipykernel",
];

/// The first version for which the wheel is built.
const LEAST: &str = "import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 10))";

/// Builds the wheel, installs it, and runs pytest (with the notebooks), the doctests, mypy and stubtest; and the wheel
/// with numpy alone. Without Python or the network it says so and does nothing.
pub(crate) fn run() -> Result<(), Failure> {
    let Some(environment) = environment("python-venv", &PACKAGES) else {
        eprintln!("── NOT RUN: the Python package (python3 from 3.10 on with venv, and the network are needed)");
        return Ok(());
    };
    let folder = root().join("crates/python");
    let wheels = root().join("target/wheels");
    if wheels.exists() {
        fs::remove_dir_all(&wheels).map_err(|source| Failure::io(&wheels, source))?;
    }
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    let build = ["-m", "maturin", "build", "--quiet", "--locked", "--profile", "quick", "--out"];
    at(&environment, &folder)
        .arguments(&build)
        .argument(&wheels)
        .argument("--interpreter")
        .argument(&environment)
        .variable("CARGO_TARGET_DIR", &target.to_string_lossy())
        .step("wheel")?;
    let wheel = only_file(&wheels)?;
    let install = ["-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps"];
    at(&environment, &folder).arguments(&install).argument(&wheel).step("installation")?;
    // One thread for each product of small matrices: more wait for each other.
    let pytest = |arguments: &[&str], name: &str| {
        let step = at(&environment, &folder).arguments(&["-m", "pytest", "-q", "-p", "no:cacheprovider"]);
        step.arguments(arguments).variable("OPENBLAS_NUM_THREADS", "1").step(name)
    };
    pytest(&["tests"], "pytest")?;
    pytest(&["--doctest-modules", "--pyargs", "luenberger"], "doctests")?;
    at(&environment, &folder).arguments(&["-m", "mypy", "-p", "luenberger"]).step("mypy")?;
    let stubs = ["-m", "mypy.stubtest", "luenberger", "--mypy-config-file", "pyproject.toml"];
    at(&environment, &folder).arguments(&stubs).step("stubtest")?;
    cargo(&["fmt", "--check"]).folder(&folder).step("format")?;

    let Some(bare) = self::environment("python-bare-venv", &["numpy"]) else {
        eprintln!("── NOT RUN: the wheel with numpy alone (no environment)");
        return Ok(());
    };
    at(&bare, &folder).arguments(&install).argument(&wheel).step("installation beside numpy")?;
    at(&bare, &folder).argument("tests/bare.py").step("with numpy alone")
}

/// Builds the wheels that are given away, optimised, and the source distribution.
///
/// On Linux with zig's linker, for manylinux2014, also for the targets of other processors; elsewhere with the linker
/// of the system. The wheel of this machine is installed beside numpy alone, and tried.
pub(crate) fn wheel(targets: &[String]) -> Result<(), Failure> {
    let is_linux = cfg!(target_os = "linux");
    let tools = if is_linux { &["maturin>=1.16,<2", "ziglang"][..] } else { &["maturin>=1.16,<2"] };
    let (Some(python), Some(bare)) =
        (environment("python-wheel-venv", tools), environment("python-bare-venv", &["numpy"]))
    else {
        eprintln!("── NOT RUN: the wheels (python3 from 3.10 on with venv, and the network are needed)");
        return Ok(());
    };
    let folder = root().join("crates/python");
    let wheels = root().join("target/dist");
    if wheels.exists() {
        fs::remove_dir_all(&wheels).map_err(|source| Failure::io(&wheels, source))?;
    }
    // zig is found by way of the Python of the environment.
    let path = std::env::var_os("PATH").unwrap_or_default();
    let beside = python.parent().into_iter().map(Path::to_path_buf).chain(std::env::split_paths(&path));
    let path = std::env::join_paths(beside).unwrap_or(path);
    let maturin = |arguments: &[&str]| {
        let step = at(&python, &folder).variable("PATH", &path.to_string_lossy());
        step.arguments(&["-m", "maturin"]).arguments(arguments).argument("--out").argument(&wheels)
    };
    let build = |more: &[&str]| {
        let linux: &[&str] = if is_linux { &["--zig", "--compatibility", "manylinux2014"] } else { &[] };
        maturin(&["build", "--quiet", "--locked", "--release"]).arguments(linux).arguments(more)
    };
    if targets.is_empty() {
        build(&["--interpreter"]).argument(&python).step("wheel")?;
        let install = ["-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps"];
        at(&bare, &folder).arguments(&install).argument(only_file(&wheels)?).step("installation")?;
        at(&bare, &folder).argument("tests/bare.py").step("with numpy alone")?;
    }
    for target in targets {
        build(&["--target", target]).step(target)?;
    }
    maturin(&["sdist"]).step("sources")?;
    for entry in fs::read_dir(&wheels).map_err(|source| Failure::io(&wheels, source))?.flatten() {
        let size = entry.metadata().map_or(0, |file| file.len());
        println!("{}: {:.1} MB", entry.path().display(), size as f64 / 1e6);
    }
    Ok(())
}

fn at(python: &Path, folder: &Path) -> Step {
    program(python).folder(folder)
}

/// The Python of an environment under `target` with these packages; none if there is no way to it.
fn environment(name: &str, packages: &[&str]) -> Option<PathBuf> {
    let environment = root().join("target").join(name);
    let python = environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    if !python.exists() {
        let is_recent = is_installed("python3") && program("python3").arguments(&["-c", LEAST]).step("python3").is_ok();
        if !is_recent {
            return None;
        }
        program("python3").arguments(&["-m", "venv"]).argument(&environment).step("virtual environment").ok()?;
    }
    // Compiling what is never imported would take as long as the download.
    let install = ["-m", "pip", "install", "--quiet", "--no-compile", "--prefer-binary"];
    let install = program(&python).arguments(&install).arguments(packages);
    install.step("packages").ok()?;
    Some(python)
}

fn only_file(folder: &Path) -> Result<PathBuf, Failure> {
    let found = fs::read_dir(folder).and_then(|mut entries| entries.next().transpose());
    let missing = || Failure::io(folder, std::io::Error::other("no wheel was built"));
    found.map_err(|source| Failure::io(folder, source))?.map(|entry| entry.path()).ok_or_else(missing)
}
