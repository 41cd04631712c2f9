//! The mean-value-theorem observer with output injection: L and P for all mean Jacobians, and a bound of its error.
//!
//! `z = xhat + e` obeys `z' = f(z, u) + L (y - C z)`, hence `d = x - z` obeys `d' = (Dbar - L C) d` with the mean
//! Jacobian between z and x. Where every such Jacobian lies in a polytope and one P serves all its vertices,
//! `|d(t)| <= sqrt(cond P) exp(-rate t) |d(0)|` from *any* e(0), and whatever G does.

use luenberger_lmi::{Problem, proof_matrix};
use luenberger_observers::mean_value::{Mean, MeanValueObserver};
use luenberger_plants::{Differentiable, Size, StateSpace};
use luenberger_proof::certificate::{Certificate, JacobianPolytope, Vertex};
use luenberger_proof::statement::overshoot_bound;
use luenberger_proof::{Interval, Matrix, ProofError};
use nalgebra::{DMatrix, DefaultAllocator, Dim, OVector};

use crate::certificate::certified;
use crate::check;
use crate::error::DesignError;
use crate::gain_lmi::{self, Gain};
use crate::gain_options::GainOptions;
use crate::lpv::Polytope;

certified!(MeanValueDesign);

/// The gain of the output injection into a mean-value-theorem observer, with its evidence.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct MeanValueDesign {
    /// The gain L, n x p.
    pub l: DMatrix<f64>,
    /// `P > 0`.
    pub p: DMatrix<f64>,
    /// The rate: `(J - L C)'P + P (J - L C) + 2 rate P < 0` at every vertex J.
    pub rate: f64,
    /// The vertices J; of entries that the theorem has as intervals, the middle.
    pub vertices: Vec<DMatrix<f64>>,
    /// An upper bound of `sqrt(cond P)`; infinite if the certificate is not proved.
    pub overshoot: f64,
    /// `P > 0` and the decrease at every vertex, for L and P as stored.
    pub certificate: Certificate,
}

impl MeanValueDesign {
    /// L and P for a plant with `C = [I 0]` of `outputs` rows, whose mean Jacobians lie in the convex hull of
    /// `vertices` (n x n each).
    ///
    /// Bounds of the entries of Df over a convex region give such vertices: the mean over a segment lies in the hull of
    /// what is averaged.
    ///
    /// ```
    /// use luenberger_design::mean_value::MeanValueDesign;
    /// use luenberger_plants::flexible_joint;
    /// use nalgebra::DMatrix;
    /// let a = flexible_joint::classical().linear_part();
    /// let vertices = [-3.33, 3.33].map(|slope| {
    ///     let mut vertex = DMatrix::from_column_slice(4, 4, a.as_slice());
    ///     vertex[(3, 2)] += slope;
    ///     vertex
    /// });
    /// let design = MeanValueDesign::new(&vertices, 2, 1.0)?;
    /// assert!(design.certificate.is_proved() && design.overshoot < 1e4);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// [`PolytopicDesign::new`](crate::robust::PolytopicDesign::new)'s; [`DesignError::NoVertices`];
    /// [`DesignError::OutputCount`] unless there are 1 to n outputs; [`DesignError::Matrix`] for the shapes of the
    /// vertices.
    pub fn new(vertices: &[DMatrix<f64>], outputs: usize, rate: f64) -> Result<Self, DesignError> {
        Self::new_with(vertices, outputs, rate, &GainOptions::default())
    }

    /// [`new`](Self::new) with a bound of the gain, the least noise gain, or another solver.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`LmiError::NotBuiltIn`](luenberger_lmi::LmiError::NotBuiltIn) in [`DesignError::Lmi`].
    pub fn new_with(
        vertices: &[DMatrix<f64>],
        outputs: usize,
        rate: f64,
        options: &GainOptions,
    ) -> Result<Self, DesignError> {
        let Gain { l, p } = common_gain(vertices, outputs, rate, options)?;
        let c = Matrix::from_fn(outputs, l.nrows(), |i, j| f64::from(i == j));
        let corners = vertices.iter().map(|a| Vertex::exactly(&proof_matrix(a), &c));
        let theorem = JacobianPolytope {
            vertices: corners.collect::<Result<_, ProofError>>()?,
            l: proof_matrix(&l),
            p: proof_matrix(&p),
            rate,
        };
        Self::certified(vertices.to_vec(), Gain { l, p }, rate, Certificate::of([theorem])?)
    }

    /// L and P for all mean Jacobians of an enclosure, with the whole interval of each entry in the theorem. The
    /// outputs have to be the first states: the certificate is not proved if Dh is not [I 0].
    ///
    /// # Errors
    /// As [`new_with`](Self::new_with).
    pub fn over(polytope: &Polytope, rate: f64, options: &GainOptions) -> Result<Self, DesignError> {
        let enclosure = &polytope.enclosure;
        let vertices: Vec<DMatrix<f64>> = polytope.vertices.iter().map(|vertex| vertex.a.clone()).collect();
        let Gain { l, p } = common_gain(&vertices, enclosure.c.rows(), rate, options)?;
        let first_states = Matrix::from_fn(l.ncols(), l.nrows(), |i, j| Interval::of(f64::from(i == j)));
        let corners = (0..vertices.len()).map(|k| Vertex::within(&polytope.around(k).0, &first_states));
        let theorem = JacobianPolytope {
            vertices: corners.collect::<Result<_, ProofError>>()?,
            l: proof_matrix(&l),
            p: proof_matrix(&p),
            rate,
        };
        let certificate = Certificate::of_jacobians(theorem, &enclosure.a, &enclosure.c)?;
        Self::certified(vertices, Gain { l, p }, rate, certificate)
    }

    fn certified(
        vertices: Vec<DMatrix<f64>>,
        Gain { l, p }: Gain,
        rate: f64,
        certificate: Certificate,
    ) -> Result<Self, DesignError> {
        let overshoot = if certificate.is_proved() { overshoot_bound(&proof_matrix(&p))? } else { f64::INFINITY };
        Ok(Self { l, p, rate, vertices, overshoot, certificate })
    }

    /// The observer gain L, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        &self.l
    }

    /// `sqrt(cond P) exp(-rate t) |d(0)|`, which `|x - z|` never exceeds.
    pub fn envelope(&self, initial: f64, t: f64) -> f64 {
        self.overshoot * (-self.rate * t).exp() * initial
    }

    /// The observer of `plant` with this output injection, whose internal error starts at `internal_error`, whatever
    /// that is.
    ///
    /// # Errors
    /// [`MeanValueObserver::with_output_injection`]'s, and [`DesignError::Matrix`] when the plant has other numbers of
    /// states or outputs.
    pub fn observer<S, D, N: Dim, M: Dim, P: Dim>(
        &self,
        plant: S,
        eta: f64,
        mean: D,
        internal_error: OVector<f64, N>,
    ) -> Result<MeanValueObserver<S, D, f64, N, M, P>, DesignError>
    where
        S: Differentiable<f64, N, M, P>,
        D: Mean<S, f64, N, M, P>,
        DefaultAllocator: Size<N, M, P>,
    {
        let size = plant.dimensions();
        let l = check::sized("L", &self.l, (size.states, size.outputs))?;
        Ok(MeanValueObserver::with_output_injection(plant, eta, mean, internal_error, l)?)
    }
}

/// L and P for these vertices and C = [I 0].
fn common_gain(
    vertices: &[DMatrix<f64>],
    outputs: usize,
    rate: f64,
    options: &GainOptions,
) -> Result<Gain, DesignError> {
    let n = vertices.first().ok_or(DesignError::NoVertices)?.nrows();
    for vertex in vertices {
        check::matrix("a vertex of the Jacobians", vertex, (n, n))?;
    }
    if outputs == 0 || outputs > n {
        return Err(DesignError::OutputCount { outputs, states: n });
    }
    let nominal = StateSpace::new(vertices[0].clone(), DMatrix::zeros(n, 0), DMatrix::identity(outputs, n))?;
    Ok(gain_lmi::solve(&nominal, vertices, rate, Problem::new(), options)?.0)
}
