//! Lower triangular factors of covariances, `P = S S'`, changed by one column at a time.
//!
//! A column v that is added, `P + v v'`, is rotated into the factor (Givens); one column after the other, this is the
//! QR factorisation of the matrix of all columns, without the memory for that matrix. A column that is taken away,
//! `P - v v'`, takes hyperbolic rotations, which exist as long as the result is positive definite. Each costs `3 n^2`
//! flops and n roots.
//!
//! Every sum has one order of operations, as in `dense`: simulation, target and exported C give the same bits.
//!
//! Source: G. H. Golub and C. F. Van Loan, Matrix Computations, 4th ed., sections 5.2.5 and 6.5.4.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, convert};

/// Adds `v v'`; v is used up.
pub fn add<T: RealField + Copy, D: Dim>(s: &mut OMatrix<T, D, D>, v: &mut OVector<T, D>)
where
    DefaultAllocator: Allocator<D, D> + Allocator<D>,
{
    for j in 0..s.nrows() {
        let Some((c, d)) = rotation(&mut s[(j, j)], v[j]) else { continue };
        for i in j + 1..s.nrows() {
            let (below, entry) = (s[(i, j)], v[i]);
            s[(i, j)] = c * below + d * entry;
            v[i] = c * entry - d * below;
        }
    }
}

/// Takes `v v'` away; v is used up. False, with s in between, if the result is not positive definite.
pub fn subtract<T: RealField + Copy, D: Dim>(s: &mut OMatrix<T, D, D>, v: &mut OVector<T, D>) -> bool
where
    DefaultAllocator: Allocator<D, D> + Allocator<D>,
{
    for j in 0..s.nrows() {
        if v[j] == T::zero() {
            continue;
        }
        let Some((c, d)) = hyperbolic(&mut s[(j, j)], v[j]) else { return false };
        for i in j + 1..s.nrows() {
            let below = (s[(i, j)] - d * v[i]) / c;
            s[(i, j)] = below;
            v[i] = c * v[i] - d * below;
        }
    }
    true
}

/// The factor `[G, 0; M, S]` of the covariance of measurement and state together.
#[derive(Clone, Debug)]
pub struct Joint<T: RealField + Copy, N: Dim, P: Dim>
where
    DefaultAllocator: Allocator<P, P> + Allocator<N, P> + Allocator<N, N>,
{
    /// G: the covariance of the measurement is `G G'`.
    pub measured: OMatrix<T, P, P>,
    /// M: the covariance of state and measurement is `M G'`.
    pub cross: OMatrix<T, N, P>,
    /// S: the covariance of the state, the measurement given, is `S S'`.
    pub state: OMatrix<T, N, N>,
}

impl<T: RealField + Copy, N: Dim, P: Dim> Joint<T, N, P>
where
    DefaultAllocator: Allocator<P, P> + Allocator<N, P> + Allocator<N, N> + Allocator<N> + Allocator<P>,
{
    /// Adds the column `(a, b)`.
    pub fn add(&mut self, a: &mut OVector<T, P>, b: &mut OVector<T, N>) {
        for j in 0..self.measured.nrows() {
            let Some((c, d)) = rotation(&mut self.measured[(j, j)], a[j]) else { continue };
            for i in j + 1..self.measured.nrows() {
                let (below, entry) = (self.measured[(i, j)], a[i]);
                self.measured[(i, j)] = c * below + d * entry;
                a[i] = c * entry - d * below;
            }
            for i in 0..self.cross.nrows() {
                let (below, entry) = (self.cross[(i, j)], b[i]);
                self.cross[(i, j)] = c * below + d * entry;
                b[i] = c * entry - d * below;
            }
        }
        add(&mut self.state, b);
    }

    /// Takes the column `(a, b)` away; false if the result is not positive definite.
    pub fn subtract(&mut self, a: &mut OVector<T, P>, b: &mut OVector<T, N>) -> bool {
        for j in 0..self.measured.nrows() {
            if a[j] == T::zero() {
                continue;
            }
            let Some((c, d)) = hyperbolic(&mut self.measured[(j, j)], a[j]) else { return false };
            for i in j + 1..self.measured.nrows() {
                let below = (self.measured[(i, j)] - d * a[i]) / c;
                self.measured[(i, j)] = below;
                a[i] = c * a[i] - d * below;
            }
            for i in 0..self.cross.nrows() {
                let below = (self.cross[(i, j)] - d * b[i]) / c;
                self.cross[(i, j)] = below;
                b[i] = c * b[i] - d * below;
            }
        }
        subtract(&mut self.state, b)
    }
}

/// Cosine and sine of the rotation that takes `(pivot, entry)` to `(r, 0)`, with r in place of the pivot; none if both
/// are 0.
fn rotation<T: RealField + Copy>(pivot: &mut T, entry: T) -> Option<(T, T)> {
    let r = (*pivot * *pivot + entry * entry).sqrt();
    if r == T::zero() {
        return None;
    }
    let pair = (*pivot / r, entry / r);
    *pivot = r;
    Some(pair)
}

/// The hyperbolic rotation that takes `(pivot, entry)` to `(r, 0)`, `r^2 = pivot^2 - entry^2`: r / pivot and entry /
/// pivot. None unless `r^2` is a positive number.
fn hyperbolic<T: RealField + Copy>(pivot: &mut T, entry: T) -> Option<(T, T)> {
    let square = (*pivot - entry) * (*pivot + entry);
    if square > T::zero() {
        let r = square.sqrt();
        let pair = (r / *pivot, entry / *pivot);
        *pivot = r;
        return Some(pair);
    }
    None
}

/// The lower triangular factor of a positive semidefinite matrix: `s s'` is p up to its rounding, entry by entry,
/// relative to the roots of the diagonal.
pub fn semidefinite_factor<T: RealField + Copy, D: Dim>(p: &OMatrix<T, D, D>) -> OMatrix<T, D, D>
where
    DefaultAllocator: Allocator<D, D> + Allocator<D>,
{
    let order = p.nrows();
    let rounding = T::default_epsilon() * convert::<f64, T>(8.0 * (order * order) as f64);
    let mut s = p.clone();
    s.fill_upper_triangle(T::zero(), 1);
    for j in 0..order {
        let pivot = (0..j).fold(s[(j, j)], |pivot, k| pivot - s[(j, k)] * s[(j, k)]);
        if pivot <= rounding * p[(j, j)] {
            return factor_by_columns(p, rounding);
        }
        s[(j, j)] = pivot.sqrt();
        for i in j + 1..order {
            let entry = (0..j).fold(s[(i, j)], |entry, k| entry - s[(i, k)] * s[(j, k)]);
            s[(i, j)] = entry / s[(j, j)];
        }
    }
    s
}

/// The same for a matrix that is singular to rounding: Cholesky's columns with the pivot that is largest relative to
/// the diagonal, rotated into the factor one by one. To leave out the column of a small pivot in the given order would
/// change p by the root of the pivot.
fn factor_by_columns<T: RealField + Copy, D: Dim>(p: &OMatrix<T, D, D>, rounding: T) -> OMatrix<T, D, D>
where
    DefaultAllocator: Allocator<D, D> + Allocator<D>,
{
    let (mut rest, mut s) = (p.clone(), p.clone());
    s.fill(T::zero());
    for _ in 0..p.nrows() {
        let (mut pivot, mut greatest) = (0, rounding);
        for j in 0..p.nrows() {
            let share = rest[(j, j)] / p[(j, j)];
            if share > greatest {
                (pivot, greatest) = (j, share);
            }
        }
        if greatest <= rounding {
            break;
        }
        let mut column = rest.column(pivot) / rest[(pivot, pivot)].sqrt();
        rest.ger(-T::one(), &column, &column, T::one());
        rest.row_mut(pivot).fill(T::zero());
        rest.column_mut(pivot).fill(T::zero());
        add(&mut s, &mut column);
    }
    s
}
