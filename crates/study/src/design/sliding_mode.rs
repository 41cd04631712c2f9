//! The sliding-mode observer of a chain of integrators.

use luenberger_design::{SuperTwistingDesign, sliding_mode_gains};
use luenberger_expression::Row;
use luenberger_observers::sliding_mode::{Discretisation, SlidingModeObserver};
use luenberger_proof::certificate::Reading;
use luenberger_proof::wording::{at_most, significant};
use nalgebra::{DMatrix, DVector};

use super::alternative::{Advice, other_kinds};
use super::explain::{self, Misfit};
use super::{Designed, NoDesign, facts, matrix, number, proved_of, upper_bound};
use crate::model::Model;
use crate::results::Proposal;
use crate::results::{DesignReport, DesignVerdict, FailureReport, Statement};
use crate::runnable::Runnable;
use crate::structure::Structure;
use crate::study::{ObserverSpec, SlidingModeSpec, Study};

/// Why the plant is not shown to be a chain `x1' = x2, .., x_n' = f` with the output x1 and the inputs in the last.
fn not_a_chain(study: &Study, structure: &Structure) -> Option<String> {
    let size = study.plant.model.size();
    if size.outputs != 1 {
        return Some(format!("the plant has {} outputs", size.outputs));
    }
    if structure.output_state(0) != Some(0) {
        return Some(explain::other_than(study, structure, Row::Output(0), 0));
    }
    let i = (0..size.states.saturating_sub(1)).find(|i| !structure.is_next_state(*i))?;
    Some(explain::other_than(study, structure, Row::Derivative(i), i + 1))
}

pub(super) fn chain(study: &Study, requested: &ObserverSpec) -> Result<(), FailureReport> {
    let (structure, kind) = (study.plant.model.structure(), requested.kind.name());
    let Some(why) = not_a_chain(study, &structure) else { return Ok(()) };
    let hypothesis = format!(
        "the kind {kind} is for a chain of integrators, x1' = x2, .., with the output x1 and the input in the last: {why}"
    );
    let is_triangular = study.plant.outputs.len() == 1
        && structure.feedthrough().is_none()
        && explain::no_chains(study, &structure, kind, &[study.plant.states.len()]).is_none();
    let high_gain = Proposal::kind("high-gain", ["r = 0.1".to_owned()], "for triangular plants; r is to be chosen");
    let advice = Advice::of(is_triangular.then_some(high_gain))
        .and(other_kinds(study, requested))
        .and(Advice::hint("states that are the output and its derivatives, where the plant has them"));
    Err(explain::failure(requested, hypothesis, advice))
}

/// The gains of a specification.
pub(crate) fn gains(spec: &SlidingModeSpec, order: usize) -> Result<Vec<f64>, luenberger_design::DesignError> {
    match &spec.gains {
        Some(gains) => Ok(gains.clone()),
        None => sliding_mode_gains(order, spec.bound),
    }
}

pub(super) fn design(study: &Study, requested: &ObserverSpec, spec: &SlidingModeSpec) -> Result<Designed, NoDesign> {
    chain(study, requested)?;
    designed(&study.plant.model, &study.plant.reading(), spec)
        .map_err(|misfit| explain::misfit(study, requested, &misfit).into())
}

fn designed(model: &Model, reading: &Reading<'_>, spec: &SlidingModeSpec) -> Result<Designed, Misfit> {
    let states = reading.states;
    let n = model.size().states;
    let gains = gains(spec, n)?;
    let rule = if spec.explicit { Discretisation::Explicit } else { Discretisation::Implicit };
    let observer = SlidingModeObserver::new(model.clone(), DVector::from_column_slice(&gains), spec.period, rule)?;
    let certified = match gains.as_slice() {
        [k1, k2] => SuperTwistingDesign::new([*k1, *k2], spec.bound)?,
        _ => None,
    };
    let (h, bound) = (spec.period, spec.bound);
    let statement = match (&certified, n) {
        (Some(design), _) => proved_of(&design.certificate, reading),
        (None, 2) => Statement::of(
            "No stability certificate: the quadratic Lyapunov function was not found for these gains and this bound, which does not mean that the observer fails.",
        ),
        (None, _) => Statement::of(format!(
            "No stability certificate for {n} states: convergence in continuous time is a theorem of Levant's, for gains that are large enough."
        )),
    };
    let mut statement = statement.remark(match (spec.explicit, n) {
        (true, _) => "The step evaluates the sign at the old estimate (explicit Euler): it chatters, and is meant for comparison.",
        (false, _) => "The step solves for the sign (implicit Euler): it does not chatter.",
    });
    if !spec.explicit && n == 2 && gains[1] >= bound {
        statement = statement.remark(format!(
            "Of the sampled observer the theory says, beside the certificate: once two innovations in a row are at most h^2 k2, about {}, and without noise, {} is exact at every sample after its correction, and {} up to h {}/2 = {}.",
            significant(h * h * gains[1], 4),
            states[0],
            states[1],
            at_most(bound, 5),
            at_most(h * bound / 2.0, 4)
        ));
    }
    let mut numbers = vec![number("period", h), number("innovation that is corrected to 0", observer.boundary_layer())];
    let mut matrices = vec![matrix("k", &DMatrix::from_column_slice(n, 1, &gains))];
    let (found, word, evidence) = match &certified {
        Some(design) => {
            numbers.push(number("alpha", design.alpha));
            numbers.push(number("c", design.c));
            numbers.push(upper_bound(
                "bound of the reaching time from an error of 1 in the last state",
                design.reaching_time(0.0, 1.0),
            ));
            matrices.push(matrix("P", &design.p));
            (facts(&design.certificate, &[]), DesignVerdict::of(&design.certificate), None)
        }
        None => (Vec::new(), DesignVerdict::NONE, Some("no certificate: check these gains by simulation".to_owned())),
    };
    let report = DesignReport {
        statement,
        matrices,
        poles: Vec::new(),
        numbers,
        facts: found,
        verdict: word,
        evidence,
        noise_deviation: Vec::new(),
    };
    let certificate = certified.map(|design| design.certificate.clone());
    Ok(Designed::new(Runnable::SlidingMode(Box::new(observer)), report, certificate))
}
