//! Riccati equations with a cross term S of the cost, for descriptor plants `E x' = A x + B u` with E regular, and in
//! discrete time with a singular R.
//!
//! With `z = E x`, `F = A E^-1`, `Q_z = E^-T Q E^-1`, `S_z = E^-T S` the equation is that of a plant in standard form;
//! with `u = v - R^-1 S_z' z` the cross term vanishes, for `F - B R^-1 S_z'` and `Q_z - S_z R^-1 S_z'`. X is the same.
//! In discrete time `X = c I + Y` gives an equation for Y with `R + c B'B` in place of R, and a cross term: this treats
//! a singular R. The result is refined by Newton's iteration on the data as given, and so are residual, condition and
//! error bound computed.

use super::input_weight::InputWeight;
use super::scaled::{Data, Weight, factored, input_weight};
use super::{Riccati, continuous, discrete, double_root, unverified};
use crate::argument::{RealMatrixView, owned, shaped, square, symmetric, symmetric_part};
use crate::balance::{NEARBY, are_near};
use crate::definite::{in_units, positive_definite, positive_semidefinite, unit_diagonal};
use crate::equilibration::Equilibrated;
use crate::forward_error::{of_exact, relative};
use crate::schur_operator::{Kind, SchurEquation};
use crate::separation::norm;
use crate::units::{Units, shift, spread};
use crate::{LinalgError, Result};
use nalgebra::{Complex, DMatrix};

/// Generalised continuous Riccati equation
/// `A'X E + E'X A - (E'X B + S) R^-1 (B'X E + S') + Q = 0`: the stabilizing solution, symmetric.
///
/// `a` and `e` are n x n, `e` regular, `b` and `s` n x m, `q` n x n symmetric (possibly indefinite), `r` m x m
/// symmetric and regular (possibly indefinite, see [`care`](super::care)). The gain of `u = -K x` is
/// `K = R^-1 (B'X E + S')`; the poles are the eigenvalues of the pencil `(A - B K, E)`. If `[Q, S; S', R] >= 0`, it
/// minimises the integral of `x'Q x + 2 x'S u + u'R u` along `E x' = A x + B u`; the cost from x is `x'E'X E x`. The
/// residual is relative to the terms, the condition relative to A, B, Q, R, S and E, all in balanced units of states,
/// equations and inputs. About 500 n^3 flops.
///
/// # Errors
/// Those of [`care`](super::care), with the eigenvalues of `(A, E)` (of `(A - B R^-1 S', E)` for the unweighted ones);
/// [`LinalgError::Singular`] if `e` is singular to working precision.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// // m v' = -d v + u with the cost v^2 + v u + u^2.
/// let (m, d, one, half) = (dmatrix![2.0], dmatrix![-0.5], dmatrix![1.0], dmatrix![0.5]);
/// let found = luenberger_linalg::generalized_care(&d, &one, &one, &one, &half, &m)?;
/// println!("K = {}poles {:?}", found.k, found.poles);
/// // 4 x^2 + 4 x - 0.75 = 0 and K = 2 x + 0.5.
/// assert!((found.k[(0, 0)] - 0.822_875_655_532_295_3).abs() < 1e-15);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Arnold and Laub, Proc. IEEE 72, 1984; the reduction is the definition.
pub fn generalized_care<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
    r: impl Into<RealMatrixView<'a>>,
    s: impl Into<RealMatrixView<'a>>,
    e: impl Into<RealMatrixView<'a>>,
) -> Result<Riccati> {
    Generalized::new(false, [owned(a), owned(b), owned(q), owned(r), owned(s), owned(e)])?.solve()
}

/// Generalised discrete Riccati equation
/// `A'X A - E'X E - (A'X B + S)(R + B'X B)^-1 (B'X A + S') + Q = 0`: the stabilizing solution, symmetric.
///
/// Shapes as [`generalized_care`]; `a` may be singular, and so may a semidefinite `r`, as long as `R + B'X B > 0`. The
/// gain of `u = -K x` is `K = (R + B'X B)^-1 (B'X A + S')`; the poles are the eigenvalues of the pencil `(A - B K, E)`.
/// If `[Q, S; S', R] >= 0`, it minimises the sum of `x'Q x + 2 x'S u + u'R u` along `E x+ = A x + B u`. About 700 n^3
/// flops.
///
/// # Errors
/// As [`generalized_care`]; [`LinalgError::NotPositiveDefinite`] names R, with its smallest eigenvalue, if an input has
/// neither a weight nor an effect on the state.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// // Deadbeat: no weight of the input.
/// let (a, b) = (dmatrix![0.0, 1.0; -0.5, 1.5], dmatrix![0.0; 1.0]);
/// let (zero, one) = (dmatrix![0.0; 0.0], dmatrix![1.0, 0.0; 0.0, 1.0]);
/// let found = luenberger_linalg::generalized_dare(&a, &b, &one, &dmatrix![0.0], &zero, &one)?;
/// println!("X = {}K = {}", found.x, found.k);
/// assert!((found.k - dmatrix![-0.5, 1.5]).amax() < 1e-14);
/// assert!((found.x - dmatrix![1.0, 0.0; 0.0, 2.0]).amax() < 1e-14);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Arnold and Laub, Proc. IEEE 72, 1984; the reduction is the definition.
pub fn generalized_dare<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    q: impl Into<RealMatrixView<'a>>,
    r: impl Into<RealMatrixView<'a>>,
    s: impl Into<RealMatrixView<'a>>,
    e: impl Into<RealMatrixView<'a>>,
) -> Result<Riccati> {
    Generalized::new(true, [owned(a), owned(b), owned(q), owned(r), owned(s), owned(e)])?.solve()
}

/// The equation in balanced units, `q` and `r` exactly symmetric.
#[derive(Clone)]
struct Generalized {
    discrete: bool,
    /// R, or in discrete time `R + B'X B`, is not positive semidefinite.
    is_indefinite: bool,
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    q: DMatrix<f64>,
    r: DMatrix<f64>,
    s: DMatrix<f64>,
    e: DMatrix<f64>,
    /// `E^-1`.
    inverse: DMatrix<f64>,
    /// Powers of two of R and C: E is R times the given E times C, and so on.
    rows: Vec<i32>,
    columns: Vec<i32>,
    /// Powers of two of the inputs.
    inputs: Vec<i32>,
}

/// Symmetric X, its gain, and the defect of the equation.
struct Iterate {
    x: DMatrix<f64>,
    k: DMatrix<f64>,
    defect: DMatrix<f64>,
    /// Sum of the norms of the terms.
    terms: f64,
}

impl Iterate {
    fn residual(&self) -> f64 {
        relative(self.defect.norm(), self.terms)
    }
}

const NEWTON_STEPS: usize = 10;

impl Generalized {
    fn new(discrete: bool, [a, b, q, r, s, e]: [DMatrix<f64>; 6]) -> Result<Self> {
        let (n, m) = (square("A", &a)?, b.ncols());
        shaped("B", &b, n, m)?;
        shaped("Q", &q, n, n)?;
        shaped("R", &r, m, m)?;
        shaped("S", &s, n, m)?;
        shaped("E", &e, n, n)?;
        let (q, r) = (symmetric("Q", &q)?, symmetric("R", &r)?);
        // Equations and states in units in which the rows and columns of E have entries of about one.
        let Equilibrated { matrix: e, rows, columns } = Equilibrated::new(&e);
        let a = DMatrix::from_fn(n, n, |i, j| shift(a[(i, j)], rows[i] + columns[j]));
        let b = DMatrix::from_fn(n, m, |i, j| shift(b[(i, j)], rows[i]));
        let s = DMatrix::from_fn(n, m, |i, j| shift(s[(i, j)], columns[i]));
        let q = in_units(&q, &columns);
        let inverse = e.clone().lu().try_inverse().filter(|m| m.iter().all(|x| x.is_finite()));
        let condition = inverse.as_ref().map_or(f64::INFINITY, |inverse| norm(inverse) * norm(&e));
        let Some(inverse) = inverse.filter(|_| n == 0 || condition * n as f64 * f64::EPSILON < 1.0) else {
            return Err(LinalgError::Singular { what: "E", condition });
        };
        let is_indefinite = positive_semidefinite("R", &r).is_err();
        let equilibrated =
            Self { discrete, is_indefinite, a, b, q, r, s, e, inverse, rows, columns, inputs: vec![0; m] };
        Ok(equilibrated.balanced())
    }

    /// The same equation with balanced states `z = E x` and inputs, as the units of `F = A E^-1` and B fit them.
    fn balanced(self) -> Self {
        let (n, m) = self.b.shape();
        let mut dynamics = DMatrix::zeros(n + m, n + m);
        dynamics.view_mut((0, 0), (n, n)).copy_from(&(&self.a * &self.inverse));
        dynamics.view_mut((0, n), (n, m)).copy_from(&self.b);
        if are_near(dynamics.iter()) && spread(&unit_diagonal(&self.r)) <= NEARBY {
            return self;
        }
        let units = Units::of(&dynamics, &DMatrix::zeros(0, n + m)).state;
        if spread(&units) <= NEARBY && spread(&unit_diagonal(&self.r)) <= NEARBY {
            return self;
        }
        let states = &units[..n];
        // An input in units of its weight, if it has one, else of its effect.
        let weights = unit_diagonal(&self.r);
        let inputs: Vec<i32> = (0..m).map(|j| if self.r[(j, j)] == 0.0 { units[n + j] } else { weights[j] }).collect();
        // The columns of D^-1 E back to entries of about one.
        let row_scaled = |m: &DMatrix<f64>| DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| shift(m[(i, j)], -states[i]));
        let e = row_scaled(&self.e);
        let more: Vec<i32> =
            e.column_iter().map(|column| -(column.amax().log2().round().clamp(-1000.0, 1000.0) as i32)).collect();
        let column_scaled = |m: &DMatrix<f64>, powers: &[i32]| {
            DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| shift(m[(i, j)], powers[j]))
        };
        Self {
            discrete: self.discrete,
            is_indefinite: self.is_indefinite,
            a: column_scaled(&row_scaled(&self.a), &more),
            b: column_scaled(&row_scaled(&self.b), &inputs),
            q: in_units(&self.q, &more),
            r: in_units(&self.r, &inputs),
            s: DMatrix::from_fn(n, m, |i, j| shift(self.s[(i, j)], more[i] + inputs[j])),
            e: column_scaled(&e, &more),
            inverse: DMatrix::from_fn(n, n, |i, j| shift(self.inverse[(i, j)], states[j] - more[i])),
            rows: self.rows.iter().zip(states).map(|(r, d)| r - d).collect(),
            columns: self.columns.iter().zip(&more).map(|(c, d)| c + d).collect(),
            inputs,
        }
    }

    fn solve(&self) -> Result<Riccati> {
        let f = &self.a * &self.inverse;
        let q = symmetric_part(&(self.inverse.tr_mul(&self.q) * &self.inverse));
        let s = self.inverse.tr_mul(&self.s);
        let x = self.without_cross_term(&f, &q, &self.r, &s).or_else(|error| match error {
            LinalgError::NotPositiveDefinite { .. } if self.discrete => self.shifted(&f, &q, &s).ok_or(error)?,
            error => Err(error),
        })?;
        self.refined(x)
    }

    /// The solution for `F`, `Q_z`, `R` and `S_z`.
    fn without_cross_term(
        &self,
        f: &DMatrix<f64>,
        q: &DMatrix<f64>,
        r: &DMatrix<f64>,
        s: &DMatrix<f64>,
    ) -> Result<DMatrix<f64>> {
        let (r, is_definite) = &input_weight(r, Weight::Symmetric)?;
        let gain = factored(r, *is_definite)?.solve(&s.transpose());
        let f = f - &self.b * &gain;
        let q = symmetric_part(&(q - s * gain));
        if !f.iter().chain(q.iter()).all(|x| x.is_finite()) {
            return Err(LinalgError::Overflow { what: "the equation without its cross term" });
        }
        let data = Data { a: &f, b: &self.b, q: &q, r, weight: Weight::Symmetric };
        Ok(if self.discrete { discrete(&data)? } else { continuous(&data)? }.x)
    }

    /// Solution by `X = c I + Y`; `None` if `R + c B'B` is not definite even for a c of the size of X.
    fn shifted(&self, f: &DMatrix<f64>, q: &DMatrix<f64>, s: &DMatrix<f64>) -> Option<Result<DMatrix<f64>>> {
        let n = f.nrows();
        let size = norm(q);
        let c = if size > 0.0 { size } else { 1.0 };
        let r = symmetric_part(&(&self.r + self.b.tr_mul(&self.b) * c));
        positive_definite("R", &r).ok()?;
        let q = symmetric_part(&(q + f.tr_mul(f) * c)) - DMatrix::identity(n, n) * c;
        let s = s + f.tr_mul(&self.b) * c;
        Some(self.without_cross_term(f, &q, &r, &s).map(|y| y + DMatrix::identity(n, n) * c))
    }

    fn iterate(&self, x: DMatrix<f64>) -> Option<Iterate> {
        let seen = if self.discrete { &self.a } else { &self.e };
        let cross = self.b.tr_mul(&x) * seen + self.s.transpose();
        let k = self.weight(&x)?.solve(&cross);
        let quadratic = cross.tr_mul(&k);
        let (linear, size) = if self.discrete {
            let (stepped, held) = (self.a.tr_mul(&x) * &self.a, self.e.tr_mul(&x) * &self.e);
            let size = stepped.norm() + held.norm();
            (stepped - held, size)
        } else {
            let half = self.a.tr_mul(&x) * &self.e;
            let size = 2.0 * half.norm();
            (&half + half.transpose(), size)
        };
        let terms = size + quadratic.norm() + self.q.norm();
        let defect = symmetric_part(&(linear - quadratic + &self.q));
        (defect.iter().all(|d| d.is_finite()) && terms.is_finite()).then_some(Iterate { x, k, defect, terms })
    }

    /// `R` (continuous) or `R + B'X B` (discrete); `None` if it is not definite, or for an indefinite R not regular.
    fn weight(&self, x: &DMatrix<f64>) -> Option<InputWeight> {
        let r = if self.discrete { &self.r + symmetric_part(&(self.b.tr_mul(x) * &self.b)) } else { self.r.clone() };
        if self.is_indefinite { InputWeight::regular(&r).ok() } else { InputWeight::definite(r) }
    }

    /// `E^-T W E^-1`: the weight W in the states of the standard form.
    fn standard(&self, w: &DMatrix<f64>) -> DMatrix<f64> {
        symmetric_part(&(self.inverse.tr_mul(w) * &self.inverse))
    }

    /// Whether `[Q, S; S', R] >= 0`.
    fn is_semidefinite(&self) -> bool {
        let (n, m) = self.b.shape();
        let mut cost = DMatrix::zeros(n + m, n + m);
        cost.view_mut((0, 0), (n, n)).copy_from(&self.q);
        cost.view_mut((n, n), (m, m)).copy_from(&self.r);
        cost.view_mut((0, n), (n, m)).copy_from(&self.s);
        cost.view_mut((n, 0), (m, n)).copy_from(&self.s.transpose());
        positive_semidefinite("the cost", &cost).is_ok()
    }

    fn closed_loop(&self, k: &DMatrix<f64>) -> Result<SchurEquation> {
        let kind = Kind::of_time(self.discrete);
        SchurEquation::untested(kind, &((&self.a - &self.b * k) * &self.inverse), None)
    }

    /// Newton's iteration as long as it lowers the residual, then poles, condition and error bound.
    fn refined(&self, x: DMatrix<f64>) -> Result<Riccati> {
        let overflow = || LinalgError::Overflow { what: "the generalised Riccati equation" };
        let mut at = match self.iterate(x.clone()) {
            Some(at) => at,
            // An indefinite Q may have another R + B'X B than R.
            None if self.discrete && !self.is_indefinite => {
                return Self { is_indefinite: true, ..self.clone() }.refined(x);
            }
            None => return Err(overflow()),
        };
        let mut equation = self.closed_loop(&at.k)?;
        for _ in 0..NEWTON_STEPS {
            let correction = equation.substituted(&self.standard(&at.defect));
            let Some(next) = correction.and_then(|d| self.iterate(symmetric_part(&(&at.x + d)))) else { break };
            if next.residual().is_nan() || next.residual() >= at.residual() {
                break;
            }
            at = next;
            equation = self.closed_loop(&at.k)?;
        }
        let poles = equation.eigenvalues();
        let distance = |l: &Complex<f64>| if self.discrete { 1.0 - l.norm() } else { -l.re };
        let nearest = poles.iter().min_by(|l, r| distance(l).total_cmp(&distance(r)));
        if let Some(&eigenvalue) = nearest
            && distance(&eigenvalue) <= 0.0
        {
            return Err(LinalgError::NotStabilizing { eigenvalue, distance: distance(&eigenvalue) });
        }
        let (residual, allowed) = (at.residual(), f64::EPSILON.sqrt());
        if residual > allowed {
            let method = "Newton's iteration for the generalised Riccati equation";
            return Err(LinalgError::NotConverged { method, iterations: NEWTON_STEPS, remaining: residual, allowed });
        }
        let (condition, forward_error) = self.evidence(&at, &mut equation).unwrap_or((f64::INFINITY, f64::INFINITY));
        let size = (norm(&self.a) + norm(&self.b) * norm(&at.k)) * norm(&self.inverse);
        let size = if self.discrete { size.max(1.0) } else { size };
        if self.is_indefinite && forward_error.is_infinite() {
            let nearest = nearest.map_or((Complex::default(), 0.0), |&eigenvalue| (eigenvalue, distance(&eigenvalue)));
            return Err(unverified(norm(&at.x), nearest));
        }
        // Where no digit is known, a pole within the accuracy of a double eigenvalue on the boundary may be one; there
        // is a solution if the cost is semidefinite, and else the defect counts as well.
        let n = at.x.nrows();
        let near =
            if self.is_semidefinite() { f64::EPSILON.sqrt() * n as f64 * size } else { double_root(residual, n, size) };
        if forward_error.is_infinite()
            && let Some(&eigenvalue) = nearest
            && distance(&eigenvalue) <= near
        {
            return Err(LinalgError::NotStabilizing { eigenvalue, distance: distance(&eigenvalue) });
        }
        let x = in_units(&at.x, &self.rows);
        let k =
            DMatrix::from_fn(at.k.nrows(), at.k.ncols(), |i, j| shift(at.k[(i, j)], self.inputs[i] - self.columns[j]));
        if !x.iter().chain(k.iter()).all(|x| x.is_finite()) {
            return Err(LinalgError::Overflow { what: "the solution x or the gain k" });
        }
        let same = self.rows.iter().all(|&e| e == self.rows[0]);
        let forward_error = if same || forward_error == 0.0 || norm(&x) == 0.0 {
            forward_error
        } else {
            // `||R E R|| <= ||E|| tr(R^2)`.
            let trace: f64 = self.rows.iter().map(|&e| shift(1.0, 2 * e)).sum();
            of_exact(forward_error * norm(&at.x) * trace / norm(&x))
        };
        Ok(Riccati { x, k, poles, residual, condition, forward_error })
    }

    /// `(condition, forward error)`, by the solutions of the closed-loop equation, as in `riccati/condition.rs`. With
    /// `F = A - B K` a change of the data changes the equation, to first order, by
    ///
    /// ```text
    /// continuous   dA'X E + E'X dA + dE'X F + F'X dE    discrete   dA'X F + F'X dA - dE'X E - E'X dE
    /// both         dQ - dS K - K'dS' + K'dR K - K'dB'X G - G'X dB K        G = E, in discrete time G = F
    /// ```
    /// The solution for the weight `M'N + N'M` has at most the norm `2 sqrt(||H(M'M)|| ||H(N'N)||)`, H(W) being the
    /// solution for the weight W.
    fn evidence(&self, at: &Iterate, equation: &mut SchurEquation) -> Option<(f64, f64)> {
        let Iterate { x, k, .. } = at;
        let n = x.nrows();
        let closed = &self.a - &self.b * k;
        let f = &closed * &self.inverse;
        let mut solved = |half: &DMatrix<f64>| equation.substituted(&half.tr_mul(half));
        let h = solved(&DMatrix::identity(n, n))?;
        let [one, of_k, of_e, of_f] =
            [self.inverse.clone(), k * &self.inverse, x.clone(), x * &f].map(|half| solved(&half).map(|h| norm(&h)));
        let (one, of_k, of_e, of_f) = (one?, of_k?, of_e?, of_f?);
        let (seen, other) = if self.discrete { (of_f, of_e) } else { (of_e, of_f) };
        let [a, b, q, r, s, e] = [&self.a, &self.b, &self.q, &self.r, &self.s, &self.e].map(norm);
        let pairs = [(one, seen, a), (one, other, e), (of_k, seen, b), (one, of_k, s)];
        let pairs = pairs.iter().map(|(left, right, size)| 2.0 * left.sqrt() * right.sqrt() * size).sum::<f64>();
        let condition = relative(one * q + of_k * r + pairs, norm(x));
        Some((condition, self.forward_error(at, &closed, &h).unwrap_or(f64::INFINITY)))
    }

    /// Forward error of X. The defect with the stored gain, in discrete time `F'X F - E'X E + Q - S K - K'S' + K'R K`,
    /// differs from that of X by the square of the gain's error. `h` is the solution for the identity.
    fn forward_error(&self, at: &Iterate, closed: &DMatrix<f64>, h: &DMatrix<f64>) -> Option<f64> {
        let Iterate { x, k, .. } = at;
        let (n, m) = (x.nrows(), k.nrows());
        let unit = 2.0 * (n + m) as f64 * f64::EPSILON;
        let [a, b, q, r, s, e] = [&self.a, &self.b, &self.q, &self.r, &self.s, &self.e].map(norm);
        let (size_x, size_k, size_f, size_i) = (norm(x), norm(k), norm(closed), norm(&self.inverse));
        let spread_f = a + b * size_k;
        let cost = &self.s * k;
        let cost = &self.q - &cost - cost.transpose() + k.tr_mul(&(&self.r * k));
        let other = if self.discrete { size_f } else { e };
        let (left, terms) = if self.discrete {
            (closed.tr_mul(x) * closed - self.e.tr_mul(x) * &self.e, (2.0 * spread_f * other + e * e) * size_x)
        } else {
            let half = closed.tr_mul(x) * &self.e;
            (&half + half.transpose(), 2.0 * spread_f * other * size_x)
        };
        let rounding = unit * (terms + q + 2.0 * s * size_k + r * size_k * size_k);
        // Error of the stored gain.
        let weight = self.weight(x)?;
        let size_w = r + if self.discrete { b * b * size_x } else { 0.0 };
        let plant = if self.discrete { &self.a } else { &self.e };
        let cross = self.b.tr_mul(x) * plant + self.s.transpose();
        let missed = norm(&(weight.times(k) - cross)) + unit * (size_w * size_k + b * size_x * norm(plant) + s);
        let size_inverse = norm(&weight.inverse());
        let (gain, square) = (size_inverse * missed, size_inverse * missed * missed);
        // Rounding errors of the closed loop in standard form, and the effect of the gain's error.
        let condition_e = size_i * e;
        let moved = size_i * (b * gain + unit * (spread_f + size_f * condition_e));
        let steps = if self.discrete { 2.0 * size_f * size_i + moved } else { 2.0 };
        let left_of_decrease = 1.0 - steps * moved * norm(h);
        if left_of_decrease.is_nan() || left_of_decrease <= 0.0 {
            return None;
        }
        let size_h = norm(h) / left_of_decrease;
        let defect = size_i * size_i * (1.0 + unit * condition_e) * (norm(&(left + cost)) + square + rounding);
        let pull = weight.pull(&self.b, h) / left_of_decrease;
        let curvature = if self.discrete { 8.0 } else { 4.0 } * pull * size_h;
        (curvature * defect <= 1.0)
            .then(|| relative(2.0 * size_h * defect * (n as f64).sqrt(), size_x))
            .map(|bound| if bound == 0.0 { 0.0 } else { of_exact(bound) })
    }
}
