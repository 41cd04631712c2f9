//! Formatted output of a certificate: one member per line, one matrix row per line.

use super::json::write_string;
use crate::interval::Interval;
use crate::label::Names;
use crate::matrix::Matrix;
use crate::number::{Datum, Number};

/// What is to be written.
#[derive(Debug, Clone)]
pub(super) enum Out {
    Text(String),
    Count(usize),
    /// An array on one line.
    Line(Vec<Out>),
    /// An array with an element to a line.
    Lines(Vec<Out>),
    Object(Vec<(&'static str, Out)>),
}

/// What has one form in files.
pub(super) trait Written {
    /// Whether an array of them is written on one line.
    const SHORT: bool = false;
    fn out(&self) -> Out;

    /// The names of labels with this member, if labels can have it.
    fn name_in<'a>(&'a self, name: &'static str, is_symmetric: bool, names: Names<'a>) -> Names<'a> {
        let _ = (name, is_symmetric);
        names
    }

    /// The names of labels with a matrix of these.
    fn matrix_in<'a>(m: &'a Matrix<Self>, name: &'static str, is_symmetric: bool, names: Names<'a>) -> Names<'a>
    where
        Self: Sized,
    {
        let _ = (m, name, is_symmetric);
        names
    }

    /// The names of labels with a list of these.
    fn list_in<'a>(list: &'a [Self], name: &'static str, names: Names<'a>) -> Names<'a>
    where
        Self: Sized,
    {
        let _ = (list, name);
        names
    }
}

impl Out {
    /// The text, ending with a line break.
    pub(super) fn pretty(&self) -> String {
        let mut text = String::new();
        self.write(0, &mut text);
        text.push('\n');
        text
    }

    fn write(&self, indent: usize, text: &mut String) {
        match self {
            Self::Text(string) => write_string(string, text),
            Self::Count(count) => text.push_str(&count.to_string()),
            Self::Line(items) => {
                text.push('[');
                for (k, item) in items.iter().enumerate() {
                    text.push_str(if k > 0 { ", " } else { "" });
                    item.write(indent, text);
                }
                text.push(']');
            }
            Self::Lines(items) if items.is_empty() => text.push_str("[]"),
            Self::Lines(items) => {
                text.push('[');
                for (k, item) in items.iter().enumerate() {
                    start_line(k, indent + 1, text);
                    item.write(indent + 1, text);
                }
                start_line(0, indent, text);
                text.push(']');
            }
            Self::Object(members) => {
                text.push('{');
                for (k, (name, value)) in members.iter().enumerate() {
                    start_line(k, indent + 1, text);
                    write_string(name, text);
                    text.push_str(": ");
                    value.write(indent + 1, text);
                }
                start_line(0, indent, text);
                text.push('}');
            }
        }
    }
}

impl Written for f64 {
    const SHORT: bool = true;

    fn out(&self) -> Out {
        // NaN and infinities have no place in a file: the reader will name them.
        Number::from_f64(*self).map_or_else(|| Out::Text(self.to_string()), |number| number.out())
    }

    fn name_in<'a>(&'a self, name: &'static str, _: bool, names: Names<'a>) -> Names<'a> {
        names.number(name, *self)
    }

    fn matrix_in<'a>(m: &'a Matrix<Self>, name: &'static str, is_symmetric: bool, names: Names<'a>) -> Names<'a> {
        if is_symmetric { names.symmetric(name, m) } else { names.matrix(name, m) }
    }

    fn list_in<'a>(list: &'a [Self], name: &'static str, names: Names<'a>) -> Names<'a> {
        names.list(name, list)
    }
}

impl Written for usize {
    const SHORT: bool = true;

    fn out(&self) -> Out {
        Out::Count(*self)
    }
}

impl Written for Interval {
    const SHORT: bool = true;

    fn out(&self) -> Out {
        // Unbounded ends have no place in a file: the reader will name them.
        Datum::from_interval(self).map_or_else(|| f64::NAN.out(), |datum| datum.out())
    }
}

impl Written for Number {
    fn out(&self) -> Out {
        Out::Text(self.to_string())
    }
}

impl Written for Datum {
    fn out(&self) -> Out {
        match self {
            Self::Number(x) => x.out(),
            Self::Between(lo, hi) => Out::Line(vec![lo.out(), hi.out()]),
        }
    }

    fn matrix_in<'a>(m: &'a Matrix<Self>, name: &'static str, _: bool, names: Names<'a>) -> Names<'a> {
        names.within(name, &m.map(Datum::interval))
    }
}

impl Written for str {
    fn out(&self) -> Out {
        Out::Text(self.to_owned())
    }
}

impl Written for String {
    fn out(&self) -> Out {
        self.as_str().out()
    }
}

impl<T: Written> Written for Matrix<T> {
    fn out(&self) -> Out {
        Out::Lines((0..self.rows()).map(|i| Out::Line(self.row(i).iter().map(T::out).collect())).collect())
    }

    fn name_in<'a>(&'a self, name: &'static str, is_symmetric: bool, names: Names<'a>) -> Names<'a> {
        T::matrix_in(self, name, is_symmetric, names)
    }
}

impl<T: Written> Written for [T] {
    fn out(&self) -> Out {
        let items = self.iter().map(T::out).collect();
        if T::SHORT { Out::Line(items) } else { Out::Lines(items) }
    }
}

impl<T: Written> Written for Vec<T> {
    fn out(&self) -> Out {
        self.as_slice().out()
    }

    fn name_in<'a>(&'a self, name: &'static str, _: bool, names: Names<'a>) -> Names<'a> {
        T::list_in(self, name, names)
    }
}

fn start_line(number: usize, indent: usize, text: &mut String) {
    text.push_str(if number > 0 { ",\n" } else { "\n" });
    text.extend(core::iter::repeat_n("  ", indent));
}
