//! Outputs that depend on the input: designs whose theory excludes them refuse them, and linear designs carry D.

use luenberger_design::kkl::{KklError, KklSettings};
use luenberger_design::mean_value::OutputCoordinates;
use luenberger_design::{
    CubicDesign, CubicGain, DesignError, KklDesign, LinearDesign, LyapunovWeight, Region, SampledCubicDesign,
};
use luenberger_observers::KklMap;
use luenberger_plants::StateSpace;
use nalgebra::{Matrix1, RealField, U1, Vector1, convert, dmatrix};

/// `x' = -x + u`, `y = x + s u`.
struct Fed(f64);

luenberger_plants::plant!(Fed, (1, 1, 1), |plant, t, x, u| u - x, x + u * convert::<f64, T>(plant.0));

/// phi = x.
#[derive(Debug)]
struct Itself;

impl<T: RealField + Copy> KklMap<T> for Itself {
    type Xi = U1;
    type Inputs = U1;
    type Outputs = U1;
    type Estimate = U1;

    fn lambda(&self, _t: T, _u: &Vector1<T>, _y: &Vector1<T>) -> Matrix1<T> {
        Matrix1::new(-T::one())
    }

    fn injection(&self, _t: T, _xi: &Vector1<T>, u: &Vector1<T>, _y: &Vector1<T>) -> Vector1<T> {
        *u
    }

    fn left_inverse(&self, _t: T, xi: &Vector1<T>, _y: &Vector1<T>) -> Vector1<T> {
        *xi
    }

    fn image(&self, _t: T, xhat: &Vector1<T>, _y: &Vector1<T>) -> Vector1<T> {
        *xhat
    }
}

#[test]
fn designs_for_outputs_of_the_state_refuse_the_input() {
    let region = Region::new(&[(-1.0, 1.0)]).inputs(&[(-1.0, 1.0)]);
    let kkl = |plant: &Fed| KklDesign::new(plant, Itself, &[0], &region, &KklSettings::default());
    assert!(kkl(&Fed(0.0)).is_ok());
    let refused = kkl(&Fed(1e-9)).unwrap_err();
    assert!(matches!(refused, KklError::Design(DesignError::Feedthrough { output: 0 })), "{refused}");
    assert_eq!(refused.to_string(), "y1 depends on the input: this observer is for y = h(t, x)");
    assert!(OutputCoordinates::of(&Fed(0.0)).is_ok());
    assert!(matches!(OutputCoordinates::of(&Fed(1e-9)), Err(DesignError::Feedthrough { output: 0 })));
}

/// D has no part in gain and certificate, and is in every observer that comes out.
#[test]
fn linear_designs_carry_d() {
    let plain = StateSpace::new(dmatrix![0.0, 1.0; -2.0, -0.5], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]).unwrap();
    let fed = plain.clone().with_feedthrough(dmatrix![0.5]).unwrap();
    let design = |plant: &StateSpace| LinearDesign::with_poles(plant, &[-4.0, -5.0]).unwrap();
    let (one, other) = (design(&plain), design(&fed));
    assert_eq!((one.l(), &one.p, one.observer.d.is_none()), (other.l(), &other.p, true));
    assert_eq!(other.observer.d, Some(dmatrix![0.5]));
    let weight = LyapunovWeight::Identity(10.0);
    let weighted = LinearDesign::with_poles_and_weight(&fed, &[-4.0, -5.0], weight).unwrap();
    let cubic = CubicDesign::new(&weighted, &dmatrix![1.0], &CubicGain::Gamma(2.0)).unwrap();
    assert_eq!((weighted.observer.d.clone(), cubic.observer.d.clone()), (fed.d.clone(), fed.d.clone()));
    let sampled = SampledCubicDesign::new(&weighted, &dmatrix![1.0], 1.0, 0.1).unwrap();
    assert_eq!(sampled.observer.d(), fed.d.as_ref());
    assert!(sampled.certificate.is_proved() && cubic.certificate.is_proved());
    let wrong = StateSpace { d: Some(dmatrix![1.0, 2.0]), ..plain };
    assert!(LinearDesign::with_poles(&wrong, &[-4.0, -5.0]).is_err());
}
