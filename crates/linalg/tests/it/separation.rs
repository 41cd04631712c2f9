//! Estimates of the separation of operators that are known.

use std::cell::Cell;

use luenberger_linalg::LinalgError;
use luenberger_linalg::internals::{
    Closest, ErrorScale, Regularity, contraction, forward_error, of_exact, refined, rescale, separation,
    separation_by_three,
};
use nalgebra::{Complex, DMatrix, dmatrix};

#[test]
fn the_estimate_is_exact_for_diagonal_operators_and_never_below_the_separation() {
    let d = dmatrix![4.0, -2.0; 0.5, 8.0];
    let solve = |x: &mut DMatrix<f64>| x.component_div_assign(&d);
    assert_eq!(separation(2, 2, solve, solve), 0.5);
    assert_eq!(separation_by_three(&mut DMatrix::zeros(2, 2), solve, solve), 0.5);
    assert_eq!(separation_by_three(&mut DMatrix::zeros(1, 1), |x| *x /= -4.0, |x| *x /= -4.0), 4.0);
    assert_eq!(separation_by_three(&mut DMatrix::zeros(0, 3), solve, solve), f64::INFINITY);
    // An overflow gives the separation zero.
    assert_eq!(separation_by_three(&mut DMatrix::zeros(2, 2), |x| x.fill(f64::NAN), solve), 0.0);
    // A full operator: X -> X M, whose inverse has the 1-norm of M^-1 transposed.
    let m = dmatrix![1.0, 2.0, 0.0; 0.0, 1.0, 3.0; -1.0, 0.0, 2.0];
    let inverse = m.clone().try_inverse().unwrap();
    let norm = inverse.row_iter().map(|r| r.lp_norm(1)).fold(0.0_f64, f64::max);
    let solve = |x: &mut DMatrix<f64>| *x = &*x * &inverse;
    let adjoint = |x: &mut DMatrix<f64>| *x = &*x * inverse.transpose();
    for found in [separation(2, 3, solve, adjoint), separation_by_three(&mut DMatrix::zeros(2, 3), solve, adjoint)] {
        assert!(found >= 1.0 / norm * (1.0 - 1e-14) && found <= 3.0 / norm, "{found} {}", 1.0 / norm);
    }
}

/// `X -> B vec X` for 300 random B of order 9: estimates of `|B|_1` are never above it, none is off by a factor of
/// three, and on average they are near to it.
#[test]
fn estimates_for_random_operators_are_near_the_norm() {
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / 2f64.powi(52) - 1.0
    };
    let (mut whole, mut three) = (Vec::new(), Vec::new());
    for _ in 0..300 {
        let b = DMatrix::from_fn(9, 9, |_, _| random());
        let norm = b.column_iter().map(|column| column.lp_norm(1)).fold(0.0_f64, f64::max);
        let apply = |b: &DMatrix<f64>, x: &mut DMatrix<f64>| {
            let image = b * DMatrix::from_column_slice(9, 1, x.as_slice());
            x.copy_from_slice(image.as_slice());
        };
        let solve = |x: &mut DMatrix<f64>| apply(&b, x);
        let adjoint = |x: &mut DMatrix<f64>| apply(&b.transpose(), x);
        whole.push(1.0 / separation(3, 3, solve, adjoint) / norm);
        three.push(1.0 / separation_by_three(&mut DMatrix::zeros(3, 3), solve, adjoint) / norm);
    }
    for (shares, average) in [(&whole, 0.85), (&three, 0.85)] {
        let mean = shares.iter().sum::<f64>() / 300.0;
        let (least, largest) = shares.iter().fold((1.0_f64, 0.0_f64), |(l, h), x| (l.min(*x), h.max(*x)));
        assert!(mean > average && least > 1.0 / 3.0 && largest <= 1.0 + 1e-14, "{mean} {least} {largest}");
    }
}

/// `e/|x|` of `|x - e|` at least: `b/(1 - b)`.
#[test]
fn an_error_relative_to_what_was_found_as_one_of_the_exact_solution() {
    assert_eq!([0.0, 0.2, 0.5, 0.75].map(of_exact), [0.0, 0.25, 1.0, 3.0]);
    assert_eq!([1.0, 2.0, f64::NAN].map(of_exact), [f64::INFINITY; 3]);
}

/// The inverse 1/100 on all entries: both starts, equal entries and alternating ones, have the norm themselves.
#[test]
fn every_start_is_exact_for_a_multiple_of_the_identity() {
    for factor in [0.01, 100.0] {
        let solve = |x: &mut DMatrix<f64>| *x *= factor;
        for found in [separation(2, 3, solve, solve), separation_by_three(&mut DMatrix::zeros(2, 3), solve, solve)] {
            assert!((found * factor - 1.0).abs() < 1e-15, "{found} for 1/{factor}");
        }
    }
}

/// Zero where one solution overflows, whichever it is.
#[test]
fn one_overflow_leaves_no_separation() {
    for last in [false, true] {
        let count = Cell::new(0);
        let solve = |x: &mut DMatrix<f64>| {
            count.set(count.get() + 1);
            if (count.get() == 1) != last {
                x.fill(f64::NAN);
            }
        };
        assert_eq!(separation_by_three(&mut DMatrix::zeros(2, 2), solve, |_| ()), 0.0, "{last}");
    }
}

/// m up/down, where m up or up/down is beyond the numbers: 2^(900 + 900 - 900), 2^(900 - 900 - 900).
#[test]
fn a_change_of_units_does_not_overflow_on_the_way() {
    let power = |k: i32| 2f64.powi(k);
    for (m, up, down, of) in
        [(900, 900, 900, 900), (-900, -900, -900, -900), (900, -900, 900, -900), (-900, 900, -900, 900), (5, 3, 1, 7)]
    {
        let mut x = DMatrix::from_element(1, 1, power(m));
        rescale(&mut x, power(up), power(down));
        assert_eq!(x[(0, 0)], power(of), "{m} {up} {down}");
    }
}

/// The substitution `S C = (1 - e) C` for the identity: each correction leaves the share e of an error.
#[test]
fn a_contraction_is_what_a_correction_leaves() {
    let of = |e: f64, symmetric: bool| {
        contraction((3, 3), symmetric, |c, x| {
            if symmetric {
                assert_eq!(*c, c.transpose());
                assert!(*c == DMatrix::zeros(3, 3) || c.upper_triangle() != DMatrix::from_diagonal(&c.diagonal()));
            }
            (c - x) * (1.0 - e)
        })
    };
    for symmetric in [false, true] {
        assert!((of(0.125, symmetric) - 0.125).abs() < 1e-14 && (of(0.2, symmetric) - 0.2).abs() < 1e-14);
        assert_eq!([of(0.5, symmetric), of(-2.0, symmetric), of(f64::NAN, symmetric)], [f64::INFINITY; 3]);
    }
}

/// From x = 1 by 1/8, then by 1/64, then by 1/100, which is more than half of the change before, relative to x each
/// time: the bound is `10 moved/(1 - rate) + n eps`.
#[test]
fn a_refinement_ends_at_the_correction_that_stays() {
    let run = |changes: &[f64], rate: f64| {
        let (mut x, mut left) = (DMatrix::from_element(1, 2, 1.0), changes.iter());
        let bound = refined(&mut x, rate, |_| DMatrix::from_element(1, 2, *left.next().unwrap()));
        (x[(0, 1)], bound)
    };
    let (x, bound) = run(&[0.125, 0.015625, 0.01], 0.2);
    let moved = 0.01 / 1.140625;
    assert_eq!(x, 1.140625);
    assert!((bound.unwrap() / (10.0 * moved / 0.8 + 2.0 * f64::EPSILON) - 1.0).abs() < 1e-14, "{bound:?}");
    // Not small at its end; as large as x; no number.
    assert_eq!([run(&[0.3, 0.4], 0.2).1, run(&[1.0], 0.2).1, run(&[f64::NAN], 0.2).1], [None; 3]);
}

/// log10(2e20 * 10) = 21.3: 22 digits are lost, three are to be left.
#[test]
fn the_digits_asked_for_leave_three() {
    let pole = Complex::new(1.0, 0.0);
    let closest = Closest { first: pole, second: -pole, gap: 0.0 };
    let error = closest.undecided("Sylvester", Regularity::Regular, 1e-20, 2e20, 10.0);
    let LinalgError::UndecidedEquation { digits, regular, .. } = error else { panic!("{error}") };
    assert_eq!((digits, regular), (Some(25), true));
}

/// A refined error of 1e-3 in units that may enlarge it eightfold: 0.008/(1 - 0.008).
#[test]
fn a_measured_error_grows_with_the_units() {
    let scale = ErrorScale { norms: 1.0, units: 8.0, refined: Some(1e-3) };
    assert!((forward_error(0.0, 1.0, 1, scale) - 0.008 / 0.992).abs() < 1e-17);
}
