//! Inputs and references of a study: expressions of time, tables, state feedback.

use luenberger_design::OperatingPoint;
use luenberger_expression::{Expression, ExpressionError, ParameterError, Parameters, Scope, Undefined};
use luenberger_sim::{Samples, Signal};
use nalgebra::DMatrix;

/// Error of a signal. Components count from 1 in the messages.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SignalError {
    /// An invalid parameter.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A text that is not an expression of time.
    #[error("component {}: {error}", index + 1)]
    Expression {
        /// The component, from 0.
        index: usize,
        /// The error of the expression.
        error: ExpressionError,
    },
    /// A signal with the wrong number of components.
    #[error("the signal has {found} components where {expected} are needed")]
    Length {
        /// The required number.
        expected: usize,
        /// The actual number.
        found: usize,
    },
    /// An expression without a finite value at some time.
    #[error("component {} = {text}: {undefined}, at t = {time}", index + 1)]
    Undefined {
        /// The component, from 0.
        index: usize,
        /// Its text.
        text: String,
        /// The subexpression that is not finite.
        undefined: Box<Undefined>,
        /// The time.
        time: f64,
    },
    /// A table that does not cover the time span of a run.
    #[error("the table reaches from t = {} to t = {}, the run from t = {} to t = {}", table.0, table.1, run.0, run.1)]
    Span {
        /// First and last time of the table.
        table: (f64, f64),
        /// Start and end of the run.
        run: (f64, f64),
    },
}

/// A function of time with several components.
#[derive(Clone, Debug, PartialEq)]
pub enum Program {
    /// One expression of t for each component.
    Expressions(Vec<Expression>),
    /// Columns of a table.
    Table(Samples),
}

/// Number of times at which a signal is evaluated before the run.
const TRIES: usize = 1000;

impl Program {
    /// The program of these expressions of `t` and the parameters.
    ///
    /// ```
    /// use luenberger_expression::Parameters;
    /// use luenberger_study::signal::Program;
    /// let program = Program::expressions(&["2*sin(3*t)", "max(0, t - 1)"], &Parameters::new())?;
    /// let mut u = [0.0; 2];
    /// program.at(2.0, &mut u);
    /// assert_eq!(u, [2.0 * 6f64.sin(), 1.0]);
    /// # Ok::<(), luenberger_study::signal::SignalError>(())
    /// ```
    /// # Errors
    /// [`SignalError::Parameter`], and [`SignalError::Expression`] for the first invalid text.
    pub fn expressions<S: AsRef<str>>(texts: &[S], parameters: &Parameters) -> Result<Self, SignalError> {
        let scope = Scope::time().with(parameters)?;
        let parsed = texts.iter().map(|text| Expression::parse(text.as_ref(), &scope)).enumerate();
        let expressions = parsed.map(|(index, one)| one.map_err(|error| SignalError::Expression { index, error }));
        Ok(Self::Expressions(expressions.collect::<Result<_, _>>()?))
    }

    /// Number of components.
    pub fn len(&self) -> usize {
        match self {
            Self::Expressions(expressions) => expressions.len(),
            Self::Table(samples) => samples.values().ncols(),
        }
    }

    /// Whether it has no components.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Writes the components at the time t.
    pub fn at(&self, t: f64, value: &mut [f64]) {
        match self {
            Self::Expressions(expressions) => {
                for (value, expression) in value.iter_mut().zip(expressions) {
                    *value = expression.evaluate(t, &[], &[]);
                }
            }
            Self::Table(samples) => samples.at(t, value),
        }
    }

    /// Checks that the signal has this number of components and is finite over a run: expressions are evaluated at 1001
    /// equally spaced times, tables are compared with the time span.
    ///
    /// # Errors
    /// [`SignalError::Length`], [`SignalError::Undefined`], [`SignalError::Span`].
    pub fn check(&self, components: usize, start: f64, end: f64) -> Result<(), SignalError> {
        if self.len() != components {
            return Err(SignalError::Length { expected: components, found: self.len() });
        }
        match self {
            Self::Expressions(expressions) => {
                let times = (0..=TRIES).map(|k| start + (end - start) * k as f64 / TRIES as f64);
                for time in times {
                    for (index, expression) in expressions.iter().enumerate() {
                        expression.examine(time, &[], &[]).map_err(|undefined| SignalError::Undefined {
                            index,
                            text: expression.text().to_owned(),
                            undefined: Box::new(undefined),
                            time,
                        })?;
                    }
                }
                Ok(())
            }
            Self::Table(samples) => {
                let (first, last) = (samples.times()[0], samples.times()[samples.times().len() - 1]);
                // Equal up to rounding in multiples of a period.
                let slack = 1e-9 * (last - first);
                let inside = first - slack <= start && end <= last + slack;
                if inside { Ok(()) } else { Err(SignalError::Span { table: (first, last), run: (start, end) }) }
            }
        }
    }

    /// The times within a run at which the signal may jump or have a kink: those of a table. Discontinuities of
    /// expressions are not detected; they must be given by the caller.
    pub fn breakpoints(&self, start: f64, end: f64) -> Vec<f64> {
        match self {
            Self::Expressions(_) => Vec::new(),
            Self::Table(samples) => samples.times().iter().copied().filter(|t| (start..end).contains(t)).collect(),
        }
    }

    fn signal(&self) -> Signal<'static> {
        let program = self.clone();
        Signal::function(move |t, u| program.at(t, u))
    }
}

/// The input of a plant in a study.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// `u = 0`.
    Zero,
    /// `u = r(t)`.
    Program(Program),
    /// `u = r(t) - K xhat`.
    Feedback {
        /// The observer that estimates.
        observer: String,
        /// K, m x n.
        gain: DMatrix<f64>,
        /// r, 0 if there is none.
        reference: Option<Program>,
    },
    /// A law of time and the true state, `u = k(t, x)`, for comparison.
    Law {
        /// One expression of t and the states for each input.
        law: Vec<Expression>,
        /// Where it jumps in time.
        jumps: Vec<f64>,
    },
    /// `u = r(t) - K x` with the true state, for comparison.
    StateFeedback {
        /// K, m x n.
        gain: DMatrix<f64>,
        /// r, 0 if there is none.
        reference: Option<Program>,
    },
}

impl Input {
    /// The input in the form that the simulation takes.
    ///
    /// ```
    /// use luenberger_expression::Parameters;
    /// use luenberger_observers::LinearObserver;
    /// use luenberger_sim::Scenario;
    /// use luenberger_study::signal::{Input, Program};
    /// use nalgebra::{Vector2, dmatrix};
    ///
    /// let plant = luenberger_plants::double_integrator();
    /// let observer = LinearObserver::of(plant.clone(), Vector2::new(7.0, 10.0))?;
    /// let reference = Program::expressions(&["8"], &Parameters::new())?;
    /// let input = Input::Feedback { observer: "linear".into(), gain: dmatrix![4.0, 4.0], reference: Some(reference) };
    /// let scenario = Scenario::new(plant).observer("linear", observer, &[1.0, -1.0]);
    /// let trajectory = scenario.input(input.signal()).until(20.0, 2).run()?;
    /// assert!((trajectory.x[(1, 0)] - 2.0).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn signal(&self) -> Signal<'static> {
        let led = |signal: Signal<'static>, reference: &Option<Program>| match reference.clone() {
            Some(program) => signal.plus(move |t, r| program.at(t, r)),
            None => signal,
        };
        match self {
            Self::Zero => Signal::zero(),
            Self::Program(program) => program.signal(),
            Self::Feedback { observer, gain, reference } => led(Signal::feedback(observer, gain.clone()), reference),
            Self::StateFeedback { gain, reference } => led(Signal::state_feedback(gain.clone()), reference),
            Self::Law { law, .. } => {
                let law = law.clone();
                Signal::law(move |view, u| {
                    for (u, row) in u.iter_mut().zip(&law) {
                        *u = row.evaluate(view.t, view.x, &[]);
                    }
                })
            }
        }
    }

    /// The same, with a feedback of the deviations from an operating point, `u = r(t) + u0 - K (xhat - x0)`, if there
    /// is one.
    pub fn signal_at(&self, point: Option<&OperatingPoint>) -> Signal<'static> {
        let signal = self.signal();
        match (self, point) {
            (Self::Feedback { gain, .. } | Self::StateFeedback { gain, .. }, Some(point)) => {
                let shift = &point.u + gain * &point.x;
                signal.plus(move |_, u| u.copy_from_slice(shift.as_slice()))
            }
            _ => signal,
        }
    }

    /// Its function of time, if any.
    pub fn program(&self) -> Option<&Program> {
        match self {
            Self::Zero | Self::Law { .. } => None,
            Self::Program(program) => Some(program),
            Self::Feedback { reference, .. } | Self::StateFeedback { reference, .. } => reference.as_ref(),
        }
    }

    /// Checks its function of time for a run: see [`Program::check`]. The gain and the observer are checked by the
    /// simulation.
    ///
    /// # Errors
    /// Those of [`Program::check`].
    pub fn check(&self, inputs: usize, start: f64, end: f64) -> Result<(), SignalError> {
        self.program().map_or(Ok(()), |program| program.check(inputs, start, end))
    }

    /// As [`Program::breakpoints`]; of a law its jumps.
    pub fn breakpoints(&self, start: f64, end: f64) -> Vec<f64> {
        match self {
            Self::Law { jumps, .. } => jumps.iter().copied().filter(|t| (start..end).contains(t)).collect(),
            _ => self.program().map_or_else(Vec::new, |program| program.breakpoints(start, end)),
        }
    }
}
