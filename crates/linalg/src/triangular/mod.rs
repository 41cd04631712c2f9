//! Sylvester, Stein and Lyapunov equations with quasi-triangular coefficients, by recursive blocking (Jonsson and
//! Kagstrom, ACM TOMS 28, 2002, I and II).
//!
//! The longer side is halved; the solution of the first of the two smaller equations enters the right-hand side of the
//! second by a matrix product. Almost all of the `n m (n + m)` flops are then matrix products; the remaining tiles of
//! order 16 are solved by substitution (`tile.rs`, `symmetric_tile.rs`). A 2 x 2 block is never split. Equations with a
//! symmetric solution use the upper triangle only and cost half.

pub(crate) mod pair;
mod symmetric_tile;
mod tile;

use crate::product::{mirror, multiply, multiply_upper};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef};
use tile::ORDER;

/// Type of the equation, for the coefficients `op(S)`, `op(T)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Equation {
    /// `op(S) Y + Y op(T) = D`.
    Sylvester,
    /// `op(S) Y op(T) - Y = D`.
    Stein,
}

/// `op(T)`: an upper quasi-triangular matrix or its transpose.
#[derive(Debug, Clone, Copy)]
pub struct Coefficient<'a> {
    t: MatRef<'a, f64>,
    transposed: bool,
    /// Whether the entries count as exact, so that only a zero pivot is singular.
    exact: bool,
}

impl<'a> Coefficient<'a> {
    /// `T`.
    pub fn plain(t: MatRef<'a, f64>) -> Self {
        Self { t, transposed: false, exact: false }
    }

    /// `T'`.
    pub fn transposed(t: MatRef<'a, f64>) -> Self {
        Self { t, transposed: true, exact: false }
    }

    /// The same coefficient with its entries marked as exact or not.
    pub(crate) fn exact(self, exact: bool) -> Self {
        Self { exact, ..self }
    }

    /// `op(T)'`.
    fn transpose(self) -> Self {
        Self { transposed: !self.transposed, ..self }
    }

    /// `op(T)` as a factor of a product.
    fn factor(self) -> MatRef<'a, f64> {
        if self.transposed { self.t.transpose() } else { self.t }
    }

    /// Diagonal blocks of a split at `k`, and the coupling block of `op(T)`: above the diagonal if plain, below if
    /// transposed.
    fn cut(self, k: usize) -> (Self, MatRef<'a, f64>, Self) {
        let (first, coupling, _, second) = self.t.split_at(k, k);
        let coupling = if self.transposed { coupling.transpose() } else { coupling };
        (Self { t: first, ..self }, coupling, Self { t: second, ..self })
    }

    /// Index of the split: near the middle, a multiple of the tile order if possible, and not within a 2 x 2 block.
    fn middle(self) -> usize {
        let n = self.t.nrows();
        let half = (n / 2).next_multiple_of(ORDER);
        let k = if half < n { half } else { n / 2 };
        if self.t[(k, k - 1)] == 0.0 { k } else { k - 1 }
    }
}

/// Norms of the coefficients, which define the rounding level.
#[derive(Debug, Clone, Copy)]
pub struct Sizes {
    /// Largest entry of the left coefficient.
    pub s: f64,
    /// Of the right one.
    pub t: f64,
    /// Whether the coefficients count as exact.
    pub exact: bool,
}

impl Sizes {
    /// Rounding level of a pivot of two diagonal blocks whose largest entries are `s` and `t`.
    pub fn floor(self, equation: Equation, s: f64, t: f64) -> f64 {
        if self.exact {
            return f64::MIN_POSITIVE / f64::EPSILON;
        }
        match equation {
            Equation::Sylvester => (f64::EPSILON * self.s.max(self.t)).max(f64::MIN_POSITIVE / f64::EPSILON),
            // Change of a product of two eigenvalues due to rounding of the coefficients.
            Equation::Stein => f64::EPSILON * (self.s * t + self.t * s).max(1.0),
        }
    }
}

/// Overwrites `d` (n x m) with the solution of the equation. `work` has room for n m numbers (used by the Stein
/// equation only).
///
/// Returns whether the equation is regular: every pivot exceeds the rounding level of the coefficients. A smaller pivot
/// is raised to that level, so that the result stays finite if possible.
pub fn solve(equation: Equation, s: Coefficient<'_>, t: Coefficient<'_>, d: MatMut<'_, f64>, work: &mut [f64]) -> bool {
    if d.nrows() * d.ncols() == 0 {
        return true;
    }
    let sizes = Sizes { s: s.t.norm_max(), t: t.t.norm_max(), exact: s.exact && t.exact };
    halve(equation, s, t, d, work, sizes)
}

fn halve(
    equation: Equation,
    s: Coefficient<'_>,
    t: Coefficient<'_>,
    d: MatMut<'_, f64>,
    work: &mut [f64],
    sizes: Sizes,
) -> bool {
    let (n, m) = d.shape();
    if n.max(m) <= ORDER {
        return tile::solve(equation, s, t, d, sizes);
    }
    if n >= m {
        let k = s.middle();
        let (upper, coupling, lower) = s.cut(k);
        let (d_upper, d_lower) = d.split_at_row_mut(k);
        // A plain coefficient is solved from the bottom, a transposed one from the top.
        let (first, mut d_first, second, mut d_second) =
            if s.transposed { (upper, d_upper, lower, d_lower) } else { (lower, d_lower, upper, d_upper) };
        let regular = halve(equation, first, t, d_first.rb_mut(), work, sizes);
        match equation {
            Equation::Sylvester => multiply(d_second.rb_mut(), Accum::Add, -1.0, coupling, d_first.rb()),
            Equation::Stein => {
                let mut image = scratch(work, d_first.nrows(), m);
                multiply(image.rb_mut(), Accum::Replace, 1.0, d_first.rb(), t.factor());
                multiply(d_second.rb_mut(), Accum::Add, -1.0, coupling, image.rb());
            }
        }
        halve(equation, second, t, d_second, work, sizes) && regular
    } else {
        let k = t.middle();
        let (left, coupling, right) = t.cut(k);
        let (d_left, d_right) = d.split_at_col_mut(k);
        let (first, mut d_first, second, mut d_second) =
            if t.transposed { (right, d_right, left, d_left) } else { (left, d_left, right, d_right) };
        let regular = halve(equation, s, first, d_first.rb_mut(), work, sizes);
        match equation {
            Equation::Sylvester => multiply(d_second.rb_mut(), Accum::Add, -1.0, d_first.rb(), coupling),
            Equation::Stein => {
                let mut image = scratch(work, n, d_second.ncols());
                multiply(image.rb_mut(), Accum::Replace, 1.0, d_first.rb(), coupling);
                multiply(d_second.rb_mut(), Accum::Add, -1.0, s.factor(), image.rb());
            }
        }
        halve(equation, s, second, d_second, work, sizes) && regular
    }
}

fn scratch(work: &mut [f64], rows: usize, cols: usize) -> MatMut<'_, f64> {
    MatMut::from_column_major_slice_mut(&mut work[..rows * cols], rows, cols)
}

/// `op(T)'Y + Y op(T) = D` or `op(T)'Y op(T) - Y = D` with symmetric `D`, given by its upper triangle; both triangles
/// of Y are returned. Otherwise as [`solve`].
pub fn solve_symmetric(equation: Equation, t: Coefficient<'_>, mut d: MatMut<'_, f64>, work: &mut [f64]) -> bool {
    if d.nrows() == 0 {
        return true;
    }
    let size = t.t.norm_max();
    let sizes = Sizes { s: size, t: size, exact: t.exact };
    let regular = halve_symmetric(equation, t, d.rb_mut(), work, sizes);
    mirror(d);
    regular
}

fn halve_symmetric(
    equation: Equation,
    t: Coefficient<'_>,
    mut d: MatMut<'_, f64>,
    work: &mut [f64],
    sizes: Sizes,
) -> bool {
    let n = d.nrows();
    if n <= ORDER {
        if equation == Equation::Sylvester {
            return symmetric_tile::solve(t, d, sizes);
        }
        mirror(d.rb_mut());
        return tile::solve(equation, t.transpose(), t, d, sizes);
    }
    let k = t.middle();
    let (upper, coupling, lower) = t.cut(k);
    let (mut d11, mut d12, _, mut d22) = d.split_at_mut(k, k);
    let (add, replace) = (Accum::Add, Accum::Replace);
    if t.transposed {
        // op(T) = [T1' 0; X' T2'], `coupling` = X': first the block Y22.
        let x = coupling.transpose();
        let mut regular = halve_symmetric(equation, lower, d22.rb_mut(), work, sizes);
        mirror(d22.rb_mut());
        if equation == Equation::Sylvester {
            multiply(d12.rb_mut(), add, -1.0, x, d22.rb());
        } else {
            let mut image = scratch(work, k, n - k);
            multiply(image.rb_mut(), replace, 1.0, x, d22.rb());
            multiply(d12.rb_mut(), add, -1.0, image.rb(), lower.factor());
        }
        regular &= halve(equation, upper.transpose(), lower, d12.rb_mut(), work, sizes);
        if equation == Equation::Sylvester {
            multiply_upper(d11.rb_mut(), add, -1.0, x, d12.rb().transpose());
            multiply_upper(d11.rb_mut(), add, -1.0, d12.rb(), coupling);
        } else {
            // D11 -= W X' + X W' with W = X Y22 / 2 + T1 Y12.
            let mut w = scratch(work, k, n - k);
            multiply(w.rb_mut(), replace, 0.5, x, d22.rb());
            multiply(w.rb_mut(), add, 1.0, upper.transpose().factor(), d12.rb());
            multiply_upper(d11.rb_mut(), add, -1.0, w.rb(), coupling);
            multiply_upper(d11.rb_mut(), add, -1.0, x, w.rb().transpose());
        }
        return halve_symmetric(equation, upper, d11, work, sizes) && regular;
    }
    // op(T) = [T1 X; 0 T2], `coupling` = X: first the block Y11.
    let mut regular = halve_symmetric(equation, upper, d11.rb_mut(), work, sizes);
    mirror(d11.rb_mut());
    if equation == Equation::Sylvester {
        multiply(d12.rb_mut(), add, -1.0, d11.rb(), coupling);
    } else {
        let mut image = scratch(work, k, n - k);
        multiply(image.rb_mut(), replace, 1.0, d11.rb(), coupling);
        multiply(d12.rb_mut(), add, -1.0, upper.transpose().factor(), image.rb());
    }
    regular &= halve(equation, upper.transpose(), lower, d12.rb_mut(), work, sizes);
    if equation == Equation::Sylvester {
        multiply_upper(d22.rb_mut(), add, -1.0, coupling.transpose(), d12.rb());
        multiply_upper(d22.rb_mut(), add, -1.0, d12.rb().transpose(), coupling);
    } else {
        // D22 -= X'W + W'X with W = Y11 X / 2 + Y12 T2.
        let mut w = scratch(work, k, n - k);
        multiply(w.rb_mut(), replace, 0.5, d11.rb(), coupling);
        multiply(w.rb_mut(), add, 1.0, d12.rb(), lower.factor());
        multiply_upper(d22.rb_mut(), add, -1.0, coupling.transpose(), w.rb());
        multiply_upper(d22.rb_mut(), add, -1.0, w.rb().transpose(), coupling);
    }
    halve_symmetric(equation, lower, d22, work, sizes) && regular
}
