//! Paths in backticks, of the pages and of comments: the files and the items that they name exist.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::pages::{files_below, prose, root};

/// What stands in backticks on one line.
fn quoted(line: &str) -> impl Iterator<Item = &str> {
    // An odd number of backticks is a quotation that goes on.
    let count = line.matches('`').count();
    line.split('`').skip(1).step_by(2).take(count / 2)
}

fn is_word(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || c == '_')
}

/// `a::{b, c}` as `a::b` and `a::c`.
fn each(path: &str) -> Vec<String> {
    match path.split_once('{').and_then(|(head, rest)| Some((head, rest.strip_suffix('}')?))) {
        Some((head, list)) => list.split(',').map(|name| format!("{head}{}", name.trim())).collect(),
        None => vec![path.to_owned()],
    }
}

/// The sources of the workspace without their comments, by their paths from the root.
struct Sources {
    code: BTreeMap<String, String>,
    files: BTreeSet<String>,
}

impl Sources {
    fn read(root: &Path) -> Self {
        let folders = ["crates", "tests", "xtask", "docs", "firmware", "fuzz", "proofs", ".cargo", ".github"];
        let skipped = |path: &Path| path.components().any(|part| part.as_os_str() == "target");
        let from_root = |path: &PathBuf| path.strip_prefix(root).unwrap().to_string_lossy().replace('\\', "/");
        let mut files: BTreeSet<String> = BTreeSet::new();
        for folder in folders.map(|folder| root.join(folder)).into_iter().filter(|folder| folder.is_dir()) {
            for kind in ["rs", "md", "py", "c", "h", "toml", "json", "js", "css", "sh", "yml"] {
                files.extend(files_below(&folder, kind).iter().filter(|path| !skipped(path)).map(from_root));
            }
        }
        let entries = std::fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path());
        files.extend(entries.filter(|path| path.is_file()).map(|path| from_root(&path)));
        let code = files.iter().filter(|path| Path::new(path).extension().is_some_and(|it| it == "rs")).map(|path| {
            let text = std::fs::read_to_string(root.join(path)).unwrap();
            let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
            (path.clone(), lines.flat_map(|line| [line, "\n"]).collect())
        });
        Self { code: code.collect(), files }
    }

    /// Whether a file or a folder has this path from the root or from a folder above the page, or ends with it.
    fn has_file(&self, path: &str, page: &Path) -> bool {
        if page.ancestors().skip(1).any(|folder| folder.join(path).exists()) {
            return true;
        }
        let path = path.trim_end_matches('/');
        let ends = |whole: &str| whole == path || whole.strip_suffix(path).is_some_and(|head| head.ends_with('/'));
        let folder = format!("{path}/");
        let inner = format!("/{path}/");
        self.files.iter().any(|file| ends(file) || file.starts_with(&folder) || file.contains(&inner))
    }

    /// Whether an item of a crate is there: each name is a module in the one before it, or stands in its code.
    fn has_item(&self, path: &str) -> bool {
        let mut names = path.split("::");
        let mut base = format!("crates/{}/src", names.next().unwrap_or_default());
        let below = |base: &str| {
            let (file, folder) = (format!("{base}.rs"), format!("{base}/"));
            self.code.iter().filter(move |(path, _)| **path == file || path.starts_with(&folder)).collect::<Vec<_>>()
        };
        let mut scope = below(&base);
        for name in names {
            let inner = below(&format!("{base}/{name}"));
            if !inner.is_empty() {
                (base, scope) = (format!("{base}/{name}"), inner);
            } else if !scope.iter().any(|(_, code)| stands_in(name, code)) {
                return false;
            }
        }
        true
    }
}

/// Whether a name stands in code as a word.
fn stands_in(name: &str, code: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(name)
        .any(|(at, _)| !code[..at].ends_with(is_part) && !code[at + name.len()..].starts_with(is_part))
}

/// The paths of a line of a page that do not exist.
fn missing(line: &str, page: &Path, crates: &BTreeSet<String>, sources: &Sources) -> Vec<String> {
    // Names in capitals stand for others, and what is built is not there.
    let is_open = |path: &str| path.contains("NAME") || path.contains("crates/X/") || path.starts_with("target/");
    let is_file = |path: &str| {
        let code = [".rs", ".py", ".md", ".c", ".h"].iter().any(|end| path.ends_with(end));
        let known = ["crates/", "tests/", "xtask/", "docs/", "firmware/", "fuzz/", "proofs/"];
        path.chars().all(|c| c.is_alphanumeric() || "/._-".contains(c))
            && (path.contains('/') && code || known.iter().any(|folder| path.starts_with(folder)))
    };
    let mut found = Vec::new();
    for path in quoted(line).filter(|path| !is_open(path)) {
        if is_file(path) {
            found.extend((!sources.has_file(path, page)).then(|| path.to_owned()));
            continue;
        }
        let is_item = |path: &String| {
            let (first, rest) = path.split_once("::").unwrap_or_default();
            crates.contains(first) && rest.split("::").all(is_word)
        };
        let items = each(path.strip_prefix("luenberger_").unwrap_or(path));
        found.extend(items.into_iter().filter(is_item).filter(|path| !sources.has_item(path)));
    }
    found
}

#[test]
fn every_path_in_backticks_exists() {
    let root = root();
    let sources = Sources::read(&root);
    let crates: BTreeSet<String> = std::fs::read_dir(root.join("crates"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let mut wrong = Vec::new();
    let mut checked = 0;
    // The changes name what was there, and the glossary what is in the crate of each part: it has a test of its own.
    let others = ["CHANGELOG.md", "docs/glossary.md"];
    for path in sources.files.iter().filter(|path| !others.contains(&path.as_str())) {
        let lines = match path.rsplit_once('.').map(|(_, kind)| kind) {
            Some("md") => prose(&root.join(path)),
            Some("rs") => {
                let text = std::fs::read_to_string(root.join(path)).unwrap();
                text.lines().filter(|line| line.trim_start().starts_with("//")).map(str::to_owned).collect()
            }
            _ => continue,
        };
        checked += lines.len();
        let page = root.join(path);
        let missing = lines.iter().flat_map(|line| missing(line, &page, &crates, &sources));
        wrong.extend(missing.map(|name| format!("{path}: `{name}`")));
    }
    assert!(checked > 10_000, "{checked} lines");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_path_that_is_not_there_is_found() {
    let sources = Sources::read(&root());
    let crates = BTreeSet::from(["study".to_owned()]);
    let missing = |line: &str| missing(line, Path::new("docs/page.md"), &crates, &sources);
    assert_eq!(missing("see `crates/study/src/kinds/no_such_kind.rs`"), ["crates/study/src/kinds/no_such_kind.rs"]);
    assert_eq!(
        missing("`study::design::{design, peb}` and `luenberger_study::kinds::registry`"),
        ["study::design::peb"]
    );
    assert!(missing("`crates/study/src/kinds`, `kinds/mod.rs` and `Study::observer`").is_empty());
}
