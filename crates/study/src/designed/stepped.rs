//! A filter with a covariance that is stepped sample by sample as a simulation and a log step it, its prediction with
//! error control: for those whose step has no program for a target.

use luenberger_sim::AnyObserver;
use nalgebra::DMatrix;

use super::Runnable;
use super::filter::Innovation;

/// A filter on its way. A measurement that is not finite is missing.
///
/// ```
/// use luenberger_study::design::{SteppedFilter, design};
/// use luenberger_study::{Format, Study};
/// use std::sync::atomic::AtomicBool;
/// let text = "
/// [plant]
/// a = [[1]]
/// c = [[1]]
/// dt = 1
/// [[observer]]
/// name = \"models\"
/// kind = \"imm\"
/// w = 0
/// v = 1
/// p0 = 3
/// period = 1
/// models = [{ v = [1] }, { v = [1] }]
/// transitions = [[0.5, 0.5], [0.5, 0.5]]
/// ";
/// let study = Study::from_text("study.toml", text, Format::Toml, ".".as_ref())?;
/// let designed = design(&study, &study.observers[0], &AtomicBool::new(false)).map_err(|why| format!("{why:?}"))?;
/// let mut filter = SteppedFilter::new(designed.runnable, &[0.0]).ok_or("a filter")?;
/// // The variance 3 before a measurement of variance 1: the gain is 3/4.
/// assert!((filter.step(&[], &[2.0])[0] - 1.5).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct SteppedFilter {
    runnable: Runnable,
    period: f64,
    /// Of the plant.
    order: usize,
    state: Vec<f64>,
    sample: usize,
    /// The last measurement.
    last: Option<Measured>,
}

/// A measurement, and sample and state before it.
#[derive(Debug, Clone)]
struct Measured {
    sample: usize,
    state: Vec<f64>,
    u: Vec<f64>,
    y: Vec<f64>,
}

impl SteppedFilter {
    /// The filter at this estimate; none if the observer is no filter with a covariance and a period.
    pub fn new(runnable: Runnable, estimate: &[f64]) -> Option<Self> {
        runnable.filter()?;
        let (period, size) = (runnable.period()?, runnable.dimensions());
        let state = runnable.initial(0.0, estimate, &vec![0.0; size.inputs], &vec![0.0; size.outputs])?;
        Some(Self { runnable, period, order: size.estimate, state, sample: 0, last: None })
    }

    /// The sampling period.
    pub fn period(&self) -> f64 {
        self.period
    }

    fn time(&self, sample: usize) -> f64 {
        sample as f64 * self.period
    }

    /// The work on its state at the time of this sample, of the observer as a simulation has it. The state stays as it
    /// was where the result is not finite, and false is returned.
    fn moved(&mut self, work: impl FnOnce(&dyn AnyObserver, f64, &mut [f64]) -> bool) -> bool {
        let mut state = self.state.clone();
        let t = self.time(self.sample);
        let is_done = work(&*self.runnable.any(), t, &mut state) && state.iter().all(|entry| entry.is_finite());
        if is_done {
            self.state = state;
        }
        is_done
    }

    fn remember(&mut self, u: &[f64], y: &[f64]) {
        self.last = Some(Measured { sample: self.sample, state: self.state.clone(), u: u.to_vec(), y: y.to_vec() });
    }

    /// The estimate for the next sample, from the input and the output of this one; NaN where it has no result.
    pub fn step(&mut self, u: &[f64], y: &[f64]) -> Vec<f64> {
        self.remember(u, y);
        let measured: Vec<bool> = y.iter().map(|y| y.is_finite()).collect();
        let is_done = self.moved(|observer, t, state| {
            observer.step(t, state, u, y, &measured);
            true
        });
        self.sample += 1;
        if is_done { self.estimate() } else { vec![f64::NAN; self.order] }
    }

    /// The estimate for the next sample; after an [`update`](Self::update), that with the measurement.
    pub fn estimate(&self) -> Vec<f64> {
        let size = self.runnable.dimensions();
        let (u, y) = (vec![0.0; size.inputs], vec![0.0; size.outputs]);
        self.runnable.estimate(self.time(self.sample), &self.state, &u, &y).unwrap_or_default()
    }

    /// The update by the measured outputs of this sample. False, and nothing changes, if it has no result.
    pub fn update(&mut self, u: &[f64], y: &[f64]) -> bool {
        self.remember(u, y);
        let measured: Vec<bool> = y.iter().map(|y| y.is_finite()).collect();
        measured.contains(&true) && self.moved(|observer, t, state| observer.update(t, state, u, y, &measured))
    }

    /// The prediction for the next sample. False, and nothing changes, if it has no result.
    pub fn predict(&mut self, u: &[f64]) -> bool {
        let is_done = self.moved(|observer, t, state| observer.predict(t, state, u));
        self.sample += usize::from(is_done);
        is_done
    }

    /// The covariance of the error of the [estimate](Self::estimate), n x n.
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        self.runnable.filter()?.covariance(&self.state, self.order)
    }

    /// The innovation of the last measurement; none before the first one, and where it was passed over.
    pub fn innovation(&self) -> Option<Innovation> {
        let Measured { sample, state, u, y } = self.last.as_ref()?;
        self.runnable.filter()?.innovation(self.time(*sample), state, u, y)
    }

    /// Its state, and how many samples it has had: [`resume`](Self::resume) goes on from there.
    pub fn position(&self) -> (Vec<f64>, usize) {
        (self.state.clone(), self.sample)
    }

    /// Goes on from the position of the same filter. False, and nothing changes, if its state has another length.
    pub fn resume(&mut self, state: &[f64], sample: usize) -> bool {
        let fits = state.len() == self.state.len();
        if fits {
            (self.state, self.sample, self.last) = (state.to_vec(), sample, None);
        }
        fits
    }
}
