//! Formatted output of a certificate: one member per line, one matrix row per line.

use super::json::write_string;
use crate::interval::Interval;
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

impl Out {
    pub(super) fn number(x: f64) -> Self {
        // NaN and infinities have no place in a file: the reader will name them.
        Self::Text(Number::from_f64(x).map_or_else(|| x.to_string(), |number| number.to_string()))
    }

    pub(super) fn numbers(xs: &[f64]) -> Self {
        Self::Line(xs.iter().map(|x| Self::number(*x)).collect())
    }

    pub(super) fn matrix(m: &Matrix<f64>) -> Self {
        Self::rows(m, |x| Self::number(*x))
    }

    pub(super) fn exact(m: &Matrix<Number>) -> Self {
        Self::rows(m, |x| Self::Text(x.to_string()))
    }

    pub(super) fn data(m: &Matrix<Datum>) -> Self {
        Self::rows(m, Self::datum)
    }

    pub(super) fn interval(interval: &Interval) -> Self {
        // Unbounded ends have no place in a file: the reader will name them.
        Datum::from_interval(interval).map_or_else(|| Self::number(f64::NAN), |x| Self::datum(&x))
    }

    pub(super) fn intervals(m: &Matrix<Interval>) -> Self {
        Self::rows(m, Self::interval)
    }

    pub(super) fn datum(datum: &Datum) -> Self {
        match datum {
            Datum::Number(x) => Self::Text(x.to_string()),
            Datum::Between(lo, hi) => Self::Line(vec![Self::Text(lo.to_string()), Self::Text(hi.to_string())]),
        }
    }

    fn rows<T>(m: &Matrix<T>, entry: impl Fn(&T) -> Self) -> Self {
        Self::Lines((0..m.rows()).map(|i| Self::Line(m.row(i).iter().map(&entry).collect())).collect())
    }

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

fn start_line(number: usize, indent: usize, text: &mut String) {
    text.push_str(if number > 0 { ",\n" } else { "\n" });
    text.extend(core::iter::repeat_n("  ", indent));
}
