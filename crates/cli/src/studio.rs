//! `luenberger studio`: the studio as a page.

use crate::answer::Answer;
use crate::arguments::StudioInput;
use crate::failure::Failure;
use crate::output;
use luenberger_study::execute::bytes;
use serde::Serialize;

#[derive(Serialize)]
struct Written {
    page: String,
    bytes: usize,
}

pub(crate) fn studio(input: &StudioInput) -> Result<Answer, Failure> {
    let page = luenberger_studio::page();
    output::file(&input.output, &page, input.force).map_err(|error| Failure::written(&input.output, error))?;
    let path = input.output.display().to_string();
    if input.open
        && let Err(error) = open::that_detached(&input.output)
    {
        output::say(&format!("note: {path} cannot be opened: {error}"));
    }
    let text = format!("{path}: the studio, one page of {}\n", bytes(page.len() as f64));
    Ok(Answer::new(text, &Written { page: path, bytes: page.len() })?)
}
