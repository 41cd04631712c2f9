//! The first section of the report: the answer in a few sentences, one table and one figure.

use luenberger_figures::{Cell, Figure, Grid, Section};
use luenberger_proof::certificate::ProvedSentence;
use luenberger_proof::wording::counted;

use super::super::document::{badge, norm_caption, score};
use super::super::{DesignVerdict, ObserverReport, Results, ScoreTable, SimulationReport, UnseenModes};

/// What was studied, what is observable, what is proved, the scores, and the figure that shows them.
pub(super) fn section(results: &Results, figure: Option<(String, Figure)>) -> Section {
    // What is proved is proved of the model: that another plant was simulated comes first.
    let truth = results.simulation.as_ref().and_then(|simulation| simulation.truth.clone());
    let (plant, simulation) = (&results.plant, results.simulation.as_ref());
    let norm = simulation.and_then(|simulation| simulation.norm_table(plant));
    let has_norm = norm.is_some();
    let scores = norm.or_else(|| simulation?.rmse_table(plant, STATES));
    let studied = [Some(sizes(results)), observability(results)].into_iter().flatten().collect::<Vec<_>>().join(" ");
    let sentences = [truth, Some(studied), certificates(&results.observers), warnings(results)];
    let section = Section::new("Summary").list(sentences.into_iter().flatten());
    let section =
        if results.observers.is_empty() { section } else { section.grid(overview(results, scores.as_ref(), has_norm)) };
    let section = figure.into_iter().fold(section, |section, (id, figure)| section.figure(id, figure));
    let proved = proved(&results.observers);
    if proved.is_empty() { section } else { section.heading("What is proved").list(proved) }
}

/// The most states of which the summary has scores.
const STATES: usize = 6;

/// Each observer with its verdict and, of a simulation, the scores of the norm of the error, or of each state where
/// there is no norm.
fn overview(results: &Results, scores: Option<&ScoreTable>, has_norm: bool) -> Grid {
    let of_scores: Vec<&str> = scores.iter().flat_map(|table| &table.head[1..]).map(String::as_str).collect();
    let head: Vec<&str> = ["observer", "certificate"].into_iter().chain(of_scores.iter().copied()).collect();
    let row = |grid: Grid, observer: &ObserverReport| {
        let own = scores.and_then(|table| table.rows.iter().find(|row| row[0].text == observer.name));
        let none = || Cell::number("–");
        let numbers = (1..=of_scores.len()).map(|k| own.map_or_else(none, |row| score(&row[k])));
        grid.row([Cell::from(observer.name.as_str()), badge(observer)].into_iter().chain(numbers))
    };
    let grid = results.observers.iter().fold(Grid::new(&head), row);
    let same = results.simulation.as_ref().is_none_or(SimulationReport::same_start);
    match scores {
        None => grid,
        Some(table) if has_norm => grid.caption(norm_caption(table.rows.len(), same)),
        Some(table) => grid.caption(rmse_caption(table, same)),
    }
}

fn rmse_caption(table: &ScoreTable, same_start: bool) -> String {
    let states = match table.omitted {
        0 => "each state".to_owned(),
        omitted => format!("the first {STATES} states, those of the other {omitted} under Comparison"),
    };
    let best = match (table.rows.len(), same_start) {
        (0 | 1, _) => "",
        (_, true) => " The best values are marked.",
        (_, false) => " The observers start from different estimates: none is marked as best.",
    };
    format!("Root mean square of the error of {states}; a norm needs simulation.scale.{best}")
}

fn sizes(results: &Results) -> String {
    let plant = &results.plant;
    let named = |count: usize, what: &str, names: &[String]| match count {
        0 => format!("no {what}"),
        1..=6 => format!("{} ({})", counted(count, what), names.join(", ")),
        _ => counted(count, what),
    };
    format!(
        "The plant has {}, {} and {}{}.",
        named(plant.states.len(), "state", &plant.states),
        named(plant.inputs.len(), "input", &plant.inputs),
        named(plant.outputs.len(), "output", &plant.outputs),
        if plant.dt.is_some() { ", in discrete time" } else { "" }
    )
}

fn observability(results: &Results) -> Option<String> {
    let report = results.observability.as_ref()?;
    let linear = report.points.iter().all(|point| point.t.is_none());
    let unseen = report.points.first().map_or(UnseenModes::Undecided, |point| point.unseen);
    let rank = format!("rank {} of {}", report.rank, report.order);
    Some(match (linear, report.rank == report.order, unseen) {
        (true, true, _) => "It is observable.".to_owned(),
        (true, false, UnseenModes::Decay) => format!("It is detectable, not observable: {rank}."),
        (true, false, UnseenModes::Remain) => format!("It is not detectable: {rank}."),
        (true, false, _) => format!("It is not observable to working precision: {rank}."),
        (false, true, _) => "Its linearisations are observable at every point of the trajectory.".to_owned(),
        (false, false, _) => format!(
            "Its linearisations have rank {} of {} at the worst point of the trajectory.",
            report.rank, report.order
        ),
    })
}

/// The observers by their verdicts.
fn certificates(observers: &[ObserverReport]) -> Option<String> {
    let of = |choose: &dyn Fn(&ObserverReport) -> bool| -> Vec<&str> {
        observers.iter().filter(|observer| choose(observer)).map(|observer| observer.name.as_str()).collect()
    };
    let is =
        |observer: &ObserverReport, verdict| observer.design.as_ref().is_some_and(|design| design.verdict == verdict);
    let groups = DesignVerdict::MEANINGS
        .iter()
        .map(|(verdict, heading, _)| (*heading, of(&|observer| is(observer, *verdict))))
        .chain([("Not applicable", of(&|observer| observer.design.is_none()))]);
    let sentences: Vec<String> = groups
        .filter(|(_, names)| !names.is_empty())
        .map(|(what, names)| format!("{what}: {}.", names.join(", ")))
        .collect();
    (!sentences.is_empty()).then(|| sentences.join(" "))
}

/// What is proved, of a few observers, a sentence or more for each.
fn proved(observers: &[ObserverReport]) -> Vec<String> {
    const FEW: usize = 3;
    let said = observers.iter().filter_map(|observer| {
        let design = observer.design.as_ref().filter(|design| design.verdict.is_proved())?;
        let sentences: Vec<&str> = design.statement.proved_sentences().map(ProvedSentence::as_str).collect();
        Some(format!("{}: {}", observer.name, sentences.join(" ")))
    });
    let said: Vec<String> = said.collect();
    if said.len() <= FEW { said } else { Vec::new() }
}

fn warnings(results: &Results) -> Option<String> {
    let ended = results.simulation.as_ref().map_or(0, |simulation| simulation.ended().len())
        + usize::from(results.not_run().is_some());
    let mut words = Vec::new();
    if ended > 0 {
        words.push(format!("{} ended early or did not run.", counted(ended, "observer")));
    }
    match results.warnings.len() {
        0 => {}
        1 => words.push("One warning qualifies these results.".to_owned()),
        count => words.push(format!("{count} warnings qualify these results.")),
    }
    (!words.is_empty()).then(|| words.join(" "))
}
