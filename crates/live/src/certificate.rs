//! The verdict on an observer whose gains were changed: the theorems of its certificate files, with the same P, for the
//! gains as they are now.

use luenberger_proof::Matrix;
use luenberger_proof::Verdict;
use luenberger_proof::certificate::{CertificateFile, Theorem};

use crate::experiment::{Experiment, Observer, Sliders};

/// What is proved with the gains as they are now.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum GainVerdict {
    /// Every inequality, with the smallest positive margin if one has a margin.
    Proved(Option<f64>),
    /// This is not proved.
    Open(String),
    /// The certificate is one that a page does not verify: its verdict is in the report.
    Elsewhere,
}

/// Whether a page verifies certificates of this theorem.
pub fn verifies(theorem: &Theorem) -> bool {
    scale(&mut theorem.clone(), &Sliders::NEUTRAL)
}

/// The verdicts on the observers of an experiment for the gains as the sliders have them; `None` for an observer without
/// certificate.
pub fn verify(experiment: &Experiment, sliders: &Sliders) -> Vec<Option<GainVerdict>> {
    let sliders = experiment.fitted(sliders);
    experiment.observers.iter().map(|observer| certified(observer, &sliders)).collect()
}

fn certified(observer: &Observer, sliders: &Sliders) -> Option<GainVerdict> {
    let Some(files) = &observer.certificates else {
        // The report's verdict is on the gains of the report.
        let moved = (sliders.gain, sliders.cubic, sliders.period) != (1.0, 1.0, 1.0);
        return Some(if moved { open(OF_DESIGN) } else { GainVerdict::Elsewhere });
    };
    let mut least: Option<f64> = None;
    for file in files {
        match theorem(file, sliders) {
            GainVerdict::Proved(margin) => least = [least, margin].into_iter().flatten().reduce(f64::min),
            other => return Some(other),
        }
    }
    (!files.is_empty()).then_some(GainVerdict::Proved(least))
}

fn theorem(file: &str, sliders: &Sliders) -> GainVerdict {
    let Ok(file) = CertificateFile::read(file.as_bytes()) else {
        return open("the certificate file cannot be read");
    };
    let mut theorem = file.theorem().clone();
    if sliders.period != 1.0 && !in_continuous_time(&theorem) {
        return open("the certificate is for the sampling period of the design");
    }
    if (sliders.gain, sliders.cubic) != (1.0, 1.0) && !scale(&mut theorem, sliders) {
        return open(OF_DESIGN);
    }
    let Ok(facts) = theorem.facts() else {
        return open("the theorem does not accept these gains");
    };
    let margins = facts.iter().filter_map(|fact| match &fact.verdict {
        Verdict::Proved { margin } if *margin > 0.0 => Some(*margin),
        _ => None,
    });
    match facts.iter().find(|fact| !fact.verdict.is_proved()) {
        None => GainVerdict::Proved(margins.reduce(f64::min)),
        Some(fact) => GainVerdict::Open(fact.inequality.clone()),
    }
}

/// Why nothing is proved for other gains, where the page has no theorem for them.
const OF_DESIGN: &str = "the certificate is for the gains of the design";

fn open(what: &str) -> GainVerdict {
    GainVerdict::Open(what.to_owned())
}

/// Whether the sampling period does not occur in the theorem.
fn in_continuous_time(theorem: &Theorem) -> bool {
    !matches!(theorem, Theorem::SampledCubicConvergence(_) | Theorem::SemiImplicitCubicConvergence(_))
}

/// The theorem for the gains of the sliders; `false` for one whose gains are none of its data, or that binds them to
/// other data.
fn scale(theorem: &mut Theorem, sliders: &Sliders) -> bool {
    let times = |m: &mut Matrix<f64>, factor: f64| *m = m.map(|entry| factor * entry);
    match theorem {
        Theorem::LinearConvergence(data) => times(&mut data.l, sliders.gain),
        Theorem::DiscreteConvergence(data) => times(&mut data.l, sliders.gain),
        Theorem::DiscreteJacobianPolytope(data) => times(&mut data.l, sliders.gain),
        Theorem::JacobianPolytope(data) => times(&mut data.l, sliders.gain),
        Theorem::PlantPolytope(data) => times(&mut data.l, sliders.gain),
        Theorem::SectorConvergence(data) => times(&mut data.l, sliders.gain),
        Theorem::StructuredCubicConvergence(data) => {
            times(&mut data.l, sliders.gain);
            times(&mut data.s, sliders.cubic);
        }
        Theorem::CubicConvergence(data) => {
            times(&mut data.l, sliders.gain);
            times(&mut data.n, sliders.cubic);
            times(&mut data.s, sliders.cubic);
        }
        Theorem::SampledCubicConvergence(data) => {
            times(&mut data.l, sliders.gain);
            times(&mut data.n, sliders.cubic);
            data.w *= sliders.cubic;
        }
        Theorem::SemiImplicitCubicConvergence(data) => {
            times(&mut data.l, sliders.gain);
            times(&mut data.n, sliders.cubic);
            times(&mut data.s, sliders.cubic);
        }
        _ => return false,
    }
    true
}
