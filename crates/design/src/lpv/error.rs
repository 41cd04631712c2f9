//! Errors of the LPV design: no common gain, or no polytope.

use core::fmt;

use luenberger_linalg::LinalgError;
use luenberger_lmi::{Infeasibility, LmiError};
use luenberger_observers::ObserverError;
use luenberger_proof::ProofError;
use luenberger_proof::statement::HiddenMotion;
use nalgebra::{Complex, DMatrix, DVector};
use thiserror::Error;

use crate::enclosure::{EnclosureError, Entry};
use crate::error::{DesignError, from_through_design_error};
use crate::number::{complex, short};

/// Why a design over a polytope of Jacobians was not possible.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LpvError {
    /// A matrix or a rate is invalid, or the inequality is undecided.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The Jacobians have no enclosure over the box.
    #[error(transparent)]
    Enclosure(#[from] EnclosureError),
    /// Too many entries of the Jacobians vary over the box.
    #[error("{varying} entries of the Jacobians vary over the box, {allowed} are allowed: {entries}")]
    TooManyVertices {
        /// How many vary.
        varying: usize,
        /// How many may.
        allowed: usize,
        /// Which ones.
        entries: VaryingEntries,
    },
    /// At some point of the polytope a direction is unobservable, and an error along it does not decay at the specified
    /// rate.
    #[error("{0}")]
    HiddenMode(Box<HiddenMode>),
    /// Vertices that are possible alone exclude each other.
    #[error("{0}")]
    Conflict(Box<Conflict>),
    /// A given gain does not stabilise at a vertex.
    #[error(
        "A - L C is not Hurwitz at vertex {} ({place}): its spectral abscissa is {abscissa}",
        vertex + 1,
        abscissa = short(*.abscissa)
    )]
    UnstableVertex {
        /// The vertex, from 0.
        vertex: usize,
        /// The vertex as text.
        place: String,
        /// The largest real part of an eigenvalue there.
        abscissa: f64,
    },
}

from_through_design_error!(LpvError: LmiError, ProofError, ObserverError, LinalgError);

/// The entries of the Jacobians that vary over the box.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VaryingEntries(pub Vec<Entry>);

impl fmt::Display for VaryingEntries {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        f.write_str(&names.join(", "))
    }
}

/// A pair `(A, C)` of the polytope with a mode that no gain can move and that does not decay faster than the rate asked
/// for, in exact arithmetic.
#[derive(Debug, Clone, PartialEq)]
pub struct HiddenMode {
    /// The specified rate.
    pub rate: f64,
    /// The pair: a vertex, or a point inside the polytope, as text.
    pub place: String,
    /// A.
    pub a: DMatrix<f64>,
    /// C.
    pub c: DMatrix<f64>,
    /// The eigenvalue of A: the rate cannot exceed minus its real part.
    pub eigenvalue: Complex<f64>,
    /// The direction v, `A v = lambda v`, `C v = 0`, of length 1. Both to rounding.
    pub direction: DVector<Complex<f64>>,
    /// The unobservable subspace of (A, C) in exact arithmetic, in which not every motion decays faster than
    /// `exp(-rate t)`: `witness.is_of` and `witness.decays_at` check it.
    pub witness: HiddenMotion,
}

impl fmt::Display for HiddenMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let direction: Vec<String> = self.direction.iter().map(|z| complex(*z)).collect();
        write!(
            f,
            "LMI infeasible at decay rate {}: at {} the mode {} along ({}) is unobservable",
            short(self.rate),
            self.place,
            complex(self.eigenvalue),
            direction.join(", ")
        )
    }
}

/// Vertices that together exclude a common P, each of them being possible alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Conflict {
    /// The specified rate.
    pub rate: f64,
    /// The vertices (from 0): two that exclude each other if such a pair was found, else all that take part in the
    /// contradiction.
    pub vertices: Vec<usize>,
    /// Each vertex as text.
    pub places: Vec<String>,
    /// Whether it is a pair. If not, no two of them were found to exclude each other alone.
    pub is_pair: bool,
    /// The multipliers of the contradiction, verified exactly.
    pub witness: Infeasibility,
}

impl fmt::Display for Conflict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 5;
        let what = if self.vertices.len() == 1 { "infeasible vertex" } else { "conflicting vertices" };
        let named = self.vertices.iter().zip(&self.places).take(SHOWN);
        let mut names: Vec<String> = named.map(|(k, place)| format!("{} ({place})", k + 1)).collect();
        if self.vertices.len() > SHOWN {
            names.push(format!("and {} more", self.vertices.len() - SHOWN));
        }
        write!(f, "LMI infeasible at decay rate {}; {what}: {}", short(self.rate), names.join("; "))
    }
}
