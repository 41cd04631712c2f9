//! The toy crate in `tests/toy`: what becomes of each of its mutants is typed in here.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Copies the toy, runs the program on it, and returns what is known of each mutant, without its place and crate.
fn outcomes(name: &str, more: &[&str], code: i32) -> (Vec<(String, String)>, String) {
    let toy = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/toy");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    for file in ["Cargo.toml", "src/lib.rs", "tests/it.rs"] {
        let copy = folder.join("tree").join(file);
        std::fs::create_dir_all(copy.parent().unwrap()).unwrap();
        std::fs::copy(toy.join(file), copy).unwrap();
    }
    let out: PathBuf = folder.join("out");
    let mut command = Command::new(env!("CARGO_BIN_EXE_luenberger-mutants"));
    let listed = toy.join("mutants.json");
    let places = [("--tree", folder.join("tree")), ("--target", folder.join("target")), ("--out", out.clone())];
    for (name, path) in &places {
        command.arg(name).arg(path);
    }
    command.args(["--config", "none", "--listed"]).arg(listed).args(more);
    let output = command.output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(code), "{printed}{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(out.join("toy.txt")).unwrap();
    let line = |line: &str| {
        let (name, outcome) = line.rsplit_once(": ").unwrap();
        let (name, outcome) = name.strip_suffix(": does not compile").map_or((name, outcome), |name| (name, "refused"));
        (name.splitn(4, ':').nth(3).unwrap().trim().to_owned(), outcome.to_owned())
    };
    (text.lines().map(line).collect(), printed)
}

#[test]
fn every_mutant_of_the_toy_comes_out_as_it_must() {
    let (found, printed) = outcomes("all", &[], 1);
    // i *= 1 from 0 on never arrives; a >= b returns the same number; many >= 9 differs at 9 only, which is odd.
    let others = [
        ("replace += with *= in triangle", "TimedOut(\"triangles\")"),
        ("replace > with >= in larger", "Survived(1)"),
        ("replace + with - in joined", "refused"),
        ("replace + with * in joined", "refused"),
        ("replace bits -> u32 with 0", "the compiler evaluates it"),
        ("replace bits -> u32 with 1", "the compiler evaluates it"),
        ("replace * with + in bits", "the compiler evaluates it"),
        ("replace * with / in bits", "the compiler evaluates it"),
        ("replace > with >= in word", "Survived(1)"),
        ("replace row -> Size with Default::default()", "refused"),
        ("replace unreached -> i32 with 0", "Survived(0)"),
        ("replace unreached -> i32 with 1", "Survived(0)"),
        ("replace unreached -> i32 with -1", "Survived(0)"),
        ("delete - in unreached", "Survived(0)"),
        ("replace evens -> impl Iterator<Item = u32> with ::std::iter::empty()", "it returns `impl`"),
        ("replace evens -> impl Iterator<Item = u32> with ::std::iter::once(0)", "it returns `impl`"),
        ("replace evens -> impl Iterator<Item = u32> with ::std::iter::once(1)", "it returns `impl`"),
    ];
    let mut others_found: Vec<_> = found
        .iter()
        .filter(|(_, outcome)| !outcome.starts_with("Failed("))
        .map(|(a, b)| (a.as_str(), b.as_str()))
        .collect();
    let mut others = others.to_vec();
    others.sort_unstable();
    others_found.sort_unstable();
    assert_eq!(others_found, others);
    assert_eq!(found.len(), 47);
    // Wilson's interval of 6 of 37: 7.7 to 31.1 %.
    let line = "toy: 37 tried, 30 noticed, 1 by time, 6 survived (4 not reached, 0 some tests only): 16.2 % (95 %: 7.7 to 31.1 %)";
    assert!(printed.contains(line), "{printed}");
}

#[test]
fn a_shard_has_every_nth_mutant() {
    // Of 47, the numbers 3, 13, 23, 33, 43, counted from 0; none survives.
    let (found, _) = outcomes("shard", &["--shard", "3/10"], 0);
    let names: Vec<_> = found.iter().map(|(name, _)| name.as_str()).collect();
    let listed = [
        "replace < with > in triangle",
        "replace > with < in larger",
        "replace word -> &'static str with \"\"",
        "replace == with != in word",
        "replace evens -> impl Iterator<Item = u32> with ::std::iter::once(0)",
    ];
    for name in listed {
        assert!(names.contains(&name), "{name}: {names:?}");
    }
    assert_eq!(names.len(), 5);
}

/// Without time for a test every mutant counts as one that survives: 37 have a switch, and a test reaches all but 4.
#[test]
fn a_mutant_whose_time_is_over_counts_as_a_survivor() {
    let (found, printed) = outcomes("seconds", &["--seconds", "0"], 1);
    assert!(found.contains(&("replace > with >= in larger".to_owned(), "Unnoticed(0, 1)".to_owned())), "{found:?}");
    assert!(printed.contains("0 noticed, 0 by time, 37 survived (4 not reached, 33 some tests only)"), "{printed}");
    assert!(printed.contains("(0 of 1 tests that reach it)"), "{printed}");
}
