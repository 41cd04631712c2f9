//! Distance of a pair `(A, C)` to the nearest unobservable pair.
//!
//! ```text
//! d(A, C) = min { |[E; F]|_2 : (A + E, C + F) is not observable } = min over complex lambda of sigma_min([A - lambda I; C])
//! ```
//! for complex `E, F`, in the 2-norm (and, the minimiser having rank one, in the Frobenius norm too; Eising, Systems
//! and Control Letters 4, 1984). Real perturbations have to be at least as large. A margin per mode looks at the
//! eigenvalues only; for matrices far from normal the minimum lies elsewhere and can be much smaller.
//!
//! `sigma_min` has many local minima over the plane, so that a bound from above costs little and one from below needs
//! the whole plane. With `v` the right singular vector, `f(lambda) = sigma_min`,
//!
//! - *from above*: `f(lambda)` itself, brought down by `lambda <- v*A v` from each eigenvalue: that minimises
//!   `|(A - lambda I) v|` for fixed v, and f never grows; quasi-Newton steps on `f^2` make it fast;
//! - *where*: the minimiser lies within `f` of the field of values of A, thus in a rectangle given by the extreme
//!   eigenvalues of `(A + A')/2` and `(A - A')/2i`; A real halves it;
//! - *from below*: `f(lambda)^2 = lambda_min((A - lambda I)*(A - lambda I) + C'C)`, and without the `|lambda|^2` the
//!   matrix is affine in lambda, so that `f^2 - |lambda - lambda0|^2` is concave. On a rectangle with half diagonal r
//!   it is least at a corner, and `f^2 >= min over the corners f^2 - r^2`. The rectangle with the least bound is halved
//!   until the two bounds are near (the search of Gao and Neumann, Linear Algebra Appl. 188, 1993, with this bound in
//!   place of Lipschitz').

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use faer::Mat;
use nalgebra::{Complex, DMatrix, DVector};

use crate::argument::{RealMatrixView, owned, symmetric_part, unit_scale};
use crate::observability::check;
use crate::spectrum::{eigenvalues, eigenvalues_of_symmetric};
use crate::{LinalgError, Result};

/// Two bounds on the distance of `(A, C)` to unobservability, in the units given.
#[derive(Debug, Clone, PartialEq)]
pub struct UnobservabilityDistance {
    /// No complex perturbation `[E; F]` of a 2-norm below this makes the pair unobservable. It holds in exact
    /// arithmetic on the evaluated singular values, from which their rounding, `10 (n + p) eps |[A; C]|`, is
    /// subtracted. Zero if the search stopped before it was positive.
    pub lower: f64,
    /// [`Self::perturbation`] has this 2-norm and makes the pair unobservable: `sigma_min([A - lambda I; C])` at
    /// [`Self::at`].
    pub upper: f64,
    /// The eigenvalue lambda that is unobservable after the perturbation.
    pub at: Complex<f64>,
    /// The unit vector `v` with `(A + E) v = lambda v`, `(C + F) v = 0`.
    pub direction: DVector<Complex<f64>>,
    /// `[E; F]`, (n + p) x n, of rank one.
    pub perturbation: DMatrix<Complex<f64>>,
    /// Number of singular value decompositions computed.
    pub evaluations: usize,
}

/// The search stops where the lower bound has come to this share of the upper.
const NEAR: f64 = 0.9;
/// Most evaluations from below. Far from normality many rectangles look alike; then the lower bound stays what it is.
const BUDGET: usize = 4000;
/// Most steps of one descent.
const STEPS: usize = 60;

/// Distance of `(A, C)` to the nearest pair that is not observable, from both sides.
///
/// `a` is n x n, `c` p x n; p = 0 gives 0. For the distance of `(A, B)` to uncontrollability pass the transposes.
/// Unlike the verdict of [`crate::observability()`], a distance depends on the units of states and outputs: choose them
/// so that errors of equal size are equally likely.
///
/// # Errors
/// [`LinalgError::NotSquare`], [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], [`LinalgError::Empty`];
/// [`LinalgError::NotConverged`] if a singular value decomposition does not. A wide gap between the bounds is no error.
///
/// # Cost
/// At most 4000 singular value decompositions of (n + p) x n, `O(n^3)` each, and a few dozen for each eigenvalue; often
/// some hundreds.
///
/// # Example
/// ```
/// use luenberger_linalg::distance_to_unobservability;
/// use nalgebra::{Complex, dmatrix};
///
/// // Two modes 0.1 apart and seen alike: a change of about a twentieth makes their difference invisible.
/// let (a, c) = (dmatrix![-1.0, 0.0; 0.0, -1.1], dmatrix![1.0, 1.0]);
/// let d = distance_to_unobservability(&a, &c)?;
/// assert!(d.lower <= d.upper && d.lower >= 0.9 * d.upper && d.upper <= 0.05 + 1e-12);
/// let full = |m: &nalgebra::DMatrix<f64>| m.map(Complex::from);
/// let (e, f) = (d.perturbation.rows(0, 2), d.perturbation.rows(2, 1));
/// let residual = ((full(&a) + e) * &d.direction - &d.direction * d.at).norm() + ((full(&c) + f) * &d.direction).norm();
/// println!("{:e} <= d <= {:e}, residual {residual:e}", d.lower, d.upper);
/// assert!(residual < 1e-15);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Eising, Systems and Control Letters 4, 1984; Gao and Neumann, Linear Algebra Appl. 188, 1993; Burke, Lewis
/// and Overton, SIAM J. Matrix Anal. Appl. 26, 2004, for the local minimisation.
pub fn distance_to_unobservability<'a>(
    a: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
) -> Result<UnobservabilityDistance> {
    distance(&owned(a), &owned(c))
}

fn distance(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<UnobservabilityDistance> {
    check(a, c)?;
    let scale = if a.amax() >= c.amax() { unit_scale(a) } else { unit_scale(c) };
    let mut search = Search { a: a * scale, c: c * scale, evaluations: 0 };
    let (n, p) = (a.nrows(), c.nrows());
    let size = search.a.norm().hypot(search.c.norm());
    let rounding = 10.0 * (n + p) as f64 * f64::EPSILON * size;

    let mut best: Option<Point> = None;
    for lambda in eigenvalues(&search.a)?.into_iter().filter(|lambda| lambda.im >= 0.0) {
        let found = search.descend(lambda)?;
        if best.as_ref().is_none_or(|best| found.sigma < best.sigma) {
            best = Some(found);
        }
    }
    let mut best = best.ok_or(LinalgError::Empty { what: "A" })?;
    let lower = if best.sigma <= rounding { 0.0 } else { search.search_below(&mut best)? };
    let lower = (lower.min(best.sigma) - rounding).max(0.0) / scale;

    let perturbation = DMatrix::from_fn(n + p, n, |i, j| -best.u[i] * best.v[j].conj() * best.sigma / scale);
    Ok(UnobservabilityDistance {
        lower,
        upper: best.sigma / scale,
        at: best.lambda / scale,
        direction: best.v,
        perturbation,
        evaluations: search.evaluations,
    })
}

struct Search {
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    evaluations: usize,
}

/// A point of the plane with the smallest singular triple there.
#[derive(Clone)]
struct Point {
    lambda: Complex<f64>,
    sigma: f64,
    u: DVector<Complex<f64>>,
    v: DVector<Complex<f64>>,
}

impl Point {
    /// `sigma grad sigma`: half the gradient of `sigma^2`. One step of that length back is `v*A v`.
    fn gradient(&self) -> [f64; 2] {
        let w: Complex<f64> = self.u.iter().zip(self.v.iter()).map(|(u, v)| u.conj() * v).sum();
        [-self.sigma * w.re, self.sigma * w.im]
    }
}

impl Search {
    fn pencil(&mut self, lambda: Complex<f64>) -> Mat<Complex<f64>> {
        self.evaluations += 1;
        let n = self.a.nrows();
        Mat::from_fn(n + self.c.nrows(), n, |i, j| {
            if i >= n {
                Complex::from(self.c[(i - n, j)])
            } else if i == j {
                Complex::from(self.a[(i, j)]) - lambda
            } else {
                Complex::from(self.a[(i, j)])
            }
        })
    }

    fn sigma(&mut self, lambda: Complex<f64>) -> Result<f64> {
        let sigma = self.pencil(lambda).singular_values().map_err(|_| not_converged())?;
        sigma.last().copied().ok_or_else(not_converged)
    }

    fn at(&mut self, lambda: Complex<f64>) -> Result<Point> {
        let n = self.a.nrows();
        let svd = self.pencil(lambda).thin_svd().map_err(|_| not_converged())?;
        let (u, v) = (svd.U(), svd.V());
        Ok(Point {
            lambda,
            sigma: svd.S().column_vector()[n - 1].re,
            u: DVector::from_fn(u.nrows(), |i, _| u[(i, n - 1)]),
            v: DVector::from_fn(n, |i, _| v[(i, n - 1)]),
        })
    }

    /// A local minimum by BFGS on `sigma^2 / 2` in two variables, started with the step `v*A v - lambda`, which always
    /// descends.
    fn descend(&mut self, start: Complex<f64>) -> Result<Point> {
        let mut here = self.at(start)?;
        let mut inverse = [[1.0, 0.0], [0.0, 1.0]];
        let mut fresh = true;
        for _ in 0..STEPS {
            let g = here.gradient();
            let step = [-(inverse[0][0] * g[0] + inverse[0][1] * g[1]), -(inverse[1][0] * g[0] + inverse[1][1] * g[1])];
            let length = step[0].hypot(step[1]);
            let resolution = f64::EPSILON * (here.lambda.norm() + here.sigma);
            if length <= resolution {
                break;
            }
            let next = self.at(here.lambda + Complex::new(step[0], step[1]))?;
            if next.sigma >= here.sigma {
                if fresh {
                    break;
                }
                (inverse, fresh) = ([[1.0, 0.0], [0.0, 1.0]], true);
                continue;
            }
            let settled = here.sigma - next.sigma <= 1e-12 * here.sigma;
            let h = next.gradient();
            let y = [h[0] - g[0], h[1] - g[1]];
            let sy = step[0] * y[0] + step[1] * y[1];
            if sy > 1e-12 * length * y[0].hypot(y[1]) {
                // (I - s y'/sy) H (I - y s'/sy) + s s'/sy
                let hy = [inverse[0][0] * y[0] + inverse[0][1] * y[1], inverse[1][0] * y[0] + inverse[1][1] * y[1]];
                let factor = 1.0 + (y[0] * hy[0] + y[1] * hy[1]) / sy;
                for i in 0..2 {
                    for j in 0..2 {
                        inverse[i][j] += (factor * step[i] * step[j] - hy[i] * step[j] - step[i] * hy[j]) / sy;
                    }
                }
                fresh = false;
            }
            here = next;
            if settled {
                break;
            }
        }
        Ok(here)
    }

    /// Halves rectangles until the least bound is near the upper one; betters `best` where it finds less.
    fn search_below(&mut self, best: &mut Point) -> Result<f64> {
        let (re, im) = self.field_of_values(best.sigma)?;
        let budget = self.evaluations + BUDGET;
        let mut known = HashMap::new();
        let mut heap = BinaryHeap::new();
        heap.push(self.rectangle([re.0, re.1, 0.0, im], &mut known)?);
        while let Some(least) = heap.peek() {
            if least.bound >= (NEAR * best.sigma).powi(2) || self.evaluations >= budget {
                break;
            }
            let Some(Rectangle { sides: [x0, x1, y0, y1], .. }) = heap.pop() else { break };
            let halves = if x1 - x0 >= y1 - y0 {
                let x = 0.5 * (x0 + x1);
                [[x0, x, y0, y1], [x, x1, y0, y1]]
            } else {
                let y = 0.5 * (y0 + y1);
                [[x0, x1, y0, y], [x0, x1, y, y1]]
            };
            for sides in halves {
                let half = self.rectangle(sides, &mut known)?;
                if half.least.0 < NEAR * best.sigma {
                    let found = self.descend(half.least.1)?;
                    if found.sigma < best.sigma {
                        *best = found;
                    }
                }
                heap.push(half);
            }
        }
        Ok(heap.peek().map_or(0.0, |least| least.bound.max(0.0).sqrt()))
    }

    /// A rectangle in the upper half plane around the field of values: `Re` between the two, `Im` up to the third;
    /// `slack` on every side.
    fn field_of_values(&self, slack: f64) -> Result<((f64, f64), f64)> {
        let n = self.a.nrows();
        let symmetric = eigenvalues_of_symmetric(&symmetric_part(&self.a))?;
        // The eigenvalues of the skew part come in pairs +-i w: the largest w is its 2-norm.
        let skew = (&self.a - self.a.transpose()) * 0.5;
        let sigma = Mat::from_fn(n, n, |i, j| skew[(i, j)]).singular_values().map_err(|_| not_converged())?;
        let slack = slack * 1.000_001 + n as f64 * 10.0 * f64::EPSILON * self.a.norm();
        let (low, high) = (symmetric.first().copied().unwrap_or(0.0), symmetric.last().copied().unwrap_or(0.0));
        Ok(((low - slack, high + slack), sigma.first().copied().unwrap_or(0.0) + slack))
    }

    fn rectangle(&mut self, sides: [f64; 4], known: &mut HashMap<[u64; 2], f64>) -> Result<Rectangle> {
        let [x0, x1, y0, y1] = sides;
        let mut least = (f64::INFINITY, Complex::new(x0, y0));
        for (x, y) in [(x0, y0), (x1, y0), (x0, y1), (x1, y1)] {
            let key = [x.to_bits(), y.to_bits()];
            let sigma = if let Some(sigma) = known.get(&key) {
                *sigma
            } else {
                let sigma = self.sigma(Complex::new(x, y))?;
                known.insert(key, sigma);
                sigma
            };
            if sigma < least.0 {
                least = (sigma, Complex::new(x, y));
            }
        }
        let bound = least.0.powi(2) - 0.25 * ((x1 - x0).powi(2) + (y1 - y0).powi(2));
        Ok(Rectangle { bound, least, sides })
    }
}

/// Part of the plane, `f^2 >= bound` on it. The one with the least bound is the greatest in the order of the heap.
struct Rectangle {
    bound: f64,
    least: (f64, Complex<f64>),
    sides: [f64; 4],
}

impl PartialEq for Rectangle {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Rectangle {}

impl PartialOrd for Rectangle {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Rectangle {
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound)
    }
}

fn not_converged() -> LinalgError {
    LinalgError::NotConverged {
        method: "singular values of [A - lambda I; C]",
        iterations: 0,
        remaining: f64::NAN,
        allowed: f64::EPSILON,
    }
}
