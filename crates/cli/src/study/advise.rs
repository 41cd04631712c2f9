//! `luenberger advise`: which observer to use for a study.

use super::columns::table;
use super::file::{folder_of, read, renamed};
use super::interrupt;
use crate::answer::Answer;
use crate::arguments::AdviseInput;
use crate::failure::Failure;
use crate::progress::Bar;
use luenberger_proof::wording::{counted, significant};
use luenberger_study::RunOptions;
use luenberger_study::advise::{Advice, AdviseOptions, Criterion, RankedObserver, advise as compared};
use luenberger_study::execute::duration;
use std::fmt::Write;
use std::path::Path;

pub(crate) fn advise(input: &AdviseInput) -> Result<Answer, Failure> {
    let study = read(&input.study)?;
    let bar = Bar::new();
    let folder = input.output.as_deref().map(|output| folder_of(Some(output), &input.study));
    let options = AdviseOptions {
        run: RunOptions {
            output: folder.clone(),
            force: input.force,
            progress: &|progress| bar.tell(progress.stage, progress.item, progress.done, progress.total),
            cancel: interrupt::flag(),
            threads: input.threads,
            ..RunOptions::default()
        },
        criteria: input.by.clone(),
        budget: input.budget,
        ..AdviseOptions::default()
    };
    let compared = compared(&study, &options);
    bar.finish();
    let (advice, stopped) = compared?;
    if let Some(folder) = &folder {
        renamed(folder, &advice.renamed);
    }
    let answer = Answer::new(text(&advice, input.budget, folder.as_deref()), &advice)?;
    let answer = answer.negative(advice.ranking.is_empty());
    match stopped {
        None => Ok(answer),
        Some(error) => Err(Failure::Stopped { error, finished: Box::new(answer) }),
    }
}

fn text(advice: &Advice, budget: f64, folder: Option<&Path>) -> String {
    let plant = &advice.plant;
    let mut text = format!(
        "{}: {}, {}, {} ({})\n",
        advice.title,
        counted(plant.states.len(), "state"),
        counted(plant.inputs.len(), "input"),
        counted(plant.outputs.len(), "output"),
        plant.kind
    );
    if let Some(observability) = &advice.observability {
        text.extend(["\nobservability: ", observability, "\n"]);
    }
    if !advice.information.is_empty() {
        text.push_str("\ngiven to all observers\n");
        for information in &advice.information {
            _ = writeln!(text, "  {}: {} ({})", information.what, information.value, information.from);
        }
    }
    if !advice.ranking.is_empty() {
        ranking(&mut text, advice);
    }
    if !advice.not_applicable.is_empty() {
        text.push_str("\nnot applicable\n");
        // Kinds for which the same hypothesis fails are one line.
        let mut reasons: Vec<(Vec<&str>, &str)> = Vec::new();
        for kind in &advice.not_applicable {
            match reasons.iter_mut().find(|(_, why)| *why == kind.hypothesis) {
                Some((names, _)) => names.push(&kind.name),
                None => reasons.push((vec![&kind.name], &kind.hypothesis)),
            }
        }
        for (names, why) in reasons {
            _ = writeln!(text, "  {}: {why}", names.join(", "));
        }
    }
    if !advice.not_reached.is_empty() {
        _ = writeln!(text, "\nnot reached within the budget of {}", duration(budget));
        for open in &advice.not_reached {
            _ = writeln!(text, "  {open}");
        }
    }
    if let Some(folder) = folder {
        _ = writeln!(text, "\n{} in {}", counted(advice.files.len() + 1, "file"), folder.display());
        if let Some(study) = advice.files.iter().find(|name| name.starts_with("study.")) {
            _ = writeln!(text, "next: luenberger run {}", folder.join(study).display());
        }
    }
    text
}

fn ranking(text: &mut String, advice: &Advice) {
    text.push_str("\nused by each\n");
    let mut rows = vec![["observer", "uses", "rule"].map(str::to_owned).to_vec()];
    for one in &advice.ranking {
        let uses: Vec<&str> = one.information.iter().map(|item| item.name()).collect();
        let same = one.same_as.as_ref().map(|name| format!("; the same gain as {name}")).unwrap_or_default();
        rows.push(vec![one.name.clone(), uses.join(", "), one.rule.clone() + &same]);
    }
    table(text, &rows);
    let medians = if advice.runs > 1 { format!(": medians of {} runs", advice.runs) } else { ": one run".to_owned() };
    _ = writeln!(text, "\nranking by {}{medians}", advice.criteria);
    for sentence in advice.scoring.iter().flat_map(|scoring| &scoring.words) {
        text.extend(["  ", sentence, "\n"]);
    }
    scores(text, advice);
    for (what, names) in [("operations", &advice.pareto_cost), ("peak |e|", &advice.pareto_peak)] {
        if names.len() > 1 {
            _ = writeln!(text, "  No other is better in both rms |e| and {what} than {}.", names.join(", "));
        }
    }
    text.push('\n');
    for sentence in &advice.explanation {
        text.extend([sentence.as_str(), "\n"]);
    }
}

/// The table of the ranking, the best value of each column marked.
fn scores(text: &mut String, advice: &Advice) {
    let unit = advice.plant.time_unit.as_ref().map(|unit| format!(" ({unit})")).unwrap_or_default();
    let several = advice.criteria.0.len() > 1;
    let mut head: Vec<String> = vec!["observer".to_owned()];
    if several {
        head.push("score".to_owned());
    }
    head.extend(["rms |e|".to_owned(), format!("settling time{unit}"), "peak |e|/|e(0)|".to_owned()]);
    head.extend(["rms |e|, 2nd half", "noise gain", "operations", "proof", "finished"].map(str::to_owned));
    let complete = || advice.ranking.iter().filter(|one| one.finished == advice.runs);
    let best = |of: &dyn Fn(&RankedObserver) -> Option<f64>| complete().filter_map(of).fold(f64::INFINITY, f64::min);
    let mut rows = vec![head];
    let row = |one: &RankedObserver| {
        let mark = |of: &dyn Fn(&RankedObserver) -> Option<f64>, x: f64| {
            if x == best(of) && one.finished == advice.runs { "*" } else { "" }
        };
        let cell = |of: &dyn Fn(&RankedObserver) -> Option<f64>, missing: &str| match of(one) {
            Some(x) => format!("{}{}", significant(x, 4), mark(of, x)),
            None => missing.to_owned(),
        };
        let operations = |one: &RankedObserver| one.operations.map(|count| count as f64);
        let mut cells = vec![one.name.clone()];
        if several {
            cells.push(cell(&|one| one.score, "-"));
        }
        cells.push(cell(&|one| one.medians.rms, "-"));
        cells.push(cell(&|one| one.medians.settling, "never"));
        cells.push(cell(&|one| one.medians.peak, "-"));
        cells.push(cell(&|one| one.medians.steady_rms, "-"));
        cells.push(one.noise_gain.map_or_else(|| "-".to_owned(), |gain| significant(gain, 4)));
        let count = one.operations.map(|count| format!("{count}{}", mark(&operations, count as f64)));
        cells.push(count.unwrap_or_else(|| "-".to_owned()));
        cells.push(one.verdict.word().to_owned());
        cells.push(format!("{} of {}", one.finished, advice.runs));
        cells
    };
    for one in &advice.ranking {
        rows.push(row(one));
    }
    table(text, &rows);
    text.push_str("  The best values have an asterisk.");
    let marked = |criterion| advice.criteria.0.iter().any(|(other, _)| *other == criterion);
    if several {
        text.push_str(" The score is the weighted geometric mean of the values relative to the best ones.");
    }
    if marked(Criterion::Proved) {
        _ = write!(text, " A missing proof counts as a factor of {}.", luenberger_study::advise::UNPROVED_FACTOR);
    }
    text.push('\n');
}
