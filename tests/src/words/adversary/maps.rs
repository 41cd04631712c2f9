//! Observers with maps: left inverses near the numbers of their expressions, and trajectories.

use luenberger_study::design::Designed;
use nalgebra::DMatrix;

use super::runs::inside;
use super::{Held, INTERVALS, Subject, TRIES, Verdict, Wrong, wrong};
use crate::words::expression::Expression;
use crate::words::said::{Said, matrix};
use crate::words::sentences::{Sentence, listed, rate};
use crate::words::simulate::{Acting, Path, norm, simulate};

impl Subject<'_> {
    /// The expressions of a key of the observer, of these variables.
    pub(super) fn expressions(&self, key: &str, variables: &[String]) -> Option<Vec<Expression>> {
        let rows = self.own.get(key)?.texts()?;
        rows.iter().map(|row| Expression::read(row, variables, &self.plant.parameters).ok()).collect()
    }

    /// Whether phi^L(phi(x), h(x)) is x, at states of the region in which a number of the maps is nearly reached: a
    /// spike is found where its numbers are.
    pub(super) fn left_inverse(&self, letter: &str, exact: bool) -> Verdict {
        let Some(phi) = self.expressions("phi", &self.plant.states) else { return Ok(Held::Unchecked) };
        let order = phi.len();
        let variables: Vec<String> =
            (1..=order).map(|k| format!("{letter}{k}")).chain(self.plant.outputs.iter().cloned()).collect();
        let Some(inverse) = self.expressions("left_inverse", &variables) else { return Ok(Held::Unchecked) };
        let region = self.region();
        let mut numbers = Vec::new();
        inverse.iter().chain(&phi).for_each(|row| row.numbers(&mut numbers));
        let u = vec![0.0; self.plant.inputs.len()];
        for number in numbers.iter().chain([&0.0, &1.0]) {
            for shift in [-1e-3, 0.0, 1e-3] {
                let (mut x, _) = self.start(region.as_ref());
                for (k, x) in x.iter_mut().enumerate() {
                    let (low, high) = region.as_ref().map_or((-1.0, 1.0), |region| region.states()[k]);
                    if *number >= low && *number <= high && self.random.borrow_mut().once_in(2) {
                        *x = number + shift;
                    }
                }
                let mut y = vec![0.0; self.plant.outputs.len()];
                self.plant.output(0.0, &x, &u, &mut y);
                let mut values = image(&phi, &x);
                values.extend(&y);
                let back: Vec<f64> = inverse.iter().map(|row| row.at(&values)).collect();
                let missed = norm(&x.iter().zip(&back).map(|(a, b)| a - b).collect::<Vec<_>>());
                if exact && missed > 1e-3 * (1.0 + norm(&x)) {
                    return Err(wrong(format!("phi^L(phi(x), h(x)) is {back:?} at x = {x:?}")));
                }
            }
        }
        Ok(Held::Computed)
    }

    /// Convergence of a KKL observer, or with the sentence of its bound that.
    pub(super) fn kkl(&self, bound: Option<&Sentence>) -> Verdict {
        let Some(designed) = self.designed else { return Ok(Held::Unchecked) };
        if bound.is_none() {
            self.left_inverse("xi", true)?;
        }
        let Some(phi) = self.expressions("phi", &self.plant.states) else { return Ok(Held::Unchecked) };
        let p = matrix(&designed.report, "P");
        let region = self.region();
        let rate = designed.report.poles.iter().map(|[re, _]| -re).fold(f64::INFINITY, f64::min).clamp(0.05, 50.0);
        let mut held = Held::Unchecked;
        for _ in 0..TRIES {
            let (mut x0, estimate) = self.start(region.as_ref());
            for x in &mut x0 {
                *x *= 0.4;
            }
            let inputs = self.inputs(region.as_ref());
            let signals = |_: usize, t: f64, _: &[f64]| Acting { u: inputs(t), ..Acting::default() };
            let mut experiment = self.experiment(x0, estimate, &signals, 30.0 / rate);
            experiment.intervals = 4 * INTERVALS;
            let Some(path) = simulate(self.plant, &designed.runnable, &experiment) else { continue };
            let count = path.x.iter().take_while(|x| inside(region.as_ref(), x)).count();
            if count < 3 {
                continue;
            }
            held = Held::Simulated;
            let errors = path.errors();
            if let (Some(sentence), Some(p)) = (bound, &p) {
                self.guaranteed(sentence, p, &phi, &path, &errors, count)?;
            } else if count == path.t.len() && path.is_complete {
                let late = errors[count * 9 / 10..].iter().map(|e| norm(e)).fold(0.0, f64::max);
                let floor = 1e-8 * path.x.iter().map(|x| norm(x)).fold(1e-3, f64::max);
                if late > 1e-4 * norm(&errors[0]).max(1e-2) {
                    return Err(wrong(format!(
                        "from x(0) = {:?} the error is {late:e} in the last tenth of {:e}",
                        experiment.x0, experiment.duration
                    )));
                }
                // Not 0, and not decaying: a limit.
                let middle = errors[count / 2..count * 6 / 10].iter().map(|e| norm(e)).fold(0.0, f64::max);
                if late > floor && late > 0.5 * middle {
                    return Err(wrong(format!("the error stays at {late:e}, it does not tend to 0")));
                }
            }
        }
        Ok(held)
    }

    /// The error of a KKL observer in the limit.
    pub(super) fn kkl_limit(&self, sentence: &Sentence) -> Verdict {
        let Some(designed) = self.designed else { return Ok(Held::Unchecked) };
        let limits = listed(sentence.hole(0));
        let region = self.region();
        let rate = designed.report.poles.iter().map(|[re, _]| -re).fold(f64::INFINITY, f64::min).clamp(0.05, 50.0);
        let mut held = Held::Unchecked;
        for _ in 0..2 {
            let (mut x0, estimate) = self.start(region.as_ref());
            for x in &mut x0 {
                *x *= 0.4;
            }
            let inputs = self.inputs(region.as_ref());
            let signals = |_: usize, t: f64, _: &[f64]| Acting { u: inputs(t), ..Acting::default() };
            let experiment = self.experiment(x0, estimate, &signals, 40.0 / rate);
            let Some(path) = simulate(self.plant, &designed.runnable, &experiment).filter(|path| path.is_complete)
            else {
                continue;
            };
            if !path.x.iter().all(|x| inside(region.as_ref(), x)) {
                continue;
            }
            held = Held::Simulated;
            let errors = path.errors();
            for (i, limit) in limits.iter().enumerate().take(self.n()) {
                let late = errors[errors.len() * 9 / 10..].iter().map(|e| e[i].abs()).fold(0.0, f64::max);
                if late > limit * (1.0 + 1e-6) + 1e-7 * (1.0 + norm(&path.x[0])) {
                    return Err(wrong(format!(
                        "the error of {} is {late:e} in the end, above {limit:e}",
                        self.plant.states[i]
                    )));
                }
            }
        }
        Ok(held)
    }

    /// The bound of a KKL observer along a trajectory.
    pub(super) fn guaranteed(
        &self,
        sentence: &Sentence,
        p: &DMatrix<f64>,
        phi: &[Expression],
        path: &Path,
        errors: &[Vec<f64>],
        count: usize,
    ) -> Result<(), Wrong> {
        let v = |k: usize| {
            let image = image(phi, &path.x[k]);
            let e = DMatrix::from_fn(image.len(), 1, |i, _| path.z[k][i] - image[i]);
            (e.transpose() * p * &e)[0].max(0.0).sqrt()
        };
        // The region stands before it, in the form that has one.
        let from = usize::from(!sentence.hole(0).contains("V(0)"));
        let (decay, limit) = sentence.hole(from).split_once(" V(0)").unwrap_or((sentence.hole(from), ""));
        let limit: f64 = limit.trim_start_matches(" + ").trim().parse().unwrap_or(0.0);
        let (Some(rate), Some(start)) = (rate(decay), sentence.number(from + 1)) else { return Ok(()) };
        let first = v(0);
        let terms: Vec<(f64, f64)> = sentence
            .hole(from + 2)
            .split(", ")
            .map(|term| {
                let term = term.split(" for ").next().unwrap_or("");
                let (lipschitz, defect) = match term.split_once(" V(t)") {
                    Some((lipschitz, rest)) => (lipschitz.trim(), rest.trim_start_matches(" + ").trim()),
                    None => ("0", term.trim()),
                };
                (lipschitz.parse().unwrap_or(f64::INFINITY), defect.parse().unwrap_or(0.0))
            })
            .collect();
        for (k, error) in errors.iter().enumerate().take(count) {
            let now = v(k);
            let bound = (-rate * path.t[k]).exp() * first + limit;
            let floor = 1e-8 * (1.0 + norm(&path.x[k]));
            if now > bound * (1.0 + 1e-6) + floor {
                return Err(wrong(format!("V is {now:e} at t = {:e}, above {bound:e}", path.t[k])));
            }
            for (i, (lipschitz, defect)) in terms.iter().enumerate().take(self.n()) {
                let bound = lipschitz * now + defect;
                if now <= start && error[i].abs() > bound * (1.0 + 1e-6) + floor {
                    return Err(wrong(format!(
                        "at t = {:e}, with V = {now:e}, the error of {} is {:e}, above {bound:e}",
                        path.t[k], self.plant.states[i], error[i]
                    )));
                }
            }
        }
        Ok(())
    }

    /// Convergence of an immersion-and-invariance observer, from estimates and from other states of the observer.
    pub(super) fn immersion(&self, sentence: &Sentence) -> Verdict {
        let Some(designed) = self.designed else { return Ok(Held::Unchecked) };
        let box_of_beta = bounds_of(sentence.hole(1));
        self.left_inverse("z", true)?;
        let region = self.region();
        let mut held = Held::Unchecked;
        for attempt in 0..2 * TRIES {
            let (mut x0, estimate) = self.start(region.as_ref());
            for x in &mut x0 {
                *x *= 0.3;
            }
            let inputs = self.inputs(region.as_ref());
            let signals = |_: usize, t: f64, _: &[f64]| Acting { u: inputs(t), ..Acting::default() };
            let mut experiment = self.experiment(x0, estimate, &signals, 30.0);
            if attempt % 2 == 1 {
                let size = designed.runnable.dimensions().state;
                let mut random = self.random.borrow_mut();
                experiment.state = Some((0..size).map(|_| 10.0 * random.unit()).collect());
            }
            let Some(path) = simulate(self.plant, &designed.runnable, &experiment).filter(|path| path.is_complete)
            else {
                continue;
            };
            // The estimate is asked to stay in the region, or beta in a box.
            let is_asked = box_of_beta.is_empty();
            if !path.x.iter().all(|x| inside(region.as_ref(), x))
                || is_asked && !path.xhat.iter().all(|x| inside(region.as_ref(), x))
            {
                continue;
            }
            if !is_asked
                && !self
                    .betas(&path)
                    .iter()
                    .all(|beta| beta.iter().zip(&box_of_beta).all(|(b, (low, high))| low <= b && b <= high))
            {
                continue;
            }
            held = Held::Simulated;
            self.attracts(designed, &path)?;
            let errors = path.errors();
            let count = errors.len();
            let late = errors[count * 9 / 10..].iter().map(|e| norm(e)).fold(0.0, f64::max);
            let middle = errors[count / 2..count * 6 / 10].iter().map(|e| norm(e)).fold(0.0, f64::max);
            if late > 1e-3 && late > 0.5 * middle {
                return Err(wrong(format!(
                    "from x(0) = {:?} and xhat(0) = {:?} the error is {late:e} in the last tenth of {}",
                    experiment.x0, path.xhat[0], experiment.duration
                )));
            }
        }
        Ok(held)
    }

    /// beta(y, chi) along a trajectory.
    pub(super) fn betas(&self, path: &Path) -> Vec<Vec<f64>> {
        let size = path.z.first().map_or(0, Vec::len);
        let variables: Vec<String> =
            (1..=size).map(|k| format!("chi{k}")).chain(self.plant.outputs.iter().cloned()).collect();
        let Some(beta) = self.expressions("beta", &variables) else { return Vec::new() };
        let at = |(z, y): (&Vec<f64>, &Vec<f64>)| {
            let values: Vec<f64> = z.iter().chain(y).copied().collect();
            beta.iter().map(|row| row.at(&values)).collect()
        };
        path.z.iter().zip(&path.y).map(at).collect()
    }

    /// The distance beta(y, chi) - phi(x) decays as the proved bound of its eigenvalues says.
    pub(super) fn attracts(&self, designed: &Designed, path: &Path) -> Result<(), Wrong> {
        let fact =
            designed.report.facts.iter().find(|fact| fact.statement == "the largest real part of an eigenvalue < 0");
        let Some(rate) = fact.and_then(|fact| fact.margin).filter(|margin| *margin > 0.0) else { return Ok(()) };
        let betas = self.betas(path);
        let Some(phi) = self.expressions("phi", &self.plant.states).filter(|_| !betas.is_empty()) else {
            return Ok(());
        };
        let distance = |k: usize| {
            let image = image(&phi, &path.x[k]);
            norm(&betas[k].iter().zip(&image).map(|(beta, phi)| beta - phi).collect::<Vec<_>>())
        };
        let step = path.t.get(1).copied().unwrap_or(1.0);
        let shift = (5.0 / rate / step).ceil() as usize;
        let spread = matrix(&designed.report, "P").map_or(1.0, |p| {
            let own = p.symmetric_eigenvalues();
            (own.max() / own.min()).sqrt()
        });
        for k in 0..path.t.len().saturating_sub(shift) {
            let (now, later) = (distance(k), distance(k + shift));
            if later > 0.5 * spread * now && now > 1e-3 {
                return Err(wrong(format!(
                    "the distance is {now:e} at t = {:e} and {later:e} at t = {:e}, with eigenvalues left of -{rate}",
                    path.t[k],
                    path.t[k + shift]
                )));
            }
        }
        Ok(())
    }

    /// The error of a numerical KKL observer tends to that of its left inverse, as it was measured.
    pub(super) fn tables(&self, said: &Said) -> Verdict {
        let Some(designed) = self.designed else { return Ok(Held::Unchecked) };
        let measured: f64 = said
            .numbers
            .iter()
            .filter(|number| number.name.starts_with("largest error of the left inverse"))
            .filter_map(|number| number.value)
            .fold(0.0, f64::max);
        let region = self.region();
        let (mut x0, estimate) = self.start(region.as_ref());
        for x in &mut x0 {
            *x *= 0.3;
        }
        let signals =
            |_: usize, _: f64, _: &[f64]| Acting { u: vec![0.0; self.plant.inputs.len()], ..Acting::default() };
        let experiment = self.experiment(x0, estimate, &signals, 30.0);
        let Some(path) = simulate(self.plant, &designed.runnable, &experiment).filter(|path| path.is_complete) else {
            return Ok(Held::Unchecked);
        };
        if !path.x.iter().all(|x| inside(region.as_ref(), x)) {
            return Ok(Held::Unchecked);
        }
        let errors = path.errors();
        let late = errors[errors.len() * 3 / 4..].iter().map(|e| norm(e)).fold(0.0, f64::max);
        if late > 30.0 * measured + 1e-3 {
            return Err(wrong(format!(
                "the error is {late:e} in the last quarter, and that of the left inverse was measured as {measured:e}"
            )));
        }
        Ok(Held::Simulated)
    }
}

/// `beta1 in [0, 1], beta2 in [..]`: the bounds.
pub(super) fn bounds_of(text: &str) -> Vec<(f64, f64)> {
    let one = |part: &str| {
        let (low, high) = part.split_once(']')?.0.split_once(", ")?;
        Some((low.parse().ok()?, high.parse().ok()?))
    };
    text.split('[').skip(1).filter_map(one).collect()
}

/// phi at a state.
fn image(phi: &[Expression], x: &[f64]) -> Vec<f64> {
    phi.iter().map(|row| row.at(x)).collect()
}
