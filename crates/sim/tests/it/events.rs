//! Crossings, extrema and integrals of quantities with closed forms, however they are kept: components of the dense
//! output, norms of them, and any function of a row.

use approx::assert_abs_diff_eq;
use luenberger_observers::LinearObserver;
use luenberger_plants::{LinearPlant, StateSpace};
use luenberger_sim::{Crossing, Integrator, Scenario, Signal, SimError, Trace, Trajectory, metrics};
use nalgebra::{DMatrix, dmatrix};

/// `x = (sin t, cos t)` and estimates that stay 0: the error of "both" is x, that of "sine" is sin t. Steps have a
/// length of about 1, a sixteenth of which is longer than what the sine needs to rise above 0.999999 and fall again.
fn circle(end: f64) -> Trajectory {
    let plant = LinearPlant::new(dmatrix![0.0, 1.0; -1.0, 0.0], DMatrix::zeros(2, 0), dmatrix![1.0, 0.0]).unwrap();
    let still = LinearPlant::new(dmatrix![0.0], DMatrix::zeros(1, 0), dmatrix![1.0]).unwrap();
    let both = LinearObserver::of(
        LinearPlant::new(DMatrix::zeros(2, 2), DMatrix::zeros(2, 0), dmatrix![1.0, 0.0]).unwrap(),
        dmatrix![0.0; 0.0],
    );
    Scenario::new(plant)
        .initial_state(&[0.0, 1.0])
        .observer("both", both.unwrap(), &[0.0, 0.0])
        .partial_observer("sine", LinearObserver::of(still, dmatrix![0.0]).unwrap(), &[0.0], &[0])
        .integrator(Integrator::Explicit)
        .tolerances(1e-7, 1e-7)
        .until(end, 2)
        .run()
        .unwrap()
}

fn near(found: &[Crossing], expected: &[(f64, bool)]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, (time, rising)) in found.iter().zip(expected) {
        // A crossing at the slope s is off by 1/s of what the solution is off by; the smallest slope here is 1e-3.
        assert!((found.time - time).abs() < 2e-3 && found.rising == *rising, "{found:?}, expected {time}");
    }
}

#[test]
fn every_crossing_of_a_sine_is_found() {
    use std::f64::consts::PI;
    let run = circle(20.0);
    assert!(run.steps < 45, "steps are long: {}", run.steps);
    let kept = run.error_trace("sine", 0).unwrap();
    let any = run.trace(|view| view.x[0]);
    for level in [0.0f64, 0.5, -0.5, 0.99, -0.99, 0.99999, -0.99999, 1.01, -1.01, 3.0] {
        let angle = level.asin();
        let mut expected: Vec<(f64, bool)> = Vec::new();
        for k in 0..4 {
            let turn = 2.0 * PI * f64::from(k);
            expected.extend([(turn + angle, true), (turn + PI - angle, false)]);
        }
        expected.retain(|(time, _)| *time > 0.0 && *time < 20.0);
        expected.sort_by(|a, b| a.0.total_cmp(&b.0));
        near(&kept.crossings(level), &expected);
        near(&any.crossings(level), &expected);
        assert_eq!(kept.first_crossing(level), kept.crossings(level).first().copied());
        assert_eq!(kept.last_crossing(level), kept.crossings(level).last().copied());
    }
    // Of a norm, both halves: the sine alone, and the circle, which never leaves 1.
    let magnitude = run.error_norm("sine").unwrap();
    for level in [0.5f64, 0.99, 0.99999] {
        let angle = level.asin();
        let halves = (0..7).map(|k| PI * f64::from(k));
        let expected: Vec<(f64, bool)> = halves
            .flat_map(|half| [(half + angle, true), (half + PI - angle, false)])
            .filter(|(t, _)| *t < 20.0)
            .collect();
        near(&magnitude.crossings(level), &expected);
    }
    let norm = run.error_norm("both").unwrap();
    assert!(norm.crossings(0.99).is_empty() && norm.crossings(1.01).is_empty());
}

#[test]
fn the_largest_values_of_a_sine_are_its_tops() {
    use std::f64::consts::FRAC_PI_2;
    let run = circle(20.0);
    let sine = run.error_trace("sine", 0).unwrap();
    // From t on, the first top or bottom; the time of a top is good to the root of its value.
    let largest = |from: f64| sine.largest_magnitude(from).unwrap();
    let greatest = |from: f64| sine.maximum(from).unwrap();
    for trace in [&sine, &run.error_norm("sine").unwrap(), &run.trace(|view| view.x[0].abs())] {
        let top = trace.largest_magnitude(0.0).unwrap();
        assert!((top.value - 1.0).abs() < 1e-5 && ((top.time / FRAC_PI_2).round() * FRAC_PI_2 - top.time).abs() < 1e-2);
    }
    let falling = greatest(18.5);
    assert!((falling.value - 20f64.sin()).abs() < 1e-5 && falling.time == 20.0, "{falling:?}");
    let behind = largest(17.5);
    assert!((behind.value - 17.5f64.sin().abs()).abs() < 1e-5 && behind.time == 17.5, "{behind:?}");
    let bottom = largest(17.0);
    assert!((bottom.value - 1.0).abs() < 1e-5 && (bottom.time - 11.0 * FRAC_PI_2).abs() < 1e-2, "{bottom:?}");
    assert!(matches!(sine.maximum(20.5), Err(SimError::Outside { .. })));
    assert_eq!(sine.largest_magnitude(20.0).unwrap().time, 20.0);
    assert_abs_diff_eq!(sine.last(), 20f64.sin(), epsilon = 1e-5);
    assert_abs_diff_eq!(sine.integral(), 1.0 - 20f64.cos(), epsilon = 1e-5);
}

/// x' = 1 from -1, and a constant beside it.
fn ramp(breakpoint: f64) -> Trajectory {
    let plant = StateSpace::new(dmatrix![0.0, 0.0; 0.0, 0.0], dmatrix![1.0; 0.0], dmatrix![1.0, 0.0]).unwrap();
    Scenario::new(plant)
        .initial_state(&[-1.0, -2.0])
        .input(Signal::constant(&[1.0]))
        .breakpoints(&[breakpoint])
        .until(2.0, 2)
        .run()
        .unwrap()
}

#[test]
fn a_crossing_at_the_seam_of_two_steps_is_one() {
    let run = ramp(0.75);
    let trace = run.trace(|view| view.x[0]);
    // Exactly the value at the seam: nothing is left of the level there.
    let level = run.state_at(0.75).unwrap()[0];
    let crossings = trace.crossings(level);
    assert!(crossings.len() == 1 && crossings[0].rising && (crossings[0].time - 0.75).abs() < 1e-9, "{crossings:?}");
    // What is no number before t = 0.5 has no sides there.
    let late = run.trace(|view| if view.t < 0.5 { f64::NAN } else { view.x[0] });
    let crossings = late.crossings(0.25);
    assert!(crossings.len() == 1 && (crossings[0].time - 1.25).abs() < 1e-9, "{crossings:?}");
    // A jump across the level is at its seam.
    let jump = run.trace(|view| if view.t < 0.75 { -1.0 } else { 1.0 });
    assert_eq!(jump.crossings(0.0), [Crossing { time: 0.75, rising: true }]);
}

/// Of equal values the first is the largest one: where it is reached.
#[test]
fn a_constant_is_largest_at_the_start() {
    let run = ramp(0.75);
    for trace in [run.trace(|view| view.x[1]), run.trace(|view| -view.x[1])] {
        assert_eq!(trace.largest_magnitude(0.0).map(|top| (top.time, top.value)), Ok((0.0, 2.0)));
        assert_eq!(trace.largest_magnitude(0.3).map(|top| (top.time, top.value)), Ok((0.3, 2.0)));
        assert_eq!(trace.maximum(0.3).map(|top| top.time), Ok(0.3));
    }
}

/// Of -1 + t on [0, 2]: within 0.25 from t = 0.75 on, and again outside from 1.25 on.
#[test]
fn settling_from_either_side() {
    let run = ramp(0.5);
    let (rising, falling) = (run.trace(|view| view.x[0]), run.trace(|view| -view.x[0]));
    let settling = |trace: &Trace<'_>, within: f64| {
        (metrics::settling_first(trace, within), metrics::settling_last(trace, within))
    };
    for trace in [&rising, &falling] {
        let (first, last) = settling(trace, 0.25);
        assert!((first.unwrap() - 0.75).abs() < 1e-12 && last.is_none(), "{first:?} {last:?}");
        // It begins and ends with 1: within 1 from the start on, and at the end.
        assert_eq!(settling(trace, 1.5), (Some(0.0), Some(0.0)));
        assert_eq!(metrics::settling_first(trace, 1.0), Some(0.0));
    }
    // x2 - x1/2 is -2 + 1/2 - t/2, which ends at -2.5; and its square root of nothing below: never within 1.
    let growing = run.trace(|view| view.x[1] - 0.5 * view.x[0]);
    assert_eq!(settling(&growing, 1.0), (None, None));
    // From -1 into the band for good at 0.75, up to 0: from below and, mirrored, from above.
    let stays = run.trace(|view| (view.x[0]).min(0.0));
    let mirrored = run.trace(|view| (-view.x[0]).max(0.0));
    for trace in [&stays, &mirrored] {
        let last = metrics::settling_last(trace, 0.25).unwrap();
        assert!((last - 0.75).abs() < 1e-9, "{last}");
    }
    assert_abs_diff_eq!(metrics::peak(&rising).unwrap().value, 1.0, epsilon = 1e-12);
}

/// `V = e'Pe` with e = (sin t, cos t) and P = [2 1; 1 4]: `2 s^2 + 2 s c + 4 c^2`.
#[test]
fn a_quadratic_form_of_the_error() {
    let run = circle(3.0);
    let p = dmatrix![2.0, 1.0; 1.0, 4.0];
    let exact = |t: f64| 2.0 * t.sin().powi(2) + 2.0 * t.sin() * t.cos() + 4.0 * t.cos().powi(2);
    let v = metrics::lyapunov(&run, "both", &p).unwrap();
    assert_eq!(v.len(), 2);
    assert!((v[0] - 4.0).abs() < 1e-12 && (v[1] - exact(3.0)).abs() < 1e-4, "{v:?}");
    let trace = metrics::lyapunov_trace(&run, "both", &p).unwrap();
    assert_abs_diff_eq!(trace.at(1.3).unwrap(), exact(1.3), epsilon = 1e-4);
    for wrong in [dmatrix![1.0], dmatrix![1.0, 0.0], dmatrix![1.0, 0.0, 0.0; 0.0, 1.0, 0.0]] {
        assert!(matches!(metrics::lyapunov(&run, "both", &wrong), Err(SimError::Length { expected: 2, .. })));
        assert!(matches!(metrics::lyapunov_trace(&run, "both", &wrong), Err(SimError::Length { expected: 2, .. })));
    }
    let nan = dmatrix![1.0, 0.0; 0.0, f64::NAN];
    assert!(matches!(metrics::lyapunov(&run, "both", &nan), Err(SimError::NotFinite { index: 3, .. })));
}
