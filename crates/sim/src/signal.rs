//! Inputs: functions of time, or feedback of estimates, outputs or states.

use std::fmt;
use std::sync::Arc;

use nalgebra::DMatrix;

use crate::error::{SimError, check_finite};
use crate::view::View;

/// A law that reads the view and writes the input.
type Law<'a> = Arc<dyn Fn(&View<'_>, &mut [f64]) + Send + Sync + 'a>;

/// A function of time that writes the input.
type Function<'a> = Arc<dyn Fn(f64, &mut [f64]) + Send + Sync + 'a>;

/// The input of a plant.
#[derive(Clone, Debug)]
pub struct Signal<'a>(Kind<'a>);

#[derive(Clone)]
enum Kind<'a> {
    Zero,
    Constant(Vec<f64>),
    Function(Function<'a>),
    Feedback {
        observer: String,
        gain: DMatrix<f64>,
    },
    StateFeedback {
        gain: DMatrix<f64>,
    },
    Law(Law<'a>),
    /// The sum of a signal and a function of time.
    Plus(Box<Kind<'a>>, Function<'a>),
}

impl<'a> Signal<'a> {
    /// `u = 0`, for any number of inputs.
    pub fn zero() -> Self {
        Self(Kind::Zero)
    }

    /// `u = value` at all times.
    pub fn constant(value: &[f64]) -> Self {
        Self(Kind::Constant(value.to_vec()))
    }

    /// `u_i = amplitude_i sin(omega t)`.
    pub fn sine(amplitude: &[f64], omega: f64) -> Self {
        let amplitude = amplitude.to_vec();
        Self::function(move |t, u| {
            for (u, amplitude) in u.iter_mut().zip(&amplitude) {
                *u = amplitude * nalgebra::ComplexField::sin(omega * t);
            }
        })
    }

    /// One input as a function of time: `Signal::scalar(f64::sin)`. All inputs of the plant get the same
    /// value.
    pub fn scalar(f: impl Fn(f64) -> f64 + Send + Sync + 'a) -> Self {
        Self::function(move |t, u| u.fill(f(t)))
    }

    /// `f(t, u)` writes the input at time t into `u`. Pass the times of its jumps to
    /// [`breakpoints`](crate::Scenario::breakpoints).
    pub fn function(f: impl Fn(f64, &mut [f64]) + Send + Sync + 'a) -> Self {
        Self(Kind::Function(Arc::new(f)))
    }

    /// `u = -K xhat` with the estimate of the observer of that name (24); K is m x n.
    pub fn feedback(observer: &str, gain: DMatrix<f64>) -> Self {
        Self(Kind::Feedback { observer: observer.to_owned(), gain })
    }

    /// `u = -K x` with the true state, for comparison with the feedback of an estimate; K is m x n.
    pub fn state_feedback(gain: DMatrix<f64>) -> Self {
        Self(Kind::StateFeedback { gain })
    }

    /// Any law: `law(view, u)` reads time, state, output and estimates from the view and writes the input into `u`. The
    /// view's own input is zero, and estimates that use the input are refused ([`SimError::AlgebraicLoop`]).
    pub fn law(law: impl Fn(&View<'_>, &mut [f64]) + Send + Sync + 'a) -> Self {
        Self(Kind::Law(Arc::new(law)))
    }

    /// This signal and a reference: `reference(t, r)` writes r, which is added, as in `u = r - K xhat`.
    ///
    /// ```
    /// use luenberger_sim::{Scenario, Signal};
    /// use nalgebra::dmatrix;
    /// // x1'' = u is led to x1 = 2 by u = 2 k1 - k1 x1 - k2 x2.
    /// let u = Signal::state_feedback(dmatrix![4.0, 4.0]).plus(|_, r| r.fill(8.0));
    /// let trajectory = Scenario::new(luenberger_plants::double_integrator()).input(u).until(20.0, 2).run()?;
    /// assert!((trajectory.x[(1, 0)] - 2.0).abs() < 1e-9);
    /// # Ok::<(), luenberger_sim::SimError>(())
    /// ```
    #[must_use]
    pub fn plus(self, reference: impl Fn(f64, &mut [f64]) + Send + Sync + 'a) -> Self {
        Self(Kind::Plus(Box::new(self.0), Arc::new(reference)))
    }

    /// Whether it is the same at all times.
    pub(crate) fn is_constant(&self) -> bool {
        matches!(self.0, Kind::Zero | Kind::Constant(_))
    }

    /// Whether estimates are needed to evaluate it.
    pub(crate) fn reads_estimates(&self) -> bool {
        self.0.reads_estimates()
    }

    /// Checks lengths, names and entries against a plant with `states`, `inputs` and the named observers' estimates.
    pub(crate) fn check(&self, states: usize, inputs: usize, estimates: &[(String, usize)]) -> Result<(), SimError> {
        self.0.check(states, inputs, estimates)
    }

    /// Writes the input.
    pub(crate) fn write(&self, view: &View<'_>, u: &mut [f64]) {
        self.0.write(view, u);
    }
}

impl fmt::Debug for Kind<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Zero => write!(f, "Zero"),
            Self::Constant(value) => f.debug_tuple("Constant").field(value).finish(),
            Self::Function(_) => write!(f, "Function"),
            Self::Feedback { observer, gain } => {
                f.debug_struct("Feedback").field("observer", observer).field("gain", gain).finish()
            }
            Self::StateFeedback { gain } => f.debug_struct("StateFeedback").field("gain", gain).finish(),
            Self::Law(_) => write!(f, "Law"),
            Self::Plus(signal, _) => f.debug_tuple("Plus").field(signal).finish_non_exhaustive(),
        }
    }
}

impl Kind<'_> {
    fn reads_estimates(&self) -> bool {
        match self {
            Self::Feedback { .. } | Self::Law(_) => true,
            Self::Plus(signal, _) => signal.reads_estimates(),
            _ => false,
        }
    }

    fn check(&self, states: usize, inputs: usize, estimates: &[(String, usize)]) -> Result<(), SimError> {
        let fits = |gain: &DMatrix<f64>, columns: usize| {
            check_finite("the feedback gain K", gain.as_slice())?;
            length("rows of the feedback gain K", inputs, gain.nrows())?;
            length("columns of the feedback gain K", columns, gain.ncols())
        };
        match self {
            Self::Zero | Self::Function(_) | Self::Law(_) => Ok(()),
            Self::Plus(signal, _) => signal.check(states, inputs, estimates),
            Self::Constant(value) => {
                check_finite("the constant input", value)?;
                length("the constant input", inputs, value.len())
            }
            Self::StateFeedback { gain } => fits(gain, states),
            Self::Feedback { observer, gain } => match estimates.iter().find(|(name, _)| name == observer) {
                Some((_, columns)) => fits(gain, *columns),
                None => Err(SimError::UnknownName { name: observer.clone() }),
            },
        }
    }

    fn write(&self, view: &View<'_>, u: &mut [f64]) {
        match self {
            Self::Zero => u.fill(0.0),
            Self::Constant(value) => u.copy_from_slice(value),
            Self::Function(f) => f(view.t, u),
            Self::StateFeedback { gain } => feed_back(gain, view.x, u),
            Self::Feedback { observer, gain } => feed_back(gain, view.estimate(observer).unwrap_or(&[]), u),
            Self::Law(law) => law(view, u),
            Self::Plus(signal, reference) => {
                let mut r = vec![0.0; u.len()];
                reference(view.t, &mut r);
                signal.write(view, u);
                for (u, r) in u.iter_mut().zip(&r) {
                    *u += r;
                }
            }
        }
    }
}

/// `u = -K x`.
fn feed_back(gain: &DMatrix<f64>, x: &[f64], u: &mut [f64]) {
    for (i, u) in u.iter_mut().enumerate() {
        *u = -x.iter().enumerate().map(|(j, x)| gain[(i, j)] * x).sum::<f64>();
    }
}

fn length(what: &str, expected: usize, found: usize) -> Result<(), SimError> {
    if expected == found { Ok(()) } else { Err(SimError::Length { what: what.to_owned(), expected, found }) }
}
