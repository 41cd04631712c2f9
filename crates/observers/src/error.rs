//! Errors in the data of an observer.

use core::fmt;

use luenberger_plants::PlantError;
use nalgebra::RealField;

/// A state in an error, where nothing may be allocated: its first entries, up to eight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    entries: [f64; 8],
    states: usize,
}

impl Point {
    /// The point with these entries.
    pub fn new(entries: impl ExactSizeIterator<Item = f64>) -> Self {
        let mut point = Self { entries: [0.0; 8], states: entries.len() };
        for (place, entry) in point.entries.iter_mut().zip(entries) {
            *place = entry;
        }
        point
    }

    /// The entries, eight at most.
    pub fn entries(&self) -> &[f64] {
        &self.entries[..self.states.min(8)]
    }

    /// How many states there are.
    pub fn states(&self) -> usize {
        self.states
    }
}

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.entries())?;
        if self.states > 8 { write!(f, ", the first 8 of {}", self.states) } else { Ok(()) }
    }
}

/// Error in the matrices or parameters of an observer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ObserverError {
    /// A matrix of the wrong shape, or with an entry that is not finite.
    #[error(transparent)]
    Matrix(#[from] PlantError),
    /// A sampling period that is not a positive number.
    #[error("the sampling period is {period}; it must be positive and finite")]
    Period {
        /// The period given.
        period: f64,
    },
    /// A prediction over a time that is long for the plant.
    #[error(
        "|A| times the longest time between samples is {needed:.0}: the prediction has {most} substeps at most, one for \
         each 1"
    )]
    PredictionTime {
        /// `|A|`, the largest row sum, times the longest time.
        needed: f64,
        /// The most substeps.
        most: usize,
    },
    /// A time among the inputs that has an effect on the plant.
    #[error(
        "the last input is the time that passes; its columns of B and D must be 0, and one has the entry {effect:e}"
    )]
    TimeInput {
        /// The entry.
        effect: f64,
    },
    /// A weight theta for which `y~' theta y~` can be negative.
    #[error("theta is not positive semidefinite: pivot {pivot:.2e} at ({0}, {0}) of its symmetric part", row + 1)]
    ThetaIndefinite {
        /// Row of the pivot, from 0.
        row: usize,
        /// The pivot: negative, or zero where the rest of its row is not.
        pivot: f64,
    },
    /// A rate `w < 0`, for which the cubic flow escapes in finite time, or `w = 0` with a gain N that is not 0.
    #[error("C N = -w I with w = {w:e}: w must be positive (or zero together with N)")]
    Rate {
        /// The rate.
        w: f64,
    },
    /// A gain N that is not radial: the cubic flow has no closed form.
    #[error("C N differs from -w I, w = {w:e}, by {deviation:.2e}; rounding explains at most {tolerance:.2e}")]
    NotRadial {
        /// The rate that was stated.
        w: f64,
        /// Largest entry of `|C N + w I|`.
        deviation: f64,
        /// The largest deviation accepted.
        tolerance: f64,
    },
    /// A matrix G that is not `-C N`.
    #[error("G differs from -C N by {deviation:.2e}; rounding explains at most {tolerance:.2e}")]
    Coupling {
        /// Largest entry of `|G + C N|`.
        deviation: f64,
        /// The largest deviation accepted.
        tolerance: f64,
    },
    /// A factor eta of the mean-value gain with which the internal error may grow.
    #[error(
        "eta = {eta}: what is lost is the decrease of the internal error, |e|^2/2 changes by at most \
         (1/2 - eta) sum alpha_k e_k^2, which is negative for eta > 1/2 only"
    )]
    Eta {
        /// The factor.
        eta: f64,
    },
    /// An output that is not the state of the same number.
    #[error(
        "output y{0} is {found} where the state x{0} is {expected}: y must be the first states; change coordinates, \
         as luenberger-design's mean_value::OutputCoordinates does for every linear output of full rank",
        output + 1
    )]
    OutputNotState {
        /// Index of the output, from 0.
        output: usize,
        /// The state of that number at the point tried; NaN if there is none.
        expected: f64,
        /// The output there; NaN if there is none.
        found: f64,
    },
    /// A Jacobian that does not exist somewhere on the segment from xhat to xhat + e.
    #[error("Df({}, {}) is not finite at the state {point}, which is xhat + s e with s = {s}", row + 1, column + 1)]
    JacobianNotFinite {
        /// How far along the segment, from 0 to 1.
        s: f64,
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// The state there.
        point: Point,
    },
    /// A right-hand side of the plant that does not exist at an end of the segment from xhat to xhat + e.
    #[error("f{} is not finite at the state {point}, which is xhat + s e with s = {s}", row + 1)]
    SlopeNotFinite {
        /// How far along the segment, from 0 to 1.
        s: f64,
        /// Row of the entry, from 0.
        row: usize,
        /// The state there.
        point: Point,
    },
    /// A covariance that is not symmetric.
    #[error("{what} is not symmetric: entries ({}, {}) and ({1}, {0}) differ by {difference:.2e}", row + 1, column + 1)]
    NotSymmetric {
        /// Name of the matrix.
        what: &'static str,
        /// Row of the entry below the diagonal, from 0.
        row: usize,
        /// Column of the entry below the diagonal, from 0.
        column: usize,
        /// How much it differs from its mirror image.
        difference: f64,
    },
    /// A covariance that is not positive semidefinite, or not positive definite where that is required.
    #[error("{what} is not a covariance: pivot {pivot:.2e} at ({0}, {0})", row + 1)]
    NotDefinite {
        /// Name of the matrix.
        what: &'static str,
        /// Row of the pivot, from 0.
        row: usize,
        /// The pivot of the elimination: negative, or zero.
        pivot: f64,
    },
    /// An entry of a bound or of a comparison system that must not be negative.
    #[error("{what}({}, {}) is {value}, and must not be negative", row + 1, column + 1)]
    Negative {
        /// Name of the matrix.
        what: &'static str,
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// Zero Runge-Kutta substeps between samples; at least 1 is required.
    #[error("a filter needs at least one step of integration between two samples")]
    Substeps,
    /// A gain, pole or rate that is not a positive number.
    #[error("{what} is {value}; it must be positive and finite")]
    NotPositive {
        /// Name of the number.
        what: &'static str,
        /// The number given.
        value: f64,
    },
    /// A number that is NaN or infinite.
    #[error("{what} is {value}; it must be finite")]
    NotFinite {
        /// Name of the number.
        what: &'static str,
        /// The number given.
        value: f64,
    },
    /// A factor of a covariance that is not lower triangular.
    #[error("{what} is not lower triangular: entry ({}, {}) is {entry:e}", row + 1, column + 1)]
    NotTriangular {
        /// Name of the matrix.
        what: &'static str,
        /// Row of the entry above the diagonal, from 0.
        row: usize,
        /// Its column, from 0.
        column: usize,
        /// The entry.
        entry: f64,
    },
    /// A state of a high-gain observer that belongs to no chain.
    #[error(
        "the state xi{} is at position {position} of the chain of the output y{}: that output must exist, positions begin \
         with 1, and the chain must have one state at position 1, not {heads}",
        state + 1, output + 1
    )]
    Chain {
        /// Index of the state, from 0.
        state: usize,
        /// Index of the output, from 0.
        output: usize,
        /// The position.
        position: usize,
        /// States at position 1 of that chain.
        heads: usize,
    },
    /// An output that does not exist.
    #[error("there is no output y{}, of {outputs}", output + 1)]
    Output {
        /// The output asked for, from 0.
        output: usize,
        /// How many there are.
        outputs: usize,
    },
    /// A fixed-point format that is not supported.
    #[error(
        "Q{integer_bits}.{fraction_bits}: a format has 2 to 32 bits, at least one of them, the sign, before the point"
    )]
    FixedPointFormat {
        /// Bits before the point.
        integer_bits: u32,
        /// Bits after it.
        fraction_bits: u32,
    },
    /// A number beyond the range of its fixed-point format.
    #[error(
        "{what}({}, {}) = {value} is beyond the range of Q{integer_bits}.{fraction_bits}: it needs {} bits before the point",
        row + 1,
        column + 1,
        integer_bits_of(*value, *integer_bits)
    )]
    FixedPointRange {
        /// Name of the matrix.
        what: &'static str,
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// The number.
        value: f64,
        /// Bits before the point.
        integer_bits: u32,
        /// Bits after it.
        fraction_bits: u32,
    },
    /// A row with entries so large that a sum of products could overflow 64 bits.
    #[error(
        "row {} of {what} could overflow 64 bits: its magnitudes add up to 2^32 units of their format or more; fewer bits \
         after the point help",
        row + 1
    )]
    FixedPointSum {
        /// The sum.
        what: &'static str,
        /// Its row, from 0.
        row: usize,
    },
    /// A table of coefficients whose size or indices do not fit.
    #[error("{what}: found {found}, which does not fit {expected}")]
    Table {
        /// Which table, or which index in it.
        what: &'static str,
        /// What would fit: an exact length, a length to be a multiple of, or a bound.
        expected: usize,
        /// What was found.
        found: usize,
    },
    /// What there is in discrete time alone, of a filter in continuous time.
    #[error("{what} are for filters of plants in discrete time")]
    NotDiscrete {
        /// What.
        what: &'static str,
    },
    /// Fewer of something than are needed.
    #[error("{found} {what}: at least {least} are needed")]
    TooFew {
        /// Of what.
        what: &'static str,
        /// How many are needed.
        least: usize,
        /// How many there are.
        found: usize,
    },
    /// Probabilities that are negative, or do not sum to one.
    #[error("{what} in row {} are no probabilities: their sum is {sum}, the least of them {least}", row + 1)]
    Probabilities {
        /// Which ones.
        what: &'static str,
        /// Their row, from 0.
        row: usize,
        /// The least.
        least: f64,
        /// Their sum.
        sum: f64,
    },
    /// A number in a table that is NaN or infinite.
    #[error("{what}: number {} is {value}", index + 1)]
    TableNotFinite {
        /// Which table.
        what: &'static str,
        /// Its position.
        index: usize,
        /// The number.
        value: f64,
    },
    /// A box without interior.
    #[error("axis {} of the box runs from {lower} to {upper}", axis + 1)]
    Box {
        /// The axis, from 0.
        axis: usize,
        /// Where it begins.
        lower: f64,
        /// Where it ends.
        upper: f64,
    },
}

/// Whether these are bounds of so many states, each lower end below the upper one.
pub(crate) fn check_bounds<T: RealField + Copy>(
    lower: &[T],
    upper: &[T],
    expected: usize,
) -> Result<(), ObserverError> {
    for found in [lower.len(), upper.len()] {
        if found != expected {
            return Err(ObserverError::Table { what: "bounds of the states", expected, found });
        }
    }
    for (axis, (lower, upper)) in lower.iter().zip(upper).enumerate() {
        let is_interval = lower < upper;
        if !is_interval {
            let (lower, upper) = (lower.to_subset_unchecked(), upper.to_subset_unchecked());
            return Err(ObserverError::Box { axis, lower, upper });
        }
    }
    Ok(())
}

/// The bits before the point, the sign among them, that a number beyond the range of a format with `too_few` needs.
fn integer_bits_of(value: f64, too_few: u32) -> u32 {
    // A bit more than in the format that does not hold it; up to the largest numbers of binary64.
    let (mut bits, mut end) = (too_few + 1, (1_u64 << too_few.min(32)) as f64);
    while !(-end..end).contains(&value) && end.is_finite() {
        (bits, end) = (bits + 1, 2.0 * end);
    }
    bits
}
