//! Resets and bounded parameters of [KKL+PEB] observers, as algebra at random states: a reset that transforms the
//! filters takes the flow to itself and leaves the estimate, for every estimator; one that restarts them is a start
//! with the same estimate; a parameter is projected to its bound.
#![cfg(feature = "alloc")]

use luenberger_observers::estimator::ParameterEstimator;
use luenberger_observers::estimator::drem::{Drem, Kreisselmeier, LtiFilters};
use luenberger_observers::estimator::gradient::Gradient;
use luenberger_observers::pebo::PebSize;
use luenberger_observers::{
    Diagnose, Diagnosis, FilterMemory, KklMap, KklPebObserver, Observer, ObserverError, Regression, Reset,
};
use nalgebra::{DefaultAllocator, Matrix2, Matrix3, U1, U2, U3, Vector1, Vector2, Vector3};
use proptest::prelude::*;

/// xi1 decays, xi2 and xi3 are only integrated; two rows, two parameters; m depends on y alone, and g is linear in the
/// integrated entries with the coefficients m.
#[derive(Clone, Copy)]
struct Maps {
    bound: Option<f64>,
}

impl KklMap<f64> for Maps {
    type Xi = U3;
    type Inputs = U1;
    type Outputs = U2;
    type Estimate = U3;

    fn lambda(&self, _t: f64, _u: &Vector1<f64>, _y: &Vector2<f64>) -> Matrix3<f64> {
        Matrix3::from_diagonal(&Vector3::new(-2.0, 0.0, 0.0))
    }

    fn injection(&self, _t: f64, _xi: &Vector3<f64>, u: &Vector1<f64>, y: &Vector2<f64>) -> Vector3<f64> {
        Vector3::new(y[0] * u[0], y[1], y[0] - y[1] * y[1])
    }

    fn left_inverse(&self, _t: f64, xi: &Vector3<f64>, y: &Vector2<f64>) -> Vector3<f64> {
        Vector3::new(xi[0] - y[0], xi[1] * (1.0 + y[0] * y[0]), xi[2] + xi[0] * y[1])
    }

    fn image(&self, _t: f64, xhat: &Vector3<f64>, y: &Vector2<f64>) -> Vector3<f64> {
        let first = xhat[0] + y[0];
        Vector3::new(first, xhat[1] / (1.0 + y[0] * y[0]), xhat[2] - first * y[1])
    }
}

impl Regression<f64> for Maps {
    type Rows = U2;
    type Parameters = U2;

    fn signal(&self, _t: f64, y: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(y[0] + 3.0, y[0] * y[1])
    }

    fn known(&self, t: f64, xi: &Vector3<f64>, u: &Vector1<f64>, y: &Vector2<f64>) -> Vector2<f64> {
        self.regressor(t, xi, u, y) * Vector2::new(xi[1], xi[2]) + Vector2::new(xi[0] + u[0], y[0])
    }

    fn regressor(&self, _t: f64, _xi: &Vector3<f64>, _u: &Vector1<f64>, y: &Vector2<f64>) -> Matrix2<f64> {
        Matrix2::new(1.0 + y[0], 0.5, y[1], 2.0)
    }

    fn missing(&self, theta: &Vector2<f64>) -> Vector3<f64> {
        Vector3::new(0.0, theta[0], theta[1])
    }

    fn is_open(&self, entry: usize) -> bool {
        entry > 0
    }

    fn lower_bound(&self, parameter: usize) -> Option<f64> {
        self.bound.filter(|_| parameter == 1)
    }
}

/// theta_hat(0), for both parameters.
const START: f64 = 0.3;

fn observer<E>(
    estimator: E,
    memory: FilterMemory,
    bound: Option<f64>,
    above: Option<f64>,
) -> KklPebObserver<Maps, E, f64>
where
    E: ParameterEstimator<f64, U2, U2>,
    DefaultAllocator: PebSize<U3, U2, U2, E::Length>,
{
    let observer = KklPebObserver::new(Maps { bound }, estimator, 1.7).unwrap().starting_at(START).unwrap();
    observer.resetting(Reset { period: 2.5, above, memory }).unwrap()
}

/// States of the observer begin with xi (3), w, F[g] (2 each), F[m] by columns (4), theta_hat (2): the rest is the
/// estimator's. `rest(slope, regressor of the slope, delta)` are the rates of the rest in the new coordinates.
fn takes_the_flow_to_itself<E>(
    estimator: E,
    numbers: &[f64],
    (u, y): (f64, Vector2<f64>),
    rest: impl Fn(&[f64], &Vector2<f64>) -> Vec<f64>,
) -> Result<(), TestCaseError>
where
    E: ParameterEstimator<f64, U2, U2>,
    DefaultAllocator: PebSize<U3, U2, U2, E::Length>,
{
    let observer = observer(estimator, FilterMemory::Transformed, None, None);
    let u = Vector1::new(u);
    let mut state = observer.initial(0.0, &Vector3::zeros(), &u, &y);
    state.iter_mut().zip(numbers).for_each(|(entry, number)| *entry = *number);
    let delta = Vector2::new(state[11] - START, state[12] - START);
    let after = observer.jump(0.0, &state, &u, &y);
    // theta_hat begins anew, and xi has what it had found.
    prop_assert_eq!([after[11], after[12]], [START; 2]);
    let before = observer.estimate(0.0, &state, &u, &y);
    // Sums and products of a few numbers below 100.
    prop_assert!((observer.estimate(0.0, &after, &u, &y) - before).amax() < 1e-12);
    let (old, new) = (observer.derivative(0.0, &state, &u, &y), observer.derivative(0.0, &after, &u, &y));
    let (old, new) = (old.as_slice(), new.as_slice());
    let mut wanted = old.to_vec();
    for i in 0..2 {
        // F[g]+ = F[g] + F[m] delta, at a delta that is constant from there on.
        wanted[5 + i] = old[5 + i] + old[7 + i] * delta[0] + old[9 + i] * delta[1];
    }
    wanted[13..].copy_from_slice(&rest(&old[13..], &delta));
    for (k, (found, wanted)) in new.iter().zip(&wanted).enumerate() {
        // Products of up to six numbers, each below 100, and their cancellation.
        prop_assert!((found - wanted).abs() <= 1e-10 * (1.0 + wanted.abs()), "entry {k}: {found} {wanted}");
    }
    Ok(())
}

proptest! {
    /// With delta = theta_hat - theta_0 held, S: (xi, w, F[g], F[m], theta_hat, ..) -> (xi + missing(delta), w,
    /// F[g] + F[m] delta, F[m], theta_hat - delta, ..) is linear, and f(S s) = S f(s): solutions go to solutions.
    #[test]
    fn a_reset_that_transforms_the_filters_takes_the_flow_to_itself(
        numbers in prop::collection::vec(-2.0..2.0, 19), u in -1.0..1.0, y in prop::array::uniform2(-1.0..1.0)
    ) {
        let at = (u, Vector2::from(y));
        let gain = Vector2::new(0.7, 1.9);
        let gradient = Gradient::new(Matrix2::new(2.0, 0.3, 0.3, 1.0)).unwrap();
        takes_the_flow_to_itself(gradient, &numbers, at, |_, _| Vec::new())?;
        // Z - Phi delta, Phi by columns.
        let kreisselmeier = Drem::new(gain, Kreisselmeier::new(0.8).unwrap()).unwrap();
        takes_the_flow_to_itself(kreisselmeier, &numbers, at, |old, delta| {
            let row = |i: usize| old[i] - old[2 + i] * delta[0] - old[4 + i] * delta[1];
            [&[row(0), row(1)], &old[2..]].concat()
        })?;
        // Y_1 - M_1 delta.
        let filters = Drem::new(gain, LtiFilters::new(Vector1::new(1.3)).unwrap()).unwrap();
        takes_the_flow_to_itself(filters, &numbers, at, |old, delta| {
            let row = |i: usize| old[i] - old[2 + i] * delta[0] - old[4 + i] * delta[1];
            [&[row(0), row(1)], &old[2..]].concat()
        })?;
    }

    /// The other kind: xi takes over, with theta_hat held at its bound, and everything else is as at a start.
    #[test]
    fn a_reset_that_restarts_the_filters_is_a_start_with_the_same_estimate(
        numbers in prop::collection::vec(-2.0..2.0, 19), u in -1.0..1.0, y in prop::array::uniform2(-1.0..1.0)
    ) {
        let drem = Drem::new(Vector2::new(0.7, 1.9), Kreisselmeier::new(0.8).unwrap()).unwrap();
        let observer = observer(drem, FilterMemory::Restarted, Some(0.4), None);
        let (u, y) = (Vector1::new(u), Vector2::from(y));
        let mut state = observer.initial(0.0, &Vector3::zeros(), &u, &y);
        state.iter_mut().zip(&numbers).for_each(|(entry, number)| *entry = *number);
        let estimate = observer.estimate(0.0, &state, &u, &y);
        let (after, start) = (observer.jump(0.0, &state, &u, &y), observer.initial(0.0, &estimate, &u, &y));
        prop_assert!((after - start).amax() < 1e-12, "{} {}", after, start);
        prop_assert_eq!([after[11], after[12]], [START, 0.4]);
    }
}

/// With a level, the instant passes unless an integrated entry is larger in magnitude; xi1, which decays, does not
/// count.
#[test]
fn a_level_is_of_the_integrated_entries() {
    let gradient = || Gradient::new(Matrix2::identity()).unwrap();
    let observer = observer(gradient(), FilterMemory::Transformed, None, Some(4.0));
    assert_eq!(observer.jump_period(), Some(2.5));
    let (u, y) = (Vector1::zeros(), Vector2::new(0.1, 0.2));
    let mut state = observer.initial(0.0, &Vector3::zeros(), &u, &y);
    state[11] = 1.5;
    for (xi, resets) in
        [([9.0, 3.9, -3.9], false), ([0.0, 4.1, 0.0], true), ([0.0, 0.0, -4.1], true), ([-9.0, 4.0, 0.0], false)]
    {
        state.rows_mut(0, 3).copy_from_slice(&xi);
        assert_eq!(observer.jump(0.0, &state, &u, &y) != state, resets, "{xi:?}");
    }
    let plain = KklPebObserver::new(Maps { bound: None }, gradient(), 1.7).unwrap();
    assert_eq!((plain.jump_period(), plain.jump(0.0, &state, &u, &y)), (None, state));
    for (period, above) in [(0.0, None), (f64::NAN, None), (1.0, Some(-1.0))] {
        let reset = Reset { period, above, memory: FilterMemory::Restarted };
        let refused = KklPebObserver::new(Maps { bound: None }, gradient(), 1.7).unwrap().resetting(reset);
        assert!(matches!(refused.err(), Some(ObserverError::NotPositive { .. })), "{period} {above:?}");
    }
}

proptest! {
    /// A parameter with a bound: the estimate takes no value below it, at the bound its slope is not negative, and what
    /// is at the bound, or there within 1/alpha at the present slope, is reported.
    #[test]
    fn a_bounded_parameter_is_projected(
        numbers in prop::collection::vec(-2.0..2.0, 13), u in -1.0..1.0, y in prop::array::uniform2(-1.0..1.0),
        above in prop_oneof![Just(-0.4), Just(0.0), 1e-3..2.0],
    ) {
        let (bound, u, y) = (0.5, Vector1::new(u), Vector2::from(y));
        let of = |bound| {
            let gradient = Gradient::new(Matrix2::new(2.0, 0.3, 0.3, 1.0)).unwrap();
            observer(gradient, FilterMemory::Transformed, bound, None)
        };
        let (free, bounded) = (of(None), of(Some(bound)));
        let mut state = free.initial(0.0, &Vector3::zeros(), &u, &y);
        state.iter_mut().zip(&numbers).for_each(|(entry, number)| *entry = *number);
        state[12] = bound + above;
        let mut held = state;
        held[12] = held[12].max(bound);
        prop_assert_eq!(bounded.estimate(0.0, &state, &u, &y), free.estimate(0.0, &held, &u, &y));

        let rate = free.derivative(0.0, &state, &u, &y)[12];
        let mut expected = free.derivative(0.0, &state, &u, &y);
        if above <= 0.0 && rate < 0.0 {
            expected[12] = 0.0;
        }
        prop_assert_eq!(bounded.derivative(0.0, &state, &u, &y), expected);

        let found = bounded.diagnose(0.0, &state, &u, &y);
        if above <= 0.0 {
            prop_assert_eq!(found, Diagnosis::LeftDomain { parameter: 1, value: state[12], bound });
        } else if rate < 0.0 && above / -rate < (1.0 - 1e-9) / 1.7 {
            let leaves = matches!(found, Diagnosis::LeavingDomain { parameter: 1, time, .. } if time > 0.0 && time <= 1.0 / 1.7);
            prop_assert!(leaves, "{found:?}");
        } else if rate >= 0.0 || above / -rate > (1.0 + 1e-9) / 1.7 {
            prop_assert_eq!(found, Diagnosis::Sound);
        }
        prop_assert_eq!(free.diagnose(0.0, &state, &u, &y), Diagnosis::Sound);
    }
}
