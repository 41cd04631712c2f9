//! Units of the state in which a plant and its quadratic forms have entries of comparable size.
//!
//! With `x = D z`, `D = diag(2^e_i)`, a plant `A` becomes `D^-1 A D`, a weight `Q` becomes `D Q D`, and a `G = B R^-1
//! B'` becomes `D^-1 G D^-1`. The exponents make the largest entry of each row of `[A, G]` equal to that of the column
//! of `[A; Q]`, which is Osborne's balancing (J. ACM 7, 1960) in the maximum norm, for the Hamiltonian matrix `[A -G;
//! -Q -A']` the symplectic balancing of Benner (SIAM J. Sci. Comput. 22, 2000). The scaling is exact. A state that
//! nothing drives (a hidden one, in the filter's equation), or that drives nothing, takes the unit in which its weight
//! is as large as the largest of the others.

use crate::Result;
use crate::argument::{RealMatrixView, owned, square};
use crate::separation::norm;
use crate::units::{Units, shift, spread};
use nalgebra::DMatrix;

/// Powers of two for each state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Balance(pub(crate) Vec<i32>);

/// Cycles over the states. Each brings every row nearer to its column; a chain of n states may need n.
const CYCLES: usize = 50;
/// No unit is stretched beyond this power, so that products of two stay in range.
const LARGEST: f64 = 400.0;

/// `log2` of the entries' sizes, minus infinity for a zero.
pub fn sizes(m: &DMatrix<f64>) -> DMatrix<f64> {
    m.map(|e| e.abs().log2())
}

/// By how much units must make the largest entry smaller.
const APART: f64 = 1024.0;

/// Whether no two entries are further apart than [`APART`] times their number, zeros left out: then nothing is to be
/// gained. One in a thousand random matrices is not.
pub(crate) fn are_near<'a>(entries: impl ExactSizeIterator<Item = &'a f64>) -> bool {
    let count = entries.len() as f64;
    let (least, most) = entries.fold((f64::INFINITY, 0.0_f64), |(least, most), entry| {
        let size = entry.abs();
        (if size > 0.0 && size < least { size } else { least }, if size > most { size } else { most })
    });
    most <= APART * count * least || most == 0.0
}

/// The largest ratio of units, as a power of two, that is left as it is.
pub(crate) const NEARBY: i32 = 10;

/// Units of the states of `x' = A x` or `x+ = A x`, as powers of two, in which the entries of A are as near to each
/// other as they can be: with `x_j = 2^k_j z_j`, the A of z is `D^-1 A D`, `D = diag(2^k_j)`. Isolated states have
/// theirs too, other than in [`balanced`](crate::balanced).
///
/// The exponents minimise the sum of `|log2|a_ij| + k_j - k_i - t|` over the nonzero entries and a unit of time;
/// `O(n^3)`.
/// ```
/// use luenberger_linalg::state_units;
/// use nalgebra::dmatrix;
/// let k = state_units(&dmatrix![-1.0, 1024.0; 1.0 / 1024.0, -1.0])?;
/// assert_eq!(k[0] - k[1], 10);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
/// # Errors
/// [`LinalgError::NotSquare`](crate::LinalgError::NotSquare),
/// [`LinalgError::NotFinite`](crate::LinalgError::NotFinite).
pub fn state_units<'a>(a: impl Into<RealMatrixView<'a>>) -> Result<Vec<i32>> {
    let a = owned(a);
    square("A", &a)?;
    Ok(Balance::fitted(&a).0)
}

/// The largest ratio of units, as a power of two, in which forms are computed.
const FARTHEST: i32 = 400;

impl Balance {
    /// Balances `a`, with `q` and `g` if they are there; all three are [`sizes`].
    pub fn of(a: &DMatrix<f64>, forms: Option<(&DMatrix<f64>, &DMatrix<f64>)>) -> Self {
        let n = a.nrows();
        let mut e = vec![0.0_f64; n];
        // The diagonal has no units.
        let mut columns = a.clone();
        columns.fill_diagonal(f64::NEG_INFINITY);
        let rows = columns.transpose();
        // Where some states are tied to the others by their weight alone, the balance is not unique: it starts where the
        // weights are one, whatever the units given.
        if let Some((q, g)) = forms
            && (0..n).any(|i| is_zero(&rows, g, i) || is_zero(&columns, q, i))
        {
            for (i, e) in e.iter_mut().enumerate() {
                let starts = [-0.5 * q[(i, i)], 0.5 * g[(i, i)]];
                *e = starts.into_iter().find(|start| start.is_finite()).unwrap_or(0.0).round().clamp(-LARGEST, LARGEST);
            }
        }
        for _ in 0..CYCLES {
            let mut moved = false;
            for i in 0..n {
                let mut column = e[i] + largest::<false>(columns.column(i).as_slice(), &e);
                let mut row = largest::<true>(rows.column(i).as_slice(), &e) - e[i];
                if let Some((q, g)) = forms {
                    column = column.max(e[i] + largest::<true>(q.column(i).as_slice(), &e));
                    row = row.max(largest::<false>(g.column(i).as_slice(), &e) - e[i]);
                    // A state that nothing drives, or that drives nothing, has its weight beside those of the others.
                    if row == f64::NEG_INFINITY {
                        row = others(q, &e, i, 1.0);
                    } else if column == f64::NEG_INFINITY {
                        column = others(g, &e, i, -1.0);
                    }
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

    /// Units of `a`, and `a` in them, if they make the largest entry a thousand times smaller. (Where they do not, they
    /// might do harm: entries that are rounding are as good as others to them. Watkins, ETNA 23, 2006.)
    pub fn worthwhile(a: &DMatrix<f64>) -> Option<(Self, DMatrix<f64>)> {
        let target = a.amax() / APART;
        // No units change the diagonal.
        if target == 0.0 || (0..a.nrows()).any(|k| a[(k, k)].abs() > target) {
            return None;
        }
        // A triangular chain has rows and columns that balancing leaves alone.
        [|a: &DMatrix<f64>| Self::of(&sizes(a), None), Self::fitted].into_iter().find_map(|units| {
            let balance = units(a);
            let balanced = balance.similar(a);
            (balanced.amax() <= target).then_some((balance, balanced))
        })
    }

    /// The units that fit the most entries ([`Units`]): they also find those of a triangular chain.
    pub(crate) fn fitted(a: &DMatrix<f64>) -> Self {
        Self(Units::of(a, &DMatrix::zeros(0, a.nrows())).state)
    }

    /// The units that fit the most entries of `a` and of the outputs `c`, where there is something to gain.
    pub(crate) fn of_seen(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Option<Self> {
        if are_near(a.iter()) && are_near(c.iter()) { None } else { Self(Units::of(a, c).state).apart() }
    }

    /// The same for a weight instead of outputs, by the roots of its diagonal.
    pub(crate) fn of_weighted(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Option<Self> {
        Self::of_seen(a, &DMatrix::from_fn(1, a.nrows(), |_, j| q[(j, j)].abs().sqrt()))
    }

    /// The units of the spaces of `A` and `B` that fit the most entries of the equation `A X + X B = C` (`A X B - X =
    /// C`), where there is something to gain.
    pub(crate) fn of_pair(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> [Option<Self>; 2] {
        if [a, b, c].iter().all(|m| are_near(m.iter())) {
            return [None, None];
        }
        let (n, m) = c.shape();
        let mut all = DMatrix::zeros(n + m, n + m);
        all.view_mut((0, 0), (n, n)).copy_from(a);
        all.view_mut((n, n), (m, m)).copy_from(b);
        all.view_mut((0, n), (n, m)).copy_from(c);
        let Self(mut left) = Self::fitted(&all);
        let right = left.split_off(n);
        [Self(left).apart(), Self(right).apart()]
    }

    /// These units, if they differ by more than a factor of a thousand: below that three digits are lost at most. Not
    /// if forms in them, with its square, would leave the range of binary64.
    pub(crate) fn apart(self) -> Option<Self> {
        (NEARBY + 1..FARTHEST).contains(&spread(&self.0)).then_some(self)
    }

    /// Whether all states keep their units.
    pub fn is_trivial(&self) -> bool {
        self.0.iter().all(|&e| e == 0)
    }

    /// `D^-1 A D`.
    pub fn similar(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| shift(a[(i, j)], self.0[j] - self.0[i]))
    }

    /// `D A D^-1`, back from the balanced states.
    pub(crate) fn similar_back(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| shift(a[(i, j)], self.0[i] - self.0[j]))
    }

    /// The largest ratio of two units.
    pub(crate) fn ratio(&self) -> f64 {
        shift(1.0, spread(&self.0))
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

    /// `D^-1 C D_B` for a right-hand side between two balanced spaces; in place.
    pub(crate) fn between(left: Option<&Self>, right: Option<&Self>, m: &mut DMatrix<f64>, sign: i32) {
        if left.is_none() && right.is_none() {
            return;
        }
        let power = |balance: Option<&Self>, k: usize| balance.map_or(0, |balance| balance.0[k]);
        for j in 0..m.ncols() {
            for i in 0..m.nrows() {
                m[(i, j)] = shift(m[(i, j)], sign * (power(right, j) - power(left, i)));
            }
        }
    }

    /// By how much a relative error of `x`, between two balanced spaces, may grow on its way back, where it is `back`:
    /// `|D E D_B^-1| <= |E| max(D) max(D_B^-1)`.
    pub(crate) fn growth_between(left: Option<&Self>, right: Option<&Self>, back: &DMatrix<f64>) -> f64 {
        if left.is_none() && right.is_none() || back.is_empty() {
            return 1.0;
        }
        let (mut x, size) = (back.clone(), norm(back));
        Self::between(left, right, &mut x, 1);
        let largest = |balance: Option<&Self>, sign: i32| {
            balance.and_then(|balance| balance.0.iter().map(|&e| sign * e).max()).map_or(1.0, |e| shift(1.0, e))
        };
        if size == 0.0 { 1.0 } else { (norm(&x) * largest(left, 1) * largest(right, -1) / size).max(1.0) }
    }

    /// `D^-1 B`.
    pub(crate) fn driven(&self, b: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| shift(b[(i, j)], -self.0[i]))
    }

    /// `C D`.
    pub(crate) fn seen(&self, c: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(c.nrows(), c.ncols(), |i, j| shift(c[(i, j)], self.0[j]))
    }

    /// `K D^-1`, back from the balanced states.
    pub(crate) fn gain_back(&self, k: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(k.nrows(), k.ncols(), |i, j| shift(k[(i, j)], -self.0[j]))
    }
}

/// Whether nothing but the diagonal is in column i of these logarithms.
fn is_zero(a: &DMatrix<f64>, form: &DMatrix<f64>, i: usize) -> bool {
    a.column(i).iter().chain(form.column(i).iter()).all(|x| *x == f64::NEG_INFINITY)
}

/// The largest diagonal entry of a form, `q_jj + 2 e_j` or `g_jj - 2 e_j`, apart from that of the state i.
fn others(form: &DMatrix<f64>, e: &[f64], i: usize, sign: f64) -> f64 {
    let entries = (0..e.len()).filter(|&j| j != i).map(|j| form[(j, j)] + sign * 2.0 * e[j]);
    entries.fold(f64::NEG_INFINITY, f64::max)
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
