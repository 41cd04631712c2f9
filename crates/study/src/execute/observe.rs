//! Observability analysis.

use std::fmt::Write;

use luenberger_design::nonlinear_observability::{Instant, LieSettings, lie_observability};
use luenberger_design::{OperatingPoint, UnseenModes};
use luenberger_linalg::{Mode, observability as of_pair};
use luenberger_plants::Differentiable;
use luenberger_proof::wording::significant;
use luenberger_sim::{GramianSettings, Settings, SimError, empirical_gramian};
use nalgebra::{DMatrix, DVector};

use super::options::RunOptions;
use crate::error::StudyError;
use crate::results::{
    LieRank, ModeReport, NonlinearObservability, ObservabilityAt, ObservabilityReport, OperatingPointReport,
};
use crate::signal::Input;
use crate::study::Study;
use crate::trajectory::{self, Member, Variation};

/// Number of points along the trajectory at which a nonlinear plant is linearized.
const POINTS: usize = 5;

/// The operating point in numbers.
pub(super) fn operating_point(point: &OperatingPoint) -> Result<OperatingPointReport, StudyError> {
    Ok(OperatingPointReport {
        x: point.x.as_slice().to_vec(),
        u: point.u.as_slice().to_vec(),
        y: point.y.as_slice().to_vec(),
        residual: point.residual,
        steps: point.steps,
        matrices: super::matrices(&point.linear),
        poles: point.poles.iter().map(|pole| [pole.re, pole.im]).collect(),
        observable: of_pair(&point.linear.a, &point.linear.c)?.is_observable(),
    })
}

/// A linear plant is analysed once. A nonlinear one is linearized along the trajectory of the study; without one, at
/// the first row of a log and the origin. An output without a derivative at such a point is left out there, with a
/// warning.
pub(super) fn observability(
    study: &Study,
    members: &[Member<'_>],
    options: &RunOptions<'_>,
    warnings: &mut Vec<String>,
) -> Result<ObservabilityReport, StudyError> {
    let order = study.plant.states.len();
    let points = match study.plant.model.linear() {
        Some(linear) => vec![observability_at(study, &linear.a, &linear.c, None)?],
        None => along(study, members, options)?
            .into_iter()
            .map(|(t, x, u)| {
                let a = study.plant.model.state_jacobian(t, &x, &u);
                let mut c = study.plant.model.output_jacobian(t, &x, &u);
                for (name, mut row) in study.plant.outputs.iter().zip(c.row_iter_mut()) {
                    if row.iter().any(|entry| !entry.is_finite()) {
                        row.fill(0.0);
                        let (t, x) =
                            (significant(t, 5), x.iter().map(|x| significant(*x, 3)).collect::<Vec<_>>().join(", "));
                        warnings.push(format!(
                            "Observability at t = {t}, x = [{x}]: {name} has no derivative there, and is left out."
                        ));
                    }
                }
                observability_at(study, &a, &c, Some((t, x.as_slice())))
            })
            .collect::<Result<_, _>>()?,
    };
    let rank = points.iter().map(|point| point.rank).min().unwrap_or(0);
    let nonlinear = match study.plant.model.linear() {
        // Lie derivatives are of plants in continuous time.
        _ if study.plant.dt.is_some() => None,
        Some(_) => None,
        None => nonlinear(study, members, options)?,
    };
    Ok(ObservabilityReport { points, order, rank, nonlinear })
}

/// Rank of the Lie derivatives of the output along the trajectory, and the empirical Gramian; none if a derivative does
/// not exist.
fn nonlinear(
    study: &Study,
    members: &[Member<'_>],
    options: &RunOptions<'_>,
) -> Result<Option<NonlinearObservability>, StudyError> {
    let model = &study.plant.model;
    let instants: Vec<Instant> = along(study, members, options)?
        .iter()
        .map(|(t, x, u)| Instant::new(*t, x.as_slice()).constant_input(u.as_slice()))
        .collect();
    let Ok(lie) = lie_observability(model, &instants, &LieSettings::default()) else { return Ok(None) };
    let ranks = lie.points.iter().map(|point| LieRank {
        t: point.t,
        x: point.x.clone(),
        rank: point.rank,
        singular_values: point.singular_values.clone(),
    });
    let names: Vec<&str> = study.plant.states.iter().map(String::as_str).collect();
    let mut report = NonlinearObservability {
        lie: ranks.collect(),
        gramian: Vec::new(),
        weakest: Vec::new(),
        words: lie.in_words(&names),
    };
    // With feedback the input depends on an observer; the Gramian is computed with the input as a given function of
    // time.
    let open = trajectory::fed(study).is_none() && !matches!(study.input, Input::Law { .. });
    if let Some(simulation) = study.simulation.as_ref().filter(|_| open) {
        let input = |t: f64, u: &mut [f64]| match study.input.program() {
            Some(program) => program.at(t, u),
            None => u.fill(0.0),
        };
        let integration = Settings { end: options.until, ..simulation.settings };
        let settings = GramianSettings { integration, ..GramianSettings::default() };
        let span = (0.0, simulation.duration);
        // A perturbed initial state may blow up where x0 does not: then only the ranks are reported.
        if let Ok(gramian) = empirical_gramian(model, &simulation.x0, input, span, &settings) {
            report.weakest = gramian.weakest().map(|v| v.as_slice().to_vec()).unwrap_or_default();
            let (rank, order) = (gramian.rank, gramian.scales.len());
            // One of several directions would be one by chance. The eigenvalues are sorted, the largest first.
            let is_repeated = matches!(gramian.eigenvalues[..], [.., next, least] if next - least <= 1e-7 * next);
            let least = if is_repeated {
                "several least observable directions alike".to_owned()
            } else {
                format!("least observable direction {}", study.plant.direction_in_words(&report.weakest))
            };
            let _ = write!(report.words, "\nempirical Gramian: rank {rank} of {order}, {least}");
            // Two ranks that differ are no contradiction, but each has to be read rightly.
            let least = lie.points.iter().map(|point| point.rank).min().unwrap_or(rank);
            if rank < least {
                let _ = write!(
                    report.words,
                    "\n  The Lie derivatives have rank {least}: every direction is observable in principle. Along this run, in the units of the initial state, {} less in the output than the Gramian's rank tolerance: expect slow or noisy estimates there, or excite the plant more.",
                    match order - rank {
                        1 => "1 of them leaves".to_owned(),
                        several => format!("{several} of them leave"),
                    }
                );
            }
            report.gramian = gramian.eigenvalues;
        }
    }
    Ok(Some(report))
}

/// A time, the state and the input there.
type Moment = (f64, DVector<f64>, DVector<f64>);

/// The points at which a nonlinear plant is analysed.
fn along(study: &Study, members: &[Member<'_>], options: &RunOptions<'_>) -> Result<Vec<Moment>, StudyError> {
    let size = study.plant.model.size();
    let Some(simulation) = &study.simulation else {
        let u = DVector::zeros(size.inputs);
        let estimates = study.observers.iter().map(|requested| DVector::from_column_slice(&requested.initial));
        // Without a simulation, the initial estimates are the only states given by the study.
        let x = estimates.take(1).next().unwrap_or_else(|| DVector::zeros(size.states));
        return Ok(vec![(0.0, x, u)]);
    };
    let run = match trajectory::run(study, simulation, members, None, Variation::NONE, options.until) {
        Err(SimError::TimeLimit { .. }) => return Err(StudyError::Interrupted),
        run => run?,
    };
    let last = run.t.len() - 1;
    let row = |m: &DMatrix<f64>, k: usize| DVector::from_iterator(m.ncols(), m.row(k).iter().copied());
    let points = (0..POINTS).map(|i| {
        let k = i * last / (POINTS - 1);
        (run.t[k], row(&run.x, k), row(&run.u, k))
    });
    Ok(points.collect())
}

fn observability_at(
    study: &Study,
    a: &DMatrix<f64>,
    c: &DMatrix<f64>,
    place: Option<(f64, &[f64])>,
) -> Result<ObservabilityAt, StudyError> {
    let seen = of_pair(a, c)?;
    let unseen = match (seen.is_observable(), place) {
        (true, _) => UnseenModes::None,
        // A linearisation is known to rounding only.
        (false, Some(_)) => UnseenModes::Undecided,
        (false, None) => UnseenModes::of(a, c, study.plant.time()),
    };
    let reports = |modes: &[Mode]| modes.iter().map(|mode| report(study, mode)).collect();
    Ok(ObservabilityAt {
        t: place.map(|(t, _)| t),
        x: place.map(|(_, x)| x.to_vec()),
        rank: seen.rank,
        tolerance: seen.tolerance,
        modes: reports(&seen.modes),
        hidden: reports(&seen.unobservable),
        unseen,
    })
}

fn report(study: &Study, mode: &Mode) -> ModeReport {
    let direction: DVector<f64> = mode.direction.map(|x| x.re);
    // One of several directions would be one by chance.
    let words = match (mode.directions, direction.len()) {
        (0 | 1, _) => study.plant.direction_in_words(direction.as_slice()),
        (count, order) if count == order => "every direction alike".to_owned(),
        (count, _) => format!("{count} independent directions alike"),
    };
    ModeReport {
        eigenvalue: [mode.eigenvalue.re, mode.eigenvalue.im],
        margin: mode.margin,
        words,
        direction: direction.as_slice().to_vec(),
    }
}
