//! Observers side by side on one plant, from the same information.
//!
//! All see the same output with the same noise, and all start from the same wrong estimate. Each runs separately, so
//! that a diverging observer fails in its own row only. An input that feeds back estimates is refused:
//! under feedback from its own estimate each observer would see another plant.
//!
//! If any of the observers is sampled, all are scored at the samples, where its estimate is defined; otherwise in
//! continuous time (see [`scores`](crate::scores)). The table says which.
//!
//! Prior information that only one observer has is listed in its row: as stated by the caller, or detected. An
//! observer whose initial state contains x(0) or x(0) - xhat(0), entry for entry, knows the true state, and its row
//! cannot be compared with the others.

use std::fmt;
use std::hint::black_box;
use std::sync::Arc;

use luenberger_clock::Instant;
use luenberger_observers::{Observer, SampledObserver};
use luenberger_plants::Dimensions;

use crate::erased::{AnyObserver, Continuous, Sampled};
use crate::error::{SimError, check, check_positive};
use crate::noise::Noise;
use crate::scenario::{Estimated, Scenario};
use crate::scores::{Band, ErrorMetrics, Errors, ScoreGrid, StateScores, check_scale};
use crate::trajectory::Trajectory;
use crate::view::View;

/// A comparison to be run.
#[derive(Clone, Debug)]
pub struct Comparison<'a> {
    /// Plant, input, noise and times: the same for all.
    scenario: Scenario<'a>,
    xhat0: Vec<f64>,
    band: f64,
    score_period: Option<f64>,
    scale: Option<Vec<f64>>,
    entries: Vec<Entry<'a>>,
    prior_information: Vec<(String, String)>,
}

#[derive(Clone, Debug)]
struct Entry<'a> {
    name: String,
    observer: Arc<dyn AnyObserver + 'a>,
}

impl<'a> Comparison<'a> {
    /// A comparison in `scenario`, which has no observers, from the estimate `xhat0` that all observers start from.
    pub fn new(scenario: Scenario<'a>, xhat0: &[f64]) -> Self {
        Self {
            scenario,
            xhat0: xhat0.to_vec(),
            band: 0.05,
            score_period: None,
            scale: None,
            entries: Vec::new(),
            prior_information: Vec::new(),
        }
    }

    /// The band of settling, as a fraction of `|x(0) - xhat(0)|` (default 0.05).
    #[must_use]
    pub fn band(mut self, fraction: f64) -> Self {
        self.band = fraction;
        self
    }

    /// Scores at multiples of this period, at least the longest sampling period (default: the samples of the sampled
    /// observers, and continuous time if there are none).
    #[must_use]
    pub fn score_period(mut self, period: f64) -> Self {
        self.score_period = Some(period);
        self
    }

    /// The scale of each state, by which its error is divided in the norm |e| (default 1 for each: the Euclidean norm
    /// of numbers with different units).
    #[must_use]
    pub fn scale(mut self, scale: &[f64]) -> Self {
        self.scale = Some(scale.to_vec());
        self
    }

    /// An observer in continuous time, of the whole state.
    #[must_use]
    pub fn observer(mut self, name: &str, observer: &'a (impl Observer<f64> + Sync)) -> Self {
        self.entries.push(Entry { name: name.to_owned(), observer: Arc::new(Continuous::new(observer)) });
        self
    }

    /// A sampled-data observer, of the whole state.
    #[must_use]
    pub fn sampled_observer(mut self, name: &str, observer: &'a (impl SampledObserver<f64> + Sync)) -> Self {
        self.entries.push(Entry { name: name.to_owned(), observer: Arc::new(Sampled(observer)) });
        self
    }

    /// Records information that only the observer of that name has; it is listed in its row.
    #[must_use]
    pub fn prior_information(mut self, name: &str, what: &str) -> Self {
        self.prior_information.push((name.to_owned(), what.to_owned()));
        self
    }

    /// Runs every observer.
    ///
    /// ```
    /// use luenberger_observers::{Integral, LinearObserver, MeanValueObserver};
    /// use luenberger_sim::{Comparison, Scenario};
    /// use nalgebra::Vector2;
    ///
    /// let plant = luenberger_plants::double_integrator();
    /// let linear = LinearObserver::of(plant.clone(), Vector2::new(7.0, 10.0))?;
    /// let e0 = Vector2::new(1.0, -2.0);
    /// let informed = MeanValueObserver::new(plant.clone(), 1.0, Integral, e0)?;
    /// let scenario = Scenario::new(plant).initial_state(&[1.0, -2.0]).until(10.0, 101);
    /// let table = Comparison::new(scenario, &[0.0, 0.0])
    ///     .observer("linear", &linear)
    ///     .observer("mean value", &informed)
    ///     .run()?;
    /// assert!(table.metrics("linear")?.settling_last < Some(3.0));
    /// assert!(table.row("linear")?.prior_information.is_empty());
    /// assert_eq!(table.row("mean value")?.prior_information, ["its state at the start contains x(0) - xhat(0)"]);
    /// println!("{table}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// For invalid input, those of [`Scenario::run`]; [`SimError::NoObserver`], [`SimError::ObserverOfScenario`],
    /// [`SimError::EstimateFeedback`]; [`SimError::NoCommonGrid`] for sampling periods without a common multiple,
    /// [`SimError::ScorePeriod`]. A run that ends early ([`SimError::ends_run`]) is no error: its row says
    /// so.
    pub fn run(self) -> Result<Compared, SimError> {
        let size = self.scenario.plant.dimensions();
        let x0 = self.scenario.x0.clone().unwrap_or_else(|| vec![0.0; size.states]);
        check("the initial state", &x0, size.states)?;
        check("the initial estimate", &self.xhat0, size.states)?;
        check_positive("the band of settling", self.band)?;
        if self.scenario.input.reads_estimates() {
            return Err(SimError::EstimateFeedback);
        }
        if let Some(observer) = self.scenario.observers.first() {
            return Err(SimError::ObserverOfScenario { name: observer.name.clone() });
        }
        if self.entries.is_empty() {
            return Err(SimError::NoObserver);
        }
        let e0: Vec<f64> = x0.iter().zip(&self.xhat0).map(|(x, xhat)| x - xhat).collect();
        if let Some(scale) = &self.scale {
            check_scale(scale, size.states)?;
        }
        let unit = |i: usize| self.scale.as_ref().map_or(1.0, |scale| scale[i]);
        let initial_error = e0.iter().enumerate().map(|(i, e)| (e / unit(i)).powi(2)).sum::<f64>().sqrt();
        check_positive("|x(0) - xhat(0)|, the error to be observed away,", initial_error)?;
        for (k, entry) in self.entries.iter().enumerate() {
            if self.entries[..k].iter().any(|other| other.name == entry.name) {
                return Err(SimError::DuplicateName { name: entry.name.clone() });
            }
        }
        if let Some((name, _)) =
            self.prior_information.iter().find(|(name, _)| self.entries.iter().all(|e| e.name != *name))
        {
            return Err(SimError::UnknownName { name: name.clone() });
        }
        let grid = if let Some(period) = self.score_period {
            ScoreGrid::Samples { period }
        } else {
            let periods: Vec<Option<f64>> = self.entries.iter().map(|entry| entry.observer.period()).collect();
            ScoreGrid::common(&periods, self.scenario.duration()?)?
        };
        let within = Band::Within(self.band * initial_error);
        let rows = self
            .entries
            .iter()
            .map(|entry| self.row(entry, (&x0, &e0), (grid, within), size))
            .collect::<Result<_, _>>()?;
        Ok(Compared {
            initial_error,
            band: self.band,
            grid,
            scale: self.scale,
            seed: self.scenario.noise.as_ref().map(Noise::seed),
            rows,
        })
    }

    fn row(
        &self,
        entry: &Entry<'a>,
        (x0, e0): (&[f64], &[f64]),
        (grid, within): (ScoreGrid, Band),
        size: Dimensions,
    ) -> Result<Row, SimError> {
        let Entry { name, observer } = entry;
        let scenario = self.scenario.clone().entry(name, Arc::clone(observer), &self.xhat0, Estimated::State);
        let trajectory = match scenario.run() {
            Ok(trajectory) => Ok(trajectory),
            Err(error) if error.ends_run() => Err(error),
            Err(error) => return Err(error),
        };

        // From here on lengths are known to fit: the run has checked them.
        let own = observer.dimensions();
        let (mut u0, mut y0) = (vec![0.0; size.inputs], vec![0.0; size.outputs]);
        let zero_input = vec![0.0; size.inputs];
        let t = self.scenario.start;
        let view = View { t, x: x0, u: &zero_input, y: &[], names: &[], estimates: &[], errors: &[] };
        self.scenario.input.write(&view, &mut u0);
        self.scenario.plant.output(t, x0, &u0, &mut y0);
        let mut z0 = vec![0.0; own.state];
        observer.initial(t, &self.xhat0, &u0, &y0, &mut z0);
        let mut prior_information: Vec<String> =
            self.prior_information.iter().filter(|(of, _)| of == name).map(|(_, what)| what.clone()).collect();
        // The two are one when the estimate starts at 0.
        let answers = [(e0, "x(0) - xhat(0)"), (x0, "x(0)")];
        if let Some((_, what)) = answers.into_iter().find(|(answer, _)| contains(&z0, answer)) {
            prior_information.push(format!("its state at the start contains {what}"));
        }

        let cost = cost(observer.as_ref(), &z0, &u0, &y0);
        let cost = Cost { seconds: cost, per_sample: observer.period().is_some() };
        let (outcome, states, trajectory) = match trajectory {
            Ok(trajectory) => {
                let errors = Errors::of(&trajectory, name, grid)?;
                let (merits, states) = (errors.merits(self.scale.as_deref(), within)?, errors.states()?);
                (Ok(merits), states, Some(trajectory))
            }
            Err(error) => (Err(error), Vec::new(), None),
        };
        Ok(Row { name: name.clone(), prior_information, outcome, states, cost, trajectory })
    }
}

/// Whether `answer` stands in `state`, entry for entry up to rounding. A single number, or one with zeros, may stand
/// there by chance and is not taken for it.
fn contains(state: &[f64], answer: &[f64]) -> bool {
    let near = |a: &f64, b: &f64| (a - b).abs() <= 4.0 * f64::EPSILON * b.abs();
    answer.len() > 1
        && answer.iter().all(|entry| *entry != 0.0)
        && state.windows(answer.len()).any(|window| window.iter().zip(answer).all(|(a, b)| near(a, b)))
}

/// Seconds of one evaluation: the best of several batches, because all that disturbs a measurement makes it longer.
fn cost(observer: &dyn AnyObserver, z: &[f64], u: &[f64], y: &[f64]) -> f64 {
    const BATCHES: usize = 5;
    const CALLS: u32 = 200;
    let mut target = z.to_vec();
    let mut best = f64::INFINITY;
    for _ in 0..BATCHES {
        let start = Instant::now();
        for _ in 0..CALLS {
            if observer.period().is_some() {
                target.copy_from_slice(black_box(z));
                observer.step(0.0, &mut target, black_box(u), black_box(y), &[]);
            } else {
                observer.derivative(0.0, black_box(z), black_box(u), black_box(y), &mut target);
            }
            black_box(&target);
        }
        best = best.min(start.elapsed().as_secs_f64() / f64::from(CALLS));
    }
    best
}

/// Result of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// `|x(0) - xhat(0)|`, the same for all.
    pub initial_error: f64,
    /// The instants at which all are scored.
    pub grid: ScoreGrid,
    /// The scale of the norm, if one was given.
    pub scale: Option<Vec<f64>>,
    /// The band of settling, as a fraction of `initial_error`.
    pub band: f64,
    /// The seed of the noise, if there was any.
    pub seed: Option<u64>,
    /// The observers, in the order in which they were given.
    pub rows: Vec<Row>,
}

/// One observer.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// Information that only this observer has, stated by the caller or detected; empty for a fair comparison.
    pub prior_information: Vec<String>,
    /// Its scores, or the error that ended its run.
    pub outcome: Result<ErrorMetrics, SimError>,
    /// The scores of each state, in its unit; empty if the run failed.
    pub states: Vec<StateScores>,
    /// Measured time per step or evaluation; it varies from run to run.
    pub cost: Cost,
    /// Its run; none if it failed.
    pub trajectory: Option<Trajectory>,
}

/// Time of one evaluation, the conversion from and to slices included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Seconds.
    pub seconds: f64,
    /// Whether `seconds` is for one step per sample; otherwise it is for one evaluation of the right-hand side, of
    /// which a step of an integrator needs several.
    pub per_sample: bool,
}

impl Compared {
    /// The row of that name.
    ///
    /// # Errors
    /// [`SimError::UnknownName`].
    pub fn row(&self, name: &str) -> Result<&Row, SimError> {
        self.rows.iter().find(|row| row.name == name).ok_or_else(|| SimError::UnknownName { name: name.to_owned() })
    }

    /// The scores of the observer of that name.
    ///
    /// # Errors
    /// [`SimError::UnknownName`], and the error that ended its run.
    pub fn metrics(&self, name: &str) -> Result<&ErrorMetrics, SimError> {
        self.row(name)?.outcome.as_ref().map_err(Clone::clone)
    }
}

impl fmt::Display for Compared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0).max(8);
        writeln!(f, "|e(0)| = {:.4}, settled within {:.4}", self.initial_error, self.band * self.initial_error)?;
        writeln!(f, "{}", self.grid)?;
        if let Some(scale) = &self.scale {
            writeln!(f, "norm in units of scale = {scale:?}")?;
        }
        if let Some(seed) = self.seed {
            writeln!(f, "noise of seed {seed}, the same for all")?;
        }
        writeln!(
            f,
            "{:width$} {:>10} {:>10} {:>10} {:>10} {:>10} {:>16}",
            "observer", "settles", "stays", "peak", "RMS", "at the end", "cost"
        )?;
        let time = |time: Option<f64>| time.map_or_else(|| "never".to_owned(), |t| format!("{t:.4}"));
        for row in &self.rows {
            let unit = if row.cost.per_sample { "sample" } else { "slope" };
            let cost = format!("{:.2} us/{unit}", row.cost.seconds * 1e6);
            match &row.outcome {
                Ok(merits) => {
                    let (first, last) = (time(merits.settling_first), time(merits.settling_last));
                    write!(f, "{:width$} {first:>10} {last:>10}", row.name)?;
                    write!(f, " {:>10.3e} {:>10.3e} {:>10.3e} {cost:>16}", merits.peak, merits.rmse, merits.last)?;
                }
                Err(error) => write!(f, "{:width$} {error} {cost:>16}", row.name)?,
            }
            for what in &row.prior_information {
                write!(f, "  [given more: {what}]")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}
