//! Pole placement with a zero pattern in the gain: output k must not correct state i.
//!
//! *Number of zeros.* The coefficients of the characteristic polynomial of `A - L C` are n polynomials in the f free
//! entries of L. With `f < n` they reach a surface only, and almost no set of poles can be placed. With `f >= n` they
//! reach an open set iff their derivative has rank n somewhere ([`StructuredPlacement::rank`]); complex gains then
//! reach almost every set of poles, real gains possibly only some, as with static output feedback (Hermann and Martin,
//! IEEE TAC 22, 1977). An eigenvalue common to all gains of the pattern is a fixed mode (Wang and Davison, IEEE TAC 18,
//! 1973): it cannot be moved, and if it is not among the requested poles the call is an error.
//!
//! *Method.* Levenberg-Marquardt in two stages. First on `det(s_i I - A + L C) / prod_j (s_i - mu_j) - 1` at n points
//! s_i of a circle around the requested poles mu. This is the difference of the two characteristic polynomials in a
//! well-scaled basis; it is smooth in L even for repeated poles, with the derivative `C adj(s_i I - A + L C)`. Then on
//! the distances between achieved and requested poles, with `d lambda = -y*(dL) C x / y*x`, which minimises their sum
//! of squares where the poles cannot be placed. Twelve fixed starting points: the unconstrained gain with its forbidden
//! entries set to zero, zero, and ten pseudorandom ones. Of the gains that place the poles, the one with the
//! best-conditioned eigenvalues is kept. The global minimum is not guaranteed.

use luenberger_random::Random;
use nalgebra::{Complex, DMatrix, DMatrixView, DVector, Dyn};

use super::eigenvectors::Eigenvectors;
use super::poles::RequestedPoles;
use super::sensitivity::{Eigen, conditions};
use super::{Placement, assign, check};
use crate::argument::{RealMatrixView, owned, shaped};
use crate::schur::{schur, triangular_factor};
use crate::units::{Units, shift};
use crate::{LinalgError, Result};

/// A gain with prescribed zeros, and the accuracy of its poles.
#[derive(Debug, Clone, PartialEq)]
pub struct StructuredPlacement {
    /// The gain, its poles, their distances from the requested ones and their condition numbers. `condition` is that of
    /// the achieved closed loop.
    pub placement: Placement,
    /// Whether every pole is at its requested place, within rounding errors times its condition number.
    pub is_placed: bool,
    /// f, the number of entries of the gain that are free.
    pub free: usize,
    /// Rank of the derivative of the characteristic polynomial with respect to the free entries, at this gain. With
    /// rank n, small changes of the requested poles can be followed.
    pub rank: usize,
    /// Levenberg-Marquardt steps of all starts together.
    pub iterations: usize,
}

/// Number of starts, and the number of successful placements after which no further start is tried.
const STARTS: u64 = 12;
const ENOUGH: usize = 4;
/// Steps of one Levenberg-Marquardt run.
const STEPS: usize = 60;

/// State feedback gain `K`, m x n, with `K(i, j) = 0` wherever `free(i, j)` is false, that places the eigenvalues of
/// `A - B K` at `poles` or as near as the iteration finds. Sign: `u = -K x`.
///
/// `a` is n x n, `b` n x m, `poles` n numbers, real or complex, closed under conjugation, `free` m x n. Poles
/// may be repeated (the loop may then be defective). The pair need not be controllable if `poles` contains its
/// uncontrollable eigenvalues.
///
/// # Errors
/// [`LinalgError::FixedMode`] names an eigenvalue that no gain with these zeros moves and that is not among `poles`.
/// The errors of the arguments of [`super::place`]. Poles that are not reached are no error: see
/// [`StructuredPlacement::is_placed`] and [`Placement::errors`].
///
/// # Cost
/// At most 1440 steps of `O(n^4)`; a few dozen steps where there are enough free entries.
///
/// # Example
/// Two carts coupled by springs, each driven by feedback of its own state only (decentralised control).
/// ```
/// use luenberger_linalg::{eigenvalues, place_structured};
/// use nalgebra::{Complex, dmatrix};
///
/// let a = dmatrix![0.0, 1.0, 0.0, 0.0; -2.0, 0.0, 1.0, 0.0; 0.0, 0.0, 0.0, 1.0; 1.0, 0.0, -2.0, 0.0];
/// let b = dmatrix![0.0, 0.0; 1.0, 0.0; 0.0, 0.0; 0.0, 1.0];
/// let own = dmatrix![true, true, false, false; false, false, true, true];
/// let requested = [Complex::new(-1.0, 1.0), Complex::new(-1.0, -1.0), Complex::from(-2.0), Complex::from(-3.0)];
/// let found = place_structured(&a, &b, &requested, &own)?;
/// let k = &found.placement.gain;
/// println!("K = {k}, poles off by {:e}", found.placement.deviation);
/// assert!(found.is_placed && found.placement.deviation < 1e-10);
/// assert_eq!((k[(0, 2)], k[(0, 3)], k[(1, 0)], k[(1, 1)]), (0.0, 0.0, 0.0, 0.0));
/// # let _ = eigenvalues(&(&a - &b * k))?;
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Wang and Davison, IEEE TAC 18, 1973, for the fixed modes; More, Lecture Notes in Mathematics 630, 1978, for
/// the method.
pub fn place_structured<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    poles: &[impl Into<Complex<f64>> + Copy],
    free: impl Into<DMatrixView<'a, bool, Dyn, Dyn>>,
) -> Result<StructuredPlacement> {
    let poles: Vec<_> = poles.iter().map(|&pole| pole.into()).collect();
    controller(&owned(a), &owned(b), &poles, &free.into().into_owned())
}

fn controller(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    poles: &[Complex<f64>],
    free: &DMatrix<bool>,
) -> Result<StructuredPlacement> {
    check(a)?;
    shaped("B", b, a.nrows(), b.ncols())?;
    let expected = (b.ncols(), a.nrows());
    if free.shape() != expected {
        return Err(LinalgError::DimensionMismatch { what: "the pattern of K", expected, found: free.shape() });
    }
    solve(a, b, &RequestedPoles::new(poles, a.nrows())?, free)
}

/// Observer gain `L`, n x p, with `L(i, k) = 0` wherever `free(i, k)` is false, that places the eigenvalues of
/// `A - L C` at `poles` or as near as the iteration finds.
///
/// `a` is n x n, `c` p x n, `poles` n numbers, real or complex, closed under conjugation, `free` n x p: false
/// where output k must not correct state i. This is [`place_structured`] of `(A', C')`, transposed.
///
/// # Errors
/// As [`place_structured`].
///
/// # Cost
/// As [`place_structured`].
///
/// # Example
/// Position and velocity measured; the position measurement must not correct the velocity. Three free entries remain,
/// more than the two poles need.
/// ```
/// use luenberger_linalg::place_observer_structured;
/// use nalgebra::dmatrix;
///
/// let (a, c) = (dmatrix![0.0, 1.0; -4.0, -0.4], dmatrix![1.0, 0.0; 0.0, 1.0]);
/// let free = dmatrix![true, true; false, true];
/// let found = place_observer_structured(&a, &c, &[-5.0, -6.0], &free)?;
/// let closed = &a - &found.placement.gain * &c;
/// let residual = (closed.trace() + 11.0).abs() + (closed.determinant() - 30.0).abs();
/// println!("L = {}, residual {residual:e}", found.placement.gain);
/// assert!(residual < 1e-11 && found.placement.gain[(1, 0)] == 0.0);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn place_observer_structured<'a>(
    a: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    poles: &[impl Into<Complex<f64>> + Copy],
    free: impl Into<DMatrixView<'a, bool, Dyn, Dyn>>,
) -> Result<StructuredPlacement> {
    let poles: Vec<_> = poles.iter().map(|&pole| pole.into()).collect();
    observer(&owned(a), &owned(c), &poles, &free.into().into_owned())
}

fn observer(
    a: &DMatrix<f64>,
    c: &DMatrix<f64>,
    poles: &[Complex<f64>],
    free: &DMatrix<bool>,
) -> Result<StructuredPlacement> {
    check(a)?;
    shaped("C", c, c.nrows(), a.nrows())?;
    let expected = (a.nrows(), c.nrows());
    if free.shape() != expected {
        return Err(LinalgError::DimensionMismatch { what: "the pattern of L", expected, found: free.shape() });
    }
    let requested = RequestedPoles::new(poles, a.nrows())?;
    let mut found = solve(&a.transpose(), &c.transpose(), &requested, &free.transpose())?;
    found.placement.gain = found.placement.gain.transpose();
    Ok(found)
}

fn solve(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    requested: &RequestedPoles,
    free: &DMatrix<bool>,
) -> Result<StructuredPlacement> {
    let (n, m) = b.shape();
    let units = Units::of(&a.transpose(), &b.transpose());
    let problem = Problem {
        a: units.dynamics(&a.transpose()).transpose(),
        b: units.outputs(&b.transpose()).transpose(),
        requested: requested.in_time(-units.time),
        free: (0..n).flat_map(|l| (0..m).map(move |j| (j, l))).filter(|at| free[*at]).collect(),
    };
    problem.fixed_modes()?.map_or(Ok(()), |(eigenvalue, distance)| {
        let back = |x: f64| shift(x, units.time);
        Err(LinalgError::FixedMode {
            eigenvalue: Complex::new(back(eigenvalue.re), back(eigenvalue.im)),
            distance: back(distance),
        })
    })?;
    // Unconstrained gain in balanced units; if there is none, zero, and the random starts scale with the norm of A.
    let power = |i: usize, j: usize| units.time - units.output[i] + units.state[j];
    let unconstrained = match assign(a, b, requested, units.clone(), None) {
        Ok(assigned) => DMatrix::from_fn(m, n, |i, j| shift(assigned.gain[(i, j)], -power(i, j))),
        Err(_) => DMatrix::zeros(m, n),
    };
    let reach = unconstrained.norm().max(problem.a.norm());
    let reach = if reach.is_finite() { reach } else { 1.0 };

    let mut best: Option<Candidate> = None;
    let (mut placed, mut iterations) = (0, 0);
    for start in 0..STARTS {
        let mut numbers = Random(start << 32);
        let x = DVector::from_iterator(
            problem.free.len(),
            problem.free.iter().map(|at| match start {
                0 => unconstrained[*at],
                1 => 0.0,
                _ => numbers.unit() * reach * 2f64.powi(1 - (start % 4) as i32),
            }),
        );
        if x.iter().any(|x| !x.is_finite()) {
            continue;
        }
        let (x, first) = levenberg_marquardt(x, |x| problem.polynomials(x));
        let (x, second) = levenberg_marquardt(x, |x| problem.distances(x));
        iterations += first + second;
        let Some(candidate) = problem.candidate(x)? else { continue };
        placed += usize::from(candidate.is_placed);
        if best.as_ref().is_none_or(|best| candidate.is_better_than(best)) {
            best = Some(candidate);
        }
        if placed >= ENOUGH || problem.free.is_empty() {
            break;
        }
    }
    let best = best.ok_or(LinalgError::Overflow { what: "the gain" })?;

    let scaled = problem.gain(&best.x);
    let gain = DMatrix::from_fn(m, n, |i, j| shift(scaled[(i, j)], power(i, j)));
    if gain.iter().any(|x| !x.is_finite()) {
        return Err(LinalgError::Overflow { what: "the gain" });
    }
    let form = schur(&problem.closed(&best.x))?;
    let eigen = Eigen::of(&form);
    let vectors = eigen.right.in_units(units.state.iter().map(|power| -power)).normalised();
    let condition = vectors.condition()?;
    let closed = super::Assigned {
        gain: gain.clone(),
        achieved: eigen.values.iter().map(|x| Complex::new(shift(x.re, units.time), shift(x.im, units.time))).collect(),
        sensitivities: conditions(&form, &units.state),
        vectors,
        rank: m,
        size: shift(problem.a.norm(), units.time),
    };
    Ok(StructuredPlacement {
        placement: super::finish(gain, requested, &closed, condition),
        is_placed: best.is_placed,
        free: problem.free.len(),
        rank: problem.rank(&best.x)?,
        iterations,
    })
}

/// Plant in balanced units, and the free entries `(input, state)` of the gain.
struct Problem {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    requested: RequestedPoles,
    free: Vec<(usize, usize)>,
}

/// Result of one starting point.
struct Candidate {
    x: DVector<f64>,
    is_placed: bool,
    /// Sum of squares of the distances between achieved and requested poles.
    missed: f64,
    /// Sum of squares of the condition numbers of the poles.
    condition: f64,
}

impl Candidate {
    fn is_better_than(&self, other: &Self) -> bool {
        match (self.is_placed, other.is_placed) {
            (true, true) => self.condition < other.condition,
            (false, false) => self.missed < other.missed,
            (placed, _) => placed,
        }
    }
}

impl Problem {
    fn gain(&self, x: &DVector<f64>) -> DMatrix<f64> {
        let mut k = DMatrix::zeros(self.b.ncols(), self.a.nrows());
        for (at, x) in self.free.iter().zip(x.iter()) {
            k[*at] = *x;
        }
        k
    }

    fn closed(&self, x: &DVector<f64>) -> DMatrix<f64> {
        &self.a - &self.b * self.gain(x)
    }

    /// Norm of the terms of the closed loop, for rounding errors.
    fn terms(&self, x: &DVector<f64>) -> f64 {
        self.a.norm() + self.b.norm() * x.norm()
    }

    /// Relative difference of the characteristic polynomials at the points of a circle, and its Jacobian: real parts,
    /// then imaginary parts.
    fn polynomials(&self, x: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let n = self.a.nrows();
        let poles = self.requested.poles();
        let centre = poles.iter().map(|p| p.re).sum::<f64>() / n as f64;
        let spread = poles.iter().map(|p| (p - centre).norm()).fold(0.25 * centre.abs(), f64::max);
        // 1.5 times the spread of the poles: near enough that the last coefficient still counts, with the weight
        // 1.5^-n.
        let radius = 1.5 * if spread > 0.0 { spread } else { self.a.norm().max(1.0) };
        let closed = self.closed(x).map(Complex::from);
        let b = self.b.map(Complex::from);
        let half = n.div_ceil(2);
        let mut r = DVector::zeros(2 * half);
        let mut j = DMatrix::zeros(2 * half, self.free.len());
        // The lower half of the circle gives the conjugates.
        for i in 0..half {
            let angle = std::f64::consts::PI * (2 * i + 1) as f64 / n as f64;
            let s =
                Complex::new(centre + radius * angle.cos(), if 2 * i + 1 == n { 0.0 } else { radius * angle.sin() });
            let mut matrix = -&closed;
            for k in 0..n {
                matrix[(k, k)] += s;
            }
            let lu = matrix.lu();
            let u = lu.u();
            let sign: f64 = lu.p().determinant();
            let ratio = (0..n).fold(Complex::from(sign), |product, k| product * (u[(k, k)] / (s - poles[k])));
            let resolvent = lu.solve(&b)?;
            let residual = ratio - 1.0;
            (r[i], r[half + i]) = (residual.re, residual.im);
            for (k, (input, state)) in self.free.iter().enumerate() {
                let d = ratio * resolvent[(*state, *input)];
                (j[(i, k)], j[(half + i, k)]) = (d.re, d.im);
            }
        }
        finite(r, j)
    }

    /// Differences between achieved and requested poles, and their Jacobian.
    fn distances(&self, x: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let n = self.a.nrows();
        let eigen = Eigen::of(&schur(&self.closed(x)).ok()?);
        let at = self.requested.matched(&eigen.values);
        // B'y; the conjugates are the entries of y*B.
        let driven = Eigenvectors { columns: self.b.tr_mul(&eigen.left.columns), parts: eigen.left.parts };
        let mut r = DVector::zeros(2 * n);
        let mut j = DMatrix::zeros(2 * n, self.free.len());
        for (i, (pole, k)) in self.requested.poles().iter().zip(at).enumerate() {
            let off = eigen.values[k] - pole;
            (r[i], r[n + i]) = (off.re, off.im);
            for (column, (input, state)) in self.free.iter().enumerate() {
                let d = -driven.entry(*input, k).conj() * eigen.right.entry(*state, k);
                (j[(i, column)], j[(n + i, column)]) = (d.re, d.im);
            }
        }
        finite(r, j)
    }

    fn candidate(&self, x: DVector<f64>) -> Result<Option<Candidate>> {
        let n = self.a.nrows();
        let form = triangular_factor(&self.closed(&x))?;
        let values = form.eigenvalues();
        let conditions = conditions(&form, &vec![0; n]);
        let terms = self.terms(&x);
        let size = self.requested.poles().iter().map(|p| p.norm()).fold(self.a.norm(), f64::max);
        let (mut is_placed, mut missed) = (true, 0.0);
        for (pole, k) in self.requested.poles().iter().zip(self.requested.matched(&values)) {
            let off = (values[k] - pole).norm();
            // Ten times the error n eps of a Schur form, at most 1e-6 of the size.
            is_placed &= off <= (10.0 * n as f64 * f64::EPSILON * conditions[k] * terms).min(1e-6 * size);
            missed += off * off;
        }
        let condition = conditions.iter().map(|x| x * x).sum();
        Ok((missed <= f64::MAX).then_some(Candidate { x, is_placed, missed, condition }))
    }

    /// Fixed mode that is furthest from the requested poles, with its distance: an eigenvalue of A that generic gains
    /// of the pattern do not move and that is not requested.
    fn fixed_modes(&self) -> Result<Option<(Complex<f64>, f64)>> {
        let n = self.a.nrows();
        let form = triangular_factor(&self.a)?;
        let own: Vec<(Complex<f64>, f64)> =
            form.eigenvalues().into_iter().zip(conditions(&form, &vec![0; n])).collect();
        let mut fixed = vec![true; n];
        let mut slack = vec![0.0; n];
        for draw in 0..3 {
            let mut numbers = Random((100 + draw) << 32);
            let size = self.a.norm().max(1.0) / self.b.norm().max(1e-3);
            let x = DVector::from_fn(self.free.len(), |_, _| numbers.unit() * size);
            let moved = triangular_factor(&self.closed(&x))?;
            let terms = self.terms(&x);
            let found: Vec<(Complex<f64>, f64)> =
                moved.eigenvalues().into_iter().zip(conditions(&moved, &vec![0; n])).collect();
            // Each eigenvalue of the perturbed plant matches one eigenvalue of A only: of a double eigenvalue, one copy
            // may be fixed and the other not.
            let mut taken = vec![false; n];
            for (k, (value, condition)) in own.iter().enumerate() {
                let tolerance =
                    |other: f64| (100.0 * n as f64 * f64::EPSILON * condition.max(other) * terms).min(1e-6 * terms);
                let same = (0..n).find(|i| !taken[*i] && (found[*i].0 - value).norm() <= tolerance(found[*i].1));
                fixed[k] &= same.is_some();
                if let Some(i) = same {
                    taken[i] = true;
                }
                slack[k] = f64::max(slack[k], tolerance(1.0));
            }
        }
        // Each requested pole accounts for one fixed mode.
        let mut used = vec![false; n];
        let mut worst: Option<(Complex<f64>, f64)> = None;
        for (k, (value, _)) in own.iter().enumerate().filter(|(k, _)| fixed[*k]) {
            let distance = |i: &usize| (self.requested.poles()[*i] - value).norm();
            let nearest = (0..n).filter(|i| !used[*i]).min_by(|i, j| distance(i).total_cmp(&distance(j)));
            let Some(nearest) = nearest else { continue };
            let off = distance(&nearest);
            // Six digits, as for a placed pole: a user types a fixed mode as a rounded decimal number.
            if off <= slack[k].max(1e-6 * value.norm()) {
                used[nearest] = true;
            } else if worst.is_none_or(|w| off > w.1) {
                worst = Some((*value, off));
            }
        }
        Ok(worst)
    }

    /// Rank of the derivative of the characteristic polynomial.
    fn rank(&self, x: &DVector<f64>) -> Result<usize> {
        let Some((_, j)) = self.polynomials(x) else { return Ok(0) };
        if self.free.is_empty() {
            return Ok(0);
        }
        let sigma = faer::Mat::from_fn(j.nrows(), j.ncols(), |r, c| j[(r, c)]).singular_values().map_err(|_| {
            LinalgError::NotConverged {
                method: "singular values of the derivative",
                iterations: 0,
                remaining: f64::NAN,
                allowed: f64::EPSILON,
            }
        })?;
        let floor =
            crate::observability::default_tolerance(j.nrows(), j.ncols()) * sigma.first().copied().unwrap_or(0.0);
        Ok(sigma.iter().filter(|s| **s > floor).count())
    }
}

fn finite(r: DVector<f64>, j: DMatrix<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let all = r.iter().chain(j.iter()).all(|x| x.is_finite());
    all.then_some((r, j))
}

/// Least squares from `x` with the steps `-J'(J J' + mu I)^-1 r`, of minimal norm if there are more unknowns than
/// equations. Returns the best x and the number of steps.
fn levenberg_marquardt(
    mut x: DVector<f64>,
    residual: impl Fn(&DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)>,
) -> (DVector<f64>, usize) {
    let Some((mut r, mut j)) = residual(&x) else { return (x, 0) };
    if x.is_empty() {
        return (x, 0);
    }
    let mut damping = 1e-3;
    for step in 0..STEPS {
        let mut normal = &j * j.transpose();
        let scale = normal.diagonal().amax();
        if scale <= 0.0 || r.norm() == 0.0 {
            return (x, step);
        }
        for i in 0..normal.nrows() {
            normal[(i, i)] += (damping + 1e-15) * scale;
        }
        let Some(factor) = normal.cholesky() else {
            damping = (10.0 * damping).max(1e-12);
            continue;
        };
        let next = &x - j.tr_mul(&factor.solve(&r));
        match residual(&next).filter(|(s, _)| s.norm() < r.norm()) {
            Some((s, derivative)) => {
                let settled = r.norm() - s.norm() <= 1e-13 * r.norm() && (&next - &x).norm() <= 1e-14 * x.norm();
                (x, r, j) = (next, s, derivative);
                damping *= 0.1;
                if settled {
                    return (x, step + 1);
                }
            }
            None if damping > 1e8 => return (x, step),
            None => damping = (10.0 * damping).max(1e-12),
        }
    }
    (x, STEPS)
}
