//! Other observers for Example 2: the printed gain of [16], Lipschitz and polytopic designs, the extended Kalman
//! filter. Figure 9.
//!
//! [17] cannot be identified from the paper, which gives no equation of it.

use std::sync::Arc;

use luenberger_design::lipschitz::{LipschitzDesign, LipschitzPlant, Sector, greatest_factor};
use luenberger_design::{DesignError, InfeasibilityReason, LpvDesign, LpvError, Region};
use luenberger_linalg::eigenvalues;
use luenberger_observers::{Beta, ExtendedKalmanFilter, MeanValueObserver, NoiseModel, NonlinearLuenbergerObserver};
use luenberger_plants::flexible_joint::FlexibleJoint;
use luenberger_plants::{Differentiable, flexible_joint};
use luenberger_proof::certificate::ProvedSentence;
use luenberger_sim::{Compared, Comparison, Noise, Scenario, Settings, Signal, Trajectory};
use nalgebra::{Const, DMatrix, Matrix4, SMatrix, Vector4, dmatrix};

use super::example2::{PLANT, XHAT0};
use super::figures::entries;
use super::output_injection::{RATE, design, vertices};
use super::runs::{HORIZONS, System, fixed, norms};
use crate::claim::{CheckError, Claim, Class, Outcome};
use crate::context::Context;
use crate::evidence::Evidence;
use crate::figure::{Figure, Hue, Panel, Series};
use crate::paper::{Drawing, Plate};
use crate::table::Table;
use crate::value::{Value, short};

/// The Lipschitz constant of the printed nonlinearity, (0, 0, 0, -3.33 sin x3).
const CONSTANT: f64 = 3.33;
/// Sampling period of the filter, and time for which noise and input are held, for all.
const PERIOD: f64 = 0.01;
const NOISE: f64 = 0.01;
const SEED: u64 = 16;

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim::holds(
            Class::Misprint,
            "mvt.ex2.gain-of-16",
            "Example 2, [16]",
            "the printed L is an observer gain: the error converges from everywhere, one P for both vertices of the mean Jacobian",
            &[PLANT, "l42 is printed \"8.49.67\""],
            gain_of_16,
        )
        .quoting("15.5282 8.49.67 62.7550 (the last row of L)", "a number with two points: one of them is a misprint"),
        Claim::holds(
            Class::Theorem,
            "mvt.ex2.unstructured-lipschitz",
            "Section 1",
            "most designs for Lipschitz plants fail when the constant is greater than an appropriate value: here no gain exists for 3.33",
            &[PLANT, "Rajamani's inequality, |φ(x) - φ(z)| ≤ 3.33 |x - z|"],
            lipschitz,
        ),
        Claim::holds(
            Class::Theorem,
            "mvt.ex2.polytopic",
            "Section 1, [10-12]",
            "the mean value theorem provides a solution even for a large Lipschitz constant: one gain and one P for both vertices of the mean Jacobian",
            &["Example 2 and both variants", "rates 2 and 4"],
            polytopic,
        ),
        Claim::holds(
            Class::Example,
            "mvt.fig9",
            "Fig. 9",
            "the proposed observer performs satisfactorily beside [16]: |x - x̂| settles within 5 % (settling times given e0, given e01, given nothing, and of [16]; -1 for never)",
            &[XHAT0, PLANT, "by 10 s, hence by 100 s too, the horizons of every claim of the examples; l42 = 8.4967", "[17] cannot be identified"],
            |context| {
                let table = &joint(context, System::Corrected)?.clean;
                let of = |name: &str| -> Result<(f64, f64), CheckError> {
                    let merits = table.metrics(name)?;
                    Ok((merits.settling_last.unwrap_or(-1.0), merits.rmse))
                };
                let [given, partly, blind, sixteen] = [of(GIVEN)?, of(PARTLY)?, of(BLIND)?, of(SIXTEEN)?];
                let satisfies = [given.0, partly.0].iter().all(|t| (0.0..=HORIZONS[0].1).contains(t));
                Ok(Outcome::new(Evidence::holds_by(satisfies, [given.0, partly.0, blind.0, sixteen.0])).note(format!(
                    "Root mean square of |x - x̂| over the run: {} given e0, {} given e01, {} given nothing, and {} of [16], which is given nothing. The paper says \"satisfactory\", and not that it is \
                     better than [16].",
                    short(given.1),
                    short(partly.1),
                    short(blind.1),
                    short(sixteen.1)
                )))
            },
        )
        .quoting(
            "The following figure show satisfactory of proposed observer performance in dealing with a nonlinear system with linear term.",
            "x̂ settles in the two cases that the paper runs, e0 and e01",
        ),
        Claim::holds(
            Class::Example,
            "mvt.ex2.from-the-same-information",
            "Section 4.0.6; Section 5",
            "the proposed observer performs well beside others that know what it knows: given nothing, it settles within 5 % (settling time without noise and with it; -1 for never)",
            &[
                XHAT0,
                PLANT,
                "the same y and the same x̂(0) for all, e(0) = 0; with and without noise",
                "η = 1; T = 20 s, 10 s on the variant with the classical outputs, 2 s on the one with a44 as printed",
            ],
            same_information,
        )
        .quoting(
            "Numerical example is provided to show high performances of the proposed approach",
            "high performance is: it settles when its peers do, and is given no more than they are",
        ),
    ]
}

fn same_information(context: &Context) -> Result<Outcome, CheckError> {
    let mut decided = [-1.0; 2];
    let mut head = vec!["observer".to_owned(), "prior information".to_owned()];
    // A row for each observer: its name, what it is given, and its times.
    let mut rows: Vec<Vec<String>> = Vec::new();
    for system in System::JOINTS {
        let runs = joint(context, system)?;
        for (k, (table, noise)) in [(&runs.clean, "without noise"), (&runs.noisy, "with noise")].into_iter().enumerate()
        {
            head.push(format!("{}, {noise}", system.name()));
            for row in &table.rows {
                let settled = row.outcome.as_ref().ok().and_then(|merits| merits.settling_last);
                if row.name == BLIND && system == System::Corrected {
                    decided[k] = settled.unwrap_or(-1.0);
                }
                let known = rows.iter().position(|cells| cells[0] == row.name).unwrap_or_else(|| {
                    rows.push(vec![row.name.clone(), row.prior_information.join("; ")]);
                    rows.len() - 1
                });
                // An observer that took no part before has empty cells there.
                rows[known].resize(head.len() - 1, String::new());
                rows[known].push(settled.map_or("never".to_owned(), |t| format!("{} s", short(t))));
            }
        }
    }
    for cells in &mut rows {
        cells.resize(head.len(), String::new());
    }
    let outcome = Outcome::new(Evidence::holds_by(decided.iter().all(|t| (0.0..=HORIZONS[0].1).contains(t)), decided))
        .table(head, rows);
    Ok(outcome.note(format!(
        "Time from which |x - x̂| stays below 5 %. On both variants it never settles. The filter's estimate is held for {PERIOD} s between its samples, which costs it the \
         band where x is fast. Noise: uniform, ± {NOISE}, held {PERIOD} s, seed {SEED}.",
    )))
}

/// The printed gain of [16], with a reading of its entry (4, 2).
fn sixteen(l42: f64) -> DMatrix<f64> {
    dmatrix![
        0.5409, -0.6315, 0.2392;
        -10.3506, 21.2355, 22.8782;
        1.8370, 3.4444, 10.6638;
        15.5282, l42, 62.7550
    ]
}

fn gain_of_16(_: &Context) -> Result<Outcome, CheckError> {
    let c = DMatrix::<f64>::identity(3, 4);
    // The mean of the cosine is 0 half-way between the two vertices.
    let ends = vertices(System::Corrected);
    let middle = (&ends[0] + &ends[1]) * 0.5;
    let mut readings = Vec::new();
    let mut words = Vec::new();
    for (assumption, l42) in [("l42 = 8.4967", 8.4967), ("l42 = 84.967", 84.967), ("l42 = 849.67", 849.67)] {
        let poles: Vec<String> = eigenvalues(&(&middle - sixteen(l42) * &c))?
            .iter()
            .map(|pole| format!("{:.2}{:+.2}i", pole.re, pole.im).replace("+0.00i", "").replace("-0.00i", ""))
            .collect();
        let proved = match LpvDesign::certify(flexible_joint::corrected(), &Region::everywhere(4), &sixteen(l42)) {
            Ok(design) => {
                words.push(format!(
                    "{l42}: rate {} {}",
                    short(design.rate),
                    if design.certificate.is_proved() { "proved" } else { "not proved" }
                ));
                design.certificate.is_proved()
            }
            Err(error @ (LpvError::UnstableVertex { .. } | LpvError::Conflict(_))) => {
                words.push(format!("{l42}: {error}"));
                false
            }
            Err(other) => return Err(other.into()),
        };
        words.push(format!("(poles {} where the cosine is 0).", poles.join(", ")));
        readings.push((assumption, Value::Truth(proved)));
    }
    Ok(Outcome::new(Evidence::Readings(readings)).note(format!(
        "{} Every other entry of L has four decimals, and so has 8.4967 alone, which is also the best damped and the fastest: it is the reading used here.",
        words.join(" ")
    )))
}

/// A joint as a linear part and a sine.
fn joint_with(system: System, sectors: Vec<Sector>) -> Result<LipschitzPlant, CheckError> {
    let a = match system {
        System::Printed => flexible_joint::printed().linear_part(),
        _ => flexible_joint::corrected().linear_part(),
    };
    let c = DMatrix::identity(system.outputs(), 4);
    Ok(LipschitzPlant::new(DMatrix::from_column_slice(4, 4, a.as_slice()), c, sectors)?)
}

/// The sine acts on x4' and depends on x3.
fn structured(system: System) -> Result<LipschitzDesign, CheckError> {
    let sine = Sector::structured(dmatrix![0.0; 0.0; 0.0; 1.0], dmatrix![0.0, 0.0, 1.0, 0.0], CONSTANT);
    Ok(LipschitzDesign::new(&joint_with(system, vec![sine])?, RATE)?)
}

fn lipschitz(_: &Context) -> Result<Outcome, CheckError> {
    let crude = joint_with(System::Corrected, vec![Sector::unstructured(4, CONSTANT)])?;
    let structured = structured(System::Corrected)?;
    match LipschitzDesign::new(&crude, 0.0) {
        Err(DesignError::Infeasible { reason: InfeasibilityReason::Dual(multipliers), .. }) => {
            let unit = joint_with(System::Corrected, vec![Sector::unstructured(4, 1.0)])?;
            let greatest = greatest_factor(&unit, None, 0.0, CONSTANT, 1e-3)?;
            Ok(Outcome::new(Evidence::holds(true)).note(format!(
                "Infeasible, with multipliers verified exactly: {multipliers}. The greatest constant for which a gain is proved is {}; {} is refuted. The limit is that of the inequality, not of the plant: given that the sine acts on x4' and depends on x3 alone, the same \
                 constant gives a gain with rate {}, {}.",
                short(greatest.factor),
                greatest.refuted_at.map_or("none greater".to_owned(), short),
                short(structured.rate),
                if structured.certificate.is_proved() { "proved" } else { "not proved" }
            )))
        }
        Err(other) => Err(other.into()),
        Ok(design) => Ok(Evidence::holds(!design.certificate.is_proved()).into()),
    }
}

fn polytopic(_: &Context) -> Result<Outcome, CheckError> {
    let mut words = Vec::new();
    let mut proved = true;
    let mut examine = |name: &str, found: (bool, f64, f64, Option<ProvedSentence>)| {
        proved &= found.0;
        let said = found.3.map_or_else(String::new, |sentence| sentence.to_string());
        words.push(format!("{name}: rate {}, |L| = {}. {}", short(found.1), short(found.2), said));
    };
    let everywhere = Region::everywhere(4);
    for rate in [RATE, 2.0 * RATE] {
        let corrected = LpvDesign::new(flexible_joint::corrected(), &everywhere, rate)?;
        examine(
            System::Corrected.name(),
            (corrected.certificate.is_proved(), rate, corrected.l().norm(), corrected.sentence()),
        );
        let classical = LpvDesign::new(flexible_joint::classical(), &everywhere, rate)?;
        examine(
            System::Classical.name(),
            (classical.certificate.is_proved(), rate, classical.l().norm(), classical.sentence()),
        );
        let printed = LpvDesign::new(flexible_joint::printed(), &everywhere, rate)?;
        examine(
            System::Printed.name(),
            (printed.certificate.is_proved(), rate, printed.l().norm(), printed.sentence()),
        );
    }
    Ok(Outcome::new(Evidence::holds(proved)).instances(words.len()).note(words.join(" ")))
}

const GIVEN: &str = "as printed, e0";
const PARTLY: &str = "as printed, e01";
const BLIND: &str = "as printed, e(0) = 0";
const INJECTED: &str = "output injection, e(0) = 0";
const SIXTEEN: &str = "[16]";
const LPV: &str = "polytopic (LPV)";
const STRUCTURED: &str = "Lipschitz, structured";
const KALMAN: &str = "extended Kalman filter";

/// Long enough for every observer that converges.
fn horizon(system: System) -> f64 {
    if system == System::Corrected { 20.0 } else { system.end() }
}

/// The observers that run in parallel on one plant.
struct Joint {
    clean: Compared,
    noisy: Compared,
    t: Vec<f64>,
}

fn joint(context: &Context, system: System) -> Result<Arc<Joint>, CheckError> {
    match system {
        System::Corrected => context.once("mvt.peers", || compare(flexible_joint::corrected(), system)),
        System::Printed => context.once("mvt.peers.printed", || compare(flexible_joint::printed(), system)),
        _ => context.once("mvt.peers.classical", || compare(flexible_joint::classical(), system)),
    }
}

fn compare<const P: usize>(plant: FlexibleJoint<P>, system: System) -> Result<Joint, CheckError>
where
    FlexibleJoint<P>: Differentiable<f64, Const<4>, Const<1>, Const<P>>,
{
    let start = system.start();
    let luenberger =
        |l: &DMatrix<f64>| -> Result<_, CheckError> { Ok(NonlinearLuenbergerObserver::new(plant, fixed::<4, P>(l)?)?) };
    let polytopic = design(system)?;
    let printed = |e0: Vector4<f64>| MeanValueObserver::new(plant, 1.0, Beta, e0);
    let given = printed(Vector4::from_column_slice(start.e0))?;
    let partly = printed(Vector4::from_column_slice(start.e01))?;
    let blind = printed(Vector4::zeros())?;
    let injected = polytopic.observer(plant, 1.0, Beta, Vector4::zeros())?;
    let lpv = LpvDesign::new(plant, &Region::everywhere(4), RATE)?.observer.clone();
    let lipschitz = structured(system)?.observer(plant)?;
    // [16] reads three outputs.
    let sixteen = if P == 3 { Some(luenberger(&sixteen(8.4967))?) } else { None };
    // Doubt of the size of the error at the start; the noise as it is, or a thousandth of it where there is none.
    let filter = |noise: f64| {
        let noises = NoiseModel {
            w: Matrix4::identity() * 1e-2,
            v: SMatrix::<f64, P, P>::identity() * (noise * noise / 3.0),
            p0: Matrix4::identity() * 4.0,
        };
        ExtendedKalmanFilter::error_controlled(plant, noises, PERIOD)
    };
    let (filter, noisy_filter) = (filter(NOISE / 30.0)?, filter(NOISE)?);
    // Input and noise jump every 10 ms, and no number of these runs is printed.
    let settings = Settings { rtol: 1e-9, atol: 1e-12, ..Settings::default() };
    // At its samples, between which it is held, the filter's estimate is meant for just that time.
    let count = (horizon(system) / PERIOD).round() as u32;
    let samples: Vec<f64> = (0..=count).map(|k| f64::from(k) * PERIOD).collect();
    let side_by_side =
        |noise: Option<Noise>, filter: &ExtendedKalmanFilter<FlexibleJoint<P>, f64, Const<4>, Const<1>, Const<P>>| {
            let mut scenario = Scenario::new(plant)
                .initial_state(start.x)
                .times(&samples)
                .input(Signal::scalar(f64::sin))
                .hold_input(PERIOD)
                .settings(settings);
            if let Some(noise) = noise {
                scenario = scenario.noise(noise);
            }
            let mut comparison = Comparison::new(scenario, start.xhat)
                .observer(GIVEN, &given)
                .observer(PARTLY, &partly)
                .prior_information(PARTLY, "all of x(0) - x̂(0) but 0.5 in its last entry")
                .observer(BLIND, &blind)
                .observer(INJECTED, &injected)
                .observer(LPV, &lpv)
                .observer(STRUCTURED, &lipschitz)
                .sampled_observer(KALMAN, filter)
                .prior_information(KALMAN, "how large the noise is, and how wrong x̂(0) may be");
            if let Some(sixteen) = &sixteen {
                comparison = comparison.observer(SIXTEEN, sixteen);
            }
            comparison.run()
        };
    Ok(Joint {
        clean: side_by_side(None, &filter)?,
        noisy: side_by_side(Some(Noise::uniform(&[NOISE; P], PERIOD, SEED)), &noisy_filter)?,
        t: samples,
    })
}

impl Joint {
    /// The run of an observer without noise, or with it.
    fn run<'a>(table: &'a Compared, name: &str) -> Result<&'a Trajectory, CheckError> {
        Ok(table.row(name)?.trajectory.as_ref().ok_or_else(|| format!("{name} has no run"))?)
    }
}

pub(super) fn figures() -> Vec<Drawing> {
    vec![
        Drawing { id: "mvt-peers", draw: |context| figure(context, System::Corrected) },
        Drawing { id: "mvt-peers-classical", draw: |context| figure(context, System::Classical) },
        Drawing { id: "mvt-peers-printed", draw: |context| figure(context, System::Printed) },
    ]
}

fn figure(context: &Context, system: System) -> Result<Plate, CheckError> {
    let runs = joint(context, system)?;
    let sixteen = if system.outputs() == 3 { " [16] with l42 = 8.4967." } else { " [16] needs a third output." };
    let blind = if system == System::Corrected {
        "Given nothing, e(0) = 0, the observer as printed converges too, later than its peers."
    } else {
        "Given nothing, e(0) = 0, the observer as printed does not converge."
    };
    let mut figure = Figure::new(format!("Beyond the paper: {} beside its peers", system.name())).columns(2).caption(format!(
        "All start from the same wrong x̂(0) and see the same y; the noise is uniform, ± {NOISE}, a new value every {PERIOD} s. \"As printed, e0\" was given x(0), \"e01\" most of it, the filter how \
         large the noise is. {blind}{sixteen}"
    ));
    let mut data = Table::new().column("t", runs.t.clone());
    for (table, title, suffix, floor) in
        [(&runs.clean, "without noise", "", 1e-14), (&runs.noisy, "with noise", "_noise", 1e-4)]
    {
        let mut panel = Panel::new("time t (s)", "|x - x̂|").title(title).log_y().y_range(floor, 1e3);
        for (k, name) in [GIVEN, PARTLY, BLIND, INJECTED, LPV, STRUCTURED, KALMAN, SIXTEEN].into_iter().enumerate() {
            let Ok(run) = Joint::run(table, name) else { continue };
            // Zeros have no place on a logarithmic axis; 1e-16 is below what can be distinguished.
            let error: Vec<f64> = norms(&run.observer(name)?.error).iter().map(|e| e.max(1e-16)).collect();
            let hue = if k < 7 { Hue::Palette(k) } else { Hue::Grey };
            panel = panel.series(Series::line(name, &runs.t, &error).hue(hue).width(0.9));
            data = data.column(format!("{}{suffix}", KEYS[k]), error);
        }
        figure = figure.panel(panel);
    }
    Ok(Plate { figure, data })
}

/// Names of the observers in the columns of the table.
const KEYS: [&str; 8] =
    ["printed_e0", "printed_e01", "printed_0", "repaired", "polytopic", "lipschitz", "kalman", "sixteen"];

pub(super) fn fig9(context: &Context) -> Result<Plate, CheckError> {
    let runs = joint(context, System::Corrected)?;
    let x4 = entries(&Joint::run(&runs.clean, GIVEN)?.x, 3);
    let mut left = Panel::new("time t (s)", "state x₄ and its estimates")
        .series(Series::line("x₄", &runs.t, &x4).hue(Hue::Palette(6)));
    let mut right = Panel::new("time t (s)", "|x₄ - x̂₄|").log_y();
    let mut data = Table::new().column("t", runs.t.clone()).column("x4", x4.clone());
    for (k, name, key) in [(0, GIVEN, "printed_e0"), (1, PARTLY, "printed_e01"), (2, SIXTEEN, "sixteen")] {
        let estimate = entries(&Joint::run(&runs.clean, name)?.observer(name)?.estimate, 3);
        let error: Vec<f64> = estimate.iter().zip(&x4).map(|(xhat, x)| (x - xhat).abs().max(1e-16)).collect();
        left = left.series(Series::line(name, &runs.t, &estimate).hue(Hue::Palette(k)));
        right = right.series(Series::line(name, &runs.t, &error).hue(Hue::Palette(k)));
        data = data.column(format!("x4_hat_{key}"), estimate);
    }
    Ok(Plate {
        figure: Figure::new("Fig. 9: the state x₄ of Example 2")
            .caption(
                "a44 = 0, C = [I3 0]. The observer follows if it is given x(0), and converges if 0.5 of x₄ are missing; [16], with l42 = 8.4967, is given nothing. [17] cannot be identified from \
                 the paper.",
            )
            .panel(left)
            .panel(right)
            .columns(2),
        data,
    })
}
