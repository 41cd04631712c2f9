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
//! **Proof.** In `docs/theory-deployed.md`. The gains L, N, theta, w and h are those of the file. N must satisfy
//! only the two Stein inequalities, and theta is arbitrary: the observer computes `max(z'theta z, 0)`, as the statement
//! says, so that theta need not be semidefinite. The ball is derived from the assumed bounds, for the operations listed
//! in the statement; a claimed bound that is smaller by one unit in the last place is rejected.

use super::super::fields::{Field, Fields};
use super::super::members::{Members, members};
use super::super::sentence::{Reading, Represented};
use super::super::write::{Out, Written};
use super::super::{Fault, Witness};
use super::{Fact, FileError, Names, Statement, counted};
use crate::definite::Direction;
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::statement::{
    CubicGains, Deployed, Deviation, ErrorBall, Format, Formats, Operation, Running, SampledPlant, Step, Stored,
    deployed_linear, deployed_sampled_cubic,
};
#[cfg(feature = "all-theorems")]
use crate::statement::{RunningBound, running_bound};
use crate::verdict::{UndecidedReason, Verdict};
#[cfg(feature = "all-theorems")]
use crate::wording::if_at_most;

/// The largest order of a plant in such a file: the powers of the error map are summed with outward rounding, which
/// takes seconds here.
pub const LARGEST_DEPLOYED: usize = 32;

/// The words where no ball is claimed.
const NOTHING_RUNNING: &str = "Nothing is said of the rounding of its steps.";

/// The words for the ways in which a step is computed, and whether it has a cubic part.
const STEPS: [(&str, (Step, bool)); 4] = [
    ("joined", (Step::Joined, false)),
    ("innovation", (Step::Innovation, false)),
    ("accumulated", (Step::Accumulated, false)),
    ("cubic", (Step::Innovation, true)),
];

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

impl DeployedObserver {
    /// What is proved of the stored gains: rounding numbers of the format leaves them as they are.
    fn derived(&self) -> Result<Deployed, ProofError> {
        let Self { plant, stored, step, formats, operation, p, .. } = self;
        match &stored.cubic {
            Some(cubic) => deployed_sampled_cubic(plant, &stored.l, cubic, p, *formats, operation),
            None => deployed_linear(plant, &stored.l, p, *step, *formats, operation),
        }
    }

    #[cfg(feature = "all-theorems")]
    /// The numbers by which the ball is proved, if one is claimed.
    pub(crate) fn running_bound(&self) -> Result<Option<RunningBound>, ProofError> {
        let Self { plant, step, formats, operation, p, .. } = self;
        if self.ball.is_none() {
            return Ok(None);
        }
        running_bound(plant, &self.derived()?, p, *step, formats.running, operation)
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

    /// The bound of the running error where no noise is assumed, behind a sentence that bounds it with noise.
    #[cfg(feature = "all-theorems")]
    pub(crate) fn noiseless_sentence(&self, reading: &Reading<'_>) -> Option<String> {
        let ball = self.ball.as_ref().filter(|_| self.operation.noise.iter().all(|bound| *bound == 0.0))?;
        Some(format!("Without measurement noise it is at most {}.", reading.useful_bounds(&ball.entries, 3)))
    }

    /// The claim about the running observer in a report, if there is one.
    #[cfg(feature = "all-theorems")]
    pub(crate) fn running_sentence(&self, reading: &Reading<'_>) -> Option<String> {
        let ball = self.ball.as_ref()?;
        let (operation, format) = (&self.operation, self.formats.running);
        let supposed =
            |names: &[String], bounds: &[f64]| reading.listed(names, bounds.iter().map(|bound| if_at_most(*bound, 3)));
        let mut bounds = vec![("states", supposed(reading.states, &operation.state))];
        if !operation.input.is_empty() {
            bounds.push(("inputs", supposed(reading.inputs, &operation.input)));
        }
        bounds.push(("measurement noise", supposed(reading.outputs, &operation.noise)));
        bounds.push(("first error", supposed(reading.states, &operation.error)));
        let bounds: Vec<String> = bounds.into_iter().map(|(what, list)| format!("{what} ({list})")).collect();
        Some(format!(
            "Rounding and noise{}: for inputs held over each period, and while the magnitudes of {} stay within these bounds, the error in the end is at most {}, and no operation leaves the range of {format}{}.",
            if operation.deviation.is_some() { ", and every deviation of A within `bounds`" } else { "" },
            bounds.join(", "),
            reading.useful_bounds(&ball.entries, 3),
            if matches!(format, Format::Fixed { .. }) { ": nothing saturates" } else { "" }
        ))
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

    fn facts(&self, _: Names<'_>) -> Result<Vec<Fact>, ProofError> {
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

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        if !matches!(reading.plant, Represented::Itself) {
            return None;
        }
        let format = self.formats.stored;
        // The forcing of a plant whose matrices are rounded keeps its error from 0.
        let is_rounded =
            [(&self.plant.a, &self.stored.a), (&self.plant.b, &self.stored.b), (&self.plant.c, &self.stored.c)]
                .iter()
                .any(|(given, stored)| given != stored);
        let whose = if is_rounded {
            format!("{format} rounds those of the sampled plant: its own error need not tend to 0.")
        } else {
            "They are those of the sampled plant.".to_owned()
        };
        Some(format!(
            "With the gains as stored in {format}, in exact arithmetic, the estimation error of a plant x+ = A x + B u, y = C x with the stored A, B and C tends to 0 exponentially from every initial error. {whose}"
        ))
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
}

/// The members of `stored` depend on the step.
impl Members for DeployedObserver {
    fn read(file: &mut Fields<'_>, (): ()) -> Result<Self, FileError> {
        let plant: SampledPlant = file.take("plant")?.part()?;
        let sizes @ (order, inputs, outputs) = (plant.a.rows(), plant.b.cols(), plant.c.rows());
        let formats = file.take("formats")?.part()?;
        let (step, is_cubic) = file.take("step")?.word(&STEPS)?;
        let stored = file.object("stored", |stored| {
            let a = stored.take(if step == Step::Joined { "F" } else { "A" })?.matrix((order, order))?;
            let b = stored.take("B")?.matrix((order, inputs))?;
            let c = match step {
                Step::Joined => plant.c.clone(),
                Step::Innovation | Step::Accumulated => stored.take("C")?.matrix((outputs, order))?,
            };
            let l = stored.take("L")?.matrix((order, outputs))?;
            let cubic = if is_cubic { Some(CubicGains::read(stored, (order, outputs))?) } else { None };
            Ok(Stored { a, b, c, l, cubic })
        })?;
        let operation = file.take("operation")?.part_of(sizes)?;
        let p = file.object("lyapunov", |lyapunov| lyapunov.take("P")?.symmetric(order))?;
        let ball = file.optional("running").map(|running| running.part_of(order)).transpose()?;
        Ok(Self { plant, stored, step, formats, operation, p, ball })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        let Stored { a, b, c, l, cubic } = &self.stored;
        let of_step = (self.step, cubic.is_some());
        let word = STEPS.iter().find(|(_, step)| *step == of_step).map_or("", |(word, _)| word);
        let mut stored = match self.step {
            Step::Joined => vec![("F", a.out()), ("B", b.out())],
            Step::Innovation | Step::Accumulated => vec![("A", a.out()), ("B", b.out()), ("C", c.out())],
        };
        stored.push(("L", l.out()));
        stored.extend(cubic.iter().flat_map(CubicGains::write));
        let mut members = vec![
            ("plant", self.plant.out()),
            ("formats", self.formats.out()),
            ("step", word.out()),
            ("stored", Out::Object(stored)),
            ("operation", Out::Object(self.operation.write())),
            ("lyapunov", Out::Object(vec![("P", self.p.out())])),
        ];
        members.extend(self.ball.iter().map(|ball| ("running", ball.out())));
        members
    }
}

members! { SampledPlant { {
    a = "A".by(|a| limited(a, a.square()?, Matrix::rows));
    b = "B".by(|b| limited(b, b.matrix_with_rows(a.rows())?, Matrix::cols));
    c = "C".by(|c| limited(c, c.matrix_with_columns(a.rows())?, Matrix::rows));
} } }

members! { Formats { { stored = "stored".by(read_format); running = "running".by(read_format); } } }

members! { CubicGains, (order, outputs): (usize, usize) { {
    n = "N".matrix((order, outputs));
    theta = "theta".matrix((outputs, outputs));
    w = "w".positive("the rate w of CN = -wI is positive");
    h = "period".positive("a sampling period is positive");
} } }

/// dA and dB are there together, or not at all.
impl Members<(usize, usize, usize)> for Operation {
    fn read(file: &mut Fields<'_>, (order, inputs, outputs): (usize, usize, usize)) -> Result<Self, FileError> {
        let deviation = match file.optional("dA") {
            Some(a) => Some(Deviation {
                a: read_bound_matrix(&a, (order, order))?,
                b: read_bound_matrix(&file.take("dB")?, (order, inputs))?,
            }),
            None => None,
        };
        Ok(Self {
            state: file.take("x")?.bounds(order)?,
            input: file.take("u")?.bounds(inputs)?,
            noise: file.take("v")?.bounds(outputs)?,
            error: file.take("e(0)")?.bounds(order)?,
            deviation,
        })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        let Self { state, input, noise, error, deviation } = self;
        let mut members = vec![("x", state.out()), ("u", input.out()), ("v", noise.out()), ("e(0)", error.out())];
        if let Some(Deviation { a, b }) = deviation {
            members.extend([("dA", a.out()), ("dB", b.out())]);
        }
        members
    }
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

members! { ClaimedBall, order: usize { {
    start = "start".bound();
    entries = "limsup".bounds(order);
} } }

/// A matrix that is not larger than is checked in seconds.
fn limited(field: &Field<'_>, m: Matrix<f64>, size: impl Fn(&Matrix<f64>) -> usize) -> Result<Matrix<f64>, FileError> {
    field.bounded_order(size(&m), LARGEST_DEPLOYED)?;
    Ok(m)
}

impl Written for Format {
    fn out(&self) -> Out {
        Out::Text(self.to_string())
    }
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
            let known = ["binary32", "binary64", "Q4.12 (4 bits before the point, the sign among them, 12 after it)"];
            field.unknown_word(word, known)
        }),
    }
}
