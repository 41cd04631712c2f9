//! An observer with given maps as one set of expressions, which can be printed as source code: its right-hand side and
//! its estimate in the state z and in (u, y), and the start of z.
//!
//! The right-hand side is that of `luenberger_observers::{kkl, kkl_peb}` written out; that both agree is tested. What
//! differs: an entry that overflows is not held.

use super::names::MapNames;
use super::{Estimator, KklMaps, PebSpec};
use crate::model::PlantModel;
use luenberger_export::extension::ExpressionObserver;
use luenberger_expression::{Expression, ExpressionPlant, Scope};
use luenberger_observers::FilterMemory;
use luenberger_observers::estimator::drem::Drem;

/// A KKL observer.
///
/// # Errors
/// Why there are no such expressions.
pub(crate) fn kkl(plant: &PlantModel, maps: &KklMaps) -> Result<ExpressionObserver, String> {
    let writer = Writer { plant, maps };
    let rate: Vec<String> = (0..maps.order()).map(|i| writer.rate(i, 0.0)).collect();
    let estimate: Vec<String> = maps.left_inverse.iter().map(|row| writer.of_outputs(row, |_| None)).collect();
    let start: Vec<String> = maps.phi.iter().map(|row| row.text().to_owned()).collect();
    built(plant, maps.order(), (&rate, &estimate, &start), None)
}

/// A PEBO or a [KKL+PEB]O. Its state is (xi, w, F[g], F[m] by columns, theta, state of the extension), and with resets
/// the number of samples since the last instant of one.
///
/// # Errors
/// Why there are no such expressions.
pub(crate) fn peb(plant: &PlantModel, spec: &PebSpec, period: f64) -> Result<ExpressionObserver, String> {
    let PebSpec { maps, alpha, .. } = spec;
    let writer = Writer { plant, maps: &maps.kkl };
    let (order, r, q) = (maps.kkl.order(), maps.signal.len(), maps.parameters);
    let state = |k: usize| format!("_{}", k + 1);
    let (w, known) = (|i: usize| state(order + i), |i: usize| state(order + r + i));
    let regressor = |i: usize, j: usize| state(order + (2 + j) * r + i);
    let theta = |j: usize| state(order + r * (q + 2) + j);
    let extension = |k: usize| state(order + r * (q + 2) + q + k);
    let held = |j: usize| match &maps.lowest {
        Some(lowest) => format!("max({}, {})", theta(j), operand(lowest[j])),
        None => theta(j),
    };

    let filter = |source: &str, state: &str| format!("{}*({source} - {state})", operand(*alpha));
    let leak = |i: usize| if maps.open.contains(&i) { maps.leakage } else { 0.0 };
    let mut rate: Vec<String> = (0..order).map(|i| writer.rate(i, leak(i))).collect();
    let signal: Vec<String> = maps.signal.iter().map(|row| signal_of(&writer, row)).collect();
    rate.extend((0..r).map(|i| filter(&signal[i], &w(i))));
    rate.extend((0..r).map(|i| filter(&format!("({})", maps.known[i].text()), &known(i))));
    for j in 0..q {
        rate.extend((0..r).map(|i| filter(&format!("({})", maps.regressor[i * q + j].text()), &regressor(i, j))));
    }
    // Y = W[s] - F[g].
    let measured = |i: usize| format!("({} - {})", filter(&signal[i], &w(i)), known(i));
    let sum = |terms: Vec<String>| terms.join(" + ");
    let mut of_theta: Vec<String> = match &spec.estimator {
        Estimator::Gradient(gradient) => {
            let residual = |i: usize| {
                let predicted = sum((0..q).map(|j| format!("{}*{}", regressor(i, j), theta(j))).collect());
                format!("({} - ({predicted}))", measured(i))
            };
            let slope = |j: usize| sum((0..r).map(|i| format!("{}*{}", regressor(i, j), residual(i))).collect());
            let gain = gradient.gain();
            let row = |i: usize| {
                let used = (0..q).filter(|j| gain[(i, *j)] != 0.0);
                sum(used.map(|j| format!("{}*({})", operand(gain[(i, j)]), slope(j))).collect())
            };
            (0..q).map(row).collect()
        }
        Estimator::Kreisselmeier(drem) => {
            let phi = |i: usize, j: usize| extension(q + i + q * j);
            mixed(q, gains(drem), phi, extension, theta)?
        }
        Estimator::Filters(drem) => {
            // Row i of block k of the square regression; block 0 is (Y, M) itself.
            let entry = |row: usize, j: usize| match (row / r, row % r) {
                (0, i) => regressor(i, j),
                (k, i) => extension((k - 1) * r * (q + 1) + (1 + j) * r + i),
            };
            let right = |row: usize| match (row / r, row % r) {
                (0, i) => measured(i),
                (k, i) => extension((k - 1) * r * (q + 1) + i),
            };
            mixed(q, gains(drem), entry, right, theta)?
        }
    };
    if let Some(lowest) = &maps.lowest {
        for (j, row) in of_theta.iter_mut().enumerate() {
            *row = format!("if({} <= {} && {row} < 0, 0, {row})", theta(j), operand(lowest[j]));
        }
    }
    rate.extend(of_theta);
    match &spec.estimator {
        Estimator::Gradient(_) => {}
        Estimator::Kreisselmeier(drem) => {
            let a = operand(drem.extension().forgetting_rate());
            let right = |j: usize| sum((0..r).map(|i| format!("{}*{}", regressor(i, j), measured(i))).collect());
            rate.extend((0..q).map(|j| format!("{} - {a}*{}", right(j), extension(j))));
            for k in 0..q {
                let gram = |j: usize| sum((0..r).map(|i| format!("{}*{}", regressor(i, j), regressor(i, k))).collect());
                rate.extend((0..q).map(|j| format!("{} - {a}*{}", gram(j), extension(q + j + q * k))));
            }
        }
        Estimator::Filters(drem) => {
            for (k, beta) in drem.extension().poles().iter().enumerate() {
                let first = k * r * (q + 1);
                let follow = |source: String, at: usize| format!("{}*({source} - {})", operand(*beta), extension(at));
                rate.extend((0..r).map(|i| follow(measured(i), first + i)));
                for j in 0..q {
                    rate.extend((0..r).map(|i| follow(regressor(i, j), first + (1 + j) * r + i)));
                }
            }
        }
    }

    // phi^L(xi + missing(theta_hat), y).
    let complete = |word: &str| {
        let i = (0..order).find(|i| word == format!("xi{}", i + 1))?;
        Some(format!("({word} + ({}))", missing_of(&maps.missing[i], q, held)))
    };
    let estimate: Vec<String> = maps.kkl.left_inverse.iter().map(|row| writer.of_outputs(row, complete)).collect();
    let first: Vec<f64> =
        (0..q).map(|j| maps.lowest.as_ref().map_or(spec.start, |lowest| spec.start.max(lowest[j]))).collect();
    let behind = maps.completion(&first);
    let mut start: Vec<String> = (0..order)
        .map(|i| format!("({}) - {}", maps.kkl.phi[i].text(), operand(behind[i])))
        .chain(signal)
        .chain((0..r * (q + 1)).map(|_| "0".to_owned()))
        .chain(first.iter().map(|theta| operand(*theta)))
        .collect();
    start.resize(rate.len(), "0".to_owned());
    let Some(reset) = &spec.reset else { return built(plant, order, (&rate, &estimate, &start), None) };

    // The samples are counted in one more state, which stands still between them.
    let count = state(rate.len());
    let every = samples_between(reset.period, period)?;
    let above = reset.above.map(|level| {
        let one = |i: &usize| format!("abs({}) > {}", state(*i), operand(level));
        maps.open.iter().map(one).collect::<Vec<_>>().join(" || ")
    });
    let is_due = format!("{count} >= {}", operand(every));
    let resets = above.map_or(is_due.clone(), |above| format!("{is_due} && ({above})"));
    let delta = |j: usize| format!("({} - {})", held(j), operand(first[j]));
    let moved = |from: String, by: &dyn Fn(usize) -> String| {
        let terms: Vec<String> = (0..q).map(|j| format!("{}*{}", by(j), delta(j))).collect();
        format!("{from} + {}", terms.join(" + "))
    };
    let back = |from: String, by: &dyn Fn(usize) -> String| moved(from, &|j| format!("(-{})", by(j)));
    let kept = maps.memory() == FilterMemory::Transformed;
    let mut after: Vec<String> = (0..order)
        .map(|i| format!("{} + ({} - {})", state(i), missing_of(&maps.missing[i], q, held), operand(behind[i])))
        .collect();
    let restarted = |k: usize| if k < r { signal_of(&writer, &maps.signal[k]) } else { "0".to_owned() };
    let filters = order..order + r * (q + 2);
    after.extend(filters.clone().map(|k| match k - order {
        k if !kept => restarted(k),
        k if k >= r && k < 2 * r => moved(known(k - r), &|j| regressor(k - r, j)),
        k => state(order + k),
    }));
    after.extend(first.iter().map(|theta| operand(*theta)));
    let rest = rate.len() - after.len();
    after.extend((0..rest).map(|k| match &spec.estimator {
        _ if !kept => "0".to_owned(),
        Estimator::Kreisselmeier(_) if k < q => back(extension(k), &|j| extension(q + k + q * j)),
        Estimator::Filters(_) if k % (r * (q + 1)) < r => back(extension(k), &|j| extension(k + (1 + j) * r)),
        _ => extension(k),
    }));
    let mut jump: Vec<String> =
        after.iter().enumerate().map(|(k, after)| format!("if({resets}, {after}, {})", state(k))).collect();
    jump.push(format!("if({is_due}, 1, {count} + 1)"));
    rate.push("0".to_owned());
    start.push("0".to_owned());
    built(plant, order, (&rate, &estimate, &start), Some(&jump))
}

/// The samples from one reset to the next.
fn samples_between(reset: f64, period: f64) -> Result<f64, String> {
    let count = (reset / period).round();
    if count >= 1.0 && (count * period - reset).abs() <= 1e-9 * reset {
        Ok(count)
    } else {
        Err(format!("the period of its resets, {reset}, is not a multiple of the sampling period {period}"))
    }
}

/// The missing part with theta held in its domain.
fn missing_of(row: &Expression, q: usize, held: impl Fn(usize) -> String) -> String {
    renamed(row.text(), |word| (0..q).find(|j| word == format!("theta{}", j + 1)).map(&held))
}

/// A row of s.
fn signal_of(writer: &Writer<'_>, row: &Expression) -> String {
    format!("({})", writer.of_outputs(row, |_| None))
}

fn gains<X>(drem: &Drem<f64, nalgebra::Dyn, X>) -> &[f64] {
    drem.gain().as_slice()
}

/// The most parameters of DREM whose determinant is written out.
const MOST_PARAMETERS: usize = 3;

/// `theta_i' = gamma_i Delta ((adj(Phi) Z)_i - Delta theta_i)`.
fn mixed(
    q: usize,
    gains: &[f64],
    phi: impl Fn(usize, usize) -> String,
    right: impl Fn(usize) -> String,
    theta: impl Fn(usize) -> String,
) -> Result<Vec<String>, String> {
    if q > MOST_PARAMETERS {
        return Err(format!(
            "the determinant of DREM for {q} parameters is not written out: at most {MOST_PARAMETERS}"
        ));
    }
    let entries: Vec<Vec<String>> = (0..q).map(|i| (0..q).map(|j| phi(i, j)).collect()).collect();
    let delta = determinant(&entries);
    let cofactor = |row: usize, column: usize| {
        let minor = without(&entries, row, column);
        let sign = if (row + column).is_multiple_of(2) { "" } else { "-" };
        format!("{sign}({})", determinant(&minor))
    };
    let row = |i: usize| {
        // Entry (i, k) of the adjugate is the cofactor (k, i).
        let solved: Vec<String> = (0..q).map(|k| format!("({})*{}", cofactor(k, i), right(k))).collect();
        format!("{}*({delta})*({} - ({delta})*{})", operand(gains[i]), solved.join(" + "), theta(i))
    };
    Ok((0..q).map(row).collect())
}

/// The rows without one of them and without one column.
pub(super) fn without(entries: &[Vec<String>], row: usize, column: usize) -> Vec<Vec<String>> {
    let kept = |row: &Vec<String>| (0..row.len()).filter(|j| *j != column).map(|j| row[j].clone()).collect();
    entries.iter().enumerate().filter(|(i, _)| *i != row).map(|(_, row)| kept(row)).collect()
}

pub(super) fn determinant(entries: &[Vec<String>]) -> String {
    let Some(first) = entries.first() else { return "1".to_owned() };
    let term = |j: usize| {
        let minor = determinant(&without(entries, 0, j));
        format!("{}{}*({minor})", if j.is_multiple_of(2) { "+" } else { "-" }, first[j])
    };
    let terms: Vec<String> = (0..first.len()).map(term).collect();
    terms.join(" ").trim_start_matches('+').to_owned()
}

/// A number as an operand.
pub(crate) fn operand(x: f64) -> String {
    format!("({x:?})")
}

/// The text with some of its names replaced.
pub(super) fn renamed(text: &str, name: impl Fn(&str) -> Option<String>) -> String {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
    let mut result = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = if is_part(first) { rest.find(|c| !is_part(c)).unwrap_or(rest.len()) } else { first.len_utf8() };
        let (word, after) = rest.split_at(length);
        match name(word) {
            Some(other) => result.push_str(&other),
            None => result.push_str(word),
        }
        rest = after;
    }
    result
}

/// The rows of an observer as texts.
struct Writer<'a> {
    plant: &'a PlantModel,
    maps: &'a KklMaps,
}

impl Writer<'_> {
    /// Row i of `Lambda xi + B`, with leakage.
    fn rate(&self, i: usize, leakage: f64) -> String {
        let order = self.maps.order();
        let is_zero = |text: &str| text.trim().parse::<f64>() == Ok(0.0);
        let mut terms: Vec<String> = (0..order)
            .map(|j| (self.maps.lambda[i * order + j].text(), j))
            .filter(|(text, _)| !is_zero(text))
            .map(|(text, j)| format!("({text})*xi{}", j + 1))
            .collect();
        if leakage > 0.0 {
            terms.push(format!("{}*xi{}", operand(-leakage), i + 1));
        }
        terms.push(format!("({})", self.maps.injection[i].text()));
        terms.join(" + ")
    }

    /// A map without inputs: outputs by names that no input and no state has.
    fn of_outputs(&self, row: &Expression, other: impl Fn(&str) -> Option<String>) -> String {
        let outputs = &self.plant.outputs;
        renamed(row.text(), |word| {
            let own = || (0..outputs.len()).find(|&k| outputs[k] == word || word == format!("y{}", k + 1));
            // A parameter with the name of an output is the parameter.
            let output = || own().filter(|_| !self.plant.parameters.contains_key(word));
            other(word).or_else(|| output().map(|k| format!("_y{}", k + 1)))
        })
    }
}

/// The observer of these rows: its right-hand side, its estimate and its start; the state after a jump at a sample.
pub(super) fn built(
    plant: &PlantModel,
    order: usize,
    (rate, estimate, start): (&[String], &[String], &[String]),
    jump: Option<&[String]>,
) -> Result<ExpressionObserver, String> {
    let names = MapNames::new(plant, order);
    let words = |error: &dyn std::fmt::Display| error.to_string();
    let within = |f: &[String], h: &[String], scope: Result<Scope, luenberger_expression::ParameterError>| {
        let scope = scope.map_err(|error| words(&error))?;
        ExpressionPlant::within(f, h, &scope).map_err(|error| words(&error))
    };
    let still: Vec<String> = plant.states.iter().map(|_| "0".to_owned()).collect();
    let flow = within(rate, estimate, names.whole(rate.len()))?;
    let start = within(&still, start, names.start())?;
    let sizes = (plant.inputs.len(), plant.outputs.len());
    let observer = ExpressionObserver::new(flow, start, sizes).map_err(|error| words(&error))?;
    let Some(jump) = jump else { return Ok(observer) };
    let rest: Vec<String> = rate.iter().map(|_| "0".to_owned()).collect();
    observer.with_jump(within(&rest, jump, names.whole(rate.len()))?).map_err(|error| words(&error))
}
