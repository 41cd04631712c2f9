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
pub fn tail(x: f64, degrees: f64) -> f64 {
    let (a, x) = (degrees / 2.0, x / 2.0);
    if x.is_nan() || x <= 0.0 {
        return 1.0;
    }
    let scale = (a * x.ln() - x - ln_gamma(a)).exp();
    let terms = most_terms(a);
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

/// More terms than series and fraction take: some multiple of sqrt(a) near x = a, and few elsewhere.
fn most_terms(a: f64) -> usize {
    1000 + (50.0 * a.sqrt()) as usize
}

fn nonzero(x: f64) -> f64 {
    if x.abs() < f64::MIN_POSITIVE { f64::MIN_POSITIVE } else { x }
}

/// The x that chi-squared with `degrees` degrees of freedom stays below with the probability p, by bisection of
/// [`tail`]; p between 1e-9 and 1 - 1e-9.
pub fn quantile(p: f64, degrees: f64) -> f64 {
    let (mut low, mut high) = (0.0, beyond(degrees));
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

/// More than any of these quantiles: mean k, variance 2 k, and a tail that decays as exp(-x/2).
fn beyond(degrees: f64) -> f64 {
    degrees + 10.0 * (2.0 * degrees).sqrt() + 100.0
}
