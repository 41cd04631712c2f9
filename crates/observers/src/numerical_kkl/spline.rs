//! A map on a box by tensor products of cubic splines.
//!
//! `s(x) = sum c_k B_k1(x_1) ... B_kn(x_n)` with uniform cubic B-splines: twice continuously differentiable, local (4^n
//! coefficients per value), and an error of order h^4 in the spacing h of the grid. The table has `(points + 2)`
//! coefficients per axis and output.
//!
//! Source: C. de Boor, A Practical Guide to Splines, rev. ed., Springer 2001, ch. XVII.

#[cfg(feature = "alloc")]
extern crate alloc;

use core::marker::PhantomData;

use nalgebra::{RealField, SMatrix, SVector, convert};

use crate::error::ObserverError;
use crate::numerical_kkl::polynomial_tree::{check_box, clamped, finite};

/// A map from a box in N dimensions to Z numbers; `V` lends the coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TensorSpline<T, V, const N: usize, const Z: usize> {
    lower: SVector<T, N>,
    upper: SVector<T, N>,
    points: [usize; N],
    coefficients: V,
    scalar: PhantomData<T>,
}

impl<T, V, const N: usize, const Z: usize> TensorSpline<T, V, N, Z>
where
    T: RealField + Copy,
    V: AsRef<[T]>,
{
    /// The spline on `points[i]` uniformly spaced points of axis i, ends included, with `points[i] + 2` coefficients
    /// per axis; the last axis runs fastest, the outputs of one coefficient stand together.
    ///
    /// The cubic B-splines add to one, so that equal coefficients give a constant:
    /// ```
    /// use luenberger_observers::numerical_kkl::TensorSpline;
    /// use nalgebra::Vector1;
    /// let spline = TensorSpline::<f64, _, 1, 1>::new(Vector1::new(0.0), Vector1::new(1.0), [2], [3.0; 4])?;
    /// let (value, slope) = spline.with_gradient(&Vector1::new(0.3));
    /// assert!((value[0] - 3.0).abs() < 1e-15 && slope[0].abs() < 1e-14);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Box`]; [`ObserverError::Table`] for fewer than two points on an axis or another number of
    /// coefficients; [`ObserverError::TableNotFinite`].
    pub fn new(
        lower: SVector<T, N>,
        upper: SVector<T, N>,
        points: [usize; N],
        coefficients: V,
    ) -> Result<Self, ObserverError> {
        check_grid((&lower, &upper), &points)?;
        // A grid that overflows is longer than any table.
        let expected = points.iter().fold(Z, |product, count| product.saturating_mul(count.saturating_add(2)));
        let found = coefficients.as_ref().len();
        if found != expected {
            return Err(ObserverError::Table { what: "the coefficients of the spline", expected, found });
        }
        finite("the coefficients of the spline", coefficients.as_ref())?;
        Ok(Self { lower, upper, points, coefficients, scalar: PhantomData })
    }

    /// The value at x; outside the box, at its nearest point.
    pub fn at(&self, x: &SVector<T, N>) -> SVector<T, Z> {
        self.with_gradient(x).0
    }

    /// The value at x and the Jacobian there (Z x N); outside the box, at its nearest point.
    pub fn with_gradient(&self, x: &SVector<T, N>) -> (SVector<T, Z>, SMatrix<T, Z, N>) {
        const { assert!(N > 0, "a box has an axis") }
        let Local { first, weights, slopes } = local(x, (&self.lower, &self.upper), &self.points);
        let table = self.coefficients.as_ref();
        let (mut value, mut gradient) = (SVector::<T, Z>::zeros(), SMatrix::<T, Z, N>::zeros());
        // Along the last axis first, where the coefficients stand one after the other.
        let last = N - 1;
        let (w, v) = (&weights[last], &slopes[last]);
        let mut k = [0usize; N];
        loop {
            let mut index = 0;
            for i in 0..N {
                index = index * (self.points[i] + 2) + first[i] + k[i];
            }
            let rows = &table[index * Z..][..4 * Z];
            let sum = |w: &[T; 4], z: usize| {
                w[0] * rows[z] + w[1] * rows[Z + z] + w[2] * rows[2 * Z + z] + w[3] * rows[3 * Z + z]
            };
            let (mut line, mut rise) = (SVector::<T, Z>::zeros(), SVector::<T, Z>::zeros());
            for z in 0..Z {
                (line[z], rise[z]) = (sum(w, z), sum(v, z));
            }
            // The weight of the line, or with the slope of axis `sloped`.
            let weight = |sloped: usize| {
                let mut product = T::one();
                for i in 0..last {
                    product *= if i == sloped { slopes[i] } else { weights[i] }[k[i]];
                }
                product
            };
            let plain = weight(N);
            for z in 0..Z {
                value[z] += plain * line[z];
                gradient[(z, last)] += plain * rise[z];
            }
            for j in 0..last {
                let sloped = weight(j);
                for z in 0..Z {
                    gradient[(z, j)] += sloped * line[z];
                }
            }
            // The next of the 4^(N - 1) combinations.
            let mut axis = last;
            loop {
                if axis == 0 {
                    return (value, gradient);
                }
                axis -= 1;
                k[axis] += 1;
                if k[axis] < 4 {
                    break;
                }
                k[axis] = 0;
            }
        }
    }

    /// The box.
    pub fn bounds(&self) -> (&SVector<T, N>, &SVector<T, N>) {
        (&self.lower, &self.upper)
    }

    /// Points per axis.
    pub fn points(&self) -> [usize; N] {
        self.points
    }

    /// The coefficients.
    pub fn coefficients(&self) -> &[T] {
        self.coefficients.as_ref()
    }

    /// The same over another scalar, on the heap.
    #[cfg(feature = "alloc")]
    pub fn cast<U: RealField + Copy>(&self) -> TensorSpline<U, alloc::vec::Vec<U>, N, Z> {
        let cast = |x: T| convert::<f64, U>(x.to_subset_unchecked());
        TensorSpline {
            lower: self.lower.map(cast),
            upper: self.upper.map(cast),
            points: self.points,
            coefficients: self.coefficients.as_ref().iter().map(|&x| cast(x)).collect(),
            scalar: PhantomData,
        }
    }
}

/// Checks the box, and that there is a cell on each axis.
pub(super) fn check_grid<T: RealField + Copy, const N: usize>(
    (lower, upper): (&SVector<T, N>, &SVector<T, N>),
    points: &[usize; N],
) -> Result<(), ObserverError> {
    check_box(lower, upper)?;
    match points.iter().find(|&&count| count < 2) {
        Some(&found) => Err(ObserverError::Table { what: "the points on an axis", expected: 2, found }),
        None => Ok(()),
    }
}

/// The B-splines that do not vanish at a point.
pub(super) struct Local<T, const N: usize> {
    /// On each axis, the first of the four.
    pub(super) first: [usize; N],
    /// Their values.
    pub(super) weights: [[T; 4]; N],
    /// Their derivatives.
    pub(super) slopes: [[T; 4]; N],
}

/// The B-splines at the point of the box nearest to x.
pub(super) fn local<T: RealField + Copy, const N: usize>(
    x: &SVector<T, N>,
    (lower, upper): (&SVector<T, N>, &SVector<T, N>),
    points: &[usize; N],
) -> Local<T, N> {
    let x = clamped(x, lower, upper);
    let mut at = Local { first: [0; N], weights: [[T::zero(); 4]; N], slopes: [[T::zero(); 4]; N] };
    for i in 0..N {
        let cells = points[i] - 1;
        let per_unit = convert::<f64, T>(cells as f64) / (upper[i] - lower[i]);
        let position = (x[i] - lower[i]) * per_unit;
        // NaN gives cell 0; the position is within the grid because x is within the box.
        let floor: f64 = position.floor().to_subset_unchecked();
        at.first[i] = (floor as usize).min(cells - 1);
        let s = position - convert::<f64, T>(at.first[i] as f64);
        (at.weights[i], at.slopes[i]) = basis(s);
        for slope in &mut at.slopes[i] {
            *slope *= per_unit;
        }
    }
    at
}

/// The four cubic B-splines that do not vanish at s of a cell, and their derivatives in s.
fn basis<T: RealField + Copy>(s: T) -> ([T; 4], [T; 4]) {
    let c = convert::<f64, T>;
    let r = T::one() - s;
    let sixth = c(1.0 / 6.0);
    (
        [
            r * r * r * sixth,
            c(2.0 / 3.0) - s * s * (T::one() - c(0.5) * s),
            c(2.0 / 3.0) - r * r * (T::one() - c(0.5) * r),
            s * s * s * sixth,
        ],
        [-c(0.5) * r * r, s * (c(1.5) * s - c(2.0)), -r * (c(1.5) * r - c(2.0)), c(0.5) * s * s],
    )
}
