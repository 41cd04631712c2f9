//! Example 1: the double integrator. Figures 1 to 5, and error trajectories for all directions of e(0).

use std::sync::Arc;

use luenberger_design::{CubicDesign, CubicGain, LinearDesign, LyapunovWeight};
use luenberger_live::{self as live, Experiment, ObserverKind};
use luenberger_observers::{CubicObserver, Observer};
use luenberger_plants::{StateSpace, double_integrator};
use luenberger_sim::{Scenario, Signal, Trajectory, metrics};
use nalgebra::{DMatrix, DVector, Dyn};

use super::certified;
use super::random::Random;
use super::theorems::random_designs;
use crate::claim::{CheckError, Claim, Class, Outcome, Quote};
use crate::context::Context;
use crate::evidence::{Evidence, Tolerance};
use crate::figure::{Figure, Hue, Mark, Panel, Series};
use crate::paper::{Drawing, LiveExample, Plate};
use crate::table::Table;
use crate::value::{Printed, short};

/// e(0) = x(0) - xhat(0) for the printed x(0) = (-3, -3) and xhat(0) = 0.
const E0: [f64; 2] = [-3.0, -3.0];
/// The 5% band of the paper's footnote, in the unit of e2.
const BAND: f64 = 0.05;
const XHAT0: &str = "x̂(0) = 0, so that e(0) = (-3, -3)";
const GRID: &str = "the peak is the largest of the samples at 0, 0.1, 0.2, .. s";
const PEAKS: Quote = Quote {
    text: "the cubic observer yields a smaller peak (0.48 compared to 1.18)",
    reading: "the largest sample of e2 after its change of sign; the step of the samples is not printed",
};

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "cubic.ex1.gain",
            class: Class::Example,
            place: "Example 1",
            statement: "the observer poles -2, -5 give L = (7, 10)",
            printed: Printed::Decimals("7; 10"),
            tolerance: Tolerance::Relative(1e-12),
            assumptions: &[],
            quote: None,
            proof: None,
            check: |_| Ok(Evidence::value(&linear()?.observer.l).into()),
        },
        Claim {
            id: "cubic.ex1.lyapunov",
            class: Class::Example,
            place: "Example 1",
            statement: "P solves (9) for Q = 10 I",
            printed: Printed::Decimals("7.8571 -5; -5 4.2857"),
            tolerance: Tolerance::Absolute(0.000_05),
            assumptions: &[],
            quote: None,
            proof: None,
            check: |_| Ok(Evidence::value(&linear()?.p).into()),
        },
        Claim {
            id: "cubic.ex1.cubic-gain",
            class: Class::Example,
            place: "Example 1, (14)",
            statement: "N = -γ P⁻¹ C' θ for γ = 2, θ = 10",
            printed: Printed::Decimals("-9.8824; -11.5294"),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[],
            quote: None,
            proof: None,
            check: |_| Ok(Evidence::value(&cubic()?.observer.n).into()),
        },
        Claim {
            id: "cubic.ex1.peak-cubic",
            class: Class::Reading,
            place: "Example 1, Fig. 4",
            statement: "the peak of the error of the cubic observer is 0.48",
            printed: Printed::Decimals("0.48"),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[XHAT0, "the signal is e2 and the peak its overshoot after the change of sign", GRID],
            quote: Some(PEAKS),
            proof: None,
            check: |context| peak(context, "cubic"),
        },
        Claim {
            id: "cubic.ex1.peak-linear",
            class: Class::Reading,
            place: "Example 1, Fig. 4",
            statement: "the peak of the error of the linear observer is 1.18",
            printed: Printed::Decimals("1.18"),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[XHAT0, "the signal is e2 and the peak its overshoot after the change of sign", GRID],
            quote: Some(PEAKS),
            proof: None,
            check: |context| peak(context, "linear"),
        },
        Claim {
            id: "cubic.ex1.settling-cubic",
            class: Class::Example,
            place: "Example 1, Fig. 4",
            statement: "the 5% settling time of the cubic observer is 1.7 s",
            printed: Printed::Decimals("1.7"),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[XHAT0, "the signal is e2; settling is the last time |e2| = 0.05"],
            quote: None,
            proof: None,
            check: |context| settling(context, "cubic"),
        },
        Claim {
            id: "cubic.ex1.settling-linear",
            class: Class::Example,
            place: "Example 1, Fig. 4",
            statement: "the 5% settling time of the linear observer is 2.3 s",
            printed: Printed::Decimals("2.3"),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[XHAT0, "the signal is e2; settling is the last time |e2| = 0.05"],
            quote: None,
            proof: None,
            check: |context| settling(context, "linear"),
        },
        Claim {
            id: "cubic.ex1.settling-first-crossing",
            class: Class::Reading,
            place: "Example 1, footnote",
            statement: "settling is the time at which the error is less than 0.05 for the first time (cubic 1.7 s, linear 2.3 s)",
            printed: Printed::Decimals("1.7 2.3"),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[XHAT0, "the error is the vector e, and its size the norm"],
            quote: Some(Quote {
                text: "We define the settling time as the time during which the error shrinks to less than .05 for the first time.",
                reading: "\"the estimation error\" of the sentence that the footnote belongs to is e of (3) and (6), a vector",
            }),
            proof: None,
            check: first_crossings,
        },
        Claim {
            id: "cubic.ex1.faster-from-every-direction",
            class: Class::Ours,
            place: "beyond the paper: Example 1",
            statement: "from some directions of e(0) the cubic observer settles later than the linear one (share of the directions with |e(0)| = 3 √2 from which it settles before)",
            printed: Printed::Holds(true),
            tolerance: Tolerance::AsPrinted,
            assumptions: &["360 equally spaced directions", "settling is the last time |e2| = 0.05"],
            quote: None,
            proof: None,
            check: every_direction,
        },
        Claim {
            id: "cubic.eq4.input",
            class: Class::Theorem,
            place: "after (7)",
            statement: "the input does not affect the error: the largest difference of e with u = sin t and with u = 0 is rounding",
            printed: Printed::Holds(true),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[XHAT0, "and the rates of the error of random plants at 150 random x, e and u"],
            quote: None,
            proof: None,
            check: input_does_not_matter,
        },
        Claim {
            id: "cubic.fig1",
            class: Class::Example,
            place: "Fig. 1",
            statement: "the cubic estimate of x2 approaches x2 faster (settling times, cubic and linear)",
            printed: Printed::Holds(true),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[XHAT0, "T = 4 s"],
            quote: None,
            proof: None,
            check: |context| {
                let run = example(context)?;
                let [c, l] = both(|name| last_settling(&run, name))?;
                Ok(Evidence::holds_by(c < l, [c, l]).into())
            },
        },
        Claim {
            id: "cubic.fig2",
            class: Class::Example,
            place: "Fig. 2",
            statement: "in the first 10 ms the cubic observer's Lyapunov function falls faster (V at 10 ms, cubic and linear)",
            printed: Printed::Holds(true),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[XHAT0],
            quote: None,
            proof: None,
            check: |context| falls_below(context, 0.01),
        },
        Claim {
            id: "cubic.fig3",
            class: Class::Example,
            place: "Fig. 3",
            statement: "in the first second the cubic observer's Lyapunov function stays below the linear one's (V at 1 s, cubic and linear)",
            printed: Printed::Holds(true),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[XHAT0],
            quote: None,
            proof: None,
            check: |context| falls_below(context, 1.0),
        },
        Claim {
            id: "cubic.fig4",
            class: Class::Example,
            place: "Fig. 4",
            statement: "the cubic observer has the smaller peak and the smaller settling time (peaks, then settling times, cubic and linear)",
            printed: Printed::Holds(true),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[XHAT0],
            quote: None,
            proof: None,
            check: |context| {
                let run = example(context)?;
                let [pc, pl] = both(|name| overshoot(&run, name))?;
                let [sc, sl] = both(|name| last_settling(&run, name))?;
                Ok(Evidence::holds_by(pc < pl && sc < sl, [pc, pl, sc, sl]).into())
            },
        },
        Claim {
            id: "cubic.fig5",
            class: Class::Example,
            place: "Fig. 5",
            statement: "γ may be used as a design parameter: the overshoot of e2 falls with γ (γ = 0, 0.1, 0.5, 2, 10)",
            printed: Printed::Holds(true),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[XHAT0, "the paper does not print its list of γ"],
            quote: None,
            proof: None,
            check: |context| {
                let overshoots =
                    sweep(context)?.iter().map(|(_, run)| overshoot(run, "cubic")).collect::<Result<Vec<_>, _>>()?;
                let falls = overshoots.windows(2).all(|pair| pair[1] < pair[0]);
                Ok(Evidence::holds_by(falls, overshoots).into())
            },
        },
    ]
}

/// The plant of Example 1.
pub(super) fn plant() -> StateSpace {
    double_integrator().to_dynamic()
}

/// The linear observer of Example 1.
pub(super) fn linear() -> Result<LinearDesign, CheckError> {
    Ok(LinearDesign::with_poles_and_weight(&plant(), &[-2.0, -5.0], LyapunovWeight::Identity(10.0))?)
}

/// The cubic observer of Example 1.
pub(super) fn cubic() -> Result<CubicDesign, CheckError> {
    with_gamma(2.0)
}

/// The example in the page of the report.
pub(super) fn live() -> LiveExample {
    LiveExample {
        id: "live-example-1",
        title: "Example 1",
        about: "The double integrator from e(0) = (-3, -3), the linear observer and the cubic one with gamma = 2. The cubic term pays while the error is large: move the first error.",
        experiment: || {
            let mut experiment = Experiment::new(live::StoredPlant::linear(&plant()), &E0, 4.0, 401)
                .observer(certified(
                    "linear",
                    ObserverKind::Linear(Box::new(linear()?.observer.clone())),
                    &linear()?.certificate,
                    2,
                )?)
                .observer(certified(
                    "cubic",
                    ObserverKind::Cubic(Box::new(cubic()?.observer.clone())),
                    &cubic()?.certificate,
                    2,
                )?);
            experiment.input = vec!["sin(t)".to_owned()];
            Ok(experiment)
        },
    }
}

fn with_gamma(gamma: f64) -> Result<CubicDesign, CheckError> {
    Ok(CubicDesign::new(&linear()?, &DMatrix::from_element(1, 1, 10.0), &CubicGain::Gamma(gamma))?)
}

/// Both observers from the estimate 0, for a plant that starts at `e0`.
fn race(e0: [f64; 2], input: Signal<'_>, end: f64) -> Result<Trajectory, CheckError> {
    Ok(Scenario::new(plant())
        .initial_state(&e0)
        .input(input)
        .observer("cubic", cubic()?.observer.clone(), &[0.0, 0.0])
        .observer("linear", linear()?.observer.clone(), &[0.0, 0.0])
        .until(end, 801)
        .run()?)
}

/// The run behind Figures 1 to 4.
fn example(context: &Context) -> Result<Arc<Trajectory>, CheckError> {
    context.once("cubic.ex1", || race(E0, Signal::scalar(f64::sin), 4.0))
}

/// The runs behind Figure 5, by gamma.
fn sweep(context: &Context) -> Result<Arc<Vec<(f64, Trajectory)>>, CheckError> {
    context.once("cubic.ex1.sweep", || {
        [0.0, 0.1, 0.5, 2.0, 10.0]
            .into_iter()
            .map(|gamma| {
                // gamma = 0 is the linear observer, which the design of a cubic one rightly refuses.
                let mut observer: CubicObserver<f64, Dyn, Dyn, Dyn> =
                    with_gamma(if gamma > 0.0 { gamma } else { 1.0 })?.observer.clone();
                if gamma == 0.0 {
                    observer.n.fill(0.0);
                }
                let run = Scenario::new(plant())
                    .initial_state(&E0)
                    .input(Signal::scalar(f64::sin))
                    .observer("cubic", observer, &[0.0, 0.0])
                    .until(4.0, 801)
                    .run()?;
                Ok((gamma, run))
            })
            .collect()
    })
}

fn both(f: impl Fn(&'static str) -> Result<f64, CheckError>) -> Result<[f64; 2], CheckError> {
    Ok([f("cubic")?, f("linear")?])
}

fn overshoot(run: &Trajectory, name: &str) -> Result<f64, CheckError> {
    Ok(metrics::overshoot(&run.error_trace(name, 1)?).ok_or("e2 never changes its sign")?.value.abs())
}

fn last_settling(run: &Trajectory, name: &str) -> Result<f64, CheckError> {
    Ok(metrics::settling_last(&run.error_trace(name, 1)?, BAND).ok_or("e2 does not settle in the time of the run")?)
}

/// The largest |e2| after its change of sign, of the samples every tenth of a second.
fn peak(context: &Context, name: &str) -> Result<Outcome, CheckError> {
    let run = example(context)?;
    let trace = run.error_trace(name, 1)?;
    let crossing = trace.first_sign_change().ok_or("e2 never changes its sign")?;
    let mut largest = 0.0_f64;
    for k in 0..=40 {
        let t = f64::from(k) / 10.0;
        if t > crossing {
            largest = largest.max(trace.at(t)?.abs());
        }
    }
    Ok(Outcome::new(Evidence::value(largest)).note(format!(
        "Between the samples it reaches {}, which would be printed otherwise. The largest |e2| of all is {}, at t = {} s.",
        short(overshoot(&run, name)?),
        short(metrics::peak(&trace)?.value.abs()),
        short(metrics::peak(&trace)?.time)
    )))
}

fn settling(context: &Context, name: &str) -> Result<Outcome, CheckError> {
    Ok(Evidence::value(last_settling(&*example(context)?, name)?).into())
}

fn first_crossings(context: &Context) -> Result<Outcome, CheckError> {
    let run = example(context)?;
    let never = "the error never enters the band";
    let size = |name: &'static str| {
        run.trace(move |view| view.error(name).map_or(f64::NAN, |e| e.iter().map(|e| e * e).sum::<f64>().sqrt()))
    };
    let of_norm = both(|name| Ok(metrics::settling_first(&size(name), BAND).ok_or(never)?))?;
    let of_e2 = both(|name| Ok(metrics::settling_first(&run.error_trace(name, 1)?, BAND).ok_or(never)?))?;
    Ok(Outcome::new(Evidence::value(of_norm)).note(format!(
        "The second component alone, which Fig. 4 shows, is below 0.05 for an instant at {} and {} s, where it changes its sign; its last times, {} and {} s, round to the printed ones too.",
        short(of_e2[0]),
        short(of_e2[1]),
        short(last_settling(&run, "cubic")?),
        short(last_settling(&run, "linear")?)
    )))
}

fn every_direction(_: &Context) -> Result<Outcome, CheckError> {
    const DIRECTIONS: u32 = 360;
    let radius = f64::hypot(E0[0], E0[1]);
    let mut faster = 0;
    let mut worst = (0.0, [0.0; 2]);
    // Every trajectory has its mirror image, so half of the circle tells all.
    for k in 0..DIRECTIONS / 2 {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(DIRECTIONS);
        let e0 = [radius * angle.cos(), radius * angle.sin()];
        let run = race(e0, Signal::zero(), 8.0)?;
        let [c, l] = both(|name| last_settling(&run, name))?;
        if c < l {
            faster += 2;
        }
        if c - l > worst.0 {
            worst = (c - l, e0);
        }
    }
    let share = f64::from(faster) / f64::from(DIRECTIONS);
    let (late, e0) = worst;
    Ok(Outcome::new(Evidence::holds_by(faster < DIRECTIONS && late > 0.0, share)).note(format!(
        "From e(0) = ({}, {}) the cubic observer settles {} s later. The paper says \"in the beginning\": of V that is true, of |e| it is not (cubic.thm3.faster).",
        short(e0[0]),
        short(e0[1]),
        short(late)
    )))
}

fn input_does_not_matter(context: &Context) -> Result<Outcome, CheckError> {
    let (with, without) = (example(context)?, race(E0, Signal::zero(), 4.0)?);
    let mut difference = 0.0_f64;
    for name in ["cubic", "linear"] {
        difference = difference.max((&with.observer(name)?.error - &without.observer(name)?.error).amax());
    }
    // And of random plants the rate of the error, at random x, e and u, with u and without: by rounding of its terms.
    let (mut random, mut cases, mut equal) = (Random::new(), 1, true);
    for design in random_designs(|_, _| CubicGain::Gamma(1.0))? {
        let o = &design.observer;
        for _ in 0..10 {
            let (x, e, u) = (random.vector(o.a.nrows()), random.vector(o.a.nrows()), random.vector(o.b.ncols()));
            let (xhat, y, none) = (&x - &e, &o.c * &x, DVector::zeros(o.b.ncols()));
            let rate = |u: &DVector<f64>| &o.a * &x + &o.b * u - o.derivative(0.0, &xhat, u, &y);
            let (with, without) = (rate(&u), rate(&none));
            let size = o.a.norm() * x.norm() + o.b.norm() * u.norm() + with.norm() + without.norm();
            equal &= (with - without).norm() <= 64.0 * f64::EPSILON * size;
            cases += 1;
        }
    }
    // The two runs choose their own steps, each to a relative accuracy of 1e-11 of a plant state of size 20.
    Ok(Outcome::new(Evidence::holds_by(equal && difference < 1e-9, difference)).instances(cases))
}

/// V of both observers at `samples` times of the first `end` seconds: (t, cubic, linear).
fn lyapunov_functions(context: &Context, end: f64, samples: usize) -> Result<[Vec<f64>; 3], CheckError> {
    let (run, p) = (example(context)?, linear()?.p.clone());
    let t: Vec<f64> = (0..samples).map(|k| end * k as f64 / (samples - 1) as f64).collect();
    let values = |name| -> Result<Vec<f64>, CheckError> {
        let v = metrics::lyapunov_trace(&run, name, &p)?;
        Ok(t.iter().map(|&t| v.at(t)).collect::<Result<_, _>>()?)
    };
    Ok([t.clone(), values("cubic")?, values("linear")?])
}

fn falls_below(context: &Context, end: f64) -> Result<Outcome, CheckError> {
    let [_, cubic, linear] = lyapunov_functions(context, end, 1001)?;
    let below = cubic.iter().zip(&linear).skip(1).all(|(c, l)| c < l);
    let at_end = cubic.last().zip(linear.last()).map(|(c, l)| [*c, *l]).ok_or("no samples")?;
    Ok(Evidence::holds_by(below, at_end).into())
}

pub(super) fn figures() -> Vec<Drawing> {
    vec![
        Drawing { id: "cubic-fig1", draw: fig1 },
        Drawing {
            id: "cubic-fig2",
            draw: |context| lyapunov_figure(context, 0.01, "Fig. 2: Lyapunov functions, the first 10 ms"),
        },
        Drawing {
            id: "cubic-fig3",
            draw: |context| lyapunov_figure(context, 1.0, "Fig. 3: Lyapunov functions, the first second"),
        },
        Drawing { id: "cubic-fig4", draw: fig4 },
        Drawing { id: "cubic-fig5", draw: fig5 },
        Drawing { id: "cubic-fan", draw: fan },
    ]
}

fn column(m: &DMatrix<f64>, j: usize) -> Vec<f64> {
    m.column(j).iter().copied().collect()
}

fn fig1(context: &Context) -> Result<Plate, CheckError> {
    let run = example(context)?;
    let (x2, cubic, linear) =
        (column(&run.x, 1), column(&run.observer("cubic")?.estimate, 1), column(&run.observer("linear")?.estimate, 1));
    let panel = Panel::new("time t (s)", "state x₂ and its estimates")
        .series(Series::line("x₂", &run.t, &x2).hue(Hue::Palette(6)))
        .series(Series::line("cubic", &run.t, &cubic).hue(Hue::Palette(0)))
        .series(Series::line("linear", &run.t, &linear).hue(Hue::Palette(1)));
    Ok(Plate {
        figure: Figure::new("Fig. 1: the second state and its estimates")
            .caption("Example 1, u = sin t, x(0) = (-3, -3), both observers from 0.")
            .panel(panel),
        data: Table::new()
            .column("t", run.t.clone())
            .column("x2", x2)
            .column("x2_cubic", cubic)
            .column("x2_linear", linear),
    })
}

/// The time in which the cubic term acts, of the panels beside Fig. 3 to 5.
const BEGINNING: f64 = 0.02;
const FIRST: &str = "the first 20 ms";

fn lyapunov_panel(context: &Context, end: f64) -> Result<(Panel, [Vec<f64>; 3]), CheckError> {
    let values = lyapunov_functions(context, end, 501)?;
    let [t, cubic, linear] = &values;
    let (unit, scale) = if end < 0.1 { ("time t (ms)", 1e3) } else { ("time t (s)", 1.0) };
    let shown: Vec<f64> = t.iter().map(|t| t * scale).collect();
    let panel = Panel::new(unit, "V = e′Pe")
        .series(Series::line("cubic", &shown, cubic))
        .series(Series::line("linear", &shown, linear));
    Ok((panel, values))
}

fn lyapunov_figure(context: &Context, end: f64, title: &str) -> Result<Plate, CheckError> {
    let (panel, [t, cubic, linear]) = lyapunov_panel(context, end)?;
    let mut figure = Figure::new(title)
        .caption(
            "Example 1, the same P for both observers, from e(0) = (-3, -3). V itself is positive: the \"large negative\" of the text is its derivative, -(e'Qe) and the cubic term of (8).",
        )
        .columns(2)
        .panel(panel);
    if end > BEGINNING {
        figure = figure.panel(lyapunov_panel(context, BEGINNING)?.0.title(FIRST));
    }
    Ok(Plate { figure, data: Table::new().column("t", t).column("v_cubic", cubic).column("v_linear", linear) })
}

/// e2 of an observer in the first 20 ms, over the time in milliseconds.
fn beginning(run: &Trajectory, observer: &str) -> Result<[Vec<f64>; 2], CheckError> {
    let t: Vec<f64> = (0..=200).map(|k| BEGINNING * f64::from(k) / 200.0).collect();
    let trace = run.error_trace(observer, 1)?;
    let e2 = t.iter().map(|&t| trace.at(t)).collect::<Result<_, _>>()?;
    Ok([t.iter().map(|t| 1e3 * t).collect(), e2])
}

fn fig4(context: &Context) -> Result<Plate, CheckError> {
    let run = example(context)?;
    let (cubic, linear) = (column(&run.observer("cubic")?.error, 1), column(&run.observer("linear")?.error, 1));
    let panel = Panel::new("time t (s)", "error e₂")
        .mark(Mark::horizontal_band(-BAND, BAND))
        .series(Series::line("cubic", &run.t, &cubic))
        .series(Series::line("linear", &run.t, &linear));
    let mut first = Panel::new("time t (ms)", "error e₂").title(FIRST).mark(Mark::horizontal_band(-BAND, BAND));
    for name in ["cubic", "linear"] {
        let [t, e2] = beginning(&run, name)?;
        first = first.series(Series::line(name, &t, &e2));
    }
    Ok(Plate {
        figure: Figure::new("Fig. 4: the error of the second state")
            .caption("Example 1 from e(0) = (-3, -3). The grey band, ±0.05, is that of the settling time.")
            .columns(2)
            .panel(panel)
            .panel(first),
        data: Table::new().column("t", run.t.clone()).column("e2_cubic", cubic).column("e2_linear", linear),
    })
}

fn fig5(context: &Context) -> Result<Plate, CheckError> {
    let runs = sweep(context)?;
    let mut panel = Panel::new("time t (s)", "error e₂");
    let mut first = Panel::new("time t (ms)", "error e₂").title(FIRST);
    let mut data = Table::new();
    for (k, (gamma, run)) in runs.iter().enumerate() {
        let e2 = column(&run.observer("cubic")?.error, 1);
        if k == 0 {
            data = data.column("t", run.t.clone());
        }
        let name = if *gamma == 0.0 { "γ = 0 (linear)".to_owned() } else { format!("γ = {gamma}") };
        let [t, start] = beginning(run, "cubic")?;
        first = first.series(Series::line(name.clone(), &t, &start));
        panel = panel.series(Series::line(name, &run.t, &e2));
        data = data.column(format!("e2_gamma_{gamma}"), e2);
    }
    Ok(Plate {
        figure: Figure::new("Fig. 5: the error of the second state for several γ")
            .caption("Example 1 from e(0) = (-3, -3), θ = 10. The paper does not print its list of γ.")
            .columns(2)
            .panel(panel)
            .panel(first),
        data,
    })
}

/// e2 over time from every direction of e(0), the linear observer beside the cubic one.
fn fan(_: &Context) -> Result<Plate, CheckError> {
    const DIRECTIONS: u32 = 24;
    let radius = f64::hypot(E0[0], E0[1]);
    let mut panels = ["linear", "cubic"].map(|name| {
        Panel::new("time t (s)", "error e₂")
            .title(name)
            .x_range(0.0, 4.0)
            .y_range(-6.5, 6.5)
            .mark(Mark::horizontal_band(-BAND, BAND))
    });
    let mut data = Table::new();
    for k in 0..DIRECTIONS {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(DIRECTIONS);
        let run = race([radius * angle.cos(), radius * angle.sin()], Signal::zero(), 8.0)?;
        if k == 0 {
            data = data.column("t", run.t.clone());
        }
        let settles_first = last_settling(&run, "cubic")? < last_settling(&run, "linear")?;
        for (panel, name) in panels.iter_mut().zip(["linear", "cubic"]) {
            let e2 = column(&run.observer(name)?.error, 1);
            let (legend, hue) = if settles_first {
                ("cubic settles first", Hue::Palette(0))
            } else {
                ("linear settles first", Hue::Palette(1))
            };
            *panel = panel
                .clone()
                .series(Series::line(legend, &run.t, &e2).hue(hue).width(0.7).dash(crate::figure::Dash::Solid));
            data = data.column(format!("e2_{name}_{}deg", k * 360 / DIRECTIONS), e2);
        }
    }
    let [linear, cubic] = panels;
    Ok(Plate {
        figure: Figure::new("Beyond the paper: e₂ from every direction of e(0)")
            .caption(
                "Example 1, |e(0)| = 3√2, 24 directions, coloured by which observer settles first (last time |e₂| = 0.05). The cubic \
                 observer is not faster from everywhere.",
            )
            .panel(linear)
            .panel(cubic)
            .columns(2),
        data,
    })
}
