//! Results as lines: numbers with the digits from which they are read back exactly.

use csv::Writer;

/// A line of CSV with these cells.
fn line(cells: impl Iterator<Item = String>) -> String {
    let mut writer = Writer::from_writer(Vec::new());
    // Writing into memory does not fail.
    _ = writer.write_record(cells.collect::<Vec<_>>());
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// A number, with an exponent where it would have many zeros.
fn number(x: f64) -> String {
    if x == 0.0 || (1e-5..1e16).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

/// The line that names the columns.
pub(super) fn header(names: &[String]) -> String {
    line(names.iter().cloned())
}

/// A row; what is not known is an empty cell.
pub(super) fn row(results: &[Option<f64>]) -> String {
    line(results.iter().map(|result| result.map_or_else(String::new, number)))
}

/// A JSON object; what is not known is null.
pub(super) fn object(names: &[String], results: &[Option<f64>]) -> String {
    let entry = |(name, result): (&String, &Option<f64>)| {
        let value = result.map_or(serde_json::Value::Null, Into::into);
        format!("{}:{value}", serde_json::Value::from(name.as_str()))
    };
    format!("{{{}}}\n", names.iter().zip(results).map(entry).collect::<Vec<_>>().join(","))
}
