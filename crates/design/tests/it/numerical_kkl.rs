//! T against closed forms, as a property over random linear plants, and what is refused.

use approx::assert_abs_diff_eq;
use std::ops::ControlFlow::{Break, Continue};
use std::sync::Arc;

use luenberger_design::DesignError;
use luenberger_design::numerical_kkl::{
    Domain, Escape, Inequality, NumericalKklDesign, NumericalKklError, Progress, Settings, TargetSystem, Transform,
    Trial, held_out,
};
use luenberger_linalg::{LinalgError, eigenvalues, sylvester};
use luenberger_observers::Observer;
use luenberger_plants::StaticPlant;
use nalgebra::{Complex, DMatrix, Matrix2, Matrix3, RowVector2, SMatrix, SVector, Vector1};
use proptest::prelude::*;

/// `x' = -x^power` with y = x or, if `even`, y = x^2.
#[derive(Clone, Copy, Debug)]
struct Power {
    power: i32,
    even: bool,
}

luenberger_plants::plant!(
    Power,
    (1, 0, 1),
    |plant, t, x, u| -x.map(|x| x.powi(plant.power)),
    if plant.even { x.map(|x| x * x) } else { *x }
);

fn line(escape: Escape) -> Domain<1> {
    Domain::new([-1.0], [1.0], escape).unwrap()
}

fn small<const N: usize>() -> Settings<N> {
    Settings {
        points: [17; N],
        degree: 3,
        leaves: 4,
        samples: 500,
        injectivity_points: 9,
        held_out: 100,
        ..Settings::default()
    }
}

/// x' = -x, y = x, D = -lambda, B = lambda: T = lambda x / (lambda - 1).
#[test]
fn the_scalar_decay_has_its_closed_form() {
    let plant = Power { power: 1, even: false };
    for lambda in [1.5, 2.0, 7.0, 40.0] {
        let target = TargetSystem::<1, 1>::poles(&[-lambda]).unwrap();
        let t = Transform::new(&plant, &target, &line(Escape::Free), SVector::zeros(), 1e-12).unwrap();
        for x in [-1.0, 0.0, 0.3, 1.0] {
            let (value, slope) = t.with_jacobian(&Vector1::new(x)).unwrap();
            let expected = lambda / (lambda - 1.0);
            // The integrand decays at lambda - 1 while the horizon counts on lambda: what is cut off is
            // tolerance^((lambda - 1)/lambda).
            let cut = expected * 1e-12f64.powf((lambda - 1.0) / lambda);
            // A hundred steps, each within the tolerance of a state that has grown by e^horizon relative to ... its own
            // size.
            let bound = 2.0 * cut + 1e-10 * expected;
            assert!((value[0] - expected * x).abs() <= bound, "{lambda} {x}: {}", value[0] - expected * x);
            assert!((slope[0] - expected).abs() <= bound, "{lambda} {x}: {}", slope[0] - expected);
            assert!(t.defect(&Vector1::new(x)).unwrap().norm() <= 2.0 * lambda * bound);
        }
    }
}

/// The harmonic oscillator, an output bank each: T solves `T A - D T = B C`, whatever the number of outputs.
#[test]
fn two_outputs_have_a_bank_each() {
    let (a, c) = (Matrix2::new(0.0, 1.0, -1.0, 0.0), Matrix2::new(1.0, 0.0, 1.0, -2.0));
    let plant = StaticPlant::new(a, SMatrix::<f64, 2, 0>::zeros(), c).unwrap();
    let target = TargetSystem::<2, 4>::bessel(2.0).unwrap();
    let domain = Domain::new([-1.0, -2.0], [2.0, 1.0], Escape::Free).unwrap();
    let t = Transform::new(&plant, &target, &domain, SVector::zeros(), 1e-11).unwrap();
    let dynamic = |m: &[f64], rows: usize, cols: usize| DMatrix::from_column_slice(rows, cols, m);
    let exact =
        sylvester(&-target.dynamics(), &dynamic(a.as_slice(), 2, 2), &dynamic((target.b() * c).as_slice(), 4, 2))
            .unwrap()
            .x;
    let x = SVector::from([0.7, -1.1]);
    let (value, slope) = t.with_jacobian(&x).unwrap();
    assert_abs_diff_eq!(dynamic(slope.as_slice(), 4, 2), exact, epsilon = 1e-9);
    assert_abs_diff_eq!(dynamic(value.as_slice(), 4, 1), exact * dynamic(x.as_slice(), 2, 1), epsilon = 1e-9);
}

/// A matrix with spectrum in |Re| < 1.2, whatever its entries: the norm is bounded.
fn plant3() -> impl Strategy<Value = StaticPlant<f64, 3, 0, 1>> {
    (prop::array::uniform9(-0.4..0.4f64), prop::array::uniform3(0.2..1.0f64)).prop_map(|(a, c)| {
        StaticPlant::new(Matrix3::from_row_slice(&a), SMatrix::zeros(), SMatrix::from_row_slice(&c)).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// For a linear plant T is the matrix of the Sylvester equation `T A - D T = B C`, and D T + B C - T A = 0 is the
    /// PDE.
    #[test]
    fn a_linear_plant_has_a_linear_t(plant in plant3(), cutoff in 6.0..12.0f64, x in prop::array::uniform3(-1.0..1.0f64)) {
        let target = TargetSystem::<1, 4>::bessel(cutoff).unwrap();
        let domain = Domain::new([-1.0; 3], [1.0; 3], Escape::Free).unwrap();
        let t = Transform::new(&plant, &target, &domain, SVector::zeros(), 1e-12).unwrap();
        let a = DMatrix::from_column_slice(3, 3, plant.a.as_slice());
        let bc = DMatrix::from_column_slice(4, 3, (target.b() * plant.c).as_slice());
        let exact = sylvester(&-target.dynamics(), &a, &bc).unwrap().x;
        let x = SVector::from(x);
        let (value, slope) = t.with_jacobian(&x).unwrap();
        let slope = DMatrix::from_column_slice(4, 3, slope.as_slice());
        let value = DMatrix::from_column_slice(4, 1, value.as_slice());
        // The past grows at most at the rate 1.2 = |A|, the weights fall at 4.8 and more: tolerance^(3/4) is cut off,
        // 1e-9; T is of size 1.
        prop_assert!((&slope - &exact).amax() < 4e-9, "{}", (&slope - &exact).amax());
        prop_assert!((value - exact * DMatrix::from_column_slice(3, 1, x.as_slice())).amax() < 1.2e-8);
        prop_assert!(t.defect(&x).unwrap().norm() < 1e-6);
    }
}

/// Break at the k-th call ends the design at that call, whatever is being done: no stage is without calls, and none
/// goes on after its break.
#[test]
fn a_design_ends_where_its_listener_says_so() {
    let plant = Power { power: 1, even: false };
    let target = TargetSystem::<1, 2>::poles(&[-2.0, -3.0]).unwrap();
    let ended = |last: usize| {
        let mut seen = Vec::new();
        let mut watch = |progress: Progress| {
            seen.push(progress);
            if seen.len() > last { Break(()) } else { Continue(()) }
        };
        let none = SVector::zeros();
        let design = NumericalKklDesign::new(&plant, &target, &line(Escape::Free), none, &small(), &mut watch);
        (design.err(), seen)
    };
    let (none, all) = ended(usize::MAX);
    assert_eq!(none, None);
    let mut stages: Vec<&str> = all.iter().map(|progress| progress.stage).collect();
    stages.dedup();
    let expected = [
        "T on the grid",
        "held-out points",
        "injectivity",
        "suspect pairs",
        "regression",
        "regression of T",
        "embedded form",
        "interpolated form",
        "evaluations of T",
    ];
    assert_eq!(stages, expected);
    for stage in expected {
        let last = all.iter().rposition(|progress| progress.stage == stage).unwrap();
        let (error, seen) = ended(last);
        let Progress { done, total, .. } = all[last];
        assert_eq!(error, Some(NumericalKklError::Stopped { stage, done, total }));
        assert_eq!(seen, all[..=last]);
    }
}

/// Everything at once on a plant whose answer is known: the harmonic oscillator, estimated from a wrong start.
#[test]
fn the_harmonic_oscillator_is_estimated_by_both_forms() {
    let plant =
        StaticPlant::new(Matrix2::new(0.0, 1.0, -1.0, 0.0), SMatrix::<f64, 2, 0>::zeros(), RowVector2::new(1.0, 0.0))
            .unwrap();
    let target = TargetSystem::<1, 3>::bessel(2.0).unwrap();
    let domain = Domain::new([-1.0; 2], [1.0; 2], Escape::Free).unwrap();
    let mut seen = Vec::new();
    let mut watch = |progress: Progress| {
        seen.push(progress);
        Continue(())
    };
    let design = NumericalKklDesign::new(&plant, &target, &domain, SVector::zeros(), &small(), &mut watch).unwrap();
    // T is linear: the spline, and one polynomial, reproduce it up to the simulation (1e-11 per step) and the ridge
    // (1e-8).
    let report = &design.report;
    assert!(report.spline.1 < 1e-8 && report.residual.1 < 1e-8 && report.simulated_residual < 1e-9, "{report}");
    assert!(report.interpolated.max.amax() < 1e-8 && report.embedded.max.amax() < 1e-6, "{report}");
    // |T v| / |v| over all v: the extreme singular values of the matrix T, by pairs and by Jacobians.
    let injectivity = &report.injectivity;
    assert!(injectivity.smallest_singular_value <= injectivity.smallest_ratio * (1.0 + 1e-6));
    assert!(injectivity.smallest_ratio > 0.05 && injectivity.smallest_ratio < injectivity.largest_ratio);
    // Three target states, two states: T(box) is flat, and the direction of no width is left out.
    let whiten = design.interpolated.map().inverse().start().coordinates().whiten();
    assert_eq!(whiten.row_iter().filter(|row| row.amax() == 0.0).count(), 1);
    // Progress: known stages, none beyond its end, the last of the grid seen.
    assert!(seen.iter().all(|p| p.done <= p.total));
    assert!(seen.contains(&Progress { stage: "T on the grid", done: 289, total: 289 }));

    let trials = [
        Trial { start: [0.6, -0.3], transient: 12.0, end: 20.0, samples: 81 },
        Trial { start: [1.2, 0.0], transient: 12.0, end: 20.0, samples: 81 },
    ];
    let run = held_out(&plant, &design.embedded, &domain, &SVector::zeros(), &trials).unwrap();
    // e^(-12 * 2.1) of the start is 1e-11; the embedded form's own error remains.
    assert!(run.inside.max.amax() < 1e-6, "{run:?}");
    // Outside, the estimate stands on the border: off by at most 0.2.
    assert!(run.outside.samples > 0 && run.outside.max.amax() <= 0.2 + 1e-6, "{run:?}");
    // `initial` is T.
    let (u, y) = (SVector::zeros(), Vector1::new(0.0));
    let z = design.interpolated.initial(0.0, &SVector::from([0.2, 0.4]), &u, &y);
    let back = design.interpolated.estimate(0.0, &z, &u, &y);
    assert_abs_diff_eq!(back, SVector::from([0.2, 0.4]), epsilon = 1e-8);
}

/// x' = -x^3 from x was infinite 1 / (2 x^2) earlier.
#[test]
fn a_blow_up_in_the_past_is_named_and_slowing_cures_it() {
    let plant = Power { power: 3, even: false };
    let target = TargetSystem::<1, 2>::poles(&[-3.0, -5.0]).unwrap();
    let free =
        NumericalKklDesign::new(
            &plant,
            &target,
            &line(Escape::Free),
            SVector::zeros(),
            &small(),
            &mut |_| Continue(()),
        )
        .unwrap_err();
    match free {
        NumericalKklError::Escapes { from, time, norm } => {
            assert!((time - 0.5 / from[0].powi(2)).abs() < 1e-6 && norm > 1e3, "{from:?} {time} {norm}");
        }
        other => panic!("{other}"),
    }
    let slowed = line(Escape::Slowed { margin: 0.5 });
    let transform = Transform::new(&plant, &target, &slowed, SVector::zeros(), 1e-11).unwrap();
    for x in [-1.0, -0.2, 0.5, 1.0] {
        // In the box the PDE holds with the plant's own f.
        let defect = transform.defect(&Vector1::new(x)).unwrap().norm();
        assert!(defect < 1e-8, "{x}: {defect:e}");
    }
    let design =
        NumericalKklDesign::new(&plant, &target, &slowed, SVector::zeros(), &small(), &mut |_| Continue(())).unwrap();
    assert!(design.report.interpolated.max[0] < 1e-2, "{}", design.report);
}

/// y = x^2 does not tell x from -x.
#[test]
fn two_states_with_one_output_are_found_and_named() {
    let plant = Power { power: 1, even: true };
    let target = TargetSystem::<1, 3>::poles(&[-4.0, -5.0, -6.0]).unwrap();
    for domain in [line(Escape::Free), Domain::new([-0.7], [1.3], Escape::Free).unwrap()] {
        let refused =
            NumericalKklDesign::new(&plant, &target, &domain, SVector::zeros(), &small(), &mut |_| Continue(()))
                .unwrap_err();
        match refused {
            NumericalKklError::NotInjective { first, second, distance, gap, accuracy } => {
                assert!(gap <= accuracy && distance > 0.1, "{gap:e} {accuracy:e} {distance}");
                // T is a quadratic here: x and -x up to the square root of what T resolves.
                assert!((first[0] + second[0]).abs() < 1e-4, "{first:?} {second:?}");
            }
            other => panic!("{other}"),
        }
    }
    // On one side of zero the same output will do.
    let positive = Domain::new([0.2], [1.0], Escape::Free).unwrap();
    let design =
        NumericalKklDesign::new(&plant, &target, &positive, SVector::zeros(), &small(), &mut |_| Continue(())).unwrap();
    assert!(design.report.interpolated.max[0] < 1e-4, "{}", design.report);
}

#[test]
fn the_same_arguments_give_the_same_numbers_and_another_seed_others() {
    let plant = Power { power: 3, even: false };
    let target = TargetSystem::<1, 2>::poles(&[-3.0, -5.0]).unwrap();
    let domain = line(Escape::Slowed { margin: 0.5 });
    let design = |seed| {
        let settings = Settings { seed, ..small() };
        NumericalKklDesign::new(&plant, &target, &domain, SVector::zeros(), &settings, &mut |_| Continue(())).unwrap()
    };
    let (one, same, other) = (design(1), design(1), design(2));
    assert_eq!(one.report, same.report);
    assert_eq!(one.embedded, same.embedded);
    assert_ne!(one.embedded, other.embedded);
}

#[test]
fn targets_that_cannot_be_are_named() {
    let unstable = TargetSystem::<1, 2>::poles(&[-1.0, 0.5]).unwrap_err();
    assert_eq!(unstable, DesignError::UnstablePole { pole: Complex::new(0.5, 0.0) }.into());
    let lone = [Complex::new(-1.0, 1.0), Complex::new(-2.0, 0.0)];
    let unpaired = TargetSystem::<1, 2>::poles(&lone).unwrap_err();
    assert_eq!(unpaired, LinalgError::PoleUnpaired { pole: lone[0] }.into());
    let nan = TargetSystem::<1, 1>::poles(&[f64::NAN]).unwrap_err();
    assert!(
        matches!(nan, NumericalKklError::Design(DesignError::Linalg(LinalgError::PoleNotFinite { index: 0, .. }))),
        "{nan}"
    );
    let few = TargetSystem::<1, 3>::poles(&[-1.0, -2.0]).unwrap_err();
    assert_eq!(few, NumericalKklError::PoleCount { poles: 2, outputs: 1, targets: 3 });
    let none = TargetSystem::<1, 0>::poles(&[0.0; 0]).unwrap_err();
    assert_eq!(none, NumericalKklError::Empty { states: 1, outputs: 1, targets: 0 });
    assert!(TargetSystem::<1, 0>::bessel(1.0).is_err() && TargetSystem::<2, 3>::bessel(1.0).is_err());
    assert!(matches!(
        TargetSystem::<1, 2>::bessel(-1.0).unwrap_err(),
        NumericalKklError::Design(DesignError::NotPositive { .. })
    ));

    let d = Matrix2::new(-1.0, 3.0, 3.0, -1.0);
    match TargetSystem::<1, 2>::new(d, SMatrix::from([[1.0, 0.0]])).unwrap_err() {
        NumericalKklError::Design(DesignError::NotHurwitz { what: "D", abscissa }) => {
            assert!((abscissa - 2.0).abs() < 1e-12);
        }
        other => panic!("{other}"),
    }
    let blind = TargetSystem::<1, 2>::new(Matrix2::new(-1.0, 0.0, 0.0, -2.0), SMatrix::from([[1.0, 0.0]])).unwrap_err();
    assert!(matches!(blind, NumericalKklError::Uncontrollable { .. }), "{blind}");
    let nan = TargetSystem::<1, 1>::new(Vector1::new(f64::NAN), Vector1::new(1.0)).unwrap_err();
    assert!(matches!(nan, NumericalKklError::Design(DesignError::Matrix(_))), "{nan}");
}

#[test]
fn boxes_settings_and_inputs_that_cannot_be_are_named() {
    for (lower, upper) in [(1.0, 1.0), (2.0, -2.0), (f64::NAN, 1.0), (0.0, f64::INFINITY), (-1e308, 1e308)] {
        let refused = Domain::new([0.0, lower], [1.0, upper], Escape::Free).unwrap_err();
        assert!(matches!(refused, NumericalKklError::Box { axis: 1, .. }), "{refused}");
    }
    assert!(Domain::<0>::new([], [], Escape::Free).is_err());
    for margin in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Domain::new([0.0], [1.0], Escape::Slowed { margin }).is_err());
    }
    let plant = StaticPlant::new(Vector1::new(-1.0), Vector1::new(1.0), Vector1::new(1.0)).unwrap();
    let target = TargetSystem::<1, 1>::poles(&[-3.0]).unwrap();
    for tolerance in [0.0, -1e-9, 1.0, f64::NAN] {
        assert!(Transform::new(&plant, &target, &line(Escape::Free), Vector1::new(0.0), tolerance).is_err());
    }
    let nan = Transform::new(&plant, &target, &line(Escape::Free), Vector1::new(f64::NAN), 1e-9);
    assert!(matches!(nan.err(), Some(NumericalKklError::Design(DesignError::Matrix(_)))));
    let with = |settings: Settings<1>| {
        NumericalKklDesign::new(&plant, &target, &line(Escape::Free), Vector1::new(0.0), &settings, &mut |_| {
            Continue(())
        })
        .err()
    };
    for (what, settings) in [
        ("points", Settings { points: [3], ..small() }),
        ("degree", Settings { degree: 0, ..small() }),
        ("leaves", Settings { leaves: 0, ..small() }),
        ("samples", Settings { samples: 0, ..small() }),
        ("ridge", Settings { ridge: f64::NAN, ..small() }),
        ("evaluations", Settings { max_evaluations: 0, ..small() }),
        ("held out", Settings { held_out: 0, ..small() }),
        ("injectivity", Settings { injectivity_points: 1, ..small() }),
    ] {
        let refused = with(settings);
        assert!(matches!(refused, Some(NumericalKklError::Design(DesignError::Setting { .. }))), "{what}");
    }
    // The constant input belongs to T: x' = -x + u has T = lambda x / (lambda - 1) - u / (lambda - 1).
    let transform = Transform::new(&plant, &target, &line(Escape::Free), Vector1::new(0.5), 1e-12).unwrap();
    let value = transform.at(&Vector1::new(0.4)).unwrap()[0];
    // tolerance^(2/3) is cut off.
    assert_abs_diff_eq!(value, 1.5 * 0.4 - 0.5 * 0.5, epsilon = 1e-7);
    let huge = Trial { start: [0.1], transient: 2.0, end: 1.0, samples: 10 };
    let design =
        NumericalKklDesign::new(&plant, &target, &line(Escape::Free), Vector1::new(0.0), &small(), &mut |_| {
            Continue(())
        })
        .unwrap();
    assert!(held_out(&plant, &design.embedded, &line(Escape::Free), &Vector1::new(0.0), &[huge]).is_err());
}

/// D of a bank for one output has the poles of the filter.
fn bessel_poles<const Z: usize>() -> Vec<Complex<f64>> {
    eigenvalues(&TargetSystem::<1, Z>::bessel(1.0).unwrap().dynamics()).unwrap()
}

#[test]
fn bessel_poles_are_the_tabulated_ones() {
    // C. S. Lindquist, Active Network Design, 1977, table of Bessel filters normalised to 3 dB at 1 rad/s: 5
    // digits.
    let second = bessel_poles::<2>();
    assert!(second.iter().all(|p| (p.re + 1.1016).abs() < 1e-4 && (p.im.abs() - 0.6360).abs() < 1e-4), "{second:?}");
    let third = bessel_poles::<3>();
    assert!(third.iter().any(|p| p.im == 0.0 && (p.re + 1.3227).abs() < 1e-4), "{third:?}");
    assert!(third.iter().filter(|p| (p.re + 1.0474).abs() < 1e-4 && (p.im.abs() - 0.9993).abs() < 1e-4).count() == 2);
    assert_eq!(bessel_poles::<10>().len(), 10);
    assert_eq!(
        TargetSystem::<1, 0>::bessel(1.0).unwrap_err(),
        NumericalKklError::PoleCount { poles: 0, outputs: 1, targets: 0 }
    );
    assert_eq!(
        TargetSystem::<1, 11>::bessel(1.0).unwrap_err(),
        NumericalKklError::BesselOrder { order: 11, largest: 10 }
    );
}

#[test]
fn repeated_poles_make_a_controllable_cascade() {
    let target = TargetSystem::<2, 8>::poles(&[
        Complex::new(-1.0, 2.0),
        Complex::new(-1.0, -2.0),
        Complex::new(-1.0, -2.0),
        Complex::new(-1.0, 2.0),
    ])
    .unwrap();
    // The static gain of a filter that is fed by the output alone: -D^-1 B has entries of modulus at most 1.
    let gain = target.d().try_inverse().unwrap() * target.b();
    assert!(gain.amax() <= 1.0 + 1e-14);
    assert!(TargetSystem::<1, 3>::poles(&[-2.0, -2.0, -2.0]).is_ok());
}

#[test]
fn the_slowed_field_is_the_plants_in_the_box_and_its_gradient_is_right() {
    let domain = Domain::new([-1.0, 0.0], [1.0, 4.0], Escape::Slowed { margin: 0.5 }).unwrap();
    assert_eq!(domain.speed(&[1.0, 4.0].into()), (1.0, SVector::zeros()));
    assert_eq!(domain.speed(&[1.5, 2.0].into()).0, 0.0);
    let x = SVector::from([-1.2, 4.3]);
    let (_, gradient) = domain.speed(&x);
    for axis in 0..2 {
        let step = SVector::from_fn(|i, _| if i == axis { 1e-6 } else { 0.0 });
        let difference = (domain.speed(&(x + step)).0 - domain.speed(&(x - step)).0) / 2e-6;
        // Central differences: h^2/6 times a third derivative below 1e3, and rounding EPSILON / h.
        assert!((difference - gradient[axis]).abs() < 1e-9, "{difference} {gradient}");
    }
}

/// x1^2 + x2^2 - 1 and x2 - x1, in the box [-2, 2]^2, times a factor.
fn half_disk(factor: f64, escape: Escape) -> Domain<2> {
    let disk: Inequality<2> = Arc::new(move |x| (factor * (x.norm_squared() - 1.0), x * (2.0 * factor)));
    let half: Inequality<2> = Arc::new(move |x| (factor * (x[1] - x[0]), SVector::from([-factor, factor])));
    Domain::new([-2.0; 2], [2.0; 2], escape).unwrap().inside([disk, half]).unwrap()
}

/// The plant is slowed beyond an inequality as beyond a side of the box, and what g is multiplied with is irrelevant.
#[test]
fn the_plant_is_slowed_outside_of_the_inequalities_and_the_gradient_is_right() {
    let slowed = Escape::Slowed { margin: 0.5 };
    let (domain, scaled) = (half_disk(1.0, slowed), half_disk(1024.0, slowed));
    assert_eq!(domain.speed(&[0.6, -0.6].into()), (1.0, SVector::zeros()));
    assert!(domain.contains(&[0.6, -0.6].into()) && !domain.contains(&[-0.6, 0.6].into()));
    // g = 0.5 is reached at |x|^2 = 1.5, where the largest -g is 1, up to the points at which it was sought.
    assert_eq!(domain.speed(&[1.0, -0.75].into()).0, 0.0);
    let between = domain.speed(&[0.9, -0.6].into()).0;
    assert!(between > 0.0 && between < 1.0, "{between}");
    for x in [[0.9, -0.6], [0.3, 0.5], [0.85, 0.9]].map(SVector::from) {
        let (value, gradient) = domain.speed(&x);
        assert_eq!((value, gradient), scaled.speed(&x));
        for axis in 0..2 {
            let step = SVector::from_fn(|i, _| if i == axis { 1e-6 } else { 0.0 });
            let difference = (domain.speed(&(x + step)).0 - domain.speed(&(x - step)).0) / 2e-6;
            // As above, with steeper slopes.
            assert!((difference - gradient[axis]).abs() < 1e-8, "{difference} {gradient}");
        }
    }
    assert_eq!(half_disk(1.0, Escape::Free).speed(&[-1.9, 1.9].into()), (1.0, SVector::zeros()));
    assert_eq!(domain.escaping(Escape::Free).unwrap().speed(&[-1.9, 1.9].into()), (1.0, SVector::zeros()));
}

#[test]
fn inequalities_that_hold_nowhere_or_have_no_value_are_refused() {
    let square = Domain::new([-1.0; 2], [1.0; 2], Escape::Free).unwrap();
    let inside = |g: fn(&SVector<f64, 2>) -> f64| {
        square.clone().inside([Arc::new(move |x: &SVector<f64, 2>| (g(x), SVector::zeros())) as Inequality<2>])
    };
    // A disk of a hundredth of the half-width: 3 of 40000 of the box.
    for g in [(|_| 1.0) as fn(&SVector<f64, 2>) -> f64, |_| 0.0, |x| x.norm() - 0.01] {
        let refused = inside(g).unwrap_err();
        assert!(matches!(refused, NumericalKklError::SmallDomain { tried: 4096, .. }), "{refused}");
    }
    let refused = inside(|x| x[0].sqrt()).unwrap_err();
    assert!(matches!(&refused, NumericalKklError::Inequality { index: 0, at } if at[0] < 0.0), "{refused}");
    assert!(square.clone().inside([]).unwrap().contains(&[0.9, 0.9].into()));
}

/// y = x^2 on the box [-1, 1], of which an inequality leaves [0.2, 1]: as the box [0.2, 1] itself.
#[test]
fn an_inequality_leaves_out_the_states_that_the_output_does_not_tell_apart() {
    let plant = Power { power: 1, even: true };
    let target = TargetSystem::<1, 3>::poles(&[-4.0, -5.0, -6.0]).unwrap();
    let positive: Inequality<1> = Arc::new(|x| (0.2 - x[0], Vector1::new(-1.0)));
    let part = line(Escape::Free).inside([positive]).unwrap();
    let design =
        NumericalKklDesign::new(&plant, &target, &part, SVector::zeros(), &small(), &mut |_| Continue(())).unwrap();
    assert!(design.report.interpolated.max[0] < 1e-4, "{}", design.report);
    assert!(design.report.injectivity.pair.0[0] >= 0.2 && design.report.injectivity.flattest[0] >= 0.2);
    let image = |x: f64| design.interpolated.initial(0.0, &Vector1::new(x), &SVector::zeros(), &Vector1::new(0.0));
    let back = |x: f64| design.interpolated.estimate(0.0, &image(x), &SVector::zeros(), &Vector1::new(0.0))[0];
    // T is the same at -x, of which the left inverse knows nothing.
    assert!((back(0.7) - 0.7).abs() < 1e-4 && (back(-0.7) - 0.7).abs() < 1e-4, "{} {}", back(0.7), back(-0.7));
}
