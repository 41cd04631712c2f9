//! H-infinity and H2 norms: by a sweep of frequencies and by another solution of the Lyapunov equation.

use nalgebra::DMatrix;

use super::{Held, Matrices, Subject, Verdict, wrong};
use crate::words::document::Value;
use crate::words::linear;
use crate::words::plant::matrix as given;
use crate::words::sentences::{Claim, Sentence};

impl Subject<'_> {
    /// E, D and H of a filter.
    pub(super) fn performance(&self) -> Option<[DMatrix<f64>; 3]> {
        let e = self.own.get("e").and_then(given)?;
        let d = self.own.get("d").and_then(given)?;
        let h = self.own.get("h").and_then(given).unwrap_or_else(|| DMatrix::identity(self.n(), self.n()));
        Some([e, d, h])
    }

    pub(super) fn norm(&self, claim: Claim, sentence: &Sentence) -> Verdict {
        let (Some((a, l, c)), Some([e, d, h])) = (self.error(), self.performance()) else { return Ok(Held::Unchecked) };
        let gamma = sentence.number(0).unwrap_or(f64::NAN);
        let (f, g) = (&a - &l * &c, &e - &l * &d);
        let (found, slack) = if claim == Claim::H2 {
            let Some(found) = linear::h2_norm(&f, &g, &h, self.is_discrete()) else { return Ok(Held::Unchecked) };
            (found, 1e-6)
        } else {
            (linear::swept_norm(&f, &g, &h, self.is_discrete(), 200), 1e-7)
        };
        if found > gamma * (1.0 + slack) {
            return Err(wrong(format!("the norm is {found:e}, above gamma = {gamma:e}")));
        }
        Ok(Held::Computed)
    }

    pub(super) fn no_gain_of_norm(&self, sentence: &Sentence) -> Verdict {
        let (Some(Matrices { a, c, .. }), Some([e, d, h])) = (self.matrices(), self.performance()) else {
            return Ok(Held::Unchecked);
        };
        let least = sentence.number(1).unwrap_or(f64::NAN);
        let limit = self.own.get("max_gain").and_then(Value::number);
        let is_h2 = sentence.hole(0) == "H2";
        let is_discrete = self.is_discrete();
        let of = |l: &DMatrix<f64>| {
            let (f, g) = (&a - l * &c, &e - l * &d);
            if is_h2 {
                linear::h2_norm(&f, &g, &h, is_discrete)
            } else {
                let is_stable = if is_discrete { linear::radius(&f) < 1.0 } else { linear::abscissa(&f) < 0.0 };
                is_stable.then(|| linear::swept_norm(&f, &g, &h, is_discrete, 400) * 1.001)
            }
        };
        let mut gains = Vec::new();
        if !is_discrete {
            let gamma = (!is_h2).then_some(least * 0.99);
            gains.extend(linear::filter_gain(&a, &c, [&e, &d, &h], None));
            gains.extend(gamma.and_then(|gamma| linear::filter_gain(&a, &c, [&e, &d, &h], Some(gamma))));
        }
        let mut random = self.random.borrow_mut();
        let size = (a.amax() / c.amax().max(f64::MIN_POSITIVE)).max(f64::MIN_POSITIVE);
        for _ in 0..30 {
            let scale = size * 10f64.powf(random.between(-2.0, 6.0));
            gains.push(random.matrix(a.nrows(), c.nrows()) * scale);
        }
        for l in &gains {
            if limit.is_some_and(|limit| l.norm() > limit) {
                continue;
            }
            if let Some(found) = of(l).filter(|found| *found < least * (1.0 - 1e-3)) {
                let l: Vec<f64> = l.iter().copied().collect();
                return Err(wrong(format!("the gain {l:?} makes it {found:e}, less than {least:e}")));
            }
        }
        Ok(Held::Computed)
    }
}
