//! The conditions (11)-(13) of Theorem 1, as printed and as corrected, for gains from any source.

use luenberger_linalg::RealMatrixView;
use luenberger_lmi::proof_matrix;
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{Certificate, CubicTheorem1};
use luenberger_proof::{Direction, Exact, Matrix, Verdict, negative_definite};

use crate::certificate::{certified, plant};
use crate::check::{self, owned};
use crate::error::DesignError;

certified!(Theorem1);

/// Verdict on each condition of Theorem 1, exactly for the given numbers.
///
/// (11), that the origin is the only equilibrium, follows from (12) and (13').
#[readonly::make]
#[derive(Debug, Clone, PartialEq)]
pub struct Theorem1 {
    /// The conditions that suffice: `P > 0`, (12), `theta >= 0` and `P N C + C'N'P <= 0` (13').
    pub certificate: Certificate,
    /// `P N C + C'N'P < 0` (13) as printed: refuted whenever rank C < n, by a direction in the kernel of C.
    pub strict: Verdict<Direction>,
}

impl Theorem1 {
    /// Decides the conditions for the gains L, N (n x p), the weight theta (p x p) and P (n x n, symmetric).
    ///
    /// A rounded gain N generally violates (13') in its last digit, and is refuted; a gain defined by `N = -P^-1
    /// C'S` is certified by [`CubicDesign`](crate::CubicDesign).
    ///
    /// # Errors
    /// Shapes that do not fit the plant, entries that are not finite, a P or theta that is not symmetric.
    pub fn examine<'a>(
        linear: &StateSpace,
        l: impl Into<RealMatrixView<'a>>,
        n: impl Into<RealMatrixView<'a>>,
        theta: impl Into<RealMatrixView<'a>>,
        p: impl Into<RealMatrixView<'a>>,
    ) -> Result<Self, DesignError> {
        let (l, n, theta, p) = (&owned(l), &owned(n), &owned(theta), &owned(p));
        check::plant(linear)?;
        let (order, outputs) = (linear.a.nrows(), linear.c.nrows());
        check::matrix("L", l, (order, outputs))?;
        check::matrix("N", n, (order, outputs))?;
        let (theta, p) = (check::symmetric("theta", theta, outputs)?, check::symmetric("P", p, order)?);
        let theorem = CubicTheorem1 {
            plant: plant((&linear.a, &linear.b, &linear.c)),
            l: proof_matrix(l),
            n: proof_matrix(n),
            theta: proof_matrix(&theta),
            p: proof_matrix(&p),
        };
        let product = Matrix::<Exact>::embed(&theorem.p, "P")?
            .product(&Matrix::embed(&theorem.n, "N")?)?
            .product(&Matrix::embed(&theorem.plant.c, "C")?)?
            .plus_transpose()?;
        Ok(Self { strict: negative_definite(&product)?, certificate: Certificate::of([theorem])? })
    }
}
