//! Observers of Lipschitz plants: one gain L that ensures convergence for every nonlinearity within its bounds.
//!
//! Plant `x' = A x + sum_k G_k phi_k(t, H_k x, u) + known terms`, `y = C x`; the implemented observer is
//! [`NonlinearLuenbergerObserver`]. Each phi_k is only known to lie in an incremental [`Sector`]: `|phi(x) - phi(z)| <=
//! gamma |x - z|` (Thau, Rajamani), the same with G and H (structured), or a slope in `[low, high]` (circle criterion).
//! With `w_k` the difference of phi_k between x and xhat, the error obeys `e' = (A - LC) e + sum G_k w_k`, and the
//! inequality
//! ```text
//! [ A'P + PA - YC - C'Y' + 2 rate P - sum tau_k low_k high_k H_k'H_k     P G_k + tau_k (low_k + high_k)/2 H_k' ]
//! [ its transpose                                                                     -tau_k I                ]  < 0,   P > 0,   L = P^-1 Y
//! ```
//! makes `V = e'Pe` decay faster than `exp(-2 rate t)`. For one sector it is necessary too: refuted means that no L and
//! no quadratic V work for every phi of the sector. For several it is sufficient only.
//!
//! The largest admissible constant: for C = [I 0] with one unmeasured direction v, `G = H = I`, the largest constant
//! over all L is `min over s >= 0 of |(A - s I) v|`: the smallest perturbation of A for which (A, C) loses
//! detectability (Rajamani and Cho). It depends on the units of the unmeasured states ([`Sector::rescaled`]), and
//! specifying where phi acts (G, H) is at least as good as any scaling ([`Sector::structured`]): what rescaling proves,
//! structure proves with the same P.
//!
//! Sources: F. E. Thau, International Journal of Control 17, 1973; R. Rajamani, IEEE Transactions on Automatic Control
//! 43, 1998; R. Rajamani and Y. M. Cho, Existence and design of observers for nonlinear systems: relation to distance
//! to unobservability, International Journal of Control 69, 1998; M. Arcak and P. Kokotovic, Automatica 37, 2001.

mod admissible;
mod sector;
mod split;

use luenberger_linalg::RealMatrixView;
use luenberger_lmi::{Expression, Problem, Settings, Solution, he, proof_matrix, zeros};
use luenberger_observers::NonlinearLuenbergerObserver;
use luenberger_plants::{Plant, Size};
use luenberger_proof::ProofError;
use luenberger_proof::certificate::{Certificate, SectorConvergence, Vertex};
use nalgebra::{DMatrix, DefaultAllocator, Dim, OVector};

pub use admissible::{AdmissibleFactor, greatest_factor};
pub use sector::{LipschitzPlant, Sector};
pub use split::Split;

use crate::certificate::certified;
use crate::check;
use crate::error::{DesignError, Pair};
use crate::gain_options::{Checked, GainOptions};

certified!(LipschitzDesign);

/// A gain for a Lipschitz plant, with its evidence.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct LipschitzDesign {
    /// The model of the plant.
    pub plant: LipschitzPlant,
    /// The gain L, n x p, of `xhat' = A xhat + sum G_k phi_k(H_k xhat) + L (y - C xhat)`.
    pub l: DMatrix<f64>,
    /// `P > 0`: `V = e'Pe` falls.
    pub p: DMatrix<f64>,
    /// The multiplier of each sector.
    pub tau: Vec<f64>,
    /// `|e(t)| <= sqrt(cond P) exp(-rate t) |e(0)|`.
    pub rate: f64,
    /// `P > 0` and the block inequality, for A, C, the sectors, L, P and tau as stored; of the plant of an enclosure,
    /// for all A and C in its intervals.
    pub certificate: Certificate,
}

impl LipschitzDesign {
    /// Some L for `plant`, every error decaying at least like `exp(-rate t)`.
    ///
    /// Cost: one SDP of `n(n+1)/2 + np` unknowns and one for each sector, of order n + the sum of the widths of the G.
    ///
    /// ```
    /// use luenberger_design::DesignError;
    /// use luenberger_design::lipschitz::{LipschitzDesign, LipschitzPlant, Sector};
    /// use luenberger_plants::flexible_joint;
    /// use nalgebra::{DMatrix, dmatrix};
    ///
    /// let plant = flexible_joint::classical();
    /// let a = DMatrix::from_column_slice(4, 4, plant.linear_part().as_slice());
    /// let c = DMatrix::identity(2, 4);
    /// // |3.33 sin x3 - 3.33 sin z3| <= 3.33 |x - z| is all that is used: no gain will do.
    /// let crude = LipschitzPlant::unstructured(a.clone(), c.clone(), 3.33)?;
    /// assert!(matches!(LipschitzDesign::new(&crude, 0.0), Err(DesignError::Infeasible { .. })));
    /// // It acts on x4' and depends on x3: a gain is found, and proved.
    /// let sine = Sector::structured(dmatrix![0.0; 0.0; 0.0; 1.0], dmatrix![0.0, 0.0, 1.0, 0.0], 3.33);
    /// let design = LipschitzDesign::new(&LipschitzPlant::new(a, c, vec![sine])?, 1.0)?;
    /// assert!(design.certificate.is_proved());
    /// let observer = design.observer(plant)?;
    /// # Ok::<(), DesignError>(())
    /// ```
    /// # Errors
    /// [`DesignError::OfPair`] where no observer exists for the plant with every phi_k in the middle of its sector;
    /// [`DesignError::Infeasible`] with verified multipliers when the inequality has no solution;
    /// [`DesignError::Undecided`].
    pub fn new(plant: &LipschitzPlant, rate: f64) -> Result<Self, DesignError> {
        Self::new_with(plant, None, rate, &GainOptions::default())
    }

    /// [`new`](Self::new), or [`with_gain`](Self::with_gain) where `l` is given, with a bound of the gain, the least
    /// noise gain, or another solver. Bound and noise do not apply to a given gain.
    ///
    /// # Errors
    /// As these; [`LmiError::NotBuiltIn`](luenberger_lmi::LmiError::NotBuiltIn) in [`DesignError::Lmi`].
    pub fn new_with(
        plant: &LipschitzPlant,
        l: Option<&DMatrix<f64>>,
        rate: f64,
        options: &GainOptions,
    ) -> Result<Self, DesignError> {
        plant.check(rate)?;
        let nearly = if let Some(l) = l {
            check::matrix("L", l, (plant.a().nrows(), plant.c().nrows()))?;
            check::hurwitz("A - L C at the centre of the sectors", (&plant.centre(), l, plant.c()))?;
            None
        } else {
            check::detectable(&plant.centre(), plant.c(), rate).map_err(|error| error.of_pair(Pair::MiddleOfSectors))?
        };
        let proposal = proposed(plant, l, rate, options).map_err(|error| error.with_seen(nearly))?;
        proposal.certified(plant, l, rate, &options.settings)
    }

    /// Verification of a user-supplied gain L, n x p.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`DesignError::NotHurwitz`] when L does not stabilise the plant with every phi_k in the
    /// middle of its sector.
    pub fn with_gain<'a>(
        plant: &LipschitzPlant,
        l: impl Into<RealMatrixView<'a>>,
        rate: f64,
    ) -> Result<Self, DesignError> {
        Self::new_with(plant, Some(&check::owned(l)), rate, &GainOptions::default())
    }

    /// The observer gain L, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        &self.l
    }

    /// The observer of `nonlinear`, the plant itself, with this gain.
    ///
    /// The plant's nonlinearities must lie in the sectors of the design: that is the user's statement, and
    /// [`Split::slope`] can contradict it.
    ///
    /// # Errors
    /// [`DesignError::Matrix`] when the plant has other numbers of states or outputs.
    pub fn observer<S, N: Dim, M: Dim, P: Dim>(
        &self,
        nonlinear: S,
    ) -> Result<NonlinearLuenbergerObserver<S, f64, N, M, P>, DesignError>
    where
        S: Plant<f64, State = OVector<f64, N>, Input = OVector<f64, M>, Output = OVector<f64, P>>,
        DefaultAllocator: Size<N, M, P>,
    {
        let size = nonlinear.dimensions();
        let l = check::sized("L", &self.l, (size.states, size.outputs))?;
        Ok(NonlinearLuenbergerObserver::new(nonlinear, l)?)
    }
}

/// The inequality, with Y free or `Y = P L`.
fn problem(plant: &LipschitzPlant, l: Option<&DMatrix<f64>>, rate: f64, limits: &Checked) -> Problem {
    let (a, c) = (plant.a(), plant.c());
    let (n, outputs) = (a.nrows(), c.nrows());
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", n);
    let free = l.is_none().then(|| lmi.rectangular("Y", n, outputs));
    let injected: Expression = match (l, &free) {
        (Some(l), _) => &p * l * c,
        (None, Some(y)) => y * c,
        (None, None) => zeros(n, n),
    };
    let mut first = he(&p * a - injected);
    let mut corners = vec![];
    let mut last = vec![];
    for (k, sector) in plant.sectors().iter().enumerate() {
        let tau = lmi.scalar(&multiplier(k));
        let (g, h) = (sector.g(), sector.h());
        let (q, r) = (g.ncols(), h.nrows());
        // The ends of the sector stay factors of their own: what is refuted is then refuted for exactly these numbers.
        first = first - sector.low() * (sector.high() * (h.transpose() * tau.identity(r) * h));
        let mut corner = &p * g;
        if !sector.is_symmetric() {
            let weighted = h.transpose() * tau.identity(r);
            corner = corner + 0.5 * (sector.low() * &weighted) + 0.5 * (sector.high() * &weighted);
        }
        corners.push(corner);
        last.push((-1.0 * tau.identity(q), q));
    }
    lmi.constrain("P > 0", &p >> 0.0);
    lmi.constrain("decrease", bordered(first.clone() + (2.0 * rate) * &p, &corners, &last) << 0.0);
    if let Some(y) = &free {
        limits.constrain(&mut lmi, &p, y, n, outputs);
        if let Some(precision) = limits.precision() {
            corners.push(y.into());
            last.push((Expression::constant(-precision), outputs));
            lmi.constrain("covariance", bordered(first, &corners, &last) << 0.0);
        }
    }
    lmi
}

/// `first` with these blocks on its right, their transposes below it, and the blocks of `last` with their widths on the
/// diagonal.
fn bordered(first: Expression, corners: &[Expression], last: &[(Expression, usize)]) -> Expression {
    let mut rows = vec![std::iter::once(first).chain(corners.iter().cloned()).collect::<Vec<_>>()];
    for (k, corner) in corners.iter().enumerate() {
        let mut row = vec![corner.transpose()];
        for (j, (block, width)) in last.iter().enumerate() {
            row.push(if j == k { block.clone() } else { zeros(last[k].1, *width) });
        }
        rows.push(row);
    }
    Expression::blocks(rows)
}

fn multiplier(k: usize) -> String {
    format!("tau {}", k + 1)
}

/// A solution of the solver, verified by `lmi`.
struct Proposal {
    p: DMatrix<f64>,
    /// None when the gain was given.
    y: Option<DMatrix<f64>>,
    tau: Vec<f64>,
}

impl Proposal {
    fn read(plant: &LipschitzPlant, solution: &Solution) -> Option<Self> {
        let tau = (0..plant.sectors().len())
            .map(|k| solution.named(&multiplier(k)).and_then(|tau| tau.get(0).copied()))
            .collect::<Option<Vec<f64>>>()?;
        Some(Self { p: solution.named("P")?.clone(), y: solution.named("Y").cloned(), tau })
    }

    /// The design with its certificate for the stored numbers.
    ///
    /// `L = P^-1 Y` is rounded, which can cost a thin margin: P is then sought again for the L that is stored.
    fn certified(
        self,
        plant: &LipschitzPlant,
        l: Option<&DMatrix<f64>>,
        rate: f64,
        settings: &Settings,
    ) -> Result<LipschitzDesign, DesignError> {
        let l = match (l, &self.y) {
            (Some(l), _) => l.clone(),
            (None, Some(y)) => check::solve_definite("P", &self.p, y)?,
            (None, None) => DMatrix::zeros(plant.a().nrows(), plant.c().nrows()),
        };
        let certificate = self.certificate(plant, &l, rate)?;
        if certificate.is_proved() || self.y.is_none() {
            let plant = plant.clone();
            return Ok(LipschitzDesign { plant, l, p: self.p, tau: self.tau, rate, certificate });
        }
        let again = proposed(plant, Some(&l), rate, &(*settings).into())?;
        let certificate = again.certificate(plant, &l, rate)?;
        Ok(LipschitzDesign { plant: plant.clone(), l, p: again.p, tau: again.tau, rate, certificate })
    }

    fn certificate(&self, plant: &LipschitzPlant, l: &DMatrix<f64>, rate: f64) -> Result<Certificate, ProofError> {
        let terms = plant.sectors().iter().zip(&self.tau).map(|(sector, &tau)| sector.term(tau)).collect();
        let (a, c) = plant.within();
        let Vertex { a, c } = Vertex::within(a, c)?;
        let theorem = SectorConvergence { a, c, terms, l: proof_matrix(l), p: proof_matrix(&self.p), rate };
        match plant.jacobians() {
            Some((a, c)) => Certificate::of_jacobians(theorem, a, c),
            None => Certificate::of([theorem]),
        }
    }
}

fn proposed(
    plant: &LipschitzPlant,
    l: Option<&DMatrix<f64>>,
    rate: f64,
    options: &GainOptions,
) -> Result<Proposal, DesignError> {
    let limits = options.check(plant.c().nrows())?;
    let solution = problem(plant, l, rate, &limits).solve_with(&options.settings)?;
    match Proposal::read(plant, &solution) {
        Some(proposal) if solution.verdict.is_proved() => Ok(proposal),
        _ => Err(DesignError::not_proved(WHAT, Some(solution.verdict))),
    }
}

const WHAT: &str = "the inequality of the Lipschitz observer";
