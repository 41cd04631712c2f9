//! The figures of a study, and its trajectories as tables.

use luenberger_design::unknown_input::left_inverse;
use luenberger_figures::{Area, Dash, Figure, Hue, Mark, Panel, Series, Table};
use luenberger_plants::Plant;
use luenberger_sim::SampleTime;
use nalgebra::{DMatrix, DVector};

use super::filter::is_filter;
use super::rows::Run;
use crate::results::with_unit;
use crate::results::{LogSweepReport, PredictionReport, SweepReport, SweepRow};
use crate::study::{Quantity, Study};
use crate::trajectory::Member;

/// The number of states drawn if the study selects none: more make an image of hundreds of megabytes.
const MOST_STATES: usize = 24;

/// The data common to all runs of a study, and those of each observer.
pub(super) struct Runs<'a> {
    pub(super) study: &'a Study,
    /// The times of the first run, its states (none on a log), inputs and outputs.
    pub(super) first: &'a Run,
    /// The observers with their runs.
    pub(super) of: Vec<(&'a Member<'a>, &'a Run)>,
    /// Whether the data are a log.
    pub(super) measured: bool,
}

impl Runs<'_> {
    /// The rows within the time window of the plot, in stretches between gaps.
    fn rows(&self, run: &Run) -> Vec<Vec<usize>> {
        let rows = self.rows_of_window(run);
        stretches(&run.t, &rows).into_iter().map(<[usize]>::to_vec).collect()
    }

    fn rows_of_window(&self, run: &Run) -> Vec<usize> {
        let plot = &self.study.plot;
        let within = |t: &f64| plot.from.is_none_or(|from| *t >= from) && plot.to.is_none_or(|to| *t <= to);
        let rows: Vec<usize> = (0..run.t.len()).filter(|k| within(&run.t[*k])).collect();
        // A window without a sample shows all.
        if rows.is_empty() { (0..run.t.len()).collect() } else { rows }
    }

    /// The observers to draw, each with its place in the study.
    fn shown(&self) -> impl Iterator<Item = (usize, &Member<'_>, &Run)> {
        let names = &self.study.plot.observers;
        let drawn = move |name: &String| names.as_ref().is_none_or(|names| names.contains(name));
        self.of.iter().filter_map(move |(member, run)| {
            let name = &member.requested.name;
            drawn(name).then(|| (place(self.study, name), *member, *run))
        })
    }

    fn states(&self) -> Vec<usize> {
        let count = self.study.plant.states.len();
        self.study.plot.states.clone().unwrap_or_else(|| (0..count.min(MOST_STATES)).collect())
    }

    /// A caption, with a remark if not every state is drawn.
    fn caption(&self, caption: &str) -> String {
        let count = self.study.plant.states.len();
        if self.study.plot.states.is_none() && count > MOST_STATES {
            return format!("{caption} The first {MOST_STATES} of {count} states; `plot.states` selects others.");
        }
        caption.to_owned()
    }

    /// The label of the time axis.
    fn time(&self) -> String {
        with_unit("time t", self.study.plant.time_unit.as_ref())
    }

    /// The label of a state, an input or an output.
    fn label(&self, name: &str) -> String {
        with_unit(name, self.study.plant.unit(name))
    }

    fn state(&self, i: usize) -> String {
        self.label(&self.study.plant.states[i])
    }
}

/// Points of a curve, about: a figure is a few hundred points wide.
const POINTS: usize = 1500;

/// The rows of a stretch that are drawn, of `count` rows in all: of many the largest and the smallest value of each
/// part, so that no peak is lost, and the last row.
pub fn drawn(stretch: &[usize], count: usize, y: impl Fn(usize) -> f64) -> Vec<usize> {
    let step = count.div_ceil(POINTS).max(1);
    if step == 1 {
        return stretch.to_vec();
    }
    let mut kept: Vec<usize> = Vec::new();
    for part in stretch.chunks(2 * step) {
        let finite = || part.iter().copied().filter(|k| y(*k).is_finite());
        let least = finite().min_by(|a, b| y(*a).total_cmp(&y(*b)));
        let largest = finite().max_by(|a, b| y(*a).total_cmp(&y(*b)));
        let (least, largest) = (least.unwrap_or(part[0]), largest.unwrap_or(part[0]));
        kept.extend([least.min(largest), least.max(largest)]);
    }
    kept.extend(stretch.first().into_iter().chain(stretch.last()));
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// The place of an observer in the study: its colour and dash in all figures.
pub(super) fn place(study: &Study, name: &str) -> usize {
    study.observers.iter().position(|observer| observer.name == name).unwrap_or_default()
}

/// The curve of a quantity; one for each stretch of a log between gaps.
fn lines(name: &str, run: &Run, rows: &[Vec<usize>], y: impl Fn(usize) -> f64) -> Vec<Series> {
    let count = rows.iter().map(Vec::len).sum();
    let mut curves = Vec::new();
    for stretch in rows {
        curves.extend(line(name, run, &drawn(stretch, count, &y), &y));
    }
    curves
}

/// The curve through these rows; none through fewer than two points.
fn line(name: &str, run: &Run, rows: &[usize], y: impl Fn(usize) -> f64) -> Option<Series> {
    let (mut xs, mut ys): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    for &k in rows {
        let value = y(k);
        if value.is_finite() && xs.last().is_none_or(|last| *last < run.t[k]) {
            xs.push(run.t[k]);
            ys.push(value);
        }
    }
    (xs.len() > 1).then(|| Series::line(name, &xs, &ys))
}

/// Rows without a gap in between: none is later than the one before it by more than five median periods.
fn stretches<'r>(t: &[f64], rows: &'r [usize]) -> Vec<&'r [usize]> {
    let mut periods: Vec<f64> = rows.windows(2).map(|pair| t[pair[1]] - t[pair[0]]).collect();
    let middle = periods.len() / 2;
    let usual =
        if periods.is_empty() { f64::INFINITY } else { *periods.select_nth_unstable_by(middle, f64::total_cmp).1 };
    rows.chunk_by(|&k, &next| t[next] - t[k] <= 5.0 * usual).collect()
}

/// The requested figures with their ids.
pub(super) fn figures(runs: &Runs<'_>) -> Vec<(String, Figure)> {
    let default = if runs.measured {
        vec![Quantity::States, Quantity::Errors, Quantity::Innovations]
    } else {
        vec![Quantity::States, Quantity::Errors, Quantity::ErrorNorm, Quantity::Inputs]
    };
    let mut figures = Vec::new();
    for quantity in runs.study.plot.show.as_ref().unwrap_or(&default) {
        let figure = match quantity {
            Quantity::States => states(runs),
            Quantity::Errors => errors(runs),
            Quantity::ErrorNorm => norm(runs),
            Quantity::Inputs => columns(runs, "inputs", "Inputs", &runs.study.plant.inputs, &runs.first.u),
            Quantity::Outputs => columns(runs, "outputs", "Outputs", &runs.study.plant.outputs, &runs.first.y),
            Quantity::Innovations => innovations(runs),
        };
        figures.extend(figure);
    }
    figures.extend(functions(runs));
    figures.extend(disturbances(runs));
    figures.extend(modes(runs));
    figures.extend(samples(runs));
    figures
}

/// Functions of the state and their estimates, of the observers of functions.
fn functions(runs: &Runs<'_>) -> Named {
    let mut panels = Vec::new();
    for (number, member, run) in runs.shown() {
        let Some((names, functions, estimate)) = &run.functions else { continue };
        let (name, rows) = (&member.requested.name, runs.rows(run));
        for (i, function) in names.iter().enumerate() {
            let truth = lines("plant", run, &rows, |k| functions[(k, i)]).into_iter();
            let truth = truth.map(|curve| curve.hue(Hue::Grey).dash(Dash::Solid).width(2.5));
            let estimated = lines(name, run, &rows, |k| estimate[(k, i)]).into_iter();
            let curves = truth.chain(estimated.map(|curve| curve.numbered(number)));
            panels.push(curves.fold(Panel::new(runs.time(), format!("{function} of {name}")), Panel::series));
        }
    }
    figure("functions", "Functions of the state", "Functions z = K x of the state, and their estimates.", panels)
}

/// The samples of observers at varying periods.
fn samples(runs: &Runs<'_>) -> Named {
    let mut panel = Panel::new(runs.time(), "time since the last sample that arrived");
    let mut marks: Vec<f64> = Vec::new();
    for (number, member, run) in runs.shown() {
        let Some(periods) = member.requested.kind.varying_periods() else { continue };
        let arrived = run.samples.iter().filter(|sample| sample.arrives);
        let (t, elapsed): (Vec<f64>, Vec<f64>) = arrived.map(|sample| (sample.time, sample.elapsed)).unzip();
        if t.is_empty() {
            continue;
        }
        panel = panel.series(Series::points(member.requested.name.as_str(), &t, &elapsed).numbered(number));
        marks.extend([periods.shortest, (periods.misses + 1) as f64 * periods.longest]);
    }
    marks.sort_by(f64::total_cmp);
    marks.dedup();
    let panel = marks.into_iter().fold(panel, |panel, mark| panel.mark(Mark::horizontal(mark)));
    let caption = "The samples that arrive. Lines: the shortest and the longest time between two of them for which the observer is designed.";
    figure("samples", "Samples", caption, vec![panel])
}

/// The estimates of disturbances, of the observers that have some.
fn disturbances(runs: &Runs<'_>) -> Named {
    let estimated = runs.shown().filter_map(|(_, _, run)| run.disturbance.as_ref());
    let names = estimated.map(|(names, _)| names).max_by_key(|names| names.len())?;
    let mut is_known = false;
    let mut panel = |name: &String| {
        let mut panel = Panel::new(runs.time(), name.clone());
        // That of the first observer that estimates it: others may have another E.
        let of_plant = runs.shown().find_map(|(_, member, run)| {
            let j = run.disturbance.as_ref()?.0.iter().position(|own| own == name)?;
            Some((j, run, true_disturbance(runs.study, member, run)?))
        });
        for (j, run, truth) in of_plant.iter().filter(|(j, _, truth)| *j < truth.ncols()) {
            for curve in lines("plant", run, &runs.rows(run), |k| truth[(k, *j)]) {
                panel = panel.series(curve.hue(Hue::Grey).dash(Dash::Solid).width(2.5));
                is_known = true;
            }
        }
        for (number, member, run) in runs.shown() {
            let Some((own, found)) = &run.disturbance else { continue };
            let Some(j) = own.iter().position(|own| own == name) else { continue };
            for curve in lines(&member.requested.name, run, &runs.rows(run), |k| found[(k, j)]) {
                panel = panel.series(curve.numbered(number));
            }
        }
        panel
    };
    let panels: Vec<Panel> = names.iter().map(|name| by_steady_part(panel(name))).collect();
    let truth = if is_known { " Of the plant: what its own equations add to the model's along E." } else { "" };
    let inset = if panels.iter().any(|panel| panel.inset) { INSET } else { "" };
    let caption = format!("The estimates of the disturbances d of x' = A x + B u + E d.{truth}{inset}");
    figure("disturbances", "Disturbances", &caption, panels)
}

/// The disturbances of a run, of which an observer estimates E d: `E^+ (f - f_model)` for the equations f of the
/// simulated plant. None where it has no others than the model, changes, or differs by more than E d.
fn true_disturbance(study: &Study, member: &Member<'_>, run: &Run) -> Option<DMatrix<f64>> {
    let truth = study.truth.as_ref().filter(|truth| truth.events.is_empty())?;
    let (plant, e) = (&truth.plant.as_ref()?.model, member.requested.kind.unknown_disturbance()?);
    let inverse = left_inverse(e)?;
    let mut found = DMatrix::zeros(run.t.len(), e.ncols());
    for (k, t) in run.t.iter().enumerate() {
        let of = |m: &DMatrix<f64>| DVector::from_iterator(m.ncols(), m.row(k).iter().copied());
        let (x, u) = (of(&run.x), of(&run.u));
        let (f, model) = (plant.derivative(*t, &x, &u), study.plant.model.derivative(*t, &x, &u));
        let rest = &f - &model;
        let d = &inverse * &rest;
        // Each equation in its own unit: what E d adds to it, but for rounding.
        let (explained, terms) = (e * &d, e.abs() * d.abs());
        let is_explained = |i: usize| {
            let rounding = 64.0 * f64::EPSILON * (f[i].abs() + model[i].abs() + terms[i]);
            (rest[i] - explained[i]).abs() <= 1e-6 * terms[i] + rounding
        };
        if !(0..f.len()).all(is_explained) {
            return None;
        }
        found.row_mut(k).tr_copy_from(&d);
    }
    Some(found)
}

/// The probabilities of the models of each filter that has several.
fn modes(runs: &Runs<'_>) -> Named {
    let panel = |(member, run): (&Member<'_>, &Run)| {
        let (names, found) = run.modes.as_ref()?;
        let rows = runs.rows(run);
        let mut panel = Panel::new(runs.time(), format!("probability, {}", member.requested.name)).y_range(-0.02, 1.02);
        for (j, name) in names.iter().enumerate() {
            for curve in lines(name, run, &rows, |k| found[(k, j)]) {
                panel = panel.series(curve.numbered(j));
            }
        }
        Some(panel)
    };
    let panels = runs.shown().filter_map(|(_, member, run)| panel((member, run))).collect();
    let caption = "The probabilities of the models between which a filter decides, given the measurements so far.";
    figure("modes", "Probabilities of the models", caption, panels)
}

type Named = Option<(String, Figure)>;

/// A figure with one panel for each nonempty set of curves; none if all are empty.
pub(super) fn figure(id: &str, title: &str, caption: &str, panels: Vec<Panel>) -> Named {
    let panels: Vec<Panel> = panels.into_iter().filter(|panel| !panel.series.is_empty()).collect();
    if panels.is_empty() {
        return None;
    }
    let columns = if panels.len() > 3 { 2 } else { 1 };
    let figure = panels.into_iter().fold(Figure::new(title).caption(caption), Figure::panel).columns(columns);
    Some((id.to_owned(), figure))
}

fn states(runs: &Runs<'_>) -> Named {
    let rows = runs.rows(runs.first);
    let panel = |i: usize| {
        let mut panel = Panel::new(runs.time(), runs.state(i));
        let truth = if runs.measured { "truth" } else { "plant" };
        // A log without true states has none of their columns.
        let known = i < runs.first.x.ncols();
        let truth = known.then(|| lines(truth, runs.first, &rows, |k| runs.first.x[(k, i)]));
        for truth in truth.into_iter().flatten() {
            panel = panel.series(truth.hue(Hue::Grey).dash(Dash::Solid).width(2.5));
        }
        for (number, member, run) in runs.shown() {
            let Some(estimate) = &run.estimate else { continue };
            for curve in lines(&member.requested.name, run, &runs.rows(run), |k| estimate[(k, i)]) {
                panel = panel.series(curve.numbered(number));
            }
            panel = bands(panel, runs, (number, member, run), |k| estimate[(k, i)], i);
            panel = smoothed(panel, runs, (number, member, run), |estimate, k| estimate[(k, i)]);
        }
        panel
    };
    let mut caption = match (runs.measured, runs.first.x.ncols()) {
        (true, 0) => "The estimates on the log.",
        (true, _) => "The estimates on the log, and the true states.",
        (false, _) => "The states of the plant, and their estimates.",
    }
    .to_owned();
    caption.push_str(&shaded(runs));
    figure("states", "States and estimates", &runs.caption(&caption), runs.states().into_iter().map(panel).collect())
}

/// The panel with a dashed curve of smoothed estimates, if the run has some.
fn smoothed(
    panel: Panel,
    runs: &Runs<'_>,
    (number, member, run): (usize, &Member<'_>, &Run),
    of: impl Fn(&DMatrix<f64>, usize) -> f64,
) -> Panel {
    let Some((estimate, _)) = &run.smoothed else { return panel };
    let name = format!("{}, smoothed", member.requested.name);
    let curves = lines(&name, run, &runs.rows(run), |k| of(estimate, k));
    curves
        .into_iter()
        .fold(panel, |panel, curve| panel.series(curve.numbered(number).dash(Dash::LongDashed).width(0.9)))
}

/// What the bands are, where there are some.
fn shaded(runs: &Runs<'_>) -> String {
    let any = |choose: &dyn Fn(&Member<'_>, &Run) -> bool| runs.shown().any(|(_, member, run)| choose(member, run));
    let mut bands = Vec::new();
    if any(&|member, run| run.deviation.is_some() && is_filter(member)) {
        bands.push("two standard deviations of a filter to either side, by its covariance P");
    }
    if any(&|member, run| run.deviation.is_some() && !is_filter(member)) {
        bands.push("two standard deviations of a stationary Kalman filter to either side, after its initial transient");
    }
    if any(&|_, run| run.half_width.is_some()) {
        bands.push("from the lower to the upper bound of an interval observer");
    }
    if bands.is_empty() { String::new() } else { format!(" Shaded: {}.", bands.join("; ")) }
}

/// The panel with the band `of` +- 2 sigma of state i of a filter, or +- r of an interval observer.
fn bands(
    mut panel: Panel,
    runs: &Runs<'_>,
    (number, member, run): (usize, &Member<'_>, &Run),
    of: impl Fn(usize) -> f64,
    i: usize,
) -> Panel {
    let (name, matrix, factor) = match (&run.deviation, &run.half_width) {
        (Some(deviation), _) => (format!("{} \u{b1} 2 sigma", member.requested.name), deviation, 2.0),
        (None, Some(half)) => (format!("{} bounds", member.requested.name), half, 1.0),
        (None, None) => return panel,
    };
    let half = |k: usize| factor * matrix[(k, i)];
    let rows = runs.rows(run);
    let count = rows.iter().map(Vec::len).sum();
    for stretch in &rows {
        // Both sides at the same rows, where the band is widest and narrowest.
        let kept = drawn(stretch, count, half);
        let side = |side: f64| line(&name, run, &kept, |k| of(k) + side * half(k));
        if let (Some(low), Some(high)) = (side(-1.0), side(1.0)) {
            panel = panel.area(Area::between(&name, &low.x, &low.y, &high.y).hue(Hue::Palette(number)));
        }
    }
    panel
}

fn errors(runs: &Runs<'_>) -> Named {
    if runs.first.x.ncols() == 0 {
        return None;
    }
    let panel = |i: usize| {
        let mut panel = Panel::new(runs.time(), format!("error of {}", runs.state(i)));
        // A log may know the truth of some states only.
        if runs.first.x.column(i).iter().all(|x| x.is_nan()) {
            return panel;
        }
        for (number, member, run) in runs.shown() {
            let Some(estimate) = &run.estimate else { continue };
            let error = |xhat: f64, k: usize| runs.study.plant.error(i, run.x[(k, i)], xhat);
            for curve in lines(&member.requested.name, run, &runs.rows(run), |k| error(estimate[(k, i)], k)) {
                panel = panel.series(curve.numbered(number));
            }
            panel = bands(panel, runs, (number, member, run), |_| 0.0, i);
            panel = smoothed(panel, runs, (number, member, run), |estimate, k| error(estimate[(k, i)], k));
        }
        by_steady_part(panel)
    };
    let sampled = runs.shown().any(|(_, member, _)| member.designed.runnable.period().is_some());
    let caption = if sampled && !runs.measured {
        "The errors e = x - xhat; those of sampled observers at their samples."
    } else {
        "The errors e = x - xhat."
    };
    let panels: Vec<Panel> = runs.states().into_iter().map(panel).collect();
    let inset = if panels.iter().any(|panel| panel.inset) { INSET } else { "" };
    let caption = format!("{caption}{}{inset}", shaded(runs));
    figure("errors", "Errors", &runs.caption(&caption), panels)
}

/// What an inset is, in a caption.
const INSET: &str =
    " The axis is that of the second half of the run where what is before is larger by far; inset: the whole run.";

/// How many times the range of its second half a figure of errors has to have for an inset.
const TRANSIENT: f64 = 5.0;

/// The share of the range of the second half that its last half has at least where the curves are steady.
const STEADY: f64 = 0.5;

/// The panel with the vertical axis of the second half of its curves and bands, with room for an inset of the whole
/// above, if the first half of the curves is larger by far. A part that still decays is not steady, and zero to
/// rounding has no axis of its own.
fn by_steady_part(panel: Panel) -> Panel {
    let times = || panel.series.iter().flat_map(|series| series.x.iter().copied());
    let (first, last) = (times().fold(f64::INFINITY, f64::min), times().fold(f64::NEG_INFINITY, f64::max));
    let middle = f64::midpoint(first, last);
    let range = |from: f64| {
        let points = panel.series.iter().flat_map(|series| series.x.iter().zip(&series.y));
        points.filter(|(t, _)| **t >= from).fold((0.0_f64, 0.0_f64), |(low, high), (_, y)| (low.min(*y), high.max(*y)))
    };
    let height = |(low, high): (f64, f64)| high - low;
    let (second_half, whole) = (range(middle), height(range(first)));
    if height(range(f64::midpoint(middle, last))) < STEADY * height(second_half) {
        return panel;
    }
    let bands = panel.areas.iter().flat_map(|area| area.x.iter().zip(area.low.iter().zip(&area.high)));
    let ends = bands.filter(|(t, _)| **t >= middle).map(|(_, ends)| ends);
    let (low, high) = ends.fold(second_half, |(low, high), (under, over)| (low.min(*under), high.max(*over)));
    let steady = high - low;
    if !(steady > 1e-9 * whole && whole > TRANSIENT * steady) {
        return panel;
    }
    let (low, high) = (low - 0.1 * steady, high + 0.1 * steady);
    panel.y_range(low, high + 0.75 * (high - low)).inset()
}

fn norm(runs: &Runs<'_>) -> Named {
    if runs.first.x.ncols() == 0 {
        return None;
    }
    // Without a scale there is no norm.
    let (scale, _) = super::scores::scale(runs.study, runs.study.simulation.as_ref()?)?;
    let mut panel = Panel::new(runs.time(), "|e| in units of scale").log_y();
    for (number, member, run) in runs.shown() {
        let Some(estimate) = &run.estimate else { continue };
        let size = |k: usize| {
            let entry = |(i, scale): (usize, &f64)| {
                (runs.study.plant.error(i, run.x[(k, i)], estimate[(k, i)]) / scale).powi(2)
            };
            let norm = scale.iter().enumerate().map(entry).sum::<f64>().sqrt();
            // Zero cannot be drawn on a logarithmic axis.
            if norm > 0.0 { norm } else { f64::NAN }
        };
        for curve in lines(&member.requested.name, run, &runs.rows(run), size) {
            panel = panel.series(curve.numbered(number));
        }
    }
    figure(
        "error-norm",
        "Norm of the error",
        "The norm of the error on a logarithmic axis: a straight line is an exponential.",
        vec![panel],
    )
}

fn columns(runs: &Runs<'_>, id: &str, title: &str, names: &[String], of: &DMatrix<f64>) -> Named {
    let rows = runs.rows(runs.first);
    let panel = |(j, name): (usize, &String)| {
        let curves = lines(name, runs.first, &rows, |k| of[(k, j)]);
        curves.into_iter().fold(Panel::new(runs.time(), runs.label(name)), Panel::series)
    };
    let noise = runs.study.simulation.as_ref().and_then(|simulation| simulation.noise.as_ref());
    let caption = match (id, noise) {
        ("outputs", Some(noise)) => format!("The measured outputs, with the noise of seed {}.", noise.seed),
        ("outputs", None) => "The measured outputs.".to_owned(),
        _ => String::new(),
    };
    figure(id, title, &caption, names.iter().enumerate().map(panel).collect())
}

/// Innovation `y - h(t, xhat, u)` of a run.
pub(super) fn innovation(study: &Study, run: &Run) -> Option<DMatrix<f64>> {
    if let Some(innovation) = &run.innovation {
        return Some(innovation.clone());
    }
    let estimate = run.estimate.as_ref()?;
    let mut innovation = run.y.clone();
    for k in 0..innovation.nrows() {
        let xhat = DVector::from_iterator(estimate.ncols(), estimate.row(k).iter().copied());
        let u = DVector::from_iterator(run.u.ncols(), run.u.row(k).iter().copied());
        let expected = study.plant.model.output(run.t[k], &xhat, &u);
        for j in 0..innovation.ncols() {
            innovation[(k, j)] = study.plant.innovation(j, innovation[(k, j)], expected[j]);
        }
    }
    Some(innovation)
}

fn innovations(runs: &Runs<'_>) -> Named {
    let all: Vec<_> = runs
        .shown()
        .filter_map(|(number, member, run)| Some((number, member, run, innovation(runs.study, run)?)))
        .collect();
    let panel = |(j, name): (usize, &String)| {
        let mut panel =
            Panel::new(runs.time(), format!("innovation of {}", runs.label(name))).mark(Mark::horizontal(0.0));
        for (number, member, run, innovation) in &all {
            for curve in lines(&member.requested.name, run, &runs.rows(run), |k| innovation[(k, j)]) {
                panel = panel.series(curve.numbered(*number));
            }
        }
        panel
    };
    let caption = "What each observer did not expect of the outputs, y - h(xhat): small and without pattern is good.";
    figure("innovations", "Innovations", caption, runs.study.plant.outputs.iter().enumerate().map(panel).collect())
}

/// Score of a row of a sweep.
type Score<'a> = Box<dyn Fn(&SweepRow) -> Option<f64> + 'a>;

/// The sweep: each score against the parameter. Without a norm, the scores of the states that are shown.
pub(super) fn sweep(study: &Study, report: &SweepReport) -> Named {
    let timed = |text: &str| with_unit(text, study.plant.time_unit.as_ref());
    let mut scores: Vec<(String, Score<'_>)> = Vec::new();
    if report.scoring.scale.is_some() {
        scores.push((timed("time to settle"), Box::new(|row| row.settling)));
        scores.push(("rms of |e|".to_owned(), Box::new(|row| row.rms)));
        scores.push(("largest |e|".to_owned(), Box::new(|row| row.peak)));
    } else {
        let all: Vec<usize> = (0..study.plant.states.len()).collect();
        for &i in study.plot.states.as_ref().unwrap_or(&all) {
            let label =
                with_unit(&format!("RMSE of {}", study.plant.states[i]), study.plant.unit(&study.plant.states[i]));
            scores.push((label, Box::new(move |row| Some(row.states.get(i)?.rmse))));
        }
    }
    let panel = |(label, score): (String, Score<'_>)| {
        let points = report.rows.iter().map(|row| (row.observer.as_str(), row.value, score(row)));
        swept(study, Panel::new(parameter(&report.parameter), label).log_x(), &points.collect::<Vec<_>>())
    };
    let caption = match report.ensemble {
        1 => "One run at each value.".to_owned(),
        runs => format!("Medians of {runs} runs at each value."),
    };
    figure("sweep", "Sweep", &caption, scores.into_iter().map(panel).collect())
}

/// A curve for each observer over the values of a sweep.
fn swept(study: &Study, mut panel: Panel, points: &[(&str, f64, Option<f64>)]) -> Panel {
    let mut observers: Vec<&str> = points.iter().map(|(name, ..)| *name).collect();
    observers.dedup();
    for name in observers {
        let of = points.iter().filter(|(other, ..)| *other == name);
        let mut points: Vec<(f64, f64)> = of.filter_map(|(_, value, score)| Some((*value, (*score)?))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        if points.len() > 1 {
            let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
            let curve = Series::line(name, &x, &y).numbered(place(study, name));
            panel = panel.series(curve.marker(luenberger_figures::Marker::Circle));
        }
    }
    panel
}

/// The sweep on a log: each score against the parameter.
pub(super) fn sweep_on_log(study: &Study, report: &LogSweepReport) -> Named {
    type Of = fn(&PredictionReport) -> Option<f64>;
    let mut scores: Vec<(&str, Of)> = vec![("relative innovation", |of| Some(of.relative))];
    let has = |of: Of| report.rows.iter().filter_map(|row| row.on_log.as_ref()).any(|one| of(one).is_some());
    let further: [(&str, Of); 2] =
        [("log-likelihood of a measurement", |of| of.log_likelihood), ("rms of |e|", |of| of.error)];
    scores.extend(further.into_iter().filter(|(_, of)| has(*of)));
    let is_log = report.values.iter().all(|value| *value > 0.0);
    let panel = |(label, score): (&str, Of)| {
        let panel = Panel::new(report.parameter.as_str(), label);
        let panel = if is_log { panel.log_x() } else { panel };
        let points =
            report.rows.iter().map(|row| (row.observer.as_str(), row.value, row.on_log.as_ref().and_then(score)));
        swept(study, panel, &points.collect::<Vec<_>>())
    };
    let caption = "The predictions of the part of the log that is held out.";
    figure("sweep", "Sweep", caption, scores.into_iter().map(panel).collect())
}

/// Axis label of the sweep parameter.
fn parameter(name: &str) -> &str {
    match name {
        "poles" => "factor of the poles",
        "noise" => "factor of the noise",
        "initial" => "factor of the initial error",
        name => name,
    }
}

/// The samples of an observer at varying periods as a table; none for other observers.
pub(super) fn samples_table(run: &Run) -> Option<Table> {
    let of = |value: &dyn Fn(&SampleTime) -> f64| run.samples.iter().map(value).collect::<Vec<f64>>();
    let table = Table::new().column("t", of(&|sample| sample.time));
    let table = table.column("arrives", of(&|sample| f64::from(u8::from(sample.arrives))));
    let table = table.column("elapsed", of(&|sample| sample.elapsed));
    (!run.samples.is_empty()).then_some(table)
}

/// A run as a table: t, states (on a log those whose truth is known), inputs, measured outputs, estimates `NAME_hat`,
/// of a filter two standard deviations `NAME_2sigma`, smoothed estimates `NAME_smoothed` with `NAME_smoothed_2sigma`,
/// of an interval observer the bounds `NAME_lower` and `NAME_upper`, functions of the state `z1` with `z1_hat`, and
/// estimates of disturbances `d1_hat`, probabilities of models `NAME_probability`. A value that is not known is an
/// empty cell.
pub(super) fn table(study: &Study, run: &Run) -> Table {
    let mut table = Table::new().column("t", run.t.clone());
    let mut add = |names: &[String], suffix: &str, of: &DMatrix<f64>| {
        for (column, name) in of.column_iter().zip(names) {
            if column.iter().all(|x| x.is_nan()) {
                continue;
            }
            let mut title = format!("{name}{suffix}");
            // A state and an output may have the same name; columns must not.
            while table.columns().iter().any(|(other, _)| *other == title) {
                title.push('\'');
            }
            let known = column.iter().map(|x| (!x.is_nan()).then_some(*x));
            table = std::mem::take(&mut table).column_with_missing(title, known);
        }
    };
    let plant = &study.plant;
    add(&plant.states, "", &run.x);
    add(&plant.inputs, "", &run.u);
    add(&plant.outputs, "", &run.y);
    if let Some(estimate) = &run.estimate {
        add(&plant.states, "_hat", estimate);
    }
    if let Some(deviation) = &run.deviation {
        add(&plant.states, "_2sigma", &(deviation * 2.0));
    }
    if let (Some(half), Some(estimate)) = (&run.half_width, &run.estimate) {
        add(&plant.states, "_lower", &(estimate - half));
        add(&plant.states, "_upper", &(estimate + half));
    }
    if let Some((estimate, deviation)) = &run.smoothed {
        add(&plant.states, "_smoothed", estimate);
        add(&plant.states, "_smoothed_2sigma", &(deviation * 2.0));
    }
    if let Some((names, functions, estimate)) = &run.functions {
        add(names, "", functions);
        add(names, "_hat", estimate);
    }
    if let Some(disturbance) = &run.disturbance {
        add(&disturbance.0, "_hat", &disturbance.1);
    }
    if let Some((names, modes)) = &run.modes {
        add(names, "_probability", modes);
    }
    table
}
