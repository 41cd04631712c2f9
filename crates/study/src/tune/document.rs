//! The fit as sections of a document, as text, as Markdown and as a page.

use luenberger_figures::figure::static_figure;
use luenberger_figures::{Cell, Grid, Report, Section};
use luenberger_proof::wording::{counted, significant};

use super::figure;
use super::report::{HeldOut, Judged, TuneReport, TunedParameter};
use crate::error::StudyError;
use crate::results::{ConsistencyReport, whiteness, with_unit};

impl TuneReport {
    /// The fit as text.
    pub fn text(&self) -> String {
        let head = self.plant.headline(&self.title);
        self.sections().iter().fold(head, |text, section| text + &section.text())
    }

    /// The fit as Markdown.
    pub fn markdown(&self) -> String {
        self.sections().into_iter().fold(Report::new(&self.title), Report::section).markdown()
    }

    fn page(&self) -> Report {
        let page = self.sections().into_iter().fold(Report::new(format!("{}: tuned", self.title)), Report::section);
        match figure::profiles(self) {
            Some(figure) => page.section(Section::new("Profile likelihoods").figure("profiles", figure)),
            None => page,
        }
    }

    fn sections(&self) -> Vec<Section> {
        let mut sections =
            vec![self.fit(), Section::new("Parameters").grid(self.table()).list(self.remarks.iter().cloned())];
        sections.extend(self.checked());
        sections.extend(self.held_out.as_ref().map(|held_out| self.judged(held_out)));
        sections
    }

    fn fit(&self) -> Section {
        let logs = self.logs.iter().map(|log| {
            let rest = if log.held_out > 0 {
                format!("; the last {} are held out", counted(log.held_out, "row"))
            } else {
                String::new()
            };
            (
                log.file.clone(),
                format!("{}, {}{rest}", counted(log.fitted, "row"), counted(log.measurements, "measurement")),
            )
        });
        let gain = self.log_likelihood - self.log_likelihood_before;
        let best = if let Some(relative) = self.relative {
            let [before, after] = relative.map(|x| significant(x, 4));
            (self.relative_name().to_owned(), format!("{after}, before {before}"))
        } else {
            let [before, after] = [self.log_likelihood_before, self.log_likelihood].map(|x| significant(x, 8));
            ("log-likelihood".to_owned(), format!("{after}, before {before} (gain {})", significant(gain, 4)))
        };
        let found = format!(
            "{} of {}, in {}{}",
            self.agreeing,
            counted(self.starts, "start"),
            counted(self.evaluations, "evaluation"),
            if self.relative.is_none() { " of the likelihood" } else { "" }
        );
        let facts = [best, ("found by".to_owned(), found)];
        let title = format!("{} ({}), by {}", self.observer, self.kind, self.by());
        Section::new(title).facts(logs.chain(facts))
    }

    fn table(&self) -> Grid {
        let has_profiles = !self.profiles.is_empty();
        let mut head = vec!["parameter", "before", "after", "standard error", "95 % interval"];
        if has_profiles {
            head.push("95 % by the profile");
        }
        self.parameters.iter().fold(Grid::new(&head), |grid, one| {
            let digits = |x: f64| significant(x, 4);
            let mut cells = vec![
                Cell::from(with_unit(&one.name, one.unit.as_ref())),
                Cell::number(digits(one.before)),
                Cell::number(digits(one.after)),
                Cell::number(one.standard_error.map_or_else(|| "-".to_owned(), |x| significant(x, 2))),
                Cell::from(one.interval_in_words()),
            ];
            if has_profiles {
                cells.push(Cell::from(of_profile(one)));
            }
            grid.row(cells)
        })
    }

    /// The variances by another method, beside those of the fit.
    fn checked(&self) -> Option<Section> {
        if self.autocovariances.is_empty() {
            return None;
        }
        let head = ["parameter", "by the likelihood", "by autocovariances", "standard error"];
        let grid = self.autocovariances.iter().fold(Grid::new(&head), |grid, one| {
            let fitted = self.parameters.iter().find(|other| other.name == one.name);
            grid.row([
                Cell::from(one.name.as_str()),
                Cell::number(fitted.map_or_else(|| "-".to_owned(), |other| significant(other.after, 4))),
                Cell::number(significant(one.value, 4)),
                Cell::number(one.standard_error.map_or_else(|| "-".to_owned(), |x| significant(x, 2))),
            ])
        });
        Some(Section::new("Cross-check by autocovariance least squares").grid(grid))
    }

    fn judged(&self, held_out: &HeldOut) -> Section {
        let both = [("before", &held_out.before), ("after", &held_out.after)];
        let rows: usize = self.logs.iter().map(|log| log.held_out).sum();
        let head: &[&str] = match self.relative {
            Some(_) => &["values", self.relative_name()],
            None => &["values", "log-likelihood", "NIS (innovations)"],
        };
        let consistency = both.iter().fold(Grid::new(head), |grid, (which, judged)| {
            let digits = if self.relative.is_some() { 4 } else { 8 };
            let number = judged.relative.or(judged.log_likelihood);
            let number = number.map_or_else(
                || format!("the {} failed", if self.relative.is_some() { "observer" } else { "filter" }),
                |x| significant(x, digits),
            );
            let mut cells = vec![Cell::from(*which), Cell::number(number)];
            if self.relative.is_none() {
                cells.push(Cell::from(judged.nis.as_ref().map_or_else(|| "-".to_owned(), ConsistencyReport::in_words)));
            }
            grid.row(cells)
        });
        let has_logs = self.logs.len() > 1;
        let mut head = vec!["values"];
        if has_logs {
            head.push("log");
        }
        head.extend(["output", "samples", "mean", "rms", "whiteness test p-value (Ljung-Box)"]);
        let innovations = both.iter().fold(Grid::new(&head), |grid, (which, judged)| {
            judged.innovations.iter().fold(grid, |grid, one| {
                let white = one.white.map_or_else(|| "-".to_owned(), whiteness);
                let mut cells = vec![Cell::from(*which)];
                if has_logs {
                    cells.push(Cell::from(one.file.as_str()));
                }
                cells.extend([
                    Cell::from(with_unit(&one.output, self.plant.unit(&one.output))),
                    Cell::number(one.samples.to_string()),
                    Cell::number(significant(one.mean, 3)),
                    Cell::number(significant(one.rms, 3)),
                    Cell::from(white),
                ]);
                grid.row(cells)
            })
        });
        let mut section = Section::new(format!("On the {} that were held out", counted(rows, "row")))
            .grid(consistency)
            .grid(innovations);
        if !held_out.after.errors.is_empty() {
            let head = ["values", "state", "samples", "rms error"];
            let errors = |grid: Grid, (which, judged): &(&str, &Judged)| {
                judged.errors.iter().fold(grid, |grid, one| {
                    grid.row([
                        Cell::from(*which),
                        Cell::from(with_unit(&one.state, self.plant.unit(&one.state))),
                        Cell::number(one.samples.to_string()),
                        Cell::number(significant(one.rms, 4)),
                    ])
                })
            };
            section = section.grid(both.iter().fold(Grid::new(&head), errors));
        }
        if self.warnings.is_empty() {
            return section;
        }
        section.list(self.warnings.iter().map(|warning| format!("warning: {warning}")))
    }
}

fn of_profile(one: &TunedParameter) -> String {
    let digits = |x: f64| significant(x, 4);
    match one.profile_interval {
        Some([Some(low), Some(high)]) => format!("{} to {}", digits(low), digits(high)),
        Some([Some(low), None]) => format!("above {}", digits(low)),
        Some([None, Some(high)]) => format!("below {}", digits(high)),
        Some([None, None]) => "any".to_owned(),
        None => "-".to_owned(),
    }
}

/// The files of a results folder: the page, the figure, and every number.
pub(super) fn files(report: &mut TuneReport) -> Result<Vec<(String, Vec<u8>)>, StudyError> {
    let failed = |what: &str, why: String| StudyError::Output { what: what.to_owned(), why };
    let page = report.page().html().map_err(|why| failed("report.html", why.to_string()))?;
    let mut files =
        vec![(report.file.clone(), report.study.clone().into_bytes()), ("report.html".to_owned(), page.into_bytes())];
    if let Some(figure) = figure::profiles(report) {
        let name = "figures/profiles";
        let svg = static_figure::svg(&figure).map_err(|why| failed(name, why.to_string()))?;
        let png = static_figure::png(&figure).map_err(|why| failed(name, why.to_string()))?;
        files.push((format!("{name}.svg"), svg.into_bytes()));
        files.push((format!("{name}.png"), png));
    }
    report.files = files.iter().map(|(name, _)| name.clone()).chain(["tune.json".to_owned()]).collect();
    files.push(("tune.json".to_owned(), (serde_json::to_string_pretty(&report)? + "\n").into_bytes()));
    Ok(files)
}
