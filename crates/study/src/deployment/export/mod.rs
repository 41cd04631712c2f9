//! An observer of a study as a folder of files for its target: source code, its test and its certificates.
//!
//! | file | subject |
//! |---|---|
//! | `options` | what is asked for, under the names of the command's options |
//! | `numbers` | the numbers on the target: floating or fixed point |
//! | `fmu` | the archive with the binaries that can be built here |
//! | `refusal` | why there is no export |

mod fmu;
mod numbers;
mod options;
mod refusal;

pub use options::{ExportOptions, Language, Libm, Precision};
pub use refusal::ExportRefusal;

use luenberger_clock::Instant;
use luenberger_export::{Export, File, sha256};
use luenberger_proof::certificate::CertificateFile;
use luenberger_proof::wording::counted;
use serde::Serialize;

use self::numbers::Numbers;
use super::closed_loop;
use super::{Compared, Difference, Sampled, evidence, exported, record, sampled_of};
use crate::error::StudyError;
use crate::results::NoObserver;
use crate::study::{ObserverSpec, Study};

/// An exported observer: its files, what is proved of them, and what a step costs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExportedObserver {
    /// The observer.
    #[serde(skip)]
    pub observer: String,
    /// Paths and contents of the files; the certificates are the last.
    #[serde(skip)]
    pub files: Vec<(String, Vec<u8>)>,
    /// Paths of the binaries in the archive of an FMU.
    pub binaries: Vec<String>,
    /// Why the archive of an FMU lacks binaries, and what the functions of the target's library cost.
    #[serde(skip)]
    pub notes: Vec<String>,
    /// The sampling period; of an observer at varying periods the nominal one.
    pub period: f64,
    /// Floating-point operations of a step, in fixed point products of integers.
    pub operations: usize,
    /// The most operations of a step without active bounds, of a moving-horizon estimator with bounds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub operations_within_bounds: Option<usize>,
    /// Bytes of constants and state.
    pub bytes: usize,
    /// Runge-Kutta steps per period, where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub substeps: Option<usize>,
    /// The distance of the exported estimates from those of the study's observer along its run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub difference: Option<Difference>,
    /// Whether stability is proved, with the feedback if there is one.
    pub proved: bool,
    /// What is proved of the stored numbers, and what is not covered.
    pub statement: Vec<String>,
    /// SHA-256 of the exported numbers.
    pub digest: String,
    /// What a step costs, in words.
    #[serde(skip)]
    pub cost: String,
}

impl ExportedObserver {
    /// The export in words, with its files in a folder of this name: one line for each file, what a step costs, and
    /// what is proved.
    pub fn in_words(&self, folder: &str) -> String {
        let mut text = format!("{} in {folder}:\n", self.observer);
        for (name, _) in &self.files {
            text.extend(["  ", name, "\n"]);
        }
        for path in &self.binaries {
            text.extend(["  with ", path, "\n"]);
        }
        for sentence in std::iter::once(&self.cost).chain(&self.statement) {
            text.extend([sentence.as_str(), "\n"]);
        }
        text
    }
}

/// An observer of a study, sampled, and the program of its step.
pub(crate) struct Prepared {
    pub(crate) sampled: Sampled,
    numbers: Numbers,
    pub(crate) export: Export,
}

/// The files of the observer of that name as code for its target; without a name, of the only observer.
///
/// The step is the sampled design of the observer: what is proved of it counts the bounds that states, inputs and noise
/// have in the simulation of the study, and it is compared with the observer of the study along that run.
///
/// ```
/// use luenberger_study::deployment::{ExportOptions, export};
/// use luenberger_study::{Format, Study};
/// let text = "
/// [plant]
/// a = [[0, 1], [0, 0]]
/// c = [[1, 0]]
/// [[observer]]
/// name = \"fast\"
/// kind = \"luenberger\"
/// poles = [-4, -5]
/// ";
/// let study = Study::from_text("study.toml", text, Format::Toml, ".".as_ref())?;
/// let exported = export(&study, None, &ExportOptions::default().period(0.01))?;
/// assert!(exported.proved && exported.files.iter().any(|(name, _)| name == "fast.c"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// # Errors
/// [`ExportRefusal`].
pub fn export(
    study: &Study,
    name: Option<&str>,
    options: &ExportOptions<'_>,
) -> Result<ExportedObserver, ExportRefusal> {
    let observer = chosen(study, name)?;
    let Prepared { sampled, numbers, export } = prepared((study, observer), options, None, None)?;
    let refused = |error| ExportRefusal::numbers(observer, error);
    numbers.check(&export).map_err(refused)?;
    let (design, formats) = (&sampled.design, numbers.formats());
    let mut evidence = evidence(study, observer, design, formats);
    let of_the_loop = if options.feedback {
        let k = closed_loop::gain(study, observer).map_err(|why| ExportRefusal::design(observer, why))?;
        Some((k, closed_loop::evidence(study, observer, design, k, formats.stored)))
    } else {
        None
    };
    let unproved = match &of_the_loop {
        _ if !evidence.is_proved() => Some(numbers.unproved()),
        Some((_, of_the_loop)) if !of_the_loop.is_proved() => {
            Some("its feedback has no stability certificate".to_owned())
        }
        _ => None,
    };
    let proved = unproved.is_none();
    if let (Some(why), false) = (unproved, options.unproved) {
        return Err(ExportRefusal::Unproved { observer: observer.name.clone(), why });
    }
    let mut certificates: Vec<(String, Vec<u8>)> = Vec::new();
    let mut keep = |name: &str, file: Option<&CertificateFile>| {
        certificates.extend(file.map(|file| (name.to_owned(), file.to_json().into_bytes())));
    };
    keep("certificate.json", evidence.file.as_ref());
    let gain = of_the_loop.map(|(k, of_the_loop)| {
        keep("certificate-feedback.json", of_the_loop.file.as_ref());
        evidence.sentences.extend(of_the_loop.sentences);
        k
    });
    let record = record(study, observer, &sampled).unwrap_or_default();
    let replayed = numbers.replay(&export, &record.samples).map_err(refused)?;
    let difference = record.difference(&replayed);
    let format = numbers.name();
    let saturated = numbers.saturated(&export, &record.samples).map_err(refused)?;
    let said = Compared { format: &format, step: export.identifier(), saturated };
    evidence.sentences.extend(difference.as_ref().map(|all| all.words(study, observer, &said)));
    let export = export
        .test_steps(options.test_steps)
        .samples(record.samples)
        .statement(&evidence.sentences)
        .source("the study", &sha256(study.source.text().as_bytes()));
    let export = certificates.iter().fold(export, |export, (name, bytes)| export.source(name, &sha256(bytes)));
    let export = gain.map_or(Ok(export.clone()), |k| export.with_feedback(k)).map_err(refused)?;
    let cost = numbers.cost(&export).map_err(refused)?;
    let bytes = |files: Vec<File>| files.into_iter().map(|file| (file.name, file.text.into_bytes()));
    let of_target = options.libm == Libm::Target;
    let export = if of_target { export.with_functions_of_target() } else { export };
    let (mut files, mut binaries, mut notes) = (Vec::new(), Vec::new(), Vec::new());
    if of_target {
        notes.push(export.functions().unwrap_or_else(|| {
            format!("{} calls no elementary function: --libm target changes nothing", observer.name)
        }));
    }
    match options.to {
        Language::C => files.extend(bytes(numbers.c(&export, options.layout).map_err(refused)?)),
        Language::Rust => files.extend(bytes(export.rust().map_err(refused)?)),
        Language::Fmu => {
            let fmu = fmu::files(&export, options.version(), &certificates).map_err(refused)?;
            files.push(fmu.archive);
            files.extend(bytes(fmu.texts));
            (binaries, notes) = (fmu.binaries, fmu.notes);
        }
    }
    if options.substeps.is_some() && sampled.design.substeps().is_none() {
        notes.push(format!("--substeps changes nothing: the step of {} has no Runge-Kutta steps", observer.name));
    }
    files.extend(certificates);
    let (substeps, within_bounds) = (sampled.design.substeps(), export.operations_within_bounds());
    let unit = study.plant.time_unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
    let words = format!(
        "{} {}{unit}{}: {}{} {}{}, {} bytes of constants and state ({format})",
        if export.observer().takes_time() { "one step for each sample, nominally every" } else { "one step every" },
        export.observer().period(),
        substeps.map(|count| format!(" with {}", counted(count, "Runge-Kutta step"))).unwrap_or_default(),
        if export.stack_of_window().is_some() { "at most " } else { "" },
        cost.operations,
        cost.of,
        within_bounds.map(|count| format!(" ({count} without active bounds)")).unwrap_or_default(),
        cost.bytes,
    );
    Ok(ExportedObserver {
        observer: observer.name.clone(),
        files,
        binaries,
        notes,
        period: export.observer().period(),
        operations: cost.operations,
        operations_within_bounds: within_bounds,
        bytes: cost.bytes,
        substeps,
        difference,
        proved,
        statement: evidence.sentences,
        digest: cost.digest,
        cost: words,
    })
}

/// The program of the step that [`export`] prints, without its evidence, from the estimate of the study or another one.
///
/// # Errors
/// [`ExportRefusal`].
pub fn program(
    study: &Study,
    name: Option<&str>,
    options: &ExportOptions<'_>,
    initial: Option<&[f64]>,
) -> Result<Export, ExportRefusal> {
    prepared((study, chosen(study, name)?), options, initial, None).map(|prepared| prepared.export)
}

/// The same of an observer beside the study, whose design begins before the instant `end`, if there is one.
pub(crate) fn prepared(
    (study, observer): (&Study, &ObserverSpec),
    options: &ExportOptions<'_>,
    initial: Option<&[f64]>,
    end: Option<Instant>,
) -> Result<Prepared, ExportRefusal> {
    let numbers = Numbers::of(options)?;
    let refused = |why| ExportRefusal::design(observer, why);
    if options.feedback {
        closed_loop::gain(study, observer).map_err(refused)?;
    }
    // The period of a sampled observer is its own; a hold of the simulation does not conflict with it.
    let hold = study.simulation.as_ref().filter(|_| observer.kind.period().is_none());
    let period = options.period.or_else(|| hold.and_then(|simulation| simulation.hold));
    let sampled = sampled_of((study, observer, options.designed), period, options.substeps, end).map_err(refused)?;
    let is_fixed = matches!(numbers, Numbers::Fixed(_));
    if sampled.design.is_of_sample(observer) && (options.feedback || is_fixed) {
        let predicted = if options.feedback { "the feedback" } else { "fixed point" };
        let hypothesis = format!("it is in filter form, and {predicted} takes the prediction");
        let has_form = observer.kind.whole_gain().is_some();
        let hint = if has_form { "form = \"predictor\"" } else { "an observer of the whole state that predicts" };
        return Err(refused(NoObserver::new(hypothesis).hint(hint)));
    }
    sampled.design.stored_in(observer, numbers.formats().stored).map_err(refused)?;
    let export = exported(study, observer, sampled.design.clone(), numbers.scalar(), initial);
    Ok(Prepared { export: export.map_err(|error| ExportRefusal::numbers(observer, error))?, sampled, numbers })
}

/// The observer of that name; without a name the only one.
pub(crate) fn chosen<'a>(study: &'a Study, name: Option<&str>) -> Result<&'a ObserverSpec, ExportRefusal> {
    let known = || study.observers.iter().map(|observer| observer.name.clone()).collect::<Vec<_>>().join(", ");
    match (name, &study.observers[..]) {
        (_, []) => Err(StudyError::Missing { step: "export", needs: "an [[observer]]" }.into()),
        (Some(name), _) => {
            let unknown = || ExportRefusal::UnknownObserver { name: name.to_owned(), known: known() };
            study.observer(name).ok_or_else(unknown)
        }
        (None, [only]) => Ok(only),
        (None, _) => Err(ExportRefusal::SeveralObservers { known: known() }),
    }
}
