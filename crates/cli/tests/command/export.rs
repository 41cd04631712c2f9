//! `luenberger export`: the files, compiled where a C compiler is there, and what cannot be exported.

use crate::terminal::{every_case, folder, luenberger, run};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

fn study(name: &str, text: Option<&str>) -> (PathBuf, String) {
    let folder = folder(name);
    let file = folder.join("study.toml").to_str().unwrap().to_owned();
    match text {
        Some(text) => std::fs::write(&file, text).unwrap(),
        None => assert_eq!(luenberger(&["new", "-o", &file], "").code, Some(0)),
    }
    (folder, file)
}

/// Compiles and runs the golden test of an export.
#[track_caller]
fn golden(folder: &Path, name: &str) {
    let sources = [format!("{name}.c"), format!("test_{name}.c")];
    let mut compiler = Command::new("cc");
    compiler.current_dir(folder).args(["-std=c99", "-O1", "-Wall", "-Wextra", "-Wconversion", "-Werror"]);
    match compiler.args(&sources).args(["-lm", "-o", "golden"]).output() {
        Err(_) => eprintln!("SKIPPED: no C compiler"),
        Ok(built) => {
            assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
            let ran = Command::new(folder.join("golden")).output().unwrap();
            assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stdout));
        }
    }
}

#[test]
fn every_observer_of_the_template_becomes_c_that_agrees_with_its_design() {
    let (folder, file) = study("export-template", None);
    for (observer, options) in [
        ("linear", &["--period", "0.05"][..]),
        ("cubic", &["--format", "f32"]),
        ("sampled", &[]),
        ("sampled", &["--format", "f32"]),
    ] {
        let out = folder.join(observer);
        let mut arguments = vec!["export", &file, "--observer", observer, "--to", "c", "-o", out.to_str().unwrap()];
        arguments.extend(options);
        let ran = luenberger(&arguments, "");
        assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{observer}");
        assert!(
            ran.stdout.contains("Proved (certificate.json)") && ran.stdout.contains("the error in the end is at most")
        );
        golden(&out, observer);
        let verified = luenberger(&["verify", out.join("certificate.json").to_str().unwrap()], "");
        assert_eq!(verified.code, Some(0), "{}", verified.stdout);
        let header = std::fs::read_to_string(out.join(format!("{observer}.h"))).unwrap();
        assert!(header.contains("States:  position (m), velocity (m/s)") && header.contains("SHA-256 of the study"));
        let certificate = std::fs::read(out.join("certificate.json")).unwrap();
        assert!(header.contains(&format!("SHA-256 of certificate.json: {}", luenberger_export::sha256(&certificate))));
    }
    // The same command again replaces its files; those of others stay.
    let out = folder.join("sampled");
    std::fs::write(out.join("notes.txt"), "mine").unwrap();
    let arguments = ["export", &file, "--observer", "sampled", "--to", "rust", "-o", out.to_str().unwrap(), "--json"];
    let written = luenberger(&arguments, "").json();
    assert_eq!(written["proved"], true);
    assert!(out.join("src/lib.rs").is_file() && !out.join("sampled.c").exists() && out.join("notes.txt").is_file());
}

#[test]
fn a_linear_observer_becomes_integers_that_agree_with_their_certificate() {
    let (folder, file) = study("export-fixed", None);
    let export = |out: &str, more: &[&str]| {
        let out = folder.join(out);
        let mut arguments = vec!["export", &file, "--observer", "linear", "--to", "c", "--period", "0.05", "-o"];
        arguments.push(out.to_str().unwrap());
        arguments.extend(more);
        (luenberger(&arguments, ""), out)
    };
    for (format, more) in [("q16.16", &[][..]), ("q8.16", &["--gains", "q4.28"])] {
        let (ran, out) = export(format, &[&["--format", format], more].concat());
        assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{format}");
        let name = format.to_uppercase();
        assert!(ran.stdout.contains(&format!("bytes of constants and state ({name})")), "{}", ran.stdout);
        assert!(ran.stdout.contains(&format!("leaves the range of {name}: nothing saturates.")), "{}", ran.stdout);
        golden(&out, "linear");
        let verified = luenberger(&["verify", out.join("certificate.json").to_str().unwrap()], "");
        assert_eq!(verified.code, Some(0), "{}", verified.stdout);
        assert!(verified.stdout.contains("each sum of products computed without rounding"), "{}", verified.stdout);
        let header = std::fs::read_to_string(out.join("linear.h")).unwrap().replace("\n * ", " ");
        for said in ["an error of at most 2^-17", "the error in the end is at most position"] {
            assert!(header.contains(said), "{said}: {header}");
        }
    }
    // A range that the position leaves: named, and counted where it runs.
    let (ran, out) = export("narrow", &["--format", "q4.20"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stdout.contains("saturation is not excluded (y may be as large as"), "{}", ran.stdout);
    golden(&out, "linear");
    for (options, code, says) in [
        (&["--format", "q12.2"][..], 1, "rounded to Q12.2, A - L C has the spectral radius"),
        (&["--format", "q0.16"], 2, "Q0.16: a format has 2 to 32 bits"),
        (&["--format", "q17.16"], 2, "Q17.16: a format has 2 to 32 bits"),
        (&["--format", "q1"], 2, "a fixed-point format such as q16.16 is expected"),
        (&["--format", "half"], 2, "f32, f64 or a fixed-point format such as q16.16 is expected"),
        (&["--format", "f32", "--gains", "q4.28"], 2, "--gains is for fixed point"),
        (&["--format", "q16.16", "--gains", "q1.31"], 2, "is beyond the range of Q1.31"),
        (&["--format", "q16.16", "--to", "rust"], 2, "FixedPointObserver of luenberger-observers"),
        (&["--format", "q16.16", "--to", "fmu"], 2, "--to fmu --format f32 has the same observer in f32"),
        (&["--format", "q16.16", "--feedback"], 2, "export the observer alone, and form u = r - K xhat"),
        (&["--format", "q16.16", "--observer", "sampled"], 2, "not for the sampled cubic observer"),
        (&["--format", "q16.16", "--libm", "target"], 2, "fixed point calls no function"),
        (&["--libm", "target", "--to", "rust"], 2, "--libm target is for --to c"),
        (&["--libm", "target", "--to", "fmu"], 2, "--libm target is for --to c"),
        (&["--libm", "mine"], 2, "possible values: own, target"),
    ] {
        let out = folder.join("refused");
        let mut arguments = vec!["export", &file, "-o", out.to_str().unwrap()];
        if !options.contains(&"--to") {
            arguments.extend(["--to", "c"]);
        }
        if !options.contains(&"--observer") {
            arguments.extend(["--observer", "linear", "--period", "0.05"]);
        }
        arguments.extend(options);
        let ran = luenberger(&arguments, "");
        assert_eq!(ran.code, Some(code), "{options:?}: {}{}", ran.stdout, ran.stderr);
        assert!(ran.stderr.contains(says), "{options:?}: {}", ran.stderr);
        assert!(!out.exists(), "{options:?}");
    }
}

/// A Kalman filter with two outputs, one input in the output, and names that are no identifiers.
#[test]
fn a_kalman_filter_with_feedthrough_becomes_c() {
    let text = r#"
[plant]
a = [[0, 1], [-2, -3]]
b = [[0], [1]]
c = [[1, 0], [-2, -3]]
d = [[0], [1]]
states = ["lage */", "für"]
[[observer]]
name = "for"
kind = "kalman"
w = [0.1, 1]
v = [0.01, 0.1]
"#;
    let (folder, file) = study("export-kalman", Some(text));
    let out = folder.join("c");
    let ran = luenberger(&["export", &file, "--to", "c", "--period", "0.1", "-o", out.to_str().unwrap()], "");
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""));
    assert!(ran.stdout.contains("Rounding to binary64 on the target is not covered."), "{}", ran.stdout);
    golden(&out, "observer_for");
}

/// The archive, and what the command says with and without a C compiler. The wrapper itself is tested in `export`.
#[test]
fn the_targets_are_named_where_none_is_chosen() {
    let overview = luenberger(&["--help"], "").stdout;
    let line = overview.lines().find(|line| line.trim_start().starts_with("export ")).unwrap();
    assert!(line.contains("C99 or Rust source or as an FMU"), "{line}");
    let ran = luenberger(&["export", "study.toml"], "");
    assert!(ran.code == Some(2) && ran.stderr.contains("--to <c|rust|fmu>"), "{}", ran.stderr);
}

#[test]
fn an_observer_becomes_an_fmu_of_either_version() {
    let (folder, file) = study("export-fmu", None);
    for (options, version) in [(&[][..], "2.0"), (&["--fmi", "3"], "3.0")] {
        let out = folder.join(version);
        let mut arguments =
            vec!["export", &file, "--observer", "sampled", "--to", "fmu", "-o", out.to_str().unwrap(), "--json"];
        arguments.extend(options);
        let ran = luenberger(&arguments, "");
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let written = ran.json();
        let files = ["sampled.fmu", "sampled_golden.csv", "test_sampled.py", "README.md", "certificate.json"];
        assert_eq!(written["files"], serde_json::json!(files));
        if Command::new("cc").arg("--version").output().is_ok() {
            assert_eq!(ran.stderr, "");
            assert!(!written["binaries"].as_array().unwrap().is_empty());
        } else {
            eprintln!("SKIPPED: no C compiler");
        }
        let readme = std::fs::read_to_string(out.join("README.md")).unwrap();
        assert!(readme.contains(&format!("Co-simulation by FMI {version}, one step every 0.02 s")), "{readme}");

        // Sources only.
        let mut without = Command::new(env!("CARGO_BIN_EXE_luenberger"));
        let ran = run(without.args(&arguments).env("PATH", "").env_remove("CC"), b"");
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert!(ran.stderr.contains("no C compiler"), "{}", ran.stderr);
        assert_eq!(ran.json()["binaries"], serde_json::json!([]));
    }
    let ran = luenberger(&["export", &file, "--observer", "sampled", "--to", "c", "--fmi", "3"], "");
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(2), "error: --fmi is for --to fmu\n"));
}

const LOOP: &str = r#"
[plant]
a = [[0, 1], [0, 0]]
b = [[0], [1]]
c = [[1, 0]]
states = ["position", "velocity"]
units = ["m", "m/s"]
time_unit = "s"

[input]
expressions = ["0.5"]
feedback = { k = [[4, 4]], observer = "linear" }

[simulation]
x0 = [1, 0]
duration = 5
samples = 101
hold = 0.05

[[observer]]
name = "linear"
kind = "luenberger"
poles = [-6, -7]

[[observer]]
name = "cubic"
kind = "sampled-cubic"
poles = [-6, -7]
period = 0.05
gamma = 1
"#;

/// The observer with u = r - K xhat in one step, in each language, with a certificate of the loop.
#[test]
fn an_observer_with_its_feedback_is_one_block() {
    for (observer, format, claim) in [
        ("linear", "f32", "x and xhat tend to 0 exponentially, from every x(0) and xhat(0)."),
        ("cubic", "f32", "tend to 0 exponentially, if they start near 0."),
        ("cubic", "f64", "x and xhat tend to 0 exponentially, from every x(0) and xhat(0)."),
    ] {
        let text = LOOP.replace("observer = \"linear\"", &format!("observer = \"{observer}\""));
        let (folder, file) = study(&format!("export-feedback-{observer}-{format}"), Some(&text));
        let export = |to: &str| {
            let out = folder.join(to);
            let arguments = ["export", &file, "--observer", observer, "--feedback", "--to", to, "--format", format];
            let ran = luenberger(&[&arguments[..], &["-o", out.to_str().unwrap()]].concat(), "");
            assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{observer} {to}");
            assert!(
                ran.stdout.contains(claim) && ran.stdout.contains("the error in the end is at most"),
                "{}",
                ran.stdout
            );
            out
        };
        let c = export("c");
        golden(&c, observer);
        let files = ["certificate.json", "certificate-feedback.json"].map(|name| c.join(name));
        let verified = luenberger(&["verify", files[0].to_str().unwrap(), files[1].to_str().unwrap()], "");
        assert_eq!(verified.code, Some(0), "{}", verified.stdout);
        let library = std::fs::read_to_string(export("rust").join("src/lib.rs")).unwrap();
        assert!(library.contains("pub type Observer = OutputFeedback<"), "{library}");
        if Command::new("cc").arg("--version").output().is_ok() {
            let table = std::fs::read_to_string(export("fmu").join(format!("{observer}_golden.csv"))).unwrap();
            assert!(table.starts_with("\"r.u1\",\"y.y1\",\"xhat.position\""), "{table}");
        }
    }
    let (_, file) = study("export-feedback-refused", Some(LOOP));
    let refused = |file: &str, observer: &str, says: &str| {
        let out = format!("{file}-out");
        let ran = luenberger(&["export", file, "--observer", observer, "--feedback", "--to", "c", "-o", &out], "");
        assert_eq!(ran.code, Some(1), "{}{}", ran.stdout, ran.stderr);
        assert!(ran.stderr.contains(says), "{}", ran.stderr);
    };
    refused(&file, "cubic", "the study feeds back the estimate of linear\n  hint: feedback = {");
    let (_, unstable) = study("export-feedback-unstable", Some(&LOOP.replace("[[4, 4]]", "[[-1, 0]]")));
    refused(&unstable, "linear", "its feedback has no stability certificate");
    let out = format!("{unstable}-out");
    let arguments =
        ["export", &unstable, "--observer", "linear", "--feedback", "--unproved", "--to", "c", "--json", "-o"];
    let ran = luenberger(&[&arguments[..], &[&out]].concat(), "");
    assert_eq!(ran.json()["proved"], false);
    assert!(ran.stdout.contains("Feedback: no stability certificate of the loop."), "{}", ran.stdout);
    let (_, open) = study("export-no-feedback", None);
    refused(&open, "sampled", "the study has no feedback");
}

/// A moving-horizon estimator with a bound, of a linear and of a nonlinear plant, in each language.
#[test]
fn a_moving_horizon_estimator_is_exported() {
    let observer = "[[observer]]\nname = \"window\"\nkind = \"mhe\"\nw = [0, 0.1]\nv = 0.01\nperiod = 0.05\nwindow = 4\nstate_bounds = [[-inf, inf], [-0.5, 1]]\ninitial = [0.5, 0]\n";
    let start = "[simulation]\nx0 = [1, 0]\nduration = 5\nsamples = 101\nhold = 0.05\nnoise = { amplitude = [0.1], period = 0.05, seed = 2 }\n";
    let input = "[input]\nexpressions = [\"sin(t)\"]\n";
    let linear = "[plant]\na = [[0, 1], [-1, -0.5]]\nb = [[0], [1]]\nc = [[1, 0]]\nstates = [\"x\", \"v\"]\n";
    let nonlinear = "[plant]\nf = [\"v\", \"-sin(x) - 0.5*v + u + 0.1*cos(t)\"]\nh = [\"x\"]\nstates = [\"x\", \"v\"]\ninputs = [\"u\"]\n";
    for (name, plant) in [("linear", linear), ("nonlinear", nonlinear)] {
        let (folder, file) = study(&format!("export-mhe-{name}"), Some(&format!("{plant}{input}{start}{observer}")));
        let export = |to: &str, more: &[&str]| {
            let out = folder.join(to);
            let arguments = [&["export", &file, "--to", to, "-o", out.to_str().unwrap()], more].concat();
            (luenberger(&arguments, ""), out)
        };
        let (ran, _) = export("c", &[]);
        assert_eq!(ran.code, Some(1), "{}{}", ran.stdout, ran.stderr);
        assert!(ran.stderr.contains("--unproved"), "{}", ran.stderr);
        let (ran, c) = export("c", &["--unproved"]);
        assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{name}");
        assert!(
            ran.stdout.contains(": at most ") && ran.stdout.contains(" without active bounds), "),
            "{}",
            ran.stdout
        );
        assert!(ran.stdout.contains("No stability certificate: there is no theorem"), "{}", ran.stdout);
        golden(&c, "window");
        let (ran, _) = export("c", &["--unproved", "--force", "--json"]);
        let written = ran.json();
        assert!(written["operations"].as_u64() > written["operations_within_bounds"].as_u64(), "{written}");
        let (ran, rust) = export("rust", &["--unproved", "--format", "f32"]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let library = std::fs::read_to_string(rust.join("src/lib.rs")).unwrap();
        let kind = "MovingHorizonEstimator<Model, f32, Const<2>, Const<1>, Const<1>, Const<41>, 4>";
        assert!(library.contains(kind) && library.contains("f32::NEG_INFINITY"), "{library}");
        let (ran, fmu) = export("fmu", &["--unproved"]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert!(fmu.join("window.fmu").exists());
    }
}

/// A Kalman filter in filter form, in each language, of a plant in continuous and in discrete time.
#[test]
fn a_kalman_filter_in_filter_form_is_exported() {
    let observer = "[[observer]]\nname = \"filter\"\nkind = \"kalman\"\nw = [0, 1]\nv = 0.01\nform = \"filter\"\n";
    let (start, _) = LOOP.split_once("[[observer]]").unwrap();
    let continuous = format!("{}{observer}", start.replace("observer = \"linear\"", "observer = \"filter\""));
    let discrete = continuous
        .replace("[[0, 1], [0, 0]]", "[[1, 0.05], [0, 1]]")
        .replace("[[0], [1]]", "[[0.00125], [0.05]]\ndt = 0.05")
        .replace("hold = 0.05\n", "");
    for (name, text) in [("continuous", &continuous), ("discrete", &discrete)] {
        let (folder, file) = study(&format!("export-filter-form-{name}"), Some(text));
        let export = |to: &str, more: &[&str]| {
            let out = folder.join(to);
            let arguments = [&["export", &file, "--to", to, "-o", out.to_str().unwrap()], more].concat();
            (luenberger(&arguments, ""), out)
        };
        let (ran, c) = export("c", &["--test-steps", "300"]);
        assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{name}");
        assert!(
            ran.stdout.contains("Proved (certificate.json)") && ran.stdout.contains("of the filter form"),
            "{name}"
        );
        if name == "discrete" {
            assert!(ran.stdout.contains("gives the same estimates as the observer of the study"), "{}", ran.stdout);
        }
        golden(&c, "filter");
        let test = std::fs::read_to_string(c.join("test_filter.c")).unwrap();
        assert!(test.contains("300 of") || test.contains("of 300 steps"), "{name}");
        let header = std::fs::read_to_string(c.join("filter.h")).unwrap();
        assert!(header.contains("Stationary Kalman filter") && header.contains("double prediction["), "{header}");
        let (ran, rust) = export("rust", &["--format", "f32"]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let library = std::fs::read_to_string(rust.join("src/lib.rs")).unwrap();
        assert!(library.contains("pub type Observer = StaticStationaryKalmanFilter<f32, 2, 1, 1>;"), "{library}");
        let (ran, fmu) = export("fmu", &[]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let readme = std::fs::read_to_string(fmu.join("README.md")).unwrap();
        assert!(readme.contains("the estimate at the last sample, with its measurement"), "{readme}");
        for (options, says) in [
            (&["--feedback"][..], "it is in filter form, and the feedback takes the prediction\n  hint: form = "),
            (&["--format", "q8.24"], "it is in filter form, and fixed point takes the prediction\n  hint: form = "),
        ] {
            let out = folder.join("refused");
            let arguments = [&["export", &file, "--to", "c", "-o", out.to_str().unwrap()], options].concat();
            let ran = luenberger(&arguments, "");
            assert_eq!(ran.code, Some(1), "{options:?}: {}{}", ran.stdout, ran.stderr);
            assert!(ran.stderr.contains(says) && !out.exists(), "{options:?}: {}", ran.stderr);
        }
    }
    let (_, bad) = study("export-form", Some(&continuous.replace("\"filter\"\n", "\"filtre\"\n")));
    let ran = luenberger(&["export", &bad, "--to", "c"], "");
    assert!(ran.code == Some(2) && ran.stderr.contains("predictor"), "{}", ran.stderr);
}

/// The loop is proved where it is stable. By Jury's criterion for z^2 - tr z + det, with the double integrator sampled
/// every h = 0.05: k1 > 0, k2 > (h/2) k1 and k2 < 2/h.
#[test]
fn the_loop_is_proved_where_it_is_stable() {
    for (k, is_stable) in [
        ("4, 4", true),
        ("4, 0.1001", true),
        ("4, 0.0999", false),
        ("0.001, 4", true),
        ("-0.001, 4", false),
        ("4, 39.99", true),
        ("4, 40.01", false),
    ] {
        let (folder, file) = study("export-jury", Some(&LOOP.replace("[[4, 4]]", &format!("[[{k}]]"))));
        for format in ["f32", "f64"] {
            let arguments =
                ["export", &file, "--observer", "linear", "--feedback", "--unproved", "--to", "c", "--format", format];
            let out = folder.join("out");
            let ran = luenberger(&[&arguments[..], &["--json", "-o", out.to_str().unwrap()]].concat(), "");
            assert_eq!(ran.json()["proved"], is_stable, "K = [{k}], {format}: {}", ran.stdout);
        }
    }
}

#[test]
fn what_cannot_be_exported_says_why() {
    let (folder, file) = study("export-refused", None);
    let out = folder.join("out");
    let out = out.to_str().unwrap();
    let refused = |file: &str, more: &[&str], code: i32, says: &str| {
        let mut arguments = vec!["export", file, "--to", "c", "-o", out];
        arguments.extend(more);
        let ran = luenberger(&arguments, "");
        assert_eq!(ran.code, Some(code), "{more:?}: {}{}", ran.stdout, ran.stderr);
        assert!(ran.stderr.contains(says), "{more:?}: {}", ran.stderr);
        assert!(!Path::new(out).exists(), "{more:?}");
    };
    refused(&file, &[], 2, "several observers: choose one with --observer NAME, of linear, cubic, sampled");
    refused(&file, &["--observer", "liner"], 2, "the study has no observer \"liner\"; it has linear, cubic, sampled");
    refused(&file, &["--observer", "sampled", "--period", "0.5"], 1, "has the period 0.02 in the study, not 0.5");
    refused(&file, &["--observer", "linear", "--period", "0"], 2, "a positive finite number is expected");
    let (_, other) = study("export-converter", Some(&luenberger(&["new", "--plant", "cuk", "-o", "-"], "").stdout));
    refused(&other, &["--observer", "filter"], 1, "no stability certificate\n  hint: --unproved");
    refused(&other, &["--observer", "filter", "--period", "1"], 1, "filter has the period 0.00005 in the study, not 1");
    let (_, other) = study("export-point", Some(REACTOR));
    refused(
        &other,
        &["--observer", "cubic", "--period", "0.01"],
        1,
        "a cubic observer in deviations from an operating point has no export\n  hint: kind = \"luenberger\"",
    );
    let (_, other) =
        study("export-joint", Some(&luenberger(&["new", "--plant", "flexible-joint", "-o", "-"], "").stdout));
    refused(&other, &["--observer", "sector", "--period", "10"], 1, "Runge-Kutta steps per period would be needed");
    refused(&other, &["--observer", "sector", "--substeps", "0"], 2, "0 is not in 1..");
    let plant = "[plant]\na = [[0, 1], [0, 0]]\nc = [[1, 0]]\n[[observer]]\nkind = \"luenberger\"\npoles = [-1, -2]\n";
    let (_, still) = study("export-no-period", Some(plant));
    refused(&still, &[], 1, "no period is given\n  hint: --period, or simulation.hold in the study");
    let large = plant.replace("[[0, 1], [0, 0]]", "[[0, 1e39], [0, 0]]");
    let (_, large) = study("export-large", Some(&large));
    refused(&large, &["--period", "1", "--format", "f32"], 2, "is beyond the range of f32");
    // 1 - 1e-8 is 1 in binary32.
    let slow =
        "[plant]\na = [[0.99999999]]\nc = [[1]]\ndt = 1\n[[observer]]\nkind = \"luenberger\"\ngain = [[-1e-9]]\n";
    let (_, slow) = study("export-slow", Some(slow));
    refused(&slow, &["--format", "f32"], 1, "rounded to binary32, A - L C has the spectral radius");
    let twice = format!("{plant}name = \"a\"\n[[observer]]\nname = \"a\"\nkind = \"luenberger\"\npoles = [-1, -2]\n");
    let (_, twice) = study("export-twice", Some(&twice));
    refused(&twice, &["--observer", "a", "--period", "1"], 2, "two observers are named");
    let alike =
        format!("{plant}name = \"A b\"\n[[observer]]\nname = \"a-b\"\nkind = \"luenberger\"\npoles = [-1, -2]\n");
    let (_, alike) = study("export-alike", Some(&alike));
    refused(&alike, &["--observer", "a-b", "--period", "1"], 2, "\"A b\" and \"a-b\" give the same file names");
    let still_zero =
        format!("{plant}\n[input]\nexpressions = []\n[simulation]\nx0 = [0, 0]\nduration = 1\nsamples = 2\nhold = 0\n");
    let (_, zero) = study("export-zero", Some(&still_zero));
    refused(&zero, &[], 2, "hold");
}

/// A folder is ours if its manifest says so; others are refused, and so is one that cannot be written.
#[test]
fn folders_of_others_are_refused_and_ours_are_replaced() {
    let (folder, file) = study("export-folders", None);
    let export = |to: &str, out: &Path| {
        luenberger(&["export", &file, "--observer", "sampled", "--to", to, "-o", out.to_str().unwrap()], "")
    };
    let theirs = folder.join("theirs");
    std::fs::create_dir(&theirs).unwrap();
    std::fs::write(theirs.join("main.c"), "mine").unwrap();
    let ran = export("c", &theirs);
    assert_eq!(ran.code, Some(2), "{}", ran.stdout);
    assert!(ran.stderr.contains("theirs"), "{}", ran.stderr);
    assert_eq!(std::fs::read_dir(&theirs).unwrap().count(), 1);

    // Ours: its files are replaced, others stay, also those of the same name as a new file.
    let ours = folder.join("ours");
    assert_eq!(export("rust", &ours).code, Some(0));
    std::fs::write(ours.join("main.c"), "mine").unwrap();
    let ran = export("c", &ours);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(!ours.join("src/lib.rs").exists() && ours.join("sampled.c").is_file());
    assert_eq!(std::fs::read_to_string(ours.join("main.c")).unwrap(), "mine");

    // A file in the place of the folder, and a folder that cannot be made: root writes into read-only ones.
    let at = folder.join("file");
    std::fs::write(&at, "").unwrap();
    for out in [at.clone(), at.join("below")] {
        let ran = export("c", &out);
        assert_eq!(ran.code, Some(2), "{}", ran.stderr);
        assert!(ran.stderr.contains("file"), "{}", ran.stderr);
    }
    #[cfg(target_os = "linux")]
    {
        // Read-only for every user.
        let ran = export("c", Path::new("/proc/luenberger"));
        assert_eq!(ran.code, Some(2), "{}", ran.stderr);
        assert!(ran.stderr.contains("/proc/luenberger"), "{}", ran.stderr);
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let closed = folder.join("closed");
        std::fs::create_dir(&closed).unwrap();
        std::fs::set_permissions(&closed, std::fs::Permissions::from_mode(0o555)).unwrap();
        let ran = export("c", &closed);
        if ran.code == Some(0) {
            eprintln!("SKIPPED: this user writes into read-only folders");
        } else {
            assert_eq!(ran.code, Some(2), "{}", ran.stderr);
            assert!(ran.stderr.contains("closed"), "{}", ran.stderr);
        }
        std::fs::set_permissions(&closed, std::fs::Permissions::from_mode(0o755)).unwrap();
    }
}

/// Without a certificate only on request, and the header says so.
#[test]
fn an_observer_without_a_certificate_is_exported_on_request() {
    // A = I/2 + k [1 -1; 1 -1], k = 2^17, has the eigenvalues 1/2, and the P of A'PA - P + I = 0 entries of k^2.
    let text = "[plant]\na = [[131072.5, -131072], [131072, -131071.5]]\nc = [[1, 0]]\ndt = 1\n[[observer]]\nkind = \"luenberger\"\ngain = [[0], [0]]\n";
    let (folder, file) = study("export-unproved", Some(text));
    let out = folder.join("c");
    let arguments = ["export", &file, "--to", "c", "-o", out.to_str().unwrap()];
    let ran = luenberger(&arguments, "");
    assert_eq!(ran.code, Some(1), "{}{}", ran.stdout, ran.stderr);
    assert!(ran.stderr.contains("--unproved exports it all the same"), "{}", ran.stderr);
    assert!(!out.exists());
    let ran = luenberger(&[&arguments[..], &["--unproved"]].concat(), "");
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let header = std::fs::read_to_string(out.join("luenberger.h")).unwrap();
    assert!(header.contains(" * No stability certificate.") && !header.contains("Proved"), "{header}");
    assert!(!out.join("certificate.json").exists());
}

/// The names of the observers of a study, as the command lists them.
fn observers(file: &str) -> Vec<String> {
    let message = luenberger(&["export", file, "--to", "c", "--observer", "no such observer"], "").stderr;
    let list = message
        .split("it has ")
        .nth(1)
        .and_then(|list| list.lines().next())
        .unwrap_or_else(|| panic!("{file}: {message}"));
    list.split(", ").map(str::to_owned).collect()
}

/// The identifier of an export: the name of its header.
fn header(folder: &Path) -> String {
    let mut names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.find_map(|name| name.strip_suffix(".h").map(str::to_owned)).unwrap()
}

/// Exports every observer of a study as C and runs its golden test: the study and the observer, and whether it is
/// proved.
fn export_all(file: &Path, folder: &Path) -> Vec<(String, String, bool)> {
    let study = file.file_stem().unwrap().to_str().unwrap();
    let file = file.to_str().unwrap();
    let mut exported = Vec::new();
    for (k, observer) in observers(file).into_iter().enumerate() {
        let out = folder.join(k.to_string());
        let out_text = out.to_str().unwrap();
        let mut arguments = vec!["export", file, "--observer", &observer, "--to", "c", "--unproved", "-o", out_text];
        let mut ran = luenberger(&arguments, "");
        if ran.stderr.contains("no period is given") {
            arguments.extend(["--period", "0.01"]);
            ran = luenberger(&arguments, "");
        }
        if ran.stderr.contains("is long for the fastest mode") && arguments.contains(&"--period") {
            arguments.truncate(arguments.len() - 2);
            arguments.extend(["--period", "1e-5"]);
            ran = luenberger(&arguments, "");
        }
        assert_eq!(ran.code, Some(0), "{file}, {observer}: {}", ran.stderr);
        golden(&out, &header(&out));
        exported.push((study.to_owned(), observer, ran.stdout.contains("Proved (certificate.json)")));
    }
    exported
}

/// Every observer of every template and example becomes C that agrees with its design; of a third of the files where
/// not [`every_case`] is asked for.
#[test]
fn observers_of_templates_and_examples_become_c_that_agrees_with_their_designs() {
    let folder = folder("export-all");
    let mut files = Vec::new();
    let list = luenberger(&["new", "--list"], "").stdout;
    for name in list.lines().map_while(|line| line.split_whitespace().next()) {
        let file = folder.join(format!("{name}.toml"));
        let made = luenberger(&["new", "--plant", name, "-o", file.to_str().unwrap()], "");
        assert_eq!(made.code, Some(0), "{name}: {}", made.stderr);
        files.push(file);
    }
    assert!(files.len() >= 8, "{list}");
    let templates = files.len();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/studies");
    let mut folders = vec![examples];
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            match path.extension().and_then(|extension| extension.to_str()) {
                Some("toml") => files.push(path),
                None if path.is_dir() => folders.push(path),
                _ => {}
            }
        }
    }
    // The templates stand in the order of their list, the examples in that of their names.
    files[templates..].sort();
    let stride = if every_case() { 1 } else { 3 };
    let files: Vec<PathBuf> = files.into_iter().skip(stride / 2).step_by(stride).collect();
    // Each thread takes the next file.
    let next = AtomicUsize::new(0);
    let work = || {
        let mut exported = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(file) = files.get(index) else { return exported };
            exported.extend(export_all(file, &folder.join(format!("out-{index}"))));
        }
    };
    let exported = std::thread::scope(|scope| {
        let other = scope.spawn(work);
        [work(), other.join().unwrap()].concat()
    });
    assert!(exported.len() >= 40 / stride, "{exported:?}");
    let is_taken = |study: &str| files.iter().any(|file| file.file_stem().is_some_and(|stem| stem == study));
    let proved = [
        ("mimo", "repeated poles"),
        ("measured-log", "stationary filter"),
        ("load-torque", "proportional-integral"),
        ("load-torque", "reduced-order"),
        ("load-torque", "extended-state"),
        ("two-tanks", "modal coordinates"),
        ("servo", "super-twisting"),
        ("servo", "extended-state"),
        ("resonance", "H-infinity"),
    ];
    let proved: Vec<_> = proved.into_iter().filter(|(study, _)| is_taken(study)).collect();
    assert!(proved.len() >= 9 / stride, "{files:?}");
    for (study, observer) in proved {
        let proved = (study.to_owned(), observer.to_owned(), true);
        assert!(exported.contains(&proved), "{study}, {observer}: {exported:?}");
    }
}

/// The stirred reactor of Seborg, Edgar and Mellichamp, Process Dynamics and Control, 2nd ed. 2004, table 2.3.
const REACTOR: &str = include_str!("../../../study/tests/studies/reactor.toml");

/// A linear observer at an operating point, in the coordinates of the plant. Its input and output are held: the
/// distance from the observer in continuous time is proportional to the period.
#[test]
fn a_linear_observer_at_an_operating_point_becomes_c() {
    let (folder, file) = study("export-point-linear", Some(REACTOR));
    let distance = |period: &str| {
        let out = folder.join(period);
        let arguments = ["export", &file, "--observer", "poles", "--to", "c", "--period", period, "--json", "-o"];
        let ran = luenberger(&[&arguments[..], &[out.to_str().unwrap()]].concat(), "");
        assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""));
        let written = ran.json();
        assert_eq!(written["proved"], true);
        golden(&out, "poles");
        written["difference"]["second_half"][1].as_f64().unwrap()
    };
    let (long, short) = (distance("0.01"), distance("0.001"));
    assert!(long < 0.2 && (8.0..12.0).contains(&(long / short)), "{long} {short}");
}

/// The linear and the cubic observers of the other templates in the formats of targets.
#[test]
fn the_observers_of_templates_agree_with_their_designs_in_other_formats() {
    for (plant, observer, name, formats) in [
        // Twenty states: the proof takes seconds.
        ("heat-rod", "stationary filter", "stationary_filter", &["q12.20"][..]),
        ("mimo", "repeated poles", "repeated_poles", &["q12.20"]),
        ("mimo", "complex poles", "complex_poles", &["f32"]),
        ("mimo", "stationary filter", "stationary_filter", &["f32", "q12.20"]),
        ("mimo", "cubic", "cubic", &["f32"]),
        ("measured-log", "stationary filter", "stationary_filter", &["q12.20"]),
        ("measured-log", "fast", "fast", &["f32"]),
        // The optimum of a search.
        ("optimal-cubic", "optimal", "optimal", &["f32"]),
        ("two-tanks", "plant coordinates", "plant_coordinates", &["f32"]),
        ("servo", "super-twisting", "super_twisting", &["f32"]),
        ("resonance", "H2", "h2", &["f32"]),
    ] {
        let folder = folder(&format!("export-{plant}-{name}"));
        let file = folder.join("study.toml").to_str().unwrap().to_owned();
        assert_eq!(luenberger(&["new", "--plant", plant, "-o", &file], "").code, Some(0));
        for format in formats {
            let out = folder.join(format);
            let out = out.to_str().unwrap();
            let arguments = [
                "export",
                &file,
                "--observer",
                observer,
                "--to",
                "c",
                "--period",
                // A sampled observer has a period of its own.
                if plant == "servo" { "0.001" } else { "0.01" },
                "--format",
                format,
                "-o",
                out,
            ];
            let ran = luenberger(&arguments, "");
            assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{plant} {observer} {format}");
            let stored = ran.stdout.contains("With the gains as stored in Q12.20");
            assert_eq!(stored, *format == "q12.20", "{plant} {observer} {format}: {}", ran.stdout);
            golden(Path::new(out), name);
        }
    }
}
