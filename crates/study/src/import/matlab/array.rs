//! MATLAB variables: numeric and sparse matrices, structures; of all others only the names.

use super::element::{Element, Elements, MATRIX, Order};
use crate::import::ImportError;
use crate::import::model::unread;
use crate::import::variable::{Value, Variable, entries, is_known, names_of};
use nalgebra::DMatrix;

const CELL: u32 = 1;
const STRUCTURE: u32 = 2;
/// Objects of old classes, such as the `ss` of MATLAB 5, are structures with an additional class name.
const OBJECT: u32 = 3;
const TEXT: u32 = 4;
const SPARSE: u32 = 5;
const FIRST_NUMERIC: u32 = 6;
const LAST_NUMERIC: u32 = 15;
/// Objects of new classes, such as today's `ss`; their format is not documented.
const OPAQUE: u32 = 17;

const COMPLEX: u32 = 1 << 11;

/// Text in UTF-8, the kind of an element.
const UTF8: u32 = 16;

/// The maximal number of fields of a structure.
const FIELDS: usize = 4096;

/// The variable in the data of a matrix element; none for the nameless data of the subsystem.
pub(super) fn array(data: &[u8], at: usize, order: Order) -> Result<Option<Variable>, ImportError> {
    let mut parts = Elements::inside(data, at, order);
    let flags = parts.expect("a variable without flags")?;
    let Some(word) = flags.data.first_chunk::<4>() else { return Err(parts.damaged("flags cut short")) };
    let word = order.u32(*word);
    let class = word & 0xff;
    if class == OPAQUE {
        // An opaque object has no dimensions: the name follows, then the kind and the name of the class.
        let name = parts.expect("an object without a name")?.name();
        parts.expect("an object without a kind")?;
        let what = format!("an object of the class {}", parts.expect("an object without a class")?.name());
        return Ok(Some(Variable { name, value: Value::Other(what) }));
    }
    let dimensions = parts.expect("a variable without dimensions")?.counts(order)?;
    let name = parts.expect("a variable without a name")?.name();
    if name.is_empty() {
        return Ok(None);
    }
    let header = Header { word, class, dimensions, order };
    if class == STRUCTURE || class == OBJECT {
        let value = structure(&header, &mut parts)?;
        return Ok(Some(Variable { name, value }));
    }
    if !is_known(&name) {
        return Ok(Some(unread(name)));
    }
    let value = matrix(&name, &header, &mut parts)?;
    Ok(Some(Variable { name, value }))
}

struct Header {
    word: u32,
    class: u32,
    dimensions: Vec<u64>,
    order: Order,
}

/// A matrix of numbers, or a description of what is there instead.
fn matrix(name: &str, header: &Header, parts: &mut Elements) -> Result<Value, ImportError> {
    let order = header.order;
    let other = |what: &str| Ok(Value::Other(what.to_owned()));
    match header.class {
        SPARSE | FIRST_NUMERIC..=LAST_NUMERIC => {}
        TEXT => return other("text"),
        CELL if names_of(name).is_some() => return names(header, parts),
        CELL => return other("a cell array"),
        _ => return other("neither numbers nor text"),
    }
    let [rows, columns] = header.dimensions[..] else {
        return Ok(Value::Other(format!("an array of the shape {:?}", header.dimensions)));
    };
    let count = entries(name, rows, columns)?;
    let (rows, columns) = (rows as usize, columns as usize);
    let sparse = if header.class == SPARSE {
        let row = parts.expect("a sparse matrix without rows")?.counts(order)?;
        let start = parts.expect("a sparse matrix without columns")?.counts(order)?;
        Some((row, start))
    } else {
        None
    };
    // MATLAB omits the data of an empty matrix.
    let real = match parts.next_element()? {
        Some(element) => element.numbers(order)?,
        None if count == 0 => Vec::new(),
        None => return Err(parts.damaged("a matrix without numbers")),
    };
    if header.word & COMPLEX != 0 {
        let imaginary = parts.expect("a complex matrix without imaginary parts")?.numbers(order)?;
        if imaginary.iter().any(|x| *x != 0.0) {
            return other("complex");
        }
    }
    let Some((row, start)) = sparse else {
        if real.len() != count {
            return Err(parts.damaged("a matrix whose numbers are not as many as its dimensions say"));
        }
        return Ok(Value::Matrix(DMatrix::from_vec(rows, columns, real)));
    };
    let is_rising = start.windows(2).all(|pair| pair[0] <= pair[1]);
    let stored = start.last().copied().unwrap_or_default() as usize;
    if start.len() != columns + 1 || !is_rising || stored > row.len() || stored > real.len() {
        return Err(parts.damaged("a sparse matrix whose columns do not fit"));
    }
    let mut m = DMatrix::zeros(rows, columns);
    for column in 0..columns {
        for at in start[column] as usize..start[column + 1] as usize {
            let Some(entry) = m.get_mut((row[at] as usize, column)) else {
                return Err(parts.damaged("a sparse matrix with an entry outside of it"));
            };
            *entry = real[at];
        }
    }
    Ok(Value::Matrix(m))
}

/// The texts of a cell array; of one with anything else a description.
fn names(header: &Header, parts: &mut Elements) -> Result<Value, ImportError> {
    let mut names = Vec::new();
    while let Some(cell) = parts.next_element()? {
        if cell.kind != MATRIX {
            return Err(parts.damaged("a cell that is no variable"));
        }
        let mut inside = Elements::of(cell, header.order, false);
        let flags = inside.expect("a cell without flags")?;
        let Some(word) = flags.data.first_chunk::<4>() else { return Err(parts.damaged("flags cut short")) };
        if header.order.u32(*word) & 0xff != TEXT {
            return Ok(Value::Other("a cell array".to_owned()));
        }
        inside.expect("a cell without dimensions")?;
        inside.expect("a cell without a name")?;
        let text = match inside.next_element()? {
            Some(text) if text.kind == UTF8 => String::from_utf8_lossy(text.data).into_owned(),
            Some(text) => {
                let units: Vec<u16> = text.numbers(header.order)?.into_iter().map(|unit| unit as u16).collect();
                String::from_utf16_lossy(&units)
            }
            None => String::new(),
        };
        names.push(text);
    }
    Ok(Value::Names(names))
}

/// The fields of a structure; arrays of structures are not read.
fn structure(header: &Header, parts: &mut Elements) -> Result<Value, ImportError> {
    if header.dimensions.iter().any(|size| *size != 1) {
        return Ok(Value::Other("an array of structures".to_owned()));
    }
    if header.class == OBJECT {
        parts.expect("an object without a class")?;
    }
    let width = parts.expect("a structure without names")?.counts(header.order)?;
    let names = parts.expect("a structure without names")?;
    let width = width.first().copied().unwrap_or_default() as usize;
    if width == 0 || names.data.len() / width > FIELDS {
        return if names.data.is_empty() {
            Ok(Value::Structure(Vec::new()))
        } else {
            Err(parts.damaged("the names of a structure do not fit"))
        };
    }
    let mut fields = Vec::new();
    for name in names.data.chunks(width) {
        let name = Element { kind: 1, data: name, at: names.at }.name();
        let field = parts.expect("a structure without one of its fields")?;
        if field.kind != MATRIX {
            return Err(parts.damaged("a field that is no variable"));
        }
        fields.push(if is_known(&name) { self::field(name, field, header.order)? } else { unread(name) });
    }
    Ok(Value::Structure(fields))
}

/// A field is a variable whose own name is empty.
fn field(name: String, element: Element, order: Order) -> Result<Variable, ImportError> {
    if element.data.is_empty() {
        return Ok(Variable { name, value: Value::Matrix(DMatrix::zeros(0, 0)) });
    }
    let mut parts = Elements::of(element, order, false);
    let flags = parts.expect("a field without flags")?;
    let Some(word) = flags.data.first_chunk::<4>() else { return Err(parts.damaged("flags cut short")) };
    let word = order.u32(*word);
    let class = word & 0xff;
    if class == OPAQUE {
        return Ok(Variable { name, value: Value::Other("an object".to_owned()) });
    }
    let dimensions = parts.expect("a field without dimensions")?.counts(order)?;
    parts.expect("a field without a name")?;
    let value = matrix(&name, &Header { word, class, dimensions, order }, &mut parts)?;
    Ok(Variable { name, value })
}
