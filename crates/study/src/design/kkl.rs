//! Numerical KKL observers of the plants of a study: run-time sizes are converted to const generics here.

use std::ops::ControlFlow::{self, Break, Continue};
use std::sync::atomic::{AtomicBool, Ordering};

use luenberger_design::enclosure::Axis;
use luenberger_design::numerical_kkl::{
    Choice, ChoiceOptions, Domain, Errors, Escape, HeldInputDesign, HeldInputs, NumericalKklDesign, NumericalKklError,
    Progress, Settings, Spline, Table, TargetSystem, Train, choose_with_table,
};
use luenberger_expression::Fixed;
use luenberger_proof::wording::{shortest, significant};
use nalgebra::SVector;

use super::explain::Misfit;
use super::{Designed, number};
use crate::model::Model;
use crate::results::{DesignReport, DesignVerdict, NamedNumber, Statement};
use crate::runnable::{Kkl, Runnable};
use crate::study::KklSpec;

/// The design for a model whose sizes have been checked: 2 to 6 states, or 2 to 3 with held inputs, and one output. It
/// stops once `cancel` is true.
pub(super) fn design(model: &Model, requested: &KklSpec, cancel: &AtomicBool) -> Result<Designed, Misfit> {
    let size = model.size();
    let plant = model.expressions()?;
    macro_rules! plain {
        ($n:literal, $z:literal, $table:ty, $accurate:ident, $embedded:ident) => {{
            let (design, report) = of_size::<$table, $n, $z>(&plant.fixed()?, requested, cancel)?;
            let (accurate, small) = (Box::new(design.interpolated), Box::new(design.embedded));
            (if requested.embedded { Kkl::$embedded(small) } else { Kkl::$accurate(accurate) }, report)
        }};
    }
    let (kkl, report) = match (size.states, size.inputs) {
        (2, 0) => plain!(2, 3, Spline<2, 3>, Two, TwoEmbedded),
        (3, 0) => plain!(3, 4, Spline<3, 4>, Three, ThreeEmbedded),
        (4, 0) => plain!(4, 5, Spline<4, 5>, Four, FourEmbedded),
        (5, 0) => plain!(5, 6, Train<5, 6>, Five, FiveEmbedded),
        (_, 0) => plain!(6, 7, Train<6, 7>, Six, SixEmbedded),
        (2, 1) => {
            let (observer, report) = held::<2, 1, 3, 4>(&plant.fixed()?, requested, cancel)?;
            (Kkl::TwoHeld(observer), report)
        }
        (2, _) => {
            let (observer, report) = held::<2, 2, 3, 5>(&plant.fixed()?, requested, cancel)?;
            (Kkl::TwoHeldTwo(observer), report)
        }
        (_, 1) => {
            let (observer, report) = held::<3, 1, 4, 5>(&plant.fixed()?, requested, cancel)?;
            (Kkl::ThreeHeld(observer), report)
        }
        _ => {
            let (observer, report) = held::<3, 2, 4, 6>(&plant.fixed()?, requested, cancel)?;
            (Kkl::ThreeHeldTwo(observer), report)
        }
    };
    Ok(Designed::new(Runnable::Kkl(Box::new(kkl)), report, None))
}

/// With what a design is made.
struct Chosen<const N: usize, const Z: usize> {
    settings: Settings<N>,
    wanted: ChoiceOptions,
    choice: Choice,
    domain: Domain<N>,
    target: TargetSystem<1, Z>,
}

/// The choices for the plant at a constant input.
fn chosen<W: Table<N, Z>, const N: usize, const M: usize, const Z: usize>(
    plant: &Fixed<N, M, 1>,
    input: SVector<f64, M>,
    requested: &KklSpec,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Chosen<N, Z>, NumericalKklError> {
    let ends = |f: fn(&(f64, f64)) -> f64| std::array::from_fn(|i| requested.domain.get(i).map_or(f64::NAN, f));
    let (lower, upper) = (ends(|end| end.0), ends(|end| end.1));
    let mut settings = Settings {
        leaves: requested.leaves,
        degree: requested.degree,
        samples: requested.samples,
        rank: requested.rank,
        rank_tolerance: 1e-4,
        // All pairs of this grid are compared.
        injectivity_points: [17, 17, 17, 9, 6, 4, 3][N.min(6)],
        fallback: [9, 9, 9, 9, 5, 4, 3][N.min(6)],
        ..Settings::default()
    };
    let wanted = ChoiceOptions {
        cutoff: requested.cutoff,
        points: requested.points,
        escape: requested.escape.map(|margin| Escape::Slowed { margin }),
        ..ChoiceOptions::default()
    };
    let choice = choose_with_table::<_, W, N, M, Z>(plant, (lower, upper), input, &wanted, &settings, progress)?;
    settings.points = [choice.points; N];
    let domain = Domain::new(lower, upper, choice.escape)?;
    let target = TargetSystem::<1, Z>::bessel(choice.cutoff)?;
    Ok(Chosen { settings, wanted, choice, domain, target })
}

type Design<W, const N: usize, const Z: usize> = NumericalKklDesign<N, 0, 1, Z, W>;

fn of_size<W: Table<N, Z>, const N: usize, const Z: usize>(
    plant: &Fixed<N, 0, 1>,
    requested: &KklSpec,
    cancel: &AtomicBool,
) -> Result<(Design<W, N, Z>, DesignReport), NumericalKklError> {
    let mut on = |_| if cancel.load(Ordering::Relaxed) { Break(()) } else { Continue(()) };
    let made = chosen::<W, N, 0, Z>(plant, SVector::zeros(), requested, &mut on)?;
    let Chosen { settings, wanted, choice, domain, target } = &made;
    let design = Design::<W, N, Z>::with_table(plant, target, domain, SVector::zeros(), settings, &mut on)?;
    let measured = &design.report;
    let form = if requested.embedded { &measured.embedded } else { &measured.interpolated };
    let mut numbers = numbers(choice, (measured.horizon, measured.spline.1, measured.residual.1));
    let table = design.interpolated.map().inverse().spline();
    if let Some(rank) = table.rank() {
        numbers.push(number("largest rank of the table", rank as f64));
        numbers.push(number("numbers in the table", table.numbers() as f64));
        numbers.push(number("trajectories of the table", measured.trajectories as f64));
    }
    numbers.extend(errors(form));
    let report = report(
        "z' = D z + B y is made to tend to T(x) while x(t) stays in the region, where the estimation error is that of the left inverse. The errors are measured; nothing is proved of them.",
        target,
        numbers,
        format!(
            "errors measured at {} points that were not used in the fit{}",
            form.samples,
            explained(choice, wanted)
        ),
    );
    Ok((design, report))
}

/// An observer for held inputs, with its report.
type Held<const N: usize, const M: usize, const Z: usize, const ZM: usize> =
    (Box<HeldInputs<N, M, 1, Z, ZM>>, DesignReport);

fn held<const N: usize, const M: usize, const Z: usize, const ZM: usize>(
    plant: &Fixed<N, M, 1>,
    requested: &KklSpec,
    cancel: &AtomicBool,
) -> Result<Held<N, M, Z, ZM>, NumericalKklError> {
    let mut on = |_| if cancel.load(Ordering::Relaxed) { Break(()) } else { Continue(()) };
    let family: [(f64, f64); M] =
        std::array::from_fn(|i| requested.inputs.get(i).copied().unwrap_or((f64::NAN, f64::NAN)));
    let middle = SVector::from_fn(|i, _| 0.5 * (family[i].0 + family[i].1));
    let mut made = chosen::<Spline<N, Z>, N, M, Z>(plant, middle, requested, &mut on)?;
    let mut attempt = |made: &Chosen<N, Z>| {
        let Chosen { settings, domain, target, .. } = made;
        HeldInputDesign::<N, M, 1, Z, ZM>::new(plant, target, domain, (&family, requested.nodes), settings, &mut on)
    };
    let mut design = attempt(&made);
    // A trajectory that is bounded at the middle input may be unbounded at another.
    if let Err(NumericalKklError::HeldInput { error, .. }) = &design
        && matches!(**error, NumericalKklError::Escapes { .. })
        && requested.escape.is_none()
        && made.choice.escape == Escape::Free
    {
        let escape = Escape::Slowed { margin: 1.0 };
        made.domain = Domain::new((*made.domain.lower()).into(), (*made.domain.upper()).into(), escape)?;
        made.choice.escape = escape;
        design = attempt(&made);
    }
    let HeldInputDesign { observer, report: measured } = design?;
    let Chosen { wanted, choice, target, .. } = &made;
    let form = if requested.embedded { &measured.embedded } else { &measured.interpolated };
    let mut numbers = numbers(choice, (measured.horizon, measured.spline.1, measured.residual.1));
    numbers.push(number("inputs with a table", measured.tables as f64));
    numbers.extend(errors(form));
    let report = report(
        "z' = D z + B y is made to tend to T(x, u) while x(t) stays in the region and the input is held at a value of its range, where the estimation error is that of the left inverse. The errors are measured; nothing is proved of them. After a jump of the input z - T(x, u) begins anew; while the input varies, the derivative of T by u times u' drives it; an input outside of its range is taken at the nearest end.",
        target,
        numbers,
        format!(
            "errors measured at {} pairs of state and input that were not used in the fit{}",
            form.samples,
            explained(choice, wanted)
        ),
    );
    Ok((Box::new(if requested.embedded { observer.embedded() } else { observer }), report))
}

/// The numbers of every design.
fn numbers(choice: &Choice, (horizon, table, residual): (f64, f64, f64)) -> Vec<NamedNumber> {
    vec![
        number("cutoff", choice.cutoff),
        number("grid points per axis", choice.points as f64),
        number("memory", horizon),
        number("largest error of the table", table),
        number("largest residual of dT/dx f = D T + B y", residual),
    ]
}

fn errors<const N: usize>(form: &Errors<N>) -> Vec<NamedNumber> {
    (0..N).map(|i| number(&format!("largest error of the left inverse, {}", Axis::State(i)), form.max[i])).collect()
}

fn report<const Z: usize>(
    statement: &str,
    target: &TargetSystem<1, Z>,
    numbers: Vec<NamedNumber>,
    evidence: String,
) -> DesignReport {
    DesignReport {
        statement: Statement::of(statement),
        matrices: Vec::new(),
        poles: target.dynamics().complex_eigenvalues().iter().map(|pole| [pole.re, pole.im]).collect(),
        numbers,
        facts: Vec::new(),
        verdict: DesignVerdict::MEASURED,
        noise_deviation: Vec::new(),
        evidence: Some(evidence),
    }
}

/// What was chosen, why, and what the other candidates gave; nothing where the keys left nothing to choose.
fn explained(choice: &Choice, wanted: &ChoiceOptions) -> String {
    if choice.candidates.is_empty() && (wanted.escape.is_some() || choice.escape == Escape::Free) {
        return String::new();
    }
    let mut chosen = Vec::new();
    if wanted.cutoff.is_none() {
        chosen.push(format!("cutoff = {}", significant(choice.cutoff, 4)));
    }
    if wanted.points.is_none() {
        chosen.push(format!("points = {}", choice.points));
    }
    if wanted.escape.is_none() {
        chosen.push(match choice.escape {
            Escape::Slowed { margin } => {
                format!("escape = {} (a trajectory is unbounded backward in time)", significant(margin, 4))
            }
            Escape::Free => "no escape".to_owned(),
        });
    }
    if choice.candidates.is_empty() {
        return format!(". Chosen: {}", chosen.join(", "));
    }
    let why = if choice.is_reached {
        format!("the slowest filter with a root mean square error of at most {} half-widths", shortest(wanted.error))
    } else {
        format!("the smallest error: none of the designs reaches {} half-widths", shortest(wanted.error))
    };
    let tried = choice.candidates.iter().map(|candidate| {
        let result = match &candidate.outcome {
            Ok(error) => format!("error {}", significant(*error, 2)),
            Err(NumericalKklError::Unresolved { .. }) => "refused (the table does not resolve T)".to_owned(),
            Err(NumericalKklError::NotInjective { .. }) => "refused (two states with one image)".to_owned(),
            Err(error) => format!("refused ({error})"),
        };
        format!("cutoff {} on {} points: {result}", significant(candidate.cutoff, 4), candidate.points)
    });
    let tried = tried.collect::<Vec<_>>().join("; ");
    format!(". Chosen: {}, {why}. Coarse designs: {tried}", chosen.join(", "))
}
