//! `cargo xtask lint`: all checks that run no test.

use std::path::Path;

use crate::step::{Failure, Step, cargo, is_installed, packages, program};
use crate::{features, skipped};

pub(crate) fn run() -> Result<(), Failure> {
    cargo(&["fmt", "--all", "--check"]).step("format")?;
    cargo(&["fmt", "--manifest-path", "xtask/mutants/Cargo.toml", "--check"]).step("format of what makes mutants")?;
    // A dependency added to a crate that firmware/ uses has to be in its lock file, too.
    cargo(&["metadata", "--manifest-path", "firmware/Cargo.toml", "--locked", "--format-version", "1"])
        .output("lock file of firmware")?;
    features::check()?;
    cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]).step("clippy")?;
    let doc = cargo(&["doc", "--workspace", "--no-deps"]).variable("RUSTDOCFLAGS", "-D warnings");
    lints()?.into_iter().flatten().fold(doc, |doc, (name, value)| doc.variable(name, &value)).step("documentation")?;
    // Other members turn on the feature `clarabel` of lmi. Nothing but lmi is checked for it, because the features of
    // all that it stands on are those of the workspace.
    let clippy = |arguments: &[&str]| cargo(&["clippy"]).arguments(arguments).arguments(&["--", "-D", "warnings"]);
    clippy(&["--package", "luenberger-lmi", "--all-targets"]).step("lmi without Clarabel")?;
    // Without development dependencies, which bring the allocator and the standard library.
    clippy(&["--package", "luenberger-observers", "--no-default-features"]).step("observers without allocator")?;
    let tests = ["--package", "luenberger-observers-tests", "--no-default-features", "--features", "serde", "--tests"];
    clippy(&tests).step("observers without dual numbers")?;
    // What is in the packages, not whether they compile: `cargo package --workspace` does both, in twice the time.
    let package = cargo(&["package", "--workspace", "--no-verify", "--allow-dirty", "--quiet"]);
    unpublished()?.iter().fold(package, Step::argument).step("packages")?;
    if is_installed("cargo-deny") {
        cargo(&["deny", "--offline", "check", "licenses", "bans", "sources"]).step("licences")?;
    } else {
        skipped("licences and sources of the dependencies", "cargo-deny");
    }
    if is_installed("typos") {
        program("typos").step("spelling")?;
    } else {
        skipped("spelling", "typos-cli");
    }
    Ok(())
}

/// The members that are not published, as arguments.
fn unpublished() -> Result<Vec<String>, Failure> {
    let packages = packages()?;
    let unpublished = packages.as_array().into_iter().flatten();
    let unpublished = unpublished.filter(|package| package["publish"].as_array().is_some_and(Vec::is_empty));
    Ok(unpublished.filter_map(|package| Some(format!("--exclude={}", package["name"].as_str()?))).collect())
}

/// What `cargo clippy -- -D warnings` sets in the environment, with which `cargo doc` takes the crates as clippy has
/// checked them; nothing where clippy is not beside the compiler. Should clippy's own differ, the crates are checked
/// again.
fn lints() -> Result<Option<[(&'static str, String); 2]>, Failure> {
    let compiler = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let sysroot = program(compiler).arguments(&["--print", "sysroot"]).quiet_output("sysroot")?;
    let driver = Path::new(sysroot.trim()).join("bin").join(format!("clippy-driver{}", std::env::consts::EXE_SUFFIX));
    let Some(path) = driver.to_str().filter(|_| driver.is_file()) else { return Ok(None) };
    let mark = "__CLIPPY_HACKERY__";
    Ok(Some([("RUSTC_WORKSPACE_WRAPPER", path.to_owned()), ("CLIPPY_ARGS", format!("-D{mark}warnings{mark}"))]))
}
