//! Mistakes as they are printed.

use std::ops::Range;
use std::sync::Arc;

use luenberger_study::diagnostic::{Diagnostic, Diagnostics, Source};

fn excerpt(text: &str, span: Range<usize>) -> String {
    let source = Arc::new(Source::new("s.toml", text));
    Diagnostics::new(source, vec![Diagnostic::new(span, "wrong", "expected right").help("do so")]).to_string()
}

#[test]
fn an_excerpt_marks_what_is_wrong() {
    let text = excerpt("a = 1\nbeta = -1\n", 13..15);
    let expected = "error: wrong\n --> s.toml:2:8\n  |\n2 | beta = -1\n  |        ^^ expected right\n  = help: do so";
    assert_eq!(text, expected);
}

#[test]
fn characters_of_several_bytes_and_tabs_count_as_one() {
    let text = excerpt("\"\u{3b8}\u{308}\"\t= 1", 8..9);
    assert!(text.contains("s.toml:1:7"), "{text}");
    assert!(text.contains("|     \t ^ expected"), "{text}");
    // Within a character: the start of that character.
    assert!(excerpt("\u{3b8} = 1", 1..1).contains("s.toml:1:1"));
}

#[test]
fn spans_past_the_end_or_over_lines_end_with_the_line() {
    assert!(excerpt("a = [\n1\n", 4..100).contains("| a = [\n  |     ^ expected"));
    assert!(excerpt("a = 1", 100..200).contains("s.toml:1:6"));
    assert!(excerpt("", 0..0).contains("s.toml:1:1"));
}

#[test]
fn colour_is_escape_sequences_and_nothing_else() {
    let source = Arc::new(Source::new("s.toml", "a = 1"));
    let list = vec![Diagnostic::new(0..1, "wrong", "right"), Diagnostic::new(4..5, "wrong", "right")];
    let diagnostics = Diagnostics::new(source, list);
    let mut coloured = diagnostics.render(true);
    assert!(coloured.contains('\x1b') && !diagnostics.render(false).contains('\x1b'));
    for sequence in ["\x1b[1;31m", "\x1b[1;34m", "\x1b[1m", "\x1b[0m"] {
        coloured = coloured.replace(sequence, "");
    }
    assert_eq!(coloured, diagnostics.render(false));
    assert!(coloured.ends_with("2 mistakes in s.toml\n"));
}
