//! A body that is written for every scalar, recorded as a program: what runs over numbers is run once over
//! [`Recorded`], whose operations become nodes of a graph.
//!
//! A comparison of two numbers that are not constants has no answer while it is recorded. The body is run for both, and
//! the results of all its paths are joined by choices. The number of paths doubles with each comparison that is not
//! decided by those before it. Within [`SimdValue::map_lanes`](nalgebra::SimdValue::map_lanes) and `zip_map_lanes`,
//! which for one number are a call of the function, the paths end with the function: a body that has its branches there
//! has one path.
//!
//! The recorded program has the operations of the body in their order. What is left out changes no bit of a result,
//! whatever the numbers are: `x + 0` stays, because it is not x for the negative zero. Expressions and their tables are
//! recorded as the graph that is evaluated, with both sides of their choices. Constants are computed in binary64 and
//! rounded once to the format of the program; its epsilon and its largest number are those of the format.
//!
//! Source: operator overloading for traces: A. Griewank and A. Walther, Evaluating Derivatives, 2nd ed., SIAM 2008,
//! ch. 6.

use core::any::Any;
use core::cell::RefCell;
use core::cmp::Ordering;
use core::fmt;
use core::ops::{Add, Div, Mul, Neg, Sub};
use std::sync::Arc;

use luenberger_plants::real_field;
use luenberger_plants::real_field::Real;
use nalgebra::DMatrix;

use super::translate::Leaves;
use super::{Graph, Id, NamedMatrix, Node, Routine};
use crate::function::{Binary, Comparison, Unary};
use crate::table::Table;
use crate::tree::Tree;

/// Paths of a body, and of a function in it, that are followed at most.
const MOST_PATHS: usize = 1 << 12;

/// Why a body is not recorded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// More paths of the body, or of a function in it, than are followed.
    #[error("its comparisons make more than {most} paths")]
    Paths {
        /// As many as are followed.
        most: usize,
    },
    /// An operation that programs do not have.
    #[error("it contains the operation {name}, which a program does not have")]
    Operation {
        /// The operation.
        name: &'static str,
    },
}

/// A number of a body that is recorded: it has a meaning only within its recording.
#[derive(Clone, Copy, Debug)]
pub struct Recorded(Id);

/// Answers to open comparisons on one path, and how many of them it has asked for.
#[derive(Debug, Default)]
struct Path {
    answers: Vec<(Id, bool)>,
    asked: usize,
}

/// A path to its end: the answers on it, and the results.
type Followed = (Vec<(Id, bool)>, Vec<Recorded>);

#[derive(Debug)]
struct Tape {
    graph: Graph,
    /// The path of the body, and those of the functions that it is in.
    paths: Vec<Path>,
    error: Option<RecordingError>,
}

thread_local! {
    static TAPE: RefCell<Option<Tape>> = const { RefCell::new(None) };
}

/// Outside of a recording there is nothing to write to.
fn on_tape<R>(run: impl FnOnce(&mut Tape) -> R) -> Option<R> {
    TAPE.with_borrow_mut(|tape| tape.as_mut().map(run))
}

fn node(make: impl FnOnce(&mut Graph) -> Id) -> Recorded {
    Recorded(on_tape(|tape| make(&mut tape.graph)).unwrap_or_default())
}

fn constant(x: Recorded) -> Option<f64> {
    on_tape(|tape| tape.graph.value(x.0)).flatten()
}

/// An operation that cannot be recorded: the first is reported.
fn refused(name: &'static str) -> Recorded {
    on_tape(|tape| tape.error.get_or_insert(RecordingError::Operation { name }).clone());
    Recorded::exactly(f64::NAN)
}

/// The answer to a condition on this path.
fn decided(condition: impl FnOnce(&mut Graph) -> Id) -> bool {
    let answer = on_tape(|tape| {
        let condition = condition(&mut tape.graph);
        if let Some(truth) = tape.graph.truth(condition) {
            return truth;
        }
        let known = |path: &Path| {
            path.answers.iter().take(path.asked).find(|(asked, _)| *asked == condition).map(|(_, answer)| *answer)
        };
        if let Some(answer) = tape.paths.iter().find_map(known) {
            return answer;
        }
        let Some(path) = tape.paths.last_mut() else { return false };
        if path.asked == path.answers.len() {
            path.answers.push((condition, true));
        }
        path.asked += 1;
        path.answers.get(path.asked - 1).is_some_and(|(_, answer)| *answer)
    });
    answer.unwrap_or_default()
}

/// Runs a body on every path of its open comparisons, and joins the results of the paths by choices.
fn explored(body: &dyn Fn() -> Vec<Recorded>) -> Vec<Recorded> {
    on_tape(|tape| tape.paths.push(Path::default()));
    let mut all: Vec<Followed> = Vec::new();
    loop {
        let results = body();
        let next = on_tape(|tape| {
            let path = tape.paths.last_mut()?;
            path.answers.truncate(path.asked);
            all.push((path.answers.clone(), results));
            // The last comparison of which only one answer has been followed.
            while path.answers.last().is_some_and(|(_, answer)| !answer) {
                path.answers.pop();
            }
            path.answers.last_mut()?.1 = false;
            path.asked = 0;
            if all.len() >= MOST_PATHS {
                tape.error.get_or_insert(RecordingError::Paths { most: MOST_PATHS });
            }
            tape.error.is_none().then_some(())
        });
        if next.flatten().is_none() {
            break;
        }
    }
    on_tape(|tape| {
        tape.paths.pop();
        if tape.error.is_some() {
            return all.pop().map(|(_, results)| results).unwrap_or_default();
        }
        joined(&mut tape.graph, &all, 0)
    })
    .unwrap_or_default()
}

/// The results of paths that agree in their first answers.
fn joined(graph: &mut Graph, paths: &[Followed], depth: usize) -> Vec<Recorded> {
    let Some((answers, results)) = paths.first() else { return Vec::new() };
    let Some((condition, _)) = answers.get(depth).filter(|_| paths.len() > 1) else { return results.clone() };
    let split = paths.partition_point(|(answers, _)| answers.get(depth).is_some_and(|(_, answer)| *answer));
    let (yes, no) = (joined(graph, &paths[..split], depth + 1), joined(graph, &paths[split..], depth + 1));
    yes.iter().zip(&no).map(|(yes, no)| Recorded(graph.select(*condition, yes.0, no.0))).collect()
}

/// A recording that is going on: see [`record`].
#[derive(Debug)]
pub struct Recording(());

/// Records bodies: within `run` numbers of the type [`Recorded`] can be made, and an observer of them, whose bodies
/// become programs. For observers of a plant of expressions see
/// [`ExpressionPlant::record`](crate::ExpressionPlant::record).
///
/// ```
/// use luenberger_expression::{Recorded, record};
/// use nalgebra::{SimdValue, convert};
/// let halved = record(|recording| {
///     let half: Recorded = convert(0.5);
///     recording.program((1, 1), |_, x, u| {
///         vec![(x[0] + u[0]).map_lanes(|sum| if sum > x[0] { sum * half } else { -sum })]
///     })
/// })?;
/// let mut results = Vec::new();
/// for u in [1.0, -1.0] {
///     halved.evaluate(0.0, &[2.0], &[u], |_, value| results.push(value));
/// }
/// assert_eq!(results, [1.5, -1.0]);
/// # Ok::<(), luenberger_expression::RecordingError>(())
/// ```
pub fn record<R>(run: impl FnOnce(&mut Recording) -> R) -> R {
    with_tables(Vec::new(), run)
}

/// [`record`] with lookup tables that have the numbers 0, 1, ..; others follow.
pub(crate) fn with_tables<R>(tables: Vec<Arc<Table>>, run: impl FnOnce(&mut Recording) -> R) -> R {
    let tape = Tape { graph: Graph::recording(tables), paths: Vec::new(), error: None };
    let outer = TAPE.replace(Some(tape));
    let result = run(&mut Recording(()));
    TAPE.set(outer);
    result
}

impl Recording {
    /// A matrix whose entries stay entries of a matrix of this name in the programs: they are known to comparisons, and
    /// are no constants of operations. [`Routine::loops`] has loops over them.
    pub fn matrix(&mut self, name: &'static str, values: &DMatrix<f64>) -> DMatrix<Recorded> {
        let matrix = Arc::new(NamedMatrix { name, values: values.clone() });
        let number = on_tape(|tape| tape.graph.matrix(&matrix)).unwrap_or_default();
        let (rows, columns) = values.shape();
        DMatrix::from_fn(rows, columns, |row, column| {
            node(|graph| graph.push(Node::Entry(number, row as u32, column as u32)))
        })
    }

    /// The program of a body, which is called with the time, so many states and so many inputs.
    ///
    /// Cost: one call of the body for each path of its open comparisons.
    ///
    /// # Errors
    /// [`RecordingError`]: too many paths, an operation that programs do not have.
    pub fn program(
        &mut self,
        (states, inputs): (usize, usize),
        body: impl Fn(Recorded, &[Recorded], &[Recorded]) -> Vec<Recorded>,
    ) -> Result<Routine, RecordingError> {
        let t = node(|graph| graph.push(Node::Time));
        let x: Vec<Recorded> = (0..states as u32).map(|k| node(|graph| graph.push(Node::State(k)))).collect();
        let u: Vec<Recorded> = (0..inputs as u32).map(|k| node(|graph| graph.push(Node::Input(k)))).collect();
        let results: Vec<Id> = explored(&|| body(t, &x, &u)).iter().map(|result| result.0).collect();
        let routine = on_tape(|tape| match tape.error.take() {
            Some(error) => Err(error),
            None => Ok(tape.graph.routine(&results)),
        });
        routine.unwrap_or_else(|| Ok(Graph::default().routine(&[])))
    }
}

/// The scalar as a recorded one, if it is.
fn recorded<T: 'static>(x: &T) -> Option<Recorded> {
    (x as &dyn Any).downcast_ref::<Recorded>().copied()
}

/// The recorded one as a scalar, which it is.
fn back<T: Copy + 'static>(x: Recorded) -> Option<T> {
    (&x as &dyn Any).downcast_ref::<T>().copied()
}

/// Calls `record` on the tape, if the scalar is a recorded one.
fn leaves<T: 'static, R>(t: &T, x: &[T], u: &[T], record: impl FnOnce(&mut Graph, Leaves<'_>) -> R) -> Option<R> {
    let ids = |column: &[T]| column.iter().filter_map(recorded).map(|entry| entry.0).collect::<Vec<Id>>();
    let (t, x, u) = (recorded(t)?.0, ids(x), ids(u));
    on_tape(|tape| record(&mut tape.graph, Leaves::Given { t, x: &x, u: &u }))
}

/// The value of an expression while a body is recorded; none over other scalars.
pub(crate) fn expression<T: Copy + 'static>(tree: &Tree, t: &T, x: &[T], u: &[T]) -> Option<T> {
    leaves(t, x, u, |graph, leaves| graph.expression_of(tree, leaves)).and_then(|id| back(Recorded(id)))
}

/// The results of a routine while a body is recorded; none over other scalars.
pub(super) fn routine<T: Copy + 'static>(routine: &Routine, t: &T, x: &[T], u: &[T]) -> Option<Vec<T>> {
    leaves(t, x, u, |graph, leaves| graph.inlined(routine, leaves))?.into_iter().map(|id| back(Recorded(id))).collect()
}

/// Whether the scalar is the recorded one.
pub(crate) fn is_recorded<T: 'static>() -> bool {
    core::any::TypeId::of::<T>() == core::any::TypeId::of::<Recorded>()
}

impl Recorded {
    fn unary(self, unary: Unary) -> Self {
        node(|graph| graph.unary(unary, self.0))
    }

    fn binary(self, binary: Binary, other: Self) -> Self {
        node(|graph| graph.binary(binary, self.0, other.0))
    }

    fn compared(self, comparison: Comparison, other: Self) -> bool {
        decided(|graph| graph.compare(comparison, self.0, other.0))
    }

    /// The other number if it compares so or this is none, else this.
    fn exchanged(self, comparison: Comparison, other: Self) -> Self {
        node(|graph| {
            let (better, none) =
                (graph.compare(comparison, other.0, self.0), graph.compare(Comparison::NotEqual, self.0, self.0));
            let other_one = graph.or(better, none);
            graph.select(other_one, other.0, self.0)
        })
    }
}

impl PartialEq for Recorded {
    fn eq(&self, other: &Self) -> bool {
        self.compared(Comparison::Equal, *other)
    }
}

impl PartialOrd for Recorded {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        if self < other {
            Some(Ordering::Less)
        } else if self > other {
            Some(Ordering::Greater)
        } else if self == other {
            Some(Ordering::Equal)
        } else {
            None
        }
    }

    fn lt(&self, other: &Self) -> bool {
        self.compared(Comparison::Less, *other)
    }

    fn le(&self, other: &Self) -> bool {
        self.compared(Comparison::LessOrEqual, *other)
    }

    fn gt(&self, other: &Self) -> bool {
        self.compared(Comparison::Greater, *other)
    }

    fn ge(&self, other: &Self) -> bool {
        self.compared(Comparison::GreaterOrEqual, *other)
    }
}

impl fmt::Display for Recorded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "v{}", self.0)
    }
}

/// The operations of numbers.
macro_rules! operators {
    ($($operator:ident $method:ident $binary:ident,)*) => {$(
        impl $operator for Recorded {
            type Output = Self;

            fn $method(self, other: Self) -> Self {
                self.binary(Binary::$binary, other)
            }
        }
    )*};
}

operators! { Add add Add, Sub sub Subtract, Mul mul Multiply, Div div Divide, }

impl Neg for Recorded {
    type Output = Self;

    fn neg(self) -> Self {
        self.unary(Unary::Negate)
    }
}

/// Elementary functions.
macro_rules! functions {
    ($($method:ident $unary:ident,)*) => {$(
        fn $method(self) -> Self {
            self.unary(Unary::$unary)
        }
    )*};
}

/// Operations that programs do not have.
macro_rules! unsupported {
    ($($method:ident($($argument:ident),*),)*) => {$(
        fn $method(self $(, $argument: Self)*) -> Self {
            refused(stringify!($method))
        }
    )*};
}

impl Real for Recorded {
    fn exactly(x: f64) -> Self {
        node(|graph| graph.constant(x))
    }

    fn about(x: f64) -> Self {
        Self::exactly(x)
    }

    fn is_number(&self) -> bool {
        constant(*self).is_some()
    }

    fn number(&self) -> f64 {
        constant(*self).unwrap_or_else(|| {
            refused("of a conversion to a number");
            f64::NAN
        })
    }

    fn is_finite(&self) -> bool {
        decided(|graph| graph.finite(self.0))
    }

    fn epsilon() -> Self {
        node(|graph| graph.push(Node::Epsilon))
    }

    fn largest() -> Self {
        node(|graph| graph.push(Node::Largest))
    }

    fn step(&self, operation: &'static str, _f: impl Fn(f64) -> f64) -> Self {
        if operation == "floor" { self.unary(Unary::Floor) } else { refused(operation) }
    }

    fn joined(branches: impl Fn() -> Self) -> Self {
        explored(&|| vec![branches()]).first().copied().unwrap_or_else(|| Self::exactly(f64::NAN))
    }

    fn max(self, other: Self) -> Self {
        self.exchanged(Comparison::Greater, other)
    }

    fn min(self, other: Self) -> Self {
        self.exchanged(Comparison::Less, other)
    }

    fn try_sqrt(self) -> Option<Self> {
        (self >= Self::exactly(0.0)).then(|| self.sqrt())
    }

    fn powi(self, n: i32) -> Self {
        let power = node(|graph| graph.power(self.0, n.unsigned_abs()));
        if n < 0 { power.recip() } else { power }
    }

    fn powf(self, n: Self) -> Self {
        self.binary(Binary::Power, n)
    }

    fn atan2(self, other: Self) -> Self {
        self.binary(Binary::Atan2, other)
    }

    functions! {
        abs Abs, recip Reciprocal, sqrt Sqrt, exp Exp, ln Ln, sin Sin, cos Cos, tan Tan, asin Asin, acos Acos, atan Atan,
        sinh Sinh, cosh Cosh, tanh Tanh, asinh Asinh, acosh Acosh, atanh Atanh,
    }

    unsupported! { copysign(_sign), hypot(_other), cbrt(), exp_m1(), ln_1p(), }
}

real_field!(Recorded);
