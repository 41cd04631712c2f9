//! Certificates of random designs, one generator for each theorem.

use std::fmt::{Debug, Write};

use luenberger_design::lipschitz::{LipschitzPlant, Sector};
use luenberger_design::mean_value::ContractingCoordinates;
use luenberger_design::robust::PolytopicDesign;
use luenberger_design::{
    Certified, CubicDesign, CubicGain, DecoupledPlant, DiscreteDesign, DisturbanceBounds, ErrorBound, ErrorCoordinates,
    FeedbackDesign, IntervalDesign, IntervalRequirements, LinearDesign, LipschitzDesign, Periods, ReducedOrderDesign,
    SampledCubicDesign, SampledIntervalDesign, SuperTwistingDesign, Theorem1, UnknownInputDesign, VaryingPeriodDesign,
    at_varying_periods, cubic_lmi_design, deployed_linear,
};
use luenberger_linalg::{lqr, lyapunov, stein};
use luenberger_lmi::{Problem, he, sdpa};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{
    CertificateFile, CubicConvergence, Datum, Definiteness, DiscreteJacobianPolytope, Equation, HurwitzStability,
    Region, SchurStability, Sign, StructuredCubicConvergence, Theorem, Vertex,
};
use luenberger_proof::statement::{Deviation, Format, Formats, Operation, Step, TimeDomain};
use luenberger_proof::{Interval, Matrix};
use luenberger_random::Random;
use nalgebra::DMatrix;

use crate::solution_certificate;

/// The certificate, if there is one: not every random plant has a design.
fn written<E: Debug>(file: Result<CertificateFile, E>) -> Option<CertificateFile> {
    file.ok()
}

fn proof_matrix(m: &DMatrix<f64>) -> Matrix<f64> {
    Matrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)])
}

/// Observable by construction: chains of integrators behind the outputs, injection, and an orthogonal change of
/// coordinates.
pub(super) fn plant(random: &mut Random, largest: usize) -> Option<StateSpace> {
    let n = 1 + random.below(largest);
    let p = 1 + random.below(n.min(2));
    let chain = DMatrix::from_fn(n, n, |i, j| if j == i + p { 1.0 } else { 0.0 });
    let c = DMatrix::from_fn(p, n, |i, j| if i == j { 1.0 } else { 0.0 });
    let a = chain + random.matrix(n, p) * &c;
    let b = if random.once_in(4) { DMatrix::zeros(n, 0) } else { random.matrix(n, n) + DMatrix::identity(n, n) * 3.0 };
    if random.once_in(3) {
        return StateSpace::new(a, b, c).ok();
    }
    let q = (random.matrix(n, n) + DMatrix::identity(n, n) * 2.0).qr().q();
    StateSpace::new(&q * a * q.transpose(), b, c * q.transpose()).ok()
}

fn linear(plant: &StateSpace, random: &mut Random) -> Option<LinearDesign> {
    match random.below(4) {
        0 => LinearDesign::with_decay_rate(plant, random.between(0.1, 2.0)),
        1 => LinearDesign::lmi(plant),
        _ => {
            let first = random.between(0.3, 2.0);
            let poles: Vec<f64> = (0..plant.a.nrows()).map(|k| -first - 0.4 * k as f64).collect();
            LinearDesign::with_poles(plant, &poles)
        }
    }
    .ok()
}

pub(super) fn linear_observer(random: &mut Random) -> Option<CertificateFile> {
    let plant = plant(random, 4)?;
    written(linear(&plant, random)?.certificate_file("linear"))
}

/// `D D' + K - K' + I/10`.
fn accretive(p: usize, random: &mut Random) -> DMatrix<f64> {
    let (d, k) = (random.matrix(p, p), random.matrix(p, p));
    &d * d.transpose() + &k - k.transpose() + DMatrix::identity(p, p) * 0.1
}

fn weight(p: usize, random: &mut Random) -> DMatrix<f64> {
    match random.below(5) {
        0 => DMatrix::identity(p, p),
        // Singular: an output is ignored, and convergence may have a limited region.
        1 => DMatrix::from_fn(p, p, |i, j| if i == j && i > 0 { 1.0 } else { 0.0 }),
        _ => {
            let d = random.matrix(p, p);
            let m = &d * d.transpose();
            (&m + m.transpose()) * 0.5 + DMatrix::identity(p, p) * 0.1
        }
    }
}

fn cubic_design(random: &mut Random) -> Option<CubicDesign> {
    let plant = plant(random, 3)?;
    let p = plant.c.nrows();
    if random.once_in(4) {
        return cubic_lmi_design(&plant, &DMatrix::identity(p, p), random.between(0.1, 1.0), 1.0).ok();
    }
    let linear = linear(&plant, random)?;
    let correction = if random.once_in(2) {
        CubicGain::Gamma(random.between(0.1, 4.0))
    } else {
        CubicGain::General(accretive(p, random))
    };
    CubicDesign::new(&linear, &weight(p, random), &correction).ok()
}

fn observer_theorem(random: &mut Random) -> Option<CubicConvergence> {
    let design = cubic_design(random)?;
    design.certificate.theorems().iter().find_map(|proved| match proved.theorem() {
        Theorem::CubicConvergence(theorem) => Some(theorem.clone()),
        _ => None,
    })
}

pub(super) fn cubic_observer(random: &mut Random) -> Option<CertificateFile> {
    let mut theorem = observer_theorem(random)?;
    if random.once_in(4) {
        theorem.region = Region::Within(2.0_f64.powi(random.integer(-10, 60)));
    }
    written(CertificateFile::prove("cubic", theorem))
}

pub(super) fn structured(random: &mut Random) -> Option<CertificateFile> {
    let CubicConvergence { plant, l, theta, p, s, rate, .. } = observer_theorem(random)?;
    written(CertificateFile::prove("structured", StructuredCubicConvergence { plant, l, theta, p, s, rate }))
}

/// Integers: P of determinant 1, so that `N = -P^-1 C'S` is one of integers, and `F = P^-1(K - Q)` with a skew K.
pub(super) fn theorem1(random: &mut Random) -> Option<CertificateFile> {
    let n = 1 + random.below(3);
    let p = 1 + random.below(n.min(2));
    let integers = |random: &mut Random, rows: usize, cols: usize| {
        DMatrix::from_fn(rows, cols, |_, _| f64::from(random.integer(-2, 2)))
    };
    let full = integers(random, n, n);
    let unit = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
        std::cmp::Ordering::Equal => 1.0,
        std::cmp::Ordering::Less => full[(i, j)],
        std::cmp::Ordering::Greater => 0.0,
    });
    let lyapunov = unit.transpose() * &unit;
    let inverse = lyapunov.clone().try_inverse()?.map(f64::round);
    let k = integers(random, n, n);
    let d = integers(random, n, n);
    let q = &d * d.transpose() + DMatrix::identity(n, n);
    let f = &inverse * (&k - k.transpose() - q);
    let c = integers(random, p, n);
    let l = integers(random, n, p);
    let (d, k) = (integers(random, p, p), integers(random, p, p));
    let s = &d * d.transpose() + &k - k.transpose();
    let gain = -(&inverse * c.transpose() * s);
    let d = integers(random, p, p);
    let plant = StateSpace::new(&f + &l * &c, DMatrix::zeros(n, 0), c).ok()?;
    let examined = Theorem1::examine(&plant, &l, &gain, &(&d * d.transpose()), &lyapunov).ok()?;
    written(examined.certificate_file("theorem 1"))
}

fn sampled_design(random: &mut Random) -> Option<SampledCubicDesign> {
    let plant = plant(random, 3)?;
    let linear = linear(&plant, random)?;
    let theta = weight(plant.c.nrows(), random);
    SampledCubicDesign::new(&linear, &theta, random.between(0.1, 20.0), random.between(0.01, 0.3)).ok()
}

pub(super) fn semi_implicit(random: &mut Random) -> Option<CertificateFile> {
    let plant = plant(random, 3)?;
    let linear = linear(&plant, random)?;
    let p = plant.c.nrows();
    let correction = if random.once_in(3) {
        CubicGain::Gamma(random.between(0.1, 4.0))
    } else {
        CubicGain::General(accretive(p, random))
    };
    let design =
        SampledCubicDesign::with_cubic_gain(&linear, &weight(p, random), &correction, random.between(0.01, 0.3));
    written(design.ok()?.certificate_file("semi-implicit"))
}

pub(super) fn varying_periods(random: &mut Random) -> Option<CertificateFile> {
    let plant = plant(random, 3)?;
    let linear = linear(&plant, random)?;
    let p = plant.c.nrows();
    let h = random.between(0.02, 0.2);
    let (shortest, longest) = (h * random.between(0.8, 1.0), h * random.between(1.0, 1.2));
    let periods = Periods { shortest, longest, misses: random.below(3) };
    let correction = match random.below(3) {
        0 => {
            let sampled = SampledCubicDesign::new(&linear, &DMatrix::identity(p, p), 1.0, h).ok()?;
            let k = sampled.observer.ad().clone().try_inverse()? * sampled.observer.ld();
            let theorem = at_varying_periods(&plant, &k, &periods).ok()?;
            return written(CertificateFile::prove("linear at varying periods", theorem));
        }
        1 => CubicGain::Radial(random.between(0.1, 20.0)),
        _ => CubicGain::General(accretive(p, random)),
    };
    let design = VaryingPeriodDesign::new(&linear, &weight(p, random), &correction, h, &periods).ok()?;
    written(design.certificate_file("varying periods"))
}

pub(super) fn discrete_observer(random: &mut Random) -> Option<CertificateFile> {
    if random.once_in(3) {
        let plant = plant(random, 3)?;
        let design = DiscreteDesign::with_decay_rate(&plant, random.between(0.05, 0.5), random.between(0.1, 2.0));
        return written(design.ok()?.certificate_file("discrete, at a rate"));
    }
    written(sampled_design(random)?.linear_certificate_file("discrete"))
}

pub(super) fn sampled(random: &mut Random) -> Option<CertificateFile> {
    written(sampled_design(random)?.certificate_file("sampled"))
}

/// Disturbances of the states and noise of the outputs; one in four enters both.
fn disturbances(n: usize, p: usize, random: &mut Random) -> DisturbanceBounds {
    let q = random.below(3);
    let size = |random: &mut Random| 2.0_f64.powi(random.integer(-6, 2));
    let bounds: Vec<f64> = (0..q).map(|_| size(random)).collect();
    let noise: Vec<f64> = (0..p).map(|_| size(random)).collect();
    let mut found = DisturbanceBounds::of_states_and_outputs(&random.matrix(n, q), &bounds, &noise);
    if q > 0 && random.once_in(4) {
        found.d[(0, 0)] = random.unit();
    }
    found
}

pub(super) fn input_to_state(random: &mut Random) -> Option<CertificateFile> {
    if random.once_in(3) {
        let plant = plant(random, 3)?;
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let design = linear(&plant, random)?;
        return written(
            ErrorBound::linear(&design.observer, &disturbances(n, p, random)).ok()?.certificate_file("linear"),
        );
    }
    let design = cubic_design(random)?;
    let o = &design.observer;
    let acting = disturbances(o.a.nrows(), o.c.nrows(), random);
    if random.once_in(4) {
        // An observer of the plant in the middle: A is that of the observer, and x is among the disturbances.
        let n = o.a.nrows();
        let step = random.matrix(n, n) * 0.05;
        let mut with_state = acting.clone();
        with_state.bounds.extend(std::iter::repeat_n(1.0, n));
        let wider =
            |e: &DMatrix<f64>, last: &DMatrix<f64>| {
                DMatrix::from_fn(e.nrows(), e.ncols() + n, |i, j| {
                    if j < e.ncols() { e[(i, j)] } else { last[(i, j - e.ncols())] }
                })
            };
        with_state.d = wider(&acting.d, &DMatrix::zeros(o.c.nrows(), n));
        let vertices = [-1.0, 1.0].map(|sign| (o.a.clone(), wider(&acting.e, &(&step * sign))));
        let cubic = Some((&o.n, &o.theta, &design.p));
        let bound = ErrorBound::polytope(&vertices, (&o.l, &o.c), cubic, &with_state).ok()?;
        return written(bound.certificate_file("uncertain"));
    }
    written(ErrorBound::cubic(&design, &acting).ok()?.certificate_file("cubic"))
}

pub(super) fn discrete_input_to_state(random: &mut Random) -> Option<CertificateFile> {
    let plant = plant(random, 3)?;
    let (n, p) = (plant.a.nrows(), plant.c.nrows());
    let h = random.between(0.05, 0.5);
    let poles: Vec<f64> = (0..n).map(|k| random.between(-0.6, 0.9) + 0.01 * k as f64).collect();
    let design = DiscreteDesign::with_poles(&plant, h, &poles).ok()?;
    written(ErrorBound::discrete(&design.observer, &disturbances(n, p, random)).ok()?.certificate_file("in steps"))
}

pub(super) fn super_twisting(random: &mut Random) -> Option<CertificateFile> {
    let bound = 2.0_f64.powi(random.integer(-6, 6)) * random.between(1.0, 2.0);
    let (k1, k2) = (random.between(2.1, 4.0) * bound.sqrt(), random.between(1.1, 4.0) * bound);
    written(SuperTwistingDesign::new([k1, k2], bound).ok()??.certificate_file("super-twisting"))
}

fn coordinates(random: &mut Random) -> ErrorCoordinates {
    if random.once_in(3) { ErrorCoordinates::Plant } else { ErrorCoordinates::Modal }
}

pub(super) fn interval(random: &mut Random) -> Option<CertificateFile> {
    let plant = plant(random, 4)?;
    let (n, p) = (plant.a.nrows(), plant.c.nrows());
    let acting = disturbances(n, p, random);
    let first = vec![1.0; n];
    if random.once_in(4) {
        return written(IntervalDesign::least_width(&plant, &acting, &first).ok()?.certificate_file("least width"));
    }
    let design = linear(&plant, random)?;
    let found = IntervalDesign::new(&design.observer, &acting, coordinates(random), &first);
    written(found.ok()?.certificate_file("interval"))
}

pub(super) fn sampled_interval(random: &mut Random) -> Option<CertificateFile> {
    let plant = plant(random, 3)?;
    let (n, m, p) = (plant.a.nrows(), plant.b.ncols(), plant.c.nrows());
    let design = linear(&plant, random)?;
    let h = random.between(0.02, 0.3);
    let discrete = DiscreteDesign::sampled(&design, h).ok()?;
    let size = |random: &mut Random| 2.0_f64.powi(random.integer(-6, 2));
    let q = random.below(3);
    let w: Vec<f64> = (0..q).map(|_| size(random)).collect();
    let v: Vec<f64> = (0..p).map(|_| size(random)).collect();
    let kept = IntervalRequirements {
        initial_error: vec![1.0; n],
        estimates: (0..n).map(|_| size(random)).collect(),
        inputs: (0..m).map(|_| size(random)).collect(),
        format: if random.once_in(2) { Format::Binary32 } else { Format::Binary64 },
    };
    let e = random.matrix(n, q);
    let acting = DisturbanceBounds::of_states_and_outputs(&e, &w, &v);
    let (l, coordinates) = (discrete.l(), coordinates(random));
    let found = if random.once_in(2) {
        SampledIntervalDesign::sampled(&plant, h, l, &acting, coordinates, &kept)
    } else {
        SampledIntervalDesign::of_discrete(discrete.observer.plant(), h, l, &acting, coordinates, &kept)
    };
    written(found.ok()?.certificate_file("sampled interval"))
}

/// The unknown input acts on the derivatives of some outputs: E = C'(CC')^-1 R with a regular R, so that C E = R.
pub(super) fn unknown_input(random: &mut Random) -> Option<CertificateFile> {
    let plant = plant(random, 4)?;
    let p = plant.c.nrows();
    let q = 1 + random.below(p);
    let root = random.matrix(p, q) + DMatrix::identity(p, q) * 2.0;
    let gram = (&plant.c * plant.c.transpose()).try_inverse()?;
    let e = plant.c.transpose() * gram * root;
    let decoupled = DecoupledPlant::new(&plant, &e).ok()?;
    let design = LinearDesign::lmi(&decoupled.reduced).ok()?;
    if random.once_in(2) {
        return written(UnknownInputDesign::linear(&decoupled, &design).ok()?.certificate_file("linear"));
    }
    let gain = CubicGain::General(accretive(p, random));
    let cubic = CubicDesign::new(&design, &weight(p, random), &gain).ok()?;
    written(UnknownInputDesign::cubic(&decoupled, &cubic).ok()?.certificate_file("cubic"))
}

/// One unknown input, in both times; in the outputs of one with two outputs at least, or in none.
pub(super) fn decoupling(random: &mut Random) -> Option<CertificateFile> {
    let time = if random.once_in(2) { TimeDomain::Discrete } else { TimeDomain::Continuous };
    let plant = plant(random, 4)?;
    let (n, p) = (plant.a.nrows(), plant.c.nrows());
    let e = random.matrix(n, 1);
    let f = if time == TimeDomain::Discrete && random.once_in(2) { DMatrix::zeros(p, 1) } else { random.matrix(p, 1) };
    let decoupled = DecoupledPlant::of_outputs(&plant, &e, &f, time).ok()?;
    let (w, v) = (DMatrix::identity(n, n), DMatrix::identity(p, p));
    let design = match time {
        TimeDomain::Continuous => {
            let linear = LinearDesign::kalman(&decoupled.reduced, &w, &v).ok()?;
            UnknownInputDesign::linear(&decoupled, &linear).ok()?
        }
        TimeDomain::Discrete => {
            let linear = DiscreteDesign::kalman(&decoupled.reduced, 1.0, &w, &v).ok()?;
            UnknownInputDesign::discrete(&decoupled, &linear).ok()?
        }
    };
    written(design.certificate_file("decoupling"))
}

pub(super) fn reduced_order(random: &mut Random) -> Option<CertificateFile> {
    let plant = plant(random, 4)?;
    let (n, p) = (plant.a.nrows(), plant.c.nrows());
    let first = random.between(0.3, 2.0);
    let poles: Vec<f64> = (0..n.checked_sub(p)?).map(|k| -first - 0.4 * k as f64).collect();
    written(ReducedOrderDesign::with_poles(&plant, &poles).ok()?.certificate_file("reduced order"))
}

pub(super) fn deployed(random: &mut Random) -> Option<CertificateFile> {
    let design = sampled_design(random)?;
    let o = &design.observer;
    let plant = StateSpace::new(o.ad().clone(), o.bd().clone(), o.c().clone()).ok()?;
    let (n, p) = (plant.a.nrows(), plant.c.nrows());
    let size = 2.0_f64.powi(random.integer(-3, 3));
    let bounded = |random: &mut Random, rows: usize, columns: usize| {
        Matrix::from_fn(rows, columns, |_, _| if random.once_in(2) { 0.0 } else { random.between(0.0, 1e-3) })
    };
    let deviation =
        random.once_in(2).then(|| Deviation { a: bounded(random, n, n), b: bounded(random, n, plant.b.ncols()) });
    let meets = Operation {
        deviation,
        state: (0..n).map(|_| size * random.between(0.5, 2.0)).collect(),
        input: (0..plant.b.ncols()).map(|_| random.between(0.0, 1.0)).collect(),
        noise: (0..p).map(|_| if random.once_in(2) { 0.0 } else { random.between(0.0, 1e-2) }).collect(),
        error: (0..n).map(|_| size * random.between(0.1, 2.0)).collect(),
    };
    let fixed = Format::Fixed { integer_bits: 14, fraction_bits: 30 };
    let formats: Formats = [Format::Binary32, Format::Binary32, Format::Binary64, fixed][random.below(4)].into();
    let q = |integer_bits, fraction_bits| Format::Fixed { integer_bits, fraction_bits };
    match random.below(4) {
        0 => written(design.deployed_certificate_file("deployed", formats, &meets)),
        1 => {
            let formats =
                [q(8, 24).into(), q(12, 20).into(), q(6, 10).into(), Formats { stored: q(4, 28), running: q(8, 16) }];
            let formats: Formats = formats[random.below(4)];
            let found = deployed_linear(&plant, o.ld(), Step::Accumulated, formats, &meets).ok()?;
            written(found.certificate_file("deployed"))
        }
        step => {
            let step = if step == 2 { Step::Joined } else { Step::Innovation };
            written(deployed_linear(&plant, o.ld(), step, formats, &meets).ok()?.certificate_file("deployed"))
        }
    }
}

pub(super) fn hurwitz(random: &mut Random) -> Option<CertificateFile> {
    let plant = plant(random, 4)?;
    let f = &plant.a - &linear(&plant, random)?.observer.l * &plant.c;
    let p = lyapunov(&f, &DMatrix::identity(f.nrows(), f.nrows())).ok()?.p;
    written(CertificateFile::prove("hurwitz", HurwitzStability::new(&proof_matrix(&f), &proof_matrix(&p)).ok()?))
}

pub(super) fn schur(random: &mut Random) -> Option<CertificateFile> {
    let design = sampled_design(random)?;
    let o = &design.observer;
    let f = o.ad() - o.ld() * o.c();
    let p = stein(&f, &DMatrix::identity(f.nrows(), f.nrows())).ok()?.p;
    written(CertificateFile::prove("schur", SchurStability { a: proof_matrix(&f), p: proof_matrix(&p) }))
}

pub(super) fn feedback(random: &mut Random) -> Option<CertificateFile> {
    let design = cubic_design(random)?;
    let o = &design.observer;
    let (n, m) = o.b.shape();
    let k = lqr(&o.a, &o.b, &DMatrix::identity(n, n), &DMatrix::identity(m, m)).ok()?.k;
    let file = FeedbackDesign::cubic(&design, &k).ok()?.certificate_file("feedback");
    if !random.once_in(4) {
        return written(file);
    }
    let Theorem::FeedbackLoop(mut theorem) = file.ok()?.theorem().clone() else { return None };
    theorem.observer.region = Region::Within(2.0_f64.powi(random.integer(-10, 60)));
    written(CertificateFile::prove("feedback", theorem))
}

pub(super) fn polytope(random: &mut Random) -> Option<CertificateFile> {
    let plant = plant(random, 3)?;
    let n = plant.a.nrows();
    let step = random.matrix(n, n) * random.between(0.01, 0.3);
    let vertices = [&plant.a - &step, &plant.a + &step];
    let rate = if random.once_in(2) { 0.0 } else { random.between(0.0, 0.5) };
    written(PolytopicDesign::new(&plant, &vertices, rate).ok()?.certificate_file("polytope"))
}

pub(super) fn jacobians(random: &mut Random) -> Option<CertificateFile> {
    let Theorem::PlantPolytope(theorem) = polytope(random)?.theorem().clone() else { return None };
    let luenberger_proof::certificate::PlantPolytope { vertices, l, p, rate } = theorem;
    written(CertificateFile::prove(
        "jacobians",
        luenberger_proof::certificate::JacobianPolytope { vertices, l, p, rate },
    ))
}

/// The polytope around a sampled plant, with P of the gain at its centre and a factor that this P gives the vertices.
pub(super) fn discrete_jacobians(random: &mut Random) -> Option<CertificateFile> {
    let design = sampled_design(random)?;
    let o = &design.observer;
    let (n, l) = (o.ad().nrows(), o.ld().clone());
    let f = o.ad() - &l * o.c();
    let p = stein(&f, &DMatrix::identity(n, n)).ok()?.p;
    let step = random.matrix(n, n) * random.between(0.001, 0.05);
    let root = p.clone().cholesky()?.l();
    let inverse = root.clone().try_inverse()?;
    // |root' F root'^-1| is the factor of one step in the norm of P.
    let factor = |a: &DMatrix<f64>| {
        let f = a - &l * o.c();
        (root.transpose() * f * inverse.transpose()).singular_values().max()
    };
    let pairs = [o.ad() - &step, o.ad() + &step];
    let largest = pairs.iter().map(factor).fold(0.0, f64::max);
    let factor = if random.once_in(2) { 1.0 } else { (largest * random.between(1.001, 1.2)).min(1.0) };
    let vertices = pairs.iter().map(|a| {
        let c = proof_matrix(o.c());
        if random.once_in(2) {
            return Vertex::exactly(&proof_matrix(a), &c);
        }
        let around = |x: &f64| Interval::new(x - 1e-6, x + 1e-6).unwrap_or(Interval::of(*x));
        Vertex::within(&proof_matrix(a).map(around), &c.map(|x| Interval::of(*x)))
    });
    let vertices = vertices.collect::<Result<Vec<_>, _>>().ok()?;
    let theorem = DiscreteJacobianPolytope { vertices, l: proof_matrix(&l), p: proof_matrix(&p), factor };
    written(CertificateFile::prove("jacobians in discrete time", theorem))
}

pub(super) fn sector(random: &mut Random) -> Option<CertificateFile> {
    let plant = plant(random, 3)?;
    let n = plant.a.nrows();
    let sectors = (0..=random.below(2))
        .map(|_| {
            let q = 1 + random.below(2);
            let (g, h) = (random.matrix(n, q), random.matrix(q, n));
            let size = random.between(0.05, 0.5);
            match random.below(3) {
                0 => Sector::structured(g, h, size),
                1 => Sector::structured(g, random.matrix(1, n), size),
                _ => Sector::slope(g, h, -size * random.between(0.0, 1.0), size),
            }
        })
        .collect();
    let plant = LipschitzPlant::new(plant.a.clone(), plant.c.clone(), sectors).ok()?;
    let rate = if random.once_in(2) { 0.0 } else { random.between(0.0, 0.5) };
    let design = LipschitzDesign::new(&plant, rate).ok()?;
    let mut theorem = match design.theorems().first()?.theorem() {
        Theorem::SectorConvergence(theorem) => theorem.clone(),
        _ => return None,
    };
    if random.once_in(2) {
        let around = |x: &Datum| {
            let x = x.interval();
            Interval::new(x.lo() - 1e-6, x.hi() + 1e-6).unwrap_or(x)
        };
        let Vertex { a, c } = Vertex::within(&theorem.a.map(around), &theorem.c.map(around)).ok()?;
        (theorem.a, theorem.c) = (a, c);
    }
    written(CertificateFile::prove("sector", theorem))
}

pub(super) fn contracting(random: &mut Random) -> Option<CertificateFile> {
    let n = 2 + random.below(2);
    let outputs = 1 + random.below(n - 1);
    let middle = random.matrix(n, n) - DMatrix::identity(n, n) * random.between(0.0, 1.5);
    let step = random.matrix(n, n) * random.between(0.01, 0.3);
    let rate = random.between(0.0, 0.5);
    written(
        ContractingCoordinates::new(&[&middle - &step, &middle + &step], outputs, rate)
            .ok()?
            .certificate_file("contracting"),
    )
}

pub(super) fn definiteness(random: &mut Random) -> Option<CertificateFile> {
    let n = 1 + random.below(4);
    let d = DMatrix::from_fn(n, n, |_, _| f64::from(random.integer(-3, 3)));
    let m = &d * d.transpose();
    let (m, sign) = match random.below(4) {
        0 => (&m + DMatrix::identity(n, n) * random.between(0.0, 1.0), Sign::PositiveDefinite),
        1 => (-&m - DMatrix::identity(n, n) * 2.0_f64.powi(-random.integer(0, 50)), Sign::NegativeDefinite),
        2 => (m, Sign::PositiveSemidefinite),
        _ => (-m, Sign::NegativeSemidefinite),
    };
    written(CertificateFile::prove("definite", Definiteness::new(&proof_matrix(&m), sign).ok()?))
}

pub(super) fn solution(random: &mut Random) -> Option<CertificateFile> {
    let n = 1 + random.below(3);
    let (m, q) = (random.matrix(n, n), random.matrix(n, n));
    let q = &q + q.transpose();
    match random.below(4) {
        0 => solution_certificate(Equation::Stein, &(m * 0.4), &q),
        1 => solution_certificate(Equation::Lyapunov, &m, &q),
        _ => {
            let shift = random.between(0.5, 3.0) + m.norm();
            solution_certificate(Equation::Lyapunov, &(m - DMatrix::identity(n, n) * shift), &q)
        }
    }
}

fn inequality(random: &mut Random, stable: bool) -> Option<CertificateFile> {
    let n = 1 + random.below(2);
    let a = random.matrix(n, n);
    let a = (&a - DMatrix::identity(n, n) * (a.norm() + 0.1)) * if stable { 1.0 } else { -1.0 };
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", n);
    lmi.constrain("P > 0", &p >> 0.0);
    lmi.constrain("decrease", he(&p * a) << 0.0);
    let solution = lmi.solve().ok()?;
    written(lmi.certificate_file("inequality", &solution))
}

pub(super) fn holds(random: &mut Random) -> Option<CertificateFile> {
    inequality(random, true)
}

pub(super) fn refuted(random: &mut Random) -> Option<CertificateFile> {
    inequality(random, false)
}

/// A dense block of order 2 and a diagonal one of order 2, in SDPA's format. With `Y = I` strictly feasible for (D) and
/// `F_1 = I`; or without a feasible point of (P), or of (D).
pub(super) fn program(random: &mut Random) -> Option<CertificateFile> {
    let unknowns = 1 + random.below(2);
    let kind = random.below(5);
    let mut text = String::new();
    let mut costs = Vec::new();
    for matrix in 0..=unknowns {
        let entries: [f64; 5] = std::array::from_fn(|_| f64::from(random.integer(-8, 8)) / 4.0);
        let [a, mut b, mut c, mut d, e] = entries;
        let mut a = a;
        let mut e = e;
        match (kind, matrix) {
            // tr F_i = 0 while tr F_0 > 0.
            (0, 0) => (a, e) = (a.abs() + 3.0, e.abs() + 3.0),
            (0, _) => e = -(a + c + d),
            (_, 1) => (a, b, c, d, e) = (1.0, 0.0, 1.0, 1.0, 1.0),
            _ => {}
        }
        if matrix > 0 {
            // c = tr F_i, or of the wrong sign: then x grows without bound.
            let trace = a + c + d + e;
            costs.push(
                if kind == 1 && matrix == 1 {
                    -trace
                } else if kind == 0 {
                    1.0
                } else {
                    trace
                }
                .to_string(),
            );
        }
        for (block, row, column, value) in [(1, 1, 1, a), (1, 1, 2, b), (1, 2, 2, c), (2, 1, 1, d), (2, 2, 2, e)] {
            writeln!(text, "{matrix} {block} {row} {column} {value}").ok()?;
        }
    }
    let text = format!("{unknowns}\n2\n2 -2\n{}\n{text}", costs.join(" "));
    let program = sdpa::read(text.as_bytes()).ok()?;
    written(sdpa::solve(&program, &sdpa::Settings::default()).certificate_file(&program, "program"))
}
