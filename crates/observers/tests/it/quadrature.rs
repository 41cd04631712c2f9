//! The degree of the rule of Gauss and Legendre.

use luenberger_observers::internals::GAUSS_LEGENDRE_8;

/// Eight points integrate s^k exactly up to k = 15, and not beyond.
#[test]
fn the_rule_has_its_degree() {
    let defect = |k: i32| {
        let sum: f64 = GAUSS_LEGENDRE_8.iter().map(|(s, w)| w * (0..k).fold(1.0, |power, _| power * s)).sum();
        (sum - 1.0 / f64::from(k + 1)).abs()
    };
    assert!((0..=15).all(|k| defect(k) <= 4.0 * f64::EPSILON));
    // (m!)^4 / ((2m + 1) (2m)!^2), the defect at degree 2m: 3.6e-10 for eight points.
    assert!(defect(16) > 1e-10);
}
