//! Meaningful changes of a certificate: of its numbers, matrices, lists, dimensions and text, in any place.

use luenberger_proof::certificate::{CertificateFile, Fault};
use luenberger_random::Random;
use serde_json::Value;

use super::document::{float, hexadecimal};
use super::stream;

/// Members that are not data.
const FRAME: [&str; 7] = ["format", "version", "title", "theorem", "statement", "margins", "sha256"];

/// Formats of numbers, and regions, of which there are more than a reader can list.
const FORMATS: [&str; 6] = ["binary32", "binary64", "Q4.28", "Q14.30", "Q8.8", "Q2.14"];
const REGIONS: [&str; 6] = ["everywhere", "0x1p0", "0x1p10", "0x1p-10", "0x1p40", "0x1p80"];

/// The words that the reader of the theorem takes at this place.
fn known_words(document: &Value, path: &str) -> Option<Vec<String>> {
    let mut unknown = document.clone();
    *unknown.pointer_mut(path)? = Value::from("?");
    match CertificateFile::read(unknown.to_string().as_bytes()).err()?.fault {
        Fault::Word { known, .. } => Some(known.split('"').skip(1).step_by(2).map(str::to_owned).collect()),
        _ => None,
    }
}

/// Positions in a document, as JSON pointers.
#[derive(Debug, Default)]
struct Map {
    numbers: Vec<String>,
    bounds: Vec<String>,
    matrices: Vec<String>,
    lists: Vec<String>,
    words: Vec<String>,
    counts: Vec<String>,
}

fn is_number(value: &Value) -> bool {
    value.as_str().is_some_and(|text| float(text).is_some() || super::document::number(text).is_some())
}

fn is_datum(value: &Value) -> bool {
    is_number(value) || is_bounds(value)
}

fn is_bounds(value: &Value) -> bool {
    value.as_array().is_some_and(|ends| ends.len() == 2 && ends.iter().all(is_number))
}

fn is_matrix(value: &Value) -> bool {
    let rows = value.as_array().map_or(&[][..], Vec::as_slice);
    let is_row = |row: &Value| row.as_array().is_some_and(|row| !row.is_empty() && row.iter().all(is_datum));
    !rows.is_empty() && rows.iter().all(is_row)
}

impl Map {
    fn of(document: &Value) -> Self {
        let mut map = Self::default();
        for (name, value) in document.as_object().into_iter().flatten() {
            if !FRAME.contains(&name.as_str()) {
                map.add(value, format!("/{name}"), false);
            }
        }
        map
    }

    fn add(&mut self, value: &Value, path: String, in_matrix: bool) {
        match value {
            Value::String(_) if is_number(value) => self.numbers.push(path),
            Value::String(_) => self.words.push(path),
            Value::Number(_) => self.counts.push(path),
            Value::Array(items) => {
                for (k, item) in items.iter().enumerate() {
                    self.add(item, format!("{path}/{k}"), is_matrix(value));
                }
                if is_bounds(value) {
                    self.bounds.push(path.clone());
                }
                if is_matrix(value) {
                    self.matrices.push(path);
                } else if !in_matrix && !items.is_empty() {
                    self.lists.push(path);
                }
            }
            Value::Object(members) => {
                for (name, member) in members {
                    self.add(member, format!("{path}/{name}"), false);
                }
            }
            _ => {}
        }
    }
}

fn pick<'a, T>(items: &'a [T], random: &mut Random) -> Option<&'a T> {
    if items.is_empty() { None } else { items.get(random.below(items.len())) }
}

/// A number near another, or far from it.
fn changed(x: f64, random: &mut Random) -> f64 {
    match random.below(14) {
        0 => x * 2.0_f64.powi(random.integer(-60, 60)),
        1 => x * 2.0_f64.powi(random.integer(-3, 3)),
        2..=4 => x * (1.0 + random.sign() * 2.0_f64.powi(-random.integer(1, 52))),
        5 => x.next_up(),
        6 => x.next_down(),
        7 => -x,
        8 => 0.0,
        9 => [f64::MAX, f64::MIN_POSITIVE, 5e-324, 1e300, -1e300, 1e-300, -5e-324, 1e150][random.below(8)],
        10 => x + random.unit(),
        11 => x + random.sign() * 2.0_f64.powi(-random.integer(1, 60)),
        12 => x * random.between(0.5, 2.0),
        _ => random.unit(),
    }
}

/// `/path/i/j` becomes `/path/j/i`, where that exists.
fn mirrored(path: &str) -> Option<String> {
    let (rest, column) = path.rsplit_once('/')?;
    let (matrix, row) = rest.rsplit_once('/')?;
    (column.bytes().chain(row.bytes()).all(|b| b.is_ascii_digit()) && row != column)
        .then(|| format!("{matrix}/{column}/{row}"))
}

/// Puts a value somewhere, and into the mirror image where that held the same.
fn put(document: &mut Value, path: &str, value: Value, random: &mut Random) {
    let old = document.pointer(path).cloned();
    if let Some(mirror) = mirrored(path)
        && let Some(there) = document.pointer_mut(&mirror)
        && Some(&*there) == old.as_ref()
        && !random.once_in(10)
    {
        *there = value.clone();
    }
    if let Some(there) = document.pointer_mut(path) {
        *there = value;
    }
}

fn number_at(document: &Value, path: &str) -> Option<f64> {
    document.pointer(path)?.as_str().and_then(float)
}

fn number(document: &mut Value, map: &Map, random: &mut Random) -> Option<()> {
    let path = pick(&map.numbers, random)?;
    let value = match random.below(12) {
        0 => document.pointer(pick(&map.numbers, random)?)?.clone(),
        // A fraction that binary64 does not have, and bounds around the number.
        1 => {
            let x = number_at(document, path)?;
            let thirds = (x * 3.0 * 1024.0).round();
            if thirds.abs() > 1e15 {
                return None;
            }
            Value::String(format!("{thirds:.0}/3072"))
        }
        2 => {
            let x = number_at(document, path)?;
            let width = x.abs() * 2.0_f64.powi(-random.integer(1, 52)) + if random.once_in(4) { 1e-3 } else { 0.0 };
            Value::Array(vec![hexadecimal(x - width), hexadecimal(x + width)])
        }
        _ => hexadecimal(finite(changed(number_at(document, path)?, random))?),
    };
    put(document, path, value, random);
    Some(())
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

fn bounds(document: &mut Value, map: &Map, random: &mut Random) -> Option<()> {
    let path = pick(&map.bounds, random)?;
    let (lo, hi) = (number_at(document, &format!("{path}/0"))?, number_at(document, &format!("{path}/1"))?);
    let (lo, hi) = match random.below(6) {
        0 => (lo.next_up(), hi),
        1 => (lo, hi.next_down()),
        2 => (lo - (hi - lo), hi + (hi - lo)),
        3 => (lo + (hi - lo) / 4.0, hi),
        4 => (hi, lo),
        _ => (lo, lo),
    };
    put(document, path, Value::Array(vec![hexadecimal(finite(lo)?), hexadecimal(finite(hi)?)]), random);
    Some(())
}

fn matrix(document: &mut Value, map: &Map, random: &mut Random) -> Option<()> {
    let path = pick(&map.matrices, random)?.clone();
    let rows: Vec<Vec<Value>> =
        document.pointer(&path)?.as_array()?.iter().map(|row| row.as_array().cloned().unwrap_or_default()).collect();
    let (height, width) = (rows.len(), rows.first()?.len());
    let scaled = |factor: f64| -> Option<Vec<Vec<Value>>> {
        let entry = |x: &Value| Some(hexadecimal(finite(factor * float(x.as_str()?)?)?));
        rows.iter().map(|row| row.iter().map(entry).collect()).collect()
    };
    // What looks like a matrix of bounds may be a list of matrices, with rows of several lengths.
    let at = |i: usize, j: usize| rows.get(i)?.get(j);
    let rearranged = |row: &dyn Fn(usize) -> usize, col: &dyn Fn(usize) -> usize| -> Option<Vec<Vec<Value>>> {
        (0..height).map(|i| (0..width).map(|j| at(row(i), col(j)).cloned()).collect()).collect()
    };
    let (from, to) = (random.below(height.max(width)), random.below(height.max(width)));
    let swap = |k: usize| {
        if k == from {
            to
        } else if k == to {
            from
        } else {
            k
        }
    };
    let same = |k: usize| k;
    let row_of = |k: usize| swap(k).min(height - 1);
    let col_of = |k: usize| swap(k).min(width - 1);
    let next = match random.below(14) {
        0 => scaled(2.0_f64.powi(random.integer(-40, 40)))?,
        1 => scaled(2.0_f64.powi(random.integer(-2, 2)))?,
        2 | 3 => scaled(1.0 + random.sign() * 2.0_f64.powi(-random.integer(1, 50)))?,
        4 => scaled(-1.0)?,
        5 => (0..width).map(|j| (0..height).map(|i| at(i, j).cloned()).collect()).collect::<Option<_>>()?,
        6 => rearranged(&row_of, &same)?,
        7 => rearranged(&same, &col_of)?,
        8 => rearranged(&row_of, &col_of)?,
        // A multiple of the identity added, or a rank of one taken away.
        9 | 10 => {
            let size = rows.iter().flatten().filter_map(|x| float(x.as_str()?)).fold(0.0, |m: f64, x| m.max(x.abs()));
            let v = random.vector(height.max(width));
            let step = random.sign() * size * 2.0_f64.powi(-random.integer(0, 40));
            let is_shift = random.once_in(2);
            let entry = |i: usize, j: usize| {
                let by = if is_shift { f64::from(u8::from(i == j)) } else { v[i] * v[j] };
                Some(hexadecimal(finite(float(at(i, j)?.as_str()?)? + step * by)?))
            };
            (0..height).map(|i| (0..width).map(|j| entry(i, j)).collect()).collect::<Option<_>>()?
        }
        // Noise in the last places, the same at mirrored entries.
        11 | 12 => {
            let (low, seed) = (2.0_f64.powi(-random.integer(4, 52)), random.bits());
            let entry = |i: usize, j: usize| {
                let noise = stream(seed, "noise", (i.min(j) * 64 + i.max(j)) as u64).unit();
                Some(hexadecimal(finite(float(at(i, j)?.as_str()?)? * (1.0 + low * noise))?))
            };
            (0..height).map(|i| (0..width).map(|j| entry(i, j)).collect()).collect::<Option<_>>()?
        }
        _ => scaled(0.0)?,
    };
    *document.pointer_mut(&path)? = Value::Array(next.into_iter().map(Value::Array).collect());
    Some(())
}

fn two_matrices(document: &mut Value, map: &Map, random: &mut Random) -> Option<()> {
    let (one, other) = (pick(&map.matrices, random)?, pick(&map.matrices, random)?);
    let (first, second) = (document.pointer(one)?.clone(), document.pointer(other)?.clone());
    *document.pointer_mut(one)? = second;
    if random.once_in(2) {
        *document.pointer_mut(other)? = first;
    }
    Some(())
}

fn list(document: &mut Value, map: &Map, random: &mut Random) -> Option<()> {
    let path = pick(&map.lists, random)?;
    if random.once_in(3) {
        // All numbers below, by the same power of two.
        let factor = random.sign() * 2.0_f64.powi(random.integer(-20, 20));
        for below in map.numbers.iter().filter(|below| below.starts_with(&format!("{path}/"))) {
            let x = number_at(document, below)?;
            *document.pointer_mut(below)? = hexadecimal(finite(factor * x)?);
        }
        return Some(());
    }
    let items = document.pointer_mut(path)?.as_array_mut()?;
    let (one, other) = (random.below(items.len()), random.below(items.len()));
    match random.below(3) {
        0 => {
            items.remove(one);
        }
        1 => {
            let item = items[one].clone();
            items.insert(other, item);
        }
        _ => items.swap(one, other),
    }
    Some(())
}

fn word(document: &mut Value, map: &Map, random: &mut Random) -> Option<()> {
    // The level of a region stands where a word may.
    let mut places: Vec<&String> = map.words.iter().collect();
    places.extend(map.numbers.iter().filter(|path| path.ends_with("converges_from")));
    let path = *pick(&places, random)?;
    let found = document.pointer(path)?.as_str()?;
    let words = match found {
        _ if path.ends_with("converges_from") => REGIONS.map(str::to_owned).to_vec(),
        format if FORMATS.contains(&format) => FORMATS.map(str::to_owned).to_vec(),
        _ => known_words(document, path)?,
    };
    *document.pointer_mut(path)? = Value::from(pick(&words, random)?.as_str());
    Some(())
}

/// An expression with another variable, number, operator or function.
fn expression(document: &mut Value, map: &Map, random: &mut Random) -> Option<()> {
    const CHANGES: &[(&str, &str)] = &[
        ("+", "-"),
        ("-", "+"),
        ("*", "/"),
        ("/", "*"),
        ("x1", "x2"),
        ("x2", "x1"),
        ("xi1", "xi2"),
        ("^3", "^2"),
        ("^2", "^3"),
        ("3*", "2*"),
        ("1", "2"),
        ("0x1", "0x3"),
        ("sin(", "tanh("),
        ("exp(", "cos("),
        ("ln(", "sqrt("),
        ("y1", "(y1/(1 + y1^2))"),
    ];
    let path = pick(&map.words, random)?;
    let text = document.pointer(path)?.as_str()?;
    let (from, to) = pick(CHANGES, random)?;
    let places: Vec<usize> = text.match_indices(from).map(|(at, _)| at).collect();
    let at = *pick(&places, random)?;
    let changed = format!("{}{to}{}", &text[..at], &text[at + from.len()..]);
    *document.pointer_mut(path)? = Value::String(changed);
    Some(())
}

fn count(document: &mut Value, map: &Map, random: &mut Random) -> Option<()> {
    let path = pick(&map.counts, random)?;
    let found = document.pointer(path)?.as_u64()?;
    let next = match random.below(4) {
        0 => found + 1,
        1 => found.saturating_sub(1),
        2 => 0,
        _ => document.pointer(pick(&map.counts, random)?)?.as_u64()?,
    };
    *document.pointer_mut(path)? = Value::from(next);
    Some(())
}

/// One dimension fewer: a row, a column, or everything of one state.
fn dimension(document: &mut Value, map: &Map, random: &mut Random) -> Option<()> {
    let shape = |document: &Value, path: &str| -> Option<(usize, usize)> {
        let rows = document.pointer(path)?.as_array()?;
        Some((rows.len(), rows.first()?.as_array()?.len()))
    };
    let chosen = pick(&map.matrices, random)?;
    let (rows, cols) = shape(document, chosen)?;
    let order = if random.once_in(2) { rows } else { cols };
    let at = random.below(order);
    let whole = !random.once_in(4);
    for path in map.matrices.iter().filter(|path| whole || *path == chosen) {
        let (rows, cols) = shape(document, path)?;
        let matrix = document.pointer_mut(path)?.as_array_mut()?;
        // A list of matrices may look like a matrix of bounds: what is gone from it is not taken twice.
        if rows == order && at < matrix.len() {
            matrix.remove(at);
        }
        if cols == order {
            for row in matrix {
                let row = row.as_array_mut()?;
                if at < row.len() {
                    row.remove(at);
                }
            }
        }
    }
    if whole {
        for path in &map.lists {
            if let Some(items) = document.pointer_mut(path).and_then(Value::as_array_mut)
                && items.len() == order
                && items.iter().all(is_number)
            {
                items.remove(at);
            }
        }
    }
    Some(())
}

/// A part of another certificate of the same theorem.
fn part_of_another(document: &mut Value, other: &Value, random: &mut Random) -> Option<()> {
    let map = Map::of(other);
    let places: Vec<&String> = map.matrices.iter().chain(&map.numbers).chain(&map.lists).collect();
    let path = *pick(&places, random)?;
    *document.pointer_mut(path)? = other.pointer(path)?.clone();
    Some(())
}

/// The document with one to three changes; `None` where the change drawn has no place in it.
pub(super) fn mutant(document: &Value, other: &Value, random: &mut Random) -> Option<Value> {
    let mut next = document.clone();
    for _ in 0..[1, 1, 1, 2, 3][random.below(5)] {
        let map = Map::of(&next);
        match random.below(21) {
            0..=7 => number(&mut next, &map, random)?,
            8..=12 => matrix(&mut next, &map, random)?,
            13 => bounds(&mut next, &map, random)?,
            14 => two_matrices(&mut next, &map, random)?,
            15 | 20 => list(&mut next, &map, random)?,
            16 if map.words.iter().any(|path| path.starts_with("/observer/phi")) => {
                expression(&mut next, &map, random)?;
            }
            16 => word(&mut next, &map, random)?,
            17 => dimension(&mut next, &map, random)?,
            18 => count(&mut next, &map, random)?,
            _ => part_of_another(&mut next, other, random)?,
        }
    }
    (next != *document).then_some(next)
}

/// The place of the first number in which two documents differ, if that is all the difference there is.
pub(super) fn single_difference(one: &Value, other: &Value) -> Option<(String, f64, f64)> {
    let (first, second) = (Map::of(one), Map::of(other));
    if first.numbers != second.numbers {
        return None;
    }
    let path = first.numbers.iter().find(|path| one.pointer(path) != other.pointer(path))?;
    Some((path.clone(), number_at(one, path)?, number_at(other, path)?))
}

/// The document with another number in one place and, where it is the same there, in its mirror image.
pub(super) fn with_number(document: &Value, path: &str, x: f64) -> Value {
    let mut next = document.clone();
    let old = next.pointer(path).cloned();
    if let Some(mirror) = mirrored(path)
        && let Some(there) = next.pointer_mut(&mirror)
        && Some(&*there) == old.as_ref()
    {
        *there = hexadecimal(x);
    }
    if let Some(there) = next.pointer_mut(path) {
        *there = hexadecimal(x);
    }
    next
}
