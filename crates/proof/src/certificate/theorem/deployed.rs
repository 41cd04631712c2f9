//! The observer as implemented on a target: its matrices in f32, f64 or fixed point, and the rounding of every step.
//!
//! **Hypotheses.** The stored numbers are the plant's numbers rounded to nearest, F rounded once from the exact `A -
//! LC`; `P > 0`; `F'PF - P < 0` for the stored F; for the cubic observer also `(wA + ANC)'P(wA + ANC) - w^2 P < 0`;
//! and, where a ball is claimed, bounds of the running error that are not below the derived ones.
//!
//! **Theorem.** With the stored numbers in exact arithmetic the error tends to 0 exponentially, from every e(0). Where
//! a ball is claimed, the running error stays in it for all initial errors in the assumed set, with the rounding of
//! every step included, and no intermediate result overflows the format.
//!
//! **Proof.** In the head of `statement/deployed`. The gains L, N, theta, w and h are those of the file. N must satisfy
//! only the two Stein inequalities, and theta is arbitrary: the observer computes `max(z'theta z, 0)`, as the statement
//! says, so that theta need not be semidefinite. The ball is derived from the assumed bounds, for the operations listed
//! in the statement; a claimed bound that is smaller by one unit in the last place is rejected.

use super::super::Fault;
use super::super::Witness;
use super::super::fields::{Field, Fields};
use super::super::write::Out;
use super::{Fact, FileError, Statement, counted, unknown_word};
use crate::definite::Direction;
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::statement::{
    CubicGains, Deployed, Deviation, ErrorBall, Format, Formats, Operation, Running, SampledPlant, Step, Stored,
    deployed_linear, deployed_sampled_cubic,
};
use crate::verdict::{UndecidedReason, Verdict};

/// The largest order of a plant in such a file: the powers of the error map are summed with outward rounding, which
/// takes seconds here.
pub const LARGEST_DEPLOYED: usize = 32;

/// The words where no ball is claimed.
const NOTHING_RUNNING: &str = "Nothing is said of the rounding of its steps.";

/// The words for the ways in which a step is computed.
const STEPS: [&str; 4] = ["joined", "innovation", "accumulated", "cubic"];

/// The bounds of the running error that a file claims.
#[derive(Debug, Clone, PartialEq)]
pub struct ClaimedBall {
    /// From the assumed initial errors, `sqrt(e'Pe)` never exceeds this.
    pub start: f64,
    /// `limsup |e_i|` is at most this, entry by entry.
    pub entries: Vec<f64>,
}

impl From<&ErrorBall> for ClaimedBall {
    fn from(ball: &ErrorBall) -> Self {
        Self { start: ball.start, entries: ball.entries.clone() }
    }
}

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct DeployedObserver {
    /// The real plant.
    pub plant: SampledPlant,
    /// What the target stores. With the cubic part, the step is that of the cubic observer.
    pub stored: Stored,
    /// How a linear observer computes its step; [`Step::Innovation`] where there is a cubic part.
    pub step: Step,
    /// The formats of stored numbers and of arithmetic.
    pub formats: Formats,
    /// Assumed bounds of inputs, states, noise and initial error during operation.
    pub operation: Operation,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// The claim about the running observer; without it the file is about the stored numbers in exact arithmetic.
    pub ball: Option<ClaimedBall>,
}

fn read_format(field: &Field<'_>) -> Result<Format, FileError> {
    let word = field.text()?;
    let fixed = |word: &str| -> Option<Format> {
        let (integer, fraction) = word.strip_prefix('Q')?.split_once('.')?;
        let bits = |text: &str| {
            let digits = !text.is_empty() && text.len() <= 2 && text.bytes().all(|b| b.is_ascii_digit());
            digits.then(|| text.parse::<u32>().ok()).flatten()
        };
        Some(Format::Fixed { integer_bits: bits(integer)?, fraction_bits: bits(fraction)? })
    };
    match word {
        "binary32" => Ok(Format::Binary32),
        "binary64" => Ok(Format::Binary64),
        _ => fixed(word).ok_or_else(|| {
            unknown_word(
                field,
                word,
                &["binary32", "binary64", "Q4.12 (4 bits before the point, the sign among them, 12 after it)"],
            )
        }),
    }
}

/// A list of bounds, of which none is negative.
fn read_bounds(field: &Field<'_>, length: usize) -> Result<Vec<f64>, FileError> {
    let items = field.items()?;
    if items.len() != length {
        return Err(field.error(Fault::Length { expected: length, found: items.len() }));
    }
    items.iter().map(read_bound).collect()
}

fn read_bound(field: &Field<'_>) -> Result<f64, FileError> {
    let value = field.binary64()?;
    if value >= 0.0 {
        return Ok(value);
    }
    Err(field.error(Fault::Range { value, requirement: "a bound of an absolute value is 0 or more" }))
}

/// A matrix of bounds, of which none is negative.
fn read_bound_matrix(field: &Field<'_>, shape: (usize, usize)) -> Result<Matrix<f64>, FileError> {
    let matrix = field.matrix(shape)?;
    match matrix.as_slice().iter().find(|x| **x < 0.0) {
        None => Ok(matrix),
        Some(&value) => {
            Err(field.error(Fault::Range { value, requirement: "a bound of an absolute value is 0 or more" }))
        }
    }
}

fn read_positive(field: &Field<'_>, requirement: &'static str) -> Result<f64, FileError> {
    let value = field.binary64()?;
    if value > 0.0 { Ok(value) } else { Err(field.error(Fault::Range { value, requirement })) }
}

/// The plant, as `plant.rs` reads it, but not larger than is checked in seconds.
fn read_plant(file: &mut Fields<'_>) -> Result<SampledPlant, FileError> {
    let mut fields = file.object("plant")?;
    let field = fields.take("A")?;
    let a = field.square()?;
    if a.rows() > LARGEST_DEPLOYED {
        return Err(field.error(Fault::TooManyRows { order: a.rows(), allowed: LARGEST_DEPLOYED }));
    }
    let field = fields.take("B")?;
    let b = field.matrix_with_rows(a.rows())?;
    let c_field = fields.take("C")?;
    let c = c_field.matrix_with_columns(a.rows())?;
    for (field, width) in [(field, b.cols()), (c_field, c.rows())] {
        if width > LARGEST_DEPLOYED {
            return Err(field.error(Fault::TooManyRows { order: width, allowed: LARGEST_DEPLOYED }));
        }
    }
    fields.finish()?;
    Ok(SampledPlant { a, b, c })
}

impl DeployedObserver {
    fn step_word(&self) -> &'static str {
        match (&self.stored.cubic, self.step) {
            (Some(_), _) => "cubic",
            (None, Step::Joined) => "joined",
            (None, Step::Innovation) => "innovation",
            (None, Step::Accumulated) => "accumulated",
        }
    }

    /// What is proved of the stored gains: rounding numbers of the format leaves them as they are.
    fn derived(&self) -> Result<Deployed, ProofError> {
        let Self { plant, stored, step, formats, operation, p, .. } = self;
        match &stored.cubic {
            Some(cubic) => deployed_sampled_cubic(plant, &stored.l, cubic, p, *formats, operation),
            None => deployed_linear(plant, &stored.l, p, *step, *formats, operation),
        }
    }

    /// The claim about the running observer.
    fn running_words(&self) -> String {
        let Formats { stored, running } = self.formats;
        // 1/epsilon, beyond which the code takes 1 + c^2 for c^2.
        let large = match running {
            Format::Binary64 => "2^52",
            _ => "2^23",
        };
        let flow = if self.stored.cubic.is_some() {
            format!(
                " with i = (((k p)p')s)d and j = p d, s = max |z_k|, d = z/s, q = max(d'theta d, 0), k = (2q)h, b = sqrt(w k), c = b s, a = sqrt(1 + c c), p = s/a, p' = s/(1 + a), but p = p' = 1/b where c is larger than {large}, and i = j = z where s = 0,"
            )
        } else {
            String::new()
        };
        let rounded = match running {
            _ if self.step == Step::Accumulated => {
                "each sum of products computed without rounding, then rounded to nearest"
            }
            Format::Fixed { .. } => "each product rounded to nearest or each sum of products as a whole",
            _ => "each operation rounded to nearest, with or without fused multiply-adds",
        };
        let plant = if self.operation.deviation.is_some() {
            "on every plant x+ = (A + dA)x + (B + dB)u whose |dA| and |dB| are at most operation.dA and operation.dB, entry by entry and perhaps differently in every step,"
        } else {
            "on the real plant"
        };
        let operands = if stored == running { "" } else { "the stored numbers entering as they are, " };
        format!(
            "As it runs in {running},{flow} {rounded}, {operands}sums in any order, y rounded to nearest, u and xhat(0) being numbers of {running}, {plant} and while |x|, |u|, |v| and |e(0)| keep the bounds of operation: the error e never makes sqrt(e'Pe) larger than running.start, limsup |e_i| is at most running.limsup[i] (counted from 0), and no result of any of these operations leaves the range of {running}."
        )
    }

    /// The stored matrices by their names, in the order of the file.
    fn matrices<'a>(&self, stored: &'a Stored) -> Vec<(&'static str, &'a Matrix<f64>)> {
        let mut matrices = match (&stored.cubic, self.step) {
            (None, Step::Joined) => vec![("F", &stored.a), ("B", &stored.b)],
            _ => vec![("A", &stored.a), ("B", &stored.b), ("C", &stored.c)],
        };
        matrices.push(("L", &stored.l));
        if let Some(cubic) = &stored.cubic {
            matrices.extend([("N", &cubic.n), ("theta", &cubic.theta)]);
        }
        matrices
    }

    /// The first stored number that is not the one derived.
    fn mismatch(&self, derived: &Stored) -> Option<Witness> {
        let (own, derived_matrices) = (self.matrices(&self.stored), self.matrices(derived));
        for ((matrix, own), (_, derived)) in own.into_iter().zip(derived_matrices) {
            if let Some(k) = own.as_slice().iter().zip(derived.as_slice()).position(|(x, y)| x != y) {
                let (row, column) = (k / own.cols(), k % own.cols());
                let (stored, nearest) = (own[(row, column)], derived[(row, column)]);
                return Some(Witness::Stored { matrix, row, column, stored, nearest });
            }
        }
        let (own, derived) = (self.stored.cubic.as_ref()?, derived.cubic.as_ref()?);
        [("w", own.w, derived.w), ("period", own.h, derived.h)]
            .into_iter()
            .find(|(_, stored, nearest)| stored != nearest)
            .map(|(matrix, stored, nearest)| Witness::Stored { matrix, row: 0, column: 0, stored, nearest })
    }
}

/// The claims about the running observer, against what is proved of it.
fn running_facts(claimed: &ClaimedBall, running: &Running) -> Vec<Fact> {
    let compared = |inequality: String, row: usize, claimed: f64, proved: &dyn Fn(&ErrorBall) -> Option<f64>| {
        let undecided = |why: UndecidedReason, best: f64| Verdict::Undecided { why, best };
        let verdict = match running {
            Running::Within(ball) => match proved(ball) {
                Some(proved) if proved <= claimed => Verdict::Proved { margin: 0.0 },
                found => {
                    let proved = found.unwrap_or(f64::INFINITY);
                    undecided(UndecidedReason::TighterThanProved { row, column: 0, claimed, proved }, claimed - proved)
                }
            },
            Running::Unproved(reason) => undecided(UndecidedReason::NoErrorBall { reason: reason.clone() }, f64::NAN),
        };
        Fact::stated(inequality, verdict)
    };
    let mut facts = vec![compared("sqrt(e'Pe) <= running.start at all times".to_owned(), 0, claimed.start, &|ball| {
        Some(ball.start)
    })];
    facts.extend(claimed.entries.iter().enumerate().map(|(i, &bound)| {
        let name = format!("limsup |e_{}| <= running.limsup[{i}]", i + 1);
        compared(name, i, bound, &|ball| ball.entries.get(i).copied())
    }));
    facts
}

impl Statement for DeployedObserver {
    const NAME: &'static str = "deployed-observer";

    fn facts(&self) -> Result<Vec<Fact>, ProofError> {
        let derived = self.derived()?;
        let nearest: Verdict<Witness> = match self.mismatch(&derived.stored) {
            None => Verdict::Proved { margin: 0.0 },
            Some(witness) => Verdict::Refuted { witness },
        };
        let decrease = match (&self.stored.cubic, self.step) {
            (None, Step::Joined) => "F'PF - P < 0 for the stored F",
            _ => "(A - LC)'P(A - LC) - P < 0 for the stored A, L and C",
        };
        let mut facts = vec![
            Fact::stated(
                format!("the stored numbers are those of {} nearest to the plant's", self.formats.stored),
                nearest,
            ),
            Fact::new("P > 0", derived.positive),
            Fact::new(decrease, derived.decrease),
        ];
        let saturated: Option<Verdict<Direction>> = derived.saturated;
        facts.extend(
            saturated.map(|verdict| Fact::new("(wA + ANC)'P(wA + ANC) - w^2 P < 0 for the stored numbers", verdict)),
        );
        if let Some(claimed) = &self.ball {
            facts.extend(running_facts(claimed, &derived.running));
        }
        Ok(facts)
    }

    fn words(&self) -> String {
        let (n, m, p) = (self.plant.a.rows(), self.plant.b.cols(), self.plant.c.rows());
        let stored = self.formats.stored;
        let (observer, error) = match (&self.stored.cubic, self.step) {
            (Some(_), _) => (
                "the sampled cubic observer xhat+ = A(xhat - N i) + Bu + L j, i = z(1 - r)/w, j = r z, z = y - C xhat, r = 1/sqrt(1 + 2 w h max(z'theta z, 0)), h the period",
                "a plant of the stored A, B and C with v = 0 has e+ = M e with M = A - LC + g (AN + wL)C for some g, 0 <= g < 1/w, that depends on e",
            ),
            (None, Step::Joined) => (
                "the observer xhat+ = F xhat + Bu + Ly, F being the exact A - LC of the plant's A and C and the stored L, rounded once",
                "a plant with the stored B, with F + LC in the place of A and with v = 0 has e+ = F e",
            ),
            (None, Step::Innovation | Step::Accumulated) => (
                "the observer xhat+ = A xhat + Bu + L z, z = y - C xhat",
                "a plant of the stored A, B and C with v = 0 has e+ = (A - LC)e",
            ),
        };
        let claim = if self.ball.is_some() { self.running_words() } else { NOTHING_RUNNING.to_owned() };
        format!(
            "For the sampled plant x+ = Ax + Bu, y = Cx + v with {}, {} and {}, and {observer}, with all its matrices stored in {stored}, to nearest, ties to even: with the numbers exactly as stored and in exact arithmetic, for the error e = x - xhat, {error}, V = e'Pe falls at each step at least by a factor below 1 that is the same for all e, and e tends to 0 exponentially, from every e(0). {claim}",
            counted(n, "state"),
            counted(m, "input"),
            counted(p, "output"),
        )
    }

    fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
        let plant = read_plant(file)?;
        let (order, inputs, outputs) = (plant.a.rows(), plant.b.cols(), plant.c.rows());
        let mut fields = file.object("formats")?;
        let formats =
            Formats { stored: read_format(&fields.take("stored")?)?, running: read_format(&fields.take("running")?)? };
        fields.finish()?;
        let field = file.take("step")?;
        let (step, is_cubic) = match field.text()? {
            "joined" => (Step::Joined, false),
            "innovation" => (Step::Innovation, false),
            "accumulated" => (Step::Accumulated, false),
            "cubic" => (Step::Innovation, true),
            other => return Err(unknown_word(&field, other, &STEPS)),
        };
        let mut fields = file.object("stored")?;
        let a = fields.take(if step == Step::Joined { "F" } else { "A" })?.matrix((order, order))?;
        let b = fields.take("B")?.matrix((order, inputs))?;
        let c = match step {
            Step::Joined => plant.c.clone(),
            Step::Innovation | Step::Accumulated => fields.take("C")?.matrix((outputs, order))?,
        };
        let l = fields.take("L")?.matrix((order, outputs))?;
        let cubic = if is_cubic {
            Some(CubicGains {
                n: fields.take("N")?.matrix((order, outputs))?,
                theta: fields.take("theta")?.matrix((outputs, outputs))?,
                w: read_positive(&fields.take("w")?, "the rate w of CN = -wI is positive")?,
                h: read_positive(&fields.take("period")?, "a sampling period is positive")?,
            })
        } else {
            None
        };
        fields.finish()?;
        let mut fields = file.object("operation")?;
        let deviation = match fields.optional("dA") {
            Some(a) => Some(Deviation {
                a: read_bound_matrix(&a, (order, order))?,
                b: read_bound_matrix(&fields.take("dB")?, (order, inputs))?,
            }),
            None => None,
        };
        let operation = Operation {
            state: read_bounds(&fields.take("x")?, order)?,
            input: read_bounds(&fields.take("u")?, inputs)?,
            noise: read_bounds(&fields.take("v")?, outputs)?,
            error: read_bounds(&fields.take("e(0)")?, order)?,
            deviation,
        };
        fields.finish()?;
        let mut fields = file.object("lyapunov")?;
        let p = fields.take("P")?.symmetric(order)?;
        fields.finish()?;
        let ball = match file.optional("running") {
            None => None,
            Some(field) => {
                let mut fields = field.object()?;
                let start = read_bound(&fields.take("start")?)?;
                let entries = read_bounds(&fields.take("limsup")?, order)?;
                fields.finish()?;
                Some(ClaimedBall { start, entries })
            }
        };
        Ok(Self { plant, stored: Stored { a, b, c, l, cubic }, step, formats, operation, p, ball })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        let SampledPlant { a, b, c } = &self.plant;
        let plant = vec![("A", Out::matrix(a)), ("B", Out::matrix(b)), ("C", Out::matrix(c))];
        let word = |format: Format| Out::Text(format.to_string());
        let formats = vec![("stored", word(self.formats.stored)), ("running", word(self.formats.running))];
        let mut stored: Vec<(&'static str, Out)> =
            self.matrices(&self.stored).into_iter().map(|(name, m)| (name, Out::matrix(m))).collect();
        if let Some(cubic) = &self.stored.cubic {
            stored.extend([("w", Out::number(cubic.w)), ("period", Out::number(cubic.h))]);
        }
        let Operation { state, input, noise, error, deviation } = &self.operation;
        let mut operation = vec![
            ("x", Out::numbers(state)),
            ("u", Out::numbers(input)),
            ("v", Out::numbers(noise)),
            ("e(0)", Out::numbers(error)),
        ];
        if let Some(Deviation { a, b }) = deviation {
            operation.extend([("dA", Out::matrix(a)), ("dB", Out::matrix(b))]);
        }
        let mut members = vec![
            ("plant", Out::Object(plant)),
            ("formats", Out::Object(formats)),
            ("step", Out::Text(self.step_word().to_owned())),
            ("stored", Out::Object(stored)),
            ("operation", Out::Object(operation)),
            ("lyapunov", Out::Object(vec![("P", Out::matrix(&self.p))])),
        ];
        if let Some(ClaimedBall { start, entries }) = &self.ball {
            let running = vec![("start", Out::number(*start)), ("limsup", Out::numbers(entries))];
            members.push(("running", Out::Object(running)));
        }
        members
    }
}
