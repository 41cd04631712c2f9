//! Times the joint design of the cubic observer in (P, Y = P L, S with Z = P N = -C'S) on random plants, one JSON line
//! each.
//!
//! `cargo run --release -p luenberger-lmi --features clarabel --example bench_joint -- [--write DIR] [--largest N]`.
//! Without the feature, only the solver of this project is timed. With `--write`, the plants are also written to
//! `DIR/plant-N.json`, for other tools to solve the same ones.

use std::error::Error;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

use luenberger_lmi::{LmiError, Problem, Settings, Solution, Solver, he};
use luenberger_random::Random;
use nalgebra::DMatrix;

/// States, outputs, and how often to solve: the fastest run counts.
const SIZES: [(usize, usize, usize, Plant); 6] = [
    (3, 1, 20, plant),
    (6, 2, 10, plant),
    (10, 2, 5, plant),
    (20, 3, 4, plant),
    (50, 3, 1, plant),
    (60, 3, 1, flexible),
];
type Plant = fn(usize, usize) -> (DMatrix<f64>, DMatrix<f64>);
const SEED: u64 = 2024;

fn main() -> Result<(), Box<dyn Error>> {
    let mut write: Option<PathBuf> = None;
    let mut largest = usize::MAX;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let value = arguments.next().ok_or(format!("{argument} needs a value"))?;
        match argument.as_str() {
            "--write" => write = Some(value.into()),
            "--largest" => largest = value.parse()?,
            _ => return Err(format!("unknown argument {argument}; known: --write DIR, --largest N").into()),
        }
    }
    for (n, p, runs, plant) in SIZES.into_iter().filter(|&(n, ..)| n <= largest) {
        let (a, c) = plant(n, p);
        if let Some(folder) = &write {
            std::fs::create_dir_all(folder)?;
            let text = format!("{{\"n\":{n},\"p\":{p},\"seed\":{SEED},\"a\":{},\"c\":{}}}\n", nested(&a), nested(&c));
            std::fs::write(folder.join(format!("plant-{n}.json")), text)?;
        }
        let solvers = [("luenberger", Solver::Interior), ("luenberger+clarabel", Solver::Clarabel)];
        for (tool, solver) in solvers.into_iter().filter(|(_, solver)| solver.require().is_ok()) {
            // Minutes for one that does not use the structure.
            if n > 20 && solver == Solver::Clarabel {
                continue;
            }
            let mut fastest = f64::INFINITY;
            let mut last = None;
            for _ in 0..runs {
                let start = Instant::now();
                let (solution, p) = design(&a, &c, solver)?;
                fastest = fastest.min(start.elapsed().as_secs_f64() * 1e3);
                last = Some((solution, p.symmetric_eigenvalues().max()));
            }
            if let Some((solution, largest)) = last {
                // For P of norm 1, as for the other tools.
                let margin = solution.verdict.margin().map_or("null".to_owned(), |m| format!("{:e}", m / largest));
                println!(
                    "{{\"tool\":\"{tool}\",\"n\":{n},\"p\":{p},\"ms\":{fastest:.3},\"iterations\":{},\"verdict\":\"{}\",\"margin\":{margin}}}",
                    solution.effort.iterations,
                    solution.verdict.word()
                );
            }
        }
    }
    Ok(())
}

/// P > 0, P < I, A'P + PA - YC - C'Y' < 0, S + S' > 0: built, solved and proved, all of it timed.
fn design(a: &DMatrix<f64>, c: &DMatrix<f64>, solver: Solver) -> Result<(Solution, DMatrix<f64>), LmiError> {
    let (n, m) = (a.nrows(), c.nrows());
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", n);
    let y = lmi.rectangular("Y", n, m);
    let s = lmi.rectangular("S", m, m);
    lmi.constrain("P > 0", &p >> 0.0);
    lmi.constrain("P < I", &p << 1.0);
    lmi.constrain("decrease", he(&p * a - &y * c) << 0.0);
    lmi.constrain("accretive", he(&s) >> 0.0);
    let solution = lmi.solve_with(&Settings { solver, ..Settings::default() })?;
    let p = solution.value(&p);
    Ok((solution, p))
}

/// A and C with entries uniform in [-1, 1).
fn plant(n: usize, p: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let mut random = Random(SEED.wrapping_add(n as u64));
    (random.matrix(n, n), random.matrix(p, n))
}

/// A beam with `n / 2` lightly damped modes, `q'' + 2 zeta w_k q' + w_k^2 q = 0` with zeta = 0.005 and w_k = k, in the
/// states `(w_k q, q')`, and p sensors of displacement.
fn flexible(n: usize, p: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let mut a = DMatrix::zeros(n, n);
    let mut c = DMatrix::zeros(p, n);
    for k in 0..n / 2 {
        let w = (k + 1) as f64;
        (a[(2 * k, 2 * k + 1)], a[(2 * k + 1, 2 * k)], a[(2 * k + 1, 2 * k + 1)]) = (w, -w, -0.01 * w);
        for sensor in 0..p {
            let place = 0.137 + 0.31 * sensor as f64;
            c[(sensor, 2 * k)] = (std::f64::consts::PI * w * place).sin();
        }
    }
    (a, c)
}

/// A matrix as nested JSON lists, row by row; Rust prints the shortest digits that read back the same.
fn nested(m: &DMatrix<f64>) -> String {
    let mut text = String::from("[");
    for (i, row) in m.row_iter().enumerate() {
        let entries: Vec<String> = row.iter().map(|x| format!("{x:?}")).collect();
        let _ = write!(text, "{}[{}]", if i > 0 { "," } else { "" }, entries.join(","));
    }
    text.push(']');
    text
}
