//! Regression of a map by polynomials on the cells of a tree.
//!
//! Best first: the leaf with the largest sum of squared errors is split next, across the middle of its samples'
//! bounding box, along the coordinate with the smallest sum of the *roots* of the two sums: a split that leaves the
//! whole error on one side is better than one that halves it, because that side can be split again. Samples near the
//! split count on both sides. A leaf is fitted by ridge-regularised least squares on the normal equations, in
//! coordinates that map the bounding box of its samples to [-1, 1]. The ridge bounds the coefficients along directions
//! in which the samples of a leaf do not spread: T(box) is a surface, a leaf of it is nearly flat, and off the surface
//! (noise, the transient) the polynomial must stay bounded.
//!
//! Sources: L. Breiman et al., Classification and Regression Trees, Wadsworth 1984, for the tree; J. R. Quinlan,
//! Learning with continuous classes, 1992, for models in its leaves.

use luenberger_observers::numerical_kkl::polynomial_tree::{monomial_count, monomials};
use luenberger_observers::numerical_kkl::{Branch, Node, PolynomialTree};

use crate::numerical_kkl::error::NumericalKklError;

/// Limits of the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Total degree of the polynomials.
    pub degree: usize,
    /// Most leaves.
    pub leaves: usize,
    /// Ridge, relative to the mean square of the monomials.
    pub ridge: f64,
}

/// Samples of a map: points of I coordinates, values of O, one sample after the other.
#[derive(Clone, Copy)]
pub struct Samples<'s, const I: usize, const O: usize> {
    /// The points.
    pub points: &'s [[f64; I]],
    /// The values at them.
    pub values: &'s [[f64; O]],
    /// Scale of each value.
    pub scale: [f64; O],
}

/// Rows of `width` numbers.
#[derive(Clone, Copy)]
struct Rows<'s> {
    numbers: &'s [f64],
    width: usize,
}

impl<'s> Rows<'s> {
    fn new<const W: usize>(rows: &'s [[f64; W]]) -> Self {
        Self { numbers: rows.as_flattened(), width: W }
    }

    fn row(self, index: u32) -> &'s [f64] {
        &self.numbers[index as usize * self.width..][..self.width]
    }

    /// The bounding box of some rows, as centre and half-width.
    fn bounds(self, members: &[u32]) -> Vec<(f64, f64)> {
        let mut bounds = vec![(f64::INFINITY, f64::NEG_INFINITY); self.width];
        for &member in members {
            for ((low, high), &x) in bounds.iter_mut().zip(self.row(member)) {
                (*low, *high) = (low.min(x), high.max(x));
            }
        }
        bounds.into_iter().map(|(low, high)| (0.5 * (low + high), 0.5 * (high - low))).collect()
    }
}

/// [`Samples`] whose sizes are known at run time: what follows is compiled once, not for each pair of sizes.
#[derive(Clone, Copy)]
struct FlatSamples<'s> {
    points: Rows<'s>,
    values: Rows<'s>,
    scale: &'s [f64],
}

struct Leaf {
    samples: Vec<u32>,
    data: Vec<f64>,
    squares: f64,
    /// Whether a cut was tried and left too few samples on one side.
    whole: bool,
}

/// A tree on the heap.
pub(crate) type Tree<const I: usize, const O: usize> = PolynomialTree<f64, Vec<Node<f64>>, Vec<f64>, I, O>;

/// Samples of a leaf between two calls of the progress: the largest degree, 12 in four coordinates, costs a millisecond
/// for each.
const BETWEEN_CALLS: usize = 256;

/// Called with the number of leaves at intervals during a fit; its error ends the fit.
type Listener<'a> = dyn FnMut(usize) -> Result<(), NumericalKklError> + 'a;

/// The tree of at most `budget.leaves` leaves that fits the samples.
///
/// # Errors
/// That of `progress`, and those of [`PolynomialTree::new`].
pub fn fit<const I: usize, const O: usize>(
    samples: Samples<'_, I, O>,
    budget: Budget,
    progress: &mut Listener<'_>,
) -> Result<Tree<I, O>, NumericalKklError> {
    let flat =
        FlatSamples { points: Rows::new(samples.points), values: Rows::new(samples.values), scale: &samples.scale };
    let (nodes, numbers) = grow(flat, samples.points.len() as u32, budget, progress)?;
    Ok(PolynomialTree::new(budget.degree, nodes, numbers)?)
}

/// The comparisons and the numbers of the leaves of a tree.
fn grow(
    samples: FlatSamples<'_>,
    count: u32,
    budget: Budget,
    progress: &mut Listener<'_>,
) -> Result<(Vec<Node<f64>>, Vec<f64>), NumericalKklError> {
    let all: Vec<u32> = (0..count).collect();
    // Two samples per coefficient of a leaf: fewer would be interpolation, not regression.
    let least = 2 * monomial_count(samples.points.width, budget.degree);
    let mut leaves = vec![fit_leaf(samples, all, budget, &mut || progress(0))?];
    let mut nodes: Vec<Node<f64>> = Vec::new();
    // Where the branch to leaf i hangs: node, and whether above.
    let mut hooks: Vec<Option<(usize, bool)>> = vec![None];
    while leaves.len() < budget.leaves {
        let worst = (0..leaves.len())
            .filter(|&i| !leaves[i].whole && leaves[i].squares > 0.0)
            .max_by(|&i, &j| leaves[i].squares.total_cmp(&leaves[j].squares).then(j.cmp(&i)));
        let Some(index) = worst else { break };
        let new = leaves.len();
        let cut = best_cut(samples, &leaves[index], budget, least, &mut || progress(new))?;
        let Some((axis, threshold, below, above)) = cut else {
            leaves[index].whole = true;
            continue;
        };
        let node = nodes.len();
        nodes.push(Node {
            axis: axis as u16,
            threshold,
            below: Branch::Leaf(index as u16),
            above: Branch::Leaf(new as u16),
        });
        if let Some((parent, is_above)) = hooks[index] {
            let branch = Branch::Node(node as u16);
            if is_above { nodes[parent].above = branch } else { nodes[parent].below = branch }
        }
        (leaves[index], hooks[index]) = (below, Some((node, false)));
        leaves.push(above);
        hooks.push(Some((node, true)));
        progress(leaves.len())?;
    }
    Ok((nodes, leaves.into_iter().flat_map(|leaf| leaf.data).collect()))
}

/// Samples this far across a cut, in half-widths of the cell, count on both sides: polynomials are worst at the border
/// of their samples, and so the border of the samples is not the border of the cell. Measured on the reverse Duffing
/// oscillator (cut-off 1.5, 64 leaves): with less, 0.02, single estimates are off by 0.5 near the origin; with more,
/// 0.1, all errors are three to ten times as large.
const OVERLAP: f64 = 0.035;

/// How far beyond the values of its samples a leaf may go, in parts of their range.
const OVERSHOOT: f64 = 0.05;

/// A cut: the axis, where, and the two leaves.
type Cut = (usize, f64, Leaf, Leaf);

/// The cut that leaves the smallest sum of root sums of squares, or none that leaves enough samples on both sides.
fn best_cut(
    samples: FlatSamples<'_>,
    leaf: &Leaf,
    budget: Budget,
    least: usize,
    alive: &mut dyn FnMut() -> Result<(), NumericalKklError>,
) -> Result<Option<Cut>, NumericalKklError> {
    let mut best: Option<Cut> = None;
    for (axis, (threshold, half)) in samples.points.bounds(&leaf.samples).into_iter().enumerate() {
        if half <= 0.0 {
            continue;
        }
        let side = |keep: &dyn Fn(f64) -> bool| -> Vec<u32> {
            leaf.samples.iter().copied().filter(|&s| keep(samples.points.row(s)[axis])).collect()
        };
        let overlap = OVERLAP * half;
        let (below, above) = (side(&|x| x < threshold + overlap), side(&|x| x >= threshold - overlap));
        if below.len() < least || above.len() < least {
            continue;
        }
        let (below, above) = (fit_leaf(samples, below, budget, alive)?, fit_leaf(samples, above, budget, alive)?);
        let roots = |below: &Leaf, above: &Leaf| below.squares.sqrt() + above.squares.sqrt();
        if best.as_ref().is_none_or(|(_, _, b, a)| roots(&below, &above) < roots(b, a)) {
            best = Some((axis, threshold, below, above));
        }
    }
    Ok(best)
}

/// One polynomial through these samples.
fn fit_leaf(
    samples: FlatSamples<'_>,
    members: Vec<u32>,
    budget: Budget,
    alive: &mut dyn FnMut() -> Result<(), NumericalKklError>,
) -> Result<Leaf, NumericalKklError> {
    let frame = samples.points.bounds(&members);
    // A coordinate that does not vary carries nothing; its local coordinate is 0.
    let rates: Vec<f64> = frame.iter().map(|&(_, half)| if half > 0.0 { 1.0 / half } else { 0.0 }).collect();
    let q = monomial_count(samples.points.width, budget.degree);
    let (mut local, mut row) = (vec![0.0; samples.points.width], Vec::with_capacity(q));
    let mut gram = vec![0.0; q * q];
    let mut right = vec![0.0; samples.values.width * q];
    let mut expand = |sample: u32, row: &mut Vec<f64>| {
        for (i, x) in samples.points.row(sample).iter().enumerate() {
            local[i] = (x - frame[i].0) * rates[i];
        }
        row.clear();
        monomials(&local, budget.degree, 1.0, &mut |monomial| row.push(monomial));
    };
    for (k, &sample) in members.iter().enumerate() {
        if k % BETWEEN_CALLS == 0 {
            alive()?;
        }
        expand(sample, &mut row);
        for (i, &x) in row.iter().enumerate() {
            for (sum, &y) in gram[i * q..][..=i].iter_mut().zip(&row) {
                *sum += x * y;
            }
        }
        for (right, value) in right.chunks_mut(q).zip(samples.values.row(sample)) {
            for (sum, &x) in right.iter_mut().zip(&row) {
                *sum += x * value;
            }
        }
    }
    let mean: f64 = (0..q).map(|i| gram[i * q + i]).sum::<f64>() / q as f64;
    // The constant is not penalised: the ridge must not move the mean. Order: the constant is the last monomial.
    for i in 0..q - 1 {
        gram[i * q + i] += budget.ridge * mean;
    }
    factor(&mut gram, q);
    for column in right.chunks_mut(q) {
        substitute(&gram, q, column);
    }
    let mut squares = 0.0;
    for &sample in &members {
        expand(sample, &mut row);
        let given = samples.values.row(sample).iter().zip(samples.scale);
        for (coefficients, (given, scale)) in right.chunks(q).zip(given) {
            let value: f64 = row.iter().zip(coefficients).map(|(x, c)| x * c).sum();
            squares += ((value - given) / scale).powi(2);
        }
    }
    let range = samples.values.bounds(&members);
    let reach = 1.0 + 2.0 * OVERSHOOT;
    let data = (frame.iter().map(|(centre, _)| *centre))
        .chain(rates)
        .chain(range.iter().map(|(middle, half)| middle - reach * half))
        .chain(range.iter().map(|(middle, half)| middle + reach * half))
        .chain(right)
        .collect();
    Ok(Leaf { samples: members, data, squares, whole: false })
}

/// Cholesky, rows of the lower triangle in place; a pivot lost to rounding takes its direction out.
fn factor(gram: &mut [f64], q: usize) {
    for i in 0..q {
        let original = gram[i * q + i];
        for j in 0..=i {
            let (before, rest) = gram.split_at_mut(i * q);
            let (row, other) = if i == j { (&*rest, &rest[..j]) } else { (&*rest, &before[j * q..][..j]) };
            let dot: f64 = row[..j].iter().zip(other).map(|(a, b)| a * b).sum();
            let value = rest[j] - dot;
            rest[j] = if i == j {
                // Rounding leaves about q EPSILON of the diagonal.
                if value > q as f64 * f64::EPSILON * original { value.sqrt() } else { f64::INFINITY }
            } else {
                value / before[j * q + j]
            };
        }
    }
}

/// `L L' x = b` in place.
fn substitute(factor: &[f64], q: usize, b: &mut [f64]) {
    for i in 0..q {
        let dot: f64 = factor[i * q..][..i].iter().zip(b.iter()).map(|(l, x)| l * x).sum();
        b[i] = (b[i] - dot) / factor[i * q + i];
    }
    for i in (0..q).rev() {
        let dot: f64 = (i + 1..q).map(|k| factor[k * q + i] * b[k]).sum();
        b[i] = (b[i] - dot) / factor[i * q + i];
    }
}
