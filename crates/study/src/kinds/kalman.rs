//! The stationary Kalman filter: a Luenberger observer with the Kalman gain.

use luenberger_design::{DesignError, KalmanNoise, LyapunovWeight};
use luenberger_linalg::discrete_kalman_gain;
use luenberger_live as live;
use luenberger_observers::{ExtendedKalmanFilter, NoiseModel, Prediction, StationaryKalmanFilter};
use nalgebra::{DMatrix, Dyn};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::filter::cross_with;
use super::keys::{CROSS_INTENSITY, NOISE_ENTERING, Q, RECOVERY, RHO, V, W};
use super::{Kind, as_kind};
use crate::designed::{LinearForm, Running};
use crate::keys::{Type, optional};
use crate::reader::gain;
use crate::results::NoObserver;
use crate::study::{Estimated, GainSpec, LinearSpec, ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::{Designed, Plan, discrete, linear, uncertified};
use crate::tuning::{Context, Keys, Value, covariance, intensity, linear as is_linear, noisy, process_noise};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "kalman",
    about: "Stationary Kalman filter, for linear plants.",
    source: "Kalman and Bucy 1961; in discrete time Kalman 1960",
    plant: PlantClass::AtPoint(Time::ANY),
    keys: &[&[
        W,
        V,
        NOISE_ENTERING,
        CROSS_INTENSITY,
        RECOVERY,
        RHO,
        Q,
        optional(
            "form",
            Type::Choice(&[
                ("predictor", "The estimate before the measurement of its sample, xhat(k|k-1)."),
                ("filter", "The estimate after it, xhat(k|k)."),
            ]),
            "Estimate at a sample, of plants in discrete time and in exported code (default predictor).",
        ),
    ]],
    kind: as_kind::<Kalman>,
    read: |given, reader| Some(Kalman(gain::linear(given, reader)?).into()),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "kalman",
        turn: 2,
        tuning: "stationary Kalman gain for the intensities of process and measurement noise",
        source: "Kalman and Bucy 1961",
        character: "its gain is that of the steady state: optimal once the first error is forgotten, not before",
        information: &[Information::Noise, Information::ProcessNoise],
        keys: tuned,
    }]),
};

/// A stationary Kalman filter with the gain of this specification.
#[derive(Debug, Clone, PartialEq)]
pub struct Kalman(pub LinearSpec);

impl Specification for Kalman {
    declared!();

    fn whole_gain(&self) -> Option<&LinearSpec> {
        Some(&self.0)
    }

    fn updates(&self, _dt: Option<f64>) -> bool {
        self.0.is_filter
    }

    // In continuous time V is an intensity, and a sample has no covariance. Correlated noises have another update.
    fn has_likelihood(&self, dt: Option<f64>) -> bool {
        dt.is_some() && matches!(&self.0.gain, GainSpec::Kalman(noise) if noise.s.is_none())
    }

    fn faster(&self, factor: f64, dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self(self.0.faster(factor, dt)).into())
    }

    // A parameter makes a linear plant nonlinear; a noise that is added to it does not.
    fn with_parameters(&self, parameters: &[Estimated]) -> Option<ObserverKind> {
        let GainSpec::Kalman(KalmanNoise { w, v, g, s, recovery }) = &self.0.gain else { return None };
        if parameters.iter().any(|one| one.noise.is_none()) {
            return None;
        }
        let count = parameters.len();
        let behind = |own: &DMatrix<f64>, of: &dyn Fn(&Estimated) -> f64| {
            let mut all = own.clone().resize(own.nrows() + count, own.ncols() + count, 0.0);
            for (k, one) in parameters.iter().enumerate() {
                all[(own.nrows() + k, own.ncols() + k)] = of(one);
            }
            all
        };
        let noise = KalmanNoise {
            w: behind(w, &|one| one.w),
            v: v.clone(),
            g: g.as_ref().map(|g| behind(g, &|_| 1.0)),
            s: cross_with(s.as_ref(), parameters),
            recovery: *recovery,
        };
        let weight = match &self.0.weight {
            Some(LyapunovWeight::Matrix(q)) => Some(LyapunovWeight::Matrix(behind(q, &|_| 1.0))),
            other => other.clone(),
        };
        Some(Self(LinearSpec { gain: GainSpec::Kalman(noise), weight, ..self.0.clone() }).into())
    }
}

impl Kind for Kalman {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        linear::design(plan, &self.0)
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
        discrete::design(plan, &self.0, dt)
    }

    // From the stationary covariance on, the filter with a covariance has the stationary gain as long as every output
    // is measured.
    fn with_covariance(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let (plant, dt) = (plan.linear()?, plan.study.plant.dt);
        let (GainSpec::Kalman(noise), Some(dt)) = (&self.0.gain, dt) else {
            return Err(NoObserver::new("the innovations have no covariance"));
        };
        let w = noise.g.as_ref().map_or_else(|| noise.w.clone(), |g| g * &noise.w * g.transpose());
        let stationary = discrete_kalman_gain(&plant.a, &plant.c, &w, &noise.v).map_err(DesignError::from)?;
        let noises = NoiseModel { w, v: noise.v.clone(), p0: stationary.p };
        let filter = ExtendedKalmanFilter::discrete(plan.study.plant.model.clone(), noises, dt)?
            .with_prediction(Prediction::Discrete)?;
        Ok(Designed::new(filter.into(), uncertified("the stationary filter with its covariance"), None))
    }
}

impl Running for StationaryKalmanFilter<f64, Dyn, Dyn, Dyn> {
    runs!(sampled);

    fn linear(&self) -> Option<LinearForm> {
        let predictor = self.predictor().linear()?;
        Some(LinearForm { update: Some(self.k().clone()), ..predictor })
    }

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((live::ObserverKind::StationaryKalman(Box::new(self.clone())), None))
    }
}

fn tuned(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    is_linear(context)?;
    noisy(context)?;
    let v = if context.study.plant.dt.is_some() { covariance(context) } else { intensity(context) };
    Ok(vec![vec![("w", Value::weight(&process_noise(context)?)), ("v", v)]])
}
