//! Smallest Lyapunov equations of the recursion, with a symmetric right-hand side: the rows of each block column down
//! to the diagonal are solved for, the others follow by symmetry.

use super::pair;
use super::tile::{ORDER, Tile, Triangle, axpy};
use super::{Coefficient, Equation, Sizes};
use crate::kernel::{Kernel, dispatch};
use faer::MatMut;

/// Overwrites the symmetric `d`, given by its upper triangle, with the upper triangle of the solution of
/// `op(T)'Y + Y op(T) = D`: half of the steps of [`solve`](super::tile::solve).
pub(super) fn solve(t: Coefficient<'_>, d: MatMut<'_, f64>, sizes: Sizes) -> bool {
    dispatch(Half { t, d, sizes })
}

struct Half<'a> {
    t: Coefficient<'a>,
    d: MatMut<'a, f64>,
    sizes: Sizes,
}

impl Kernel for Half<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> bool {
        match self.d.nrows() {
            0..=4 => self.of::<4, FMA>(),
            5..=8 => self.of::<8, FMA>(),
            _ => self.of::<ORDER, FMA>(),
        }
    }
}

impl Half<'_> {
    #[inline(always)]
    fn of<const W: usize, const FMA: bool>(self) -> bool {
        let Self { t, mut d, sizes } = self;
        let triangle = Triangle::<W>::load(t);
        let n = triangle.n;
        // With rows and columns in reverse order, the transposed equation is the plain one.
        let at = |i: usize, j: usize| if t.transposed { (n - 1 - j, n - 1 - i) } else { (i, j) };
        // Entries below the blocks are zero until they are known.
        let mut tile = [[0.0; W]; W];
        for b in &triangle.blocks[..triangle.count] {
            for j in b.start..b.start + b.size {
                for i in 0..=j {
                    tile[j][i] = d[at(i, j)];
                }
            }
            if b.size == 2 {
                tile[b.start][b.start + 1] = tile[b.start + 1][b.start];
            }
        }
        let mut beside = [[0.0; W]; W];
        for (l, above) in triangle.above.iter().enumerate().take(n) {
            for i in 0..l {
                beside[i][l] = above[i];
            }
        }
        let mut regular = true;
        for k in 0..triangle.count {
            regular &= if triangle.blocks[k].size == 1 {
                upper_columns::<1, W, FMA>(&triangle, &beside, k, &mut tile, sizes)
            } else {
                upper_columns::<2, W, FMA>(&triangle, &beside, k, &mut tile, sizes)
            };
        }
        for j in 0..n {
            for i in 0..=j {
                d[at(i, j)] = tile[j][i];
            }
        }
        regular
    }
}

/// The `C` columns of block `k`, from the top down to the diagonal, and their mirror image below it.
#[inline(always)]
fn upper_columns<const C: usize, const W: usize, const FMA: bool>(
    triangle: &Triangle<W>,
    beside: &Tile<W>,
    k: usize,
    d: &mut Tile<W>,
    sizes: Sizes,
) -> bool {
    let block = &triangle.blocks[k];
    let start = block.start;
    let mut y = [[0.0; W]; C];
    y.copy_from_slice(&d[start..start + C]);
    for (l, done) in d[..start].iter().enumerate() {
        for (jj, y) in y.iter_mut().enumerate() {
            axpy::<W, FMA>(y, -triangle.above[start + jj][l], done);
        }
    }
    let corner = |y: &[[f64; W]; C]| {
        let mut corner = [[0.0; 2]; 2];
        for (to, y) in corner.iter_mut().zip(y) {
            *to = [y[start], if C == 2 { y[start + 1] } else { 0.0 }];
        }
        corner
    };
    // Unchanged so far: the previous columns have zeros in these rows.
    let given = corner(&y);
    let mut regular = true;
    for b in &triangle.blocks[..k] {
        let mut rhs = [[0.0; 2]; 2];
        for (rhs, y) in rhs.iter_mut().zip(&y) {
            *rhs = [y[b.start], if b.size == 2 { y[b.start + 1] } else { 0.0 }];
        }
        let (x, good) = pair::solve(Equation::Sylvester, &b.transposed(), block, rhs, sizes);
        regular &= good;
        for jj in 0..C {
            for ii in 0..b.size {
                y[jj][b.start + ii] = x[jj][ii];
                axpy::<W, FMA>(&mut y[jj], -x[jj][ii], &beside[b.start + ii]);
            }
        }
    }
    // On the diagonal T'Y and Y T are transposes of each other; only the first has been subtracted.
    let left = corner(&y);
    let mut rhs = [[0.0; 2]; 2];
    for jj in 0..C {
        for ii in 0..C {
            rhs[jj][ii] = left[jj][ii] + (left[ii][jj] - given[jj][ii]);
        }
    }
    let (mut x, good) = pair::solve(Equation::Sylvester, &block.transposed(), block, rhs, sizes);
    x[1][0] = 0.5 * (x[1][0] + x[0][1]);
    x[0][1] = x[1][0];
    for jj in 0..C {
        y[jj][start..start + C].copy_from_slice(&x[jj][..C]);
        y[jj][start + C..].fill(0.0);
        for (l, done) in d[..start].iter_mut().enumerate() {
            done[start + jj] = y[jj][l];
        }
    }
    d[start..start + C].copy_from_slice(&y);
    regular && good
}
