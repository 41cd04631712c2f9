//! Every exported symbol, called as Fortran would, against loops written from its definition.
//!
//! Matrices have a leading dimension above their number of rows, filled with a sentinel that must survive, and the
//! triangle that a function must not touch holds NaN.
#![allow(unsafe_code, reason = "the functions under test take raw pointers")]

use std::ffi::{c_char, c_int};

use proptest::prelude::*;

use luenberger_lapack::symbols::*;
use luenberger_random::Random;

fn letter(l: u8) -> c_char {
    c_char::try_from(l).unwrap()
}

fn int(n: usize) -> c_int {
    c_int::try_from(n).unwrap()
}

macro_rules! suite {
    ($module:ident, $scalar:ty, $gemm:ident, $gemv:ident, $symv:ident, $syrk:ident, $syr2k:ident, $potrf:ident, $potrs:ident,
     $syevr:ident, $gesdd:ident, $gesvd:ident, $gesv:ident) => {
        mod $module {
            use super::*;

            const EPSILON: $scalar = <$scalar>::EPSILON;
            const SENTINEL: $scalar = 12345.0;

            /// In [-1, 1), of 21 bits: exact in either precision.
            fn unit(random: &mut Random) -> $scalar {
                (random.bits() >> 43) as $scalar / (1u32 << 20) as $scalar - 1.0
            }

            /// A column-major matrix with room below its columns.
            #[derive(Clone, Debug)]
            struct Strided {
                rows: usize,
                columns: usize,
                lda: usize,
                data: Vec<$scalar>,
            }

            impl Strided {
                fn new(rows: usize, columns: usize, mut f: impl FnMut(usize, usize) -> $scalar) -> Self {
                    let lda = rows + 3;
                    let mut data = vec![SENTINEL; lda * columns.max(1)];
                    for j in 0..columns {
                        for i in 0..rows {
                            data[j * lda + i] = f(i, j);
                        }
                    }
                    Self { rows, columns, lda, data }
                }
                fn random(rows: usize, columns: usize, random: &mut Random) -> Self {
                    Self::new(rows, columns, |_, _| unit(random))
                }
                fn symmetric(n: usize, random: &mut Random) -> Self {
                    let half = Self::random(n, n, random);
                    Self::new(n, n, |i, j| half.at(i.max(j), i.min(j)))
                }
                /// `G G' + I`.
                fn definite(n: usize, random: &mut Random) -> Self {
                    let g = Self::random(n, n, random);
                    Self::new(n, n, |i, j| {
                        (0..n).map(|k| g.at(i, k) * g.at(j, k)).sum::<$scalar>() + <$scalar>::from(u8::from(i == j))
                    })
                }
                fn at(&self, i: usize, j: usize) -> $scalar {
                    self.data[j * self.lda + i]
                }
                fn op(&self, transposed: bool, i: usize, j: usize) -> $scalar {
                    if transposed { self.at(j, i) } else { self.at(i, j) }
                }
                /// Only one triangle; the other is NaN.
                fn half(&self, uplo: u8) -> Self {
                    let stored = |i, j| if uplo == b'L' { i >= j } else { i <= j };
                    Self::new(self.rows, self.columns, |i, j| if stored(i, j) { self.at(i, j) } else { <$scalar>::NAN })
                }
                fn padding_survives(&self) -> bool {
                    (0..self.columns).all(|j| (self.rows..self.lda).all(|i| self.at(i, j) == SENTINEL))
                }
                fn other_triangle_is_nan(&self, uplo: u8) -> bool {
                    (0..self.columns).all(|j| {
                        (0..self.rows).all(|i| (if uplo == b'L' { i >= j } else { i <= j }) || self.at(i, j).is_nan())
                    })
                }
                fn largest(&self) -> $scalar {
                    (0..self.columns).flat_map(|j| (0..self.rows).map(move |i| (i, j))).fold(0.0, |m, (i, j)| {
                        let x = self.at(i, j).abs();
                        if x > m { x } else { m }
                    })
                }
            }

            /// Entries of A and B are at most 1, so a sum of k products and its scaling err by at most this.
            fn product_error(k: usize, alpha: $scalar, beta: $scalar) -> $scalar {
                (2 * k + 8) as $scalar * EPSILON * (alpha.abs() * (2 * k + 2) as $scalar + beta.abs() + 1.0)
            }

            fn kronecker(k: usize, l: usize) -> $scalar {
                <$scalar>::from(u8::from(k == l))
            }

            fn close(x: $scalar, y: $scalar, error: $scalar) -> bool {
                (x - y).abs() <= error
            }

            proptest! {
                #![proptest_config(ProptestConfig::with_cases(48))]

                #[test]
                fn gemm(seed: u64, m in 0usize..20, n in 0usize..20, k in 0usize..20, ta: bool, tb: bool, overwrite: bool) {
                    let random = &mut Random(seed);
                    let a = if ta { Strided::random(k, m, random) } else { Strided::random(m, k, random) };
                    let b = if tb { Strided::random(n, k, random) } else { Strided::random(k, n, random) };
                    let mut c = Strided::random(m, n, random);
                    let (alpha, beta) = (unit(random), if overwrite { 0.0 } else { unit(random) });
                    let before = c.clone();
                    if overwrite {
                        c = Strided::new(m, n, |_, _| <$scalar>::NAN);
                    }
                    let (la, lb) = (letter(if ta { b'T' } else { b'N' }), letter(if tb { b'c' } else { b'n' }));
                    // SAFETY: shapes and leading dimensions are those of the buffers.
                    unsafe {
                        $gemm(&la, &lb, &int(m), &int(n), &int(k), &alpha, a.data.as_ptr(), &int(a.lda), b.data.as_ptr(),
                              &int(b.lda), &beta, c.data.as_mut_ptr(), &int(c.lda));
                    }
                    for i in 0..m {
                        for j in 0..n {
                            let sum: $scalar = (0..k).map(|l| a.op(ta, i, l) * b.op(tb, l, j)).sum();
                            let expected = alpha * sum + beta * before.at(i, j);
                            prop_assert!(close(c.at(i, j), expected, product_error(k, alpha, beta)));
                        }
                    }
                    prop_assert!(c.padding_survives());
                }

                #[test]
                fn gemv(seed: u64, m in 1usize..20, n in 1usize..20, t: bool, incx in prop_oneof![-3..0i32, 1..4i32], incy in prop_oneof![-3..0i32, 1..4i32]) {
                    let random = &mut Random(seed);
                    let a = Strided::random(m, n, random);
                    let (inputs, outputs) = if t { (m, n) } else { (n, m) };
                    let (sx, sy) = (incx.unsigned_abs() as usize, incy.unsigned_abs() as usize);
                    let x: Vec<$scalar> = (0..inputs * sx).map(|_| unit(random)).collect();
                    let mut y: Vec<$scalar> = (0..outputs * sy).map(|_| unit(random)).collect();
                    let before = y.clone();
                    let (alpha, beta) = (unit(random), unit(random));
                    let place = |k: usize, count: usize, inc: i32| {
                        let step = inc.unsigned_abs() as usize;
                        if inc > 0 { k * step } else { (count - 1 - k) * step }
                    };
                    let lt = letter(if t { b't' } else { b'N' });
                    // SAFETY: shapes, leading dimension and increments are those of the buffers.
                    unsafe {
                        $gemv(&lt, &int(m), &int(n), &alpha, a.data.as_ptr(), &int(a.lda), x.as_ptr(), &incx, &beta, y.as_mut_ptr(), &incy);
                    }
                    let mut expected = before.clone();
                    for i in 0..outputs {
                        let sum: $scalar = (0..inputs).map(|j| a.op(t, i, j) * x[place(j, inputs, incx)]).sum();
                        let at = place(i, outputs, incy);
                        expected[at] = alpha * sum + beta * before[at];
                    }
                    for (found, expected) in y.iter().zip(&expected) {
                        prop_assert!(close(*found, *expected, product_error(inputs, alpha, beta)));
                    }
                }

                #[test]
                fn symv(seed: u64, n in 0usize..20, lower: bool) {
                    let random = &mut Random(seed);
                    let uplo = if lower { b'L' } else { b'U' };
                    let a = Strided::symmetric(n, random);
                    let half = a.half(uplo);
                    let x: Vec<$scalar> = (0..2 * n).map(|_| unit(random)).collect();
                    let mut y: Vec<$scalar> = (0..n).map(|_| unit(random)).collect();
                    let before = y.clone();
                    let (alpha, beta) = (unit(random), unit(random));
                    // SAFETY: shapes, leading dimension and increments are those of the buffers.
                    unsafe {
                        $symv(&letter(uplo), &int(n), &alpha, half.data.as_ptr(), &int(half.lda), x.as_ptr(), &2, &beta, y.as_mut_ptr(), &1);
                    }
                    for i in 0..n {
                        let sum: $scalar = (0..n).map(|j| a.at(i, j) * x[2 * j]).sum();
                        prop_assert!(close(y[i], alpha * sum + beta * before[i], product_error(n, alpha, beta)));
                    }
                }

                #[test]
                fn syrk_and_syr2k(seed: u64, n in 0usize..24, k in 0usize..20, lower: bool, t: bool) {
                    let random = &mut Random(seed);
                    let uplo = if lower { b'L' } else { b'U' };
                    let shape = if t { (k, n) } else { (n, k) };
                    let a = Strided::random(shape.0, shape.1, random);
                    let b = Strided::random(shape.0, shape.1, random);
                    let before = Strided::symmetric(n, random);
                    let (alpha, beta) = (unit(random), unit(random));
                    let (mut c, mut c2) = (before.half(uplo), before.half(uplo));
                    let (lu, lt) = (letter(uplo), letter(if t { b'T' } else { b'N' }));
                    // SAFETY: shapes and leading dimensions are those of the buffers.
                    unsafe {
                        $syrk(&lu, &lt, &int(n), &int(k), &alpha, a.data.as_ptr(), &int(a.lda), &beta, c.data.as_mut_ptr(), &int(c.lda));
                        $syr2k(&lu, &lt, &int(n), &int(k), &alpha, a.data.as_ptr(), &int(a.lda), b.data.as_ptr(), &int(b.lda), &beta,
                               c2.data.as_mut_ptr(), &int(c2.lda));
                    }
                    for j in 0..n {
                        for i in 0..n {
                            if (if lower { i >= j } else { i <= j }) {
                                let aa: $scalar = (0..k).map(|l| a.op(t, i, l) * a.op(t, j, l)).sum();
                                let ab: $scalar = (0..k).map(|l| a.op(t, i, l) * b.op(t, j, l) + b.op(t, i, l) * a.op(t, j, l)).sum();
                                prop_assert!(close(c.at(i, j), alpha * aa + beta * before.at(i, j), product_error(k, alpha, beta)));
                                prop_assert!(close(c2.at(i, j), alpha * ab + beta * before.at(i, j), product_error(2 * k, alpha, beta)));
                            }
                        }
                    }
                    prop_assert!(c.padding_survives() && c.other_triangle_is_nan(uplo));
                    prop_assert!(c2.padding_survives() && c2.other_triangle_is_nan(uplo));
                }

                #[test]
                fn potrf_and_potrs(seed: u64, n in 0usize..40, nrhs in 0usize..4, lower: bool) {
                    let random = &mut Random(seed);
                    let uplo = if lower { b'L' } else { b'U' };
                    let a = Strided::definite(n, random);
                    let mut factor = a.half(uplo);
                    let b = Strided::random(n, nrhs, random);
                    let mut x = b.clone();
                    let mut info = 77;
                    // SAFETY: shapes and leading dimensions are those of the buffers.
                    unsafe {
                        $potrf(&letter(uplo), &int(n), factor.data.as_mut_ptr(), &int(factor.lda), &mut info);
                        prop_assert_eq!(info, 0);
                        $potrs(&letter(uplo), &int(n), &int(nrhs), factor.data.as_ptr(), &int(factor.lda), x.data.as_mut_ptr(), &int(x.lda), &mut info);
                    }
                    prop_assert_eq!(info, 0);
                    // The triangular factors are at most sqrt(max diag) in size; backward error n eps |L||L'|.
                    let error = (4 * n + 8) as $scalar * EPSILON * (n + 1) as $scalar;
                    let l = |i: usize, k: usize| if k > i { 0.0 } else { factor.op(!lower, i, k) };
                    for i in 0..n {
                        for j in 0..n {
                            let sum: $scalar = (0..n).map(|k| l(i, k) * l(j, k)).sum();
                            prop_assert!(close(sum, a.at(i, j), error));
                        }
                        for j in 0..nrhs {
                            let sum: $scalar = (0..n).map(|k| a.at(i, k) * x.at(k, j)).sum();
                            prop_assert!(close(sum, b.at(i, j), error * (n + 1) as $scalar * (1.0 + x.largest())));
                        }
                    }
                    prop_assert!(factor.padding_survives() && factor.other_triangle_is_nan(uplo) && x.padding_survives());
                }

                /// diag(1, .., 1, -1 at k, ..) plus a strictly lower part keeps its first k leading minors: info is k +
                /// 1.
                #[test]
                fn potrf_of_an_indefinite_matrix_returns_its_order(seed: u64, n in 1usize..90, lower: bool, where_ in 0.0..1.0f64) {
                    let random = &mut Random(seed);
                    let uplo = if lower { b'L' } else { b'U' };
                    let bad = ((n as f64 * where_) as usize).min(n - 1);
                    let unit = Strided::new(n, n, |i, j| if i == j { 1.0 } else if i > j { unit(random) / n as $scalar } else { 0.0 });
                    let sign = |k: usize| if k == bad { -1.0 } else { 1.0 };
                    let a = Strided::new(n, n, |i, j| (0..n).map(|k| unit.at(i, k) * sign(k) * unit.at(j, k)).sum());
                    let mut half = a.half(uplo);
                    let mut info = 77;
                    // SAFETY: shape and leading dimension are those of the buffer.
                    unsafe { $potrf(&letter(uplo), &int(n), half.data.as_mut_ptr(), &int(half.lda), &mut info) };
                    prop_assert_eq!(info, int(bad + 1));
                }

                #[test]
                fn syevr(seed: u64, n in 1usize..40, lower: bool, range in 0..3usize) {
                    let random = &mut Random(seed);
                    let uplo = if lower { b'L' } else { b'U' };
                    let a = Strided::symmetric(n, random);
                    let mut half = a.half(uplo);
                    let (vl, vu): ($scalar, $scalar) = (-0.5, 1.0);
                    let (il, iu) = (int(1 + n / 3), int(1 + n / 2));
                    let run = |jobz: u8, range: u8, half: &mut Strided| {
                        let (mut work, mut iwork, mut m, mut info) = (vec![0.0 as $scalar], vec![0 as c_int], 0 as c_int, 77 as c_int);
                        let mut w = vec![0.0 as $scalar; n];
                        let mut z = Strided::new(n, n, |_, _| 0.0);
                        let mut support = vec![0 as c_int; 2 * n];
                        let (lda, ldz) = (int(half.lda), int(z.lda));
                        for query in [true, false] {
                            let (lwork, liwork) = if query { (-1, -1) } else { (int(work.len()), int(iwork.len())) };
                            // SAFETY: shapes and leading dimensions are those of the buffers, workspace as the query
                            // said.
                            unsafe {
                                $syevr(&letter(jobz), &letter(range), &letter(uplo), &int(n), half.data.as_mut_ptr(), &lda, &vl, &vu,
                                       &il, &iu, &0.0, &mut m, w.as_mut_ptr(), z.data.as_mut_ptr(), &ldz, support.as_mut_ptr(),
                                       work.as_mut_ptr(), &lwork, iwork.as_mut_ptr(), &liwork, &mut info);
                            }
                            assert_eq!(info, 0);
                            if query {
                                assert!(work[0] >= (26 * n) as $scalar && iwork[0] >= int(10 * n));
                                work = vec![0.0; work[0] as usize];
                                iwork = vec![0; iwork[0] as usize];
                            }
                        }
                        w.truncate(m as usize);
                        assert!(z.padding_survives());
                        (w, z)
                    };
                    let (all, _) = run(b'N', b'A', &mut half);
                    let error = (20 * n + 20) as $scalar * EPSILON * n as $scalar;
                    prop_assert!(all.is_sorted());
                    let trace: $scalar = (0..n).map(|i| a.at(i, i)).sum();
                    prop_assert!(close(trace, all.iter().sum(), error * n as $scalar));
                    let (values, z) = run(b'V', [b'A', b'V', b'I'][range], &mut half);
                    let expected: Vec<$scalar> = match range {
                        0 => all.clone(),
                        1 => all.iter().copied().filter(|&x| vl < x && x <= vu).collect(),
                        _ => all[n / 3..=n / 2].to_vec(),
                    };
                    prop_assert_eq!(values.len(), expected.len());
                    for (k, (value, expected)) in values.iter().zip(&expected).enumerate() {
                        prop_assert!(close(*value, *expected, error));
                        for i in 0..n {
                            let sum: $scalar = (0..n).map(|j| a.at(i, j) * z.at(j, k)).sum();
                            prop_assert!(close(sum, value * z.at(i, k), error));
                        }
                        for l in 0..values.len() {
                            let dot: $scalar = (0..n).map(|j| z.at(j, l) * z.at(j, k)).sum();
                            prop_assert!(close(dot, kronecker(k, l), error));
                        }
                    }
                }

                #[test]
                fn gesdd_and_gesvd(seed: u64, m in 1usize..24, n in 1usize..24, square: bool) {
                    let random = &mut Random(seed);
                    let a = Strided::random(m, n, random);
                    let small = m.min(n);
                    let job = letter(if square { b'A' } else { b'S' });
                    let (cu, rv) = if square { (m, n) } else { (small, small) };
                    for divide_and_conquer in [true, false] {
                        let mut copy = a.clone();
                        let (mut s, mut work, mut iwork, mut info) = (vec![0.0 as $scalar; small], vec![0.0 as $scalar], vec![0; 8 * small], 77);
                        let (mut u, mut vt) = (Strided::new(m, cu, |_, _| 0.0), Strided::new(rv, n, |_, _| 0.0));
                        let (lda, ldu, ldvt) = (int(a.lda), int(u.lda), int(vt.lda));
                        for query in [true, false] {
                            let lwork = if query { -1 } else { int(work.len()) };
                            // SAFETY: shapes and leading dimensions are those of the buffers, workspace as the query
                            // said.
                            unsafe {
                                if divide_and_conquer {
                                    $gesdd(&job, &int(m), &int(n), copy.data.as_mut_ptr(), &lda, s.as_mut_ptr(), u.data.as_mut_ptr(), &ldu,
                                           vt.data.as_mut_ptr(), &ldvt, work.as_mut_ptr(), &lwork, iwork.as_mut_ptr(), &mut info);
                                } else {
                                    $gesvd(&job, &job, &int(m), &int(n), copy.data.as_mut_ptr(), &lda, s.as_mut_ptr(), u.data.as_mut_ptr(), &ldu,
                                           vt.data.as_mut_ptr(), &ldvt, work.as_mut_ptr(), &lwork, &mut info);
                                }
                            }
                            prop_assert_eq!(info, 0);
                            if query {
                                prop_assert!(work[0] >= small as $scalar);
                                work = vec![0.0; work[0] as usize];
                            }
                        }
                        let error = (20 * (m + n)) as $scalar * EPSILON * (m + n) as $scalar;
                        prop_assert!(s.is_sorted_by(|x, y| x >= y) && s[small - 1] >= 0.0);
                        for i in 0..m {
                            for j in 0..n {
                                let sum: $scalar = (0..small).map(|k| u.at(i, k) * s[k] * vt.at(k, j)).sum();
                                prop_assert!(close(sum, a.at(i, j), error));
                            }
                        }
                        for k in 0..cu {
                            for l in 0..cu {
                                let dot: $scalar = (0..m).map(|i| u.at(i, k) * u.at(i, l)).sum();
                                prop_assert!(close(dot, kronecker(k, l), error));
                            }
                        }
                        for k in 0..rv {
                            for l in 0..rv {
                                let dot: $scalar = (0..n).map(|i| vt.at(k, i) * vt.at(l, i)).sum();
                                prop_assert!(close(dot, kronecker(k, l), error));
                            }
                        }
                        prop_assert!(u.padding_survives() && vt.padding_survives());
                    }
                }

                #[test]
                fn gesv(seed: u64, n in 1usize..30, nrhs in 1usize..4) {
                    let random = &mut Random(seed);
                    // Diagonal dominance by a permuted diagonal: well conditioned, and pivoting has work to do.
                    let a = Strided::new(n, n, |i, j| unit(random) + if (i + 1) % n == j { 2.0 * n as $scalar } else { 0.0 });
                    let b = Strided::random(n, nrhs, random);
                    let (mut lu, mut x, mut pivots, mut info) = (a.clone(), b.clone(), vec![0; n], 77);
                    // SAFETY: shapes and leading dimensions are those of the buffers.
                    unsafe {
                        $gesv(&int(n), &int(nrhs), lu.data.as_mut_ptr(), &int(a.lda), pivots.as_mut_ptr(), x.data.as_mut_ptr(), &int(x.lda), &mut info);
                    }
                    prop_assert_eq!(info, 0);
                    let error = (20 * n) as $scalar * EPSILON * (3 * n) as $scalar;
                    for i in 0..n {
                        for j in 0..nrhs {
                            let sum: $scalar = (0..n).map(|k| a.at(i, k) * x.at(k, j)).sum();
                            prop_assert!(close(sum, b.at(i, j), error));
                        }
                    }
                    // The exchanges applied to A give L U.
                    let mut rows: Vec<usize> = (0..n).collect();
                    for (k, &pivot) in pivots.iter().enumerate() {
                        rows.swap(k, pivot as usize - 1);
                    }
                    for i in 0..n {
                        for j in 0..n {
                            let sum: $scalar = (0..=i.min(j)).map(|k| if k == i { 1.0 } else { lu.at(i, k) } * lu.at(k, j)).sum();
                            prop_assert!(close(sum, a.at(rows[i], j), error * n as $scalar));
                        }
                    }
                    prop_assert!(lu.padding_survives() && x.padding_survives());
                }
            }

            #[test]
            fn a_singular_system_names_its_pivot() {
                let mut a = Strided::new(3, 3, |i, j| if j == 1 { 0.0 } else { (i + 2 * j + 1) as $scalar });
                let mut b = Strided::new(3, 1, |_, _| 1.0);
                let (mut pivots, mut info) = (vec![0; 3], 77);
                // SAFETY: shapes and leading dimensions are those of the buffers.
                unsafe { $gesv(&3, &1, a.data.as_mut_ptr(), &int(a.lda), pivots.as_mut_ptr(), b.data.as_mut_ptr(), &int(b.lda), &mut info) };
                assert_eq!(info, 2);
                assert_eq!(b.at(2, 0), 1.0);
            }

            #[test]
            fn an_impossible_argument_is_named_or_changes_nothing() {
                let mut a = Strided::new(3, 3, |i, j| <$scalar>::from(u8::from(i == j)));
                let mut info = 77;
                // SAFETY: the arguments are refused before the buffer is reached.
                unsafe {
                    $potrf(&letter(b'X'), &3, a.data.as_mut_ptr(), &int(a.lda), &mut info);
                    assert_eq!(info, -1);
                    $potrf(&letter(b'L'), &-1, a.data.as_mut_ptr(), &int(a.lda), &mut info);
                    assert_eq!(info, -2);
                    $potrf(&letter(b'L'), &3, a.data.as_mut_ptr(), &2, &mut info);
                    assert_eq!(info, -4);
                }
                let mut c = a.clone();
                // SAFETY: the arguments are refused before the buffers are reached.
                unsafe {
                    $gemm(&letter(b'N'), &letter(b'?'), &3, &3, &3, &1.0, a.data.as_ptr(), &int(a.lda), a.data.as_ptr(), &int(a.lda), &0.0,
                          c.data.as_mut_ptr(), &int(c.lda));
                }
                assert_eq!(c.data, a.data);
            }

            #[test]
            fn what_is_not_finite_is_reported() {
                let mut a = Strided::new(5, 5, |i, j| if (i, j) == (3, 2) { <$scalar>::NAN } else { 1.0 });
                let (mut s, mut u, mut vt) = (vec![0.0; 5], vec![0.0; 25], vec![0.0; 25]);
                let (mut work, mut iwork, mut info, mut m) = (vec![0.0; 500], vec![0; 500], 77, 0);
                // SAFETY: shapes and leading dimensions are those of the buffers.
                unsafe {
                    $gesdd(&letter(b'S'), &5, &5, a.data.as_mut_ptr(), &int(a.lda), s.as_mut_ptr(), u.as_mut_ptr(), &5, vt.as_mut_ptr(), &5,
                           work.as_mut_ptr(), &500, iwork.as_mut_ptr(), &mut info);
                    assert_eq!(info, -4);
                    $syevr(&letter(b'V'), &letter(b'A'), &letter(b'L'), &5, a.data.as_mut_ptr(), &int(a.lda), &0.0, &0.0, &0, &0, &0.0, &mut m,
                           s.as_mut_ptr(), u.as_mut_ptr(), &5, iwork.as_mut_ptr(), work.as_mut_ptr(), &500, iwork.as_mut_ptr().add(10), &490, &mut info);
                    assert_eq!(info, 1);
                    $potrf(&letter(b'L'), &5, a.data.as_mut_ptr(), &int(a.lda), &mut info);
                    assert!(info > 0);
                }
                assert!(a.largest() == 1.0);
            }
        }
    };
}

suite!(single, f32, sgemm_, sgemv_, ssymv_, ssyrk_, ssyr2k_, spotrf_, spotrs_, ssyevr_, sgesdd_, sgesvd_, sgesv_);
suite!(double, f64, dgemm_, dgemv_, dsymv_, dsyrk_, dsyr2k_, dpotrf_, dpotrs_, dsyevr_, dgesdd_, dgesvd_, dgesv_);
