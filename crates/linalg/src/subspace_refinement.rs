//! Refinement of the unobservable subspace to working accuracy: Newton's method for the last columns of a staircase.
//!
//! A small stair amplifies the rounding errors of the stairs before it; a small stair taken as zero gives the subspace
//! an error of its size. Let `Q = [W V]` be the orthogonal matrix of the staircase, V its last columns, and
//! ```text
//! Q'A Q = [A11 A12]    C Q = [C1 C2],    V+ = V + W Z,
//!         [A21 A22]
//! V+ spans an unobservable invariant subspace iff `A11 Z - Z A22 = -A12 + Z A21 Z` and `C1 Z = -C2`. Without the
//! quadratic term this is linear, and its solution converges quadratically (Stewart, SIAM Review 15, 1973; Demmel,
//! Computing 38, 1987). The Sylvester equation alone is singular if A11 and A22 share an eigenvalue; with the rows of C
//! it has full column rank, because the pair (A11, C1) is observable. It is solved by least squares, column by column
//! along the Schur form of A22: `4 k r^3` flops for k columns and rank r.

use nalgebra::{DMatrix, QR};

use crate::Result;
use crate::schur::schur;
use crate::staircase::Staircase;

/// Newton steps: one for the error of about 1e-8 of a stair taken as zero, another for an ill-conditioned subspace.
const STEPS: usize = 3;

/// Refines the last columns of `staircase.q`, the staircase of `(A', C')`, until `[A V - V (V'A V); C V]` is at most
/// `n eps size`, or a step brings no improvement.
///
/// # Errors
/// Those of [`schur()`].
pub fn refine(staircase: &mut Staircase, a: &DMatrix<f64>, c: &DMatrix<f64>, size: f64) -> Result<()> {
    let (n, r) = (a.nrows(), staircase.rank);
    if r == 0 || r == n {
        return Ok(());
    }
    let mut seen = Split::new(a, c, &staircase.q, r);
    for _ in 0..STEPS {
        if seen.residual() <= n as f64 * f64::EPSILON * size {
            return Ok(());
        }
        let Some(z) = seen.step()? else { return Ok(()) };
        let (w, v) = (staircase.q.columns(0, r), staircase.q.columns(r, n - r));
        // The two groups of columns are orthogonal to each other, so QR orthogonalises each separately.
        let mut moved = DMatrix::zeros(n, n);
        moved.columns_mut(0, n - r).copy_from(&(v + w * &z));
        moved.columns_mut(n - r, r).copy_from(&(w - v * z.transpose()));
        let basis = QR::new(moved).q();
        let mut q = DMatrix::zeros(n, n);
        q.columns_mut(0, r).copy_from(&basis.columns(n - r, r));
        q.columns_mut(r, n - r).copy_from(&basis.columns(0, n - r));
        let next = Split::new(a, c, &q, r);
        let gained = next.residual() < 0.5 * seen.residual();
        if !gained {
            return Ok(());
        }
        staircase.f = q.transpose() * a.transpose() * &q;
        staircase.f.view_mut((r, 0), (n - r, r)).fill(0.0);
        staircase.g = q.transpose() * c.transpose();
        staircase.g.rows_mut(r, n - r).fill(0.0);
        staircase.q = q;
        seen = next;
    }
    Ok(())
}

/// The pair `(A, C)` in the coordinates of Q.
struct Split {
    a11: DMatrix<f64>,
    a12: DMatrix<f64>,
    a22: DMatrix<f64>,
    c1: DMatrix<f64>,
    c2: DMatrix<f64>,
}

impl Split {
    fn new(a: &DMatrix<f64>, c: &DMatrix<f64>, q: &DMatrix<f64>, r: usize) -> Self {
        let n = a.nrows();
        let (w, v) = (q.columns(0, r), q.columns(r, n - r));
        let (aw, av) = (a * w, a * v);
        Self { a11: w.transpose() * aw, a12: w.transpose() * &av, a22: v.transpose() * av, c1: c * w, c2: c * v }
    }

    fn residual(&self) -> f64 {
        self.a12.norm().hypot(self.c2.norm())
    }

    /// Least-squares solution of `A11 Z - Z A22 = -A12`, `C1 Z = -C2`; `None` if it is not finite.
    fn step(&self) -> Result<Option<DMatrix<f64>>> {
        let (r, k, p) = (self.a11.nrows(), self.a22.nrows(), self.c1.nrows());
        let form = schur(&self.a22)?;
        let (t, right, seen) = (&form.t, -(&self.a12 * &form.q), -(&self.c2 * &form.q));
        let mut z = DMatrix::zeros(r, k);
        let mut j = 0;
        while j < k {
            let width = if j + 1 < k && t[(j + 1, j)] != 0.0 { 2 } else { 1 };
            let known = right.columns(j, width) + z.columns(0, j) * t.view((0, j), (j, width));
            let (rows, columns) = (width * (r + p), width * r);
            let mut m = DMatrix::zeros(rows, columns);
            let mut b = DMatrix::zeros(rows, 1);
            for s in 0..width {
                for q in 0..width {
                    let mut block = m.view_mut((s * (r + p), q * r), (r, r));
                    if s == q {
                        block.copy_from(&self.a11);
                    }
                    for i in 0..r {
                        block[(i, i)] -= t[(j + q, j + s)];
                    }
                }
                m.view_mut((s * (r + p) + r, s * r), (p, r)).copy_from(&self.c1);
                b.view_mut((s * (r + p), 0), (r, 1)).copy_from(&known.column(s));
                b.view_mut((s * (r + p) + r, 0), (p, 1)).copy_from(&seen.column(j + s));
            }
            let qr = QR::new(m);
            let Some(x) = qr.r().solve_upper_triangular(&(qr.q().transpose() * b)) else { return Ok(None) };
            for s in 0..width {
                z.view_mut((0, j + s), (r, 1)).copy_from(&x.view((s * r, 0), (r, 1)));
            }
            j += width;
        }
        let z = z * form.q.transpose();
        Ok(z.iter().all(|x: &f64| x.is_finite()).then_some(z))
    }
}
