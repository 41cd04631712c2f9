//! Columns of numbers, written as CSV with the shortest exact decimals, and as npz in binary form.

use std::io::{Seek, Write};

use crate::npz;

/// Named columns of equal length.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    columns: Vec<(String, Vec<f64>)>,
    /// For each column whether values may be missing, which are NaN in it.
    partial: Vec<bool>,
}

/// A table that cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// A column differs from the first in length.
    #[error("column {name:?} has {found} rows, and {first:?} has {expected}")]
    Length {
        /// The column.
        name: String,
        /// Its rows.
        found: usize,
        /// The first column.
        first: String,
        /// Its rows.
        expected: usize,
    },
    /// There is no column, or no row.
    #[error("the table is empty")]
    Empty,
    /// Two columns have one name.
    #[error("two columns are named {name:?}")]
    Duplicate {
        /// The name.
        name: String,
    },
    /// An entry is not finite.
    #[error("column {name:?}, row {row}: {value} is not a finite number")]
    NotFinite {
        /// The column.
        name: String,
        /// The row, counted from 1 below the header.
        row: usize,
        /// The entry.
        value: f64,
    },
    /// Writing failed.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// Writing failed.
    #[error(transparent)]
    Zip(#[from] zip::result::ZipError),
    /// Writing failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

impl Table {
    /// A table without columns.
    pub fn new() -> Self {
        Self::default()
    }

    /// The same table with one more column.
    #[must_use]
    pub fn column(mut self, name: impl Into<String>, values: impl Into<Vec<f64>>) -> Self {
        self.columns.push((name.into(), values.into()));
        self.partial.push(false);
        self
    }

    /// As [`column`](Self::column), with values that are missing: an empty cell in CSV, NaN in npz.
    ///
    /// ```
    /// use luenberger_figures::Table;
    /// let table = Table::new().column("t", [0.0, 1.0]).column_with_missing("y", [Some(3.0), None]);
    /// let mut text = Vec::new();
    /// table.write_csv(&mut text)?;
    /// assert_eq!(text, b"t,y\n0.0,3.0\n1.0,\n");
    /// # Ok::<(), luenberger_figures::table::TableError>(())
    /// ```
    #[must_use]
    pub fn column_with_missing(
        mut self,
        name: impl Into<String>,
        values: impl IntoIterator<Item = Option<f64>>,
    ) -> Self {
        self.columns.push((name.into(), values.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect()));
        self.partial.push(true);
        self
    }

    /// The columns with their names; a missing value is NaN.
    pub fn columns(&self) -> &[(String, Vec<f64>)] {
        &self.columns
    }

    /// Writes the header and the rows as CSV. Numbers are written in the shortest form that reads back as the same
    /// number.
    /// # Errors
    /// [`TableError`]: columns that differ in length or share a name, an empty table, an entry that is not finite, I/O.
    pub fn write_csv(&self, to: impl Write) -> Result<(), TableError> {
        let rows = self.check()?;
        let mut writer = csv::Writer::from_writer(to);
        writer.write_record(self.columns.iter().map(|(name, _)| name))?;
        let mut cell = String::new();
        for row in 0..rows {
            for (_, values) in &self.columns {
                cell.clear();
                // `{:?}` of an f64 is the shortest decimal that reads back as the same number.
                if !values[row].is_nan() {
                    _ = std::fmt::Write::write_fmt(&mut cell, format_args!("{:?}", values[row]));
                }
                writer.write_field(&cell)?;
            }
            writer.write_record(None::<&[u8]>)?;
        }
        writer.flush()?;
        Ok(())
    }

    /// Writes each column as a one-dimensional array of float64 under its name, as `numpy.savez` does: an uncompressed
    /// zip archive of `NAME.npy`, without times, so that the same table gives the same bytes. In Python,
    /// `numpy.load("run.npz")["t"]`.
    ///
    /// ```
    /// use luenberger_figures::Table;
    /// let table = Table::new().column("t", [0.0, 0.1]).column("x1", [1.0, 0.9]);
    /// let mut file = std::io::Cursor::new(Vec::new());
    /// table.write_npz(&mut file)?;
    /// assert!(file.into_inner().starts_with(b"PK"));
    /// # Ok::<(), luenberger_figures::table::TableError>(())
    /// ```
    /// # Errors
    /// As [`write_csv`](Self::write_csv).
    pub fn write_npz(&self, to: impl Write + Seek) -> Result<(), TableError> {
        self.check()?;
        let arrays = self.columns.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
        Ok(npz::write(to, arrays, &[])?)
    }

    /// The number of rows; an error if the table cannot be written.
    fn check(&self) -> Result<usize, TableError> {
        let Some((first, rows)) = self.columns.first() else { return Err(TableError::Empty) };
        if rows.is_empty() {
            return Err(TableError::Empty);
        }
        for (i, (name, values)) in self.columns.iter().enumerate() {
            if values.len() != rows.len() {
                return Err(TableError::Length {
                    name: name.clone(),
                    found: values.len(),
                    first: first.clone(),
                    expected: rows.len(),
                });
            }
            if self.columns[..i].iter().any(|(other, _)| other == name) {
                return Err(TableError::Duplicate { name: name.clone() });
            }
            let wrong = |x: &f64| !(x.is_finite() || self.partial[i] && x.is_nan());
            if let Some(row) = values.iter().position(wrong) {
                return Err(TableError::NotFinite { name: name.clone(), row: row + 1, value: values[row] });
            }
        }
        Ok(rows.len())
    }
}
