//! Proportional-integral and extended-state observers: the plant with a disturbance among its states.
//!
//! `x' = A x + B u + E d`, `y = C x`, with a d that is constant, `d' = 0`, or in general a polynomial of t: a chain of
//! k integrators, `d^(k) = 0`. For k = 1 the state `(x, d)` has the matrices `[A E; 0 0]`, `[B; 0]`, `[C 0]`; for
//! larger k the state is `(x, d, d', .., d^(k-1))`. A linear or a cubic observer of this plant estimates all of it. It
//! is detectable iff (A, C) is and
//! ```text
//! rank [A E; C 0] = n + q :
//! ```
//! else `A x + E d = 0`, `C x = 0` has a solution other than 0, a constant disturbance d with a state at rest that no
//! output sees. (Where (A, E, C) has the normal rank n + q this is an invariant zero at 0. The condition is the same
//! for every k: at s = 0 the derivatives of d vanish in the kernel of [A - sI; C].) The rank is decided without
//! rounding. For
//! `|d^(k)| <= R` the error is bounded by [`ErrorBound`](crate::ErrorBound) with it among the disturbances.
//!
//! **In discrete time**, `x+ = A x + B u + E d` with the d of each sample, a constant d has `d+ = d`, and a polynomial
//! of t the chain of integrators at its samples, `(d, h d', h^2/2 d'', ..)` summed up: `d+ = d + h d' + h^2/2 d'' +
//! ..`, `d'+ = d' + h d'' + ..` for the period h. Its states are d and its derivatives in units of time, as in
//! continuous time. The condition is that at z = 1, `rank [A - I, E; C, 0] = n + q`.
//!
//! **Extended-state observer** and **disturbance observer** are names of the same observer: with one input, `E = B` and
//! the plant `1/a(s)`, `a(s)` of degree n, its estimate is `dhat = Q(s)(a(s) y - u)` with the filter
//! `Q = l0/(s^(n+1) + .. + l0)` for k = 1, the denominator that of the poles of the observer: Ohnishi's disturbance
//! observer with a Q-filter of relative degree n + 1 and `Q(0) = 1`. With all poles at `-w` (Gao's bandwidth)
//! `Q = (w/(s + w))^(n+1)`; in discrete time with all at `exp(-w h)` (Miklosovic, Radke, Gao, American Control
//! Conference 2006, which samples the chain with the input held as well).

use luenberger_linalg::RealMatrixView;
use luenberger_lmi::proof_matrix;
use luenberger_observers::{ObserverError, ProportionalIntegralObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::statement::hidden_motion;
use luenberger_proof::{Exact, Matrix, Verdict, positive_definite};
use nalgebra::{DMatrix, Dyn, SymmetricEigen};

use crate::check;
use crate::error::DesignError;
use crate::error_bound::DisturbanceBounds;

/// The plant with the state (x, d) for disturbances `x' = A x + B u + E d`, `d' = 0`; E is n x q.
///
/// ```
/// use luenberger_design::{LinearDesign, with_disturbance};
/// use nalgebra::dmatrix;
/// // A double integrator with a constant force: the position shows the force.
/// let plant = luenberger_plants::double_integrator().to_dynamic();
/// let both = with_disturbance(&plant, &dmatrix![0.0; 1.0])?;
/// let design = LinearDesign::with_poles(&both, &[-1.0, -2.0, -3.0])?;
/// assert!((design.l()[(2, 0)] - 6.0).abs() < 1e-12);
/// // A constant velocity and a drift of the position that cancels it leave no trace.
/// assert!(with_disturbance(&plant, &dmatrix![0.0, 1.0; 1.0, 0.0]).is_err());
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
///
/// # Errors
/// [`DesignError::UnseenDisturbance`] with the direction where the rank condition fails; a matrix E that does not fit.
pub fn with_disturbance<'a>(plant: &StateSpace, e: impl Into<RealMatrixView<'a>>) -> Result<StateSpace, DesignError> {
    with_disturbance_chain(plant, e, 1)
}

/// The plant with the state (x, d, d', .., d^(k-1)), k the `order` from 1, for disturbances `x' = A x + B u + E d`,
/// `d^(k) = 0`; E is n x q, and the order of the result n + k q.
///
/// ```
/// use luenberger_design::{LinearDesign, bandwidth_poles, with_disturbance_chain};
/// use nalgebra::dmatrix;
/// // A double integrator with a force that grows linearly: all four poles at -10.
/// let plant = luenberger_plants::double_integrator().to_dynamic();
/// let extended = with_disturbance_chain(&plant, &dmatrix![0.0; 1.0], 2)?;
/// let design = LinearDesign::with_poles(&extended, &bandwidth_poles(4, 1, 10.0))?;
/// assert!((design.l() - dmatrix![40.0; 600.0; 4000.0; 10000.0]).amax() < 1e-8);
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
///
/// Source: J. Han, IEEE Transactions on Industrial Electronics 56, 2009; Z. Gao, American Control Conference 2003.
///
/// # Errors
/// As [`with_disturbance`]; [`DesignError::Setting`] for an order that is not from 1 to 16.
pub fn with_disturbance_chain<'a>(
    plant: &StateSpace,
    e: impl Into<RealMatrixView<'a>>,
    order: usize,
) -> Result<StateSpace, DesignError> {
    chain(plant, &check::owned(e), order, None)
}

/// The same of a plant in discrete time, `x+ = A x + B u + E d`, sampled every `period`: the state
/// (x, d, d', .., d^(k-1)) at the samples, for a d(t) with `d^(k) = 0`.
///
/// ```
/// use luenberger_design::{DiscreteDesign, with_sampled_disturbance_chain};
/// use luenberger_plants::StateSpace;
/// use nalgebra::dmatrix;
/// // x+ = x/2 + u + d with a constant d; both poles at zero.
/// let plant = StateSpace::new(dmatrix![0.5], dmatrix![1.0], dmatrix![1.0])?;
/// let both = with_sampled_disturbance_chain(&plant, &dmatrix![1.0], 1, 0.1)?;
/// let design = DiscreteDesign::with_poles(&both, 0.1, &[0.0, 0.0])?;
/// assert!((design.l() - dmatrix![1.5; 1.0]).amax() < 1e-12);
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
/// Source: R. Miklosovic, A. Radke, Z. Gao, American Control Conference 2006.
///
/// # Errors
/// As [`with_disturbance_chain`]; [`DesignError::NotPositive`] for the period.
pub fn with_sampled_disturbance_chain<'a>(
    plant: &StateSpace,
    e: impl Into<RealMatrixView<'a>>,
    order: usize,
    period: f64,
) -> Result<StateSpace, DesignError> {
    check::positive("the period", period)?;
    chain(plant, &check::owned(e), order, Some(period))
}

/// `h^k/k!` for k from 0 to the order: the parts of the derivatives of a disturbance in its next sample.
fn parts(order: usize, h: f64) -> Vec<f64> {
    (0..=order).scan(1.0, |part, k| Some(std::mem::replace(part, *part * h / (k + 1) as f64))).collect()
}

fn chain(plant: &StateSpace, e: &DMatrix<f64>, order: usize, period: Option<f64>) -> Result<StateSpace, DesignError> {
    check::plant(plant)?;
    check::within("the order of the chain of integrators", order as f64, 1.0, 16.0)?;
    let (n, p, q) = (plant.a.nrows(), plant.c.nrows(), e.ncols());
    check::matrix("E", e, (n, q))?;
    let system = DMatrix::from_fn(n + p, n + q, |i, j| match (i < n, j < n) {
        (true, true) => plant.a[(i, j)],
        (true, false) => e[(i, j - n)],
        (false, true) => plant.c[(i - n, j)],
        (false, false) => 0.0,
    });
    // At rest A x + E d is 0, in discrete time x.
    let rest = if period.is_some() { 1.0 } else { 0.0 };
    let at_rest = |i: usize, j: usize| if i == j && i < n { rest } else { 0.0 };
    let identity = check::exactly(&DMatrix::from_fn(n + p, n + q, at_rest))?;
    if has_full_column_rank(&check::exactly(&system)?.difference(&identity)?)? == Some(false) {
        let still = DMatrix::from_fn(n + p, n + q, |i, j| system[(i, j)] - at_rest(i, j));
        let (near, sigma_min) = least_seen(&still);
        let direction = kernel_direction(&still)?.unwrap_or(near);
        let (x, d) = direction.split_at(n);
        let (d, x) = (d.to_vec(), x.to_vec());
        return Err(DesignError::UnseenDisturbance { d, x, outputs: p, sigma_min, is_discrete: period.is_some() });
    }
    let of_state = |m: &DMatrix<f64>, rows: usize, columns: usize| {
        DMatrix::from_fn(rows, columns, |i, j| m.get((i, j)).copied().unwrap_or(0.0))
    };
    let all = n + order * q;
    let parts = period.map(|h| parts(order, h));
    let motion = |i: usize, j: usize| match (&parts, j.checked_sub(i)) {
        (None, Some(later)) if later == q => 1.0,
        (Some(parts), Some(later)) if later.is_multiple_of(q) => parts[later / q],
        _ => 0.0,
    };
    let a = DMatrix::from_fn(all, all, |i, j| match (i < n, j < n) {
        (true, true) => plant.a[(i, j)],
        (true, false) if j < n + q => e[(i, j - n)],
        (false, false) => motion(i, j),
        _ => 0.0,
    });
    let both = StateSpace::new(a, of_state(&plant.b, all, plant.b.ncols()), of_state(&plant.c, p, all))?;
    Ok(match &plant.d {
        Some(d) => both.with_feedthrough(d.clone())?,
        None => both,
    })
}

/// `count` poles for the bandwidth `omega`: with one output all of them at `-omega`; with more, from `-0.8 omega` to
/// `-1.25 omega` in geometric progression, since equal ones can make the error system defective.
///
/// ```
/// use luenberger_design::bandwidth_poles;
/// assert_eq!(bandwidth_poles(3, 1, 10.0), [-10.0; 3]);
/// assert_eq!(bandwidth_poles(3, 2, 10.0), [-8.0, -10.0, -12.5]);
/// ```
pub fn bandwidth_poles(count: usize, outputs: usize, omega: f64) -> Vec<f64> {
    let pole = |k: usize| {
        // Between -1 and 1.
        let place = if outputs > 1 && count > 1 { 2.0 * k as f64 / (count - 1) as f64 - 1.0 } else { 0.0 };
        -omega * 1.25f64.powf(place)
    };
    (0..count).map(pole).collect()
}

/// The disturbances of the plant with the state (x, d, .., d^(k-1)), k the `order`: those of the plant, whose D is
/// kept, and `d^(k)` with the bounds `rate`.
pub fn disturbances_with_rate(of_plant: &DisturbanceBounds, rate: &[f64], order: usize) -> DisturbanceBounds {
    let (n, m, q, p) = (of_plant.e.nrows(), of_plant.bounds.len(), rate.len(), of_plant.d.nrows());
    let last = n + (order.max(1) - 1) * q;
    DisturbanceBounds {
        e: DMatrix::from_fn(last + q, m + q, |i, j| match (i < n, j < m) {
            (true, true) => of_plant.e[(i, j)],
            (false, false) if i >= last && i - last == j - m => 1.0,
            _ => 0.0,
        }),
        d: DMatrix::from_fn(p, m + q, |i, j| if j < m { of_plant.d[(i, j)] } else { 0.0 }),
        bounds: of_plant.bounds.iter().chain(rate).copied().collect(),
    }
}

/// The same at samples, with the period h: where `|d^(k)(t)| <= rate`, the derivatives of lower order j miss their
/// values of the chain at the next sample by `rate h^(k-j)/(k-j)!` at most, each for itself.
pub fn disturbances_with_sampled_rate(
    of_plant: &DisturbanceBounds,
    rate: &[f64],
    order: usize,
    period: f64,
) -> DisturbanceBounds {
    let (n, m, p) = (of_plant.e.nrows(), of_plant.bounds.len(), of_plant.d.nrows());
    let parts = parts(order.max(1), period);
    let missed = parts.iter().skip(1).rev().flat_map(|part| rate.iter().map(move |rate| rate * part));
    let bounds: Vec<f64> = of_plant.bounds.iter().copied().chain(missed).collect();
    let added = bounds.len() - m;
    DisturbanceBounds {
        e: DMatrix::from_fn(n + added, m + added, |i, j| match (i < n, j < m) {
            (true, true) => of_plant.e[(i, j)],
            (false, false) if i - n == j - m => 1.0,
            _ => 0.0,
        }),
        d: DMatrix::from_fn(p, m + added, |i, j| if j < m { of_plant.d[(i, j)] } else { 0.0 }),
        bounds,
    }
}

/// The observer whose estimate is the state (the first `states` entries), from an observer of state and disturbance.
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

/// A direction that M maps to 0, found exactly, its largest entry 1, with entries rounded at the end; none where the
/// columns are independent, or too many for exact arithmetic.
fn kernel_direction(m: &DMatrix<f64>) -> Result<Option<Vec<f64>>, DesignError> {
    // What x' = 0, y = M x hides.
    let still = DMatrix::zeros(m.ncols(), m.ncols());
    let Some(hidden) = hidden_motion(&proof_matrix(&still), &proof_matrix(m))? else { return Ok(None) };
    let column: Vec<&Exact> = (0..m.ncols()).map(|i| &hidden.basis[(i, 0)]).collect();
    let Some(exponent) = column.iter().filter_map(|x| x.magnitude_exponent()).max() else { return Ok(None) };
    let rounded: Vec<f64> = column.iter().map(|x| x.shifted(-exponent).round_down()).collect();
    let largest = rounded.iter().fold(0.0, |most: f64, x| if x.abs() > most.abs() { *x } else { most });
    Ok(Some(rounded.iter().map(|x| if *x == 0.0 { 0.0 } else { x / largest }).collect()))
}

/// C E without rounding.
pub(crate) fn exact_product(c: &DMatrix<f64>, e: &DMatrix<f64>) -> Result<Matrix<Exact>, DesignError> {
    let embed = |m: &DMatrix<f64>| Matrix::<Exact>::embed(&proof_matrix(m), "a matrix");
    Ok(embed(c)?.product(&embed(e)?)?)
}
