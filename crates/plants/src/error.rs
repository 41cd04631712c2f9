//! Errors in the data of a plant.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, RealField};

/// Error in the matrices or parameters of a plant.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlantError {
    /// A matrix whose shape does not fit the others.
    #[error("{what} must be {} x {}, found {} x {}", expected.0, expected.1, found.0, found.1)]
    DimensionMismatch {
        /// Name of the matrix.
        what: &'static str,
        /// Required rows and columns.
        expected: (usize, usize),
        /// Actual rows and columns.
        found: (usize, usize),
    },
    /// A matrix in a file whose rows have different lengths.
    #[error("row {} of {what} has {found} {} where row 1 has {expected}", row + 1, if *found == 1 { "entry" } else { "entries" })]
    Ragged {
        /// Name of the matrix.
        what: &'static str,
        /// The first row of another length than the first, from 0.
        row: usize,
        /// Entries of the first row.
        expected: usize,
        /// Entries of this row.
        found: usize,
    },
    /// An entry that is NaN or infinite.
    #[error("{what}({}, {}) is {value}, not a finite number", row + 1, column + 1)]
    NotFinite {
        /// Name of the matrix.
        what: &'static str,
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// A transformation without a finite inverse in binary64.
    #[error("{what} is singular to rounding: |{what}| |{what}^-1| = {condition:.2e}")]
    Singular {
        /// Name of the matrix.
        what: &'static str,
        /// Its condition number in the Frobenius norm; infinite where no inverse was found.
        condition: f64,
    },
    /// Output i is not coordinate i of the state.
    #[error("output y{0} is {found} where the state x{0} is {expected}", output + 1)]
    OutputNotCoordinate {
        /// Index of the output, from 0.
        output: usize,
        /// The coordinate at the point tried; NaN if there is none.
        expected: f64,
        /// The output there.
        found: f64,
    },
    /// A plant without states or without outputs: there is nothing to observe.
    #[error("a plant needs at least one state and one output: {states} states, {outputs} outputs")]
    Empty {
        /// Number of states.
        states: usize,
        /// Number of outputs.
        outputs: usize,
    },
    /// A physical parameter that is not a positive number.
    #[error("{what} is {value}; it must be positive and finite")]
    NotPositive {
        /// Name of the parameter.
        what: &'static str,
        /// The value given.
        value: f64,
    },
}

/// Checks that `matrix` is `expected.0` x `expected.1` and that its entries are finite.
///
/// ```
/// use luenberger_plants::error::check_matrix;
/// let a = nalgebra::Matrix2::new(0.0, 1.0, f64::NAN, 0.0);
/// let error = check_matrix("A", &a, (2, 2)).unwrap_err();
/// assert_eq!(error.to_string(), "A(2, 1) is NaN, not a finite number");
/// ```
/// # Errors
/// [`PlantError::DimensionMismatch`], [`PlantError::NotFinite`] (the first such entry, by columns).
pub fn check_matrix<T, R, C>(
    what: &'static str,
    matrix: &OMatrix<T, R, C>,
    expected: (usize, usize),
) -> Result<(), PlantError>
where
    T: RealField + Copy,
    R: Dim,
    C: Dim,
    DefaultAllocator: Allocator<R, C>,
{
    let found = matrix.shape();
    if found != expected {
        return Err(PlantError::DimensionMismatch { what, expected, found });
    }
    for column in 0..found.1 {
        for row in 0..found.0 {
            let value = matrix[(row, column)];
            if !value.is_finite() {
                return Err(PlantError::NotFinite { what, row, column, value: value.to_subset_unchecked() });
            }
        }
    }
    Ok(())
}
