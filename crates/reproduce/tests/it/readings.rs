//! Numbers of the second reading of the papers, each computed outside this program (scipy), and the separation of F3.

use luenberger_plants::{ExponentialCascade, Plant};
use luenberger_random::{Purpose, Stream};
use luenberger_reproduce::kkl::prop6::{forced_to_vanish, forced_to_vanish_with_zero};
use luenberger_reproduce::{Context, Record, Value};
use nalgebra::{Vector1, Vector3};

fn record(id: &str) -> Record {
    let papers = luenberger_reproduce::papers();
    let (paper, claim) = papers
        .iter()
        .find_map(|paper| paper.claims.iter().find(|claim| claim.id == id).map(|claim| (paper, claim)))
        .unwrap_or_else(|| panic!("{id}"));
    claim.examine(paper.key, &Context::new("."))
}

fn numbers(id: &str) -> Vec<f64> {
    record(id).computed.unwrap().entries()
}

/// scipy 1.17, DOP853 with rtol = 1e-12: Example 1 of the cubic observer from e(0) = (-3, -3).
#[test]
fn the_first_times_and_the_peaks_of_example_1() {
    let times = numbers("cubic.ex1.settling-first-crossing");
    assert!((times[0] - 1.664_606).abs() < 2e-6 && (times[1] - 2.311_566).abs() < 2e-6, "{times:?}");
    let peaks = [numbers("cubic.ex1.peak-cubic")[0], numbers("cubic.ex1.peak-linear")[0]];
    assert!((peaks[0] - 0.480_784_9).abs() < 1e-6 && (peaks[1] - 1.182_717_2).abs() < 1e-6, "{peaks:?}");
}

/// d|e|^2/dt at e = (3, -3): 2e'(Fe + 10 e1^3 N) = 36 + 10 * 27 * 2 * 3 (N1 - N2), N = -(168, 196)/17.
#[test]
fn the_estimate_moves_away_first() {
    let expected: f64 = 36.0 + 1620.0 * (196.0 - 168.0) / 17.0;
    let note = record("cubic.remark3.step").note;
    assert!((expected - 2704.235).abs() < 1e-3 && note.contains("2704.24") && note.contains("36 with"), "{note}");
}

/// scipy, DOP853 with rtol = 1e-10: the chirp of Proposition 7 at T = 60, with x2hat, x3hat from 0 and from x2, x3; the
/// integral of F[b]^2, and the least of that of b^2 over windows of 2.
#[test]
fn the_chirp_is_exciting_and_its_filter_is_not() {
    let found = record("kkl.prop7.gradient");
    for said in ["-1.54987", "-1.53669", "0.263514"] {
        assert!(found.note.contains(said), "{said}: {}", found.note);
    }
    assert!(found.hypotheses.iter().any(|hypothesis| hypothesis.how.contains("0.716717")), "{:?}", found.hypotheses);
    assert!(found.hypotheses.iter().all(|hypothesis| hypothesis.holds == Some(true)));
}

/// scipy, LSODA with rtol = 1e-10: Example 2 of the mean-value-theorem observer, |x - xhat| at 20 s from xhat0 and e0
/// both as printed, and from e01; the largest residual of (10) from 1 s on is at 1 s.
#[test]
fn the_readings_of_example_2() {
    let note = record("mvt.ex2.both-as-printed").note;
    assert!(note.contains("0.00786076 at 20 s"), "{note}");
    let note = record("mvt.ex2.e01").note;
    assert!(note.contains("0.0291285 at 10 s") && note.contains("0.00168427 at 20 s"), "{note}");
    let note = record("mvt.eq7").note;
    assert!(note.contains("16.1872"), "{note}");
}

/// scipy: the least Theta_hat from w(0) = 0, psi(0) = 0.1, x1(0) = -2, and the closed form of the escape.
#[test]
fn theta_goes_below_zero_and_the_small_plant_escapes() {
    let note = record("kkl.prop6.theta-positive").note;
    assert!(note.contains("-0.2253"), "{note}");
    let note = record("kkl.prop4").note;
    assert!(note.contains("0.875634") || note.contains("0.8756"), "{note}");
}

/// The separation of terms of F3 on random points, and that it would find a KKLO: with x3 for e^x3 in x1' the plant has
/// one, and the equations leave λb open.
#[test]
fn the_terms_of_f3_separate_for_its_plant_and_not_for_a_linear_one() {
    let plant = |x: &Vector3<f64>, u: f64| ExponentialCascade.derivative(0.0, x, &Vector1::new(u));
    let linear = |x: &Vector3<f64>, u: f64| plant(x, u) + Vector3::new(x[2] - x[2].exp(), 0.0, 0.0);
    let mut random = Stream::new(7, Purpose::RandomCase, 0).draws(0);
    for _ in 0..200 {
        let (x1, x2) = (2.0 * random.unit(), 2.0 * random.unit());
        assert!(forced_to_vanish(plant, x1, x2) > 0.999_999, "({x1}, {x2})");
        assert!(forced_to_vanish(linear, x1, x2) < 0.999, "({x1}, {x2})");
    }
    let (x1, x2) = ([-2.0, -0.7, 0.4, 1.9], [-1.5, 0.2, 1.1]);
    assert!(forced_to_vanish_with_zero(plant, &x1, &x2) > 0.999_999);
    // x2' = x1^2 is a function of y: phi = x2 solves the equation of a PEBO.
    let known = |x: &Vector3<f64>, u: f64| Vector3::new(plant(x, u)[0], x[0] * x[0], plant(x, u)[2]);
    assert!(forced_to_vanish_with_zero(known, &x1, &x2) < 0.999);
}

/// scipy and numpy: the covariance of the filter with P0, integrated by Gauss's rule, and the same after a push.
#[test]
fn the_kalman_filter_with_p0_is_the_opponent() {
    let costs = numbers("cubic.kalman.first-error");
    for (found, expected) in
        costs.iter().zip([0.015_683_577, 0.080_831_591, 0.585_248_152, 0.289_412_559, 0.278_856_615])
    {
        assert!((found / expected - 1.0).abs() < 1e-8, "{found} {expected}");
    }
    let costs = numbers("cubic.kalman.push");
    for (found, expected) in costs[2..].iter().zip([0.744_868_976, 24.441_007_635]) {
        assert!((found / expected - 1.0).abs() < 1e-8, "{found} {expected}");
    }
}

/// A truth is shown as such where a reading fails.
#[test]
fn both_starts_of_the_filters_are_told() {
    let found = record("kkl.cuk.kkl-peb");
    assert_eq!(found.computed, Some(Value::Truth(true)));
    // scipy, LSODA with rtol = 1e-9: 4.223 mA of i1 at 0.19 s, and 11.22 mV of v4 of the PEBO.
    assert!(found.note.contains("0.00422"), "{}", found.note);
    assert!(record("kkl.cuk.pebo").note.contains("0.0112"), "{}", record("kkl.cuk.pebo").note);
}
