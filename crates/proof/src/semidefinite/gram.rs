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
fn scales(program: &Program) -> Vec<f64> {
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
fn by_position(program: &Program) -> Vec<(usize, Entry)> {
    let mut all: Vec<(usize, Entry)> =
        (1..=program.unknowns()).flat_map(|i| program.matrix(i).iter().map(move |&entry| (i - 1, entry))).collect();
    all.sort_by_key(|(i, entry)| (position(entry), *i));
    all
}

/// A lower bound of the smallest eigenvalue of the Gram matrix, possibly negative, from the Gershgorin circles of
/// `D^-1 G D`, which has the eigenvalues of G: they are at least `min_i (g_ii - sum_(j != i) |g_ij| d_j / d_i)` for
/// every positive d. Each `|g_ij|` is bounded by the sum of the absolute values of its terms, so G is not formed. Cost:
/// a few passes over the entries.
fn from_circles(program: &Program, scales: &[f64], all: &[(usize, Entry)]) -> f64 {
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
pub(super) struct Equations {
    scales: Vec<f64>,
    /// A proved lower bound of the smallest eigenvalue of the scaled Gram matrix.
    smallest: f64,
}

impl Equations {
    /// `None` if the constraints are linearly dependent, or nearly so. Cost: a few Cholesky factorisations of order m,
    /// and 48 bytes per entry of the Gram matrix. Returns an error at once if m exceeds [`LARGEST_GRAM`] and the
    /// Gershgorin circles do not decide.
    pub(super) fn of(program: &Program) -> Result<Option<Self>, ProofError> {
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::definite::positive_semidefinite;
    use crate::exact::Exact;

    /// A program of dense 4 x 4 constraints with entries that are multiples of 0.1, most of them zero.
    fn program() -> impl Strategy<Value = Program> {
        let tenth = prop_oneof![4 => Just(0.0), 1 => (-9..=9_i32).prop_map(|k| f64::from(k) / 10.0)];
        prop::collection::vec(prop::collection::vec(tenth, 10), 1..=5).prop_map(|constraints| {
            let places: Vec<(usize, usize)> = (0..4).flat_map(|i| (i..4).map(move |j| (i, j))).collect();
            let entries = |values: &Vec<f64>| -> Vec<Entry> {
                let pairs = places.iter().zip(values).filter(|(_, x)| **x != 0.0);
                pairs.map(|(&(row, column), x)| Entry { block: 0, row, column, value: Interval::point(*x) }).collect()
            };
            let matrices = std::iter::once(Vec::new()).chain(constraints.iter().map(entries)).collect();
            let costs = vec![Interval::zero(); constraints.len()];
            Program::new(vec![Block::Dense(4)], costs, matrices).expect("well-posed")
        })
    }

    proptest! {
        /// The Gershgorin bound and the bound finally used are below the smallest eigenvalue of the exact Gram matrix.
        #[test]
        fn the_bounds_of_the_gram_matrix_hold(program in program()) {
            let (scales, all) = (scales(&program), by_position(&program));
            let m = program.unknowns();
            let exact = |x: f64| Exact::from_f64(x).expect("finite");
            let mut g = Matrix::from_fn(m, m, |_, _| Exact::zero());
            for (i, x) in &all {
                for (j, y) in all.iter().filter(|(_, y)| position(y) == position(x)) {
                    let size = |k: usize, e: &Entry| exact(scales[k]).mul(&exact(e.value.lo()));
                    g[(*i, *j)] = g[(*i, *j)].add(&exact(weight(x)).mul(&size(*i, x)).mul(&size(*j, y)));
                }
            }
            let used = Equations::of(&program).expect("small").map(|equations| equations.smallest);
            for bound in [Some(from_circles(&program, &scales, &all)), used].into_iter().flatten() {
                if bound.is_finite() {
                    let lowered = g.difference(&Matrix::scalar(m, &exact(bound))).expect("square");
                    let holds = positive_semidefinite(&lowered).expect("symmetric").is_proved();
                    prop_assert!(holds, "{bound:e}");
                }
            }
        }
    }

    /// Diagonal unit matrices and the matrix of ones, as in graph partitioning: circles with equal d would touch 0.
    #[test]
    fn circles_of_their_own_size_see_that_ones_and_units_are_independent() {
        let n = 40;
        let entry = |row, column| Entry { block: 0, row, column, value: Interval::point(1.0) };
        let mut matrices = vec![Vec::new()];
        matrices.extend((0..n).map(|i| vec![entry(i, i)]));
        matrices.push((0..n).flat_map(|i| (i..n).map(move |j| entry(i, j))).collect());
        let program = Program::new(vec![Block::Dense(n)], vec![Interval::zero(); n + 1], matrices).expect("well-posed");
        let bound = from_circles(&program, &scales(&program), &by_position(&program));
        assert!(bound > 0.1, "{bound}");
    }
}
