//! Fig. 2 in two parts, without and with noise, and the effect of the I&IO's gain under noise.

use luenberger_plants::CukConverter;
use luenberger_sim::{Trajectory, View};

use super::{noise, runs};
use crate::claim::CheckError;
use crate::context::Context;
use crate::figure::{Dash, Figure, Hue, Mark, Panel, Series};
use crate::paper::{Drawing, Plate};
use crate::table::Table;

pub(super) fn figures() -> Vec<Drawing> {
    vec![
        Drawing { id: "kkl-cuk-noise-free", draw: noise_free },
        Drawing { id: "kkl-cuk-noise", draw: noisy },
        Drawing { id: "kkl-cuk-gain", draw: gain },
    ]
}

/// The columns t, u, x and the estimates.
fn table(run: &Trajectory) -> Result<Table, CheckError> {
    let mut table = Table::new().column("t", run.t.clone()).column("u", run.u.column(0).as_slice());
    for (state, name) in ["i1", "v2", "i3", "v4"].into_iter().enumerate() {
        table = table.column(name, run.x.column(state).as_slice());
    }
    for (name, _) in runs::OBSERVERS {
        let estimate = &run.observer(name)?.estimate;
        for (entry, state) in ["i1", "v4"].into_iter().enumerate() {
            table = table.column(format!("{state}_{name}"), estimate.column(entry).as_slice());
        }
    }
    Ok(table)
}

const LABELS: [&str; 2] = ["input current i₁ (A)", "output voltage v₄ (V)"];
const ERRORS: [&str; 2] = ["largest error of i₁ in 4 ms (A)", "largest error of v₄ in 4 ms (V)"];
const TIME: &str = "time t (s)";
/// End of the panels that show the estimates, in s.
const START: f64 = 0.06;

fn with_jumps(panel: Panel) -> Panel {
    runs::jumps().into_iter().fold(panel, |panel, t| panel.mark(Mark::vertical(t)))
}

/// The state of the plant, over the whole run.
fn state(run: &Trajectory, entry: usize) -> Panel {
    let truth = Series::line("plant", &run.t, run.x.column(runs::ESTIMATED[entry]).as_slice());
    with_jumps(Panel::new(TIME, LABELS[entry]).series(truth.hue(Hue::Grey).dash(Dash::Solid).width(2.4)))
}

/// Places in [`runs::OBSERVERS`] that share a panel: with the plant no panel has more than four curves.
const AT_THE_START: [(&str, &[usize]); 3] = [
    ("the start: KKLO, PEBO, [KKL+PEB]O", &[0, 1, 2]),
    ("the start: I&IO, exact HGO", &[3, 6]),
    ("the start: the paper's HGOs", &[4, 5]),
];
const ERRORS_OF: [(&str, &[usize]); 2] =
    [("KKLO, PEBO, [KKL+PEB]O, I&IO", &[0, 1, 2, 3]), ("high-gain observers", &[4, 5, 6])];

/// The state and some of its estimates at the start: later they coincide at this scale.
fn start(run: &Trajectory, entry: usize, (title, shown): (&str, &[usize])) -> Result<Panel, CheckError> {
    // Fine enough for the oscillation of the time-varying high-gain observer at 450 Hz.
    let t: Vec<f64> = (0..=600).map(|k| START * f64::from(k) / 600.0).collect();
    let ms: Vec<f64> = t.iter().map(|t| 1e3 * t).collect();
    let state = runs::ESTIMATED[entry];
    let of = |read: &dyn Fn(&View<'_>) -> f64| -> Result<Vec<f64>, CheckError> {
        let trace = run.trace(read);
        Ok(t.iter().map(|&t| trace.at(t)).collect::<Result<_, _>>()?)
    };
    let truth = Series::line("plant", &ms, &of(&|view| view.x[state])?).hue(Hue::Grey).dash(Dash::Solid).width(2.4);
    let mut panel = Panel::new("time t (ms)", LABELS[entry]).title(title).x_range(0.0, 1e3 * START).series(truth);
    for &k in shown {
        let (name, label) = runs::OBSERVERS[k];
        let estimate = of(&|view| view.estimate(name).map_or(f64::NAN, |estimate| estimate[entry]))?;
        panel = panel.series(Series::line(label, &ms, &estimate).hue(Hue::Palette(k)));
    }
    Ok(panel)
}

/// The largest error in every 4 ms on a logarithmic scale from `floor` on, below which it is drawn at `floor`. 4 ms are
/// two periods of the fastest oscillation: samples at single points would show its beat with the sampling.
fn errors(
    run: &Trajectory,
    entry: usize,
    (floor, top): (f64, f64),
    (title, shown): (&str, &[usize]),
) -> Result<Panel, CheckError> {
    const WINDOWS: u32 = 300;
    const INSIDE: u32 = 20;
    let at = |k: u32| f64::from(k) / f64::from(WINDOWS * INSIDE) * 1.2;
    let times: Vec<f64> = (0..WINDOWS).map(|k| at(k * INSIDE + INSIDE / 2)).collect();
    let mut panel = Panel::new(TIME, ERRORS[entry]).title(title).log_y().x_range(0.0, 1.2).y_range(floor, top);
    for &k in shown {
        let (name, label) = runs::OBSERVERS[k];
        let trace = run.error_trace(name, entry)?;
        let mut largest = vec![floor; times.len()];
        for (window, largest) in (0..WINDOWS).zip(&mut largest) {
            for inside in 0..INSIDE {
                *largest = largest.max(trace.at(at(window * INSIDE + inside))?.abs());
            }
        }
        panel = panel.series(Series::line(label, &times, &largest).hue(Hue::Palette(k)));
    }
    Ok(with_jumps(panel))
}

/// The states, the estimates at the start, the errors: i1 on the left, v4 on the right.
fn panels(mut figure: Figure, run: &Trajectory, errors_of: [(f64, f64); 2]) -> Result<Figure, CheckError> {
    figure = figure.columns(2).panel(state(run, 0)).panel(state(run, 1));
    for (k, group) in AT_THE_START.into_iter().enumerate() {
        let (mut current, mut voltage) = (start(run, 0, group)?, start(run, 1, group)?);
        // The high-gain observers begin far away.
        if k == 2 {
            (current, voltage) = (current.y_range(-2.0, 4.0), voltage.y_range(-40.0, 5.0));
        }
        figure = figure.panel(current).panel(voltage);
    }
    for group in ERRORS_OF {
        figure = figure.panel(errors(run, 0, errors_of[0], group)?).panel(errors(run, 1, errors_of[1], group)?);
    }
    Ok(figure)
}

fn noise_free(context: &Context) -> Result<Plate, CheckError> {
    let run = runs::corrected(context)?;
    let figure = Figure::new("The observers of the Ćuk converter without noise, as in Fig. 2").caption(
        "Table I as it works, and an exact high-gain observer; |Vd| jumps at the thin lines. Errors below 10⁻¹⁰ are rounding. Only the linear high-gain observer, \
         which differentiates, is disturbed by the jumps.",
    );
    Ok(Plate { figure: panels(figure, &run, [(1e-10, 10.0), (1e-10, 100.0)])?, data: table(&run)? })
}

fn noisy(context: &Context) -> Result<Plate, CheckError> {
    let run = noise::shown(context)?;
    let figure = Figure::new("The observers of the Ćuk converter with noise, as in Fig. 2").caption(
        "As without noise, with uniform noise of ±0.02 V on v₂ and ±0.2 mA on i₃, held for 0.1 ms and seen by the observers only; seed 1.",
    );
    Ok(Plate { figure: panels(figure, &run, [(1e-4, 10.0), (1e-4, 100.0)])?, data: table(&run)? })
}

fn gain(context: &Context) -> Result<Plate, CheckError> {
    let (gains, rows) = (noise::gains(), noise::sweep(context)?);
    let of = |k: usize| -> [f64; 2] {
        let n = rows.len() as f64;
        let mean = rows.iter().map(|row| row[k]).sum::<f64>() / n;
        [mean, (rows.iter().map(|row| (row[k] - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()]
    };
    let [mean, deviation] = [0, 1].map(|which| (0..gains.len()).map(|k| of(k)[which]).collect::<Vec<_>>());
    let kklo = CukConverter::default().l1.recip();
    let mut panel = Panel::new("gain g₁ of the I&IO (1/s)", "root mean square of the error of i₁ (A)").log_x().log_y();
    for (k, &g1) in gains.iter().enumerate() {
        let bar = [mean[k] - deviation[k], mean[k] + deviation[k]];
        panel = panel.series(
            Series::line("± one standard deviation", &[g1, g1], &bar).hue(Hue::Grey).dash(Dash::Solid).width(2.0),
        );
    }
    panel = panel
        .series(Series::line("I&IO", &gains, &mean).hue(Hue::Palette(0)).marker(crate::figure::Marker::Circle))
        .mark(Mark::vertical(50.0).label("the paper's 50"))
        .mark(Mark::point(kklo, of(gains.len())[0]).label("KKLO: 1/L₁"));
    Ok(Plate {
        figure: Figure::new("The error of the I&IO under noise, by its gain")
            .caption(format!(
                "Root mean square of the error of i₁ from 0.4 s to 1.2 s: mean and standard deviation over the seeds 1 to {}. Below 20/s the transient of the start is not over by 0.4 s; to the right the direct \
                 way of the noise through C₂ g₁ y₁ takes over.",
                noise::SWEEP_SEEDS
            ))
            .panel(panel),
        data: Table::new().column("g1", gains).column("rms_i1", mean).column("deviation", deviation),
    })
}
