//! The claims that are linear matrix inequalities, solved by both solvers.

use luenberger_reproduce::{Context, Verdict};

/// Each solver comes to each expectation, and the ledger shows the answers of both.
#[test]
fn both_solvers_answer_every_inequality() {
    let papers = luenberger_reproduce::papers();
    for id in ["cubic.lmi.strict", "cubic.lmi.nonstrict", "cubic.thm6.lmi"] {
        let claim = papers.iter().flat_map(|paper| &paper.claims).find(|claim| claim.id == id).unwrap();
        let record = claim.examine("cubic", &Context::new("."));
        assert_eq!((record.verdict, record.error), (Some(Verdict::Reproduced), None), "{id}: {}", record.note);
        for answer in ["interior: ", "clarabel: "] {
            assert!(record.note.contains(answer), "{}", record.note);
        }
        // For the built-in solver, and for all cases together.
        assert!(record.note.matches(", 0 undecided").count() >= 2, "{}", record.note);
    }
}
