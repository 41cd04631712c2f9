//! The steps of the integrators, beside those of second implementations in Python with the coefficients, stages and
//! error estimates of SciPy's `DOP853` and `Radau`, and with the rules that the modules state for step size, Newton's
//! iteration and the defect of the dense output: where each step ends, and how often the right-hand side is evaluated.

use std::cell::Cell;

use luenberger_sim::{Dense, Integrator, Settings, solve};

/// The solution, and how often the right-hand side was evaluated.
fn counted(f: impl Fn(f64, &[f64], &mut [f64]), end: f64, x0: &[f64], settings: Settings) -> (Dense, usize) {
    let count = Cell::new(0);
    let counting = |t: f64, x: &[f64], slope: &mut [f64]| {
        count.set(count.get() + 1);
        f(t, x, slope);
    };
    let solution = solve(counting, 0.0, end, x0, &settings).unwrap();
    (solution, count.get())
}

fn settings(integrator: Integrator, rtol: f64, atol: f64) -> Settings {
    Settings::default().integrator(integrator).rtol(rtol).atol(atol)
}

/// Steps end where those of the second implementation end, relative to the length of each.
fn ends_at(solution: &Dense, expected: &[f64], digits: f64) {
    assert_eq!(solution.step_count(), expected.len());
    // A small estimate or defect is known to some digits only: it is a difference of large terms.
    for ((start, end), expected) in solution.steps().zip(expected) {
        assert!((end - expected).abs() <= digits * (expected - start), "{start} to {end}, expected {expected}");
    }
}

/// Euler's equations of a rigid body under a torque, beside a pendulum with cubic damping: five states, two of the
/// steps rejected for the estimate or the defect before their successors.
#[test]
fn explicit_steps_of_several_states() {
    let f = |t: f64, x: &[f64], slope: &mut [f64]| {
        let body = [x[1] * x[2] + (3.0 * t).sin(), -x[0] * x[2], -0.51 * x[0] * x[1]];
        slope[..3].copy_from_slice(&body);
        slope[3..].copy_from_slice(&[x[4], -4.0 * x[3].sin() - x[4].powi(3)]);
    };
    let settings = settings(Integrator::Explicit, 1e-6, 1e-6);
    let (solution, evaluations) = counted(f, 3.0, &[0.0, 1.0, 1.0, 2.0, 0.0], settings);
    let ends = [
        0.0018329169505,
        0.012830418653,
        0.078815428871,
        0.30773315596,
        0.49883464626,
        0.68993613655,
        0.87280795853,
        1.1143121759,
        1.3611165324,
        1.6429218679,
        1.9953554422,
        2.4329578187,
        2.8112016593,
        3.0,
    ];
    ends_at(&solution, &ends, 1e-5);
    assert_eq!(evaluations, 301);
    let expected = [0.67467775534, -1.0099555846, 1.005089672, -0.16023254099, 0.68670489773];
    assert!(solution.at(3.0).unwrap().iter().zip(expected).all(|(x, expected)| (x - expected).abs() < 1e-7));
}

/// A pulse, which the estimate of order 5 and 3 notices before the defect does: seven rejected steps.
#[test]
fn explicit_steps_through_a_pulse() {
    let f = |t: f64, x: &[f64], slope: &mut [f64]| slope[0] = -x[0] + 20.0 * (-200.0 * (t - 1.0).powi(2)).exp();
    let (solution, evaluations) = counted(f, 2.0, &[1.0], settings(Integrator::Explicit, 1e-7, 1e-7));
    let ends = [
        0.01,
        0.07,
        0.43,
        0.58518448861,
        0.74036897722,
        0.79728316726,
        0.8541973573,
        0.8981274616,
        0.93754622433,
        0.97335193669,
        1.0128520995,
        1.0533996413,
        1.0935239826,
        1.1420359845,
        1.1904853425,
        1.2503072066,
        1.3142948339,
        1.4130587053,
        1.7055214773,
        2.0,
    ];
    ends_at(&solution, &ends, 1e-4);
    assert_eq!(evaluations, 407);
    assert!((solution.at(2.0).unwrap()[0] - 1.0586256907).abs() < 1e-8);
}

/// Robertson's reactions.
#[test]
fn implicit_steps_through_reactions() {
    let f = |_: f64, x: &[f64], slope: &mut [f64]| {
        let (slow, fast, faster) = (0.04 * x[0], 1e4 * x[1] * x[2], 3e7 * x[1] * x[1]);
        slope.copy_from_slice(&[fast - slow, slow - fast - faster, faster]);
    };
    let (solution, evaluations) = counted(f, 40.0, &[1.0, 0.0, 0.0], settings(Integrator::Implicit, 1e-4, 1e-8));
    let ends = [
        2.49975e-05,
        0.0002249775,
        0.0005103126,
        0.0007752892,
        0.001092214,
        0.0015608,
        0.002106834,
        0.002676207,
        0.003454893,
        0.004604998,
        0.006632657,
        0.01160409,
        0.03415456,
        0.1974272,
        0.4121719,
        0.7766431,
        1.251617,
        1.868597,
        2.652115,
        3.642154,
        4.83897,
        6.347043,
        8.244786,
        10.64265,
        13.6835,
        17.55344,
        22.49434,
        28.82023,
        36.93804,
        40.0,
    ];
    ends_at(&solution, &ends, 1e-5);
    // 359 of the second implementation, which forms slope and Jacobian anew after its rejected attempt.
    assert_eq!(evaluations, 359 - 4);
    let expected = [0.715827016, 9.18553192e-06, 0.284163798];
    let end = solution.at(40.0).unwrap();
    assert!(end.iter().zip(expected).all(|(x, expected)| (x / expected - 1.0).abs() < 1e-7), "{end:?}");
}

/// Van der Pol's oscillator up to its jump, with rejected steps and the predictive controller on the way.
#[test]
fn implicit_steps_into_a_jump() {
    let f = |_: f64, x: &[f64], slope: &mut [f64]| {
        slope.copy_from_slice(&[x[1], 100.0 * ((1.0 - x[0] * x[0]) * x[1] - x[0])]);
    };
    let (solution, evaluations) = counted(f, 0.86, &[2.0, 0.0], settings(Integrator::Implicit, 1e-4, 1e-4));
    let ends = [
        3.333333e-05,
        0.0003,
        0.001660612,
        0.003164454,
        0.004917758,
        0.00696494,
        0.009385129,
        0.0123048,
        0.01593627,
        0.02066379,
        0.02726626,
        0.03761772,
        0.05764395,
        0.1171189,
        0.2962767,
        0.4754345,
        0.5679278,
        0.6407956,
        0.7089981,
        0.752349,
        0.777109,
        0.7960927,
        0.8125547,
        0.8260296,
        0.8369915,
        0.8461972,
        0.8540547,
        0.86,
    ];
    ends_at(&solution, &ends, 1e-5);
    // 400 of the second implementation, which forms slope and Jacobian anew after its two rejected attempts.
    assert_eq!(evaluations, 400 - 2 * 3);
    let end = solution.at(0.86).unwrap();
    assert!((end[0] - 0.917951177).abs() < 1e-6 && (end[1] + 6.92392359).abs() < 1e-4, "{end:?}");
}

/// After fifteen steps at the border of stability the implicit method goes on: the explicit one would need some
/// million steps, and half of the allowed number would be spent on it.
#[test]
fn stiffness_is_noticed_within_some_steps() {
    let stiff = |t: f64, x: &[f64], slope: &mut [f64]| slope[0] = -1e6 * (x[0] - t.cos());
    let (solution, evaluations) = counted(stiff, 10.0, &[0.0], Settings::default());
    assert!(evaluations < 50_000, "{evaluations} evaluations, {} steps", solution.step_count());
    assert!((solution.at(10.0).unwrap()[0] - 10f64.cos() - 1e-6 * 10f64.sin()).abs() < 1e-9);
    // What is not stiff stays explicit to the end.
    let circle = |_: f64, x: &[f64], slope: &mut [f64]| slope.copy_from_slice(&[x[1], -x[0]]);
    let automatic = counted(circle, 100.0, &[0.0, 1.0], Settings::default());
    assert_eq!(automatic, counted(circle, 100.0, &[0.0, 1.0], Settings::default().integrator(Integrator::Explicit)));
}
