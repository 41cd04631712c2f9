//! Runs one routine at a time, of this project or of another Rust crate, as requested on standard input; one JSON
//! object per request and reply.
//!
//! ```text
//! {"do": "load", "name": "a", "rows": 2, "cols": 2, "file": "a.bin"}        columns of f64, in the order of this machine
//! {"do": "run", "who": "luenberger", "routine": "lyapunov", "times": 100}   {"ms": of one call} or {"error": ".."}
//! {"do": "keep", "who": .., "routine": .., "file": "p.bin"}                 {"shapes": [[2, 2]]}: the answer's matrices, one after the other
//! {"do": "peak", "n": 1000}                                                 {"gigaflops": of a product of that order}
//! ```
//! Only the call is timed; its arguments are prepared before, and its result is dropped after.
//!
//! With the path of the same program of an earlier version as its argument it compares the two instead: see
//! `against.rs`.

mod against;

use faer::{Mat, MatRef};
use luenberger_linalg as ours;
use nalgebra::{Complex, DMatrix};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::hint::black_box;
use std::io::{BufRead, Write};
use std::time::Instant;

type Data = HashMap<String, DMatrix<f64>>;
type Answer = Result<Vec<DMatrix<f64>>, String>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    if let Some(earlier) = std::env::args().nth(1) {
        let largest = std::env::args().nth(2).map_or(Ok(100), |text| text.parse())?;
        return against::compare(&earlier, largest);
    }
    let mut data = Data::new();
    for line in std::io::stdin().lock().lines() {
        let request: Value = serde_json::from_str(&line?)?;
        let word = |key: &str| request[key].as_str().unwrap_or_default();
        let number = |key: &str| request[key].as_u64().unwrap_or(1) as usize;
        let reply = match word("do") {
            "load" => {
                let bytes = std::fs::read(word("file"))?;
                let numbers = bytes.chunks_exact(8).map(|b| f64::from_ne_bytes(b.try_into().expect("eight bytes")));
                data.insert(word("name").to_owned(), DMatrix::from_iterator(number("rows"), number("cols"), numbers));
                json!({})
            }
            "run" => time(&data, word("who"), word("routine"), number("times")),
            "keep" => match call(&data, word("who"), word("routine")) {
                Ok(matrices) => {
                    let bytes: Vec<u8> = matrices.iter().flat_map(|m| m.iter().flat_map(|x| x.to_ne_bytes())).collect();
                    std::fs::write(word("file"), bytes)?;
                    json!({"shapes": matrices.iter().map(|m| [m.nrows(), m.ncols()]).collect::<Vec<_>>()})
                }
                Err(why) => json!({"error": why}),
            },
            "peak" => json!({"gigaflops": peak(number("n"))}),
            other => json!({"error": format!("what is {other:?}?")}),
        };
        println!("{reply}");
        std::io::stdout().flush()?;
    }
    Ok(())
}

fn time(data: &Data, who: &str, routine: &str, times: usize) -> Value {
    let start = Instant::now();
    for _ in 0..times {
        if let Err(why) = black_box(call(data, who, routine)) {
            return json!({"error": why});
        }
    }
    json!({"ms": start.elapsed().as_secs_f64() * 1e3 / times as f64})
}

/// Poles travel as a matrix of two columns, real and imaginary parts.
fn poles(data: &Data) -> Vec<Complex<f64>> {
    data["poles"].row_iter().map(|row| Complex::new(row[0], row[1])).collect()
}

fn call(data: &Data, who: &str, routine: &str) -> Answer {
    let a = &data["a"];
    match who {
        "luenberger" => call_ours(data, routine).map_err(|why| why.to_string()),
        "nalgebra" if routine == "schur" => {
            // It has no cap of its own; this one is ten times what LAPACK allows.
            let limit = 300 * a.nrows().max(1);
            let form = nalgebra::Schur::try_new(a.clone(), f64::EPSILON, limit).ok_or("does not converge")?;
            let (q, t) = form.unpack();
            Ok(vec![q, t])
        }
        "deimos_numerics" => call_deimos(data, routine),
        _ => Err(format!("{who} has no {routine}")),
    }
}

fn call_ours(data: &Data, routine: &str) -> Result<Vec<DMatrix<f64>>, ours::LinalgError> {
    let (a, get) = (&data["a"], |name: &str| &data[name]);
    Ok(match routine {
        "schur" => {
            let form = ours::schur(a)?;
            vec![form.q, form.t]
        }
        "lyapunov" => vec![ours::lyapunov(a, get("q"))?.p],
        "lyapunov-again" => vec![ours::LyapunovEquation::new(a)?.solve(get("q"))?.p],
        "dlyap" => vec![ours::stein(a, get("q"))?.p],
        "sylvester" => vec![ours::sylvester(a, get("b"), get("c"))?.x],
        "care" => vec![ours::care(a, get("b"), get("q"), get("r"))?.x],
        "place" => vec![ours::place(a, get("b"), &poles(data))?.gain],
        "eigenvalues" => vec![DMatrix::from_element(1, 1, ours::eigenvalues(a)?.len() as f64)],
        "lyapunov-factor" => vec![ours::lyapunov_factor(a, get("c"))?.u],
        "generalized-lyapunov" => vec![ours::generalized_lyapunov(a, get("e"), get("q"))?.p],
        "dare" => vec![ours::dare(a, get("b"), get("q"), get("r"))?.x],
        "generalized-care" => vec![ours::generalized_care(a, get("b"), get("q"), get("r"), get("s"), get("e"))?.x],
        "kalman" => vec![ours::kalman_gain(a, get("c"), get("q"), get("r"))?.l],
        "exponential" => vec![ours::expm(a)?],
        "hold" => vec![ours::zero_order_hold(a, get("b"), 0.1)?.bd],
        "tustin" => vec![converted(data, ours::Discretization::Tustin)?],
        "first-order-hold" => vec![converted(data, ours::Discretization::FirstOrderHold)?],
        "logarithm" => vec![ours::logm(&(DMatrix::identity(a.nrows(), a.nrows()) + a * 0.05))?],
        "noise" => vec![ours::discrete_process_noise(a, get("q"), 0.1)?],
        "h2-norm" => vec![DMatrix::from_element(1, 1, ours::h2_norm(a, get("b"), get("c"))?)],
        "h-infinity-norm" => {
            vec![DMatrix::from_element(1, 1, ours::h_infinity_norm(a, get("b"), get("c"), get("d"))?.norm)]
        }
        "observability" => vec![DMatrix::from_element(1, 1, ours::observability(a, get("c"))?.rank as f64)],
        "zeros" => {
            let found = ours::invariant_zeros(a, get("b"), get("c"), &(get("d") * 0.0))?;
            vec![DMatrix::from_element(1, 1, found.zeros.len() as f64)]
        }
        "decomposition" => vec![ours::kalman_decomposition(a, get("b"), get("c"))?.a],
        _ => Vec::new(),
    })
}

fn converted(data: &Data, method: ours::Discretization) -> Result<DMatrix<f64>, ours::LinalgError> {
    let system = ours::Realization::new(&data["a"], &data["b"], &data["c"], &data["d"])?;
    Ok(ours::c2d(&system, 0.1, method)?.b)
}

fn seen(m: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(m.as_slice(), m.nrows(), m.ncols())
}

fn back(m: MatRef<'_, f64>) -> DMatrix<f64> {
    DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)])
}

/// Its equations are those with `A X + X A'`: the transpose of A goes in.
fn call_deimos(data: &Data, routine: &str) -> Answer {
    use deimos_numerics::control::matrix_equations as peer;
    use deimos_numerics::control::synthesis;
    let (a, get) = (&data["a"], |name: &str| seen(&data[name]));
    let text = |why: &dyn std::fmt::Debug| format!("{why:?}");
    let transposed = seen(a).transpose();
    let answer = match routine {
        "lyapunov" => peer::solve_continuous_lyapunov_dense(transposed, get("q")).map_err(|e| text(&e))?.solution,
        "dlyap" => peer::solve_discrete_stein_dense(transposed, get("q")).map_err(|e| text(&e))?.solution,
        "care" => {
            peer::solve_care_dense(seen(a), get("b"), get("q"), get("r")).map_err(|e| text(&e))?.solution
        }
        "place" => {
            let specified: Vec<_> = poles(data).iter().map(|p| faer::c64::new(p.re, p.im)).collect();
            synthesis::place_poles_dense(seen(a), get("b"), &specified).map_err(|e| text(&e))?.gain
        }
        _ => return Err(format!("deimos_numerics has no {routine}")),
    };
    Ok(vec![back(answer.as_ref())])
}

/// Of the fastest product here, one thread: the best of five.
fn peak(n: usize) -> f64 {
    let a = Mat::from_fn(n, n, |i, j| ((i + 3 * j) as f64).sin());
    let mut c = Mat::<f64>::zeros(n, n);
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        faer::linalg::matmul::matmul(c.as_mut(), faer::Accum::Replace, a.as_ref(), a.as_ref(), 1.0, faer::Par::Seq);
        best = best.min(start.elapsed().as_secs_f64());
    }
    black_box(c);
    2.0 * (n as f64).powi(3) / best / 1e9
}
