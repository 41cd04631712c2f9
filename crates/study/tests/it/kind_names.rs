//! What is of a kind alone stands in its module: the others do not ask for it by its name.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use luenberger_study::kinds::registry;

/// The sources of the crate without their comments.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let read = |path: PathBuf| {
        if path.is_dir() {
            return sources(&path);
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        vec![(path, code.flat_map(|line| [line, "\n"]).collect())]
    };
    entries.flat_map(read).collect()
}

/// Whether a code has the name of a kind as a value, or in a sentence about this kind.
fn names(code: &str, kind: &str, keys: &BTreeSet<&str>) -> bool {
    let ends = |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '-' || c == '_');
    let sentence = format!("the kind {kind}");
    let is_said = code.match_indices(&sentence).any(|(at, found)| ends(&code[at + found.len()..]));
    let asked = [format!("kind(\"{kind}\""), format!("kind = \\\"{kind}\\\""), format!("Some(\"{kind}\")")];
    // A key of that name, such as `kalman`, is another thing.
    let is_value = !keys.contains(kind) && code.contains(&format!("\"{kind}\""));
    is_said || is_value || asked.iter().any(|form| code.contains(form.as_str()))
}

/// Its own module, one that proposes it in place of another kind, and one more.
const MOST: usize = 3;

#[test]
fn a_kind_is_named_in_three_files_at_most() {
    let sources = sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    let kinds = registry();
    let keys: BTreeSet<&str> =
        kinds.iter().flat_map(|kind| kind.keys.iter().copied().flatten()).map(|key| key.name).collect();
    // Each that is declared is in the registry.
    let declares = |code: &str| code.contains("static DECLARATION: Declaration = Declaration {");
    assert!(keys.contains("kalman") && kinds.len() == sources.iter().filter(|(_, code)| declares(code)).count());
    for kind in kinds {
        let declared = format!("static DECLARATION: Declaration = Declaration {{\n    name: \"{}\"", kind.name);
        let is_named = |code: &str| code.contains(&declared) || names(code, kind.name, &keys);
        let files = sources.iter().filter(|(_, code)| is_named(code)).map(|(path, _)| path.as_path());
        let files: Vec<&Path> = files.collect();
        let own = files.iter().filter(|path| path.components().any(|part| part.as_os_str() == "kinds"));
        assert!(own.count() > 0 && files.len() <= MOST, "{}: {files:?}", kind.name);
    }
}
