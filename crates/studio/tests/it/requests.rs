//! What each request answers.

use std::fmt::Write;
use std::io::Read;
use std::sync::Mutex;

use luenberger_studio::{Host, Message, answer};
use luenberger_study::TEMPLATES;
use serde_json::{Value, json};

use crate::{asked, file, given, names};

#[test]
fn about_has_every_template_with_its_files() {
    let about = asked(json!({ "do": "about" }), &[]);
    let templates = about.json["templates"].as_array().unwrap();
    assert_eq!(templates.len(), TEMPLATES.len());
    assert!(templates.iter().all(|one| one["title"].as_str().is_some_and(|title| !title.is_empty())));
    assert_eq!(names(&about), ["measured-log/measured-log.csv"]);
    assert_eq!(about.json["schema"]["title"], "luenberger study");
    assert_eq!(about.json["version"], env!("CARGO_PKG_VERSION"));
}

#[test]
fn check_finds_each_key_where_it_stands() {
    let (text, _) = given("double-integrator");
    let check = asked(json!({ "do": "check", "study": text }), &[]);
    let outline = check.json["outline"].as_array().unwrap();
    let at = |path: Value| outline.iter().find(|one| one["path"] == path).unwrap_or_else(|| panic!("{path}"));
    let value = |one: &Value| {
        let [from, to] = ["from", "to"].map(|key| one[key].as_u64().unwrap() as usize);
        text[from..to].to_owned()
    };
    assert_eq!(value(at(json!(["observer", 1, "kind"]))), "\"cubic\"");
    let key = at(json!(["plant", "a"]));
    let [from, to] = ["key_from", "key_to"].map(|end| key[end].as_u64().unwrap() as usize);
    assert_eq!((&text[from..to], key["kind"].as_str()), ("a", Some("array")));
    assert_eq!(check.json["observers"][1], json!({ "name": "cubic", "kind": "cubic" }));
    assert!(check.json["estimate"]["seconds"].as_f64().unwrap() > 0.0);
    assert!(check.json["exports"][1]["languages"].as_array().unwrap().contains(&json!("fmu3")));
    assert_eq!(check.json["has"]["sweep"], true);
}

/// The places are bytes: a letter of two bytes in front counts twice.
#[test]
fn a_mistake_has_the_place_of_its_word() {
    let (text, _) = given("double-integrator");
    let text = format!("# \u{fc}ber\n{}", text.replacen("poles =", "pols =", 1));
    let check = asked(json!({ "do": "check", "study": text, "name": "mine.toml" }), &[]);
    let found = &check.json["diagnostics"][0];
    let [from, to] = ["from", "to"].map(|key| found[key].as_u64().unwrap() as usize);
    assert_eq!(&text[from..to], "pols");
    assert_eq!(found["line"], text[..from].matches('\n').count() + 1);
    assert_eq!((&found["column"], &found["severity"]), (&json!(1), &json!("error")));
    let rendered = check.json["rendered"].as_str().unwrap();
    assert!(rendered.contains("mine.toml:") && rendered.contains("the nearest key is `poles`"), "{rendered}");
    assert!(check.json["outline"].as_array().unwrap().iter().any(|one| one["path"] == json!(["plant", "a"])));
    // A run says the same.
    let run = crate::ask(json!({ "do": "run", "study": text, "name": "mine.toml" }), &[]);
    assert_eq!(run.json["rendered"], check.json["rendered"]);
    assert_eq!(run.json["error"]["diagnostics"], check.json["diagnostics"]);
    let said = run.json["error"]["message"].as_str().unwrap();
    assert!(said.starts_with("mine.toml: line ") && said.lines().count() == 1, "{said}");
}

/// Progress of a run.
struct Told(Mutex<Vec<Value>>);

impl Host for Told {
    fn progress(&self, json: &str) {
        self.0.lock().unwrap().push(serde_json::from_str(json).unwrap());
    }
}

#[test]
fn a_run_tells_of_its_progress_and_its_failures() {
    let (text, _) = given("double-integrator");
    // A place that no observer of this kind takes: the others are designed all the same.
    let text = format!("{text}\n[[observer]]\nname = \"lost\"\nkind = \"luenberger\"\npoles = [-1, -1, -1]\n");
    let bad = asked(json!({ "do": "check", "study": text }), &[]);
    assert_eq!(bad.json["diagnostics"].as_array().unwrap().len(), 1);
    let text = text.replace("poles = [-1, -1, -1]", "decay_rate = 3\nmax_gain = 0.01");
    let told = Told(Mutex::default());
    let request = Message::new(json!({ "do": "run", "step": "certify", "study": text, "name": "study.toml" }));
    let run = Message::read(&answer(&request.bytes(), &told)).unwrap();
    assert!(run.json["error"].is_null(), "{}", run.json["error"]);
    let told = told.0.into_inner().unwrap();
    assert!(told.iter().any(|one| one["stage"] == "design" && one["done"] == one["of"]), "{told:?}");
    assert_eq!(run.json["failures"][0]["observer"], "lost");
    let summary = run.json["summary"].as_str().unwrap();
    assert!(summary.contains("failed: lost: "), "{summary}");
    assert!(names(&run).contains(&"certificates/cubic.json"));
    let study: Value = serde_json::from_slice(file(&run, "study.json")).unwrap();
    assert_eq!(study, run.json["results"]);
}

#[test]
fn a_limit_keeps_what_is_finished() {
    let (text, data) = given("cuk-observers");
    let run = asked(json!({ "do": "run", "study": text, "limit_seconds": 0.001 }), &data);
    assert!(run.json["stopped"].as_str().unwrap().contains("time limit"), "{}", run.json["stopped"]);
    assert!(names(&run).contains(&"study.json"));
}

#[test]
fn certificates_are_verified_and_forged_ones_rejected() {
    let (text, _) = given("double-integrator");
    let run = asked(json!({ "do": "run", "step": "certify", "study": text }), &[]);
    let certificate = file(&run, "certificates/cubic.json").to_vec();
    let found = asked(json!({ "do": "verify" }), &[("cubic.json", &certificate)]);
    assert_eq!(found.json["verdict"], "proved");
    assert!(found.json["rendered"].as_str().unwrap().starts_with("cubic.json: Proved\n"));
    assert!(!found.json["facts"].as_array().unwrap().is_empty());
    let forged = String::from_utf8(certificate).unwrap().replacen("\"title\": \"", "\"title\": \"not ", 1);
    let found = asked(json!({ "do": "verify" }), &[("cubic.json", forged.as_bytes())]);
    assert_eq!(found.json["verdict"], "rejected");
    let found = asked(json!({ "do": "verify" }), &[("cubic.json", b"none")]);
    assert_eq!(found.json["verdict"], "unreadable");
}

#[test]
fn columns_are_offered_by_name() {
    let csv = b"Time,duty,Voltage,angle\n0,1,2,3\n0.1,1,2,4\n";
    let found = asked(json!({ "do": "columns" }), &[("bench.csv", csv)]);
    assert_eq!(found.json["columns"], json!(["Time", "duty", "Voltage", "angle"]));
    assert_eq!(found.json["rows"], 2);
    let expected = "[log]\nfile = \"bench.csv\"\ntime = \"Time\"\noutputs = [\"duty\", \"Voltage\", \"angle\"]\n";
    assert_eq!(found.json["suggestion"], expected);
    let study = "[plant]\nstates = [\"angle\", \"speed\"]\ninputs = [\"voltage\"]\noutputs = [\"angle\"]\n\
                 a = [[0, 1], [0, -1]]\nb = [[0], [1]]\nc = [[1, 0]]\n";
    let found = asked(json!({ "do": "columns", "study": study }), &[("bench.csv", csv)]);
    let expected = "[log]\nfile = \"bench.csv\"\ntime = \"Time\"\ninputs = [\"Voltage\"]\n";
    assert_eq!(found.json["suggestion"], expected);
    // The study with it reads the log.
    let study = format!("{study}{expected}[[observer]]\nname = \"one\"\nkind = \"luenberger\"\npoles = [-4, -5]\n");
    let check = asked(json!({ "do": "check", "study": study }), &[("bench.csv", csv)]);
    assert_eq!(check.json["diagnostics"], json!([]));
    assert_eq!(check.json["has"]["log"], true);
}

#[test]
fn advise_and_tune_leave_the_files_of_the_commands() {
    let study = "[plant]\na = [[0, 1], [0, 0]]\nc = [[1, 0]]\n[simulation]\nx0 = [1, 0]\nduration = 5\n\
                 noise = { distribution = \"gaussian\", amplitude = [0.01], period = 0.1 }\n[advise]\nensemble = 2\n";
    let advice = asked(json!({ "do": "advise", "study": study }), &[]);
    assert!(names(&advice).contains(&"study.toml") && names(&advice).contains(&"advice.json"), "{:?}", names(&advice));
    assert!(advice.json["text"].as_str().unwrap().contains("kalman"));
    // A random walk with noise, by a generator that is written out here.
    let (mut state, mut x, mut log) = (1_u32, 0.0, "t,y\n".to_owned());
    let mut uniform = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24) - 0.5
    };
    for k in 0..200 {
        _ = writeln!(log, "{k},{}", x + 4.0 * uniform());
        x += 2.0 * uniform();
    }
    let study = "[plant]\na = [[1]]\nc = [[1]]\ndt = 1\noutputs = [\"y\"]\n[log]\nfile = \"log.csv\"\n[[observer]]\n\
                 name = \"filter\"\nkind = \"extended-kalman\"\ninitial = [0]\nw = [0.1]\nv = [1]\nperiod = 1\n[tune]\n\
                 observer = \"filter\"\nparameters = [\"w\", \"v\"]\nprofile = 0\n";
    let tuned = asked(json!({ "do": "tune", "study": study, "name": "study.toml" }), &[("log.csv", log.as_bytes())]);
    assert_eq!(tuned.json["file"], "tuned.toml");
    assert_eq!(file(&tuned, "tuned.toml"), tuned.json["study"].as_str().unwrap().as_bytes());
    // The variances of the two uniform distributions are 16/12 and 4/12; the intervals have them.
    for (parameter, variance) in
        tuned.json["results"]["parameters"].as_array().unwrap().iter().zip([1.0 / 3.0, 4.0 / 3.0])
    {
        let [low, high] = [0, 1].map(|end| parameter["interval"][end].as_f64().unwrap());
        assert!(low < variance && variance < high, "{parameter}");
    }
}

#[test]
fn a_zip_has_all_files() {
    let files: [(&str, &[u8]); 2] = [("a/b.csv", b"t,y\n"), ("study.toml", "title = \"\u{fc}\"\n".as_bytes())];
    let zip = asked(json!({ "do": "zip" }), &files);
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(file(&zip, "archive.zip"))).unwrap();
    assert_eq!(archive.len(), 2);
    for (name, bytes) in files {
        let mut found = Vec::new();
        archive.by_name(name).unwrap().read_to_end(&mut found).unwrap();
        assert_eq!(found, bytes);
    }
}
