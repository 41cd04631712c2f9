//! Example 3: the observer in the feedback loop `u = -K xhat`. Figure 9.

use std::sync::Arc;

use luenberger_design::{DesignError, InfeasibilityReason, robust};
use luenberger_linalg::{kalman_gain, lqr};
use luenberger_live::{self as live, Experiment, ObserverKind};
use luenberger_observers::{CubicObserver, LinearObserver, Observer};
use luenberger_plants::{StateSpace, third_order};
use luenberger_proof::coq::cubic_paper::{WrongSign, wrong_sign};
use luenberger_sim::{Integrand, Scenario, Signal, SimError, Trajectory};
use nalgebra::{DMatrix, DVector, dmatrix};

use crate::claim::{CheckError, Claim, Class, Outcome, Quote};
use crate::context::Context;
use crate::evidence::{Counterexample, Evidence, Hypothesis, Tolerance};
use crate::figure::{Figure, Panel, Series};
use crate::hypotheses::{self, as_printed};
use crate::paper::{Drawing, KernelRefutation, LiveExample, Plate};
use crate::table::Table;
use crate::value::{Printed, Value, short};

const START: &str = "x(0) = (1, 1, 1), x̂(0) = 0, T = 30 s, none of which is printed";
const SIGN: &str = "N = -10 L: the printed sign makes the loop blow up";
const PRINTED: &str = "K and L as printed, to three decimals";
const END: f64 = 30.0;
const THETA: f64 = 10.0;

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "cubic.ex3.feedback-gain",
            class: Class::Reading,
            place: "Example 3",
            statement: "K is the LQR gain for Q = I, R = I",
            printed: Printed::Decimals("-.597 2.004 2.511; -.197 .757 7.510"),
            tolerance: Tolerance::AsPrinted,
            assumptions: &["the paper does not say how K was found"],
            quote: None,
            proof: None,
            check: |_| {
                let plant = plant();
                Ok(Evidence::value(&lqr(&plant.a, &plant.b, &DMatrix::identity(3, 3), &DMatrix::identity(2, 2))?.k)
                    .into())
            },
        },
        Claim {
            id: "cubic.ex3.observer-gain",
            class: Class::Reading,
            place: "Example 3",
            statement: "L is a Kalman gain",
            printed: Printed::Decimals(".267; -1.429; 3.904"),
            tolerance: Tolerance::AsPrinted,
            assumptions: &["process noise W = BB', measurement noise R = 100; the paper does not say how L was found"],
            quote: None,
            proof: None,
            check: |_| {
                let plant = plant();
                let w = &plant.b * plant.b.transpose();
                Ok(Evidence::value(&kalman_gain(&plant.a, &plant.c, &w, &dmatrix![100.0])?.l).into())
            },
        },
        Claim {
            id: "cubic.ex3.sign-of-n",
            class: Class::Misprint,
            place: "Example 3",
            statement: "N = +10 L fulfils (11) and, for some P > 0, (12) and (13'), and the loop of Fig. 9 runs to T = 30 s",
            printed: Printed::Holds(true),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[PRINTED, START],
            quote: Some(Quote {
                text: "L = L_c = .1N_c = [.267 -1.429 3.904]ᵀ, N_c = 10L, θ = 10",
                reading: "the sign as printed; \"This example examines Theorem 6\", which asks for (11)-(13)",
            }),
            proof: None,
            check: sign_of_n,
        },
        Claim {
            id: "cubic.fig9",
            class: Class::Example,
            place: "Fig. 9",
            statement: "the cost with the cubic observer is the smaller one at T (costs, cubic and linear)",
            printed: Printed::Holds(true),
            tolerance: Tolerance::AsPrinted,
            assumptions: &[PRINTED, SIGN, START],
            quote: None,
            proof: None,
            check: |context| {
                let loops = loops(context)?;
                let (c, l) = (final_cost(&loops.cubic)?, final_cost(&loops.linear)?);
                Ok(Evidence::holds_by(c < l, [c, l]).into())
            },
        },
    ]
}

fn plant() -> StateSpace {
    third_order::example3().to_dynamic()
}

/// K as printed.
fn feedback_gain() -> DMatrix<f64> {
    dmatrix![-0.597, 2.004, 2.511; -0.197, 0.757, 7.510]
}

/// L as printed.
fn observer_gain() -> DMatrix<f64> {
    dmatrix![0.267; -1.429; 3.904]
}

/// The cubic observer with `N = factor L`.
fn observer(factor: f64) -> Result<CubicObserver<f64, nalgebra::Dyn, nalgebra::Dyn, nalgebra::Dyn>, CheckError> {
    let l = observer_gain();
    let n = &l * factor;
    Ok(CubicObserver::of(plant(), l, n, dmatrix![THETA])?)
}

/// The loop around one observer, with its cost.
fn close<'a>(observer: impl Observer<f64> + Send + Sync + 'a, k: DMatrix<f64>) -> Result<Trajectory, SimError> {
    Scenario::new(plant())
        .initial_state(&[1.0; 3])
        .observer("observer", observer, &[0.0; 3])
        .input(Signal::feedback("observer", k))
        .integral("cost", Integrand::quadratic_cost(DMatrix::identity(3, 3), DMatrix::identity(2, 2)))
        .until(END, 1201)
        .run()
}

/// The example in the page of the report.
pub(super) fn live() -> LiveExample {
    LiveExample {
        id: "live-example-3",
        title: "Example 3",
        about: "The loop around each observer, u = -K xhat, with K and L as printed and N = -10 L.",
        experiment: || {
            let linear = LinearObserver::of(plant(), observer_gain())?;
            let mut experiment = Experiment::new(live::StoredPlant::linear(&plant()), &[1.0; 3], END, 401)
                .observer(live::StoredObserver::new("linear", ObserverKind::Linear(Box::new(linear)), &[0.0; 3]))
                .observer(live::StoredObserver::new(
                    "cubic",
                    ObserverKind::Cubic(Box::new(observer(-10.0)?)),
                    &[0.0; 3],
                ));
            experiment.feedback = Some(live::Feedback::of_each_estimate(&feedback_gain()));
            Ok(experiment)
        },
    }
}

struct Loops {
    cubic: Trajectory,
    linear: Trajectory,
}

fn loops(context: &Context) -> Result<Arc<Loops>, CheckError> {
    context.once("cubic.ex3", || {
        Ok(Loops {
            cubic: close(observer(-10.0)?, feedback_gain())?,
            linear: close(LinearObserver::of(plant(), observer_gain())?, feedback_gain())?,
        })
    })
}

fn final_cost(run: &Trajectory) -> Result<f64, CheckError> {
    Ok(run.integral_trace("cost")?.last())
}

/// What is asked of the pieces of the loop, whatever N is.
fn hypotheses() -> Result<Vec<Hypothesis>, CheckError> {
    let plant = plant();
    Ok(vec![
        hypotheses::observable(&plant.a, &plant.c)?,
        hypotheses::positive("θ = θ' ≥ 0", &dmatrix![THETA])?,
        hypotheses::stable("A - LC", &(&plant.a - observer_gain() * &plant.c))?,
        hypotheses::stable("A - BK", &(&plant.a - &plant.b * feedback_gain()))?,
    ])
}

/// Three witnesses: no P, an equilibrium, a loop that ends.
fn sign_of_n(_: &Context) -> Result<Outcome, CheckError> {
    let (plant, l) = (plant(), observer_gain());
    let mut cases = vec![equilibrium()?, blow_up()?];
    let mut note = "";
    match robust::certify_gain(&plant, &l, &(&l * 10.0)) {
        Err(DesignError::Infeasible { reason: InfeasibilityReason::SignOfCn(cn), .. }) => {
            cases.insert(
                0,
                Counterexample {
                    case: "no P".to_owned(),
                    what: "P N = -C'S with S ≥ 0 gives N'PN = -S C N ≤ 0 as soon as C N > 0, but P > 0".to_owned(),
                    violation: cn,
                    witness: Some(Value::Number(cn)),
                    hypotheses: hypotheses()?,
                },
            );
            let opposite = robust::certify_gain(&plant, &l, &(&l * -10.0))
                .is_ok_and(|gain| gain.certificate.is_proved() && gain.certificate.converges_from_everywhere());
            if opposite {
                note = "With N = -10 L a P is found, and convergence from every error is proved for the stored gains: the sign is a misprint.";
            }
        }
        Err(other) => return Err(other.into()),
        Ok(_) => {}
    }
    Ok(Outcome::new(Evidence::Counterexamples(cases)).note(note))
}

/// The first two witnesses as theorems for Coq, about the numbers as printed.
pub(super) fn kernel() -> KernelRefutation {
    KernelRefutation {
        claim: "cubic.ex3.sign-of-n",
        file: |claim| {
            let (plant, l) = (plant(), observer_gain());
            // 10 L to the three decimals that L has, which the product rounds.
            let n = l.map(|entry| (entry * 1e4).round() / 1e3);
            let data = [&plant.a, &plant.c, &l, &n, &dmatrix![THETA]].map(as_printed);
            let [Some(a), Some(c), Some(l), Some(n), Some(theta)] = &data else { return Err("not finite".into()) };
            Ok(wrong_sign(claim, &WrongSign { a, c, l, n, theta })?)
        },
    }
}

/// A solution v != 0 of `F v + theta (Cv)^2 N C v = 0`: with `w = F^-1 N`, v = -theta y^3 w and `y = C v`, hence
/// `theta y^2 C w = -1`.
fn equilibrium() -> Result<Counterexample, CheckError> {
    let observer = observer(10.0)?;
    let f = &observer.a - &observer.l * &observer.c;
    let w = f.clone().lu().solve(&observer.n).ok_or("F is singular")?;
    let y = (-1.0 / (THETA * (&observer.c * &w)[(0, 0)])).sqrt();
    let v = DVector::from_column_slice((&w * (-THETA * y.powi(3))).as_slice());
    let rate = (&f * &v + &observer.n * (THETA * y.powi(3))).amax();
    // Two products of n terms, each rounded.
    let stands_still = rate <= 8.0 * f64::EPSILON * f.norm() * v.norm();
    Ok(Counterexample {
        case: "equilibrium".to_owned(),
        what: format!(
            "(11): at this v the entries of e' are at most {}, their rounding; the violation is |v|",
            short(rate)
        ),
        violation: if stands_still { v.norm() } else { -rate },
        witness: Some(Value::from(&v)),
        hypotheses: hypotheses()?,
    })
}

/// The time at which the loop with `N = +10 L` ends, and the largest entry then; infinite if it does not.
fn end_of_the_loop() -> Result<(f64, f64), CheckError> {
    match close(observer(10.0)?, feedback_gain()) {
        Err(SimError::BlowUp { time, norm }) => Ok((time, norm)),
        Err(other) => Err(other.into()),
        Ok(_) => Ok((f64::INFINITY, 0.0)),
    }
}

fn blow_up() -> Result<Counterexample, CheckError> {
    let (time, norm) = end_of_the_loop()?;
    let (c, n) = (plant().c, observer_gain() * 10.0);
    let y0: f64 = c.iter().sum();
    let alone = 1.0 / (2.0 * THETA * (c * n)[(0, 0)] * y0 * y0);
    Ok(Counterexample {
        case: "blow-up".to_owned(),
        what: format!(
            "the loop ends at this time (s), when an entry reaches {}; the cubic term alone would blow up at 1/(2 θ C N y(0)²) = {} s",
            short(norm),
            short(alone)
        ),
        violation: END - time,
        witness: Some(Value::Number(time)),
        hypotheses: hypotheses()?,
    })
}

/// The smallest eigenvalue of the solution of (9), Q = I, for the observable plant of Example 3: with L = 0 and with
/// the printed L.
pub(super) fn lyapunov_solutions() -> Result<[f64; 2], CheckError> {
    let plant = plant();
    let smallest = |l: DMatrix<f64>| -> Result<f64, CheckError> {
        let p = luenberger_linalg::lyapunov(&(&plant.a - l * &plant.c), &DMatrix::identity(3, 3))?.p;
        Ok(luenberger_linalg::lambda_min(&p)?)
    };
    Ok([smallest(DMatrix::zeros(3, 1))?, smallest(observer_gain())?])
}

pub(super) fn figures() -> Vec<Drawing> {
    vec![Drawing { id: "cubic-fig9", draw: fig9 }]
}

fn fig9(context: &Context) -> Result<Plate, CheckError> {
    let loops = loops(context)?;
    let (cubic, linear) = (loops.cubic.integral("cost")?.to_vec(), loops.linear.integral("cost")?.to_vec());
    let t = loops.cubic.t.clone();
    let panel = Panel::new("time t (s)", "cost ∫(x′x + u′u) dt")
        .series(Series::line("cubic", &t, &cubic))
        .series(Series::line("linear", &t, &linear));
    Ok(Plate {
        figure: Figure::new("Fig. 9: the regulation cost with either observer in the loop")
            .caption("Example 3 with N = -10 L (the printed sign blows up), from x(0) = (1, 1, 1), x̂(0) = 0.")
            .panel(panel),
        data: Table::new().column("t", t).column("cost_cubic", cubic).column("cost_linear", linear),
    })
}
