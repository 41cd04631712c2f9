//! Comparison systems of interval observers: bounds of the error for each block of the coordinates `z = T e`.
//!
//! The blocks of z have one or two entries; |.| is their Euclidean norm, and `T_k` are the rows of T of block k. For
//! `e' = F e + G w` and `|w_j| <= W_j` the block norms satisfy
//! ```text
//! |z_k|' <= mu(M_kk) |z_k| + sum_(j != k) |M_kj| |z_j| + g_k,    M = T F T^-1,    g_k = sum_j |T_k G_j| W_j,
//! ```
//! with the spectral norm |.| and the logarithmic norm `mu(X)`, the largest eigenvalue of `(X + X')/2`. Let K have
//! these entries or larger ones; it is a Metzler matrix. Then `rho' = K rho + g` stays above the block norms if it
//! starts above them. In discrete time, `e+ = F e + G w`, the same holds for `rho+ = N rho + g` with `N_kj = |M_kj|`
//! for all k, j. The components are bounded by `|e_i| <= sum_k |(T^-1)_ik| |z_k|`. A pair of complex eigenvalues
//! `a + ib` forms a block with `mu = a` and the norm `sqrt(a^2 + b^2)`: its rotation does not weaken the bound.
//!
//! With T = I and blocks of one entry, K is the smallest Metzler matrix above F, and F itself if F is Metzler.
//!
//! Source of the comparison: F. Mazenc and O. Bernard, Interval observers for linear time-invariant systems with
//! disturbances, Automatica 47, 2011, for boxes in rotating coordinates; R. Bellman, Vector Lyapunov functions, SIAM
//! Journal on Control 1, 1962, for block norms.
//!
//! **Rounding.** [`SampledBounds`] contains the entries required by `rho+ = N rho + g + Q|xhat| + U|u|` if every
//! operation of the step `xhat+ = F xhat + G u + L(y - C xhat)`, for the plant `x+ = A x + B u + E w`, `y = C x + v`,
//! is rounded to nearest, with the unit roundoff u and the smallest positive number eta of the format. With
//! `c = 2(n + m + p) + q + 8` and `eps = 4 c u`, a sum of at most c/2 products in any order has an error of at most
//! `1.01 (c/2) u` times the sum of their magnitudes, plus `c eta`. With `|y - C xhat| <= |C||e| + V` and
//! `|y| <= |y - C xhat| + |C||xhat|`, the error of the computed next estimate is at most
//! ```text
//! delta = eps (|F||xhat| + |G||u| + |L||C||xhat| + |L||C||e| + |L| V) + c eta (1 + |L| 1),
//! ```
//! and `|e| <= |T^-1| rho`. The sums of rho+ and of the half-widths `H rho + outward |xhat|` have nonnegative terms
//! only: computed, they are at least `1 - eps` times their values, so entries divided by `1 - eps` suffice.

use super::embed;
use crate::definite::Direction;
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::statement::Format;
use crate::verdict::{UndecidedReason, Verdict};

/// Coordinates `z = T e` with their blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockCoordinates {
    t: Matrix<Interval>,
    inverse: Matrix<Interval>,
    /// First index and number of entries of each block.
    blocks: Vec<(usize, usize)>,
}

impl BlockCoordinates {
    /// T, n x n, with blocks of one or two entries in order; `None` if T is not proved to be invertible.
    ///
    /// ```
    /// use luenberger_proof::{Interval, Matrix, statement::BlockCoordinates};
    /// # fn main() -> Result<(), luenberger_proof::ProofError> {
    /// // Eigenvalues -1 +- 3i: one block, whose logarithmic norm is -1.
    /// let identity = Matrix::from_rows([[1.0, 0.0], [0.0, 1.0]]);
    /// let f = Matrix::from_rows([[-1.0, 3.0], [-3.0, -1.0]]).map(|x| Interval::of(*x));
    /// let block = BlockCoordinates::new(&identity, &[2])?.ok_or(luenberger_proof::ProofError::Empty { what: "T" })?;
    /// assert!((block.comparison(&f)?[(0, 0)] + 1.0).abs() < 1e-14);
    /// // Entry by entry the bound [-1 3; 3 -1], rounded up, is not stable.
    /// let entries = BlockCoordinates::new(&identity, &[1, 1])?.ok_or(luenberger_proof::ProofError::Empty { what: "T" })?;
    /// let bound = entries.comparison(&f)?;
    /// assert!(bound[(0, 0)] >= -1.0 && bound[(0, 0)] < -1.0 + 1e-14);
    /// assert!(bound[(0, 1)] >= 3.0 && bound[(0, 1)] < 3.0 + 1e-14);
    /// # Ok(())
    /// # }
    /// ```
    /// # Errors
    /// [`ProofError`] for a T that is not square or not finite, or blocks whose sizes do not add up to its order.
    pub fn new(t: &Matrix<f64>, blocks: &[usize]) -> Result<Option<Self>, ProofError> {
        let n = t.rows();
        let enclosed = embed::<Interval>(t, "T", (n, n))?;
        let mut first = 0;
        let mut places = Vec::with_capacity(blocks.len());
        for &length in blocks {
            if !(1..=2).contains(&length) {
                let (expected, found) = ((1, 1), (length, length));
                return Err(ProofError::DimensionMismatch { what: "a block of one or two entries", expected, found });
            }
            places.push((first, length));
            first += length;
        }
        if first != n {
            return Err(ProofError::DimensionMismatch {
                what: "the blocks of T",
                expected: (n, n),
                found: (first, first),
            });
        }
        let Some(inverse) = inverse(t, &enclosed)? else { return Ok(None) };
        Ok(Some(Self { t: enclosed, inverse, blocks: places }))
    }

    /// The number of blocks.
    pub fn count(&self) -> usize {
        self.blocks.len()
    }

    fn order(&self) -> usize {
        self.t.rows()
    }

    /// `T F T^-1`.
    fn transformed(&self, f: &Matrix<Interval>) -> Result<Matrix<Interval>, ProofError> {
        f.expect_shape("F", self.t.shape())?;
        self.t.product(f)?.product(&self.inverse)
    }

    /// Upper bounds of the entries of K for `e' = F e`, q x q (q is the number of blocks).
    ///
    /// # Errors
    /// [`ProofError::DimensionMismatch`].
    pub fn comparison(&self, f: &Matrix<Interval>) -> Result<Matrix<f64>, ProofError> {
        let m = self.transformed(f)?;
        Ok(self.of_blocks(|k, j| if k == j { logarithmic_norm(&m, self.blocks[k]) } else { self.block_norm(&m, k, j) }))
    }

    /// Upper bounds of the norms of the blocks of `T F T^-1`, q x q.
    ///
    /// # Errors
    /// [`ProofError::DimensionMismatch`].
    pub fn norms(&self, f: &Matrix<Interval>) -> Result<Matrix<f64>, ProofError> {
        let m = self.transformed(f)?;
        Ok(self.of_blocks(|k, j| self.block_norm(&m, k, j)))
    }

    /// Upper bounds of the norms of the blocks of each column of `T G`, q x m.
    ///
    /// # Errors
    /// [`ProofError::DimensionMismatch`].
    pub fn column_norms(&self, g: &Matrix<Interval>) -> Result<Matrix<f64>, ProofError> {
        let m = self.t.product(g)?;
        Ok(Matrix::from_fn(self.count(), g.cols(), |k, j| norm(&m, self.blocks[k], (j, 1))))
    }

    /// Upper bounds of the norms of the columns of T, block by block, q x n:
    /// `|T_k v| <= sum_i state_norms(k, i) |v_i|`.
    pub fn state_norms(&self) -> Matrix<f64> {
        Matrix::from_fn(self.count(), self.order(), |k, i| norm(&self.t, self.blocks[k], (i, 1)))
    }

    /// Upper bounds of the norms of the rows of `T^-1`, block by block, n x q: `|e_i| <= sum_k widths(i, k) |z_k|`.
    pub fn widths(&self) -> Matrix<f64> {
        Matrix::from_fn(self.order(), self.count(), |i, k| norm(&self.inverse, (i, 1), self.blocks[k]))
    }

    fn of_blocks(&self, entry: impl Fn(usize, usize) -> f64) -> Matrix<f64> {
        Matrix::from_fn(self.count(), self.count(), entry)
    }

    fn block_norm(&self, m: &Matrix<Interval>, k: usize, j: usize) -> f64 {
        norm(m, self.blocks[k], self.blocks[j])
    }
}

/// An enclosure of `T^-1`; `None` if none is found.
///
/// In units of the states in which the columns of T have entries of about one: `T^-1 = S (T S)^-1`, S of powers of two.
/// There, with X near `T^-1` and `E = I - X T`, `h = |E|_inf < 1`: `T^-1 - X = E (I - E)^-1 X`, whose entry (i, j) is
/// at most the sum of row i of |E| times the largest absolute entry of column j of X, divided by 1 - h.
fn inverse(t: &Matrix<f64>, enclosed: &Matrix<Interval>) -> Result<Option<Matrix<Interval>>, ProofError> {
    let n = t.rows();
    let units: Vec<f64> = (0..n)
        .map(|j| match (0..n).fold(0.0, |m: f64, i| m.max(t[(i, j)].abs())) {
            0.0 => 1.0,
            largest => 2f64.powi(-(largest.log2().round() as i32).clamp(-1000, 1000)),
        })
        .collect();
    let Some(x) = eliminated(&Matrix::from_fn(n, n, |i, j| t[(i, j)] * units[j])) else { return Ok(None) };
    let enclosed = &Matrix::from_fn(n, n, |i, j| enclosed[(i, j)].mul(&Interval::of(units[j])));
    let near = Matrix::<Interval>::embed(&x, "an approximate inverse")?;
    let defect = Matrix::scalar(n, &Interval::point(1.0)).difference(&near.product(enclosed)?)?;
    let sums: Vec<f64> = (0..n).map(|i| sum_up(defect.row(i).iter().map(Interval::magnitude))).collect();
    let h = sums.iter().fold(0.0, |h: f64, sum| h.max(*sum));
    if h.is_nan() || h >= 0.5 {
        return Ok(None);
    }
    let left = (1.0 - h).next_down();
    let largest: Vec<f64> = (0..n).map(|j| (0..n).fold(0.0, |m: f64, i| m.max(x[(i, j)].abs()))).collect();
    let found = Matrix::from_fn(n, n, |i, j| {
        let radius = ((sums[i] * largest[j]).next_up() / left).next_up();
        let entry = Interval::around(x[(i, j)], if sums[i] == 0.0 { 0.0 } else { radius });
        entry.unwrap_or(Interval::UNBOUNDED).mul(&Interval::of(units[i]))
    });
    Ok(found.as_slice().iter().all(Interval::is_bounded).then_some(found))
}

/// Approximate inverse by Gauss-Jordan elimination with row pivoting.
fn eliminated(t: &Matrix<f64>) -> Option<Matrix<f64>> {
    let n = t.rows();
    let mut rows: Vec<Vec<f64>> = (0..n)
        .map(|i| t.row(i).iter().copied().chain((0..n).map(|j| if i == j { 1.0 } else { 0.0 })).collect())
        .collect();
    for k in 0..n {
        let pivot = (k..n).max_by(|a, b| rows[*a][k].abs().total_cmp(&rows[*b][k].abs()))?;
        rows.swap(k, pivot);
        let head = rows[k][k];
        if head == 0.0 || !head.is_finite() {
            return None;
        }
        rows[k].iter_mut().for_each(|x| *x /= head);
        let row = rows[k].clone();
        for (_, other) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = other[k];
            other.iter_mut().zip(&row).for_each(|(x, y)| *x -= factor * y);
        }
    }
    let found = Matrix::from_fn(n, n, |i, j| rows[i][n + j]);
    found.as_slice().iter().all(|x| x.is_finite()).then_some(found)
}

/// Upper bound of a sum of nonnegative numbers.
fn sum_up(terms: impl Iterator<Item = f64>) -> f64 {
    terms.fold(0.0, |sum: f64, x| if x == 0.0 { sum } else { Interval::of(sum).add(&Interval::of(x)).hi() })
}

/// Upper bound of `sqrt(x^2 + y^2)`; exact if x or y is 0.
fn length(x: &Interval, y: &Interval) -> f64 {
    let (x, y) = (x.magnitude(), y.magnitude());
    if x == 0.0 || y == 0.0 {
        return x.max(y);
    }
    let square = |x: f64| Interval::of(x).mul(&Interval::of(x));
    square(x).add(&square(y)).sqrt().map_or(f64::INFINITY, |root| root.hi())
}

/// Upper bound of the spectral norm of a block of at most two rows and columns, each given by first index and length.
///
/// For a 2 x 2 matrix `(sqrt((a + d)^2 + (b - c)^2) + sqrt((a - d)^2 + (b + c)^2))/2`: exact for a scaled rotation.
fn norm(m: &Matrix<Interval>, (row, rows): (usize, usize), (column, columns): (usize, usize)) -> f64 {
    match (rows, columns) {
        (1, 1) => m[(row, column)].magnitude(),
        (1, _) => length(&m[(row, column)], &m[(row, column + 1)]),
        (_, 1) => length(&m[(row, column)], &m[(row + 1, column)]),
        _ => {
            let (a, b) = (&m[(row, column)], &m[(row, column + 1)]);
            let (c, d) = (&m[(row + 1, column)], &m[(row + 1, column + 1)]);
            let turned = length(&a.add(d), &b.sub(c));
            let mirrored = length(&a.sub(d), &b.add(c));
            Interval::of(turned).add(&Interval::of(mirrored)).hi() / 2.0
        }
    }
}

/// Upper bound of the largest eigenvalue of the symmetric part of a diagonal block.
fn logarithmic_norm(m: &Matrix<Interval>, (first, length_of_block): (usize, usize)) -> f64 {
    let (a, next) = (&m[(first, first)], first + 1);
    if length_of_block == 1 {
        return a.hi();
    }
    let d = &m[(next, next)];
    let spread = length(&a.sub(d), &m[(first, next)].add(&m[(next, first)]));
    a.add(d).add(&Interval::of(spread)).hi() / 2.0
}

/// A sampled plant `x+ = A x + B u + E w`, `y = C x + v` and the step of its interval observer.
#[derive(Debug, Clone, Copy)]
pub struct SampledIntervals<'a> {
    /// A, n x n.
    pub a: &'a Matrix<Interval>,
    /// B, n x m.
    pub b: &'a Matrix<Interval>,
    /// C, p x n.
    pub c: &'a Matrix<f64>,
    /// E, n x d.
    pub e: &'a Matrix<f64>,
    /// F of the step, n x n.
    pub f: &'a Matrix<f64>,
    /// G of the step, n x m.
    pub g: &'a Matrix<f64>,
    /// L, n x p.
    pub l: &'a Matrix<f64>,
    /// Bounds of |w|, d numbers.
    pub disturbances: &'a [f64],
    /// Bounds of |v|, p numbers.
    pub noise: &'a [f64],
    /// The format in which the step is computed, binary32 or binary64.
    pub format: Format,
}

/// Lower bounds for the entries of the step `rho+ = N rho + g + Q|xhat| + U|u|` and of the half-widths
/// `H rho + outward |xhat|`, rounding included; see the head of this file.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledBounds {
    /// N, q x q.
    pub n: Matrix<f64>,
    /// g, q x 1.
    pub g: Matrix<f64>,
    /// Q, q x n.
    pub q: Matrix<f64>,
    /// U, q x m.
    pub u: Matrix<f64>,
    /// H, n x q.
    pub h: Matrix<f64>,
    /// eps.
    pub eps: f64,
    /// The number c of the head of this file.
    pub count: usize,
}

/// Unit roundoff, smallest positive number, and a number far above the rounding errors of small numbers.
pub(crate) fn units(format: Format) -> Option<(f64, f64, f64)> {
    match format {
        Format::Binary32 => Some((2f64.powi(-24), 2f64.powi(-149), 2f64.powi(-110))),
        Format::Binary64 => Some((2f64.powi(-53), f64::from_bits(1), 2f64.powi(-1000))),
        Format::Fixed { .. } => None,
    }
}

/// `eps` and c for the given numbers of states, inputs, outputs and blocks.
pub(crate) fn rounding((n, m, p, q): (usize, usize, usize, usize), unit: f64) -> (f64, usize) {
    let count = 2 * (n + m + p) + q + 8;
    (4.0 * count as f64 * unit, count)
}

impl SampledIntervals<'_> {
    /// The required entries in these coordinates, before the division by `1 - eps`.
    ///
    /// # Errors
    /// [`ProofError`] for inconsistent shapes, entries that are not finite, or a fixed-point format.
    pub fn bounds(&self, coordinates: &BlockCoordinates) -> Result<SampledBounds, ProofError> {
        let (n, m, p, d) = (self.a.rows(), self.b.cols(), self.c.rows(), self.e.cols());
        self.a.expect_shape("A", (n, n))?;
        self.b.expect_shape("B", (n, m))?;
        let c = embed::<Interval>(self.c, "C", (p, n))?;
        let e = embed::<Interval>(self.e, "E", (n, d))?;
        let f = embed::<Interval>(self.f, "F", (n, n))?;
        let g = embed::<Interval>(self.g, "G", (n, m))?;
        let l = embed::<Interval>(self.l, "L", (n, p))?;
        for (what, expected, found) in [("w", d, self.disturbances.len()), ("v", p, self.noise.len())] {
            if expected != found {
                let (expected, found) = ((expected, 1), (found, 1));
                return Err(ProofError::DimensionMismatch { what, expected, found });
            }
        }
        let Some((unit, _, least)) = units(self.format) else {
            return Err(ProofError::Format { integer_bits: 0, fraction_bits: 0 });
        };
        let q = coordinates.count();
        let (eps, count) = rounding((n, m, p, q), unit);
        let eps_of = |m: &Matrix<Interval>| m.scaled(&Interval::of(eps));
        let magnitudes = |m: &Matrix<Interval>| m.map(|x| Interval::of(x.magnitude()));
        let upper = |m: &Matrix<Interval>| m.map(Interval::hi);
        let states = coordinates.state_norms().map(|x| Interval::of(*x));
        let fed = magnitudes(&l).product(&magnitudes(&c))?;
        let widths = coordinates.widths();
        let h = widths.map(|x| Interval::of(*x));
        // N: block norms of A - LC, and the rounding errors proportional to e.
        let errors = states.product(&eps_of(&fed.product(&h)?))?;
        let of_error = coordinates.norms(&self.a.difference(&l.product(&c)?)?)?;
        let of_error = of_error.map(|x| Interval::of(*x)).sum(&errors)?;
        // g: disturbances, noise with its rounding, and underflow.
        let column = |entries: &[f64]| Matrix::from_fn(entries.len(), 1, |i, _| Interval::of(entries[i]));
        let (w, v) = (column(self.disturbances), column(self.noise));
        let forced = |m: &Matrix<Interval>, bounds: &Matrix<Interval>| {
            coordinates.column_norms(m)?.map(|x| Interval::of(*x)).product(bounds)
        };
        let ones = |rows: usize| Matrix::from_fn(rows, 1, |_, _| Interval::point(1.0));
        let rounded_noise = states.product(&eps_of(&magnitudes(&l).product(&v)?))?;
        let small = states.product(&ones(n).sum(&magnitudes(&l).product(&ones(p))?)?)?.sum(&ones(q))?;
        let small = small.scaled(&Interval::of(least).mul(&Interval::of(count as f64)));
        let constant = forced(&e, &w)?.sum(&forced(&l, &v)?)?.sum(&rounded_noise)?.sum(&small)?;
        // Q and U: differences between stored and plant matrices, and rounding.
        let of_estimate = magnitudes(&self.a.difference(&f)?).sum(&eps_of(&magnitudes(&f).sum(&fed)?))?;
        let of_input = magnitudes(&self.b.difference(&g)?).sum(&eps_of(&magnitudes(&g)))?;
        Ok(SampledBounds {
            n: upper(&of_error),
            g: upper(&constant),
            q: upper(&states.product(&of_estimate)?),
            u: upper(&states.product(&of_input)?),
            h: widths,
            eps,
            count,
        })
    }
}

/// Whether every entry of `stored` times `factor` is at least that of `least`; the margin is 0.
pub(crate) fn entries_at_least(
    stored: &Matrix<f64>,
    factor: f64,
    least: &Matrix<f64>,
) -> Result<Verdict<Direction>, ProofError> {
    stored.expect_shape("the entries", least.shape())?;
    for row in 0..stored.rows() {
        for column in 0..stored.cols() {
            let (claimed, proved) = (stored[(row, column)], least[(row, column)]);
            let kept = if factor == 1.0 { claimed } else { Interval::of(claimed).mul(&Interval::of(factor)).lo() };
            if kept < proved || kept.is_nan() || proved.is_nan() {
                let why = UndecidedReason::TighterThanProved { row, column, claimed, proved };
                return Ok(Verdict::Undecided { why, best: kept - proved });
            }
        }
    }
    Ok(Verdict::Proved { margin: 0.0 })
}

/// Upper bounds of the entries of a product.
pub(crate) fn product_up(a: &Matrix<f64>, b: &Matrix<f64>) -> Result<Matrix<f64>, ProofError> {
    let (a, b) = (Matrix::<Interval>::embed(a, "a factor")?, Matrix::<Interval>::embed(b, "a factor")?);
    Ok(a.product(&b)?.map(Interval::hi))
}

/// Enclosure of the sampled plant, `x+ = A_d x + B_d u + E_d w_d` for `x' = A x + B u + E w` with u held for `period`
/// and any `|w(t)| <= W`.
///
/// E_d has the columns `h X E` with X near `exp(A h/2)`, bounded by W, and those of the identity, bounded by the
/// remainder `integral |exp(A s) E - X E| W ds`, over eight parts of the period.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldPlant {
    /// A_d, n x n.
    pub a: Matrix<Interval>,
    /// B_d, n x m.
    pub b: Matrix<Interval>,
    /// E_d, n x (d + n).
    pub e: Matrix<f64>,
    /// The bounds of w_d.
    pub disturbances: Vec<f64>,
}

/// Parts of a period for the bound of the remainder.
const PARTS: u32 = 8;

/// Enclosure of the sampled plant; `None` if the exponential is too large. See [`HeldPlant`].
///
/// # Errors
/// [`ProofError`] for inconsistent shapes or entries that are not finite.
pub fn held_plant(
    (a, b): (&Matrix<f64>, &Matrix<f64>),
    (e, bounds): (&Matrix<f64>, &[f64]),
    period: f64,
) -> Result<Option<HeldPlant>, ProofError> {
    use super::exponential::exponential;
    let (n, m, d) = (a.rows(), b.cols(), e.cols());
    let a = embed::<Interval>(a, "A", (n, n))?;
    let b = embed::<Interval>(b, "B", (n, m))?;
    let e = embed::<Interval>(e, "E", (n, d))?;
    let h = Interval::of(period);
    let joined = Matrix::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
        (true, true) => a[(i, j)].mul(&h),
        (true, false) => b[(i, j - n)].mul(&h),
        _ => Interval::point(0.0),
    });
    let Some(held) = exponential(&joined)? else { return Ok(None) };
    let Some(middle) = exponential(&a.scaled(&Interval::of(period / 2.0)))? else { return Ok(None) };
    let near = middle.product(&e)?.map(Interval::midpoint);
    let near_enclosed = near.map(|x| Interval::of(*x));
    let mut rest = Matrix::<Interval>::zeros(n, d);
    for part in 0..PARTS {
        // Cells that cover the period; they overlap by a rounding error.
        let (from, to) = (f64::from(part) / f64::from(PARTS), f64::from(part + 1) / f64::from(PARTS));
        let Some(cell) = Interval::new((from * period).next_down().max(0.0), (to * period).next_up()) else {
            return Ok(None);
        };
        let Some(moved) = exponential(&a.scaled(&cell))? else { return Ok(None) };
        let length = Interval::of(cell.width());
        let off = moved.product(&e)?.difference(&near_enclosed)?;
        rest = rest.sum(&off.map(|x| Interval::of(x.magnitude()).mul(&length)))?;
    }
    // The columns h X E are rounded as well.
    let columns = near.map(|x| x * period);
    let rounded = near_enclosed.scaled(&h).difference(&columns.map(|x| Interval::of(*x)))?;
    let rest = rest.sum(&rounded.map(|x| Interval::of(x.magnitude())))?;
    let weights = Matrix::from_fn(d, 1, |j, _| Interval::of(bounds.get(j).copied().unwrap_or(f64::NAN)));
    let rest = rest.product(&weights)?.map(Interval::hi);
    let e = Matrix::from_fn(n, d + n, |i, j| match j {
        j if j < d => columns[(i, j)],
        j => f64::from(u8::from(j - d == i)),
    });
    let disturbances = bounds.iter().copied().chain(rest.as_slice().iter().copied()).collect();
    let take = |rows: usize, first: usize, columns: usize| Matrix::from_fn(rows, columns, |i, j| held[(i, first + j)]);
    Ok(Some(HeldPlant { a: take(n, 0, n), b: take(n, n, m), e, disturbances }))
}
