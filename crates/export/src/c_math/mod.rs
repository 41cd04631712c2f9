//! The elementary functions of the crate libm as C99.
//!
//! Observers take their elementary functions from libm on every machine (`nalgebra/libm-force`). A C library has its
//! own, which differ in the last bits. Emitted C therefore carries libm's: each function of version 0.2.16, operation
//! by operation, for binary64 and binary32. Tests compare them bit by bit on millions of arguments.
//!
//! The files beside this one are C. Their paragraphs, separated by empty lines, define one object each; names begin
//! with `lm_`, in whose place the emitted code has a prefix of its own. [`source`] takes the paragraphs that the wanted
//! functions refer to. Constants are hexadecimal. From the C library they need the exact operations `sqrt`, `fabs` and
//! `floor`, and `memcpy` for the bits of a number.

use std::collections::BTreeSet;

use luenberger_expression::MathFunction;

use crate::scalar::Scalar;

/// An elementary function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Function {
    /// The exponential.
    Exp,
    /// `exp(x) - 1`.
    ExpM1,
    /// The natural logarithm.
    Ln,
    /// `ln(1 + x)`.
    Ln1p,
    /// The logarithm to base 10.
    Log10,
    /// Sine.
    Sin,
    /// Cosine.
    Cos,
    /// Tangent.
    Tan,
    /// Inverse sine.
    Asin,
    /// Inverse cosine.
    Acos,
    /// Inverse tangent.
    Atan,
    /// The angle of the point (x, y), of the arguments y and x.
    Atan2,
    /// Hyperbolic sine.
    Sinh,
    /// Hyperbolic cosine.
    Cosh,
    /// Hyperbolic tangent.
    Tanh,
    /// Inverse hyperbolic sine.
    Asinh,
    /// Inverse hyperbolic cosine.
    Acosh,
    /// Inverse hyperbolic tangent.
    Atanh,
    /// `x^y`.
    Power,
}

impl Function {
    /// All functions.
    pub const ALL: [Self; 19] = [
        Self::Exp,
        Self::ExpM1,
        Self::Ln,
        Self::Ln1p,
        Self::Log10,
        Self::Sin,
        Self::Cos,
        Self::Tan,
        Self::Asin,
        Self::Acos,
        Self::Atan,
        Self::Atan2,
        Self::Sinh,
        Self::Cosh,
        Self::Tanh,
        Self::Asinh,
        Self::Acosh,
        Self::Atanh,
        Self::Power,
    ];

    /// The number of arguments.
    pub fn arguments(self) -> usize {
        if matches!(self, Self::Atan2 | Self::Power) { 2 } else { 1 }
    }

    /// The name in emitted C: the prefix, an underscore, and the name that C has for it (`plant_sinf`).
    ///
    /// ```
    /// use luenberger_export::{Scalar, c_math::Function};
    /// assert_eq!(Function::Ln.call("plant", Scalar::Binary32), "plant_logf");
    /// ```
    pub fn call(self, prefix: &str, scalar: Scalar) -> String {
        let name = match self {
            Self::Exp => "exp",
            Self::ExpM1 => "expm1",
            Self::Ln => "log",
            Self::Ln1p => "log1p",
            Self::Log10 => "log10",
            Self::Sin => "sin",
            Self::Cos => "cos",
            Self::Tan => "tan",
            Self::Asin => "asin",
            Self::Acos => "acos",
            Self::Atan => "atan",
            Self::Atan2 => "atan2",
            Self::Sinh => "sinh",
            Self::Cosh => "cosh",
            Self::Tanh => "tanh",
            Self::Asinh => "asinh",
            Self::Acosh => "acosh",
            Self::Atanh => "atanh",
            Self::Power => "pow",
        };
        let suffix = match scalar {
            Scalar::Binary32 => "f",
            Scalar::Binary64 => "",
        };
        format!("{prefix}_{name}{suffix}")
    }
}

impl From<MathFunction> for Function {
    fn from(function: MathFunction) -> Self {
        match function {
            MathFunction::Exp => Self::Exp,
            MathFunction::Log => Self::Ln,
            MathFunction::Log10 => Self::Log10,
            MathFunction::Log1p => Self::Ln1p,
            MathFunction::Sin => Self::Sin,
            MathFunction::Cos => Self::Cos,
            MathFunction::Tan => Self::Tan,
            MathFunction::Asin => Self::Asin,
            MathFunction::Acos => Self::Acos,
            MathFunction::Atan => Self::Atan,
            MathFunction::Atan2 => Self::Atan2,
            MathFunction::Sinh => Self::Sinh,
            MathFunction::Cosh => Self::Cosh,
            MathFunction::Tanh => Self::Tanh,
            MathFunction::Asinh => Self::Asinh,
            MathFunction::Acosh => Self::Acosh,
            MathFunction::Atanh => Self::Atanh,
            MathFunction::Pow => Self::Power,
        }
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
/// use luenberger_export::{Scalar, c_math::{Function, source}};
/// let text = source("plant", Scalar::Binary64, &[Function::Sinh]);
/// assert!(text.contains("static double plant_sinh(double x)") && text.contains("static double plant_expm1("));
/// assert!(!text.contains("plant_sinhf"));
/// ```
pub fn source(prefix: &str, scalar: Scalar, functions: &[Function]) -> String {
    if functions.is_empty() {
        return String::new();
    }
    let mut needed: BTreeSet<String> = functions.iter().map(|function| function.call("lm", scalar)).collect();
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reference_is_defined_before_it_and_every_definition_is_used() {
        let mut defined = BTreeSet::new();
        let mut used: BTreeSet<&str> = BTreeSet::new();
        let wanted: Vec<String> =
            [Scalar::Binary32, Scalar::Binary64].map(|s| Function::ALL.map(|f| f.call("lm", s))).concat();
        for paragraph in FILES.iter().flat_map(|file| file.trim_end().split("\n\n")) {
            let mut names = names(paragraph);
            let name = names.next().unwrap();
            assert!(paragraph.contains(&format!("{name}(")) || paragraph.contains(&format!("{name}[")), "{name}");
            for other in names.filter(|other| *other != name) {
                assert!(defined.contains(other), "{name} refers to {other}");
                used.insert(other);
            }
            assert!(defined.insert(name), "{name} twice");
        }
        for name in defined {
            assert!(used.contains(name) || wanted.iter().any(|function| function == name), "{name} is not used");
        }
    }
}
