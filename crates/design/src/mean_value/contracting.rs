//! Coordinates in which the unmeasured states contract without injection, so that the observer converges as printed.
//!
//! With C = [I 0] and `d = x - z`, `z = xhat + e`, the printed observer has `d' = (D - [G_m 0; 0 0]) d`, D the mean
//! Jacobian between z and x: injection in the measured rows and nothing in the others, where
//! `d_u' = D_uu d_u + D_um d_m`. As G_m grows, d_m is held at zero and D_uu decides. In the coordinates
//! `w = x_u - K x_m` the unmeasured block is `D_uu - K D_mu`, and K makes it contract wherever (D, C) is detectable:
//! ```text
//! Q > 0,   He(Q D_uu - Y D_mu) + 2 rate Q < 0 at every vertex,   K = Q^-1 Y
//! ```
//! Then `V = |d_m|^2 + d_w'Q d_w` falls faster than `exp(-2 rate t)` once the injection exceeds some g, by the Schur
//! complement, and for every larger one, because its term is `-2 d_m'G_m d_m`. The observer's
//! `G_m = eta diag(alpha_1, .., alpha_p)` exceeds g where `eta >= g / alpha`, alpha a lower bound of the alpha_k; one
//! is read off the vertices, entry by entry, since both means have each entry between the least and the largest of the
//! vertices.
//!
//! This recovers Luenberger's reduced-order observer: z_w is one, driven by the measured states.

use luenberger_lmi::{Problem, he, proof_matrix};
use luenberger_observers::mean_value::{MappedObserver, Mean, MeanValueObserver};
use luenberger_plants::{Differentiable, InCoordinates, Plant, Size};
use luenberger_proof::certificate::{Certificate, ContractionInCoordinates};
use nalgebra::allocator::Allocator;
use nalgebra::{DMatrix, DefaultAllocator, Dim, OVector, U2};

use crate::certificate::certified;
use crate::check;
use crate::error::DesignError;

/// The printed observer in other coordinates, its estimate in the plant's own.
pub type PrintedInCoordinates<S, D, N, M, P> =
    MappedObserver<MeanValueObserver<InCoordinates<S, f64, N>, D, f64, N, M, P>, f64, N>;

certified!(ContractingCoordinates);

/// Coordinates `(x_m, x_u - K x_m)` in which the printed observer converges, with their evidence.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct ContractingCoordinates {
    /// K, (n - p) x p.
    pub k: DMatrix<f64>,
    /// `Q > 0`, of order n - p.
    pub q: DMatrix<f64>,
    /// The rate of `sqrt V`.
    pub rate: f64,
    /// The vertices J.
    pub vertices: Vec<DMatrix<f64>>,
    /// The injection g from which on the decrease is proved.
    pub injection: f64,
    /// The least eta for which `eta alpha_k >= g` in all measured rows, and above 1/2; infinite where the vertices
    /// leave room for `alpha_k = 0`. The internal error falls like `exp(-(eta - 1/2) alpha t)`: 1 and more is better.
    pub eta: f64,
    /// `Q > 0`, and at every vertex the contraction of the unmeasured block and the decrease with the injection g, for
    /// K and Q as stored.
    pub certificate: Certificate,
}

impl ContractingCoordinates {
    /// K, Q and g for a plant with `C = [I 0]` of `outputs` rows, whose Jacobians lie in the convex hull of `vertices`
    /// (n x n each).
    ///
    /// ```
    /// use luenberger_design::mean_value::ContractingCoordinates;
    /// use nalgebra::dmatrix;
    /// // Stable, but not in its unmeasured block: the printed observer diverges for every eta > 1/10, in other
    /// // coordinates it converges.
    /// let design = ContractingCoordinates::new(&[dmatrix![-3.0, 2.0; -2.0, 1.0]], 1, 0.5)?;
    /// assert!(design.certificate.is_proved() && 1.0 - design.k[(0, 0)] * 2.0 < -0.5);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// [`DesignError::NoVertices`]; [`DesignError::NothingUnmeasured`]; [`DesignError::Infeasible`] with verified
    /// multipliers when no K and Q serve all vertices; [`DesignError::Undecided`], also when no injection up to 2^60
    /// times the size of the vertices is proved.
    pub fn new(vertices: &[DMatrix<f64>], outputs: usize, rate: f64) -> Result<Self, DesignError> {
        let first = vertices.first().ok_or(DesignError::NoVertices)?;
        let n = first.nrows();
        check::rate(rate)?;
        if outputs == 0 || outputs >= n {
            return Err(DesignError::NothingUnmeasured { states: n, outputs });
        }
        for vertex in vertices {
            check::matrix("vertex", vertex, (n, n))?;
        }
        let (p, m) = (outputs, n - outputs);
        let mut lmi = Problem::new();
        let (q, y) = (lmi.symmetric("Q", m), lmi.rectangular("Y", m, p));
        lmi.constrain("Q > 0", &q >> 0.0);
        for (k, vertex) in vertices.iter().enumerate() {
            let (uu, mu) = (vertex.view((p, p), (m, m)).into_owned(), vertex.view((0, p), (p, m)).into_owned());
            let block = he(&q * &uu - &y * &mu) + (2.0 * rate) * &q;
            lmi.constrain(&format!("contraction at vertex {}", k + 1), block << 0.0);
        }
        let solution = lmi.solve()?;
        if !solution.verdict.is_proved() {
            return Err(DesignError::not_proved(WHAT, Some(solution.verdict)));
        }
        let q = solution.value(&q);
        let k = check::solve_definite("Q", &q, &solution.value(&y))?;
        Self::certified(vertices, k, &q, rate)
    }

    /// The best multiple of Q and the least injection that is proved with it.
    fn certified(vertices: &[DMatrix<f64>], k: DMatrix<f64>, q: &DMatrix<f64>, rate: f64) -> Result<Self, DesignError> {
        let size = vertices.iter().fold(1.0f64, |size, vertex| size.max(vertex.norm())) * (1.0 + k.norm());
        let examined = |q: &DMatrix<f64>, injection: f64| {
            Certificate::of([ContractionInCoordinates {
                vertices: vertices.iter().map(proof_matrix).collect(),
                k: proof_matrix(&k),
                q: proof_matrix(q),
                injection,
                rate,
            }])
        };
        let mut best: Option<(f64, DMatrix<f64>)> = None;
        // |d_m|^2 and d_w'Q d_w may be weighed against each other; powers of two keep Q as it is.
        for exponent in -12..=12 {
            let q = q * f64::powi(2.0, exponent);
            let enough = |g: f64| examined(&q, g).map(|certificate| certificate.is_proved());
            // No more than the best so far, if there is one; else whatever it takes.
            let mut high = best.as_ref().map_or(size, |(g, _)| *g);
            let mut found = enough(high)?;
            for _ in 0..60 {
                if found || best.is_some() {
                    break;
                }
                high *= 2.0;
                found = enough(high)?;
            }
            if !found {
                continue;
            }
            // To within a hundredth.
            let mut low = 0.0;
            for _ in 0..60 {
                if high - low <= 0.01 * high {
                    break;
                }
                let middle = f64::midpoint(low, high);
                if enough(middle)? { high = middle } else { low = middle }
            }
            best = Some((high, q));
        }
        let Some((injection, q)) = best else {
            let why = luenberger_proof::UndecidedReason::NotByThisMatrix { name: "Q" };
            return Err(DesignError::Undecided { what: WHAT, why, best: f64::NAN, seen: None });
        };
        let alpha = least_alpha(vertices, &k);
        // alpha is a sum of a few rounded products.
        let eta = (injection / alpha * (1.0 + 1e-9)).max(0.5f64.next_up());
        let certificate = examined(&q, injection)?;
        Ok(Self { k, q, rate, vertices: vertices.to_vec(), injection, eta, certificate })
    }

    /// `T = [I 0; K I]`, `x = T (x_m, w)`.
    pub fn matrix(&self) -> DMatrix<f64> {
        triangular(&self.k, 1.0)
    }

    /// `plant` in these coordinates.
    ///
    /// # Errors
    /// [`DesignError::Matrix`] when the plant has other numbers of states, or its outputs are not its first states.
    pub fn plant<S, N: Dim, M: Dim>(&self, plant: S) -> Result<InCoordinates<S, f64, N>, DesignError>
    where
        S: Plant<f64, State = OVector<f64, N>, Input = OVector<f64, M>>,
        DefaultAllocator: Allocator<N, N> + Allocator<N> + Allocator<M>,
    {
        let n = plant.dimensions().states;
        Ok(InCoordinates::measured_first(plant, check::sized("T", &self.matrix(), (n, n))?)?)
    }

    /// The printed observer in these coordinates, with its estimate in those of the plant; `internal_error` is its
    /// e(0), in the coordinates z.
    ///
    /// Converges from every e(0) where `eta` is at least [`eta`](Self::eta), as far as the vertices hold all mean
    /// Jacobians.
    ///
    /// # Errors
    /// As [`plant`](Self::plant), and [`MeanValueObserver::new`]'s.
    pub fn observer<S, D, N: Dim, M: Dim, P: Dim>(
        &self,
        plant: S,
        eta: f64,
        mean: D,
        internal_error: OVector<f64, N>,
    ) -> Result<PrintedInCoordinates<S, D, N, M, P>, DesignError>
    where
        S: Differentiable<f64, N, M, P> + Clone,
        D: Mean<InCoordinates<S, f64, N>, f64, N, M, P>,
        DefaultAllocator: Size<N, M, P> + Allocator<N, U2>,
    {
        let plant = self.plant(plant)?;
        let observer = MeanValueObserver::new(plant.clone(), eta, mean, internal_error)?;
        Ok(MappedObserver::new(&plant, observer))
    }
}

fn triangular(k: &DMatrix<f64>, sign: f64) -> DMatrix<f64> {
    let (m, p) = k.shape();
    DMatrix::from_fn(m + p, m + p, |i, j| if i >= p && j < p { sign * k[(i - p, j)] } else { f64::from(i == j) })
}

/// A lower bound of `alpha_k` over the measured rows k: of each entry of the Jacobian in the new coordinates the least
/// absolute value between the least and the largest of the vertices.
fn least_alpha(vertices: &[DMatrix<f64>], k: &DMatrix<f64>) -> f64 {
    let (m, p) = k.shape();
    let n = m + p;
    let moved: Vec<DMatrix<f64>> =
        vertices.iter().map(|vertex| triangular(k, -1.0) * vertex * triangular(k, 1.0)).collect();
    let least = |i: usize, j: usize| {
        let (low, high) = moved
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v[(i, j)]), high.max(v[(i, j)])));
        if low > 0.0 { low } else { (-high).max(0.0) }
    };
    (0..p).map(|k| (0..n).map(|j| least(k, j) + least(j, k)).sum::<f64>()).fold(f64::INFINITY, f64::min)
}

const WHAT: &str = "contraction of the unmeasured block, Q > 0, He(Q J_uu - Y J_mu) + 2 rate Q < 0";
