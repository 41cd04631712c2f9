//! What the Lyapunov equation `A'P + PA + Q = 0` and the Stein equation `A'PA - P + Q = 0` share: with the real Schur form `A = U T U'` both
//! become one substitution with T and its flipped transpose, and both are tried again in balanced units before they are called singular.

use crate::argument::symmetric_part;
use crate::balance::{Balance, sizes};
use crate::triangular::{flip_cols, flip_rows, flipped};
use crate::{LinalgError, Result, Schur, schur};
use nalgebra::DMatrix;

/// Solves with two quasi-triangular matrices in place of the right-hand side: `S Y + Y T = D` or `S Y T - Y = D`. False where a pivot vanishes.
pub(crate) type Substitution = fn(&DMatrix<f64>, &DMatrix<f64>, &mut DMatrix<f64>) -> bool;

/// `T'Y + Y T` or `T'Y T - Y` with the quasi-triangular `T` of a Schur form.
pub(crate) struct Operator {
    pub(crate) schur: Schur,
    flipped: DMatrix<f64>,
    substitution: Substitution,
}

impl Operator {
    pub(crate) fn new(a: &DMatrix<f64>, substitution: Substitution) -> Result<Self> {
        let schur = schur(a)?;
        let flipped = flipped(&schur.t);
        Ok(Self { schur, flipped, substitution })
    }

    /// The operator applied to Y equals D, in place.
    pub(crate) fn solve(&self, d: &mut DMatrix<f64>) -> bool {
        flip_rows(d);
        let regular = (self.substitution)(&self.flipped, &self.schur.t, d);
        flip_rows(d);
        regular
    }

    /// The adjoint operator (T for T') applied to Y equals D, in place.
    pub(crate) fn solve_adjoint(&self, d: &mut DMatrix<f64>) {
        flip_cols(d);
        (self.substitution)(&self.schur.t, &self.flipped, d);
        flip_cols(d);
    }

    /// The symmetric solution for the symmetric Q, and whether the equation is regular.
    pub(crate) fn solution(&self, q: &DMatrix<f64>) -> (DMatrix<f64>, bool) {
        let u = &self.schur.q;
        let mut y = -(u.transpose() * q * u);
        let regular = self.solve(&mut y);
        (symmetric_part(&(u * y * u.transpose())), regular)
    }
}

/// The solution alone, for iterations that need no evidence; `None` if the equation is singular to working precision.
pub(crate) fn step(a: &DMatrix<f64>, q: &DMatrix<f64>, substitution: Substitution) -> Result<Option<DMatrix<f64>>> {
    let (p, regular) = Operator::new(a, substitution)?.solution(q);
    Ok((regular && p.iter().all(|e| e.is_finite())).then_some(p))
}

/// `solve(a, q)`; where that is nearly singular, the same in units of the state that balance `a`, with its P brought back: units
/// decades apart look like a singular equation.
pub(crate) fn retried_in_balanced_units<S>(
    a: &DMatrix<f64>,
    q: &DMatrix<f64>,
    solve: impl Fn(&DMatrix<f64>, &DMatrix<f64>) -> Result<S>,
    p_of: impl Fn(&mut S) -> &mut DMatrix<f64>,
) -> Result<S> {
    let plain = solve(a, q);
    if !matches!(plain, Err(LinalgError::NearlySingular { .. })) {
        return plain;
    }
    let balance = Balance::of(&sizes(a), None);
    if balance.is_trivial() {
        return plain;
    }
    let Ok(mut found) = solve(&balance.similar(a), &balance.form(q)) else { return plain };
    let p = p_of(&mut found);
    *p = balance.form_back(p);
    if p.iter().all(|e| e.is_finite()) { Ok(found) } else { plain }
}
