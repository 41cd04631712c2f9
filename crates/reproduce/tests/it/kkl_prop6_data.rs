//! `data/kkl-prop6.csv` compared with another method and other equations.

use luenberger_reproduce::Context;
use luenberger_sim::{Integrator, Scenario, Signal};

/// Proposition 6 as the paper prints it, typed in once more: (31) under u = -y, (32) to (37). The state is (x, xi, w,
/// F[y^3], psi, Theta_hat).
fn proposition6(z: &[f64; 9]) -> [f64; 9] {
    let [x1, x2, x3, xi1, xi2, w, cube, psi, theta] = *z;
    let (alpha, gamma, y) = (1.0, 5.0, x1);
    let (u, signal) = (-y, alpha * (y - w) + cube);
    [
        x3.exp() - x1.powi(3),
        x1 * x1 + x1.sin() - x2,
        1.0 / (x1 * x1 + 1.0) + x1 * u,
        y * y + y.sin() - xi1,
        u * y + 1.0 / (y * y + 1.0),
        alpha * (y - w),
        alpha * (y.powi(3) - cube),
        alpha * (xi2.exp() - psi),
        gamma * psi * (signal - psi * theta),
    ]
}

/// The classical Runge-Kutta method with `steps` steps per 0.05, from t = 0 to 20.
fn runge_kutta(steps: u32) -> Vec<[f64; 9]> {
    let h = 0.05 / f64::from(steps);
    let moved = |z: &[f64; 9], k: &[f64; 9], h: f64| -> [f64; 9] { std::array::from_fn(|i| z[i] + h * k[i]) };
    let mut z = [0.5, -1.0, 0.3, 0.0, 0.0, 0.5, 0.0, 0.0, 1.0];
    let mut rows = vec![z];
    for _ in 0..400 {
        for _ in 0..steps {
            let k1 = proposition6(&z);
            let k2 = proposition6(&moved(&z, &k1, h / 2.0));
            let k3 = proposition6(&moved(&z, &k2, h / 2.0));
            let k4 = proposition6(&moved(&z, &k3, h));
            z = std::array::from_fn(|i| z[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        }
        rows.push(z);
    }
    rows
}

/// `data/kkl-prop6.csv` to 1e-9: beside another method with other equations, whose own error the halved step shows, and
/// beside looser tolerances of the same.
#[test]
fn the_data_of_proposition_6_are_accurate() {
    let papers = luenberger_reproduce::papers();
    let drawing = papers.iter().flat_map(|paper| &paper.figures).find(|drawing| drawing.id == "kkl-prop6").unwrap();
    let data = (drawing.draw)(&Context::new(".")).unwrap().data;
    let names: Vec<&str> = data.columns().iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["t", "x1", "x2", "x3", "x2_hat", "x3_hat", "theta_hat"]);
    let t = &data.columns()[0].1;
    assert!([1.0, 5.0, 20.0].iter().all(|wanted| t.contains(wanted)));

    let (coarse, fine) = (runge_kutta(25), runge_kutta(50));
    let row = |z: &[f64; 9]| [z[0], z[1], z[2], z[3], z[4] + z[8].ln(), z[8]];
    for (k, &t) in t.iter().enumerate() {
        assert!((t - 0.05 * k as f64).abs() < 1e-14);
        let (coarse, fine) = (row(&coarse[k]), row(&fine[k]));
        for i in 0..6 {
            let written = data.columns()[1 + i].1[k];
            // Order 4: the finer one is off by a fifteenth of the difference.
            assert!((coarse[i] - fine[i]).abs() < 1e-9, "{} at {t}: {} {}", names[1 + i], coarse[i], fine[i]);
            assert!((written - fine[i]).abs() < 1e-10, "{} at {t}: {written} {}", names[1 + i], fine[i]);
        }
    }

    let observer = luenberger_reproduce::kkl::exponential_cascade::observer(1.0, 5.0).unwrap();
    let loose = Scenario::new(luenberger_plants::ExponentialCascade)
        .initial_state(&[0.5, -1.0, 0.3])
        .input(Signal::law(|view, u| u[0] = -view.y[0]))
        .partial_observer("observer", &observer, &[0.0, 0.0], &[1, 2])
        .integrator(Integrator::Implicit)
        .until(20.0, 401)
        .run()
        .unwrap();
    let found = loose.observer("observer").unwrap();
    for (k, t) in t.iter().enumerate() {
        let row = [
            loose.x[(k, 0)],
            loose.x[(k, 1)],
            loose.x[(k, 2)],
            found.estimate[(k, 0)],
            found.estimate[(k, 1)],
            found.state[(k, 5)],
        ];
        for (i, value) in row.into_iter().enumerate() {
            let written = data.columns()[1 + i].1[k];
            assert!((written - value).abs() < 1e-9, "{} at {t}: {written} {value}", names[1 + i]);
        }
    }
}
