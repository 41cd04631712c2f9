//! The search for cut-off, table and escape of a numerical KKL observer: the plants of the literature, and one that the
//! search has not been tuned on. The designs chosen are run along trajectories.

use std::ops::ControlFlow::{Break, Continue};

use luenberger_design::numerical_kkl::{
    Choice, ChoiceOptions, Domain, Escape, NumericalKklDesign, NumericalKklError, Settings, TargetSystem, Trial,
    choose, held_out,
};
use luenberger_plants::{Differentiable, ReverseDuffing, VanDerPol};
use nalgebra::{Const, SVector};

plant!(
    /// Lotka and Volterra's prey and predators, of which the prey is counted: `x1' = x1 (1 - x2)`, `x2' = x2 (x1 - 1)`.
    Prey,
    2,
    1,
    |_plant, x| [x[0] * (T::one() - x[1]), x[1] * (x[0] - T::one())],
    [x[0]]
);

type Box2 = ([f64; 2], [f64; 2]);

fn chosen<S>(plant: &S, (lower, upper): Box2, wanted: &ChoiceOptions) -> Result<Choice, NumericalKklError>
where
    S: Differentiable<f64, Const<2>, Const<0>, Const<1>>,
{
    let settings = Settings { leaves: 32, samples: 8000, ..Settings::default() };
    let domain = Domain::new(lower, upper, Escape::Free)?;
    choose::<_, 2, 0, 3>(plant, &domain, SVector::zeros(), wanted, &settings, &mut |_| Continue(()))
}

/// The largest root mean square error along trajectories from these states, in half-widths, with the choice.
fn error_along<S>(plant: &S, (lower, upper): Box2, choice: &Choice, starts: &[[f64; 2]]) -> f64
where
    S: Differentiable<f64, Const<2>, Const<0>, Const<1>>,
{
    let settings = Settings { points: [choice.points; 2], leaves: 32, samples: 8000, ..Settings::default() };
    let (domain, input) = (Domain::new(lower, upper, choice.escape).unwrap(), SVector::zeros());
    let target = TargetSystem::<1, 3>::bessel(choice.cutoff).unwrap();
    let design = NumericalKklDesign::new(plant, &target, &domain, input, &settings, &mut |_| Continue(())).unwrap();
    let trials: Vec<_> =
        starts.iter().map(|&start| Trial { start, transient: 15.0, end: 40.0, samples: 400 }).collect();
    let seen = held_out(plant, &design.interpolated, &domain, &input, &trials).unwrap();
    assert_eq!(seen.outside.samples, 0, "the trajectories stay in the box");
    seen.inside.rmse.component_div(&domain.half_width()).max()
}

#[test]
fn van_der_pol_is_slowed_and_has_a_fast_filter() {
    let box_ = ([-2.3, -3.0], [2.3, 3.0]);
    let choice = chosen(&VanDerPol { mu: 1.0 }, box_, &ChoiceOptions::default()).unwrap();
    assert!(matches!(choice.escape, Escape::Slowed { .. }));
    assert!(choice.is_reached && choice.candidates.len() <= 11, "{choice:?}");
    let error = error_along(&VanDerPol { mu: 1.0 }, box_, &choice, &[[0.5, 0.5], [2.0, 1.0]]);
    assert!(error < 2e-4, "{error:e} with {choice:?}");
}

/// Refused at cut-offs to 10.
#[test]
fn a_relaxation_oscillator_is_found_too() {
    let box_ = ([-2.3, -6.0], [2.3, 6.0]);
    let choice = chosen(&VanDerPol { mu: 3.0 }, box_, &ChoiceOptions::default()).unwrap();
    assert!(choice.cutoff > 10.0, "{choice:?}");
    let refused = choice.candidates.iter().filter(|candidate| candidate.cutoff <= 10.0);
    assert!(refused.clone().count() > 0 && refused.clone().all(|candidate| candidate.outcome.is_err()), "{choice:?}");
    let error = error_along(&VanDerPol { mu: 3.0 }, box_, &choice, &[[0.5, 0.5], [2.0, 0.0]]);
    assert!(error < 1e-3, "{error:e} with {choice:?}");
}

#[test]
fn plants_with_a_bounded_past_are_not_slowed() {
    let unit = ([-1.0; 2], [1.0; 2]);
    let choice = chosen(&ReverseDuffing, unit, &ChoiceOptions::default()).unwrap();
    assert_eq!(choice.escape, Escape::Free);
    // With the seeds 0 to 5 it is 3e-7 to 6e-4: the few samples at which the inverse ends in another minimum decide.
    let error = error_along(&ReverseDuffing, unit, &choice, &[[0.5, 0.5], [-0.3, 0.6]]);
    assert!(error < 1e-3, "{error:e} with {choice:?}");

    let box_ = ([0.3; 2], [2.5; 2]);
    let choice = chosen(&Prey, box_, &ChoiceOptions::default()).unwrap();
    let error = error_along(&Prey, box_, &choice, &[[0.7, 1.0], [1.5, 1.2]]);
    assert!(error < 1e-4, "{error:e} with {choice:?}");
}

#[test]
fn what_is_given_is_not_searched() {
    let box_ = ([-1.0; 2], [1.0; 2]);
    let given = ChoiceOptions { cutoff: Some(1.5), points: Some(21), ..ChoiceOptions::default() };
    let choice = chosen(&ReverseDuffing, box_, &given).unwrap();
    assert_eq!((choice.cutoff, choice.points, choice.escape), (1.5, 21, Escape::Free));
    assert!(choice.candidates.is_empty());
    let given =
        ChoiceOptions { cutoff: Some(1.5), escape: Some(Escape::Slowed { margin: 0.5 }), ..ChoiceOptions::default() };
    let choice = chosen(&ReverseDuffing, box_, &given).unwrap();
    assert!(choice.candidates.iter().all(|candidate| candidate.cutoff == 1.5) && choice.candidates.len() <= 3);
    assert_eq!(choice.escape, Escape::Slowed { margin: 0.5 });
    // A search that cannot succeed: too few points for any of the filters.
    let coarse =
        ChoiceOptions { points: Some(5), escape: Some(Escape::Slowed { margin: 1.0 }), ..ChoiceOptions::default() };
    let error = chosen(&VanDerPol { mu: 3.0 }, ([-2.3, -6.0], [2.3, 6.0]), &coarse).unwrap_err();
    assert!(matches!(error, NumericalKklError::NoneFits { tried: 6, points: 5, .. }), "{error}");
}

#[test]
fn the_search_can_be_stopped() {
    let mut calls = 0;
    let settings = Settings::default();
    let domain = Domain::new([-1.0; 2], [1.0; 2], Escape::Free).unwrap();
    let stopped = choose::<_, 2, 0, 3>(
        &ReverseDuffing,
        &domain,
        SVector::zeros(),
        &ChoiceOptions::default(),
        &settings,
        &mut |_| {
            calls += 1;
            if calls > 100 { Break(()) } else { Continue(()) }
        },
    );
    assert!(matches!(stopped, Err(NumericalKklError::Stopped { .. })));
    assert_eq!(calls, 101);
}
