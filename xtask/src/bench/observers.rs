//! Benchmark of observers: `luenberger advise` on fifteen plants.

use crate::step::{Failure, cargo, root};
use std::fs;

/// Writes `observers.md` in `target/bench`, and puts it into `docs/benchmark.md` if that is asked for.
pub(crate) fn run(document: bool) -> Result<(), Failure> {
    let folder = root().join("target/bench");
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    let table = folder.join("observers.md");
    cargo(&["run", "--release", "--package", "luenberger-study", "--example", "benchmark_of_observers", "--"])
        .argument(&table)
        .step("observers")?;
    println!("{}", table.display());
    if document { super::write_page("docs/benchmark.md", &table) } else { Ok(()) }
}
