//! Linear plants in files (feature `serde`), in any format of serde.
//!
//! A plant is written as its matrices, each an array of rows, and read through [`LinearPlant::checked`]: a file that
//! was changed by hand gives a plant whose shapes fit and whose entries are finite, or the error. Sizes known at
//! compile time must be those of the file.
//!
//! ```
//! use luenberger_plants::{StateSpace, double_integrator};
//! let text = serde_json::to_string(&double_integrator())?;
//! assert_eq!(text, r#"{"a":[[0.0,1.0],[0.0,0.0]],"b":[[0.0],[1.0]],"c":[[1.0,0.0]]}"#);
//! let read: StateSpace = serde_json::from_str(&text)?;
//! assert_eq!(read, double_integrator().to_dynamic());
//! let error = serde_json::from_str::<StateSpace>(&text.replace("[0.0,0.0]", "[0.0]")).unwrap_err();
//! assert_eq!(error.to_string(), "row 2 of A has 1 entry where row 1 has 2");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use alloc::vec::Vec;

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, RealField, Scalar};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::PlantError;
use crate::linear::LinearPlant;
use crate::size::Size;

/// A matrix as an array of its rows.
pub type Rows<T> = Vec<Vec<T>>;

/// The rows of a matrix.
pub fn rows<T: Scalar + Copy, R: Dim, C: Dim>(m: &OMatrix<T, R, C>) -> Rows<T>
where
    DefaultAllocator: Allocator<R, C>,
{
    m.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// The matrix with these rows.
///
/// # Errors
/// [`PlantError::Ragged`] for rows of different lengths, [`PlantError::DimensionMismatch`] for another size than the
/// type has.
pub fn matrix<T: Scalar + Copy, R: Dim, C: Dim>(
    what: &'static str,
    rows: &[Vec<T>],
) -> Result<OMatrix<T, R, C>, PlantError>
where
    DefaultAllocator: Allocator<R, C>,
{
    let length = rows.first().map(Vec::len);
    let width = length.or(C::try_to_usize()).unwrap_or(0);
    if let Some((row, found)) = rows.iter().map(Vec::len).enumerate().find(|(_, found)| *found != width) {
        return Err(PlantError::Ragged { what, row, expected: width, found });
    }
    let expected = (R::try_to_usize().unwrap_or(rows.len()), C::try_to_usize().unwrap_or(width));
    let found = (rows.len(), width);
    if found != expected {
        return Err(PlantError::DimensionMismatch { what, expected, found });
    }
    Ok(OMatrix::from_fn_generic(R::from_usize(found.0), C::from_usize(width), |i, j| rows[i][j]))
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Linear<T> {
    a: Rows<T>,
    b: Rows<T>,
    c: Rows<T>,
    #[serde(skip_serializing_if = "Option::is_none")]
    d: Option<Rows<T>>,
}

impl<T: RealField + Copy + Serialize, N: Dim, M: Dim, P: Dim> Serialize for LinearPlant<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { a, b, c, d } = self;
        Linear { a: rows(a), b: rows(b), c: rows(c), d: d.as_ref().map(rows) }.serialize(serializer)
    }
}

impl<'de, T: RealField + Copy + Deserialize<'de>, N: Dim, M: Dim, P: Dim> Deserialize<'de> for LinearPlant<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Linear { a, b, c, d } = Linear::<T>::deserialize(deserializer)?;
        let build = || -> Result<Self, PlantError> {
            let d = d.map(|d| matrix("D", &d)).transpose()?;
            Self { a: matrix("A", &a)?, b: matrix("B", &b)?, c: matrix("C", &c)?, d }.checked()
        };
        build().map_err(D::Error::custom)
    }
}
