//! Outputs that are measured late: `delays` in [plant].

use crate::reader::Reader;
use crate::reader::tree::Node;

/// The delay of each output; empty if none is late.
pub(super) fn delays(
    node: Option<&Node>,
    outputs: &[String],
    dt: Option<f64>,
    reader: &mut Reader,
) -> Option<Vec<f64>> {
    let Some(node) = node else { return Some(Vec::new()) };
    let mut delays = vec![0.0; outputs.len()];
    let mut sound = true;
    for entry in node.entries() {
        let Some(j) = outputs.iter().position(|name| *name == entry.key) else {
            let message = format!("the plant has no output `{}`", entry.key);
            reader.wrong(entry.span.clone(), message, format!("expected one of {}", outputs.join(", ")));
            sound = false;
            continue;
        };
        let delay = entry.node.number().filter(|delay| *delay >= 0.0 && delay.is_finite());
        let Some(delay) = delay else {
            let message = format!("the delay of {} is no time", entry.key);
            reader.wrong(entry.node.span.clone(), message, "expected a finite number that is not negative");
            sound = false;
            continue;
        };
        if let Some(dt) = dt.filter(|dt| (delay / dt - (delay / dt).round()).abs() > 1e-6) {
            let message = format!("the delay of {} is {delay}, not a multiple of `dt` = {dt}", entry.key);
            reader.wrong(entry.node.span.clone(), message, "expected a multiple of the period of the plant");
            sound = false;
        }
        delays[j] = delay;
    }
    sound.then(|| if delays.iter().any(|delay| *delay > 0.0) { delays } else { Vec::new() })
}
