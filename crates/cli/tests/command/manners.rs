//! Help, colours, closed pipes.

use crate::terminal::{luenberger, run};
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

const COMMANDS: &[&str] = &[
    "new",
    "run",
    "observe",
    "design",
    "certify",
    "simulate",
    "compare",
    "advise",
    "tune",
    "sweep",
    "export",
    "stream",
    "lyap",
    "dlyap",
    "sylv",
    "care",
    "dare",
    "place",
    "obsv",
    "eig",
    "bode",
    "c2d",
    "d2c",
    "noise",
    "poles",
    "import",
    "verify",
    "studio",
    "sdp",
    "completions",
    "man",
];

#[test]
fn each_command_has_help_with_an_example() {
    let all = luenberger(&["--help"], "");
    assert_eq!((all.code, all.stderr.as_str()), (Some(0), ""));
    for command in COMMANDS {
        assert!(all.stdout.contains(&format!("\n  {command} ")), "{command} in\n{}", all.stdout);
        for flag in ["--help", "-h"] {
            let help = luenberger(&[command, flag], "");
            assert_eq!((help.code, help.stderr.as_str()), (Some(0), ""));
            assert!(help.stdout.contains("Example") && help.stdout.contains(&format!("luenberger {command} ")));
            assert!(help.stdout.contains("--json"));
        }
    }
    let listed = all.stdout.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let listed: Vec<&str> = listed.filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(listed.len(), COMMANDS.len() + 1, "{listed:?}");
    assert_eq!(luenberger(&["--version"], "").stdout, format!("luenberger {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn there_is_no_colour_off_the_terminal() {
    let mut help = Command::new(env!("CARGO_BIN_EXE_luenberger"));
    let texts = [
        run(help.arg("--help").env("TERM", "xterm-256color"), b""),
        luenberger(&["lyap"], ""),
        luenberger(&["eig", "-"], "nonsense"),
        luenberger(&["eig", "-"], "{\"a\": [[1]]}"),
    ];
    for ran in texts {
        assert!(!ran.stdout.contains('\x1b') && !ran.stderr.contains('\x1b'), "{ran:?}");
    }
}

/// A closed pipe, as with `head -1`, does not cause a panic.
#[test]
fn a_closed_pipe_is_no_panic() {
    // More than a pipe buffers, so that writing fails on the closed end.
    let rows: Vec<String> = (0..120).map(|i| format!("[{}]", vec![(i % 7).to_string(); 120].join(","))).collect();
    let input = format!("{{\"a\": [{}], \"c\": [[{}]]}}", rows.join(","), vec!["1"; 120].join(","));
    let mut child = Command::new(env!("CARGO_BIN_EXE_luenberger"))
        .args(["obsv", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = String::new();
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), input.as_bytes()).unwrap();
    BufReader::with_capacity(16, child.stdout.take().unwrap()).read_line(&mut first).unwrap();
    let left = child.wait_with_output().unwrap();
    assert!(first.starts_with("rank "), "{first}");
    assert_eq!(String::from_utf8(left.stderr).unwrap(), "");
    assert_eq!(left.status.code(), Some(0));
}
