//! The conditions (11)-(13) of Theorem 1, as printed and as they work, for gains of any origin.

use luenberger_plants::DynamicPlant;
use luenberger_proof::statement::{cubic_dissipation, lyapunov_decrease, positive};
use luenberger_proof::{Direction, Exact, Matrix, Verdict, negative_definite, positive_semidefinite};
use nalgebra::DMatrix;

use crate::certificate::exact;
use crate::check;
use crate::error::DesignError;

/// What is known of each condition of Theorem 1, for the numbers exactly as given.
///
/// (11), that the origin is the only equilibrium, follows from (12) and (13').
#[derive(Debug, Clone, PartialEq)]
pub struct Theorem1 {
    /// `P > 0`.
    pub positive: Verdict<Direction>,
    /// `theta >= 0`.
    pub weight: Verdict<Direction>,
    /// `(A - LC)'P + P(A - LC) < 0` (12).
    pub decrease: Verdict<Direction>,
    /// `P N C + C'N'P < 0` (13) as printed: refuted whenever rank C < n, by a direction in the kernel of C.
    pub strict: Verdict<Direction>,
    /// `P N C + C'N'P <= 0` (13'), which is what the theorem needs.
    pub dissipation: Verdict<Direction>,
}

impl Theorem1 {
    /// Decides the conditions for the gains L, N (n x p), the weight theta (p x p) and P (n x n, symmetric).
    ///
    /// A gain N that was rounded misses (13') in its last digit, and the verdict says so; a gain defined by `N = -P^-1 C'S` is certified
    /// by [`CubicDesign`](crate::CubicDesign).
    ///
    /// # Errors
    /// Shapes that do not fit the plant, entries that are not finite, a P or theta that is not symmetric.
    pub fn examine(
        plant: &DynamicPlant,
        (l, n, theta): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
        p: &DMatrix<f64>,
    ) -> Result<Self, DesignError> {
        check::plant(plant)?;
        let (order, outputs) = (plant.a.nrows(), plant.c.nrows());
        check::matrix("L", l, (order, outputs))?;
        check::matrix("N", n, (order, outputs))?;
        let (theta, p) = (check::symmetric("theta", theta, outputs)?, check::symmetric("P", p, order)?);
        let (a, c) = (exact(&plant.a)?, exact(&plant.c)?);
        let (l, n, p) = (exact(l)?, exact(n)?, exact(&p)?);
        let product = Matrix::<Exact>::embed(&p, "P")?
            .product(&Matrix::embed(&n, "N")?)?
            .product(&Matrix::embed(&c, "C")?)?
            .plus_transpose()?;
        Ok(Self {
            positive: positive(&p)?,
            weight: positive_semidefinite(&exact(&theta)?)?,
            decrease: lyapunov_decrease(&a, &l, &c, &p)?,
            strict: negative_definite(&product)?,
            dissipation: cubic_dissipation(&p, &n, &c)?,
        })
    }

    /// Whether the conditions that suffice for global exponential stability are proved: all but the strict (13).
    pub fn is_proved(&self) -> bool {
        [&self.positive, &self.weight, &self.decrease, &self.dissipation].into_iter().all(Verdict::is_proved)
    }
}
