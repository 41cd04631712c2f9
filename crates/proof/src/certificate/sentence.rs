//! What a report says of an observer that is proved: made here, of the data of proved theorems, and nowhere else.
//!
//! The words of a certificate file stand for themselves: they repeat the plant and every number exactly. A report has
//! shown these, and wants a sentence with the names of the states. It is a *reading* of the theorem: the report says
//! what the theorem's data are in terms of its plant ([`Represented`]), and what of this can be checked from the data
//! is checked. Numbers of hypotheses and of conclusions are rounded to the safe side.

use core::fmt;
use std::collections::BTreeMap;

#[cfg(feature = "all-theorems")]
use super::DeployedObserver;
use super::{Certificate, PlantMatrices, ProvedTheorem, Theorem};
use crate::interval::Interval;
use crate::matrix::Matrix;
#[cfg(feature = "all-theorems")]
use crate::statement::TimeDomain;
use crate::statement::{largest_eigenvalue_bound, overshoot_bound};
use crate::wording::{at_least, at_most, shortest};

/// A sentence that proved theorems imply. It can only be made from these.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProvedSentence(String);

impl ProvedSentence {
    /// The text, with its full stop.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for ProvedSentence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// What the data of a theorem are in a report: the names and units there.
#[derive(Debug, Clone, Copy)]
pub struct Reading<'a> {
    /// The names of the components of the error.
    pub states: &'a [String],
    /// The names of the inputs.
    pub inputs: &'a [String],
    /// The names of the outputs.
    pub outputs: &'a [String],
    /// The units of these names, as far as they have one.
    pub units: &'a BTreeMap<String, String>,
    /// What the plant of the theorem is.
    pub plant: Represented<'a>,
    /// Whether it is the linearisation of a nonlinear plant at an operating point, in deviations from it.
    pub is_linearised: bool,
    /// What bounds of the errors are judged by, see [`is_useful`]: entries in the order of `states`; those that are not
    /// there or not positive are not judged.
    pub scales: &'a [f64],
}

/// Whether a bound of the error of a state says more than a constant estimate would have: whether it is below `scale`,
/// half of the range of that state. Where the scale is not positive there is nothing to compare with.
///
/// Without a unit, and the same whatever is added to the state.
pub fn is_useful(bound: f64, scale: f64) -> bool {
    bound < scale || scale.is_nan() || scale <= 0.0
}

/// What stands in the place of a bound that is not useful.
pub const NO_USEFUL_BOUND: &str = "no useful bound";

/// What the plant of a theorem is in a report.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Represented<'a> {
    /// The plant itself.
    Itself,
    /// The plant with a disturbance d as further states, `x' = A x + B u + E d` and `d` the first of a chain of
    /// integrators. Checked: the rows and columns of the chain.
    WithDisturbance {
        /// The number of states of the plant.
        states: usize,
        /// The length of the chain, from 1.
        order: usize,
    },
    /// The plant itself, whose A deviates within bounds: what the deviations make of states within bounds is among the
    /// disturbances of the theorem, or A among its vertices.
    Uncertain,
    /// The loop `u = -K xhat` of plant and observer, with the state (x, xhat). Checked: the blocks.
    Loop {
        /// The number of states of the plant.
        states: usize,
        /// Whether it is the linear part at 0 of a loop with a cubic observer, whose cubic term has the derivative 0
        /// there.
        is_linear_part: bool,
    },
    /// The Jacobians of a nonlinear plant, of which an enclosure is known wherever the hypothesis holds. Checked: that
    /// the theorem is about every matrix of the enclosure.
    Jacobians {
        /// Where they lie in the enclosure: `as long as x(t) and xhat(t) stay in the box (..)`.
        hypothesis: &'a str,
        /// The name of the estimate of which that is said, such as `xhat`.
        estimate: &'a str,
        /// Of the right-hand side.
        a: &'a Matrix<Interval>,
        /// Of the output.
        c: &'a Matrix<Interval>,
    },
    /// The Jacobians of the distance d = beta(y, chi) - phi(x) of an immersion-and-invariance observer, of which an
    /// enclosure is known wherever the hypothesis holds, as well as that `xhat = phi^L(beta(y, chi), y)` is x for d = 0
    /// and Lipschitz in d. Checked: that the theorem is about every matrix of the enclosure.
    Distance {
        /// Where that is so: `as long as x(t) .. and beta(y(t), chi(t)) ..`.
        hypothesis: &'a str,
        /// Of `d' = M d`.
        m: &'a Matrix<Interval>,
    },
    /// A nonlinear plant whose nonlinearities are in the sectors of the theorem by the word of the user.
    InSectors {
        /// Where they are.
        hypothesis: &'a str,
    },
}

impl Theorem {
    /// The linear system that the theorem is about; none for those about a nonlinear plant or an error alone.
    fn linear_system(&self) -> Option<&'static str> {
        let is_discrete = match self {
            Self::DiscreteConvergence(_) | Self::SampledCubicConvergence(_) | Self::SemiImplicitCubicConvergence(_) => {
                true
            }
            #[cfg(feature = "all-theorems")]
            Self::KklErrorBound(_) | Self::SuperTwistingConvergence(_) => return None,
            #[cfg(feature = "all-theorems")]
            Self::HInfinityFilter(theorem) => theorem.0.time == TimeDomain::Discrete,
            #[cfg(feature = "all-theorems")]
            Self::H2Filter(theorem) => theorem.0.time == TimeDomain::Discrete,
            #[cfg(feature = "all-theorems")]
            Self::SampledIntervalEnclosure(_) | Self::DeployedObserver(_) | Self::DiscreteInputToStateStability(_) => {
                true
            }
            _ => false,
        };
        Some(if is_discrete { "x+ = A x + B u, y = C x" } else { "x' = A x + B u, y = C x" })
    }
}

impl Reading<'_> {
    fn is_of_linearisation(&self) -> bool {
        let is_linear = matches!(
            self.plant,
            Represented::Itself
                | Represented::Uncertain
                | Represented::WithDisturbance { .. }
                | Represented::Loop { .. }
        );
        self.is_linearised && is_linear
    }

    /// `position 0.1 m, velocity 0.2 m/s`: half-widths that are concluded, each rounded up.
    pub(super) fn errors_at_most(&self, values: &[f64]) -> String {
        self.listed(self.states, values.iter().map(|value| at_most(*value, 4)))
    }

    /// `position 0.1 m, velocity: no useful bound`: bounds of the error that are concluded, each rounded up to so many
    /// digits, as far as they are useful.
    pub(super) fn useful_bounds(&self, values: &[f64], digits: usize) -> String {
        let one = |(k, value): (usize, &f64)| {
            if is_useful(*value, self.scales.get(k).copied().unwrap_or(0.0)) {
                return self.quantity(self.states, k, &at_most(*value, digits));
            }
            let name = self.states.get(k).cloned().unwrap_or_else(|| format!("entry {}", k + 1));
            format!("{name}: {NO_USEFUL_BOUND}")
        };
        values.iter().enumerate().map(one).collect::<Vec<_>>().join(", ")
    }

    /// Numbers with the names and units of what they bound.
    pub(super) fn listed(&self, names: &[String], numbers: impl Iterator<Item = String>) -> String {
        numbers.enumerate().map(|(k, number)| self.quantity(names, k, &number)).collect::<Vec<_>>().join(", ")
    }

    /// A number with the name and the unit of what it bounds, of these the one of index k.
    fn quantity(&self, names: &[String], k: usize, number: &str) -> String {
        match names.get(k) {
            None => format!("entry {} {number}", k + 1),
            Some(name) => match self.units.get(name) {
                Some(unit) => format!("{name} {number} {unit}"),
                None => format!("{name} {number}"),
            },
        }
    }
}

impl ProvedTheorem {
    /// The theorem in a sentence of a report; none if it says nothing of what it should be read as.
    pub fn sentence(&self, reading: &Reading<'_>) -> Option<ProvedSentence> {
        if let Represented::Jacobians { a, c, .. } = reading.plant
            && !self.theorem().contains_jacobians(a, c)
        {
            return None;
        }
        let margin = self.facts().iter().filter_map(|fact| fact.verdict.margin()).fold(f64::INFINITY, f64::min);
        let sentence = self.theorem().sentence(reading, margin)?;
        Some(ProvedSentence(match self.theorem().linear_system().filter(|_| reading.is_of_linearisation()) {
            Some(system) => format!(
                "For the linear system {system} with the matrices of the linearisation, x, u and y being the deviations from the operating point: {sentence}"
            ),
            None => sentence,
        }))
    }
}

#[cfg(feature = "all-theorems")]
impl Certificate {
    /// The bound of the error of a deployed observer as it runs, with the rounding of its steps.
    pub fn running_sentence(&self, reading: &Reading<'_>) -> Option<ProvedSentence> {
        self.deployed()?.running_sentence(reading).map(ProvedSentence)
    }

    /// What a certificate of a deployed observer without measurement noise says beside one with noise.
    pub fn noiseless_sentence(&self, reading: &Reading<'_>) -> Option<ProvedSentence> {
        self.deployed()?.noiseless_sentence(reading).map(ProvedSentence)
    }

    fn deployed(&self) -> Option<&DeployedObserver> {
        self.theorems().iter().find_map(|proved| match proved.theorem() {
            Theorem::DeployedObserver(theorem) => Some(theorem),
            _ => None,
        })
    }
}

impl Certificate {
    /// The sentences of the theorems that are proved, of those that can be read so.
    pub fn sentences(&self, reading: &Reading<'_>) -> Vec<ProvedSentence> {
        self.theorems().iter().filter_map(|theorem| theorem.sentence(reading)).collect()
    }

    /// That the loop `u = -K xhat` with a sampled cubic observer converges from everywhere, by the theorem of the
    /// observer in this certificate and that of the loop with its linear part; none unless the loop has the plant and
    /// the gain of the observer.
    ///
    /// The error of the observer tends to 0 exponentially, whatever x is, and drives `x+ = (A - BK)x + BK e`, of which
    /// `A - BK` is a diagonal block of the linear loop in the coordinates (x, e).
    pub fn sentence_of_sampled_loop(&self, linear: &Self) -> Option<ProvedSentence> {
        let observers = self.theorems().iter().filter_map(|proved| match proved.theorem() {
            Theorem::SampledCubicConvergence(found) => Some((&found.plant, &found.l)),
            Theorem::SemiImplicitCubicConvergence(found) => Some((&found.plant, &found.l)),
            _ => None,
        });
        let is_loop_of = |plant: &PlantMatrices, l: &Matrix<f64>| {
            linear.theorems().iter().any(|proved| {
                matches!(proved.theorem(), Theorem::DiscreteConvergence(of) if is_loop_of(&of.plant, &of.l, plant, l))
            })
        };
        observers.into_iter().any(|(plant, l)| is_loop_of(plant, l)).then(|| ProvedSentence(LOOP.to_owned()))
    }
}

/// `exp(-rate t)` for the rate of a decrease of `e'Pe` that is proved with this margin; nothing for the rate 0.
///
/// The shortest decimal of a rate may be above it by a rounding, by which the margin allows to increase the rate too:
/// `2 delta P <= margin I`. Where it does not, fewer digits are written.
pub(super) fn decay(rate: f64, p: &Matrix<f64>, margin: f64) -> Option<String> {
    match rate {
        0.0 => None,
        1.0 => Some("exp(-t)".to_owned()),
        rate if margin > 4.0 * largest_eigenvalue_bound(p) * rate * f64::EPSILON => {
            Some(format!("exp(-{} t)", shortest(rate)))
        }
        rate => Some(format!("exp(-{} t)", at_least(rate, 6))),
    }
}

/// `|x(t) - xhat(t)| <= K |x(0) - xhat(0)|` with K >= sqrt(cond P), at the times of this letter.
pub(super) fn envelope(p: &Matrix<f64>, estimate: &str, time: &str) -> Option<String> {
    let factor = overshoot_bound(p).ok().filter(|factor| factor.is_finite())?;
    Some(format!("|x({time}) - {estimate}({time})| <= {} |x(0) - {estimate}(0)|", at_most(factor, 5)))
}

/// What a rate of decay says of an error that tends to 0.
pub(super) fn tends_to_zero(rate: f64, p: &Matrix<f64>, margin: f64) -> String {
    match decay(rate, p, margin) {
        None => "tends to 0".to_owned(),
        Some(decay) => format!("tends to 0, at least as fast as {decay}"),
    }
}

/// The blocks of `[A E 0; 0 0 I; 0 0 0]`, `[C 0]` for a chain of this length.
pub(super) fn has_disturbance(a: &Matrix<Interval>, c: &Matrix<Interval>, states: usize, order: usize) -> bool {
    let n = a.rows();
    let Some(chain) = n.checked_sub(states) else { return false };
    if order == 0 || !chain.is_multiple_of(order) || chain == 0 {
        return false;
    }
    let q = chain / order;
    let is = |entry: &Interval, value: f64| *entry == Interval::of(value);
    let lower = (states..n).all(|i| (0..n).all(|j| is(&a[(i, j)], if j >= states && j == i + q { 1.0 } else { 0.0 })));
    let right = (0..states).all(|i| (states + q..n).all(|j| is(&a[(i, j)], 0.0)));
    lower && right && (0..c.rows()).all(|i| (states..n).all(|j| is(&c[(i, j)], 0.0)))
}

/// The blocks of the same chain at samples: `[A E 0; 0 S]`, `[C 0]`, S made of q columns of Jordan chains of the
/// eigenvalue 1, whose solutions are all polynomials in k of a degree below the length.
pub(super) fn has_sampled_disturbance(a: &Matrix<f64>, c: &Matrix<f64>, states: usize, order: usize) -> bool {
    let n = a.rows();
    let Some(chain) = n.checked_sub(states) else { return false };
    if order == 0 || !chain.is_multiple_of(order) || chain == 0 {
        return false;
    }
    let q = chain / order;
    let fits = |i: usize, j: usize| {
        let entry = a[(i, j)];
        match j.checked_sub(i) {
            Some(0) => entry == 1.0,
            Some(later) if later == q => entry != 0.0,
            Some(later) if later.is_multiple_of(q) => true,
            _ => entry == 0.0,
        }
    };
    let lower = (states..n).all(|i| (0..n).all(|j| if j < states { a[(i, j)] == 0.0 } else { fits(i, j) }));
    let right = (0..states).all(|i| (states + q..n).all(|j| a[(i, j)] == 0.0));
    lower && right && (0..c.rows()).all(|i| (states..n).all(|j| c[(i, j)] == 0.0))
}

/// `d' = 0` and so on, in words.
pub(super) fn disturbance(order: usize) -> String {
    match order {
        1 => "a constant disturbance d".to_owned(),
        2 => "a disturbance d that is linear in t".to_owned(),
        k => format!("a disturbance d that is a polynomial in t of degree {}", k - 1),
    }
}

/// The blocks `[A 0; 0 As] - [B 0; Bs Ls][0 K; -C Cs]` of the loop `u = -K xhat` of a plant (A, B, C) with so many
/// states and an observer (As, Bs, Cs, Ls) of it, of which the number of inputs is found; none for matrices without
/// these blocks.
pub(super) fn inputs_of_loop(
    a: &Matrix<Interval>,
    l: &Matrix<f64>,
    c: &Matrix<Interval>,
    states: usize,
) -> Option<usize> {
    let (n, columns) = (states, l.cols());
    if a.shape() != (2 * n, 2 * n) || l.rows() != 2 * n || c.shape() != (columns, 2 * n) {
        return None;
    }
    let zero = |entry: &Interval| *entry == Interval::of(0.0);
    let decoupled = (0..n).all(|i| (0..n).all(|j| zero(&a[(i, n + j)]) && zero(&a[(n + i, j)])));
    let fits = |m: &usize| {
        (0..*m).all(|row| (0..n).all(|j| zero(&c[(row, j)]))) && (0..n).all(|i| (*m..columns).all(|j| l[(i, j)] == 0.0))
    };
    // The fewest inputs that fit: an output that no state enters is one that no state enters.
    if decoupled { (0..=columns).find(fits) } else { None }
}

/// That the states of a loop tend to 0.
pub(super) const LOOP: &str =
    "In the loop u = r - K xhat with r = 0: x and xhat tend to 0 exponentially, from every x(0) and xhat(0).";

/// Whether `all` with this gain is the loop `[A 0; 0 A] - [B 0; B L][0 K; -C C]` of the plant and the gain L of its
/// observer.
fn is_loop_of(all: &PlantMatrices, gain: &Matrix<f64>, plant: &PlantMatrices, l: &Matrix<f64>) -> bool {
    let (n, m, p) = (plant.a.rows(), plant.b.cols(), plant.c.rows());
    let points = |matrix: &Matrix<f64>| matrix.map(|x| Interval::of(*x));
    if inputs_of_loop(&points(&all.a), gain, &points(&all.c), n).is_none() || gain.cols() != m + p {
        return false;
    }
    let is_block = |matrix: &Matrix<f64>, (i, j): (usize, usize), part: &Matrix<f64>, sign: f64| {
        (0..part.rows()).all(|r| (0..part.cols()).all(|s| matrix[(i + r, j + s)] == sign * part[(r, s)]))
    };
    let is_zero = |matrix: &Matrix<f64>, (i, j): (usize, usize), rows: usize, columns: usize| {
        (i..i + rows).all(|r| (j..j + columns).all(|s| matrix[(r, s)] == 0.0))
    };
    [0, n].into_iter().all(|i| is_block(&all.a, (i, i), &plant.a, 1.0) && is_block(gain, (i, 0), &plant.b, 1.0))
        && is_block(gain, (n, m), l, 1.0)
        && is_zero(gain, (0, m), n, p)
        && is_block(&all.c, (m, 0), &plant.c, -1.0)
        && is_block(&all.c, (m, n), &plant.c, 1.0)
        && is_zero(&all.c, (0, 0), m, n)
}
