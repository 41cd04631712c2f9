//! Certificates of H-infinity and H2 filters of random plants, and attempts to contradict them: the transfer function
//! at frequencies, and the variance from the exact Gramian, both in rational arithmetic.

use luenberger_design::{
    Certified, GainOptions, GeneralizedPlant, NormFilterDesign, NormTarget, SystemNorm, TimeDomain,
};
use luenberger_linalg::{discrete_h_infinity_norm, h_infinity_norm};
use luenberger_proof::certificate::CertificateFile;
use luenberger_random::Random;
use nalgebra::DMatrix;
use serde_json::Value;

use super::adversary::{Found, ensure, fall, margin_of, single};
use super::document::{float_matrix, matrix};
use super::exact::Exact;
use super::seeds::plant;

pub(super) fn h_infinity(random: &mut Random) -> Option<CertificateFile> {
    generate(SystemNorm::HInfinity, random)
}

pub(super) fn h2(random: &mut Random) -> Option<CertificateFile> {
    generate(SystemNorm::H2, random)
}

fn generate(norm: SystemNorm, random: &mut Random) -> Option<CertificateFile> {
    let plant = plant(random, 3)?;
    let (n, p) = (plant.a.nrows(), plant.c.nrows());
    let q = 1 + random.below(2);
    let noise = DMatrix::from_fn(p, q + p, |i, j| if j == q + i { 1.0 } else { 0.0 });
    let mixed = if random.once_in(3) { random.matrix(p, q + p) * 0.3 } else { DMatrix::zeros(p, q + p) };
    let mut e = random.matrix(n, q + p);
    e.columns_mut(q, p).fill(0.0);
    let h = if random.once_in(2) { DMatrix::identity(n, n) } else { random.matrix(1, n) };
    let of = GeneralizedPlant { e, d: noise + mixed, h };
    let time = if random.once_in(2) { TimeDomain::Discrete } else { TimeDomain::Continuous };
    let options = GainOptions::default();
    let found = NormFilterDesign::new(&plant, time, norm, &of, &NormTarget::Least, &options).ok()?;
    let goal = match random.below(3) {
        0 => NormTarget::Least,
        1 => NormTarget::Below(found.gamma * random.between(1.05, 2.0)),
        _ => NormTarget::OfGain(found.l.clone()),
    };
    NormFilterDesign::new(&plant, time, norm, &of, &goal, &options).ok()?.certificate_file("a filter").ok()
}

/// The error system of a document.
struct System {
    is_discrete: bool,
    f: Exact,
    g: Exact,
    h: Exact,
    p: Exact,
    gamma: Exact,
}

impl System {
    fn of(document: &Value, random: &mut Random) -> Self {
        let plant = &document["plant"];
        let l = matrix(&document["observer"]["L"], random);
        let flow =
            |all: &Value, seen: &Value, random: &mut Random| matrix(all, random).minus(&l.times(&matrix(seen, random)));
        Self {
            is_discrete: document["time"] == "discrete",
            f: flow(&plant["A"], &plant["C"], random),
            g: flow(&document["E"], &document["D"], random),
            h: matrix(&document["H"], random),
            p: matrix(&document["lyapunov"]["P"], random),
            gamma: single(&document["gamma"]),
        }
    }

    fn square(&self) -> Exact {
        self.gamma.times(&self.gamma)
    }

    /// P > 0, and F stable: `P - F'PF` or `-(F'P + PF)`.
    fn stable(&self, document: &Value) -> Result<Exact, String> {
        ensure(self.gamma.sign() > 0, || "false: gamma > 0".to_owned())?;
        ensure(self.p.is_positive(), || "false: P > 0".to_owned())?;
        margin_of(document, 0, &self.p)?;
        if self.is_discrete {
            return fall(&self.f, &self.p);
        }
        ensure(self.f.is_hurwitz(), || "false: F is Hurwitz".to_owned())?;
        Ok(self.p.times(&self.f).he().negative())
    }

    /// `gamma^2 I - T*T > 0` at the frequency t, in discrete time at `(1 + jt)/(1 - jt)`, as a real matrix of twice the
    /// order.
    fn is_below_at(&self, t: f64) -> Result<(), String> {
        let (n, q) = (self.f.rows, self.g.cols);
        let (t, one) = (Exact::number(t), Exact::identity(n));
        // (M + jN) x = (a + jb) G w.
        let (m, k, b) = if self.is_discrete {
            (one.minus(&self.f), one.plus(&self.f).scaled(&t), self.g.scaled(&t).negative())
        } else {
            (self.f.negative(), one.scaled(&t), Exact::zeros(n, q))
        };
        let complex =
            |re: &Exact, im: &Exact| Exact::blocks(&[vec![re.clone(), im.negative()], vec![im.clone(), re.clone()]]);
        let Some(state) = complex(&m, &k).solve(&complex(&self.g, &b)) else {
            return Err("an eigenvalue on the boundary".to_owned());
        };
        let none = Exact::zeros(self.h.rows, n);
        let response = complex(&self.h, &none).times(&state);
        let room = Exact::identity(2 * q).scaled(&self.square()).minus(&response.transposed().times(&response));
        ensure(room.is_positive(), || "false: the norm is below gamma, at a frequency".to_owned())
    }
}

pub(super) fn gain_contradicted(document: &Value, random: &mut Random) -> Found {
    let system = System::of(document, random);
    let first = system.stable(document)?.minus(&system.h.transposed().times(&system.h));
    let driven = system.p.times(&system.g);
    let square = Exact::identity(system.g.cols).scaled(&system.square());
    let (corner, last) = if system.is_discrete {
        (system.f.transposed().times(&driven), square.minus(&system.g.congruent(&system.p)))
    } else {
        (driven, square)
    };
    let corner = corner.negative();
    let form = Exact::blocks(&[vec![first, corner.clone()], vec![corner.transposed(), last]]);
    ensure(form.is_positive(), || "false: the inequality in e and w".to_owned())?;
    margin_of(document, 1, &form)?;
    let mut frequencies = vec![0.0, 0.01, 0.3, 1.0, 5.0, 1e3, random.between(0.0, 10.0)];
    let (l, plant) = (float_matrix(&document["observer"]["L"]), &document["plant"]);
    let f = float_matrix(&plant["A"]) - &l * float_matrix(&plant["C"]);
    let g = float_matrix(&document["E"]) - &l * float_matrix(&document["D"]);
    let h = float_matrix(&document["H"]);
    let none = DMatrix::zeros(h.nrows(), g.ncols());
    if f.iter().chain(&g).chain(&h).all(|x| x.abs() < 1e100) {
        let peak = if system.is_discrete {
            discrete_h_infinity_norm(&f, &g, &h, &none).map(|found| (0.5 * found.frequency).tan())
        } else {
            h_infinity_norm(&f, &g, &h, &none).map(|found| found.frequency)
        };
        frequencies.extend(peak.ok().filter(|peak| peak.abs() < 1e12));
    }
    frequencies.into_iter().try_for_each(|frequency| system.is_below_at(frequency))
}

pub(super) fn variance_contradicted(document: &Value, random: &mut Random) -> Found {
    let system = System::of(document, random);
    let seen = system.h.transposed().times(&system.h);
    let first = system.stable(document)?.minus(&seen);
    ensure(first.is_positive(), || "false: the decrease".to_owned())?;
    margin_of(document, 1, &first)?;
    let spent = |w: &Exact| trace(&system.g.congruent(w));
    let room = system.square().minus(&spent(&system.p));
    ensure(room.sign() > 0, || "false: tr G'PG < gamma^2".to_owned())?;
    margin_of(document, 2, &room)?;
    let gramian = gramian(&system, &seen).ok_or("the Gramian is not unique")?;
    ensure(system.square().minus(&spent(&gramian)).sign() > 0, || "false: the variance is below gamma^2".to_owned())
}

fn trace(m: &Exact) -> Exact {
    (0..m.rows).fold(Exact::number(0.0), |sum, i| sum.plus(&m.at(i, i)))
}

/// `F'W + WF + H'H = 0`, or `F'WF - W + H'H = 0`, as n^2 linear equations.
fn gramian(system: &System, seen: &Exact) -> Option<Exact> {
    let (n, f) = (system.f.rows, &system.f);
    let mut equations = Vec::with_capacity(n * n * n * n);
    for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
        for (a, b) in (0..n * n).map(|k| (k / n, k % n)) {
            let one = |equal: bool| Exact::number(if equal { 1.0 } else { 0.0 });
            equations.push(if system.is_discrete {
                f.at(a, i).times(&f.at(b, j)).minus(&one(a == i && b == j))
            } else {
                f.at(a, i).times(&one(b == j)).plus(&one(a == i).times(&f.at(b, j)))
            });
        }
    }
    let right: Vec<Exact> = (0..n * n).map(|k| seen.at(k / n, k % n).negative()).collect();
    let found = Exact::from_numbers(n * n, n * n, &equations).solve(&Exact::from_numbers(n * n, 1, &right))?;
    let entries: Vec<Exact> = (0..n * n).map(|k| found.at(k, 0)).collect();
    Some(Exact::from_numbers(n, n, &entries))
}
