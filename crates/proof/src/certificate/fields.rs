//! The fields of a certificate, read from the tree; every error names line and path.

use super::error::{Fault, FileError};
use super::json::{Member, Node, Value};
use super::members::Members;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::number::{Datum, Number, decimal, quoted};

/// The largest order of a matrix in a file: what the checker proves in seconds.
pub const LARGEST_ORDER: usize = 512;

/// The most entries that matrices of which a file lists only those that are not 0 may have together, with the zeros.
pub const MOST_ENTRIES: usize = 1 << 20;

const QUOTED: &str = "a number in quotes, such as \"0x1.8p-3\" or \"42/85\"";

/// A value and its position.
#[derive(Debug, Clone)]
pub(super) struct Field<'a> {
    node: &'a Node,
    path: String,
}

/// An object whose members are taken one by one; what is left over at the end does not belong there.
#[derive(Debug)]
pub(super) struct Fields<'a> {
    line: usize,
    path: String,
    members: &'a [Member],
    taken: Vec<bool>,
}

impl<'a> Field<'a> {
    pub(super) fn root(node: &'a Node) -> Self {
        Self { node, path: String::new() }
    }

    pub(super) fn line(&self) -> usize {
        self.node.line
    }

    pub(super) fn error(&self, fault: Fault) -> FileError {
        FileError { line: self.node.line, path: self.path.clone(), fault }
    }

    fn wrong_type(&self, expected: &'static str) -> FileError {
        self.error(Fault::Type { expected, found: self.node.value.kind() })
    }

    fn fields(&self) -> Result<Fields<'a>, FileError> {
        match &self.node.value {
            Value::Object(members) => {
                Ok(Fields { line: self.node.line, path: self.path.clone(), members, taken: vec![false; members.len()] })
            }
            _ => Err(self.wrong_type("an object")),
        }
    }

    /// What `read` makes of the members of an object; an error for one that it leaves.
    pub(super) fn object<T>(&self, read: impl FnOnce(&mut Fields<'a>) -> Result<T, FileError>) -> Result<T, FileError> {
        let mut fields = self.fields()?;
        let value = read(&mut fields)?;
        fields.finish()?;
        Ok(value)
    }

    /// A member of an object that is read, for an error there.
    pub(super) fn member(&self, name: &'static str) -> Result<Self, FileError> {
        self.fields()?.take(name)
    }

    /// An object described by [`members!`](super::members).
    pub(super) fn part<T: Members>(&self) -> Result<T, FileError> {
        self.part_of(())
    }

    /// An object described by [`members!`](super::members), of sizes that other members have.
    pub(super) fn part_of<T: Members<Sizes>, Sizes>(&self, sizes: Sizes) -> Result<T, FileError> {
        self.object(|fields| T::read(fields, sizes))
    }

    /// What `read` makes of it.
    pub(super) fn by<T>(&self, read: impl FnOnce(&Self) -> Result<T, FileError>) -> Result<T, FileError> {
        read(self)
    }

    pub(super) fn text(&self) -> Result<&'a str, FileError> {
        match &self.node.value {
            Value::Text(text) => Ok(text),
            _ => Err(self.wrong_type("a string")),
        }
    }

    /// A name or a title: a line that is not empty.
    pub(super) fn name(&self) -> Result<String, FileError> {
        let text = self.text()?;
        if text.trim().is_empty() { Err(self.error(Fault::Empty)) } else { Ok(text.to_owned()) }
    }

    /// An index or a size, which JSON writes as it is.
    pub(super) fn count(&self) -> Result<usize, FileError> {
        match &self.node.value {
            Value::Number(text) => match text.parse::<u32>() {
                Ok(count) if !text.starts_with('+') => Ok(count as usize),
                _ => Err(self.error(Fault::Type { expected: "a whole number from 0", found: "another number" })),
            },
            _ => Err(self.wrong_type("a whole number")),
        }
    }

    /// An error when matrices given by their orders have too many entries together.
    pub(super) fn bounded_entries(&self, orders: impl Iterator<Item = usize>) -> Result<(), FileError> {
        let entries = orders.fold(0_usize, |sum, order| sum.saturating_add(order.saturating_mul(order)));
        if entries <= MOST_ENTRIES {
            return Ok(());
        }
        Err(self.error(Fault::TooManyEntries { entries, allowed: MOST_ENTRIES }))
    }

    /// As [`count`](Self::count), at most `limit`.
    pub(super) fn index(&self, limit: usize) -> Result<usize, FileError> {
        let found = self.count()?;
        if found <= limit { Ok(found) } else { Err(self.error(Fault::Index { found, limit })) }
    }

    pub(super) fn items(&self) -> Result<Vec<Field<'a>>, FileError> {
        match &self.node.value {
            Value::Array(items) => Ok(items.iter().enumerate().map(|(k, node)| self.item(k, node)).collect()),
            _ => Err(self.wrong_type("an array")),
        }
    }

    fn item(&self, k: usize, node: &'a Node) -> Field<'a> {
        Field { node, path: format!("{}[{k}]", self.path) }
    }

    /// An exact number.
    pub(super) fn exact(&self) -> Result<Number, FileError> {
        match &self.node.value {
            Value::Text(text) => text.parse().map_err(|error| self.error(Fault::Number(error))),
            // An integer only lacks its quotes.
            Value::Number(text) if text.parse::<Number>().is_err() => {
                Err(decimal(text).map_or_else(|| self.wrong_type(QUOTED), |error| self.error(Fault::Number(error))))
            }
            _ => Err(self.wrong_type(QUOTED)),
        }
    }

    /// A number that binary64 has.
    pub(super) fn binary64(&self) -> Result<f64, FileError> {
        let number = self.exact()?;
        number.to_f64().ok_or_else(|| self.not_exact(&number, "binary64 number"))
    }

    /// A binary64 number that satisfies the requirement.
    pub(super) fn number(
        &self,
        satisfies: impl FnOnce(f64) -> bool,
        requirement: &'static str,
    ) -> Result<f64, FileError> {
        let value = self.binary64()?;
        if satisfies(value) { Ok(value) } else { Err(self.error(Fault::Range { value, requirement })) }
    }

    pub(super) fn positive(&self, requirement: &'static str) -> Result<f64, FileError> {
        self.number(|x| x > 0.0, requirement)
    }

    /// 0 or more.
    pub(super) fn nonnegative(&self, requirement: &'static str) -> Result<f64, FileError> {
        self.number(|x| x >= 0.0, requirement)
    }

    pub(super) fn rate(&self) -> Result<f64, FileError> {
        self.nonnegative("a rate of decay is 0 or more")
    }

    /// The bound of an absolute value.
    pub(super) fn bound(&self) -> Result<f64, FileError> {
        self.nonnegative("a bound of an absolute value is 0 or more")
    }

    /// A list of this length.
    pub(super) fn list<T>(
        &self,
        length: usize,
        item: impl FnMut(&Self) -> Result<T, FileError>,
    ) -> Result<Vec<T>, FileError> {
        let items = self.items()?;
        if items.len() != length {
            return Err(self.error(Fault::Length { expected: length, found: items.len() }));
        }
        items.iter().map(item).collect()
    }

    /// A list of any length.
    pub(super) fn list_of<T>(&self, item: impl FnMut(&Self) -> Result<T, FileError>) -> Result<Vec<T>, FileError> {
        self.items()?.iter().map(item).collect()
    }

    /// A list of at least one.
    pub(super) fn some_of<T>(&self, item: impl FnMut(&Self) -> Result<T, FileError>) -> Result<Vec<T>, FileError> {
        let list = self.list_of(item)?;
        if list.is_empty() { Err(self.error(Fault::Empty)) } else { Ok(list) }
    }

    /// A list of numbers.
    pub(super) fn numbers(&self, length: usize) -> Result<Vec<f64>, FileError> {
        self.list(length, Field::binary64)
    }

    /// A list of bounds of absolute values.
    pub(super) fn bounds(&self, length: usize) -> Result<Vec<f64>, FileError> {
        self.list(length, Field::bound)
    }

    /// A word that stands for a value.
    pub(super) fn word<T: Copy>(&self, words: &[(&str, T)]) -> Result<T, FileError> {
        let found = self.text()?;
        match words.iter().find(|(word, _)| *word == found) {
            Some((_, value)) => Ok(*value),
            None => Err(self.unknown_word(found, words.iter().map(|(word, _)| *word))),
        }
    }

    pub(super) fn unknown_word<'w>(&self, found: &str, known: impl IntoIterator<Item = &'w str>) -> FileError {
        let known = known.into_iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ");
        self.error(Fault::Word { found: quoted(found), known })
    }

    /// An error for a matrix that is to be formed and has too many rows.
    pub(super) fn bounded_order(&self, order: usize, allowed: usize) -> Result<(), FileError> {
        if order <= allowed { Ok(()) } else { Err(self.error(Fault::TooManyRows { order, allowed })) }
    }

    pub(super) fn not_exact(&self, number: &Number, needed: &'static str) -> FileError {
        self.error(Fault::NotExact { number: quoted(&number.to_string()), needed })
    }

    /// A number, or the bounds of one.
    pub(super) fn datum(&self) -> Result<Datum, FileError> {
        let bounded = |number: Number| {
            if number.enclosure().is_bounded() {
                Ok(number)
            } else {
                let text = quoted(&number.to_string());
                Err(self.error(Fault::Number(crate::number::NumberError::Overflow { text })))
            }
        };
        if !matches!(self.node.value, Value::Array(_)) {
            return Ok(Datum::Number(bounded(self.exact()?)?));
        }
        match self.items()?.as_slice() {
            [lo, hi] => {
                let (lo, hi) = (bounded(lo.exact()?)?, bounded(hi.exact()?)?);
                if lo.enclosure().lo() > hi.enclosure().hi() {
                    return Err(self.error(Fault::Bounds { lo: Box::new(lo), hi: Box::new(hi) }));
                }
                Ok(Datum::Between(lo, hi))
            }
            others => Err(self.error(Fault::Length { expected: 2, found: others.len() })),
        }
    }

    fn rows<T>(&self, entry: impl Fn(&Field<'a>) -> Result<T, FileError>) -> Result<Matrix<T>, FileError> {
        let Value::Array(rows) = &self.node.value else { return Err(self.wrong_type("a matrix, an array of rows")) };
        let mut entries = Vec::new();
        let mut columns = None;
        for (i, node) in rows.iter().enumerate() {
            let row = self.item(i, node);
            let Value::Array(items) = &node.value else { return Err(row.wrong_type("a row of a matrix, an array")) };
            let expected = *columns.get_or_insert(items.len());
            if items.len() != expected {
                return Err(row.error(Fault::Ragged { expected, found: items.len() }));
            }
            let order = rows.len().max(expected);
            if order > LARGEST_ORDER {
                return Err(self.error(Fault::TooManyRows { order, allowed: LARGEST_ORDER }));
            }
            for (j, node) in items.iter().enumerate() {
                entries.push(entry(&row.item(j, node))?);
            }
        }
        Matrix::from_row_major(rows.len(), columns.unwrap_or(0), entries).map_err(|_| self.error(Fault::Empty))
    }

    pub(super) fn of_shape<T>(&self, m: Matrix<T>, expected: (usize, usize)) -> Result<Matrix<T>, FileError> {
        if m.shape() == expected {
            return Ok(m);
        }
        Err(self.error(Fault::Shape { expected, found: m.shape() }))
    }

    /// An error for a matrix of another shape.
    pub(super) fn same_shape<T>(&self, expected: &Matrix<T>, found: &Matrix<T>) -> Result<(), FileError> {
        let (expected, found) = (expected.shape(), found.shape());
        if expected == found { Ok(()) } else { Err(self.error(Fault::Shape { expected, found })) }
    }

    /// A matrix with at least one entry.
    fn not_empty<T>(&self, m: Matrix<T>) -> Result<Matrix<T>, FileError> {
        if m.as_slice().is_empty() { Err(self.error(Fault::Empty)) } else { Ok(m) }
    }

    fn squared<T>(&self, m: Matrix<T>) -> Result<Matrix<T>, FileError> {
        let rows = m.rows();
        self.of_shape(self.not_empty(m)?, (rows, rows))
    }

    fn with_columns<T>(&self, m: Matrix<T>, columns: usize) -> Result<Matrix<T>, FileError> {
        let rows = m.rows();
        self.of_shape(self.not_empty(m)?, (rows, columns))
    }

    fn with_rows<T>(&self, m: Matrix<T>, rows: usize) -> Result<Matrix<T>, FileError> {
        let columns = m.cols();
        self.of_shape(m, (rows, columns))
    }

    /// A matrix of binary64 numbers with at least one entry.
    pub(super) fn any_matrix(&self) -> Result<Matrix<f64>, FileError> {
        self.not_empty(self.rows(Field::binary64)?)
    }

    pub(super) fn matrix(&self, shape: (usize, usize)) -> Result<Matrix<f64>, FileError> {
        self.of_shape(self.rows(Field::binary64)?, shape)
    }

    /// A matrix with this many rows.
    pub(super) fn matrix_with_rows(&self, rows: usize) -> Result<Matrix<f64>, FileError> {
        self.with_rows(self.rows(Field::binary64)?, rows)
    }

    /// A matrix with this many rows, and one column at least.
    pub(super) fn columns(&self, rows: usize) -> Result<Matrix<f64>, FileError> {
        self.not_without_columns(self.matrix_with_rows(rows)?)
    }

    pub(super) fn not_without_columns<T>(&self, m: Matrix<T>) -> Result<Matrix<T>, FileError> {
        if m.cols() == 0 { Err(self.error(Fault::Empty)) } else { Ok(m) }
    }

    /// A matrix with this many columns, and one row at least.
    pub(super) fn matrix_with_columns(&self, columns: usize) -> Result<Matrix<f64>, FileError> {
        self.with_columns(self.rows(Field::binary64)?, columns)
    }

    /// A square matrix.
    pub(super) fn square(&self) -> Result<Matrix<f64>, FileError> {
        self.squared(self.rows(Field::binary64)?)
    }

    pub(super) fn symmetric(&self, order: usize) -> Result<Matrix<f64>, FileError> {
        let m = self.matrix((order, order))?;
        self.must_mirror(&m, |x| Number::from_f64(*x).map_or_else(String::new, |x| x.to_string()))?;
        Ok(m)
    }

    fn must_mirror<T: PartialEq>(&self, m: &Matrix<T>, show: impl Fn(&T) -> String) -> Result<(), FileError> {
        for i in 0..m.rows() {
            for j in 0..i {
                let (lower, upper) = (&m[(i, j)], &m[(j, i)]);
                if lower != upper {
                    let Value::Array(rows) = &self.node.value else { continue };
                    let row =
                        Field { node: rows.get(i).unwrap_or(self.node), path: format!("{}[{i}][{j}]", self.path) };
                    return Err(row.error(Fault::NotSymmetric { lower: show(lower), upper: show(upper) }));
                }
            }
        }
        Ok(())
    }

    /// A symmetric matrix of numbers or bounds, of any order from 1.
    pub(super) fn symmetric_data(&self) -> Result<Matrix<Datum>, FileError> {
        let m = self.square_data()?;
        self.must_mirror(&m, |datum| match datum {
            Datum::Number(x) => x.to_string(),
            Datum::Between(lo, hi) => format!("[{lo}, {hi}]"),
        })?;
        Ok(m)
    }

    /// As [`symmetric_data`](Self::symmetric_data), of this order.
    pub(super) fn symmetric_data_of(&self, order: usize) -> Result<Matrix<Datum>, FileError> {
        self.of_shape(self.symmetric_data()?, (order, order))
    }

    /// An interval whose ends are numbers that binary64 has: a claim, which must not be widened on reading.
    pub(super) fn interval(&self) -> Result<Interval, FileError> {
        let end = |number: &Number| number.to_f64().ok_or_else(|| self.not_exact(number, "binary64 number"));
        let (lo, hi) = match self.datum()? {
            Datum::Number(x) => (end(&x)?, end(&x)?),
            Datum::Between(lo, hi) => (end(&lo)?, end(&hi)?),
        };
        Interval::new(lo, hi).ok_or_else(|| self.error(Fault::Empty))
    }

    /// A symmetric matrix of intervals with ends in binary64.
    pub(super) fn symmetric_intervals(&self, order: usize) -> Result<Matrix<Interval>, FileError> {
        let m = self.of_shape(self.rows(Field::interval)?, (order, order))?;
        self.must_mirror(&m, |x| format!("[{:e}, {:e}]", x.lo(), x.hi()))?;
        Ok(m)
    }

    /// A matrix of intervals with ends in binary64.
    pub(super) fn matrix_of_intervals(&self, shape: (usize, usize)) -> Result<Matrix<Interval>, FileError> {
        self.of_shape(self.rows(Field::interval)?, shape)
    }

    /// A square matrix of numbers or bounds.
    pub(super) fn square_data(&self) -> Result<Matrix<Datum>, FileError> {
        self.squared(self.rows(Field::datum)?)
    }

    /// As [`square_data`](Self::square_data), of this order if there is one.
    pub(super) fn square_data_of(&self, order: Option<usize>) -> Result<Matrix<Datum>, FileError> {
        let m = self.square_data()?;
        let order = order.unwrap_or(m.rows());
        self.of_shape(m, (order, order))
    }

    pub(super) fn data(&self, shape: (usize, usize)) -> Result<Matrix<Datum>, FileError> {
        self.of_shape(self.data_with_columns(shape.1)?, shape)
    }

    /// A matrix of numbers or bounds with this many columns, and one row at least.
    pub(super) fn data_with_columns(&self, columns: usize) -> Result<Matrix<Datum>, FileError> {
        self.with_columns(self.rows(Field::datum)?, columns)
    }

    /// A matrix of numbers or bounds with this many rows, perhaps without columns.
    pub(super) fn data_with_rows(&self, rows: usize) -> Result<Matrix<Datum>, FileError> {
        self.with_rows(self.rows(Field::datum)?, rows)
    }

    /// A symmetric matrix of exact numbers.
    pub(super) fn symmetric_exact(&self, order: usize) -> Result<Matrix<Number>, FileError> {
        let m = self.of_shape(self.rows(Field::exact)?, (order, order))?;
        self.must_mirror(&m, |x| quoted(&x.to_string()))?;
        Ok(m)
    }
}

impl<'a> Fields<'a> {
    pub(super) fn optional(&mut self, name: &'static str) -> Option<Field<'a>> {
        let k = self.members.iter().position(|member| *member.name == *name)?;
        if let Some(taken) = self.taken.get_mut(k) {
            *taken = true;
        }
        let path = if self.path.is_empty() { name.to_owned() } else { format!("{}.{name}", self.path) };
        self.members.get(k).map(|member| Field { node: &member.node, path })
    }

    pub(super) fn take(&mut self, name: &'static str) -> Result<Field<'a>, FileError> {
        let missing = FileError { line: self.line, path: self.path.clone(), fault: Fault::Missing { name } };
        self.optional(name).ok_or(missing)
    }

    pub(super) fn object<T>(
        &mut self,
        name: &'static str,
        read: impl FnOnce(&mut Fields<'a>) -> Result<T, FileError>,
    ) -> Result<T, FileError> {
        self.take(name)?.object(read)
    }

    /// An error for the first unknown member.
    fn finish(self) -> Result<(), FileError> {
        for (member, taken) in self.members.iter().zip(&self.taken) {
            if !taken {
                let fault = Fault::Unknown { name: quoted(&member.name) };
                return Err(FileError { line: member.node.line, path: self.path, fault });
            }
        }
        Ok(())
    }
}
