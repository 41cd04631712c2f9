//! From the syntax tree of an expression to nodes of the graph.

use super::{Graph, Id, Node as Operation, Routine};
use crate::function::{Binary, Comparison, LARGEST_PRODUCT, Unary};
use crate::scope::Symbol;
use crate::surface::Surface;
use crate::tree::{Node, Tree};

/// What stands for time, states and inputs.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Leaves<'a> {
    /// Themselves.
    Own,
    /// These nodes; others are NaN.
    Given {
        /// The time.
        t: Id,
        /// The states.
        x: &'a [Id],
        /// The inputs.
        u: &'a [Id],
    },
}

impl Graph {
    /// The node of time, of a state or of an input.
    fn leaf(&mut self, leaf: Operation, leaves: Leaves<'_>) -> Id {
        let given = match (leaves, leaf) {
            (Leaves::Given { t, .. }, Operation::Time) => Some(t),
            (Leaves::Given { x, .. }, Operation::State(k)) => x.get(k as usize).copied(),
            (Leaves::Given { u, .. }, Operation::Input(k)) => u.get(k as usize).copied(),
            _ => return self.push(leaf),
        };
        given.unwrap_or_else(|| self.constant(f64::NAN))
    }

    /// The nodes of the results of a routine.
    pub(super) fn inlined(&mut self, routine: &Routine, leaves: Leaves<'_>) -> Vec<Id> {
        let tables: Vec<u32> = routine.tables.iter().map(|table| self.table(table)).collect();
        let matrices: Vec<u32> = routine.matrices.iter().map(|matrix| self.matrix(matrix)).collect();
        let mut ids: Vec<Id> = Vec::with_capacity(routine.code.len());
        for node in &routine.code {
            let node = node.renumbered(|operand| ids[operand as usize]);
            let id = match node {
                Operation::Time | Operation::State(_) | Operation::Input(_) => self.leaf(node, leaves),
                Operation::Entry(matrix, row, column) => {
                    self.push(Operation::Entry(matrices[matrix as usize], row, column))
                }
                Operation::Unary(unary, x) => self.unary(unary, x),
                Operation::Binary(binary, x, y) => self.binary(binary, x, y),
                Operation::Table(table, x) => self.looked_up(tables[table as usize], x),
                Operation::Slope(table, x) => self.push(Operation::Slope(tables[table as usize], x)),
                Operation::Compare(comparison, x, y) => self.compare(comparison, x, y),
                Operation::And(x, y) => self.and(x, y),
                Operation::Or(x, y) => self.or(x, y),
                Operation::Not(x) => self.not(x),
                Operation::Select(condition, x, y) => self.select(condition, x, y),
                Operation::Constant(_) | Operation::Epsilon | Operation::Largest | Operation::Truth(_) => {
                    self.push(node)
                }
            };
            ids.push(id);
        }
        routine.results.iter().map(|result| ids[*result as usize]).collect()
    }

    /// The node of an expression.
    pub(crate) fn expression(&mut self, tree: &Tree) -> Id {
        self.expression_of(tree, Leaves::Own)
    }

    /// The same of these variables.
    pub(crate) fn expression_of(&mut self, tree: &Tree, leaves: Leaves<'_>) -> Id {
        let nodes: Vec<&Node> = tree.nodes().collect();
        // The nodes between the parts of a choice have no value.
        let none = self.constant(0.0);
        let mut ids: Vec<Id> = Vec::with_capacity(nodes.len());
        for node in &nodes {
            let id = match node {
                Node::Number(number) => self.constant(*number),
                Node::Symbol(symbol, _) => match *symbol {
                    Symbol::Time => self.leaf(Operation::Time, leaves),
                    Symbol::State(k) => self.leaf(Operation::State(k as u32), leaves),
                    Symbol::Input(k) => self.leaf(Operation::Input(k as u32), leaves),
                    Symbol::Pi => self.constant(core::f64::consts::PI),
                    Symbol::E => self.constant(core::f64::consts::E),
                    Symbol::Parameter(value) => self.constant(value),
                },
                Node::Unary(Unary::Ln, x) => self.logarithm(&nodes, &ids, *x),
                Node::Unary(unary, x) => self.unary(*unary, ids[*x]),
                Node::Binary(Binary::Power, x, y) => self.raised(ids[*x], ids[*y]),
                Node::Binary(binary, x, y) => self.binary(*binary, ids[*x], ids[*y]),
                Node::Saturate(x, low, high) => {
                    let above = self.binary(Binary::Max, ids[*x], ids[*low]);
                    self.binary(Binary::Min, above, ids[*high])
                }
                Node::Table(table, _, x) => {
                    let table = self.table(table);
                    self.looked_up(table, ids[*x])
                }
                Node::Surface(surface, _, x, y) => self.looked_up_at(surface, ids[*x], ids[*y]),
                Node::Compare(comparison, x, y) => self.compare(*comparison, ids[*x], ids[*y]),
                Node::And(x, y) => self.and(ids[*x], ids[*y]),
                Node::Or(x, y) => self.or(ids[*x], ids[*y]),
                Node::Not(x) => self.not(ids[*x]),
                Node::Then | Node::Else => none,
                Node::If(condition, x, y) => self.select(ids[*condition], ids[*x], ids[*y]),
            };
            ids.push(id);
        }
        ids.last().copied().unwrap_or(none)
    }

    /// `ln(x)`; `ln(a + exp(z))` is one operation, which does not overflow.
    fn logarithm(&mut self, nodes: &[&Node], ids: &[Id], x: usize) -> Id {
        if let Node::Binary(Binary::Add, a, b) = nodes[x] {
            if let Node::Unary(Unary::Exp, z) = nodes[*b] {
                return self.binary(Binary::LnPlusExp, ids[*a], ids[*z]);
            }
            if let (Node::Unary(Unary::Exp, z), Some(_)) = (nodes[*a], self.value(ids[*b])) {
                return self.binary(Binary::LnPlusExp, ids[*b], ids[*z]);
            }
        }
        self.unary(Unary::Ln, ids[x])
    }

    /// `x^y`: without a logarithm where y is an integer or a half.
    pub(super) fn raised(&mut self, x: Id, y: Id) -> Id {
        let Some(exponent) = self.value(y) else { return self.binary(Binary::Power, x, y) };
        let size = exponent.abs();
        let power = if size == 0.5 {
            self.unary(Unary::Sqrt, x)
        } else if size.fract() == 0.0 && size <= LARGEST_PRODUCT {
            self.power(x, size as u32)
        } else {
            return self.binary(Binary::Power, x, y);
        };
        if exponent < 0.0 { self.unary(Unary::Reciprocal, power) } else { power }
    }

    /// As [`Surface::at`].
    fn looked_up_at(&mut self, surface: &Surface, x: Id, y: Id) -> Id {
        let x = match surface.held() {
            Some(ends) => {
                let [low, high] = ends.map(|end| self.constant(end));
                let above = self.binary(Binary::Max, x, low);
                self.binary(Binary::Min, above, high)
            }
            None => x,
        };
        let mut nodes: Vec<(f64, Id)> = Vec::new();
        for (from, row) in surface.rows() {
            let row = self.table(row);
            nodes.push((from, self.looked_up(row, y)));
        }
        let mut value = None;
        for pair in nodes.windows(2).rev() {
            let ((from, low), (to, high)) = (pair[0], pair[1]);
            let (start, end, width) = (self.constant(from), self.constant(to), self.constant(to - from));
            let passed = self.binary(Binary::Subtract, x, start);
            let share = self.binary(Binary::Divide, passed, width);
            let rise = self.binary(Binary::Subtract, high, low);
            let step = self.binary(Binary::Multiply, share, rise);
            let piece = self.binary(Binary::Add, low, step);
            value = Some(match value {
                Some(later) => {
                    let is_before = self.compare(Comparison::Less, x, end);
                    self.select(is_before, piece, later)
                }
                None => piece,
            });
        }
        // A surface has two rows or more.
        value.unwrap_or(x)
    }

    fn looked_up(&mut self, table: u32, x: Id) -> Id {
        if let Some(value) = self.value(x) {
            let value = self.tables[table as usize].at(value);
            return self.constant(value);
        }
        self.push(Operation::Table(table, x))
    }
}
