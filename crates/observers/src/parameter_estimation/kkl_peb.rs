//! [KKL+PEB] observers: part of the state by a stable linear extension, part by parameter estimation; eq. (15) of Yi,
//! Ortega and Zhang.
//!
//! ```text
//! xi'  = Lambda xi + B(y, u)                     Lambda = diag(Lambda_L, 0): the KKL part decays, the PEB part integrates
//! w'   = alpha (s(y) - w)                         w(0) = s(y(0))
//! f_g' = alpha (g - f_g),  f_m' = alpha (m - f_m)         from 0
//! Y = W[s] - F[g] = alpha (s - w) - f_g,  M = F[m] = f_m
//! zeta' : an estimator of theta in Y = M theta
//! xhat = phi^L(xi + missing(theta_hat), y)
//! ```
//!
//! The maps are those of a [`KklMap`] with a [`Regression`]; the estimator is a part. With Lambda = 0 this is a PEBO;
//! with nothing missing, a KKLO. The state is (xi, w, f_g, f_m by columns, zeta), and the first q entries of zeta are
//! theta_hat.
//!
//! **What holds.** The error of the KKL part obeys `e' = Lambda_L e`. If it is zero the regression is exact and
//! theta_hat obeys the theorem of its estimator. While it is not, Y is off by a decaying term, which an exponentially
//! convergent estimator turns into a decaying error.
//!
//! **Reset.** Integrators integrate every offset of y: xi drifts, and theta_hat drifts the other way. A [`Reset`] hands
//! theta_hat over to xi from time to time, `xi+ = xi + missing(theta_hat) - missing(theta_0)`, `theta_hat+ = theta_0`,
//! so that the estimate is continuous and what is missing is small again. With [`FilterMemory::Transformed`] the
//! filters move to the new coordinates; with [`FilterMemory::Restarted`] they begin again, and the regression is exact
//! from there.
//!
//! **A domain.** Where [`Regression::lower_bound`] bounds a parameter from below, theta_hat is projected: at the bound
//! it does not fall further, and the estimate uses no value below it. [`Diagnose`] reports a parameter that is at its
//! bound or about to reach it. An entry of the right-hand side that overflows (an exponential of xi, say) stands still
//! rather than become NaN, and is reported too.

use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, U1};

use super::estimator::{ParameterEstimator, finite_or_zero};
use super::filters::{Filter, positive};
use super::regression::{PebSize, Regression};
use crate::dense::{choose, larger};
use crate::diagnosis::{Diagnose, Diagnosis};
use crate::error::ObserverError;
use crate::kkl::{KklMap, KklSize};
use crate::observer::{Observer, ObserverDimensions};
use luenberger_plants::PlantError;

/// The observer with maps `K`, estimator `E` over the scalar `T`; see the [module](self).
///
/// Fields are read through methods, because the constructor has checked them.
#[derive(Clone, Debug, PartialEq)]
pub struct KklPebObserver<K, E, T> {
    map: K,
    estimator: E,
    filter: Filter<T>,
    /// theta_hat(0), the same for every parameter: xi(0) makes up for it.
    theta: T,
    wanted: Option<T>,
    reset: Option<Reset<T>>,
}

/// Periodic transfer of theta_hat to xi, and the treatment of the filters at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reset<T> {
    /// Period of the resets.
    pub period: T,
    /// Reset only if an entry of xi that is only integrated exceeds this magnitude; `None` for a reset after every
    /// period.
    pub above: Option<T>,
    /// Treatment of the filters and the estimator.
    pub memory: FilterMemory,
}

/// Treatment of the filters and the estimator at a reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterMemory {
    /// They move to the new coordinates, `F[g]+ = F[g] + F[m] delta` with `delta = theta_hat - theta_0`. For
    /// `missing` linear in theta and m independent of the entries of xi that are only integrated: there
    /// `g(xi + missing(delta)) = g(xi) + m delta`, and the estimate is that without resets at all times.
    Transformed,
    /// They begin again, as at the start: `w = s(y)`, the others 0. For any regression; past excitation is lost.
    Restarted,
}

impl<K, E, T: RealField + Copy> KklPebObserver<K, E, T> {
    /// The observer with these maps, this estimator, and filters with pole `-alpha`; theta_hat starts at 0.
    ///
    /// # Errors
    /// [`ObserverError::NotPositive`] for alpha, [`ObserverError::Matrix`] when the estimator has another number of
    /// parameters.
    pub fn new(map: K, estimator: E, alpha: T) -> Result<Self, ObserverError>
    where
        K: Regression<T>,
        E: ParameterEstimator<T, K::Rows, K::Parameters>,
        DefaultAllocator:
            KklSize<K::Xi, K::Inputs, K::Outputs, K::Estimate> + PebSize<K::Xi, K::Rows, K::Parameters, E::Length>,
    {
        let (_, q) = map.rows_and_parameters();
        if estimator.parameters() != q {
            let expected = (q, 1);
            let found = (estimator.parameters(), 1);
            return Err(PlantError::DimensionMismatch { what: "theta", expected, found }.into());
        }
        Ok(Self { map, estimator, filter: Filter::new(alpha)?, theta: T::zero(), wanted: None, reset: None })
    }

    /// The same with every entry of theta_hat(0) equal to `theta`.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for a number that is not finite.
    pub fn starting_at(self, theta: T) -> Result<Self, ObserverError> {
        if !theta.is_finite() {
            let value = theta.to_subset_unchecked();
            return Err(PlantError::NotFinite { what: "theta(0)", row: 0, column: 0, value }.into());
        }
        Ok(Self { theta, ..self })
    }

    /// Reports [`Diagnosis::NotExciting`] while the estimator's excitation is below `wanted`.
    #[must_use]
    pub fn wanting_excitation(self, wanted: T) -> Self {
        Self { wanted: Some(wanted), ..self }
    }

    /// The same with resets; see the [module](self).
    ///
    /// # Errors
    /// [`ObserverError::NotPositive`] for the period and the level.
    pub fn resetting(self, reset: Reset<T>) -> Result<Self, ObserverError> {
        positive("the period of the reset", reset.period)?;
        if let Some(level) = reset.above {
            positive("the level of the reset", level)?;
        }
        Ok(Self { reset: Some(reset), ..self })
    }

    /// The resets.
    pub fn reset(&self) -> Option<&Reset<T>> {
        self.reset.as_ref()
    }

    /// The maps.
    pub fn map(&self) -> &K {
        &self.map
    }

    /// The estimator.
    pub fn estimator(&self) -> &E {
        &self.estimator
    }

    /// The filters.
    pub fn filter(&self) -> &Filter<T> {
        &self.filter
    }
}

/// The state of the observer, taken apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Parts<'s, T: RealField + Copy, Z: Dim, R: Dim, Q: Dim>
where
    DefaultAllocator: nalgebra::allocator::Allocator<Z> + crate::estimator::RegressionSize<R, Q>,
{
    /// The extension xi.
    pub xi: OVector<T, Z>,
    /// The state w of the filter W.
    pub w: OVector<T, R>,
    /// `F[g]`.
    pub known: OVector<T, R>,
    /// `M = F[m]`.
    pub regressor: OMatrix<T, R, Q>,
    /// The state of the estimator, theta_hat first.
    pub estimator: &'s [T],
}

/// Y and M.
type RegressionOf<K, T> =
    (OVector<T, <K as Regression<T>>::Rows>, OMatrix<T, <K as Regression<T>>::Rows, <K as Regression<T>>::Parameters>);

type PartsOf<'s, K, T> =
    Parts<'s, T, <K as KklMap<T>>::Xi, <K as Regression<T>>::Rows, <K as Regression<T>>::Parameters>;

type StateOf<K, E, T> = OVector<
    T,
    <DefaultAllocator as PebSize<
        <K as KklMap<T>>::Xi,
        <K as Regression<T>>::Rows,
        <K as Regression<T>>::Parameters,
        <E as ParameterEstimator<T, <K as Regression<T>>::Rows, <K as Regression<T>>::Parameters>>::Length,
    >>::Length,
>;

impl<K, E, T> KklPebObserver<K, E, T>
where
    T: RealField + Copy,
    K: Regression<T>,
    E: ParameterEstimator<T, K::Rows, K::Parameters>,
    DefaultAllocator:
        KklSize<K::Xi, K::Inputs, K::Outputs, K::Estimate> + PebSize<K::Xi, K::Rows, K::Parameters, E::Length>,
{
    /// The parts of a state of this observer.
    pub fn parts<'s>(&self, state: &'s StateOf<K, E, T>) -> PartsOf<'s, K, T> {
        let z = self.map.dimensions().state;
        let (r, q) = self.map.rows_and_parameters();
        let (rows, columns) = (K::Rows::from_usize(r), K::Parameters::from_usize(q));
        let state = state.as_slice();
        Parts {
            xi: OVector::from_fn_generic(K::Xi::from_usize(z), U1, |i, _| state[i]),
            w: OVector::from_fn_generic(rows, U1, |i, _| state[z + i]),
            known: OVector::from_fn_generic(rows, U1, |i, _| state[z + r + i]),
            regressor: OMatrix::from_fn_generic(rows, columns, |i, j| state[z + (2 + j) * r + i]),
            estimator: &state[z + r * (q + 2)..],
        }
    }

    /// theta_hat, held inside its domain.
    pub fn theta(&self, state: &StateOf<K, E, T>) -> OVector<T, K::Parameters> {
        let parts = self.parts(state);
        self.held(&parts)
    }

    /// The excitation of the regression, if the estimator computes it.
    pub fn excitation(&self, state: &StateOf<K, E, T>) -> Option<T> {
        let parts = self.parts(state);
        self.estimator.excitation(parts.estimator, &parts.regressor)
    }

    /// The regression `Y = M theta` at this instant.
    pub fn regression(&self, t: T, state: &StateOf<K, E, T>, y: &OVector<T, K::Outputs>) -> RegressionOf<K, T> {
        let parts = self.parts(state);
        (self.filter.washout(&parts.w, &self.map.signal(t, y)) - parts.known, parts.regressor)
    }

    fn held(&self, parts: &PartsOf<'_, K, T>) -> OVector<T, K::Parameters> {
        OVector::from_fn_generic(parts.regressor.shape_generic().1, U1, |i, _| {
            let theta = parts.estimator[i];
            self.map.lower_bound(i).map_or(theta, |bound| larger(theta, bound))
        })
    }

    /// theta_hat(0), inside of its domain.
    fn first(&self) -> OVector<T, K::Parameters> {
        let (_, q) = self.map.rows_and_parameters();
        OVector::from_fn_generic(K::Parameters::from_usize(q), U1, |i, _| {
            self.map.lower_bound(i).map_or(self.theta, |bound| larger(self.theta, bound))
        })
    }

    /// The right-hand side of the estimator, before projection.
    fn estimator_rate(&self, t: T, state: &StateOf<K, E, T>, y: &OVector<T, K::Outputs>, rate: &mut [T]) {
        let (value, m) = self.regression(t, state, y);
        let offset = state.nrows() - rate.len();
        self.estimator.rate(&state.as_slice()[offset..], &value, &m, rate);
    }

    /// The whole right-hand side, theta_hat not yet projected.
    fn unprojected(
        &self,
        t: T,
        state: &StateOf<K, E, T>,
        u: &OVector<T, K::Inputs>,
        y: &OVector<T, K::Outputs>,
    ) -> StateOf<K, E, T> {
        let parts = self.parts(state);
        let xi = &parts.xi;
        let mut slope = state.clone();
        let sources = [
            self.filter.rate(&parts.w, &self.map.signal(t, y)),
            self.filter.rate(&parts.known, &self.map.known(t, xi, u, y)),
        ];
        let regressor = self.filter.rate(&parts.regressor, &self.map.regressor(t, xi, u, y));
        let extension = self.map.slope(t, xi, u, y);
        let entries = extension.iter().chain(sources[0].iter()).chain(sources[1].iter()).chain(regressor.iter());
        slope.iter_mut().zip(entries).for_each(|(slope, &entry)| *slope = entry);
        let offset = state.nrows() - parts.estimator.len();
        self.estimator_rate(t, state, y, &mut slope.as_mut_slice()[offset..]);
        slope
    }
}

impl<K, E, T> Observer<T> for KklPebObserver<K, E, T>
where
    T: RealField + Copy,
    K: Regression<T>,
    E: ParameterEstimator<T, K::Rows, K::Parameters>,
    DefaultAllocator:
        KklSize<K::Xi, K::Inputs, K::Outputs, K::Estimate> + PebSize<K::Xi, K::Rows, K::Parameters, E::Length>,
{
    type State = StateOf<K, E, T>;
    type Input = OVector<T, K::Inputs>;
    type Output = OVector<T, K::Outputs>;
    type Estimate = OVector<T, K::Estimate>;

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.map.dimensions();
        let (r, q) = self.map.rows_and_parameters();
        ObserverDimensions { state: size.state + r * (q + 2) + self.estimator.state_len(r), ..size }
    }

    fn derivative(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        let mut slope = self.unprojected(t, state, u, y).map(finite_or_zero);
        let (r, q) = self.map.rows_and_parameters();
        let offset = self.map.dimensions().state + r * (q + 2);
        for i in 0..q {
            if let Some(bound) = self.map.lower_bound(i) {
                let (theta, rate) = (state[offset + i], slope[offset + i]);
                slope[offset + i] = choose(|| theta <= bound && rate < T::zero(), T::zero(), rate);
            }
        }
        slope
    }

    fn estimate(&self, t: T, state: &Self::State, _u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        let parts = self.parts(state);
        let complete = &parts.xi + self.map.missing(&self.held(&parts));
        self.map.left_inverse(t, &complete, y)
    }

    fn jump_period(&self) -> Option<T> {
        self.reset.map(|reset| reset.period)
    }

    fn jump(&self, t: T, state: &Self::State, _u: &Self::Input, y: &Self::Output) -> Self::State {
        let mut after = state.clone();
        let Some(Reset { above, memory, .. }) = self.reset else { return after };
        let parts = self.parts(state);
        let is_above = |level: T| parts.xi.iter().enumerate().any(|(i, xi)| self.map.is_open(i) && xi.abs() > level);
        if !above.is_none_or(is_above) {
            return after;
        }
        let (held, first) = (self.held(&parts), self.first());
        let (behind, ahead) = (self.map.missing(&held), self.map.missing(&first));
        let (z, (r, q)) = (parts.xi.nrows(), self.map.rows_and_parameters());
        for i in 0..z {
            after[i] += behind[i] - ahead[i];
        }
        let filters = z + r * (q + 2);
        match memory {
            FilterMemory::Transformed => {
                let delta = &held - &first;
                for i in 0..r {
                    for j in 0..q {
                        after[z + r + i] += parts.regressor[(i, j)] * delta[j];
                    }
                }
                self.estimator.shift(&mut after.as_mut_slice()[filters..], &delta);
            }
            FilterMemory::Restarted => {
                let signal = self.map.signal(t, y);
                let rest = after.iter_mut().skip(z);
                rest.enumerate().for_each(|(i, entry)| *entry = if i < r { signal[i] } else { T::zero() });
            }
        }
        for j in 0..q {
            after[filters + j] = first[j];
        }
        after
    }

    /// xi such that the estimate is as wished with theta_hat(0), w at s(y), all other filters and the estimator's
    /// extension at 0.
    fn initial(&self, t: T, estimate: &Self::Estimate, _u: &Self::Input, y: &Self::Output) -> Self::State {
        let size = self.map.dimensions().state;
        let (r, q) = self.map.rows_and_parameters();
        let theta = self.first();
        let xi = self.map.image(t, estimate, y) - self.map.missing(&theta);
        let signal = self.map.signal(t, y);
        let length = <DefaultAllocator as PebSize<K::Xi, K::Rows, K::Parameters, E::Length>>::Length::from_usize(
            self.dimensions().state,
        );
        let mut state = OVector::zeros_generic(length, U1);
        state.iter_mut().zip(xi.iter().chain(signal.iter())).for_each(|(state, &entry)| *state = entry);
        for i in 0..q {
            state[size + r * (q + 2) + i] = theta[i];
        }
        state
    }
}

impl<K, E, T> Diagnose<T> for KklPebObserver<K, E, T>
where
    T: RealField + Copy,
    K: Regression<T>,
    E: ParameterEstimator<T, K::Rows, K::Parameters>,
    DefaultAllocator:
        KklSize<K::Xi, K::Inputs, K::Outputs, K::Estimate> + PebSize<K::Xi, K::Rows, K::Parameters, E::Length>,
{
    /// A parameter at its bound, or one that would reach it within `1/alpha` at its present rate; an entry of the slope
    /// that is not finite; an excitation below the one wanted.
    fn diagnose(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Diagnosis<T> {
        let slope = self.unprojected(t, state, u, y);
        if let Some(entry) = slope.iter().position(|entry| !entry.is_finite()) {
            return Diagnosis::Overflow { entry };
        }
        let (r, q) = self.map.rows_and_parameters();
        let offset = self.map.dimensions().state + r * (q + 2);
        for parameter in 0..q {
            if let Some(bound) = self.map.lower_bound(parameter) {
                let (value, rate) = (state[offset + parameter], slope[offset + parameter]);
                if value <= bound {
                    return Diagnosis::LeftDomain { parameter, value, bound };
                }
                if rate < T::zero() && (bound - value) >= rate / self.filter.alpha() {
                    return Diagnosis::LeavingDomain { parameter, value, bound, time: (bound - value) / rate };
                }
            }
        }
        match (self.wanted, self.excitation(state)) {
            (Some(wanted), Some(excitation)) if excitation < wanted => Diagnosis::NotExciting { excitation, wanted },
            _ => Diagnosis::Sound,
        }
    }
}
