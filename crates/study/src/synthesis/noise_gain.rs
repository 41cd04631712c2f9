//! How much measurement noise a constant gain lets into the estimate.
//!
//! With `F = A - L C` the error obeys `e' = F e - L v`. White noise v of intensity V leaves it with the covariance X of
//! `F X + X F' + L V L' = 0`; the noise gain is `sqrt(trace X)` for V = I. The noise of a study is held over its period
//! h: with variance S it leaves the covariance of `Phi X Phi' - X + G S G' = 0`, `Phi = exp(F h)`,
//! `G = int_0^h exp(F s) ds L`, at the end of each period; outputs are independent, and their covariances add. Of
//! several Jacobians (vertices) the largest counts. In discrete time the error obeys `e+ = F e - L v`, and white noise
//! of covariance V at each sample leaves it with the covariance X of `F X F' - X + L V L' = 0`.

use luenberger_linalg::{eigenvalues, lyapunov, stein, symmetric_part, zero_order_hold};
use nalgebra::{Complex, DMatrix, DVector};

use super::number;
use crate::results::{NamedNumber, Quantity};
use crate::study::{OutputNoise, Simulation, Study};

/// The noise gain of a design, and what it means for the noise of the study.
#[derive(Debug, Default)]
pub(crate) struct NoiseGain {
    norm: f64,
    gain: f64,
    ratio: Option<f64>,
    /// Standard deviation of the error of each state with the noise of the simulation; empty without noise.
    pub(crate) deviation: Vec<f64>,
}

impl NoiseGain {
    /// The noise gain of L for these pairs (A, C), of which `A - L C` is Hurwitz; for one pair with the eigenvalues of
    /// `A - L C`, where the design has them.
    pub(crate) fn of<'a>(
        study: &Study,
        pairs: impl IntoIterator<Item = (&'a DMatrix<f64>, &'a DMatrix<f64>)>,
        l: &DMatrix<f64>,
        poles: Option<&[Complex<f64>]>,
    ) -> Self {
        let simulation = study.simulation.as_ref().filter(|simulation| simulation.is_noisy());
        let mut worst = Self { norm: l.clone().svd(false, false).singular_values.max(), ..Self::default() };
        let (mut fastest, mut plant) = (0.0f64, 0.0f64);
        for (a, c) in pairs {
            let f = a - l * c;
            let white = lyapunov(&f.transpose(), &symmetric_part(&(l * l.transpose())));
            worst.gain = worst.gain.max(white.map_or(f64::NAN, |x| x.p.trace().max(0.0).sqrt()));
            if let Some(x) = simulation.and_then(|simulation| noise_covariance(&f, l, simulation)) {
                let deviation = x.diagonal().map(|variance| variance.max(0.0).sqrt());
                if worst.deviation.is_empty() {
                    worst.deviation = deviation.as_slice().to_vec();
                } else {
                    worst.deviation.iter_mut().zip(&deviation).for_each(|(most, one)| *most = most.max(*one));
                }
            }
            let modulus = |poles: &[Complex<f64>]| poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
            let modulus_of = |m: &DMatrix<f64>| eigenvalues(m).map_or(0.0, |poles| modulus(&poles));
            fastest = fastest.max(poles.map_or_else(|| modulus_of(&f), modulus));
            plant = plant.max(modulus_of(a));
        }
        worst.ratio = (plant > 0.0).then_some(fastest / plant);
        worst
    }

    /// The numbers of the report.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = NamedNumber> {
        let ratio = self.ratio.map(|ratio| number(Quantity::SpeedRatio, ratio));
        [number(Quantity::GainNorm, self.norm), number(Quantity::NoiseGain, self.gain)].into_iter().chain(ratio)
    }
}

/// Norm and noise gain of L in discrete time, for the stable `F = A - L C`.
pub(crate) fn at_samples(f: &DMatrix<f64>, l: &DMatrix<f64>) -> [NamedNumber; 2] {
    let white = stein(&f.transpose(), &symmetric_part(&(l * l.transpose())));
    let gain = white.map_or(f64::NAN, |x| x.p.trace().max(0.0).sqrt());
    let norm = l.clone().svd(false, false).singular_values.max();
    [number(Quantity::GainNorm, norm), number(Quantity::NoiseGain, gain)]
}

/// The stationary covariance of the error with the noise of the study; none if it does not exist in floating point.
fn noise_covariance(f: &DMatrix<f64>, l: &DMatrix<f64>, simulation: &Simulation) -> Option<DMatrix<f64>> {
    let noises: Vec<Option<OutputNoise>> = (0..l.ncols()).map(|output| simulation.noise_of(output)).collect();
    let mut periods: Vec<f64> = noises.iter().flatten().map(|noise| noise.period).collect();
    periods.sort_by(f64::total_cmp);
    periods.dedup();
    let mut sum = DMatrix::zeros(f.nrows(), f.nrows());
    for period in periods {
        let held = zero_order_hold(f, l, period).ok()?;
        let variance = |noise: &Option<OutputNoise>| noise.filter(|n| n.period == period).map_or(0.0, |n| n.variance());
        let s = DMatrix::from_diagonal(&DVector::from_iterator(noises.len(), noises.iter().map(variance)));
        let q = symmetric_part(&(&held.bd * s * held.bd.transpose()));
        sum += stein(&held.ad.transpose(), &q).ok()?.p;
    }
    Some(sum)
}
