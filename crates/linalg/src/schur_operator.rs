//! Common part of the Lyapunov equation `A'P + PA + Q = 0` and the Stein equation `A'PA - P + Q = 0`: with the real
//! Schur form `A = U T U'` each is one substitution with T per right-hand side.
//!
//! **Separation.** For stable A the inverse of the operator maps positive semidefinite matrices to positive
//! semidefinite ones, so its norm (spectral norm of X over that of the right-hand side) is attained at the identity: it
//! is `||H||_2` with `H = integral of e^(A't) e^(At)`, or `sum of A'^k A^k` (Russo and Dye; Hewer and Kenney, SIAM J.
//! Control 26, 1988; Gahinet, Laub, Kenney and Hewer, IEEE TAC 35, 1990). This takes one more substitution. For
//! unstable A the separation is estimated from above by a few substitutions.

use crate::argument::{shaped, square, symmetric, symmetric_into, unit_scale};
use crate::balance::{Balance, sizes};
use crate::compensated;
use crate::error_estimate::{self, DIGIT, RATE, Standing};
use crate::exactly_singular::{Regularity, regularity};
use crate::forward_error::{ErrorScale, forward_error, relative};
use crate::product::{mirror, multiply, multiply_upper, view, view_mut};
use crate::schur::block_eigenvalues;
use crate::separation::{rescale, separation};
use crate::triangular::{self, Coefficient, Equation};
use crate::{LinalgError, Result, Schur, SchurWorkspace, schur_into};
use faer::Accum;
use nalgebra::{Complex, DMatrix};
use std::cell::Cell;

/// The operator `A'X + X A` or `A'X A - X`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Lyapunov,
    Stein,
}

impl Kind {
    pub(crate) fn of_time(discrete: bool) -> Self {
        if discrete { Self::Stein } else { Self::Lyapunov }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Lyapunov => "Lyapunov",
            Self::Stein => "Stein",
        }
    }

    fn equation(self) -> Equation {
        match self {
            Self::Lyapunov => Equation::Sylvester,
            Self::Stein => Equation::Stein,
        }
    }

    pub(crate) fn is_stable(self, lambda: Complex<f64>) -> bool {
        match self {
            Self::Lyapunov => lambda.re < 0.0,
            Self::Stein => lambda.norm() < 1.0,
        }
    }

    /// Whether all eigenvalues of a Schur form are on the stable side.
    fn is_stable_form(self, schur: &Schur) -> bool {
        let (t, n) = (&schur.t, schur.t.nrows());
        let mut k = 0;
        while k < n {
            let size = if k + 1 < n && t[(k + 1, k)] != 0.0 { 2 } else { 1 };
            if !self.is_stable(block_eigenvalues(t, k, size).0) {
                return false;
            }
            k += size;
        }
        true
    }

    /// Upper bound of the norm of the operator.
    pub(crate) fn weight(self, size: f64) -> f64 {
        match self {
            Self::Lyapunov => 2.0 * size,
            Self::Stein => size * size + 1.0,
        }
    }

    /// Change of the operator due to rounding of `A`: a separation below this may be zero.
    fn rounding(self, n: usize, size: f64) -> f64 {
        let size = if self == Self::Stein { size.max(1.0) } else { size };
        n as f64 * f64::EPSILON * size
    }
}

/// A backward stable solution has a residual below this, whatever its order.
pub(crate) const DIGITS: f64 = 1e-12;

/// One with a larger residual has left the range of binary64 on its way.
pub(crate) const LOST: f64 = 1e-10;

/// The equation with its Schur form, in scaled units of time (Lyapunov) and, if they were balanced, of the state.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SchurEquation {
    kind: Kind,
    /// A in these units.
    a: DMatrix<f64>,
    size: f64,
    /// `a` is this times the given A. NaN after a failed factorisation: every solution then is an overflow error.
    units: f64,
    balance: Option<Balance>,
    schur: Schur,
    /// Whether all eigenvalues are on the stable side.
    stable: bool,
    /// Separation `min ||operator(X)|| / ||X||` in these units, see the head of this file.
    separation: f64,
    /// If every solution is refined, because rounding might decide it: the factor by which a step reduces the error.
    contraction: Option<f64>,
    /// Whether the separation is at rounding level.
    rounding: bool,
    /// What exact arithmetic says of the equation, computed if the separation is small.
    regularity: Regularity,
    /// Relative error of the last refined solution, in these units.
    refined: Option<f64>,
    work: Work,
}

/// Workspace for a factorisation and a solution; ignored by comparison and not copied.
#[derive(Debug, Default)]
struct Work {
    schur: SchurWorkspace,
    half: DMatrix<f64>,
    scratch: DMatrix<f64>,
    defect: DMatrix<f64>,
}

impl Clone for Work {
    fn clone(&self) -> Self {
        let mut room = Self::default();
        room.reserve(self.half.nrows(), self.scratch.nrows());
        room
    }
}

impl PartialEq for Work {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Work {
    fn reserve(&mut self, n: usize, scratch: usize) {
        for (room, n) in [(&mut self.half, n), (&mut self.scratch, scratch), (&mut self.defect, n)] {
            if room.nrows() != n {
                *room = DMatrix::zeros(n, n);
            }
        }
    }
}

impl SchurEquation {
    fn vacant(kind: Kind) -> Self {
        let (size, units, separation) = (0.0, f64::NAN, f64::NAN);
        let (a, schur, work) = (DMatrix::default(), Schur::default(), Work::default());
        let (balance, stable, contraction, refined) = (None, false, None, None);
        let (rounding, regularity) = (false, Regularity::Unknown);
        Self {
            kind,
            a,
            size,
            units,
            balance,
            schur,
            stable,
            separation,
            contraction,
            rounding,
            regularity,
            refined,
            work,
        }
    }

    pub(crate) fn new(kind: Kind, a: &DMatrix<f64>) -> Result<Self> {
        let mut equation = Self::vacant(kind);
        equation.refactor(a)?;
        Ok(equation)
    }

    /// The equation for `a`, and its solution for the exactly symmetric matrix in `q`, which replaces it, with the
    /// relative residual: in the units that fit both matrices, if they differ by decades.
    pub(crate) fn solved(kind: Kind, a: &DMatrix<f64>, q: &mut DMatrix<f64>) -> Result<(Self, f64)> {
        square("A", a)?;
        if let Some(balance) = Balance::of_weighted(a, q) {
            let (mut equation, mut p) = (Self::vacant(kind), q.clone());
            let solved = equation.factor_in_some_units(a, Some(balance)).and_then(|()| equation.solve_in_place(&mut p));
            // Entries can leave the range of binary64 in these units.
            if let Ok(residual) = solved
                && residual <= DIGITS
            {
                *q = p;
                return Ok((equation, residual));
            }
        }
        let mut equation = Self::new(kind, a)?;
        let residual = equation.solve_in_place(q)?;
        Ok((equation, residual))
    }

    /// The equation for a finite, square `a`, without the test for singularity.
    pub(crate) fn untested(kind: Kind, a: &DMatrix<f64>, balance: Option<Balance>) -> Result<Self> {
        let mut equation = Self::vacant(kind);
        equation.factor(a, balance)?;
        Ok(equation)
    }

    /// Replaces the equation by that for `a`, in the same memory. After an error every solution is an error.
    pub(crate) fn refactor(&mut self, a: &DMatrix<f64>) -> Result<()> {
        let done = square("A", a)
            .and_then(|_| self.factor_in_some_units(a, Balance::worthwhile(a).map(|(balance, _)| balance)));
        if done.is_err() {
            self.units = f64::NAN;
        }
        done
    }

    /// For a square `a`, in these units if they serve.
    fn factor_in_some_units(&mut self, a: &DMatrix<f64>, preferred: Option<Balance>) -> Result<()> {
        if self.kind == Kind::Stein && a.amax() > 2.0_f64.powi(250) {
            return Err(LinalgError::Overflow { what: "the product of entries of a" });
        }
        let given = preferred.is_none();
        let first = self.factor_and_test(a, preferred)?;
        // Units of the state that differ by decades make an equation look singular.
        let mut others = match (first, given) {
            (Standing::Rounding, true) => Some(Balance::of(&sizes(a), None))
                .filter(|balance| !balance.is_trivial())
                .map(Some)
                .into_iter()
                .collect(),
            (Standing::Rounding, false) => vec![None],
            _ => Vec::new(),
        };
        if first == Standing::Clear {
            return Ok(());
        }
        let known = regularity(self.kind.equation(), a, a, true);
        self.regularity = known;
        if known == Regularity::Singular {
            return Err(self
                .kind
                .equation()
                .closest(&self.eigenvalues(), &self.eigenvalues())
                .singular(self.kind.name()));
        }
        if self.contracts() || first == Standing::Doubtful {
            return Ok(());
        }
        let refused = self.undecided();
        // A triangular chain has rows and columns that balancing leaves alone.
        others.extend(Balance::fitted(a).apart().map(Some));
        for balance in others {
            let standing = self.factor_and_test(a, balance)?;
            self.regularity = known;
            if standing == Standing::Clear || self.contracts() || standing == Standing::Doubtful {
                return Ok(());
            }
        }
        Err(refused)
    }

    /// Error: rounding decides whether the equation has a unique solution.
    fn undecided(&self) -> LinalgError {
        let values = self.eigenvalues();
        let n = self.order() as f64;
        self.kind.equation().closest(&values, &values).undecided(
            self.kind.name(),
            self.regularity,
            self.separation(),
            self.condition(),
            2.0 * n * self.norms(),
        )
    }

    /// Whether refinement converges; if so, every solution is refined.
    fn contracts(&mut self) -> bool {
        self.contraction = Some(RATE);
        let n = self.order();
        let rate = error_estimate::contraction((n, n), true, |q, p| self.correction(q, p));
        self.contraction = (rate <= RATE).then_some(rate);
        self.contraction.is_some()
    }

    fn factor(&mut self, a: &DMatrix<f64>, balance: Option<Balance>) -> Result<()> {
        let n = a.nrows();
        self.units = if self.kind == Kind::Lyapunov { unit_scale(a) } else { 1.0 };
        if self.a.shape() != a.shape() {
            self.a = DMatrix::zeros(n, n);
        }
        self.a.copy_from(a);
        self.a *= self.units;
        self.size = self.a.norm();
        // Only the substitution for the Stein equation needs the second workspace.
        self.work.reserve(n, if self.kind == Kind::Stein { n } else { 0 });
        schur_into(&self.a, &mut self.schur, &mut self.work.schur)?;
        self.stable = self.kind.is_stable_form(&self.schur);
        (self.balance, self.separation) = (balance, f64::NAN);
        (self.contraction, self.refined, self.regularity) = (None, None, Regularity::Unknown);
        Ok(())
    }

    /// The given `a`, in these units.
    fn factor_and_test(&mut self, a: &DMatrix<f64>, balance: Option<Balance>) -> Result<Standing> {
        let balanced = balance.as_ref().map(|balance| balance.similar(a));
        self.factor(balanced.as_ref().unwrap_or(a), balance)?;
        self.rounding = false;
        let (n, kind) = (a.nrows(), self.kind);
        let (separation, regular) = if self.stable {
            let Work { half: h, scratch, .. } = &mut self.work;
            h.fill(0.0);
            h.fill_diagonal(-1.0);
            let t = Coefficient::plain(view(&self.schur.t));
            let regular = triangular::solve_symmetric(kind.equation(), t, view_mut(h), scratch.as_mut_slice());
            // The Frobenius norm is at most sqrt(n) times the spectral norm, so the separation is not overestimated.
            (1.0 / h.norm(), regular)
        } else {
            self.estimated_separation()
        };
        self.separation = separation;
        let floor = kind.rounding(n, self.size) / (n as f64).sqrt();
        if n == 0 {
            return Ok(Standing::Clear);
        }
        if !regular || separation.is_nan() || separation <= floor {
            self.rounding = true;
            return Ok(Standing::Rounding);
        }
        let spread = ErrorScale { norms: self.norms(), units: 1.0, refined: None };
        let bound = forward_error(0.0, self.condition(), n, spread);
        Ok(if bound <= DIGIT { Standing::Clear } else { Standing::Doubtful })
    }

    /// Estimate from above of `min ||operator(X)||_1 / ||X||_1` (entries summed, in the coordinates of the Schur form),
    /// and whether every pivot is regular.
    fn estimated_separation(&self) -> (f64, bool) {
        let (n, equation) = (self.a.nrows(), self.kind.equation());
        let (plain, transposed) =
            (Coefficient::plain(view(&self.schur.t)), Coefficient::transposed(view(&self.schur.t)));
        let regular = Cell::new(true);
        let solve = |s, t, d: &mut DMatrix<f64>| {
            let mut work = vec![0.0; if self.kind == Kind::Stein { n * n } else { 0 }];
            regular.set(triangular::solve(equation, s, t, view_mut(d), &mut work) && regular.get());
        };
        let found = separation(n, n, |d| solve(transposed, plain, d), |d| solve(plain, transposed, d));
        (found, regular.get())
    }

    pub(crate) fn order(&self) -> usize {
        self.a.nrows()
    }

    /// In the units of the given A, except for balanced units of the state.
    pub(crate) fn separation(&self) -> f64 {
        self.separation / self.units
    }

    pub(crate) fn estimated_separation_in_units(&self) -> f64 {
        self.estimated_separation().0 / self.units
    }

    pub(crate) fn condition(&self) -> f64 {
        self.kind.weight(self.size) / self.separation
    }

    pub(crate) fn eigenvalues(&self) -> Vec<Complex<f64>> {
        self.schur.eigenvalues().iter().map(|lambda| lambda / self.units).collect()
    }

    pub(crate) fn is_stable(&self) -> bool {
        self.stable
    }

    /// Solves for `q`, n x n and symmetric up to rounding, into `p`; returns the relative residual. Nothing is
    /// allocated if `p` has the right shape and the state is not balanced.
    pub(crate) fn solve_into(&mut self, q: &DMatrix<f64>, p: &mut DMatrix<f64>) -> Result<f64> {
        let n = self.order();
        if q.shape() != (n, n) {
            return Err(LinalgError::DimensionMismatch { what: "Q", expected: (n, n), found: q.shape() });
        }
        if p.shape() != (n, n) {
            *p = DMatrix::zeros(n, n);
        }
        symmetric_into("Q", q, p)?;
        self.solve_in_place(p)
    }

    /// As [`solve_into`](Self::solve_into), for the finite and exactly symmetric matrix of order n in `p`.
    pub(crate) fn solve_in_place(&mut self, p: &mut DMatrix<f64>) -> Result<f64> {
        let n = self.order();
        if let Some(balance) = &self.balance {
            *p = balance.form(p);
        }
        let units_q = unit_scale(p);
        *p *= units_q;
        let size_q = p.norm();
        self.work.defect.copy_from(p);
        self.substitute(p);
        if let Some(rate) = self.contraction {
            let weight = self.work.defect.clone();
            let substituted = p.clone();
            self.refined = error_estimate::refined(p, rate, |p| self.correction(&weight, p));
            if self.refined.is_none() {
                if self.rounding {
                    return Err(self.undecided());
                }
                p.copy_from(&substituted);
            }
        }
        // Upper triangle of the defect A'P + PA + Q or A'PA - P + Q.
        let Work { half: image, defect, .. } = &mut self.work;
        multiply(view_mut(image), Accum::Replace, 1.0, view(p), view(&self.a));
        match self.kind {
            Kind::Lyapunov => {
                for j in 0..n {
                    for i in 0..=j {
                        defect[(i, j)] += image[(i, j)] + image[(j, i)];
                    }
                }
            }
            Kind::Stein => {
                multiply_upper(view_mut(defect), Accum::Add, 1.0, view(&self.a).transpose(), view(image));
                for j in 0..n {
                    for i in 0..=j {
                        defect[(i, j)] -= p[(i, j)];
                    }
                }
            }
        }
        mirror(view_mut(defect));
        let residual = relative(defect.norm(), self.kind.weight(self.size) * p.norm() + size_q);
        rescale(p, self.units, units_q);
        if let Some(balance) = &self.balance {
            *p = balance.form_back(p);
        }
        if residual.is_nan() || residual > LOST || p.iter().any(|e| !e.is_finite()) {
            return Err(LinalgError::Overflow { what: "the solution p" });
        }
        Ok(residual)
    }

    /// One step of iterative refinement of `p`, with the defect computed in twice the working precision; returns the
    /// size of the correction relative to `p`. A correction as large as `p` is not applied: no digit would be correct.
    pub(crate) fn refine(&mut self, q: &DMatrix<f64>, p: &mut DMatrix<f64>) -> Result<f64> {
        let n = self.order();
        shaped("Q", q, n, n)?;
        shaped("P", p, n, n)?;
        let (mut weight, mut x) = (symmetric("Q", q)?, symmetric("P", p)?);
        if let Some(balance) = &self.balance {
            (weight, x) = (balance.form(&weight), balance.form(&x));
        }
        let units_q = unit_scale(&weight);
        weight *= units_q;
        rescale(&mut x, units_q, self.units);
        let correction = self.correction(&weight, &x);
        let moved = relative(correction.norm(), x.norm());
        if moved >= 1.0 {
            return Ok(moved);
        }
        x += correction;
        rescale(&mut x, self.units, units_q);
        if let Some(balance) = &self.balance {
            x = balance.form_back(&x);
        }
        if moved.is_nan() || x.iter().any(|e| !e.is_finite()) {
            return Err(LinalgError::Overflow { what: "the correction of p" });
        }
        p.copy_from(&x);
        Ok(moved)
    }

    /// Correction of `p`: the solution for its defect.
    fn correction(&mut self, q: &DMatrix<f64>, p: &DMatrix<f64>) -> DMatrix<f64> {
        let mut correction = self.precise_defect(q, p);
        self.substitute(&mut correction);
        correction
    }

    /// `A'P + PA + Q` or `A'PA - P + Q`, each entry rounded once.
    fn precise_defect(&self, q: &DMatrix<f64>, p: &DMatrix<f64>) -> DMatrix<f64> {
        let n = self.order();
        let (image, rest) = compensated::product(p, &self.a);
        let mut defect = match self.kind {
            Kind::Lyapunov => DMatrix::from_fn(n, n, |i, j| {
                compensated::sum(&[q[(i, j)], image[(i, j)], image[(j, i)], rest[(i, j)], rest[(j, i)]])
            }),
            Kind::Stein => {
                let (high, mut low) = compensated::product(&self.a.transpose(), &image);
                low += self.a.tr_mul(&rest);
                DMatrix::from_fn(n, n, |i, j| compensated::sum(&[q[(i, j)], high[(i, j)], -p[(i, j)], low[(i, j)]]))
            }
        };
        mirror(view_mut(&mut defect));
        defect
    }

    /// Factors from the separation's norm and units to the relative error of the solution `p`.
    pub(crate) fn spread(&self, p: &DMatrix<f64>) -> ErrorScale {
        let units = self.balance.as_ref().map_or(1.0, |balance| balance.growth(p));
        ErrorScale { norms: self.norms(), units, refined: self.refined }
    }

    /// Factor from the norm of the separation to the Frobenius norm.
    fn norms(&self) -> f64 {
        let n = self.order() as f64;
        if self.stable { n.sqrt() } else { 3.0 * n }
    }

    /// Replaces the symmetric right-hand side `q` in `p` by the symmetric solution. Returns whether the equation is
    /// regular.
    fn substitute(&mut self, p: &mut DMatrix<f64>) -> bool {
        let (u, t) = (view(&self.schur.q), view(&self.schur.t));
        let Work { half, scratch, .. } = &mut self.work;
        // Y = -U'Q U, substitution, and back: P = U Y U'.
        multiply(view_mut(half), Accum::Replace, 1.0, view(p), u);
        multiply_upper(view_mut(p), Accum::Replace, -1.0, u.transpose(), view(half));
        let regular = triangular::solve_symmetric(
            self.kind.equation(),
            Coefficient::plain(t).exact(self.contraction.is_some()),
            view_mut(p),
            scratch.as_mut_slice(),
        );
        multiply(view_mut(half), Accum::Replace, 1.0, u, view(p));
        multiply_upper(view_mut(p), Accum::Replace, 1.0, view(half), u.transpose());
        mirror(view_mut(p));
        regular
    }

    /// Solution for a symmetric `q` without residual, in units of the given A and of the balanced state; `None` if the
    /// equation is singular to working precision.
    pub(crate) fn substituted(&mut self, q: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let mut p = q * self.units;
        let regular = self.substitute(&mut p);
        (regular && p.iter().all(|e| e.is_finite())).then_some(p)
    }

    /// Solution for one symmetric `q`, without residual and condition; `None` if the equation is singular to working
    /// precision.
    pub(crate) fn step(kind: Kind, a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<Option<DMatrix<f64>>> {
        Ok(Self::untested(kind, a, None)?.substituted(q))
    }
}
