//! Effect of increasing eta: the internal error converges faster, and the part of the initial error not given to the
//! observer more slowly.

use std::sync::Arc;

use super::runs::{Experiment, System, Theorem, internal, norms, not_given};
use crate::claim::{CheckError, Claim, Class, Outcome};
use crate::context::Context;
use crate::evidence::Evidence;
use crate::figure::{Dash, Figure, Hue, Marker, Panel, Series};
use crate::paper::{Drawing, Plate};
use crate::table::Table;
use crate::value::short;

/// The values of eta; the paper requires eta >= 1.
const ETAS: [f64; 8] = [0.6, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0];

pub(super) fn claims() -> Vec<Claim> {
    vec![Claim::holds(
        Class::Ours,
        "mvt.raising-eta",
        "beyond the paper: Theorem 1, (5)",
        "from η = 1 to η = 2 the internal error falls faster, and what was not given falls more slowly (rates of x - x̂ - e from e01 for η = 1 and 2: Example 1, then Example 2)",
        &[
            "the paper asks for η ≥ 1, takes 1, and says nothing of what more of it does",
            super::example2::PLANT,
            "mean rates of x - x̂ - e over 50 s in Example 1 and over 20 s in Example 2; of e over the first 2 s and 30 ms",
        ],
        |context| {
            let rates = rates(context)?;
            let at = |eta: f64| rates.iter().find(|rates| rates.eta.total_cmp(&eta).is_eq()).ok_or("no such η");
            let (one, two) = (at(1.0)?, at(2.0)?);
            let internal = two.internal > one.internal && two.internal_joint > one.internal_joint;
            let slower = two.error < one.error && two.joint < one.joint;
            Ok(Outcome::new(Evidence::holds_by(
                    internal && slower,
                    [one.error, two.error, one.joint, two.joint],
                ))
                .note(format!(
                    "The internal error falls at the rates {} and {} per second in Example 1, {} and {} in Example 2. A larger gain holds the measured rows tighter, so that less of the \
                     unmeasured error shows in them. On the variant with a44 as printed the error grows, at {} and {} per second.",
                    short(one.internal),
                    short(two.internal),
                    short(one.internal_joint),
                    short(two.internal_joint),
                    short(-one.printed),
                    short(-two.printed)
                )))
        },
    )]
}

/// Mean rates of decay, per second, negative for growth. "Error" is x - xhat - e, the part unknown to the observer: it
/// decays more slowly than e, and determines the rate of x - xhat.
struct Rates {
    eta: f64,
    /// Of the internal error in Example 1.
    internal: f64,
    /// Of the internal error in Example 2, which does not depend on what is measured.
    internal_joint: f64,
    /// Of the error in Example 1.
    error: f64,
    /// Of the error in Example 2.
    joint: f64,
    /// Of the error in its variant with a44 as printed.
    printed: f64,
}

fn rates(context: &Context) -> Result<Arc<Vec<Rates>>, CheckError> {
    context.once("mvt.eta", || ETAS.iter().map(|&eta| rates_at(eta)).collect())
}

fn rates_at(eta: f64) -> Result<Rates, CheckError> {
    let from_e01 = |system: System, times: Vec<f64>| {
        let e0 = system.start().e01;
        Experiment { eta, e0, mean: Theorem::Integral, l: None, times, rtol: 1e-11 }.on(system)
    };
    let rate = |before: f64, after: f64, time: f64| (before / after).ln() / time;

    let run = from_e01(System::Chaotic, vec![0.0, 2.0, 50.0])?;
    let (e, d) = (norms(&internal(&run)?), norms(&not_given(&run)?));
    let (of_e, of_d) = (rate(e[0], e[1], 2.0), rate(d[0], d[2], 50.0));

    // For eta = 6 the internal error of the joint is 1e-8 after 40 ms.
    let run = from_e01(System::Corrected, vec![0.0, 0.03, 20.0])?;
    let (e, d) = (norms(&internal(&run)?), norms(&not_given(&run)?));
    let (of_e_joint, of_d_joint) = (rate(e[0], e[1], 0.03), rate(d[0], d[2], 20.0));

    let d = norms(&not_given(&from_e01(System::Printed, vec![0.0, 2.0])?)?);
    let of_d_printed = rate(d[0], d[1], 2.0);
    Ok(Rates { eta, internal: of_e, internal_joint: of_e_joint, error: of_d, joint: of_d_joint, printed: of_d_printed })
}

pub(super) fn figures() -> Vec<Drawing> {
    vec![Drawing { id: "mvt-eta", draw: figure }]
}

fn figure(context: &Context) -> Result<Plate, CheckError> {
    let rates = rates(context)?;
    let of = |read: fn(&Rates) -> f64| rates.iter().map(read).collect::<Vec<_>>();
    let eta = of(|r| r.eta);
    let panel = |title: &str| Panel::new("η", "rate of decay (1/s)").title(title).log_x();
    let columns = [
        ("internal_ex1", of(|r| r.internal), panel("e, Example 1").log_y()),
        ("internal_ex2", of(|r| r.internal_joint), panel("e, Example 2").log_y()),
        ("error_ex1", of(|r| r.error), panel("x - x̂, Example 1").log_y()),
        ("error_ex2", of(|r| r.joint), panel("x - x̂, Example 2").log_y()),
    ];
    let mut figure = Figure::new("Beyond the paper: what raising η does").columns(2).caption(
        "Mean rates of decay from e01. The internal error e, of which the theorem speaks, falls faster with η. The real one, of which it does not, falls \
         more slowly.",
    );
    let mut data = Table::new().column("eta", eta.clone());
    for (k, (name, values, panel)) in columns.into_iter().enumerate() {
        let (legend, hue) = if k < 2 { ("internal error e", 0) } else { ("real error x - x̂", 1) };
        let series =
            Series::line(legend, &eta, &values).hue(Hue::Palette(hue)).dash(Dash::Solid).marker(Marker::Circle);
        figure = figure.panel(panel.series(series));
        data = data.column(name, values);
    }
    Ok(Plate { figure, data })
}
