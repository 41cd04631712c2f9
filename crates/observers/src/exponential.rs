//! The exponential of a matrix with the integrals that a linear plant needs between samples, without an inverse.
//!
//! ```text
//! growth = exp(F tau) - I,   average = 1/tau int_0^tau exp(F s) ds,   noise = int_0^tau exp(F s) W exp(F' s) ds
//! ramp = 1/tau^2 int_0^tau exp(F (tau - s)) s ds
//! ```
//!
//! In coordinates that are balanced by powers of two, by their series for `tau / 2^s` with `|F| tau / 2^s <= 1/4`, and
//! s doublings:
//!
//! ```text
//! growth <- 2 growth + growth^2,   average <- average + growth average / 2,   noise <- noise + E noise E',  E = I + growth
//! ramp <- (2 ramp + growth ramp + average) / 4
//! ```
//!
//! so that the noise is a sum of congruences and a slow mode keeps its digits beside the identity. The error of a mode
//! is of the order of `epsilon |F| tau`, relative to the largest entries. Cost: about `2 n^3 (20 + 4 s)` flops.
//!
//! Source: C. F. Van Loan, Computing integrals involving the matrix exponential, IEEE Transactions on Automatic Control
//! 23, 1978; N. J. Higham, Functions of Matrices, SIAM 2008, section 10.7.4, for the averages by doubling.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, U1, convert};

use crate::dense::{times, times_transpose};
use crate::gaussian::symmetrise;

/// See the module.
#[derive(Clone)]
pub(crate) struct Exponential<T: RealField + Copy, N: Dim>
where
    DefaultAllocator: Allocator<N, N>,
{
    pub(crate) growth: OMatrix<T, N, N>,
    pub(crate) average: OMatrix<T, N, N>,
    pub(crate) noise: OMatrix<T, N, N>,
    pub(crate) ramp: OMatrix<T, N, N>,
}

/// The most doublings. Beyond them `epsilon |F| tau` leaves no digit.
const MOST_DOUBLINGS: usize = 128;

impl<T: RealField + Copy, N: Dim> Exponential<T, N>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    /// NaN where F, W or tau is not finite, or `|F| tau` above 2^126.
    pub(crate) fn new(f: &OMatrix<T, N, N>, w: &OMatrix<T, N, N>, tau: T) -> Self {
        let order = f.shape_generic().0;
        let (mut a, scale) = balanced(f);
        a *= tau;
        let (quarter, half): (T, T) = (convert(0.25), convert(0.5));
        let mut norm = norm_of(&a);
        let mut factor = T::one();
        let mut doublings = 0;
        while norm > quarter && doublings < MOST_DOUBLINGS {
            norm *= half;
            factor *= half;
            doublings += 1;
        }
        let is_small = norm <= quarter;
        if !is_small {
            let nothing = OMatrix::<T, N, N>::repeat_generic(order, order, convert(f64::NAN));
            return Self { growth: nothing.clone(), average: nothing.clone(), noise: nothing.clone(), ramp: nothing };
        }
        a *= factor;
        let w = OMatrix::<T, N, N>::from_fn_generic(order, order, |i, j| w[(i, j)] / scale[i] / scale[j]);
        // The terms fall faster than 1/2^k of the first.
        let identity = OMatrix::<T, N, N>::identity_generic(order, order);
        let (mut average, mut ramp, mut term) = (identity.clone(), identity.clone() * half, identity.clone());
        let (mut noise, mut change) = (w.clone(), w);
        let mut bound = T::one();
        let mut k = T::one();
        while bound > T::default_epsilon() * convert(0.01) {
            k += T::one();
            term = times(&term, &a) / k;
            average += &term;
            ramp += &term / (k + T::one());
            let product = times(&a, &change);
            change = (product.transpose() + product) / k;
            noise += &change;
            bound *= norm * convert(2.0) / k;
        }
        noise *= tau * factor;
        let mut found = Self { growth: times(&a, &average), average, noise, ramp };
        for _ in 0..doublings {
            found = found.doubled();
        }
        let Self { growth, average, noise, ramp } = &mut found;
        symmetrise(noise);
        for j in 0..order.value() {
            for i in 0..order.value() {
                let ratio = scale[i] / scale[j];
                growth[(i, j)] *= ratio;
                average[(i, j)] *= ratio;
                ramp[(i, j)] *= ratio;
                noise[(i, j)] = noise[(i, j)] * scale[i] * scale[j];
            }
        }
        found
    }

    /// That of twice the time.
    pub(crate) fn doubled(&self) -> Self {
        let Self { growth, average, noise, ramp } = self;
        let (half, quarter): (T, T) = (convert(0.5), convert(0.25));
        let carried = times(growth, noise);
        Self {
            ramp: (ramp + ramp + times(growth, ramp) + average) * quarter,
            average: average + times(growth, average) * half,
            // E noise E' + noise, with E = I + growth.
            noise: noise + noise + &carried + carried.transpose() + times_transpose(&carried, growth),
            growth: growth + growth + times(growth, growth),
        }
    }
}

/// The largest row sum.
fn norm_of<T: RealField + Copy, N: Dim>(a: &OMatrix<T, N, N>) -> T
where
    DefaultAllocator: Allocator<N, N>,
{
    let row = |i: usize| (0..a.ncols()).fold(T::zero(), |sum, j| sum + a[(i, j)].abs());
    (0..a.nrows()).fold(T::zero(), |norm, i| norm.max(row(i)))
}

/// The norm of a matrix in balanced coordinates: at least the modulus of its largest eigenvalue, and not far above for
/// any units of the states.
pub(crate) fn balanced_norm<T: RealField + Copy, N: Dim>(f: &OMatrix<T, N, N>) -> T
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    norm_of(&balanced(f).0)
}

/// `D^-1 F D` with powers of two in D that make the norms of rows and columns alike (as EISPACK's BALANC, without
/// permutations), and D.
fn balanced<T: RealField + Copy, N: Dim>(f: &OMatrix<T, N, N>) -> (OMatrix<T, N, N>, OVector<T, N>)
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    const MOST_SWEEPS: usize = 40;
    let order = f.shape_generic().0;
    let n = order.value();
    let (mut a, mut scale) = (f.clone(), OVector::<T, N>::repeat_generic(order, U1, T::one()));
    let (two, four) = (convert::<f64, T>(2.0), convert::<f64, T>(4.0));
    for _ in 0..MOST_SWEEPS {
        let mut is_done = true;
        for i in 0..n {
            let (mut column, mut row) = (T::zero(), T::zero());
            for j in (0..n).filter(|j| *j != i) {
                column += a[(j, i)].abs();
                row += a[(i, j)].abs();
            }
            let are_right = column > T::zero() && row > T::zero() && (column + row).is_finite();
            if !are_right {
                continue;
            }
            let (before, mut by) = (column + row, T::one());
            while column < row / two {
                by *= two;
                column *= four;
            }
            while column >= row * two {
                by /= two;
                column /= four;
            }
            if (column + row) / by < before * convert(0.95) {
                is_done = false;
                scale[i] *= by;
                for j in (0..n).filter(|j| *j != i) {
                    a[(j, i)] *= by;
                    a[(i, j)] /= by;
                }
            }
        }
        if is_done {
            break;
        }
    }
    (a, scale)
}
