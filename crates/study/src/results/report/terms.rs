//! What the words and numbers of the report mean, for those that occur in it.

use luenberger_figures::{Grid, Section};

use crate::results::{DesignReport, DesignVerdict, Results};

/// Numbers of designs.
const NUMBERS: [(&str, &str); 9] = [
    ("rate", "The error decays at least like exp(-rate t)."),
    (
        "decay rate",
        "The error decays in the end like exp(-t times the rate): distance of the poles from the imaginary axis.",
    ),
    (
        "overshoot",
        "The factor before exp(-rate t): the error is never larger than the overshoot times the initial error.",
    ),
    (
        "vertices",
        "The number of combinations of extreme values of the Jacobians over the region; the conditions hold at each.",
    ),
    ("norm of L", "The largest singular value of the gain."),
    (
        "noise gain",
        "White measurement noise of unit intensity leaves errors whose variances sum to the square of this number, by the \
         linear part of the error equation.",
    ),
    (
        "fastest pole relative to the plant",
        "The largest modulus of a pole of A - L C, divided by that of A: large values need short sampling periods.",
    ),
    ("period", "The time between two samples."),
    ("largest modulus of a pole", "The error shrinks in the end by this factor from sample to sample."),
];

/// The explanations, behind a line that opens them; none without observers.
pub(super) fn section(section: Section, results: &Results) -> Section {
    let designs: Vec<&DesignReport> = results.observers.iter().filter_map(|of| of.design.as_ref()).collect();
    let verdicts =
        DesignVerdict::MEANINGS.iter().filter(|(verdict, _)| designs.iter().any(|of| of.verdict == *verdict));
    let verdicts = verdicts.map(|(verdict, meaning)| (verdict.word(), *meaning));
    let has = |name: &str| designs.iter().any(|design| design.numbers.iter().any(|number| number.name == name));
    let numbers = NUMBERS.iter().filter(|(name, _)| has(name));
    let mut rows: Vec<(&str, &str)> = verdicts.chain(numbers.copied()).collect();
    if designs.iter().any(|design| !design.noise_deviation.is_empty()) {
        rows.push((
            "standard deviation of the error due to noise",
            "Of each state after the initial transient, with the measurement noise of the simulation, by the linear part \
             of the error equation; the largest over the vertices.",
        ));
    }
    if designs.iter().any(|design| design.facts.iter().any(|fact| fact.words.contains("margin"))) {
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
