//! Linear time-invariant plants `x' = A x + B u`, `y = C x + D u`: eq. (1) of the cubic-observer paper, where D = 0.
//!
//! The direct feedthrough D is stored only where there is one: without it no operation is spent on it, and every result
//! is bitwise that for `y = C x`. D does not affect observability or gains, because u is known: an observer subtracts
//! `D u` from y.

use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField};
#[cfg(feature = "alloc")]
use nalgebra::{Matrix, RawStorage};

use crate::error::{PlantError, check_matrix};
use crate::plant::{Dimensions, Plant, Shape};
use crate::size::Size;

/// `x' = A x + B u`, `y = C x + D u` with N states, M inputs and P outputs.
///
/// A plant without inputs has a B of no columns (`M = 0`).
#[derive(Clone, Debug, PartialEq)]
pub struct LinearPlant<T: RealField + Copy, N: Dim, M: Dim, P: Dim>
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
}

/// A linear plant whose sizes are known at compile time.
pub type StaticPlant<T, const N: usize, const M: usize, const P: usize> = LinearPlant<T, Const<N>, Const<M>, Const<P>>;

/// A linear plant whose sizes are known at run time.
#[cfg(feature = "alloc")]
pub type StateSpace = LinearPlant<f64, nalgebra::Dyn, nalgebra::Dyn, nalgebra::Dyn>;

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> LinearPlant<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The plant with these matrices: A n x n, B n x m, C p x n, n and p at least 1, m may be 0.
    ///
    /// ```
    /// use luenberger_plants::{StateSpace, PlantError};
    /// use nalgebra::DMatrix;
    ///
    /// let a = DMatrix::<f64>::zeros(2, 2);
    /// let b = DMatrix::zeros(2, 1);
    /// let c = DMatrix::zeros(1, 3);
    /// let error = StateSpace::new(a, b, c).unwrap_err();
    /// assert_eq!(error, PlantError::DimensionMismatch { what: "C", expected: (1, 2), found: (1, 3) });
    /// ```
    /// # Errors
    /// [`PlantError::DimensionMismatch`], [`PlantError::NotFinite`] or [`PlantError::Empty`].
    pub fn new(a: OMatrix<T, N, N>, b: OMatrix<T, N, M>, c: OMatrix<T, P, N>) -> Result<Self, PlantError> {
        let (n, m, p) = (a.nrows(), b.ncols(), c.nrows());
        if n == 0 || p == 0 {
            return Err(PlantError::Empty { states: n, outputs: p });
        }
        check_matrix("A", &a, (n, n))?;
        check_matrix("B", &b, (n, m))?;
        check_matrix("C", &c, (p, n))?;
        Ok(Self { a, b, c, d: None })
    }

    /// The same plant with the feedthrough D, p x m: `y = C x + D u`.
    ///
    /// ```
    /// use luenberger_plants::{Plant, StateSpace};
    /// use nalgebra::{dmatrix, dvector};
    /// // A high pass: x' = -x + u, y = u - x.
    /// let plant = StateSpace::new(dmatrix![-1.0], dmatrix![1.0], dmatrix![-1.0])?.with_feedthrough(dmatrix![1.0])?;
    /// assert_eq!(plant.output(0.0, &dvector![0.25], &dvector![1.0]), dvector![0.75]);
    /// # Ok::<(), luenberger_plants::PlantError>(())
    /// ```
    /// # Errors
    /// [`PlantError::DimensionMismatch`] or [`PlantError::NotFinite`].
    pub fn with_feedthrough(self, d: OMatrix<T, P, M>) -> Result<Self, PlantError> {
        check_matrix("D", &d, (self.c.nrows(), self.b.ncols()))?;
        Ok(Self { d: Some(d), ..self })
    }

    /// The same plant, after the checks of [`new`](Self::new) and [`with_feedthrough`](Self::with_feedthrough): for
    /// plants whose public fields were set directly.
    ///
    /// # Errors
    /// Those of these two.
    pub fn checked(self) -> Result<Self, PlantError> {
        let plant = Self::new(self.a, self.b, self.c)?;
        match self.d {
            Some(d) => plant.with_feedthrough(d),
            None => Ok(plant),
        }
    }

    /// The same plant with sizes known at run time.
    ///
    /// ```
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// assert_eq!(plant.a.shape(), (2, 2));
    /// ```
    #[cfg(feature = "alloc")]
    pub fn to_dynamic(&self) -> LinearPlant<T, nalgebra::Dyn, nalgebra::Dyn, nalgebra::Dyn> {
        LinearPlant::<T, nalgebra::Dyn, nalgebra::Dyn, nalgebra::Dyn> {
            a: dynamic(&self.a),
            b: dynamic(&self.b),
            c: dynamic(&self.c),
            d: self.d.as_ref().map(dynamic),
        }
    }
}

#[cfg(feature = "alloc")]
impl<T: RealField + Copy> LinearPlant<T, nalgebra::Dyn, nalgebra::Dyn, nalgebra::Dyn> {
    /// As [`new`](Self::new), from matrices of any kind: of static or dynamic size, owned or views.
    ///
    /// ```
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::{DMatrix, matrix, vector};
    /// let (a, b) = (matrix![0.0, 1.0; 0.0, 0.0], vector![0.0, 1.0]);
    /// let plant = StateSpace::from_matrices(&a, &b, &DMatrix::identity(2, 2).row(0))?;
    /// assert_eq!(plant, luenberger_plants::double_integrator().to_dynamic());
    /// # Ok::<(), luenberger_plants::PlantError>(())
    /// ```
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn from_matrices<Ra: Dim, Ca: Dim, Rb: Dim, Cb: Dim, Rc: Dim, Cc: Dim>(
        a: &Matrix<T, Ra, Ca, impl RawStorage<T, Ra, Ca>>,
        b: &Matrix<T, Rb, Cb, impl RawStorage<T, Rb, Cb>>,
        c: &Matrix<T, Rc, Cc, impl RawStorage<T, Rc, Cc>>,
    ) -> Result<Self, PlantError> {
        Self::new(dynamic(a), dynamic(b), dynamic(c))
    }
}

/// A copy of `matrix` with sizes known at run time.
#[cfg(feature = "alloc")]
fn dynamic<T: RealField + Copy, R: Dim, C: Dim>(
    matrix: &Matrix<T, R, C, impl RawStorage<T, R, C>>,
) -> nalgebra::DMatrix<T> {
    nalgebra::DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)])
}

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> Shape for LinearPlant<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: self.a.nrows(), inputs: self.b.ncols(), outputs: self.c.nrows() }
    }
}

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> Plant<T> for LinearPlant<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    type State = OVector<T, N>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;

    fn derivative(&self, _t: T, x: &Self::State, u: &Self::Input) -> Self::State {
        &self.a * x + &self.b * u
    }

    fn output(&self, _t: T, x: &Self::State, u: &Self::Input) -> Self::Output {
        match &self.d {
            Some(d) => &self.c * x + d * u,
            None => &self.c * x,
        }
    }

    fn is_affine(&self) -> bool {
        true
    }

    fn derivative_into(&self, _t: T, x: &[T], u: &[T], slope: &mut [T]) -> bool {
        let fits = (x.len(), u.len(), slope.len()) == (self.a.ncols(), self.b.ncols(), self.a.nrows());
        if fits {
            for (i, slope) in slope.iter_mut().enumerate() {
                *slope = row_times(&self.a, i, x) + row_times(&self.b, i, u);
            }
        }
        fits
    }

    fn output_into(&self, _t: T, x: &[T], u: &[T], y: &mut [T]) -> bool {
        let fits = (x.len(), u.len(), y.len()) == (self.c.ncols(), self.b.ncols(), self.c.nrows());
        if fits {
            for (i, y) in y.iter_mut().enumerate() {
                let output = row_times(&self.c, i, x);
                *y = self.d.as_ref().map_or(output, |d| output + row_times(d, i, u));
            }
        }
        fits
    }
}

/// Entry `i` of `M v`, its terms added from left to right as nalgebra adds them; 0 without terms.
pub(crate) fn row_times<T: RealField + Copy, R: Dim, C: Dim>(m: &OMatrix<T, R, C>, i: usize, v: &[T]) -> T
where
    DefaultAllocator: nalgebra::allocator::Allocator<R, C>,
{
    let terms = v.iter().enumerate().map(|(j, v)| m[(i, j)] * *v);
    terms.reduce(|sum, term| sum + term).unwrap_or_else(T::zero)
}
