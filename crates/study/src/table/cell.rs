//! What a cell of a table says: a number, nothing, or a mistake.
//!
//! The decimal sign is a point; between semicolons or tabs also a comma, as spreadsheets of many countries write it,
//! but not both in one table: `1.234` would be 1234 in one of them.

/// What stands in a cell without a value, in any case.
const MISSING: [&str; 5] = ["", "nan", "na", "n/a", "null"];

/// A cell as it was read.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cell {
    Number(f64),
    Missing,
    Wrong(String),
}

/// The decimal sign of a table, as soon as a cell has one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Decimal {
    Point,
    Comma,
}

/// Reads a cell; `separator` is the one between cells, `decimal` the sign that has been used so far.
pub(super) fn cell(text: &str, separator: u8, decimal: &mut Option<Decimal>) -> Cell {
    if MISSING.iter().any(|missing| text.eq_ignore_ascii_case(missing)) {
        return Cell::Missing;
    }
    let sign = match (text.contains('.'), text.matches(',').count()) {
        (true, 0) => Some(Decimal::Point),
        (false, 1) if separator != b',' => Some(Decimal::Comma),
        (false, 0) => None,
        _ => return Cell::Wrong(text.to_owned()),
    };
    let number = match sign {
        Some(Decimal::Comma) => text.replace(',', ".").parse::<f64>(),
        _ => text.parse(),
    };
    let Ok(number) = number else { return Cell::Wrong(text.to_owned()) };
    if let Some(sign) = sign {
        if decimal.is_some_and(|decimal| decimal != sign) {
            return Cell::Wrong(text.to_owned());
        }
        *decimal = Some(sign);
    }
    Cell::Number(number)
}

/// Advice for a cell that is no number.
pub(super) fn advice(text: &str, decimal: Option<Decimal>) -> &'static str {
    let digits = |text: &str| text.chars().filter(char::is_ascii_digit).count();
    let has = |separator: char| text.matches(separator).count();
    if digits(text) >= 4 && (has(':') >= 1 || has('-') == 2 || has('/') == 2 || has('.') == 2) {
        return "; dates and times of day are for the column of times, all in one form, such as 2024-05-01T12:00:00.5 or 12:00:00.5";
    }
    let number = text.replace([',', '.'], "").parse::<f64>().is_ok();
    match decimal {
        _ if !number => "",
        Some(Decimal::Point) if has(',') == 1 => "; other cells have a decimal point, so that a comma is ambiguous",
        Some(Decimal::Comma) if has('.') == 1 => "; other cells have a decimal comma, so that a point is ambiguous",
        _ => {
            "; a decimal sign is one point, or between semicolons or tabs one comma, and there is no sign for thousands"
        }
    }
}
