//! Beyond the paper: the numerical KKL observer, where phi has no closed form, on the reverse Duffing oscillator.

use std::sync::Arc;

use luenberger_design::numerical_kkl::{Domain, Escape, NumericalKklDesign, Settings, TargetSystem, Transform};
use luenberger_observers::Observer;
use luenberger_plants::ReverseDuffing;
use luenberger_sim::{Scenario, Trajectory};
use nalgebra::{SVector, Vector2};

use crate::claim::{CheckError, Claim, Class, Outcome};
use crate::context::Context;
use crate::evidence::Evidence;
use crate::figure::{Figure, Hue, Mark, Marker, Panel, Series};
use crate::paper::{Drawing, Plate};
use crate::table::Table;
use crate::value::short;

const PLANT: &str =
    "x1' = x2³, x2' = -x1, y = x1; box [-1, 1]², z' = D z + B y with n_z = 3, Bessel poles of cut-off 1.5";
const TRIAL: &str = "from x(0) = (0.5, 0.5), z(0) = 0, over t = 10 to 50; nothing was fitted on this trajectory";

const START: [f64; 2] = [0.5, 0.5];
const TRANSIENT: f64 = 10.0;
const END: f64 = 50.0;
/// Every 0.025.
const SAMPLES: usize = 2001;
const EMBEDDED: &str = "embedded";
const INTERPOLATED: &str = "interpolated";
/// Root mean squares of learned observers with n_z = 5 on the same trajectory.
const PUBLISHED: [f64; 2] = [6.9e-3, 1.1e-2];

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim::holds(
            Class::Ours,
            "kkl.duffing.numerical",
            "beyond the paper",
            "without a closed form of φ the states are estimated to root mean squares below 1e-4 and 1e-3 by the embedded form, below 1e-5 by the interpolated one (x1, x2 of each)",
            &[PLANT, TRIAL],
            numerical,
        ),
        Claim::holds(
            Class::Ours,
            "kkl.duffing.pde-residual",
            "beyond the paper, (4)",
            "T solves its PDE DT f = D T + B h on the box (largest residual relative to |B h|: by simulation, and of the spline)",
            &[PLANT, "at points that were not fitted"],
            residual,
        ),
    ]
}

type Design = NumericalKklDesign<2, 0, 1, 3>;

struct Fit {
    domain: Domain<2>,
    target: TargetSystem<1, 3>,
    design: Design,
}

/// About 4 s of processor time: once per run of the ledger.
fn fit(context: &Context) -> Result<Arc<Fit>, CheckError> {
    context.once("kkl.duffing", || {
        let (domain, target) = (Domain::new([-1.0; 2], [1.0; 2], Escape::Free)?, TargetSystem::bessel(1.5)?);
        let settings = Settings::default();
        let design =
            NumericalKklDesign::new(&ReverseDuffing, &target, &domain, SVector::zeros(), &settings, &mut |_| {
                std::ops::ControlFlow::Continue(())
            })?;
        Ok(Fit { domain, target, design })
    })
}

fn run(context: &Context) -> Result<Arc<Trajectory>, CheckError> {
    let fit = fit(context)?;
    context.once("kkl.duffing.run", || {
        Ok(Scenario::new(ReverseDuffing)
            .initial_state(&START)
            .observer(EMBEDDED, &fit.design.embedded, &[0.0; 2])
            .observer(INTERPOLATED, &fit.design.interpolated, &[0.0; 2])
            .tolerances(1e-10, 1e-11)
            .until(END, SAMPLES)
            .run()?)
    })
}

/// Root mean squares of the errors of x1 and x2 after the transient.
fn root_mean_squares(run: &Trajectory, name: &str) -> Result<[f64; 2], CheckError> {
    let first = run.t.iter().position(|&t| t >= TRANSIENT).ok_or("the run ends before the transient does")?;
    let rows = run.t.len() - first;
    let errors = run.observer(name)?.error.rows(first, rows);
    Ok([0, 1].map(|i| (errors.column(i).norm_squared() / rows as f64).sqrt()))
}

fn numerical(context: &Context) -> Result<Outcome, CheckError> {
    let (fit, run) = (fit(context)?, run(context)?);
    let (embedded, interpolated) = (root_mean_squares(&run, EMBEDDED)?, root_mean_squares(&run, INTERPOLATED)?);
    let holds = embedded[0] < 1e-4 && embedded[1] < 1e-3 && interpolated[0] < 1e-5 && interpolated[1] < 1e-5;
    let report = &fit.design.report;
    let cost = &report.embedded_footprint;
    Ok(Outcome::new(Evidence::holds_by(holds, [embedded[0], embedded[1], interpolated[0], interpolated[1]])).note(
        format!(
            "Learned observers are published with {} and {} on this trajectory, with n_z = 5. The embedded form is {} bytes in single precision, {} multiply-adds and {} comparisons \
             per estimate. Nothing here is proved: T is injective as far as the pairs of a grid tell (|T(x) - T(x')| ≥ {} |x - x'|), and flat in the origin.",
            short(PUBLISHED[0]),
            short(PUBLISHED[1]),
            cost.bytes_f32,
            cost.multiply_adds,
            cost.comparisons,
            short(report.injectivity.smallest_ratio)
        ),
    ))
}

fn residual(context: &Context) -> Result<Outcome, CheckError> {
    let fit = fit(context)?;
    let report = &fit.design.report;
    // The simulation keeps 1e-11 per memory of T, and the derivative of its flow loses two digits; the spline has cells
    // of h = 1/32, and h^3 = 3e-5 times third derivatives of order one in its slopes.
    let holds = report.simulated_residual < 1e-9 && report.residual.1 < 1e-4;
    Ok(Outcome::new(Evidence::holds_by(holds, [report.simulated_residual, report.residual.1])).note(format!(
        "T is the integral of y over the past of x, {} long, by simulation; DT by the variational equation.",
        short(report.horizon)
    )))
}

pub(super) fn figures() -> Vec<Drawing> {
    vec![
        Drawing { id: "kkl-duffing", draw: errors_in_time },
        Drawing { id: "kkl-duffing-map", draw: map },
        Drawing { id: "kkl-duffing-field", draw: field },
    ]
}

fn errors_in_time(context: &Context) -> Result<Plate, CheckError> {
    let run = run(context)?;
    let t = run.t.clone();
    let (mut figure, mut data) = (
        Figure::new("The numerical KKL observer on the reverse Duffing oscillator").caption(
            "Errors in time from x(0) = (0.5, 0.5), z(0) = 0, with n_z = 3. The lines are the root mean squares that learned observers are published with, n_z = 5.",
        ),
        Table::new().column("t", t.clone()),
    );
    for (i, published) in PUBLISHED.into_iter().enumerate() {
        let mut panel = Panel::new("time t", format!("error |x̂{0} - x{0}|", ["₁", "₂"][i]))
            .log_y()
            .y_range(1e-9, 1.0)
            .mark(Mark::horizontal(published).label(format!("published, {}", short(published))));
        for (place, name) in [EMBEDDED, INTERPOLATED].into_iter().enumerate() {
            // Zero has no place on the axis.
            let error: Vec<f64> = run.observer(name)?.error.column(i).iter().map(|e| e.abs().max(1e-12)).collect();
            panel = panel.series(Series::line(name, &t, &error).hue(Hue::Palette(place)).width(0.7));
            data = data.column(format!("e{}_{name}", i + 1), error);
        }
        figure = figure.panel(panel);
    }
    Ok(Plate { figure, data })
}

/// T along lines of constant x1.
fn map(context: &Context) -> Result<Plate, CheckError> {
    let fit = fit(context)?;
    let transform = Transform::new(&ReverseDuffing, &fit.target, &fit.domain, SVector::zeros(), 1e-11)?;
    let x2: Vec<f64> = (0..=80).map(|k| f64::from(k) / 40.0 - 1.0).collect();
    let (mut panels, mut data) =
        ([0, 1, 2].map(|i| Panel::new("x₂", ["T₁", "T₂", "T₃"][i])), Table::new().column("x2", x2.clone()));
    for k in 0..=4 {
        let x1 = 0.5 * f64::from(k) - 1.0;
        let images = x2.iter().map(|&x2| transform.at(&Vector2::new(x1, x2))).collect::<Result<Vec<_>, _>>()?;
        for (i, panel) in panels.iter_mut().enumerate() {
            let column: Vec<f64> = images.iter().map(|z| z[i]).collect();
            let series = Series::line(format!("x₁ = {x1}"), &x2, &column).hue(Hue::Ramp(0.22 * f64::from(k)));
            *panel = std::mem::replace(panel, Panel::new("", "")).series(series);
            data = data.column(format!("T{}_at_x1_{x1}", i + 1), column);
        }
    }
    let [first, second, third] = panels;
    Ok(Plate {
        figure: Figure::new("The transformation T of the reverse Duffing oscillator")
            .caption(
                "z = T(x) is where three filters of y settle that have listened to the whole past of x. It is odd, and flat in x₂ about the origin, where y' = x₂³ tells little.",
            )
            .columns(3)
            .panel(first)
            .panel(second)
            .panel(third),
        data,
    })
}

/// The error of both inverses over the box, as a raster of cells whose colour is the decade.
fn field(context: &Context) -> Result<Plate, CheckError> {
    /// Cells along x1 and x2.
    const CELLS: [u32; 2] = [58, 38];
    let fit = fit(context)?;
    let transform = Transform::new(&ReverseDuffing, &fit.target, &fit.domain, SVector::zeros(), 1e-11)?;
    let none = SVector::<f64, 0>::zeros();
    let (mut x1, mut x2, mut size) = (Vec::new(), Vec::new(), [Vec::new(), Vec::new()]);
    for (i, j) in (0..CELLS[0]).flat_map(|i| (0..CELLS[1]).map(move |j| (i, j))) {
        let centre = |k: u32, cells: u32| (2.0 * f64::from(k) + 1.0) / f64::from(cells) - 1.0;
        let x = Vector2::new(centre(i, CELLS[0]), centre(j, CELLS[1]));
        let (z, y) = (transform.at(&x)?, SVector::from([x[0]]));
        let error = [
            fit.design.embedded.estimate(0.0, &z, &none, &y) - x,
            fit.design.interpolated.estimate(0.0, &z, &none, &y) - x,
        ];
        x1.push(x[0]);
        x2.push(x[1]);
        size.iter_mut().zip(error).for_each(|(size, error)| size.push(error.norm()));
    }
    let mut figure = Figure::new("Where the two left inverses are good")
        .caption(
            "|x̂ - x| for z = T(x), over the box: 64 leaves of polynomials, and Gauss-Newton steps on the spline. Both lose digits about the origin, where T is flat.",
        )
        .columns(2);
    // 1e-7 and less to more than 1e-2.
    let decade = |e: f64| (e.log10().ceil().clamp(-7.0, -1.0) + 7.0) as usize;
    let names = ["≤ 10⁻⁷", "≤ 10⁻⁶", "≤ 10⁻⁵", "≤ 10⁻⁴", "≤ 10⁻³", "≤ 10⁻²", "> 10⁻²"];
    for (name, size) in [EMBEDDED, INTERPOLATED].into_iter().zip(&size) {
        let cell = Marker::Cell { width: 2.0 / f64::from(CELLS[0]), height: 2.0 / f64::from(CELLS[1]) };
        let mut panel = Panel::new("x₁", "x₂").title(format!("|x̂ - x|, {name}")).x_range(-1.0, 1.0).y_range(-1.0, 1.0);
        for (level, label) in names.into_iter().enumerate() {
            let chosen: Vec<usize> = (0..size.len()).filter(|&k| decade(size[k]) == level).collect();
            if chosen.is_empty() {
                continue;
            }
            let of = |column: &[f64]| chosen.iter().map(|&k| column[k]).collect::<Vec<_>>();
            let points = Series::points(label, &of(&x1), &of(&x2));
            panel = panel.series(points.hue(Hue::Ramp(level as f64 / 6.0)).marker(cell));
        }
        figure = figure.panel(panel);
    }
    let [embedded, interpolated] = size;
    Ok(Plate {
        figure,
        data: Table::new()
            .column("x1", x1)
            .column("x2", x2)
            .column("error_embedded", embedded)
            .column("error_interpolated", interpolated),
    })
}
