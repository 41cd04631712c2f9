//! The stationary Kalman filter: a Luenberger observer with the Kalman gain.

use luenberger_live as live;
use luenberger_observers::StationaryKalmanFilter;
use nalgebra::Dyn;

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::keys::{CROSS_INTENSITY, NOISE_ENTERING, Q, RHO, V, W};
use super::{Kind, as_kind};
use crate::designed::Running;
use crate::keys::{Type, optional};
use crate::reader::{Given, Reader, gain};
use crate::results::NoObserver;
use crate::study::{LinearSpec, ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::{Designed, Plan, discrete, linear};
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
    read,
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

fn read(given: &Given<'_>, reader: &mut Reader) -> Option<ObserverKind> {
    Some(Kalman(gain::linear(given.node, given.size(), reader)?).into())
}

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

    fn faster(&self, factor: f64, dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self(self.0.faster(factor, dt)).into())
    }
}

impl Kind for Kalman {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        linear::design(plan, &self.0)
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
        discrete::design(plan, &self.0, dt)
    }
}

impl Running for StationaryKalmanFilter<f64, Dyn, Dyn, Dyn> {
    runs!(sampled);

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
