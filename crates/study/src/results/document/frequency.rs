//! Frequency responses of observers and of the loop, as tables.

use luenberger_figures::{Cell, Grid, Section};
use luenberger_proof::wording::significant;

use crate::results::{Crossing, FrequencyReport, LoopReport, PlantSummary};

/// A number with four digits.
fn size(x: f64) -> String {
    significant(x, 4)
}

/// At a frequency, which may be infinite.
fn at(frequency: Option<f64>) -> String {
    frequency.map_or_else(|| "infinity".to_owned(), size)
}

fn maybe(x: Option<f64>) -> Cell {
    x.map_or_else(|| Cell::number("-"), |x| Cell::number(size(x)))
}

/// A margin with its frequency.
fn crossing(found: Option<Crossing>, unit: &str) -> Cell {
    let Some(Crossing { frequency, margin }) = found else { return Cell::number("-") };
    Cell::number(format!("{}{unit} at {}", size(margin), at(frequency)))
}

/// A factor, with its decibels.
fn factor(found: Option<Crossing>) -> Cell {
    let Some(Crossing { frequency, margin }) = found else { return Cell::number("-") };
    Cell::number(format!("{} ({} dB) at {}", size(margin), significant(20.0 * margin.log10(), 3), at(frequency)))
}

/// The whole section.
pub(crate) fn section(report: &FrequencyReport, plant: &PlantSummary) -> Section {
    let unit = plant.time_unit.as_deref().unwrap_or("unit of time");
    let mut section = Section::new("Frequency responses").prose(format!(
        "Frequencies w are in radians per {unit}; figures and tables from {} to {}.",
        size(report.range[0]),
        size(report.range[1])
    ));
    if report.observers.is_empty() {
        section = section.prose("No observer of the study is linear with a constant gain of its own.");
    } else {
        let caption = "Largest gain from measurement noise to the error of each state, over all frequencies.";
        let mut grid = Grid::new(&["observer", "state", "gain", "at w"]).caption(caption);
        for observer in &report.observers {
            for (state, peak) in plant.states.iter().zip(&observer.noise_peaks) {
                grid = grid.row([
                    Cell::from(observer.observer.as_str()),
                    Cell::from(plant.labelled(state).as_str()),
                    Cell::number(size(peak.norm)),
                    Cell::number(at(peak.frequency)),
                ]);
            }
        }
        section = section.grid(grid);
    }
    match &report.feedback {
        Some(found) => feedback(section, found, plant),
        None => section,
    }
}

fn feedback(mut section: Section, report: &LoopReport, plant: &PlantSummary) -> Section {
    let mut margins = Grid::new(&["opened at", "gain margin", "gain may fall to", "phase margin", "delay margin"])
        .caption(format!("Margins of the loop u = r - K xhat with the estimate of {}.", report.observer));
    let mut peaks = Grid::new(&["opened at the", "closed loop", "peak of S", "peak of T", "all gains", "all phases"])
        .caption("Peaks of the sensitivities, and what all channels may change at once.");
    for opened in &report.opened {
        for channel in &opened.channels {
            let delay = plant.time_unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
            margins = margins.row([
                Cell::from(plant.labelled(&channel.channel).as_str()),
                factor(channel.gain_margin),
                factor(channel.gain_reduction),
                crossing(channel.phase_margin, "°"),
                crossing(channel.delay_margin, &delay),
            ]);
        }
        let peak = |peak: Option<crate::results::Peak>| match peak {
            Some(peak) => Cell::number(format!("{} at {}", size(peak.norm), at(peak.frequency))),
            None => Cell::number("-"),
        };
        let gains = match opened.all_gains[..] {
            [low, high] => format!("{} to {}", size(low), size(high)),
            [low] => format!("from {}", size(low)),
            _ => "-".to_owned(),
        };
        let phases = opened.all_phases.map_or_else(|| "-".to_owned(), |angle| format!("± {}°", size(angle)));
        peaks = peaks.row([
            Cell::from(opened.at),
            Cell::from(if opened.stable { "stable" } else { "not stable" }),
            peak(opened.sensitivity),
            peak(opened.complementary_sensitivity),
            Cell::number(gains),
            Cell::number(phases),
        ]);
    }
    section = section.grid(margins).note(
        "Computed in floating point. Each margin is that of one channel, the others closed; `study.json` has all \
         crossovers. Of a loop that is not stable margins do not say what makes it stable.",
    );
    section = section.grid(peaks);
    if report.recovery.is_empty() {
        return section;
    }
    let head = ["q", "difference of S", "peak of S", "phase margin", "norm of L"];
    let mut grid = Grid::new(&head).caption(
        "Loop transfer recovery at the inputs: the filter for W + q^2 B B'; the difference is the largest over all \
         frequencies, from the sensitivity of state feedback.",
    );
    for one in &report.recovery {
        grid = grid.row([
            Cell::number(size(one.q)),
            Cell::number(size(one.difference)),
            maybe(one.sensitivity),
            one.phase_margin.map_or_else(|| Cell::number("-"), |angle| Cell::number(format!("{}°", size(angle)))),
            Cell::number(size(one.gain)),
        ]);
    }
    section = section.grid(grid);
    match &report.obstacle {
        Some(obstacle) => section.prose(format!("The loop of state feedback is not recovered: {obstacle}.")),
        None => section,
    }
}
