//! Two versions of this program on the same matrices, in turn, sample by sample: the ratio of their least times, which
//! other work on the machine disturbs least.

use crate::{Data, time};
use nalgebra::{Complex, DMatrix};
use serde_json::{Value, json};
use std::error::Error;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

const ROUTINES: [&str; 23] = [
    "schur", "eigenvalues", "lyapunov", "lyapunov-factor", "generalized-lyapunov", "dlyap", "sylvester", "care", "dare",
    "generalized-care", "kalman", "place", "exponential", "hold", "first-order-hold", "tustin", "logarithm", "noise",
    "h2-norm", "h-infinity-norm", "observability", "zeros", "decomposition",
];
const ORDERS: [usize; 5] = [4, 10, 30, 100, 300];
const KINDS: [&str; 3] = ["random", "scaled", "defective"];
/// Samples of each, and the milliseconds that the calls of one fill at least.
const SAMPLES: usize = 25;
const FILLED: f64 = 0.3;
/// Slower routines have fewer samples: this many milliseconds in all.
const BUDGET: f64 = 2000.0;
/// A slowdown beyond this is marked.
const ALLOWED: f64 = 1.05;

/// The earlier version, as a process.
struct Earlier {
    _process: Child,
    requests: ChildStdin,
    replies: BufReader<ChildStdout>,
}

impl Earlier {
    fn ask(&mut self, request: &Value) -> Result<Value, Box<dyn Error>> {
        writeln!(self.requests, "{request}")?;
        let mut reply = String::new();
        self.replies.read_line(&mut reply)?;
        Ok(serde_json::from_str(&reply)?)
    }
}

/// Prints a table; orders up to `largest`.
pub(crate) fn compare(earlier: &str, largest: usize) -> Result<(), Box<dyn Error>> {
    let mut process = Command::new(earlier).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
    let (Some(requests), Some(replies)) = (process.stdin.take(), process.stdout.take()) else {
        return Err("the earlier version has no pipes".into());
    };
    let mut earlier = Earlier { _process: process, requests, replies: BufReader::new(replies) };
    let file = std::env::temp_dir().join(format!("linalg-bench-{}.bin", std::process::id()));
    println!("| routine | n | matrix | earlier, ms | ratio | |\n|---|---:|---|---:|---:|---|");
    for n in ORDERS.into_iter().filter(|n| *n <= largest) {
        for kind in KINDS {
            for routine in ROUTINES {
                let data = problem(kind, n, routine);
                for (name, m) in &data {
                    let bytes: Vec<u8> = m.iter().flat_map(|x| x.to_ne_bytes()).collect();
                    std::fs::write(&file, bytes)?;
                    let (rows, cols) = m.shape();
                    earlier.ask(&json!({"do": "load", "name": name, "rows": rows, "cols": cols, "file": file}))?;
                }
                println!("{}", line(&mut earlier, &data, routine, (n, kind))?);
            }
        }
    }
    std::fs::remove_file(&file)?;
    Ok(())
}

/// A row of the table.
fn line(earlier: &mut Earlier, data: &Data, routine: &str, (n, kind): (usize, &str)) -> Result<String, Box<dyn Error>> {
    let mut then = |times: usize| {
        let who = "luenberger";
        earlier.ask(&json!({"do": "run", "who": who, "routine": routine, "times": times}))
    };
    let now = |times: usize| time(data, "luenberger", routine, times);
    let head = format!("| {routine} | {n} | {kind} |");
    let (Some(once), Some(_)) = (then(1)?["ms"].as_f64(), now(1)["ms"].as_f64()) else {
        let failed = |reply: &Value| if reply["error"].is_null() { "solved" } else { "refused" };
        return Ok(format!("{head} {} | {} | |", failed(&then(1)?), failed(&now(1))));
    };
    let times = ((FILLED / once.max(1e-5)) as usize).clamp(1, 2000);
    let samples = ((BUDGET / (once * times as f64)) as usize).clamp(3, SAMPLES);
    let (mut first, mut second) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..samples {
        first = first.min(then(times)?["ms"].as_f64().unwrap_or(f64::INFINITY));
        second = second.min(now(times)["ms"].as_f64().unwrap_or(f64::INFINITY));
    }
    let ratio = second / first;
    Ok(format!("{head} {first:.3e} | {ratio:.2} | {} |", if ratio > ALLOWED { "slower" } else { "" }))
}

/// Numbers between -1 and 1 that are the same everywhere.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn matrix(&mut self, rows: usize, columns: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |_, _| self.next())
    }
}

/// A stable plant with its weights: random, in units of the states eight decades apart, or with Jordan blocks of order
/// five. In discrete time A is scaled into the unit circle.
fn problem(kind: &str, n: usize, routine: &str) -> Data {
    let mut numbers = Numbers(88_172_645_463_325_252 + n as u64);
    let m = (n / 2).clamp(1, 3);
    let mut a = numbers.matrix(n, n) * (3.0 / n as f64).sqrt();
    let poles = |a: &DMatrix<f64>| luenberger_linalg::eigenvalues(a).unwrap_or_default();
    let top = poles(&a).iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max);
    a -= DMatrix::identity(n, n) * (top + 0.1);
    if kind == "defective" {
        let jordan = DMatrix::from_fn(n, n, |i, j| match j {
            _ if i == j => -1.0 - (i / 5) as f64 * 0.37,
            _ if j == i + 1 && j % 5 != 0 => 1.0,
            _ => 0.0,
        });
        let turn = numbers.matrix(n, n).qr().q();
        a = &turn * jordan * turn.transpose();
    }
    let (mut b, mut c, g) = (numbers.matrix(n, m), numbers.matrix(m, n), numbers.matrix(n, n));
    if kind == "scaled" {
        let unit: Vec<f64> = (0..n).map(|_| (13.0 * numbers.next()).round().exp2()).collect();
        a = DMatrix::from_fn(n, n, |i, j| a[(i, j)] * unit[i] / unit[j]);
        b = DMatrix::from_fn(n, m, |i, j| b[(i, j)] * unit[i]);
        c = DMatrix::from_fn(m, n, |i, j| c[(i, j)] / unit[j]);
    }
    if ["dlyap", "dare"].contains(&routine) {
        a *= 0.95 / poles(&a).iter().map(|pole: &Complex<f64>| pole.norm()).fold(0.0, f64::max);
    }
    let poles = DMatrix::from_fn(n, 2, |i, j| if j == 0 { -1.0 - i as f64 / n as f64 } else { 0.0 });
    let (q, e) = (&g * g.transpose() / n as f64 + DMatrix::identity(n, n), DMatrix::identity(n, n) + &g * (0.3 / n as f64));
    if routine == "sylvester" {
        (b, c) = (a.transpose(), g);
    }
    let r = DMatrix::identity(m, m);
    let all = [("a", a), ("b", b), ("c", c), ("q", q), ("e", e), ("r", r), ("poles", poles)];
    let more = [("s", DMatrix::zeros(n, m)), ("d", DMatrix::zeros(m, m))];
    all.into_iter().chain(more).map(|(name, m)| (name.to_owned(), m)).collect()
}
