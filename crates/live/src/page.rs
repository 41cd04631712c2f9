//! The part of a page in which an experiment is run: sliders, figures, scores and verdicts.
//!
//! A page has blocks ([`html_block`]), [`MODULE`] as the packed element `live-module`, [`STYLE`] and [`SCRIPT`]. The
//! script uses what every page of `luenberger-figures` has: the plotting library, `themed` and `unpack`.

use crate::experiment::{Experiment, ObserverKind};

/// The style sheet of the blocks.
pub const STYLE: &str = include_str!("../assets/live.css");

/// The script that starts every block of the page.
pub const SCRIPT: &str = include_str!("../assets/live.js");

/// The module, compressed by gzip, in base64.
pub const MODULE: &str = include_str!("../assets/luenberger-live.wasm.gz.base64");

/// A slider: its name, its label, what it is for, and its positions.
struct Slider {
    name: &'static str,
    label: &'static str,
    /// Whether the positions are exponents of 2.
    is_logarithmic: bool,
    range: [f64; 2],
    step: f64,
}

const SLIDERS: [Slider; 5] = [
    Slider { name: "gain", label: "gain L", is_logarithmic: true, range: [-3.0, 3.0], step: 0.05 },
    Slider { name: "cubic", label: "cubic gain N", is_logarithmic: true, range: [-4.0, 4.0], step: 0.05 },
    Slider { name: "noise", label: "noise", is_logarithmic: false, range: [0.0, 5.0], step: 0.05 },
    Slider { name: "error", label: "first error", is_logarithmic: false, range: [0.0, 5.0], step: 0.05 },
    Slider { name: "period", label: "sampling period", is_logarithmic: true, range: [-3.0, 3.0], step: 0.05 },
];

/// Whether a slider changes anything in the experiment.
fn matters(name: &str, experiment: &Experiment) -> bool {
    let any =
        |choose: &dyn Fn(&ObserverKind) -> bool| experiment.observers.iter().any(|observer| choose(&observer.kind));
    match name {
        "cubic" => any(&ObserverKind::is_cubic),
        "noise" => experiment.noise.is_some() || experiment.sensors.iter().any(|sensor| sensor.amplitude > 0.0),
        // A plant in discrete time has its period.
        "period" => experiment.dt.is_none() && any(&|kind| kind.period().is_some()),
        _ => true,
    }
}

/// What the slider of the gains scales.
fn gains(experiment: &Experiment) -> String {
    let of = |kind: &ObserverKind| match kind {
        ObserverKind::Kalman { .. } => "W of filters",
        ObserverKind::SlidingMode { .. } => "sliding-mode gains",
        _ => "gain L",
    };
    let kinds: Vec<&str> = experiment.observers.iter().map(|observer| of(&observer.kind)).collect();
    let named = ["gain L", "sliding-mode gains", "W of filters"].into_iter().filter(|name| kinds.contains(name));
    named.collect::<Vec<_>>().join(", ")
}

/// What stands in the place of a norm.
const NO_NORM: &str = "The states have no norm in common: no simulation.scale and several units. The errors and scores are \
     those of the chosen state, settled within 5 % of its error at the start.";

/// The block of an experiment, as HTML; `id` is unique in the page, made of letters, digits and hyphens, and `colours`
/// are those of the curves, in CSS.
///
/// # Errors
/// Numbers that JSON does not have: NaN and infinities.
pub fn html_block(id: &str, experiment: &Experiment, colours: &[String]) -> Result<String, serde_json::Error> {
    let sliders = SLIDERS.iter().filter(|slider| matters(slider.name, experiment)).map(|slider| {
        let Slider { name, label, is_logarithmic, range: [least, most], step } = *slider;
        let label = if name == "gain" { gains(experiment) } else { label.to_owned() };
        let (value, scale) = if is_logarithmic { (0, "log") } else { (1, "linear") };
        format!(
            "<label for=\"{id}-{name}\">{label}</label><input type=\"range\" id=\"{id}-{name}\" data-slider=\"{name}\" \
             data-scale=\"{scale}\" min=\"{least}\" max=\"{most}\" step=\"{step}\" value=\"{value}\">\
             <output for=\"{id}-{name}\">&times; 1</output>"
        )
    });
    let sliders: String = sliders.collect();
    let (picture, about) = match &experiment.scale {
        Some(_) => ("Norm of the errors", String::new()),
        None => ("Errors of a state", format!("<p class=\"small\">{NO_NORM}</p>")),
    };
    let data = serde_json::to_string(&serde_json::json!({ "experiment": experiment, "colours": colours }))?;
    // "</script" within a string would end the element that holds it.
    let data = data.replace("</", "<\\/");
    Ok(format!(
        "<div class=\"live\" id=\"{id}\"><div class=\"sliders\">{sliders}</div>\
         <p class=\"live-buttons\"><button type=\"button\" data-reset>As in the report</button>\
         <label>state <select data-state></select></label><span class=\"live-note small\" role=\"status\"></span></p>\
         {about}<div class=\"live-plots\"><div class=\"plot\" data-live=\"norm\" role=\"img\" \
         aria-label=\"{picture}\"></div><div class=\"plot\" data-live=\"state\" role=\"img\" \
         aria-label=\"A state and its estimates\"></div></div>\
         <div class=\"wide\"><table class=\"rows\"><thead><tr><th>observer</th><th class=\"number\">rms</th>\
         <th class=\"number\">peak</th><th class=\"number\">settled</th><th class=\"number\">at the end</th>\
         <th>certificate</th></tr></thead><tbody></tbody></table></div>\
         <noscript><p>This part needs JavaScript.</p></noscript></div>\
         <script type=\"application/json\" id=\"{id}-data\">{data}</script>"
    ))
}
