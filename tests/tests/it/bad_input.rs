//! Invalid input and unusual units in the whole chain from a plant to a simulation.

use luenberger_design::{
    CubicDesign, CubicGain, FeedbackDesign, LinearDesign, LyapunovWeight, SampledCubicDesign, cubic_lmi_design, robust,
};
use luenberger_linalg as linalg;
use luenberger_plants::{PlantError, StateSpace, double_integrator};
use luenberger_sim::{Scenario, SimError};
use nalgebra::{Complex, DMatrix, dmatrix};

/// What is wrong with a square matrix that something is asked of.
fn bad_matrices() -> Vec<DMatrix<f64>> {
    vec![
        DMatrix::zeros(0, 0),
        DMatrix::zeros(2, 3),
        dmatrix![f64::NAN, 0.0; 0.0, -1.0],
        dmatrix![-1.0, f64::INFINITY; 0.0, -1.0],
        dmatrix![-1.0, 0.0; f64::NEG_INFINITY, -1.0],
    ]
}

#[test]
fn every_matrix_function_refuses_what_is_not_a_finite_square_matrix() {
    let i = DMatrix::identity(2, 2);
    let poles = [Complex::new(-1.0, 0.0), Complex::new(-2.0, 0.0)];
    for a in bad_matrices() {
        // An empty matrix has a Schur form, a spectrum and an exponential; nothing else.
        assert!(linalg::schur(&a).is_err() || a.is_empty());
        assert!(linalg::eigenvalues(&a).is_err() || a.is_empty());
        assert!(linalg::lyapunov(&a, &i).is_err());
        assert!(linalg::stein(&a, &i).is_err());
        assert!(linalg::sylvester(&a, &i, &i).is_err());
        assert!(linalg::care(&a, &i, &i, &i).is_err());
        assert!(linalg::dare(&a, &i, &i, &i).is_err());
        assert!(linalg::kalman_gain(&a, &i, &i, &i).is_err());
        assert!(linalg::observability(&a, &i).is_err());
        assert!(linalg::detectability(&a, &i).is_err());
        assert!(linalg::place(&a, &i, &poles).is_err());
        assert!(linalg::place_observer(&a, &i, &poles).is_err());
        assert!(linalg::expm(&a).is_err() || a.is_empty());
        assert!(linalg::zero_order_hold(&a, &i, 0.1).is_err());
        assert!(linalg::lambda_min(&a).is_err());
        assert!(linalg::spectral_abscissa(&a).is_err());
        // The same mistakes in the second argument.
        assert!(linalg::lyapunov(&-&i, &a).is_err());
        assert!(linalg::stein(&(&i * 0.5), &a).is_err());
        assert!(linalg::care(&i, &i, &a, &i).is_err());
        assert!(linalg::care(&i, &i, &i, &a).is_err());
    }
}

#[test]
fn a_plant_names_what_does_not_fit() {
    let c = dmatrix![1.0, 0.0];
    for (a, b, c) in [
        (DMatrix::zeros(2, 3), DMatrix::zeros(2, 1), c.clone()),
        (DMatrix::zeros(2, 2), DMatrix::zeros(3, 1), c.clone()),
        (DMatrix::zeros(2, 2), DMatrix::zeros(2, 1), dmatrix![1.0, 0.0, 0.0]),
        (DMatrix::zeros(0, 0), DMatrix::zeros(0, 1), DMatrix::zeros(1, 0)),
        (DMatrix::zeros(2, 2), DMatrix::zeros(2, 1), DMatrix::zeros(0, 2)),
        (dmatrix![f64::NAN, 0.0; 0.0, 0.0], DMatrix::zeros(2, 1), c),
    ] {
        let error = StateSpace::new(a, b, c).unwrap_err();
        assert!(
            matches!(
                error,
                PlantError::DimensionMismatch { .. } | PlantError::NotFinite { .. } | PlantError::Empty { .. }
            ),
            "{error}"
        );
    }
}

/// One state, one output, every design.
#[test]
fn a_plant_of_one_state_goes_the_whole_way() {
    let plant = StateSpace::new(dmatrix![2.0], dmatrix![1.0], dmatrix![3.0]).unwrap();
    let linear = LinearDesign::with_poles(&plant, &[-1.0]).unwrap();
    assert!((linear.l()[(0, 0)] - 1.0).abs() < 1e-15);
    let cubic = CubicDesign::new(&linear, &dmatrix![1.0], &CubicGain::Gamma(1.0)).unwrap();
    assert!(cubic.certificate.is_proved(), "{}", cubic.certificate);
    assert!(FeedbackDesign::cubic(&cubic, &dmatrix![5.0]).unwrap().certificate.is_proved());
    assert!(SampledCubicDesign::new(&linear, &dmatrix![1.0], 1.0, 0.1).unwrap().certificate.is_proved());
    assert!(cubic_lmi_design(&plant, &dmatrix![1.0], 1.0, 1.0).unwrap().certificate.is_proved());
    let (f, c, n) = (cubic.error_matrix(), &cubic.observer.c, &cubic.observer.n);
    assert!((robust::positive_real_margin(&f, c, n).unwrap() - 1.0).abs() < 1e-12);
    let margin = robust::fixed_gain_margin(&plant, cubic.l(), n, 1e-6).unwrap().margin;
    assert!((margin - 1.0).abs() < 1e-5, "{margin}");
}

/// Every output measured: p = n, so that the kernel of C is empty and even (13) can be strict.
#[test]
fn a_plant_whose_state_is_measured_goes_the_whole_way() {
    let plant =
        StateSpace::new(dmatrix![0.5, 1.0; -1.0, 0.5], DMatrix::zeros(2, 0), dmatrix![1.0, 0.3; 0.0, 2.0]).unwrap();
    let linear = LinearDesign::with_poles(&plant, &[-1.0, -2.0]).unwrap();
    let cubic = CubicDesign::new(&linear, &DMatrix::identity(2, 2), &CubicGain::Radial(1.0)).unwrap();
    assert!(cubic.certificate.is_proved(), "{}", cubic.certificate);
    let margin = robust::fixed_gain_margin(&plant, cubic.l(), &cubic.observer.n, 1e-3).unwrap().margin;
    assert!(margin > 0.5, "{margin}");
}

/// The double integrator in units of time and length far from one: the same observer, in those units.
#[test]
fn the_units_do_not_matter() {
    for (time, length) in [(1e-12, 1.0), (1e12, 1.0), (1.0, 1e12), (1.0, 1e-12), (1e-6, 1e6)] {
        // x2 is a velocity: x1' = x2 per unit of time; y is x1 in other units.
        let plant =
            StateSpace::new(dmatrix![0.0, 1.0 / time; 0.0, 0.0], dmatrix![0.0; 1.0], dmatrix![length, 0.0]).unwrap();
        let linear =
            LinearDesign::with_poles_and_weight(&plant, &[-2.0 / time, -5.0 / time], LyapunovWeight::Identity(10.0))
                .unwrap();
        let expected = dmatrix![7.0; 10.0] / (time * length);
        let relative = (linear.l() - &expected).amax() / expected.amax();
        assert!(relative < 1e-12, "time {time:e}, length {length:e}: {}", linear.l());
        let cubic = CubicDesign::new(&linear, &dmatrix![1.0], &CubicGain::Gamma(1.0)).unwrap();
        assert!(cubic.certificate.is_proved(), "time {time:e}, length {length:e}\n{}", cubic.certificate);
        let lmi = LinearDesign::with_decay_rate(&plant, 1.0 / time).unwrap();
        assert!(lmi.certificate.is_proved(), "time {time:e}, length {length:e}\n{}", lmi.certificate);
    }
}

#[test]
fn an_unobservable_plant_names_its_mode_and_the_direction_no_output_sees() {
    // Two equal tanks, of which only the sum is measured.
    let plant = StateSpace::new(dmatrix![-1.0, 0.0; 0.0, -1.0], dmatrix![1.0; 0.0], dmatrix![1.0, 1.0]).unwrap();
    let report = linalg::observability(&plant.a, &plant.c).unwrap();
    assert_eq!((report.rank, report.is_observable()), (1, false));
    let hidden = &report.unobservable[0];
    assert!((hidden.eigenvalue + Complex::new(1.0, 0.0)).norm() < 1e-12);
    assert!((hidden.direction[0] + hidden.direction[1]).norm() < 1e-12, "{}", hidden.direction);
    assert!(LinearDesign::with_poles(&plant, &[-2.0, -3.0]).is_err());
    // It is detectable, and the Kalman gain exists.
    assert!(LinearDesign::kalman(&plant, &DMatrix::identity(2, 2), &dmatrix![1.0]).unwrap().certificate.is_proved());
}

#[test]
fn a_run_refuses_what_does_not_fit() {
    let scenario = || Scenario::new(double_integrator()).until(1.0, 11);
    assert!(matches!(scenario().initial_state(&[1.0]).run(), Err(SimError::Length { .. })));
    assert!(matches!(scenario().initial_state(&[1.0, f64::NAN]).run(), Err(SimError::NotFinite { .. })));
    assert!(matches!(Scenario::new(double_integrator()).until(0.0, 2).run(), Err(SimError::TimeSpan { .. })));
    assert!(Scenario::new(double_integrator()).until(f64::NAN, 2).run().is_err());
    assert!(matches!(scenario().times(&[0.0, 2.0, 1.0]).run(), Err(SimError::TimesUnsorted { .. })));
}
