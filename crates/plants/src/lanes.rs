//! Plants over several lanes at once: one evaluation for as many states as there are lanes.
//!
//! Many trajectories of one plant are integrated together, each in its own lane. A value is an array with an entry for
//! each lane, and the operations of a lane are those of a single evaluation in the same order, so that its bits do not
//! depend on the other lanes. A compiler turns them into vector instructions.

#![allow(clippy::inline_always, reason = "vector instructions are used where the function is inlined only")]

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix};

use crate::linear::LinearPlant;
use crate::plant::Shape;
use crate::size::Size;

/// A plant whose right-hand side and output are evaluated over `L` lanes, with the results of
/// [`Plant`](crate::Plant) to the last bit.
///
/// Columns have one array per entry, `x[i][lane]`, and the lengths of [`dimensions`](Shape::dimensions).
///
/// ```
/// use luenberger_plants::LanePlant;
/// let plant = luenberger_plants::double_integrator();
/// let mut slope = [[0.0; 2]; 2];
/// plant.derivative_lanes(&[0.0; 2], &[[1.0, 2.0], [3.0, 4.0]], &[[5.0, 6.0]], &mut slope);
/// assert_eq!(slope, [[3.0, 4.0], [5.0, 6.0]]);
/// ```
pub trait LanePlant: Shape {
    /// `f(t, x, u)` of each lane into `slope`.
    fn derivative_lanes<const L: usize>(&self, t: &[f64; L], x: &[[f64; L]], u: &[[f64; L]], slope: &mut [[f64; L]]);

    /// `h(t, x, u)` of each lane into `y`.
    fn output_lanes<const L: usize>(&self, t: &[f64; L], x: &[[f64; L]], u: &[[f64; L]], y: &mut [[f64; L]]);
}

impl<S: LanePlant + ?Sized> LanePlant for &S {
    #[inline(always)]
    fn derivative_lanes<const L: usize>(&self, t: &[f64; L], x: &[[f64; L]], u: &[[f64; L]], slope: &mut [[f64; L]]) {
        (**self).derivative_lanes(t, x, u, slope);
    }

    #[inline(always)]
    fn output_lanes<const L: usize>(&self, t: &[f64; L], x: &[[f64; L]], u: &[[f64; L]], y: &mut [[f64; L]]) {
        (**self).output_lanes(t, x, u, y);
    }
}

impl<N: Dim, M: Dim, P: Dim> LanePlant for LinearPlant<f64, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    #[inline(always)]
    fn derivative_lanes<const L: usize>(&self, _t: &[f64; L], x: &[[f64; L]], u: &[[f64; L]], slope: &mut [[f64; L]]) {
        for (i, slope) in slope.iter_mut().enumerate() {
            let (state, input) = (entry_lanes(&self.a, i, x), entry_lanes(&self.b, i, u));
            *slope = core::array::from_fn(|lane| state[lane] + input[lane]);
        }
    }

    #[inline(always)]
    fn output_lanes<const L: usize>(&self, _t: &[f64; L], x: &[[f64; L]], u: &[[f64; L]], y: &mut [[f64; L]]) {
        for (i, y) in y.iter_mut().enumerate() {
            *y = entry_lanes(&self.c, i, x);
            if let Some(d) = &self.d {
                let input = entry_lanes(d, i, u);
                *y = core::array::from_fn(|lane| y[lane] + input[lane]);
            }
        }
    }
}

/// Entry `i` of `M v` of each lane, its terms added from left to right; 0 without terms.
#[inline(always)]
pub fn entry_lanes<const L: usize, R: Dim, C: Dim>(m: &OMatrix<f64, R, C>, i: usize, v: &[[f64; L]]) -> [f64; L]
where
    DefaultAllocator: Allocator<R, C>,
{
    let mut sum = [0.0; L];
    for (j, v) in v.iter().enumerate() {
        let entry = m.get((i, j)).copied().unwrap_or(0.0);
        if j == 0 {
            sum = v.map(|v| entry * v);
        } else {
            for lane in 0..L {
                sum[lane] += entry * v[lane];
            }
        }
    }
    sum
}
