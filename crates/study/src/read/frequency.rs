//! The table [frequency].

use luenberger_linalg::FrequencyAxis;
use luenberger_proof::wording::shortest;

use crate::model::PlantModel;
use crate::reader::tree::Node;
use crate::reader::{Reader, gain};
use crate::signal::Input;
use crate::study::{FrequencySpec, GainSpec, ObserverSpec};

pub(super) fn frequency(
    node: &Node,
    plant: &PlantModel,
    (observers, input): (Option<&[ObserverSpec]>, Option<&Input>),
    reader: &mut Reader,
) -> Option<FrequencySpec> {
    let before = reader.mistakes.len();
    let [from, to] = ["from", "to"].map(|key| node.get(key).and_then(Node::number));
    if let (Some(from), Some(to), Some(entry)) = (from, to, node.entry("to"))
        && to <= from
    {
        let message = format!("`to` is {}, and `from` is {}", shortest(to), shortest(from));
        reader.wrong(entry.span.clone(), message, "expected a frequency above `from`");
    }
    for (key, value) in [("from", from), ("to", to)] {
        let axis = FrequencyAxis::new(plant.dt);
        if let (Some(dt), Some(value), Some(entry)) = (plant.dt, value, node.entry(key))
            && !axis.contains(value)
        {
            let message = format!("`{key}` is {}, and the plant has dt = {}", shortest(value), shortest(dt));
            reader.wrong(entry.span.clone(), message, format!("expected at most pi/dt, {}", shortest(axis.highest())));
        }
    }
    let recovery = node.get("recovery").map_or(Some(Vec::new()), Node::numbers)?;
    if let Some(entry) = node.entry("recovery") {
        recovered(plant, (observers?, input?), entry.span.clone(), reader);
    }
    let points = node.get("points").map_or(Some(FrequencySpec::default().points), Node::count)?;
    (reader.mistakes.len() == before).then_some(FrequencySpec { from, to, points, recovery })
}

/// Checks that the study has a loop that can be recovered.
fn recovered(
    plant: &PlantModel,
    (observers, input): (&[ObserverSpec], &Input),
    span: std::ops::Range<usize>,
    reader: &mut Reader,
) {
    if let Some(dt) = plant.dt {
        return gain::not_recovered(dt, span, reader);
    }
    let fed = match input {
        Input::Feedback { observer, .. } => observers.iter().find(|one| one.name == *observer),
        _ => None,
    };
    let Some(fed) = fed else {
        let expected = "expected `feedback` in [input], of an observer with `w` and `v`";
        return reader.wrong(span, "`recovery` without a feedback of an estimate", expected);
    };
    let is_kalman = fed.kind.whole_gain().is_some_and(|spec| matches!(spec.gain, GainSpec::Kalman(_)));
    if !is_kalman {
        let message = format!("`recovery` is for a Kalman filter, and {} has no w and v", fed.name);
        reader.wrong(span, message, "expected a feedback of an observer with `w` and `v`");
    }
}
