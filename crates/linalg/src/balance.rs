//! Units of the state in which a plant and its quadratic forms have entries of comparable size.
//!
//! With `x = D z`, `D = diag(2^e_i)`, a plant `A` becomes `D^-1 A D`, a weight `Q` becomes `D Q D`, and a
//! `G = B R^-1 B'` becomes `D^-1 G D^-1`. The exponents make the largest entry of each row of `[A, G]` equal to that of
//! the column of `[A; Q]`, which is Osborne's balancing (J. ACM 7, 1960) in the maximum norm, for the Hamiltonian
//! matrix `[A -G; -Q -A']` the symplectic balancing of Benner (SIAM J. Sci. Comput. 22, 2000). The scaling is exact.

use crate::separation::norm;
use crate::units::shift;
use nalgebra::DMatrix;

/// Powers of two for each state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Balance(Vec<i32>);

/// Cycles over the states. Each brings every row nearer to its column; a chain of n states may need n.
const CYCLES: usize = 50;
/// No unit is stretched beyond this power, so that products of two stay in range.
const LARGEST: f64 = 400.0;

/// `log2` of the entries' sizes, minus infinity for a zero.
pub fn sizes(m: &DMatrix<f64>) -> DMatrix<f64> {
    m.map(|e| e.abs().log2())
}

impl Balance {
    /// Balances `a`, with `q` and `g` if they are there; all three are [`sizes`].
    pub fn of(a: &DMatrix<f64>, forms: Option<(&DMatrix<f64>, &DMatrix<f64>)>) -> Self {
        let n = a.nrows();
        let mut e = vec![0.0_f64; n];
        // The diagonal has no units.
        let mut columns = a.clone();
        columns.fill_diagonal(f64::NEG_INFINITY);
        let rows = columns.transpose();
        for _ in 0..CYCLES {
            let mut moved = false;
            for i in 0..n {
                let mut column = e[i] + largest::<false>(columns.column(i).as_slice(), &e);
                let mut row = largest::<true>(rows.column(i).as_slice(), &e) - e[i];
                if let Some((q, g)) = forms {
                    column = column.max(e[i] + largest::<true>(q.column(i).as_slice(), &e));
                    row = row.max(largest::<false>(g.column(i).as_slice(), &e) - e[i]);
                }
                let step = (0.5 * (row - column)).trunc();
                if step.is_finite() && step != 0.0 {
                    let next = (e[i] + step).clamp(-LARGEST, LARGEST);
                    moved |= next != e[i];
                    e[i] = next;
                }
            }
            if !moved {
                break;
            }
        }
        // Only the ratios are kept: a factor common to all states changes no `A`, and the size of the forms is not our
        // business.
        let extremes = e.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, u), &x| (l.min(x), u.max(x)));
        let centre = if n == 0 { 0.0 } else { (0.5 * (extremes.0 + extremes.1)).round() };
        Self(e.into_iter().map(|e| (e - centre) as i32).collect())
    }

    /// The balance of `a`, and `a` in it, if it makes the largest entry a thousand times smaller. (Where it does not,
    /// it might do harm: entries that are rounding are as good as others to it. Watkins, ETNA 23, 2006.)
    pub fn worthwhile(a: &DMatrix<f64>) -> Option<(Self, DMatrix<f64>)> {
        let target = a.amax() / 1024.0;
        // No units change the diagonal.
        if target == 0.0 || (0..a.nrows()).any(|k| a[(k, k)].abs() > target) {
            return None;
        }
        let balance = Self::of(&sizes(a), None);
        let balanced = balance.similar(a);
        (balanced.amax() <= target).then_some((balance, balanced))
    }

    /// Whether all states keep their units.
    pub fn is_trivial(&self) -> bool {
        self.0.iter().all(|&e| e == 0)
    }

    /// `D^-1 A D`.
    pub fn similar(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| shift(a[(i, j)], self.0[j] - self.0[i]))
    }

    /// `D Q D`.
    pub fn form(&self, q: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(q.nrows(), q.ncols(), |i, j| shift(q[(i, j)], self.0[i] + self.0[j]))
    }

    /// `D^-1 P D^-1`, back from the balanced states.
    pub(crate) fn form_back(&self, p: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(p.nrows(), p.ncols(), |i, j| shift(p[(i, j)], -self.0[i] - self.0[j]))
    }

    /// By how much a relative error of a form, in the Frobenius norm, may grow on its way back to the user's units,
    /// `back` being the form there: with `|E_ij| <= ||E||`, `||D^-1 E D^-1|| <= ||E|| tr(D^-2)`.
    pub(crate) fn growth(&self, back: &DMatrix<f64>) -> f64 {
        let trace: f64 = self.0.iter().map(|&e| shift(1.0, -2 * e)).sum();
        let size = norm(back);
        if size == 0.0 || self.is_trivial() { 1.0 } else { norm(&self.form(back)) * trace / size }
    }

    /// `D^-1 B`.
    pub(crate) fn driven(&self, b: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| shift(b[(i, j)], -self.0[i]))
    }

    /// `K D^-1`, back from the balanced states.
    pub(crate) fn gain_back(&self, k: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(k.nrows(), k.ncols(), |i, j| shift(k[(i, j)], -self.0[j]))
    }
}

/// The largest `x[j] + e[j]` or, unless `PLUS`, `x[j] - e[j]`: four at a time, because this is all of the work.
fn largest<const PLUS: bool>(x: &[f64], e: &[f64]) -> f64 {
    let term = |x: f64, e: f64| if PLUS { x + e } else { x - e };
    let larger = |x: f64, y: f64| if x > y { x } else { y };
    let ((fours, rest), (of_fours, of_rest)) = (x.as_chunks::<4>(), e.as_chunks::<4>());
    let mut found = [f64::NEG_INFINITY; 4];
    for (x, e) in fours.iter().zip(of_fours) {
        for l in 0..4 {
            found[l] = larger(term(x[l], e[l]), found[l]);
        }
    }
    let last = rest.iter().zip(of_rest).fold(f64::NEG_INFINITY, |m, (&x, &e)| larger(term(x, e), m));
    larger(larger(found[0], found[1]), larger(larger(found[2], found[3]), last))
}
