//! A Riccati equation in units in which its terms are of comparable size.
//!
//! With `x = D z` for a diagonal `D` (see `balance`), `X = rho D^-1 X^ D^-1`, each input in other units and, in
//! continuous time, time in units of `1/tau`, the equation keeps its form. `rho` is chosen so that `rho G` and `Q /
//! rho` have equal norms, `G = B R^-1 B'` (Kenney, Laub and Wette, Systems and Control Letters 12, 1989). All scales
//! are powers of two, hence exact, and are stored as exponents, so that even `R = 1e-300` loses no digits.

use super::input_weight::InputWeight;
use crate::argument::{shaped, square, symmetric, symmetric_part, unit_scale};
use crate::balance::{Balance, sizes};
use crate::definite::{in_units, positive_definite, positive_semidefinite, unit_diagonal};
use crate::forward_error::relative;
use crate::product::{multiply, view, view_mut};
use crate::separation::norm;
use crate::units::shift;
use crate::{LinalgError, Result};
use faer::Accum;
use nalgebra::DMatrix;

/// The scaled data, with the factors that take `K^` and `X^` to the user's units.
pub(super) struct Scaled {
    pub(super) discrete: bool,
    pub(super) a: DMatrix<f64>,
    pub(super) b: DMatrix<f64>,
    pub(super) q: DMatrix<f64>,
    pub(super) r: DMatrix<f64>,
    r_factor: InputWeight,
    /// `B R^-1 B'`.
    pub(super) g: DMatrix<f64>,
    /// `x = D z`.
    balance: Balance,
    /// `u = diag(2^inputs) v`.
    inputs: Vec<i32>,
    /// `K = k_units diag(2^inputs) K^ D^-1`.
    k_units: f64,
    /// `X = x_units D^-1 X^ D^-1`.
    x_units: f64,
    /// `A^ = time A`.
    pub(super) time: f64,
}

/// Requirement on Q and R.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Weight {
    /// A cost: Q positive semidefinite, R positive definite.
    Semidefinite,
    /// Symmetric, possibly indefinite, R regular.
    Symmetric,
}

/// Data of an equation in the user's units.
#[derive(Clone, Copy)]
pub(super) struct Data<'m> {
    pub(super) a: &'m DMatrix<f64>,
    pub(super) b: &'m DMatrix<f64>,
    pub(super) q: &'m DMatrix<f64>,
    pub(super) r: &'m DMatrix<f64>,
    pub(super) weight: Weight,
}

/// Half of the binary digits of a double.
const HALF_OF_THE_DIGITS: f64 = 26.0;

fn power(exponent: f64) -> f64 {
    2.0_f64.powi(exponent.clamp(-2000.0, 2000.0) as i32)
}

impl Scaled {
    pub(super) fn new(data: &Data<'_>, discrete: bool) -> Result<Self> {
        let Data { a, b, q, r, weight } = *data;
        if discrete && a.amax() > power(100.0) {
            return Err(LinalgError::Overflow { what: "the powers of a" });
        }
        let n = square("A", a)?;
        let m = b.ncols();
        shaped("B", b, n, m)?;
        shaped("Q", q, n, n)?;
        shaped("R", r, m, m)?;
        let q = match weight {
            Weight::Semidefinite => positive_semidefinite("Q", q)?,
            Weight::Symmetric => symmetric("Q", q)?,
        };
        let (r, is_definite) = input_weight(r, weight)?;
        // Each input in units in which its weight is one.
        let inputs = unit_diagonal(&r);
        let r = in_units(&r, &inputs);
        let b = &DMatrix::from_fn(n, m, |i, j| shift(b[(i, j)], inputs[j]));
        let (units_b, units_q, units_r) = (unit_scale(b), unit_scale(&q), unit_scale(&r));
        let (b, q, r) = (b * units_b, q * units_q, r * units_r);
        let g = factored(&r, is_definite)?.driven(&b);
        // Binary exponents: G = g 2^of_g and Q = q 2^of_q.
        let of_g = units_r.log2() - 2.0 * units_b.log2();
        let of_q = -units_q.log2();
        let size = |m: &DMatrix<f64>| if m.amax() > 0.0 { Some(m.amax().log2()) } else { None };
        let balance = if is_balanced(a, (&q, of_q), (&g, of_g)) {
            Balance::of(&DMatrix::from_element(n, n, f64::NEG_INFINITY), None)
        } else {
            Balance::of(&sizes(a), Some((&sizes(&q).add_scalar(of_q), &sizes(&g).add_scalar(of_g))))
        };
        let units = (!balance.is_trivial()).then(|| balance.similar(a));
        let a = units.as_ref().unwrap_or(a);
        let (b, q, g) = if balance.is_trivial() {
            (b, q, g)
        } else {
            (balance.driven(&b), balance.form(&q), balance.form_back(&g))
        };
        // If Q or G is zero, the other is scaled to the size of A.
        let of_a = size(a).unwrap_or(0.0);
        let rho = match (size(&g), size(&q)) {
            // If A dominates, the balanced terms would be lost beside it. X is then about A / G on the unstable modes,
            // which must be accurate; on the stable ones it is about Q / A, which Newton's iteration restores.
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
        let weight = power(time - g_exponent);
        if !weight.is_normal() {
            return Err(LinalgError::Overflow { what: "the Riccati equation" });
        }
        let r_factor = factored(&(&r * weight), is_definite)?;
        let problem = Self {
            discrete,
            a: a * power(time),
            b: b * power(time),
            q: q * power(q_exponent + time),
            r: r * weight,
            r_factor,
            g: g * power(g_exponent + time),
            balance,
            inputs,
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

    /// The same equation with another state weight.
    pub(super) fn with_weight(&self, q: DMatrix<f64>) -> Self {
        Self {
            q,
            a: self.a.clone(),
            b: self.b.clone(),
            r: self.r.clone(),
            r_factor: self.r_factor.clone(),
            g: self.g.clone(),
            balance: self.balance.clone(),
            inputs: self.inputs.clone(),
            ..*self
        }
    }

    /// The same equation in other coordinates of the state, with these matrices.
    pub(super) fn in_coordinates(&self, a: DMatrix<f64>, b: DMatrix<f64>, q: DMatrix<f64>) -> Self {
        let g = self.r_factor.driven(&b);
        Self {
            a,
            b,
            q,
            r: self.r.clone(),
            r_factor: self.r_factor.clone(),
            g,
            balance: self.balance.clone(),
            inputs: self.inputs.clone(),
            ..*self
        }
    }

    /// The same equation in discrete time, with an `R + B'X B` of any signs; `None` if R is singular.
    pub(super) fn with_any_signs(&self) -> Option<Self> {
        let r_factor = InputWeight::regular(&self.r).ok()?;
        Some(Self { r_factor, ..self.with_weight(self.q.clone()) })
    }

    /// Whether R, and in discrete time `R + B'X B`, is positive definite; else it is symmetric and regular.
    pub(super) fn is_definite(&self) -> bool {
        self.r_factor.is_definite()
    }

    /// Gain `K^` of `x`; `None` if `R` (discrete: `R + B'X B`) is not positive definite, or for an indefinite R not
    /// regular, to working precision.
    pub(super) fn gain(&self, x: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let bx = self.b.transpose() * x;
        if self.discrete {
            let weight = symmetric_part(&(&self.r + &bx * &self.b));
            Some(self.r_factor.likewise(weight)?.solve(&(bx * &self.a)))
        } else {
            Some(self.r_factor.solve(&bx))
        }
    }

    /// `X` and `K` in the user's units; `None` if they overflow.
    pub(super) fn in_user_units(&self, x: &DMatrix<f64>, k: &DMatrix<f64>) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let x = self.balance.form_back(x) * self.x_units;
        let k = self.balance.gain_back(k) * self.k_units;
        let k = DMatrix::from_fn(k.nrows(), k.ncols(), |i, j| shift(k[(i, j)], self.inputs[i]));
        x.iter().chain(k.iter()).all(|e| e.is_finite()).then_some((x, k))
    }

    /// Factor by which a relative error of `X^` may grow in the user's units, where X is `x`.
    pub(super) fn growth(&self, x: &DMatrix<f64>) -> f64 {
        self.balance.growth(x)
    }

    /// `A - B K`.
    pub(super) fn closed_loop(&self, k: &DMatrix<f64>) -> Result<DMatrix<f64>> {
        let closed = &self.a - &self.b * k;
        if closed.iter().all(|e| e.is_finite()) {
            Ok(closed)
        } else {
            Err(LinalgError::Overflow { what: "the closed loop A - B K" })
        }
    }

    /// Defect of the equation for `x` with its gain `k`, and the sum of the norms of its terms.
    pub(super) fn defect(&self, x: &DMatrix<f64>, k: &DMatrix<f64>) -> (DMatrix<f64>, f64) {
        let n = self.a.nrows();
        let product = |l: &DMatrix<f64>, r: &DMatrix<f64>| {
            let mut d = DMatrix::zeros(n, n);
            multiply(view_mut(&mut d), Accum::Replace, 1.0, view(l).transpose(), view(r));
            d
        };
        if self.discrete {
            let xa = x * &self.a;
            let (axa, cross) = (product(&self.a, &xa), product(&self.b.tr_mul(&xa), k));
            let size = axa.norm() + x.norm() + cross.norm() + self.q.norm();
            (symmetric_part(&(axa - x - cross + &self.q)), size)
        } else {
            let (ax, quadratic) = (product(&self.a, x), product(&self.b.tr_mul(x), k));
            let size = 2.0 * self.a.norm() * x.norm() + quadratic.norm() + self.q.norm();
            let defect = DMatrix::from_fn(n, n, |i, j| {
                let (i, j) = (i.min(j), i.max(j));
                (ax[(i, j)] + ax[(j, i)]) + (self.q[(i, j)] - 0.5 * (quadratic[(i, j)] + quadratic[(j, i)]))
            });
            (defect, size)
        }
    }

    /// Defect relative to the sum of the norms of the terms; NaN if the gain cannot be computed.
    pub(super) fn residual(&self, x: &DMatrix<f64>) -> f64 {
        self.gain(x).map_or(f64::NAN, |k| {
            let (defect, size) = self.defect(x, &k);
            relative(defect.norm(), size)
        })
    }

    /// `R`, for the discrete equation `R + B'X B` with this `b`; `None` as for [`Self::gain`].
    pub(super) fn input_weight(&self, b: &DMatrix<f64>, x: &DMatrix<f64>) -> Option<InputWeight> {
        if self.discrete {
            self.r_factor.likewise(symmetric_part(&(&self.r + b.tr_mul(&(x * b)))))
        } else {
            Some(self.r_factor.clone())
        }
    }

    /// Bound of the defect that the error of a gain `k`, computed with an indefinite R, leaves: `eps |R| |K|^2`. With a
    /// definite R the term `K'R K` of the equation bounds it.
    pub(super) fn defect_of_gain(&self, k: &DMatrix<f64>) -> f64 {
        if self.is_definite() { 0.0 } else { norm(&self.r) * norm(k).powi(2) }
    }
}

/// Whether the first cycle of [`Balance::of`] would change no state, tested without logarithms: for each state, the
/// largest entries of the row of `[A, G]` and of the column of `[A; Q]` are within a factor of four. `q` and `g` come
/// with their binary exponents.
fn is_balanced(a: &DMatrix<f64>, (q, of_q): (&DMatrix<f64>, f64), (g, of_g): (&DMatrix<f64>, f64)) -> bool {
    let n = a.nrows();
    // Larger exponents are left to the general method.
    if of_q.abs().max(of_g.abs()) > 900.0 {
        return false;
    }
    let (unit_q, unit_g) = (power(of_q), power(of_g));
    (0..n).all(|i| {
        let (mut column, mut row) = (0.0_f64, 0.0_f64);
        for j in 0..n {
            if j != i {
                column = column.max(a[(j, i)].abs());
                row = row.max(a[(i, j)].abs());
            }
            column = column.max(q[(j, i)].abs() * unit_q);
            row = row.max(g[(j, i)].abs() * unit_g);
        }
        column > 0.0 && row > 0.0 && row < 4.0 * column && column < 4.0 * row && row.is_normal() && column.is_normal()
    })
}

/// The symmetric R, and whether it is positive definite.
pub(super) fn input_weight(r: &DMatrix<f64>, weight: Weight) -> Result<(DMatrix<f64>, bool)> {
    match positive_definite("R", r) {
        Ok(r) => Ok((r, true)),
        // A singular weight that is semidefinite is named as such.
        Err(LinalgError::NotPositiveDefinite { .. })
            if weight == Weight::Symmetric && positive_semidefinite("R", r).is_err() =>
        {
            Ok((symmetric("R", r)?, false))
        }
        Err(error) => Err(error),
    }
}

/// R factored; its signs are known.
pub(super) fn factored(r: &DMatrix<f64>, is_definite: bool) -> Result<InputWeight> {
    if is_definite {
        // The eigenvalues were found positive before; only rounding can make this fail.
        InputWeight::definite(r.clone()).ok_or(LinalgError::NotPositiveDefinite { what: "R", lambda_min: 0.0 })
    } else {
        InputWeight::regular(r).map_err(|condition| LinalgError::Singular { what: "R", condition })
    }
}
