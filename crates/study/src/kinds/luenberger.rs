//! The Luenberger observer `xhat' = A xhat + B u + L (y - C xhat - D u)`.

use std::sync::Arc;

use luenberger_design::{DesignError, OperatingPoint};
use luenberger_live as live;
use luenberger_observers::{DiscreteLinearObserver, LinearObserver};
use luenberger_sim::AnyObserver;
use nalgebra::{DMatrix, Dyn};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::keys::{DECAY, ERROR_BOUNDS, GAIN, KALMAN, LMI, MAX_GAIN, NOISE, POLES, Q, RHO};
use super::{Kind, of};
use crate::designed::{At, Runnable, Running, SampledDesign, continuous, sampled};
use crate::reader::{Given, Reader, gain};
use crate::results::FailureReport;
use crate::steps::{self};
use crate::study::{LinearSpec, ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::operating_point::{at, page_point};
use crate::synthesis::{Designed, NoDesign, Plan, Sampling, discrete, linear};
use crate::tuning::{self, Context, Keys, Value, covariance, intensity, noisy, rates};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "luenberger",
    about: "Luenberger observer xhat' = A xhat + B u + L (y - C xhat - D u), for linear plants.",
    source: "Luenberger 1964",
    plant: PlantClass::AtPoint(Time::ANY),
    keys: &[POLES, DECAY, LMI, KALMAN, GAIN, RHO, Q, MAX_GAIN, NOISE, ERROR_BOUNDS],
    kind: of::<Luenberger>,
    read,
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

fn read(given: &Given<'_>, reader: &mut Reader) -> Option<ObserverKind> {
    Some(Luenberger(gain::linear(given.node, given.size(), reader)?).into())
}

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

    fn faster(&self, factor: f64) -> Option<ObserverKind> {
        Some(Self(self.0.faster(factor)).into())
    }
}

impl Kind for Luenberger {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoDesign> {
        linear::design(plan, &self.0)
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoDesign> {
        discrete::design(plan, &self.0, dt)
    }

    fn sampled(&self, of: &Sampling<'_>) -> Option<Result<SampledDesign, FailureReport>> {
        steps::of_gain(of, &self.0)
    }

    fn sampled_at_point(
        &self,
        of: &Sampling<'_>,
        point: &OperatingPoint,
    ) -> Option<Result<SampledDesign, FailureReport>> {
        Some(steps::of_gain_at_point(of, &self.0, point))
    }
}

impl Running for LinearObserver<f64, Dyn, Dyn, Dyn> {
    fn any(&self) -> Arc<dyn AnyObserver + '_> {
        continuous(self)
    }

    fn at(&self, point: &OperatingPoint) -> Option<Result<Runnable, DesignError>> {
        Some(at(self.clone(), point).map(Runnable::from))
    }

    fn gain_of_loop(&self) -> Option<DMatrix<f64>> {
        Some(self.l.clone())
    }

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((live::ObserverKind::Linear(Box::new(self.clone())), None))
    }
}

impl Running for At<LinearObserver<f64, Dyn, Dyn, Dyn>> {
    fn any(&self) -> Arc<dyn AnyObserver + '_> {
        continuous(self)
    }

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((live::ObserverKind::Linear(Box::new(self.inner().clone())), Some(page_point(self))))
    }
}

impl Running for DiscreteLinearObserver<f64, Dyn, Dyn, Dyn> {
    fn any(&self) -> Arc<dyn AnyObserver + '_> {
        sampled(self)
    }

    fn gain_of_loop(&self) -> Option<DMatrix<f64>> {
        Some(self.l().clone())
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
