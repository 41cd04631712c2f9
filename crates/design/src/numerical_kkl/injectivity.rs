//! Quantitative injectivity of T on the domain: whether y distinguishes the states.
//!
//! `|T(x) - T(x')| / |x - x'|` over all pairs of a grid, and the smallest singular value of DT on it: noise in z is
//! amplified in x by at most the reciprocal of the former, and locally of the latter. A singular value of zero does not
//! disprove injectivity (x^3 is injective); two states with one image do, and they are searched: from the worst distant
//! pairs, `T(x'') = T(x)` is solved for x'' beginning at x', first on the spline, then by Gauss-Newton steps on T
//! itself.

use luenberger_observers::numerical_kkl::BoxMap;
use luenberger_observers::numerical_kkl::least_squares::nearest;
use luenberger_plants::Differentiable;
use nalgebra::{Const, DMatrix, SVector};

use crate::numerical_kkl::error::NumericalKklError;
use crate::numerical_kkl::progress::Listener;
use crate::numerical_kkl::progress::Progress;
use crate::numerical_kkl::transform::Transform;
use crate::separation::{DISTANT, Ratios, ratios, second_preimage};
use luenberger_observers::numerical_kkl::Coordinates;

/// How well T separates the states of the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Injectivity<const N: usize> {
    /// The smallest `|T(x) - T(x')| / |x - x'|` over the pairs of the grid.
    pub smallest_ratio: f64,
    /// The pair that has it.
    pub pair: (SVector<f64, N>, SVector<f64, N>),
    /// The largest such ratio: an estimate of T's Lipschitz constant from the grid.
    pub largest_ratio: f64,
    /// The smallest singular value of DT on the grid.
    pub smallest_singular_value: f64,
    /// Where it is attained.
    pub flattest: SVector<f64, N>,
    /// Points of the grid.
    pub points: usize,
}

/// The numbers over a grid of `per_axis` points per axis; `spline` is T in `coordinates`.
pub(crate) fn injectivity<S, const N: usize, const M: usize, const P: usize, const Z: usize>(
    transform: &Transform<'_, S, N, M, P, Z>,
    (spline, coordinates): (&impl BoxMap<f64, N, Z>, &Coordinates<f64, Z>),
    per_axis: usize,
    progress: &mut Listener<'_>,
) -> Result<Injectivity<N>, NumericalKklError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
{
    let domain = transform.domain();
    let points = domain.grid(per_axis);
    let count = points.len();
    let mut grid = Vec::with_capacity(count);
    let (mut smallest_singular_value, mut flattest) = (f64::INFINITY, domain.centre());
    for (index, x) in points.into_iter().enumerate() {
        let (z, jacobian) = transform.with_jacobian(&x)?;
        let dynamic = DMatrix::from_column_slice(Z, N, jacobian.as_slice());
        // Fewer target states than states: some direction is lost everywhere.
        let sigma = if Z < N { 0.0 } else { dynamic.singular_values().min() };
        if sigma < smallest_singular_value {
            (smallest_singular_value, flattest) = (sigma, x);
        }
        grid.push((x, z));
        Progress { stage: "injectivity", done: index + 1, total: count }.tell(progress)?;
    }
    let half = domain.half_width();
    let Ratios { smallest: (smallest, i, j), largest, suspects } = ratios(&grid, &half);
    let pair = (grid[i].0, grid[j].0);
    // An integration of some hundred steps, each within the tolerance.
    let accuracy = 1e3 * transform.tolerance() * transform.output_scale();
    let pairs = suspects.len();
    for (done, (_, i, j)) in suspects.into_iter().enumerate() {
        Progress { stage: "suspect pairs", done, total: pairs }.tell(progress)?;
        let (x, z) = grid[i];
        let near = nearest(spline, &coordinates.white(&z), &grid[j].0, 60).x;
        let map = |x: &SVector<f64, N>| {
            let (value, jacobian) = transform.with_jacobian(x)?;
            Ok::<_, NumericalKklError>((value, DMatrix::from_column_slice(Z, N, jacobian.as_slice())))
        };
        let (second, gap) = second_preimage(map, &z, near, (domain.lower(), domain.upper()))?;
        let apart = second - x;
        // A state outside of the domain's inequalities is none that has to be told apart.
        if gap <= accuracy && apart.component_div(&half).norm() >= 0.5 * DISTANT && domain.satisfies(&second) {
            return Err(NumericalKklError::NotInjective {
                first: x.iter().copied().collect(),
                second: second.iter().copied().collect(),
                distance: apart.norm(),
                gap,
                accuracy,
            });
        }
    }
    Ok(Injectivity {
        smallest_ratio: smallest,
        pair,
        largest_ratio: largest,
        smallest_singular_value,
        flattest,
        points: count,
    })
}
