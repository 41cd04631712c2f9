//! The four parts have the orders they were built with, in any coordinates, and the first alone makes the transfer
//! function.

use approx::assert_abs_diff_eq;
use luenberger_linalg::{KalmanDecomposition, LinalgError, kalman_decomposition};
use nalgebra::{Complex, DMatrix, dmatrix};
use proptest::prelude::*;

fn orders(found: &KalmanDecomposition) -> [usize; 4] {
    found.parts().map(|part| part.order)
}

/// `T^-1 A T` and the rest, against the arguments.
fn assert_similar(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>, found: &KalmanDecomposition, tolerance: f64) {
    let t = &found.transformation;
    let motion = (a * t - t * &found.a).norm() / (a.norm() * t.norm()).max(f64::MIN_POSITIVE);
    let drive = (b - t * &found.b).norm() / b.norm().max(f64::MIN_POSITIVE);
    let sight = (c * t - &found.c).norm() / (c.norm() * t.norm()).max(f64::MIN_POSITIVE);
    assert!(motion.max(drive).max(sight) <= tolerance, "{motion:e} {drive:e} {sight:e}");
    assert!(found.residual <= tolerance, "{:e}", found.residual);
    let part = found.parts();
    for (row, column) in [(0, 1), (0, 3), (2, 0), (2, 1), (2, 3), (3, 0), (3, 1)] {
        let block = found.a.view((part[row].start, part[column].start), (part[row].order, part[column].order));
        assert!(block.iter().all(|x| *x == 0.0));
    }
}

/// SLICOT AB01ND's plant: the inputs move two of its three states, with the eigenvalues -3, -1; all are seen by its
/// first and third states.
#[test]
fn the_plant_of_slicot_ab01nd() {
    let a = dmatrix![-1.0, 0.0, 0.0; -2.0, -2.0, -2.0; -1.0, 0.0, -3.0];
    let b = dmatrix![1.0, 0.0; 0.0, 2.0; 0.0, 1.0];
    let found = kalman_decomposition(&a, &b, &DMatrix::identity(3, 3)).unwrap();
    assert_eq!(orders(&found), [2, 0, 1, 0]);
    let mut moved: Vec<f64> = found.controllable_observable.eigenvalues.iter().map(|x| x.re).collect();
    moved.sort_by(f64::total_cmp);
    assert!((moved[0] + 3.0).abs() < 1e-13 && (moved[1] + 1.0).abs() < 1e-13, "{moved:?}");
    assert!((found.uncontrollable_observable.eigenvalues[0] + 2.0).norm() < 1e-13);
    assert_similar(&a, &b, &DMatrix::identity(3, 3), &found, 1e-14);
}

/// SLICOT TB01PD, example program: `A = [1 2 0; 4 -1 0; 0 0 1], B = [1; 0; 1], C = [0 1 -1; 0 0 1]` is minimal, and is
/// printed with order 3.
#[test]
fn the_example_of_slicot_tb01pd() {
    let a = dmatrix![1.0, 2.0, 0.0; 4.0, -1.0, 0.0; 0.0, 0.0, 1.0];
    let (b, c) = (dmatrix![1.0; 0.0; 1.0], dmatrix![0.0, 1.0, -1.0; 0.0, 0.0, 1.0]);
    let found = kalman_decomposition(&a, &b, &c).unwrap();
    assert_eq!(orders(&found), [3, 0, 0, 0]);
    assert_abs_diff_eq!(found.condition, 1.0, epsilon = 1e-14);
    assert_similar(&a, &b, &c, &found, 1e-14);
}

#[test]
fn the_extremes() {
    let a = dmatrix![0.0, 1.0; -2.0, -3.0];
    let zero = kalman_decomposition(&a, &DMatrix::zeros(2, 1), &DMatrix::zeros(1, 2)).unwrap();
    assert_eq!(orders(&zero), [0, 0, 0, 2]);
    let none = kalman_decomposition(&a, &DMatrix::zeros(2, 0), &DMatrix::zeros(0, 2)).unwrap();
    assert_eq!(orders(&none), [0, 0, 0, 2]);
    let blind = kalman_decomposition(&a, &dmatrix![0.0; 1.0], &DMatrix::zeros(0, 2)).unwrap();
    assert_eq!(orders(&blind), [0, 2, 0, 0]);
    let driven = kalman_decomposition(&a, &DMatrix::zeros(2, 0), &dmatrix![1.0, 0.0]).unwrap();
    assert_eq!(orders(&driven), [0, 0, 2, 0]);
    let one = kalman_decomposition(&dmatrix![3.0], &dmatrix![1e-12], &dmatrix![1e12]).unwrap();
    assert_eq!(orders(&one), [1, 0, 0, 0]);
    let (am, bm, cm) = one.minimal();
    assert!((am[0] - 3.0).abs() < 1e-15 && (bm[0] * cm[0] - 1.0).abs() < 1e-15);
    // The same eigenvalue in two parts: moved and seen, neither.
    let twice =
        kalman_decomposition(&(DMatrix::identity(2, 2) * -1.0), &dmatrix![1.0; 0.0], &dmatrix![1.0, 0.0]).unwrap();
    assert_eq!(orders(&twice), [1, 0, 0, 1]);
}

#[test]
fn bad_input_is_named() {
    let (a, b, c) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]);
    assert!(matches!(kalman_decomposition(&c, &b, &c), Err(LinalgError::NotSquare { what: "A", .. })));
    assert!(matches!(kalman_decomposition(&a, &c, &c), Err(LinalgError::DimensionMismatch { what: "B", .. })));
    assert!(matches!(kalman_decomposition(&a, &b, &b), Err(LinalgError::DimensionMismatch { what: "C", .. })));
    assert!(matches!(kalman_decomposition(&a, &(b * f64::NAN), &c), Err(LinalgError::NotFinite { what: "B", .. })));
    let empty = DMatrix::zeros(0, 0);
    let none = kalman_decomposition(&empty, &DMatrix::zeros(0, 1), &DMatrix::zeros(1, 0));
    assert_eq!(none.unwrap_err(), LinalgError::Empty { what: "A" });
}

#[derive(Debug, Clone)]
struct Built {
    orders: [usize; 4],
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    units: Vec<i32>,
}

/// Kalman's form with parts of these orders (within each part of the first three every state drives the one before it,
/// the first is seen and the last is moved), turned by two reflections.
fn built(orders: impl Strategy<Value = [usize; 4]>) -> impl Strategy<Value = Built> {
    orders.prop_flat_map(|orders| {
        let n: usize = orders.iter().sum();
        (
            prop::collection::vec(-1.0..1.0_f64, n * n + 2 * n),
            prop::collection::vec(-1.0..1.0_f64, n),
            prop::collection::vec(-30..=30_i32, n),
        )
            .prop_map(move |(x, v, units)| {
                let part: Vec<usize> = (0..4).flat_map(|k| vec![k; orders[k]]).collect();
                let allowed =
                    |i: usize, j: usize| !matches!((part[i], part[j]), (0, 1 | 3) | (2, 0 | 1 | 3) | (3, 0 | 1));
                let (first, last) =
                    (|i: usize| i == 0 || part[i - 1] != part[i], |i: usize| i + 1 == n || part[i + 1] != part[i]);
                let a = DMatrix::from_fn(n, n, |i, j| match x[i * n + j] {
                    // The parts have spectra of their own, 10 apart: that keeps them far from exchanging modes.
                    free if i == j => 0.3 * free - 10.0 * part[i] as f64,
                    free if part[i] == part[j] && j == i + 1 => 1.5 + 0.5 * free,
                    free if part[i] == part[j] => {
                        if i > j {
                            0.2 * free
                        } else {
                            0.0
                        }
                    }
                    free => {
                        if allowed(i, j) {
                            0.3 * free
                        } else {
                            0.0
                        }
                    }
                });
                let b = DMatrix::from_fn(n, 1, |i, _| if part[i] < 2 && last(i) { 1.5 + x[n * n + i] } else { 0.0 });
                let c = DMatrix::from_fn(1, n, |_, i| {
                    if matches!(part[i], 0 | 2) && first(i) { 1.5 + x[n * n + n + i] } else { 0.0 }
                });
                // The reflection I - 2 v v'/|v|^2 turns every state: its entries are at least a hundredth. (Those of
                // `rounding_of_coordinates_that_are_hardly_turned_counts` are not.) With others between 1 and 2, the
                // square of the first is twice to four times the sum of theirs.
                let mut v = nalgebra::DVector::from_fn(n, |i, _| v[i] + if v[i] < 0.0 { -1.0 } else { 1.0 });
                let (first, others) = (v[0], v.rows_range(1..).norm());
                v[0] = if n == 1 { 1.0 } else { others * (3.0 + first.abs() - 1.5).clamp(2.0, 4.0).sqrt() };
                let q = DMatrix::identity(n, n) - &v * v.transpose() * (2.0 / v.norm_squared());
                Built { orders, a: &q * a * &q, b: &q * b, c: c * &q, units }
            })
    })
}

/// Any orders up to 2, not all zero.
fn four_parts() -> impl Strategy<Value = [usize; 4]> {
    (0..81_usize).prop_map(|k| if k == 0 { [1, 0, 0, 0] } else { [k % 3, k / 3 % 3, k / 9 % 3, k / 27] })
}

/// One part alone, of up to four states.
fn one_part() -> impl Strategy<Value = [usize; 4]> {
    (0..4_usize, 1..=4_usize).prop_map(|(k, order)| core::array::from_fn(|i| if i == k { order } else { 0 }))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Kalman 1963: the orders of the parts do not depend on the coordinates, and `C (s I - A)^-1 B` is that of the
    /// first part.
    #[test]
    fn the_parts_are_found_in_any_coordinates(p in built(four_parts())) {
        let found = kalman_decomposition(&p.a, &p.b, &p.c).unwrap();
        prop_assert_eq!(orders(&found), p.orders);
        assert_similar(&p.a, &p.b, &p.c, &found, 1e-11);
        for (k, part) in found.parts().iter().enumerate() {
            for x in &part.eigenvalues {
                prop_assert!((x.re + 10.0 * k as f64).abs() < 5.0, "{x} in part {k}");
            }
        }
        let (am, bm, cm) = found.minimal();
        let transfer = |a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>, s: Complex<f64>| {
            let n = a.nrows();
            let shifted = DMatrix::identity(n, n) * s - a.map(Complex::from);
            (c.map(Complex::from) * shifted.lu().solve(&b.map(Complex::from)).unwrap())[(0, 0)]
        };
        for s in [Complex::new(7.0, 0.0), Complex::new(0.5, 9.0), Complex::new(-15.0, 8.0)] {
            let (whole, least) = (transfer(&p.a, &p.b, &p.c, s), if p.orders[0] == 0 { Complex::from(0.0) } else { transfer(&am, &bm, &cm, s) });
            prop_assert!((whole - least).norm() < 1e-11 * (1.0 + whole.norm()), "{whole} {least} at {s}");
        }
    }

    /// A seen and a moved part, turned by an angle t. From a hundredth on they are found; below that the units make
    /// entries of the size t as large as the others, the rounding of the coordinates with them, and the parts may be
    /// found coupled: by no more than that, since `C (s I - A)^-1 B` stays zero.
    #[test]
    fn rounding_of_coordinates_that_are_hardly_turned_counts(t in -8.0..0.0_f64, b in 1.0..3.0_f64, c in 1.0..3.0_f64) {
        let t = 10f64.powf(t);
        let q = dmatrix![t.cos(), -t.sin(); t.sin(), t.cos()];
        let a = &q * dmatrix![-10.0, 0.0; 0.0, -20.0] * q.transpose();
        let (b, c) = (&q * dmatrix![b; 0.0], dmatrix![0.0, c] * q.transpose());
        let found = kalman_decomposition(&a, &b, &c).unwrap();
        let is_coupled = orders(&found) == [2, 0, 0, 0] && t < 0.01;
        prop_assert!(is_coupled || orders(&found) == [0, 1, 1, 0], "{t:e}: {:?}", orders(&found));
        if is_coupled {
            let (a, b, c) = found.minimal();
            let response = c * (DMatrix::identity(2, 2) * 3.0 - a).lu().solve(&b).unwrap();
            prop_assert!(response[0].abs() < 1e-14, "{t:e}: {response}");
        }
    }

    /// States in units up to 18 decades apart: the same orders. One part only, because reflected coordinates of several
    /// have rounding where there should be zeros, and too much of it to be outvoted once the units differ.
    #[test]
    fn units_change_nothing(p in built(one_part())) {
        let n = p.a.nrows();
        let d = |k: usize| 2f64.powi(p.units[k]);
        let a = DMatrix::from_fn(n, n, |i, j| p.a[(i, j)] * d(j) / d(i));
        let b = DMatrix::from_fn(n, 1, |i, _| p.b[i] / d(i));
        let c = DMatrix::from_fn(1, n, |_, j| p.c[j] * d(j));
        prop_assert_eq!(orders(&kalman_decomposition(&a, &b, &c).unwrap()), p.orders);
    }
}
