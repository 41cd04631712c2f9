//! Convergence of the cubic observer with the stored gain `N`, rounded to binary64.
//!
//! `e' = F e + (y'theta y) N y`, `y = Ce`, `F = A - LC` (Share Pasand, eq. 7). The design gives `N0 = -P^-1 C'S`; the
//! stored `N` leaves the residual `R = P N + C'S`, about 1e-16 relative to its terms. With `V = e'Pe` and
//! `F'P + PF <= -q I`,
//! ```text
//! V' <= -q |e|^2 + (y'theta y) (-2 y'Sy + 2 e'R y),                                                     (*)
//! ```
//! and the last term is indefinite for large |e| and small |y|: `V` itself cannot prove global convergence. There are
//! two alternatives.
//!
//! **Another Lyapunov matrix, for which the stored gain is exact.** For symmetric X (p x p) and the orthogonal
//! projector `T = N (N'N)^-1 N'` put
//! ```text
//! P~ = C'XC + (I - T)(P - C'XC)(I - T),    S~ = -X C N.
//! ```
//! Since `(I - T)N = 0`, `P~ N = C'X C N = -C'S~` **exactly**: the structure holds for `N` as stored, and `V~ = e'P~e`
//! proves global exponential convergence if `P~ > 0`, `F'P~ + P~F < 0`, `S~ + S~' >= 0` and `theta >= 0`. With X near
//! `(C P^-1 C')^-1`, `P~` differs from P and `S~` from S by rounding errors only, so that the strict inequalities
//! remain true. `P~` is not a matrix of floats: it is enclosed, T as in `left_inverse.rs`, and the inequalities are
//! proved for all matrices within the enclosure. This needs `N` of full column rank, hence S nonsingular, and
//! `S + S' > 0` with a margin above rounding level.
//!
//! **An ellipsoid.** Let `S + S' >= mu I`, `theta <= t I`, `|R| <= rho`, `|C| <= kappa` (spectral norms). With s = |y|,
//! (*) gives `V' <= -q |e|^2 + t s^2 max(0, 2 rho |e| s - mu s^2)`. Over s >= 0 the last term is at most
//! `27 t rho^4 |e|^4 / (16 mu^3)`, attained at `s = 3 rho |e| / (2 mu)`; and since `s <= kappa |e|` it is at most
//! `2 t rho kappa^3 |e|^4` even for mu = 0. So `V' < 0` for
//! ```text
//! 0 < |e| < r,    r^2 = max(16 q mu^3 / (27 t rho^4), q / (2 t rho kappa^3)),
//! ```
//! and every error with `e'Pe < lambda_min(P) r^2` tends to 0. With rho = 1e-15 and the rest about 1, r is about 1e29
//! by the first term, 1e7 by the second.

use super::left_inverse::times_left_inverse;
use super::lyapunov::{error_matrix, largest_eigenvalue_bound};
use super::{accretive, embed, embed_symmetric, lyapunov_decrease, norm_bound, positive};
use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::label::Names;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

/// Verdicts on the cubic observer with its gains as stored.
#[derive(Debug, Clone, PartialEq)]
pub struct DeployedCubic {
    /// `P > 0`.
    pub positive: Verdict<Direction>,
    /// `F'P + PF < 0`; its margin is q.
    pub decrease: Verdict<Direction>,
    /// `theta >= 0`.
    pub weight: Verdict<Direction>,
    /// `S + S' >= 0`; its margin is mu.
    pub accretive: Verdict<Direction>,
    /// Upper bound of the spectral norm of `R = P N + C'S`, the deviation of the stored gain from the structure.
    pub residual: f64,
    /// The set of initial errors from which convergence is proved. [`Reach::Unproved`] unless the four verdicts above
    /// are `Proved`.
    pub reach: Reach,
}

/// Initial errors for which the estimate is proved to converge.
#[derive(Debug, Clone, PartialEq)]
pub enum Reach {
    /// All, exponentially.
    Everywhere {
        /// Largest difference between an entry of the Lyapunov matrix of the proof and that of P; 0 if the matrix is P.
        moved: f64,
    },
    /// All in an ellipsoid.
    Within(Ellipsoid),
    /// None: nothing is proved.
    Unproved,
}

/// The ellipsoid `e'Pe < level`: V decreases in it, so it is invariant, and the error tends to 0 exponentially.
#[derive(Debug, Clone, PartialEq)]
pub struct Ellipsoid {
    /// r of the head of this module: `V' < 0` for `0 < |e| < radius`.
    pub radius: f64,
    /// `lambda_min(P) radius^2`, rounded down.
    pub level: f64,
    /// Radius of a ball within the ellipsoid.
    pub ball: f64,
}

/// Convergence of `e' = (A - LC)e + (y'theta y) N y`, `y = Ce`, for the numbers exactly as stored.
///
/// `A` n x n, `L` and `N` n x p, `C` p x n, `theta` symmetric p x p. `P` (symmetric n x n) and `S` (p x p) are the
/// design data of `N`, which is a rounding of `-P^-1 C'S`. The head of this module has the theorems and proofs.
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a `P` or `theta` that is not symmetric.
/// ```
/// use luenberger_proof::Matrix;
/// use luenberger_proof::statement::{Reach, cubic_dissipation, deployed_cubic};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // Example 1 of the paper: F'P + PF = -10 I, N = -P^-1 C' = -(42/85, 49/85), up to rounding.
/// let a = Matrix::from_rows([[0.0, 1.0], [0.0, 0.0]]);
/// let (l, c) = (Matrix::from_rows([[7.0], [10.0]]), Matrix::from_rows([[1.0, 0.0]]));
/// let p = Matrix::from_rows([[55.0 / 7.0, -5.0], [-5.0, 30.0 / 7.0]]);
/// let n = Matrix::from_rows([[-42.0 / 85.0], [-49.0 / 85.0]]);
/// let one = Matrix::from_rows([[1.0]]);
/// assert!(cubic_dissipation(&p, &n, &c)?.is_refuted(), "by the rounding of N");
/// let deployed = deployed_cubic(&a, &l, &c, &p, &n, &one, &one)?;
/// assert!(deployed.residual < 1e-14);
/// assert!(matches!(deployed.reach, Reach::Everywhere { moved } if moved < 1e-12));
/// # Ok(())
/// # }
/// ```
pub fn deployed_cubic(
    a: &Matrix<f64>,
    l: &Matrix<f64>,
    c: &Matrix<f64>,
    p: &Matrix<f64>,
    n: &Matrix<f64>,
    s: &Matrix<f64>,
    theta: &Matrix<f64>,
) -> Result<DeployedCubic, ProofError> {
    deployed_cubic_knowing(a, l, c, (p, None), n, s, theta)
}

/// The same, with the margins of `P > 0` and `F'P + PF < 0` where they are proved already.
pub(crate) fn deployed_cubic_knowing(
    a: &Matrix<f64>,
    l: &Matrix<f64>,
    c: &Matrix<f64>,
    (p, known): (&Matrix<f64>, Option<(f64, Option<f64>)>),
    n: &Matrix<f64>,
    s: &Matrix<f64>,
    theta: &Matrix<f64>,
) -> Result<DeployedCubic, ProofError> {
    let (order, outputs) = (a.rows(), c.rows());
    embed::<Interval>(n, "N", (order, outputs))?;
    embed::<Interval>(s, "S", (outputs, outputs))?;
    embed_symmetric::<Interval>(theta, "theta", outputs)?;
    let mut deployed = DeployedCubic {
        positive: match known {
            Some((margin, _)) => Verdict::Proved { margin },
            None => positive(p)?,
        },
        decrease: match known {
            Some((_, Some(margin))) => Verdict::Proved { margin },
            _ => lyapunov_decrease(a, l, c, p)?,
        },
        weight: definite::decide(theta, Sense::PositiveSemidefinite)?,
        accretive: accretive(s)?,
        residual: norm_bound(&residual::<Exact>(p, n, s, c)?.map(Exact::enclosure)),
        reach: Reach::Unproved,
    };
    let verdicts = [&deployed.positive, &deployed.decrease, &deployed.weight, &deployed.accretive];
    if verdicts.into_iter().all(Verdict::is_proved) {
        deployed.reach = if deployed.residual == 0.0 {
            Reach::Everywhere { moved: 0.0 }
        } else if let Some(moved) = repaired(a, l, c, p, n)? {
            Reach::Everywhere { moved }
        } else {
            ellipsoid(c, p, theta, &deployed)
        };
    }
    Ok(deployed)
}

/// `P N + C'S`.
fn residual<R: Ring>(
    p: &Matrix<f64>,
    n: &Matrix<f64>,
    s: &Matrix<f64>,
    c: &Matrix<f64>,
) -> Result<Matrix<R>, ProofError> {
    let image = Matrix::<R>::embed(p, "P")?.product(&Matrix::embed(n, "N")?)?;
    image.sum(&Matrix::<R>::embed(c, "C")?.transpose().product(&Matrix::embed(s, "S")?)?)
}

/// The Lyapunov matrix `P~` of the head of this module, if it proves global convergence; returns its distance from P.
fn repaired(
    a: &Matrix<f64>,
    l: &Matrix<f64>,
    c: &Matrix<f64>,
    p: &Matrix<f64>,
    n: &Matrix<f64>,
) -> Result<Option<f64>, ProofError> {
    let Some(x) = output_metric(p, c) else { return Ok(None) };
    let names = Names::new().matrix("C", c).symmetric("X", &x).matrix("N", n).define("S~", "-XCN")?;
    if !names.decide("S~ + S~' >= 0")?.is_proved() {
        return Ok(None);
    }
    let Some(enclosed) = structured_for(p, c, &x, n)? else { return Ok(None) };
    let flow = error_matrix::<Interval>(a, l, c)?;
    let decrease = enclosed.product(&flow)?.plus_transpose()?;
    let proved = definite::decide(&enclosed, Sense::PositiveDefinite)?.is_proved()
        && definite::decide(&decrease, Sense::NegativeDefinite)?.is_proved();
    let change = enclosed.difference(&Matrix::embed(p, "P")?)?;
    Ok(proved.then(|| change.as_slice().iter().map(Interval::magnitude).fold(0.0, f64::max)))
}

/// An enclosure of the `P~` of the head of this module, for which `P~ N = C'X C N`.
/// # Errors
/// [`ProofError`] for inconsistent shapes or entries that are not finite.
pub fn structured_for(
    p: &Matrix<f64>,
    c: &Matrix<f64>,
    x: &Matrix<f64>,
    n: &Matrix<f64>,
) -> Result<Option<Matrix<Interval>>, ProofError> {
    let order = p.rows();
    let Some(projector) = times_left_inverse(n, n)? else { return Ok(None) };
    let rest = Matrix::scalar(order, &Interval::ONE).difference(&projector)?;
    let output = Matrix::<Interval>::embed(c, "C")?;
    let metric = output.transpose().product(&Matrix::embed(x, "X")?)?.product(&output)?;
    let p_enclosed = Matrix::<Interval>::embed(p, "P")?;
    let lyapunov = metric.sum(&rest.transpose().product(&p_enclosed.difference(&metric)?)?.product(&rest)?)?;
    // P~ is symmetric: each entry lies in both intervals computed for it and its mirror entry.
    let mut enclosed = lyapunov.clone();
    for i in 0..order {
        for j in 0..order {
            let Some(both) = lyapunov[(i, j)].intersection(&lyapunov[(j, i)]) else { return Ok(None) };
            enclosed[(i, j)] = both;
        }
    }
    Ok(Some(enclosed))
}

/// X near `(C P^-1 C')^-1`, symmetric; every symmetric X is valid, the best is near this.
pub(crate) fn output_metric(p: &Matrix<f64>, c: &Matrix<f64>) -> Option<Matrix<f64>> {
    let outputs = c.rows();
    let columns = definite::solve_approximately(p, &c.transpose())?;
    let gram = Matrix::from_fn(outputs, outputs, |i, j| {
        let (i, j) = (i.max(j), i.min(j));
        c.row(i).iter().enumerate().map(|(k, x)| x * columns[(k, j)]).sum()
    });
    let identity = Matrix::from_fn(outputs, outputs, |i, j| if i == j { 1.0 } else { 0.0 });
    let x = definite::solve_approximately(&gram, &identity)?;
    Some(Matrix::from_fn(outputs, outputs, |i, j| f64::midpoint(x[(i, j)], x[(j, i)])))
}

/// The ellipsoid of the head of this module. All operations on these nonnegative numbers are rounded to the safe side.
fn ellipsoid(c: &Matrix<f64>, p: &Matrix<f64>, theta: &Matrix<f64>, proved: &DeployedCubic) -> Reach {
    let below = |x: f64| if x.is_nan() { 0.0 } else { x.next_down().max(0.0) };
    let above = |x: f64| x.next_up();
    let margin = |verdict: &Verdict<Direction>| verdict.margin().unwrap_or(0.0);
    let (q, mu, least) = (margin(&proved.decrease), margin(&proved.accretive), margin(&proved.positive));
    let (rho, t, largest) = (proved.residual, largest_eigenvalue_bound(theta), largest_eigenvalue_bound(p));
    if t == 0.0 {
        return Reach::Everywhere { moved: 0.0 };
    }
    let kappa = c.as_slice().iter().fold(0.0_f64, |sum, x| above(sum + above(x * x)));
    let kappa = above(kappa.sqrt());
    // r = sqrt(16 q mu / (27 t)) mu / rho^2.
    let by_accretion = {
        let factor = below(below(below(below(16.0 * q) * mu) / above(27.0 * t)).sqrt());
        below(below(factor * mu) / above(rho * rho))
    };
    // r = sqrt(q / (2 t rho kappa) ) / kappa.
    let by_output = {
        let bound = above(above(above(2.0 * t) * rho) * kappa);
        below(below(below(q / bound).sqrt()) / kappa)
    };
    let radius = by_accretion.max(by_output);
    let level = below(below(least * radius) * radius);
    let ball = below(below(level / largest).sqrt());
    if level > 0.0 && ball > 0.0 { Reach::Within(Ellipsoid { radius, level, ball }) } else { Reach::Unproved }
}
