//! The program that checks a file.

use std::io::Write;
use std::process::{Command, Output, Stdio};

use super::*;

fn run(arguments: &[&str], input: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_luenberger-verify"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    // A program that has refused its arguments does not read.
    let _ = child.stdin.take().expect("piped").write_all(input);
    child.wait_with_output().expect("it ends")
}

fn said(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

#[test]
fn the_program_says_proved_rejected_or_unreadable() {
    let proved = run(&["-"], text().as_bytes());
    assert_eq!(proved.status.code(), Some(0));
    assert!(said(&proved).starts_with("-: Proved\n  For the plant x' = Ax + Bu"), "{}", said(&proved));
    assert!(said(&proved).contains("\n  (A - LC)'P + P(A - LC) < 0 (12), margin >= 13.99999\n"), "{}", said(&proved));
    let forged = run(&["-"], text().replace("0x1.6p3", "0x1.7p3").as_bytes());
    assert_eq!(forged.status.code(), Some(1));
    assert!(said(&forged).starts_with("-: Rejected\n  line 43, sha256: the digest"), "{}", said(&forged));
    for unreadable in [&b"{"[..], b"\xff", b""] {
        assert_eq!(run(&["-"], unreadable).status.code(), Some(2));
    }
    let several = run(&["/nonexistent/certificate.json", "-"], text().as_bytes());
    assert_eq!(several.status.code(), Some(2));
    assert!(
        said(&several).contains("/nonexistent/certificate.json: Unreadable\n")
            && said(&several).contains("-: Proved\n")
    );
}

#[test]
fn the_program_speaks_json() {
    let proved = run(&["--json", "-"], text().as_bytes());
    let line = said(&proved);
    assert!(
        line.starts_with("{\"file\":\"-\",\"outcome\":\"proved\",\"title\":\"a test\",\"statement\":\"For the plant"),
        "{line}"
    );
    assert!(line.contains("\"facts\":[{\"inequality\":\"P > 0\",\"margin\":\"0x1."), "{line}");
    let rejected = run(&["--json", "-"], text().replace("0x1.6p3", "0x1.zp3").as_bytes());
    assert_eq!(
        said(&rejected),
        "{\"file\":\"-\",\"outcome\":\"rejected\",\"why\":\"line 28, lyapunov.P[0][0]: \\\"0x1.zp3\\\" is not a hexadecimal float such as \\\"0x1.8p-3\\\"\"}\n"
    );
    assert_eq!(rejected.status.code(), Some(1));
}

/// The example of `--help` is that of the page, which the tests of the command `luenberger verify` run.
#[test]
fn the_example_of_help_is_that_of_the_page() {
    let page = include_str!("../../../../../docs/commands/verify.md").replace("luenberger verify", "luenberger-verify");
    let help = said(&run(&["--help"], b""));
    let example: Vec<&str> =
        help.lines().skip_while(|line| *line != "Example:").skip(1).take_while(|line| !line.is_empty()).collect();
    assert!(example.len() > 4, "{help}");
    for line in example {
        let line = line.strip_prefix("  ").expect("indented");
        let is_there = match line.strip_suffix(" ...") {
            Some(begin) => page.lines().any(|found| found.starts_with(begin)),
            None => page.lines().any(|found| found == line),
        };
        assert!(is_there, "{line}");
    }
}

#[test]
fn the_program_explains_itself() {
    let help = run(&["--help"], b"");
    assert!(help.status.success() && said(&help).contains("Example:") && said(&help).contains("linear-observer"));
    for arguments in [&[][..], &["--frobnicate", "x"], &["--json"]] {
        let refused = run(arguments, b"");
        assert_eq!(refused.status.code(), Some(2), "{arguments:?}");
        assert!(String::from_utf8_lossy(&refused.stderr).contains("luenberger-verify --help"));
    }
    let digested = run(&["--digest", "-"], text().as_bytes());
    assert!(text().contains(said(&digested).split(' ').next().expect("a digest")));
}
