//! A plant in other linear coordinates: `x = T z`, hence `z' = T^-1 f(t, T z, u)`, `y = h(t, T z, u)`.
//!
//! Derivatives are taken from the original plant along `T v` (by dual numbers or by hand): the Jacobians in the new
//! coordinates are `T^-1 Df T` and `Dh T`.
//!
//! Observers that ask for `y = (x_1, .., x_p)` run on any plant with a linear output in coordinates with `C T = [I 0]`;
//! and a triangular T = [I 0; K I] changes which part of the Jacobian is the unmeasured block.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, U1, convert};

use crate::column::Column;
use crate::error::{PlantError, check_matrix};
use crate::jacobian::Differentiable;
use crate::plant::{Dimensions, Plant, Shape};
use crate::size::Size;

/// The plant `S` in the coordinates z, `x = T z`.
#[derive(Clone, Debug, PartialEq)]
pub struct InCoordinates<S, T: RealField + Copy, N: Dim>
where
    DefaultAllocator: Allocator<N, N>,
{
    plant: S,
    matrix: OMatrix<T, N, N>,
    inverse: OMatrix<T, N, N>,
    measured_first: bool,
}

impl<S, T: RealField + Copy, N: Dim> InCoordinates<S, T, N>
where
    S: Plant<T, State = OVector<T, N>>,
    DefaultAllocator: Allocator<N, N> + Allocator<N>,
{
    /// `plant` with `x = T z`, T n x n and invertible.
    ///
    /// ```
    /// use luenberger_plants::coordinates::InCoordinates;
    /// use luenberger_plants::{Plant, double_integrator};
    /// use nalgebra::{Matrix2, Vector1, Vector2};
    /// // Millimetres for metres: x = z / 1000.
    /// let plant = InCoordinates::new(double_integrator(), Matrix2::identity() * 1e-3)?;
    /// let slope = plant.derivative(0.0, &Vector2::new(1.0, 2.0), &Vector1::new(0.5));
    /// assert!((slope - Vector2::new(2.0, 500.0)).amax() <= 1e-12);
    /// # Ok::<(), luenberger_plants::PlantError>(())
    /// ```
    /// # Errors
    /// [`PlantError::DimensionMismatch`], [`PlantError::NotFinite`], and [`PlantError::Singular`] when T has no inverse
    /// in this arithmetic.
    pub fn new(plant: S, t: OMatrix<T, N, N>) -> Result<Self, PlantError> {
        let n = plant.dimensions().states;
        check_matrix("T", &t, (n, n))?;
        let singular = |condition: f64| PlantError::Singular { what: "T", condition };
        let inverse = t.clone().try_inverse().ok_or(singular(f64::INFINITY))?;
        let condition = t.norm() * inverse.norm();
        // Beyond this no digit of T^-1 is known.
        let known = condition.is_finite() && condition * T::default_epsilon() * convert(n as f64) <= T::one();
        if !known {
            return Err(singular(condition.to_subset_unchecked()));
        }
        Ok(Self { plant, matrix: t, inverse, measured_first: false })
    }

    /// As [`new`](Self::new), of a plant whose outputs *are* the first coordinates: `h(T z, u) = (z_1, .., z_p)` up to
    /// rounding, which is what [`output`](Plant::output) then returns, exactly.
    ///
    /// # Errors
    /// As [`new`](Self::new), and [`PlantError::OutputNotCoordinate`] when h(T z, u) differs by more than the rounding
    /// of T and of its inverse (tested at two states and inputs).
    pub fn measured_first<M: Dim>(plant: S, t: OMatrix<T, N, N>) -> Result<Self, PlantError>
    where
        S: Plant<T, Input = OVector<T, M>>,
        DefaultAllocator: Allocator<M>,
    {
        let new = Self::new(plant, t)?;
        let size = new.plant.dimensions();
        let condition = new.condition();
        for scale in [2.0, -3.0] {
            let z = OVector::from_fn_generic(new.matrix.shape_generic().0, U1, |i, _| {
                convert::<f64, T>(scale * (i as f64 + 1.0))
            });
            let u = OVector::from_fn_generic(M::from_usize(size.inputs), U1, |j, _| {
                convert::<f64, T>(scale * (j as f64 + 0.5))
            });
            let y = new.plant.output(T::zero(), &(&new.matrix * &z), &u);
            let allowed = T::default_epsilon() * convert(16.0 * size.states as f64) * condition * z.norm();
            for (output, &found) in y.as_slice().iter().enumerate() {
                let expected = z.get(output).copied();
                if !expected.is_some_and(|expected| (found - expected).abs() <= allowed) {
                    return Err(PlantError::OutputNotCoordinate {
                        output,
                        expected: expected.map_or(f64::NAN, |x| x.to_subset_unchecked()),
                        found: found.to_subset_unchecked(),
                    });
                }
            }
        }
        Ok(Self { measured_first: true, ..new })
    }

    /// `|T| |T^-1|` in the Frobenius norm: at least the condition number, at most n times it.
    pub fn condition(&self) -> T {
        self.matrix.norm() * self.inverse.norm()
    }

    /// The plant in its own coordinates.
    pub fn plant(&self) -> &S {
        &self.plant
    }

    /// The transformation T, n x n, `x = T z`.
    pub fn matrix(&self) -> &OMatrix<T, N, N> {
        &self.matrix
    }

    /// `T^-1`, n x n.
    pub fn inverse(&self) -> &OMatrix<T, N, N> {
        &self.inverse
    }
}

impl<T: RealField + Copy, S: Shape, N: Dim> Shape for InCoordinates<S, T, N>
where
    DefaultAllocator: Allocator<N, N>,
{
    fn dimensions(&self) -> Dimensions {
        self.plant.dimensions()
    }
}

impl<T: RealField + Copy, S, N: Dim> Plant<T> for InCoordinates<S, T, N>
where
    S: Plant<T, State = OVector<T, N>>,
    DefaultAllocator: Allocator<N, N> + Allocator<N>,
{
    type State = OVector<T, N>;
    type Input = S::Input;
    type Output = S::Output;

    fn derivative(&self, t: T, z: &Self::State, u: &Self::Input) -> Self::State {
        &self.inverse * self.plant.derivative(t, &(&self.matrix * z), u)
    }

    fn output(&self, t: T, z: &Self::State, u: &Self::Input) -> Self::Output {
        if self.measured_first {
            let outputs = self.plant.dimensions().outputs;
            if let Some(y) = z.as_slice().get(..outputs).and_then(S::Output::try_from_slice) {
                return y;
            }
        }
        self.plant.output(t, &(&self.matrix * z), u)
    }
}

impl<T, S, N, M, P> Differentiable<T, N, M, P> for InCoordinates<S, T, N>
where
    S: Differentiable<T, N, M, P>,
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P>,
{
    fn directional(
        &self,
        t: T,
        z: &OVector<T, N>,
        u: &OVector<T, M>,
        v: &OVector<T, N>,
    ) -> (OVector<T, N>, OVector<T, N>) {
        let (slope, along) = self.plant.directional(t, &(&self.matrix * z), u, &(&self.matrix * v));
        (&self.inverse * slope, &self.inverse * along)
    }

    fn output_directional(
        &self,
        t: T,
        z: &OVector<T, N>,
        u: &OVector<T, M>,
        v: &OVector<T, N>,
    ) -> (OVector<T, P>, OVector<T, P>) {
        if self.measured_first {
            let size = self.plant.dimensions();
            if let (Some(y), Some(along)) = (
                z.as_slice().get(..size.outputs).and_then(OVector::<T, P>::try_from_slice),
                v.as_slice().get(..size.outputs).and_then(OVector::<T, P>::try_from_slice),
            ) {
                return (y, along);
            }
        }
        self.plant.output_directional(t, &(&self.matrix * z), u, &(&self.matrix * v))
    }
}
