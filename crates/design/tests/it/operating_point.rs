//! Operating points against scipy's `fsolve` (1.17.1), and what has none.

use luenberger_design::{OperatingPointError, operating_point};
use luenberger_plants::{ByDual, Dimensions, Plant, Shape, StateSpace};
use nalgebra::{DVector, RealField, Vector1, Vector2, convert, dmatrix, dvector};

fn number<T: RealField>(x: f64) -> T {
    convert(x)
}

plant!(
    /// The stirred reactor of Seborg, Edgar and Mellichamp, Process Dynamics and Control, 2nd ed. 2004, table 2.3: c in
    /// mol/l, T in K, the coolant's temperature as input.
    Reactor,
    (2, 1, 1),
    |_plant, _t, x, u| {
        let rate = number::<T>(7.2e10) * (-number::<T>(8750.0) / x[1]).exp() * x[0];
        let heat = number::<T>(5e4 / 239.0) * rate + number::<T>(5e4 / 239.0 / 100.0) * (u[0] - x[1]);
        [number::<T>(1.0) - x[0] - rate, number::<T>(350.0) - x[1] + heat]
    },
    [x[1] + number::<T>(0.01) * u[0]]
);
plant!(
    /// `x' = x^2 + u`: two operating points, one, or none.
    Fold,
    (2, 1, 1),
    |_plant, _t, x, u| [x[0] * x[0] + u[0], x[0] - x[1]],
    [x[0]]
);
plant!(
    /// A pendulum on a cart: the position is nowhere in f.
    Cart,
    (2, 1, 1),
    |_plant, _t, x, u| [x[1], u[0] - x[1]],
    [x[0]]
);

#[test]
fn a_reactor_at_its_unstable_point() {
    let point = operating_point(&Reactor, &Vector2::new(0.6, 345.0), &Vector1::new(300.0)).unwrap();
    let expected = [0.499_918_285_958_655_5, 350.005_528_690_212_77];
    for (found, expected) in point.x.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-13, "{}", point.x);
    }
    assert!(point.residual < 1e-10 && point.steps < 10, "{point:?}");
    // numpy, with the derivatives written out.
    let a = dmatrix![-2.000_326_909_591_587, -0.035_718_993_969_741_3; 209.273_412_048_449_16, 4.380_542_671_493_995];
    assert!((&point.linear.a - &a).amax() < 1e-10 * a.amax(), "{}", point.linear.a);
    assert!((point.linear.b[(1, 0)] - 2.092_050_209_205_021).abs() < 1e-14 && point.linear.b[(0, 0)] == 0.0);
    assert_eq!((point.linear.c.clone(), point.linear.d.clone()), (dmatrix![0.0, 1.0], Some(dmatrix![0.01])));
    assert!((point.y[0] - point.x[1] - 3.0).abs() < 1e-13);
    let mut poles: Vec<f64> = point.poles.iter().map(|pole| pole.re).collect();
    poles.sort_by(f64::total_cmp);
    for (found, expected) in poles.iter().zip([-0.454_227_367_628_014_6, 2.834_443_129_530_422]) {
        assert!((found - expected).abs() < 1e-11, "{found}, expected {expected}");
    }
    // From far away damping finds the way, in Kelvin or not.
    let far = operating_point(&Reactor, &Vector2::new(0.9, 330.0), &Vector1::new(300.0)).unwrap();
    assert!(far.residual < 1e-10);
}

/// A linear plant over every scalar, as that of a study.
struct Spring(StateSpace);

impl ByDual for Spring {}

impl Shape for Spring {
    fn dimensions(&self) -> Dimensions {
        self.0.dimensions()
    }
}

impl<T: RealField + Copy> Plant<T> for Spring {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;
    fn derivative(&self, _t: T, x: &DVector<T>, u: &DVector<T>) -> DVector<T> {
        self.0.a.map(number::<T>) * x + self.0.b.map(number::<T>) * u
    }
    fn output(&self, _t: T, x: &DVector<T>, _u: &DVector<T>) -> DVector<T> {
        self.0.c.map(number::<T>) * x
    }
}

#[test]
fn a_linear_plant_has_the_point_of_its_equations() {
    let plant = StateSpace::new(dmatrix![0.0, 1.0; -2.0, -3.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]).unwrap();
    let point = operating_point(&Spring(plant.clone()), &dvector![0.0, 0.0], &dvector![4.0]).unwrap();
    assert!((point.x - dvector![2.0, 0.0]).amax() < 1e-15 && point.steps <= 2);
    assert_eq!(point.linear, plant);
}

#[test]
fn what_has_no_point_says_where_it_stopped() {
    let at = |guess: f64, u: f64| operating_point(&Fold, &Vector2::new(guess, 0.0), &Vector1::new(u));
    assert!((at(3.0, -4.0).unwrap().x[0] - 2.0).abs() < 1e-14);
    assert!((at(-3.0, -4.0).unwrap().x[0] + 2.0).abs() < 1e-14);
    let none = at(3.0, 1.0).unwrap_err();
    assert!(matches!(none, OperatingPointError::NotConverged { .. } | OperatingPointError::Singular { .. }), "{none}");
    // At the fold the Jacobian is singular.
    assert!(matches!(at(0.0, -4.0), Err(OperatingPointError::Singular { .. })));
    let cart = |guess: Vector2<f64>, u: f64| operating_point(&Cart, &guess, &Vector1::new(u));
    // Anywhere on the rail it rests; under a force nowhere.
    let rest = cart(Vector2::new(7.0, 0.0), 0.0).unwrap();
    assert_eq!((rest.x.as_slice(), rest.steps, rest.residual), (&[7.0, 0.0][..], 0, 0.0));
    let error = cart(Vector2::new(7.0, 0.0), 1.0).unwrap_err().to_string();
    assert!(error.contains("df/dx is singular at the state [7, 0]"), "{error}");
    let reactor = operating_point(&Reactor, &Vector2::new(0.5, 0.0), &Vector1::new(300.0));
    assert!(reactor.is_err());
    assert!(operating_point(&Fold, &Vector2::new(f64::NAN, 0.0), &Vector1::new(0.0)).is_err());
}
