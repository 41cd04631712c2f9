//! Smaller studies with the same finding: fewer observers and keys, fewer states, shorter expressions, rounder numbers.

use super::document::{Table, Value, read, write};

/// Attempts at most: each one designs the observers again.
const ATTEMPTS: usize = 120;

/// The smallest study found for which `remains` is true.
pub(super) fn shrink(text: &str, remains: &mut dyn FnMut(&str) -> bool) -> String {
    let mut best = text.to_owned();
    let mut left = ATTEMPTS;
    loop {
        let Some(document) = read(&best) else { return best };
        let mut is_smaller = false;
        for candidate in candidates(&document) {
            if left == 0 {
                return best;
            }
            let smaller = write(&candidate);
            if smaller.len() >= best.len() {
                continue;
            }
            left -= 1;
            if remains(&smaller) {
                best = smaller;
                is_smaller = true;
                break;
            }
        }
        if !is_smaller {
            return best;
        }
    }
}

/// Documents that are smaller by one change, the largest changes first.
fn candidates(document: &Table) -> Vec<Table> {
    let mut all = Vec::new();
    let observers = document.get("observer").and_then(Value::list).map_or(0, Vec::len);
    for k in 0..observers {
        if observers > 1 {
            let mut smaller = document.clone();
            if let Some(list) = smaller.get_mut("observer").and_then(Value::list_mut) {
                list.remove(k);
            }
            all.push(smaller);
        }
    }
    for key in ["sweep", "simulation", "input", "operating_point", "title"] {
        if document.has(key) {
            let mut smaller = document.clone();
            smaller.remove(key);
            all.push(smaller);
        }
    }
    // A key of an observer or of the plant.
    let mut paths: Vec<Vec<Step>> = Vec::new();
    let whole = Value::Table(document.clone());
    walk(&whole, &mut Vec::new(), &mut paths);
    for path in &paths {
        if let Some(Step::Key(_)) = path.last()
            && path.len() > 1
        {
            let mut smaller = whole.clone();
            remove(&mut smaller, path);
            all.extend(smaller.table().cloned());
        }
    }
    all.extend(without_state(document));
    for path in &paths {
        let Some(value) = get(&whole, path) else { continue };
        for simpler in simpler(value) {
            let mut changed = whole.clone();
            if let Some(place) = get_mut(&mut changed, path) {
                *place = simpler;
                all.extend(changed.table().cloned());
            }
        }
    }
    all
}

/// Linear plants with a state less.
fn without_state(document: &Table) -> Vec<Table> {
    let Some(a) = document.get("plant").and_then(Value::table).and_then(|plant| plant.get("a")).and_then(Value::rows)
    else {
        return Vec::new();
    };
    let n = a.len();
    if n < 2 {
        return Vec::new();
    }
    let drop_rows = |value: &mut Value, k: usize| {
        if let Some(list) = value.list_mut().filter(|list| list.len() == n) {
            list.remove(k);
        }
    };
    let drop_columns = |value: &mut Value, k: usize| {
        for row in value.list_mut().into_iter().flatten() {
            drop_rows(row, k);
        }
    };
    (0..n)
        .map(|k| {
            let mut smaller = document.clone();
            if let Some(plant) = smaller.get_mut("plant").and_then(Value::table_mut) {
                for key in ["a", "c"] {
                    if let Some(value) = plant.get_mut(key) {
                        drop_columns(value, k);
                    }
                }
                for key in ["a", "b"] {
                    if let Some(value) = plant.get_mut(key) {
                        drop_rows(value, k);
                    }
                }
            }
            let observers = smaller.get_mut("observer").and_then(Value::list_mut).into_iter().flatten();
            for observer in observers.filter_map(Value::table_mut) {
                for key in ["e", "gain", "poles", "initial_bounds", "w", "initial", "first_errors"] {
                    if let Some(value) = observer.get_mut(key) {
                        drop_rows(value, k);
                    }
                }
                if let Some(e) =
                    observer.get_mut("bounds").and_then(Value::table_mut).and_then(|bounds| bounds.get_mut("e"))
                {
                    drop_rows(e, k);
                }
                if let Some(value) = observer.get_mut("k") {
                    drop_columns(value, k);
                }
            }
            if let Some(x0) =
                smaller.get_mut("simulation").and_then(Value::table_mut).and_then(|table| table.get_mut("x0"))
            {
                drop_rows(x0, k);
            }
            smaller
        })
        .collect()
}

/// A step into a value.
#[derive(Debug, Clone)]
enum Step {
    Key(String),
    Index(usize),
}

fn walk(value: &Value, path: &mut Vec<Step>, all: &mut Vec<Vec<Step>>) {
    if !path.is_empty() {
        all.push(path.clone());
    }
    match value {
        Value::Table(table) => {
            for (key, value) in &table.0 {
                path.push(Step::Key(key.clone()));
                walk(value, path, all);
                path.pop();
            }
        }
        Value::List(list) => {
            for (k, value) in list.iter().enumerate() {
                path.push(Step::Index(k));
                walk(value, path, all);
                path.pop();
            }
        }
        _ => {}
    }
}

fn get<'a>(value: &'a Value, path: &[Step]) -> Option<&'a Value> {
    path.iter().try_fold(value, |value, step| match step {
        Step::Key(key) => value.table()?.get(key),
        Step::Index(k) => value.list()?.get(*k),
    })
}

fn get_mut<'a>(value: &'a mut Value, path: &[Step]) -> Option<&'a mut Value> {
    path.iter().try_fold(value, |value, step| match step {
        Step::Key(key) => value.table_mut()?.get_mut(key),
        Step::Index(k) => value.list_mut()?.get_mut(*k),
    })
}

fn remove(value: &mut Value, path: &[Step]) {
    let Some((last, before)) = path.split_last() else { return };
    let Some(place) = get_mut(value, before) else { return };
    match (last, place) {
        (Step::Key(key), Value::Table(table)) => table.remove(key),
        (Step::Index(k), Value::List(list)) => _ = list.remove(*k),
        _ => {}
    }
}

/// Simpler values: a rounder number, an expression without one of its terms.
fn simpler(value: &Value) -> Vec<Value> {
    match value {
        Value::Text(text) => terms(text).into_iter().map(Value::Text).collect(),
        Value::Number(x) => {
            let round = |digits: i32| {
                let scale = 10f64.powi(digits - 1 - x.abs().max(1e-300).log10().floor() as i32);
                (x * scale).round() / scale
            };
            [0.0, 1.0f64.copysign(*x), round(1), round(2)]
                .into_iter()
                .filter(|y| y != x && y.is_finite())
                .map(Value::Number)
                .collect()
        }
        _ => Vec::new(),
    }
}

/// The texts without one of their terms outside of parentheses.
fn terms(text: &str) -> Vec<String> {
    let (mut depth, mut cuts) = (0, vec![0]);
    let bytes = text.as_bytes();
    for (k, byte) in bytes.iter().enumerate() {
        match byte {
            b'(' => depth += 1,
            b')' => depth -= 1,
            b'+' | b'-' if depth == 0 && k > 0 && !matches!(bytes[k - 1], b'e' | b'E' | b'*' | b'/' | b'^') => {
                cuts.push(k);
            }
            _ => {}
        }
    }
    cuts.push(text.len());
    if cuts.len() < 3 {
        return Vec::new();
    }
    (0..cuts.len() - 1)
        .map(|k| {
            let rest = format!("{}{}", &text[..cuts[k]], &text[cuts[k + 1]..]);
            rest.trim().trim_start_matches('+').trim().to_owned()
        })
        .filter(|rest| !rest.is_empty())
        .collect()
}
