//! A copy of a nonlinear plant with a gain for all nonlinearities within sectors (Thau, Rajamani, circle criterion).

use luenberger_design::enclosure::enclose;
use luenberger_design::{GainOptions, LipschitzDesign, LipschitzPlant, Region, Sector};
use luenberger_proof::certificate::{ProvedSentence, Reading, Represented};
use nalgebra::DMatrix;

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::keys::{MAX_GAIN, NOISE, REGION};
use super::{KeyValue, Kind, Present, as_kind};
use crate::keys::Table;
use crate::reader::tree::Node;
use crate::reader::{Given, Reader, check};
use crate::results::{DesignReport, NoObserver, Quantity, Statement};
use crate::study::{ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::noise_gain::NoiseGain;
use crate::synthesis::{Designed, Plan, certified, lower_bound, matrix, number, proof_matrix};
use crate::tuning::{nonlinear, over_region};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "lipschitz",
    about: "Copy of a nonlinear plant with a gain for all nonlinearities within sectors (Thau, Rajamani, circle criterion).",
    source: "Thau 1973, Rajamani 1998, Arcak and Kokotovic 2001",
    plant: PlantClass::Nonlinear(Time::CONTINUOUS),
    keys: &[Lipschitz::KEYS],
    kind: as_kind::<Lipschitz>,
    read: |given, reader| Some(Lipschitz::read(given, reader)?.checked(given.node, reader)?.into()),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "lipschitz",
        turn: 14,
        tuning: "the decay rate, or half of it as often as needed, for all slopes over the region, and the least noise gain with it",
        source: "Arcak and Kokotovic 2001",
        character: "one constant gain serves all slopes within the sectors of the region",
        information: &[Information::Settling, Information::Region, Information::Noise],
        keys: |context| nonlinear(context).and_then(|()| over_region(context, "decay_rate")),
    }]),
};

crate::keys! { |size|
    /// One gain for all nonlinearities within given sectors.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Lipschitz {
        /// Linear part A, n x n; the sectors are the rest of f (default: both are computed from the Jacobians over the
        /// region).
        a: Option<DMatrix<f64>>[n, n] as Rows,
        /// The nonlinearities.
        sectors: Option<Vec<Sector>> as Tables(&SECTOR),
        /// The box for sectors derived from the Jacobians.
        region: Region as &REGION = Region::everywhere(size.states),
        /// Decay rate to be certified (default 0).
        decay_rate: f64 as Number(NotNegative) = 0.0,
        /// In place of a design: a given gain L, n x p, is analysed.
        gain: Option<DMatrix<f64>>[n, p] as Rows,
        ..[&[MAX_GAIN, NOISE]]
    }
}

const SECTOR: Table = Table {
    name: "sectors",
    about: "A nonlinearity G phi(t, H x, u) whose slope lies between low and high.",
    variants: None,
    keys: Slope::KEYS,
};

crate::keys! {
    struct Slope {
        /// G, n x q.
        g: DMatrix<f64>[n, _] as Rows,
        /// H, q x n.
        h: DMatrix<f64>[_, n] as Rows,
        /// Smallest slope; -gamma for a Lipschitz constant gamma.
        low: f64 as Number(Any),
        /// Largest slope; gamma for a Lipschitz constant gamma.
        high: f64 as Number(Any),
    }
}

impl KeyValue for Vec<Sector> {
    fn read(of: Present<'_>, reader: &mut Reader) -> Option<Self> {
        let read: Vec<_> = of.node.list()?.iter().map(|node| sector(&Given { node, ..*of.given }, reader)).collect();
        read.into_iter().collect()
    }
}

fn sector(given: &Given<'_>, reader: &mut Reader) -> Option<Sector> {
    let Slope { g, h, low, high } = Slope::read(given, reader)?;
    if low > high {
        let message = format!("the sector goes from {low} to {high}");
        reader.absent(check::head(given.node), message, "expected low <= high");
        return None;
    }
    Some(Sector::slope(g, h, low, high))
}

impl Lipschitz {
    /// With A and sectors, or with neither.
    fn checked(self, node: &Node, reader: &mut Reader) -> Option<Self> {
        let ((Some(one), None) | (None, Some(one))) = (node.entry("a"), node.entry("sectors")) else {
            return Some(self);
        };
        let message = format!("`{}` alone: `a` and `sectors` define the plant together", one.key);
        reader.refuse(one.span.clone(), message, "expected both, or neither")
    }
}

impl Specification for Lipschitz {
    declared!();

    fn free_keys(&self) -> &'static [&'static str] {
        &["decay_rate", "gain"]
    }

    fn has_given_gain(&self) -> bool {
        true
    }

    fn decay_rate(&self) -> Option<f64> {
        Some(self.decay_rate)
    }

    fn poses_inequality(&self) -> bool {
        true
    }

    fn region_of_design(&self) -> Option<Region> {
        self.a.is_none().then(|| self.region.clone())
    }

    fn takes_region(&self) -> bool {
        true
    }

    fn faster(&self, factor: f64, _dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self { decay_rate: self.decay_rate * factor, ..self.clone() }.into())
    }
}

impl Kind for Lipschitz {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        lipschitz(plan.study, self, &plan.options())
    }
}

fn lipschitz(study: &Study, spec: &Lipschitz, options: &GainOptions) -> Result<Designed, NoObserver> {
    let Lipschitz { a, sectors, region, decay_rate, gain } = spec;
    let enclosure = enclose(&study.plant.model, region)?;
    let read = LipschitzPlant::over(&enclosure)?;
    let plant = match a.as_ref().zip(sectors.as_ref()) {
        Some((a, sectors)) => read.with_sectors(a.clone(), sectors.clone())?,
        None => read,
    };
    let design = LipschitzDesign::new_with(&plant, gain.as_ref(), *decay_rate, options)?;
    if let Some(sentence) = enclosure.sentence(&design.certificate, region, ("xhat", "t")) {
        return by_sectors(study, &design, Some(sentence), "The sectors enclose the Jacobian over the region.");
    }
    let hypothesis = enclosure.hypothesis(region, "xhat", "t");
    let reading = Reading { plant: Represented::InSectors { hypothesis: &hypothesis }, ..study.plant.reading() };
    let given = design.certificate.sentences(&reading).into_iter().next();
    by_sectors(study, &design, given, "The sectors are those of the study; they are not checked.")
}

/// The report of a design by sectors, with what it proves; `whose` says where they come from.
pub(super) fn by_sectors(
    study: &Study,
    design: &LipschitzDesign,
    sentence: Option<ProvedSentence>,
    whose: &str,
) -> Result<Designed, NoObserver> {
    let count = design.plant.sectors().len();
    let centre = design.plant.centre();
    let noise = NoiseGain::of(study, [(&centre, design.plant.c())], &design.l, None);
    let mut numbers = vec![lower_bound(Quantity::Rate, design.rate), number("sectors", count as f64)];
    numbers.extend(noise.numbers());
    let report = DesignReport {
        statement: Statement::of_proved(sentence).remark(whose),
        matrices: vec![matrix("L", &design.l), proof_matrix("P", &design.p)],
        numbers,
        noise_deviation: noise.deviation,
        ..certified(&design.certificate, &[])
    };
    let observer = design.observer(study.plant.model.clone())?;
    Ok(Designed::new(observer.into(), report, Some(design.certificate.clone())))
}
