//! The numerical KKL observer end to end: designed by `design`, run by `sim`, on trajectories not used in the fit.
//!
//! The reverse Duffing oscillator is a benchmark of learned observers: from (0.5, 0.5), on the box [-1, 1]^2, published
//! ones reach root mean squares of (6.9e-3, 1.1e-2) with five target states. With three, the embedded form must stay
//! below (1e-4, 1e-3), the interpolated one below 1e-5 in both, from t = 10 on, started at z = 0.

use std::ops::ControlFlow::Continue;
use std::sync::OnceLock;

use luenberger_design::numerical_kkl::{
    Domain, Escape, NumericalKklDesign, NumericalKklError, Settings, TargetSystem, Trial, ValidationErrors, held_out,
};
use luenberger_observers::Observer;
use luenberger_observers::kkl::{KklObserver, LinearKkl};
use luenberger_observers::numerical_kkl::{Node, PolynomialInverse, PolynomialTree};
use luenberger_plants::{Plant, ReverseDuffing, StaticPlant, VanDerPol};
use luenberger_sim::Scenario;
use nalgebra::{DMatrix, SMatrix, SVector, Vector2, matrix};

type Design = NumericalKklDesign<2, 0, 1, 3>;

fn square() -> Domain<2> {
    Domain::new([-1.0; 2], [1.0; 2], Escape::Free).unwrap()
}

fn duffing() -> &'static Design {
    static DESIGN: OnceLock<Design> = OnceLock::new();
    DESIGN.get_or_init(|| {
        let target = TargetSystem::bessel(1.5).unwrap();
        let settings = Settings::default();
        NumericalKklDesign::new(&ReverseDuffing, &target, &square(), SVector::zeros(), &settings, &mut |_| Continue(()))
            .unwrap()
    })
}

/// Root mean squares over t >= 10 of the errors that `sim` sees, from the estimate (0, 0), whose z is 0.
fn simulated(observer: impl Observer<f64> + Send + Sync, start: [f64; 2]) -> Vector2<f64> {
    let times: Vec<f64> = (0..=1600).map(|k| 10.0 + 0.025 * f64::from(k)).collect();
    let run = Scenario::new(ReverseDuffing)
        .initial_state(&start)
        .observer("kkl", observer, &[0.0, 0.0])
        .times(&times)
        .tolerances(1e-10, 1e-11)
        .run()
        .unwrap();
    let errors = &run.observer("kkl").unwrap().error;
    Vector2::from_fn(|i, _| (errors.column(i).norm_squared() / errors.nrows() as f64).sqrt())
}

#[test]
fn the_reverse_duffing_oscillator_is_estimated_as_well_as_was_asked() {
    let design = duffing();
    println!("{}", design.report);
    let embedded = simulated(&design.embedded, [0.5, 0.5]);
    let interpolated = simulated(&design.interpolated, [0.5, 0.5]);
    println!("embedded {embedded:?}, interpolated {interpolated:?}");
    assert!(embedded[0] < 1e-4 && embedded[1] < 1e-3, "{embedded}");
    assert!(interpolated.amax() < 1e-5, "{interpolated}");
}

#[test]
fn two_integrators_agree_on_the_errors() {
    let design = duffing();
    let trial = Trial { start: [0.5, 0.5], transient: 10.0, end: 50.0, samples: 1601 };
    let ValidationErrors { inside, outside } =
        held_out(&ReverseDuffing, &design.embedded, &square(), &SVector::zeros(), &[trial]).unwrap();
    assert_eq!((inside.samples, outside.samples), (1601, 0));
    let simulated = simulated(&design.embedded, [0.5, 0.5]);
    // The states at the samples differ by 1e-8 between the integrators, and by the residue of T(0), 1e-6, at the start;
    // estimates jump between leaves, by errors of this size, at times that differ as little.
    assert!((simulated - inside.rmse).component_div(&inside.rmse).amax() < 0.05, "{simulated} {}", inside.rmse);
}

#[test]
fn other_starts_inside_and_outside_the_box_are_told_apart() {
    let design = duffing();
    let start = |start| Trial { start, transient: 10.0, end: 50.0, samples: 1601 };
    let zero = SVector::zeros();
    // Energies 0.08, 0.26 and 0.40 stay in the box, or leave it by x2 only: |x2| <= (4 H)^(1/4), 1.06 and 1.12.
    let trials = [start([-0.3, 0.6]), start([0.6, -0.7]), start([0.8, 0.75])];
    let run = held_out(&ReverseDuffing, &design.interpolated, &square(), &zero, &trials).unwrap();
    println!("{run:?}");
    assert!(run.inside.rmse.amax() < 1e-5, "{run:?}");
    assert!(run.outside.samples > 100 && run.outside.rmse.amax() > 1e-3, "{run:?}");
    // What cannot be estimated is still bounded: by the box.
    assert!(run.outside.max.amax() < 2.2, "{run:?}");
    // Near the origin x2 is all but unobservable (y' = x2^3): the embedded form gives up digits there, the interpolated
    // one few.
    let near = [start([0.1, 0.1])];
    let (rough, fine) = (
        held_out(&ReverseDuffing, &design.embedded, &square(), &zero, &near).unwrap().inside,
        held_out(&ReverseDuffing, &design.interpolated, &square(), &zero, &near).unwrap().inside,
    );
    assert!(rough.rmse[0] < 1e-4 && rough.rmse[1] < 3e-2, "{rough:?}");
    assert!(fine.rmse[0] < 1e-5 && fine.rmse[1] < 1e-4, "{fine:?}");
}

#[test]
fn the_evidence_of_the_design_is_what_the_theory_says() {
    let report = &duffing().report;
    // The simulation obeys the PDE to its tolerance; the spline to the error of its slopes, h^3 = 3e-5 times third
    // derivatives of order one.
    assert!(report.simulated_residual < 1e-9, "{report}");
    assert!(report.residual.1 < 1e-4, "{report}");
    // T is injective, and not immersive in the origin: DT (0, 1) = 0 there.
    assert!(report.injectivity.smallest_ratio > 1e-3, "{report}");
    assert!(
        report.injectivity.smallest_singular_value < 1e-9 && report.injectivity.flattest.amax() < 1e-12,
        "{report}"
    );
    // For a microcontroller.
    let cost = report.embedded_footprint;
    assert!(cost.bytes_f32 < 32 * 1024 && cost.multiply_adds < 128 && cost.comparisons <= 16, "{cost:?}");
}

/// In single precision: the same design, rounded, run on its own equations with steps of the classical Runge-Kutta
/// method.
#[test]
fn in_single_precision_the_embedded_form_keeps_its_accuracy() {
    let design = duffing();
    let map = design.embedded.map();
    let observer = KklObserver::new(
        LinearKkl::new(
            map.d().cast::<f32>(),
            map.b().cast::<f32>(),
            SMatrix::<f32, 3, 0>::zeros(),
            map.inverse().cast::<f32>(),
        )
        .unwrap(),
    );
    let (h, none) = (0.005, SVector::<f64, 0>::zeros());
    let (mut x, mut z) = (Vector2::new(0.5, 0.5), SVector::<f32, 3>::zeros());
    let (mut squares, mut count) = (Vector2::zeros(), 0.0);
    for k in 0..6000 {
        let slope = |x: &Vector2<f64>| ReverseDuffing.derivative(0.0, x, &none);
        let k1 = slope(&x);
        let k2 = slope(&(x + k1 * (h / 2.0)));
        let k3 = slope(&(x + k2 * (h / 2.0)));
        let k4 = slope(&(x + k3 * h));
        let middle = x + k2 * (h / 2.0);
        let next = x + (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
        // The observer's own steps, on the output at the start, the middle and the end of the interval.
        let (step, u) = (h as f32, SVector::<f32, 0>::zeros());
        let y = |x: &Vector2<f64>| SVector::<f32, 1>::new(x[0] as f32);
        let l1 = observer.derivative(0.0, &z, &u, &y(&x));
        let l2 = observer.derivative(0.0, &(z + l1 * (step / 2.0)), &u, &y(&middle));
        let l3 = observer.derivative(0.0, &(z + l2 * (step / 2.0)), &u, &y(&middle));
        let l4 = observer.derivative(0.0, &(z + l3 * step), &u, &y(&next));
        z += (l1 + (l2 + l3) * 2.0 + l4) * (step / 6.0);
        x = next;
        if f64::from(k) * h >= 10.0 {
            let error = x - observer.estimate(0.0, &z, &u, &y(&x)).cast::<f64>();
            squares += error.component_mul(&error);
            count += 1.0;
        }
    }
    let rmse = squares.map(|sum: f64| (sum / count).sqrt());
    println!("in single precision {rmse:?}");
    assert!(rmse[0] < 1e-4 && rmse[1] < 1e-3, "{rmse}");
}

/// The numbers may lie in flash: the observer over borrowed slices is the observer over vectors.
#[test]
fn the_tables_may_be_borrowed() {
    let form = duffing().embedded.map().inverse();
    let single = form.cast::<f32>();
    let (inverse, forward) = (single.inverse(), single.forward());
    let (lower, upper) = single.bounds();
    let borrowed = PolynomialInverse::<f32, &[Node<f32>], &[f32], 2, 3>::new(
        *single.coordinates(),
        (*lower, *upper),
        PolynomialTree::new(inverse.degree(), inverse.nodes(), inverse.leaves()).unwrap(),
        PolynomialTree::new(forward.degree(), forward.nodes(), forward.leaves()).unwrap(),
    )
    .unwrap();
    for x in [[0.5, 0.5], [-0.9, 0.2], [0.1, -0.7]] {
        let z = single.target(&SVector::from(x));
        assert_eq!(borrowed.state(&z), single.state(&z));
        assert_eq!(borrowed.target(&SVector::from(x)), z);
    }
}

/// No state of the target, however wild, makes NaN or leaves the box.
#[test]
fn wild_target_states_give_estimates_in_the_box() {
    let design = duffing();
    let (u, y) = (SVector::zeros(), SVector::zeros());
    for z in [[0.0; 3], [1e300, -1e300, 1e300], [f64::MAX; 3], [-3.0, 2.0, 5.0], [1e-300; 3]] {
        for estimate in [
            design.embedded.estimate(0.0, &SVector::from(z), &u, &y),
            design.interpolated.estimate(0.0, &SVector::from(z), &u, &y),
        ] {
            assert!(estimate.iter().all(|x| (-1.0..=1.0).contains(x)), "{z:?}: {estimate}");
        }
    }
}

/// The iteration from the last estimate ends where the one from the embedded form does, with fewer evaluations.
#[test]
fn a_warm_start_saves_evaluations() {
    let inverse = duffing().interpolated.map().inverse();
    let (mut cold, mut warm) = (0, 0);
    for k in 0..200 {
        let angle = 0.031 * f64::from(k);
        let x = Vector2::new(0.8 * angle.cos(), 0.8 * angle.sin());
        let before = Vector2::new(0.8 * (angle - 0.01).cos(), 0.8 * (angle - 0.01).sin());
        let z = inverse.target(&x);
        let (far, near) = (inverse.solve(&z, &Vector2::new(-x[1], x[0])), inverse.solve(&z, &before));
        assert!((near.x - x).amax() < 1e-6 && (far.x - x).amax() < 1e-6, "{x} {near:?} {far:?}");
        cold += far.evaluations;
        warm += near.evaluations;
    }
    assert!(2 * warm < cold, "{warm} {cold}");
}

/// Van der Pol's oscillator: every past but that of the origin is unbounded outside the limit cycle, so the plant is
/// slowed outside the box.
#[test]
fn van_der_pol_is_estimated_along_its_limit_cycle() {
    let plant = VanDerPol::default();
    let design = |escape| {
        let domain = Domain::new([-2.3, -3.0], [2.3, 3.0], escape).unwrap();
        let target = TargetSystem::<1, 3>::bessel(8.0).unwrap();
        let settings = Settings { held_out: 200, ..Settings::default() };
        NumericalKklDesign::new(&plant, &target, &domain, SVector::zeros(), &settings, &mut |_| Continue(()))
            .map(|design| (design, domain))
    };
    let free = design(Escape::Free).unwrap_err();
    assert!(matches!(free, NumericalKklError::Escapes { .. }), "{free}");
    println!("{free}");

    let (design, domain) = design(Escape::Slowed { margin: 1.0 }).unwrap();
    println!("{}", design.report);
    let start = |start| Trial { start, transient: 10.0, end: 50.0, samples: 1601 };
    // From inside and from outside the cycle.
    let trials = [start([0.5, 0.5]), start([0.01, 0.0]), start([2.2, 2.5])];
    let embedded = held_out(&plant, &design.embedded, &domain, &SVector::zeros(), &trials).unwrap().inside;
    let interpolated = held_out(&plant, &design.interpolated, &domain, &SVector::zeros(), &trials).unwrap().inside;
    println!("embedded {embedded:?}, interpolated {interpolated:?}");
    assert!(embedded.rmse.amax() < 1e-3 && interpolated.rmse.amax() < 1e-3, "{embedded:?} {interpolated:?}");
}

/// T of a linear plant is a matrix, `T A = D T + B C`, here from one linear system; the table of low rank knows nothing
/// of that. Six states: an oscillator moved by two sines.
#[test]
fn a_table_of_low_rank_is_the_solution_of_sylvesters_equation() {
    let a = matrix![
        0.0, 1.0, 0.0, 0.0, 0.0, 0.0;
        -1.0, -0.2, 1.0, 0.0, 1.0, 0.0;
        0.0, 0.0, 0.0, 2.0, 0.0, 0.0;
        0.0, 0.0, -2.0, 0.0, 0.0, 0.0;
        0.0, 0.0, 0.0, 0.0, 0.0, 3.0;
        0.0, 0.0, 0.0, 0.0, -3.0, 0.0
    ];
    let c = matrix![1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let plant = StaticPlant::new(a, SMatrix::<f64, 6, 0>::zeros(), c).unwrap();
    let target = TargetSystem::<1, 7>::bessel(4.0).unwrap();
    let domain =
        Domain::new([-1.0, -2.0, -0.5, -0.5, -0.5, -0.5], [1.0, 2.0, 0.5, 0.5, 0.5, 0.5], Escape::Free).unwrap();
    let settings = Settings {
        points: [4; 6],
        samples: 400,
        leaves: 1,
        degree: 1,
        held_out: 50,
        fallback: 0,
        injectivity_points: 3,
        ..Settings::default()
    };
    let design =
        NumericalKklDesign::low_rank(&plant, &target, &domain, SVector::zeros(), &settings, &mut |_| Continue(()))
            .unwrap();
    let (d, b) = (target.d(), target.b());
    // vec(T A - D T) = (A' x I - I x D) vec T.
    let (one, six) = (DMatrix::<f64>::identity(7, 7), DMatrix::<f64>::identity(6, 6));
    let dynamic = |rows, columns, entries: &[f64]| DMatrix::from_column_slice(rows, columns, entries);
    let operator =
        dynamic(6, 6, a.transpose().as_slice()).kronecker(&one) - six.kronecker(&dynamic(7, 7, d.as_slice()));
    let right = dynamic(42, 1, (b * c).as_slice());
    let exact = SMatrix::<f64, 7, 6>::from_column_slice(operator.lu().solve(&right).unwrap().as_slice());
    let inverse = design.interpolated.map().inverse();
    // The functions before a cut are the linear ones and 1, and so are those behind it.
    assert!(inverse.spline().ranks()[1..].iter().all(|rank| *rank <= 7), "{:?}", inverse.spline().ranks());
    // 2255; the full grid alone has 4096 points.
    assert!(design.report.trajectories < 3000, "{}", design.report.trajectories);
    for k in 0..40 {
        let x = SVector::from_fn(|i, _| domain.upper()[i] * (1.0 + 2.3 * f64::from(k) + 1.7 * i as f64).sin());
        let error = (inverse.target(&x) - exact * x).norm();
        // Six coordinates, of which the thinnest is some 1e-5 wide, each to 1e-6 of its width, and simulations to
        // 1e-11.
        assert!(error < 1e-6 * (exact * x).norm().max(0.1), "{error:e}");
        assert!((inverse.state(&inverse.target(&x)) - x).amax() < 1e-6, "{x}");
    }
    assert!(design.report.residual.1 < 1e-6 && design.report.interpolated.max.amax() < 1e-4, "{}", design.report);
}

/// The same grid in full and of low rank: T is the same up to the tolerance of the rank, in the units of T's widths.
#[test]
fn tables_in_full_and_of_low_rank_agree() {
    let settings = Settings { points: [33; 2], samples: 1000, leaves: 2, rank_tolerance: 1e-7, ..Settings::default() };
    let target = TargetSystem::<1, 3>::bessel(2.0).unwrap();
    let full =
        NumericalKklDesign::new(
            &ReverseDuffing,
            &target,
            &square(),
            SVector::zeros(),
            &settings,
            &mut |_| Continue(()),
        )
        .unwrap();
    let few =
        NumericalKklDesign::low_rank(&ReverseDuffing, &target, &square(), SVector::zeros(), &settings, &mut |_| {
            Continue(())
        })
        .unwrap();
    let (full, few) = (full.interpolated.map().inverse(), few.interpolated.map().inverse());
    let coordinates = full.start().coordinates();
    for k in 0..100 {
        let x = Vector2::new((1.3 * f64::from(k)).sin(), (0.7 + 2.1 * f64::from(k)).sin());
        let apart = (coordinates.white(&full.target(&x)) - coordinates.white(&few.target(&x))).amax();
        // Ten times for the norm of the interpolation by splines and for points that were not judged.
        assert!(apart < 1e-6, "{apart:e} at {x}");
    }
}
