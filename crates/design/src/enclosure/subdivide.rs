//! Bisection of the box: first until every part has a finite enclosure, then where an entry attains its extremes.

use std::collections::BTreeMap;

use luenberger_plants::{Dimensions, Plant};
use luenberger_proof::certificate::{Certificate, ProvedSentence, Reading, Represented};
use luenberger_proof::{Interval, Matrix};

use super::branches::{Branches, Gap};
use super::error::EnclosureError;
use super::evaluation::{Evaluation, Failure, Sides, middle};
use super::paths::{Undefined, explore};
use super::place::{Axis, Entry, Place};
use super::region::Region;
use super::scalar::IntervalDual;

/// How often one coordinate is halved in search of a finite enclosure: a part that is 2^-48 of the box names its point
/// well enough.
const HALVINGS: u32 = 48;

/// How many parts may be examined in search of a finite enclosure everywhere.
const PARTS: usize = 20_000;

/// A part is not bisected if the excess over the samples is below this fraction of an entry's range.
const WORTHWHILE: f64 = 0.01;

/// An entry does not count as varying if its interval is no wider, relative to its own magnitude, than some thousands
/// of roundings. Programs have its middle; the theorems that are proved have its whole interval.
const NARROW: f64 = 4096.0 * f64::EPSILON;

/// A part of the box, with how often each coordinate was halved.
#[derive(Clone)]
struct Cell {
    axes: Vec<Interval>,
    halvings: Vec<u32>,
}

impl Cell {
    /// The two halves along a coordinate; none where there is no number in between.
    fn halves(&self, k: usize) -> Option<[Self; 2]> {
        let axis = &self.axes[k];
        let middle = middle(axis);
        if !(axis.lo() < middle && middle < axis.hi()) {
            return None;
        }
        let part = |lo, hi| {
            let mut cell = self.clone();
            cell.axes[k] = Interval::new(lo, hi)?;
            cell.halvings[k] += 1;
            Some(cell)
        };
        Some([part(axis.lo(), middle)?, part(middle, axis.hi())?])
    }

    /// The single point in the middle.
    fn centre(&self) -> Vec<Interval> {
        self.axes.iter().map(|axis| Interval::new(middle(axis), middle(axis)).unwrap_or(*axis)).collect()
    }

    /// The chosen coordinates, as text for an error.
    fn place(&self, size: Dimensions, chosen: impl Fn(usize) -> bool) -> Place {
        let value = |axis: &Interval| match (axis.contains(0.0), axis.lo().is_finite(), axis.hi().is_finite()) {
            (true, ..) => 0.0,
            (_, true, false) => axis.lo(),
            (_, false, true) => axis.hi(),
            _ => middle(axis),
        };
        let axes: Vec<(usize, &Interval)> = self.axes.iter().enumerate().filter(|(k, _)| chosen(*k)).collect();
        Place {
            point: axes.iter().map(|(k, axis)| (Axis::of(*k, size), value(axis))).collect(),
            part: axes.iter().map(|(_, axis)| (axis.lo(), axis.hi())).collect(),
        }
    }
}

/// Two halves, with how many of them failed and how often the coordinate was halved before.
type Ranked<T> = ((usize, u32), T);

/// The [Jacobians](Evaluation::jacobians) over one box, and bounds of jumps where a branch is undecided.
struct Jacobians {
    entries: Vec<Interval>,
    gap: Option<Gap>,
}

/// A part with its Jacobians.
struct Leaf {
    cell: Cell,
    entries: Vec<Interval>,
    gap: Option<Gap>,
}

/// An enclosure of the Jacobians over a box.
#[derive(Debug, Clone, PartialEq)]
pub struct JacobianEnclosure {
    /// Df, n x n: entry (i, j) encloses the derivative of `f_i` by `x_j`.
    pub a: Matrix<Interval>,
    /// Dh, p x n.
    pub c: Matrix<Interval>,
    /// Number of parts of the box whose enclosures were united.
    pub parts: usize,
    /// Largest excess of an end of an entry over the range of sampled Jacobians, relative to the size of that
    /// entry. Not a bound of the overestimation: samples need not hit the extremes.
    pub excess: f64,
    /// Where comparisons stay open, what is known of the jumps there. `None` where none does: then there is no such
    /// hypothesis.
    pub branches: Option<Branches>,
}

impl JacobianEnclosure {
    /// The interval of an entry.
    ///
    /// # Panics
    /// For an entry that the Jacobian does not have.
    pub fn interval(&self, entry: Entry) -> Interval {
        if entry.of_output { self.c[(entry.row, entry.column)] } else { self.a[(entry.row, entry.column)] }
    }

    /// The entries that vary by more than some thousands of roundings of their own magnitude, row by row, those of Df
    /// first.
    pub fn varying(&self) -> impl Iterator<Item = Entry> {
        let n = self.a.rows();
        let entry = move |k: usize| match k / n {
            row if row >= n => Entry { of_output: true, row: row - n, column: k % n },
            row => Entry { of_output: false, row, column: k % n },
        };
        (0..(n + self.c.rows()) * n).map(entry).filter(|entry| {
            let interval = self.interval(*entry);
            interval.width() > NARROW * interval.magnitude()
        })
    }

    /// What a certificate proves of the plant with this enclosure, of states at `time` and an `estimate`: that holds
    /// where [`hypothesis`](Self::hypothesis) does. None if it proves nothing of all Jacobians of the enclosure.
    pub fn sentence(
        &self,
        certificate: &Certificate,
        region: &Region,
        (estimate, time): (&str, &str),
    ) -> Option<ProvedSentence> {
        let hypothesis = self.hypothesis(region, estimate, time);
        let plant = Represented::Jacobians { hypothesis: &hypothesis, estimate, a: &self.a, c: &self.c };
        let reading = Reading {
            states: &[],
            inputs: &[],
            outputs: &[],
            units: &BTreeMap::new(),
            plant,
            is_linearised: false,
            scales: &[],
        };
        certificate.sentences(&reading).into_iter().next()
    }

    /// Where the mean Jacobians between a state and its `estimate` lie in the enclosure over `region`: with
    /// `xhat` and `t` "from every x(0) and xhat(0)", or "as long as x(t) and xhat(t) stay in the box (..)", and the
    /// continuity where [branches](Self::branches) meet, if there are any. Every conclusion from the enclosure has this
    /// hypothesis.
    pub fn hypothesis(&self, region: &Region, estimate: &str, time: &str) -> String {
        let place = match region.to_string().as_str() {
            "everywhere" => format!("from every x(0) and {estimate}(0)"),
            bounds => format!("as long as x({time}) and {estimate}({time}) stay in the box ({bounds})"),
        };
        match &self.branches {
            Some(branches) => format!("{place}, and provided that {branches}"),
            None => place,
        }
    }
}

/// An enclosure of Df (n x n) and Dh (p x n) over the box.
///
/// Cost: two evaluations of the plant for each state and each part of the box; the parts are at most twice the region's
/// [subdivisions](Region::subdivisions), and more only where that is needed for a finite result.
///
/// ```
/// use luenberger_design::{Region, enclosure::enclose};
/// use luenberger_plants::flexible_joint;
/// // The only nonlinearity is -3.33 sin x3, whose derivative is bounded everywhere.
/// let jacobians = enclose(&flexible_joint::classical(), &Region::everywhere(4))?;
/// let entry = jacobians.a[(3, 2)];
/// assert!(entry.contains(-19.5 - 3.33) && entry.contains(-19.5 + 3.33) && entry.width() < 6.660_000_1);
/// assert!(jacobians.a[(1, 0)].is_point() && jacobians.a[(1, 0)].contains(-48.6));
/// # Ok::<(), luenberger_design::enclosure::EnclosureError>(())
/// ```
/// # Errors
/// [`EnclosureError`] names the entry or the operation, and the point.
pub fn enclose<S: Plant<IntervalDual>>(plant: &S, region: &Region) -> Result<JacobianEnclosure, EnclosureError> {
    enclose_sides(plant, region)
}

/// Bounds of h over the box, on every branch that the box leaves open. An entry without bounds is unbounded.
///
/// ```
/// use luenberger_design::{Region, enclosure::output_bounds};
/// use luenberger_plants::flexible_joint;
/// // y = (x1, x2).
/// let bounds = output_bounds(&flexible_joint::classical(), &Region::new(&[(-1.0, 2.0), (0.0, 0.5), (0.0, 1.0), (0.0, 1.0)]))?;
/// assert_eq!((bounds[0].lo(), bounds[0].hi(), bounds[1].hi()), (-1.0, 2.0, 0.5));
/// # Ok::<(), luenberger_design::enclosure::EnclosureError>(())
/// ```
/// # Errors
/// [`EnclosureError`] names an operation that is not defined on the whole box.
pub fn output_bounds<S: Plant<IntervalDual>>(plant: &S, region: &Region) -> Result<Vec<Interval>, EnclosureError> {
    let evaluation = &Evaluation { plant, size: plant.size() };
    let axes = region.axes(evaluation.size)?;
    let whole = Cell { halvings: vec![0; axes.len()], axes };
    let ways = explore(|| evaluation.over("h", &whole.axes, None)).map_err(|why| {
        let outcome = Outcome::Undefined(why, "h");
        located(evaluation, &whole, &whole, &outcome)
    })?;
    let mut bounds: Vec<Interval> = Vec::new();
    for way in ways {
        let values: Vec<Interval> = match way {
            Ok(values) => values.iter().map(IntervalDual::value).collect(),
            Err(Failure::Wrong(error)) => return Err(error),
            Err(Failure::Undefined(why, side)) => {
                return Err(located(evaluation, &whole, &whole, &Outcome::Undefined(why, side)));
            }
        };
        bounds = match bounds.len() {
            0 => values,
            _ => bounds.iter().zip(&values).map(|(all, one)| all.hull(one)).collect(),
        };
    }
    Ok(bounds)
}

fn enclose_sides(plant: &dyn Sides, region: &Region) -> Result<JacobianEnclosure, EnclosureError> {
    let size = plant.size();
    let evaluation = &Evaluation { plant, size };
    let axes = region.axes(size)?;
    let whole = Cell { halvings: vec![0; axes.len()], axes };
    let mut leaves = finite_parts(evaluation, &whole, &whole)?;
    let branches = search_jumps(evaluation, &whole, &leaves)?;
    let seen = refine(evaluation, &whole, &mut leaves, region.budget());
    let (n, p) = (size.states, size.outputs);
    let hull = united(&leaves);
    let excess = hull.iter().zip(&seen).map(|(outer, inner)| largest_excess(outer, inner).0).fold(0.0, f64::max);
    Ok(JacobianEnclosure {
        a: Matrix::from_fn(n, n, |i, j| hull[i * n + j]),
        c: Matrix::from_fn(p, n, |i, j| hull[(n + i) * n + j]),
        parts: leaves.len(),
        excess,
        branches,
    })
}

/// Entry by entry, the hull over all parts.
fn united(leaves: &[Leaf]) -> Vec<Interval> {
    let mut leaves = leaves.iter();
    let mut hull = leaves.next().map(|leaf| leaf.entries.clone()).unwrap_or_default();
    for leaf in leaves {
        for (all, one) in hull.iter_mut().zip(&leaf.entries) {
            *all = all.hull(one);
        }
    }
    hull
}

/// Result for one part.
enum Outcome {
    Finite(Jacobians),
    Unbounded(usize),
    Undefined(Undefined, &'static str),
}

fn examine(evaluation: &Evaluation<'_>, cell: &[Interval]) -> Result<Outcome, EnclosureError> {
    let found = evaluation.jacobians(cell).and_then(|(entries, branched)| {
        let gap = if branched { Some(evaluation.gap(cell)?) } else { None };
        Ok(Jacobians { entries, gap })
    });
    match found {
        Ok(jacobians) => Ok(match jacobians.entries.iter().position(|entry| !entry.is_bounded()) {
            Some(entry) => Outcome::Unbounded(entry),
            None => Outcome::Finite(jacobians),
        }),
        Err(Failure::Undefined(why, side)) => Ok(Outcome::Undefined(why, side)),
        Err(Failure::Wrong(error)) => Err(error),
    }
}

/// Halves a part of the whole box until every part of it has a finite enclosure, depth first, so that a point without
/// one is found soon.
fn finite_parts(evaluation: &Evaluation<'_>, whole: &Cell, part: &Cell) -> Result<Vec<Leaf>, EnclosureError> {
    let mut leaves = Vec::new();
    let mut examined = 1;
    let mut open = vec![(part.clone(), examine(evaluation, &part.axes)?)];
    while let Some((cell, outcome)) = open.pop() {
        let failure = match outcome {
            Outcome::Finite(Jacobians { entries, gap }) => {
                leaves.push(Leaf { cell, entries, gap });
                continue;
            }
            failure => failure,
        };
        let exhausted = cell.halvings.iter().any(|halvings| *halvings >= HALVINGS);
        // The coordinate along which the fewest halves fail; among equals the one that was halved least.
        let mut best: Option<Ranked<Vec<(Cell, Outcome)>>> = None;
        for k in 0..if exhausted { 0 } else { cell.axes.len() } {
            let Some(halves) = cell.halves(k) else { continue };
            let mut parts = Vec::with_capacity(2);
            for half in halves {
                let outcome = examine(evaluation, &half.axes)?;
                parts.push((half, outcome));
            }
            examined += 2;
            let failures = parts.iter().filter(|(_, outcome)| !matches!(outcome, Outcome::Finite(_))).count();
            let rank = (failures, cell.halvings[k]);
            if best.as_ref().is_none_or(|(least, _)| rank < *least) {
                best = Some((rank, parts));
            }
        }
        let Some((_, parts)) = best else { return Err(located(evaluation, whole, &cell, &failure)) };
        if examined > PARTS {
            return Err(EnclosureError::Effort { parts: examined, place: cell.place(evaluation.size, |_| true) });
        }
        open.extend(parts);
    }
    Ok(leaves)
}

/// How many parts that leave a branch open are halved in search of a jump, those with the largest possible jump first.
const SEARCHES: usize = 400;

/// How many of the parts that are left then are searched to the end, down to a point where branches meet.
const DIVES: usize = 24;

/// How often each coordinate is halved there: a jump at that point is seen when it is larger than what the branches'
/// difference varies over a 2^-32 of the box.
const DIVE_HALVINGS: u32 = 32;

/// A coordinate is not halved this much more often than another for the sake of the bound alone: where the branches
/// meet has to come out as well.
const AHEAD: u32 = 8;

/// Halves parts that leave a branch open, all of them, the largest possible jump first, and then some down to a point.
/// Where two branches cannot meet, although the comparison stays open down to a point, that point is the error.
fn search_jumps(
    evaluation: &Evaluation<'_>,
    whole: &Cell,
    leaves: &[Leaf],
) -> Result<Option<Branches>, EnclosureError> {
    let mut open: Vec<(Cell, Gap)> = leaves.iter().filter_map(|leaf| Some((leaf.cell.clone(), leaf.gap?))).collect();
    if open.is_empty() {
        return Ok(None);
    }
    // Parts that cannot be halved further.
    let mut done: Vec<(Cell, Gap)> = Vec::new();
    for _ in 0..SEARCHES {
        let Some(at) = (0..open.len()).max_by(|&i, &j| open[i].1.bound.total_cmp(&open[j].1.bound)) else { break };
        if open[at].1.bound == 0.0 {
            break;
        }
        let (cell, gap) = open.swap_remove(at);
        match least_halved(&cell, HALVINGS) {
            None => done.push((cell, gap)),
            Some(other) => {
                let main = gap.axis.filter(|&k| cell.halvings[k] < cell.halvings[other] + AHEAD);
                let halves = main.and_then(|k| cell.halves(k)).or_else(|| cell.halves(other));
                for half in halves.into_iter().flatten() {
                    open.extend(branched_parts(evaluation, whole, half)?);
                }
            }
        }
    }
    open.append(&mut done);
    let jump = open.iter().map(|(_, gap)| gap.bound).fold(0.0, f64::max);
    let parts = open.len();
    for (start, _) in open.into_iter().step_by(parts.div_ceil(DIVES).max(1)) {
        let mut next = Some(start);
        while let Some((cell, k)) = next.and_then(|cell| Some((cell.clone(), least_halved(&cell, DIVE_HALVINGS)?))) {
            let mut parts = Vec::new();
            for half in cell.halves(k).into_iter().flatten() {
                parts.extend(branched_parts(evaluation, whole, half)?);
            }
            next = parts.into_iter().max_by(|x, y| x.1.bound.total_cmp(&y.1.bound)).map(|(cell, _)| cell);
        }
    }
    Ok(if parts == 0 { None } else { Some(Branches { parts, jump }) })
}

/// The coordinate that was halved least, among those that can be halved.
fn least_halved(cell: &Cell, limit: u32) -> Option<usize> {
    (0..cell.axes.len())
        .filter(|&k| cell.halvings[k] < limit && cell.halves(k).is_some())
        .min_by_key(|&k| cell.halvings[k])
}

/// The part of a box on which a branch is undecided, in parts with a finite enclosure.
fn branched_parts(evaluation: &Evaluation<'_>, whole: &Cell, part: Cell) -> Result<Vec<(Cell, Gap)>, EnclosureError> {
    Ok(match examine(evaluation, &part.axes)? {
        Outcome::Finite(Jacobians { gap, .. }) => gap.map(|gap| (part, gap)).into_iter().collect(),
        _ => finite_parts(evaluation, whole, &part)?
            .into_iter()
            .filter_map(|leaf| Some((leaf.cell, leaf.gap?)))
            .collect(),
    })
}

/// The error for a part that stays without a finite enclosure. A coordinate makes no difference if there is none at
/// other values of it either.
fn located(evaluation: &Evaluation<'_>, whole: &Cell, cell: &Cell, outcome: &Outcome) -> EnclosureError {
    let matters = |k: usize| {
        let axis = &whole.axes[k];
        let others = [axis.lo(), axis.hi(), middle(axis), middle(axis) / 3.0 + axis.lo() / 1.5];
        others.into_iter().filter(|x| axis.contains(*x)).filter_map(|x| Interval::new(x, x)).any(|other| {
            let mut axes = cell.axes.clone();
            axes[k] = other;
            matches!(examine(evaluation, &axes), Ok(Outcome::Finite(_)))
        })
    };
    let (n, place) = (evaluation.size.states, cell.place(evaluation.size, matters));
    match *outcome {
        Outcome::Undefined(Undefined::Operation(operation), side) => {
            EnclosureError::Undefined { operation, side, place }
        }
        Outcome::Undefined(Undefined::TooManyBranches, side) => EnclosureError::TooManyBranches { side, place },
        Outcome::Unbounded(entry) => {
            let (row, column) = (entry / n, entry % n);
            let entry = Entry { of_output: row >= n, row: if row >= n { row - n } else { row }, column };
            EnclosureError::Unbounded { entry, place }
        }
        // Not called for one.
        Outcome::Finite(_) => EnclosureError::Effort { parts: 1, place },
    }
}

/// The larger of the excesses at the two ends relative to the range or size of the entry, and whether it is at the
/// upper end.
fn largest_excess(outer: &Interval, inner: &Interval) -> (f64, bool) {
    let size = (inner.hi() - inner.lo()).max(inner.magnitude() * WORTHWHILE).max(f64::MIN_POSITIVE);
    let (below, above) = ((inner.lo() - outer.lo()).max(0.0) / size, (outer.hi() - inner.hi()).max(0.0) / size);
    // Where samples and enclosure differ by rounding, there is nothing to gain.
    let rounding = 64.0 * f64::EPSILON * outer.magnitude() / size;
    let excess = below.max(above);
    (if excess <= rounding { 0.0 } else { excess }, above > below)
}

/// Halves parts that hold the extremes of an entry, while the samples leave room. Returns the range of the samples.
fn refine(evaluation: &Evaluation<'_>, whole: &Cell, leaves: &mut Vec<Leaf>, budget: usize) -> Vec<Interval> {
    let mut seen: Option<Vec<Interval>> = None;
    let mut sample = |point: &[Interval]| {
        if let Ok(Outcome::Finite(Jacobians { entries, .. })) = examine(evaluation, point) {
            match seen.as_mut() {
                None => seen = Some(entries),
                Some(seen) => seen.iter_mut().zip(&entries).for_each(|(all, one)| *all = all.hull(one)),
            }
        }
        seen.clone()
    };
    let mut inner = sample(&whole.centre());
    for corner in corners(&whole.axes) {
        inner = sample(&corner);
    }
    let mut closed = vec![[false; 2]; leaves.first().map_or(0, |leaf| leaf.entries.len())];
    for _ in 0..budget {
        let Some(seen) = &inner else { break };
        let hull = united(leaves);
        // The entry and the end with the largest excess.
        let worst = (0..hull.len())
            .map(|entry| (largest_excess(&hull[entry], &seen[entry]), entry))
            .filter(|((excess, upper), entry)| *excess > WORTHWHILE && !closed[*entry][usize::from(*upper)])
            .max_by(|x, y| x.0.0.total_cmp(&y.0.0));
        let Some(((_, upper), entry)) = worst else { break };
        let bound = |entries: &[Interval]| if upper { entries[entry].hi() } else { -entries[entry].lo() };
        // Among the parts that hold it, the smallest: one attained value is enough to close the gap.
        let Some(at) = (0..leaves.len()).max_by(|&i, &j| {
            let depth = |k: usize| leaves[k].cell.halvings.iter().sum::<u32>();
            bound(&leaves[i].entries).total_cmp(&bound(&leaves[j].entries)).then(depth(i).cmp(&depth(j)))
        }) else {
            break;
        };
        let mut best: Option<(f64, u32, [Leaf; 2])> = None;
        for k in 0..leaves[at].cell.axes.len() {
            if leaves[at].cell.halvings[k] >= HALVINGS {
                continue;
            }
            let Some(halves) = leaves[at].cell.halves(k) else { continue };
            let [Some(first), Some(second)] = halves.map(|cell| match examine(evaluation, &cell.axes) {
                Ok(Outcome::Finite(Jacobians { entries, gap })) => Some(Leaf { cell, entries, gap }),
                _ => None,
            }) else {
                continue;
            };
            let rank = (bound(&first.entries).max(bound(&second.entries)), leaves[at].cell.halvings[k]);
            if best.as_ref().is_none_or(|(bound, halvings, _)| rank < (*bound, *halvings)) {
                best = Some((rank.0, rank.1, [first, second]));
            }
        }
        let Some((_, _, [first, second])) = best else {
            closed[entry][usize::from(upper)] = true;
            continue;
        };
        for leaf in [&first, &second] {
            inner = sample(&leaf.cell.centre());
        }
        leaves[at] = first;
        leaves.push(second);
    }
    inner.unwrap_or_else(|| united(leaves))
}

/// The corners of the bounded coordinates, with the middles of the others; of at most 10 coordinates that are not
/// single numbers, since there are 2^k of them.
fn corners(axes: &[Interval]) -> Vec<Vec<Interval>> {
    let varying: Vec<usize> =
        (0..axes.len()).filter(|&k| axes[k].is_bounded() && !axes[k].is_point()).take(10).collect();
    let end = |x: f64, axis: &Interval| Interval::new(x, x).unwrap_or(*axis);
    (0..1usize << varying.len())
        .map(|which| {
            let corner = |(k, axis): (usize, &Interval)| match varying.iter().position(|v| *v == k) {
                Some(bit) => end(if which >> bit & 1 == 1 { axis.hi() } else { axis.lo() }, axis),
                None => end(middle(axis), axis),
            };
            axes.iter().enumerate().map(corner).collect()
        })
        .collect()
}
