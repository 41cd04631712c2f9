//! Expressions that are syntactically affine in states and inputs, or in the states while the inputs are held.

use crate::function::{Binary, Unary};
use crate::scope::Symbol;
use crate::tree::{Node, Tree};

/// Classification of a node.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Constant,
    Affine,
    /// Not affine because of that node.
    Not(usize),
}

/// With `inputs_held` inputs count as constants.
///
/// # Errors
/// The first node that is not affine.
pub(crate) fn affine(tree: &Tree, inputs_held: bool) -> Result<(), usize> {
    use Form::{Affine, Constant, Not};
    let mut forms: Vec<Form> = Vec::new();
    for (index, node) in tree.nodes().enumerate() {
        // A condition that is no constant is `Affine`: it only matters that it varies.
        let form = match node {
            Node::Number(_)
            | Node::Symbol(Symbol::Pi | Symbol::E | Symbol::Parameter(_), _)
            | Node::Then
            | Node::Else => Constant,
            Node::Symbol(Symbol::Input(_), _) if inputs_held => Constant,
            Node::Symbol(Symbol::State(_) | Symbol::Input(_), _) => Affine,
            Node::Symbol(Symbol::Time, _) => Not(index),
            Node::Unary(unary, x) => match forms[*x] {
                Affine if *unary != Unary::Negate => Not(index),
                form => form,
            },
            Node::Binary(operation, x, y) => match (operation, forms[*x], forms[*y]) {
                (_, Not(why), _) | (_, _, Not(why)) => Not(why),
                (_, Constant, Constant) => Constant,
                (Binary::Add | Binary::Subtract, ..)
                | (Binary::Multiply, Constant, _)
                | (Binary::Multiply | Binary::Divide, _, Constant) => Affine,
                _ => Not(index),
            },
            Node::Table(_, _, x) => match forms[*x] {
                Affine => Not(index),
                form => form,
            },
            Node::Surface(_, _, x, y) => match (forms[*x], forms[*y]) {
                (Not(why), _) | (_, Not(why)) => Not(why),
                (Constant, Constant) => Constant,
                _ => Not(index),
            },
            Node::Not(x) => forms[*x],
            Node::Compare(_, x, y) | Node::And(x, y) | Node::Or(x, y) => match (forms[*x], forms[*y]) {
                (Not(why), _) | (_, Not(why)) => Not(why),
                (Constant, Constant) => Constant,
                _ => Affine,
            },
            Node::If(condition, x, y) => match (forms[*condition], forms[*x], forms[*y]) {
                (Not(why), ..) | (_, Not(why), _) | (_, _, Not(why)) => Not(why),
                (Affine, ..) => Not(index),
                (_, Constant, Constant) => Constant,
                _ => Affine,
            },
            Node::Saturate(x, low, high) => match (forms[*x], forms[*low], forms[*high]) {
                (Not(why), ..) | (_, Not(why), _) | (_, _, Not(why)) => Not(why),
                (Constant, Constant, Constant) => Constant,
                _ => Not(index),
            },
        };
        forms.push(form);
    }
    match forms.last() {
        Some(Not(why)) => Err(*why),
        _ => Ok(()),
    }
}
