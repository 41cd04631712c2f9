//! Products: `gemm`, `gemv`, `symv`, `syrk`, `syr2k`, on views.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};

use crate::abi::Triangle;
use crate::element::Element;

/// Whether every entry is finite.
pub(crate) fn is_finite<T: Element>(a: MatRef<'_, T>) -> bool {
    (0..a.ncols()).all(|j| a.col(j).iter().all(|x| x.finite()))
}

/// `C := beta C`, the whole of it, without reading C when beta is 0.
fn scale<T: Element>(mut c: MatMut<'_, T>, beta: T, part: Option<Triangle>) {
    if beta == T::ONE {
        return;
    }
    for j in 0..c.ncols() {
        let rows = match part {
            None => 0..c.nrows(),
            Some(Triangle::Lower) => j..c.nrows(),
            Some(Triangle::Upper) => 0..(j + 1).min(c.nrows()),
        };
        for i in rows {
            c[(i, j)] = if beta == T::ZERO { T::ZERO } else { beta * c[(i, j)] };
        }
    }
}

/// `C := alpha A B + beta C`.
pub(crate) fn gemm<T: Element>(alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, beta: T, mut c: MatMut<'_, T>) {
    scale(c.as_mut(), beta, None);
    if alpha != T::ZERO && a.ncols() > 0 && c.nrows() > 0 && c.ncols() > 0 {
        matmul(c, Accum::Add, a, b, alpha, Par::Seq);
    }
}

/// `y := alpha A x + beta y`, one column of A at a time, or one dot product at a time when A is a transposed view.
pub(crate) fn gemv<T: Element>(alpha: T, a: MatRef<'_, T>, x: &[T], beta: T, y: &mut [T]) {
    scale_vector(y, beta);
    if alpha == T::ZERO {
        return;
    }
    if a.row_stride() == 1 {
        for (j, &xj) in x.iter().enumerate() {
            let factor = alpha * xj;
            for (yi, &aij) in y.iter_mut().zip(a.col(j).iter()) {
                *yi += factor * aij;
            }
        }
    } else {
        for (i, yi) in y.iter_mut().enumerate() {
            let mut dot = T::ZERO;
            for (&xj, &aij) in x.iter().zip(a.row(i).iter()) {
                dot += aij * xj;
            }
            *yi += alpha * dot;
        }
    }
}

/// `y := alpha A x + beta y`, A symmetric with one triangle stored.
pub(crate) fn symv<T: Element>(stored: Triangle, alpha: T, a: MatRef<'_, T>, x: &[T], beta: T, y: &mut [T]) {
    scale_vector(y, beta);
    if alpha == T::ZERO {
        return;
    }
    for j in 0..a.ncols() {
        let factor = alpha * x[j];
        y[j] += factor * a[(j, j)];
        let mut dot = T::ZERO;
        let off_diagonal = match stored {
            Triangle::Lower => j + 1..a.nrows(),
            Triangle::Upper => 0..j,
        };
        for i in off_diagonal {
            let aij = a[(i, j)];
            y[i] += factor * aij;
            dot += aij * x[i];
        }
        y[j] += alpha * dot;
    }
}

fn scale_vector<T: Element>(y: &mut [T], beta: T) {
    for yi in y {
        *yi = if beta == T::ZERO { T::ZERO } else { beta * *yi };
    }
}

/// One triangle of `C := alpha A B + C`.
fn add_triangle<T: Element>(stored: Triangle, alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, c: MatMut<'_, T>) {
    let part = match stored {
        Triangle::Lower => BlockStructure::TriangularLower,
        Triangle::Upper => BlockStructure::TriangularUpper,
    };
    let full = BlockStructure::Rectangular;
    triangular::matmul(c, part, Accum::Add, a, full, b, full, alpha, Par::Seq);
}

/// One triangle of `C := alpha A A' + beta C`.
pub(crate) fn syrk<T: Element>(stored: Triangle, alpha: T, a: MatRef<'_, T>, beta: T, mut c: MatMut<'_, T>) {
    scale(c.as_mut(), beta, Some(stored));
    if alpha != T::ZERO && a.ncols() > 0 && a.nrows() > 0 {
        add_triangle(stored, alpha, a, a.transpose(), c);
    }
}

/// One triangle of `C := alpha (A B' + B A') + beta C`.
pub(crate) fn syr2k<T: Element>(
    stored: Triangle,
    alpha: T,
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    beta: T,
    mut c: MatMut<'_, T>,
) {
    scale(c.as_mut(), beta, Some(stored));
    if alpha != T::ZERO && a.ncols() > 0 && a.nrows() > 0 {
        add_triangle(stored, alpha, a, b.transpose(), c.as_mut());
        add_triangle(stored, alpha, b, a.transpose(), c);
    }
}
