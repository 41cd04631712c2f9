//! Equations between two diagonal blocks, of order one to four: the innermost step of a substitution.
//!
//! A block in standard form, `[a b; c a]` with `b c < 0`, is `D (a I + w J) D^-1` with `D = diag(1, d)`,
//! `d = sqrt(-c/b)`, `w = sqrt(-b c)` (with the sign of b) and `J = [0 1; -1 0]`, `J^2 = -I`. A matrix of order two is
//! the sum of one that commutes with J, `x I + y J`, and one that anticommutes, `x K + y L`, with `K = diag(1, -1)` and
//! `L = [0 1; 1 0]`. So an equation between two such blocks splits into two complex divisions; for the Sylvester
//! equation the divisors are `lambda + mu` and `lambda + conj(mu)`. The divisions are accurate to a few units in the
//! last place. Only the scaling D may lose accuracy; if it is far from one, the system of order four is solved with
//! complete pivoting.

use super::{Equation, Sizes};
use crate::linear_block::LinearBlock;

/// Largest product of the scalings of two blocks for which the divisions are used: the possible growth of a residual.
const STRETCH: f64 = 32.0;

/// A diagonal block of a quasi-triangular matrix.
#[derive(Debug, Clone, Copy, Default)]
pub struct Block {
    pub(super) start: usize,
    /// Its order, 1 or 2.
    pub size: usize,
    /// Entries by rows; a block of order one is `m[0][0]`.
    pub m: [[f64; 2]; 2],
    /// Eigenvalue `a + i w`: `re = a`, `im = w`.
    re: f64,
    im: f64,
    /// `d`, `1/d`, and the larger of the two; `stretch` is infinite for a block that is not in standard form.
    d: f64,
    inverse: f64,
    stretch: f64,
    /// Largest entry.
    pub largest: f64,
}

impl Block {
    /// The block of order one.
    #[inline(always)]
    pub fn one(start: usize, a: f64) -> Self {
        let m = [[a, 0.0], [0.0; 2]];
        Self { start, size: 1, m, re: a, im: 0.0, d: 1.0, inverse: 1.0, stretch: 1.0, largest: a.abs() }
    }

    /// The block of order two.
    #[inline(always)]
    pub fn two(start: usize, m: [[f64; 2]; 2]) -> Self {
        let [[a, b], [c, e]] = m;
        let (root_b, root_c) = (b.abs().sqrt(), c.abs().sqrt());
        let (d, inverse) = (root_c / root_b, root_b / root_c);
        let standard = a == e && (b > 0.0) != (c > 0.0);
        let stretch = if standard { d.max(inverse) } else { f64::INFINITY };
        let largest = a.abs().max(e.abs()).max(b.abs()).max(c.abs());
        Self { start, size: 2, m, re: a, im: (root_b * root_c).copysign(b), d, inverse, stretch, largest }
    }

    #[inline(always)]
    pub(super) fn transposed(self) -> Self {
        let [[a, b], [c, e]] = self.m;
        Self { m: [[a, c], [b, e]], im: -self.im, d: self.inverse, inverse: self.d, ..self }
    }
}

/// `z / p`, with `p` raised to the floor if it is not larger; and whether it is larger.
#[inline(always)]
fn quotient(z: [f64; 2], p: [f64; 2], floor: f64) -> ([f64; 2], bool) {
    let larger = p[0].abs().max(p[1].abs());
    if larger <= floor {
        return (z.map(|e| e / floor), false);
    }
    let square = p[0] * p[0] + p[1] * p[1];
    if !(1e-280..1e280).contains(&square) {
        // Scaled, so that the squares neither underflow nor overflow.
        let p = p.map(|e| e / larger);
        let square = p[0] * p[0] + p[1] * p[1];
        let z = z.map(|e| e / larger);
        return ([(z[0] * p[0] + z[1] * p[1]) / square, (z[1] * p[0] - z[0] * p[1]) / square], true);
    }
    let inverse = 1.0 / square;
    ([(z[0] * p[0] + z[1] * p[1]) * inverse, (z[1] * p[0] - z[0] * p[1]) * inverse], true)
}

/// The unknowns `x[column][row]` of one pair of blocks, `l` on the left and `r` on the right; and whether every divisor
/// exceeds the rounding level.
#[inline(always)]
pub fn solve(equation: Equation, l: &Block, r: &Block, rhs: [[f64; 2]; 2], sizes: Sizes) -> ([[f64; 2]; 2], bool) {
    let floor = sizes.floor(equation, l.largest, r.largest);
    // With lambda = a + i u, mu = b + i v.
    let (a, u, b, v) = (l.re, l.im, r.re, r.im);
    if l.size == 1 && r.size == 1 {
        let pivot = match equation {
            Equation::Sylvester => a + b,
            Equation::Stein => a * b - 1.0,
        };
        let regular = pivot.abs() > floor;
        // The reciprocal does not depend on the right-hand side.
        let inverse = 1.0 / if regular { pivot } else { floor };
        return ([[rhs[0][0] * inverse, 0.0], [0.0; 2]], regular);
    }
    if l.stretch * r.stretch > STRETCH {
        return eliminate(equation, l, r, rhs, floor);
    }
    if l.size == 1 {
        let p = match equation {
            Equation::Sylvester => [a + b, v],
            Equation::Stein => [a * b - 1.0, a * v],
        };
        let (z, regular) = quotient([rhs[0][0], rhs[1][0] * r.d], p, floor);
        return ([[z[0], 0.0], [z[1] * r.inverse, 0.0]], regular);
    }
    if r.size == 1 {
        let p = match equation {
            Equation::Sylvester => [a + b, u],
            Equation::Stein => [a * b - 1.0, u * b],
        };
        let (z, regular) = quotient([rhs[0][1] * l.inverse, rhs[0][0]], p, floor);
        return ([[z[1], z[0] * l.d], [0.0; 2]], regular);
    }
    // Scaled by D, both blocks are normal matrices.
    let (r11, r12, r21, r22) = (rhs[0][0], rhs[1][0] * r.d, rhs[0][1] * l.inverse, rhs[1][1] * (r.d * l.inverse));
    let (commuting, anticommuting) = match equation {
        Equation::Sylvester => ([a + b, u + v], [a + b, u - v]),
        Equation::Stein => ([a * b - u * v - 1.0, a * v + u * b], [a * b + u * v - 1.0, u * b - a * v]),
    };
    let (x, one) = quotient([0.5 * (r11 + r22), 0.5 * (r12 - r21)], commuting, floor);
    let (y, other) = quotient([0.5 * (r12 + r21), 0.5 * (r11 - r22)], anticommuting, floor);
    let (x11, x22, x12, x21) = (x[0] + y[1], x[0] - y[1], y[0] + x[1], y[0] - x[1]);
    ([[x11, x21 * l.d], [x12 * r.inverse, x22 * (l.d * r.inverse)]], one && other)
}

/// The same by Gaussian elimination.
#[cold]
pub fn eliminate(equation: Equation, l: &Block, r: &Block, rhs: [[f64; 2]; 2], floor: f64) -> ([[f64; 2]; 2], bool) {
    let (left, right) = (|i: usize, k: usize| l.m[i][k], |k: usize, j: usize| r.m[k][j]);
    let mut system = match equation {
        Equation::Sylvester => LinearBlock::sylvester(l.size, r.size, left, right),
        Equation::Stein => LinearBlock::stein(l.size, r.size, left, right),
    };
    for (j, column) in rhs.iter().enumerate().take(r.size) {
        for (i, &entry) in column.iter().enumerate().take(l.size) {
            system.set_rhs(i, j, entry);
        }
    }
    let regular = system.solve(floor);
    let mut x = [[0.0; 2]; 2];
    for (j, column) in x.iter_mut().enumerate().take(r.size) {
        for (i, entry) in column.iter_mut().enumerate().take(l.size) {
            *entry = system.x(i, j);
        }
    }
    (x, regular)
}
