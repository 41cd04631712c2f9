//! `luenberger new`: writes a commented study template.

use crate::answer::Answer;
use crate::arguments::NewInput;
use crate::failure::Failure;
use crate::output;
use luenberger_study::kinds::{Declaration, registry};
use luenberger_study::schema;
use luenberger_study::template::template;
use luenberger_study::{TEMPLATES, Template};
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
struct Written {
    study: String,
    files: Vec<String>,
}

#[derive(Serialize)]
struct Listed {
    plants: Vec<Plant>,
    observers: Vec<Observer>,
}

#[derive(Serialize)]
struct Observer {
    kind: &'static str,
    about: &'static str,
    source: &'static str,
}

#[derive(Serialize)]
struct Plant {
    name: &'static str,
    about: &'static str,
}

pub(crate) fn new(input: &NewInput) -> Result<Answer, Failure> {
    if input.list {
        return list();
    }
    let template = template(&input.plant)?;
    let Template { text, files, .. } = template;
    if input.output.as_os_str() == "-" {
        return Ok(Answer::new((*text).to_owned(), &Written { study: (*text).to_owned(), files: vec![] })?);
    }
    let write = |path: &Path, text: &str, force: bool| {
        output::file(path, text, force).map_err(|error| Failure::written(path, error))
    };
    let name = input.output.file_name().unwrap_or_default().to_string_lossy();
    write(&input.output, &template.text_of(&name), input.force)?;
    let folder = input.output.parent().unwrap_or(Path::new(""));
    let mut written = Vec::new();
    // Editors complete keys by the schema that the study names, which is that of this version.
    let file = folder.join("study.schema.json");
    let schema = schema::schema();
    if std::fs::read(&file).ok().as_deref() != Some(schema.as_bytes()) {
        write(&file, &schema, true)?;
        written.push(file.display().to_string());
    }
    for (name, text) in *files {
        let path = folder.join(name);
        write(&path, text, input.force)?;
        written.push(path.display().to_string());
    }
    let study = input.output.display().to_string();
    let mut text = format!("{study} is written; next: luenberger run {study}\n");
    for file in &written {
        text.extend(["with it: ", file, "\n"]);
    }
    Ok(Answer::new(text, &Written { study, files: written })?)
}

fn list() -> Result<Answer, Failure> {
    let width = TEMPLATES.iter().map(|template| template.name.len()).max().unwrap_or_default();
    let line = |template: &Template| format!("{:<width$}  {}\n", template.name, template.about);
    let kinds = registry();
    let longest = kinds.iter().map(|kind| kind.name.len()).max().unwrap_or_default();
    let of_kind = |&Declaration { name, about, source, plant, .. }: &&Declaration| {
        format!("{name:<longest$}  {about} Plants: {plant}. [{source}]\n")
    };
    let text = TEMPLATES
        .iter()
        .map(line)
        .chain(["\nkinds of observers, with their sources:\n\n".to_owned()])
        .chain(kinds.iter().map(of_kind))
        .collect();
    let observers =
        kinds.iter().map(|&&Declaration { name, about, source, .. }| Observer { kind: name, about, source }).collect();
    let plants = TEMPLATES.iter().map(|template| Plant { name: template.name, about: template.about }).collect();
    Ok(Answer::new(text, &Listed { plants, observers })?)
}
