//! Bounds of a polynomial in atoms over a box, by branch and bound.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::{Arena, Atom, Function, NoPolynomial, Polynomial};
use crate::interval::Interval;
use crate::ring::Ring;

/// Maximum number of parts of a box for one bound.
pub(super) const PARTS: usize = 1 << 15;

/// A polynomial with its coefficients as intervals.
type Terms = Vec<(Interval, Vec<(usize, u32)>)>;

fn compiled(p: &Polynomial) -> Terms {
    p.terms.iter().map(|(monomial, x)| (x.enclosure(), monomial.0.clone())).collect()
}

enum Compiled {
    Variable(usize),
    Function(Function, Terms),
    Reciprocal(Terms),
}

/// A polynomial to be bounded, with its gradient and all atoms they need.
struct Target {
    atoms: Vec<Option<Compiled>>,
    value: Terms,
    gradient: Vec<Terms>,
    depends: Vec<bool>,
}

/// Bounds of the supremum over the box.
#[derive(Debug, Clone)]
pub(crate) struct Extremum {
    /// Upper bound of the supremum; infinite if none was found.
    pub(crate) upper: f64,
    /// Lower bound of the value at `at`.
    pub(crate) lower: f64,
    /// A point of the box.
    pub(crate) at: Vec<f64>,
}

/// A part of the box and a bound over it.
struct Part {
    upper: f64,
    axes: Vec<Interval>,
    cut: usize,
}

impl PartialEq for Part {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Part {}
impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Part {
    fn cmp(&self, other: &Self) -> Ordering {
        self.upper.total_cmp(&other.upper)
    }
}

fn evaluate(terms: &Terms, ranges: &[Option<Interval>]) -> Option<Interval> {
    let mut sum = Interval::zero();
    for (coefficient, factors) in terms {
        let mut product = *coefficient;
        for (atom, power) in factors {
            let range = (*ranges.get(*atom)?)?;
            let power = i32::try_from(*power).ok()?;
            product = product.mul(&if power == 1 { range } else { range.powi(power)? });
        }
        sum = sum.add(&product);
    }
    Some(sum)
}

impl Arena {
    /// The supremum over a box. With a goal, until it is known to be at most `goal` or larger; without, to 2 % or to
    /// the accuracy that the number of parts allows.
    ///
    /// # Errors
    /// [`NoPolynomial::TooLarge`] if the gradient has too many terms.
    pub(crate) fn supremum(
        &mut self,
        p: &Polynomial,
        axes: &[Interval],
        goal: Option<f64>,
    ) -> Result<Extremum, NoPolynomial> {
        if p.is_zero() {
            return Ok(Extremum { upper: 0.0, lower: 0.0, at: axes.iter().map(Interval::midpoint).collect() });
        }
        let target = Target::new(self, p)?;
        let terms = target.terms();
        let (found, parts) = target.supremum(axes, goal, self.allowed_parts(terms));
        self.evaluations += 2 * (parts + 1) * terms;
        Ok(found)
    }
}

impl Target {
    fn new(arena: &mut Arena, p: &Polynomial) -> Result<Self, NoPolynomial> {
        let depends = arena.depends_on(p);
        let mut gradient = Vec::with_capacity(depends.len());
        for (variable, _) in depends.iter().enumerate() {
            gradient.push(arena.derivative(p, variable)?);
        }
        let mut used = vec![false; arena.atoms.len()];
        let mark = |used: &mut Vec<bool>, p: &Polynomial| {
            for (atom, _) in p.terms.keys().flat_map(|monomial| &monomial.0) {
                used[*atom] = true;
            }
        };
        for p in gradient.iter().chain([p]) {
            mark(&mut used, p);
        }
        for k in (0..used.len()).rev() {
            if used[k]
                && let Atom::Function(_, p) | Atom::Reciprocal(p) = &arena.atoms[k]
            {
                mark(&mut used, p);
            }
        }
        let atoms = arena.atoms.iter().zip(&used).enumerate().map(|(k, (atom, used))| {
            used.then(|| match atom {
                Atom::Variable => Compiled::Variable(k),
                Atom::Function(function, p) => Compiled::Function(*function, compiled(p)),
                Atom::Reciprocal(p) => Compiled::Reciprocal(compiled(p)),
            })
        });
        let atoms = atoms.collect();
        Ok(Self { atoms, value: compiled(p), gradient: gradient.iter().map(compiled).collect(), depends })
    }

    /// Number of terms evaluated per box.
    fn terms(&self) -> usize {
        let of_atom = |atom: &Option<Compiled>| match atom {
            Some(Compiled::Function(_, p) | Compiled::Reciprocal(p)) => p.len() + 1,
            _ => 0,
        };
        let atoms: usize = self.atoms.iter().map(of_atom).sum();
        // Twice: atoms and value are evaluated at the midpoint too.
        2 * (self.value.len() + atoms) + self.gradient.iter().map(Vec::len).sum::<usize>()
    }

    /// Ranges of the atoms over a box.
    fn ranges(&self, axes: &[Interval]) -> Vec<Option<Interval>> {
        let mut ranges: Vec<Option<Interval>> = Vec::with_capacity(self.atoms.len());
        for atom in &self.atoms {
            let range = match atom {
                None => None,
                Some(Compiled::Variable(k)) => axes.get(*k).copied(),
                Some(Compiled::Function(function, p)) => evaluate(p, &ranges).and_then(|x| function.over(&x)),
                Some(Compiled::Reciprocal(p)) => evaluate(p, &ranges).and_then(|x| x.recip()),
            };
            ranges.push(range);
        }
        ranges
    }

    /// Enclosures of the values over the box and of the value at its midpoint, and the variable to bisect. No enclosure
    /// if an atom is not shown to be defined.
    fn over(&self, axes: &[Interval]) -> (Option<Interval>, Option<Interval>, Option<usize>) {
        let ranges = self.ranges(axes);
        let natural = evaluate(&self.value, &ranges);
        let middle: Vec<Interval> =
            axes.iter().map(|axis| Interval::from_f64(axis.midpoint()).unwrap_or(*axis)).collect();
        let centre = evaluate(&self.value, &self.ranges(&middle));
        let mut form = centre;
        let (mut cut, mut most) = (None, -1.0);
        for (k, axis) in axes.iter().enumerate() {
            if !self.depends[k] || axis.is_point() {
                continue;
            }
            let slope = evaluate(&self.gradient[k], &ranges);
            let change = slope.map(|slope| slope.mul(&axis.sub(&middle[k])));
            form = form.zip(change).map(|(form, change)| form.add(&change));
            let size = change.map_or(f64::INFINITY, |change| change.magnitude());
            // An unbounded contribution is bisected along the widest variable.
            let size = if size.is_finite() { size } else { f64::MAX.min(axis.width() * 1e290) };
            if size > most {
                (cut, most) = (Some(k), size);
            }
        }
        let both = match (natural, form) {
            (Some(natural), Some(form)) => Some(natural.intersection(&form).unwrap_or(natural)),
            // Without a value over the whole part the mean-value form does not apply.
            (natural, _) => natural,
        };
        (both, centre, cut)
    }

    /// As [`Arena::supremum`], with the number of bisections.
    fn supremum(&self, axes: &[Interval], goal: Option<f64>, parts: usize) -> (Extremum, usize) {
        let middle = |axes: &[Interval]| axes.iter().map(Interval::midpoint).collect::<Vec<_>>();
        let mut found = Extremum { upper: f64::INFINITY, lower: f64::NEG_INFINITY, at: middle(axes) };
        let mut heap = BinaryHeap::new();
        // Largest bound of the parts that cannot be bisected further.
        let mut left_over = f64::NEG_INFINITY;
        let mut consider = |axes: Vec<Interval>, found: &mut Extremum, heap: &mut BinaryHeap<Part>| {
            let (range, centre, cut) = self.over(&axes);
            if let Some(centre) = centre
                && centre.lo() > found.lower
            {
                (found.lower, found.at) = (centre.lo(), middle(&axes));
            }
            let upper = range.map_or(f64::INFINITY, |range| range.hi());
            match cut {
                Some(cut) => heap.push(Part { upper, axes, cut }),
                None => left_over = left_over.max(upper),
            }
            left_over
        };
        let mut rest = consider(axes.to_vec(), &mut found, &mut heap);
        for count in 0..parts {
            let Some(top) = heap.pop() else { break };
            let upper = top.upper.max(rest);
            let is_done = match goal {
                Some(goal) => upper <= goal || found.lower > goal,
                None => upper <= found.lower + 0.02 * found.lower.abs(),
            };
            let axis = top.axes[top.cut];
            let at = axis.midpoint();
            if is_done || !(axis.lo() < at && at < axis.hi()) {
                found.upper = upper;
                return (found, count);
            }
            for (lo, hi) in [(axis.lo(), at), (at, axis.hi())] {
                let mut half = top.axes.clone();
                half[top.cut] = Interval::new(lo, hi).unwrap_or(axis);
                rest = consider(half, &mut found, &mut heap);
            }
        }
        found.upper = heap.peek().map_or(rest, |top| top.upper.max(rest));
        (found, parts)
    }
}
