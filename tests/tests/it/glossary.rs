//! `docs/glossary.md` has every name at the root of the library crates and in their public modules, and no name that
//! its crate does not define.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

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

/// The keyword of a definition is the last one before the name: `const fn new`.
fn defined_names<'a>(words: &[&'a str]) -> impl Iterator<Item = &'a str> {
    let pairs = words.windows(2).filter(|pair| DEFINING.contains(&pair[0]) && !DEFINING.contains(&pair[1]));
    pairs.map(|pair| pair[1])
}

/// What a source file makes public.
#[derive(Debug, PartialEq)]
enum Item<'a> {
    Definition(&'a str),
    /// `pub use from::name`, and whether it is of this crate.
    Use {
        from: &'a str,
        name: &'a str,
        is_own: bool,
    },
    /// `pub use name::*`
    Glob(&'a str),
    /// `pub mod name`, and its text unless it is in another file.
    Module(&'a str, Option<String>),
}

/// The outermost `pub` items that the documentation shows.
fn items(text: &str) -> Vec<Item<'_>> {
    let mut items = Vec::new();
    let pieces = text.split("\npub ");
    for (before, item) in pieces.clone().zip(pieces.skip(1)) {
        let first_line: Vec<&str> = words(item.lines().next().unwrap()).collect();
        if before.ends_with("#[doc(hidden)]") {
            continue;
        }
        if let Some(path) = item.strip_prefix("use ") {
            let path = path.split(';').next().unwrap();
            let from = words(path).next().unwrap();
            if path.ends_with("::*") {
                items.push(Item::Glob(from));
                continue;
            }
            let is_own = !from.starts_with("luenberger_") && from != "nalgebra";
            let list = path.split_once('{').map_or(path, |(_, list)| list);
            let names = list.split(',').filter_map(|name| words(name).last()).filter(|name| *name != "self");
            items.extend(names.map(|name| Item::Use { from, name, is_own }));
        } else if item.starts_with("mod ") {
            let text = item.split("\n}").next().unwrap().split_once(" {\n");
            let text = text.filter(|(head, _)| !head.contains(';'));
            items.push(Item::Module(first_line[1], text.map(|(_, text)| format!("\n{text}").replace("\n    ", "\n"))));
        } else {
            items.extend(defined_names(&first_line).next().map(Item::Definition));
        }
    }
    items
}

/// The public names of a module and of those below it, the files of which are in `folder`, and whether they are of this
/// crate.
fn names_below(text: &str, folder: &Path) -> Vec<(String, bool)> {
    let mut names = Vec::new();
    for item in items(text) {
        match item {
            Item::Definition(name) => names.push((name.to_owned(), true)),
            Item::Use { name, is_own, .. } => names.push((name.to_owned(), is_own)),
            Item::Glob(module) => names.extend(names_of_module(module, None, folder)),
            Item::Module(module, text) => names.extend(names_of_module(module, text, folder)),
        }
    }
    names
}

fn names_of_module(name: &str, text: Option<String>, folder: &Path) -> Vec<(String, bool)> {
    let read = |path: String| std::fs::read_to_string(folder.join(path));
    let text = text.or_else(|| read(format!("{name}.rs")).ok());
    names_below(&text.unwrap_or_else(|| read(format!("{name}/mod.rs")).unwrap()), &folder.join(name))
}

#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct PublicName {
    /// The outermost module; none at the root of the crate.
    module: Option<String>,
    name: String,
    /// Whether the crate defines it.
    is_own: bool,
}

/// The names at the root of a crate, with the macros it exports, and those of its modules that are not at the root too.
fn names_of(name: &str) -> BTreeSet<PublicName> {
    let folder = root().join("crates").join(name).join("src");
    let lib = std::fs::read_to_string(folder.join("lib.rs")).unwrap();
    let sources = sources(name);
    let macros = sources.iter().flat_map(|source| source.split("#[macro_export]").skip(1));
    let macros = macros.map(|text| words(text).nth(1).unwrap().to_owned());
    let mut names: BTreeSet<_> = macros.map(|name| PublicName { module: None, name, is_own: true }).collect();
    let items = items(&lib);
    for item in &items {
        match item {
            Item::Definition(name) => {
                names.extend([PublicName { module: None, name: (*name).to_owned(), is_own: true }]);
            }
            Item::Use { name, is_own, .. } => {
                names.extend([PublicName { module: None, name: (*name).to_owned(), is_own: *is_own }]);
            }
            Item::Glob(module) => panic!("{name}: `pub use {module}::*` at the root"),
            Item::Module(module, text) => {
                let below = names_of_module(module, text.clone(), &folder).into_iter().filter(|(name, is_own)| {
                    !items.contains(&Item::Use { from: module, name: name.as_str(), is_own: *is_own })
                });
                let module = Some((*module).to_owned());
                names.extend(below.map(|(name, is_own)| PublicName { module: module.clone(), name, is_own }));
            }
        }
    }
    names
}

/// The names in backticks in the first column of a row.
fn listed(row: &str) -> impl Iterator<Item = &str> {
    row.split(" | ").next().unwrap().split('`').skip(1).step_by(2).flat_map(words)
}

/// The rows by the crate that the heading of their section names: the listed names, with the modules of the heading
/// above them.
fn glossary() -> BTreeMap<String, Vec<BTreeSet<String>>> {
    let mut sections = BTreeMap::<String, Vec<BTreeSet<String>>>::new();
    let (mut section, mut modules) = (None, BTreeSet::new());
    for line in prose(&root().join("docs/glossary.md")) {
        if let Some(heading) = line.strip_prefix("## ") {
            modules.clear();
            section = heading.split('`').nth(1).map(|path| match path.trim_start_matches("luenberger") {
                "" => path.to_owned(),
                rest => rest.trim_start_matches([':', '_']).to_owned(),
            });
        } else if line.starts_with("### ") {
            modules = listed(&line).map(str::to_owned).collect();
        } else if let (Some(section), true) = (&section, line.starts_with("| `")) {
            let row = listed(&line).map(str::to_owned).chain(modules.clone()).collect();
            sections.entry(section.clone()).or_default().push(row);
        }
    }
    sections
}

/// A name of a module is in a row, or below a heading, with the name of the module. A name that a crate re-exports from
/// another one may be in any section.
#[test]
fn every_public_name_of_a_library_is_in_the_glossary() {
    let sections = glossary();
    let anywhere: BTreeSet<&String> = sections.values().flatten().flatten().collect();
    let (mut count, mut missing) = (0, Vec::new());
    for library in libraries() {
        let rows = sections.get(&library).map_or(&[][..], Vec::as_slice);
        for PublicName { module, name, is_own } in names_of(&library) {
            count += 1;
            let is_in =
                |row: &BTreeSet<String>| row.contains(&name) && module.as_ref().is_none_or(|it| row.contains(it));
            if !(rows.iter().any(is_in) || !is_own && anywhere.contains(&name)) {
                missing.push(format!("{library}: {}{name}", module.map(|it| it + "::").unwrap_or_default()));
            }
        }
    }
    assert!(missing.is_empty(), "not in docs/glossary.md:\n{}", missing.join("\n"));
    assert!(count > 1000, "{count} names");
}

#[test]
fn every_name_in_the_glossary_is_defined_by_its_crate() {
    let libraries = libraries();
    let mut unknown = Vec::new();
    for (section, rows) in glossary() {
        assert!(libraries.contains(&section), "docs/glossary.md has a section of {section}");
        let mut defined: BTreeSet<String> = names_of(&section).into_iter().map(|public| public.name).collect();
        for source in sources(&section) {
            for line in source.lines().filter(|line| !line.trim_start().starts_with("//")) {
                defined.extend(defined_names(&words(line).collect::<Vec<_>>()).map(str::to_owned));
            }
        }
        let listed: BTreeSet<String> = rows.into_iter().flatten().collect();
        unknown.extend(listed.difference(&defined).map(|name| format!("{section}: {name}")));
    }
    assert!(unknown.is_empty(), "in docs/glossary.md, and not defined:\n{}", unknown.join("\n"));
}

#[test]
fn public_items_are_read_from_definitions_lists_and_modules() {
    let text = "mod a;\npub mod b;\npub use a::{One, two,\n    c::Three};\npub use d::*;\npub use nalgebra::{self};\n\
                pub use luenberger_proof::Verdict as Four;\n\n/// A type.\npub type Five<T> = Option<T>;\n\
                pub(crate) fn hidden() {}\n#[doc(hidden)]\npub mod internals;\npub const fn six() {}\n\
                pub mod e {\n    pub fn seven() {}\n}\npub unsafe extern \"C\" fn eight() {}\n";
    let used = |from, name, is_own| Item::Use { from, name, is_own };
    let expected = [
        Item::Module("b", None),
        used("a", "One", true),
        used("a", "two", true),
        used("a", "Three", true),
        Item::Glob("d"),
        used("luenberger_proof", "Four", false),
        Item::Definition("Five"),
        Item::Definition("six"),
        Item::Module("e", Some("\npub fn seven() {}".to_owned())),
        Item::Definition("eight"),
    ];
    assert_eq!(items(text), expected);
    assert_eq!(
        names_of_module("e", Some("\npub fn seven() {}".to_owned()), Path::new("")),
        [("seven".to_owned(), true)]
    );
}
