//! `[frequency]`: responses of observers and of the loop, recovery, files and figures, and mistakes in it.

use luenberger_study::results::{Crossing, FrequencyReport, OpenedLoop};
use luenberger_study::{RunOptions, Step, execute};

use crate::studies::{executed, mistakes, scratch, study_in};

fn near(found: f64, expected: f64, relative: f64) -> bool {
    (found - expected).abs() <= relative * expected.abs()
}

fn report(text: &str) -> FrequencyReport {
    let results = executed(text, Step::Design);
    assert_eq!(results.failures(), Vec::<String>::new());
    results.frequency.unwrap()
}

/// The plant of Doyle and Stein, `(s + 2)/((s + 1)(s + 3))`, with their regulator and filter.
const DOYLE_AND_STEIN: &str = "[plant]\na = [[0, 1], [-3, -4]]\nb = [[0], [1]]\nc = [[2, 1]]\ntime_unit = \"s\"\n\
    [input]\nfeedback = { k = [[50, 10]], observer = \"filter\" }\n\
    [[observer]]\nname = \"filter\"\nkind = \"kalman\"\nw = [1]\ng = [[35], [-61]]\nv = 1\n";

fn crossing(found: Option<Crossing>, frequency: f64, margin: f64) {
    let found = found.unwrap();
    let (w, m) = (found.frequency.unwrap(), found.margin);
    assert!(near(w, frequency, 1e-7) && near(m, margin, 1e-7), "{found:?}");
}

/// Crossovers, angles and differences of scipy 1.17, as in the tests of `design::recovery`.
#[test]
fn margins_and_recovery_of_doyle_and_stein() {
    let text = format!("{DOYLE_AND_STEIN}[frequency]\nrecovery = [0, 10, 100, 1e4]\n");
    let found = report(&text).feedback.unwrap();
    let [inputs, outputs] = &found.opened[..] else { panic!("{found:?}") };
    assert_eq!([inputs.at, outputs.at], ["inputs", "outputs"]);
    crossing(inputs.channels[0].phase_margin, 12.615241644208238, 14.850631367099991);
    // One input and one output: the same loop on both sides.
    let phase = |opened: &OpenedLoop| opened.channels[0].phase_margin.unwrap().margin;
    assert!(near(phase(outputs), phase(inputs), 1e-9) && inputs.stable);
    assert_eq!((inputs.channels[0].channel.as_str(), outputs.channels[0].channel.as_str()), ("u1", "y1"));
    let expected = [
        (0.0, 4.769176480111589),
        (10.0, 3.406750267562773),
        (100.0, 0.13038666688851958),
        (1e4, 0.0009991018767749969),
    ];
    for (row, (q, difference)) in found.recovery.iter().zip(expected) {
        assert!(row.q == q && near(row.difference, difference, 1e-7), "{row:?}");
    }
    assert!(found.obstacle.is_none());

    // The key of the kind is the same filter.
    let text = format!("{DOYLE_AND_STEIN}recovery = 100\n[frequency]\n");
    let found = report(&text).feedback.unwrap();
    crossing(found.opened[0].channels[0].phase_margin, 11.165942328997689, 74.43965936530186);
}

/// The double integrator with poles at -2 and -5: from v to the first error `(7 s + 10)/(s^2 + 7 s + 10)`, whose square
/// `(49 t + 100)/(t^2 + 29 t + 100)` with `t = w^2` is the largest where `49 t^2 + 200 t = 2000`, and from v to the
/// second one `10 s/(s^2 + 7 s + 10)`, 10/7 at sqrt(10).
#[test]
fn noise_peaks_of_an_observer() {
    let text = "[plant]\na = [[0, 1], [0, 0]]\nb = [[0], [1]]\nc = [[1, 0]]\n[frequency]\nfrom = 0.1\nto = 100\n\
                [[observer]]\nkind = \"luenberger\"\npoles = [-2, -5]\n";
    let found = report(text);
    assert_eq!(found.range, [0.1, 100.0]);
    assert!(found.feedback.is_none());
    let [first, second] = &found.observers[0].noise_peaks[..] else { panic!("{found:?}") };
    let w = ((108_000f64.sqrt() - 100.0) / 49.0).sqrt();
    let peak = ((49.0 * w * w + 100.0) / ((10.0 - w * w).powi(2) + 49.0 * w * w)).sqrt();
    assert!(near(first.norm, peak, 1e-9) && near(first.frequency.unwrap(), w, 1e-4), "{first:?} {w} {peak}");
    let (norm, at) = (10.0 / 7.0, 10f64.sqrt());
    assert!(near(second.norm, norm, 1e-9) && near(second.frequency.unwrap(), at, 1e-4), "{second:?}");
}

/// In discrete time frequencies are per unit of time: half the period doubles them. scipy as in the tests of
/// `linalg::LoopMargins`.
#[test]
fn in_discrete_time() {
    for dt in [1.0, 0.5, 1e-12] {
        let text = format!(
            "[plant]\na = [[0.9, 0.2], [-0.1, 0.8]]\nb = [[0.1], [0.5]]\nc = [[1, 0]]\ndt = {dt}\n\
             [input]\nfeedback = {{ k = [[0.4, 0.6]], observer = \"o\" }}\n[frequency]\n\
             [[observer]]\nname = \"o\"\nkind = \"luenberger\"\ngain = [[0.9], [0.5]]\n"
        );
        let found = report(&text);
        assert!(near(found.range[1], std::f64::consts::PI / dt, 1e-12));
        let opened = &found.feedback.unwrap().opened[0];
        crossing(opened.channels[0].gain_margin, 0.8463706899875243 / dt, 7.234678678644739);
        assert!(opened.channels[0].phase_margin.is_none() && opened.channels[0].gain.len() == 1);
        let peak = opened.sensitivity.unwrap();
        assert!(
            near(peak.norm, 1.2041391961595382, 1e-9) && near(peak.frequency.unwrap(), 0.6280923352723162 / dt, 1e-4)
        );
    }
}

#[test]
fn files_figures_and_the_page() {
    let folder = scratch("frequency");
    let text = format!("title = \"a loop\"\n{DOYLE_AND_STEIN}[frequency]\npoints = 50\nrecovery = [0, 100]\n");
    let options = RunOptions { output: Some(folder.join("out").into()), ..RunOptions::default() };
    let results = execute(&study_in(&folder, &text), Step::Run, &options).unwrap();
    for name in ["frequency/filter.csv", "frequency/loop-inputs.csv", "frequency/loop-outputs.npz"] {
        assert!(results.files.iter().any(|file| file == name), "{name}: {:?}", results.files);
    }
    for id in ["frequency-observers", "frequency-loop-inputs", "frequency-loop-outputs", "recovery"] {
        assert!(results.files.contains(&format!("figures/{id}.svg")), "{id}: {:?}", results.files);
    }
    let page = std::fs::read_to_string(folder.join("out/report.html")).unwrap();
    for words in ["Frequency responses", "in radians per s", "Margins of the loop", "Loop transfer recovery"] {
        assert!(page.contains(words), "{words}");
    }
    // A row of the table by hand: at the first frequency w |(s I - A + L C)^-1 L| is in it with the digits of w.
    let table = std::fs::read_to_string(folder.join("out/frequency/loop-inputs.csv")).unwrap();
    let mut rows = table.lines();
    assert_eq!(rows.next().unwrap(), "w,largest_L,smallest_L,largest_S,smallest_S,largest_T,smallest_T,phase_L");
    let row: Vec<f64> = rows.next().unwrap().split(',').map(|x| x.parse().unwrap()).collect();
    let (l, angle) = (row[1], row[7].to_radians());
    let closed = nalgebra::Complex::new(1.0 + l * angle.cos(), l * angle.sin()).norm();
    assert!(near(row[3], 1.0 / closed, 1e-12) && near(row[5], l / closed, 1e-12), "{row:?}");
    // The loop of a double integrator lags by half a turn, not by minus that.
    let text = "[plant]\na = [[0, 1], [0, 0]]\nb = [[0], [1]]\nc = [[1, 0]]\n\
                [input]\nfeedback = { k = [[1, 2]], observer = \"o\" }\n[frequency]\nfrom = 1e-3\n\
                [[observer]]\nname = \"o\"\nkind = \"luenberger\"\npoles = [-2, -5]\n";
    let options = RunOptions { output: Some(folder.join("lag").into()), ..RunOptions::default() };
    execute(&study_in(&folder, text), Step::Run, &options).unwrap();
    let table = std::fs::read_to_string(folder.join("lag/frequency/loop-inputs.csv")).unwrap();
    let phase: f64 = table.lines().nth(1).unwrap().rsplit(',').next().unwrap().parse().unwrap();
    assert!((phase + 180.0).abs() < 1.0, "{phase}");
    let text = results.text(true);
    assert!(text.contains("Margins of the loop u = r - K xhat with the estimate of filter."), "{text}");
}

/// Of a plant that is not minimum phase, and of one with more inputs than outputs, the loop is not recovered.
#[test]
fn what_is_not_recovered_is_said() {
    let plant = "[plant]\na = [[0, 1], [0, 0]]\nb = [[0], [1]]\nc = [[1, -1]]\n\
                 [input]\nfeedback = { k = [[1, 2]], observer = \"o\" }\n\
                 [[observer]]\nname = \"o\"\nkind = \"kalman\"\nw = 1\nv = 1\nrecovery = 5\n";
    let results = executed(plant, Step::Design);
    let expected = "o: `recovery` does not bring the loop to that of state feedback: the plant is not minimum phase, it has a zero at 1";
    assert!(results.warnings.iter().any(|warning| warning == expected), "{:?}", results.warnings);
    let results = executed(&format!("{plant}[frequency]\nrecovery = [1]\n"), Step::Design);
    let report = results.frequency.unwrap().feedback.unwrap();
    assert_eq!(report.obstacle.as_deref(), Some("the plant is not minimum phase, it has a zero at 1"));
    let wide = "[plant]\na = [[0, 1], [0, 0]]\nb = [[1, 0], [0, 1]]\nc = [[1, 0]]\n\
                [[observer]]\nkind = \"kalman\"\nw = 1\nv = 1\nrecovery = 5\n";
    let warnings = executed(wide, Step::Design).warnings;
    assert!(warnings.iter().any(|warning| warning.contains("2 inputs and 1 output")), "{warnings:?}");
}

/// Observers that are not linear have no response, and the loop of a filter form is not computed.
#[test]
fn what_has_no_response() {
    let text = "[plant]\na = [[0.9, 0.1], [0, 0.8]]\nb = [[0], [1]]\nc = [[1, 0]]\ndt = 1\n\
                [input]\nfeedback = { k = [[0, 0.1]], observer = \"filter\" }\n[frequency]\n\
                [[observer]]\nname = \"filter\"\nkind = \"kalman\"\nform = \"filter\"\nw = 1\nv = 1\n\
                [[observer]]\nname = \"extended\"\nkind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 1\n";
    let results = executed(text, Step::Design);
    let found = results.frequency.unwrap();
    assert_eq!(found.observers.iter().map(|one| one.observer.as_str()).collect::<Vec<_>>(), ["filter"]);
    assert!(found.feedback.is_none());
    let warned = results.warnings.iter().any(|warning| warning.contains("no frequency response of the loop"));
    assert!(warned, "{:?}", results.warnings);
}

#[test]
fn mistakes_of_the_table() {
    let plant = "[plant]\na = [[0, 1], [0, 0]]\nb = [[0], [1]]\nc = [[1, 0]]\n";
    let observer = "[[observer]]\nname = \"o\"\nkind = \"luenberger\"\npoles = [-1, -2]\n";
    let feedback = "[input]\nfeedback = { k = [[1, 1]], observer = \"o\" }\n";
    for (text, expected) in [
        (format!("{plant}{observer}[frequency]\nfrom = 2\nto = 1\n"), "`to` is 1, and `from` is 2"),
        (format!("{plant}{observer}[frequency]\nfrom = 0\n"), "`from`"),
        (format!("{plant}{observer}[frequency]\npoints = 1\n"), "`points`"),
        (format!("{plant}{observer}[frequency]\nrecovery = [1]\n"), "`recovery` without a feedback of an estimate"),
        (format!("{plant}{feedback}{observer}[frequency]\nrecovery = [1]\n"), "`recovery` is for a Kalman filter"),
        (format!("{plant}{feedback}{observer}[frequency]\nrecovery = [-1]\n"), "recovery"),
        (
            format!("{plant}dt = 1\n[[observer]]\nkind = \"luenberger\"\npoles = [0, 0.1]\n[frequency]\nto = 4\n"),
            "dt = 1",
        ),
        (
            format!("{plant}dt = 1\n[[observer]]\nkind = \"kalman\"\nw = 1\nv = 1\nrecovery = 1\n"),
            "`recovery` is for plants in continuous time, and this one has dt = 1",
        ),
    ] {
        let found = mistakes(&text).iter().fold(String::new(), |all, one| all + &one.message + "\n");
        assert!(found.contains(expected), "{text}\n{found}");
    }
}
