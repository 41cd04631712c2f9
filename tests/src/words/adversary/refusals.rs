//! Claims of impossibility: no observer, no gain, not observable. Each needs one counterexample.

use nalgebra::DMatrix;

use super::{Held, Matrices, Subject, Verdict, wrong};
use crate::words::document::Value;
use crate::words::linear;
use crate::words::plant::matrix as given;

impl Subject<'_> {
    pub(super) fn not_observable(&self) -> Verdict {
        let Some(Matrices { a, c, .. }) = self.matrices() else { return Ok(Held::Unchecked) };
        if linear::unseen(&a, &c).rows == 0 {
            return Err(wrong("(C; CA; ..) has full rank, exactly: the plant is observable".to_owned()));
        }
        Ok(Held::Computed)
    }

    pub(super) fn is_observable(&self) -> Verdict {
        let Some(Matrices { a, c, .. }) = self.matrices() else { return Ok(Held::Unchecked) };
        if linear::unseen(&a, &c).rows > 0 {
            return Err(wrong("(C; CA; ..) does not have full rank, exactly".to_owned()));
        }
        Ok(Held::Computed)
    }

    pub(super) fn is_detectable(&self) -> Verdict {
        let Some(Matrices { a, c, .. }) = self.matrices() else { return Ok(Held::Unchecked) };
        if !linear::is_detectable(&a, &c, self.is_discrete()) {
            return Err(wrong("a mode that no output sees is not stable, exactly".to_owned()));
        }
        Ok(Held::Computed)
    }

    pub(super) fn not_detectable(&self) -> Verdict {
        let Some(Matrices { a, c, .. }) = self.matrices() else { return Ok(Held::Unchecked) };
        if linear::is_detectable(&a, &c, self.is_discrete()) {
            let other = self.proved.first().map_or_else(String::new, |name| format!("; `{name}` is proved"));
            return Err(wrong(format!("the modes that no output sees are stable, exactly{other}")));
        }
        Ok(Held::Computed)
    }

    pub(super) fn no_gain_of_width(&self) -> Verdict {
        let Some(Matrices { a, c, .. }) = self.matrices() else { return Ok(Held::Unchecked) };
        let (n, p) = (a.nrows(), c.nrows());
        // Each row of L is chosen to make one entry of A - LC zero, or to make it more stable.
        let choices = |i: usize| -> Vec<Vec<f64>> {
            let mut rows = vec![vec![0.0; p]];
            for k in 0..p {
                for j in 0..n {
                    if c[(k, j)] != 0.0 {
                        let mut row = vec![0.0; p];
                        row[k] = if j == i {
                            (a[(i, j)] + a.amax().max(1.0) * 3.0) / c[(k, j)]
                        } else {
                            a[(i, j)] / c[(k, j)]
                        };
                        rows.push(row);
                    }
                }
            }
            rows
        };
        let all: Vec<Vec<Vec<f64>>> = (0..n).map(choices).collect();
        let count: usize = all.iter().map(Vec::len).product();
        for code in 0..count.min(20_000) {
            let (mut rest, mut rows) = (code, Vec::new());
            for choices in &all {
                rows.push(&choices[rest % choices.len()]);
                rest /= choices.len();
            }
            let l = DMatrix::from_fn(n, p, |i, k| rows[i][k]);
            let closed = &a - &l * &c;
            let compared = DMatrix::from_fn(n, n, |i, j| {
                if i == j && !self.is_discrete() { closed[(i, j)] } else { closed[(i, j)].abs() }
            });
            // A Metzler matrix is Hurwitz iff the leading minors of its negative are positive; to be sure in floating
            // point, the off-diagonal part is enlarged by the rounding of the product.
            let slack = (&a.map(f64::abs) + l.map(f64::abs) * c.map(f64::abs)) * 4.0 * f64::EPSILON;
            let zero = DMatrix::zeros(n, 1);
            let above = compared + slack;
            let row = DMatrix::zeros(1, n);
            let is_stable = if self.is_discrete() {
                linear::contracts(&above, &zero, &row, 1.0)
            } else {
                linear::decays(&above, &zero, &row, 0.0)
            };
            if is_stable == Some(true) {
                let l: Vec<f64> = l.iter().copied().collect();
                return Err(wrong(format!("the gain {l:?} makes the comparison system stable")));
            }
        }
        Ok(Held::Computed)
    }

    pub(super) fn not_stable(&self, is_discrete: bool) -> Verdict {
        let (Some(Matrices { a, c, .. }), Some(l)) = (self.matrices(), self.own.get("gain").and_then(given)) else {
            return Ok(Held::Unchecked);
        };
        // Other kinds speak of the gain of another pair.
        let is_own = matches!(self.kind(), "luenberger" | "cubic" | "interval" | "h2" | "h-infinity");
        if !is_own || self.is_discrete() != is_discrete || l.nrows() != a.nrows() || l.ncols() != c.nrows() {
            return Ok(Held::Unchecked);
        }
        let is_stable = if is_discrete { linear::contracts(&a, &l, &c, 1.0) } else { linear::decays(&a, &l, &c, 0.0) };
        match is_stable {
            Some(true) => Err(wrong("A - LC with the given gain is stable, exactly".to_owned())),
            Some(false) => Ok(Held::Computed),
            None => Ok(Held::Unchecked),
        }
    }

    pub(super) fn infeasible(&self) -> Verdict {
        if !matches!(self.kind(), "luenberger" | "cubic") || self.own.has("max_gain") {
            return Ok(Held::Unchecked);
        }
        let Some(Matrices { a, c, .. }) = self.matrices() else { return Ok(Held::Unchecked) };
        let least = self.own.get("decay_rate").and_then(Value::number).unwrap_or(0.0);
        let least_or_more = least * (1.0 + 1e-9);
        let shifted = match self.plant.dt {
            Some(dt) => &a * (least_or_more * dt).exp(),
            None => &a + DMatrix::identity(a.nrows(), a.nrows()) * least_or_more,
        };
        if linear::is_detectable(&shifted, &c, self.is_discrete()) {
            return Err(wrong(format!("infeasible, and the unseen modes decay faster than {least}, exactly")));
        }
        Ok(Held::Computed)
    }

    pub(super) fn unmatched(&self) -> Verdict {
        let (Some(Matrices { c, .. }), Some(e)) = (self.matrices(), self.own.get("e").and_then(given)) else {
            return Ok(Held::Unchecked);
        };
        if e.ncols() == 1 && !linear::exact(&c).times(&linear::exact(&e)).is_zero() {
            return Err(wrong("C E is not 0, exactly".to_owned()));
        }
        Ok(Held::Computed)
    }
}
