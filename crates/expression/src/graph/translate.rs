//! From the syntax tree of an expression to nodes of the graph.

use super::{Graph, Id, Node as Operation};
use crate::function::{Binary, LARGEST_PRODUCT, Unary};
use crate::scope::Symbol;
use crate::tree::{Node, Tree};

impl Graph {
    /// The node of an expression.
    pub(crate) fn expression(&mut self, tree: &Tree) -> Id {
        let nodes: Vec<&Node> = tree.nodes().collect();
        // The nodes between the parts of a choice have no value.
        let none = self.constant(0.0);
        let mut ids: Vec<Id> = Vec::with_capacity(nodes.len());
        for node in &nodes {
            let id = match node {
                Node::Number(number) => self.constant(*number),
                Node::Symbol(symbol, _) => match *symbol {
                    Symbol::Time => self.push(Operation::Time),
                    Symbol::State(k) => self.push(Operation::State(k as u32)),
                    Symbol::Input(k) => self.push(Operation::Input(k as u32)),
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

    fn looked_up(&mut self, table: u32, x: Id) -> Id {
        if let Some(value) = self.value(x) {
            let value = self.tables[table as usize].at(value);
            return self.constant(value);
        }
        self.push(Operation::Table(table, x))
    }
}
