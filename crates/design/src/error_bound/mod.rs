//! A proved bound of the error of the linear and of the cubic observer under bounded disturbances and noise.
//!
//! `x' = A x + B u + E w`, `y = C x + D w`, `|w_i| <= W_i`. The theorem is at the head of
//! `proof/src/certificate/theorem/input_to_state.rs` and in `docs/theory-cubic.md`; here its numbers are chosen.
//! For a rate alpha the bounds are `b_k^2 = U (P^-1)_kk` with any P that satisfies `F'P + PF + 2 alpha P + PG
//! diag(lambda)^-1 G'P < 0` and `sum lambda_i W_i^2 + (cubic part) <= 2 alpha U`. U = 1 fixes the scale of P, and the
//! weighted sum of the squares of the bounds is made least.
//!
//! **Linear observer.** `Z = P^-1 = sum d_i Z_i`, `d_i = 1/lambda_i`, with `(F + alpha I)Z_i + Z_i(F + alpha I)' + G_i
//! G_i' = 0` for the columns of G. The objective is `sum d_i t_i` under `sum W_i^2/d_i = 2 alpha`, least at `d_i = W_i
//! sum_j W_j sqrt(t_j) / (2 alpha sqrt(t_i))`. Each rate costs m Lyapunov equations; the rate is found by a search.
//!
//! **In discrete time**, `x+ = A x + B u + E w`, `e+ = F e + G w`: with a factor `q = exp(-alpha)` of a step `V(Fe +
//! Gw) <= q^2 V + sum lambda_i w_i^2` iff `F Z F'/q^2 + G diag(lambda)^-1 G' <= Z`, so that `F Z_i F'/q^2 - Z_i + G_i
//! G_i' = 0`, and `1 - q^2` takes the place of `2 alpha`.
//!
//! **Cubic observer, or a polytope of plants.** A semidefinite program for each rate. The stored N restricts P to `P =
//! C'XC + T'YT`, `TN = 0`, where X is taken as a multiple of that of the design (for one output: any X). Then kappa is
//! inversely proportional to X, mu is proportional, and the cubic part `27/128 kappa (sum mu_i W_i^2)^2` is linear in
//! X. Where no program is solved, as for an N that leaves P little freedom, the P of the design is taken at half the
//! rate at which its V decays, with `lambda_i = m (PG_i)'M^-1 PG_i` for `M = -(F'P + PF + 2 alpha P)`: each of the m
//! disturbances has an equal part of M.

mod programs;
mod reached;

use luenberger_linalg::{RealMatrixView, eigenvalues, lambda_max, positive_definite, state_units, symmetric_part};
use luenberger_lmi::proof_matrix;
use luenberger_observers::{CubicObserver, DiscreteLinearObserver, LinearObserver, SampledObserver};
use luenberger_proof::certificate::{
    Certificate, CubicTerm, DiscreteInputToStateStability, DisturbedPlant, InputToStateStability,
};
use luenberger_proof::statement::TimeDomain;
use luenberger_proof::{ProofError, Ring};
use nalgebra::{DMatrix, DVector, Dyn};

use crate::certificate::certified;
use crate::check;
use crate::cubic::{CubicDesign, radial_s};
use crate::error::DesignError;
use crate::powers::{Powers, shift};
use reached::{Reached, equation, golden, spent};

/// Disturbances and noise of a plant with their bounds: `x' = A x + B u + E w` (`x+` in discrete time), `y = C x + D
/// w`, `|w_i(t)| <= W_i`.
#[derive(Debug, Clone, PartialEq)]
pub struct DisturbanceBounds {
    /// E, n x m: how the disturbances enter the states.
    pub e: DMatrix<f64>,
    /// D, p x m: how they enter the outputs.
    pub d: DMatrix<f64>,
    /// Their bounds W, m numbers, 0 or more.
    pub bounds: Vec<f64>,
}

impl DisturbanceBounds {
    /// Disturbances of the states, `x' = A x + B u + E w`, and measurement noise, `y = C x + v`, with bounds for each
    /// component of w and of v.
    pub fn of_states_and_outputs<'a>(e: impl Into<RealMatrixView<'a>>, disturbances: &[f64], noise: &[f64]) -> Self {
        let e = check::owned(e);
        let (n, q, p) = (e.nrows(), e.ncols(), noise.len());
        Self {
            e: DMatrix::from_fn(n, q + p, |i, j| if j < q { e[(i, j)] } else { 0.0 }),
            d: DMatrix::from_fn(p, q + p, |i, j| if j == q + i { 1.0 } else { 0.0 }),
            bounds: disturbances.iter().chain(noise).copied().collect(),
        }
    }

    /// Shapes for n states and p outputs, and bounds that are finite and not negative.
    pub(crate) fn check(&self, size: (usize, usize)) -> Result<(), DesignError> {
        self.check_shapes(size)?;
        check::not_negative("the bound of a disturbance", &self.bounds)
    }

    pub(crate) fn check_shapes(&self, (n, p): (usize, usize)) -> Result<(), DesignError> {
        let (of_states, of_outputs) = (self.e.ncols(), self.d.ncols());
        if of_states != self.bounds.len() || of_outputs != self.bounds.len() {
            return Err(DesignError::DisturbanceCount { bounds: self.bounds.len(), of_states, of_outputs });
        }
        check::matrix("E", &self.e, (n, of_states))?;
        check::matrix("D", &self.d, (p, of_outputs))
    }

    /// Measurement noise only.
    pub fn of_outputs(states: usize, noise: &[f64]) -> Self {
        Self::of_states_and_outputs(&DMatrix::zeros(states, 0), &[], noise)
    }
}

certified!(ErrorBound);

/// A bound of the error under bounded disturbances, with its certificate.
///
/// `V = e'Pe` obeys `V(t) <= exp(-2 rate t) V(0) + level`, in discrete time at the samples, and `limsup |e_k| <=
/// limsup[k]`.
#[readonly::make]
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorBound {
    /// P, n x n. For a cubic observer the theorem holds with a matrix P~ that differs from it by rounding.
    pub p: DMatrix<f64>,
    /// The decay rate of `sqrt V`.
    pub rate: f64,
    /// The bound of V for t to infinity.
    pub level: f64,
    /// The bounds of `limsup |e_k|`, n entries.
    pub limsup: Vec<f64>,
    /// The share of the cubic term in `level`, from 0 to 1.
    pub cubic_share: f64,
    /// The certificate of the bound; check that it is proved.
    pub certificate: Certificate,
}

impl ErrorBound {
    /// A bound of the error of a linear observer.
    ///
    /// Cost: about 60 m Lyapunov equations of order n.
    ///
    /// ```
    /// use luenberger_design::{DisturbanceBounds, ErrorBound, LinearDesign};
    ///
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let design = LinearDesign::with_poles(&plant, &[-2.0, -5.0])?;
    /// let noise = DisturbanceBounds::of_outputs(2, &[0.1]);
    /// let bound = ErrorBound::linear(&design.observer, &noise)?;
    /// assert!(bound.certificate.is_proved());
    /// // The largest error of x1 that any noise of this bound can make is 0.1236.
    /// assert!(bound.limsup[0] > 0.1236 && bound.limsup[0] < 0.2, "{:?}", bound.limsup);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// # Errors
    /// [`DesignError::NotHurwitz`] for an observer that does not converge, [`DesignError::Negative`] for a negative
    /// bound, [`DesignError::NotPositive`] where all are zero, [`DesignError::NothingReachesTheError`] where none
    /// acts on the error, [`DesignError::DisturbanceCount`] and
    /// [`DesignError::Matrix`] for shapes that do not fit.
    pub fn linear(
        observer: &LinearObserver<f64, Dyn, Dyn, Dyn>,
        disturbances: &DisturbanceBounds,
    ) -> Result<Self, DesignError> {
        let system = ErrorSystem::new((&observer.a, &observer.l, &observer.c), disturbances)?;
        system.linear()?.certify(&system)
    }

    /// A bound of the error of a linear observer in discrete time, `x+ = A x + B u + E w`, `y = C x + D w`, for all w
    /// of the samples within their bounds.
    ///
    /// Cost: about 60 m Stein equations of order n.
    ///
    /// ```
    /// use luenberger_design::{DiscreteDesign, DisturbanceBounds, ErrorBound};
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::dmatrix;
    /// // e+ = e/2 + w - v/2 with |w| <= 1, |v| <= 1/5: at most (1 + 1/10)/(1 - 1/2) = 2.2 in the end.
    /// let plant = StateSpace::new(dmatrix![1.0], dmatrix![0.0], dmatrix![1.0])?;
    /// let design = DiscreteDesign::with_poles(&plant, 0.1, &[0.5])?;
    /// let acting = DisturbanceBounds::of_states_and_outputs(&dmatrix![1.0], &[1.0], &[0.2]);
    /// let bound = ErrorBound::discrete(&design.observer, &acting)?;
    /// assert!(bound.certificate.is_proved() && (2.2..2.203).contains(&bound.limsup[0]));
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// # Errors
    /// As [`linear`](Self::linear), with [`DesignError::NotSchur`] in place of [`DesignError::NotHurwitz`].
    pub fn discrete(
        observer: &DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>,
        disturbances: &DisturbanceBounds,
    ) -> Result<Self, DesignError> {
        let (plant, period) = (observer.plant(), observer.period());
        let system = ErrorSystem::at_samples((&plant.a, observer.l(), &plant.c), disturbances)?;
        system.linear()?.certify_in_steps(&system, period)
    }

    /// A bound of the error of a cubic observer.
    ///
    /// Cost: the linear one, and about 20 semidefinite programs of about `n^2` unknowns.
    ///
    /// # Errors
    /// As [`linear`](Self::linear); [`DesignError::Undecided`] where no program was solved; the errors of
    /// [`certify_gain`](crate::robust::certify_gain) for an N that no P admits.
    pub fn cubic(design: &CubicDesign, disturbances: &DisturbanceBounds) -> Result<Self, DesignError> {
        Self::cubic_observer(&design.observer, &design.p, disturbances)
    }

    /// As [`cubic`](Self::cubic), for an observer whose N was computed with this P.
    ///
    /// # Errors
    /// As [`cubic`](Self::cubic).
    pub fn cubic_observer<'a>(
        o: &CubicObserver<f64, Dyn, Dyn, Dyn>,
        p: impl Into<RealMatrixView<'a>>,
        disturbances: &DisturbanceBounds,
    ) -> Result<Self, DesignError> {
        let mut system = ErrorSystem::new((&o.a, &o.l, &o.c), disturbances)?;
        if o.n.iter().all(|x| *x == 0.0) || o.theta.iter().all(|x| *x == 0.0) {
            return system.linear()?.certify(&system);
        }
        system.cubic = Some(system.cubic_part(&o.n, &o.theta, &check::owned(p))?);
        let linear = system.linear()?;
        system.by_programs(linear.rate, &linear.limsup)?.certify(&system)
    }

    /// A bound of the error of an observer of the plant (A, L, C) for every pair (A, E) of the convex hull of
    /// `vertices`, the observer running the same A as the plant; `disturbances.e` is not used. With a cubic term where
    /// N, theta and the P of its design are given.
    ///
    /// For an observer that runs a nominal A on an uncertain plant, the A of every vertex is the nominal one, and `E_k
    /// = [E, A_k - A]`, with bounds of the states among those of the disturbances.
    ///
    /// # Errors
    /// As [`cubic`](Self::cubic); [`DesignError::NoVertices`].
    pub fn polytope(
        vertices: &[(DMatrix<f64>, DMatrix<f64>)],
        (l, c): (&DMatrix<f64>, &DMatrix<f64>),
        cubic: Option<(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>)>,
        disturbances: &DisturbanceBounds,
    ) -> Result<Self, DesignError> {
        let Some((a, e)) = vertices.first() else { return Err(DesignError::NoVertices) };
        let of_vertex = |a, e: &DMatrix<f64>| {
            let here = DisturbanceBounds { e: e.clone(), ..disturbances.clone() };
            ErrorSystem::new((a, l, c), &here)
        };
        let mut system = of_vertex(a, e)?;
        for (a, e) in &vertices[1..] {
            system.vertices.extend(of_vertex(a, e)?.vertices);
        }
        // The rate and the scales of one on which a disturbance acts.
        let acting = system.flows().iter().position(|(_, g)| g.amax() > 0.0).unwrap_or(0);
        let (a, e) = &vertices[acting];
        let first = of_vertex(a, e)?.linear()?;
        if let Some((n, theta, p)) = cubic {
            system.cubic = Some(system.cubic_part(n, theta, p)?);
        }
        system.by_programs(first.rate, &first.limsup)?.certify(&system)
    }
}

/// The disturbances that are not zero, and the observer.
pub(crate) struct ErrorSystem {
    /// A and E at each vertex.
    vertices: Vec<(DMatrix<f64>, DMatrix<f64>)>,
    time: TimeDomain,
    /// The decay rate of the slowest mode of `A - L C` at the first of them; in discrete time per step, at most
    /// [`AT_ONCE`].
    slowest: f64,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    l: DMatrix<f64>,
    bounds: Vec<f64>,
    cubic: Option<CubicPart>,
}

/// The cubic term and its bound for the X of the design.
struct CubicPart {
    n: DMatrix<f64>,
    theta: DMatrix<f64>,
    x: DMatrix<f64>,
    kappa: f64,
    mu: Vec<f64>,
    /// P of the design.
    p: DMatrix<f64>,
    /// `27/128 kappa (sum mu_i W_i^2)^2`.
    cost: f64,
}

/// The numbers of a bound before it is proved.
struct Candidate {
    p: DMatrix<f64>,
    rate: f64,
    lambda: Vec<f64>,
    /// By how much X exceeds that of the design.
    x: f64,
    limsup: Vec<f64>,
}

/// The decay in a step of a deadbeat observer, which has no slowest mode: a factor of 1/20.
const AT_ONCE: f64 = 3.0;

const WHAT: &str = "a bound of the error, [F'P + PF + 2 rate P, PG; *, -diag(lambda)] < 0,";

impl ErrorSystem {
    pub(crate) fn new(
        pair: (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
        disturbances: &DisturbanceBounds,
    ) -> Result<Self, DesignError> {
        Self::of(TimeDomain::Continuous, pair, disturbances, || Ok(-check::hurwitz("A - L C", pair)?))
    }

    fn at_samples(
        pair: (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
        disturbances: &DisturbanceBounds,
    ) -> Result<Self, DesignError> {
        Self::of(TimeDomain::Discrete, pair, disturbances, || {
            let poles = eigenvalues(&check::closed_loop(pair)?)?;
            let radius = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
            check::schur_stable("A - L C", (radius, true), pair)?;
            Ok((-radius.ln()).min(AT_ONCE))
        })
    }

    fn of(
        time: TimeDomain,
        (a, l, c): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
        disturbances: &DisturbanceBounds,
        slowest: impl FnOnce() -> Result<f64, DesignError>,
    ) -> Result<Self, DesignError> {
        let (n, p, m) = (a.nrows(), c.nrows(), disturbances.bounds.len());
        check::matrix("A", a, (n, n))?;
        check::matrix("C", c, (p, n))?;
        check::matrix("L", l, (n, p))?;
        disturbances.check((n, p))?;
        let present: Vec<usize> = (0..m).filter(|&i| disturbances.bounds[i] > 0.0).collect();
        if present.is_empty() {
            return Err(DesignError::NotPositive { what: "the largest bound of a disturbance", value: 0.0 });
        }
        Ok(Self {
            time,
            slowest: slowest()?,
            vertices: vec![(a.clone(), disturbances.e.select_columns(&present))],
            c: c.clone(),
            d: disturbances.d.select_columns(&present),
            l: l.clone(),
            bounds: present.iter().map(|&i| disturbances.bounds[i]).collect(),
            cubic: None,
        })
    }

    /// F and G, its columns times the bounds, at each vertex.
    fn flows(&self) -> Vec<(DMatrix<f64>, DMatrix<f64>)> {
        let bounds = DMatrix::from_diagonal(&DVector::from_column_slice(&self.bounds));
        self.vertices.iter().map(|(a, e)| (a - &self.l * &self.c, (e - &self.l * &self.d) * &bounds)).collect()
    }

    /// The optimum for the linear observer and the first vertex, in the units given or, where its P does not serve
    /// there, in those of the states that fit `A - L C`.
    fn linear(&self) -> Result<Candidate, DesignError> {
        let Some((f, g)) = self.flows().into_iter().next() else { return Err(DesignError::NoVertices) };
        let units = Powers(state_units(&f)?);
        let decreases = |found: &Candidate| {
            let half = &found.p * &f;
            let decrease = match self.time {
                TimeDomain::Continuous => -(&half + half.transpose() + &found.p * (2.0 * found.rate)),
                TimeDomain::Discrete => &found.p * (-2.0 * found.rate).exp() - f.transpose() * half,
            };
            positive_definite("P", &found.p).is_ok() && positive_definite("its decrease", &decrease).is_ok()
        };
        match self.linear_in(&Powers::given(f.nrows()), &f, &g) {
            Ok(found) if decreases(&found) => Ok(found),
            other => self.linear_in(&units, &f, &g).or(other),
        }
    }

    fn linear_in(&self, units: &Powers, f: &DMatrix<f64>, g: &DMatrix<f64>) -> Result<Candidate, DesignError> {
        let n = f.nrows();
        let (f, g) = (units.similar(f), units.rows(g));
        let (time, fastest) = (self.time, self.slowest);
        check::positive("the decay rate of A - L C", fastest)?;
        let e = &self.vertices[0].1;
        if check::exact_closed_loop(e, &self.l, &self.d)?.as_slice().iter().all(Ring::is_zero) {
            return Err(DesignError::NothingReachesTheError);
        }
        // Rates from a hundredth of the fastest to close to it; first the best bound of each component by itself.
        let shares: Vec<f64> = (0..24).map(|k| 0.02 * f64::powf(48.5, f64::from(k) / 23.0)).collect();
        let mut best = vec![f64::INFINITY; n];
        for share in &shares {
            let Some(reached) = Reached::new(time, &f, &g, share * fastest) else { continue };
            for (k, best) in best.iter_mut().enumerate() {
                *best = best.min(reached.component(k));
            }
        }
        let found = |why| DesignError::Undecided { what: WHAT, why, best: f64::NAN, seen: None };
        let unproved = || found(luenberger_proof::UndecidedReason::NotByThisMatrix { name: "P" });
        if best.iter().any(|b| !b.is_finite()) {
            return Err(unproved());
        }
        // A component that no disturbance reaches has the bound 0: the others decide.
        let largest = best.iter().fold(0.0_f64, |m, b| m.max(*b));
        let weights: Vec<f64> = best.iter().map(|b| 1.0 / b.max(1e-6 * largest).powi(2)).collect();
        // The square of a bound can leave the range of binary64.
        if weights.iter().any(|w| !(w.is_finite() && *w > 0.0)) {
            return Err(unproved());
        }
        let cost = |share: f64| {
            Reached::new(time, &f, &g, share * fastest).map_or(f64::INFINITY, |reached| reached.combined(&weights).1)
        };
        let start = shares.iter().copied().min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(0.5);
        let share = golden(start / 1.2, (start * 1.2).min(0.985), 20, cost);
        let rate = share * fastest;
        let reached = Reached::new(time, &f, &g, rate).ok_or_else(unproved)?;
        let (d, _) = reached.combined(&weights);
        let mut z: DMatrix<f64> = reached.parts.iter().zip(&d).map(|(part, d)| part * *d).sum();
        // Directions that no disturbance reaches, so that P exists.
        let scaling = DMatrix::from_diagonal(&DVector::from_iterator(n, weights.iter().map(|w| 1e-9 / w)));
        z += equation(time, &f, rate).and_then(|mut equation| equation.solve(&scaling)).ok_or_else(unproved)?;
        let z = symmetric_part(&z);
        // Rounding can take its definiteness, or the range of binary64.
        let inverse = z.clone().cholesky().map(|root| symmetric_part(&root.inverse()));
        let p = inverse.filter(|p| p.iter().all(|x| x.is_finite())).ok_or_else(unproved)?;
        let lambda = d.iter().zip(&self.bounds).map(|(d, w)| (1.0 / d) / (w * w)).collect();
        let limsup = (0..n).map(|k| shift(z[(k, k)].max(0.0).sqrt(), units.0[k])).collect();
        let p = units.form_back(&p);
        // A little less than the rate, for which the inequality holds strictly.
        Ok(Candidate { p, rate: rate * (1.0 - 1e-6), lambda, x: 0.0, limsup })
    }

    /// N, theta and the P of its design.
    fn cubic_part(
        &self,
        n_gain: &DMatrix<f64>,
        theta: &DMatrix<f64>,
        p: &DMatrix<f64>,
    ) -> Result<CubicPart, DesignError> {
        let (n, outputs) = (p.nrows(), self.c.nrows());
        check::matrix("N", n_gain, (n, outputs))?;
        let theta = check::positive_semidefinite("theta", theta, outputs)?;
        let p_inverse_ct = check::solve_definite("P", p, &self.c.transpose())?;
        let x = symmetric_part(&radial_s(&self.c, &p_inverse_ct, 1.0)?);
        let s = -(&x * (&self.c * n_gain));
        let accretive = symmetric_part(&s);
        let Some(root) = accretive.clone().cholesky() else {
            let lambda_min = luenberger_linalg::lambda_min(&accretive)?;
            return Err(luenberger_linalg::LinalgError::NotPositiveDefinite { what: "S + S'", lambda_min }.into());
        };
        // theta <= kappa S: the largest eigenvalue of root^-1 theta root^-T.
        let half = root.l().solve_lower_triangular(&theta).unwrap_or_else(|| theta.clone());
        let both = root.l().solve_lower_triangular(&half.transpose()).unwrap_or(half);
        let slack = 1.0 + 1e-9;
        let kappa = lambda_max(&symmetric_part(&both))? * slack;
        // D'S S_s^-1 S'D <= diag(mu), by the diagonal dominance that is sharp at the bounds.
        let column = s.transpose() * &self.d;
        let k = column.transpose() * root.solve(&column);
        let mu: Vec<f64> = (0..k.nrows())
            .map(|i| (0..k.ncols()).map(|j| k[(i, j)].abs() * self.bounds[j] / self.bounds[i]).sum::<f64>())
            .collect();
        // A disturbance of the states only needs no mu; the inequality is strict for the others.
        let mu: Vec<f64> = mu.into_iter().map(|mu| mu * slack).collect();
        let square: f64 = mu.iter().zip(&self.bounds).map(|(mu, w)| mu * w * w).sum();
        let cost = 27.0 / 128.0 * kappa * square * square;
        Ok(CubicPart { n: n_gain.clone(), theta, x, kappa, mu, p: p.clone(), cost })
    }
}

/// By how much numbers that are proved later are larger than computed.
const UP: f64 = 1.0 + 1e-7;

impl Candidate {
    /// The bounds of the components for this bound of V.
    fn limits(p: &DMatrix<f64>, level: f64) -> Result<Vec<f64>, DesignError> {
        let n = p.nrows();
        let z = check::solve_definite("P", p, &DMatrix::identity(n, n))?;
        Ok((0..n).map(|k| (level * z[(k, k)]).sqrt() * UP).collect())
    }

    /// The bounds in discrete time, and the theorem.
    fn certify_in_steps(self, system: &ErrorSystem, period: f64) -> Result<ErrorBound, DesignError> {
        let Self { p, rate, lambda, .. } = self;
        let factor = (-rate).exp();
        let all: f64 = lambda.iter().zip(&system.bounds).map(|(lambda, w)| lambda * w * w).sum();
        let level = all / spent(TimeDomain::Discrete, rate) * UP;
        let limsup = Self::limits(&p, level)?;
        let (a, e) = &system.vertices[0];
        let theorem = DiscreteInputToStateStability {
            vertices: vec![DisturbedPlant::exactly(&proof_matrix(a), &proof_matrix(e))?],
            c: proof_matrix(&system.c),
            d: DisturbedPlant::exactly(&proof_matrix(&system.d), &proof_matrix(&system.d))?.e,
            l: proof_matrix(&system.l),
            p: proof_matrix(&p),
            factor,
            lambda,
            disturbances: system.bounds.clone(),
            level,
            limsup: limsup.clone(),
        };
        let certificate = Certificate::of([theorem])?;
        Ok(ErrorBound { certificate, p, rate: rate / period, level, limsup, cubic_share: 0.0 })
    }

    /// The bounds, rounded up from those of this P, and the theorem.
    fn certify(self, system: &ErrorSystem) -> Result<ErrorBound, DesignError> {
        let Self { p, rate, lambda, x, .. } = self;
        let of_linear: f64 = lambda.iter().zip(&system.bounds).map(|(lambda, w)| lambda * w * w).sum();
        let of_cubic = system.cubic.as_ref().map_or(0.0, |part| part.cost * x);
        let level = (of_linear + of_cubic) / (2.0 * rate) * UP;
        let limsup = Self::limits(&p, level)?;
        let cubic = system.cubic.as_ref().map(|part| CubicTerm {
            n: proof_matrix(&part.n),
            theta: proof_matrix(&part.theta),
            x: proof_matrix(&symmetric_part(&(&part.x * x))),
            kappa: part.kappa / x * UP,
            mu: part.mu.iter().map(|mu| mu * x).collect(),
        });
        let exactly =
            |(a, e): &(DMatrix<f64>, DMatrix<f64>)| DisturbedPlant::exactly(&proof_matrix(a), &proof_matrix(e));
        let vertices = system.vertices.iter().map(exactly).collect::<Result<Vec<_>, ProofError>>()?;
        let d = DisturbedPlant::exactly(&proof_matrix(&system.d), &proof_matrix(&system.d))?.e;
        let theorem = InputToStateStability {
            vertices,
            c: proof_matrix(&system.c),
            d,
            l: proof_matrix(&system.l),
            cubic,
            p: proof_matrix(&p),
            rate,
            lambda,
            disturbances: system.bounds.clone(),
            level,
            limsup: limsup.clone(),
        };
        let cubic_share = of_cubic / (of_linear + of_cubic);
        Ok(ErrorBound { certificate: Certificate::of([theorem])?, p, rate, level, limsup, cubic_share })
    }
}
