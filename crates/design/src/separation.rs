//! Quantitative injectivity of a map: ratios `|T(x) - T(x')| / |x - x'|` over pairs, and the search for two points with
//! the same image.
//!
//! A small singular value of the Jacobian does not disprove injectivity (x^3 is injective); two points with one image
//! do. The search starts from the worst pairs that are far apart: `T(x'') = T(x)` is solved for x'' by Gauss-Newton
//! steps from x'.

use nalgebra::allocator::Allocator;
use nalgebra::{DMatrix, DefaultAllocator, Dim, OVector};

/// Two points are distant when they are this many half-widths of the box apart.
pub(crate) const DISTANT: f64 = 0.25;
/// Distant pairs from which a second preimage is searched.
pub(crate) const SUSPECTS: usize = 12;
/// Gauss-Newton steps of one search.
const STEPS: usize = 12;

/// The ratios over all pairs of some points.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ratios {
    /// The smallest, and the pair that has it.
    pub(crate) smallest: (f64, usize, usize),
    /// The largest ratio: an estimate of the map's Lipschitz constant from the points.
    pub(crate) largest: f64,
    /// The distant pairs with the smallest ratios, smallest first: at most [`SUSPECTS`].
    pub(crate) suspects: Vec<(f64, usize, usize)>,
}

/// A point with its image.
pub(crate) type Imaged<N, Z> = (OVector<f64, N>, OVector<f64, Z>);

/// The ratios over points `(x, T(x))` of a box with these half-widths.
pub(crate) fn ratios<N: Dim, Z: Dim>(points: &[Imaged<N, Z>], half: &OVector<f64, N>) -> Ratios
where
    DefaultAllocator: Allocator<N> + Allocator<Z>,
{
    let mut found = Ratios { smallest: (f64::INFINITY, 0, 0), largest: 0.0, suspects: Vec::new() };
    for i in 0..points.len() {
        for j in 0..i {
            let apart = &points[i].0 - &points[j].0;
            let ratio = (&points[i].1 - &points[j].1).norm() / apart.norm();
            found.largest = found.largest.max(ratio);
            if ratio < found.smallest.0 {
                found.smallest = (ratio, i, j);
            }
            if apart.component_div(half).norm() >= DISTANT
                && (found.suspects.len() < SUSPECTS || ratio < found.suspects[SUSPECTS - 1].0)
            {
                found.suspects.push((ratio, i, j));
                found.suspects.sort_by(|a, b| a.0.total_cmp(&b.0));
                found.suspects.truncate(SUSPECTS);
            }
        }
    }
    found
}

/// `T(x) = z` by Gauss-Newton steps from x, in the box; the best point, and how far its image is from z. `map` gives T
/// and its Jacobian.
pub(crate) fn second_preimage<N: Dim, Z: Dim, E>(
    mut map: impl FnMut(&OVector<f64, N>) -> Result<(OVector<f64, Z>, DMatrix<f64>), E>,
    z: &OVector<f64, Z>,
    mut x: OVector<f64, N>,
    (lower, upper): (&OVector<f64, N>, &OVector<f64, N>),
) -> Result<(OVector<f64, N>, f64), E>
where
    DefaultAllocator: Allocator<N> + Allocator<Z>,
{
    let mut best = (x.clone(), f64::INFINITY);
    for _ in 0..STEPS {
        let (value, jacobian) = map(&x)?;
        let residual = DMatrix::from_column_slice(z.len(), 1, (z - value).as_slice());
        let missed = residual.norm();
        if missed.is_nan() || missed >= best.1 {
            break;
        }
        best = (x.clone(), missed);
        let svd = jacobian.svd(true, true);
        // Directions that T does not see take no part.
        let Ok(step) = svd.solve(&residual, 1e-8 * svd.singular_values.max()) else { break };
        for (i, entry) in x.iter_mut().enumerate() {
            *entry = (*entry + step[i]).clamp(lower[i], upper[i]);
        }
    }
    Ok(best)
}
