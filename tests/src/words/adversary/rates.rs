//! Claims about the decay of linear error dynamics, decided exactly.

use nalgebra::DMatrix;

use luenberger_study::kinds::DisturbanceSpec;

use super::{Held, Matrices, Subject, Verdict, Wrong, of_sentence, wrong};
use crate::falsify::exact::Exact;
use crate::words::linear;
use crate::words::said::Said;
use crate::words::sentences::{Claim, Sentence};

impl Subject<'_> {
    pub(super) fn decay(&self, sentence: &Sentence, said: &Said, is_discrete: bool) -> Verdict {
        let Some((a, l, c)) = self.error() else { return Ok(Held::Unchecked) };
        let number = if is_discrete { sentence.number(0).unwrap_or(1.0) } else { of_sentence(sentence, 0) };
        stable(&a, &l, &c, number, is_discrete, said)
    }

    pub(super) fn refuted(&self, claim: Claim, sentence: &Sentence) -> Verdict {
        let is_convergence = matches!(claim, Claim::Decay | Claim::WithoutW | Claim::DiscreteDecay);
        let is_norm = matches!(claim, Claim::H2 | Claim::HInfinity);
        let Some((a, l, c)) = self.error() else { return Ok(Held::Unchecked) };
        let is_stable =
            if self.is_discrete() { linear::contracts(&a, &l, &c, 1.0) } else { linear::decays(&a, &l, &c, 0.0) };
        if is_convergence && is_stable == Some(true) {
            return Err(wrong("refuted, and A - LC is stable, exactly".to_owned()));
        }
        if is_norm && is_stable == Some(true) && self.norm(claim, sentence).is_ok_and(|held| held == Held::Computed) {
            return Err(wrong("refuted, and A - LC is stable, exactly, and the norm is below gamma".to_owned()));
        }
        Ok(Held::Computed)
    }

    pub(super) fn disturbance(&self, sentence: &Sentence, said: &Said) -> Verdict {
        let Some(DisturbanceSpec { e, chain, .. }) = self.spec.kind.of() else { return Ok(Held::Unchecked) };
        let (Some(Matrices { a, c, .. }), Some(l)) = (self.matrices(), self.gain()) else { return Ok(Held::Unchecked) };
        let (n, q, order) = (a.nrows(), e.ncols(), chain.unwrap_or(1));
        let size = n + q * order;
        let mut both = DMatrix::zeros(size, size);
        both.view_mut((0, 0), (n, n)).copy_from(&a);
        both.view_mut((0, n), (n, q)).copy_from(e);
        // d+ = d + h d' + .., or d' and so on.
        let part = |later: usize| match self.plant.dt {
            Some(h) => (1..=later).fold(1.0, |part, k| part * h / k as f64),
            None => f64::from(u8::from(later == 1)),
        };
        for (k, i) in (0..order).flat_map(|k| (k..order).map(move |i| (k, i))) {
            (0..q).for_each(|j| both[(n + k * q + j, n + i * q + j)] = part(i - k));
        }
        let mut seen = DMatrix::zeros(c.nrows(), size);
        seen.view_mut((0, 0), (c.nrows(), n)).copy_from(&c);
        let last = sentence.holes.len().saturating_sub(1);
        if self.is_discrete() {
            let factor = sentence.hole(last).rsplit_once(' ').and_then(|(_, factor)| factor.strip_suffix("^k"));
            let factor = factor.and_then(|factor| factor.parse().ok()).unwrap_or(1.0);
            return stable(&both, &l, &seen, factor, true, said);
        }
        stable(&both, &l, &seen, of_sentence(sentence, last), false, said)
    }

    pub(super) fn in_loop(&self) -> Verdict {
        let luenberger_study::signal::Input::Feedback { gain: k, .. } = &self.study.input else {
            return Ok(Held::Unchecked);
        };
        let (Some((a, l, c)), Some(Matrices { b, .. })) = (self.error(), self.matrices()) else {
            return Ok(Held::Unchecked);
        };
        let (a, b, c, l, k) =
            (linear::exact(&a), linear::exact(&b), linear::exact(&c), linear::exact(&l), linear::exact(k));
        let seen = l.times(&c);
        let fed = b.times(&k);
        let both = Exact::blocks(&[vec![a.clone(), fed.negative()], vec![seen.clone(), a.minus(&fed).minus(&seen)]]);
        let found = if self.is_discrete() { both.is_schur() } else { both.is_hurwitz() };
        if !found {
            return Err(wrong("the loop of plant and observer is not stable, exactly".to_owned()));
        }
        Ok(Held::Computed)
    }

    pub(super) fn feedthrough(&self) -> Verdict {
        match self.plant.matrices() {
            Some((.., Some(d))) if d.iter().any(|x| *x != 0.0) => Ok(Held::Computed),
            Some(_) => Err(wrong("D is 0".to_owned())),
            None => Ok(Held::Unchecked),
        }
    }
}

/// A - LC is stable, and the printed rate is no faster than the true one.
pub(super) fn stable(
    a: &DMatrix<f64>,
    l: &DMatrix<f64>,
    c: &DMatrix<f64>,
    printed: f64,
    is_discrete: bool,
    _said: &Said,
) -> Verdict {
    let holds = |slack: f64| {
        if is_discrete {
            linear::contracts(a, l, c, (printed * (1.0 + slack)).max(f64::MIN_POSITIVE))
        } else {
            linear::decays(a, l, c, printed * (1.0 - slack))
        }
    };
    let is_stable = if is_discrete { linear::contracts(a, l, c, 1.0) } else { linear::decays(a, l, c, 0.0) };
    let found = || {
        let closed = a - l * c;
        if is_discrete { linear::radius(&closed) } else { linear::abscissa(&closed) }
    };
    match is_stable {
        None => return Ok(Held::Unchecked),
        Some(false) => return Err(wrong(format!("A - LC is not stable, exactly: {:e}", found()))),
        Some(true) => {}
    }
    // The last digits of a multiple eigenvalue are the square root of those of its matrix.
    if holds(1e-3) == Some(false) && !(is_discrete && printed < 1e-3) {
        return Err(wrong(format!("the rate {printed:e} is not that of A - LC, {:e}", found())));
    }
    if holds(1e-9) == Some(false) && !(is_discrete && printed < 1e-3) {
        return Err(Wrong::Rounded(format!(
            "the printed rate {printed:e} is faster than that of A - LC, {:e}",
            found()
        )));
    }
    Ok(Held::Computed)
}
