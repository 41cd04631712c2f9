//! Crossings and extrema of a quantity along a trajectory, located on the dense output.
//!
//! Each step of the integrator is searched at 17 points, more than the degree of its polynomial, and every local
//! extremum that comes towards the level without reaching it on these points, also one beside an end of the step, is
//! followed to its end: it has two crossings close to each other. What turns twice between two points can be missed.
//! Roots are bisected to the last bit of t.

use luenberger_plants::wrap;

use crate::dense::{Dense, NODES, Place, enclosure};
use crate::error::SimError;

/// Points per step at which a quantity is searched, besides its start.
const SEARCH: usize = 16;

/// The error of one state: a component of the dense output less another one, by a scale.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Difference {
    pub(crate) of: usize,
    pub(crate) from: usize,
    /// The full turn of an angle, otherwise 0.
    pub(crate) turn: f64,
    pub(crate) scale: f64,
}

/// How a quantity follows from a row of the dense output.
enum Quantity<'t> {
    /// A polynomial on each step.
    Difference(Difference),
    /// The root of the sum of the squares.
    Norm(Vec<Difference>),
    /// Of the time and the whole row.
    Any(Read<'t>),
}

type Read<'t> = Box<dyn Fn(f64, &[f64]) -> f64 + 't>;

/// A scalar quantity as a function of time.
pub struct Trace<'t> {
    dense: &'t Dense,
    quantity: Quantity<'t>,
}

/// A quantity passes a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// When.
    pub time: f64,
    /// Upwards or downwards.
    pub rising: bool,
}

/// A largest or smallest value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremum {
    /// When.
    pub time: f64,
    /// The value.
    pub value: f64,
}

impl<'t> Trace<'t> {
    pub(crate) fn new(dense: &'t Dense, read: impl Fn(f64, &[f64]) -> f64 + 't) -> Self {
        Self { dense, quantity: Quantity::Any(Box::new(read)) }
    }

    pub(crate) fn difference(dense: &'t Dense, difference: Difference) -> Self {
        Self { dense, quantity: Quantity::Difference(difference) }
    }

    pub(crate) fn norm(dense: &'t Dense, differences: Vec<Difference>) -> Self {
        Self { dense, quantity: Quantity::Norm(differences) }
    }

    /// Start and end of the trajectory.
    pub fn span(&self) -> (f64, f64) {
        self.dense.span()
    }

    /// The value at `t`.
    ///
    /// # Errors
    /// [`SimError::Outside`].
    pub fn at(&self, t: f64) -> Result<f64, SimError> {
        Ok(self.on_step(self.dense.step_at(t)?).at(t))
    }

    /// The integral over the whole trajectory: Gauss-Legendre quadrature with eight points on each step, exact for the
    /// square of the dense output.
    ///
    /// ```
    /// # let plant = luenberger_plants::double_integrator();
    /// let trajectory = luenberger_sim::Scenario::new(plant).initial_state(&[0.0, 1.0]).until(2.0, 2).run()?;
    /// let integral = trajectory.trace(|view| view.x[0].powi(2)).integral(); // of t^2
    /// assert!((integral - 8.0 / 3.0).abs() < 1e-12);
    /// # Ok::<(), luenberger_sim::SimError>(())
    /// ```
    pub fn integral(&self) -> f64 {
        self.integral_of(self.span().0, &|value| value)
    }

    /// The integral of the square from `from` to the end.
    pub(crate) fn integral_of_square_from(&self, from: f64) -> f64 {
        self.integral_of(from, &|value| value * value)
    }

    fn integral_of(&self, from: f64, measure: &dyn Fn(f64) -> f64) -> f64 {
        // Positive nodes on [-1, 1] and their weights; Abramowitz and Stegun, table 25.4.
        const RULE: [(f64, f64); 4] = [
            (0.183_434_642_495_649_8, 0.362_683_783_378_362),
            (0.525_532_409_916_329, 0.313_706_645_877_887_3),
            (0.796_666_477_413_626_7, 0.222_381_034_453_374_47),
            (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
        ];
        let step = |(k, (start, end)): (usize, (f64, f64))| {
            let quantity = self.on_step(k);
            let start = start.max(from);
            let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
            let pair = |&(node, weight): &(f64, f64)| {
                let (left, right) = (quantity.at(middle - half * node), quantity.at(middle + half * node));
                weight * (measure(left) + measure(right))
            };
            half * RULE.iter().map(pair).sum::<f64>()
        };
        self.dense.steps().enumerate().filter(|(_, (_, end))| *end > from).map(step).sum()
    }

    /// The value at the end.
    pub fn last(&self) -> f64 {
        let (_, end) = self.span();
        self.on_step(self.dense.step_count() - 1).at(end)
    }

    fn on_step(&self, step: usize) -> OnStep<'_> {
        let nodes = |d: &Difference| {
            let (of, from) = (self.dense.nodes(step, d.of), self.dense.nodes(step, d.from));
            let nodes = core::array::from_fn(|i| (of[i] - from[i]) / d.scale);
            let turn = d.turn / d.scale;
            if turn == 0.0 {
                return (nodes, turn);
            }
            // On the branch of its start it is a polynomial, if it stays within half a turn.
            let apart = wrap(nodes[0], turn) - nodes[0];
            let near = nodes.map(|node| node + apart);
            let stays = enclosure(&near).is_some_and(|(low, high)| low > -0.5 * turn && high < 0.5 * turn);
            (near, if stays { 0.0 } else { turn })
        };
        let form = match &self.quantity {
            Quantity::Difference(difference) => match nodes(difference) {
                (nodes, 0.0) => Form::Polynomial(nodes),
                wrapped => Form::Wrapped(wrapped.0, wrapped.1),
            },
            Quantity::Norm(differences) => {
                let parts: Vec<_> = differences.iter().map(nodes).collect();
                if parts.iter().all(|(_, turn)| *turn == 0.0) {
                    Form::Norm(parts.into_iter().map(|(nodes, _)| nodes).collect())
                } else {
                    Form::NormOfWrapped(parts)
                }
            }
            Quantity::Any(read) => Form::Any(self.dense, step, read),
        };
        OnStep { span: self.dense.step(step), form }
    }

    /// All crossings of `level`, in order. A quantity that touches the level and turns back does not cross it.
    pub fn crossings(&self, level: f64) -> Vec<Crossing> {
        let mut crossings = Vec::new();
        self.each_crossing(level, |crossing| {
            crossings.push(crossing);
            true
        });
        crossings
    }

    /// Calls `found` with the crossings of `level`, in order, until it returns false.
    fn each_crossing(&self, level: f64, mut found: impl FnMut(Crossing) -> bool) {
        // The last point off the level: step, time, value.
        let mut before: Option<(usize, f64, f64)> = None;
        for (step, (start, _)) in self.dense.steps().enumerate() {
            let quantity = self.on_step(step);
            let value = |t: f64| quantity.at(t) - level;
            for (t, now) in quantity.points_about(level) {
                if now == 0.0 || now.is_nan() {
                    continue;
                }
                if let Some((at, since, last)) = before
                    && last * now < 0.0
                {
                    // Between two steps the quantity may jump across the level, or pass it exactly at the seam.
                    let low = if at == step { since } else { start };
                    let first = if at == step { last } else { value(start) };
                    let time = if first * now < 0.0 { bisect(&value, low, t, first) } else { start };
                    if !found(Crossing { time, rising: now > 0.0 }) {
                        return;
                    }
                }
                before = Some((step, t, now));
            }
        }
    }

    /// The first crossing of `level`.
    pub fn first_crossing(&self, level: f64) -> Option<Crossing> {
        let mut first = None;
        self.each_crossing(level, |crossing| {
            first = Some(crossing);
            false
        });
        first
    }

    /// The last crossing of `level`.
    pub fn last_crossing(&self, level: f64) -> Option<Crossing> {
        self.crossings(level).last().copied()
    }

    /// The first change of sign.
    pub fn first_sign_change(&self) -> Option<f64> {
        self.first_crossing(0.0).map(|crossing| crossing.time)
    }

    /// The largest value from `from` to the end.
    ///
    /// # Errors
    /// [`SimError::Outside`] when `from` is not within the span.
    pub fn maximum(&self, from: f64) -> Result<Extremum, SimError> {
        self.largest(from, &|value| value)
    }

    /// The largest magnitude from `from` to the end.
    ///
    /// # Errors
    /// [`SimError::Outside`] when `from` is not within the span.
    pub fn largest_magnitude(&self, from: f64) -> Result<Extremum, SimError> {
        self.largest(from, &f64::abs)
    }

    /// The largest of a convex `measure`.
    fn largest(&self, from: f64, measure: &dyn Fn(f64) -> f64) -> Result<Extremum, SimError> {
        let mut best = Extremum { time: from, value: measure(self.at(from)?) };
        for (step, (start, end)) in self.dense.steps().enumerate().filter(|(_, (_, end))| *end > from) {
            let quantity = self.on_step(step);
            if quantity.enclosure().is_some_and(|(low, high)| measure(low).max(measure(high)) <= best.value) {
                continue;
            }
            let value = |t: f64| measure(quantity.at(t));
            let points: Vec<(f64, f64)> = grid(start.max(from), end).map(|t| (t, value(t))).collect();
            let mut consider = |time: f64, value: f64| {
                if value > best.value {
                    best = Extremum { time, value };
                }
            };
            for &(t, value) in &points {
                consider(t, value);
            }
            let falling = |t: f64| -value(t);
            let below: Vec<(f64, f64)> = points.iter().map(|&(t, value)| (t, -value)).collect();
            for bracket in brackets(&below, &falling) {
                let t = minimum(&falling, bracket.low, bracket.high);
                consider(t, value(t));
            }
        }
        Ok(best)
    }
}

/// A quantity on one step.
struct OnStep<'a> {
    span: (f64, f64),
    form: Form<'a>,
}

enum Form<'a> {
    /// By its values at the nodes.
    Polynomial([f64; NODES]),
    /// Of the polynomials with these values at the nodes.
    Norm(Vec<[f64; NODES]>),
    /// The same of an angle that passes half a turn on the step, with its full turn.
    Wrapped([f64; NODES], f64),
    NormOfWrapped(Vec<([f64; NODES], f64)>),
    Any(&'a Dense, usize, &'a dyn Fn(f64, &[f64]) -> f64),
}

impl OnStep<'_> {
    fn at(&self, t: f64) -> f64 {
        match &self.form {
            Form::Polynomial(nodes) => Place::of(self.span, t).value(nodes),
            Form::Norm(parts) => {
                let place = Place::of(self.span, t);
                parts.iter().map(|nodes| place.value(nodes).powi(2)).sum::<f64>().sqrt()
            }
            Form::Wrapped(nodes, turn) => wrap(Place::of(self.span, t).value(nodes), *turn),
            Form::NormOfWrapped(parts) => {
                let place = Place::of(self.span, t);
                parts.iter().map(|(nodes, turn)| wrap(place.value(nodes), *turn).powi(2)).sum::<f64>().sqrt()
            }
            Form::Any(dense, step, read) => {
                let mut row = vec![0.0; dense.width()];
                dense.on_step(*step, t, 0, &mut row);
                read(t, &row)
            }
        }
    }

    /// What encloses the quantity on the step, where that is known.
    fn enclosure(&self) -> Option<(f64, f64)> {
        match &self.form {
            Form::Polynomial(nodes) => enclosure(nodes),
            Form::Norm(parts) => {
                let (mut least, mut largest) = (0.0, 0.0);
                for nodes in parts {
                    let (low, high) = enclosure(nodes)?;
                    least += low.max(-high).max(0.0).powi(2);
                    largest += high.max(-low).powi(2);
                }
                Some((least.sqrt() * (1.0 - 1e-15), largest.sqrt() * (1.0 + 1e-15)))
            }
            Form::Wrapped(..) | Form::NormOfWrapped(..) | Form::Any(..) => None,
        }
    }

    /// Times on the step with what the quantity exceeds `level` by, among them one on each side of a crossing: the ends
    /// alone where the quantity keeps its side.
    fn points_about(&self, level: f64) -> Vec<(f64, f64)> {
        let (start, end) = self.span;
        let value = |t: f64| self.at(t) - level;
        if self.enclosure().is_some_and(|(low, high)| low > level || high < level) {
            return vec![(start, value(start)), (end, value(end))];
        }
        let mut points: Vec<(f64, f64)> = grid(start, end).map(|t| (t, value(t))).collect();
        // Turning points between the grid points, which may be on the other side of the level.
        let mut turns = Vec::new();
        for sign in [1.0, -1.0] {
            let apart = |t: f64| sign * value(t);
            let on_grid: Vec<(f64, f64)> = points.iter().map(|&(t, value)| (t, sign * value)).collect();
            for bracket in brackets(&on_grid, &apart).into_iter().filter(|bracket| bracket.least > 0.0) {
                let t = minimum(&apart, bracket.low, bracket.high);
                turns.push((t, value(t)));
            }
        }
        points.extend(turns);
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    }
}

/// The points at which a step is searched, both ends among them.
fn grid(start: f64, end: f64) -> impl Iterator<Item = f64> {
    (0..=SEARCH).map(move |i| if i == SEARCH { end } else { start + (end - start) * i as f64 / SEARCH as f64 })
}

/// Where a function has a local minimum, with the least of its values on the grid there.
struct Bracket {
    low: f64,
    high: f64,
    least: f64,
}

/// The local minima of `f` between the points (t, f(t)) of a grid: around a point that is not above its neighbours, and
/// beside an end from which f falls before it rises.
fn brackets(points: &[(f64, f64)], f: &dyn Fn(f64) -> f64) -> Vec<Bracket> {
    let around = points.windows(3).filter(|w| w[1].1 <= w[0].1 && w[1].1 <= w[2].1);
    let mut found: Vec<Bracket> = around.map(|w| Bracket { low: w[0].0, high: w[2].0, least: w[1].1 }).collect();
    if let ([first, second, ..], [.., before, last]) = (points, points) {
        for (end, next) in [(first, second), (last, before)] {
            // A thousandth of the way: an extremum that is nearer to the end is as high as the end to a millionth of
            // what the grid leaves open.
            if end.1 <= next.1 && f(end.0 + 1e-3 * (next.0 - end.0)) < end.1 {
                found.push(Bracket { low: end.0.min(next.0), high: end.0.max(next.0), least: end.1 });
            }
        }
    }
    found
}

/// The root between `low` and `high`, where `f(low)` has the sign of `first` and `f(high)` the other, to the last bit.
fn bisect(f: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64, first: f64) -> f64 {
    // 1100 halvings reach neighbouring floating-point numbers from any interval.
    for _ in 0..1100 {
        let middle = low + (high - low) / 2.0;
        if middle <= low || middle >= high {
            break;
        }
        let value = f(middle);
        if value == 0.0 {
            return middle;
        }
        if value * first > 0.0 { low = middle } else { high = middle }
    }
    high
}

/// Where `f` is least between `low` and `high`, by golden section; 60 steps shrink the interval by 3e-13.
fn minimum(f: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let (mut left, mut right) = (high - golden * (high - low), low + golden * (high - low));
    let (mut f_left, mut f_right) = (f(left), f(right));
    for _ in 0..60 {
        if f_left <= f_right {
            (high, right, f_right) = (right, left, f_left);
            left = high - golden * (high - low);
            f_left = f(left);
        } else {
            (low, left, f_left) = (left, right, f_right);
            right = low + golden * (high - low);
            f_right = f(right);
        }
    }
    if f_left <= f_right { left } else { right }
}
