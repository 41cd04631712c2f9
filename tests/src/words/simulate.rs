//! A plant with its observer, integrated by `integrate`: the plant as this module reads it, the observer as the tool
//! runs it.

use luenberger_study::design::Runnable;

use super::integrate::{Integrator, Stop};
use super::plant::Plant;

/// What acts on the plant: inputs, measurement noise, and what is added to x'.
#[derive(Debug, Clone, Default)]
pub(super) struct Acting {
    pub(super) u: Vec<f64>,
    pub(super) noise: Vec<f64>,
    pub(super) disturbance: Vec<f64>,
}

/// What acts at a time of an interval of the grid, where the estimate is the last argument.
pub(super) type Signals<'a> = dyn Fn(usize, f64, &[f64]) -> Acting + 'a;

/// An experiment.
pub(super) struct Experiment<'a> {
    pub(super) x0: Vec<f64>,
    /// The first estimate; the state of the observer follows from it.
    pub(super) estimate: Vec<f64>,
    /// Or the first state of the observer.
    pub(super) state: Option<Vec<f64>>,
    pub(super) signals: &'a Signals<'a>,
    pub(super) duration: f64,
    /// Intervals of the grid; what acts may jump between them.
    pub(super) intervals: usize,
    pub(super) tolerance: f64,
    /// Evaluations at most.
    pub(super) budget: usize,
}

/// The result at the times of the grid, as far as it came.
#[derive(Debug, Clone, Default)]
pub(super) struct Path {
    pub(super) t: Vec<f64>,
    pub(super) x: Vec<Vec<f64>>,
    pub(super) xhat: Vec<Vec<f64>>,
    /// The states of the observer.
    pub(super) z: Vec<Vec<f64>>,
    pub(super) u: Vec<Vec<f64>>,
    pub(super) y: Vec<Vec<f64>>,
    /// Whether it came to the end.
    pub(super) is_complete: bool,
}

impl Path {
    /// The errors of the estimates.
    pub(super) fn errors(&self) -> Vec<Vec<f64>> {
        self.x.iter().zip(&self.xhat).map(|(x, xhat)| x.iter().zip(xhat).map(|(x, xhat)| x - xhat).collect()).collect()
    }
}

pub(super) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Runs an experiment.
pub(super) fn simulate(plant: &Plant, observer: &Runnable, experiment: &Experiment<'_>) -> Option<Path> {
    match observer.period().or(plant.dt) {
        Some(period) => sampled(plant, observer, experiment, period),
        None => continuous(plant, observer, experiment),
    }
}

fn measured(plant: &Plant, t: f64, x: &[f64], acting: &Acting) -> Vec<f64> {
    let mut y = vec![0.0; plant.outputs.len()];
    plant.output(t, x, &acting.u, &mut y);
    y.iter_mut().zip(&acting.noise).for_each(|(y, v)| *y += v);
    y
}

fn first(plant: &Plant, observer: &Runnable, experiment: &Experiment<'_>) -> Option<Vec<f64>> {
    if let Some(state) = &experiment.state {
        return Some(state.clone());
    }
    let acting = (experiment.signals)(0, 0.0, &experiment.estimate);
    let y = measured(plant, 0.0, &experiment.x0, &acting);
    observer.initial(0.0, &experiment.estimate, &acting.u, &y)
}

fn continuous(plant: &Plant, observer: &Runnable, experiment: &Experiment<'_>) -> Option<Path> {
    let Experiment { signals, duration, intervals, .. } = *experiment;
    let n = plant.states.len();
    let z = first(plant, observer, experiment)?;
    let mut state: Vec<f64> = experiment.x0.iter().copied().chain(z).collect();
    let mut integrator = Integrator::new(experiment.tolerance, experiment.budget);
    let mut path = Path::default();
    // Under feedback u follows from the estimate, and the estimate from y: which does not depend on u then.
    let at = |interval: usize, t: f64, state: &[f64]| -> Option<(Acting, Vec<f64>, Vec<f64>)> {
        let (x, z) = state.split_at(n);
        let idle = signals(interval, t, &[]);
        let y = measured(plant, t, x, &idle);
        let estimate = observer.estimate(t, z, &idle.u, &y)?;
        let acting = signals(interval, t, &estimate);
        let y = if acting.u == idle.u { y } else { measured(plant, t, x, &acting) };
        Some((acting, y, estimate))
    };
    let note = |path: &mut Path, interval: usize, t: f64, state: &[f64]| -> Option<()> {
        let (acting, y, estimate) = at(interval, t, state)?;
        path.t.push(t);
        path.x.push(state[..n].to_vec());
        path.z.push(state[n..].to_vec());
        path.xhat.push(estimate);
        path.u.push(acting.u);
        path.y.push(y);
        Some(())
    };
    note(&mut path, 0, 0.0, &state)?;
    for interval in 0..intervals {
        let time = |k: usize| duration * k as f64 / intervals as f64;
        let mut motion = |t: f64, state: &[f64], into: &mut [f64]| -> bool {
            let Some((acting, y, _)) = at(interval, t, state) else { return false };
            let (x, z) = state.split_at(n);
            let (dx, dz) = into.split_at_mut(n);
            plant.motion(t, x, &acting.u, dx);
            dx.iter_mut().zip(&acting.disturbance).for_each(|(d, w)| *d += w);
            match observer.motion(t, z, &acting.u, &y) {
                Some(moved) => {
                    dz.copy_from_slice(&moved);
                    true
                }
                None => false,
            }
        };
        match integrator.advance(&mut motion, time(interval), time(interval + 1), &mut state) {
            Ok(()) => {}
            Err(Stop::Undefined | Stop::Slow) => return Some(path),
        }
        if state.iter().any(|x| x.is_nan() || x.abs() > 1e150) {
            return Some(path);
        }
        note(&mut path, interval, time(interval + 1), &state)?;
    }
    path.is_complete = true;
    Some(path)
}

/// The estimates at samples, before the step that takes the measurement of each, or after it in filter form.
fn sampled(plant: &Plant, observer: &Runnable, experiment: &Experiment<'_>, period: f64) -> Option<Path> {
    let signals = experiment.signals;
    let mut x = experiment.x0.clone();
    let mut z = first(plant, observer, experiment)?;
    let count = (experiment.duration / period).round().min(2e4) as usize;
    let mut integrator = Integrator::new(experiment.tolerance, experiment.budget + 20 * count);
    let mut path = Path::default();
    for k in 0..=count {
        let t = k as f64 * period;
        let interval = k * experiment.intervals / count.max(1);
        let idle = signals(interval, t, &[]);
        let y = measured(plant, t, &x, &idle);
        let estimate = observer.estimate(t, &z, &idle.u, &y)?;
        let acting = signals(interval, t, &estimate);
        let y = measured(plant, t, &x, &acting);
        path.t.push(t);
        path.x.push(x.clone());
        path.z.push(z.clone());
        path.xhat.push(estimate);
        path.u.push(acting.u.clone());
        path.y.push(y.clone());
        z = observer.motion(t, &z, &acting.u, &y)?;
        if plant.dt.is_some() {
            let mut next = vec![0.0; x.len()];
            plant.motion(t, &x, &acting.u, &mut next);
            next.iter_mut().zip(&acting.disturbance).for_each(|(x, w)| *x += w);
            x = next;
        } else {
            let mut motion = |t: f64, x: &[f64], into: &mut [f64]| -> bool {
                plant.motion(t, x, &acting.u, into);
                into.iter_mut().zip(&acting.disturbance).for_each(|(d, w)| *d += w);
                true
            };
            if integrator.advance(&mut motion, t, t + period, &mut x).is_err() {
                return Some(path);
            }
        }
        if x.iter().chain(&z).any(|x| x.is_nan() || x.abs() > 1e150) {
            return Some(path);
        }
    }
    path.is_complete = true;
    Some(path)
}
