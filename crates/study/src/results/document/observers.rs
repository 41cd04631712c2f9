//! The observers: what is claimed of each, its gains, and the conditions that were verified.

use luenberger_figures::{Cell, Grid, Section, Tone};

use super::{matrices, poles, short};
use crate::results::{DesignReport, DesignVerdict, NamedMatrix, ObserverReport};

pub(crate) fn section(observers: &[ObserverReport]) -> Section {
    observers.iter().fold(Section::new("Observers"), observer)
}

/// The verdict of each.
pub(crate) fn verdicts(observers: &[ObserverReport]) -> Section {
    let grid = observers.iter().fold(Grid::new(&["observer", "kind", "certificate"]), |grid, observer| {
        grid.row([Cell::from(observer.name.as_str()), Cell::from(observer.kind.as_str()), badge(observer)])
    });
    observers.iter().filter(|observer| observer.design.is_none()).fold(Section::new("Observers").grid(grid), refused)
}

fn tone(verdict: DesignVerdict) -> Tone {
    if verdict.is_proved() {
        Tone::Good
    } else if verdict.is_refuted() {
        Tone::Bad
    } else {
        Tone::Open
    }
}

pub(crate) fn badge(observer: &ObserverReport) -> Cell {
    match &observer.design {
        Some(design) => Cell::badge(design.verdict.word(), tone(design.verdict)),
        None => Cell::badge("not applicable", Tone::Failed),
    }
}

fn observer(section: Section, observer: &ObserverReport) -> Section {
    match &observer.design {
        Some(design) => {
            let section = section.marked_heading(format!("{} ({})", observer.name, observer.kind), badge(observer));
            designed(section, design, observer.solver)
        }
        None => refused(section, observer),
    }
}

/// Why there is no design, and what else there is.
fn refused(section: Section, observer: &ObserverReport) -> Section {
    let Some(failure) = &observer.failure else { return section };
    let heading = format!("{} ({})", observer.name, observer.kind);
    let section = section.marked_heading(heading, badge(observer));
    section.prose(format!("Line {}: {}", failure.line, failure.hypothesis)).list(failure.advice())
}

fn designed(section: Section, design: &DesignReport, solver: Option<&str>) -> Section {
    let mut section = section.prose(design.statement.to_string());
    if let Some(evidence) = &design.evidence {
        section = section.prose(format!("Evidence: {evidence}."));
    }
    let numbers = design.numbers.iter().map(|number| (number.name.clone(), Cell::number(number.text())));
    let mut facts: Vec<_> = numbers.collect();
    if !design.noise_deviation.is_empty() {
        let deviations = design.noise_deviation.iter().map(|x| short(*x)).collect::<Vec<_>>().join(", ");
        facts.push(("standard deviation of the error due to noise".to_owned(), Cell::number(deviations)));
    }
    if !design.poles.is_empty() {
        facts.push(("poles".to_owned(), Cell::number(poles(&design.poles))));
    }
    facts.extend(solver.map(|solver| ("solver".to_owned(), Cell::from(solver))));
    let of_proof = |matrix: &&NamedMatrix| matrix.is_of_proof;
    section = if facts.is_empty() { section } else { section.facts(facts) };
    section = matrices(section, design.matrices.iter().filter(|matrix| !of_proof(matrix)));
    if design.matrices.iter().any(|matrix| of_proof(&matrix)) {
        let inside = matrices(Section::new(""), design.matrices.iter().filter(of_proof));
        section = section.folded("The matrices of the certificate", inside);
    }
    if design.facts.is_empty() {
        return section;
    }
    let (shown, folded) = design.leading_facts();
    let grid = shown.iter().fold(Grid::new(&["condition", "verdict", "result"]), |grid, fact| {
        grid.row([
            Cell::from(fact.statement.as_str()),
            Cell::badge(fact.verdict.word(), tone(fact.verdict)),
            Cell::from(fact.words.as_str()),
        ])
    });
    section = section.grid(grid);
    if folded > 0 {
        let count = design.facts.len();
        let words = format!("The {} smallest margins of {count} conditions; `study.json` has all.", shown.len());
        section = section.prose(words);
    }
    let mut notes = Vec::new();
    if design.facts.iter().any(|fact| fact.is_at_vertex) {
        notes.push(
            "A vertex (A, C) is a combination of extreme values of the entries of the Jacobians df/dx and dh/dx over the \
             region: what holds at all vertices holds for all Jacobians over the region.",
        );
    }
    let has = |equation: &str| design.facts.iter().any(|fact| fact.equation.as_deref() == Some(equation));
    match (has("(12)"), has("(13')")) {
        (true, true) => notes.push("(12) and (13') are their numbers in the paper on the cubic observer."),
        (true, false) => notes.push("(12) is its number in the paper on the cubic observer."),
        (false, true) => notes.push("(13') is its number in the paper on the cubic observer."),
        (false, false) => {}
    }
    if notes.is_empty() { section } else { section.note(notes.join(" ")) }
}
