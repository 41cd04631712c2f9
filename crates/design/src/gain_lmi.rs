//! Gain by linear matrix inequality: one L and one P for one or several state matrices.
//!
//! `P > 0`, `A_k'P + P A_k - YC - C'Y' + 2 rate P < 0` for every k, `L = P^-1 Y`. Homogeneous in (P, Y): the solver
//! normalises them together.
//!
//! In discrete time `[factor^2 P, (P A_k - YC)'; *, P] > 0` for every k, which is `F_k'P F_k < factor^2 P` for
//! `F_k = A_k - LC` by the Schur complement.

use luenberger_lmi::{Problem, Solution, block, he};
use luenberger_plants::StateSpace;
use nalgebra::DMatrix;

use crate::check;
use crate::error::{DesignError, Pair};
use crate::gain_options::{Checked, GainOptions, NoiseUnits};

/// A gain with the Lyapunov matrix that came with it.
pub(crate) struct Gain {
    pub(crate) l: DMatrix<f64>,
    pub(crate) p: DMatrix<f64>,
}

/// L and P alone.
pub(crate) fn gain_by_lmi(plant: &StateSpace, rate: f64, options: &GainOptions) -> Result<Gain, DesignError> {
    Ok(solve(plant, std::slice::from_ref(&plant.a), rate, Problem::new(), options)?.0)
}

/// One L and one P for every state matrix in `vertices`, in addition to the constraints already in `lmi`.
pub(crate) fn solve(
    plant: &StateSpace,
    vertices: &[DMatrix<f64>],
    rate: f64,
    mut lmi: Problem,
    options: &GainOptions,
) -> Result<(Gain, Solution), DesignError> {
    check::plant(plant)?;
    check::rate(rate)?;
    let limits = options.check(plant.c.nrows())?;
    let units = NoiseUnits::of(&limits, vertices, &plant.c);
    let mut nearly = None;
    for (k, a) in vertices.iter().enumerate() {
        let seen = check::detectable(a, &plant.c, rate);
        nearly = match vertices {
            [_] => seen?,
            _ => seen.map_err(|error| error.of_pair(Pair::Vertex(k)))?.or(nearly),
        };
    }
    let scaled: Vec<DMatrix<f64>> = vertices.iter().map(|a| units.dynamics(a)).collect();
    let (seen, limits) = (units.outputs(&plant.c), limits.within(&units));
    pose(&mut lmi, scaled.iter().enumerate().map(|(k, a)| (k, a, &seen)), rate / units.time, &limits);
    let solution = lmi.solve_with(&options.settings)?;
    if solution.verdict.is_proved() {
        let Gain { l, p } = gain_of(&solution)?;
        Ok((Gain { l: units.gain_back(&l), p: units.lyapunov_back(&p) }, solution))
    } else {
        let what = if options.only_rate() { WHAT } else { within_limits(options) };
        Err(DesignError::not_proved(what, Some(solution.verdict)).with_seen(nearly))
    }
}

/// Asks `lmi` for one P and one Y for all pairs `(A_k, C_k)`, each given with the number k (from 0) of its vertex, at
/// least one, within `limits`.
pub(crate) fn pose<'a>(
    lmi: &mut Problem,
    vertices: impl Iterator<Item = (usize, &'a DMatrix<f64>, &'a DMatrix<f64>)>,
    rate: f64,
    limits: &Checked,
) {
    let mut unknowns = None;
    for (k, a, c) in vertices {
        let (p, y) = unknowns.get_or_insert_with(|| {
            let p = lmi.symmetric("P", a.nrows());
            let y = lmi.rectangular("Y", a.nrows(), c.nrows());
            lmi.constrain("P > 0", &p >> 0.0);
            limits.constrain(lmi, &p, &y, a.nrows(), c.nrows());
            (p, y)
        });
        let half = &*p * a - &*y * c;
        lmi.constrain(&decrease_at(k), (he(half.clone()) + (2.0 * rate) * &*p) << 0.0);
        limits.constrain_vertex(lmi, &decrease_at(k), half, y);
    }
}

/// L and P alone, in discrete time: `sqrt(e'Pe)` falls at each step by the factor, that of this rate.
pub(crate) fn gain_in_steps(
    plant: &StateSpace,
    (rate, factor): (f64, f64),
    options: &GainOptions,
) -> Result<Gain, DesignError> {
    check::plant(plant)?;
    let limits = options.check(plant.c.nrows())?;
    let units = NoiseUnits::of(&limits, std::slice::from_ref(&plant.a), &plant.c).in_steps();
    let nearly = check::detectable_in_steps(&plant.a, &plant.c, (rate, factor))?;
    let (a, c, limits) = (units.dynamics(&plant.a), units.outputs(&plant.c), limits.within(&units));
    let mut lmi = Problem::new();
    pose_in_steps(&mut lmi, std::iter::once((0, &a, &c)), c.shape(), factor * factor, &limits);
    let solution = lmi.solve_with(&options.settings)?;
    if solution.verdict.is_proved() {
        let Gain { l, p } = gain_of(&solution)?;
        return Ok(Gain { l: units.gain_back(&l), p: units.lyapunov_back(&p) });
    }
    let what = if options.only_rate() { WHAT_IN_STEPS } else { WHAT_IN_STEPS_WITHIN_LIMITS };
    Err(DesignError::not_proved(what, Some(solution.verdict)).with_seen(nearly))
}

/// As [`pose`] in discrete time, for the `square` of the factor and p outputs of n states.
pub(crate) fn pose_in_steps<'a>(
    lmi: &mut Problem,
    vertices: impl Iterator<Item = (usize, &'a DMatrix<f64>, &'a DMatrix<f64>)>,
    (outputs, n): (usize, usize),
    square: f64,
    limits: &Checked,
) {
    let (p, y) = (lmi.symmetric("P", n), lmi.rectangular("Y", n, outputs));
    lmi.constrain("P > 0", &p >> 0.0);
    limits.constrain(lmi, &p, &y, n, outputs);
    for (k, a, c) in vertices {
        let (corner, name) = (&p * a - &y * c, decrease_at(k));
        lmi.constrain(&name, block![[square * &p, corner.transpose()], [corner.clone(), &p]] >> 0.0);
        limits.constrain_vertex_in_steps(lmi, &name, corner, (&p, &y), (n, outputs));
    }
}

/// The name of the inequality of vertex k (from 0).
pub(crate) fn decrease_at(k: usize) -> String {
    format!("decrease at vertex {}", k + 1)
}

/// `L = P^-1 Y` and P from a solution of what [`pose`] asks.
pub(crate) fn gain_of(solution: &Solution) -> Result<Gain, DesignError> {
    let value = |name| solution.named(name).cloned().unwrap_or_else(|| DMatrix::zeros(0, 0));
    let p: DMatrix<f64> = value("P");
    let l = check::solve_definite("P", &p, &value("Y"))?;
    Ok(Gain { l, p })
}

/// The inequality with a bound of the gain or with noise. That it has no solution excludes no gain within a bound.
pub(crate) fn within_limits(options: &GainOptions) -> &'static str {
    if options.max_gain.is_some() {
        "P > 0, A'P + PA - YC - C'Y' + 2 rate P < 0 with the bound of the gain, for which it is sufficient but not necessary,"
    } else {
        "P > 0, A'P + PA - YC - C'Y' + 2 rate P < 0 with the bound of the gain and the noise asked for"
    }
}

pub(crate) const WHAT: &str = "P > 0, A'P + PA - YC - C'Y' + 2 rate P < 0";

const WHAT_IN_STEPS: &str = "[factor^2 P, A'P - C'Y'; *, P] > 0";

const WHAT_IN_STEPS_WITHIN_LIMITS: &str =
    "[factor^2 P, A'P - C'Y'; *, P] > 0 with the bound of the gain and the noise asked for";
