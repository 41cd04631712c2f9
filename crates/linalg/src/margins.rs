//! Gain, phase, delay and modulus margins of a loop with one input, `1 + L = 0`, from `L(s) = C (s I - A)^-1 B + D`.
//!
//! The loop is closed by negative feedback. Its gain crossovers, `|L| = 1`, are imaginary eigenvalues of a Hamiltonian
//! pencil, those of `1 - L(s)L(-s) = 0`; its phase crossovers, L real, are imaginary zeros of
//! ```text
//! L(s) - L(-s) = [C C] (s I - [A 0; 0 -A])^-1 [B; B].
//! ```
//! Rounding moves such zeros off the axis, so that the frequencies of all are candidates: between two of them there is
//! no crossover. Each change of sign of `|L| - 1` and of `Im L` between points that the candidates separate is bisected
//! on the response itself to its last digits. A frequency at which `|L|` touches 1, or L the real axis, without
//! crossing is not found.
//!
//! In discrete time the same is done for `w = tan(angle/2)`, the frequency after Tustin's transformation; the responses
//! are those of the plant as given.

use nalgebra::{Complex, DMatrix};
use std::f64::consts::{PI, TAU};

use crate::argument::shaped;
use crate::system_norm::{block_diagonal, frequencies_of_singular_value};
use crate::{
    Discretization, FrequencyResponse, HInfinityNorm, LinalgError, Realization, Result, d2c, discrete_h_infinity_norm,
    eigenvalues, h_infinity_norm, invariant_zeros,
};

/// Halvings of the logarithm of an interval: 1100 binary decades at most, then the 52 digits.
const BISECTIONS: usize = 70;
/// Nearer to a pole on the axis than this factor of `|L|` between its neighbours, a change of sign is that of the pole.
const POLE: f64 = 1e6;
/// An imaginary part is that of a real L up to rounding.
const REAL: f64 = 1e-6;
/// A value of the order of one has no sign below this.
const ROUNDING: f64 = 1e-13;
/// At an end of the axis a loop that is larger has a pole there, but for rounding.
const LARGEST: f64 = 1e12;

/// A frequency at which L is real and negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GainMargin {
    /// The frequency, in radians per unit of time, in discrete time per sample. 0 and the end of the axis included,
    /// which is infinite in continuous time, pi in discrete time.
    pub frequency: f64,
    /// The factor of L that brings it to -1 there, `1/|L|`: above 1 the gain may rise by less, below 1 fall by less.
    pub factor: f64,
}

/// A frequency at which `|L| = 1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseMargin {
    /// The frequency, in radians per unit of time, in discrete time per sample.
    pub frequency: f64,
    /// `pi + arg L`, from -pi to pi: the lag that brings L to -1 there; a lead where it is negative.
    pub angle: f64,
    /// The delay, in units of time, in discrete time in samples, that does so.
    pub delay: f64,
}

/// How far a loop is from instability.
#[derive(Debug, Clone, PartialEq)]
pub struct StabilityMargins {
    /// Whether the closed loop is stable, to working precision. If not, the margins do not say what keeps it stable.
    pub is_stable: bool,
    /// The eigenvalues of the closed loop, `A - B (1 + D)^-1 C`.
    pub poles: Vec<Complex<f64>>,
    /// At the phase crossovers, by frequency.
    pub gain: Vec<GainMargin>,
    /// At the gain crossovers, by frequency.
    pub phase: Vec<PhaseMargin>,
    /// The H-infinity norm of the sensitivity `S = 1/(1 + L)`, `1/min |1 + L|`, and where; none if it is not stable.
    pub sensitivity: Option<HInfinityNorm>,
}

impl StabilityMargins {
    /// The least factor above 1 by which the gain may rise.
    pub fn gain_margin(&self) -> Option<GainMargin> {
        self.gain.iter().filter(|one| one.factor > 1.0).min_by(|x, y| x.factor.total_cmp(&y.factor)).copied()
    }

    /// The largest factor below 1 to which it may fall.
    pub fn gain_reduction(&self) -> Option<GainMargin> {
        self.gain.iter().filter(|one| one.factor < 1.0).max_by(|x, y| x.factor.total_cmp(&y.factor)).copied()
    }

    /// The smallest angle.
    pub fn phase_margin(&self) -> Option<PhaseMargin> {
        self.phase.iter().min_by(|x, y| x.angle.abs().total_cmp(&y.angle.abs())).copied()
    }

    /// The shortest delay.
    pub fn delay_margin(&self) -> Option<PhaseMargin> {
        self.phase.iter().min_by(|x, y| x.delay.total_cmp(&y.delay)).copied()
    }

    /// `min |1 + L|` over all frequencies, the distance of L from -1; none if the loop is not stable.
    pub fn modulus_margin(&self) -> Option<f64> {
        self.sensitivity.map(|found| found.norm.recip())
    }
}

/// The margins of the loop `1 + L = 0` in continuous time.
///
/// `open` is L, with one input and one output, negative feedback. Cost: `66 (2n)^3` flops for each of two sets of
/// zeros, and the H-infinity norm of the sensitivity.
///
/// ```
/// use luenberger_linalg::{Realization, stability_margins};
/// use nalgebra::dmatrix;
/// // L = 4/(s + 1)^3 has the phase -180 degrees at sqrt(3), where |L| = 4/8.
/// let a = dmatrix![-1.0, 1.0, 0.0; 0.0, -1.0, 1.0; 0.0, 0.0, -1.0];
/// let open = Realization::new(&a, &dmatrix![0.0; 0.0; 4.0], &dmatrix![1.0, 0.0, 0.0], &dmatrix![0.0])?;
/// let found = stability_margins(&open)?;
/// let margin = found.gain_margin().ok_or("a margin")?;
/// assert!((margin.factor - 2.0).abs() < 1e-13 && (margin.frequency - 3f64.sqrt()).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Those of [`Realization::new`]; [`LinalgError::DimensionMismatch`] for a loop with several inputs or outputs,
/// [`LinalgError::Singular`] where `1 + D = 0`; those of [`invariant_zeros`] and
/// [`h_infinity_norm`].
pub fn stability_margins(open: &Realization) -> Result<StabilityMargins> {
    margins(open, FrequencyResponse::continuous(open)?, None)
}

/// The same in discrete time: frequencies in radians per sample, delays in samples.
///
/// # Errors
/// As [`stability_margins`].
pub fn discrete_stability_margins(open: &Realization) -> Result<StabilityMargins> {
    let response = FrequencyResponse::discrete(open)?;
    // With a pole at -1 the frequencies are those of z -> -z, from the other end.
    let (continued, is_mirrored) = match d2c(open, 2.0, Discretization::Tustin) {
        Ok(continued) => (continued, false),
        Err(LinalgError::Singular { .. }) => {
            let Realization { a, b, c, d } = open;
            let mirrored = Realization { a: -a, b: b.clone(), c: -c, d: d.clone() };
            (d2c(&mirrored, 2.0, Discretization::Tustin)?, true)
        }
        Err(error) => return Err(error),
    };
    margins(open, response, Some((&continued, is_mirrored)))
}

fn margins(
    open: &Realization,
    response: FrequencyResponse,
    continued: Option<(&Realization, bool)>,
) -> Result<StabilityMargins> {
    if open.d.shape() != (1, 1) {
        return Err(LinalgError::DimensionMismatch { what: "the loop", expected: (1, 1), found: open.d.shape() });
    }
    let (poles, sensitivity) = peak_if_stable(&sensitivity(open)?, response.is_discrete())?;
    let axis = Axis { response, is_mirrored: continued.is_some_and(|(_, is_mirrored)| is_mirrored) };
    let (gain, phase) = axis.crossovers(continued.map_or(open, |(continued, _)| continued))?;
    Ok(StabilityMargins { is_stable: sensitivity.is_some(), poles, gain, phase, sensitivity })
}

/// The sensitivity `S = (I + L)^-1` of a loop L with as many inputs as outputs, negative feedback:
/// `(I + D)^-1 - (I + D)^-1 C (s I - A + B (I + D)^-1 C)^-1 B (I + D)^-1`, in either time.
///
/// # Errors
/// Those of [`Realization::new`]; [`LinalgError::DimensionMismatch`] for a loop that is not square,
/// [`LinalgError::Singular`] where `I + D` is.
pub fn sensitivity(open: &Realization) -> Result<Realization> {
    open.check()?;
    let Realization { a, b, c, d } = open;
    shaped("the loop", d, b.ncols(), b.ncols())?;
    let inverse = return_difference(d)?;
    let input = b * &inverse;
    Ok(Realization { a: a - &input * c, c: -(&inverse * c), b: input, d: inverse })
}

/// `(I + D)^-1`.
pub(crate) fn return_difference(d: &DMatrix<f64>) -> Result<DMatrix<f64>> {
    let singular = LinalgError::Singular { what: "I + D", condition: f64::INFINITY };
    let inverse = (DMatrix::identity(d.nrows(), d.nrows()) + d).try_inverse();
    inverse.filter(|m| m.iter().all(|x| x.is_finite())).ok_or(singular)
}

/// The poles of a system, and its H-infinity norm if it is stable.
pub(crate) fn peak_if_stable(
    system: &Realization,
    is_discrete: bool,
) -> Result<(Vec<Complex<f64>>, Option<HInfinityNorm>)> {
    let Realization { a, b, c, d } = system;
    let poles = eigenvalues(a)?;
    let is_stable = poles.iter().all(|pole| if is_discrete { pole.norm() < 1.0 } else { pole.re < 0.0 });
    let peak = match (is_stable, is_discrete) {
        (false, _) => None,
        (true, false) => Some(h_infinity_norm(a, b, c, d)?),
        (true, true) => Some(discrete_h_infinity_norm(a, b, c, d)?),
    };
    Ok((poles, peak))
}

/// The frequencies of a loop as those of continuous time.
struct Axis {
    response: FrequencyResponse,
    /// Whether w belongs to -z.
    is_mirrored: bool,
}

impl Axis {
    /// The frequency of w: of `tan(angle/2)`, in discrete time.
    fn frequency(&self, w: f64) -> f64 {
        match (self.response.is_discrete(), self.is_mirrored) {
            (false, _) => w,
            (true, false) => 2.0 * w.atan(),
            (true, true) => PI - 2.0 * w.atan(),
        }
    }

    fn at(&self, frequency: f64) -> Complex<f64> {
        self.response.at(frequency)[(0, 0)]
    }

    fn crossovers(&self, open: &Realization) -> Result<(Vec<GainMargin>, Vec<PhaseMargin>)> {
        let poles = eigenvalues(&open.a)?;
        let poles: Vec<f64> = poles.iter().flat_map(|pole| [pole.im.abs(), pole.norm()]).collect();
        let candidates = [&poles[..], &gain_candidates(open)?].concat();
        let mut phase: Vec<PhaseMargin> = Vec::new();
        for frequency in self.changes(candidates, |z| z.norm() - 1.0) {
            let angle = (-self.at(frequency)).arg();
            phase.push(PhaseMargin { frequency, angle, delay: angle.rem_euclid(TAU) / frequency });
        }
        let inner = match phase_candidates(open)? {
            Some(candidates) => self.changes([&poles[..], &candidates].concat(), |z| z.im / z.norm()),
            None => Vec::new(),
        };
        let mut gain: Vec<GainMargin> = Vec::new();
        let end = if self.response.is_discrete() { PI } else { f64::INFINITY };
        for frequency in inner.into_iter().chain([0.0, end]) {
            let at = self.at(frequency);
            if at.re < 0.0 && at.re > -LARGEST && at.im.abs() <= REAL * at.re.abs() {
                gain.push(GainMargin { frequency, factor: at.norm().recip() });
            }
        }
        phase.sort_by(|x, y| x.frequency.total_cmp(&y.frequency));
        gain.sort_by(|x, y| x.frequency.total_cmp(&y.frequency));
        Ok((gain, phase))
    }

    /// The frequencies at which a function of L, of the order of one, changes its sign, between points that the
    /// candidates separate.
    fn changes(&self, candidates: Vec<f64>, value: impl Fn(Complex<f64>) -> f64) -> Vec<f64> {
        let mut candidates: Vec<f64> = candidates.into_iter().filter(|w| *w > 0.0 && w.is_finite()).collect();
        candidates.sort_by(f64::total_cmp);
        candidates.dedup();
        let (Some(first), Some(last)) = (candidates.first(), candidates.last()) else { return Vec::new() };
        let between = candidates.windows(2).map(|pair| mean(pair[0], pair[1]));
        let points = std::iter::once(0.5 * first).chain(between).chain([2.0 * last]);
        let at = |w: f64| self.at(self.frequency(w));
        let known = points.map(|w| (w, at(w))).filter(|(_, z)| value(*z).abs() > ROUNDING);
        let known: Vec<(f64, Complex<f64>)> = known.collect();
        let mut found = Vec::new();
        for ends in known.windows(2) {
            let [(mut low, below), (mut high, above)] = [ends[0], ends[1]];
            if value(below) * value(above) > 0.0 {
                continue;
            }
            for _ in 0..BISECTIONS {
                let middle = mean(low, high);
                if !(middle > low && middle < high) {
                    break;
                }
                if value(at(middle)) * value(below) > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            if at(high).norm() <= POLE * below.norm().max(above.norm()) {
                found.push(self.frequency(high));
            }
        }
        found
    }
}

/// The geometric mean.
fn mean(x: f64, y: f64) -> f64 {
    x.sqrt() * y.sqrt()
}

/// Frequencies at which `|L| = 1`.
fn gain_candidates(open: &Realization) -> Result<Vec<f64>> {
    let Realization { a, b, c, d } = open;
    frequencies_of_singular_value([a, b, c, d], 1.0)
}

/// Frequencies at which L is real; none where it is real at all of them.
fn phase_candidates(open: &Realization) -> Result<Option<Vec<f64>>> {
    let Realization { a, b, c, .. } = open;
    let n = a.nrows();
    let both = block_diagonal(a, &-a);
    let input = DMatrix::from_fn(2 * n, 1, |i, _| b[i % n]);
    let output = DMatrix::from_fn(1, 2 * n, |_, j| c[j % n]);
    let zeros = invariant_zeros(&both, &input, &output, &DMatrix::zeros(1, 1))?;
    Ok((!zeros.is_degenerate()).then(|| zeros.zeros.iter().map(|z| z.im.abs()).collect()))
}
