//! The residual `Dphi f - Lambda phi - B` of the equation (4) over a box: sampled, and enclosed.

use luenberger_proof::{Interval, Ring, UndecidedReason, Verdict};

use super::candidate::{Pieces, still};
use super::error::KklError;
use super::witness::{BoxPoint, ResidualWitness};
use crate::enclosure::IntervalDual;
use crate::enclosure::paths::{Undefined, explore};
use crate::symbolic_polynomial::{Arena, Polynomial, SymbolicPolynomial, collect, evaluate, sum};

/// The residual over the box.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// Among the samples, the point and the row with the largest residual relative to its terms.
    pub worst: ResidualWitness,
    /// For each row, the largest of `|Dphi f| + |Lambda| |phi| + |B|` over the sampled points.
    pub scales: Vec<f64>,
    /// For each row, a number that the magnitude of the residual nowhere in the box exceeds: proved, infinite where
    /// nothing is.
    pub bounds: Vec<f64>,
    /// Whether the two sides could be collected before they were enclosed; else what stood in the way.
    pub collected: Result<(), &'static str>,
    /// Whether phi is known to be continuous on the box: it has a collected form, or leaves no comparison open. Where
    /// it jumps, `Dphi f` does not tell how phi moves.
    pub continuous: bool,
    /// Points sampled.
    pub points: usize,
    /// Of how many parts of the box the bounds are the largest.
    pub parts: usize,
    /// `|residual| <= tolerance scale` in every row and on the whole box.
    pub verdict: Verdict<ResidualWitness>,
}

/// One row over one box.
#[derive(Clone, Copy)]
struct Row {
    residual: Interval,
    scale: f64,
}

/// Every row of the residual over one box.
fn over<C: Pieces<IntervalDual>>(candidate: &C, cell: &[Interval]) -> Result<Vec<Row>, Undefined> {
    let size = candidate.plant_dimensions();
    let still = |x: &Interval| IntervalDual::new(*x, Interval::zero());
    let ways = explore(|| {
        let (x, u): (Vec<_>, Vec<_>) = (
            cell[..size.states].iter().map(still).collect(),
            cell[size.states..][..size.inputs].iter().map(still).collect(),
        );
        let time = cell[size.states + size.inputs];
        let field = candidate.field(still(&time), &x, &u);
        let moving: Vec<_> = x.iter().zip(&field).map(|(x, f)| IntervalDual::new(x.value(), f.value())).collect();
        let t = IntervalDual::new(time, Interval::ONE);
        let phi = candidate.image(t, &moving, &candidate.output(t, &moving));
        // The right-hand side needs no derivatives.
        let xi: Vec<_> = phi.iter().map(|phi| still(&phi.value())).collect();
        let (t, y) = (still(&time), candidate.output(still(&time), &x));
        let (lambda, injection) = (candidate.lambda(t, &u, &y), candidate.injection(t, &xi, &u, &y));
        let order = xi.len();
        if field.len() != size.states || lambda.len() != order * order || injection.len() != order {
            return None;
        }
        let rows = (0..order)
            .map(|i| {
                let (mut side, mut scale) = (injection[i].value(), injection[i].value().magnitude());
                for (j, xi) in xi.iter().enumerate() {
                    let term = lambda[j * order + i].value().mul(&xi.value());
                    side = side.add(&term);
                    scale += term.magnitude();
                }
                Row { residual: phi[i].slope().sub(&side), scale: scale + phi[i].slope().magnitude() }
            })
            .collect::<Vec<_>>();
        Some(rows)
    })?;
    let ways: Option<Vec<Vec<Row>>> = ways.into_iter().collect();
    let united = ways.and_then(|ways| {
        ways.into_iter().reduce(|mut rows, way| {
            for (row, other) in rows.iter_mut().zip(&way) {
                *row = Row { residual: row.residual.hull(&other.residual), scale: row.scale.max(other.scale) };
            }
            rows
        })
    });
    united.ok_or(Undefined::Operation("a column of the length that it should have"))
}

/// The rows of the residual, collected, with the arena of their atoms.
fn collected<C: Pieces<SymbolicPolynomial>>(candidate: &C) -> Result<(Vec<Polynomial>, Arena), &'static str> {
    let size = candidate.plant_dimensions();
    let (first, last) = (size.states, size.states + size.inputs);
    let (found, mut arena) = collect(|| {
        let variables: Vec<SymbolicPolynomial> = (0..=last).map(SymbolicPolynomial::variable).collect();
        let (x, u, t) = (&variables[..first], &variables[first..last], variables[last]);
        let y = candidate.output(t, x);
        let phi = candidate.image(t, x, &y);
        let (lambda, injection) = (candidate.lambda(t, u, &y), candidate.injection(t, &phi, u, &y));
        let order = phi.len();
        if lambda.len() != order * order || injection.len() != order {
            return None;
        }
        let sides: Vec<SymbolicPolynomial> = (0..order)
            .map(|i| (0..order).fold(injection[i], |side, j| side + lambda[j * order + i] * phi[j]))
            .collect();
        Some((candidate.field(t, x, u), phi, sides))
    })?;
    let (field, phi, sides) = found.ok_or("columns of another length")?;
    let mut along = arena.polynomials(&field)?;
    along.resize(last, Vec::new());
    along.push(vec![(Vec::new(), Interval::ONE)]);
    let (phi, sides) = (arena.polynomials(&phi)?, arena.polynomials(&sides)?);
    let rows = phi.iter().zip(&sides).map(|(phi, side)| {
        let lie = arena.along(phi, &along);
        sum(&lie, side, true)
    });
    let rows = rows.collect();
    arena.failed().map_or(Ok((rows, arena)), Err)
}

/// The numbers beside x and those between, as far as they belong to the axis.
fn neighbours(x: &Interval, axis: &Interval) -> Interval {
    Interval::new(x.lo().next_down(), x.hi().next_up()).and_then(|around| around.intersection(axis)).unwrap_or(*x)
}

/// A part of the box, with the bounds of the rows on it.
struct Part {
    axes: Vec<Interval>,
    bounds: Vec<f64>,
}

/// Samples at `points`, bounds over `axes` with `budget` bisections.
pub(super) fn residual<C: Pieces<IntervalDual> + Pieces<SymbolicPolynomial>>(
    candidate: &C,
    (points, axes): (&[Vec<Interval>], &[Interval]),
    tolerance: f64,
    budget: usize,
) -> Result<Residual, KklError> {
    let size = Pieces::<IntervalDual>::plant_dimensions(candidate);
    let place = |point: &[Interval]| BoxPoint::of(point, size);
    let mut samples = Vec::with_capacity(points.len());
    for point in points {
        // The residual is continuous where phi is smooth, and a comparison with the very number of a sample tells
        // nothing of the derivative there.
        let around: Vec<Interval> = point.iter().zip(axes).map(|(x, axis)| neighbours(x, axis)).collect();
        let undefined = |operation| {
            let BoxPoint { state, input, .. } = place(point);
            KklError::Undefined { operation, state, input }
        };
        let rows = over(candidate, &around).map_err(|why| match why {
            Undefined::Operation(operation) => undefined(operation),
            Undefined::TooManyBranches => undefined("a choice of more than 64 branches"),
        })?;
        if rows.iter().any(|row| !row.residual.is_bounded() || !row.scale.is_finite()) {
            return Err(undefined("a value beyond the range of numbers"));
        }
        samples.push(rows);
    }
    let order = samples.first().map_or(0, Vec::len);
    let scales: Vec<f64> =
        (0..order).map(|row| samples.iter().map(|rows| rows[row].scale).fold(0.0, f64::max)).collect();
    let mut worst =
        ResidualWitness { row: 0, at_least: 0.0, scale: scales.first().copied().unwrap_or(0.0), place: place(axes) };
    let mut greatest = -1.0;
    for (rows, point) in samples.iter().zip(points) {
        for (row, found) in rows.iter().enumerate() {
            let at_least = found.residual.lo().max(-found.residual.hi()).max(0.0);
            let share = if at_least > 0.0 { at_least / scales[row] } else { 0.0 };
            if share > greatest {
                greatest = share;
                worst = ResidualWitness { row, at_least, scale: scales[row], place: place(point) };
            }
        }
    }
    let (form, collected) = match collected(candidate) {
        Ok(form) => (Some(form), Ok(())),
        Err(what) => (None, Err(what)),
    };
    let part = |axes: Vec<Interval>| {
        let direct = over(candidate, &axes);
        let atoms = form.as_ref().and_then(|(_, arena)| arena.atoms_over(&axes));
        let bounds = (0..order)
            .map(|row| {
                let direct = direct.as_ref().map_or(f64::INFINITY, |rows| rows[row].residual.magnitude());
                let collected = form.as_ref().zip(atoms.as_ref()).and_then(|((rows, _), atoms)| {
                    rows.get(row).and_then(|row| evaluate(row, atoms)).map(|residual| residual.magnitude())
                });
                direct.min(collected.unwrap_or(f64::INFINITY))
            })
            .collect();
        Part { axes, bounds }
    };
    let allowed: Vec<f64> = scales.iter().map(|scale| tolerance * scale).collect();
    // How far a part is from what is asked for: 1 or less is enough.
    let excess = |part: &Part| {
        let shares =
            part.bounds.iter().zip(&allowed).map(|(bound, allowed)| if *bound == 0.0 { 0.0 } else { bound / allowed });
        shares.fold(0.0, f64::max)
    };
    let mut parts = vec![part(axes.to_vec())];
    let refuted = worst.at_least > tolerance * worst.scale;
    for _ in 0..if refuted { 0 } else { budget } {
        let Some(at) = (0..parts.len()).max_by(|&i, &j| excess(&parts[i]).total_cmp(&excess(&parts[j]))) else { break };
        if excess(&parts[at]) <= 1.0 {
            break;
        }
        let Some([first, second]) = halves(&parts[at].axes, axes) else { break };
        parts[at] = part(first);
        parts.push(part(second));
    }
    let bounds: Vec<f64> =
        (0..order).map(|row| parts.iter().map(|part| part.bounds[row]).fold(0.0, f64::max)).collect();
    let room = bounds.iter().zip(&allowed).map(|(bound, allowed)| allowed - bound).fold(f64::INFINITY, f64::min);
    let verdict = if refuted {
        Verdict::Refuted { witness: worst.clone() }
    } else if room >= 0.0 {
        Verdict::Proved { margin: room }
    } else {
        let width = bounds.iter().copied().fold(0.0, f64::max);
        Verdict::Undecided { why: UndecidedReason::DataTooUncertain { width }, best: -worst.at_least }
    };
    let is_unbranched = || {
        let (x, _, t) = still(axes, size);
        explore(|| candidate.image(t, &x, &candidate.output(t, &x))).is_ok_and(|ways| ways.len() == 1)
    };
    let continuous = collected.is_ok() || is_unbranched();
    Ok(Residual { worst, scales, bounds, collected, continuous, points: points.len(), parts: parts.len(), verdict })
}

/// The two halves along the coordinate that is widest as a share of the box; none where nothing can be halved.
fn halves(axes: &[Interval], whole: &[Interval]) -> Option<[Vec<Interval>; 2]> {
    let share = |k: usize| axes[k].width() / whole[k].width();
    let k = (0..axes.len())
        .filter(|&k| whole[k].is_bounded() && axes[k].width() > 0.0)
        .max_by(|&i, &j| share(i).total_cmp(&share(j)))?;
    let (lo, hi) = (axes[k].lo(), axes[k].hi());
    let middle = lo / 2.0 + hi / 2.0;
    if !(lo < middle && middle < hi) {
        return None;
    }
    let half = |lo, hi| {
        let mut half = axes.to_vec();
        half[k] = Interval::new(lo, hi)?;
        Some(half)
    };
    Some([half(lo, middle)?, half(middle, hi)?])
}
