//! The syntax tree of an expression, stored as a list with operands before their operation, and its printed form.

use core::ops::Range;

use std::sync::Arc;

use crate::function::{Binary, Comparison, Unary};
use crate::scope::Symbol;
use crate::surface::Surface;
use crate::table::Table;

/// A node; operands are earlier nodes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Node {
    /// Not negative: a sign is an operation.
    Number(f64),
    Symbol(Symbol, String),
    Unary(Unary, usize),
    Binary(Binary, usize, usize),
    /// x, low, high.
    Saturate(usize, usize, usize),
    /// The table of that name at x.
    Table(Arc<Table>, String, usize),
    /// The table of two variables of that name at (x, y).
    Surface(Arc<Surface>, String, usize, usize),
    /// Two numbers to a condition.
    Compare(Comparison, usize, usize),
    And(usize, usize),
    Or(usize, usize),
    Not(usize),
    /// Between the condition of an `if` and the first branch.
    Then,
    /// Between the branches.
    Else,
    /// Condition, branch if it holds, branch if not.
    If(usize, usize, usize),
}

/// Nodes in the order in which a stack evaluates them; the last is the root.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tree {
    nodes: Vec<(Node, Range<usize>)>,
}

/// Binding power of the printed form of a node, as in the parser.
const OR: u8 = 1;
const AND: u8 = 2;
const COMPARISON: u8 = 3;
const SUM: u8 = 5;
const PRODUCT: u8 = 7;
const SIGN: u8 = 8;
const POWER: u8 = 9;
const ATOM: u8 = 10;

impl Tree {
    /// Adds a node that reaches over these bytes, and returns its number.
    pub(crate) fn push(&mut self, node: Node, span: Range<usize>) -> usize {
        self.nodes.push((node, span));
        self.nodes.len() - 1
    }

    pub(crate) fn nodes(&self) -> impl Iterator<Item = &Node> {
        self.nodes.iter().map(|(node, _)| node)
    }

    /// Whether a node is a condition, and not a number.
    pub(crate) fn is_condition(&self, node: usize) -> bool {
        let conditional = |node: &Node| matches!(node, Node::Compare(..) | Node::And(..) | Node::Or(..) | Node::Not(_));
        self.nodes.get(node).is_some_and(|(node, _)| conditional(node))
    }

    /// Takes the root away if it compares two numbers.
    pub(crate) fn unmake_comparison(&mut self) -> Option<(Comparison, usize, usize)> {
        let Some((Node::Compare(comparison, x, y), _)) = self.nodes.last() else { return None };
        let compared = (*comparison, *x, *y);
        self.nodes.pop();
        Some(compared)
    }

    /// The bytes that a node reaches over.
    pub(crate) fn span(&self, node: usize) -> Range<usize> {
        self.nodes.get(node).map_or(0..0, |(_, span)| span.clone())
    }

    /// A node in parentheses reaches over them.
    pub(crate) fn widen(&mut self, node: usize, wider: Range<usize>) {
        if let Some((_, span)) = self.nodes.get_mut(node) {
            *span = wider;
        }
    }

    /// The expression with as few parentheses as give the same tree.
    pub(crate) fn print(&self) -> String {
        let mut printed: Vec<(String, u8)> = Vec::with_capacity(self.nodes.len());
        for node in self.nodes() {
            // Each node is an operand once, so that its text can be taken.
            let mut take = |index: usize| core::mem::take(&mut printed[index]);
            let text = match node {
                Node::Number(number) => (format!("{number:?}"), ATOM),
                Node::Symbol(_, name) => (name.clone(), ATOM),
                Node::Unary(Unary::Negate, x) => (format!("-{}", held(take(*x), SIGN)), SIGN),
                Node::Unary(function, x) => (format!("{}({})", function.name(), take(*x).0), ATOM),
                Node::Binary(operation, x, y) => {
                    let (x, y, sign) = (take(*x), take(*y), operation.name());
                    match operation {
                        Binary::Add | Binary::Subtract => {
                            (format!("{} {sign} {}", held(x, SUM), held(y, SUM + 1)), SUM)
                        }
                        Binary::Multiply | Binary::Divide => {
                            (format!("{}{sign}{}", held(x, PRODUCT), held(y, PRODUCT + 1)), PRODUCT)
                        }
                        Binary::Power => (format!("{}^{}", held(x, POWER + 1), held(y, SIGN)), POWER),
                        _ => (format!("{sign}({}, {})", x.0, y.0), ATOM),
                    }
                }
                Node::Table(_, name, x) => (format!("{name}({})", take(*x).0), ATOM),
                Node::Surface(_, name, x, y) => (format!("{name}({}, {})", take(*x).0, take(*y).0), ATOM),
                Node::Compare(comparison, x, y) => {
                    let (x, y) = (held(take(*x), SUM), held(take(*y), SUM));
                    (format!("{x} {} {y}", comparison.sign()), COMPARISON)
                }
                Node::And(x, y) => (format!("{} && {}", held(take(*x), AND), held(take(*y), AND + 1)), AND),
                Node::Or(x, y) => (format!("{} || {}", held(take(*x), OR), held(take(*y), OR + 1)), OR),
                Node::Not(x) => (format!("!{}", held(take(*x), SIGN)), SIGN),
                Node::Then | Node::Else => (String::new(), ATOM),
                Node::If(condition, x, y) => {
                    (format!("if({}, {}, {})", take(*condition).0, take(*x).0, take(*y).0), ATOM)
                }
                Node::Saturate(x, low, high) => {
                    (format!("sat({}, {}, {})", take(*x).0, take(*low).0, take(*high).0), ATOM)
                }
            };
            printed.push(text);
        }
        printed.pop().unwrap_or_default().0
    }
}

/// In parentheses if it holds together less than is needed.
fn held((text, strength): (String, u8), needed: u8) -> String {
    if strength < needed { format!("({text})") } else { text }
}
