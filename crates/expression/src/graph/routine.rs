//! A routine: the operations that some results need, in order, and their evaluation over any scalar.

use core::any::TypeId;
use std::collections::BTreeSet;
use std::sync::Arc;

use nalgebra::{RealField, convert, try_convert};

use super::loops::{self, Columns};
use super::program::Program;
use super::recording;
use super::source::{self, Dialect, Lookups, MathFunction};
use super::translate::Leaves;
use super::{Graph, Id, NamedMatrix, Node};
use crate::function::{Binary, Unary};
use crate::table::Table;

/// Straight-line code for some functions of time, states and inputs, each operation once.
#[derive(Clone, Debug, PartialEq)]
pub struct Routine {
    pub(super) code: Vec<Node>,
    pub(super) results: Vec<Id>,
    pub(crate) tables: Vec<Arc<Table>>,
    pub(super) matrices: Vec<Arc<NamedMatrix>>,
    /// What runs over binary64, unless it is too long.
    program: Option<Program>,
}

impl Graph {
    /// The routine of these results.
    pub(crate) fn routine(&self, results: &[Id]) -> Routine {
        let needed = self.needed(results);
        let mut number = vec![0; needed.len()];
        let mut code = Vec::new();
        for (id, node) in self.nodes.iter().enumerate() {
            if needed[id] {
                number[id] = code.len() as Id;
                code.push(node.renumbered(|operand| number[operand as usize]));
            }
        }
        let results: Vec<Id> = results.iter().map(|id| number[*id as usize]).collect();
        let (tables, matrices) = (self.tables.clone(), self.matrices.clone());
        let program = Program::of(&code, &results, &tables, &matrices);
        Routine { code, results, tables, matrices, program }
    }
}

impl Routine {
    /// The number of results.
    pub fn len(&self) -> usize {
        self.results.len()
    }

    /// Whether there are no results.
    pub fn is_empty(&self) -> bool {
        self.results.is_empty()
    }

    /// The results at the time t, the states x and the inputs u, one after the other. States and inputs that are not
    /// there are NaN.
    pub fn evaluate<T: RealField + Copy>(&self, t: T, x: &[T], u: &[T], mut result: impl FnMut(usize, T)) {
        if let Some(program) = self.program.as_ref().filter(|_| TypeId::of::<T>() == TypeId::of::<f64>()) {
            // Over f64 the conversions do nothing.
            let number = |value: T| try_convert(value).unwrap_or(f64::NAN);
            let entry = |column: &[T], k: usize| column.get(k).map_or(f64::NAN, |value| number(*value));
            return program.run(number(t), |k| entry(x, k), |k| entry(u, k), |k, value| result(k, convert(value)));
        }
        if let Some(values) = recording::routine(self, &t, x, u) {
            return values.into_iter().enumerate().for_each(|(k, value)| result(k, value));
        }
        // Most plants are short; the stack of the others is not worth an allocation per call until they are long.
        match self.code.len() {
            0..=16 => self.run(&mut [T::zero(); 16], t, x, u, result),
            17..=64 => self.run(&mut [T::zero(); 64], t, x, u, result),
            65..=256 => self.run(&mut [T::zero(); 256], t, x, u, result),
            length => self.run(&mut vec![T::zero(); length], t, x, u, result),
        }
    }

    fn run<T: RealField + Copy>(&self, values: &mut [T], t: T, x: &[T], u: &[T], mut result: impl FnMut(usize, T)) {
        let entry = |column: &[T], k: u32| column.get(k as usize).copied().unwrap_or_else(|| convert(f64::NAN));
        // A condition is 1 or 0.
        let truth = |condition: bool| if condition { T::one() } else { T::zero() };
        for (k, node) in self.code.iter().enumerate() {
            let at = |id: Id| values[id as usize];
            let holds = |id: Id| at(id) != T::zero();
            values[k] = match *node {
                Node::Constant(bits) => convert(f64::from_bits(bits)),
                Node::Epsilon => T::default_epsilon(),
                Node::Largest => T::max_value().unwrap_or_else(|| convert(f64::MAX)),
                Node::Truth(condition) => truth(condition),
                Node::Entry(matrix, row, column) => convert(self.entry(matrix, row, column)),
                Node::Time => t,
                Node::State(k) => entry(x, k),
                Node::Input(k) => entry(u, k),
                Node::Unary(unary, x) => unary.at(at(x)),
                Node::Binary(binary, x, y) => binary.at(at(x), at(y)),
                Node::Table(table, x) => self.tables[table as usize].at(at(x)),
                Node::Slope(table, x) => self.tables[table as usize].slope(at(x)),
                Node::Compare(comparison, x, y) => truth(comparison.at(at(x), at(y))),
                Node::And(x, y) => truth(holds(x) && holds(y)),
                Node::Or(x, y) => truth(holds(x) || holds(y)),
                Node::Not(x) => truth(!holds(x)),
                Node::Select(condition, x, y) => {
                    if holds(condition) {
                        at(x)
                    } else {
                        at(y)
                    }
                }
            };
        }
        for (k, id) in self.results.iter().enumerate() {
            result(k, values[*id as usize]);
        }
    }

    /// The derivatives of its results by the first n states, row by row.
    ///
    /// ```
    /// use luenberger_expression::{ExpressionPlant, Parameters};
    /// let plant = ExpressionPlant::new(&["x1*x2", "x2^2"], &["x1"], 0, &Parameters::new())?;
    /// let mut jacobian = Vec::new();
    /// plant.routines().f.jacobian(2).evaluate(0.0, &[2.0, 3.0], &[], |_, entry| jacobian.push(entry));
    /// assert_eq!(jacobian, [3.0, 2.0, 0.0, 6.0]);
    /// # Ok::<(), luenberger_expression::ExpressionPlantError>(())
    /// ```
    #[must_use]
    pub fn jacobian(&self, n: usize) -> Self {
        let mut graph = Graph { tables: self.tables.clone(), ..Graph::default() };
        let results = graph.inlined(self, Leaves::Own);
        let jacobian = graph.jacobian(&results, n);
        graph.routine(&jacobian)
    }

    /// An entry of a named matrix.
    pub(super) fn entry(&self, matrix: u32, row: u32, column: u32) -> f64 {
        self.matrices[matrix as usize].entry(row, column)
    }

    /// The name of a matrix.
    pub(super) fn matrix(&self, matrix: u32) -> &'static str {
        self.matrices[matrix as usize].name
    }

    /// Whether its results are the states, in order.
    pub fn is_identity(&self) -> bool {
        let mut results = self.results.iter().map(|result| self.code[*result as usize]).enumerate();
        results.all(|(k, node)| node == Node::State(k as u32))
    }

    /// Whether the time occurs in it.
    pub fn uses_time(&self) -> bool {
        self.code.contains(&Node::Time)
    }

    /// Whether a state occurs in it.
    pub fn uses_states(&self) -> bool {
        self.code.iter().any(|node| matches!(node, Node::State(_)))
    }

    /// Whether an input occurs in it.
    pub fn uses_inputs(&self) -> bool {
        self.code.iter().any(|node| matches!(node, Node::Input(_)))
    }

    /// Whether an input of these numbers occurs in it.
    pub fn uses_inputs_in(&self, range: core::ops::Range<usize>) -> bool {
        self.code.iter().any(|node| matches!(node, Node::Input(k) if range.contains(&(*k as usize))))
    }

    /// The result `k` if it is a constant.
    pub fn constant(&self, k: usize) -> Option<f64> {
        match self.code[self.results[k] as usize] {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// The constants that it uses, in order; those of tables included.
    pub fn constants(&self) -> impl Iterator<Item = f64> {
        let own = self.code.iter().filter_map(|node| match node {
            Node::Constant(bits) => Some(f64::from_bits(*bits)),
            _ => None,
        });
        own.chain(self.used_tables().flat_map(|(_, table, _)| table.numbers().collect::<Vec<_>>()))
    }

    /// The tables that it uses, with their numbers, which are those of the plant, and what it uses of them.
    pub fn used_tables(&self) -> impl Iterator<Item = (usize, &Table, Lookups)> {
        let used = |k: usize| {
            let mut used = Lookups::default();
            for node in &self.code {
                match node {
                    Node::Table(table, _) if *table as usize == k => used.value = true,
                    Node::Slope(table, _) if *table as usize == k => used.slope = true,
                    _ => {}
                }
            }
            used
        };
        let all = self.tables.iter().enumerate().map(move |(k, table)| (k, table.as_ref(), used(k)));
        all.filter(|(_, _, used)| used.value || used.slope)
    }

    /// Operations on numbers: sums, products, quotients, comparisons and calls of functions, each counted once.
    pub fn operations(&self) -> usize {
        let counts = |node: &&Node| {
            !node.is_leaf()
                && !matches!(
                    node,
                    Node::Unary(Unary::Negate | Unary::Abs, _)
                        | Node::And(..)
                        | Node::Or(..)
                        | Node::Not(_)
                        | Node::Select(..)
                )
        };
        // The operations of `x - y floor(x/y)` and `x + y floor(1/2 - x/y)` after the first.
        let more = |node: &Node| match node {
            Node::Binary(Binary::Modulo, ..) => 3,
            Node::Binary(Binary::Wrap, ..) => 4,
            _ => 0,
        };
        self.code.iter().filter(counts).map(|node| 1 + more(node)).sum()
    }

    /// The elementary functions that it calls.
    pub fn functions(&self) -> BTreeSet<MathFunction> {
        let mut all = BTreeSet::new();
        for node in &self.code {
            match node {
                Node::Unary(unary, _) => all.extend(MathFunction::of(*unary)),
                Node::Binary(Binary::Power, ..) => all.extend([MathFunction::Pow]),
                Node::Binary(Binary::Atan2, ..) => all.extend([MathFunction::Atan2]),
                Node::Binary(Binary::LnPlusExp | Binary::LnExpPlus, ..) => {
                    all.extend([MathFunction::Exp, MathFunction::Log, MathFunction::Log1p]);
                }
                _ => {}
            }
        }
        all
    }

    /// The body of a function that writes the results to `out[0]`, `out[1]`, ...; it reads `t`, `x` and `u`.
    pub fn source(&self, dialect: &Dialect) -> String {
        source::body(self, dialect)
    }

    /// The body of a function of C that writes the results to `columns`, with loops over arrays and over the entries of
    /// its [named matrices](super::Recording::matrix); it reads `t`, `x` and the columns of its inputs.
    pub fn loops(&self, dialect: &Dialect, columns: Columns<'_>) -> String {
        loops::body(self, dialect, columns)
    }
}
