//! Example 2: the robot link with a flexible joint, classical and as printed. Figures 6 to 9.

use luenberger_linalg::spectral_abscissa;
use luenberger_observers::mean_value::beta::mean_value;
use luenberger_plants::flexible_joint;
use luenberger_sim::{Trajectory, View};
use nalgebra::{DMatrix, SVector, Vector1, Vector4};

use super::example1::{entries, error_panels, residual_panels};
use super::runs::{
    Experiment, OBSERVER, System, Theorem, Told, beta_solves, internal, last, norms, real, residuals, run, untold,
};
use crate::claim::{CheckError, Claim, Outcome};
use crate::context::Context;
use crate::evidence::{Evidence, Tolerance};
use crate::figure::{Figure, Panel, Series};
use crate::paper::{Drawing, Plate};
use crate::table::Table;
use crate::value::{Printed, Value, short};

pub(super) const XHAT0: &str = "x̂0 = (1, 2, .5, 1): its printed minus signs are misprints, since e0 = (2, 1, 2.5, 2)";
const ETA: &str = "η = 1, as printed";
const CLASSICAL: &str = "the classical plant: a44 = 0, y = (x1, x2)";
const AS_PRINTED: &str = "the plant as printed: a44 = 3.33, y = (x1, x2, x3); T = 2 s, because it is unstable";

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "mvt.ex2.xhat0-sign",
            place: "Example 2",
            statement: "x̂0 = (-1, -2, -0.5, -1), with e0 = x0 - x̂0 = (2, 1, 2.5, 2)",
            printed: Printed::Decimals("-1 -2 -.5 -1"),
            tolerance: Tolerance::AsPrinted,
            assumptions: &["x0 = (3, 3, 3, 3) and e0, as printed"],
            check: |_| {
                let start = System::Printed.start();
                Ok(Evidence::value(start.x.iter().zip(start.e0).map(|(x, e)| x - e).collect::<Vec<_>>()).into())
            },
        },
        Claim {
            id: "mvt.ex2.a44",
            place: "Example 2",
            statement: "A(4,4) of the single-link flexible joint is 3.33",
            printed: Printed::Decimals("3.33"),
            tolerance: Tolerance::AsPrinted,
            assumptions: &["compared with the benchmark that the paper cites for it"],
            check: |_| {
                let [classical, printed] =
                    [flexible_joint::classical().linear_part(), flexible_joint::printed().linear_part()];
                let abscissa =
                    |a: &nalgebra::Matrix4<f64>| spectral_abscissa(&DMatrix::from_column_slice(4, 4, a.as_slice()));
                Ok(Outcome::new(Evidence::value(classical[(3, 3)])).note(format!(
                    "The 3.33 of the sine has slipped into A: a link without friction would gain energy from its speed. The spectral abscissa of A is {} as printed and {} without it. \
                     Both plants are run here, each under its name.",
                    short(abscissa(&printed)?),
                    short(abscissa(&classical)?)
                )))
            },
        },
        Claim::holds(
            "mvt.ex2.classical-e0",
            "Example 2, Fig. 8",
            "with e0 the observer's error follows the real error, and both vanish (|x - x̂| at T = 10 s, classical plant)",
            &[XHAT0, ETA, CLASSICAL],
            |context| follows_when_told(context, System::Classical),
        ),
        Claim::holds(
            "mvt.ex2.printed-e0",
            "Example 2, Fig. 8",
            "with e0 the observer's error follows the real error, and both vanish (|x - x̂| at T = 2 s, plant as printed)",
            &[XHAT0, ETA, AS_PRINTED],
            |context| follows_when_told(context, System::Printed),
        ),
        Claim::holds(
            "mvt.ex2.classical-e01",
            "Example 2, Fig. 8",
            "with e01 the observer's error follows the real error: their difference falls below 5 % (classical plant)",
            &[XHAT0, ETA, CLASSICAL],
            classical_e01,
        ),
        Claim::holds(
            "mvt.ex2.printed-e01",
            "Example 2, Fig. 8",
            "with e01 the observer's error follows the real error (their difference at T = 2 s; it is 0.5 at first; plant as printed)",
            &[XHAT0, ETA, AS_PRINTED],
            |context| {
                let run = run(context, System::Printed, 1.0, Told::E01)?;
                let difference = norms(&untold(&run.trajectory)?);
                let (first, end) = (difference[0], last(&difference));
                let rate = (end / first).ln() / System::Printed.end();
                Ok(Outcome::new(Evidence::holds_by(end <= 0.05 * first, end)).note(format!(
                    "It grows at the mean rate {} per second, and the internal error is {} by then: the unmeasured row of d' = (D - [G_m 0; 0 0]) d keeps nearly all of the plant's instability.",
                    short(rate),
                    short(last(&norms(&internal(&run.trajectory)?)))
                )))
            },
        ),
        Claim::holds(
            "mvt.ex2.beta-in-unit-interval",
            "Example 2, Figs. 6, 7",
            "at every moment some β in [0, 1] makes X(β) = 0 (largest |X|)",
            &[XHAT0, ETA, "both plants, e0 and e01"],
            |context| {
                let (mut holds, mut largest) = (true, 0.0_f64);
                for system in [System::Classical, System::Printed] {
                    for told in [Told::E0, Told::E01] {
                        let (solved, x) = beta_solves(&*run(context, system, 1.0, told)?);
                        holds &= solved;
                        largest = largest.max(x);
                    }
                }
                Ok(Evidence::holds_by(holds, largest).into())
            },
        ),
        Claim::holds(
            "mvt.ex2.beta-continuous",
            "Lemma 1; Example 2, Fig. 6",
            "β is a variable that changes continuously with the ends of the segment",
            &[XHAT0, ETA, CLASSICAL, "e0"],
            |context| {
                let jump = jump(context)?;
                Ok(Outcome::new(Evidence::Counterexample {
                    what: format!(
                        "within {} s around t = {} s, where x̂3 and x3 lie on either side of a zero of the sine, β4 goes from {} to {}; less the steepest change there may be, 0.1",
                        short(jump.width),
                        short(jump.t),
                        short(jump.before),
                        short(jump.after)
                    ),
                    violation: (jump.after - jump.before).abs() - 0.1,
                    witness: Some(Value::from([jump.before, jump.after])),
                })
                .note(
                    "No rule avoids it. For small e3 the equation is r (β - ½) + ((β - ½)² - 1/12)/2 = 0 with r = f''/(f''' e3) in the middle of the segment: its roots in [0, 1] are \
                     ½ - r + √(r² + 1/12) for r ≥ -1/6 and ½ - r - √(r² + 1/12) for r ≤ 1/6, which never meet. The gradient itself is continuous, so the observer does not notice.",
                ))
            },
        ),
    ]
}

fn follows_when_told(context: &Context, system: System) -> Result<Outcome, CheckError> {
    let run = run(context, system, 1.0, Told::E0)?;
    let (difference, end) = (untold(&run.trajectory)?.amax(), last(&norms(real(&run.trajectory)?)));
    // Differences of states good to 1e-9.
    Ok(Outcome::new(Evidence::holds_by(difference < 1e-8 && end < 1e-8, end)).note(format!(
        "The largest difference of the two errors is {}. The observer was told x(0) by e0 = x0 - x̂0; it copies the plant from there.",
        short(difference)
    )))
}

fn classical_e01(context: &Context) -> Result<Outcome, CheckError> {
    const LONG: i32 = 100;
    let at_ten = norms(&untold(&run(context, System::Classical, 1.0, Told::E01)?.trajectory)?);
    let times = (0..=10 * LONG).map(|k| f64::from(k) / 10.0).collect();
    let e0 = System::Classical.start().e01;
    let trajectory =
        Experiment { eta: 1.0, e0, mean: Theorem::Beta, l: None, times, rtol: 1e-10 }.on(System::Classical)?;
    let long_run = norms(&untold(&trajectory)?);
    // The difference swings: its largest value over the last second, and over the last tenth of the long run.
    let swing = |values: &[f64], share: usize| {
        values[values.len() - values.len() / share..].iter().fold(0.0, |m: f64, d| m.max(*d))
    };
    let (before, after, end) = (at_ten[0], swing(&at_ten, 14), swing(&long_run, 10));
    Ok(Outcome::new(Evidence::Readings(vec![
        ("by T = 10 s", Value::Truth(after <= 0.05 * before)),
        ("by T = 100 s", Value::Truth(end <= 0.05 * before)),
    ]))
    .note(format!(
        "The paper prints no horizon. The difference is {} at first; it swings, with amplitude {} at 10 s and {} at 100 s. The link is an oscillator without friction, and the \
         measured rows, held by large gains, reach it only through their lag. The internal error is below 1e-8 after half a second.",
        short(before),
        short(after),
        short(end)
    )))
}

/// A jump of beta_4 on the run of the classical plant.
struct Jump {
    t: f64,
    width: f64,
    before: f64,
    after: f64,
}

/// x̂, e and beta_4 at a time of the run that was told x(0), where e is x - xhat.
fn segment(trajectory: &Trajectory, t: f64) -> Result<(Vector4<f64>, Vector4<f64>, f64), CheckError> {
    let at = |read: &dyn Fn(&View<'_>) -> f64| trajectory.trace(read).at(t);
    let (mut xhat, mut e) = (Vector4::zeros(), Vector4::zeros());
    for i in 0..4 {
        xhat[i] = at(&|view| view.estimate(OBSERVER).map_or(f64::NAN, |xhat| xhat[i]))?;
        e[i] = at(&|view| view.error(OBSERVER).map_or(f64::NAN, |e| e[i]))?;
    }
    let beta = mean_value(&flexible_joint::classical(), t, &xhat, &Vector1::new(t.sin()), &e).beta[3];
    Ok((xhat, e, beta))
}

/// The largest change of beta_4 between samples with an e3 of some size, halved down to a billionth of a second.
fn jump(context: &Context) -> Result<Jump, CheckError> {
    let run = run(context, System::Classical, 1.0, Told::E0)?;
    let trajectory = &run.trajectory;
    let beta = run.beta.column(3);
    let e3 = internal(trajectory)?.column(2).abs();
    let change = |k: &usize| (beta[k + 1] - beta[*k]).abs();
    // Where e3 is not so small that X is rounding.
    let k = (0..beta.len() - 1)
        .filter(|&k| e3[k] > 1e-2)
        .max_by(|j, k| change(j).total_cmp(&change(k)))
        .ok_or("no samples")?;
    let (mut from, mut to) = (trajectory.t[k], trajectory.t[k + 1]);
    let (mut before, mut after) = (beta[k], beta[k + 1]);
    while to - from > 1e-9 {
        let middle = f64::midpoint(from, to);
        let here = segment(trajectory, middle)?.2;
        if (here - before).abs() > (after - here).abs() {
            (to, after) = (middle, here);
        } else {
            (from, before) = (middle, here);
        }
    }
    Ok(Jump { t: from, width: to - from, before, after })
}

/// The time of the jump, `X_4(beta)` there at each of `betas`, and between which of them it changes its sign.
pub(super) fn two_roots(context: &Context, betas: &[f64]) -> Result<(f64, Vec<f64>, Vec<f64>), CheckError> {
    let run = run(context, System::Classical, 1.0, Told::E0)?;
    let t = jump(context)?.t;
    let (xhat, e, _) = segment(&run.trajectory, t)?;
    let u = SVector::<f64, 1>::new(t.sin());
    let x4 = entries(&residuals(&flexible_joint::classical(), t, &xhat, &u, &e, betas).transpose(), 3);
    let crosses = |k: &usize| (x4[*k] < 0.0) != (x4[k + 1] < 0.0);
    let root = |k: usize| betas[k] + (betas[k + 1] - betas[k]) * x4[k] / (x4[k] - x4[k + 1]);
    let roots = (0..betas.len() - 1).filter(crosses).map(root).collect();
    Ok((t, x4, roots))
}

pub(super) fn figures() -> Vec<Drawing> {
    vec![
        Drawing { id: "mvt-fig6", draw: fig6 },
        Drawing { id: "mvt-fig7", draw: fig7 },
        Drawing { id: "mvt-fig8", draw: fig8 },
        Drawing { id: "mvt-fig9", draw: super::peers::fig9 },
    ]
}

fn fig6(context: &Context) -> Result<Plate, CheckError> {
    let mut figure = Figure::new("Fig. 6: β of Example 2").columns(2).caption(
        "η = 1. β₁ = β₂ = β₃ = ½, because those rows are linear. β₄ jumps where x₃ passes π, and is ½ once e₃ is too small for X to tell (below about 10⁻⁴).",
    );
    let mut data = Table::new();
    for system in [System::Classical, System::Printed] {
        let [a, b] = [run(context, system, 1.0, Told::E0)?, run(context, system, 1.0, Told::E01)?];
        // The first 150 ms, sampled at the same times in both runs.
        let shown = |values: Vec<f64>| values[..75].to_vec();
        let t = shown(a.trajectory.t.clone());
        let (with_e0, with_e01) = (shown(entries(&a.beta, 3)), shown(entries(&b.beta, 3)));
        figure = figure.panel(
            Panel::new("time t (s)", "β₄")
                .title(if system == System::Classical { "classical plant" } else { "plant as printed" })
                .y_range(0.0, 1.0)
                .series(Series::line("e0", &t, &with_e0))
                .series(Series::line("e01", &t, &with_e01)),
        );
        let key = if system == System::Classical { "classical" } else { "printed" };
        if data.columns().is_empty() {
            data = data.column("t", t);
        }
        data = data.column(format!("beta4_{key}_e0"), with_e0).column(format!("beta4_{key}_e01"), with_e01);
    }
    Ok(Plate { figure, data })
}

fn fig7(context: &Context) -> Result<Plate, CheckError> {
    Ok(residual_panels(
        &*run(context, System::Classical, 1.0, Told::E0)?,
        ("X(β), in 10⁻¹⁴", 1e14, 1.0),
        Figure::new("Fig. 7: X(β) of Example 2")
            .caption("Classical plant, η = 1, e0. What is left of X is the rounding of terms of size 100; it ends when e is too small to change x̂."),
    ))
}

fn fig8(context: &Context) -> Result<Plate, CheckError> {
    error_panels(
        context,
        System::Classical,
        3.0,
        "Fig. 8: the observer's error and the real error of Example 2",
        "Classical plant, η = 1. From e0 the two coincide. From e01, which differs from it by 0.5 in the last entry, the internal error is gone in a fifth of a second, and the \
         real error swings on.",
    )
}
