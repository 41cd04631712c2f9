//! Error against cost and against peak, with the observers that nothing else is better than in both.

use luenberger_figures::figure::static_figure;
use luenberger_figures::{Dash, Figure, Hue, Marker, Panel, Series};

use super::candidate::Candidate;
use super::ranking::{Criterion, Ranked};
use crate::error::StudyError;
use crate::statistics::pareto_front;

const CAPTION: &str = "The lower left is better; the line joins the observers that no other one is better than in both (the Pareto front).";

/// The figure as SVG and PNG, with the names of their files.
pub(super) fn files(ordered: &[&Candidate], accuracy: Criterion) -> Result<Vec<(String, Vec<u8>)>, StudyError> {
    let panels = [(Criterion::Cost, "operations per step"), (Criterion::Peak, "peak |e| / |e(0)|")];
    let panels: Vec<Panel> = panels.into_iter().filter_map(|of| panel(ordered, accuracy, of)).collect();
    if panels.is_empty() {
        return Ok(Vec::new());
    }
    let (title, caption) = match accuracy {
        Criterion::Innovations => {
            ("Innovations against cost", format!("Of the part of the log that is held out. {CAPTION}"))
        }
        _ => ("Error against cost and peak", format!("Medians over the runs. {CAPTION}")),
    };
    let figure = panels.into_iter().fold(Figure::new(title).caption(&caption), Figure::panel);
    let failed = |why: luenberger_figures::figure::FigureError| StudyError::Output {
        what: "figures/advise-pareto".to_owned(),
        why: why.to_string(),
    };
    Ok(vec![
        ("figures/advise-pareto.svg".to_owned(), static_figure::svg(&figure).map_err(failed)?.into_bytes()),
        ("figures/advise-pareto.png".to_owned(), static_figure::png(&figure).map_err(failed)?),
    ])
}

/// None with less than two points.
fn panel(ordered: &[&Candidate], accuracy: Criterion, (criterion, label): (Criterion, &str)) -> Option<Panel> {
    let complete = ordered.iter().filter(|one| one.is_complete());
    let points: Vec<(&str, (f64, f64))> = complete
        .map(|one| (one.spec.name.as_str(), (one.value(criterion), one.value(accuracy))))
        .filter(|(_, (x, y))| x.is_finite() && y.is_finite() && *x > 0.0 && *y > 0.0)
        .collect();
    if points.len() < 2 {
        return None;
    }
    let pairs: Vec<(f64, f64)> = points.iter().map(|point| point.1).collect();
    let mut best: Vec<(f64, f64)> = pareto_front(&pairs).into_iter().map(|i| pairs[i]).collect();
    best.sort_by(|one, other| one.0.total_cmp(&other.0));
    let mut panel = Panel::new(label, accuracy.quantity()).log_y();
    if criterion == Criterion::Cost {
        panel = panel.log_x();
    }
    if best.len() > 1 {
        let (x, y): (Vec<f64>, Vec<f64>) = best.into_iter().unzip();
        panel = panel.series(Series::line("Pareto front", &x, &y).hue(Hue::Grey).dash(Dash::Solid).width(0.7));
    }
    for (number, (name, (x, y))) in points.into_iter().enumerate() {
        panel = panel.series(Series::points(name, &[x], &[y]).hue(Hue::Palette(number)).marker(Marker::Circle));
    }
    Some(panel)
}
