//! The instants at which errors are scored; [`scores`](crate::scores) says why.

use std::fmt;

use crate::error::{SimError, check_positive};

/// Largest number of periods that a common multiple is looked for in.
const MULTIPLES: u32 = 1000;

/// Fewest intervals of a common grid of several periods in a run.
const INTERVALS: f64 = 10.0;

/// The instants at which errors are scored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScoreGrid {
    /// All times of the run.
    Continuous,
    /// The start and every multiple of a period after it.
    Samples {
        /// The period.
        period: f64,
    },
}

impl ScoreGrid {
    /// The instants common to observers with these periods (`None` for those in continuous time) in a run of this
    /// duration: continuous time if none is sampled, otherwise the least common multiple of the periods.
    ///
    /// ```
    /// use luenberger_sim::ScoreGrid;
    /// assert_eq!(ScoreGrid::common(&[None, None], 10.0)?, ScoreGrid::Continuous);
    /// assert_eq!(ScoreGrid::common(&[None, Some(0.02)], 10.0)?, ScoreGrid::Samples { period: 0.02 });
    /// assert_eq!(ScoreGrid::common(&[Some(0.25), Some(0.1)], 10.0)?, ScoreGrid::Samples { period: 0.5 });
    /// assert!(ScoreGrid::common(&[Some(0.1), Some(0.1 * 2f64.sqrt())], 10.0).is_err());
    /// # Ok::<(), luenberger_sim::SimError>(())
    /// ```
    /// # Errors
    /// [`SimError::NoCommonGrid`] for periods without a common multiple of which the run has at least ten.
    pub fn common(periods: &[Option<f64>], duration: f64) -> Result<Self, SimError> {
        let mut common: Option<f64> = None;
        for &period in periods.iter().flatten() {
            check_positive("the period of a sampled-data observer", period)?;
            common = Some(match common {
                None => period,
                Some(other) if near(other, period) => other,
                Some(other) => {
                    let none = SimError::NoCommonGrid { first: other, second: period, duration };
                    let found = multiple(other, period).filter(|common| INTERVALS * common <= duration * (1.0 + 1e-9));
                    found.ok_or(none)?
                }
            });
        }
        Ok(common.map_or(Self::Continuous, |period| Self::Samples { period }))
    }

    /// The period; none in continuous time.
    pub fn period(self) -> Option<f64> {
        match self {
            Self::Continuous => None,
            Self::Samples { period } => Some(period),
        }
    }
}

impl fmt::Display for ScoreGrid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Continuous => write!(f, "Scores in continuous time"),
            Self::Samples { period } => write!(f, "Scores at the samples, every {period}"),
        }
    }
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

/// The least common multiple, up to rounding.
fn multiple(a: f64, b: f64) -> Option<f64> {
    let (short, long) = (a.min(b), a.max(b));
    (1..=MULTIPLES).map(|k| f64::from(k) * long).find(|multiple| {
        let count = multiple / short;
        near(count, count.round())
    })
}
