//! A problem: unknowns, strict inequalities, and optionally an objective.
//!
//! Find x such that every symmetric `F_k(x) = F_k0 + x_1 F_k1 + ... + x_N F_kN` is positive definite with the largest
//! margin, or minimise a linear objective under these inequalities.

use luenberger_clock::Instant;
use luenberger_wording::setters;

use crate::expression::Expression;
use crate::inequality::Inequality;
use crate::solver::Solver;
use crate::variable::{Structure, Variable};

/// A system of linear matrix inequalities.
///
/// ```
/// use luenberger_lmi::{Problem, he};
/// use nalgebra::dmatrix;
///
/// // Is A Hurwitz? Find P > 0 with A'P + PA < 0.
/// let a = dmatrix![0.0, 1.0; -2.0, -3.0];
/// let mut lmi = Problem::new();
/// let p = lmi.symmetric("P", 2);
/// lmi.constrain("P > 0", &p >> 0.0);
/// lmi.constrain("decrease", he(&p * &a) << 0.0);
/// let solution = lmi.solve()?;
/// assert!(solution.verdict.is_proved());
/// let p = solution.value(&p);
/// let slope = a.transpose() * &p + &p * &a;
/// println!("P = {p}A'P + PA = {slope}proved below by {:e}", -solution.margin("decrease").unwrap());
/// # assert!(slope.symmetric_eigenvalues().max() <= -solution.margin("decrease").unwrap() * 0.99);
/// # Ok::<(), luenberger_lmi::LmiError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Problem {
    pub(crate) variables: Vec<Variable>,
    pub(crate) constraints: Vec<(String, Inequality)>,
    pub(crate) objective: Option<Objective>,
}

/// A scalar expression and whether it is minimised or maximised.
#[derive(Debug, Clone)]
pub(crate) struct Objective {
    pub(crate) expression: Expression,
    pub(crate) maximise: bool,
}

/// Solver and limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The solver; its results are always verified.
    pub solver: Solver,
    /// Maximal number of interior-point iterations.
    pub iterations: u32,
    /// How close to the optimum the objective is taken before the point is moved inside the constraints, relative to
    /// the distance between the optimum and the best-centred point.
    pub closeness: f64,
    /// The largest number of exact equations solved to correct a witness of infeasibility; the cost grows with its
    /// cube.
    pub referee: usize,
    /// Time limit: no iteration of the solver and no search for a witness starts after this instant, and what is not
    /// decided then is `Undecided`. Without a limit (the default) the result does not depend on the machine.
    pub end: Option<Instant>,
}

impl Settings {
    /// Whether the time limit has passed.
    pub(crate) fn is_over(&self) -> bool {
        self.end.is_some_and(|end| Instant::now() >= end)
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self { solver: Solver::default(), iterations: 100, closeness: 1e-6, referee: 400, end: None }
    }
}

impl Settings {
    setters! { solver: Solver, iterations: u32, closeness: f64, referee: usize, end: Instant }
}

impl Problem {
    /// A problem without unknowns.
    pub fn new() -> Self {
        Self::default()
    }

    /// A symmetric unknown of order `n`.
    pub fn symmetric(&mut self, name: &str, n: usize) -> Variable {
        self.declare(name, Structure::Symmetric, n, n)
    }

    /// An unknown without structure.
    pub fn rectangular(&mut self, name: &str, rows: usize, columns: usize) -> Variable {
        self.declare(name, Structure::Rectangular, rows, columns)
    }

    /// A diagonal unknown of order `n`.
    pub fn diagonal(&mut self, name: &str, n: usize) -> Variable {
        self.declare(name, Structure::Diagonal, n, n)
    }

    /// A scalar unknown.
    pub fn scalar(&mut self, name: &str) -> Variable {
        self.declare(name, Structure::Scalar, 1, 1)
    }

    fn declare(&mut self, name: &str, structure: Structure, rows: usize, columns: usize) -> Variable {
        let variable = Variable::new(name, structure, rows, columns, self.variables.len());
        self.variables.push(variable.clone());
        variable
    }

    /// Adds a strict inequality, under a name used in errors, margins and witnesses.
    pub fn constrain(&mut self, name: &str, inequality: Inequality) {
        self.constraints.push((name.to_owned(), inequality));
    }

    /// Minimises a scalar expression under the inequalities. Replaces any earlier objective.
    pub fn minimise(&mut self, expression: impl Into<Expression>) {
        self.objective = Some(Objective { expression: expression.into(), maximise: false });
    }

    /// Maximises a scalar expression under the inequalities. Replaces any earlier objective.
    pub fn maximise(&mut self, expression: impl Into<Expression>) {
        self.objective = Some(Objective { expression: expression.into(), maximise: true });
    }
}
