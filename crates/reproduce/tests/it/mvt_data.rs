//! The sixteen runs of the mean-value-theorem paper: the files exist, and their numbers are accurate to 1e-8.
//!
//! The reference is independent: the right-hand sides are written out by hand, with the mean slope in closed form where
//! the runs search for beta, and the integrator is the implicit one.

use luenberger_reproduce::{papers, run_papers};
use luenberger_sim::{Integrator, Settings, solve};
use std::collections::HashMap;
use std::fs;
use std::path::PathBuf;

/// Mean over the segment from d to d + delta of `s(d) = e^d / (0.1 + e^d)`, the slope of ln(0.1 + e^d).
fn mean_slope(d: f64, delta: f64) -> f64 {
    let s = d.exp() / (0.1 + d.exp());
    if delta.abs() < 1e-9 { s } else { (s * delta.exp_m1()).ln_1p() / delta }
}

/// Mean of the cosine between x and x + e: `(sin(x + e) - sin x)/e = cos(x + e/2) sin(e/2)/(e/2)`.
fn mean_cosine(x: f64, e: f64) -> f64 {
    let half = e / 2.0;
    (x + half).cos() * if half.abs() < 1e-9 { 1.0 } else { half.sin() / half }
}

type Plant = fn(f64, &[f64]) -> Vec<f64>;
type MeanJacobian = fn(&[f64], &[f64]) -> Vec<Vec<f64>>;

fn chaotic(_: f64, x: &[f64]) -> Vec<f64> {
    vec![(0.1 + (x[1] - x[0]).exp()).ln(), x[0] * x[2], 0.2 - x[0] * x[1]]
}

fn chaotic_mean(x: &[f64], e: &[f64]) -> Vec<Vec<f64>> {
    let s = mean_slope(x[1] - x[0], e[1] - e[0]);
    let m: Vec<f64> = x.iter().zip(e).map(|(x, e)| x + e / 2.0).collect();
    vec![vec![-s, s, 0.0], vec![m[2], 0.0, m[0]], vec![-m[1], -m[0], 0.0]]
}

fn joint(t: f64, x: &[f64], a44: f64) -> Vec<f64> {
    vec![
        x[1],
        -48.6 * x[0] - 1.25 * x[1] + 48.6 * x[2] + 21.6 * t.sin(),
        x[3],
        19.5 * x[0] - 19.5 * x[2] + a44 * x[3] - 3.33 * x[2].sin(),
    ]
}

fn joint_mean(x: &[f64], e: &[f64], a44: f64) -> Vec<Vec<f64>> {
    vec![
        vec![0.0, 1.0, 0.0, 0.0],
        vec![-48.6, -1.25, 48.6, 0.0],
        vec![0.0, 0.0, 0.0, 1.0],
        vec![19.5, 0.0, -19.5 - 3.33 * mean_cosine(x[2], e[2]), a44],
    ]
}

struct Experiment {
    name: &'static str,
    f: Plant,
    mean: MeanJacobian,
    measured: usize,
    x: &'static [f64],
    xhat: &'static [f64],
    e0: &'static [f64],
    e01: &'static [f64],
    end: f64,
}

const EXPERIMENTS: [Experiment; 4] = [
    Experiment {
        name: "mvt-ex1",
        f: chaotic,
        mean: chaotic_mean,
        measured: 2,
        x: &[-2.0, -1.0, -1.0],
        xhat: &[-1.0, -0.5, -1.5],
        e0: &[-1.0, -0.5, 0.5],
        e01: &[-1.0, -0.5, 0.2],
        end: 10.0,
    },
    Experiment {
        name: "mvt-ex2",
        f: |t, x| joint(t, x, 0.0),
        mean: |x, e| joint_mean(x, e, 0.0),
        measured: 3,
        x: &[3.0, 3.0, 3.0, 3.0],
        xhat: &[1.0, 2.0, 0.5, 1.0],
        e0: &[2.0, 1.0, 2.5, 2.0],
        e01: &[2.0, 1.0, 2.5, 2.5],
        end: 10.0,
    },
    Experiment {
        name: "mvt-ex2-classical",
        f: |t, x| joint(t, x, 0.0),
        mean: |x, e| joint_mean(x, e, 0.0),
        measured: 2,
        x: &[3.0, 3.0, 3.0, 3.0],
        xhat: &[1.0, 2.0, 0.5, 1.0],
        e0: &[2.0, 1.0, 2.5, 2.0],
        e01: &[2.0, 1.0, 2.5, 2.5],
        end: 10.0,
    },
    Experiment {
        name: "mvt-ex2-printed",
        f: |t, x| joint(t, x, 3.33),
        mean: |x, e| joint_mean(x, e, 3.33),
        measured: 3,
        x: &[3.0, 3.0, 3.0, 3.0],
        xhat: &[1.0, 2.0, 0.5, 1.0],
        e0: &[2.0, 1.0, 2.5, 2.0],
        e01: &[2.0, 1.0, 2.5, 2.5],
        end: 2.0,
    },
];

impl Experiment {
    /// x, xhat and e at `times` (0 excluded).
    fn reference(&self, eta: f64, e0: &[f64], times: &[f64]) -> Vec<Vec<f64>> {
        let n = self.x.len();
        let right_hand_side = |t: f64, state: &[f64], slope: &mut [f64]| {
            let (x, xhat, e) = (&state[..n], &state[n..2 * n], &state[2 * n..]);
            let d = (self.mean)(xhat, e);
            slope[..n].copy_from_slice(&(self.f)(t, x));
            let copy = (self.f)(t, xhat);
            for k in 0..n {
                // (6): row and column, the diagonal twice.
                let alpha: f64 = (0..n).map(|j| d[k][j].abs() + d[j][k].abs()).sum();
                let e1 = if k < self.measured { x[k] - xhat[k] } else { e[k] };
                slope[n + k] = copy[k] + eta * alpha * e1;
                slope[2 * n + k] = (0..n).map(|j| d[k][j] * e[j]).sum::<f64>() - eta * alpha * e[k];
            }
        };
        let settings = Settings { integrator: Integrator::Implicit, rtol: 1e-11, atol: 1e-12, ..Settings::default() };
        let mut state = [self.x, self.xhat, e0].concat();
        let mut from = 0.0;
        // From time to time, so that the dense output of the implicit method is not asked.
        times
            .iter()
            .map(|&t| {
                state = solve(right_hand_side, from, t, &state, &settings).unwrap().at(t).unwrap();
                from = t;
                state.clone()
            })
            .collect()
    }
}

fn columns(path: &PathBuf) -> (Vec<String>, HashMap<String, Vec<f64>>) {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let mut found: HashMap<String, Vec<f64>> = HashMap::new();
    for record in reader.records() {
        for (name, entry) in names.iter().zip(&record.unwrap()) {
            found.entry(name.clone()).or_default().push(entry.parse().unwrap());
        }
    }
    (names, found)
}

/// beta solves the one row that is not linear or a product: at every sample what is left of X is rounding of terms that
/// are 50 times the states at most; and the other rows have 1/2.
fn check_beta(id: &str, n: usize, data: &HashMap<String, Vec<f64>>) {
    for (k, t) in data["t"].iter().enumerate() {
        let at = |name: &str| data[name][k];
        let size = (1..=n).map(|i| at(&format!("x{i}_hat")).abs() + at(&format!("e{i}")).abs()).sum::<f64>();
        let rounding = 16.0 * f64::EPSILON * 50.0 * (1.0 + size);
        let (row, left) = if n == 3 {
            let (d, delta) = (at("x2_hat") - at("x1_hat"), at("e2") - at("e1"));
            let there = d + at("beta1") * delta;
            (1, delta * (there.exp() / (0.1 + there.exp()) - mean_slope(d, delta)))
        } else {
            let (x, e) = (at("x3_hat"), at("e3"));
            (4, 3.33 * e * ((x + at("beta4") * e).cos() - mean_cosine(x, e)))
        };
        assert!(left.abs() <= rounding, "{id}, t = {t}: X = {left}, rounding {rounding}");
        for other in (1..=n).filter(|&other| other != row) {
            assert_eq!(at(&format!("beta{other}")), 0.5, "{id}, t = {t}");
        }
    }
}

#[test]
fn the_sixteen_runs_are_written_and_good_to_eight_decimals() {
    let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("mvt-data");
    let _ = fs::remove_dir_all(&out);
    // The data alone: claims and figures have their own tests.
    let mut papers = papers();
    papers.retain(|paper| paper.key == "mvt");
    for paper in &mut papers {
        paper.claims.clear();
        paper.figures.clear();
        paper.findings.clear();
    }
    let summary = run_papers(&papers, &out).unwrap();
    assert!(summary.is_complete(), "{:?}", summary.failures);

    for experiment in &EXPERIMENTS {
        let n = experiment.x.len();
        let times: Vec<f64> = [0.1, 0.5, 1.0, 2.0, 5.0, 10.0].into_iter().filter(|&t| t <= experiment.end).collect();
        for eta in [1, 2] {
            for (given, e0) in [("e0", experiment.e0), ("e01", experiment.e01)] {
                let id = format!("{}-eta{eta}-{given}", experiment.name);
                let (names, data) = columns(&out.join("data").join(format!("{id}.csv")));
                let numbered =
                    |before: &'static str, after: &'static str| (1..=n).map(move |i| format!("{before}{i}{after}"));
                let expected: Vec<String> = std::iter::once("t".to_owned())
                    .chain(numbered("x", ""))
                    .chain(numbered("x", "_hat"))
                    .chain(numbered("e", ""))
                    .chain(numbered("beta", ""))
                    .collect();
                assert_eq!(names, expected, "{id}");
                assert!(data["t"].windows(2).all(|pair| pair[0] < pair[1]), "{id}");
                assert_eq!((data["t"][0], data["t"].last()), (0.0, Some(&experiment.end)), "{id}");
                for beta in numbered("beta", "") {
                    assert!(data[&beta].iter().all(|beta| (0.0..=1.0).contains(beta)), "{id} {beta}");
                }
                check_beta(&id, n, &data);
                let reference = experiment.reference(f64::from(eta), e0, &times);
                for (t, state) in times.iter().zip(&reference) {
                    let row =
                        data["t"].iter().position(|found| found == t).unwrap_or_else(|| panic!("{id}: no t = {t}"));
                    for (name, expected) in names[1..=3 * n].iter().zip(state) {
                        let found = data[name][row];
                        assert!((found - expected).abs() < 1e-8, "{id}, {name} at {t}: {found} and {expected}");
                    }
                }
            }
        }
    }
}
