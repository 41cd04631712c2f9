//! Numbers of an observer itself that are fitted: those that a key of its table holds, and the key with others.
//!
//! Poles are grouped in twos: conjugates, and real ones in their order; a single one may be left ([`Part`]).

use luenberger_wording::rounded;
use nalgebra::Complex;

use crate::reader::rows_of;
use crate::reader::tree::Node;
use crate::study::{Part, Tunable, Tuned};
use crate::tuning::Value;

/// Digits of a pole: its frequency and its damping ratio have fewer.
const DIGITS: usize = 10;

/// The numbers that a key holds, with their names; none if it holds something else.
pub(super) fn numbers(key: &str, node: &Node, dt: Option<f64>) -> Option<Vec<Tuned>> {
    let one = |part: Part, place: String, value: f64| {
        let what = Tunable::Own(key.to_owned(), part);
        Tuned { what, name: format!("{key}{place}"), value, bounds: None }
    };
    if key == "poles" {
        let poles = poles(node)?;
        let of = |group: &(usize, Option<usize>)| match *group {
            (i, None) => vec![one(Part::Rate(i), format!("[{}].rate", i + 1), -plane(poles[i], dt).re)],
            (i, Some(j)) => {
                let [frequency, damping] = frequency_and_damping(poles[i], poles[j], dt);
                let place = format!("[{},{}]", i + 1, j + 1);
                vec![
                    one(Part::Frequency(i, j), format!("{place}.frequency"), frequency),
                    one(Part::Damping(i, j), format!("{place}.damping"), damping),
                ]
            }
        };
        return Some(grouped(&poles).iter().flat_map(of).collect());
    }
    if let Some(x) = node.number() {
        return Some(vec![one(Part::Whole, String::new(), x)]);
    }
    if let Some(list) = node.numbers() {
        let entry = |(k, x): (usize, &f64)| one(Part::Entry(k), format!("[{}]", k + 1), *x);
        return Some(list.iter().enumerate().map(entry).collect());
    }
    let rows = rows_of(node)?;
    let cells = (0..rows.nrows()).flat_map(|i| (0..rows.ncols()).map(move |j| (i, j)));
    Some(cells.map(|(i, j)| one(Part::Cell(i, j), format!("[{},{}]", i + 1, j + 1), rows[(i, j)])).collect())
}

/// The value of a key with these numbers in place of its own.
pub(super) fn changed(key: &str, node: &Node, dt: Option<f64>, new: &[(Part, f64)]) -> Option<Value> {
    let of = |part: Part, own: f64| new.iter().find(|(other, _)| *other == part).map_or(own, |(_, x)| *x);
    if key == "poles" {
        let mut poles = poles(node)?;
        for group in grouped(&poles) {
            match group {
                (i, None) => poles[i] = back(Complex::from(-of(Part::Rate(i), -plane(poles[i], dt).re)), dt),
                (i, Some(j)) => {
                    let [frequency, damping] = frequency_and_damping(poles[i], poles[j], dt);
                    let roots = roots(of(Part::Frequency(i, j), frequency), of(Part::Damping(i, j), damping));
                    [poles[i], poles[j]] = roots.map(|s| back(s, dt));
                }
            }
        }
        let value = |pole: &Complex<f64>| {
            let [re, im] = [pole.re, pole.im].map(|x| rounded(x, DIGITS));
            if im == 0.0 { Value::Number(re) } else { Value::numbers([re, im]) }
        };
        return Some(Value::List(poles.iter().map(value).collect()));
    }
    if let Some(x) = node.number() {
        return Some(Value::Number(of(Part::Whole, x)));
    }
    if let Some(list) = node.numbers() {
        return Some(Value::numbers(list.iter().enumerate().map(|(k, x)| of(Part::Entry(k), *x))));
    }
    let mut rows = rows_of(node)?;
    for i in 0..rows.nrows() {
        for j in 0..rows.ncols() {
            rows[(i, j)] = of(Part::Cell(i, j), rows[(i, j)]);
        }
    }
    Some(Value::rows(&rows))
}

fn poles(node: &Node) -> Option<Vec<Complex<f64>>> {
    let pole = |node: &Node| match node.number() {
        Some(re) => Some(Complex::from(re)),
        None => node.numbers().filter(|pair| pair.len() == 2).map(|pair| Complex::new(pair[0], pair[1])),
    };
    node.list()?.iter().map(pole).collect()
}

/// Twos of poles, and a single one at the end.
fn grouped(poles: &[Complex<f64>]) -> Vec<(usize, Option<usize>)> {
    let (mut groups, mut free): (Vec<(usize, Option<usize>)>, Vec<usize>) = (Vec::new(), (0..poles.len()).collect());
    while let Some(&i) = free.iter().find(|i| poles[**i].im != 0.0) {
        // Without its conjugate the study would not have been read.
        let other = free.iter().copied().find(|j| *j != i && poles[*j] == poles[i].conj());
        free.retain(|k| *k != i && Some(*k) != other);
        groups.push((i, other));
    }
    groups.extend(free.chunks(2).map(|pair| (pair[0], pair.get(1).copied())));
    groups
}

/// A pole in the half plane of continuous time.
fn plane(pole: Complex<f64>, dt: Option<f64>) -> Complex<f64> {
    dt.map_or(pole, |dt| (pole - 1.0) / (pole + 1.0) * (2.0 / dt))
}

/// The pole of a point of that plane.
fn back(s: Complex<f64>, dt: Option<f64>) -> Complex<f64> {
    dt.map_or(s, |dt| (s * (0.5 * dt) + 1.0) / (-s * (0.5 * dt) + 1.0))
}

fn frequency_and_damping(one: Complex<f64>, other: Complex<f64>, dt: Option<f64>) -> [f64; 2] {
    let (a, b) = (plane(one, dt), plane(other, dt));
    let frequency = (a * b).re.sqrt();
    [frequency, -(a + b).re / (2.0 * frequency)]
}

/// The roots of `s^2 + 2 damping frequency s + frequency^2`.
fn roots(frequency: f64, damping: f64) -> [Complex<f64>; 2] {
    let real = -damping * frequency;
    if damping < 1.0 {
        let imaginary = frequency * ((1.0 - damping) * (1.0 + damping)).sqrt();
        return [Complex::new(real, imaginary), Complex::new(real, -imaginary)];
    }
    let fast = real - frequency * ((damping - 1.0) * (damping + 1.0)).sqrt();
    [Complex::from(fast), Complex::from(frequency * frequency / fast)]
}
