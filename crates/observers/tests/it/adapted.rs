//! Filters with noises along their way and bounds: against enumeration, filters by hand, and constant noises.

#![cfg(feature = "dual")]

use luenberger_observers::adapted::{AdaptedFilter, NoisesAlong, nearest_within};
use luenberger_observers::{
    CovarianceFilter, ExtendedKalmanFilter, NoiseModel, ObserverError, SampledObserver, SigmaPoints,
    UnscentedKalmanFilter,
};
use luenberger_plants::{double_integrator, plant};
use luenberger_random::Random;
use nalgebra::{DMatrix, DVector, Matrix1, Matrix2, SVector, Vector1, Vector2};

/// The least `(x - xhat)' P^-1 (x - xhat)` of all choices of states that are on a bound, by the inverse of P: the free
/// ones follow from `Lambda_ff d_f = -Lambda_fa d_a` with `Lambda = P^-1`.
fn by_enumeration(xhat: &[f64], p: &DMatrix<f64>, lower: &[f64], upper: &[f64]) -> Vec<f64> {
    let (n, precision) = (xhat.len(), p.clone().try_inverse().unwrap());
    let mut best: Option<(f64, Vec<f64>)> = None;
    for choice in 0..3usize.pow(n as u32) {
        let ends: Vec<Option<f64>> = (0..n)
            .map(|i| match choice / 3usize.pow(i as u32) % 3 {
                0 => None,
                1 => Some(lower[i]),
                _ => Some(upper[i]),
            })
            .collect();
        if ends.iter().flatten().any(|end| !end.is_finite()) {
            continue;
        }
        let (free, fixed): (Vec<usize>, Vec<usize>) = (0..n).partition(|i| ends[*i].is_none());
        let mut d = DVector::zeros(n);
        for &i in &fixed {
            d[i] = ends[i].unwrap() - xhat[i];
        }
        let of = |rows: &[usize], columns: &[usize]| {
            DMatrix::from_fn(rows.len(), columns.len(), |i, j| precision[(rows[i], columns[j])])
        };
        if !free.is_empty() && !fixed.is_empty() {
            let right = DVector::from_fn(fixed.len(), |k, _| d[fixed[k]]);
            let solved = of(&free, &free).lu().solve(&-(of(&free, &fixed) * right)).unwrap();
            for (k, &i) in free.iter().enumerate() {
                d[i] = solved[k];
            }
        }
        let x: Vec<f64> = (0..n).map(|i| ends[i].unwrap_or(xhat[i] + d[i])).collect();
        let is_within = |i: usize| x[i] >= lower[i] - 1e-9 && x[i] <= upper[i] + 1e-9;
        let cost = d.dot(&(&precision * &d));
        if (0..n).all(is_within) && best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, x));
        }
    }
    best.unwrap().1
}

#[test]
fn the_projection_is_the_least_of_all_choices_of_bounds() {
    let mut random = Random(17);
    let mut active = [0usize; 5];
    for _ in 0..2000 {
        let n = 1 + random.below(4);
        let root = random.matrix(n, n);
        let units: Vec<f64> = (0..n).map(|_| 10f64.powf(random.between(-3.0, 3.0))).collect();
        let p = DMatrix::from_fn(n, n, |i, j| {
            units[i] * units[j] * ((&root * root.transpose())[(i, j)] + if i == j { 0.05 } else { 0.0 })
        });
        let xhat: Vec<f64> = units.iter().map(|unit| unit * random.between(-3.0, 3.0)).collect();
        let ends: Vec<(f64, f64)> = units
            .iter()
            .map(|unit| {
                let (a, b) = (random.between(-2.0, 1.0), random.between(0.1, 2.0));
                let (low, high) = (unit * a, unit * (a + b));
                match random.below(4) {
                    0 => (low, f64::INFINITY),
                    1 => (f64::NEG_INFINITY, high),
                    _ => (low, high),
                }
            })
            .collect();
        let (lower, upper): (Vec<f64>, Vec<f64>) = ends.into_iter().unzip();
        let (found, expected) = (nearest_within(&xhat, &p, &lower, &upper), by_enumeration(&xhat, &p, &lower, &upper));
        for i in 0..n {
            let deviation = p[(i, i)].sqrt();
            assert!((found[i] - expected[i]).abs() < 1e-7 * deviation, "{found:?} {expected:?} {xhat:?} {p}");
        }
        active[(0..n).filter(|&i| found[i] == lower[i] || found[i] == upper[i]).count()] += 1;
    }
    assert!(active.iter().all(|count| *count > 20), "{active:?}");
}

/// A state without variance stays, and is put on its bound alone; two states that are one move together.
#[test]
fn a_singular_covariance_moves_what_it_can() {
    let inf = f64::INFINITY;
    let p = DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 0.0, 4.0]);
    assert_eq!(nearest_within(&[3.0, 5.0], &p, &[-1.0, -inf], &[1.0, 2.0]), [1.0, 2.0]);
    let p = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 4.0]);
    assert_eq!(nearest_within(&[3.0, 5.0], &p, &[-inf, -inf], &[1.0, inf]), [1.0, 1.0]);
    // The second bound takes both further than the first.
    assert_eq!(nearest_within(&[3.0, 5.0], &p, &[-inf, -inf], &[1.0, -1.0]), [0.0, -1.0]);
    assert_eq!(nearest_within(&[0.5, 5.0], &p, &[-inf, -inf], &[1.0, inf]), [0.5, 5.0]);
}

/// A level whose root is measured, with a variance that grows with the level.
#[derive(Clone, Debug)]
struct Level;
plant!(Level, (1, 1, 1), |plant, t, x, u| [u[0] - x[0]], [x[0].sqrt()]);

/// V = 0.01 + 0.1 x + u, W = 0.2 x^2.
#[derive(Clone, Debug)]
struct Proportional;

impl NoisesAlong<f64> for Proportional {
    fn process_noise(&self, _t: f64, x: &[f64], _u: &[f64], w: &mut [f64]) -> bool {
        w[0] = 0.2 * x[0] * x[0];
        true
    }

    fn measurement_noise(&self, _t: f64, x: &[f64], u: &[f64], v: &mut [f64]) -> bool {
        v[0] = 0.01 + 0.1 * x[0] + u[0];
        true
    }
}

/// The step of each filter is that of the filter which is made with the noises of that step.
#[test]
fn noises_are_those_of_the_estimate() {
    let noises = |w: f64, v: f64| NoiseModel { w: Matrix1::new(w), v: Matrix1::new(v), p0: Matrix1::new(0.5) };
    let (u, ys) = (Vector1::new(0.3), [1.2, 0.9, 1.1, 0.4]);
    let extended = |w: f64, v: f64| ExtendedKalmanFilter::error_controlled(Level, noises(w, v), 0.1).unwrap();
    let unscented = |w: f64, v: f64| {
        UnscentedKalmanFilter::error_controlled(Level, noises(w, v), SigmaPoints::default(), 0.1).unwrap()
    };
    macro_rules! compare {
        ($filter:ident) => {
            let adapted = AdaptedFilter::new($filter(1.0, 1.0), Proportional);
            let mut state = adapted.initial(0.0, &Vector1::new(1.5), &u, &Vector1::new(0.0));
            let mut by_hand = state.clone();
            for (k, y) in ys.into_iter().enumerate() {
                let (t, y) = (0.1 * k as f64, Vector1::new(y));
                let v = 0.01 + 0.1 * adapted.estimate(&by_hand)[0] + u[0];
                let expected = $filter(1.0, v).measure(t, &mut by_hand, &u, &y, &[true]);
                assert_eq!(adapted.measure(t, &mut state, &u, &y, &[true]), expected);
                let w = 0.2 * adapted.estimate(&by_hand)[0].powi(2);
                assert!($filter(w, 1.0).advance(t, &mut by_hand, &u, 0.1));
                assert!(adapted.advance(t, &mut state, &u, 0.1));
                assert_eq!(state, by_hand);
            }
            // The same by steps.
            let mut stepped = adapted.initial(0.0, &Vector1::new(1.5), &u, &Vector1::new(0.0));
            for (k, y) in ys.into_iter().enumerate() {
                adapted.step(0.1 * k as f64, &mut stepped, &u, &Vector1::new(y));
            }
            assert_eq!(stepped, state);
        };
    }
    compare!(extended);
    compare!(unscented);
}

/// V that is no covariance: the sample is passed over. W that is none: no result, and a step is NaN.
#[test]
fn noises_that_are_none_are_said() {
    struct Wrong;
    impl NoisesAlong<f64> for Wrong {
        fn process_noise(&self, t: f64, _x: &[f64], _u: &[f64], w: &mut [f64]) -> bool {
            w[0] = if t > 0.5 { -1.0 } else { 1.0 };
            true
        }

        fn measurement_noise(&self, t: f64, _x: &[f64], _u: &[f64], v: &mut [f64]) -> bool {
            v[0] = if t > 0.2 { f64::NAN } else { 1.0 };
            true
        }
    }
    let noises = NoiseModel { w: Matrix1::new(1.0), v: Matrix1::new(1.0), p0: Matrix1::new(0.5) };
    let filter = AdaptedFilter::new(ExtendedKalmanFilter::error_controlled(Level, noises, 0.1).unwrap(), Wrong);
    let (u, y) = (Vector1::new(0.3), Vector1::new(1.0));
    let mut state = filter.initial(0.0, &Vector1::new(1.5), &u, &y);
    assert!(filter.measure(0.1, &mut state, &u, &y, &[true]).is_some());
    let before = state.clone();
    assert!(filter.measure(0.3, &mut state, &u, &y, &[true]).is_none());
    assert_eq!(state, before);
    assert!(!filter.advance(0.6, &mut state, &u, 0.1) && state == before);
    filter.step(0.6, &mut state, &u, &y);
    assert!(filter.estimate(&state)[0].is_nan());
}

/// Both filters of a linear plant with a bound: the update of the Kalman filter by hand, and the state beside moves by
/// its covariance.
#[test]
fn bounds_hold_after_every_update() {
    let p0 = Matrix2::new(1.0, 0.5, 0.5, 1.0);
    let noises = NoiseModel { w: Matrix2::identity() * 0.1, v: Matrix1::new(1.0), p0 };
    let (lower, upper) = ([-1.0, f64::NEG_INFINITY], [1.0, 0.9]);
    let extended = ExtendedKalmanFilter::error_controlled(double_integrator(), noises.clone(), 0.1).unwrap();
    let extended = AdaptedFilter::new(extended, ()).with_bounds(&lower, &upper).unwrap();
    let unscented =
        UnscentedKalmanFilter::error_controlled(double_integrator(), noises, SigmaPoints::default(), 0.1).unwrap();
    let unscented = AdaptedFilter::new(unscented, ()).with_bounds(&lower, &upper).unwrap();
    let (u, y) = (Vector1::new(1.0), Vector1::new(4.0));
    let mut one = extended.initial(0.0, &Vector2::zeros(), &u, &y);
    let mut other = unscented.initial(0.0, &Vector2::zeros(), &u, &y);
    // K = [1/2, 1/4], P+ = [1/2, 1/4; 1/4, 7/8]: from (2, 1) to the bound of the first state.
    extended.measure(0.0, &mut one, &u, &y, &[true]);
    unscented.measure(0.0, &mut other, &u, &y, &[true]);
    for estimate in [extended.estimate(&one), unscented.estimate(&other)] {
        assert!((estimate - Vector2::new(1.0, 0.5)).norm() < 1e-14, "{estimate}");
    }
    let expected = Matrix2::new(0.5, 0.25, 0.25, 0.875);
    assert!((one.covariance() - expected).norm() < 1e-14 && (other.covariance() - expected).norm() < 1e-14);
    for k in 0..30 {
        let t = 0.1 * f64::from(k);
        extended.advance(t, &mut one, &u, 0.1);
        extended.measure(t + 0.1, &mut one, &u, &y, &[true]);
        let estimate = extended.estimate(&one);
        assert!(estimate[0] <= 1.0 && estimate[1] <= 0.9, "{estimate}");
    }
    let wrong = extended.clone().with_bounds(&[0.0, 1.0], &[1.0, 1.0]).unwrap_err();
    assert_eq!(wrong, ObserverError::Box { axis: 1, lower: 1.0, upper: 1.0 });
    assert!(matches!(extended.with_bounds(&[0.0], &[1.0]), Err(ObserverError::Table { expected: 2, found: 1, .. })));
    let _: SVector<f64, 1> = y;
}
