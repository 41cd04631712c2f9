//! The LPV design in discrete time: one constant gain for `x+ = f(t, x, u)` on a box, with a proof.
//!
//! The observer `xhat+ = f(t, xhat, u) + L (y - h(t, xhat))` has the error `e+ = (Fbar - L Hbar) e`, with the mean
//! Jacobians of f and h over the segment from xhat to x, which lie in the convex hull of the vertices `(A_k, C_k)` of
//! the [polytope](super::Polytope) of the box as long as x and xhat stay in it. With `F_k = A_k - L C_k`
//! ```text
//!     [ q^2 P    F_k'P ]
//!     [ P F_k    P     ] > 0        for all k                                                    (1)
//! ```
//! is linear in (A, C), so that it holds on the hull; by the Schur complement it says `F'P F < q^2 P` there, and
//! ```text
//!     |x(k) - xhat(k)| <= sqrt(cond P) |x(0) - xhat(0)| q^k.                                      (2)
//! ```
//! With `Y = P L` (1) is linear in (P, Y). The factor q belongs to a decay rate per unit of time, `q = exp(-rate h)`
//! for the period h.
//!
//! With measurement noise of covariance V per sample the least noise gain is asked for by
//! ```text
//!     [ P          F_k'P   0    ]
//!     [ P F_k      P       Y    ] > 0,    [ Z  I ]
//!     [ 0          Y'      V^-1 ]         [ I  P ] > 0,    minimise trace Z,
//! ```
//! the first of which is `F P^-1 F' + L V L' < P^-1`: the noise leaves the error with a covariance of at most P^-1.
//!
//! Sources: A. Zemouche, M. Boutayeb, Observer design for Lipschitz nonlinear systems: the discrete-time case, IEEE
//! Transactions on Circuits and Systems II 53, 2006 (the mean value theorem and the polytope); M. C. de Oliveira, J.
//! Bernussou, J. C. Geromel, A new discrete-time robust stability condition, Systems and Control Letters 37, 1999.

use core::fmt;

use luenberger_linalg::{RealMatrixView, eigenvalues, lambda_max};
use luenberger_lmi::{Problem, Settings, Solution, block, greatest_parameter_with, proof_matrix};
use luenberger_observers::DiscreteNonlinearObserver;
use luenberger_plants::{Plant, Size};
use luenberger_proof::Verdict;
use luenberger_proof::certificate::{Certificate, Certified, DiscreteJacobianPolytope, ProvedSentence};
use luenberger_proof::statement::overshoot_bound;
use nalgebra::{DMatrix, DefaultAllocator, Dim, OMatrix, OVector};

use super::error::{Conflict, LpvError};
use super::polytope::{Polytope, Vertex};
use super::text::write_inequalities;
use super::{Stop, growing, outcome};
use crate::check;
use crate::enclosure::{IntervalDual, Region, enclose};
use crate::error::DesignError;
use crate::gain_lmi::{self, Gain};
use crate::gain_options::{Checked, GainOptions};
use crate::number::write_matrix;

/// Relative accuracy of the greatest rate in [`DiscreteLpvDesign::certify`].
const RELATIVE_RATE: f64 = 1e-3;

const WHAT: &str = "[q^2 P, A'P - C'Y'; *, P] > 0";

/// An observer with a constant gain for a nonlinear plant in discrete time, with the proof of its rate on a box.
#[readonly::make]
#[derive(Debug, Clone, PartialEq)]
pub struct DiscreteLpvDesign<S, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The observer, ready to run.
    pub observer: DiscreteNonlinearObserver<S, f64, N, M, P>,
    /// P of (1), n x n.
    pub p: DMatrix<f64>,
    /// The decay rate per unit of time.
    pub rate: f64,
    /// The factor q of (1) by which errors fall at each step, `exp(-rate h)`.
    pub factor: f64,
    /// An upper bound of `sqrt(cond P)` in (2); infinite if the certificate is not proved.
    pub overshoot: f64,
    /// The vertices, and the enclosure that they cover.
    pub polytope: Polytope,
    /// For each vertex the least factor that this P and L give it, in floating point.
    pub vertex_factors: Vec<f64>,
    /// The end of the search for the greatest rate: the least rate tried for which nothing was proved, and why. None
    /// for a given rate, and if the ceiling itself was reached.
    pub stopped: Option<(f64, Box<LpvError>)>,
    /// The box.
    pub region: Region,
    /// `P > 0` and (1) at every vertex.
    pub certificate: Certificate,
}

impl<S, N: Dim, M: Dim, P: Dim> Certified for DiscreteLpvDesign<S, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    fn certificate(&self) -> &Certificate {
        &self.certificate
    }
}

impl<S, N: Dim, M: Dim, P: Dim> DiscreteLpvDesign<S, N, M, P>
where
    S: Plant<f64, State = OVector<f64, N>, Input = OVector<f64, M>, Output = OVector<f64, P>> + Plant<IntervalDual>,
    DefaultAllocator: Size<N, M, P>,
{
    /// The gain for which every error in the box decays at least like `exp(-rate t)`, of a plant whose `derivative` is
    /// its next state after a `period`.
    ///
    /// ```
    /// use luenberger_design::{DiscreteLpvDesign, Region};
    /// use luenberger_plants::VanDerPol;
    /// // Any right-hand side, read as the next state: here that of van der Pol's oscillator, with mu = 0.1.
    /// let plant = VanDerPol { mu: 0.1 };
    /// let design = DiscreteLpvDesign::new(plant, 0.5, &Region::new(&[(-1.0, 1.0), (-1.0, 1.0)]), 0.1, &Default::default())?;
    /// assert!(design.certificate.is_proved() && design.factor == (-0.05f64).exp());
    /// # Ok::<(), luenberger_design::LpvError>(())
    /// ```
    /// # Errors
    /// [`LpvError::Enclosure`], [`LpvError::TooManyVertices`]; [`DesignError::BadRate`]; [`LpvError::Conflict`] names
    /// the vertices that exclude each other, with verified multipliers; [`DesignError::Undecided`] with the best margin
    /// found.
    pub fn new(plant: S, period: f64, region: &Region, rate: f64, options: &GainOptions) -> Result<Self, LpvError> {
        check::rate(rate)?;
        check::positive("the period", period)?;
        let polytope = Polytope::new(enclose(&plant, region)?)?;
        let limits = options.check(polytope.enclosure.c.rows())?;
        let solution = pose(&polytope, rate * period, &limits, &options.settings).solve_with(&options.settings)?;
        if !solution.verdict.is_proved() {
            return Err(why_not(&polytope, rate, solution.verdict));
        }
        let gain = gain_lmi::gain_of(&solution)?;
        Self::certified((plant, period), region, polytope, gain, rate, None)
    }

    /// The gain with the greatest rate that can be proved in `[0, ceiling]`, to within `tolerance`.
    ///
    /// # Errors
    /// As [`new`](Self::new) at the rate 0; a ceiling or tolerance that is not positive and finite.
    pub fn max_rate(
        plant: S,
        period: f64,
        region: &Region,
        (ceiling, tolerance): (f64, f64),
        options: &GainOptions,
    ) -> Result<Self, LpvError> {
        check::positive("the period", period)?;
        check::positive("ceiling", ceiling)?;
        check::positive("tolerance", tolerance)?;
        let polytope = Polytope::new(enclose(&plant, region)?)?;
        let limits = options.check(polytope.enclosure.c.rows())?;
        let family = |rate| pose(&polytope, rate * period, &limits, &options.settings);
        let bisection = greatest_parameter_with(&options.settings, 0.0, ceiling, tolerance, family)?;
        let stopped = bisection.stopped.map(|(rate, verdict)| (rate, why_not(&polytope, rate, verdict)));
        let (rate, solution, stopped) = outcome(bisection.proved, stopped)?;
        Self::certified((plant, period), region, polytope, gain_lmi::gain_of(&solution)?, rate, stopped)
    }

    /// The greatest rate that some P proves for a given gain L (n x p), to within 0.1 % of what the eigenvalues at the
    /// vertices allow.
    ///
    /// # Errors
    /// [`DesignError::Matrix`] for the shape and entries of L; [`DesignError::NotSchur`] if `A - L C` has an eigenvalue
    /// outside the unit circle at a vertex; [`LpvError::Conflict`] when no P serves all vertices; the errors of the
    /// enclosure.
    pub fn certify<'a>(
        plant: S,
        period: f64,
        region: &Region,
        l: impl Into<RealMatrixView<'a>>,
        settings: &Settings,
    ) -> Result<Self, LpvError> {
        Self::certify_gain((plant, period), region, check::owned(l), settings)
    }

    fn certify_gain(
        (plant, period): (S, f64),
        region: &Region,
        l: DMatrix<f64>,
        settings: &Settings,
    ) -> Result<Self, LpvError> {
        check::positive("the period", period)?;
        let polytope = Polytope::new(enclose(&plant, region)?)?;
        check::matrix("L", &l, (polytope.enclosure.a.rows(), polytope.enclosure.c.rows()))?;
        let mut slowest = 0.0f64;
        for vertex in &polytope.vertices {
            let poles = eigenvalues(&(&vertex.a - &l * &vertex.c))?;
            slowest = poles.iter().map(|pole| pole.norm()).fold(slowest, f64::max);
        }
        if slowest >= 1.0 {
            return Err(DesignError::NotSchur { what: "A - L C at a vertex", radius: slowest }.into());
        }
        // A deadbeat gain has no slowest mode; twenty-fold per step is as good as at once.
        let high = (-slowest.max(1e-20).ln()).min(3.0) / period;
        let family = |rate| pose_for(&polytope, &l, rate * period, settings);
        let bisection = greatest_parameter_with(settings, 0.0, high, RELATIVE_RATE * high, family)?;
        let stopped = bisection.stopped.map(|(rate, verdict)| (rate, why_not(&polytope, rate, verdict)));
        let (rate, solution, stopped) = outcome(bisection.proved, stopped)?;
        let p = solution.named("P").cloned().unwrap_or_else(|| DMatrix::zeros(0, 0));
        Self::certified((plant, period), region, polytope, Gain { l, p }, rate, stopped)
    }

    fn certified(
        (plant, period): (S, f64),
        region: &Region,
        polytope: Polytope,
        Gain { l, p }: Gain,
        rate: f64,
        stopped: Option<Stop>,
    ) -> Result<Self, LpvError> {
        let factor = (-rate * period).exp();
        let mut vertex_factors = Vec::with_capacity(polytope.vertices.len());
        for vertex in &polytope.vertices {
            vertex_factors.push(factor_at(&(&vertex.a - &l * &vertex.c), &p)?);
        }
        let vertices = polytope.corners()?;
        let theorem = DiscreteJacobianPolytope { vertices, l: proof_matrix(&l), p: proof_matrix(&p), factor };
        let certificate = Certificate::of_jacobians(theorem, &polytope.enclosure.a, &polytope.enclosure.c)?;
        let overshoot = if certificate.is_proved() { overshoot_bound(&proof_matrix(&p))? } else { f64::INFINITY };
        let size = plant.dimensions();
        let (n, outputs) = (N::from_usize(size.states), P::from_usize(size.outputs));
        let l = OMatrix::<f64, N, P>::from_fn_generic(n, outputs, |i, j| l[(i, j)]);
        let observer = DiscreteNonlinearObserver::new(plant, l, period)?;
        let region = region.clone();
        Ok(Self { observer, p, rate, factor, overshoot, polytope, vertex_factors, stopped, region, certificate })
    }
}

impl<S, N: Dim, M: Dim, P: Dim> DiscreteLpvDesign<S, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The observer gain L, n x p.
    pub fn l(&self) -> &OMatrix<f64, N, P> {
        self.observer.l()
    }

    /// Labels of the vertices by their varying entries, for
    /// [`Fact::inequality_naming`](luenberger_proof::certificate::Fact::inequality_naming).
    pub fn vertex_names(&self) -> Vec<String> {
        self.polytope.vertices.iter().map(ToString::to_string).collect()
    }

    /// What is proved, with its hypothesis; none if the certificate is not proved.
    pub fn sentence(&self) -> Option<ProvedSentence> {
        self.polytope.enclosure.sentence(&self.certificate, &self.region, ("xhat", "k"))
    }
}

impl<S, N: Dim, M: Dim, P: Dim> fmt::Display for DiscreteLpvDesign<S, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_matrix(f, "L", self.l())?;
        if let Some(sentence) = self.sentence() {
            writeln!(f, "{sentence}")?;
        }
        let slowest = self.vertex_factors.iter().zip(&self.polytope.vertices).enumerate();
        if let Some((k, (factor, vertex))) = slowest.max_by(|x, y| x.1.0.total_cmp(y.1.0)) {
            writeln!(f, "Vertex {} limits the factor, to {factor:.6}: {vertex}.", k + 1)?;
        }
        write_inequalities(f, self.stopped.as_ref(), &self.certificate, &self.vertex_names())
    }
}

/// (1) for P and Y at the relevant vertices, for `decay`, the rate times the period.
fn pose(polytope: &Polytope, decay: f64, limits: &Checked, settings: &Settings) -> Problem {
    let square = (-2.0 * decay).exp();
    let at = |active: &[usize]| {
        let mut lmi = Problem::new();
        let vertices = active.iter().map(|&k| (k, &polytope.vertices[k].a, &polytope.vertices[k].c));
        let shape = (polytope.enclosure.c.rows(), polytope.enclosure.a.rows());
        gain_lmi::pose_in_steps(&mut lmi, vertices, shape, square, limits);
        lmi
    };
    let halves = |solution: &Solution, vertex: &Vertex| {
        let (p, y) = (solution.named("P")?, solution.named("Y")?);
        let corner = p * &vertex.a - y * &vertex.c;
        let mut halves = vec![negative_half(p, &corner, square)];
        if let Some(term) = limits.covariance_term(y) {
            // P - Y V Y' in place of the last block, by the Schur complement.
            let mut half = negative_half(p, &corner, 1.0);
            let n = p.nrows();
            let mut last = half.view_mut((n, n), (n, n));
            last += term * 0.5;
            halves.push(half);
        }
        Some(halves)
    };
    growing(polytope, at, halves, settings)
}

/// (1) for P with a given gain.
fn pose_for(polytope: &Polytope, l: &DMatrix<f64>, decay: f64, settings: &Settings) -> Problem {
    let square = (-2.0 * decay).exp();
    let at = |active: &[usize]| {
        let mut lmi = Problem::new();
        let p = lmi.symmetric("P", l.nrows());
        lmi.constrain("P > 0", &p >> 0.0);
        for &k in active {
            let vertex = &polytope.vertices[k];
            // The factors one by one: what is refuted is then refuted for exactly these numbers.
            let corner = &p * &vertex.a - &p * l * &vertex.c;
            let rows = block![[square * &p, corner.transpose()], [corner, &p]];
            lmi.constrain(&gain_lmi::decrease_at(k), rows >> 0.0);
        }
        lmi
    };
    let halves = |solution: &Solution, vertex: &Vertex| {
        let p = solution.named("P")?;
        Some(vec![negative_half(p, &(p * (&vertex.a - l * &vertex.c)), square)])
    };
    growing(polytope, at, halves, settings)
}

/// X with `X + X' = -[square P, corner'; corner, P]`.
fn negative_half(p: &DMatrix<f64>, corner: &DMatrix<f64>, square: f64) -> DMatrix<f64> {
    let n = p.nrows();
    let mut half = DMatrix::zeros(2 * n, 2 * n);
    half.view_mut((0, 0), (n, n)).copy_from(&(p * (-0.5 * square)));
    half.view_mut((n, 0), (n, n)).copy_from(&-corner);
    half.view_mut((n, n), (n, n)).copy_from(&(p * -0.5));
    half
}

/// The least q with `F'PF <= q^2 P`, in floating point; NaN where P is not positive definite.
fn factor_at(f: &DMatrix<f64>, p: &DMatrix<f64>) -> Result<f64, DesignError> {
    let Some(root) = p.clone().cholesky().map(|factor| factor.l()) else { return Ok(f64::NAN) };
    let Some(scaled) = root.solve_lower_triangular(&(f.transpose() * &root)) else { return Ok(f64::NAN) };
    Ok(lambda_max(&(&scaled * scaled.transpose()))?.max(0.0).sqrt())
}

/// Why there is no gain, or no P for a given one.
fn why_not(polytope: &Polytope, rate: f64, verdict: Verdict<luenberger_lmi::Infeasibility>) -> LpvError {
    match verdict {
        Verdict::Refuted { witness } if !witness.multipliers.iter().any(|m| m.constraint.contains("max_gain")) => {
            LpvError::Conflict(Box::new(Conflict::of(polytope, rate, witness)))
        }
        other => DesignError::not_proved(WHAT, Some(other)).into(),
    }
}
