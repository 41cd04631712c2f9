//! A sample of the cases of `cargo xtask stress theorems`.

use luenberger_tests::falsify::{falsify, kinds};

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
