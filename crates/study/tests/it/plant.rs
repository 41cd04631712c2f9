//! The papers' plants given as expressions: designs prove the same as for the Rust versions, and observers run on them.

use luenberger_design::enclosure::enclose;
use luenberger_design::numerical_kkl::{Domain, Escape, TargetSystem, Transform};
use luenberger_design::{LpvDesign, LpvError, Region};
use luenberger_expression::{ExpressionPlant, Parameters};
use luenberger_observers::kalman::{ExtendedKalmanFilter, NoiseModel};
use luenberger_observers::mean_value::EstimateAndError;
use luenberger_observers::{Integral, MeanValueObserver, NonlinearLuenbergerObserver, Observer, SampledObserver};
use luenberger_plants::{Chaotic, Column, Plant, ReverseDuffing, flexible_joint};
use luenberger_sim::{Scenario, Signal};
use luenberger_study::model::{Builtin, Model};
use nalgebra::{DMatrix, DVector, Dyn, SVector, Vector2, Vector3, dvector};

fn parameters(named: &[(&str, f64)]) -> Parameters {
    named.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
}

fn plant(f: &[&str], h: &[&str], inputs: usize, named: &[(&str, f64)]) -> ExpressionPlant {
    ExpressionPlant::new(f, h, inputs, &parameters(named)).unwrap_or_else(|error| panic!("{error}"))
}

fn chaotic() -> ExpressionPlant {
    plant(&["ln(0.1 + exp(x2 - x1))", "x1*x3", "0.2 - x1*x2"], &["x1", "x2"], 0, &[])
}

fn joint() -> ExpressionPlant {
    let f = ["x2", "-48.6*x1 - 1.25*x2 + 48.6*x3 + 21.6*u1", "x4", "19.5*x1 - 19.5*x3 - 3.33*sin(x3)"];
    plant(&f, &["x1", "x2"], 1, &[])
}

/// Rounding of a right-hand side of some ten operations, relative to its largest term.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// The interval enclosure of the expressions over a box equals that of the Rust plant, and the same gain is proved with
/// the same rate.
#[test]
fn designs_prove_the_same_of_both() {
    let everywhere = Region::everywhere(4);
    let (text, rust) =
        (enclose(&joint(), &everywhere).unwrap(), enclose(&flexible_joint::classical(), &everywhere).unwrap());
    for i in 0..4 {
        for j in 0..4 {
            let (a, b) = (text.a[(i, j)], rust.a[(i, j)]);
            let scale = b.magnitude().max(1.0);
            let apart = (a.lo() - b.lo()).abs().max((a.hi() - b.hi()).abs());
            assert!(apart <= ROUNDING * scale, "A({i}, {j}): {a:?} and {b:?}");
        }
    }
    let text = LpvDesign::new(joint(), &everywhere, 1.0).unwrap();
    let rust = LpvDesign::new(flexible_joint::classical(), &everywhere, 1.0).unwrap();
    assert!(text.certificate.is_proved() && rust.certificate.is_proved());
    assert_eq!(text.polytope.vertices.len(), rust.polytope.vertices.len());
    // A gain proved for one plant is proved for the other.
    let l = DMatrix::from_fn(4, 2, |i, j| rust.l()[(i, j)]);
    let crossed = LpvDesign::certify(joint(), &everywhere, &l).unwrap();
    assert!(crossed.certificate.is_proved() && crossed.rate >= rust.rate);
}

/// The expressions of the chaotic plant are compiled to the two branches of the Rust version: its Jacobians have the
/// same bounds, and the same is proved.
#[test]
fn the_chaotic_plant_in_text_is_proved_away_from_0() {
    let region = Region::new(&[(-3.0, -0.3), (-3.0, 3.0), (-3.0, 3.0)]);
    let (text, rust) = (enclose(&chaotic(), &region).unwrap(), enclose(&Chaotic, &region).unwrap());
    assert_eq!((&text.a, &text.c), (&rust.a, &rust.c));
    let design = LpvDesign::new(chaotic(), &region, 0.5).unwrap();
    assert_eq!(design.polytope.vertices.len(), 64);
    assert!(design.certificate.is_proved());
    // Where x1 can vanish x3 is unobservable, in both versions.
    let error = LpvDesign::new(chaotic(), &Region::new(&[(-3.0, 3.0); 3]), 0.0).unwrap_err();
    assert!(matches!(error, LpvError::HiddenMode(_)), "{error}");
}

/// A kink is enclosed by its one-sided derivatives; a jump and a pole are rejected by name.
#[test]
fn boxes_are_honest_about_kinks_jumps_and_poles() {
    let region = Region::new(&[(-1.0, 2.0)]);
    let kink = enclose(&plant(&["sat(2*x1) - abs(x1)"], &["x1"], 0, &[]), &region).unwrap().a[(0, 0)];
    assert!(kink.lo() <= -1.0 && kink.hi() >= 3.0 && kink.width() <= 4.001, "{kink:?}");
    for text in ["sign(x1)", "1/x1", "ln(x1)", "sqrt(abs(x1))", "x1^0.25", "atan2(x1, -1)"] {
        assert!(enclose(&plant(&[text], &["x1"], 0, &[]), &region).is_err(), "{text}");
    }
    // Beyond 300 the hyperbolic tangent uses another branch; its derivative is bounded there too.
    let tanh = enclose(&plant(&["tanh(x1)"], &["x1"], 0, &[]), &Region::new(&[(-1000.0, 1000.0)])).unwrap().a[(0, 0)];
    assert!(tanh.lo() >= -0.01 && tanh.hi() >= 1.0 && tanh.hi() <= 1.1, "{tanh:?}");
}

/// Observers of run-time size run on it: the copy with a gain, and the extended Kalman filter, which uses derivatives.
#[test]
fn observers_run_on_a_plant_of_text() {
    let design = LpvDesign::new(joint(), &Region::everywhere(4), 1.0).unwrap();
    let x0 = [0.5, -0.2, 0.3, 0.1];
    let run = |scenario: Scenario<'_>| {
        scenario.initial_state(&x0).input(Signal::scalar(|t| 0.1 * t.sin())).until(6.0, 61).run().unwrap()
    };
    let text = run(Scenario::new(joint()).observer("lpv", design.observer.clone(), &[0.0; 4]));
    let l = design.l().clone_owned();
    let l = nalgebra::Matrix4x2::from_fn(|i, j| l[(i, j)]);
    let twin = NonlinearLuenbergerObserver::new(flexible_joint::classical(), l).unwrap();
    let rust = run(Scenario::new(flexible_joint::classical()).observer("lpv", twin, &[0.0; 4]));
    // Two integrations to 1e-11 whose right-hand sides differ by rounding.
    let apart = (&text.observers[0].estimate - &rust.observers[0].estimate).amax();
    assert!(apart < 1e-8, "{apart:e}");
    let noises =
        NoiseModel { w: DMatrix::identity(4, 4) * 0.1, v: DMatrix::identity(2, 2) * 1e-4, p0: DMatrix::identity(4, 4) };
    let filter: ExtendedKalmanFilter<_, f64, Dyn, Dyn, Dyn> =
        ExtendedKalmanFilter::new(joint(), noises, 0.01, 2).unwrap();
    let (u, y) = (dvector![0.0], dvector![0.5, -0.2]);
    let mut estimate = filter.initial(0.0, &DVector::zeros(4), &u, &y);
    filter.step(0.0, &mut estimate, &u, &y);
    assert!((estimate.estimate()[0] - 0.5).abs() < 0.05 && estimate.as_slice().len() == 20);
}

/// With fixed sizes the plant is simulated backwards in time for the KKL observer.
#[test]
fn kkl_designs_take_it() {
    let domain = Domain::new([-1.0; 2], [1.0; 2], Escape::Free).unwrap();
    let target = TargetSystem::<1, 3>::bessel(2.0).unwrap();
    let duffing = plant(&["x2^3", "-x1"], &["x1"], 0, &[]).fixed::<2, 0, 1>().unwrap();
    let text = Transform::new(&duffing, &target, &domain, SVector::zeros(), 1e-9).unwrap();
    let rust = Transform::new(&ReverseDuffing, &target, &domain, SVector::zeros(), 1e-9).unwrap();
    let x = Vector2::new(0.5, -0.3);
    // Two integrations at 1e-9 of right-hand sides that differ by rounding.
    assert!((text.at(&x).unwrap() - rust.at(&x).unwrap()).amax() < 1e-8);
}

/// The observer that integrates the Jacobian between estimate and measurement differentiates it.
#[test]
fn mean_value_observers_run_on_it() {
    let text = MeanValueObserver::new(chaotic(), 2.0, Integral, DVector::zeros(3)).unwrap();
    let rust = MeanValueObserver::new(Chaotic, 2.0, Integral, Vector3::zeros()).unwrap();
    let (x, e, y) = (dvector![0.3f64, -0.2, 1.1], dvector![0.1, 0.2, -0.4], dvector![0.5, 0.4]);
    let found = text.derivative(0.0, &EstimateAndError::new(&x, &e), &DVector::zeros(0), &y);
    let state = EstimateAndError::new(&[0.3, -0.2, 1.1].into(), &[0.1, 0.2, -0.4].into());
    let expected = rust.derivative(0.0, &state, &SVector::zeros(), &[0.5, 0.4].into());
    for (a, b) in found.as_slice().iter().zip(expected.as_slice()) {
        let (a, b): (f64, f64) = (*a, *b);
        // The adaptive quadrature of the Jacobian takes the same nodes; what differs is rounding, amplified by eta and
        // the solution of a 3 x 3 system.
        assert!((a - b).abs() <= 100.0 * ROUNDING * (1.0 + b.abs()), "{a} {b}");
    }
}

/// The expressions of each plant of the library have its values, at states without symmetry.
#[test]
fn expressions_of_the_library_have_the_values_of_the_plants() {
    let names = [
        "double-integrator",
        "third-order",
        "flexible-joint",
        "flexible-joint-printed",
        "chaotic",
        "cuk",
        "reverse-duffing",
        "van-der-pol",
        "exponential-cascade",
    ];
    for name in names {
        let model = Model::Builtin(Builtin::named(name).unwrap());
        let plant = model.expressions().unwrap();
        for seed in [1.0, 7.0, 19.0] {
            let entry = |i: usize, _: usize| 0.1 + 0.8 * ((i as f64 + seed) * 0.618_033_988).fract();
            let x = DVector::from_fn(model.size().states, entry);
            let u = DVector::repeat(model.size().inputs, 0.3);
            let same = |a: DVector<f64>, b: DVector<f64>| {
                assert!((&a - &b).amax() <= 1e-14 * (1.0 + b.amax()), "{name}: {a} {b}");
            };
            same(plant.derivative(0.0, &x, &u), model.derivative(0.0, &x, &u));
            same(plant.output(0.0, &x, &u), model.output(0.0, &x, &u));
        }
    }
}
