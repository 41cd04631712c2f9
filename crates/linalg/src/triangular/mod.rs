//! Sylvester, Stein and Lyapunov equations with quasi-triangular coefficients, by recursive blocking (Jonsson and
//! Kagstrom, ACM TOMS 28, 2002, I and II).
//!
//! The longer side is halved; the solution of the first of the two smaller equations enters the right-hand side of the
//! second by a matrix product. Almost all of the `n m (n + m)` flops are then matrix products; the remaining tiles of
//! order 16 are solved by substitution (`tile.rs`, `symmetric_tile.rs`). A 2 x 2 block is never split. Equations with a
//! symmetric solution use the upper triangle only and cost half.

mod pair;
mod symmetric_tile;
mod tile;

use crate::product::{mirror, multiply, multiply_upper};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef};
use tile::ORDER;

/// Type of the equation, for the coefficients `op(S)`, `op(T)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Equation {
    /// `op(S) Y + Y op(T) = D`.
    Sylvester,
    /// `op(S) Y op(T) - Y = D`.
    Stein,
}

/// `op(T)`: an upper quasi-triangular matrix or its transpose.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coefficient<'a> {
    t: MatRef<'a, f64>,
    transposed: bool,
    /// Whether the entries count as exact, so that only a zero pivot is singular.
    exact: bool,
}

impl<'a> Coefficient<'a> {
    /// `T`.
    pub(crate) fn plain(t: MatRef<'a, f64>) -> Self {
        Self { t, transposed: false, exact: false }
    }

    /// `T'`.
    pub(crate) fn transposed(t: MatRef<'a, f64>) -> Self {
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
struct Sizes {
    s: f64,
    t: f64,
    /// Whether the coefficients count as exact.
    exact: bool,
}

impl Sizes {
    /// Rounding level of a pivot of two diagonal blocks whose largest entries are `s` and `t`.
    fn floor(self, equation: Equation, s: f64, t: f64) -> f64 {
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
pub(crate) fn solve(
    equation: Equation,
    s: Coefficient<'_>,
    t: Coefficient<'_>,
    d: MatMut<'_, f64>,
    work: &mut [f64],
) -> bool {
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
pub(crate) fn solve_symmetric(
    equation: Equation,
    t: Coefficient<'_>,
    mut d: MatMut<'_, f64>,
    work: &mut [f64],
) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::{view, view_mut};
    use nalgebra::DMatrix;

    /// Upper quasi-triangular, about half of the diagonal in standardised 2 x 2 blocks, eigenvalues of modulus 0.2 to
    /// 0.9.
    fn quasi_triangular(n: usize, seed: usize) -> DMatrix<f64> {
        let entry = |i: usize, j: usize| (((seed + 1) * (1 + 31 * i + 17 * j * j + i * i * j)) as f64).sin();
        let mut t = DMatrix::from_fn(n, n, |i, j| if i < j { 0.3 * entry(i, j) / (n as f64).sqrt() } else { 0.0 });
        let mut k = 0;
        while k < n {
            let real = 0.55 + 0.15 * entry(k, k);
            t[(k, k)] = real;
            if k + 1 < n && (k + seed) % 5 < 3 {
                t[(k + 1, k + 1)] = real;
                (t[(k, k + 1)], t[(k + 1, k)]) = (0.5, -0.2);
                k += 1;
            }
            k += 1;
        }
        t
    }

    fn right_hand_side(n: usize, m: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, m, |i, j| ((3 + 7 * i + 13 * j * j + i * j) as f64).cos())
    }

    fn operator(equation: Equation, s: Coefficient<'_>, t: Coefficient<'_>, y: &DMatrix<f64>) -> DMatrix<f64> {
        let whole = |c: Coefficient<'_>| {
            let factor = c.factor();
            DMatrix::from_fn(factor.nrows(), factor.ncols(), |i, j| factor[(i, j)])
        };
        match equation {
            Equation::Sylvester => whole(s) * y + y * whole(t),
            Equation::Stein => whole(s) * y * whole(t) - y,
        }
    }

    /// Backward stability: a residual of a few n eps for every transposition, with and without recursion.
    #[test]
    fn every_form_of_the_equation_is_solved() {
        for (n, m) in [(1, 1), (3, 20), (16, 16), (17, 5), (17, 17), (40, 33), (33, 90), (70, 70)] {
            let (s, t) = (quasi_triangular(n, 1), quasi_triangular(m, 2));
            for equation in [Equation::Sylvester, Equation::Stein] {
                for (left, right) in [(false, false), (false, true), (true, false), (true, true)] {
                    let (left, right) = (
                        Coefficient { transposed: left, ..Coefficient::plain(view(&s)) },
                        Coefficient { transposed: right, ..Coefficient::plain(view(&t)) },
                    );
                    let d = right_hand_side(n, m);
                    let mut y = d.clone();
                    assert!(solve(equation, left, right, view_mut(&mut y), &mut vec![0.0; n * m]));
                    let residual = (operator(equation, left, right, &y) - &d).norm();
                    let terms = (s.norm() + t.norm() + s.norm() * t.norm()) * y.norm() + d.norm();
                    assert!(
                        residual <= 10.0 * n.max(m) as f64 * f64::EPSILON * terms,
                        "{n} {m} {equation:?} {residual:e}"
                    );
                }
            }
        }
    }

    /// The symmetric and the general recursion give the same solution.
    #[test]
    fn the_symmetric_solution_is_the_solution() {
        for n in [1, 2, 16, 17, 18, 33, 50, 97] {
            let t = quasi_triangular(n, 3);
            let d = right_hand_side(n, n);
            let d = &d + d.transpose();
            for equation in [Equation::Sylvester, Equation::Stein] {
                for transposed in [false, true] {
                    let t = Coefficient { transposed, ..Coefficient::plain(view(&t)) };
                    let (mut whole, mut half) = (d.clone(), d.clone());
                    // Entries below the diagonal are not read.
                    (0..n).for_each(|j| (j + 1..n).for_each(|i| half[(i, j)] = f64::NAN));
                    let mut work = vec![0.0; n * n];
                    assert!(solve(equation, t.transpose(), t, view_mut(&mut whole), &mut work));
                    assert!(solve_symmetric(equation, t, view_mut(&mut half), &mut work));
                    assert_eq!(half, half.transpose());
                    // Sums of eigenvalues exceed 0.4 and products stay below 0.85: condition below 1e3.
                    assert!(
                        (&half - &whole).norm() <= 1e3 * n as f64 * f64::EPSILON * whole.norm(),
                        "{n} {equation:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_vanishing_pivot_is_reported_and_the_answer_stays_finite() {
        for n in [1, 2, 40] {
            let t = DMatrix::from_fn(
                n,
                n,
                |i, j| if i + 1 == n && j == i { -0.5 } else { f64::from(u8::from(i == j)) * 0.5 },
            );
            let mut y = right_hand_side(n, n);
            let t = Coefficient::plain(view(&t));
            let regular = solve(Equation::Sylvester, t, t, view_mut(&mut y), &mut []);
            assert!(y.iter().all(|e| e.is_finite()));
            assert_eq!(regular, n == 1);
        }
    }
}
