//! The block diagram of a study: plant, sensors, observers and the signals between them, as SVG in the colours of the
//! page.

use luenberger_figures::escape;
use std::fmt::Write;

use crate::signal::Input;
use crate::study::Study;

/// Width of a letter, for the shortening of labels.
const LETTER: f64 = 7.2;

/// The diagram.
pub(super) fn svg(study: &Study) -> String {
    let plant = &study.plant;
    let noisy = study.simulation.as_ref().is_some_and(crate::study::Simulation::is_noisy);
    let feedback = matches!(study.input, Input::Feedback { .. });
    let driven = !plant.inputs.is_empty();
    let observers = list(study.observers.iter().map(|observer| observer.name.as_str()), 200.0);
    let states = list(plant.states.iter().map(String::as_str), 150.0);
    let (inputs, outputs) =
        (list(plant.inputs.iter().map(String::as_str), 120.0), list(plant.outputs.iter().map(String::as_str), 120.0));
    let alt = format!(
        "Block diagram: {}the plant with the states {states} has the outputs {outputs}{}, from which {observers} estimate the states{}.",
        if driven { format!("driven by {inputs}, ") } else { String::new() },
        if noisy { ", measured with noise" } else { "" },
        if feedback { "; the estimate is fed back" } else { "" }
    );
    let mut svg = format!(
        "<svg class=\"diagram\" viewBox=\"0 0 740 230\" role=\"img\" aria-label=\"{}\" fill=\"none\" \
         stroke=\"currentColor\" stroke-width=\"1.4\" font-size=\"14\"><defs><marker id=\"arrow\" viewBox=\"0 0 8 8\" \
         refX=\"7\" refY=\"4\" markerWidth=\"8\" markerHeight=\"8\" orient=\"auto\"><path d=\"M0 0L8 4L0 8Z\" \
         fill=\"currentColor\" stroke=\"none\"/></marker></defs>",
        escape(&alt)
    );
    let mut arrow = |path: &str| {
        let _ = write!(svg, "<path d=\"{path}\" marker-end=\"url(#arrow)\"/>");
    };
    if driven {
        arrow("M20 60H199");
        arrow("M110 60V170H289");
    }
    arrow(if noisy { "M400 60H491" } else { "M400 60H720" });
    if noisy {
        arrow("M505 14V46");
        arrow("M518 60H720");
    }
    arrow("M570 60V115H400V141");
    arrow("M510 170H720");
    if feedback {
        arrow("M580 170V215H60V66");
    }
    if noisy {
        svg.push_str("<circle cx=\"505\" cy=\"60\" r=\"13\"/>");
    }
    let mut block = |x: f64, y: f64, width: f64, lines: [&str; 2]| {
        let middle = x + width / 2.0;
        let _ = write!(
            svg,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"56\" rx=\"6\" fill=\"var(--card)\"/>\
             <g stroke=\"none\" fill=\"currentColor\" text-anchor=\"middle\"><text x=\"{middle}\" y=\"{}\" \
             font-weight=\"600\">{}</text><text x=\"{middle}\" y=\"{}\" font-size=\"12.5\">{}</text></g>",
            y + 24.0,
            escape(lines[0]),
            y + 43.0,
            escape(lines[1])
        );
    };
    block(200.0, 32.0, 200.0, ["plant", &states]);
    let name = if study.observers.len() == 1 { "observer" } else { "observers" };
    block(290.0, 142.0, 220.0, [name, &observers]);
    let mut label = |x: f64, y: f64, anchor: &str, text: &str| {
        let _ = write!(
            svg,
            "<text x=\"{x}\" y=\"{y}\" stroke=\"none\" fill=\"currentColor\" text-anchor=\"{anchor}\">{}</text>",
            escape(text)
        );
    };
    if driven {
        label(20.0, 50.0, "start", &inputs);
    }
    label(720.0, 50.0, "end", &outputs);
    label(720.0, 160.0, "end", "estimates");
    if noisy {
        label(516.0, 24.0, "start", "noise");
        label(505.0, 65.0, "middle", "+");
    }
    if feedback {
        label(70.0, 208.0, "start", "u = r - K xhat");
    }
    svg + "</svg>"
}

/// Names with commas, as many as have room, and the number of the others.
fn list<'n>(names: impl Iterator<Item = &'n str>, room: f64) -> String {
    let names: Vec<&str> = names.collect();
    let fits = |text: &str| text.chars().count() as f64 * LETTER <= room;
    let whole = names.join(", ");
    if fits(&whole) {
        return whole;
    }
    let shown =
        (0..names.len()).rev().find(|&count| fits(&format!("{}, .. ({})", names[..count].join(", "), names.len())));
    match shown {
        Some(count) if count > 0 => format!("{}, .. ({})", names[..count].join(", "), names.len()),
        _ => names.len().to_string(),
    }
}
