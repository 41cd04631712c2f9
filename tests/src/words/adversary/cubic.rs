//! The decrease of V along cubic observers, at errors of all magnitudes.

use luenberger_observers::{CubicObserver, SampledCubicObserver};
use nalgebra::{DMatrix, Dyn};

use super::{Held, Subject, Verdict, Wrong, wrong};
use crate::words::said::{Said, matrix};
use crate::words::sentences::Sentence;

impl Subject<'_> {
    pub(super) fn cubic(&self, within: f64, said: &Said, beside_linear: bool) -> Verdict {
        let Some(designed) = self.designed else { return Ok(Held::Unchecked) };
        let (Some(p), Some((a, l, c))) = (matrix(&designed.report, "P"), self.error()) else {
            return Ok(Held::Unchecked);
        };
        if within == f64::INFINITY && said.sealed.is_some_and(|sealed| sealed.ball.is_some()) {
            return Err(wrong("the certificate has a ball".to_owned()));
        }
        if designed.runnable.of::<CubicObserver<f64, Dyn, Dyn, Dyn>>().is_none() {
            return Ok(Held::Unchecked);
        }
        let (n, m) = (self.n(), self.plant.inputs.len());
        let (u, y) = (vec![0.0; m], vec![0.0; c.nrows()]);
        let f = &a - &l * &c;
        let mut random = self.random.borrow_mut();
        for _ in 0..20 {
            let size = 10f64.powf(random.between(-3.0, 8.0));
            let mut e = DMatrix::from_fn(n, 1, |_, _| random.unit() * size);
            if within.is_finite() && within > 0.0 && e.norm() >= within {
                e *= 0.999 * within / e.norm();
            }
            // The plant is at rest at 0: the estimate is -e, and both have the same V.
            let Some(motion) = designed.runnable.motion(0.0, e.as_slice(), &u, &y) else { return Ok(Held::Unchecked) };
            let motion = DMatrix::from_column_slice(n, 1, &motion);
            let linear = &f * &e;
            let pe = &p * &e;
            let (all, alone) = ((pe.transpose() * &motion)[0], (pe.transpose() * &linear)[0]);
            let terms: f64 = pe.iter().zip(motion.iter()).map(|(p, m)| (p * m).abs()).sum();
            let parts: f64 = pe
                .iter()
                .zip((a.map(f64::abs) * e.map(f64::abs) + l.map(f64::abs) * c.map(f64::abs) * e.map(f64::abs)).iter())
                .map(|(p, m)| (p * m).abs())
                .sum();
            // N y~ is rounded: an error of eps |P N y~|.
            let rounding =
                1e-11 * (terms + parts) * (1.0 + p.amax() * p.clone().try_inverse().map_or(0.0, |q| q.amax()) * 1e-4);
            if beside_linear && all > alone + rounding {
                return Err(wrong(format!(
                    "at e = {:?} V' is {all:e}, and {alone:e} without the cubic term",
                    e.as_slice()
                )));
            }
            if !beside_linear && all > rounding {
                return Err(wrong(format!("at e = {:?} V grows: V'/2 = {all:e}", e.as_slice())));
            }
        }
        Ok(Held::Computed)
    }

    pub(super) fn sampled_cubic(&self, sentence: &Sentence, said: &Said) -> Verdict {
        let Some(designed) = self.designed else { return Ok(Held::Unchecked) };
        let Some(p) = matrix(&designed.report, "P") else { return Ok(Held::Unchecked) };
        let slowest = said.number("largest modulus of a pole");
        let factor = sentence.number(1);
        if let (Some(slowest), Some(factor)) = (slowest, factor)
            && factor < slowest * slowest * (1.0 - 1e-9)
        {
            return Err(Wrong::Rounded(format!("the factor {factor} is less than {}", slowest * slowest)));
        }
        let sampled = designed.runnable.of::<SampledCubicObserver<f64, Dyn, Dyn, Dyn>>();
        let Some(observer) = sampled else { return Ok(Held::Computed) };
        // The theorem is about exact arithmetic. What the rounding of a step moves: A xhat and L z cancel where the
        // plant grows by many orders of magnitude in a period.
        let moved = observer.ad().map(f64::abs) + observer.ld().map(f64::abs) * observer.c().map(f64::abs);
        let (n, m) = (self.n(), self.plant.inputs.len());
        let (u, y) = (vec![0.0; m], vec![0.0; self.plant.outputs.len()]);
        let mut random = self.random.borrow_mut();
        for _ in 0..20 {
            let size = 10f64.powf(random.between(-3.0, 6.0));
            let e = DMatrix::from_fn(n, 1, |_, _| random.unit() * size);
            let Some(next) = designed.runnable.motion(0.0, e.as_slice(), &u, &y) else { return Ok(Held::Unchecked) };
            let next = DMatrix::from_column_slice(n, 1, &next);
            let v = |e: &DMatrix<f64>| (e.transpose() * &p * e)[0];
            let size = |e: &DMatrix<f64>| (e.map(f64::abs).transpose() * p.map(f64::abs) * e.map(f64::abs))[0];
            let rounding = size(&(&moved * e.map(f64::abs) * (16.0 * n as f64 * f64::EPSILON)));
            // |e+| <= |e| + |rounding| in the norm of P.
            let most = (v(&e).max(0.0).sqrt() + rounding.sqrt()).powi(2);
            if v(&next) > most + 1e-9 * (size(&e) + size(&next)) {
                return Err(wrong(format!("from e = {:?} V grows from {:e} to {:e}", e.as_slice(), v(&e), v(&next))));
            }
        }
        Ok(Held::Computed)
    }
}
