//! The right-hand sides of a plant as one graph: each subexpression once, derivatives by symbols, one order of
//! operations in Rust and in emitted C.
//!
//! A node is an operation whose operands are earlier nodes; a node that exists is not added again (value numbering).
//! Powers with an integer exponent are products in the order of [`Graph::power`]. Both sides of a choice are evaluated,
//! and the value of the one that is not taken has no effect, whether it is defined or not.
//!
//! Simplifications are exact: neutral elements, signs, and operations on constants, which are rounded to binary64 once.
//! A product with zero is kept unless the zero is a derivative that vanishes identically. In a recording the sign of a
//! zero is kept as well.
//!
//! | file | subject |
//! |---|---|
//! | `translate` | from the syntax tree of an expression to nodes |
//! | `derivative` | partial derivatives of nodes |
//! | `routine` | the nodes that some results need, in order: evaluation over any scalar |
//! | `recording` | a body that is written for every scalar, as a routine |
//! | `program` | a routine over binary64 in registers |
//! | `source` | a routine as source code of C and Rust |
//! | `loops` | a routine of named matrices as C, with loops |
//!
//! Source: value numbering: J. Cocke and J. T. Schwartz, Programming Languages and their Compilers, 1970; derivatives
//! by the chain rule over the graph: A. Griewank and A. Walther, Evaluating Derivatives, 2nd ed., SIAM 2008, ch. 3.

mod derivative;
mod loops;
mod program;
pub(crate) mod recording;
mod routine;
mod source;
mod translate;

use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::DMatrix;

pub use loops::Columns;
pub use recording::{Recorded, Recording, RecordingError, record};
pub use routine::Routine;
pub use source::{Dialect, Language, Lookups, MathFunction};

use crate::function::{Binary, Comparison, Unary};
use crate::table::Table;

/// The number of a node.
pub(crate) type Id = u32;

/// An operation; operands are earlier nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Node {
    /// The bits of a binary64 number.
    Constant(u64),
    /// The distance from 1 to the next number of the format.
    Epsilon,
    /// The largest number of the format.
    Largest,
    Truth(bool),
    /// An entry of the matrix of that number: row, column.
    Entry(u32, u32, u32),
    Time,
    State(u32),
    Input(u32),
    Unary(Unary, Id),
    Binary(Binary, Id, Id),
    /// The table of that number at x.
    Table(u32, Id),
    /// The derivative of the table.
    Slope(u32, Id),
    /// Two numbers to a condition.
    Compare(Comparison, Id, Id),
    And(Id, Id),
    Or(Id, Id),
    Not(Id),
    /// Condition, value if it holds, value if not.
    Select(Id, Id, Id),
}

impl Node {
    /// The operands, in order.
    pub(crate) fn operands(self) -> impl Iterator<Item = Id> {
        let list: [Option<Id>; 3] = match self {
            Self::Unary(_, x) | Self::Table(_, x) | Self::Slope(_, x) | Self::Not(x) => [Some(x), None, None],
            Self::Binary(_, x, y) | Self::Compare(_, x, y) | Self::And(x, y) | Self::Or(x, y) => {
                [Some(x), Some(y), None]
            }
            Self::Select(c, x, y) => [Some(c), Some(x), Some(y)],
            _ => [None; 3],
        };
        list.into_iter().flatten()
    }

    /// Whether it has no operands, so that it is written where it is used.
    pub(crate) fn is_leaf(self) -> bool {
        self.operands().next().is_none()
    }

    /// The same operation with other numbers for its operands.
    pub(crate) fn renumbered(self, number: impl Fn(Id) -> Id) -> Self {
        match self {
            Self::Unary(unary, x) => Self::Unary(unary, number(x)),
            Self::Binary(binary, x, y) => Self::Binary(binary, number(x), number(y)),
            Self::Table(table, x) => Self::Table(table, number(x)),
            Self::Slope(table, x) => Self::Slope(table, number(x)),
            Self::Compare(comparison, x, y) => Self::Compare(comparison, number(x), number(y)),
            Self::And(x, y) => Self::And(number(x), number(y)),
            Self::Or(x, y) => Self::Or(number(x), number(y)),
            Self::Not(x) => Self::Not(number(x)),
            Self::Select(c, x, y) => Self::Select(number(c), number(x), number(y)),
            leaf => leaf,
        }
    }
}

/// A matrix of numbers whose entries a program has by their places.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NamedMatrix {
    name: &'static str,
    values: DMatrix<f64>,
}

impl NamedMatrix {
    fn entry(&self, row: u32, column: u32) -> f64 {
        self.values[(row as usize, column as usize)]
    }
}

/// Operations on numbers, each once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    nodes: Vec<Node>,
    known: HashMap<Node, Id>,
    /// The values in binary64 and binary32 of nodes without time, states and inputs.
    fixed: Vec<Option<(f64, f32)>>,
    tables: Vec<Arc<Table>>,
    matrices: Vec<Arc<NamedMatrix>>,
    /// Of a recording: a simplification may not change the sign of a zero.
    keeps_signs: bool,
}

impl Graph {
    /// That of a recording, with these tables.
    fn recording(tables: Vec<Arc<Table>>) -> Self {
        Self { tables, keeps_signs: true, ..Self::default() }
    }

    /// Whether adding this constant changes no number: in a recording only that of the negative zero does not.
    fn is_neutral(&self, constant: Option<f64>) -> bool {
        constant.is_some_and(|zero| zero == 0.0 && (!self.keeps_signs || zero.is_sign_negative()))
    }

    fn node(&self, id: Id) -> Node {
        self.nodes[id as usize]
    }

    fn value(&self, id: Id) -> Option<f64> {
        match self.node(id) {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    fn truth(&self, id: Id) -> Option<bool> {
        match self.node(id) {
            Node::Truth(truth) => Some(truth),
            _ => None,
        }
    }

    /// The operand of a sign.
    fn negated(&self, id: Id) -> Option<Id> {
        match self.node(id) {
            Node::Unary(Unary::Negate, x) => Some(x),
            _ => None,
        }
    }

    fn push(&mut self, node: Node) -> Id {
        if let Some(id) = self.known.get(&node) {
            return *id;
        }
        // Rows are bounded in number and length, so that 32 bits count their nodes.
        let id = self.nodes.len() as Id;
        let fixed = self.fixed_value(node);
        self.nodes.push(node);
        self.fixed.push(fixed);
        self.known.insert(node, id);
        id
    }

    fn fixed_value(&self, node: Node) -> Option<(f64, f32)> {
        let of = |id: Id| self.fixed[id as usize];
        match node {
            Node::Constant(bits) => Some((f64::from_bits(bits), f64::from_bits(bits) as f32)),
            Node::Epsilon => Some((f64::EPSILON, f32::EPSILON)),
            Node::Largest => Some((f64::MAX, f32::MAX)),
            Node::Entry(matrix, row, column) => {
                let value = self.matrices[matrix as usize].entry(row, column);
                Some((value, value as f32))
            }
            Node::Unary(unary, x) => of(x).map(|(x, single)| (unary.at(x), unary.at(single))),
            Node::Binary(binary, x, y) => of(x).zip(of(y)).map(|(x, y)| (binary.at(x.0, y.0), binary.at(x.1, y.1))),
            // A condition is 1 or 0, and may differ in the two.
            Node::Truth(truth) => Some((truth.into(), truth.into())),
            Node::Compare(comparison, x, y) => {
                of(x).zip(of(y)).map(|(x, y)| (comparison.at(x.0, y.0).into(), comparison.at(x.1, y.1).into()))
            }
            Node::And(x, y) => of(x).zip(of(y)).map(|(x, y)| (x.0 * y.0, x.1 * y.1)),
            Node::Or(x, y) => of(x).zip(of(y)).map(|(x, y)| (x.0.max(y.0), x.1.max(y.1))),
            Node::Not(x) => of(x).map(|x| (1.0 - x.0, 1.0 - x.1)),
            Node::Select(condition, x, y) => {
                let ((double, single), (x, y)) = (of(condition)?, of(x).zip(of(y))?);
                Some((if double == 0.0 { y.0 } else { x.0 }, if single == 0.0 { y.1 } else { x.1 }))
            }
            _ => None,
        }
    }

    fn table(&mut self, table: &Arc<Table>) -> u32 {
        let known = self.tables.iter().position(|other| Arc::ptr_eq(other, table) || other == table);
        known.unwrap_or_else(|| {
            self.tables.push(Arc::clone(table));
            self.tables.len() - 1
        }) as u32
    }

    /// The number of a matrix.
    fn matrix(&mut self, matrix: &Arc<NamedMatrix>) -> u32 {
        let known = self.matrices.iter().position(|other| Arc::ptr_eq(other, matrix));
        known.unwrap_or_else(|| {
            self.matrices.push(Arc::clone(matrix));
            self.matrices.len() - 1
        }) as u32
    }

    pub(crate) fn constant(&mut self, value: f64) -> Id {
        self.push(Node::Constant(value.to_bits()))
    }

    /// The node of an operation on constants, if the result is a finite number; beside matrices, whose numbers are
    /// those of the format, only if the format computes it.
    fn folded(&mut self, value: f64, single: f32) -> Option<Id> {
        let is_same = self.matrices.is_empty() || (value as f32).to_bits() == single.to_bits();
        (value.is_finite() && is_same).then(|| self.constant(value))
    }

    pub(crate) fn unary(&mut self, unary: Unary, x: Id) -> Id {
        if let Some(value) = self.value(x)
            && let Some(id) = self.folded(unary.at(value), unary.at(value as f32))
        {
            return id;
        }
        if unary == Unary::Negate {
            match self.node(x) {
                Node::Unary(Unary::Negate, inner) => return inner,
                Node::Binary(Binary::Subtract, a, b) if !self.keeps_signs => {
                    return self.binary(Binary::Subtract, b, a);
                }
                _ => {}
            }
        }
        self.push(Node::Unary(unary, x))
    }

    pub(crate) fn negate(&mut self, x: Id) -> Id {
        self.unary(Unary::Negate, x)
    }

    pub(crate) fn add(&mut self, x: Id, y: Id) -> Id {
        self.binary(Binary::Add, x, y)
    }

    pub(crate) fn subtract(&mut self, x: Id, y: Id) -> Id {
        self.binary(Binary::Subtract, x, y)
    }

    pub(crate) fn multiply(&mut self, x: Id, y: Id) -> Id {
        self.binary(Binary::Multiply, x, y)
    }

    pub(crate) fn divide(&mut self, x: Id, y: Id) -> Id {
        self.binary(Binary::Divide, x, y)
    }

    pub(crate) fn binary(&mut self, binary: Binary, x: Id, y: Id) -> Id {
        let (first, second) = (self.value(x), self.value(y));
        if let (Some(first), Some(second)) = (first, second)
            && let Some(id) = self.folded(binary.at(first, second), binary.at(first as f32, second as f32))
        {
            return id;
        }
        match binary {
            Binary::Add => self.sum(x, y, first, second),
            Binary::Subtract => match (self.negated(y), first, second) {
                (_, _, Some(zero)) if self.is_neutral(Some(-zero)) => x,
                (_, Some(0.0), _) if !self.keeps_signs => self.negate(y),
                (Some(y), ..) => self.add(x, y),
                _ => self.push(Node::Binary(binary, x, y)),
            },
            Binary::Multiply => self.product(x, y, first, second),
            Binary::Divide => match (self.negated(x), self.negated(y), second) {
                (_, _, Some(1.0)) => x,
                (_, _, Some(-1.0)) => self.negate(x),
                (Some(x), Some(y), _) => self.divide(x, y),
                (Some(x), None, _) => {
                    let quotient = self.divide(x, y);
                    self.negate(quotient)
                }
                (None, Some(y), _) => {
                    let quotient = self.divide(x, y);
                    self.negate(quotient)
                }
                _ => self.push(Node::Binary(binary, x, y)),
            },
            _ => self.push(Node::Binary(binary, x, y)),
        }
    }

    fn sum(&mut self, x: Id, y: Id, first: Option<f64>, second: Option<f64>) -> Id {
        match (self.negated(x), self.negated(y), first, second) {
            _ if self.is_neutral(second) => x,
            _ if self.is_neutral(first) => y,
            (_, Some(y), ..) => self.subtract(x, y),
            (Some(x), ..) => self.subtract(y, x),
            // Addition and multiplication of floating-point numbers commute.
            _ => self.push(Node::Binary(Binary::Add, x.min(y), x.max(y))),
        }
    }

    fn product(&mut self, x: Id, y: Id, first: Option<f64>, second: Option<f64>) -> Id {
        match (self.negated(x), self.negated(y), first, second) {
            (_, _, _, Some(1.0)) => x,
            (_, _, Some(1.0), _) => y,
            (_, _, _, Some(-1.0)) => self.negate(x),
            (_, _, Some(-1.0), _) => self.negate(y),
            (Some(x), Some(y), ..) => self.multiply(x, y),
            (Some(x), None, ..) => {
                let product = self.multiply(x, y);
                self.negate(product)
            }
            (None, Some(y), ..) => {
                let product = self.multiply(x, y);
                self.negate(product)
            }
            _ => self.push(Node::Binary(Binary::Multiply, x.min(y), x.max(y))),
        }
    }

    /// `x^n`, in the order of [`integer_power`](crate::function::integer_power).
    pub(crate) fn power(&mut self, x: Id, n: u32) -> Id {
        let one = self.constant(1.0);
        crate::function::square_and_multiply(x, n, one, |a, b| self.multiply(a, b))
    }

    pub(crate) fn compare(&mut self, comparison: Comparison, x: Id, y: Id) -> Id {
        // What is the same in both formats.
        let answer = self.fixed[x as usize].zip(self.fixed[y as usize]).and_then(|(x, y)| {
            let answer = comparison.at(x.0, y.0);
            (answer == comparison.at(x.1, y.1)).then_some(answer)
        });
        match answer {
            Some(truth) => self.push(Node::Truth(truth)),
            None => self.push(Node::Compare(comparison, x, y)),
        }
    }

    pub(crate) fn and(&mut self, x: Id, y: Id) -> Id {
        match (self.truth(x), self.truth(y)) {
            (Some(false), _) | (_, Some(true)) => x,
            (_, Some(false)) | (Some(true), _) => y,
            _ => self.push(Node::And(x, y)),
        }
    }

    pub(crate) fn or(&mut self, x: Id, y: Id) -> Id {
        match (self.truth(x), self.truth(y)) {
            (Some(true), _) | (_, Some(false)) => x,
            (_, Some(true)) | (Some(false), _) => y,
            _ => self.push(Node::Or(x, y)),
        }
    }

    pub(crate) fn not(&mut self, x: Id) -> Id {
        match self.truth(x) {
            Some(truth) => self.push(Node::Truth(!truth)),
            None => self.push(Node::Not(x)),
        }
    }

    /// Whether a number is finite.
    pub(crate) fn finite(&mut self, x: Id) -> Id {
        let (size, largest) = (self.unary(Unary::Abs, x), self.push(Node::Largest));
        self.compare(Comparison::LessOrEqual, size, largest)
    }

    pub(crate) fn select(&mut self, condition: Id, x: Id, y: Id) -> Id {
        match self.truth(condition) {
            Some(true) => x,
            Some(false) => y,
            None if x == y => x,
            None => self.push(Node::Select(condition, x, y)),
        }
    }
}
