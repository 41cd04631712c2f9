//! The empirical observability Gramian against Lyapunov's equation, the variational equation and closed forms.

use approx::assert_abs_diff_eq;
use luenberger_linalg::lyapunov;
use luenberger_plants::{Plant, StateSpace, VanDerPol, plant, state_jacobian};
use luenberger_sim::{GramianSettings, Settings, SimError, empirical_gramian, solve};
use nalgebra::{DMatrix, SVector, Vector2, dmatrix};
use proptest::prelude::*;

/// Plants that stay where they are.
struct Product;
struct Cubes;

plant!(Product, (2, 0, 1), |plant, t, x, u| [T::zero(); 2], [x[0] * x[1]]);
plant!(Cubes, (2, 0, 1), |plant, t, x, u| [T::zero(); 2], [x[0].powi(3) + x[1]]);

fn from(x0: &[f64], plant: &StateSpace, end: f64, settings: &GramianSettings) -> luenberger_sim::EmpiricalGramian {
    empirical_gramian(plant, x0, |t, u| u.fill(t.sin()), (0.0, end), settings).unwrap()
}

fn unit(n: usize) -> GramianSettings {
    GramianSettings { scales: Some(vec![1.0; n]), ..GramianSettings::default() }
}

/// `A = -I - M M' + K`, `K' = -K`: every motion decays at least like `e^-t`.
fn stable() -> impl Strategy<Value = (DMatrix<f64>, DMatrix<f64>)> {
    (1usize..=3).prop_flat_map(|n| {
        let entry = || prop::collection::vec(-1.0..1.0f64, n * n);
        (entry(), entry(), prop::collection::vec(-1.0..1.0f64, 2 * n)).prop_map(move |(m, k, c)| {
            let (m, k) = (DMatrix::from_vec(n, n, m), DMatrix::from_vec(n, n, k));
            (-DMatrix::identity(n, n) - &m * m.transpose() + &k - k.transpose(), DMatrix::from_vec(2, n, c))
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Over a long horizon the Gramian of a stable linear plant solves `A'P + P A + C'C = 0`, whatever the input, the
    /// state and the step; in scales S it is S P S.
    #[test]
    fn the_gramian_of_a_stable_linear_plant_is_that_of_lyapunov(
        (a, c) in stable(), x0 in prop::collection::vec(-5.0..5.0f64, 3), step in 1e-3..1.0f64,
        scales in prop::collection::vec(-3i32..=3, 3),
    ) {
        let n = a.nrows();
        let p = lyapunov(&a, &(c.transpose() * &c)).unwrap().p;
        let plant = StateSpace::new(a, DMatrix::from_element(n, 1, 1.0), c).unwrap();
        let s: Vec<f64> = scales[..n].iter().map(|e| 10f64.powi(*e)).collect();
        let settings = GramianSettings { scales: Some(s.clone()), perturbation: step, ..GramianSettings::default() };
        let found = from(&x0[..n], &plant, 20.0, &settings);
        let d = DMatrix::from_diagonal(&s.clone().into());
        let scaled = &d * p * &d;
        // What is cut off is e^-40 of the whole. Differences of two states up to 1e4 scales, good to 1e-11 relative,
        // over 2e-3 and more: 1e-4 at the very worst, of an entry that is the small one of a product with a large one.
        prop_assert!((&found.gramian - &scaled).norm() <= 1e-4 * scaled.norm(), "{} for {}", found.gramian, scaled);
    }
}

#[test]
fn what_no_output_sees_has_a_zero_eigenvalue() {
    // The sum of the states is seen; their difference is not.
    let a = dmatrix![-1.0, 0.5; 0.5, -1.0];
    let plant = StateSpace::new(a, dmatrix![0.0; 0.0], dmatrix![1.0, 1.0]).unwrap();
    let found = from(&[2.0, 1.0], &plant, 10.0, &unit(2));
    assert_eq!(found.rank, 1);
    assert!(found.eigenvalues[1].abs() <= found.tolerance * found.eigenvalues[0], "{:?}", found.eigenvalues);
    assert_eq!((found.condition(), found.unobservability_index()), (f64::INFINITY, f64::INFINITY));
    let v = found.weakest().unwrap();
    assert!((v[0] + v[1]).abs() < 1e-6, "{v}");
    // The sum decays like e^(-t/2): W = (1 - e^-10) [1 1; 1 1], with eigenvalues 2 (1 - e^-10) and 0.
    assert_abs_diff_eq!(found.eigenvalues[0], 2.0 * (1.0 - (-10f64).exp()), epsilon = 1e-8);
}

#[test]
fn the_gramian_does_not_depend_on_the_units_of_the_state() {
    let plant = |d: f64| {
        // x2 in units of 1/d.
        StateSpace::new(dmatrix![-1.0, 1.0 / d; -d, -2.0], dmatrix![0.0; d], dmatrix![1.0, 0.0]).unwrap()
    };
    let one = from(&[1.0, 2.0], &plant(1.0), 3.0, &GramianSettings::default());
    let other = from(&[1.0, 2e9], &plant(1e9), 3.0, &GramianSettings::default());
    assert!((&one.gramian - &other.gramian).norm() < 1e-9 * one.gramian.norm(), "{} {}", one.gramian, other.gramian);
    assert!((one.unscaled()[(1, 1)] - 1e18 * other.unscaled()[(1, 1)]).abs() < 1e-9 * one.gramian.norm());
}

#[test]
fn the_gramian_of_van_der_pol_is_that_of_its_variational_equation() {
    let plant = VanDerPol::default();
    // Phi' = Df(x) Phi, W' = (C Phi)'(C Phi), with the Jacobian by dual numbers.
    let rhs = |t: f64, z: &[f64], slope: &mut [f64]| {
        let x = Vector2::new(z[0], z[1]);
        let phi = nalgebra::Matrix2::from_column_slice(&z[2..6]);
        let u = SVector::zeros();
        slope[..2].copy_from_slice(Plant::<f64>::derivative(&plant, t, &x, &u).as_slice());
        slope[2..6].copy_from_slice((state_jacobian(&plant, t, &x, &u) * phi).as_slice());
        let row = phi.row(0);
        slope[6..].copy_from_slice((row.transpose() * row).as_slice());
    };
    let start = [1.0, 2.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
    let exact = solve(rhs, 0.0, 5.0, &start, &Settings::default()).unwrap().at(5.0).unwrap();
    let exact = DMatrix::from_column_slice(2, 2, &exact[6..]);
    for eps in [1e-2, 1e-3] {
        let settings = GramianSettings { perturbation: eps, ..unit(2) };
        let found = empirical_gramian(&plant, &[1.0, 2.0], |_, _| {}, (0.0, 5.0), &settings).unwrap();
        // The truncation error goes with eps^2 times the third derivatives of the solution by its start, some tens
        // here.
        assert!((&found.gramian - &exact).norm() <= 100.0 * eps * eps * exact.norm(), "{} {exact}", found.gramian);
        assert_eq!(found.rank, 2);
    }
}

#[test]
fn where_the_output_is_stationary_the_step_decides() {
    let of = |x0: [f64; 2], eps: f64| {
        let settings = GramianSettings { perturbation: eps, ..unit(2) };
        empirical_gramian(&Product, &x0, |_, _| {}, (0.0, 2.0), &settings).unwrap()
    };
    // y = x1 x2: in the origin a step along one state changes nothing; at (1, 1), W = 2 [1 1; 1 1].
    assert_eq!((of([0.0, 0.0], 0.1).rank, of([0.0, 0.0], 0.1).gramian.norm()), (0, 0.0));
    let found = of([1.0, 1.0], 0.1);
    assert_eq!(found.rank, 1);
    assert!((&found.gramian - DMatrix::from_element(2, 2, 2.0)).norm() < 1e-9, "{}", found.gramian);
    // y = x1^3 + x2 at 0: the linearisation does not see x1, a step of eps does, W_11 = 2 eps^4.
    let settings = GramianSettings { perturbation: 0.1, ..unit(2) };
    let found = empirical_gramian(&Cubes, &[0.0, 0.0], |_, _| {}, (0.0, 2.0), &settings).unwrap();
    assert_abs_diff_eq!(found.gramian[(0, 0)], 2e-4, epsilon = 1e-12);
}

/// `x' = -x`, `y = (x1, 2 x2)` over T = 1: W = (1 - e^-2)/2 diag(1, 4).
#[test]
fn the_condition_of_a_gramian_of_full_rank() {
    let plant =
        StateSpace::new(-DMatrix::<f64>::identity(2, 2), dmatrix![0.0; 0.0], dmatrix![1.0, 0.0; 0.0, 2.0]).unwrap();
    let found = from(&[1.0, 1.0], &plant, 1.0, &unit(2));
    let weight = (1.0 - (-2f64).exp()) / 2.0;
    assert_eq!(found.rank, 2);
    assert!((found.condition() - 4.0).abs() < 1e-6, "{}", found.condition());
    assert!((found.unobservability_index() * weight - 1.0).abs() < 1e-6, "{}", found.unobservability_index());
    let v = found.weakest().unwrap();
    assert!((v[0].abs() - 1.0).abs() < 1e-6 && v[1].abs() < 1e-6, "{v}");
}

/// `x' = 0`, `y = x1 x2` from (3, 5) in the scales (2, 10) and of the output 4: the derivatives of y by the scaled
/// states are (10, 30)/4, so that over T = 2 `W = 2 [6.25, 18.75; 18.75, 56.25]`, whatever the step. Its eigenvectors
/// are (1, 3) and (3, -1), the directions in the units of the states (2, 30) and (6, -10), both over sqrt 10.
#[test]
fn scales_of_states_and_outputs() {
    let settings = GramianSettings::default().scales(vec![2.0, 10.0]).output_scales(vec![4.0]).perturbation(0.1);
    let found = empirical_gramian(&Product, &[3.0, 5.0], |_, _| {}, (0.0, 2.0), &settings).unwrap();
    assert!((&found.gramian - dmatrix![12.5, 37.5; 37.5, 112.5]).amax() < 1e-9, "{}", found.gramian);
    assert!((found.unscaled() - dmatrix![3.125, 1.875; 1.875, 1.125]).amax() < 1e-10, "{}", found.unscaled());
    assert!((found.eigenvalues[0] - 125.0).abs() < 1e-8 && found.rank == 1);
    let root = 10f64.sqrt();
    for (k, expected) in [[2.0, 30.0], [6.0, -10.0]].into_iter().enumerate() {
        let direction = found.directions.column(k);
        let sign = (direction[0] * expected[0]).signum();
        let off = |i: usize| (sign * direction[i] - expected[i] / root).abs();
        assert!(off(0) < 1e-8 && off(1) < 1e-8, "{direction}");
    }
    // n (100 rtol + (10 max(rtol, atol)/eps)^2): 2 (1e-9 + (1e-10/0.1)^2), and with other tolerances 2 (1e-6 + 1e-6).
    assert!((found.tolerance / 2e-9 - 1.0).abs() < 1e-8, "{:e}", found.tolerance);
    let coarse = settings.integration(Settings::default().rtol(1e-8).atol(1e-5));
    let coarse = empirical_gramian(&Product, &[3.0, 5.0], |_, _| {}, (0.0, 2.0), &coarse).unwrap();
    assert!((coarse.tolerance / 4e-6 - 1.0).abs() < 1e-8, "{:e}", coarse.tolerance);
    // Without scales they are the magnitudes of the start, and 1 for what starts at 0.
    let plain = GramianSettings::default();
    let found = empirical_gramian(&Product, &[-3.0, 0.0], |_, _| {}, (0.0, 2.0), &plain).unwrap();
    assert_eq!(found.scales, [3.0, 1.0]);
    assert!((&found.gramian - dmatrix![0.0, 0.0; 0.0, 18.0]).amax() < 1e-9, "{}", found.gramian);
}

#[test]
fn what_makes_no_sense_is_refused_with_its_numbers() {
    let plant = VanDerPol::default();
    let refused = |x0: &[f64], span: (f64, f64), settings: GramianSettings| {
        empirical_gramian(&plant, x0, |_, _| {}, span, &settings).unwrap_err()
    };
    let x0 = [1.0, 1.0];
    assert!(matches!(refused(&[1.0], (0.0, 1.0), unit(2)), SimError::Length { expected: 2, found: 1, .. }));
    assert!(matches!(refused(&[1.0, f64::NAN], (0.0, 1.0), unit(2)), SimError::NotFinite { index: 1, .. }));
    assert!(matches!(refused(&x0, (1.0, 1.0), unit(2)), SimError::TimeSpan { .. }));
    assert!(matches!(refused(&x0, (0.0, f64::NAN), unit(2)), SimError::TimeSpan { .. }));
    assert!(matches!(refused(&x0, (0.0, 1.0), unit(3)), SimError::Length { expected: 2, found: 3, .. }));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let perturbed = GramianSettings { perturbation: bad, ..unit(2) };
        assert!(matches!(refused(&x0, (0.0, 1.0), perturbed), SimError::NotPositive { .. }));
        let scaled = GramianSettings { scales: Some(vec![1.0, bad]), ..unit(2) };
        assert!(refused(&x0, (0.0, 1.0), scaled).to_string().contains("scale"));
    }
    // A start that blows up says so.
    let unstable = StateSpace::new(dmatrix![400.0], dmatrix![0.0], dmatrix![1.0]).unwrap();
    let error = empirical_gramian(&unstable, &[1.0], |_, u| u.fill(0.0), (0.0, 9.0), &unit(1)).unwrap_err();
    assert!(matches!(error, SimError::BlowUp { .. }), "{error}");
    // An input that is NaN is found by the integrator.
    let error = empirical_gramian(&unstable, &[1.0], |_, u| u.fill(f64::NAN), (0.0, 9.0), &unit(1)).unwrap_err();
    assert!(matches!(error, SimError::NotDefined { .. }), "{error}");
}
