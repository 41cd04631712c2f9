//! KKL and [KKL+PEB] observers beyond the converter: Propositions 6 and 7.
//!
//! Error equations are checked as algebraic identities at random states, not by integration: the error dynamics follow
//! from the right-hand sides of observer and plant.

use luenberger_design::kkl::{KklSettings, Pieces};
use luenberger_design::{IntervalDual, KklCandidate, Region, SymbolicPolynomial};
use luenberger_expression::{ExpressionPlant, Parameters};
use luenberger_observers::Observer;
use luenberger_observers::cascade::CascadeMap;
use luenberger_observers::diagnosis::{Diagnose, Diagnosis};
use luenberger_observers::estimator::drem::{Drem, Kreisselmeier, LtiFilters};
use luenberger_observers::estimator::excitation::Monitored;
use luenberger_observers::estimator::gradient::Gradient;
use luenberger_observers::kkl::KklMap;
use luenberger_observers::kkl_peb::KklPebObserver;
use luenberger_observers::pebo::Regression;
use luenberger_plants::{DrivenCascade, ExponentialCascade, Plant};
use luenberger_reproduce::kkl::driven_cascade;
use luenberger_reproduce::kkl::exponential_cascade::{self, ExponentialCascadeMap, LOWEST};
use luenberger_sim::{Scenario, Signal};
use nalgebra::{Matrix2, SVector, Vector1, Vector2, Vector3};
use proptest::prelude::*;

use crate::generators::vector2;

proptest! {
    /// Proposition 6, F4: `phi = (x2, x3)`, and `y' = -y^3 + exp(xi2) Theta` with `Theta = exp(x3 - xi2)`.
    #[test]
    fn the_maps_of_proposition_6_solve_its_equations(
        x in prop::array::uniform3(-2.0..2.0f64).prop_map(Vector3::from), xi in vector2(2.0), u in (-2.0..2.0f64).prop_map(Vector1::new),
    ) {
        let plant = ExponentialCascade;
        let (y, rate) = (plant.output(0.0, &x, &u), plant.derivative(0.0, &x, &u));
        let observer = exponential_cascade::observer(1.0, 5.0).unwrap();
        let map = observer.map();
        let slope = map.slope(0.0, &xi, &u, &y);
        // e = xi - phi(x): -e1, and 0.
        let rounding = 32.0 * f64::EPSILON * 10.0;
        prop_assert!((slope[0] - rate[1] + (xi[0] - x[1])).abs() <= rounding);
        prop_assert!((slope[1] - rate[2]).abs() <= rounding);
        let theta = (x[2] - xi[1]).exp();
        let claimed = map.known(0.0, &xi, &u, &y)[0] + map.regressor(0.0, &xi, &u, &y)[0] * theta;
        prop_assert!((rate[0] - claimed).abs() <= 64.0 * f64::EPSILON * (1.0 + theta) * 60.0, "{} {}", rate[0], claimed);
    }

    /// F3 of Proposition 6 does not survive a Lambda that depends on y and u: `e' = Lambda(y, u) e` with
    /// `Lambda <= diag(-1, 1 - c + u^2/12)`, and phi^L takes phi back.
    #[test]
    fn the_plant_of_proposition_6_has_a_kklo(
        x in prop::array::uniform3(-2.0..2.0f64).prop_map(Vector3::from), xi in vector2(5.0), u in (-3.0..3.0f64).prop_map(Vector1::new), c in 0.1..10.0f64,
    ) {
        let plant = ExponentialCascade;
        let (y, rate) = (plant.output(0.0, &x, &u), plant.derivative(0.0, &x, &u));
        let observer = exponential_cascade::kklo(c).unwrap();
        let map = observer.map();
        let phi = map.image(0.0, &Vector2::new(x[1], x[2]), &y);
        // d/dt (exp(x3) - c y - y^3), by hand.
        let phi_rate = Vector2::new(rate[1], x[2].exp() * rate[2] - (c + 3.0 * y[0] * y[0]) * rate[0]);
        let lambda = map.lambda(0.0, &u, &y);
        let e_rate = map.slope(0.0, &xi, &u, &y) - phi_rate;
        // Lambda up to 30, phi up to 40, k' y^3 up to 200.
        prop_assert!((e_rate - lambda * (xi - phi)).amax() <= 64.0 * f64::EPSILON * 1400.0, "{} {}", e_rate, lambda * (xi - phi));
        prop_assert!(lambda[(0, 0)] == -1.0 && lambda[(1, 1)] <= 1.0 - c + u[0] * u[0] / 12.0 + 1e-14);
        // phi is up to 30 away from 0, exp(x3) only 0.1.
        prop_assert!((map.left_inverse(0.0, &phi, &y) - Vector2::new(x[1], x[2])).amax() <= 8.0 * f64::EPSILON * 300.0);
    }
}

/// Outputs that overflow make no NaN in that KKLO, and an estimate below the domain of the logarithm is held.
#[test]
fn the_kklo_of_proposition_6_stays_finite() {
    let observer = exponential_cascade::kklo(2.0).unwrap();
    for y in [1e200, -1e200, f64::MAX, 1e-320] {
        let (u, y) = (Vector1::new(-y), Vector1::new(y));
        let state = Vector2::new(1.0, -1e10);
        assert!(!observer.derivative(0.0, &state, &u, &y).iter().any(|entry| entry.is_nan()), "{y}");
        assert!(observer.estimate(0.0, &state, &u, &y).iter().all(|entry| entry.is_finite()), "{y}");
    }
    let held = observer.estimate(0.0, &Vector2::new(0.0, -1.0), &Vector1::new(0.0), &Vector1::new(0.0));
    assert_eq!(held[1], LOWEST.ln());
    assert!(exponential_cascade::kklo(0.0).is_err() && exponential_cascade::kklo(f64::NAN).is_err());
}

/// Proposition 6's run: x(0) = (0.5, -1, 0.3), u = -y, everything in the observer from 0, alpha = 1, gamma = 5.
#[test]
fn the_observer_of_proposition_6_converges() {
    let observer = exponential_cascade::observer(1.0, 5.0).unwrap();
    let run = Scenario::new(ExponentialCascade)
        .initial_state(&[0.5, -1.0, 0.3])
        .input(Signal::law(|view, u| u[0] = -view.y[0]))
        .partial_observer("[KKL+PEB]O", &observer, &[0.0, 0.0], &[1, 2])
        .until(12.0, 241)
        .run()
        .unwrap();
    let found = run.observer("[KKL+PEB]O").unwrap();
    for k in 0..241 {
        // e2 = x2 - xi1 obeys e' = -e; 1e-9 is a hundred times the tolerance of the run.
        assert!((found.error[(k, 0)] + (-run.t[k]).exp()).abs() <= 1e-9, "{}", found.error[(k, 0)]);
        // The regression is exact from the start: Theta_hat approaches Theta = exp(0.3) from below, monotonically.
        let theta = found.state[(k, 5)];
        assert!(theta <= 0.3f64.exp() + 1e-9 && (k == 0 || theta >= found.state[(k - 1, 5)] - 1e-9));
        let state = SVector::from_fn(|i, _| found.state[(k, i)]);
        let healthy = observer.diagnose(run.t[k], &state, &Vector1::new(run.u[(k, 0)]), &Vector1::new(run.y[(k, 0)]));
        assert_eq!(healthy, Diagnosis::Sound);
        // The plant stays bounded with u = -y.
        assert!(run.x.row(k).amax() <= 2.0);
    }
    assert!(found.error.row(240).amax() <= 1e-5, "{}", found.error.row(240));
}

/// What u = 0 does to the same plant: x3' = 1/(x1^2 + 1) > 0, and it never stops.
#[test]
fn without_input_the_plant_of_proposition_6_drifts() {
    let run = Scenario::new(ExponentialCascade).initial_state(&[0.5, -1.0, 0.3]).until(30.0, 31).run().unwrap();
    assert!((1..31).all(|k| run.x[(k, 2)] > run.x[(k - 1, 2)]) && run.x[(30, 2)] > 2.0);
}

/// Proposition 7: with either estimator the whole state is found, and the run was exciting.
///
/// Gamma is small on purpose: a large one removes the error along psi at once and lets the rest wait for psi to turn.
#[test]
fn the_class_of_proposition_7_is_observed() {
    let map = CascadeMap::new::<f64>(driven_cascade::Pieces).unwrap();
    let gradient =
        KklPebObserver::new(map, Monitored::new(Gradient::new(Matrix2::identity() * 2.0).unwrap(), 0.0).unwrap(), 5.0)
            .unwrap();
    let filters = LtiFilters::new(Vector1::new(1.0)).unwrap();
    let square = KklPebObserver::new(map, Drem::new(Vector2::repeat(200.0), filters).unwrap(), 5.0).unwrap();
    let gram =
        KklPebObserver::new(map, Drem::new(Vector2::repeat(10.0), Kreisselmeier::new(0.5).unwrap()).unwrap(), 5.0)
            .unwrap();
    // 4 for xi, 4 for the filters, 2 for theta_hat; then the Gramian, 3 for one filter of (Y, M), 6 for (Z, Phi).
    assert_eq!([gradient.dimensions().state, square.dimensions().state, gram.dimensions().state], [14, 13, 16]);
    let run = Scenario::new(DrivenCascade)
        .initial_state(&[1.0, -1.0, 0.5, -0.5, 2.0, -1.0])
        .input(Signal::function(|t, u| (u[0], u[1]) = ((2.0 * t).sin(), 1.0)))
        .partial_observer("gradient", &gradient, &[0.0; 4], &[2, 3, 4, 5])
        .partial_observer("filters", &square, &[0.0; 4], &[2, 3, 4, 5])
        .partial_observer("Kreisselmeier", &gram, &[0.0; 4], &[2, 3, 4, 5])
        .tolerances(1e-8, 1e-9)
        .until(30.0, 301)
        .run()
        .unwrap();
    for name in ["gradient", "filters", "Kreisselmeier"] {
        let error = &run.observer(name).unwrap().error;
        assert!(error.row(0).amax() >= 2.0);
        assert!(error.row(300).amax() <= 1e-4, "{name}: {}", error.row(300));
    }
    let last = |name: &str| run.observer(name).unwrap().state.row(300).transpose();
    let excitation = [
        gradient.excitation(&SVector::from_column_slice(last("gradient").as_slice())).unwrap(),
        gram.excitation(&SVector::from_column_slice(last("Kreisselmeier").as_slice())).unwrap(),
    ];
    // 30 s of sin^2 and 1 through the filter: about 13 and 30 on the diagonal, with 13 at most for the smallest
    // eigenvalue.
    assert!(excitation[0] > 5.0 && excitation[0] < 15.0 && excitation[1] > 0.0, "{excitation:?}");
}

/// Nothing excites: b = (1, 0) for ever. theta_2 is not seen, the estimate of x4_2 keeps its error, and the observer
/// says that it cannot know.
#[test]
fn a_run_without_excitation_says_so() {
    let map = CascadeMap::new::<f64>(driven_cascade::Pieces).unwrap();
    let monitored = Monitored::new(Gradient::new(Matrix2::identity() * 20.0).unwrap(), 0.0).unwrap();
    let observer = KklPebObserver::new(map, monitored, 5.0).unwrap().wanting_excitation(1.0);
    let run = Scenario::new(DrivenCascade)
        .initial_state(&[1.0, -1.0, 0.5, -0.5, 2.0, -1.0])
        .input(Signal::constant(&[1.0, 0.0]))
        .partial_observer("gradient", &observer, &[0.0; 4], &[2, 3, 4, 5])
        .until(20.0, 21)
        .run()
        .unwrap();
    let found = run.observer("gradient").unwrap();
    assert!((found.error[(20, 3)] + 1.0).abs() <= 1e-9 && found.error[(20, 2)].abs() <= 1e-4);
    let state = SVector::from_fn(|i, _| found.state[(20, i)]);
    let said = observer.diagnose(20.0, &state, &Vector2::new(1.0, 0.0), &Vector2::new(run.y[(20, 0)], run.y[(20, 1)]));
    assert_eq!(said, Diagnosis::NotExciting { excitation: 0.0, wanted: 1.0 });
}

/// Proposition 6's maps are checked against its plant, in Rust and in text: the terms of the two sides of (4) cancel in
/// both.
#[test]
fn the_maps_of_proposition_6_are_proved_over_a_box() {
    fn check<S>(plant: &S)
    where
        for<'a> KklCandidate<'a, S, ExponentialCascadeMap>: Pieces<IntervalDual> + Pieces<SymbolicPolynomial>,
        S: Plant<IntervalDual>,
    {
        let region = Region::new(&[(-2.0, 2.0), (-2.0, 2.0), (-1.0, 1.0)]).inputs(&[(-3.0, 3.0)]);
        let candidate = KklCandidate::new(plant, &ExponentialCascadeMap, &[1, 2]).unwrap();
        let report = candidate.check(&region, &KklSettings::default()).unwrap();
        assert_eq!(report.residual.bounds, [0.0, 0.0]);
        assert!(report.residual.verdict.is_proved() && report.injectivity.verdict.is_proved());
        // The second entry of xi is only integrated, which is for a parameter estimator to make up for.
        assert!(report.stability.is_proved() && report.stability.integrated == [1]);
    }
    check(&ExponentialCascade);
    let f = ["-x1^3 + exp(x3)", "-x2 + x1^2 + sin(x1)", "1/(x1^2 + 1) + x1*u1"];
    check(&ExpressionPlant::new(&f, &["x1"], 1, &Parameters::default()).unwrap());
}
