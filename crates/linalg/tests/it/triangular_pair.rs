//! Equations between diagonal blocks of order one and two.

use luenberger_linalg::internals::{Block, Equation, Sizes, eliminate, solve_pair};
use proptest::prelude::*;

/// How far divisions may let a residual grow, for scalings of the blocks for which they are used at all.
const STRETCH: f64 = 32.0;

fn block() -> impl Strategy<Value = Block> {
    let one = (-2.0..-0.5_f64).prop_map(|a| Block::one(0, 0.4 * a));
    let two = (-2.0..-0.5_f64, 0.1..2.0_f64, -2.0..2.0_f64, any::<bool>()).prop_map(|(a, w, e, up)| {
        let (b, c) = (0.4 * w * e.exp(), -0.4 * w / e.exp());
        Block::two(0, [[0.4 * a, if up { b } else { c }], [if up { c } else { b }, 0.4 * a]])
    });
    prop_oneof![one, two]
}

proptest! {
    /// Divisions and elimination agree within their rounding errors. The real parts of the eigenvalues are below
    /// -0.2 and their moduli below 1.2, so the divisors of the Sylvester equation are at least 0.4. The Stein
    /// equation may be nearly singular; its solutions are compared by their residuals.
    #[test]
    fn divisions_do_what_elimination_does(l in block(), r in block(), rhs in prop::array::uniform4(-1.0..1.0_f64)) {
        let rhs = [[rhs[0], rhs[1]], [rhs[2], rhs[3]]];
        let sizes = Sizes { s: l.largest, t: r.largest, exact: false };
        for equation in [Equation::Sylvester, Equation::Stein] {
            let (x, regular) = solve_pair(equation, &l, &r, rhs, sizes);
            let (y, _) = eliminate(equation, &l, &r, rhs, sizes.floor(equation, l.largest, r.largest));
            prop_assert!(regular);
            let left = |x: [[f64; 2]; 2], i: usize, j: usize| (0..l.size).map(|k| l.m[i][k] * x[j][k]).sum::<f64>();
            for (j, column) in rhs.iter().enumerate().take(r.size) {
                for (i, entry) in column.iter().enumerate().take(l.size) {
                    let defect = |x: [[f64; 2]; 2]| {
                        let through = (0..r.size).map(|k| r.m[k][j] * match equation {
                            Equation::Sylvester => x[k][i],
                            Equation::Stein => left(x, i, k),
                        }).sum::<f64>();
                        match equation {
                            Equation::Sylvester => left(x, i, j) + through - entry,
                            Equation::Stein => through - x[j][i] - entry,
                        }
                    };
                    let size = x.iter().chain(&y).flatten().fold(1.0_f64, |m, e| m.max(e.abs()));
                    let terms = 1.0 + (l.largest + r.largest).max(1.0 + l.largest * r.largest) * size;
                    prop_assert!(defect(x).abs() <= 8.0 * STRETCH * f64::EPSILON * terms, "{l:?} {r:?} {}", defect(x));
                    prop_assert!(defect(y).abs() <= 16.0 * f64::EPSILON * terms);
                    if equation == Equation::Sylvester {
                        prop_assert!((x[j][i] - y[j][i]).abs() <= 1e3 * f64::EPSILON * STRETCH * size);
                    }
                }
            }
        }
    }
}

/// The divisions are scale invariant: data scaled by a power of two give the scaled solution.
#[test]
fn the_ends_of_the_range_change_nothing() {
    let unit = Block::two(0, [[-1.0, 2.0], [-0.5, -1.0]]);
    let rhs = [[1.0, 0.25], [-0.5, 2.0]];
    let (x, _) = solve_pair(Equation::Sylvester, &unit, &unit, rhs, Sizes { s: 2.0, t: 2.0, exact: false });
    for exponent in [-480, 480] {
        let scale = 2.0_f64.powi(exponent);
        let block = Block::two(0, [[-scale, 2.0 * scale], [-0.5 * scale, -scale]]);
        let sizes = Sizes { s: 2.0 * scale, t: 2.0 * scale, exact: false };
        let (y, regular) = solve_pair(Equation::Sylvester, &block, &block, rhs, sizes);
        assert!(regular);
        for (x, y) in x.iter().flatten().zip(y.iter().flatten()) {
            assert!((x - y * scale).abs() <= 8.0 * f64::EPSILON, "{exponent} {x} {}", y * scale);
        }
    }
}
