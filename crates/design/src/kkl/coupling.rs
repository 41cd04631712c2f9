//! Dependence of the injection B on xi, and whether the errors of the entries decay in cascade.
//!
//! With `xi' = Lambda xi + B(t, xi, u, y)` and a phi that solves (4), the error `e = xi - phi(x)` obeys
//! ```text
//!     e' = Lambda e + B(t, phi + e, u, y) - B(t, phi, u, y)
//! ```
//! and Lambda alone decides only if B does not depend on xi: `Lambda = -1, B = 2 xi` is `xi' = xi`. Proved here:
//! - B_i reads xi_j for `j < i` only, for all xi and over the box of states, inputs and times;
//! - Lambda and B have no way from entry i back to an entry that B_i reads, and none of these is only integrated;
//! - B is Lipschitz in the entries that it reads, on every bounded set of xi and there uniformly over the box.
//!
//! Then the blocks of entries that Lambda couples in both directions form a cascade, and B acts from earlier blocks on
//! later ones only. If `e' = Lambda e` decays exponentially, so does each block on its own; the first has no other
//! input, and each later one has inputs that decay. Hence e decays exponentially from every start, with a factor that
//! depends on the start where B is Lipschitz on bounded sets only.
//!
//! Method: derivatives by xi_j over intervals with unbounded xi: if a derivative is 0 on every path through the
//! branches, and no branch condition depends on xi_j, then B does not depend on xi_j; alternatively the collected form
//! of B, in which terms cancel. Either is sufficient. Both hold for xi for which B is defined.

use luenberger_plants::Dimensions;
use luenberger_proof::{Interval, Matrix, Ring, UndecidedReason, Verdict};

use super::candidate::{Pieces, still};
use super::witness::{BoxPoint, CouplingObjection, CouplingWitness, OpenCoupling};
use crate::enclosure::IntervalDual;
use crate::enclosure::paths::{explore, steered};
use crate::symbolic_polynomial::{SymbolicPolynomial, collect};

/// Dependence of B on xi.
#[derive(Clone, Debug, PartialEq)]
pub struct Coupling {
    /// The pairs (i, j), from 0, for which `B_i` was not shown to be independent of `xi_j`.
    pub reads: Vec<(usize, usize)>,
    /// The first pair that violates the condition; none if the verdict is `Proved`.
    pub objection: Option<OpenCoupling>,
    /// B leaves the decay of the errors to Lambda. `Proved` has an infinite margin: the statement is one of structure.
    /// `Refuted`: B_i reads xi_j with `j >= i`, which is not what a [`KklMap`](luenberger_observers::KklMap) may do;
    /// whether the observer converges in spite of it is not said.
    pub verdict: Verdict<CouplingWitness>,
}

/// How an entry of B depends on an entry of xi.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Dependence {
    None,
    /// On every bounded set of xi.
    Lipschitz,
    Unknown,
}

/// What is known of B over the box `axes`; `lambda` and the entries that are `integrated` belong to Lambda over the
/// same box.
pub(super) fn coupling<C: Pieces<IntervalDual> + Pieces<SymbolicPolynomial>>(
    candidate: &C,
    (lambda, integrated): (&Matrix<Interval>, &[usize]),
    (points, axes): (&[Vec<Interval>], &[Interval]),
) -> Coupling {
    let (order, size) = (lambda.rows(), Pieces::<IntervalDual>::plant_dimensions(candidate));
    let form = collected(candidate, order, size, axes);
    let by_slopes: Vec<Vec<Dependence>> = (0..order).map(|j| along(candidate, order, size, axes, j)).collect();
    let known = |i: usize, j: usize| form.as_ref().map_or(by_slopes[j][i], |form| form[i][j].min(by_slopes[j][i]));
    let pairs = (0..order).flat_map(|i| (0..order).map(move |j| (i, j)));
    let reads: Vec<(usize, usize)> = pairs.filter(|&(i, j)| known(i, j) != Dependence::None).collect();
    let back = ways(order, |i, j| !lambda[(i, j)].is_zero() || reads.contains(&(i, j)));
    let objection_to = |&(row, entry): &(usize, usize)| {
        let why = if entry >= row {
            CouplingObjection::NotEarlier
        } else if integrated.contains(&entry) {
            CouplingObjection::Integrated
        } else if back[row][entry] {
            CouplingObjection::WayBack
        } else if known(row, entry) == Dependence::Unknown {
            CouplingObjection::NotLipschitz
        } else {
            return None;
        };
        Some(OpenCoupling { row, entry, why })
    };
    let objections: Vec<OpenCoupling> = reads.iter().filter_map(objection_to).collect();
    let mut forbidden = objections.iter().filter(|objection| objection.why == CouplingObjection::NotEarlier);
    let verdict = match forbidden.find_map(|objection| shown(candidate, objection, points, size)) {
        Some(witness) => Verdict::Refuted { witness },
        None if objections.is_empty() => Verdict::Proved { margin: f64::INFINITY },
        None => Verdict::Undecided { why: UndecidedReason::DataTooUncertain { width: f64::INFINITY }, best: f64::NAN },
    };
    let objection = match &verdict {
        Verdict::Refuted { witness: CouplingWitness { row, entry, .. } } => {
            Some(OpenCoupling { row: *row, entry: *entry, why: CouplingObjection::NotEarlier })
        }
        _ => objections.first().copied(),
    };
    Coupling { reads, objection, verdict }
}

/// From which entry there is a way to which, `acts(i, j)` meaning that j acts on i.
fn ways(order: usize, acts: impl Fn(usize, usize) -> bool) -> Vec<Vec<bool>> {
    let mut way: Vec<Vec<bool>> = (0..order).map(|j| (0..order).map(|i| acts(i, j)).collect()).collect();
    for through in 0..order {
        let onwards = way[through].clone();
        for from in way.iter_mut().filter(|from| from[through]) {
            from.iter_mut().zip(&onwards).for_each(|(to, onwards)| *to |= onwards);
        }
    }
    way
}

/// How the entries of B depend on xi_j, by intervals.
fn along<C: Pieces<IntervalDual>>(
    candidate: &C,
    order: usize,
    size: Dimensions,
    axes: &[Interval],
    j: usize,
) -> Vec<Dependence> {
    let (x, u, t) = still(axes, size);
    let found = explore(|| {
        let moving = |k| if k == j { Interval::ONE } else { Interval::zero() };
        let xi: Vec<_> = (0..order).map(|k| IntervalDual::new(Interval::UNBOUNDED, moving(k))).collect();
        let slopes: Vec<Interval> =
            candidate.injection(t, &xi, &u, &candidate.output(t, &x)).iter().map(IntervalDual::slope).collect();
        (slopes, steered())
    });
    let Ok(found) = found else { return vec![Dependence::Unknown; order] };
    let all = |i: usize, holds: fn(&Interval) -> bool| {
        found.iter().all(|(slopes, steered)| !steered && slopes.get(i).is_some_and(holds))
    };
    let of = |i| match () {
        () if all(i, Ring::is_zero) => Dependence::None,
        () if all(i, Interval::is_bounded) => Dependence::Lipschitz,
        () => Dependence::Unknown,
    };
    (0..order).map(of).collect()
}

/// How the entries of B depend on those of xi, by its collected form.
fn collected<C: Pieces<IntervalDual> + Pieces<SymbolicPolynomial>>(
    candidate: &C,
    order: usize,
    size: Dimensions,
    axes: &[Interval],
) -> Option<Vec<Vec<Dependence>>> {
    let first = axes.len();
    let (b, arena) = collect(|| {
        let variables: Vec<SymbolicPolynomial> = (0..first + order).map(SymbolicPolynomial::variable).collect();
        let (x, u, t) = (&variables[..size.states], &variables[size.states..][..size.inputs], variables[first - 1]);
        candidate.injection(t, &variables[first..], u, &candidate.output(t, x))
    })
    .ok()?;
    let b = arena.polynomials(&b).ok().filter(|b| b.len() == order)?;
    // Smooth for all xi means Lipschitz where xi is bounded. The observer's xi is, where phi is.
    let mut boxed = axes.to_vec();
    boxed.resize(first + order, Interval::UNBOUNDED);
    let smooth = arena.atoms_over(&boxed).is_some_and(|atoms| arena.roots_are_smooth(|k| k >= first, &atoms));
    let (x, _, t) = still(axes, size);
    let phi = explore(|| candidate.image(t, &x, &candidate.output(t, &x))).unwrap_or_default();
    let bounded = |j: usize| {
        !phi.is_empty() && phi.iter().all(|phi| phi.get(j).is_some_and(|phi: &IntervalDual| phi.value().is_bounded()))
    };
    let rows = b.iter().map(|row| {
        let variables = arena.variables(row);
        let uniform = variables.iter().all(|&k| if k < first { axes[k].is_bounded() } else { bounded(k - first) });
        let of = |j| match variables.contains(&(first + j)) {
            false => Dependence::None,
            true if smooth && uniform => Dependence::Lipschitz,
            true => Dependence::Unknown,
        };
        (0..order).map(of).collect()
    });
    Some(rows.collect())
}

/// A point around which the derivative of B by the entry of xi is proved not to be 0.
fn shown<C: Pieces<IntervalDual>>(
    candidate: &C,
    objection: &OpenCoupling,
    points: &[Vec<Interval>],
    size: Dimensions,
) -> Option<CouplingWitness> {
    let OpenCoupling { row, entry, .. } = *objection;
    points.iter().find_map(|point| {
        let (x, u, t) = still(point, size);
        let phi = explore(|| candidate.image(t, &x, &candidate.output(t, &x))).ok()?.into_iter().next()?;
        let phi: Vec<f64> = phi.iter().map(|phi| Some(phi.value().midpoint_radius()?.0)).collect::<Option<_>>()?;
        // At xi = phi, and beside it.
        [0.0, 1.0].into_iter().find_map(|shift| {
            let xi: Vec<f64> = phi.iter().map(|phi| phi + shift).collect();
            // An interval, lest a comparison with this very number decides.
            let around = Interval::around(xi[entry], f64::EPSILON * (1.0 + xi[entry].abs()))?;
            let moving: Vec<IntervalDual> = xi
                .iter()
                .enumerate()
                .map(|(k, xi)| {
                    if k == entry {
                        IntervalDual::new(around, Interval::ONE)
                    } else {
                        IntervalDual::new(Interval::of(*xi), Interval::zero())
                    }
                })
                .collect();
            let found = explore(|| candidate.injection(t, &moving, &u, &candidate.output(t, &x))).ok()?;
            let [only] = found.as_slice() else { return None };
            let slope = only.get(row)?.slope();
            (!slope.contains(0.0)).then(|| CouplingWitness { row, entry, slope, place: BoxPoint::of(point, size), xi })
        })
    })
}
