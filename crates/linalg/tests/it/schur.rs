//! The real Schur form: backward error, orthogonality, standard blocks, and the matrices on which QR iterations stall.

use crate::small_matrices;

use luenberger_linalg::{LinalgError, Schur, SchurWorkspace, balanced, eigenvalues, schur, schur_into};
use luenberger_random::Random;
use nalgebra::{Complex, DMatrix, dmatrix};
use proptest::prelude::*;

/// Householder reductions and a few sweeps per eigenvalue, each committing a small multiple of `eps` in norm: the
/// backward error grows like `n eps`; 20 covers the constants (LAPACK's own tests allow 30).
fn bound(n: usize) -> f64 {
    20.0 * n.max(1) as f64 * f64::EPSILON
}

fn check(a: &DMatrix<f64>, s: &Schur) {
    let n = a.nrows();
    let (scale, identity) = (a.amax().max(f64::MIN_POSITIVE), DMatrix::<f64>::identity(n, n));
    // In units of the largest entry, so that the norms neither overflow nor underflow.
    let (a, t) = (a / scale, &s.t / scale);
    let backward = (&s.q * &t * s.q.transpose() - &a).norm();
    assert!(backward <= bound(n) * a.norm(), "backward error {backward:e}");
    let orthogonality = (s.q.transpose() * &s.q - identity).norm();
    assert!(orthogonality <= 2.5 * bound(n), "orthogonality {orthogonality:e}");
    for j in 0..n {
        for i in j + 2..n {
            assert_eq!(s.t[(i, j)], 0.0);
        }
    }
    let mut k = 0;
    while k + 1 < n {
        if s.t[(k + 1, k)] == 0.0 {
            k += 1;
            continue;
        }
        assert_eq!(s.t[(k, k)], s.t[(k + 1, k + 1)], "block at {k}");
        assert!(s.t[(k, k + 1)] * s.t[(k + 1, k)].signum() < 0.0, "block at {k}");
        assert!(k + 2 >= n || s.t[(k + 2, k + 1)] == 0.0, "blocks at {k} overlap");
        k += 2;
    }
    assert_eq!(s.eigenvalues().len(), n);
}

fn checked(a: &DMatrix<f64>) -> Schur {
    let s = schur(a).unwrap();
    check(a, &s);
    s
}

fn cyclic(n: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == (j + 1) % n)))
}

#[test]
fn cyclic_permutations_have_the_roots_of_unity() {
    for n in [2, 3, 8, 9, 16, 32, 64, 100, 128, 256] {
        for l in checked(&cyclic(n)).eigenvalues() {
            assert!((l.norm() - 1.0).abs() <= bound(n));
            let power = l.powu(n as u32);
            assert!((power - Complex::new(1.0, 0.0)).norm() <= n as f64 * bound(n), "{l} ^ {n} = {power}");
        }
    }
}

#[test]
fn matrices_on_which_other_iterations_do_not_end() {
    let shift = dmatrix![0.0, 0.0, 0.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0];
    assert!(checked(&shift).eigenvalues().iter().all(|l| l.norm() <= bound(3).cbrt()));
    checked(&dmatrix![0.0, -1.0, 0.0; -3.0, -3.0, 1.0; 0.0, 3.0, 0.0]);
    // Batterman and Day's family: the double shift without exception cycles on it.
    for h in [0.0, 1e-8, 1e-3, 0.5] {
        checked(&dmatrix![0.0, 1.0, 0.0, 0.0; 1.0, 0.0, -h, 0.0; 0.0, h, 0.0, 1.0; 0.0, 0.0, 1.0, 0.0]);
    }
    checked(&dmatrix![0.0, 0.0, 0.0, 1.0; 1.0, 0.0, 0.0, 0.0; 0.0, 1.0, 0.0, 0.0; 0.0, 0.0, 1.0, 0.0]);
}

#[test]
fn companions_of_powers_and_jordan_blocks() {
    for n in [1, 2, 5, 16, 33] {
        // The companion matrix of x^n, both ways round: nilpotent.
        let lower = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j + 1)));
        for a in [lower.transpose(), lower.clone()] {
            let s = checked(&a);
            assert!(s.eigenvalues().iter().all(|l| l.norm() <= bound(n).powf(1.0 / n as f64)));
        }
        // Jordan blocks, transposed so that the reduction has work to do.
        for lambda in [-1.0, 1e-8, 0.0] {
            checked(&(DMatrix::identity(n, n) * lambda + &lower));
        }
    }
    // Derogatory: two Jordan blocks of one eigenvalue, hidden by an orthogonal similarity.
    let mut j = DMatrix::<f64>::identity(6, 6) * -2.0;
    (j[(0, 1)], j[(1, 2)], j[(3, 4)]) = (1.0, 1.0, 1.0);
    let q = DMatrix::from_fn(6, 6, |i, k| f64::from(u8::from(i == k)) - 2.0 / 6.0);
    checked(&(&q * j * &q));
}

#[test]
fn entries_of_any_size() {
    for scale in [1e-300, 1e-150, 1e150, 1e300] {
        let a = dmatrix![1.0, 2.0, 3.0; -4.0, 5.0, 6.0; 7.0, -8.0, 9.0];
        let reference = schur(&a).unwrap().eigenvalues();
        let scaled = checked(&(a * scale)).eigenvalues();
        for (x, y) in reference.iter().zip(scaled) {
            assert!((x - Complex::new(y.re / scale, y.im / scale)).norm() <= bound(3) * 20.0);
        }
    }
    // Graded over 300 decades.
    let n = 7;
    let graded = |step: f64| {
        DMatrix::from_fn(n, n, |i, j| {
            let entry = 1.0 + ((3 * i + 5 * j) % 7) as f64;
            entry * 10.0_f64.powf(step * ((i + j) as f64 - 6.0))
        })
    };
    for step in [-25.0, -2.0, 2.0, 25.0] {
        checked(&graded(step));
    }
    let subnormal = DMatrix::from_element(3, 3, 5e-324);
    assert!(schur(&subnormal).is_ok());
}

#[test]
fn small_eigenvalues_of_a_graded_matrix_keep_their_digits() {
    // Ahues and Tisseur's test must not deflate the small entries of a matrix graded downwards too early.
    let a = dmatrix![1.0, 1e-6, 0.0; 1e-6, 1e-12, 1e-18; 0.0, 1e-18, 4e-24];
    let smallest = eigenvalues(&a).unwrap().iter().map(|l| l.norm()).fold(f64::MAX, f64::min);
    // det = -1e-36, and the middle pivot 1e-12 - 1e-12 vanishes: the two small eigenvalues are +-1e-18.
    assert!(smallest <= 2e-18, "{smallest:e}");
}

#[test]
fn orders_zero_and_one() {
    assert_eq!(schur(&DMatrix::zeros(0, 0)).unwrap().eigenvalues(), vec![]);
    let one = checked(&dmatrix![-3.0]);
    assert_eq!(one.eigenvalues(), vec![Complex::new(-3.0, 0.0)]);
    checked(&DMatrix::zeros(5, 5));
}

#[test]
fn bad_input_is_named() {
    assert_eq!(schur(&DMatrix::zeros(2, 3)), Err(LinalgError::NotSquare { what: "A", rows: 2, cols: 3 }));
    let mut a = DMatrix::<f64>::identity(3, 3);
    a[(2, 1)] = f64::INFINITY;
    assert_eq!(schur(&a), Err(LinalgError::NotFinite { what: "A", row: 2, col: 1, value: f64::INFINITY }));
    a[(2, 1)] = f64::NAN;
    assert!(matches!(schur(&a), Err(LinalgError::NotFinite { row: 2, col: 1, .. })));
}

/// Real matrices: dense, of small integers (many multiple eigenvalues), and badly scaled.
fn matrix(orders: core::ops::RangeInclusive<usize>) -> impl Strategy<Value = DMatrix<f64>> {
    let entry = prop_oneof![
        3 => (-10.0..10.0_f64).boxed(),
        1 => (-1..=1_i32).prop_map(f64::from).boxed(),
    ];
    let decade = prop_oneof![Just(0.0), -12.0..=12.0_f64];
    (orders, decade).prop_flat_map(move |(n, decade)| {
        prop::collection::vec(entry.clone(), n * n).prop_map(move |data| {
            DMatrix::from_fn(n, n, |i, j| {
                data[i * n + j] * 10.0_f64.powf((decade * (i as f64 - j as f64) / n as f64).round())
            })
        })
    })
}

fn integer_matrix() -> impl Strategy<Value = DMatrix<f64>> {
    (1..=9_usize).prop_flat_map(|n| {
        prop::collection::vec((-1..=1_i32).prop_map(f64::from), n * n)
            .prop_map(move |data| DMatrix::from_row_slice(n, n, &data))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Every real matrix is orthogonally similar to a quasi-triangular one, and keeps its trace and determinant.
    #[test]
    fn every_matrix_has_a_schur_form(a in prop_oneof![matrix(1..=12), integer_matrix()]) {
        let n = a.nrows();
        let s = checked(&a);
        let values = s.eigenvalues();
        let sum: Complex<f64> = values.iter().sum();
        prop_assert!((sum.re - a.trace()).abs() <= n as f64 * bound(n) * a.norm());
        prop_assert!(sum.im == 0.0);
        // |det(A + E) - det A| <= ((1 + eps)^n - 1) ||A||^n for ||E|| <= eps ||A||, by Hadamard's inequality.
        let product: Complex<f64> = values.iter().product();
        let determinant = a.clone().lu().determinant();
        prop_assert!((product.re - determinant).abs() <= n as f64 * bound(n) * a.norm().powf(n as f64));
    }

    /// The eigenvalues that are selected come first, and their invariant subspace with them.
    #[test]
    fn any_selection_can_be_brought_to_the_top(a in matrix(1..=9), threshold in -1.0..1.0_f64) {
        let s = checked(&a);
        let wanted = s.eigenvalues().iter().filter(|l| l.re < threshold).count();
        let n = a.nrows();
        match s.ordered(|l| l.re < threshold) {
            Ok((ordered, k)) => {
                prop_assert_eq!(k, wanted);
                let scale = a.norm().max(f64::MIN_POSITIVE);
                let back = (&ordered.q * &ordered.t * ordered.q.transpose() - &a).norm();
                // Up to n^2/4 exchanges, each with its own rounding.
                prop_assert!(back <= n as f64 * bound(n) * scale, "{back:e}");
                prop_assert!(k == n || k == 0 || ordered.t[(k, k - 1)] == 0.0);
            }
            Err(LinalgError::SwapRejected { .. }) => {}
            Err(other) => prop_assert!(false, "{other}"),
        }
    }
}

#[test]
fn ordering_separates_the_stable_from_the_unstable() {
    // Complex pairs on both sides, so that 2 x 2 blocks pass 2 x 2 blocks.
    let mut t = DMatrix::<f64>::from_fn(6, 6, |i, j| if i <= j { 1.0 + (i + j) as f64 } else { 0.0 });
    for (k, (re, im)) in [(3.0, 2.0), (-1.0, 5.0), (4.0, 1.0)].into_iter().enumerate() {
        let k = 2 * k;
        (t[(k, k)], t[(k + 1, k + 1)], t[(k, k + 1)], t[(k + 1, k)]) = (re, re, im, -im);
    }
    let w = DMatrix::from_fn(6, 6, |i, j| f64::from(u8::from(i == j)) - 2.0 / 6.0);
    let a = &w * t * &w;
    let (s, k) = checked(&a).ordered(|l| l.re < 0.0).unwrap();
    check(&a, &s);
    assert_eq!(k, 2);
    let first = s.eigenvalues()[0];
    assert!((first - Complex::new(-1.0, 5.0)).norm() <= 50.0 * bound(6), "{first}");
}

/// Normal, with known eigenvalues: complex pairs and real numbers on the diagonal, and two reflections.
fn normal(n: usize, seed: u64) -> (DMatrix<f64>, Vec<Complex<f64>>) {
    let mut random = Random(seed);
    let mut d = DMatrix::zeros(n, n);
    let mut values = Vec::with_capacity(n);
    while values.len() < n {
        let k = values.len();
        let (re, im) = (random.unit(), random.unit());
        d[(k, k)] = re;
        if k + 1 < n && random.below(2) == 0 {
            (d[(k + 1, k + 1)], d[(k, k + 1)], d[(k + 1, k)]) = (re, im, -im);
            values.extend([Complex::new(re, im), Complex::new(re, -im)]);
        } else {
            values.push(Complex::new(re, 0.0));
        }
    }
    for _ in 0..2 {
        let v = DMatrix::from_fn(n, 1, |_, _| random.unit());
        let w = DMatrix::identity(n, n) - &v * v.transpose() * (2.0 / v.norm_squared());
        d = &w * d * &w;
    }
    (d, values)
}

#[test]
fn eigenvalues_of_normal_matrices_are_as_good_as_the_backward_error() {
    // Bauer and Fike: an eigenvalue of a normal matrix moves by no more than the perturbation. Orders on every path,
    // and those at which other iterations stall.
    for n in [1, 2, 5, 12, 17, 40, 75, 76, 77, 83, 90, 99, 100, 101, 200] {
        let (a, known) = normal(n, n as u64);
        let allowed = 2.0 * bound(n) * a.norm();
        for found in [checked(&a).eigenvalues(), eigenvalues(&a).unwrap()] {
            assert_eq!(found.len(), n);
            let mut left = known.clone();
            for l in found {
                let distance = |x: &Complex<f64>| (x - l).norm();
                let nearest =
                    (0..left.len()).min_by(|&i, &j| distance(&left[i]).total_cmp(&distance(&left[j]))).unwrap();
                assert!(distance(&left.swap_remove(nearest)) <= allowed, "order {n}: {l}");
            }
        }
    }
}

#[test]
fn adversaries_of_all_orders() {
    for n in [8, 20, 33, 64, 90, 128] {
        let x = |i: usize| i as f64;
        let unit = |b: bool| f64::from(u8::from(b));
        // Wilkinson's polynomial (x - 1) ... (x - 20) scaled to the order, through its coefficients.
        let mut wilkinson = vec![1.0];
        for root in 1..=n {
            let root = x(root) / x(n);
            let shifted: Vec<f64> = wilkinson.iter().map(|c| -root * c).collect();
            wilkinson.push(0.0);
            wilkinson.iter_mut().skip(1).zip(shifted).for_each(|(c, s)| *c += s);
        }
        let mut random = Random(n as u64);
        let half = n / 2;
        let f = DMatrix::from_fn(half, half, |_, _| random.unit());
        let g = DMatrix::from_fn(half, half, |i, j| 1.0 / (1.0 + x(i + j)));
        let hamiltonian = DMatrix::from_fn(2 * half, 2 * half, |i, j| match (i < half, j < half) {
            (true, true) => f[(i, j)],
            (true, false) => -g[(i, j - half)],
            (false, true) => -g[(i - half, j)],
            (false, false) => -f[(j - half, i - half)],
        });
        let dense = DMatrix::from_fn(n, n, |_, _| random.unit());
        let graded = |step: f64| {
            let dense = &dense;
            DMatrix::from_fn(n, n, |i, j| dense[(i, j)] * 10.0_f64.powf(step * (x(i + j) / x(2 * n - 2) - 0.5)))
        };
        let cases = [
            ("Wilkinson", DMatrix::from_fn(n, n, |i, j| if i == 0 { -wilkinson[j + 1] } else { unit(i == j + 1) })),
            ("power", DMatrix::from_fn(n, n, |i, j| unit(i == j + 1))),
            ("Jordan", DMatrix::from_fn(n, n, |i, j| if i == j { 2.0 } else { unit(i == j + 1) })),
            ("nilpotent", DMatrix::from_fn(n, n, |i, j| if i > j { dense[(i, j)] } else { 0.0 })),
            ("derogatory", DMatrix::from_fn(n, n, |i, j| if i == j { -1.0 } else { unit(i == j + 1 && i % 3 != 0) })),
            ("Hamiltonian", hamiltonian),
            ("ones", DMatrix::from_element(n, n, 1.0)),
            ("zero", DMatrix::zeros(n, n)),
            ("identity", DMatrix::identity(n, n)),
            ("graded down", graded(-300.0)),
            ("graded up", graded(300.0)),
            ("graded little", graded(-20.0)),
            ("badly scaled", DMatrix::from_fn(n, n, |i, j| dense[(i, j)] * 10.0_f64.powf(x(i % 13) - x(j % 13)))),
            ("huge", &dense * 1e300),
            ("tiny", &dense * 1e-300),
            ("orthogonal", DMatrix::from_fn(n, n, |i, j| unit(i == j) - 2.0 / x(n))),
            ("Grcar", DMatrix::from_fn(n, n, |i, j| if i == j + 1 { -1.0 } else { unit(i <= j && j <= i + 3) })),
            ("Frank", DMatrix::from_fn(n, n, |i, j| if i > j + 1 { 0.0 } else { x(n - i.max(j)) })),
        ];
        let (mut found, mut workspace) = (Schur::default(), SchurWorkspace::new());
        for (name, a) in cases {
            schur_into(&a, &mut found, &mut workspace).unwrap_or_else(|e| panic!("{name}, order {n}: {e}"));
            check(&a, &found);
            assert_eq!(eigenvalues(&a).unwrap_or_else(|e| panic!("{name}, order {n}: {e}")).len(), a.nrows());
        }
    }
}

#[test]
fn a_sample_of_small_random_matrices() {
    // The example `stress_schur` does a million.
    let mut random = Random(2);
    let (mut found, mut workspace) = (Schur::default(), SchurWorkspace::new());
    for _ in 0..5000 {
        let n = 1 + random.below(8);
        let a = small_matrices::matrix(&mut random, n);
        schur_into(&a, &mut found, &mut workspace).unwrap();
        check(&a, &found);
    }
}

#[test]
fn a_workspace_forgets_what_it_was_used_for() {
    // Small after large, large after an error: the same numbers as from a fresh one.
    let mut random = Random(3);
    let (mut found, mut workspace, mut values) = (Schur::default(), SchurWorkspace::new(), Vec::new());
    for n in [120, 7, 80, 0, 120, 5, 1] {
        let a = DMatrix::from_fn(n, n, |_, _| random.unit());
        schur_into(&a, &mut found, &mut workspace).unwrap();
        assert_eq!(found, schur(&a).unwrap());
        workspace.eigenvalues(&a, &mut values).unwrap();
        assert_eq!(values, eigenvalues(&a).unwrap());
        let bad = DMatrix::from_element(n + 1, n + 1, f64::NAN);
        assert!(matches!(schur_into(&bad, &mut found, &mut workspace), Err(LinalgError::NotFinite { .. })));
        assert!(matches!(workspace.eigenvalues(&bad, &mut values), Err(LinalgError::NotFinite { .. })));
    }
}

#[test]
fn balancing_saves_the_eigenvalues_of_a_badly_scaled_matrix() {
    let n = 10;
    let (a, known) = normal(n, 5);
    let scaled = DMatrix::from_fn(n, n, |i, j| a[(i, j)] * 512.0_f64.powf(i as f64 - j as f64));
    let b = balanced(&scaled).unwrap();
    for l in eigenvalues(&b.matrix).unwrap() {
        let error = known.iter().map(|x| (x - l).norm()).fold(f64::MAX, f64::min);
        // The balanced matrix is nearly the normal one: its rows and columns have comparable norms, and its eigenvalues
        // a condition of a few.
        assert!(error <= 10.0 * bound(n) * a.norm(), "{error:e}");
    }
}
