//! Observers of nonlinear plants from the design, in f64, to the target, in f32: the plant is given again, the numbers
//! are those of the design.

use luenberger_observers::{
    DiscreteNonlinearObserver, ExtendedKalmanFilter, Integral, MeanValueObserver, NoiseModel,
    NonlinearLuenbergerObserver, Observer, ObserverError, SampledNonlinearObserver, SampledObserver, SigmaPoints,
    StaticExtendedKalmanFilter, StaticInterSampleObserver, StaticMeanValueObserver, StaticNonlinearLuenbergerObserver,
    StaticSampledNonlinearObserver, StaticUnscentedKalmanFilter, UnscentedKalmanFilter,
};
use luenberger_plants::{Chaotic, Plant, PlantError, ReverseDuffing};
use nalgebra::{Matrix1, Matrix2, Matrix3, Matrix3x2, SVector, Vector2, Vector3};

type Sampled<T> =
    StaticInterSampleObserver<Chaotic, StaticMeanValueObserver<Chaotic, Integral, T, 3, 0, 2>, T, 6, 3, 0, 2, 9>;

fn gain() -> Matrix3x2<f64> {
    Matrix3x2::new(4.0, 0.5, -0.25, 5.0, 1.0, 3.0)
}

/// Runs both along the same measurements; the estimates differ by the rounding of f32 alone.
fn follows<A, B>(designed: &A, target: &B)
where
    A: SampledObserver<f64, Input = SVector<f64, 0>, Output = Vector2<f64>, Estimate = Vector3<f64>>,
    B: SampledObserver<f32, Input = SVector<f32, 0>, Output = Vector2<f32>, Estimate = Vector3<f32>>,
{
    let mut x = Vector3::new(-2.0, -1.0, -1.0);
    let (u, v) = (SVector::<f64, 0>::zeros(), SVector::<f32, 0>::zeros());
    let first = Vector3::new(-1.75, -0.75, -1.25);
    let mut one = designed.initial(0.0, &first, &u, &Vector2::zeros());
    let mut other = target.initial(0.0, &first.map(|x| x as f32), &v, &Vector2::zeros());
    assert!((f64::from(target.period()) - designed.period()).abs() < 1e-7);
    for k in 0..100 {
        let y: Vector2<f64> = Chaotic.output(0.0, &x, &u);
        let t = 0.01 * f64::from(k);
        designed.step(t, &mut one, &u, &y);
        target.step(t as f32, &mut other, &v, &y.map(|y| y as f32));
        for _ in 0..10 {
            x += Chaotic.derivative(0.0, &x, &u) * 0.001;
        }
        let apart = (designed.estimate(&one) - target.estimate(&other).map(f64::from)).amax();
        assert!(apart < 1e-3, "step {k}: {apart}");
    }
}

#[test]
fn designed_observers_step_in_f32() {
    let copy = SampledNonlinearObserver::new(Chaotic, gain(), 0.01, 2).unwrap();
    let target: StaticSampledNonlinearObserver<Chaotic, f32, 3, 0, 2> = copy.to_static(Chaotic).unwrap();
    assert_eq!((target.substeps(), target.l()), (2, &gain().map(|l| l as f32)));
    follows(&copy, &target);
    let noises =
        || NoiseModel { w: Matrix3::identity() * 0.01, v: Matrix2::identity() * 0.01, p0: Matrix3::identity() };
    let extended = ExtendedKalmanFilter::new(Chaotic, noises(), 0.01, 2).unwrap().with_gate(50.0).unwrap();
    let target: StaticExtendedKalmanFilter<Chaotic, f32, 3, 0, 2> = extended.to_static(Chaotic).unwrap();
    assert_eq!((target.gate(), target.substeps()), (Some(50.0), Some(2)));
    follows(&extended, &target);
    let unscented = UnscentedKalmanFilter::new(Chaotic, noises(), SigmaPoints::default(), 0.01, 2).unwrap();
    let target: StaticUnscentedKalmanFilter<Chaotic, f32, 3, 0, 2> = unscented.to_static(Chaotic).unwrap();
    assert_eq!((target.gate(), target.substeps()), (None, Some(2)));
    follows(&unscented, &target);
    let angles = UnscentedKalmanFilter::new(Chaotic, noises(), SigmaPoints::default(), 0.01, 2).unwrap();
    let angles = angles.with_angles(Vector2::new(6.25, 0.0), Vector3::new(0.0, 0.0, 360.0)).unwrap();
    let target: StaticUnscentedKalmanFilter<Chaotic, f32, 3, 0, 2> = angles.to_static(Chaotic).unwrap();
    assert_eq!(target.turns().unwrap().as_slice(), [6.25, 0.0]);
    assert_eq!(target.state_turns().unwrap().as_slice(), [0.0, 0.0, 360.0]);
    follows(&angles, &target);
    let discrete = ExtendedKalmanFilter::discrete(Chaotic, noises(), 0.01).unwrap().with_iterations(2).unwrap();
    let target: StaticExtendedKalmanFilter<Chaotic, f32, 3, 0, 2> = discrete.to_static(Chaotic).unwrap();
    assert_eq!((target.substeps(), target.iterations()), (None, 2));
    let vectors = extended.clone().with_unit_vectors(Vector3::new(0.0, 1.0, 1.0)).unwrap();
    let target: StaticExtendedKalmanFilter<Chaotic, f32, 3, 0, 2> = vectors.to_static(Chaotic).unwrap();
    assert_eq!(target.unit_vectors().unwrap().as_slice(), [0.0, 1.0, 1.0]);
    follows(&vectors, &target);
    // A mean-value design, from continuous time through its sampled form.
    let e0 = Vector3::new(0.0, 0.0, 0.25);
    for designed in [
        MeanValueObserver::new(Chaotic, 1.0, Integral, e0).unwrap(),
        MeanValueObserver::with_output_injection(Chaotic, 1.0, Integral, e0, gain()).unwrap(),
    ] {
        let target: StaticMeanValueObserver<Chaotic, Integral, f32, 3, 0, 2> =
            designed.to_static(Chaotic, Integral).unwrap();
        assert_eq!(target.l().is_some(), designed.l().is_some());
        let (one, other) = (Sampled::new(Chaotic, designed, 0.01, 1), Sampled::<f32>::new(Chaotic, target, 0.01, 1));
        follows::<Sampled<f64>, _>(&one.unwrap(), &other.unwrap());
    }
}

#[test]
fn a_continuous_design_becomes_a_loop() {
    let designed = NonlinearLuenbergerObserver::new(Chaotic, gain()).unwrap();
    let target: StaticNonlinearLuenbergerObserver<Chaotic, f32, 3, 0, 2> = designed.to_static(Chaotic).unwrap();
    let (x, u, y) = (Vector3::new(-1.5, 0.25, 0.5), SVector::zeros(), Vector2::new(1.0, 0.5));
    let slope: Vector3<f32> = target.derivative(0.0, &x.map(|x| x as f32), &SVector::zeros(), &Vector2::new(1.0, 0.5));
    assert!((slope.map(f64::from) - designed.derivative(0.0, &x, &u, &y)).amax() < 1e-4);
}

#[test]
fn other_sizes_are_errors() {
    let designed = NonlinearLuenbergerObserver::new(Chaotic, gain()).unwrap();
    let error = designed.to_static::<f32, 2, 0, 1, _>(ReverseDuffing).unwrap_err();
    let expected = PlantError::DimensionMismatch { what: "the state of the design", expected: (2, 1), found: (3, 1) };
    assert_eq!(error, ObserverError::Matrix(expected));
    let discrete = DiscreteNonlinearObserver::new(ReverseDuffing, Vector2::new(0.5, 0.25), 0.1).unwrap();
    assert!(discrete.to_static::<f32, 2, 0, 1, _>(ReverseDuffing).is_ok());
    assert!(discrete.to_static::<f32, 3, 0, 2, _>(Chaotic).is_err());
    let noises = NoiseModel { w: Matrix2::zeros(), v: Matrix1::new(1.0), p0: Matrix2::identity() };
    let filter = ExtendedKalmanFilter::new(ReverseDuffing, noises, 0.1, 1).unwrap();
    assert!(filter.to_static::<f32, 3, 0, 2, _>(Chaotic).is_err());
    // Beyond the range of f32, and below it.
    let large = SampledNonlinearObserver::new(ReverseDuffing, Vector2::new(1e39, 0.0), 0.1, 1).unwrap();
    let error = large.to_static::<f32, 2, 0, 1, _>(ReverseDuffing).unwrap_err();
    assert!(matches!(error, ObserverError::Matrix(PlantError::NotFinite { what: "L", .. })), "{error}");
    let short = SampledNonlinearObserver::new(ReverseDuffing, Vector2::new(1.0, 0.0), 1e-60, 1).unwrap();
    let error = short.to_static::<f32, 2, 0, 1, _>(ReverseDuffing).unwrap_err();
    assert!(matches!(error, ObserverError::Period { .. }), "{error}");
    // An observer whose state has another length than it is told.
    let mean = MeanValueObserver::new(ReverseDuffing, 1.0, Integral, Vector2::zeros()).unwrap();
    let wrong = StaticInterSampleObserver::<_, _, f64, 2, 2, 0, 1, 4>::new(ReverseDuffing, mean, 0.1, 1);
    assert!(matches!(wrong, Err(ObserverError::Matrix(PlantError::DimensionMismatch { what: "z", .. }))));
}
