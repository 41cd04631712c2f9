//! Numbers of `docs/bench-target.md` that `docs/deploy.md` quotes: the page is written anew with each measurement.

use std::path::Path;

fn page(name: &str) -> String {
    // A package of this crate has no pages.
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(name)).unwrap_or_default()
}

/// The cells of the row that begins with these, in the section of this title.
fn row<'a>(page: &'a str, section: &str, first: &[&str]) -> Vec<&'a str> {
    let section = page.split("\n## ").find(|text| text.starts_with(section)).unwrap();
    let rows = section.lines().map(|line| line.split('|').map(str::trim).skip(1).collect::<Vec<_>>());
    rows.into_iter().find(|cells| cells.starts_with(first)).unwrap_or_else(|| panic!("no row {first:?}"))
}

#[test]
fn the_numbers_of_a_target_are_those_of_its_page() {
    let (bench, deploy) = (page("bench-target.md"), page("deploy.md").replace("\n  ", " ").replace('\n', " "));
    if bench.is_empty() {
        return;
    }
    let says = |sentence: &str| assert!(deploy.contains(sentence), "docs/deploy.md does not say: {sentence}");
    let studies = "Observers of the templates and examples";
    let sampled = row(&bench, studies, &["double-integrator", "sampled"]);
    says(&format!("takes {} instructions and {} bytes of code on a Cortex-M4F", sampled[2], sampled[5]));
    let m0 = |name: &str| row(&bench, "Cortex-M0", &[name])[5];
    says(&format!(
        "takes {} instructions in q16.16, {} in f32 and {} in f64",
        m0("fixed_2_q16_16"),
        m0("linear_2_f32"),
        m0("linear_2_f64")
    ));
    let interpolated = row(&bench, studies, &["interpolated", "interpolated"]);
    let embedded = row(&bench, studies, &["duffing", "by simulation"]);
    says(&format!(
        "{} instructions in f32 on average, {} at most, where the embedded one takes {}",
        interpolated[2], interpolated[3], embedded[2]
    ));
    let filters = page("filters.md").replace('\n', " ");
    let bounded = row(&bench, studies, &["bounded", "bounded"]);
    // The stack, and in brackets the frame of the step's own function.
    let stack = bounded[4].split(' ').next().unwrap();
    let sentence = format!("takes {stack} bytes of stack and, in a run in which");
    assert!(filters.contains(&sentence), "docs/filters.md does not say: {sentence}");
    let sentence = format!("{} instructions on average and {} at most", bounded[2], bounded[3]);
    assert!(filters.contains(&sentence), "docs/filters.md does not say: {sentence}");
    // How many times more instructions f64 takes, in the table of C: the table of Rust below it is another section's.
    let section = bench.split("\n## ").find(|text| text.starts_with(studies)).unwrap();
    let table = section.split("\nSome of them as the static library").next().unwrap();
    let ratios: Vec<f64> = table
        .lines()
        .map(|line| line.split('|').map(str::trim).skip(1).collect::<Vec<_>>())
        .filter_map(|cells| Some(cells.get(7)?.parse::<f64>().ok()? / cells.get(2)?.parse::<f64>().ok()?))
        .collect();
    assert!(ratios.len() > 50, "{}", ratios.len());
    let (least, most) = ratios.iter().fold((f64::MAX, 0.0_f64), |(least, most), x| (least.min(*x), most.max(*x)));
    says(&format!("`--format f32` is {least:.0} to {most:.0} times faster"));
}

/// A row with fewer cells than its head has numbers in columns of another name.
#[test]
fn each_row_of_the_page_of_targets_has_all_its_cells() {
    let bench = page("bench-target.md");
    let mut head = None;
    for line in bench.lines() {
        let cells = line.starts_with('|').then(|| line.matches('|').count());
        assert!(head.is_none() || cells.is_none() || cells == head, "{line}");
        head = cells;
    }
}
