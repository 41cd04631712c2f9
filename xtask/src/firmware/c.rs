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
const DEVIATIONS: [&str; 5] = ["2.2", "2.5", "8.7", "8.9", "15.5"];

/// Further ones in elementary functions.
const OF_LIBM: [&str; 9] = ["9.3", "10.1", "10.3", "10.6", "10.8", "12.1", "12.2", "14.4", "21.15"];

/// What cppcheck does not have to say: findings of style that are no rules of MISRA, and what it did.
const SUPPRESSED: [&str; 6] = [
    "missingIncludeSystem",
    "knownConditionTrueFalse",
    "moduloofone",
    "variableScope",
    "unmatchedSuppression",
    "checkersReport",
];

/// A function that breaks a rule: a check that does not find it has not read the file.
const BROKEN: &str = "\nint broken(int a);\nint broken(int a)\n{\n    return (int)(a + 1u);\n}\n";

fn misra(exports: &Path, names: &[String]) -> Result<(), Failure> {
    for (k, name) in names.iter().enumerate() {
        let folder = exports.join(name);
        let path = folder.join(format!("{name}.c"));
        let source = fs::read_to_string(&path).map_err(|source| Failure::io(&path, source))?;
        let found: Vec<String> = findings(&folder, name)?
            .lines()
            .filter(|line| is_unexpected(line, name, &source))
            .map(str::to_owned)
            .collect();
        if !found.is_empty() {
            return Err(Failure::Firmware(format!("cppcheck of {name}.c: {}", found.join("\n"))));
        }
        if k == 0 {
            let path = folder.join("broken.c");
            fs::write(&path, format!("{source}{BROKEN}")).map_err(|source| Failure::io(&path, source))?;
            if !findings(&folder, "broken")?.contains("misra-c2012-10.4") {
                return Err(Failure::Firmware("cppcheck does not find a broken rule".to_owned()));
            }
        }
    }
    eprintln!("── cppcheck: emitted C of {} observers has no finding but the deviations listed", names.len());
    Ok(())
}

/// What cppcheck prints of a file. It does not read `float.h`: without its values the guards of the source would leave
/// nothing of the file. `information` has it say so where it does not analyse one.
fn findings(folder: &Path, name: &str) -> Result<String, Failure> {
    let checked = Command::new("cppcheck")
        .current_dir(folder)
        .args(["--addon=misra", "--std=c99", "--quiet", "--inline-suppr"])
        .args(["-DFLT_MANT_DIG=24", "-DDBL_MANT_DIG=53", "-DFLT_EVAL_METHOD=0"])
        .arg("--enable=warning,style,performance,portability,information")
        .args(SUPPRESSED.map(|finding| format!("--suppress={finding}")))
        .arg(format!("{name}.c"))
        .output()
        .map_err(|source| Failure::io("cppcheck", source))?;
    // Its exit code says nothing of findings in headers; it prints them all.
    let found = String::from_utf8_lossy(&checked.stderr).into_owned();
    if checked.status.success() { Ok(found) } else { Err(Failure::Firmware(format!("cppcheck of {name}.c: {found}"))) }
}

/// Whether a line of cppcheck is a finding, and none of a deviation.
fn is_unexpected(line: &str, name: &str, source: &str) -> bool {
    let Some(finding) = line.rsplit_once('[').and_then(|(_, rest)| rest.strip_suffix(']')) else {
        // The lines below a finding show its place.
        return false;
    };
    let Some(rule) = finding.strip_prefix("misra-c2012-") else { return !line.starts_with(' ') };
    let mut place = line.split(':');
    let is_source = place.next() == Some(format!("{name}.c").as_str());
    let number = place.next().and_then(|number| number.parse().ok()).unwrap_or(0);
    let is_of_libm = is_source && OF_LIBM.contains(&rule) && is_in_libm(name, source, number);
    !DEVIATIONS.contains(&rule) && !is_of_libm
}

/// Whether a line, from 1, lies in an elementary function, whose names begin with that of the export.
fn is_in_libm(name: &str, source: &str, line: usize) -> bool {
    let functions = source.lines().take(line).filter(|line| line.ends_with(')') && !line.starts_with([' ', '#', '/']));
    let prefix = format!(" {name}_");
    functions.last().is_some_and(|function| function.starts_with("static") && function.contains(&prefix))
}
