//! Integration of `x' = f(t, x)` with error control, dense output, and an error where the solution ends.
//!
//! Explicit: DOP853, order 8 (module `dop853`). Implicit: Radau IIA, order 5 (module `radau`). Automatic: explicit
//! until stiffness shows or half the allowed steps are spent, implicit from there.
//!
//! Both are this crate's own. Of the crates that offer them, differential-equations 0.7.0 exchanges s and 1 - s in the
//! dense output of DOP853 (errors of 1e-7 where the steps are good to 1e-11), keeps a stale factorisation in Radau5
//! when the step changes, and tightens or loosens a shared tolerance once per component; ode_solvers 0.6.2 fails at the
//! end of dense output.
//!
//! A large initial error of a cubic observer looks stiff (its rate grows with the square of the error) and mostly is
//! not: the rate falls as 1/t, and an explicit method follows it with steps that grow in proportion to t.

use luenberger_clock::{Instant, is_stopped};
use luenberger_wording::setters;
use std::cell::RefCell;

use crate::dense::{Dense, NODE, NODES};
use crate::dop853::Dop853;
use crate::error::{SimError, check_finite, check_positive};
use crate::radau::Radau;
use crate::step::{Accepted, Attempt, Interpolant, Tolerance};

/// The method that integrates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// Explicit until stiffness shows, then implicit.
    #[default]
    Auto,
    /// DOP853, order 8: the best for smooth problems and tight tolerances.
    Explicit,
    /// Radau IIA, order 5: for stiff plants and stiff starts.
    Implicit,
}

/// How a solution is integrated.
///
/// ```
/// use luenberger_sim::{Integrator, Settings};
/// let settings = Settings::default().integrator(Integrator::Implicit).rtol(1e-9).max_step(0.1);
/// assert_eq!(settings, Settings { integrator: Integrator::Implicit, rtol: 1e-9, max_step: 0.1, ..Settings::default() });
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The method.
    pub integrator: Integrator,
    /// Relative tolerance per step and component (default 1e-11).
    pub rtol: f64,
    /// Absolute tolerance per step and component (default 1e-12).
    pub atol: f64,
    /// Hard cap on attempted steps (default a million).
    pub max_steps: usize,
    /// Longest step (default infinite).
    pub max_step: f64,
    /// Time limit: no step starts after this instant (default none), [`SimError::TimeLimit`]. Without a limit the
    /// result does not depend on the machine's speed.
    pub end: Option<Instant>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            integrator: Integrator::Auto,
            rtol: 1e-11,
            atol: 1e-12,
            max_steps: 1_000_000,
            max_step: f64::INFINITY,
            end: None,
        }
    }
}

impl Settings {
    setters! { integrator: Integrator, rtol: f64, atol: f64, max_steps: usize, max_step: f64, end: Instant }
}

impl Settings {
    /// Checks that the numbers make sense; a relative tolerance below 1e-14 cannot be kept in double precision.
    pub(crate) fn check(&self) -> Result<(), SimError> {
        check_positive("rtol", self.rtol)?;
        check_positive("atol", self.atol)?;
        if self.max_step.is_nan() || self.max_step <= 0.0 {
            return Err(SimError::NotPositive { what: "max_step", value: self.max_step });
        }
        Ok(())
    }

    /// Ends a run at its time limit, and where its thread is [stopped](luenberger_clock::stoppable).
    pub(crate) fn check_time(&self, t: f64) -> Result<(), SimError> {
        match self.end {
            Some(end) if Instant::now() >= end => Err(SimError::TimeLimit { time: t }),
            _ if is_stopped() => Err(SimError::TimeLimit { time: t }),
            _ => Ok(()),
        }
    }

    pub(crate) fn tolerance(&self) -> Tolerance {
        Tolerance { rtol: self.rtol.max(1e-14), atol: self.atol }
    }
}

/// Integrates `x' = f(t, x)` from `x(start) = x0` to `end > start`. `f(t, x, slope)` writes the derivative into
/// `slope`.
///
/// ```
/// use luenberger_sim::{Settings, solve};
/// let circle = solve(|_, x, slope| (slope[0], slope[1]) = (x[1], -x[0]), 0.0, 10.0, &[0.0, 1.0], &Settings::default())?;
/// assert!((circle.at(7.3)?[0] - 7.3f64.sin()).abs() < 1e-9);
/// # Ok::<(), luenberger_sim::SimError>(())
/// ```
/// # Errors
/// [`SimError::TimeSpan`], [`SimError::NotFinite`] and [`SimError::NotPositive`] for bad input; [`SimError::BlowUp`],
/// [`SimError::Singular`], [`SimError::StepSize`], [`SimError::TooManySteps`] or [`SimError::TimeLimit`] where the
/// solution is not continued.
pub fn solve(
    f: impl Fn(f64, &[f64], &mut [f64]),
    start: f64,
    end: f64,
    x0: &[f64],
    settings: &Settings,
) -> Result<Dense, SimError> {
    settings.check()?;
    if !(start.is_finite() && end.is_finite() && end > start) {
        return Err(SimError::TimeSpan { start, end });
    }
    check_finite("the initial state", x0)?;
    let mut dense = Dense::new(x0.len());
    let mut x = x0.to_vec();
    let mut values = vec![0.0; NODES * x.len()];
    Stepper::new(*settings).advance(&f, start, end, &mut x, &mut |step| {
        for (node, value) in NODE.iter().zip(values.chunks_exact_mut(x0.len().max(1))) {
            step.at(step.start + node * (step.end - step.start), value);
        }
        dense.push(step.start, step.end, &[], &values);
        Ok(())
    })?;
    Ok(dense)
}

enum Method {
    Explicit(Box<Dop853>),
    Implicit(Box<Radau>),
}

impl Method {
    fn t(&self) -> f64 {
        match self {
            Self::Explicit(method) => method.t(),
            Self::Implicit(method) => method.t(),
        }
    }

    fn y(&self) -> &[f64] {
        match self {
            Self::Explicit(method) => method.y(),
            Self::Implicit(method) => method.y(),
        }
    }

    fn h(&self) -> f64 {
        match self {
            Self::Explicit(method) => method.h(),
            Self::Implicit(method) => method.h(),
        }
    }

    fn set_h(&mut self, h: f64) {
        match self {
            Self::Explicit(method) => method.set_h(h),
            Self::Implicit(method) => method.set_h(h),
        }
    }

    fn attempt(&mut self, f: &impl Fn(f64, &[f64], &mut [f64]), tolerance: Tolerance) -> Attempt {
        match self {
            Self::Explicit(method) => method.attempt(f, tolerance),
            Self::Implicit(method) => method.attempt(f, tolerance),
        }
    }

    /// Whether the explicit method suspects stiffness.
    fn stiff(&self) -> bool {
        matches!(self, Self::Explicit(method) if method.stiff())
    }
}

impl Interpolant for Method {
    fn interpolate(&self, t: f64, value: &mut [f64]) {
        match self {
            Self::Explicit(method) => method.interpolate(t, value),
            Self::Implicit(method) => method.interpolate(t, value),
        }
    }
}

/// Integration that goes on over several intervals, between which the right-hand side or the state may jump.
pub(crate) struct Stepper {
    settings: Settings,
    /// Step size to go on with.
    h: Option<f64>,
    implicit: bool,
    steps: usize,
    /// The largest entry and the largest derivative at the start of the first interval.
    first: Option<(f64, f64)>,
    /// The explicit method of the last interval, whose memory the next one works in.
    explicit: Option<Box<Dop853>>,
    slope: Vec<f64>,
}

impl Stepper {
    pub(crate) fn new(settings: Settings) -> Self {
        let implicit = settings.integrator == Integrator::Implicit;
        Self { settings, h: None, implicit, steps: 0, first: None, explicit: None, slope: Vec::new() }
    }

    /// Steps attempted so far.
    pub(crate) fn steps(&self) -> usize {
        self.steps
    }

    /// Counts steps that were not integrated; whether there may be so many.
    pub(crate) fn counts(&mut self, steps: usize) -> bool {
        self.steps = self.steps.saturating_add(steps);
        self.steps <= self.settings.max_steps
    }

    /// From `y` at `start` to `end`, leaving the result in `y`; `on_step` sees every accepted step.
    pub(crate) fn advance(
        &mut self,
        f: &impl Fn(f64, &[f64], &mut [f64]),
        start: f64,
        end: f64,
        y: &mut [f64],
        on_step: &mut impl FnMut(&Accepted<'_>) -> Result<(), SimError>,
    ) -> Result<(), SimError> {
        let tolerance = self.settings.tolerance();
        // The last state since the last accepted step at which the right-hand side was not finite.
        let undefined = RefCell::new(None);
        let watched = |t: f64, y: &[f64], slope: &mut [f64]| {
            f(t, y, slope);
            if let Some(index) = slope.iter().position(|entry| !entry.is_finite())
                && y.iter().all(|entry| entry.is_finite())
            {
                let (value, state) = (slope[index], y.to_vec());
                undefined.replace(Some(SimError::NotDefined { time: t, index, value, state }));
            }
        };
        let f = &watched;
        let mut slope = std::mem::take(&mut self.slope);
        slope.resize(y.len(), 0.0);
        f(start, y, &mut slope);
        if let Some(error) = undefined.take() {
            return Err(error);
        }
        check_finite("the right-hand side at the start of an interval", &slope)?;
        let first = *self.first.get_or_insert_with(|| (largest(y), largest(&slope)));
        let h = self.h.unwrap_or_else(|| first_step(y, &slope, tolerance)).min(self.settings.max_step).min(end - start);
        let mut method = self.begin(start, y, &slope, h);
        loop {
            let t = method.t();
            let rest = end - t;
            let proposed = method.h().min(self.settings.max_step);
            // A last step may stretch a little, lest a sliver remain.
            let last = proposed * 1.001 >= rest;
            let h = if last { rest } else { proposed };
            method.set_h(h);
            if self.steps >= self.settings.max_steps {
                return Err(SimError::TooManySteps { time: t, step: h, steps: self.steps });
            }
            self.settings.check_time(t)?;
            self.steps += 1;
            if !(last || h > 8.0 * f64::EPSILON * t.abs().max(f64::MIN_POSITIVE)) {
                let reached = undefined.take();
                return Err(match (standstill(f, t, method.y(), h, first), reached) {
                    (SimError::StepSize { .. }, Some(undefined)) => undefined,
                    (error, _) => error,
                });
            }
            match method.attempt(f, tolerance) {
                Attempt::Accepted => {
                    undefined.take();
                    self.h = Some(if last { method.h().max(proposed) } else { method.h() });
                    let norm = largest(method.y());
                    if norm > 1e100 || !method.y().iter().all(|entry| entry.is_finite()) {
                        return Err(SimError::BlowUp { time: t, norm });
                    }
                    let step_end = if last { end } else { method.t() };
                    on_step(&Accepted { start: t, end: step_end, solution: &method })?;
                    if last {
                        y.copy_from_slice(method.y());
                        self.slope = slope;
                        if let Method::Explicit(method) = method {
                            self.explicit = Some(method);
                        }
                        return Ok(());
                    }
                }
                Attempt::Rejected => {}
            }
            let spent = self.steps > self.settings.max_steps / 2;
            if self.settings.integrator == Integrator::Auto && !self.implicit && (spent || method.stiff()) {
                self.implicit = true;
                method = self.begin(method.t(), method.y(), &slope, method.h());
            }
        }
    }

    fn begin(&mut self, t: f64, y: &[f64], slope: &[f64], h: f64) -> Method {
        if self.implicit {
            return Method::Implicit(Box::new(Radau::new(t, y, h)));
        }
        Method::Explicit(match self.explicit.take() {
            Some(mut method) if method.y().len() == y.len() => {
                method.restart(t, y, slope, h);
                method
            }
            _ => Box::new(Dop853::new(t, y, slope, h)),
        })
    }
}

fn largest(y: &[f64]) -> f64 {
    y.iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()))
}

/// Growth of the largest entry over its size at the start, 1 at least, that counts as a blow-up. At the spacing of
/// floating-point numbers a solution of x' = x^p has grown by the factor 1e16^(1/(p - 1)), which is 1e4 for p = 5,
/// while the logarithm that a simple pole of the right-hand side integrates to has reached 40.
const GROWTH: f64 = 1e3;

/// A derivative is unbounded if it exceeds the largest one at the start, and the entries per unit of time, by this
/// factor; at x' = -1/x it is 1e8 at the spacing of floating-point numbers.
const STEEP: f64 = 1e6;

/// Why the step size vanished: the solution or its derivative runs off within a few steps, or the right-hand side is
/// rough.
fn standstill(f: &impl Fn(f64, &[f64], &mut [f64]), t: f64, y: &[f64], h: f64, (size, speed): (f64, f64)) -> SimError {
    let mut slopes = vec![0.0; y.len()];
    f(t, y, &mut slopes);
    let norm = largest(y);
    // At a finite-time blow-up |y|/|y'| is the time left, a few steps; at a kink it is the time scale of the plant.
    // Steps there have the size of the spacing of t, so a million of them is still nothing.
    let step = h.max(f64::EPSILON * t.abs()) * 1e6;
    let grows = y.iter().zip(&slopes).any(|(y, slope)| y.abs() >= norm && slope * y.signum() * step > norm);
    if norm > GROWTH * size.max(1.0) && grows || slopes.iter().any(|slope| !slope.is_finite()) && norm > 1e10 {
        return SimError::BlowUp { time: t, norm };
    }
    let steepest = y.iter().zip(&slopes).enumerate().max_by(|a, b| a.1.1.abs().total_cmp(&b.1.1.abs()));
    match steepest {
        Some((index, (&value, &slope))) if slope.abs() > STEEP * speed.max(norm) => {
            SimError::Singular { time: t, index, value, slope }
        }
        _ => SimError::StepSize { time: t, step: h },
    }
}

/// A first step so short that a step of Euler's changes nothing to speak of (Hairer, Norsett, Wanner I, section II.4).
pub(crate) fn first_step(y: &[f64], slope: &[f64], tolerance: Tolerance) -> f64 {
    let (mut size, mut speed) = (0.0f64, 0.0f64);
    for (entry, slope) in y.iter().zip(slope) {
        let scale = tolerance.atol + tolerance.rtol * entry.abs();
        size = size.max((entry / scale).abs());
        speed = speed.max((slope / scale).abs());
    }
    if size < 1e-5 || speed < 1e-5 { 1e-6 } else { 0.01 * size / speed }
}
