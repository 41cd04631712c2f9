//! Requested poles: validation, conjugate pairs, and matching with the achieved poles.

use nalgebra::Complex;

use crate::staircase::Staircase;
use crate::units::shift;
use crate::{LinalgError, Result};

/// n poles closed under conjugation.
#[derive(Debug, Clone)]
pub struct RequestedPoles {
    /// Real poles.
    pub real: Vec<f64>,
    /// The pole of each pair with positive imaginary part.
    pub pairs: Vec<Complex<f64>>,
    /// All poles in the order given, conjugates made exact.
    given: Vec<Complex<f64>>,
}

/// Relative tolerance for two poles to count as conjugate, or for one as real: the accuracy of a root finder.
const CONJUGATE: f64 = 64.0 * f64::EPSILON;

impl RequestedPoles {
    /// The poles in pairs.
    ///
    /// # Errors
    /// Unless they are `order` finite numbers closed under conjugation.
    pub fn new(poles: &[Complex<f64>], order: usize) -> Result<Self> {
        for (index, pole) in poles.iter().enumerate() {
            if !(pole.re.is_finite() && pole.im.is_finite() && pole.norm().is_finite()) {
                return Err(LinalgError::PoleNotFinite { index, pole: *pole });
            }
        }
        if poles.len() != order {
            return Err(LinalgError::PoleCount { order, found: poles.len() });
        }
        let mut requested = Self { real: Vec::new(), pairs: Vec::new(), given: poles.to_vec() };
        let mut taken = vec![false; order];
        for (i, pole) in poles.iter().enumerate() {
            if taken[i] {
                continue;
            }
            taken[i] = true;
            let near = CONJUGATE * pole.norm();
            if pole.im.abs() <= near {
                requested.given[i].im = 0.0;
                requested.real.push(pole.re);
                continue;
            }
            let partner = (i + 1..order)
                .filter(|k| !taken[*k])
                .map(|k| (k, (poles[k].conj() - pole).norm()))
                .filter(|(_, distance)| *distance <= near)
                .min_by(|x, y| x.1.total_cmp(&y.1));
            let Some((k, _)) = partner else { return Err(LinalgError::PoleUnpaired { pole: *pole }) };
            taken[k] = true;
            let mean = pole + (poles[k].conj() - pole) / 2.0;
            requested.given[i] = mean;
            requested.given[k] = mean.conj();
            requested.pairs.push(Complex::new(mean.re, mean.im.abs()));
        }
        Ok(requested)
    }

    /// The poles in the order given.
    pub fn poles(&self) -> &[Complex<f64>] {
        &self.given
    }

    /// The same poles with time in other units.
    pub(super) fn in_time(&self, power: i32) -> Self {
        let scale = |p: &Complex<f64>| Complex::new(shift(p.re, power), shift(p.im, power));
        Self {
            real: self.real.iter().map(|x| shift(*x, power)).collect(),
            pairs: self.pairs.iter().map(scale).collect(),
            given: self.given.iter().map(scale).collect(),
        }
    }

    /// The poles and how often they are repeated, those first that are repeated most.
    fn repeated(&self) -> Vec<(Complex<f64>, usize)> {
        let mut all: Vec<(Complex<f64>, usize)> = Vec::new();
        for pole in &self.given {
            match all.iter_mut().find(|(other, _)| other == pole) {
                Some((_, times)) => *times += 1,
                None => all.push((*pole, 1)),
            }
        }
        all.sort_by_key(|(_, times)| core::cmp::Reverse(*times));
        all
    }

    /// Error if every closed loop with these poles is defective: see [`LinalgError::PoleMultiplicity`].
    pub(super) fn allowed_by(&self, stairs: &[usize]) -> Result<()> {
        let (mut multiplicity, mut allowed) = (0, 0);
        for (k, (pole, times)) in self.repeated().into_iter().enumerate() {
            multiplicity += times;
            allowed += stairs.get(k).copied().unwrap_or(0);
            if multiplicity > allowed {
                return Err(LinalgError::PoleMultiplicity { pole, poles: k + 1, multiplicity, rank: allowed });
            }
        }
        Ok(())
    }

    /// Whether all poles are at zero, of a controllable pair of which every closed loop with these poles is defective.
    pub(super) fn is_deadbeat(&self, staircase: &Staircase) -> bool {
        let at_zero = self.given.iter().all(|pole| pole.norm() == 0.0);
        at_zero && staircase.rank == self.given.len() && self.allowed_by(&staircase.stairs).is_err()
    }

    /// Whether a closed loop with these poles and `rank` inputs is defective.
    pub(super) fn is_defective(&self, rank: usize) -> bool {
        self.repeated().first().is_some_and(|(_, times)| *times > rank)
    }

    /// For each requested pole, the index of the achieved pole matched to it (equal numbers): nearest pairs first.
    pub fn matched(&self, achieved: &[Complex<f64>]) -> Vec<usize> {
        let n = self.given.len();
        let distance = |i: usize, k: usize| {
            let off: Complex<f64> = achieved[k] - self.given[i];
            let squares = off.norm_sqr();
            if (1e-280..1e280).contains(&squares) { squares.sqrt() } else { off.norm() }
        };
        let mut used = vec![false; n];
        let nearest = |i: usize, used: &[bool]| {
            let free = (0..n).filter(|k| !used[*k]).map(|k| (distance(i, k), k));
            free.min_by(|x, y| x.0.total_cmp(&y.0)).unwrap_or((f64::INFINITY, 0))
        };
        let mut candidates: Vec<(f64, usize)> = (0..n).map(|i| nearest(i, &used)).collect();
        let mut open: Vec<usize> = (0..n).collect();
        while let Some(at) = (0..open.len()).min_by(|x, y| candidates[open[*x]].0.total_cmp(&candidates[open[*y]].0)) {
            let (_, taken) = candidates[open.remove(at)];
            used[taken] = true;
            for i in &open {
                if candidates[*i].1 == taken {
                    candidates[*i] = nearest(*i, &used);
                }
            }
        }
        candidates.into_iter().map(|(_, k)| k).collect()
    }
}
