//! Loops of observers and their margins against numpy and scipy; observers and frequencies by hand.

use luenberger_linalg::{
    FrequencyAxis, FrequencyResponse, LinalgError, LoopMargins, LoopTransfer, ObserverTransfer, Realization,
    StabilityMargins,
};
use nalgebra::{Complex, DMatrix, dmatrix};
use std::f64::consts::PI;

fn near(found: f64, expected: f64, relative: f64) -> bool {
    (found - expected).abs() <= relative * expected.abs()
}

fn close(found: &DMatrix<Complex<f64>>, expected: &[(f64, f64)]) {
    for (k, (re, im)) in expected.iter().enumerate() {
        let at = found[(k / found.ncols(), k % found.ncols())];
        assert!((at - Complex::new(*re, *im)).norm() < 1e-13, "{k}: {at}");
    }
}

fn at(plant: &Realization, w: f64, discrete: bool) -> DMatrix<Complex<f64>> {
    let response = if discrete { FrequencyResponse::discrete(plant) } else { FrequencyResponse::continuous(plant) };
    response.unwrap().at(w)
}

fn two_by_two() -> (Realization, DMatrix<f64>, DMatrix<f64>) {
    let plant = Realization::new(
        &dmatrix![0.0, 1.0, 0.0; -2.0, -0.4, 1.0; 0.5, 0.0, -1.0],
        &dmatrix![0.0, 0.0; 1.0, 0.0; 0.0, 2.0],
        &dmatrix![1.0, 0.0, 0.0; 0.0, 0.0, 1.0],
        &dmatrix![0.0, 0.1; 0.0, 0.0],
    );
    (plant.unwrap(), dmatrix![8.0, 0.3; 20.0, 1.0; 1.0, 4.0], dmatrix![3.0, 2.5, 0.5; 0.2, 0.3, 4.0])
}

/// Two inputs and outputs, with feedthrough. numpy 2.4: products of `H` and `G`, each from its own solve; the margins
/// of a channel by scipy's `brentq` on `1/S_ii - 1`; peaks of S and T from a grid of 60 000 frequencies, refined by
/// `minimize_scalar`.
#[test]
fn a_loop_of_two_channels() {
    let (plant, l, k) = two_by_two();
    let transfer = LoopTransfer::new(&plant, &l, &k).unwrap();
    close(
        &at(&transfer.at_inputs, 0.7, false),
        &[
            (0.9842356460701678, 0.3369963447136629),
            (2.4073666224692767, -0.626096031026676),
            (0.3086493117026663, -0.3676054673842833),
            (1.7008103935049597, -2.032411583539957),
        ],
    );
    close(
        &at(&transfer.at_outputs, 0.7, false),
        &[
            (1.0377566379468737, 0.30554175892466107),
            (1.2320646528764019, -1.4597554307273861),
            (0.6500733874482512, -0.22339959692850936),
            (1.6472894016282538, -2.000956997750955),
        ],
    );
    let margins = LoopMargins::continuous(&transfer.at_inputs).unwrap();
    let (s, t) = (margins.sensitivity.unwrap(), margins.complementary.unwrap());
    assert!(near(s.norm, 1.6120707044317528, 1e-9) && near(s.frequency, 5.168071596406722, 1e-4), "{s:?}");
    assert!(near(t.norm, 1.0441411932783728, 1e-9) && near(t.frequency, 1.602024546551235, 1e-4), "{t:?}");
    let [first, second] = &margins.channels[..] else { panic!("{margins:?}") };
    channel(
        first,
        &[(0.7925259174218292, -2.517412650896808), (2.298360876625058, 1.1552280582969403)],
        &[(6.986124083474487, 6.9206192040995145)],
    );
    channel(second, &[(2.110323594674961, 1.874249526603792)], &[]);
    let (low, high) = margins.guaranteed_gain().unwrap();
    assert!(near(low, 1.6120707044317528 / 2.6120707044317528, 1e-9));
    assert!(near(high, 1.6120707044317528 / 0.6120707044317528, 1e-8));
    assert!(near(margins.guaranteed_phase().unwrap(), 2.0 * (0.5_f64 / 1.6120707044317528).asin(), 1e-9));

    let margins = LoopMargins::continuous(&transfer.at_outputs).unwrap();
    let (s, t) = (margins.sensitivity.unwrap(), margins.complementary.unwrap());
    assert!(near(s.norm, 1.3811050079794596, 1e-9) && near(t.norm, 0.9781486456866513, 1e-9), "{s:?} {t:?}");
    channel(
        &margins.channels[0],
        &[(0.7741091024035771, -2.5196226867798686), (2.294832387945993, 1.159474279331285)],
        &[(6.076794275610558, 6.251117216894414)],
    );
    channel(&margins.channels[1], &[(2.113924407544242, 1.8719180811565037)], &[]);
}

/// Crossovers with their angles, and phase crossovers with their factors.
fn channel(found: &StabilityMargins, phase: &[(f64, f64)], gain: &[(f64, f64)]) {
    assert_eq!((found.phase.len(), found.gain.len()), (phase.len(), gain.len()), "{found:?}");
    for (margin, (frequency, angle)) in found.phase.iter().zip(phase) {
        assert!(near(margin.frequency, *frequency, 1e-11) && near(margin.angle, *angle, 1e-11), "{margin:?}");
    }
    for (margin, (frequency, factor)) in found.gain.iter().zip(gain) {
        assert!(near(margin.frequency, *frequency, 1e-10) && near(margin.factor, *factor, 1e-10), "{margin:?}");
    }
}

/// In discrete time, numpy and scipy likewise.
#[test]
fn a_loop_in_discrete_time() {
    let a = dmatrix![0.9, 0.2; -0.1, 0.8];
    let plant = Realization::new(&a, &dmatrix![0.1; 0.5], &dmatrix![1.0, 0.0], &dmatrix![0.0]).unwrap();
    let transfer = LoopTransfer::new(&plant, &dmatrix![0.9; 0.5], &dmatrix![0.4, 0.6]).unwrap();
    for open in [&transfer.at_inputs, &transfer.at_outputs] {
        close(&at(open, 0.7, true), &[(-0.1670130363279815, -0.0594052674919019)]);
        let margins = LoopMargins::discrete(open).unwrap();
        let (s, t) = (margins.sensitivity.unwrap(), margins.complementary.unwrap());
        assert!(near(s.norm, 1.2041391961595382, 1e-9) && near(s.frequency, 0.6280923352723162, 1e-4), "{s:?}");
        assert!(near(t.norm, 0.4020024771862203, 1e-9) && near(t.frequency, 0.26029481025803397, 1e-4), "{t:?}");
        channel(&margins.channels[0], &[], &[(0.8463706899875243, 7.234678678644739)]);
    }
}

/// By hand: the double integrator with poles at -2 and -5, y through `(7 s + 10, 10 s)/(s^2 + 7 s + 10)`, u through
/// `(1, s + 7)` over the same, v to the error as y with the other sign.
#[test]
fn transfer_functions_of_an_observer() {
    let a = dmatrix![0.0, 1.0; 0.0, 0.0];
    let plant = Realization::new(&a, &dmatrix![0.0; 1.0], &dmatrix![1.0, 0.0], &dmatrix![0.0]).unwrap();
    let transfer = ObserverTransfer::new(&plant, &dmatrix![7.0; 10.0]).unwrap();
    for w in [0.1, 1.0, 30.0] {
        let s = Complex::new(0.0, w);
        let below = s * s + s * 7.0 + 10.0;
        let expected = [s * 7.0 + 10.0, Complex::from(1.0), s * 10.0, s + 7.0].map(|above| above / below);
        let expected = expected.map(|z| (z.re, z.im));
        close(&at(&transfer.estimate, w, false), &expected);
        let noise = [expected[0], expected[2]].map(|(re, im)| (-re, -im));
        close(&at(&transfer.noise_to_error, w, false), &noise);
    }
}

/// A closed loop that is not stable has no peaks; its margins are those of the crossovers still.
#[test]
fn an_unstable_loop_has_no_peak() {
    let integrator = Realization::new(&dmatrix![0.0], &dmatrix![-1.0], &dmatrix![1.0], &dmatrix![0.0]).unwrap();
    let found = LoopMargins::continuous(&integrator).unwrap();
    assert!(found.sensitivity.is_none() && found.complementary.is_none() && found.guaranteed_phase().is_none());
    assert!(!found.channels[0].is_stable && found.poles == [Complex::from(1.0)]);
    assert!(near(found.channels[0].phase[0].frequency, 1.0, 1e-15));
}

#[test]
fn frequencies_show_the_features() {
    let light = [Complex::new(-0.01, 3.0), Complex::new(-0.01, -3.0), Complex::from(-100.0), Complex::from(0.0)];
    let found = FrequencyAxis::new(None).grid(&light, [None; 2], 50);
    assert!(near(found[0], 0.1 * 9.0001f64.sqrt(), 1e-14) && near(found[found.len() - 1], 1000.0, 1e-12));
    assert!(found.len() == 51 && found.contains(&3.0) && found.windows(2).all(|pair| pair[0] < pair[1]));
    let found = FrequencyAxis::new(Some(1.0)).grid(&[Complex::from(0.9)], [None; 2], 20);
    assert!(near(found[0], 0.1 * -(0.9f64.ln()), 1e-12) && found[19] == PI);
    assert_eq!(FrequencyAxis::new(None).grid(&[], [None; 2], 2), [0.1, 10.0]);
    let found = FrequencyAxis::new(None).grid(&light, [Some(2.0), Some(8.0)], 3);
    assert!(found.len() == 4 && found[0] == 2.0 && found[1] == 3.0 && near(found[2], 4.0, 1e-15) && found[3] == 8.0);
    assert_eq!(FrequencyAxis::new(None).grid(&light, [Some(1e5), None], 2), [1e5, 1e7]);
    assert_eq!(FrequencyAxis::new(None).grid(&light, [None, Some(1e-3)], 2), [1e-5, 1e-3]);
    // The same in other units of time.
    let slow = FrequencyAxis::new(None).grid(&light.map(|s| s * 1e-12), [None; 2], 50);
    assert!(near(slow[7], FrequencyAxis::new(None).grid(&light, [None; 2], 50)[7] * 1e-12, 1e-12));
}

#[test]
fn mistakes_of_loops_are_named() {
    let (plant, l, k) = two_by_two();
    let of_k = LoopTransfer::new(&plant, &l, &l).unwrap_err();
    assert!(matches!(of_k, LinalgError::DimensionMismatch { what: "K", expected: (2, 3), found: (3, 2) }), "{of_k}");
    let of_l = ObserverTransfer::new(&plant, &k).unwrap_err();
    assert!(matches!(of_l, LinalgError::DimensionMismatch { what: "L", .. }), "{of_l}");
    let nan = LoopTransfer::new(&plant, &(&l * f64::NAN), &k).unwrap_err();
    assert!(matches!(nan, LinalgError::NotFinite { what: "L", .. }), "{nan}");
    // An algebraic loop: 1 + D = 0.
    let one = dmatrix![1.0];
    let algebraic = Realization::new(&-&one, &one, &one, &-&one).unwrap();
    let refused = LoopMargins::continuous(&algebraic).unwrap_err();
    assert!(matches!(refused, LinalgError::Singular { what: "I + D", .. }), "{refused}");
    let wide = Realization::new(&one, &dmatrix![1.0, 1.0], &one, &dmatrix![0.0, 0.0]).unwrap();
    let refused = LoopMargins::discrete(&wide).unwrap_err();
    assert!(matches!(refused, LinalgError::DimensionMismatch { what: "the loop", .. }), "{refused}");
}

/// The filter form: at high frequencies the estimate is that of the measurement alone, and for a state that is measured
/// without delay from one sample to the next, x+ = x + w with K = 1/2, y passes as `z/(2 z - 1)`.
#[test]
fn a_filter_in_discrete_time() {
    let one = dmatrix![1.0];
    let plant = Realization::new(&one, &one, &one, &dmatrix![0.25]).unwrap();
    let transfer = ObserverTransfer::with_update(&plant, &dmatrix![0.5], &dmatrix![0.5]).unwrap();
    for w in [0.2, 1.0, 3.0] {
        let z = Complex::from_polar(1.0, w);
        let found = at(&transfer.estimate, w, true);
        assert!((found[(0, 0)] - z / (z * 2.0 - 1.0)).norm() < 1e-15);
        // From u: through x+ = x + u, and with y - D u in the place of y.
        let expected = (Complex::from(1.0 - 0.125) - (z - 0.5) * 0.125 * 2.0) / (z * 2.0 - 1.0);
        assert!((found[(0, 1)] - expected).norm() < 1e-15, "{found}, {expected}");
        assert!((at(&transfer.noise_to_error, w, true)[(0, 0)] + z / (z * 2.0 - 1.0)).norm() < 1e-15);
    }
}

/// The double integrator with the observer and the regulator of poles -2, -5 and -1, -1, by hand: the loop is
/// `(27 s + 10)/(s^2 (s^2 + 9 s + 25))`, -9/65 where `w^2 = 65/3`. The poles at 0, which rounding moves, are no margin.
#[test]
fn poles_at_the_origin_are_no_margin() {
    let a = dmatrix![0.0, 1.0; 0.0, 0.0];
    let plant = Realization::new(&a, &dmatrix![0.0; 1.0], &dmatrix![1.0, 0.0], &dmatrix![0.0]).unwrap();
    let transfer = LoopTransfer::new(&plant, &dmatrix![7.0; 10.0], &dmatrix![1.0, 2.0]).unwrap();
    for open in [&transfer.at_inputs, &transfer.at_outputs] {
        let margins = LoopMargins::continuous(open).unwrap();
        assert!(margins.sensitivity.is_some());
        let [margin] = margins.channels[0].gain[..] else { panic!("{margins:?}") };
        assert!(near(margin.factor, 65.0 / 9.0, 1e-9), "{margin:?}");
        assert!(near(margin.frequency, (65f64 / 3.0).sqrt(), 1e-9), "{margin:?}");
    }
}
