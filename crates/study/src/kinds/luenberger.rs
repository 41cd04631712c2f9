//! The Luenberger observer `xhat' = A xhat + B u + L (y - C xhat - D u)`.

use luenberger_design::{DesignError, OperatingPoint};
use luenberger_live as live;
use luenberger_observers::{DiscreteLinearObserver, LinearObserver};
use nalgebra::{DMatrix, Dyn};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::keys::{ERROR_BOUNDS, GAINS, OF_GAIN};
use super::{Kind, as_kind};
use crate::designed::{At, LinearForm, Runnable, Running};
use crate::reader::gain;
use crate::results::NoObserver;
use crate::study::{LinearSpec, ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::operating_point::{in_deviations, page_point};
use crate::synthesis::{Designed, Plan, discrete, linear};
use crate::tuning::{self, Context, Keys, Value, covariance, intensity, noisy, rates};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "luenberger",
    about: "Luenberger observer xhat' = A xhat + B u + L (y - C xhat - D u), for linear plants.",
    source: "Luenberger 1964",
    plant: PlantClass::AtPoint(Time::ANY),
    keys: &[GAINS, OF_GAIN, &[ERROR_BOUNDS]],
    kind: as_kind::<Luenberger>,
    read: |given, reader| Some(Luenberger(gain::linear(given, reader)?).into()),
    takes_long: false,
    tuning: Tuning::Rules(&[
        Rule {
            name: "luenberger",
            turn: 0,
            tuning: "modes of the plant that are slower than the decay rate, or than twice the slowest one, become the poles of a Bessel filter of that rate",
            source: "luenberger poles --pattern bessel",
            character: "its poles are placed without regard to the noise",
            information: &[Information::Settling],
            keys: |context| Ok(vec![tuning::poles(context, 0)?]),
        },
        Rule {
            name: "luenberger-lmi",
            turn: 1,
            tuning: "the least noise gain among the gains with the decay rate, or twice that of the plant, by a matrix inequality",
            source: "Boyd et al. 1994, sections 2.6 and 7.2",
            character: "its gain is the least noisy one that the matrix inequality finds for the decay rate",
            information: &[Information::Settling, Information::Noise],
            keys: least_noise,
        },
    ]),
};

/// A Luenberger observer with this gain.
#[derive(Debug, Clone, PartialEq)]
pub struct Luenberger(pub LinearSpec);

impl Specification for Luenberger {
    declared!();

    fn gain(&self) -> Option<&LinearSpec> {
        Some(&self.0)
    }

    fn whole_gain(&self) -> Option<&LinearSpec> {
        Some(&self.0)
    }

    fn takes_uncertainty(&self) -> bool {
        true
    }

    fn faster(&self, factor: f64, dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self(self.0.faster(factor, dt)).into())
    }
}

impl Kind for Luenberger {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        linear::design(plan, &self.0)
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
        discrete::design(plan, &self.0, dt)
    }
}

impl Running for LinearObserver<f64, Dyn, Dyn, Dyn> {
    runs!(continuous);

    fn at(&self, point: &OperatingPoint) -> Option<Result<Runnable, DesignError>> {
        Some(in_deviations(self.clone(), point).map(Runnable::from))
    }

    fn gain_of_loop(&self) -> Option<DMatrix<f64>> {
        Some(self.l.clone())
    }

    fn linear(&self) -> Option<LinearForm> {
        Some(LinearForm { plant: self.plant(), l: self.l.clone(), update: None })
    }

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((live::ObserverKind::Linear(Box::new(self.clone())), None))
    }
}

impl Running for At<LinearObserver<f64, Dyn, Dyn, Dyn>> {
    runs!(continuous);

    fn linear(&self) -> Option<LinearForm> {
        self.inner().linear()
    }

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((live::ObserverKind::Linear(Box::new(self.inner().clone())), Some(page_point(self))))
    }
}

impl Running for DiscreteLinearObserver<f64, Dyn, Dyn, Dyn> {
    runs!(sampled);

    fn gain_of_loop(&self) -> Option<DMatrix<f64>> {
        Some(self.l().clone())
    }

    fn linear(&self) -> Option<LinearForm> {
        Some(LinearForm { plant: self.plant().clone(), l: self.l().clone(), update: None })
    }

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((live::ObserverKind::DiscreteLinear(Box::new(self.clone())), None))
    }
}

fn least_noise(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    tuning::linear(context)?;
    noisy(context)?;
    let noise = || if context.study.plant.dt.is_some() { covariance(context) } else { intensity(context) };
    let keys = |rate: f64| vec![("decay_rate", Value::Number(rate)), ("noise", noise())];
    Ok(rates(context.information.linear_rate).filter(|rate| *rate > 0.0).map(keys).collect())
}
