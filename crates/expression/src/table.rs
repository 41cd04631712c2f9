//! Lookup tables: a function of one variable through given points.
//!
//! Between the points x_1 < .. < x_n it is linear, or the cubic Hermite polynomial with the slopes of Fritsch and
//! Carlson (PCHIP), which is continuously differentiable and monotone wherever the points are. Before the first point
//! and after the last it holds their values, or goes on along the slope there.
//!
//! Evaluated over any scalar: the piece is found by comparisons, and the two pieces at a point have the same value
//! there in real arithmetic, so that an enclosure over a box sees a kink and never a jump.
//!
//! Source: F. N. Fritsch and R. E. Carlson, Monotone piecewise cubic interpolation, SIAM J. Numer. Anal. 17, 1980; the
//! slopes at the ends are those of scipy's `PchipInterpolator` and MATLAB's `pchip` (C. Moler, Numerical Computing with
//! MATLAB, 2004, ch. 3.6).

use nalgebra::{RealField, convert};

/// The interpolation between the points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight lines.
    #[default]
    Linear,
    /// Cubic polynomials that are monotone where the points are (PCHIP).
    MonotoneCubic,
}

/// The values outside of the points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extrapolation {
    /// Those of the first and the last point.
    #[default]
    Hold,
    /// Straight lines along the slopes at the first and the last point.
    Linear,
}

/// Why points do not make a table.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// Fewer than two points.
    #[error("a table needs two points or more: it has {points}")]
    TooFew {
        /// How many there are.
        points: usize,
    },
    /// Different numbers of x and y.
    #[error("x has {x} entries, and y has {y}")]
    Length {
        /// The number of x.
        x: usize,
        /// The number of y.
        y: usize,
    },
    /// A number that is NaN or infinite.
    #[error("entry {} of {what} is {value}, not a finite number", index + 1)]
    NotFinite {
        /// x or y.
        what: &'static str,
        /// Which entry, from 0.
        index: usize,
        /// The entry.
        value: f64,
    },
    /// An x that is not larger than its predecessor.
    #[error("x must increase: entry {} is {value}, after {before}", index + 1)]
    NotIncreasing {
        /// Which entry, from 0.
        index: usize,
        /// The entry.
        value: f64,
        /// Its predecessor.
        before: f64,
    },
    /// Points whose slopes are not finite numbers.
    #[error("the slope from x = {from} to {to} is not a finite number")]
    Slope {
        /// Where the interval begins.
        from: f64,
        /// Where it ends.
        to: f64,
    },
    /// Another number of rows of a table of two variables than of x.
    #[error("x has {x} entries, and z has {z} rows")]
    Rows {
        /// The number of x.
        x: usize,
        /// The number of rows of z.
        z: usize,
    },
    /// A row of a table of two variables with another number of entries than y.
    #[error("y has {y} entries, and row {} of z has {entries}", row + 1)]
    Row {
        /// Which row, from 0.
        row: usize,
        /// The number of y.
        y: usize,
        /// The number of its entries.
        entries: usize,
    },
    /// A value of a table of two variables that is NaN or infinite.
    #[error("entry {} of row {} of z is {value}, not a finite number", column + 1, row + 1)]
    Value {
        /// Which row, from 0.
        row: usize,
        /// Which entry of it, from 0.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// The axis y of a table of two variables, or values along it.
    #[error("along y: {0}")]
    AlongY(Box<TableError>),
}

impl TableError {
    /// Of the axis y of a table of two variables.
    pub(crate) fn of_y(self) -> Self {
        Self::AlongY(Box::new(self))
    }
}

/// A lookup table; see the head of this module.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    x: Vec<f64>,
    y: Vec<f64>,
    /// The slopes at the points, of a monotone cubic.
    slopes: Option<Vec<f64>>,
    extrapolation: Extrapolation,
}

impl Table {
    /// The table through the points (x_k, y_k), x increasing.
    ///
    /// ```
    /// use luenberger_expression::{Extrapolation, Interpolation, Table};
    /// let table = Table::new(&[0.0, 1.0, 3.0], &[2.0, 4.0, 0.0], Interpolation::Linear, Extrapolation::Hold)?;
    /// assert_eq!([-1.0, 0.5, 2.0, 9.0].map(|x| table.at(x)), [2.0, 3.0, 2.0, 0.0]);
    /// # Ok::<(), luenberger_expression::TableError>(())
    /// ```
    /// # Errors
    /// [`TableError`].
    pub fn new(
        x: &[f64],
        y: &[f64],
        interpolation: Interpolation,
        extrapolation: Extrapolation,
    ) -> Result<Self, TableError> {
        if x.len() != y.len() {
            return Err(TableError::Length { x: x.len(), y: y.len() });
        }
        if x.len() < 2 {
            return Err(TableError::TooFew { points: x.len() });
        }
        for (what, list) in [("x", x), ("y", y)] {
            if let Some(index) = list.iter().position(|entry| !entry.is_finite()) {
                return Err(TableError::NotFinite { what, index, value: list[index] });
            }
        }
        if let Some(k) = x.windows(2).position(|pair| pair[0] >= pair[1]) {
            return Err(TableError::NotIncreasing { index: k + 1, value: x[k + 1], before: x[k] });
        }
        let secants: Vec<f64> = x.windows(2).zip(y.windows(2)).map(|(x, y)| (y[1] - y[0]) / (x[1] - x[0])).collect();
        if let Some(k) = secants.iter().position(|slope| !slope.is_finite()) {
            return Err(TableError::Slope { from: x[k], to: x[k + 1] });
        }
        let slopes = match interpolation {
            Interpolation::Linear => None,
            Interpolation::MonotoneCubic => Some(monotone_slopes(x, &secants)),
        };
        Ok(Self { x: x.to_vec(), y: y.to_vec(), slopes, extrapolation })
    }

    /// x, y and the slopes at the points of a monotone cubic.
    pub fn points(&self) -> (&[f64], &[f64], Option<&[f64]>) {
        (&self.x, &self.y, self.slopes.as_deref())
    }

    /// Its values outside of the points.
    pub fn extrapolation(&self) -> Extrapolation {
        self.extrapolation
    }

    /// Its value over any scalar.
    pub fn at<T: RealField + Copy>(&self, x: T) -> T {
        let last = self.x.len() - 1;
        let number = |value: f64| convert::<f64, T>(value);
        if x < number(self.x[0]) {
            return self.outside(x, 0);
        }
        if x > number(self.x[last]) {
            return self.outside(x, last);
        }
        let k = self.piece(x);
        let (from, to) = (number(self.x[k]), number(self.x[k + 1]));
        let (low, high) = (number(self.y[k]), number(self.y[k + 1]));
        let (width, share) = (to - from, (x - from) / (to - from));
        let Some(slopes) = &self.slopes else { return low + (high - low) * share };
        let (first, second) = (number(slopes[k]) * width, number(slopes[k + 1]) * width);
        // Hermite's polynomial in Bernstein's form, whose coefficients bound it over the whole piece.
        let third: T = convert(3.0);
        let rest = T::one() - share;
        low * rest * rest * rest
            + (low * third + first) * rest * rest * share
            + (high * third - second) * rest * share * share
            + high * share * share * share
    }

    /// The piece k from x_k to x_(k+1).
    fn piece<T: RealField + Copy>(&self, x: T) -> usize {
        let (mut k, mut end) = (0, self.x.len() - 1);
        while end - k > 1 {
            let middle = usize::midpoint(k, end);
            if x < convert::<f64, T>(self.x[middle]) { end = middle } else { k = middle }
        }
        k
    }

    /// Its derivative over any scalar; at a point that of the piece after it.
    pub(crate) fn slope<T: RealField + Copy>(&self, x: T) -> T {
        let last = self.x.len() - 1;
        let number = |value: f64| convert::<f64, T>(value);
        if x < number(self.x[0]) {
            return self.outer_slope(0);
        }
        if x > number(self.x[last]) {
            return self.outer_slope(last);
        }
        let k = self.piece(x);
        let (from, to) = (number(self.x[k]), number(self.x[k + 1]));
        let (low, high) = (number(self.y[k]), number(self.y[k + 1]));
        let secant = (high - low) / (to - from);
        let Some(slopes) = &self.slopes else { return secant };
        let share = (x - from) / (to - from);
        let (first, second, six) = (number(slopes[k]), number(slopes[k + 1]), number(6.0));
        let rest = T::one() - share;
        let middle = six * secant - (first + first) - (second + second);
        first * rest * rest + middle * rest * share + second * share * share
    }

    /// The slope beyond the first point or the last.
    fn outer_slope<T: RealField + Copy>(&self, end: usize) -> T {
        let number = |value: f64| convert::<f64, T>(value);
        let k = end.min(self.x.len() - 2);
        match (self.extrapolation, &self.slopes) {
            (Extrapolation::Hold, _) => T::zero(),
            (Extrapolation::Linear, Some(slopes)) => number(slopes[end]),
            (Extrapolation::Linear, None) => {
                (number(self.y[k + 1]) - number(self.y[k])) / (number(self.x[k + 1]) - number(self.x[k]))
            }
        }
    }

    /// Beyond the first point or the last.
    fn outside<T: RealField + Copy>(&self, x: T, end: usize) -> T {
        let y: T = convert(self.y[end]);
        match self.extrapolation {
            Extrapolation::Hold => y,
            Extrapolation::Linear => y + self.outer_slope::<T>(end) * (x - convert::<f64, T>(self.x[end])),
        }
    }
}

/// The slopes of Fritsch and Carlson at the points.
fn monotone_slopes(x: &[f64], secants: &[f64]) -> Vec<f64> {
    let widths: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let [only] = secants else {
        let last = secants.len() - 1;
        let mut slopes = vec![end_slope((widths[0], widths[1]), (secants[0], secants[1]))];
        for k in 1..secants.len() {
            let (before, after) = (secants[k - 1], secants[k]);
            slopes.push(if before != 0.0 && after != 0.0 && (before > 0.0) == (after > 0.0) {
                let (w1, w2) = (2.0 * widths[k] + widths[k - 1], widths[k] + 2.0 * widths[k - 1]);
                (w1 + w2) / (w1 / before + w2 / after)
            } else {
                0.0
            });
        }
        slopes.push(end_slope((widths[last], widths[last - 1]), (secants[last], secants[last - 1])));
        return slopes;
    };
    vec![*only; 2]
}

/// The slope of a parabola through three points at the first, limited so that the piece stays monotone.
fn end_slope((near, far): (f64, f64), (first, second): (f64, f64)) -> f64 {
    let slope = ((2.0 * near + far) * first - near * second) / (near + far);
    if slope * first <= 0.0 {
        0.0
    } else if first * second < 0.0 && slope.abs() > 3.0 * first.abs() {
        3.0 * first
    } else {
        slope
    }
}
