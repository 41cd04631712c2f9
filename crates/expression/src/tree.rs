//! The syntax tree of an expression, stored as a list with operands before their operation, and its printed form.

use core::ops::Range;

use crate::function::{Binary, Unary};
use crate::scope::Symbol;

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
}

/// Nodes in the order in which a stack evaluates them; the last is the root.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tree {
    nodes: Vec<(Node, Range<usize>)>,
}

/// Binding power of the printed form of a node, as in the parser.
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
