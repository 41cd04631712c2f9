//! Operating points: a state at which a plant rests under a constant input, `f(x, u) = 0`, and the linear plant there.
//!
//! Method: Newton's method with the exact Jacobian, damped by the natural monotonicity test: a step is shortened until
//! the next correction, with the same Jacobian, is shorter. The test does not depend on the units of f, and lengths are
//! relative to the units of the states, the largest magnitude that a state has had, or 1 where it was always zero. It
//! has converged when the correction is below `sqrt(EPSILON)` of them; the next one, which is made, is of the order of
//! its square. Whether the Jacobian is singular is decided with its columns and rows scaled to the length 1.
//!
//! Source: P. Deuflhard, Newton Methods for Nonlinear Problems, Springer 2004, section 3.3 (NLEQ-ERR).

use luenberger_linalg::eigenvalues;
use luenberger_plants::{Differentiable, Dual64, Plant, PlantError, Size, StateSpace, linearize};
use luenberger_proof::wording::significant;
use nalgebra::{Complex, DMatrix, DVector, DefaultAllocator, Dim, OVector, U1};
use thiserror::Error;

use crate::error::DesignError;
use crate::names;

/// At most so many Newton steps.
const STEPS: usize = 50;

/// A step is halved at most so often.
const HALVINGS: usize = 20;

/// A Jacobian with columns and rows of length 1 is singular to working precision beyond this condition.
const SINGULAR: f64 = 1e13;

/// An operating point with its linearisation.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatingPoint {
    /// The state.
    pub x: DVector<f64>,
    /// The input.
    pub u: DVector<f64>,
    /// The output, `h(x, u)`.
    pub y: DVector<f64>,
    /// The largest `|f_i(x, u)|` that is left.
    pub residual: f64,
    /// How many Newton steps were taken.
    pub steps: usize,
    /// The linearised plant of the deviations: A, B, C and D at the point.
    pub linear: StateSpace,
    /// The eigenvalues of A.
    pub poles: Vec<Complex<f64>>,
}

/// Why there is no operating point.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum OperatingPointError {
    /// A vector of another length, or with an entry that is not finite; or A, B, C, D with such an entry.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// f is not finite at an iterate.
    #[error("{}' = {value} at the state {}: the plant is not defined there", names::state(*row), short(x))]
    Undefined {
        /// Which entry of f, from 0.
        row: usize,
        /// Its value.
        value: f64,
        /// Where.
        x: Vec<f64>,
    },
    /// df/dx is singular: the operating point is not isolated, or there is none nearby.
    #[error(
        "df/dx is singular at the state {} (condition {}): for this input there is no operating point, or not a single one",
        short(x),
        significant(*condition, 2)
    )]
    Singular {
        /// Where.
        x: Vec<f64>,
        /// Its condition, in the units of the states.
        condition: f64,
    },
    /// Newton's method does not converge.
    #[error(
        "no operating point was found in {steps} Newton steps: at the state {} the largest |f| is {}, and the next correction is {} times the state", short(x), significant(*residual, 3), significant(*correction, 3)
    )]
    NotConverged {
        /// How many steps.
        steps: usize,
        /// Where it stopped.
        x: Vec<f64>,
        /// The largest `|f_i|` there.
        residual: f64,
        /// The length of the next correction, relative to the state.
        correction: f64,
    },
}

/// A state with five digits.
fn short(x: &[f64]) -> String {
    format!("[{}]", x.iter().map(|x| significant(*x, 5)).collect::<Vec<_>>().join(", "))
}

impl From<PlantError> for OperatingPointError {
    fn from(error: PlantError) -> Self {
        Self::Design(error.into())
    }
}

/// The operating point of `plant` under the constant input `u` (length m) near the state `guess` (length n), at time 0.
///
/// Converges quadratically from near enough; a guess at which f is zero is an operating point even where df/dx is
/// singular, as for a cart anywhere on its rail. Cost: n evaluations of f over dual numbers and one factorisation for
/// each step.
///
/// ```
/// use luenberger_design::operating_point;
/// use luenberger_plants::from_fn;
/// use luenberger_plants::flexible_joint;
/// use nalgebra::{Vector1, Vector4};
/// // A constant torque holds the joint, whose angles then differ.
/// let plant = flexible_joint::classical();
/// let point = operating_point(&plant, &Vector4::zeros(), &Vector1::new(0.1))?;
/// assert!(point.residual < 1e-13 && point.x[1].abs() < 1e-15);
/// assert!((48.6 * (point.x[0] - point.x[2]) - 2.16).abs() < 1e-12);
/// // The slope of the sine there.
/// assert!((point.linear.a[(3, 2)] + 19.5 + 3.33 * point.x[2].cos()).abs() < 1e-13);
/// # Ok::<(), luenberger_design::OperatingPointError>(())
/// ```
/// # Errors
/// [`OperatingPointError`], each with the state where it stopped.
pub fn operating_point<S, N: Dim, M: Dim, P: Dim>(
    plant: &S,
    guess: &OVector<f64, N>,
    u: &OVector<f64, M>,
) -> Result<OperatingPoint, OperatingPointError>
where
    S: Differentiable<f64, N, M, P>
        + Plant<Dual64, State = OVector<Dual64, N>, Input = OVector<Dual64, M>, Output = OVector<Dual64, P>>,
    DefaultAllocator: Size<N, M, P>,
{
    let size = plant.dimensions();
    luenberger_plants::error::check_matrix("x", guess, (size.states, 1))?;
    luenberger_plants::error::check_matrix("u", u, (size.inputs, 1))?;
    let at =
        |x: &DVector<f64>| OVector::<f64, N>::from_iterator_generic(guess.shape_generic().0, U1, x.iter().copied());
    let value = |x: &DVector<f64>| {
        let f = plant.derivative(0.0, &at(x), u);
        let f = DVector::from_column_slice(f.as_slice());
        match f.iter().position(|entry| !entry.is_finite()) {
            Some(row) => Err(OperatingPointError::Undefined { row, value: f[row], x: x.as_slice().to_vec() }),
            None => Ok(f),
        }
    };
    let guess = DVector::from_column_slice(guess.as_slice());
    let (mut x, mut f) = (guess.clone(), value(&guess)?);
    let mut largest = guess.abs();
    let mut steps = 0;
    while f.iter().any(|entry| *entry != 0.0) {
        let jacobian = plant.state_jacobian(0.0, &at(&x), u);
        let jacobian = DMatrix::from_column_slice(jacobian.nrows(), jacobian.ncols(), jacobian.as_slice());
        largest = largest.sup(&x.abs());
        let units = largest.map(|size| if size > 0.0 { size } else { 1.0 });
        let newton = Newton::new(&jacobian, &units, &x)?;
        let correction = newton.correction(&f);
        let length = correction.norm();
        let stopped = |x: &DVector<f64>, f: &DVector<f64>| OperatingPointError::NotConverged {
            steps,
            x: x.as_slice().to_vec(),
            residual: f.amax(),
            correction: length,
        };
        if steps == STEPS {
            return Err(stopped(&x, &f));
        }
        // At the accuracy of f itself no step is shorter than the one before.
        if length <= 4.0 * f64::EPSILON {
            break;
        }
        let mut damping = 1.0;
        let mut next = None;
        for _ in 0..=HALVINGS {
            let trial = &x - units.component_mul(&correction) * damping;
            if let Ok(found) = value(&trial)
                && (newton.correction(&found).norm() <= (1.0 - damping / 4.0) * length || length <= f64::EPSILON.sqrt())
            {
                next = Some((trial, found));
                break;
            }
            damping /= 2.0;
        }
        let Some(found) = next else { return Err(stopped(&x, &f)) };
        (x, f) = found;
        steps += 1;
        if length <= f64::EPSILON.sqrt() {
            break;
        }
    }
    let state = at(&x);
    let linear = linearize(plant, 0.0, &state, u).to_dynamic().checked()?;
    let y = plant.output(0.0, &state, u);
    Ok(OperatingPoint {
        residual: f.amax(),
        u: DVector::from_column_slice(u.as_slice()),
        y: DVector::from_column_slice(y.as_slice()),
        poles: eigenvalues(&linear.a).map_err(DesignError::from)?,
        x,
        steps,
        linear,
    })
}

/// The Jacobian at one state, factorised, with columns and rows of length 1.
struct Newton {
    /// The factors that turn an entry of the solution into a correction in the units of the states.
    columns: DVector<f64>,
    rows: DVector<f64>,
    factors: nalgebra::SVD<f64, nalgebra::Dyn, nalgebra::Dyn>,
}

impl Newton {
    fn new(jacobian: &DMatrix<f64>, units: &DVector<f64>, x: &DVector<f64>) -> Result<Self, OperatingPointError> {
        let singular = |condition| OperatingPointError::Singular { x: x.as_slice().to_vec(), condition };
        luenberger_plants::error::check_matrix("df/dx", jacobian, jacobian.shape())?;
        let mut scaled = jacobian.clone();
        let lengths = DVector::from_iterator(scaled.ncols(), scaled.column_iter().map(|column| column.norm()));
        if lengths.iter().any(|length| *length == 0.0) {
            return Err(singular(f64::INFINITY));
        }
        for (mut column, length) in scaled.column_iter_mut().zip(lengths.iter()) {
            column /= *length;
        }
        let rows = DVector::from_iterator(scaled.nrows(), scaled.row_iter().map(|row| row.norm()));
        if rows.iter().any(|length| *length == 0.0) {
            return Err(singular(f64::INFINITY));
        }
        for (mut row, length) in scaled.row_iter_mut().zip(rows.iter()) {
            row /= *length;
        }
        let factors = scaled.svd(true, true);
        let condition = factors.singular_values.max() / factors.singular_values.min();
        if condition.is_nan() || condition > SINGULAR {
            return Err(singular(if condition.is_nan() { f64::INFINITY } else { condition }));
        }
        let columns = lengths.zip_map(units, |length, unit| 1.0 / length / unit);
        Ok(Self { columns, rows, factors })
    }

    /// `J^-1 f` in the units of the states.
    fn correction(&self, f: &DVector<f64>) -> DVector<f64> {
        let scaled = f.component_div(&self.rows);
        // Both factors were computed.
        let solved = self.factors.solve(&scaled, 0.0).unwrap_or_else(|_| DVector::repeat(f.len(), f64::NAN));
        solved.component_mul(&self.columns)
    }
}
