//! The regression of a PEBO or a [KKL+PEB]O as expressions: `d s(y)/dt = g + m theta` and
//! `phi(x) = xi + missing(theta)`; the estimators of theta.

use luenberger_design::Region;
use luenberger_expression::Expression;
use luenberger_observers::estimator::ParameterEstimator;
use luenberger_observers::estimator::drem::{Drem, Kreisselmeier, LtiFilters};
use luenberger_observers::estimator::gradient::Gradient;
use luenberger_observers::kkl::KklMap;
use luenberger_observers::{FilterMemory, ObserverDimensions, ObserverError, Regression};
use nalgebra::{DMatrix, DVector, Dyn, RealField, convert};

use super::kkl::KklMaps;

/// The maps of a [KKL+PEB]O: phi, Lambda with rows of zeros, B and phi^L, and the regression for what these rows leave.
///
/// s, g and m are evaluated with xi and (u, y); the missing part with theta.
#[derive(Debug, Clone, PartialEq)]
pub struct RegressionMaps {
    /// phi, Lambda, B and phi^L.
    pub kkl: KklMaps,
    /// s(t, y), r expressions.
    pub signal: Vec<Expression>,
    /// g(t, xi, u, y), r expressions.
    pub known: Vec<Expression>,
    /// m(t, xi, u, y), r x q, row by row.
    pub regressor: Vec<Expression>,
    /// What is missing in xi as a function of theta, n_z expressions.
    pub missing: Vec<Expression>,
    /// q.
    pub parameters: usize,
    /// The least value of each parameter, where there is one.
    pub lowest: Option<Vec<f64>>,
    /// The entries of xi that are only integrated, from 0.
    pub open: Vec<usize>,
    /// The leakage of these entries at run time, `xi' = B - leakage xi`; 0 for pure integration.
    pub leakage: f64,
}

impl RegressionMaps {
    /// What a reset leaves of the filters: theta stands in the rows of zeros as it is, and m does not read them.
    pub(crate) fn memory(&self) -> FilterMemory {
        let is_plain = |row: &Expression| {
            let text = row.text().trim();
            text.parse::<f64>() == Ok(0.0) || (1..=self.parameters).any(|k| text == format!("theta{k}"))
        };
        let reads = |entry: &Expression| self.open.iter().any(|k| entry.depends_on_state(*k));
        if self.missing.iter().all(is_plain) && !self.regressor.iter().any(reads) {
            FilterMemory::Transformed
        } else {
            FilterMemory::Restarted
        }
    }

    /// The missing part of xi.
    pub(crate) fn completion<T: RealField + Copy>(&self, theta: &[T]) -> DVector<T> {
        KklMaps::column(&self.missing, T::zero(), theta, &[])
    }
}

impl<T: RealField + Copy> KklMap<T> for RegressionMaps {
    type Xi = Dyn;
    type Inputs = Dyn;
    type Outputs = Dyn;
    type Estimate = Dyn;

    fn dimensions(&self) -> ObserverDimensions {
        KklMap::<T>::dimensions(&self.kkl)
    }

    fn lambda(&self, t: T, u: &DVector<T>, y: &DVector<T>) -> DMatrix<T> {
        let mut lambda = self.kkl.lambda(t, u, y);
        for &i in self.open.iter().filter(|_| self.leakage > 0.0) {
            lambda[(i, i)] -= convert(self.leakage);
        }
        lambda
    }

    fn injection(&self, t: T, xi: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.kkl.injection(t, xi, u, y)
    }

    fn left_inverse(&self, t: T, xi: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.kkl.left_inverse(t, xi, y)
    }

    fn image(&self, t: T, xhat: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.kkl.image(t, xhat, y)
    }
}

impl<T: RealField + Copy> Regression<T> for RegressionMaps {
    type Rows = Dyn;
    type Parameters = Dyn;

    fn rows_and_parameters(&self) -> (usize, usize) {
        (self.signal.len(), self.parameters)
    }

    fn signal(&self, t: T, y: &DVector<T>) -> DVector<T> {
        KklMaps::column(&self.signal, t, &[], &self.kkl.known(None, y))
    }

    fn known(&self, t: T, xi: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        KklMaps::column(&self.known, t, xi.as_slice(), &self.kkl.known(Some(u), y))
    }

    fn regressor(&self, t: T, xi: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DMatrix<T> {
        let (q, known) = (self.parameters, self.kkl.known(Some(u), y));
        let entry = |i: usize, j: usize| self.regressor[i * q + j].evaluate(t, xi.as_slice(), &known);
        DMatrix::from_fn(self.signal.len(), q, entry)
    }

    fn missing(&self, theta: &DVector<T>) -> DVector<T> {
        self.completion(theta.as_slice())
    }

    fn is_open(&self, entry: usize) -> bool {
        self.open.contains(&entry)
    }

    fn lower_bound(&self, parameter: usize) -> Option<T> {
        self.lowest.as_ref().map(|lowest| convert(lowest[parameter]))
    }
}

/// The estimator of theta.
#[derive(Debug, Clone, PartialEq)]
pub enum Estimator<T: RealField + Copy = f64> {
    /// The gradient estimator.
    Gradient(Gradient<T, Dyn>),
    /// DREM with Kreisselmeier's extension.
    Kreisselmeier(Drem<T, Dyn, Kreisselmeier<T>>),
    /// DREM with stable filters.
    Filters(Drem<T, Dyn, LtiFilters<T, Dyn>>),
}

/// The same expression for each estimator.
macro_rules! each {
    ($estimator:expr, $one:ident => $call:expr) => {
        match $estimator {
            Estimator::Gradient($one) => $call,
            Estimator::Kreisselmeier($one) => $call,
            Estimator::Filters($one) => $call,
        }
    };
}

impl<T: RealField + Copy> ParameterEstimator<T, Dyn, Dyn> for Estimator<T> {
    type Length = Dyn;

    fn state_len(&self, rows: usize) -> usize {
        each!(self, one => ParameterEstimator::<T, Dyn, Dyn>::state_len(one, rows))
    }

    fn parameters(&self) -> usize {
        each!(self, one => ParameterEstimator::<T, Dyn, Dyn>::parameters(one))
    }

    fn rate(&self, state: &[T], y: &DVector<T>, m: &DMatrix<T>, rate: &mut [T]) {
        each!(self, one => one.rate(state, y, m, rate));
    }

    fn excitation(&self, state: &[T], m: &DMatrix<T>) -> Option<T> {
        each!(self, one => one.excitation(state, m))
    }

    fn shift(&self, state: &mut [T], delta: &DVector<T>) {
        each!(self, one => ParameterEstimator::<T, Dyn, Dyn>::shift(one, state, delta));
    }
}

impl Estimator {
    /// The gradient estimator with this gain, q x q.
    ///
    /// # Errors
    /// Those of [`Gradient::new`].
    pub fn gradient(gain: DMatrix<f64>) -> Result<Self, ObserverError> {
        Gradient::new(gain).map(Self::Gradient)
    }

    /// DREM with these gains and the extension that forgets at the rate `a`.
    ///
    /// # Errors
    /// Those of [`Drem::new`] and [`Kreisselmeier::new`].
    pub fn kreisselmeier(gain: &[f64], a: f64) -> Result<Self, ObserverError> {
        Drem::new(DVector::from_column_slice(gain), Kreisselmeier::new(a)?).map(Self::Kreisselmeier)
    }

    /// DREM with these gains and filters with the poles `-beta`.
    ///
    /// # Errors
    /// Those of [`Drem::new`] and [`LtiFilters::new`].
    pub fn filters(gain: &[f64], beta: &[f64]) -> Result<Self, ObserverError> {
        let filters = LtiFilters::new(DVector::from_column_slice(beta))?;
        Drem::new(DVector::from_column_slice(gain), filters).map(Self::Filters)
    }

    /// The same over another scalar.
    ///
    /// # Errors
    /// Those of the constructors, which are not expected for an estimator that was made.
    pub(crate) fn cast<T: RealField + Copy>(&self) -> Result<Estimator<T>, ObserverError> {
        let column = |values: &DVector<f64>| values.map(convert::<f64, T>);
        Ok(match self {
            Self::Gradient(gradient) => Estimator::Gradient(Gradient::new(gradient.gain().map(convert))?),
            Self::Kreisselmeier(drem) => {
                let extension = Kreisselmeier::new(convert(drem.extension().forgetting_rate()))?;
                Estimator::Kreisselmeier(Drem::new(column(drem.gain()), extension)?)
            }
            Self::Filters(drem) => {
                let extension = LtiFilters::new(column(drem.extension().poles()))?;
                Estimator::Filters(Drem::new(column(drem.gain()), extension)?)
            }
        })
    }

    /// As a phrase.
    pub(crate) fn words(&self) -> &'static str {
        match self {
            Self::Gradient(_) => "gradient estimator",
            Self::Kreisselmeier(_) => "DREM with Kreisselmeier's extension",
            Self::Filters(_) => "DREM with stable filters",
        }
    }
}

/// When xi takes over theta_hat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResetSpec {
    /// From one reset to the next.
    pub period: f64,
    /// A reset is left out unless a row of zeros of xi is larger than this.
    pub above: Option<f64>,
}

/// A PEBO or a [KKL+PEB]O.
#[derive(Debug, Clone, PartialEq)]
pub struct PebSpec {
    /// The maps.
    pub maps: RegressionMaps,
    /// The region of states, inputs and time over which they are checked.
    pub region: Region,
    /// The region of theta over which the regression is checked.
    pub theta: Vec<(f64, f64)>,
    /// The poles of the filters are at -alpha.
    pub alpha: f64,
    /// The estimator.
    pub estimator: Estimator,
    /// theta_hat(0), the same for all parameters.
    pub start: f64,
    /// When xi takes over theta_hat.
    pub reset: Option<ResetSpec>,
    /// Length of the windows in which the run of the study has to excite the regression; none for the whole run.
    pub window: Option<f64>,
}
