//! The format of numbers on the target.

/// The format of numbers on the target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    /// IEEE 754 binary32, `float`.
    Binary32,
    /// IEEE 754 binary64, `double`.
    Binary64,
}

impl Scalar {
    /// `f32` or `f64`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Binary32 => "f32",
            Self::Binary64 => "f64",
        }
    }

    /// Bytes of a number.
    pub fn bytes(self) -> usize {
        match self {
            Self::Binary32 => 4,
            Self::Binary64 => 8,
        }
    }

    /// The product of two numbers of the format.
    pub(crate) fn multiply(self, x: f64, y: f64) -> f64 {
        match self {
            Self::Binary32 => f64::from(x as f32 * y as f32),
            Self::Binary64 => x * y,
        }
    }

    /// The nearest number of the format; infinite beyond its range.
    pub fn round(self, x: f64) -> f64 {
        match self {
            Self::Binary32 => f64::from(x as f32),
            Self::Binary64 => x,
        }
    }
}
