//! The flat form of an expression: a list of instructions for a stack of scalars.
//!
//! Constants are folded only where that is exact in binary64, so that an interval evaluation encloses the real value of
//! the expression with the binary64 constants as written. A power with a small integer exponent becomes a product,
//! defined and differentiable for every base, and `ln(a + exp(z))` one operation that does not overflow.
//!
//! Conditions have a stack of bits of their own. `if` is compiled to jumps, forward only, so that the branch that is
//! not taken is not evaluated: it may be undefined there. Nothing is folded across the target of a jump.

use nalgebra::{RealField, convert};

use crate::LIMITS;
use std::sync::Arc;

use crate::function::{Binary, Comparison, LARGEST_PRODUCT, Unary, integer_power, saturate};
use crate::scope::Symbol;
use crate::surface::Surface;
use crate::table::Table;
use crate::tree::{Node, Tree};

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
    Product(u32),
    Saturate,
    /// The table of this index.
    Table(usize),
    /// The table of two variables of this index.
    Surface(usize),
    /// Two values to a condition.
    Compare(Comparison),
    And,
    Or,
    Not,
    /// Takes a condition, and goes on at that instruction if it is false.
    Unless(usize),
    /// Goes on at that instruction, beyond the other branch.
    Jump(usize),
}

impl Instruction {
    fn operands(self) -> usize {
        match self {
            Self::Unary(_) | Self::Product(_) | Self::Table(_) => 1,
            Self::Binary(_) | Self::Compare(_) | Self::Surface(_) => 2,
            Self::Saturate => 3,
            _ => 0,
        }
    }

    /// How many values it leaves. After the jump at its end a branch leaves none, since the other one will.
    fn heights(self, height: usize) -> usize {
        match self {
            Self::Compare(_) => height - 2,
            Self::Jump(_) => height - 1,
            Self::And | Self::Or | Self::Not | Self::Unless(_) => height,
            _ => height + 1 - self.operands(),
        }
    }
}

/// The instructions of an expression.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tape {
    /// Each with the node of the tree that it belongs to.
    code: Vec<(Instruction, usize)>,
    tables: Vec<Arc<Table>>,
    surfaces: Vec<Arc<Surface>>,
    /// Length of the stack.
    depth: usize,
}

/// A step of an evaluation: the node, its operands and its value.
pub(crate) struct Step<'s, T> {
    pub(crate) node: usize,
    pub(crate) operands: &'s [T],
    /// None of a comparison.
    pub(crate) value: Option<T>,
}

impl Tape {
    /// The instructions, or the node at which more values wait than there may be.
    pub(crate) fn compile(tree: &Tree) -> Result<Self, usize> {
        let mut code: Vec<(Instruction, usize)> = Vec::new();
        let (mut tables, mut surfaces): (Vec<Arc<Table>>, Vec<Arc<Surface>>) = Default::default();
        // Jumps whose target is not known yet, and where the code may not be changed any more.
        let (mut open, mut fixed): (Vec<usize>, usize) = (Vec::new(), 0);
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
                Node::Table(table, ..) => {
                    tables.push(Arc::clone(table));
                    Instruction::Table(tables.len() - 1)
                }
                Node::Surface(surface, ..) => {
                    surfaces.push(Arc::clone(surface));
                    Instruction::Surface(surfaces.len() - 1)
                }
                Node::Compare(comparison, ..) => Instruction::Compare(*comparison),
                Node::And(..) => Instruction::And,
                Node::Or(..) => Instruction::Or,
                Node::Not(_) => Instruction::Not,
                Node::Then => Instruction::Unless(usize::MAX),
                Node::Else => Instruction::Jump(usize::MAX),
                Node::If(..) => {
                    land(&mut code, &mut open);
                    fixed = code.len();
                    continue;
                }
            };
            match instruction {
                Instruction::Unless(_) => {
                    open.push(code.len());
                    code.push((instruction, node));
                    fixed = code.len();
                }
                Instruction::Jump(_) => {
                    code.push((instruction, node));
                    land(&mut code, &mut open);
                    open.push(code.len() - 1);
                    fixed = code.len();
                }
                _ => append(&mut code, fixed, instruction, node),
            }
        }
        let (mut height, mut depth, mut conditions) = (0, 1, 0usize);
        for (instruction, node) in &code {
            height = instruction.heights(height);
            depth = depth.max(height);
            match instruction {
                Instruction::Compare(_) => conditions += 1,
                Instruction::And | Instruction::Or | Instruction::Unless(_) => {
                    conditions = conditions.saturating_sub(1);
                }
                _ => {}
            }
            if depth.max(conditions) > LIMITS.depth {
                return Err(*node);
            }
        }
        Ok(Self { code, tables, surfaces, depth })
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
        // As many conditions as bits wait at most: `compile` has seen to that.
        let (mut top, mut conditions, mut at) = (0, 0u64, 0);
        while let Some(&(instruction, node)) = self.code.get(at) {
            at += 1;
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
                Instruction::Product(n) => integer_power(operands[0], n),
                Instruction::Saturate => saturate(operands[0], operands[1], operands[2]),
                Instruction::Table(k) => self.tables[k].at(operands[0]),
                Instruction::Surface(k) => self.surfaces[k].at(operands[0], operands[1]),
                Instruction::Compare(comparison) => {
                    conditions = conditions << 1 | u64::from(comparison.at(operands[0], operands[1]));
                    seen(Step { node, operands, value: None });
                    top = first;
                    continue;
                }
                Instruction::And => {
                    conditions = (conditions >> 2 << 1) | (conditions >> 1 & conditions & 1);
                    continue;
                }
                Instruction::Or => {
                    conditions = (conditions >> 2 << 1) | ((conditions >> 1 | conditions) & 1);
                    continue;
                }
                Instruction::Not => {
                    conditions ^= 1;
                    continue;
                }
                Instruction::Unless(other) => {
                    if conditions & 1 == 0 {
                        at = other;
                    }
                    conditions >>= 1;
                    continue;
                }
                Instruction::Jump(end) => {
                    at = end;
                    continue;
                }
            };
            seen(Step { node, operands, value: Some(value) });
            stack[first] = value;
            top = first + 1;
        }
        stack[0]
    }
}

/// The last open jump lands behind what there is.
fn land(code: &mut [(Instruction, usize)], open: &mut Vec<usize>) {
    let target = code.len();
    if let Some((Instruction::Unless(to) | Instruction::Jump(to), _)) = open.pop().and_then(|at| code.get_mut(at)) {
        *to = target;
    }
}

/// Appends an instruction, or what it comes to. The operands of an instruction end the code; one that is a constant is
/// one instruction. What comes before `fixed` stays as it is.
fn append(code: &mut Vec<(Instruction, usize)>, fixed: usize, instruction: Instruction, node: usize) {
    let index = |back: usize| code.len().checked_sub(back).filter(|index| *index >= fixed);
    let constant = |back: usize| match index(back).and_then(|index| code.get(index)) {
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
            let (joined, length) = match &code[fixed..] {
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
        code.push((Instruction::Product(size as u32), node));
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
