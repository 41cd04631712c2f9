//! Number formats of a target: binary32, binary64, fixed point.

use core::fmt;

use crate::error::ProofError;
use crate::exact::{Exact, power_of_two};
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;

/// A number format. Rounding is to nearest, ties to even; a number beyond the largest number of the format is an error,
/// there is no saturation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// IEEE 754 single precision, `f32`.
    Binary32,
    /// IEEE 754 double precision, `f64`.
    Binary64,
    /// Two's complement with `integer_bits + fraction_bits` bits (2 to 53), Qm.n: the multiples of `2^-fraction_bits`
    /// from `-2^(integer_bits - 1)` to `2^(integer_bits - 1) - 2^-fraction_bits`. The sign is one of the integer bits
    /// (ARM's Qm.n; TI's Qm.n has m + 1 integer bits in this notation).
    Fixed {
        /// Bits before the point, including the sign; at least 1.
        integer_bits: u32,
        /// Bits after the point.
        fraction_bits: u32,
    },
}

impl Format {
    /// # Errors
    /// [`ProofError::Format`] for a fixed-point format that is not supported.
    pub(super) fn check(self) -> Result<(), ProofError> {
        match self {
            Self::Fixed { integer_bits, fraction_bits }
                if integer_bits == 0
                    || !(2..=53).contains(&u64::from(integer_bits).saturating_add(u64::from(fraction_bits))) =>
            {
                Err(ProofError::Format { integer_bits, fraction_bits })
            }
            _ => Ok(()),
        }
    }

    /// The largest number of the format; 0 for an unsupported fixed-point format.
    pub fn largest(self) -> f64 {
        match self {
            Self::Binary32 => f64::from(f32::MAX),
            Self::Binary64 => f64::MAX,
            Self::Fixed { integer_bits, fraction_bits } => {
                if self.check().is_err() {
                    return 0.0;
                }
                power_of_two(i64::from(integer_bits) - 1) - power_of_two(-i64::from(fraction_bits))
            }
        }
    }

    /// The number of the format nearest to `x`, ties to even.
    ///
    /// `None` for NaN, for numbers beyond the largest number (no saturation), and for unsupported formats.
    /// ```
    /// use luenberger_proof::statement::Format;
    /// let q4_4 = Format::Fixed { integer_bits: 4, fraction_bits: 4 };
    /// assert_eq!(q4_4.round(0.1), Some(0.125));
    /// assert_eq!(q4_4.round(0.03125), Some(0.0));
    /// assert_eq!((q4_4.round(7.9375), q4_4.round(8.0), q4_4.round(-8.0)), (Some(7.9375), None, Some(-8.0)));
    /// assert_eq!(Format::Binary32.round(0.1), Some(f64::from(0.1_f32)));
    /// assert_eq!(Format::Binary32.round(1e39), None);
    /// ```
    pub fn round(self, x: f64) -> Option<f64> {
        let rounded = match self {
            Self::Binary32 => f64::from(x as f32),
            Self::Binary64 => x,
            Self::Fixed { integer_bits, fraction_bits } => {
                self.check().ok()?;
                let unit = power_of_two(i64::from(fraction_bits));
                let half = power_of_two(i64::from(integer_bits) - 1 + i64::from(fraction_bits));
                let multiple = (x * unit).round_ties_even();
                if !(-half..half).contains(&multiple) {
                    return None;
                }
                multiple / unit
            }
        };
        rounded.is_finite().then_some(rounded)
    }

    /// The number of the format nearest to `x`, ties to even, with **one** rounding; an intermediate binary64 number
    /// would add a second one.
    ///
    /// `None` as for [`round`](Self::round).
    /// ```
    /// use luenberger_proof::statement::Format;
    /// use luenberger_proof::{Exact, Ring};
    /// // Above a tie of binary32 by less than binary64 can say.
    /// let tie = Exact::power_of_two(0).add(&Exact::power_of_two(-24));
    /// let above = tie.add(&Exact::power_of_two(-80));
    /// assert_eq!(Format::Binary32.round_exact(&tie), Some(1.0));
    /// assert_eq!(Format::Binary32.round_exact(&above), Some(f64::from(1.0_f32.next_up())));
    /// assert_eq!(Format::Binary32.round(above.round_down()), Some(1.0));
    /// ```
    pub fn round_exact(self, x: &Exact) -> Option<f64> {
        self.check().ok()?;
        let Some(top) = x.magnitude_exponent() else { return Some(0.0) };
        // The spacing of the numbers of the format around x is 2^quantum.
        let quantum = match self {
            Self::Binary32 => (top - 23).max(-149),
            Self::Binary64 => (top - 52).max(-1074),
            Self::Fixed { fraction_bits, .. } => -i64::from(fraction_bits),
        };
        // Supported fixed-point formats end at 2^(quantum + 52); |x| is at least twice that.
        if top - quantum > 52 {
            return None;
        }
        let rounded = x.nearest_multiple(quantum) * power_of_two(quantum);
        let least = match self {
            Self::Fixed { integer_bits, .. } => -power_of_two(i64::from(integer_bits) - 1),
            _ => -self.largest(),
        };
        (least..=self.largest()).contains(&rounded).then_some(rounded)
    }

    /// The matrix with every entry rounded into the format, as the target stores it.
    /// # Errors
    /// [`ProofError::NotFinite`]; [`ProofError::OutOfRange`] for an entry beyond the range of the format;
    /// [`ProofError::Format`].
    pub fn stored(self, m: &Matrix<f64>, what: &'static str) -> Result<Matrix<f64>, ProofError> {
        self.check()?;
        let mut stored = m.clone();
        for row in 0..m.rows() {
            for column in 0..m.cols() {
                let value = m[(row, column)];
                if !value.is_finite() {
                    return Err(ProofError::NotFinite { what, row, column, value });
                }
                stored[(row, column)] = self.round(value).ok_or(ProofError::OutOfRange {
                    what,
                    row,
                    column,
                    value,
                    largest: self.largest(),
                })?;
            }
        }
        Ok(stored)
    }

    /// As [`stored`](Self::stored) for exact entries, each rounded once.
    /// # Errors
    /// [`ProofError::OutOfRange`] for an entry beyond the range of the format; [`ProofError::Format`].
    pub(super) fn stored_exact(self, m: &Matrix<Exact>, what: &'static str) -> Result<Matrix<f64>, ProofError> {
        self.check()?;
        let mut stored = m.map(|_| 0.0);
        for row in 0..m.rows() {
            for column in 0..m.cols() {
                let value = &m[(row, column)];
                stored[(row, column)] = self.round_exact(value).ok_or_else(|| ProofError::OutOfRange {
                    what,
                    row,
                    column,
                    value: value.round_up(),
                    largest: self.largest(),
                })?;
            }
        }
        Ok(stored)
    }

    /// Unit roundoff u of `fl(x op y) = (x op y)(1 + delta)`, `|delta| <= u`; 0 for fixed point.
    pub(super) fn unit(self) -> f64 {
        match self {
            Self::Binary32 => power_of_two(-24),
            Self::Binary64 => power_of_two(-53),
            Self::Fixed { .. } => 0.0,
        }
    }

    /// Absolute error in addition: in floating point the smallest normal number, for any operation whose result may be
    /// flushed to zero; in fixed point half the spacing, for a product.
    pub(super) fn absolute(self) -> f64 {
        match self {
            Self::Binary32 => power_of_two(-126),
            Self::Binary64 => power_of_two(-1022),
            Self::Fixed { fraction_bits, .. } => power_of_two(-i64::from(fraction_bits) - 1),
        }
    }

    /// `gamma_k = k u / (1 - k u)`: the bound of `|(1 + delta_1) ... (1 + delta_k) - 1|`.
    pub(super) fn gamma(self, k: usize) -> Interval {
        let share = Interval::of(k as f64).mul(&Interval::of(self.unit()));
        if share.hi() >= 0.5 {
            return Interval::UNBOUNDED;
        }
        share.quotient(&Interval::ONE.sub(&share)).unwrap_or(Interval::UNBOUNDED)
    }
}

impl fmt::Display for Format {
    /// `binary32`, `binary64`, or `Q4.12`, the 4 bits including the sign.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Binary32 => f.write_str("binary32"),
            Self::Binary64 => f.write_str("binary64"),
            Self::Fixed { integer_bits, fraction_bits } => write!(f, "Q{integer_bits}.{fraction_bits}"),
        }
    }
}

/// The formats of the stored matrices and of the computation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Formats {
    /// Format of the stored matrices.
    pub stored: Format,
    /// Format of the estimate, the measurement, the input, and the results of operations.
    pub running: Format,
}

impl From<Format> for Formats {
    fn from(format: Format) -> Self {
        Self { stored: format, running: format }
    }
}
