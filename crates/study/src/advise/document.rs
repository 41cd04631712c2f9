//! The advice as sections of a document, as text and as Markdown.

use luenberger_figures::{Cell, Grid, Report, Section};
use luenberger_proof::wording::significant;

use super::UNPROVED_FACTOR;
use super::ranking::Criterion;
use super::report::{Advice, RankedObserver};
use crate::results::{Columns, with_unit};

impl Advice {
    /// The advice as text; `budget` is the time it had, in words.
    pub fn text(&self, budget: &str) -> String {
        let head = self.plant.headline(&self.title);
        self.sections(budget).iter().fold(head, |text, section| text + &section.text())
    }

    /// The advice as Markdown; `budget` is the time it had, in words.
    pub fn markdown(&self, budget: &str) -> String {
        self.sections(budget).into_iter().fold(Report::new(&self.title), Report::section).markdown()
    }

    fn sections(&self, budget: &str) -> Vec<Section> {
        let mut sections = Vec::new();
        sections.extend(self.observability.as_ref().map(|words| Section::new("Observability").prose(words)));
        if !self.information.is_empty() {
            let given = self.information.iter().map(|given| (given.what, format!("{} ({})", given.value, given.from)));
            sections.push(Section::new("Given to all observers").facts(given));
        }
        if !self.ranking.is_empty() {
            sections.push(self.used());
            sections.push(self.ranked());
        }
        if !self.not_applicable.is_empty() {
            // Kinds for which the same hypothesis fails are one line.
            let mut reasons: Vec<(Vec<&str>, &str)> = Vec::new();
            for kind in &self.not_applicable {
                match reasons.iter_mut().find(|(_, why)| *why == kind.hypothesis) {
                    Some((names, _)) => names.push(&kind.name),
                    None => reasons.push((vec![&kind.name], &kind.hypothesis)),
                }
            }
            let reasons = reasons.iter().map(|(names, why)| format!("{}: {why}", names.join(", ")));
            sections.push(Section::new("Not applicable").list(reasons));
        }
        if !self.not_reached.is_empty() {
            let title = format!("Not reached within the budget of {budget}");
            sections.push(Section::new(title).list(self.not_reached.iter().cloned()));
        }
        sections
    }

    fn used(&self) -> Section {
        let grid = self.ranking.iter().fold(Grid::new(&["observer", "uses", "rule"]), |grid, one| {
            let uses: Vec<&str> = one.information.iter().map(|item| item.name()).collect();
            let same = one.same_as.as_ref().map(|name| format!("; the same gain as {name}")).unwrap_or_default();
            grid.row([one.name.clone(), uses.join(", "), one.rule.clone() + &same])
        });
        Section::new("Used by each").grid(grid)
    }

    fn ranked(&self) -> Section {
        let medians = if self.held_out.is_some() {
            "on the log".to_owned()
        } else if self.runs > 1 {
            format!("medians of {} runs", self.runs)
        } else {
            "one run".to_owned()
        };
        let mut section = Section::new(format!("Ranking by {}: {medians}", self.criteria));
        let sentences = self.scoring.iter().flat_map(|scoring| &scoring.words);
        section = section.list(sentences.cloned());
        section = match &self.held_out {
            Some(rows) => {
                let (words, grid) = self.scores_on_log();
                section.list(std::iter::once(rows.clone()).chain(words)).grid(grid)
            }
            None => section.grid(self.scores()),
        };
        let mut words = vec!["The best values are marked.".to_owned()];
        if self.criteria.0.len() > 1 {
            words.push("The score is the weighted geometric mean of the values relative to the best ones.".to_owned());
        }
        if self.criteria.0.iter().any(|(criterion, _)| *criterion == Criterion::Proved) {
            words.push(format!("A missing proof counts as a factor of {UNPROVED_FACTOR}."));
        }
        let accuracy = self.accuracy().quantity();
        let pareto = [("operations", &self.pareto_cost), ("peak |e|", &self.pareto_peak)];
        let pareto = pareto.into_iter().filter(|(_, names)| names.len() > 1).map(|(what, names)| {
            format!("No other is better in both {accuracy} and {what} than {}.", names.join(", "))
        });
        section = section.list(std::iter::once(words.join(" ")).chain(pareto));
        section.list(self.explanation.iter().cloned())
    }

    /// A number of the table, marked if it is the best of those that finished.
    fn cell(
        &self,
        one: &RankedObserver,
        of: &dyn Fn(&RankedObserver) -> Option<f64>,
        text: &dyn Fn(f64) -> String,
        missing: &str,
    ) -> Cell {
        let complete = |one: &&RankedObserver| one.finished == self.runs;
        let Some(x) = of(one) else { return Cell::number(missing) };
        let best = self.ranking.iter().filter(complete).filter_map(of).fold(f64::INFINITY, f64::min);
        if x == best && complete(&one) { Cell::best(text(x)) } else { Cell::number(text(x)) }
    }

    /// What the scores on a log are, and their table.
    fn scores_on_log(&self) -> (Vec<String>, Grid) {
        let columns = Columns::of(self.ranking.iter().filter_map(|one| one.on_log.as_ref()));
        let several = self.criteria.0.len() > 1;
        let mut head = vec!["observer".to_owned()];
        head.extend(several.then(|| "score".to_owned()));
        let scores = columns.head(&self.plant);
        let count = scores.len();
        head.extend(scores.into_iter().chain(["operations", "proof"].map(str::to_owned)));
        let digits = |x: f64| significant(x, 4);
        let head: Vec<&str> = head.iter().map(String::as_str).collect();
        let grid = self.ranking.iter().fold(Grid::new(&head), |grid, one| {
            let mut cells = vec![Cell::from(one.name.as_str())];
            if several {
                cells.push(self.cell(one, &|one| one.score, &digits, "-"));
            }
            for j in 0..count {
                let is_gain = columns.scores(None)[j].is_gain;
                let sign = if is_gain { -1.0 } else { 1.0 };
                let of = |one: &RankedObserver| columns.scores(one.on_log.as_ref())[j].value.map(|x| sign * x);
                cells.push(self.cell(one, &of, &|x| digits(sign * x), "-"));
            }
            cells.push(self.cell(
                one,
                &|one| one.operations.map(|count| count as f64),
                &|count| count.to_string(),
                "-",
            ));
            cells.push(Cell::from(one.verdict.word()));
            grid.row(cells)
        });
        (columns.words(), grid)
    }

    /// The table of the ranking, the best value of each column marked.
    fn scores(&self) -> Grid {
        let several = self.criteria.0.len() > 1;
        let settling = with_unit("settling time", self.plant.time_unit.as_ref());
        let mut head = vec!["observer"];
        if several {
            head.push("score");
        }
        head.extend(["rms |e|", &settling, "peak |e|/|e(0)|", "rms |e|, 2nd half", "noise gain"]);
        head.extend(["operations", "proof", "finished"]);
        let digits = |x: f64| significant(x, 4);
        self.ranking.iter().fold(Grid::new(&head), |grid, one| {
            let mut cells = vec![Cell::from(one.name.as_str())];
            if several {
                cells.push(self.cell(one, &|one| one.score, &digits, "-"));
            }
            cells.push(self.cell(one, &|one| one.medians.rms, &digits, "-"));
            cells.push(self.cell(one, &|one| one.medians.settling, &digits, "never"));
            cells.push(self.cell(one, &|one| one.medians.peak, &digits, "-"));
            cells.push(self.cell(one, &|one| one.medians.steady_rms, &digits, "-"));
            cells.push(Cell::number(one.noise_gain.map_or_else(|| "-".to_owned(), digits)));
            cells.push(self.cell(
                one,
                &|one| one.operations.map(|count| count as f64),
                &|count| count.to_string(),
                "-",
            ));
            cells.push(Cell::from(one.verdict.word()));
            cells.push(Cell::from(format!("{} of {}", one.finished, self.runs)));
            grid.row(cells)
        })
    }
}
