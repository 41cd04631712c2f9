//! Regions, bounds and sectors.

use luenberger_design::Region;
use luenberger_plants::Dimensions;
use luenberger_proof::wording::counted;

use super::Reader;
use super::tree::Node;

pub(crate) fn region(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<Region> {
    node.get("region").map_or_else(|| Some(Region::everywhere(size.states)), |table| of_table(table, size, reader))
}

/// The region of this table.
pub(crate) fn of_table(table: &Node, size: Dimensions, reader: &mut Reader) -> Option<Region> {
    let mut region = match table.get("states") {
        Some(states) => Region::new(&bounds(states, "states", size.states, "state", reader)?),
        None => Region::everywhere(size.states),
    };
    if let Some(inputs) = table.get("inputs") {
        region = region.inputs(&bounds(inputs, "inputs", size.inputs, "input", reader)?);
    }
    if let Some(time) = table.get("time") {
        let (from, to) = bound(time)?;
        region = region.time(from, to);
    }
    Some(region)
}

pub(crate) fn bound(node: &Node) -> Option<(f64, f64)> {
    match node.list()? {
        [lower, upper] => Some((lower.number()?, upper.number()?)),
        _ => None,
    }
}

pub(crate) fn bounds(node: &Node, name: &str, length: usize, of: &str, reader: &mut Reader) -> Option<Vec<(f64, f64)>> {
    pairs(node, name, (length, of, "the plant"), reader)
}

/// The same with finite ends, the lower one less.
pub(crate) fn finite_bounds(
    node: &Node,
    name: &str,
    (length, of): (usize, &str),
    reader: &mut Reader,
) -> Option<Vec<(f64, f64)>> {
    let pairs = bounds(node, name, length, of, reader)?;
    if let Some(k) = pairs.iter().position(|(low, high)| !(low.is_finite() && high.is_finite() && low < high)) {
        let message = format!("pair {} of `{name}` is from {} to {}", k + 1, pairs[k].0, pairs[k].1);
        return reader.refuse(node.span.clone(), message, "expected finite ends, the lower one less");
    }
    Some(pairs)
}

/// As many pairs as `whose` has of `of`.
pub(crate) fn pairs(
    node: &Node,
    name: &str,
    (length, of, whose): (usize, &str, &str),
    reader: &mut Reader,
) -> Option<Vec<(f64, f64)>> {
    let bounds: Vec<(f64, f64)> = node.list()?.iter().map(bound).collect::<Option<_>>()?;
    if bounds.len() != length {
        let message =
            format!("`{name}` has {}, and {whose} has {}", counted(bounds.len(), "pair"), counted(length, of));
        return reader.refuse(node.span.clone(), message, format!("expected {}", counted(length, "pair")));
    }
    Some(bounds)
}
