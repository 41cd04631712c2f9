//! The chi-squared distribution against tables and scipy.

use luenberger_sim::chi_squared::{quantile, tail};

#[test]
fn the_tail_of_chi_squared_is_that_of_the_tables() {
    // Abramowitz and Stegun, table 26.8: 95 % and 99 % points.
    for (degrees, x, expected) in
        [(2.0, 5.99147, 0.05), (10.0, 18.3070, 0.05), (20.0, 31.4104, 0.05), (20.0, 37.5662, 0.01)]
    {
        assert!((tail(x, degrees) - expected).abs() < 1e-6, "{degrees} {x}");
    }
    assert_eq!((tail(0.0, 4.0), tail(1e9, 20.0)), (1.0, 0.0));
    assert_eq!((tail(-2.0, 3.0), tail(f64::NAN, 3.0)), (1.0, 1.0));
}

/// mpmath 1.3 with 30 digits, `gammainc(k/2, x/2, regularized=True)`, where Stirling's series begins: the logarithm of
/// the gamma function, 13, is known to its last bits.
#[test]
fn tails_near_the_mean_are_right_to_rounding() {
    for (x, degrees, expected) in [
        (20.0, 20.0, 0.457_929_714_471_852_2),
        (18.5, 20.0, 0.554_506_898_750_187),
        (25.0, 21.0, 0.247_164_078_922_659_77),
    ] {
        let found = tail(x, degrees);
        assert!((found - expected).abs() < 8e-15, "{x} {degrees}: {found}");
    }
}

/// scipy 1.17.1: `chi2.sf(x, k)`, `chi2.ppf(p, k)`.
#[test]
fn tails_and_quantiles_are_those_of_scipy() {
    for (x, degrees, expected) in [
        (800.0, 20.0, 1.4152785631076833e-156),
        (3.5, 7.0, 0.8352254826103422),
        (120.0, 99.0, 0.07424385580596692),
        (1000.0, 3.0, 1.7994208765314067e-216),
    ] {
        assert!((tail(x, degrees) / expected - 1.0f64).abs() < 1e-11, "{x} {degrees}: {}", tail(x, degrees));
    }
    for (degrees, low, high) in [
        (1.0, 0.0009820691171752555, 5.023886187314888),
        (2.0, 0.05063561596857975, 7.377758908227871),
        (3.0, 0.21579528262389785, 9.348403604496148),
        (7.0, 1.689869180677355, 16.012764274629326),
        (100.0, 74.22192747492373, 129.5611971858366),
        (999.0, 913.3009983021134, 1088.4870677259353),
        (4500.0, 4315.962985549624, 4687.825505126172),
        (200000.0, 198762.30532748945, 201241.48328154747),
    ] {
        let found = (quantile(0.025, degrees), quantile(0.975, degrees));
        assert!((found.0 / low - 1.0f64).abs() < 1e-10 && (found.1 / high - 1.0f64).abs() < 1e-10, "{degrees}");
    }
}
