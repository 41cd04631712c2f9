//! CSV files named in a study: input tables and measured logs.

use luenberger_sim::{BetweenRows, Estimates, SampleInterpolation, Samples};

use crate::model::PlantModel;
use crate::reader::Reader;
use crate::reader::tree::Node;
use crate::study::Log;
use crate::table::{LogColumns, Table, TableError};

/// The result of reading a file, or its mistake at the key that names it.
fn read<T>(node: &Node, reader: &mut Reader, made: impl Fn(Table) -> Result<T, TableError>) -> Option<T> {
    let name = node.text()?;
    // The name as in the study: a message should not depend on the folder.
    let message = match reader.file(name) {
        Ok(bytes) => {
            let table = Table::from_bytes(&bytes);
            // A long log is in memory once.
            drop(bytes);
            match table.and_then(&made) {
                Ok(made) => return Some(made),
                Err(error) => format!("{name}: {error}"),
            }
        }
        Err(error) => format!("{name} cannot be read: {error}"),
    };
    reader.refuse(node.span.clone(), message, "expected a CSV file with a header, relative to the folder of the study")
}

/// A table with the column t and one for each input.
pub(super) fn input(node: &Node, plant: &PlantModel, linear: bool, reader: &mut Reader) -> Option<Samples> {
    let between = if linear { SampleInterpolation::Linear } else { SampleInterpolation::ZeroOrderHold };
    read(node, reader, |table| table.samples("t", &plant.inputs, between))
}

/// The columns of the true states of a log, or of the variances of its outputs, if there are any; none for an unknown
/// one.
pub(super) type KnownColumns = Option<Vec<Option<String>>>;

/// A log, with what is between its rows, and which estimates are scored on it.
pub(super) fn log(
    node: &Node,
    (columns, states, variances): (&LogColumns, &KnownColumns, &KnownColumns),
    (between, estimates): (BetweenRows, Estimates),
    every_row: bool,
    reader: &mut Reader,
) -> Option<Log> {
    let LogColumns { time, inputs, outputs } = columns;
    read(node, reader, |table| {
        let table = if every_row { table.counting_repeats() } else { table };
        let (recording, suspicions) = table.recording_with_suspicions(time, inputs, outputs)?;
        let known = |names: &KnownColumns| {
            let names: Option<Vec<Option<&str>>> = names.as_ref().map(|all| all.iter().map(Option::as_deref).collect());
            names.map(|names| table.samples_with_missing(time, &names)).transpose()
        };
        Ok(Log {
            columns: columns.clone(),
            recording: recording.between(SampleInterpolation::ZeroOrderHold, between),
            truth: known(states)?,
            variances: known(variances)?,
            estimates,
            suspicions,
        })
    })
}
