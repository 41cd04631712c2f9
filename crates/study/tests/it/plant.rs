//! Plants of the papers written as text are those written in Rust: right-hand sides, Jacobians, and what designs prove of them.

use luenberger_design::enclosure::enclose;
use luenberger_design::numerical_kkl::{Domain, Escape, Target, Transform};
use luenberger_design::{LpvDesign, LpvError, Region};
use luenberger_observers::kalman::{ExtendedKalmanFilter, NoiseModel};
use luenberger_observers::mean_value::EstimateAndError;
use luenberger_observers::{Integral, MeanValueObserver, NonlinearLuenbergerObserver, Observer, SampledObserver};
use luenberger_plants::{
    Chaotic, Column, CukConverter, Differentiable, Dimensions, Plant, ReverseDuffing, VanDerPol, flexible_joint,
};
use luenberger_sim::{Scenario, Signal};
use luenberger_study::expression::Parameters;
use luenberger_study::plant::{AffineError, ExpressionPlant, ExpressionPlantError, Row};
use nalgebra::{Const, DMatrix, DVector, Dyn, OVector, SVector, Vector2, Vector3, dmatrix, dvector};
use proptest::prelude::*;

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

fn cuk() -> ExpressionPlant {
    let f = ["(-(1 - u1)*x2 + E)/L1", "((1 - u1)*x1 + u1*x3)/C2", "(-u1*x2 - x4)/L3", "(x3 - G*x4)/C4"];
    let c = CukConverter::default();
    let named = [("L1", c.l1), ("C2", c.c2), ("L3", c.l3), ("C4", c.c4), ("G", c.g), ("E", c.e)];
    plant(&f, &["x2", "x3"], 1, &named)
}

/// Two plants at one point: the largest difference of f, h, Df and Dh, relative to the largest entry.
fn apart<S, const N: usize, const M: usize, const P: usize>(
    text: &ExpressionPlant,
    rust: &S,
    t: f64,
    x: &OVector<f64, Const<N>>,
    u: &OVector<f64, Const<M>>,
) -> f64
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
{
    assert_eq!(Plant::<f64>::dimensions(text), Dimensions { states: N, inputs: M, outputs: P });
    let (dx, du) = (DVector::from_slice(x.as_slice()), DVector::from_slice(u.as_slice()));
    let far = |found: &[f64], expected: &[f64]| {
        let scale = expected.iter().fold(1.0f64, |scale, entry| scale.max(entry.abs()));
        found.iter().zip(expected).fold(0.0f64, |far, (a, b)| far.max((a - b).abs())) / scale
    };
    far(text.derivative(t, &dx, &du).as_slice(), rust.derivative(t, x, u).as_slice())
        .max(far(text.output(t, &dx).as_slice(), rust.output(t, x).as_slice()))
        .max(far(text.state_jacobian(t, &dx, &du).as_slice(), rust.state_jacobian(t, x, u).as_slice()))
        .max(far(text.output_jacobian(t, &dx).as_slice(), rust.output_jacobian(t, x).as_slice()))
}

/// Rounding of a right-hand side of some ten operations, relative to its largest term.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

proptest! {
    /// The same right-hand sides, outputs and Jacobians wherever they are evaluated.
    #[test]
    fn the_papers_plants_are_those_written_in_rust(
        x in prop::array::uniform4(-5.0..5.0f64), u in -2.0..2.0f64, t in 0.0..9.0f64,
    ) {
        let (x2, x3, x4) = ([x[0], x[1]].into(), [x[0], x[1], x[2]].into(), x.into());
        let u = [u].into();
        prop_assert!(apart(&chaotic(), &Chaotic, t, &x3, &[].into()) <= ROUNDING);
        prop_assert!(apart(&joint(), &flexible_joint::classical(), t, &x4, &u) <= ROUNDING);
        prop_assert!(apart(&cuk(), &CukConverter::default(), t, &x4, &u) <= ROUNDING);
        let duffing = plant(&["x2^3", "-x1"], &["x1"], 0, &[]);
        prop_assert!(apart(&duffing, &ReverseDuffing, t, &x2, &[].into()) <= ROUNDING);
        let oscillator = plant(&["x2", "mu*(1 - x1^2)*x2 - x1"], &["x1"], 0, &[("mu", 1.5)]);
        let rust = VanDerPol { mu: 1.5 };
        prop_assert!(apart(&oscillator, &rust, t, &x2, &[].into()) <= ROUNDING);
        // And with the sizes in the type.
        let fixed = joint().fixed::<4, 1, 2>().unwrap();
        let (found, expected) =
            (fixed.derivative(t, &x4, &u), joint().derivative(t, &DVector::from_slice(&x), &DVector::from_slice(u.as_slice())));
        prop_assert_eq!(found.as_slice(), expected.as_slice());
    }
}

/// Over a box the text is enclosed as the Rust plant is, and the same gain is proved with the same rate.
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
    // What one plant's gain is proved for, the other's is.
    let l = DMatrix::from_fn(4, 2, |i, j| rust.observer.l()[(i, j)]);
    let crossed = LpvDesign::certify(joint(), &everywhere, &l).unwrap();
    assert!(crossed.certificate.is_proved() && crossed.rate >= rust.rate);
}

/// The chaotic plant in text is compiled to the two branches of the one in Rust: its Jacobians have the same bounds, and the same is proved of it.
#[test]
fn the_chaotic_plant_in_text_is_proved_away_from_0() {
    let region = Region::new(&[(-3.0, -0.3), (-3.0, 3.0), (-3.0, 3.0)]);
    let (text, rust) = (enclose(&chaotic(), &region).unwrap(), enclose(&Chaotic, &region).unwrap());
    assert_eq!((&text.a, &text.c), (&rust.a, &rust.c));
    let design = LpvDesign::new(chaotic(), &region, 0.5).unwrap();
    assert_eq!(design.polytope.vertices.len(), 64);
    assert!(design.certificate.is_proved());
    // Where x1 can vanish x3 is hidden, whoever wrote the plant.
    let error = LpvDesign::new(chaotic(), &Region::new(&[(-3.0, 3.0); 3]), 0.0).unwrap_err();
    assert!(matches!(error, LpvError::HiddenMode(_)), "{error}");
}

/// A kink is bounded by its two sides, a jump and a pole are refused by name.
#[test]
fn boxes_are_honest_about_kinks_jumps_and_poles() {
    let region = Region::new(&[(-1.0, 2.0)]);
    let kink = enclose(&plant(&["sat(2*x1) - abs(x1)"], &["x1"], 0, &[]), &region).unwrap().a[(0, 0)];
    assert!(kink.lo() <= -1.0 && kink.hi() >= 3.0 && kink.width() <= 4.001, "{kink:?}");
    for text in ["sign(x1)", "1/x1", "ln(x1)", "sqrt(abs(x1))", "x1^0.25", "atan2(x1, -1)"] {
        assert!(enclose(&plant(&[text], &["x1"], 0, &[]), &region).is_err(), "{text}");
    }
    // Beyond 300 the hyperbolic tangent takes another way, and its derivative is bounded there as everywhere.
    let tanh = enclose(&plant(&["tanh(x1)"], &["x1"], 0, &[]), &Region::new(&[(-1000.0, 1000.0)])).unwrap().a[(0, 0)];
    assert!(tanh.lo() >= -0.01 && tanh.hi() >= 1.0 && tanh.hi() <= 1.1, "{tanh:?}");
}

/// Observers of run-time size run on it: the copy with a gain, and the filter that differentiates.
#[test]
fn observers_run_on_a_plant_of_text() {
    let design = LpvDesign::new(joint(), &Region::everywhere(4), 1.0).unwrap();
    let x0 = [0.5, -0.2, 0.3, 0.1];
    let run = |scenario: Scenario<'_>| {
        scenario.initial_state(&x0).input(Signal::scalar(|t| 0.1 * t.sin())).until(6.0, 61).run().unwrap()
    };
    let text = run(Scenario::new(joint()).observer("lpv", design.observer.clone(), &[0.0; 4]));
    let l = design.observer.l().clone_owned();
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
    let mut belief = filter.initial(0.0, &DVector::zeros(4), &u, &y);
    filter.step(0.0, &mut belief, &u, &y);
    assert!((belief.estimate()[0] - 0.5).abs() < 0.05 && belief.as_slice().len() == 20);
}

/// With fixed sizes its past is simulated.
#[test]
fn kkl_designs_take_it() {
    let domain = Domain::new([-1.0; 2], [1.0; 2], Escape::Free).unwrap();
    let target = Target::<1, 3>::bessel(2.0).unwrap();
    let duffing = plant(&["x2^3", "-x1"], &["x1"], 0, &[]).fixed::<2, 0, 1>().unwrap();
    let text = Transform::new(&duffing, &target, &domain, SVector::zeros(), 1e-9).unwrap();
    let rust = Transform::new(&ReverseDuffing, &target, &domain, SVector::zeros(), 1e-9).unwrap();
    let x = Vector2::new(0.5, -0.3);
    // Two integrations at 1e-9 of right-hand sides that differ by rounding.
    assert!((text.at(&x).unwrap() - rust.at(&x).unwrap()).amax() < 1e-8);
}

/// The observer that integrates the Jacobian between estimate and measurement differentiates it, and single precision runs it.
#[test]
fn mean_value_observers_and_single_precision_run_on_it() {
    let text = MeanValueObserver::new(chaotic(), 2.0, Integral, DVector::zeros(3)).unwrap();
    let rust = MeanValueObserver::new(Chaotic, 2.0, Integral, Vector3::zeros()).unwrap();
    let (x, e, y) = (dvector![0.3f64, -0.2, 1.1], dvector![0.1, 0.2, -0.4], dvector![0.5, 0.4]);
    let found = text.derivative(0.0, &EstimateAndError::new(&x, &e), &DVector::zeros(0), &y);
    let state = EstimateAndError::new(&[0.3, -0.2, 1.1].into(), &[0.1, 0.2, -0.4].into());
    let expected = rust.derivative(0.0, &state, &SVector::zeros(), &[0.5, 0.4].into());
    for (a, b) in found.as_slice().iter().zip(expected.as_slice()) {
        let (a, b): (f64, f64) = (*a, *b);
        // The adaptive quadrature of the Jacobian takes the same nodes; what differs is rounding, amplified by eta and the solution of a 3 x 3 system.
        assert!((a - b).abs() <= 100.0 * ROUNDING * (1.0 + b.abs()), "{a} {b}");
    }
    let single = joint().derivative(0.0f32, &dvector![0.1, 0.2, 0.3, 0.4], &dvector![0.5]);
    let double = joint().derivative(0.0, &dvector![0.1, 0.2, 0.3, 0.4], &dvector![0.5]);
    assert!(single.iter().zip(&double).all(|(a, b)| (f64::from(*a) - b).abs() <= 1e2 * f64::from(f32::EPSILON)));
}

/// A linear plant in text has its matrices, whatever the form of its rows; a nonlinear one says which part is not.
#[test]
fn linear_plants_are_found_out() {
    let text = plant(
        &["x2/T", "(u1 - c*x1 - 2*(x2 + u2*k))/m"],
        &["x1 - x2", "k*x2"],
        2,
        &[("T", 0.5), ("c", 3.0), ("m", 4.0), ("k", 0.25)],
    );
    let affine = text.affine().unwrap();
    assert!(affine.is_linear());
    assert_eq!(affine.linear.a, dmatrix![0.0, 2.0; -0.75, -0.5]);
    assert_eq!(affine.linear.b, dmatrix![0.0, 0.0; 0.25, -0.125]);
    assert_eq!(affine.linear.c, dmatrix![1.0, -1.0; 0.0, 0.25]);
    let offset = plant(&["1 - x1"], &["x1 + 2"], 0, &[]).affine().unwrap();
    assert!(!offset.is_linear());
    assert_eq!((offset.f0, offset.h0), (dvector![1.0], dvector![2.0]));
    let error = joint().affine().unwrap_err();
    assert_eq!(
        error.to_string(),
        "f4 = 19.5*x1 - 19.5*x3 - 3.33*sin(x3) is not affine in states and inputs: `sin(x3)` is not"
    );
    assert!(matches!(plant(&["x1/0"], &["x1"], 0, &[]).affine(), Err(AffineError::Undefined(_))));
}

/// Bad plants, each with its numbers.
#[test]
fn bad_plants_are_refused() {
    let new = |f: &[&str], h: &[&str], named: &[(&str, f64)]| {
        ExpressionPlant::new(f, h, 1, &parameters(named)).unwrap_err().to_string()
    };
    assert_eq!(new(&[], &["x1"], &[]), "a plant needs at least one state and one output: f has 0 rows, h has 1");
    assert_eq!(
        new(&["x2", "x3"], &["x1"], &[]),
        "f2: line 1, column 1: there is no `x3`: there are 2 states, x1 to x2"
    );
    assert_eq!(
        new(&["x1"], &["x1", "u1"], &[]),
        "h2: line 1, column 1: `u1` may not be used here: an output y = h(t, x) does not depend on the input"
    );
    assert_eq!(new(&["x1"], &["x1"], &[("sin", 1.0)]), "`sin` cannot be the name of a parameter: it is a function");
    assert_eq!(new(&["x1"], &["x1"], &[("k", f64::NAN)]), "the parameter `k` is NaN, not a finite number");
    assert!(new(&["x1"], &["x1"], &[("a b", 1.0)]).contains("letters, digits and _"));
    assert!(new(&["x1"; 1001], &["x1"], &[]).contains("at most 1000"));

    let text = plant(&["x2", "u1/(x1 - 1)"], &["ln(x2)"], 1, &[]);
    let at = |x: &[f64], u: &[f64]| text.check_at(0.0, x, u);
    assert!(at(&[2.0, 1.0], &[1.0]).is_ok());
    let error = at(&[1.0, 1.0], &[2.0]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "f2 = u1/(x1 - 1): `u1/(x1 - 1)` is infinite: `u1` is 2 and `(x1 - 1)` is 0, at x = [1.0, 1.0], u = [2.0]"
    );
    assert!(matches!(at(&[2.0, 0.0], &[0.0]), Err(ExpressionPlantError::Undefined { row: Row::Output(0), .. })));
    assert!(matches!(at(&[2.0], &[0.0]), Err(ExpressionPlantError::Length { expected: 2, found: 1, .. })));
    assert!(matches!(at(&[2.0, f64::INFINITY], &[0.0]), Err(ExpressionPlantError::NotFinite { index: 1, .. })));
    assert!(matches!(text.fixed::<2, 1, 2>(), Err(ExpressionPlantError::Sizes { .. })));
    assert_eq!(text.fixed::<2, 1, 1>().unwrap().output(0.0, &Vector2::new(0.0, 1.0))[0], 0.0);
}
