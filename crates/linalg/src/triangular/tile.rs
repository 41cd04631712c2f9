//! Smallest equations of the recursion: order at most [`ORDER`], stored on the stack.
//!
//! Block columns are solved from the left, block rows from the bottom (Bartels and Stewart, CACM 15, 1972; LAPACK
//! dtrsyl). Each step is an equation between two diagonal blocks (`pair.rs`) and an update of whole columns. The
//! entries above the diagonal blocks are stored separately, with zeros in place of the blocks, so that loops need not
//! test for block boundaries.

use super::pair::{self, Block};
use super::{Coefficient, Equation, Sizes};
use crate::kernel::{Kernel, dispatch, fma};
use faer::MatMut;

/// Up to this order one substitution is faster than two and a product.
pub(super) const ORDER: usize = 16;

/// Square array of order `W`, by columns.
pub(super) type Tile<const W: usize> = [[f64; W]; W];

/// An upper quasi-triangular matrix of order at most `W`.
pub(super) struct Triangle<const W: usize> {
    pub(super) n: usize,
    /// The diagonal blocks; the first `count` are used.
    pub(super) blocks: [Block; W],
    pub(super) count: usize,
    /// Entries above the blocks.
    pub(super) above: Tile<W>,
}

impl<const W: usize> Triangle<W> {
    /// `op(T)`; for a transposed coefficient `J T'J`, J the exchange matrix: rows and columns in reverse order.
    #[inline(always)]
    pub(super) fn load(coefficient: Coefficient<'_>) -> Self {
        let t = coefficient.t;
        let n = t.nrows().min(W);
        let mut found = Self { n, blocks: [Block::default(); W], count: 0, above: [[0.0; W]; W] };
        let (mut k, mut j) = (0, 0);
        while j < n {
            let size = if j + 1 < n && t[(j + 1, j)] != 0.0 { 2 } else { 1 };
            for l in j..j + size {
                for i in 0..j {
                    let entry = t[(i, l)];
                    if coefficient.transposed {
                        found.above[n - 1 - i][n - 1 - l] = entry;
                    } else {
                        found.above[l][i] = entry;
                    }
                }
            }
            let start = if coefficient.transposed { n - j - size } else { j };
            let block = if size == 1 {
                Block::one(start, t[(j, j)])
            } else if coefficient.transposed {
                Block::two(start, [[t[(j + 1, j + 1)], t[(j, j + 1)]], [t[(j + 1, j)], t[(j, j)]]])
            } else {
                Block::two(start, [[t[(j, j)], t[(j, j + 1)]], [t[(j + 1, j)], t[(j + 1, j + 1)]]])
            };
            found.blocks[k] = block;
            k += 1;
            j += size;
        }
        found.count = k;
        if coefficient.transposed {
            found.blocks[..k].reverse();
        }
        found
    }
}

/// `y += a x`.
#[inline(always)]
pub(super) fn axpy<const W: usize, const FMA: bool>(y: &mut [f64; W], a: f64, x: &[f64; W]) {
    for k in 0..W {
        y[k] = fma::<FMA>(a, x[k], y[k]);
    }
}

/// Overwrites `d` with the solution of the equation. Returns false if a pivot does not exceed its floor.
pub(super) fn solve(
    equation: Equation,
    s: Coefficient<'_>,
    t: Coefficient<'_>,
    d: MatMut<'_, f64>,
    sizes: Sizes,
) -> bool {
    dispatch(Whole { equation, s, t, d, sizes })
}

struct Whole<'a> {
    equation: Equation,
    s: Coefficient<'a>,
    t: Coefficient<'a>,
    d: MatMut<'a, f64>,
    sizes: Sizes,
}

impl Kernel for Whole<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> bool {
        match self.d.nrows().max(self.d.ncols()) {
            0..=4 => self.of::<4, FMA>(),
            5..=8 => self.of::<8, FMA>(),
            _ => self.of::<ORDER, FMA>(),
        }
    }
}

impl Whole<'_> {
    #[inline(always)]
    fn of<const W: usize, const FMA: bool>(self) -> bool {
        let Self { equation, s, t, mut d, sizes } = self;
        let (left, right) = (Triangle::<W>::load(s), Triangle::<W>::load(t));
        let (n, m) = (left.n, right.n);
        let row = |i: usize| if s.transposed { n - 1 - i } else { i };
        let col = |j: usize| if t.transposed { m - 1 - j } else { j };
        let mut tile = [[0.0; W]; W];
        for (j, column) in tile.iter_mut().enumerate().take(m) {
            for (i, entry) in column.iter_mut().enumerate().take(n) {
                *entry = d[(row(i), col(j))];
            }
        }
        let mut regular = true;
        for block in &right.blocks[..right.count] {
            regular &= if block.size == 1 {
                columns::<1, W, FMA>(equation, &left, &right, block, &mut tile, sizes)
            } else {
                columns::<2, W, FMA>(equation, &left, &right, block, &mut tile, sizes)
            };
        }
        for (j, column) in tile.iter().enumerate().take(m) {
            for (i, &entry) in column.iter().enumerate().take(n) {
                d[(row(i), col(j))] = entry;
            }
        }
        regular
    }
}

/// Solves for the `C` columns that belong to one block of the right coefficient.
#[inline(always)]
fn columns<const C: usize, const W: usize, const FMA: bool>(
    equation: Equation,
    left: &Triangle<W>,
    right: &Triangle<W>,
    block: &Block,
    d: &mut Tile<W>,
    sizes: Sizes,
) -> bool {
    let start = block.start;
    let mut y = [[0.0; W]; C];
    y.copy_from_slice(&d[start..start + C]);
    match equation {
        Equation::Sylvester => {
            for (l, done) in d[..start].iter().enumerate() {
                for (jj, y) in y.iter_mut().enumerate() {
                    axpy::<W, FMA>(y, -right.above[start + jj][l], done);
                }
            }
        }
        Equation::Stein => {
            let mut product = [[0.0; W]; C];
            for (l, done) in d[..start].iter().enumerate() {
                for (jj, product) in product.iter_mut().enumerate() {
                    axpy::<W, FMA>(product, right.above[start + jj][l], done);
                }
            }
            for (y, product) in y.iter_mut().zip(&product) {
                for (k, above) in left.above.iter().enumerate().take(left.n) {
                    axpy::<W, FMA>(y, -product[k], above);
                }
                for b in &left.blocks[..left.count] {
                    let x = [product[b.start], if b.size == 2 { product[b.start + 1] } else { 0.0 }];
                    for ii in 0..b.size {
                        y[b.start + ii] -= b.m[ii][0] * x[0] + b.m[ii][1] * x[1];
                    }
                }
            }
        }
    }
    let mut regular = true;
    for b in left.blocks[..left.count].iter().rev() {
        let mut rhs = [[0.0; 2]; 2];
        for (rhs, y) in rhs.iter_mut().zip(&y) {
            *rhs = [y[b.start], if b.size == 2 { y[b.start + 1] } else { 0.0 }];
        }
        let (x, good) = pair::solve(equation, b, block, rhs, sizes);
        regular &= good;
        for jj in 0..C {
            for ii in 0..b.size {
                y[jj][b.start + ii] = x[jj][ii];
                let weight = match equation {
                    Equation::Sylvester => x[jj][ii],
                    Equation::Stein => (0..C).map(|l| x[l][ii] * block.m[l][jj]).sum(),
                };
                axpy::<W, FMA>(&mut y[jj], -weight, &left.above[b.start + ii]);
            }
        }
    }
    d[start..start + C].copy_from_slice(&y);
    regular
}
