//! The curves of the figures in a report: those of the trajectories, which are read from their files.

use std::path::{Path, PathBuf};

use luenberger_study::{RunOptions, Step, execute};
use serde_json::Value;

use crate::studies::{scratch, study_in};

/// A curve of a figure, or the outline of a band.
struct Curve {
    label: String,
    name: String,
    points: Vec<(f64, f64)>,
}

/// The numbers of a curve: multiples of a step, by the differences of their counts; logarithms of some.
fn numbers(of: &Value) -> Vec<Option<f64>> {
    let (step, log) = (of["of"].as_f64().unwrap(), of["log"] == true);
    let mut count = 0;
    let mut one = |by: &Value| {
        count += by.as_i64()?;
        let x = count as f64 * step;
        Some(if log { 10f64.powf(x) } else { x })
    };
    of["by"].as_array().unwrap().iter().map(&mut one).collect()
}

/// The figures of a report with their captions, the curves of each in their order.
fn figures(folder: &Path) -> Vec<(String, Vec<Curve>)> {
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    let pictures: Value = serde_json::from_slice(&luenberger_figures::unpacked(&page, "pictures").unwrap()).unwrap();
    let one = |(id, figure): (&String, &Value)| {
        let data = figure["data"].as_array().unwrap();
        let curves = data.iter().map(|curve| {
            let axis = curve["yaxis"].as_str().unwrap().replace('y', "yaxis");
            let title = &figure["layout"][&axis]["title"]["text"];
            let x = curve["x"].as_u64().map_or(&curve["x"], |first| &data[first as usize]["x"]);
            let points = numbers(x).into_iter().zip(numbers(&curve["y"]));
            Curve {
                label: title.as_str().unwrap().to_owned(),
                name: curve["name"].as_str().unwrap().to_owned(),
                points: points.filter_map(|(x, y)| Some((x?, y?))).collect(),
            }
        });
        (id.clone(), curves.collect())
    };
    pictures.as_object().unwrap().iter().map(one).collect()
}

/// The columns of a table by their names, NaN where a cell is empty.
struct Columns(Vec<String>, Vec<Vec<f64>>);

impl Columns {
    fn read(folder: &Path, name: &str) -> Self {
        let text = std::fs::read_to_string(folder.join(format!("trajectories/{name}.csv"))).unwrap();
        let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        Self(
            text.lines().next().unwrap().split(',').map(str::to_owned).collect(),
            text.lines().skip(1).map(row).collect(),
        )
    }

    fn of(&self, name: &str) -> Vec<f64> {
        let place = self.0.iter().position(|column| column == name).unwrap_or_else(|| panic!("{name}: {:?}", self.0));
        self.1.iter().map(|row| row[place]).collect()
    }
}

/// Each point of a curve is one of the rows, to the resolution of the figure, and the first and the last row are among
/// them.
#[track_caller]
fn is_curve(curve: &Curve, t: &[f64], values: &[f64]) {
    let span = |values: &[f64]| {
        let finite = || values.iter().copied().filter(|x| x.is_finite());
        finite().fold(f64::NEG_INFINITY, f64::max) - finite().fold(f64::INFINITY, f64::min)
    };
    // Axes reach over the other curves too, and their step is a ten thousandth.
    let resolution = 3e-3 * span(values) + 1e-3 * values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let near = |x: f64, y: f64| {
        t.iter().zip(values).any(|(t, value)| (t - x).abs() <= 2e-3 && (value - y).abs() <= resolution)
    };
    for (x, y) in &curve.points {
        assert!(near(*x, *y), "{} of {}: ({x}, {y})", curve.name, curve.label);
    }
    let rows: Vec<usize> = (0..t.len()).filter(|k| values[*k].is_finite()).collect();
    for k in [rows[0], rows[rows.len() - 1]] {
        let there = curve.points.iter().any(|(x, y)| (x - t[k]).abs() < 2e-3 && (y - values[k]).abs() <= resolution);
        assert!(there, "{} of {}: row {k} is missing", curve.name, curve.label);
    }
}

fn run(name: &str, csv: &str, text: &str) -> PathBuf {
    let folder = scratch(&format!("pictures/{name}"));
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    let options = RunOptions { output: Some(folder.join("out").into()), ..RunOptions::default() };
    execute(&study_in(&folder, text), Step::Run, &options).unwrap_or_else(|error| panic!("{error}"));
    folder.join("out")
}

const PLANT: &str = r#"
[plant]
a = [[0, 1], [-2, -0.5]]
b = [[0], [1]]
c = [[1, 0]]
states = ["x", "v"]
inputs = ["f"]
outputs = ["y"]
time_unit = "s"
units = { x = "m", f = "N", y = "V" }
"#;

const OBSERVERS: &str = r#"
[[observer]]
name = "gain"
kind = "luenberger"
poles = [-3, -4]
[[observer]]
name = "filter"
kind = "extended-kalman"
w = [0, 0.1]
v = 0.01
p0 = [1, 1]
period = 0.1
"#;

const SIMULATION: &str = r#"
[input]
expressions = ["sin(t)"]
[simulation]
x0 = [1, -0.5]
duration = 4
samples = 41
hold = 0.1
scale = [2, 4]
noise = { amplitude = [0.05], period = 0.1, seed = 3 }
[plot]
show = ["states", "errors", "error-norm", "inputs", "outputs", "innovations"]
"#;

/// Of both sides of a band.
fn sides(curve: &Curve) -> (Vec<f64>, Vec<f64>) {
    let half = curve.points.len() / 2;
    let ys = |points: &[(f64, f64)]| points.iter().map(|point| point.1).collect::<Vec<_>>();
    (ys(&curve.points[..half]), ys(&curve.points[half..]))
}

#[test]
fn the_curves_of_a_simulation_are_its_trajectories() {
    let folder = run("simulation", "", &format!("{PLANT}{OBSERVERS}{SIMULATION}"));
    let figures = figures(&folder);
    let names: Vec<&str> = figures.iter().map(|(id, _)| id.as_str()).collect();
    let mut expected = ["states", "errors", "error-norm", "inputs", "outputs", "innovations"];
    expected.sort_unstable();
    let mut sorted = names.clone();
    sorted.sort_unstable();
    sorted.retain(|id| expected.contains(id));
    assert_eq!(sorted, expected, "{names:?}");
    let of = |id: &str| &figures.iter().find(|(name, _)| name == id).unwrap().1;
    let (gain, filter) = (Columns::read(&folder, "gain"), Columns::read(&folder, "filter"));
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>();
    for (state, label) in [("x", "x (m)"), ("v", "v")] {
        let find = |id: &str, label: &str, name: &str| {
            let found = of(id).iter().find(|curve| curve.label == label && curve.name == name);
            found.unwrap_or_else(|| panic!("{name} of {label} in {id}"))
        };
        is_curve(find("states", label, "plant"), &gain.of("t"), &gain.of(state));
        for (name, columns) in [("gain", &gain), ("filter", &filter)] {
            let (t, hat) = (columns.of("t"), columns.of(&format!("{state}_hat")));
            is_curve(find("states", label, name), &t, &hat);
            let error = apart(&columns.of(state), &hat);
            is_curve(find("errors", &format!("error of {label}"), name), &t, &error);
        }
        let (t, sigma, hat) =
            (filter.of("t"), filter.of(&format!("{state}_2sigma")), filter.of(&format!("{state}_hat")));
        for (id, label, centre) in
            [("states", label.to_owned(), hat.clone()), ("errors", format!("error of {label}"), vec![0.0; hat.len()])]
        {
            let band = find(id, &label, "filter \u{b1} 2 sigma");
            let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
            let most = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let ends: Vec<(f64, f64)> = centre.iter().zip(&sigma).map(|(x, s)| (x - s, x + s)).collect();
            let (low, high): (Vec<f64>, Vec<f64>) = ends.into_iter().unzip();
            let found: Vec<f64> = band.points.iter().map(|point| point.1).collect();
            let size = most(&high) - least(&low);
            assert!((least(&found) - least(&low)).abs() < 5e-3 * size, "{label}");
            assert!((most(&found) - most(&high)).abs() < 5e-3 * size, "{label}");
            let (one, other) = sides(band);
            assert!(one.len() > 2 && other.len() > 2 && t.len() == 41);
        }
    }
    let norm: Vec<f64> = {
        let of = |state: &str| apart(&gain.of(state), &gain.of(&format!("{state}_hat")));
        of("x").iter().zip(of("v")).map(|(x, v)| (x / 2.0).hypot(v / 4.0)).collect()
    };
    let curve = of("error-norm").iter().find(|curve| curve.name == "gain").unwrap();
    assert_eq!(curve.label, "|e| in units of scale");
    is_curve(curve, &gain.of("t"), &norm);
    for (id, label, column) in [("inputs", "f (N)", "f"), ("outputs", "y (V)", "y")] {
        let [curve] = &of(id)[..] else { panic!("{id}") };
        assert_eq!((curve.label.as_str(), curve.name.as_str()), (label, column));
        is_curve(curve, &gain.of("t"), &gain.of(column));
    }
    let innovation = of("innovations").iter().find(|curve| curve.name == "gain").unwrap();
    assert_eq!(innovation.label, "innovation of y (V)");
    is_curve(innovation, &gain.of("t"), &apart(&gain.of("y"), &gain.of("x_hat")));
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    for caption in [
        "The states of the plant, and their estimates. Shaded: two standard deviations of a filter to either side, by its covariance P.",
        "The errors e = x - xhat; those of sampled observers at their samples. Shaded: ",
        "The measured outputs, with the noise of seed 3.",
        "a straight line is an exponential.",
        "What each observer did not expect of the outputs, y - h(xhat)",
    ] {
        assert!(page.contains(caption), "{caption}");
    }
}

/// The window, the states and the observers that are chosen; a window without a sample shows all.
#[test]
fn a_plot_shows_what_is_chosen() {
    let chosen = |name: &str, window: &str| {
        let plot = format!("[plot]\nshow = [\"errors\"]\nstates = [\"v\"]\nobservers = [\"gain\"]\n{window}");
        let folder = run(name, "", &format!("{PLANT}{OBSERVERS}{}{plot}", SIMULATION.split("[plot]").next().unwrap()));
        let figures = figures(&folder);
        let (_, curves) = figures.into_iter().find(|(id, _)| id == "errors").unwrap();
        let [curve, insets @ ..] = &curves[..] else { panic!("no curve") };
        assert_eq!((curve.label.as_str(), curve.name.as_str()), ("error of v", "gain"));
        // The whole of it in the corner, where its beginning is larger by far.
        assert!(insets.len() < 2 && insets.iter().all(|inset| inset.label.is_empty() && inset.name == "gain"));
        (curve.points[0].0, curve.points[curve.points.len() - 1].0)
    };
    let near = |found: (f64, f64), expected: (f64, f64)| {
        assert!((found.0 - expected.0).abs() < 2e-3 && (found.1 - expected.1).abs() < 2e-3, "{found:?}");
    };
    near(chosen("window", "from = 1\nto = 2.5\n"), (1.0, 2.5));
    near(chosen("from", "from = 3.95\nto = 3.99\n"), (0.0, 4.0));
}

/// Measurement noise up to 0.01 and a first error of 1: the axis is that of the noise, with the whole in the corner. An
/// error that decays for all of the run has no steady part.
#[test]
fn errors_have_the_axis_of_their_steady_part() {
    let insets = |name: &str, noise: &str| {
        let simulation = format!("[simulation]\nx0 = [1, 0]\nduration = 10\nsamples = 401\n{noise}");
        let observer = "[[observer]]\nkind = \"luenberger\"\npoles = [-2, -3]\n";
        let folder = run(name, "", &format!("{PLANT}{observer}{simulation}"));
        let (_, curves) = figures(&folder).into_iter().find(|(id, _)| id == "errors").unwrap();
        curves.iter().filter(|curve| curve.label.is_empty()).count()
    };
    let noise = "noise = { amplitude = [0.01], period = 0.05, seed = 3 }\n";
    assert_eq!((insets("steady", noise), insets("decaying", "")), (2, 0));
}

/// The observers along a sweep of the first estimate: settling times and steady errors that are those of `sweep.csv`,
/// each with its curve, the front that no other is better than, and an axis with room at both ends. None without noise.
#[test]
fn the_points_of_a_front_are_those_of_the_sweep() {
    let text = |noise: &str| {
        let slow = "[[observer]]\nname = \"slow\"\nkind = \"luenberger\"\npoles = [-1, -1.5]\n";
        let simulation = format!("[simulation]\nx0 = [1, 0]\nduration = 12\nscale = [1, 1]\n{noise}");
        let sweep = "[sweep]\nparameter = \"initial\"\nvalues = [0.5, 1]\nensemble = 2\n";
        let observer = "[[observer]]\nname = \"fast\"\nkind = \"luenberger\"\npoles = [-4, -5]\n";
        format!("{PLANT}{observer}{slow}{simulation}{sweep}")
    };
    let quiet = run("no-front", "", &text(""));
    assert!(figures(&quiet).iter().all(|(id, _)| id != "sweep-pareto"));
    let folder = run("front", "", &text("noise = { amplitude = [0.01], period = 0.05, seed = 3 }\n"));
    let (_, curves) = figures(&folder).into_iter().find(|(id, _)| id == "sweep-pareto").unwrap();
    let names: Vec<&str> = curves.iter().map(|curve| curve.name.as_str()).collect();
    assert_eq!(names, ["Pareto front", "fast", "slow"]);
    let results: Value = serde_json::from_slice(&std::fs::read(folder.join("study.json")).unwrap()).unwrap();
    let rows = results["sweep"]["rows"].as_array().unwrap();
    let mut all: Vec<(f64, f64)> = Vec::new();
    for curve in &curves[1..] {
        let of = rows.iter().filter(|row| row["observer"] == curve.name.as_str());
        let expected: Vec<(f64, f64)> =
            of.map(|row| (row["settling"].as_f64().unwrap(), row["steady_rms"].as_f64().unwrap())).collect();
        assert_eq!(curve.points.len(), 2, "{}", curve.name);
        for ((x, y), (speed, error)) in curve.points.iter().zip(&expected) {
            assert!((x - speed).abs() < 2e-3 * speed && (y - error).abs() < 2e-3 * error, "{}: {x} {y}", curve.name);
        }
        all.extend(expected);
    }
    let better = |(a, b): &(f64, f64), (c, d): &(f64, f64)| c <= a && d <= b && (c < a || d < b);
    let mut front: Vec<(f64, f64)> =
        all.iter().filter(|one| !all.iter().any(|other| better(one, other))).copied().collect();
    front.sort_by(|one, other| one.0.total_cmp(&other.0));
    assert_eq!(curves[0].points.len(), front.len());
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    let pictures: Value = serde_json::from_slice(&luenberger_figures::unpacked(&page, "pictures").unwrap()).unwrap();
    let range: Vec<f64> = pictures["sweep-pareto"]["layout"]["xaxis"]["range"]
        .as_array()
        .unwrap_or_else(|| panic!("{}", pictures["sweep-pareto"]["layout"]))
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect();
    let speeds = || all.iter().map(|point| point.0);
    let (low, high) = (speeds().fold(f64::INFINITY, f64::min), speeds().fold(0.0, f64::max));
    let room = 0.06 * (high - low);
    assert!(
        (range[0] - (low - room)).abs() < 1e-4 && (range[1] - (high + room)).abs() < 1e-4,
        "{range:?} {low} {high}"
    );
}

/// The curves of a frequency response are twenty logarithms of the magnitudes in its table, and the phases in it.
#[test]
fn curves_of_responses_are_their_numbers() {
    let folder = run("response", "", &format!("{PLANT}{OBSERVERS}[frequency]\nfrom = 0.1\nto = 100\npoints = 40\n"));
    let (_, curves) = figures(&folder).into_iter().find(|(id, _)| id == "frequency-observers").unwrap();
    let labels: Vec<&str> = curves.iter().map(|curve| curve.label.as_str()).collect();
    assert_eq!(labels, ["y to x (dB)", "y to x, phase (degrees)", "y to v (dB)", "y to v, phase (degrees)"]);
    let text = std::fs::read_to_string(folder.join("frequency/gain.csv")).unwrap();
    let names: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    for (curve, column) in curves.iter().zip(["magnitude_x_y", "phase_x_y", "magnitude_v_y", "phase_v_y"]) {
        let place = names.iter().position(|name| *name == column).unwrap_or_else(|| panic!("{column} in {names:?}"));
        let rows = || {
            text.lines().skip(1).map(|line| {
                let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
                (cells[0], cells[place])
            })
        };
        // Points between two others on a line are left out.
        assert!(curve.points.len() > 15, "{column}: {:?}", curve.points);
        for (w, found) in &curve.points {
            let (_, value) = rows().find(|(at, _)| (at / w - 1.0).abs() < 1e-3).unwrap_or_else(|| panic!("{w}"));
            let expected = if column.starts_with("magnitude") { 20.0 * value.log10() } else { value };
            assert!((found - expected).abs() < 0.05, "{column} at {w}: {found}, expected {expected}");
        }
    }
}

/// A log with a gap of six periods, whose curves are in two parts, with the true values of one state.
#[test]
fn the_curves_of_a_log_end_at_its_gaps() {
    let row = |k: u32| {
        let t = 0.1 * f64::from(k) + if k < 20 { 0.0 } else { 0.6 };
        format!("{t},0,{},{}\n", t.cos(), t.cos())
    };
    let csv = format!("t,f,y,truth\n{}", (0..40).map(row).collect::<String>());
    let log = "[log]\nfile = \"log.csv\"\nstates = [\"truth\", \"-\"]\n";
    let folder = run("log", &csv, &format!("{PLANT}{OBSERVERS}{log}"));
    let figures = figures(&folder);
    let filter = Columns::read(&folder, "log-filter");
    let parts = |id: &str, label: &str, name: &str| -> Vec<(f64, f64)> {
        let (_, curves) = figures.iter().find(|(found, _)| found.ends_with(id)).unwrap_or_else(|| panic!("{id}"));
        let of = curves.iter().filter(|curve| curve.label == label && curve.name == name);
        of.map(|curve| (curve.points[0].0, curve.points[curve.points.len() - 1].0)).collect()
    };
    for (id, label, name) in [
        ("states", "x (m)", "truth"),
        ("states", "x (m)", "filter"),
        ("states", "v", "filter"),
        ("errors", "error of x (m)", "filter"),
        ("innovations", "innovation of y (V)", "gain"),
    ] {
        let found = parts(id, label, name);
        assert_eq!(found.len(), 2, "{name} of {label}: {found:?}");
        for ((from, to), expected) in found.iter().zip([(0.0, 1.9), (2.6, 4.5)]) {
            assert!((from - expected.0).abs() < 2e-3 && (to - expected.1).abs() < 2e-3, "{name} of {label}: {found:?}");
        }
    }
    assert_eq!((parts("states", "v", "truth").len(), parts("errors", "error of v", "filter").len()), (0, 0));
    assert_eq!(filter.of("t").len(), 40);
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(page.contains("The estimates on the log, and the true states."), "{page}");
}
