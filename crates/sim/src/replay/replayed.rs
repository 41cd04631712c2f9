//! Result of a replay: estimates, innovations, and errors where the true state is known.

use luenberger_observers::tangential;
use luenberger_plants::wrap;
use nalgebra::{DMatrix, DVector};

use super::Smoothed;
use super::innovation::{Consistency, InnovationStatistics, NormalisedSquare};
use crate::error::SimError;
use crate::samples::Samples;

/// Result of a replay, for all observers.
#[derive(Clone, Debug, PartialEq)]
pub struct Replayed {
    /// The observers, in the order they were added.
    pub observers: Vec<ReplayedObserver>,
}

/// Result of a replay for one observer. Matrices have one row for each of its times.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayedObserver {
    /// Its name.
    pub name: String,
    /// The times: those of the log, or the samples of an observer in discrete time.
    pub t: Vec<f64>,
    /// The row of the log at each time; none for a sample of an observer in discrete time that no row lies on.
    pub row: Vec<Option<usize>>,
    /// The estimates: of a filter, and of an observer that is corrected at the rows, what is known after the
    /// measurements of that time, of a sampled-data observer of a fixed period what is known before them.
    pub estimate: DMatrix<f64>,
    /// The estimates before the measurements of that time, where those of `estimate` are after them; otherwise the
    /// same. Without rows for a replay [without predictions](super::Replay::without_predictions).
    pub predicted: DMatrix<f64>,
    /// The innovation of the measurements of that time: of a filter that of its update, otherwise `y - h(xhat)` before
    /// them; none for an observer of some states only. An entry is none where that output was not measured.
    pub innovation: Option<DMatrix<Option<f64>>>,
    /// Covariance and normalised innovations, of a filter.
    pub consistency: Option<FilterConsistency>,
    /// The estimates from the whole log, of a [smoothed filter](super::Replay::smoothed_filter).
    pub smoothed: Option<Smoothed>,
    /// The states of the observer, a row for each time, with the measurements of that time where `estimate` has them;
    /// none but for a replay [with states](super::Replay::with_states).
    pub states: Option<DMatrix<f64>>,
    /// How many samples of a sampled-data observer were interpolated between rows, where that was asked for.
    pub interpolated: usize,
    /// Steps the integrator attempted.
    pub steps: usize,
    /// The full turns of the states that are angles, 0 of the others; empty without angles.
    pub turns: Vec<f64>,
}

/// What a filter computes along a recording besides its estimate: covariances, and normalised innovations.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterConsistency {
    /// `nu' S^-1 nu` of each time (normalised innovation squared); none where nothing was measured.
    pub nis: Vec<Option<NormalisedSquare>>,
    /// The log-likelihood of the measurements of each time, given those before: that of a normal distribution with the
    /// covariance S of the innovation, `-(p ln(2 pi) + ln det S + nu' S^-1 nu)/2`. None where nothing was measured, and
    /// of an estimator that has no S.
    pub log_likelihood: Vec<Option<f64>>,
    /// The times, by their index, whose measurements had no result and were passed over: h is not defined around the
    /// estimate, or the covariance of the innovation not positive definite.
    pub passed_over: Vec<usize>,
    /// The measurements that the gate of the filter rejected: index of the time, and output.
    pub rejected: Vec<(usize, usize)>,
    /// The covariances by columns, one time after the other; empty if only the deviations are kept.
    pub(super) covariances: Vec<f64>,
    /// The standard deviations, one time after the other, if only they are kept.
    pub(super) deviations: Vec<f64>,
    /// Those before the measurements.
    pub(super) predicted: Vec<f64>,
    pub(super) order: usize,
    /// The number of the unit vector that each state belongs to; 0 for none.
    pub(super) unit_vectors: Vec<usize>,
}

impl FilterConsistency {
    pub(super) fn new(unit_vectors: Vec<usize>) -> Self {
        let order = unit_vectors.len();
        let (covariances, deviations, predicted) = (Vec::new(), Vec::new(), Vec::new());
        let (nis, log_likelihood, passed_over, rejected) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { nis, log_likelihood, passed_over, rejected, covariances, deviations, predicted, order, unit_vectors }
    }

    /// The covariance P of the error of the estimate at the time of this index, n x n; none beyond the last, and of a
    /// replay that keeps [deviations only](super::Replay::deviations_only).
    pub fn covariance(&self, index: usize) -> Option<DMatrix<f64>> {
        let size = self.order * self.order;
        let entries = self.covariances.get(index * size..(index + 1) * size)?;
        Some(DMatrix::from_column_slice(self.order, self.order, entries))
    }

    /// The standard deviations `sqrt(P_ii)` at the last time; none without a time.
    pub fn last_deviation(&self) -> Option<Vec<f64>> {
        let last = self.nis.len().checked_sub(1)?;
        Some((0..self.order).map(|i| self.deviation_at(last, i)).collect())
    }

    /// The standard deviations `sqrt(P_ii)`, one row for each time.
    pub fn deviation(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.nis.len(), self.order, |k, i| self.deviation_at(k, i))
    }

    fn deviation_at(&self, k: usize, i: usize) -> f64 {
        let n = self.order;
        match self.covariances.get(k * n * n + i * n + i) {
            Some(variance) => variance.max(0.0).sqrt(),
            None => self.deviations.get(k * n + i).copied().unwrap_or(f64::NAN),
        }
    }
}

impl Replayed {
    /// The observer of that name.
    ///
    /// # Errors
    /// [`SimError::UnknownName`].
    pub fn observer(&self, name: &str) -> Result<&ReplayedObserver, SimError> {
        let found = self.observers.iter().find(|observer| observer.name == name);
        found.ok_or_else(|| SimError::UnknownName { name: name.to_owned() })
    }
}

impl ReplayedObserver {
    /// The statistics of the innovation of each output from the time `from` on, which excludes the initial
    /// transient. Measurements that the gate of a filter rejected are not among them.
    ///
    /// Whiteness counts lags in measurements of that output; of a log that is not equally spaced it says little.
    ///
    /// # Errors
    /// [`SimError::Outside`] when nothing is left.
    pub fn statistics(&self, from: f64) -> Result<Vec<InnovationStatistics>, SimError> {
        let first = self.first(from)?;
        let Some(innovation) = &self.innovation else { return Ok(Vec::new()) };
        let of = |j: usize| {
            // In the order of the times, as they were rejected.
            let all = self.consistency.iter().flat_map(|consistency| &consistency.rejected);
            let mut rejected = all.filter(|(_, of)| *of == j).map(|(k, _)| *k).peekable();
            let column = innovation.column(j);
            let used = column.iter().enumerate().filter(|(k, _)| rejected.next_if_eq(k).is_none());
            used.skip_while(|(k, _)| *k < first).filter_map(|(_, nu)| *nu).collect::<Vec<f64>>()
        };
        Ok((0..innovation.ncols()).map(|j| InnovationStatistics::of(&of(j))).collect())
    }

    /// Whether the innovations of a filter have, from the time `from` on, the covariance that it computes (NIS);
    /// none for other observers.
    ///
    /// # Errors
    /// [`SimError::Outside`] when nothing is left.
    pub fn consistency(&self, from: f64) -> Result<Option<Consistency>, SimError> {
        let first = self.first(from)?;
        let Some(FilterConsistency { nis, passed_over, .. }) = &self.consistency else { return Ok(None) };
        let squares = nis.iter().skip(first).filter_map(|nis| nis.map(Some));
        let without = passed_over.iter().filter(|k| **k >= first).map(|_| None);
        Ok(Consistency::of(squares.chain(without)))
    }

    /// The errors `x - xhat` at its times, of angles within half a turn, by the states in `truth`, whose times are
    /// those of the log; none where the true value is missing, or no row of the log lies.
    ///
    /// # Errors
    /// [`SimError::Length`] if `truth` has not the states of the estimate.
    pub fn errors(&self, truth: &Samples) -> Result<DMatrix<Option<f64>>, SimError> {
        let (expected, found) = (self.estimate.ncols(), truth.values().ncols());
        if expected != found {
            return Err(SimError::Length { what: "the true states".to_owned(), expected, found });
        }
        let turn = |i: usize| self.turns.get(i).copied().unwrap_or_default();
        let error = |k: usize, i: usize| Some(wrap(truth.value(self.row[k]?, i)? - self.estimate[(k, i)], turn(i)));
        Ok(DMatrix::from_fn(self.t.len(), expected, error))
    }

    /// The same with the estimates and covariances before the measurements of each time in place of those after them.
    /// Not of a replay [without predictions](super::Replay::without_predictions).
    #[must_use]
    pub fn with_predictions(&self) -> Self {
        let mut of_predictions = Self { estimate: self.predicted.clone(), ..self.clone() };
        if let Some(consistency) = &mut of_predictions.consistency {
            consistency.covariances.clone_from(&consistency.predicted);
        }
        of_predictions
    }

    /// The same with the smoothed estimates in place of those of the filter; none if they were not asked for.
    #[must_use]
    pub fn with_smoothed_estimates(&self) -> Option<Self> {
        let smoothed = self.smoothed.as_ref()?;
        let covariances = (0..self.t.len()).filter_map(|k| smoothed.covariance(k));
        let consistency = self.consistency.as_ref().map(|consistency| FilterConsistency {
            covariances: covariances.flat_map(|p| p.data.as_vec().clone()).collect(),
            ..consistency.clone()
        });
        Some(Self { estimate: smoothed.estimate.clone(), consistency, ..self.clone() })
    }

    /// Whether the errors of a filter have, from the time `from` on, the covariance that it computes (NEES); none for
    /// other observers, and without a true state. Of a singular covariance it is the pseudo-inverse, with the rank as
    /// degrees of freedom ([`NormalisedSquare::of_error`]). Where only some true states are known, it is that of these.
    ///
    /// # Errors
    /// [`SimError::Outside`] when nothing is left, and those of [`errors`](Self::errors).
    pub fn nees(&self, truth: &Samples, from: f64) -> Result<Option<Consistency>, SimError> {
        let first = self.first(from)?;
        let errors = self.errors(truth)?;
        let Some(consistency) = &self.consistency else { return Ok(None) };
        let one = |k: usize| {
            let known: Vec<usize> = (0..errors.ncols()).filter(|i| errors[(k, *i)].is_some()).collect();
            let p = consistency.covariance(k).filter(|_| !known.is_empty())?;
            let p = p.select_rows(&known).select_columns(&known);
            let mut e = DVector::from_iterator(known.len(), known.iter().filter_map(|i| errors[(k, *i)]));
            let x = DVector::from_fn(known.len(), |i, _| self.estimate[(k, known[i])]);
            // Of a unit vector whose true entries are known.
            let numbers = &consistency.unit_vectors;
            let is_whole = |number: usize| (0..numbers.len()).all(|i| numbers[i] != number || known.contains(&i));
            let vector_of = |i: usize| Some(numbers[known[i]]).filter(|number| is_whole(*number)).unwrap_or(0);
            tangential(e.as_mut_slice(), x.as_slice(), vector_of);
            Some(NormalisedSquare::of_error(&e, &p, &x))
        };
        Ok(Consistency::of((first..self.t.len()).filter_map(one)))
    }

    /// How many rows of the log the observer has used; of an observer in discrete time, those on its samples.
    pub fn rows_used(&self) -> usize {
        self.row.iter().flatten().count()
    }

    /// The first row at or after `from`.
    fn first(&self, from: f64) -> Result<usize, SimError> {
        let outside = || SimError::Outside {
            time: from,
            start: self.t.first().copied().unwrap_or(f64::NAN),
            end: self.t.last().copied().unwrap_or(f64::NAN),
        };
        self.t.iter().position(|&t| t >= from).ok_or_else(outside)
    }
}
