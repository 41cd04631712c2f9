//! The standard form of blocks of order two.

use luenberger_linalg::internals::{Standard, standardise};
use proptest::prelude::*;

fn is_standard(m: [[f64; 2]; 2]) -> bool {
    let [[a, b], [c, d]] = m;
    c == 0.0 || (a == d && b * c.signum() < 0.0)
}

fn rebuilt(s: Standard) -> [[f64; 2]; 2] {
    let Standard { block: [[a, b], [c, d]], cs, sn } = s;
    let (l, r) = ([[cs, -sn], [sn, cs]], [[cs, sn], [-sn, cs]]);
    let m = [
        [l[0][0] * a + l[0][1] * c, l[0][0] * b + l[0][1] * d],
        [l[1][0] * a + l[1][1] * c, l[1][0] * b + l[1][1] * d],
    ];
    [
        [m[0][0] * r[0][0] + m[0][1] * r[1][0], m[0][0] * r[0][1] + m[0][1] * r[1][1]],
        [m[1][0] * r[0][0] + m[1][1] * r[1][0], m[1][0] * r[0][1] + m[1][1] * r[1][1]],
    ]
}

proptest! {
    /// Every real 2 x 2 matrix has a standard form that rotates back to it; small integers give equal and opposite
    /// entries.
    #[test]
    fn the_standard_form_is_a_rotation_away(
        m in prop_oneof![
            prop::array::uniform4(-10.0..10.0_f64),
            prop::array::uniform4((-2..=2_i32).prop_map(f64::from)),
            prop::array::uniform4((-1.0..1.0_f64, -150..150_i32).prop_map(|(x, e)| x * 10.0_f64.powi(e))),
        ]
    ) {
        let block = [[m[0], m[1]], [m[2], m[3]]];
        let s = standardise(block);
        prop_assert!(is_standard(s.block), "{s:?}");
        let bound = 16.0 * f64::EPSILON * m.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
        let back = rebuilt(s);
        for i in 0..2 {
            for j in 0..2 {
                prop_assert!((back[i][j] - block[i][j]).abs() <= bound, "{s:?} {back:?}");
            }
        }
    }
}

#[test]
fn a_difference_below_the_normal_numbers_is_seen() {
    for tiny in [5e-324, -5e-324, 3e-320, f64::MIN_POSITIVE] {
        for block in [[[tiny, -1.0], [1.0, 0.0]], [[0.0, 2.0], [-2.0, tiny]], [[tiny, 1.0], [-1.0 - 1e-16, 0.0]]] {
            let s = standardise(block);
            assert!(is_standard(s.block) && (s.cs.hypot(s.sn) - 1.0).abs() <= 4.0 * f64::EPSILON, "{s:?}");
        }
    }
}

#[test]
fn nearly_equal_real_eigenvalues_are_split() {
    let s = standardise([[1.0, 1.0], [1e-20, 1.0]]);
    assert_eq!(s.block[1][0], 0.0);
    assert!((s.block[0][0] - s.block[1][1] - 2e-10).abs() <= 4.0 * f64::EPSILON);
}
