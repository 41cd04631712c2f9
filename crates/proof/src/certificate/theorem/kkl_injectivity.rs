//! The modulus of injectivity of (phi, h) over the box of a [`KklErrorBound`](super::KklErrorBound): a bound of the
//! distance of x from any point of the box, for observers without a left inverse in closed form.
//!
//! **Hypotheses.** The Jacobian J of Phi = (phi, h) lies between bounds over the box, `M J + J'M' - 2 modulus I > 0`
//! for every matrix between them, and `spread^2 P - M_phi'M_phi >= 0`, M_phi being the columns of M for phi.
//!
//! **Theorem.** For all x and z in the box `|M (Phi(x) - Phi(z))| >= modulus |x - z|`, and along the solutions of the
//! theorem `|x - z| <= (spread V(t) + |M (xi - phi(z), y - h(z))|)/modulus`.
//!
//! **Proof.** The box is convex: `Phi(x) - Phi(z) = J (x - z)` with J, a mean of Jacobians, between the bounds, and
//! `(x - z)'M J (x - z) >= modulus |x - z|^2`. With `Phi(x) = (xi - e, y)` the difference is `(xi - phi(z), y - h(z))`
//! less (e, 0), and `|M_phi e| <= spread V`.

use super::super::members::members;
use super::Fact;
use crate::definite::{positive_definite, positive_semidefinite};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::wording::exact;

/// The data of the modulus of injectivity; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct KklInjectivity {
    /// Bounds of the Jacobian of (phi, h), (q + p) x n.
    pub jacobian: Matrix<Interval>,
    /// M, n x (q + p).
    pub m: Matrix<f64>,
    /// The modulus, positive.
    pub modulus: f64,
    /// The bound of `|M_phi e|/V`.
    pub spread: f64,
}

impl KklInjectivity {
    pub(super) fn check(&self, (states, order, outputs): (usize, usize, usize)) -> Result<(), ProofError> {
        self.jacobian.expect_shape("the bounds of the Jacobian", (order + outputs, states))?;
        self.m.expect_shape("M", (states, order + outputs))?;
        for (value, least) in [(self.modulus, 5e-324), (self.spread, 0.0)] {
            if !(value >= least && value.is_finite()) {
                return Err(ProofError::Sign { what: "a bound, which should be finite and not negative,", value });
            }
        }
        Ok(())
    }

    /// The inequalities of M; that the Jacobian lies between its bounds is decided with the maps.
    pub(super) fn facts(&self, p: &Matrix<f64>) -> Result<[Fact; 2], ProofError> {
        let (n, q) = (self.m.rows(), p.rows());
        let embedded = Matrix::<Interval>::embed(&self.m, "M")?;
        let modulus = Interval::of(-self.modulus).mul(&Interval::of(2.0));
        let decrease = embedded.product(&self.jacobian)?.plus_transpose()?.sum(&Matrix::scalar(n, &modulus))?;
        let number = |x: f64| Exact::from_f64(x).unwrap_or_else(Exact::zero);
        let square = number(self.spread).mul(&number(self.spread));
        let spread = Matrix::from_fn(q, q, |i, j| {
            let gram =
                (0..n).fold(Exact::zero(), |sum, k| sum.add(&number(self.m[(k, i)]).mul(&number(self.m[(k, j)]))));
            square.mul(&number(p[(i, j)])).sub(&gram)
        });
        Ok([
            Fact::new("M J + J'M' - 2 modulus I > 0 for the Jacobian J of (phi, h)", positive_definite(&decrease)?),
            Fact::new("spread^2 P - M_phi'M_phi >= 0", positive_semidefinite(&spread)?),
        ])
    }

    pub(super) fn words(&self) -> String {
        format!(
            " For all x and z in the box, |M ((phi, h)(x) - (phi, h)(z))| >= modulus |x - z| with modulus = {}; hence |x(t) - z| <= (spread V(t) + |M (xi - phi(z), y - h(z))|)/modulus with spread = {}, for every z in the box.",
            exact(self.modulus),
            exact(self.spread),
        )
    }
}

members! { KklInjectivity, (states, order, outputs): (usize, usize, usize) { {
    jacobian = "Jacobian".matrix_of_intervals((order + outputs, states));
    m = "M".matrix((states, order + outputs));
    modulus = "modulus".positive("this number is positive");
    spread = "spread".nonnegative("a bound is 0 or more");
} } }
