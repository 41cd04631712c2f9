//! Proportional-integral observers: the plant with a constant disturbance among its states.
//!
//! `x' = A x + B u + E d`, `y = C x`, `d' = 0`. The state `(x, d)` has the matrices `[A E; 0 0]`, `[B; 0]`, `[C 0]`; a
//! linear or a cubic observer of this plant estimates both. It is detectable iff (A, C) is and
//! ```text
//! rank [A E; C 0] = n + q :
//! ```
//! else `A x + E d = 0`, `C x = 0` has a solution other than 0, a constant disturbance d with a state at rest that no
//! output sees. The rank is decided without rounding. For `|d'| <= R` the error is bounded by
//! [`ErrorBound`](crate::ErrorBound) with d' among the disturbances.

use luenberger_lmi::proof_matrix;
use luenberger_observers::{ObserverError, ProportionalIntegralObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::{Exact, Matrix, Verdict, positive_definite};
use nalgebra::{DMatrix, Dyn, SymmetricEigen};

use crate::check;
use crate::error::DesignError;
use crate::error_bound::Disturbances;

/// The plant with the state (x, d) for disturbances `x' = A x + B u + E d`, `d' = 0`; E is n x q.
///
/// ```
/// use luenberger_design::{LinearDesign, with_disturbance};
/// use nalgebra::dmatrix;
/// // A double integrator with a constant force: the position shows the force.
/// let plant = luenberger_plants::double_integrator().to_dynamic();
/// let both = with_disturbance(&plant, &dmatrix![0.0; 1.0])?;
/// let design = LinearDesign::with_poles(&both, &[-1.0, -2.0, -3.0])?;
/// assert!((design.observer.l[(2, 0)] - 6.0).abs() < 1e-12);
/// // A constant velocity and a drift of the position that cancels it leave no trace.
/// assert!(with_disturbance(&plant, &dmatrix![0.0, 1.0; 1.0, 0.0]).is_err());
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
///
/// # Errors
/// [`DesignError::UnseenDisturbance`] with the direction where the rank condition fails; a matrix E that does not fit.
pub fn with_disturbance(plant: &StateSpace, e: &DMatrix<f64>) -> Result<StateSpace, DesignError> {
    check::plant(plant)?;
    let (n, p, q) = (plant.a.nrows(), plant.c.nrows(), e.ncols());
    check::matrix("E", e, (n, q))?;
    let system = DMatrix::from_fn(n + p, n + q, |i, j| match (i < n, j < n) {
        (true, true) => plant.a[(i, j)],
        (true, false) => e[(i, j - n)],
        (false, true) => plant.c[(i - n, j)],
        (false, false) => 0.0,
    });
    if has_full_column_rank(&check::exactly(&system)?)? == Some(false) {
        let (direction, sigma_min) = least_seen(&system);
        let (x, d) = direction.split_at(n);
        return Err(DesignError::UnseenDisturbance { d: d.to_vec(), x: x.to_vec(), outputs: p, sigma_min });
    }
    let of_state = |m: &DMatrix<f64>, rows: usize, columns: usize| {
        DMatrix::from_fn(rows, columns, |i, j| m.get((i, j)).copied().unwrap_or(0.0))
    };
    let a = DMatrix::from_fn(n + q, n + q, |i, j| match (i < n, j < n) {
        (true, true) => plant.a[(i, j)],
        (true, false) => e[(i, j - n)],
        (false, _) => 0.0,
    });
    let both = StateSpace::new(a, of_state(&plant.b, n + q, plant.b.ncols()), of_state(&plant.c, p, n + q))?;
    Ok(match &plant.d {
        Some(d) => both.with_feedthrough(d.clone())?,
        None => both,
    })
}

/// The disturbances of the plant with the state (x, d): those of the plant, whose D is kept, and d' with the bounds
/// `rate`.
pub fn disturbances_with_rate(of_plant: &Disturbances, rate: &[f64]) -> Disturbances {
    let (n, m, q, p) = (of_plant.e.nrows(), of_plant.bounds.len(), rate.len(), of_plant.d.nrows());
    Disturbances {
        e: DMatrix::from_fn(n + q, m + q, |i, j| match (i < n, j < m) {
            (true, true) => of_plant.e[(i, j)],
            (false, false) if i - n == j - m => 1.0,
            _ => 0.0,
        }),
        d: DMatrix::from_fn(p, m + q, |i, j| if j < m { of_plant.d[(i, j)] } else { 0.0 }),
        bounds: of_plant.bounds.iter().chain(rate).copied().collect(),
    }
}

/// The observer that hands out the state of a plant of `states` states, from one of the state and the disturbance.
///
/// # Errors
/// [`DesignError::Observer`] if `inner` has fewer states.
pub fn proportional_integral<O>(inner: O, states: usize) -> Result<ProportionalIntegralObserver<O, Dyn>, DesignError>
where
    O: luenberger_observers::Observer<f64>,
{
    let made: Result<_, ObserverError> = ProportionalIntegralObserver::new(inner, Dyn(states));
    Ok(made?)
}

/// Whether `M'M > 0`, decided exactly; `None` beyond the limits of exact arithmetic.
pub(crate) fn has_full_column_rank(m: &Matrix<Exact>) -> Result<Option<bool>, DesignError> {
    let gram = m.transpose().product(m)?;
    // Exact arithmetic has no rounding by which the two triangles could differ.
    Ok(match positive_definite(&gram)? {
        Verdict::Proved { .. } => Some(true),
        Verdict::Refuted { .. } => Some(false),
        Verdict::Undecided { .. } => None,
    })
}

/// The direction that M maps to the shortest column, its largest entry 1, and the smallest singular value.
pub(crate) fn least_seen(m: &DMatrix<f64>) -> (Vec<f64>, f64) {
    let eigen = SymmetricEigen::new(m.transpose() * m);
    let k = eigen.eigenvalues.imin();
    let column = eigen.eigenvectors.column(k);
    let largest = column[column.icamax()];
    let tidy = |x: &f64| {
        let x = x / largest;
        if x.abs() < 1e-12 { 0.0 } else { x }
    };
    (column.iter().map(tidy).collect(), eigen.eigenvalues[k].max(0.0).sqrt())
}

/// C E without rounding.
pub(crate) fn exact_product(c: &DMatrix<f64>, e: &DMatrix<f64>) -> Result<Matrix<Exact>, DesignError> {
    let embed = |m: &DMatrix<f64>| Matrix::<Exact>::embed(&proof_matrix(m), "a matrix");
    Ok(embed(c)?.product(&embed(e)?)?)
}
