//! Every kind of bad input gets an error that names the quantity and its value.

use luenberger_design::mean_value::MeanValueDesign;
use luenberger_design::{
    CubicDesign, CubicGain, DesignError, DisturbanceBounds, ErrorBound, ErrorCoordinates, FeedbackDesign, GainOptions,
    GeneralizedPlant, IntervalDesign, IntervalRequirements, LinearDesign, LyapunovWeight, NormFilterDesign, NormTarget,
    SampledIntervalDesign, SystemNorm, TimeDomain, cubic_lmi_design, robust,
};
use luenberger_linalg::LinalgError;
use luenberger_plants::{PlantError, StateSpace, double_integrator};
use luenberger_proof::statement::Format;
use nalgebra::{Complex, DMatrix, dmatrix};

fn plant() -> StateSpace {
    double_integrator().to_dynamic()
}

fn linear() -> LinearDesign {
    LinearDesign::with_poles_and_weight(&plant(), &[-2.0, -5.0], LyapunovWeight::Identity(10.0)).unwrap()
}

fn refused_poles(poles: &[f64]) -> DesignError {
    LinearDesign::with_poles(&plant(), poles).unwrap_err()
}

fn refused_gain(l: &DMatrix<f64>) -> DesignError {
    LinearDesign::with_gain(&plant(), l).unwrap_err()
}

#[test]
fn a_pole_in_the_right_half_plane_is_named() {
    let error = refused_poles(&[-1.0, 0.5]);
    assert_eq!(error, DesignError::UnstablePole { pole: Complex::new(0.5, 0.0) });
    assert!(error.to_string().contains("0.5"));
    // On the boundary an error never decays.
    assert_eq!(refused_poles(&[-1.0, 0.0]), DesignError::UnstablePole { pole: Complex::new(0.0, 0.0) });
}

#[test]
fn a_pole_that_is_nan_is_refused() {
    assert!(LinearDesign::with_poles(&plant(), &[-1.0, f64::NAN]).is_err());
}

#[test]
fn poles_must_be_closed_under_conjugation_and_n_in_number() {
    let lonely = LinearDesign::with_poles(&plant(), &[Complex::new(-1.0, 1.0), Complex::new(-1.0, 2.0)]).unwrap_err();
    assert!(matches!(lonely, DesignError::Linalg(_)));
    assert!(matches!(refused_poles(&[-1.0]), DesignError::Linalg(_)));
}

#[test]
fn an_unobservable_plant_names_its_hidden_mode() {
    // The second state is seen by nothing and decays like exp(-t).
    let plant = StateSpace::new(dmatrix![1.0, 0.0; 0.0, -1.0], dmatrix![1.0; 1.0], dmatrix![1.0, 0.0]).unwrap();
    let error = LinearDesign::with_poles(&plant, &[-2.0, -3.0]).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("-1"), "{text}");
}

#[test]
fn an_undetectable_plant_names_its_mode_in_every_design() {
    let plant = StateSpace::new(dmatrix![-1.0, 0.0; 0.0, 2.0], dmatrix![1.0; 1.0], dmatrix![1.0, 0.0]).unwrap();
    for error in [
        LinearDesign::lmi(&plant).unwrap_err(),
        cubic_lmi_design(&plant, &dmatrix![1.0], 0.0, 1.0).unwrap_err(),
        LinearDesign::kalman(&plant, &DMatrix::identity(2, 2), &dmatrix![1.0]).unwrap_err(),
    ] {
        let DesignError::NotDetectable { eigenvalue, .. } = error else { panic!("{error}") };
        assert!((eigenvalue - Complex::new(2.0, 0.0)).norm() < 1e-9, "{eigenvalue}");
    }
}

#[test]
fn a_rate_that_a_hidden_mode_does_not_have_is_refused_with_that_mode() {
    let plant = StateSpace::new(dmatrix![-1.0, 0.0; 0.0, 2.0], dmatrix![1.0; 1.0], dmatrix![0.0, 1.0]).unwrap();
    assert!(LinearDesign::with_decay_rate(&plant, 0.5).is_ok());
    let error = LinearDesign::with_decay_rate(&plant, 1.5).unwrap_err();
    let DesignError::NotDetectable { eigenvalue, .. } = error else { panic!("{error}") };
    assert!((eigenvalue - Complex::new(-1.0, 0.0)).norm() < 1e-9, "{eigenvalue}");
}

#[test]
fn a_gain_of_ones_own_is_checked() {
    assert!(
        matches!(refused_gain(&dmatrix![-1.0; 0.0]), DesignError::NotHurwitz { what: "A - L C", abscissa } if abscissa >= 0.0)
    );
    assert!(matches!(
        refused_gain(&dmatrix![1.0, 2.0]),
        DesignError::Matrix(PlantError::DimensionMismatch { what: "L", expected: (2, 1), found: (1, 2) })
    ));
    assert!(matches!(
        refused_gain(&dmatrix![1.0; f64::NAN]),
        DesignError::Matrix(PlantError::NotFinite { what: "L", .. })
    ));
}

#[test]
fn q_must_be_symmetric_and_positive_definite() {
    let weighted = |weight| LinearDesign::with_poles_and_weight(&plant(), &[-2.0, -5.0], weight).unwrap_err();
    let with = |q| weighted(LyapunovWeight::Matrix(q));
    assert!(matches!(
        with(dmatrix![1.0, 0.5; 0.0, 1.0]),
        DesignError::Linalg(LinalgError::NotSymmetric { what: "Q", .. })
    ));
    assert!(matches!(
        with(dmatrix![1.0, 2.0; 2.0, 1.0]),
        DesignError::Linalg(LinalgError::NotPositiveDefinite { what: "Q", lambda_min }) if (lambda_min + 1.0).abs() < 1e-12
    ));
    assert!(matches!(
        weighted(LyapunovWeight::Identity(-1.0)),
        DesignError::NotPositive { what, value: -1.0 } if what.starts_with("rho")
    ));
}

#[test]
fn theta_gamma_and_s_are_checked() {
    let with = |theta: DMatrix<f64>, correction| CubicDesign::new(&linear(), &theta, &correction).unwrap_err();
    assert!(matches!(
        with(dmatrix![-1.0], CubicGain::Gamma(1.0)),
        DesignError::Linalg(LinalgError::NotPositiveSemidefinite { what: "theta", lambda_min: -1.0 })
    ));
    for gamma in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(with(dmatrix![1.0], CubicGain::Gamma(gamma)), DesignError::NotPositive { what: "gamma", .. }));
        assert!(matches!(with(dmatrix![1.0], CubicGain::Radial(gamma)), DesignError::NotPositive { what: "w", .. }));
    }
    assert!(matches!(
        with(dmatrix![1.0], CubicGain::General(dmatrix![-0.5])),
        DesignError::Linalg(LinalgError::NotPositiveSemidefinite { what: "S + S'", lambda_min: -1.0 })
    ));
    assert!(matches!(with(DMatrix::identity(2, 2), CubicGain::Gamma(1.0)), DesignError::Matrix(_)));
}

#[test]
fn a_feedback_that_does_not_stabilise_is_refused() {
    let cubic = CubicDesign::new(&linear(), &dmatrix![1.0], &CubicGain::Gamma(1.0)).unwrap();
    assert!(matches!(
        FeedbackDesign::cubic(&cubic, &dmatrix![-1.0, -1.0]).unwrap_err(),
        DesignError::NotHurwitz { what: "A - B K", .. }
    ));
}

#[test]
fn a_cubic_gain_of_the_wrong_sign_is_named() {
    let design = CubicDesign::new(&linear(), &dmatrix![10.0], &CubicGain::Gamma(2.0)).unwrap();
    let (f, l, n) = (design.error_matrix(), design.l(), -&design.observer.n);
    for error in [
        robust::certify_gain(&plant(), l, &n).unwrap_err(),
        robust::fixed_gain_margin(&plant(), l, &n, 1e-3).unwrap_err(),
        robust::positive_real_margin(&f, &design.observer.c, &n).unwrap_err(),
    ] {
        assert!(matches!(error, DesignError::Infeasible { .. }), "{error}");
        assert!(error.to_string().contains("C N"), "{error}");
    }
}

/// theta = diag(1, 0) makes N rank-deficient: admissible, but not decided by the method for gains without a P.
#[test]
fn a_gain_that_the_method_does_not_decide_is_not_called_infeasible() {
    let plant =
        StateSpace::new(dmatrix![0.1, 1.0; -1.0, 0.2], DMatrix::zeros(2, 0), dmatrix![1.0, 0.0; 0.0, 1.0]).unwrap();
    let linear = LinearDesign::with_poles(&plant, &[-1.0, -2.0]).unwrap();
    let cubic = CubicDesign::new(&linear, &dmatrix![1.0, 0.0; 0.0, 0.0], &CubicGain::Gamma(1.0)).unwrap();
    let error = robust::certify_gain(&plant, cubic.l(), &cubic.observer.n).unwrap_err();
    assert!(matches!(error, DesignError::DegenerateGain { .. }), "{error}");
}

#[test]
fn a_rate_that_is_no_rate_is_refused_by_every_design() {
    for rate in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            cubic_lmi_design(&plant(), &dmatrix![1.0], rate, 1.0).unwrap_err(),
            DesignError::BadRate { .. }
        ));
        let polytope = robust::PolytopicDesign::new(&plant(), &[plant().a], rate).unwrap_err();
        assert!(matches!(polytope, DesignError::BadRate { .. }));
    }
}

/// The fields of a plant are public, so its shapes can change after the constructor has checked them.
#[test]
fn a_plant_that_was_bent_after_its_construction_is_refused() {
    let mut bent = plant();
    bent.c = dmatrix![1.0, 0.0, 0.0];
    assert!(matches!(LinearDesign::with_gain(&bent, &dmatrix![1.0; 1.0]).unwrap_err(), DesignError::Matrix(_)));
    assert!(matches!(cubic_lmi_design(&bent, &dmatrix![1.0], 0.0, 1.0).unwrap_err(), DesignError::Matrix(_)));
    assert!(matches!(
        robust::certify_gain(&bent, &dmatrix![1.0; 1.0], &dmatrix![1.0; 1.0]).unwrap_err(),
        DesignError::Matrix(_)
    ));
}

/// Each is refused by its name, not by a symbol of the method that it spoils later.
#[test]
fn bounds_of_disturbances_are_checked_where_they_enter() {
    let observer = linear().observer.clone();
    let e = dmatrix![0.0; 1.0];
    let acting = |bound: f64| DisturbanceBounds::of_states_and_outputs(&e, &[bound], &[0.01]);
    let interval = |acting: &DisturbanceBounds, first: &[f64]| {
        IntervalDesign::new(&observer, acting, ErrorCoordinates::Modal, first).unwrap_err().to_string()
    };
    let bound = "the bound of a disturbance is";
    assert!(interval(&acting(-0.3), &[1.0, 1.0]).starts_with(&format!("{bound} -0.3")));
    assert!(interval(&acting(f64::NAN), &[1.0, 1.0]).starts_with(&format!("{bound} NaN")));
    assert!(interval(&acting(0.3), &[1.0, -1.0]).starts_with("a half-width of x(0) is -1"));
    let two = DisturbanceBounds { bounds: vec![0.1, 0.2, 0.3], ..acting(0.1) };
    let count = "3 bounds of disturbances are given, for 2 columns of E and 2 columns of D";
    assert_eq!(interval(&two, &[1.0, 1.0]), count);
    assert_eq!(ErrorBound::linear(&observer, &two).unwrap_err().to_string(), count);
    let plant = StateSpace::new(dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1], dmatrix![1.0, 0.0]).unwrap();
    let sampled = |disturbance: f64, noise: f64, first: f64| {
        let required = IntervalRequirements {
            initial_error: vec![first; 2],
            estimates: vec![10.0; 2],
            inputs: vec![1.0],
            format: Format::Binary64,
        };
        let acting = DisturbanceBounds::of_states_and_outputs(&e, &[disturbance], &[noise]);
        let (l, modal) = (dmatrix![0.9; 2.0], ErrorCoordinates::Modal);
        SampledIntervalDesign::of_discrete(&plant, 0.1, &l, &acting, modal, &required).unwrap_err().to_string()
    };
    assert!(sampled(-0.2, 0.1, 1.0).starts_with(bound));
    assert!(sampled(0.2, f64::NAN, 1.0).starts_with("the bound of the noise of an output is NaN"));
    assert!(sampled(0.2, 0.1, -1.0).starts_with("a half-width of x(0) is -1"));
}

#[test]
fn an_error_of_which_nothing_counts_has_no_norm() {
    let of = GeneralizedPlant { e: dmatrix![0.0, 0.0; 1.0, 0.0], d: dmatrix![0.0, 1.0], h: DMatrix::zeros(1, 2) };
    for h in [DMatrix::zeros(1, 2), DMatrix::zeros(0, 2)] {
        let of = GeneralizedPlant { h, ..of.clone() };
        for norm in [SystemNorm::HInfinity, SystemNorm::H2] {
            let goal = NormTarget::Below(1.0);
            let error =
                NormFilterDesign::new(&plant(), TimeDomain::Continuous, norm, &of, &goal, &GainOptions::default());
            assert!(error.unwrap_err().to_string().starts_with("the largest entry of H"), "{norm:?}");
        }
    }
}

#[test]
fn outputs_of_a_mean_value_design_are_some_of_the_states() {
    let vertex = dmatrix![-1.0, 0.5; 0.0, -2.0];
    for outputs in [0, 3] {
        let error = MeanValueDesign::new(std::slice::from_ref(&vertex), outputs, 0.5).unwrap_err();
        assert_eq!(error, DesignError::OutputCount { outputs, states: 2 });
    }
    let error = MeanValueDesign::new(&[vertex, dmatrix![-1.0]], 1, 0.5).unwrap_err().to_string();
    assert!(error.contains("a vertex of the Jacobians"), "{error}");
}
