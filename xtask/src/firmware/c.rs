//! Emitted C on the host: with every compiler and many flags the same bits, no undefined behaviour, and MISRA's rules
//! but for the deviations that `docs/deploy.md` lists.

use super::output::{self, Golden};
use crate::step::{Failure, cargo, is_installed, program, root};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Optimisation must not change a bit.
const FLAGS: [&[&str]; 4] = [&["-O0"], &["-Os"], &["-O2"], &["-O3", "-march=haswell", "-ffp-contract=off"]];

const SANITISERS: [&str; 3] = ["-O1", "-fsanitize=undefined,address", "-fno-sanitize-recover=all"];

/// What was left out.
pub(super) fn on_the_host(exports: &Path, names: &[String], golden: &[Golden]) -> Result<Vec<String>, Failure> {
    let mut skipped = Vec::new();
    for compiler in ["gcc", "clang"] {
        if !is_installed(compiler) {
            skipped.push(format!("emitted C on the host with {compiler}, which is not installed"));
            continue;
        }
        let mut flags: Vec<&[&str]> = FLAGS.into_iter().filter(|flags| has_fma() || flags.len() == 1).collect();
        if !has_fma() {
            skipped.push(format!("{compiler} -march=haswell, which this processor does not run"));
        }
        if can_sanitise(exports, compiler) {
            flags.push(&SANITISERS);
        } else {
            skipped.push(format!("sanitizers of {compiler}, which are not installed"));
        }
        for name in names {
            for flags in &flags {
                compare(exports, name, golden, compiler, flags)?;
            }
        }
        eprintln!(
            "── {compiler}: emitted C of {} observers, {} builds of each, every step the same",
            names.len(),
            flags.len()
        );
    }
    let compilers: Vec<&str> = ["gcc", "clang"].into_iter().filter(|name| is_installed(name)).collect();
    if !compilers.is_empty() {
        // `cargo test` takes the first of them, and a part of the options and of the random observers.
        cargo(&["test", "--quiet", "--package", "luenberger-export", "--test", "it"])
            .variable("EVERY_C_COMPILER", "1")
            .quiet_output("tests of exports")?;
        eprintln!("── tests of exports: passed, all of them, with {}", compilers.join(" and "));
    }
    if is_installed("cppcheck") {
        misra(exports, names)?;
    } else {
        skipped.push("MISRA's rules: cppcheck is not installed".to_owned());
    }
    Ok(skipped)
}

fn compare(exports: &Path, name: &str, golden: &[Golden], compiler: &str, flags: &[&str]) -> Result<(), Failure> {
    let folder = exports.join(name);
    let build = || program(compiler).folder(&folder).argument("-std=c99").arguments(flags);
    let object = format!("{name}.o");
    build()
        .arguments(&["-Wall", "-Wextra", "-Wconversion", "-Werror", "-c", &format!("{name}.c"), "-o", &object])
        .quiet_output(name)?;
    build()
        .argument("-I.")
        .argument(root().join("firmware/host/c/main.c"))
        .arguments(&[&object, "-lm", "-o", "host"])
        .quiet_output(name)?;
    let found = output::read(&program(folder.join("host")).quiet_output(name)?)?;
    output::of(golden, name)?.compare(&found[0], &format!("{compiler} {}", flags.join(" ")))
}

/// Whether this processor runs code for Haswell, which has fused multiply-adds.
fn has_fma() -> bool {
    #[cfg(target_arch = "x86_64")]
    let there = std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    let there = false;
    there
}

fn can_sanitise(exports: &Path, compiler: &str) -> bool {
    let (source, image) = (exports.with_file_name("empty.c"), exports.with_file_name("empty"));
    let written = fs::write(&source, "int main(void) { return 0; }\n");
    let built = Command::new(compiler).args(SANITISERS).arg(&source).arg("-o").arg(&image).output();
    written.is_ok() && built.is_ok_and(|built| built.status.success())
}

/// Rules that emitted code breaks on purpose; `docs/deploy.md` has the reasons.
const DEVIATIONS: [&str; 3] = ["misra-c2012-2.5", "misra-c2012-8.7", "misra-c2012-8.9"];

fn misra(exports: &Path, names: &[String]) -> Result<(), Failure> {
    for name in names {
        let checked = Command::new("cppcheck")
            .current_dir(exports.join(name))
            .args(["--addon=misra", "--std=c99", "--quiet", "--inline-suppr", "--suppress=missingIncludeSystem"])
            .arg("--enable=warning,style,performance,portability")
            .args(DEVIATIONS.map(|rule| format!("--suppress={rule}")))
            .arg(format!("{name}.c"))
            .output()
            .map_err(|source| Failure::io("cppcheck", source))?;
        // Its exit code says nothing of findings in headers; it prints them all.
        let found = String::from_utf8_lossy(&checked.stderr);
        if !checked.status.success() || !found.trim().is_empty() {
            return Err(Failure::Firmware(format!("cppcheck of {name}.c: {}", found.trim())));
        }
    }
    eprintln!("── cppcheck: emitted C of {} observers has no finding but the deviations listed", names.len());
    Ok(())
}
