//! The right-hand sides (2) and (5): error dynamics (4) and (7) over random plants, sizes known at compile time and at
//! run time, `f32`, and data that overflow.
#![cfg(feature = "alloc")]

use luenberger_observers::{CubicObserver, LinearObserver, NonlinearLuenbergerObserver, Observer, cubic};
use luenberger_plants::{Plant, StateSpace};
use nalgebra::{DMatrix, DVector, Matrix1, Matrix2, SMatrix, SVector, Vector1, Vector2};
use proptest::prelude::*;

/// A plant, gains and a point, all of matching sizes.
#[derive(Debug, Clone)]
struct Case {
    plant: StateSpace,
    l: DMatrix<f64>,
    n: DMatrix<f64>,
    theta: DMatrix<f64>,
    x: DVector<f64>,
    xhat: DVector<f64>,
    u: DVector<f64>,
}

fn matrix(rows: usize, columns: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-3.0..3.0, rows * columns).prop_map(move |entries| DMatrix::from_vec(rows, columns, entries))
}

fn case() -> impl Strategy<Value = Case> {
    (1usize..=8, 0usize..=4, 1usize..=8).prop_flat_map(|(n, m, p)| {
        let plant = (matrix(n, n), matrix(n, m), matrix(p, n));
        let gains = (matrix(n, p), matrix(n, p), matrix(p, p));
        let point = (matrix(n, 1), matrix(n, 1), matrix(m, 1));
        (plant, gains, point).prop_map(|((a, b, c), (l, n, theta), (x, xhat, u))| Case {
            plant: StateSpace { a, b, c, d: None },
            l,
            n,
            theta,
            x: x.column(0).into_owned(),
            xhat: xhat.column(0).into_owned(),
            u: u.column(0).into_owned(),
        })
    })
}

/// Rounding in sums of products: a few ulps of the sum of magnitudes.
fn close(a: &DVector<f64>, b: &DVector<f64>, magnitude: f64) -> bool {
    (a - b).amax() <= 500.0 * f64::EPSILON * (1.0 + magnitude)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// x' - xhat' = (A - L C) e + (e'C' theta C e) N C e for every x, xhat, u: (7), and (4) when N = 0.
    #[test]
    fn the_error_obeys_its_own_equation(case in case()) {
        let Case { plant, l, n, theta, x, xhat, u } = case;
        let y = plant.output(0.0, &x, &u);
        let slope = plant.derivative(0.0, &x, &u);
        let e = &x - &xhat;
        let innovation = &plant.c * &e;
        let cubic_term = &n * &innovation * innovation.dot(&(&theta * &innovation));
        let linear_term = (&plant.a - &l * &plant.c) * &e;
        let magnitude = 3.0 * 3.0 * 24.0 * 8.0 + cubic_term.amax() + n.amax() * theta.amax() * (8.0 * 18.0f64 * 8.0).powi(3);

        let linear = LinearObserver::of(plant.clone(), l.clone()).unwrap();
        prop_assert!(close(&(&slope - linear.derivative(0.0, &xhat, &u, &y)), &linear_term, magnitude));
        let cubic = CubicObserver::of(plant.clone(), l.clone(), n, theta.clone()).unwrap();
        prop_assert!(close(&(slope - cubic.derivative(0.0, &xhat, &u, &y)), &(linear_term + cubic_term), magnitude));
        // On a linear plant the copy of the plant is the linear observer, up to the order of summation.
        let copy = NonlinearLuenbergerObserver::new(plant.clone(), l.clone()).unwrap();
        prop_assert!(close(&copy.derivative(0.0, &xhat, &u, &y), &linear.derivative(0.0, &xhat, &u, &y), magnitude));
        // With N = 0 the cubic observer is the linear one, bit for bit.
        let zero = CubicObserver::of(plant, l.clone(), l * 0.0, theta).unwrap();
        prop_assert_eq!(zero.derivative(0.0, &xhat, &u, &y), linear.derivative(0.0, &xhat, &u, &y));
        prop_assert_eq!(cubic.estimate(0.0, &cubic.initial(0.0, &xhat, &u, &y), &u, &y), xhat);
    }

    /// Sizes known at compile time and at run time give the same numbers up to the order of summation, and so does
    /// `f32`.
    #[test]
    fn static_dynamic_and_single_precision_agree(
        a in prop::array::uniform9(-3.0f64..3.0), b in prop::array::uniform6(-3.0f64..3.0),
        c in prop::array::uniform6(-3.0f64..3.0), l in prop::array::uniform6(-3.0f64..3.0),
        n in prop::array::uniform6(-3.0f64..3.0), theta in prop::array::uniform4(-3.0f64..3.0),
        point in prop::array::uniform7(-3.0f64..3.0),
    ) {
        let (xhat, u, y) = (&point[..3], &point[3..5], &point[5..]);
        let fixed = CubicObserver::new(
            SMatrix::<f64, 3, 3>::from_column_slice(&a), SMatrix::<f64, 3, 2>::from_column_slice(&b),
            SMatrix::<f64, 2, 3>::from_column_slice(&c), SMatrix::<f64, 3, 2>::from_column_slice(&l),
            SMatrix::<f64, 3, 2>::from_column_slice(&n), SMatrix::<f64, 2, 2>::from_column_slice(&theta),
        ).unwrap();
        let dynamic = CubicObserver::new(
            DMatrix::from_column_slice(3, 3, &a), DMatrix::from_column_slice(3, 2, &b),
            DMatrix::from_column_slice(2, 3, &c), DMatrix::from_column_slice(3, 2, &l),
            DMatrix::from_column_slice(3, 2, &n), DMatrix::from_column_slice(2, 2, &theta),
        ).unwrap();
        let single = CubicObserver::new(
            fixed.a.cast::<f32>(), fixed.b.cast(), fixed.c.cast(), fixed.l.cast(), fixed.n.cast(), fixed.theta.cast(),
        ).unwrap();
        let (xs, us, ys) = (
            SVector::<f64, 3>::from_column_slice(xhat), SVector::<f64, 2>::from_column_slice(u),
            SVector::<f64, 2>::from_column_slice(y),
        );
        let from_fixed = fixed.derivative(0.0, &xs, &us, &ys);
        let from_dynamic = dynamic.derivative(
            0.0, &DVector::from_column_slice(xhat), &DVector::from_column_slice(u), &DVector::from_column_slice(y),
        );
        let from_single = single.derivative(0.0, &xs.cast(), &us.cast(), &ys.cast());
        // |y~| <= 30, so the cubic term is below 2 * 3 * 30^3 * 12.
        let magnitude = 2e6;
        for i in 0..3 {
            prop_assert!((from_fixed[i] - from_dynamic[i]).abs() <= 20.0 * f64::EPSILON * magnitude);
            prop_assert!((from_fixed[i] - f64::from(from_single[i])).abs() <= 20.0 * f64::from(f32::EPSILON) * magnitude);
        }
    }

    /// Finite data never give NaN, whatever their size, and give a finite slope up to 1e150.
    #[test]
    fn huge_innovations_stay_finite(exponent in 0.0f64..150.0, sign in prop::bool::ANY, tilt in -1.0f64..1.0) {
        let y = 10f64.powf(exponent) * if sign { 1.0 } else { -1.0 };
        let observer = CubicObserver::new(
            SMatrix::<f64, 2, 2>::identity(), SMatrix::<f64, 2, 0>::zeros(), SMatrix::<f64, 2, 2>::identity(),
            SMatrix::<f64, 2, 2>::identity(), SMatrix::<f64, 2, 2>::new(-10.0, tilt, 0.0, -10.0),
            SMatrix::<f64, 2, 2>::identity() * 10.0,
        ).unwrap();
        let slope = observer.derivative(0.0, &Vector2::zeros(), &SVector::zeros(), &Vector2::new(y, tilt * y));
        prop_assert!(slope.iter().all(|entry| entry.is_finite()), "{}", slope);
        prop_assert!(slope[0] * y > 0.0);
    }
}

#[test]
fn saturation_does_not_touch_ordinary_numbers_of_single_precision() {
    let observer = CubicObserver::new(
        Matrix1::new(0.0f32),
        Matrix1::new(0.0),
        Matrix1::new(1.0),
        Matrix1::new(0.0),
        Matrix1::new(-1.0),
        Matrix1::new(1.0),
    )
    .unwrap();
    for y in [1e3f32, 1e7, 1e9, 4e9] {
        let slope = observer.derivative(0.0, &Vector1::zeros(), &Vector1::zeros(), &Vector1::new(y));
        assert!((slope[0] / (y * y * y) - 1.0).abs() < 4.0 * f32::EPSILON, "{y}: {slope}");
    }
    let slope = observer.derivative(0.0, &Vector1::zeros(), &Vector1::zeros(), &Vector1::new(1e12));
    assert!(slope[0].is_finite());
}

/// Beyond MAX^(1/4) the weight is that of the innovation shortened to it: continuous there, and the same for all that
/// lie beyond on one ray.
#[test]
fn the_weight_stops_growing_without_a_jump() {
    let (theta, ray) = (Matrix2::new(2.0, 0.5, 0.25, 1.0), Vector2::new(1.0, -0.5));
    let bound = f64::MAX.sqrt().sqrt();
    let at = |size: f64| cubic::weight(&theta, &(ray * size));
    // 2 - 0.375 + 0.25, and two roundings of the bound.
    assert!((at(bound) / (1.875 * bound * bound) - 1.0).abs() <= 4.0 * f64::EPSILON);
    for beyond in [1.0 + 1e-9, 10.0, 1e200] {
        assert!((at(bound * beyond) / at(bound) - 1.0).abs() <= 4.0 * f64::EPSILON, "{beyond}");
    }
}

#[test]
fn bad_matrices_are_errors_that_name_them() {
    let plant = luenberger_plants::double_integrator().to_dynamic();
    let error = LinearObserver::of(plant.clone(), DMatrix::zeros(1, 2)).unwrap_err();
    assert_eq!(error.to_string(), "L must be 2 x 1, found 1 x 2");
    let nan = DMatrix::from_element(2, 1, f64::NAN);
    let (gain, theta) = (DMatrix::zeros(2, 1), DMatrix::identity(1, 1));
    let error = CubicObserver::of(plant.clone(), gain.clone(), nan, theta).unwrap_err();
    assert_eq!(error.to_string(), "N(1, 1) is NaN, not a finite number");
    let error = CubicObserver::of(plant, gain.clone(), gain, DMatrix::identity(2, 2)).unwrap_err();
    assert_eq!(error.to_string(), "theta must be 1 x 1, found 2 x 2");
}
