//! The maps of an observer: lists and matrices of expressions.

use luenberger_design::Region;
use luenberger_expression::{Expression, ParameterError, Scope};
use luenberger_observers::FilterMemory;
use luenberger_proof::wording::counted;

use super::tree::Node;
use super::{Reader, check, region};
use super::{expression, inequality};
use crate::maps::{Estimator, KklMaps, MapNames, PebSpec, RegressionMaps, ResetSpec};
use crate::model::PlantModel;

/// The four maps.
pub(crate) fn kkl_maps(node: &Node, plant: &PlantModel, reader: &mut Reader) -> Option<KklMaps> {
    let order = node.get("phi")?.list()?.len();
    let names = MapNames::new(plant, order);
    let of_phi = format!("`phi` has {}", counted(order, "row"));
    let phi = list(node, "phi", (order, &of_phi), names.image(), reader);
    let lambda = match node.get("lambda") {
        Some(_) => matrix(node, "lambda", (order, order, &of_phi), names.dynamics(), reader),
        None => list_of_zeros(order * order),
    };
    let injection = list(node, "b", (order, &of_phi), names.injection(), reader);
    let of_states = format!("the plant has {}", counted(plant.states.len(), "state"));
    let left_inverse = list(node, "left_inverse", (plant.states.len(), &of_states), names.left_inverse(), reader);
    let (phi, lambda, injection, left_inverse) = (phi?, lambda?, injection?, left_inverse?);
    Some(KklMaps { plant: plant.model.size(), phi, lambda, injection, left_inverse })
}

/// A matrix that is not given.
pub(crate) fn list_of_zeros(count: usize) -> Option<Vec<Expression>> {
    (0..count).map(|_| Expression::parse("0", &Scope::constant()).ok()).collect()
}

/// A region with bounds of every state and every input.
pub(crate) fn bounded(node: &Node, plant: &PlantModel, reader: &mut Reader) -> Option<Region> {
    let region = region::region(node, plant.model.size(), reader)?;
    let inputs = region.input_bounds().map(<[_]>::to_vec).unwrap_or_default();
    let finite = |bounds: &(f64, f64)| bounds.0.is_finite() && bounds.1.is_finite();
    let open = |bounds: &[(f64, f64)], names: &[String]| {
        names.iter().enumerate().find(|(k, _)| !bounds.get(*k).is_some_and(finite)).map(|(_, name)| name.clone())
    };
    let entry = node.entry("region")?;
    let found = open(region.states(), &plant.states).or_else(|| open(&inputs, &plant.inputs));
    if let Some(name) = found {
        let message = format!("`region` has no finite bounds of {name}");
        return reader.refuse(entry.span.clone(), message, "expected finite bounds of every state and every input");
    }
    Some(region)
}

/// The expressions of a list of this length.
pub(crate) fn list(
    node: &Node,
    key: &str,
    (length, why): (usize, &str),
    scope: Result<Scope, ParameterError>,
    reader: &mut Reader,
) -> Option<Vec<Expression>> {
    let node = node.get(key)?;
    let entries = node.list()?;
    if entries.len() != length {
        let message = format!("`{key}` has {}, and {why}", counted(entries.len(), "expression"));
        return reader.refuse(node.span.clone(), message, format!("expected {}", counted(length, "expression")));
    }
    let scope = usable(node, scope, reader)?;
    let parsed: Vec<Option<Expression>> = entries.iter().map(|entry| expression(entry, &scope, reader)).collect();
    parsed.into_iter().collect()
}

/// The expressions of a list of this length, without the time: those of maps that are evaluated without it.
pub(crate) fn list_without_time(
    node: &Node,
    key: &str,
    length: (usize, &str),
    scope: Result<Scope, ParameterError>,
    reader: &mut Reader,
) -> Option<Vec<Expression>> {
    let rows = list(node, key, length, scope, reader)?;
    without_time(node, key, rows, reader)
}

fn without_time(node: &Node, key: &str, rows: Vec<Expression>, reader: &mut Reader) -> Option<Vec<Expression>> {
    let entries = node.get(key)?.list()?;
    match entries.iter().zip(&rows).find(|(_, row)| row.uses_time()) {
        Some((entry, _)) => {
            let message = format!("`{key}` depends on the time t");
            reader.refuse(entry.span.clone(), message, "expected an expression without t")
        }
        None => Some(rows),
    }
}

/// The inequalities of a list, each as the difference that is not positive where it holds; none without the key.
pub(crate) fn inequalities(
    node: &Node,
    key: &str,
    scope: Result<Scope, ParameterError>,
    reader: &mut Reader,
) -> Option<Vec<Expression>> {
    let Some(list) = node.get(key) else { return Some(Vec::new()) };
    let scope = usable(list, scope, reader)?;
    let parsed: Vec<_> = list.list()?.iter().map(|entry| inequality(entry, &scope, reader)).collect();
    without_time(node, key, parsed.into_iter().collect::<Option<_>>()?, reader)
}

/// The expressions of a matrix, row by row; of a square one also from the list of its diagonal.
pub(crate) fn matrix(
    node: &Node,
    key: &str,
    (rows, columns, why): (usize, usize, &str),
    scope: Result<Scope, ParameterError>,
    reader: &mut Reader,
) -> Option<Vec<Expression>> {
    let node = node.get(key)?;
    let entries = node.list()?;
    let is_diagonal = entries.iter().all(|entry| entry.list().is_none());
    let width = entries.first()?.list().map_or(entries.len(), <[Node]>::len);
    if entries.len() != rows || width != columns {
        let size = if is_diagonal {
            format!("the diagonal `{key}` has length {}", entries.len())
        } else {
            format!("`{key}` is {} x {width}", entries.len())
        };
        return reader.refuse(node.span.clone(), format!("{size}, and {why}"), format!("expected {rows} x {columns}"));
    }
    let scope = usable(node, scope, reader)?;
    let zero = Expression::parse("0", &scope).ok()?;
    let mut all = Vec::with_capacity(rows * columns);
    for (i, row) in entries.iter().enumerate() {
        match row.list() {
            Some(row) => all.extend(row.iter().map(|entry| expression(entry, &scope, reader))),
            None => all.extend(
                (0..columns).map(|j| if i == j { expression(row, &scope, reader) } else { Some(zero.clone()) }),
            ),
        }
    }
    all.into_iter().collect()
}

/// The names, unless a parameter has the name of a variable.
fn usable(node: &Node, scope: Result<Scope, ParameterError>, reader: &mut Reader) -> Option<Scope> {
    scope
        .map_err(|error| {
            let message = format!("{error} of the maps of an observer");
            reader.wrong(node.span.clone(), message, "expected another name of this parameter in [plant]");
        })
        .ok()
}

/// A PEBO or a [KKL+PEB]O: the maps, the regression, the estimator.
pub(crate) fn peb(node: &Node, plant: &PlantModel, reader: &mut Reader) -> Option<PebSpec> {
    let region = bounded(node, plant, reader);
    let kkl = kkl_maps(node, plant, reader);
    let maps = regression(node, plant, kkl, reader)?;
    let q = maps.parameters;
    let theta = match (node.get("theta"), &maps.lowest) {
        (Some(theta), _) => region::pairs(theta, "theta", (q, "parameter", "the regression"), reader),
        (None, Some(lowest)) => Some(lowest.iter().map(|least| (*least, least + 1.0)).collect()),
        (None, None) => Some(vec![(-1.0, 1.0); q]),
    };
    let theta = theta?;
    if let Some(k) = theta.iter().position(|(low, high)| !(low.is_finite() && high.is_finite())) {
        let span = node.get("theta")?.span.clone();
        return reader.refuse(span, format!("pair {} of `theta` is not bounded", k + 1), "expected finite ends");
    }
    let estimator = estimator(node.get("estimator")?, (maps.signal.len(), q), reader);
    Some(PebSpec {
        region: region?,
        theta,
        alpha: node.get("alpha")?.number()?,
        estimator: estimator?,
        start: node.get("theta_start").map_or(Some(0.0), Node::number)?,
        window: node.get("window").and_then(Node::number),
        reset: reset(node, &maps, reader)?,
        maps,
    })
}

/// When xi takes over theta_hat; none without the key.
#[expect(clippy::option_option, reason = "the outer one is of a mistake")]
fn reset(node: &Node, maps: &RegressionMaps, reader: &mut Reader) -> Option<Option<ResetSpec>> {
    let Some(entry) = node.entry("reset") else { return Some(None) };
    if node.entry("leakage").is_some() {
        let message = "`reset` conflicts with `leakage`: with leakage theta is not constant";
        return reader.refuse(entry.span.clone(), message, "expected one of them");
    }
    if maps.open.is_empty() {
        let message = "`reset` is given, and Lambda has no row of zeros";
        return reader.refuse(entry.span.clone(), message, "expected it with a row that is only integrated");
    }
    if maps.lowest.is_some() && maps.memory() == FilterMemory::Transformed {
        let message = "`reset` conflicts with `theta_min`: what is missing in xi after a reset may have either sign";
        return reader.refuse(entry.span.clone(), message, "expected one of them");
    }
    let above = entry.node.given("above", Node::number)?;
    Some(Some(ResetSpec { period: entry.node.get("period")?.number()?, above }))
}

/// s, g, m and what theta adds to xi.
fn regression(node: &Node, plant: &PlantModel, kkl: Option<KklMaps>, reader: &mut Reader) -> Option<RegressionMaps> {
    let order = node.get("phi")?.list()?.len();
    let names = MapNames::new(plant, order);
    let rows = node.get("s")?.list()?.len();
    let of_s = format!("`s` has {}", counted(rows, "row"));
    let signal = list(node, "s", (rows, &of_s), names.signal(), reader);
    let known = list(node, "g", (rows, &of_s), names.injection(), reader);
    let entries = node.get("m")?.list()?;
    let q = entries.first()?.list().map_or(entries.len(), <[Node]>::len);
    let regressor = matrix(node, "m", (rows, q, &of_s), names.injection(), reader);
    let kkl = kkl?;
    let open: Vec<usize> = (0..order).filter(|i| is_open(&kkl, *i)).collect();
    let of_phi = format!("`phi` has {}", counted(order, "row"));
    let missing = match node.get("missing") {
        Some(_) => list_without_time(node, "missing", (order, &of_phi), names.missing(q), reader),
        None if open.len() == q => {
            let scope = names.missing(q).ok()?;
            let text = |i: usize| match open.iter().position(|k| *k == i) {
                Some(k) => format!("theta{}", k + 1),
                None => "0".to_owned(),
            };
            (0..order).map(|i| Expression::parse(&text(i), &scope).ok()).collect()
        }
        None => {
            let message = format!(
                "`m` has {}, and Lambda has {}",
                counted(q, "column"),
                match open.len() {
                    1 => "1 row of zeros".to_owned(),
                    count => format!("{count} rows of zeros"),
                }
            );
            let expected = "expected one column for each row of zeros, or `missing`, what theta adds to xi";
            reader.refuse(node.get("m")?.span.clone(), message, expected)
        }
    };
    let lowest = match node.get("theta_min") {
        None => Some(None),
        Some(least) => {
            let numbers = least.numbers()?;
            if numbers.len() == q {
                Some(Some(numbers))
            } else {
                let message = format!("`theta_min` has length {}, and `m` has {}", numbers.len(), counted(q, "column"));
                reader.refuse(least.span.clone(), message, format!("expected length {q}"))
            }
        }
    };
    Some(RegressionMaps {
        signal: signal?,
        known: known?,
        regressor: regressor?,
        missing: missing?,
        parameters: q,
        lowest: lowest?,
        open,
        leakage: node.get("leakage").map_or(Some(0.0), Node::number)?,
        kkl,
    })
}

/// Whether row and column i of Lambda are zeros as they are written.
fn is_open(kkl: &KklMaps, i: usize) -> bool {
    let order = kkl.order();
    let is_zero = |k: usize| kkl.lambda[k].text().trim().parse::<f64>() == Ok(0.0);
    (0..order).all(|j| is_zero(i * order + j) && is_zero(j * order + i))
}

/// The estimator of q parameters in r rows.
fn estimator(node: &Node, (rows, q): (usize, usize), reader: &mut Reader) -> Option<Estimator> {
    let why = format!("the regression has {}", counted(q, "parameter"));
    let gain_node = node.get("gain")?;
    let gain = reader.weight(gain_node, "gain", q, &why)?;
    let made = if node.get("kind")?.text()? == "gradient" {
        Estimator::gradient(gain)
    } else {
        let is_diagonal = gain.iter().enumerate().all(|(k, x)| k % (q + 1) == 0 || *x == 0.0);
        if !is_diagonal {
            let message = "`gain` of drem is a matrix with entries beside its diagonal";
            return reader.refuse(gain_node.span.clone(), message, "expected one number for each parameter");
        }
        let diagonal = gain.diagonal();
        match (node.entry("forgetting"), node.entry("filters")) {
            (Some(a), None) => Estimator::kreisselmeier(diagonal.as_slice(), a.node.number()?),
            (None, Some(beta)) => {
                let poles = beta.node.numbers()?;
                if rows * (poles.len() + 1) != q {
                    let message = format!(
                        "{} of `filters` make {} equations for {}",
                        counted(poles.len(), "number"),
                        rows * (poles.len() + 1),
                        counted(q, "parameter")
                    );
                    let expected = if q % rows == 0 && q > rows {
                        format!("expected {}", counted(q / rows - 1, "number"))
                    } else {
                        "expected `forgetting`, an extension for any number of rows and parameters".to_owned()
                    };
                    return reader.refuse(beta.span.clone(), message, expected);
                }
                Estimator::filters(diagonal.as_slice(), &poles)
            }
            (Some(_), Some(filters)) => {
                let message = "`filters` conflicts with `forgetting`";
                return reader.refuse(filters.span.clone(), message, "expected one of them");
            }
            (None, None) => {
                let message = "the estimator drem has no extension";
                reader.absent(check::head(node), message, "expected `forgetting` or `filters`");
                return None;
            }
        }
    };
    made.map_err(|error| reader.wrong(gain_node.span.clone(), error.to_string(), "expected a positive gain")).ok()
}
