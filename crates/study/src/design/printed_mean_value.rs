//! The mean-value-theorem observer as printed, eq. (3) of Ben Messaoud and Hajji, for comparison with the one
//! with output injection.

use luenberger_design::LeastSquares;
use luenberger_observers::mean_value::{Mean, MeanJacobian};
use luenberger_observers::{Beta, Integral, MeanValueObserver, ObserverError};
use nalgebra::{DVector, Dyn};

use super::explain::Misfit;
use super::{Designed, number, uncertified};
use crate::model::Model;
use crate::results::{DesignReport, Statement};
use crate::runnable::Runnable;
use crate::study::PrintedMean;

impl PrintedMean {
    fn words(self) -> &'static str {
        match self {
            Self::LeastSquares => "beta by bounded nonlinear least squares",
            Self::Root => "beta as the bracketed root of each row",
            Self::Integral => "the integral of the Jacobian",
        }
    }
}

/// The same expression for each mean.
macro_rules! each {
    ($mean:expr, $one:ident => $call:expr) => {
        match $mean {
            PrintedMean::LeastSquares => {
                let $one = LeastSquares::new();
                $call
            }
            PrintedMean::Root => {
                let $one = Beta;
                $call
            }
            PrintedMean::Integral => {
                let $one = Integral;
                $call
            }
        }
    };
}

type Column = DVector<f64>;

impl Mean<Model, f64, Dyn, Dyn, Dyn> for PrintedMean {
    fn mean(&self, plant: &Model, t: f64, xhat: &Column, u: &Column, e: &Column) -> MeanJacobian<f64, Dyn> {
        each!(self, one => Mean::<Model, f64, Dyn, Dyn, Dyn>::mean(&one, plant, t, xhat, u, e))
    }

    fn examine(&self, plant: &Model, t: f64, xhat: &Column, u: &Column, e: &Column) -> Result<(), ObserverError> {
        each!(self, one => Mean::<Model, f64, Dyn, Dyn, Dyn>::examine(&one, plant, t, xhat, u, e))
    }
}

/// The observer; nothing is proved of it.
pub(super) fn design(model: &Model, mean: PrintedMean, eta: f64, internal_error: &[f64]) -> Result<Designed, Misfit> {
    let start = DVector::from_column_slice(internal_error);
    let observer = MeanValueObserver::new(model.clone(), eta, mean, start)?;
    let report = DesignReport {
        statement: Statement::of(format!(
            "Eq. (3) as printed, with {}. The internal error e never grows, as eta > 1/2; x - xhat tends to 0 with it where e(0) = x(0) - xhat(0).",
            mean.words()
        )),
        numbers: vec![number("eta", eta)],
        ..uncertified(
            "the theorem as printed is false, the estimation error need not tend to 0 from another e(0); without `as_printed` the observer with output injection is designed",
        )
    };
    Ok(Designed::new(Runnable::PrintedMeanValue(Box::new(observer)), report, None))
}
