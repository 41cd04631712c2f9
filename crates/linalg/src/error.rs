//! Errors of matrix computations, each with the relevant numbers.

use crate::units::shift;
use luenberger_wording::{entry, significant};
use nalgebra::{Complex, DVector};
use thiserror::Error;

/// Error of a matrix computation.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LinalgError {
    /// A matrix that has to be square is not.
    #[error("{what} must be square, found {rows} x {cols}")]
    NotSquare {
        /// The matrix, by its name in the equation.
        what: &'static str,
        /// Its number of rows.
        rows: usize,
        /// Its number of columns.
        cols: usize,
    },
    /// Two matrices do not fit together.
    #[error("{what} must be {} x {}, found {} x {}", expected.0, expected.1, found.0, found.1)]
    DimensionMismatch {
        /// The matrix, by its name in the equation.
        what: &'static str,
        /// The shape required by the other arguments (rows, columns).
        expected: (usize, usize),
        /// The shape it has.
        found: (usize, usize),
    },
    /// A matrix of order zero, where at least one row is required.
    #[error("{what} is empty")]
    Empty {
        /// The matrix, by its name in the equation.
        what: &'static str,
    },
    /// An entry is NaN or infinite.
    #[error("{what}{at} is {value}", at = entry(*.row, *.col))]
    NotFinite {
        /// The matrix, by its name in the equation.
        what: &'static str,
        /// Row of the first such entry.
        row: usize,
        /// Column of the first such entry.
        col: usize,
        /// The entry.
        value: f64,
    },
    /// A matrix that has to be symmetric is not.
    #[error(
        "{what} is not symmetric: entries {upper} and {lower} differ by {asymmetry} (limit {allowed})",
        upper = entry(*.row, *.col), lower = entry(*.col, *.row), asymmetry = short(*.asymmetry), allowed = short(*.allowed)
    )]
    NotSymmetric {
        /// The matrix, by its name in the equation.
        what: &'static str,
        /// Row of the entry that differs most from its mirror image.
        row: usize,
        /// Column of that entry.
        col: usize,
        /// The difference.
        asymmetry: f64,
        /// The tolerance: the rounding error of a matrix product of this order and size.
        allowed: f64,
    },
    /// A matrix that has to be positive definite is not.
    #[error(
        "{what} is not positive definite: its smallest eigenvalue is {lambda_min}",
        lambda_min = short(*.lambda_min)
    )]
    NotPositiveDefinite {
        /// The matrix, by its name in the equation.
        what: &'static str,
        /// Its smallest eigenvalue.
        lambda_min: f64,
    },
    /// A matrix that has to be positive semidefinite is not.
    #[error(
        "{what} is not positive semidefinite: its smallest eigenvalue is {lambda_min}",
        lambda_min = short(*.lambda_min)
    )]
    NotPositiveSemidefinite {
        /// The matrix, by its name in the equation.
        what: &'static str,
        /// Its smallest eigenvalue.
        lambda_min: f64,
    },
    /// An iteration reached its cap.
    #[error(
        "{method} did not converge in {iterations} iterations: residual {remaining} (limit {allowed})",
        remaining = short(*.remaining), allowed = short(*.allowed)
    )]
    NotConverged {
        /// The iteration.
        method: &'static str,
        /// How many steps were taken.
        iterations: usize,
        /// The remaining value of the quantity that should converge to zero.
        remaining: f64,
        /// The tolerance below which it counts as zero.
        allowed: f64,
    },
    /// The linear equation has no unique solution, for the coefficients as stored: its determinant is zero, computed in
    /// integers.
    #[error(
        "the {equation} equation is singular for the data as stored: eigenvalues {first} and {second} (computed gap {gap})",
        gap = short(*.gap), first = complex(*.first), second = complex(*.second)
    )]
    SingularEquation {
        /// The equation.
        equation: &'static str,
        /// An eigenvalue of the left coefficient, as computed.
        first: Complex<f64>,
        /// The eigenvalue of the right coefficient that meets it.
        second: Complex<f64>,
        /// How far the two are from making the equation singular: `|first + second|`, in discrete time
        /// `|first * second - 1|`. Zero but for the rounding of the eigenvalues.
        gap: f64,
    },
    /// Rounding decides the solution of the linear equation.
    #[error(
        "{}: separation {separation}, condition {condition} (limit 4.5e15){}; nearest eigenvalues {first} and {second}, computed gap {gap}",

        if *.regular { format!("the {equation} equation has a unique solution, of which no digit is certain in double precision") }
        else { format!("whether the {equation} equation has a unique solution is undecided in double precision") },
        .digits.map_or(String::new(), |digits| format!(", about {digits} decimal digits needed")),
        separation = short(*.separation), condition = short(*.condition), gap = short(*.gap), first = complex(*.first), second = complex(*.second)
    )]
    UndecidedEquation {
        /// The equation.
        equation: &'static str,
        /// Whether it is known to have exactly one solution: its determinant, computed in integers modulo a prime, is
        /// not zero.
        regular: bool,
        /// An eigenvalue of the left coefficient, as computed.
        first: Complex<f64>,
        /// The eigenvalue of the right coefficient for which the gap is smallest.
        second: Complex<f64>,
        /// `|first + second|`, in discrete time `|first * second - 1|`. For matrices far from normal the separation is
        /// far smaller.
        gap: f64,
        /// The estimated separation: the smallest relative change of the equation that makes it singular is
        /// about this over the norm of the coefficients.
        separation: f64,
        /// The norm of the operator over the separation: the inverse of that change.
        condition: f64,
        /// Decimal digits of an arithmetic in which this condition would leave three digits of the solution; none where
        /// the condition is infinite.
        digits: Option<u32>,
    },
    /// A matrix that has to be regular is not, to working precision.
    #[error(
        "{what} is singular to working precision (condition {condition})",
        condition = short(*.condition)
    )]
    Singular {
        /// The matrix, by its name in the equation.
        what: &'static str,
        /// Its condition number, or infinity.
        condition: f64,
    },
    /// A semidefinite solution is asked for, and the matrix is not stable.
    #[error(
        "to working precision the {equation} equation has no positive semidefinite solution for every weight: the eigenvalue {eigenvalue} is not stable",
        eigenvalue = complex(*.eigenvalue)
    )]
    NotStable {
        /// The equation.
        equation: &'static str,
        /// An eigenvalue on the stability boundary or beyond it.
        eigenvalue: Complex<f64>,
    },
    /// Two neighbouring blocks of a real Schur form are too close to change places.
    #[error(
        "the Schur blocks of {first} and {second} cannot be exchanged: residual {residual} (limit {allowed})",
        residual = short(*.residual), allowed = short(*.allowed), first = complex(*.first), second = complex(*.second)
    )]
    SwapRejected {
        /// An eigenvalue of the upper block.
        first: Complex<f64>,
        /// An eigenvalue of the lower block.
        second: Complex<f64>,
        /// What the swap would leave below the diagonal.
        residual: f64,
        /// What rounding explains.
        allowed: f64,
    },
    /// An eigenvalue that is not stable cannot be moved by the input.
    #[error(
        "the pair (A, B) is not stabilizable to working precision: uncontrollable eigenvalue {eigenvalue}, PBH margin {margin}",
        margin = short(*.margin), eigenvalue = complex(*.eigenvalue)
    )]
    NotStabilizable {
        /// The eigenvalue.
        eigenvalue: Complex<f64>,
        /// The smallest singular value of `[A - lambda I, B]`.
        margin: f64,
    },
    /// An eigenvalue on the stability boundary is not seen by the weight Q of a Riccati equation: a unit vector near
    /// its mode costs nothing.
    #[error(
        "to working precision the weight Q does not see the eigenvalue {eigenvalue} on the stability boundary, PBH margin of (A, Q) {margin}",
        margin = short(*.margin), eigenvalue = complex(*.eigenvalue)
    )]
    NotWeighted {
        /// The eigenvalue.
        eigenvalue: Complex<f64>,
        /// The smallest singular value of `[A - lambda I; Q]`.
        margin: f64,
    },
    /// An eigenvalue on the stability boundary that the process noise of a Kalman filter does not excite.
    #[error(
        "to working precision the process noise W does not excite the eigenvalue {eigenvalue} on the stability boundary, PBH margin of (A, W) {margin}",
        margin = short(*.margin), eigenvalue = complex(*.eigenvalue)
    )]
    NotExcited {
        /// The eigenvalue.
        eigenvalue: Complex<f64>,
        /// The smallest singular value of `[A - lambda I, W]`.
        margin: f64,
    },
    /// An eigenvalue that is not stable is not seen by the output, to working precision.
    #[error(
        "the pair (A, C) is not detectable to working precision: unobservable eigenvalue {eigenvalue}, PBH margin {margin}",
        margin = short(*.margin), eigenvalue = complex(*.eigenvalue)
    )]
    NotDetectable {
        /// The eigenvalue.
        eigenvalue: Complex<f64>,
        /// The smallest singular value of `[A - lambda I; C]`.
        margin: f64,
    },
    /// No stabilizing solution was found: with the gain, an eigenvalue is beyond the stability boundary or on it,
    /// though no eigenvalue of the plant explains it.
    #[error("no stabilizing solution was found: {}", not_stabilizing(*.eigenvalue, *.distance))]
    NotStabilizing {
        /// The eigenvalue of the closed loop (or of the Hamiltonian matrix) nearest to the boundary, or beyond it.
        eigenvalue: Complex<f64>,
        /// Its signed distance from the boundary, positive on the stable side.
        distance: f64,
    },
    /// No stabilizing solution was found, and the eigenvalues of the plant do not explain it.
    #[error(
        "no stabilizing solution was found, although A has no eigenvalue that prevents one: with an indefinite Q or R there may be none"
    )]
    NoStabilizingSolution,
    /// The stable subspace `[X1; X2]` of a Riccati equation with indefinite R has a singular X1: no X satisfies
    /// `X2 = X X1`.
    #[error(
        "no stabilizing solution: X1 of the stable subspace [X1; X2] is singular to working precision (smallest singular value {})",
        short(*.sigma_min)
    )]
    NotGraph {
        /// The smallest singular value of X1, for an orthonormal basis in balanced units.
        sigma_min: f64,
    },
    /// The answer, or a quantity on the way to it, exceeds the range of double precision.
    #[error("{what} exceeds the range of double precision")]
    Overflow {
        /// The quantity.
        what: &'static str,
    },
    /// A mode that no output sees to working precision, where the answer needs all of them seen.
    #[error(
        "the pair (A, C) is not observable to working precision: unobservable eigenvalue {eigenvalue}, PBH margin {margin}",
        margin = short(*.margin), eigenvalue = complex(*.eigenvalue)
    )]
    Unobservable {
        /// The eigenvalue, which no observer gain can move.
        eigenvalue: Complex<f64>,
        /// The unit vector `v` with `A v = lambda v`, `C v = 0`.
        direction: DVector<Complex<f64>>,
        /// `|[A - lambda I; C] v| / |[A; C]|`, in units that suit the pair.
        margin: f64,
    },
    /// A mode that no input moves, where the answer needs all of them moved.
    #[error(
        "the pair (A, B) is not controllable to working precision: uncontrollable eigenvalue {eigenvalue}, PBH margin {margin}",
        margin = short(*.margin), eigenvalue = complex(*.eigenvalue)
    )]
    Uncontrollable {
        /// The eigenvalue, which no feedback gain can move.
        eigenvalue: Complex<f64>,
        /// The unit vector `v` with `v'A = lambda v'`, `v'B = 0` (transposed, not conjugated).
        direction: DVector<Complex<f64>>,
        /// `|v'[A - lambda I, B]| / |[A, B]|`, in units that suit the pair.
        margin: f64,
    },
    /// Not as many poles as states.
    #[error("a plant of order {order} needs {order} poles, and {found} are given")]
    PoleCount {
        /// The order of the plant.
        order: usize,
        /// The number of poles given.
        found: usize,
    },
    /// A pole is NaN or infinite.
    #[error(
        "pole {number} is {pole}",
        number = *.index + 1, pole = complex(*.pole)
    )]
    PoleNotFinite {
        /// Its place in the list.
        index: usize,
        /// The pole.
        pole: Complex<f64>,
    },
    /// A complex pole without its conjugate, which no real gain can place.
    #[error(
        "the poles are not closed under conjugation: {pole} has no conjugate",
        pole = complex(*.pole)
    )]
    PoleUnpaired {
        /// The pole.
        pole: Complex<f64>,
    },
    /// Poles repeated more often than only a defective closed loop could have them: with sorted multiplicities `m_i`
    /// and `s_i` the number of inputs that reach states after i integrations (the conjugates of the controllability
    /// indices), `m_1 + .. + m_k <= s_1 + .. + s_k` for all k; `s_1` is the rank of B. (Rosenbrock, State-Space and
    /// Multivariable Theory, 1970.) For an observer, outputs and observability.
    #[error("{}", repeated(*.pole, *.poles, *.multiplicity, *.rank))]
    PoleMultiplicity {
        /// The pole, the last of them.
        pole: Complex<f64>,
        /// The number k of poles that are repeated too often together.
        poles: usize,
        /// Their requested multiplicity, all together.
        multiplicity: usize,
        /// The one allowed; for one pole the rank of B (for an observer, of C).
        rank: usize,
    },
    /// A pole that no gain with the zeros asked for can move, and that is not asked for.
    #[error(
        "to working precision no gain with these zeros moves the eigenvalue {eigenvalue}: the nearest specified pole is {distance} away",
        distance = short(*.distance), eigenvalue = complex(*.eigenvalue)
    )]
    FixedMode {
        /// The eigenvalue.
        eigenvalue: Complex<f64>,
        /// Its distance from the nearest requested pole.
        distance: f64,
    },
    /// No observer of the order asked for gives the function: its rate does not follow from itself, the outputs and
    /// their rates.
    #[error(
        "no observer of this order to working precision: row {number} of K A is not a combination of the rows of [K; C A; C], residual {residual} (limit {allowed}) (Darouach's first condition)",
        number = *.row + 1, residual = short(*.residual), allowed = short(*.allowed)
    )]
    NotFunctional {
        /// The row of K A with the largest relative residual, from 0.
        row: usize,
        /// Its part outside of the row space of [C A; C; K], relative to the row.
        residual: f64,
        /// What rounding explains.
        allowed: f64,
    },
    /// An eigenvalue of a functional observer that no choice of its gains moves.
    #[error(
        "to working precision every observer of this order has the eigenvalue {eigenvalue}: [s K - K A; C A; C] loses rank there, margin {margin} (Darouach's second condition)",
        margin = short(*.margin), eigenvalue = complex(*.eigenvalue)
    )]
    FixedObserverMode {
        /// The eigenvalue.
        eigenvalue: Complex<f64>,
        /// The margin of the mode in the pair that the freedom left makes.
        margin: f64,
    },
    /// A sampling period that is not a positive finite number.
    #[error("the sampling period must be positive and finite, and is {h}")]
    InvalidPeriod {
        /// The period.
        h: f64,
    },
    /// A delay that is negative, not a number, or too long.
    #[error("a delay must be 0 or more and at most {longest} periods of {period}, and is {delay}")]
    InvalidDelay {
        /// The delay.
        delay: f64,
        /// The sampling period.
        period: f64,
        /// The longest delay in periods.
        longest: f64,
    },
    /// A prewarping frequency that is not between 0 and pi over the sampling period.
    #[error("the prewarping frequency must be between 0 and pi/{period}, and is {frequency}")]
    InvalidFrequency {
        /// The frequency.
        frequency: f64,
        /// The sampling period.
        period: f64,
    },
    /// A specification of poles outside of its range.
    #[error("{what} must be {}, and is {value}", range(*low, *high))]
    InvalidSpecification {
        /// The quantity.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The lower end of the range.
        low: f64,
        /// The upper end.
        high: f64,
    },
    /// A matrix without a real principal logarithm.
    #[error(
        "there is no real principal logarithm: the eigenvalue {eigenvalue} is zero or negative",
        eigenvalue = complex(*.eigenvalue)
    )]
    NoLogarithm {
        /// The eigenvalue.
        eigenvalue: Complex<f64>,
    },
    /// A tolerance that is negative, infinite or NaN.
    #[error("the relative tolerance must be nonnegative and finite, and is {tolerance}")]
    InvalidTolerance {
        /// The tolerance.
        tolerance: f64,
    },
}

fn repeated(pole: Complex<f64>, poles: usize, multiplicity: usize, allowed: usize) -> String {
    let pole = complex(pole);
    if poles == 1 {
        format!(
            "the pole {pole} is repeated {multiplicity} times; with {allowed} independent inputs (outputs) it may be repeated \
             {allowed} times: separate the others by a little"
        )
    } else {
        format!(
            "the {poles} poles repeated most, {pole} among them, are {multiplicity} together; the pair allows {allowed}, since \
             its inputs (outputs) reach unlike numbers of states: separate some of them by a little"
        )
    }
}

impl LinalgError {
    /// With the eigenvalues and poles in units of time that are `2^power` times shorter.
    pub(crate) fn in_time(mut self, power: i32) -> Self {
        if let Self::Unobservable { eigenvalue: pole, .. }
        | Self::Uncontrollable { eigenvalue: pole, .. }
        | Self::PoleMultiplicity { pole, .. }
        | Self::PoleUnpaired { pole } = &mut self
        {
            *pole = Complex::new(shift(pole.re, power), shift(pole.im, power));
        }
        self
    }
}

/// The eigenvalue is beyond the boundary, or so near to it that it may be.
fn not_stabilizing(eigenvalue: Complex<f64>, distance: f64) -> String {
    let (eigenvalue, at) = (complex(eigenvalue), short(distance.abs()));
    if distance > 0.0 {
        format!("the closed loop has the eigenvalue {eigenvalue}, only {at} from the stability boundary")
    } else {
        format!("the closed loop keeps the eigenvalue {eigenvalue}, {at} beyond the stability boundary")
    }
}

/// A number with three significant digits.
fn short(x: f64) -> String {
    significant(x, 3)
}

/// A complex number with six significant digits.
fn complex(z: Complex<f64>) -> String {
    luenberger_wording::complex([z.re, z.im], 6)
}

/// Complex numbers, separated by commas.
pub(crate) fn listed(numbers: &[Complex<f64>]) -> String {
    numbers.iter().map(|z| complex(*z)).collect::<Vec<_>>().join(", ")
}

/// A range, whose upper end may be infinite.
fn range(low: f64, high: f64) -> String {
    if high == f64::INFINITY { format!("greater than {low}") } else { format!("between {low} and {high}") }
}
