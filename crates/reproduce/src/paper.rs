//! A paper: its claims, figures and errata.
//!
//! # Adding a figure
//! ```
//! use luenberger_reproduce::{CheckError, Context, Drawing, Figure, Panel, Plate, Series, Mark, Table};
//!
//! const DECAY: Drawing = Drawing { id: "demo-fig1", draw: decay };
//!
//! fn decay(_: &Context) -> Result<Plate, CheckError> {
//!     let t: Vec<f64> = (0..=400).map(|k| f64::from(k) / 100.0).collect();
//!     let [slow, fast] = [1.0, 2.0].map(|rate| t.iter().map(|t| f64::exp(-rate * t)).collect::<Vec<_>>());
//!     let panel = Panel::new("time t (s)", "error e₂ (rad)")
//!         .series(Series::line("linear", &t, &slow))
//!         .series(Series::line("cubic", &t, &fast))
//!         .mark(Mark::horizontal(0.05).label("5 %"));
//!     Ok(Plate {
//!         figure: Figure::new("Decay of the error").caption("The two observers from e(0) = 1.").panel(panel),
//!         data: Table::new().column("t", t).column("e2_linear", slow).column("e2_cubic", fast),
//!     })
//! }
//! decay(&Context::new(".")).unwrap().figure.check().unwrap();
//! ```

use luenberger_live::Experiment;
use luenberger_proof::coq::CoqFile;

use crate::claim::{CheckError, Claim};
use crate::context::Context;
use crate::figure::Figure;
use crate::table::Table;

/// One paper.
#[derive(Debug, Clone)]
pub struct Paper {
    /// Short name, the first part of every id: `cubic`.
    pub key: &'static str,
    /// Its title.
    pub title: &'static str,
    /// What it is about, in a few words: "the cubic observer".
    pub short: &'static str,
    /// Authors, journal, year.
    pub citation: &'static str,
    /// Its claims, in the order of the paper.
    pub claims: Vec<Claim>,
    /// The figures, in the order of the report.
    pub figures: Vec<Drawing>,
    /// Numbers without a picture, in the order of the report.
    pub datasets: Vec<Dataset>,
    /// Experiments that the page of the report runs itself.
    pub live: Vec<LiveExample>,
    /// Refutations that the kernel of Coq checks.
    pub kernel: Vec<KernelRefutation>,
    /// What it comes to: what holds, what is a slip of the pen, what is wrong.
    pub findings: Vec<Finding>,
}

/// The refutation of a claim as a file for the proof assistant Coq, whose theorems are about the claim's own numbers.
/// `cargo xtask kernel` writes these files and has each checked; the ledger marks the claims.
#[derive(Debug, Clone, Copy)]
pub struct KernelRefutation {
    /// The id of the claim, which has to be refuted.
    pub claim: &'static str,
    /// Writes the file; the text is for its head.
    pub file: fn(&str) -> Result<CoqFile, CheckError>,
}

impl KernelRefutation {
    /// The name of the file, `cubic_thm2_strict.v` for the claim `cubic.thm2.strict`: that of a module.
    pub fn file_name(&self) -> String {
        format!("{}.v", self.claim.replace(['.', '-'], "_"))
    }
}

/// An experiment with sliders.
#[derive(Debug, Clone)]
pub struct LiveExample {
    /// Its id in the page.
    pub id: &'static str,
    /// Its title.
    pub title: &'static str,
    /// What to try, in a sentence or two.
    pub about: &'static str,
    /// Designs the observers.
    pub experiment: fn() -> Result<Experiment, CheckError>,
}

/// A figure to be drawn.
#[derive(Debug, Clone)]
pub struct Drawing {
    /// Name of the files: `cubic-fig4` gives `figures/cubic-fig4.svg`, `.png` and `data/cubic-fig4.csv`.
    pub id: &'static str,
    /// Computes and describes it.
    pub draw: fn(&Context) -> Result<Plate, CheckError>,
}

/// Numbers to be written: trajectories that a reader may want to compute with.
#[derive(Debug, Clone)]
pub struct Dataset {
    /// Name of the file: `mvt-ex1-eta1-e0` gives `data/mvt-ex1-eta1-e0.csv`.
    pub id: &'static str,
    /// Computes the columns, given the name.
    pub tabulate: fn(&Context, &str) -> Result<Table, CheckError>,
}

/// A figure with the numbers behind it.
#[derive(Debug, Clone)]
pub struct Plate {
    /// The picture.
    pub figure: Figure,
    /// The numbers, one column per curve, written as CSV.
    pub data: Table,
}

/// What a paper comes to in one point. Its evidence is the claims it names: the report shows their numbers, and a
/// finding that they do not support is an error of the run.
#[derive(Debug, Clone, Copy)]
pub struct Finding {
    /// What it says of the paper.
    pub kind: Kind,
    /// A headline; of a slip of the pen, with its correction.
    pub title: &'static str,
    /// What is printed, where, and what holds instead.
    pub statement: &'static str,
    /// Ids of the claims that show it.
    pub claims: &'static [&'static str],
}

/// What a finding says of the paper, and what its claims have to be for that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// It holds: every claim is reproduced, one at least the paper's own.
    Holds,
    /// A slip of the pen: every claim is a misprint that is refuted or leaves the choice, or a reading.
    Slip,
    /// It is wrong: one of the paper's own claims is refuted.
    Wrong,
    /// It depends on how the paper is read, or on what it does not print: one claim is underspecified, none of the
    /// paper's own is refuted.
    Open,
    /// Not in the paper: every claim is ours and reproduced.
    Beyond,
}

impl Kind {
    /// In the order of the report.
    pub const ALL: [Self; 5] = [Self::Holds, Self::Slip, Self::Wrong, Self::Open, Self::Beyond];

    /// The head of the list in the report.
    pub fn heading(self) -> &'static str {
        match self {
            Self::Holds => "Holds",
            Self::Slip => "Slips of the pen, corrected",
            Self::Wrong => "Wrong",
            Self::Open => "Depends on the reading",
            Self::Beyond => "Beyond the paper",
        }
    }
}
