//! End-to-end tests of the templates: each is read, runs, and writes identical files for any number of threads.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::page::{body, read};
use crate::studies;
use luenberger_study::{RunOptions, Study, TEMPLATES, Template, execute::Step};

fn scratch(name: &str) -> PathBuf {
    studies::scratch(&format!("study/{name}"))
}

fn study(template: &Template) -> Study {
    Study::from_path(&Path::new(env!("CARGO_MANIFEST_DIR")).join("templates").join(format!("{}.toml", template.name)))
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Every file below a folder that is not hidden, with its bytes.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if !path.file_name().unwrap().to_string_lossy().starts_with('.') {
                let name = path.strip_prefix(folder).unwrap().to_string_lossy().replace('\\', "/");
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

fn run(template: &Template, folder: &Path, threads: usize) -> luenberger_study::Results {
    let options =
        RunOptions { output: Some(folder.to_owned().into()), threads: Some(threads), ..RunOptions::default() };
    luenberger_study::execute(&study(template), Step::Run, &options)
        .unwrap_or_else(|error| panic!("{}: {error}", template.name))
}

/// Numbers of moderate size written with an exponent, such as 1.2e1.
fn with_needless_exponents(text: &str) -> Vec<&str> {
    let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '.' || c == '-'));
    let needless = |word: &&str| word.contains('e') && word.parse().is_ok_and(|x: f64| (1e-4..1e6).contains(&x.abs()));
    words.filter(needless).collect()
}

/// A linear plant is shown by its matrices, times with the unit that the study gives, and a proof with plain numbers.
#[test]
fn the_report_of_a_linear_plant_shows_its_matrices() {
    assert_eq!(with_needless_exponents("<p>2(1e0)P, 1.1904e1: 3e-9 and 12"), ["1e0", "1.1904e1"]);
    let folder = scratch("matrices");
    run(luenberger_study::template::template("double-integrator").unwrap(), &folder, 2);
    let page = read(&folder.join("report.html"));
    let text_of_page = body(&page);
    for matrix in
        ["A = \\begin{bmatrix} 0 &amp; 1 \\\\ 0 &amp; 0 \\end{bmatrix}", "B = \\begin{bmatrix} 0 \\\\ 1 \\end{bmatrix}"]
    {
        assert!(text_of_page.contains(matrix), "{text_of_page}");
    }
    assert!(text_of_page.contains("settling time (s)") && page.contains("time t (s)"));
    assert!(text_of_page.contains("(12) is its number in the paper on the cubic observer."));
    let seconds = "time_unit = \"s\"\n";
    let text = luenberger_study::template::text("double-integrator").unwrap();
    assert!(text.contains(seconds));
    let without =
        Study::from_text("t.toml", &text.replace(seconds, ""), luenberger_study::Format::Toml, &folder).unwrap();
    let options = RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() };
    luenberger_study::run(&without, &options).unwrap();
    let page = read(&folder.join("report.html"));
    assert!(page.contains("\"time t\"") && !page.contains("time t (s)") && body(&page).contains("settling time</th>"));
}

/// Runs the template twice and checks the invariants of every run.
fn end_to_end(name: &str) -> luenberger_study::Results {
    let template = luenberger_study::template::template(name).unwrap();
    let [first, second] = ["first", "second"].map(|which| scratch(&format!("{name}-{which}")));
    let results = run(template, &first, 2);
    run(template, &second, 1);
    assert_eq!(results.failures(), Vec::<String>::new(), "{name}");
    let (one, two) = (files(&first), files(&second));
    assert_eq!(one.keys().collect::<Vec<_>>(), two.keys().collect::<Vec<_>>());
    for (file, bytes) in &one {
        assert!(*bytes == two[file], "{name}: {file} differs between two runs");
    }
    for file in ["manifest.json", "report.html", "study.json"] {
        assert!(one.contains_key(file), "{name} has no {file}");
    }
    let listed: Vec<&String> =
        one.keys().filter(|file| !["manifest.json", "study.json"].contains(&file.as_str())).collect();
    assert_eq!(results.files.iter().collect::<Vec<_>>(), listed, "study.json lists the files that are there");
    let mut proofs = 0;
    for (file, bytes) in one.iter().filter(|(file, _)| file.starts_with("certificates/")) {
        luenberger_proof::certificate::verify(bytes).unwrap_or_else(|error| panic!("{name}: {file}: {error}"));
        // A bound of the error under disturbances is in a file of its own.
        proofs += usize::from(!file.ends_with(".bounds.json") && !file.ends_with(".feedback.json"));
    }
    // The maps of a PEBO are proved, but no theorem that a certificate has follows from them alone.
    let with_facts = results
        .observers
        .iter()
        .filter(|o| o.kind != "pebo" && o.design.as_ref().is_some_and(|design| !design.facts.is_empty()));
    assert_eq!(proofs, with_facts.count(), "{name}: a certificate for each observer with a proof");
    let page = String::from_utf8(one["report.html"].clone()).unwrap();
    for figure in one.keys().filter_map(|file| file.strip_prefix("figures/")?.strip_suffix(".svg")) {
        assert!(page.contains(&format!("data-picture=\"{figure}\"")), "{name}: the report does not draw {figure}");
        assert!(one.contains_key(&format!("figures/{figure}.png")));
    }
    // The last section has digests, and the study as it was written.
    let shown = body(&page);
    let (written, reproduction) = shown.split_once("<section id=\"reproduction\">").unwrap();
    assert_eq!(with_needless_exponents(written), Vec::<&str>::new(), "{name}: numbers in the report");
    assert!(reproduction.contains("[[observer]]"), "{name}: the study is in its report");
    assert!(
        body(&page).matches("<th>least observable direction</th>").count() <= 2,
        "{name}: one table of modes, or two with the hidden ones"
    );
    // A filter of a template passes the test of consistency that it teaches.
    for filter in &results.filters {
        let nis = filter.nis.as_ref().unwrap();
        assert!(nis.accepted, "{name}: NIS {} outside {:?}", nis.mean, nis.region);
    }
    let noise = results.warnings.iter().find(|warning| warning.contains(": v of "));
    assert_eq!(noise, None, "{name}: the noise of a filter is that of the simulation");
    let machine = env!("CARGO_MANIFEST_DIR");
    let leaks = one.iter().find(|(_, bytes)| bytes.windows(machine.len()).any(|window| window == machine.as_bytes()));
    assert!(leaks.is_none(), "{name}: a path of this machine stands in {}", leaks.unwrap().0);
    results
}

macro_rules! templates {
    ($($test:ident $name:literal;)*) => {
        $(#[test] fn $test() { end_to_end($name); })*
        #[test]
        fn every_template_is_tried() {
            let mut tried = vec![$($name),*];
            let mut all: Vec<&str> = TEMPLATES.iter().map(|template| template.name).collect();
            tried.sort_unstable();
            all.sort_unstable();
            assert_eq!(tried, all);
        }
    };
}

templates! {
    double_integrator "double-integrator";
    flexible_joint "flexible-joint";
    cuk "cuk";
    cuk_observers "cuk-observers";
    cuk_table_1 "cuk-table-1";
    exponential_cascade "exponential-cascade";
    van_der_pol "van-der-pol";
    chaotic "chaotic";
    duffing "duffing";
    heat_rod "heat-rod";
    mimo "mimo";
    load_torque "load-torque";
    two_tanks "two-tanks";
    servo "servo";
    optimal_cubic "optimal-cubic";
    attitude "attitude";
    resonance "resonance";
    measured_log "measured-log";
}

/// Compares every number of `study.json` with the golden one, to the accuracy of the integrator (1e-9 for each step)
/// with a margin for another machine.
fn near(path: &str, found: &serde_json::Value, golden: &serde_json::Value) {
    use serde_json::Value;
    match (found, golden) {
        (Value::Number(found), Value::Number(golden)) => {
            let (x, y) = (found.as_f64().unwrap(), golden.as_f64().unwrap());
            assert!((x - y).abs() <= 1e-6 * y.abs() + 1e-9, "{path}: {x} where {y} was expected");
        }
        (Value::Array(found), Value::Array(golden)) => {
            assert_eq!(found.len(), golden.len(), "{path}");
            found.iter().zip(golden).enumerate().for_each(|(i, (x, y))| near(&format!("{path}[{i}]"), x, y));
        }
        (Value::Object(found), Value::Object(golden)) => {
            assert_eq!(found.keys().collect::<Vec<_>>(), golden.keys().collect::<Vec<_>>(), "{path}");
            found.iter().for_each(|(key, x)| near(&format!("{path}.{key}"), x, &golden[key]));
        }
        // Text contains rounded numbers, which may round differently.
        (Value::String(found), Value::String(golden)) => {
            let words = |text: &str| text.chars().filter(|c| c.is_alphabetic()).collect::<String>();
            assert_eq!(words(found), words(golden), "{path}");
        }
        _ => assert_eq!(found, golden, "{path}"),
    }
}

fn golden(name: &str) {
    let template = luenberger_study::template::template(name).unwrap();
    let results = luenberger_study::run(&study(template), &RunOptions::default()).unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(format!("{name}.json"));
    if std::env::var_os("UPDATE").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, results.to_json().unwrap()).unwrap();
    }
    let golden = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    near(name, &serde_json::to_value(&results).unwrap(), &golden);
}

/// Run with `UPDATE=1` in the environment after an intended change.
#[test]
fn the_double_integrator_has_its_golden_numbers() {
    golden("double-integrator");
}

#[test]
fn the_motor_on_the_bench_has_its_golden_numbers() {
    golden("measured-log");
}

#[test]
fn an_interruption_leaves_what_is_finished() {
    use std::sync::atomic::{AtomicBool, Ordering};
    let folder = scratch("interrupted");
    let cancel = AtomicBool::new(false);
    // The user interrupts after the first observer has been simulated.
    let progress = |progress: luenberger_study::Progress<'_>| {
        if progress.stage == "simulate" {
            cancel.store(true, Ordering::Relaxed);
        }
    };
    let options = RunOptions {
        output: Some(folder.clone().into()),
        progress: &progress,
        cancel: &cancel,
        threads: Some(1),
        ..RunOptions::default()
    };
    let study = study(luenberger_study::template::template("mimo").unwrap());
    let error = luenberger_study::run(&study, &options).unwrap_err();
    assert!(matches!(error, luenberger_study::StudyError::Interrupted));
    let left = files(&folder);
    let json: serde_json::Value = serde_json::from_slice(&left["study.json"]).unwrap();
    assert_eq!(json["observers"].as_array().unwrap().len(), 4);
    assert_eq!(left.keys().filter(|name| name.starts_with("trajectories/")).count(), 2, "one run, as CSV and npz");
    // Of four observers, and of the loop.
    assert_eq!(left.keys().filter(|name| name.starts_with("certificates/")).count(), 5);
    assert!(!left.contains_key("report.html"));
}

#[test]
fn an_estimate_counts_the_runs() {
    let study = study(luenberger_study::template::template("mimo").unwrap());
    let estimate = luenberger_study::estimate(&study, Step::Run, 1);
    // Four observers, and two of them at four values three times each.
    assert_eq!(estimate.runs, 4 + 2 * 4 * 3);
    assert!(estimate.seconds > 0.0 && estimate.seconds < 3600.0);
    assert_eq!(luenberger_study::estimate(&study, Step::Design, 1).runs, 0);
}
