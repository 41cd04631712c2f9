//! Cut-off frequency, grid and escape of a numerical KKL observer, found by trying designs on coarse grids.
//!
//! T is smooth enough for a table only if the filter is faster than the plant expands backward in time, and the error
//! of the left inverse grows when it is much faster; where between is not known beforehand. The search is
//! deterministic:
//!
//! 1. *Escape.* The plant is not slowed, unless a trajectory from a grid of the box escapes backward in time within the
//!    memory of the slowest candidate, or one of a later design does: then it is slowed over one half-width.
//! 2. *Candidates.* The rate of the plant is the median of the norm of its Jacobian over a grid of the box, with the
//!    states in half-widths. The candidates are the rate times 1/2, 1, 2, 4, 8, 16.
//! 3. *Stages.* All candidates are designed on the coarsest grid, the best three on the next one, the best two on the
//!    finest. The error of a candidate is that of the interpolated left inverse at points that were not used in the
//!    fit: the root mean square, in half-widths, of the state where it is largest.
//! 4. *Choice.* After the first stage at which a candidate has at most the wanted error, the slowest such candidate: it
//!    amplifies noise least. Without one, the smallest error of all.
//!
//! What is given is not searched. At most eleven designs.

use luenberger_plants::Differentiable;
use luenberger_wording::setters;
use nalgebra::{Const, SVector};

use super::progress::Listener;
use super::{Domain, Escape, NumericalKklDesign, NumericalKklError, Settings, Spline, Table, TargetSystem, Transform};

/// The given parameters of a design, and the target error for those to be found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChoiceOptions {
    /// The cut-off frequency of the Bessel filter; none to search it.
    pub cutoff: Option<f64>,
    /// Grid points per axis; none to search them.
    pub points: Option<usize>,
    /// What the plant does outside the box; none to search it.
    pub escape: Option<Escape>,
    /// The root mean square error of a state that is small enough, in half-widths of the box (default 1e-4).
    pub error: f64,
}

impl Default for ChoiceOptions {
    fn default() -> Self {
        Self { cutoff: None, points: None, escape: None, error: 1e-4 }
    }
}

impl ChoiceOptions {
    setters! { cutoff: f64, points: usize, escape: Escape, error: f64 }
}

/// A design that was tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The cut-off frequency.
    pub cutoff: f64,
    /// Grid points per axis.
    pub points: usize,
    /// The error, as in [`ChoiceOptions::error`], or why there is no design.
    pub outcome: Result<f64, NumericalKklError>,
}

/// The choice, with all designs that were tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The cut-off frequency.
    pub cutoff: f64,
    /// Grid points per axis.
    pub points: usize,
    /// What the plant does outside the box.
    pub escape: Escape,
    /// The rate of the plant, from which the candidates follow; none where the cut-off was given.
    pub rate: Option<f64>,
    /// The designs, in the order in which they were tried; none where cut-off and points were given.
    pub candidates: Vec<Candidate>,
    /// Whether the wanted error was reached on a coarse design.
    pub is_reached: bool,
}

/// The candidates, as multiples of the rate of the plant.
const MULTIPLES: [f64; 6] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// How many candidates are tried at each stage.
const KEPT: [usize; 3] = [MULTIPLES.len(), 3, 2];

/// Width of the layer in which a plant is slowed down, in half-widths.
const MARGIN: f64 = 1.0;

/// Grid points per axis at each stage.
fn grids(states: usize) -> [usize; 3] {
    match states {
        ..=2 => [33, 65, 97],
        3 => [17, 25, 33],
        _ => [9, 13, 17],
    }
}

/// Grid points per axis of the designs that [`choose`] tries at most, for an estimate of the time it takes; none where
/// cut-off and points are given.
pub fn searched_tables(cutoff: Option<f64>, points: Option<usize>, states: usize) -> Vec<usize> {
    let stages = points.map_or_else(|| grids(states).to_vec(), |points| vec![points]);
    let count = |kept: usize| if cutoff.is_some() { 1 } else { kept };
    stages.into_iter().zip(KEPT).flat_map(|(points, kept)| core::iter::repeat_n(points, count(kept))).collect()
}

/// Searches for the parameters that are not given, for a plant with one output and a Bessel filter of order Z. The
/// escape is that of the options, not that of `domain`.
///
/// ```
/// use luenberger_design::numerical_kkl::{ChoiceOptions, Domain, Escape, Settings, choose};
/// use luenberger_plants::VanDerPol;
/// use nalgebra::SVector;
/// use std::ops::ControlFlow::Continue;
/// let settings = Settings { samples: 300, leaves: 1, injectivity_points: 5, held_out: 40, ..Settings::default() };
/// let domain = Domain::new([-2.3, -3.0], [2.3, 3.0], Escape::Free)?;
/// let wanted = ChoiceOptions { points: Some(17), ..ChoiceOptions::default() };
/// let choice = choose::<_, 2, 0, 3>(&VanDerPol::default(), &domain, SVector::zeros(), &wanted, &settings, &mut |_| Continue(()))?;
/// // Its past is unbounded, and its cycle contracts at the rate 1.06: slow filters are refused.
/// assert!(choice.cutoff > 4.0 && choice.candidates[0].outcome.is_err());
/// # Ok::<(), luenberger_design::numerical_kkl::NumericalKklError>(())
/// ```
/// # Errors
/// As [`NumericalKklDesign::new`] for the box, the settings, and `progress`; [`NumericalKklError::NoneFits`] if no
/// candidate has a design.
pub fn choose<S, const N: usize, const M: usize, const Z: usize>(
    plant: &S,
    domain: &Domain<N>,
    input: SVector<f64, M>,
    wanted: &ChoiceOptions,
    settings: &Settings<N>,
    progress: &mut Listener<'_>,
) -> Result<Choice, NumericalKklError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<1>>,
{
    choose_with_table::<S, Spline<N, Z>, N, M, Z>(plant, domain, input, wanted, settings, progress)
}

/// As [`choose`], for designs with the table `W`.
///
/// # Errors
/// As [`choose`].
pub fn choose_with_table<S, W, const N: usize, const M: usize, const Z: usize>(
    plant: &S,
    domain: &Domain<N>,
    input: SVector<f64, M>,
    wanted: &ChoiceOptions,
    settings: &Settings<N>,
    progress: &mut Listener<'_>,
) -> Result<Choice, NumericalKklError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<1>>,
    W: Table<N, Z>,
{
    let domain = domain.escaping(wanted.escape.unwrap_or(Escape::Free))?;
    let rate = if wanted.cutoff.is_none() { Some(rate(plant, &domain, &input)?) } else { None };
    let mut cutoffs: Vec<f64> = match (wanted.cutoff, rate) {
        (Some(cutoff), _) => vec![cutoff],
        (None, rate) => MULTIPLES.iter().map(|multiple| multiple * rate.unwrap_or(1.0)).collect(),
    };
    let slowest = cutoffs.iter().copied().fold(f64::INFINITY, f64::min);
    let mut escape = match wanted.escape {
        Some(escape) => escape,
        None if escapes::<S, N, M, Z>(plant, &domain, slowest, input, settings)? => Escape::Slowed { margin: MARGIN },
        None => Escape::Free,
    };
    if let (Some(cutoff), Some(points)) = (wanted.cutoff, wanted.points) {
        return Ok(Choice { cutoff, points, escape, rate, candidates: Vec::new(), is_reached: true });
    }
    let stages: Vec<usize> = wanted.points.map_or_else(|| grids(N).to_vec(), |points| vec![points]);
    let mut candidates: Vec<Candidate> = Vec::new();
    for (&points, kept) in stages.iter().zip(KEPT) {
        // The order of the errors so far; what has no design comes last, the fastest of it first.
        if !candidates.is_empty() {
            let error = |cutoff: &f64| {
                let last = candidates.iter().rev().find(|candidate| candidate.cutoff == *cutoff);
                last.and_then(|candidate| candidate.outcome.as_ref().ok()).copied().unwrap_or(f64::INFINITY)
            };
            cutoffs.sort_by(|a, b| error(a).total_cmp(&error(b)).then(b.total_cmp(a)));
            cutoffs.truncate(kept);
        }
        let mut reached: Option<f64> = None;
        for &cutoff in &cutoffs {
            let mut attempt = |escape| {
                let domain = domain.escaping(escape)?;
                error_of::<S, W, N, M, Z>(plant, &domain, (cutoff, points), input, settings, progress)
            };
            let mut outcome = attempt(escape);
            if let (Err(NumericalKklError::Escapes { .. }), None, Escape::Free) = (&outcome, wanted.escape, escape) {
                escape = Escape::Slowed { margin: MARGIN };
                outcome = attempt(escape);
            }
            if let Err(error @ (NumericalKklError::Stopped { .. } | NumericalKklError::GridTooLarge { .. })) = outcome {
                return Err(error);
            }
            if outcome.as_ref().is_ok_and(|error| *error <= wanted.error) {
                reached = Some(reached.map_or(cutoff, |other: f64| other.min(cutoff)));
            }
            candidates.push(Candidate { cutoff, points, outcome });
        }
        if let Some(cutoff) = reached {
            return Ok(Choice { cutoff, points, escape, rate, candidates, is_reached: true });
        }
    }
    let error = |candidate: &Candidate| candidate.outcome.as_ref().ok().copied();
    let best = candidates.iter().filter(|candidate| error(candidate).is_some());
    let best = best.min_by(|a, b| {
        a.outcome.as_ref().ok().partial_cmp(&b.outcome.as_ref().ok()).unwrap_or(core::cmp::Ordering::Equal)
    });
    match best {
        Some(&Candidate { cutoff, points, .. }) => {
            Ok(Choice { cutoff, points, escape, rate, candidates, is_reached: false })
        }
        None => Err(none_fits(candidates)),
    }
}

/// Whether a trajectory from a grid of the box escapes backward in time.
fn escapes<S, const N: usize, const M: usize, const Z: usize>(
    plant: &S,
    domain: &Domain<N>,
    cutoff: f64,
    input: SVector<f64, M>,
    settings: &Settings<N>,
) -> Result<bool, NumericalKklError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<1>>,
{
    let target = TargetSystem::<1, Z>::bessel(cutoff)?;
    let transform = Transform::new(plant, &target, domain, input, settings.tolerance)?;
    let is_unbounded = |x: &SVector<f64, N>| {
        // A trajectory that no step can follow escapes in finite time.
        matches!(
            transform.at(x),
            Err(NumericalKklError::Escapes { .. }
                | NumericalKklError::Stalled { .. }
                | NumericalKklError::NotFinite { .. })
        )
    };
    Ok(grid(domain).iter().any(is_unbounded))
}

/// Five points per axis, three for more than four states.
fn grid<const N: usize>(domain: &Domain<N>) -> Vec<SVector<f64, N>> {
    domain.grid(if N > 4 { 3 } else { 5 })
}

/// The error of the candidate that came furthest: the last one.
fn none_fits(mut candidates: Vec<Candidate>) -> NumericalKklError {
    let tried = candidates.len();
    let all = || candidates.iter().map(|candidate| candidate.cutoff);
    let (slowest, fastest) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
    match candidates.pop() {
        // A single design, as if it had been asked for.
        Some(Candidate { outcome: Err(error), .. }) if tried == 1 => error,
        Some(Candidate { points, outcome: Err(error), .. }) => {
            NumericalKklError::NoneFits { tried, slowest, fastest, points, last: Box::new(error) }
        }
        _ => NumericalKklError::NoneFits {
            tried,
            slowest,
            fastest,
            points: 0,
            last: Box::new(NumericalKklError::Unresolved { error: f64::NAN, most: super::UNRESOLVED }),
        },
    }
}

/// The error of a coarse design.
fn error_of<S, W, const N: usize, const M: usize, const Z: usize>(
    plant: &S,
    domain: &Domain<N>,
    (cutoff, points): (f64, usize),
    input: SVector<f64, M>,
    settings: &Settings<N>,
    progress: &mut Listener<'_>,
) -> Result<f64, NumericalKklError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<1>>,
    W: Table<N, Z>,
{
    let coarse = Settings {
        points: [points; N],
        leaves: settings.leaves.min(16),
        samples: settings.samples.min(4000),
        injectivity_points: settings.injectivity_points.min(9),
        held_out: settings.held_out.min(200),
        ..*settings
    };
    let target = TargetSystem::<1, Z>::bessel(cutoff)?;
    let design = NumericalKklDesign::<N, M, 1, Z, W>::with_table(plant, &target, domain, input, &coarse, progress)?;
    let error = design.report.interpolated.rmse.component_div(&domain.half_width()).max();
    if error.is_finite() { Ok(error) } else { Err(NumericalKklError::Unresolved { error, most: super::UNRESOLVED }) }
}

/// The median of the Frobenius norm of the Jacobian over a grid, states in half-widths.
fn rate<S, const N: usize, const M: usize>(
    plant: &S,
    domain: &Domain<N>,
    input: &SVector<f64, M>,
) -> Result<f64, NumericalKklError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<1>>,
{
    let half = domain.half_width();
    let mut norms = Vec::new();
    for x in grid(domain) {
        let mut square = 0.0;
        for j in 0..N {
            let direction = SVector::from_fn(|i, _| if i == j { half[j] } else { 0.0 });
            let (_, slope) = plant.directional(0.0, &x, input, &direction);
            square += slope.component_div(&half).norm_squared();
        }
        if !square.is_finite() {
            return Err(NumericalKklError::NotFinite { from: x.iter().copied().collect(), time: 0.0 });
        }
        norms.push(square.sqrt());
    }
    norms.sort_by(f64::total_cmp);
    // A plant that stands still has no rate, and any filter will do.
    Ok(norms.get(norms.len() / 2).copied().filter(|rate| *rate > 0.0).unwrap_or(1.0))
}
