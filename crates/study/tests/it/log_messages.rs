//! What is said and drawn of a log: failures, estimates without a true value, plants without inputs, long logs.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

use luenberger_study::internals::drawn;
use luenberger_study::results::{ConsistencyReport, InnovationOf};
use luenberger_study::{Progress, Results, RunOptions, Step, estimate, execute};
use proptest::prelude::*;

use crate::studies::{scratch, study_in};

fn bench(name: &str, csv: &str) -> PathBuf {
    let folder = scratch(&format!("log-messages/{name}"));
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    folder
}

fn run(folder: &Path, text: &str) -> Results {
    let options = RunOptions { output: Some(folder.join("out").into()), threads: Some(1), ..RunOptions::default() };
    execute(&study_in(folder, text), Step::Run, &options).unwrap_or_else(|error| panic!("{error}"))
}

/// A decay whose rate is an estimated parameter, without an input.
const DECAY: &str = "[plant]
states = [\"level\", \"rate\"]
inputs = []
outputs = [\"gauge\"]
f = [\"-rate*level\", \"0\"]
h = [\"level\"]
[log]
file = \"log.csv\"
inputs = []
";

const FILTER: &str = "[[observer]]
name = \"filter\"
kind = \"extended-kalman\"
initial = [1, 0.4]
p0 = [0.01, 0.04]
w = [1e-8, 0]
v = 1e-4
period = 0.1
";

/// exp(-t/2), every 0.1.
fn decay(rows: usize) -> String {
    let row = |csv: String, k: usize| csv + &format!("{},{}\n", 0.1 * k as f64, (-0.05 * k as f64).exp());
    (0..rows).fold("t,gauge\n".to_owned(), row)
}

/// `inputs = []` is a plant, and a log, without inputs; as if the key were not there.
#[test]
fn a_plant_may_have_no_inputs() {
    let folder = bench("no-inputs", &decay(50));
    let with = run(&folder, &format!("{DECAY}{FILTER}"));
    let without = run(&folder, &format!("{}{FILTER}", DECAY.replace("inputs = []\n", "")));
    assert_eq!(with.plant.inputs, Vec::<String>::new());
    assert_eq!(with.log, without.log);
    let error = luenberger_study::Study::from_text(
        "study.toml",
        &DECAY.replace("outputs = [\"gauge\"]", "outputs = []"),
        luenberger_study::Format::Toml,
        &folder,
    );
    assert!(error.unwrap_err().to_string().contains("`outputs` is an empty list"));
}

/// An estimated parameter has no true value, and its last estimate is in the report with its band: here 1/2.
#[test]
fn the_last_estimate_of_a_parameter_is_said() {
    let folder = bench("parameter", &decay(80));
    let results = run(&folder, &format!("{DECAY}{FILTER}"));
    let row = &results.log.as_ref().unwrap().rows[0];
    let (found, sigma) = (row.estimate[1], row.deviation[1]);
    assert!((found - 0.5).abs() < 0.01 && sigma > 0.0 && sigma < 0.01, "{found}, {sigma}");
    let csv = std::fs::read_to_string(folder.join("out/trajectories/log-filter.csv")).unwrap();
    let last: Vec<&str> = csv.lines().last().unwrap().split(',').collect();
    let at = csv.lines().next().unwrap().split(',').position(|name| name == "rate_2sigma").unwrap();
    assert_eq!(last[at].parse::<f64>().unwrap(), 2.0 * sigma);
    let text = results.text(false);
    let line = text.lines().find(|line| line.contains("filter") && line.contains(" rate ")).unwrap();
    let words: Vec<&str> = line.split_whitespace().collect();
    let [said, band] = [words[2], words[3]].map(|word| word.parse::<f64>().unwrap());
    assert!((said - found).abs() < 1e-5 && (band - 2.0 * sigma).abs() < 1e-2 * sigma, "{line}");
    // A state with a true value has its errors, and no second row.
    let known = DECAY.replace("file =", "states = [\"gauge\", \"-\"]\nfile =");
    let text = run(&folder, &format!("{known}{FILTER}")).text(false);
    let table = text.split("Estimates at the end of the log").nth(1).unwrap();
    let table = table.split("\n\n").next().unwrap();
    assert!(table.contains("rate") && !table.contains("level"), "{table}");
}

/// A run that ends early stands in a list of its own and not among the outputs; the message says what `substeps` is
/// not, and what may help.
#[test]
fn a_failure_is_no_output() {
    let folder = bench("failure", "t,gauge\n0,1\n1,1\n2,1\n3,1\n");
    let diverging = DECAY.replace("-rate*level", "level^3*rate");
    let filters = FILTER.replace("0.4]", "40]") + &FILTER.replace("\"filter\"", "\"sound\"").replace("0.4]", "0]");
    let results = run(&folder, &format!("{diverging}{filters}"));
    let why = results.log.as_ref().unwrap().rows[0].failure.clone().unwrap();
    for words in ["more than 5000 steps are needed", "`substeps` is for targets", "a smaller `p0` or `w`"] {
        assert!(why.contains(words), "{why}");
    }
    let text = results.text(false);
    let innovations = text.split("Innovations y - h(xhat)").nth(1).unwrap().split("\n\n").next().unwrap();
    assert!(innovations.contains("sound") && !innovations.contains("stopped"), "{innovations}");
    assert!(text.contains(&format!("filter: {why}")), "{text}");
}

/// Counts have their noun in the right number.
#[test]
fn one_row_is_a_row() {
    let folder = bench("one", "t,gauge,other\n0,1,1\n1,0.6,\n2,0.4,\n");
    let two =
        DECAY.replace("[\"gauge\"]", "[\"gauge\", \"other\"]").replace("h = [\"level\"]", "h = [\"level\", \"level\"]");
    let text = run(&folder, &format!("{two}{}", FILTER.replace("v = 1e-4", "v = [1e-4, 1e-4]"))).text(false);
    assert!(text.contains("other is measured in 1 row "), "{text}");
    assert!(!text.contains("1 rows"), "{text}");
}

fn consistency(mean: f64, region: [f64; 2], samples: usize, [singular, outside, left_out]: [usize; 3]) -> String {
    let accepted = (region[0]..=region[1]).contains(&mean) && outside == 0;
    let report = ConsistencyReport { mean, expected: 1.0, region, samples, singular, outside, left_out, accepted };
    report.in_words()
}

/// A mean in the region is said to be there, also where the test is not accepted because an error is without variance.
#[test]
fn a_mean_in_the_region_is_said_to_be_there() {
    let words = consistency(1.0, [0.91, 1.09], 3, [3, 2, 0]);
    assert_eq!(
        words,
        "1, in [0.91, 1.09] (P is singular at 3 of 3 samples, an error has no variance at 2 of 3 samples)"
    );
}

/// What a test of consistency and an innovation say, by hand.
#[test]
fn statistics_in_words() {
    let words = consistency;
    let region = [0.912_34, 1.09];
    assert_eq!(words(1.04, region, 40, [0; 3]), "1.04, in [0.912, 1.09]");
    assert_eq!(words(1.2, region, 40, [0; 3]), "1.2, above [0.912, 1.09]");
    assert_eq!(words(0.9, region, 40, [0; 3]), "0.9, below [0.912, 1.09]");
    assert_eq!((words(1.09, region, 1, [0; 3]).as_str()), "1.09, in [0.912, 1.09]");
    assert_eq!(
        words(1.5, region, 3, [4, 2, 5]),
        "1.5, above [0.912, 1.09] (P is singular at 4 of 9 samples, an error has no variance at 2 of 9 samples, there is \
         no result at 5 of 9 samples)"
    );
    assert_eq!(words(0.0, [0.0, 0.0], 0, [0, 0, 7]), "- (there is no result at 7 of 7 samples)");
    assert_eq!(words(0.0, [0.0, 0.0], 0, [0; 3]), "-");
    let innovation = |rejected, white| InnovationOf {
        output: "y".to_owned(),
        samples: 1450,
        rejected,
        mean: 0.0,
        rms: 1.0,
        peak: 2.0,
        white,
    };
    assert_eq!(innovation(0, None).samples_in_words(), "1450");
    assert_eq!(innovation(6, None).samples_in_words(), "1450 (6 rejected)");
    assert_eq!(innovation(0, None).whiteness_in_words(), None);
    assert_eq!(innovation(0, Some(3.7e-169)).whiteness_in_words().unwrap(), "3.7e-169 (rejected)");
    assert_eq!(innovation(0, Some(0.05)).whiteness_in_words().unwrap(), "0.05 (not rejected)");
}

proptest! {
    /// Of a long curve the peaks of each part are drawn, in order; of a short one everything.
    #[test]
    fn a_drawn_curve_has_its_peaks(y in proptest::collection::vec(-1e3..1e3f64, 1..9000), gap in 0usize..100) {
        let rows: Vec<usize> = (gap..gap + y.len()).collect();
        let kept = drawn(&rows, y.len(), |k| y[k - gap]);
        prop_assert!(kept.windows(2).all(|pair| pair[0] < pair[1]));
        let of = |rows: &[usize], choose: fn(f64, f64) -> f64| rows.iter().map(|k| y[k - gap]).reduce(choose);
        prop_assert_eq!(of(&kept, f64::max), of(&rows, f64::max));
        prop_assert_eq!(of(&kept, f64::min), of(&rows, f64::min));
        prop_assert_eq!((kept.first(), kept.last()), (rows.first(), rows.last()));
        prop_assert!(kept.len() <= 1600);
        if y.len() <= 1500 {
            prop_assert_eq!(kept, rows);
        }
    }
}

/// A long log tells how far it is, and takes about as long as is said before.
#[test]
fn a_long_log_is_estimated_and_tells_its_rows() {
    let count = 60_000;
    let row = |csv: String, k: usize| csv + &format!("{},{}\n", 0.1 * k as f64, 1.0 + 0.01 * (k as f64).sin());
    let folder = bench("long", &(0..count).fold("t,gauge\n".to_owned(), row));
    let study = study_in(&folder, &format!("{DECAY}{}", FILTER.replace("1e-8, 0]", "1e-4, 1e-6]")));
    let cost = estimate(&study, Step::Simulate, 1);
    let told = Mutex::new(Vec::new());
    let tell = |progress: Progress<'_>| {
        if progress.stage == "log" {
            told.lock().unwrap().push((progress.done, progress.total));
        }
    };
    let began = Instant::now();
    let options = RunOptions { threads: Some(1), progress: &tell, ..RunOptions::default() };
    let results = execute(&study, Step::Simulate, &options).unwrap();
    let seconds = began.elapsed().as_secs_f64();
    assert_eq!(results.failures(), Vec::<String>::new());
    let told = told.into_inner().unwrap();
    assert_eq!((told.len(), told[0], told[49], told[50]), (51, (1200, count), (count, count), (1, 1)));
    // The machine may be busy with one of the two: the factor is 3 on a quiet one.
    let ratio = cost.seconds / seconds;
    assert!((0.05..20.0).contains(&ratio), "estimated {} s, took {seconds} s", cost.seconds);
}

/// One column for two outputs would count each measurement twice.
#[test]
fn two_outputs_of_one_column_are_refused() {
    let folder = scratch("log-one-column");
    std::fs::write(folder.join("log.csv"), "t,y\n0,1\n1,2\n2,3\n").unwrap();
    let text = "[plant]\na = [[-1]]\nc = [[1], [1]]\noutputs = [\"left\", \"right\"]\n[log]\nfile = \"log.csv\"\noutputs = [\"y\", \"y\"]\n";
    let error = luenberger_study::Study::from_text("study.toml", text, luenberger_study::Format::Toml, &folder);
    let error = error.unwrap_err().to_string();
    assert!(error.contains("the outputs left and right are both the column \"y\""), "{error}");
    assert!(error.contains("one measurement would count twice"), "{error}");
}
