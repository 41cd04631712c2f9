//! Observers whose sizes are known at run time run with their sizes in a type where these are small: with the same
//! bits.

use luenberger_observers::{
    Differentiable, Dimensions, ExtendedKalmanFilter, KalmanFilter, KalmanModel, NoiseModel, Plant,
    SampledNonlinearObserver, SampledObserver, Shape, SigmaPoints, UnscentedKalmanFilter,
};
use luenberger_plants::Column;
use nalgebra::{DMatrix, DVector, Dyn};

/// `x_i' = x_(i+1) - x_i^3/4 + u1 t`, `y_j = x_j + x_j^2/8`, the indices in a ring.
struct Ring {
    states: usize,
    outputs: usize,
}

impl Shape for Ring {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: self.states, inputs: 1, outputs: self.outputs }
    }
}

impl Plant<f64> for Ring {
    type State = DVector<f64>;
    type Input = DVector<f64>;
    type Output = DVector<f64>;

    fn derivative(&self, t: f64, x: &DVector<f64>, u: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(self.states, |i, _| x[(i + 1) % self.states] - x[i] * x[i] * x[i] * 0.25 + u[0] * t)
    }

    fn output(&self, _t: f64, x: &DVector<f64>, _u: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(self.outputs, |j, _| x[j % self.states] + x[j % self.states] * x[j % self.states] * 0.125)
    }
}

impl Differentiable<f64, Dyn, Dyn, Dyn> for Ring {
    fn directional(
        &self,
        t: f64,
        x: &DVector<f64>,
        u: &DVector<f64>,
        v: &DVector<f64>,
    ) -> (DVector<f64>, DVector<f64>) {
        let slope = |i: usize| v[(i + 1) % self.states] - x[i] * x[i] * 0.75 * v[i];
        (self.derivative(t, x, u), DVector::from_fn(self.states, |i, _| slope(i)))
    }

    fn output_directional(
        &self,
        t: f64,
        x: &DVector<f64>,
        u: &DVector<f64>,
        v: &DVector<f64>,
    ) -> (DVector<f64>, DVector<f64>) {
        let slope = |i: usize| v[i] + x[i] * v[i] * 0.25;
        (self.output(t, x, u), DVector::from_fn(self.outputs, |j, _| slope(j % self.states)))
    }
}

/// Up to the most states and outputs, and beyond.
const SIZES: [(usize, usize); 9] = [(1, 1), (2, 1), (3, 2), (4, 3), (5, 1), (6, 4), (8, 4), (9, 1), (2, 5)];

fn noises(n: usize, p: usize) -> NoiseModel<f64, Dyn, Dyn> {
    let joined =
        |order: usize| DMatrix::from_fn(order, order, |i, j| if i == j { 0.5 } else { 0.125 / (i + j) as f64 });
    NoiseModel { w: joined(n) * 0.1, v: joined(p) * 0.2, p0: joined(n) }
}

/// Samples of which the last outputs are not measured, or not finite.
fn samples(p: usize) -> Vec<(f64, DVector<f64>, Vec<bool>)> {
    let y = |k: usize| DVector::from_fn(p, |j, _| 0.5 + 0.125 * ((3 * k + j) % 5) as f64);
    let mut all: Vec<_> = (0..6).map(|k| (0.01 * k as f64, y(k), vec![true; p])).collect();
    all[1].2[p - 1] = false;
    all[3].2 = vec![false; p];
    all[4].1[p - 1] = f64::NAN;
    all
}

/// The steps of an observer, on columns and on slices, are those of `by_hand`.
fn compare<O>(observer: &O, n: usize, by_hand: impl Fn(f64, &mut O::State, &DVector<f64>, &DVector<f64>, &[bool]))
where
    O: SampledObserver<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>,
{
    let size = observer.dimensions();
    let (u, start) = (DVector::repeat(size.inputs, 0.25), DVector::from_fn(n, |i, _| 0.5 - 0.0625 * i as f64));
    let mut expected = observer.initial(0.0, &start, &u, &DVector::zeros(size.outputs));
    let (mut state, mut entries) = (expected.clone(), expected.as_slice().to_vec());
    for (t, y, measured) in samples(size.outputs) {
        by_hand(t, &mut expected, &u, &y, &measured);
        if measured.contains(&false) {
            observer.step_partial(t, &mut state, &u, &y, &measured);
        } else {
            observer.step(t, &mut state, &u, &y);
        }
        assert!(observer.step_into(t, &mut entries, u.as_slice(), y.as_slice(), &measured));
        let bits = |entries: &[f64]| entries.iter().map(|entry| entry.to_bits()).collect::<Vec<_>>();
        assert!(expected.as_slice().iter().all(|entry| entry.is_finite()), "{size:?} at {t}");
        assert_eq!(bits(state.as_slice()), bits(expected.as_slice()), "{size:?} at {t}");
        assert_eq!(bits(&entries), bits(expected.as_slice()), "{size:?} at {t}");
    }
    // Columns of other lengths change nothing.
    let before = entries.clone();
    assert!(!observer.step_into(0.0, &mut entries, &[0.25; 9], &before[..1], &[]));
    assert!(!observer.step_into(0.0, &mut entries[1..], u.as_slice(), &before[..1], &[]));
    assert_eq!(entries, before);
}

type Extended = ExtendedKalmanFilter<Ring, f64, Dyn, Dyn, Dyn>;
type Unscented = UnscentedKalmanFilter<Ring, f64, Dyn, Dyn, Dyn>;

fn compare_extended(filter: &Extended, n: usize) {
    compare(filter, n, |t, state, u, y, measured| {
        if measured.contains(&true) {
            filter.update_partial(t, state, u, y, |output| measured[output]);
        }
        filter.finish(t, state, u);
    });
}

fn compare_unscented(filter: &Unscented, n: usize) {
    compare(filter, n, |t, state, u, y, measured| {
        if measured.contains(&true) {
            filter.update_partial(t, state, u, y, |output| measured[output]);
        }
        filter.finish(t, state, u);
    });
}

#[test]
fn steps_of_filters_are_updates_and_predictions() {
    for (states, outputs) in SIZES {
        let (plant, noises) = (|| Ring { states, outputs }, || noises(states, outputs));
        let extended = || Extended::new(plant(), noises(), 0.01, 2).unwrap();
        compare_extended(&extended(), states);
        compare_extended(&Extended::discrete(plant(), noises(), 0.01).unwrap(), states);
        compare_extended(&Extended::error_controlled(plant(), noises(), 0.01).unwrap(), states);
        compare_extended(&extended().with_iterations(3).unwrap().with_gate(0.75).unwrap(), states);
        let turns = |count: usize| DVector::from_fn(count, |i, _| if i == 0 { 0.25 } else { 0.0 });
        compare_extended(&extended().with_angles(turns(outputs)).unwrap(), states);
        let vectors = DVector::from_fn(states, |i, _| if i < 2 { 1.0 } else { 0.0 });
        compare_extended(&extended().with_unit_vectors(vectors).unwrap(), states);
        let unscented = || Unscented::new(plant(), noises(), SigmaPoints::default(), 0.01, 2).unwrap();
        compare_unscented(&unscented(), states);
        compare_unscented(&unscented().with_gate(0.75).unwrap(), states);
        compare_unscented(&unscented().with_angles(turns(outputs), turns(states)).unwrap(), states);
        let discrete = Unscented::discrete(plant(), noises(), SigmaPoints::default(), 0.01).unwrap();
        compare_unscented(&discrete, states);
    }
}

#[test]
fn steps_of_linear_filters_are_updates_and_predictions() {
    for (n, p) in SIZES {
        let NoiseModel { w, v, p0 } = noises(n, p);
        let ad = DMatrix::from_fn(n, n, |i, j| 0.5 / (1 + i + 2 * j) as f64);
        let (bd, c) = (
            DMatrix::from_fn(n, 3, |i, j| 0.25 / (1 + i + j) as f64),
            DMatrix::from_fn(p, n, |i, j| 1.0 / (1 + i + j) as f64),
        );
        let filter = KalmanFilter::new(KalmanModel { ad, bd, c, w, v, p0, period: 0.01 }).unwrap();
        let fed = filter.clone().with_feedthrough(DMatrix::repeat(p, 3, 0.3)).unwrap();
        for filter in [filter, fed] {
            compare(&filter, n, |_, state, u, y, measured| {
                if measured.contains(&true) {
                    filter.update_partial(state, u, y, |output| measured[output]);
                }
                assert!(filter.predict(state, u));
            });
        }
    }
}

#[test]
fn steps_of_a_copy_are_those_of_runge_and_kutta() {
    for (states, outputs) in SIZES {
        let l = DMatrix::from_fn(states, outputs, |i, j| 1.0 / (1 + i + j) as f64);
        let copy = SampledNonlinearObserver::new(Ring { states, outputs }, l, 0.01, 2).unwrap();
        compare(&copy, states, |t, xhat: &mut DVector<f64>, u, y, measured| {
            let mut w = DVector::from_fn(outputs, |j, _| if measured[j] { y[j] } else { f64::NAN });
            let tau = 0.01 / 2.0;
            for k in 0..2 {
                let now = t + tau * f64::from(k);
                let (x, seen) = (xhat.clone(), w.clone());
                let (k1, w1) = copy.slope(now, &x, &seen, u);
                let at = |k: &DVector<f64>, w: &DVector<f64>, tau: f64| {
                    copy.slope(now + tau, &(&x + k * tau), &(&seen + w * tau), u)
                };
                let (k2, w2) = at(&k1, &w1, tau * 0.5);
                let (k3, w3) = at(&k2, &w2, tau * 0.5);
                let (k4, w4) = at(&k3, &w3, tau);
                *xhat += (k1 + (k2 + k3) * 2.0 + k4) * (tau * (1.0 / 6.0));
                w += (w1 + (w2 + w3) * 2.0 + w4) * (tau * (1.0 / 6.0));
            }
        });
    }
}
