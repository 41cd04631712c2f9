//! Initial errors so large that the cubic term is stiff, in continuous and in sampled time.

use luenberger_design::{CubicDesign, SampledCubicDesign};
use luenberger_observers::Observer;
use luenberger_plants::double_integrator;
use luenberger_sim::{Integrator, Scenario};
use nalgebra::DVector;

use crate::examples::example_1;

/// At e(0) = 1000 the cubic term has the rate 3 theta |C N| y^2 = 3e8 per second, the linear one 5.
#[test]
fn an_error_of_a_thousand_is_integrated_and_both_methods_agree() {
    let (_, _, cubic) = example_1();
    let at = |integrator| {
        Scenario::new(double_integrator())
            .observer("cubic", cubic_static(&cubic), &[1000.0, 1000.0])
            .until(4.0, 41)
            .integrator(integrator)
            .run()
            .unwrap()
            .observer("cubic")
            .unwrap()
            .error
            .clone()
    };
    let (explicit, implicit, auto) = (at(Integrator::Explicit), at(Integrator::Implicit), at(Integrator::Auto));
    // Relative to the largest error, 1414.
    assert!((&explicit - &implicit).amax() < 1e-8 * 1414.0, "{:e}", (&explicit - &implicit).amax());
    assert!((&auto - &implicit).amax() < 1e-8 * 1414.0);
    assert!(explicit.row(40).amax() < 1.0);
}

fn cubic_static(design: &CubicDesign) -> luenberger_observers::cubic::StaticCubicObserver<f64, 2, 1, 1> {
    let (o, plant) = (&design.observer, double_integrator());
    let column = |m: &nalgebra::DMatrix<f64>| nalgebra::Vector2::new(m[(0, 0)], m[(1, 0)]);
    luenberger_observers::CubicObserver::of(plant, column(&o.l), column(&o.n), nalgebra::Matrix1::new(o.theta[(0, 0)]))
        .unwrap()
}

/// At 1 kHz from (100, 100) explicit Euler on (5) diverges within a few steps; the sampled-data observer converges.
#[test]
fn the_sampled_observer_converges_where_euler_diverges() {
    let (_, linear, cubic) = example_1();
    let h = 1e-3;
    let (mut xhat, u, y) = (DVector::from_vec(vec![-100.0, -100.0]), DVector::zeros(1), DVector::zeros(1));
    let diverged = (0..100).any(|k| {
        let slope = cubic.observer.derivative(f64::from(k) * h, &xhat, &u, &y);
        xhat += slope * h;
        xhat.amax() > 1e12
    });
    assert!(diverged, "Euler stayed at {xhat}");

    let sampled = SampledCubicDesign::from_cubic(&linear, &cubic, h).unwrap();
    assert!(sampled.certificate.is_proved(), "{}", sampled.certificate);
    let run = Scenario::new(double_integrator())
        .sampled_observer("sampled", sampled.observer.clone(), &[-100.0, -100.0])
        .until(8.0, 81)
        .run()
        .unwrap();
    let error = &run.observer("sampled").unwrap().error;
    assert!(error.row(80).amax() < 1e-4, "{}", error.row(80));
    assert!(error.amax() <= 100.0 * 50.0, "it never leaves the level set of V");
}
