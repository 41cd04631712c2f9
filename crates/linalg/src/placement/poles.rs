//! Requested poles: validation, conjugate pairs, and matching with the achieved poles.

use nalgebra::Complex;

use crate::units::shift;
use crate::{LinalgError, Result};

/// n poles closed under conjugation.
#[derive(Debug, Clone)]
pub(super) struct RequestedPoles {
    /// Real poles.
    pub(super) real: Vec<f64>,
    /// The pole of each pair with positive imaginary part.
    pub(super) pairs: Vec<Complex<f64>>,
    /// All poles in the order given, conjugates made exact.
    given: Vec<Complex<f64>>,
}

/// Relative tolerance for two poles to count as conjugate, or for one as real: the accuracy of a root finder.
const CONJUGATE: f64 = 64.0 * f64::EPSILON;

impl RequestedPoles {
    pub(super) fn new(poles: &[Complex<f64>], order: usize) -> Result<Self> {
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
    pub(super) fn poles(&self) -> &[Complex<f64>] {
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

    /// The pole repeated most often, and how often.
    fn most_repeated(&self) -> (Complex<f64>, usize) {
        let count = |p: &Complex<f64>| self.given.iter().filter(|q| *q == p).count();
        self.given.iter().map(|p| (*p, count(p))).fold((Complex::from(0.0), 0), |x, y| if y.1 > x.1 { y } else { x })
    }

    /// Error if a pole is repeated more than `rank` times, with several inputs.
    pub(super) fn allowed_by(&self, rank: usize) -> Result<()> {
        let (pole, multiplicity) = self.most_repeated();
        if rank > 1 && multiplicity > rank {
            return Err(LinalgError::PoleMultiplicity { pole, multiplicity, rank });
        }
        Ok(())
    }

    /// Whether a closed loop with these poles and `rank` inputs is defective.
    pub(super) fn is_defective(&self, rank: usize) -> bool {
        self.most_repeated().1 > rank
    }

    /// For each requested pole, the index of the achieved pole matched to it (equal numbers): nearest pairs first.
    pub(super) fn matched(&self, achieved: &[Complex<f64>]) -> Vec<usize> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn c(re: f64, im: f64) -> Complex<f64> {
        Complex::new(re, im)
    }

    #[test]
    fn pairs_are_found_in_any_order_and_made_exact() {
        let requested =
            RequestedPoles::new(&[c(-1.0, 2.0), c(-3.0, 0.0), c(-1.0, -2.0 - 2e-16), c(-1.0, -2.0), c(-1.0, 2.0)], 5)
                .unwrap();
        assert_eq!(requested.real, [-3.0]);
        assert_eq!(requested.pairs.len(), 2);
        assert_eq!(requested.poles()[0], requested.poles()[3].conj());
    }

    #[test]
    fn what_is_wrong_is_named() {
        let half = [c(-1.0, 0.0), c(-2.0, 1.0), c(-2.0, -1.0 - 1e-9)];
        assert_eq!(RequestedPoles::new(&half, 3).unwrap_err(), LinalgError::PoleUnpaired { pole: half[1] });
        assert_eq!(RequestedPoles::new(&half[..1], 2).unwrap_err(), LinalgError::PoleCount { order: 2, found: 1 });
        let nan = RequestedPoles::new(&[c(-1.0, 0.0), c(f64::NAN, 0.0)], 2).unwrap_err();
        assert!(matches!(nan, LinalgError::PoleNotFinite { index: 1, .. }), "{nan}");
        let thrice = RequestedPoles::new(&[c(-1.0, 0.0); 3], 3).unwrap();
        let expected = LinalgError::PoleMultiplicity { pole: c(-1.0, 0.0), multiplicity: 3, rank: 2 };
        assert_eq!(thrice.allowed_by(2).unwrap_err(), expected);
        assert!(thrice.allowed_by(3).is_ok() && thrice.allowed_by(1).is_ok());
    }

    #[test]
    fn matching_takes_the_nearest_first() {
        let requested = RequestedPoles::new(&[c(-1.0, 0.0), c(-2.0, 0.0), c(0.0, 1.0), c(0.0, -1.0)], 4).unwrap();
        let achieved = [c(0.1, -1.0), c(-2.1, 0.0), c(-1.4, 0.0), c(0.1, 1.0)];
        assert_eq!(requested.matched(&achieved), [2, 1, 3, 0]);
    }
}
