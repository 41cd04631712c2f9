//! Runs the claims and figures of the papers and writes the results.

use crate::claim::{CheckError, Claim, Class, KernelTheorems, Record};
use crate::context::Context;
use crate::evidence::Verdict;
use crate::figure::{Figure, static_figure};
use crate::paper::{Dataset, Drawing, Finding, KernelRefutation, Kind, LiveExample, Paper, Plate};
use crate::progress::Progress;
use crate::report;
use crate::summary::{Drawn, Live};
use crate::table::Table;
use crate::threads;
use luenberger_figures::colours;
use luenberger_live::page;
use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

pub use crate::summary::{Failure, Summary};

/// A run that could not write its output, or that makes no sense.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReproduceError {
    /// A file or folder could not be written.
    #[error("{path}: {source}", path = path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The ledger could not be encoded.
    #[error("the ledger could not be encoded: {0}")]
    Json(#[from] serde_json::Error),
    /// The report could not be written.
    #[error("the report: {0}")]
    Report(#[from] luenberger_figures::report::ReportError),
    /// Two claims or two figures have one id.
    #[error("the id {id:?} occurs twice")]
    Duplicate {
        /// The id.
        id: String,
    },
}

/// [`crate::run`] for the given papers: every claim, figure and dataset on all cores, then the report.
/// # Errors
/// As [`crate::run`]; and an id that occurs twice.
pub fn run_papers(papers: &[Paper], out: &Path) -> Result<Summary, ReproduceError> {
    let began = Instant::now();
    unique(papers.iter().flat_map(|p| &p.claims).map(|claim| claim.id))?;
    // Both write into one folder of numbers.
    let figures = papers.iter().flat_map(|p| &p.figures).map(|drawing| drawing.id);
    unique(figures.chain(papers.iter().flat_map(|p| &p.datasets).map(|dataset| dataset.id)))?;
    for folder in ["data", "figures"] {
        let path = out.join(folder);
        fs::create_dir_all(&path).map_err(|source| ReproduceError::Write { path, source })?;
    }
    let context = Context::new(out);
    let steps: Vec<Step<'_>> = papers.iter().flat_map(Step::of).collect();
    let progress = Progress::new(steps.len());
    let mut done = threads::map(steps.len(), |number| {
        let (step, began) = (&steps[number], Instant::now());
        progress.begin(step.id());
        let done = step.take(&context);
        progress.end(number, step.id(), done.word(), began.elapsed());
        done
    })
    .into_iter();
    progress.finish();
    let mut summary =
        Summary { records: Vec::new(), failures: Vec::new(), out: out.to_path_buf(), elapsed: Duration::ZERO };
    let (mut drawn, mut live) = (Vec::new(), Vec::new());
    for paper in papers {
        for (step, done) in Step::of(paper).zip(&mut done) {
            let error = match done {
                Done::Examined(record) => {
                    let error = record.error.clone().or_else(|| record.owes().map(str::to_owned));
                    summary.records.push(*record);
                    error
                }
                Done::Drawn(figure) => {
                    drawn.push(Drawn { id: step.id(), paper: paper.key, figure: *figure });
                    None
                }
                Done::Written => None,
                Done::Live(one) => {
                    live.push(one);
                    None
                }
                Done::Failed(error) => Some(error.to_string()),
            };
            summary.failures.extend(error.map(|error| Failure { id: step.id().to_owned(), error }));
        }
        for refutation in &paper.kernel {
            match refuted_in_coq(refutation, paper, &summary.records, out) {
                Ok((record, theorems)) => summary.records[record].kernel = Some(theorems),
                Err(error) => {
                    summary.failures.push(Failure { id: refutation.claim.to_owned(), error: error.to_string() });
                }
            }
        }
        for finding in &paper.findings {
            if let Some(error) = unsupported(finding, &summary.records) {
                summary.failures.push(Failure { id: finding.title.to_owned(), error });
            }
        }
    }
    let mut ledger = serde_json::to_string_pretty(&summary.records)?;
    ledger.push('\n');
    write(&out.join("claims.json"), ledger.as_bytes())?;
    summary.elapsed = began.elapsed();
    write(&out.join("report.html"), report::html(papers, &summary, &drawn, &live)?.as_bytes())?;
    summary.elapsed = began.elapsed();
    Ok(summary)
}

/// What a run does of a paper, one independent of the other.
enum Step<'a> {
    Claim(&'a Paper, &'a Claim),
    Figure(&'a Drawing),
    Dataset(&'a Dataset),
    Live(&'a LiveExample),
}

/// What a step came to.
enum Done {
    Examined(Box<Record>),
    Drawn(Box<Figure>),
    Written,
    Live(Live),
    Failed(CheckError),
}

impl<'a> Step<'a> {
    fn of(paper: &'a Paper) -> impl Iterator<Item = Self> {
        let claims = paper.claims.iter().map(move |claim| Step::Claim(paper, claim));
        let (figures, datasets) = (paper.figures.iter().map(Step::Figure), paper.datasets.iter().map(Step::Dataset));
        claims.chain(figures).chain(datasets).chain(paper.live.iter().map(Step::Live))
    }

    fn id(&self) -> &'static str {
        match self {
            Self::Claim(_, claim) => claim.id,
            Self::Figure(drawing) => drawing.id,
            Self::Dataset(dataset) => dataset.id,
            Self::Live(example) => example.id,
        }
    }

    fn take(&self, context: &Context) -> Done {
        let done = match self {
            Self::Claim(paper, claim) => Ok(Done::Examined(Box::new(claim.examine(paper.key, context)))),
            Self::Figure(drawing) => draw(drawing, context).map(|figure| Done::Drawn(Box::new(figure))),
            Self::Dataset(dataset) => tabulate(dataset, context).map(|()| Done::Written),
            Self::Live(example) => (example.experiment)()
                .and_then(|it| Ok(page::html_block(example.id, &it, &colours())?))
                .map(|html| Done::Live(Live { example: (*example).clone(), html })),
        };
        done.unwrap_or_else(Done::Failed)
    }
}

impl Done {
    /// For the progress.
    fn word(&self) -> &'static str {
        match self {
            Self::Examined(record) => record.word(),
            Self::Drawn(_) => "drawn",
            Self::Written | Self::Live(_) => "written",
            Self::Failed(_) => "failed",
        }
    }
}

/// Draws one figure and writes its three files.
fn draw(drawing: &Drawing, context: &Context) -> Result<Figure, CheckError> {
    let Plate { figure, data } = (drawing.draw)(context)?;
    let figures = context.out().join("figures");
    write_numbers(drawing.id, &data, context)?;
    write(&figures.join(format!("{}.svg", drawing.id)), static_figure::svg(&figure)?.as_bytes())?;
    write(&figures.join(format!("{}.png", drawing.id)), &static_figure::png(&figure)?)?;
    Ok(figure)
}

/// Computes one dataset and writes its file.
fn tabulate(dataset: &Dataset, context: &Context) -> Result<(), CheckError> {
    write_numbers(dataset.id, &(dataset.tabulate)(context, dataset.id)?, context)
}

fn write_numbers(id: &str, data: &Table, context: &Context) -> Result<(), CheckError> {
    let mut csv = Vec::new();
    data.write_csv(&mut csv)?;
    Ok(write(&context.out().join("data").join(format!("{id}.csv")), &csv)?)
}

/// The place of the record that a refutation for Coq belongs to, and what is written of it.
fn refuted_in_coq(
    refutation: &KernelRefutation,
    paper: &Paper,
    records: &[Record],
    out: &Path,
) -> Result<(usize, KernelTheorems), CheckError> {
    let of_claim = records.iter().position(|record| record.id == refutation.claim);
    let record = of_claim.ok_or("a refutation for Coq belongs to no claim")?;
    if records[record].verdict != Some(Verdict::Refuted) {
        return Err("it has a refutation for Coq and is not refuted".into());
    }
    Ok((record, write_refutation(refutation, paper, &out.join(COQ))?))
}

/// The folder of the refutations for Coq, below that of the run.
const COQ: &str = "coq";

/// Writes the file of a refutation into this folder.
fn write_refutation(refutation: &KernelRefutation, paper: &Paper, folder: &Path) -> Result<KernelTheorems, CheckError> {
    let claim = paper.claims.iter().find(|claim| claim.id == refutation.claim);
    let claim = claim.ok_or("a refutation for Coq belongs to no claim")?;
    let name = refutation.file_name();
    let said = format!("{} is false: {} ({})", claim.id, claim.statement, claim.place);
    let file = (refutation.file)(&said)?;
    let path = folder.to_path_buf();
    fs::create_dir_all(folder).map_err(|source| ReproduceError::Write { path, source })?;
    write(&folder.join(&name), file.text.as_bytes())?;
    Ok(KernelTheorems { file: format!("{COQ}/{name}"), theorems: file.theorems })
}

/// Writes the refutations for Coq of every paper into this folder, without checking a claim; how many there are.
///
/// # Errors
/// A file that could not be computed or written.
pub fn write_refutations(papers: &[Paper], folder: &Path) -> Result<usize, CheckError> {
    let mut count = 0;
    for paper in papers {
        for refutation in &paper.kernel {
            write_refutation(refutation, paper, folder)?;
            count += 1;
        }
    }
    Ok(count)
}

/// Why the claims named by a finding do not support it, if they do not.
fn unsupported(finding: &Finding, records: &[Record]) -> Option<String> {
    let mut rest = Vec::new();
    for id in finding.claims {
        match records.iter().find(|record| record.id == *id) {
            None => return Some(format!("the finding rests on {id:?}, which is no claim")),
            Some(record) => rest.push(record),
        }
    }
    let own = |record: &Record| Class::OWN.contains(&record.class);
    let (reproduced, refuted) = (Some(Verdict::Reproduced), Some(Verdict::Refuted));
    let decided = |record: &&Record| record.verdict.is_some();
    let (supported, wanted) = match finding.kind {
        Kind::Holds => (
            rest.iter().all(|record| record.verdict == reproduced) && rest.iter().any(|record| own(record)),
            "every claim to be reproduced, and one to be the paper's",
        ),
        Kind::Slip => (
            rest.iter().all(|record| match record.class {
                Class::Misprint => record.verdict != reproduced,
                class => class == Class::Reading,
            }),
            "misprints that are not reproduced, and readings",
        ),
        Kind::Wrong => {
            (rest.iter().any(|record| own(record) && record.verdict == refuted), "a claim of the paper that is refuted")
        }
        Kind::Open => (
            rest.iter().any(|record| record.verdict == Some(Verdict::Underspecified))
                && !rest.iter().any(|record| own(record) && record.verdict == refuted),
            "a claim that is underspecified, and none of the paper that is refuted",
        ),
        Kind::Beyond => (
            rest.iter().all(|record| record.class == Class::Ours && record.verdict == reproduced),
            "claims of ours that are reproduced",
        ),
    };
    let supported = supported && !rest.is_empty() && rest.iter().all(decided);
    (!supported).then(|| format!("the finding needs {wanted}"))
}

fn unique<'a>(ids: impl Iterator<Item = &'a str>) -> Result<(), ReproduceError> {
    let mut seen = HashSet::new();
    for id in ids {
        if !seen.insert(id) {
            return Err(ReproduceError::Duplicate { id: id.to_owned() });
        }
    }
    Ok(())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), ReproduceError> {
    fs::write(path, bytes).map_err(|source| ReproduceError::Write { path: path.to_path_buf(), source })
}
