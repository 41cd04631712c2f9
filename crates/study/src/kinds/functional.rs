//! The functional observer: an estimate of z = K x alone.

use std::sync::Arc;

use luenberger_design::DesignError;
use luenberger_expression::Recorded;
use luenberger_linalg::{
    LeastFunctionalObserver, LinalgError, eigenvalues, functional_observer, least_functional_observer,
};
use luenberger_observers::{
    DiscreteForm, FeedthroughObserver, FunctionalObserver, Observer, ObserverError, SampledObserver,
};
use luenberger_plants::StateSpace;
use luenberger_proof::wording::{counted, significant};
use luenberger_sim::{AnyObserver, Scenario};
use nalgebra::{Complex, DMatrix, DVector, Dyn, convert};

use super::declaration::{Declaration, Tuning};
use super::reduced_order::{NOISE_PASSED, WithFeedthrough, norm};
use super::{Kind, as_kind};
use crate::designed::{NonlinearStep, Running, StepOf, continuous, sampled};
use crate::study::{GainSpec, ObserverKind, PlantClass, SamplingSpec, Specification, Time, faster_poles};
use crate::synthesis::alternative::{list, rows};
use crate::synthesis::{Designed, Plan, matrix, number, other_kinds, poles, uncertified};

use crate::keys::{Type, optional, required};
use crate::reader::tree::Node;
use crate::reader::{Given, Reader, check, gain};
use crate::results::{Advice, Cause, DesignReport, NoObserver, Proposal, Quantity, Statement};
use crate::steps::recorded::{cast, step_at_samples};
use crate::synthesis::linear::measurement;

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "functional",
    about: "Functional observer (Darouach): an estimate of z = K x alone, with as many states as K has rows, or as few beyond as are found; for linear plants. Its errors are K x - zhat, its first estimate is K initial.",
    source: "Luenberger 1966, Darouach 2000; of least order Fernando, Trinh and Jennings 2010",
    plant: PlantClass::Linear(Time::ANY),
    keys: &[&[
        required("k", Type::Rows, "K of z = K x, a row for each function."),
        required(
            "poles",
            Type::Poles,
            "Eigenvalues of F: as many numbers as `k` has rows, complex ones as [re, im] with their conjugates; with `order = \"least\"` at least as many, of which the first ones are taken.",
        ),
        optional(
            "order",
            Type::Choice(&[
                ("functions", "As many states as `k` has rows."),
                ("least", "The least order that is found, with further functions beside those of `k`."),
            ]),
            "Order of the observer (default functions).",
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
    let is_least = node.get("order").and_then(Node::text) == Some("least");
    let given = node.get("poles")?;
    let count = if is_least { k.nrows().max(given.list()?.len()) } else { k.nrows() };
    match gain::poles(given, count, &rows, reader)? {
        GainSpec::Poles(poles) => Some(Functional { k, poles, is_least }.into()),
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
    /// Whether further functions may stand beside K, and the first of the poles are those of the order found.
    pub is_least: bool,
}

impl Specification for Functional {
    declared!();

    fn poles(&self) -> Option<&[Complex<f64>]> {
        Some(&self.poles)
    }

    fn functions(&self) -> Option<(&DMatrix<f64>, Vec<String>)> {
        Some((&self.k, (1..=self.k.nrows()).map(|i| format!("z{i}")).collect()))
    }

    fn updates(&self, dt: Option<f64>) -> bool {
        dt.is_some()
    }

    fn faster(&self, factor: f64, dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self { poles: faster_poles(&self.poles, factor, dt), ..self.clone() }.into())
    }
}

impl Kind for Functional {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        functional(plan, plant, self)
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, _dt: f64) -> Result<Designed, NoObserver> {
        self.design(plan)
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
        let dt = plan.study.plant.dt;
        let fastest = match dt {
            None => self.poles.iter().map(|pole| pole.re).fold(0.0, f64::min),
            Some(_) => self.poles.iter().map(|pole| pole.norm()).fold(1.0, f64::min),
        };
        // Poles a tenth apart, from the fastest one on.
        let further = |count: usize| {
            let faster = move |i: usize| faster_poles(&[fastest.into()], 1.0 + 0.1 * (i + 1) as f64, dt)[0].re;
            (0..count).map(move |i| short(faster(i)))
        };
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

/// The observer of the functions, and of others behind them.
type OfFunctions<T> = FeedthroughObserver<FunctionalObserver<T, Dyn, Dyn, Dyn, Dyn>, T, Dyn, Dyn>;

/// The same at samples.
type AtSamples = DiscreteForm<OfFunctions<f64>, f64, Dyn, Dyn, Dyn, Dyn, Dyn>;

/// A functional observer, ready to run.
#[derive(Debug, Clone)]
pub(super) struct RunningFunctional<O> {
    observer: O,
    k: DMatrix<f64>,
}

impl<O> RunningFunctional<O> {
    fn first(&self, initial: &[f64]) -> DVector<f64> {
        &self.k * DVector::from_column_slice(initial)
    }
}

impl Running for RunningFunctional<WithFeedthrough<FunctionalObserver<f64, Dyn, Dyn, Dyn, Dyn>>> {
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
        scenario.functional_observer(name, &self.observer, self.first(initial).as_slice(), &self.k)
    }

    fn step(&self, _of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let hypothesis = "a functional observer has no export: it estimates z = K x alone, and has no prediction of the output between two samples";
        Err(NoObserver::new(hypothesis).hint("reduced-order, or luenberger, with K times its estimate"))
    }
}

impl Running for RunningFunctional<AtSamples> {
    fn any(&self) -> Arc<dyn AnyObserver + '_> {
        sampled(&self.observer)
    }

    fn join<'a>(
        &'a self,
        scenario: Scenario<'a>,
        name: &str,
        initial: &[f64],
        _sampling: &SamplingSpec,
    ) -> Scenario<'a> {
        scenario.sampled_functional_observer(name, &self.observer, self.first(initial).as_slice(), &self.k)
    }

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let (of_functions, outputs) = (self.observer.observer(), self.observer.dimensions().outputs);
        let (functions, order) = (self.k.nrows(), of_functions.dimensions().state);
        let names = (1..=functions).map(|i| format!("z{i}")).chain((1..=order).map(|i| format!("w{i}")));
        let first = self.observer.first().into_iter().flatten().copied();
        let start = self.first(&of.observer.initial).into_iter().copied().chain(first).collect();
        let make = || over_recorded(of_functions);
        step_at_samples(of, make, (names.collect(), start), |_| vec![convert(0.0); outputs]).map(Some)
    }
}

/// The same over the scalar that records.
fn over_recorded(of: &OfFunctions<f64>) -> Result<OfFunctions<Recorded>, ObserverError> {
    let o = of.inner();
    let (functions, first) = o.first();
    let first = (functions, first.map(convert));
    let inner = FunctionalObserver::leading(cast(o.f()), cast(o.g()), cast(o.h()), cast(o.n()), first)?;
    FeedthroughObserver::new(inner, of.d().map(cast))
}

fn functional(plan: &Plan<'_>, plant: &StateSpace, of: &Functional) -> Result<Designed, NoObserver> {
    let Functional { k, poles: requested, is_least } = of;
    let StateSpace { a, b, c, d } = plant;
    let found = if *is_least {
        least_functional_observer(a, b, c, k, requested)
    } else {
        let is_least = false;
        functional_observer(a, b, c, k, requested).map(|observer| LeastFunctionalObserver {
            observer,
            functions: k.clone(),
            is_least,
        })
    };
    let found = found?;
    let (o, functions) = (&found.observer, &found.functions);
    let spectrum = eigenvalues(&o.f)?;
    let initial = DVector::from_column_slice(&plan.requested.initial);
    let first = (Dyn(k.nrows()), functions * &initial);
    let observer = FunctionalObserver::leading(o.f.clone(), o.g.clone(), o.h.clone(), o.n.clone(), first)?;
    let observer = FeedthroughObserver::new(observer, d.clone())?;
    let (motion, factor, asymptotic) = if plan.study.plant.dt.is_some() {
        let radius = spectrum.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
        let words = format!("asymptotic factor {} at each sample", significant(radius, 5));
        ("e+", number(Quantity::LargestPole, radius), words)
    } else {
        let slowest = -spectrum.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max);
        let words = format!("asymptotic rate exp(-{} t)", significant(slowest, 5));
        ("e'", number(Quantity::DecayRate, slowest), words)
    };
    let all = if functions.nrows() > k.nrows() { "all functions of the observer" } else { "z = K x" };
    let statement = Statement::of(format!(
        "No stability certificate: T A = F T + G C holds up to rounding, with the relative residual {}. With equality the error of {all}, {}, is {motion} = F e, for all x(0) and w(0): {asymptotic}.",
        significant(o.residual, 2),
        counted(functions.nrows(), "function"),
    ));
    let order = functions.nrows();
    let named = [("K", functions), ("T", &o.t), ("F", &o.f), ("G", &o.g), ("H", &o.h), ("N", &o.n)];
    let report = DesignReport {
        statement: statement
            .remark(if *is_least { of_order(order, k.nrows(), found.is_least) } else { String::new() })
            .remark(measurement(plant)),
        matrices: named.into_iter().filter(|(_, m)| !m.is_empty()).map(|(name, m)| matrix(name, m)).collect(),
        poles: poles(&spectrum),
        numbers: vec![
            factor,
            number(NOISE_PASSED, norm(&o.n)),
            number("relative residual of T A = F T + G C and K = T + N C", o.residual),
        ],
        ..uncertified("the equations hold up to rounding")
    };
    let k = k.clone();
    let runnable = match plan.study.plant.dt {
        None => RunningFunctional { observer, k }.into(),
        Some(dt) => {
            let observer = DiscreteForm::holding(observer, &o.t * initial, dt)?;
            RunningFunctional { observer, k }.into()
        }
    };
    Ok(Designed::new(runnable, report, None))
}

/// What is said of the order.
fn of_order(order: usize, rows: usize, is_least: bool) -> String {
    let further = match order - rows {
        0 => "no further function is needed".to_owned(),
        further => format!("{} below those of `k` in K", counted(further, "further function")),
    };
    let least = if is_least {
        "to working precision no observer of a lower order has the first ones of these poles"
    } else {
        "whether one of a lower order exists is not decided"
    };
    format!("The order is {order}: {further}, and {least}.")
}

/// A number with three digits.
fn short(x: f64) -> f64 {
    significant(x, 3).parse().unwrap_or(x)
}
