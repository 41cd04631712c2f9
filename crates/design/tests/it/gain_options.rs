//! Bounds of the gain and the least noise gain, against closed forms and against designs for the rate alone.

use luenberger_design::{DesignError, GainOptions, LinearDesign, LipschitzDesign, LipschitzPlant, LpvDesign, Region};
use luenberger_linalg::lyapunov;
use luenberger_plants::{StateSpace, flexible_joint};
use nalgebra::{DMatrix, dmatrix};

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// `x' = a x`, `y = x`: with the gain l the noise of intensity 1 leaves the variance `l^2 / (2 (l - a))`.
fn scalar(a: f64) -> Result<StateSpace, Box<dyn std::error::Error>> {
    Ok(StateSpace::new(dmatrix![a], DMatrix::zeros(1, 0), dmatrix![1.0])?)
}

/// The trace of X in `F X + X F' + L L' = 0`.
fn variance(f: &DMatrix<f64>, l: &DMatrix<f64>) -> Result<f64, Box<dyn std::error::Error>> {
    Ok(lyapunov(&f.transpose(), &(l * l.transpose()))?.p.trace())
}

#[test]
fn the_least_noise_gain_of_one_state_is_that_of_the_closed_form() -> Outcome {
    let quiet = GainOptions::default().noise(dmatrix![1.0]);
    // Without a rate the minimum is at l = 2 a. A rate r needs l >= a + r, and for r > a it binds.
    for (a, rate, expected) in [(1.0, 0.0, 2.0), (3.0, 0.0, 6.0), (1.0, 3.0, 4.0), (-1.0, 2.0, 1.0)] {
        let design = LinearDesign::lmi_with(&scalar(a)?, rate, &quiet)?;
        let l = design.l()[(0, 0)];
        assert!((l / expected - 1.0).abs() < 0.02, "a = {a}, rate {rate}: l = {l}");
        assert!(design.certificate.is_proved());
    }
    Ok(())
}

#[test]
fn the_noise_gain_falls_and_the_rate_stays() -> Outcome {
    let plant = luenberger_plants::double_integrator().to_dynamic();
    let quiet = LinearDesign::lmi_with(&plant, 1.0, &GainOptions::default().noise(dmatrix![1.0]))?;
    let plain = LinearDesign::with_decay_rate(&plant, 1.0)?;
    let noise = |design: &LinearDesign| variance(&design.error_matrix(), design.l());
    assert!(quiet.certificate.is_proved() && quiet.rate == 1.0);
    assert!(noise(&quiet)? < 0.9 * noise(&plain)?, "{} and {}", noise(&quiet)?, noise(&plain)?);
    // The optimum of the same program by cvxpy 1.9 with Clarabel: L = [2.0001, 1.6181], variance 2.0591. One P for the
    // rate and the covariance costs: L = [2, 1], with both poles at -1, has the variance 1.5.
    let l = quiet.l();
    assert!((l[(0, 0)] - 2.0001).abs() < 2e-3 && (l[(1, 0)] - 1.6181).abs() < 2e-3, "L = {l}");
    assert!((noise(&quiet)? - 2.0591).abs() < 2e-3);
    Ok(())
}

#[test]
fn a_bound_of_the_gain_holds_or_is_refused_with_a_proof() -> Outcome {
    let plant = luenberger_plants::double_integrator().to_dynamic();
    for bound in [8.0, 20.0] {
        let design = LinearDesign::lmi_with(&plant, 1.0, &GainOptions::default().max_gain(bound))?;
        let norm = design.l().clone().svd(false, false).singular_values.max();
        assert!(norm <= bound && design.certificate.is_proved(), "|L| = {norm}, bound {bound}");
    }
    // Two poles with real parts of at most -1 need l1 >= 2, l2 >= 1.
    let error = LinearDesign::lmi_with(&plant, 1.0, &GainOptions::default().max_gain(1.0)).err().ok_or("an error")?;
    assert!(matches!(error, DesignError::Infeasible { .. }), "{error}");
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = LinearDesign::lmi_with(&plant, 1.0, &GainOptions::default().max_gain(bad)).err();
        assert!(matches!(error, Some(DesignError::NotPositive { .. })), "{bad}: {error:?}");
    }
    let error = LinearDesign::lmi_with(&plant, 1.0, &GainOptions::default().noise(dmatrix![-1.0])).err();
    assert!(error.ok_or("an error")?.to_string().contains('V'));
    Ok(())
}

#[test]
fn polytopes_and_sectors_take_the_same_options() -> Outcome {
    let plant = flexible_joint::classical();
    let region = Region::everywhere(4);
    let noise = DMatrix::identity(2, 2);
    let worst = |design: &LpvDesign<_, _, _, _>| -> Result<f64, Box<dyn std::error::Error>> {
        let l = DMatrix::from_fn(4, 2, |i, j| design.l()[(i, j)]);
        let traces = design.polytope.vertices.iter().map(|vertex| variance(&(&vertex.a - &l * &vertex.c), &l));
        Ok(traces.collect::<Result<Vec<_>, _>>()?.into_iter().fold(0.0, f64::max))
    };
    let plain = LpvDesign::new(plant, &region, 1.0)?;
    let quiet = LpvDesign::new_with(plant, &region, 1.0, &GainOptions::default().noise(noise.clone()))?;
    assert!(quiet.certificate.is_proved());
    // P^-1 bounds the covariance at every vertex.
    let bound = quiet.p.clone().cholesky().ok_or("P > 0")?.inverse().trace();
    assert!(worst(&quiet)? <= bound * (1.0 + 1e-9) && worst(&quiet)? < worst(&plain)?);
    let bounded = LpvDesign::new_with(plant, &region, 1.0, &GainOptions::default().max_gain(60.0))?;
    assert!((*bounded.l()).svd(false, false).singular_values.max() <= 60.0);

    let sine = luenberger_design::Sector::structured(dmatrix![0.0; 1.0], dmatrix![1.0, 0.0], 0.5);
    let pendulum = LipschitzPlant::new(dmatrix![0.0, 1.0; -1.0, 0.0], dmatrix![1.0, 0.0], vec![sine])?;
    let plain = LipschitzDesign::new(&pendulum, 0.5)?;
    let options = GainOptions::default().noise(dmatrix![1.0]);
    let quiet = LipschitzDesign::new_with(&pendulum, None, 0.5, &options)?;
    let centre = |design: &LipschitzDesign| variance(&(pendulum.centre() - &design.l * pendulum.c()), &design.l);
    assert!(quiet.certificate.is_proved() && centre(&quiet)? < centre(&plain)?);
    let bounded = LipschitzDesign::new_with(&pendulum, None, 0.5, &GainOptions::default().max_gain(5.0))?;
    assert!(bounded.certificate.is_proved() && bounded.l.norm() <= 5.0);
    Ok(())
}
