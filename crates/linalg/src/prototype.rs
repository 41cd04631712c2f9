//! Poles from the specifications of a response: settling time, damping or overshoot, and prototype filters.
//!
//! | pattern | poles |
//! |---|---|
//! | dominant pair | a pair with the damping, the others real and further left |
//! | Bessel | maximally flat group delay: hardly any overshoot |
//! | Butterworth | on a circle: maximally flat frequency response |
//! | ITAE | least integral of `t |e|` of the step response (Graham and Lathrop, AIEE Trans. 72, 1953), up to order 6 |
//!
//! A prototype is scaled in time so that its step response stays within the band from the given settling time on. The
//! initial error of an observer with these poles decays about as fast, depending on its direction.

use nalgebra::{Complex, DMatrix};

use crate::discretize::zero_order_hold;
use crate::spectrum::eigenvalues;
use crate::{LinalgError, Result};

/// A pattern of poles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PolePattern {
    /// A complex pair with the given damping ratio, and for higher orders real poles further left, each 10 % faster
    /// than the previous one.
    Dominant {
        /// Damping ratio of the pair, `0 < damping <= 1`.
        damping: f64,
        /// Real part of the first other pole, relative to that of the pair; greater than one.
        ratio: f64,
    },
    /// Bessel filter.
    Bessel,
    /// Butterworth filter.
    Butterworth,
    /// Filter with the least integral of time-weighted absolute error (ITAE).
    Itae,
}

/// Largest order of a Bessel or Butterworth filter, and of a dominant pair with its additional poles.
const LARGEST: usize = 20;
const LARGEST_DOMINANT: usize = 1000;

/// Coefficients of the ITAE polynomials of order 2 to 6, highest power first, without the first and the last, which are
/// 1 (Dorf, Bishop, Modern Control Systems, table 5.6).
const ITAE: [&[f64]; 5] =
    [&[1.4], &[1.75, 2.15], &[2.1, 3.4, 2.7], &[2.8, 5.0, 5.5, 3.4], &[3.25, 6.6, 8.6, 7.45, 3.95]];

/// Damping ratio of a pair of poles whose step response overshoots by the fraction o:
/// `zeta = -ln o / sqrt(pi^2 + ln^2 o)`.
///
/// # Errors
/// [`LinalgError::InvalidSpecification`] unless `0 < overshoot < 1`.
///
/// # Example
/// ```
/// use luenberger_linalg::damping_from_overshoot;
/// let zeta = damping_from_overshoot(0.05)?;
/// assert!((zeta - 0.690).abs() < 1e-3);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
/// Source: Franklin, Powell, Emami-Naeini, Feedback Control of Dynamic Systems, section 3.4.
pub fn damping_from_overshoot(overshoot: f64) -> Result<f64> {
    let overshoot = within("the overshoot", overshoot, 0.0, 1.0)?;
    let log = -overshoot.ln();
    Ok(log / core::f64::consts::PI.hypot(log))
}

/// Continuous-time poles of a pattern whose step response stays within `band` of its final value from `settling_time`
/// on.
///
/// `order >= 1` is the number of poles, `settling_time > 0` in the unit of time, `0 < band < 1` (0.02 is usual). For a
/// complex dominant pair the settling time is that of its envelope, `-ln(band sqrt(1 - zeta^2)) / (zeta w)`; for a
/// double pole or a single one it is exact, ignoring the additional poles; for the other patterns it is that of the
/// step response itself. In discrete time use `e^{p h}`.
///
/// # Errors
/// [`LinalgError::InvalidSpecification`] names the number that is out of range.
///
/// # Example
/// Two poles that settle to 2 % in 1 s without overshoot.
/// ```
/// use luenberger_linalg::{PolePattern, poles_from};
/// let poles = poles_from(PolePattern::Dominant { damping: 1.0, ratio: 5.0 }, 2, 1.0, 0.02)?;
/// assert!((poles[0].re + 5.834).abs() < 1e-3 && poles[0] == poles[1]);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn poles_from(pattern: PolePattern, order: usize, settling_time: f64, band: f64) -> Result<Vec<Complex<f64>>> {
    let settling_time = within("the settling time", settling_time, 0.0, f64::INFINITY)?;
    let band = within("the band", band, 0.0, 1.0)?;
    let largest = match pattern {
        PolePattern::Dominant { .. } => LARGEST_DOMINANT,
        PolePattern::Bessel | PolePattern::Butterworth => LARGEST,
        PolePattern::Itae => ITAE.len() + 1,
    };
    if order == 0 || order > largest {
        let (what, low, high) = ("the order", 1.0, largest as f64);
        return Err(LinalgError::InvalidSpecification { what, value: order as f64, low, high });
    }
    let coefficients = match pattern {
        PolePattern::Dominant { damping, ratio } => return dominant(order, settling_time, band, damping, ratio),
        PolePattern::Bessel => bessel(order),
        PolePattern::Butterworth => return butterworth(order, settling_time, band),
        PolePattern::Itae if order == 1 => vec![1.0, 1.0],
        PolePattern::Itae => [&[1.0], ITAE[order - 2], &[1.0]].concat(),
    };
    let poles = eigenvalues(&companion(&coefficients))?;
    scaled(poles, settling_time, band)
}

/// Error unless `low < value < high`.
fn within(what: &'static str, value: f64, low: f64, high: f64) -> Result<f64> {
    if value > low && value < high {
        Ok(value)
    } else {
        Err(LinalgError::InvalidSpecification { what, value, low, high })
    }
}

fn dominant(order: usize, settling: f64, band: f64, damping: f64, ratio: f64) -> Result<Vec<Complex<f64>>> {
    if !(damping > 0.0 && damping <= 1.0) {
        let what = "the damping ratio";
        return Err(LinalgError::InvalidSpecification { what, value: damping, low: 0.0, high: 1.0 });
    }
    let ratio = within("the ratio of the other poles", ratio, 1.0, f64::INFINITY)?;
    if order == 1 {
        return Ok(vec![Complex::from(band.ln() / settling)]);
    }
    if damping == 1.0 {
        // Solves (1 + w t) e^{-w t} = band for w t by fixed-point iteration.
        let mut w = -band.ln();
        for _ in 0..100 {
            w = (1.0 + w).ln() - band.ln();
        }
        let pole = Complex::from(-w / settling);
        return Ok(with_others(vec![pole, pole], order, ratio));
    }
    let root = (1.0 - damping * damping).sqrt();
    let real = (band * root).ln() / settling;
    let imaginary = -real / damping * root;
    Ok(with_others(vec![Complex::new(real, imaginary), Complex::new(real, -imaginary)], order, ratio))
}

/// Adds real poles to the left of the pair, each 10 % faster than the previous one.
fn with_others(mut pair: Vec<Complex<f64>>, order: usize, ratio: f64) -> Vec<Complex<f64>> {
    let real = pair[0].re;
    pair.extend((0..order - 2).map(|k| Complex::from(real * ratio * 1.1f64.powf(k as f64))));
    pair
}

/// Coefficients of the reverse Bessel polynomial, highest power first, scaled so that the last one is 1.
fn bessel(order: usize) -> Vec<f64> {
    // a_k = (2n - k)! / (2^(n-k) k! (n-k)!), a_n = 1, from a_{k-1} = a_k (2n - k + 1) k / (2 (n - k + 1)).
    let n = order as f64;
    let mut coefficients = vec![1.0];
    for k in (1..=order).rev() {
        let k = k as f64;
        let last = coefficients[coefficients.len() - 1];
        coefficients.push(last * (2.0 * n - k + 1.0) * k / (2.0 * (n - k + 1.0)));
    }
    let scale = coefficients[order].powf(1.0 / n);
    coefficients.iter().enumerate().map(|(k, a)| a / scale.powf(k as f64)).collect()
}

fn butterworth(order: usize, settling: f64, band: f64) -> Result<Vec<Complex<f64>>> {
    let angle = |k: usize| core::f64::consts::PI * (2 * k + 1 + order) as f64 / (2 * order) as f64;
    let poles = (0..order / 2).flat_map(|k| {
        let pole = Complex::from_polar(1.0, angle(k));
        [pole, pole.conj()]
    });
    scaled(poles.chain((order % 2 == 1).then(|| Complex::from(-1.0))).collect(), settling, band)
}

fn companion(coefficients: &[f64]) -> DMatrix<f64> {
    let n = coefficients.len() - 1;
    DMatrix::from_fn(n, n, |i, j| match (i, j) {
        (0, j) => -coefficients[j + 1],
        (i, j) if i == j + 1 => 1.0,
        _ => 0.0,
    })
}

/// Scales the poles in time so that the step response of the prototype settles at `settling`.
fn scaled(poles: Vec<Complex<f64>>, settling: f64, band: f64) -> Result<Vec<Complex<f64>>> {
    let natural = settling_time(&poles, band)?;
    Ok(poles.into_iter().map(|pole| pole * (natural / settling)).collect())
}

/// Time from which the step response of `prod(-p) / prod(s - p)` stays within `band` of 1.
fn settling_time(poles: &[Complex<f64>], band: f64) -> Result<f64> {
    let slowest = poles.iter().map(|pole| -pole.re).fold(f64::INFINITY, f64::min);
    let fastest = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    // A series of first- and second-order sections: well conditioned for every order.
    let n = poles.len();
    let (mut a, mut b) = (DMatrix::zeros(n, n), DMatrix::zeros(n, 1));
    let mut k = 0;
    for pole in poles.iter().filter(|pole| pole.im >= 0.0) {
        let last = if pole.im > 0.0 { k + 1 } else { k };
        let gain = if pole.im > 0.0 { pole.norm_sqr() } else { -pole.re };
        if pole.im > 0.0 {
            a[(k, k + 1)] = 1.0;
            a[(last, k)] = -gain;
            a[(last, last)] = 2.0 * pole.re;
        } else {
            a[(k, k)] = pole.re;
        }
        // The output of a section is its first state.
        match before(poles, k) {
            Some(output) => a[(last, output)] = gain,
            None => b[(last, 0)] = gain,
        }
        k = last + 1;
    }
    let output = before(poles, n).unwrap_or(0);
    let step = 1e-3 / fastest;
    let held = zero_order_hold(&a, &b, step)?;
    let mut x = DMatrix::zeros(n, 1);
    let (mut settled, mut error) = (0.0, 1.0_f64);
    // By then the slowest mode has decayed far below the band.
    let steps = ((-band.ln() + 10.0 * n as f64) / slowest / step).ceil().min(1e7) as usize;
    for count in 1..=steps {
        x = &held.ad * x + &held.bd;
        let next: f64 = (1.0 - x[output]).abs();
        if error > band && next <= band {
            settled = (count as f64 - 1.0 + (error - band) / (error - next)) * step;
        }
        error = next;
    }
    Ok(settled)
}

/// First state of the section before the one that begins at `k`.
fn before(poles: &[Complex<f64>], k: usize) -> Option<usize> {
    let mut start = 0;
    let mut last = None;
    for pole in poles.iter().filter(|pole| pole.im >= 0.0) {
        if start >= k {
            break;
        }
        last = Some(start);
        start += if pole.im > 0.0 { 2 } else { 1 };
    }
    last
}
