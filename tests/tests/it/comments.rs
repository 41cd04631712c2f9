//! The prose of comments has at most 120 columns; `cargo fmt` does not wrap it.
//!
//! Tables, blocks of code, equations in them and the targets of links may be longer.

use crate::pages::{files_below, root};

const COLUMNS: usize = 120;

/// The numbers of the lines of prose that are too long.
fn too_long(text: &str) -> Vec<usize> {
    let mut is_code = false;
    let mut numbers = Vec::new();
    for (line, number) in text.lines().zip(1..) {
        let Some(comment) = line.trim_start().strip_prefix("//") else {
            is_code = false;
            continue;
        };
        let comment = comment.trim_start_matches(['/', '!']).trim_start();
        is_code ^= comment.starts_with("```");
        let is_target = comment.starts_with('[') && comment.contains("]: ");
        if !is_code && !comment.starts_with('|') && !is_target && line.chars().count() > COLUMNS {
            numbers.push(number);
        }
    }
    numbers
}

#[test]
fn comments_have_at_most_120_columns() {
    let (mut count, mut found) = (0, Vec::new());
    for folder in ["crates", "firmware", "fuzz", "tests", "xtask"] {
        let files = files_below(&root().join(folder), "rs");
        for file in files.iter().filter(|file| !file.iter().any(|part| part == "target")) {
            let text = std::fs::read_to_string(file).unwrap();
            found.extend(too_long(&text).into_iter().map(|line| format!("{}:{line}", file.display())));
            count += 1;
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
    assert!(count > 500, "{count} files");
}

#[test]
fn long_prose_is_found_and_long_code_is_not() {
    let long = "\u{3b8}".repeat(COLUMNS - 4);
    let text = format!(
        "/// {long}\n//! x{long}\n\n  // {long}\n// | x{long}\n// [x]: {long}\n/// ```\n/// {long}x\n/// ```\n/// {long}x"
    );
    assert_eq!(too_long(&text), [2, 4, 10]);
    assert_eq!(too_long(&format!("let x = \"{long}\";\n// ```\nx\n// x{long}x")), [4]);
}
