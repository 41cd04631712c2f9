//! The numerical KKL observer for held inputs, on a linear plant, whose T(x, u) = T0 x + T1 u is known:
//! T0 A - D T0 = B C and T0 E = D T1 for x' = A x + E u.

use std::ops::ControlFlow::{Break, Continue};

use luenberger_design::numerical_kkl::{
    Domain, Escape, HeldInputDesign, NumericalKklError, Progress, Settings, TargetSystem,
};
use luenberger_observers::Observer;
use luenberger_plants::StaticPlant;
use nalgebra::{DMatrix, Matrix1x2, Matrix2, SMatrix, Vector1, Vector2};

const FAMILY: [(f64, f64); 2] = [(-1.0, 1.0), (0.0, 3.0)];

fn plant() -> StaticPlant<f64, 2, 2, 1> {
    let (a, e, c) = (Matrix2::new(0.0, 1.0, -2.0, -0.3), Matrix2::new(1.0, 0.5, 0.0, 1.0), Matrix1x2::new(1.0, 0.0));
    StaticPlant::new(a, e, c).unwrap()
}

fn settings() -> Settings<2> {
    Settings {
        points: [9; 2],
        leaves: 4,
        degree: 2,
        samples: 1000,
        injectivity_points: 5,
        held_out: 60,
        ..Settings::default()
    }
}

fn design(
    family: &[(f64, f64); 2],
    nodes: usize,
    settings: &Settings<2>,
    progress: &mut dyn FnMut(Progress) -> std::ops::ControlFlow<()>,
) -> Result<HeldInputDesign<2, 2, 1, 3, 5>, NumericalKklError> {
    let target = TargetSystem::<1, 3>::bessel(3.0).unwrap();
    let domain = Domain::new([-1.0, -2.0], [1.0, 2.0], Escape::Free).unwrap();
    HeldInputDesign::new(&plant(), &target, &domain, (family, nodes), settings, progress)
}

/// T is affine in u: two nodes per input are exact, at inputs between them and in the right order of the two inputs.
#[test]
fn an_affine_transformation_takes_two_nodes() {
    let design = design(&FAMILY, 2, &settings(), &mut |_| Continue(())).unwrap();
    let target = TargetSystem::<1, 3>::bessel(3.0).unwrap();
    let (d, b) = (target.d(), target.b());
    let (a, e, c) = (Matrix2::new(0.0, 1.0, -2.0, -0.3), Matrix2::new(1.0, 0.5, 0.0, 1.0), Matrix1x2::new(1.0, 0.0));
    // vec(T0 A - D T0) = (A' (x) I - I (x) D) vec(T0).
    let dynamic = |rows, columns, m: &[f64]| DMatrix::from_column_slice(rows, columns, m);
    let (da, dd) = (dynamic(2, 2, a.as_slice()), dynamic(3, 3, d.as_slice()));
    let operator = da.transpose().kronecker(&DMatrix::identity(3, 3)) - DMatrix::identity(2, 2).kronecker(&dd);
    let right = dynamic(6, 1, (b * c).as_slice());
    let t0 = SMatrix::<f64, 3, 2>::from_column_slice(operator.lu().solve(&right).unwrap().as_slice());
    let t1 = d.try_inverse().unwrap() * t0 * e;
    let y = Vector1::zeros();
    for (x, u) in [
        (Vector2::new(0.3, -1.2), Vector2::new(0.4, 1.1)),
        (Vector2::new(-0.9, 1.9), Vector2::new(-1.0, 3.0)),
        (Vector2::new(0.0, 0.5), Vector2::new(0.9, 0.2)),
    ] {
        let z = t0 * x + t1 * u;
        // T by simulation to 1e-11 of y, of which the backward growth e^{0.15 s} costs little; the spline of a linear
        // map is exact.
        assert!((design.observer.initial(0.0, &x, &u, &y) - z).norm() < 1e-8, "{x} {u}");
        assert!((design.observer.estimate(0.0, &z, &u, &y) - x).norm() < 1e-6, "{x} {u}");
        let small = design.observer.clone().embedded();
        // A linear map, fitted by polynomials with a ridge of 1e-8.
        assert!((small.estimate(0.0, &z, &u, &y) - x).norm() < 1e-3, "{x} {u}");
        assert_eq!(small.derivative(0.0, &z, &u, &Vector1::new(0.7)), d * z + b * 0.7);
    }
    assert_eq!(design.report.tables, 4);
    assert!(design.report.interpolated.max.amax() < 1e-6, "{:?}", design.report);
    assert!(design.report.spline.1 < 1e-8 && design.report.smallest_ratio > 0.0, "{:?}", design.report);
    assert!(design.to_string().contains("inputs with a table            4\n"), "{design}");
    // Outside of the family an input is taken at its nearest end, and so is one that is not a number at the lower one.
    let (x, inside) = (Vector2::new(0.1, 0.2), Vector2::new(1.0, 0.0));
    let at = |u: Vector2<f64>| design.observer.initial(0.0, &x, &u, &y);
    assert_eq!(at(Vector2::new(7.0, -2.0)), at(inside));
    assert_eq!(at(Vector2::new(7.0, f64::NAN)), at(inside));
}

#[test]
fn families_that_cannot_be_are_named() {
    let mut on = |_| Continue(());
    let refused =
        |family: [(f64, f64); 2], nodes| design(&family, nodes, &settings(), &mut |_| Continue(())).unwrap_err();
    let error = refused([(-1.0, 1.0), (3.0, 3.0)], 2);
    assert!(error.to_string().contains("the family of input 2 goes from 3 to 3"), "{error}");
    assert!(refused(FAMILY, 1).to_string().contains("the number of nodes"));
    assert!(refused(FAMILY, 34).to_string().contains("the number of nodes"));
    let large = Settings { points: [400; 2], ..settings() };
    let error = design(&FAMILY, 6, &large, &mut on).unwrap_err();
    // 36 tables of 402^2 coefficients; 341^2 * 36 is below 2^22 = 4194304, 342^2 * 36 is not.
    let NumericalKklError::GridTooLarge { points, per_axis, .. } = error else { panic!("{error}") };
    assert_eq!((points, per_axis), (36.0 * 402.0 * 402.0, 339));
    let mut calls = 0;
    let mut stop = |_| {
        calls += 1;
        if calls < 100 { Continue(()) } else { Break(()) }
    };
    let stopped = design(&FAMILY, 2, &settings(), &mut stop).unwrap_err();
    assert!(
        matches!(stopped, NumericalKklError::Stopped { stage: "T on the grid", done: 100, total: 324 }),
        "{stopped}"
    );
}
