//! The results folder: what a run replaces, what it keeps, and what it refuses.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use luenberger_study::{MemoryFolder, RunOptions, Step, StudyError, execute};
use serde_json::Value;

use crate::studies::study;

const STUDY: &str = r#"title = "t"
[plant]
a = [[0, 1], [0, 0]]
c = [[1, 0]]
[simulation]
x0 = [1, 1]
duration = 1
samples = 5
[[observer]]
name = "one"
kind = "luenberger"
poles = [-2, -5]
[[observer]]
name = "two"
kind = "luenberger"
poles = [-3, -4]
"#;

fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("folder").join(name);
    _ = fs::remove_dir_all(&folder);
    folder
}

fn run_with(text: &str, folder: &Path, force: bool) -> Result<Vec<(String, String)>, StudyError> {
    let study = study(text);
    let options = RunOptions { output: Some(folder.to_owned().into()), force, ..RunOptions::default() };
    execute(&study, Step::Run, &options).map(|results| results.renamed)
}

#[track_caller]
fn run(text: &str, folder: &Path) -> Vec<(String, String)> {
    run_with(text, folder, false).unwrap_or_else(|error| panic!("{error}"))
}

/// Every file below a folder, hidden ones and all.
fn files(folder: &Path) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                found.insert(path.strip_prefix(folder).unwrap().to_string_lossy().replace('\\', "/"));
            }
        }
    }
    found
}

fn manifest(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("manifest.json")).unwrap()).unwrap()
}

/// The second observer is gone from the study, and all its files with it.
fn without_two() -> String {
    STUDY[..STUDY.rfind("[[observer]]").unwrap()].to_owned()
}

#[test]
fn the_manifest_has_every_file_with_its_digest() {
    let folder = scratch("manifest");
    run(STUDY, &folder);
    let manifest = manifest(&folder);
    assert_eq!(manifest["command"], "run");
    assert_eq!(manifest["luenberger"], env!("CARGO_PKG_VERSION"));
    assert_eq!((&manifest["study"]["name"], &manifest["study"]["bytes"]), (&"study.toml".into(), &STUDY.len().into()));
    let mut listed: BTreeSet<String> =
        manifest["files"].as_array().unwrap().iter().map(|entry| entry["name"].as_str().unwrap().to_owned()).collect();
    listed.extend([".luenberger.lock".to_owned(), "manifest.json".to_owned()]);
    assert_eq!(listed, files(&folder));
    // sha256sum (GNU coreutils 9.4) of the text above, as a file.
    assert_eq!(manifest["study"]["sha256"], "e0439ec29b0718116ff58f3f0d868aeeced79868486361ffb63600c065f74f85");
    for entry in manifest["files"].as_array().unwrap() {
        let size = fs::metadata(folder.join(entry["name"].as_str().unwrap())).unwrap().len();
        assert_eq!(entry["bytes"], size, "{entry}");
    }
}

#[test]
fn nothing_of_an_earlier_study_stays_and_nothing_else_goes() {
    let folder = scratch("earlier");
    run(STUDY, &folder);
    fs::write(folder.join("notes.txt"), "mine").unwrap();
    fs::write(folder.join("certificates/mine.json"), "mine").unwrap();
    assert!(folder.join("certificates/two.json").is_file());
    assert_eq!(run(&without_two(), &folder), []);
    let left = files(&folder);
    assert!(left.iter().all(|name| !name.contains("two")), "{left:?}");
    assert!(left.contains("certificates/one.json"));
    for mine in ["notes.txt", "certificates/mine.json"] {
        assert_eq!(fs::read_to_string(folder.join(mine)).unwrap(), "mine");
    }
    // Folders that become empty go as well.
    let plain = without_two().replace("[simulation]\nx0 = [1, 1]\nduration = 1\nsamples = 5\n", "");
    run(&plain, &folder);
    assert!(!folder.join("trajectories").exists() && !folder.join("figures").exists());
    assert!(folder.join("certificates/mine.json").is_file());
    let fresh = scratch("earlier-fresh");
    run(&plain, &fresh);
    let without_mine: BTreeSet<String> =
        files(&folder).into_iter().filter(|name| !["notes.txt", "certificates/mine.json"].contains(&&**name)).collect();
    assert_eq!(without_mine, files(&fresh));
    for name in without_mine {
        assert!(fs::read(folder.join(&name)).unwrap() == fs::read(fresh.join(&name)).unwrap(), "{name}");
    }
}

#[test]
fn what_was_changed_by_hand_is_kept_under_another_name() {
    let folder = scratch("changed");
    run(STUDY, &folder);
    fs::write(folder.join("report.html"), "annotated").unwrap();
    fs::write(folder.join("certificates/two.json"), "annotated").unwrap();
    // A file of the user under a name that the next run needs, and one where it needs a folder.
    let renamed = run(&without_two(), &folder);
    assert_eq!(renamed, [("report.html".to_owned(), "report.html.old".to_owned())]);
    assert_eq!(fs::read_to_string(folder.join("report.html.old")).unwrap(), "annotated");
    assert_eq!(fs::read_to_string(folder.join("certificates/two.json")).unwrap(), "annotated");
    fs::write(folder.join("report.html"), "again").unwrap();
    assert_eq!(run(&without_two(), &folder), [("report.html".to_owned(), "report.html.old2".to_owned())]);
    assert_eq!(run(&without_two(), &folder), []);
    fs::remove_dir_all(folder.join("figures")).unwrap();
    fs::write(folder.join("figures"), "a file").unwrap();
    assert_eq!(run(&without_two(), &folder), [("figures".to_owned(), "figures.old".to_owned())]);
    assert!(folder.join("figures/states.svg").is_file());
}

/// A change that leaves the length of a file as it was is a change.
#[test]
fn a_digit_changed_by_hand_is_kept_too() {
    let folder = scratch("changed-digit");
    run(STUDY, &folder);
    let path = folder.join("trajectories/one.csv");
    let mut bytes = fs::read(&path).unwrap();
    let digit = bytes.iter().rposition(u8::is_ascii_digit).unwrap();
    bytes[digit] = if bytes[digit] == b'1' { b'2' } else { b'1' };
    fs::write(&path, &bytes).unwrap();
    let name = "trajectories/one.csv".to_owned();
    assert_eq!(run(STUDY, &folder), [(name.clone(), format!("{name}.old"))]);
    assert_eq!(fs::read(folder.join("trajectories/one.csv.old")).unwrap(), bytes);
}

#[test]
fn a_folder_of_another_is_refused_unless_forced() {
    let folder = scratch("foreign");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("report.html"), "mine").unwrap();
    fs::write(folder.join("manifest.json"), "{\"name\": \"an app\"}").unwrap();
    let error = run_with(STUDY, &folder, false).unwrap_err();
    assert!(matches!(error, StudyError::ForeignFolder { .. }) && error.to_string().contains("--force"), "{error}");
    assert_eq!(files(&folder).len(), 2);
    let mut renamed = run_with(STUDY, &folder, true).unwrap();
    renamed.sort();
    let pair = |name: &str| (name.to_owned(), format!("{name}.old"));
    assert_eq!(renamed, [pair("manifest.json"), pair("report.html")]);
    assert_eq!(fs::read_to_string(folder.join("report.html.old")).unwrap(), "mine");
    assert_eq!(run(STUDY, &folder), []);
    // An empty folder, or one with hidden files only, is nobody's.
    let empty = scratch("empty");
    fs::create_dir_all(&empty).unwrap();
    fs::write(empty.join(".gitignore"), "*").unwrap();
    run(STUDY, &empty);
}

/// A manifest is read from a folder that others may write to: it cannot name files outside.
#[test]
fn a_manifest_that_points_outside_is_no_manifest() {
    let folder = scratch("outside");
    let victim = folder.with_file_name("victim.txt");
    fs::write(&victim, "").unwrap();
    for name in ["../victim.txt", victim.to_str().unwrap(), ""] {
        _ = fs::remove_dir_all(&folder);
        run(STUDY, &folder);
        let mut forged = manifest(&folder);
        // The digest of nothing.
        let digest = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
        let entry = serde_json::json!({ "name": name, "bytes": 0, "sha256": digest });
        forged["files"].as_array_mut().unwrap().push(entry);
        fs::write(folder.join("manifest.json"), forged.to_string()).unwrap();
        assert!(matches!(run_with(STUDY, &folder, false), Err(StudyError::ForeignFolder { .. })), "{name}");
        assert!(victim.exists());
    }
}

#[test]
fn two_runs_do_not_write_into_one_folder() {
    let folder = scratch("locked");
    let study = study(STUDY);
    let second = std::sync::Mutex::new(None);
    let progress = |_: luenberger_study::Progress<'_>| {
        second.lock().unwrap().get_or_insert_with(|| run_with(STUDY, &folder, false));
    };
    let options = RunOptions { output: Some(folder.clone().into()), progress: &progress, ..RunOptions::default() };
    execute(&study, Step::Run, &options).unwrap();
    let error = second.into_inner().unwrap().unwrap().unwrap_err();
    assert!(matches!(error, StudyError::FolderInUse { .. }), "{error}");
    assert!(error.to_string().ends_with("or choose another folder with -o"));
    run(STUDY, &folder);
}

/// A run that is killed leaves its temporary folder, and while it moves files, a manifest with both contents.
#[test]
fn a_folder_that_a_killed_run_left_is_used_by_the_next() {
    let folder = scratch("killed");
    run(STUDY, &folder);
    let before = manifest(&folder);
    let kept = scratch("killed-after");
    run(&without_two(), &kept);
    let mut both = manifest(&kept);
    both["files"].as_array_mut().unwrap().extend(before["files"].as_array().unwrap().clone());
    fs::write(folder.join("manifest.json"), both.to_string()).unwrap();
    // Half of the files are moved, the others are still in the temporary folder.
    let partial = folder.join(".luenberger.partial");
    fs::create_dir_all(partial.join("figures")).unwrap();
    fs::copy(kept.join("report.html"), folder.join("report.html")).unwrap();
    fs::copy(kept.join("figures/states.svg"), partial.join("figures/states.svg")).unwrap();
    assert_eq!(run(&without_two(), &folder), []);
    assert_eq!(files(&folder), files(&kept));
    for name in files(&kept) {
        assert!(fs::read(folder.join(&name)).unwrap() == fs::read(kept.join(&name)).unwrap(), "{name}");
    }
}

#[test]
fn an_error_leaves_the_results_as_they_were() {
    let folder = scratch("error");
    run(STUDY, &folder);
    let before = fs::read(folder.join("study.json")).unwrap();
    // A plant that grows past the range of a double before the end: the observability of the run cannot be analysed.
    let text = "[plant]\nf = [\"x1^3\"]\nh = [\"x1\"]\n[simulation]\nx0 = [1]\nduration = 9\n";
    assert!(matches!(run_with(text, &folder, false), Err(StudyError::Sim(_))));
    assert!(!folder.join(".luenberger.partial").exists());
    assert_eq!(fs::read(folder.join("study.json")).unwrap(), before);
    let file = scratch("error-file");
    fs::create_dir_all(file.parent().unwrap()).unwrap();
    _ = fs::remove_file(&file);
    fs::write(&file, "").unwrap();
    assert!(matches!(run_with(STUDY, &file, true), Err(StudyError::NotAFolder { .. })));
    fs::remove_file(&file).unwrap();
}

#[test]
fn an_interruption_replaces_the_earlier_results_by_the_finished_ones() {
    let folder = scratch("interruption");
    run(STUDY, &folder);
    let study = study(&without_two());
    let cancel = AtomicBool::new(false);
    let progress = |progress: luenberger_study::Progress<'_>| {
        if progress.stage == "design" {
            cancel.store(true, Ordering::Relaxed);
        }
    };
    let output = Some(folder.clone());
    let options =
        RunOptions { output: output.map(Into::into), progress: &progress, cancel: &cancel, ..RunOptions::default() };
    assert!(matches!(execute(&study, Step::Run, &options), Err(StudyError::Interrupted)));
    let expected = [".luenberger.lock", "certificates/one.json", "manifest.json", "study.json"];
    assert_eq!(files(&folder).into_iter().collect::<Vec<_>>(), expected);
    run(STUDY, &folder);
}

/// A folder in memory has the files of one on the disk, with their bytes, for every step; the blocks of a sweep, which
/// are for other processes, are not among them. A second run leaves nothing of the first.
#[test]
fn a_folder_in_memory_has_the_same_files() {
    let text = format!("{STUDY}[sweep]\nparameter = \"poles\"\nvalues = [1, 2]\n");
    let study = study(&text);
    let memory = MemoryFolder::default();
    for step in [Step::Run, Step::Sweep, Step::Certify, Step::Observe] {
        let folder = scratch(&format!("memory-{}", step.name()));
        execute(&study, step, &RunOptions::default().output(folder.clone().into())).unwrap();
        execute(&study, step, &RunOptions::default().output(memory.clone().into())).unwrap();
        let is_result = |name: &String| !name.starts_with('.') && !name.starts_with("blocks/");
        let names: BTreeSet<String> = files(&folder).into_iter().filter(is_result).collect();
        let found = memory.take();
        assert_eq!(found.keys().cloned().collect::<BTreeSet<_>>(), names, "{}", step.name());
        for (name, bytes) in found {
            assert_eq!(bytes, fs::read(folder.join(&name)).unwrap(), "{}: {name}", step.name());
        }
        memory.clone().take();
    }
    let run = |step| execute(&study, step, &RunOptions::default().output(memory.clone().into())).unwrap();
    run(Step::Run);
    run(Step::Observe);
    let names: Vec<String> = memory.take().into_keys().collect();
    assert_eq!(names, ["manifest.json", "study.json"]);
}
