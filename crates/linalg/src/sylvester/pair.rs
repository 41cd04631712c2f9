//! Common part of the Sylvester equation `A X + X B = C` and its discrete form `A X B - X + C = 0`: with the real Schur
//! forms `A = U S U'`, `B = V T V'` each is one substitution with S and T per right-hand side.
//!
//! **Separation.** Estimated by three substitutions. If the estimate is near the rounding level of a singular equation,
//! the full iteration (`separation.rs`) replaces it: no equation is judged by the three substitutions alone.

use crate::argument::{finite, shaped, square, unit_scale};
use crate::balance::Balance;
use crate::compensated;
use crate::error_estimate::{self, Closest, DIGIT, RATE};
use crate::exactly_singular::{Regularity, regularity};
use crate::forward_error::{ErrorScale, forward_error, relative};
use crate::product::{multiply, view, view_mut};
use crate::schur::{SchurWorkspace, schur_into};
use crate::schur_operator::DIGITS;
use crate::separation::{rescale, separation, separation_by_three};
use crate::triangular::{self, Coefficient, Equation};
use crate::{LinalgError, Result, Schur};
use faer::Accum;
use nalgebra::{Complex, DMatrix};
use std::cell::{Cell, RefCell};

/// The full iteration is used if three substitutions give a separation below this multiple of the rounding level. No
/// error of more than a factor of ten has been observed for three substitutions.
const FULL_ITERATION_BELOW: f64 = 1e3;

/// The equation with its Schur forms.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SchurPair {
    equation: Equation,
    /// A and B in the units of the computation. Sylvester: both in the unit of the larger one. Discrete: both of equal
    /// size, with their product as given.
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    /// Powers of two: `a = units_a A`, `b = units_b B` for the given A and B.
    units_a: f64,
    units_b: f64,
    /// Factor of the operator relative to the given one.
    units: f64,
    /// Upper bound of the norm of the operator: `||A|| + ||B||` or `||A|| ||B|| + 1`.
    weight: f64,
    left: Schur,
    right: Schur,
    /// Separation `min ||operator(X)||_1 / ||X||_1`, estimated from above, in these units.
    separation: f64,
    /// If every solution is refined, because rounding might decide it: the factor by which a step reduces the error.
    contraction: Option<f64>,
    /// Whether the separation is at rounding level.
    rounding: bool,
    /// What exact arithmetic says of the equation, computed if the separation is small.
    regularity: Regularity,
    /// Relative error of the last refined solution.
    refined: Option<f64>,
    /// Of the spaces of A and of B, where their units are decades apart: `A = D A^ D^-1`, `X = D X^ D_B^-1`.
    balance: [Option<Balance>; 2],
    half: DMatrix<f64>,
    defect: DMatrix<f64>,
}

/// The equation of the Schur forms, or its adjoint.
#[derive(Debug, Clone, Copy)]
enum Side {
    Plain,
    Adjoint,
}

/// Replaces the right-hand side in `x` by the solution of the equation of the Schur forms. Returns whether every pivot
/// used is regular.
///
/// If the lower rows and the left columns of the right-hand side are zero, so are those of the solution; only the
/// equation of the upper corner of S and the lower corner of T is solved. For the unit matrices of the separation
/// estimate this takes a third of a substitution on average.
fn substitute(
    equation: Equation,
    left: &Schur,
    right: &Schur,
    side: Side,
    exact: bool,
    x: &mut DMatrix<f64>,
    work: &mut [f64],
) -> bool {
    let (s, t) = (view(&left.t), view(&right.t));
    let (n, m) = x.shape();
    if let Side::Adjoint = side {
        let (s, t) = (Coefficient::transposed(s), Coefficient::transposed(t));
        return triangular::solve(equation, s, t, view_mut(x), work);
    }
    let mut rows = (0..n).rfind(|&i| x.row(i).iter().any(|&e| e != 0.0)).map_or(0, |i| i + 1);
    let mut skipped = (0..m).find(|&j| x.column(j).iter().any(|&e| e != 0.0)).unwrap_or(m);
    // Do not split a 2 x 2 block.
    if (1..n).contains(&rows) && s[(rows, rows - 1)] != 0.0 {
        rows += 1;
    }
    if (1..m).contains(&skipped) && t[(skipped, skipped - 1)] != 0.0 {
        skipped -= 1;
    }
    let (s, _, _, _) = s.split_at(rows, rows);
    let (_, _, _, t) = t.split_at(skipped, skipped);
    let (_, corner, _, _) = view_mut(x).split_at_mut(rows, skipped);
    let (s, t) = (Coefficient::plain(s).exact(exact), Coefficient::plain(t).exact(exact));
    triangular::solve(equation, s, t, corner, work)
}

/// Powers of two that scale A and B to the units of the computation.
fn units(equation: Equation, a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<(f64, f64)> {
    let (unit_a, unit_b) = (unit_scale(a), unit_scale(b));
    // A coefficient that is zero or has order zero gets no scale.
    let present = (a.amax() > 0.0, b.amax() > 0.0);
    match equation {
        Equation::Sylvester => {
            let unit = match present {
                (true, true) => unit_a.min(unit_b),
                (true, false) => unit_a,
                _ => unit_b,
            };
            Ok((unit, unit))
        }
        Equation::Stein if present == (true, true) => {
            // Powers of two as exponents: exact, and half their difference does not overflow.
            let (low_a, low_b) = (unit_a.log2() as i32, unit_b.log2() as i32);
            if -(low_a + low_b) > 500 {
                return Err(LinalgError::Overflow { what: "the product of entries of a and b" });
            }
            let shift = (low_a - low_b) / 2;
            Ok((2.0_f64.powi(shift), 2.0_f64.powi(-shift)))
        }
        Equation::Stein => Ok((unit_a, unit_b)),
    }
}

impl SchurPair {
    /// For any right-hand side: in balanced units where these make the coefficients smaller.
    pub(super) fn new(equation: Equation, a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<Self> {
        square("A", a)?;
        square("B", b)?;
        let balance = [a, b].map(|m| Balance::worthwhile(m).map(|(balance, _)| balance));
        Self::balanced(equation, a, b, balance)
    }

    /// The solution for `c` and its residual by `solve`: in the units of all three, since the entries of `c` tell units
    /// from rounding, or where these do not serve for any right-hand side.
    pub(super) fn solved<T>(
        equation: Equation,
        [a, b, c]: [&DMatrix<f64>; 3],
        solve: impl Fn(Self) -> Result<(f64, T)>,
    ) -> Result<T> {
        let (n, m) = (square("A", a)?, square("B", b)?);
        shaped("C", c, n, m)?;
        finite("C", c)?;
        let balance = Balance::of_pair(a, b, c);
        if balance.iter().any(Option::is_some)
            && let Ok((residual, found)) = Self::balanced(equation, a, b, balance).and_then(&solve)
            && residual <= DIGITS
        {
            return Ok(found);
        }
        Self::new(equation, a, b).and_then(solve).map(|(_, found)| found)
    }

    fn balanced(
        equation: Equation,
        given_a: &DMatrix<f64>,
        given_b: &DMatrix<f64>,
        balance: [Option<Balance>; 2],
    ) -> Result<Self> {
        let (n, m) = (given_a.nrows(), given_b.nrows());
        let within = |m: &DMatrix<f64>, balance: &Option<Balance>| {
            balance.as_ref().map_or_else(|| m.clone(), |balance| balance.similar(m))
        };
        let (given_a, given_b) = (&within(given_a, &balance[0]), &within(given_b, &balance[1]));
        let (units_a, units_b) = units(equation, given_a, given_b)?;
        let (a, b) = (given_a * units_a, given_b * units_b);
        let (mut left, mut right, mut workspace) = (Schur::default(), Schur::default(), SchurWorkspace::new());
        schur_into(&a, &mut left, &mut workspace)?;
        schur_into(&b, &mut right, &mut workspace)?;
        let (size_a, size_b) = (a.norm(), b.norm());
        // Change of the operator due to rounding of A and B: a separation below this may be zero.
        let (units, weight, size) = match equation {
            Equation::Sylvester => (units_a, size_a + size_b, size_a + size_b),
            Equation::Stein => (1.0, size_a * size_b + 1.0, (size_a * size_b).sqrt().max(1.0)),
        };
        let floor = n.max(m) as f64 * f64::EPSILON * size;
        let (half, defect, separation) = (DMatrix::zeros(n, m), DMatrix::zeros(n, m), f64::INFINITY);
        let (contraction, unknown, refined) = (None, Regularity::Unknown, None);
        let mut pair = Self {
            equation,
            a,
            b,
            units_a,
            units_b,
            units,
            weight,
            left,
            right,
            separation,
            contraction,
            rounding: false,
            regularity: unknown,
            refined,
            balance,
            half,
            defect,
        };
        let mut regular = pair.estimate_separation();
        if pair.separation.is_nan() || pair.separation <= FULL_ITERATION_BELOW * floor {
            let (separation, too) = pair.whole_estimate();
            (pair.separation, regular) = (separation, regular && too);
        }
        let rounding = !regular || pair.separation.is_nan() || pair.separation <= floor;
        pair.rounding = n * m > 0 && rounding;
        if n * m > 0 && (rounding || error_bound((n, m), 0.0, pair.condition(), (1.0, None)) > DIGIT) {
            pair.regularity = regularity(equation, given_a, given_b, false);
            if pair.regularity == Regularity::Singular {
                return Err(pair.closest().singular(pair.name()));
            }
            if !pair.contracts() && rounding {
                return Err(pair.undecided());
            }
        }
        Ok(pair)
    }

    fn name(&self) -> &'static str {
        match self.equation {
            Equation::Sylvester => "Sylvester",
            Equation::Stein => "discrete Sylvester",
        }
    }

    /// The eigenvalues of the given A and B that are nearest to a singular equation.
    fn closest(&self) -> Closest {
        let values = |form: &Schur, units: f64| -> Vec<Complex<f64>> {
            form.eigenvalues().iter().map(|lambda| lambda / units).collect()
        };
        self.equation.closest(&values(&self.left, self.units_a), &values(&self.right, self.units_b))
    }

    /// Error: rounding decides whether the equation has a unique solution.
    fn undecided(&self) -> LinalgError {
        let (n, m) = self.shape();
        let stretch = 2.0 * n.max(m) as f64 * norms((n, m));
        self.closest().undecided(self.name(), self.regularity, self.separation(), self.condition(), stretch)
    }

    /// Whether refinement converges; if so, every solution is refined.
    fn contracts(&mut self) -> bool {
        self.contraction = Some(RATE);
        let (n, m) = self.shape();
        let rate = error_estimate::contraction((n, m), false, |c, x| self.correction(c, x));
        self.contraction = (rate <= RATE).then_some(rate);
        self.contraction.is_some()
    }

    /// Correction of `x`: the solution for its defect.
    fn correction(&mut self, c: &DMatrix<f64>, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut correction = self.precise_defect(c, x);
        self.substitute(&mut correction);
        correction
    }

    /// Relative error of the last solution, if refinement measured it.
    pub(super) fn refined(&self) -> Option<f64> {
        self.refined
    }

    /// Estimates the separation by three substitutions; returns whether every pivot is regular.
    fn estimate_separation(&mut self) -> bool {
        let Self { equation, left, right, half, defect, .. } = self;
        let (work, regular) = (RefCell::new(defect.as_mut_slice()), Cell::new(true));
        let solve = |side: Side, x: &mut DMatrix<f64>| {
            regular.set(substitute(*equation, left, right, side, false, x, &mut work.borrow_mut()) && regular.get());
        };
        self.separation = separation_by_three(half, |x| solve(Side::Plain, x), |x| solve(Side::Adjoint, x));
        regular.get()
    }

    /// The separation by the full iteration, at most eleven substitutions, and whether every pivot is regular.
    fn whole_estimate(&self) -> (f64, bool) {
        let (n, m) = self.shape();
        let (work, regular) = (RefCell::new(vec![0.0; n * m]), Cell::new(true));
        let solve = |side: Side, x: &mut DMatrix<f64>| {
            let (left, right) = (&self.left, &self.right);
            regular
                .set(substitute(self.equation, left, right, side, false, x, &mut work.borrow_mut()) && regular.get());
        };
        let found = separation(n, m, |x| solve(Side::Plain, x), |x| solve(Side::Adjoint, x));
        (found, regular.get())
    }

    /// To the balanced units of both spaces; with `sign` -1 back.
    fn balance(&self, m: &mut DMatrix<f64>, sign: i32) {
        let [left, right] = &self.balance;
        Balance::between(left.as_ref(), right.as_ref(), m, sign);
    }

    /// By how much the relative error of a solution may be larger in the units given.
    pub(super) fn growth(&self, x: &DMatrix<f64>) -> f64 {
        let [left, right] = &self.balance;
        Balance::growth_between(left.as_ref(), right.as_ref(), x)
    }

    fn shape(&self) -> (usize, usize) {
        (self.a.nrows(), self.b.nrows())
    }

    /// In the units of the given A and B.
    pub(super) fn separation(&self) -> f64 {
        self.separation / self.units
    }

    pub(super) fn separation_estimate(&self) -> f64 {
        self.whole_estimate().0 / self.units
    }

    pub(super) fn condition(&self) -> f64 {
        self.weight / self.separation
    }

    /// Solves for `c` into `x`; returns the relative residual. Nothing is allocated if `x` has the right shape.
    pub(super) fn solve_into(&mut self, c: &DMatrix<f64>, x: &mut DMatrix<f64>) -> Result<f64> {
        let (n, m) = self.shape();
        shaped("C", c, n, m)?;
        if x.shape() != (n, m) {
            *x = DMatrix::zeros(n, m);
        }
        x.copy_from(c);
        self.balance(x, 1);
        let units_c = unit_scale(x);
        x.apply(|x| *x *= units_c);
        let size_c = x.norm();
        self.defect.copy_from(x);
        self.substitute(x);
        if let Some(rate) = self.contraction {
            let c = self.defect.clone();
            let substituted = x.clone();
            self.refined = error_estimate::refined(x, rate, |x| self.correction(&c, x));
            if self.refined.is_none() {
                if self.rounding {
                    return Err(self.undecided());
                }
                x.copy_from(&substituted);
            }
        }
        // Defect C - A X - X B or A X B - X + C.
        let Self { a, b, half, defect, .. } = self;
        match self.equation {
            Equation::Sylvester => {
                multiply(view_mut(defect), Accum::Add, -1.0, view(a), view(x));
                multiply(view_mut(defect), Accum::Add, -1.0, view(x), view(b));
            }
            Equation::Stein => {
                multiply(view_mut(half), Accum::Replace, 1.0, view(a), view(x));
                *defect -= &*x;
                multiply(view_mut(defect), Accum::Add, 1.0, view(half), view(b));
            }
        }
        let residual = relative(self.defect.norm(), self.weight * x.norm() + size_c);
        rescale(x, self.units, units_c);
        self.balance(x, -1);
        if residual.is_nan() || finite("X", x).is_err() {
            return Err(LinalgError::Overflow { what: "the solution x" });
        }
        Ok(residual)
    }

    /// Replaces the right-hand side `c` in `x` by the solution, in the units of the coefficients.
    fn substitute(&mut self, x: &mut DMatrix<f64>) {
        let Self { equation, left, right, half, contraction, .. } = self;
        let (u, v) = (view(&left.q), view(&right.q));
        // The discrete equation is `S Y T - Y = -U'C V`.
        let sign = if *equation == Equation::Stein { -1.0 } else { 1.0 };
        multiply(view_mut(half), Accum::Replace, 1.0, u.transpose(), view(x));
        multiply(view_mut(x), Accum::Replace, sign, view(half), v);
        substitute(*equation, left, right, Side::Plain, contraction.is_some(), x, half.as_mut_slice());
        multiply(view_mut(half), Accum::Replace, 1.0, u, view(x));
        multiply(view_mut(x), Accum::Replace, 1.0, view(half), v.transpose());
    }

    /// One step of iterative refinement of `x`, with the defect computed in twice the working precision; returns the
    /// size of the correction relative to `x`. A correction as large as `x` is not applied: no digit would be correct.
    pub(super) fn refine(&mut self, c: &DMatrix<f64>, x: &mut DMatrix<f64>) -> Result<f64> {
        let (n, m) = self.shape();
        shaped("C", c, n, m)?;
        shaped("X", x, n, m)?;
        let (mut c, mut better) = (c.clone(), x.clone());
        self.balance(&mut c, 1);
        self.balance(&mut better, 1);
        let units_c = unit_scale(&c);
        c *= units_c;
        rescale(&mut better, units_c, self.units);
        let correction = self.correction(&c, &better);
        let moved = relative(correction.norm(), better.norm());
        if moved >= 1.0 {
            return Ok(moved);
        }
        better += correction;
        rescale(&mut better, self.units, units_c);
        self.balance(&mut better, -1);
        if moved.is_nan() || better.iter().any(|e| !e.is_finite()) {
            return Err(LinalgError::Overflow { what: "the correction of x" });
        }
        x.copy_from(&better);
        Ok(moved)
    }

    /// `C - A X - X B` or `A X B - X + C`, each entry rounded once.
    fn precise_defect(&self, c: &DMatrix<f64>, x: &DMatrix<f64>) -> DMatrix<f64> {
        let (n, m) = self.shape();
        let (image, rest) = compensated::product(&self.a, x);
        match self.equation {
            Equation::Sylvester => {
                let (right, more) = compensated::product(x, &self.b);
                DMatrix::from_fn(n, m, |i, j| {
                    compensated::sum(&[c[(i, j)], -image[(i, j)], -right[(i, j)], -rest[(i, j)], -more[(i, j)]])
                })
            }
            Equation::Stein => {
                let (high, mut low) = compensated::product(&image, &self.b);
                low += rest * &self.b;
                DMatrix::from_fn(n, m, |i, j| compensated::sum(&[c[(i, j)], high[(i, j)], -x[(i, j)], low[(i, j)]]))
            }
        }
    }
}

/// Factor from the norm of summed entries to the Frobenius norm, times three for the error of the estimate.
fn norms((n, m): (usize, usize)) -> f64 {
    3.0 * ((n * m) as f64).sqrt()
}

/// Bound of the relative error for an n x m equation, as [`forward_error`].
pub(super) fn error_bound(
    shape: (usize, usize),
    residual: f64,
    condition: f64,
    (units, refined): (f64, Option<f64>),
) -> f64 {
    let spread = ErrorScale { norms: norms(shape), units, refined };
    forward_error(residual, condition, shape.0.max(shape.1), spread)
}
