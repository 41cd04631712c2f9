//! Theorem 4: one gain and one P for every plant of a polytope.
//!
//! If `A_k'P + P A_k - YC - C'Y' < 0` at every vertex, it holds on their convex hull, and the observer with
//! `L = P^-1 Y` and any `N = -P^-1 C'S` decreases `V = e'Pe` for every `A(eps)` of the hull, for the error dynamics
//! `e' = (A(eps) - LC) e + ..`. The forcing `(A(eps) - A) x` of an observer with the nominal A is not covered by the
//! theorem: see [`super`].

use luenberger_lmi::{Problem, proof_matrix};
use luenberger_plants::StateSpace;
use luenberger_proof::ProofError;
use luenberger_proof::certificate::{Certificate, PlantPolytope, Vertex};
use nalgebra::DMatrix;

use crate::certificate::certified;
use crate::error::DesignError;
use crate::gain_options::GainOptions;
use crate::linear::LinearDesign;
use crate::{check, gain_lmi};

certified!(PolytopicDesign);

/// A gain for every plant of a polytope, with its evidence.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct PolytopicDesign {
    /// The observer of the nominal plant, with the common gain and P: build the cubic observer on it with
    /// [`CubicDesign::new`](crate::CubicDesign::new).
    pub nominal: LinearDesign,
    /// The other state matrices that the gain serves.
    pub vertices: Vec<DMatrix<f64>>,
    /// `P > 0` and the decrease at every vertex, of which the nominal plant is the first.
    pub certificate: Certificate,
}

impl PolytopicDesign {
    /// One L and P for `nominal` and for all of `vertices` (n x n each), every error decaying at least like
    /// `exp(-rate t)`.
    ///
    /// Exists only if every vertex is detectable, and not always then. Cost: one SDP of `n(n+1)/2 + np` unknowns with
    /// one inequality for each vertex.
    ///
    /// # Errors
    /// [`DesignError::OfPair`] for a vertex with a mode that no gain can move;
    /// [`DesignError::Infeasible`] names the vertices that together exclude a common P.
    pub fn new(nominal: &StateSpace, vertices: &[DMatrix<f64>], rate: f64) -> Result<Self, DesignError> {
        let n = nominal.a.nrows();
        for a in vertices {
            check::matrix("vertex A", a, (n, n))?;
        }
        let all: Vec<_> = std::iter::once(nominal.a.clone()).chain(vertices.iter().cloned()).collect();
        let (gain, _) = gain_lmi::solve(nominal, &all, rate, Problem::new(), &GainOptions::default())?;
        let nominal = LinearDesign::with_lyapunov_matrix(nominal, gain, rate)?;
        let c = proof_matrix(&nominal.observer.c);
        let theorem = PlantPolytope {
            vertices: all.iter().map(|a| Vertex::exactly(&proof_matrix(a), &c)).collect::<Result<_, ProofError>>()?,
            l: proof_matrix(nominal.l()),
            p: proof_matrix(&nominal.p),
            rate,
        };
        Ok(Self { certificate: Certificate::of([theorem])?, nominal, vertices: vertices.to_vec() })
    }

    /// The observer gain L, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        self.nominal.l()
    }
}
