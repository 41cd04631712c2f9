//! The pages of `docs/` and the READMEs: every link resolves, and every page is in the book.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap()
}

pub(crate) fn files_below(folder: &Path, extension: &str) -> BTreeSet<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| if path.is_dir() { files_below(&path, extension) } else { BTreeSet::from([path]) })
        .filter(|path| path.extension().is_some_and(|found| found == extension))
        .collect()
}

/// The lines outside blocks of code.
pub(crate) fn prose(page: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(page).unwrap_or_else(|error| panic!("{}: {error}", page.display()));
    let mut is_code = false;
    let is_prose = |line: &&str| {
        is_code ^= line.starts_with("```");
        !is_code
    };
    text.lines().filter(is_prose).map(str::to_owned).collect()
}

/// The targets of `[..](target)`, without addresses in the web.
fn links(page: &Path) -> Vec<String> {
    let text = prose(page).join("\n");
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets.filter(|target| !target.starts_with("http")).map(str::to_owned).collect()
}

/// The name of a heading in a link, as mdbook and GitHub form it.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.collect::<String>().trim().to_lowercase().replace(' ', "-")
}

fn anchors(page: &Path) -> Vec<String> {
    let prose = prose(page);
    prose.iter().filter(|line| line.starts_with('#')).map(|line| anchor(line.trim_start_matches('#'))).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let (root, docs) = (root(), root().join("docs"));
    let crates = std::fs::read_dir(root.join("crates")).unwrap().map(|entry| entry.unwrap().path().join("README.md"));
    let others = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(|page| root.join(page));
    let pages = files_below(&docs, "md").into_iter().chain(others).chain(crates.filter(|page| page.exists()));
    let (mut count, mut dead) = (0, Vec::new());
    for page in pages {
        for link in links(&page) {
            count += 1;
            let (file, heading) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            // What a page of the book links to has to be in the book.
            let is_reached = target.canonicalize().is_ok_and(|target| {
                (!page.starts_with(&docs) || target.starts_with(&docs))
                    && (heading.is_empty() || anchors(&target).iter().any(|anchor| anchor == heading))
            });
            if !is_reached {
                dead.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(dead.is_empty(), "dead links:\n{}", dead.join("\n"));
    assert!(count > 50, "{count} links");
}

#[test]
fn every_page_is_in_the_book_once() {
    let docs = root().join("docs");
    let summary = docs.join("SUMMARY.md");
    let mut listed: Vec<PathBuf> = links(&summary).iter().map(|link| docs.join(link)).collect();
    listed.sort();
    let mut pages = files_below(&docs, "md");
    assert!(pages.remove(&summary));
    assert_eq!(listed, pages.into_iter().collect::<Vec<_>>());
}

#[test]
fn headings_are_named_as_the_book_names_them() {
    assert_eq!(anchor(" Deployed: what f32 and fixed point leave"), "deployed-what-f32-and-fixed-point-leave");
    assert_eq!(anchor(" `hurwitz`, `schur`"), "hurwitz-schur");
}
