//! Attempts to contradict an accepted certificate, from the text of the document alone, in exact arithmetic, without
//! `luenberger-proof`.
//!
//! For statements about eigenvalues or quadratic forms, the exact answer is computed for the numbers as written; where
//! data are intervals, for numbers sampled from them. The worst case of a switching polytope is at a vertex in every
//! step, the worst w of a sector on its boundary: these are sampled, and their inequality is decided for all e at once.
//! The claimed margins are compared with the exact matrices.

use serde_json::Value;

use super::deployed;
use super::disturbed;
use super::document::{binary64, float_matrix, is_single, matrix, matrix_with_columns, number, symmetric};
use super::exact::Exact;
use super::filters;
use super::intervals;
use super::kkl;
use super::programs;
use super::random::Random;
use super::sampled as beyond;

pub(super) type Found = Result<(), String>;

type Adversary = fn(&Value, &mut Random) -> Found;

/// The adversary of each theorem, by its name.
pub(super) const ADVERSARIES: &[(&str, Adversary)] = &[
    ("linear-observer", linear_observer),
    ("discrete-observer", discrete_observer),
    ("hurwitz", hurwitz),
    ("schur", schur),
    ("cubic-observer", cubic_observer),
    ("cubic-observer-with-structured-gain", structured),
    ("cubic-observer-theorem-1", theorem1),
    ("sampled-cubic-observer", sampled),
    ("unknown-input-observer", unknown_input),
    ("input-to-state-stability", disturbed::contradicted),
    ("interval-observer", intervals::continuous),
    ("sampled-interval-observer", intervals::sampled),
    ("super-twisting-observer", super_twisting),
    ("reduced-order-observer", reduced_order),
    ("h-infinity-filter", filters::gain_contradicted),
    ("h2-filter", filters::variance_contradicted),
    ("sampled-cubic-observer-semi-implicit", beyond::semi_implicit),
    ("sampled-observer-at-varying-periods", beyond::varying_periods),
    ("deployed-observer", deployed::contradicted),
    ("feedback-loop", feedback),
    ("polytope-of-plants", polytope),
    ("polytope-of-jacobians", polytope),
    ("discrete-polytope-of-jacobians", discrete_polytope),
    ("sector-observer", sector),
    ("contracting-coordinates", contracting),
    ("kkl-error-bound", kkl::contradicted),
    ("definiteness", definiteness),
    ("solution-within", solution),
    ("matrix-inequality-holds", programs::holds),
    ("matrix-inequality-refuted", programs::refuted),
    ("semidefinite-program", programs::semidefinite),
];

pub(super) fn ensure(holds: bool, what: impl FnOnce() -> String) -> Found {
    if holds { Ok(()) } else { Err(what()) }
}

fn said(what: &str) -> impl FnOnce() -> String {
    let what = format!("false: {what}");
    || what
}

pub(super) fn single(value: &Value) -> Exact {
    number(value.as_str().expect("a number")).expect("a number")
}

/// The margin of the fact at this place, if one is claimed, is a lower bound of the least eigenvalue of `m`.
pub(super) fn margin_of(document: &Value, index: usize, m: &Exact) -> Found {
    let claim = &document["margins"][index];
    if claim.is_null() {
        return Ok(());
    }
    let margin = single(&claim["margin"]);
    let left = m.minus(&Exact::identity(m.rows).scaled(&margin));
    ensure(left.is_semidefinite(), || format!("the margin {} of {} is too large", claim["margin"], claim["inequality"]))
}

fn rate(document: &Value) -> Exact {
    single(&document["lyapunov"]["rate"])
}

/// `-(F'P + PF + 2 rate P)`.
fn decrease(f: &Exact, p: &Exact, rate: &Exact) -> Exact {
    p.times(f).he().plus(&p.scaled(&rate.plus(rate))).negative()
}

/// `V' + 2 rate V < 0` for `e' = Fe`, and F + rate I stable.
fn decays(f: &Exact, p: &Exact, rate: &Exact) -> Result<Exact, String> {
    let m = decrease(f, p, rate);
    ensure(m.is_positive(), said("V' + 2 rate V < 0"))?;
    ensure(f.plus(&Exact::identity(f.rows).scaled(rate)).is_hurwitz(), said("eigenvalues left of -rate"))?;
    Ok(m)
}

fn linear_observer(document: &Value, random: &mut Random) -> Found {
    let plant = &document["plant"];
    let p = matrix(&document["lyapunov"]["P"], random);
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    let l = matrix(&document["observer"]["L"], random);
    let draws = if is_single(&plant["A"]) && is_single(&plant["C"]) { 1 } else { 12 };
    for _ in 0..draws {
        let (a, c) = (matrix(&plant["A"], random), matrix(&plant["C"], random));
        margin_of(document, 1, &decays(&a.minus(&l.times(&c)), &p, &rate(document))?)?;
    }
    Ok(())
}

fn hurwitz(document: &Value, random: &mut Random) -> Found {
    let p = matrix(&document["lyapunov"]["P"], random);
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    let draws = if is_single(&document["A"]) { 1 } else { 12 };
    for _ in 0..draws {
        let a = matrix(&document["A"], random);
        margin_of(document, 1, &decays(&a, &p, &Exact::number(0.0))?)?;
        if let Some(claim) = document["margins"].get(2) {
            let shift = single(&claim["margin"]);
            // Where the margin is that of the boundary itself, a little less has to hold.
            let less = shift.scaled(&Exact::number(1.0_f64.next_down()));
            let left = a.plus(&Exact::identity(a.rows).scaled(&less));
            ensure(
                left.is_hurwitz() || (shift.is_zero() && a.is_hurwitz()),
                said("real parts below minus the margin"),
            )?;
        }
    }
    Ok(())
}

/// `P - F'P F`.
pub(super) fn fall(f: &Exact, p: &Exact) -> Result<Exact, String> {
    let m = p.minus(&f.congruent(p));
    ensure(m.is_positive(), said("F'PF - P < 0"))?;
    ensure(f.is_schur(), said("eigenvalues inside the unit circle"))?;
    Ok(m)
}

fn schur(document: &Value, random: &mut Random) -> Found {
    let (a, p) = (matrix(&document["A"], random), matrix(&document["lyapunov"]["P"], random));
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    margin_of(document, 1, &fall(&a, &p)?)
}

fn discrete_observer(document: &Value, random: &mut Random) -> Found {
    let plant = &document["plant"];
    let (a, c) = (matrix(&plant["A"], random), matrix(&plant["C"], random));
    let (l, p) = (matrix(&document["observer"]["L"], random), matrix(&document["lyapunov"]["P"], random));
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    margin_of(document, 1, &fall(&a.minus(&l.times(&c)), &p)?)
}

/// `w M(g)` for g w = share, at which V has to fall: the map of one period of the sampled cubic observer.
pub(super) fn sampled_map(a: &Exact, c: &Exact, l: &Exact, n: &Exact, w: &Exact, share: &Exact) -> Exact {
    let linear = a.minus(&l.times(c)).scaled(w);
    let cubic = a.times(n).plus(&l.scaled(w)).times(c);
    linear.plus(&cubic.scaled(share))
}

/// V falls under `M(g)` for g from 0 to 1/w.
pub(super) fn sampled_falls(a: &Exact, c: &Exact, l: &Exact, n: &Exact, w: &Exact, p: &Exact) -> Found {
    for k in [0, 1, 5, 8, 11, 15, 16] {
        let map = sampled_map(a, c, l, n, w, &Exact::dyadic(k, 4));
        let left = p.scaled(&w.times(w)).minus(&map.congruent(p));
        ensure(left.is_positive(), || format!("false: V falls where g w = {k}/16"))?;
    }
    Ok(())
}

fn sampled(document: &Value, random: &mut Random) -> Found {
    let (plant, observer) = (&document["plant"], &document["observer"]);
    let (a, c) = (matrix(&plant["A"], random), matrix(&plant["C"], random));
    let (l, n) = (matrix(&observer["L"], random), matrix(&observer["N"], random));
    let (w, p) = (single(&observer["w"]), matrix(&document["lyapunov"]["P"], random));
    ensure(w.sign() > 0 && single(&observer["period"]).sign() > 0, said("w, h > 0"))?;
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    margin_of(document, 1, &fall(&a.minus(&l.times(&c)), &p)?)?;
    sampled_falls(&a, &c, &l, &n, &w, &p)?;
    let saturated = a.scaled(&w).plus(&a.times(&n).times(&c));
    margin_of(document, 2, &p.scaled(&w.times(&w)).minus(&saturated.congruent(&p)))
}

/// Directions in which a cubic term would show: of any kind, and eigenvectors of the forms.
fn directions(forms: &[nalgebra::DMatrix<f64>], n: usize, random: &mut Random) -> Vec<Vec<f64>> {
    let mut found: Vec<Vec<f64>> = (0..4).map(|_| random.vector(n)).collect();
    for form in forms.iter().filter(|form| form.iter().all(|x| x.abs() < 1e100)) {
        let eigen = nalgebra::SymmetricEigen::new((form + form.transpose()) * 0.5);
        found.extend(eigen.eigenvectors.column_iter().map(|v| v.iter().copied().collect::<Vec<f64>>()));
    }
    found.retain(|v| v.iter().all(|x| x.is_finite()) && v.iter().any(|x| *x != 0.0));
    found
}

/// `V' = e'Me + (y'theta y) e'He < 0` at errors of all sizes, in all directions that are drawn.
fn falls_along_cubic(m: &Exact, weight: &Exact, h: &Exact, at: &[Vec<f64>], random: &mut Random) -> Found {
    for direction in at {
        let u = Exact::from_f64(direction.len(), 1, direction);
        let form = |m: &Exact| u.congruent(m);
        let (linear, cubic) = (form(m), form(weight).times(&form(h)));
        for exponent in [-27, 0, 27, i64::from(random.integer(-40, 40))] {
            // The linear part grows with r^2, the cubic one with r^4.
            let sum = linear.plus(&cubic.scaled(&Exact::dyadic(1, -2 * exponent)));
            ensure(sum.sign() < 0, || format!("false: V' < 0 at 2^{exponent} times {direction:?}"))?;
        }
    }
    Ok(())
}

/// The parts of a cubic observer in a document.
struct Cubic {
    a: Exact,
    b: Exact,
    c: Exact,
    l: Exact,
    theta: Exact,
    p: Exact,
}

impl Cubic {
    fn of(document: &Value, random: &mut Random) -> Self {
        let (plant, observer) = (&document["plant"], &document["observer"]);
        Self {
            a: matrix(&plant["A"], random),
            b: matrix(&plant["B"], random),
            c: matrix(&plant["C"], random),
            l: matrix(&observer["L"], random),
            theta: matrix(&observer["theta"], random),
            p: matrix(&document["lyapunov"]["P"], random),
        }
    }

    fn f(&self) -> Exact {
        self.a.minus(&self.l.times(&self.c))
    }

    /// `P > 0`, (12) and `theta >= 0`, with their margins.
    fn linear_part(&self, document: &Value, rate: &Exact) -> Found {
        ensure(self.p.is_positive(), said("P > 0"))?;
        margin_of(document, 0, &self.p)?;
        margin_of(document, 1, &decays(&self.f(), &self.p, rate)?)?;
        ensure(self.theta.is_semidefinite(), said("theta >= 0"))?;
        margin_of(document, 2, &self.theta)
    }

    /// `V' + 2 rate V < 0` at errors of all sizes, where the cubic term is `(y'theta y) e'He`.
    fn falls(&self, h: &Exact, document: &Value, rate: &Exact, random: &mut Random) -> Found {
        let weight = self.c.congruent(&self.theta);
        let c = float_matrix(&document["plant"]["C"]);
        let forms = [c.transpose() * float_matrix(&document["observer"]["theta"]) * &c];
        let at = directions(&forms, self.p.rows, random);
        falls_along_cubic(&decrease(&self.f(), &self.p, rate).negative(), &weight, h, &at, random)
    }

    /// For the real gain `-P^-1 C'S`: `P N C + C'N'P = -C'(S + S')C`.
    fn real_gain(&self, s: &Exact, document: &Value, rate: &Exact, random: &mut Random) -> Found {
        let h = self.c.congruent(&s.he()).negative();
        ensure(h.negative().is_semidefinite(), said("P N C + C'N'P <= 0"))?;
        self.falls(&h, document, rate, random)
    }
}

fn theorem1(document: &Value, random: &mut Random) -> Found {
    let cubic = Cubic::of(document, random);
    let zero = Exact::number(0.0);
    cubic.linear_part(document, &zero)?;
    let h = cubic.p.times(&matrix(&document["observer"]["N"], random)).times(&cubic.c).he();
    ensure(h.negative().is_semidefinite(), said("P N C + C'N'P <= 0"))?;
    cubic.falls(&h, document, &zero, random)
}

fn structured(document: &Value, random: &mut Random) -> Found {
    let cubic = Cubic::of(document, random);
    cubic.linear_part(document, &rate(document))?;
    cubic.real_gain(&matrix(&document["observer"]["S"], random), document, &rate(document), random)
}

fn cubic_observer(document: &Value, random: &mut Random) -> Found {
    let cubic = Cubic::of(document, random);
    cubic.linear_part(document, &rate(document))?;
    let s = matrix(&document["lyapunov"]["S"], random);
    ensure(s.he().is_semidefinite(), said("S + S' >= 0"))?;
    cubic.real_gain(&s, document, &rate(document), random)?;
    let n = matrix(&document["observer"]["N"], random);
    let region = document["lyapunov"]["converges_from"].as_str().unwrap_or_default();
    let (f, nc) = (cubic.f(), n.times(&cubic.c));
    // With the Lyapunov matrix of the proof no e' = (F + q NC)e grows; and y'theta y can be any q where theta > 0.
    let unstable = [-30, -10, -2, 0, 2, 10, 30, i64::from(random.integer(-60, 60))]
        .into_iter()
        .find(|exponent| !f.plus(&nc.scaled(&Exact::dyadic(1, -exponent))).is_hurwitz());
    if region == "everywhere" {
        let sound = unstable.is_none() || !cubic.theta.is_positive();
        ensure(sound, || format!("F + q NC is unstable for q = 2^{unstable:?}"))?;
    } else if unstable.is_some() {
        // V' < 0 where e'Pe is just below the level: e is a direction, moved there.
        let level = number(region).ok_or("a region that is no number")?;
        let h = cubic.p.times(&nc).he();
        let weight = cubic.c.congruent(&cubic.theta);
        let m = cubic.p.times(&f).he();
        let c = float_matrix(&document["plant"]["C"]);
        let forms = [c.transpose() * float_matrix(&document["observer"]["theta"]) * &c];
        for direction in directions(&forms, f.rows, random) {
            let u = Exact::from_f64(direction.len(), 1, &direction);
            let form = |m: &Exact| u.congruent(m);
            // e = r u with r^2 = level/(u'Pu): V' u'Pu/r^2 = u'Mu u'Pu + level (u'theta u) (u'Hu).
            for share in [16, 8, 1] {
                let cubic_part = form(&weight).times(&form(&h)).times(&level).scaled(&Exact::dyadic(share, 4));
                let sum = form(&m).times(&form(&cubic.p)).plus(&cubic_part);
                ensure(sum.sign() < 0, || format!("false: V' < 0 at {share}/16 of the level along {direction:?}"))?;
            }
        }
    }
    if random.once_in(24) { simulated(document, random) } else { Ok(()) }
}

/// Runge and Kutta's fourth order with short steps, until V has fallen to a thousandth of what it was. The Lyapunov
/// matrix of the stored gain is another one than P, so that V may grow at first; not a thousandfold.
fn simulated(document: &Value, random: &mut Random) -> Found {
    let (plant, observer) = (&document["plant"], &document["observer"]);
    let c = float_matrix(&plant["C"]);
    let f = float_matrix(&plant["A"]) - float_matrix(&observer["L"]) * &c;
    let nc = float_matrix(&observer["N"]) * &c;
    let theta = c.transpose() * float_matrix(&observer["theta"]) * &c;
    let p = float_matrix(&document["lyapunov"]["P"]);
    let n = f.nrows();
    let slope = |e: &nalgebra::DVector<f64>| {
        let q = e.dot(&(&theta * e));
        &f * e + (&nc * e) * q
    };
    let energy = |e: &nalgebra::DVector<f64>| e.dot(&(&p * e));
    let level = match document["lyapunov"]["converges_from"].as_str() {
        Some("everywhere") | None => f64::INFINITY,
        Some(_) => binary64(&document["lyapunov"]["converges_from"]),
    };
    for size in [1e-3, 1.0, 1e2] {
        let mut e = nalgebra::DVector::from_vec(random.vector(n)) * size;
        if energy(&e) > 0.9 * level {
            e *= (0.9 * level / energy(&e)).sqrt();
        }
        let start = energy(&e);
        for _ in 0..4000 {
            let q = e.dot(&(&theta * &e)).abs();
            let mut h = 0.1 / (f.norm() + 3.0 * q * nc.norm());
            let before = energy(&e);
            // Where y is small and e is not, the cubic term awakes within a step: that step is too long.
            for _ in 0..60 {
                let k1 = slope(&e);
                let k2 = slope(&(&e + &k1 * (h / 2.0)));
                let k3 = slope(&(&e + &k2 * (h / 2.0)));
                let k4 = slope(&(&e + &k3 * h));
                let next = &e + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0);
                let v = energy(&next);
                if v <= 1.01 * before && v >= 0.5 * before {
                    e = next;
                    break;
                }
                h /= 2.0;
            }
            let v = energy(&e);
            if !v.is_finite() || start < 1e-280 {
                return ensure(start < 1e-280 || !h.is_normal(), || {
                    format!("the error grew without bound from V = {start:e}")
                });
            }
            ensure(v <= 1e3 * start, || format!("V grew from {start:e} to {v:e}"))?;
            if v < 1e-3 * start {
                break;
            }
        }
    }
    Ok(())
}

/// `T = I - HC` with rational numbers: `T E = 0`, and the error decays at every size of it.
fn unknown_input(document: &Value, random: &mut Random) -> Found {
    let (plant, term) = (&document["plant"], &document["cubic"]);
    let (a, c) = (matrix(&plant["A"], random), matrix(&plant["C"], random));
    let (e, l) = (matrix(&document["E"], random), matrix(&document["observer"]["L"], random));
    let image = c.times(&e);
    let gram = image.transposed().times(&image);
    ensure(gram.is_positive(), said("C E has full column rank"))?;
    margin_of(document, 0, &gram)?;
    let h = e.times(&gram.solve(&image.transposed()).ok_or("(CE)'CE is singular")?);
    let t = Exact::identity(a.rows).minus(&h.times(&c));
    ensure(t.times(&e).is_zero(), said("T E = 0"))?;
    let mut p = matrix(&document["lyapunov"]["P"], random);
    let f = t.times(&a).minus(&l.times(&c));
    let rate = rate(document);
    if term.is_null() {
        ensure(p.is_positive(), said("P > 0"))?;
        margin_of(document, 1, &p)?;
        return margin_of(document, 2, &decays(&f, &p, &rate)?);
    }
    let (n, theta) = (matrix(&term["N"], random), matrix(&term["theta"], random));
    let x = matrix(&term["X"], random);
    p = disturbed::structured(&p, &c, &x, &n)?;
    ensure(p.is_positive(), said("P~ > 0"))?;
    margin_of(document, 1, &p)?;
    let m = decays(&f, &p, &rate)?;
    margin_of(document, 2, &m)?;
    ensure(theta.is_semidefinite(), said("theta >= 0"))?;
    margin_of(document, 3, &theta)?;
    margin_of(document, 4, &x.times(&c).times(&n).negative().he())?;
    let output = float_matrix(&plant["C"]);
    let forms = [output.transpose() * float_matrix(&term["theta"]) * &output];
    let at = directions(&forms, p.rows, random);
    let h = p.times(&n).times(&c).he();
    falls_along_cubic(&m.negative(), &c.congruent(&theta), &h, &at, random)
}

/// `V' <= -alpha V/|z1|` for the worst F at every z, and `|z1| <= c V^(1/2)`.
fn super_twisting(document: &Value, random: &mut Random) -> Found {
    let (observer, lyapunov) = (&document["observer"], &document["lyapunov"]);
    let (k1, k2, bound) = (single(&observer["k1"]), single(&observer["k2"]), single(&document["bounds"]["F"]));
    let (p, alpha, c) = (matrix(&lyapunov["P"], random), single(&lyapunov["alpha"]), single(&lyapunov["c"]));
    for (what, x) in [("k1", &k1), ("k2", &k2), ("bound", &bound), ("alpha", &alpha), ("c", &c)] {
        ensure(x.sign() > 0, || format!("false: {what} > 0"))?;
    }
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    let number = Exact::number;
    for step in -16..=16_i32 {
        // z1 > 0 by symmetry; z2 in units in which both parts of V are alike.
        let (p11, p22) = (p.at(0, 0).near(), p.at(1, 1).near());
        let scale = (p11 / p22).sqrt();
        let (z1, z2) = if step == 16 { (0.0, 1.0) } else { (1.0, f64::from(step) * 0.25 * scale) };
        let z = Exact::from_f64(2, 1, &[z1, z2]);
        let value = z.congruent(&p);
        ensure(c.times(&c).times(&value).minus(&number(z1 * z1)).sign() >= 0, said("|z1| <= c V^(1/2)"))?;
        for sign in [-1.0, 1.0] {
            // |z1| z' = (-k1 z1 + z2, -2 k2 z1)/2 + (0, |z1| F).
            let pushed = bound.times(&number(sign * z1));
            let first = z.at(1, 0).minus(&k1.times(&number(z1))).scaled(&Exact::dyadic(1, 1));
            let second = pushed.minus(&k2.times(&number(z1)));
            let motion = Exact::from_numbers(2, 1, &[first, second]);
            let slope = z.transposed().times(&p).times(&motion);
            let rise = slope.plus(&slope).plus(&alpha.times(&value));
            ensure(rise.sign() <= 0, said("V' <= -alpha V/|z1|"))?;
        }
    }
    let seen = Exact::from_f64(2, 2, &[1.0, 0.0, 0.0, 0.0]);
    margin_of(document, 2, &p.scaled(&c.times(&c)).minus(&seen))
}

/// `M T + N C = I` and `T A = F T + G C` with rational numbers, and F stable.
fn reduced_order(document: &Value, random: &mut Random) -> Found {
    let plant = &document["plant"];
    let (a, c) = (matrix(&plant["A"], random), matrix(&plant["C"], random));
    let (t, p) = (matrix(&document["observer"]["T"], random), matrix(&document["lyapunov"]["P"], random));
    let gram = c.transposed().times(&c).plus(&t.transposed().times(&t));
    ensure(gram.is_positive(), said("C'C + T'T > 0"))?;
    margin_of(document, 0, &gram)?;
    let inverse = |m: &Exact| gram.solve(&m.transposed()).ok_or("C'C + T'T is singular");
    let (n, m) = (inverse(&c)?, inverse(&t)?);
    ensure(m.times(&t).plus(&n.times(&c)).minus(&Exact::identity(a.rows)).is_zero(), said("MT + NC = I"))?;
    let image = t.times(&a);
    let f = image.times(&m);
    let rest = image.minus(&f.times(&t)).minus(&image.times(&n).times(&c));
    ensure(rest.is_zero(), said("TA = FT + GC"))?;
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 1, &p)?;
    margin_of(document, 2, &decays(&f, &p, &rate(document))?)
}

fn feedback(document: &Value, random: &mut Random) -> Found {
    cubic_observer(document, random)?;
    let cubic = Cubic::of(document, random);
    let n = cubic.a.rows;
    let b = if cubic.b.cols == 0 { Exact::zeros(n, 0) } else { cubic.b.clone() };
    let k = matrix_with_columns(&document["feedback"]["K"], n, random);
    let p1 = matrix(&document["feedback"]["P1"], random);
    ensure(p1.is_positive(), said("P1 > 0"))?;
    margin_of(document, 5, &p1)?;
    let bk = if b.cols == 0 { Exact::zeros(n, n) } else { b.times(&k) };
    let f = cubic.f();
    let closed = cubic.a.minus(&bk);
    ensure(closed.is_hurwitz() && f.is_hurwitz(), said("the loop is stable"))?;
    let corner = p1.times(&bk);
    let form = Exact::blocks(&[
        vec![p1.times(&closed).he(), corner.clone()],
        vec![corner.transposed(), cubic.p.times(&f).he()],
    ]);
    ensure(form.negative().is_positive(), said("(25)"))?;
    margin_of(document, 6, &form.negative())
}

/// Weights of a point of the hull, in sixteenths: often a vertex.
fn weights(count: usize, random: &mut Random) -> Vec<Exact> {
    let mut weights = vec![0; count];
    let vertex = random.once_in(2);
    let first = random.below(count);
    for _ in 0..16 {
        weights[if vertex { first } else { random.below(count) }] += 1;
    }
    weights.into_iter().map(|k| Exact::dyadic(k, 4)).collect()
}

fn mixed(matrices: &[Exact], weights: &[Exact]) -> Exact {
    let first = Exact::zeros(matrices[0].rows, matrices[0].cols);
    matrices.iter().zip(weights).fold(first, |sum, (m, weight)| sum.plus(&m.scaled(weight)))
}

fn polytope(document: &Value, random: &mut Random) -> Found {
    let vertices = document["vertices"].as_array().ok_or("no vertices")?;
    ensure(!vertices.is_empty(), said("there is a vertex"))?;
    let (l, p) = (matrix(&document["observer"]["L"], random), matrix(&document["lyapunov"]["P"], random));
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    for k in 0..vertices.len() + 6 {
        let a: Vec<Exact> = vertices.iter().map(|vertex| matrix(&vertex["A"], random)).collect();
        let c: Vec<Exact> = vertices.iter().map(|vertex| matrix(&vertex["C"], random)).collect();
        if k < vertices.len() {
            margin_of(document, k + 1, &decays(&a[k].minus(&l.times(&c[k])), &p, &rate(document))?)?;
        } else {
            let weights = weights(vertices.len(), random);
            decays(&mixed(&a, &weights).minus(&l.times(&mixed(&c, &weights))), &p, &rate(document))?;
        }
    }
    Ok(())
}

/// `factor^2 P - F'PF > 0`, and F/factor inside the unit circle; the block of the certificate.
fn contracts(f: &Exact, p: &Exact, factor: &Exact) -> Result<Exact, String> {
    let scaled = p.scaled(&factor.times(factor));
    ensure(scaled.minus(&f.congruent(p)).is_positive(), said("F'PF < factor^2 P"))?;
    ensure(f.is_schur(), said("eigenvalues inside the unit circle"))?;
    let corner = p.times(f);
    Ok(Exact::blocks(&[vec![scaled, corner.transposed()], vec![corner, p.clone()]]))
}

fn discrete_polytope(document: &Value, random: &mut Random) -> Found {
    let vertices = document["vertices"].as_array().ok_or("no vertices")?;
    ensure(!vertices.is_empty(), said("there is a vertex"))?;
    let (l, p) = (matrix(&document["observer"]["L"], random), matrix(&document["lyapunov"]["P"], random));
    let factor = single(&document["lyapunov"]["factor"]);
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    let mut product = Exact::identity(p.rows);
    for k in 0..vertices.len() + 6 {
        let a: Vec<Exact> = vertices.iter().map(|vertex| matrix(&vertex["A"], random)).collect();
        let c: Vec<Exact> = vertices.iter().map(|vertex| matrix(&vertex["C"], random)).collect();
        let f = if k < vertices.len() {
            let f = a[k].minus(&l.times(&c[k]));
            margin_of(document, k + 1, &contracts(&f, &p, &factor)?)?;
            f
        } else {
            let weights = weights(vertices.len(), random);
            let f = mixed(&a, &weights).minus(&l.times(&mixed(&c, &weights)));
            contracts(&f, &p, &factor)?;
            f
        };
        // However the pairs follow one another: V(k) <= factor^(2k) V(0) for all e(0).
        if k < 3 {
            product = f.times(&product);
            let mut bound = p.clone();
            (0..=k).for_each(|_| bound = bound.scaled(&factor.times(&factor)));
            ensure(bound.minus(&product.congruent(&p)).is_positive(), said("V(k) <= factor^(2k) V(0)"))?;
        }
    }
    Ok(())
}

fn contracting(document: &Value, random: &mut Random) -> Found {
    let k = matrix(&document["coordinates"]["K"], random);
    let (unmeasured, measured) = (k.rows, k.cols);
    let n = unmeasured + measured;
    let q = matrix(&document["lyapunov"]["Q"], random);
    ensure(q.is_positive(), said("Q > 0"))?;
    margin_of(document, 0, &q)?;
    let injection = single(&document["observer"]["injection"]);
    let vertices: Vec<Exact> =
        document["vertices"].as_array().into_iter().flatten().map(|vertex| matrix(vertex, random)).collect();
    ensure(!vertices.is_empty(), said("there is a vertex"))?;
    let (one, zero) = (Exact::identity, Exact::zeros);
    let turn = Exact::blocks(&[vec![one(measured), zero(measured, unmeasured)], vec![k.clone(), one(unmeasured)]]);
    let back = Exact::blocks(&[vec![one(measured), zero(measured, unmeasured)], vec![k.negative(), one(unmeasured)]]);
    let p =
        Exact::blocks(&[vec![one(measured), zero(measured, unmeasured)], vec![zero(unmeasured, measured), q.clone()]]);
    for number in 0..vertices.len() + 6 {
        let at_vertex = number < vertices.len();
        let j = if at_vertex { vertices[number].clone() } else { mixed(&vertices, &weights(vertices.len(), random)) };
        // Diagonal injections of g or more.
        let more: Vec<f64> = (0..n * n)
            .map(|k| if k / n == k % n && k / n < measured && !at_vertex { random.between(0.0, 4.0) } else { 0.0 })
            .collect();
        let least = Exact::blocks(&[
            vec![one(measured).scaled(&injection), zero(measured, unmeasured)],
            vec![zero(unmeasured, measured), zero(unmeasured, unmeasured)],
        ]);
        let f = back.times(&j).times(&turn).minus(&least).minus(&Exact::from_f64(n, n, &more));
        let m = decays(&f, &p, &rate(document))?;
        if at_vertex {
            margin_of(document, 2 * number + 2, &m)?;
            margin_of(document, 2 * number + 1, &m.view(measured, measured, unmeasured, unmeasured))?;
        }
    }
    Ok(())
}

/// A signed permutation, or a part of one: its norm is at most 1.
fn isometry(rows: usize, cols: usize, random: &mut Random) -> Exact {
    let turn = random.below(rows.max(cols));
    let entries: Vec<f64> = (0..rows * cols)
        .map(|k| if (k / cols + turn) % rows.max(cols) == k % cols { random.sign() } else { 0.0 })
        .collect();
    Exact::from_f64(rows, cols, &entries)
}

fn sector(document: &Value, random: &mut Random) -> Found {
    let plant = &document["plant"];
    let (a, c) = (matrix(&plant["A"], random), matrix(&plant["C"], random));
    let (l, p) = (matrix(&document["observer"]["L"], random), matrix(&document["lyapunov"]["P"], random));
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    let f = a.minus(&l.times(&c));
    let terms = plant["sectors"].as_array().ok_or("no sectors")?;
    let half = Exact::dyadic(1, 1);
    let mut parts = Vec::new();
    for term in terms {
        let (g, h) = (matrix(&term["G"], random), matrix(&term["H"], random));
        let (low, high, tau) = (single(&term["low"]), single(&term["high"]), single(&term["tau"]));
        ensure(high.minus(&low).sign() >= 0, said("low <= high"))?;
        let (middle, radius) = (low.plus(&high).scaled(&half), high.minus(&low).scaled(&half));
        parts.push((g, h, low, high, tau, middle, radius));
    }
    // w = middle He + radius R He with |R| <= 1 satisfies the sector.
    for _ in 0..8 {
        let mut worst = f.clone();
        for (g, h, _, _, _, middle, radius) in &parts {
            let mut map = isometry(g.cols, h.rows, random).scaled(radius);
            if g.cols == h.rows {
                map = map.plus(&Exact::identity(h.rows).scaled(middle));
            }
            worst = worst.plus(&g.times(&map).times(h));
        }
        decays(&worst, &p, &rate(document))?;
    }
    // The matrix of the S-procedure, as it is written.
    let rate = rate(document);
    let mut corner = decrease(&f, &p, &rate).negative();
    let mut rows: Vec<Vec<Exact>> = Vec::new();
    let mut first = Vec::new();
    for (k, (g, h, low, high, tau, middle, _)) in parts.iter().enumerate() {
        corner = corner.minus(&h.transposed().times(h).scaled(&low.times(high).times(tau)));
        let mut off = p.times(g);
        if g.cols == h.rows {
            off = off.plus(&h.transposed().scaled(&middle.times(tau)));
        }
        let mut row = vec![off.transposed()];
        row.extend(parts.iter().enumerate().map(|(j, other)| {
            if j == k { Exact::identity(g.cols).scaled(tau).negative() } else { Exact::zeros(g.cols, other.0.cols) }
        }));
        rows.push(row);
        first.push(off);
    }
    first.insert(0, corner);
    rows.insert(0, first);
    margin_of(document, 1, &Exact::blocks(&rows).negative())
}

fn definiteness(document: &Value, random: &mut Random) -> Found {
    let is = document["is"].as_str().unwrap_or_default();
    let draws = if is_single(&document["M"]) { 1 } else { 20 };
    for _ in 0..draws {
        let mut m = symmetric(&document["M"], random);
        if is.starts_with("negative") {
            m = m.negative();
        }
        ensure(if is.ends_with("semidefinite") { m.is_semidefinite() } else { m.is_positive() }, said(is))?;
        margin_of(document, 0, &m)?;
    }
    Ok(())
}

fn solution(document: &Value, random: &mut Random) -> Found {
    let is_stein = document["equation"] == "A'PA - P + Q = 0";
    let draws = if is_single(&document["A"]) && is_single(&document["Q"]) { 1 } else { 6 };
    for _ in 0..draws {
        let (a, q) = (matrix(&document["A"], random), symmetric(&document["Q"], random));
        let n = a.rows;
        // The operator by its values at the n^2 units.
        let mut columns = Vec::new();
        for k in 0..n * n {
            let unit: Vec<f64> = (0..n * n).map(|j| if j == k { 1.0 } else { 0.0 }).collect();
            let unit = Exact::from_f64(n, n, &unit);
            let image = if is_stein {
                a.congruent(&unit).minus(&unit)
            } else {
                a.transposed().times(&unit).plus(&unit.times(&a))
            };
            columns.push(image);
        }
        let entries: Vec<Exact> =
            (0..n.pow(4)).map(|k| columns[k % (n * n)].at(k / (n * n) / n, k / (n * n) % n)).collect();
        let operator = Exact::from_numbers(n * n, n * n, &entries);
        let right: Vec<Exact> = (0..n * n).map(|k| q.at(k / n, k % n).negative()).collect();
        let p = operator.solve(&Exact::from_numbers(n * n, 1, &right)).ok_or("the solution is not unique")?;
        for k in 0..n * n {
            let interval = &document["P"][k / n][k % n];
            let (lo, hi) = match interval {
                Value::Array(ends) => (single(&ends[0]), single(&ends[1])),
                point => (single(point), single(point)),
            };
            let x = p.at(k, 0);
            let within = x.minus(&lo).sign() >= 0 && hi.minus(&x).sign() >= 0;
            ensure(within, || format!("P[{}][{}] is not within {interval}", k / n, k % n))?;
        }
    }
    Ok(())
}
