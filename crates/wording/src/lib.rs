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

/// A user's text as a name: in double quotes, with a backslash before quotes and backslashes of its own, and
/// [`visible`].
///
/// ```
/// use luenberger_wording::quoted;
/// assert_eq!(quoted("P > 0"), "\"P > 0\"");
/// assert_eq!(quoted("the \"gain\""), "\"the \\\"gain\\\"\"");
/// assert_eq!(quoted("P\u{202e}0 <"), "\"P\\u{202e}0 <\"");
/// ```
pub fn quoted(name: &str) -> String {
    format!("\"{}\"", visible(&name.replace('\\', "\\\\").replace('"', "\\\"")))
}

/// A text without [invisible characters](is_invisible): in their place are `\u{200b}` and so on.
///
/// ```
/// assert_eq!(luenberger_wording::visible("a\u{200b}b \u{2028}c"), "a\\u{200b}b \\u{2028}c");
/// ```
pub fn visible(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if is_invisible(c) {
            shown.extend(c.escape_unicode());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// Whether a character leaves no mark of its own, or moves others: controls, format characters such as those of
/// bidirectional text, separators of lines, every space but U+0020, fillers, and selectors of variants. The list is
/// that of `docs/certificates.md`, the same in all versions of Unicode.
///
/// ```
/// use luenberger_wording::is_invisible;
/// assert!("\n\u{7f}\u{a0}\u{ad}\u{200b}\u{2028}\u{202e}\u{3164}\u{feff}\u{e0041}".chars().all(is_invisible));
/// assert!(!"P > 0, \u{e4}\u{3b8}\u{4f4d}".chars().any(is_invisible));
/// ```
pub fn is_invisible(c: char) -> bool {
    let c = u32::from(c);
    INVISIBLE.iter().any(|(first, last)| (*first..=*last).contains(&c))
}

/// The first and the last of each range.
const INVISIBLE: [(u32, u32); 30] = [
    (0x0000, 0x001f),
    (0x007f, 0x00a0),
    (0x00ad, 0x00ad),
    (0x034f, 0x034f),
    (0x0600, 0x0605),
    (0x061c, 0x061c),
    (0x06dd, 0x06dd),
    (0x070f, 0x070f),
    (0x0890, 0x0891),
    (0x08e2, 0x08e2),
    (0x115f, 0x1160),
    (0x1680, 0x1680),
    (0x17b4, 0x17b5),
    (0x180b, 0x180f),
    (0x2000, 0x200f),
    (0x2028, 0x202f),
    (0x205f, 0x206f),
    (0x2800, 0x2800),
    (0x3000, 0x3000),
    (0x3164, 0x3164),
    (0xfe00, 0xfe0f),
    (0xfeff, 0xfeff),
    (0xffa0, 0xffa0),
    (0xfff0, 0xfffb),
    (0x110bd, 0x110bd),
    (0x110cd, 0x110cd),
    (0x13430, 0x1345f),
    (0x1bca0, 0x1bca3),
    (0x1d173, 0x1d17a),
    (0xe0000, 0xe0fff),
];

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
