//! Poles land where they are asked for, as exactly as their condition allows; what cannot be placed is named.

use approx::assert_abs_diff_eq;
use approx::assert_relative_eq;
use luenberger_linalg::{LinalgError, Placement, eigenvalues, observability, place, place_observer};
use nalgebra::{Complex, DMatrix, DVector, dmatrix};
use proptest::prelude::*;

fn c(re: f64, im: f64) -> Complex<f64> {
    Complex::new(re, im)
}

fn real(poles: &[f64]) -> Vec<Complex<f64>> {
    poles.iter().map(|x| Complex::from(*x)).collect()
}

/// Bauer and Fike: the closed loop is off by a few n eps of its terms, and cond(X) is what that can do to the poles.
fn assert_placed(placed: &Placement, requested: &[Complex<f64>], terms: f64) {
    let n = requested.len() as f64;
    let bound = 20.0 * n * f64::EPSILON * placed.condition * terms;
    for (achieved, requested) in placed.poles.iter().zip(requested) {
        let off = (achieved - requested).norm();
        assert!(
            off <= bound,
            "{achieved} for {requested}: off by {off:e}, allowed {bound:e} at condition {:e}",
            placed.condition
        );
    }
}

fn observer_terms(a: &DMatrix<f64>, c: &DMatrix<f64>, placed: &Placement) -> f64 {
    a.norm() + placed.gain.norm() * c.norm()
}

/// Example 2 of Share Pasand's cubic observer: A 3x3, C = [1 1 2], poles -30, -10, -5. The gain from the coefficients
/// of the characteristic polynomial: with one output it is unique.
#[test]
fn the_third_order_example() {
    let a = dmatrix![-0.1, -0.2, 0.0; 0.3, 0.0, 0.0; 0.1, 0.2, -3.0];
    let c = dmatrix![1.0, 1.0, 2.0];
    let requested = real(&[-30.0, -10.0, -5.0]);
    let placed = place_observer(&a, &c, &requested).unwrap();
    // Ackermann in this small case: L = phi(A) O^-1 e3.
    let one = DMatrix::identity(3, 3);
    let phi = (&a + &one * 30.0) * (&a + &one * 10.0) * (&a + &one * 5.0);
    let mut o = DMatrix::zeros(3, 3);
    for k in 0..3 {
        o.set_row(k, &(&c * a.pow(k as u32)).row(0));
    }
    let expected = phi * o.lu().solve(&dmatrix![0.0; 0.0; 1.0]).unwrap();
    assert!((&placed.gain - &expected).norm() < 1e-11 * expected.norm(), "{} for {expected}", placed.gain);
    assert_placed(&placed, &requested, observer_terms(&a, &c, &placed));
    assert!(placed.deviation < 1e-10);
}

#[test]
fn the_double_integrator_by_hand() {
    let placed = place_observer(&dmatrix![0.0, 1.0; 0.0, 0.0], &dmatrix![1.0, 0.0], &real(&[-2.0, -5.0])).unwrap();
    assert!((placed.gain - dmatrix![7.0; 10.0]).norm() < 1e-14);
    // A - L C = [-7 1; -10 0] has the eigenvectors (1, 5) and (1, 2).
    let cosine: f64 = 11.0 / (26.0f64 * 5.0).sqrt();
    let expected = ((1.0 + cosine) / (1.0 - cosine)).sqrt();
    assert_relative_eq!(placed.condition, expected, max_relative = 1e-10);
    // Each of two eigenvectors at that angle has the condition 1/sin.
    let sine = (1.0 - cosine * cosine).sqrt();
    for (sensitivity, error) in placed.sensitivities.iter().zip(&placed.errors) {
        assert!((sensitivity * sine - 1.0).abs() < 1e-10 && *error < 1e-14, "{sensitivity} {error:e}");
    }
    assert_eq!(placed.poles.len(), 2);
    assert!(
        (placed.poles[0] + 2.0).norm() < 1e-14 && (placed.poles[1] + 5.0).norm() < 1e-14,
        "the order of the request"
    );
}

/// SLICOT SB01BD, example data: n = 4, m = 2. The routine moves two eigenvalues only; here all four go where it was
/// asked to move them.
#[test]
fn the_plant_of_slicot_sb01bd() {
    let a = dmatrix![
        -6.8, 0.0, -207.0, 0.0;
        1.0, 0.0, 0.0, 0.0;
        43.2, 0.0, 0.0, -4.2;
        0.0, 0.0, 1.0, 0.0
    ];
    let b = dmatrix![5.64, 0.0; 0.0, 0.0; 0.0, 1.18; 0.0, 0.0];
    let requested = [c(-0.5, 0.15), c(-0.5, -0.15), c(-2.0, 0.0), c(-0.4, 0.0)];
    let placed = place(&a, &b, &requested).unwrap();
    assert_placed(&placed, &requested, a.norm() + b.norm() * placed.gain.norm());
    // scipy's Tits-Yang reaches 8.364.
    assert!(placed.condition < 8.5, "condition {}", placed.condition);
    // The problem of the example itself: two moved, two kept (printed to four decimals).
    let requested = [c(-3.3984, 94.5253), c(-3.3984, -94.5253), c(-0.5, 0.15), c(-0.5, -0.15)];
    let placed = place(&a, &b, &requested).unwrap();
    assert_placed(&placed, &requested, a.norm() + b.norm() * placed.gain.norm());
    // scipy's Tits-Yang reaches 1.645 for these poles.
    assert!(placed.condition < 1.70, "condition {}", placed.condition);
    // SLICOT's gain is F in A + B F: -K for its closed loop, another choice of the freedom left. Ours may not be worse
    // conditioned.
    let f = dmatrix![-0.0876, -4.2138, 0.0837, -18.1412; -0.0233, 18.2483, -0.4259, -4.8120];
    let printed = eigenvalues(&(&a + &b * f)).unwrap();
    let near = |x: &Complex<f64>| printed.iter().map(|y| (x - y).norm()).fold(f64::INFINITY, f64::min);
    assert!(requested.iter().all(|x| near(x) < 0.02), "the printed gain places {printed:?}");
}

/// Kautsky, Nichols, Van Dooren 1985, example 1: a chemical reactor. The Tits-Yang method of scipy 1.x (`place_poles`,
/// run to rtol 1e-8) reaches cond(X) = 4.27.
#[test]
fn the_chemical_reactor_is_well_conditioned() {
    let a = dmatrix![
        1.380, -0.2077, 6.715, -5.676;
        -0.5814, -4.290, 0.0, 0.6750;
        1.067, 4.273, -6.654, 5.893;
        0.0480, 4.273, 1.343, -2.104
    ];
    let b = dmatrix![0.0, 0.0; 5.679, 0.0; 1.136, -3.146; 1.136, 0.0];
    let requested = real(&[-0.2, -0.5, -5.0566, -8.6659]);
    let placed = place(&a, &b, &requested).unwrap();
    assert_placed(&placed, &requested, a.norm() + b.norm() * placed.gain.norm());
    assert!(placed.condition < 4.27, "condition {}", placed.condition);
}

#[test]
fn repeated_poles_up_to_the_number_of_outputs() {
    // Two double integrators, both positions measured.
    let mut a = DMatrix::zeros(4, 4);
    (a[(0, 1)], a[(2, 3)], a[(3, 0)]) = (1.0, 1.0, 0.5);
    let mut outputs = DMatrix::zeros(2, 4);
    (outputs[(0, 0)], outputs[(1, 2)]) = (1.0, 1.0);
    let twice = [c(-1.0, 1.0), c(-1.0, -1.0), c(-1.0, 1.0), c(-1.0, -1.0)];
    let placed = place_observer(&a, &outputs, &twice).unwrap();
    assert_placed(&placed, &twice, observer_terms(&a, &outputs, &placed));
    let twice = real(&[-3.0, -2.0, -3.0, -2.0]);
    let placed = place_observer(&a, &outputs, &twice).unwrap();
    assert_placed(&placed, &twice, observer_terms(&a, &outputs, &placed));
    assert_eq!(
        place_observer(&a, &outputs, &real(&[-1.0, -1.0, -2.0, -1.0])).unwrap_err(),
        LinalgError::PoleMultiplicity { pole: c(-1.0, 0.0), poles: 1, multiplicity: 3, rank: 2 }
    );
}

/// With one output the loop has no choice: a repeated pole is defective, and said to be.
#[test]
fn repeated_poles_with_one_output_are_defective() {
    let mut a = DMatrix::zeros(3, 3);
    (a[(0, 1)], a[(1, 2)]) = (1.0, 1.0);
    let c = dmatrix![1.0, 0.0, 0.0];
    let placed = place_observer(&a, &c, &real(&[-2.0; 3])).unwrap();
    assert!((placed.gain - dmatrix![6.0; 12.0; 8.0]).norm() < 1e-13);
    assert_eq!(placed.condition, f64::INFINITY);
    // The cube root of the rounding is what a triple pole costs.
    assert!(placed.deviation < 1e-4, "{:e}", placed.deviation);
    // And it says so pole by pole: a change of eps moves each by eps^(1/3).
    assert!(placed.sensitivities.iter().all(|s| *s > 1e8), "{:?}", placed.sensitivities);
    let largest = placed.errors.iter().copied().fold(0.0, f64::max);
    assert!(
        (largest / placed.deviation - 2.0).abs() < 1e-6,
        "relative to the requested pole 2, the norm of A being less"
    );
}

#[test]
fn every_state_measured() {
    let a = dmatrix![1.0, 2.0; 3.0, 4.0];
    let outputs = dmatrix![1.0, 1.0; 0.0, 1.0; 1.0, 0.0];
    for requested in [[c(-1.0, 2.0), c(-1.0, -2.0)], [c(-4.0, 0.0), c(-4.0, 0.0)], [c(-1.0, 0.0), c(-9.0, 0.0)]] {
        let placed = place_observer(&a, &outputs, &requested).unwrap();
        assert_placed(&placed, &requested, observer_terms(&a, &outputs, &placed));
        assert_abs_diff_eq!(placed.condition, 1.0, epsilon = 1e-12);
    }
    let scalar = place(&dmatrix![3.0], &dmatrix![2.0], &real(&[-1.0])).unwrap();
    assert_eq!((scalar.gain[0], scalar.condition, scalar.poles[0]), (2.0, 1.0, c(-1.0, 0.0)));
}

/// Outputs that say the same count once.
#[test]
fn dependent_outputs_count_once() {
    let a = dmatrix![0.0, 1.0; -1.0, 0.0];
    let outputs = dmatrix![1.0, 2.0; -2.0, -4.0; 0.5, 1.0];
    let requested = real(&[-3.0, -3.0]);
    let placed = place_observer(&a, &outputs, &requested).unwrap();
    assert_eq!(placed.condition, f64::INFINITY);
    assert!(placed.deviation < 1e-6);
}

/// Poles that are eigenvalues already cost nothing, and do not disturb the method.
#[test]
fn the_poles_the_plant_has() {
    let a = dmatrix![-1.0, 1.0, 0.0; 0.0, -2.0, 1.0; 0.0, 0.0, -3.0];
    let requested = real(&[-1.0, -2.0, -3.0]);
    let single = place(&a, &dmatrix![0.0; 0.0; 1.0], &requested).unwrap();
    assert!(single.gain.norm() < 1e-13, "{}", single.gain);
    let double = place(&a, &dmatrix![1.0, 0.0; 0.0, 0.0; 0.0, 1.0], &requested).unwrap();
    assert_placed(&double, &requested, 10.0);
}

#[test]
fn what_no_gain_moves_is_named_with_its_direction() {
    let a = dmatrix![-1.0, 0.0, 0.0; 0.0, 2.0, 0.0; 1.0, 0.0, -3.0];
    let outputs = dmatrix![1.0, 0.0, 1.0];
    let LinalgError::Unobservable { eigenvalue, direction, margin } =
        place_observer(&a, &outputs, &real(&[-1.0, -2.0, -3.0])).unwrap_err()
    else {
        panic!("an unobservable pair was placed");
    };
    assert!((eigenvalue - 2.0).norm() < 1e-14 && margin < 1e-14);
    assert!((direction - DVector::from_vec(real(&[0.0, 1.0, 0.0]))).norm() < 1e-14);

    let LinalgError::Uncontrollable { eigenvalue, direction, .. } =
        place(&a.transpose(), &outputs.transpose(), &real(&[-1.0, -2.0, -3.0])).unwrap_err()
    else {
        panic!("an uncontrollable pair was placed");
    };
    assert!((eigenvalue - 2.0).norm() < 1e-14 && (direction[1].norm() - 1.0).abs() < 1e-14);
    assert!(matches!(
        place(&a, &DMatrix::zeros(3, 0), &real(&[-1.0, -2.0, -3.0])),
        Err(LinalgError::Uncontrollable { .. })
    ));
}

#[test]
fn bad_input_is_named() {
    let (a, b) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
    assert_eq!(place(&a, &b, &real(&[-1.0])).unwrap_err(), LinalgError::PoleCount { order: 2, found: 1 });
    let unpaired = [c(-1.0, 1.0), c(-1.0, -1.0 - 1e-9)];
    assert_eq!(place(&a, &b, &unpaired).unwrap_err(), LinalgError::PoleUnpaired { pole: unpaired[0] });
    assert!(matches!(
        place(&a, &b, &[c(-1.0, 0.0), c(f64::NAN, 0.0)]),
        Err(LinalgError::PoleNotFinite { index: 1, .. })
    ));
    assert_eq!(
        place(&a, &dmatrix![1.0, 0.0], &real(&[-1.0, -2.0])).unwrap_err(),
        LinalgError::DimensionMismatch { what: "B", expected: (2, 2), found: (1, 2) }
    );
    assert!(matches!(
        place_observer(&a, &dmatrix![f64::NAN, 0.0], &real(&[-1.0, -2.0])),
        Err(LinalgError::NotFinite { what: "C", .. })
    ));
    assert!(matches!(place(&b, &b, &[0.0; 0]), Err(LinalgError::NotSquare { what: "A", .. })));
    assert!(matches!(
        place(&DMatrix::zeros(0, 0), &DMatrix::zeros(0, 1), &[0.0; 0]),
        Err(LinalgError::Empty { what: "A" })
    ));
}

#[test]
fn a_pole_repeated_too_often_is_named_in_the_units_given() {
    let (a, b) = (dmatrix![0.0, 8.0, 0.0; 0.0, 0.0, 8.0; 0.0, 0.0, 0.0], dmatrix![0.0, 0.0; 1.0, 0.0; 0.0, 1.0]);
    let expected = LinalgError::PoleMultiplicity { pole: c(-1.0, 0.0), poles: 1, multiplicity: 3, rank: 2 };
    assert_eq!(place(&a, &b, &real(&[-1.0; 3])), Err(expected));
}

/// Controllability indices 3 and 1: two double poles would take invariant polynomials of degrees 2 and 2 (Rosenbrock),
/// with 3 and 1 they exist.
#[test]
fn repetitions_of_several_poles_together_are_limited_by_the_indices() {
    let mut a = DMatrix::zeros(4, 4);
    (a[(0, 1)], a[(1, 2)], a[(2, 0)], a[(3, 1)]) = (1.0, 1.0, 0.5, 0.25);
    let b = dmatrix![0.0, 0.0; 0.0, 0.0; 1.0, 0.0; 0.0, 1.0];
    let expected = LinalgError::PoleMultiplicity { pole: c(-2.0, 0.0), poles: 2, multiplicity: 4, rank: 3 };
    assert_eq!(place(&a, &b, &real(&[-1.0, -1.0, -2.0, -2.0])), Err(expected));
    let placed = place(&a, &b, &real(&[-1.0, -1.0, -2.0, -3.0])).unwrap();
    assert!(placed.deviation < 1e-12 && placed.gain.norm() < 100.0, "{placed}");
}

/// Observability indices 2 and 2: `(A - L C)^2 = 0` for `L = A^2 [C; C A]^-1 [0; I]` alone, as in Ackermann's formula.
#[test]
fn the_deadbeat_gain_of_equal_indices_is_that_of_ackermann() {
    let a = dmatrix![0.5, 1.0, -0.25, 0.0; 2.0, -1.0, 0.5, 1.0; 0.0, 0.75, 1.5, -2.0; 1.0, 0.0, 0.25, 0.5];
    let c = dmatrix![1.0, 0.0, 2.0, 0.0; 0.0, 1.0, -1.0, 1.0];
    let mut seen = DMatrix::zeros(4, 4);
    seen.rows_mut(0, 2).copy_from(&c);
    seen.rows_mut(2, 2).copy_from(&(&c * &a));
    let last = dmatrix![0.0, 0.0; 0.0, 0.0; 1.0, 0.0; 0.0, 1.0];
    let expected = a.pow(2) * seen.lu().solve(&last).unwrap();
    let placed = place_observer(&a, &c, &[0.0; 4]).unwrap();
    assert!((&placed.gain - &expected).norm() < 1e-12 * expected.norm(), "{} for {expected}", placed.gain);
    assert!((&a - &placed.gain * &c).pow(2).norm() < 1e-12);
    // Poles of a defective loop: the root of the rounding.
    assert!(placed.condition.is_infinite() && placed.deviation < 1e-6, "{placed}");
}

/// Indices 3 and 1: the output 2 may correct more than one state, and the least gain corrects the one that it sees.
/// `A^-1` does not exist: the first state is a shift register's.
#[test]
fn the_deadbeat_gain_is_the_least_one() {
    let mut a = DMatrix::zeros(4, 4);
    (a[(0, 1)], a[(1, 2)], a[(3, 3)]) = (1.0, 1.0, 1.0);
    let c = dmatrix![1.0, 0.0, 0.0, 0.0; 0.0, 0.0, 0.0, 1.0];
    let placed = place_observer(&a, &c, &[0.0; 4]).unwrap();
    assert!((placed.gain - dmatrix![0.0, 0.0; 0.0, 0.0; 0.0, 0.0; 0.0, 1.0]).norm() < 1e-15);
    // An output that is the sum of two others does not count.
    let c = dmatrix![1.0, 0.0, 0.0, 0.0; 1.0, 0.0, 0.0, 1.0; 0.0, 0.0, 0.0, 1.0];
    let placed = place_observer(&a, &c, &[0.0; 4]).unwrap();
    assert!((&a - &placed.gain * &c).pow(3).norm() < 1e-14);
    // Every state is measured: at once.
    let placed = place_observer(&a, &DMatrix::identity(4, 4), &[0.0; 4]).unwrap();
    assert!((placed.gain - a).norm() < 1e-14);
}

/// A mode that no input moves is an error even if it is asked for, real or a pair, with one input or two: no gain
/// places it, it merely happens to be there.
#[test]
fn a_mode_that_stays_is_named_even_if_it_is_asked_for() {
    let a = dmatrix![-1.0, 0.0, 0.0; 0.3, 2.0, 1.0; 0.2, 0.0, -3.0];
    let fixed =
        |b: &DMatrix<f64>, a: &DMatrix<f64>, requested: &[Complex<f64>]| match place(a, b, requested).unwrap_err() {
            LinalgError::Uncontrollable { eigenvalue, direction, margin } => {
                let (a, b, v) = (a.map(Complex::from), b.map(Complex::from), direction.transpose());
                assert!((&v * a - &v * eigenvalue).norm() < 1e-13 && (v * b).norm() < 1e-14 && margin < 1e-14);
                eigenvalue
            }
            other => panic!("{other}"),
        };
    for b in [dmatrix![0.0; 0.0; 1.0], dmatrix![0.0, 0.0; 1.0, 0.0; 0.0, 1.0]] {
        for requested in [[-1.0, -5.0, -6.0], [-4.0, -5.0, -6.0]] {
            assert!((fixed(&b, &a, &real(&requested)) + 1.0).norm() < 1e-14);
        }
    }
    let rotating = dmatrix![0.0, 2.0, 0.0; -2.0, 0.0, 0.0; 1.0, 1.0, 1.0];
    let found = fixed(&dmatrix![0.0; 0.0; 1.0], &rotating, &[c(0.0, 2.0), c(0.0, -2.0), c(-1.0, 0.0)]);
    assert!((found.im.abs() - 2.0).abs() < 1e-14 && found.re.abs() < 1e-14, "{found}");
}

/// A chain of integrators wants the coefficients of the polynomial itself: `(s + 1)^4 (s + 2)^4` and, in real
/// arithmetic, then complex, `(s + 1)^2 (s^2 + 2 s + 5)^3`.
#[test]
fn a_chain_of_integrators_takes_the_coefficients() {
    let double = [c(-1.0, 0.0); 4].into_iter().chain([c(-2.0, 0.0); 4]).collect::<Vec<_>>();
    let pairs = (0..8).map(|k| if k < 2 { c(-1.0, 0.0) } else { c(-1.0, if k % 2 == 0 { 2.0 } else { -2.0 }) });
    for requested in [double, pairs.collect()] {
        let mut polynomial = vec![Complex::from(1.0)];
        for pole in &requested {
            polynomial.push(Complex::from(0.0));
            for k in (1..polynomial.len()).rev() {
                let before = polynomial[k - 1];
                polynomial[k] -= pole * before;
            }
        }
        let a = DMatrix::from_fn(8, 8, |i, j| f64::from(u8::from(j == i + 1)));
        let b = DMatrix::from_fn(8, 1, |i, _| f64::from(u8::from(i == 7)));
        let placed = place(&a, &b, &requested).unwrap();
        for (found, expected) in placed.gain.iter().zip(polynomial[1..].iter().rev()) {
            // Eight steps, each orthogonal, on entries of the size of the largest coefficient.
            let bound = 100.0 * f64::EPSILON * polynomial.iter().map(|x| x.re).fold(0.0, f64::max);
            assert!((found - expected.re).abs() < bound, "{found} for {}", expected.re);
        }
        assert_eq!(placed.condition, f64::INFINITY);
    }
}

/// A plant in other units of everything: `s A` with poles s times as fast is the same plant in another unit of time,
/// `s B` has an input in another unit.
#[test]
fn the_size_of_the_plant_does_not_matter() {
    let a = dmatrix![0.2, 1.0, -0.3, 0.1; -0.7, 0.4, 0.9, 0.0; 0.5, -0.2, -1.0, 0.8; 0.3, 0.6, 0.1, -0.5];
    let (one, two) = (dmatrix![0.3; 1.0; -0.4; 0.2], dmatrix![0.3, 1.0; 1.0, 0.2; -0.4, 0.1; 0.2, -0.6]);
    for requested in [vec![c(-1.0, 2.0), c(-1.0, -2.0), c(-2.0, 0.0), c(-3.0, 0.0)], real(&[-1.0, -2.0, -3.0, -4.0])] {
        for b in [&one, &two] {
            let plain = place(&a, b, &requested).unwrap();
            for s in [1e-300, 1e-12, 1e-6, 1e6, 1e12, 1e290] {
                let faster: Vec<_> = requested.iter().map(|p| p * s).collect();
                let fast = place(&(&a * s), b, &faster).unwrap();
                let loud = place(&a, &(b * s), &requested).unwrap();
                // The same problem in other roundings of the data.
                let near = |x: &DMatrix<f64>| (x - &plain.gain).norm() < 1e-12 * plain.condition * plain.gain.norm();
                assert!(near(&(&fast.gain / s)) && near(&(&loud.gain * s)), "{s:e}: {} {}", fast.gain, loud.gain);
                for (x, y) in [(&fast, &plain), (&loud, &plain)] {
                    assert!((x.condition / y.condition - 1.0).abs() < 1e-9 && x.deviation < 1e-12, "{s:e}: {x:?}");
                    for (x, y) in x.sensitivities.iter().zip(&y.sensitivities) {
                        assert!((x / y - 1.0).abs() < 1e-9, "{s:e}: {x} for {y}");
                    }
                }
            }
        }
    }
}

#[test]
fn numbers_that_are_none_are_named_wherever_they_are() {
    let (a, b, requested) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], real(&[-1.0, -2.0]));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let (mut wrong_a, mut wrong_b) = (a.clone(), b.clone());
        (wrong_a[(1, 0)], wrong_b[(1, 0)]) = (bad, bad);
        assert!(matches!(
            place(&wrong_a, &b, &requested),
            Err(LinalgError::NotFinite { what: "A", row: 1, col: 0, .. })
        ));
        assert!(matches!(
            place(&a, &wrong_b, &requested),
            Err(LinalgError::NotFinite { what: "B", row: 1, col: 0, .. })
        ));
        assert!(matches!(
            place(&a, &b, &[requested[0], c(bad, 0.0)]),
            Err(LinalgError::PoleNotFinite { index: 1, .. })
        ));
        assert!(matches!(
            place(&a, &b, &[c(-1.0, bad), requested[0]]),
            Err(LinalgError::PoleNotFinite { index: 0, .. })
        ));
    }
    // A gain beyond the range of a double.
    let refused = place(&dmatrix![1.0], &dmatrix![1e-200], &real(&[-1e200])).unwrap_err();
    assert_eq!(refused, LinalgError::Overflow { what: "the gain" });
    // The scalar in any size that fits.
    for (pole, b) in [(-1e200, 1e-100), (-1e-200, 1e50), (1e-300, -1e-10)] {
        let placed = place(&dmatrix![0.0], &dmatrix![b], &real(&[pole])).unwrap();
        assert!((placed.gain[0] * b + pole).abs() <= 4.0 * f64::EPSILON * pole.abs() && placed.condition == 1.0);
    }
}

#[derive(Debug, Clone)]
struct Problem {
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    poles: Vec<Complex<f64>>,
    units: Vec<i32>,
}

/// Observable by construction (each state drives the one before it, the first output sees the first), in mixed
/// coordinates; distinct poles, some in pairs.
fn problem(
    order: std::ops::RangeInclusive<usize>,
    outputs: std::ops::RangeInclusive<usize>,
) -> impl Strategy<Value = Problem> {
    (order, outputs).prop_flat_map(|(n, p)| {
        let unit = || -1.0..1.0f64;
        (
            prop::collection::vec(unit(), n * n),
            prop::collection::vec(unit(), p * n),
            prop::collection::vec(unit(), n),
            prop::collection::vec(0.0..0.6f64, n),
            0..=n / 2,
            prop::collection::vec(-40i32..=40, n),
        )
            .prop_map(move |(x, y, v, shifts, pairs, units)| {
                let a = DMatrix::from_fn(n, n, |i, j| match x[i * n + j] {
                    free if j == i + 1 => free.signum() * (1.0 + free.abs()),
                    _ if j > i + 1 => 0.0,
                    free => free,
                });
                let outputs = DMatrix::from_fn(p, n, |i, j| match (i, j) {
                    (0, 0) => 1.0,
                    (0, _) => 0.0,
                    _ => y[i * n + j],
                });
                let v = DVector::from_fn(n, |i, _| v[i] + if i == 0 { 1.5 } else { 0.0 });
                let q = DMatrix::identity(n, n) - &v * v.transpose() * (2.0 / v.norm_squared());
                let mut poles = Vec::new();
                for (k, shift) in shifts.iter().enumerate().take(pairs) {
                    let pole = c(-1.0 - k as f64 - shift, 1.0 + shift);
                    poles.extend([pole, pole.conj()]);
                }
                poles.extend((2 * pairs..n).map(|k| c(-1.0 - k as f64 - shifts[k], 0.0)));
                Problem { a: &q * a * q.transpose(), c: outputs * q.transpose(), poles, units }
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Wonham 1967: an observable pair takes every set of poles.
    #[test]
    fn one_output_places_every_set(problem in problem(1..=7, 1..=1)) {
        let placed = place_observer(&problem.a, &problem.c, &problem.poles).unwrap();
        assert_placed(&placed, &problem.poles, observer_terms(&problem.a, &problem.c, &placed));
    }

    #[test]
    fn several_outputs_place_every_set(problem in problem(1..=7, 2..=4)) {
        let placed = place_observer(&problem.a, &problem.c, &problem.poles).unwrap();
        assert_placed(&placed, &problem.poles, observer_terms(&problem.a, &problem.c, &placed));
        prop_assert!(placed.condition.is_finite());
        // With columns of norm one, `|X| <= sqrt n` and `|X^-1| <= |X^-1|_F`, whose rows have the conditions for norms;
        // and none of these exceeds `|X^-1|`. The slack is for the loop achieved not being the one aimed at.
        let worst = placed.sensitivities.iter().copied().fold(1.0, f64::max);
        prop_assert!(placed.sensitivities.iter().all(|s| *s >= 1.0 - 1e-12) && worst <= placed.condition * 1.001);
        let all = placed.sensitivities.iter().map(|s| s * s).sum::<f64>();
        prop_assert!(placed.condition <= (placed.poles.len() as f64 * all).sqrt() * 1.001, "{} {all}", placed.condition);
        for ((error, pole), requested) in placed.errors.iter().zip(&placed.poles).zip(&problem.poles) {
            prop_assert_eq!(*error, (pole - requested).norm());
        }
        // The same numbers again, whoever asks.
        prop_assert_eq!(&placed, &place_observer(&problem.a, &problem.c, &problem.poles).unwrap());
    }

    /// The deadbeat gain: the error is zero after as many steps as the largest observability index, which is the number
    /// of rows of C, C A, .. that have the rank n together, over p; and not before.
    #[test]
    fn the_deadbeat_observer_takes_the_fewest_steps(problem in problem(3..=6, 2..=3)) {
        let n = problem.a.nrows();
        let mut rows = problem.c.clone();
        let mut steps = 1;
        while rows.rank(1e-9) < n {
            let next = rows.rows(rows.nrows() - problem.c.nrows(), problem.c.nrows()) * &problem.a;
            rows = DMatrix::from_fn(rows.nrows() + next.nrows(), n, |i, j| {
                if i < rows.nrows() { rows[(i, j)] } else { next[(i - rows.nrows(), j)] }
            });
            steps += 1;
        }
        let placed = place_observer(&problem.a, &problem.c, &vec![0.0; n]).unwrap();
        let closed = &problem.a - &placed.gain * &problem.c;
        let size = observer_terms(&problem.a, &problem.c, &placed).powi(steps);
        let after = |k: i32| closed.pow(k as u32).norm();
        prop_assert!(after(steps) < 1e-10 * size, "{:e} after {steps} steps", after(steps));
        prop_assert!(steps == 1 || after(steps - 1) > 1e-6 * after(1).max(1.0), "{:e}", after(steps - 1));
    }

    /// `eig(A - B K)` by duality: `place(A', C')` is the transpose.
    #[test]
    fn feedback_is_the_dual(problem in problem(1..=6, 1..=3)) {
        let observer = place_observer(&problem.a, &problem.c, &problem.poles).unwrap();
        let feedback = place(&problem.a.transpose(), &problem.c.transpose(), &problem.poles).unwrap();
        prop_assert_eq!(&feedback.gain.transpose(), &observer.gain);
    }

    /// States in units up to 12 decades off: with one output the gain is the same motion in those units, `L -> D^-1 L`.
    #[test]
    fn the_gain_follows_the_units(problem in problem(2..=5, 1..=1)) {
        let d = |i: usize| 2f64.powi(problem.units[i]);
        let n = problem.a.nrows();
        let a = DMatrix::from_fn(n, n, |i, j| problem.a[(i, j)] * d(j) / d(i));
        let outputs = DMatrix::from_fn(1, n, |_, j| problem.c[(0, j)] * d(j));
        let plain = place_observer(&problem.a, &problem.c, &problem.poles).unwrap();
        let scaled = place_observer(&a, &outputs, &problem.poles).unwrap();
        let largest = plain.gain.amax();
        for i in 0..n {
            let back = scaled.gain[i] * d(i);
            prop_assert!((back - plain.gain[i]).abs() < 1e-8 * largest, "{back} for {}", plain.gain[i]);
        }
        prop_assert!(scaled.deviation < 1e-7, "{:e}", scaled.deviation);
    }

    /// Whether a pair is placed is what `observability` says of it, however weak one coupling is made: the short way of
    /// `place` to a yes is no other verdict.
    #[test]
    fn the_verdict_is_that_of_observability(problem in problem(2..=8, 1..=3), at in 0usize..7, weak in 0i32..=22) {
        let n = problem.a.nrows();
        // The rows above one stage hear of what is below through this factor alone.
        let stage = 1 + at % (n - 1);
        let factor = 10f64.powi(-weak);
        let weakened = |m: &DMatrix<f64>, rows: usize| {
            DMatrix::from_fn(m.nrows(), n, |i, j| m[(i, j)] * if i < rows && j >= stage { factor } else { 1.0 })
        };
        let v = DVector::from_fn(n, |i, _| 1.0 / (i as f64 + 1.5));
        let q = DMatrix::identity(n, n) - &v * v.transpose() * (2.0 / v.norm_squared());
        let a = &q * weakened(&problem.a, stage) * q.transpose();
        let c = weakened(&problem.c, usize::MAX) * q.transpose();
        match place_observer(&a, &c, &problem.poles) {
            Ok(placed) => {
                prop_assert!(observability(&a, &c).unwrap().is_observable());
                prop_assert!(placed.gain.iter().all(|x| x.is_finite()));
            }
            Err(LinalgError::Unobservable { margin, .. }) => {
                let seen = observability(&a, &c).unwrap();
                prop_assert!(!seen.is_observable());
                prop_assert!(margin <= 1e-7, "a margin of {margin:e} is no reason");
            }
            Err(LinalgError::Overflow { .. }) => prop_assert!(weak > 5),
            Err(other) => prop_assert!(false, "{other}"),
        }
    }
}
