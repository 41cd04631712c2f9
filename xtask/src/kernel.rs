//! Certificates before the kernel of Coq: the theory in `proofs/`, the files of templates and examples, forged files,
//! and refutations.
//!
//! - The theory is compiled once for each content (kept by digest in `target/kernel`), with no `Admitted` and no axiom
//!   of its own.
//! - Every certificate of a template or example that has a file for Coq is compiled, and what its theorems assume has
//!   to be among [`AXIOMS`], those of Coq's real numbers.
//! - Of each file some numbers are changed so that it becomes false ([`forgeries`]): the checker has to refuse it.
//! - Of each certificate two or three false ones are made, with digests that fit: their refutations have to be
//!   accepted, and those of data between bounds with a matrix that is not between them refused.
//! - Random designs of each theorem are compiled, some of them forged, too, and of their mutants in `cargo xtask stress
//!   theorems` that are refuted some are forged, with and without margins (`luenberger-tests`, `falsify::forged`): the
//!   checker has to refuse them.
//! - The refutations of the papers' claims that the ledger marks (`luenberger-reproduce --coq`) have to be accepted.

use crate::step::{Failure, build, build_command, built, is_installed, program, root};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// What the theorems may assume: the axioms from which Coq's library builds the real numbers, and those that it proves
/// about them.
const AXIOMS: [&str; 4] = [
    "ClassicalDedekindReals.sig_not_dec",
    "ClassicalDedekindReals.sig_forall_dec",
    "FunctionalExtensionality.functional_extensionality_dep",
    "Classical_Prop.classic",
];

/// What does not occur in the theory or a file.
const FORBIDDEN: [&str; 8] =
    ["Admitted", "admit.", "Axiom", "Parameter", "Conjecture", "bypass_check", "Unset Guard", "Unset Universe"];

/// Templates that take long and have no certificate of these kinds.
const WITHOUT: [&str; 3] = ["cuk-table-1", "duffing", "van-der-pol"];

/// Longer files, in bytes, take minutes: they are named and left out.
const LARGEST: usize = 60_000;

/// Up to this length a file is forged, too: one of twenty states takes as long as twenty of two.
const LARGEST_FORGED: usize = 17_000;

/// The margins that are forged.
const MARGINS: [&str; 15] = [
    "margin_P",
    "margin_P1",
    "margin_12",
    "margin_12_1",
    "margin_13",
    "margin_25",
    "margin_F",
    "margin_F_1",
    "margin_F_2",
    "margin_w",
    "margin_theta",
    "margin_S",
    "margin",
    // Those of an observer that converges from an ellipsoid.
    "q",
    "mu",
];

/// Refuted mutants of each theorem, and the seed.
const MUTANTS: &str = "2";
const SEED: &str = "2019";

/// Claims of the papers with a refutation for Coq.
const CLAIMS: usize = 3;

pub(crate) fn run() -> Result<(), Failure> {
    if !is_installed("coqc") {
        eprintln!("── SKIPPED: certificates before the kernel of Coq. To have it: apt install coq");
        return Ok(());
    }
    let theory = theory()?;
    build_command()?;
    let folder = root().join("target/kernel/certificates");
    _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    let certificates = certificates(&folder)?;
    let (mut jobs, mut left_out) = (Vec::new(), Vec::new());
    for certificate in &certificates {
        match written(certificate)? {
            Err(why) => left_out.push(shown(certificate, &why)),
            Ok(text) if text.len() > LARGEST => left_out.push(shown(certificate, "too long for this test")),
            Ok(text) => jobs.extend(jobs_of(certificate, &text)?),
        }
    }
    for line in &left_out {
        eprintln!("── left out: {line}");
    }
    let mutants = mutants(&folder)?;
    eprintln!("── {} files of random designs and forged from their mutants", mutants.len());
    jobs.extend(mutants);
    let claims = claims(&folder)?;
    let of_claims: Vec<String> = claims.iter().map(|job| shown(&job.path, "refuted")).collect();
    eprintln!("── claims of the papers: {}", of_claims.join(", "));
    if claims.len() < CLAIMS {
        return Err(Failure::Kernel(format!("only {} refutations of claims of the papers", claims.len())));
    }
    for claim in &claims {
        jobs.extend(forged_jobs(&claim.path, &claim.text));
    }
    jobs.extend(claims);
    let count = |kind: fn(&Expected) -> bool| jobs.iter().filter(|job| kind(&job.expected)).count();
    let proved = count(|expected| matches!(expected, Expected::Proved));
    let refuted = count(|expected| matches!(expected, Expected::Refuted));
    let forged = count(|expected| matches!(expected, Expected::Refused));
    if proved < 40 || refuted < 40 || forged < 3 * proved {
        return Err(Failure::Kernel(format!("only {proved} files, {refuted} refutations and {forged} forgeries")));
    }
    every(&jobs, &theory)?;
    eprintln!("── Coq: {proved} certificates proved, {refuted} refuted, {forged} forged files refused");
    Ok(())
}

/// Compiles the theory, if it is not there; the folder of what was compiled.
fn theory() -> Result<PathBuf, Failure> {
    let proofs = root().join("proofs");
    let read = |path: &Path| fs::read_to_string(path).map_err(|source| Failure::io(path, source));
    let project = read(&proofs.join("_CoqProject"))?;
    let names: Vec<&str> =
        project.lines().filter(|line| Path::new(line).extension().is_some_and(|end| end == "v")).collect();
    let mut digest = Sha256::new();
    digest.update(program("coqc").arguments(&["--version"]).quiet_output("the version of Coq")?);
    let mut files = Vec::new();
    for name in &names {
        let text = read(&proofs.join(name))?;
        allowed(name, &text)?;
        digest.update(name);
        digest.update(&text);
        files.push((name, text));
    }
    let found = fs::read_dir(&proofs).map_err(|source| Failure::io(&proofs, source))?;
    for file in found.flatten().filter(|file| file.path().extension().is_some_and(|end| end == "v")) {
        if !names.contains(&file.file_name().to_string_lossy().as_ref()) {
            return Err(Failure::Kernel(format!("{} is not in proofs/_CoqProject", file.path().display())));
        }
    }
    let digest: String = format!("{:x}", digest.finalize()).chars().take(16).collect();
    let folder = root().join("target/kernel").join(format!("theory-{digest}"));
    let done = folder.join("compiled");
    if done.exists() {
        return Ok(folder);
    }
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    for (name, text) in files {
        let path = folder.join(name);
        fs::write(&path, text).map_err(|source| Failure::io(&path, source))?;
        program("coqc").folder(&folder).arguments(&["-R", ".", "Luenberger", name]).step(&format!("proofs/{name}"))?;
    }
    fs::write(&done, "").map_err(|source| Failure::io(&done, source))?;
    Ok(folder)
}

/// Fails where a proof is left out.
fn allowed(name: &str, text: &str) -> Result<(), Failure> {
    match FORBIDDEN.iter().find(|word| text.contains(**word)) {
        Some(word) => Err(Failure::Kernel(format!("{name} contains {word}"))),
        None => Ok(()),
    }
}

/// The certificates of the templates and of the examples.
fn certificates(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let list = crate::step::luenberger(&["new", "--list"]).quiet_output("the templates")?;
    let names = list.lines().take_while(|line| !line.is_empty()).filter_map(|line| line.split_whitespace().next());
    let mut studies = Vec::new();
    for name in names.filter(|name| !WITHOUT.contains(name)) {
        let study = folder.join(name).join("study.toml");
        fs::create_dir_all(folder.join(name)).map_err(|source| Failure::io(folder, source))?;
        let path = study.to_string_lossy().into_owned();
        crate::step::luenberger(&["new", "--quiet", "--plant", name, "-o", &path]).quiet_output(name)?;
        studies.push((name.to_owned(), study));
    }
    let examples = root().join("examples/studies");
    let found = fs::read_dir(&examples).map_err(|source| Failure::io(&examples, source))?;
    for path in found.flatten().map(|file| file.path()).filter(|path| path.extension().is_some_and(|end| end == "toml"))
    {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        studies.push((format!("example-{name}"), path));
    }
    studies.sort();
    let mut certificates = Vec::new();
    for (name, study) in studies {
        let results = folder.join(&name).join("results");
        let mut certify = Command::new(built("luenberger"));
        certify.args(["certify", "--quiet"]).arg(&study).arg("-o").arg(&results);
        // A study of which an observer has no gain is a negative answer, with the certificates of the others.
        output(&mut certify)?;
        if let Ok(found) = fs::read_dir(results.join("certificates")) {
            certificates.extend(found.flatten().map(|file| file.path()));
        }
    }
    certificates.sort();
    Ok(certificates)
}

fn output(command: &mut Command) -> Result<Output, Failure> {
    command.output().map_err(|source| Failure::io(command.get_program(), source))
}

fn shown(path: &Path, what: &str) -> String {
    let short: PathBuf = path.components().skip_while(|part| part.as_os_str() != "certificates").skip(1).collect();
    format!("{} ({what})", short.display())
}

/// The file for Coq, or why there is none.
fn written(certificate: &Path) -> Result<Result<String, String>, Failure> {
    let mut verify = Command::new(built("luenberger"));
    let done = output(verify.args(["verify", "--coq", "-o", "-"]).arg(certificate))?;
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    if done.stdout.is_empty() {
        let known = ["has no proof in Coq", "do not cover", "is found that has room"];
        if known.iter().any(|known| said.contains(known)) {
            let why = said.split(".json: ").last().unwrap_or_default();
            return Ok(Err(why.split(':').next().unwrap_or_default().trim().to_owned()));
        }
        return Err(Failure::Kernel(format!("{}: {said}", certificate.display())));
    }
    Ok(Ok(String::from_utf8_lossy(&done.stdout).into_owned()))
}

/// What Coq should say of a file.
enum Expected {
    /// It accepts it, and it assumes no more than [`AXIOMS`].
    Proved,
    /// The same, of the refutation of a false certificate.
    Refuted,
    /// The checker does not return true.
    Refused,
}

struct Job {
    path: PathBuf,
    text: String,
    expected: Expected,
}

/// The file of a certificate, forged ones, and the refutations of false certificates.
fn jobs_of(certificate: &Path, text: &str) -> Result<Vec<Job>, Failure> {
    // The name of a file is that of a module.
    let stem = certificate.file_stem().unwrap_or_default().to_string_lossy();
    let stem: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let folder = certificate.with_file_name("");
    let path = |end: &str| folder.join(format!("{stem}{end}.v"));
    let mut jobs = vec![Job { path: path(""), text: with_assumptions(text), expected: Expected::Proved }];
    if text.len() > LARGEST_FORGED {
        return Ok(jobs);
    }
    jobs.extend(forged_jobs(&path(""), text));
    let source = fs::read_to_string(certificate).map_err(|source| Failure::io(certificate, source))?;
    for (name, pointers, number) in
        [("indefinite", INDEFINITE, "-0x1p40"), ("unstable", UNSTABLE, "0x1p40"), ("wide", WIDE, "0x1p40")]
    {
        let Some(changed) = false_certificate(&source, pointers, number)? else { continue };
        let file = folder.join(format!("{stem}_{name}.json"));
        fs::write(&file, changed).map_err(|source| Failure::io(&file, source))?;
        let text = written(&file)?.unwrap_or_default();
        if !text.contains("The certificate is false.") {
            return Err(Failure::Kernel(format!("{} is not refuted", file.display())));
        }
        let path = path(&format!("_{name}"));
        jobs.extend(outside(&path, &text));
        jobs.push(Job { path, text: with_assumptions(&text), expected: Expected::Refuted });
    }
    Ok(jobs)
}

/// Random designs of each theorem, and files forged from their refuted mutants.
fn mutants(folder: &Path) -> Result<Vec<Job>, Failure> {
    let (package, name, forged) = ("luenberger-tests", "falsify", folder.join("forged"));
    build(package, "--bin", name)?;
    let arguments = ["--coq", &forged.to_string_lossy(), "--mutants", MUTANTS, "--seed", SEED];
    program(built(name)).arguments(&arguments).quiet_output("forged files")?;
    let designs = jobs_in(&forged.join("designs"), || Expected::Proved, with_assumptions)?;
    let mut jobs = Vec::new();
    // Those of the sorts that templates need not have: data between bounds, ellipsoids, running observers.
    for design in designs.iter().filter(|design| design.path.to_string_lossy().ends_with("_2.v")) {
        jobs.extend(forged_jobs(&design.path, &design.text));
    }
    jobs.extend(designs);
    for part in ["mutants", "without_margins"] {
        jobs.extend(jobs_in(&forged.join(part), || Expected::Refused, ToOwned::to_owned)?);
    }
    Ok(jobs)
}

/// The refutations of the papers' claims.
fn claims(folder: &Path) -> Result<Vec<Job>, Failure> {
    let (name, refutations) = ("luenberger-reproduce", folder.join("papers"));
    build(name, "--bin", name)?;
    program(built(name)).arguments(&["--coq", &refutations.to_string_lossy()]).quiet_output("refutations")?;
    jobs_in(&refutations, || Expected::Refuted, with_assumptions)
}

/// A job for each file of a folder.
fn jobs_in(folder: &Path, expected: fn() -> Expected, text: fn(&str) -> String) -> Result<Vec<Job>, Failure> {
    let found = fs::read_dir(folder).map_err(|source| Failure::io(folder, source))?;
    let mut paths: Vec<PathBuf> = found.flatten().map(|file| file.path()).collect();
    paths.sort();
    let job = |path: PathBuf| {
        let read = fs::read_to_string(&path).map_err(|source| Failure::io(&path, source))?;
        Ok(Job { path, text: text(&read), expected: expected() })
    };
    paths.into_iter().map(job).collect()
}

/// The forgeries of a file, beside it.
fn forged_jobs(path: &Path, text: &str) -> Vec<Job> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let beside = |name: &str| path.with_file_name(format!("{stem}_{name}.v"));
    let job = |(name, text): (String, String)| Job { path: beside(&name), text, expected: Expected::Refused };
    forgeries(text).into_iter().map(job).collect()
}

/// P with a negative entry on its diagonal, and a plant that grows.
const INDEFINITE: &[&str] = &["/lyapunov/P/0/0"];
const UNSTABLE: &[&str] = &["/plant/A/0/0", "/vertices/0/A/0/0"];

/// An upper bound of a plant that grows.
const WIDE: &[&str] = &["/plant/A/0/0/1", "/vertices/0/A/0/0/1"];

/// The certificate with another number at the first of the pointers that there is, and a digest that fits; none where
/// there is none of them.
fn false_certificate(source: &str, pointers: &[&str], number: &str) -> Result<Option<String>, Failure> {
    let invalid = |error: serde_json::Error| Failure::Kernel(format!("a certificate: {error}"));
    let mut value: Value = serde_json::from_str(source).map_err(invalid)?;
    let Some(pointer) = pointers.iter().find(|pointer| value.pointer(pointer).is_some()) else { return Ok(None) };
    if let Some(entry) = value.pointer_mut(pointer) {
        *entry = json!(number);
    }
    if let Some(members) = value.as_object_mut() {
        members.remove("sha256");
    }
    // Without white space and with its members in order, a document of this crate is in the canonical form.
    let canonical = serde_json::to_string(&value).map_err(invalid)?;
    let digest = format!("{:x}", Sha256::digest(canonical.as_bytes()));
    value["sha256"] = json!(digest);
    serde_json::to_string(&value).map(Some).map_err(invalid)
}

/// The refutation of data between bounds, with matrices that are not between them.
fn outside(path: &Path, text: &str) -> Vec<Job> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let is_false = |block: &&str| block.contains("Definition A_false") || block.contains("Definition C_false");
    let job = |(k, block): (usize, &str)| {
        let text = text.replacen(block, &with_entry(block, "0x1p900")?, 1);
        Some(Job { path: path.with_file_name(format!("{stem}_outside_{k}.v")), text, expected: Expected::Refused })
    };
    text.split("\n\n").filter(is_false).enumerate().filter_map(job).collect()
}

/// The definition of a matrix with another first entry.
fn with_entry(block: &str, number: &str) -> Option<String> {
    let (head, tail) = block.split_once("[\n  [")?;
    let end = tail.find([';', ']'])?;
    Some(format!("{head}[\n  [{number}{}", &tail[end..]))
}

/// The file, and at its end the question what its theorems assume.
fn with_assumptions(text: &str) -> String {
    let names = text.lines().filter_map(|line| line.strip_prefix("Theorem ")?.strip_suffix(" :"));
    let names = names.collect::<Vec<_>>().join(", ");
    format!("{text}\nDefinition theorems := ({names}).\nPrint Assumptions theorems.\n")
}

/// Files that are false: each margin doubled, the first entry of P or P1 negative, a plant that grows, another gain K,
/// N with the other sign, a cubic flow that is too slow, V that falls faster than it does, an overshoot of 1 where P is
/// not a multiple of I; of an ellipsoid and of a deployed observer bounds of 0, and a level that is too high. Of the
/// papers' claims another error, or another direction of it, that does not stand still.
fn forgeries(text: &str) -> Vec<(String, String)> {
    let mut forged = Vec::new();
    let blocks: Vec<&str> = text.split("\n\n").collect();
    let mut change = |name: &str, block: &str, to: String| {
        forged.push((name.to_owned(), text.replacen(block, &to, 1)));
    };
    let value = |name: &str| {
        let start = format!("Definition {name} : Q := ");
        text.lines().find_map(|line| Some(line.strip_prefix(&start)?.strip_suffix('.')?.to_owned()))
    };
    let zero = Some("0x0p0".to_owned());
    for block in blocks {
        let Some(definition) = block.lines().position(|line| line.starts_with("Definition ")) else { continue };
        let line = block.lines().nth(definition).unwrap_or_default();
        let name = line.split_whitespace().nth(1).unwrap_or_default();
        let entry = |number: &str| with_entry(block, number);
        match name {
            "P" | "P1" | "P_stored" | "P1_stored" => change(name, block, entry("-0x1p0").unwrap_or_default()),
            "A" | "F" | "A_1" | "A_high" | "A_high_1" => change("A", block, entry("0x1p40").unwrap_or_default()),
            "rate" | "decay" | "decay_stored" | "decay_loop" | "decay_stored_loop" => {
                change(name, block, format!("Definition {name} : Q := 0x1p40."));
            }
            // A cubic term that drives the error away; of one that did so, one that does not.
            "N" => change("N", block, negated(block)),
            "e0" => change("e0", block, entry("0x1p0").unwrap_or_default()),
            "d" | "D" => change(name, block, entry("0x1p60").unwrap_or_default()),
            "s" => change(name, block, entry("0x0p0").unwrap_or_default()),
            "K" => change("K", block, entry("0x1p60").unwrap_or_default()),
            "w" if line.contains(" : Q := ") => change("w", block, format!("Definition {name} : Q := 0x1p-60.")),
            "w" => change("w", block, entry("0x1p40").unwrap_or_default()),
            "contraction" => change("contraction", block, format!("Definition {name} : Q := 0x0p0.")),
            // Bounds of theta, of C and of what N lacks, and an ellipsoid that is too large if N lacks something.
            // Of a deployed observer bounds of what a step adds.
            "t" | "kappa" | "rho" | "beta" | "limit" | "start" if value(name) != zero => {
                change(name, block, format!("Definition {name} : Q := 0x0p0."));
            }
            "level" if value("rho") != zero && value("t") != zero => {
                change(name, block, format!("Definition {name} : Q := 0x1p1000."));
            }
            _ if name
                .strip_prefix("overshoot")
                .is_some_and(|of| value(&format!("lower{of}")) != value(&format!("upper{of}"))) =>
            {
                change(name, block, format!("Definition {name} : Q := 0x1p0."));
            }
            _ if MARGINS.contains(&name) => {
                // Margins of 0 stay what they are.
                let number = line.rsplit(' ').next().unwrap_or_default().trim_end_matches('.');
                if number != "0x0p0" {
                    change(name, block, format!("Definition {name} : Q := 2 * ({number})."));
                }
            }
            _ => {}
        }
    }
    forged
}

/// The definition of a matrix with the other sign.
fn negated(block: &str) -> String {
    let (head, matrix) = block.split_once(":=").unwrap_or((block, ""));
    let (mut text, mut before) = (format!("{head}:="), ' ');
    for c in matrix.chars() {
        let is_first =
            !before.is_alphanumeric() && !matches!(before, '-' | '/' | '.') && (c == '-' || c.is_ascii_digit());
        match (is_first, c) {
            (true, '-') => {}
            (true, _) => text.extend(['-', c]),
            (false, _) => text.push(c),
        }
        before = c;
    }
    text
}

/// Runs the jobs, two at a time.
fn every(jobs: &[Job], theory: &Path) -> Result<(), Failure> {
    let (next, failed) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            if let Err(failure) = one(job, theory) {
                failed.lock().unwrap_or_else(PoisonError::into_inner).push(failure.to_string());
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(work);
        }
    });
    let failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
    if failed.is_empty() { Ok(()) } else { Err(Failure::Kernel(failed.join("\n"))) }
}

fn one(job: &Job, theory: &Path) -> Result<(), Failure> {
    let Job { path, text, expected } = job;
    allowed(&path.display().to_string(), text)?;
    fs::write(path, text).map_err(|source| Failure::io(path, source))?;
    let done = output(Command::new("coqc").arg("-R").arg(theory).arg("Luenberger").arg(path))?;
    let (printed, said) = (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
    let wrong = |what: &str| Err(Failure::Kernel(format!("{}: {what}\n{said}{printed}", path.display())));
    match expected {
        Expected::Refused if done.status.success() => wrong("a false file is accepted"),
        // Not for another reason, such as its syntax.
        Expected::Refused if !said.contains("has type \"true = true\"") => wrong("refused, but not by the checker"),
        Expected::Refused => Ok(()),
        _ if !done.status.success() => wrong("refused"),
        _ => {
            let assumed = assumptions(&printed);
            match assumed.iter().find(|name| !AXIOMS.contains(&name.as_str())) {
                Some(name) => wrong(&format!("{name} is assumed")),
                None if assumed.is_empty() => wrong("nothing is said of what is assumed"),
                None => Ok(()),
            }
        }
    }
}

/// The names in the answers to `Print Assumptions`: each at the beginning of a line, its type behind a colon there or
/// on the next line.
fn assumptions(printed: &str) -> Vec<String> {
    let lines = printed.lines().filter(|line| !line.starts_with([' ', '\t']) && !line.is_empty() && *line != "Axioms:");
    lines.filter_map(|line| line.split([' ', ':']).next()).map(ToOwned::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "(** A *)\nDefinition A : list (list Q) := [\n  [0x0p0; 0x1p0];\n  [0x0p0; 0x0p0]].\n\n(** P *)\n\
                        Definition P : list (list Q) := [\n  [0x1p1]].\n\n(** margin *)\nDefinition margin_P : Q := 0x1p-1.\n\n\
                        Theorem P_is_positive_definite :\n  0 < margin_P.\nProof. Qed.\n";

    #[test]
    fn forged_files_differ_in_one_number() {
        let forged = forgeries(FILE);
        let names: Vec<&str> = forged.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["A", "P", "margin_P"]);
        assert!(forged[0].1.contains("[0x1p40; 0x1p0];\n  [0x0p0; 0x0p0]]."));
        assert!(forged[1].1.contains("[-0x1p0]].\n\n(** margin *)"));
        assert!(forged[2].1.contains("Definition margin_P : Q := 2 * (0x1p-1)."));
    }

    #[test]
    fn a_matrix_is_negated_entry_by_entry() {
        let block = "(** N -1 *)\nDefinition N : list (list Q) := [\n  [-0x1.7p-3; 267/100];\n  [0x0p0; -1/2]].";
        let expected = "(** N -1 *)\nDefinition N : list (list Q) := [\n  [0x1.7p-3; -267/100];\n  [-0x0p0; 1/2]].";
        assert_eq!(negated(block), expected);
    }

    #[test]
    fn what_is_assumed_is_read() {
        let printed = "Axioms:\nClassical_Prop.classic : forall P : Prop, P \\/ ~ P\nReals.sig\n  : forall P\n";
        assert_eq!(assumptions(printed), ["Classical_Prop.classic", "Reals.sig"]);
        assert!(
            with_assumptions(FILE)
                .ends_with("\nDefinition theorems := (P_is_positive_definite).\nPrint Assumptions theorems.\n")
        );
        assert!(allowed("file", FILE).is_ok() && allowed("file", "Proof. Admitted.").is_err());
    }

    #[test]
    fn a_false_certificate_has_a_digest_that_fits() {
        let changed =
            false_certificate(r#"{"sha256": "", "b": 1, "a": ["0x1p0"]}"#, &["/c", "/a/0"], "0x1p40").unwrap();
        assert!(false_certificate("{}", &["/c"], "0x1p40").is_ok_and(|none| none.is_none()));
        // printf '{"a":["0x1p40"],"b":1}' | sha256sum
        assert_eq!(changed.as_deref(), Some(DIGESTED));
    }

    const DIGESTED: &str =
        r#"{"a":["0x1p40"],"b":1,"sha256":"f74ec36fc3dabe7b9df786cf200ec3835e6e01c7e1036b8453e583877ea85b16"}"#;
}
