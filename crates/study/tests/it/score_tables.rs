//! Scores as tables, for the terminal and the report.

use luenberger_study::results::ScoreTable;
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
