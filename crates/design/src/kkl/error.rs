//! Errors of the checks of a KKL or [KKL+PEB] candidate.

use luenberger_linalg::LinalgError;
use luenberger_observers::ObserverError;
use luenberger_plants::PlantError;
use luenberger_proof::{ProofError, Verdict};
use nalgebra::Complex;
use thiserror::Error;

use super::witness::{CommonImage, CouplingWitness, OpenCoupling, ResidualWitness, TwoStates};
use crate::enclosure::{Axis, EnclosureError};
use crate::error::{DesignError, from_through_design_error};
use crate::number::{complex, short};

/// Why a candidate was refused. Every variant names the quantity and its value.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum KklError {
    /// A matrix or a vector is invalid, or a computation with one failed.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The box, or a Jacobian over it.
    #[error(transparent)]
    Enclosure(#[from] EnclosureError),
    /// A coordinate of the box without finite bounds: there is nothing to sample.
    #[error("{axis} runs from {lo} to {hi}: the check needs a bounded box of states and inputs")]
    Unbounded {
        /// The coordinate.
        axis: Axis,
        /// Its lower bound.
        lo: f64,
        /// Its upper bound.
        hi: f64,
    },
    /// The states that the map estimates are not states of the plant, or one is named twice.
    #[error("the estimated states {estimated:?} are not {count} different states of a plant with {states}")]
    Estimated {
        /// The indices given, from 0.
        estimated: Vec<usize>,
        /// How many the map estimates.
        count: usize,
        /// n.
        states: usize,
    },
    /// f, h, phi, Lambda or B has no value at a point of the box.
    #[error(
        "{operation} has no value at the state {state:?}{}",
        if input.is_empty() { String::new() } else { format!(" and the input {input:?}") }
    )]
    Undefined {
        /// What.
        operation: &'static str,
        /// x.
        state: Vec<f64>,
        /// u.
        input: Vec<f64>,
    },
    /// phi does not solve the equation (4).
    #[error("phi does not solve D phi f = Lambda phi + B: {0}")]
    NotASolution(ResidualWitness),
    /// It was not decided whether phi solves the equation (4).
    #[error(
        "it is undecided whether phi solves row {} of D phi f = Lambda phi + B: its residual is proved below {bound} only, where {allowed} is allowed",
        .row + 1, bound = short(*.bound), allowed = short(*.allowed)
    )]
    ResidualUndecided {
        /// Row, from 0.
        row: usize,
        /// The verified value.
        bound: f64,
        /// The required value.
        allowed: f64,
    },
    /// A matrix that has to be Hurwitz has an eigenvalue that is not in the open left half plane.
    #[error(
        "{what} is not Hurwitz: it has the eigenvalue {eigenvalue}",
        eigenvalue = complex(*.eigenvalue)
    )]
    NotHurwitz {
        /// Which matrix.
        what: &'static str,
        /// Its eigenvalue of the largest real part.
        eigenvalue: Complex<f64>,
    },
    /// A matrix that may be Hurwitz, and was not proved to be.
    #[error(
        "{what} was not proved Hurwitz: {} at the eigenvalue {eigenvalue}",
        verdict.word(),
        eigenvalue = complex(*.eigenvalue)
    )]
    HurwitzUndecided {
        /// Which matrix.
        what: &'static str,
        /// Its eigenvalue of the largest real part, in the middle of the box.
        eigenvalue: Complex<f64>,
        /// The result of the Lyapunov inequality.
        verdict: Verdict<luenberger_proof::certificate::Witness>,
    },
    /// Two states with one image.
    #[error("(phi, h) is not injective on the box: {0}")]
    NotInjective(CommonImage),
    /// Two states whose images are too close for a left inverse in binary64; injectivity is undecided.
    #[error("it is undecided whether (phi, h) is injective on the box, and it is not to eight digits: {0}")]
    Indistinct(TwoStates),
    /// B reads an entry of xi that is not before its own.
    #[error("B is to read earlier entries of xi only: {0}")]
    ReadsItself(CouplingWitness),
    /// It was not shown that B leaves the decay of the errors to Lambda.
    #[error("it is undecided whether the error of xi decays as that of Lambda alone: {0}")]
    CouplingUndecided(OpenCoupling),
    /// A run without two samples, or whose tables do not fit together.
    #[error("a run needs two samples or more of x and u: {times} times, {states} rows of x, {inputs} rows of u")]
    Samples {
        /// Entries of t.
        times: usize,
        /// Rows of x.
        states: usize,
        /// Rows of u.
        inputs: usize,
    },
    /// Times that do not increase.
    #[error("the times of the run do not increase at sample {sample}: {before}, {after}")]
    Times {
        /// The sample, from 0.
        sample: usize,
        /// The time before it.
        before: f64,
        /// Its time.
        after: f64,
    },
    /// A value of the run is not finite, or exceeds its bound.
    #[error("{what}{} is {value} at the time {time}: the run is not bounded", index + 1)]
    Unbounding {
        /// `x` or `u`.
        what: &'static str,
        /// The coordinate, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// When.
        time: f64,
    },
    /// The given parts do not agree with the equations of the plant.
    #[error("{equation} is {piece} by the pieces and {plant} by the plant, at the time {time} of the run")]
    Mismatch {
        /// Which equation, as in `x2'(1)`.
        equation: String,
        /// By the pieces.
        piece: f64,
        /// By the plant.
        plant: f64,
        /// When.
        time: f64,
    },
    /// n4 = 0: nothing is to be estimated by the [KKL+PEB]O, and b is empty.
    #[error("x4 has no entries: there is no parameter to estimate")]
    NothingToEstimate,
    /// A direction of x4 that b does not excite over some window of the run.
    #[error(
        "b is not exciting: over the {window} after {from}, int b b' has the least eigenvalue {delta}, where more than {needed} is needed; the direction of x4 that is not seen is {direction:?}",
        delta = short(*.delta), needed = short(*.needed)
    )]
    NotExciting {
        /// The least eigenvalue achieved, delta of (42).
        delta: f64,
        /// The required value, or the rounding error of delta.
        needed: f64,
        /// Length of the window, T of (42).
        window: f64,
        /// Where the worst window begins.
        from: f64,
        /// The direction of x4 that it does not show.
        direction: Vec<f64>,
    },
}

from_through_design_error!(KklError: LinalgError, ObserverError, PlantError, ProofError);
