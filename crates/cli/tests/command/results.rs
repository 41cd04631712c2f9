//! Results folders and standard streams: what a run leaves when the disk is full, when it is killed, and when another
//! one is at work.

use crate::terminal::{folder, luenberger, run};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

pub(crate) const STUDY: &str = "
[plant]
a = [[0, 1], [0, 0]]
c = [[1, 0]]
[[observer]]
kind = \"luenberger\"
poles = [-2, -5]
[simulation]
x0 = [1, 1]
duration = 1
";

/// A sweep of hours.
const SWEEP: &str = "[sweep]\nparameter = \"initial\"\nfrom = 1\nto = 2\ncount = 1000\nensemble = 1000\n";

/// The folder and the file of a study with this text.
pub(crate) fn written(name: &str, text: &str) -> (std::path::PathBuf, String) {
    let folder = folder(name);
    let file = folder.join("study.toml");
    std::fs::write(&file, text).unwrap();
    (folder, file.to_str().unwrap().to_owned())
}

#[test]
fn a_study_is_read_from_standard_input() {
    let folder = folder("standard-input");
    std::fs::write(folder.join("log.csv"), "t,y1\n0,1\n0.5,1.5\n1,2\n").unwrap();
    let text = format!("{STUDY}[log]\nfile = \"log.csv\"\n");
    let mut command = Command::new(env!("CARGO_BIN_EXE_luenberger"));
    let ran = run(command.args(["run", "-"]).current_dir(&folder), text.as_bytes());
    assert_eq!((ran.code, ran.stderr_without_estimate()), (Some(0), String::new()));
    assert!(ran.stdout.starts_with("study: 2 states"), "{}", ran.stdout);
    let manifest: Value =
        serde_json::from_slice(&std::fs::read(folder.join("study-results/manifest.json")).unwrap()).unwrap();
    assert_eq!(manifest["study"]["name"], "standard input");
    let json = r#"{"plant": {"a": [[0, 1], [0, 0]], "c": [[1, 0]]}}"#;
    assert!(luenberger(&["observe", "-"], json).stdout.contains("observable: rank 2 of 2."));
    let ran = luenberger(&["run", "-"], "[plant]\na = [[0]]\n");
    assert_eq!(ran.code, Some(2));
    assert!(ran.stderr.contains("--> standard input:1:1"), "{}", ran.stderr);
}

#[test]
fn limits_refuse_a_study_before_it_runs() {
    let (folder, file) = written("limits", &format!("{STUDY}samples = 100000000\n"));
    let ran = luenberger(&["run", &file, "--json"], "");
    assert_eq!((ran.code, &ran.json()["error"]["kind"]), (Some(2), &Value::from("limit")), "{ran:?}");
    assert!(ran.stderr.contains("of memory (limit 4 GiB), most of it for the trajectories"), "{}", ran.stderr);
    assert!(!folder.join("study-results").exists());
    let (folder, file) = written("limits-time", &format!("{STUDY}{SWEEP}"));
    let ran = luenberger(&["run", &file, "--limit", "time=1s,memory=1GiB"], "");
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert!(ran.stderr.contains("(limit 1 s), most of it for the simulations; a longer limit: --limit time="));
    assert!(!folder.join("study-results").exists());
    let ran = luenberger(&["run", &file, "--limit", "4GiB"], "");
    assert!(ran.code == Some(2) && ran.stderr.contains("expected memory=SIZE or time=TIME"), "{ran:?}");
}

/// Every write to /dev/full fails as on a full disk.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let (_, file) = written("full", STUDY);
    let model = r#"{"a": [[-1]], "q": [[1]]}"#;
    for (arguments, input) in [
        (vec!["lyap", "-"], model),
        (vec!["lyap", "-", "--json"], model),
        (vec!["design", &file], ""),
        (vec!["new", "-o", "-"], ""),
        (vec!["--help"], ""),
        (vec!["--version"], ""),
    ] {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let mut child = Command::new(env!("CARGO_BIN_EXE_luenberger"))
            .args(&arguments)
            .stdin(Stdio::piped())
            .stdout(full)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::io::Write::write_all(&mut child.stdin.take().unwrap(), input.as_bytes()).unwrap();
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {said}");
        assert!(said.contains("error: standard output cannot be written: No space left on device"), "{said}");
    }
    let ran = luenberger(&["new", "--force", "-o", "/dev/full", "--json"], "");
    assert_eq!((ran.code, &ran.json()["error"]["kind"]), (Some(1), &Value::from("storage")), "{ran:?}");
    let ran = luenberger(&["run", &file, "-o", "/dev/full", "--json"], "");
    assert_eq!((ran.code, &ran.json()["error"]["kind"]), (Some(2), &Value::from("file")), "{ran:?}");
    assert!(ran.stderr.contains("/dev/full is not a folder"), "{}", ran.stderr);
}

/// A limit of the size of files stands for a disk that becomes full during a run.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_becomes_full_leaves_the_earlier_results() {
    let (folder, file) = written("becomes-full", STUDY);
    let out = folder.join("results");
    let arguments = ["run", &file, "-o", out.to_str().unwrap()];
    assert_eq!(luenberger(&arguments, "").code, Some(0));
    let before = std::fs::read(out.join("manifest.json")).unwrap();
    // 16 blocks of 512 bytes; the signal that would end the command is ignored.
    let shell = "trap '' XFSZ; ulimit -f 16; exec \"$@\"";
    let mut command = Command::new("sh");
    command.args(["-c", shell, "sh", env!("CARGO_BIN_EXE_luenberger")]).args(arguments);
    let ran = run(&mut command, b"");
    assert_eq!((ran.code, ran.stdout.as_str()), (Some(1), ""), "{ran:?}");
    let stated = format!("error: {}", out.display());
    assert!(ran.stderr.contains(&stated) && ran.stderr.contains("File too large"), "{}", ran.stderr);
    assert_eq!(ran.stderr_without_estimate().lines().count(), 1, "{}", ran.stderr);
    assert!(!out.join(".luenberger.partial").exists());
    assert_eq!(std::fs::read(out.join("manifest.json")).unwrap(), before);
}

/// A schema of another version, or a part of one, is replaced by that of this version, complete or not at all.
#[cfg(target_os = "linux")]
#[test]
fn the_schema_is_whole_and_that_of_this_version() {
    let (folder, _) = written("schema", STUDY);
    let (schema, new) = (folder.join("study.schema.json"), |name: &str| folder.join(name).display().to_string());
    assert_eq!(luenberger(&["new", "-o", &new("a.toml")], "").code, Some(0));
    let whole = std::fs::read(&schema).unwrap();
    let ran = luenberger(&["new", "-o", &new("b.toml")], "");
    assert!(ran.code == Some(0) && !ran.stdout.contains("with it"), "{ran:?}");
    let half = &whole[..whole.len() / 2];
    std::fs::write(&schema, half).unwrap();
    let shell = "trap '' XFSZ; ulimit -f 64; exec \"$@\"";
    let mut command = Command::new("sh");
    command.args(["-c", shell, "sh", env!("CARGO_BIN_EXE_luenberger"), "new", "-o", &new("c.toml")]);
    let ran = run(&mut command, b"");
    assert!(ran.code == Some(1) && ran.stderr.contains("study.schema.json cannot be written"), "{ran:?}");
    assert_eq!(std::fs::read(&schema).unwrap(), half);
    assert!(!folder.join(".study.schema.json.partial").exists());
    let ran = luenberger(&["new", "-o", &new("d.toml")], "");
    assert!(ran.code == Some(0) && ran.stdout.contains("with it"), "{ran:?}");
    assert_eq!(std::fs::read(&schema).unwrap(), whole);
}

/// While one run is at work, a second one into the same folder is refused. After the first is killed, the next one uses
/// the folder.
#[cfg(unix)]
#[test]
fn two_runs_exclude_each_other_and_a_killed_one_does_not() {
    let (folder, file) = written("locked", &format!("{STUDY}{SWEEP}"));
    let out = folder.join("results");
    let out_text = out.to_str().unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_luenberger"))
        .args(["run", &file, "-o", out_text, "--limit", "time=none"])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let began = Instant::now();
    while !out.join(".luenberger.partial/study.json").exists() && began.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(50));
    }
    let short = written("locked-short", STUDY).1;
    let ran = luenberger(&["run", &short, "-o", out_text, "--json"], "");
    assert_eq!((ran.code, &ran.json()["error"]["kind"]), (Some(2), &Value::from("file")), "{ran:?}");
    assert!(ran.stderr.contains("results is in use by another run of luenberger: wait until"), "{}", ran.stderr);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(out.join(".luenberger.partial").exists() && !out.join("manifest.json").exists());
    let ran = luenberger(&["run", &short, "-o", out_text], "");
    assert_eq!((ran.code, ran.stderr_without_estimate()), (Some(0), String::new()));
    assert!(out.join("manifest.json").is_file() && !out.join(".luenberger.partial").exists());
}

#[test]
fn another_folder_is_refused_and_with_force_its_files_are_kept() {
    let (folder, file) = written("foreign", STUDY);
    let out = folder.join("results");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("report.html"), "mine").unwrap();
    let arguments = ["run", &file, "-o", out.to_str().unwrap()];
    let ran = luenberger(&arguments, "");
    assert_eq!(ran.code, Some(2));
    assert!(ran.stderr.contains("results has files and no manifest.json: choose a new or empty folder"), "{ran:?}");
    let ran = luenberger(&[&arguments[..], &["--force"]].concat(), "");
    assert_eq!(ran.code, Some(0));
    let note = format!("note: {} was not written by luenberger", out.join("report.html").display());
    assert!(ran.stderr.contains(&note) && ran.stderr.contains("report.html.old"), "{}", ran.stderr);
    assert_eq!(std::fs::read_to_string(out.join("report.html.old")).unwrap(), "mine");
}

/// A name of 300 characters is a mistake in the study, not a failure of the file system.
#[test]
fn a_long_name_is_located() {
    let text = STUDY.replace("kind =", &format!("name = \"{}\"\nkind =", "n".repeat(300)));
    let (folder, file) = written("long-name", &text);
    let error = luenberger(&["run", &file, "--json"], "").json()["error"].clone();
    assert_eq!((&error["kind"], &error["mistakes"][0]["line"]), (&"study".into(), &6.into()), "{error}");
    assert!(!Path::new(&folder).join("study-results").exists());
}
