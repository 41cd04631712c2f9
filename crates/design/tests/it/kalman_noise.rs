//! Kalman filters for noise that enters by G and is correlated with that of the measurement, against scipy 1.17.1
//! (`solve_continuous_are`, `solve_discrete_are` with `s`; integrals by `quad_vec`).

use luenberger_design::{DesignError, DiscreteDesign, KalmanNoise, LinearDesign, LyapunovWeight};
use luenberger_linalg::LinalgError;
use luenberger_plants::StateSpace;
use nalgebra::{DMatrix, dmatrix};

fn plant(a: DMatrix<f64>) -> StateSpace {
    StateSpace::new(a, dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]).unwrap()
}

/// A force on the second state, and a sensor that feels it.
fn noise() -> KalmanNoise {
    KalmanNoise::new(&dmatrix![2.0], &dmatrix![0.1]).entering(&dmatrix![0.0; 1.0]).cross(&dmatrix![0.3])
}

#[track_caller]
fn near(found: &DMatrix<f64>, expected: &DMatrix<f64>) {
    assert!((found - expected).amax() < 1e-12 * expected.amax(), "{found}{expected}");
}

#[test]
fn in_continuous_time() {
    let plant = plant(dmatrix![0.0, 1.0; -2.0, -3.0]);
    let filter = LinearDesign::kalman_of(&plant, &noise(), LyapunovWeight::FirstProved).unwrap();
    near(filter.l(), &dmatrix![0.316_624_790_355_399_25; 3.050_125_628_933_802]);
    let p = dmatrix![
        0.031_662_479_035_539_93, 0.005_012_562_893_380_19; 0.005_012_562_893_380_19, 0.174_937_185_533_099_37
    ];
    near(filter.covariance().unwrap(), &p);
    assert!(filter.certificate.is_proved(), "{}", filter.certificate);
    // With the information matrix as P as well.
    let filter = LinearDesign::kalman_of(&plant, &noise(), LyapunovWeight::InverseCovariance).unwrap();
    assert!(filter.certificate.is_proved(), "{}", filter.certificate);
    near(&(&filter.p * p), &DMatrix::identity(2, 2));
    // Without S and G it is the filter as before.
    let (w, v) = (dmatrix![0.0, 0.0; 0.0, 2.0], dmatrix![0.1]);
    let entering = KalmanNoise { s: None, ..noise() };
    let first = LinearDesign::kalman(&plant, &w, &v).unwrap();
    let same = LinearDesign::kalman_of(&plant, &entering, LyapunovWeight::FirstProved).unwrap();
    assert_eq!(first.l(), same.l());
}

#[test]
fn in_discrete_time() {
    let plant = plant(dmatrix![0.9, 0.1; 0.0, 0.8]);
    let filter = DiscreteDesign::kalman_of(&plant, 1.0, &noise()).unwrap();
    near(filter.l(), &dmatrix![0.471_164_250_717_785_9; 2.317_363_298_553_732]);
    near(filter.update_gain().unwrap(), &dmatrix![0.436_465_755_606_720_96; 0.783_450_706_717_369]);
    assert!(filter.certificate.is_proved(), "{}", filter.certificate);
}

/// The noise of a period and the mean of the measurement noise over it have `int_0^h e^{As} ds G S / h` in common.
#[test]
fn of_a_sampled_plant() {
    let plant = plant(dmatrix![0.0, 1.0; -2.0, -3.0]);
    let filter = DiscreteDesign::sampled_kalman_of(&plant, 0.1, &noise()).unwrap();
    near(filter.l(), &dmatrix![0.045_991_425_873_162_84; 0.247_944_045_487_201_17]);
    near(filter.update_gain().unwrap(), &dmatrix![0.032_712_365_285_120_07; 0.005_061_004_765_386_23]);
    // For a short period it is the continuous filter: L/h there.
    let short = DiscreteDesign::sampled_kalman_of(&plant, 1e-5, &noise()).unwrap();
    let continuous = LinearDesign::kalman_of(&plant, &noise(), LyapunovWeight::FirstProved).unwrap();
    assert!((short.l() * 1e5 - continuous.l()).amax() < 1e-4, "{}", short.l());
}

#[test]
fn what_is_wrong_is_named() {
    let plant = plant(dmatrix![0.0, 1.0; -2.0, -3.0]);
    let refused = |noise: &KalmanNoise| {
        let continuous = LinearDesign::kalman_of(&plant, noise, LyapunovWeight::FirstProved).unwrap_err();
        let discrete = DiscreteDesign::kalman_of(&plant, 1.0, noise).unwrap_err();
        assert_eq!(std::mem::discriminant(&continuous), std::mem::discriminant(&discrete));
        continuous.to_string()
    };
    let more = refused(&noise().cross(&dmatrix![0.5]));
    assert!(more.contains("[W, S; S', V] is not positive semidefinite"), "{more}");
    let long = refused(&noise().entering(&dmatrix![0.0; 1.0; 0.0]));
    assert!(long.contains("G must be 2 x 1, found 3 x 1"), "{long}");
    let wide = refused(&noise().cross(&dmatrix![0.3, 0.1]));
    assert!(wide.contains("S must be 1 x 1, found 1 x 2"), "{wide}");
    // A W that is indefinite although `G W G'` is not.
    let hidden =
        KalmanNoise::new(&dmatrix![1.0, 0.0; 0.0, -1.0], &dmatrix![1.0]).entering(&dmatrix![0.0, 0.0; 1.0, 0.0]);
    let found = LinearDesign::kalman_of(&plant, &hidden, LyapunovWeight::FirstProved).unwrap_err();
    assert!(matches!(found, DesignError::Linalg(LinalgError::NotPositiveSemidefinite { what: "W", .. })), "{found}");
}
