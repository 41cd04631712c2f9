//! Results of a study as data. `study.json` is their serialization; the report and the terminal output are generated
//! from them.
//!
//! Nothing in here depends on the time, the machine's paths or the computing time, so that the same study gives
//! identical bytes.

mod about_zero;
mod alternative;
mod coverage;
mod document;
mod frequency;
mod log;
mod no_observer;
mod prediction;
mod quantity;
pub(crate) mod report;
mod score_tables;
mod scores;
mod statement;

pub use about_zero::{ABOUT_ZERO, ABOUT_ZERO_MEANS, is_about_zero};
pub(crate) use alternative::Proposal;
pub use alternative::{Advice, Alternative};
pub use coverage::{CoverageReport, StateCoverage};
pub(crate) use document::{Columns, eigenvalue, with_unit};
pub use document::{leading, log_data};
pub use frequency::{
    ChannelMargins, Crossing, FrequencyReport, LoopReport, ObserverFrequencies, OpenedLoop, Peak, RecoveryReport,
};
pub(crate) use log::whiteness;
pub use log::{
    ConsistencyReport, FilterReport, InnovationOf, InnovationReport, IntervalReport, LogColumn, LogReport, LogSampling,
    ModelReport, SmoothedDeviation, SmoothedReport, StateScore,
};
pub use no_observer::{Cause, NoObserver};
pub use prediction::{ErrorOf, LogSweepReport, LogSweepRow, PredictionOf, PredictionReport};
pub(crate) use quantity::Label;
pub use quantity::Quantity;
pub use score_tables::{ScoreCell, ScoreTable};
pub use scores::{
    MeritsReport, NormReport, PercentileReport, RunReport, SamplingReport, ScoreStatistics, ScoringReport,
    SimulationReport, StateReport, SweepReport, SweepRow,
};
pub use statement::{DesignVerdict, Statement};

pub use luenberger_design::UnseenModes;
use luenberger_proof::wording::{at_least, at_most, counted, rounded, shortest, significant};
use nalgebra::DMatrix;
use serde::Serialize;

/// Results of the executed steps. Parts that were not requested, or for which the study has no table, are absent.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Results {
    /// The title.
    pub title: String,
    /// Description of the study.
    pub about: String,
    /// The plant.
    pub plant: PlantSummary,
    /// The operating point, if the study names one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub operating_point: Option<OperatingPointReport>,
    /// Observability.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observability: Option<ObservabilityReport>,
    /// The observers, as designed; one for each of the study, in its order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub observers: Vec<ObserverReport>,
    /// Frequency responses of the observers and of the loop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency: Option<FrequencyReport>,
    /// The runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulation: Option<SimulationReport>,
    /// The interval observers of the simulation: how they enclosed the state.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub intervals: Vec<IntervalReport>,
    /// The filters of the simulation: whether their covariances agree with their errors.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub filters: Vec<FilterReport>,
    /// The filters of the simulation that decide between models: how probable these were.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub models: Vec<ModelReport>,
    /// The filters of the simulation and of the log: how often their errors were within two standard deviations.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub coverage: Vec<CoverageReport>,
    /// Observers on the log.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub log: Option<LogReport>,
    /// The sweep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep: Option<SweepReport>,
    /// The sweep on the log.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep_on_log: Option<LogSweepReport>,
    /// Warnings that qualify the results.
    pub warnings: Vec<String>,
    /// Files of the results folder besides `study.json` and `manifest.json`, by their names in it.
    pub files: Vec<String>,
    /// Files of the results folder that were not written by this command, or changed since, and stood in the way: their
    /// names, and the names they have now.
    #[serde(skip)]
    pub renamed: Vec<(String, String)>,
    /// Blocks of a sweep that were damaged and have been computed again, a sentence each.
    #[serde(skip)]
    pub notes: Vec<String>,
    /// The trajectories of the simulation and of the log, each observer's own.
    #[serde(skip)]
    pub runs: Vec<ObserverRun>,
}

/// The trajectory of an observer with its plant, one row for each time. What is not known is NaN.
#[derive(Debug, Clone, PartialEq)]
pub struct ObserverRun {
    /// The observer; empty for the plant alone.
    pub observer: String,
    /// Whether it ran on the log.
    pub on_log: bool,
    /// The times.
    pub t: Vec<f64>,
    /// The states of the plant; on a log without them there are no columns.
    pub x: DMatrix<f64>,
    /// The inputs.
    pub u: DMatrix<f64>,
    /// The measured outputs, with noise.
    pub y: DMatrix<f64>,
    /// The estimates: of the states, or of the functions of an observer of functions.
    pub estimate: Option<DMatrix<f64>>,
    /// Names and values of the functions of the states that an observer of functions estimates.
    pub functions: Option<(Vec<String>, DMatrix<f64>)>,
    /// The standard deviations of the estimates, of a filter.
    pub deviation: Option<DMatrix<f64>>,
    /// The smoothed estimates with their standard deviations, of a filter with `smooth` on a log.
    pub smoothed: Option<(DMatrix<f64>, DMatrix<f64>)>,
    /// The half-widths of the bounds of the states, of an interval observer.
    pub half_width: Option<DMatrix<f64>>,
    /// Names and estimates of disturbances, of an observer that has some.
    pub disturbance: Option<(Vec<String>, DMatrix<f64>)>,
    /// Names and probabilities of the models, of a filter that has several.
    pub modes: Option<(Vec<String>, DMatrix<f64>)>,
    /// What limits the use of its log, or that it left the region of its design, in sentences.
    pub warnings: Vec<String>,
}

/// The plant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlantSummary {
    /// `linear`, `expressions` or the name of a library plant.
    pub kind: String,
    /// Names of the states.
    pub states: Vec<String>,
    /// Units of the states, an empty text for one without; empty if the file gives none.
    pub units: Vec<String>,
    /// Units of the inputs, likewise.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub input_units: Vec<String>,
    /// Units of the outputs, likewise.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub output_units: Vec<String>,
    /// Unit of the time, if the file gives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_unit: Option<String>,
    /// The period of a plant in discrete time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dt: Option<f64>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// The parameters of the equations.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<ParameterReport>,
    /// The equations, one per line.
    pub equations: Vec<String>,
    /// A, B and C of a linear plant; B only if there are inputs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub matrices: Vec<NamedMatrix>,
}

impl PlantSummary {
    /// The first line of a text: `TITLE: 2 states, 1 input, 1 output (linear)`.
    pub(crate) fn headline(&self, title: &str) -> String {
        let [states, inputs, outputs] = [
            counted(self.states.len(), "state"),
            counted(self.inputs.len(), "input"),
            counted(self.outputs.len(), "output"),
        ];
        format!("{title}: {states}, {inputs}, {outputs} ({})\n", self.kind)
    }

    /// The unit of a state, an input or an output, if the file gives it.
    pub fn unit(&self, name: &str) -> Option<&String> {
        let columns =
            [(&self.states, &self.units), (&self.inputs, &self.input_units), (&self.outputs, &self.output_units)];
        let mut named = columns.into_iter().flat_map(|(names, units)| names.iter().zip(units));
        named.find(|(other, unit)| *other == name && !unit.is_empty()).map(|(_, unit)| unit)
    }

    /// A name with its unit, `speed (rad/s)`.
    pub fn labelled(&self, name: &str) -> String {
        document::with_unit(name, self.unit(name))
    }

    /// Values by names, `speed = 2 rad/s, current = 0.1 A`.
    pub fn listed(&self, names: &[String], values: impl IntoIterator<Item = String>) -> String {
        let one = |(name, value): (&String, String)| match self.unit(name) {
            Some(unit) => format!("{name} = {value} {unit}"),
            None => format!("{name} = {value}"),
        };
        names.iter().zip(values).map(one).collect::<Vec<_>>().join(", ")
    }
}

/// A parameter of the equations of a plant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterReport {
    /// The name.
    pub name: String,
    /// The value.
    pub value: f64,
    /// Its unit, if the file gives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

/// An operating point, and the linearisation there.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OperatingPointReport {
    /// The state.
    pub x: Vec<f64>,
    /// The input.
    pub u: Vec<f64>,
    /// The output.
    pub y: Vec<f64>,
    /// The largest |f(x, u)| that is left.
    pub residual: f64,
    /// How many steps Newton's method took.
    pub steps: usize,
    /// A, B, C and D; B only if there are inputs, D only if it is not zero.
    pub matrices: Vec<NamedMatrix>,
    /// The eigenvalues of A, as pairs of real and imaginary part.
    pub poles: Vec<[f64; 2]>,
    /// Whether the outputs see all states, to first order.
    pub observable: bool,
}

/// Observability of the plant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObservabilityReport {
    /// Subject of the analysis: the plant (linear), or its linearizations along a trajectory.
    pub points: Vec<ObservabilityAt>,
    /// The number of states.
    pub order: usize,
    /// The smallest rank over the points.
    pub rank: usize,
    /// For a nonlinear plant: Lie derivatives and empirical Gramian.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nonlinear: Option<NonlinearObservability>,
}

/// Observability of a linear plant or of a linearization.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObservabilityAt {
    /// The time of the linearization; none for a linear plant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub t: Option<f64>,
    /// The state of the linearization.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Vec<f64>>,
    /// The rank.
    pub rank: usize,
    /// The relative tolerance of the rank decisions.
    pub tolerance: f64,
    /// Every mode with its margin.
    pub modes: Vec<ModeReport>,
    /// The modes that are unobservable to working precision.
    pub hidden: Vec<ModeReport>,
    /// What is decided of the unobservable modes, exactly for the numbers as stored. In `study.json` it is
    /// `detectable`, whether an observer exists: `null` where that is not decided, as for a linearisation or very many
    /// states.
    #[serde(rename = "detectable", serialize_with = "detectable")]
    pub unseen: UnseenModes,
}

impl ObservabilityReport {
    /// Whether it is decided exactly that the plant is not observable.
    pub fn is_decided(&self) -> bool {
        self.points.iter().any(|point| matches!(point.unseen, UnseenModes::Decay | UnseenModes::Remain))
    }
}

/// `true`, `false` or `null`.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn detectable<S: serde::Serializer>(unseen: &UnseenModes, serializer: S) -> Result<S::Ok, S::Error> {
    unseen.is_detectable().serialize(serializer)
}

impl ObservabilityAt {
    /// What follows from the unobservable modes; `these` names them.
    pub fn unseen_in_words(&self, these: &str) -> String {
        let margin = self.hidden.iter().map(|mode| mode.margin).fold(0.0, f64::max);
        let margin = significant(margin, 2);
        match self.unseen {
            UnseenModes::Decay => format!(
                "{these} are unobservable. They are stable: the plant is detectable. An observer exists and does not change their rate."
            ),
            UnseenModes::None => format!(
                "{these} are unobservable to working precision (margin at most {margin}), while the plant as stored is observable: an observer exists, and only a large gain changes their rate."
            ),
            UnseenModes::Remain => {
                format!(
                    "{these} are unobservable. Not all of them are stable: the plant is not detectable, and no observer exists."
                )
            }
            UnseenModes::Undecided => format!(
                "{these} are unobservable to working precision (margin at most {margin}). Whether an observer exists is not decided."
            ),
        }
    }
}

/// One mode.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModeReport {
    /// The eigenvalue, [re, im].
    pub eigenvalue: [f64; 2],
    /// Observability margin: 0 for an unobservable mode.
    pub margin: f64,
    /// The least observable direction: real parts.
    pub direction: Vec<f64>,
    /// The direction as text, with the names of the states.
    pub words: String,
}

/// Observability of a nonlinear plant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NonlinearObservability {
    /// The rank of the Lie derivatives along the trajectory.
    pub lie: Vec<LieRank>,
    /// The eigenvalues of the empirical Gramian, largest first; empty if it was not computed.
    pub gramian: Vec<f64>,
    /// The eigenvector of its smallest eigenvalue.
    pub weakest: Vec<f64>,
    /// Ranks and Gramian as text.
    pub words: String,
}

/// The rank of the Lie derivatives at a point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LieRank {
    /// The time.
    pub t: f64,
    /// The state.
    pub x: Vec<f64>,
    /// The rank.
    pub rank: usize,
    /// The singular values of the Jacobian of the Lie derivatives, largest first.
    pub singular_values: Vec<f64>,
}

/// An observer of the study: its design, or why there is none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObserverReport {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: String,
    /// The solver, if the design solves a matrix inequality.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solver: Option<&'static str>,
    /// Its design; none if the observer is not applicable to the plant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub design: Option<DesignReport>,
    /// Why there is no design: violated hypothesis, alternatives and hints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<NoObserver>,
}

/// A design.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct DesignReport {
    /// What is proved, computed and measured of it.
    pub statement: Statement,
    /// Matrices by name: L, N, P, ...; rows.
    pub matrices: Vec<NamedMatrix>,
    /// Eigenvalues of the linear error dynamics, [re, im].
    pub poles: Vec<[f64; 2]>,
    /// Scalars by name: rate, overshoot, ...
    pub numbers: Vec<NamedNumber>,
    /// The verified conditions; empty for observers with measured evidence or without evidence.
    pub facts: Vec<FactReport>,
    /// `proved`, `refuted` or `undecided`; `measured` or `none` for observers without a theorem.
    pub verdict: DesignVerdict,
    /// The kind of evidence, if it is not a proof.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evidence: Option<String>,
    /// For designs with a constant gain: the stationary standard deviation of the error of each state that the noise of
    /// the simulation causes, by the linearised error equation; the largest over the vertices. Empty without noise.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub noise_deviation: Vec<f64>,
    /// Of a stationary Kalman filter: the standard deviations of the error of its estimate.
    #[serde(skip)]
    pub stationary_deviation: Option<Vec<f64>>,
}

impl DesignReport {
    /// The value of a quantity, if the design has it and it is finite.
    pub fn quantity(&self, quantity: Quantity) -> Option<f64> {
        self.numbers.iter().find(|number| number.quantity == Some(quantity)).and_then(|number| number.value)
    }

    /// The number of that name, if it is finite.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers.iter().find(|number| number.name == name).and_then(|number| number.value)
    }
}

/// A named matrix.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedMatrix {
    /// The name.
    pub name: String,
    /// The rows.
    pub rows: Vec<Vec<f64>>,
    /// Whether it is one of the proof, like P, and nothing that the observer runs with or that describes its error:
    /// such matrices are folded in the report.
    #[serde(skip)]
    pub is_of_proof: bool,
}

/// A named number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedNumber {
    /// The name.
    pub name: String,
    /// What it is, if it is one of the quantities of several designs.
    #[serde(skip)]
    pub quantity: Option<Quantity>,
    /// The number; none if it is infinite.
    pub value: Option<f64>,
    /// How a text rounds it.
    #[serde(skip)]
    pub rounding: Rounding,
}

impl NamedNumber {
    /// With six significant digits; a proved bound with more of them is rounded to the safe side.
    pub fn text(&self) -> String {
        let Some(value) = self.value else { return "infinite".to_owned() };
        match self.rounding {
            _ if rounded(value, 6) == value => shortest(value),
            Rounding::Nearest => significant(value, 6),
            Rounding::Down => at_least(value, 6),
            Rounding::Up => at_most(value, 6),
        }
    }
}

/// The side to which a text rounds a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rounding {
    /// To nearest: a computed number.
    Nearest,
    /// Down: a proved lower bound, as of a rate.
    Down,
    /// Up: a proved upper bound, as of an error.
    Up,
}

/// A condition of a certificate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FactReport {
    /// The inequality.
    pub statement: String,
    /// `proved`, `refuted` or `undecided`.
    pub verdict: DesignVerdict,
    /// The verified margin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub margin: Option<f64>,
    /// The verdict as text.
    pub words: String,
    /// Whether it is stated at a vertex of a polytope.
    #[serde(skip)]
    pub is_at_vertex: bool,
    /// Whether its words name a margin: the verified one, or that of floating point where it is undecided.
    #[serde(skip)]
    pub names_margin: bool,
    /// Its number in its paper, in brackets.
    #[serde(skip)]
    pub equation: Option<String>,
}

impl FactReport {
    /// A condition on the maps of an observer that was verified over the whole region, in intervals or symbolically,
    /// and is not a part of its certificate.
    pub(crate) fn of_region(statement: &str, words: String, margin: Option<f64>) -> Self {
        let margin = margin.filter(|margin| margin.is_finite());
        let (statement, verdict) = (statement.to_owned(), DesignVerdict::of_region());
        Self { statement, verdict, margin, words, is_at_vertex: false, names_margin: false, equation: None }
    }
}

impl DesignReport {
    /// The facts to print: those that are not verified and the five smallest margins, and how many others there are.
    /// Up to six are not folded.
    pub fn leading_facts(&self) -> (&[FactReport], usize) {
        const ALL: usize = 6;
        const LEADING: usize = 5;
        let open = self.facts.iter().filter(|fact| !fact.verdict.is_proved()).count();
        let shown = if self.facts.len() > ALL { (open + LEADING).min(self.facts.len()) } else { self.facts.len() };
        (&self.facts[..shown], self.facts.len() - shown)
    }
}

impl Results {
    /// Observers without a design, conditions that are not verified, and runs that ended early, one sentence each.
    /// Empty if the exit code is 0.
    pub fn failures(&self) -> Vec<String> {
        self.failures_of_observers().map(|(observer, why)| format!("{observer}: {why}")).collect()
    }

    /// The same, each with the name of its observer apart.
    pub fn failures_of_observers(&self) -> impl Iterator<Item = (&str, String)> {
        let designs = self.observers.iter().flat_map(|observer| {
            let failure = observer.failure.iter().map(|failure| failure.hypothesis.clone());
            let facts = observer.design.iter().flat_map(|design| &design.facts);
            let open = facts.filter(|fact| !fact.verdict.is_proved());
            let open = open.map(|fact| format!("{}: {}", fact.statement, fact.words));
            failure.chain(open).map(|why| (observer.name.as_str(), why))
        });
        let rows = self.simulation.iter().flat_map(|simulation| &simulation.rows);
        let runs = rows.filter_map(|row| Some((row.observer.as_str(), row.failure.clone()?)));
        let rows = self.log.iter().flat_map(|log| &log.rows);
        let on_log = rows.filter_map(|row| Some((row.observer.as_str(), row.failure.clone()?)));
        designs.chain(runs).chain(on_log)
    }

    /// The results as a command prints them, with the warnings and the failures; `designs` is whether gains and proofs
    /// are, too.
    pub fn summary(&self, designs: bool, coloured: bool) -> String {
        let mut text = if coloured { self.coloured_text(designs) } else { self.text(designs) };
        let failures = self.failures();
        for warning in &self.warnings {
            text.extend(["\nwarning: ", warning]);
        }
        for failure in &failures {
            text.extend(["\nfailed: ", failure]);
        }
        if !self.warnings.is_empty() || !failures.is_empty() {
            text.push('\n');
        }
        text
    }

    /// The results as `study.json` has them.
    ///
    /// # Errors
    /// None for finite results.
    pub fn to_json(&self) -> Result<String, crate::StudyError> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}
