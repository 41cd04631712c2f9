//! A Riccati equation in units in which its terms are of comparable size.
//!
//! With `x = D z` for a diagonal `D` (see `balance`), `X = rho D^-1 X^ D^-1`, inputs in other units and, in continuous time, time in units of
//! `1/tau`, the equation keeps its form. `rho` is chosen so that
//! `rho G` and `Q / rho` have equal norms, `G = B R^-1 B'` (Kenney, Laub and Wette, Systems and Control Letters 12, 1989). All scales are
//! powers of two, hence exact, and are kept as exponents: `R = 1e-300` is as good as any other unit.

use crate::argument::{shaped, square, symmetric, symmetric_part, unit_scale};
use crate::balance::{Balance, sizes};
use crate::lyapunov::lyapunov_step;
use crate::separation::relative;
use crate::spectrum::eigenvalues_of_symmetric;
use crate::stein::stein_step;
use crate::{LinalgError, Result};
use nalgebra::{Cholesky, DMatrix, Dyn};

/// The scaled data. `gain` and `x` in these units become those of the user by `k_units` and `x_units`.
pub(super) struct Scaled {
    pub(super) discrete: bool,
    pub(super) a: DMatrix<f64>,
    pub(super) b: DMatrix<f64>,
    pub(super) q: DMatrix<f64>,
    pub(super) r: DMatrix<f64>,
    /// `B R^-1 B'`.
    pub(super) g: DMatrix<f64>,
    /// `x = D z`.
    balance: Balance,
    /// `K = k_units K^ D^-1`.
    k_units: f64,
    /// `X = x_units D^-1 X^ D^-1`.
    x_units: f64,
    /// `A^ = time A`.
    pub(super) time: f64,
}

/// In bits.
const HALF_OF_THE_DIGITS: f64 = 26.0;

fn power(exponent: f64) -> f64 {
    2.0_f64.powi(exponent.clamp(-2000.0, 2000.0) as i32)
}

impl Scaled {
    pub(super) fn continuous(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Result<Self> {
        Self::new(a, b, q, r, false)
    }

    pub(super) fn discrete(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Result<Self> {
        let largest = a.amax();
        let problem = Self::new(a, b, q, r, true)?;
        if largest > power(100.0) {
            return Err(LinalgError::Overflow { what: "the powers of a" });
        }
        Ok(problem)
    }

    fn new(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>, discrete: bool) -> Result<Self> {
        let n = square("a", a)?;
        let m = b.ncols();
        shaped("b", b, n, m)?;
        shaped("q", q, n, n)?;
        shaped("r", r, m, m)?;
        let q = symmetric("q", q)?;
        let r = symmetric("r", r)?;
        let (units_b, units_q, units_r) = (unit_scale(b), unit_scale(&q), unit_scale(&r));
        let (b, q, r) = (b * units_b, q * units_q, r * units_r);
        // An eigenvalue below the rounding error of its own computation has no sign.
        let rounding = |m: &DMatrix<f64>| 4.0 * m.nrows() as f64 * f64::EPSILON * m.norm();
        if let Some(&least) = eigenvalues_of_symmetric(&r)?.first()
            && least <= rounding(&r)
        {
            return Err(LinalgError::NotPositiveDefinite { what: "r", lambda_min: least / units_r });
        }
        if let Some(&least) = eigenvalues_of_symmetric(&q)?.first()
            && least < -rounding(&q)
        {
            return Err(LinalgError::NotPositiveSemidefinite { what: "q", lambda_min: least / units_q });
        }
        let factor = cholesky(&r)?;
        let g = weighted_square(&factor, &b);
        // Exponents (base two) of G = g 2^of_g and of Q = q 2^of_q.
        let of_g = units_r.log2() - 2.0 * units_b.log2();
        let of_q = -units_q.log2();
        let size = |m: &DMatrix<f64>| if m.amax() > 0.0 { Some(m.amax().log2()) } else { None };
        let balance = Balance::of(&sizes(a), Some((&sizes(&q).add_scalar(of_q), &sizes(&g).add_scalar(of_g))));
        let a = &balance.similar(a);
        let (b, q, g) = (balance.driven(&b), balance.form(&q), balance.form_back(&g));
        // Where Q or G vanishes, the other is made as large as A.
        let of_a = size(a).unwrap_or(0.0);
        let rho = match (size(&g), size(&q)) {
            // Beside a dominant A the balanced terms would drown. X is then about A / G on the unstable modes, which must not be lost;
            // on the stable ones it is about Q / A, which Newton's iteration restores.
            (Some(g), Some(q)) if of_a - 0.5 * (q + of_q + g + of_g) > HALF_OF_THE_DIGITS => (of_a - g - of_g).round(),
            (Some(g), Some(q)) => (0.5 * (q + of_q - g - of_g)).round(),
            (Some(g), None) => (of_a - g - of_g).round(),
            (None, Some(q)) => (q + of_q - of_a).round(),
            (None, None) => 0.0,
        };
        let (g_exponent, q_exponent) = (of_g + rho, of_q - rho);
        let time = if discrete {
            0.0
        } else {
            let largest = [size(a), size(&g).map(|e| e + g_exponent), size(&q).map(|e| e + q_exponent)];
            -largest.into_iter().flatten().fold(f64::NEG_INFINITY, f64::max).floor()
        };
        let time = if time.is_finite() { time } else { 0.0 };
        let problem = Self {
            discrete,
            a: a * power(time),
            b: b * power(time),
            q: q * power(q_exponent + time),
            r: r * power(time - g_exponent),
            g: g * power(g_exponent + time),
            balance,
            k_units: units_b,
            x_units: power(rho),
            time: power(time),
        };
        let finite = |m: &DMatrix<f64>| m.iter().all(|e| e.is_finite());
        if [&problem.a, &problem.b, &problem.q, &problem.r, &problem.g].into_iter().all(finite) {
            Ok(problem)
        } else {
            Err(LinalgError::Overflow { what: "the Riccati equation" })
        }
    }

    /// The same equation with another weight of the state.
    pub(super) fn with_weight(&self, q: DMatrix<f64>) -> Self {
        Self {
            q,
            a: self.a.clone(),
            b: self.b.clone(),
            r: self.r.clone(),
            g: self.g.clone(),
            balance: self.balance.clone(),
            ..*self
        }
    }

    /// The same equation for the states `T z`.
    pub(super) fn in_coordinates(&self, t: &DMatrix<f64>, inverse: &DMatrix<f64>) -> Self {
        let b = inverse * &self.b;
        let g = match Cholesky::new(self.r.clone()) {
            Some(factor) => weighted_square(&factor, &b),
            None => symmetric_part(&(inverse * &self.g * inverse.transpose())),
        };
        Self {
            a: inverse * &self.a * t,
            b,
            q: symmetric_part(&(t.tr_mul(&self.q) * t)),
            r: self.r.clone(),
            g,
            balance: self.balance.clone(),
            ..*self
        }
    }

    /// `K^`, or `None` if its normal equations are not definite to working precision.
    pub(super) fn gain(&self, x: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let bx = self.b.transpose() * x;
        if self.discrete {
            let weight = symmetric_part(&(&self.r + &bx * &self.b));
            Some(Cholesky::new(weight)?.solve(&(bx * &self.a)))
        } else {
            Some(Cholesky::new(self.r.clone())?.solve(&bx))
        }
    }

    /// `X` and `K` in the units of the user, if they are within the range of binary64.
    pub(super) fn in_user_units(&self, x: &DMatrix<f64>, k: &DMatrix<f64>) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let x = self.balance.form_back(x) * self.x_units;
        let k = self.balance.gain_back(k) * self.k_units;
        x.iter().chain(k.iter()).all(|e| e.is_finite()).then_some((x, k))
    }

    /// By how much a relative error of `X^` may grow on its way to the user's units, where it is `x`.
    pub(super) fn growth(&self, x: &DMatrix<f64>) -> f64 {
        self.balance.growth(x)
    }

    /// `A - B K`.
    pub(super) fn closed_loop(&self, k: &DMatrix<f64>) -> DMatrix<f64> {
        &self.a - &self.b * k
    }

    /// What `x` leaves of the equation, and the sum of the norms of its terms.
    fn defect(&self, x: &DMatrix<f64>) -> Option<(DMatrix<f64>, f64)> {
        let k = self.gain(x)?;
        let defect = if self.discrete {
            let (axa, cross) = (self.a.transpose() * x * &self.a, self.a.transpose() * x * &self.b * &k);
            let size = axa.norm() + x.norm() + cross.norm() + self.q.norm();
            (axa - x - cross + &self.q, size)
        } else {
            let (ax, quadratic) = (self.a.transpose() * x, x * &self.b * &k);
            let size = 2.0 * self.a.norm() * x.norm() + quadratic.norm() + self.q.norm();
            (&ax + ax.transpose() - quadratic + &self.q, size)
        };
        Some((symmetric_part(&defect.0), defect.1))
    }

    /// `tr(H B R^-1 B')`, for the discrete equation `tr(H B (R + B'X B)^-1 B')`; infinite if that cannot be formed.
    pub(super) fn pull(&self, x: &DMatrix<f64>, h: &DMatrix<f64>) -> f64 {
        let weight =
            if self.discrete { symmetric_part(&(&self.r + self.b.tr_mul(x) * &self.b)) } else { self.r.clone() };
        Cholesky::new(weight).map_or(f64::INFINITY, |factor| factor.solve(&(self.b.tr_mul(h) * &self.b)).trace())
    }

    /// The sum of the norms of the terms of the equation; NaN if it cannot be formed.
    pub(super) fn size_of_terms(&self, x: &DMatrix<f64>) -> f64 {
        self.defect(x).map_or(f64::NAN, |(_, size)| size)
    }

    /// Relative residual; NaN if it cannot be formed.
    pub(super) fn residual(&self, x: &DMatrix<f64>) -> f64 {
        self.defect(x).map_or(f64::NAN, |(defect, size)| relative(defect.norm(), size))
    }

    /// One step of Newton's iteration from a stabilizing `x`, in the form that adds a correction.
    pub(super) fn newton_step(&self, x: &DMatrix<f64>) -> Result<Option<DMatrix<f64>>> {
        let Some(k) = self.gain(x) else { return Ok(None) };
        let Some((defect, _)) = self.defect(x) else { return Ok(None) };
        let closed = self.closed_loop(&k);
        if !closed.iter().chain(defect.iter()).all(|e| e.is_finite()) {
            return Ok(None);
        }
        let correction = if self.discrete { stein_step(&closed, &defect) } else { lyapunov_step(&closed, &defect) }?;
        Ok(correction.map(|d| x + d))
    }
}

fn cholesky(r: &DMatrix<f64>) -> Result<Cholesky<f64, Dyn>> {
    // The eigenvalues were found positive already; only rounding could still object.
    Cholesky::new(r.clone()).ok_or(LinalgError::NotPositiveDefinite { what: "r", lambda_min: 0.0 })
}

/// `B R^-1 B'` as a square, hence positive semidefinite whatever the rounding.
fn weighted_square(factor: &Cholesky<f64, Dyn>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut half = b.transpose();
    factor.l_dirty().solve_lower_triangular_mut(&mut half);
    symmetric_part(&(half.transpose() * half))
}
