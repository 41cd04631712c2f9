//! Invalid arguments are reported, and nothing is written.

use std::path::Path;
use std::process::{Command, Output};

fn run_with(here: &Path, argument: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_luenberger-reproduce")).args(argument).current_dir(here).output().unwrap()
}

#[test]
fn help_is_help_and_an_unknown_flag_an_error() {
    let here = Path::new(env!("CARGO_TARGET_TMPDIR")).join("arguments");
    _ = std::fs::remove_dir_all(&here);
    std::fs::create_dir_all(&here).unwrap();
    for flag in ["--help", "-h"] {
        let help = run_with(&here, &[flag]);
        let text = String::from_utf8(help.stdout).unwrap();
        assert_eq!((help.status.code(), help.stderr.len()), (Some(0), 0));
        assert!(
            text.contains("Usage: luenberger-reproduce [OPTIONS] [OUT]") && text.contains("target/reproduce"),
            "{text}"
        );
        for choice in ["--class <CLASS>", "theorem", "misprint", "--verdict <VERDICT>", "underspecified"] {
            assert!(text.contains(choice), "{choice}: {text}");
        }
    }
    for wrong in [&["--outt", "here"][..], &["one", "two"], &["-x"]] {
        let refused = run_with(&here, wrong);
        assert_eq!((refused.status.code(), refused.stdout.len()), (Some(2), 0), "{wrong:?}");
        assert!(String::from_utf8(refused.stderr).unwrap().contains("unexpected argument"), "{wrong:?}");
    }
    assert_eq!(std::fs::read_dir(&here).unwrap().count(), 0, "nothing is written");
}
