//! The modules of a crate import each other without circles, so that each can be read after those that it imports.
//!
//! A module at the root of a crate counts with all modules below it as one; the root itself may re-export everything.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::pages::{files_below, root};

/// What each module imports.
type Graph = BTreeMap<String, BTreeSet<String>>;

/// The code of a file, without comments and the tests at its end.
fn code(text: &str) -> String {
    let lines =
        text.lines().take_while(|line| !line.starts_with("#[cfg(test)]") && !line.starts_with("#[cfg(all(test"));
    lines.filter(|line| !line.trim_start().starts_with("//")).flat_map(|line| [line, "\n"]).collect()
}

/// The names that follow `path` in a text: one, or each of a list in braces.
fn names_after(text: &str, path: &str) -> Vec<String> {
    let mut names = Vec::new();
    for (at, _) in text.match_indices(path) {
        // `super::super::x` and `luenberger_crate::x` are other paths.
        if text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':') {
            continue;
        }
        let rest = &text[at + path.len()..];
        let list = rest.strip_prefix('{').unwrap_or(rest);
        let (mut depth, mut is_first) = (0, true);
        let mut name = String::new();
        for c in list.chars() {
            match c {
                '{' => depth += 1,
                '}' if depth > 0 => depth -= 1,
                ',' if depth == 0 && rest.starts_with('{') => {
                    names.push(std::mem::take(&mut name));
                    is_first = true;
                }
                c if depth == 0 && is_first && (c.is_alphanumeric() || c == '_') => name.push(c),
                c if c.is_whitespace() && name.is_empty() && rest.starts_with('{') => {}
                _ if depth == 0 && !rest.starts_with('{') => break,
                '}' => break,
                _ => is_first = false,
            }
        }
        names.push(name);
    }
    names.retain(|name| !name.is_empty() && name != "super");
    names
}

/// The names that a root takes from its modules, with the module of each.
fn reexports(code: &str, modules: &BTreeSet<String>) -> BTreeMap<String, String> {
    let mut names = BTreeMap::new();
    for path in code.split("use ").skip(1).filter_map(|rest| rest.split(';').next()) {
        let mut words = path.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty());
        if let Some(module) =
            words.find(|word| *word != "crate" && *word != "self").filter(|word| modules.contains(*word))
        {
            names.extend(words.map(|name| (name.to_owned(), module.to_owned())));
        }
    }
    names
}

/// The imports between the modules at the root of a crate.
fn imports(source: &Path) -> Graph {
    let is_root =
        |file: &Path| file.parent() == Some(source) && (file.ends_with("lib.rs") || file.ends_with("main.rs"));
    let within = |file: &Path| file.strip_prefix(source).unwrap().with_extension("");
    let (roots, files): (Vec<_>, Vec<_>) = files_below(source, "rs").into_iter().partition(|file| is_root(file));
    let files = files
        .iter()
        .filter(|file| !within(file).starts_with("bin") && !within(file).iter().any(|part| part == "tests"));
    let files: Vec<_> = files.collect();
    let top = |file: &Path| within(file).iter().next().unwrap().to_string_lossy().into_owned();
    let modules: BTreeSet<String> = files.iter().map(|file| top(file)).collect();
    let read = |file: &Path| code(&std::fs::read_to_string(file).unwrap());
    let taken: BTreeMap<_, _> = roots.iter().flat_map(|root| reexports(&read(root), &modules)).collect();
    let mut graph: Graph = modules.iter().map(|module| (module.clone(), BTreeSet::new())).collect();
    for file in files {
        let (module, code) = (top(file), read(file));
        let depth = within(file).iter().count() - usize::from(file.ends_with("mod.rs"));
        let names = names_after(&code, "crate::").into_iter().chain(names_after(&code, &"super::".repeat(depth)));
        let imported =
            names.filter_map(|name| if modules.contains(&name) { Some(name) } else { taken.get(&name).cloned() });
        graph.get_mut(&module).unwrap().extend(imported.filter(|name| *name != module));
    }
    graph
}

/// The modules on circles and between them; none if the modules can be ordered.
fn circle(mut graph: Graph) -> Graph {
    loop {
        let before = graph.len();
        // A module that imports nothing, or that nothing imports, is on no circle.
        let imported: BTreeSet<String> = graph.values().flatten().cloned().collect();
        graph.retain(|module, imports| !imports.is_empty() && imported.contains(module));
        let left: BTreeSet<String> = graph.keys().cloned().collect();
        for imports in graph.values_mut() {
            imports.retain(|name| left.contains(name));
        }
        if graph.len() == before {
            return graph;
        }
    }
}

#[test]
fn modules_import_each_other_without_circles() {
    let crates = std::fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path().join("src"));
    let (mut count, mut circles) = (0, Vec::new());
    for source in crates.filter(|source| source.is_dir()).chain([root().join("xtask/src")]) {
        let graph = imports(&source);
        count += graph.values().map(BTreeSet::len).sum::<usize>();
        let found = circle(graph);
        circles.extend(
            found.iter().map(|(module, imports)| format!("{}: {module} imports {imports:?}", source.display())),
        );
    }
    assert!(circles.is_empty(), "{}", circles.join("\n"));
    assert!(count > 500, "{count} imports");
}

#[test]
fn imports_are_read_from_paths_and_lists() {
    let text = code(
        "use crate::{a::{B, c}, d, E};\n// crate::no\nfn f() { crate::g::h(super::super::i()); luenberger_crate::j() }\n\
                     #[cfg(test)]\nmod tests { use crate::k; }\n",
    );
    assert_eq!(names_after(&text, "crate::"), ["a", "d", "E", "g"]);
    assert_eq!(names_after(&text, "super::super::"), ["i"]);
    assert_eq!(names_after(&text, "super::"), Vec::<String>::new());
    let modules = ["a", "b"].map(str::to_owned).into();
    let names = reexports("pub use a::{One, two};\nuse other::Three;\npub(crate) use self::b::Four;\n", &modules);
    assert_eq!(names.keys().collect::<Vec<_>>(), ["Four", "One", "two"]);
    let graph = |edges: &[(&str, &[&str])]| -> Graph {
        edges.iter().map(|(from, to)| (from.to_string(), to.iter().map(ToString::to_string).collect())).collect()
    };
    assert!(circle(graph(&[("a", &["b", "c"]), ("b", &["c"]), ("c", &[])])).is_empty());
    assert_eq!(circle(graph(&[("a", &["b"]), ("b", &["c"]), ("c", &["b"]), ("d", &["a"])])).len(), 2);
}
