//! The theorems of parameter estimation, as algebra at random states and as runs.
#![cfg(feature = "alloc")]

use luenberger_observers::ObserverError;
use luenberger_observers::estimator::ParameterEstimator;
use luenberger_observers::estimator::drem::{Drem, Kreisselmeier, LtiFilters};
use luenberger_observers::estimator::excitation::{Monitored, least_eigenvalue};
use luenberger_observers::estimator::gradient::Gradient;
use luenberger_observers::filters::Filter;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, OMatrix, OVector, SMatrix, SVector, U2, Vector1, Vector2, Vector3};
use proptest::prelude::*;

fn vector<const N: usize>(size: f64) -> impl Strategy<Value = SVector<f64, N>> {
    prop::collection::vec(-size..size, N).prop_map(|entries| SVector::from_column_slice(&entries))
}

fn matrix<const R: usize, const C: usize>(size: f64) -> impl Strategy<Value = SMatrix<f64, R, C>> {
    prop::collection::vec(-size..size, R * C).prop_map(|entries| SMatrix::from_column_slice(&entries))
}

/// Checks `theta_hat_i' = -gamma_i Delta^2 theta~_i`, which makes every |theta~_i| decrease: `delta` is the
/// determinant, and `size` bounds the terms of which `v = adj(Phi) Z` is the sum.
fn assert_monotone(rate: &[f64], error: &[f64], gain: &[f64], delta: f64, size: f64) -> Result<(), TestCaseError> {
    for i in 0..error.len() {
        let claimed = -gain[i] * delta * delta * error[i];
        // v - Delta theta_hat: sums of products of q^2 numbers, and the adjugate's own rounding, in front of gamma
        // Delta.
        let rounding = 1024.0 * f64::EPSILON * gain[i] * delta.abs() * size;
        prop_assert!((rate[i] - claimed).abs() <= rounding, "{i}: {} {claimed} {rounding:e}", rate[i]);
        // No entry moves away from its parameter by more than rounding.
        prop_assert!(rate[i] * error[i] <= rounding * error[i].abs());
    }
    Ok(())
}

proptest! {
    /// DREM with filters on a scalar regression of three parameters: the square case.
    #[test]
    fn drem_with_filters_moves_every_parameter_the_right_way(
        theta in vector::<3>(2.0), guess in vector::<3>(5.0), rows in matrix::<3, 3>(1.0), gain in vector::<3>(1.0),
    ) {
        let gain = gain.map(|g| g.abs() + 0.1);
        let estimator = Drem::new(gain, LtiFilters::new(Vector2::new(1.0, 3.0)).unwrap()).unwrap();
        // Now, and as the two filters remember: consistent with theta.
        let values = rows * theta;
        let mut state = guess.as_slice().to_vec();
        for k in 1..3 {
            state.push(values[k]);
            state.extend(rows.row(k).iter());
        }
        let m = rows.row(0).into_owned();
        let mut rate = vec![0.0; state.len()];
        estimator.rate(&state, &Vector1::new(values[0]), &m, &mut rate);
        // Each filter of Y and of M moves at its own rate: beta (present - past).
        for (k, beta) in [1.0, 3.0].into_iter().enumerate() {
            let past = values[k + 1];
            prop_assert!((rate[3 + 4 * k] - beta * (values[0] - past)).abs() <= 4.0 * f64::EPSILON * beta * 12.0);
            for j in 0..3 {
                prop_assert_eq!(rate[4 + 4 * k + j], (m[j] - rows[(k + 1, j)]) * beta);
            }
        }
        let delta = rows.determinant();
        prop_assert!((estimator.excitation(&state, &m).unwrap() - delta.abs()).abs() <= 64.0 * f64::EPSILON * 6.0);
        // |adj| <= 2 per entry, |Z| <= 6, |Delta| <= 6, |theta_hat| <= 5.
        assert_monotone(&rate[..3], (guess - theta).as_slice(), gain.as_slice(), delta, 36.0)?;
    }

    /// DREM by Kreisselmeier's regressor: three parameters, two rows at a time.
    #[test]
    fn drem_by_kreisselmeier_moves_every_parameter_the_right_way(
        theta in vector::<3>(2.0), guess in vector::<3>(5.0), past in matrix::<5, 3>(1.0), m in matrix::<2, 3>(1.0),
    ) {
        let estimator = Drem::new(Vector3::repeat(1.0), Kreisselmeier::new(0.7).unwrap()).unwrap();
        let phi: Matrix3<f64> = past.transpose() * past;
        let mut state = guess.as_slice().to_vec();
        state.extend((phi * theta).iter().chain(phi.iter()));
        let mut rate = vec![0.0; state.len()];
        estimator.rate(&state, &(m * theta), &m, &mut rate);
        // Entries of Phi up to 5, of the adjugate up to 50, of Z up to 30.
        assert_monotone(&rate[..3], (guess - theta).as_slice(), &[1.0; 3], phi.determinant(), 3.0 * 50.0 * 30.0)?;
        // Phi' = -a Phi + M'M, and the extension keeps Z = Phi theta.
        let (z_rate, phi_rate) = rate[3..].split_at(3);
        let deviation = Matrix3::from_column_slice(phi_rate) - (m.transpose() * m - phi * 0.7);
        prop_assert!(deviation.amax() <= 16.0 * f64::EPSILON * 6.0, "{deviation}");
        let expected = Matrix3::from_column_slice(phi_rate) * theta;
        prop_assert!((Vector3::from_column_slice(z_rate) - expected).amax() <= 64.0 * f64::EPSILON * 60.0);
    }

    /// More equations than parameters: the normal equations, whose determinant is the sum of the squares of the minors.
    #[test]
    fn drem_with_too_many_filters_uses_them_all(
        theta in vector::<2>(2.0), guess in vector::<2>(5.0), rows in matrix::<4, 2>(1.0),
    ) {
        let estimator = Drem::new(Vector2::repeat(1.0), LtiFilters::new(Vector1::new(2.0)).unwrap()).unwrap();
        let values = rows * theta;
        let (m, remembered) = (rows.fixed_rows::<2>(0).into_owned(), rows.fixed_rows::<2>(2).into_owned());
        let mut state = guess.as_slice().to_vec();
        state.extend(values.iter().skip(2).chain(remembered.iter()));
        let mut rate = vec![0.0; state.len()];
        estimator.rate(&state, &Vector2::new(values[0], values[1]), &m, &mut rate);
        let mut minors = 0.0;
        for i in 0..4 {
            for j in 0..i {
                minors += (rows[(i, 0)] * rows[(j, 1)] - rows[(i, 1)] * rows[(j, 0)]).powi(2);
            }
        }
        assert_monotone(&rate[..2], (guess - theta).as_slice(), &[1.0; 2], minors, 4.0 * 4.0 * 16.0)?;
    }

    /// The gradient estimator: `theta~' Gamma^-1 theta~` changes at the rate `-2 |M theta~|^2`, for any number of rows
    /// and any Gamma.
    #[test]
    fn the_gradient_never_increases_its_energy(
        theta in vector::<3>(2.0), guess in vector::<3>(5.0), m in matrix::<2, 3>(1.0), root in matrix::<3, 3>(1.0),
    ) {
        let gain = root * root.transpose() + Matrix3::identity();
        let estimator = Gradient::new(gain).unwrap();
        let mut rate = [0.0; 3];
        estimator.rate(guess.as_slice(), &(m * theta), &m, &mut rate);
        let error = guess - theta;
        let change = 2.0 * error.dot(&(gain.try_inverse().unwrap() * Vector3::from(rate)));
        let claimed = -2.0 * (m * error).norm_squared();
        // The condition of Gamma is at most 10, |rate| at most 10 * 2 * 21.
        prop_assert!((change - claimed).abs() <= 256.0 * f64::EPSILON * 10.0 * 420.0 * 7.0, "{change} {claimed}");
    }

    /// The bound is below the smallest eigenvalue, and not by more than the means allow: equal for order 1, at least
    /// half of it for order 2.
    #[test]
    fn the_measure_of_excitation_is_a_bound(m in matrix::<4, 3>(1.0)) {
        let gram: Matrix3<f64> = m.transpose() * m;
        let smallest = gram.symmetric_eigenvalues().min();
        prop_assert!(least_eigenvalue(&gram) <= smallest + 64.0 * f64::EPSILON * gram.trace());
        let two: Matrix2<f64> = gram.fixed_view::<2, 2>(0, 0).into_owned();
        let (bound, smallest) = (least_eigenvalue(&two), two.symmetric_eigenvalues().min());
        prop_assert!(bound <= smallest + 64.0 * f64::EPSILON * two.trace());
        prop_assert!(bound >= 0.5 * smallest - 64.0 * f64::EPSILON * two.trace());
        // Equality of the means, for diag(a, b, b): a b^2 (2/(a + 2 b))^2.
        let (a, b) = (m[(0, 0)].abs() + 0.1, m[(1, 1)].abs() + 0.1);
        let exact = a * (2.0 * b / (a + 2.0 * b)).powi(2);
        prop_assert!((least_eigenvalue(&Matrix3::from_diagonal(&Vector3::new(a, b, b))) / exact - 1.0).abs() <= 32.0 * f64::EPSILON);
        let one = gram.fixed_view::<1, 1>(0, 0).into_owned();
        prop_assert!((least_eigenvalue(&one) - one[0]).abs() <= 4.0 * f64::EPSILON * one[0]);
        // Of rank 1.
        let row = m.row(0).into_owned();
        prop_assert!(least_eigenvalue(&(row.transpose() * row)) <= 64.0 * f64::EPSILON * gram.trace());
    }
}

/// One run by the classical Runge-Kutta method.
fn integrate<E, const Q: usize>(
    estimator: &E,
    theta: SVector<f64, Q>,
    m: impl Fn(f64) -> SMatrix<f64, 1, Q>,
    (end, steps): (f64, usize),
    mut look: impl FnMut(f64, &[f64]),
) -> Vec<f64>
where
    E: ParameterEstimator<f64, nalgebra::Const<1>, nalgebra::Const<Q>>,
{
    let mut state = vec![0.0; estimator.state_len(1)];
    let h = end / steps as f64;
    let slope = |t: f64, state: &[f64]| {
        let (m, mut rate) = (m(t), vec![0.0; state.len()]);
        estimator.rate(state, &(m * theta), &m, &mut rate);
        rate
    };
    let shifted = |state: &[f64], rate: &[f64], by: f64| -> Vec<f64> {
        state.iter().zip(rate).map(|(s, r)| s + r * by).collect()
    };
    for k in 0..steps {
        let t = k as f64 * h;
        look(t, &state);
        let k1 = slope(t, &state);
        let k2 = slope(t + h / 2.0, &shifted(&state, &k1, h / 2.0));
        let k3 = slope(t + h / 2.0, &shifted(&state, &k2, h / 2.0));
        let k4 = slope(t + h, &shifted(&state, &k3, h));
        for (i, state) in state.iter_mut().enumerate() {
            *state += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
    }
    state
}

/// Along a run, from zero: each entry of DREM's error decreases, with both extensions, while an entry of the gradient's
/// overshoots.
#[test]
fn along_a_run_drem_is_monotone_and_the_gradient_is_not() {
    let theta = Vector2::new(1.0, 3.0);
    let m = |t: f64| SMatrix::<f64, 1, 2>::new(1.0, 0.2 + (1.5 * t).sin().powi(2));
    let filters = Drem::new(Vector2::repeat(50.0), LtiFilters::new(Vector1::new(0.5)).unwrap()).unwrap();
    let gram = Drem::new(Vector2::repeat(50.0), Kreisselmeier::new(0.5).unwrap()).unwrap();
    let gradient = Gradient::new(Matrix2::identity() * 2.0).unwrap();

    let mut previous = [1.0, 3.0];
    // Runge-Kutta with h = 0.005: local errors of h^5, far below what is asked for.
    let mut monotone = |_: f64, state: &[f64]| {
        for i in 0..2 {
            let error = (state[i] - theta[i]).abs();
            assert!(error <= previous[i] + 1e-9, "{error} {}", previous[i]);
            previous[i] = error;
        }
    };
    let last = integrate(&filters, theta, m, (30.0, 6000), &mut monotone);
    assert!((last[0] - 1.0).abs() < 1e-3 && (last[1] - 3.0).abs() < 1e-2, "{last:?}");
    previous = [1.0, 3.0];
    let mut monotone = |_: f64, state: &[f64]| {
        for i in 0..2 {
            let error = (state[i] - theta[i]).abs();
            assert!(error <= previous[i] + 1e-9, "{error} {}", previous[i]);
            previous[i] = error;
        }
    };
    let last = integrate(&gram, theta, m, (30.0, 6000), &mut monotone);
    assert!((last[0] - 1.0).abs() < 1e-3 && (last[1] - 3.0).abs() < 1e-2, "{last:?}");

    let mut overshoot = 0.0f64;
    integrate(&gradient, theta, m, (30.0, 6000), |_, state| overshoot = overshoot.max(state[0] - 1.0));
    assert!(overshoot > 0.3, "{overshoot}");
}

/// M = (1, exp(-t)): M is not persistently exciting and the gradient stops short; the monitor says how little was seen.
#[test]
fn a_regression_that_dies_out_is_reported() {
    let theta = Vector2::new(1.0, -1.0);
    let m = |t: f64| SMatrix::<f64, 1, 2>::new(1.0, (-t).exp());
    let estimator = Monitored::new(Gradient::new(Matrix2::identity()).unwrap(), 0.0).unwrap();
    let last = integrate(&estimator, theta, m, (40.0, 8000), |_, _| {});
    // theta_2 had one unit of time to be learned in.
    assert!((last[1] + 1.0).abs() > 0.5, "{last:?}");
    // The Gramian is (t, 1; 1, 1/2) to e^-40: smallest eigenvalue 0.47 at t = 40, and forgetting would take it to 0.
    let exact: f64 = Matrix2::new(40.0, 1.0, 1.0, 0.5).symmetric_eigenvalues().min();
    let said = ParameterEstimator::<f64, nalgebra::Const<1>, U2>::excitation(&estimator, &last, &m(40.0)).unwrap();
    assert!(said <= exact && said >= 0.5 * exact, "{said} {exact}");
    let forgetful = Monitored::new(Gradient::new(Matrix2::identity()).unwrap(), 1.0).unwrap();
    let last = integrate(&forgetful, theta, m, (40.0, 8000), |_, _| {});
    let said = ParameterEstimator::<f64, nalgebra::Const<1>, U2>::excitation(&forgetful, &last, &m(40.0)).unwrap();
    assert!(said < 1e-12, "{said}");
}

/// Sizes known at run time: five parameters, two rows, the same code.
#[test]
fn estimators_of_dynamic_size_are_the_same() {
    let theta = DVector::from_fn(5, |i, _| 1.0 + i as f64);
    let m = DMatrix::from_fn(2, 5, |i, j| ((1 + i + 3 * j) as f64).sin());
    let y: DVector<f64> = &m * &theta;
    let gradient = Gradient::new(DMatrix::identity(5, 5)).unwrap();
    let mut rate = vec![0.0; 5];
    gradient.rate(&[0.0; 5], &y, &m, &mut rate);
    let expected: DVector<f64> = m.transpose() * &y;
    assert!((DVector::from_vec(rate) - expected).amax() <= 64.0 * f64::EPSILON * 50.0);

    let drem = Drem::new(DVector::repeat(5, 1.0), Kreisselmeier::new(1.0).unwrap()).unwrap();
    let past = DMatrix::from_fn(6, 5, |i, j| (((i + 1) * (j + 2)) as f64).cos());
    let phi: DMatrix<f64> = past.transpose() * &past;
    let mut state = vec![0.0; 5];
    state.extend((&phi * &theta).iter().chain(phi.iter()));
    assert_eq!(state.len(), ParameterEstimator::<f64, nalgebra::Dyn, nalgebra::Dyn>::state_len(&drem, 2));
    let mut rate = vec![0.0; state.len()];
    drem.rate(&state, &y, &m, &mut rate);
    let delta = phi.determinant();
    for i in 0..5 {
        // Condition 1e4 at most for this Phi, checked by the relative error itself.
        assert!((rate[i] / (delta * delta * theta[i]) - 1.0).abs() < 1e-9, "{i}: {}", rate[i]);
    }
}

#[test]
fn bad_numbers_are_refused() {
    let refused = |error: ObserverError| error.to_string();
    assert_eq!(
        refused(Filter::new(f64::NAN).unwrap_err()),
        "the filter's alpha is NaN; it must be positive and finite"
    );
    assert!(matches!(Gradient::new(Matrix2::new(1.0, 2.0, 2.0, 1.0)), Err(ObserverError::NotDefinite { .. })));
    assert!(matches!(Gradient::new(Matrix2::new(1.0, 2.0, 0.0, 1.0)), Err(ObserverError::NotSymmetric { .. })));
    assert!(matches!(
        Gradient::new(OMatrix::<f64, _, _>::from_element_generic(U2, U2, f64::INFINITY)),
        Err(ObserverError::Matrix(_))
    ));
    assert!(matches!(Kreisselmeier::new(-1.0), Err(ObserverError::NotPositive { value, .. }) if value == -1.0));
    assert!(matches!(LtiFilters::new(DVector::<f64>::zeros(0)), Err(ObserverError::Matrix(_))));
    assert!(matches!(LtiFilters::new(Vector2::new(1.0, 0.0)), Err(ObserverError::NotPositive { .. })));
    assert!(Drem::new(Vector1::new(f64::NAN), Kreisselmeier::new(1.0).unwrap()).is_err());
    assert!(Monitored::new(Gradient::new(Matrix2::<f64>::identity()).unwrap(), -0.5).is_err());
}

/// Numbers at the end of the range: no NaN, a parameter whose rate overflows stands still.
#[test]
fn nothing_overflows_to_nan() {
    let huge = f64::MAX / 4.0;
    let (y, m) = (Vector1::new(huge), SMatrix::<f64, 1, 2>::new(huge, -huge));
    let gradient = Gradient::new(Matrix2::identity()).unwrap();
    let mut rate = [f64::NAN; 2];
    gradient.rate(&[huge, huge], &y, &m, &mut rate);
    assert!(rate.iter().all(|rate| rate.is_finite()), "{rate:?}");
    let drem = Drem::new(Vector2::repeat(1.0), Kreisselmeier::new(1.0).unwrap()).unwrap();
    let mut rate = [f64::NAN; 8];
    drem.rate(&[huge; 8], &y, &m, &mut rate);
    assert!(rate.iter().all(|rate| rate.is_finite()), "{rate:?}");
    let ones: OVector<f64, U2> = OVector::repeat_generic(U2, nalgebra::U1, 1.0);
    let filters = Drem::new(ones, LtiFilters::new(Vector1::new(huge)).unwrap()).unwrap();
    let mut rate = [f64::NAN; 5];
    filters.rate(&[-huge; 5], &y, &m, &mut rate);
    assert!(rate.iter().all(|rate| rate.is_finite()), "{rate:?}");
}
