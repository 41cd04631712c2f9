//! A copy of a nonlinear plant with one gain for all Jacobians over a region (polytopic design).

use luenberger_design::enclosure::enclose;
use luenberger_design::{
    DesignError, DiscreteLpvDesign, GainOptions, LipschitzDesign, LipschitzPlant, LpvDesign, LpvError, Region,
};
use luenberger_export::ExportableObserver;
use luenberger_live as live;
use luenberger_observers::{DiscreteNonlinearObserver, NonlinearLuenbergerObserver, SampledObserver};
use luenberger_proof::wording::significant;
use nalgebra::{DMatrix, Dyn};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::keys::{MAX_GAIN, NOISE, REGION};
use super::lipschitz::by_sectors;
use super::settings::one_of;
use super::{Kind, as_kind};
use crate::designed::{NonlinearStep, Running, StepOf, rows};
use crate::study::{ObserverKind, PlantClass, RateSpec, Specification, Study, Time};
use crate::synthesis::{Designed, Plan, certified, lower_bound, matrix, number, proof_matrix, upper_bound};
use crate::tuning::{nonlinear, over_region};

use crate::model::Model;
use crate::reader::{Given, Reader};
use crate::results::{DesignReport, NoObserver, Quantity, Statement};
use crate::synthesis::noise_gain::NoiseGain;

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "lpv",
    about: "Copy of a nonlinear plant with one gain for all Jacobians over a region (polytopic design).",
    source: "Boyd et al., Linear Matrix Inequalities in System and Control Theory, 1994",
    plant: PlantClass::Nonlinear(Time::ANY),
    keys: &[Lpv::KEYS],
    kind: as_kind::<Lpv>,
    read: |given, reader| Some(Lpv::read(given, reader)?.into()),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "lpv",
        turn: 13,
        tuning: "the largest decay rate up to that of the settling time for all Jacobians over the region, and the least noise gain with it",
        source: "Boyd et al. 1994, section 7.2",
        character: "one constant gain serves all Jacobians of the region",
        information: &[Information::Settling, Information::Region, Information::Noise],
        keys: |context| nonlinear(context).and_then(|()| over_region(context, "fastest")),
    }]),
};

crate::keys! { |size|
    /// One gain for all Jacobians over a box.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Lpv {
        /// The box of the states.
        region: Region as &REGION = Region::everywhere(size.states),
        /// The rate.
        rate: RateSpec as [Goal::KEYS] => rate,
        ..[&[MAX_GAIN, NOISE]]
    }
}

crate::keys! {
    struct Goal {
        /// Decay rate to be certified (default 0).
        decay_rate: Option<f64> as Number(NotNegative),
        /// In place of decay_rate: the largest decay rate up to this bound is found and certified.
        fastest: Option<f64> as Number(Positive),
        /// In place of a design: a given gain L, n x p, is analysed.
        gain: Option<DMatrix<f64>>[n, p] as Rows,
    }
}

fn rate(given: &Given<'_>, reader: &mut Reader) -> Option<RateSpec> {
    one_of(Goal::KEYS, given, false, reader)?;
    let Goal { decay_rate, fastest, gain } = Goal::read(given, reader)?;
    let given = fastest.map(RateSpec::Fastest).or(gain.map(|gain| RateSpec::Gain(gain, 0.0)));
    Some(given.unwrap_or(RateSpec::Rate(decay_rate.unwrap_or(0.0))))
}

impl Specification for Lpv {
    declared!();

    fn free_keys(&self) -> &'static [&'static str] {
        &["decay_rate", "gain"]
    }

    fn has_given_gain(&self) -> bool {
        true
    }

    fn decay_rate(&self) -> Option<f64> {
        match self.rate {
            RateSpec::Rate(rate) => Some(rate),
            RateSpec::Fastest(_) | RateSpec::Gain(..) => None,
        }
    }

    fn poses_inequality(&self) -> bool {
        true
    }

    fn region_of_design(&self) -> Option<Region> {
        Some(self.region.clone())
    }

    fn takes_region(&self) -> bool {
        true
    }

    fn faster(&self, factor: f64, _dt: Option<f64>) -> Option<ObserverKind> {
        let rate = match &self.rate {
            RateSpec::Rate(rate) => RateSpec::Rate(rate * factor),
            RateSpec::Fastest(ceiling) => RateSpec::Fastest(ceiling * factor),
            given @ RateSpec::Gain(..) => given.clone(),
        };
        Some(Self { rate, ..self.clone() }.into())
    }
}

impl Kind for Lpv {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        lpv(plan.study, &self.region, &self.rate, &plan.options())
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
        discrete_lpv(plan.study, &self.region, &self.rate, dt, &plan.options())
    }
}

impl Running for NonlinearLuenbergerObserver<Model, f64, Dyn, Dyn, Dyn> {
    runs!(continuous);

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((live::ObserverKind::NonlinearLuenberger { l: rows(self.l()) }, None))
    }

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        of.with_gain(self.l(), of.observer.initial.clone(), "").map(Some)
    }
}

impl Running for DiscreteNonlinearObserver<Model, f64, Dyn, Dyn, Dyn> {
    runs!(sampled);

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        let period = SampledObserver::<f64>::period(self);
        Some((live::ObserverKind::DiscreteNonlinear { l: rows(self.l()), period }, None))
    }

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let observer = DiscreteNonlinearObserver::new(of.plant.clone(), self.l().clone(), of.period);
        let observer = observer?;
        if of.designed.certificate.is_none() {
            return Err(NoObserver::new("the design has no certificate to refer to"));
        }
        Ok(Some(NonlinearStep::of(of.designed, ExportableObserver::Discrete(observer))))
    }
}

fn lpv(study: &Study, region: &Region, rate: &RateSpec, options: &GainOptions) -> Result<Designed, NoObserver> {
    let model = &study.plant.model;
    let design = match rate {
        RateSpec::Rate(rate) => LpvDesign::new_with(model.clone(), region, *rate, options),
        // The rate is determined to one hundredth of the ceiling, which is enough for a design.
        RateSpec::Fastest(ceiling) => {
            LpvDesign::max_rate_with(model.clone(), region, *ceiling, 0.01 * ceiling, options)
        }
        RateSpec::Gain(gain, _) => LpvDesign::certify_with(model.clone(), region, gain, &options.settings),
    };
    let design = match design {
        Err(LpvError::TooManyVertices { .. }) => return beyond_vertices(study, region, rate, options),
        design => design?,
    };
    let evidence =
        design.stopped.as_ref().map(|(rate, why)| format!("rate {} is not certified: {why}", significant(*rate, 5)));
    let pairs = design.polytope.vertices.iter().map(|vertex| (&vertex.a, &vertex.c));
    let l = design.l();
    let noise = NoiseGain::of(study, pairs, l, None);
    let mut numbers = vec![
        lower_bound(Quantity::Rate, design.rate),
        upper_bound(Quantity::Overshoot, design.overshoot),
        number(Quantity::Vertices, design.polytope.vertices.len() as f64),
    ];
    numbers.extend(noise.numbers());
    let report = DesignReport {
        statement: Statement::of_proved(design.sentence()),
        matrices: vec![matrix("L", l), proof_matrix("P", &design.p)],
        numbers,
        evidence,
        noise_deviation: noise.deviation,
        ..certified(&design.certificate, &design.vertex_names())
    };
    let runnable = design.observer.clone().into();
    Ok(Designed::new(runnable, report, Some(design.certificate.clone())))
}

fn discrete_lpv(
    study: &Study,
    region: &Region,
    rate: &RateSpec,
    dt: f64,
    options: &GainOptions,
) -> Result<Designed, NoObserver> {
    let model = study.plant.model.clone();
    let design = match rate {
        RateSpec::Rate(rate) => DiscreteLpvDesign::new(model, dt, region, *rate, options)?,
        // The rate is determined to one hundredth of the ceiling, which is enough for a design.
        RateSpec::Fastest(ceiling) => {
            DiscreteLpvDesign::max_rate(model, dt, region, (*ceiling, 0.01 * ceiling), options)?
        }
        RateSpec::Gain(gain, _) => DiscreteLpvDesign::certify(model, dt, region, gain, &options.settings)?,
    };
    let evidence =
        design.stopped.as_ref().map(|(rate, why)| format!("rate {} is not certified: {why}", significant(*rate, 5)));
    let l = design.l();
    let report = DesignReport {
        statement: Statement::of_proved(design.sentence()),
        matrices: vec![matrix("L", l), proof_matrix("P", &design.p)],
        numbers: vec![
            lower_bound(Quantity::Rate, design.rate),
            upper_bound("factor of a step", design.factor),
            upper_bound(Quantity::Overshoot, design.overshoot),
            number(Quantity::Vertices, design.polytope.vertices.len() as f64),
            number(Quantity::GainNorm, l.clone().svd(false, false).singular_values.max()),
        ],
        evidence,
        ..certified(&design.certificate, &design.vertex_names())
    };
    let runnable = design.observer.clone().into();
    Ok(Designed::new(runnable, report, Some(design.certificate.clone())))
}

/// Where the vertices are too many: the norm-bounded form, with a sector for each entry that varies and one inequality
/// in place of one for each vertex. It is sufficient only.
fn beyond_vertices(
    study: &Study,
    region: &Region,
    rate: &RateSpec,
    options: &GainOptions,
) -> Result<Designed, NoObserver> {
    let enclosure = enclose(&study.plant.model, region)?;
    let plant = LipschitzPlant::over(&enclosure)?;
    let count = plant.sectors().len();
    let at = |rate| LipschitzDesign::new_with(&plant, None, rate, options);
    let design = match rate {
        RateSpec::Rate(rate) => at(*rate)?,
        RateSpec::Gain(gain, rate) => LipschitzDesign::new_with(&plant, Some(gain), *rate, options)?,
        RateSpec::Fastest(ceiling) => fastest(at, *ceiling)?,
    };
    let whose = format!(
        "{count} entries of the Jacobians vary, too many for a polytope with 2^{count} vertices: the norm-bounded form is used, which is more conservative."
    );
    by_sectors(study, &design, enclosure.sentence(&design.certificate, region, ("xhat", "t")), &whose)
}

/// The design of the greatest rate up to the ceiling, to one hundredth of it.
fn fastest(
    at: impl Fn(f64) -> Result<LipschitzDesign, DesignError>,
    ceiling: f64,
) -> Result<LipschitzDesign, DesignError> {
    let proved = |rate| at(rate).ok().filter(|design| design.certificate.is_proved());
    if let Some(design) = proved(ceiling) {
        return Ok(design);
    }
    let (mut best, mut low, mut high) = (at(0.0)?, 0.0, ceiling);
    while high - low > 0.01 * ceiling {
        let middle = f64::midpoint(low, high);
        match proved(middle) {
            Some(design) => (best, low) = (design, middle),
            None => high = middle,
        }
    }
    Ok(best)
}
