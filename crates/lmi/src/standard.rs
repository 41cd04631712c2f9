//! Standard form of every problem: homogeneous, scaled, symmetric.
//!
//! Constraints `F_k0 + sum x_i F_ki > 0` become `x_0 F_k0 + sum x_i F_ki > 0` together with `x_0 > 0`, with one more
//! scalar unknown (unless all `F_k0` are zero). Feasibility becomes a question about a cone, in which the zero solution
//! is on the boundary and thus excluded, and witnesses of infeasibility always have the same form.
//!
//! Scaling: unknown i is replaced by `2^s_i` times another, and constraint k by `D_k F_k D_k` with D_k diagonal of
//! powers of two, so that the coefficients are as close to 1 as possible. Coefficients that remain far smaller than the
//! others can be omitted for the numerical solution ([`Small`]). Powers of two make the scaling exact, and congruence
//! preserves definiteness. The result does not depend on the units of the plant.

use std::collections::HashSet;

use luenberger_proof::Matrix;

use crate::coefficients::{Entry, Rounded, expand, foreign_variable};
use crate::conic::{Block, BlockEntry, ScaledProduct};
use crate::error::LmiError;
use crate::problem::Problem;
use crate::products::products;

/// A problem after validation, in standard form in binary64.
#[derive(Debug)]
pub struct Standard {
    /// Where the scalar unknowns of each variable start.
    pub(crate) offsets: Vec<usize>,
    /// The number of scalar unknowns of the variables.
    pub(crate) unknowns: usize,
    /// Whether all constants are zero, so that there is no `x_0`.
    pub(crate) homogeneous: bool,
    /// `D_k F_k D_k` in terms of the scaled unknowns, with `x_0`, if there is one, as unknown number `unknowns`; last
    /// the 1x1 block `x_0`, if there is one.
    pub blocks: Vec<Block>,
    /// The exponents s_i, that of `x_0` last.
    pub(crate) unknown_scale: Vec<i32>,
    /// The exponents of the diagonal of D_k.
    pub(crate) row_scale: Vec<Vec<i32>>,
    /// Number of small coefficients omitted.
    pub(crate) left_out: usize,
}

impl Standard {
    /// The number of unknowns of the cone, `x_0` included.
    pub fn cone_unknowns(&self) -> usize {
        self.unknowns + usize::from(!self.homogeneous)
    }
}

/// `2^k`, saturating at the ends of binary64.
pub(crate) fn power(k: i32) -> f64 {
    2.0f64.powi(k.clamp(-1000, 1000))
}

/// How the scale of `x_0` is chosen if the constants require different scales: an upper bound `P < I` in unsuitable
/// units needs the largest, a lower bound the smallest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Their median.
    Middle,
    /// The largest.
    Largest,
    /// The smallest.
    Smallest,
}

/// Treatment of coefficients far below all others, such as the 1e-323 that outward rounding makes of 0. They spread the
/// scales by hundreds of binary digits, which makes the solver fail. A solution computed without them is verified with
/// them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Small {
    /// They are used.
    Kept,
    /// Omit those far below the largest of their constraint, in the given units.
    LeftOutAsGiven,
    /// Omit those far below the others after the best scaling.
    LeftOutAsScaled,
}

/// Validates the problem and converts it to standard form.
///
/// # Errors
/// [`LmiError`] if the problem is ill-posed.
pub fn standard_form(problem: &Problem, anchor: Anchor, small: Small) -> Result<Standard, LmiError> {
    let (offsets, unknowns) = check(problem)?;
    let mut blocks = Vec::with_capacity(problem.constraints.len() + 1);
    let mut homogeneous = true;
    for (name, inequality) in &problem.constraints {
        let matrix = expand::<Rounded>(&inequality.positive, &offsets)
            .map_err(|fault| LmiError::Malformed { place: name.clone(), fault })?;
        require_symmetric(name, &matrix)?;
        let mut block = symmetric_part(&matrix);
        let finite = |e: &BlockEntry| e.constant.is_finite() && e.terms.iter().all(|(_, c)| c.is_finite());
        if !block.entries.iter().all(finite) {
            return Err(LmiError::Overflow { place: name.clone() });
        }
        homogeneous &= block.entries.iter().all(|e| e.constant == 0.0);
        block.products = products(&inequality.positive)
            .into_iter()
            .map(|product| {
                let (offset, count) = (offsets[product.variable.position()], product.variable.unknowns());
                ScaledProduct { product, offset, factors: vec![1.0; count] }
            })
            .collect();
        blocks.push(block);
    }
    if !homogeneous {
        for entry in blocks.iter_mut().flat_map(|block| &mut block.entries) {
            if entry.constant != 0.0 {
                entry.terms.push((unknowns, entry.constant));
                entry.constant = 0.0;
            }
        }
        let entry = BlockEntry { row: 0, column: 0, constant: 0.0, terms: vec![(unknowns, 1.0)] };
        blocks.push(Block::of(1, vec![entry]));
    }
    let count = unknowns + usize::from(!homogeneous);
    let Equilibrium { unknown_scale, row_scale, left_out } = equilibrate(&blocks, unknowns, count, anchor, small);
    for (k, (block, scale)) in blocks.iter_mut().zip(&row_scale).enumerate() {
        for entry in &mut block.entries {
            let place = |unknown: usize| (k, entry.row, entry.column, unknown);
            entry.terms.retain(|(unknown, _)| !left_out.contains(&place(*unknown)));
            for (unknown, c) in &mut entry.terms {
                *c *= power(scale[entry.row] + scale[entry.column] + unknown_scale[*unknown]);
            }
        }
    }
    for (block, scale) in blocks.iter_mut().zip(&row_scale) {
        if !left_out.is_empty() {
            block.products.clear();
        }
        for ScaledProduct { product, offset, factors } in &mut block.products {
            for (i, &k) in scale.iter().enumerate() {
                product.left.row_mut(i).scale_mut(power(k));
                product.right.column_mut(i).scale_mut(power(k));
            }
            factors.iter_mut().zip(&unknown_scale[*offset..]).for_each(|(factor, &k)| *factor *= power(k));
        }
    }
    let left_out = left_out.len();
    Ok(Standard { offsets, unknowns, homogeneous, blocks, unknown_scale, row_scale, left_out })
}

/// Validation before the coefficients are computed; returns the index of each variable's first unknown, and the number
/// of unknowns.
fn check(problem: &Problem) -> Result<(Vec<usize>, usize), LmiError> {
    let (variables, constraints) = (problem.variables.len(), problem.constraints.len());
    if variables == 0 || constraints == 0 {
        return Err(LmiError::NothingToSolve { variables, constraints });
    }
    let mut offsets = Vec::with_capacity(variables);
    let mut unknowns = 0;
    for (k, variable) in problem.variables.iter().enumerate() {
        let (rows, columns) = variable.shape();
        if rows == 0 || columns == 0 {
            return Err(LmiError::Empty { name: variable.name().to_owned(), rows, columns });
        }
        if problem.variables[..k].iter().any(|other| other.name() == variable.name()) {
            return Err(LmiError::DuplicateName { what: "variables", name: variable.name().to_owned() });
        }
        offsets.push(unknowns);
        unknowns += variable.unknowns();
    }
    for (k, (name, inequality)) in problem.constraints.iter().enumerate() {
        if problem.constraints[..k].iter().any(|(other, _)| other == name) {
            return Err(LmiError::DuplicateName { what: "constraints", name: name.clone() });
        }
        let positive = &inequality.positive;
        if let Some(fault) = positive.fault() {
            return Err(LmiError::Malformed { place: name.clone(), fault });
        }
        let (rows, columns) = positive.shape();
        if rows == 0 || columns == 0 {
            return Err(LmiError::Empty { name: name.clone(), rows, columns });
        }
        if rows != columns {
            let fault = crate::Fault::NotSquare { operation: "definiteness", rows, columns };
            return Err(LmiError::Malformed { place: name.clone(), fault });
        }
        if let Some(variable) = foreign_variable(positive, &problem.variables) {
            return Err(LmiError::ForeignVariable { place: name.clone(), variable });
        }
    }
    if let Some(objective) = &problem.objective {
        let place = "objective".to_owned();
        let e = &objective.expression;
        if let Some(fault) = e.fault() {
            return Err(LmiError::Malformed { place, fault });
        }
        if e.shape() != (1, 1) {
            let (rows, columns) = e.shape();
            return Err(LmiError::ObjectiveNotScalar { rows, columns });
        }
        if let Some(variable) = foreign_variable(e, &problem.variables) {
            return Err(LmiError::ForeignVariable { place, variable });
        }
    }
    Ok((offsets, unknowns))
}

/// An error unless the matrix is symmetric but for the rounding of its coefficients.
fn require_symmetric(name: &str, matrix: &Matrix<Entry<Rounded>>) -> Result<(), LmiError> {
    let n = matrix.rows();
    let sizes = |e: &Entry<Rounded>| e.terms.iter().fold(e.constant.0.abs(), |m, (_, c)| m.max(c.0.abs()));
    let largest = matrix.as_slice().iter().map(sizes).fold(0.0, f64::max);
    let mut worst = (0, 0, 0.0);
    for j in 0..n {
        for i in j + 1..n {
            let difference = difference(&matrix[(i, j)], &matrix[(j, i)]);
            if difference > worst.2 {
                worst = (i, j, difference);
            }
        }
    }
    // A coefficient is a sum of products of constants, at most n of them per multiplication: 100 n roundings are
    // generous, and a mistake in a formula is of the order of the data.
    if worst.2 > 100.0 * n as f64 * f64::EPSILON * largest {
        return Err(LmiError::NotSymmetric {
            constraint: name.to_owned(),
            row: worst.0,
            column: worst.1,
            difference: worst.2,
        });
    }
    Ok(())
}

/// The largest difference between two entries' coefficients.
fn difference(x: &Entry<Rounded>, y: &Entry<Rounded>) -> f64 {
    let mut worst = (x.constant.0 - y.constant.0).abs();
    let (mut i, mut j) = (0, 0);
    while i < x.terms.len() || j < y.terms.len() {
        let (a, b) = (x.terms.get(i), y.terms.get(j));
        let gap = match (a, b) {
            (Some((u, c)), Some((v, d))) if u == v => {
                i += 1;
                j += 1;
                c.0 - d.0
            }
            (Some((u, c)), Some((v, _))) if u < v => {
                i += 1;
                c.0
            }
            (Some((_, c)), None) => {
                i += 1;
                c.0
            }
            (_, Some((_, d))) => {
                j += 1;
                d.0
            }
            (None, None) => 0.0,
        };
        worst = worst.max(gap.abs());
    }
    worst
}

/// The lower triangle of `(M + M') / 2`.
fn symmetric_part(matrix: &Matrix<Entry<Rounded>>) -> Block {
    let order = matrix.rows();
    let mut entries = Vec::with_capacity(order * (order + 1) / 2);
    for row in 0..order {
        for column in 0..=row {
            let (x, y) = (&matrix[(row, column)], &matrix[(column, row)]);
            // Where the two agree, as they do but for rounding, the half of their sum is either of them.
            let constant = 0.5 * x.constant.0 + 0.5 * y.constant.0;
            let terms = if x.terms == y.terms {
                x.terms.iter().map(|(unknown, c)| (*unknown, c.0)).collect()
            } else {
                let mut terms: Vec<(usize, f64)> =
                    x.terms.iter().chain(&y.terms).map(|(unknown, c)| (*unknown, 0.5 * c.0)).collect();
                terms.sort_by_key(|&(unknown, _)| unknown);
                let mut merged: Vec<(usize, f64)> = Vec::with_capacity(terms.len());
                for (unknown, c) in terms {
                    match merged.last_mut() {
                        Some((last, sum)) if *last == unknown => *sum += c,
                        _ => merged.push((unknown, c)),
                    }
                }
                merged
            };
            entries.push(BlockEntry { row, column, constant, terms });
        }
    }
    Block::of(order, entries)
}

/// One coefficient of the standard form before scaling: its block, row, column, unknown, and log2 of its size.
struct Coefficient {
    block: usize,
    row: usize,
    column: usize,
    unknown: usize,
    size: f64,
}

impl Coefficient {
    fn place(&self) -> (usize, usize, usize, usize) {
        (self.block, self.row, self.column, self.unknown)
    }
}

/// Scales as exponents of two, in the making.
struct Scales {
    unknowns: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

impl Scales {
    fn of(&self, c: &Coefficient) -> f64 {
        c.size + self.rows[c.block][c.row] + self.rows[c.block][c.column] + self.unknowns[c.unknown]
    }
}

/// Exponents that bring the scaled coefficients near 1.
///
/// First the unknowns of the variables, all coefficients as far as possible: the least-squares fit of
/// `log2 |c| + d_row + d_column + s_unknown` to zero (Curtis and Reid, J. Inst. Maths Applics 10, 1972, for matrices).
/// Unlike a fit of the largest coefficients it finds the units in which a plant is written: if some change of units
/// makes all coefficients 1, it is the answer. Coefficients that are small by accident are held back by weights that
/// fall off beyond eight binary digits. Then `x_0`, and last the rows, by their largest coefficient: where a constant
/// dwarfs an unknown or the other way round, the smaller of the two does not matter.
fn equilibrate(blocks: &[Block], unknowns: usize, count: usize, anchor: Anchor, small: Small) -> Equilibrium {
    let mut scales =
        Scales { unknowns: vec![0.0; count], rows: blocks.iter().map(|block| vec![0.0; block.order]).collect() };
    let (mut coefficients, mut constants) = (Vec::new(), Vec::new());
    for (block, content) in blocks.iter().enumerate() {
        for entry in &content.entries {
            for &(unknown, c) in entry.terms.iter().filter(|(_, c)| *c != 0.0) {
                let list = if unknown < unknowns { &mut coefficients } else { &mut constants };
                list.push(Coefficient { block, row: entry.row, column: entry.column, unknown, size: c.abs().log2() });
            }
        }
    }
    let all: Vec<(usize, usize, usize, usize)> = coefficients.iter().map(Coefficient::place).collect();
    if small == Small::LeftOutAsGiven {
        let mut largest = vec![f64::NEG_INFINITY; blocks.len()];
        for c in &coefficients {
            largest[c.block] = c.size.max(largest[c.block]);
        }
        coefficients.retain(|c| c.size > largest[c.block] - ROUNDED_AWAY);
    }
    fit(&mut scales, &coefficients);
    if small == Small::LeftOutAsScaled {
        // The worst half first: what is left may fit once they are gone.
        for _ in 0..ROUNDS {
            let least = coefficients.iter().map(|c| scales.of(c)).fold(0.0, f64::min);
            if least > -NEGLIGIBLE {
                break;
            }
            coefficients.retain(|c| scales.of(c) > 0.5 * least);
            scales.unknowns.iter_mut().chain(scales.rows.iter_mut().flatten()).for_each(|scale| *scale = 0.0);
            fit(&mut scales, &coefficients);
        }
    }
    let kept: HashSet<_> = coefficients.iter().map(Coefficient::place).collect();
    let left_out = all.into_iter().filter(|place| !kept.contains(place)).collect();
    // The last constant is the coefficient of `x_0` in its own block, which asks for nothing.
    let own = constants.len().saturating_sub(1);
    let mut wanted: Vec<f64> = constants[..own].iter().map(|c| -scales.of(c)).collect();
    wanted.sort_by(f64::total_cmp);
    if let (Some(x0), Some(&smallest), Some(&largest)) =
        (scales.unknowns.get_mut(unknowns), wanted.first(), wanted.last())
    {
        *x0 = match anchor {
            Anchor::Middle => wanted[wanted.len() / 2],
            Anchor::Largest => largest,
            Anchor::Smallest => smallest,
        };
    }
    coefficients.append(&mut constants);
    level_rows(&mut scales, &coefficients);
    let rounded = |x: &f64| x.round() as i32;
    Equilibrium {
        unknown_scale: scales.unknowns.iter().map(rounded).collect(),
        row_scale: scales.rows.iter().map(|rows| rows.iter().map(rounded).collect()).collect(),
        left_out,
    }
}

/// A coefficient that remains this many binary digits below 1 after the best scaling may be omitted. The scales
/// compensate half of the distance, so that it is twice as many digits below the others.
const NEGLIGIBLE: f64 = 16.0;

/// Binary digits below the largest coefficient of a constraint.
const ROUNDED_AWAY: f64 = 60.0;

/// How often coefficients are omitted and the scales fitted again.
const ROUNDS: usize = 8;

/// The exponents of the scales, and the omitted coefficients (block, row, column, unknown).
struct Equilibrium {
    unknown_scale: Vec<i32>,
    row_scale: Vec<Vec<i32>>,
    left_out: HashSet<(usize, usize, usize, usize)>,
}

/// Rounds of relaxation; the scales need be right to a digit, not to sixteen.
const SWEEPS: usize = 40;

/// The weighted least-squares fit, by relaxation: the unknowns and the rows take turns.
fn fit(scales: &mut Scales, coefficients: &[Coefficient]) {
    for sweep in 0..SWEEPS {
        // The first half finds the units, all coefficients counting alike; the second gives outliers less weight.
        let weight = |r: f64| if sweep < SWEEPS / 2 { 1.0 } else { 1.0 / (1.0 + (r / 8.0).powi(2)) };
        let mut sums = vec![(0.0, 0.0); scales.unknowns.len()];
        for c in coefficients {
            let r = scales.of(c);
            sums[c.unknown].0 += weight(r) * r;
            sums[c.unknown].1 += weight(r);
        }
        for (scale, (sum, total)) in scales.unknowns.iter_mut().zip(&sums) {
            if *total > 0.0 {
                *scale -= sum / total;
            }
        }
        let mut sums: Vec<Vec<(f64, f64)>> = scales.rows.iter().map(|rows| vec![(0.0, 0.0); rows.len()]).collect();
        for c in coefficients {
            let r = scales.of(c);
            for place in [c.row, c.column] {
                sums[c.block][place].0 += weight(r) * r;
                sums[c.block][place].1 += weight(r);
            }
        }
        for (scale, (sum, total)) in scales.rows.iter_mut().flatten().zip(sums.iter().flatten()) {
            if *total > 0.0 {
                // Half a step: two rows share every entry, and both move at once.
                *scale -= 0.5 * sum / total;
            }
        }
    }
}

/// Brings the largest coefficient of every row near 1, by Ruiz's iteration on the rows alone, which halves the
/// logarithms each time.
fn level_rows(scales: &mut Scales, coefficients: &[Coefficient]) {
    for _ in 0..8 {
        let mut largest: Vec<Vec<f64>> = scales.rows.iter().map(|rows| vec![f64::NEG_INFINITY; rows.len()]).collect();
        for c in coefficients {
            let size = scales.of(c);
            for place in [c.row, c.column] {
                largest[c.block][place] = largest[c.block][place].max(size);
            }
        }
        for (scale, size) in scales.rows.iter_mut().flatten().zip(largest.iter().flatten()) {
            if size.is_finite() {
                *scale -= 0.5 * size;
            }
        }
    }
}
