//! The smallest linear matrix equations, with coefficients of order one or two, as a linear system of order at most
//! four.
//!
//! Gaussian elimination with complete pivoting, as in LAPACK dlasy2 and dgetc2: a pivot too small to divide by is
//! raised to the smallest one allowed, and reported.

/// A system of order `rows * cols`, unknowns `x(i, j)` stored by columns.
#[derive(Debug, Clone)]
pub(crate) struct LinearBlock {
    rows: usize,
    order: usize,
    m: [[f64; 4]; 4],
    rhs: [f64; 4],
}

impl LinearBlock {
    fn new(rows: usize, cols: usize, coefficient: impl Fn((usize, usize), (usize, usize)) -> f64) -> Self {
        let mut m = [[0.0; 4]; 4];
        for j in 0..cols {
            for i in 0..rows {
                for l in 0..cols {
                    for k in 0..rows {
                        m[j * rows + i][l * rows + k] = coefficient((i, j), (k, l));
                    }
                }
            }
        }
        Self { rows, order: rows * cols, m, rhs: [0.0; 4] }
    }

    /// `A X + X B`, `a` of order `rows`, `b` of order `cols`.
    pub(crate) fn sylvester(
        rows: usize,
        cols: usize,
        a: impl Fn(usize, usize) -> f64,
        b: impl Fn(usize, usize) -> f64,
    ) -> Self {
        Self::new(rows, cols, |(i, j), (k, l)| {
            let left = if j == l { a(i, k) } else { 0.0 };
            let right = if i == k { b(l, j) } else { 0.0 };
            left + right
        })
    }

    /// `A X B - X`, `a` of order `rows`, `b` of order `cols`.
    pub(crate) fn stein(
        rows: usize,
        cols: usize,
        a: impl Fn(usize, usize) -> f64,
        b: impl Fn(usize, usize) -> f64,
    ) -> Self {
        Self::new(rows, cols, |(i, j), (k, l)| a(i, k) * b(l, j) - if (i, j) == (k, l) { 1.0 } else { 0.0 })
    }

    pub(crate) fn set_rhs(&mut self, i: usize, j: usize, value: f64) {
        self.rhs[j * self.rows + i] = value;
    }

    /// The solution, once [`Self::solve`] has run.
    pub(crate) fn x(&self, i: usize, j: usize) -> f64 {
        self.rhs[j * self.rows + i]
    }

    /// Replaces the right-hand side by the solution. Returns whether every pivot exceeded `smallest`.
    pub(crate) fn solve(&mut self, smallest: f64) -> bool {
        let n = self.order;
        let mut columns = [0, 1, 2, 3];
        let mut regular = true;
        for k in 0..n {
            let (mut pi, mut pj) = (k, k);
            for i in k..n {
                for j in k..n {
                    if self.m[i][j].abs() > self.m[pi][pj].abs() {
                        (pi, pj) = (i, j);
                    }
                }
            }
            self.m.swap(k, pi);
            self.rhs.swap(k, pi);
            for row in &mut self.m {
                row.swap(k, pj);
            }
            columns.swap(k, pj);
            if self.m[k][k].abs() <= smallest {
                regular = false;
                self.m[k][k] = smallest;
            }
            for i in k + 1..n {
                let factor = self.m[i][k] / self.m[k][k];
                for j in k + 1..n {
                    self.m[i][j] -= factor * self.m[k][j];
                }
                self.rhs[i] -= factor * self.rhs[k];
            }
        }
        for k in (0..n).rev() {
            let sum: f64 = (k + 1..n).map(|j| self.m[k][j] * self.rhs[j]).sum();
            self.rhs[k] = (self.rhs[k] - sum) / self.m[k][k];
        }
        let solved = self.rhs;
        for (k, &column) in columns.iter().enumerate().take(n) {
            self.rhs[column] = solved[k];
        }
        regular
    }
}
