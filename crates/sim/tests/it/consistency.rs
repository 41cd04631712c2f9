//! Normalised squares of errors by covariances of any rank, and their test.

use approx::assert_abs_diff_eq;
use luenberger_sim::replay::{Consistency, NormalisedSquare};
use nalgebra::{DMatrix, dmatrix, dvector};

fn of(e: [f64; 2], p: &DMatrix<f64>, x: [f64; 2]) -> NormalisedSquare {
    NormalisedSquare::of_error(&dvector![e[0], e[1]], p, &dvector![x[0], x[1]]).unwrap()
}

/// `e'P^-1 e`, and with the pseudo-inverse `[1 1; 1 1]/4` of a matrix of ones; a state of variance 0 counts for
/// nothing. Units of the states do not matter.
#[test]
fn the_square_of_an_error_by_its_covariance() {
    let zeros = [0.0; 2];
    for (e, p, square, degrees, is_outside) in [
        ([1.0, 2.0], dmatrix![4.0, 0.0; 0.0, 1.0], 4.25, 2, false),
        ([1.0, 0.0], dmatrix![2.0, 1.0; 1.0, 2.0], 2.0 / 3.0, 2, false),
        ([1.0, -3.0], dmatrix![2.0, 1.0; 1.0, 2.0], 26.0 / 3.0, 2, false),
        ([1.0, 1.0], dmatrix![1.0, 1.0; 1.0, 1.0], 1.0, 1, false),
        ([1.0, -1.0], dmatrix![1.0, 1.0; 1.0, 1.0], 0.0, 1, true),
        ([0.0, 2.0], dmatrix![0.0, 0.0; 0.0, 4.0], 1.0, 1, false),
        ([1e-3, 2.0], dmatrix![0.0, 0.0; 0.0, 4.0], 1.0, 1, true),
        ([0.0, 0.0], dmatrix![0.0, 0.0; 0.0, 0.0], 0.0, 0, false),
    ] {
        for unit in [1.0, 1e6, 1e-6] {
            let scaled = dmatrix![p[(0, 0)], p[(0, 1)] * unit; p[(1, 0)] * unit, p[(1, 1)] * unit * unit];
            let found = of([e[0], e[1] * unit], &scaled, zeros);
            assert_abs_diff_eq!(found.square, square, epsilon = 1e-12);
            assert_eq!((found.degrees, found.entries, found.is_outside), (degrees, 2, is_outside), "{e:?} {p} {unit}");
        }
    }
    let (e, p, x) = (dvector![f64::NAN], dmatrix![1.0], dvector![0.0]);
    assert_eq!(NormalisedSquare::of_error(&e, &p, &x), None);
    assert_eq!(NormalisedSquare::of_error(&x, &dmatrix![f64::INFINITY], &x), None);
}

/// Of a state without variance an error is rounding up to `sqrt(EPSILON)`, 1.5e-8, of the state.
#[test]
fn rounding_of_an_exact_state_is_no_error() {
    let p = dmatrix![0.0, 0.0; 0.0, 1.0];
    for (error, state, is_outside) in [(1e-8, 1.0, false), (-2e-8, 1.0, true), (1e-7, -10.0, false), (1e-9, 0.01, true)]
    {
        assert_eq!(of([error, 0.0], &p, [state, 0.0]).is_outside, is_outside, "{error} of {state}");
    }
}

/// scipy 1.17: `chi2.ppf([0.025, 0.975], 3)` is (0.215795282624, 9.348403604496), over two samples with three degrees
/// of freedom in all.
#[test]
fn squares_are_counted_by_what_they_are() {
    let full = of([1.0, 2.0], &dmatrix![4.0, 0.0; 0.0, 1.0], [0.0; 2]);
    let within = of([1.0, 1.0], &dmatrix![1.0, 1.0; 1.0, 1.0], [0.0; 2]);
    let outside = of([1.0, -1.0], &dmatrix![1.0, 1.0; 1.0, 1.0], [0.0; 2]);
    let none = of([0.0; 2], &DMatrix::zeros(2, 2), [0.0; 2]);
    let test = Consistency::of([Some(full), None, Some(within), Some(none), None]).unwrap();
    assert_eq!((test.samples, test.left_out, test.singular, test.outside), (2, 2, 2, 0));
    assert_eq!((test.mean, test.expected), (5.25 / 2.0, 1.5));
    assert_abs_diff_eq!(test.bounds.0, 0.215_795_282_624 / 2.0, epsilon = 1e-9);
    assert_abs_diff_eq!(test.bounds.1, 9.348_403_604_496 / 2.0, epsilon = 1e-9);
    assert!(test.accepted());
    let test = Consistency::of([Some(full), Some(outside)]).unwrap();
    assert_eq!((test.samples, test.singular, test.outside, test.accepted()), (2, 1, 1, false));
    let large = NormalisedSquare { square: 10.0, ..full };
    assert!(!Consistency::of([Some(large), Some(large)]).unwrap().accepted());
    assert_eq!(Consistency::of([]), None);
    // Nothing to test: no degree of freedom in any sample.
    let test = Consistency::of([Some(none), None]).unwrap();
    assert_eq!((test.mean, test.expected, test.bounds, test.samples), (0.0, 0.0, (0.0, 0.0), 0));
}
