//! Jacobians by dual numbers against the derivatives on paper, the edges of f included.

#![cfg(feature = "dual")]

use luenberger_plants::jacobian::Differentiable;
use luenberger_plants::{Chaotic, Plant, double_integrator, flexible_joint, state_jacobian};
use nalgebra::{Matrix2x3, Matrix3, SMatrix, SVector, Vector1, Vector2, Vector3, Vector4};

/// d/dx ln(0.1 + exp d) is exp(d)/(0.1 + exp(d)) times (-1, 1, 0), on both branches and far out on either side.
#[test]
fn the_chaotic_plant_has_the_jacobian_on_paper() {
    for (x1, x2, x3) in
        [(-2.0, -1.0, -1.0), (1.0, 1.0, 0.3), (0.0, 1.0 - 1e-9, 2.0), (0.0, 1.0 + 1e-9, 2.0), (5.0, -3.0, 0.1)]
    {
        let x = Vector3::new(x1, x2, x3);
        let s = 1.0 / (1.0 + 0.1 * f64::exp(x1 - x2));
        let expected = Matrix3::new(-s, s, 0.0, x3, 0.0, x1, -x2, -x1, 0.0);
        let jacobian = state_jacobian(&Chaotic, 0.0, &x, &SVector::zeros());
        // A handful of operations of condition at most |d| <= 8.
        assert!((jacobian - expected).amax() <= 32.0 * f64::EPSILON, "{x}{jacobian}");
        let c = Chaotic.output_jacobian(0.0, &x, &SVector::zeros());
        assert_eq!(c, Matrix2x3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0));
    }
}

#[test]
fn the_chaotic_plant_does_not_overflow() {
    let x = Vector3::new(-500.0, 500.0, 0.0);
    let slope: Vector3<f64> = Chaotic.derivative(0.0, &x, &SVector::zeros());
    assert_eq!(slope[0], 1000.0);
    let jacobian = state_jacobian(&Chaotic, 0.0, &x, &SVector::zeros());
    assert_eq!((jacobian[(0, 0)], jacobian[(0, 1)]), (-1.0, 1.0));
    // On the other side ln 0.1 is left, and nothing of the slope.
    let jacobian = state_jacobian(&Chaotic, 0.0, &-x, &SVector::zeros());
    assert_eq!((jacobian[(0, 0)], jacobian[(0, 1)]), (0.0, 0.0));
}

#[test]
fn the_flexible_joint_has_the_jacobian_on_paper() {
    let x = Vector4::new(3.0, -1.0, 0.7, 2.0);
    let mut expected = flexible_joint::classical().linear_part();
    expected[(3, 2)] -= 3.33 * 0.7f64.cos();
    let u = Vector1::new(0.4);
    assert!((state_jacobian(&flexible_joint::classical(), 0.0, &x, &u) - expected).amax() <= 8.0 * f64::EPSILON * 48.6);
    expected[(3, 3)] = 3.33;
    let printed = flexible_joint::printed();
    assert!((state_jacobian(&printed, 0.0, &x, &u) - expected).amax() <= 8.0 * f64::EPSILON * 48.6);
    assert_eq!(printed.output_jacobian(0.0, &x, &u), SMatrix::<f64, 3, 4>::identity());
    assert_eq!(flexible_joint::classical().output_jacobian(0.0, &x, &u), SMatrix::<f64, 2, 4>::identity());
}

/// a44 = 3.33 alone moves the linearisation at the origin across the imaginary axis: its trace is the sum of the
/// eigenvalues.
#[test]
fn the_printed_joint_is_unstable() {
    assert!(flexible_joint::printed().linear_part().trace() > 2.0);
    assert!(flexible_joint::classical().linear_part().trace() < -1.0);
}

/// A linear plant is its own derivative, at run-time sizes too; and single precision has Jacobians as well.
#[test]
fn linear_plants_and_single_precision() {
    let plant = double_integrator();
    assert_eq!(plant.state_jacobian(0.0, &Vector2::new(3.0, 4.0), &Vector1::new(1.0)), plant.a);
    let dynamic = plant.to_dynamic();
    let x = nalgebra::DVector::zeros(2);
    assert_eq!(dynamic.state_jacobian(0.0, &x, &nalgebra::DVector::zeros(1)), dynamic.a);
    assert_eq!(dynamic.output_jacobian(0.0, &x, &nalgebra::DVector::zeros(1)), dynamic.c);
    let x = Vector3::new(1.0f32, 2.0, 3.0);
    let single = state_jacobian(&Chaotic, 0.0, &x, &SVector::zeros());
    let double = state_jacobian(&Chaotic, 0.0, &x.cast::<f64>(), &SVector::zeros());
    assert!((single.cast::<f64>() - double).amax() <= 16.0 * f64::from(f32::EPSILON));
}
