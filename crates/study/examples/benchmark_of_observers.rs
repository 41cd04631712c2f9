//! Benchmark of observers: `luenberger advise` on fifteen plants, as tables in Markdown.
//!
//! ```sh
//! cargo run --release -p luenberger-study --example benchmark_of_observers -- target/bench/observers.md
//! ```
//!
//! Further arguments: a part of the names of files of plants (default all), and the seconds for each plant.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use luenberger_proof::wording::{counted, significant};
use luenberger_study::advise::{Advice, AdviseOptions, RankedObserver, advise};
use luenberger_study::{Format, Study};

/// A study, the noise of one that has none, and what is added at its end.
struct Plant {
    file: &'static str,
    noise: &'static str,
    advise: &'static str,
}

const fn of(file: &'static str) -> Plant {
    Plant { file, noise: "", advise: "" }
}

const fn with(file: &'static str, noise: &'static str, advise: &'static str) -> Plant {
    Plant { file, noise, advise }
}

/// Linear plants first.
const PLANTS: &[Plant] = &[
    with(
        "crates/study/templates/double-integrator.toml",
        "noise = { amplitude = [0.02], period = 0.02, seed = 1 }",
        "settling = 1.5",
    ),
    of("xtask/bench/observers/two-masses.toml"),
    with("examples/studies/dc-motor.toml", "", "settling = 0.1"),
    with("crates/study/templates/load-torque.toml", "", "settling = 0.3"),
    with("crates/study/templates/mimo.toml", "", "settling = 5"),
    of("xtask/bench/observers/tanks.toml"),
    of("xtask/bench/observers/pendulum.toml"),
    with("crates/study/templates/flexible-joint.toml", "", "settling = 2"),
    with("examples/studies/cart-pole.toml", "", ""),
    with("examples/studies/cstr.toml", "", ""),
    with("examples/studies/lorenz.toml", "", ""),
    with(
        "crates/study/templates/van-der-pol.toml",
        "noise = { amplitude = [0.02], period = 0.05, seed = 1 }",
        "settling = 3",
    ),
    with(
        "crates/study/templates/duffing.toml",
        "noise = { amplitude = [0.01], period = 0.05, seed = 1 }",
        "settling = 5\nregion = { states = [[-1, 1], [-1, 1]] }\ninitial = [0, 0]",
    ),
    with(
        "crates/study/templates/cuk-observers.toml",
        "noise = { amplitude = [0.05, 0.005], period = 1e-4, seed = 1 }",
        "settling = 0.02",
    ),
    with(
        "crates/study/templates/exponential-cascade.toml",
        "noise = { amplitude = [0.01], period = 0.05, seed = 1 }",
        "settling = 4",
    ),
];

/// Seconds for each plant, unless others are given. What they do not reach is listed; with enough of them the tables do
/// not depend on the machine.
const BUDGET: f64 = 120.0;

/// The observers that this project is about.
const FAVOURITES: &[&str] =
    &["cubic", "sampled-cubic", "kkl", "pebo", "kkl-peb", "immersion-invariance", "kkl-numerical"];

/// A column of a table of winners: its head, and the value of which less is better.
type Column = (&'static str, fn(&RankedObserver) -> Option<f64>);

const COLUMNS: &[Column] = &[
    ("error", |one| one.medians.rms),
    ("noise", |one| one.medians.steady_rms),
    ("peak", |one| one.medians.peak),
    ("settling", |one| one.medians.settling),
    ("cost", |one| one.operations.map(|count| count as f64)),
    ("error, proved", |one| one.medians.rms.filter(|_| one.verdict.is_proved())),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let output = std::env::args().nth(1).ok_or("the file to write is expected")?;
    let chosen = std::env::args().nth(2);
    let budget = std::env::args().nth(3).map_or(Ok(BUDGET), |seconds| seconds.parse())?;
    let mut all = Vec::new();
    for plant in PLANTS.iter().filter(|plant| chosen.as_ref().is_none_or(|part| plant.file.contains(part))) {
        let began = std::time::Instant::now();
        let study = study(plant)?;
        let options = AdviseOptions { budget, own_tuning: false, ..AdviseOptions::default() };
        let (advice, _) = advise(&study, &options)?;
        eprintln!(
            "{}: {} in {:.1} s",
            advice.title,
            counted(advice.ranking.len(), "observer"),
            began.elapsed().as_secs_f64()
        );
        all.push(advice);
        // The pages so far, if the next plant takes too long.
        std::fs::write(&output, page(&all))?;
    }
    Ok(())
}

/// The study, with the noise in its simulation.
fn study(plant: &Plant) -> Result<Study, Box<dyn std::error::Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(plant.file);
    let mut text = String::new();
    for line in std::fs::read_to_string(&path)?.lines() {
        _ = writeln!(text, "{line}");
        if line.starts_with("duration =") && !plant.noise.is_empty() {
            _ = writeln!(text, "{}", plant.noise);
        }
    }
    if !plant.advise.is_empty() {
        _ = writeln!(text, "\n[advise]\n{}", plant.advise);
    }
    let folder: PathBuf = path.parent().map(Path::to_owned).unwrap_or_default();
    Ok(Study::from_text(plant.file, &text, Format::Toml, &folder)?)
}

/// Those whose runs all finished.
fn complete(advice: &Advice) -> impl Iterator<Item = &RankedObserver> {
    advice.ranking.iter().filter(|one| one.finished == advice.runs)
}

/// The best in a column: all that are within a thousandth of the least value.
fn winners(advice: &Advice, of: fn(&RankedObserver) -> Option<f64>) -> Vec<&str> {
    let least = complete(advice).filter_map(of).fold(f64::INFINITY, f64::min);
    let is_best = |one: &&RankedObserver| of(one).is_some_and(|value| value <= least * 1.001);
    complete(advice).filter(is_best).map(|one| one.name.as_str()).collect()
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| significant(value, 3))
}

fn page(all: &[Advice]) -> String {
    let mut text = String::new();
    plants(&mut text, all);
    best(&mut text, all);
    favourites(&mut text, all);
    tuning(&mut text, all);
    for advice in all {
        plant(&mut text, advice);
    }
    text
}

fn plants(text: &mut String, all: &[Advice]) {
    text.push_str(
        "## The plants\n\n| plant | states | outputs | noise | settling time asked for |\n|---|---:|---:|---|---|\n",
    );
    for advice in all {
        let value_of = |what: &str| {
            advice.information.iter().find(|item| item.what == what).map_or("", |item| item.value.as_str())
        };
        let plant = &advice.plant;
        _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} |",
            advice.title,
            plant.states.len(),
            plant.outputs.len(),
            value_of("noise level"),
            value_of("settling time")
        );
    }
}

fn best(text: &mut String, all: &[Advice]) {
    text.push_str("\n## The winner for each criterion\n\n| plant |");
    for (head, _) in COLUMNS {
        _ = write!(text, " {head} |");
    }
    _ = writeln!(text, "\n|---|{}", "---|".repeat(COLUMNS.len()));
    for advice in all {
        _ = write!(text, "| {} |", advice.title);
        for (_, of) in COLUMNS {
            let names = winners(advice, *of);
            let shown = match names.len() {
                0 => "none".to_owned(),
                count @ 4.. => format!("{} and {} more", names[..2].join(", "), count - 2),
                _ => names.join(", "),
            };
            _ = write!(text, " {shown} |");
        }
        text.push('\n');
    }
    let mut wins: Vec<(&str, usize)> = Vec::new();
    for name in all.iter().flat_map(|advice| winners(advice, COLUMNS[0].1)) {
        match wins.iter_mut().find(|(other, _)| *other == name) {
            Some((_, count)) => *count += 1,
            None => wins.push((name, 1)),
        }
    }
    wins.sort_by_key(|(name, count)| (std::cmp::Reverse(*count), *name));
    let wins: Vec<String> = wins.iter().map(|(name, count)| format!("{name} {count}")).collect();
    _ = writeln!(text, "\nLeast error, of {}: {}.", counted(all.len(), "plant"), wins.join(", "));
}

/// How the favourites fare against the winner.
fn favourites(text: &mut String, all: &[Advice]) {
    text.push_str(
        "\n## Cubic and KKL observers against the winner\n\nThe rank by error and the error relative to the winner's; for cubic observers, the error relative to the Luenberger observer\nwith the same poles too.\n\n| plant | observer | rank | error relative to the winner | relative to luenberger |\n|---|---|---:|---:|---:|\n",
    );
    for advice in all {
        let Some(winner) = complete(advice).next() else { continue };
        for (rank, one) in advice.ranking.iter().enumerate().filter(|(_, one)| FAVOURITES.contains(&one.kind.as_str()))
        {
            let relative = |to: Option<f64>| match (one.medians.rms.filter(|_| one.finished == advice.runs), to) {
                (Some(error), Some(to)) => significant(error / to, 3),
                (None, _) => format!("{} of {} runs finished", one.finished, advice.runs),
                _ => "-".to_owned(),
            };
            let same = advice
                .ranking
                .iter()
                .find(|other| other.name.starts_with("luenberger") && other.rule.starts_with("modes"));
            let same = same.filter(|_| one.kind.ends_with("cubic")).and_then(|other| other.medians.rms);
            let beside = same.map_or_else(|| "-".to_owned(), |same| relative(Some(same)));
            let of = advice.ranking.len();
            _ = writeln!(
                text,
                "| {} | {} | {} of {of} | {} | {beside} |",
                advice.title,
                one.name,
                rank + 1,
                relative(winner.medians.rms)
            );
        }
    }
}

/// The prior information that each tuning rule uses.
fn tuning(text: &mut String, all: &[Advice]) {
    text.push_str("\n## Prior information of each observer\n\nAll know the plant, its input, the first estimate and the sampling period. Beyond that:\n\n| observer | uses | rule | source |\n|---|---|---|---|\n");
    let mut known: Vec<String> = Vec::new();
    for one in all.iter().flat_map(|advice| &advice.ranking) {
        let name = one.name.trim_end_matches("-advised").to_owned();
        if one.source == "the study" || known.contains(&name) {
            continue;
        }
        let information: Vec<&str> = one.information.iter().map(|item| item.name()).collect();
        _ = writeln!(text, "| {name} | {} | {} | {} |", information.join(", "), one.rule, one.source);
        known.push(name);
    }
    text.push_str("| kkl, pebo, kkl-peb, immersion-invariance | their maps, gains and regions in the study | as the study specifies them | [KKL, PEB and I&I observers](kkl-studies.md) |\n");
}

fn plant(text: &mut String, advice: &Advice) {
    _ = writeln!(text, "\n## {}\n", advice.title);
    let unit = advice.plant.time_unit.as_ref().map(|unit| format!(", {unit}")).unwrap_or_default();
    _ = writeln!(
        text,
        "| observer | rms of the error | 5th to 95th percentile | settling time{unit} | peak | rms, second half | operations | proof | finished |\n|---|---:|---:|---:|---:|---:|---:|---|---:|"
    );
    for one in &advice.ranking {
        let m = &one.medians;
        let settling = m.settling.map_or_else(|| "never".to_owned(), |settling| significant(settling, 3));
        let operations = one.operations.map_or_else(|| "-".to_owned(), |count| count.to_string());
        let range = format!("{} to {}", number(m.rms_range[0]), number(m.rms_range[1]));
        _ = writeln!(
            text,
            "| {} | {} | {range} | {settling} | {} | {} | {operations} | {} | {} of {} |",
            one.name,
            number(m.rms),
            number(m.peak),
            number(m.steady_rms),
            one.verdict,
            one.finished,
            advice.runs
        );
    }
    text.push('\n');
    let mut reasons: Vec<(Vec<&str>, &str)> = Vec::new();
    for kind in advice.not_applicable.iter().filter(|kind| !kind.hypothesis.starts_with("its maps are derived by hand"))
    {
        match reasons.iter_mut().find(|(_, why)| *why == kind.hypothesis) {
            Some((names, _)) => names.push(&kind.name),
            None => reasons.push((vec![&kind.name], &kind.hypothesis)),
        }
    }
    for (names, why) in reasons {
        _ = writeln!(text, "- not applicable: {}: {}", names.join(", "), why.replace('|', "\\|").replace('\n', " "));
    }
    for open in &advice.not_reached {
        _ = writeln!(text, "- not reached: {open}");
    }
    for one in advice.ranking.iter().filter(|one| one.finished < advice.runs) {
        if let Some(why) = &one.ended {
            _ = writeln!(text, "- {} {why} (first of {})", one.name, counted(advice.runs - one.finished, "run"));
        }
    }
}
