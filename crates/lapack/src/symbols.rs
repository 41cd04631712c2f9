//! The exported functions, under the names and with the argument lists of Fortran BLAS and LAPACK.
//!
//! Reference: the argument lists of `blas-sys` 0.7 and `lapack-sys` 0.14, and netlib's LAPACK 3.12 for their meaning.

use std::ffi::{c_char, c_int};

use crate::abi::{CleanRegisters, leading, letter, matrix, matrix_mut, size, store, transposed, triangle, vector};
use crate::eigen::Range;
use crate::element::Element;
use crate::{blas, cholesky, eigen, lu, svd};

/// Runs a body whose `?` on a missing argument ends the function.
fn optional(body: impl FnOnce() -> Option<()>) {
    let _clean = CleanRegisters;
    let _ = body();
}

/// Runs a body that ends with an `info` code, early with `-i` when argument i is impossible.
///
/// # Safety
/// `info` points to a writable integer.
unsafe fn reported(info: *mut c_int, body: impl FnOnce() -> Result<(), c_int>) {
    let _clean = CleanRegisters;
    let code = body().err().unwrap_or(0);
    // SAFETY: the caller's promise.
    unsafe { *info = code };
}

/// A position or size as Fortran counts; sizes come from `c_int`, so this never saturates.
fn fortran(k: usize) -> c_int {
    c_int::try_from(k).unwrap_or(c_int::MAX)
}

macro_rules! blas_symbols {
    ($scalar:ty, $gemm:ident, $gemv:ident, $symv:ident, $syrk:ident, $syr2k:ident) => {
        /// `C := alpha op(A) op(B) + beta C`, op(A) m x k, op(B) k x n.
        ///
        /// # Safety
        /// Every pointer is valid for what BLAS says of it; C overlaps neither A nor B.
        #[unsafe(no_mangle)]
        #[allow(clippy::too_many_arguments, reason = "the argument list of BLAS")]
        pub unsafe extern "C" fn $gemm(
            transa: *const c_char,
            transb: *const c_char,
            m: *const c_int,
            n: *const c_int,
            k: *const c_int,
            alpha: *const $scalar,
            a: *const $scalar,
            lda: *const c_int,
            b: *const $scalar,
            ldb: *const c_int,
            beta: *const $scalar,
            c: *mut $scalar,
            ldc: *const c_int,
        ) {
            // SAFETY: the caller's promise, which is that of each function called here.
            optional(|| unsafe {
                let (ta, tb) = (transposed(transa)?, transposed(transb)?);
                let (m, n, k) = (size(m)?, size(n)?, size(k)?);
                let (rows_a, columns_a) = if ta { (k, m) } else { (m, k) };
                let (rows_b, columns_b) = if tb { (n, k) } else { (k, n) };
                let a = matrix(a, rows_a, columns_a, leading(lda, rows_a)?);
                let b = matrix(b, rows_b, columns_b, leading(ldb, rows_b)?);
                let c = matrix_mut(c, m, n, leading(ldc, m)?);
                let a = if ta { a.transpose() } else { a };
                let b = if tb { b.transpose() } else { b };
                blas::gemm(*alpha, a, b, *beta, c);
                Some(())
            });
        }

        /// `y := alpha op(A) x + beta y`, A m x n.
        ///
        /// # Safety
        /// Every pointer is valid for what BLAS says of it; y overlaps neither A nor x.
        #[unsafe(no_mangle)]
        #[allow(clippy::too_many_arguments, reason = "the argument list of BLAS")]
        pub unsafe extern "C" fn $gemv(
            trans: *const c_char,
            m: *const c_int,
            n: *const c_int,
            alpha: *const $scalar,
            a: *const $scalar,
            lda: *const c_int,
            x: *const $scalar,
            incx: *const c_int,
            beta: *const $scalar,
            y: *mut $scalar,
            incy: *const c_int,
        ) {
            // SAFETY: the caller's promise, which is that of each function called here.
            optional(|| unsafe {
                let (m, n, t) = (size(m)?, size(n)?, transposed(trans)?);
                if m == 0 || n == 0 || *incx == 0 || *incy == 0 {
                    return None;
                }
                let a = matrix(a, m, n, leading(lda, m)?);
                let a = if t { a.transpose() } else { a };
                let x = vector(x, a.ncols(), *incx);
                let mut result = vector(y, a.nrows(), *incy);
                blas::gemv(*alpha, a, &x, *beta, &mut result);
                store(y, &result, *incy);
                Some(())
            });
        }

        /// `y := alpha A x + beta y`, A symmetric of order n with one triangle stored.
        ///
        /// # Safety
        /// Every pointer is valid for what BLAS says of it; y overlaps neither A nor x.
        #[unsafe(no_mangle)]
        #[allow(clippy::too_many_arguments, reason = "the argument list of BLAS")]
        pub unsafe extern "C" fn $symv(
            uplo: *const c_char,
            n: *const c_int,
            alpha: *const $scalar,
            a: *const $scalar,
            lda: *const c_int,
            x: *const $scalar,
            incx: *const c_int,
            beta: *const $scalar,
            y: *mut $scalar,
            incy: *const c_int,
        ) {
            // SAFETY: the caller's promise, which is that of each function called here.
            optional(|| unsafe {
                let (stored, n) = (triangle(uplo)?, size(n)?);
                if *incx == 0 || *incy == 0 {
                    return None;
                }
                let a = matrix(a, n, n, leading(lda, n)?);
                let x = vector(x, n, *incx);
                let mut result = vector(y, n, *incy);
                blas::symv(stored, *alpha, a, &x, *beta, &mut result);
                store(y, &result, *incy);
                Some(())
            });
        }

        /// One triangle of `C := alpha op(A) op(A)' + beta C`, op(A) n x k.
        ///
        /// # Safety
        /// Every pointer is valid for what BLAS says of it; C does not overlap A.
        #[unsafe(no_mangle)]
        #[allow(clippy::too_many_arguments, reason = "the argument list of BLAS")]
        pub unsafe extern "C" fn $syrk(
            uplo: *const c_char,
            trans: *const c_char,
            n: *const c_int,
            k: *const c_int,
            alpha: *const $scalar,
            a: *const $scalar,
            lda: *const c_int,
            beta: *const $scalar,
            c: *mut $scalar,
            ldc: *const c_int,
        ) {
            // SAFETY: the caller's promise, which is that of each function called here.
            optional(|| unsafe {
                let (stored, t, n, k) = (triangle(uplo)?, transposed(trans)?, size(n)?, size(k)?);
                let (rows, columns) = if t { (k, n) } else { (n, k) };
                let a = matrix(a, rows, columns, leading(lda, rows)?);
                let a = if t { a.transpose() } else { a };
                blas::syrk(stored, *alpha, a, *beta, matrix_mut(c, n, n, leading(ldc, n)?));
                Some(())
            });
        }

        /// One triangle of `C := alpha (op(A) op(B)' + op(B) op(A)') + beta C`, op(A) and op(B) n x k.
        ///
        /// # Safety
        /// Every pointer is valid for what BLAS says of it; C overlaps neither A nor B.
        #[unsafe(no_mangle)]
        #[allow(clippy::too_many_arguments, reason = "the argument list of BLAS")]
        pub unsafe extern "C" fn $syr2k(
            uplo: *const c_char,
            trans: *const c_char,
            n: *const c_int,
            k: *const c_int,
            alpha: *const $scalar,
            a: *const $scalar,
            lda: *const c_int,
            b: *const $scalar,
            ldb: *const c_int,
            beta: *const $scalar,
            c: *mut $scalar,
            ldc: *const c_int,
        ) {
            // SAFETY: the caller's promise, which is that of each function called here.
            optional(|| unsafe {
                let (stored, t, n, k) = (triangle(uplo)?, transposed(trans)?, size(n)?, size(k)?);
                let (rows, columns) = if t { (k, n) } else { (n, k) };
                let a = matrix(a, rows, columns, leading(lda, rows)?);
                let b = matrix(b, rows, columns, leading(ldb, rows)?);
                let (a, b) = if t { (a.transpose(), b.transpose()) } else { (a, b) };
                blas::syr2k(stored, *alpha, a, b, *beta, matrix_mut(c, n, n, leading(ldc, n)?));
                Some(())
            });
        }
    };
}

macro_rules! lapack_symbols {
    ($scalar:ty, $potrf:ident, $potrs:ident, $syevr:ident, $gesdd:ident, $gesvd:ident, $gesv:ident) => {
        /// Cholesky factorisation `A = L L'` or `A = U'U`. `info = k`: the leading minor of order k is not positive;
        /// then A is as it was.
        ///
        /// # Safety
        /// Every pointer is valid for what LAPACK says of it.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $potrf(
            uplo: *const c_char,
            n: *const c_int,
            a: *mut $scalar,
            lda: *const c_int,
            info: *mut c_int,
        ) {
            // SAFETY: the caller's promise, which is that of each function called here.
            let body = || unsafe {
                let (stored, n) = (triangle(uplo).ok_or(-1)?, size(n).ok_or(-2)?);
                let a = matrix_mut(a, n, n, leading(lda, n).ok_or(-4)?);
                cholesky::potrf(stored, a).map_err(fortran)
            };
            // SAFETY: the caller's promise.
            unsafe { reported(info, body) };
        }

        /// Solves `A X = B` with the factor that the Cholesky factorisation left of A.
        ///
        /// # Safety
        /// Every pointer is valid for what LAPACK says of it; B does not overlap A.
        #[unsafe(no_mangle)]
        #[allow(clippy::too_many_arguments, reason = "the argument list of LAPACK")]
        pub unsafe extern "C" fn $potrs(
            uplo: *const c_char,
            n: *const c_int,
            nrhs: *const c_int,
            a: *const $scalar,
            lda: *const c_int,
            b: *mut $scalar,
            ldb: *const c_int,
            info: *mut c_int,
        ) {
            // SAFETY: the caller's promise, which is that of each function called here.
            let body = || unsafe {
                let (stored, n, nrhs) = (triangle(uplo).ok_or(-1)?, size(n).ok_or(-2)?, size(nrhs).ok_or(-3)?);
                let a = matrix(a, n, n, leading(lda, n).ok_or(-5)?);
                cholesky::potrs(stored, a, matrix_mut(b, n, nrhs, leading(ldb, n).ok_or(-7)?));
                Ok(())
            };
            // SAFETY: the caller's promise.
            unsafe { reported(info, body) };
        }

        /// Eigenvalues W (ascending) and eigenvectors Z of a symmetric A, all (`A`), in (vl, vu] (`V`) or from the
        /// il-th to the iu-th (`I`). A is left as it was. `info = 1`: not finite, or not converged.
        ///
        /// # Safety
        /// Every pointer is valid for what LAPACK says of it; the outputs overlap nothing.
        #[unsafe(no_mangle)]
        #[allow(clippy::too_many_arguments, reason = "the argument list of LAPACK")]
        pub unsafe extern "C" fn $syevr(
            jobz: *const c_char,
            range: *const c_char,
            uplo: *const c_char,
            n: *const c_int,
            a: *mut $scalar,
            lda: *const c_int,
            vl: *const $scalar,
            vu: *const $scalar,
            il: *const c_int,
            iu: *const c_int,
            _abstol: *const $scalar,
            m: *mut c_int,
            w: *mut $scalar,
            z: *mut $scalar,
            ldz: *const c_int,
            isuppz: *mut c_int,
            work: *mut $scalar,
            lwork: *const c_int,
            iwork: *mut c_int,
            liwork: *const c_int,
            info: *mut c_int,
        ) {
            // SAFETY: the caller's promise, which is that of each function called here.
            let body = || unsafe {
                let vectors = match letter(jobz) {
                    b'V' => true,
                    b'N' => false,
                    _ => return Err(-1),
                };
                let range_letter = letter(range);
                if !matches!(range_letter, b'A' | b'V' | b'I') {
                    return Err(-2);
                }
                let (stored, n) = (triangle(uplo).ok_or(-3)?, size(n).ok_or(-4)?);
                let lda = leading(lda, n).ok_or(-6)?;
                let range = match range_letter {
                    b'A' => Range::All,
                    b'V' if n > 0 && *vl >= *vu => return Err(-8),
                    b'V' => Range::Between(*vl, *vu),
                    _ => {
                        let first = size(il).filter(|&k| k >= 1).ok_or(-9)?;
                        let last = size(iu).filter(|&k| k <= n && (k >= first || n == 0)).ok_or(-10)?;
                        if n == 0 { Range::All } else { Range::Numbered(first - 1, last - 1) }
                    }
                };
                let ldz = leading(ldz, if vectors { n } else { 0 }).ok_or(-15)?;
                if *lwork == -1 || *liwork == -1 {
                    *work = <$scalar>::from_size((26 * n).max(1));
                    *iwork = fortran((10 * n).max(1));
                    return Ok(());
                }
                let (values, basis) = eigen::syevr(stored, matrix(a, n, n, lda), range, vectors).ok_or(1)?;
                *m = fortran(values.len());
                store(w, &values, 1);
                if let Some(basis) = basis {
                    svd::copy_columns(basis.as_ref(), matrix_mut(z, n, values.len(), ldz));
                    // Every eigenvector may be nonzero from its first row to its last.
                    for k in 0..values.len() {
                        *isuppz.add(2 * k) = 1;
                        *isuppz.add(2 * k + 1) = fortran(n);
                    }
                }
                Ok(())
            };
            // SAFETY: the caller's promise.
            unsafe { reported(info, body) };
        }

        /// Singular value decomposition `A = U diag(S) V'`; `jobz` A: square U and V, S: min(m, n) columns, N: S only.
        /// O (overwrite A) is not offered: `info = -1`. A is left as it was. `info = -4`: not finite; `info = 1`: not
        /// converged.
        ///
        /// # Safety
        /// Every pointer is valid for what LAPACK says of it; the outputs overlap nothing.
        #[unsafe(no_mangle)]
        #[allow(clippy::too_many_arguments, reason = "the argument list of LAPACK")]
        pub unsafe extern "C" fn $gesdd(
            jobz: *const c_char,
            m: *const c_int,
            n: *const c_int,
            a: *mut $scalar,
            lda: *const c_int,
            s: *mut $scalar,
            u: *mut $scalar,
            ldu: *const c_int,
            vt: *mut $scalar,
            ldvt: *const c_int,
            work: *mut $scalar,
            lwork: *const c_int,
            _iwork: *mut c_int,
            info: *mut c_int,
        ) {
            // SAFETY: the caller's promise, which is that of each function called here.
            let body = || unsafe {
                let job = letter(jobz);
                if !matches!(job, b'A' | b'S' | b'N') {
                    return Err(-1);
                }
                let (m, n) = (size(m).ok_or(-2)?, size(n).ok_or(-3)?);
                let (small, large) = (m.min(n), m.max(n));
                let lda = leading(lda, m).ok_or(-5)?;
                let ldu = leading(ldu, if job == b'N' { 0 } else { m }).ok_or(-8)?;
                let rows_vt = if job == b'A' { n } else { small };
                let ldvt = leading(ldvt, if job == b'N' { 0 } else { rows_vt }).ok_or(-10)?;
                if *lwork == -1 {
                    *work = <$scalar>::from_size((4 * small * small + 7 * small).max(3 * small + large).max(1));
                    return Ok(());
                }
                let a = matrix(a, m, n, lda);
                let d = svd::svd(a, job == b'A').ok_or(if blas::is_finite(a) { 1 } else { -4 })?;
                store(s, &d.s, 1);
                if job != b'N' {
                    let columns_u = if job == b'A' { m } else { small };
                    svd::copy_columns(d.u.as_ref(), matrix_mut(u, m, columns_u, ldu));
                    svd::copy_columns(d.v.transpose(), matrix_mut(vt, rows_vt, n, ldvt));
                }
                Ok(())
            };
            // SAFETY: the caller's promise.
            unsafe { reported(info, body) };
        }

        /// Singular value decomposition `A = U diag(S) V'`; `jobu` and `jobvt` choose as in the divide-and-conquer
        /// variant, each for its own factor. A is left as it was. `info = 1`: not finite, or not converged.
        ///
        /// # Safety
        /// Every pointer is valid for what LAPACK says of it; the outputs overlap nothing.
        #[unsafe(no_mangle)]
        #[allow(clippy::too_many_arguments, reason = "the argument list of LAPACK")]
        pub unsafe extern "C" fn $gesvd(
            jobu: *const c_char,
            jobvt: *const c_char,
            m: *const c_int,
            n: *const c_int,
            a: *mut $scalar,
            lda: *const c_int,
            s: *mut $scalar,
            u: *mut $scalar,
            ldu: *const c_int,
            vt: *mut $scalar,
            ldvt: *const c_int,
            work: *mut $scalar,
            lwork: *const c_int,
            info: *mut c_int,
        ) {
            // SAFETY: the caller's promise, which is that of each function called here.
            let body = || unsafe {
                let (job_u, job_vt) = (letter(jobu), letter(jobvt));
                if !matches!(job_u, b'A' | b'S' | b'N') {
                    return Err(-1);
                }
                if !matches!(job_vt, b'A' | b'S' | b'N') {
                    return Err(-2);
                }
                let (m, n) = (size(m).ok_or(-3)?, size(n).ok_or(-4)?);
                let (small, large) = (m.min(n), m.max(n));
                let lda = leading(lda, m).ok_or(-6)?;
                let ldu = leading(ldu, if job_u == b'N' { 0 } else { m }).ok_or(-9)?;
                let rows_vt = if job_vt == b'A' { n } else { small };
                let ldvt = leading(ldvt, if job_vt == b'N' { 0 } else { rows_vt }).ok_or(-11)?;
                if *lwork == -1 {
                    *work = <$scalar>::from_size((3 * small + large).max(5 * small).max(1));
                    return Ok(());
                }
                let square = job_u == b'A' || job_vt == b'A';
                let d = svd::svd(matrix(a, m, n, lda), square).ok_or(1)?;
                store(s, &d.s, 1);
                if job_u != b'N' {
                    let columns_u = if job_u == b'A' { m } else { small };
                    svd::copy_columns(d.u.as_ref(), matrix_mut(u, m, columns_u, ldu));
                }
                if job_vt != b'N' {
                    svd::copy_columns(d.v.transpose(), matrix_mut(vt, rows_vt, n, ldvt));
                }
                Ok(())
            };
            // SAFETY: the caller's promise.
            unsafe { reported(info, body) };
        }

        /// Solves `A X = B`, leaving L and U of `A = P L U` in A and the row exchanges in `ipiv`. `info = k`: the k-th
        /// pivot is zero.
        ///
        /// # Safety
        /// Every pointer is valid for what LAPACK says of it; A, B and ipiv do not overlap.
        #[unsafe(no_mangle)]
        #[allow(clippy::too_many_arguments, reason = "the argument list of LAPACK")]
        pub unsafe extern "C" fn $gesv(
            n: *const c_int,
            nrhs: *const c_int,
            a: *mut $scalar,
            lda: *const c_int,
            ipiv: *mut c_int,
            b: *mut $scalar,
            ldb: *const c_int,
            info: *mut c_int,
        ) {
            // SAFETY: the caller's promise, which is that of each function called here.
            let body = || unsafe {
                let (n, nrhs) = (size(n).ok_or(-1)?, size(nrhs).ok_or(-2)?);
                let a = matrix_mut(a, n, n, leading(lda, n).ok_or(-4)?);
                let b = matrix_mut(b, n, nrhs, leading(ldb, n).ok_or(-7)?);
                let mut exchanges = vec![0; n];
                let outcome = lu::gesv(a, &mut exchanges, b);
                let exchanges: Vec<c_int> = exchanges.iter().map(|&k| fortran(k + 1)).collect();
                store(ipiv, &exchanges, 1);
                outcome.map_err(|k| fortran(k + 1))
            };
            // SAFETY: the caller's promise.
            unsafe { reported(info, body) };
        }
    };
}

blas_symbols!(f32, sgemm_, sgemv_, ssymv_, ssyrk_, ssyr2k_);
blas_symbols!(f64, dgemm_, dgemv_, dsymv_, dsyrk_, dsyr2k_);
lapack_symbols!(f32, spotrf_, spotrs_, ssyevr_, sgesdd_, sgesvd_, sgesv_);
lapack_symbols!(f64, dpotrf_, dpotrs_, dsyevr_, dgesdd_, dgesvd_, dgesv_);
