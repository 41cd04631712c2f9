//! Observers over several lanes at once, as [`LanePlant`] has plants: for ensembles of runs.

#![allow(clippy::inline_always, reason = "vector instructions are used where the function is inlined only")]

use luenberger_plants::lanes::entry_lanes;
use luenberger_plants::{LanePlant, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector};

use crate::cubic::{CubicObserver, weight_of};
use crate::linear::LinearObserver;
use crate::nonlinear_luenberger::NonlinearLuenbergerObserver;

/// An observer in continuous time whose estimate is its state, evaluated over `L` lanes with the results of
/// [`Observer`](crate::Observer) to the last bit.
///
/// Columns have one array per entry, `state[i][lane]`.
pub trait LaneObserver {
    /// `g(t, xhat, u, y)` of each lane into `slope`.
    fn derivative_lanes<const L: usize>(
        &self,
        t: &[f64; L],
        xhat: &[[f64; L]],
        u: &[[f64; L]],
        y: &[[f64; L]],
        slope: &mut [[f64; L]],
    );
}

impl<O: LaneObserver + ?Sized> LaneObserver for &O {
    #[inline(always)]
    fn derivative_lanes<const L: usize>(
        &self,
        t: &[f64; L],
        xhat: &[[f64; L]],
        u: &[[f64; L]],
        y: &[[f64; L]],
        slope: &mut [[f64; L]],
    ) {
        (**self).derivative_lanes(t, xhat, u, y, slope);
    }
}

/// A column with an entry for each lane.
type Lanes<const L: usize> = [[f64; L]];

/// Outputs up to this number live on the stack where their number is not known at compile time.
const SMALL: usize = 8;

/// Runs with a column of lanes for the outputs.
#[inline(always)]
fn with_outputs<const L: usize, P: Dim>(outputs: P, run: impl FnOnce(&mut [[f64; L]]))
where
    DefaultAllocator: Allocator<P>,
{
    if outputs.value() <= SMALL {
        run(&mut [[0.0; L]; SMALL][..outputs.value()]);
    } else {
        run(OVector::<[f64; L], P>::from_element_generic(outputs, Const, [0.0; L]).as_mut_slice());
    }
}

/// `y - C xhat - D u`.
#[inline(always)]
fn innovation<const L: usize, N: Dim, M: Dim, P: Dim>(
    c: &OMatrix<f64, P, N>,
    d: Option<&OMatrix<f64, P, M>>,
    (xhat, u, y): (&Lanes<L>, &Lanes<L>, &Lanes<L>),
    innovation: &mut Lanes<L>,
) where
    DefaultAllocator: Allocator<P, N> + Allocator<P, M>,
{
    for (i, (value, y)) in innovation.iter_mut().zip(y).enumerate() {
        let expected = entry_lanes(c, i, xhat);
        *value = core::array::from_fn(|lane| y[lane] - expected[lane]);
        if let Some(d) = d {
            let input = entry_lanes(d, i, u);
            *value = core::array::from_fn(|lane| value[lane] - input[lane]);
        }
    }
}

impl<N: Dim, M: Dim, P: Dim> LaneObserver for LinearObserver<f64, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    #[inline(always)]
    fn derivative_lanes<const L: usize>(
        &self,
        _t: &[f64; L],
        xhat: &[[f64; L]],
        u: &[[f64; L]],
        y: &[[f64; L]],
        slope: &mut [[f64; L]],
    ) {
        with_outputs(self.l.shape_generic().1, |surprise| {
            innovation(&self.c, self.d.as_ref(), (xhat, u, y), surprise);
            for (i, slope) in slope.iter_mut().enumerate() {
                let (state, input) = (entry_lanes(&self.a, i, xhat), entry_lanes(&self.b, i, u));
                let injected = entry_lanes(&self.l, i, surprise);
                *slope = core::array::from_fn(|lane| state[lane] + input[lane] + injected[lane]);
            }
        });
    }
}

impl<N: Dim, M: Dim, P: Dim> LaneObserver for CubicObserver<f64, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    #[inline(always)]
    fn derivative_lanes<const L: usize>(
        &self,
        _t: &[f64; L],
        xhat: &[[f64; L]],
        u: &[[f64; L]],
        y: &[[f64; L]],
        slope: &mut [[f64; L]],
    ) {
        let outputs = self.l.shape_generic().1;
        with_outputs(outputs, |surprise| {
            innovation(&self.c, self.d.as_ref(), (xhat, u, y), surprise);
            with_outputs(outputs, |cubic: &mut [[f64; L]]| {
                let weight = weights(&self.theta, surprise);
                for (cubic, surprise) in cubic.iter_mut().zip(&*surprise) {
                    *cubic = core::array::from_fn(|lane| surprise[lane] * weight[lane]);
                }
                for (i, slope) in slope.iter_mut().enumerate() {
                    let (state, input) = (entry_lanes(&self.a, i, xhat), entry_lanes(&self.b, i, u));
                    let (injected, cubic) = (entry_lanes(&self.l, i, surprise), entry_lanes(&self.n, i, cubic));
                    *slope = core::array::from_fn(|lane| state[lane] + input[lane] + injected[lane] - cubic[lane]);
                }
            });
        });
    }
}

/// `v' theta v` of each lane, as [`weight`](crate::cubic::weight) has it.
#[inline(always)]
fn weights<const L: usize, P: Dim>(theta: &OMatrix<f64, P, P>, v: &[[f64; L]]) -> [f64; L]
where
    DefaultAllocator: Allocator<P> + Allocator<P, P>,
{
    let mut largest = 0.0;
    let mut weights = [0.0; L];
    for (i, entry) in v.iter().enumerate() {
        let row = entry_lanes(theta, i, v);
        for lane in 0..L {
            let term = entry[lane] * row[lane];
            weights[lane] = if i == 0 { term } else { weights[lane] + term };
            largest = f64::max(largest, entry[lane].abs());
        }
    }
    if largest * f64::EPSILON > 1.0 {
        // Where the weight may be that of a shortened innovation.
        for (lane, weight) in weights.iter_mut().enumerate() {
            let mut one = OVector::<f64, P>::zeros_generic(theta.shape_generic().0, Const);
            for (one, v) in one.iter_mut().zip(v) {
                *one = v[lane];
            }
            *weight = weight_of(theta, one.as_slice());
        }
    }
    weights
}

impl<S: LanePlant, N: Dim, M: Dim, P: Dim> LaneObserver for NonlinearLuenbergerObserver<S, f64, N, M, P>
where
    S: luenberger_plants::Plant<f64, State = OVector<f64, N>, Input = OVector<f64, M>, Output = OVector<f64, P>>,
    DefaultAllocator: Size<N, M, P>,
{
    #[inline(always)]
    fn derivative_lanes<const L: usize>(
        &self,
        t: &[f64; L],
        xhat: &[[f64; L]],
        u: &[[f64; L]],
        y: &[[f64; L]],
        slope: &mut [[f64; L]],
    ) {
        with_outputs(self.l().shape_generic().1, |surprise| {
            self.plant().output_lanes(t, xhat, u, surprise);
            self.plant().derivative_lanes(t, xhat, u, slope);
            for (surprise, y) in surprise.iter_mut().zip(y) {
                *surprise = core::array::from_fn(|lane| y[lane] - surprise[lane]);
            }
            for (i, slope) in slope.iter_mut().enumerate() {
                let injected = entry_lanes(self.l(), i, surprise);
                *slope = core::array::from_fn(|lane| slope[lane] + injected[lane]);
            }
        });
    }
}
