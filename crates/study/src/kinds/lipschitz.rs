//! A copy of a nonlinear plant with a gain for all nonlinearities within sectors (Thau, Rajamani, circle criterion).

use luenberger_design::enclosure::enclose;
use luenberger_design::{GainOptions, LipschitzDesign, LipschitzPlant, Region, Sector};
use luenberger_proof::certificate::{ProvedSentence, Reading, Represented};
use luenberger_proof::wording::counted;
use nalgebra::DMatrix;

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::keys::{MAX_GAIN, NOISE, REGION, SECTOR};
use super::{Kind, as_kind};
use crate::keys::{Range, Type, optional};
use crate::reader::gain::this_gain;
use crate::reader::region::region;
use crate::reader::tree::Node;
use crate::reader::{Given, Reader, check};
use crate::results::{DesignReport, NoObserver, Quantity, Statement};
use crate::study::{ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::noise_gain::NoiseGain;
use crate::synthesis::{Designed, Plan, certified, lower_bound, matrix, number};
use crate::tuning::{nonlinear, over_region};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "lipschitz",
    about: "Copy of a nonlinear plant with a gain for all nonlinearities within sectors (Thau, Rajamani, circle criterion).",
    source: "Thau 1973, Rajamani 1998, Arcak and Kokotovic 2001",
    plant: PlantClass::Nonlinear(Time::CONTINUOUS),
    keys: &[&[
        optional(
            "a",
            Type::Rows,
            "Linear part A, n x n; the sectors are the rest of f (default: both are computed from the Jacobians over the region).",
        ),
        optional("sectors", Type::Tables(&SECTOR), "The nonlinearities."),
        REGION,
        optional("decay_rate", Type::Number(Range::NotNegative), "Decay rate to be certified (default 0)."),
        optional("gain", Type::Rows, "In place of a design: a given gain L, n x p, is analysed."),
        MAX_GAIN,
        NOISE,
    ]],
    kind: as_kind::<Lipschitz>,
    read,
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

fn read(given: &Given<'_>, reader: &mut Reader) -> Option<ObserverKind> {
    let (node, size) = (given.node, given.size());
    let n = size.states;
    let region = region(node, size, reader);
    let gain = node.given("gain", |gain| this_gain(gain, size, reader))?;
    let split = match (node.entry("a"), node.entry("sectors")) {
        (None, None) => None,
        (Some(a), Some(sectors)) => {
            let of_states = format!("the plant has {}", counted(n, "state"));
            let a = reader.matrix(&a.node, "a", (Some(n), Some(n)), &of_states);
            let sectors: Vec<Option<Sector>> =
                sectors.node.list()?.iter().map(|node| sector(node, n, reader)).collect();
            Some((a?, sectors.into_iter().collect::<Option<Vec<_>>>()?))
        }
        (Some(one), None) | (None, Some(one)) => {
            let message = format!("`{}` alone: `a` and `sectors` define the plant together", one.key);
            return reader.refuse(one.span.clone(), message, "expected both, or neither");
        }
    };
    Some(Lipschitz { split, region: region?, rate: given.number_or("decay_rate", 0.0)?, gain }.into())
}

fn sector(node: &Node, n: usize, reader: &mut Reader) -> Option<Sector> {
    let why = format!("the plant has {}", counted(n, "state"));
    let g = reader.matrix(node.get("g")?, "g", (Some(n), None), &why);
    let h = reader.matrix(node.get("h")?, "h", (None, Some(n)), &why);
    let (low, high) = (node.get("low")?.number()?, node.get("high")?.number()?);
    if low > high {
        reader.absent(check::head(node), format!("the sector goes from {low} to {high}"), "expected low <= high");
        return None;
    }
    Some(Sector::slope(g?, h?, low, high))
}

/// One gain for all nonlinearities within given sectors.
#[derive(Debug, Clone, PartialEq)]
pub struct Lipschitz {
    /// A and the sectors, if given.
    pub split: Option<(DMatrix<f64>, Vec<Sector>)>,
    /// The box for sectors derived from the Jacobians.
    pub region: Region,
    /// The rate.
    pub rate: f64,
    /// A given gain.
    pub gain: Option<DMatrix<f64>>,
}

impl Specification for Lipschitz {
    declared!();

    fn has_given_gain(&self) -> bool {
        true
    }

    fn decay_rate(&self) -> Option<f64> {
        Some(self.rate)
    }

    fn poses_inequality(&self) -> bool {
        true
    }

    fn region_of_design(&self) -> Option<Region> {
        self.split.is_none().then(|| self.region.clone())
    }

    fn takes_region(&self) -> bool {
        true
    }

    fn faster(&self, factor: f64, _dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self { rate: self.rate * factor, ..self.clone() }.into())
    }
}

impl Kind for Lipschitz {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let Self { split, region, rate, gain } = self;
        lipschitz(plan.study, split.as_ref(), region, *rate, gain.as_ref(), &plan.options())
    }
}

fn lipschitz(
    study: &Study,
    split: Option<&(DMatrix<f64>, Vec<Sector>)>,
    region: &Region,
    rate: f64,
    gain: Option<&DMatrix<f64>>,
    options: &GainOptions,
) -> Result<Designed, NoObserver> {
    let enclosure = enclose(&study.plant.model, region)?;
    let read = LipschitzPlant::over(&enclosure)?;
    let plant = match split {
        Some((a, sectors)) => read.with_sectors(a.clone(), sectors.clone())?,
        None => read,
    };
    let design = LipschitzDesign::new_with(&plant, gain, rate, options)?;
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
        matrices: vec![matrix("L", &design.l), matrix("P", &design.p)],
        numbers,
        noise_deviation: noise.deviation,
        ..certified(&design.certificate, &[])
    };
    let observer = design.observer(study.plant.model.clone())?;
    Ok(Designed::new(observer.into(), report, Some(design.certificate.clone())))
}
