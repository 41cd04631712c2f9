//! Immersion-and-invariance observers with given maps: what is proved of the distance `d = beta(y, chi) - phi(x)`.
//!
//! Where D_chi beta has full row rank, rho = 0, h does not read the time and phi^L(phi(x), h(x)) = x, (18) makes
//! `d' = K(phi^L(phi(x) + d, y)) - K(phi^L(phi(x), y))` with
//! ```text
//!     K(x) = Dphi(x) f(x, u) - D_y beta(y, chi) Dh(x) f(x, u)
//! ```
//! so that `d' = M d` with M a mean of `d K(phi^L(z, y))/dz` over the segment from phi(x) to beta(y, chi). It lies in
//! Z, the box of phi over the region, if beta(y, chi) does. These derivatives are enclosed over Z and the region, with
//! jumps of f, h, phi, phi^L and beta compared in value. If one P proves every matrix of the enclosure to be Hurwitz, d
//! decays exponentially as long as x stays in the region and beta(y, chi) in Z: (A5). phi^L has bounded derivatives by
//! z there, and xhat tends to x.

use super::declaration::{Declaration, Tuning};
use super::keys::BOUNDED;
use super::{Kind, as_kind};
use crate::designed::{Running, StepOf};
use crate::keys::{Type, optional, required};
use crate::maps::MapNames;
use crate::maps::{ImmersionMaps, ImmersionSpec, KklMaps, left_inverse_defect};
use crate::model::{Model, PlantModel};
use crate::reader::maps::{bounded, list_of_zeros, list_without_time};
use crate::reader::tree::Node;
use crate::reader::{Given, Reader};
use crate::results::{Advice, Cause, DesignReport, DesignVerdict, FactReport, NoObserver, Statement};
use crate::steps::recorded::recorded;
use crate::study::{ObserverKind, ObserverSpec, PlantClass, Specification, Study, Time};
use crate::synthesis::kkl_maps::{candidate, is_left_inverse, measured_left_inverse, other_maps};
use crate::synthesis::{Designed, Plan, facts, number, other_kinds, proof_matrix};
use luenberger_design::enclosure::{EnclosureError, JacobianEnclosure, enclose, output_bounds};
use luenberger_design::kkl::{Attractivity, KklReport, KklSettings, attractivity};
use luenberger_design::{Certificate, IntervalDual, KklError, Names, Region};
use luenberger_export::extension::RecordedObserver;
use luenberger_expression::{Expression, ExpressionPlant};
use luenberger_expression::{ParameterError, Recording, Scope, Terms, Variable};
use luenberger_observers::{Immersion, ImmersionInvarianceObserver, KklMap};
use luenberger_plants::{Differentiable, Dimensions, Plant, Shape};
use luenberger_proof::certificate::{Reading, Represented};
use luenberger_proof::wording::counted;
use luenberger_proof::wording::{at_least, at_most, significant};
use luenberger_proof::{Interval, Matrix, Ring, Verdict};
use nalgebra::{DMatrix, DVector};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "immersion-invariance",
    about: "Immersion-and-invariance observer: chi makes beta(y, chi) follow phi(x), xhat = phi^L(beta(y, chi), y).",
    source: "Yi, Ortega and Zhang 2018, eq. (18) and (19), Proposition 4",
    plant: PlantClass::Nonlinear(Time::OF_STATE),
    keys: &[&[
        required("beta", Type::Expressions, "beta(y, chi), one expression of chi1, .. and the outputs for each z."),
        required("phi", Type::Expressions, "phi(x), one expression of the states for each z."),
        required(
            "left_inverse",
            Type::Expressions,
            "phi^L(z, y), one expression of z1, .. and the outputs for each state of the plant.",
        ),
        BOUNDED,
        optional("order", Type::Count(1), "Number of states chi (default: that of the rows of `beta`)."),
        optional(
            "start",
            Type::Expressions,
            "chi for an estimate, expressions of the states and the outputs (default: phi(x) - beta(y, 0), for beta = chi + a function of y).",
        ),
        optional(
            "q",
            Type::Expressions,
            "Q(y, chi, u): how chi moves in the directions that beta does not see (default 0).",
        ),
        optional("rho", Type::Expressions, "rho(y, chi, u): how beta moves beside phi(xhat) (default 0)."),
    ]],
    kind: as_kind::<ImmersionSpec>,
    read,
    takes_long: false,
    tuning: Tuning::MAPS_BY_HAND,
};

/// beta, phi, phi^L of an immersion-and-invariance observer.
fn read(given: &Given<'_>, reader: &mut Reader) -> Option<ObserverKind> {
    let (node, plant) = (given.node, given.plant);
    let region = bounded(node, plant, reader);
    let rows = node.get("phi")?.list()?.len();
    let order = node.get("order").map_or(Some(rows), Node::count)?;
    let names = MapNames::new(plant, rows);
    let of_phi = format!("`phi` has {}", counted(rows, "row"));
    let of_states = format!("the plant has {}", counted(plant.states.len(), "state"));
    let of_order = format!("the observer has {} chi", counted(order, "state"));
    let phi = list_without_time(node, "phi", (rows, &of_phi), names.states(), reader);
    let beta = list_without_time(node, "beta", (rows, &of_phi), names.manifold(order), reader);
    let left_inverse =
        list_without_time(node, "left_inverse", (plant.states.len(), &of_states), names.off_manifold(), reader);
    let mut optional = |key: &str, length: (usize, &str), scope| {
        node.given(key, |_| list_without_time(node, key, length, scope, reader))
    };
    let start = optional("start", (order, &of_order), names.image());
    let freedom = optional("q", (order, &of_order), names.freedom(order));
    let rho = optional("rho", (rows, &of_phi), names.freedom(order));
    let (phi, beta, left_inverse, start) = (phi?, beta?, left_inverse?, start?);
    let as_plant = |rows: &[Expression], scope: Result<Scope, ParameterError>, states: usize| {
        let texts: Vec<&str> = rows.iter().map(Expression::text).collect();
        ExpressionPlant::within(&vec!["0"; states], &texts, &scope.ok()?).ok()
    };
    let beta = as_plant(&beta, names.manifold(order), order + plant.outputs.len())?;
    let size = plant.model.size();
    if start.is_none() && !is_shifted_identity(&beta, order) {
        let message = "`beta` is not chi plus a function of the outputs, and `start` is not given";
        let expected = "expected `start`: chi for an estimate, as expressions of states and outputs";
        return reader.refuse(node.get("beta")?.span.clone(), message, expected);
    }
    let image = KklMaps {
        plant: size,
        lambda: list_of_zeros(rows * rows)?,
        injection: list_of_zeros(rows)?,
        left_inverse,
        phi: phi.clone(),
    };
    let maps = ImmersionMaps {
        plant: size,
        order,
        beta,
        phi: as_plant(&phi, names.states(), plant.states.len())?,
        image,
        start,
        freedom: freedom?,
        rho: rho?,
    };
    Some(ImmersionSpec { maps, region: region? }.into())
}

/// Whether beta is chi plus a function of the outputs.
fn is_shifted_identity(beta: &ExpressionPlant, order: usize) -> bool {
    let is_one = |i: usize, j: usize, terms: &Terms| {
        terms.multiple_of(Variable::State(j)) == Some(if i == j { 1.0 } else { 0.0 })
    };
    let rows: Vec<Terms> = beta.h().iter().map(Expression::terms).collect();
    rows.len() == order && rows.iter().enumerate().all(|(i, row)| (0..order).all(|j| is_one(i, j, row)))
}

impl Specification for ImmersionSpec {
    declared!();

    fn region_of_design(&self) -> Option<Region> {
        Some(self.region.clone())
    }
}

impl Kind for ImmersionSpec {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        output_without_time(plan.study, plan.requested)?;
        immersion(plan.study, self)
    }

    fn advice(&self, plan: &Plan<'_>, cause: &Cause) -> Option<Advice> {
        other_maps(plan.study, cause)
    }
}

impl Running for ImmersionInvarianceObserver<Model, ImmersionMaps> {
    runs!(continuous);

    fn record(&self, of: &StepOf<'_>, recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        let Some(spec) = of.observer.kind.of::<ImmersionSpec>() else {
            return Err(NoObserver::new("the observer has another kind"));
        };
        recorded(recording, &ImmersionInvarianceObserver::new(of.plant.clone(), spec.maps.clone()))
    }
}

/// Observers whose theory takes the derivative of the output along f alone.
fn output_without_time(study: &Study, requested: &ObserverSpec) -> Result<(), NoObserver> {
    let Some(k) = study.plant.model.structure().timed_output() else { return Ok(()) };
    let (kind, output) = (requested.kind.name(), &study.plant.outputs[k]);
    let hypothesis =
        format!("the kind {kind} is for outputs y = h(x) without the time: {output} depends on the time t");
    Err(NoObserver::new(hypothesis).advise(other_kinds(study, requested)))
}

/// The observer, if phi^L takes phi(x) back, (phi, h) is not shown to lack injectivity, and D_chi beta has full row
/// rank at the samples.
fn immersion(study: &Study, spec: &ImmersionSpec) -> Result<Designed, NoObserver> {
    let model = &study.plant.model;
    let ImmersionSpec { maps, region } = spec;
    let settings = KklSettings::default();
    // The checks of phi and phi^L alone: the equation of phi is not asked.
    let report = candidate(model, &maps.image)?.check(region, &settings)?;
    match (&report.injectivity.verdict, &report.injectivity.near_collision) {
        (Verdict::Refuted { witness }, _) => return Err(KklError::NotInjective(witness.clone()).into()),
        (Verdict::Undecided { .. }, Some(pair)) => return Err(KklError::Indistinct(pair.clone()).into()),
        _ => {}
    }
    is_left_inverse(study, &maps.image, region, &report, settings.tolerance)?;
    let found = Findings::of(study, spec, &report)?;
    let is_proved = found.open.is_empty();
    let statement = if is_proved { found.converges(study, region) } else { found.does_not_follow() };
    let numbers = vec![
        number("smallest ratio of distances under (phi, h)", report.injectivity.smallest_ratio),
        number("smallest singular value of D(phi, h)", report.injectivity.smallest_singular_value),
        number("sampled states", report.injectivity.points as f64),
    ];
    let report = DesignReport {
        statement,
        matrices: found.p.iter().map(|p| proof_matrix("P", p)).collect(),
        poles: found.poles,
        numbers,
        facts: found.facts,
        verdict: match &found.certificate {
            Some(certificate) if is_proved => DesignVerdict::of(certificate),
            _ => DesignVerdict::MEASURED,
        },
        evidence: (!is_proved).then(|| found.open.join("; ")),
        noise_deviation: Vec::new(),
        stationary_deviation: None,
    };
    let observer = ImmersionInvarianceObserver::new(model.clone(), maps.clone());
    Ok(Designed::new(observer.into(), report, found.certificate))
}

/// What is  and what is left open.
struct Findings {
    facts: Vec<FactReport>,
    /// The hypotheses that are not proved; none where the error is proved to tend to 0.
    open: Vec<String>,
    /// Z.
    image: Vec<Interval>,
    poles: Vec<[f64; 2]>,
    p: Option<DMatrix<f64>>,
    /// That the Jacobians of the distance, which are these, are Hurwitz.
    certificate: Option<Certificate>,
    jacobian: Matrix<Interval>,
}

impl Findings {
    fn of(study: &Study, spec: &ImmersionSpec, report: &KklReport) -> Result<Self, NoObserver> {
        let model = &study.plant.model;
        let ImmersionSpec { maps, region } = spec;
        let mut found = Self {
            facts: Vec::new(),
            open: Vec::new(),
            image: Vec::new(),
            poles: Vec::new(),
            p: None,
            certificate: None,
            jacobian: Matrix::from_fn(0, 0, |_, _| Interval::zero()),
        };
        let over = Enclosed::over(study, maps, region);
        if is_exact(model, &maps.image, region) {
            found.facts.push(FactReport::of_region(
                "phi^L(phi(x), h(x)) = x",
                "verified over the region".to_owned(),
                None,
            ));
        } else {
            found.open.push(measured_left_inverse(report));
        }
        if let Verdict::Proved { margin } = report.injectivity.verdict {
            found.facts.push(FactReport::of_region(
                "(phi, h) is injective",
                "verified over the region".to_owned(),
                Some(margin),
            ));
        }
        if over.as_ref().is_ok_and(|over| over.has_pivots(maps)) {
            let words = "verified by the constant entries of D_chi beta".to_owned();
            found.facts.push(FactReport::of_region("D_chi beta has full row rank (A4)", words, None));
        } else {
            found.open.push(format!(
                "that D_chi beta has full row rank (A4) is not proved: its least singular value at the samples, with chi of the start, is {}",
                significant(least_singular_value(&study.plant, maps, region)?, 3)
            ));
        }
        let why = match over {
            _ if maps.rho.is_some() => Some("rho moves beta beside phi(xhat)".to_owned()),
            Err(why) => Some(why),
            Ok(over) => {
                found.image.clone_from(&over.image);
                match over.attractivity(study, maps, region)? {
                    Ok(attraction) => found.take(attraction),
                    Err(why) => Some(why),
                }
            }
        };
        found.open.extend(why.map(|why| format!("that the manifold attracts (A5) is not proved: {why}")));
        Ok(found)
    }

    /// The proof that the distance decays, or why it is none.
    fn take(&mut self, found: Attractivity) -> Option<String> {
        self.poles = found.eigenvalues.iter().map(|z| [z.re, z.im]).collect();
        if let Some(branches) = found.jumps {
            return Some(format!(
                "over the region it is not shown that {branches}, with f = K(phi^L(z, y)) and h = (phi^L, phi, h)"
            ));
        }
        if !found.certificate.is_proved() {
            return Some("no P was found for all Jacobians of the distance over the region".to_owned());
        }
        self.facts.splice(0..0, facts(&found.certificate, &[]));
        self.p = found.p;
        self.certificate = Some(found.certificate);
        self.jacobian = found.jacobian;
        None
    }

    /// The sentence of a proof.
    fn converges(&self, study: &Study, region: &Region) -> Statement {
        // The hypothesis is rounded to the inside.
        let entry =
            |(k, z): (usize, &Interval)| format!("beta{} in [{}, {}]", k + 1, at_most(z.lo(), 6), at_least(z.hi(), 6));
        let image: Vec<String> = self.image.iter().enumerate().map(entry).collect();
        let hypothesis = format!(
            "as long as x(t) and u(t) stay in the region ({region}) and beta(y(t), chi(t)) in the box of phi over it ({})",
            image.join(", ")
        );
        let plant = Represented::Distance { hypothesis: &hypothesis, m: &self.jacobian };
        let reading = Reading { plant, ..study.plant.reading() };
        Statement::of_proved(self.certificate.iter().flat_map(|certificate| certificate.sentences(&reading)))
    }

    /// The sentence without a proof.
    fn does_not_follow(&self) -> Statement {
        let slowest = self.poles.iter().map(|[re, _]| *re).fold(f64::NEG_INFINITY, f64::max);
        let known = if slowest > 0.0 {
            format!(
                "It is not to be expected that it attracts: the middle of the Jacobians of the distance over the region has an eigenvalue with the real part {}.",
                significant(slowest, 3)
            )
        } else {
            "Its convergence is not proved: check it by simulation.".to_owned()
        };
        Statement::of(format!(
            "The observer is made for a manifold beta(y, chi) = phi(x) that is invariant, with xhat = x on it. {known}"
        ))
    }
}

/// The ranges of the maps over the region.
struct Enclosed {
    /// phi over the region: Z.
    image: Vec<Interval>,
    /// `[D_chi beta, D_y beta]` for every chi, and y over the region.
    beta: Matrix<Interval>,
}

impl Enclosed {
    /// Why there are none, as a clause: among others, where beta jumps.
    fn over(study: &Study, maps: &ImmersionMaps, region: &Region) -> Result<Self, String> {
        let words = |error: EnclosureError| error.to_string();
        let image = output_bounds(&maps.phi, &Region::new(region.states())).map_err(words)?;
        let outputs = output_bounds(&study.plant.model, region).map_err(words)?;
        let chi = (1..=maps.order).map(|k| format!("chi{k}"));
        let names = Names { states: chi.chain(study.plant.outputs.iter().cloned()).collect(), ..Names::default() };
        let everything = [(f64::NEG_INFINITY, f64::INFINITY)];
        let arguments: Vec<(f64, f64)> =
            everything.repeat(maps.order).into_iter().chain(outputs.iter().map(ends)).collect();
        let found = names.with(|| {
            let found = enclose(&maps.beta, &Region::new(&arguments)).map_err(words)?;
            match &found.branches {
                Some(branches) if branches.jump > 0.0 => Err(format!("it is not shown that {branches}, with h = beta")),
                _ => Ok(found),
            }
        });
        found.map(|JacobianEnclosure { c: beta, .. }| Self { image, beta })
    }

    /// Whether each row of D_chi beta has an entry that is a constant other than 0 and the only one of its column, for
    /// all chi, and y over the region.
    fn has_pivots(&self, maps: &ImmersionMaps) -> bool {
        let is_pivot = |i: usize, j: usize| {
            let own = &self.beta[(i, j)];
            own.is_point() && !own.is_zero() && (0..maps.rows()).all(|k| k == i || self.beta[(k, j)].is_zero())
        };
        (0..maps.rows()).all(|i| (0..maps.order).any(|j| is_pivot(i, j)))
    }

    /// What is proved of the distance over Z and the region, or why nothing is.
    fn attractivity(
        &self,
        study: &Study,
        maps: &ImmersionMaps,
        region: &Region,
    ) -> Result<Result<Attractivity, String>, NoObserver> {
        let plant = match study.plant.model.expressions() {
            Ok(plant) => plant,
            Err(error) => return Ok(Err(error.to_string())),
        };
        if plant.h().iter().any(Expression::uses_time) {
            return Ok(Err("the observer has no term for the derivative of h by the time".to_owned()));
        }
        let size = maps.plant;
        // Of the inputs of the distance, D_y beta comes last, row by row.
        let by_output = (0..maps.rows()).flat_map(|i| (0..size.outputs).map(move |j| (i, j)));
        let unbounded = vec![(f64::NEG_INFINITY, f64::INFINITY); size.inputs];
        let inputs = region.input_bounds().unwrap_or(&unbounded).iter().copied();
        let inputs: Vec<(f64, f64)> = region
            .states()
            .iter()
            .copied()
            .chain(inputs)
            .chain(by_output.clone().map(|(i, j)| ends(&self.beta[(i, maps.order + j)])))
            .collect();
        let states: Vec<(f64, f64)> = self.image.iter().map(ends).collect();
        let (from, to) = region.time_bounds();
        let whole = Region::new(&states).inputs(&inputs).time(from, to);
        let of_beta = by_output.map(|(i, j)| format!("dbeta{}/d{}", i + 1, study.plant.outputs[j]));
        let names = Names {
            states: (1..=maps.rows()).map(|k| format!("z{k}")).collect(),
            inputs: study.plant.states.iter().chain(&study.plant.inputs).cloned().chain(of_beta).collect(),
            outputs: study.plant.states.iter().map(|state| format!("phi^L of {state}")).collect(),
        };
        match attractivity(&Distance { plant, maps }, &whole) {
            Ok(found) => Ok(Ok(found)),
            Err(KklError::Enclosure(why)) => {
                let why = names.with(|| why.to_string());
                Ok(Err(format!("with f = K(phi^L(z, y)) and h = (phi^L, phi, h), over the region: {why}")))
            }
            Err(error) => Err(error.into()),
        }
    }
}

fn ends(range: &Interval) -> (f64, f64) {
    (range.lo(), range.hi())
}

/// `z' = K(phi^L(z, y))` with the inputs x, u and D_y beta, and the outputs phi^L(z, y), phi(x) and h(x), which have to
/// be continuous.
struct Distance<'a> {
    plant: ExpressionPlant,
    maps: &'a ImmersionMaps,
}

type Column = DVector<IntervalDual>;

impl Distance<'_> {
    /// x, u and D_y beta.
    fn parts(&self, inputs: &Column) -> (Column, Column, DMatrix<IntervalDual>) {
        let Dimensions { states, inputs: count, outputs } = self.maps.plant;
        let part = |from: usize, length: usize| inputs.rows(from, length).into_owned();
        let rest = part(states + count, self.maps.rows() * outputs);
        (part(0, states), part(states, count), DMatrix::from_row_slice(self.maps.rows(), outputs, rest.as_slice()))
    }
}

impl Shape for Distance<'_> {
    fn dimensions(&self) -> Dimensions {
        let Dimensions { states, inputs, outputs } = self.maps.plant;
        let rows = self.maps.rows();
        Dimensions { states: rows, inputs: states + inputs + rows * outputs, outputs: states + rows + outputs }
    }
}

impl Plant<IntervalDual> for Distance<'_> {
    type State = Column;
    type Input = Column;
    type Output = Column;

    fn derivative(&self, t: IntervalDual, z: &Column, inputs: &Column) -> Column {
        let (x, u, by_output) = self.parts(inputs);
        let y: Column = self.plant.output(t, &x, &u);
        let estimate = Immersion::<IntervalDual>::left_inverse(self.maps, z, &y);
        let f: Column = self.plant.derivative(t, &estimate, &u);
        let measured = self.plant.output_jacobian(t, &estimate, &u) * &f;
        self.maps.phi_jacobian(&estimate) * f - by_output * measured
    }

    fn output(&self, t: IntervalDual, z: &Column, inputs: &Column) -> Column {
        let (x, u, _) = self.parts(inputs);
        let y: Column = self.plant.output(t, &x, &u);
        let estimate = Immersion::<IntervalDual>::left_inverse(self.maps, z, &y);
        let image = Immersion::<IntervalDual>::phi(self.maps, &x);
        let all = estimate.iter().chain(image.iter()).chain(y.iter()).copied();
        Column::from_iterator(estimate.len() + image.len() + y.len(), all)
    }
}

/// Whether phi^L(phi(x), h(x)) = x over the region: in exact arithmetic, or by its Jacobian and one value.
fn is_exact(model: &Model, image: &KklMaps, region: &Region) -> bool {
    if left_inverse_defect(model, image, region).is_ok_and(|bounds| bounds.iter().all(|bound| *bound == 0.0)) {
        return true;
    }
    let recovered = Recovered { model, image };
    let n = image.plant.states;
    let Ok(found) = enclose(&recovered, region) else { return false };
    let corner: Vec<(f64, f64)> = region.states().iter().map(|(low, _)| (*low, *low)).collect();
    let (from, to) = region.time_bounds();
    let at_corner = Region::new(&corner).time(from, to);
    let at_corner = region.input_bounds().map_or(at_corner.clone(), |inputs| at_corner.inputs(inputs));
    let Ok(values) = output_bounds(&recovered, &at_corner) else { return false };
    let is = |found: &Interval, x: f64| found.is_point() && found.lo() == x;
    found.branches.is_none_or(|branches| branches.jump == 0.0)
        && (0..n).all(|i| (0..n).all(|j| is(&found.c[(i, j)], if i == j { 1.0 } else { 0.0 })))
        && values.iter().zip(&corner).all(|(found, (x, _))| is(found, *x))
}

/// phi^L(phi(x), h(x)) as the outputs of a plant.
struct Recovered<'a> {
    model: &'a Model,
    image: &'a KklMaps,
}

impl Shape for Recovered<'_> {
    fn dimensions(&self) -> Dimensions {
        Dimensions { outputs: self.image.plant.states, ..self.image.plant }
    }
}

impl Plant<IntervalDual> for Recovered<'_> {
    type State = Column;
    type Input = Column;
    type Output = Column;

    fn derivative(&self, _t: IntervalDual, x: &Column, _u: &Column) -> Column {
        x.clone()
    }

    fn output(&self, t: IntervalDual, x: &Column, u: &Column) -> Column {
        let y: Column = self.model.output(t, x, u);
        self.image.left_inverse(t, &self.image.image(t, x, &y), &y)
    }
}

/// The least singular value of D_chi beta at the corners of the region; an error where it loses rank.
fn least_singular_value(plant: &PlantModel, maps: &ImmersionMaps, region: &Region) -> Result<f64, NoObserver> {
    let (mut least, mut largest, mut point) = (f64::INFINITY, 0.0_f64, Vec::new());
    for x in corners(region) {
        let y = plant.model.output(0.0, &x, &DVector::zeros(maps.plant.inputs));
        let chi = Immersion::<f64>::start(maps, &x, &y);
        let values = maps.beta_jacobian(&chi, &y).columns(0, maps.order).into_owned().singular_values();
        // With fewer columns than rows there is no full row rank.
        let smallest = if maps.order < maps.rows() { 0.0 } else { values.min() };
        largest = largest.max(values.max());
        // Not a number is less than every number.
        if smallest.is_nan() || smallest < least {
            (least, point) = (smallest, x.as_slice().to_vec());
        }
    }
    if least > f64::EPSILON.sqrt() * largest {
        Ok(least)
    } else {
        let hypothesis = format!(
            "D_chi beta does not have the rank {} (A4): its least singular value is {} at {}, with chi of the start",
            maps.rows(),
            significant(least, 3),
            plant.at_state(&point)
        );
        Err(NoObserver::new(hypothesis)
            .because(Cause::Rank { needed: maps.rows(), smallest: least, point })
            .hint("a `beta` whose Jacobian by chi has full row rank, such as chi plus a function of y"))
    }
}

/// The corners and the centre of a bounded region of states.
fn corners(region: &Region) -> Vec<DVector<f64>> {
    /// Corners of at most so many coordinates; the others are in the middle.
    const CORNERED: usize = 6;
    let states = region.states();
    let count = states.len().min(CORNERED);
    let middle = |k: usize| f64::midpoint(states[k].0, states[k].1);
    let mut all = vec![DVector::from_fn(states.len(), |k, _| middle(k))];
    for corner in 0..1usize << count {
        let end = |k: usize| if corner >> k & 1 == 1 { states[k].1 } else { states[k].0 };
        all.push(DVector::from_fn(states.len(), |k, _| if k < count { end(k) } else { middle(k) }));
    }
    all
}
