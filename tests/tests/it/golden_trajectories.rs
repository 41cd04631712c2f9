//! Trajectories compared with independent integrators: diffsol's BDF and Tsit45.

use diffsol::{NalgebraMat, OdeBuilder, OdeSolverMethod};
use luenberger_design::{CubicDesign, CubicGain, LinearDesign, LyapunovWeight};
use luenberger_observers::CubicObserver;
use luenberger_plants::{StateSpace, third_order};
use luenberger_sim::{Scenario, Signal};
use nalgebra::{DVector, Dyn, dmatrix};

use crate::examples::example_1;

type M = NalgebraMat<f64>;

/// `e' = F e + theta (C e)^2 N C e` for one output, solved by diffsol at the times `t`.
fn second_opinion(observer: &CubicObserver<f64, Dyn, Dyn, Dyn>, e0: &[f64], t: &[f64]) -> Vec<DVector<f64>> {
    let f = &observer.a - &observer.l * &observer.c;
    let (c, n, theta) = (observer.c.row(0).transpose(), observer.n.column(0).clone_owned(), observer.theta[(0, 0)]);
    let order = e0.len();
    let read = DVector::from_column_slice;
    let (f2, c2, n2) = (f.clone(), c.clone(), n.clone());
    let e0 = e0.to_vec();
    let problem = OdeBuilder::<M>::new()
        .rtol(1e-12)
        .atol([1e-14])
        .rhs_implicit(
            move |x: &[f64], _: &[f64], _, out: &mut [f64]| {
                let e = read(x);
                let y = c.dot(&e);
                let rate = &f * &e + &n * (theta * y * y * y);
                out.copy_from_slice(rate.as_slice());
            },
            move |x: &[f64], _: &[f64], _, direction: &[f64], out: &mut [f64]| {
                let (e, d) = (read(x), read(direction));
                let y = c2.dot(&e);
                let rate = &f2 * &d + &n2 * (3.0 * theta * y * y * c2.dot(&d));
                out.copy_from_slice(rate.as_slice());
            },
        )
        .init(move |_: &[f64], _, out: &mut [f64]| out.copy_from_slice(&e0), order)
        .build()
        .unwrap();
    let mut solver = problem.tsit45().unwrap();
    let (solution, _) = solver.solve_dense(t).unwrap();
    (0..t.len()).map(|k| DVector::from_fn(order, |i, _| solution[(i, k)])).collect()
}

fn agree(design: &CubicDesign, e0: &[f64], t: &[f64], tolerance: f64) {
    let o = &design.observer;
    let plant = StateSpace::new(o.a.clone(), o.b.clone(), o.c.clone()).unwrap();
    let run = Scenario::new(plant)
        .input(Signal::zero())
        .observer("cubic", o.clone(), &e0.iter().map(|e| -e).collect::<Vec<_>>())
        .times(t)
        .run()
        .unwrap();
    let ours = &run.observer("cubic").unwrap().error;
    for (k, theirs) in second_opinion(o, e0, t).iter().enumerate() {
        let difference = (ours.row(k).transpose() - theirs).amax();
        assert!(difference < tolerance, "at t = {}: {difference:e}", t[k]);
    }
}

#[test]
fn example_1_agrees_with_a_second_integrator() {
    let (_, _, cubic) = example_1();
    agree(&cubic, &[-3.0, -3.0], &[0.001, 0.01, 0.1, 0.5, 1.0, 2.0, 4.0], 1e-9);
}

/// The errors begin at 866, so 1e-9 is relative to that.
#[test]
fn example_2_agrees_with_a_second_integrator() {
    let plant = third_order::example2().to_dynamic();
    let linear =
        LinearDesign::with_poles_and_weight(&plant, &[-30.0, -10.0, -5.0], LyapunovWeight::Identity(10.0)).unwrap();
    let cubic = CubicDesign::new(&linear, &dmatrix![1.0], &CubicGain::Gamma(0.1)).unwrap();
    agree(&cubic, &[500.0; 3], &[0.01, 0.1, 0.5, 1.0], 1e-9 * 866.0);
}

/// Typed in from scipy 1.17, solve_ivp with DOP853 at rtol 1e-11: the overshoot of e2 and its last crossings of 0.05.
#[test]
fn example_1_has_its_golden_values() {
    use luenberger_sim::metrics;
    let (plant, linear, cubic) = example_1();
    let run = Scenario::new(plant)
        .initial_state(&[-3.0, -3.0])
        .input(Signal::scalar(f64::sin))
        .observer("cubic", cubic.observer.clone(), &[0.0, 0.0])
        .observer("linear", linear.observer.clone(), &[0.0, 0.0])
        .until(4.0, 401)
        .run()
        .unwrap();
    for (name, overshoot, settling) in [("cubic", 0.485_232_525, 1.654_96), ("linear", 1.190_550_789, 2.301_78)] {
        let e2 = run.error_trace(name, 1).unwrap();
        assert!((metrics::overshoot(&e2).unwrap().value.abs() - overshoot).abs() < 1e-8, "{name}");
        // scipy's samples are 20 microseconds apart.
        assert!((metrics::settling_last(&e2, 0.05).unwrap() - settling).abs() < 4e-5, "{name}");
    }
}
