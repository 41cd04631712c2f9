//! `columns`: what a log has, and the table of a study that reads it.

use std::fmt::Write;

use luenberger_study::Study;
use luenberger_study::table::Table;
use serde_json::{Value, json};

use crate::error::StudioError;
use crate::message::Message;
use crate::study::Written;
use crate::verify::one;

/// Names that a column of times may have, in the order in which they are preferred.
const TIMES: [&str; 6] = ["t", "time", "timestamp", "time_s", "t_s", "seconds"];

/// The columns of the one file, and a table `[log]`: with `study` columns are offered for its plant, by their names
/// where these agree.
pub(crate) fn columns(request: Message) -> Result<Message, StudioError> {
    let study = match request.json.get("study") {
        None | Some(Value::Null) => None,
        // A log may be dropped on a study that has mistakes, or on one without its files.
        Some(_) => Written::of(&request)?.study(Vec::new()).ok(),
    };
    let (name, bytes) = one(request, "the bytes of a table")?;
    let table = Table::from_bytes(&bytes).map_err(|error| StudioError::Table { name: name.clone(), error })?;
    drop(bytes);
    let suggestion = suggestion(&name, table.names(), study.as_ref());
    Ok(Message::new(json!({ "columns": table.names(), "rows": table.rows(), "suggestion": suggestion })))
}

/// The table `[log]`.
fn suggestion(file: &str, names: &[String], study: Option<&Study>) -> String {
    let is = |name: &String, wanted: &str| name.trim().eq_ignore_ascii_case(wanted);
    let named = TIMES.iter().find_map(|time| names.iter().find(|name| is(name, time)));
    let time = named.or(names.first()).map_or("t", String::as_str);
    let mut text = format!("[log]\nfile = {}\n", quoted(file));
    if time != "t" {
        _ = writeln!(text, "time = {}", quoted(time));
    }
    let mut rest: Vec<&String> = names.iter().filter(|name| *name != time).collect();
    let Some(study) = study else {
        let rest: Vec<String> = rest.into_iter().map(|name| quoted(name)).collect();
        return text + &format!("outputs = [{}]\n", rest.join(", "));
    };
    // Those of the same name first, then those that are left, in their order.
    let wanted = [("inputs", &study.plant.inputs), ("outputs", &study.plant.outputs)];
    let mut take = |wanted: &str, exactly: bool| {
        let same = |name: &&String| if exactly { **name == wanted } else { is(name, wanted) };
        rest.iter().position(same).map(|k| rest.remove(k).clone())
    };
    let mut found: Vec<Vec<Option<String>>> = wanted
        .iter()
        .map(|(_, all)| all.iter().map(|one| take(one, true).or_else(|| take(one, false))).collect())
        .collect();
    let mut left = rest.into_iter();
    for column in found.iter_mut().flatten().filter(|column| column.is_none()) {
        *column = left.next().cloned();
    }
    for ((key, all), found) in wanted.iter().zip(found) {
        let is_default = all.iter().zip(&found).all(|(one, column)| column.as_ref() == Some(one));
        if !is_default {
            // A plant with more signals than the table has columns: the message of the study says which.
            let all: Vec<String> = found.iter().map(|column| quoted(column.as_deref().unwrap_or_default())).collect();
            _ = writeln!(text, "{key} = [{}]", all.join(", "));
        }
    }
    text
}

/// A text of TOML.
fn quoted(text: &str) -> String {
    // Of the escapes of JSON those that it needs are those of TOML.
    Value::from(text).to_string()
}
