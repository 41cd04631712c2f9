//! Numbers, counts and names in sentences and in markup, for text that makes no claim about the last digit.
//!
//! Decimals are those that read back as the number, or rounded to a number of significant digits, without trailing
//! zeros, and in scientific notation below 1e-4 and from 1e7. Numbers of statements, exact or rounded to the safe side,
//! are written by `luenberger_proof::wording`. And [`setters!`], which words the documentation of options.
#![deny(missing_docs)]

mod setters;

/// The shortest decimal that reads back as `x`, in scientific notation only where it is very large or very small.
///
/// ```
/// use luenberger_wording::shortest;
/// assert_eq!([shortest(0.1), shortest(-0.0), shortest(-0.25), shortest(1e-9), shortest(3e8)], ["0.1", "0", "-0.25", "1e-9", "3e8"]);
/// ```
pub fn shortest(x: f64) -> String {
    match x {
        0.0 => "0".to_owned(),
        _ if (1e-4..1e7).contains(&x.abs()) || !x.is_finite() => x.to_string(),
        _ => format!("{x:e}"),
    }
}

/// `x` with this number of significant digits, without trailing zeros: for text that makes no claim.
///
/// ```
/// use luenberger_wording::significant;
/// assert_eq!([significant(11.904_37, 5), significant(0.098_457_4, 4), significant(10.0, 4)], ["11.904", "0.09846", "10"]);
/// assert_eq!([significant(2.5e-13, 4), significant(9.999_96e6, 5), significant(f64::NAN, 3)], ["2.5e-13", "1e7", "NaN"]);
/// ```
pub fn significant(x: f64, digits: usize) -> String {
    // The shortest decimal of the nearest double has no more digits.
    shortest(rounded(x, digits))
}

/// The double that is nearest to `x` with this number of significant digits.
///
/// ```
/// use luenberger_wording::rounded;
/// assert_eq!([rounded(1.0 / 3.0, 4), rounded(12345.0, 2), rounded(f64::INFINITY, 3)], [0.3333, 12000.0, f64::INFINITY]);
/// ```
pub fn rounded(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits.saturating_sub(1)).parse().unwrap_or(x)
}

/// A complex number to so many significant digits in either part.
///
/// ```
/// use luenberger_wording::complex;
/// assert_eq!([complex([-1.0, 2.0], 3), complex([0.5, -1.0 / 3.0], 2), complex([2.0, 0.0], 3)], ["-1 + 2i", "0.5 - 0.33i", "2"]);
/// ```
pub fn complex([re, im]: [f64; 2], digits: usize) -> String {
    match (re, im) {
        (_, 0.0) => significant(re, digits),
        (0.0, _) => format!("{}i", significant(im, digits)),
        _ => {
            let sign = if im < 0.0 { '-' } else { '+' };
            format!("{} {sign} {}i", significant(re, digits), significant(im.abs(), digits))
        }
    }
}

/// The entry of a matrix at `row` and `column`, which count from 0: people count from 1.
///
/// ```
/// use luenberger_wording::entry;
/// assert_eq!(format!("A{}", entry(0, 1)), "A(1, 2)");
/// ```
pub fn entry(row: usize, column: usize) -> String {
    format!("({}, {})", row + 1, column + 1)
}

/// The text with a capital first letter, as the start of a sentence.
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().collect::<String>() + letters.as_str()).unwrap_or_default()
}

/// `1 state`, `2 states`.
///
/// ```
/// use luenberger_wording::counted;
/// assert_eq!([counted(1, "state"), counted(0, "input")], ["1 state", "0 inputs"]);
/// ```
pub fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// A user's text as a name: in double quotes, with a backslash before quotes and backslashes of its own.
///
/// ```
/// use luenberger_wording::quoted;
/// assert_eq!(quoted("P > 0"), "\"P > 0\"");
/// assert_eq!(quoted("the \"gain\""), "\"the \\\"gain\\\"\"");
/// ```
pub fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('\\', "\\\\").replace('"', "\\\""))
}

/// `text` for HTML, SVG and XML, within an element or a quoted attribute.
///
/// ```
/// assert_eq!(luenberger_wording::escape("a < \"b\" & c"), "a &lt; &quot;b&quot; &amp; c");
/// ```
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
