//! The linear observer in discrete time in fixed point: integers, as a target without floating point computes.
//!
//! A number x of the format Qm.n is stored as the integer `x 2^n` of m + n bits, the sign among the m. The step is that
//! of [`DiscreteLinearObserver`], `z = y - C xhat - D u`, `xhat+ = A xhat + B u + L z`, in integers:
//!
//! - Each of the two sums is accumulated in 64 bits without rounding, and cannot overflow: [`FixedPointObserver::new`]
//!   checks that for all integers of 32 bits.
//! - The sum is then rounded once, to the nearest number of the format, ties upwards: an error of at most `2^-(n+1)`.
//! - Results beyond the range saturate, and are counted in [`FixedPointState::saturations`].
//!
//! `luenberger_proof::statement::deployed_linear` with `Step::Accumulated` bounds the estimation error of this step,
//! and proves for given bounds of operation that nothing saturates.
//!
//! The matrices have a separate format, which may have more fraction bits than that of the signals.

use luenberger_plants::{LinearPlant, Size};
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector};

use crate::discrete_linear::DiscreteLinearObserver;
use crate::error::ObserverError;
use crate::observer::ObserverDimensions;

/// Qm.n: two's complement of 2 to 32 bits, the sign among the bits before the point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FixedPointFormat {
    integer_bits: u32,
    fraction_bits: u32,
}

impl FixedPointFormat {
    /// The format with this many bits before the point, the sign among them, and after it.
    ///
    /// # Errors
    /// [`ObserverError::FixedPointFormat`] for no bit before the point, and for fewer than 2 or more than 32 in all.
    pub fn new(integer_bits: u32, fraction_bits: u32) -> Result<Self, ObserverError> {
        let bits = integer_bits.saturating_add(fraction_bits);
        if integer_bits == 0 || !(2..=32).contains(&bits) {
            return Err(ObserverError::FixedPointFormat { integer_bits, fraction_bits });
        }
        Ok(Self { integer_bits, fraction_bits })
    }

    /// Bits before the point, the sign among them.
    pub fn integer_bits(self) -> u32 {
        self.integer_bits
    }

    /// Bits after the point.
    pub fn fraction_bits(self) -> u32 {
        self.fraction_bits
    }

    /// The largest integer of the format.
    pub fn largest(self) -> i32 {
        i32::MAX >> (32 - self.integer_bits - self.fraction_bits)
    }

    /// The smallest integer of the format.
    pub fn smallest(self) -> i32 {
        -self.largest() - 1
    }

    /// `2^n`, by which a number is multiplied to give its integer.
    fn scale(self) -> f64 {
        (1_u64 << self.fraction_bits) as f64
    }

    /// The integer of the number nearest to x, ties to even; `None` beyond the range and for NaN.
    ///
    /// ```
    /// use luenberger_observers::FixedPointFormat;
    /// let q4_4 = FixedPointFormat::new(4, 4)?;
    /// assert_eq!(q4_4.nearest(0.1), Some(2));
    /// assert_eq!((q4_4.nearest(7.9375), q4_4.nearest(8.0), q4_4.nearest(-8.0)), (Some(127), None, Some(-128)));
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    pub fn nearest(self, x: f64) -> Option<i32> {
        let scaled = x * self.scale();
        if !(-4_294_967_296.0..=4_294_967_296.0).contains(&scaled) {
            return None;
        }
        let rounded = (scaled + INTEGERS) - INTEGERS;
        let fits = f64::from(self.smallest()) <= rounded && rounded <= f64::from(self.largest());
        fits.then_some(rounded as i32)
    }

    /// The real number `integer 2^-n` that an integer of the format represents.
    pub fn value(self, integer: i32) -> f64 {
        f64::from(integer) / self.scale()
    }
}

/// `1.5 2^52`: the spacing of the numbers around it is 1, so that adding it rounds to an integer, ties to even.
const INTEGERS: f64 = 6_755_399_441_055_744.0;

/// The formats of an observer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FixedPointFormats {
    /// Format of A, B, C, D and L.
    pub gains: FixedPointFormat,
    /// Format of inputs, outputs and estimates.
    pub signals: FixedPointFormat,
}

impl From<FixedPointFormat> for FixedPointFormats {
    fn from(format: FixedPointFormat) -> Self {
        Self { gains: format, signals: format }
    }
}

/// The matrices as integers of their format.
#[derive(Clone, Debug, PartialEq)]
pub struct FixedPointGains<N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// A, n x n.
    pub a: OMatrix<i32, N, N>,
    /// B, n x m.
    pub b: OMatrix<i32, N, M>,
    /// C, p x n.
    pub c: OMatrix<i32, P, N>,
    /// D, p x m.
    pub d: Option<OMatrix<i32, P, M>>,
    /// L, n x p.
    pub l: OMatrix<i32, N, P>,
}

/// The state of the observer.
#[derive(Clone, Debug, PartialEq)]
pub struct FixedPointState<N: Dim>
where
    DefaultAllocator: nalgebra::allocator::Allocator<N>,
{
    /// The estimate, as integers of the signals' format.
    pub xhat: OVector<i32, N>,
    /// Number of results that saturated; the counter itself saturates at its largest value.
    pub saturations: u32,
}

/// The linear observer in fixed point, with N states, M inputs and P outputs.
///
/// ```
/// use luenberger_observers::{DiscreteLinearObserver, FixedPointFormat, FixedPointObserver};
/// use luenberger_plants::StaticPlant;
/// use nalgebra::{Matrix2, RowVector2, Vector1, Vector2};
/// let plant = StaticPlant::new(Matrix2::new(1.0, 0.5, 0.0, 1.0), Vector2::new(0.0, 0.5), RowVector2::new(1.0, 0.0))?;
/// let designed = DiscreteLinearObserver::new(plant, Vector2::new(1.0, 0.5), 0.5)?;
/// let q = FixedPointFormat::new(8, 8)?;
/// let observer = FixedPointObserver::rounded(&designed, q.into())?;
/// let mut state = observer.start(Vector2::new(0, 512));
/// observer.step(&mut state, &Vector1::new(512), &Vector1::new(256));
/// assert_eq!((state.xhat.map(|x| q.value(x)), state.saturations), (Vector2::new(2.0, 3.5), 0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FixedPointObserver<N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    gains: FixedPointGains<N, M, P>,
    formats: FixedPointFormats,
}

/// An observer in fixed point whose sizes are known at compile time.
pub type StaticFixedPointObserver<const N: usize, const M: usize, const P: usize> =
    FixedPointObserver<Const<N>, Const<M>, Const<P>>;

impl<N: Dim, M: Dim, P: Dim> FixedPointObserver<N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The observer with these matrices.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for shapes that do not fit; [`ObserverError::FixedPointRange`] for an integer beyond
    /// the format; [`ObserverError::FixedPointSum`] where the magnitudes in a row are so large that a sum of products
    /// could overflow 64 bits.
    pub fn new(gains: FixedPointGains<N, M, P>, formats: FixedPointFormats) -> Result<Self, ObserverError> {
        let FixedPointGains { a, b, c, d, l } = &gains;
        let (n, m, p) = (a.nrows(), b.ncols(), c.nrows());
        shape("A", a.shape(), (n, n))?;
        shape("B", b.shape(), (n, m))?;
        shape("C", c.shape(), (p, n))?;
        shape("L", l.shape(), (n, p))?;
        in_range("A", a, formats.gains)?;
        in_range("B", b, formats.gains)?;
        in_range("C", c, formats.gains)?;
        in_range("L", l, formats.gains)?;
        if let Some(d) = d {
            shape("D", d.shape(), (p, m))?;
            in_range("D", d, formats.gains)?;
        }
        let one = 1_u64 << formats.gains.fraction_bits;
        for k in 0..p {
            let fed = d.as_ref().map_or(0, |d| magnitudes(d, k));
            fits("y - C xhat - D u", k, one + magnitudes(c, k) + fed)?;
        }
        for i in 0..n {
            fits("A xhat + B u + L z", i, magnitudes(a, i) + magnitudes(b, i) + magnitudes(l, i))?;
        }
        Ok(Self { gains, formats })
    }

    /// The observer with the matrices of a design, rounded to nearest, ties to even.
    ///
    /// # Errors
    /// [`ObserverError::FixedPointRange`] for an entry beyond the range of the format; those of [`new`](Self::new).
    pub fn rounded(
        designed: &DiscreteLinearObserver<f64, N, M, P>,
        formats: FixedPointFormats,
    ) -> Result<Self, ObserverError> {
        let LinearPlant { a, b, c, d } = designed.plant();
        let gains = FixedPointGains {
            a: nearest("A", a, formats.gains)?,
            b: nearest("B", b, formats.gains)?,
            c: nearest("C", c, formats.gains)?,
            d: d.as_ref().map(|d| nearest("D", d, formats.gains)).transpose()?,
            l: nearest("L", designed.l(), formats.gains)?,
        };
        Self::new(gains, formats)
    }

    /// The matrices as integers.
    pub fn gains(&self) -> &FixedPointGains<N, M, P> {
        &self.gains
    }

    /// The formats.
    pub fn formats(&self) -> FixedPointFormats {
        self.formats
    }

    /// Lengths of the columns.
    pub fn dimensions(&self) -> ObserverDimensions {
        let FixedPointGains { a, b, c, .. } = &self.gains;
        ObserverDimensions { state: a.nrows(), inputs: b.ncols(), outputs: c.nrows(), estimate: a.nrows() }
    }

    /// The state that begins with this estimate.
    pub fn start(&self, xhat: OVector<i32, N>) -> FixedPointState<N> {
        FixedPointState { xhat, saturations: 0 }
    }

    /// One step, from the sample at t to the estimate at t + period; all numbers are integers of the signals' format.
    pub fn step(&self, state: &mut FixedPointState<N>, u: &OVector<i32, M>, y: &OVector<i32, P>) {
        self.step_partial(state, u, y, &[]);
    }

    /// [`step`](Self::step) of a sample of which only the outputs that are true in `measured` were measured, none for
    /// all: the innovation of the others, which are not read, is 0, so that their columns of L are left out. Integers
    /// have no NaN that could say so.
    pub fn step_partial(
        &self,
        state: &mut FixedPointState<N>,
        u: &OVector<i32, M>,
        y: &OVector<i32, P>,
        measured: &[bool],
    ) {
        let FixedPointGains { a, b, c, d, l } = &self.gains;
        let mut z = y.clone();
        for (k, z) in z.iter_mut().enumerate() {
            if measured.get(k) == Some(&false) {
                *z = 0;
                continue;
            }
            let mut sum = i64::from(*z) << self.formats.gains.fraction_bits;
            sum -= dot(c, k, &state.xhat);
            if let Some(d) = d {
                sum -= dot(d, k, u);
            }
            *z = self.result(sum, &mut state.saturations);
        }
        let mut next = state.xhat.clone();
        for (i, next) in next.iter_mut().enumerate() {
            let sum = dot(a, i, &state.xhat) + dot(b, i, u) + dot(l, i, &z);
            *next = self.result(sum, &mut state.saturations);
        }
        state.xhat = next;
    }

    /// The number of the format nearest to a sum of products, ties upwards.
    fn result(&self, sum: i64, saturations: &mut u32) -> i32 {
        let FixedPointFormats { gains, signals } = self.formats;
        // Half of 2^n, and 0 for n = 0.
        let half = (1_i64 << gains.fraction_bits) >> 1;
        let rounded = (sum + half) >> gains.fraction_bits;
        let within = rounded.clamp(i64::from(signals.smallest()), i64::from(signals.largest()));
        if within != rounded {
            *saturations = saturations.saturating_add(1);
        }
        within as i32
    }
}

/// The sum of the products of a row and a column. Where the row has passed [`fits`], nothing overflows.
fn dot<R: Dim, C: Dim>(m: &OMatrix<i32, R, C>, row: usize, x: &OVector<i32, C>) -> i64
where
    DefaultAllocator: nalgebra::allocator::Allocator<R, C> + nalgebra::allocator::Allocator<C>,
{
    let mut sum = 0_i64;
    for (j, x) in x.iter().enumerate() {
        sum += i64::from(m[(row, j)]) * i64::from(*x);
    }
    sum
}

/// The sum of the magnitudes in a row.
fn magnitudes<R: Dim, C: Dim>(m: &OMatrix<i32, R, C>, row: usize) -> u64
where
    DefaultAllocator: nalgebra::allocator::Allocator<R, C>,
{
    m.row(row).iter().map(|x| u64::from(x.unsigned_abs())).sum()
}

/// Whether every sum of products of numbers of 32 bits with coefficients of these magnitudes fits into 64 bits, with
/// the half that rounding adds.
fn fits(what: &'static str, row: usize, magnitudes: u64) -> Result<(), ObserverError> {
    // (2^32 - 1) 2^31, and 2^30 for the half, are below 2^63.
    if magnitudes < 1 << 32 { Ok(()) } else { Err(ObserverError::FixedPointSum { what, row }) }
}

fn shape(what: &'static str, found: (usize, usize), expected: (usize, usize)) -> Result<(), ObserverError> {
    if found == expected {
        return Ok(());
    }
    Err(ObserverError::Matrix(luenberger_plants::PlantError::DimensionMismatch { what, expected, found }))
}

fn in_range<R: Dim, C: Dim>(
    what: &'static str,
    m: &OMatrix<i32, R, C>,
    format: FixedPointFormat,
) -> Result<(), ObserverError>
where
    DefaultAllocator: nalgebra::allocator::Allocator<R, C>,
{
    for column in 0..m.ncols() {
        for row in 0..m.nrows() {
            let integer = m[(row, column)];
            if !(format.smallest()..=format.largest()).contains(&integer) {
                let FixedPointFormat { integer_bits, fraction_bits } = format;
                let value = format.value(integer);
                return Err(ObserverError::FixedPointRange { what, row, column, value, integer_bits, fraction_bits });
            }
        }
    }
    Ok(())
}

fn nearest<R: Dim, C: Dim>(
    what: &'static str,
    m: &OMatrix<f64, R, C>,
    format: FixedPointFormat,
) -> Result<OMatrix<i32, R, C>, ObserverError>
where
    DefaultAllocator: nalgebra::allocator::Allocator<R, C>,
{
    let mut rounded = OMatrix::<i32, R, C>::zeros_generic(m.shape_generic().0, m.shape_generic().1);
    for column in 0..m.ncols() {
        for row in 0..m.nrows() {
            let value = m[(row, column)];
            let FixedPointFormat { integer_bits, fraction_bits } = format;
            let error = ObserverError::FixedPointRange { what, row, column, value, integer_bits, fraction_bits };
            rounded[(row, column)] = format.nearest(value).ok_or(error)?;
        }
    }
    Ok(rounded)
}
