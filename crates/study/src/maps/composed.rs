//! Observers whose right-hand side contains the plant or its derivatives, as one set of expressions for export:
//! high-gain observers with given maps, immersion and invariance, unknown-input observers, the mean-value observer as
//! printed.
//!
//! The state of the observer is `_1, .., `, outputs are `_y1, ..`, as in [`whole`](super::whole). Derivatives are
//! symbolic. That the expressions are the observers that run is tested.

use luenberger_expression::{Expression, ExpressionPlant, Scope, Variable};
use luenberger_observers::mean_value::integral::GAUSS_LEGENDRE_8;
use luenberger_observers::{CubicObserver, LinearObserver};
use luenberger_plants::Dimensions;
use nalgebra::{DMatrix, Dyn};

use super::high_gain::place;
use super::whole::{Written, built, determinant, operand, renamed, without};
use super::{HighGainMaps, ImmersionMaps};
use crate::model::{Model, PlantModel};

/// Rows of D_chi beta whose pseudo-inverse is written out.
const MOST_ROWS: usize = 3;

/// A high-gain observer with given maps and the gains `alpha_i/r^j`.
///
/// # Errors
/// Why there are no such expressions.
pub(crate) fn high_gain(plant: &PlantModel, maps: &HighGainMaps, gains: &[f64]) -> Result<Written, String> {
    let names = Names { plant };
    let head = |output: usize| maps.lengths[..output].iter().sum::<usize>();
    let row = |i: usize| {
        let output = place(&maps.lengths, i).output;
        format!(
            "({}) + ({})*{}*({} - {})",
            names.of_outputs(maps.drift[i].text(), |_| None),
            names.of_outputs(maps.shape[i].text(), |_| None),
            operand(gains[i]),
            seen(output),
            state(head(output))
        )
    };
    let rate: Vec<String> = (0..maps.order()).map(row).collect();
    let estimate: Vec<String> = maps.estimate.iter().map(|row| names.of_outputs(row.text(), |_| None)).collect();
    let start: Vec<String> = maps.start.iter().map(|row| row.text().to_owned()).collect();
    built(plant, maps.order(), (&rate, &estimate, &start))
}

/// An immersion-and-invariance observer, eq. (18).
///
/// # Errors
/// Why there are no such expressions.
pub(crate) fn immersion(plant: &PlantModel, maps: &ImmersionMaps) -> Result<Written, String> {
    let names = Names { plant };
    let (f, h) = equations(&plant.model)?;
    let (order, rows) = (maps.order, maps.rows());
    let of_chi =
        |text: &str| names.of_outputs(text, |word| (0..order).find(|i| word == format!("chi{}", i + 1)).map(state));
    let beta: Vec<String> = maps.beta.h().iter().map(|row| format!("({})", of_chi(row.text()))).collect();
    let xhat: Vec<String> = maps
        .image
        .left_inverse
        .iter()
        .map(|row| {
            let z = |word: &str| (0..rows).find(|i| word == format!("z{}", i + 1)).map(|i| beta[i].clone());
            format!("({})", names.of_outputs(row.text(), z))
        })
        .collect();
    let at_estimate = |text: &str| names.of_states(text, |k| xhat[k].clone());
    let in_order = |text: &str| numbered_states(text, |k| xhat[k].clone());
    let slope = |row: &Expression, by: Variable| {
        row.partial(by).map_err(|part| format!("the derivative of `{part}` is not written out"))
    };
    let f: Vec<String> = f.iter().map(|row| format!("({})", in_order(row.text()))).collect();
    // Dh f.
    let mut output_rate = Vec::new();
    for row in &h {
        let mut terms = Vec::new();
        for (j, f) in f.iter().enumerate() {
            terms.extend(slope(row, Variable::State(j))?.map(|text| format!("{}*{f}", in_order(&text))));
        }
        output_rate.push(sum(&terms));
    }
    // Dphi f - D_y beta Dh f + rho.
    let mut wanted = Vec::new();
    for i in 0..rows {
        let mut terms = Vec::new();
        for (j, f) in f.iter().enumerate() {
            let along = slope(&maps.phi.h()[i], Variable::State(j))?;
            terms.extend(along.map(|text| format!("{}*{f}", at_estimate(&text))));
        }
        for (k, rate) in output_rate.iter().enumerate() {
            let along = slope(&maps.beta.h()[i], Variable::State(order + k))?;
            terms.extend(along.map(|text| format!("(-{})*({rate})", of_chi(&text))));
        }
        terms.extend(maps.rho.as_ref().map(|rho| format!("({})", of_chi(rho[i].text()))));
        wanted.push(format!("({})", sum(&terms)));
    }
    let mut jacobian = vec![vec!["0".to_owned(); order]; rows];
    for (i, row) in jacobian.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = slope(&maps.beta.h()[i], Variable::State(j))?.map_or("0".to_owned(), |text| of_chi(&text));
        }
    }
    // Of chi1 + k(y) it is ((1)).
    let is = |text: &str, number: &str| text.trim_matches(['(', ')']) == number;
    let is_identity =
        rows == order && (0..rows).all(|i| (0..order).all(|j| is(&jacobian[i][j], if i == j { "1" } else { "0" })));
    let rate = if is_identity {
        wanted
    } else {
        let free: Vec<String> = match &maps.freedom {
            Some(free) => free.iter().map(|row| format!("({})", of_chi(row.text()))).collect(),
            None => vec!["0".to_owned(); order],
        };
        projected(&jacobian, &wanted, &free)?
    };
    let start: Vec<String> = match &maps.start {
        Some(start) => start.iter().map(|row| row.text().to_owned()).collect(),
        None => (0..rows)
            .map(|i| {
                let chi = |word: &str| (0..order).any(|k| word == format!("chi{}", k + 1)).then(|| "0".to_owned());
                let at_zero = names.of_outputs(maps.beta.h()[i].text(), chi);
                format!("({}) - ({at_zero})", maps.phi.h()[i].text())
            })
            .collect(),
    };
    built(plant, order, (&rate, &xhat, &start))
}

/// `Q + B'(BB')^-1 (wanted - B Q)`: the pseudo-inverse where B has full row rank.
fn projected(b: &[Vec<String>], wanted: &[String], free: &[String]) -> Result<Vec<String>, String> {
    let (rows, order) = (b.len(), free.len());
    if rows > MOST_ROWS {
        return Err(format!(
            "the pseudo-inverse of D_chi beta with {rows} rows is not written out: at most {MOST_ROWS}, or beta = chi + k"
        ));
    }
    let product = |i: usize, k: usize| sum(&(0..order).map(|j| format!("{}*{}", b[i][j], b[k][j])).collect::<Vec<_>>());
    let gram: Vec<Vec<String>> =
        (0..rows).map(|i| (0..rows).map(|k| format!("({})", product(i, k))).collect()).collect();
    let whole = determinant(&gram);
    let missed: Vec<String> = (0..rows)
        .map(|i| {
            let seen = sum(&(0..order).map(|j| format!("{}*{}", b[i][j], free[j])).collect::<Vec<_>>());
            format!("({} - ({seen}))", wanted[i])
        })
        .collect();
    // The Gram matrix is symmetric, and so is its adjugate.
    let solved: Vec<String> = (0..rows)
        .map(|i| {
            let term = |k: usize| {
                let sign = if (i + k).is_multiple_of(2) { "" } else { "-" };
                format!("({sign}({}))*{}", determinant(&without(&gram, i, k)), missed[k])
            };
            format!("(({})/({whole}))", sum(&(0..rows).map(term).collect::<Vec<_>>()))
        })
        .collect();
    let row = |j: usize| {
        let back = sum(&(0..rows).map(|i| format!("{}*{}", b[i][j], solved[i])).collect::<Vec<_>>());
        format!("{} + {back}", free[j])
    };
    Ok((0..order).map(row).collect())
}

/// The observer of the plant (TA, TB, C, D) inside of an unknown-input observer.
pub(crate) enum Decoupled<'a> {
    /// Linear.
    Linear(&'a LinearObserver<f64, Dyn, Dyn, Dyn>),
    /// With a cubic term.
    Cubic(&'a CubicObserver<f64, Dyn, Dyn, Dyn>),
}

/// An unknown-input observer with this H.
///
/// # Errors
/// Why there are no such expressions.
pub(crate) fn unknown_input(
    inner: &Decoupled<'_>,
    h: &DMatrix<f64>,
    d: Option<&DMatrix<f64>>,
    size: Dimensions,
) -> Result<Written, String> {
    let Dimensions { states: n, inputs: m, outputs: p } = size;
    let words = |error: &dyn std::fmt::Display| error.to_string();
    let (a, b, c, l) = match inner {
        Decoupled::Linear(inner) => (&inner.a, &inner.b, &inner.c, &inner.l),
        Decoupled::Cubic(inner) => (&inner.a, &inner.b, &inner.c, &inner.l),
    };
    let combined = |matrix: &DMatrix<f64>, row: usize, of: &dyn Fn(usize) -> String| {
        let used = (0..matrix.ncols()).filter(|j| matrix[(row, *j)] != 0.0);
        sum(&used.map(|j| format!("{}*{}", operand(matrix[(row, j)]), of(j))).collect::<Vec<_>>())
    };
    let input = |j: usize| format!("u{}", j + 1);
    // y - D u.
    let seen = |j: usize| match d {
        Some(d) => format!("(u{} - ({}))", m + j + 1, combined(d, j, &input)),
        None => format!("u{}", m + j + 1),
    };
    let xhat = |i: usize| format!("(x{} + {})", i + 1, combined(h, i, &seen));
    let residual = |i: usize| format!("({} - ({}))", seen(i), combined(c, i, &xhat));
    let strength = match inner {
        Decoupled::Linear(_) => None,
        Decoupled::Cubic(inner) => {
            let theta = &inner.theta;
            let rows = (0..p).map(|i| format!("{}*({})", residual(i), combined(theta, i, &residual)));
            Some((format!("({})", sum(&rows.collect::<Vec<_>>())), &inner.n))
        }
    };
    let rate: Vec<String> = (0..n)
        .map(|i| {
            let linear =
                format!("{} + {} + {}", combined(a, i, &xhat), combined(b, i, &input), combined(l, i, &residual));
            match &strength {
                Some((strength, n)) => format!("{linear} - {strength}*({})", combined(n, i, &residual)),
                None => linear,
            }
        })
        .collect();
    let estimate: Vec<String> = (0..n).map(xhat).collect();
    let first = |j: usize| format!("u{}", j + 1);
    let start: Vec<String> = (0..n).map(|i| format!("x{} - ({})", i + 1, combined(h, i, &first))).collect();
    let still = vec!["0".to_owned(); n];
    let within = |f: &[String], h: &[String], inputs: usize| {
        ExpressionPlant::within(f, h, &Scope::plant(n, inputs).generated()).map_err(|error| words(&error))
    };
    let (flow, start) = (within(&rate, &estimate, m + p)?, within(&still, &start, p)?);
    Ok(Written { flow, start, inputs: m, outputs: p })
}

/// The mean-value observer as printed with the integral mean of the Jacobian, from this internal error. Its state is
/// (xhat, e).
///
/// # Errors
/// Why there are no such expressions.
pub(crate) fn printed_mean_value(plant: &PlantModel, eta: f64, internal_error: &[f64]) -> Result<Written, String> {
    let (f, _) = equations(&plant.model)?;
    let (n, p) = (f.len(), plant.outputs.len());
    let at = |text: &str, share: &dyn Fn(usize) -> String| numbered_states(text, share);
    let estimate = |k: usize| state(k);
    let end = |k: usize| format!("({} + {})", state(k), state(n + k));
    // D(i, j), by eight points.
    let mut mean = vec![vec!["0".to_owned(); n]; n];
    for (i, row) in mean.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            let slope = f[i].partial(Variable::State(j));
            let Some(slope) = slope.map_err(|part| format!("the derivative of `{part}` is not written out"))? else {
                continue;
            };
            let node = |(share, weight): &(f64, f64)| {
                let point = |k: usize| format!("({} + {}*{})", state(k), state(n + k), operand(*share));
                format!("{}*{}", at(&slope, &point), operand(*weight))
            };
            *entry = format!("({})", sum(&GAUSS_LEGENDRE_8.iter().map(node).collect::<Vec<_>>()));
        }
    }
    let gain = |k: usize| {
        let terms: Vec<String> = (0..n).flat_map(|j| [&mean[k][j], &mean[j][k]]).map(|d| format!("abs({d})")).collect();
        format!("{}*({})", operand(eta), sum(&terms))
    };
    let error = |k: usize| state(n + k);
    let mut rate = Vec::new();
    for (k, row) in f.iter().enumerate() {
        let measured = if k < p { format!("({} - {})", seen(k), state(k)) } else { error(k) };
        rate.push(format!("({}) + {}*{measured}", at(row.text(), &estimate), gain(k)));
    }
    for (k, row) in f.iter().enumerate() {
        let forward = format!("(({}) - ({}))", at(row.text(), &end), at(row.text(), &estimate));
        rate.push(format!("{forward} - {}*{}", gain(k), error(k)));
    }
    let estimates: Vec<String> = (0..n).map(state).collect();
    let start: Vec<String> =
        (0..n).map(|k| format!("x{}", k + 1)).chain(internal_error.iter().map(|e| operand(*e))).collect();
    built(plant, 2 * n, (&rate, &estimates, &start))
}

/// f and h with the numbered names of states and inputs, and with numbers for parameters.
fn equations(model: &Model) -> Result<(Vec<Expression>, Vec<Expression>), String> {
    let plant = model.expressions().map_err(|error| error.to_string())?;
    let size = model.size();
    let scope = Scope::plant(size.states, size.inputs);
    let rows = |of: &[Expression]| -> Result<Vec<Expression>, String> {
        let row = |row: &Expression| {
            let text = row.numbered().ok_or_else(|| format!("`{}` has a lookup table", row.text()))?;
            Expression::parse(&text, &scope).map_err(|error| error.to_string())
        };
        of.iter().map(row).collect()
    };
    Ok((rows(plant.f())?, rows(plant.h())?))
}

/// The text with its numbered states replaced.
fn numbered_states(text: &str, state: impl Fn(usize) -> String) -> String {
    renamed(text, |word| {
        let k: usize = word.strip_prefix('x')?.parse().ok()?;
        Some(state(k.checked_sub(1)?))
    })
}

/// Names of the study in the maps.
struct Names<'a> {
    plant: &'a PlantModel,
}

impl Names<'_> {
    /// A map whose outputs are those of the observer, by names that no input and no state has.
    fn of_outputs(&self, text: &str, other: impl Fn(&str) -> Option<String>) -> String {
        let own = |word: &str| position(&self.plant.outputs, word, 'y');
        renamed(text, |word| {
            // A parameter with the name of an output is the parameter.
            let output = || own(word).filter(|_| !self.plant.parameters.contains_key(word));
            other(word).or_else(|| output().map(seen))
        })
    }

    /// A map of states at these.
    fn of_states(&self, text: &str, value: impl Fn(usize) -> String) -> String {
        renamed(text, |word| {
            let own = position(&self.plant.states, word, 'x');
            own.filter(|_| !self.plant.parameters.contains_key(word)).map(&value)
        })
    }
}

/// The index of a name, or of a numbered one.
fn position(names: &[String], word: &str, letter: char) -> Option<usize> {
    names.iter().position(|name| name == word).or_else(|| {
        let k: usize = word.strip_prefix(letter)?.parse().ok()?;
        (1..=names.len()).contains(&k).then(|| k - 1)
    })
}

fn state(k: usize) -> String {
    format!("_{}", k + 1)
}

fn seen(k: usize) -> String {
    format!("_y{}", k + 1)
}

fn sum(terms: &[String]) -> String {
    if terms.is_empty() { "0".to_owned() } else { terms.join(" + ") }
}
