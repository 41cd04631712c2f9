//! The LPV, or mean-value-theorem, design: one constant gain for a nonlinear plant on a box, with a proof.
//!
//! The observer `xhat' = f(t, xhat, u) + L (y - h(t, xhat))` has the error equation `e' = (Fbar - L Hbar) e`, with the
//! mean Jacobians of f and h over the segment from xhat to x. As long as x and xhat stay in a box, so does the segment,
//! and `(Fbar, Hbar)` lies in the convex hull of finitely many pairs `(A_k, C_k)`: the vertices of an
//! [enclosure](crate::enclosure) of Df and Dh over the box. The inequality
//! ```text
//!     (A_k - L C_k)'P + P (A_k - L C_k) + 2 rate P < 0        for all k,   P > 0                  (1)
//! ```
//! is linear in (A, C), so that it holds on the hull, and `V = e'Pe` decreases at least like `exp(-2 rate t)`:
//! ```text
//!     |x(t) - xhat(t)| <= sqrt(cond P) |x(0) - xhat(0)| exp(-rate t).                            (2)
//! ```
//! With `Y = P L` (1) is linear in (P, Y) also where the outputs are nonlinear. The enclosure is outward rounded and
//! (1) is verified by `luenberger-proof` for boxes around the vertices, so that a certificate covers every point of the
//! box and not only samples.
//!
//! The hull neglects correlations between the entries of a Jacobian; a refutation concerns the method, not observers in
//! general. Where (1) is infeasible the error gives the reason with a witness: an unobservable direction at some
//! point of the polytope (the unobservable subspace in exact arithmetic), or vertices that exclude each other
//! (multipliers). Without a witness it is undecided.
//!
//! Sources: A. Zemouche, M. Boutayeb, G. I. Bara, Observers for a class of Lipschitz systems with extension to
//! H-infinity performance analysis, Systems and Control Letters 57, 2008 (the mean value theorem and the polytope); S.
//! Boyd, L. El Ghaoui, E. Feron, V. Balakrishnan, Linear Matrix Inequalities in System and Control Theory, SIAM 1994,
//! section 5.1.

mod discrete;
mod error;
mod infeasibility;
mod polytope;
mod text;

use core::fmt;

use luenberger_linalg::{RealMatrixView, lambda_max};
use luenberger_lmi::{Infeasibility, Problem, Settings, Solution, greatest_parameter_with, he, proof_matrix};
use luenberger_observers::NonlinearLuenbergerObserver;
use luenberger_plants::{Plant, Size};
use luenberger_proof::Verdict;
use luenberger_proof::certificate::{Certificate, Certified, JacobianPolytope, ProvedSentence};
use luenberger_proof::statement::overshoot_bound;
use nalgebra::{DMatrix, DVector, DefaultAllocator, Dim, OMatrix, OVector};

pub use discrete::DiscreteLpvDesign;
pub use error::{Conflict, HiddenMode, LpvError, VaryingEntries};
pub use polytope::{MAX_VARYING, Polytope, Vertex};

use self::text::write_inequalities;
use crate::check;
use crate::enclosure::{IntervalDual, Region, enclose};
use crate::error::DesignError;
use crate::gain_lmi::{self, Gain};
use crate::gain_options::{Checked, GainOptions};
use crate::number::write_matrix;
use crate::robust::greatest_rate;

/// Relative accuracy of the greatest rate in [`LpvDesign::certify`].
const RELATIVE_RATE: f64 = 1e-3;

impl<S, N: Dim, M: Dim, P: Dim> Certified for LpvDesign<S, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    fn certificate(&self) -> &Certificate {
        &self.certificate
    }
}

/// A nonlinear Luenberger observer with the proof of its rate on a box.
#[readonly::make]
#[derive(Debug, Clone, PartialEq)]
pub struct LpvDesign<S, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The observer, ready to run.
    pub observer: NonlinearLuenbergerObserver<S, f64, N, M, P>,
    /// P of (1), n x n.
    pub p: DMatrix<f64>,
    /// The rate that (1) is stated with.
    pub rate: f64,
    /// An upper bound of `sqrt(cond P)` in (2); infinite if the certificate is not proved.
    pub overshoot: f64,
    /// The vertices, and the enclosure that they cover.
    pub polytope: Polytope,
    /// For each vertex the greatest rate that this P and L give it, in floating point.
    pub vertex_rates: Vec<f64>,
    /// The vertex that limits the rate, from 0: the one with the least of [`vertex_rates`](Self::vertex_rates).
    pub limiting: usize,
    /// The end of the search for the greatest rate: the least rate tried for which nothing was proved, and why. None
    /// for a given rate, and if the ceiling itself was reached.
    pub stopped: Option<(f64, Box<LpvError>)>,
    /// The box.
    pub region: Region,
    /// `P > 0` and (1) at every vertex.
    pub certificate: Certificate,
}

impl<S, N: Dim, M: Dim, P: Dim> LpvDesign<S, N, M, P>
where
    S: Plant<f64, State = OVector<f64, N>, Input = OVector<f64, M>, Output = OVector<f64, P>> + Plant<IntervalDual>,
    DefaultAllocator: Size<N, M, P>,
{
    /// The gain with the largest margin for which every error in the box decays at least like `exp(-rate t)`.
    ///
    /// Cost: the enclosure, a few SDPs of `n(n+1)/2 + np` unknowns with an inequality for each vertex that matters, and
    /// one proof for each of the 2^k vertices, k the number of varying entries.
    ///
    /// ```
    /// use luenberger_design::{LpvDesign, Region};
    /// use luenberger_plants::flexible_joint;
    /// let design = LpvDesign::new(flexible_joint::classical(), &Region::everywhere(4), 1.0)?;
    /// assert_eq!(design.polytope.vertices.len(), 2);
    /// assert!(design.certificate.is_proved());
    /// println!("{design}");
    /// # Ok::<(), luenberger_design::LpvError>(())
    /// ```
    /// # Errors
    /// [`LpvError::Enclosure`] for the box, and for a Jacobian that is not bounded on it, with the point;
    /// [`LpvError::TooManyVertices`]; [`DesignError::BadRate`];
    /// [`LpvError::HiddenMode`] names an unobservable direction, with an exact witness, [`LpvError::Conflict`] the
    /// vertices that exclude each other, with verified multipliers; [`DesignError::Undecided`] with the best margin
    /// found.
    pub fn new(plant: S, region: &Region, rate: f64) -> Result<Self, LpvError> {
        Self::new_with(plant, region, rate, &GainOptions::default())
    }

    /// [`new`](Self::new) with a bound of the gain, the least noise gain, or another solver.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`LmiError::NotBuiltIn`](luenberger_lmi::LmiError::NotBuiltIn) in [`DesignError::Lmi`].
    pub fn new_with(plant: S, region: &Region, rate: f64, options: &GainOptions) -> Result<Self, LpvError> {
        check::rate(rate)?;
        let polytope = Polytope::new(enclose(&plant, region)?)?;
        let gain = common_gain(&polytope, rate, options)?;
        Self::certified(plant, region, polytope, gain, rate, None)
    }

    /// The gain with the greatest rate that can be proved in `[0, ceiling]`, to within `tolerance`.
    ///
    /// A ceiling is required: for many plants every rate is possible, with gains that grow without bound.
    /// [`stopped`](Self::stopped) has the reason why a greater rate was not proved.
    ///
    /// Cost: that of [`new`](Self::new) for each of `2 + log2(ceiling / tolerance)` steps.
    ///
    /// # Errors
    /// As [`new`](Self::new) at the rate 0; a ceiling or tolerance that is not positive and finite.
    pub fn max_rate(plant: S, region: &Region, ceiling: f64, tolerance: f64) -> Result<Self, LpvError> {
        Self::max_rate_with(plant, region, ceiling, tolerance, &GainOptions::default())
    }

    /// [`max_rate`](Self::max_rate) with a bound of the gain, or another solver. Noise is considered at each rate, and
    /// does not limit it.
    ///
    /// # Errors
    /// As [`max_rate`](Self::max_rate); [`LmiError::NotBuiltIn`](luenberger_lmi::LmiError::NotBuiltIn) in
    /// [`DesignError::Lmi`].
    pub fn max_rate_with(
        plant: S,
        region: &Region,
        ceiling: f64,
        tolerance: f64,
        options: &GainOptions,
    ) -> Result<Self, LpvError> {
        check::positive("ceiling", ceiling)?;
        check::positive("tolerance", tolerance)?;
        let polytope = Polytope::new(enclose(&plant, region)?)?;
        let limits = options.check(polytope.enclosure.c.rows())?;
        let family = |rate| pose(&polytope, rate, &limits, &options.settings);
        let bisection = greatest_parameter_with(&options.settings, 0.0, ceiling, tolerance, family)?;
        let stopped = bisection.stopped.map(|(rate, verdict)| (rate, why_not(&polytope, rate, verdict, options)));
        let (rate, solution, stopped) = outcome(bisection.proved, stopped)?;
        Self::certified(plant, region, polytope, gain_lmi::gain_of(&solution)?, rate, stopped)
    }

    /// The greatest rate that some P proves for a given gain L (n x p), to within 0.1 % of what the eigenvalues at the
    /// vertices allow.
    ///
    /// # Errors
    /// [`DesignError::Matrix`] for the shape and entries of L; [`LpvError::UnstableVertex`] names a vertex at which
    /// `A - L C` is not Hurwitz;
    /// [`LpvError::Conflict`] when no P serves all vertices; the errors of the enclosure.
    pub fn certify<'a>(plant: S, region: &Region, l: impl Into<RealMatrixView<'a>>) -> Result<Self, LpvError> {
        Self::certify_with(plant, region, l, &Settings::default())
    }

    /// [`certify`](Self::certify) by the solver of `settings`.
    ///
    /// # Errors
    /// As [`certify`](Self::certify); [`LmiError::NotBuiltIn`](luenberger_lmi::LmiError::NotBuiltIn) in
    /// [`DesignError::Lmi`].
    pub fn certify_with<'a>(
        plant: S,
        region: &Region,
        l: impl Into<RealMatrixView<'a>>,
        settings: &Settings,
    ) -> Result<Self, LpvError> {
        Self::certify_gain(plant, region, check::owned(l), settings)
    }

    fn certify_gain(plant: S, region: &Region, l: DMatrix<f64>, settings: &Settings) -> Result<Self, LpvError> {
        let polytope = Polytope::new(enclose(&plant, region)?)?;
        let (n, outputs) = (polytope.enclosure.a.rows(), polytope.enclosure.c.rows());
        check::matrix("L", &l, (n, outputs))?;
        let mut high = f64::INFINITY;
        for (vertex, pair) in polytope.vertices.iter().enumerate() {
            let abscissa = match check::hurwitz("A - L C", (&pair.a, &l, &pair.c)) {
                Err(DesignError::NotHurwitz { abscissa, .. }) => {
                    return Err(LpvError::UnstableVertex { vertex, place: pair.to_string(), abscissa });
                }
                other => other?,
            };
            // Rounding can hide how stable it is.
            high = high.min((-abscissa).max(0.0));
        }
        let tolerance = (RELATIVE_RATE * high).max(f64::MIN_POSITIVE);
        let family = |rate| pose_for(&polytope, &l, rate, settings);
        let bisection = greatest_parameter_with(settings, 0.0, high, tolerance, family)?;
        let stopped = bisection.stopped.map(|(rate, verdict)| (rate, for_this_gain(&polytope, rate, verdict)));
        let (rate, solution, stopped) = outcome(bisection.proved, stopped)?;
        let p = solution.named("P").cloned().unwrap_or_else(|| DMatrix::zeros(0, 0));
        Self::certified(plant, region, polytope, Gain { l, p }, rate, stopped)
    }

    fn certified(
        plant: S,
        region: &Region,
        polytope: Polytope,
        gain: Gain,
        rate: f64,
        stopped: Option<Stop>,
    ) -> Result<Self, LpvError> {
        let Gain { l, p } = gain;
        let mut vertex_rates = Vec::with_capacity(polytope.vertices.len());
        for vertex in &polytope.vertices {
            vertex_rates.push(rate_at(&(&vertex.a - &l * &vertex.c), &p)?);
        }
        let vertices = polytope.corners()?;
        let theorem = JacobianPolytope { vertices, l: proof_matrix(&l), p: proof_matrix(&p), rate };
        let certificate = Certificate::of_jacobians(theorem, &polytope.enclosure.a, &polytope.enclosure.c)?;
        let overshoot = if certificate.is_proved() { overshoot_bound(&proof_matrix(&p))? } else { f64::INFINITY };
        let limiting =
            (0..vertex_rates.len()).min_by(|&i, &j| vertex_rates[i].total_cmp(&vertex_rates[j])).unwrap_or(0);
        let size = plant.dimensions();
        let l =
            OMatrix::<f64, N, P>::from_fn_generic(N::from_usize(size.states), P::from_usize(size.outputs), |i, j| {
                l[(i, j)]
            });
        let observer = NonlinearLuenbergerObserver::new(plant, l)?;
        let region = region.clone();
        Ok(Self { observer, p, rate, overshoot, polytope, vertex_rates, limiting, stopped, region, certificate })
    }
}

impl<S, N: Dim, M: Dim, P: Dim> LpvDesign<S, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// How far each component of the error can ever be from 0 when it starts at `e0` (n entries):
    /// `|e_i(t)| <= sqrt((P^-1)_ii e0'P e0)`, to rounding; none for another length.
    ///
    /// This verifies the hypothesis: if x(t) stays at these distances inside the box, xhat(t) stays in the box.
    pub fn excursion(&self, e0: &DVector<f64>) -> Option<DVector<f64>> {
        let inverse = self.p.clone().cholesky()?.inverse();
        (e0.len() == self.p.nrows()).then(|| {
            let value = e0.dot(&(&self.p * e0));
            inverse.diagonal().map(|entry| (entry * value).sqrt())
        })
    }

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
        self.polytope.enclosure.sentence(&self.certificate, &self.region, ("xhat", "t"))
    }
}

impl<S, N: Dim, M: Dim, P: Dim> fmt::Display for LpvDesign<S, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_matrix(f, "L", self.l())?;
        if let Some(sentence) = self.sentence() {
            writeln!(f, "{sentence}")?;
        }
        if let (Some(rate), Some(vertex)) =
            (self.vertex_rates.get(self.limiting), self.polytope.vertices.get(self.limiting))
        {
            writeln!(f, "Vertex {} limits the rate, to {rate:.6}: {vertex}.", self.limiting + 1)?;
        }
        write_inequalities(f, self.stopped.as_ref(), &self.certificate, &self.vertex_names())
    }
}

impl Polytope {
    /// A gain L (n x p) with which every pair `(A_k, C_k)`, and each of their convex hull, decays at this rate by one
    /// P; also for vertices that are no interval hull.
    ///
    /// # Errors
    /// As [`LpvDesign::new_with`], without those of the enclosure.
    pub fn common_gain(&self, rate: f64, options: &GainOptions) -> Result<DMatrix<f64>, LpvError> {
        check::rate(rate)?;
        Ok(common_gain(self, rate, options)?.l)
    }
}

/// L and P for all vertices.
fn common_gain(polytope: &Polytope, rate: f64, options: &GainOptions) -> Result<Gain, LpvError> {
    let limits = options.check(polytope.enclosure.c.rows())?;
    let solution = pose(polytope, rate, &limits, &options.settings).solve_with(&options.settings)?;
    if !solution.verdict.is_proved() {
        return Err(why_not(polytope, rate, solution.verdict, options));
    }
    Ok(gain_lmi::gain_of(&solution)?)
}

/// (1) for P and Y at the relevant vertices.
fn pose(polytope: &Polytope, rate: f64, limits: &Checked, settings: &Settings) -> Problem {
    let at = |active: &[usize]| {
        let mut lmi = Problem::new();
        let vertices = active.iter().map(|&k| (k, &polytope.vertices[k].a, &polytope.vertices[k].c));
        gain_lmi::pose(&mut lmi, vertices, rate, limits);
        lmi
    };
    let half = |solution: &Solution, vertex: &Vertex| {
        let (p, y) = (solution.named("P")?, solution.named("Y")?);
        let half = p * &vertex.a - y * &vertex.c;
        let mut halves = vec![&half + p * rate];
        halves.extend(limits.covariance_term(y).map(|term| half + term * 0.5));
        Some(halves)
    };
    growing(polytope, at, half, settings)
}

/// (1) for P with a given gain.
fn pose_for(polytope: &Polytope, l: &DMatrix<f64>, rate: f64, settings: &Settings) -> Problem {
    let at = |active: &[usize]| {
        let mut lmi = Problem::new();
        let p = lmi.symmetric("P", l.nrows());
        lmi.constrain("P > 0", &p >> 0.0);
        for &k in active {
            let vertex = &polytope.vertices[k];
            // The factors one by one: what is refuted is then refuted for exactly these numbers.
            let half = &p * &vertex.a - &p * l * &vertex.c;
            lmi.constrain(&gain_lmi::decrease_at(k), (he(half) + (2.0 * rate) * &p) << 0.0);
        }
        lmi
    };
    let half = |solution: &Solution, vertex: &Vertex| {
        let p = solution.named("P")?;
        Some(vec![p * (&vertex.a - l * &vertex.c) + p * rate])
    };
    growing(polytope, at, half, settings)
}

/// Up to this many vertices, all inequalities are posed at once.
const AT_ONCE: usize = 16;

/// Number of vertices added per round.
const ADDED: usize = 4;

/// The problem at a set of vertices that grows until its solution satisfies all of them with half its margin, or until
/// it is infeasible: infeasibility for a few vertices implies it for all. `halves` are X of each left-hand side X + X'
/// that has to be negative at a vertex. The solution is approximate; the verification uses every vertex.
fn growing(
    polytope: &Polytope,
    at: impl Fn(&[usize]) -> Problem,
    halves: impl Fn(&Solution, &Vertex) -> Option<Vec<DMatrix<f64>>>,
    settings: &Settings,
) -> Problem {
    let count = polytope.vertices.len();
    if count <= AT_ONCE {
        return at(&(0..count).collect::<Vec<_>>());
    }
    // Opposite corners, twice.
    let alternating = 0x5555_5555 & (count - 1);
    let mut active = vec![0, count - 1, alternating, count - 1 - alternating];
    // Every round adds a vertex, so that there are at most as many rounds as vertices.
    loop {
        let problem = at(&active);
        let Ok(solution) = problem.solve_with(settings) else { return problem };
        let Some(margin) = solution.verdict.margin() else { return problem };
        let slope = |k: &usize| {
            let halves = halves(&solution, &polytope.vertices[*k])?;
            let slopes = halves.iter().map(|half| lambda_max(&(half + half.transpose())));
            slopes.collect::<Result<Vec<f64>, _>>().ok()?.into_iter().reduce(f64::max)
        };
        let mut violated: Vec<(usize, f64)> = (0..count)
            .filter(|k| !active.contains(k))
            .map(|k| (k, slope(&k).unwrap_or(f64::INFINITY)))
            .filter(|(_, slope)| *slope > -0.5 * margin)
            .collect();
        if violated.is_empty() {
            return problem;
        }
        violated.sort_by(|x, y| y.1.total_cmp(&x.1));
        active.extend(violated.iter().take(ADDED).map(|(k, _)| *k));
    }
}

/// Why there is no gain: for a rate alone the mode or the vertices that exclude it, within limits the constraints that
/// exclude each other.
fn why_not(polytope: &Polytope, rate: f64, verdict: Verdict<Infeasibility>, options: &GainOptions) -> LpvError {
    if options.only_rate() {
        infeasibility::explain(polytope, rate, verdict, &options.settings)
    } else {
        DesignError::not_proved(gain_lmi::within_limits(options), Some(verdict)).into()
    }
}

/// Why no P serves all vertices with a given gain, each of which is Hurwitz.
fn for_this_gain(polytope: &Polytope, rate: f64, verdict: Verdict<Infeasibility>) -> LpvError {
    match verdict {
        Verdict::Refuted { witness } => LpvError::Conflict(Box::new(Conflict::of(polytope, rate, witness))),
        other => DesignError::not_proved(GIVEN, Some(other)).into(),
    }
}

/// A rate for which nothing was proved, and why.
type Stop = (f64, Box<LpvError>);

/// The greatest rate that was proved with its solution, and where the search ended; why there is none, if no rate was
/// proved.
fn outcome(
    proved: Option<(f64, Solution)>,
    stopped: Option<(f64, LpvError)>,
) -> Result<(f64, Solution, Option<Stop>), LpvError> {
    match (proved, stopped) {
        (Some((rate, solution)), stopped) => Ok((rate, solution, stopped.map(|(rate, error)| (rate, Box::new(error))))),
        (None, Some((_, error))) => Err(error),
        (None, None) => Err(DesignError::not_proved(GIVEN, None).into()),
    }
}

const GIVEN: &str = "P > 0, (A - LC)'P + P(A - LC) + 2 rate P < 0 at all vertices";

/// The greatest r with `F'P + PF + 2 r P <= 0`, in floating point; NaN where P is not positive definite.
fn rate_at(f: &DMatrix<f64>, p: &DMatrix<f64>) -> Result<f64, DesignError> {
    let half = p * f;
    Ok(greatest_rate(p, &-(&half + half.transpose()))?.unwrap_or(f64::NAN))
}
