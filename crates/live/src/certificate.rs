//! The verdict on an observer whose gains were changed: the theorems of its certificate files, with the same P, for the
//! gains as they are now.

use luenberger_proof::Matrix;
use luenberger_proof::Verdict;
use luenberger_proof::certificate::{CertificateFile, Theorem};

use crate::experiment::{Experiment, Observer, Sliders};

/// What is proved with the gains as they are now.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Certified {
    /// Whether every inequality is proved.
    pub proved: bool,
    /// The smallest positive margin; none if no inequality has one.
    pub margin: Option<f64>,
    /// What is not proved.
    pub fails: Option<String>,
}

impl Certified {
    fn no(fails: &str) -> Self {
        Self { proved: false, margin: None, fails: Some(fails.to_owned()) }
    }
}

/// The verdicts on the observers of an experiment for the gains as the sliders have them; `None` for an observer without
/// certificate.
pub fn verify(experiment: &Experiment, sliders: &Sliders) -> Vec<Option<Certified>> {
    experiment.observers.iter().map(|observer| certified(observer, sliders)).collect()
}

fn certified(observer: &Observer, sliders: &Sliders) -> Option<Certified> {
    if observer.certificates.is_empty() {
        return None;
    }
    let mut all = Certified { proved: true, margin: None, fails: None };
    for file in &observer.certificates {
        let one = theorem(file, sliders);
        if !one.proved {
            return Some(one);
        }
        all.margin = [all.margin, one.margin].into_iter().flatten().reduce(f64::min);
    }
    Some(all)
}

fn theorem(file: &str, sliders: &Sliders) -> Certified {
    let Ok(file) = CertificateFile::read(file.as_bytes()) else {
        return Certified::no("the certificate file cannot be read");
    };
    let mut theorem = file.theorem().clone();
    if sliders.period != 1.0 && !in_continuous_time(&theorem) {
        return Certified::no("the certificate is for the sampling period of the design");
    }
    if (sliders.gain, sliders.cubic) != (1.0, 1.0) && !scale(&mut theorem, sliders) {
        return Certified::no("the certificate is for the gains of the design");
    }
    let Ok(facts) = theorem.facts() else {
        return Certified::no("the theorem does not accept these gains");
    };
    let margins = facts.iter().filter_map(|fact| match &fact.verdict {
        Verdict::Proved { margin } if *margin > 0.0 => Some(*margin),
        _ => None,
    });
    let fails = facts.iter().find(|fact| !fact.verdict.is_proved()).map(|fact| fact.inequality.clone());
    Certified { proved: fails.is_none(), margin: margins.reduce(f64::min), fails }
}

/// Whether the sampling period does not occur in the theorem.
fn in_continuous_time(theorem: &Theorem) -> bool {
    matches!(
        theorem,
        Theorem::LinearConvergence(_)
            | Theorem::JacobianPolytope(_)
            | Theorem::PlantPolytope(_)
            | Theorem::SectorConvergence(_)
            | Theorem::StructuredCubicConvergence(_)
            | Theorem::CubicConvergence(_)
            | Theorem::InputToStateStability(_)
    )
}

/// The theorem for the gains of the sliders; `false` for one whose gains are none of its data, or that binds them to
/// other data.
fn scale(theorem: &mut Theorem, sliders: &Sliders) -> bool {
    let times = |m: &mut Matrix<f64>, factor: f64| *m = m.map(|entry| factor * entry);
    let linear_only = sliders.cubic == 1.0;
    match theorem {
        Theorem::LinearConvergence(data) if linear_only => times(&mut data.l, sliders.gain),
        Theorem::JacobianPolytope(data) if linear_only => times(&mut data.l, sliders.gain),
        Theorem::PlantPolytope(data) if linear_only => times(&mut data.l, sliders.gain),
        Theorem::SectorConvergence(data) if linear_only => times(&mut data.l, sliders.gain),
        Theorem::StructuredCubicConvergence(data) => {
            times(&mut data.l, sliders.gain);
            times(&mut data.s, sliders.cubic);
        }
        Theorem::CubicConvergence(data) => {
            times(&mut data.l, sliders.gain);
            times(&mut data.n, sliders.cubic);
            times(&mut data.s, sliders.cubic);
        }
        _ => return false,
    }
    true
}
