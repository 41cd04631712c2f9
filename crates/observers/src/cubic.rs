//! The cubic observer: eq. (5) of the cubic-observer paper.
//!
//! `xhat' = A xhat + B u + L y~ - (y~' theta y~) N y~` with the innovation `y~ = y - C xhat - D u`, so that the error
//! obeys `e' = (A - L C) e + (y~' theta y~) N y~` (7). Every admissible gain is `N = -P^-1 C' S` with `S + S' >= 0`;
//! the paper's is `S = gamma theta` (14).
//!
//! The cubic part alone, `e' = (y~' theta y~) N y~`, has a closed form when `C N = -w I`: always for one output (w = -C
//! N), and for any number of outputs with `S = w (C P^-1 C')^-1`. [`flow`] evaluates it.

use luenberger_plants::error::check_matrix;
use luenberger_plants::{LinearPlant, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::dense::{branches, choose, copy, entry, larger, sum, with_column};
use crate::error::ObserverError;
use crate::feedthrough;
use crate::observer::{Observer, ObserverDimensions, state_is_estimate};

/// `xhat' = A xhat + B u + L y~ - (y~' theta y~) N y~`, `y~ = y - C xhat - D u`, with N states, M inputs and P outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct CubicObserver<T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// State matrix, n x n.
    pub a: OMatrix<T, N, N>,
    /// Input matrix, n x m.
    pub b: OMatrix<T, N, M>,
    /// Output matrix, p x n.
    pub c: OMatrix<T, P, N>,
    /// Feedthrough matrix, p x m; `None` where the output does not depend on the input.
    pub d: Option<OMatrix<T, P, M>>,
    /// Gain of the linear part, n x p.
    pub l: OMatrix<T, N, P>,
    /// Gain of the cubic part, n x p.
    pub n: OMatrix<T, N, P>,
    /// Weight of the outputs, p x p.
    pub theta: OMatrix<T, P, P>,
}

/// A cubic observer whose sizes are known at compile time.
pub type StaticCubicObserver<T, const N: usize, const M: usize, const P: usize> =
    CubicObserver<T, Const<N>, Const<M>, Const<P>>;

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> CubicObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The plant that is observed.
    pub fn plant(&self) -> LinearPlant<T, N, M, P> {
        LinearPlant { a: self.a.clone(), b: self.b.clone(), c: self.c.clone(), d: self.d.clone() }
    }

    /// The gain L, n x p.
    pub fn l(&self) -> &OMatrix<T, N, P> {
        &self.l
    }

    /// The observer with gains L and N (n x p) and weight theta (p x p) of the plant (A, B, C).
    ///
    /// Convergence is not checked here: an observer that diverges (a printed gain with the wrong sign, say) must be
    /// possible to simulate. Certificates come from the design crate.
    ///
    /// ```
    /// use luenberger_observers::{CubicObserver, Observer};
    /// use nalgebra::{Matrix1, Vector1, Vector2};
    /// let plant = luenberger_plants::double_integrator();
    /// let (l, n) = (Vector2::new(7.0, 10.0), Vector2::new(-9.5, -11.5));
    /// let observer = CubicObserver::new(plant.a, plant.b, plant.c, l, n, Matrix1::new(10.0))?;
    /// let slope = observer.derivative(0.0, &Vector2::zeros(), &Vector1::new(0.0), &Vector1::new(-2.0));
    /// assert_eq!(slope, Vector2::new(-14.0 - 760.0, -20.0 - 920.0));
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`]: shapes that do not fit, entries that are not finite.
    pub fn new(
        a: OMatrix<T, N, N>,
        b: OMatrix<T, N, M>,
        c: OMatrix<T, P, N>,
        l: OMatrix<T, N, P>,
        n: OMatrix<T, N, P>,
        theta: OMatrix<T, P, P>,
    ) -> Result<Self, ObserverError> {
        Self::of(LinearPlant::new(a, b, c)?, l, n, theta)
    }

    /// The observer with these gains of `plant`, and with its D.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of(
        plant: LinearPlant<T, N, M, P>,
        l: OMatrix<T, N, P>,
        n: OMatrix<T, N, P>,
        theta: OMatrix<T, P, P>,
    ) -> Result<Self, ObserverError> {
        let LinearPlant { a, b, c, d } = plant.checked()?;
        let (states, outputs) = (a.nrows(), c.nrows());
        check_matrix("L", &l, (states, outputs))?;
        check_matrix("N", &n, (states, outputs))?;
        check_matrix("theta", &theta, (outputs, outputs))?;
        Ok(Self { a, b, c, d, l, n, theta })
    }
}

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> Observer<T> for CubicObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    state_is_estimate! { Observer }

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions {
            state: self.a.nrows(),
            inputs: self.b.ncols(),
            outputs: self.c.nrows(),
            estimate: self.a.nrows(),
        }
    }

    fn derivative(&self, t: T, xhat: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        let mut slope = xhat.clone();
        let fits = self.derivative_into(t, xhat.as_slice(), u.as_slice(), y.as_slice(), slope.as_mut_slice());
        debug_assert!(fits, "columns of other lengths than the observer's");
        slope
    }

    fn derivative_into(&self, _t: T, xhat: &[T], u: &[T], y: &[T], slope: &mut [T]) -> bool {
        let (order, outputs) = self.l.shape_generic();
        let fits = (xhat.len(), u.len(), y.len()) == (order.value(), self.b.ncols(), outputs.value());
        let fits = fits && slope.len() == xhat.len();
        if fits {
            with_column(outputs, |innovation| {
                feedthrough::innovation(&self.c, self.d.as_ref(), (xhat, u, y), innovation);
                with_column(outputs, |cubic| {
                    let weight = weight_of(&self.theta, innovation);
                    for (cubic, innovation) in cubic.iter_mut().zip(&*innovation) {
                        *cubic = *innovation * weight;
                    }
                    for (i, slope) in slope.iter_mut().enumerate() {
                        let linear = entry(&self.a, i, xhat) + entry(&self.b, i, u) + entry(&self.l, i, innovation);
                        *slope = linear - entry(&self.n, i, cubic);
                    }
                });
            });
        }
        fits
    }
}

/// `v' theta v`, which stops growing where its product with v would overflow: beyond `|v|_max = MAX^(1/4)` (1e77 in
/// `f64`, 4e9 in `f32`) it is that of the shortened `v`. So finite data give a finite right-hand side and never NaN.
pub fn weight<T: RealField + Copy, P: Dim>(theta: &OMatrix<T, P, P>, v: &OVector<T, P>) -> T
where
    DefaultAllocator: Allocator<P> + Allocator<P, P>,
{
    weight_of(theta, v.as_slice())
}

/// [`weight`] of a slice.
pub(crate) fn weight_of<T: RealField + Copy, P: Dim>(theta: &OMatrix<T, P, P>, v: &[T]) -> T
where
    DefaultAllocator: Allocator<P> + Allocator<P, P>,
{
    let size = largest(v);
    branches(|| {
        // The fourth root is taken only where it can matter; 1/epsilon lies below it for every floating-point format.
        if size * T::default_epsilon() <= T::one() {
            return quadratic(theta, v);
        }
        let bound = T::max_value().map_or(T::one() / T::default_epsilon(), |max| max.sqrt().sqrt());
        if size <= bound {
            return quadratic(theta, v);
        }
        with_column(theta.shape_generic().0, |shortened| {
            for (shortened, v) in shortened.iter_mut().zip(v) {
                *shortened = *v / size;
            }
            quadratic(theta, shortened) * bound * bound
        })
    })
}

/// Where the cubic flow has arrived: see [`flow`].
#[derive(Clone, Debug, PartialEq)]
pub struct Flow<T: RealField, P: Dim>
where
    DefaultAllocator: Allocator<P>,
{
    /// The innovation that is left, `y~(t) = r y~(0)` with `0 < r <= 1`.
    pub innovation: OVector<T, P>,
    /// The integral of `(y~' theta y~) y~` over the time passed: `e(t) = e(0) + N impulse`,
    /// `xhat(t) = xhat(0) - N impulse`.
    pub impulse: OVector<T, P>,
}

/// The flow of the cubic part alone, `e' = (y~' theta y~) N y~` with `C N = -w I`, for the time `t >= 0`, in closed
/// form.
///
/// `y~(t) = r y~(0)`, `r = 1/sqrt(1 + 2 w t y~(0)' theta y~(0))`, `e(t) = e(0) + N y~(0) (1 - r)/w`; theta is p x p
/// with nonnegative symmetric part, `w >= 0` (a negative w counts as 0; the true flow then blows up in finite time).
/// `(1 - r)/w` is evaluated without cancellation and without dividing by w; finite data give finite results up to
/// `|y~|` of 1e150 and beyond.
///
/// With it the observer is stepped by Strang splitting (cubic h/2, linear h, cubic h/2), which decreases V at every
/// step h.
///
/// ```
/// use luenberger_observers::cubic::flow;
/// use nalgebra::{Matrix1, Vector1};
/// // y~' = -w theta y~^3 with w theta = 4 from y~ = 3: y~(t)^2 = 9/(1 + 72 t).
/// let after = flow(&Matrix1::new(2.0), 2.0, &Vector1::new(3.0), 1.0);
/// assert!((after.innovation[0] - 3.0 / 73f64.sqrt()).abs() < 1e-15);
/// assert!((after.impulse[0] - (3.0 - after.innovation[0]) / 2.0).abs() < 1e-15);
/// ```
///
/// Cost: p^2 operations and a square root.
pub fn flow<T: RealField + Copy, P: Dim>(theta: &OMatrix<T, P, P>, w: T, innovation: &OVector<T, P>, t: T) -> Flow<T, P>
where
    DefaultAllocator: Allocator<P> + Allocator<P, P>,
{
    let mut after = Flow { innovation: innovation.clone(), impulse: innovation.clone() };
    advance(theta, w, t, after.innovation.as_mut_slice(), after.impulse.as_mut_slice());
    after
}

/// [`flow`] for the time `t` in place; `impulse` is written.
pub(crate) fn advance<T: RealField + Copy, P: Dim>(
    theta: &OMatrix<T, P, P>,
    w: T,
    t: T,
    innovation: &mut [T],
    impulse: &mut [T],
) where
    DefaultAllocator: Allocator<P, P>,
{
    let (zero, one, two) = (T::zero(), T::one(), T::one() + T::one());
    let most = T::max_value();
    copy(innovation, impulse);
    let size = largest(innovation);
    let direction = impulse;
    // y~' theta y~ = size^2 q; the square is never formed, so that it cannot overflow.
    let q = if P::try_to_usize().unwrap_or(direction.len()) == 1 {
        // One output has a sign for a direction, to the last bit, and its q does not wait for the innovation.
        for entry in direction.iter_mut() {
            let before = *entry;
            let sign = choose(|| before < zero, -one, one);
            *entry = choose(|| most.is_none_or(|most| size <= most), sign, before);
        }
        theta.get((0, 0)).copied().unwrap_or(zero)
    } else {
        // An innovation of zero has no direction, and is not divided by its size.
        let length = choose(|| size > zero, size, one);
        for entry in direction.iter_mut() {
            *entry /= length;
        }
        quadratic(theta, direction)
    };
    let q = larger(q, zero);
    let drive = two * q * t;
    let root = if w > zero { (w * drive).sqrt() } else { zero };
    let reach = root * size;
    // hypot(1, reach), then size/hypot and size/(1 + hypot); far away 1/root for both.
    let large = one / T::default_epsilon();
    let is_near = || reach <= large;
    // Far away its square may overflow, and is not used.
    let near = choose(is_near, reach, one);
    let hypot = (one + near * near).sqrt();
    let top = choose(is_near, size, one);
    let left = top / choose(is_near, hypot, root);
    let right = top / choose(is_near, one + hypot, root);
    let bound = most.map_or(large, nalgebra::ComplexField::sqrt);
    let pull = drive * left * right * size;
    let pull = choose(|| pull < bound, pull, bound);
    for (innovation, direction) in innovation.iter_mut().zip(direction) {
        let (before, along) = (*innovation, *direction);
        *innovation = choose(|| size <= zero, before, along * left);
        *direction = choose(|| size <= zero, before, along * pull);
    }
}

/// The rate `w = -trace(C N)/p` of a radial gain, `C N = -w I`. For one output every gain is radial.
///
/// ```
/// use nalgebra::{RowVector2, Vector2};
/// assert_eq!(luenberger_observers::cubic::rate(&RowVector2::new(1.0, 0.0), &Vector2::new(-9.5, -11.5)), 9.5);
/// ```
pub fn rate<T: RealField + Copy, N: Dim, P: Dim>(c: &OMatrix<T, P, N>, n: &OMatrix<T, N, P>) -> T
where
    DefaultAllocator: Allocator<P, N> + Allocator<N, P>,
{
    let trace = (0..c.nrows()).fold(T::zero(), |sum, i| sum + entry_of_product(c, n, i, i));
    -trace / count(c.nrows())
}

/// `v' theta v`, summed in the order of the entries: the same bits with static and with dynamic sizes. Where the length
/// is out of the compiler's sight, an index would keep a panic on a target.
pub(crate) fn quadratic<T: RealField + Copy, P: Dim>(theta: &OMatrix<T, P, P>, v: &[T]) -> T
where
    DefaultAllocator: Allocator<P, P>,
{
    sum(v.len(), |i| v.get(i).map_or_else(T::zero, |left| *left * entry(theta, i, v)))
}

/// The largest magnitude of an entry.
pub(crate) fn largest<T: RealField + Copy>(v: &[T]) -> T {
    v.iter().fold(T::zero(), |largest, entry| larger(entry.abs(), largest))
}

/// Entry (i, j) of C N.
pub(crate) fn entry_of_product<T: RealField + Copy, N: Dim, P: Dim>(
    c: &OMatrix<T, P, N>,
    n: &OMatrix<T, N, P>,
    i: usize,
    j: usize,
) -> T
where
    DefaultAllocator: Allocator<P, N> + Allocator<N, P>,
{
    (0..c.ncols()).fold(T::zero(), |sum, k| sum + c[(i, k)] * n[(k, j)])
}

/// A count as a scalar; counts here are sizes of matrices, which every scalar holds exactly.
pub(crate) fn count<T: RealField>(number: usize) -> T {
    nalgebra::convert(number as f64)
}
