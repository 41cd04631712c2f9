//! H-infinity filters and bounds by Riccati equations.
//!
//! Let `V = DD' > 0`, `S = ED'`, `A0 = A - S V^-1 C`, `W0 = EE' - S V^-1 S'`. A filter with an H-infinity norm below
//! gamma exists if
//! ```text
//! A0 P + P A0' - P [C; H]' diag(V, -gamma^2 I)^-1 [C; H] P + W0 = 0
//! ```
//! has a stabilizing solution whose gain `L = S V^-1 + P C'V^-1`, that of the central filter, makes `A - LC` stable:
//! then `P >= 0`, and the converse holds if (A0, W0) has no unreachable mode on the stability boundary. In discrete
//! time it is the equation of the same data, with `gamma^2 I - H P H' > 0` in addition, and L has the first columns of
//! its gain.
//!
//! Near the least gamma P can grow without bound. In continuous time `Y = P^-1` then solves
//! ```text
//! -A0'Y - Y A0 - Y W0 Y + C'V^-1 C - H'H/gamma^2 = 0
//! ```
//! P of the certificate of any gain is the solution of its bounded-real equation with a weight s of all states,
//! ```text
//! F'P + P F + H'H + s I + P G G'P/gamma^2 = 0                                 F = A - LC, G = E - LD
//! F'P F - P + H'H + s I + F'P G (gamma^2 I - G'P G)^-1 G'P F = 0              discrete time
//! ```
//! which exists iff the norm of `[H; sqrt(s) I](sI - F)^-1 G` is below gamma; the inequality of the bound then holds
//! with the margin s.
//!
//! Source: K. Nagpal, P. Khargonekar, IEEE Transactions on Automatic Control 36, 1991; B. Hassibi, A. Sayed, T.
//! Kailath, Indefinite-Quadratic Estimation and Control, SIAM 1999.

use luenberger_linalg::{Riccati, care, dare, positive_definite, spectral_abscissa, spectral_radius, symmetric_part};
use luenberger_proof::certificate::Certificate;
use nalgebra::{DMatrix, DVector};

use super::units::Units;
use super::{Measured, Task, TimeDomain};
use crate::powers::shift;

/// How accurately the least gamma is found, relative.
const ACCURACY: f64 = 1e-6;
/// How often the bracket of the least gamma is doubled.
const DOUBLINGS: usize = 40;
/// Binary exponents of `1/sqrt(s)`, relative to `H'H`, from the largest weight.
const WEIGHTS: [i32; 7] = [1, 4, 7, 10, 13, 16, 19];
/// By how much the gamma of the central filter is below the one to prove, relative: a filter whose norm is just below
/// its gamma leaves no room for a proof.
const ROOM: [f64; 3] = [0.0, 0.002, 0.005];

/// A plant and its noise without covariance between states and outputs.
pub(super) struct Uncorrelated {
    /// `A0`.
    pub(super) a: DMatrix<f64>,
    /// `W0`, and without added noise a matrix `E0` with `E0 E0' = W0`.
    pub(super) w: DMatrix<f64>,
    rest: DMatrix<f64>,
    /// `V`.
    pub(super) v: DMatrix<f64>,
    /// `S V^-1`, the part of the noise of the states that the outputs show.
    pub(super) shown: DMatrix<f64>,
}

/// A central filter with a proved bound of its norm.
pub(super) struct CentralFilter {
    pub(super) l: DMatrix<f64>,
    pub(super) p: DMatrix<f64>,
    pub(super) found: Measured,
    pub(super) certificate: Certificate,
}

impl Task<'_> {
    /// With noise of these intensities added to the outputs; `None` if V is not definite.
    pub(super) fn uncorrelated(&self, added: &DVector<f64>) -> Option<Uncorrelated> {
        let (e, d) = (&self.of.e, &self.of.d);
        let added = DMatrix::from_diagonal(added);
        let v = symmetric_part(&(d * d.transpose() + &added));
        let shown = v.clone().cholesky()?.solve(&(d * e.transpose())).transpose();
        let rest = e - &shown * d;
        let w = symmetric_part(&(&rest * rest.transpose() + &shown * &added * shown.transpose()));
        let a = &self.plant.a - &shown * &self.plant.c;
        Some(Uncorrelated { a, w, rest, v, shown })
    }

    fn equation(&self, [a, b, q, r]: [&DMatrix<f64>; 4]) -> Option<Riccati> {
        match self.time {
            TimeDomain::Continuous => care(a, b, q, r),
            TimeDomain::Discrete => dare(a, b, q, r),
        }
        .ok()
    }

    /// The gain of the central filter for this gamma.
    fn central(&self, of: &Uncorrelated, gamma: f64) -> Option<DMatrix<f64>> {
        let (c, h) = (&self.plant.c, &self.of.h);
        let (n, p, r) = (c.ncols(), c.nrows(), h.nrows());
        let square = gamma * gamma;
        let mut seen = DMatrix::zeros(n, p + r);
        seen.columns_mut(0, p).copy_from(&c.transpose());
        seen.columns_mut(p, r).copy_from(&h.transpose());
        let mut weight = DMatrix::from_diagonal_element(p + r, p + r, -square);
        weight.view_mut((0, 0), (p, p)).copy_from(&of.v);
        let Some(found) = self.equation([&of.a.transpose(), &seen, &of.w, &weight]) else {
            return self.by_information(of, square);
        };
        let l = &of.shown + found.k.rows(0, p).transpose();
        let f = self.flow(&l).0;
        let is_stable = match self.time {
            TimeDomain::Continuous => spectral_abscissa(&f).ok()? < 0.0,
            TimeDomain::Discrete => {
                let left = DMatrix::from_diagonal_element(r, r, square) - h * &found.x * h.transpose();
                spectral_radius(&f).ok()? < 1.0 && symmetric_part(&left).cholesky().is_some()
            }
        };
        is_stable.then_some(l)
    }

    /// The same gain in continuous time from `Y = P^-1 > 0`, which stays small where P grows without bound.
    fn by_information(&self, of: &Uncorrelated, square: f64) -> Option<DMatrix<f64>> {
        if self.time == TimeDomain::Discrete {
            return None;
        }
        let (c, h) = (&self.plant.c, &self.of.h);
        let seen = of.v.clone().cholesky()?.solve(c);
        let known = symmetric_part(&(c.transpose() * &seen - h.transpose() * h / square));
        let q = of.rest.ncols();
        let y = care(&-&of.a, &of.rest, &known, &DMatrix::identity(q, q)).ok()?.x;
        Some(&of.shown + positive_definite("Y", &y).ok()?.cholesky()?.solve(&seen.transpose()))
    }

    /// A central filter with a proved norm below gamma: its gain, P, norm and certificate.
    pub(super) fn central_filter(&self, gamma: f64) -> Option<CentralFilter> {
        let of = self.noise()?;
        ROOM.into_iter().find_map(|room| {
            let l = self.central(&of, gamma * (1.0 - room))?;
            let found = self.measured(&l).ok().filter(|found| found.norm < gamma)?;
            let (p, certificate) = self.stored(&l, gamma)?;
            Some(CentralFilter { l, p, found, certificate })
        })
    }

    fn noise(&self) -> Option<Uncorrelated> {
        self.uncorrelated(&DVector::zeros(self.plant.c.nrows()))
    }

    /// The least gamma with a central filter, from above, near the norm `start` of some gain.
    pub(super) fn least_central(&self, start: f64) -> Option<f64> {
        let of = self.noise()?;
        let is_kept = |gamma: f64| self.central(&of, gamma).is_some();
        // The bracket widens from the norm of a gain, which is above the least.
        let mut above = start;
        if !is_kept(above) {
            above *= 1.0 + f64::from(f32::EPSILON);
            if !is_kept(above) {
                return None;
            }
        }
        let mut step = 0.0625;
        let mut below = above * (1.0 - step);
        for _ in 0..DOUBLINGS {
            if !is_kept(below) {
                return Some(self.bisected(&of, below, above));
            }
            above = below;
            step = (2.0 * step).min(0.5);
            below = above * (1.0 - step);
        }
        None
    }

    /// The gamma between `below`, without a central filter, and `above`, with one, from which on there is one.
    fn bisected(&self, of: &Uncorrelated, mut below: f64, mut above: f64) -> f64 {
        while above - below > above * ACCURACY {
            let middle = f64::midpoint(above, below);
            if self.central(of, middle).is_some() {
                above = middle;
            } else {
                below = middle;
            }
        }
        above
    }

    /// P for a gain with a norm below gamma, and the certificate, if that is proved.
    pub(super) fn stored(&self, l: &DMatrix<f64>, gamma: f64) -> Option<(DMatrix<f64>, Certificate)> {
        let (units, [f, g, h], gamma_there) = self.in_units_of(l, gamma);
        let (n, q) = g.shape();
        let seen = symmetric_part(&h.tr_mul(&h));
        let size = seen.amax();
        let weight = DMatrix::from_diagonal_element(q, q, -gamma_there * gamma_there);
        for k in WEIGHTS {
            let all = &seen + DMatrix::from_diagonal_element(n, n, shift(size, -2 * k));
            let Some(found) = self.equation([&f, &g, &all, &weight]) else { continue };
            let p = units.form_back(&found.x);
            if let Ok(certificate) = self.theorem(l, &p, gamma)
                && certificate.is_proved()
            {
                return Some((p, certificate));
            }
        }
        None
    }

    /// F, G, H and gamma in units in which the error of this gain has covariances of about one.
    pub(super) fn in_units_of(&self, l: &DMatrix<f64>, gamma: f64) -> (Units, [DMatrix<f64>; 3], f64) {
        let (f, g) = self.flow(l);
        let units = Units::of_gain(self, l, gamma);
        let time = 2 * units.half_time;
        let (f, g) = (units.state.similar(&f).map(|x| shift(x, time)), units.state.rows(&g).map(|x| shift(x, time)));
        let h = units.state.columns(&self.of.h).map(|x| shift(x, units.size));
        let gamma = shift(gamma, units.size);
        (units, [f, g, h], gamma)
    }
}
