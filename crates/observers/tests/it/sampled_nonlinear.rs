//! Observers of nonlinear plants that are stepped once per sample: the copy, and the numerical KKL observer.
#![cfg(all(feature = "alloc", feature = "dual"))]

use luenberger_observers::numerical_kkl::{
    Coordinates, Node, PolynomialInverse, PolynomialTree, SampledFilter, SampledKkl,
};
use luenberger_observers::{
    NonlinearLuenbergerObserver, Observer, ObserverError, SampledNonlinearObserver, SampledObserver,
};
use luenberger_plants::{Plant, VanDerPol, plant};
use nalgebra::{Matrix2, SVector, Vector1, Vector2};

type Column = SVector<f64, 0>;

fn rk4<const N: usize>(
    f: impl Fn(f64, &SVector<f64, N>) -> SVector<f64, N>,
    t: f64,
    x: &SVector<f64, N>,
    tau: f64,
) -> SVector<f64, N> {
    let k1 = f(t, x);
    let k2 = f(t + tau / 2.0, &(x + k1 * (tau / 2.0)));
    let k3 = f(t + tau / 2.0, &(x + k2 * (tau / 2.0)));
    let k4 = f(t + tau, &(x + k3 * tau));
    x + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (tau / 6.0)
}

/// The largest distance from the observer in continuous time along a run of Van der Pol's oscillator, at the samples.
fn distance(h: f64, substeps: usize) -> f64 {
    let (l, u) = (Vector2::new(4.0, 5.0), Column::zeros());
    let plant = VanDerPol::default();
    let continuous = NonlinearLuenbergerObserver::new(plant, l).unwrap();
    let sampled = SampledNonlinearObserver::new(plant, l, h, substeps).unwrap();
    let (mut x, mut reference, mut xhat) = (Vector2::new(1.5, -0.5), Vector2::zeros(), Vector2::zeros());
    let fine = 1e-3;
    let (count, mut largest) = ((h / fine).round() as usize, 0.0f64);
    for k in 0..(4.0 / h).round() as usize {
        sampled.step(k as f64 * h, &mut xhat, &u, &plant.output(0.0, &x, &u));
        for i in 0..count {
            let t = k as f64 * h + i as f64 * fine;
            // Plant and observer as one system.
            let both = rk4(
                |t, z: &SVector<f64, 4>| {
                    let (x, xhat) = (Vector2::new(z[0], z[1]), Vector2::new(z[2], z[3]));
                    let y: Vector1<f64> = plant.output(t, &x, &u);
                    let (dx, slope) = (plant.derivative(t, &x, &u), continuous.derivative(t, &xhat, &u, &y));
                    SVector::<f64, 4>::new(dx[0], dx[1], slope[0], slope[1])
                },
                t,
                &SVector::<f64, 4>::new(x[0], x[1], reference[0], reference[1]),
                fine,
            );
            (x, reference) = (Vector2::new(both[0], both[1]), Vector2::new(both[2], both[3]));
        }
        largest = largest.max((xhat - reference).norm());
    }
    assert!((x - xhat).norm() < 1e-3, "h = {h}: {x} {xhat}");
    largest
}

/// The predicted output differs from the measured one by `O(h |e|)`.
#[test]
fn the_sampled_observer_tends_to_the_continuous_observer_as_the_period_goes_to_zero() {
    let distances = [0.08, 0.04, 0.02].map(|h| distance(h, 2));
    assert!(distances[0] < 0.5 && distances[2] > 1e-6, "{distances:?}");
    for pair in distances.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((1.6..2.6).contains(&ratio), "{distances:?}");
    }
}

/// On the plant's own motion it is the plant, with nonzero slopes of the output: no error of the order of h is left.
#[test]
fn without_an_error_the_sampled_observer_is_the_runge_kutta_solution() {
    let (plant, u) = (VanDerPol::default(), Column::zeros());
    let sampled = SampledNonlinearObserver::new(plant, Vector2::new(4.0, 5.0), 0.1, 4).unwrap();
    let (mut x, mut xhat) = (Vector2::new(1.5, -0.5), Vector2::new(1.5, -0.5));
    for k in 0..100 {
        let t = f64::from(k) * 0.1;
        sampled.step(t, &mut xhat, &u, &plant.output(t, &x, &u));
        for _ in 0..100 {
            x = rk4(|t, x| plant.derivative(t, x, &u), 0.0, &x, 1e-3);
        }
        assert!((x - xhat).norm() < 1e-6, "{k}: {x} {xhat}");
    }
}

#[test]
fn what_cannot_be_stepped_is_an_error() {
    let new = |l, h, substeps| {
        SampledNonlinearObserver::<_, f64, _, _, _>::new(VanDerPol::default(), l, h, substeps).unwrap_err()
    };
    assert_eq!(new(Vector2::zeros(), 0.0, 1), ObserverError::Period { period: 0.0 });
    assert!(matches!(new(Vector2::zeros(), f64::NAN, 1), ObserverError::Period { .. }));
    assert_eq!(new(Vector2::zeros(), 0.1, 0), ObserverError::Substeps);
    assert!(matches!(new(Vector2::new(f64::NAN, 0.0), 0.1, 1), ObserverError::Matrix(_)));
}

/// x' = -x, y = x.
#[derive(Debug)]
struct Decay;

plant!(Decay, (1, 0, 1), |plant, t, x, u| -x, *x);

/// With D = diag(-2, -3) and B = (1, 1) it is T(x) = (x, x/2), which solves `-m_i = -d_i m_i + 1`.
#[test]
fn the_sampled_kkl_observer_follows_the_plant_and_converges() {
    let nodes: [Node<f64>; 0] = [];
    // Local coordinates s = z/4; x = 4 s1, and z = (4 s, 2 s).
    let inverse = [0.0, 0.0, 0.25, 0.25, -4.0, 4.0, 0.0, 4.0, 0.0];
    let forward = [0.0, 0.25, -4.0, -4.0, 4.0, 4.0, 4.0, 0.0, 2.0, 0.0];
    let (inverse, forward) = (PolynomialTree::new(1, nodes, inverse), PolynomialTree::new(1, nodes, forward));
    // The two trees lend arrays of different lengths: on the heap they have one type.
    let (inverse, forward) = (inverse.unwrap().cast::<f64>(), forward.unwrap().cast::<f64>());
    let bounds = (Vector1::new(-4.0), Vector1::new(4.0));
    let inverse = PolynomialInverse::new(Coordinates::identity(), bounds, inverse, forward).unwrap();
    let d = Matrix2::new(-2.0, 0.0, 0.0, -3.0);
    let filter = SampledFilter { d, b: Vector2::new(1.0, 1.0), period: 0.1, substeps: 1 };
    let observer = SampledKkl::new(Decay, filter, inverse.clone()).unwrap();
    let (u, y) = (Column::zeros(), |k: i32| Vector1::new((-0.1 * f64::from(k)).exp()));
    for (first, bound) in [(1.0, 1e-6), (-3.0, 0.1)] {
        let mut z = observer.initial(0.0, &Vector1::new(first), &u, &y(0));
        assert!((observer.estimate(&z)[0] - first).abs() < 1e-12);
        for k in 0..20 {
            observer.step(0.1 * f64::from(k), &mut z, &u, &y(k));
        }
        // From a wrong estimate the error decays like exp(-2 t).
        assert!((observer.estimate(&z) - y(20)).norm() < bound, "{first}: {z} {}", y(20));
    }
    let none = SampledFilter { substeps: 0, ..filter };
    assert_eq!(SampledKkl::new(Decay, none, inverse.clone()).unwrap_err(), ObserverError::Substeps);
    let still = SampledFilter { period: 0.0, ..filter };
    assert!(matches!(SampledKkl::new(Decay, still, inverse).unwrap_err(), ObserverError::Period { .. }));
}
