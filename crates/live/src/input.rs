//! The input of an experiment: a function of time, feedback, or a law with the true state.

use luenberger_expression::{Expression, Scope};
use luenberger_sim::{SampleInterpolation, Samples, Signal};

use crate::experiment::{Experiment, FeedbackSignal};
use crate::plants::{self, Result, text};
use crate::rows::matrix;

/// The inputs as a function of time, or with the true state.
pub(crate) enum Inputs {
    Zero,
    Expressions(Vec<Expression>),
    Table(Samples),
    Law(Vec<Expression>),
}

impl Inputs {
    pub(crate) fn new(experiment: &Experiment) -> Result<Self> {
        let as_many = |signals: usize| {
            let inputs = experiment.plant.inputs();
            if signals == inputs { Ok(()) } else { Err(format!("{signals} signals for {inputs} inputs")) }
        };
        if let Some(table) = &experiment.table {
            let between = if table.line { SampleInterpolation::Linear } else { SampleInterpolation::ZeroOrderHold };
            let samples = Samples::new(table.t.clone(), matrix(&table.rows), between).map_err(text)?;
            return as_many(samples.values().ncols()).map(|()| Self::Table(samples));
        }
        if let Some(law) = &experiment.law {
            let rows = plants::law(experiment, &law.rows)?;
            return as_many(rows.len()).map(|()| Self::Law(rows));
        }
        let scope = Scope::time().with(&experiment.parameters).map_err(text)?;
        let parsed = experiment.input.iter().map(|row| Expression::parse(row, &scope));
        let rows: Vec<Expression> = parsed.collect::<core::result::Result<_, _>>().map_err(text)?;
        if rows.is_empty() {
            return Ok(Self::Zero);
        }
        as_many(rows.len()).map(|()| Self::Expressions(rows))
    }

    /// Times at which it jumps or has a kink.
    pub(crate) fn breakpoints(&self, experiment: &Experiment) -> Vec<f64> {
        let times = match (self, &experiment.law) {
            (Self::Table(samples), _) => samples.times(),
            (Self::Law(_), Some(law)) => &law.jumps,
            _ => &[],
        };
        times.iter().copied().filter(|t| (0.0..experiment.duration).contains(t)).collect()
    }

    fn at(&self, t: f64, x: &[f64], u: &mut [f64]) {
        match self {
            Self::Zero => u.fill(0.0),
            Self::Expressions(rows) | Self::Law(rows) => {
                for (u, row) in u.iter_mut().zip(rows) {
                    *u = row.evaluate(t, x, &[]);
                }
            }
            Self::Table(samples) => samples.at(t, u),
        }
    }

    /// The input of the run of the observer `name`, with the feedback if there is one.
    pub(crate) fn signal(self, experiment: &Experiment, name: &str) -> Signal<'static> {
        let is_zero = matches!(self, Self::Zero);
        let Some(feedback) = &experiment.feedback else {
            return match self {
                Self::Zero => Signal::zero(),
                Self::Law(_) => Signal::law(move |view, u| self.at(view.t, view.x, u)),
                _ => Signal::function(move |t, u| self.at(t, &[], u)),
            };
        };
        let gain = matrix(&feedback.gain);
        let mut signal = match &feedback.of {
            FeedbackSignal::EachEstimate => Signal::feedback(name, gain),
            FeedbackSignal::Estimate(observer) => Signal::feedback(observer, gain),
            FeedbackSignal::State => Signal::state_feedback(gain),
        };
        if !is_zero {
            signal = signal.plus(move |t, r| self.at(t, &[], r));
        }
        if !feedback.shift.is_empty() {
            let shift = feedback.shift.clone();
            signal = signal.plus(move |_, u| u.copy_from_slice(&shift));
        }
        signal
    }
}
