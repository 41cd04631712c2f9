//! Figures of merit of an observer's error.
//!
//! Settling has two meanings, and they differ as soon as the error swings through the band: [`settling_first`] is the
//! first time the error is within it (the footnote of the cubic-observer paper), [`settling_last`] the time from which
//! it stays there (what reproduces the paper's numbers). Integrals of the error are extra states of the run: see
//! [`Integrand`](crate::Integrand).

use nalgebra::DMatrix;

use crate::error::{SimError, check_finite};
use crate::events::{Extremum, Trace};
use crate::integral::quadratic_form;
use crate::trajectory::Trajectory;

/// The largest `|e|` of the whole run.
///
/// # Errors
/// None for the trace of a run; [`SimError::Outside`] for an empty one.
pub fn peak(error: &Trace<'_>) -> Result<Extremum, SimError> {
    error.largest_magnitude(error.span().0)
}

/// The largest `|e|` after the first change of sign: how far the estimate overshoots. `None` when the sign never
/// changes.
pub fn overshoot(error: &Trace<'_>) -> Option<Extremum> {
    error.largest_magnitude(error.first_sign_change()?).ok()
}

/// The first time with `|e| <= threshold`, in the unit of the error, which may be the start; `None` if there is none.
pub fn settling_first(error: &Trace<'_>, threshold: f64) -> Option<f64> {
    let start = error.span().0;
    if error.at(start).ok()?.abs() <= threshold {
        return Some(start);
    }
    // Whichever side the error comes from, it enters through the nearer edge.
    [threshold, -threshold]
        .into_iter()
        .filter_map(|level| error.first_crossing(level))
        .map(|crossing| crossing.time)
        .reduce(f64::min)
}

/// The last time with `|e| = threshold`, in the unit of the error, after which `|e|` stays below: the start if the
/// error never exceeds it, `None` if it does at the end.
pub fn settling_last(error: &Trace<'_>, threshold: f64) -> Option<f64> {
    if error.last().abs() > threshold {
        return None;
    }
    let last = [threshold, -threshold]
        .into_iter()
        .filter_map(|level| error.last_crossing(level))
        .map(|crossing| crossing.time);
    Some(last.reduce(f64::max).unwrap_or(error.span().0))
}

/// `V = e'Pe` of an observer at the requested times; P is square of the length of its estimate.
///
/// # Errors
/// [`SimError::UnknownName`], [`SimError::Length`], [`SimError::NotFinite`].
pub fn lyapunov(trajectory: &Trajectory, observer: &str, p: &DMatrix<f64>) -> Result<Vec<f64>, SimError> {
    let error = &trajectory.observer(observer)?.error;
    check_weight(p, error.ncols())?;
    Ok(error.row_iter().map(|e| quadratic_form(p, &e.iter().copied().collect::<Vec<_>>())).collect())
}

/// `V = e'Pe` of an observer as a function of time.
///
/// # Errors
/// As [`lyapunov`].
pub fn lyapunov_trace<'t>(trajectory: &'t Trajectory, observer: &str, p: &DMatrix<f64>) -> Result<Trace<'t>, SimError> {
    check_weight(p, trajectory.observer(observer)?.error.ncols())?;
    let (observer, p) = (observer.to_owned(), p.clone());
    Ok(trajectory.trace(move |view| view.error(&observer).map_or(f64::NAN, |e| quadratic_form(&p, e))))
}

fn check_weight(p: &DMatrix<f64>, expected: usize) -> Result<(), SimError> {
    check_finite("P", p.as_slice())?;
    for found in [p.nrows(), p.ncols()] {
        if found != expected {
            return Err(SimError::Length { what: "P".to_owned(), expected, found });
        }
    }
    Ok(())
}
