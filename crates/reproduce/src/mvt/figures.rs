//! Figures that both examples have: the errors of their runs, and the residual of X(beta).

use luenberger_proof::wording::significant;
use nalgebra::DMatrix;

use super::runs::{Given, Run, System, internal, real, run};
use crate::claim::CheckError;
use crate::context::Context;
use crate::figure::{Bar, Figure, Hue, Mark, Panel, Series};
use crate::paper::Plate;
use crate::table::Table;

/// Column j.
pub(super) fn entries(m: &DMatrix<f64>, j: usize) -> Vec<f64> {
    m.column(j).iter().copied().collect()
}

/// The largest |X| of each row along a run, which is rounding noise and has no shape to be drawn, beside the size of
/// the terms of which it is the difference.
pub(super) fn residual_bars(run: &Run, title: &str, case: &str) -> Plate {
    let (mut panel, mut data) =
        (Panel::new("largest along the run", ""), Table::new().column("t", run.trajectory.t.clone()));
    let unit = f64::EPSILON / 2.0;
    let (floor, mut largest) = (unit / 100.0, unit);
    for i in 0..run.residual.ncols() {
        let row = ["₁", "₂", "₃", "₄"][i];
        let (x, terms) = (run.residual.column(i).amax(), run.terms.column(i).amax());
        let bars = [
            (format!("|X{row}|, rounding noise"), x.max(floor), Hue::Palette(i)),
            (format!("rounding unit of the terms of X{row}"), (unit * terms).max(floor), Hue::Grey),
        ];
        for (name, value, hue) in bars {
            largest = largest.max(value);
            let text = if value > floor { significant(value, 2) } else { "0".to_owned() };
            panel = panel.bar(Bar::to(name, value, text).hue(hue));
        }
        data = data.column(format!("X{}", i + 1), entries(&run.residual, i));
    }
    let caption = format!(
        "{case} What is left of X(β) at the β that was found is rounding noise, at most some tens of rounding units of its terms. The paper draws it over time; it has no shape."
    );
    Plate { figure: Figure::new(title).caption(caption).panel(panel.log_x().x_range(floor, 10.0 * largest)), data }
}

/// Errors of both runs in one panel per state, up to `end`.
pub(super) fn error_panels(
    context: &Context,
    system: System,
    end: f64,
    title: &str,
    caption: &str,
) -> Result<Plate, CheckError> {
    let [a, b] = [run(context, system, 1.0, Given::E0)?, run(context, system, 1.0, Given::E01)?];
    let t = &a.trajectory.t;
    let (given, partly, error) = (internal(&a.trajectory)?, internal(&b.trajectory)?, real(&b.trajectory)?);
    let mut figure = Figure::new(title).caption(caption).columns(if system.states() == 4 { 2 } else { 1 });
    let mut data = Table::new().column("t", t.clone());
    for i in 0..system.states() {
        let [e0, e01, truth] = [entries(&given, i), entries(&partly, i), entries(error, i)];
        figure = figure.panel(
            Panel::new("time t (s)", format!("error {}", i + 1))
                .x_range(0.0, end)
                .mark(Mark::horizontal(0.0))
                .series(Series::line("e = x - x̂, from e0", t, &e0).hue(Hue::Palette(0)))
                .series(Series::line("e, from e01", t, &e01).hue(Hue::Palette(1)))
                .series(Series::line("x - x̂, from e01", t, &truth).hue(Hue::Palette(2))),
        );
        data = data.column(format!("e{}_e0", i + 1), e0);
        data = data.column(format!("e{}_e01", i + 1), e01).column(format!("error{}_e01", i + 1), truth);
    }
    Ok(Plate { figure, data })
}
