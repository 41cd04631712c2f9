//! Parser from text to a study; every mistake is reported at its position.
//!
//! Three passes: syntax (`toml`, `json`), each key by itself (`check`, from the description in [`crate::schema`]), and
//! conditions on several keys: dimensions, alternatives, names. A later pass skips what an earlier one has reported, so
//! that each mistake is reported once.

mod advise;
mod angles;
mod csv;
mod delays;
mod estimate;
mod frequency;
mod json;
mod observer;
mod operating_point;
mod other_plant;
mod outline;
mod own;
mod plant;
mod sensor;
mod simulation_settings;
mod sweep;
mod toml;
mod truth;
mod tune;
mod tuned;
mod units;
mod varied;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use luenberger_lmi::Solver;

use crate::diagnostic::{Diagnostic, Diagnostics, Source};
use crate::error::StudyError;
use crate::model::PlantModel;
use crate::schema::STUDY;
use crate::study::{DataFiles, OtherPlant, Study};

use crate::reader::tree::{Node, Value};
use crate::reader::{Reader, Reported, check};
pub use crate::study::Format;
pub(crate) use observer::file_name;
use other_plant::Whose;
pub use outline::{OutlineStep, Outlined, outline};
pub(crate) use tuned::{Edit, Editable};
pub(crate) use varied::varied;

impl Study {
    /// Reads a study: JSON from `.json`, TOML from everything else.
    ///
    /// # Errors
    /// [`StudyError::Io`] for a file that cannot be read, [`StudyError::File`] with every mistake in it, by line and
    /// column.
    pub fn from_path(path: &Path) -> Result<Self, StudyError> {
        let text = std::fs::read_to_string(path).map_err(|error| StudyError::io(path, error))?;
        let json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Self::from_text(&path.to_string_lossy(), &text, if json { Format::Json } else { Format::Toml }, folder)
    }

    /// Parses the study in `text`; `name` is used in messages, and file names in the study are relative to `folder`.
    /// A study without a title is titled by its file name, or "study" if `name` is "standard input".
    ///
    /// ```
    /// use luenberger_study::{Format, Study, template};
    /// let text = template::text("double-integrator").ok_or("a template")?;
    /// let study = Study::from_text("study.toml", text, Format::Toml, ".".as_ref())?;
    /// assert_eq!(study.plant.states.len(), 2);
    ///
    /// let wrong = text.replace("poles =", "pols =");
    /// let error = Study::from_text("study.toml", &wrong, Format::Toml, ".".as_ref()).unwrap_err();
    /// assert!(error.to_string().contains("the nearest key is `poles`"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`StudyError::File`] with every mistake.
    pub fn from_text(name: &str, text: &str, format: Format, folder: &Path) -> Result<Self, StudyError> {
        study(name, text, format, &DataFiles::folder(folder))
    }

    /// As [`from_text`](Self::from_text), with the files that the study names in memory, by names relative to the
    /// study.
    ///
    /// ```
    /// use luenberger_study::{Format, Study, template};
    /// let template = template::template("measured-log")?;
    /// let files = template.files.iter().map(|(name, text)| ((*name).to_owned(), text.as_bytes().to_vec()));
    /// let study = Study::with_files("study.toml", template.text, Format::Toml, files.collect())?;
    /// assert_eq!(study.files[0].name, "measured-log.csv");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`StudyError::File`] with every mistake.
    pub fn with_files(
        name: &str,
        text: &str,
        format: Format,
        files: BTreeMap<String, Vec<u8>>,
    ) -> Result<Self, StudyError> {
        study(name, text, format, &DataFiles::Memory(Arc::new(files)))
    }
}

/// The name of a study that is not a file.
pub(crate) const STANDARD_INPUT: &str = "standard input";

/// The study in a text.
pub(crate) fn study(name: &str, text: &str, format: Format, data: &DataFiles) -> Result<Study, StudyError> {
    let source = Arc::new(Source::new(name, text));
    let (root, mut mistakes) = match format {
        Format::Toml => toml::tree(text),
        Format::Json => json::tree(text),
    };
    // After a syntax error the rest of the tree is unreliable.
    if mistakes.is_empty() {
        check::table(&root, &STUDY, &mut mistakes);
        let mut reader = Reader::new(data);
        let study = assemble(&root, &source, &mut reader);
        // What is missing where another key is unknown is most likely misspelt.
        let starts = starts(&root);
        let table = |mistake: &Diagnostic| starts.partition_point(|start| *start <= mistake.span.start);
        let spoilt: Vec<usize> = mistakes.iter().filter(|mistake| !mistake.is_absence).map(table).collect();
        // An invalid value of a key has been reported already.
        let said: Vec<Range<usize>> = mistakes.iter().map(|mistake| mistake.span.clone()).collect();
        let new = |mistake: &Diagnostic| {
            !said.iter().any(|span| span.start < mistake.span.end && mistake.span.start < span.end)
        };
        mistakes.extend(reader.mistakes.into_iter().filter(new));
        mistakes.extend(reader.absences.into_iter().filter(|absence| !spoilt.contains(&table(absence))));
        if let (Some(mut study), true) = (study, mistakes.is_empty()) {
            study.format = format;
            return Ok(study);
        }
        if mistakes.is_empty() {
            // Each missing part has been reported.
            mistakes.push(Diagnostic::new(0..0, "the study is incomplete", "expected a complete study"));
        }
    }
    Err(Diagnostics::new(source, mistakes).into())
}

/// The study in a changed text, without its log and what is done with it: a log need not be read again for a design.
///
/// # Errors
/// As [`Study::from_text`].
pub(crate) fn without_log(study: &Study, text: &str) -> Result<Study, StudyError> {
    let source = Arc::new(Source::new(study.source.name(), text));
    let (mut root, mut mistakes) = match study.format {
        Format::Toml => toml::tree(text),
        Format::Json => json::tree(text),
    };
    let mut found = None;
    if mistakes.is_empty() {
        check::table(&root, &STUDY, &mut mistakes);
        if let Value::Table(entries) = &mut root.value {
            entries.retain(|entry| !["log", "tune", "sweep"].contains(&entry.key.as_str()));
        }
        let mut reader = Reader::new(&study.data);
        found = assemble(&root, &source, &mut reader);
        mistakes.extend(reader.mistakes.into_iter().chain(reader.absences));
    }
    match (found, mistakes.is_empty()) {
        (Some(found), true) => Ok(Study { format: study.format, ..found }),
        _ => Err(Diagnostics::new(source, mistakes).into()),
    }
}

fn assemble(root: &Node, source: &Arc<Source>, reader: &mut Reader) -> Option<Study> {
    let base = plant::plant(root.get("plant")?, reader)?;
    let estimated = estimate::estimated(root, &base, reader)?;
    let plant = if estimated.is_empty() {
        base.clone()
    } else {
        estimate::with_states(root.get("plant")?, &base, &estimated, reader)?
    };
    let operating_point =
        root.get("operating_point").and_then(|node| operating_point::operating_point(node, &base, reader));
    let start =
        operating_point.as_ref().map_or_else(|| vec![0.0; base.states.len()], |point| point.x.as_slice().to_vec());
    let observers = observer::observers(root, (&base, &estimated), &start, source, reader);
    let input = simulation_settings::input(root.get("input"), (&base, &plant), observers.as_deref(), reader);
    let mut simulation = root.get("simulation").and_then(|node| simulation_settings::simulation(node, &base, reader));
    if let (Some(node), Some(input), Some(simulation)) = (root.get("input"), &input, &simulation) {
        simulation_settings::input_over(node, input, plant.inputs.len(), simulation, reader);
    }
    if let (Some(node), Some(simulation), Some(observers)) = (root.get("simulation"), &simulation, &observers) {
        simulation_settings::score_grid(node, simulation, observers, reader);
        simulation_settings::sampling_used(node, observers, reader);
    }
    let truth = match (root.get("truth"), &simulation) {
        (Some(node), Some(simulation)) => truth::truth((root, node), (&base, &estimated), simulation, reader),
        _ => None,
    };
    if let (None, Some(entry)) = (root.get("simulation"), root.entry("truth")) {
        reader.wrong(entry.span.clone(), "[truth] without a [simulation]", "expected a [simulation] of that plant");
    }
    if let Some(simulation) = &mut simulation {
        estimate::simulated(simulation, truth.as_ref(), &estimated);
    }
    let log = root.get("log").and_then(|node| simulation_settings::log(node, (&base, &estimated), reader));
    let advise = root.get("advise").and_then(|node| advise::advise(node, &base, simulation.as_ref(), reader));
    let tune = root
        .get("tune")
        .and_then(|node| tune::tune((root, node), (&base, &estimated, observers.as_deref(), log.as_ref()), reader));
    let frequency = root
        .get("frequency")
        .and_then(|node| frequency::frequency(node, &plant, (observers.as_deref(), input.as_ref()), reader));
    let plot = simulation_settings::plot(root.get("plot"), &plant, observers.as_deref(), reader);
    let sweep = root
        .get("sweep")
        .and_then(|node| sweep::sweep((root, node), observers.as_deref(), simulation.as_ref(), source, reader));
    let title = root.get("title").and_then(Node::text).map(str::to_owned);
    let stem = match source.name() {
        STANDARD_INPUT => None,
        path => Path::new(path).file_stem().map(|stem| stem.to_string_lossy().into_owned()),
    };
    Some(Study {
        title: title.or(stem).unwrap_or_else(|| "study".to_owned()),
        about: root.get("about").and_then(Node::text).unwrap_or_default().to_owned(),
        input: estimate::fed_back(input?, &estimated),
        operating_point: sound(root, "operating_point", operating_point).ok()?,
        simulation: sound(root, "simulation", simulation).ok()?,
        truth: sound(root, "truth", truth).ok()?,
        log: sound(root, "log", log).ok()?,
        observers: observers?,
        solver: match root.get("solver").and_then(Node::text) {
            Some("clarabel") => Solver::Clarabel,
            _ => Solver::Interior,
        },
        advise: sound(root, "advise", advise).ok()?,
        tune: sound(root, "tune", tune).ok()?,
        frequency: sound(root, "frequency", frequency).ok()?,
        plot: plot?,
        sweep: sound(root, "sweep", sweep).ok()?,
        data: reader.data.clone(),
        files: reader.files.clone(),
        format: Format::Toml,
        source: Arc::clone(source),
        plant,
        estimated,
    })
}

/// As [`ModelReader`](crate::reader::ModelReader).
fn model_of(
    root: &Node,
    change: &Node,
    known: &PlantModel,
    reader: &mut Reader,
) -> Result<Option<OtherPlant>, Reported> {
    let mut tree = root.get("plant").ok_or(Reported)?.clone();
    other_plant::changed(&mut tree, change, (known, &[]), Whose::Model, reader)
}

/// An absent table is allowed; a present one with mistakes is not.
fn sound<T>(root: &Node, key: &str, table: Option<T>) -> Result<Option<T>, Reported> {
    if table.is_none() && root.get(key).is_some() { Err(Reported) } else { Ok(table) }
}

/// Starts of the tables: those of the first level, and each element of an array of tables.
fn starts(root: &Node) -> Vec<usize> {
    let mut starts = Vec::new();
    for entry in root.entries() {
        starts.push(entry.span.start.min(entry.node.span.start));
        starts.extend(
            entry
                .node
                .list()
                .unwrap_or(&[])
                .iter()
                .filter(|node| !node.entries().is_empty())
                .map(|node| check::head(node).start),
        );
    }
    starts.sort_unstable();
    starts.dedup();
    starts
}
