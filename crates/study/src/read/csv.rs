//! CSV files named in a study: input tables and measured logs.

use luenberger_sim::{Between, Samples};

use super::Reader;
use super::tree::Node;
use crate::model::PlantModel;
use crate::study::Log;
use crate::table::{Table, TableError};

/// The result of reading a file, or its mistake at the key that names it.
fn read<T>(node: &Node, reader: &mut Reader, made: impl Fn(&Table) -> Result<T, TableError>) -> Option<T> {
    let name = node.text()?;
    // The name as in the study: a message should not depend on the folder.
    let message = match std::fs::read_to_string(reader.folder.join(name)) {
        Ok(text) => match Table::parse(&text).and_then(|table| made(&table)) {
            Ok(made) => return Some(made),
            Err(error) => format!("{name}: {error}"),
        },
        Err(error) => format!("{name} cannot be read: {error}"),
    };
    reader.wrong(node.span.clone(), message, "expected a CSV file with a header, beside the study");
    None
}

/// A table with the column t and one for each input.
pub(super) fn input(node: &Node, plant: &PlantModel, linear: bool, reader: &mut Reader) -> Option<Samples> {
    let between = if linear { Between::Line } else { Between::Hold };
    read(node, reader, |table| table.samples("t", &plant.inputs, between))
}

/// A log.
pub(super) fn log(node: &Node, time: &str, inputs: &[String], outputs: &[String], reader: &mut Reader) -> Option<Log> {
    read(node, reader, |table| {
        Ok(Log { recording: table.recording(time, inputs, outputs)?, suspicions: table.suspicions(time, outputs)? })
    })
}
