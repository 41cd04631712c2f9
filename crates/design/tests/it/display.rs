//! Designs as text: the gains, other numbers of the design, the poles, and each inequality with its verdict.

use std::fmt::Display;

use luenberger_design::{
    Certified, CubicDesign, CubicGain, DecoupledPlant, DisturbanceBounds, ErrorCoordinates, EstimationProblem,
    GainOptions, GeneralizedPlant, IntervalDesign, IntervalRequirements, LinearDesign, NormFilterDesign, NormTarget,
    OptimalCubicDesign, Periods, ReducedOrderDesign, SampledIntervalDesign, SuperTwistingDesign, SystemNorm,
    TimeDomain, UnknownInputDesign, VaryingPeriodDesign,
};
use luenberger_plants::{StateSpace, double_integrator};
use luenberger_proof::statement::Format;
use nalgebra::dmatrix;

fn plant() -> StateSpace {
    double_integrator().to_dynamic()
}

fn linear() -> LinearDesign {
    LinearDesign::with_poles(&plant(), &[-2.0, -5.0]).unwrap()
}

/// The text ends with the certificate; the names before it, at the start of lines.
fn names(design: &(impl Certified + Display)) -> Vec<String> {
    let (text, certificate) = (design.to_string(), design.certificate().to_string());
    let numbers = text.strip_suffix(&certificate).unwrap_or_else(|| panic!("{text}"));
    assert!(certificate.contains("Proved"), "{certificate}");
    numbers.lines().map(|line| line.split([' ', '=']).next().unwrap_or_default().to_owned()).collect()
}

#[test]
fn linear_and_cubic_designs() {
    let cubic = CubicDesign::new(&linear(), &dmatrix![10.0], &CubicGain::Gamma(0.5)).unwrap();
    assert_eq!(names(&linear()), ["L", "poles"]);
    assert_eq!(names(&cubic), ["L", "N", "theta"]);
    let text = linear().to_string();
    assert!(
        text.starts_with("L = [7; 10]\npoles -2, -5\n") || text.starts_with("L = [7; 10]\npoles -5, -2\n"),
        "{text}"
    );
    assert!(text.contains("Proved     P > 0, margin >= "), "{text}");
    assert!(cubic.to_string().contains("\ntheta = [10]\n"), "{cubic}");

    let problem = EstimationProblem::new(&[1.0, 2.0], &[0.05], 0.01, 20.0);
    let optimal = OptimalCubicDesign::new(&plant(), &problem, None).unwrap();
    let gains: &[&str] = if optimal.cubic.is_some() { &["L", "N", "theta"] } else { &["L"] };
    assert_eq!(names(&optimal), [gains, &["cost", "cost", "poles"]].concat());
}

#[test]
fn filters_and_observers_of_lower_order() {
    let reduced = ReducedOrderDesign::with_poles(&plant(), &[-4.0]).unwrap();
    assert_eq!(names(&reduced), ["F", "G", "H", "M", "N", "poles"]);
    assert!(reduced.to_string().starts_with("F = [-4]\n"), "{reduced}");

    let of = GeneralizedPlant { e: dmatrix![0.0, 0.0; 1.0, 0.0], d: dmatrix![0.0, 1.0], h: dmatrix![1.0, 0.0] };
    let (time, norm, goal) = (TimeDomain::Continuous, SystemNorm::H2, NormTarget::Least);
    let filter = NormFilterDesign::new(&plant(), time, norm, &of, &goal, &GainOptions::default()).unwrap();
    assert_eq!(names(&filter), ["L", "norm", "proved", "poles"]);
    // Kalman's filter of intensity 1 has P = [sqrt 2, 1; 1, sqrt 2], and the norm is sqrt P_11.
    assert!(filter.to_string().contains("\nnorm 1.18921\nproved to be below 1.18"), "{filter}");
}

#[test]
fn designs_against_disturbances() {
    let stable = StateSpace::new(dmatrix![0.0, 1.0; -1.0, -2.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]).unwrap();
    let decoupled = DecoupledPlant::new(&stable, &dmatrix![1.0; 0.0]).unwrap();
    let rest = LinearDesign::lmi(&decoupled.reduced).unwrap();
    assert_eq!(names(&UnknownInputDesign::linear(&decoupled, &rest).unwrap()), ["L", "H"]);
    let rest = CubicDesign::new(&rest, &dmatrix![1.0], &CubicGain::Gamma(1.0)).unwrap();
    assert_eq!(names(&UnknownInputDesign::cubic(&decoupled, &rest).unwrap()), ["L", "N", "theta", "H"]);

    let acting = DisturbanceBounds::of_states_and_outputs(&dmatrix![0.0; 1.0], &[0.1], &[0.01]);
    let interval = IntervalDesign::new(&linear().observer, &acting, ErrorCoordinates::Modal, &[1.0, 1.0]).unwrap();
    assert_eq!(names(&interval), ["L", "T", "half-widths"]);

    let sampled = StateSpace::new(dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1], dmatrix![1.0, 0.0]).unwrap();
    let (initial_error, estimates, inputs) = (vec![1.0; 2], vec![10.0; 2], vec![1.0]);
    let required = IntervalRequirements { initial_error, estimates, inputs, format: Format::Binary32 };
    let (l, modal) = (dmatrix![0.9; 2.0], ErrorCoordinates::Modal);
    let interval = SampledIntervalDesign::of_discrete(&sampled, 0.1, &l, &acting, modal, &required).unwrap();
    assert_eq!(names(&interval), ["L", "T", "half-widths"]);

    let periods = Periods { shortest: 0.08, longest: 0.13, misses: 1 };
    let jitter = VaryingPeriodDesign::new(&linear(), &dmatrix![1.0], &CubicGain::Radial(10.0), 0.1, &periods).unwrap();
    assert_eq!(names(&jitter), ["K", "N", "theta", "factor"]);

    let sliding = SuperTwistingDesign::new([2.1, 1.1], 1.0).unwrap().unwrap();
    assert_eq!(names(&sliding), ["P", "alpha,"]);
}
