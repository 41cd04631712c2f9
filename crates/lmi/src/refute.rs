//! Exact witnesses of infeasibility, obtained by correcting the solver's multipliers.
//!
//! `F_k(x) > 0` for all k has no solution iff there are `Z_k >= 0`, not all zero, with `sum_k tr(F_ki Z_k) = 0` for
//! every unknown i and `sum_k tr(F_k0 Z_k) <= 0` (theorem of alternatives for open cones; no constraint qualification
//! is needed). The solver's multipliers satisfy the equations only to about nine digits, which is not a proof.
//! Correction:
//!
//! 1. parts that are nearly zero are set to zero: blocks, rows, and directions in the kernel of a multiplier that are
//!    small rationals;
//! 2. the equations, whose coefficients are exact dyadic numbers, are solved exactly for as many entries as there are
//!    independent equations; the other entries keep the solver's values ([`equations`](crate::equations));
//! 3. the result is integer after scaling; that it is semidefinite is proved by exact elimination in
//!    `luenberger-proof`.
//!
//! Step 2 changes a multiplier by the solver's error times the condition number of the equations. It stays semidefinite
//! if its kernel is enforced by the equations or by step 1; otherwise the attempt fails, and the verdict is undecided.

use dashu_int::IBig;
use luenberger_proof::{Exact, Matrix, Ring, positive_semidefinite};
use nalgebra::DMatrix;

use crate::coefficients::{Entry, expand};
use crate::equations::{Row, solve_near};
use crate::problem::{Problem, Settings};
use crate::rational::near_rational;
use crate::solution::{Infeasibility, Multiplier};
use crate::standard::{Anchor, Small, Standard, standard_form};

/// Relative thresholds below which a part of the solver's multipliers is set to zero, tried in this order. A wrong
/// choice costs time but cannot produce a wrong witness.
const ZERO_GUESSES: [f64; 4] = [1e-6, 1e-4, 1e-8, 1e-3];

/// The constraints with exact coefficients, lower triangle of `F + F'`, so that off the diagonal an entry counts twice
/// as in a trace, and on the diagonal it is twice too large: halved where used.
struct ExactConstraints {
    blocks: Vec<Matrix<Entry<Exact>>>,
    unknowns: usize,
}

impl ExactConstraints {
    /// `None` for a constraint with a constant that is no number.
    fn new(problem: &Problem) -> Option<Self> {
        let mut offsets = Vec::with_capacity(problem.variables.len());
        let mut unknowns = 0;
        for variable in &problem.variables {
            offsets.push(unknowns);
            unknowns += variable.unknowns();
        }
        let expanded = problem.constraints.iter().map(|(_, inequality)| expand(&inequality.positive, &offsets).ok());
        Some(Self { blocks: expanded.collect::<Option<_>>()?, unknowns })
    }

    /// `sum_k tr(F_ki Z_k)` for every unknown i, and last for the constants.
    fn traces(&self, multipliers: &[Option<&Matrix<Exact>>]) -> Vec<Exact> {
        let mut traces = vec![Exact::zero(); self.unknowns + 1];
        for (block, z) in self.blocks.iter().zip(multipliers) {
            let Some(z) = z else { continue };
            for i in 0..block.rows() {
                for j in 0..block.cols() {
                    let weight = &z[(j, i)];
                    if weight.is_zero() {
                        continue;
                    }
                    let entry = &block[(i, j)];
                    for (unknown, c) in &entry.terms {
                        traces[*unknown] = traces[*unknown].add(&c.mul(weight));
                    }
                    traces[self.unknowns] = traces[self.unknowns].add(&entry.constant.mul(weight));
                }
            }
        }
        traces
    }
}

/// A witness near the solver's multipliers, if one is found. `multipliers` belong to the scaled blocks of `standard`.
pub(crate) fn refute(
    problem: &Problem,
    settings: &Settings,
    standard: &Standard,
    multipliers: &[DMatrix<f64>],
) -> Option<Infeasibility> {
    let constraints = ExactConstraints::new(problem)?;
    let mut attempted: Vec<Vec<Vec<bool>>> = Vec::new();
    for guess in ZERO_GUESSES {
        let active = active_rows(multipliers, guess);
        if attempted.contains(&active) || !active.iter().flatten().any(|&row| row) {
            continue;
        }
        for with_kernel in [false, true] {
            if settings.is_over() {
                return None;
            }
            let kernel = if with_kernel { kernels(multipliers, &active, guess.sqrt()) } else { Vec::new() };
            if with_kernel && kernel.is_empty() {
                continue;
            }
            let repaired = repair(&constraints, settings, standard, multipliers, &active, &kernel);
            if let Some(witness) = repaired.and_then(|z| package(problem, &constraints, &z)) {
                return Some(witness);
            }
        }
        attempted.push(active);
    }
    None
}

/// Which rows of each multiplier are nonzero.
fn active_rows(multipliers: &[DMatrix<f64>], guess: f64) -> Vec<Vec<bool>> {
    let largest = multipliers.iter().flat_map(|z| z.diagonal().iter().copied().collect::<Vec<_>>()).fold(0.0, f64::max);
    multipliers.iter().map(|z| z.diagonal().iter().map(|&d| d > guess * largest).collect()).collect()
}

/// Small rational directions, scaled to integers, in the numerical kernel of the multipliers: pairs of a block and a
/// vector.
fn kernels(multipliers: &[DMatrix<f64>], active: &[Vec<bool>], tolerance: f64) -> Vec<(usize, Vec<i64>)> {
    let mut found = Vec::new();
    for (k, z) in multipliers.iter().enumerate() {
        let rows: Vec<usize> = (0..z.nrows()).filter(|&i| active[k][i]).collect();
        if rows.is_empty() {
            continue;
        }
        let part = DMatrix::from_fn(rows.len(), rows.len(), |i, j| z[(rows[i], rows[j])]);
        let largest = part.diagonal().max();
        // Gauss-Jordan with complete pivoting on the diagonal brings a semidefinite matrix to [I, X; 0, 0], whose
        // kernel is [-X; I].
        let n = rows.len();
        let mut m = part.clone();
        let mut pivots = Vec::new();
        loop {
            let next = (0..n).filter(|i| !pivots.contains(i)).max_by(|&i, &j| m[(i, i)].total_cmp(&m[(j, j)]));
            let Some(p) = next.filter(|&p| m[(p, p)] > tolerance * largest) else { break };
            let pivot_row = m.row(p) / m[(p, p)];
            for i in 0..n {
                let factor = if i == p { 0.0 } else { m[(i, p)] };
                for j in 0..n {
                    m[(i, j)] = if i == p { pivot_row[j] } else { m[(i, j)] - factor * pivot_row[j] };
                }
            }
            pivots.push(p);
        }
        for free in (0..n).filter(|i| !pivots.contains(i)) {
            let mut direction = vec![0.0; z.nrows()];
            direction[rows[free]] = 1.0;
            for &p in &pivots {
                direction[rows[p]] = -m[(p, free)];
            }
            if let Some(integers) = near_rational(&direction, tolerance) {
                found.push((k, integers));
            }
        }
    }
    found
}

/// Exact multipliers near the given ones that satisfy all equations, or none.
fn repair(
    constraints: &ExactConstraints,
    settings: &Settings,
    standard: &Standard,
    multipliers: &[DMatrix<f64>],
    active: &[Vec<bool>],
    kernel: &[(usize, Vec<i64>)],
) -> Option<Vec<Matrix<Exact>>> {
    // Number the entries that may differ from zero: block, row, column with row >= column.
    let mut places = Vec::new();
    let mut number: Vec<Vec<usize>> = Vec::new();
    for (k, rows) in active.iter().enumerate() {
        let n = rows.len();
        number.push(vec![usize::MAX; n * n]);
        for i in 0..n {
            for j in (0..=i).filter(|&j| rows[i] && rows[j]) {
                number[k][i * n + j] = places.len();
                number[k][j * n + i] = places.len();
                places.push((k, i, j));
            }
        }
    }
    let scale = |k: usize, i: usize| i64::from(standard.row_scale[k][i]);
    // One equation per unknown, in the scaled coefficients, where sizes can be compared.
    let mut rows: Vec<Vec<(usize, Exact)>> = vec![Vec::new(); constraints.unknowns + 1];
    for (k, block) in constraints.blocks.iter().enumerate() {
        let n = block.rows();
        for i in 0..n {
            for j in 0..n {
                let place = number[k][i * n + j];
                if place == usize::MAX {
                    continue;
                }
                let shift = scale(k, i) + scale(k, j);
                let entry = &block[(i, j)];
                for (unknown, c) in &entry.terms {
                    let shift = shift + i64::from(standard.unknown_scale[*unknown]);
                    rows[*unknown].push((place, c.shifted(shift)));
                }
                if !entry.constant.is_zero() {
                    let shift =
                        shift + i64::from(standard.unknown_scale.get(constraints.unknowns).copied().unwrap_or(0));
                    rows[constraints.unknowns].push((place, entry.constant.shifted(shift)));
                }
            }
        }
    }
    if !standard.homogeneous {
        // The equation of x_0 ends with the multiplier of x_0 > 0, the last block.
        let last = constraints.blocks.len();
        if let Some(&place) = number.get(last).and_then(|n| n.first()).filter(|&&p| p != usize::MAX) {
            let shift = 2 * scale(last, 0) + i64::from(standard.unknown_scale[constraints.unknowns]);
            rows[constraints.unknowns].push((place, Exact::power_of_two(shift)));
        }
    }
    for (k, direction) in kernel {
        let n = active[*k].len();
        for i in (0..n).filter(|&i| active[*k][i]) {
            // (Z v)_i = 0, for Z = D Z~ D: in the scaled multiplier, Z~ (D v) = 0.
            let terms = (0..n).filter(|&j| direction[j] != 0 && active[*k][j]);
            // The direction was read off the scaled multiplier already.
            rows.push(terms.map(|j| (number[*k][i * n + j], Exact::new(IBig::from(direction[j]), 0))).collect());
        }
    }
    let equations: Vec<Row> = rows.into_iter().map(Row::from_exact).filter(|row| !row.is_empty()).collect();
    if equations.len() > settings.referee {
        return None;
    }
    let start: Vec<f64> = places.iter().map(|&(k, i, j)| multipliers[k][(i, j)]).collect();
    let solution = solve_near(equations, &start, || settings.is_over())?;
    // Back to the unscaled multipliers Z = D Z~ D of the user's constraints.
    let unscaled = |k: usize, n: usize| {
        Matrix::from_fn(n, n, |i, j| match number[k][i * n + j] {
            usize::MAX => Exact::zero(),
            place => Exact::new(solution[place].clone(), scale(k, i) + scale(k, j)),
        })
    };
    Some(constraints.blocks.iter().enumerate().map(|(k, block)| unscaled(k, block.rows())).collect())
}

/// The witness, if the exact multipliers are one.
fn package(problem: &Problem, constraints: &ExactConstraints, z: &[Matrix<Exact>]) -> Option<Infeasibility> {
    let present: Vec<Option<&Matrix<Exact>>> = z.iter().map(|z| (!is_zero(z)).then_some(z)).collect();
    let traces = constraints.traces(&present);
    if !is_contradiction(&traces, &present) {
        return None;
    }
    // Rounded for the reader, in units of the largest trace.
    let trace = |z: &Matrix<Exact>| (0..z.rows()).fold(Exact::zero(), |sum, i| sum.add(&z[(i, i)]));
    let largest = present.iter().flatten().map(|z| trace(z)).max()?;
    let exponent = largest.magnitude_exponent()?;
    let unit = largest.shifted(-exponent).round_up();
    let rounded = |x: &Exact| x.shifted(-exponent).round_down() / unit;
    let multipliers = problem
        .constraints
        .iter()
        .zip(&present)
        .filter_map(|((name, _), z)| {
            let z = (*z)?;
            let shown = DMatrix::from_fn(z.rows(), z.cols(), |i, j| rounded(&z[(i, j)]));
            Some(Multiplier { constraint: name.clone(), z: shown, exact: z.clone() })
        })
        .collect();
    Some(Infeasibility { multipliers, value: rounded(&traces[constraints.unknowns]) })
}

fn is_zero(z: &Matrix<Exact>) -> bool {
    z.as_slice().iter().all(Ring::is_zero)
}

/// Whether the multipliers, not all zero and all proved semidefinite, make the sum of traces a constant at most zero.
fn is_contradiction(traces: &[Exact], multipliers: &[Option<&Matrix<Exact>>]) -> bool {
    let Some((constant, coefficients)) = traces.split_last() else { return false };
    constant.signum() <= 0
        && coefficients.iter().all(Ring::is_zero)
        && multipliers.iter().any(Option::is_some)
        && multipliers.iter().flatten().all(|z| positive_semidefinite(*z).is_ok_and(|verdict| verdict.is_proved()))
}

impl Problem {
    /// Whether the witness shows that this problem has no solution, checked exactly from the problem's own data: the
    /// multipliers are positive semidefinite and not all zero, the coefficient of every unknown in
    /// `sum_k tr(Z_k F_k(x))` vanishes, and the constant is at most zero.
    ///
    /// `false` says only that this is no witness. Cost: one exact multiplication per coefficient, and one exact
    /// elimination per multiplier.
    pub fn is_refuted_by(&self, witness: &Infeasibility) -> bool {
        if standard_form(self, Anchor::Middle, Small::Kept).is_err() {
            return false;
        }
        let mut present = Vec::with_capacity(self.constraints.len());
        for (name, inequality) in &self.constraints {
            let z = witness.multipliers.iter().find(|m| m.constraint == *name).map(|m| &m.exact);
            if z.is_some_and(|z| z.shape() != inequality.positive.shape()) {
                return false;
            }
            present.push(z.filter(|z| !is_zero(z)));
        }
        let known = |m: &Multiplier| self.constraints.iter().any(|(name, _)| *name == m.constraint);
        if !witness.multipliers.iter().all(known) {
            return false;
        }
        let Some(constraints) = ExactConstraints::new(self) else { return false };
        is_contradiction(&constraints.traces(&present), &present)
    }
}
