//! The particle filter beside the Kalman filter, which is exact for a linear plant, and beside the exact filter of a
//! nonlinear one by integration on a grid.

use luenberger_observers::{
    CovarianceFilter, KalmanFilter, KalmanModel, NoiseModel, ObserverError, ParticleFilter, ParticleNoise, Prediction,
    SampledObserver,
};
use luenberger_plants::{Differentiable, Dimensions, LinearPlant, Plant, Shape};
use luenberger_random::Random;
use nalgebra::{DMatrix, DVector, Dyn, RealField, convert, dmatrix, dvector};

/// Numbers by their place, from the tests' own generator.
#[derive(Clone)]
struct Numbers(u64);

impl Numbers {
    fn at(&self, k: u64, index: u64) -> Random {
        let mut random = Random(self.0 ^ (2 * k + index).wrapping_mul(0x2545_f491_4f6c_dd1d));
        random.bits();
        random
    }
}

impl ParticleNoise for Numbers {
    fn normals(&self, k: u64, numbers: &mut [f64]) {
        let mut random = self.at(k, 0);
        for number in numbers {
            *number = random.normal_pair()[0];
        }
    }

    fn uniform(&self, k: u64) -> f64 {
        self.at(k, 1).uniform()
    }
}

/// The growth model of Gordon, Salmond and Smith: x+ = x/2 + 25 x/(1 + x^2) + 8 cos(1.2 t) + w, y = x^2/20 + v, with
/// W = 10 and V = 1. The sign of x is not measured.
#[derive(Clone)]
struct Growth;

impl Shape for Growth {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: 1, inputs: 0, outputs: 1 }
    }
}

impl<T: RealField + Copy> Plant<T> for Growth {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;

    fn derivative(&self, t: T, x: &DVector<T>, _u: &DVector<T>) -> DVector<T> {
        let number = |x: f64| convert::<f64, T>(x);
        let x = x[0];
        dvector![x * number(0.5) + x * number(25.0) / (x * x + T::one()) + (t * number(1.2)).cos() * number(8.0)]
    }

    fn output(&self, _t: T, x: &DVector<T>, _u: &DVector<T>) -> DVector<T> {
        dvector![x[0] * x[0] * convert::<f64, T>(0.05)]
    }
}

impl<T: RealField + Copy> Differentiable<T, Dyn, Dyn, Dyn> for Growth {
    fn directional(&self, t: T, x: &DVector<T>, u: &DVector<T>, v: &DVector<T>) -> (DVector<T>, DVector<T>) {
        let (number, square) = (|x: f64| convert::<f64, T>(x), x[0] * x[0]);
        let below = square + T::one();
        let slope = number(0.5) + (T::one() - square) * number(25.0) / (below * below);
        (self.derivative(t, x, u), v * slope)
    }

    fn output_directional(&self, t: T, x: &DVector<T>, u: &DVector<T>, v: &DVector<T>) -> (DVector<T>, DVector<T>) {
        (self.output(t, x, u), v * (x[0] * convert::<f64, T>(0.1)))
    }
}

fn growth(particles: usize, seed: u64) -> ParticleFilter<Growth, Numbers> {
    let noises = NoiseModel { w: dmatrix![10.0], v: dmatrix![1.0], p0: dmatrix![5.0] };
    ParticleFilter::new(Growth, noises, (1.0, Prediction::Discrete), particles, Numbers(seed)).unwrap()
}

/// States and outputs of a run of the growth model from x(0), which has the variance 5.
fn run(seed: u64, steps: usize) -> Vec<(f64, f64)> {
    let mut random = Random(seed);
    let mut normal = || random.normal_pair()[0];
    let mut x = 5f64.sqrt() * normal();
    let none = DVector::zeros(0);
    (0..steps)
        .map(|k| {
            let pair = (x, Growth.output(0.0, &dvector![x], &none)[0] + normal());
            x = Growth.derivative(k as f64, &dvector![x], &none)[0] + 10f64.sqrt() * normal();
            pair
        })
        .collect()
}

/// Mean and variance after the update and the prediction of each sample, by the density on a grid: Bayes' rule and the
/// integral of Chapman and Kolmogorov as they stand.
fn on_a_grid(outputs: &[f64]) -> Vec<(f64, f64)> {
    let (cells, half) = (1201, 45.0);
    let at = |i: usize| -half + 2.0 * half * i as f64 / (cells - 1) as f64;
    let none = DVector::zeros(0);
    let mut density: Vec<f64> = (0..cells).map(|i| (-at(i) * at(i) / 10.0).exp()).collect();
    let mut found = Vec::new();
    for (k, y) in outputs.iter().enumerate() {
        for (i, density) in density.iter_mut().enumerate() {
            *density *= (-0.5 * (y - at(i) * at(i) / 20.0).powi(2)).exp();
        }
        let sum: f64 = density.iter().sum();
        for density in &mut density {
            *density /= sum;
        }
        let mean: f64 = density.iter().enumerate().map(|(i, density)| at(i) * density).sum();
        let variance = density.iter().enumerate().map(|(i, density)| (at(i) - mean).powi(2) * density).sum();
        found.push((mean, variance));
        let mut next = vec![0.0; cells];
        for (i, density) in density.iter().enumerate().filter(|(_, density)| **density > 1e-12) {
            let image = Growth.derivative(k as f64, &dvector![at(i)], &none)[0];
            for (j, next) in next.iter_mut().enumerate() {
                *next += density * (-(at(j) - image).powi(2) / 20.0).exp();
            }
        }
        density = next;
    }
    found
}

/// Mean and variance of 2000 particles are those of the exact filter, within five of the deviations that so many
/// particles leave, which is measured with other seeds.
#[test]
fn the_growth_model_has_the_exact_mean_and_variance() {
    let run = run(3, 25);
    let exact = on_a_grid(&run.iter().map(|(_, y)| *y).collect::<Vec<_>>());
    let none = DVector::zeros(0);
    let means: Vec<Vec<(f64, f64)>> = (0..8)
        .map(|seed| {
            let filter = growth(2000, 100 + seed);
            let mut state = filter.initial(0.0, &dvector![0.0], &none, &dvector![0.0]);
            let each = run.iter().enumerate().map(|(k, (_, y))| {
                filter.measure(k as f64, &mut state, &none, &dvector![*y], &[true]).unwrap();
                let (mean, mut p) = (filter.estimate(&state)[0], [0.0]);
                assert!(filter.covariance_into(&state, &mut p));
                assert!(filter.advance(k as f64, &mut state, &none, 1.0));
                (mean, p[0])
            });
            each.collect()
        })
        .collect();
    for (k, (mean, variance)) in exact.iter().enumerate() {
        let of = |part: fn(&(f64, f64)) -> f64| {
            let all: Vec<f64> = means.iter().map(|run| part(&run[k])).collect();
            let average = all.iter().sum::<f64>() / 8.0;
            let error = (all.iter().map(|x| (x - average).powi(2)).sum::<f64>() / (7.0 * 8.0)).sqrt();
            (average, error)
        };
        // The other sign of x is another peak, 2 xhat away. One of a probability of 3e-4 has five of the 16 000
        // particles or none.
        let (rare, apart) = (3e-4, 2.0 * mean.abs());
        for ((found, error), exact, missing) in
            [(of(|run| run.0), mean, rare * apart), (of(|run| run.1), variance, rare * apart * apart)]
        {
            // A grid of 0.075 adds some thousandths.
            let allowed = 5.0 * error + missing + 0.01 * (1.0 + exact.abs());
            assert!((found - exact).abs() <= allowed, "{k}: {found} {error} {exact}");
        }
    }
}

/// The root mean square error of 50 particles over 100 runs of 100 steps, each with its own: 5.54 in Arulampalam,
/// Maskell, Gordon and Clapp, A tutorial on particle filters, IEEE Transactions on Signal Processing 50, 2002, table I.
#[test]
fn the_error_for_the_growth_model_is_the_published_one() {
    let none = DVector::zeros(0);
    let errors: Vec<f64> = (0..100)
        .map(|seed| {
            let filter = growth(50, 7000 + seed);
            let mut state = filter.initial(0.0, &dvector![0.0], &none, &dvector![0.0]);
            let square = run(900 + seed, 100).into_iter().enumerate().map(|(k, (x, y))| {
                filter.measure(k as f64, &mut state, &none, &dvector![y], &[true]);
                let error = filter.estimate(&state)[0] - x;
                assert!(filter.advance(k as f64, &mut state, &none, 1.0));
                error * error
            });
            (square.sum::<f64>() / 100.0).sqrt()
        })
        .collect();
    let mean = errors.iter().sum::<f64>() / 100.0;
    let deviation = (errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / 9900.0).sqrt();
    assert!((mean - 5.54).abs() < 5.0 * deviation, "{mean} +- {deviation}");
}

fn oscillator() -> LinearPlant<f64, Dyn, Dyn, Dyn> {
    LinearPlant::new(dmatrix![0.9, 0.2; -0.2, 0.9], dmatrix![0.0; 0.3], dmatrix![1.0, 0.0; 0.0, 1.0]).unwrap()
}

/// Estimate, covariance, square and determinant of a linear plant are those of the Kalman filter, within what 8000
/// particles leave; an output that is NaN or not measured counts for neither.
#[test]
fn a_linear_plant_has_the_kalman_filter() {
    let (w, v, p0) = (dmatrix![0.02, 0.0; 0.0, 0.03], dmatrix![0.2, 0.05; 0.05, 0.3], dmatrix![1.0, 0.3; 0.3, 0.5]);
    let LinearPlant { a, b, c, .. } = oscillator();
    let model = KalmanModel { ad: a, bd: b, c, w: w.clone(), v: v.clone(), p0: p0.clone(), period: 0.5 };
    let exact = KalmanFilter::new(model).unwrap();
    let noises = NoiseModel { w, v, p0 };
    let filter = ParticleFilter::new(oscillator(), noises, (0.5, Prediction::Discrete), 8000, Numbers(5)).unwrap();
    let (u, start) = (dvector![0.4], dvector![1.0, -1.0]);
    let mut state = filter.initial(0.0, &start, &u, &dvector![0.0, 0.0]);
    let mut kalman = exact.initial(0.0, &start, &u, &dvector![0.0, 0.0]);
    let (mut random, mut x) = (Random(12), dvector![0.2, -0.7]);
    for k in 0..30 {
        let t = 0.5 * f64::from(k);
        let mut y = &x + dvector![0.4 * random.normal_pair()[0], 0.5 * random.normal_pair()[0]];
        x = &exact.model().ad * &x + dvector![0.1 * random.normal_pair()[0], 0.12 + 0.1 * random.normal_pair()[0]];
        y[1] = if k % 3 == 1 { f64::NAN } else { y[1] };
        let measured = [k % 4 != 2, true];
        let found = filter.measure_with_determinant(t, &mut state, &u, &y, &measured);
        let expected = exact.measure_with_determinant(t, &mut kalman, &u, &y, &measured);
        match (found, expected) {
            (Some((square, Some(log))), Some((expected, Some(wanted)))) => {
                assert!((square - expected).abs() < 0.08 * (1.0 + expected), "{k}: {square} {expected}");
                assert!((log - wanted).abs() < 0.08, "{k}: {log} {wanted}");
            }
            (found, expected) => assert_eq!((found, expected), (None, None), "{k}"),
        }
        let mut p = [0.0; 4];
        assert!(filter.covariance_into(&state, &mut p));
        assert!((filter.estimate(&state) - kalman.estimate()).amax() < 0.03, "{k}");
        assert!((DMatrix::from_column_slice(2, 2, &p) - kalman.covariance()).amax() < 0.03, "{k}");
        assert!(filter.advance(t, &mut state, &u, 0.5) && exact.advance(t, &mut kalman, &u, 0.5));
    }
}

/// The same bits from a state that was stored; other numbers from another seed.
#[test]
fn a_stored_state_goes_on_with_the_same_numbers() {
    let none = DVector::zeros(0);
    let outputs: Vec<f64> = run(1, 20).into_iter().map(|(_, y)| y).collect();
    let steps = |filter: &ParticleFilter<Growth, Numbers>, mut state: DVector<f64>, from: usize| {
        for (k, y) in outputs.iter().enumerate().skip(from) {
            filter.step(k as f64, &mut state, &none, &dvector![*y]);
        }
        state
    };
    let filter = growth(60, 4);
    let start = filter.initial(0.0, &dvector![0.0], &none, &dvector![0.0]);
    let mut halfway = start.clone();
    for (k, y) in outputs.iter().enumerate().take(10) {
        let mut slice = halfway.as_slice().to_vec();
        filter.step(k as f64, &mut halfway, &none, &dvector![*y]);
        assert!(filter.step_into(k as f64, &mut slice, &[], &[*y], &[]));
        assert_eq!(slice, halfway.as_slice());
    }
    assert_eq!(steps(&filter, start.clone(), 0), steps(&filter.clone(), halfway, 10));
    let other = growth(60, 5);
    assert_ne!(steps(&other, other.initial(0.0, &dvector![0.0], &none, &dvector![0.0]), 0), steps(&filter, start, 0));
}

/// A sample that is impossible for every particle is passed over; without any finite particle there is no prediction.
#[test]
fn what_has_no_result() {
    let none = DVector::zeros(0);
    let filter = growth(30, 9);
    let start = filter.initial(0.0, &dvector![0.0], &none, &dvector![0.0]);
    for y in [f64::NAN, f64::INFINITY, 1e300] {
        let mut state = start.clone();
        assert_eq!(filter.measure(0.0, &mut state, &none, &dvector![y], &[true]), None);
        assert_eq!(state, start);
    }
    let mut state = start.clone();
    assert!(!filter.advance(f64::NAN, &mut state, &none, 1.0) && state == start);
    filter.step(f64::NAN, &mut state, &none, &dvector![1.0]);
    assert!(filter.estimate(&state)[0].is_nan());
    for (u, y) in [(1, 1), (0, 2), (0, 0)] {
        let mut state = start.clone();
        assert_eq!(filter.measure(0.0, &mut state, &DVector::zeros(u), &DVector::zeros(y), &[]), None);
        assert_eq!(state, start);
    }
    let noises = || NoiseModel { w: dmatrix![10.0], v: dmatrix![1.0], p0: dmatrix![5.0] };
    let made = |noises, time, count| ParticleFilter::new(Growth, noises, time, count, Numbers(0)).err();
    let discrete = (1.0, Prediction::Discrete);
    assert!(matches!(made(noises(), discrete, 1), Some(ObserverError::TooFew { .. })));
    assert!(matches!(made(noises(), (0.0, Prediction::Discrete), 9), Some(ObserverError::Period { .. })));
    assert!(matches!(made(noises(), (1.0, Prediction::RungeKutta(0)), 9), Some(ObserverError::Substeps)));
    let negative = NoiseModel { v: dmatrix![-1.0], ..noises() };
    assert!(matches!(made(negative, discrete, 9), Some(ObserverError::NotDefinite { .. })));
}

/// In continuous time, over a period of any stiffness: the covariance of a first-order lag with the rate 1000 tends to
/// W/2000, and its particles stay finite.
#[test]
fn a_stiff_plant_in_continuous_time() {
    let plant = LinearPlant::<f64, Dyn, Dyn, Dyn>::new(dmatrix![-1000.0], DMatrix::zeros(1, 0), dmatrix![1.0]).unwrap();
    let noises = NoiseModel { w: dmatrix![2.0], v: dmatrix![1.0], p0: dmatrix![1.0] };
    let filter = ParticleFilter::new(plant, noises, (0.1, Prediction::ErrorControlled), 20_000, Numbers(2)).unwrap();
    let none = DVector::zeros(0);
    let mut state = filter.initial(0.0, &dvector![3.0], &none, &dvector![0.0]);
    assert!(filter.advance(0.0, &mut state, &none, 0.1));
    let mut p = [0.0];
    assert!(filter.covariance_into(&state, &mut p));
    // The standard error of a variance is the root of 2/N of it.
    assert!((p[0] - 1e-3).abs() < 5.0 * 1e-3 * (2.0f64 / 20_000.0).sqrt(), "{p:?}");
    assert!(filter.estimate(&state)[0].abs() < 5.0 * (1e-3f64 / 20_000.0).sqrt());
}
