//! Speed against noise: settling time and steady-state error of observers, in one figure.

use luenberger_figures::{Dash, Figure, Hue, Marker, Panel, Series};

use super::pictures::figure;
use crate::results::with_unit;
use crate::results::{ScoringReport, SimulationReport, SweepReport};
use crate::statistics::pareto_front;
use crate::study::Study;

/// Settling time and steady-state error; what does not exist is not drawn.
type Speed = (Option<f64>, Option<f64>);

/// An observer, at one value of a sweep.
struct Point<'a> {
    observer: &'a str,
    norm: Speed,
    states: Vec<Speed>,
}

const CAPTION: &str = "Settling time against the root mean square of the error over the second half of the run, which \
                       is what noise leaves. The lower left is better; the line joins the points that no other one is better than in both (the Pareto front).";

/// The observers of a simulation; none without noise, or with less than two of them.
pub(super) fn simulation(study: &Study, report: &SimulationReport) -> Option<(String, Figure)> {
    report.seed?;
    let points: Vec<Point<'_>> = report
        .rows
        .iter()
        .filter_map(|row| {
            let merits = row.merits.as_ref()?;
            let norm = merits.norm.as_ref();
            Some(Point {
                observer: &row.observer,
                norm: (norm.and_then(|norm| norm.settling_last), norm.map(|norm| norm.steady_rms)),
                states: merits.states.iter().map(|state| (state.settling_5, Some(state.steady_rmse))).collect(),
            })
        })
        .collect();
    if points.len() < 2 {
        return None;
    }
    figure("pareto", "Speed against noise", CAPTION, panels(study, &report.scoring, &points))
}

/// The observers along a sweep, a curve each; none without noise.
pub(super) fn sweep(study: &Study, report: &SweepReport) -> Option<(String, Figure)> {
    study.simulation.as_ref().filter(|simulation| simulation.is_noisy())?;
    let rows = report.rows.iter().filter(|row| row.finished > 0);
    let points: Vec<Point<'_>> = rows
        .map(|row| Point {
            observer: &row.observer,
            norm: (row.settling, row.steady_rms),
            states: row.states.iter().map(|state| (state.settling_5, Some(state.steady_rmse))).collect(),
        })
        .collect();
    figure("sweep-pareto", "Speed against noise in the sweep", CAPTION, panels(study, &report.scoring, &points))
}

/// One panel for the norm, or without a scale one for each state that is shown.
fn panels(study: &Study, scoring: &ScoringReport, points: &[Point<'_>]) -> Vec<Panel> {
    let time = |text: &str| with_unit(text, study.plant.time_unit.as_ref());
    if scoring.scale.is_some() {
        let norm: Vec<_> = points.iter().map(|point| (point.observer, point.norm)).collect();
        return vec![panel(&time("settling time"), "steady-state rms of |e|", &norm)];
    }
    let all: Vec<usize> = (0..study.plant.states.len()).collect();
    let of = |i: &usize| {
        let name = &study.plant.states[*i];
        let error = with_unit(&format!("steady-state RMSE of {name}"), study.plant.unit(name));
        let states = points.iter().filter_map(|point| Some((point.observer, *point.states.get(*i)?)));
        panel(&time(&format!("settling time of {name}")), &error, &states.collect::<Vec<_>>())
    };
    study.plot.states.as_ref().unwrap_or(&all).iter().map(of).collect()
}

/// The Pareto front of the points that a logarithmic axis has, from the fastest on.
fn front(points: &[(&str, Speed)]) -> (Vec<f64>, Vec<f64>) {
    let known: Vec<(f64, f64)> =
        points.iter().filter_map(|(_, speed)| Some((speed.0?, speed.1?))).filter(|(_, error)| *error > 0.0).collect();
    let mut front: Vec<(f64, f64)> = pareto_front(&known).into_iter().map(|i| known[i]).collect();
    front.sort_by(|one, other| one.0.total_cmp(&other.0));
    front.dedup();
    front.into_iter().unzip()
}

fn panel(speed: &str, error: &str, points: &[(&str, Speed)]) -> Panel {
    let mut names: Vec<&str> = points.iter().map(|point| point.0).collect();
    names.dedup();
    let mut panel = Panel::new(speed, error).log_y();
    let (x, y) = front(points);
    if x.len() > 1 {
        // Room for the points at both ends.
        let known = points.iter().filter_map(|(_, speed)| speed.0);
        let (from, to) = known.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        panel = panel.x_range(from - 0.06 * (to - from), to + 0.06 * (to - from));
        panel = panel.series(Series::line("Pareto front", &x, &y).hue(Hue::Grey).dash(Dash::Solid).width(0.7));
    }
    for (number, name) in names.into_iter().enumerate() {
        let of = points.iter().filter(|point| point.0 == name);
        let (x, y): (Vec<f64>, Vec<f64>) =
            of.filter_map(|(_, speed)| Some((speed.0?, speed.1?))).filter(|(_, error)| *error > 0.0).unzip();
        if !x.is_empty() {
            let series = Series::points(name, &x, &y).hue(Hue::Palette(number)).marker(Marker::Circle);
            panel = panel.series(series);
        }
    }
    panel
}
