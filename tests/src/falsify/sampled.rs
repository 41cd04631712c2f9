//! The adversaries of sampled observers beyond the closed form: the semi-implicit cubic step, and varying periods.

use luenberger_random::Random;
use serde_json::Value;

use super::adversary::{Found, ensure, fall, margin_of, single};
use super::document::{binary64, float_matrix, matrix};
use super::exact::Exact;

/// `(I - s N C)'P(I - s N C) - F'PF`: V before a step minus V after it, of the error d after the cubic part.
fn falls_by(n: &Exact, c: &Exact, p: &Exact, after: &Exact, s: &Exact) -> Exact {
    Exact::identity(p.rows).minus(&n.times(c).scaled(s)).congruent(p).minus(after)
}

/// V falls for s of all sizes, and `V(e) >= (V(d) + V(F d))/2`.
pub(super) fn semi_implicit(document: &Value, random: &mut Random) -> Found {
    let (plant, observer, lyapunov) = (&document["plant"], &document["observer"], &document["lyapunov"]);
    let (a, c) = (matrix(&plant["A"], random), matrix(&plant["C"], random));
    let (l, n) = (matrix(&observer["L"], random), matrix(&observer["N"], random));
    let (p, gain) = (matrix(&lyapunov["P"], random), matrix(&lyapunov["S"], random));
    let said = |what: &'static str| move || format!("false: {what}");
    ensure(single(&observer["period"]).sign() > 0, said("h > 0"))?;
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    let f = a.minus(&l.times(&c));
    let decrease = fall(&f, &p)?;
    margin_of(document, 1, &decrease)?;
    ensure(gain.he().is_semidefinite(), said("S + S' >= 0"))?;
    margin_of(document, 2, &gain.he())?;
    let half = Exact::dyadic(1, 1);
    let corner = p.times(&n).plus(&c.transposed().times(&gain));
    let block =
        Exact::blocks(&[vec![decrease.scaled(&half), corner.clone()], vec![corner.transposed(), n.congruent(&p)]]);
    margin_of(document, 3, &block)?;
    let after = f.congruent(&p);
    let mean = p.plus(&after).scaled(&half);
    for exponent in [-60, -20, -8, -3, -1, 0, 1, 3, 8, 20, 60] {
        let share = Exact::number(random.between(0.5, 2.0) * 2.0_f64.powi(exponent));
        ensure(falls_by(&n, &c, &p, &after, &share).is_positive(), said("V falls at a step of the flow"))?;
        ensure(falls_by(&n, &c, &p, &mean, &share).is_semidefinite(), said("V(e) >= (V(d) + V(Fd))/2"))?;
    }
    ensure(falls_by(&n, &c, &p, &after, &Exact::zeros(1, 1)).is_positive(), said("V falls without the flow"))
}

/// `exp(At)`, by its series, far beyond the digits that decide; `None` where that takes too many terms.
fn exponential(a: &Exact, t: &Exact, size: f64) -> Option<Exact> {
    if size.is_nan() || size >= 12.0 {
        return None;
    }
    let exponent = a.scaled(t);
    let (mut term, mut sum) = (Exact::identity(a.rows), Exact::identity(a.rows));
    // 12^90/90! < 1e-40.
    for degree in 1..=90_i64 {
        let inverse = Exact::rational(1.into(), 0, degree.into());
        term = term.times(&exponent).scaled(&inverse);
        sum = sum.plus(&term);
    }
    Some(sum)
}

/// V falls between corrections at times that are drawn, the ends among them, and over steps of the flow of all sizes.
pub(super) fn varying_periods(document: &Value, random: &mut Random) -> Found {
    let (plant, observer) = (&document["plant"], &document["observer"]);
    let (periods, lyapunov) = (&document["periods"], &document["lyapunov"]);
    let (a, c) = (matrix(&plant["A"], random), matrix(&plant["C"], random));
    let (k, p) = (matrix(&observer["K"], random), matrix(&lyapunov["P"], random));
    let said = |what: &'static str| move || format!("false: {what}");
    let (shortest, longest) = (binary64(&periods["shortest"]), binary64(&periods["longest"]));
    let misses = periods["misses"].as_i64().unwrap_or(-1);
    let factor = single(&lyapunov["factor"]);
    let one = Exact::number(1.0);
    ensure(shortest > 0.0 && longest >= shortest && misses >= 0, said("0 < shortest <= longest"))?;
    ensure(factor.sign() > 0 && one.minus(&factor).sign() > 0, said("0 < factor < 1"))?;
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    let identity = Exact::identity(p.rows);
    let mut maps = vec![identity.minus(&k.times(&c))];
    let level = p.scaled(&factor.times(&factor));
    match observer["step"].as_str() {
        Some("radial") => {
            let (n, w) = (matrix(&observer["N"], random), single(&observer["w"]));
            ensure(w.sign() > 0, said("w > 0"))?;
            let Some(inverse) = w.solve(&one) else { return Err("false: w > 0".to_owned()) };
            let saturated = identity.plus(&n.times(&c).scaled(&inverse));
            // Between them too, where g w = 3/8.
            let share = Exact::dyadic(3, 3);
            maps.push(saturated.scaled(&share).plus(&maps[0].scaled(&one.minus(&share))));
            maps.push(saturated);
        }
        Some("semi-implicit") => {
            let (n, gain) = (matrix(&observer["N"], random), matrix(&lyapunov["S"], random));
            ensure(gain.he().is_semidefinite(), said("S + S' >= 0"))?;
            let half = Exact::dyadic(1, 1);
            let corner = p.times(&n).plus(&c.transposed().times(&gain));
            let room = p.minus(&level).scaled(&half);
            let block = Exact::blocks(&[vec![room, corner.clone()], vec![corner.transposed(), n.congruent(&p)]]);
            // The last facts, however many there are of the times.
            let facts = document["margins"].as_array().map_or(0, Vec::len);
            margin_of(document, facts.saturating_sub(2), &gain.he())?;
            margin_of(document, facts.saturating_sub(1), &block)?;
            let mean = p.plus(&level).scaled(&half);
            for exponent in [-60, -8, -1, 0, 1, 8, 60] {
                let share = Exact::number(random.between(0.5, 2.0) * 2.0_f64.powi(exponent));
                let room = falls_by(&n, &c, &p, &mean, &share);
                ensure(room.is_semidefinite(), said("V(e) >= (1 + factor^2)/2 V(d)"))?;
            }
        }
        _ => {}
    }
    let size = float_matrix(&plant["A"]).row_iter().map(|row| row.abs().sum()).fold(0.0, f64::max);
    for count in 1..=misses + 1 {
        for at in [0.0, 1.0, random.unit(), random.unit()] {
            // Few digits between, so that the powers stay short.
            let t = if at == 0.0 || at == 1.0 {
                Exact::number(if at == 0.0 { shortest } else { longest })
            } else {
                let t = shortest + at * (longest - shortest);
                Exact::number(f64::from(t as f32).clamp(shortest, longest))
            };
            let Some(motion) = exponential(&a, &t.scaled(&Exact::dyadic(count, 0)), size * longest * count as f64)
            else {
                continue;
            };
            for map in &maps {
                let left = level.minus(&motion.times(map).congruent(&p));
                ensure(left.is_positive(), said("V falls between corrections"))?;
            }
        }
    }
    Ok(())
}
