//! Logs as they come: times as dates and counters, unnamed columns, rows of one time, expressions of columns, outputs
//! that the logger repeats, quantised outputs.

use luenberger_study::table::{Suspicion, Table};
use proptest::prelude::*;

use luenberger_study::{RunOptions, Step, execute};

use crate::studies::{scratch, study_in};

fn times(column: &[&str]) -> Result<Vec<f64>, String> {
    let rows: Vec<String> = column.iter().map(|t| format!("{t},0")).collect();
    let log = Table::parse(&format!("t,y\n{}\n", rows.join("\n"))).unwrap().recording("t", &[], &["y"]);
    log.map(|log| log.times().to_vec()).map_err(|error| error.to_string())
}

/// Differences by the calendar: 2024 and 2000 are leap years, 1900 is none; offsets are east of universal time.
#[test]
fn dates_are_seconds_since_the_first_row() {
    let day = 86_400.0;
    let cases: [(&[&str], &[f64]); 8] = [
        (&["2024-05-01T12:00:00Z", "2024-05-01T12:00:00.25Z"], &[0.0, 0.25]),
        (&["2024-02-28 23:59:59", "2024-03-01 00:00:00"], &[0.0, day + 1.0]),
        (&["1900-02-28", "1900-03-01", "1901-03-01"], &[0.0, day, 366.0 * day]),
        (&["2000-02-28", "2000-03-01", "2001-01-01"], &[0.0, 2.0 * day, 308.0 * day]),
        (&["1969-12-31T23:59:59Z", "1970-01-01T00:00:01Z"], &[0.0, 2.0]),
        (&["2024-03-31T01:59:59+01:00", "2024-03-31T03:00:00+02:00"], &[0.0, 1.0]),
        // Midnight passes.
        (&["23:59:59.5", "00:00:00.25", "12:00:00"], &[0.0, 0.75, 43_200.5]),
        (&["12:00", "12:01"], &[0.0, 60.0]),
    ];
    for (column, expected) in cases {
        assert_eq!(times(column).unwrap(), expected, "{column:?}");
    }
    // Nanoseconds of a log of a day, which seconds since 1970 in binary64 do not have.
    let fine = times(&["2024-05-01T00:00:00.000000001Z", "2024-05-01T23:00:00.000000003Z"]).unwrap();
    assert_eq!(fine[1], 82_800.000_000_002);
}

#[test]
fn times_that_are_no_dates_are_refused() {
    let dates = "dates and times of day are for the column of times";
    for wrong in ["5/1/2024", "01.05.2024 12:00", "2024-13-01", "2024-02-30", "25:00:00"] {
        let said = times(&[wrong, "1"]).unwrap_err();
        assert!(said.starts_with(&format!("line 2, column 1 (t): expected a number, found `{wrong}`")), "{said}");
    }
    assert!(times(&["2024-05-01", "7"]).unwrap_err().contains("found `2024-05-01`"));
    assert!(times(&["7", "2024-05-01"]).unwrap_err().contains("found `2024-05-01`"));
    assert!(times(&["2024-05-01", "12:00:00"]).unwrap_err().contains("found `2024-05-01`"));
    assert_eq!(times(&["2024-05-01", ""]).unwrap_err(), "line 3, column 1 (t): the value is missing");
    assert_eq!(times(&["", "2024-05-01"]).unwrap_err(), "line 2, column 1 (t): the value is missing");
    // As an output a date is none.
    let said = Table::parse("t,y\n0,2024-05-01\n1,2024-05-02\n").unwrap().recording("t", &[], &["y"]).unwrap_err();
    assert!(said.to_string().contains(dates), "{said}");
    // A clock that goes back is another log.
    let back = times(&["12:00:10", "12:00:05"]).unwrap_err();
    assert_eq!(
        back,
        "line 3: the time -5 comes before 0, the time of the row above; where the logger started again begins another log"
    );
}

#[test]
fn the_index_of_pandas_is_no_column() {
    let table = Table::parse(",t,y\n0,0,1\n1,0.1,2\n").unwrap();
    assert_eq!(table.recording("t", &[], &["y"]).unwrap().times(), [0.0, 0.1]);
    assert_eq!(table.values("z").unwrap_err().to_string(), "there is no column `z`; the columns are t, y");
    assert!(Table::parse("t,,y\n0,0,1\n").is_err() && Table::parse("\n\n").is_err());
}

/// Two sensors that write a row each when they measure.
#[test]
fn rows_of_one_time_are_one() {
    let table = Table::parse("t,u,a,b\n0,1,5,\n0,2,,7\n1,2,6,\n1,2,6,8\n2,3,,\n").unwrap();
    let log = table.recording("t", &["u"], &["a", "b"]).unwrap();
    assert_eq!(log.times(), [0.0, 1.0, 2.0]);
    assert_eq!(log.inputs().values().column(0).as_slice(), [2.0, 2.0, 3.0]);
    let values = |j: usize| [0, 1, 2].map(|i| log.outputs().value(i, j));
    assert_eq!((values(0), values(1)), ([Some(5.0), Some(6.0), None], [Some(7.0), Some(8.0), None]));
    let truth = table.samples_with_missing("t", &[Some("u"), None]).unwrap();
    assert_eq!((truth.value(0, 0), truth.value(1, 1)), (Some(2.0), None));
    let twice = Table::parse("t,y\n0,1\n1,1\n1,2\n").unwrap().recording("t", &[], &["y"]).unwrap_err();
    assert_eq!(twice.to_string(), "line 4, column 2 (y): this time has another value above");
    assert!(Table::parse("t,y\n1,1\n1,1\n").unwrap().recording("t", &[], &["y"]).is_err());
}

#[test]
fn a_column_may_be_an_expression_of_columns() {
    let text = "stamp [us],acc_x [m/s2],range,odd-name\n1000000,9.81,4,1\n1500000,,0,2\n3000000,19.62,1,3\n";
    let table = Table::parse(text).unwrap();
    let log = table.recording("(stamp - 1e6)/1e6", &["range^2"], &["acc_x/9.81"]).unwrap();
    assert_eq!(log.times(), [0.0, 0.5, 2.0]);
    assert_eq!(log.inputs().values().column(0).as_slice(), [16.0, 0.0, 1.0]);
    assert_eq!([0, 1, 2].map(|i| log.outputs().value(i, 0)), [Some(1.0), None, Some(2.0)]);
    // Which cell of an expression is blank, the expression does not say.
    let blank = Table::parse("t,a,b\n0,1,\n1,2,3\n").unwrap().recording("t", &["a*b"], &["a"]).unwrap_err();
    assert_eq!(blank.to_string(), "line 2, column 2 (a*b): the value is missing");
    // A column of that name comes first.
    assert_eq!(table.recording("stamp", &[], &["odd-name"]).unwrap().outputs().value(2, 0), Some(3.0));
    let said = |output: &str| table.recording("stamp", &[], &[output]).unwrap_err().to_string();
    assert_eq!(said("1/range"), "line 3, column 3 (1/range): inf is not a finite number");
    let none = said("2*speed");
    assert!(none.starts_with("`2*speed` is no column, and no expression of columns: there is no `speed`"), "{none}");
    assert_eq!(said("2*3"), "`2*3` is no column, and no expression of columns: no column occurs in it");
    assert_eq!(said("odd-mame"), "there is no column `odd-mame`; did you mean `odd-name`?");
    assert_eq!(said("ranges"), "there is no column `ranges`; did you mean `range`?");
    assert!(said("range*t").starts_with("there is no column `t`"), "{}", said("range*t"));
    let rate = Table::parse("t,y\n1,3\n2,8\n").unwrap().recording("t", &[], &["y/t"]).unwrap();
    assert_eq!([rate.outputs().value(0, 0), rate.outputs().value(1, 0)], [Some(3.0), Some(4.0)]);
}

/// The values of a sensor that measures in every `each`th row.
fn held(rows: usize, each: usize, value: impl Fn(usize) -> f64) -> Table {
    let rows: Vec<String> = (0..rows).map(|k| format!("{},{}", 0.02 * k as f64, value(k / each * each))).collect();
    Table::parse(&format!("t,y\n{}\n", rows.join("\n"))).unwrap()
}

/// A pseudo-random number in [0, 1): the fractional part of a multiple of the golden ratio's square.
fn scattered(k: usize) -> f64 {
    ((k * k + 3 * k) as f64 * 0.381_966_011_250_105).fract()
}

fn measurements(table: &Table) -> usize {
    table.recording("t", &[], &["y"]).unwrap().outputs().count(0)
}

#[test]
fn a_repeated_measurement_counts_once() {
    let noisy = |k: usize| (0.01 * k as f64).sin() + 0.1 * scattered(k);
    let table = held(4001, 10, noisy);
    assert_eq!(measurements(&table), 401);
    let said = table.suspicions("t", &[], &["y"]).unwrap();
    assert_eq!(said, [Suspicion::Repeated { column: "y".to_owned(), each: 10, measurements: 401 }]);
    assert!(
        said[0]
            .to_string()
            .starts_with("`y` changes in about every 10th row: taken for 401 measurements that the logger repeats")
    );
    assert_eq!(measurements(&table.clone().counting_repeats()), 4001);
    // A measurement that happens to be the one before makes a run twice as long: one in five of them.
    let equal = held(4000, 10, |k| noisy(if k / 10 % 5 == 4 { k - 10 } else { k }));
    assert_eq!(measurements(&equal), 320);
    // A rhythm between two and three rows: a sensor of 20 Hz in a log of 50 Hz.
    let uneven: Vec<String> = (0..500).map(|k| format!("{k},{}", noisy(2 * k / 5))).collect();
    assert_eq!(measurements(&Table::parse(&format!("t,y\n{}\n", uneven.join("\n"))).unwrap()), 200);
}

/// Values that repeat without being repeated: a quantised ramp and sine, a switch, a sensor that failed.
#[test]
fn signals_that_rest_are_measured_in_every_row() {
    let ramp = held(400, 1, |k| (k / 5) as f64 * 0.25);
    let sine = held(400, 1, |k| (40.0 * (0.031 * k as f64).sin()).round() / 40.0);
    let switch = held(400, 1, |k| f64::from(u8::from(k / 20 % 2 == 0)));
    let frozen = held(400, 1, |k| if (100..140).contains(&k) { 0.5 } else { scattered(k) });
    let few = held(80, 10, scattered);
    for (name, table, rows) in
        [("ramp", ramp, 400), ("sine", sine, 400), ("switch", switch, 400), ("frozen", frozen, 400), ("few", few, 80)]
    {
        assert_eq!(measurements(&table), rows, "{name}");
    }
}

/// An observer on the log of a sensor at 5 Hz that is written at 50 Hz gives what it gives on the measurements.
#[test]
fn the_observer_is_corrected_once_by_each_measurement() {
    const STUDY: &str = r#"
[plant]
a = [[0, 1], [0, 0]]
c = [[1, 0]]
[log]
file = "log.csv"
[[observer]]
name = "filter"
kind = "extended-kalman"
w = [0.01, 0.1]
v = 0.01
period = 0.02
"#;
    let value = |k: usize| (0.01 * k as f64).sin() + 0.1 * scattered(k);
    let log = |cell: &dyn Fn(usize) -> String| {
        let rows: Vec<String> = (0..1000).map(|k| format!("{},{}", 0.02 * k as f64, cell(k))).collect();
        format!("t,y1\n{}\n", rows.join("\n"))
    };
    let repeated = log(&|k| value(k / 10 * 10).to_string());
    let blank = log(&|k| if k % 10 == 0 { value(k).to_string() } else { String::new() });
    let [repeated, blank] = [("repeated", repeated), ("blank", blank)].map(|(name, log)| {
        let folder = scratch(&format!("log-columns/{name}"));
        std::fs::write(folder.join("log.csv"), log).unwrap();
        execute(&study_in(&folder, STUDY), Step::Run, &RunOptions::default()).unwrap()
    });
    assert_eq!(repeated.log, blank.log);
    assert!(repeated.log.is_some());
    let said: Vec<_> = repeated.warnings.iter().filter(|warning| warning.starts_with("in the log")).collect();
    assert_eq!(said.len(), 1, "{said:?}");
}

#[test]
fn a_smooth_quantised_signal_is_not_saturated() {
    let sine =
        |limit: f64| held(4000, 1, move |k| ((300.0 * (0.0021 * k as f64).sin()).round() / 300.0).clamp(-limit, limit));
    assert_eq!(sine(2.0).suspicions("t", &[], &["y"]).unwrap(), []);
    let said = sine(0.9).suspicions("t", &[], &["y"]).unwrap();
    assert!(matches!(said[..], [Suspicion::Saturated { .. }, Suspicion::Saturated { .. }]), "{said:?}");
}

#[test]
fn counters_and_many_of_one_kind_are_said_once() {
    let counter = Table::parse("us,y\n0,1\n20000,2\n40000,3\n60001,4\n").unwrap();
    let said: Vec<String> = counter.suspicions("us", &[], &["y"]).unwrap().iter().map(ToString::to_string).collect();
    assert_eq!(
        said,
        [
            "the times are whole numbers, 20000 apart in the median: where they are microseconds, `time = \"us/1e6\"` has seconds"
        ]
    );
    let hours = Table::parse("t,y\n0,1\n3600,2\n7200,3\n").unwrap();
    assert_eq!(hours.suspicions("t", &[], &["y"]).unwrap(), []);
    // A gap after every ten rows.
    let rows: Vec<String> = (0..200).map(|k| format!("{},{}", k + 50 * (k / 10), scattered(k))).collect();
    let gaps = Table::parse(&format!("t,y\n{}\n", rows.join("\n"))).unwrap().suspicions("t", &[], &["y"]).unwrap();
    assert!(matches!(&gaps[..], [Suspicion::Several { count: 19, .. }]), "{gaps:?}");
    assert_eq!(gaps[0].to_string(), "Gap 9-60 (median Ts 1); the first of 19");
}

proptest! {
    /// Whatever a measurement is repeated for, its repetitions have no weight, and no first row of one is lost.
    #[test]
    fn each_measurement_is_kept(each in 2_usize..30, count in 12_usize..60, seed in 0_usize..1000) {
        let table = held(each * count, each, |k| scattered(k + seed));
        let log = table.recording("t", &[], &["y"]).unwrap();
        let kept: Vec<usize> = (0..each * count).filter(|i| log.outputs().value(*i, 0).is_some()).collect();
        let expected: Vec<usize> = (0..each * count).step_by(each).collect();
        // Neighbours that are equal by chance are one measurement.
        prop_assert!(kept == expected || kept.len() + 1 == expected.len());
    }
}
