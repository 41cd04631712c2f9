//! Names as identifiers.

use luenberger_export::names::{check, identifier};

#[test]
fn names_become_identifiers_that_are_accepted() {
    for name in ["EKF at 100 Hz", "2nd", "", "---", "for", "Beobachter für Winkel", "a__b", "x"] {
        let text = identifier(name);
        assert!(check(&text).is_ok(), "{name:?} -> {text:?}");
    }
    for name in ["", "2nd", "a b", "for", "fn", "\u{e4}", &"a".repeat(49)] {
        assert!(check(name).is_err(), "{name:?}");
    }
}
