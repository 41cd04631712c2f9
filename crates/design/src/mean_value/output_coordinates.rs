//! Coordinates in which the outputs are the first states: `x = T z` with `C T = [I 0]`.
//!
//! The observer of the paper requires C = [I 0]. Every C of full row rank can be transformed to it: with `C' = Q [R;
//! 0]`, `T = [Q_1 R^-T, s Q_2]`. The first columns are the pseudo-inverse of C, s is free. No T has a smaller condition
//! number than C itself: its first columns are some right inverse of C, with norm at least that of the pseudo-inverse,
//! and `T^-1` contains C. With s the reciprocal of the geometric mean of the largest and the smallest singular value, T
//! attains that condition number.

use std::fmt;

use luenberger_linalg::{RealMatrixView, symmetric_eigenvalues};
use luenberger_plants::{Differentiable, InCoordinates, Plant, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DMatrix, DefaultAllocator, Dim, OVector, U1};

use crate::check;
use crate::error::DesignError;
use crate::number::short;

/// A change of coordinates that makes the outputs the first states.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputCoordinates {
    /// C, p x n, in the plant's own coordinates.
    pub c: DMatrix<f64>,
    /// T, n x n, `x = T z`, `C T = [I 0]` up to rounding; the identity where C already is [I 0].
    pub t: DMatrix<f64>,
    /// The condition number of T, which is that of C.
    pub condition: f64,
}

impl OutputCoordinates {
    /// T for C (p x n, p <= n).
    ///
    /// ```
    /// use luenberger_design::mean_value::OutputCoordinates;
    /// use nalgebra::{DMatrix, dmatrix};
    /// let c = dmatrix![1.0, 1.0, 0.0; 0.0, 3.0, 4.0];
    /// let change = OutputCoordinates::of_matrix(&c)?;
    /// let residual = (&c * &change.t - DMatrix::identity(2, 3)).amax();
    /// assert!(residual <= 16.0 * f64::EPSILON);
    /// println!("{change}");
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// [`DesignError::DependentOutputs`] with the smallest singular value of C, its rows scaled to length one;
    /// [`DesignError::Matrix`].
    pub fn of_matrix<'a>(c: impl Into<RealMatrixView<'a>>) -> Result<Self, DesignError> {
        Self::of_owned(check::owned(c))
    }

    fn of_owned(c: DMatrix<f64>) -> Result<Self, DesignError> {
        let (p, n) = c.shape();
        if p == 0 || n == 0 {
            return Err(luenberger_plants::PlantError::Empty { states: n, outputs: p }.into());
        }
        check::matrix("C", &c, (p, n))?;
        if p > n {
            return Err(DesignError::DependentOutputs { sigma_min: 0.0 });
        }
        check::independent_outputs(&c)?;
        if c == DMatrix::identity(p, n) {
            return Ok(Self { c, t: DMatrix::identity(n, n), condition: 1.0 });
        }
        // Singular values of C in units in which the squares are harmless.
        let scale = c.amax();
        let unit = &c / scale;
        let squares = symmetric_eigenvalues(&(&unit * unit.transpose()))?;
        let (least, most) = squares.iter().fold((f64::INFINITY, 0.0f64), |(a, b), &x| (a.min(x), b.max(x)));
        let (least, most) = (scale * least.max(0.0).sqrt(), scale * most.sqrt());
        // [C' I] has full row rank: its Q is complete.
        let full = DMatrix::from_fn(n, n + p, |i, j| if j < p { c[(j, i)] } else { f64::from(i == j - p) });
        let q = full.qr().q();
        let r = q.columns(0, p).transpose() * c.transpose();
        let Some(inverse) = r.transpose().try_inverse() else {
            return Err(DesignError::DependentOutputs { sigma_min: least });
        };
        let first = q.columns(0, p) * inverse;
        let rest = q.columns(p, n - p) / (least * most).sqrt();
        let t = DMatrix::from_fn(n, n, |i, j| if j < p { first[(i, j)] } else { rest[(i, j - p)] });
        check::matrix("T", &t, (n, n))?;
        Ok(Self { c, t, condition: most / least })
    }

    /// T for the outputs of a plant, which must be linear and free of the input: `h(t, x, u) = C x` with a constant C.
    ///
    /// # Errors
    /// [`DesignError::NonlinearOutput`] with the numbers when h is something else at one of four states
    /// and inputs, [`DesignError::Feedthrough`] when it depends on the input there; as
    /// [`of_matrix`](Self::of_matrix).
    pub fn of<S, N: Dim, M: Dim, P: Dim>(plant: &S) -> Result<Self, DesignError>
    where
        S: Differentiable<f64, N, M, P>,
        DefaultAllocator: Size<N, M, P>,
    {
        let size = plant.dimensions();
        let order = N::from_usize(N::try_to_usize().unwrap_or(size.states));
        let point = |scale: f64| {
            OVector::<f64, N>::from_fn_generic(order, U1, |i, _| {
                scale * (1.0 + i as f64 * 0.75 + f64::from(i % 2 == 1))
            })
        };
        let input = |scale: f64| {
            OVector::<f64, M>::from_fn_generic(M::from_usize(size.inputs), U1, |j, _| scale * (0.5 + j as f64))
        };
        let c = plant.output_jacobian(0.0, &point(0.25), &input(0.0));
        let c = DMatrix::from_column_slice(c.nrows(), c.ncols(), c.as_slice());
        check::matrix("Dh", &c, (size.outputs, size.states))?;
        for (t, scale) in [(0.0, 1.0), (1.0, -2.0), (0.5, 0.0), (2.0, 7.0)] {
            let x = point(scale);
            let found = plant.output(t, &x, &input(0.0));
            let under_input = plant.output(t, &x, &input(1.0 + scale));
            if let Some(output) = (0..size.outputs).find(|&k| found[k] != under_input[k]) {
                return Err(DesignError::Feedthrough { output });
            }
            for output in 0..size.outputs {
                let row = c.row(output);
                let terms = row.iter().zip(x.iter());
                let (expected, sum) = terms.fold((0.0, 0.0), |(a, b), (c, x)| (a + c * x, b + (c * x).abs()));
                let found = found[output];
                // Two evaluations of n terms.
                let agrees = (found - expected).abs() <= 4.0 * size.states as f64 * f64::EPSILON * sum;
                if !agrees {
                    let point = x.as_slice().to_vec();
                    return Err(DesignError::NonlinearOutput { output, expected, found, point });
                }
            }
        }
        Self::of_matrix(&c)
    }

    /// `plant` in the coordinates z, for which the mean-value observer is made.
    ///
    /// # Errors
    /// [`DesignError::Matrix`] when the outputs of the plant are not those of this C.
    pub fn plant<S, N: Dim, M: Dim>(&self, plant: S) -> Result<InCoordinates<S, f64, N>, DesignError>
    where
        S: Plant<f64, State = OVector<f64, N>, Input = OVector<f64, M>>,
        DefaultAllocator: Allocator<N, N> + Allocator<N> + Allocator<M>,
    {
        let n = plant.dimensions().states;
        Ok(InCoordinates::measured_first(plant, check::sized("T", &self.t, (n, n))?)?)
    }
}

impl fmt::Display for OutputCoordinates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (p, n) = self.c.shape();
        if self.t == DMatrix::identity(n, n) {
            return writeln!(f, "The {p} outputs are the first states already: x = z.");
        }
        writeln!(f, "The {p} outputs are not the first states. In x = T z they are, C T = [I 0], with")?;
        write!(f, "T = {}", self.t)?;
        writeln!(f, "of condition {}, the least there is for this C.", short(self.condition))
    }
}
