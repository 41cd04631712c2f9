//! What filters know at their samples: before the measurement, and after it.

use nalgebra::DMatrix;

use crate::erased::AnyObserver;

/// Which estimate of a filter at a sample is meant. Other observers have only one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Estimates {
    /// After the measurement of the sample (a posteriori), `xhat(k|k)`.
    #[default]
    Filtered,
    /// Before the measurement of the sample (a priori), `xhat(k|k-1)`.
    Predicted,
}

/// The estimates of a filter at its samples, one row each.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleEstimates {
    /// The samples.
    pub t: Vec<f64>,
    /// The estimates before the measurement of the sample.
    pub predicted: DMatrix<f64>,
    /// The estimates after it.
    pub filtered: DMatrix<f64>,
    /// The states of the filter after it; without columns for a filter with a constant gain, whose state is the
    /// prediction.
    pub state: DMatrix<f64>,
}

impl SampleEstimates {
    /// Those that are meant.
    pub fn of(&self, estimates: Estimates) -> &DMatrix<f64> {
        match estimates {
            Estimates::Filtered => &self.filtered,
            Estimates::Predicted => &self.predicted,
        }
    }

    /// The index of the last sample up to the time t.
    pub(crate) fn index(&self, t: f64) -> Option<usize> {
        self.t.partition_point(|sample| *sample <= t + self.rounding()).checked_sub(1)
    }

    /// The index of the sample at the time t; none between samples.
    pub fn at(&self, t: f64) -> Option<usize> {
        self.index(t).filter(|&k| t - self.t[k] <= self.rounding())
    }

    /// What a sample and a time differ by where they are the same instant.
    fn rounding(&self) -> f64 {
        1e-9 * self.t.get(1).map_or(1.0, |next| next - self.t[0])
    }
}

/// The same on its way.
#[derive(Clone, Debug, Default)]
pub(crate) struct Updates {
    t: Vec<f64>,
    predicted: Vec<f64>,
    filtered: Vec<f64>,
    state: Vec<f64>,
}

impl Updates {
    /// A sample, with the states before and after it, or twice the one before it, and which outputs were measured, none
    /// for all.
    pub(crate) fn note(
        &mut self,
        t: f64,
        observer: &dyn AnyObserver,
        (before, after): (&[f64], &[f64]),
        u: &[f64],
        (y, measured): (&[f64], &[bool]),
    ) {
        let (n, start) = (observer.dimensions().estimate, self.predicted.len());
        self.t.push(t);
        self.predicted.resize(start + n, 0.0);
        self.filtered.resize(start + n, 0.0);
        observer.estimate(t, before, u, y, &mut self.predicted[start..]);
        let filtered = &mut self.filtered[start..];
        if observer.is_filter() {
            filtered.copy_from_slice(&self.predicted[start..]);
            observer.correct(before, u, y, measured, filtered);
        } else {
            observer.estimate(t, after, u, y, filtered);
            self.state.extend_from_slice(after);
        }
    }

    /// The estimates of so many components; none without a sample.
    pub(crate) fn finish(self, components: usize) -> Option<SampleEstimates> {
        let rows = self.t.len();
        let table = |entries: &[f64], columns: usize| DMatrix::from_row_slice(rows, columns, entries);
        (rows > 0).then(|| SampleEstimates {
            predicted: table(&self.predicted, components),
            filtered: table(&self.filtered, components),
            state: table(&self.state, self.state.len() / rows),
            t: self.t,
        })
    }
}
