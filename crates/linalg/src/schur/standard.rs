//! Standard form of a real 2 x 2 block: upper triangular if its eigenvalues are real, else equal diagonal entries and
//! off-diagonal entries of opposite sign (LAPACK dlanv2; Bai and Demmel, Linear Algebra Appl. 186, 1993).

/// `[a b; c d] = [cs -sn; sn cs] [a' b'; c' d'] [cs sn; -sn cs]`, the primed block in standard form.
#[derive(Debug, Clone, Copy)]
pub struct Standard {
    /// `[a' b'; c' d']`.
    pub block: [[f64; 2]; 2],
    /// Cosine of the rotation.
    pub cs: f64,
    /// Its sine.
    pub sn: f64,
}

/// Brings a 2 x 2 block into standard form.
pub fn standardise([[a, b], [c, d]]: [[f64; 2]; 2]) -> Standard {
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
        // Real, well-separated eigenvalues.
        let z = p + (scale.sqrt() * discriminant.sqrt()).copysign(p);
        let tau = c.hypot(z);
        return Standard { block: [[d + z, b - c], [0.0, d - larger / z * smaller]], cs: z / tau, sn: c / tau };
    }
    // Complex eigenvalues, or real ones that are nearly equal: first make the diagonal entries equal.
    // Only their ratio matters: far below the block's entries, half of the difference could be rounded to zero.
    let unit =
        if (b + c).abs().max(difference.abs()) < f64::MIN_POSITIVE / f64::EPSILON { 2f64.powi(200) } else { 1.0 };
    let (sigma, difference) = ((b + c) * unit, difference * unit);
    let p = 0.5 * difference;
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
    // The eigenvalues are real: one more rotation makes the block triangular.
    let (root_b, root_c) = (b.abs().sqrt(), c.abs().sqrt());
    let p = (root_b * root_c).copysign(c);
    let tau = 1.0 / (b + c).abs().sqrt();
    let (cs1, sn1) = (root_b * tau, root_c * tau);
    (cs, sn) = (cs * cs1 - sn * sn1, cs * sn1 + sn * cs1);
    Standard { block: [[mean + p, b - c], [0.0, mean - p]], cs, sn }
}

/// Rotates columns `j`, `j + 1` of `m`, rows `rows`.
#[inline(always)]
pub(super) fn rotate_cols(m: &mut [f64], ld: usize, j: usize, rows: core::ops::Range<usize>, cs: f64, sn: f64) {
    let (x, y) = m[j * ld..(j + 2) * ld].split_at_mut(ld);
    for (x, y) in x[rows.clone()].iter_mut().zip(&mut y[rows]) {
        (*x, *y) = (cs * *x + sn * *y, cs * *y - sn * *x);
    }
}

/// Rotates rows `i`, `i + 1` of `m`, columns `cols`.
#[inline(always)]
pub(super) fn rotate_rows(m: &mut [f64], ld: usize, i: usize, cols: core::ops::Range<usize>, cs: f64, sn: f64) {
    if cols.is_empty() {
        return;
    }
    for column in m[cols.start * ld..cols.end * ld].chunks_exact_mut(ld) {
        if let [x, y] = &mut column[i..i + 2] {
            (*x, *y) = (cs * *x + sn * *y, cs * *y - sn * *x);
        }
    }
}

/// Standardises the diagonal block of the matrix `t` of order `n` at `k`, `k + 1`, and applies the rotation to the rows
/// and columns of `t` in `within` and to `q`, of `rows` rows.
#[inline(always)]
pub(super) fn standardise_block(t: &mut [f64], n: usize, q: &mut [f64], rows: usize, k: usize, within: (usize, usize)) {
    let (x, y) = (k * n + k, (k + 1) * n + k);
    let found = standardise([[t[x], t[y]], [t[x + 1], t[y + 1]]]);
    rotate_rows(t, n, k, k + 2..within.1, found.cs, found.sn);
    rotate_cols(t, n, k, within.0..k, found.cs, found.sn);
    if rows > 0 {
        rotate_cols(q, rows, k, 0..rows, found.cs, found.sn);
    }
    [[t[x], t[y]], [t[x + 1], t[y + 1]]] = found.block;
}
