//! Reduced-order observers in studies.

use luenberger_proof::certificate::Theorem;
use luenberger_study::deployment::sampled;
use luenberger_study::execute::Step;
use luenberger_study::{RunOptions, execute};

use crate::studies::{designed, extension, read, scratch};

/// MATLAB's example of a minimum-order observer, Ogata, Modern Control Engineering, 5th ed., example 10-8: `x1' = x2`,
/// `x2' = x3`, `x3' = -6 x1 - 11 x2 - 6 x3 + u`, `y = x1`, poles -2 +- j 2 sqrt 3, for which Ke = [-2; 17].
pub(crate) const OGATA: &str = r#"[plant]
a = [[0, 1, 0], [0, 0, 1], [-6, -11, -6]]
b = [[0], [0], [1]]
c = [[1, 0, 0]]
[input]
expressions = ["sin(t)"]
[simulation]
x0 = [1, -1, 2]
duration = 8
hold = 0.01
[[observer]]
name = "o"
kind = "reduced-order"
poles = [[-2, 3.4641016151377544], [-2, -3.4641016151377544]]
"#;

#[test]
fn the_gain_is_that_of_the_textbook() {
    let study = read(OGATA).unwrap();
    let found = designed(&study).unwrap();
    assert_eq!(found.report.verdict.word(), "proved");
    let certificate = found.certificate.unwrap();
    let Theorem::ReducedOrderConvergence(theorem) = certificate.theorems()[0].theorem() else { panic!() };
    // T = [-Ke I] up to a change of the coordinates of w: the rows of Ke follow from its right block.
    let t = nalgebra::DMatrix::from_fn(2, 3, |i, j| theorem.t[(i, j)]);
    let ke = -t.columns(1, 2).into_owned().try_inverse().unwrap() * t.column(0);
    assert!((ke[0] + 2.0).abs() < 1e-9 && (ke[1] - 17.0).abs() < 1e-9, "{ke}");
    let mut poles = found.report.poles;
    poles.sort_by(|a, b| a[1].total_cmp(&b[1]));
    assert!((poles[1][0] + 2.0).abs() < 1e-9 && (poles[1][1] - 12f64.sqrt()).abs() < 1e-9, "{poles:?}");
}

#[test]
fn it_runs_and_its_step_follows() {
    let folder = scratch("reduced-order");
    let study = read(OGATA).unwrap();
    execute(&study, Step::Run, &RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() }).unwrap();
    let csv = std::fs::read_to_string(folder.join("trajectories/o.csv")).unwrap();
    let row = |line: &str| -> Vec<f64> { line.split(',').map(|x| x.parse().unwrap()).collect() };
    let (first, last) = (row(csv.lines().nth(1).unwrap()), row(csv.lines().last().unwrap()));
    // t, three states, u, y, three estimates: that of the output is exact from the start.
    assert!(first.len() == 9 && (first[1] - first[6]).abs() < 1e-12, "{first:?}");
    for k in 1..=3 {
        assert!((last[k] - last[k + 5]).abs() < 1e-5, "{last:?}");
    }
    luenberger_proof::certificate::verify(&std::fs::read(folder.join("certificates/o.json")).unwrap()).unwrap();
    let step = sampled(&study, &study.observers[0], Some(0.01), None).unwrap();
    extension(&step);
}

/// Franklin, Powell and Workman, Digital Control of Dynamic Systems, 3rd ed., section 8.2.4: the satellite 1/s^2 at
/// T = 0.1 with the pole 0.5 has `L_r = 5`. By hand: x2 - xhat2 at a sample is `0.5^k (x2 - 5 x1)(0)` from xhat = 0,
/// the error of x1 is 0, and with D the same.
const SATELLITE: &str = r#"[plant]
a = [[1, 0.1], [0, 1]]
b = [[0.005], [0.1]]
c = [[1, 0]]
dt = 0.1
[input]
expressions = ["sin(3*t)"]
[simulation]
x0 = [1, -1]
duration = 1
[[observer]]
name = "o"
kind = "reduced-order"
poles = [0.5]
"#;

#[test]
fn the_observer_of_samples_has_the_gain_of_the_textbook() {
    for (k, text) in [SATELLITE.to_owned(), SATELLITE.replace("dt =", "d = [[2]]\ndt =")].iter().enumerate() {
        let study = read(text).unwrap();
        let found = designed(&study).unwrap();
        assert_eq!(found.report.verdict.word(), "proved");
        let matrix =
            |name: &str| found.report.matrices.iter().find(|m| m.name.starts_with(name)).unwrap().rows.concat();
        for (name, expected) in [("N (", [1.0, 5.0]), ("L", [1.5, 5.0])] {
            assert!(matrix(name).iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-13), "{:?}", matrix(name));
        }
        assert_eq!(found.report.statement.contains("y - D u"), k == 1);
        let folder = scratch(&format!("reduced-order-of-samples-{k}"));
        execute(&study, Step::Run, &RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() })
            .unwrap();
        let csv = std::fs::read_to_string(folder.join("trajectories/o.csv")).unwrap();
        for (sample, line) in csv.lines().skip(1).enumerate() {
            // t, x1, x2, u1, y1 and the estimates.
            let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
            let expected = -6.0 * 0.5f64.powi(i32::try_from(sample).unwrap());
            assert!((row[1] - row[5]).abs() < 1e-12 && (row[2] - row[6] - expected).abs() < 1e-11, "{row:?}");
        }
        luenberger_proof::certificate::verify(&std::fs::read(folder.join("certificates/o.json")).unwrap()).unwrap();
        assert!(
            sampled(&study, &study.observers[0], None, None).unwrap().design.update_gain(&study.observers[0]).is_some()
        );
    }
    assert!(read(&SATELLITE.replace("[0.5]", "[1]")).unwrap_err().to_string().contains("unit circle"));
    let hidden = read(&SATELLITE.replace("[[1, 0]]", "[[0, 1]]")).unwrap();
    let Err(failure) = designed(&hidden) else { panic!("x1 is hidden") };
    assert!(failure.hypothesis.contains("not observable"), "{}", failure.hypothesis);
    let nothing = SATELLITE.replace("[[1, 0]]", "[[1, 0], [0, 1]]").replace("poles = [0.5]", "poles = []");
    assert!(read(&nothing).is_err());
}

/// The double integrator with y = x1 + 2 u and the pole -4: x2 - xhat2 is `exp(-4 t) (x2 - 4 x1)(0)` from xhat = 0.
#[test]
fn an_input_in_the_output_is_taken_out() {
    let text = "[plant]\na = [[0, 1], [0, 0]]\nb = [[0], [1]]\nc = [[1, 0]]\nd = [[2]]\n[input]\nexpressions = [\"cos(2*t)\"]\n\
        [simulation]\nx0 = [1, -1]\nduration = 1\nsamples = 11\n[[observer]]\nname = \"o\"\nkind = \"reduced-order\"\npoles = [-4]\n";
    let study = read(text).unwrap();
    assert!(designed(&study).unwrap().report.statement.contains("y - D u = C x"));
    let folder = scratch("reduced-order-fed");
    execute(&study, Step::Run, &RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() }).unwrap();
    let csv = std::fs::read_to_string(folder.join("trajectories/o.csv")).unwrap();
    for line in csv.lines().skip(1) {
        let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let expected = -5.0 * (-4.0 * row[0]).exp();
        assert!((row[1] - row[5]).abs() < 1e-9 && (row[2] - row[6] - expected).abs() < 1e-7, "{row:?}");
    }
    extension(&sampled(&study, &study.observers[0], Some(0.01), None).unwrap());
}

#[test]
fn what_fails_is_named() {
    let text = |a: &str, c: &str, poles: &str| {
        format!("[plant]\na = {a}\nc = {c}\n[[observer]]\nkind = \"reduced-order\"\npoles = {poles}\n")
    };
    let wrong = |a: &str, c: &str, poles: &str| read(&text(a, c, poles)).unwrap_err().to_string();
    let pair = "[[0, 1], [0, 0]]";
    let said = wrong(pair, "[[1, 0]]", "[-1, -2]");
    assert!(said.contains("of 2 states the outputs leave 1"), "{said}");
    assert!(wrong(pair, "[[1, 0]]", "[1]").contains("left half plane"));
    assert!(
        wrong(pair, "[[1, 0], [0, 1]]", "[]").contains("no state is left")
            || wrong(pair, "[[1, 0], [0, 1]]", "[]").contains("poles")
    );
    match designed(&read(&text(pair, "[[0, 1]]", "[-1]")).unwrap()) {
        Err(failure) => {
            assert!(failure.hypothesis.contains("not observable"), "{}", failure.hypothesis);
        }
        other => panic!("{other:?}"),
    }
}
