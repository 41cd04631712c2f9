//! A routine over binary64 as a program for registers: constants are loaded, not evaluated, and the registers of values
//! that are no longer needed are used again.
//!
//! The operations and their order are those of the [`Routine`](super::Routine), so that the results are the same to the
//! last bit. A product that is used once, by a sum or another product, is one instruction with it, rounded as two: what
//! costs is to decode an instruction.

use std::sync::Arc;

use super::{Id, NamedMatrix, Node};
use crate::function::{Binary, Comparison, Unary};
use crate::table::Table;

/// The largest number of registers that live on the stack; longer routines are evaluated node by node.
const LARGEST: usize = 256;

/// A register.
type Register = u16;

/// Where a register gets its value at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Load {
    Time,
    State(u32),
    Input(u32),
}

/// An instruction; the first register is that of its result.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Instruction {
    Add(Register, Register, Register),
    Subtract(Register, Register, Register),
    Multiply(Register, Register, Register),
    Divide(Register, Register, Register),
    /// `a b + c`, `a b - c`, `c - a b`, `(a b) c`.
    MultiplyAdd(Register, Register, Register, Register),
    MultiplySubtract(Register, Register, Register, Register),
    SubtractProduct(Register, Register, Register, Register),
    MultiplyTwice(Register, Register, Register, Register),
    Negate(Register, Register),
    Unary(Unary, Register, Register),
    Binary(Binary, Register, Register, Register),
    Table(u16, Register, Register),
    Slope(u16, Register, Register),
    Compare(Comparison, Register, Register, Register),
    And(Register, Register, Register),
    Or(Register, Register, Register),
    Not(Register, Register),
    Select(Register, Register, Register, Register),
}

/// A program for registers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Program {
    /// The first registers.
    constants: Vec<f64>,
    /// The registers after them.
    loads: Vec<Load>,
    code: Vec<Instruction>,
    results: Vec<Register>,
    tables: Vec<Arc<Table>>,
    registers: usize,
}

impl Program {
    /// The program of these nodes, whose operands are earlier ones; none if it needs more registers than there are.
    pub(super) fn of(
        nodes: &[Node],
        results: &[Id],
        tables: &[Arc<Table>],
        matrices: &[Arc<NamedMatrix>],
    ) -> Option<Self> {
        let (mut constants, mut loads) = (Vec::new(), Vec::new());
        for node in nodes {
            match *node {
                Node::Constant(bits) => constants.push(f64::from_bits(bits)),
                Node::Epsilon => constants.push(f64::EPSILON),
                Node::Largest => constants.push(f64::MAX),
                Node::Truth(truth) => constants.push(f64::from(u8::from(truth))),
                Node::Entry(matrix, row, column) => constants.push(matrices[matrix as usize].entry(row, column)),
                Node::Time => loads.push(Load::Time),
                Node::State(k) => loads.push(Load::State(k)),
                Node::Input(k) => loads.push(Load::Input(k)),
                _ => {}
            }
        }
        let operations = fused(nodes, results);
        // After which node each value is needed no more; results are needed to the end.
        let mut last: Vec<usize> = (0..nodes.len()).collect();
        for (k, operation) in operations.iter().enumerate() {
            operation.operands().for_each(|operand| last[operand as usize] = k);
        }
        for result in results {
            last[*result as usize] = nodes.len();
        }
        let (mut constant, mut load) = (0, constants.len());
        let first = constants.len() + loads.len();
        let mut registers = first;
        let (mut free, mut code): (Vec<usize>, Vec<Instruction>) = (Vec::new(), Vec::new());
        let mut places = vec![0; nodes.len()];
        for (k, operation) in operations.iter().enumerate() {
            let counter = match operation {
                Operation::Node(
                    Node::Constant(_) | Node::Epsilon | Node::Largest | Node::Truth(_) | Node::Entry(..),
                ) => Some(&mut constant),
                Operation::Node(Node::Time | Node::State(_) | Node::Input(_)) => Some(&mut load),
                Operation::Within => continue,
                _ => None,
            };
            if let Some(counter) = counter {
                places[k] = *counter;
                *counter += 1;
                continue;
            }
            // A result may take the register of an operand that ends here: operands are read first.
            for operand in operation.operands().map(|operand| operand as usize) {
                let place = places[operand];
                if last[operand] == k && place >= first && !free.contains(&place) {
                    free.push(place);
                }
            }
            places[k] = free.pop().unwrap_or_else(|| {
                registers += 1;
                registers - 1
            });
            if registers > LARGEST {
                return None;
            }
            code.push(operation.instruction(places[k] as Register, |operand| places[operand as usize] as Register)?);
        }
        let results = results.iter().map(|result| places[*result as usize] as Register).collect();
        (registers <= LARGEST).then(|| Self { constants, loads, code, results, tables: tables.to_vec(), registers })
    }

    /// The results. States and inputs that are not there are NaN.
    pub(super) fn run(
        &self,
        t: f64,
        x: impl Fn(usize) -> f64,
        u: impl Fn(usize) -> f64,
        mut result: impl FnMut(usize, f64),
    ) {
        if self.code.is_empty() && self.constants.is_empty() {
            for (k, register) in self.results.iter().enumerate() {
                result(k, load(self.loads[usize::from(*register)], t, &x, &u));
            }
            return;
        }
        match self.registers {
            0..=32 => self.on::<32>(t, x, u, result),
            33..=64 => self.on::<64>(t, x, u, result),
            65..=128 => self.on::<128>(t, x, u, result),
            _ => self.on::<LARGEST>(t, x, u, result),
        }
    }

    fn on<const SIZE: usize>(
        &self,
        t: f64,
        x: impl Fn(usize) -> f64,
        u: impl Fn(usize) -> f64,
        mut result: impl FnMut(usize, f64),
    ) {
        let mut r = [0.0; SIZE];
        let constants = self.constants.len();
        for (k, constant) in self.constants.iter().enumerate() {
            r[k] = *constant;
        }
        for (k, load) in self.loads.iter().enumerate() {
            r[constants + k] = self::load(*load, t, &x, &u);
        }
        self.execute(&mut r);
        for (k, register) in self.results.iter().enumerate() {
            result(k, r[usize::from(*register) & (SIZE - 1)]);
        }
    }

    /// All instructions. Apart from [`on`](Self::on), which is compiled for each kind of argument.
    fn execute<const SIZE: usize>(&self, r: &mut [f64; SIZE]) {
        // The size is a power of two, so that a masked index needs no check.
        let at = |register: Register| usize::from(register) & (SIZE - 1);
        for instruction in &self.code {
            match *instruction {
                Instruction::Add(to, a, b) => r[at(to)] = r[at(a)] + r[at(b)],
                Instruction::Subtract(to, a, b) => r[at(to)] = r[at(a)] - r[at(b)],
                Instruction::Multiply(to, a, b) => r[at(to)] = r[at(a)] * r[at(b)],
                Instruction::Divide(to, a, b) => r[at(to)] = r[at(a)] / r[at(b)],
                Instruction::MultiplyAdd(to, a, b, c) => {
                    r[at(to)] = r[at(a)] * r[at(b)] + r[at(c)];
                }
                Instruction::MultiplySubtract(to, a, b, c) => {
                    r[at(to)] = r[at(a)] * r[at(b)] - r[at(c)];
                }
                Instruction::SubtractProduct(to, a, b, c) => {
                    r[at(to)] = r[at(c)] - r[at(a)] * r[at(b)];
                }
                Instruction::MultiplyTwice(to, a, b, c) => {
                    r[at(to)] = r[at(a)] * r[at(b)] * r[at(c)];
                }
                Instruction::Negate(to, a) => r[at(to)] = -r[at(a)],
                Instruction::Unary(unary, to, a) => r[at(to)] = unary.at(r[at(a)]),
                Instruction::Binary(binary, to, a, b) => {
                    r[at(to)] = binary.at(r[at(a)], r[at(b)]);
                }
                Instruction::Table(table, to, a) => {
                    let table = &self.tables[usize::from(table)];
                    r[at(to)] = table.at(r[at(a)]);
                }
                Instruction::Slope(table, to, a) => {
                    let table = &self.tables[usize::from(table)];
                    r[at(to)] = table.slope(r[at(a)]);
                }
                Instruction::Compare(comparison, to, a, b) => {
                    r[at(to)] = truth(comparison.at(r[at(a)], r[at(b)]));
                }
                Instruction::And(to, a, b) => {
                    r[at(to)] = truth(r[at(a)] != 0.0 && r[at(b)] != 0.0);
                }
                Instruction::Or(to, a, b) => {
                    r[at(to)] = truth(r[at(a)] != 0.0 || r[at(b)] != 0.0);
                }
                Instruction::Not(to, a) => r[at(to)] = truth(r[at(a)] == 0.0),
                Instruction::Select(to, condition, a, b) => {
                    r[at(to)] = if r[at(condition)] == 0.0 { r[at(b)] } else { r[at(a)] };
                }
            }
        }
    }
}

/// A condition is 1 or 0.
fn truth(condition: bool) -> f64 {
    f64::from(u8::from(condition))
}

fn load(load: Load, t: f64, x: &impl Fn(usize) -> f64, u: &impl Fn(usize) -> f64) -> f64 {
    match load {
        Load::Time => t,
        Load::State(k) => x(k as usize),
        Load::Input(k) => u(k as usize),
    }
}

/// A node, or a product together with the node that uses it.
#[derive(Clone, Copy)]
enum Operation {
    Node(Node),
    /// The operation on a product of the first two operands and the third one.
    Product(Binary, Id, Id, Id),
    /// `c - a b`.
    FromProduct(Id, Id, Id),
    /// A product within a later operation.
    Within,
}

impl Operation {
    fn operands(&self) -> impl Iterator<Item = Id> {
        let (node, product) = match *self {
            Self::Node(node) => (Some(node), None),
            Self::Product(_, a, b, c) | Self::FromProduct(a, b, c) => (None, Some([a, b, c])),
            Self::Within => (None, None),
        };
        node.into_iter().flat_map(Node::operands).chain(product.into_iter().flatten())
    }

    fn instruction(self, to: Register, place: impl Fn(Id) -> Register) -> Option<Instruction> {
        Some(match self {
            Self::Node(node) => return instruction(node, to, place),
            Self::Product(Binary::Add, a, b, c) => Instruction::MultiplyAdd(to, place(a), place(b), place(c)),
            Self::Product(Binary::Subtract, a, b, c) => Instruction::MultiplySubtract(to, place(a), place(b), place(c)),
            Self::Product(Binary::Multiply, a, b, c) => Instruction::MultiplyTwice(to, place(a), place(b), place(c)),
            Self::FromProduct(a, b, c) => Instruction::SubtractProduct(to, place(a), place(b), place(c)),
            Self::Product(..) | Self::Within => return None,
        })
    }
}

/// The nodes, of which products that are used once are within the operation that uses them.
fn fused(nodes: &[Node], results: &[Id]) -> Vec<Operation> {
    let mut uses = vec![0; nodes.len()];
    for operand in nodes.iter().flat_map(|node| node.operands()).chain(results.iter().copied()) {
        uses[operand as usize] += 1;
    }
    let mut operations: Vec<Operation> = nodes.iter().map(|node| Operation::Node(*node)).collect();
    for k in 0..nodes.len() {
        let Node::Binary(binary @ (Binary::Add | Binary::Subtract | Binary::Multiply), x, y) = nodes[k] else {
            continue;
        };
        let product = |operand: Id| match operations[operand as usize] {
            Operation::Node(Node::Binary(Binary::Multiply, a, b)) if uses[operand as usize] == 1 => Some((a, b)),
            _ => None,
        };
        // Sums and products of two numbers commute.
        let (within, operation) = match (product(x), product(y)) {
            (Some((a, b)), _) => (x, Operation::Product(binary, a, b, y)),
            (None, Some((a, b))) if binary == Binary::Subtract => (y, Operation::FromProduct(a, b, x)),
            (None, Some((a, b))) => (y, Operation::Product(binary, a, b, x)),
            (None, None) => continue,
        };
        (operations[within as usize], operations[k]) = (Operation::Within, operation);
    }
    operations
}

/// The instruction of a node that is an operation.
fn instruction(node: Node, to: Register, place: impl Fn(Id) -> Register) -> Option<Instruction> {
    Some(match node {
        Node::Unary(Unary::Negate, x) => Instruction::Negate(to, place(x)),
        Node::Unary(unary, x) => Instruction::Unary(unary, to, place(x)),
        Node::Binary(Binary::Add, x, y) => Instruction::Add(to, place(x), place(y)),
        Node::Binary(Binary::Subtract, x, y) => Instruction::Subtract(to, place(x), place(y)),
        Node::Binary(Binary::Multiply, x, y) => Instruction::Multiply(to, place(x), place(y)),
        Node::Binary(Binary::Divide, x, y) => Instruction::Divide(to, place(x), place(y)),
        Node::Binary(binary, x, y) => Instruction::Binary(binary, to, place(x), place(y)),
        Node::Table(table, x) => Instruction::Table(u16::try_from(table).ok()?, to, place(x)),
        Node::Slope(table, x) => Instruction::Slope(u16::try_from(table).ok()?, to, place(x)),
        Node::Compare(comparison, x, y) => Instruction::Compare(comparison, to, place(x), place(y)),
        Node::And(x, y) => Instruction::And(to, place(x), place(y)),
        Node::Or(x, y) => Instruction::Or(to, place(x), place(y)),
        Node::Not(x) => Instruction::Not(to, place(x)),
        Node::Select(condition, x, y) => Instruction::Select(to, place(condition), place(x), place(y)),
        Node::Constant(_)
        | Node::Epsilon
        | Node::Largest
        | Node::Truth(_)
        | Node::Entry(..)
        | Node::Time
        | Node::State(_)
        | Node::Input(_) => return None,
    })
}
