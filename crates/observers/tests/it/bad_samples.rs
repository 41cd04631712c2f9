//! Filters with samples that are no measurements: NaN, infinities, and columns of other lengths.

use luenberger_observers::moving_horizon::{MovingHorizonEstimator, StaticMovingHorizonEstimator, state_length};
use luenberger_observers::{
    AdaptedFilter, CovarianceFilter, DelayedFilter, ExtendedKalmanFilter, Horizon, KalmanFilter, KalmanModel,
    NoiseModel, ParticleFilter, ParticleNoise, Prediction, SampledObserver, SigmaPoints, UnscentedKalmanFilter,
};
use luenberger_plants::{Column, LinearPlant, StaticPlant};
use nalgebra::{Const, DMatrix, DVector, Dyn, Matrix2, Vector1, Vector2};

type StaticWindow =
    StaticMovingHorizonEstimator<StaticPlant<f64, 2, 1, 2>, f64, 2, 1, 2, { state_length(2, 1, 2, 3) }, 3>;
type Window = MovingHorizonEstimator<LinearPlant<f64, Dyn, Dyn, Dyn>, f64, Dyn, Dyn, Dyn, Dyn, 3>;

const BAD: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

fn noises() -> NoiseModel<f64, Const<2>, Const<2>> {
    NoiseModel {
        w: Matrix2::new(0.01, 0.0, 0.0, 0.02),
        v: Matrix2::new(0.05, 0.01, 0.01, 0.04),
        p0: Matrix2::identity(),
    }
}

/// A damped oscillator with position and speed measured, in discrete time.
fn map() -> StaticPlant<f64, 2, 1, 2> {
    StaticPlant::new(Matrix2::new(0.99, 0.1, -0.1, 0.95), Vector2::new(0.0, 0.1), Matrix2::identity()).unwrap()
}

fn flow() -> StaticPlant<f64, 2, 1, 2> {
    StaticPlant::new(Matrix2::new(0.0, 1.0, -1.0, -0.5), Vector2::new(0.0, 1.0), Matrix2::identity()).unwrap()
}

fn kalman() -> KalmanFilter<f64, Const<2>, Const<1>, Const<2>> {
    let (NoiseModel { w, v, p0 }, LinearPlant { a: ad, b: bd, c, .. }) = (noises(), map());
    KalmanFilter::new(KalmanModel { ad, bd, c, w, v, p0, period: 0.1 }).unwrap()
}

/// Outputs that are not finite are not measured, to the last bit, in a step and in an update: one of two or both. The
/// estimate then converges to that of a filter that has had all samples.
fn passes_over<F>(filter: &F)
where
    F: CovarianceFilter<f64, Input = Vector1<f64>, Output = Vector2<f64>, Estimate = Vector2<f64>>,
    F::State: Clone + PartialEq + core::fmt::Debug,
{
    let u = Vector1::new(0.3);
    let y = |k: usize| Vector2::new((0.1 * k as f64).sin(), (0.1 * k as f64).cos());
    for bad in BAD {
        for measured in [[false, true], [true, false], [false; 2]] {
            let lost = y(20).zip_map(&Vector2::from(measured), |y, measured| if measured { y } else { bad });
            let mut found = filter.initial(0.0, &Vector2::zeros(), &u, &y(0));
            let (mut missed, mut healthy) = (found.clone(), found.clone());
            for k in 0..200 {
                let t = 0.1 * k as f64;
                if k == 20 {
                    let before = found.clone();
                    let square = filter.measure(t, &mut found, &u, &lost, &[true; 2]);
                    let is_used = measured != [false; 2];
                    assert_eq!(square.is_some(), is_used, "{bad}, {measured:?}: {square:?}");
                    assert_eq!(found == before, !is_used, "{bad}, {measured:?}: {found:?}");
                    found = before;
                    filter.step(t, &mut found, &u, &lost);
                    filter.step_partial(t, &mut missed, &u, &y(k), &measured);
                    // On slices as well, where they fit.
                    let mut slice = found.as_slice().to_vec();
                    assert!(filter.step_into(t, &mut slice, u.as_slice(), lost.as_slice(), &[]));
                    assert!(slice.iter().all(|x| x.is_finite()));
                } else {
                    filter.step(t, &mut found, &u, &y(k));
                    filter.step(t, &mut missed, &u, &y(k));
                }
                filter.step(t, &mut healthy, &u, &y(k));
                assert_eq!(found.as_slice(), missed.as_slice(), "{bad}, {measured:?}, sample {k}");
                assert!(found.as_slice().iter().all(|x| x.is_finite()));
            }
            assert!((filter.estimate(&found) - filter.estimate(&healthy)).amax() < 1e-6);
        }
    }
}

#[test]
fn an_output_that_is_not_finite_is_a_missed_one() {
    passes_over(&kalman());
    let sigma = [SigmaPoints::default(), SigmaPoints { alpha: 0.5, ..SigmaPoints::default() }];
    for substeps in [None, Some(2)] {
        let extended = || match substeps {
            None => ExtendedKalmanFilter::discrete(map(), noises(), 0.1),
            Some(substeps) => ExtendedKalmanFilter::new(flow(), noises(), 0.1, substeps),
        };
        passes_over(&extended().unwrap());
        passes_over(&extended().unwrap().with_gate(50.0).unwrap());
        passes_over(&extended().unwrap().with_iterations(3).unwrap());
        passes_over(&extended().unwrap().with_iterations(3).unwrap().with_gate(50.0).unwrap());
        for sigma in sigma {
            let unscented = || match substeps {
                None => UnscentedKalmanFilter::discrete(map(), noises(), sigma, 0.1),
                Some(substeps) => UnscentedKalmanFilter::new(flow(), noises(), sigma, 0.1, substeps),
            };
            passes_over(&unscented().unwrap());
            passes_over(&unscented().unwrap().with_gate(50.0).unwrap());
        }
    }
    let horizon = Horizon { window: 3, iterations: 1 };
    passes_over(&StaticWindow::discrete(map(), noises(), horizon, 0.1).unwrap());
}

/// An innovation whose correction overflows is no measurement either.
#[test]
fn an_overflow_is_no_update() {
    let filter = ExtendedKalmanFilter::discrete(map(), noises(), 0.1).unwrap();
    let u = Vector1::new(0.0);
    let start = filter.initial(0.0, &Vector2::repeat(f64::MAX), &u, &Vector2::zeros());
    let mut estimate = start.clone();
    assert_eq!(filter.update(0.0, &mut estimate, &u, &Vector2::repeat(-f64::MAX)), None);
    assert_eq!(estimate, start);
}

/// Without a finite input there is no prediction; a step says so by an estimate that is NaN, whose covariance is kept.
#[test]
fn an_input_that_is_not_finite_is_no_prediction() {
    for bad in BAD {
        let (u, y) = (Vector1::new(bad), Vector2::zeros());
        let filter = kalman();
        let start = filter.initial(0.0, &Vector2::new(1.0, 2.0), &u, &y);
        let mut estimate = start.clone();
        assert!(!filter.predict(&mut estimate, &u) && estimate == start);
        filter.step(0.0, &mut estimate, &u, &y);
        assert!(estimate.estimate().iter().all(|x| x.is_nan()) && estimate.covariance().iter().all(|x| x.is_finite()));
        // The estimate is unknown, and no measurement makes it known.
        assert_eq!(filter.update(&mut estimate, &Vector1::new(0.0), &y), None);
        for filter in [
            ExtendedKalmanFilter::discrete(map(), noises(), 0.1).unwrap(),
            ExtendedKalmanFilter::new(flow(), noises(), 0.1, 2).unwrap().with_gate(4.0).unwrap(),
        ] {
            let mut estimate = start.clone();
            assert!(!filter.predict(0.0, &mut estimate, &u, 0.1) && estimate == start);
            filter.step(0.0, &mut estimate, &u, &y);
            assert!(estimate.estimate().iter().all(|x| x.is_nan()));
            assert!(estimate.covariance().iter().all(|x| x.is_finite()));
            assert_eq!(filter.update(0.0, &mut estimate, &Vector1::new(0.0), &y), None);
        }
    }
}

/// Numbers that are not random.
struct Alternating;

impl ParticleNoise for Alternating {
    fn normals(&self, _k: u64, numbers: &mut [f64]) {
        for (k, number) in numbers.iter_mut().enumerate() {
            *number = if k % 2 == 0 { 0.5 } else { -0.25 };
        }
    }

    fn uniform(&self, _k: u64) -> f64 {
        0.5
    }
}

/// Columns of other lengths than the filter's, where the compiler does not see lengths: nothing panics, nothing
/// changes.
fn refuses<F>(filter: &F)
where
    F: CovarianceFilter<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>,
    F::State: Clone + PartialEq + core::fmt::Debug,
{
    let zeros = DVector::<f64>::zeros;
    let start = filter.initial(0.0, &zeros(2), &zeros(1), &zeros(2));
    let n = start.as_slice().len();
    for (u, y) in [(1, 1), (1, 3), (0, 2), (2, 2), (2, 1), (0, 0)] {
        let (u, y, mut state) = (zeros(u), zeros(y), start.clone());
        filter.step(0.0, &mut state, &u, &y);
        filter.step_partial(0.0, &mut state, &u, &y, &[true, false]);
        assert_eq!(filter.measure(0.0, &mut state, &u, &y, &[true; 2]), None);
        assert!((0..4).all(|output| !filter.rejects_output(0.0, &state, &u, &y, output)));
        let mut slice = start.as_slice().to_vec();
        assert!(!filter.step_into(0.0, &mut slice, u.as_slice(), y.as_slice(), &[]));
        assert_eq!((state, &slice[..]), (start.clone(), start.as_slice()));
    }
    for u in [0, 2] {
        let mut state = start.clone();
        assert!(!filter.advance(0.0, &mut state, &zeros(u), 0.1) && state == start);
        assert!(!filter.advance_across(0.0, &mut state, &zeros(u), 0.1, &mut [0.0; 4]) && state == start);
    }
    // The state of a filter of another order.
    for other in [vec![0.0; 2], vec![1.0; n + 6]] {
        let mut slice = other.clone();
        assert!(!filter.step_into(0.0, &mut slice, &[0.0], &[0.0; 2], &[]) && slice == other);
        let Some(mut state) = F::State::try_from_slice(&other) else { continue };
        let before = state.clone();
        filter.step(0.0, &mut state, &zeros(1), &zeros(2));
        assert_eq!(filter.measure(0.0, &mut state, &zeros(1), &zeros(2), &[true; 2]), None);
        assert!(!filter.advance(0.0, &mut state, &zeros(1), 0.1));
        assert_eq!(state, before);
    }
    // With the right lengths it is a filter.
    let mut state = start.clone();
    filter.step(0.0, &mut state, &zeros(1), &zeros(2));
    assert_ne!(state, start);
}

#[test]
fn columns_of_other_lengths_change_nothing() {
    let dense = |m: Matrix2<f64>| DMatrix::from_column_slice(2, 2, m.as_slice());
    let NoiseModel { w, v, p0 } = noises();
    let noises = || NoiseModel { w: dense(w), v: dense(v), p0: dense(p0) };
    let plant = |plant: StaticPlant<f64, 2, 1, 2>| LinearPlant::<f64, Dyn, Dyn, Dyn> {
        a: dense(plant.a),
        b: DMatrix::from_column_slice(2, 1, plant.b.as_slice()),
        c: dense(plant.c),
        d: None,
    };
    let LinearPlant { a: ad, b: bd, c, .. } = plant(map());
    let model = KalmanModel { ad, bd, c, w: dense(w), v: dense(v), p0: dense(p0), period: 0.1 };
    let filter = KalmanFilter::new(model).unwrap();
    refuses(&filter);
    refuses(&filter.with_feedthrough(DMatrix::from_element(2, 1, 0.5)).unwrap());
    refuses(&ExtendedKalmanFilter::discrete(plant(map()), noises(), 0.1).unwrap());
    refuses(&ExtendedKalmanFilter::new(plant(flow()), noises(), 0.1, 2).unwrap().with_gate(4.0).unwrap());
    let sigma = SigmaPoints::default();
    refuses(&UnscentedKalmanFilter::discrete(plant(map()), noises(), sigma, 0.1).unwrap());
    refuses(&UnscentedKalmanFilter::new(plant(flow()), noises(), sigma, 0.1, 2).unwrap().with_gate(4.0).unwrap());
    let extended = || ExtendedKalmanFilter::new(plant(flow()), noises(), 0.1, 2).unwrap();
    let adapted = || AdaptedFilter::new(extended(), ()).with_bounds(&[-1.0; 2], &[1.0; 2]).unwrap();
    refuses(&adapted());
    refuses(&DelayedFilter::new(adapted(), &[0.2, 0.0], 6).unwrap());
    let discrete = (0.1, Prediction::Discrete);
    refuses(&ParticleFilter::new(plant(map()), noises(), discrete, 20, Alternating).unwrap());
    let horizon = Horizon { window: 3, iterations: 1 };
    refuses(&Window::new(plant(flow()), noises(), horizon, 0.1, 1).unwrap());
}

/// A filter of a plant whose sizes are known at run time steps on slices, with the same result.
#[test]
fn steps_on_slices_pass_over_as_well() {
    let dense = |m: Matrix2<f64>| DMatrix::from_column_slice(2, 2, m.as_slice());
    let NoiseModel { w, v, p0 } = noises();
    let plant = |plant: StaticPlant<f64, 2, 1, 2>| LinearPlant::<f64, Dyn, Dyn, Dyn> {
        a: dense(plant.a),
        b: DMatrix::from_column_slice(2, 1, plant.b.as_slice()),
        c: dense(plant.c),
        d: None,
    };
    let noises = NoiseModel { w: dense(w), v: dense(v), p0: dense(p0) };
    let extended = ExtendedKalmanFilter::new(plant(flow()), noises.clone(), 0.1, 2).unwrap();
    let discrete = ExtendedKalmanFilter::discrete(plant(map()), noises, 0.1).unwrap();
    for filter in [extended.clone(), extended.with_gate(4.0).unwrap(), discrete] {
        for bad in BAD {
            for (u, y) in [(0.3, [bad, 0.5]), (0.3, [0.5, bad]), (0.3, [bad; 2]), (bad, [0.5; 2])] {
                let (u, y) = (DVector::from_element(1, u), DVector::from_column_slice(&y));
                let mut columns = filter.initial(0.0, &DVector::zeros(2), &u, &y);
                let mut slice = columns.as_slice().to_vec();
                for k in 0..3 {
                    let y = if k == 1 { y.clone() } else { DVector::from_element(2, 0.1) };
                    filter.step(0.0, &mut columns, &u, &y);
                    assert!(filter.step_into(0.0, &mut slice, u.as_slice(), y.as_slice(), &[]));
                    let bits =
                        |x: &[f64]| x.iter().map(|x| if x.is_nan() { 0 } else { x.to_bits() }).collect::<Vec<_>>();
                    assert_eq!(bits(columns.as_slice()), bits(&slice), "{bad} {u} {y}");
                    assert!(!u[0].is_finite() || slice.iter().all(|x| x.is_finite()));
                }
            }
        }
    }
}
