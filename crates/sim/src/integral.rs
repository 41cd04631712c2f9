//! Integrals along a run, as extra states of the integrated equation.
//!
//! A quadrature of samples is as good as the samples are dense; an extra state `q' = f(view)`, `q(0) = 0` is as good as
//! the trajectory, and the step size takes it into account.

use std::fmt;
use std::sync::Arc;

use nalgebra::DMatrix;

use crate::error::{SimError, check_finite};
use crate::view::View;

/// What is integrated.
#[derive(Clone, Debug)]
pub struct Integrand<'a>(Kind<'a>);

#[derive(Clone)]
enum Kind<'a> {
    SquaredError { observer: String, component: Option<usize> },
    QuadraticCost { q: DMatrix<f64>, r: DMatrix<f64> },
    Custom(Arc<dyn Fn(&View<'_>) -> f64 + Send + Sync + 'a>),
}

impl fmt::Debug for Kind<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SquaredError { observer, component } => {
                f.debug_struct("SquaredError").field("observer", observer).field("component", component).finish()
            }
            Self::QuadraticCost { q, r } => f.debug_struct("QuadraticCost").field("q", q).field("r", r).finish(),
            Self::Custom(_) => write!(f, "Custom"),
        }
    }
}

impl<'a> Integrand<'a> {
    /// `|e|^2` of the observer of that name: the integral is J of the cubic-observer paper's Example 2.
    pub fn squared_error(observer: &str) -> Self {
        Self(Kind::SquaredError { observer: observer.to_owned(), component: None })
    }

    /// `e_i^2` of the observer of that name, i from 0.
    pub fn squared_error_of(observer: &str, component: usize) -> Self {
        Self(Kind::SquaredError { observer: observer.to_owned(), component: Some(component) })
    }

    /// `x'Qx + u'Ru`, the cost of the linear-quadratic regulator; Q is n x n, R m x m.
    pub fn quadratic_cost(q: DMatrix<f64>, r: DMatrix<f64>) -> Self {
        Self(Kind::QuadraticCost { q, r })
    }

    /// Any function of what is known at an instant.
    pub fn custom(f: impl Fn(&View<'_>) -> f64 + Send + Sync + 'a) -> Self {
        Self(Kind::Custom(Arc::new(f)))
    }

    pub(crate) fn check(&self, states: usize, inputs: usize, estimates: &[(String, usize)]) -> Result<(), SimError> {
        match &self.0 {
            Kind::Custom(_) => Ok(()),
            Kind::QuadraticCost { q, r } => {
                for (what, matrix, size) in [("the weight Q", q, states), ("the weight R", r, inputs)] {
                    check_finite(what, matrix.as_slice())?;
                    for found in [matrix.nrows(), matrix.ncols()] {
                        if found != size {
                            return Err(SimError::Length { what: what.to_owned(), expected: size, found });
                        }
                    }
                }
                Ok(())
            }
            Kind::SquaredError { observer, component } => {
                let Some((_, count)) = estimates.iter().find(|(name, _)| name == observer) else {
                    return Err(SimError::UnknownName { name: observer.clone() });
                };
                match component {
                    Some(index) if index >= count => {
                        Err(SimError::Index { what: "component of the error", index: *index, count: *count })
                    }
                    _ => Ok(()),
                }
            }
        }
    }

    pub(crate) fn value(&self, view: &View<'_>) -> f64 {
        match &self.0 {
            Kind::Custom(f) => f(view),
            Kind::QuadraticCost { q, r } => quadratic_form(q, view.x) + quadratic_form(r, view.u),
            Kind::SquaredError { observer, component } => {
                view.error(observer).map_or(f64::NAN, |error| match component {
                    Some(index) => error[*index].powi(2),
                    None => error.iter().map(|entry| entry * entry).sum(),
                })
            }
        }
    }
}

/// `v'Mv`.
pub(crate) fn quadratic_form(m: &DMatrix<f64>, v: &[f64]) -> f64 {
    let row = |i: usize| v.iter().enumerate().map(|(j, entry)| m[(i, j)] * entry).sum::<f64>();
    v.iter().enumerate().map(|(i, entry)| entry * row(i)).sum()
}
