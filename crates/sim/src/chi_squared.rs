//! The chi-squared distribution: tail and quantile.
//!
//! `Q(k/2, x/2)`, the regularised incomplete gamma function, by its series for small x and by its continued fraction
//! (modified Lentz) for large x, so that small tails keep their relative accuracy.
//!
//! Source: W. H. Press et al., Numerical Recipes, 3rd edition, Cambridge 2007, section 6.2; NIST DLMF 5.11.1 for the
//! logarithm of the gamma function.

/// The logarithm of the gamma function for x > 0: Stirling's series from 10 on, the recurrence below.
fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut product) = (x, 1.0);
    while x < 10.0 {
        product *= x;
        x += 1.0;
    }
    let square = 1.0 / (x * x);
    let series = [1.0 / 12.0, -1.0 / 360.0, 1.0 / 1260.0, -1.0 / 1680.0, 1.0 / 1188.0, -691.0 / 360360.0, 1.0 / 156.0];
    let tail = series.iter().rev().fold(0.0, |sum, term| sum * square + term) / x;
    (x - 0.5) * x.ln() - x + 0.5 * core::f64::consts::TAU.ln() + tail - product.ln()
}

/// The probability that chi-squared with `degrees` > 0 degrees of freedom exceeds x.
pub(crate) fn tail(x: f64, degrees: f64) -> f64 {
    let (a, x) = (degrees / 2.0, x / 2.0);
    if x.is_nan() || x <= 0.0 {
        return 1.0;
    }
    let scale = (a * x.ln() - x - ln_gamma(a)).exp();
    // Both need some multiple of sqrt(a) terms near x = a, and few elsewhere.
    let terms = 1000 + (50.0 * a.sqrt()) as usize;
    if x < a + 1.0 {
        let (mut term, mut sum, mut index) = (1.0 / a, 1.0 / a, a);
        for _ in 0..terms {
            index += 1.0;
            term *= x / index;
            sum += term;
            if term < sum * f64::EPSILON {
                break;
            }
        }
        return (1.0 - sum * scale).clamp(0.0, 1.0);
    }
    let mut b = x + 1.0 - a;
    let mut c = f64::MAX;
    let mut d = 1.0 / b;
    let mut fraction = d;
    for i in 1..terms {
        let i = i as f64;
        let numerator = -i * (i - a);
        b += 2.0;
        d = 1.0 / nonzero(numerator * d + b);
        c = nonzero(b + numerator / c);
        let factor = c * d;
        fraction *= factor;
        if (factor - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    (fraction * scale).clamp(0.0, 1.0)
}

fn nonzero(x: f64) -> f64 {
    if x.abs() < f64::MIN_POSITIVE { f64::MIN_POSITIVE } else { x }
}

/// The x that chi-squared with `degrees` degrees of freedom stays below with the probability p, by bisection of
/// [`tail`]; p between 1e-9 and 1 - 1e-9.
pub(crate) fn quantile(p: f64, degrees: f64) -> f64 {
    // Mean k, variance 2 k, and a tail that decays as exp(-x/2).
    let (mut low, mut high) = (0.0, degrees + 10.0 * (2.0 * degrees).sqrt() + 100.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if tail(middle, degrees) > 1.0 - p {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tail_of_chi_squared_is_that_of_the_tables() {
        // Abramowitz and Stegun, table 26.8: 95 % and 99 % points.
        for (degrees, x, expected) in
            [(2.0, 5.99147, 0.05), (10.0, 18.3070, 0.05), (20.0, 31.4104, 0.05), (20.0, 37.5662, 0.01)]
        {
            assert!((tail(x, degrees) - expected).abs() < 1e-6, "{degrees} {x}");
        }
        assert_eq!((tail(0.0, 4.0), tail(1e9, 20.0)), (1.0, 0.0));
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
}
