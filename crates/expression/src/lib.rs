//! Plants given by expressions: right-hand sides, outputs and signals such as `ln(0.1 + exp(x2 - x1))`, over every
//! scalar.
//!
//! | what | how it is written |
//! |---|---|
//! | states, inputs, time | `x1`, `x2`, ...; `u1`, ...; `t`; names supplied by the user ([`Scope::named`]) |
//! | numbers, parameters | `0.5`, `.5`, `1e-3`, `pi`, `e`; any other name that has a value |
//! | operations | `+ - * /`, `^` or `**`: `-x1^2` is `-(x1^2)`, `2^-1` is 0.5, `2^3^2` is `2^9` |
//! | functions | `sqrt exp ln log10 sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh pow` |
//! | with kinks | `abs`, `min` and `max` of two or more, `sat(x, low, high)` (`sat(x)` is between -1 and 1) |
//! | with a jump | `sign`, which is 0 at 0; `step`, which is 1 at 0; `floor` |
//! | of angles | `wrap(x)` in (-pi, pi], `wrap(x, turn)` in (-turn/2, turn/2]; `mod(x, m)`, with the sign of m |
//! | conditions | `x < y`, `<= > >= == !=`; `&&`, `||`, `!`, all parts of which are evaluated |
//! | choice | `if(condition, x, y)`: the branch that is not taken is not evaluated, and may be undefined |
//! | lookup tables | `name(x)`, by [`Scope::tables`]: linear or monotone cubic ([`Table`]) |
//!
//! Their evaluation over each scalar:
//!
//! | | numbers | dual numbers (Jacobians, observers) | intervals (certified designs) | symbolic polynomials (KKL residuals) |
//! |---|---|---|---|---|
//! | `+ - * /`, smooth functions | binary64 | the derivative, to rounding | enclosure of value and derivative | exact for polynomials; functions are atoms |
//! | `abs`, `min`, `max`, `sat` | the value | the derivative of the side taken; at a kink that of one side | the hull of both sides | refused, unless it is a constant |
//! | `sign` | -1, 0, 1 | 0 | 0 away from 0; refused where the argument can be 0: it jumps | refused |
//! | `step` | 0 for x < 0, else 1 | 0 | as `sign` | refused |
//! | `floor`, `wrap`, `mod` | `wrap(x, r) = x + r floor(1/2 - x/r)`, `mod(x, m) = x - m floor(x/m)` | that between the jumps | that of one piece; refused where the box contains a jump | refused |
//! | `if` | the branch taken | the derivative of the branch taken | all branches possible on the box; refused where two of them do not meet | refused, unless the condition is constant |
//! | lookup table | the piece at x; on a point the piece after it | its derivative | all pieces possible on the box, whose values meet: a kink | refused |
//!
//! A condition is false with NaN in it, except `!=`. Equality of floating-point numbers is seldom what is meant.
//! Certified designs accept kinks, with both sides, and refuse jumps: their conclusions need a continuous right-hand
//! side. Simulation integrates both; a jump costs short steps.
//!
//! The grammar; a larger binding power binds tighter, and white space separates:
//!
//! ```text
//! or       1, from the left      c || d
//! and      2, from the left      c && d
//! compare  3                     a < b, a <= b, a > b, a >= b, a == b, a != b; a < b < c is an error
//! sum      5, from the left      a + b, a - b
//! product  7, from the left      a*b, a/b
//! sign     8                     -a, +a, !c
//! power    9, from the right     a^b, a**b         -x^2 is -(x^2), 2^-1 is 0.5, 2^3^2 is 2^9
//! operand                        number, name, name(a, ...), (a), (c)
//! ```
//! Conditions c, d and numbers a, b are different things: `2*(x1 > 0)` is an error, `if(x1 > 0, 2, 0)` is not.
//!
//! A text is parsed into a syntax tree and compiled to a tape, a flat list of instructions, which is evaluated over any
//! scalar: numbers, dual numbers (so that Jacobians are exact), the intervals and polynomials of `luenberger-design`.
//! Over numbers a plant is evaluated as a graph with each subexpression once, and so are its Jacobians, whose
//! derivatives are symbolic; the same graph prints itself as C and Rust ([`Routine`]), with the same results to the
//! last bit. What is written for every scalar, such as an observer, is recorded as one by its evaluation over
//! [`Recorded`] ([`record`]). The evaluation of a tape allocates no memory and does not recurse. Where an expression is
//! undefined (`1/0`, `ln(-1)`) the value is not finite, as in any right-hand side written in Rust, and
//! [`Expression::examine`] reports the subexpression that causes it.
//!
//! ```
//! use luenberger_expression::{ExpressionPlant, Parameters};
//! use luenberger_plants::{Plant, state_jacobian};
//! use nalgebra::{dmatrix, dvector};
//!
//! let parameters = Parameters::from([("g".to_owned(), 9.81), ("l".to_owned(), 0.5)]);
//! let pendulum = ExpressionPlant::new(&["x2", "-g/l*sin(x1) + u1"], &["x1"], 1, &parameters)?;
//! let (x, u) = (dvector![0.0, 2.0], dvector![1.0]);
//! assert_eq!(pendulum.derivative(0.0, &x, &u), dvector![2.0, 1.0]);
//! assert_eq!(state_jacobian(&pendulum, 0.0, &x, &u), dmatrix![0.0, 1.0; -9.81 / 0.5, 0.0]);
//!
//! let error = ExpressionPlant::new(&["x2", "-g/l*sinn(x1)"], &["x1"], 0, &parameters).unwrap_err();
//! assert_eq!(error.to_string(), "f2: line 1, column 6: there is no function `sinn`; did you mean `sin`?");
//! # Ok::<(), luenberger_expression::ExpressionPlantError>(())
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `parse`, `tree`, `scope` | from a text to its syntax tree; the names in scope |
//! | `tape`, `function`, `table` | the instructions, and their evaluation over any scalar |
//! | `graph` | a plant over numbers: subexpressions once, symbolic derivatives, source code |
//! | `derived` | parameters that depend on other parameters |
//! | `expression`, `affine`, `undefined` | values and derivatives; affine expressions; undefined values |
//! | `terms` | what an expression is as a sum: a variable, a multiple, what it depends on |
//! | `plant` | plants whose rows are expressions |
//! | `typeset` | expressions as MathML and LaTeX |
//! | `error`, `nearest` | errors of a text, with positions; the nearest name |

#![deny(missing_docs)]

mod affine;
mod derived;
mod error;
mod expression;
mod function;
mod graph;
mod nearest;
mod parse;
mod plant;
mod rewritten;
mod scope;
mod surface;
mod table;
mod tape;
mod terms;
mod tree;
mod typeset;
mod undefined;

pub use derived::{Definition, DerivedError, derived};
pub use error::{ExpressionError, ExpressionErrorKind, Family, Found};
pub use expression::Expression;
pub use graph::{
    Columns, Dialect, Language, Lookups, MathFunction, Recorded, Recording, RecordingError, Routine, record,
};
pub use nalgebra;
pub use nearest::nearest;
pub use plant::{AffinePlant, ExpressionPlant, ExpressionPlantError, Fixed, Routines, Row};
pub use scope::{NameError, ParameterError, Parameters, Scope, Variable};
pub use surface::{LookupTable, Surface, Tables};
pub use table::{Extrapolation, Interpolation, Table, TableError};
pub use terms::Terms;
pub use typeset::Formula;
pub use undefined::Undefined;

/// Limits of the length and the nesting of an expression.
struct Limits {
    /// Bytes of its text.
    length: usize,
    /// Operations that wait for an operand while it is parsed, and values that wait while it is evaluated.
    depth: usize,
}

const LIMITS: Limits = Limits { length: 8192, depth: 64 };

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
