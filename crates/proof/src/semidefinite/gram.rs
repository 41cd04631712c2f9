//! The Gram matrix of the constraints, `G_ij = tr(F_i F_j)`, and the distance from a matrix Y to the solutions of the
//! equations `tr(F_i Y) = c_i`.

use super::{Block, DualBlock, Entry, Program, position};
use crate::definite::{proved_eigenvalue_bound, smallest_eigenvalue_above};
use crate::error::ProofError;
use crate::exact::power_of_two;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;

/// Weight of an entry of the upper triangle in the trace of a product.
pub(super) fn weight(entry: &Entry) -> f64 {
    if entry.row == entry.column { 1.0 } else { 2.0 }
}

/// `tr(F Y)`.
pub(super) fn inner(entries: &[Entry], y: &[DualBlock]) -> Interval {
    entries.iter().fold(Interval::zero(), |sum, entry| {
        let weighted = Interval::of(weight(entry) * y[entry.block].at(entry.row, entry.column));
        sum.add(&entry.value.mul(&weighted))
    })
}

/// Upper bound of the Frobenius norm.
pub(super) fn norm(entries: &[Entry]) -> f64 {
    root(entries.iter().fold(0.0_f64, |sum, entry| {
        let size = entry.value.magnitude();
        (sum + (weight(entry) * (size * size).next_up()).next_up()).next_up()
    }))
}

/// Upper bound of the square root of a nonnegative number.
pub(super) fn root(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.sqrt().next_up() }
}

/// For each constraint, the power of two that scales its norm to about 1.
pub fn scales(program: &Program) -> Vec<f64> {
    (1..=program.unknowns())
        .map(|i| {
            let size = norm(program.matrix(i));
            if size > 0.0 && size.is_finite() {
                // Between 2^-1000 and 2^1000, so that products with the entries stay within range.
                power_of_two(-(size.log2().round() as i64).clamp(-1000, 1000))
            } else {
                1.0
            }
        })
        .collect()
}

/// Entries of all constraints with the index of their unknown, sorted by position.
pub fn by_position(program: &Program) -> Vec<(usize, Entry)> {
    let mut all: Vec<(usize, Entry)> =
        (1..=program.unknowns()).flat_map(|i| program.matrix(i).iter().map(move |&entry| (i - 1, entry))).collect();
    all.sort_by_key(|(i, entry)| (position(entry), *i));
    all
}

/// A lower bound of the smallest eigenvalue of the Gram matrix, possibly negative, from the Gershgorin circles of
/// `D^-1 G D`, which has the eigenvalues of G: they are at least `min_i (g_ii - sum_(j != i) |g_ij| d_j / d_i)` for
/// every positive d. Each `|g_ij|` is bounded by the sum of the absolute values of its terms, so G is not formed. Cost:
/// a few passes over the entries.
pub fn from_circles(program: &Program, scales: &[f64], all: &[(usize, Entry)]) -> f64 {
    let m = program.unknowns();
    let size = |i: usize, entry: &Entry| (scales[i] * entry.value.magnitude()).next_up();
    let mut diagonal = vec![0.0_f64; m];
    for (i, entry) in all {
        let least = if entry.value.contains(0.0) { 0.0 } else { entry.value.lo().abs().min(entry.value.hi().abs()) };
        let x = (scales[*i] * least).next_down().max(0.0);
        diagonal[*i] = (diagonal[*i] + (weight(entry) * (x * x).next_down().max(0.0)).next_down().max(0.0)).next_down();
    }
    // Upper bounds of sum_(j != i) |g_ij| d_j.
    let around = |d: &[f64]| {
        let mut sums = vec![0.0_f64; m];
        for here in all.chunk_by(|(_, a), (_, b)| position(a) == position(b)) {
            if here.len() == 1 {
                continue;
            }
            let reach = |(j, y): &(usize, Entry)| (size(*j, y) * d[*j]).next_up();
            let mut ahead = vec![0.0_f64; here.len()];
            for k in (1..here.len()).rev() {
                ahead[k - 1] = (ahead[k] + reach(&here[k])).next_up();
            }
            let mut behind = 0.0_f64;
            for ((i, x), ahead) in here.iter().zip(&ahead) {
                let others = (behind + ahead).next_up();
                let term = (weight(x) * (size(*i, x) * others).next_up()).next_up();
                sums[*i] = (sums[*i] + term).next_up();
                behind = (behind + reach(&(*i, *x))).next_up();
            }
        }
        sums
    };
    let mut d = vec![1.0; m];
    let mut best = f64::NEG_INFINITY;
    // Jacobi iteration for a d that makes all bounds equal; the bound holds for every d.
    for _ in 0..8 {
        let sums = around(&d);
        let bounds = (0..m).map(|i| (diagonal[i] - (sums[i] / d[i]).next_up()).next_down());
        // inf - inf gives no bound.
        let bounds = bounds.map(|bound| if bound.is_nan() { f64::NEG_INFINITY } else { bound });
        best = best.max(bounds.fold(f64::INFINITY, f64::min));
        if best > GOOD || !best.is_finite() {
            break;
        }
        d = (0..m).map(|i| ((1.0 + sums[i]) / diagonal[i]).clamp(1e-100, 1e100)).collect();
    }
    best
}

/// Lower bound of the smallest eigenvalue, for norms near 1, above which no better bound is sought: the distance
/// depends on its square root.
const GOOD: f64 = 0.1;

/// The Gram matrix of the scaled constraints.
fn gram(program: &Program, scales: &[f64], all: &[(usize, Entry)]) -> Matrix<Interval> {
    let m = program.unknowns();
    let mut g = Matrix::from_fn(m, m, |_, _| Interval::zero());
    for here in all.chunk_by(|(_, a), (_, b)| position(a) == position(b)) {
        for (k, (i, x)) in here.iter().enumerate() {
            let x = x.value.mul(&Interval::of(scales[*i] * weight(x)));
            for (j, y) in &here[k..] {
                g[(*i, *j)] = g[(*i, *j)].add(&x.mul(&y.value.mul(&Interval::of(scales[*j]))));
            }
        }
    }
    for i in 0..m {
        for j in 0..i {
            g[(i, j)] = g[(j, i)];
        }
    }
    g
}

/// Maximum number of unknowns for which the Gram matrix is formed; it then takes a gigabyte.
pub const LARGEST_GRAM: usize = 4608;

/// Properties of the equations `tr(F_i Y) = c_i` that do not depend on the right-hand sides.
#[derive(Debug, Clone)]
pub struct Equations {
    scales: Vec<f64>,
    /// A proved lower bound of the smallest eigenvalue of the scaled Gram matrix.
    pub smallest: f64,
}

impl Equations {
    /// `None` if the constraints are linearly dependent, or nearly so. Cost: a few Cholesky factorisations of order m,
    /// and 48 bytes per entry of the Gram matrix.
    /// # Errors
    /// At once if m exceeds [`LARGEST_GRAM`] and the Gershgorin circles do not decide.
    pub fn of(program: &Program) -> Result<Option<Self>, ProofError> {
        let scales = scales(program);
        let all = by_position(program);
        let circles = from_circles(program, &scales, &all);
        let smallest = if circles > GOOD {
            circles
        } else {
            let order = program.unknowns();
            if order > LARGEST_GRAM {
                return Err(ProofError::TooLarge {
                    what: "the Gram matrix of the constraints",
                    order,
                    allowed: LARGEST_GRAM,
                });
            }
            let proved = proved_eigenvalue_bound(&gram(program, &scales, &all)).unwrap_or(0.0);
            proved.max(circles)
        };
        Ok((smallest > 0.0).then_some(Self { scales, smallest }))
    }

    /// Upper bound of the Frobenius distance from Y to the nearest matrix with zero residuals.
    pub(super) fn distance(&self, residuals: &[Interval]) -> f64 {
        let squares = residuals.iter().zip(&self.scales).fold(0.0_f64, |sum, (r, s)| {
            let scaled = (r.magnitude() * s).next_up();
            (sum + (scaled * scaled).next_up()).next_up()
        });
        (root(squares) / root_below(self.smallest)).next_up()
    }
}

/// Positive lower bound of the square root of a positive number.
fn root_below(x: f64) -> f64 {
    x.sqrt().next_down()
}

/// Whether `Y - delta I >= 0` is proved.
pub(super) fn is_above(blocks: &[Block], y: &[DualBlock], delta: f64) -> bool {
    blocks.len() == y.len()
        && blocks.iter().zip(y).all(|(block, y)| match (block, y) {
            (Block::Diagonal(n), DualBlock::Diagonal(y)) => y.len() == *n && y.iter().all(|y| *y >= delta),
            (Block::Dense(n), DualBlock::Dense(y)) => y.shape() == (*n, *n) && smallest_eigenvalue_above(y, delta),
            _ => false,
        })
}
