//! The observers of the converter: their states taken apart, and what their constructors refuse.

use luenberger_observers::{Observer, ObserverDimensions, ObserverError};
use luenberger_plants::{CukConverter, PlantError};
use luenberger_reproduce::kkl::cuk;
use nalgebra::{Matrix2, SVector, Vector1, Vector2, Vector4};

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
    let (u, y, wish) = (Vector1::new(0.5), Vector2::new(20.0, -0.25), Vector2::new(0.5, -8.0));
    let start = observer.starting_at(0.125).unwrap();
    let state = start.initial(0.0, &wish, &u, &y);
    let parts = start.parts(&state);
    assert_eq!((parts.w, parts.known, parts.regressor), (y, Vector2::zeros(), Matrix2::zeros()));
    assert_eq!(parts.estimator, [0.125; 2]);
    assert!((start.estimate(0.0, &state, &u, &y) - wish).amax() <= 8.0 * f64::EPSILON * 8.0);
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
