//! Errors of a simulation, with the relevant numbers.

use luenberger_wording::significant;

/// Why a simulation could not be set up or finished.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// A column of the wrong length.
    #[error("{what} has {found} entries where {expected} are expected")]
    Length {
        /// Name of the column.
        what: String,
        /// Required length.
        expected: usize,
        /// The length found.
        found: usize,
    },
    /// A number that is NaN or infinite where none may be.
    #[error("entry {} of {what} is {value}, not a finite number", index + 1)]
    NotFinite {
        /// Name of the quantity.
        what: String,
        /// Its index, from 0.
        index: usize,
        /// The number.
        value: f64,
    },
    /// No time span to simulate.
    #[error("a simulation from t = {start} to t = {end} has no length: say how long with `until` or `times`")]
    TimeSpan {
        /// Start.
        start: f64,
        /// End.
        end: f64,
    },
    /// Fewer than two requested times.
    #[error("{samples} equally spaced times do not span anything: at least 2 are needed, the start and the end")]
    Samples {
        /// Number of times requested.
        samples: usize,
    },
    /// Requested times that do not increase.
    #[error("times must increase: entry {} is {next} after {previous}", index + 1)]
    TimesUnsorted {
        /// Index of the second of the two, from 0.
        index: usize,
        /// The first of the two.
        previous: f64,
        /// The second of the two.
        next: f64,
    },
    /// A quantity that must be positive and finite.
    #[error("{what} is {value}; it must be positive and finite")]
    NotPositive {
        /// Name of the quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// An amplitude or standard deviation of noise below 0.
    #[error("noise {} has the amplitude {value}; it must not be negative", index + 1)]
    NegativeNoise {
        /// The entry of the noise, from 0.
        index: usize,
        /// Its amplitude.
        value: f64,
    },
    /// A probability outside of [0, 1].
    #[error("the probability of {what} is {value}; it must be from 0 to 1")]
    Probability {
        /// Of what.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// A comparison whose input depends on estimates.
    #[error("observers are compared on one input: a feedback of estimates would give each another plant")]
    EstimateFeedback,
    /// A comparison without observers.
    #[error("there is no observer to compare")]
    NoObserver,
    /// A comparison whose scenario has observers of its own.
    #[error(
        "observer {name:?} belongs to the scenario: add it to the comparison, which gives all the same first estimate"
    )]
    ObserverOfScenario {
        /// The first of them.
        name: String,
    },
    /// Two observers, or two integrals, of one name.
    #[error("the name {name:?} is used twice")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// No observer, estimate or integral has this name.
    #[error("there is no observer or integral named {name:?}")]
    UnknownName {
        /// The name.
        name: String,
    },
    /// An index of a state, estimate or output that does not exist.
    #[error("{what} {} does not exist: there are {count}", index + 1)]
    Index {
        /// What is counted.
        what: &'static str,
        /// The index asked for, from 0.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// Two sensors of one output.
    #[error("output {} has two sensors", output + 1)]
    SensorTwice {
        /// The output, from 0.
        output: usize,
    },
    /// An observer in continuous time of a plant in discrete time.
    #[error("observer {name:?} is in continuous time, and the plant in discrete time")]
    ContinuousObserver {
        /// The observer.
        name: String,
    },
    /// A feedback from an estimate, or of an output, that itself depends on the input.
    #[error(
        "the input depends on itself through an estimate or an output: evaluated again with the input found it moves by {change:e}"
    )]
    AlgebraicLoop {
        /// Change of the input when it is evaluated again with the value found.
        change: f64,
    },
    /// Sampling periods without a common multiple in the run, so that there are no instants at which to score all.
    #[error(
        "the sampling periods {first} and {second} have no common multiple that occurs ten times in a run of {duration}: \
         set the period of the scores"
    )]
    NoCommonGrid {
        /// A period, or the common multiple of several.
        first: f64,
        /// The period that does not fit.
        second: f64,
        /// The duration of the run.
        duration: f64,
    },
    /// Scores between the samples of an observer, where its estimate is not defined.
    #[error(
        "scores every {period} are finer than the samples of {observer:?}, every {own}: its estimate is defined there"
    )]
    ScorePeriod {
        /// The period of the scores.
        period: f64,
        /// The observer.
        observer: String,
        /// Its sampling period.
        own: f64,
    },
    /// The solution is unbounded in finite time, or grows past 1e100.
    #[error("stopped at t = {}: the solution blows up, its norm has reached {}", short(*time), short(*norm))]
    BlowUp {
        /// Time up to which it exists, located to the spacing of floating-point numbers there.
        time: f64,
        /// Its largest entry then.
        norm: f64,
    },
    /// A derivative leaves every bound where the solution itself is of moderate size, as at a division by zero.
    #[error(
        "stopped at t = {}: the derivative of entry {} is unbounded there ({} at the value {}), as by a division \
         by zero",
        short(*time), index + 1, short(*slope), short(*value)
    )]
    Singular {
        /// Time reached.
        time: f64,
        /// Index of the entry, from 0: the plant's states, then those of the observers in continuous time.
        index: usize,
        /// Its value.
        value: f64,
        /// Its derivative.
        slope: f64,
    },
    /// A right-hand side that is not finite where the solution arrives.
    #[error(
        "stopped at t = {}: the right-hand side is not finite, its entry {} is {value} at the state {state:?}",
        short(*time), index + 1
    )]
    NotDefined {
        /// The time.
        time: f64,
        /// Index of the entry, from 0.
        index: usize,
        /// The entry.
        value: f64,
        /// The state: the plant's, then the observers' in their order.
        state: Vec<f64>,
    },
    /// The state of a sampled observer is not finite after a sample.
    #[error("stopped at t = {}: entry {} of the state of {observer:?} is {value} after this sample", short(*time), index + 1)]
    ObserverNotFinite {
        /// The observer.
        observer: String,
        /// The time of the sample.
        time: f64,
        /// Index of the entry, from 0.
        index: usize,
        /// The entry.
        value: f64,
    },
    /// An input, output or estimate that is not finite along the run.
    #[error("stopped at t = {}: {what} is {value}", short(*time))]
    QuantityNotFinite {
        /// The time.
        time: f64,
        /// Its name.
        what: String,
        /// Its value.
        value: f64,
    },
    /// An output that an observer needs, and that is not defined at its estimate.
    #[error(
        "stopped at t = {}{}: output {} is {value} at the estimate of {observer:?}{}",
        short(*time), of_row(*row), output + 1, if *is_measured { "" } else { NEEDS_PREDICTION }
    )]
    OutputNotFinite {
        /// The observer.
        observer: String,
        /// The time.
        time: f64,
        /// The row of the log, from 0; none between rows.
        row: Option<usize>,
        /// The output, from 0.
        output: usize,
        /// Its value, or that of its innovation.
        value: f64,
        /// Whether it was measured; otherwise the observer needs its prediction.
        is_measured: bool,
    },
    /// The step size fell to the spacing of floating-point numbers although the solution does not grow.
    #[error(
        "stopped at t = {}: step size {} is the spacing of floating-point numbers (right-hand side not smooth there)",
        short(*time), short(*step)
    )]
    StepSize {
        /// Time reached.
        time: f64,
        /// Step size there.
        step: f64,
    },
    /// The cap on the number of steps was reached.
    #[error(
        "stopped at t = {}: step limit reached (stiff or diverging), {steps} steps, step size {}",
        short(*time), short(*step)
    )]
    TooManySteps {
        /// Time reached.
        time: f64,
        /// Step size there.
        step: f64,
        /// Steps taken.
        steps: usize,
    },
    /// The eigenvalues of a Gramian did not converge.
    #[error("the eigenvalues of a Gramian of norm {norm:e} did not converge in {iterations} iterations")]
    Eigenvalues {
        /// Iterations allowed.
        iterations: usize,
        /// Norm of the Gramian.
        norm: f64,
    },
    /// An input of a log that is missing in the first row.
    #[error("input {} of the log is missing in the first row, t = {time}: nothing is known that could be held", input + 1)]
    NoInput {
        /// The input, from 0.
        input: usize,
        /// The first time.
        time: f64,
    },
    /// An observer in discrete time whose samples are not those of the log.
    #[error(
        "the period {period} of observer {name:?} does not fit the log: of {rows} rows (median Ts {median}) only the first lies on its samples"
    )]
    PeriodDoesNotFit {
        /// The observer.
        name: String,
        /// Its period.
        period: f64,
        /// The rows of the log.
        rows: usize,
        /// Their median period.
        median: f64,
    },
    /// An observer in discrete time, or a prediction, with more steps than are sensible for a log.
    #[error("observer {name:?} with the period {period} needs {steps:e} steps for the log; the limit is {limit:e}")]
    TooManySamples {
        /// The observer.
        name: String,
        /// Its period.
        period: f64,
        /// The steps.
        steps: f64,
        /// Their limit.
        limit: f64,
    },
    /// A change of the plant that is not after the start.
    #[error("the plant changes at t = {time}; expected a time after the start, t = {start}")]
    ChangeTime {
        /// Time of the change.
        time: f64,
        /// The start of the run.
        start: f64,
    },
    /// The time limit of the settings.
    #[error("stopped at t = {} by the time limit", short(*time))]
    TimeLimit {
        /// Time at which the run was stopped.
        time: f64,
    },
    /// A time outside the simulated span.
    #[error("t = {time} lies outside the simulated span from {start} to {end}")]
    Outside {
        /// Time asked for.
        time: f64,
        /// Start of the span.
        start: f64,
        /// End of the span.
        end: f64,
    },
}

impl SimError {
    /// Whether the error occurred during the run (and not when it was set up): a comparison then reports it in the row
    /// of the observer and still compares the others.
    pub fn ends_run(&self) -> bool {
        matches!(
            self,
            Self::BlowUp { .. }
                | Self::Singular { .. }
                | Self::NotDefined { .. }
                | Self::ObserverNotFinite { .. }
                | Self::QuantityNotFinite { .. }
                | Self::OutputNotFinite { .. }
                | Self::StepSize { .. }
                | Self::TooManySteps { .. }
                | Self::TimeLimit { .. }
        )
    }
}

/// Why an output matters that was not measured.
const NEEDS_PREDICTION: &str = ", which predicts it where it is not measured";

/// `, row 3`, counted from 1.
fn of_row(row: Option<usize>) -> String {
    row.map(|row| format!(", row {}", row + 1)).unwrap_or_default()
}

/// A number with six significant digits.
fn short(x: f64) -> String {
    significant(x, 6)
}

/// Checks that there are `expected` entries and that they are finite.
pub(crate) fn check(what: &str, entries: &[f64], expected: usize) -> Result<(), SimError> {
    if entries.len() != expected {
        return Err(SimError::Length { what: what.to_owned(), expected, found: entries.len() });
    }
    check_finite(what, entries)
}

/// Checks that the entries are finite.
pub(crate) fn check_finite(what: &str, entries: &[f64]) -> Result<(), SimError> {
    match entries.iter().position(|entry| !entry.is_finite()) {
        Some(index) => Err(SimError::NotFinite { what: what.to_owned(), index, value: entries[index] }),
        None => Ok(()),
    }
}

/// Checks that the number is positive and finite.
pub(crate) fn check_positive(what: &'static str, value: f64) -> Result<(), SimError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(SimError::NotPositive { what, value }) }
}
