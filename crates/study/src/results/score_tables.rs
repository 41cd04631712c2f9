//! Scores as tables, for the terminal and the report.

use luenberger_proof::wording::significant;

use super::document::with_unit;
use super::{
    NormReport, PercentileReport, PlantSummary, Results, RunReport, SimulationReport, StateReport, SweepReport,
    SweepRow,
};

/// A table of scores.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoreTable {
    /// The head.
    pub head: Vec<String>,
    /// The rows, each as long as the head.
    pub rows: Vec<Vec<ScoreCell>>,
    /// Number of states of which the scores are not in the table.
    pub omitted: usize,
}

/// A cell of a table of scores.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoreCell {
    /// Its text.
    pub text: String,
    /// Whether it is a number, or stands for one.
    pub number: bool,
    /// Whether it is the best of those it is compared with.
    pub best: bool,
}

impl ScoreCell {
    fn name(text: &str) -> Self {
        Self { text: text.to_owned(), number: false, best: false }
    }

    fn text(text: &str) -> Self {
        Self { text: text.to_owned(), number: true, best: false }
    }

    fn number(x: f64) -> Self {
        Self::text(&significant(x, 4))
    }

    /// What is left of an error at the end; digits beyond these are noise or rounding.
    fn residual(x: f64) -> Self {
        Self::text(&significant(x, 2))
    }
}

/// A score with its value, the smaller the better; none for a time that does not exist.
type Score = (ScoreCell, Option<f64>);

fn plain(x: f64) -> Score {
    (ScoreCell::number(x), Some(x))
}

fn residual(x: f64) -> Score {
    (ScoreCell::residual(x), Some(x))
}

/// A time of settling; an error that starts at 0 has none.
fn settling(time: Option<f64>, initial: f64) -> Score {
    match time {
        Some(t) => plain(t),
        None if initial == 0.0 => (ScoreCell::text("-"), None),
        None => (ScoreCell::text("never"), None),
    }
}

/// Marks the best score of each column, unless all are written alike. None of observers that are not `comparable`.
fn with_best(rows: Vec<(Vec<ScoreCell>, Vec<Score>)>, comparable: bool) -> Vec<Vec<ScoreCell>> {
    let columns = rows.first().map_or(0, |(_, scores)| scores.len());
    let best: Vec<Option<String>> = (0..columns)
        .map(|j| {
            if !comparable {
                return None;
            }
            let column: Vec<&Score> = rows.iter().map(|(_, scores)| &scores[j]).collect();
            let least = column.iter().filter_map(|(cell, x)| Some((cell, (*x)?))).min_by(|a, b| a.1.total_cmp(&b.1))?.0;
            column.iter().any(|(cell, _)| cell.text != least.text).then(|| least.text.clone())
        })
        .collect();
    let marked = |(names, scores): (Vec<ScoreCell>, Vec<Score>)| {
        let scores = scores.into_iter().zip(&best);
        let scores = scores
            .map(|((cell, x), best)| ScoreCell { best: x.is_some() && best.as_ref() == Some(&cell.text), ..cell });
        names.into_iter().chain(scores).collect()
    };
    rows.into_iter().map(marked).collect()
}

fn head(columns: &[&str]) -> Vec<String> {
    columns.iter().map(|&column| column.to_owned()).collect()
}

fn of_norm(norm: &NormReport) -> Vec<Score> {
    vec![
        // An error that crosses the band and leaves it has not converged: this is no merit by itself.
        (settling(norm.settling_first, norm.initial).0, None),
        settling(norm.settling_last, norm.initial),
        plain(norm.peak),
        plain(norm.rms),
        residual(norm.last),
    ]
}

fn of_state(state: &StateReport) -> Vec<Score> {
    vec![
        plain(state.rmse),
        plain(state.peak),
        plain(state.overshoot),
        settling(state.settling_5, state.initial),
        settling(state.settling_2, state.initial),
        residual(state.last),
    ]
}

/// The heads of the scores of a state.
fn state_heads(plant: &PlantSummary) -> [String; 6] {
    let timed = |text: &str| with_unit(text, plant.time_unit.as_ref());
    ["RMSE", "peak", "overshoot", &timed("settling 5 %"), &timed("settling 2 %"), "at the end"].map(str::to_owned)
}

fn labelled(state: &StateReport) -> ScoreCell {
    ScoreCell::name(&with_unit(&state.state, state.unit.as_ref()))
}

impl SimulationReport {
    fn finished(&self) -> impl Iterator<Item = (&RunReport, &super::MeritsReport)> {
        self.rows.iter().filter_map(|row| Some((row, row.merits.as_ref()?)))
    }

    /// Whether all observers that finished were given the same estimate at the start.
    pub fn same_start(&self) -> bool {
        let mut starts = self.finished().map(|(row, _)| &row.initial);
        starts.next().is_none_or(|first| starts.all(|start| start == first))
    }

    /// The scores of the norm of each observer that finished; none without a scale, or if no run finished.
    pub fn norm_table(&self, plant: &PlantSummary) -> Option<ScoreTable> {
        let timed = |text: &str| with_unit(text, plant.time_unit.as_ref());
        let rows: Vec<_> = self
            .finished()
            .filter_map(|(row, merits)| Some((vec![ScoreCell::name(&row.observer)], of_norm(merits.norm.as_ref()?))))
            .collect();
        let head = head(&[
            "observer",
            &timed("enters band"),
            &timed("settling time"),
            "peak |e|",
            "rms |e|",
            "|e| at the end",
        ]);
        (!rows.is_empty()).then(|| ScoreTable { head, rows: with_best(rows, self.same_start()), omitted: 0 })
    }

    /// The scores of the first `most` states, the observers compared state by state; none if no run finished.
    pub fn state_table(&self, plant: &PlantSummary, most: usize) -> Option<ScoreTable> {
        // States, and functions of the state that some observers estimate in their place.
        let mut names: Vec<&str> = Vec::new();
        for state in self.finished().flat_map(|(_, merits)| &merits.states) {
            if !names.contains(&state.state.as_str()) {
                names.push(&state.state);
            }
        }
        let count = names.len();
        if count == 0 {
            return None;
        }
        let mut rows = Vec::new();
        for name in names.into_iter().take(most) {
            let named = |state: &&StateReport| state.state == name;
            let of = self.finished().filter_map(|(row, merits)| Some((row, merits.states.iter().find(named)?)));
            rows.extend(with_best(
                of.map(|(row, state)| (vec![labelled(state), ScoreCell::name(&row.observer)], of_state(state)))
                    .collect(),
                self.same_start(),
            ));
        }
        let mut head = head(&["error of", "observer"]);
        head.extend(state_heads(plant));
        Some(ScoreTable { head, rows, omitted: count.saturating_sub(most) })
    }

    /// The root mean square of the error of the first `most` states, a row for each observer that finished; none if no
    /// run finished.
    pub fn rmse_table(&self, plant: &PlantSummary, most: usize) -> Option<ScoreTable> {
        let names = plant.states.iter().take(most);
        let columns = names.clone().map(|name| format!("RMSE of {}", plant.labelled(name)));
        let head = std::iter::once("observer".to_owned()).chain(columns).collect();
        let of = |states: &[StateReport], name: &String| {
            let own = states.iter().find(|state| state.state == *name);
            own.map_or_else(|| (ScoreCell::text("–"), None), |state| plain(state.rmse))
        };
        let row = |(row, merits): (&RunReport, &super::MeritsReport)| {
            (vec![ScoreCell::name(&row.observer)], names.clone().map(|name| of(&merits.states, name)).collect())
        };
        let rows: Vec<_> = self.finished().map(row).collect();
        let omitted = plant.states.len().saturating_sub(most);
        (!rows.is_empty()).then(|| ScoreTable { head, rows: with_best(rows, self.same_start()), omitted })
    }

    /// Observers whose run ended early, and why.
    pub fn ended(&self) -> Vec<String> {
        self.rows.iter().filter_map(|row| Some(format!("{}: {}", row.observer, row.failure.as_ref()?))).collect()
    }
}

/// A median with the percentiles beside it.
fn spread(median: Option<f64>, percentiles: impl Iterator<Item = Option<f64>>) -> ScoreCell {
    let Some(median) = median else { return ScoreCell::text("-") };
    let end = |x: Option<f64>| x.map_or_else(|| "never".to_owned(), |x| significant(x, 3));
    let ends: Vec<String> = percentiles.map(end).collect();
    if ends.is_empty() {
        return ScoreCell::number(median);
    }
    ScoreCell::text(&format!("{} ({})", significant(median, 3), ends.join(" .. ")))
}

impl SweepReport {
    /// The medians of the norm, or without a scale those of the first `most` states, and in brackets the 5th and the
    /// 95th percentile of an ensemble; none if no run finished.
    pub fn table(&self, plant: &PlantSummary, most: usize) -> Option<ScoreTable> {
        let timed = |text: &str| with_unit(text, plant.time_unit.as_ref());
        let named = |row: &SweepRow| {
            let finished = format!("{} of {}", row.finished, self.ensemble);
            vec![ScoreCell::number(row.value), ScoreCell::name(&row.observer), ScoreCell::text(&finished)]
        };
        let finished = || self.rows.iter().filter(|row| row.finished > 0);
        let count = finished().next()?.states.len();
        let mut columns = head(&[self.parameter.as_str(), "observer", "finished"]);
        if self.scoring.scale.is_some() {
            columns.extend(head(&[&timed("settling time"), "peak |e|", "rms |e|", "|e| at the end"]));
            let scores = |row: &SweepRow| {
                let of = |median: Option<f64>, score: fn(&PercentileReport) -> Option<f64>| {
                    spread(median, row.percentiles.iter().map(score))
                };
                [
                    of(row.settling, |p| p.settling),
                    of(row.peak, |p| p.peak),
                    of(row.rms, |p| p.rms),
                    of(row.last, |p| p.last),
                ]
            };
            let rows = finished().map(|row| named(row).into_iter().chain(scores(row)).collect());
            return Some(ScoreTable { head: columns, rows: rows.collect(), omitted: 0 });
        }
        columns.push("error of".to_owned());
        columns.extend(state_heads(plant));
        let mut rows = Vec::new();
        for row in finished() {
            for (i, state) in row.states.iter().take(most).enumerate() {
                let of = |score: fn(&StateReport) -> Option<f64>| {
                    spread(score(state), row.percentiles.iter().map(|p| score(&p.states[i])))
                };
                let scores = [
                    of(|s| Some(s.rmse)),
                    of(|s| Some(s.peak)),
                    of(|s| Some(s.overshoot)),
                    of(|s| s.settling_5),
                    of(|s| s.settling_2),
                    of(|s| Some(s.last)),
                ];
                rows.push(named(row).into_iter().chain([labelled(state)]).chain(scores).collect());
            }
        }
        Some(ScoreTable { head: columns, rows, omitted: count.saturating_sub(most) })
    }

    /// The rows without a run, or with runs that ended early, and why.
    pub fn ended(&self) -> Vec<String> {
        let sentence = |row: &SweepRow| {
            let why = row.failure.as_ref()?;
            let (observer, value) = (&row.observer, significant(row.value, 6));
            let count = self.ensemble - row.finished;
            let runs = if row.finished > 0 { format!(", {count} of {} runs", self.ensemble) } else { String::new() };
            Some(format!("{observer} with {} = {value}{runs}: {why}", self.parameter))
        };
        self.rows.iter().filter_map(sentence).collect()
    }
}

impl Results {
    /// Observers without a design, which therefore were not run: a sentence if there are any.
    pub fn not_run(&self) -> Option<String> {
        let names: Vec<&str> =
            self.observers.iter().filter(|o| o.design.is_none()).map(|observer| observer.name.as_str()).collect();
        (!names.is_empty()).then(|| format!("Not run, because there is no design: {}.", names.join(", ")))
    }
}
