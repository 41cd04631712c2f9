//! Gauss and Legendre's quadrature on [0, 1].

/// Nodes and weights of eight points on [0, 1], to the last digit of f64.
pub const GAUSS_LEGENDRE_8: [(f64, f64); 8] = [
    (0.019855071751231884, 0.05061426814518813),
    (0.10166676129318664, 0.11119051722668724),
    (0.2372337950418355, 0.15685332293894363),
    (0.4082826787521751, 0.181341891689181),
    (0.591717321247825, 0.181341891689181),
    (0.7627662049581645, 0.15685332293894363),
    (0.8983332387068134, 0.11119051722668724),
    (0.9801449282487681, 0.05061426814518813),
];

/// Nodes and weights of five points on [0, 1].
pub(super) const GAUSS_LEGENDRE_5: [(f64, f64); 5] = [
    (0.046910077030668004, 0.11846344252809454),
    (0.23076534494715845, 0.23931433524968324),
    (0.5, 0.28444444444444444),
    (0.7692346550528415, 0.23931433524968324),
    (0.953089922969332, 0.11846344252809454),
];

#[cfg(test)]
mod tests {
    use super::{GAUSS_LEGENDRE_5, GAUSS_LEGENDRE_8};

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
}
