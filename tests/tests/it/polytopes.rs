//! Guarantees of an LPV design compared with simulation: errors stay below the proved bound as long as the hypothesis
//! holds.

use luenberger_design::enclosure::enclose;
use luenberger_design::{LpvDesign, Region};
use luenberger_observers::mean_value::beta::mean_value;
use luenberger_observers::mean_value::integral::gauss_legendre;
use luenberger_plants::{Chaotic, flexible_joint};
use luenberger_proof::Interval;
use luenberger_sim::{Scenario, Signal, Trajectory};
use nalgebra::{DVector, SVector, Vector3};
use proptest::prelude::*;

use crate::generators::vector4;

/// The integrator's tolerance is 1e-11 in each component, and the plants here grow no error by more than a factor 100
/// over the runs.
const INTEGRATION: f64 = 1e-8;

fn errors(run: &Trajectory) -> Vec<(f64, DVector<f64>)> {
    run.t.iter().copied().zip(run.observers[0].error.row_iter().map(|row| row.transpose())).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, failure_persistence: None, ..ProptestConfig::default() })]

    /// On all of the state space: sqrt(cond P) |e0| exp(-rate t), and each component within its excursion. Both joints,
    /// several rates.
    #[test]
    fn the_joints_stay_below_their_envelopes(x0 in vector4(3.0), xhat0 in vector4(10.0), rate in prop_oneof![Just(0.5), Just(2.0), Just(6.0)]) {
        let region = Region::everywhere(4);
        let e0 = DVector::from_column_slice((x0 - xhat0).as_slice());
        macro_rules! check {
            ($plant:expr, $end:expr) => {
                let design = LpvDesign::new($plant, &region, rate).unwrap();
                prop_assert!(design.certificate.is_proved());
                let run = Scenario::new($plant)
                    .initial_state(x0.as_slice())
                    .input(Signal::scalar(f64::sin))
                    .observer("lpv", &design.observer, xhat0.as_slice())
                    .until($end, 101)
                    .run()
                    .unwrap();
                let excursion = design.excursion(&e0).unwrap();
                for (t, e) in errors(&run) {
                    let envelope = design.overshoot * e0.norm() * (-rate * t).exp();
                    prop_assert!(e.norm() <= envelope * (1.0 + 1e-9) + INTEGRATION, "{t}: {} {envelope}", e.norm());
                    for i in 0..4 {
                        prop_assert!(e[i].abs() <= excursion[i] * (1.0 + 1e-9) + INTEGRATION, "{t}: {e}{excursion}");
                    }
                }
            };
        }
        check!(flexible_joint::classical(), 5.0);
        // a44 = 3.33 makes the plant itself grow like exp(2.2 t).
        check!(flexible_joint::printed(), 1.0);
    }

    /// On a box: for as long as x and xhat are inside.
    #[test]
    fn the_chaotic_plant_stays_below_its_envelope_while_it_stays_in_the_box(
        shares in prop::array::uniform3(0.0f64..1.0), offset in prop::array::uniform3(-0.05f64..0.05),
    ) {
        let bounds = [(-3.0, -0.3), (-3.0, 3.0), (-3.0, 3.0)];
        let design = LpvDesign::new(Chaotic, &Region::new(&bounds), 0.5).unwrap();
        prop_assert!(design.certificate.is_proved());
        // The middle third of the box.
        let x0 = Vector3::from_fn(|k, _| bounds[k].0 + (1.0 + shares[k]) / 3.0 * (bounds[k].1 - bounds[k].0));
        let e0 = Vector3::from(offset);
        let run = Scenario::new(Chaotic)
            .initial_state(x0.as_slice())
            .observer("lpv", &design.observer, (x0 - e0).as_slice())
            .until(1.0, 201)
            .run()
            .unwrap();
        let inside = |x: &[f64]| x.iter().zip(&bounds).all(|(x, (lo, hi))| lo <= x && x <= hi);
        let mut samples = 0;
        for (k, (t, e)) in errors(&run).into_iter().enumerate() {
            let x: Vec<f64> = run.x.row(k).iter().copied().collect();
            let xhat: Vec<f64> = x.iter().zip(e.iter()).map(|(x, e)| x - e).collect();
            if !inside(&x) || !inside(&xhat) {
                break;
            }
            samples += 1;
            let envelope = design.overshoot * e0.norm() * (-design.rate * t).exp();
            prop_assert!(e.norm() <= envelope * (1.0 + 1e-9) + INTEGRATION, "{t}: {} {envelope}", e.norm());
        }
        // The slope is below 10 in the box, and the nearest wall 0.9 away from x0.
        prop_assert!(samples >= 10, "left the box at {}", run.t[samples]);
    }

    /// The mean value theorem with the paper's beta, and the integral mean, both inside the enclosure.
    #[test]
    fn both_means_lie_in_the_enclosure(from in prop::array::uniform3(0.0f64..=1.0), to in prop::array::uniform3(0.0f64..=1.0)) {
        let bounds = [(-3.0, 1.0), (-2.0, 3.0), (-3.0, 3.0)];
        let enclosure = enclose(&Chaotic, &Region::new(&bounds)).unwrap();
        let at = |shares: [f64; 3]| Vector3::from_fn(|k, _| bounds[k].0 + shares[k] * (bounds[k].1 - bounds[k].0));
        let (xhat, e) = (at(from), at(to) - at(from));
        let beta = mean_value(&Chaotic, 0.0, &xhat, &SVector::zeros(), &e).jacobian;
        let mean = |from: &Vector3<f64>, e: &Vector3<f64>| gauss_legendre(&Chaotic, 0.0, from, &SVector::zeros(), e);
        let half = e * 0.5;
        let integral = (mean(&xhat, &half) + mean(&(xhat + half), &half)) * 0.5;
        let difference = (integral - mean(&xhat, &e)).amax();
        for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
            let within = |entry: f64, slack: f64| {
                let widened = Interval::new(enclosure.a[(i, j)].lo() - slack, enclosure.a[(i, j)].hi() + slack);
                widened.unwrap().contains(entry)
            };
            // The means are rounded, and the quadrature of the halves is off by less than it differs from the whole's.
            prop_assert!(within(beta[(i, j)], 1e-14), "beta ({i}, {j})");
            prop_assert!(within(integral[(i, j)], 1e-14 + difference), "integral ({i}, {j})");
        }
    }
}

/// The excursion closes the hypothesis: a run that stays 1 away from the walls, and an estimate that starts near
/// enough, need no further assumption.
#[test]
fn the_excursion_keeps_the_estimate_in_the_box() {
    let bounds = [(-3.0, -0.3), (-3.0, 3.0), (-3.0, 3.0)];
    let design = LpvDesign::new(Chaotic, &Region::new(&bounds), 0.5).unwrap();
    let e0 = DVector::from_vec(vec![0.02, -0.02, 0.05]);
    let excursion = design.excursion(&e0).unwrap();
    assert!(excursion.iter().zip(e0.iter()).all(|(most, start)| *most >= start.abs()));
    // The same number through the inverse instead of the factor.
    let value = (e0.transpose() * &design.p * &e0)[(0, 0)];
    let inverse = design.p.clone().try_inverse().unwrap();
    for k in 0..3 {
        assert!((excursion[k].powi(2) - inverse[(k, k)] * value).abs() <= 1e-9 * excursion[k].powi(2));
    }
}
