//! The mean-value-theorem observer: means along a segment, right-hand sides, bad data.

#![cfg(feature = "dual")]

use luenberger_observers::mean_value::beta::mean_value;
use luenberger_observers::mean_value::integral::gauss_legendre;
use luenberger_observers::{
    Beta, EstimateAndError, Integral, MappedObserver, Mean, MeanValueObserver, Observer, ObserverError,
};
use luenberger_plants::coordinates::InCoordinates;
use luenberger_plants::{Chaotic, Column, Differentiable, Plant, PlantError, double_integrator, flexible_joint, plant};
use nalgebra::{
    Const, DVector, Matrix2, Matrix4x2, SMatrix, SVector, Vector1, Vector2, Vector3, Vector4, convert, vector,
};
use proptest::prelude::*;

/// `x' = f(x)`, y = x, for the functions on which a root finder can fail.
#[derive(Clone, Copy, Debug)]
enum Scalar {
    Cube,
    /// sin(40 x): up to six roots in [0, 1] for e = 1.
    Wave,
    /// sqrt(x): not defined for x < 0.
    Root,
}

plant!(
    Scalar,
    (1, 0, 1),
    |plant, t, x, u| [match plant {
        Scalar::Cube => x[0] * x[0] * x[0],
        Scalar::Wave => (x[0] * convert::<f64, T>(40.0)).sin(),
        Scalar::Root => x[0].sqrt(),
    }],
    *x
);

fn vector3(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

fn vector4(size: f64) -> impl Strategy<Value = Vector4<f64>> {
    prop::array::uniform4(-size..size).prop_map(Vector4::from)
}

/// Both means that run on the target.
fn both<S, const N: usize, const M: usize, const P: usize>()
-> [&'static dyn Mean<S, f64, Const<N>, Const<M>, Const<P>>; 2]
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
{
    [&Beta, &Integral]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// The mean value theorem: beta in [0, 1] for every row, and D e = f(xhat + e) - f(xhat) to rounding.
    #[test]
    fn beta_exists_and_is_found(xhat in vector3(3.0), e in vector3(3.0)) {
        let u = SVector::zeros();
        let mean = mean_value(&Chaotic, 0.0, &xhat, &u, &e);
        prop_assert!(mean.beta.iter().all(|beta| (0.0..=1.0).contains(beta)));
        let rise: Vector3<f64> = Chaotic.derivative(0.0, &(xhat + e), &u) - Chaotic.derivative(0.0, &xhat, &u);
        // |f| and |Df e| are below 40 here, and beta is a root to 16 roundings of them.
        prop_assert!((mean.jacobian * e - rise).amax() <= 640.0 * f64::EPSILON, "{mean:?}");
        // Rows 2 and 3 are quadratic along the segment: their mean value is taken in the middle, and nowhere else.
        prop_assert_eq!((mean.beta[1], mean.beta[2]), (0.5, 0.5));
    }

    #[test]
    fn beta_exists_for_the_flexible_joint(xhat in vector4(4.0), e in vector4(4.0), u in -1.0f64..1.0) {
        let plant = flexible_joint::printed();
        let mean = mean_value(&plant, 0.0, &xhat, &Vector1::new(u), &e);
        prop_assert!(mean.beta.iter().all(|beta| (0.0..=1.0).contains(beta)));
        // |f| <= 48.6 * 8 * 2 + 40 < 900.
        prop_assert!(mean.residual.amax() <= 16.0 * 900.0 * f64::EPSILON, "{mean:?}");
    }

    /// As printed: z = xhat + e obeys z' = f(z) + [G_m; 0] (y - C z), and the unmeasured rows of z are the plant's own.
    /// With output injection: z' = f(z) + L (y - C z), whatever G is.
    #[test]
    fn what_the_observer_believes(xhat in vector4(2.0), e in vector4(2.0), y in prop::array::uniform2(-2.0f64..2.0), eta in 0.6f64..3.0) {
        let (plant, y, u) = (flexible_joint::classical(), Vector2::from(y), vector![0.3]);
        let l = Matrix4x2::from_fn(|i, j| 1.0 + i as f64 - 2.0 * j as f64);
        let state = EstimateAndError::new(&xhat, &e);
        let z = state.second_estimate();
        let surprise = y - z.fixed_rows::<2>(0);
        let f: Vector4<f64> = plant.derivative(0.0, &z, &u);
        // f is below 500, G below 3 * 300, times surprises of 8, in a few roundings.
        let rounding = 64.0 * f64::EPSILON * 8000.0;
        for mean in both() {
            let printed = MeanValueObserver::new(plant, eta, mean, e).unwrap();
            let moved = printed.derivative(0.0, &state, &u, &y).second_estimate() - f;
            prop_assert!(moved.fixed_rows::<2>(2).amax() <= rounding, "{moved}");
            for k in 0..2 {
                // G_m is positive: the injection pulls towards the measurement.
                prop_assert!(moved[k] * surprise[k] >= -rounding);
            }
            // (5): xhat' = f(xhat) + G (y - C xhat; e), the measured rows by what is measured, the others by e.
            let d = mean.mean(&plant, 0.0, &xhat, &u, &e).jacobian;
            let own: Vector4<f64> = plant.derivative(0.0, &xhat, &u);
            let corrected = printed.derivative(0.0, &state, &u, &y).estimate() - own;
            for k in 0..4 {
                let alpha: f64 = d.row(k).iter().chain(d.column(k).iter()).map(|entry| entry.abs()).sum();
                let by = if k < 2 { y[k] - xhat[k] } else { e[k] };
                prop_assert!((corrected[k] - eta * alpha * by).abs() <= rounding, "row {k}: {corrected}");
            }
            let injected = MeanValueObserver::with_output_injection(plant, eta, mean, e, l).unwrap();
            let moved = injected.derivative(0.0, &state, &u, &y).second_estimate() - f;
            prop_assert!((moved - l * surprise).amax() <= rounding, "{moved}");
        }
    }

    /// In coordinates x = T z the observer of z is the observer of x: it starts from the given estimate, which moves
    /// by T z'.
    #[test]
    fn a_mapped_observer_estimates_in_the_coordinates_of_its_plant(turn in prop::array::uniform4(-1.0f64..1.0), xhat in prop::array::uniform2(-2.0f64..2.0)) {
        // y = x1 is z1 for a T of this form; it is no involution.
        let matrix = Matrix2::new(1.0, 0.0, turn[0], 2.0 + turn[1]);
        let other = InCoordinates::measured_first(double_integrator(), matrix).unwrap();
        let observer = MeanValueObserver::new(other.clone(), 1.0, Integral, Vector2::new(turn[2], turn[3])).unwrap();
        let mapped = MappedObserver::new(&other, observer);
        let (xhat, u, y) = (Vector2::from(xhat), Vector1::new(0.5), Vector1::new(0.25));
        let state = mapped.initial(0.0, &xhat, &u, &y);
        let rounding = 64.0 * f64::EPSILON * 4.0;
        prop_assert!((state.estimate() - matrix.try_inverse().unwrap() * xhat).amax() <= rounding);
        prop_assert!((mapped.estimate(0.0, &state, &u, &y) - xhat).amax() <= rounding);
    }

    /// Along the printed observer the internal error falls at least as fast as the theorem says; the factor 1/2 is what
    /// the proof of the paper drops.
    #[test]
    fn the_internal_error_falls(xhat in vector3(3.0), e in vector3(3.0), eta in 0.500001f64..2.0) {
        let (u, y) = (SVector::zeros(), Vector2::zeros());
        for mean in both() {
            let observer = MeanValueObserver::new(Chaotic, eta, mean, e).unwrap();
            let slope = observer.derivative(0.0, &EstimateAndError::new(&xhat, &e), &u, &y).error();
            prop_assert!(slope.dot(&e) <= 1e4 * f64::EPSILON * e.norm_squared(), "{slope}");
        }
    }
}

/// x^3 from 0 to 1: 3 beta^2 = 1.
#[test]
fn a_root_is_found_to_the_last_digits() {
    let mean = mean_value(&Scalar::Cube, 0.0_f64, &vector![0.0], &SVector::zeros(), &vector![1.0]);
    assert!((mean.beta[0] - 1.0 / 3f64.sqrt()).abs() <= 4.0 * f64::EPSILON, "{mean:?}");
}

#[test]
fn many_roots_and_none() {
    // A wave of six half-periods along the segment: some root, to rounding.
    let u = SVector::zeros();
    let mean = mean_value(&Scalar::Wave, 0.0_f64, &vector![0.1], &u, &vector![0.5]);
    assert!((0.0..=1.0).contains(&mean.beta[0]) && mean.residual[0].abs() <= 40.0 * 16.0 * f64::EPSILON, "{mean:?}");
    // Not finite at one end: beta stays defined, and the residual tells.
    let mean = mean_value(&Scalar::Root, 0.0_f64, &vector![0.25], &u, &vector![-1.0]);
    assert!((0.0..=1.0).contains(&mean.beta[0]) && mean.residual[0].is_nan(), "{mean:?}");
}

/// e = 0 is an ordinary segment: both means are Df(xhat), and the observer is a copy with output injection.
#[test]
fn no_internal_error_is_an_ordinary_case() {
    let (xhat, u) = (Vector3::new(0.3, -1.0, 2.0), SVector::zeros());
    let here = luenberger_plants::state_jacobian(&Chaotic, 0.0, &xhat, &u);
    assert_eq!(mean_value(&Chaotic, 0.0, &xhat, &u, &Vector3::zeros()).jacobian, here);
    let mean = gauss_legendre(&Chaotic, 0.0, &xhat, &u, &Vector3::zeros());
    assert!((mean - here).amax() <= 8.0 * f64::EPSILON * 2.0);
}

/// The same code at run-time sizes: the double integrator is linear, so D = A, alpha = (1, 1).
#[test]
fn sizes_known_at_run_time() {
    let plant = double_integrator().to_dynamic();
    let e = DVector::from_vec(vec![1.0, 2.0]);
    let observer = MeanValueObserver::new(plant, 2.0, Beta, e).unwrap();
    let (u, y) = (DVector::from_vec(vec![0.5]), DVector::from_vec(vec![4.0]));
    let state = observer.initial(0.0, &DVector::from_vec(vec![3.0, -1.0]), &u, &y);
    assert_eq!(state.as_slice(), [3.0, -1.0, 1.0, 2.0]);
    // xhat' = A xhat + B u + 2 (y - xhat1, e2); e' = A e - 2 e.
    assert_eq!(observer.derivative(0.0, &state, &u, &y).as_slice(), [-1.0 + 2.0, 0.5 + 4.0, 2.0 - 2.0, -4.0]);
    assert!(EstimateAndError::<f64, Const<2>>::try_from_slice(&[0.0; 3]).is_none());
    assert!(EstimateAndError::<f64, nalgebra::Dyn>::try_from_slice(&[0.0; 3]).is_none());
}

#[test]
fn single_precision_follows_double() {
    let (xhat, e) = (Vector3::new(-1.0, -0.5, -1.5), Vector3::new(-1.0, -0.5, 0.5));
    let y = Vector2::new(-2.0, -1.0);
    let double = MeanValueObserver::new(Chaotic, 1.0, Integral, e).unwrap();
    let single = MeanValueObserver::new(Chaotic, 1.0f32, Integral, e.cast()).unwrap();
    let slope = double.derivative(0.0, &EstimateAndError::new(&xhat, &e), &SVector::zeros(), &y);
    let slope32 =
        single.derivative(0.0, &EstimateAndError::new(&xhat.cast::<f32>(), &e.cast()), &SVector::zeros(), &y.cast());
    assert!((slope.estimate() - slope32.estimate().cast()).amax() <= 100.0 * f64::from(f32::EPSILON));
}

#[test]
fn bad_data_are_errors() {
    let e = Vector3::new(1.0, 0.0, 0.0);
    for eta in [0.5, 0.0, -1.0, f64::INFINITY] {
        assert_eq!(MeanValueObserver::new(Chaotic, eta, Beta, e).unwrap_err(), ObserverError::Eta { eta },);
    }
    assert!(matches!(MeanValueObserver::new(Chaotic, f64::NAN, Beta, e), Err(ObserverError::Eta { .. })));
    let message = MeanValueObserver::new(Chaotic, 0.5, Beta, e).unwrap_err().to_string();
    assert!(message.contains("what is lost is the decrease of the internal error"), "{message}");
    assert!(matches!(
        MeanValueObserver::new(Chaotic, 1.0, Beta, e * f64::NAN),
        Err(ObserverError::Matrix(PlantError::NotFinite { what: "e(0)", .. }))
    ));
    let l = SMatrix::<f64, 3, 2>::repeat(f64::INFINITY);
    assert!(matches!(
        MeanValueObserver::with_output_injection(Chaotic, 1.0, Beta, e, l),
        Err(ObserverError::Matrix(PlantError::NotFinite { what: "L", .. }))
    ));
    // y = 2 x1 is not x1.
    let mut plant = double_integrator();
    plant.c *= 2.0;
    assert!(matches!(
        MeanValueObserver::new(plant, 1.0, Beta, Vector2::zeros()),
        Err(ObserverError::OutputNotState { output: 0, expected: 2.0, found: 4.0 })
    ));
    // Lengths that are known at run time only.
    let dynamic = double_integrator().to_dynamic();
    assert!(matches!(
        MeanValueObserver::new(dynamic, 1.0, Beta, DVector::zeros(3)),
        Err(ObserverError::Matrix(PlantError::DimensionMismatch { what: "e(0)", .. }))
    ));
}
