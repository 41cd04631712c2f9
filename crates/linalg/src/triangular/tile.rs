//! The smallest pieces of a recursive substitution: Sylvester equations of order at most [`ORDER`], on the stack.
//!
//! Block columns are solved from the left, block rows from below; each step is a system of order at most four, everything else runs down
//! columns (Bartels and Stewart, CACM 15, 1972; LAPACK dtrsyl).

use super::{Coefficient, Equation, Sizes};
use crate::linear_block::LinearBlock;
use faer::MatMut;

/// Up to here one substitution is faster than two and a product.
pub(super) const ORDER: usize = 16;

/// A matrix of order at most [`ORDER`], by columns.
type Tile = [[f64; ORDER]; ORDER];

/// `op(S)` as an upper quasi-triangular tile: a transposed coefficient is turned about, `J S'J`.
fn load(s: Coefficient<'_>) -> Tile {
    let n = s.t.nrows();
    let mut tile = [[0.0; ORDER]; ORDER];
    for j in 0..n {
        for i in 0..n.min(j + 2) {
            if s.transposed {
                tile[n - 1 - i][n - 1 - j] = s.t[(i, j)];
            } else {
                tile[j][i] = s.t[(i, j)];
            }
        }
    }
    tile
}

/// The order of the diagonal block of an upper quasi-triangular tile of order `n` that starts at `k`.
fn block(tile: &Tile, n: usize, k: usize) -> usize {
    if k + 1 < n && tile[k][k + 1] != 0.0 { 2 } else { 1 }
}

/// `y += a x`.
fn axpy(y: &mut [f64], a: f64, x: &[f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += a * x);
}

/// Overwrites `d` with the solution of the equation. False where a pivot does not exceed its floor.
pub(super) fn solve(
    equation: Equation,
    s: Coefficient<'_>,
    t: Coefficient<'_>,
    mut d: MatMut<'_, f64>,
    sizes: Sizes,
) -> bool {
    let (n, m) = d.shape();
    let (left, right) = (load(s), load(t));
    let row = |i: usize| if s.transposed { n - 1 - i } else { i };
    let col = |j: usize| if t.transposed { m - 1 - j } else { j };
    let mut tile = [[0.0; ORDER]; ORDER];
    for j in 0..m {
        for i in 0..n {
            tile[j][i] = d[(row(i), col(j))];
        }
    }
    let regular = substitute(equation, (&left, n), (&right, m), &mut tile, sizes);
    for j in 0..m {
        for i in 0..n {
            d[(row(i), col(j))] = tile[j][i];
        }
    }
    regular
}

fn substitute(equation: Equation, (s, n): (&Tile, usize), (t, m): (&Tile, usize), d: &mut Tile, sizes: Sizes) -> bool {
    let mut regular = true;
    let mut j = 0;
    while j < m {
        let cols = block(t, m, j);
        let (done, rest) = d.split_at_mut(j);
        for jj in 0..cols {
            let column = &mut rest[jj][..n];
            match equation {
                Equation::Sylvester => done.iter().enumerate().for_each(|(l, y)| axpy(column, -t[j + jj][l], y)),
                Equation::Stein => {
                    let mut product = [0.0; ORDER];
                    done.iter().enumerate().for_each(|(l, y)| axpy(&mut product[..n], t[j + jj][l], y));
                    for k in 0..n {
                        let filled = n.min(k + 2);
                        axpy(&mut column[..filled], -product[k], &s[k]);
                    }
                }
            }
        }
        // Block rows from below: a block ends where the one under it starts.
        let mut end = n;
        while end > 0 {
            let size = if end > 1 && s[end - 2][end - 1] != 0.0 { 2 } else { 1 };
            let i = end - size;
            let x = step(equation, (s, i, size), (t, j, cols), rest, sizes, &mut regular);
            for jj in 0..cols {
                let column = &mut rest[jj];
                for ii in 0..size {
                    column[i + ii] = x[jj][ii];
                    let weight = match equation {
                        Equation::Sylvester => x[jj][ii],
                        Equation::Stein => (0..cols).map(|l| x[l][ii] * t[j + jj][j + l]).sum(),
                    };
                    axpy(&mut column[..i], -weight, &s[i + ii]);
                }
            }
            end = i;
        }
        j += cols;
    }
    regular
}

/// The unknowns of one pair of diagonal blocks, by columns.
fn step(
    equation: Equation,
    (s, i, size): (&Tile, usize, usize),
    (t, j, cols): (&Tile, usize, usize),
    rest: &[[f64; ORDER]],
    sizes: Sizes,
    regular: &mut bool,
) -> [[f64; 2]; 2] {
    let largest = |tile: &Tile, k: usize, size: usize| {
        tile[k..k + size]
            .iter()
            .flat_map(|column| &column[k..k + size])
            .fold(0.0_f64, |largest, x| largest.max(x.abs()))
    };
    let floor = sizes.floor(equation, largest(s, i, size), largest(t, j, cols));
    if size == 1 && cols == 1 {
        let mut pivot = match equation {
            Equation::Sylvester => s[i][i] + t[j][j],
            Equation::Stein => s[i][i] * t[j][j] - 1.0,
        };
        if pivot.abs() <= floor {
            (pivot, *regular) = (floor, false);
        }
        return [[rest[0][i] / pivot, 0.0], [0.0; 2]];
    }
    let (left, right) = (|k: usize, l: usize| s[i + l][i + k], |k: usize, l: usize| t[j + l][j + k]);
    let mut system = match equation {
        Equation::Sylvester => LinearBlock::sylvester(size, cols, left, right),
        Equation::Stein => LinearBlock::stein(size, cols, left, right),
    };
    for (jj, column) in rest.iter().enumerate().take(cols) {
        for ii in 0..size {
            system.set_rhs(ii, jj, column[i + ii]);
        }
    }
    *regular &= system.solve(floor);
    let mut x = [[0.0; 2]; 2];
    for (jj, column) in x.iter_mut().enumerate().take(cols) {
        for (ii, entry) in column.iter_mut().enumerate().take(size) {
            *entry = system.x(ii, jj);
        }
    }
    x
}
