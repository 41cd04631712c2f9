//! What the words and numbers of the report mean, for those that occur in it.

use luenberger_figures::{Grid, Section};

use crate::results::{DesignReport, DesignVerdict, Quantity, Results};

/// The explanations, behind a line that opens them; none without observers.
pub(super) fn section(section: Section, results: &Results) -> Section {
    let designs: Vec<&DesignReport> = results.observers.iter().filter_map(|of| of.design.as_ref()).collect();
    let verdicts =
        DesignVerdict::MEANINGS.iter().filter(|(verdict, ..)| designs.iter().any(|of| of.verdict == *verdict));
    let verdicts = verdicts.map(|(verdict, _, meaning)| (verdict.word(), *meaning));
    let numbers = || designs.iter().flat_map(|design| &design.numbers);
    let quantities = Quantity::ALL.into_iter().filter(|of| numbers().any(|number| number.quantity == Some(*of)));
    let quantities = quantities.map(|quantity| (quantity.name(), quantity.meaning()));
    let mut rows: Vec<(&str, &str)> = verdicts.chain(quantities).collect();
    if designs.iter().any(|design| !design.noise_deviation.is_empty()) {
        rows.push((
            "standard deviation of the error due to noise",
            "Of each state after the initial transient, with the measurement noise of the simulation, by the linear part \
             of the error equation; the largest over the vertices.",
        ));
    }
    if designs.iter().any(|design| design.facts.iter().any(|fact| fact.names_margin)) {
        rows.push((
            "margin",
            "A lower bound of the distance from violation: M > 0 with margin m means that M - m I is positive \
             semidefinite.",
        ));
    }
    if rows.is_empty() {
        return section;
    }
    let grid =
        rows.into_iter().fold(Grid::new(&["word", "meaning"]), |grid, (word, meaning)| grid.row([word, meaning]));
    section.folded("What these words and numbers mean", Section::new("").grid(grid))
}
