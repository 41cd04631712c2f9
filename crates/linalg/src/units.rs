//! Balanced units of a pair (A, C): powers of two for each state, each output and for time.
//!
//! A plant in volts and nanometres has entries 24 decades apart and is the same plant as in volts and metres. With
//! `x = D z`, `y = R w` and time in units of `2^-t`, the pair becomes `(2^-t D^-1 A D, R^-1 C D)`. `D, R, t` minimise
//! the sum of the absolute logarithms of the nonzero entries:
//!
//! ```text
//! minimise   sum_{a_ij != 0} | log2|a_ij| + d_j - d_i - t |  +  sum_{c_kj != 0} | log2|c_kj| + d_j - r_k |
//! ```
//!
//! Only `D` is taken from the minimiser; `t` and `R` then bring the largest entry of `A` and of each row of `C` to
//! about one. The result changes with the units of the data, so that later decisions do not depend on those units: not
//! by a single bit, if these units are powers of two. Least squares (Curtis and Reid, J. Inst. Maths Applics 10, 1972)
//! has this property too, but absolute values are robust against a minority of entries that are rounding noise. Method:
//! iteratively reweighted least squares, equivariant in each step, with a bounded number of steps.

use nalgebra::DMatrix;

/// Powers of two: `x_j = 2^state[j] z_j`, `y_k = 2^output[k] w_k`, `d/dt = 2^time d/ds`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Units {
    pub(crate) state: Vec<i32>,
    pub(crate) output: Vec<i32>,
    pub(crate) time: i32,
}

/// Maximum number of reweighting steps. About ten reach a fixed point on dense data; the choice affects the units, not
/// the accuracy.
const STEPS: usize = 12;
/// The iteration stops if no unknown moves further than this: the unknowns are exponents, rounded to integers
/// afterwards. Two or three steps on dense data.
const SETTLED: f64 = 0.2;
/// Keeps the normal equations definite in directions that change no entry (all units of one connected part together).
const RIDGE: f64 = 1e-10;
/// Exponents of the units are limited to this size, which is safe from overflow.
const LARGEST: f64 = 900.0;

impl Units {
    /// The units of the pair as given.
    pub(crate) fn given(states: usize, outputs: usize) -> Self {
        Self { state: vec![0; states], output: vec![0; outputs], time: 0 }
    }

    /// Balanced units of `(a, c)`, n x n and p x n, both finite; O((n + p)^3).
    pub fn of(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Self {
        let (n, p) = (a.nrows(), c.nrows());
        let Some(best) = fit(&Logarithms::of(a, c), n, p) else { return Self::given(n, p) };
        // A common shift of connected states and outputs changes nothing. The fit chooses it by the units given, so
        // that only differences may be rounded; then each connected part is centred.
        let parts = parts(a, c);
        let limit = |x: f64| x.clamp(-LARGEST, LARGEST);
        let mut units = Self::given(n, p);
        for first in (0..n).filter(|&j| parts[j] == j) {
            let of_part = || (0..n).filter(|&j| parts[j] == first);
            let centre = of_part().map(|j| best[j]).sum::<f64>() / of_part().count() as f64;
            let shift = limit(best[first] - centre).round();
            for j in of_part() {
                units.state[j] = limit((best[j] - best[first]).round() + shift) as i32;
            }
        }
        // Time and outputs are scaled by their largest entries only, since the other entries may be noise.
        let largest = |size: f64| if size > 0.0 && size.is_finite() { size.log2().round() as i32 } else { 0 };
        units.time = largest(units.dynamics(a).amax());
        let seen = units.outputs(c);
        units.output = (0..p).map(|k| largest(seen.row(k).amax())).collect();
        let readable = |m: &DMatrix<f64>| m.iter().all(|x| x.is_finite());
        if readable(&units.dynamics(a)) && readable(&units.outputs(c)) { units } else { Self::given(n, p) }
    }

    /// `2^-t D^-1 A D`. Exact but for underflow.
    pub fn dynamics(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        let d = &self.state;
        DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| shift(a[(i, j)], d[j] - d[i] - self.time))
    }

    /// `R^-1 C D`. Exact but for underflow.
    pub fn outputs(&self, c: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(c.nrows(), c.ncols(), |k, j| shift(c[(k, j)], self.state[j] - self.output[k]))
    }

    /// Largest ratio of two units, as a power of two: zero if the units are those given, up to a common factor.
    pub fn spread(&self) -> i32 {
        spread(&self.state).max(spread(&self.output))
    }
}

/// The largest ratio of two units, as a power of two.
pub(crate) fn spread(powers: &[i32]) -> i32 {
    powers.iter().max().unwrap_or(&0) - powers.iter().min().unwrap_or(&0)
}

/// `x 2^power` without intermediate overflow.
pub(crate) fn shift(x: f64, power: i32) -> f64 {
    if (-1022..=1023).contains(&power) {
        return x * f64::from_bits(((power + 1023) as u64) << 52);
    }
    if x == 0.0 {
        return x;
    }
    let half = power / 2;
    x * 2f64.powi(half) * 2f64.powi(power - half)
}

/// For each state the first of those that it is connected with, by entries of A or through outputs.
fn parts(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Vec<usize> {
    let n = a.nrows();
    let mut parts: Vec<usize> = (0..n).collect();
    let mut join = |i: usize, j: usize| {
        let (kept, other) = (parts[i].min(parts[j]), parts[i].max(parts[j]));
        if kept != other {
            parts.iter_mut().filter(|part| **part == other).for_each(|part| *part = kept);
        }
    };
    for j in 0..n {
        for i in (0..n).filter(|&i| i != j && a[(i, j)] != 0.0) {
            join(i, j);
        }
    }
    for row in c.row_iter() {
        let mut seen = (0..n).filter(|&j| row[j] != 0.0);
        if let Some(first) = seen.next() {
            seen.for_each(|j| join(first, j));
        }
    }
    parts
}

/// Logarithms of `[A; C]`, column by column, and the weight of each entry: one, or zero for a zero entry.
struct Logarithms {
    sizes: Vec<f64>,
    counts: Vec<f64>,
}

impl Logarithms {
    fn of(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Self {
        let entries = a.column_iter().zip(c.column_iter()).flat_map(|(a, c)| a.into_iter().chain(c));
        let (sizes, counts) = entries.map(|x| if *x == 0.0 { (0.0, 0.0) } else { (x.abs().log2(), 1.0) }).unzip();
        Self { sizes, counts }
    }
}

/// The unknowns `d, r, t` of the head of this file, for n states and p outputs.
fn fit(entries: &Logarithms, n: usize, p: usize) -> Option<Vec<f64>> {
    let (size, time, rows) = (n + p + 1, n + p, n + p);
    let (mut unknowns, mut right, mut normal) = (vec![0.0; size], vec![0.0; size], vec![0.0; size * size]);
    let (mut taken, mut weights) = (vec![0.0; rows], vec![0.0; rows * n]);
    // For each row: the sum of its weights and of its weighted logarithms.
    let (mut weight, mut moment, mut terms) = (vec![0.0; rows], vec![0.0; rows], vec![0.0; rows]);
    for step in 0..STEPS {
        for x in [&mut normal, &mut right, &mut weight, &mut moment] {
            x.fill(0.0);
        }
        // The residual of an entry in column j is its logarithm plus d_j minus `taken` of its row.
        taken.copy_from_slice(&unknowns[..rows]);
        taken[..n].iter_mut().for_each(|x| *x += unknowns[time]);
        for (j, weights) in weights.chunks_exact_mut(rows.max(1)).enumerate() {
            let (logs, counts) = (&entries.sizes[j * rows..(j + 1) * rows], &entries.counts[j * rows..(j + 1) * rows]);
            if step == 0 {
                weights.copy_from_slice(counts);
            } else {
                for (w, ((log, count), taken)) in weights.iter_mut().zip(logs.iter().zip(counts).zip(&taken)) {
                    *w = count / (log + unknowns[j] - taken).abs().max(1.0);
                }
            }
            // The diagonal entries of A determine the unit of time only.
            let own = core::mem::take(&mut weights[j]);
            normal[time * size + time] += own;
            right[time] += own * logs[j];
            let (of_a, of_all) = (sum(&weights[..n]), sum(weights));
            normal[j * size + j] += of_all;
            normal[j * size + time] -= of_a;
            normal[time * size + time] += of_a;
            for (term, (w, log)) in terms.iter_mut().zip(weights.iter().zip(logs)) {
                *term = w * log;
            }
            right[j] -= sum(&terms);
            right[time] += sum(&terms[..n]);
            for ((weight, moment), (w, term)) in weight.iter_mut().zip(&mut moment).zip(weights.iter().zip(&terms)) {
                *weight += w;
                *moment += term;
            }
        }
        // Only the lower triangle is needed.
        for (i, (weight, moment)) in weight.iter().zip(&moment).enumerate() {
            normal[i * size + i] += weight;
            right[i] += moment;
            if i < n {
                normal[i * size + time] += weight;
            }
        }
        for j in 0..n {
            for i in j + 1..rows {
                normal[j * size + i] -= weights[j * rows + i] + if i < n { weights[i * rows + j] } else { 0.0 };
            }
        }
        normal.iter_mut().step_by(size + 1).for_each(|x| *x += RIDGE);
        solve_definite(&mut normal, &mut right)?;
        let moved = right.iter().zip(&unknowns).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        core::mem::swap(&mut unknowns, &mut right);
        if step > 0 && moved <= SETTLED {
            break;
        }
    }
    Some(unknowns)
}

/// Sum in four independent partial sums.
fn sum(x: &[f64]) -> f64 {
    let fours = x.chunks_exact(4);
    let rest: f64 = fours.remainder().iter().sum();
    let sums = fours.fold([0.0; 4], |s, x| [s[0] + x[0], s[1] + x[1], s[2] + x[2], s[3] + x[3]]);
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// Solves a positive definite system, its lower triangle in the columns of `normal`; overwrites `right` with the
/// solution. `None` if a pivot is not positive.
fn solve_definite(normal: &mut [f64], right: &mut [f64]) -> Option<()> {
    let size = right.len();
    for k in 0..size {
        let (before, column) = normal.split_at_mut(k * size);
        let column = &mut column[k..size];
        for previous in before.chunks_exact(size) {
            let factor = previous[k];
            for (x, y) in column.iter_mut().zip(&previous[k..size]) {
                *x -= factor * y;
            }
        }
        if column[0].is_nan() || column[0] <= 0.0 {
            return None;
        }
        let pivot = 1.0 / column[0].sqrt();
        for x in column.iter_mut() {
            *x *= pivot;
        }
        right[k] /= column[0];
        let (top, below) = right[k..].split_first_mut()?;
        for (x, y) in below.iter_mut().zip(&column[1..]) {
            *x -= *top * y;
        }
    }
    for k in (0..size).rev() {
        let column = &normal[k * size + k..k * size + size];
        let known: f64 = column[1..].iter().zip(&right[k + 1..]).map(|(x, y)| x * y).sum();
        right[k] = (right[k] - known) / column[0];
    }
    Some(())
}
