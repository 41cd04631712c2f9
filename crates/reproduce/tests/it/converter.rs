//! The run of section V.C and the observers of Table I.

use luenberger_observers::Observer;
use luenberger_plants::CukConverter;
use luenberger_reproduce::kkl::converter::printed;
use luenberger_reproduce::kkl::converter::runs::{self, OBSERVERS};
use luenberger_reproduce::kkl::cuk::{self, Tuning};
use luenberger_sim::{Integrator, Settings};
use nalgebra::{SVector, Vector1, Vector2};

/// The times at which others compare.
const GOLDEN: [f64; 12] = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.19, 0.205, 0.21, 0.25, 0.39];

/// The noise-free data are good to 1e-9: another order with another kind of method, and tolerances ten times as
/// tight, give the same numbers.
#[test]
fn the_noise_free_data_are_good_to_nine_decimals() {
    let implicit = std::thread::spawn(|| {
        let settings = Settings { integrator: Integrator::Implicit, rtol: 2e-11, atol: 2e-12, ..Settings::default() };
        let scenario = runs::with_all(runs::converter(), None).unwrap();
        scenario.breakpoints(&GOLDEN).settings(settings).times(&GOLDEN).run().unwrap()
    });
    let run = runs::noise_free(runs::settings()).unwrap();
    let tight = Settings { rtol: 1e-13, atol: 1e-14, ..runs::settings() };
    let tight = runs::noise_free(tight).unwrap();
    let implicit = implicit.join().unwrap();
    for (k, t) in GOLDEN.into_iter().enumerate() {
        let row = (t * 1000.0).round() as usize;
        assert!((run.t[row] - t).abs() <= f64::EPSILON);
        for other in [(&tight, row), (&implicit, k)] {
            let difference = (run.x.row(row) - other.0.x.row(other.1)).amax();
            assert!(difference <= 1e-9, "x at {t}: {difference:e}");
            for (name, _) in OBSERVERS {
                let estimates = [&run, other.0].map(|run| &run.observer(name).unwrap().estimate);
                let difference = (estimates[0].row(row) - estimates[1].row(other.1)).amax();
                assert!(difference <= 1e-9, "{name} at {t}: {difference:e}");
            }
        }
    }
}

/// All dynamic extensions from 0, the filters W from the output that the observer sees.
#[test]
fn the_start_is_rest_with_and_without_noise() {
    let noise = runs::noise(3);
    for noise in [None, Some(&noise)] {
        let mut scenario = runs::with_all(runs::converter(), noise).unwrap();
        if let Some(noise) = noise {
            scenario = scenario.noise(noise.clone());
        }
        let run = scenario.times(&[0.0, 1e-4]).run().unwrap();
        for (name, _) in OBSERVERS {
            let state = run.observer(name).unwrap().state.row(0).clone_owned();
            // w(0) = y(0) of the filters stands behind xi, of length 2; the rest is 0 up to the rounding of C2 y
            // and of G L3 y2/C4.
            let filters = match name {
                "pebo" => 2..4,
                "kkl_peb" => 2..3,
                _ => 0..0,
            };
            for (k, entry) in state.iter().enumerate() {
                if filters.contains(&k) {
                    assert!((entry - run.y[(0, k - 2)]).abs() <= 0.02 && *entry != 0.0, "{name}, entry {k}: {entry}");
                } else {
                    assert!(entry.abs() <= 4.0 * f64::EPSILON * 20.0, "{name}, entry {k}: {entry}");
                }
            }
        }
    }
}

/// The printed KKLO is right, and the printed PEBO, [KKL+PEB]O and I&IO agree with the corrected ones wherever the
/// misprints have no effect.
#[test]
fn the_printed_observers_differ_by_their_misprints_only() {
    let (plant, tuning) = (CukConverter::default(), Tuning::default());
    let (u, y) = (Vector1::new(0.4), Vector2::new(20.0, -0.5));
    // Terms of 20 V over 10 mH, and of 0.5 A over 22 uF: their rounding.
    let close = |a: f64, b: f64| (a - b).abs() <= 64.0 * f64::EPSILON * (1e5 + a.abs());
    // xi, and w of the filters: the first four and the first three entries in both.
    let printed = printed::Pebo::new(plant, tuning);
    let state = SVector::<f64, 9>::from([1.0, -9.0, 19.0, -0.4, 0.0, 0.0, 0.0, 0.5, -6.0]);
    let right = cuk::pebo(plant, &tuning).unwrap();
    let full = SVector::<f64, 12>::from([1.0, -9.0, 19.0, -0.4, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, -6.0]);
    let slopes = (printed.derivative(0.0, &state, &u, &y), right.derivative(0.0, &full, &u, &y));
    assert!((0..4).all(|k| close(slopes.0[k], slopes.1[k])), "{} {}", slopes.0, slopes.1);
    let estimates = (printed.estimate(0.0, &state, &u, &y), right.estimate(0.0, &full, &u, &y));
    assert!((estimates.0 - estimates.1).amax() <= 64.0 * f64::EPSILON * 20.0);
    // With xi1 = xi2 the [KKL+PEB]O's misprint has no effect.
    let printed = printed::KklPeb::new(plant, tuning);
    let state = SVector::<f64, 6>::from([0.7, 0.7, 19.0, 0.1, 0.2, 0.5]);
    let right = cuk::kkl_pebo(plant, &tuning).unwrap();
    // There `F[g]` and `F[m]` are with 1/C2: (xi, w, F[g], F[m], theta).
    let full = SVector::<f64, 6>::from([0.7, 0.7, 19.0, 0.2 / plant.c2, 0.1 / plant.c2, 0.5]);
    let slopes = (printed.derivative(0.0, &state, &u, &y), right.derivative(0.0, &full, &u, &y));
    let filters = [slopes.0[4] / plant.c2, slopes.0[3] / plant.c2];
    assert!([0, 1, 2, 5].into_iter().all(|k| close(slopes.0[k], slopes.1[k])), "{} {}", slopes.0, slopes.1);
    assert!(close(filters[0], slopes.1[3]) && close(filters[1], slopes.1[4]));
    // With i3 = 0 the I&IO's.
    let y = Vector2::new(20.0, 0.0);
    let printed = printed::ImmersionInvariance::new(plant, tuning);
    let right = cuk::immersion_invariance(plant, &tuning).unwrap();
    let chi = Vector2::new(0.6, -8.0);
    let slopes = (printed.derivative(0.0, &chi, &u, &y), right.derivative(0.0, &chi, &u, &y));
    assert!(close(slopes.0[0], slopes.1[0]) && close(slopes.0[1], slopes.1[1]), "{} {}", slopes.0, slopes.1);
    // With y = (xi1, xi3) the time-varying high-gain observer's.
    let printed = printed::HighGain::time_varying(plant, tuning);
    let right = cuk::high_gain_time_varying(plant, &tuning).unwrap();
    let xi = nalgebra::Vector4::new(20.0, 0.5, 0.0, -7.0);
    let slopes = (printed.derivative(0.0, &xi, &u, &y), right.derivative(0.0, &xi, &u, &y));
    assert!((0..4).all(|k| close(slopes.0[k], slopes.1[k])), "{} {}", slopes.0, slopes.1);
}
