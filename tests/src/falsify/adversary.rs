//! Attempts to contradict an accepted certificate, from the text of the document alone, in exact arithmetic, without
//! `luenberger-proof`.
//!
//! For statements about eigenvalues or quadratic forms, the exact answer is computed for the numbers as written; where
//! data are intervals, for numbers sampled from them. The worst case of a switching polytope is at a vertex in every
//! step, the worst w of a sector on its boundary: these are sampled, and their inequality is decided for all e at once.
//! The claimed margins are compared with the exact matrices.

use luenberger_random::Random;
use serde_json::Value;

use super::document::{float_matrix, is_single, matrix, number, symmetric};
use super::exact::Exact;

pub(super) type Found = Result<(), String>;

pub(super) fn ensure(holds: bool, what: impl FnOnce() -> String) -> Found {
    if holds { Ok(()) } else { Err(what()) }
}

pub(super) fn said(what: &str) -> impl FnOnce() -> String {
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

pub(super) fn rate(document: &Value) -> Exact {
    single(&document["lyapunov"]["rate"])
}

/// `-(F'P + PF + 2 rate P)`.
pub(super) fn decrease(f: &Exact, p: &Exact, rate: &Exact) -> Exact {
    p.times(f).he().plus(&p.scaled(&rate.plus(rate))).negative()
}

/// `V' + 2 rate V < 0` for `e' = Fe`, and F + rate I stable.
pub(super) fn decays(f: &Exact, p: &Exact, rate: &Exact) -> Result<Exact, String> {
    let m = decrease(f, p, rate);
    ensure(m.is_positive(), said("V' + 2 rate V < 0"))?;
    ensure(f.plus(&Exact::identity(f.rows).scaled(rate)).is_hurwitz(), said("eigenvalues left of -rate"))?;
    Ok(m)
}

pub(super) fn linear_observer(document: &Value, random: &mut Random) -> Found {
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

pub(super) fn hurwitz(document: &Value, random: &mut Random) -> Found {
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

pub(super) fn schur(document: &Value, random: &mut Random) -> Found {
    let (a, p) = (matrix(&document["A"], random), matrix(&document["lyapunov"]["P"], random));
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    margin_of(document, 1, &fall(&a, &p)?)
}

pub(super) fn discrete_observer(document: &Value, random: &mut Random) -> Found {
    let plant = &document["plant"];
    let (a, c) = (matrix(&plant["A"], random), matrix(&plant["C"], random));
    let (l, p) = (matrix(&document["observer"]["L"], random), matrix(&document["lyapunov"]["P"], random));
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    let f = a.minus(&l.times(&c));
    let factor = &document["lyapunov"]["factor"];
    if factor.is_null() {
        return margin_of(document, 1, &fall(&f, &p)?);
    }
    // F/factor is Schur stable: factor^2 P - F'P F, and the circle of this radius.
    let factor = single(factor);
    ensure(factor.sign() > 0 && factor.minus(&Exact::number(1.0)).sign() < 0, said("0 < factor < 1"))?;
    let m = p.scaled(&factor.times(&factor)).minus(&f.congruent(&p));
    ensure(m.is_positive(), said("F'PF - factor^2 P < 0"))?;
    let inverse = factor.solve(&Exact::number(1.0)).ok_or("a factor of 0")?;
    ensure(f.scaled(&inverse).is_schur(), said("eigenvalues inside the circle of radius factor"))?;
    margin_of(document, 1, &m)
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

pub(super) fn sampled(document: &Value, random: &mut Random) -> Found {
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

/// `V' <= -alpha V/|z1|` for the worst F at every z, and `|z1| <= c V^(1/2)`.
pub(super) fn super_twisting(document: &Value, random: &mut Random) -> Found {
    let (observer, lyapunov) = (&document["observer"], &document["lyapunov"]);
    let (k1, k2, bound) = (single(&observer["k1"]), single(&observer["k2"]), single(&document["bounds"]["F"]));
    let (p, alpha, c) = (matrix(&lyapunov["P"], random), single(&lyapunov["alpha"]), single(&lyapunov["c"]));
    for (what, x) in [("k1", &k1), ("k2", &k2), ("bound", &bound), ("alpha", &alpha), ("c", &c)] {
        ensure(x.sign() > 0, || format!("false: {what} > 0"))?;
    }
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    let number = Exact::number;
    // The matrix of the theorem, as it is written.
    let (seen, zero) = (Exact::from_f64(2, 2, &[1.0, 0.0, 0.0, 0.0]), Exact::zeros(1, 1));
    let a = Exact::blocks(&[vec![k1.negative(), number(1.0)], vec![k2.plus(&k2).negative(), zero]]);
    let half =
        p.times(&a).he().scaled(&Exact::dyadic(1, 1)).plus(&p.scaled(&alpha)).plus(&seen.scaled(&bound.times(&bound)));
    let pushed = p.times(&Exact::from_f64(2, 1, &[0.0, 2.0]));
    let whole = Exact::blocks(&[vec![half.plus(&half), pushed.clone()], vec![pushed.transposed(), number(-2.0)]]);
    margin_of(document, 1, &whole.negative())?;
    for step in -16..=16_i32 {
        // z1 > 0 by symmetry; z2 in units in which both parts of V are alike.
        let (p11, p22) = (p.at(0, 0).near(), p.at(1, 1).near());
        let scale = Some((p11 / p22).sqrt()).filter(|scale| scale.is_finite()).unwrap_or(1.0);
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
    margin_of(document, 2, &p.scaled(&c.times(&c)).minus(&seen))
}

/// `H F = 0` and `T E = J F` with rational numbers, and TA - JC stable.
pub(super) fn decoupling(document: &Value, random: &mut Random) -> Found {
    let plant = &document["plant"];
    let (a, c) = (matrix(&plant["A"], random), matrix(&plant["C"], random));
    let (e, f) = (matrix(&document["E"], random), matrix(&document["F"], random));
    let (l, p) = (matrix(&document["observer"]["L"], random), matrix(&document["lyapunov"]["P"], random));
    let columns = float_matrix(&document["F"]);
    let fed: Vec<usize> = (0..columns.ncols()).filter(|j| columns.column(*j).iter().any(|x| *x != 0.0)).collect();
    let pick = Exact::from_f64(
        columns.ncols(),
        fed.len(),
        &(0..columns.ncols())
            .flat_map(|i| fed.iter().map(move |j| if i == *j { 1.0 } else { 0.0 }))
            .collect::<Vec<f64>>(),
    );
    let (outputs, count) = (c.rows, fed.len());
    let upper = if count == 0 { vec![c.times(&e)] } else { vec![c.times(&e), f.times(&pick)] };
    let lower = if count == 0 { vec![f.clone()] } else { vec![f.clone(), Exact::zeros(outputs, count)] };
    let s = Exact::blocks(&[upper, lower]);
    let gram = s.transposed().times(&s);
    ensure(gram.is_positive(), said("S has full column rank"))?;
    margin_of(document, 0, &gram)?;
    let left = e.minus(&l.times(&f));
    let wanted = if count == 0 { left } else { Exact::blocks(&[vec![left, Exact::zeros(a.rows, count)]]) };
    let both = wanted.times(&gram.solve(&s.transposed()).ok_or("S'S is singular")?);
    let (h, j) = (both.view(0, 0, a.rows, outputs), l.plus(&both.view(0, outputs, a.rows, outputs)));
    ensure(h.times(&f).is_zero(), said("HF = 0"))?;
    let t = Exact::identity(a.rows).minus(&h.times(&c));
    ensure(t.times(&e).minus(&j.times(&f)).is_zero(), said("TE = JF"))?;
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 1, &p)?;
    let flow = t.times(&a).minus(&j.times(&c));
    let change =
        if document["time"] == "discrete" { fall(&flow, &p)? } else { decays(&flow, &p, &Exact::zeros(1, 1))? };
    margin_of(document, 2, &change)
}

/// `M T + N C = I` and `T A = F T + G C` with rational numbers, and F stable.
pub(super) fn reduced_order(document: &Value, random: &mut Random) -> Found {
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

pub(super) fn definiteness(document: &Value, random: &mut Random) -> Found {
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

pub(super) fn solution(document: &Value, random: &mut Random) -> Found {
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
