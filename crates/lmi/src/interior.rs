//! A primal-dual interior-point method for semidefinite programs whose constraints are sparse.
//!
//! ```text
//! minimise c'x   subject to   X = F_0 + x_1 F_1 + ... + x_m F_m >= 0,      maximise -tr(F_0 Y)   subject to   tr(F_i Y) = c_i,  Y >= 0
//! ```
//! in the notation of [`conic`](crate::conic), where the constant comes with a plus sign.
//!
//! Each iteration solves for the direction of Helmberg, Rendl, Vanderbei and Wolkowicz, Kojima, Shindoh and Hara, and Monteiro (HKM): with V = X^-1,
//! ```text
//! dX = R + sum dx_i F_i,   dY = mu V - Y - sym(V dX Y),   tr(F_i dY) = c_i - tr(F_i Y)   =>   B dx = tr(F_i (mu V - V R Y)) - c_i,   B_ij = tr(F_i V F_j Y),
//! ```
//! by Mehrotra's predictor and corrector. Cost per iteration: a Cholesky factorisation of order m, a dozen operations of n^3 per block, and the
//! assembly of B, which takes for each pair of constraints a number of operations that follows their entries. A general conic solver factors
//! a matrix of order n (n + 1)/2 per block instead: n^6 operations where these are n^3.
//!
//! The iterates stay positive definite, and once the equations hold they are strictly feasible: what a proof needs. All of the last ones are handed
//! out, since the last of all is the one nearest the boundary.
//!
//! Sources: C. Helmberg, F. Rendl, R. J. Vanderbei, H. Wolkowicz, An interior-point method for semidefinite programming, SIAM J. Optim. 6, 1996;
//! K. Fujisawa, M. Kojima, K. Nakata, Exploiting sparsity in primal-dual interior-point methods for semidefinite programming, Math. Program. 79, 1997.

use std::collections::BTreeMap;

use faer::linalg::solvers::{DenseSolveCore, Llt, Solve};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, MatRef, Par, Side};
use nalgebra::DMatrix;

use crate::conic::{ConicProgram, Ending};

/// A pair of points; nothing about them is proved.
#[derive(Debug, Clone)]
pub(crate) struct Iterate {
    pub(crate) unknowns: Vec<f64>,
    /// One for each block.
    pub(crate) multipliers: Vec<DMatrix<f64>>,
}

/// The last iterates that were better than all before, the nearest to the optimum last.
#[derive(Debug)]
pub(crate) struct Path {
    scaled: Scaled,
    pub(crate) iterates: Vec<Iterate>,
    pub(crate) ending: Ending,
    pub(crate) status: &'static str,
    pub(crate) iterations: u32,
}

/// How many iterates are kept.
const KEPT: usize = 16;

/// A relative gap and residuals below this are as good as this arithmetic gets.
const PRECISE: f64 = 1e-12;

/// A ray is believed when its equations hold to this, relative to its size.
const RAY: f64 = 1e-9;

/// Runs the method. `None` for a program without unknowns or constraints, or if not one step could be taken.
pub(crate) fn solve(program: &ConicProgram, iterations: u32) -> Option<Path> {
    if program.cost.is_empty() || program.blocks.is_empty() {
        return None;
    }
    let scaled = Scaled::of(program);
    let mut state = State::start(&scaled);
    let mut kept: Vec<Iterate> = Vec::new();
    let (mut ending, mut status, mut done) = (Ending::Point, "iteration limit", iterations);
    let (mut last_merit, mut last_kept) = (f64::INFINITY, f64::INFINITY);
    let mut stalled = 0;
    for iteration in 0..iterations {
        let Some(progress) = state.step(&scaled) else {
            (status, done) = ("numerical error", iteration);
            break;
        };
        let merit = progress.gap.max(progress.residual);
        let ray = state.ray(&scaled);
        // One for each octave of the gap: the last iterates of all crowd at the boundary, and prove nothing.
        if progress.gap < 0.5 * last_kept || ray.is_some() {
            last_kept = progress.gap;
            if kept.len() == KEPT {
                kept.remove(0);
            }
            kept.push(scaled.original(&state));
        }
        if let Some(ray) = ray {
            (ending, done) = (ray, iteration + 1);
            status = if ray == Ending::NoPoint { "infeasible" } else { "unbounded" };
            break;
        }
        if merit < PRECISE {
            (status, done) = ("solved", iteration + 1);
            break;
        }
        stalled = if merit < 0.9 * last_merit { 0 } else { stalled + 1 };
        last_merit = last_merit.min(merit);
        if stalled >= 25 {
            (status, done) = ("insufficient progress", iteration + 1);
            break;
        }
    }
    (!kept.is_empty()).then_some(Path { scaled, iterates: kept, ending, status, iterations: done })
}

impl Path {
    /// The last iterate.
    pub(crate) fn last(&self) -> Option<&Iterate> {
        self.iterates.last()
    }

    /// The multipliers of an iterate, moved onto their equations `tr(F_i Y) = c_i` (or = 0, of a ray) within the cone: `Y + Y (sum l_i F_i) Y` changes no
    /// eigenvalue by more than a share of itself, where a plain projection may leave the cone at the small ones.
    pub(crate) fn on_equations(&self, iterate: &Iterate, is_ray: bool) -> Vec<DMatrix<f64>> {
        let scaled = &self.scaled;
        let mut y = scaled.multipliers(iterate);
        for _ in 0..2 {
            let residual: Vec<f64> =
                scaled.adjoint(&y).iter().zip(&scaled.cost).map(|(a, c)| if is_ray { -a } else { c - a }).collect();
            let mut matrix: Mat<f64> = Mat::zeros(residual.len(), residual.len());
            for (block, y) in scaled.dense.iter().zip(&y.dense) {
                assemble(block, y.as_ref(), y.as_ref(), &mut matrix);
            }
            for (number, y) in scaled.numbers.iter().zip(&y.numbers) {
                number.assemble(y * y, &mut matrix);
            }
            let Some(factor) = regularised(&matrix) else { break };
            let change = scaled.pencil(&refined(&factor, &matrix, &residual), false);
            for (y, change) in y.dense.iter_mut().zip(&change.dense) {
                let moved = &*y * (change * &*y);
                let n = y.nrows();
                *y += Mat::from_fn(n, n, |i, j| 0.5 * (moved[(i, j)] + moved[(j, i)]));
            }
            for (y, change) in y.numbers.iter_mut().zip(&change.numbers) {
                *y += *y * change * *y;
            }
        }
        scaled.original_multipliers(&y)
    }
}

/// An entry of the upper triangle.
#[derive(Debug, Clone, Copy)]
struct Entry {
    row: usize,
    column: usize,
    value: f64,
}

/// A block of more than one row.
#[derive(Debug)]
struct Dense {
    order: usize,
    constant: Vec<Entry>,
    /// By number of entries, the most first.
    constraints: Vec<(usize, Vec<Entry>)>,
}

/// A block of one row.
#[derive(Debug)]
struct Number {
    constant: f64,
    terms: Vec<(usize, f64)>,
}

impl Number {
    /// Adds `factor c_i c_j` to every pair of unknowns.
    fn assemble(&self, factor: f64, b: &mut Mat<f64>) {
        for &(i, c) in &self.terms {
            for &(j, d) in &self.terms {
                b[(i, j)] += c * d * factor;
            }
        }
    }
}

/// The program with constraints of norm 1, and costs and constants of size 1.
#[derive(Debug)]
struct Scaled {
    cost: Vec<f64>,
    dense: Vec<Dense>,
    numbers: Vec<Number>,
    /// For each block of the program, whether it is the k-th of `numbers` or of `dense`.
    places: Vec<(bool, usize)>,
    /// x of the program is this times x.
    unknown_scale: Vec<f64>,
    /// Y of the program is this times Y.
    multiplier_scale: f64,
    rows: usize,
}

impl Scaled {
    fn of(program: &ConicProgram) -> Self {
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
            constraints.sort_by_key(|(_, entries)| std::cmp::Reverse(entries.len()));
            dense.push(Dense { order: block.order, constant: constants, constraints });
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
        }
    }

    fn original(&self, state: &State) -> Iterate {
        let unknowns = state.x.iter().zip(&self.unknown_scale).map(|(x, s)| x * s).collect();
        Iterate { unknowns, multipliers: self.original_multipliers(&state.dual) }
    }

    fn original_multipliers(&self, y: &Blocks) -> Vec<DMatrix<f64>> {
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
    fn multipliers(&self, iterate: &Iterate) -> Blocks {
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
    fn pencil(&self, x: &[f64], with_constant: bool) -> Blocks {
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
    fn adjoint(&self, m: &Blocks) -> Vec<f64> {
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
    fn constant_part(&self, m: &Blocks) -> f64 {
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
fn pair(e: &Entry, m: impl Fn(usize, usize) -> f64) -> f64 {
    if e.row == e.column { e.value * m(e.row, e.row) } else { e.value * (m(e.row, e.column) + m(e.column, e.row)) }
}

/// A matrix in blocks.
#[derive(Debug, Clone)]
struct Blocks {
    dense: Vec<Mat<f64>>,
    numbers: Vec<f64>,
}

impl Blocks {
    fn size(&self) -> f64 {
        let dense: f64 = self.dense.iter().map(Mat::squared_norm_l2).sum();
        (dense + self.numbers.iter().map(|x| x * x).sum::<f64>()).sqrt()
    }
}

/// Where the method stands.
struct State {
    x: Vec<f64>,
    /// X, which is `F_0 + sum x_i F_i` up to the residual.
    primal: Blocks,
    /// Y.
    dual: Blocks,
    /// Whether X is `F_0 + sum x_i F_i`.
    is_primal_feasible: bool,
    /// The residual of that, as a share of what it was at the start.
    residual: f64,
}

struct Progress {
    gap: f64,
    residual: f64,
}

/// A direction.
struct Direction {
    x: Vec<f64>,
    primal: Blocks,
    dual: Blocks,
}

/// What an iteration computes once.
struct Factors {
    x: Vec<Llt<f64>>,
    y: Vec<Llt<f64>>,
    inverse: Vec<Mat<f64>>,
    schur: Llt<f64>,
    /// The Schur complement, for refinement.
    matrix: Mat<f64>,
    residual: Blocks,
}

impl State {
    fn start(scaled: &Scaled) -> Self {
        let size = 10.0 * (scaled.rows as f64).sqrt();
        let identity = |n: usize| Mat::from_fn(n, n, |i, j| if i == j { size } else { 0.0 });
        let dense: Vec<_> = scaled.dense.iter().map(|block| identity(block.order)).collect();
        let numbers = vec![size; scaled.numbers.len()];
        Self {
            x: vec![0.0; scaled.cost.len()],
            primal: Blocks { dense: dense.clone(), numbers: numbers.clone() },
            dual: Blocks { dense, numbers },
            is_primal_feasible: false,
            residual: 1.0,
        }
    }

    fn complementarity(&self) -> f64 {
        let dense: f64 = self.primal.dense.iter().zip(&self.dual.dense).map(|(x, y)| inner(x, y)).sum();
        dense + self.primal.numbers.iter().zip(&self.dual.numbers).map(|(x, y)| x * y).sum::<f64>()
    }

    /// One iteration. `None` where a factorisation fails or a step is too short to go on.
    fn step(&mut self, scaled: &Scaled) -> Option<Progress> {
        let factors = self.factors(scaled)?;
        let rows = scaled.rows as f64;
        let mu = self.complementarity() / rows;
        let predictor = self.direction(scaled, &factors, 0.0, None)?;
        let (ap, ad) = self.lengths(&factors, &predictor, 1.0)?;
        let after = self.moved_complementarity(&predictor, ap, ad) / rows;
        let ratio = (after / mu).clamp(0.0, 1.0);
        // The shorter the predictor's step, the more centring.
        let exponent = (3.0 * ap.min(ad).powi(2)).max(1.0);
        let sigma = ratio.powf(exponent).max(1e-6);
        let direction = self.direction(scaled, &factors, sigma * mu, Some(&predictor))?;
        let (ap, ad) = self.lengths(&factors, &direction, 0.9 + 0.08 * ap.min(ad))?;
        if ap < 1e-6 && ad < 1e-6 {
            return None;
        }
        self.advance(scaled, &direction, ap, ad);
        let progress = self.progress(scaled);
        Some(progress)
    }

    fn factors(&self, scaled: &Scaled) -> Option<Factors> {
        let x: Vec<Llt<f64>> = self.primal.dense.iter().map(|x| x.llt(Side::Lower).ok()).collect::<Option<_>>()?;
        let y: Vec<Llt<f64>> = self.dual.dense.iter().map(|y| y.llt(Side::Lower).ok()).collect::<Option<_>>()?;
        let inverse: Vec<Mat<f64>> = x.iter().map(DenseSolveCore::inverse).collect();
        let matrix = self.schur(scaled, &inverse);
        let mut pencil = scaled.pencil(&self.x, true);
        for (p, x) in pencil.dense.iter_mut().zip(&self.primal.dense) {
            *p -= x;
        }
        for (p, x) in pencil.numbers.iter_mut().zip(&self.primal.numbers) {
            *p -= x;
        }
        let schur = regularised(&matrix)?;
        Some(Factors { x, y, inverse, schur, matrix, residual: pencil })
    }

    /// B.
    fn schur(&self, scaled: &Scaled, inverse: &[Mat<f64>]) -> Mat<f64> {
        let m = scaled.cost.len();
        let mut b: Mat<f64> = Mat::zeros(m, m);
        for ((block, v), y) in scaled.dense.iter().zip(inverse).zip(&self.dual.dense) {
            assemble(block, v.as_ref(), y.as_ref(), &mut b);
        }
        for ((number, x), y) in scaled.numbers.iter().zip(&self.primal.numbers).zip(&self.dual.numbers) {
            number.assemble(y / x, &mut b);
        }
        b
    }

    fn direction(
        &self,
        scaled: &Scaled,
        factors: &Factors,
        mu: f64,
        predictor: Option<&Direction>,
    ) -> Option<Direction> {
        // mu V - V (R Y + dX_a dY_a), not yet symmetric.
        let dense: Vec<Mat<f64>> = (0..self.primal.dense.len())
            .map(|k| {
                let v = &factors.inverse[k];
                let mut product = if self.is_primal_feasible {
                    Mat::zeros(v.nrows(), v.ncols())
                } else {
                    &factors.residual.dense[k] * &self.dual.dense[k]
                };
                if let Some(p) = predictor {
                    product += &p.primal.dense[k] * &p.dual.dense[k];
                }
                let mut out = -(v * &product);
                if mu > 0.0 {
                    out += faer::Scale(mu) * v;
                }
                out
            })
            .collect();
        let numbers: Vec<f64> = (0..self.primal.numbers.len())
            .map(|k| {
                let second = predictor.map_or(0.0, |p| p.primal.numbers[k] * p.dual.numbers[k]);
                (mu - factors.residual.numbers[k] * self.dual.numbers[k] - second) / self.primal.numbers[k]
            })
            .collect();
        let known = Blocks { dense, numbers };
        let right: Vec<f64> = scaled.adjoint(&known).iter().zip(&scaled.cost).map(|(a, c)| a - c).collect();
        let x = refined(&factors.schur, &factors.matrix, &right);
        if !x.iter().all(|x| x.is_finite()) {
            return None;
        }
        let mut dx = scaled.pencil(&x, false);
        let mut dy = Blocks {
            dense: Vec::with_capacity(self.dual.dense.len()),
            numbers: Vec::with_capacity(self.dual.numbers.len()),
        };
        for (k, known) in known.dense.into_iter().enumerate() {
            // - sym(V (sum dx_i F_i) Y), and the known part symmetric.
            let moved = &factors.inverse[k] * (&dx.dense[k] * &self.dual.dense[k]);
            let n = moved.nrows();
            let y = &self.dual.dense[k];
            dy.dense.push(Mat::from_fn(n, n, |i, j| {
                0.5 * (known[(i, j)] + known[(j, i)] - moved[(i, j)] - moved[(j, i)]) - y[(i, j)]
            }));
            if !self.is_primal_feasible {
                dx.dense[k] += &factors.residual.dense[k];
            }
        }
        for (k, known) in known.numbers.into_iter().enumerate() {
            dy.numbers
                .push(known - dx.numbers[k] * self.dual.numbers[k] / self.primal.numbers[k] - self.dual.numbers[k]);
            dx.numbers[k] += factors.residual.numbers[k];
        }
        Some(Direction { x, primal: dx, dual: dy })
    }

    /// The longest steps, at most 1, that keep this share of the distance to the boundary.
    fn lengths(&self, factors: &Factors, d: &Direction, share: f64) -> Option<(f64, f64)> {
        let mut ends = [f64::INFINITY; 2];
        for (end, llts, changes, at, steps) in [
            (0, &factors.x, &d.primal.dense, &self.primal.numbers, &d.primal.numbers),
            (1, &factors.y, &d.dual.dense, &self.dual.numbers, &d.dual.numbers),
        ] {
            for (llt, change) in llts.iter().zip(changes) {
                let least = least_relative_eigenvalue(llt, change)?;
                if least < 0.0 {
                    ends[end] = ends[end].min(-1.0 / least);
                }
            }
            for (at, step) in at.iter().zip(steps) {
                if *step < 0.0 {
                    ends[end] = ends[end].min(-at / step);
                }
            }
        }
        Some(((share * ends[0]).min(1.0), (share * ends[1]).min(1.0)))
    }

    fn moved_complementarity(&self, d: &Direction, ap: f64, ad: f64) -> f64 {
        let dense: f64 = (0..self.primal.dense.len())
            .map(|k| {
                let (x, y, dx, dy) = (&self.primal.dense[k], &self.dual.dense[k], &d.primal.dense[k], &d.dual.dense[k]);
                inner(x, y) + ap * inner(dx, y) + ad * inner(x, dy) + ap * ad * inner(dx, dy)
            })
            .sum();
        let numbers: f64 = (0..self.primal.numbers.len())
            .map(|k| {
                (self.primal.numbers[k] + ap * d.primal.numbers[k]) * (self.dual.numbers[k] + ad * d.dual.numbers[k])
            })
            .sum();
        dense + numbers
    }

    fn advance(&mut self, scaled: &Scaled, d: &Direction, ap: f64, ad: f64) {
        for (x, dx) in self.x.iter_mut().zip(&d.x) {
            *x += ap * dx;
        }
        for (y, dy) in self.dual.dense.iter_mut().zip(&d.dual.dense) {
            *y += faer::Scale(ad) * dy;
        }
        for (y, dy) in self.dual.numbers.iter_mut().zip(&d.dual.numbers) {
            *y += ad * dy;
        }
        self.residual *= 1.0 - ap;
        self.is_primal_feasible |= self.residual == 0.0;
        if self.is_primal_feasible {
            // Once the residual is gone it stays gone, to rounding.
            let pencil = scaled.pencil(&self.x, true);
            self.primal = pencil;
        } else {
            for (x, dx) in self.primal.dense.iter_mut().zip(&d.primal.dense) {
                *x += faer::Scale(ap) * dx;
            }
            for (x, dx) in self.primal.numbers.iter_mut().zip(&d.primal.numbers) {
                *x += ap * dx;
            }
        }
    }

    fn progress(&self, scaled: &Scaled) -> Progress {
        let value: f64 = scaled.cost.iter().zip(&self.x).map(|(c, x)| c * x).sum();
        let dual = -scaled.constant_part(&self.dual);
        let infeasibility =
            scaled.adjoint(&self.dual).iter().zip(&scaled.cost).map(|(a, c)| (a - c).abs()).fold(0.0, f64::max);
        Progress {
            gap: self.complementarity() / (1.0 + value.abs() + dual.abs()),
            residual: f64::max(infeasibility / (1.0 + self.dual.size()), self.residual),
        }
    }

    /// Whether x or Y have become a ray that shows the other program infeasible, as far as this arithmetic can tell.
    fn ray(&self, scaled: &Scaled) -> Option<Ending> {
        let value = -scaled.cost.iter().zip(&self.x).map(|(c, x)| c * x).sum::<f64>();
        // X - F_0 >= - |F_0|, and the constants have norm 1.
        if self.is_primal_feasible && value > 0.0 && 1.0 < RAY * value {
            return Some(Ending::Unbounded);
        }
        let dual = -scaled.constant_part(&self.dual);
        if dual > 0.0 {
            let infeasibility = scaled.adjoint(&self.dual).iter().map(|a| a * a).sum::<f64>().sqrt();
            if infeasibility < RAY * dual {
                return Some(Ending::NoPoint);
            }
        }
        None
    }
}

fn inner(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (0..a.ncols()).map(|j| a.col(j).iter().zip(b.col(j).iter()).map(|(x, y)| x * y).sum::<f64>()).sum()
}

/// The factor of a matrix that is positive definite but for rounding: where its constraints are nearly dependent, or the optimum is near, a
/// touch of regularisation, which refinement takes back.
fn regularised(matrix: &Mat<f64>) -> Option<Llt<f64>> {
    [0.0, 1e-15, 1e-13, 1e-11].into_iter().find_map(|share| {
        let mut regular = matrix.clone();
        for i in 0..regular.nrows() {
            regular[(i, i)] *= 1.0 + share;
        }
        regular.llt(Side::Lower).ok()
    })
}

/// `B^-1 right` with two steps of iterative refinement.
fn refined(factor: &Llt<f64>, matrix: &Mat<f64>, right: &[f64]) -> Vec<f64> {
    let m = right.len();
    let right = Mat::from_fn(m, 1, |i, _| right[i]);
    let mut x = right.clone();
    factor.solve_in_place(&mut x);
    for _ in 0..2 {
        let mut residual = &right - matrix * &x;
        factor.solve_in_place(&mut residual);
        x += residual;
    }
    (0..m).map(|i| x[(i, 0)]).collect()
}

/// The smallest eigenvalue of `L^-1 D L^-T`.
fn least_relative_eigenvalue(factor: &Llt<f64>, d: &Mat<f64>) -> Option<f64> {
    let mut left = d.clone();
    solve_lower_triangular_in_place(factor.L(), left.as_mut(), Par::Seq);
    let mut both = left.transpose().to_owned();
    solve_lower_triangular_in_place(factor.L(), both.as_mut(), Par::Seq);
    let eigenvalues = both.self_adjoint_eigenvalues(Side::Lower).ok()?;
    eigenvalues.first().copied().filter(|x| x.is_finite())
}

/// Adds `tr(F_i V F_j Y)` to B, both triangles.
fn assemble(block: &Dense, v: MatRef<'_, f64>, y: MatRef<'_, f64>, b: &mut Mat<f64>) {
    let n = block.order;
    // Entries of all constraints from the k-th on.
    let mut rest: Vec<usize> = block.constraints.iter().map(|(_, entries)| entries.len()).collect();
    for k in (0..rest.len().saturating_sub(1)).rev() {
        rest[k] += rest[k + 1];
    }
    for (k, (j, entries)) in block.constraints.iter().enumerate() {
        let mut rows: Vec<usize> = entries.iter().flat_map(|e| [e.row, e.column]).collect();
        rows.sort_unstable();
        rows.dedup();
        // Columns of (F_j Y)' that are not zero: (F_j Y)(r, :) = sum_c F_j(r, c) Y(c, :), stored as columns, like those of V.
        let mut g: Mat<f64> = Mat::zeros(n, rows.len());
        let place = |row: usize| rows.binary_search(&row).unwrap_or(0);
        for e in entries {
            let mirrored = if e.row == e.column { None } else { Some((e.column, e.row)) };
            for (r, c) in std::iter::once((e.row, e.column)).chain(mirrored) {
                let target = place(r);
                for (out, y) in g.col_mut(target).iter_mut().zip(y.col(c).iter()) {
                    *out += e.value * y;
                }
            }
        }
        let selected = Mat::from_fn(n, rows.len(), |i, c| v[(i, rows[c])]);
        // The whole product costs n^2 a row, at the speed of a matrix product; single entries cost one operation a row each.
        let is_whole = 2 * rest[k] * 4 > n * n;
        let whole = if is_whole { Some(&selected * g.transpose()) } else { None };
        // Rows of the two factors side by side in memory.
        let (vt, gt) = if is_whole {
            (Mat::zeros(0, 0), Mat::zeros(0, 0))
        } else {
            (selected.transpose().to_owned(), g.transpose().to_owned())
        };
        for (i, others) in &block.constraints[k..] {
            let entry =
                |r: usize, c: usize| -> f64 { vt.col(r).iter().zip(gt.col(c).iter()).map(|(x, y)| x * y).sum() };
            let sum: f64 = match &whole {
                Some(u) => others.iter().map(|e| pair(e, |r, c| u[(r, c)])).sum(),
                None => others.iter().map(|e| pair(e, entry)).sum(),
            };
            b[(*i, *j)] += sum;
            if i != j {
                b[(*j, *i)] += sum;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conic::{Block, BlockEntry};

    /// min x s.t. [[x, c], [c, y]] >= 0 and y <= 1: the optimum is c^2; with x <= 1 too, c = 2 is impossible; without y <= 1 the infimum
    /// 0 is not attained.
    #[test]
    fn a_two_by_two_program() {
        let entry = |row, column, constant, terms| BlockEntry { row, column, constant, terms };
        let program = |c: f64, bounds: &[usize]| {
            let entries =
                vec![entry(0, 0, 0.0, vec![(0, 1.0)]), entry(1, 0, c, vec![]), entry(1, 1, 0.0, vec![(1, 1.0)])];
            let bounds = bounds.iter().map(|&k| Block::number(1.0, vec![(k, -1.0)]));
            let blocks = std::iter::once(Block { order: 2, entries }).chain(bounds).collect();
            ConicProgram { cost: vec![1.0, 0.0], blocks }
        };
        let bounded = program(0.5, &[1]);
        let path = solve(&bounded, 100).unwrap();
        let last = path.last().unwrap();
        assert_eq!(path.ending, Ending::Point);
        // A gap and residuals of 1e-12 were asked for.
        assert!((last.unknowns[0] - 0.25).abs() < 1e-10, "{}", last.unknowns[0]);
        assert!((bounded.dual_cost(&last.multipliers) - 0.25).abs() < 1e-10);
        assert_eq!(solve(&program(2.0, &[0, 1]), 100).unwrap().ending, Ending::NoPoint);
        let open = solve(&program(0.5, &[]), 100).unwrap();
        assert!(open.last().unwrap().unknowns[0] < 1e-3);
    }

    #[test]
    fn a_cost_without_lower_bound_is_noticed() {
        let program = ConicProgram { cost: vec![-1.0], blocks: vec![Block::number(-1.0, vec![(0, 1.0)])] };
        assert_eq!(solve(&program, 100).unwrap().ending, Ending::Unbounded);
        assert!(solve(&ConicProgram { cost: vec![], blocks: vec![] }, 100).is_none());
    }
}
