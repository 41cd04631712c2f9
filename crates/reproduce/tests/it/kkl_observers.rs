//! The observers of the converter: parts of their states, and errors of their constructors.

use luenberger_observers::diagnosis::{Diagnose, Diagnosis};
use luenberger_observers::{Observer, ObserverDimensions, ObserverError};
use luenberger_plants::{CukConverter, ExponentialCascade, Plant, PlantError};
use luenberger_reproduce::kkl::cuk;
use luenberger_reproduce::kkl::exponential_cascade::{self, LOWEST};
use nalgebra::{Matrix2, SVector, Vector1, Vector2, Vector3, Vector4};
use proptest::prelude::*;

/// The states of the [KKL+PEB] observers come apart as they were put together, and start where they must.
#[test]
fn states_come_apart() {
    let plant = CukConverter::default();
    let observer = cuk::pebo(plant, &cuk::Tuning::default()).unwrap();
    assert_eq!(observer.dimensions(), ObserverDimensions { state: 12, inputs: 1, outputs: 2, estimate: 2 });
    let state = SVector::<f64, 12>::from_fn(|i, _| i as f64);
    let parts = observer.parts(&state);
    assert_eq!(
        (parts.xi, parts.w, parts.known),
        (Vector2::new(0.0, 1.0), Vector2::new(2.0, 3.0), Vector2::new(4.0, 5.0))
    );
    assert_eq!((parts.regressor, parts.estimator), (Matrix2::new(6.0, 8.0, 7.0, 9.0), &[10.0, 11.0][..]));
    let (u, y, xhat) = (Vector1::new(0.5), Vector2::new(20.0, -0.25), Vector2::new(0.5, -8.0));
    let start = observer.starting_at(0.125).unwrap();
    let state = start.initial(0.0, &xhat, &u, &y);
    let parts = start.parts(&state);
    assert_eq!((parts.w, parts.known, parts.regressor), (y, Vector2::zeros(), Matrix2::zeros()));
    assert_eq!(parts.estimator, [0.125; 2]);
    assert!((start.estimate(0.0, &state, &u, &y) - xhat).amax() <= 8.0 * f64::EPSILON * 8.0);
    // W[y] = 0 at the start: Y = M theta holds as 0 = 0.
    assert_eq!(start.regression(0.0, &state, &y), (Vector2::zeros(), Matrix2::zeros()));
}

#[test]
fn what_does_not_fit_is_refused() {
    let good = CukConverter::default();
    let bad = CukConverter { c2: -1e-6, ..good };
    let expected = ObserverError::Matrix(PlantError::NotPositive { what: "C2", value: -1e-6 });
    assert_eq!(cuk::kklo(bad).err(), Some(expected));
    let tuning = cuk::Tuning::<f64>::default();
    assert!(matches!(cuk::pebo(good, &cuk::Tuning { alpha: 0.0, ..tuning }), Err(ObserverError::NotPositive { .. })));
    assert!(matches!(
        cuk::pebo(good, &cuk::Tuning { gains: [1.0, -1.0], ..tuning }),
        Err(ObserverError::NotDefinite { .. })
    ));
    assert!(matches!(
        cuk::immersion_invariance(good, &cuk::Tuning { g1: f64::NAN, ..tuning }),
        Err(ObserverError::Matrix(_))
    ));
    // 1/r^2 is not a number any more.
    let tiny = cuk::Tuning { r1: 1e-200, ..tuning };
    assert!(matches!(
        cuk::high_gain_time_varying(good, &tiny),
        Err(ObserverError::NotPositive { what: "alpha/r^j", .. })
    ));
    assert!(cuk::high_gain_exact(good, &tuning).unwrap().starting_at(Vector4::repeat(f64::INFINITY)).is_err());
    assert!(cuk::pebo(good, &tuning).unwrap().starting_at(f64::NAN).is_err());
}

/// Theta_hat of Proposition 6 at the end of its domain: held, reported, and no NaN.
#[test]
fn theta_of_proposition_6_stays_in_its_domain() {
    let observer = exponential_cascade::observer(1.0, 5.0).unwrap();
    let u = Vector1::new(0.0);
    // psi = 1 and Y = alpha (y - w) - F[-y^3] = -3: the estimator pulls Theta_hat to -3 at the rate 5 (3 + Theta_hat).
    let state = |theta: f64| SVector::<f64, 6>::from([0.0, 0.0, 3.0, 0.0, 1.0, theta]);
    let y = Vector1::new(0.0);
    let slope = observer.derivative(0.0, &state(0.5), &u, &y);
    assert_eq!(slope[5], -17.5);
    assert_eq!(
        observer.diagnose(0.0, &state(0.5), &u, &y),
        Diagnosis::LeavingDomain { parameter: 0, value: 0.5, bound: LOWEST, time: (LOWEST - 0.5) / -17.5 }
    );
    for theta in [LOWEST, 0.0, -1.0, -1e300] {
        assert_eq!(
            observer.diagnose(0.0, &state(theta), &u, &y),
            Diagnosis::LeftDomain { parameter: 0, value: theta, bound: LOWEST }
        );
        assert!(observer.derivative(0.0, &state(theta), &u, &y)[5] >= 0.0);
        assert_eq!(observer.estimate(0.0, &state(theta), &u, &y), Vector2::new(0.0, LOWEST.ln()));
    }
    // It finds its way back when the regression says so.
    assert!(observer.derivative(0.0, &state(-1.0), &u, &Vector1::new(9.0))[5] > 0.0);
    // exp(xi2) overflows at 710: that entry stands still, and says so.
    let mut wild = state(1.0);
    wild[1] = 800.0;
    assert!(observer.derivative(0.0, &wild, &u, &y).iter().all(|entry| entry.is_finite()));
    assert_eq!(observer.diagnose(0.0, &wild, &u, &y), Diagnosis::Overflow { entry: 4 });
}

proptest! {
    /// (37) of Proposition 6: where Y = psi Theta, with x3 = xi2 + ln Theta, it stays so along the plant, whatever the
    /// filters have seen; W starts at y, where Y = 0.
    #[test]
    fn the_regression_of_proposition_6_stays_exact(
        x in prop::array::uniform3(-2.0..2.0f64).prop_map(Vector3::from), xi in prop::array::uniform2(-2.0..2.0f64), known in -5.0..5.0f64,
        psi in 0.0..5.0f64, u in (-2.0..2.0f64).prop_map(Vector1::new), alpha in 0.5..4.0f64,
    ) {
        let observer = exponential_cascade::observer(alpha, 5.0).unwrap();
        let y = ExponentialCascade.output(0.0, &x, &u);
        let rate: Vector3<f64> = ExponentialCascade.derivative(0.0, &x, &u);
        let theta = (x[2] - xi[1]).exp();
        let w = y[0] - (known + psi * theta) / alpha;
        let state = SVector::<f64, 6>::from([xi[0], xi[1], w, known, psi, 1.0]);
        // Theta is below exp(4).
        let rounding = 64.0 * f64::EPSILON * alpha * (alpha + 1.0) * 400.0;
        let (value, m) = observer.regression(0.0, &state, &y);
        prop_assert!((value[0] - m[0] * theta).abs() <= rounding, "{value} {m}");
        let slope = observer.derivative(0.0, &state, &u, &y);
        let deviation = alpha * (rate[0] - slope[2]) - slope[3] - slope[4] * theta;
        prop_assert!(deviation.abs() <= rounding, "{deviation}");
        // xhat' of x2 and x3, with Theta_hat in the place of Theta.
        let estimate = observer.estimate(0.0, &state, &u, &y);
        prop_assert_eq!(estimate, Vector2::new(xi[0], xi[1]));
        let start = observer.initial(0.0, &estimate, &u, &y);
        prop_assert_eq!(observer.regression(0.0, &start, &y).0[0], 0.0);
        prop_assert_eq!(observer.estimate(0.0, &start, &u, &y), estimate);
    }
}
