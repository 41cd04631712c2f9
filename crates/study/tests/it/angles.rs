//! States and outputs that are angles: the same estimates and errors as of readings that go on beyond a turn.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::path::Path;

use luenberger_random::Random;
use luenberger_study::{Results, RunOptions, Step, execute};

use crate::studies::{self, designed, filters, mistakes_of, read, scratch, study, study_in};

fn run(folder: &Path, text: &str, step: Step) -> Results {
    let options = RunOptions { output: Some(folder.join("out").into()), threads: Some(1), ..RunOptions::default() };
    let results = execute(&study_in(folder, text), step, &options).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(results.failures(), Vec::<String>::new());
    results
}

/// A column of the trajectory of an observer on a log.
fn column(folder: &Path, observer: &str, name: &str) -> Vec<f64> {
    let file = folder.join(format!("out/trajectories/log-{observer}.csv"));
    let text = std::fs::read_to_string(file).unwrap();
    let mut lines = text.lines();
    let at = lines.next().unwrap().split(',').position(|title| title == name).unwrap_or_else(|| panic!("{name}"));
    lines.map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

/// An angle in (-pi, pi], by its sine and cosine.
fn principal(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}

/// A plant that turns five times in 40 s from 170 degrees on, with a compass of 2 degrees, in units of `unit` per
/// radian; every 50th reading is off by 100 degrees. `wraps` is of the compass and of the true heading.
fn log(folder: &Path, unit: f64, wraps: bool) {
    let mut random = Random(11);
    let mut csv = "t,compass,gyro,heading_true,rate_true\n".to_owned();
    for k in 0..400 {
        let t = 0.1 * f64::from(k);
        let rate = 0.8 + 0.1 * (0.3 * t).sin();
        let heading = 2.967 + 0.8 * t + (1.0 - (0.3 * t).cos()) / 3.0;
        let outlier = if k % 50 == 49 { 1.75 } else { 0.0 };
        let [first, second] = random.normal_pair();
        let compass = heading + outlier + 0.035 * first;
        let gyro = rate + 0.02 * second;
        let of = |angle: f64| unit * if wraps { principal(angle) } else { angle };
        _ = writeln!(csv, "{t},{},{},{},{}", of(compass), unit * gyro, of(heading), unit * rate);
    }
    std::fs::write(folder.join("log.csv"), csv).unwrap();
}

/// All filters on that log, with these keys of [plant].
fn turning(unit: f64, keys: &str) -> String {
    let square = unit * unit;
    let mut text = format!(
        "[plant]\nstates = [\"heading\", \"rate\"]\noutputs = [\"compass\", \"gyro\"]\nf = [\"rate\", \"0\"]\nh = [\"heading\", \"rate\"]\n{keys}\n[log]\nfile = \"log.csv\"\nstates = [\"heading_true\", \"rate_true\"]\n"
    );
    for kind in filters() {
        let gate = if kind == "mhe" { "window = 6\n" } else { "gate = 5\nsmooth = true\n" };
        _ = write!(
            text,
            "[[observer]]\nname = \"{kind}\"\nkind = \"{kind}\"\ninitial = [{}, 0]\nw = [{}, {}]\nv = [{}, {}]\np0 = [{}, {}]\nperiod = 0.1\n{gate}",
            unit * 2.9,
            1e-6 * square,
            1e-3 * square,
            0.035f64.powi(2) * square,
            4e-4 * square,
            0.1 * square,
            square
        );
    }
    text
}

/// The errors of the heading of each filter on its log, and its NEES.
fn errors(results: &Results) -> Vec<(String, f64, f64)> {
    let rows = &results.log.as_ref().unwrap().rows;
    let of = |row: &luenberger_study::results::InnovationReport| {
        (row.observer.clone(), row.errors[0].rmse, row.nees.as_ref().map_or(f64::NAN, |nees| nees.mean))
    };
    rows.iter().map(of).collect()
}

/// Every filter with wrapped readings and a wrapped truth has the estimates of the same filter with unwrapped ones,
/// whichever of the two names is given; in degrees they are those in radians.
#[test]
fn filters_of_a_compass_are_those_of_unwrapped_readings() {
    let degrees = "units = { heading = \"deg\", compass = \"deg\", rate = \"deg/s\", gyro = \"deg/s\" }\n";
    let exact = scratch("angles/unwrapped");
    log(&exact, 1.0, false);
    let expected = errors(&run(&exact, &turning(1.0, ""), Step::Run));
    assert_eq!(expected.len(), filters().len());
    for (name, unit, keys) in [
        ("state", 1.0, "angles = [\"heading\"]".to_owned()),
        ("output", 1.0, "angles = [\"compass\"]".to_owned()),
        ("degrees", 180.0 / PI, format!("{degrees}angles = [\"heading\", \"compass\"]")),
    ] {
        let folder = scratch(&format!("angles/{name}"));
        log(&folder, unit, true);
        let found = errors(&run(&folder, &turning(unit, &keys), Step::Run));
        for ((kind, rmse, nees), (_, found_rmse, found_nees)) in expected.iter().zip(&found) {
            // The outliers are rejected by all but the window.
            assert!(*rmse < if kind == "mhe" { 0.4 } else { 0.03 }, "{kind}: {rmse}");
            assert!((found_rmse / unit - rmse).abs() < 1e-9, "{name} {kind}: {found_rmse} {rmse}");
            assert!((found_nees - nees).abs() < 1e-6 * nees, "{name} {kind}: {found_nees} {nees}");
            let smoothed: &[&str] = if kind == "mhe" { &[] } else { &["heading_smoothed"] };
            for title in ["heading_hat"].iter().chain(smoothed) {
                let (a, b) = (column(&exact, kind, title), column(&folder, kind, title));
                for (k, (a, b)) in a.iter().zip(&b).enumerate() {
                    let apart = principal(a - b / unit).abs();
                    assert!(apart < 1e-9, "{name} {kind} {title}, row {k}: {a} {b}");
                }
            }
        }
    }
    // Without the key the estimates are a turn off, and so are the errors.
    let folder = scratch("angles/without");
    log(&folder, 1.0, true);
    let wrong = errors(&run(&folder, &turning(1.0, ""), Step::Run));
    assert!(wrong.iter().all(|(_, rmse, _)| *rmse > 1.0), "{wrong:?}");
}

/// A ship that passes a radar on the west, where its bearing jumps, and has a position from time to time: in
/// coordinates turned by half a turn the bearing has no jump, and the estimates are the same, turned.
#[test]
fn a_radar_does_not_see_where_its_bearing_jumps() {
    let make = |folder: &Path, side: f64, keys: &str| {
        let mut random = Random(5);
        let mut csv = "t,east,north,range,bearing,east_true,north_true,vx_true,vy_true\n".to_owned();
        for k in 0..120 {
            let t = 0.5 * f64::from(k);
            let (east, north) = (-5.0 + 0.02 * t, 1.2 - 0.04 * t);
            let ([a, b], [c, d]) = (random.normal_pair(), random.normal_pair());
            let (x, y) = (side * east, side * north);
            // The lidar measures every third time, the radar at the others.
            let lidar = k % 3 == 0;
            let cell = |of: bool, value: f64| if of { value.to_string() } else { String::new() };
            let noisy = y.atan2(x) + 0.06 * d;
            let cells = [
                cell(lidar, side * (east + 0.15 * a)),
                cell(lidar, side * (north + 0.15 * b)),
                cell(!lidar, x.hypot(y) + 0.05 * c),
                cell(!lidar, noisy.sin().atan2(noisy.cos())),
            ];
            _ = writeln!(csv, "{t},{},{x},{y},{},{}", cells.join(","), side * 0.02, side * -0.04);
        }
        std::fs::write(folder.join("log.csv"), csv).unwrap();
        let mut text = format!(
            "[plant]\nstates = [\"px\", \"py\", \"vx\", \"vy\"]\noutputs = [\"east\", \"north\", \"range\", \"bearing\"]\nf = [\"vx\", \"vy\", \"0\", \"0\"]\nh = [\"px\", \"py\", \"sqrt(px^2 + py^2)\", \"atan2(py, px)\"]\n{keys}\n[log]\nfile = \"log.csv\"\nstates = [\"east_true\", \"north_true\", \"vx_true\", \"vy_true\"]\n"
        );
        for kind in filters() {
            _ = write!(
                text,
                "[[observer]]\nname = \"{kind}\"\nkind = \"{kind}\"\ninitial = [{}, {}, 0, 0]\nw = [0, 0, 1e-5, 1e-5]\nv = [0.0225, 0.0225, 0.0025, 3.6e-3]\np0 = [0.25, 0.25, 0.04, 0.04]\nperiod = 0.5\n",
                side * -4.6,
                side * 1.5
            );
        }
        text
    };
    let (west, east, without) = (scratch("angles/west"), scratch("angles/east"), scratch("angles/jump"));
    let found = errors(&run(&west, &make(&west, 1.0, "angles = [\"bearing\"]"), Step::Run));
    let expected = errors(&run(&east, &make(&east, -1.0, ""), Step::Run));
    let wrong = errors(&run(&without, &make(&without, 1.0, ""), Step::Run));
    for (k, (kind, rmse, _)) in expected.iter().enumerate() {
        assert!(*rmse < 0.12, "{kind}: {rmse}");
        assert!((found[k].1 - rmse).abs() < 1e-9, "{kind}: {} {rmse}", found[k].1);
        assert!(wrong[k].1 > 5.0 * rmse, "{kind}: {} {rmse}", wrong[k].1);
        for (state, title) in [("px", "px_hat"), ("vy", "vy_hat")] {
            let (a, b) = (column(&west, kind, title), column(&east, kind, title));
            assert!(a.iter().zip(&b).all(|(a, b)| (a + b).abs() < 1e-8), "{kind} {state}");
        }
    }
}

/// A plant in discrete time whose f and h wrap: scores, NIS and NEES of its simulation are those of the plant that
/// goes on beyond a turn.
#[test]
fn simulations_that_wrap_have_the_scores_of_those_that_do_not() {
    let text = |wrapped: bool| {
        let of = |expression: &str| if wrapped { format!("wrap({expression})") } else { expression.to_owned() };
        let keys = if wrapped { "angles = [\"heading\"]\n" } else { "" };
        let mut text = format!(
            "[plant]\nstates = [\"heading\", \"rate\"]\noutputs = [\"compass\", \"gyro\"]\nf = [\"{}\", \"0.99*rate\"]\nh = [\"{}\", \"rate\"]\ndt = 0.1\n{keys}[simulation]\nx0 = [3.1, 2]\nduration = 10\nnoise = {{ distribution = \"gaussian\", amplitude = [0.05, 0.02], period = 0.1, seed = 3 }}\n",
            of("heading + 0.1*rate"),
            of("heading")
        );
        for kind in filters() {
            _ = write!(
                text,
                "[[observer]]\nname = \"{kind}\"\nkind = \"{kind}\"\ninitial = [2.9, 0]\nw = [1e-6, 1e-4]\nv = [2.5e-3, 4e-4]\np0 = [0.1, 1]\nperiod = 0.1\n"
            );
        }
        // An output that is wrapped is named: it is no state.
        if wrapped { text.replace("[\"heading\"]\n[sim", "[\"heading\", \"compass\"]\n[sim") } else { text }
    };
    let [exact, wrapped] = [false, true].map(|wrapped| {
        let folder = scratch(&format!("angles/simulated-{wrapped}"));
        serde_json::to_value(run(&folder, &text(wrapped), Step::Run)).unwrap()
    });
    let scores = |results: &serde_json::Value| {
        let filters = results["filters"].as_array().unwrap();
        let mut all: Vec<f64> = filters.iter().map(|row| row["nees"]["mean"].as_f64().unwrap()).collect();
        all.extend(filters.iter().map(|row| row["nis"]["mean"].as_f64().unwrap()));
        for row in results["simulation"]["rows"].as_array().unwrap() {
            for state in row["merits"]["states"].as_array().unwrap() {
                all.extend(["rmse", "peak", "last"].map(|score| state[score].as_f64().unwrap()));
            }
        }
        all
    };
    let (expected, found) = (scores(&exact), scores(&wrapped));
    assert_eq!(expected.len(), (2 + 2 * 3) * filters().len());
    for (k, (expected, found)) in expected.iter().zip(&found).enumerate() {
        assert!((expected - found).abs() <= 1e-7 * (1.0 + expected.abs()), "score {k}: {found} {expected}");
    }
}

/// Kinds that inject y - h(xhat) as it is are refused for angles among the outputs, and not for states alone.
#[test]
fn kinds_that_do_not_wrap_say_so() {
    let text = |keys: &str| {
        format!(
            "[plant]\na = [[0, 1], [-1, -1]]\nc = [[1, 0]]\nstates = [\"heading\", \"rate\"]\noutputs = [\"compass\"]\n{keys}\n[[observer]]\nkind = \"luenberger\"\npoles = [-1, -2]\n"
        )
    };
    let refused = designed(&study(&text("angles = [\"heading\"]"))).unwrap_err();
    let said = refused.to_string();
    assert!(said.contains("compass is an angle, and the kind luenberger takes the difference"), "{said}");
    assert!(designed(&study(&text(""))).is_ok());
    // The rate alone is measured.
    assert!(designed(&study(&text("angles = [\"heading\"]").replace("[[1, 0]]", "[[0, 1]]"))).is_ok());
    let bounded = "[plant]\nf = [\"wrap(x1 + x2)\", \"x2\"]\nh = [\"x1\"]\ndt = 1\nangles = [\"x1\"]\n[[observer]]\nkind = \"mhe\"\nw = 1\nv = 1\nperiod = 1\nstate_bounds = [[-1, 1], [-inf, inf]]\n";
    let said = designed(&study(bounded)).unwrap_err().to_string();
    assert!(said.contains("`state_bounds` bounds x1, an angle"), "{said}");
    assert!(designed(&study(&bounded.replace("[-1, 1], [-inf, inf]", "[-inf, inf], [-1, 1]"))).is_ok());
}

#[test]
fn mistakes_of_angles_are_named() {
    let said = |keys: &str| {
        let text = format!(
            "[plant]\nstates = [\"heading\"]\noutputs = [\"compass\"]\nf = [\"0\"]\nh = [\"heading\"]\n{keys}\n"
        );
        mistakes_of(&text, read(&text)).iter().map(|mistake| mistake.message.clone()).collect::<Vec<_>>().join("; ")
    };
    assert_eq!(said("angles = [\"course\"]"), "the plant has no state or output `course`");
    let unit = said("angles = [\"heading\"]\nunits = { heading = \"m\" }");
    assert_eq!(unit, "`heading` has the unit m, which is none of an angle");
    let both = said("angles = [\"heading\", \"compass\"]\nunits = { heading = \"rad\", compass = \"deg\" }");
    assert_eq!(both, "`compass` is `heading`, and their units are those of other angles");
    // The turns of the units.
    for (unit, turn) in [("rad", TAU), ("mrad", 1e3 * TAU), ("deg", 360.0), ("gon", 400.0), ("rev", 1.0)] {
        let text = format!(
            "[plant]\nstates = [\"heading\"]\nf = [\"0\"]\nh = [\"2*heading\"]\nangles = [\"heading\"]\nunits = {{ heading = \"{unit}\" }}\n[[observer]]\nkind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 1\n"
        );
        let plant = studies::study(&text).plant;
        assert_eq!(plant.turns_of(&plant.states), Some(vec![turn]));
        // Twice the angle is not the angle.
        assert_eq!(plant.turns_of(&plant.outputs), None);
    }
}
