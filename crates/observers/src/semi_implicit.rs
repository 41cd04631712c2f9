//! The cubic flow in one semi-implicit step, for any gain `N = -P^-1 C'S` with `S + S' >= 0`.
//!
//! The flow `xhat' = -(y~'theta y~) N y~` has a closed form for radial gains only. With `q = y~'theta y~` held at its
//! measured value and the innovation taken at the end of the step,
//!
//! ```text
//! (I + s G) r = y~,   G = -C N,   s = h q,        p equations for the innovation r after the step
//! xhat'  = xhat - s N r                           the cubic part
//! ```
//!
//! In terms of the error, `e' - s N C e' = e` and `r = C e'`: `V = e'Pe` never grows, whatever h and q are, because
//! `V(e) = V(e') + s (Ce')'(S + S')(Ce') + s^2 |P^1/2 N C e'|^2`. For the same reason the equations have a solution for
//! every s >= 0: the eigenvalues of `G = (C P^-1 C') S` have nonnegative real parts.
//!
//! G is a product of a definite and an accretive matrix, whose leading minors may vanish, hence elimination with row
//! exchanges. s is bounded by `1/(epsilon |G|)`, from where on r is 0 to within rounding: every s >= 0 serves the
//! theorem, nothing overflows, and `I + s G` stays invertible in floating point.
//!
//! Cost: `2 p^3/3 + 5 p^2` operations, no square root; for one output a division.

#![allow(clippy::inline_always, reason = "loops over columns of fixed sizes unroll only where the sizes are seen")]

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, RealField};

use crate::cubic::{count, entry_of_product, largest, quadratic};
use crate::dense::{choose, copy, larger};

/// The matrix `G = -C N`, p x p, of the flow `y~' = -(y~'theta y~) G y~`.
///
/// ```
/// use luenberger_observers::semi_implicit::coupling;
/// use nalgebra::{Matrix1, RowVector2, Vector2};
/// assert_eq!(coupling(&RowVector2::new(1.0, 2.0), &Vector2::new(-3.0, 0.5)), Matrix1::new(2.0));
/// ```
pub fn coupling<T: RealField + Copy, N: Dim, P: Dim>(c: &OMatrix<T, P, N>, n: &OMatrix<T, N, P>) -> OMatrix<T, P, P>
where
    DefaultAllocator: Allocator<P, N> + Allocator<N, P> + Allocator<P, P>,
{
    let outputs = c.shape_generic().0;
    OMatrix::from_fn_generic(outputs, outputs, |i, j| -entry_of_product(c, n, i, j))
}

/// The largest s of a step with this G: `1/(epsilon |G|)`, |G| being the largest magnitude of an entry; 0 for `G = 0`.
pub fn reach<T: RealField + Copy, P: Dim>(coupling: &OMatrix<T, P, P>) -> T
where
    DefaultAllocator: Allocator<P, P>,
{
    let size = coupling.iter().fold(T::zero(), |largest, entry| largest.max(entry.abs()));
    let reach = T::one() / (T::default_epsilon() * size);
    if size > T::zero() && reach.is_finite() { reach } else { T::zero() }
}

/// One step of the flow for the time `t`: the innovation becomes r, `impulse` is written with `s r`.
///
/// Nothing but the linear step is left, r = y~ and no impulse, where the equations are singular: no admissible gain
/// has that.
#[inline(always)]
pub(crate) fn advance<T: RealField + Copy, P: Dim>(
    theta: &OMatrix<T, P, P>,
    (coupling, reach): (&OMatrix<T, P, P>, T),
    t: T,
    innovation: &mut [T],
    impulse: &mut [T],
) where
    DefaultAllocator: Allocator<P, P>,
{
    let (zero, one) = (T::zero(), T::one());
    copy(innovation, impulse);
    let size = largest(innovation);
    let length = choose(|| size > zero, size, one);
    for entry in impulse.iter_mut() {
        *entry /= length;
    }
    // y~' theta y~ = size^2 q; the square is bounded before it can overflow.
    let drive = larger(quadratic(theta, impulse), zero) * t * size * size;
    let s = choose(|| drive < reach, drive, reach);
    copy(innovation, impulse);
    let solved = with_square(coupling, |matrix| {
        let outputs = impulse.len();
        for i in 0..outputs {
            for j in 0..outputs {
                let entry = s * coupling.get((i, j)).copied().unwrap_or(zero);
                put(matrix, i * outputs + j, if i == j { one + entry } else { entry });
            }
        }
        eliminate(matrix, impulse)
    });
    for (innovation, impulse) in innovation.iter_mut().zip(impulse) {
        let (before, solution) = (*innovation, *impulse);
        *innovation = choose(|| solved > zero, solution, before);
        *impulse = choose(|| solved > zero, solution * s, zero);
    }
}

/// Runs with p^2 numbers, for which nothing is allocated up to 8 outputs, or where p is known at compile time.
#[inline(always)]
fn with_square<T: RealField + Copy, P: Dim, R>(like: &OMatrix<T, P, P>, run: impl FnOnce(&mut [T]) -> R) -> R
where
    DefaultAllocator: Allocator<P, P>,
{
    let order = like.shape_generic().0;
    if P::try_to_usize().is_none() && order.value() <= 8 {
        run([T::zero(); 64].get_mut(..order.value() * order.value()).unwrap_or_default())
    } else {
        run(OMatrix::<T, P, P>::zeros_generic(order, order).as_mut_slice())
    }
}

/// Solves `A x = b` in place, A by rows, with row exchanges; 1 if every pivot differs from 0, else 0, and x is none.
///
/// Rows are exchanged by choices between numbers, so that a program can be recorded.
#[inline(always)]
#[doc(hidden)]
pub fn eliminate<T: RealField + Copy>(a: &mut [T], x: &mut [T]) -> T {
    let (order, zero) = (x.len(), T::zero());
    let mut solved = T::one();
    for k in 0..order {
        let (mut largest, mut row) = (at(a, k * order + k).abs(), count::<T>(k));
        for i in k + 1..order {
            let (size, before) = (at(a, i * order + k).abs(), largest);
            largest = choose(|| size > before, size, before);
            row = choose(|| size > before, count(i), row);
        }
        for i in k + 1..order {
            let is_row = || row == count(i);
            for j in k..order {
                exchange(is_row, a, i * order + j, k * order + j);
            }
            exchange(is_row, x, i, k);
        }
        let pivot = at(a, k * order + k);
        // Not a number is no pivot either.
        solved = choose(|| pivot.abs() > zero, solved, zero);
        for i in k + 1..order {
            let factor = at(a, i * order + k) / pivot;
            for j in k + 1..order {
                put(a, i * order + j, at(a, i * order + j) - factor * at(a, k * order + j));
            }
            put(x, i, at(x, i) - factor * at(x, k));
        }
    }
    for i in (0..order).rev() {
        let mut rest = at(x, i);
        for j in i + 1..order {
            rest -= at(a, i * order + j) * at(x, j);
        }
        put(x, i, rest / at(a, i * order + i));
    }
    solved
}

/// An entry; 0 beyond the end, so that no index can panic on a target.
fn at<T: RealField + Copy>(entries: &[T], index: usize) -> T {
    entries.get(index).copied().unwrap_or_else(T::zero)
}

/// Two entries change places where the condition holds.
fn exchange<T: RealField + Copy>(condition: impl Fn() -> bool, entries: &mut [T], one: usize, other: usize) {
    let (first, second) = (at(entries, one), at(entries, other));
    put(entries, one, choose(&condition, second, first));
    put(entries, other, choose(&condition, first, second));
}

fn put<T>(entries: &mut [T], index: usize, value: T) {
    if let Some(place) = entries.get_mut(index) {
        *place = value;
    }
}

/// Whether `G + C N` is no more than rounding, and by how much it is more.
pub(crate) fn deviation<T: RealField + Copy, N: Dim, P: Dim>(
    c: &OMatrix<T, P, N>,
    n: &OMatrix<T, N, P>,
    given: &OMatrix<T, P, P>,
) -> T
where
    DefaultAllocator: Allocator<P, N> + Allocator<N, P> + Allocator<P, P>,
{
    let mut deviation = T::zero();
    for i in 0..c.nrows() {
        for j in 0..c.nrows() {
            deviation = deviation.max((entry_of_product(c, n, i, j) + given[(i, j)]).abs());
        }
    }
    deviation
}
