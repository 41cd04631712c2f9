//! Sweeps in blocks on disk: the same bytes from any processes, threads and interruptions; folders of other studies;
//! damaged blocks; two writers.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use luenberger_study::execute::{
    BlockSettings, Computed, RunsAsCsv, Shard, SharedSweep, SweepOptions, reduce_sweep, sweep_status,
};
use luenberger_study::{Results, RunOptions, Step, Study, StudyError, SweepError, execute};

use crate::studies::{self, study_in};

/// Two rows of 50 runs, with noise and an input that is a file; with x(0) far off the plant escapes in finite time.
const STUDY: &str = r#"
[plant]
f = ["0.1*level^3 - level + u1"]
h = ["level"]
states = ["level"]
[input]
table = "input.csv"
[simulation]
x0 = [0.5]
duration = 2
samples = 3
scale = [1]
noise = { amplitude = [0.2], period = 0.1 }
[[observer]]
name = "copy"
kind = "lpv"
region = { states = [[-1, 1]] }
decay_rate = 0.2
initial = [0.2]
[sweep]
parameter = "initial"
values = [1, 4]
ensemble = 50
"#;

fn scratch(name: &str) -> PathBuf {
    let folder = studies::scratch(&format!("blocks/{name}"));
    std::fs::write(folder.join("input.csv"), "t,u1\n0,0\n1,0.2\n2,0\n").unwrap();
    folder
}

fn study(folder: &Path) -> Study {
    study_in(folder, STUDY)
}

const BLOCKS_OF_8: BlockSettings = BlockSettings { size: Some(8), restart: false, force: false };
const RESTART: BlockSettings = BlockSettings { size: None, restart: true, force: false };

fn shared(folder: &Path, out: &str) -> SharedSweep {
    SharedSweep::open(study(folder), &folder.join(out), BLOCKS_OF_8).unwrap_or_else(|error| panic!("{error}"))
}

fn compute(sweep: &SharedSweep, shard: &str, threads: usize) -> Computed {
    let shard: Shard = shard.parse().unwrap();
    let options = RunOptions { threads: Some(threads), ..RunOptions::default() };
    sweep.compute(shard.blocks(sweep.plan()), &options).unwrap_or_else(|error| panic!("{error}"))
}

fn reduced(folder: &Path) -> Results {
    let (results, stopped) = reduce_sweep(folder, &RunOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert!(stopped.is_none());
    results
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

/// The results folder of one process, which the others have to reproduce.
fn reference(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let options = RunOptions {
        output: Some(folder.join("one").into()),
        threads: Some(1),
        sweep: SweepOptions { block_size: Some(8), ..SweepOptions::default() },
        ..RunOptions::default()
    };
    execute(&study(folder), Step::Sweep, &options).unwrap();
    content(&folder.join("one"))
}

#[track_caller]
fn assert_same(found: &BTreeMap<String, Vec<u8>>, expected: &BTreeMap<String, Vec<u8>>) {
    assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
    for (name, bytes) in found {
        assert!(*bytes == expected[name], "{name} differs");
    }
}

#[test]
fn shards_threads_and_interruptions_do_not_change_a_byte() {
    let folder = scratch("same");
    let one = reference(&folder);
    // 7 blocks of each row, the last with 2 runs.
    assert_eq!(one.keys().filter(|name| name.starts_with("blocks/0")).count(), 14);
    assert!(one.contains_key("sweep.csv") && one.contains_key("figures/sweep.svg"), "{:?}", one.keys());
    for threads in [1, 2] {
        let out = format!("shards-{threads}");
        for number in [3, 1, 2] {
            let computed = compute(&shared(&folder, &out), &format!("{number}/3"), threads);
            assert_eq!((computed.computed, computed.present), (if number == 3 { 4 } else { 5 }, 0));
        }
        reduced(&folder.join(&out));
        assert_same(&content(&folder.join(&out)), &one);
    }
    // Interrupted after ten runs, and once more.
    let sweep = shared(&folder, "interrupted");
    for stop in [10, 30] {
        let (cancel, count) = (AtomicBool::new(false), AtomicUsize::new(0));
        let progress = |_: luenberger_study::Progress<'_>| {
            cancel.fetch_or(count.fetch_add(1, Ordering::Relaxed) + 1 >= stop, Ordering::Relaxed);
        };
        let options = RunOptions { cancel: &cancel, progress: &progress, threads: Some(1), ..RunOptions::default() };
        let error = sweep.compute(0..14, &options).unwrap_err();
        assert!(matches!(error, StudyError::Interrupted), "{error}");
    }
    let computed = compute(&sweep, "1/1", 2);
    assert!(computed.present > 0 && computed.computed > 0 && computed.present + computed.computed == 14);
    reduced(&folder.join("interrupted"));
    assert_same(&content(&folder.join("interrupted")), &one);
    // Without a folder the blocks are in memory, and nothing else differs. Nor does the size of the blocks matter, but
    // for the last bits of mean and deviation.
    let results = execute(&study(&folder), Step::Sweep, &RunOptions::default()).unwrap();
    let written: serde_json::Value = serde_json::from_slice(&one["study.json"]).unwrap();
    let sweep = serde_json::to_value(results.sweep.unwrap()).unwrap();
    for (row, other) in sweep["rows"].as_array().unwrap().iter().zip(written["sweep"]["rows"].as_array().unwrap()) {
        assert_eq!((&row["states"], &row["percentiles"]), (&other["states"], &other["percentiles"]));
        for (x, y) in row["statistics"].as_array().unwrap().iter().zip(other["statistics"].as_array().unwrap()) {
            assert_eq!((&x["count"], &x["min"], &x["max"]), (&y["count"], &y["min"], &y["max"]));
            // Of a settling time that no run has, there is no mean.
            let (x, y) = (x["mean"].as_f64(), y["mean"].as_f64());
            assert!(x == y || (x.unwrap() - y.unwrap()).abs() <= 1e-14 * x.unwrap().abs());
        }
    }
}

/// Runs that end early, and runs that leave the region of the design, are counted over all blocks.
#[test]
fn runs_that_end_early_are_in_the_results() {
    let folder = scratch("early");
    let text = STUDY.replace("values = [1, 4]", "values = [3, 40]").replace("0.1*level^3 - level", "level^3 - level");
    let sweep = SharedSweep::open(study_in(&folder, &text), &folder.join("out"), BLOCKS_OF_8).unwrap();
    compute(&sweep, "1/1", 2);
    let results = reduced(&folder.join("out"));
    let rows = &results.sweep.as_ref().unwrap().rows;
    assert_eq!((rows[0].finished, rows.len()), (50, 2));
    assert!(rows[1].finished < 50, "{}", rows[1].finished);
    let why = rows[1].failure.as_ref().unwrap();
    assert!(why.starts_with("stopped at t = "), "{why}");
    let csv = std::fs::read_to_string(folder.join("out/sweep.csv")).unwrap();
    assert_eq!(csv.lines().count(), 101);
    assert_eq!(csv.lines().filter(|line| line.contains("stopped at")).count(), 50 - rows[1].finished);
    let warned: Vec<&String> = results.warnings.iter().filter(|warning| warning.contains("of the sweep")).collect();
    assert_eq!(warned.len(), 1, "{:?}", results.warnings);
    let all = rows[0].finished + rows[1].finished;
    assert!(warned[0].contains(&format!(" of {all} runs of the sweep, first with initial = ")), "{}", warned[0]);
}

#[test]
fn statistics_are_those_of_the_lines() {
    let folder = scratch("statistics");
    compute(&shared(&folder, "out"), "1/1", 1);
    let row = &reduced(&folder.join("out")).sweep.unwrap().rows[0];
    let csv = std::fs::read_to_string(folder.join("out/sweep.csv")).unwrap();
    let head: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    assert_eq!(row.statistics.len() + 4, head.len());
    for (k, statistics) in row.statistics.iter().enumerate() {
        assert_eq!(statistics.score, head[k + 3]);
        let lines = csv.lines().skip(1).take(50).map(|line| line.split(',').nth(k + 3).unwrap());
        let values: Vec<f64> = lines.filter(|cell| !cell.is_empty()).map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(statistics.count, values.len() as u64);
        if values.is_empty() {
            assert_eq!((statistics.mean, statistics.min), (None, None));
            continue;
        }
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        assert!((statistics.mean.unwrap() - mean).abs() <= 1e-13 * mean.abs(), "{statistics:?}");
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        assert_eq!(statistics.min, Some(least));
        if let Some(deviation) = statistics.deviation {
            let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
            let expected = (squares / (values.len() - 1) as f64).sqrt();
            assert!((deviation - expected).abs() <= 1e-10 * expected + 1e-15, "{statistics:?}");
        }
    }
}

/// Percentiles are exact however little memory there is for them.
#[test]
fn percentiles_do_not_depend_on_the_memory() {
    let folder = scratch("memory");
    compute(&shared(&folder, "out"), "1/1", 1);
    let one = {
        reduced(&folder.join("out"));
        content(&folder.join("out"))
    };
    for memory in [0, 4_000_000] {
        let sweep = SweepOptions { percentile_memory: Some(memory), ..SweepOptions::default() };
        reduce_sweep(&folder.join("out"), &RunOptions { sweep, ..RunOptions::default() }).unwrap();
        assert_same(&content(&folder.join("out")), &one);
    }
}

#[track_caller]
fn other(folder: &Path, text: &str, settings: BlockSettings) -> String {
    match SharedSweep::open(study_in(folder, text), &folder.join("out"), settings) {
        Err(StudyError::Sweep(error)) => error.to_string(),
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("opened"),
    }
}

#[test]
fn the_folder_of_another_study_is_refused() {
    let folder = scratch("other");
    compute(&shared(&folder, "out"), "1/1", 1);
    let any = BlockSettings::default();
    // The block size of the folder is the default.
    assert_eq!(SharedSweep::open(study(&folder), &folder.join("out"), any).unwrap().plan().block_size, 8);
    let said = other(&folder, STUDY, BlockSettings { size: Some(9), ..any });
    assert!(
        said.contains("has blocks of another sweep: their block size is 8, not 9; choose another folder"),
        "{said}"
    );
    let said = other(&folder, &STUDY.replace("ensemble = 50", "ensemble = 51"), any);
    assert!(said.contains(": study.toml has changed since; choose another folder with -o, or delete"), "{said}");
    std::fs::write(folder.join("input.csv"), "t,u1\n0,0\n1,0.3\n2,0\n").unwrap();
    let said = other(&folder, STUDY, any);
    assert!(said.contains(": input.csv, which the study reads, has changed since;"), "{said}");
    // The results are those of the copy.
    let results = reduced(&folder.join("out"));
    assert_eq!(results.sweep.unwrap().rows[0].finished, 50);
    let plan = folder.join("out/blocks/plan.json");
    let text = std::fs::read_to_string(&plan).unwrap();
    let version = format!("\"luenberger\": \"{}\"", env!("CARGO_PKG_VERSION"));
    std::fs::write(&plan, text.replace(&version, "\"luenberger\": \"0.0.1\"")).unwrap();
    let said = other(&folder, STUDY, any);
    assert!(said.contains(": they are of luenberger 0.0.1, and this is "), "{said}");
    let refused = reduce_sweep(&folder.join("out"), &RunOptions::default()).unwrap_err().to_string();
    assert!(refused.contains("luenberger 0.0.1"), "{refused}");
    std::fs::write(&plan, &text[..20]).unwrap();
    let said = other(&folder, STUDY, any);
    assert!(said.contains("plan.json is damaged: restore it, or begin again with --restart"), "{said}");
    let sweep = SharedSweep::open(study(&folder), &folder.join("out"), RESTART).unwrap();
    assert_eq!((sweep.plan().block_size, sweep_status(&folder.join("out"), true).unwrap().done), (32, 0));
    let said = sweep_status(&folder, false).unwrap_err().to_string();
    assert!(said.ends_with("has no sweep: there is no plan.json"), "{said}");
    // Blocks and a copy of the study are all that a restart deletes.
    std::fs::write(folder.join("out/blocks/notes.txt"), "mine").unwrap();
    SharedSweep::open(study(&folder), &folder.join("out"), RESTART).unwrap();
    assert!(folder.join("out/blocks/notes.txt").exists());
}

/// The copy of a study beside its blocks is the one that they are of: a change in it, or in a file that it reads, is
/// seen.
#[test]
fn a_changed_copy_of_the_study_is_refused() {
    let folder = scratch("copy");
    compute(&shared(&folder, "out"), "1/1", 1);
    let copies: Vec<PathBuf> =
        std::fs::read_dir(folder.join("out/blocks/study")).unwrap().map(|entry| entry.unwrap().path()).collect();
    let of =
        |part: &str| copies.iter().find(|path| std::fs::read_to_string(path).is_ok_and(|text| text.contains(part)));
    for (copy, from, to) in [(of("decay_rate = 0.2"), "rate = 0.2", "rate = 0.3"), (of("t,u1"), "1,0.2", "1,0.3")] {
        let copy = copy.unwrap_or_else(|| panic!("{from} in {copies:?}"));
        let text = std::fs::read_to_string(copy).unwrap();
        std::fs::write(copy, text.replacen(from, to, 1)).unwrap();
        let refused = reduce_sweep(&folder.join("out"), &RunOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("the copy of the study in ") && refused.contains("was changed"), "{refused}");
        std::fs::write(copy, text).unwrap();
    }
    assert_eq!(reduced(&folder.join("out")).sweep.unwrap().rows[0].finished, 50);
}

/// The rate is that of the runs after the first block, over the times between the first block and the last; what is
/// left takes its runs at this rate.
#[test]
fn the_rate_of_a_sweep_is_that_of_its_blocks() {
    let folder = scratch("rate");
    let sweep = shared(&folder, "out");
    let file = |block: u64| folder.join(format!("out/blocks/{block:08}.npz"));
    sweep.compute([0], &RunOptions::default()).unwrap();
    let status = sweep_status(&folder.join("out"), false).unwrap();
    assert_eq!((status.done, status.rate, status.remaining), (1, None, None));
    sweep.compute([1, 2], &RunOptions::default()).unwrap();
    let start = std::time::SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(1_700_000_000);
    for (block, seconds) in [(0, 0), (1, 3), (2, 8)] {
        let opened = std::fs::File::options().write(true).open(file(block)).unwrap();
        opened.set_modified(start + std::time::Duration::from_secs(seconds)).unwrap();
    }
    let status = sweep_status(&folder.join("out"), false).unwrap();
    // 16 runs in 8 seconds; 76 of 100 runs are left.
    assert_eq!((status.done, status.rate, status.remaining), (3, Some(2.0), Some(38.0)));
    assert_eq!((status.runs, status.done_runs), (100, 24));
}

#[test]
fn damaged_blocks_are_computed_again() {
    let folder = scratch("damaged");
    let one = reference(&folder);
    let sweep = shared(&folder, "out");
    compute(&sweep, "1/1", 2);
    let file = |block: u64| folder.join(format!("out/blocks/{block:08}.npz"));
    let bytes = std::fs::read(file(3)).unwrap();
    std::fs::write(file(3), &bytes[..bytes.len() / 2]).unwrap();
    let mut flipped = std::fs::read(file(5)).unwrap();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 4;
    std::fs::write(file(5), flipped).unwrap();
    std::fs::copy(file(9), file(8)).unwrap();
    std::fs::remove_file(file(2)).unwrap();
    // Of a sweep with another seed.
    let alien = SharedSweep::open(
        study_in(&folder, &STUDY.replace("ensemble = 50", "ensemble = 50\nseed = 1")),
        &folder.join("alien"),
        BLOCKS_OF_8,
    );
    alien.unwrap().compute([11], &RunOptions::default()).unwrap();
    std::fs::copy(folder.join("alien/blocks/00000011.npz"), file(11)).unwrap();

    let status = sweep_status(&folder.join("out"), true).unwrap();
    assert_eq!((status.missing, status.faults.len(), status.done), (vec![2, 3, 5, 8, 11], 4, 9));
    let refused = reduce_sweep(&folder.join("out"), &RunOptions::default()).unwrap_err();
    assert!(refused.to_string().contains("1 of 14 blocks is missing (2): complete the sweep with: "), "{refused}");
    sweep.compute([2], &RunOptions::default()).unwrap();
    let refused = reduce_sweep(&folder.join("out"), &RunOptions::default()).unwrap_err().to_string();
    assert!(refused.contains("00000003.npz is cut short, or is no block of a sweep: compute it again"), "{refused}");
    assert!(!folder.join("out/study.json").exists());
    let computed = compute(&sweep, "1/1", 1);
    let faults: Vec<String> = computed.faults.iter().map(|(_, fault)| fault.to_string()).collect();
    let expected = [
        "is cut short, or is no block of a sweep",
        "is damaged (its checksum does not match)",
        "is a copy of block 9",
        "is a block of another study, or of another version",
    ];
    assert_eq!((faults, computed.computed), (expected.map(str::to_owned).to_vec(), 4));
    reduced(&folder.join("out"));
    assert_same(&content(&folder.join("out")), &one);
}

#[test]
fn two_writers_compute_no_block_twice() {
    let folder = scratch("writers");
    let one = reference(&folder);
    // A lock of a process that was killed, with what it had written.
    let blocks = folder.join("out/blocks");
    let (first, second) = (shared(&folder, "out"), shared(&folder, "out"));
    std::fs::write(blocks.join(".00000003.lock"), "").unwrap();
    std::fs::write(blocks.join(".00000003.partial"), "half").unwrap();
    let (first, second) = std::thread::scope(|scope| {
        let other = scope.spawn(|| compute(&second, "1/1", 1));
        let first = compute(&first, "1/1", 1);
        (first, other.join().unwrap())
    });
    assert_eq!((first.computed + second.computed, first.runs + second.runs), (14, 100), "{first:?} {second:?}");
    assert!(first.faults.is_empty() && second.faults.is_empty());
    reduced(&folder.join("out"));
    assert_same(&content(&folder.join("out")), &one);
}

/// A block that another process holds is waited for, and is shown as being computed; nobody may delete it meanwhile.
#[test]
fn a_block_that_is_held_is_waited_for() {
    let folder = scratch("held");
    let sweep = shared(&folder, "out");
    let path = folder.join("out/blocks/.00000000.lock");
    let lock = std::fs::File::create(path).unwrap();
    lock.lock().unwrap();
    assert_eq!(sweep_status(&folder.join("out"), false).unwrap().running, [0]);
    let restart = SharedSweep::open(study(&folder), &folder.join("out"), RESTART);
    assert!(matches!(restart, Err(StudyError::Sweep(SweepError::InUse { .. }))));
    std::thread::scope(|scope| {
        let computed = scope.spawn(|| compute(&sweep, "1/1", 1));
        while sweep_status(&folder.join("out"), false).unwrap().done < 13 {
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        assert!(!computed.is_finished());
        // As when its process ends.
        drop(lock);
        assert_eq!(computed.join().unwrap().computed, 14);
    });
}

#[test]
fn runs_are_written_block_by_block_too() {
    let folder = scratch("csv");
    compute(&shared(&folder, "out"), "1/1", 1);
    reduced(&folder.join("out"));
    let whole = std::fs::read_to_string(folder.join("out/sweep.csv")).unwrap();
    let sweep = SweepOptions { csv: RunsAsCsv::Blocks, ..SweepOptions::default() };
    let (results, _) = reduce_sweep(&folder.join("out"), &RunOptions { sweep, ..RunOptions::default() }).unwrap();
    assert!(!folder.join("out/sweep.csv").exists() && !results.files.contains(&"sweep.csv".to_owned()));
    let head = whole.lines().next().unwrap();
    let mut lines = format!("{head}\n");
    for block in 0..14 {
        let text = std::fs::read_to_string(folder.join(format!("out/blocks/{block:08}.csv"))).unwrap();
        lines += text.strip_prefix(&format!("{head}\n")).unwrap();
    }
    assert_eq!(lines, whole);
}

/// A binding for another language computes from threads of its own.
#[test]
fn a_shared_sweep_is_one_for_threads() {
    fn is_shared<T: Send + Sync + 'static>() {}
    is_shared::<SharedSweep>();
    let folder = scratch("threads");
    let sweep = shared(&folder, "out");
    std::thread::scope(|scope| {
        let each = |number: u64| {
            let sweep = &sweep;
            scope.spawn(move || sweep.compute([number], &RunOptions::default()).unwrap().computed)
        };
        let computed: Vec<_> = (0..14).map(each).collect();
        assert_eq!(computed.into_iter().map(|thread| thread.join().unwrap()).sum::<u64>(), 14);
    });
}

#[test]
fn sizes_that_are_not_possible_are_refused() {
    let folder = scratch("sizes");
    let size = |size| BlockSettings { size: Some(size), ..BlockSettings::default() };
    let said = other(&folder, STUDY, size(0));
    assert_eq!(said, "a block of 0 runs is not possible: expected 1 to 1000000");
    let said = other(&folder, &STUDY.replace("ensemble = 50", "ensemble = 2000000"), size(1));
    assert_eq!(said, "the sweep has 4000000 blocks (limit 1000000): --block-size 4 or larger");
    let error = shared(&folder, "out").compute([14], &RunOptions::default()).unwrap_err().to_string();
    assert_eq!(error, "there is no block 14: the sweep has 14, numbered from 0");
    // A folder with other files.
    std::fs::create_dir_all(folder.join("foreign")).unwrap();
    std::fs::write(folder.join("foreign/letter.txt"), "").unwrap();
    let refused = SharedSweep::open(study(&folder), &folder.join("foreign"), BLOCKS_OF_8).err().unwrap();
    assert!(matches!(refused, StudyError::ForeignFolder { .. }), "{refused}");
}

/// One row of so many values, runs of each and runs of a block.
fn divided(folder: &Path, values: usize, ensemble: u64, size: u64) -> SharedSweep {
    let listed = (1..=values).map(|k| (0.1 * k as f64).to_string()).collect::<Vec<_>>().join(", ");
    let text = STUDY.replace("values = [1, 4]", &format!("values = [{listed}]"));
    let text = text.replace("ensemble = 50", &format!("ensemble = {ensemble}"));
    let settings = BlockSettings { size: Some(size), restart: true, force: false };
    SharedSweep::open(study_in(folder, &text), &folder.join("out"), settings).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn the_blocks_have_each_trajectory_once() {
    let folder = scratch("once");
    for (values, ensemble, size) in [(1, 1, 1), (3, 10, 4), (2, 12, 4), (5, 1, 1), (2, 7, 7)] {
        let sweep = divided(&folder, values, ensemble, size);
        assert_eq!(compute(&sweep, "1/1", 1).runs, values as u64 * ensemble);
        reduced(&folder.join("out"));
        let csv = std::fs::read_to_string(folder.join("out/sweep.csv")).unwrap();
        let runs: Vec<[String; 2]> = csv
            .lines()
            .skip(1)
            .map(|line| [1, 2].map(|column| line.split(',').nth(column).unwrap().to_owned()))
            .collect();
        let of = |value: usize| (0..ensemble).map(move |run| [(0.1 * value as f64).to_string(), run.to_string()]);
        assert_eq!(runs, (1..=values).flat_map(of).collect::<Vec<_>>());
    }
}

#[test]
fn the_shards_have_each_block_once() {
    let folder = scratch("shards");
    let sweep = divided(&folder, 3, 10, 4);
    for of in 1..=12 {
        let shard = |number: u64| format!("{number}/{of}").parse::<Shard>().unwrap().blocks(sweep.plan());
        let mut all: Vec<u64> = (1..=of).flat_map(shard).collect();
        all.sort_unstable();
        assert_eq!(all, (0..9).collect::<Vec<_>>());
    }
}

#[test]
fn a_shard_is_one_of_its_number() {
    let wrong = |word: &str| word.parse::<Shard>().unwrap_err();
    assert_eq!(wrong("0/3"), "there is no shard 0 of 3: they are numbered from 1 to 3");
    assert_eq!(wrong("4/3"), "there is no shard 4 of 3: they are numbered from 1 to 3");
    assert_eq!(wrong("1/0"), "the number of shards is 0, expected at least 1");
    for word in ["a/b", "1", "1/", "/1", "-1/2", "+1/2", "1/2/3", "1.0/2", "99999999999/99999999999"] {
        assert_eq!(wrong(word), "expected I/N, such as 1/4 for the first of four shards", "{word}");
    }
    let shard: Shard = "2/3".parse().unwrap();
    assert_eq!((shard.number(), shard.of(), shard.to_string()), (2, 3, "2/3".to_owned()));
}

/// A file of an archive.
fn member(archive: &[u8], name: &str) -> Vec<u8> {
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(archive)).unwrap();
    let mut content = Vec::new();
    std::io::Read::read_to_end(&mut archive.by_name(name).unwrap(), &mut content).unwrap();
    content
}

/// The lines of the runs are the columns of the blocks, bit by bit; a run that ended early has no scores, and one that
/// does not settle no settling time.
#[test]
fn the_lines_are_the_columns_of_the_blocks() {
    let folder = scratch("columns");
    let text = STUDY.replace("values = [1, 4]", "values = [3, 40]").replace("0.1*level^3 - level", "level^3 - level");
    let sweep = SharedSweep::open(study_in(&folder, &text), &folder.join("out"), BLOCKS_OF_8).unwrap();
    compute(&sweep, "1/1", 1);
    reduced(&folder.join("out"));
    let csv = std::fs::read_to_string(folder.join("out/sweep.csv")).unwrap();
    let head: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let lines: Vec<Vec<&str>> = csv.lines().skip(1).map(|line| line.splitn(head.len(), ',').collect()).collect();
    let mut line = 0;
    let (mut early, mut unsettled) = (0, 0);
    for block in 0..14_u64 {
        let bytes = std::fs::read(folder.join(format!("out/blocks/{block:08}.npz"))).unwrap();
        let column = |name: &str| luenberger_figures::npz::numbers(&member(&bytes, &format!("{name}.npy"))).unwrap();
        let header: serde_json::Value = serde_json::from_slice(&member(&bytes, "block.json")).unwrap();
        assert_eq!((&header["block"], &header["observer"]), (&block.into(), &"copy".into()));
        let (runs, finished) = (column("run"), column("finished"));
        for (k, run) in runs.iter().enumerate() {
            let cells = &lines[line];
            assert_eq!(cells[1].parse::<f64>().ok(), header["value"].as_f64());
            assert_eq!(cells[2].parse::<f64>(), Ok(*run));
            let why = header["ended"].as_array().unwrap().iter().find(|ended| ended["index"] == k);
            assert_eq!((why.is_none(), cells.last().unwrap().is_empty()), (finished[k] == 1.0, finished[k] == 1.0));
            for (name, cell) in head[3..head.len() - 1].iter().zip(&cells[3..]) {
                let score = column(name)[k];
                if cell.is_empty() {
                    assert!(if why.is_some() { score.is_nan() } else { score == f64::INFINITY }, "{name}: {score}");
                    early += usize::from(why.is_some());
                    unsettled += usize::from(why.is_none());
                } else {
                    assert_eq!(cell.parse::<f64>().unwrap().to_bits(), score.to_bits(), "{name} of run {run}");
                }
            }
            line += 1;
        }
    }
    assert!(line == lines.len() && early > 0 && unsettled > 0, "{early} {unsettled}");
}

/// A block with any byte changed, cut off or appended is no block.
#[test]
fn every_other_file_is_refused() {
    let folder = scratch("refused");
    let sweep = divided(&folder, 1, 20_000, 1);
    sweep.compute([0], &RunOptions::default()).unwrap();
    let file = |number: usize| folder.join(format!("out/blocks/{number:08}.npz"));
    let bytes = std::fs::read(file(0)).unwrap();
    let faults = || sweep_status(&folder.join("out"), true).unwrap().faults;
    assert_eq!(faults(), [""; 0]);
    let length = bytes.len();
    assert!(2 * length < 20_000, "{length} bytes");
    for at in 0..length {
        std::fs::write(file(at), &bytes[..at]).unwrap();
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << (at % 8);
        std::fs::write(file(length + at), flipped).unwrap();
    }
    std::fs::write(file(2 * length), [&bytes[..], b"x"].concat()).unwrap();
    let all = faults();
    assert_eq!(all.len(), 2 * length + 1);
    let (cut, damaged) = ("is cut short, or is no block of a sweep", "is damaged (its checksum does not match)");
    for fault in &all {
        assert!(fault.ends_with(cut) || fault.ends_with(damaged), "{fault}");
    }
    assert!(all[2 * length].ends_with(cut));
    (0..=2 * length).for_each(|number| std::fs::remove_file(file(number)).unwrap());
    // With the right checksum it is one of another version, if a column has another name.
    let (content, sum) = bytes.split_at(length - 64);
    let checksum = |content: &[u8]| {
        use sha2::Digest;
        format!("{:x}", sha2::Sha256::digest(content))
    };
    assert_eq!(checksum(content).as_bytes(), sum);
    let (name, other) = (b"level_rmse.npy", b"level_rmsf.npy");
    let mut renamed = content.to_vec();
    let places: Vec<usize> = (0..content.len()).filter(|at| content[*at..].starts_with(name)).collect();
    assert_eq!(places.len(), 2);
    for at in places {
        renamed[at..at + name.len()].copy_from_slice(other);
    }
    let sum = checksum(&renamed);
    std::fs::write(file(0), [&renamed[..], sum.as_bytes()].concat()).unwrap();
    assert!(faults()[0].ends_with("is a block of another study, or of another version"), "{:?}", faults());
}
