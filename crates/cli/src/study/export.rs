//! `luenberger export`: an observer of a study as source code for the target.

use super::export_fmu;
use super::export_numbers::Numbers;
use super::file::{read, renamed};
use crate::answer::Answer;
use crate::arguments::{ExportInput, FmiVersion, Language};
use crate::failure::Failure;
use crate::input::Source;
use luenberger_export::names;
use luenberger_proof::certificate::CertificateFile;
use luenberger_proof::wording::counted;
use luenberger_study::closed_loop;
use luenberger_study::deployment::{Difference, evidence, exported, record, sampled};
use luenberger_study::results::FailureReport;
use luenberger_study::study::ObserverSpec;
use luenberger_study::{Study, StudyError, write_folder};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(Serialize)]
struct Written {
    observer: String,
    folder: String,
    files: Vec<String>,
    binaries: Vec<String>,
    period: f64,
    operations: usize,
    /// The most operations of a step without active bounds, of a moving-horizon estimator with bounds.
    #[serde(skip_serializing_if = "Option::is_none")]
    operations_within_bounds: Option<usize>,
    bytes: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    substeps: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    difference: Option<Distance>,
    proved: bool,
    statement: Vec<String>,
    digest: String,
}

/// Distance of the exported estimates from those of the study's observer along its run, for each state.
#[derive(Serialize)]
struct Distance {
    largest: Vec<f64>,
    second_half: Vec<f64>,
    own_error_in_second_half: Vec<f64>,
}

pub(crate) fn export(input: &ExportInput) -> Result<Answer, Failure> {
    if input.fmi.is_some() && !matches!(input.to, Language::Fmu) {
        return Err(Failure::Usage("--fmi is for --to fmu"));
    }
    let numbers = Numbers::of(input)?;
    let study = read(&input.study)?;
    let observer = chosen(&study, input.observer.as_deref())?;
    let not_exported = |why: FailureReport| Failure::NotExported {
        observer: observer.name.clone(),
        advice: why.advice(),
        why: why.hypothesis,
    };
    let gain = if input.feedback { Some(closed_loop::gain(&study, observer).map_err(not_exported)?) } else { None };
    let period = input.period.or_else(|| study.simulation.as_ref().and_then(|simulation| simulation.hold));
    // The period of a sampled observer is its own; a hold of the simulation does not conflict with it.
    let period = if observer.kind.period().is_some() { input.period } else { period };
    let sampled = sampled(&study, observer, period, input.substeps.map(usize::from)).map_err(not_exported)?;
    let design = sampled.design.clone();
    let predicted = if input.feedback { "the feedback" } else { "fixed point" };
    if design.update_gain(observer).is_some() && (input.feedback || matches!(numbers, Numbers::Fixed(_))) {
        let hypothesis = format!("it is in filter form, and {predicted} takes the prediction");
        return Err(not_exported(FailureReport::new(hypothesis, observer.place.line).hint("form = \"predictor\"")));
    }
    let formats = numbers.formats();
    design.stored_in(observer, formats.stored).map_err(not_exported)?;
    let refused = |error| Failure::Export { observer: observer.name.clone(), error: Box::new(error) };
    let substeps = design.substeps();
    let export = exported(&study, observer, design.clone(), numbers.scalar(), None).map_err(refused)?;
    numbers.check(&export).map_err(refused)?;
    let mut evidence = evidence(&study, observer, &design, formats);
    let of_the_loop = gain.map(|k| closed_loop::evidence(&study, observer, &design, k, formats.stored));
    let unproved = match &of_the_loop {
        _ if !evidence.is_proved() => Some(numbers.unproved()),
        Some(of_the_loop) if !of_the_loop.is_proved() => Some("its feedback has no stability certificate".to_owned()),
        _ => None,
    };
    let proved = unproved.is_none();
    if let (Some(why), false) = (unproved, input.unproved) {
        return Err(Failure::NotExported {
            observer: observer.name.clone(),
            why,
            advice: vec!["hint: --unproved exports it all the same, and the header says so".to_owned()],
        });
    }
    let mut certificates: Vec<(String, Vec<u8>)> = Vec::new();
    let mut keep = |name: &str, file: Option<&CertificateFile>| {
        certificates.extend(file.map(|file| (name.to_owned(), file.to_json().into_bytes())));
    };
    keep("certificate.json", evidence.file.as_ref());
    if let Some(of_the_loop) = of_the_loop {
        keep("certificate-feedback.json", of_the_loop.file.as_ref());
        evidence.sentences.extend(of_the_loop.sentences);
    }
    let digest = study_digest(&study);
    let record = record(&study, observer, &sampled).unwrap_or_default();
    let exported = numbers.replay(&export, &record.samples).map_err(refused)?;
    let difference = record.difference(&exported);
    let format_name = numbers.name();
    evidence.sentences.extend(difference.as_ref().map(|all| all.words(&study, observer, &format_name)));
    let export = export
        .test_steps(input.test_steps.into())
        .samples(record.samples)
        .statement(&evidence.sentences)
        .source("the study", &digest);
    let export = certificates
        .iter()
        .fold(export, |export, (name, bytes)| export.source(name, &luenberger_export::sha256(bytes)));
    let export = gain.map_or(Ok(export.clone()), |k| export.with_feedback(k)).map_err(refused)?;
    let cost = numbers.cost(&export).map_err(refused)?;
    let bytes = |files: Vec<luenberger_export::File>| {
        files.into_iter().map(|file| (file.name, file.text.into_bytes())).collect::<Vec<_>>()
    };
    let mut binaries = Vec::new();
    let files = match input.to {
        Language::C => numbers.c(&export).map(bytes),
        Language::Rust => export.rust().map(bytes),
        Language::Fmu => export_fmu::files(&export, input.fmi.unwrap_or(FmiVersion::Two), &certificates).map(|fmu| {
            binaries = fmu.binaries;
            fmu.files
        }),
    };
    let mut files = files.map_err(refused)?;
    files.extend(certificates);
    let folder = folder(input, observer);
    let moved = write_folder(&folder, input.force, "export", &study, &files)?;
    renamed(&folder, &moved);

    let names: Vec<String> = files.iter().map(|(name, _)| name.clone()).collect();
    let mut text = format!("{} in {}:\n", observer.name, folder.display());
    for name in &names {
        _ = writeln!(text, "  {name}");
    }
    for path in &binaries {
        _ = writeln!(text, "  with {path}");
    }
    let written = Written {
        observer: observer.name.clone(),
        folder: folder.display().to_string(),
        files: names,
        binaries,
        period: export.observer().period(),
        operations: cost.operations,
        operations_within_bounds: export.operations_within_bounds(),
        bytes: cost.bytes,
        substeps,
        difference: difference.map(|Difference { largest, late, own }| Distance {
            largest,
            second_half: late,
            own_error_in_second_half: own,
        }),
        proved,
        statement: evidence.sentences.clone(),
        digest: cost.digest,
    };
    let unit = study.plant.time_unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
    _ = writeln!(
        text,
        "{} {}{unit}{}: {}{} {}{}, {} bytes of constants and state ({})",
        if export.observer().takes_time() { "one step for each sample, nominally every" } else { "one step every" },
        written.period,
        substeps.map(|count| format!(" with {}", counted(count, "Runge-Kutta step"))).unwrap_or_default(),
        if export.stack_of_window().is_some() { "at most " } else { "" },
        written.operations,
        cost.of,
        written.operations_within_bounds.map(|count| format!(" ({count} without active bounds)")).unwrap_or_default(),
        written.bytes,
        format_name
    );
    for sentence in &evidence.sentences {
        text.extend([sentence.as_str(), "\n"]);
    }
    Ok(Answer::new(text, &written)?)
}

/// The observer of that name; without a name the only one.
fn chosen<'a>(study: &'a Study, name: Option<&str>) -> Result<&'a ObserverSpec, Failure> {
    let names = || study.observers.iter().map(|observer| observer.name.clone()).collect::<Vec<_>>().join(", ");
    match (name, &study.observers[..]) {
        (_, []) => Err(StudyError::Missing { step: "export", needs: "an [[observer]]" }.into()),
        (Some(name), _) => {
            let unknown = || Failure::UnknownObserver { name: name.to_owned(), known: names() };
            study.observer(name).ok_or_else(unknown)
        }
        (None, [only]) => Ok(only),
        (None, _) => Err(Failure::SeveralObservers { known: names() }),
    }
}

fn study_digest(study: &Study) -> String {
    luenberger_export::sha256(study.source.text().as_bytes())
}

/// The folder given, or by default `study-NAME-c`.
fn folder(input: &ExportInput, observer: &ObserverSpec) -> PathBuf {
    let stem = match &input.study {
        Source::File(path) => path.file_stem().map(|stem| stem.to_string_lossy().into_owned()),
        Source::Standard => None,
    };
    let language = match input.to {
        Language::C => "c",
        Language::Rust => "rust",
        Language::Fmu => "fmu",
    };
    let name = names::identifier(&observer.name);
    let beside = || PathBuf::from(format!("{}-{name}-{language}", stem.unwrap_or_else(|| "study".to_owned())));
    input.output.clone().unwrap_or_else(beside)
}
