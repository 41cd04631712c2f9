//! One constant gain for a nonlinear plant in discrete time.

use luenberger_design::{DesignError, DiscreteLpvDesign, GainOptions, LpvError, Region};
use luenberger_lmi::Settings;
use luenberger_observers::SampledObserver;
use luenberger_plants::Plant;
use nalgebra::{RealField, SVector, Vector1, Vector2, convert, dmatrix};

fn number<T: RealField>(x: f64) -> T {
    convert(x)
}

// A pendulum by Euler's method.
plant!(
    Pendulum {},
    2,
    1,
    |s, x| Vector2::new(x[0] + number::<T>(0.1) * x[1], x[1] - number::<T>(0.981) * x[0].sin()),
    Vector1::new(x[0])
);

// x+ = a x with a between 1/2 and 7/10.
plant!(
    Scalar {},
    1,
    1,
    |s, x| Vector1::new(number::<T>(0.6) * x[0] + number::<T>(0.1) * x[0].sin()),
    Vector1::new(x[0])
);

// The second state grows, and is not seen.
plant!(
    Blind {},
    2,
    1,
    |s, x| Vector2::new(number::<T>(0.5) * x[0] + number::<T>(0.1) * x[0].sin(), number::<T>(1.1) * x[1]),
    Vector1::new(x[0])
);

fn half() -> Region {
    Region::new(&[(-0.5, 0.5), (-5.0, 5.0)])
}

fn inside(x: &Vector2<f64>) -> bool {
    half().states().iter().zip(x.iter()).all(|((low, high), x)| (low..=high).contains(&x))
}

/// x+ = a x with a in [1/2, 7/10] and y = x: the best gain is 6/10, with the factor 1/10.
#[test]
fn the_fastest_gain_of_a_scalar_plant() {
    let region = Region::new(&[(-4.0, 4.0)]);
    let design = DiscreteLpvDesign::max_rate(Scalar {}, 0.5, &region, (20.0, 1e-3), &GainOptions::default()).unwrap();
    assert!((design.factor - 0.1).abs() < 1e-3 && design.factor > 0.1, "{}", design.factor);
    assert!((design.l()[(0, 0)] - 0.6).abs() < 1e-3);
    assert!((design.rate + design.factor.ln() / 0.5).abs() < 1e-12);
    assert!(design.certificate.is_proved() && design.stopped.is_some());
}

/// The least common factor of two vertices for a given gain: 0.554898674, by minimising the largest of the two norms
/// over P with scipy 1.17.1 (Nelder-Mead from twenty starts).
#[test]
fn the_greatest_rate_of_a_given_gain() {
    let design = DiscreteLpvDesign::certify(Pendulum {}, 0.1, &half(), &dmatrix![1.0; 2.0], &Settings::default());
    let design = design.unwrap();
    assert_eq!(design.polytope.vertices.len(), 2);
    assert!(design.factor >= 0.554_898 && design.factor < 0.555_5, "{}", design.factor);
    let largest = design.vertex_factors.iter().copied().fold(0.0, f64::max);
    assert!(largest <= design.factor && largest > 0.99 * design.factor);
}

/// The bound holds along every run that stays in the box.
#[test]
fn errors_obey_the_bound() {
    let design = DiscreteLpvDesign::new(Pendulum {}, 0.1, &half(), 2.0, &GainOptions::default()).unwrap();
    let text = design.to_string();
    assert!(text.starts_with("L = [") && text.contains(design.sentence().unwrap().as_str()), "{text}");
    assert!(text.contains("Proved     P > 0"), "{text}");
    let largest = design.vertex_factors.iter().copied().fold(0.0, f64::max);
    assert!(text.contains(&format!(" limits the factor, to {largest:.6}: df2/dx1 = ")), "{text}");
    assert!(design.certificate.is_proved());
    assert_eq!(design.factor, (-0.2f64).exp());
    let (u, mut compared) = (SVector::<f64, 0>::zeros(), 0);
    for k in 0..40 {
        let angle = f64::from(k);
        let mut x = Vector2::new(0.15 * angle.cos(), 0.4 * angle.sin());
        let mut xhat = Vector2::new(0.1 * (2.0 * angle).sin(), 0.3 * (3.0 * angle).cos());
        let first = (x - xhat).norm();
        for step in 0..30 {
            if !inside(&x) || !inside(&xhat) {
                break;
            }
            let bound = design.overshoot * first * design.factor.powi(step);
            assert!((x - xhat).norm() <= bound * (1.0 + 1e-12), "{k} {step}");
            compared += 1;
            let y = Vector1::new(x[0]);
            design.observer.step(0.0, &mut xhat, &u, &y);
            x = Plant::<f64>::derivative(&Pendulum {}, 0.0, &x, &u);
        }
    }
    assert!(compared > 400, "{compared}");
}

/// Limits of the gain, and the least noise gain: the covariance of the noise is at most P^-1 at every vertex.
#[test]
fn limits_of_the_gain() {
    let of = |options: &GainOptions| DiscreteLpvDesign::new(Pendulum {}, 0.1, &half(), 0.5, options).unwrap();
    let bounded = of(&GainOptions::default().max_gain(1.5));
    assert!(bounded.certificate.is_proved() && bounded.l().norm() < 1.5);
    let quiet = of(&GainOptions::default().noise(dmatrix![0.01]));
    let (l, p) = (quiet.l(), &quiet.p);
    let inverse = p.clone().try_inverse().unwrap();
    for vertex in &quiet.polytope.vertices {
        let f = &vertex.a - l * &vertex.c;
        let next = &f * &inverse * f.transpose() + l * 0.01 * l.transpose();
        assert!((&inverse - next).symmetric_eigenvalues().min() > -1e-9 * inverse.norm());
    }
    assert!(
        inverse.trace() < of(&GainOptions::default().noise(dmatrix![1.0])).p.clone().try_inverse().unwrap().trace()
    );
}

#[test]
fn what_is_impossible_is_said() {
    let region = Region::new(&[(-1.0, 1.0), (-1.0, 1.0)]);
    let error = DiscreteLpvDesign::new(Blind {}, 0.1, &region, 0.0, &GainOptions::default()).unwrap_err();
    assert!(matches!(error, LpvError::Conflict(_)), "{error}");
    assert!(error.to_string().starts_with("LMI infeasible at decay rate 0; "), "{error}");
    let unstable = DiscreteLpvDesign::certify(Pendulum {}, 0.1, &half(), &dmatrix![0.0; 0.0], &Settings::default());
    assert!(matches!(unstable, Err(LpvError::Design(DesignError::NotSchur { .. }))));
    let period = DiscreteLpvDesign::new(Pendulum {}, 0.0, &half(), 0.0, &GainOptions::default());
    assert!(matches!(period, Err(LpvError::Design(DesignError::NotPositive { .. }))));
}
