//! The numerical KKL observer: `z' = D z + B y` with a left inverse of T computed by simulation. Run-time sizes become
//! const generics here.

mod step;

use std::sync::Arc;

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::{Kind, as_kind};
use crate::designed::{NonlinearStep, Running, StepOf, continuous};
use crate::keys::{Key, Type, optional};
use crate::maps::MapNames;
use crate::model::Model;
use crate::reader::region::finite_bounds;
use crate::reader::{Given, Reader, maps};
use crate::results::{Advice, Cause, DesignReport, DesignVerdict, NamedNumber, NoObserver, Statement};
use crate::steps::steps_for;
use crate::study::{NUMBER, ObserverKind, ObserverSpec, PlantClass, Specification, Study, Time};
use crate::synthesis::alternative::{MOST_INPUTS, MOST_STATES, has_table};
use crate::synthesis::{Designed, Plan, number, other_kinds};
use crate::tuning::Value;
use luenberger_design::enclosure::Axis;
use luenberger_design::numerical_kkl::{
    Choice, ChoiceOptions, Domain, Errors, Escape, HeldInputDesign, HeldInputs, Inequality, NumericalKklDesign,
    NumericalKklError, Progress, Settings, Spline, Table, TargetSystem, Train, choose_with_table,
};
use luenberger_design::numerical_kkl::{Embedded, Interpolated, MOST_NODES, low_rank_trajectories, searched_tables};
use luenberger_export::ExportableObserver;
use luenberger_expression::{Expression, Fixed};
use luenberger_observers::numerical_kkl::NumericalKklObserver;
use luenberger_observers::numerical_kkl::tensor_train::MOST_RANK;
use luenberger_proof::wording::counted;
use luenberger_proof::wording::{shortest, significant};
use luenberger_sim::AnyObserver;
use nalgebra::SVector;
use std::ops::ControlFlow::{self, Break, Continue};
use std::sync::atomic::{AtomicBool, Ordering};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "kkl-numerical",
    about: "Numerical KKL observer: z' = D z + B y with a left inverse of T computed by simulation, for plants with one output: of 2 to 6 states, or of 2 or 3 states with inputs that are held at constant values.",
    source: "Kazantzis and Kravaris 1998, Andrieu and Praly 2006; computed by simulation",
    plant: PlantClass::Nonlinear(Time::OF_STATE),
    keys: &[KklSpec::KEYS],
    kind: as_kind::<KklSpec>,
    read: |given, reader| Some(KklSpec::read(given, reader)?.checked(given, reader)?.into()),
    takes_long: true,
    tuning: Tuning::Rules(&[Rule {
        name: "kkl-numerical",
        turn: 21,
        tuning: "cutoff and table by the search of the design, over the region",
        source: "docs/numerical-kkl.md",
        character: "its filter has the cutoff for which the map is accurate over the region, whatever settling is asked for",
        information: &[Information::Region],
        keys: |context| Ok(vec![vec![("domain", Value::pairs(context.information.region.states()))]]),
    }]),
};

crate::keys! { |size|
    /// A numerical KKL observer.
    #[derive(Debug, Clone, PartialEq)]
    pub struct KklSpec {
        /// Region of the states, n finite pairs [lower, upper].
        domain: Vec<(f64, f64)> as Bounds => |key, given, reader| {
            finite_bounds(given.node.get(key.name)?, key.name, (given.size().states, "state"), reader)
        },
        /// Inequalities of the states that hold in the part of `domain` that is the region, each as the difference that
        /// is not positive there.
        inside: Vec<Expression> as &INSIDE => |key, given, reader| {
            maps::inequalities(given.node, key.name, MapNames::new(given.plant, 0).states(), reader)
        },
        /// Range of each input, m finite pairs; empty for a plant without inputs.
        inputs: Vec<(f64, f64)> as &INPUTS => |key, given, reader| match given.node.get(key.name) {
            Some(inputs) => finite_bounds(inputs, key.name, (given.size().inputs, "input"), reader),
            None => Some(Vec::new()),
        },
        /// Values of each input for which there is a table, up to 33; between them T is interpolated (default 5).
        nodes: usize as Count(2) = 5,
        /// Cutoff frequency of the Bessel filter z (default: the slowest of six that is accurate on a coarse table).
        cutoff: Option<f64> as Number(Positive),
        /// Width of the layer around the region in which the plant is slowed down, for plants that are unbounded
        /// backward in time (default: one half-width if a trajectory escapes, else none).
        escape: Option<f64> as Number(Positive),
        /// Grid points of the table per axis (default: 33 to 97, three states 17 to 33, more states 9 to 17, until the
        /// table is accurate).
        points: Option<usize> as Count(5),
        /// Largest rank of the table for five or six states, up to 32; the table is a tensor train (default 24).
        rank: usize as Count(1) = 24,
        /// Largest number of leaves of the tree of polynomials (default 32).
        leaves: usize as Count(1) = 32,
        /// Degree of the polynomials (default 4, five or six states 3).
        degree: usize as Count(1) = if size.states > MOST_STATES_OF_A_FULL_TABLE { 3 } else { 4 },
        /// Number of samples of the fit (default 8000).
        samples: usize as Count(100) = 8000,
        /// Left inverse to simulate (default interpolated).
        form: Form as Choice = Form::Interpolated,
    }
}

const INSIDE: Key = optional(
    "inside",
    Type::Texts,
    "Inequalities of the states, as in [\"x1^2 + x2^2 <= 4\"], that all hold in the part of `domain` for which the observer is made (default: all of it).",
);

const INPUTS: Key = optional(
    "inputs",
    Type::Bounds,
    "Range of each input, m finite pairs [lower, upper]: the inputs are held at constant values of it (required for a plant with inputs).",
);

/// The form of the left inverse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// A table.
    Interpolated,
    /// A tree of polynomials.
    Embedded,
}

crate::words! { Form {
    /// Interpolation in the table: accurate.
    Interpolated = "interpolated",
    /// Tree of polynomials: small enough for a microcontroller.
    Embedded = "embedded",
} }

impl KklSpec {
    /// With keys that have an effect, and numbers that a table may have.
    fn checked(self, given: &Given<'_>, reader: &mut Reader) -> Option<Self> {
        let (node, n) = (given.node, given.size().states);
        if self.inputs.is_empty()
            && let Some(nodes) = node.entry("nodes")
        {
            let message = "`nodes` without `inputs`";
            return reader.refuse(nodes.span.clone(), message, "expected `inputs`, the range of each input");
        }
        if n <= MOST_STATES_OF_A_FULL_TABLE
            && let Some(rank) = node.entry("rank")
        {
            let message = format!("`rank` for a plant with {}", counted(n, "state"));
            let expected = format!("up to {MOST_STATES_OF_A_FULL_TABLE} states the table has all points of the grid");
            return reader.refuse(rank.span.clone(), message, expected);
        }
        for (key, count, most) in [("nodes", self.nodes, MOST_NODES), ("rank", self.rank, MOST_RANK)] {
            if count > most {
                let span = node.get(key)?.span.clone();
                return reader.refuse(span, format!("`{key}` is {count}"), format!("expected at most {most}"));
            }
        }
        Some(self)
    }
}

impl KklSpec {
    /// Grid points per axis of all tables that the design may compute for a plant with so many states, those of the
    /// search included.
    pub fn tables(&self, states: usize) -> Vec<usize> {
        let mut tables = searched_tables(self.cutoff, self.points, states);
        let last = tables.iter().copied().max().or(self.points);
        tables.extend(last.into_iter().flat_map(|points| core::iter::repeat_n(points, self.family())));
        tables
    }

    /// Trajectories backward in time that a table with so many points per axis takes.
    pub fn trajectories(&self, states: usize, points: usize) -> f64 {
        if states > MOST_STATES_OF_A_FULL_TABLE {
            low_rank_trajectories(states, points, self.rank)
        } else {
            (points as f64).powf(states as f64)
        }
    }

    /// Whether the small form is simulated.
    pub fn is_embedded(&self) -> bool {
        self.form == Form::Embedded
    }

    /// Values of the inputs for which there are tables; one without inputs.
    pub fn family(&self) -> usize {
        self.nodes.pow(self.inputs.len() as u32)
    }
}

/// Number of values of T that a design needs besides its table: validation points, and pairs tested for
/// indistinguishability.
const BESIDES: f64 = 2000.0;

/// Seconds for one value of T by simulation: a trajectory over the memory of the filter with tolerance 1e-11.
const ONE_T: f64 = 2e-3;

impl Specification for KklSpec {
    declared!();

    fn free_keys(&self) -> &'static [&'static str] {
        &["cutoff"]
    }

    fn region_of_design(&self) -> Option<luenberger_design::Region> {
        Some(luenberger_design::Region::new(&self.domain).inputs(&self.inputs))
    }

    fn inequalities(&self) -> &[Expression] {
        &self.inside
    }

    fn outside_region(&self) -> &'static str {
        "Fit not valid outside the design region"
    }

    fn faster(&self, factor: f64, _dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self { cutoff: self.cutoff.map(|cutoff| cutoff * factor), ..self.clone() }.into())
    }

    fn seconds(&self, study: &Study) -> f64 {
        let states = study.plant.states.len();
        let of_table = |points| self.trajectories(states, points) + BESIDES;
        let tables = self.tables(states).into_iter().map(of_table);
        tables.sum::<f64>() * ONE_T + self.samples as f64 * 1e-5
    }

    // The table of the inverse, its derivatives, and a copy.
    fn memory(&self, study: &Study) -> (f64, &'static str) {
        let states = study.plant.states.len();
        let points = self.tables(states).into_iter().max().unwrap_or(0);
        let table = self.family() as f64 * self.trajectories(states, points);
        let numbers = 3.0 * (states + 1) as f64;
        (table * numbers * NUMBER, "the table of a numerical KKL observer (reduce its points)")
    }
}

impl Kind for KklSpec {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        tabulated(plan.study, plan.requested, self)?;
        designed(&plan.study.plant.model, self, plan.cancel)
    }

    fn advice(&self, plan: &Plan<'_>, cause: &Cause) -> Option<Advice> {
        let Cause::NumericalKkl(error) = cause else { return None };
        let is_held = !plan.study.plant.inputs.is_empty();
        // What fails at one input has the remedies of what fails without.
        let failing = match error {
            NumericalKklError::HeldInput { error, .. } => error.as_ref(),
            error => error,
        };
        let remedy = match failing {
            NumericalKklError::Unresolved { .. } if is_held => Some(
                "increase `points`, `nodes` or `cutoff`, or choose a smaller `domain` or smaller ranges of `inputs`",
            ),
            NumericalKklError::Unresolved { .. } if plan.study.plant.states.len() > MOST_STATES_OF_A_FULL_TABLE => {
                Some("increase `points`, `rank` or `cutoff`, or choose a smaller `domain`")
            }
            NumericalKklError::Unresolved { .. } => Some("increase `points` or `cutoff`, or choose a smaller `domain`"),
            NumericalKklError::SmallDomain { .. } => Some("a `domain` closer around the states of `inside`"),
            NumericalKklError::NoneFits { .. } => Some("a smaller `domain`, or `cutoff` and `points` of your choice"),
            NumericalKklError::GridTooLarge { .. } if is_held => Some("fewer `points` or `nodes`"),
            NumericalKklError::GridTooLarge { .. } => Some("fewer `points`"),
            NumericalKklError::Escapes { .. } => {
                Some("give `escape`, the margin around `domain` outside of which the plant is slowed down")
            }
            NumericalKklError::NotInjective { .. } => Some(
                "increase `cutoff`, or choose a `domain`, or a part of it by `inside`, on which the output distinguishes all states",
            ),
            _ => None,
        };
        let remedy = remedy.map_or_else(Advice::default, Advice::hint);
        Some(other_kinds(plan.study, plan.requested).and(remedy))
    }
}

/// With more states the table is of low rank.
const MOST_STATES_OF_A_FULL_TABLE: usize = 4;

/// The observer, for two to six states.
#[derive(Debug, Clone)]
pub enum Kkl {
    /// Two states, the accurate form.
    Two(Box<NumericalKklObserver<Interpolated<2, 3>, f64, 2, 0, 1, 3>>),
    /// Two states, the form for a microcontroller.
    TwoEmbedded(Box<NumericalKklObserver<Embedded<2, 3>, f64, 2, 0, 1, 3>>),
    /// Three states, the accurate form.
    Three(Box<NumericalKklObserver<Interpolated<3, 4>, f64, 3, 0, 1, 4>>),
    /// Three states, the form for a microcontroller.
    ThreeEmbedded(Box<NumericalKklObserver<Embedded<3, 4>, f64, 3, 0, 1, 4>>),
    /// Four states, the accurate form.
    Four(Box<NumericalKklObserver<Interpolated<4, 5>, f64, 4, 0, 1, 5>>),
    /// Four states, the tree of polynomials.
    FourEmbedded(Box<NumericalKklObserver<Embedded<4, 5>, f64, 4, 0, 1, 5>>),
    /// Five states, the accurate form, with a table of low rank.
    Five(Box<NumericalKklObserver<Interpolated<5, 6, Train<5, 6>>, f64, 5, 0, 1, 6>>),
    /// Five states, the tree of polynomials.
    FiveEmbedded(Box<NumericalKklObserver<Embedded<5, 6>, f64, 5, 0, 1, 6>>),
    /// Six states, the accurate form, with a table of low rank.
    Six(Box<NumericalKklObserver<Interpolated<6, 7, Train<6, 7>>, f64, 6, 0, 1, 7>>),
    /// Six states, the tree of polynomials.
    SixEmbedded(Box<NumericalKklObserver<Embedded<6, 7>, f64, 6, 0, 1, 7>>),
    /// Two states and one held input, in both forms.
    TwoHeld(Box<HeldInputs<2, 1, 1, 3, 4>>),
    /// Two states and two held inputs.
    TwoHeldTwo(Box<HeldInputs<2, 2, 1, 3, 5>>),
    /// Three states and one held input.
    ThreeHeld(Box<HeldInputs<3, 1, 1, 4, 5>>),
    /// Three states and two held inputs.
    ThreeHeldTwo(Box<HeldInputs<3, 2, 1, 4, 6>>),
}

impl Kkl {
    /// As one that is simulated, whatever its size.
    fn any(&self) -> Arc<dyn AnyObserver + '_> {
        match self {
            Self::Two(observer) => continuous(observer.as_ref()),
            Self::TwoEmbedded(observer) => continuous(observer.as_ref()),
            Self::Three(observer) => continuous(observer.as_ref()),
            Self::ThreeEmbedded(observer) => continuous(observer.as_ref()),
            Self::Four(observer) => continuous(observer.as_ref()),
            Self::FourEmbedded(observer) => continuous(observer.as_ref()),
            Self::Five(observer) => continuous(observer.as_ref()),
            Self::FiveEmbedded(observer) => continuous(observer.as_ref()),
            Self::Six(observer) => continuous(observer.as_ref()),
            Self::SixEmbedded(observer) => continuous(observer.as_ref()),
            Self::TwoHeld(observer) => continuous(observer.as_ref()),
            Self::TwoHeldTwo(observer) => continuous(observer.as_ref()),
            Self::ThreeHeld(observer) => continuous(observer.as_ref()),
            Self::ThreeHeldTwo(observer) => continuous(observer.as_ref()),
        }
    }
}

impl Running for Kkl {
    fn any(&self) -> Arc<dyn AnyObserver + '_> {
        self.any()
    }

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let Some(spec) = of.observer.kind.of::<KklSpec>() else {
            return Err(NoObserver::new("the observer has another kind"));
        };
        // The filter is slower than the plant has to be resolved: the poles of D are those of the cut-off.
        let fastest = of.designed.report.poles.iter().map(|[re, im]| re.hypot(*im)).fold(0.0, f64::max);
        let settings = (of.period, of.substeps.map_or_else(|| steps_for(of.period, fastest), Ok)?);
        let step = step::step((of.study, spec), self, of.plant, settings)?;
        Ok(Some(NonlinearStep::of(of.designed, ExportableObserver::Kkl(step))))
    }
}

fn tabulated(study: &Study, requested: &ObserverSpec, spec: &KklSpec) -> Result<(), NoObserver> {
    let size = study.plant.model.size();
    let kind = requested.kind.name();
    let sizes = format!(
        "the kind {kind} takes plants with one output, of 2 to {} states, or of 2 or {} states with at most \
         {MOST_INPUTS} inputs",
        MOST_STATES.0, MOST_STATES.1
    );
    let hypothesis = if let Some(row) = study.plant.model.structure().explicit_time() {
        format!(
            "the kind {kind} is for plants x' = f(x, u), y = h(x, u) without the time: {} depends on the time t",
            study.plant.row(row)
        )
    } else if !has_table(size) {
        let what = if size.outputs != 1 {
            counted(size.outputs, "output")
        } else if (2..=MOST_STATES.0).contains(&size.states) && size.inputs > 0 {
            format!("{} and {}", counted(size.states, "state"), counted(size.inputs, "input"))
        } else {
            counted(size.states, "state")
        };
        format!("{sizes}; this plant has {what}")
    } else if size.inputs > 0 && spec.inputs.is_empty() {
        format!(
            "the kind {kind} takes inputs that are held at constant values, and needs their range, `inputs`; this \
             plant has {}",
            counted(size.inputs, "input")
        )
    } else {
        return Ok(());
    };
    let mut advice = other_kinds(study, requested);
    if has_table(size) && study.plant.model.structure().explicit_time().is_none() {
        let range = vec!["[lower, upper]"; size.inputs].join(", ");
        advice = advice.and(Advice::hint(format!("inputs = [{range}], if the input is held at constant values")));
    }
    Err(NoObserver::new(hypothesis).advise(advice))
}

/// The design for a model whose sizes have been checked: 2 to 6 states, or 2 to 3 with held inputs, and one output. It
/// stops once `cancel` is true.
fn designed(model: &Model, requested: &KklSpec, cancel: &AtomicBool) -> Result<Designed, NoObserver> {
    let size = model.size();
    let plant = model.expressions()?;
    macro_rules! plain {
        ($n:literal, $z:literal, $table:ty, $accurate:ident, $embedded:ident) => {{
            let (design, report) = of_size::<$table, $n, $z>(&plant.fixed()?, requested, cancel)?;
            let (accurate, small) = (Box::new(design.interpolated), Box::new(design.embedded));
            (if requested.is_embedded() { Kkl::$embedded(small) } else { Kkl::$accurate(accurate) }, report)
        }};
    }
    let (kkl, report) = match (size.states, size.inputs) {
        (2, 0) => plain!(2, 3, Spline<2, 3>, Two, TwoEmbedded),
        (3, 0) => plain!(3, 4, Spline<3, 4>, Three, ThreeEmbedded),
        (4, 0) => plain!(4, 5, Spline<4, 5>, Four, FourEmbedded),
        (5, 0) => plain!(5, 6, Train<5, 6>, Five, FiveEmbedded),
        (_, 0) => plain!(6, 7, Train<6, 7>, Six, SixEmbedded),
        (2, 1) => {
            let (observer, report) = held_inputs::<2, 1, 3, 4>(&plant.fixed()?, requested, cancel)?;
            (Kkl::TwoHeld(observer), report)
        }
        (2, _) => {
            let (observer, report) = held_inputs::<2, 2, 3, 5>(&plant.fixed()?, requested, cancel)?;
            (Kkl::TwoHeldTwo(observer), report)
        }
        (_, 1) => {
            let (observer, report) = held_inputs::<3, 1, 4, 5>(&plant.fixed()?, requested, cancel)?;
            (Kkl::ThreeHeld(observer), report)
        }
        _ => {
            let (observer, report) = held_inputs::<3, 2, 4, 6>(&plant.fixed()?, requested, cancel)?;
            (Kkl::ThreeHeldTwo(observer), report)
        }
    };
    Ok(Designed::new(kkl.into(), report, None))
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
    let whole = Domain::new(ends(|end| end.0), ends(|end| end.1), Escape::Free)?;
    let domain = whole.inside(requested.inside.iter().cloned().map(function))?;
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
    let choice = choose_with_table::<_, W, N, M, Z>(plant, &domain, input, &wanted, &settings, progress)?;
    settings.points = [choice.points; N];
    let domain = domain.escaping(choice.escape)?;
    let target = TargetSystem::<1, Z>::bessel(choice.cutoff)?;
    Ok(Chosen { settings, wanted, choice, domain, target })
}

/// A function of the states with its gradient, NaN where it has none.
fn function<const N: usize>(g: Expression) -> Inequality<N> {
    Arc::new(move |x: &SVector<f64, N>| {
        let gradient = g.gradient(0.0, x.as_slice(), &[]);
        let entry = |i: usize| gradient.as_ref().ok().and_then(|entries| entries.get(i)).copied().unwrap_or(f64::NAN);
        (g.evaluate(0.0, x.as_slice(), &[]), SVector::from_fn(|i, _| entry(i)))
    })
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
    let form = if requested.is_embedded() { &measured.embedded } else { &measured.interpolated };
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

fn held_inputs<const N: usize, const M: usize, const Z: usize, const ZM: usize>(
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
        made.domain = made.domain.escaping(escape)?;
        made.choice.escape = escape;
        design = attempt(&made);
    }
    let HeldInputDesign { observer, report: measured } = design?;
    let Chosen { wanted, choice, target, .. } = &made;
    let form = if requested.is_embedded() { &measured.embedded } else { &measured.interpolated };
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
    Ok((Box::new(if requested.is_embedded() { observer.embedded() } else { observer }), report))
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
        stationary_deviation: None,
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
