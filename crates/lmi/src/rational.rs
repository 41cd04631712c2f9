//! Small rationals near given numbers, by continued fractions.

/// The largest denominator that counts as small.
const LARGEST_DENOMINATOR: i64 = 64;

/// Integers proportional to a vector of small rationals within `tolerance` of `x` relative to its largest entry, if
/// there is one.
pub fn near_rational(x: &[f64], tolerance: f64) -> Option<Vec<i64>> {
    let largest = x.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return None;
    }
    let mut denominator = 1;
    let mut fractions = Vec::with_capacity(x.len());
    for &value in x {
        let (p, q) = fraction(value, tolerance * largest)?;
        fractions.push((p, q));
        denominator = least_common_multiple(denominator, q)?;
    }
    fractions.into_iter().map(|(p, q)| p.checked_mul(denominator / q)).collect()
}

/// The first convergent p/q of the continued fraction of `x` within `tolerance`, if its denominator is small.
fn fraction(x: f64, tolerance: f64) -> Option<(i64, i64)> {
    if x.abs() > 1e6 {
        return None;
    }
    let (mut p, mut q) = ((1i64, 0i64), (0i64, 1i64));
    let mut rest = x;
    // Denominators grow at least as Fibonacci's numbers, so ten terms pass any small denominator.
    for _ in 0..12 {
        let whole = rest.floor();
        let term = whole as i64;
        p = (term.checked_mul(p.0)?.checked_add(p.1)?, p.0);
        q = (term.checked_mul(q.0)?.checked_add(q.1)?, q.0);
        if q.0 > LARGEST_DENOMINATOR {
            return None;
        }
        if (x - p.0 as f64 / q.0 as f64).abs() <= tolerance {
            return Some((p.0, q.0));
        }
        rest = 1.0 / (rest - whole);
        if !rest.is_finite() || rest > 1e9 {
            return None;
        }
    }
    None
}

fn least_common_multiple(a: i64, b: i64) -> Option<i64> {
    let (mut x, mut y) = (a, b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    (a / x).checked_mul(b)
}
