//! Parts of a study that are read: keys with their values, and the mistakes in them. What the kinds of observers read
//! their keys with.

pub(crate) mod check;
pub(crate) mod disturbance;
pub(crate) mod gain;
pub(crate) mod maps;
pub(crate) mod region;
pub(crate) mod tree;

use std::ops::Range;

use luenberger_expression::{Expression, ExpressionError, Scope, nearest};
use luenberger_plants::Dimensions;
use luenberger_proof::wording::counted;
use nalgebra::DMatrix;

use crate::diagnostic::Diagnostic;
use crate::digest::{self, FileDigest};
use crate::model::PlantModel;
use crate::study::{DataFiles, OtherPlant};
use tree::Node;

/// An `[[observer]]` that is read.
#[derive(Debug, Clone, Copy)]
pub struct Given<'a> {
    /// Its table.
    pub(crate) node: &'a Node,
    /// The plant.
    pub(crate) plant: &'a PlantModel,
    /// Its name.
    pub(crate) name: &'a str,
    /// The study.
    pub(crate) root: &'a Node,
    /// Reads a model of the plant.
    pub(crate) models: ModelReader,
}

/// Marker of a mistake that is recorded already.
pub(crate) struct Reported;

/// Reads from the root of a study and a table a model of the plant with what the table says of it; none if it says
/// nothing.
pub(crate) type ModelReader = fn(&Node, &Node, &PlantModel, &mut Reader) -> Result<Option<OtherPlant>, Reported>;

impl Given<'_> {
    /// The sizes of the plant.
    pub fn size(&self) -> Dimensions {
        self.plant.model.size()
    }

    /// The plant with what a table says of it, as [`ModelReader`].
    pub(crate) fn model_of(&self, change: &Node, reader: &mut Reader) -> Result<Option<OtherPlant>, Reported> {
        (self.models)(self.root, change, self.plant, reader)
    }
}

/// Collects the mistakes of the third pass, and resolves file names.
#[derive(Debug)]
pub struct Reader {
    pub(crate) mistakes: Vec<Diagnostic>,
    /// Mistakes about missing keys.
    pub(crate) absences: Vec<Diagnostic>,
    pub(crate) data: DataFiles,
    /// The files that were read.
    pub(crate) files: Vec<FileDigest>,
    /// The period of a plant in discrete time.
    pub(crate) dt: Option<f64>,
    /// Whether the kind of observer that is read is for the time of the plant; if not, its design says so.
    pub(crate) fits_time: bool,
}

impl Reader {
    pub(crate) fn new(data: &DataFiles) -> Self {
        let (mistakes, absences) = (Vec::new(), Vec::new());
        Self { mistakes, absences, data: data.clone(), files: Vec::new(), dt: None, fits_time: true }
    }

    /// A reader of a part of the same study.
    pub(crate) fn inner(&self) -> Self {
        Self { dt: self.dt, ..Self::new(&self.data) }
    }

    /// The content of a file that the study names.
    pub(crate) fn file(&mut self, name: &str) -> std::io::Result<Vec<u8>> {
        let bytes = self.data.read(name)?;
        let read = FileDigest { name: name.to_owned(), sha256: digest::sha256(&bytes) };
        if !self.files.contains(&read) {
            self.files.push(read);
        }
        Ok(bytes)
    }

    pub(crate) fn wrong(&mut self, span: Range<usize>, message: impl Into<String>, expected: impl Into<String>) {
        self.mistakes.push(Diagnostic::new(span, message, expected));
    }

    /// [`wrong`](Self::wrong), and none of what should have been read.
    pub(crate) fn refuse<T>(
        &mut self,
        span: Range<usize>,
        message: impl Into<String>,
        expected: impl Into<String>,
    ) -> Option<T> {
        self.wrong(span, message, expected);
        None
    }

    pub(crate) fn absent(&mut self, span: Range<usize>, message: impl Into<String>, expected: impl Into<String>) {
        self.absences.push(Diagnostic::new(span, message, expected));
    }

    /// A list of numbers of the given length.
    pub(crate) fn numbers(&mut self, node: &Node, name: &str, length: usize, of: &str) -> Option<Vec<f64>> {
        let numbers = node.numbers()?;
        if numbers.len() != length {
            let message = format!("`{name}` has length {}, and the plant has {}", numbers.len(), counted(length, of));
            return self.refuse(node.span.clone(), message, format!("expected length {length}"));
        }
        Some(numbers)
    }

    /// A matrix; a dimension given as `None` is arbitrary.
    pub(crate) fn matrix(
        &mut self,
        node: &Node,
        name: &str,
        (rows, columns): (Option<usize>, Option<usize>),
        why: &str,
    ) -> Option<DMatrix<f64>> {
        let matrix = rows_of(node)?;
        let fits = rows.is_none_or(|rows| rows == matrix.nrows()) && columns.is_none_or(|c| c == matrix.ncols());
        if !fits {
            let size = |size: Option<usize>, found: usize| size.unwrap_or(found).to_string();
            let message = format!("`{name}` is {} x {}", matrix.nrows(), matrix.ncols());
            let expected =
                format!("expected {} x {}: {why}", size(rows, matrix.nrows()), size(columns, matrix.ncols()));
            return self.refuse(node.span.clone(), message, expected);
        }
        Some(matrix)
    }

    /// A weight of the given order: a number, a diagonal or a matrix.
    pub(crate) fn weight(&mut self, node: &Node, name: &str, order: usize, why: &str) -> Option<DMatrix<f64>> {
        if let Some(x) = node.number() {
            return Some(DMatrix::identity(order, order) * x);
        }
        match node.numbers() {
            Some(diagonal) if diagonal.len() == order => Some(DMatrix::from_diagonal(&diagonal.into())),
            Some(diagonal) => {
                let message = format!("the diagonal `{name}` has length {}", diagonal.len());
                self.refuse(node.span.clone(), message, format!("expected length {order}: {why}"))
            }
            None => self.matrix(node, name, (Some(order), Some(order)), why),
        }
    }

    /// The index of a name among the known ones.
    pub(crate) fn position(&mut self, node: &Node, what: &str, known: &[String]) -> Option<usize> {
        let name = node.text()?;
        let found = known.iter().position(|known| known == name);
        if found.is_none() {
            let expected = if known.is_empty() {
                format!("expected the name of {what}, of which the study has none")
            } else {
                format!("expected one of {}", known.join(", "))
            };
            let mut mistake =
                Diagnostic::new(node.span.clone(), format!("there is no {what} named {name:?}"), expected);
            if let Some(near) = nearest(name, known.iter().map(String::as_str)) {
                mistake = mistake.help(format!("the nearest is {near:?}"));
            }
            self.mistakes.push(mistake);
        }
        found
    }
}

/// A matrix from its rows; none if the rows have mistakes, which are reported already.
pub(crate) fn rows_of(node: &Node) -> Option<DMatrix<f64>> {
    let rows: Vec<Vec<f64>> = node.list()?.iter().map(Node::numbers).collect::<Option<_>>()?;
    let columns = rows.first()?.len();
    if columns == 0 || rows.iter().any(|row| row.len() != columns) {
        return None;
    }
    Some(DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j]))
}

/// The expression of a text, or the constant of a number.
pub(crate) fn expression(node: &Node, scope: &Scope, reader: &mut Reader) -> Option<Expression> {
    let text = match node.text() {
        Some(text) => text.to_owned(),
        None => format!("{:?}", node.number()?),
    };
    let parsed = Expression::parse(&text, scope);
    parsed.map_err(|error| unreadable(node, &error, "this expression cannot be read", reader)).ok()
}

/// The difference that is not positive where the inequality of a text holds.
pub(crate) fn inequality(node: &Node, scope: &Scope, reader: &mut Reader) -> Option<Expression> {
    let parsed = Expression::parse_inequality(node.text()?, scope);
    parsed.map_err(|error| unreadable(node, &error, "this inequality cannot be read", reader)).ok()
}

fn unreadable(node: &Node, error: &ExpressionError, what: &str, reader: &mut Reader) {
    reader.mistakes.push(Diagnostic::new(within(node, error), error.kind().to_string(), what));
}

/// The span in the file of an error within a string; the whole string if escapes or line breaks make the position
/// ambiguous.
pub(crate) fn within(node: &Node, error: &ExpressionError) -> Range<usize> {
    let quotes = node.span.len().saturating_sub(error.text().len());
    if quotes == 2 {
        let start = node.span.start + 1;
        return start + error.span().start..start + error.span().end;
    }
    node.span.clone()
}
