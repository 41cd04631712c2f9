//! Claims of convergence, held against trajectories.

use luenberger_design::Region;
use luenberger_observers::sliding_mode::Discretisation;
use luenberger_study::kinds::{SlidingModeSpec, UnknownInput};
use nalgebra::{DMatrix, DVector};

use super::{BUDGET, Held, INTERVALS, Subject, TOLERANCE, TRIES, Verdict, Wrong, of_sentence, wrong};
use crate::words::linear;
use crate::words::said::{Said, matrix};
use crate::words::sentences::{Sentence, rate};
use crate::words::simulate::{Acting, Experiment, Path, Signals, norm, simulate};

impl Subject<'_> {
    /// An experiment of usual accuracy.
    pub(super) fn experiment<'b>(
        &self,
        x0: Vec<f64>,
        estimate: Vec<f64>,
        signals: &'b Signals<'b>,
        duration: f64,
    ) -> Experiment<'b> {
        Experiment {
            x0,
            estimate,
            state: None,
            signals,
            duration,
            intervals: INTERVALS,
            tolerance: self.tolerance.get(),
            budget: if self.tolerance.get() < TOLERANCE { 10 * BUDGET } else { BUDGET },
        }
    }

    /// The region of the design; none where it is everywhere.
    pub(super) fn region(&self) -> Option<Region> {
        self.spec.kind.region()
    }

    /// A first state and a first estimate within the bounds: anywhere, in a corner, or near a number of the equations.
    pub(super) fn start(&self, region: Option<&Region>) -> (Vec<f64>, Vec<f64>) {
        let mut random = self.random.borrow_mut();
        if let Some(simulation) = self.study.simulation.as_ref().filter(|_| random.once_in(3)) {
            return (simulation.x0.clone(), self.spec.initial.clone());
        }
        let numbers = self.plant.numbers();
        let rule = random.below(4);
        let sizes = [0.3, 1.0, 3.0, 20.0];
        let size = sizes[random.below(4)];
        let mut one = |k: usize| {
            let (low, high) =
                region.and_then(|region| region.states().get(k).copied()).unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
            let (low, high) = (low.max(-size), high.min(size));
            match rule {
                0 if !numbers.is_empty() => {
                    let near = numbers[random.below(numbers.len())] + 0.1 * random.unit();
                    near.clamp(low.min(high), high.max(low))
                }
                1 => {
                    if random.once_in(2) {
                        low + 0.02 * (high - low)
                    } else {
                        high - 0.02 * (high - low)
                    }
                }
                _ => random.between(low, high),
            }
        };
        let x: Vec<f64> = (0..self.n()).map(&mut one).collect();
        let estimate = (0..self.n()).map(one).collect();
        (x, estimate)
    }

    /// Inputs within the bounds of the region: 0, constant, a wave, or a switch.
    pub(super) fn inputs(&self, region: Option<&Region>) -> impl Fn(f64) -> Vec<f64> + use<> {
        let mut random = self.random.borrow_mut();
        let bounds: Vec<(f64, f64)> = (0..self.plant.inputs.len())
            .map(|k| {
                let given = region.and_then(Region::input_bounds).and_then(|all| all.get(k).copied());
                let (low, high) = given.unwrap_or((-2.0, 2.0));
                (low.max(-1e3), high.min(1e3))
            })
            .collect();
        let (rule, mut level, omega) = (random.below(5), random.unit(), random.between(0.3, 3.0));
        let numbers = self.plant.numbers();
        if rule == 0 && random.once_in(2) && !numbers.is_empty() {
            // Constant, near a number of the equations.
            level = numbers[random.below(numbers.len())] + 0.02 * random.unit();
        }
        let own = self.study.input.program().filter(|_| rule == 4).cloned();
        move |t: f64| {
            if let Some(program) = &own {
                let mut u = vec![0.0; bounds.len()];
                program.at(t, &mut u);
                return u;
            }
            if rule == 0 {
                return bounds.iter().map(|(low, high)| level.clamp(*low, *high)).collect();
            }
            let wave = match rule {
                1 => (omega * t).sin(),
                2 => (1.7 * omega * t).sin() * level,
                _ => level * (omega * t).cos(),
            };
            bounds.iter().map(|(low, high)| f64::midpoint(*low, *high) + 0.5 * (high - low) * wave).collect()
        }
    }

    /// The time in which the error decays, by its Jacobians at some points; for a claim without a rate.
    pub(super) fn horizon(&self, region: Option<&Region>) -> f64 {
        let Some(l) = self.gain() else { return 30.0 };
        let (n, p) = (self.n(), self.plant.outputs.len());
        let mut slow = f64::INFINITY;
        let mut fast = 0.0_f64;
        for _ in 0..3 {
            let (x, _) = self.start(region);
            let u = vec![0.0; self.plant.inputs.len()];
            let j = self.plant.jacobian(0.3, &x, &u);
            let mut seen = DMatrix::zeros(p, n);
            let (mut low, mut high, mut moved) = (vec![0.0; p], vec![0.0; p], x.clone());
            for k in 0..n {
                let delta = 1e-6 * x[k].abs().max(1e-3);
                moved[k] = x[k] + delta;
                self.plant.output(0.3, &moved, &u, &mut high);
                moved[k] = x[k] - delta;
                self.plant.output(0.3, &moved, &u, &mut low);
                moved[k] = x[k];
                (0..p).for_each(|i| seen[(i, k)] = (high[i] - low[i]) / (2.0 * delta));
            }
            if l.nrows() != n || l.ncols() != p {
                return 30.0;
            }
            for z in linear::eigenvalues(&(j - &l * seen)) {
                slow = slow.min(z.re.abs());
                fast = fast.max(z.norm());
            }
        }
        (25.0 / slow.max(1e-9 * fast).max(1e-12)).min(1e9)
    }

    /// `|e(t)| <= factor exp(-rate t) |e(0)|` as long as the states stay in the region; `z` for the mean-value
    /// observer, whose z is xhat + e.
    pub(super) fn envelope(&self, hypothesis: &str, factor: f64, rate: Option<f64>, is_of_z: bool) -> Verdict {
        let Some(designed) = self.designed else { return Ok(Held::Unchecked) };
        let Some(rate) = rate else { return Err(wrong(format!("no rate in `{hypothesis}`"))) };
        let region = self.region();
        let mut held = Held::Unchecked;
        for _ in 0..TRIES {
            let (x0, estimate) = self.start(region.as_ref());
            let inputs = self.inputs(region.as_ref());
            let signals = move |_: usize, t: f64, _: &[f64]| Acting { u: inputs(t), ..Acting::default() };
            let duration = if rate > 0.0 { 6.0 / rate } else { self.horizon(region.as_ref()) };
            let experiment = self.experiment(x0, estimate, &signals, duration);
            let Some(path) = simulate(self.plant, &designed.runnable, &experiment) else { continue };
            if path.t.len() > 3 {
                held = Held::Simulated;
            }
            if let Some(why) = self.breaks(&path, region.as_ref(), factor, rate, is_of_z) {
                let Experiment { x0, estimate, .. } = experiment;
                return Err(wrong(format!("from x(0) = {x0:?} and xhat(0) = {estimate:?} {why}")));
            }
        }
        Ok(held)
    }

    /// How a trajectory violates an envelope, if it does.
    pub(super) fn breaks(
        &self,
        path: &Path,
        region: Option<&Region>,
        factor: f64,
        rate: f64,
        is_of_z: bool,
    ) -> Option<String> {
        let n = self.n();
        let estimate = |k: usize| -> Vec<f64> {
            if is_of_z {
                // The state of the observer is (xhat, e), in an order that the estimate tells.
                let z = &path.z[k];
                (0..n).map(|i| z[i] + z[n + i]).collect()
            } else {
                path.xhat[k].clone()
            }
        };
        let error = |k: usize| norm(&path.x[k].iter().zip(estimate(k)).map(|(x, z)| x - z).collect::<Vec<_>>());
        let first = error(0);
        let mut largest = 0.0_f64;
        let mut last = 0;
        for k in 0..path.t.len() {
            let in_time =
                region.is_none_or(|region| region.time_bounds().0 <= path.t[k] && path.t[k] <= region.time_bounds().1);
            if !inside(region, &path.x[k]) || !inside(region, &estimate(k)) || !in_time {
                break;
            }
            largest = largest.max(norm(&path.x[k]));
            let floor = 1e-6 * norm(&path.x[k]) + 1e-9 * largest;
            let bound = factor * (-rate * path.t[k]).exp() * first;
            if error(k) > bound * (1.0 + 1e-6) + floor {
                return Some(format!(
                    "|e| is {:e} at t = {:e}, above {bound:e}; |e(0)| = {first:e}",
                    error(k),
                    path.t[k]
                ));
            }
            last = k;
        }
        // Without a rate: after the time that its slowest mode needs the error is small, or it still decays.
        if rate == 0.0 && path.is_complete && last + 1 == path.t.len() {
            let (half, end) = (error(last / 2), error(last));
            let floor = 1e-5 * norm(&path.x[last]) + 1e-6 * largest;
            if end > 1e-2 * first + floor && end > (1.0 - 1e-6) * half {
                return Some(format!(
                    "|e| does not tend to 0: it is {half:e} at t = {:e} and {end:e} at t = {:e}; |e(0)| = {first:e}",
                    path.t[last / 2],
                    path.t[last]
                ));
            }
        }
        None
    }

    pub(super) fn sectors(&self, sentence: &Sentence) -> Verdict {
        // Sectors of the study are not the plant's.
        if self.own.has("sectors") {
            return Ok(Held::Unchecked);
        }
        let Some(rate) = rate(sentence.hole(1)) else { return Ok(Held::Unchecked) };
        // V = e'Pe decays: the factor is that of P, where floating point knows it.
        let p = self.designed.and_then(|designed| matrix(&designed.report, "P"));
        let spread = p.map(|p| {
            let own = p.symmetric_eigenvalues();
            (own.max() / own.min()).sqrt()
        });
        match spread.filter(|spread| *spread < 1e6) {
            Some(factor) => self.envelope(sentence.hole(0), factor * (1.0 + 1e-6), Some(rate), false),
            None => self.envelope(sentence.hole(0), f64::INFINITY, Some(0.0), false),
        }
    }

    pub(super) fn unknown_input(&self, sentence: &Sentence, said: &Said) -> Verdict {
        let Some(UnknownInput { e, f, .. }) = self.spec.kind.of() else { return Ok(Held::Unchecked) };
        let Some(designed) = self.designed else { return Ok(Held::Unchecked) };
        let Some(rate) = rate_of(sentence, 0, said) else { return Ok(Held::Unchecked) };
        let mut held = Held::Unchecked;
        for _ in 0..2 {
            let (x0, estimate) = self.start(None);
            let inputs = self.inputs(None);
            let signs = self.signs(0, e.ncols());
            let omega = rate;
            let signals = |interval: usize, t: f64, _: &[f64]| {
                let w = &signs[interval.min(signs.len() - 1)].1;
                let wave = 1.0 + (omega * t).sin();
                let entering = |m: &DMatrix<f64>| -> Vec<f64> {
                    m.row_iter().map(|row| row.iter().zip(w).map(|(x, s)| x * s * wave).sum()).collect()
                };
                // F d is what noise would be.
                Acting { u: inputs(t), noise: entering(f), disturbance: entering(e) }
            };
            let experiment = self.experiment(x0, estimate, &signals, 25.0 / rate);
            let Some(path) = simulate(self.plant, &designed.runnable, &experiment) else { continue };
            if !path.is_complete {
                continue;
            }
            held = Held::Simulated;
            self.decayed(&path)?;
        }
        Ok(held)
    }

    pub(super) fn unknown_input_at_samples(&self, said: &Said) -> Verdict {
        let Some(UnknownInput { e, f, .. }) = self.spec.kind.of() else { return Ok(Held::Unchecked) };
        let (Some(designed), Some(plant)) = (self.designed, self.study.plant.model.linear()) else {
            return Ok(Held::Unchecked);
        };
        let radius = said.number("largest modulus of a pole").unwrap_or(1.0).max(1e-3);
        let steps = (25.0 / -radius.ln()).ceil();
        if !(steps > 0.0 && steps < 2e4) {
            return Ok(Held::Unchecked);
        }
        let (x0, estimate) = self.start(None);
        let signs = self.signs(0, e.ncols());
        let (mut x, u) = (DVector::from_vec(x0), DVector::from_element(plant.b.ncols(), 0.5));
        let output = |x: &DVector<f64>, d: &DVector<f64>| {
            let fed = plant.d.as_ref().map_or_else(|| DVector::zeros(plant.c.nrows()), |through| through * &u);
            &plant.c * x + fed + f * d
        };
        let none = DVector::zeros(e.ncols());
        let first = designed.runnable.initial(0.0, &estimate, u.as_slice(), output(&x, &none).as_slice());
        let Some(mut state) = first else { return Ok(Held::Unchecked) };
        let (mut transient, mut largest, mut last) = (0.0_f64, 0.0_f64, 0.0);
        for k in 0..steps as usize {
            let signs = &signs[k % signs.len()].1;
            let d = DVector::from_fn(e.ncols(), |j, _| signs[j] * (1.0 + (k as f64).sin()));
            let y = output(&x, &d);
            let next = designed.runnable.motion(0.0, &state, u.as_slice(), y.as_slice());
            let Some(next) = next else { return Ok(Held::Unchecked) };
            let mut xhat = vec![0.0; x.len()];
            designed.runnable.any().correct(&state, u.as_slice(), y.as_slice(), &[], &mut xhat);
            last = (&x - DVector::from_vec(xhat)).norm();
            (transient, largest) = (transient.max(last), largest.max(x.norm()));
            state = next;
            x = &plant.a * x + &plant.b * &u + e * d;
        }
        let size = |name: &str| matrix(&designed.report, name).map_or(1.0, |m| m.norm());
        let rounding = 1e-6 * largest * (1.0 + size("L") * size("TA") + size("H") + size("J"));
        if !largest.is_finite() {
            return Ok(Held::Unchecked);
        }
        if last > 1e-4 * transient + rounding {
            return Err(wrong(format!("|e| is {last:e} after {steps} samples; it was {transient:e}")));
        }
        Ok(Held::Simulated)
    }

    /// The error of a run over 25 time constants has decayed.
    pub(super) fn decayed(&self, path: &Path) -> Result<(), Wrong> {
        let errors = path.errors();
        let (first, last) = (norm(&errors[0]), norm(errors.last().map_or(&[], Vec::as_slice)));
        let largest = path.x.iter().chain(&path.xhat).map(|x| norm(x)).fold(0.0, f64::max);
        // Products of the matrices of the observer are rounded: what they cancel is larger than what is left.
        let size =
            |name: &str| self.designed.and_then(|designed| matrix(&designed.report, name)).map_or(1.0, |m| m.norm());
        let largest = largest * (1.0 + size("M") * size("T") + size("L") * size("TA") + size("H"));
        let transient = errors.iter().map(|e| norm(e)).fold(first, f64::max);
        if last > 1e-4 * transient + 1e-6 * largest {
            return Err(wrong(format!(
                "|e| is {last:e} at t = {:e}; it was {first:e} at first",
                path.t.last().copied().unwrap_or(0.0)
            )));
        }
        Ok(())
    }

    pub(super) fn reduced(&self, sentence: &Sentence, said: &Said) -> Verdict {
        let Some(designed) = self.designed else { return Ok(Held::Unchecked) };
        let Some(rate) = rate_of(sentence, 2, said) else { return Ok(Held::Unchecked) };
        let (x0, estimate) = self.start(None);
        let inputs = self.inputs(None);
        let signals = |_: usize, t: f64, _: &[f64]| Acting { u: inputs(t), ..Acting::default() };
        let experiment = self.experiment(x0, estimate, &signals, 25.0 / rate);
        match simulate(self.plant, &designed.runnable, &experiment) {
            Some(path) if path.is_complete => self.decayed(&path).map(|()| Held::Simulated),
            _ => Ok(Held::Unchecked),
        }
    }

    /// The error of a sliding-mode observer is 0 after a finite time, but for its sampling.
    pub(super) fn finite_time(&self, sentence: &Sentence, said: &Said) -> Verdict {
        let (Some(designed), Some(spec)) = (self.designed, self.spec.kind.of::<SlidingModeSpec>()) else {
            return Ok(Held::Unchecked);
        };
        let n = self.n();
        let bound = sentence.number(0).or_else(|| sentence.number(1)).unwrap_or(f64::NAN);
        if bound > spec.bound {
            return Err(Wrong::Rounded(format!(
                "the bound {bound} is more than {}, for which the gains are",
                spec.bound
            )));
        }
        if spec.discretisation == Discretisation::Explicit {
            return Ok(Held::Unchecked);
        }
        let reaching = said.number("bound of the reaching time from an error of 1 in the last state").unwrap_or(10.0);
        let mut held = Held::Unchecked;
        for _ in 0..3 {
            let (mut x0, _) = self.start(None);
            if self.random.borrow_mut().once_in(2) {
                for x in &mut x0 {
                    *x *= 3.0;
                }
            }
            let mut y = vec![0.0; 1];
            let inputs = self.inputs(None);
            self.plant.output(0.0, &x0, &inputs(0.0), &mut y);
            let mut estimate = x0.clone();
            estimate[n - 1] += self.random.borrow_mut().unit();
            let signals = |_: usize, t: f64, _: &[f64]| Acting { u: inputs(t), ..Acting::default() };
            let duration = (1.5 * reaching + 1.0).min(60.0).min(2e4 * spec.period);
            let experiment = self.experiment(x0, estimate, &signals, duration);
            let Some(path) = simulate(self.plant, &designed.runnable, &experiment) else { continue };
            if !path.is_complete {
                continue;
            }
            // Model errors count as disturbances.
            let (mut real, mut copy) = (vec![0.0; n], vec![0.0; n]);
            let within = (0..path.t.len()).all(|k| {
                self.plant.motion(path.t[k], &path.x[k], &path.u[k], &mut real);
                self.plant.motion(path.t[k], &path.xhat[k], &path.u[k], &mut copy);
                (real[n - 1] - copy[n - 1]).abs() <= 0.8 * spec.bound
            });
            if !within {
                continue;
            }
            held = Held::Simulated;
            let errors = path.errors();
            let late = errors[errors.len() * 9 / 10..].iter().map(|e| e[n - 1].abs()).fold(0.0, f64::max);
            let u = path.u.iter().flatten().fold(0.0, |most: f64, u| most.max(u.abs()));
            let size = path.x.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
            if late > 20.0 * spec.period * (spec.bound + u + size) {
                return Err(wrong(format!(
                    "from x(0) = {:?} the error of {} is {late:e} in the last tenth of {duration} time units, with model errors within the bound",
                    experiment.x0,
                    self.plant.states[n - 1]
                )));
            }
        }
        Ok(held)
    }
}

/// Whether a state is in the region.
pub(super) fn inside(region: Option<&Region>, x: &[f64]) -> bool {
    region.is_none_or(|region| region.states().iter().zip(x).all(|((low, high), x)| low <= x && x <= high))
}

/// The rate of a sentence, positive; where it has none, that of the poles in the report.
pub(super) fn rate_of(sentence: &Sentence, hole: usize, said: &Said) -> Option<f64> {
    let rate = Some(of_sentence(sentence, hole)).filter(|rate| *rate > 0.0);
    rate.or_else(|| said.number("decay rate")).filter(|rate| *rate > 0.0 && rate.is_finite())
}
