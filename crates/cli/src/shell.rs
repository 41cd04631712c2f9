//! What a shell and `man` need: completions, manual pages.

use crate::answer::Answer;
use crate::arguments::Arguments;
use crate::failure::Failure;
use clap::{Command, CommandFactory};
use clap_complete::Shell;
use luenberger_proof::wording::counted;
use serde_json::json;
use std::fs;
use std::path::Path;

/// The script with which a shell completes the arguments.
pub(crate) fn completions(shell: Shell) -> Answer {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "luenberger", &mut script);
    let script = String::from_utf8_lossy(&script).into_owned();
    let json = json!({ "shell": shell.to_string(), "script": script }).to_string();
    Answer::written(script, json)
}

/// The manual pages: `luenberger.1`, `luenberger-run.1`, ...
pub(crate) fn manual(folder: &Path) -> Result<Answer, Failure> {
    fs::create_dir_all(folder).map_err(|error| Failure::written(folder, error))?;
    let mut files = Vec::new();
    let mut command = Arguments::command().disable_help_subcommand(true);
    command.build();
    pages(&command, folder, &mut files)?;
    let json = json!({ "folder": folder.display().to_string(), "files": files }).to_string();
    Ok(Answer::written(format!("{} in {}\n", counted(files.len(), "page"), folder.display()), json))
}

fn pages(command: &Command, folder: &Path, files: &mut Vec<String>) -> Result<(), Failure> {
    let name = command.get_display_name().unwrap_or_else(|| command.get_name()).to_owned();
    let file = format!("{name}.1");
    let path = folder.join(&file);
    let page = clap_mangen::Man::new(command.clone());
    let mut text = Vec::new();
    page.render(&mut text).and_then(|()| fs::write(&path, text)).map_err(|error| Failure::written(&path, error))?;
    files.push(file);
    command.get_subcommands().try_for_each(|command| pages(command, folder, files))
}
