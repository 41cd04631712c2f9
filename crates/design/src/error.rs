//! Errors of a design. Families of designs with further errors have their own types, which include this one:
//! `LpvError`, `KklError`, `NumericalKklError`.

use luenberger_linalg::LinalgError;
use luenberger_lmi::{Infeasibility, LmiError};
use luenberger_observers::ObserverError;
use luenberger_plants::PlantError;
use luenberger_proof::statement::TimeDomain;
use luenberger_proof::wording::{at_most, counted, entry, shortest};
use luenberger_proof::{ProofError, UndecidedReason, Verdict};
use nalgebra::Complex;
use thiserror::Error;

use crate::names;
use crate::number::{complex, short};
use crate::periods::{GrowingTimes, Periods};

/// Error of a design. Every variant names the quantity and its value.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DesignError {
    /// A matrix equation, a placement or an observability test failed, or a matrix is not symmetric or not definite.
    #[error(transparent)]
    Linalg(#[from] LinalgError),
    /// A matrix inequality could not be posed or solved.
    #[error(transparent)]
    Lmi(#[from] LmiError),
    /// An output that is not linear in the state, where one constant C is needed.
    #[error("the outputs should be linear in the state, and {} is between {} and {}", names::derivative(true, *.output, *.state), shortest(*.low), shortest(*.high))]
    VaryingOutput {
        /// The output, from 0.
        output: usize,
        /// The state, from 0.
        state: usize,
        /// The least derivative of the output by the state.
        low: f64,
        /// The largest.
        high: f64,
    },
    /// A matrix has the wrong shape or an entry that is not finite.
    #[error(transparent)]
    Matrix(#[from] PlantError),
    /// The observer's matrices do not fit together.
    #[error(transparent)]
    Observer(#[from] ObserverError),
    /// A certificate file could not be written: an inequality of its theorem is not proved.
    #[error("no certificate file: {0}")]
    CertificateFile(Box<luenberger_proof::certificate::Rejection>),
    /// The data of a statement are invalid for `luenberger-proof`.
    #[error(transparent)]
    Proof(#[from] ProofError),
    /// A scalar that must be positive is not.
    #[error("{what} must be positive and finite; it is {value}")]
    NotPositive {
        /// Which scalar.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A bound, a width or a covariance that is negative, infinite or not a number.
    #[error("{what} is {value}; it must be finite and not negative")]
    Negative {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The observer of the other time domain is asked of a design.
    #[error("the design is for a plant in {designed} time")]
    OtherTimeDomain {
        /// `"continuous"` or `"discrete"`.
        designed: &'static str,
    },
    /// Bounds and matrices of different numbers of disturbances.
    #[error("{bounds} bounds of disturbances are given, for {of_states} columns of E and {of_outputs} columns of D")]
    DisturbanceCount {
        /// Number of bounds.
        bounds: usize,
        /// Columns of E.
        of_states: usize,
        /// Columns of D.
        of_outputs: usize,
    },
    /// A number of the settings that is out of its range.
    #[error("{what} is {value}; it must be from {least} to {most}")]
    Setting {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Its least value.
        least: f64,
        /// Its largest value.
        most: f64,
    },
    /// A specified pole for which the observer would not converge.
    #[error(
        "the observer pole {pole} is not in the open left half plane",
        pole = complex(*.pole)
    )]
    UnstablePole {
        /// The pole.
        pole: Complex<f64>,
    },
    /// A specified pole for which an observer in discrete time would not converge.
    #[error("the observer pole {pole} is not inside the unit circle", pole = complex(*.pole))]
    PoleOutside {
        /// The pole.
        pole: Complex<f64>,
    },
    /// A gain does not stabilise in discrete time.
    #[error(
        "{what} has an eigenvalue that is not inside the unit circle{}",
        unstable("spectral radius", *.radius, *.radius < 1.0)
    )]
    NotSchur {
        /// Which matrix.
        what: &'static str,
        /// Its largest modulus of an eigenvalue.
        radius: f64,
    },
    /// A gain does not stabilise.
    #[error("{what} is not Hurwitz{}", unstable("spectral abscissa", *.abscissa, *.abscissa < 0.0))]
    NotHurwitz {
        /// Which matrix.
        what: &'static str,
        /// Its largest real part of an eigenvalue.
        abscissa: f64,
    },
    /// The rows of C are linearly dependent, so that gains of the form `-P^-1 C'S` do not exhaust the admissible ones.
    #[error(
        "C does not have full row rank: with rows of length one its smallest singular value is {sigma_min}",
        sigma_min = short(*.sigma_min)
    )]
    DependentOutputs {
        /// Smallest singular value of C with its rows scaled to length one.
        sigma_min: f64,
    },
    /// A method for one output was called for a plant with several.
    #[error("{what} needs a plant with one output; this one has {outputs}")]
    SeveralOutputs {
        /// The method.
        what: &'static str,
        /// Number of outputs.
        outputs: usize,
    },
    /// Convergence at varying periods is not proved.
    #[error("convergence is not proved for {periods}{}", why_unproved(.witness.as_ref(), .largest.as_deref()))]
    VaryingPeriods {
        /// The periods.
        periods: Box<Periods>,
        /// Times between corrections for which the error grows; none were found where it is empty.
        witness: Option<GrowingTimes>,
        /// The largest spread of periods, with the most misses, for which a search proved convergence.
        largest: Option<Box<Periods>>,
    },
    /// Bounds on rounding of a step that is not in closed form.
    #[error(
        "bounds on the rounding of a step are proved for the closed form of the cubic flow, hence for a radial gain; this \
         observer takes a semi-implicit step"
    )]
    SemiImplicit,
    /// [`LyapunovWeight::InverseCovariance`](crate::LyapunovWeight::InverseCovariance) was requested for a gain that is
    /// not a Kalman gain.
    #[error("P cannot be the information matrix: only a Kalman gain comes with a covariance")]
    NoCovariance,
    /// A [`LyapunovWeight`](crate::LyapunovWeight) for a design whose P came from a linear matrix inequality.
    #[error("a Lyapunov weight has no effect here: the inequality that gave the gain gave P as well")]
    LyapunovMatrixGiven,
    /// A decay rate is negative or not finite.
    #[error("the decay rate must be finite and not negative; it is {rate}")]
    BadRate {
        /// The rate.
        rate: f64,
    },
    /// A sector whose ends are not finite or not in order, or a nonlinearity that acts on nothing or depends on
    /// nothing.
    #[error(
        "a sector needs finite ends low <= high and matrices G, H: low = {low}, high = {high}, G has {acts} columns, H {depends} rows"
    )]
    BadSector {
        /// Its lower end.
        low: f64,
        /// Its upper end.
        high: f64,
        /// Columns of G.
        acts: usize,
        /// Rows of H.
        depends: usize,
    },
    /// A polytope without vertices.
    #[error("a polytope of Jacobians needs at least one vertex")]
    NoVertices,
    /// Outputs that are the first states of the plant, more of them than states, or none.
    #[error("{outputs} outputs of {states} states: the outputs are the first states, at least one and at most all")]
    OutputCount {
        /// Number of outputs.
        outputs: usize,
        /// Number of states.
        states: usize,
    },
    /// No output, or as many outputs as states: there is no block of unmeasured states.
    #[error("{outputs} outputs of {states} states leave no measured or no unmeasured state")]
    NothingUnmeasured {
        /// Number of states.
        states: usize,
        /// Number of outputs.
        outputs: usize,
    },
    /// An output that is not linear in the state: no linear change of coordinates makes it one.
    #[error("output y{} is {found} at the state {point:?}, where the C of another point makes it {expected}", output + 1)]
    NonlinearOutput {
        /// Index of the output, from 0.
        output: usize,
        /// `C x`.
        expected: f64,
        /// The output.
        found: f64,
        /// The state.
        point: Vec<f64>,
    },
    /// An output that depends on the input, for an observer whose theory excludes it.
    #[error("{} depends on the input: this observer is for y = h(t, x)", crate::names::output(*output))]
    Feedthrough {
        /// Index of the output, from 0.
        output: usize,
    },
    /// A derivative of the plant is not finite at a point.
    #[error("{what}{} is {value} at the state {point:?}", entry(*row, *column))]
    NotDifferentiable {
        /// Which Jacobian.
        what: &'static str,
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// The entry.
        value: f64,
        /// The state.
        point: Vec<f64>,
    },
    /// `C N` has an eigenvalue on the imaginary axis up to rounding: N is rank-deficient or `S + S'` singular, which
    /// the method does not decide.
    #[error(
        "C N has an eigenvalue of real part {real_part}, zero up to rounding: this method does not decide such gains",
        real_part = short(*.real_part)
    )]
    DegenerateGain {
        /// The real part.
        real_part: f64,
    },
    /// No P exists for the given gains.
    #[error("{what} is infeasible: {reason}")]
    Infeasible {
        /// The inequality.
        what: &'static str,
        /// The quantity that refutes it.
        reason: InfeasibilityReason,
    },
    /// Neither a solution nor a refutation was found.
    #[error(
        "{what} is undecided: {why}{}{}",
        if best.is_nan() { String::new() } else { format!(" (best margin {})", short(*.best)) },
        seen.as_ref().map_or_else(String::new, |seen| format!("; {seen}"))
    )]
    Undecided {
        /// The inequality.
        what: &'static str,
        /// The reason.
        why: UndecidedReason,
        /// The best margin found.
        best: f64,
        /// A mode that is unobservable to working precision, a possible reason.
        seen: Option<Box<NearlyHidden>>,
    },
    /// Multipliers refute the inequality with rounded intermediate results, which does not refute it for the stored
    /// numbers.
    #[error("{what} is undecided: it is refuted only with {rounded} as rounded ({witness})")]
    RefutedAsRounded {
        /// The inequality.
        what: &'static str,
        /// The rounded quantity.
        rounded: &'static str,
        /// The multipliers, verified for the rounded numbers.
        witness: Infeasibility,
    },
    /// A constant disturbance that a state at rest hides: `rank [A E; C 0] < n + q`, in discrete time
    /// `rank [A - I, E; C, 0] < n + q`, decided exactly. The direction is one of the kernel, with entries rounded at
    /// the end.
    #[error(
        "{}, so that {} has no full column rank (smallest singular value {}; {} for {}{})",
        unseen(.d, .x, *.is_discrete), if *.is_discrete { "[A - I, E; C, 0]" } else { "[A E; C 0]" },
        short(*.sigma_min), counted(.d.len(), "disturbance"), counted(*.outputs, "output"),
        zero_at_rest(.d, .x, *.outputs, *.is_discrete)
    )]
    UnseenDisturbance {
        /// The disturbance.
        d: Vec<f64>,
        /// The state.
        x: Vec<f64>,
        /// The number of outputs.
        outputs: usize,
        /// The smallest singular value of this matrix in floating point.
        sigma_min: f64,
        /// Whether the plant is in discrete time.
        is_discrete: bool,
    },
    /// An unknown input that is not in the first derivative of the outputs: `rank(CE) < q`, decided exactly.
    #[error(
        "rank(C E) is less than the number of unknown inputs, {}: for d = ({}) |E d| = {} and |C E d| = {}, so that {}",
        .d.len(), listed(.d), short(*.acting), short(*.seen), unmatched(.d.len(), *.outputs, *.acting)
    )]
    UnmatchedDisturbance {
        /// The direction of the unknown input.
        d: Vec<f64>,
        /// `|C E d|`.
        seen: f64,
        /// `|E d|`.
        acting: f64,
        /// The number of outputs.
        outputs: usize,
    },
    /// A bound of a norm that no gain keeps, by multipliers of its inequality.
    #[error("no gain makes the {norm} norm of the error less than {}{}: {witness}", short(*.gamma), best_found(*.best))]
    NormTooSmall {
        /// The norm.
        norm: &'static str,
        /// The bound.
        gamma: f64,
        /// The least norm of the gains that were found.
        best: Option<f64>,
        /// The multipliers, verified.
        witness: Infeasibility,
    },
    /// No gain with a norm below a bound was found, and none was proved not to exist.
    #[error(
        "not found: a gain{} that makes the {norm} norm of the error less than {}{}; that there is none is not proved{}{}",
        if *is_limited { " within `max_gain`" } else { "" }, short(*.gamma), best_found(*.best),
        if *is_limited { ", because the inequality for `max_gain` is sufficient but not necessary" } else { "" },
        why.as_ref().map_or_else(String::new, |why| format!(": {why}"))
    )]
    NormNotFound {
        /// The norm.
        norm: &'static str,
        /// The bound.
        gamma: f64,
        /// The least norm of the gains that were found.
        best: Option<f64>,
        /// Whether the gain is bounded.
        is_limited: bool,
        /// Why its inequality is undecided; none where it has a solution without the bound of the gain.
        why: Option<UndecidedReason>,
    },
    /// The least norm is requested, and nothing disturbs the states of a stable plant.
    #[error(
        "E = 0 and A is stable: the least {norm} norm is 0, that of the gain L = 0, since nothing disturbs the states"
    )]
    NoDisturbance {
        /// The norm.
        norm: &'static str,
    },
    /// The least norm is requested, and an output or a combination of outputs has no noise.
    #[error(
        "D does not have full row rank for {} (smallest singular value {}): a measurement without noise makes the least norm that of gains without bound",
        counted(*.outputs, "output"), short(*.sigma_min)
    )]
    NoiselessOutput {
        /// The number of outputs.
        outputs: usize,
        /// The smallest singular value of D.
        sigma_min: f64,
    },
    /// (A, E, C), or (A, E, C, F), is not strongly detectable.
    #[error(
        "to working precision (A, E, C{}) has the invariant zero {}, which is not {}: every observer whose error does not depend on the unknown input has it as a pole",
        if *is_fed { ", F" } else { "" }, complex(*.zero),
        match time { TimeDomain::Continuous => "in the open left half plane", TimeDomain::Discrete => "inside the unit circle" }
    )]
    UnstableZero {
        /// The zero.
        zero: Complex<f64>,
        /// The time of the plant.
        time: TimeDomain,
        /// Whether the unknown input enters the outputs.
        is_fed: bool,
    },
    /// An unknown input in the outputs that cannot be decoupled: `[C E, F1; F, 0]` does not have full column rank.
    #[error(
        "S = [C E, F1; F, 0] does not have full column rank, smallest singular value {}: {} not 0 have to be independent, and no combination of the unknown inputs may be hidden from y and from what y has of its own derivative; here d = ({}) is",
        short(*.sigma_min),
        if *fed == 1 { "the 1 column F1 of F that is".to_owned() } else { format!("the {fed} columns F1 of F that are") },
        listed(.d)
    )]
    UnmatchedInOutputs {
        /// The unknown input.
        d: Vec<f64>,
        /// The number of columns of F that are not 0.
        fed: usize,
        /// The smallest singular value.
        sigma_min: f64,
    },
    /// A cubic term of an unknown-input observer whose innovation has the unknown input, or in discrete time.
    #[error(
        "the cubic term of an unknown-input observer is for plants in continuous time whose outputs do not have the unknown input: the innovation r = C e + F d would add it to the error"
    )]
    CubicOfOutputs,
    /// Poles of an unknown-input observer without the invariant zeros of (A, E, C).
    #[error(
        "to working precision the invariant zeros of (A, E, C) that no gain moves, {}, are among the poles of every unknown-input observer, and the poles specified do not contain them",
        zeros.iter().map(|zero| complex(*zero)).collect::<Vec<_>>().join(", ")
    )]
    FixedPoles {
        /// The zeros.
        zeros: Vec<Complex<f64>>,
    },
    /// Poles that are not distinct have no modal coordinates.
    #[error(
        "the poles of A - LC are not distinct enough for modal coordinates: two of them are {} apart",
        short(*.separation)
    )]
    NoModalCoordinates {
        /// The least distance of two poles, in the units that were tried.
        separation: f64,
    },
    /// Eigenvectors that are nearly dependent, of poles that are distinct.
    #[error("{}", dependent_modes(*.condition))]
    DependentModes {
        /// The condition number of the matrix of the eigenvectors, of length 1, in floating point; infinite where they
        /// were not found.
        condition: f64,
    },
    /// The equations of the comparison system of an interval observer have no positive solution in floating point.
    #[error(
        "whether the width of the interval stays bounded is undecided: the equations of the comparison system of the error have no finite, positive solution in floating point"
    )]
    ComparisonUndecided,
    /// The comparison system of an interval observer is not stable.
    #[error(
        "the width of the interval would grow: the comparison system of the error has the {} {}, which is not below {limit}",
        if *.limit == 0.0 { "spectral abscissa" } else { "spectral radius" },
        short(*.size)
    )]
    WidthGrows {
        /// Its spectral abscissa, or its spectral radius in discrete time.
        size: f64,
        /// 0, or 1 in discrete time.
        limit: f64,
        /// Whether its coordinates are those of the plant.
        plant: bool,
    },
    /// The gain of least width of an output without noise.
    #[error(
        "the gain of the least width needs a bound of the noise of every output above 0, and y{} has none: no gain is too large for it",
        output + 1
    )]
    QuietOutput {
        /// The output, from 0.
        output: usize,
    },
    /// No gain makes the comparison system stable in the coordinates of the plant, by multipliers of its linear
    /// program.
    #[error("no gain makes the comparison system of the error stable in the coordinates of the plant: {witness}")]
    NoLeastWidth {
        /// The multipliers, verified.
        witness: Infeasibility,
    },
    /// A sliding-mode observer of an order without known gains.
    #[error("gains of sliding-mode observers are for 1 to 5 states, not for {order}")]
    SlidingOrder {
        /// The number of states.
        order: usize,
    },
    /// A number that is not representable in the format of the target.
    #[error("{}", not_stored(.what, *.value, *.format))]
    NotStored {
        /// What it is.
        what: &'static str,
        /// The number.
        value: f64,
        /// The format.
        format: luenberger_proof::statement::Format,
    },
    /// An exponential that is too large to be enclosed.
    #[error("exp(A h) is too large to be enclosed for the period {}", short(*.period))]
    Exponential {
        /// The period.
        period: f64,
    },
    /// Floating point finds an unstable eigenvalue, and exact arithmetic does not confirm it.
    #[error(
        "whether {what} is {} is undecided: its {} is {}, up to rounding",
        if *.limit == 0.0 { "Hurwitz" } else { "Schur stable" },
        if *.limit == 0.0 { "spectral abscissa" } else { "spectral radius" },
        short(*.size)
    )]
    StabilityUndecided {
        /// Which matrix.
        what: &'static str,
        /// Its spectral abscissa in floating point, or its spectral radius in discrete time.
        size: f64,
        /// 0, or 1 in discrete time.
        limit: f64,
    },
    /// Bounds of disturbances that do not act on the error: `(E - L D) W = 0`, decided exactly.
    #[error(
        "no disturbance within these bounds reaches the error, since (E - L D) W = 0: it tends to 0, and there is nothing to bound"
    )]
    NothingReachesTheError,
    /// A hidden mode of another pair than (A, C) of the plant, which the error calls (A, C).
    #[error("{}", error.to_string().replace("the pair (A, C)", &pair.to_string()))]
    OfPair {
        /// The pair.
        pair: Pair,
        /// What is said of it.
        error: Box<DesignError>,
    },
    /// A mode that no output sees does not decay, or decays too slowly for the rate, which is decided exactly for the
    /// numbers as stored.
    #[error(
        "the pair (A, C) is not detectable{}: unobservable eigenvalue {}, PBH margin {}, decided exactly for the numbers as stored",
        if *.rate > 0.0 { format!(" at the rate {}", short(*.rate)) } else { String::new() },
        complex(*.eigenvalue), short(*.margin)
    )]
    NotDetectable {
        /// The eigenvalue, to rounding.
        eigenvalue: Complex<f64>,
        /// Its margin in floating point.
        margin: f64,
        /// The rate asked for.
        rate: f64,
    },
}

/// Why there are no modal coordinates of distinct poles.
fn dependent_modes(condition: f64) -> String {
    if condition.is_finite() {
        format!(
            "the eigenvectors of A - LC are too close to dependent for modal coordinates: their condition number is {}",
            short(condition)
        )
    } else {
        "the eigenvectors of A - LC, for modal coordinates, were not found in floating point".to_owned()
    }
}

/// A pair that takes the place of (A, C) in a design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Pair {
    /// That of the plant with its input held over a period.
    Sampled,
    /// That of the plant whose unknown input is decoupled, `T = I - H C`.
    Decoupled,
    /// That of the plant with a disturbance among its states.
    WithDisturbance,
    /// That of the plant with every nonlinearity in the middle of its sector.
    MiddleOfSectors,
    /// That of a vertex of a polytope, from 0.
    Vertex(usize),
}

impl core::fmt::Display for Pair {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Sampled => f.write_str("the sampled pair (Ad, C)"),
            Self::Decoupled => f.write_str("the pair (T A, C) of the decoupled plant"),
            Self::WithDisturbance => f.write_str("the pair (A, C) of the plant with its disturbance"),
            Self::MiddleOfSectors => f.write_str("the pair (A, C) with every nonlinearity in the middle of its sector"),
            Self::Vertex(k) => write!(f, "the pair (A, C) of vertex {}", k + 1),
        }
    }
}

/// Why a number is not one of the format.
fn not_stored(what: &str, value: f64, format: luenberger_proof::statement::Format) -> String {
    match format.round(value) {
        None => format!("{what}, {}, is beyond the range of {format}", short(value)),
        Some(_) => format!("{what}, {}, is no number of {format}, which would round it", shortest(value)),
    }
}

/// The number of an unstable matrix, which rounding may have put on the other side.
fn unstable(number: &str, value: f64, otherwise: bool) -> String {
    let value = short(value);
    if otherwise {
        format!(", decided exactly: in floating point its {number} is {value}")
    } else {
        format!(": its {number} is {value}")
    }
}

/// The best value of what was tried.
fn best_found(best: Option<f64>) -> String {
    best.map_or_else(String::new, |best| format!(" (the best that was found is {})", at_most(best, 5)))
}

/// What the outputs do not see: a disturbance at a state at rest, a disturbance that does not act, or a state alone.
fn unseen(d: &[f64], x: &[f64], is_discrete: bool) -> String {
    let rest = if is_discrete { "x" } else { "0" };
    match (vanishes(d), vanishes(x)) {
        (true, _) => format!("no output sees the state x = ({}) at rest: A x = {rest} and C x = 0", listed(x)),
        (false, true) => format!("the disturbance d = ({}) does not act: E d = 0", listed(d)),
        (false, false) => format!(
            "no output sees the constant disturbance d = ({}): with x = ({}) both A x + E d = {rest} and C x = 0",
            listed(d),
            listed(x)
        ),
    }
}

/// Whether it is a zero of the plant from d to y.
fn zero_at_rest(d: &[f64], x: &[f64], outputs: usize, is_discrete: bool) -> &'static str {
    match d.len() <= outputs && !vanishes(d) && !vanishes(x) {
        true if is_discrete => "; an invariant zero of (A, E, C) at 1",
        true => "; an invariant zero of (A, E, C) at 0",
        false => "",
    }
}

fn vanishes(entries: &[f64]) -> bool {
    entries.iter().all(|x| *x == 0.0)
}

/// `1, 0.5`.
fn listed(entries: &[f64]) -> String {
    entries.iter().map(|x| short(*x)).collect::<Vec<_>>().join(", ")
}

/// What an unknown input that C E does not show means.
fn unmatched(inputs: usize, outputs: usize, acting: f64) -> String {
    if acting == 0.0 {
        "the columns of E are linearly dependent: leave one out".to_owned()
    } else if inputs > outputs {
        format!("{} cannot be decoupled from {}", counted(inputs, "unknown input"), counted(outputs, "output"))
    } else {
        "no output has this disturbance in its first derivative".to_owned()
    }
}

/// A mode that is unobservable in floating point but not in exact arithmetic: an observation, not a proof.
#[derive(Debug, Clone, PartialEq)]
pub struct NearlyHidden {
    /// Which pair (A, C), if there are several.
    pub place: Option<String>,
    /// The eigenvalue, to rounding.
    pub eigenvalue: Complex<f64>,
    /// The smallest singular value of `[A - lambda I; C]`, relative, after scaling of the pair.
    pub margin: f64,
}

impl core::fmt::Display for NearlyHidden {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("to working precision")?;
        if let Some(place) = &self.place {
            write!(f, ", at {place},")?;
        }
        write!(f, " the eigenvalue {} is unobservable (PBH margin {})", complex(self.eigenvalue), short(self.margin))
    }
}

impl DesignError {
    /// The same, where a hidden mode is one of this pair and not of (A, C) of the plant.
    #[must_use]
    pub fn of_pair(self, pair: Pair) -> Self {
        match self {
            Self::NotDetectable { .. }
            | Self::Linalg(LinalgError::Unobservable { .. } | LinalgError::NotDetectable { .. }) => {
                Self::OfPair { pair, error: Box::new(self) }
            }
            other => other,
        }
    }

    /// The same, undecided, with the best margin found.
    pub(crate) fn with_seen(self, nearly: Option<NearlyHidden>) -> Self {
        match self {
            Self::Undecided { what, why, best, seen: None } => {
                Self::Undecided { what, why, best, seen: nearly.map(Box::new) }
            }
            other => other,
        }
    }

    /// The error for the verdict on the inequality `what`, if a proof was required and there is none: no verdict, or an
    /// insufficient one.
    pub(crate) fn not_proved(what: &'static str, verdict: Option<Verdict<Infeasibility>>) -> Self {
        match verdict {
            Some(Verdict::Refuted { witness }) => Self::Infeasible { what, reason: InfeasibilityReason::Dual(witness) },
            Some(Verdict::Undecided { why, best }) => Self::Undecided { what, why, best, seen: None },
            Some(Verdict::Proved { margin }) => Self::Undecided {
                what,
                why: UndecidedReason::ProposalNotProved { estimate: margin },
                best: margin,
                seen: None,
            },
            None => {
                let why = UndecidedReason::NoProposal { status: "no attempt was made" };
                Self::Undecided { what, why, best: 0.0, seen: None }
            }
        }
    }
}

/// An error of one family of designs takes through [`DesignError`] what that takes.
macro_rules! from_through_design_error {
    ($error:ty: $($source:ty),+) => {$(
        impl From<$source> for $error {
            fn from(source: $source) -> Self {
                Self::Design(source.into())
            }
        }
    )+};
}
pub(crate) use from_through_design_error;

impl From<luenberger_proof::certificate::Rejection> for DesignError {
    fn from(rejection: luenberger_proof::certificate::Rejection) -> Self {
        Self::CertificateFile(Box::new(rejection))
    }
}

/// Why an inequality is infeasible.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum InfeasibilityReason {
    /// Multipliers of the inequalities, verified exactly.
    #[error("{0}")]
    Dual(Infeasibility),
    /// The largest real part of an eigenvalue of `C N`, to rounding; that an eigenvalue has at least half of it was
    /// decided exactly. If `P N = -C'S` with `P > 0` and `S + S' >= 0`, none is positive.
    #[error(
        "C N has an eigenvalue of real part {value} > 0, but P N = -C'S with S + S' >= 0 and P > 0 makes it <= 0",
        value = short(*.0)
    )]
    SignOfCn(f64),
}

/// Why convergence at varying periods is not proved, and where it is.
fn why_unproved(witness: Option<&GrowingTimes>, largest: Option<&Periods>) -> String {
    let why = match witness {
        Some(growing) => format!(": {growing}"),
        None => ": no common quadratic Lyapunov function was found".to_owned(),
    };
    match largest {
        Some(periods) => format!("{why}; it is proved for {periods}"),
        None => why,
    }
}
