//! Attempts to contradict a certificate of input-to-state stability: V' at errors of many sizes under the disturbances
//! that raise V most, in exact arithmetic, and simulations under bang-bang disturbances.
//!
//! P~ is computed here from its definition, with rational numbers.

use luenberger_random::Random;
use nalgebra::{DMatrix, DVector};
use serde_json::Value;

use super::adversary::{Found, ensure, margin_of};
use super::document::{binary64, float_matrix, floats, is_single, matrix};
use super::exact::Exact;

fn diagonal(value: &Value) -> Exact {
    let entries = floats(value);
    let n = entries.len();
    let all: Vec<f64> = (0..n * n).map(|k| if k / n == k % n { entries[k / n] } else { 0.0 }).collect();
    Exact::from_f64(n, n, &all)
}

/// `P~ = C'XC + (I - T)(P - C'XC)(I - T)` with the orthogonal projector T on the range of N.
pub(super) fn structured(p: &Exact, c: &Exact, x: &Exact, gain: &Exact) -> Result<Exact, String> {
    let gram = gain.transposed().times(gain);
    let image = gram.solve(&gain.transposed()).ok_or("N has dependent columns")?;
    let rest = Exact::identity(p.rows).minus(&gain.times(&image));
    let seen = c.congruent(x);
    Ok(seen.plus(&rest.times(&p.minus(&seen)).times(&rest)))
}

/// The parts of a document, with A, E and D drawn where they are intervals.
struct Disturbed {
    f: Exact,
    g: Exact,
    c: Exact,
    d: Exact,
    p: Exact,
    gain: Option<(Exact, Exact)>,
}

impl Disturbed {
    fn of(document: &Value, vertex: &Value, random: &mut Random) -> Result<Self, String> {
        let (plant, term) = (&document["plant"], &document["cubic"]);
        let (c, d) = (matrix(&plant["C"], random), matrix(&plant["D"], random));
        let l = matrix(&document["observer"]["L"], random);
        let p = matrix(&document["lyapunov"]["P"], random);
        let (a, e) = (matrix(&vertex["A"], random), matrix(&vertex["E"], random));
        let (mut metric, mut gain) = (p.clone(), None);
        if !term.is_null() {
            let n = matrix(&term["N"], random);
            metric = structured(&p, &c, &matrix(&term["X"], random), &n)?;
            gain = Some((n, matrix(&term["theta"], random)));
        }
        Ok(Self { f: a.minus(&l.times(&c)), g: e.minus(&l.times(&d)), c, d, p: metric, gain })
    }

    /// `e' = F e + G w + (r'theta r) N r`.
    fn slope(&self, e: &Exact, w: &Exact) -> Exact {
        let linear = self.f.times(e).plus(&self.g.times(w));
        let Some((n, theta)) = &self.gain else { return linear };
        let r = self.c.times(e).plus(&self.d.times(w));
        linear.plus(&n.times(&r).scaled(&r.congruent(theta)))
    }

    /// `2 rate level - 2 rate V - V'`, which the theorem makes 0 or more.
    fn room(&self, e: &Exact, w: &Exact, rate: &Exact, level: &Exact) -> Exact {
        let fall = e.transposed().times(&self.p).times(&self.slope(e, w));
        let v = e.congruent(&self.p);
        let half = rate.times(&level.minus(&v)).minus(&fall);
        half.plus(&half)
    }
}

pub(super) fn contradicted(document: &Value, random: &mut Random) -> Found {
    let vertices = document["plant"]["vertices"].as_array().ok_or("no vertices")?;
    let (rate, level) = (binary64(&document["lyapunov"]["rate"]), binary64(&document["bounds"]["level"]));
    ensure(rate > 0.0 && level > 0.0 && !vertices.is_empty(), || "false: rate, level > 0".to_owned())?;
    let (exact_rate, exact_level) = (Exact::number(rate), Exact::number(level));
    let bounds = floats(&document["bounds"]["w"]);
    for (k, vertex) in vertices.iter().enumerate() {
        let single = is_single(&vertex["A"]) && is_single(&vertex["E"]) && is_single(&document["plant"]["D"]);
        for draw in 0..if single { 1 } else { 6 } {
            let system = Disturbed::of(document, vertex, random)?;
            ensure(system.p.is_positive(), || "false: P > 0".to_owned())?;
            if k == 0 && draw == 0 {
                facts(document, &system, vertices.len(), random)?;
            }
            decrease(document, &system, k, &exact_rate)?;
            for (e, w) in attacks(document, vertex, &bounds, level, random) {
                let e = Exact::from_f64(e.len(), 1, &e);
                let w = Exact::from_f64(w.len(), 1, &w);
                let room = system.room(&e, &w, &exact_rate, &exact_level);
                ensure(room.sign() >= 0, || "false: V' <= 2 rate (level - V)".to_owned())?;
            }
        }
    }
    if random.once_in(24) { simulated(document, random) } else { Ok(()) }
}

/// The block inequality of a vertex, with its margin.
fn decrease(document: &Value, system: &Disturbed, vertex: usize, rate: &Exact) -> Found {
    let p = &system.p;
    let first = p.times(&system.f).he().plus(&p.scaled(&rate.plus(rate)));
    let corner = p.times(&system.g);
    let last = diagonal(&document["lyapunov"]["lambda"]).negative();
    let block = Exact::blocks(&[vec![first, corner.clone()], vec![corner.transposed(), last]]).negative();
    ensure(block.is_positive(), || "false: the linear inequality".to_owned())?;
    margin_of(document, 1 + vertex, &block)
}

/// The facts that no vertex has part in, with their margins, and the bounds of the components.
fn facts(document: &Value, system: &Disturbed, vertices: usize, random: &mut Random) -> Found {
    margin_of(document, 0, &system.p)?;
    let (level, rate) = (&document["bounds"]["level"], &document["lyapunov"]["rate"]);
    let (level, rate) = (Exact::number(binary64(level)), Exact::number(binary64(rate)));
    let squares = |weights: &Value| {
        let w = floats(&document["bounds"]["w"]);
        Exact::from_f64(w.len(), 1, &w).congruent(&diagonal(weights))
    };
    let mut spent = squares(&document["lyapunov"]["lambda"]).scaled(&Exact::number(128.0));
    let mut next = 1 + vertices;
    let term = &document["cubic"];
    if let Some((n, theta)) = &system.gain {
        let s = matrix(&term["X"], random).times(&system.c).times(n).negative();
        let kappa = Exact::number(binary64(&term["kappa"]));
        ensure(kappa.sign() >= 0, || "false: kappa >= 0".to_owned())?;
        let corner = system.d.transposed().times(&s).scaled(&Exact::number(2.0));
        let first = diagonal(&term["mu"]).scaled(&Exact::number(2.0));
        let noise = Exact::blocks(&[vec![first, corner.clone()], vec![corner.transposed(), s.he()]]);
        for m in [theta.clone(), s.he().scaled(&kappa).minus(&theta.scaled(&Exact::number(2.0))), noise] {
            ensure(m.is_semidefinite(), || format!("false: {}", document["margins"][next]["inequality"]))?;
            margin_of(document, next, &m)?;
            next += 1;
        }
        let square = squares(&term["mu"]);
        spent = spent.plus(&square.times(&square).times(&kappa).scaled(&Exact::number(27.0)));
    }
    let room = rate.times(&level).scaled(&Exact::number(256.0)).minus(&spent);
    ensure(room.sign() >= 0, || "false: the level".to_owned())?;
    margin_of(document, next, &room)?;
    components(document, system, next + 1, &level)
}

/// `b^2 >= level (P^-1)_kk`, the facts from this place on.
fn components(document: &Value, system: &Disturbed, first: usize, level: &Exact) -> Found {
    let n = system.p.rows;
    let inverse = system.p.solve(&Exact::identity(n)).ok_or("P is singular")?;
    for (k, bound) in floats(&document["bounds"]["limsup"]).into_iter().enumerate() {
        let square = Exact::number(bound).times(&Exact::number(bound));
        let room = square.minus(&level.times(&inverse.at(k, k)));
        ensure(room.sign() >= 0 && bound > 0.0, || format!("false: the bound of e{}", k + 1))?;
        let unit: Vec<f64> = (0..n * n).map(|at| if at == k * n + k { 1.0 } else { 0.0 }).collect();
        let form = system.p.scaled(&square).minus(&Exact::from_f64(n, n, &unit).scaled(level));
        margin_of(document, first + k, &form)?;
    }
    Ok(())
}

/// The system in floating point.
struct Floats {
    f: DMatrix<f64>,
    g: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    p: DMatrix<f64>,
    cubic: Option<(DMatrix<f64>, DMatrix<f64>)>,
    bounds: Vec<f64>,
}

impl Floats {
    fn of(document: &Value, vertex: &Value) -> Option<Self> {
        let (plant, term) = (&document["plant"], &document["cubic"]);
        if ![&vertex["A"], &vertex["E"], &plant["D"]].into_iter().all(is_single) {
            return None;
        }
        let (c, d) = (float_matrix(&plant["C"]), float_matrix(&plant["D"]));
        let l = float_matrix(&document["observer"]["L"]);
        let cubic = (!term.is_null()).then(|| (float_matrix(&term["N"]), float_matrix(&term["theta"])));
        // V is that of P~, whatever P is.
        let mut p = float_matrix(&document["lyapunov"]["P"]);
        if let Some((n, _)) = &cubic {
            let rest = DMatrix::identity(p.nrows(), p.nrows()) - n * (n.transpose() * n).try_inverse()? * n.transpose();
            let seen = c.transpose() * float_matrix(&term["X"]) * &c;
            p = &seen + &rest * (p - &seen) * &rest;
        }
        Some(Self {
            f: float_matrix(&vertex["A"]) - &l * &c,
            g: float_matrix(&vertex["E"]) - &l * &d,
            c,
            d,
            p,
            cubic,
            bounds: floats(&document["bounds"]["w"]),
        })
    }

    fn slope(&self, e: &DVector<f64>, w: &DVector<f64>) -> DVector<f64> {
        let linear = &self.f * e + &self.g * w;
        let Some((n, theta)) = &self.cubic else { return linear };
        let r = &self.c * e + &self.d * w;
        linear + n * &r * r.dot(&(theta * &r))
    }

    /// Candidates for the disturbance that raises V most: bang-bang on the sign of G'Pe, all of its signs changed one
    /// by one, and the noise -Ce/4 at which the bound of the cubic part is attained.
    fn worst(&self, e: &DVector<f64>) -> DVector<f64> {
        let m = self.bounds.len();
        let pull = self.g.transpose() * (&self.p * e);
        let bang = DVector::from_fn(m, |i, _| self.bounds[i].copysign(pull[i]));
        let seen = self.d.transpose() * (&self.c * e) * -0.25;
        let quarter = DVector::from_fn(m, |i, _| seen[i].clamp(-self.bounds[i], self.bounds[i]));
        let mut tried = vec![bang.clone(), quarter.clone(), -&bang];
        for i in 0..m {
            for (base, value) in [(&bang, -bang[i]), (&quarter, bang[i]), (&bang, quarter[i])] {
                let mut other = base.clone();
                other[i] = value;
                tried.push(other);
            }
        }
        let gain = |w: &DVector<f64>| e.dot(&(&self.p * self.slope(e, w)));
        tried.into_iter().max_by(|a, b| gain(a).total_cmp(&gain(b))).unwrap_or(bang)
    }
}

/// Errors about as large as the level allows, and far smaller and larger ones, with disturbances within the bounds.
fn attacks(
    document: &Value,
    vertex: &Value,
    bounds: &[f64],
    level: f64,
    random: &mut Random,
) -> Vec<(Vec<f64>, Vec<f64>)> {
    let Some(system) = Floats::of(document, vertex) else { return Vec::new() };
    let n = system.p.nrows();
    let mut found = Vec::new();
    for _ in 0..6 {
        let direction = DVector::from_vec(random.vector(n));
        let v = direction.dot(&(&system.p * &direction));
        if !(v > 0.0 && v.is_finite()) {
            continue;
        }
        for share in [1e-6, 0.01, 0.25, 1.0, 4.0, 1e6] {
            let e = &direction * (share * level / v).sqrt();
            let w = system.worst(&e);
            let within = w.iter().zip(bounds).all(|(w, bound)| w.abs() <= *bound);
            if within && e.iter().chain(w.iter()).all(|x| x.is_finite()) {
                found.push((e.iter().copied().collect(), w.iter().copied().collect()));
            }
        }
    }
    found
}

/// Runge and Kutta's fourth order under the worst disturbance of every step, from errors inside and outside the level.
fn simulated(document: &Value, random: &mut Random) -> Found {
    let Some(vertices) = document["plant"]["vertices"].as_array() else { return Ok(()) };
    let systems: Option<Vec<Floats>> = vertices.iter().map(|vertex| Floats::of(document, vertex)).collect();
    let Some(systems) = systems else { return Ok(()) };
    let (rate, level) = (binary64(&document["lyapunov"]["rate"]), binary64(&document["bounds"]["level"]));
    let limsup = floats(&document["bounds"]["limsup"]);
    let first = &systems[0];
    let energy = |e: &DVector<f64>| e.dot(&(&first.p * e));
    for share in [0.01, 1.0, 100.0] {
        let direction = DVector::from_vec(random.vector(first.p.nrows()));
        let mut e = &direction * (share * level / energy(&direction)).sqrt();
        let start = energy(&e);
        let mut time = 0.0;
        for _ in 0..3000 {
            let system = &systems[random.below(systems.len())];
            let r = &system.c * &e;
            let stiff = system.cubic.as_ref().map_or(0.0, |(n, theta)| {
                let size = r.norm() + (&system.d * DVector::from_column_slice(&system.bounds)).norm();
                3.0 * theta.norm() * size * size * n.norm() * system.c.norm()
            });
            let h = 0.1 / (system.f.norm() + stiff);
            let w = system.worst(&e);
            let k1 = system.slope(&e, &w);
            let k2 = system.slope(&(&e + &k1 * (h / 2.0)), &w);
            let k3 = system.slope(&(&e + &k2 * (h / 2.0)), &w);
            let k4 = system.slope(&(&e + &k3 * h), &w);
            e += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0);
            time += h;
            let (v, allowed) = (energy(&e), (-2.0 * rate * time).exp() * start + level);
            if !v.is_finite() || !h.is_normal() {
                return Ok(());
            }
            // The steps themselves have errors.
            ensure(v <= 1.001 * allowed, || format!("V = {v:e} at {time:e}, where {allowed:e} is the bound"))?;
            if (-2.0 * rate * time).exp() * start < 1e-4 * level {
                for (k, bound) in limsup.iter().enumerate() {
                    ensure(e[k].abs() <= 1.001 * bound, || format!("|e{}| = {:e} beyond {bound:e}", k + 1, e[k]))?;
                }
            }
        }
    }
    Ok(())
}

/// Attempts in discrete time: one step from errors of many sizes under the disturbances that raise V most, exactly, and
/// runs of thousands of steps.
pub(super) fn in_steps(document: &Value, random: &mut Random) -> Found {
    let vertices = document["plant"]["vertices"].as_array().ok_or("no vertices")?;
    let (factor, level) = (binary64(&document["lyapunov"]["factor"]), binary64(&document["bounds"]["level"]));
    ensure(factor > 0.0 && factor < 1.0 && level > 0.0 && !vertices.is_empty(), || {
        "false: factor, level > 0, factor < 1".to_owned()
    })?;
    let (factor, exact_level) = (Exact::number(factor), Exact::number(level));
    let square = factor.times(&factor);
    let bounds = floats(&document["bounds"]["w"]);
    for (k, vertex) in vertices.iter().enumerate() {
        let single = is_single(&vertex["A"]) && is_single(&vertex["E"]) && is_single(&document["plant"]["D"]);
        for draw in 0..if single { 1 } else { 6 } {
            let system = Disturbed::of(document, vertex, random)?;
            ensure(system.p.is_positive(), || "false: P > 0".to_owned())?;
            if k == 0 && draw == 0 {
                facts_in_steps(document, &system, vertices.len(), (&square, &exact_level))?;
            }
            let (flow, driven) = (system.p.times(&system.f), system.p.times(&system.g));
            let zero = Exact::zeros(flow.rows, bounds.len());
            let block = Exact::blocks(&[
                vec![system.p.scaled(&square), zero.clone(), flow.transposed()],
                vec![zero.transposed(), diagonal(&document["lyapunov"]["lambda"]), driven.transposed()],
                vec![flow, driven, system.p.clone()],
            ]);
            ensure(block.is_positive(), || "false: the linear inequality".to_owned())?;
            margin_of(document, 1 + k, &block)?;
            for (e, w) in attacks(document, vertex, &bounds, level, random) {
                let e = Exact::from_f64(e.len(), 1, &e);
                let w = Exact::from_f64(w.len(), 1, &w);
                let next = system.f.times(&e).plus(&system.g.times(&w));
                let above = |e: &Exact| e.congruent(&system.p).minus(&exact_level);
                let room = above(&e).times(&square).minus(&above(&next));
                ensure(room.sign() >= 0, || "false: V+ - level <= factor^2 (V - level)".to_owned())?;
            }
        }
    }
    if random.once_in(24) { stepped(document, random) } else { Ok(()) }
}

/// The facts that no vertex has part in.
fn facts_in_steps(document: &Value, system: &Disturbed, vertices: usize, (square, level): (&Exact, &Exact)) -> Found {
    margin_of(document, 0, &system.p)?;
    let w = floats(&document["bounds"]["w"]);
    let spent = Exact::from_f64(w.len(), 1, &w).congruent(&diagonal(&document["lyapunov"]["lambda"]));
    let room = Exact::number(1.0).minus(square).times(level).minus(&spent);
    ensure(room.sign() >= 0, || "false: the level".to_owned())?;
    margin_of(document, 1 + vertices, &room)?;
    components(document, system, 2 + vertices, level)
}

/// Steps under the worst disturbance of each, from errors inside and outside the level.
fn stepped(document: &Value, random: &mut Random) -> Found {
    let Some(vertices) = document["plant"]["vertices"].as_array() else { return Ok(()) };
    let systems: Option<Vec<Floats>> = vertices.iter().map(|vertex| Floats::of(document, vertex)).collect();
    let Some(systems) = systems else { return Ok(()) };
    let (factor, level) = (binary64(&document["lyapunov"]["factor"]), binary64(&document["bounds"]["level"]));
    let limsup = floats(&document["bounds"]["limsup"]);
    let first = &systems[0];
    let energy = |e: &DVector<f64>| e.dot(&(&first.p * e));
    for share in [0.01, 1.0, 100.0] {
        let direction = DVector::from_vec(random.vector(first.p.nrows()));
        let mut e = &direction * (share * level / energy(&direction)).sqrt();
        let mut start = energy(&e);
        for step in 0..3000 {
            let system = &systems[random.below(systems.len())];
            // The signs of G'P F e raise V in this step.
            let pull = system.g.transpose() * (&system.p * (&system.f * &e));
            let w = DVector::from_fn(pull.len(), |i, _| system.bounds[i].copysign(pull[i]));
            e = &system.f * &e + &system.g * w;
            start *= factor * factor;
            let v = energy(&e);
            if !v.is_finite() {
                return Ok(());
            }
            ensure(v <= (start + level) * (1.0 + 1e-9), || format!("V = {v:e} at step {step}"))?;
            if start < 1e-6 * level {
                for (k, bound) in limsup.iter().enumerate() {
                    ensure(e[k].abs() <= 1.00001 * bound, || format!("|e{}| = {:e} beyond {bound:e}", k + 1, e[k]))?;
                }
            }
        }
    }
    Ok(())
}
