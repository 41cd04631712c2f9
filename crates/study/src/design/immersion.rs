//! Immersion-and-invariance observers with given maps: what is proved of the distance `d = beta(y, chi) - phi(x)`.
//!
//! Where D_chi beta has full row rank and rho = 0, (18) makes `d' = K(phi^L(phi(x) + d, y)) - K(x)` with
//! ```text
//!     K(x) = Dphi(x) f(x, u) - D_y beta(y, chi) Dh(x) f(x, u)
//! ```
//! so that `d' = M d` with M a mean of `d K(phi^L(z, y))/dz`. If one P proves every matrix of the enclosure of these
//! derivatives over the region to be Hurwitz, d decays exponentially as long as x and xhat stay there: (A5).

use luenberger_design::kkl::{Attractivity, KklSettings, attractivity};
use luenberger_design::{IntervalDual, KklError, Region};
use luenberger_observers::{Immersion, ImmersionInvarianceObserver};
use luenberger_plants::{Differentiable, Plant};
use luenberger_proof::wording::significant;
use luenberger_proof::{Interval, Ring, Verdict};
use nalgebra::DVector;

use super::explain::Misfit;
use super::kkl_maps::{candidate, is_left_inverse, proved, undecided_injectivity};
use super::{Designed, facts, matrix, number};
use crate::maps::{ImmersionMaps, ImmersionSpec};
use crate::model::Model;
use crate::results::DesignReport;
use crate::runnable::Runnable;

/// The observer, if phi^L takes phi(x) back, (phi, h) is not shown to lack injectivity, and D_chi beta has full row
/// rank at the samples.
pub(super) fn immersion(model: &Model, spec: &ImmersionSpec) -> Result<Designed, Misfit> {
    let ImmersionSpec { maps, region } = spec;
    let settings = KklSettings::default();
    // The checks of phi and phi^L alone: the equation of phi is not asked.
    let phi = &maps.image;
    let report = candidate(model, phi)?.check(region, &settings)?;
    match (&report.injectivity.verdict, &report.injectivity.near_collision) {
        (Verdict::Refuted { witness }, _) => return Err(KklError::NotInjective(witness.clone()).into()),
        (Verdict::Undecided { .. }, Some(pair)) => return Err(KklError::Indistinct(pair.clone()).into()),
        _ => {}
    }
    is_left_inverse(model, phi, region, &report, settings.tolerance)?;
    let rank = rank(model, maps, region)?;

    let mut all = Vec::new();
    let mut evidence = Vec::new();
    if let Verdict::Proved { margin } = report.injectivity.verdict {
        all.push(proved("(phi, h) is injective", "verified over the region".to_owned(), Some(margin)));
    } else {
        evidence.push(undecided_injectivity(&report));
    }
    match rank {
        Rank::Proved => {
            let words = "verified by the constant entries of D_chi beta".to_owned();
            all.push(proved("D_chi beta has full row rank (A4)", words, None));
        }
        Rank::Measured(least) => evidence.push(format!(
            "that D_chi beta has full row rank (A4) is not proved: its least singular value at the samples, with chi of the start, is {}",
            significant(least, 3)
        )),
    }
    let mut certificate = None;
    let (mut poles, mut matrices) = (Vec::new(), Vec::new());
    match attractivity_over(model, maps, region)? {
        Ok(found) if matches!(rank, Rank::Proved) => {
            poles = found.eigenvalues.iter().map(|z| [z.re, z.im]).collect();
            if found.certificate.is_proved() {
                all.splice(0..0, facts(&found.certificate, &[]));
                matrices.extend(found.p.iter().map(|p| matrix("P", p)));
                certificate = Some(found.certificate);
            } else {
                evidence.push("that the manifold attracts (A5) is not proved: no P was found for all Jacobians of the distance over the region".to_owned());
            }
        }
        Ok(_) => evidence.push("that the manifold attracts (A5) is not proved: it needs (A4)".to_owned()),
        Err(why) => evidence.push(format!("that the manifold attracts (A5) is not proved: {why}")),
    }
    let statement = if certificate.is_some() {
        format!(
            "As long as x(t), xhat(t) and u(t) stay in the region ({region}), the distance beta(y, chi) - phi(x) decays exponentially, and xhat = phi^L(beta(y, chi), y) is continuous in it: the estimation error tends to 0."
        )
    } else {
        let slowest = poles.iter().map(|[re, _]| *re).fold(f64::NEG_INFINITY, f64::max);
        let known = if slowest > 0.0 {
            format!(
                "It is not to be expected that it attracts: the middle of the Jacobians of the distance over the region has an eigenvalue with the real part {}.",
                significant(slowest, 3)
            )
        } else {
            "Nothing is proved of its attractivity: check it by simulation.".to_owned()
        };
        format!("The manifold beta(y, chi) = phi(x) is invariant, and xhat = x on it. {known}")
    };
    let is_proved = evidence.is_empty();
    let numbers = vec![
        number("smallest ratio of distances under (phi, h)", report.injectivity.smallest_ratio),
        number("smallest singular value of D(phi, h)", report.injectivity.smallest_singular_value),
        number("sampled states", report.injectivity.points as f64),
    ];
    let report = DesignReport {
        statement,
        matrices,
        poles,
        numbers,
        facts: all,
        verdict: if is_proved { "proved" } else { "measured" }.to_owned(),
        evidence: (!is_proved).then(|| evidence.join("; ")),
        noise_deviation: Vec::new(),
    };
    let observer = ImmersionInvarianceObserver::new(model.clone(), maps.clone());
    Ok(Designed::new(Runnable::Immersion(Box::new(observer)), report, certificate))
}

/// What is known of the rank of D_chi beta.
#[derive(Clone, Copy)]
enum Rank {
    Proved,
    Measured(f64),
}

/// The rank of D_chi beta: of a constant matrix by its zeros, otherwise at the corners of the region.
fn rank(model: &Model, maps: &ImmersionMaps, region: &Region) -> Result<Rank, Misfit> {
    if has_pivots(maps) {
        return Ok(Rank::Proved);
    }
    let (mut least, mut largest, mut point) = (f64::INFINITY, 0.0_f64, Vec::new());
    for x in corners(region) {
        let y = model.output(0.0, &x, &DVector::zeros(maps.plant.inputs));
        let chi = Immersion::<f64>::start(maps, &x, &y);
        let values = maps.beta_jacobian(&chi, &y).columns(0, maps.order).into_owned().singular_values();
        // With fewer columns than rows there is no full row rank.
        let smallest = if maps.order < maps.rows() { 0.0 } else { values.min() };
        largest = largest.max(values.max());
        // Not a number is less than every number.
        if smallest.is_nan() || smallest < least {
            (least, point) = (smallest, x.as_slice().to_vec());
        }
    }
    if least > f64::EPSILON.sqrt() * largest {
        Ok(Rank::Measured(least))
    } else {
        Err(Misfit::Rank { needed: maps.rows(), smallest: least, point })
    }
}

/// Whether each row of D_chi beta has an entry that is a constant other than 0 and the only one of its column, for all
/// chi and y.
fn has_pivots(maps: &ImmersionMaps) -> bool {
    let anything = IntervalDual::new(Interval::UNBOUNDED, Interval::zero());
    let (chi, y) = (DVector::repeat(maps.order, anything), DVector::repeat(maps.plant.outputs, anything));
    let jacobian = maps.beta_jacobian(&chi, &y);
    let entry = |i: usize, j: usize| jacobian[(i, j)].value();
    let is_pivot = |i: usize, j: usize| {
        let own = entry(i, j);
        own.is_point()
            && own.is_bounded()
            && !own.is_zero()
            && (0..maps.rows()).all(|k| k == i || entry(k, j).is_zero())
    };
    (0..maps.rows()).all(|i| (0..maps.order).any(|j| is_pivot(i, j)))
}

/// The corners and the centre of a bounded region of states.
fn corners(region: &Region) -> Vec<DVector<f64>> {
    /// Corners of at most so many coordinates; the others are in the middle.
    const CORNERED: usize = 6;
    let states = region.states();
    let count = states.len().min(CORNERED);
    let middle = |k: usize| f64::midpoint(states[k].0, states[k].1);
    let mut all = vec![DVector::from_fn(states.len(), |k, _| middle(k))];
    for corner in 0..1usize << count {
        let end = |k: usize| if corner >> k & 1 == 1 { states[k].1 } else { states[k].0 };
        all.push(DVector::from_fn(states.len(), |k, _| if k < count { end(k) } else { middle(k) }));
    }
    all
}

/// The enclosure of `d K(phi^L(z, y))/dz` over the region and what is proved of it, or why there is none.
fn attractivity_over(
    model: &Model,
    maps: &ImmersionMaps,
    region: &Region,
) -> Result<Result<Attractivity, String>, Misfit> {
    if maps.rho.is_some() {
        return Ok(Err("rho moves beta beside phi(xhat)".to_owned()));
    }
    let plant = match model.expressions() {
        Ok(plant) => plant,
        Err(error) => return Ok(Err(error.to_string())),
    };
    let size = maps.plant;
    let wide = |(lo, hi): &(f64, f64)| Interval::of(*lo).hull(&Interval::of(*hi));
    let still = |x: Interval| IntervalDual::new(x, Interval::zero());
    let x = DVector::from_iterator(size.states, region.states().iter().map(|bounds| still(wide(bounds))));
    let bounds = region.input_bounds().unwrap_or_default();
    let u = DVector::from_iterator(size.inputs, bounds.iter().map(|bounds| still(wide(bounds))));
    let t = still(wide(&region.time_bounds()));
    // chi is not bounded by the region: D_y beta may not depend on it.
    let chi = DVector::repeat(maps.order, still(Interval::UNBOUNDED));
    let column = |j: usize| {
        let y: DVector<IntervalDual> = plant.output(t, &x, &u);
        let z = Immersion::<IntervalDual>::phi(maps, &x);
        let by_output = maps.beta_jacobian(&chi, &y).columns(maps.order, size.outputs).into_owned();
        let mut moving = z.clone();
        moving[j] = IntervalDual::new(z[j].value(), Interval::ONE);
        let estimate = Immersion::<IntervalDual>::left_inverse(maps, &moving, &y);
        let f: DVector<IntervalDual> = plant.derivative(t, &estimate, &u);
        let measured = plant.output_jacobian(t, &estimate, &u) * &f;
        (maps.phi_jacobian(&estimate) * &f - by_output * measured).as_slice().to_vec()
    };
    let found = attractivity(maps.rows(), column)?;
    Ok(found.map_err(|operation| format!("over the region there are no bounds of {operation}")))
}
