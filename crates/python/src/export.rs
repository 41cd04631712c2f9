//! An observer as source code for the target.

use luenberger_export::fmu::{Version, compilers};
use luenberger_export::{Export, ExportError, File, Scalar, golden};
use luenberger_proof::statement::Format;
use luenberger_study::Study;
use luenberger_study::deployment::{SampledDesign, evidence, exported, record, sampled};
use luenberger_study::results::FailureReport;
use luenberger_study::study::ObserverSpec;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error::{self, dictionary};

/// What is to be exported.
pub(crate) struct Request {
    pub(crate) to: String,
    pub(crate) period: Option<f64>,
    pub(crate) substeps: Option<usize>,
    pub(crate) is_single: bool,
    pub(crate) unproved: bool,
}

/// Why there is no export.
pub(crate) enum Refusal {
    Misfit(Box<FailureReport>),
    Export(Box<ExportError>),
    Unproved(Vec<String>),
    Target(String),
}

impl From<FailureReport> for Refusal {
    fn from(why: FailureReport) -> Self {
        Self::Misfit(Box::new(why))
    }
}

impl From<ExportError> for Refusal {
    fn from(why: ExportError) -> Self {
        Self::Export(Box::new(why))
    }
}

impl Refusal {
    pub(crate) fn raised(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Misfit(why) if why.cause.is_some() => error::design(py, &why),
            Self::Misfit(why) => error::plain(py, "ExportRefused", why.hypothesis),
            Self::Export(why) => error::plain(py, "ExportRefused", why),
            Self::Unproved(sentences) => error::plain(
                py,
                "ExportRefused",
                format!("{} unproved=True exports it all the same, and the header says so", sentences.join(" ")),
            ),
            Self::Target(to) => {
                error::plain(py, "InvalidArgument", format!("to is {to:?}; it must be 'c', 'rust' or 'fmu'"))
            }
        }
    }
}

/// The files of an export.
pub(crate) struct Exported {
    files: Vec<(String, Vec<u8>)>,
    statement: Vec<String>,
    proved: bool,
    period: f64,
    operations: usize,
    bytes: usize,
}

impl Exported {
    pub(crate) fn dictionary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let files = PyDict::new(py);
        for (name, content) in &self.files {
            files.set_item(name, PyBytes::new(py, content))?;
        }
        let (statement, proved) = (&self.statement, self.proved);
        Ok(dictionary!(py; files, statement, proved, period = self.period, operations = self.operations,
            bytes = self.bytes))
    }
}

/// The export of a sampled design in double or single precision.
pub(crate) fn prepared(
    study: &Study,
    observer: &ObserverSpec,
    design: SampledDesign,
    is_single: bool,
    initial: Option<&[f64]>,
) -> Result<Export, Refusal> {
    let scalar = if is_single { Scalar::Binary32 } else { Scalar::Binary64 };
    Ok(exported(study, observer, design, scalar, initial)?)
}

pub(crate) fn export(study: &Study, request: &Request) -> Result<Exported, Refusal> {
    if !["c", "rust", "fmu"].contains(&request.to.as_str()) {
        return Err(Refusal::Target(request.to.clone()));
    }
    let observer = &study.observers[0];
    let sampled = sampled(study, observer, request.period, request.substeps)?;
    let format = if request.is_single { Format::Binary32 } else { Format::Binary64 };
    sampled.design.stored_in(observer, format)?;
    let export = prepared(study, observer, sampled.design.clone(), request.is_single, None)?;
    let evidence = evidence(study, observer, &sampled.design, format.into());
    if !(evidence.is_proved() || request.unproved) {
        return Err(Refusal::Unproved(evidence.sentences));
    }
    let record = record(study, observer, &sampled).unwrap_or_default();
    let exported = golden::replay(&export, &record.samples)?;
    let mut statement = evidence.sentences;
    statement.extend(record.difference(&exported).map(|all| all.words(study, observer, export.scalar().name())));
    let mut export = export.samples(record.samples).statement(&statement);
    export = export.source("the study", &luenberger_export::sha256(study.source.text().as_bytes()));
    let mut certificates = Vec::new();
    if let Some(file) = &evidence.file {
        let bytes = file.to_json().into_bytes();
        export = export.source("certificate.json", &luenberger_export::sha256(&bytes));
        certificates.push(("certificate.json".to_owned(), bytes));
    }
    let texts = |files: Vec<File>| files.into_iter().map(|file| (file.name, file.text.into_bytes()));
    let mut files: Vec<_> = match request.to.as_str() {
        "c" => texts(export.c()?).collect(),
        "rust" => texts(export.rust()?).collect(),
        _ => fmu(&export, &certificates)?,
    };
    files.extend(certificates);
    let (operations, bytes) = (export.operations(), export.bytes());
    Ok(Exported { files, statement, proved: evidence.file.is_some(), period: sampled.period, operations, bytes })
}

/// The archive, with a binary for each platform that a compiler of this machine builds for, and its test.
fn fmu(export: &Export, certificates: &[(String, Vec<u8>)]) -> Result<Vec<(String, Vec<u8>)>, Refusal> {
    let mut fmu = export.fmu(Version::Two)?;
    for (name, bytes) in certificates {
        fmu.add(&format!("documentation/{name}"), bytes.clone());
    }
    for compiler in &compilers() {
        let scratch = std::env::temp_dir().join(format!("luenberger-{}-{}", std::process::id(), compiler.platform));
        // Without a binary the archive has its sources.
        if std::fs::create_dir_all(&scratch).is_ok() {
            _ = fmu.compile(compiler, &scratch);
        }
        _ = std::fs::remove_dir_all(&scratch);
    }
    let mut files = vec![(fmu.file_name(), fmu.archive()?)];
    files.extend(export.fmu_test()?.into_iter().map(|file| (file.name, file.text.into_bytes())));
    Ok(files)
}
