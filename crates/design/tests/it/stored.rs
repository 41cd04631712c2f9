//! Designs stored as certificate files and read again.

use luenberger_design::{
    Certified, CubicDesign, CubicGain, DiscreteDesign, GainOptions, GeneralizedPlant, LinearDesign, NormFilterDesign,
    NormTarget, SampledCubicDesign, StoredDesign, StoredError, StoredObserver, SystemNorm, TimeDomain,
};
use luenberger_plants::{StateSpace, double_integrator};
use luenberger_proof::certificate::{CertificateFile, LinearConvergence, PlantWithin, Rejection};
use luenberger_proof::{Interval, Matrix};
use nalgebra::dmatrix;

fn linear() -> LinearDesign {
    LinearDesign::with_poles(&double_integrator().to_dynamic(), &[-2.0, -5.0]).unwrap()
}

fn stored(design: &impl Certified) -> StoredDesign {
    let file = design.certificate_file("a design").unwrap().to_json();
    let stored = StoredDesign::read(file.as_bytes()).unwrap();
    assert_eq!(stored.title, "a design");
    assert_eq!(stored.certificate(), design.certificate());
    stored
}

#[test]
fn designs_come_back_with_their_certificates() {
    let design = CubicDesign::new(&linear(), &dmatrix![1.0], &CubicGain::Gamma(3.0)).unwrap();
    assert_eq!(stored(&design).observer, StoredObserver::Cubic(design.observer.clone()));
    let design = SampledCubicDesign::new(&linear(), &dmatrix![1.0], 2.0, 0.1).unwrap();
    assert_eq!(stored(&design).observer, StoredObserver::SampledCubic(design.observer.clone()));
    let plant = StateSpace::new(dmatrix![1.0, 0.5; 0.0, 1.0], dmatrix![0.0; 0.5], dmatrix![1.0, 0.0]).unwrap();
    let design = DiscreteDesign::with_poles(&plant, 0.5, &[0.5, 0.4]).unwrap();
    let StoredObserver::Discrete { plant: read, l } = stored(&design).observer else { panic!("of another kind") };
    assert_eq!((read, &l), (plant, design.l()));
}

/// `x' = -x + w1`, `y = x + w2`, and the same matrices in discrete time with a pole at 0.5.
#[test]
fn filters_of_a_norm_come_back() {
    let of = GeneralizedPlant { e: dmatrix![1.0, 0.0], d: dmatrix![0.0, 1.0], h: dmatrix![1.0] };
    for (time, pole) in [(TimeDomain::Continuous, -1.0), (TimeDomain::Discrete, 0.5)] {
        let plant = StateSpace::new(dmatrix![pole], dmatrix![2.0], dmatrix![1.0]).unwrap();
        for norm in [SystemNorm::HInfinity, SystemNorm::H2] {
            let options = GainOptions::default();
            let design = NormFilterDesign::new(&plant, time, norm, &of, &NormTarget::Least, &options).unwrap();
            let expected = match time {
                TimeDomain::Continuous => StoredObserver::Linear(design.observer().unwrap()),
                TimeDomain::Discrete => StoredObserver::Discrete { plant: plant.clone(), l: design.l().clone() },
            };
            assert_eq!(stored(&design).observer, expected);
            let is_continuous = time == TimeDomain::Continuous;
            assert_eq!(design.observer().is_ok(), is_continuous);
            assert_eq!(design.discrete_observer(0.1).is_ok(), !is_continuous);
        }
    }
}

#[test]
fn false_files_and_files_without_an_observer_are_refused() {
    let file = linear().certificate_file("a design").unwrap();
    let bytes = file.to_json();
    for length in [0, 1, bytes.len() / 2, bytes.len() - 3] {
        assert!(matches!(StoredDesign::read(&bytes.as_bytes()[..length]), Err(StoredError::Rejected(_))));
    }
    // A margin that is too large, with a digest that agrees.
    let mut claims = file.claims().to_vec();
    claims[0].margin = claims[1].margin.clone();
    let forged = file.with_claims(&claims).unwrap().to_json();
    assert!(matches!(
        StoredDesign::read(forged.as_bytes()),
        Err(StoredError::Rejected(Rejection::Margin { .. } | Rejection::NotProved { .. }))
    ));
    let entry = |lo, hi| Matrix::from_fn(1, 1, |_, _| Interval::new(lo, hi).unwrap());
    let plant = PlantWithin::within(&entry(-1.25, -1.0), &entry(0.0, 0.0), &entry(1.0, 1.0)).unwrap();
    let (l, p) = (Matrix::from_rows([[1.0]]), Matrix::from_rows([[1.0]]));
    let bounds = CertificateFile::prove("bounds", LinearConvergence { plant, l, p, rate: 0.0 }).unwrap().to_json();
    assert_eq!(
        StoredDesign::read(bounds.as_bytes()).unwrap_err().to_string(),
        "A(1, 1) of the plant is given by bounds: the observer needs a number"
    );
}
