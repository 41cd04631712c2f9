//! Adversaries of the cubic observers: their forms in exact arithmetic, and runs of the stored observer.

use luenberger_random::Random;
use serde_json::Value;

use super::adversary::{Found, decays, decrease, ensure, margin_of, rate, said};
use super::disturbed;
use super::document::{binary64, float_matrix, matrix, matrix_with_columns, number};
use super::exact::Exact;

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

pub(super) fn theorem1(document: &Value, random: &mut Random) -> Found {
    let cubic = Cubic::of(document, random);
    let zero = Exact::number(0.0);
    cubic.linear_part(document, &zero)?;
    let h = cubic.p.times(&matrix(&document["observer"]["N"], random)).times(&cubic.c).he();
    ensure(h.negative().is_semidefinite(), said("P N C + C'N'P <= 0"))?;
    cubic.falls(&h, document, &zero, random)
}

pub(super) fn structured(document: &Value, random: &mut Random) -> Found {
    let cubic = Cubic::of(document, random);
    cubic.linear_part(document, &rate(document))?;
    cubic.real_gain(&matrix(&document["observer"]["S"], random), document, &rate(document), random)
}

pub(super) fn observer(document: &Value, random: &mut Random) -> Found {
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
pub(super) fn unknown_input(document: &Value, random: &mut Random) -> Found {
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

pub(super) fn feedback(document: &Value, random: &mut Random) -> Found {
    observer(document, random)?;
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
