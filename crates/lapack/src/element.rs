//! The two scalars of the real half of BLAS.

use std::ops::{AddAssign, DivAssign, Mul, MulAssign, SubAssign};

use faer::traits::RealField;

/// f32 or f64.
pub(crate) trait Element:
    RealField + Copy + PartialOrd + Mul<Output = Self> + AddAssign + SubAssign + MulAssign + DivAssign
{
    const ZERO: Self;
    const ONE: Self;
    /// A workspace size, as LAPACK returns it: in the first entry of the workspace.
    fn from_size(size: usize) -> Self;
    fn finite(self) -> bool;
}

impl Element for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    fn from_size(size: usize) -> Self {
        // Rounded up, since the caller truncates it back to an integer.
        let rounded = size as f32;
        if (rounded as usize) < size { rounded.next_up() } else { rounded }
    }
    fn finite(self) -> bool {
        self.is_finite()
    }
}

impl Element for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    fn from_size(size: usize) -> Self {
        size as f64
    }
    fn finite(self) -> bool {
        self.is_finite()
    }
}
