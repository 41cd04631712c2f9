//! Observers whose sizes are known at run time, with their sizes in a type where these are small: up to eight states
//! and four outputs, in a module for web pages up to four states and two outputs.
//!
//! Such an observer takes no memory. It is the same body as for any size, and gives the same bits. The plant is at an
//! input that is held, and without its type, and the scalar is binary64: the sizes that an observer is compiled for are
//! many already, and so they are compiled once, with this crate.

use core::any::Any;
use core::marker::PhantomData;

use luenberger_plants::{Column as _, Differentiable, Dimensions, Plant, Shape, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, DimAdd, DimSum, OMatrix, OVector, RealField, U0, U1};

use crate::dense::times;
use crate::gaussian::GaussianEstimate;
use crate::observer::put_slice;

/// Most states.
const STATES: usize = 8;
/// Most outputs.
const OUTPUTS: usize = 4;
/// Entries of estimate and covariance of four states.
const FEW: usize = 20;

/// The same value, if it has that type.
pub(crate) fn same<A: 'static, B: 'static>(a: &A) -> Option<&B> {
    (a as &dyn Any).downcast_ref()
}

/// The same, to be changed.
pub(crate) fn same_mut<A: 'static, B: 'static>(a: &mut A) -> Option<&mut B> {
    (a as &mut dyn Any).downcast_mut()
}

/// Copies entries of the same type, and as many; whether they are.
pub(crate) fn copied<A: Copy + 'static, B: Copy + 'static>(from: &[A], to: &mut [B]) -> bool {
    from.len() == to.len() && from.iter().zip(to).all(|(from, to)| same(from).map(|from| *to = *from).is_some())
}

/// A plant at an input that is held, on slices, matrices by columns; false if a length does not fit.
pub(crate) trait OnSlices {
    fn derivative(&self, t: f64, x: &[f64], f: &mut [f64]) -> bool;
    fn output(&self, t: f64, x: &[f64], h: &mut [f64]) -> bool;
    fn motion(&self, t: f64, x: &[f64], f: &mut [f64], df: &mut [f64]) -> bool;
    fn measurement(&self, t: f64, x: &[f64], h: &mut [f64], dh: &mut [f64]) -> bool;
    fn is_linear_between_samples(&self) -> bool;
}

/// A plant over `T`, which is binary64, with its input; D are the types of its sizes.
pub(crate) struct AtInput<'p, S, T, D> {
    plant: &'p S,
    input: &'p [T],
    sizes: PhantomData<D>,
}

impl<'p, S, T: RealField + Copy, D> AtInput<'p, S, T, D> {
    pub(crate) fn new(plant: &'p S, input: &'p [T]) -> Self {
        Self { plant, input, sizes: PhantomData }
    }

    /// A map of at most `ROWS` states, at most as many values, and a Jacobian of at most `ENTRIES`.
    #[inline]
    fn on<const ROWS: usize, const ENTRIES: usize>(
        (t, x): (f64, &[f64]),
        (values, jacobian): (&mut [f64], &mut [f64]),
        map: impl FnOnce(T, &[T], &mut [T], &mut [T]) -> bool,
    ) -> bool {
        let (mut from, mut to, mut entries) = ([T::zero(); ROWS], [T::zero(); ROWS], [T::zero(); ENTRIES]);
        let lengths = (from.get_mut(..x.len()), to.get_mut(..values.len()), entries.get_mut(..jacobian.len()));
        let (Some(t), (Some(from), Some(to), Some(entries))) = (same(&t), lengths) else { return false };
        copied(x, from) && map(*t, from, to, entries) && copied(to, values) && copied(entries, jacobian)
    }

    /// The same of few states or of more.
    fn jacobian(
        at: (f64, &[f64]),
        to: (&mut [f64], &mut [f64]),
        map: impl FnOnce(T, &[T], &mut [T], &mut [T]) -> bool,
    ) -> bool {
        if at.1.len() <= OUTPUTS {
            Self::on::<OUTPUTS, { OUTPUTS * OUTPUTS }>(at, to, map)
        } else {
            Self::on::<STATES, { STATES * STATES }>(at, to, map)
        }
    }

    /// The same without a Jacobian.
    fn values(at: (f64, &[f64]), to: &mut [f64], map: impl FnOnce(T, &[T], &mut [T]) -> bool) -> bool {
        Self::on::<STATES, 0>(at, (to, &mut []), |t, x, to, _| map(t, x, to))
    }
}

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> OnSlices for AtInput<'_, S, T, (N, M, P)>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P>,
{
    fn derivative(&self, t: f64, x: &[f64], f: &mut [f64]) -> bool {
        Self::values((t, x), f, |t, x, f| self.plant.derivative_into(t, x, self.input, f))
    }

    fn output(&self, t: f64, x: &[f64], h: &mut [f64]) -> bool {
        Self::values((t, x), h, |t, x, h| self.plant.output_into(t, x, self.input, h))
    }

    fn motion(&self, t: f64, x: &[f64], f: &mut [f64], df: &mut [f64]) -> bool {
        Self::jacobian((t, x), (f, df), |t, x, f, df| self.plant.motion_into(t, x, self.input, f, df))
    }

    fn measurement(&self, t: f64, x: &[f64], h: &mut [f64], dh: &mut [f64]) -> bool {
        Self::jacobian((t, x), (h, dh), |t, x, h, dh| self.plant.measurement_into(t, x, self.input, h, dh))
    }

    fn is_linear_between_samples(&self) -> bool {
        self.plant.is_linear_between_samples()
    }
}

/// The plant at an input that is held, with as many states and outputs.
#[derive(Clone, Copy)]
pub(crate) struct Held<'f, N, P> {
    pub(crate) plant: &'f dyn OnSlices,
    pub(crate) size: (N, P),
}

/// What `fill` writes; NaN where there is nothing.
fn column<R: Dim>(rows: R, fill: impl FnOnce(&mut [f64]) -> bool) -> OVector<f64, R>
where
    DefaultAllocator: Allocator<R>,
{
    let mut value = OVector::zeros_generic(rows, U1);
    if !fill(value.as_mut_slice()) {
        value.fill(f64::NAN);
    }
    value
}

/// The same with a Jacobian.
fn with_jacobian<R: Dim, N: Dim>(
    (rows, columns): (R, N),
    fill: impl FnOnce(&mut [f64], &mut [f64]) -> bool,
) -> (OVector<f64, R>, OMatrix<f64, R, N>)
where
    DefaultAllocator: Allocator<R> + Allocator<R, N>,
{
    let mut jacobian = OMatrix::zeros_generic(rows, columns);
    (column(rows, |value| fill(value, jacobian.as_mut_slice())), jacobian)
}

impl<N: Dim, P: Dim> Shape for Held<'_, N, P> {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: self.size.0.value(), inputs: 0, outputs: self.size.1.value() }
    }
}

impl<N: Dim, P: Dim> Plant<f64> for Held<'_, N, P>
where
    DefaultAllocator: Size<N, U0, P>,
{
    type State = OVector<f64, N>;
    type Input = OVector<f64, U0>;
    type Output = OVector<f64, P>;

    fn derivative(&self, t: f64, x: &Self::State, _u: &Self::Input) -> Self::State {
        column(self.size.0, |f| self.plant.derivative(t, x.as_slice(), f))
    }

    fn output(&self, t: f64, x: &Self::State, _u: &Self::Input) -> Self::Output {
        column(self.size.1, |h| self.plant.output(t, x.as_slice(), h))
    }
}

impl<N: Dim, P: Dim> Differentiable<f64, N, U0, P> for Held<'_, N, P>
where
    DefaultAllocator: Size<N, U0, P>,
{
    fn directional(
        &self,
        t: f64,
        x: &OVector<f64, N>,
        u: &OVector<f64, U0>,
        v: &OVector<f64, N>,
    ) -> (OVector<f64, N>, OVector<f64, N>) {
        let (f, jacobian) = self.motion(t, x, u);
        (f, times(&jacobian, v))
    }

    fn output_directional(
        &self,
        t: f64,
        x: &OVector<f64, N>,
        u: &OVector<f64, U0>,
        v: &OVector<f64, N>,
    ) -> (OVector<f64, P>, OVector<f64, P>) {
        let (h, jacobian) = self.measurement(t, x, u);
        (h, times(&jacobian, v))
    }

    fn state_jacobian(&self, t: f64, x: &OVector<f64, N>, u: &OVector<f64, U0>) -> OMatrix<f64, N, N> {
        self.motion(t, x, u).1
    }

    fn output_jacobian(&self, t: f64, x: &OVector<f64, N>, u: &OVector<f64, U0>) -> OMatrix<f64, P, N> {
        self.measurement(t, x, u).1
    }

    fn motion(&self, t: f64, x: &OVector<f64, N>, _u: &OVector<f64, U0>) -> (OVector<f64, N>, OMatrix<f64, N, N>) {
        with_jacobian((self.size.0, self.size.0), |f, df| self.plant.motion(t, x.as_slice(), f, df))
    }

    fn measurement(&self, t: f64, x: &OVector<f64, N>, _u: &OVector<f64, U0>) -> (OVector<f64, P>, OMatrix<f64, P, N>) {
        with_jacobian((self.size.1, self.size.0), |h, dh| self.plant.measurement(t, x.as_slice(), h, dh))
    }

    fn is_linear_between_samples(&self) -> bool {
        self.plant.is_linear_between_samples()
    }
}

/// A call with a size as a type, if it is one of the list, or of the second one outside of web pages; else false.
macro_rules! sized {
    ($size:expr, [$($small:literal)*] [$($large:literal)*], $dim:ident => $call:expr) => {
        match $size {
            $($small => {
                let $dim = nalgebra::Const::<$small>;
                $call
            })*
            $(#[cfg(not(target_arch = "wasm32"))]
            $large => {
                let $dim = nalgebra::Const::<$large>;
                $call
            })*
            _ => false,
        }
    };
}

pub(crate) use sized;

/// What `run` makes of time, state and sample over `T`; false, and the state as it was, for other scalars and lengths.
pub(crate) fn on_numbers<T: RealField + Copy>(
    sample: (T, &[T]),
    state: &mut [T],
    run: impl FnOnce(f64, &mut [f64], &[f64]) -> bool,
) -> bool {
    if state.len() <= STATES {
        on_column::<_, STATES>(sample, state, run)
    } else if state.len() <= FEW {
        on_column::<_, FEW>(sample, state, run)
    } else {
        on_column::<_, { STATES * (STATES + 1) }>(sample, state, run)
    }
}

/// The same of a state of at most `LENGTH` entries.
fn on_column<T: RealField + Copy, const LENGTH: usize>(
    (t, y): (T, &[T]),
    state: &mut [T],
    run: impl FnOnce(f64, &mut [f64], &[f64]) -> bool,
) -> bool {
    let (mut next, mut sample) = ([0.0; LENGTH], [0.0; OUTPUTS]);
    let lengths = (next.get_mut(..state.len()), sample.get_mut(..y.len()));
    let (Some(t), (Some(next), Some(sample))) = (same(&t), lengths) else { return false };
    copied(state, next) && copied(y, sample) && run(*t, next, sample) && copied(next, state)
}

/// A step of a filter, or part of one, with the outputs that are measured; all without any.
#[derive(Clone, Copy)]
pub(crate) enum Part<'m> {
    Step(&'m [bool]),
    Update(&'m [bool]),
    Prediction,
}

/// A filter whose sizes are known at run time, at an input that is held.
pub(crate) trait AtRunTime {
    /// States and outputs.
    fn size(&self) -> (usize, usize);

    /// The update with these sizes, at time t by the outputs of y that are true in `measured`, all without any.
    fn measure<N: DimAdd<U1>, P: Dim>(
        &self,
        size: (N, P),
        t: f64,
        state: &mut GaussianEstimate<f64, N>,
        y: &OVector<f64, P>,
        measured: &[bool],
    ) where
        DefaultAllocator: Size<N, U0, P> + Allocator<N, DimSum<N, U1>>;

    /// The prediction of a step with this number of states.
    fn finish<N: DimAdd<U1>>(&self, n: N, t: f64, state: &mut GaussianEstimate<f64, N>)
    where
        DefaultAllocator: Size<N, U0, U1> + Allocator<N, DimSum<N, U1>>;

    /// False for other sizes.
    fn run(&self, t: f64, state: &mut [f64], y: &[f64], part: Part<'_>) -> bool {
        let (n, p) = self.size();
        let (measured, predicts) = match part {
            Part::Step(measured) => (measured, true),
            Part::Update(measured) => (measured, false),
            Part::Prediction => {
                return sized!(n, [1 2 3 4] [5 6 7 8], n => self.prediction_of_size(n, t, state));
            }
        };
        sized!(n, [1 2 3 4] [5 6 7 8], n => sized!(
            p, [1 2] [3 4], p => self.update_of_size((n, p), t, state, (y, measured))
                && (!predicts || self.prediction_of_size(n, t, state))
        ))
    }

    fn update_of_size<N: DimAdd<U1>, P: Dim>(
        &self,
        (n, p): (N, P),
        t: f64,
        state: &mut [f64],
        (y, measured): (&[f64], &[bool]),
    ) -> bool
    where
        DefaultAllocator: Size<N, U0, P> + Allocator<N, DimSum<N, U1>>,
    {
        let (next, y) = (GaussianEstimate::<f64, N>::try_from_slice(state), OVector::<f64, P>::try_from_slice(y));
        let (Some(mut next), Some(y)) = (next, y) else { return false };
        if measured.is_empty() || measured.contains(&true) {
            self.measure((n, p), t, &mut next, &y, measured);
        }
        put_slice(next.as_slice(), state)
    }

    fn prediction_of_size<N: DimAdd<U1>>(&self, n: N, t: f64, state: &mut [f64]) -> bool
    where
        DefaultAllocator: Size<N, U0, U1> + Allocator<N, DimSum<N, U1>>,
    {
        let Some(mut next) = GaussianEstimate::<f64, N>::try_from_slice(state) else { return false };
        self.finish(n, t, &mut next);
        put_slice(next.as_slice(), state)
    }
}
