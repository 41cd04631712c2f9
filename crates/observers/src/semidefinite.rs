//! Positive semidefiniteness of a symmetric matrix, by elimination with diagonal pivoting.
//!
//! The largest diagonal entry of a semidefinite matrix bounds all of its entries, so that nothing grows, also where the
//! matrix is singular; a small pivot taken before a large one would amplify rounding. Rounding, that of forming the
//! matrix included, leaves a multiple of `n^2 epsilon` times the largest entry undecided, and that much is accepted.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, U1};

use crate::cubic::count;

/// The row and the pivot for which the symmetric part of `matrix` (n x n, finite) is not positive semidefinite up to
/// `undecided n^2 epsilon` of its largest entry; `None` asks for positive definiteness.
pub(crate) fn failing_pivot<T: RealField + Copy, D: Dim>(
    matrix: &OMatrix<T, D, D>,
    undecided: Option<usize>,
) -> Option<(usize, T)>
where
    DefaultAllocator: Allocator<D, D> + Allocator<D>,
{
    let (order, definite) = (matrix.nrows(), undecided.is_none());
    let half = T::one() / (T::one() + T::one());
    let scale = matrix.iter().fold(T::zero(), |largest: T, entry| largest.max(entry.abs()));
    if scale == T::zero() {
        return (definite && order > 0).then_some((0, scale));
    }
    let mut rest = matrix / scale;
    for i in 0..order {
        for j in 0..=i {
            let mean = (rest[(i, j)] + rest[(j, i)]) * half;
            (rest[(i, j)], rest[(j, i)]) = (mean, mean);
        }
    }
    let undecided = count::<T>(undecided.unwrap_or(0) * order * order) * T::default_epsilon();
    let mut eliminated = OVector::<bool, D>::repeat_generic(matrix.shape_generic().0, U1, false);
    // Loops over every index with a test inside: through a filter the compiler loses sight of the range, and would keep
    // the panic of an index that is out of bounds.
    loop {
        let mut largest: Option<(usize, T)> = None;
        for i in 0..order {
            if !eliminated[i] && largest.is_none_or(|(_, pivot)| rest[(i, i)] > pivot) {
                largest = Some((i, rest[(i, i)]));
            }
        }
        let (k, pivot) = largest?;
        if pivot > undecided {
            // Where k came from is out of the compiler's sight: an index would keep a panic.
            if let Some(eliminated) = eliminated.get_mut(k) {
                *eliminated = true;
            }
            let at = |rest: &OMatrix<T, D, D>, i: usize, j: usize| rest.get((i, j)).copied().unwrap_or_else(T::zero);
            for i in 0..order {
                if eliminated[i] {
                    continue;
                }
                let factor = at(&rest, i, k) / pivot;
                for j in 0..order {
                    if !eliminated[j] {
                        let reduced = rest[(i, j)] - factor * at(&rest, k, j);
                        rest[(i, j)] = reduced;
                    }
                }
            }
            continue;
        }
        // No diagonal entry that is left is positive. A semidefinite rest is zero.
        let zero = |i: usize| {
            rest[(i, i)] >= -undecided && (0..order).all(|j| j == i || eliminated[j] || rest[(i, j)].abs() <= undecided)
        };
        for i in 0..order {
            if !eliminated[i] && (definite || !zero(i)) {
                return Some((i, rest[(i, i)] * scale));
            }
        }
        return None;
    }
}
