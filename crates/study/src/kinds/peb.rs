//! PEBO and [KKL+PEB] observers with given maps: the checks of the maps and of the regression over the region, and the
//! excitation along the run of the study.
//!
//! That `d s(y)/dt = g + m theta` wherever `phi(x) = xi + missing(theta)` is an equation in x, u and theta. It is
//! checked as (4) is: (s, phi) is the phi of a plant whose inputs are (u, theta), and (g + m theta, B) its B, evaluated
//! at `xi = phi(x) - missing(theta)`.

use super::{Kind, kkl_peb, pebo};
use crate::designed::{Running, StepOf};
use crate::maps::{Estimator, PebSpec, RegressionMaps, ResetSpec};
use crate::model::Model;
use crate::reader::{Given, Reader, maps};
use crate::results::{Advice, Cause, DesignReport, DesignVerdict, FactReport, NoObserver, Statement};
use crate::signal::Input;
use crate::steps::recorded::recorded;
use crate::study::{ObserverKind, ObserverSpec, PlantClass, Specification, Study};
use crate::synthesis::kkl_maps::{self, candidate, is_left_inverse, other_maps, undecided_injectivity};
use crate::synthesis::{Designed, Plan, number, proof_matrix, upper_bound};
use crate::trajectory::{self, Member};
use luenberger_design::kkl::{KklSettings, Residual, ResidualWitness};
use luenberger_design::kkl_peb::{Excitation, Excite, excitation};
use luenberger_design::{KklCandidate, KklError, Region};
use luenberger_export::extension::RecordedObserver;
use luenberger_expression::{Recorded, Recording};
use luenberger_observers::SampledJumps;
use luenberger_observers::kkl::KklMap;
use luenberger_observers::{FilterMemory, KklPebObserver, ObserverDimensions, ObserverError, Regression, Reset};
use luenberger_plants::{Dimensions, Plant, Shape};
use luenberger_proof::Verdict;
use luenberger_proof::wording::{at_most, counted, significant};
use nalgebra::{DMatrix, DVector, Dyn, RealField, convert};

/// A PEBO or [KKL+PEB] observer, ready to run.
pub type PebObserver = KklPebObserver<RegressionMaps, Estimator, f64>;

/// The observer with these maps, regression and estimator.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterEstimation {
    /// Its maps, regression and estimator.
    pub spec: PebSpec,
    /// Whether Lambda is given, which is 0 otherwise: the kind `kkl-peb`.
    pub is_kkl: bool,
}

pub(super) fn read(given: &Given<'_>, is_kkl: bool, reader: &mut Reader) -> Option<ObserverKind> {
    Some(ParameterEstimation { spec: maps::peb(given.node, given.plant, reader)?, is_kkl }.into())
}

impl Specification for ParameterEstimation {
    fn name(&self) -> &'static str {
        if self.is_kkl { kkl_peb::DECLARATION.name } else { pebo::DECLARATION.name }
    }

    fn plant(&self) -> PlantClass {
        pebo::DECLARATION.plant
    }

    fn region_of_design(&self) -> Option<Region> {
        Some(self.spec.region.clone())
    }
}

impl Kind for ParameterEstimation {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        designed(plan.study, plan.requested, &self.spec)
    }

    fn advice(&self, plan: &Plan<'_>, cause: &Cause) -> Option<Advice> {
        other_maps(plan.study, cause)
    }
}

/// The specification of an observer of one of the two kinds.
fn spec(kind: &ObserverKind) -> Option<&PebSpec> {
    Some(&kind.of::<ParameterEstimation>()?.spec)
}

impl Running for PebObserver {
    runs!(continuous);

    fn record(&self, of: &StepOf<'_>, recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        let spec = spec(&of.observer.kind).ok_or_else(|| NoObserver::new("the observer has another kind"))?;
        let observer = observer::<Recorded>(spec)?;
        match spec.reset {
            Some(ResetSpec { period: reset, .. }) => {
                let samples = samples_between(reset, of.period)?;
                recorded(recording, &SampledJumps::<_, Dyn>::new(observer, samples))
            }
            None => recorded(recording, &observer),
        }
    }

    // A regressor is filtered from zero; what it tends to at the start counts.
    fn settled(&self, of: &StepOf<'_>, mut z: DVector<f64>, u: &DVector<f64>, y: &DVector<f64>) -> DVector<f64> {
        if let Some(spec) = spec(&of.observer.kind) {
            let order = spec.maps.kkl.order();
            let m = spec.maps.regressor(0.0, &z.rows(0, order).into_owned(), u, y);
            z.rows_mut(order + 2 * m.nrows(), m.len()).copy_from_slice(m.as_slice());
        }
        z
    }
}

/// The samples from one reset to the next.
fn samples_between(reset: f64, period: f64) -> Result<usize, NoObserver> {
    let count = (reset / period).round();
    if count >= 1.0 && (count * period - reset).abs() <= 1e-9 * reset {
        Ok(count as usize)
    } else {
        let hypothesis =
            format!("the period of its resets, {reset}, is not a multiple of the sampling period {period}");
        Err(NoObserver::new(hypothesis))
    }
}

/// The observer, if (4) is proved over the region, the regression is not refuted there, the rest of Lambda is Hurwitz,
/// phi^L takes phi(x) back, and the run of the study, if there is one, excites the regression.
fn designed(study: &Study, requested: &ObserverSpec, spec: &PebSpec) -> Result<Designed, NoObserver> {
    let (model, maps) = (&study.plant.model, &spec.maps);
    let settings = KklSettings::default();
    let report = candidate(model, &maps.kkl)?.check(&spec.region, &settings)?;
    required(&report.residual, settings.tolerance, |residual, row, bound, allowed| match &residual.verdict {
        Verdict::Refuted { witness } => KklError::NotASolution(witness.clone()).into(),
        _ => KklError::ResidualUndecided { row, bound, allowed }.into(),
    })?;
    if !report.stability.is_proved() {
        let eigenvalue = report.stability.eigenvalues.first().copied().unwrap_or_default();
        return Err(KklError::NotHurwitz { what: "the part of Lambda without rows of zeros", eigenvalue }.into());
    }
    match (&report.injectivity.verdict, &report.injectivity.near_collision) {
        (Verdict::Refuted { witness }, _) => return Err(KklError::NotInjective(witness.clone()).into()),
        (Verdict::Undecided { .. }, Some(pair)) => return Err(KklError::Indistinct(pair.clone()).into()),
        _ => {}
    }
    is_left_inverse(study, &maps.kkl, &spec.region, &report, settings.tolerance)?;
    let regression = regression(model, spec, &settings)?;
    let observer = observer(spec)?;
    let mut facts = kkl_maps::all_facts(&report, &report.stability.certificate);
    if maps.open.len() == maps.kkl.order() {
        // Nothing decays.
        facts.retain(|fact| fact.statement != kkl_maps::DECAY);
    }
    let mut numbers = kkl_maps::numbers(&report);
    let mut evidence: Vec<String> = Vec::new();
    let equation = "d s(y)/dt = g + m theta where phi(x) = xi + missing(theta)";
    if regression.verdict.is_proved() && regression.continuous {
        let bounds = &regression.bounds[..maps.signal.len()];
        let rows: Vec<String> = bounds.iter().map(|bound| at_most(*bound, 3)).collect();
        let words = format!("verified over the region; residual by rows at most {}", rows.join(", "));
        facts.push(FactReport::of_region(equation, words, None));
        let largest = bounds.iter().copied().fold(0.0, f64::max);
        numbers.push(upper_bound("bound of the residual of d s(y)/dt = g + m theta", largest));
    } else {
        evidence.push(format!(
            "that {equation} is not proved: {} have it to {} of its terms",
            counted(regression.points, "sampled point"),
            significant(settings.tolerance, 2)
        ));
    }
    let certificate = (maps.open.len() < maps.kkl.order()).then(|| report.stability.certificate.clone());
    let mut designed = Designed::new(
        observer.into(),
        DesignReport {
            statement: statement(spec),
            matrices: report.stability.p.iter().map(|p| proof_matrix("P", p)).collect(),
            poles: report.stability.eigenvalues.iter().map(|z| [z.re, z.im]).collect(),
            numbers,
            facts,
            verdict: DesignVerdict::MEASURED,
            evidence: None,
            noise_deviation: Vec::new(),
            stationary_deviation: None,
        },
        certificate,
    );
    if !report.injectivity.verdict.is_proved() {
        evidence.push(undecided_injectivity(&report));
    }
    match excited(study, requested, spec, &designed)? {
        Some(found) => {
            let words = format!(
                "along the run of [simulation], int M'M >= {} I over every window of length {}, the least after t = {}; the convergence of the estimator is not proved for other runs",
                significant(found.delta, 3),
                significant(found.window, 4),
                significant(found.from, 4)
            );
            evidence.push(words);
            designed.report.numbers.push(number("excitation delta along the run", found.delta));
            designed.report.numbers.push(number("window of the excitation", found.window));
        }
        None => evidence.push("the excitation of the regression is not checked: it needs a run".to_owned()),
    }
    designed.report.evidence = Some(evidence.join("; "));
    Ok(designed)
}

/// The observer with the numbers of a study, over any scalar.
fn observer<T: RealField + Copy>(
    spec: &PebSpec,
) -> Result<KklPebObserver<RegressionMaps, Estimator<T>, T>, ObserverError> {
    let maps = &spec.maps;
    let observer = KklPebObserver::new(maps.clone(), spec.estimator.cast()?, convert(spec.alpha))?;
    let observer = observer.starting_at(convert(spec.start))?;
    match spec.reset {
        Some(ResetSpec { period, above }) => {
            let (period, above) = (convert(period), above.map(convert));
            observer.resetting(Reset { period, above, memory: maps.memory() })
        }
        None => Ok(observer),
    }
}

fn statement(spec: &PebSpec) -> Statement {
    let region = &spec.region;
    let rest = match spec.maps.open.len() {
        count if count == spec.maps.kkl.order() => {
            "phi(x) - xi is a constant, and the regression for it is exact".to_owned()
        }
        _ => "the error of the KKL part of xi decays exponentially, and the regression for what the other rows miss is exact once it has".to_owned(),
    };
    let leakage = if spec.maps.leakage > 0.0 {
        "With leakage this constant moves, and the estimation error does not tend to 0."
    } else {
        ""
    };
    Statement::of(format!(
        "The observer is made for this: as long as x(t) and u(t) stay in the region ({region}), {rest}, and the {} converges as far as the run excites the regression.",
        spec.estimator.words()
    ))
    .remark(leakage)
    .remark(reset(spec))
}

/// What resets do to the estimate.
fn reset(spec: &PebSpec) -> &'static str {
    match (&spec.reset, spec.maps.memory()) {
        (None, _) => "",
        (Some(_), FilterMemory::Transformed) => {
            "A reset moves theta_hat into xi and the filters with it: the estimates are those without resets."
        }
        (Some(_), FilterMemory::Restarted) => {
            "A reset moves theta_hat into xi: the estimate is continuous, and the filters begin again, so that the excitation since the last reset is lost."
        }
    }
}

/// `error` of the row that exceeds its bound most, unless the residual is proved small.
fn required(
    residual: &Residual,
    tolerance: f64,
    error: impl Fn(&Residual, usize, f64, f64) -> NoObserver,
) -> Result<(), NoObserver> {
    if residual.verdict.is_proved() {
        return Ok(());
    }
    let allowed = |row: usize| tolerance * residual.scales[row];
    let excess = |row: &usize| residual.bounds[*row] - allowed(*row);
    let row = (0..residual.bounds.len()).max_by(|i, j| excess(i).total_cmp(&excess(j))).unwrap_or(0);
    Err(error(residual, row, residual.bounds[row], allowed(row)))
}

/// The residual of the regression; an error with the worst point where it is refuted.
///
/// An equation that is neither proved nor refuted is accepted: the sampled points have it to the tolerance.
fn regression(model: &Model, spec: &PebSpec, settings: &KklSettings) -> Result<Residual, NoObserver> {
    let maps = &spec.maps;
    let plant = WithParameters { model, parameters: maps.parameters };
    let map = Joined { maps };
    let all: Vec<usize> = (0..maps.kkl.plant.states).collect();
    let mut inputs = spec.region.input_bounds().map(<[_]>::to_vec).unwrap_or_default();
    inputs.extend(&spec.theta);
    let (from, to) = spec.region.time_bounds();
    let region = Region::new(spec.region.states()).inputs(&inputs).time(from, to);
    let residual = KklCandidate::new(&plant, &map, &all)?.residual(&region, settings)?;
    match &residual.verdict {
        Verdict::Refuted { witness } => {
            let ResidualWitness { row, at_least, place, .. } = witness;
            let (u, theta) = place.input.split_at(maps.kkl.plant.inputs);
            let input = if u.is_empty() { String::new() } else { format!(", u = {u:?}") };
            let hypothesis = format!(
                "row {} of `s`, `g` and `m` is no regression: d s(y)/dt and g + m theta differ by at least {} at x = {:?}{input}, theta = {theta:?}, with xi = phi(x) - missing(theta)",
                row + 1,
                significant(*at_least, 4),
                place.state
            );
            Err(NoObserver::new(hypothesis)
                .because(Cause::NotRegression(witness.clone()))
                .hint("other `s`, `g`, `m` or `missing`: the two sides differ at the point named"))
        }
        _ => Ok(residual),
    }
}

/// The excitation along the run of the study; none without a run of the plant alone with this observer.
fn excited(
    study: &Study,
    requested: &ObserverSpec,
    spec: &PebSpec,
    designed: &Designed,
) -> Result<Option<Excitation>, NoObserver> {
    let Some(simulation) = &study.simulation else { return Ok(None) };
    if matches!(&study.input, Input::Feedback { observer, .. } if *observer != requested.name) {
        return Ok(None);
    }
    let mut quiet = simulation.clone();
    quiet.noise = None;
    quiet.sensors.clear();
    let samples = simulation.samples.max(LEAST_SAMPLES);
    let time = |k: usize| simulation.duration * k as f64 / (samples - 1) as f64;
    let times: Vec<f64> = (0..samples).map(time).collect();
    let members = [Member { requested, designed }];
    let Some(run) = trajectory::of_observer_at(study, &quiet, &members, &members[0], &times) else { return Ok(None) };
    let Ok(observer) = run.observer(&requested.name) else { return Ok(None) };
    let Some(runnable) = designed.runnable.of::<PebObserver>() else { return Ok(None) };
    let regressors: Vec<DMatrix<f64>> = (0..run.t.len().min(observer.state.nrows()))
        .map(|k| runnable.parts(&observer.state.row(k).transpose()).regressor)
        .collect();
    let window = spec.window.unwrap_or(simulation.duration).min(simulation.duration);
    match excitation(&run.t[..regressors.len()], &regressors, &Excite::within(window * (1.0 - f64::EPSILON))) {
        Ok(found) => Ok(Some(found)),
        Err(KklError::NotExciting { delta, window, from, direction, .. }) => {
            let unseen: Vec<String> = direction.iter().map(|x| significant(*x, 3)).collect();
            let hypothesis = format!(
                "the regression is not exciting along the run of [simulation]: over the {} after t = {} the least eigenvalue of int M'M is {}, and the direction ({}) of theta is not seen",
                significant(window, 4),
                significant(from, 4),
                significant(delta, 3),
                unseen.join(", ")
            );
            Err(NoObserver::new(hypothesis)
                .because(Cause::NotExciting { delta, window, from, direction })
                .hint("an input or an initial state that excites the regressor m, or a longer `window`")
                .hint("the kind kkl: a Lambda that is stable, where there is one, needs no excitation"))
        }
        Err(error) => Err(error.into()),
    }
}

/// Rows of the run in which the excitation is measured, at least.
const LEAST_SAMPLES: usize = 1001;

/// The plant with theta as further inputs, which it does not read.
struct WithParameters<'a> {
    model: &'a Model,
    parameters: usize,
}

impl Shape for WithParameters<'_> {
    fn dimensions(&self) -> Dimensions {
        let size = self.model.size();
        Dimensions { inputs: size.inputs + self.parameters, ..size }
    }
}

impl WithParameters<'_> {
    fn input<T: RealField + Copy>(&self, u: &DVector<T>) -> DVector<T> {
        u.rows(0, self.model.size().inputs).into_owned()
    }
}

impl<T: RealField + Copy> Plant<T> for WithParameters<'_> {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;

    fn derivative(&self, t: T, x: &DVector<T>, u: &DVector<T>) -> DVector<T> {
        self.model.derivative(t, x, &self.input(u))
    }

    fn output(&self, t: T, x: &DVector<T>, u: &DVector<T>) -> DVector<T> {
        self.model.output(t, x, &self.input(u))
    }
}

/// (s, phi) with Lambda of phi alone, and `B = (g + m theta, B)` at `xi = phi - missing(theta)`.
struct Joined<'a> {
    maps: &'a RegressionMaps,
}

impl Joined<'_> {
    fn rows(&self) -> usize {
        self.maps.signal.len()
    }

    /// phi of (s, phi).
    fn phi<T: RealField + Copy>(&self, image: &DVector<T>) -> DVector<T> {
        image.rows(self.rows(), self.maps.kkl.order()).into_owned()
    }
}

fn stacked<T: RealField + Copy>(first: &DVector<T>, second: &DVector<T>) -> DVector<T> {
    DVector::from_iterator(first.len() + second.len(), first.iter().chain(second.iter()).copied())
}

impl<T: RealField + Copy> KklMap<T> for Joined<'_> {
    type Xi = Dyn;
    type Inputs = Dyn;
    type Outputs = Dyn;
    type Estimate = Dyn;

    fn dimensions(&self) -> ObserverDimensions {
        let size = KklMap::<T>::dimensions(&self.maps.kkl);
        ObserverDimensions { state: size.state + self.rows(), inputs: size.inputs + self.maps.parameters, ..size }
    }

    fn lambda(&self, t: T, u: &DVector<T>, y: &DVector<T>) -> DMatrix<T> {
        let (rows, order) = (self.rows(), self.maps.kkl.order());
        let inner = self.maps.kkl.lambda(t, &u.rows(0, self.maps.kkl.plant.inputs).into_owned(), y);
        let entry = |i: usize, j: usize| if i < rows || j < rows { T::zero() } else { inner[(i - rows, j - rows)] };
        DMatrix::from_fn(rows + order, rows + order, entry)
    }

    fn injection(&self, t: T, image: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        let (inputs, maps) = (self.maps.kkl.plant.inputs, self.maps);
        let theta = u.rows(inputs, maps.parameters).into_owned();
        let u = u.rows(0, inputs).into_owned();
        let phi = self.phi(image);
        let xi = &phi - maps.missing(&theta);
        let rate = maps.known(t, &xi, &u, y) + maps.regressor(t, &xi, &u, y) * theta;
        stacked(&rate, &maps.kkl.injection(t, &phi, &u, y))
    }

    fn left_inverse(&self, t: T, image: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.maps.kkl.left_inverse(t, &self.phi(image), y)
    }

    fn image(&self, t: T, xhat: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        stacked(&self.maps.signal(t, y), &self.maps.kkl.image(t, xhat, y))
    }
}
