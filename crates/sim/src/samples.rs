//! Sampled quantities: their interpolation between the samples, and missing values.

use nalgebra::DMatrix;

use crate::error::{SimError, check_finite};

/// Interpolation of a sampled quantity between its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleInterpolation {
    /// The last sample is held (zero-order hold): causal.
    ZeroOrderHold,
    /// Linear interpolation to the next sample: not causal.
    Linear,
}

/// Columns of numbers at increasing times, which need not be equally spaced. [`Samples::value`] is `None`
/// for a missing value.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    t: Vec<f64>,
    /// One row for each time. In the place of a missing value stands the last one before it, or the first one after.
    values: DMatrix<f64>,
    /// Which values are missing; `None` if none is.
    missing: Option<DMatrix<bool>>,
    between: SampleInterpolation,
}

impl Samples {
    /// The samples `values` (one row for each time) at the times `t`, at least 2.
    ///
    /// ```
    /// use luenberger_sim::samples::{SampleInterpolation, Samples};
    /// use nalgebra::dmatrix;
    /// let ramp = Samples::new(vec![0.0, 1.0, 3.0], dmatrix![0.0; 2.0; 6.0], SampleInterpolation::Linear)?;
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
    pub fn new(t: Vec<f64>, values: DMatrix<f64>, between: SampleInterpolation) -> Result<Self, SimError> {
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
        Ok(Self { t, values, missing: None, between })
    }

    /// As [`new`](Self::new), with `None` for each value that is missing.
    ///
    /// ```
    /// use luenberger_sim::samples::{SampleInterpolation, Samples};
    /// use nalgebra::dmatrix;
    /// let t = vec![0.0, 1.0, 2.0];
    /// let values = dmatrix![Some(5.0); None; Some(7.0)];
    /// let samples = Samples::with_missing(t, &values, SampleInterpolation::ZeroOrderHold)?;
    /// assert_eq!((samples.value(0, 0), samples.value(1, 0)), (Some(5.0), None));
    /// assert_eq!(samples.count(0), 2);
    /// # Ok::<(), luenberger_sim::SimError>(())
    /// ```
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_missing(
        t: Vec<f64>,
        values: &DMatrix<Option<f64>>,
        between: SampleInterpolation,
    ) -> Result<Self, SimError> {
        let mut filled = DMatrix::zeros(values.nrows(), values.ncols());
        for (column, mut filled) in values.column_iter().zip(filled.column_iter_mut()) {
            let mut last = column.iter().copied().find_map(|value| value).unwrap_or(0.0);
            for (value, filled) in column.iter().zip(filled.iter_mut()) {
                last = value.unwrap_or(last);
                *filled = last;
            }
        }
        let missing = values.map(|value| value.is_none());
        let any = missing.iter().any(|missing| *missing);
        Ok(Self { missing: any.then_some(missing), ..Self::new(t, filled, between)? })
    }

    /// The times.
    pub fn times(&self) -> &[f64] {
        &self.t
    }

    /// The values, one row for each time. In the place of a missing value stands the last one before it; before the
    /// first one, the first one; and 0 in a column without values.
    pub fn values(&self) -> &DMatrix<f64> {
        &self.values
    }

    /// The value in this row and column; none if it is missing or beyond the table.
    pub fn value(&self, row: usize, column: usize) -> Option<f64> {
        let missing = self.missing.as_ref().is_some_and(|missing| missing.get((row, column)).copied().unwrap_or(true));
        if missing { None } else { self.values.get((row, column)).copied() }
    }

    /// How many values of a column there are.
    pub fn count(&self, column: usize) -> usize {
        (0..self.t.len()).filter(|&row| self.value(row, column).is_some()).count()
    }

    /// The interpolation between the samples.
    pub fn between(&self) -> SampleInterpolation {
        self.between
    }

    /// The same samples with another interpolation.
    #[must_use]
    pub fn with(self, between: SampleInterpolation) -> Self {
        Self { between, ..self }
    }

    /// Writes the values at `t` into `value`, up to the smaller of its length and the number of columns. Outside of the
    /// sampled times the first or last values are held. For missing values see [`values`](Self::values).
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
            (Some(start), Some(end)) if self.between == SampleInterpolation::Linear => {
                ((t - start) / (end - start)).clamp(0.0, 1.0)
            }
            _ => 0.0,
        };
        for (column, value) in value.iter_mut().enumerate().take(self.values.ncols()) {
            let here = self.values[(k, column)];
            *value = if share == 0.0 { here } else { here + share * (self.values[(k + 1, column)] - here) };
        }
    }
}
