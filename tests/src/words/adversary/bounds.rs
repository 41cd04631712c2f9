//! Bounds under noise and disturbances at their limits.

use luenberger_observers::LinearObserver;
use luenberger_study::kinds::IntervalSpec;
use luenberger_study::study::ActingBounds;
use nalgebra::{DMatrix, Dyn};

use super::{Held, INTERVALS, Subject, Verdict, Wrong, rounded_up, wrong};
use crate::words::linear;
use crate::words::said::{Said, matrix};
use crate::words::sentences::{Sentence, listed};
use crate::words::simulate::{Acting, simulate};

impl Subject<'_> {
    pub(super) fn ultimate(&self, sentence: &Sentence) -> Verdict {
        let Some(bounds) = &self.spec.bounds else { return Ok(Held::Unchecked) };
        if bounds.uncertain.is_some() {
            return Ok(Held::Unchecked);
        }
        let limits = listed(sentence.hole(0));
        let Some(designed) = self.designed else { return Ok(Held::Unchecked) };
        let is_discrete = self.is_discrete();
        if !is_discrete && designed.runnable.of::<LinearObserver<f64, Dyn, Dyn, Dyn>>().is_none() {
            return self.ultimate_simulated(bounds, &limits, sentence.number(1));
        }
        // In discrete time L of an observer of a disturbance has further rows, and is left.
        let Some((a, l, c)) = self.error() else { return Ok(Held::Unchecked) };
        let g = acting(bounds, &l);
        let Some(peaks) = linear::peak_gains(&(&a - &l * &c), &g, is_discrete) else { return Ok(Held::Unchecked) };
        for (i, limit) in limits.iter().enumerate().take(peaks.nrows()) {
            let found: f64 = peaks.row(i).iter().sum();
            if found > limit * (1.0 + 1e-6) {
                return Err(wrong(format!(
                    "noise and disturbances within their bounds drive the error of {} to {found:e}, above {limit:e}",
                    self.plant.states[i]
                )));
            }
        }
        Ok(Held::Computed)
    }

    /// The bound of a cubic observer, from rest.
    pub(super) fn ultimate_simulated(&self, bounds: &ActingBounds, limits: &[f64], rate: Option<f64>) -> Verdict {
        let Some(rate) = rate.filter(|rate| *rate > 0.0) else { return Ok(Held::Unchecked) };
        let Some(designed) = self.designed else { return Ok(Held::Unchecked) };
        let n = self.n();
        let mut held = Held::Unchecked;
        for _ in 0..2 {
            let signs = self.signs(bounds.noise.len(), bounds.disturbance.len());
            let signals = |interval: usize, _: f64, _: &[f64]| {
                let (noise, w) = &signs[interval.min(signs.len() - 1)];
                Acting {
                    u: vec![0.0; self.plant.inputs.len()],
                    noise: noise.iter().zip(&bounds.noise).map(|(s, b)| s * b).collect(),
                    disturbance: (0..n)
                        .map(|i| w.iter().enumerate().map(|(j, s)| bounds.e[(i, j)] * s * bounds.disturbance[j]).sum())
                        .collect(),
                }
            };
            let experiment = self.experiment(vec![0.0; n], vec![0.0; n], &signals, 20.0 / rate);
            let Some(path) = simulate(self.plant, &designed.runnable, &experiment) else { return Ok(Held::Unchecked) };
            if !path.is_complete {
                continue;
            }
            held = Held::Simulated;
            let errors = path.errors();
            for (i, limit) in limits.iter().enumerate().take(n) {
                let worst = errors[2 * INTERVALS / 3..].iter().map(|e| e[i].abs()).fold(0.0, f64::max);
                let floor = 1e-7 * path.x.iter().map(|x| x[i].abs()).fold(0.0, f64::max);
                if worst > limit * (1.0 + 1e-6) + floor {
                    return Err(wrong(format!(
                        "within the bounds the error of {} is {worst:e} in the end, above {limit:e}",
                        self.plant.states[i]
                    )));
                }
            }
        }
        Ok(held)
    }

    /// Signs of noise and disturbances in each interval: changing at random, alternating, or constant.
    pub(super) fn signs(&self, noise: usize, disturbances: usize) -> Vec<(Vec<f64>, Vec<f64>)> {
        let mut random = self.random.borrow_mut();
        let rule = random.below(3);
        let period = 1 + random.below(12);
        let constant: Vec<f64> = (0..noise + disturbances).map(|_| random.sign()).collect();
        (0..INTERVALS)
            .map(|k| {
                let mut one = |j: usize| match rule {
                    0 => random.sign(),
                    1 => constant[j] * if (k / period).is_multiple_of(2) { 1.0 } else { -1.0 },
                    _ => constant[j],
                };
                let first: Vec<f64> = (0..noise).map(&mut one).collect();
                (first, (noise..noise + disturbances).map(one).collect())
            })
            .collect()
    }

    /// The bounds of an interval observer contain the state.
    pub(super) fn encloses(&self) -> Verdict {
        let (Some(designed), Some(spec)) = (self.designed, self.spec.kind.of::<IntervalSpec>()) else {
            return Ok(Held::Unchecked);
        };
        let n = self.n();
        let nothing = ActingBounds {
            noise: vec![0.0; self.plant.outputs.len()],
            disturbance: Vec::new(),
            e: DMatrix::zeros(n, 0),
            uncertain: None,
        };
        let bounds = self.spec.bounds.as_ref().unwrap_or(&nothing);
        if bounds.uncertain.is_some() {
            return Ok(Held::Unchecked);
        }
        let duration = if let Some(dt) = self.plant.dt {
            200.0 * dt
        } else {
            let f = matrix(&designed.report, "K").unwrap_or_else(|| DMatrix::identity(1, 1));
            8.0 / linear::abscissa(&f).abs().max(1e-9)
        };
        let mut held = Held::Unchecked;
        for _ in 0..2 {
            let estimate = self.spec.initial.clone();
            let corner: Vec<f64> = {
                let mut random = self.random.borrow_mut();
                estimate.iter().zip(&spec.initial_bounds).map(|(x, r)| x + r * random.sign()).collect()
            };
            let inputs = self.inputs(None);
            let signs = self.signs(bounds.noise.len(), bounds.disturbance.len());
            let signals = |interval: usize, t: f64, _: &[f64]| {
                let (noise, w) = &signs[interval.min(signs.len() - 1)];
                Acting {
                    u: inputs(t),
                    noise: noise.iter().zip(&bounds.noise).map(|(s, b)| s * b).collect(),
                    disturbance: (0..n)
                        .map(|i| w.iter().enumerate().map(|(j, s)| bounds.e[(i, j)] * s * bounds.disturbance[j]).sum())
                        .collect(),
                }
            };
            let experiment = self.experiment(corner, estimate, &signals, duration);
            let Some(path) = simulate(self.plant, &designed.runnable, &experiment) else { continue };
            let rows = DMatrix::from_fn(path.z.len(), path.z.first().map_or(0, Vec::len), |k, j| path.z[k][j]);
            let Some(widths) = designed.runnable.half_widths(&rows) else { return Ok(Held::Unchecked) };
            held = Held::Simulated;
            for (k, error) in path.errors().iter().enumerate() {
                for i in 0..n {
                    let floor = 1e-7 * (path.x[k][i].abs() + path.xhat[k][i].abs() + widths[(k, i)]);
                    if error[i].abs() > widths[(k, i)] + floor {
                        return Err(wrong(format!(
                            "at t = {:e} {} is {:e} from its estimate, and r = {:e}",
                            path.t[k],
                            self.plant.states[i],
                            error[i].abs(),
                            widths[(k, i)]
                        )));
                    }
                }
            }
        }
        Ok(held)
    }

    pub(super) fn widths(&self, sentence: &Sentence, said: &Said) -> Verdict {
        for (name, printed) in self.plant.states.iter().zip(listed(sentence.hole(0))) {
            rounded_up(Some(printed), said.number(&format!("half-width of {name} in the end")), "the half-width")?;
        }
        let of_rate = said.number("rate of the width");
        if let (Some(printed), Some(rate)) = (sentence.number(1), of_rate)
            && printed > rate
        {
            return Err(Wrong::Rounded(format!("the rate {printed} is more than {rate}")));
        }
        let (Some(designed), Some(rate)) = (self.designed, of_rate.filter(|rate| *rate > 0.0)) else {
            return Ok(Held::Computed);
        };
        let n = self.n();
        let quiet = |_: usize, _: f64, _: &[f64]| Acting { u: vec![0.0; self.plant.inputs.len()], ..Acting::default() };
        let experiment = self.experiment(vec![0.0; n], vec![0.0; n], &quiet, 30.0 / rate);
        let Some(path) = simulate(self.plant, &designed.runnable, &experiment).filter(|path| path.is_complete) else {
            return Ok(Held::Computed);
        };
        let last = path.z.last().cloned().unwrap_or_default();
        let Some(found) = designed.runnable.half_widths(&DMatrix::from_row_slice(1, last.len(), &last)) else {
            return Ok(Held::Computed);
        };
        for (i, printed) in listed(sentence.hole(0)).iter().enumerate().take(n) {
            // What is left of the first width after 30 time constants.
            let rest = 1e-11 * self.first_width();
            if found[(0, i)] > printed * (1.0 + 1e-5) + rest {
                return Err(wrong(format!(
                    "the half-width of {} tends to {:e}, above {printed:e}",
                    self.plant.states[i],
                    found[(0, i)]
                )));
            }
        }
        Ok(Held::Simulated)
    }

    /// What the largest bound of the first error makes of any entry, in the coordinates of the width.
    pub(super) fn first_width(&self) -> f64 {
        let Some(spec) = self.spec.kind.of::<IntervalSpec>() else { return 0.0 };
        let largest = self
            .designed
            .and_then(|designed| matrix(&designed.report, "T"))
            .map_or(1.0, |t| t.amax() * t.clone().try_inverse().map_or(1e6, |inverse| inverse.amax()));
        spec.initial_bounds.iter().fold(0.0, |most: f64, x| most.max(*x)) * (1.0 + largest)
    }
}

/// What noise and disturbances of magnitude 1 do to the error: (E W, -L V).
pub(super) fn acting(bounds: &ActingBounds, l: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, q, p) = (l.nrows(), bounds.disturbance.len(), l.ncols());
    DMatrix::from_fn(n, q + p, |i, j| {
        if j < q {
            bounds.e[(i, j)] * bounds.disturbance[j]
        } else {
            -l[(i, j - q)] * bounds.noise.get(j - q).copied().unwrap_or(0.0)
        }
    })
}
