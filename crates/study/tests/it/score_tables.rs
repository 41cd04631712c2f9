//! Scores as tables, for the terminal and the report.

use luenberger_study::results::{PercentileReport, ScoreTable, StateReport, SweepRow};
use luenberger_study::{Results, Step};

use crate::studies::executed;

const STUDY: &str = r#"
[plant]
a = [[-1]]
c = [[1]]
[simulation]
x0 = [1]
duration = 1
samples = 3
[[observer]]
name = "a"
kind = "luenberger"
poles = [-2]
[[observer]]
name = "b"
kind = "luenberger"
poles = [-2]
[[observer]]
name = "c"
kind = "luenberger"
poles = [-2]
"#;

/// The table of the errors, which have these settling times, the peak 4 and these last values.
fn table(results: &mut Results, errors: &[(Option<f64>, f64)]) -> ScoreTable {
    let simulation = results.simulation.as_mut().unwrap();
    simulation.rows.truncate(errors.len());
    for (row, (settles, last)) in simulation.rows.iter_mut().zip(errors) {
        let state = &mut row.merits.as_mut().unwrap().states[0];
        (state.peak, state.settling_5, state.last) = (4.0, *settles, *last);
    }
    simulation.state_table(&results.plant, 1).unwrap()
}

#[test]
fn the_best_is_marked_unless_all_are_alike() {
    let mut results = executed(STUDY, Step::Simulate);
    let table_of_three = table(&mut results, &[(None, 1e-9), (Some(2.0), 1.01e-9), (Some(3.0), 2.0)]);
    let column = |title: &str| table_of_three.head.iter().position(|head| head == title).unwrap();
    let best = |title: &str| table_of_three.rows.iter().map(|row| row[column(title)].best).collect::<Vec<_>>();
    // Two that are written alike are both best; a score that all share is none.
    assert_eq!(best("settling 5 %"), [false, true, false]);
    assert_eq!(best("at the end"), [true, true, false]);
    for alike in ["error of", "observer", "RMSE", "peak", "overshoot", "settling 2 %"] {
        assert_eq!(best(alike), [false; 3], "{alike}");
    }
    assert_eq!(table_of_three.rows[0][column("settling 5 %")].text, "never");
    // Observers that start from different estimates are not compared.
    results.simulation.as_mut().unwrap().rows[1].initial[0] += 0.1;
    let unequal = table(&mut results, &[(None, 1e-9), (Some(2.0), 1.01e-9), (Some(3.0), 2.0)]);
    assert!(unequal.rows.iter().flatten().all(|cell| !cell.best));
    // One observer has nobody to be compared with.
    let table_of_one = table(&mut results, &[(None, 1.0)]);
    assert_eq!(table_of_one.rows[0].iter().filter(|cell| cell.best).count(), 0);
    // An error that starts at 0 has no settling time.
    results.simulation.as_mut().unwrap().rows[0].merits.as_mut().unwrap().states[0].initial = 0.0;
    assert_eq!(table(&mut results, &[(None, 1.0)]).rows[0][column("settling 5 %")].text, "-");
}

/// The cells of a table, row by row.
fn texts(table: &ScoreTable) -> Vec<Vec<&str>> {
    table.rows.iter().map(|row| row.iter().map(|cell| cell.text.as_str()).collect()).collect()
}

fn scores(name: &str, k: f64) -> StateReport {
    StateReport {
        state: name.to_owned(),
        unit: (name == "x2").then(|| "m".to_owned()),
        initial: 1.0,
        rmse: k + 0.1,
        peak: k + 0.2,
        overshoot: k + 0.3,
        settling_5: (k < 2.0).then_some(k + 0.4),
        settling_2: Some(k + 0.5),
        last: k + 0.6,
        steady_rmse: k + 0.7,
    }
}

fn percentile(percent: u8, k: f64) -> PercentileReport {
    PercentileReport {
        percent,
        settling: (percent == 5).then_some(k),
        rms: Some(k + 1.0),
        peak: Some(k + 2.0),
        last: Some(k + 3.0),
        steady_rms: None,
        states: vec![scores("x1", k), scores("x2", k + 1.0)],
    }
}

/// Rows of a sweep: an ensemble of four with percentiles, a single value, one without a run, and one that is not among
/// the tables because nothing of it finished.
#[test]
fn the_tables_of_a_sweep() {
    let swept = format!("{STUDY}[sweep]\nparameter = \"initial\"\nvalues = [1]\n");
    let results = executed(&swept, Step::Sweep);
    let (mut sweep, mut plant) = (results.sweep.clone().unwrap(), results.plant.clone());
    plant.time_unit = Some("ms".to_owned());
    sweep.ensemble = 4;
    let row = |observer: &str, value: f64, finished: usize| SweepRow {
        observer: observer.to_owned(),
        value,
        finished,
        states: vec![scores("x1", 0.0), scores("x2", 1.0)],
        ..SweepRow::default()
    };
    sweep.rows = vec![
        SweepRow {
            settling: Some(1.5),
            rms: Some(2.25),
            peak: Some(3.123_456),
            last: Some(4.0),
            percentiles: vec![percentile(5, 0.0), percentile(95, 1.0)],
            ..row("a", 0.5, 4)
        },
        SweepRow { failure: Some("it diverges".to_owned()), ..row("b", 2.0, 3) },
        SweepRow { failure: Some("no design".to_owned()), ..row("c", 1e-3, 0) },
    ];
    let table = sweep.table(&plant, 1).unwrap();
    let times = ["settling 5 % (ms)", "settling 2 % (ms)"];
    assert_eq!(
        table.head,
        ["initial", "observer", "finished", "error of", "RMSE", "peak", "overshoot", times[0], times[1], "at the end"]
    );
    let of_a = ["0.5", "a", "4 of 4", "x1", "0.1 (0.1 .. 1.1)", "0.2 (0.2 .. 1.2)", "0.3 (0.3 .. 1.3)"];
    let of_a = [&of_a[..], &["0.4 (0.4 .. 1.4)", "0.5 (0.5 .. 1.5)", "0.6 (0.6 .. 1.6)"]].concat();
    let of_b = vec!["2", "b", "3 of 4", "x1", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6"];
    assert_eq!(texts(&table), [of_a, of_b.clone()]);
    assert_eq!(table.omitted, 1);
    let both = sweep.table(&plant, 2).unwrap();
    assert_eq!((both.omitted, both.rows.len(), sweep.table(&plant, 3).unwrap().omitted), (0, 4, 0));
    // The second state of the first row, whose 95th percentile does not settle.
    let second = ["0.5", "a", "4 of 4", "x2 (m)", "1.1 (1.1 .. 2.1)", "1.2 (1.2 .. 2.2)", "1.3 (1.3 .. 2.3)"];
    let second = [&second[..], &["1.4 (1.4 .. never)", "1.5 (1.5 .. 2.5)", "1.6 (1.6 .. 2.6)"]].concat();
    assert_eq!(texts(&both)[1], second);
    let kinds: Vec<bool> = both.rows[0].iter().map(|cell| cell.number).collect();
    assert_eq!(kinds, [true, false, true, false, true, true, true, true, true, true]);
    assert!(both.rows.iter().flatten().all(|cell| !cell.best));
    // With a scale the scores of the norm.
    sweep.scoring.scale = Some(vec![1.0, 1.0]);
    let table = sweep.table(&plant, 1).unwrap();
    let scores = ["settling time (ms)", "peak |e|", "rms |e|", "|e| at the end"];
    assert_eq!(table.head, [&["initial", "observer", "finished"][..], &scores].concat());
    let of_a = ["0.5", "a", "4 of 4", "1.5 (0 .. never)", "3.12 (2 .. 3)", "2.25 (1 .. 2)", "4 (3 .. 4)"];
    assert_eq!(texts(&table), [of_a, ["2", "b", "3 of 4", "-", "-", "-", "-"]]);
    assert_eq!(table.omitted, 0);
    let ended = ["b with initial = 2, 1 of 4 runs: it diverges", "c with initial = 0.001: no design"];
    assert_eq!(sweep.ended(), ended);
    sweep.rows.remove(0);
    sweep.rows.remove(0);
    assert_eq!((sweep.table(&plant, 1), sweep.ended()), (None, vec![ended[1].to_owned()]));
}

/// The norm and the states of three observers, of which the first two start alike: what is said of each, and which is
/// marked.
#[test]
fn the_tables_of_a_simulation() {
    let mut results = executed(&STUDY.replace("samples = 3\n", "samples = 3\nscale = [1]\n"), Step::Simulate);
    results.plant.time_unit = Some("s".to_owned());
    let plant = results.plant.clone();
    let simulation = results.simulation.as_mut().unwrap();
    for (k, row) in simulation.rows.iter_mut().enumerate() {
        let merits = row.merits.as_mut().unwrap();
        let norm = merits.norm.as_mut().unwrap();
        let x = k as f64;
        (norm.initial, norm.settling_first, norm.settling_last) = (1.0, Some(x + 0.5), (k > 0).then_some(x));
        (norm.peak, norm.rms, norm.last) = (1.0, 3.0 - x, 0.012_345 * (x + 1.0));
        merits.states = vec![scores("x1", x), scores("x2", x)];
    }
    let table = simulation.norm_table(&plant).unwrap();
    let head = ["observer", "enters band (s)", "settling time (s)", "peak |e|", "rms |e|", "|e| at the end"];
    assert_eq!(table.head, head);
    assert_eq!(
        texts(&table),
        [
            ["a", "0.5", "never", "1", "3", "0.012"],
            ["b", "1.5", "1", "1", "2", "0.025"],
            ["c", "2.5", "2", "1", "1", "0.037"]
        ]
    );
    let best = |table: &ScoreTable| -> Vec<(usize, usize)> {
        let all = table.rows.iter().enumerate();
        all.flat_map(|(i, row)| row.iter().enumerate().filter(|(_, cell)| cell.best).map(move |(j, _)| (i, j)))
            .collect()
    };
    assert_eq!((best(&table), table.omitted), (vec![(0, 5), (1, 2), (2, 4)], 0));
    let states = simulation.state_table(&plant, 1).unwrap();
    assert_eq!((states.omitted, states.rows.len()), (1, 3));
    assert_eq!(texts(&states)[1], ["x1", "b", "1.1", "1.2", "1.3", "1.4", "1.5", "1.6"]);
    assert_eq!(texts(&states)[2][5], "never");
    assert_eq!(best(&states), [2, 3, 4, 5, 6, 7].map(|column| (0, column)));
    let both = simulation.state_table(&plant, 2).unwrap();
    assert_eq!((both.omitted, both.rows.len(), texts(&both)[3][0]), (0, 6, "x2 (m)"));
    // A run that ended early is in no table.
    simulation.rows[1].merits = None;
    simulation.rows[1].failure = Some("it stopped".to_owned());
    assert_eq!(simulation.ended(), ["b: it stopped"]);
    assert_eq!(texts(&simulation.norm_table(&plant).unwrap()).iter().map(|row| row[0]).collect::<Vec<_>>(), ["a", "c"]);
    simulation.rows.truncate(2);
    simulation.rows[0].merits = None;
    assert_eq!((simulation.norm_table(&plant), simulation.state_table(&plant, 6)), (None, None));
}
