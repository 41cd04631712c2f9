//! What comes of a study: numbers first. `study.json` is exactly this, and the report, the terminal and machines read
//! it.
//!
//! Nothing in here depends on the time of day, on the machine's paths or on how long anything took, so that the same
//! study gives the same bytes.

pub(crate) mod report;

pub use report::leading;

use serde::Serialize;

/// What came of the steps that were executed; absent parts were not asked for, or the study has no table for them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Results {
    /// The title.
    pub title: String,
    /// What the study is for.
    pub about: String,
    /// The plant.
    pub plant: PlantSummary,
    /// What the outputs see.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observability: Option<ObservabilityReport>,
    /// The observers, as designed; one for each of the study, in its order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub observers: Vec<ObserverReport>,
    /// The runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulation: Option<SimulationReport>,
    /// Observers on the log.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub log: Option<LogReport>,
    /// The sweep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep: Option<SweepReport>,
    /// What a reader should know before he believes the rest.
    pub warnings: Vec<String>,
    /// Files of the output folder besides `study.json`, by their names in it.
    pub files: Vec<String>,
}

/// The plant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlantSummary {
    /// `linear`, `expressions` or the name of a plant that is built in.
    pub kind: String,
    /// Names of the states.
    pub states: Vec<String>,
    /// Units of the states; empty if the file gives none.
    pub units: Vec<String>,
    /// Unit of the time, if the file gives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_unit: Option<String>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// The numbers that the equations use by name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<NamedNumber>,
    /// The equations, one a line.
    pub equations: Vec<String>,
    /// A, B and C of a linear plant; B only if there are inputs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub matrices: Vec<NamedMatrix>,
}

/// What the outputs see of the states.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObservabilityReport {
    /// Of the plant itself (linear), or of its linearisations along a trajectory.
    pub points: Vec<ObservabilityAt>,
    /// The number of states.
    pub order: usize,
    /// The least rank over the points.
    pub rank: usize,
    /// For a nonlinear plant: what Lie derivatives and the empirical Gramian say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nonlinear: Option<NonlinearObservability>,
}

/// What the outputs see of a linear plant, or of a linearisation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObservabilityAt {
    /// The time of the linearisation; none for a linear plant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub t: Option<f64>,
    /// The state of the linearisation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Vec<f64>>,
    /// The rank.
    pub rank: usize,
    /// The relative tolerance of the rank decisions.
    pub tolerance: f64,
    /// Every mode with its margin.
    pub modes: Vec<ModeReport>,
    /// The modes that no output sees.
    pub hidden: Vec<ModeReport>,
    /// Whether the hidden modes decay by themselves, so that an observer exists nevertheless.
    pub detectable: bool,
}

/// One mode.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModeReport {
    /// The eigenvalue, [re, im].
    pub eigenvalue: [f64; 2],
    /// How well it is seen: 0 if not at all.
    pub margin: f64,
    /// The direction that is seen least: real parts.
    pub direction: Vec<f64>,
    /// The direction in words, by the names of the states.
    pub words: String,
}

/// What is known of the observability of a nonlinear plant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NonlinearObservability {
    /// The rank of the Lie derivatives along the trajectory.
    pub lie: Vec<LieRank>,
    /// The eigenvalues of the empirical Gramian, largest first; empty if it was not computed.
    pub gramian: Vec<f64>,
    /// The direction of its least eigenvalue.
    pub weakest: Vec<f64>,
    /// Ranks and Gramian in words.
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
    /// The solver that proposed, where a matrix inequality is solved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solver: Option<&'static str>,
    /// Its design; none if it does not fit the plant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub design: Option<DesignReport>,
    /// Why there is no design, which hypothesis fails, and what would fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<FailureReport>,
}

/// A design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DesignReport {
    /// What it claims, in a sentence.
    pub statement: String,
    /// Matrices by their names: L, N, P, ...; rows.
    pub matrices: Vec<NamedMatrix>,
    /// Eigenvalues of the error's linear part, [re, im].
    pub poles: Vec<[f64; 2]>,
    /// Numbers by their names: rate, overshoot, ...
    pub numbers: Vec<NamedNumber>,
    /// The facts; empty for observers whose evidence is measured or that have none.
    pub facts: Vec<FactReport>,
    /// `proved`, `refuted`, `undecided`, or `measured` and `none` for observers without a proof.
    pub verdict: String,
    /// What the evidence rests on, where it is not a proof.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evidence: Option<String>,
}

/// A matrix with its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedMatrix {
    /// The name.
    pub name: String,
    /// The rows.
    pub rows: Vec<Vec<f64>>,
}

/// A number with its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedNumber {
    /// The name.
    pub name: String,
    /// The number; none if it is infinite.
    pub value: Option<f64>,
}

/// A fact of a certificate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FactReport {
    /// The inequality.
    pub statement: String,
    /// `proved`, `refuted` or `undecided`.
    pub verdict: String,
    /// The margin of a proved fact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub margin: Option<f64>,
    /// The verdict in words.
    pub words: String,
}

/// Why an observer does not fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FailureReport {
    /// The hypothesis that fails, with its numbers.
    pub hypothesis: String,
    /// What would fit instead; empty if nothing is known to.
    pub alternatives: Vec<String>,
    /// Where the observer stands in the file.
    pub line: usize,
}

/// The runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SimulationReport {
    /// The end.
    pub duration: f64,
    /// `|x(0) - xhat(0)|` and the like are per observer; this is x(0).
    pub x0: Vec<f64>,
    /// x at the end.
    pub x_end: Vec<f64>,
    /// The seed of the noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// One row for each observer that was designed.
    pub rows: Vec<RunReport>,
}

/// How one observer did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunReport {
    /// The observer.
    pub observer: String,
    /// The merits; none where the run ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub merits: Option<MeritsReport>,
    /// Why the run ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

/// Figures of merit of |e|.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeritsReport {
    /// |e(0)|.
    pub initial: f64,
    /// The band of settling.
    pub band: f64,
    /// The first time within the band.
    pub settling_first: Option<f64>,
    /// The time from which |e| stays in the band.
    pub settling_last: Option<f64>,
    /// The largest |e|.
    pub peak: f64,
    /// The root of the mean square.
    pub rms: f64,
    /// |e| at the end.
    pub last: f64,
    /// The root of the mean square for each state.
    pub rms_by_state: Vec<f64>,
}

/// Observers on a measured log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogReport {
    /// How many samples.
    pub samples: usize,
    /// From when.
    pub start: f64,
    /// To when.
    pub end: f64,
    /// One row for each observer that was designed.
    pub rows: Vec<InnovationReport>,
}

/// The innovations of one observer, over the second half of the log, so that how the estimate came in is left out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InnovationReport {
    /// The observer.
    pub observer: String,
    /// One for each output.
    pub outputs: Vec<InnovationOf>,
    /// The estimate at the end.
    pub estimate: Vec<f64>,
    /// Of a Kalman filter: the mean of nu' S^-1 nu, which is the number of outputs where the filter believes in the
    /// right covariance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normalised: Option<f64>,
    /// Samples of a sampled-data observer that are not samples of the log.
    pub interpolated: usize,
    /// Why the run ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

/// The innovation of one output.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InnovationOf {
    /// The output.
    pub output: String,
    /// The mean: a bias of a sensor or of the model.
    pub mean: f64,
    /// The root of the mean square.
    pub rms: f64,
    /// The largest magnitude.
    pub peak: f64,
    /// How probable so much correlation is for a white sequence (Ljung and Box); none for fewer than 20 samples.
    pub white: Option<f64>,
}

/// The sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepReport {
    /// What was varied.
    pub parameter: String,
    /// Runs at each value.
    pub ensemble: usize,
    /// Its values.
    pub values: Vec<f64>,
    /// One row for each observer and value.
    pub rows: Vec<SweepRow>,
}

/// One observer at one value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepRow {
    /// The observer.
    pub observer: String,
    /// The value.
    pub value: f64,
    /// How many runs of the ensemble came to their end.
    pub finished: usize,
    /// Median over the ensemble of the time from which |e| stays in the band; none if most never do.
    pub settling: Option<f64>,
    /// Median of the root of the mean square of |e|.
    pub rms: Option<f64>,
    /// Median and greatest of the largest |e|.
    pub peak: Option<f64>,
    /// Median of |e| at the end.
    pub last: Option<f64>,
    /// Why there is no run, if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

impl Results {
    /// The observers without a design, the facts that are not proved and the runs that ended early, in a sentence each.
    /// A command that exits with 0 has none.
    pub fn failures(&self) -> Vec<String> {
        let mut failures = Vec::new();
        for observer in &self.observers {
            if let Some(failure) = &observer.failure {
                failures.push(format!("{}: {}", observer.name, failure.hypothesis));
            }
            let facts = observer.design.iter().flat_map(|design| &design.facts);
            let open = facts.filter(|fact| fact.verdict != "proved");
            failures.extend(open.map(|fact| format!("{}: {}: {}", observer.name, fact.statement, fact.words)));
        }
        let rows = self.simulation.iter().flat_map(|simulation| &simulation.rows);
        failures.extend(rows.filter_map(|row| Some(format!("{}: {}", row.observer, row.failure.as_ref()?))));
        let rows = self.log.iter().flat_map(|log| &log.rows);
        failures.extend(rows.filter_map(|row| Some(format!("{}: {}", row.observer, row.failure.as_ref()?))));
        failures
    }

    /// The results as `study.json` has them.
    ///
    /// # Errors
    /// None that a finite result can have.
    pub fn to_json(&self) -> Result<String, crate::StudyError> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}
