//! `luenberger import`: creates a study file from a model.

use crate::answer::Answer;
use crate::arguments::ImportInput;
use crate::failure::Failure;
use crate::output;
use luenberger_proof::wording::counted;
use serde::Serialize;

#[derive(Serialize)]
struct Imported<'a> {
    /// The file written, or the text itself if the output is standard output.
    study: String,
    states: usize,
    inputs: usize,
    outputs: usize,
    ignored: &'a [String],
}

pub(crate) fn import(input: &ImportInput) -> Result<Answer, Failure> {
    let origin = input.model.display().to_string();
    let model = luenberger_study::import::import(&input.model).map_err(|error| Failure::Import { origin, error })?;
    let title = input.model.file_stem().map_or_else(|| "model".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let study = model.study(&title);
    let (states, inputs, outputs) = (model.a.nrows(), model.b.ncols(), model.c.nrows());
    let is_standard = input.output.as_os_str() == "-";
    if !is_standard {
        output::file(&input.output, &study, input.force).map_err(|error| Failure::written(&input.output, error))?;
    }
    let text = if is_standard {
        study.clone()
    } else {
        let ignored = match model.ignored.len() {
            0 => String::new(),
            _ => format!("not used: {}\n", model.ignored.join(", ")),
        };
        let path = input.output.display();
        let sizes =
            [(states, "state"), (inputs, "input"), (outputs, "output")].map(|(number, what)| counted(number, what));
        format!("{path}: {}\n{ignored}", sizes.join(", "))
    };
    let study = if is_standard { study } else { input.output.display().to_string() };
    Ok(Answer::new(text, &Imported { study, states, inputs, outputs, ignored: &model.ignored })?)
}
