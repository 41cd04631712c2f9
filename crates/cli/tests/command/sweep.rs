//! Sweeps in blocks: shards that are killed and resumed, a full disk, status, results and the script for SLURM.

use crate::terminal::{Ran, folder, luenberger, run};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const STUDY: &str = "
[plant]
a = [[0, 1], [-1, -0.2]]
c = [[1, 0]]
[[observer]]
name = \"kalman\"
kind = \"kalman\"
w = 0.1
v = 0.01
[simulation]
x0 = [1, 1]
duration = 10
samples = 3
scale = [1, 1]
noise = { amplitude = [0.1], period = 0.05 }
[sweep]
parameter = \"noise\"
values = [1, 2]
ensemble = RUNS
";

fn written(name: &str, runs: usize) -> (PathBuf, String) {
    let folder = folder(name);
    let file = folder.join("study.toml");
    std::fs::write(&file, STUDY.replace("RUNS", &runs.to_string())).unwrap();
    (folder, file.to_str().unwrap().to_owned())
}

fn sweep(arguments: &[&str]) -> Ran {
    luenberger(&[&["sweep"], arguments].concat(), "")
}

/// The content of a folder, by names.
fn content(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut content = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = entry.file_name().unwrap().to_str().unwrap().to_owned();
        if entry.is_dir() {
            content.extend(self::content(&entry).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            content.insert(name, std::fs::read(&entry).unwrap());
        }
    }
    content
}

#[track_caller]
fn assert_same(found: &Path, expected: &Path) {
    let (found, expected) = (content(found), content(expected));
    assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
    for (name, bytes) in found {
        assert!(bytes == expected[&name], "{name} differs");
    }
}

fn blocks(out: &Path) -> usize {
    let files = std::fs::read_dir(out.join("blocks")).map(|files| {
        files.filter(|file| file.as_ref().unwrap().path().extension().is_some_and(|end| end == "npz")).count()
    });
    files.unwrap_or(0)
}

/// A shard is killed twice in the middle, by SIGKILL. The finished blocks stay, and the results are those of one
/// process.
#[cfg(unix)]
#[test]
fn a_killed_shard_is_resumed() {
    let (folder, file) = written("sweep-killed", 320);
    let (one, out) = (folder.join("one"), folder.join("killed"));
    let (one_name, name) = (one.to_str().unwrap(), out.to_str().unwrap());
    let size = ["--block-size", "10"];
    let ran = sweep(&[&[file.as_str(), "-o", one_name, "--threads", "2"], &size[..]].concat());
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let shard = ["--shard", "1/1", "--threads", "1"];
    for wanted in [3, 20] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_luenberger"))
            .args(["sweep", &file, "-o", name])
            .args(size)
            .args(shard)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let began = Instant::now();
        while blocks(&out) < wanted && began.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(2));
        }
        child.kill().unwrap();
        assert!(!child.wait().unwrap().success());
        assert!((wanted..64).contains(&blocks(&out)), "{} blocks", blocks(&out));
        let status = sweep(&["status", name, "--verify", "--json"]).json();
        assert_eq!((&status["done"], &status["running"]), (&blocks(&out).into(), &Value::Array(vec![])));
        assert_eq!(status["faults"], Value::Array(vec![]));
    }
    let present = blocks(&out);
    let reduced = sweep(&["reduce", name, "--json"]);
    assert_eq!((reduced.code, &reduced.json()["error"]["kind"]), (Some(2), &Value::from("file")));
    assert!(reduced.stderr.contains(" of 64 blocks are missing ("), "{}", reduced.stderr);
    let ran = sweep(&[&[file.as_str(), "-o", name, "--json"], &size[..], &shard[..]].concat()).json();
    assert_eq!((&ran["present"], &ran["computed"]), (&present.into(), &(64 - present).into()));
    let ran = sweep(&["reduce", name]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert_same(&out, &one);
    assert_eq!(ran.stdout.replace(name, one_name), sweep(&["reduce", one_name]).stdout);
}

/// Ctrl-C ends a shard with the exit code 130, and a sweep too: both are resumed.
#[cfg(unix)]
#[test]
fn an_interrupted_sweep_is_resumed() {
    let (folder, file) = written("sweep-interrupted", 5000);
    let out = folder.join("out");
    let name = out.to_str().unwrap();
    for extra in [&["--shard", "1/2"][..], &[][..]] {
        let before = blocks(&out);
        let child = Command::new(env!("CARGO_BIN_EXE_luenberger"))
            .args(["sweep", &file, "-o", name, "--block-size", "10", "--json"])
            .args(extra)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let began = Instant::now();
        while blocks(&out) < before + 2 && began.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(5));
        }
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130));
        assert!(blocks(&out) >= before + 2);
    }
    let status = sweep(&["status", name]);
    assert!(status.stdout.contains("missing: ") && status.stdout.contains("\nrate: "), "{}", status.stdout);
    assert!(status.stdout.contains("\nremaining: ") && !status.stdout.contains("computed"), "{}", status.stdout);
}

#[test]
fn a_shard_outside_of_its_number_is_refused() {
    let (folder, file) = written("sweep-shards", 10);
    let out = folder.join("out");
    let name = out.to_str().unwrap();
    for (shard, said) in [
        ("0/3", "there is no shard 0 of 3: they are numbered from 1 to 3"),
        ("4/3", "there is no shard 4 of 3: they are numbered from 1 to 3"),
        ("1/0", "the number of shards is 0, expected at least 1"),
        ("a/b", "expected I/N, such as 1/4 for the first of four shards"),
        ("-1/2", "expected I/N, such as 1/4 for the first of four shards"),
    ] {
        let ran = sweep(&[&file, "-o", name, "--shard", shard]);
        assert!(ran.code == Some(2) && ran.stderr.contains(said), "{ran:?}");
    }
    assert!(!out.exists());
    // More shards than blocks: this one has none.
    let ran = sweep(&[&file, "-o", name, "--shard", "7/9"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(ran.stdout.starts_with("shard 7/9: 0 blocks computed (0 runs), 0 present\nstudy.toml: 0 of 2 blocks in "));
    let ran = sweep(&[&file, "-o", name, "--shard", "1/1"]);
    assert!(ran.stdout.ends_with(&format!("\nnext: luenberger sweep reduce {name}\n")), "{}", ran.stdout);
    for arguments in [&["status", "no-such-folder"][..], &["reduce", "no-such-folder"]] {
        let ran = sweep(arguments);
        assert!(ran.code == Some(2) && ran.stderr.contains("has no sweep: there is no plan.json"), "{ran:?}");
    }
    let ran = sweep(&[]);
    assert!(ran.code == Some(2) && ran.stderr.contains("<STUDY>"), "{ran:?}");
    let ran = sweep(&[&file, "-o", name, "--block-size", "0", "--restart"]);
    assert!(ran.code == Some(2) && ran.stderr.contains("a block of 0 runs is not possible"), "{ran:?}");
}

#[test]
fn another_study_is_refused_and_restarted_on_demand() {
    let (folder, file) = written("sweep-other", 10);
    let name = folder.join("out").to_str().unwrap().to_owned();
    assert_eq!(sweep(&[&file, "-o", &name]).code, Some(0));
    std::fs::write(&file, STUDY.replace("RUNS", "12")).unwrap();
    let ran = sweep(&[&file, "-o", &name, "--json"]);
    assert_eq!((ran.code, &ran.json()["error"]["kind"]), (Some(2), &Value::from("file")));
    assert!(ran.stderr.contains("study.toml has changed since; choose another folder with -o"), "{}", ran.stderr);
    assert_eq!(sweep(&[&file, "-o", &name, "--restart"]).code, Some(0));
}

/// A limit of the size of files stands for a disk that is full: the command names the block and ends with exit code 1,
/// and what was finished before is used later.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_loses_nothing() {
    let (folder, file) = written("sweep-full", 64);
    let (one, out) = (folder.join("one"), folder.join("full"));
    let (one_name, name) = (one.to_str().unwrap(), out.to_str().unwrap());
    assert_eq!(sweep(&[&file, "-o", one_name]).code, Some(0));
    assert_eq!(sweep(&[&file, "-o", name, "--shard", "1/2"]).code, Some(0));
    // 8 blocks of 512 bytes; the signal that would end the command is ignored.
    let shell = "trap '' XFSZ; ulimit -f 8; exec \"$@\"";
    let mut command = Command::new("sh");
    command.args(["-c", shell, "sh", env!("CARGO_BIN_EXE_luenberger"), "sweep", &file, "-o", name, "--shard", "2/2"]);
    let ran = run(command.arg("--json"), b"");
    assert_eq!((ran.code, &ran.json()["error"]["kind"]), (Some(1), &Value::from("storage")), "{ran:?}");
    assert!(ran.stderr.contains("blocks/0000000") && ran.stderr.contains("File too large"), "{}", ran.stderr);
    let said = "; finished blocks are kept, and the same command resumes";
    assert!(ran.stderr.trim_end().ends_with(said), "{}", ran.stderr);
    assert!(content(&out).keys().all(|name| !name.ends_with(".partial")), "{:?}", content(&out).keys());
    assert_eq!(blocks(&out), 2);
    assert_eq!(sweep(&[&file, "-o", name, "--shard", "2/2"]).code, Some(0));
    assert_eq!(sweep(&["reduce", name]).code, Some(0));
    assert_same(&out, &one);
}

#[test]
fn a_damaged_block_is_named() {
    let (folder, file) = written("sweep-damaged", 64);
    let out = folder.join("out");
    let name = out.to_str().unwrap();
    assert_eq!(sweep(&[&file, "-o", name]).code, Some(0));
    let before = content(&out);
    let block = out.join("blocks/00000001.npz");
    let mut bytes = std::fs::read(&block).unwrap();
    bytes[1000] ^= 1;
    std::fs::write(&block, &bytes).unwrap();
    let fault = format!("{} is damaged (its checksum does not match)", block.display());
    let status = sweep(&["status", name, "--verify"]);
    assert_eq!(status.code, Some(1));
    assert!(status.stdout.contains(&format!("failed: {fault}\n")), "{}", status.stdout);
    let ran = sweep(&["reduce", name]);
    assert!(ran.code == Some(2) && ran.stderr.contains(&fault), "{ran:?}");
    let ran = sweep(&[&file, "-o", name]);
    assert_eq!((ran.code, ran.stderr_without_estimate()), (Some(0), format!("note: {fault}: computed again")));
    assert!(content(&out) == before);
}

#[test]
fn the_script_is_one_for_slurm() {
    let (folder, _) = written("sweep-script", 320);
    let file = folder.join("it's a study.toml");
    std::fs::rename(folder.join("study.toml"), &file).unwrap();
    let file = file.to_str().unwrap();
    let script = sweep(&["script", file, "--slurm", "-o", "my results", "--shards", "4", "--partition", "short"]);
    assert_eq!(script.code, Some(0), "{script:?}");
    for line in [
        "#SBATCH --array=1-4",
        "#SBATCH --partition=short",
        "#SBATCH --output='my results/blocks/slurm-shard-%a.txt'",
        "sbatch --dependency=\"afterok:${array%%;*}\" <<'END'",
        "exec luenberger sweep reduce 'my results'",
    ] {
        assert!(script.stdout.lines().any(|found| found == line), "{line} in\n{}", script.stdout);
    }
    let path = folder.join("submit.sh");
    std::fs::write(&path, &script.stdout).unwrap();
    let checked = Command::new("sh").arg("-n").arg(&path).output().unwrap();
    assert!(checked.status.success(), "{checked:?}");
    assert_eq!(sweep(&["script", file, "--slurm", "--json"]).json()["shards"], 20);
    let ran = sweep(&["script", file]);
    assert!(ran.code == Some(2) && ran.stderr.contains("--slurm"), "{ran:?}");
    let ran = sweep(&["script", file, "--slurm", "--partition", "a b"]);
    assert!(ran.code == Some(2) && ran.stderr.contains("letters, digits and any of _-.,:+ are expected"), "{ran:?}");
}

#[test]
fn words_of_the_script_are_those_of_the_shell() {
    let (_, file) = written("sweep-words", 32);
    for word in ["a/b-1.toml", "two words", "it's", "$HOME", "a;b"] {
        let script = sweep(&["script", &file, "--slurm", "-o", word]).stdout;
        let reduce = script.lines().find_map(|line| line.strip_prefix("exec luenberger sweep reduce ")).unwrap();
        let echo = format!("printf %s {reduce}");
        let output = Command::new("sh").args(["-c", &echo]).output().unwrap();
        assert_eq!(String::from_utf8(output.stdout).unwrap(), word);
    }
    // An empty one is no folder.
    let ran = sweep(&["script", &file, "--slurm", "-o", ""]);
    assert!(ran.code == Some(2) && ran.stderr.contains("a value is required for '--output <FOLDER>'"), "{ran:?}");
}

/// `script` of util-linux is the terminal: what is to be expected, and the progress of the runs.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_has_the_estimate_and_the_progress() {
    use luenberger_study::execute::bytes;
    use luenberger_study::{Step, Study, estimate};
    let (folder, file) = written("sweep-terminal", 320);
    for threads in [1, 2] {
        let command = format!(
            "stty cols 200; '{}' sweep '{file}' -o '{}' --threads {threads}",
            env!("CARGO_BIN_EXE_luenberger"),
            folder.join(threads.to_string()).display()
        );
        let terminal = Command::new("script").args(["-qec", &command, "/dev/null"]).stdin(Stdio::null()).output();
        let output = terminal.unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success(), "{text}");
        let cost = estimate(&Study::from_path(Path::new(&file)).unwrap(), Step::Sweep, threads);
        let less = if threads > 1 { format!(", less on {threads} threads") } else { String::new() };
        // The seconds are measured again by each process.
        let expected = format!(
            " on one thread{less}, {} of memory ({} runs; most of the time for the simulations)",
            bytes(cost.memory.bytes),
            cost.runs
        );
        let estimate =
            text.lines().find_map(|line| line.trim_end().strip_prefix("estimate: ")?.strip_suffix(&expected));
        assert!(cost.runs > 640 && estimate.is_some_and(|seconds| seconds.contains("second")), "{expected}\n{text}");
        // The rate and the time left, as the template has them and the default of the bar has not.
        let shows_rate = |part: &str| part.contains("\u{2591}") && part.contains("/s, ") && part.contains("s left");
        assert!(text.split('\r').any(shows_rate), "{text}");
    }
}

/// Stands for SLURM: the scripts of `sbatch` run one after the other, the array task by task.
#[cfg(unix)]
#[test]
fn the_script_computes_the_sweep() {
    use std::os::unix::fs::PermissionsExt;
    let (folder, file) = written("sweep-submitted", 40);
    assert_eq!(sweep(&[&file, "-o", folder.join("one").to_str().unwrap()]).code, Some(0));
    let sbatch = folder.join("bin/sbatch");
    std::fs::create_dir_all(folder.join("bin")).unwrap();
    let text = "#!/bin/sh\nset -e\ncat > job.sh\necho \"$@\" >> calls\nif grep -q 'array=1-3' job.sh; then\n\
                for i in 1 2 3; do SLURM_ARRAY_TASK_ID=$i SLURM_CPUS_PER_TASK=1 sh job.sh >&2; done\n\
                else sh job.sh >&2; fi\necho 17\n";
    std::fs::write(&sbatch, text).unwrap();
    std::fs::set_permissions(&sbatch, std::fs::Permissions::from_mode(0o755)).unwrap();
    let script = sweep(&["script", &file, "--slurm", "-o", "out", "--shards", "3"]).stdout;
    let own = Path::new(env!("CARGO_BIN_EXE_luenberger")).parent().unwrap().to_owned();
    let known = std::env::var_os("PATH").unwrap();
    let path = [folder.join("bin"), own].into_iter().chain(std::env::split_paths(&known));
    let path = std::env::join_paths(path).unwrap();
    let ran = run(Command::new("sh").args(["-c", &script]).current_dir(&folder).env("PATH", path), b"");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let calls = std::fs::read_to_string(folder.join("calls")).unwrap();
    assert_eq!(calls, "--parsable\n--dependency=afterok:17\n");
    assert_same(&folder.join("out"), &folder.join("one"));
}
