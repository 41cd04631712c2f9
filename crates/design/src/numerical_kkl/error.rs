//! Errors of the numerical KKL design.

use luenberger_linalg::LinalgError;
use luenberger_observers::ObserverError;
use luenberger_plants::PlantError;
use luenberger_proof::wording::significant;
use thiserror::Error;

use crate::error::{DesignError, from_through_design_error};
use crate::number::short;

/// Why a transformation was not computed, or not inverted. Every variant names the quantity and its value.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum NumericalKklError {
    /// A matrix, a pole or a column is invalid, or a computation with one failed.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// No target states, no plant states or no outputs.
    #[error("n = {states} states, p = {outputs} outputs, n_z = {targets} target states: each must be at least 1")]
    Empty {
        /// n.
        states: usize,
        /// p.
        outputs: usize,
        /// n_z.
        targets: usize,
    },
    /// The poles of the target, one set per output, do not fill it.
    #[error("{poles} poles for each of {outputs} outputs do not make {targets} target states")]
    PoleCount {
        /// Poles given.
        poles: usize,
        /// p.
        outputs: usize,
        /// n_z.
        targets: usize,
    },
    /// An order of the Bessel prototype that is not offered.
    #[error("a Bessel prototype of order {order}: orders 1 to {largest} are offered")]
    BesselOrder {
        /// The order.
        order: usize,
        /// The largest offered.
        largest: usize,
    },
    /// (D, B) is not controllable: some target states do not depend on the output, and carry no information on x.
    #[error(
        "(D, B) is not controllable: the eigenvalues of its Gramian have the ratio {ratio}",
        ratio = short(*.ratio)
    )]
    Uncontrollable {
        /// Smallest eigenvalue of the controllability Gramian over the largest.
        ratio: f64,
    },
    /// A box without interior, or with a bound that is not finite.
    #[error("axis {} of the box runs from {lower} to {upper}", axis + 1)]
    Box {
        /// The axis, from 0.
        axis: usize,
        /// Where it begins.
        lower: f64,
        /// Where it ends.
        upper: f64,
    },
    /// A function of the domain's inequalities that is NaN or infinite in the box.
    #[error("inequality {} of the domain has no finite value at {at:?}", index + 1)]
    Inequality {
        /// Which of them, from 0.
        index: usize,
        /// A state of the box.
        at: Vec<f64>,
    },
    /// Inequalities that hold at few of the points of the box that were tried, or at none.
    #[error(
        "the inequalities of the domain hold at {inside} of {tried} points of the box: a box closer to the domain is needed"
    )]
    SmallDomain {
        /// Points at which they hold.
        inside: usize,
        /// Points that were tried.
        tried: usize,
    },
    /// Tables larger than are computed.
    #[error(
        "the table of T would have {} coefficients, {} MB (limit {} coefficients, which is {per_axis} points per axis)",
        significant(*points, 3), significant(*megabytes, 3), significant(*most as f64, 3)
    )]
    GridTooLarge {
        /// Coefficients of all tables, each of n_z numbers: two more than grid points on each axis.
        points: f64,
        /// The most that is computed.
        most: usize,
        /// Memory of all tables.
        megabytes: f64,
        /// The most points per axis with so many states and tables.
        per_axis: usize,
    },
    /// A family of inputs without interior, or with a bound that is not finite.
    #[error("the family of input {} goes from {lower} to {upper}", input + 1)]
    Family {
        /// The input, from 0.
        input: usize,
        /// Its lower end.
        lower: f64,
        /// Its upper end.
        upper: f64,
    },
    /// What fails at one input of a family.
    #[error("at the held input u = {input:?}: {error}")]
    HeldInput {
        /// The input.
        input: Vec<f64>,
        /// What fails there.
        error: Box<NumericalKklError>,
    },
    /// T varies more than the grid can show: it is rough (D too slow for the backward expansion of the plant), or the
    /// grid coarse.
    #[error(
        "interpolation error {} % of the width of T (limit {} %)", significant(100.0 * error, 3), significant(100.0 * most, 3)
    )]
    Unresolved {
        /// The largest error at the held-out points, in units of the width of T(box).
        error: f64,
        /// The largest that is accepted.
        most: f64,
    },
    /// No cut-off frequency that was tried has a design.
    #[error(
        "none of {tried} designs with cut-off frequencies from {} to {} succeeds; the last one, on {points} points per axis: {last}",
        significant(*slowest, 3), significant(*fastest, 3)
    )]
    NoneFits {
        /// Designs.
        tried: usize,
        /// The lowest cut-off frequency.
        slowest: f64,
        /// The highest.
        fastest: f64,
        /// Grid points per axis of the last design.
        points: usize,
        /// Its error.
        last: Box<NumericalKklError>,
    },
    /// f or h is NaN or infinite somewhere.
    #[error("the plant, integrated backward by {time} from {from:?}, is not finite")]
    NotFinite {
        /// Where the trajectory began.
        from: Vec<f64>,
        /// Time backward from there.
        time: f64,
    },
    /// A trajectory that leaves everything backward in time; slowing the plant outside the box keeps it.
    #[error(
        "the plant escapes backward in time: from {from:?}, {norm} half-widths of the box are passed {time} earlier",
        norm = short(*.norm)
    )]
    Escapes {
        /// Where the trajectory began.
        from: Vec<f64>,
        /// Time backward from there.
        time: f64,
        /// Distance from the centre reached, in half-widths of the box.
        norm: f64,
    },
    /// The integrator reached its largest number of steps before the end of a trajectory.
    #[error(
        "the integration from {from:?} stopped after {steps} steps, the largest number, at time {time} with step size {step}",
        step = short(*.step)
    )]
    Stalled {
        /// Where the trajectory began.
        from: Vec<f64>,
        /// How far it came.
        time: f64,
        /// The last step size.
        step: f64,
        /// Attempted steps.
        steps: usize,
    },
    /// Two states of the box that T maps to one point, to the accuracy of T: y does not distinguish them.
    #[error(
        "T is not injective on the box: {first:?} and {second:?}, {distance} apart, have images {gap} apart, \
         and T is known to {accuracy}",
        distance = short(*.distance), gap = short(*.gap), accuracy = short(*.accuracy)
    )]
    NotInjective {
        /// One state.
        first: Vec<f64>,
        /// The other.
        second: Vec<f64>,
        /// `|x - x'|`.
        distance: f64,
        /// `|T(x) - T(x')|`.
        gap: f64,
        /// How accurately T is known.
        accuracy: f64,
    },
    /// The progress callback ended the design.
    #[error("stopped at step {done} of {total} of the stage \"{stage}\"")]
    Stopped {
        /// The stage.
        stage: &'static str,
        /// Steps of it that were done.
        done: usize,
        /// Steps that it has.
        total: usize,
    },
}

from_through_design_error!(NumericalKklError: LinalgError, ObserverError, PlantError);
