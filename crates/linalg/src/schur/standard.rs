//! Standard form of a real 2 x 2 block: upper triangular if its eigenvalues are real, else equal diagonal entries and
//! off-diagonal entries of opposite sign (LAPACK dlanv2; Bai and Demmel, Linear Algebra Appl. 186, 1993).

use nalgebra::DMatrix;

/// `[a b; c d] = [cs -sn; sn cs] [a' b'; c' d'] [cs sn; -sn cs]`, the primed block in standard form.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Standard {
    pub(crate) block: [[f64; 2]; 2],
    pub(crate) cs: f64,
    pub(crate) sn: f64,
}

/// Brings a 2 x 2 block into standard form.
pub(crate) fn standardise([[a, b], [c, d]]: [[f64; 2]; 2]) -> Standard {
    if c == 0.0 {
        return Standard { block: [[a, b], [0.0, d]], cs: 1.0, sn: 0.0 };
    }
    if b == 0.0 {
        return Standard { block: [[d, -c], [0.0, a]], cs: 0.0, sn: 1.0 };
    }
    if a == d && (b > 0.0) != (c > 0.0) {
        return Standard { block: [[a, b], [c, d]], cs: 1.0, sn: 0.0 };
    }
    let difference = a - d;
    let p = 0.5 * difference;
    let larger = b.abs().max(c.abs());
    let smaller = b.abs().min(c.abs()) * b.signum() * c.signum();
    let scale = p.abs().max(larger);
    let discriminant = p / scale * p + larger / scale * smaller;
    if discriminant >= 4.0 * f64::EPSILON * scale {
        // Real eigenvalues, well apart.
        let z = p + (scale.sqrt() * discriminant.sqrt()).copysign(p);
        let tau = c.hypot(z);
        return Standard { block: [[d + z, b - c], [0.0, d - larger / z * smaller]], cs: z / tau, sn: c / tau };
    }
    // Complex eigenvalues, or real ones that are nearly equal: first make the diagonal entries equal.
    let sigma = b + c;
    let tau = sigma.hypot(difference);
    let mut cs = (0.5 * (1.0 + sigma.abs() / tau)).sqrt();
    let mut sn = -(p / (tau * cs)).copysign(p * sigma);
    if p == 0.0 {
        sn = 0.0;
    }
    let (aa, bb, cc, dd) = (a * cs + b * sn, -a * sn + b * cs, c * cs + d * sn, -c * sn + d * cs);
    let (a, b, c, d) = (aa * cs + cc * sn, bb * cs + dd * sn, -aa * sn + cc * cs, -bb * sn + dd * cs);
    let mean = 0.5 * (a + d);
    if c == 0.0 {
        return Standard { block: [[mean, b], [0.0, mean]], cs, sn };
    }
    if b == 0.0 {
        return Standard { block: [[mean, -c], [0.0, mean]], cs: -sn, sn: cs };
    }
    if (b > 0.0) != (c > 0.0) {
        return Standard { block: [[mean, b], [c, mean]], cs, sn };
    }
    // Real after all: one more rotation makes it triangular.
    let (root_b, root_c) = (b.abs().sqrt(), c.abs().sqrt());
    let p = (root_b * root_c).copysign(c);
    let tau = 1.0 / (b + c).abs().sqrt();
    let (cs1, sn1) = (root_b * tau, root_c * tau);
    (cs, sn) = (cs * cs1 - sn * sn1, cs * sn1 + sn * cs1);
    Standard { block: [[mean + p, b - c], [0.0, mean - p]], cs, sn }
}

/// Rotates columns `j`, `j + 1` of `m`, rows `0..rows`.
pub(crate) fn rotate_cols(m: &mut DMatrix<f64>, j: usize, rows: usize, cs: f64, sn: f64) {
    let n = m.nrows();
    let (x, y) = m.as_mut_slice()[j * n..(j + 2) * n].split_at_mut(n);
    for (x, y) in x[..rows].iter_mut().zip(&mut y[..rows]) {
        (*x, *y) = (cs * *x + sn * *y, cs * *y - sn * *x);
    }
}

/// Rotates rows `i`, `i + 1` of `m`, columns from `col` on.
pub(crate) fn rotate_rows(m: &mut DMatrix<f64>, i: usize, col: usize, cs: f64, sn: f64) {
    for j in col..m.ncols() {
        let (x, y) = (m[(i, j)], m[(i + 1, j)]);
        m[(i, j)] = cs * x + sn * y;
        m[(i + 1, j)] = cs * y - sn * x;
    }
}

/// Standardises the diagonal block of `t` at `k`, `k + 1`, and carries the rotation through `t` and `q`.
pub(crate) fn standardise_block(t: &mut DMatrix<f64>, q: &mut DMatrix<f64>, k: usize) {
    let found = standardise([[t[(k, k)], t[(k, k + 1)]], [t[(k + 1, k)], t[(k + 1, k + 1)]]]);
    rotate_rows(t, k, k + 2, found.cs, found.sn);
    rotate_cols(t, k, k, found.cs, found.sn);
    let rows = q.nrows();
    rotate_cols(q, k, rows, found.cs, found.sn);
    for i in 0..2 {
        for j in 0..2 {
            t[(k + i, k + j)] = found.block[i][j];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
        /// Every real 2 x 2 matrix, small integers included (equal and opposite entries), has a standard form that
        /// rotates back to it.
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
    fn nearly_equal_real_eigenvalues_are_split() {
        let s = standardise([[1.0, 1.0], [1e-20, 1.0]]);
        assert_eq!(s.block[1][0], 0.0);
        assert!((s.block[0][0] - s.block[1][1] - 2e-10).abs() <= 4.0 * f64::EPSILON);
    }
}
