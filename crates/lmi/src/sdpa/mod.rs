//! Semidefinite programs in SDPA's form, with rigorous bounds on the optimum: solved numerically, then verified
//! independently of the solver.
//!
//! ```text
//! (P)  minimise  c'x          subject to  X = x_1 F_1 + ... + x_m F_m - F_0 >= 0
//! (D)  maximise  tr(F_0 Y)    subject to  tr(F_i Y) = c_i,  Y >= 0
//! ```
//! [`read`] reads a file, [`solve`] returns a lower and an upper bound on the optimum, or a proof that (P) or (D) is
//! infeasible. A bound is infinite if no feasible point of the corresponding program could be *proved*: a program
//! without interior points has none that a binary64 computation can prove feasible, so that rigorous bounds from points
//! do not exist.
//!
//! Method: the solver computes approximate x and Y near the optimum. Y is projected onto the equations, and a point
//! that is not quite feasible is moved towards a well-centred point as little as needed (`centre.rs`). The
//! verification, and the inequalities it uses, are in [`luenberger_proof::semidefinite`].

pub(crate) mod centre;
mod certificate_file;
mod dual;
pub(crate) mod face;
mod pose;
mod reader;
mod report;

use std::time::Duration;

use luenberger_clock::Instant;
use luenberger_proof::semidefinite::{Block, DualBlock, Program};
use luenberger_wording::setters;

use thiserror::Error;

pub use reader::{LONGEST_LINE, ReadError, read};

use crate::conic::{ConicProgram, Ending};
use crate::interior::{Iterate, Path};
use crate::solver::Solver;
use dual::{Equations, Point};

/// Verified status of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Both bounds are finite: the optimum exists and lies between them.
    Bounds,
    /// (P) has no feasible point.
    PrimalInfeasible,
    /// (D) has no feasible point.
    DualInfeasible,
    /// Neither; a finite bound is valid nevertheless.
    Undecided,
}

/// Why a program is undecided.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum NoBoundReason {
    /// The solver was not started.
    #[error("the solver would take about {:.1} GB, and {:.1} GB are allowed", expected / 1e9, *allowed as f64 / 1e9)]
    Memory {
        /// Bytes.
        expected: f64,
        /// Bytes.
        allowed: usize,
    },
    /// The solver is not compiled in.
    #[error("the solver {solver} is not part of this build")]
    NotBuiltIn {
        /// The requested solver.
        solver: Solver,
    },
    /// The time limit was reached.
    #[error("the time allowed was over")]
    Time,
    /// The lower bound is verified, the upper is not.
    #[error("no feasible point of (P) could be proved: its interior is empty or thin")]
    NoPrimalPoint,
    /// The upper bound is verified, the lower is not.
    #[error("no feasible point of (D) could be proved: its interior is empty or thin, or its equations are dependent")]
    NoDualPoint,
    /// Neither bound.
    #[error("neither a feasible point nor a ray of either program could be proved")]
    NoPoint,
}

/// Result of [`solve`].
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The verified status.
    pub status: Status,
    /// The optimum of (P), where (P) has feasible points, is at least this; minus infinity if no feasible point of (D)
    /// could be proved.
    pub lower: f64,
    /// It is at most this; infinity if no feasible point of (P) could be proved.
    pub upper: f64,
    /// A proved lower bound of the smallest eigenvalue of X at the point that gives `upper`.
    pub primal_margin: Option<f64>,
    /// The point that gives `upper`, or the ray that shows (D) infeasible; else the solver's last.
    pub x: Vec<f64>,
    /// The matrix near which a feasible point of (D) gives `lower`, or a ray of (D) shows (P) infeasible; empty where
    /// neither is proved.
    pub y: Vec<DualBlock>,
    /// The solver's own status of its first run; not used in any proof.
    pub word: &'static str,
    /// For an undecided status, the reason.
    pub why: Option<NoBoundReason>,
    /// Number of solver runs.
    pub runs: usize,
    /// Total number of iterations.
    pub iterations: u32,
    /// Time in the solver.
    pub solving: Duration,
    /// Time for projection, centring (without the solver's part) and verification.
    pub verifying: Duration,
}

/// Cost that a centre may give up for its margin, relative to `1 + |value|`, smallest first.
const ROOMS: [f64; 2] = [1e-3, 1.0];

/// The smallest fractions of the way to a centre, and to a point already verified, as powers of ten.
const NEAREST: i32 = -14;
const NEAR: i32 = -7;

/// Whether the costs of a verified point and an approximate one differ enough to search between them.
fn is_wide(proposed: f64, proved: f64) -> bool {
    (proposed - proved).abs() > 1e-8 * (1.0 + proposed.abs())
}

/// Solver and limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// The solver; its results are always verified.
    pub solver: Solver,
    /// Maximal number of iterations of the solver.
    pub iterations: u32,
    /// Memory limit in bytes; the solver is not started if its estimated memory exceeds it.
    pub memory: usize,
    /// Time limit: no solver iteration or verification starts after it; results verified before are kept. Without a
    /// limit the result does not depend on the machine.
    pub time: Option<Duration>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { solver: Solver::default(), iterations: 200, memory: 8 << 30, time: None }
    }
}

impl Settings {
    setters! { solver: Solver, iterations: u32, memory: usize, time: Duration }
}

/// Bounds the optimum of a program, or proves that it has none.
///
/// ```
/// // minimise x subject to [[x, 1], [1, x]] >= 0: the optimum is 1.
/// let program = luenberger_lmi::sdpa::read("1\n1\n2\n1.0\n0 1 1 2 -1.0\n1 1 1 1 1.0\n1 1 2 2 1.0\n".as_bytes())?;
/// let found = luenberger_lmi::sdpa::solve(&program, &Default::default());
/// assert!(found.lower <= 1.0 && 1.0 <= found.upper && found.upper - found.lower < 1e-6);
/// # Ok::<(), luenberger_lmi::sdpa::ReadError>(())
/// ```
pub fn solve(program: &Program, settings: &Settings) -> Outcome {
    let start = Instant::now();
    let end = settings.time.and_then(|time| start.checked_add(time));
    let mut run = Run { program, settings, end, solving: Duration::ZERO, runs: 0, iterations: 0 };
    let mut outcome = run.outcome();
    outcome.solving = run.solving;
    (outcome.runs, outcome.iterations) = (run.runs, run.iterations);
    outcome.verifying = start.elapsed().saturating_sub(run.solving);
    outcome
}

struct Run<'a> {
    program: &'a Program,
    settings: &'a Settings,
    end: Option<Instant>,
    solving: Duration,
    runs: usize,
    iterations: u32,
}

impl Run<'_> {
    fn is_late(&self) -> bool {
        self.end.is_some_and(|end| Instant::now() >= end)
    }

    fn propose(&mut self, program: &ConicProgram) -> Option<Path> {
        let start = Instant::now();
        if self.is_late() {
            return None;
        }
        let Settings { solver, iterations, .. } = *self.settings;
        let path = solver.propose(program, iterations, self.end).ok().flatten();
        self.solving += start.elapsed();
        self.runs += 1;
        self.iterations += path.as_ref().map_or(0, |path| path.iterations);
        path
    }

    fn outcome(&mut self) -> Outcome {
        let program = self.program;
        let mut outcome = Outcome {
            status: Status::Undecided,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            primal_margin: None,
            x: Vec::new(),
            y: Vec::new(),
            word: "not started",
            why: None,
            runs: 0,
            iterations: 0,
            solving: Duration::ZERO,
            verifying: Duration::ZERO,
        };
        let solver = self.settings.solver;
        if solver.require().is_err() {
            outcome.why = Some(NoBoundReason::NotBuiltIn { solver });
            return outcome;
        }
        let expected = expected_memory(program);
        if expected > self.settings.memory as f64 {
            outcome.why = Some(NoBoundReason::Memory { expected, allowed: self.settings.memory });
            return outcome;
        }
        let Some(path) = self.propose(&pose::primal(program)) else {
            outcome.why = Some(self.no_bound_reason(&outcome));
            outcome.word = "no proposal";
            return outcome;
        };
        outcome.word = path.status;
        outcome.x = path.last().map(|last| last.unknowns.clone()).unwrap_or_default();
        let equations = Equations::of(program);
        if path.ending != Ending::Point && self.is_infeasible(path.ending, &path, &equations, &mut outcome) {
            return outcome;
        }
        self.bound_above(&path, &mut outcome);
        if !face::confines_dual(program) {
            self.bound_below(&path, &equations, &mut outcome);
        }
        if outcome.upper.is_finite() && outcome.lower.is_finite() {
            outcome.status = Status::Bounds;
            return outcome;
        }
        // A solver that gave up near a point may have met an infeasible program all the same. A feasible point excludes
        // the one kind.
        for ending in [Ending::NoPoint, Ending::Unbounded] {
            let excluded = match ending {
                Ending::NoPoint => outcome.upper.is_finite(),
                _ => outcome.lower.is_finite(),
            };
            if !excluded && self.is_infeasible(ending, &path, &equations, &mut outcome) {
                return outcome;
            }
        }
        outcome.why = Some(self.no_bound_reason(&outcome));
        outcome
    }

    fn no_bound_reason(&self, outcome: &Outcome) -> NoBoundReason {
        match (outcome.lower.is_finite(), outcome.upper.is_finite()) {
            _ if self.is_late() => NoBoundReason::Time,
            (true, _) => NoBoundReason::NoPrimalPoint,
            (_, true) => NoBoundReason::NoDualPoint,
            _ => NoBoundReason::NoPoint,
        }
    }

    /// An upper bound from the last iterate that can be verified as feasible, or from a point between it and the final
    /// one if their costs differ much; if no iterate is feasible, from the final one, moved towards a centre.
    fn bound_above(&mut self, path: &Path, outcome: &mut Outcome) {
        let program = self.program;
        let mut accept = |x: &[f64]| {
            program.upper_bound(x).is_some_and(|bound| {
                if bound.value < outcome.upper {
                    (outcome.upper, outcome.primal_margin) = (bound.value, Some(bound.margin));
                    outcome.x = x.to_vec();
                }
                true
            })
        };
        let Some(x) = path.last().map(|last| &last.unknowns) else { return };
        let drawn =
            |end: &[f64], share: f64| -> Vec<f64> { x.iter().zip(end).map(|(x, end)| x + share * (end - x)).collect() };
        if let Some(k) = centre::last(path.iterates.len(), |k| accept(&path.iterates[k].unknowns)) {
            let end = &path.iterates[k].unknowns;
            if is_wide(pose::value(program, x), pose::value(program, end)) && !self.is_late() {
                centre::draw(NEAR, |share| accept(&drawn(end, share)));
            }
            return;
        }
        for room in ROOMS {
            let Some(centred) = self.propose(&pose::primal_centre(program, x, room)) else { continue };
            let Some(centre) = centred.last().map(|last| &last.unknowns[..program.unknowns()]) else { continue };
            // Where the centre itself is not proved, nothing on the way to it is.
            if accept(centre) {
                centre::draw(NEAREST, |share| accept(&drawn(centre, share)));
                return;
            }
        }
    }

    /// A lower bound from Y, likewise.
    fn bound_below(&mut self, path: &Path, equations: &Equations, outcome: &mut Outcome) {
        let program = self.program;
        let mut proved: Option<Point> = None;
        let mut accept = |y: Point| {
            let y = equations.move_onto(program, y, true);
            let blocks = y.clone().into_blocks(program);
            let Some(bound) = program.lower_bound(&blocks) else { return false };
            if bound.value > outcome.lower {
                (outcome.lower, outcome.y) = (bound.value, blocks);
                proved = Some(y);
            }
            true
        };
        let point = |iterate: &Iterate| dual::blocks(program, &path.on_equations(iterate, false));
        let end = self.end;
        let is_late = || end.is_some_and(|end| Instant::now() >= end);
        // The plain projection is cheap and leaves the cone now and then; the other stays in it.
        let is_found = centre::last(path.iterates.len(), |k| {
            let iterate = &path.iterates[k];
            accept(dual::blocks(program, &iterate.multipliers)) || (!is_late() && accept(point(iterate)))
        })
        .is_some();
        let Some(last) = path.last().filter(|_| !is_late()) else { return };
        if is_found {
            let y = dual::blocks(program, &last.multipliers);
            if let Some(end) = proved.filter(|end| is_wide(y.value(program), end.value(program))) {
                centre::draw(NEAR, |share| {
                    let blocks = equations.move_onto(program, y.towards(&end, share), true).into_blocks(program);
                    program.lower_bound(&blocks).is_some_and(|bound| {
                        if bound.value > outcome.lower {
                            (outcome.lower, outcome.y) = (bound.value, blocks);
                        }
                        true
                    })
                });
            }
            return;
        }
        let y = point(last);
        for room in ROOMS {
            let posed = pose::dual_centre(program, y.value(program), y.size(), room);
            let Some(centred) = self.propose(&posed.program) else { continue };
            // The last of these iterates has the most margin, and satisfies its equations the least.
            let is_found = centre::last(centred.iterates.len(), |k| {
                let centre = posed.centre(program, &centred.on_equations(&centred.iterates[k], false));
                let centre = equations.move_onto(program, centre, true);
                // Where the centre itself is not proved, nothing on the way to it is.
                let is_proved = !is_late() && accept(centre.clone());
                if is_proved {
                    centre::draw(NEAREST, |share| accept(y.towards(&centre, share)));
                }
                is_proved
            });
            if is_found.is_some() || is_late() {
                return;
            }
        }
    }

    /// Whether the program is verified as infeasible in the way given by `ending`.
    fn is_infeasible(&mut self, ending: Ending, path: &Path, equations: &Equations, outcome: &mut Outcome) -> bool {
        let is_primal = ending == Ending::NoPoint;
        if is_primal && let Some(ray) = self.primal_infeasible(path, equations) {
            (outcome.status, outcome.y) = (Status::PrimalInfeasible, ray);
            (outcome.lower, outcome.upper) = (f64::INFINITY, f64::INFINITY);
            return true;
        }
        if !is_primal && let Some(ray) = self.dual_infeasible(path) {
            (outcome.status, outcome.x) = (Status::DualInfeasible, ray);
            outcome.lower = f64::NEG_INFINITY;
            return true;
        }
        false
    }

    /// A ray of (D), from the solver's multipliers or a centred one.
    fn primal_infeasible(&mut self, path: &Path, equations: &Equations) -> Option<Vec<DualBlock>> {
        let program = self.program;
        let mut found = None;
        let mut is_ray = |y: Point| {
            let y = equations.move_onto(program, y, false).into_blocks(program);
            let is_ray = program.is_primal_infeasible(&y).is_some();
            if is_ray {
                found = Some(y);
            }
            is_ray
        };
        let iterates = &path.iterates;
        let is_found = centre::last(iterates.len(), |k| {
            is_ray(dual::blocks(program, &iterates[k].multipliers))
                || is_ray(dual::blocks(program, &path.on_equations(&iterates[k], true)))
        });
        if is_found.is_none() {
            let posed = pose::dual_ray(program);
            let ray = self.propose(&posed.program)?;
            let centre = |k: usize| posed.centre(program, &ray.on_equations(&ray.iterates[k], false));
            centre::last(ray.iterates.len(), |k| is_ray(centre(k)))?;
        }
        found
    }

    /// A ray of (P), likewise.
    fn dual_infeasible(&mut self, path: &Path) -> Option<Vec<f64>> {
        let program = self.program;
        let found = |path: &Path| {
            let x = |k: usize| &path.iterates[k].unknowns[..program.unknowns()];
            let last = centre::last(path.iterates.len(), |k| program.is_dual_infeasible(x(k)).is_some())?;
            Some(x(last).to_vec())
        };
        found(path).or_else(|| found(&self.propose(&pose::primal_ray(program))?))
    }
}

/// Bytes the solver needs: the Schur complement with its factor, and a dozen matrices for each block.
fn expected_memory(program: &Program) -> f64 {
    let squares: f64 = program
        .blocks()
        .iter()
        .map(|block| match *block {
            Block::Dense(n) => (n as f64).powi(2),
            Block::Diagonal(n) => n as f64,
        })
        .sum();
    // The prover's Gram matrix has intervals for entries.
    8.0 * (30.0 * squares + 6.0 * (program.unknowns() as f64).powi(2))
}
