//! Units in which a pair `(A, C)` is best read: powers of two for each state, each output and for time.
//!
//! A plant in volts and nanometres has entries 24 decades apart, and says nothing else than the same plant in volts and
//! metres. With `x = D z`, `y = R w` and time in units of `2^-t`, the pair becomes `(2^-t D^-1 A D, R^-1 C D)`. `D, R, t` are chosen so
//! that the logarithms of the nonzero entries are as near to zero as they can be in the sense of the sum of absolute values:
//!
//! ```text
//! minimise   sum_{a_ij != 0} | log2|a_ij| + d_j - d_i - t |  +  sum_{c_kj != 0} | log2|c_kj| + d_j - r_k |
//! ```
//!
//! Of the minimiser only `D` is kept; `t` and `R` then bring the largest entry of `A` and of each row of `C` to one. All of it moves
//! with the units of the data, so that whatever is decided afterwards does not depend on them. Least squares (Curtis and Reid, J. Inst.
//! Maths Applics 10, 1972) would do that too; absolute values let the majority of entries outvote the few that are rounding noise.
//! Method: iteratively reweighted least squares, a fixed number of steps.

use nalgebra::{Cholesky, DMatrix, DVector};

/// Powers of two: `x_j = 2^state[j] z_j`, `y_k = 2^output[k] w_k`, `d/dt = 2^time d/ds`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Units {
    pub(crate) state: Vec<i32>,
    pub(crate) output: Vec<i32>,
    pub(crate) time: i32,
}

/// Reweighting steps. Ten bring the weights to rest on dense data; the choice only shapes the units, it is no accuracy.
const STEPS: usize = 12;
/// Keeps the normal equations definite along the directions that change no entry (all units of one connected part at once).
const RIDGE: f64 = 1e-10;
/// No unit is stretched beyond this power: twice the range of the data, and safe from overflow.
const LARGEST: f64 = 900.0;

impl Units {
    /// The units of the pair as given.
    pub(crate) fn given(states: usize, outputs: usize) -> Self {
        Self { state: vec![0; states], output: vec![0; outputs], time: 0 }
    }

    /// The best units of `(a, c)`, n x n and p x n, both finite; O((n + p)^3).
    pub(crate) fn of(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Self {
        let (n, p) = (a.nrows(), c.nrows());
        let entries = logarithms(a, c);
        let Some(best) = fit(&entries, n + p + 1) else { return Self::given(n, p) };
        // A common shift of all states and outputs changes nothing; centre the states.
        let centre = if n == 0 { 0.0 } else { best.rows(0, n).mean() };
        let power = |x: f64| x.clamp(-LARGEST, LARGEST).round() as i32;
        let mut units = Self::given(n, p);
        units.state = (0..n).map(|j| power(best[j] - centre)).collect();
        // Time and outputs only have to be of the size of their largest entries: the majority may well be noise.
        let largest = |size: f64| if size > 0.0 && size.is_finite() { power(size.log2()) } else { 0 };
        units.time = largest(units.dynamics(a).amax());
        let seen = units.outputs(c);
        units.output = (0..p).map(|k| largest(seen.row(k).amax())).collect();
        let readable = |m: &DMatrix<f64>| m.iter().all(|x| x.is_finite());
        if readable(&units.dynamics(a)) && readable(&units.outputs(c)) { units } else { Self::given(n, p) }
    }

    /// `2^-t D^-1 A D`. Exact but for underflow.
    pub(crate) fn dynamics(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        let d = &self.state;
        DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| shift(a[(i, j)], d[j] - d[i] - self.time))
    }

    /// `R^-1 C D`. Exact but for underflow.
    pub(crate) fn outputs(&self, c: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(c.nrows(), c.ncols(), |k, j| shift(c[(k, j)], self.state[j] - self.output[k]))
    }

    /// Decimal-free measure of how much the units differ: the largest ratio of two of them, as a power of two.
    pub(crate) fn spread(&self) -> i32 {
        let spread = |powers: &[i32]| powers.iter().max().unwrap_or(&0) - powers.iter().min().unwrap_or(&0);
        spread(&self.state).max(spread(&self.output))
    }
}

/// `x 2^power` without overflow on the way.
pub(crate) fn shift(x: f64, power: i32) -> f64 {
    if x == 0.0 {
        return x;
    }
    let half = power / 2;
    x * 2f64.powi(half) * 2f64.powi(power - half)
}

/// One nonzero entry: its logarithm, and the unknowns added to it and taken from it.
struct Entry {
    log: f64,
    plus: Option<usize>,
    minus: [Option<usize>; 2],
}

impl Entry {
    fn residual(&self, unknowns: &DVector<f64>) -> f64 {
        let value = |index: Option<usize>| index.map_or(0.0, |i| unknowns[i]);
        self.log + value(self.plus) - value(self.minus[0]) - value(self.minus[1])
    }
}

fn logarithms(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Vec<Entry> {
    let (n, time) = (a.nrows(), a.nrows() + c.nrows());
    let mut entries = Vec::new();
    for j in 0..n {
        for i in 0..n {
            if a[(i, j)] != 0.0 {
                let (plus, minus) = if i == j { (None, None) } else { (Some(j), Some(i)) };
                entries.push(Entry { log: a[(i, j)].abs().log2(), plus, minus: [minus, Some(time)] });
            }
        }
        for k in 0..c.nrows() {
            if c[(k, j)] != 0.0 {
                entries.push(Entry { log: c[(k, j)].abs().log2(), plus: Some(j), minus: [Some(n + k), None] });
            }
        }
    }
    entries
}

fn fit(entries: &[Entry], size: usize) -> Option<DVector<f64>> {
    let mut unknowns = DVector::zeros(size);
    for step in 0..STEPS {
        let mut normal = DMatrix::identity(size, size) * RIDGE;
        let mut right = DVector::zeros(size);
        for entry in entries {
            let weight = if step == 0 { 1.0 } else { 1.0 / entry.residual(&unknowns).abs().max(1.0) };
            let signed = [(entry.plus, 1.0), (entry.minus[0], -1.0), (entry.minus[1], -1.0)];
            for (row, sign) in signed.iter().filter_map(|(index, sign)| index.map(|i| (i, sign))) {
                right[row] -= weight * sign * entry.log;
                for (column, other) in signed.iter().filter_map(|(index, sign)| index.map(|i| (i, sign))) {
                    normal[(row, column)] += weight * sign * other;
                }
            }
        }
        unknowns = Cholesky::new(normal)?.solve(&right);
    }
    Some(unknowns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_of_extreme_units_becomes_a_chain_of_ones() {
        let a = DMatrix::from_row_slice(3, 3, &[0.0, 2f64.powi(40), 0.0, 0.0, 0.0, 2f64.powi(-40), 0.0, 0.0, 0.0]);
        let c = DMatrix::from_row_slice(1, 3, &[2f64.powi(13), 0.0, 0.0]);
        let units = Units::of(&a, &c);
        for x in units.dynamics(&a).iter().chain(units.outputs(&c).iter()) {
            assert!(*x == 0.0 || (0.5..=2.0).contains(x), "{x:e} is not near one in {units:?}");
        }
    }

    #[test]
    fn rounding_noise_is_outvoted() {
        let mut a = DMatrix::from_fn(4, 4, |i, j| 1.0 + (i + 2 * j) as f64 / 10.0);
        a[(2, 1)] = 1e-17;
        let units = Units::of(&a, &DMatrix::from_element(1, 4, 1.0));
        assert!(units.spread() <= 2, "one entry of 1e-17 among twenty bent the units: {units:?}");
    }

    #[test]
    fn the_scaled_pair_does_not_depend_on_the_units_of_the_data() {
        let a = DMatrix::from_fn(4, 4, |i, j| ((3 * i + 5 * j + 1) % 7) as f64 - 3.3);
        let c = DMatrix::from_fn(2, 4, |i, j| ((2 * i + 3 * j) % 5) as f64 - 1.7);
        let d = [37, -41, 3, 12];
        let other = Units { state: d.to_vec(), output: vec![-29, 17], time: 11 };
        let (first, second) = (Units::of(&a, &c), Units::of(&other.dynamics(&a), &other.outputs(&c)));
        let (x, y) = (first.dynamics(&a), second.dynamics(&other.dynamics(&a)));
        for (x, y) in x.iter().zip(y.iter()) {
            // The powers are rounded to whole ones: three roundings may each fall the other way.
            assert!((x / y).log2().abs() <= 3.0, "{x:e} against {y:e}");
        }
    }
}
