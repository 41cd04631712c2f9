//! A sample of the cases of `cargo xtask stress theorems`.

use luenberger_tests::falsify::{changed_labels, falsify, kinds, without_seeds};

/// Theorems without a label or a definition in the language of labels: their mutants are in the table of `cargo xtask
/// mutate`.
const WITHOUT_LABELS: [&str; 9] = [
    "cubic-observer",
    "deployed-observer",
    "interval-observer",
    "kkl-error-bound",
    "matrix-inequality-holds",
    "matrix-inequality-refuted",
    "sampled-interval-observer",
    "semidefinite-program",
    "solution-within",
];

/// A theorem of the registry without a generator of certificates or an adversary is not tested.
#[test]
fn every_theorem_has_seeds() {
    assert_eq!(without_seeds(), [""; 0]);
}

/// Each label and each definition of every theorem with one typical error, decided in place of the right one.
#[test]
fn every_wrong_label_is_noticed() {
    let mut missed = Vec::new();
    for kind in kinds() {
        let found = changed_labels(kind, 2019);
        assert_eq!(found.noticed.is_empty(), WITHOUT_LABELS.contains(kind), "{kind}");
        missed.extend(found.missed.into_iter().map(|changed| (kind, changed)));
    }
    assert!(missed.is_empty(), "not noticed: {missed:#?}");
}

/// Mutants of certificates of every theorem: not one accepted mutant is contradicted.
#[test]
fn no_mutant_is_accepted_wrongly() {
    for kind in kinds() {
        let tally = falsify(kind, 120, 2019);
        assert!(tally.wrong.is_empty(), "{}", tally.wrong.join("\n\n"));
        // A sample in which every mutant has the same answer would test little.
        assert!(tally.accepted > 0 && tally.refused > 0, "{kind}: {tally:?}");
        // And an adversary that finds nothing in refused mutants would not find it in accepted ones.
        assert!(tally.convicted > 0, "{kind}: {tally:?}");
    }
}
