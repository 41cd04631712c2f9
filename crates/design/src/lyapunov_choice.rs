//! The Lyapunov matrix of a given stable matrix F: the first of a short list that is proved.
//!
//! Every stable F has a P, but not every right-hand side Q gives one that binary64 can hold: in unsuitable units the
//! rounding of its largest entries exceeds `v'Qv` for some v. That a P fails says nothing about F, so others are tried:
//!
//! 1. `Q = I` in the coordinates of the user, whose P the theorems on costs know;
//! 2. `Q = I` in coordinates `x = D z`, D of powers of two: those in which F is balanced (Osborne, J. ACM 7, 1960), and
//!    then those in which the P found has the diagonal 1;
//! 3. in the same coordinates, the P with half of the decay of F: `Q = I + 2 a P`, or `F/s` with `Q = I` in discrete
//!    time, so that the smallest eigenvalues of P are proved as well as the largest;
//! 4. `P = T'T` for modal coordinates, `T F T^-1` block diagonal.
//!
//! F is `A - L C` rounded once from its exact value, and each solution has a residual correction.

use luenberger_linalg::{
    LyapunovEquation, SteinEquation, balanced, spectral_abscissa, spectral_radius, state_units, symmetric_part,
};
use luenberger_proof::certificate::Certificate;
use luenberger_proof::statement::TimeDomain;
use nalgebra::DMatrix;

use crate::error::DesignError;
use crate::modal;
use crate::powers::Powers;

/// How often the coordinates are taken from the diagonal of the last P.
const ROUNDS: usize = 3;

/// Whether binary64 can solve equations with P, as the gain of a cubic term needs it: exact arithmetic may prove a P
/// whose smallest eigenvalue is in the rounding of its entries.
fn is_regular(p: &DMatrix<f64>) -> bool {
    p.clone().cholesky().is_some()
}

/// The first P that `certify` proves and that is [regular](is_regular): `first`, or one of the list in the head.
/// `first` if none is.
pub(crate) fn proved_or_first(
    time: TimeDomain,
    f: &DMatrix<f64>,
    first: Result<DMatrix<f64>, DesignError>,
    mut certify: impl FnMut(&DMatrix<f64>) -> Result<Certificate, DesignError>,
) -> Result<(DMatrix<f64>, Certificate), DesignError> {
    let plain = first.and_then(|p| certify(&p).map(|certificate| (p, certificate)));
    if plain.as_ref().is_ok_and(|(p, certificate)| certificate.is_proved() && is_regular(p)) {
        return plain;
    }
    let found = others(time, f, |p| match certify(p) {
        Ok(certificate) if certificate.is_proved() && is_regular(p) => Some(certificate),
        _ => None,
    });
    found.map_or(plain, Ok)
}

/// The first P of the list behind `Q = I` for which `accept` has a value, with that value.
pub(crate) fn others<T>(
    time: TimeDomain,
    f: &DMatrix<f64>,
    mut accept: impl FnMut(&DMatrix<f64>) -> Option<T>,
) -> Option<(DMatrix<f64>, T)> {
    let mut of = |p: Option<DMatrix<f64>>| {
        let p = p.filter(|p| p.iter().all(|x| x.is_finite()))?;
        let value = accept(&p)?;
        Some((p, value))
    };
    for units in coordinates(time, f) {
        let plain = Equation::new(time, f, &units, false).and_then(|mut equation| equation.of_identity());
        let slower = || Equation::new(time, f, &units, true).and_then(|mut equation| equation.of_identity());
        if let Some(found) = of(plain).or_else(|| of(slower())) {
            return Some(found);
        }
    }
    let units = coordinates(time, f).pop()?;
    let t = modal::in_units(&units.similar(f)).ok()?.0;
    of(Some(units.form_back(&symmetric_part(&(t.transpose() * t)))))
}

/// Coordinates in which F and its P are of moderate size, the balanced ones first, of F with and without its isolated
/// states.
pub(crate) fn coordinates(time: TimeDomain, f: &DMatrix<f64>) -> Vec<Powers> {
    let (Ok(found), Ok(fitted)) = (balanced(f), state_units(f)) else { return Vec::new() };
    let mut powers = vec![0; f.nrows()];
    for (&state, scale) in found.permutation.iter().zip(&found.scaling) {
        powers[state] = scale.log2().round() as i32;
    }
    let mut all = vec![Powers(fitted), Powers(powers)];
    for _ in 0..ROUNDS {
        let last = &all[all.len() - 1];
        let Some(p) = Equation::new(time, f, last, false).and_then(|mut equation| equation.of_identity()) else {
            break;
        };
        let next = Powers(p.diagonal().iter().map(|x| (-0.5 * x.log2()).round() as i32).collect());
        if next == *last || p.diagonal().iter().any(|x| !(*x > 0.0 && x.is_finite())) {
            break;
        }
        all.push(next);
    }
    all
}

/// `F'P + P F + Q = 0`, or `F'P F - P + Q = 0`, in coordinates `x = D z`.
pub(crate) struct Equation {
    f: DMatrix<f64>,
    solver: Solver,
    units: Powers,
}

/// `F'P + P F + Q = 0`, or `F'P F - P + Q = 0`.
pub(crate) enum Solver {
    Lyapunov(Box<LyapunovEquation>),
    Stein(Box<SteinEquation>),
}

impl Solver {
    pub(crate) fn new(time: TimeDomain, f: &DMatrix<f64>) -> Option<Self> {
        Some(match time {
            TimeDomain::Continuous => Self::Lyapunov(Box::new(LyapunovEquation::new(f).ok()?)),
            TimeDomain::Discrete => Self::Stein(Box::new(SteinEquation::new(f).ok()?)),
        })
    }

    pub(crate) fn solve(&mut self, q: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        match self {
            Self::Lyapunov(equation) => equation.solve(q).map(|found| found.p).ok(),
            Self::Stein(equation) => equation.solve(q).map(|found| found.p).ok(),
        }
    }
}

impl Equation {
    /// The equation of F or, with `slower`, of F with half of its decay.
    pub(crate) fn new(time: TimeDomain, f: &DMatrix<f64>, units: &Powers, slower: bool) -> Option<Self> {
        let mut f = units.similar(f);
        if f.iter().any(|x| !x.is_finite()) {
            return None;
        }
        if slower {
            match time {
                TimeDomain::Continuous => {
                    let half = -0.5 * spectral_abscissa(&f).ok()?;
                    f += DMatrix::identity(f.nrows(), f.nrows()) * half.max(0.0);
                }
                TimeDomain::Discrete => f /= 0.5 * (1.0 + spectral_radius(&f).ok()?.min(1.0)),
            }
        }
        let solver = Solver::new(time, &f)?;
        Some(Self { f, solver, units: units.clone() })
    }

    /// P for `Q = I` in the coordinates D, as a form in those of the user.
    pub(crate) fn of_identity(&mut self) -> Option<DMatrix<f64>> {
        let n = self.f.nrows();
        let p = self.solve(&DMatrix::identity(n, n))?;
        Some(self.units.form_back(&p))
    }

    /// P for `Q = H'H`, H in the coordinates of the user, as a form in those of the user.
    pub(crate) fn of_output(&mut self, h: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let h = self.units.columns(h);
        let p = self.solve(&symmetric_part(&(h.transpose() * h)))?;
        Some(self.units.form_back(&p))
    }

    /// The solution with one residual correction.
    fn solve(&mut self, q: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let p = self.solver.solve(q)?;
        let residual = match self.solver {
            Solver::Lyapunov(_) => {
                let half = &p * &self.f;
                &half + half.transpose() + q
            }
            Solver::Stein(_) => self.f.transpose() * &p * &self.f - &p + q,
        };
        Some(match self.solver.solve(&symmetric_part(&residual)) {
            Some(correction) if correction.iter().all(|x| x.is_finite()) => symmetric_part(&(p + correction)),
            _ => p,
        })
    }
}
