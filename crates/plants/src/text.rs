//! Matrices in one line of text: `A = [0, 1; -2, -3]`, rows divided by semicolons.

use core::fmt::{self, Display, Formatter};

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, RealField};

use crate::linear::LinearPlant;
use crate::size::Size;

/// Writes `name = [..; ..]`, the entries in the format of `f`, as with `{:.3}`.
///
/// # Errors
/// Those of the formatter.
pub fn write_matrix<T: RealField + Copy, R: Dim, C: Dim>(
    f: &mut Formatter<'_>,
    name: &str,
    matrix: &OMatrix<T, R, C>,
) -> fmt::Result
where
    DefaultAllocator: Allocator<R, C>,
{
    write!(f, "{name} = [")?;
    for i in 0..matrix.nrows() {
        for j in 0..matrix.ncols() {
            if j > 0 {
                f.write_str(", ")?;
            } else if i > 0 {
                f.write_str("; ")?;
            }
            Display::fmt(&matrix[(i, j)], f)?;
        }
    }
    f.write_str("]")
}

/// The matrices, a line each; B only where there are inputs.
///
/// ```
/// let plant = luenberger_plants::double_integrator();
/// assert_eq!(plant.to_string(), "A = [0, 1; 0, 0]\nB = [0; 1]\nC = [1, 0]");
/// assert_eq!(format!("{plant:.1}").lines().next(), Some("A = [0.0, 1.0; 0.0, 0.0]"));
/// ```
impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> Display for LinearPlant<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write_matrix(f, "A", &self.a)?;
        if self.b.ncols() > 0 {
            f.write_str("\n")?;
            write_matrix(f, "B", &self.b)?;
        }
        f.write_str("\n")?;
        write_matrix(f, "C", &self.c)?;
        let Some(d) = &self.d else { return Ok(()) };
        f.write_str("\n")?;
        write_matrix(f, "D", d)
    }
}
