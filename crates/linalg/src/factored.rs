//! Lyapunov and Stein equations whose right-hand side is a Gram matrix, solved for the factor of the solution:
//! `P = U'U`.
//!
//! ```text
//! A'P + P A + C'C = 0,  A Hurwitz             the observability Gramian in continuous time
//! A'P A - P + C'C = 0,  A Schur stable        and in discrete time
//! ```
//! P itself is never formed: `U` has the square root of its condition, so that states which the output hardly sees
//! (`x'P x` below `eps ||P||`) keep their digits, and P is positive semidefinite by construction.
//!
//! Method: Hammarling (IMA J. Numer. Anal. 2, 1982) on the complex Schur form. Row by row of U: with `A = [l a; 0 A2]`,
//! `R = [r b; 0 R2]` (the factor of the right-hand side), `t^2 = -2 Re l` or `1 - |l|^2`, the first row `[r/t, u]` of U
//! solves a triangular system, and the rest is the same problem with R2 updated by one row. The complex factor becomes
//! real by one QR factorisation, of its real above its imaginary part.

use crate::argument::{RealMatrixView, finite, owned, square, unit_scale};
use crate::balance::Balance;
use crate::forward_error::relative;
use crate::schur_operator::{Kind, LOST};
use crate::separation::norm;
use crate::{LinalgError, Result, Schur, schur};
use nalgebra::{Complex, DMatrix};

/// A solution `P = U'U` by its factor.
#[derive(Debug, Clone, PartialEq)]
pub struct Factored {
    /// Upper triangular, n x n, its diagonal not negative.
    pub u: DMatrix<f64>,
    /// The residual of the equation for `P = U'U`, relative to the sum of the norms of its terms, in the Frobenius
    /// norm and, where units of the state are decades apart, in balanced ones.
    pub residual: f64,
}

impl Factored {
    /// `P = U'U`.
    pub fn p(&self) -> DMatrix<f64> {
        self.u.tr_mul(&self.u)
    }
}

/// Solves `A'P + P A + C'C = 0` for the factor U of `P = U'U`: the Cholesky factor of the observability Gramian.
///
/// `a` is n x n, all eigenvalues in the open left half plane; `c` is p x n. For the controllability Gramian
/// `A W + W A' + B B' = 0` give `A'` and `B'`. About 70 n^3 flops.
/// # Errors
/// [`LinalgError::NotStable`] names an eigenvalue with a nonnegative real part, or one as small as the rounding of the
/// eigenvalue: the solution would not be semidefinite, or out of reach. [`LinalgError::NotSquare`],
/// [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], those of [`schur()`](crate::schur()), and
/// [`LinalgError::Overflow`], also for entries near the ends of the range of binary64 with which the residual exceeds
/// 1e-10.
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// // The second state is hardly seen: P has the eigenvalue 2.5e-25, far below the rounding of its largest.
/// let (a, c) = (dmatrix![-1.0, 0.0; 0.0, -2.0], dmatrix![1.0, 0.0; 0.0, 1e-12]);
/// let factor = luenberger_linalg::lyapunov_factor(&a, &c)?;
/// println!("residual {:e}", factor.residual);
/// assert!((factor.u[(1, 1)] - 5e-13).abs() <= 1e-27);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
/// Source: Hammarling, IMA J. Numer. Anal. 2, 1982; SLICOT SB03OD.
pub fn lyapunov_factor<'a>(a: impl Into<RealMatrixView<'a>>, c: impl Into<RealMatrixView<'a>>) -> Result<Factored> {
    solve(Kind::Lyapunov, &owned(a), &owned(c))
}

/// Solves `A'P A - P + C'C = 0` for the factor U of `P = U'U`, all eigenvalues of A inside the unit circle. Otherwise
/// as [`lyapunov_factor`].
/// # Errors
/// As [`lyapunov_factor`].
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let factor = luenberger_linalg::stein_factor(&dmatrix![0.6], &dmatrix![0.8])?;
/// assert!((factor.u[(0, 0)] - 1.0).abs() <= 4.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn stein_factor<'a>(a: impl Into<RealMatrixView<'a>>, c: impl Into<RealMatrixView<'a>>) -> Result<Factored> {
    solve(Kind::Stein, &owned(a), &owned(c))
}

fn solve(kind: Kind, a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<Factored> {
    let n = square("A", a)?;
    if c.ncols() != n {
        return Err(LinalgError::DimensionMismatch { what: "C", expected: (c.nrows(), n), found: c.shape() });
    }
    finite("C", c)?;
    let balance = Balance::of_seen(a, c);
    let (mut a, mut c) = (a.clone(), c.clone());
    if let Some(balance) = &balance {
        (a, c) = (balance.similar(&a), balance.seen(&c));
    }
    // Time in units of an even power of two, so that its root, by which U is scaled back, is exact.
    let root = if kind == Kind::Lyapunov { even_root(unit_scale(&a)) } else { 1.0 };
    let units_c = unit_scale(&c);
    a *= root * root;
    c *= units_c;
    let form = schur(&a)?;
    if let Some(eigenvalue) = form.eigenvalues().into_iter().find(|&lambda| !is_stable(kind, lambda)) {
        return Err(LinalgError::NotStable { equation: kind.name(), eigenvalue: eigenvalue / (root * root) });
    }
    let (z, t) = complex_form(&form);
    let mut r = DMatrix::zeros(n, n);
    let seen = (c.map(|x| Complex::new(x, 0.0)) * &z).qr().unpack_r();
    r.view_mut((0, 0), seen.shape()).copy_from(&seen);
    let w = rows(kind, &t, r) * z.adjoint();
    let stacked = DMatrix::from_fn(2 * n, n, |i, j| if i < n { w[(i, j)].re } else { w[(i - n, j)].im });
    let mut u = stacked.qr().unpack_r();
    for i in 0..n {
        if u[(i, i)] < 0.0 {
            u.row_mut(i).neg_mut();
        }
    }
    let p = u.tr_mul(&u);
    let weight = c.tr_mul(&c);
    let defect = match kind {
        Kind::Lyapunov => &p * &a + a.tr_mul(&p) + &weight,
        Kind::Stein => a.tr_mul(&(&p * &a)) - &p + &weight,
    };
    let residual = relative(defect.norm(), kind.weight(a.norm()) * p.norm() + weight.norm());
    // Norms whose squares leave the range.
    let residual = if residual.is_finite() {
        residual
    } else {
        relative(norm(&defect), kind.weight(norm(&a)) * norm(&p) + norm(&weight))
    };
    // Back from balanced states: U D^-1 is triangular too.
    if let Some(balance) = &balance {
        u = balance.gain_back(&u);
    }
    u *= root;
    u /= units_c;
    if residual.is_nan() || residual > LOST || u.iter().any(|e| !e.is_finite()) {
        return Err(LinalgError::Overflow { what: "the factor u" });
    }
    Ok(Factored { u, residual })
}

/// Further from the boundary than the rounding of the eigenvalue itself: what is nearer has no damping that could be
/// divided by.
fn is_stable(kind: Kind, lambda: Complex<f64>) -> bool {
    match kind {
        Kind::Lyapunov => -lambda.re > f64::EPSILON * lambda.norm(),
        Kind::Stein => 1.0 - lambda.norm() > f64::EPSILON,
    }
}

/// The root of the largest even power of two not above the given power of two.
fn even_root(power: f64) -> f64 {
    2.0_f64.powi((power.log2() as i32).div_euclid(2))
}

/// The complex Schur form `A = Z T Z^H` by one rotation for each 2 x 2 block.
fn complex_form(form: &Schur) -> (DMatrix<Complex<f64>>, DMatrix<Complex<f64>>) {
    let n = form.t.nrows();
    let mut z = form.q.map(|x| Complex::new(x, 0.0));
    let mut t = form.t.map(|x| Complex::new(x, 0.0));
    for m in (1..n).rev() {
        let below = form.t[(m, m - 1)];
        if below == 0.0 {
            continue;
        }
        // Of the standardised block: lambda - t_mm is imaginary.
        let shift = form.t[(m - 1, m)].abs().sqrt() * below.abs().sqrt();
        let norm = shift.hypot(below);
        let (c, s) = (Complex::new(0.0, shift / norm), below / norm);
        for j in m - 1..n {
            let (x, y) = (t[(m - 1, j)], t[(m, j)]);
            t[(m - 1, j)] = c.conj() * x + y * s;
            t[(m, j)] = c * y - x * s;
        }
        for (matrix, rows) in [(&mut t, m + 1), (&mut z, n)] {
            for i in 0..rows {
                let (x, y) = (matrix[(i, m - 1)], matrix[(i, m)]);
                matrix[(i, m - 1)] = c * x + y * s;
                matrix[(i, m)] = c.conj() * y - x * s;
            }
        }
        t[(m, m - 1)] = Complex::new(0.0, 0.0);
    }
    (z, t)
}

/// The upper triangular U of the equation with the triangular T and the factor R of the right-hand side, which is used
/// up.
fn rows(kind: Kind, t: &DMatrix<Complex<f64>>, mut r: DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
    let n = t.nrows();
    let mut u = DMatrix::zeros(n, n);
    for k in 0..n {
        let lambda = t[(k, k)];
        // Positive: the eigenvalue is stable. `1 - |l|^2` without cancellation of the squares.
        let tau = match kind {
            Kind::Lyapunov => (-2.0 * lambda.re).sqrt(),
            Kind::Stein => ((1.0 - lambda.norm()) * (1.0 + lambda.norm())).sqrt(),
        };
        let size = r[(k, k)].norm();
        let phase = if size > 0.0 { r[(k, k)].conj() / size } else { Complex::new(1.0, 0.0) };
        let corner = size / tau;
        u[(k, k)] = Complex::new(corner, 0.0);
        let mut update = Vec::with_capacity(n - k - 1);
        for j in k + 1..n {
            let b = r[(k, j)] * phase;
            // The part of u T2 that is known already.
            let known: Complex<f64> = (k + 1..j).map(|l| u[(k, l)] * t[(l, j)]).sum();
            let coupled = t[(k, j)] * corner + known;
            let (entry, row) = match kind {
                // u (T2 + conj(l) I) = -corner a - tau b, and the new row b - tau u.
                Kind::Lyapunov => {
                    let entry = -(coupled + b * tau) / (t[(j, j)] + lambda.conj());
                    (entry, b - entry * tau)
                }
                // u = conj(l) v + tau b with v = corner a + u T2, and the new row tau v - l b.
                Kind::Stein => {
                    let entry =
                        (lambda.conj() * coupled + b * tau) / (Complex::new(1.0, 0.0) - lambda.conj() * t[(j, j)]);
                    (entry, (coupled + entry * t[(j, j)]) * tau - lambda * b)
                }
            };
            u[(k, j)] = entry;
            update.push(row);
        }
        add_row(&mut r, k + 1, update);
    }
    u
}

/// The triangular factor of `[R2; y]` in place of R2, which starts at `first`.
fn add_row(r: &mut DMatrix<Complex<f64>>, first: usize, mut y: Vec<Complex<f64>>) {
    let n = r.nrows();
    for i in first..n {
        let (x, z) = (r[(i, i)], y[i - first]);
        let norm = x.norm().hypot(z.norm());
        if norm == 0.0 {
            continue;
        }
        let (c, s) = (x.conj() / norm, z.conj() / norm);
        for j in i..n {
            let (x, z) = (r[(i, j)], y[j - first]);
            r[(i, j)] = c * x + s * z;
            y[j - first] = c.conj() * z - s.conj() * x;
        }
    }
}
