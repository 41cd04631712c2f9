//! MATLAB's files of version 4, which `save` writes with `-v4`: matrices one after the other, without a header of the
//! file.
//!
//! A matrix has five integers of 4 bytes (type, rows, columns, whether it is complex, length of the name with its final
//! zero), the name, the real parts by columns, and the imaginary parts. The decimal digits `MOPT` of the type say the
//! byte order M (0 little, 1 big), 0, the precision P of the numbers and the kind T: 0 full, 1 text, 2 sparse. A sparse
//! matrix is a full one with a row, a column and a value in each row, and the dimensions in the last.
//!
//! Source: MathWorks, MAT-File Format (MATLAB documentation), chapter 2.

use super::element::{Element, Order};
use crate::import::ImportError;
use crate::import::model::unread;
use crate::import::variable::{Value, Variable, entries, is_known, names_of};
use nalgebra::DMatrix;

const HEADER: usize = 20;
/// The longest name with its final zero.
const LONGEST_NAME: u32 = 256;

/// The head of a matrix.
struct Head {
    order: Order,
    /// P.
    precision: u32,
    /// T.
    kind: u32,
    rows: u32,
    columns: u32,
    is_complex: bool,
    name: u32,
}

impl Head {
    /// The head at the beginning of these bytes; none if they cannot be one.
    fn read(bytes: &[u8]) -> Option<Self> {
        let (words, _) = bytes.first_chunk::<HEADER>()?.as_chunks::<4>();
        let order = if Order::Little.u32(words[0]) < 100 { Order::Little } else { Order::Big };
        let [kind, rows, columns, complex, name] = [0, 1, 2, 3, 4].map(|k| order.u32(words[k]));
        let expected = if order == Order::Little { 0 } else { 1000 };
        let kind = kind.checked_sub(expected).filter(|kind| *kind < 100)?;
        let (precision, kind) = (kind / 10, kind % 10);
        (precision <= 5 && kind <= 2 && complex <= 1 && (2..=LONGEST_NAME).contains(&name)).then_some(Self {
            order,
            precision,
            kind,
            rows,
            columns,
            is_complex: complex == 1,
            name,
        })
    }

    /// The width of a number, and its type as an element of version 5.
    fn number(&self) -> (usize, u32) {
        [(8, 9), (4, 7), (4, 5), (2, 3), (2, 4), (1, 2)][self.precision as usize]
    }
}

/// Whether the file begins with a matrix of version 4: its head, and a name of letters, digits and underscores.
pub(in crate::import) fn is_version_4(bytes: &[u8]) -> bool {
    Head::read(bytes).is_some_and(|head| {
        let name = bytes.get(HEADER..HEADER + head.name as usize).and_then(<[u8]>::split_last);
        name.is_some_and(|(last, name)| *last == 0 && name.iter().all(|c| c.is_ascii_alphanumeric() || *c == b'_'))
    })
}

/// The variables of a file.
pub(in crate::import) fn read(bytes: &[u8]) -> Result<Vec<Variable>, ImportError> {
    let mut variables = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let damaged = |what| ImportError::Damaged { what, at };
        let head = Head::read(&bytes[at..]).ok_or_else(|| damaged("no head of a matrix"))?;
        let rest = &bytes[at + HEADER..];
        let (name, rest) = rest.split_at_checked(head.name as usize).ok_or_else(|| damaged("a name cut short"))?;
        let name = Element { kind: 1, data: name, at }.name();
        let (width, kind) = head.number();
        let cut = || damaged("a matrix that is longer than what is left of the file");
        let count = u64::from(head.rows).checked_mul(u64::from(head.columns));
        let length = count.and_then(|count| usize::try_from(count).ok()?.checked_mul(width)).ok_or_else(cut)?;
        let (real, rest) = rest.split_at_checked(length).ok_or_else(cut)?;
        let (imaginary, rest) =
            if head.is_complex { rest.split_at_checked(length).ok_or_else(cut)? } else { (&[][..], rest) };
        variables.push(if is_known(&name) {
            let numbers = |data| Element { kind, data, at }.numbers(head.order);
            let value = value(&name, &head, &numbers(real)?, &numbers(imaginary)?, at)?;
            Variable { name, value }
        } else {
            unread(name)
        });
        at = bytes.len() - rest.len();
    }
    Ok(variables)
}

fn value(name: &str, head: &Head, real: &[f64], imaginary: &[f64], at: usize) -> Result<Value, ImportError> {
    if head.kind == 1 {
        if names_of(name).is_none() {
            return Ok(Value::Other("text".to_owned()));
        }
        // Each row is a text, padded with blanks.
        let rows = head.rows as usize;
        let letter = |code: &f64| char::from_u32(*code as u32).unwrap_or('?');
        let text = |row: usize| real.iter().skip(row).step_by(rows).map(letter).collect::<String>();
        return Ok(Value::Names((0..rows).map(|row| text(row).trim_end().to_owned()).collect()));
    }
    if imaginary.iter().any(|x| *x != 0.0) {
        return Ok(Value::Other("complex".to_owned()));
    }
    let (rows, columns) = (u64::from(head.rows), u64::from(head.columns));
    if head.kind == 0 {
        entries(name, rows, columns)?;
        return Ok(Value::Matrix(DMatrix::from_column_slice(rows as usize, columns as usize, real)));
    }
    sparse(name, head, real, at)
}

/// Triples `(row, column, value)`, the last of them with the dimensions.
fn sparse(name: &str, head: &Head, numbers: &[f64], at: usize) -> Result<Value, ImportError> {
    let damaged = || ImportError::Damaged { what: "a sparse matrix whose entries do not fit", at };
    let count = head.rows as usize;
    let is_count = |x: f64| x >= 0.0 && x <= f64::from(u32::MAX) && x.fract() == 0.0;
    if count == 0 || head.columns < 3 || !numbers[..2 * count].iter().all(|x| is_count(*x)) {
        return Err(damaged());
    }
    let triple = |k: usize| (numbers[k] as usize, numbers[count + k] as usize, numbers[2 * count + k]);
    let (rows, columns, _) = triple(count - 1);
    entries(name, rows as u64, columns as u64)?;
    let mut m = DMatrix::zeros(rows, columns);
    for (row, column, value) in (0..count - 1).map(triple) {
        let place = row.checked_sub(1).zip(column.checked_sub(1));
        *place.and_then(|place| m.get_mut(place)).ok_or_else(damaged)? = value;
    }
    Ok(Value::Matrix(m))
}
