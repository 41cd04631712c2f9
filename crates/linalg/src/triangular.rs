//! Back-substitution for the Sylvester and Stein equations with quasi-triangular coefficients (Bartels and Stewart, CACM 15, 1972;
//! Kitagawa, Int. J. Control 25, 1977; LAPACK dtrsyl).
//!
//! Both coefficients are *upper* quasi-triangular. An equation with a transposed coefficient is brought here by [`flipped`]: with `J` the
//! reversal of order, `J T'J` is upper quasi-triangular again. Block columns are solved from the left, block rows from below; each
//! step is a system of order at most four, everything else runs down columns. `n m (n + m)` flops.

use crate::linear_block::LinearBlock;
use crate::schur::blocks;
use nalgebra::DMatrix;

/// `J T'J`: upper quasi-triangular if `T` is.
pub(crate) fn flipped(t: &DMatrix<f64>) -> DMatrix<f64> {
    let n = t.nrows();
    DMatrix::from_fn(n, n, |i, j| t[(n - 1 - j, n - 1 - i)])
}

/// `M := J M`.
pub(crate) fn flip_rows(m: &mut DMatrix<f64>) {
    let n = m.nrows();
    if n > 0 {
        m.as_mut_slice().chunks_exact_mut(n).for_each(<[f64]>::reverse);
    }
}

/// `M := M J`.
pub(crate) fn flip_cols(m: &mut DMatrix<f64>) {
    let n = m.ncols();
    for j in 0..n / 2 {
        m.swap_columns(j, n - 1 - j);
    }
}

/// Overwrites `d` with the solution `Y` of `S Y + Y T = D`. Returns whether the equation is regular: every pivot is beyond the
/// rounding of the coefficients. One that is not is raised to it, so that the answer stays finite where it can.
pub(crate) fn sylvester(s: &DMatrix<f64>, t: &DMatrix<f64>, d: &mut DMatrix<f64>) -> bool {
    let (n, mut regular) = (s.nrows(), true);
    if d.is_empty() {
        return true;
    }
    let smallest = (f64::EPSILON * s.amax().max(t.amax())).max(f64::MIN_POSITIVE / f64::EPSILON);
    let rows = blocks(s);
    for (j, cols) in blocks(t) {
        let (done, rest) = d.as_mut_slice().split_at_mut(j * n);
        for (jj, column) in rest.chunks_exact_mut(n).enumerate().take(cols) {
            for (l, y) in done.chunks_exact(n).enumerate() {
                axpy(column, -t[(l, j + jj)], y);
            }
        }
        for &(i, size) in rows.iter().rev() {
            let mut x = [[0.0; 2]; 2];
            if size == 1 && cols == 1 {
                let mut pivot = s[(i, i)] + t[(j, j)];
                if pivot.abs() <= smallest {
                    (pivot, regular) = (smallest, false);
                }
                x[0][0] = rest[i] / pivot;
            } else {
                let mut block = LinearBlock::sylvester(size, cols, |k, l| s[(i + k, i + l)], |k, l| t[(j + k, j + l)]);
                regular &= solve(&mut block, &mut x, rest, (n, i, size, cols), smallest);
            }
            for (jj, column) in rest.chunks_exact_mut(n).enumerate().take(cols) {
                for ii in 0..size {
                    column[i + ii] = x[ii][jj];
                    axpy(&mut column[..i], -x[ii][jj], &s.as_slice()[(i + ii) * n..(i + ii) * n + i]);
                }
            }
        }
    }
    regular
}

/// Overwrites `d` with the solution `Y` of `S Y T - Y = D`. Returns whether the equation is regular, as [`sylvester`].
pub(crate) fn stein(s: &DMatrix<f64>, t: &DMatrix<f64>, d: &mut DMatrix<f64>) -> bool {
    let (n, mut regular) = (s.nrows(), true);
    if d.is_empty() {
        return true;
    }
    let (largest_s, largest_t) = (s.amax(), t.amax());
    let rows = blocks(s);
    let mut product = vec![0.0; n];
    for (j, cols) in blocks(t) {
        let (done, rest) = d.as_mut_slice().split_at_mut(j * n);
        for (jj, column) in rest.chunks_exact_mut(n).enumerate().take(cols) {
            product.fill(0.0);
            for (l, y) in done.chunks_exact(n).enumerate() {
                axpy(&mut product, t[(l, j + jj)], y);
            }
            for (k, p) in product.iter().enumerate() {
                let filled = n.min(k + 2);
                axpy(&mut column[..filled], -p, &s.as_slice()[k * n..k * n + filled]);
            }
        }
        let size_t = t.view((j, j), (cols, cols)).amax();
        for &(i, size) in rows.iter().rev() {
            // The rounding of `A` moves a product of two eigenvalues by this much.
            let size_s = s.view((i, i), (size, size)).amax();
            let smallest = f64::EPSILON * (largest_s * size_t + largest_t * size_s).max(1.0);
            let mut x = [[0.0; 2]; 2];
            let mut block = LinearBlock::stein(size, cols, |k, l| s[(i + k, i + l)], |k, l| t[(j + k, j + l)]);
            regular &= solve(&mut block, &mut x, rest, (n, i, size, cols), smallest);
            for (jj, column) in rest.chunks_exact_mut(n).enumerate().take(cols) {
                for ii in 0..size {
                    column[i + ii] = x[ii][jj];
                    let w: f64 = (0..cols).map(|l| x[ii][l] * t[(j + l, j + jj)]).sum();
                    axpy(&mut column[..i], -w, &s.as_slice()[(i + ii) * n..(i + ii) * n + i]);
                }
            }
        }
    }
    regular
}

/// Solves one small system with the right-hand side found in `columns`, which has `shape = (leading dimension, row, rows, columns)`.
fn solve(
    block: &mut LinearBlock,
    x: &mut [[f64; 2]; 2],
    columns: &[f64],
    shape: (usize, usize, usize, usize),
    smallest: f64,
) -> bool {
    let (n, i, size, cols) = shape;
    for jj in 0..cols {
        for ii in 0..size {
            block.set_rhs(ii, jj, columns[jj * n + i + ii]);
        }
    }
    let regular = block.solve(smallest);
    for (ii, row) in x.iter_mut().enumerate().take(size) {
        for (jj, entry) in row.iter_mut().enumerate().take(cols) {
            *entry = block.x(ii, jj);
        }
    }
    regular
}

/// `y += a x`.
fn axpy(y: &mut [f64], a: f64, x: &[f64]) {
    if a != 0.0 {
        y.iter_mut().zip(x).for_each(|(y, x)| *y += a * x);
    }
}
