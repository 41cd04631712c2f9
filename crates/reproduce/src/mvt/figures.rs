//! Figures that both examples have: the errors of their runs, and the residual of X(beta).

use nalgebra::DMatrix;

use super::runs::{Given, Run, System, internal, real, run};
use crate::claim::CheckError;
use crate::context::Context;
use crate::figure::{Dash, Figure, Hue, Mark, Panel, Series};
use crate::paper::Plate;
use crate::table::Table;

/// Column j.
pub(super) fn entries(m: &DMatrix<f64>, j: usize) -> Vec<f64> {
    m.column(j).iter().copied().collect()
}

/// |X| of each row along a run: rounding noise, beside the largest rounding unit of the terms of which it is the
/// difference.
pub(super) fn residual_evolution(run: &Run, end: f64, title: &str, case: &str) -> Plate {
    let t = &run.trajectory.t;
    let unit = f64::EPSILON / 2.0;
    // Zero has no place on the axis.
    let floor = unit / 100.0;
    let (mut figure, mut data) = (Figure::new(title).columns(2), Table::new().column("t", t.clone()));
    let top = 100.0 * unit * run.terms.amax();
    for i in 0..run.residual.ncols() {
        let row = ["₁", "₂", "₃", "₄"][i];
        let x = entries(&run.residual, i);
        let shown: Vec<f64> = x.iter().map(|x| x.abs().max(floor)).collect();
        let terms: Vec<f64> = run.terms.column(i).iter().map(|size| (unit * size).max(floor)).collect();
        figure = figure.panel(
            Panel::new("time t (s)", format!("|X{row}(β{row})|"))
                .log_y()
                .x_range(0.0, end)
                .y_range(floor, top)
                .series(Series::line(format!("|X{row}|"), t, &shown).hue(Hue::Palette(i)).dash(Dash::Solid).width(0.7))
                .series(Series::line("rounding unit of its terms", t, &terms).hue(Hue::Grey)),
        );
        data = data.column(format!("X{}", i + 1), x);
    }
    let caption = format!(
        "{case} What is left of X(β) at the β that was found is rounding noise, at most some tens of rounding units of its terms; an exact 0 is drawn at 10⁻¹⁸."
    );
    Plate { figure: figure.caption(caption), data }
}

/// Errors of both runs in one panel per state, up to `end`.
pub(super) fn error_panels(
    context: &Context,
    system: System,
    [end, inset]: [f64; 2],
    title: &str,
    caption: &str,
) -> Result<Plate, CheckError> {
    let [a, b] = [run(context, system, 1.0, Given::E0)?, run(context, system, 1.0, Given::E01)?];
    let t = &a.trajectory.t;
    let (given, partly, error) = (internal(&a.trajectory)?, internal(&b.trajectory)?, real(&b.trajectory)?);
    let mut figure = Figure::new(title).caption(caption).columns(2);
    let mut data = Table::new().column("t", t.clone());
    for i in 0..system.states() {
        let [e0, e01, truth] = [entries(&given, i), entries(&partly, i), entries(error, i)];
        // The whole run, and beside it the beginning.
        for (end, title) in [(end, format!("{end} s")), (inset, format!("the first {inset} s"))] {
            figure = figure.panel(
                Panel::new("time t (s)", format!("error {}", i + 1))
                    .title(title)
                    .x_range(0.0, end)
                    .mark(Mark::horizontal(0.0))
                    .series(Series::line("e = x - x̂, from e0", t, &e0).hue(Hue::Palette(0)))
                    .series(Series::line("e, from e01", t, &e01).hue(Hue::Palette(1)))
                    .series(Series::line("x - x̂, from e01", t, &truth).hue(Hue::Palette(2))),
            );
        }
        data = data.column(format!("e{}_e0", i + 1), e0);
        data = data.column(format!("e{}_e01", i + 1), e01).column(format!("error{}_e01", i + 1), truth);
    }
    Ok(Plate { figure, data })
}
