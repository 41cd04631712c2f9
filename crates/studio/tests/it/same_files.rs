//! Files in memory are those that the commands write into folders, byte for byte.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use luenberger_study::deployment::{ExportOptions, Language, export};
use luenberger_study::{Format, RunOptions, Step, Study, execute, write_folder};
use serde_json::json;

use crate::{asked, given};

/// An empty folder of this test.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("luenberger-studio-{}-{name}", std::process::id()));
    _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// All files below a folder, but for hidden ones.
fn files(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut open = vec![root.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/");
            if path.is_dir() {
                open.push(path);
            } else if !name.starts_with('.') {
                all.insert(name, std::fs::read(path).unwrap());
            }
        }
    }
    all
}

/// Compares the files of an answer with those of a folder, and removes the folder.
fn same(answer: luenberger_studio::Message, folder: &Path) {
    let (ours, theirs): (BTreeMap<String, Vec<u8>>, _) = (answer.files.into_iter().collect(), files(folder));
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&ours), names(&theirs));
    let differ: Vec<&String> =
        ours.iter().filter(|(name, bytes)| theirs[*name] != **bytes).map(|(name, _)| name).collect();
    assert_eq!(differ, Vec::<&String>::new());
    std::fs::remove_dir_all(folder).unwrap();
}

fn run_of(name: &str) {
    let (text, data) = given(name);
    let root = folder(name);
    for (file, bytes) in &data {
        std::fs::write(root.join(file), bytes).unwrap();
    }
    let study = Study::from_text("study.toml", text, Format::Toml, &root).unwrap();
    let out = root.join("out");
    execute(&study, Step::Run, &RunOptions::default().output(out.clone().into())).unwrap();
    let answer = asked(json!({ "do": "run", "study": text, "name": "study.toml" }), &data);
    assert!(answer.files.len() > 5);
    same(answer, &out);
    std::fs::remove_dir_all(root).unwrap();
}

#[test]
fn of_a_linear_study_with_a_sweep() {
    run_of("double-integrator");
}

#[test]
fn of_a_study_with_a_log() {
    run_of("measured-log");
}

#[test]
fn of_a_study_in_expressions() {
    run_of("servo");
}

/// Without figures the files below `figures/` are missing, and all others are there.
#[test]
fn figures_can_be_left_out() {
    let (text, data) = given("double-integrator");
    let with = asked(json!({ "do": "run", "study": text }), &data);
    let without = asked(json!({ "do": "run", "study": text, "figures": false }), &data);
    let is_kept = |name: &&str| !name.starts_with("figures/");
    let kept: Vec<&str> = crate::names(&with).into_iter().filter(is_kept).collect();
    assert!(kept.len() < with.files.len());
    assert_eq!(crate::names(&without), kept);
}

#[test]
fn of_exports() {
    let (text, data) = given("double-integrator");
    let study = Study::from_text("study.toml", text, Format::Toml, Path::new(".")).unwrap();
    for (language, to) in [("c", Language::C), ("rust", Language::Rust)] {
        let exported =
            export(&study, Some("cubic"), &ExportOptions::default().to(to).period(0.01).unproved(true)).unwrap();
        let out = folder(language);
        write_folder(out.as_path(), false, "export", &study, &exported.files).unwrap();
        let request = json!({
            "do": "export", "study": text, "observer": "cubic", "language": language, "period": 0.01, "unproved": true,
        });
        same(asked(request, &data), &out);
    }
}
