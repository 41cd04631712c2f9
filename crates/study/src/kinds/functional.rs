//! The functional observer: an estimate of z = K x alone.

use std::sync::Arc;

use luenberger_design::DesignError;
use luenberger_linalg::{eigenvalues, functional_observer};
use luenberger_observers::FunctionalObserver;
use luenberger_plants::StateSpace;
use luenberger_proof::wording::{counted, significant};
use luenberger_sim::{AnyObserver, Scenario};
use nalgebra::{Complex, DMatrix, DVector, Dyn};

use super::declaration::{Declaration, Tuning};
use super::{Kind, of};
use crate::designed::{NonlinearStep, Refusal, Running, StepOf, continuous};
use crate::study::{GainSpec, ObserverKind, PlantClass, SamplingSpec, Specification, Time};
use crate::synthesis::{Designed, NoDesign, Plan, matrix, number, poles, uncertified};

use crate::keys::{Type, required};
use crate::reader::{Given, Reader, check, gain};
use crate::results::{DesignReport, Statement};
use crate::synthesis::explain::Misfit;

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "functional",
    about: "Functional observer (Darouach): an estimate of z = K x alone, with as many states as K has rows; for linear plants whose outputs do not depend on the input. Its errors are K x - zhat, its first estimate is K initial.",
    source: "Luenberger 1966, Darouach 2000",
    plant: PlantClass::Linear(Time::OF_STATE),
    keys: &[
        required("k", Type::Rows, "K of z = K x, a row for each function."),
        required(
            "poles",
            Type::Poles,
            "Eigenvalues of F: as many numbers as `k` has rows, complex ones as [re, im] with their conjugates.",
        ),
    ],
    kind: of::<Functional>,
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
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoDesign> {
        let plant = plan.linear()?;
        plan.explained(functional(&plant, &self.k, &self.poles))
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

    fn step(&self, _of: &StepOf<'_>) -> Result<Option<NonlinearStep>, Refusal> {
        Err((
            "a functional observer has no export: it estimates z = K x alone, and has no prediction of the output between two samples"
                .to_owned(),
            vec!["reduced-order, or luenberger, with K times its estimate".to_owned()],
        ))
    }
}

fn functional(plant: &StateSpace, k: &DMatrix<f64>, requested: &[Complex<f64>]) -> Result<Designed, Misfit> {
    let o = functional_observer(&plant.a, &plant.b, &plant.c, k, requested).map_err(DesignError::from)?;
    let found = eigenvalues(&o.f).map_err(DesignError::from)?;
    let slowest = -found.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max);
    let observer =
        FunctionalObserver::new(o.f.clone(), o.g.clone(), o.h.clone(), o.n.clone()).map_err(DesignError::from)?;
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
            number("decay rate", slowest),
            number("noise passed to the estimate, norm of N", o.n.clone().svd(false, false).singular_values.max()),
            number("relative residual of T A = F T + G C and K = T + N C", o.residual),
        ],
        ..uncertified("the equations hold up to rounding")
    };
    Ok(Designed::new(RunningFunctional { observer, k: k.clone() }.into(), report, None))
}
