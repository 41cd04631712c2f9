//! The elementary functions of the observers as C99.
//!
//! Observers take their elementary functions from libm on every machine (`nalgebra/libm-force`). A C library has its
//! own, which differ in the last bits. Emitted C therefore carries libm's: each function of version 0.2.16, operation
//! by operation, for binary64 and binary32. In binary32 the sine, cosine, tangent and arc sine, which libm computes in
//! binary64, are those of [`luenberger_plants::binary32`]: no function for binary32 has an operation of binary64. Tests
//! compare them bit by bit on millions of arguments.
//!
//! The files beside this one are C. Their paragraphs, separated by empty lines, define one object each; names begin
//! with `lm_`, in whose place the emitted code has a prefix of its own. [`source`] takes the paragraphs that the wanted
//! functions refer to. Constants are hexadecimal. From the C library they need the exact operations `sqrt`, `fabs` and
//! `floor`, and `memcpy` for the bits of a number.

use std::collections::BTreeSet;

use luenberger_expression::MathFunction;

use crate::scalar::Scalar;

/// The name of a function in emitted C: the prefix, an underscore, and the name that C has for it (`plant_sinf`).
///
/// ```
/// use luenberger_export::{Scalar, c_math};
/// use luenberger_expression::MathFunction;
/// assert_eq!(c_math::call(MathFunction::Log, "plant", Scalar::Binary32), "plant_logf");
/// ```
pub fn call(function: MathFunction, prefix: &str, scalar: Scalar) -> String {
    let suffix = match scalar {
        Scalar::Binary32 => "f",
        Scalar::Binary64 => "",
    };
    format!("{prefix}_{}{suffix}", function.name())
}

/// A bound of the error of the function for binary32, in units in the last place of the result; tests look at all
/// exponents, multiples of pi/2 and ln 2, and the ends of the ranges. Of the arc hyperbolic cosine from 1 on: below,
/// libm's is not always NaN.
///
/// ```
/// use luenberger_export::c_math::units;
/// use luenberger_expression::MathFunction;
/// assert_eq!([MathFunction::Sin, MathFunction::Tan].map(units), [1.0, 2.0]);
/// ```
pub fn units(function: MathFunction) -> f64 {
    match function {
        MathFunction::Tan
        | MathFunction::Atan2
        | MathFunction::Sinh
        | MathFunction::Cosh
        | MathFunction::Asinh
        | MathFunction::Acosh
        | MathFunction::Atanh => 2.0,
        MathFunction::Tanh => 2.5,
        _ => 1.0,
    }
}

/// The headers that [`source`] needs.
pub const INCLUDES: &str = "#include <math.h>\n#include <stdint.h>\n#include <string.h>\n";

/// The notice of the authors of libm, musl and msun, which stands before the functions.
const NOTICE: &str = include_str!("notice.c");

/// In the order in which they can be compiled.
const FILES: [&str; 8] = [
    include_str!("bits.c"),
    include_str!("exponential.c"),
    include_str!("logarithm.c"),
    include_str!("reduction.c"),
    include_str!("trigonometric.c"),
    include_str!("inverse.c"),
    include_str!("power.c"),
    include_str!("hyperbolic.c"),
];

/// C definitions of these functions and of all that they call, as static functions whose names begin with `prefix`,
/// after the notice of their authors. Empty without functions. The file has to include [`INCLUDES`] before.
///
/// ```
/// use luenberger_export::{Scalar, c_math::source};
/// use luenberger_expression::MathFunction;
/// let text = source("plant", Scalar::Binary64, [MathFunction::Sinh]);
/// assert!(text.contains("static double plant_sinh(double x)") && text.contains("static double plant_expm1("));
/// assert!(!text.contains("plant_sinhf"));
/// ```
pub fn source(prefix: &str, scalar: Scalar, functions: impl IntoIterator<Item = MathFunction>) -> String {
    let mut needed: BTreeSet<String> = functions.into_iter().map(|function| call(function, "lm", scalar)).collect();
    if needed.is_empty() {
        return String::new();
    }
    let mut taken = Vec::new();
    // What a paragraph refers to stands before it.
    for paragraph in FILES.iter().rev().flat_map(|file| file.trim_end().rsplit("\n\n")) {
        let mut names = names(paragraph);
        if names.next().is_some_and(|name| needed.contains(name)) {
            needed.extend(names.map(str::to_owned));
            taken.push(paragraph.replace("lm_", &format!("{prefix}_")));
        }
    }
    taken.push(NOTICE.trim_end().to_owned());
    taken.reverse();
    taken.join("\n\n") + "\n"
}

/// The names that begin with `lm_` in the code of a paragraph; the first is the one that it defines.
fn names(paragraph: &str) -> impl Iterator<Item = &str> {
    paragraph
        .split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_')
        .filter(|word| word.starts_with("lm_"))
}
