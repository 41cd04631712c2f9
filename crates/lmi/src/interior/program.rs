//! Internal form of the program: scaled, sparse, by constraint, with dense blocks separate from scalars.

use std::collections::BTreeMap;

use faer::Mat;
use nalgebra::DMatrix;

use super::structured::Structured;
use crate::conic::ConicProgram;

/// A primal-dual pair of points, not verified.
#[derive(Debug, Clone)]
pub(crate) struct Iterate {
    pub(crate) unknowns: Vec<f64>,
    /// One for each block.
    pub(crate) multipliers: Vec<DMatrix<f64>>,
}

/// An entry of the upper triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    pub(super) row: usize,
    pub(super) column: usize,
    pub(super) value: f64,
}

/// From this order on, products of matrices cost less than the entries.
const WORTH_A_PRODUCT: usize = 6;

/// A block of more than one row.
#[derive(Debug)]
pub struct Dense {
    pub order: usize,
    pub(super) constant: Vec<Entry>,
    /// Those of the products last, and by number of entries, the most first.
    pub(super) constraints: Vec<(usize, Vec<Entry>)>,
    /// The last constraints as products of matrices, if that is the faster way to assemble them.
    pub products: Vec<Structured>,
    /// The number of constraints that are not among the products.
    pub(super) others: usize,
}

/// A block of one row.
#[derive(Debug)]
pub(super) struct Number {
    pub(super) constant: f64,
    pub(super) terms: Vec<(usize, f64)>,
}
/// The program with constraints of norm 1, and costs and constants of size 1.
#[derive(Debug)]
pub struct Scaled {
    pub(super) cost: Vec<f64>,
    /// The blocks of more than one row.
    pub dense: Vec<Dense>,
    pub(super) numbers: Vec<Number>,
    /// For each block of the program, whether it is the k-th of `numbers` or of `dense`.
    pub(super) places: Vec<(bool, usize)>,
    /// x of the program is this times x.
    pub(super) unknown_scale: Vec<f64>,
    /// Y of the program is this times Y.
    pub(super) multiplier_scale: f64,
    pub(super) rows: usize,
    /// As in [`ConicProgram`].
    pub(super) enough: f64,
}

impl Scaled {
    /// The program in this form.
    pub fn of(program: &ConicProgram) -> Self {
        let m = program.cost.len();
        let weight = |row: usize, column: usize| if row == column { 1.0 } else { 2.0 };
        let (mut squares, mut constant_square) = (vec![0.0; m], 0.0);
        for entry in program.blocks.iter().flat_map(|block| &block.entries) {
            let w = weight(entry.row, entry.column);
            constant_square += w * entry.constant * entry.constant;
            for &(unknown, c) in &entry.terms {
                squares[unknown] += w * c * c;
            }
        }
        let one_over = |size: f64| if size > 0.0 && size.is_finite() { 1.0 / size } else { 1.0 };
        let constraint: Vec<f64> = squares.iter().map(|s: &f64| one_over(s.sqrt())).collect();
        let constant = one_over(f64::sqrt(constant_square));
        let cost: Vec<f64> = program.cost.iter().zip(&constraint).map(|(c, s)| c * s).collect();
        let cost_scale = one_over(cost.iter().fold(0.0, |m: f64, c| m.max(c.abs())));
        let (mut dense, mut numbers, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for block in &program.blocks {
            if block.order == 1 {
                places.push((true, numbers.len()));
                let mut number = Number { constant: 0.0, terms: Vec::new() };
                for entry in &block.entries {
                    number.constant += constant * entry.constant;
                    number.terms.extend(entry.terms.iter().map(|&(i, c)| (i, c * constraint[i])));
                }
                numbers.push(number);
                continue;
            }
            places.push((false, dense.len()));
            let mut by_unknown: BTreeMap<usize, Vec<Entry>> = BTreeMap::new();
            let mut constants = Vec::new();
            for entry in &block.entries {
                let (row, column) = (entry.row.min(entry.column), entry.row.max(entry.column));
                if entry.constant != 0.0 {
                    constants.push(Entry { row, column, value: constant * entry.constant });
                }
                for &(i, c) in entry.terms.iter().filter(|(_, c)| *c != 0.0) {
                    by_unknown.entry(i).or_default().push(Entry { row, column, value: c * constraint[i] });
                }
            }
            let mut constraints: Vec<_> = by_unknown.into_iter().collect();
            // As a matrix lies in memory.
            for (_, entries) in &mut constraints {
                entries.sort_by_key(|e| (e.column, e.row));
            }
            let products: Vec<Structured> = block.products.iter().map(|p| Structured::of(p, &constraint)).collect();
            let is_product = |unknown: usize| products.iter().any(|product| product.unknowns().contains(&unknown));
            constraints.sort_by_key(|(unknown, entries)| (is_product(*unknown), std::cmp::Reverse(entries.len())));
            let others = constraints.iter().filter(|(unknown, _)| !is_product(*unknown)).count();
            let entries: usize = constraints[others..].iter().map(|(_, entries)| entries.len()).sum();
            dense.push(if entries > 0 && block.order >= WORTH_A_PRODUCT {
                Dense { order: block.order, constant: constants, constraints, products, others }
            } else {
                let others = constraints.len();
                constraints.sort_by_key(|(_, entries)| std::cmp::Reverse(entries.len()));
                Dense { order: block.order, constant: constants, constraints, products: Vec::new(), others }
            });
        }
        let rows = program.blocks.iter().map(|block| block.order).sum();
        Self {
            cost: cost.iter().map(|c| c * cost_scale).collect(),
            dense,
            numbers,
            places,
            unknown_scale: constraint.iter().map(|s| s / constant).collect(),
            multiplier_scale: 1.0 / cost_scale,
            rows,
            enough: program.enough,
        }
    }

    pub(super) fn original(&self, x: &[f64], dual: &Blocks) -> Iterate {
        let unknowns = x.iter().zip(&self.unknown_scale).map(|(x, s)| x * s).collect();
        Iterate { unknowns, multipliers: self.original_multipliers(dual) }
    }

    pub(super) fn original_multipliers(&self, y: &Blocks) -> Vec<DMatrix<f64>> {
        self.places
            .iter()
            .map(|&(is_number, k)| {
                if is_number {
                    DMatrix::from_element(1, 1, y.numbers[k] * self.multiplier_scale)
                } else {
                    let y = &y.dense[k];
                    DMatrix::from_fn(y.nrows(), y.ncols(), |i, j| y[(i, j)] * self.multiplier_scale)
                }
            })
            .collect()
    }

    /// The multipliers of an iterate of this program.
    pub(super) fn multipliers(&self, iterate: &Iterate) -> Blocks {
        let mut blocks = Blocks { dense: Vec::new(), numbers: Vec::new() };
        for (y, &(is_number, _)) in iterate.multipliers.iter().zip(&self.places) {
            if is_number {
                blocks.numbers.push(y[(0, 0)] / self.multiplier_scale);
            } else {
                blocks.dense.push(Mat::from_fn(y.nrows(), y.ncols(), |i, j| y[(i, j)] / self.multiplier_scale));
            }
        }
        blocks
    }

    /// `F_0 + sum x_i F_i`, or without F_0: the dense blocks and the numbers.
    pub(super) fn pencil(&self, x: &[f64], with_constant: bool) -> Blocks {
        let dense = self
            .dense
            .iter()
            .map(|block| {
                let mut sum = Mat::zeros(block.order, block.order);
                let mut put = |entries: &[Entry], factor: f64| {
                    for e in entries {
                        sum[(e.row, e.column)] += factor * e.value;
                        if e.row != e.column {
                            sum[(e.column, e.row)] += factor * e.value;
                        }
                    }
                };
                if with_constant {
                    put(&block.constant, 1.0);
                }
                for (i, entries) in &block.constraints {
                    put(entries, x[*i]);
                }
                sum
            })
            .collect();
        let numbers = self
            .numbers
            .iter()
            .map(|number| {
                let constant = if with_constant { number.constant } else { 0.0 };
                constant + number.terms.iter().map(|&(i, c)| c * x[i]).sum::<f64>()
            })
            .collect();
        Blocks { dense, numbers }
    }

    /// `tr(F_i M)` for every i, of a matrix that need not be symmetric.
    pub(super) fn adjoint(&self, m: &Blocks) -> Vec<f64> {
        let mut out = vec![0.0; self.cost.len()];
        for (block, m) in self.dense.iter().zip(&m.dense) {
            for (i, entries) in &block.constraints {
                out[*i] += entries.iter().map(|e| pair(e, |r, c| m[(r, c)])).sum::<f64>();
            }
        }
        for (number, m) in self.numbers.iter().zip(&m.numbers) {
            for &(i, c) in &number.terms {
                out[i] += c * m;
            }
        }
        out
    }

    /// `tr(F_0 M)`.
    pub(super) fn constant_part(&self, m: &Blocks) -> f64 {
        let of_dense: f64 = self
            .dense
            .iter()
            .zip(&m.dense)
            .map(|(block, m)| block.constant.iter().map(|e| pair(e, |r, c| m[(r, c)])).sum::<f64>())
            .sum();
        of_dense + self.numbers.iter().zip(&m.numbers).map(|(n, m)| n.constant * m).sum::<f64>()
    }
}

/// What an entry of the upper triangle, with its mirror image, takes from a matrix.
pub(super) fn pair(e: &Entry, m: impl Fn(usize, usize) -> f64) -> f64 {
    if e.row == e.column { e.value * m(e.row, e.row) } else { e.value * (m(e.row, e.column) + m(e.column, e.row)) }
}

/// A matrix in blocks.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    pub(super) dense: Vec<Mat<f64>>,
    pub(super) numbers: Vec<f64>,
}

impl Blocks {
    pub(super) fn size(&self) -> f64 {
        let dense: f64 = self.dense.iter().map(Mat::squared_norm_l2).sum();
        (dense + self.numbers.iter().map(|x| x * x).sum::<f64>()).sqrt()
    }
}
