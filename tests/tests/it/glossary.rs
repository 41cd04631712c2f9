//! `docs/glossary.md` has every name at the root of the library crates, and no name that its crate does not define.

use std::collections::{BTreeMap, BTreeSet};

use super::pages::{files_below, prose, root};

/// Crates with a `lib.rs` that are no libraries for users: a test oracle, the Python package, the papers.
const OTHERS: [&str; 3] = ["lapack", "python", "reproduce"];

const DEFINING: [&str; 8] = ["fn", "struct", "enum", "trait", "type", "const", "mod", "macro_rules"];

fn libraries() -> Vec<String> {
    let crates = std::fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap());
    let libraries = crates.filter(|entry| entry.path().join("src/lib.rs").exists());
    let names = libraries.map(|entry| entry.file_name().into_string().unwrap());
    names.filter(|name| !OTHERS.contains(&name.as_str())).collect()
}

/// The text of every source file of a crate.
fn sources(name: &str) -> Vec<String> {
    let files = files_below(&root().join("crates").join(name).join("src"), "rs");
    files.iter().map(|file| std::fs::read_to_string(file).unwrap()).collect()
}

/// Identifiers and keywords.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty())
}

/// A name at the root of a crate, and whether the crate defines it.
type RootName = (String, bool);

/// The names of the outermost `pub` items of a `lib.rs`, without its modules.
fn root_names(lib: &str) -> Vec<RootName> {
    let mut names = Vec::new();
    for item in lib.split("\npub ").skip(1) {
        if let Some(path) = item.strip_prefix("use ") {
            let path = path.split(';').next().unwrap();
            let is_own = !path.starts_with("luenberger_") && path != "nalgebra";
            let list = path.split_once('{').map_or(path, |(_, list)| list);
            names.extend(list.split(',').filter_map(|name| words(name).last()).map(|name| (name.to_owned(), is_own)));
        } else if !item.starts_with("mod ") {
            names.push((words(item).nth(1).unwrap().to_owned(), true));
        }
    }
    names
}

/// The root names of a crate, with the macros it exports.
fn names_of(name: &str) -> Vec<RootName> {
    let lib = std::fs::read_to_string(root().join("crates").join(name).join("src/lib.rs")).unwrap();
    let sources = sources(name);
    let macros = sources.iter().flat_map(|source| source.split("#[macro_export]").skip(1));
    let macros = macros.map(|text| (words(text).nth(1).unwrap().to_owned(), true));
    root_names(&lib).into_iter().chain(macros).collect()
}

/// The names in backticks in the first column of a row.
fn listed(row: &str) -> impl Iterator<Item = &str> {
    row.split(" | ").next().unwrap().split('`').skip(1).step_by(2).flat_map(words)
}

/// The listed names by the crate that the heading of their section names.
fn glossary() -> BTreeMap<String, BTreeSet<String>> {
    let mut sections = BTreeMap::<String, BTreeSet<String>>::new();
    let mut section = None;
    for line in prose(&root().join("docs/glossary.md")) {
        if let Some(heading) = line.strip_prefix("## ") {
            section = heading.split('`').nth(1).map(|path| match path.trim_start_matches("luenberger") {
                "" => path.to_owned(),
                rest => rest.trim_start_matches([':', '_']).to_owned(),
            });
        } else if let (Some(section), true) = (&section, line.starts_with("| `")) {
            sections.entry(section.clone()).or_default().extend(listed(&line).map(str::to_owned));
        }
    }
    sections
}

/// A name that a crate re-exports from another one may be in any section.
#[test]
fn every_name_at_the_root_of_a_library_is_in_the_glossary() {
    let sections = glossary();
    let anywhere: BTreeSet<&String> = sections.values().flatten().collect();
    let (mut count, mut missing) = (0, Vec::new());
    for library in libraries() {
        for (name, is_own) in names_of(&library) {
            count += 1;
            let is_listed = if is_own {
                sections.get(&library).is_some_and(|section| section.contains(&name))
            } else {
                anywhere.contains(&name)
            };
            if !is_listed {
                missing.push(format!("{library}: {name}"));
            }
        }
    }
    assert!(missing.is_empty(), "not in docs/glossary.md:\n{}", missing.join("\n"));
    assert!(count > 400, "{count} names");
}

#[test]
fn every_name_in_the_glossary_is_defined_by_its_crate() {
    let libraries = libraries();
    let mut unknown = Vec::new();
    for (section, listed) in glossary() {
        assert!(libraries.contains(&section), "docs/glossary.md has a section of {section}");
        let mut defined: BTreeSet<String> = names_of(&section).into_iter().map(|(name, _)| name).collect();
        for source in sources(&section) {
            for line in source.lines().filter(|line| !line.trim_start().starts_with("//")) {
                let words: Vec<&str> = words(line).collect();
                let pairs = words.windows(2).filter(|pair| DEFINING.contains(&pair[0]));
                defined.extend(pairs.map(|pair| pair[1].to_owned()));
            }
        }
        unknown.extend(listed.difference(&defined).map(|name| format!("{section}: {name}")));
    }
    assert!(unknown.is_empty(), "in docs/glossary.md, and not defined:\n{}", unknown.join("\n"));
}

#[test]
fn root_names_are_read_from_items_and_lists() {
    let lib = "mod a;\npub mod b;\npub use a::{One, two,\n    c::Three};\npub use b::four;\npub use nalgebra;\n\
               pub use luenberger_proof::Verdict as Five;\n\n/// A type.\npub type Six<T> = Option<T>;\n";
    let names = root_names(lib);
    let own: Vec<&str> = names.iter().filter(|(_, is_own)| *is_own).map(|(name, _)| name.as_str()).collect();
    let others: Vec<&str> = names.iter().filter(|(_, is_own)| !is_own).map(|(name, _)| name.as_str()).collect();
    assert_eq!(own, ["One", "two", "Three", "four", "Six"]);
    assert_eq!(others, ["nalgebra", "Five"]);
}
