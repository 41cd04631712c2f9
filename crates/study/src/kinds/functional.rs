//! The functional observer: an estimate of z = K x alone.

use std::sync::Arc;

use luenberger_design::DesignError;
use luenberger_linalg::{LinalgError, eigenvalues, functional_observer};
use luenberger_observers::FunctionalObserver;
use luenberger_plants::StateSpace;
use luenberger_proof::wording::{counted, significant};
use luenberger_sim::{AnyObserver, Scenario};
use nalgebra::{Complex, DMatrix, DVector, Dyn};

use super::declaration::{Declaration, Tuning};
use super::{Kind, as_kind};
use crate::designed::{NonlinearStep, Running, StepOf, continuous};
use crate::study::{GainSpec, ObserverKind, PlantClass, SamplingSpec, Specification, Time};
use crate::synthesis::alternative::{list, rows};
use crate::synthesis::{Designed, Plan, matrix, number, other_kinds, poles, uncertified};

use crate::keys::{Type, required};
use crate::reader::{Given, Reader, check, gain};
use crate::results::{Advice, Cause, DesignReport, NoObserver, Proposal, Quantity, Statement};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "functional",
    about: "Functional observer (Darouach): an estimate of z = K x alone, with as many states as K has rows; for linear plants whose outputs do not depend on the input. Its errors are K x - zhat, its first estimate is K initial.",
    source: "Luenberger 1966, Darouach 2000",
    plant: PlantClass::Linear(Time::OF_STATE),
    keys: &[&[
        required("k", Type::Rows, "K of z = K x, a row for each function."),
        required(
            "poles",
            Type::Poles,
            "Eigenvalues of F: as many numbers as `k` has rows, complex ones as [re, im] with their conjugates.",
        ),
    ]],
    kind: as_kind::<Functional>,
    read,
    takes_long: false,
    tuning: Tuning::Never("it estimates functions of the state, and the others are compared by the state"),
};

fn read(given: &Given<'_>, reader: &mut Reader) -> Option<ObserverKind> {
    let (node, root, size) = (given.node, given.root, given.size());
    let table = ["log", "sweep"].into_iter().find(|table| root.get(table).is_some());
    if let Some(table) = table {
        let message =
            format!("this kind estimates functions of the state, and [{table}] compares estimates of the state");
        return reader.refuse(
            check::head(node),
            message,
            format!("expected no [{table}], or another kind such as reduced-order"),
        );
    }
    let fed = root.get("input").and_then(|input| input.get("feedback")?.get("observer")?.text());
    if fed == Some(given.name) {
        let message = "the feedback u = r - K xhat has the estimate of the whole state";
        return reader.refuse(check::head(node), message, "expected the feedback of another observer");
    }
    let why = format!("the plant has {}", counted(size.states, "state"));
    let k = reader.matrix(node.get("k")?, "k", (None, Some(size.states)), &why)?;
    let rows = format!("`k` has {}", counted(k.nrows(), "row"));
    match gain::poles(node.get("poles")?, k.nrows(), &rows, reader)? {
        GainSpec::Poles(poles) => Some(Functional { k, poles }.into()),
        _ => None,
    }
}

/// A functional observer of z = K x.
#[derive(Debug, Clone, PartialEq)]
pub struct Functional {
    /// K, r x n.
    pub k: DMatrix<f64>,
    /// The eigenvalues of F.
    pub poles: Vec<Complex<f64>>,
}

impl Specification for Functional {
    declared!();

    fn poles(&self) -> Option<&[Complex<f64>]> {
        Some(&self.poles)
    }

    fn functions(&self) -> Option<(&DMatrix<f64>, Vec<String>)> {
        Some((&self.k, (1..=self.k.nrows()).map(|i| format!("z{i}")).collect()))
    }

    fn faster(&self, factor: f64) -> Option<ObserverKind> {
        Some(Self { poles: self.poles.iter().map(|pole| pole * factor).collect(), ..self.clone() }.into())
    }
}

impl Kind for Functional {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        functional(plant, &self.k, &self.poles)
    }

    // Where Darouach's conditions do not hold.
    fn advice(&self, plan: &Plan<'_>, cause: &Cause) -> Option<Advice> {
        let Cause::Design(DesignError::Linalg(error)) = cause else { return None };
        let hint = match error {
            LinalgError::NotFunctional { .. } => None,
            LinalgError::FixedObserverMode { .. } => Some("other rows of `k`"),
            _ => return None,
        };
        let plant = plan.study.plant.model.linear()?;
        let fastest = self.poles.iter().map(|pole| pole.re).fold(0.0, f64::min);
        // Poles a tenth apart, from the fastest one on.
        let further = |count: usize| (0..count).map(move |i| short(fastest * (1.0 + 0.1 * (i + 1) as f64)));
        let mut ways = Vec::new();
        if let (LinalgError::NotFunctional { row, .. }, true) = (error, self.poles.iter().all(|pole| pole.im == 0.0)) {
            let mut longer = self.k.clone().insert_row(self.k.nrows(), 0.0);
            longer.row_mut(self.k.nrows()).copy_from(&(self.k.row(*row) * &plant.a));
            let poles = self.poles.iter().map(|pole| pole.re).chain(further(1));
            let keys = [format!("k = {}", rows(&longer)), format!("poles = {}", list(poles))];
            ways.push(Proposal::keys(keys, &["k", "poles"], "with the rate of a function among the functions"));
        }
        let left = plant.a.nrows().saturating_sub(plant.c.nrows());
        let poles = format!("poles = {}", list(further(left)));
        ways.push(Proposal::kind("reduced-order", [poles], "for the whole state"));
        let others = other_kinds(plan.study, plan.requested);
        Some(Advice::of(ways).and(others).and(hint.map_or_else(Advice::default, Advice::hint)))
    }
}

/// A functional observer, ready to run.
#[derive(Debug, Clone)]
pub(super) struct RunningFunctional {
    observer: FunctionalObserver<f64, Dyn, Dyn, Dyn>,
    k: DMatrix<f64>,
}

impl Running for RunningFunctional {
    fn any(&self) -> Arc<dyn AnyObserver + '_> {
        continuous(&self.observer)
    }

    fn join<'a>(
        &'a self,
        scenario: Scenario<'a>,
        name: &str,
        initial: &[f64],
        _sampling: &SamplingSpec,
    ) -> Scenario<'a> {
        let first = &self.k * DVector::from_column_slice(initial);
        scenario.functional_observer(name, &self.observer, first.as_slice(), &self.k)
    }

    fn step(&self, _of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let hypothesis = "a functional observer has no export: it estimates z = K x alone, and has no prediction of the output between two samples";
        Err(NoObserver::new(hypothesis).hint("reduced-order, or luenberger, with K times its estimate"))
    }
}

fn functional(plant: &StateSpace, k: &DMatrix<f64>, requested: &[Complex<f64>]) -> Result<Designed, NoObserver> {
    let o = functional_observer(&plant.a, &plant.b, &plant.c, k, requested)?;
    let found = eigenvalues(&o.f)?;
    let slowest = -found.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max);
    let observer = FunctionalObserver::new(o.f.clone(), o.g.clone(), o.h.clone(), o.n.clone())?;
    let named = [("K", k), ("T", &o.t), ("F", &o.f), ("G", &o.g), ("H", &o.h), ("N", &o.n)];
    let report = DesignReport {
        statement: Statement::of(format!(
            "No stability certificate: T A = F T + G C holds up to rounding, with the relative residual {}. With equality the error of z = K x, {}, is e' = F e, for all x(0) and w(0): asymptotic rate exp(-{} t).",
            significant(o.residual, 2),
            counted(k.nrows(), "function"),
            significant(slowest, 5)
        )),
        matrices: named.into_iter().filter(|(_, m)| !m.is_empty()).map(|(name, m)| matrix(name, m)).collect(),
        poles: poles(&found),
        numbers: vec![
            number(Quantity::DecayRate, slowest),
            number("noise passed to the estimate, norm of N", o.n.clone().svd(false, false).singular_values.max()),
            number("relative residual of T A = F T + G C and K = T + N C", o.residual),
        ],
        ..uncertified("the equations hold up to rounding")
    };
    Ok(Designed::new(RunningFunctional { observer, k: k.clone() }.into(), report, None))
}

/// A number with three digits.
fn short(x: f64) -> f64 {
    significant(x, 3).parse().unwrap_or(x)
}
