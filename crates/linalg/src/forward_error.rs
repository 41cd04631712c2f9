//! Bounds of the error of a solution, relative to it.

/// A bound of the error relative to the solution found, as one relative to the exact solution. From one on, not a digit
/// is known: infinite.
pub fn of_exact(bound: f64) -> f64 {
    if bound < 1.0 { bound / (1.0 - bound) } else { f64::INFINITY }
}

/// `norm / scale`, and zero where both vanish: the residual of an equation whose terms all are zero.
pub(crate) fn relative(norm: f64, scale: f64) -> f64 {
    if norm == 0.0 { 0.0 } else { norm / scale }
}

/// From an error in the norm of the separation to one of the solution in Frobenius' and the user's units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorScale {
    /// sqrt(n) for the spectral norm, n for the sum of the entries, of which the estimate may be three times too large.
    pub norms: f64,
    /// What the units of the state bring, where these were balanced.
    pub units: f64,
    /// The error as refinement measured it, relative to the solution in the units of the computation, where rounding
    /// decides the separation.
    pub refined: Option<f64>,
}

/// `X = P* - P` solves the equation for the defect: `||X|| <= ||defect|| / separation`, where
/// `||defect|| <= residual * 2 weight ||P||`, and where the defect itself is known up to the rounding of n products. A
/// bound beyond one says that rounding decides the separation too: then there is none.
pub fn forward_error(residual: f64, condition: f64, n: usize, spread: ErrorScale) -> f64 {
    if let Some(error) = spread.refined {
        return of_exact(error * spread.units);
    }
    let bound = 2.0 * condition * (residual + n as f64 * f64::EPSILON) * spread.norms;
    if bound < 1.0 { of_exact(bound * spread.units) } else { f64::INFINITY }
}
