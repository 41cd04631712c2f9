//! Gaussian elimination with row exchanges: `gesv`.
//!
//! Written out, since LAPACK's `ipiv` is the sequence of exchanges and faer keeps the resulting permutation.
//! Column-oriented (right-looking) elimination, 2/3 n^3 flops.

use faer::MatMut;

use crate::element::Element;

/// Overwrites A with L and U of `A = P L U`, B with the solution of `A X = B`, and `exchanges[k]` with the row
/// exchanged with row k. Returns the index of the first zero pivot, in which case B is untouched.
pub(crate) fn gesv<T: Element>(
    mut a: MatMut<'_, T>,
    exchanges: &mut [usize],
    mut b: MatMut<'_, T>,
) -> Result<(), usize> {
    let n = a.nrows();
    let mut singular = None;
    for k in 0..n {
        let mut pivot = k;
        for i in k + 1..n {
            if magnitude(a[(i, k)]) > magnitude(a[(pivot, k)]) {
                pivot = i;
            }
        }
        exchanges[k] = pivot;
        if a[(pivot, k)] == T::ZERO {
            singular = singular.or(Some(k));
            continue;
        }
        exchange_rows(a.as_mut(), k, pivot);
        let divisor = a[(k, k)];
        for i in k + 1..n {
            a[(i, k)] /= divisor;
        }
        for j in k + 1..n {
            let factor = a[(k, j)];
            for i in k + 1..n {
                let product = a[(i, k)] * factor;
                a[(i, j)] -= product;
            }
        }
    }
    if let Some(k) = singular {
        return Err(k);
    }
    for (k, &pivot) in exchanges.iter().enumerate() {
        exchange_rows(b.as_mut(), k, pivot);
    }
    for j in 0..b.ncols() {
        for k in 0..n {
            let x = b[(k, j)];
            for i in k + 1..n {
                b[(i, j)] -= a[(i, k)] * x;
            }
        }
        for k in (0..n).rev() {
            b[(k, j)] /= a[(k, k)];
            let x = b[(k, j)];
            for i in 0..k {
                b[(i, j)] -= a[(i, k)] * x;
            }
        }
    }
    Ok(())
}

fn magnitude<T: Element>(x: T) -> T {
    if x < T::ZERO { T::ZERO - x } else { x }
}

fn exchange_rows<T: Element>(mut m: MatMut<'_, T>, i: usize, j: usize) {
    if i != j {
        for column in 0..m.ncols() {
            let kept = m[(i, column)];
            m[(i, column)] = m[(j, column)];
            m[(j, column)] = kept;
        }
    }
}
