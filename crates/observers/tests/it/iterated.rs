//! The iterated extended Kalman filter: against Gauss-Newton steps in information form, the maximum of the posterior
//! density, fractions worked by hand, the Kalman filter of linear plants, and on bad samples.

#![cfg(feature = "dual")]

use luenberger_observers::{
    ExtendedKalmanFilter, GaussianEstimate, KalmanFilter, KalmanModel, NoiseModel, ObserverError, SampledObserver,
};
use luenberger_plants::{ByDual, Column, Differentiable, Dimensions, Plant, Shape, StaticPlant, plant};
use nalgebra::{
    Const, DMatrix, DVector, Dyn, Matrix1, Matrix2, Matrix3, Matrix3x2, RealField, SVector, Vector1, Vector2, Vector3,
    convert,
};
use proptest::prelude::*;

/// A point at rest, whose distance from the origin and whose bearing are measured.
#[derive(Clone, Debug)]
struct Radar;

plant!(Radar, (2, 0, 2), |plant, _t, x, u| [x[0], x[1]], [(x[0] * x[0] + x[1] * x[1]).sqrt(), x[1].atan2(x[0])]);

/// The same with sizes known at run time.
#[derive(Clone, Debug)]
struct DynamicRadar;

impl Shape for DynamicRadar {
    fn dimensions(&self) -> Dimensions {
        Radar.dimensions()
    }
}

impl ByDual for DynamicRadar {}

impl<T: RealField + Copy> Plant<T> for DynamicRadar {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;

    fn derivative(&self, _t: T, x: &DVector<T>, _u: &DVector<T>) -> DVector<T> {
        x.clone()
    }

    fn output(&self, t: T, x: &DVector<T>, _u: &DVector<T>) -> DVector<T> {
        DVector::from_column_slice(Radar.output(t, &Vector2::new(x[0], x[1]), &SVector::zeros()).as_slice())
    }
}

fn noises() -> NoiseModel<f64, Const<2>, Const<2>> {
    NoiseModel {
        w: Matrix2::zeros(),
        v: Matrix2::new(0.01, 0.002, 0.002, 0.0025),
        p0: Matrix2::new(0.5, 0.1, 0.1, 0.4),
    }
}

type Filter = ExtendedKalmanFilter<Radar, f64, Const<2>, Const<0>, Const<2>>;

fn radar(iterations: usize) -> Filter {
    ExtendedKalmanFilter::discrete(Radar, noises(), 0.1).unwrap().with_iterations(iterations).unwrap()
}

const START: Vector2<f64> = Vector2::new(1.0, 0.5);
const MEASURED: Vector2<f64> = Vector2::new(1.8, 1.1);

/// Gauss-Newton steps `x <- xbar + C H' V^-1 (y - h(x) - H (xbar - x))` with `C = (P^-1 + H' V^-1 H)^-1`, in numpy
/// 2.4.6, of both outputs and of one of them, the other one missing. The NIS is that of the prediction.
#[test]
fn the_numbers_are_those_of_gauss_newton_steps() {
    let cases = [
        (
            [true, true],
            1,
            [1.2817025831725999, 1.4265046230155178],
            [0.0067251737096242, 0.00399840850494735, 0.00617869731623816],
        ),
        (
            [true, true],
            2,
            [0.8358696755850383, 1.6324314126824602],
            [5.6720670773147625e-03, 3.0801356386136224e-05, 0.01299377072152584],
        ),
        (
            [true, true],
            3,
            [0.8260878298552556, 1.5661884289641426],
            [0.00568014701161374, -0.00139534746713717, 0.01221566287023318],
        ),
        (
            [true, true],
            60,
            [0.8251505083435435, 1.56699495663139],
            [0.00531972448573197, -0.00103219330083267, 0.0120409165631696],
        ),
        (
            [true, false],
            3,
            [1.585368625416359, 0.8268704725864138],
            [0.07978530011485144, -0.13464834221601488, 0.268972112304084],
        ),
        (
            [false, true],
            5,
            [0.3363459434066953, 0.6558210226253722],
            [0.10098426839939816, 0.19368591772161625, 0.37800324527523516],
        ),
    ];
    let u = SVector::zeros();
    for (measured, iterations, x, p) in cases {
        let filter = radar(iterations);
        assert_eq!(filter.iterations(), iterations);
        let mut estimate = filter.initial(0.0, &START, &u, &MEASURED);
        // The missing output is not read.
        let y = Vector2::from_fn(|i, _| if measured[i] { MEASURED[i] } else { f64::NAN });
        let innovation = filter.update_partial(0.0, &mut estimate, &u, &y, |output| measured[output]).unwrap();
        let covariance = Matrix2::new(p[0], p[1], p[1], p[2]);
        assert!((estimate.estimate() - Vector2::from(x)).amax() < 1e-13, "{iterations}: {}", estimate.estimate());
        assert!((estimate.covariance() - covariance).amax() < 1e-13, "{iterations}: {}", estimate.covariance());
        if measured == [true, true] {
            assert!((innovation.normalized_square - 2.186334475824623).abs() < 1e-13);
        }
    }
}

/// scipy 1.17.1, `least_squares(method="lm")` of the residuals `P^(-1/2) (x - xbar)` and `V^(-1/2) (y - h(x))`; its
/// gradient there is below 2e-7, 8e-10 and 5e-9.
#[test]
fn the_estimate_tends_to_the_maximum_of_the_posterior_density() {
    let cases = [
        ([true, true], [0.8251505084014521, 1.566994956585418], 1e-9),
        ([true, false], [1.5852020404222693, 0.8271895528977895], 1e-8),
        ([false, true], [0.33617520223637865, 0.6555302472973416], 1e-7),
    ];
    let u = SVector::zeros();
    for (measured, x, distance) in cases {
        let filter = radar(60);
        let mut estimate = filter.initial(0.0, &START, &u, &MEASURED);
        filter.update_partial(0.0, &mut estimate, &u, &MEASURED, |output| measured[output]).unwrap();
        assert!((estimate.estimate() - Vector2::from(x)).amax() < distance, "{measured:?}: {}", estimate.estimate());
        // One linearisation ends far from there.
        let filter = radar(1);
        let mut estimate = filter.initial(0.0, &START, &u, &MEASURED);
        filter.update_partial(0.0, &mut estimate, &u, &MEASURED, |output| measured[output]).unwrap();
        assert!((estimate.estimate() - Vector2::from(x)).amax() > 3e-3, "{measured:?}: {}", estimate.estimate());
    }
}

/// One state, y = x^2, xbar = P = V = 1, y = 4: by fractions.
#[derive(Clone, Debug, PartialEq)]
struct Square;

plant!(Square, (1, 0, 1), |plant, _t, x, u| [x[0]], [x[0] * x[0]]);

#[test]
fn one_state_by_hand() {
    let one = Matrix1::new(1.0);
    let noises = NoiseModel { w: Matrix1::new(0.0), v: one, p0: one };
    let filter = ExtendedKalmanFilter::<_, f64, Const<1>, Const<0>, Const<1>>::discrete(Square, noises, 1.0).unwrap();
    let expected = [
        (11.0 / 5.0, 1.0 / 5.0),
        (4987.0 / 2545.0, 25.0 / 509.0),
        (522_946_483_631.0 / 269_662_349_045.0, 6_477_025.0 / 105_957_701.0),
    ];
    let (u, y) = (SVector::zeros(), Vector1::new(4.0));
    for (k, (x, p)) in expected.into_iter().enumerate() {
        let filter = filter.clone().with_iterations(k + 1).unwrap();
        let mut estimate = filter.initial(0.0, &one.column(0).into(), &u, &y);
        let innovation = filter.update(0.0, &mut estimate, &u, &y).unwrap();
        assert!((estimate.estimate()[0] - x).abs() <= 8.0 * f64::EPSILON, "{k}: {}", estimate.estimate()[0]);
        assert!((estimate.covariance()[(0, 0)] - p).abs() <= 8.0 * f64::EPSILON);
        // Of the prediction: y - h = 3, S = 4 + 1.
        assert_eq!((innovation.value[0], innovation.covariance[(0, 0)]), (3.0, 5.0));
        assert!((innovation.normalized_square - 1.8).abs() <= 4.0 * f64::EPSILON);
    }
    assert_eq!(
        filter.with_iterations(0),
        Err(ObserverError::Table { what: "linearisations of an update", expected: 1, found: 0 })
    );
}

/// Of two outputs the one with an outlier is rejected, by its innovation at the prediction, in every linearisation.
#[test]
fn a_gate_rejects_at_the_prediction() {
    let (plain, u) = (radar(4), SVector::zeros());
    // The innovations have standard deviations of about 0.73 and 0.6.
    let gated = plain.clone().with_gate(2.0).unwrap();
    let start = plain.initial(0.0, &START, &u, &MEASURED);
    for (y, rejected) in [
        (MEASURED, [false, false]),
        (Vector2::new(9.0, 1.1), [true, false]),
        (Vector2::new(1.8, 3.0), [false, true]),
        (Vector2::new(f64::NAN, 1.1), [true, false]),
        (Vector2::new(1e30, f64::INFINITY), [true, true]),
    ] {
        let (mut found, mut expected) = (start.clone(), start.clone());
        assert!((0..2).all(|output| gated.rejects(0.0, &start, &u, &y, output) == rejected[output]), "{y}");
        gated.update(0.0, &mut found, &u, &y).unwrap();
        plain.update_partial(0.0, &mut expected, &u, &y, |output| !rejected[output]).unwrap();
        assert_eq!(found, expected);
    }
}

fn bits(x: &[f64]) -> Vec<u64> {
    x.iter().map(|x| if x.is_nan() { 0 } else { x.to_bits() }).collect()
}

/// Sizes of both kinds and the step on slices have the same bits, with outputs missing and with hostile samples. No
/// sample makes the estimate not finite: it is used, or it is passed over.
#[test]
fn sizes_and_samples() {
    let dense = |m: Matrix2<f64>| DMatrix::from_column_slice(2, 2, m.as_slice());
    let hostile = [1e13, -1e13, 1e30, -1e30, 1e300, -f64::MAX, 5e-324, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0];
    for (iterations, gate) in [(1, None), (2, None), (5, None), (3, Some(3.0))] {
        let NoiseModel { v, p0, .. } = noises();
        let model = NoiseModel { w: Matrix2::identity() * 0.01, v, p0 };
        let same = NoiseModel { w: dense(model.w), v: dense(v), p0: dense(p0) };
        let fixed = ExtendedKalmanFilter::<_, f64, Const<2>, Const<0>, Const<2>>::discrete(Radar, model, 0.1).unwrap();
        let run_time = ExtendedKalmanFilter::<_, f64, Dyn, Dyn, Dyn>::discrete(DynamicRadar, same, 0.1).unwrap();
        let (mut fixed, mut run_time) =
            (fixed.with_iterations(iterations).unwrap(), run_time.with_iterations(iterations).unwrap());
        if let Some(gate) = gate {
            (fixed, run_time) = (fixed.with_gate(gate).unwrap(), run_time.with_gate(gate).unwrap());
        }
        let (u, none) = (SVector::zeros(), DVector::zeros(0));
        for bad in hostile {
            let mut one = fixed.initial(0.0, &START, &u, &MEASURED);
            let mut two =
                run_time.initial(0.0, &DVector::from_column_slice(START.as_slice()), &none, &DVector::zeros(2));
            let mut slice = two.as_slice().to_vec();
            for k in 0..12 {
                let mut y = Vector2::new(1.7 + 0.1 * (f64::from(k)).sin(), 1.0 + 0.1 * f64::from(k).cos());
                y[k as usize % 2] = if k % 4 == 1 || k % 4 == 2 { bad } else { y[k as usize % 2] };
                let measured = [k != 5, k != 7];
                let column = DVector::from_column_slice(y.as_slice());
                fixed.step_partial(0.0, &mut one, &u, &y, &measured);
                run_time.step_partial(0.0, &mut two, &none, &column, &measured);
                assert!(run_time.step_into(0.0, &mut slice, &[], y.as_slice(), &measured));
                assert_eq!(bits(one.as_slice()), bits(two.as_slice()), "{iterations} {bad} {k}");
                assert_eq!(bits(two.as_slice()), bits(&slice), "{iterations} {bad} {k}");
                assert!(slice.iter().all(|x| x.is_finite()), "{iterations} {bad} {k}: {slice:?}");
            }
        }
    }
}

/// The cost of which a Gauss-Newton step is the minimum of the linearisation: its gradient.
fn gradient(x: &Vector2<f64>, xbar: &Vector2<f64>, y: &Vector2<f64>) -> Vector2<f64> {
    let NoiseModel { v, p0, .. } = noises();
    let inverse = |m: Matrix2<f64>| m.try_inverse().unwrap();
    let u = SVector::<f64, 0>::zeros();
    let h = Radar.output_jacobian(0.0, x, &u);
    let value: Vector2<f64> = Radar.output(0.0, x, &u);
    inverse(p0) * (x - xbar) - h.transpose() * inverse(v) * (y - value)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Where the iterations converge they do to a point at which the posterior density is stationary.
    #[test]
    fn a_limit_is_stationary(
        xbar in prop::array::uniform2(1.0f64..3.0), off in prop::array::uniform2(-0.2f64..0.2),
    ) {
        let u = SVector::<f64, 0>::zeros();
        let xbar = Vector2::from(xbar);
        let y: Vector2<f64> = Radar.output(0.0, &(xbar + Vector2::from(off)), &u);
        let filter = radar(100);
        let mut estimate = filter.initial(0.0, &xbar, &u, &y);
        filter.update(0.0, &mut estimate, &u, &y).unwrap();
        let (x, first) = (estimate.estimate(), gradient(&xbar, &xbar, &y).amax());
        prop_assert!(gradient(&x, &xbar, &y).amax() <= 1e-9 * (1.0 + first), "{x} {first}");
    }

    /// A measurement that is linear has one linearisation: all iterations are the Kalman filter, to rounding; one
    /// iteration has its bits.
    #[test]
    fn of_a_linear_plant_it_is_the_kalman_filter(
        root in prop::array::uniform9(-1.0f64..1.0), c in prop::array::uniform6(-1.0f64..1.0),
        x in prop::array::uniform3(-1.0f64..1.0), y in prop::array::uniform2(-1.0f64..1.0), iterations in 2usize..6,
    ) {
        let (a, root) = (Matrix3::new(0.9, 0.1, 0.0, -0.1, 0.8, 0.1, 0.0, 0.2, 0.7), Matrix3::from_row_slice(&root));
        let c = Matrix3x2::from_row_slice(&c).transpose();
        let p0 = root * root.transpose();
        let (w, v) = (Matrix3::identity() * 0.1, Matrix2::new(0.5, 0.1, 0.1, 0.3));
        let plant = StaticPlant::<f64, 3, 0, 2>::new(a, nalgebra::SMatrix::zeros(), c).unwrap();
        let once: ExtendedKalmanFilter<_, f64, Const<3>, Const<0>, Const<2>> =
            ExtendedKalmanFilter::discrete(plant, NoiseModel { w, v, p0 }, 1.0).unwrap();
        let again = once.clone().with_iterations(iterations).unwrap();
        let model = KalmanModel { ad: a, bd: nalgebra::SMatrix::zeros(), c, w, v, p0, period: 1.0 };
        let kalman: KalmanFilter<f64, Const<3>, Const<0>, Const<2>> = KalmanFilter::new(model).unwrap();
        let (u, y, x) = (SVector::<f64, 0>::zeros(), Vector2::from(y), Vector3::from(x));
        let (mut first, mut other, mut third) =
            (once.initial(0.0, &x, &u, &y), again.initial(0.0, &x, &u, &y), kalman.initial(0.0, &x, &u, &y));
        for _ in 0..5 {
            once.step(0.0, &mut first, &u, &y);
            again.step(0.0, &mut other, &u, &y);
            kalman.step(0.0, &mut third, &u, &y);
        }
        let same = once.with_iterations(1).unwrap();
        let mut still = same.initial(0.0, &x, &u, &y);
        (0..5).for_each(|_| same.step(0.0, &mut still, &u, &y));
        prop_assert_eq!(bits(still.as_slice()), bits(first.as_slice()));
        // |P| is below 10, S^-1 below 5.
        let near = |a: &GaussianEstimate<f64, Const<3>>, b: &GaussianEstimate<f64, Const<3>>| {
            a.as_slice().iter().zip(b.as_slice()).all(|(a, b)| (a - b).abs() <= 2000.0 * f64::EPSILON)
        };
        prop_assert!(near(&first, &other) && near(&first, &third), "{:?} {:?} {:?}", first, other, third);
    }
}

/// In f32 the same numbers, to its rounding.
#[test]
fn in_single_precision() {
    let single = |m: Matrix2<f64>| m.map(|x| x as f32);
    let NoiseModel { w, v, p0 } = noises();
    let model = NoiseModel { w: single(w), v: single(v), p0: single(p0) };
    let filter = ExtendedKalmanFilter::<_, f32, Const<2>, Const<0>, Const<2>>::discrete(Radar, model, 0.1).unwrap();
    let filter = filter.with_iterations(3).unwrap();
    let to: fn(Vector2<f64>) -> Vector2<f32> = |x| x.map(|x| convert::<f64, f64>(x) as f32);
    let mut estimate = filter.initial(0.0, &to(START), &SVector::zeros(), &to(MEASURED));
    filter.update(0.0, &mut estimate, &SVector::zeros(), &to(MEASURED)).unwrap();
    let expected = Vector2::new(0.826_087_83_f32, 1.566_188_4);
    assert!((estimate.estimate() - expected).amax() < 1e-4, "{}", estimate.estimate());
}
