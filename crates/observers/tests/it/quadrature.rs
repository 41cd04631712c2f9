//! The degree of the rules of Gauss and Legendre.

use luenberger_observers::internals::{GAUSS_LEGENDRE_5, GAUSS_LEGENDRE_8};

/// The rules integrate s^k exactly up to twice the number of points less one, and not beyond.
#[test]
fn the_rules_have_their_degree() {
    for (rule, degree) in [(&GAUSS_LEGENDRE_8[..], 15), (&GAUSS_LEGENDRE_5[..], 9)] {
        let defect = |k: i32| {
            let sum: f64 = rule.iter().map(|(s, w)| w * (0..k).fold(1.0, |power, _| power * s)).sum();
            (sum - 1.0 / f64::from(k + 1)).abs()
        };
        assert!((0..=degree).all(|k| defect(k) <= 4.0 * f64::EPSILON));
        // (m!)^4 / ((2m + 1) (2m)!^2), the defect at degree 2m: 3.6e-10 for eight points, 1.4e-6 for five.
        assert!(defect(degree + 1) > 1e-10);
    }
}
