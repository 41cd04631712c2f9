//! The commands on study files, from `new` to `verify`.

use crate::terminal::{Ran, folder, luenberger};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The commands of this file get absolute paths, since tests share one working folder.
fn study(name: &str, plant: &str) -> (PathBuf, String) {
    let folder = folder(name);
    let file = folder.join("study.toml").to_str().unwrap().to_owned();
    let ran = luenberger(&["new", "--plant", plant, "-o", &file], "");
    assert_eq!((ran.code, ran.stderr_without_estimate()), (Some(0), String::new()));
    (folder, file)
}

/// Every file below a folder that is not hidden, with its content.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if !path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.')) {
                found.insert(path.strip_prefix(folder).unwrap().to_owned(), std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

#[test]
fn every_plant_is_written_and_read_again() {
    let listed = luenberger(&["new", "--list", "--json"], "").json();
    let plants = listed["plants"].as_array().unwrap();
    assert!(plants.len() >= 6);
    let observers = listed["observers"].as_array().unwrap();
    for kind in ["cubic", "mean-value", "kkl", "pebo", "kkl-peb", "immersion-invariance", "high-gain"] {
        let found = observers.iter().find(|observer| observer["kind"] == kind).unwrap();
        assert!(found["source"].as_str().unwrap().contains(['0', '1', '5']), "{found}");
    }
    let text = luenberger(&["new", "--list"], "").stdout;
    assert!(
        text.contains("kkl-peb") && text.contains("[Yi, Ortega and Zhang 2018, eq. (15), Propositions 3, 6 and 7]")
    );
    for plant in plants {
        let name = plant["name"].as_str().unwrap();
        let (folder, file) = study(&format!("new-{name}"), name);
        let schema = std::fs::read_to_string(folder.join("study.schema.json")).unwrap();
        let schema: Value = serde_json::from_str(&schema).unwrap();
        let described = schema["properties"]["observer"]["items"]["oneOf"].as_array().unwrap();
        let kinds = described.iter().map(|variant| &variant["properties"]["kind"]["const"]);
        assert!(kinds.eq(observers.iter().map(|observer| &observer["kind"])), "{name}");
        let printed = luenberger(&["new", "--plant", name, "-o", "-"], "").stdout;
        // Its comment names the file that it is in.
        let own = Path::new(&file).file_name().unwrap().to_str().unwrap();
        let [of_plant, of_file] = [&format!("{name}.toml"), own].map(|file| format!("#   luenberger run {file}\n"));
        assert!(printed.contains(&of_plant), "{printed}");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), printed.replace(&of_plant, &of_file));
    }
}

#[test]
fn nothing_is_written_over_unasked() {
    let (_, file) = study("new-again", "double-integrator");
    std::fs::write(&file, "mine").unwrap();
    let ran = luenberger(&["new", "-o", &file], "");
    assert_eq!(ran.code, Some(2));
    assert_eq!(ran.stderr, format!("error: {file} exists: choose another name, or overwrite it with --force\n"));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "mine");
    assert_eq!(luenberger(&["new", "--force", "-o", &file], "").code, Some(0));
    let ran = luenberger(&["new", "--plant", "cukk", "-o", &file, "--json"], "");
    assert_eq!((ran.code, &ran.json()["error"]["kind"]), (Some(2), &Value::from("usage")));
    assert!(ran.stderr.contains("there is no template \"cukk\"") && ran.stderr.contains("\"cuk\""), "{}", ran.stderr);
}

#[test]
fn a_run_is_the_same_twice_and_its_certificates_hold() {
    let (folder, file) = study("run", "double-integrator");
    let run = |name: &str, threads| {
        let out = folder.join(name);
        let ran = luenberger(&["run", &file, "-o", out.to_str().unwrap(), "--threads", threads, "--json"], "");
        assert_eq!((ran.code, ran.stderr_without_estimate()), (Some(0), String::new()));
        (files(&out), ran.json())
    };
    let (first, printed) = run("first", "1");
    let (second, again) = run("second", "2");
    assert!(first == second && printed == again, "{:?}", first.keys().collect::<Vec<_>>());
    for name in ["report.html", "study.json", "trajectories/cubic.csv", "trajectories/cubic.npz"] {
        assert!(first.contains_key(Path::new(name)), "{name}");
    }
    let written: Value = serde_json::from_slice(&first[Path::new("study.json")]).unwrap();
    assert_eq!(written, printed);
    let certificates: Vec<String> = first
        .keys()
        .filter(|name| name.starts_with("certificates"))
        .map(|name| folder.join("first").join(name).to_str().unwrap().to_owned())
        .collect();
    assert!(!certificates.is_empty());
    let mut arguments = vec!["verify", "--json"];
    arguments.extend(certificates.iter().map(String::as_str));
    let ran = luenberger(&arguments, "");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let outcomes = ran.json();
    assert!(outcomes["files"].as_array().unwrap().iter().all(|file| file["outcome"] == "proved"));
    // With one digit of a certificate changed, it is rejected and the answer is negative.
    let text = std::fs::read_to_string(&certificates[0]).unwrap().replacen("\"title\": \"", "\"title\": \"not ", 1);
    let forged = folder.join("forged.json");
    std::fs::write(&forged, text).unwrap();
    let ran = luenberger(&["verify", &certificates[0], forged.to_str().unwrap()], "");
    assert_eq!(ran.code, Some(1));
    assert!(ran.stdout.contains("forged.json: Rejected\n"), "{}", ran.stdout);
}

#[test]
fn what_is_no_certificate_is_no_question() {
    let ran = luenberger(&["verify", "-", "--json"], "nonsense");
    assert_eq!((ran.code, &ran.json()["error"]["kind"]), (Some(2), &Value::from("syntax")));
    assert_eq!(luenberger(&["verify"], "").code, Some(2));
}

#[test]
fn each_step_prints_its_part() {
    let (folder, file) = study("steps", "double-integrator");
    let output_of = |step: &str| {
        let ran = luenberger(&[step, &file], "");
        assert_eq!((ran.code, ran.stderr_without_estimate()), (Some(0), String::new()), "{step}");
        ran.stdout
    };
    assert!(output_of("observe").contains("The plant is observable: rank 2 of 2."));
    let design = output_of("design");
    assert!(design.contains("linear (luenberger): proved") && design.contains("L = [7; 10]"), "{design}");
    let compared = output_of("compare");
    assert!(compared.contains("observer") && compared.contains("settling time (s)") && compared.contains("cubic"));
    let markdown = luenberger(&["compare", &file, "--markdown"], "").stdout;
    assert!(
        markdown.starts_with("# Double integrator\n\n") && markdown.contains("\n| linear | luenberger | proved |\n")
    );
    assert!(!folder.join("study-results").exists());
}

/// With the velocity measured, the position is unobservable and not stable: no observer exists, and the answer is
/// negative.
#[test]
fn an_observer_that_does_not_fit_is_a_no_with_its_reason() {
    let (_, file) = study("blind", "double-integrator");
    let text = std::fs::read_to_string(&file).unwrap().replace("c = [[1, 0]]", "c = [[0, 1]]");
    std::fs::write(&file, text).unwrap();
    let ran = luenberger(&["design", &file], "");
    assert_eq!((ran.code, ran.stderr_without_estimate()), (Some(1), String::new()));
    assert!(ran.stdout.contains("linear (luenberger): not applicable\n  Line "), "{}", ran.stdout);
    let found = luenberger(&["design", &file, "--json"], "").json();
    assert!(found["observers"][0]["failure"]["hypothesis"].is_string());
    assert_eq!(luenberger(&["observe", &file], "").code, Some(0));
}

#[test]
fn mistakes_in_a_study_are_located() {
    let (_, file) = study("wrong", "double-integrator");
    let text = std::fs::read_to_string(&file).unwrap().replacen("poles =", "pols =", 1);
    std::fs::write(&file, &text).unwrap();
    let line = text.lines().position(|line| line.starts_with("pols")).unwrap() + 1;
    let ran = luenberger(&["run", &file], "");
    assert_eq!((ran.code, ran.stdout.as_str()), (Some(2), ""));
    assert!(ran.stderr.contains(&format!("study.toml:{line}:1")), "{}", ran.stderr);
    assert!(ran.stderr.contains("the nearest key is `poles`") && !ran.stderr.contains('\x1b'), "{}", ran.stderr);
    let error = luenberger(&["run", &file, "--json"], "").json()["error"].clone();
    assert_eq!(error["kind"], "study");
    let mistakes = error["mistakes"].as_array().unwrap();
    let pols = mistakes.iter().find(|mistake| mistake["line"] == line).unwrap();
    assert_eq!((&pols["column"], &pols["help"]), (&Value::from(1), &Value::from("the nearest key is `poles`")));
}

#[test]
fn a_step_without_its_table_says_so() {
    let (_, file) = study("no-sweep", "double-integrator");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, &text[..text.find("[sweep]").unwrap()]).unwrap();
    let ran = luenberger(&["sweep", &file, "--json"], "");
    assert_eq!((ran.code, &ran.json()["error"]["kind"]), (Some(2), &Value::from("usage")), "{ran:?}");
    let ran = luenberger(&["run", "no-such-study.toml", "--json"], "");
    assert_eq!((ran.code, &ran.json()["error"]["kind"]), (Some(2), &Value::from("file")));
    let ran = luenberger(&["run", &file, "--threads", "0"], "");
    assert!(ran.code == Some(2) && ran.stderr.contains("a number from 1 to 1024 is expected"), "{ran:?}");
}

#[test]
fn an_imported_model_is_a_study() {
    let folder = folder("import");
    let model = folder.join("model.json");
    std::fs::write(&model, r#"{"A": [[0, 1], [-2, -3]], "B": [[0], [1]], "C": [[1, 0]], "hsv": [1]}"#).unwrap();
    let (model, file) = (model.to_str().unwrap(), folder.join("study.toml"));
    let file = file.to_str().unwrap();
    let imported = luenberger(&["import", model, "-o", file, "--json"], "").json();
    assert_eq!(
        imported,
        serde_json::json!({ "study": file, "states": 2, "inputs": 1, "outputs": 1, "ignored": ["hsv"] })
    );
    let ran = luenberger(&["compare", file], "");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let ran = luenberger(&["import", model, "-o", file], "");
    assert!(ran.code == Some(2) && ran.stderr.contains("exists: choose another name"), "{ran:?}");
    std::fs::write(model, "{\"A\": [[1, 2],\n [3]]}").unwrap();
    let ran = luenberger(&["import", model, "-o", "-", "--json"], "");
    let error = &ran.json()["error"];
    assert_eq!((&error["kind"], &error["line"], &error["column"]), (&"syntax".into(), &2.into(), &5.into()));
    std::fs::write(model, "{\"A\": [[1]], \"C\": [[1]], \"D\": [[2]]}").unwrap();
    let ran = luenberger(&["import", model, "-o", "-", "--json"], "");
    assert_eq!((ran.code, &ran.json()["error"]["kind"]), (Some(2), &Value::from("data")));
}

/// Runs the study, sends an interrupt like Ctrl-C as soon as `file` is in the output folder, and waits for the end.
#[cfg(unix)]
fn interrupted(study: &str, out: &Path, file: &str) -> Ran {
    let child = Command::new(env!("CARGO_BIN_EXE_luenberger"))
        .args(["run", study, "-o", out.to_str().unwrap(), "--threads", "1", "--json", "--limit", "time=none"])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let began = Instant::now();
    // The files of an unfinished run.
    let partial = out.join(".luenberger.partial");
    while !partial.join(file).exists() && began.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let ran = Ran {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    };
    assert_eq!((ran.code, &ran.json()["error"]["kind"]), (Some(130), &Value::from("interrupted")), "{ran:?}");
    assert!(!partial.exists() && out.join("manifest.json").is_file());
    ran
}

#[cfg(unix)]
fn written(out: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(out.join("study.json")).unwrap()).unwrap()
}

/// Ctrl-C during a sweep that would take hours: exit code 130 soon after, and the files written before are complete.
#[cfg(unix)]
#[test]
fn an_interrupted_sweep_leaves_what_is_finished() {
    let (folder, file) = study("interrupt", "double-integrator");
    let text = std::fs::read_to_string(&file).unwrap().replace("count = 5", "count = 2000\nensemble = 1000");
    std::fs::write(&file, text).unwrap();
    let out = folder.join("results");
    // The simulations come before the sweep.
    let ran = interrupted(&file, &out, "trajectories/sampled.npz");
    // The estimate was printed first: 3 runs, and 2000 x 1000 of each observer in the sweep.
    assert!(
        ran.stderr.starts_with("estimate: ")
            && ran.stderr.contains("000003 runs; most of the time for the simulations)\n"),
        "{}",
        ran.stderr
    );
    assert!(written(&out)["observers"].is_array());
}

/// Ctrl-C while a table of T is computed that would take an hour: a later, fast observer of the file is on disk with
/// its certificate.
#[cfg(unix)]
#[test]
fn an_interrupted_design_leaves_the_designs_that_are_finished() {
    const STUDY: &str = "
[plant]
a = [[0, 1], [-1, 0]]
c = [[1, 0]]
[[observer]]
name = \"slow\"
kind = \"kkl-numerical\"
domain = [[-1, 1], [-1, 1]]
cutoff = 2
points = 1000
[[observer]]
name = \"quick\"
kind = \"luenberger\"
poles = [-1, -2]
[simulation]
x0 = [1, 0]
duration = 1
";
    let folder = folder("interrupt-design");
    let file = folder.join("study.toml");
    std::fs::write(&file, STUDY).unwrap();
    let out = folder.join("results");
    let ran = interrupted(file.to_str().unwrap(), &out, "certificates/quick.json");
    assert!(ran.stderr.contains("most of the time for the designs"), "{}", ran.stderr);
    let written = written(&out);
    let observers = written["observers"].as_array().unwrap();
    assert_eq!(observers.len(), 1, "{observers:?}");
    assert_eq!((&observers[0]["name"], &observers[0]["design"]["verdict"]), (&"quick".into(), &"proved".into()));
    assert_eq!(written["files"], serde_json::json!(["certificates/quick.json"]));
    assert!(written["simulation"].is_null());
}

/// Digits beyond the largest entry's are rounding error for large numbers, and negligible for small ones.
#[test]
fn entries_at_the_level_of_rounding_are_zero() {
    let study = "[plant]\na = [[-1, 0], [0, -1]]\nc = [[1, 0]]\n\
                 [[observer]]\nname = \"large\"\nkind = \"luenberger\"\ngain = [[1e12], [1e-4]]\n\
                 [[observer]]\nname = \"small\"\nkind = \"luenberger\"\ngain = [[1e-12], [-1e-17]]\n";
    let text = luenberger(&["design", "-", "-o", folder("design-rounding").to_str().unwrap()], study).stdout;
    let gains: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("  L = ")).collect();
    assert_eq!(gains, ["[1e12; ≈0]", "[1e-12; -1e-17]"], "{text}");
}

/// A folder stands for its `study.toml`, or for the only file in TOML.
#[test]
fn a_folder_stands_for_its_study() {
    let (folder, file) = study("folder", "double-integrator");
    let at = folder.to_str().unwrap();
    let designs = |study: &str| luenberger(&["design", study, "--json"], "");
    let expected = designs(&file);
    assert_eq!((designs(at).code, designs(at).stdout), (expected.code, expected.stdout));
    std::fs::copy(&file, folder.join("other.toml")).unwrap();
    std::fs::rename(&file, folder.join("third.toml")).unwrap();
    let ran = designs(at);
    assert_eq!((ran.code, &ran.json()["error"]["kind"]), (Some(2), &Value::from("file")));
    assert!(ran.stderr.ends_with("is a folder with 2 files in TOML and no study.toml: name the study\n"), "{ran:?}");
}

/// `-q` leaves nothing on standard error, `-v` has a line for each part; the results are the same.
#[test]
fn quiet_and_verbose_differ_on_standard_error_only() {
    let (_, file) = study("volume", "double-integrator");
    let [quiet, normal, verbose] = [Some("-q"), None, Some("-v")].map(|volume| {
        let arguments: Vec<&str> = ["design", &file].into_iter().chain(volume).collect();
        luenberger(&arguments, "")
    });
    assert_eq!((&quiet.stdout, &verbose.stdout), (&normal.stdout, &normal.stdout));
    assert_eq!(quiet.stderr, "");
    for said in ["estimate: ", "\ndesign linear: ", "\ndesign sampled: "] {
        assert!(verbose.stderr.contains(said) && !normal.stderr.contains(said), "{said} in {}", verbose.stderr);
    }
    assert_eq!(luenberger(&["design", &file, "-q", "-v"], "").code, Some(2));
}

/// A study that is watched runs again when it is saved, and Ctrl-C ends it.
#[cfg(unix)]
#[test]
fn a_watched_study_runs_again_when_it_is_saved() {
    let (folder, file) = study("watch", "double-integrator");
    let mut child = Command::new(env!("CARGO_BIN_EXE_luenberger"))
        .args(["run", &file, "--watch", "-o", folder.join("results").to_str().unwrap()])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let id = child.id().to_string();
    let signal = |name: &str| Command::new("kill").args([name, &id]).status().unwrap().success();
    let (lines, read) = std::sync::mpsc::channel();
    let stdout = child.stdout.take().unwrap();
    std::thread::spawn(move || {
        BufReader::new(stdout).lines().map_while(Result::ok).for_each(|line| _ = lines.send(line));
    });
    // A line that does not come ends the test, and not only the wait.
    let until = |beginning: &str| loop {
        match read.recv_timeout(Duration::from_secs(60)) {
            Ok(line) if line.starts_with(beginning) => break,
            Ok(_) => {}
            Err(error) => {
                signal("-KILL");
                panic!("no line {beginning}: {error}");
            }
        }
    };
    until("Double integrator: ");
    until("report: ");
    let text = std::fs::read_to_string(&file).unwrap().replace("\"Double integrator\"", "\"Saved again\"");
    std::fs::write(&file, text).unwrap();
    until("Saved again: ");
    until("report: ");
    assert!(signal("-INT"));
    assert_eq!(child.wait().unwrap().code(), Some(130));
}
