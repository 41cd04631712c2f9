//! Errors of an export.

/// Why an observer cannot be exported.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// A name that is no identifier of C and Rust.
    #[error("{name:?} is not an identifier of C and Rust: {why}")]
    Identifier {
        /// The name.
        name: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// A list of another length than the observer has.
    #[error("{what} has {found} entries where the observer has {expected}")]
    Length {
        /// Which list.
        what: &'static str,
        /// Required number of entries.
        expected: usize,
        /// Actual number of entries.
        found: usize,
    },
    /// A feedback gain of another shape.
    #[error("K must be {} x {}, found {} x {}", expected.0, expected.1, found.0, found.1)]
    Gain {
        /// Required numbers of rows and columns.
        expected: (usize, usize),
        /// Actual numbers.
        found: (usize, usize),
    },
    /// A number that the format cannot store.
    #[error("{what} is beyond the range of {format}")]
    Format {
        /// Which number.
        what: String,
        /// The format.
        format: &'static str,
    },
    /// An observer without a step in the format.
    #[error("there is no step in {format}: {why}")]
    NoStep {
        /// The error of its design.
        why: String,
        /// The format.
        format: &'static str,
    },
    /// Gains that are not an observer any more after rounding.
    #[error("the gains rounded to {format} are refused: {error}")]
    Rounded {
        /// The format.
        format: &'static str,
        /// The error of the constructor.
        error: luenberger_observers::ObserverError,
    },
    /// A filter whose prediction takes as many steps as its error needs.
    #[error("the filter predicts with control of its error; a target takes a fixed number of Runge-Kutta steps")]
    ErrorControlled,
    /// An observer without a form in fixed point.
    #[error(
        "fixed point is for linear observers and Kalman filters with a constant gain, not for the {}",
        uncapitalised(kind)
    )]
    FixedPointKind {
        /// The observer.
        kind: String,
    },
    /// An observer in filter form with an option that filter form does not support.
    #[error("the filter form is for stationary Kalman filters in floating point without feedback, not with {what}")]
    FilterForm {
        /// The option.
        what: String,
    },
    /// An observer at varying periods in a form with a fixed period.
    #[error("an observer at varying periods is exported as C or Rust without a feedback, not {what}")]
    VaryingPeriods {
        /// The form in which it cannot be exported.
        what: &'static str,
    },
    /// Numbers that a fixed-point format cannot store, or whose sums could overflow.
    #[error("in {format}: {error}")]
    FixedPoint {
        /// The format.
        format: String,
        /// What is wrong.
        error: Box<luenberger_observers::ObserverError>,
    },
    /// The observer leaves the range of the format on the golden vectors: it does not converge there.
    #[error("in step {step} of the golden vectors the estimate leaves the range of {format}: the observer is unstable")]
    NotFinite {
        /// The step, from 0.
        step: usize,
        /// The format.
        format: &'static str,
    },
    /// Two columns of one name.
    #[error("two columns are named {name:?}")]
    Duplicate {
        /// The name.
        name: String,
    },
    /// A unit of time that is not a known multiple of the second, the unit of time of an FMU.
    #[error("the time unit {unit:?} cannot be converted to seconds; s, ms, us, ns, min, h and d can")]
    TimeUnit {
        /// The unit.
        unit: String,
    },
    /// A period that a timer of a board does not have.
    #[error("a period of {seconds} s is not one of the timers of boards; 1e-6 to 2000 s are")]
    Period {
        /// The period.
        seconds: f64,
    },
    /// A period that a timer of a board rounds.
    #[error(
        "a period of {seconds} s is no whole number of microseconds, the unit of the timers of boards; {microseconds}e-6 s is"
    )]
    FractionalPeriod {
        /// The period.
        seconds: f64,
        /// The nearest number of microseconds.
        microseconds: u64,
    },
    /// A C compiler that fails.
    #[error("{compiler} fails: {why}")]
    Compiler {
        /// The command.
        compiler: String,
        /// Its error message.
        why: String,
    },
    /// An archive that cannot be written.
    #[error("the FMU cannot be written: {why}")]
    Archive {
        /// What is wrong.
        why: String,
    },
}

/// Within a sentence: `extended Kalman filter`.
fn uncapitalised(kind: &str) -> String {
    let mut letters = kind.chars();
    letters.next().map(|first| first.to_lowercase().collect::<String>() + letters.as_str()).unwrap_or_default()
}
