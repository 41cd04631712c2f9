//! The flat form of an expression: a list of instructions for a stack of scalars.
//!
//! Constants are folded only where that is exact in binary64, so that an interval evaluation encloses the real value of
//! the expression with the binary64 constants as written. A power with a small integer exponent becomes a product,
//! defined and differentiable for every base, and `ln(a + exp(z))` one operation that does not overflow.

use nalgebra::{RealField, convert};

use crate::LIMITS;
use crate::function::{Binary, Unary, saturate};
use crate::scope::Symbol;
use crate::tree::{Node, Tree};

/// The largest exponent that becomes a product.
const LARGEST_PRODUCT: f64 = 1000.0;

/// A product of numbers of which both are above this loses nothing below the smallest number.
const UNDERFLOW: f64 = 1e-140;

/// Typical bound of the stack size of an expression.
const SHORT: usize = 12;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Instruction {
    Constant(f64),
    Pi,
    E,
    Time,
    State(usize),
    Input(usize),
    Unary(Unary),
    Binary(Binary),
    /// `x^n` as a product.
    Product(i32),
    Saturate,
}

impl Instruction {
    fn operands(self) -> usize {
        match self {
            Self::Unary(_) | Self::Product(_) => 1,
            Self::Binary(_) => 2,
            Self::Saturate => 3,
            _ => 0,
        }
    }
}

/// The instructions of an expression.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tape {
    /// Each with the node of the tree that it belongs to.
    code: Vec<(Instruction, usize)>,
    /// Length of the stack.
    depth: usize,
}

/// A step of an evaluation: the node, its operands and its value.
pub(crate) struct Step<'s, T> {
    pub(crate) node: usize,
    pub(crate) operands: &'s [T],
    pub(crate) value: T,
}

impl Tape {
    /// The instructions, or the node at which more values wait than there may be.
    pub(crate) fn compile(tree: &Tree) -> Result<Self, usize> {
        let mut code: Vec<(Instruction, usize)> = Vec::new();
        for (node, what) in tree.nodes().enumerate() {
            let instruction = match what {
                Node::Number(number) => Instruction::Constant(*number),
                Node::Symbol(symbol, _) => match *symbol {
                    Symbol::Time => Instruction::Time,
                    Symbol::State(k) => Instruction::State(k),
                    Symbol::Input(k) => Instruction::Input(k),
                    Symbol::Pi => Instruction::Pi,
                    Symbol::E => Instruction::E,
                    Symbol::Parameter(value) => Instruction::Constant(value),
                },
                Node::Unary(unary, _) => Instruction::Unary(*unary),
                Node::Binary(binary, ..) => Instruction::Binary(*binary),
                Node::Saturate(..) => Instruction::Saturate,
            };
            append(&mut code, instruction, node);
        }
        let (mut height, mut depth) = (0, 1);
        for (instruction, node) in &code {
            height = height + 1 - instruction.operands();
            depth = depth.max(height);
            if depth > LIMITS.depth {
                return Err(*node);
            }
        }
        Ok(Self { code, depth })
    }

    /// The value; `seen` is shown every step.
    pub(crate) fn evaluate<T: RealField + Copy>(&self, t: T, x: &[T], u: &[T], seen: impl FnMut(Step<'_, T>)) -> T {
        if self.depth <= SHORT {
            self.run([T::zero(); SHORT], t, x, u, seen)
        } else {
            self.run([T::zero(); LIMITS.depth], t, x, u, seen)
        }
    }

    fn run<T: RealField + Copy, const DEPTH: usize>(
        &self,
        mut stack: [T; DEPTH],
        t: T,
        x: &[T],
        u: &[T],
        mut seen: impl FnMut(Step<'_, T>),
    ) -> T {
        // A column shorter than it should be has no such entry.
        let entry = |column: &[T], k: usize| column.get(k).copied().unwrap_or_else(|| convert(f64::NAN));
        let mut top = 0;
        for &(instruction, node) in &self.code {
            let first = top - instruction.operands();
            let operands = &stack[first..top];
            let value = match instruction {
                Instruction::Constant(number) => convert(number),
                Instruction::Pi => T::pi(),
                Instruction::E => T::e(),
                Instruction::Time => t,
                Instruction::State(k) => entry(x, k),
                Instruction::Input(k) => entry(u, k),
                Instruction::Unary(unary) => unary.at(operands[0]),
                Instruction::Binary(binary) => binary.at(operands[0], operands[1]),
                Instruction::Product(n) => operands[0].powi(n),
                Instruction::Saturate => saturate(operands[0], operands[1], operands[2]),
            };
            seen(Step { node, operands, value });
            stack[first] = value;
            top = first + 1;
        }
        stack[0]
    }
}

/// Appends an instruction, or what it comes to. The operands of an instruction end the code; one that is a constant is
/// one instruction.
fn append(code: &mut Vec<(Instruction, usize)>, instruction: Instruction, node: usize) {
    let constant = |back: usize| match code.len().checked_sub(back).and_then(|index| code.get(index)) {
        Some((Instruction::Constant(value), _)) => Some(*value),
        _ => None,
    };
    match instruction {
        Instruction::Unary(Unary::Negate) => {
            if let Some(x) = constant(1) {
                code.pop();
                code.push((Instruction::Constant(-x), node));
                return;
            }
        }
        Instruction::Unary(Unary::Ln) => {
            use Instruction::{Binary as Two, Constant, Unary as One};
            // The sum's second operand ends before it: an exponential, or a number after one.
            let (joined, length) = match code.as_slice() {
                [.., (One(Unary::Exp), _), (Two(Binary::Add), _)] => (Binary::LnPlusExp, 2),
                [.., (One(Unary::Exp), _), (Constant(_), _), (Two(Binary::Add), _)] => (Binary::LnExpPlus, 3),
                _ => (Binary::Add, 0),
            };
            if length > 0 {
                let number = (length == 3).then(|| code[code.len() - 2]);
                code.truncate(code.len() - length);
                code.extend(number);
                code.push((Two(joined), node));
                return;
            }
        }
        Instruction::Binary(binary) => {
            if let Some(y) = constant(1) {
                if let Some(value) = constant(2).and_then(|x| exact(binary, x, y)) {
                    code.truncate(code.len() - 2);
                    code.push((Instruction::Constant(value), node));
                    return;
                }
                if binary == Binary::Power && raised(code, y, node) {
                    return;
                }
            }
        }
        _ => {}
    }
    code.push((instruction, node));
}

/// Replaces a constant exponent y by what needs no logarithm, if there is such a thing.
fn raised(code: &mut Vec<(Instruction, usize)>, y: f64, node: usize) -> bool {
    let size = y.abs();
    let root = size == 0.5;
    if !(root || size.fract() == 0.0 && size <= LARGEST_PRODUCT) {
        return false;
    }
    code.pop();
    if root {
        code.push((Instruction::Unary(Unary::Sqrt), node));
    } else if size != 1.0 {
        code.push((Instruction::Product(size as i32), node));
    }
    if y < 0.0 {
        code.push((Instruction::Unary(Unary::Reciprocal), node));
    }
    true
}

/// The result of an operation on numbers, if binary64 has it.
fn exact(operation: Binary, x: f64, y: f64) -> Option<f64> {
    let sum = |x: f64, y: f64| {
        let s = x + y;
        // The rounding error of a sum is a binary64 number and found exactly (Knuth, The Art of Computer Programming,
        // vol. 2, 4.2.2).
        let rest = (x - (s - y)) + (y - (s - (s - y)));
        (rest == 0.0).then_some(s)
    };
    let product = |x: f64, y: f64| {
        let p = x * y;
        let large = x.abs() > UNDERFLOW && y.abs() > UNDERFLOW;
        ((x == 0.0 || y == 0.0 || large) && x.mul_add(y, -p) == 0.0).then_some(p)
    };
    let value = match operation {
        Binary::Add => sum(x, y),
        Binary::Subtract => sum(x, -y),
        Binary::Multiply => product(x, y),
        Binary::Divide => {
            let q = x / y;
            (y != 0.0 && product(q, y) == Some(x)).then_some(q)
        }
        Binary::Power if y.fract() == 0.0 && (0.0..=64.0).contains(&y) => {
            (0..y as u32).try_fold(1.0, |power, _| product(power, x))
        }
        _ => None,
    };
    value.filter(|value| value.is_finite())
}
