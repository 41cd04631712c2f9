//! The optimum of a semidefinite program is bounded, or the program has no feasible point.
//!
//! About `min c'x` subject to `x_1 F_1 + ... + x_m F_m - F_0 >= 0` (P) and its dual (D), in the sign convention of
//! SDPA: a bound of the optimum, or that (P) or (D) has no feasible point. The implications, and the bound of the
//! distance from a given Y to a feasible one, are in the head of [`semidefinite`](crate::semidefinite). The data are
//! treated as intervals there: a decimal of a file is the exact fraction, and the proof holds for it.

use super::super::Fault;
use super::super::fields::{Field, Fields, LARGEST_ORDER, MOST_ENTRIES};
use super::super::members::Members;
use super::super::write::{Out, Written};
use super::{Fact, FileError, Names, Statement, combination, counted};
use crate::error::ProofError;
use crate::number::Number;
use crate::semidefinite::{Block, DualBlock, Entry, Program};
use crate::verdict::{UndecidedReason, Verdict};
use crate::wording::exact;

/// What is claimed of the program, and the point that shows it.
#[derive(Debug, Clone, PartialEq)]
pub enum SemidefiniteEvidence {
    /// The optimum lies between two numbers: x is feasible for (P) and `c'x` at most `upper`, and near Y is a feasible
    /// point of (D) of value at least `lower`.
    Bounds {
        /// The lower bound and Y, if there are.
        lower: Option<(f64, Vec<DualBlock>)>,
        /// The upper bound and x, if there are.
        upper: Option<(f64, Vec<f64>)>,
    },
    /// (P) has no feasible point: near Y is a ray of (D).
    PrimalInfeasible(Vec<DualBlock>),
    /// (D) has no feasible point: x is a ray of (P).
    DualInfeasible(Vec<f64>),
}

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct SemidefiniteProgram {
    /// The program.
    pub program: Program,
    /// What is claimed.
    pub evidence: SemidefiniteEvidence,
}

impl Statement for SemidefiniteProgram {
    const NAME: &'static str = "semidefinite-program";

    fn facts(&self, _: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        let fact = |inequality: String, margin: Option<f64>| {
            let undecided =
                Verdict::Undecided { why: UndecidedReason::NotByThisMatrix { name: "point" }, best: f64::NAN };
            Fact::stated(inequality, margin.map_or(undecided, |margin| Verdict::Proved { margin }))
        };
        let shown = |x: f64| Number::from_f64(x).map_or_else(|| x.to_string(), |x| x.to_string());
        let (program, mut facts) = (&self.program, Vec::new());
        match &self.evidence {
            SemidefiniteEvidence::Bounds { lower, upper } => {
                if let Some((claimed, y)) = lower {
                    program.within_limits()?;
                    let holds = program.lower_bound(y).is_some_and(|bound| bound.value >= *claimed);
                    facts.push(fact(format!("the optimum >= {} by Y", shown(*claimed)), holds.then_some(0.0)));
                }
                if let Some((claimed, x)) = upper {
                    let bound = program.upper_bound(x).filter(|bound| bound.value <= *claimed);
                    facts.push(fact(
                        format!("X(x) >= 0 and c'x <= {}", shown(*claimed)),
                        bound.map(|bound| bound.margin),
                    ));
                }
            }
            SemidefiniteEvidence::PrimalInfeasible(y) => {
                program.within_limits()?;
                let ray = program.is_primal_infeasible(y);
                let inequality = "tr(F_i Y) = 0, tr(F_0 Y) > 0, Y >= 0 near Y";
                facts.push(fact(inequality.to_owned(), ray.map(|ray| ray.value)));
            }
            SemidefiniteEvidence::DualInfeasible(x) => {
                let ray = program.is_dual_infeasible(x);
                facts.push(fact("x_1 F_1 + ... + x_m F_m >= 0 and c'x < 0".to_owned(), ray.map(|ray| -ray.value)));
            }
        }
        Ok(facts)
    }

    fn words(&self) -> String {
        let sum = combination("F_", self.program.unknowns());
        let blocks = counted(self.program.blocks().len(), "block");
        let program = format!("the semidefinite program (P) min c'x subject to {sum} - F_0 >= 0 with {blocks}");
        match &self.evidence {
            SemidefiniteEvidence::Bounds { lower, upper } => {
                let bounds: Vec<String> = [
                    lower
                        .as_ref()
                        .map(|(bound, _)| format!("every feasible point of (P) has c'x >= {}", exact(*bound))),
                    upper.as_ref().map(|(bound, _)| format!("(P) has a feasible point with c'x <= {}", exact(*bound))),
                ]
                .into_iter()
                .flatten()
                .collect();
                format!("For {program}: {}.", bounds.join(", and "))
            }
            SemidefiniteEvidence::PrimalInfeasible(_) => format!("For {program}: (P) has no feasible point."),
            SemidefiniteEvidence::DualInfeasible(_) => format!(
                "For {program} and its dual (D) max tr(F_0 Y) subject to tr(F_i Y) = c_i, Y >= 0: (D) has no feasible point."
            ),
        }
    }
}

/// The members of the evidence depend on the claim.
impl Members for SemidefiniteProgram {
    fn read(file: &mut Fields<'_>, (): ()) -> Result<Self, FileError> {
        let program = file.take("program")?.by(read_program)?;
        let x = |fields: &mut Fields<'_>| fields.take("x")?.numbers(program.unknowns());
        let y = |fields: &mut Fields<'_>| read_blocks(&fields.take("Y")?, &program);
        let claim = file.take("claim")?;
        let evidence = match claim.text()? {
            "bounds" => {
                let bound = |fields: &mut Fields<'_>| fields.take("bound")?.binary64();
                let lower =
                    file.optional("lower").map(|lower| lower.object(|of| Ok((bound(of)?, y(of)?)))).transpose()?;
                let upper =
                    file.optional("upper").map(|upper| upper.object(|of| Ok((bound(of)?, x(of)?)))).transpose()?;
                if lower.is_none() && upper.is_none() {
                    return Err(claim.error(Fault::Missing { name: "lower\" or \"upper" }));
                }
                SemidefiniteEvidence::Bounds { lower, upper }
            }
            "primal infeasible" => SemidefiniteEvidence::PrimalInfeasible(y(file)?),
            "dual infeasible" => SemidefiniteEvidence::DualInfeasible(x(file)?),
            other => return Err(claim.unknown_word(other, ["bounds", "primal infeasible", "dual infeasible"])),
        };
        Ok(Self { program, evidence })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        let mut members = vec![("program", self.program.out())];
        let claim = |word: &str| ("claim", word.out());
        match &self.evidence {
            SemidefiniteEvidence::Bounds { lower, upper } => {
                members.push(claim("bounds"));
                members.extend(
                    lower.iter().map(|(bound, y)| ("lower", Out::Object(vec![("bound", bound.out()), ("Y", y.out())]))),
                );
                members.extend(
                    upper.iter().map(|(bound, x)| ("upper", Out::Object(vec![("bound", bound.out()), ("x", x.out())]))),
                );
            }
            SemidefiniteEvidence::PrimalInfeasible(y) => {
                members.push(claim("primal infeasible"));
                members.push(("Y", y.out()));
            }
            SemidefiniteEvidence::DualInfeasible(x) => {
                members.push(claim("dual infeasible"));
                members.push(("x", x.out()));
            }
        }
        members
    }
}

fn read_program(whole: &Field<'_>) -> Result<Program, FileError> {
    let (blocks, costs, matrices) = whole.object(|program| {
        let list = program.take("blocks")?;
        let blocks = list.list_of(|item| {
            item.object(|block| match (block.optional("dense"), block.optional("diagonal")) {
                (Some(order), None) => Ok(Block::Dense(order.index(LARGEST_ORDER)?)),
                (None, Some(order)) => Ok(Block::Diagonal(order.index(MOST_ENTRIES)?)),
                _ => Err(item.error(Fault::Missing { name: "dense\" or \"diagonal" })),
            })
        })?;
        // A diagonal block of n rows has n entries: as many as a matrix of this order, rounded up.
        list.bounded_entries(blocks.iter().map(|block| match *block {
            Block::Dense(n) => n,
            Block::Diagonal(n) => n.isqrt() + 1,
        }))?;
        let costs = program.take("costs")?.list_of(|cost| Ok(cost.datum()?.interval()))?;
        let mut matrices = vec![Vec::new(); costs.len() + 1];
        for entry in program.take("entries")?.items()? {
            let parts = entry.items()?;
            let [matrix, block, row, column, value] = parts.as_slice() else {
                return Err(entry.error(Fault::Length { expected: 5, found: parts.len() }));
            };
            let matrix = matrix.index(costs.len())?;
            let (block, row, column) = (block.count()?, row.count()?, column.count()?);
            let value = Entry { block, row, column, value: value.datum()?.interval() };
            if let Some(entries) = matrices.get_mut(matrix) {
                entries.push(value);
            }
        }
        Ok((blocks, costs, matrices))
    })?;
    Program::new(blocks, costs, matrices).map_err(|error| whole.error(Fault::Program(error)))
}

impl Written for Program {
    fn out(&self) -> Out {
        let block = |block: &Block| match block {
            Block::Dense(n) => Out::Object(vec![("dense", n.out())]),
            Block::Diagonal(n) => Out::Object(vec![("diagonal", n.out())]),
        };
        let entries = (0..=self.unknowns()).flat_map(|k| {
            self.matrix(k).iter().map(move |entry| {
                let places = [k, entry.block, entry.row, entry.column].map(Out::Count);
                Out::Line(places.into_iter().chain([entry.value.out()]).collect())
            })
        });
        Out::Object(vec![
            ("blocks", Out::Line(self.blocks().iter().map(block).collect())),
            ("costs", self.costs().out()),
            ("entries", Out::Lines(entries.collect())),
        ])
    }
}

fn read_blocks(field: &Field<'_>, program: &Program) -> Result<Vec<DualBlock>, FileError> {
    let items = field.list(program.blocks().len(), |item| Ok(item.clone()))?;
    let block = |(item, block): (&Field<'_>, &Block)| {
        item.object(|of| match *block {
            Block::Dense(n) => Ok(DualBlock::Dense(of.take("dense")?.symmetric(n)?)),
            Block::Diagonal(n) => Ok(DualBlock::Diagonal(of.take("diagonal")?.numbers(n)?)),
        })
    };
    items.iter().zip(program.blocks()).map(block).collect()
}

impl Written for DualBlock {
    fn out(&self) -> Out {
        match self {
            Self::Dense(y) => Out::Object(vec![("dense", y.out())]),
            Self::Diagonal(y) => Out::Object(vec![("diagonal", y.out())]),
        }
    }
}
