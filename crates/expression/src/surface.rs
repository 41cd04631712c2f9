//! Lookup tables of two variables.
//!
//! Through values z_ij at the nodes (x_i, y_j) of a grid, bilinear between them: for x between x_i and x_(i+1)
//!
//! `z(x, y) = r_i(y) + (x - x_i)/(x_(i+1) - x_i) (r_(i+1)(y) - r_i(y))`
//!
//! with the linear tables r_i of the rows, which are [`Table`]s. The piece is found by comparisons, and two pieces meet
//! at x_i in real arithmetic: an enclosure over a box sees a kink and never a jump. In the graph of a plant the pieces
//! are choices, of which all are computed.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{RealField, convert};

use crate::function::saturate;
use crate::table::{Extrapolation, Interpolation, Table, TableError};

/// A lookup table of two variables; see the head of this module.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    x: Vec<f64>,
    rows: Vec<Arc<Table>>,
}

impl Surface {
    /// The table with the values `z[i][j]` at (x_i, y_j), x and y increasing.
    ///
    /// ```
    /// use luenberger_expression::{Extrapolation, Surface};
    /// let z = [vec![0.0, 10.0], vec![4.0, 10.0], vec![4.0, 20.0]];
    /// let map = Surface::new(&[0.0, 1.0, 3.0], &[0.0, 2.0], &z, Extrapolation::Hold)?;
    /// assert_eq!([(0.5, 0.0), (0.0, 1.0), (2.0, 1.0), (9.0, 9.0)].map(|(x, y)| map.at(x, y)), [2.0, 5.0, 9.5, 20.0]);
    /// # Ok::<(), luenberger_expression::TableError>(())
    /// ```
    /// # Errors
    /// [`TableError`].
    pub fn new(x: &[f64], y: &[f64], z: &[Vec<f64>], extrapolation: Extrapolation) -> Result<Self, TableError> {
        // The shape of the grid and its axes first.
        Table::new(x, &vec![0.0; x.len()], Interpolation::Linear, extrapolation)?;
        if z.len() != x.len() {
            return Err(TableError::Rows { x: x.len(), z: z.len() });
        }
        if let Some(row) = z.iter().position(|row| row.len() != y.len()) {
            return Err(TableError::Row { row, y: y.len(), entries: z[row].len() });
        }
        for (row, values) in z.iter().enumerate() {
            if let Some(column) = values.iter().position(|value| !value.is_finite()) {
                return Err(TableError::Value { row, column, value: values[column] });
            }
        }
        let line = |y: &[f64], z: &[f64]| Table::new(y, z, Interpolation::Linear, extrapolation).map(Arc::new);
        line(y, &vec![0.0; y.len()]).map_err(TableError::of_y)?;
        let rows = z.iter().map(|row| line(y, row).map_err(TableError::of_y)).collect::<Result<_, _>>()?;
        Ok(Self { x: x.to_vec(), rows })
    }

    /// x, y and z.
    pub fn points(&self) -> (&[f64], &[f64], Vec<&[f64]>) {
        (&self.x, self.rows[0].points().0, self.rows.iter().map(|row| row.points().1).collect())
    }

    /// Its values outside of the grid.
    pub fn extrapolation(&self) -> Extrapolation {
        self.rows[0].extrapolation()
    }

    /// Its value over any scalar.
    pub fn at<T: RealField + Copy>(&self, x: T, y: T) -> T {
        let x = match self.held() {
            Some([low, high]) => saturate(x, convert(low), convert(high)),
            None => x,
        };
        let last = self.x.len() - 2;
        let k = (0..last).find(|k| x < convert(self.x[k + 1])).unwrap_or(last);
        let [from, to] = [k, k + 1].map(|k| convert::<f64, T>(self.x[k]));
        let [low, high] = [k, k + 1].map(|k| self.rows[k].at(y));
        low + (x - from) / (to - from) * (high - low)
    }

    /// The ends of x, if the values there are held outside.
    pub(crate) fn held(&self) -> Option<[f64; 2]> {
        (self.extrapolation() == Extrapolation::Hold).then(|| [self.x[0], self.x[self.x.len() - 1]])
    }

    /// Each x_i with r_i.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (f64, &Arc<Table>)> {
        self.x.iter().copied().zip(&self.rows)
    }
}

/// A lookup table as a function of expressions.
#[derive(Clone, Debug, PartialEq)]
pub enum LookupTable {
    /// Of one variable.
    Curve(Arc<Table>),
    /// Of two variables.
    Surface(Arc<Surface>),
}

impl LookupTable {
    /// The number of its arguments.
    pub fn arguments(&self) -> usize {
        match self {
            Self::Curve(_) => 1,
            Self::Surface(_) => 2,
        }
    }
}

impl From<Table> for LookupTable {
    fn from(table: Table) -> Self {
        Self::Curve(Arc::new(table))
    }
}

impl From<Surface> for LookupTable {
    fn from(surface: Surface) -> Self {
        Self::Surface(Arc::new(surface))
    }
}

/// Named lookup tables.
pub type Tables = BTreeMap<String, LookupTable>;
