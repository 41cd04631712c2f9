//! The optimum of a semidefinite program is bounded, or the program has no feasible point.
//!
//! About `min c'x` subject to `x_1 F_1 + ... + x_m F_m - F_0 >= 0` (P) and its dual (D), in the sign convention of
//! SDPA: a bound of the optimum, or that (P) or (D) has no feasible point. The implications, and the bound of the
//! distance from a given Y to a feasible one, are in the head of [`semidefinite`](crate::semidefinite). The data are
//! treated as intervals there: a decimal of a file is the exact fraction, and the proof holds for it.

use super::super::Fault;
use super::super::fields::{Field, Fields, LARGEST_ORDER, MOST_ENTRIES};
use super::super::write::Out;
use super::{Fact, FileError, Statement, combination, counted, unknown_word};
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

fn write_blocks(blocks: &[DualBlock]) -> Out {
    let block = |block: &DualBlock| match block {
        DualBlock::Dense(y) => Out::Object(vec![("dense", Out::matrix(y))]),
        DualBlock::Diagonal(y) => Out::Object(vec![("diagonal", Out::numbers(y))]),
    };
    Out::Lines(blocks.iter().map(block).collect())
}

fn read_numbers(field: &Field<'_>) -> Result<Vec<f64>, FileError> {
    field.items()?.iter().map(Field::binary64).collect()
}

fn read_x(field: &Field<'_>, program: &Program) -> Result<Vec<f64>, FileError> {
    let x = read_numbers(field)?;
    if x.len() == program.unknowns() {
        return Ok(x);
    }
    Err(field.error(Fault::Length { expected: program.unknowns(), found: x.len() }))
}

fn read_blocks(field: &Field<'_>, program: &Program) -> Result<Vec<DualBlock>, FileError> {
    let items = field.items()?;
    let (expected, found) = (program.blocks().len(), items.len());
    if expected != found {
        return Err(field.error(Fault::Length { expected, found }));
    }
    let mut blocks = Vec::with_capacity(found);
    for (item, block) in items.iter().zip(program.blocks()) {
        let mut fields = item.object()?;
        blocks.push(match *block {
            Block::Dense(n) => DualBlock::Dense(fields.take("dense")?.symmetric(n)?),
            Block::Diagonal(expected) => {
                let field = fields.take("diagonal")?;
                let y = read_numbers(&field)?;
                if y.len() != expected {
                    return Err(field.error(Fault::Length { expected, found: y.len() }));
                }
                DualBlock::Diagonal(y)
            }
        });
        fields.finish()?;
    }
    Ok(blocks)
}

fn read_program(file: &mut Fields<'_>) -> Result<Program, FileError> {
    let whole = file.take("program")?;
    let mut fields = whole.object()?;
    let mut blocks: Vec<Block> = Vec::new();
    let list = fields.take("blocks")?;
    for item in list.items()? {
        let mut fields = item.object()?;
        let block = match (fields.optional("dense"), fields.optional("diagonal")) {
            (Some(order), None) => Block::Dense(order.index(LARGEST_ORDER)?),
            (None, Some(order)) => Block::Diagonal(order.index(MOST_ENTRIES)?),
            _ => return Err(item.error(Fault::Missing { name: "dense\" or \"diagonal" })),
        };
        fields.finish()?;
        blocks.push(block);
    }
    // A diagonal block of n rows has n entries: as many as a matrix of this order, rounded up.
    list.bounded_entries(blocks.iter().map(|block| match *block {
        Block::Dense(n) => n,
        Block::Diagonal(n) => n.isqrt() + 1,
    }))?;
    let costs = fields
        .take("costs")?
        .items()?
        .iter()
        .map(|item| Ok(item.datum()?.interval()))
        .collect::<Result<Vec<_>, FileError>>()?;
    let mut matrices = vec![Vec::new(); costs.len() + 1];
    for entry in fields.take("entries")?.items()? {
        let parts = entry.items()?;
        let [matrix, block, row, column, value] = parts.as_slice() else {
            return Err(entry.error(Fault::Length { expected: 5, found: parts.len() }));
        };
        let matrix = matrix.index(costs.len())?;
        let value = Entry {
            block: block.count()?,
            row: row.count()?,
            column: column.count()?,
            value: value.datum()?.interval(),
        };
        if let Some(entries) = matrices.get_mut(matrix) {
            entries.push(value);
        }
    }
    fields.finish()?;
    Program::new(blocks, costs, matrices).map_err(|error| whole.error(Fault::Program(error)))
}

impl Statement for SemidefiniteProgram {
    const NAME: &'static str = "semidefinite-program";

    fn facts(&self) -> Result<Vec<Fact>, ProofError> {
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

    fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
        let program = read_program(file)?;
        let field = file.take("claim")?;
        let evidence = match field.text()? {
            "bounds" => {
                let lower = match file.optional("lower") {
                    None => None,
                    Some(field) => {
                        let mut fields = field.object()?;
                        let bound = (fields.take("bound")?.binary64()?, read_blocks(&fields.take("Y")?, &program)?);
                        fields.finish()?;
                        Some(bound)
                    }
                };
                let upper = match file.optional("upper") {
                    None => None,
                    Some(field) => {
                        let mut fields = field.object()?;
                        let bound = (fields.take("bound")?.binary64()?, read_x(&fields.take("x")?, &program)?);
                        fields.finish()?;
                        Some(bound)
                    }
                };
                if lower.is_none() && upper.is_none() {
                    return Err(field.error(Fault::Missing { name: "lower\" or \"upper" }));
                }
                SemidefiniteEvidence::Bounds { lower, upper }
            }
            "primal infeasible" => SemidefiniteEvidence::PrimalInfeasible(read_blocks(&file.take("Y")?, &program)?),
            "dual infeasible" => SemidefiniteEvidence::DualInfeasible(read_x(&file.take("x")?, &program)?),
            other => return Err(unknown_word(&field, other, &["bounds", "primal infeasible", "dual infeasible"])),
        };
        Ok(Self { program, evidence })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        let program = &self.program;
        let block = |block: &Block| match *block {
            Block::Dense(n) => Out::Object(vec![("dense", Out::Count(n))]),
            Block::Diagonal(n) => Out::Object(vec![("diagonal", Out::Count(n))]),
        };
        let entries = (0..=program.unknowns()).flat_map(|k| {
            program.matrix(k).iter().map(move |entry| {
                let places = [k, entry.block, entry.row, entry.column].map(Out::Count);
                Out::Line(places.into_iter().chain([Out::interval(&entry.value)]).collect())
            })
        });
        let fields = vec![
            ("blocks", Out::Line(program.blocks().iter().map(block).collect())),
            ("costs", Out::Line(program.costs().iter().map(Out::interval).collect())),
            ("entries", Out::Lines(entries.collect())),
        ];
        let mut members = vec![("program", Out::Object(fields))];
        let claim = |word: &str| ("claim", Out::Text(word.to_owned()));
        match &self.evidence {
            SemidefiniteEvidence::Bounds { lower, upper } => {
                members.push(claim("bounds"));
                if let Some((bound, y)) = lower {
                    members.push(("lower", Out::Object(vec![("bound", Out::number(*bound)), ("Y", write_blocks(y))])));
                }
                if let Some((bound, x)) = upper {
                    members.push(("upper", Out::Object(vec![("bound", Out::number(*bound)), ("x", Out::numbers(x))])));
                }
            }
            SemidefiniteEvidence::PrimalInfeasible(y) => {
                members.extend([claim("primal infeasible"), ("Y", write_blocks(y))]);
            }
            SemidefiniteEvidence::DualInfeasible(x) => {
                members.extend([claim("dual infeasible"), ("x", Out::numbers(x))]);
            }
        }
        members
    }
}
