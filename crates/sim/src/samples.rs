//! A quantity known at some times only, and what it is taken to be in between.

use nalgebra::DMatrix;

use crate::error::{SimError, check_finite};

/// What a sampled quantity is taken to be between its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// The last sample, as a digital-to-analogue converter holds it.
    Hold,
    /// The straight line from one sample to the next.
    Line,
}

/// Columns of numbers at increasing times, which need not be equally spaced.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    t: Vec<f64>,
    /// One row for each time.
    values: DMatrix<f64>,
    between: Between,
}

impl Samples {
    /// The samples `values` (one row for each time) at the times `t`, at least 2.
    ///
    /// ```
    /// use luenberger_sim::samples::{Between, Samples};
    /// use nalgebra::dmatrix;
    /// let ramp = Samples::new(vec![0.0, 1.0, 3.0], dmatrix![0.0; 2.0; 6.0], Between::Line)?;
    /// let mut value = [0.0];
    /// ramp.at(2.0, &mut value);
    /// assert_eq!(value, [4.0]);
    /// // Beyond the ends it is what it is at the end.
    /// ramp.at(9.0, &mut value);
    /// assert_eq!(value, [6.0]);
    /// # Ok::<(), luenberger_sim::SimError>(())
    /// ```
    /// # Errors
    /// [`SimError::Samples`], [`SimError::Length`], [`SimError::NotFinite`] with the index counted row by row,
    /// [`SimError::TimesUnsorted`].
    pub fn new(t: Vec<f64>, values: DMatrix<f64>, between: Between) -> Result<Self, SimError> {
        if t.len() < 2 {
            return Err(SimError::Samples { samples: t.len() });
        }
        if values.nrows() != t.len() {
            let what = "a table of samples, in rows,".to_owned();
            return Err(SimError::Length { what, expected: t.len(), found: values.nrows() });
        }
        check_finite("the times of samples", &t)?;
        let by_rows: Vec<f64> = values.transpose().iter().copied().collect();
        check_finite("a table of samples", &by_rows)?;
        for (index, pair) in t.windows(2).enumerate() {
            if pair[1] <= pair[0] {
                return Err(SimError::TimesUnsorted { index: index + 1, previous: pair[0], next: pair[1] });
            }
        }
        Ok(Self { t, values, between })
    }

    /// The times.
    pub fn times(&self) -> &[f64] {
        &self.t
    }

    /// The values, one row for each time.
    pub fn values(&self) -> &DMatrix<f64> {
        &self.values
    }

    /// What it is taken to be between the samples.
    pub fn between(&self) -> Between {
        self.between
    }

    /// The same samples with another rule.
    #[must_use]
    pub fn with(self, between: Between) -> Self {
        Self { between, ..self }
    }

    /// Writes the values at `t`, and beyond the ends those of the end. As many are written as there are columns and
    /// room for.
    ///
    /// Cost: the logarithm of the number of samples.
    pub fn at(&self, t: f64, value: &mut [f64]) {
        let next = self.t.partition_point(|&sample| sample <= t);
        self.on(next.saturating_sub(1), t, value);
    }

    /// Writes the values at `t` by what holds from sample `k` to the next: on the right of a jump one still sees what
    /// was held.
    pub(crate) fn on(&self, k: usize, t: f64, value: &mut [f64]) {
        let share = match (self.t.get(k), self.t.get(k + 1)) {
            (Some(start), Some(end)) if self.between == Between::Line => ((t - start) / (end - start)).clamp(0.0, 1.0),
            _ => 0.0,
        };
        for (column, value) in value.iter_mut().enumerate().take(self.values.ncols()) {
            let here = self.values[(k, column)];
            *value = if share == 0.0 { here } else { here + share * (self.values[(k + 1, column)] - here) };
        }
    }

    /// The number of the sample at `t`, up to rounding in multiples of a period.
    pub(crate) fn sample_at(&self, t: f64, period: f64) -> Option<usize> {
        let next = self.t.partition_point(|&sample| sample <= t);
        let near = |k: &usize| self.t.get(*k).is_some_and(|sample| (sample - t).abs() <= 1e-9 * period.max(t.abs()));
        [next.saturating_sub(1), next].into_iter().find(near)
    }
}
