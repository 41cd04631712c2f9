//! Real Schur form `A = Q T Q'`: `Q` orthogonal, `T` upper quasi-triangular.
//!
//! `T` has 1 x 1 diagonal blocks for the real eigenvalues of `A` and standardised 2 x 2 blocks (equal diagonal entries,
//! off-diagonal entries of opposite sign) for the complex pairs. It exists for every real matrix. All dense equations
//! of this crate are solved with it.
//!
//! Method: Householder reduction to Hessenberg form (`hessenberg.rs`). Up to order 75 follows the implicit double-shift
//! QR iteration of Francis (`francis.rs`; up to order 8 on the stack, `small.rs`); for larger orders the small-bulge
//! multishift iteration (`multishift.rs`) with aggressive early deflation (`deflation.rs`) of Braman, Byers and
//! Mathias. Its bulges are chased near the diagonal (`bulge.rs`), and their chains of reflectors are applied to the
//! rest afterwards (`chain.rs`). Exceptional shifts break cycles, and the number of sweeps is bounded. About 25 n^3
//! flops for n small, and fewer than 15 n^3 for n large.
//!
//! Selected eigenvalues are moved to the top by exchanges of neighbouring blocks (`swap.rs`, `reorder.rs`), with the
//! condition of their invariant subspace (`subspace.rs`). Balancing (`balancing.rs`) is an option for eigenvalues and
//! not part of the Schur form.

mod balancing;
mod bulge;
mod chain;
mod deflation;
mod francis;
pub(crate) mod hessenberg;
mod multishift;
mod reorder;
mod small;
pub(crate) mod standard;
mod subspace;
mod swap;

pub use balancing::{Balanced, balanced};
pub use subspace::Reordered;

use crate::argument::{RealMatrixView, owned, square, unit_scale};
use crate::kernel;
use crate::{LinalgError, Result};
use nalgebra::{Complex, DMatrix};

/// `A = Q T Q'`.
#[derive(Debug, Clone, PartialEq)]
pub struct Schur {
    /// Orthogonal; its first k columns span an invariant subspace of `A` wherever `T` has a zero below entry (k, k).
    pub q: DMatrix<f64>,
    /// Upper quasi-triangular, its 2 x 2 blocks in standard form. Entries below the blocks are exactly zero.
    pub t: DMatrix<f64>,
}

/// Real Schur form `A = Q T Q'` of a square matrix.
///
/// Backward stable: `||A - Q T Q'||` (relative to `||A||`) and `||Q'Q - I||` are a small multiple of `n eps`. Entries
/// of any size are allowed; a matrix whose largest entry is beyond 2^+-300 is scaled by a power of two for the
/// computation. A matrix of order zero has the Schur form of order zero. About 25 n^3 flops for n small, fewer than 15
/// n^3 for n large, on one thread.
///
/// # Errors
/// [`LinalgError::NotSquare`], [`LinalgError::NotFinite`]; [`LinalgError::NotConverged`] after 30 n sweeps (no such
/// case is known); [`LinalgError::Overflow`] if an eigenvalue is beyond the range of binary64.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let a = dmatrix![0.0, -1.0, 0.0; -3.0, -3.0, 1.0; 0.0, 3.0, 0.0];
/// let schur = luenberger_linalg::schur(&a)?;
/// let residual = (&schur.q * &schur.t * schur.q.transpose() - &a).norm() / a.norm();
/// println!("{residual:e}");
/// assert!(residual <= 10.0 * 3.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Braman, Byers and Mathias, SIAM J. Matrix Anal. Appl. 23, 2002, parts I and II; Byers, LAPACK Working Note
/// 187, 2007; Golub and Van Loan, Matrix Computations, 4th ed., 7.5; LAPACK dlahqr, dlaqr0, dlanv2.
pub fn schur<'a>(a: impl Into<RealMatrixView<'a>>) -> Result<Schur> {
    real_form(&owned(a))
}

fn real_form(a: &DMatrix<f64>) -> Result<Schur> {
    let mut found = Schur::default();
    schur_into(a, &mut found, &mut SchurWorkspace::new())?;
    Ok(found)
}

/// [`schur()`] into an existing factorisation and workspace: from the second call of the same order on, no memory is
/// allocated.
///
/// After an error the content of `into` is undefined.
///
/// # Errors
/// Those of [`schur()`].
///
/// # Example
/// ```
/// use luenberger_linalg::{Schur, SchurWorkspace, schur_into};
/// use nalgebra::dmatrix;
/// let (mut found, mut workspace) = (Schur::default(), SchurWorkspace::new());
/// for gain in [1.0, 2.0, 4.0] {
///     let a = dmatrix![0.0, 1.0; -gain, -1.0];
///     schur_into(&a, &mut found, &mut workspace)?;
///     let residual = (&found.q * &found.t * found.q.transpose() - &a).norm() / a.norm();
///     println!("{residual:e}");
///     assert!(residual <= 10.0 * 2.0 * f64::EPSILON);
/// }
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn schur_into(a: &DMatrix<f64>, into: &mut Schur, workspace: &mut SchurWorkspace) -> Result<()> {
    let n = a.nrows();
    if into.q.shape() != (n, n) {
        into.q = DMatrix::zeros(n, n);
    }
    factor_into(a, into, workspace)
}

/// [`schur()`] without Q (a Q of order zero).
///
/// # Errors
/// Those of [`schur()`].
#[doc(hidden)]
pub fn triangular_factor(a: &DMatrix<f64>) -> Result<Schur> {
    let mut found = Schur::default();
    factor_into(a, &mut found, &mut SchurWorkspace::new())?;
    Ok(found)
}

/// Factorisation with Q if `into.q` has the order of `a`, without if it has order zero.
fn factor_into(a: &DMatrix<f64>, into: &mut Schur, workspace: &mut SchurWorkspace) -> Result<()> {
    let n = square("A", a)?;
    if into.t.shape() == (n, n) {
        into.t.copy_from(a);
    } else {
        into.t = a.clone();
    }
    let scale = working_scale(a);
    if scale != 1.0 {
        into.t *= scale;
    }
    workspace.factor(into.t.as_mut_slice(), n, into.q.as_mut_slice(), true)?;
    if scale != 1.0 {
        into.t /= scale;
    }
    if into.t.iter().any(|e| !e.is_finite()) {
        return Err(LinalgError::Overflow { what: "the Schur form of a" });
    }
    Ok(())
}

/// The identity; if there are more rows than columns, the rows below are zero.
fn identity(q: &mut [f64], rows: usize) {
    q.fill(0.0);
    q.iter_mut().step_by(rows + 1).for_each(|e| *e = 1.0);
}

/// Power of two that scales a matrix so that squares of its entries neither overflow nor underflow.
fn working_scale(a: &DMatrix<f64>) -> f64 {
    let largest = a.amax();
    let in_range = largest == 0.0 || (2.0_f64.powi(-300)..=2.0_f64.powi(300)).contains(&largest);
    if in_range { 1.0 } else { unit_scale(a) }
}

/// Workspace for matrices up to the largest order so far; grows as needed.
#[derive(Default)]
pub struct SchurWorkspace {
    h: Vec<f64>,
    padded: Vec<f64>,
    work: Vec<f64>,
    blocked: hessenberg::Blocked,
    space: multishift::Space,
}

impl core::fmt::Debug for SchurWorkspace {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("SchurWorkspace").finish_non_exhaustive()
    }
}

impl SchurWorkspace {
    /// An empty workspace; memory is allocated at the first use.
    pub fn new() -> Self {
        Self::default()
    }

    /// Stores the eigenvalues of `a` in `into`, without T and Q: about 10 n^3 flops, and no allocation from the second
    /// call of the same order on.
    ///
    /// # Errors
    /// Those of [`schur()`].
    pub fn eigenvalues(&mut self, a: &DMatrix<f64>, into: &mut Vec<Complex<f64>>) -> Result<()> {
        let n = square("A", a)?;
        let scale = working_scale(a);
        let mut h = core::mem::take(&mut self.h);
        h.clear();
        h.extend(a.iter().map(|e| e * scale));
        let done = self.factor(&mut h, n, &mut [], false);
        into.clear();
        let mut k = 0;
        while done.is_ok() && k < n {
            let d = k * n + k;
            let pair = k + 1 < n && h[d + 1] != 0.0;
            let re = h[d] / scale;
            if pair {
                let im = h[d + 1].abs().sqrt() * h[d + n].abs().sqrt() / scale;
                into.extend([Complex::new(re, im), Complex::new(re, -im)]);
            } else {
                into.push(Complex::new(re, 0.0));
            }
            k += if pair { 2 } else { 1 };
        }
        self.h = h;
        done?;
        if into.iter().any(|l| !l.re.is_finite() || !l.im.is_finite()) {
            return Err(LinalgError::Overflow { what: "the Schur form of a" });
        }
        Ok(())
    }

    /// Overwrites the matrix `h` of order `n` with its Schur form (only the diagonal blocks unless `whole`) and `q`,
    /// unless it is empty, with the transformation.
    fn factor(&mut self, h: &mut [f64], n: usize, q: &mut [f64], whole: bool) -> Result<()> {
        if n == 0 {
            return Ok(());
        }
        if n <= small::LARGEST && !q.is_empty() {
            return converged(kernel::dispatch(small::Small { h, n, q }), h, n);
        }
        if n >= hessenberg::BLOCKED {
            self.blocked.reduce(h, n, q);
        } else if n > multishift::SMALL || q.is_empty() {
            identity(q, n);
            self.work.resize(3 * n, 0.0);
            kernel::dispatch(hessenberg::Reduction { h, n, order: n, q, fresh: true, work: &mut self.work });
        }
        let stuck = if n <= multishift::SMALL && !q.is_empty() {
            // Column length a multiple of four, to fill registers; the rows below Q stay zero.
            let rows = n.next_multiple_of(4);
            self.padded.resize(rows * n, 0.0);
            self.work.resize(3 * n, 0.0);
            let padded = &mut self.padded[..];
            identity(padded, rows);
            kernel::dispatch(hessenberg::Reduction { h, n, order: n, q: padded, fresh: true, work: &mut self.work });
            let stuck = kernel::dispatch(francis::Francis { h, n, q: padded, whole });
            for (to, from) in q.chunks_exact_mut(n).zip(padded.chunks_exact(rows)) {
                to.copy_from_slice(&from[..n]);
            }
            stuck
        } else if n > multishift::SMALL {
            multishift::multishift(&mut deflation::Iterate { h, n, q, whole }, &mut self.space)
        } else {
            kernel::dispatch(francis::Francis { h, n, q, whole })
        };
        converged(stuck, h, n)
    }
}

/// Error if `stuck` leading rows of `h` have not converged.
fn converged(stuck: usize, h: &[f64], n: usize) -> Result<()> {
    if stuck == 0 {
        return Ok(());
    }
    let at = |i: usize, j: usize| h[j * n + i];
    let last = stuck - 1;
    Err(LinalgError::NotConverged {
        method: "the QR iteration for the real Schur form",
        iterations: francis::SWEEPS_PER_ROW * n.max(10),
        remaining: if last > 0 { at(last, last - 1).abs() } else { 0.0 },
        allowed: f64::EPSILON * (at(last, last).abs() + if last > 0 { at(last - 1, last - 1).abs() } else { 0.0 }),
    })
}

impl Default for Schur {
    /// The factorisation of the matrix of order zero.
    fn default() -> Self {
        Self { q: DMatrix::zeros(0, 0), t: DMatrix::zeros(0, 0) }
    }
}

impl Schur {
    /// The eigenvalues, in the order of the diagonal of `T`; of a complex pair, the one above the real axis comes
    /// first.
    pub fn eigenvalues(&self) -> Vec<Complex<f64>> {
        let mut found = Vec::with_capacity(self.t.nrows());
        for (k, size) in blocks(&self.t) {
            let (first, second) = block_eigenvalues(&self.t, k, size);
            found.push(first);
            found.extend(second);
        }
        found
    }
}

/// First index and order (one or two) of each diagonal block of a quasi-triangular matrix.
pub(crate) fn blocks(t: &DMatrix<f64>) -> Vec<(usize, usize)> {
    let n = t.nrows();
    let mut found = Vec::with_capacity(n);
    let mut k = 0;
    while k < n {
        let size = if k + 1 < n && t[(k + 1, k)] != 0.0 { 2 } else { 1 };
        found.push((k, size));
        k += size;
    }
    found
}

/// The eigenvalue of the standardised block of order `size` at `k`, and its conjugate if there is one.
pub(crate) fn block_eigenvalues(t: &DMatrix<f64>, k: usize, size: usize) -> (Complex<f64>, Option<Complex<f64>>) {
    let re = t[(k, k)];
    if size == 1 {
        return (Complex::new(re, 0.0), None);
    }
    let im = t[(k, k + 1)].abs().sqrt() * t[(k + 1, k)].abs().sqrt();
    (Complex::new(re, im), Some(Complex::new(re, -im)))
}
