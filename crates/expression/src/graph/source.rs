//! A routine as source code of C99 and Rust: one operation per line, in the order of its evaluation.
//!
//! Elementary functions are called as `PREFIX_sin(x)` in C and `libm::sin(x)` in Rust, which have to be the algorithms
//! of the crate libm, or in binary32 those of [`luenberger_plants::binary32`]; `sqrt` and `fabs` are exact in every
//! library.

use std::fmt::Write;

use super::{Id, Node, Routine};
use crate::function::{Binary, Unary};
use crate::table::{Extrapolation, Table};

/// The language of the source code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// C99.
    C,
    /// Rust.
    Rust,
}

/// How source code is written.
#[derive(Clone, Copy, Debug)]
pub struct Dialect<'a> {
    /// The language.
    pub language: Language,
    /// Whether numbers are binary32, and not binary64.
    pub single: bool,
    /// What stands before the names of functions and tables, with its underscore.
    pub prefix: &'a str,
    /// Whether C calls the elementary functions of the target's library, `sinf`, in place of those with the prefix.
    pub of_target: bool,
    /// A number as a literal of the language and the format.
    pub literal: fn(f64, single: bool) -> String,
}

/// An elementary function of the library of mathematics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[expect(missing_docs, reason = "the names are those of the C library")]
pub enum MathFunction {
    Exp,
    Expm1,
    Log,
    Log10,
    Log1p,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Atan2,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
    Pow,
}

impl MathFunction {
    /// All functions.
    pub const ALL: [Self; 19] = [
        Self::Exp,
        Self::Expm1,
        Self::Log,
        Self::Log10,
        Self::Log1p,
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
        Self::Pow,
    ];

    /// The number of arguments.
    pub fn arguments(self) -> usize {
        if matches!(self, Self::Atan2 | Self::Pow) { 2 } else { 1 }
    }

    /// The name in the C library, of the version for binary64.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exp => "exp",
            Self::Expm1 => "expm1",
            Self::Log => "log",
            Self::Log10 => "log10",
            Self::Log1p => "log1p",
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
            Self::Pow => "pow",
        }
    }

    /// Whether binary32 has an algorithm of its own in [`luenberger_plants::binary32`], because libm's computes in
    /// binary64.
    fn is_of_binary32(self) -> bool {
        matches!(self, Self::Sin | Self::Cos | Self::Tan | Self::Asin)
    }

    pub(super) fn of(unary: Unary) -> Option<Self> {
        Some(match unary {
            Unary::Exp => Self::Exp,
            Unary::Ln => Self::Log,
            Unary::Log10 => Self::Log10,
            Unary::Sin => Self::Sin,
            Unary::Cos => Self::Cos,
            Unary::Tan => Self::Tan,
            Unary::Asin => Self::Asin,
            Unary::Acos => Self::Acos,
            Unary::Atan => Self::Atan,
            Unary::Sinh => Self::Sinh,
            Unary::Cosh => Self::Cosh,
            Unary::Tanh => Self::Tanh,
            Unary::Asinh => Self::Asinh,
            Unary::Acosh => Self::Acosh,
            Unary::Atanh => Self::Atanh,
            Unary::Negate | Unary::Reciprocal | Unary::Abs | Unary::Sign | Unary::Step | Unary::Floor | Unary::Sqrt => {
                return None;
            }
        })
    }
}

impl Dialect<'_> {
    /// The type of a number.
    pub fn number(&self) -> &'static str {
        match (self.language, self.single) {
            (Language::C, false) => "double",
            (Language::C, true) => "float",
            (Language::Rust, false) => "f64",
            (Language::Rust, true) => "f32",
        }
    }

    pub(super) fn literal(&self, x: f64) -> String {
        (self.literal)(x, self.single)
    }

    /// The name of an elementary function.
    fn call(&self, function: MathFunction) -> String {
        let suffix = if self.single { "f" } else { "" };
        match self.language {
            Language::C if self.of_target => format!("{}{suffix}", function.name()),
            Language::C => format!("{}{}{suffix}", self.prefix, function.name()),
            Language::Rust if self.single && function.is_of_binary32() => {
                format!("luenberger_observers::binary32::{}", function.name())
            }
            Language::Rust => format!("libm::{}{suffix}", function.name()),
        }
    }

    /// `sqrt`, `fabs` or `floor`, which are exact.
    fn exact(&self, name: &str) -> String {
        let suffix = if self.single { "f" } else { "" };
        match self.language {
            Language::C => format!("{name}{suffix}"),
            Language::Rust => format!("libm::{name}{suffix}"),
        }
    }

    /// A number of `<float.h>`, and in Rust of the type.
    fn of_format(&self, name: &str) -> String {
        match self.language {
            Language::C => format!("{}_{name}", if self.single { "FLT" } else { "DBL" }),
            Language::Rust => format!("{}::{name}", self.number()),
        }
    }

    /// `condition ? x : y`.
    fn choice(&self, condition: &str, x: &str, y: &str) -> String {
        match self.language {
            Language::C => format!("({condition}) ? {x} : {y}"),
            Language::Rust => format!("if {condition} {{ {x} }} else {{ {y} }}"),
        }
    }
}

/// An operand: leaves are written where they are used.
pub(super) fn operand(routine: &Routine, dialect: &Dialect, id: Id) -> String {
    match routine.code[id as usize] {
        Node::Constant(bits) => {
            let literal = dialect.literal(f64::from_bits(bits));
            if literal.starts_with('-') { format!("({literal})") } else { literal }
        }
        Node::Epsilon => dialect.of_format("EPSILON"),
        Node::Largest => dialect.of_format("MAX"),
        Node::Truth(truth) => truth.to_string(),
        Node::Time => "t".to_owned(),
        Node::Entry(matrix, row, column) => format!("{}[{row}][{column}]", routine.matrix(matrix)),
        Node::State(k) => format!("x[{k}]"),
        Node::Input(k) => format!("u[{k}]"),
        _ => format!("v{id}"),
    }
}

pub(super) fn body(routine: &Routine, dialect: &Dialect) -> String {
    let mut text = String::new();
    for (id, node) in routine.code.iter().enumerate() {
        let Some(value) = operation(routine, dialect, *node) else { continue };
        let condition = matches!(node, Node::Compare(..) | Node::And(..) | Node::Or(..) | Node::Not(_));
        _ = match (dialect.language, condition) {
            (Language::C, true) => writeln!(text, "    const bool v{id} = {value};"),
            (Language::C, false) => writeln!(text, "    const {} v{id} = {value};", dialect.number()),
            (Language::Rust, _) => writeln!(text, "    let v{id} = {value};"),
        };
    }
    for (k, id) in routine.results.iter().enumerate() {
        _ = writeln!(text, "    out[{k}] = {};", operand(routine, dialect, *id).trim_matches(['(', ')']));
    }
    text
}

/// The right-hand side of an operation; none for a leaf.
fn operation(routine: &Routine, dialect: &Dialect, node: Node) -> Option<String> {
    applied(dialect, node, &node.operands().map(|id| operand(routine, dialect, id)).collect::<Vec<_>>())
}

/// An operation on operands; none for a leaf.
pub(super) fn applied(dialect: &Dialect, node: Node, operands: &[String]) -> Option<String> {
    Some(match (node, operands) {
        (Node::Unary(unary, _), [x]) => function(dialect, unary, x),
        (Node::Binary(binary, ..), [x, y]) => two(dialect, binary, x, y),
        (Node::Table(table, _), [x]) => format!("{}table{table}({x})", dialect.prefix),
        (Node::Slope(table, _), [x]) => format!("{}slope{table}({x})", dialect.prefix),
        (Node::Compare(comparison, ..), [x, y]) => format!("{x} {} {y}", comparison.sign()),
        (Node::And(..), [x, y]) => format!("{x} && {y}"),
        (Node::Or(..), [x, y]) => format!("{x} || {y}"),
        (Node::Not(_), [x]) => format!("!{x}"),
        (Node::Select(..), [condition, x, y]) => dialect.choice(condition, x, y),
        _ => return None,
    })
}

fn function(dialect: &Dialect, unary: Unary, x: &str) -> String {
    if let Some(function) = MathFunction::of(unary) {
        return format!("{}({x})", dialect.call(function));
    }
    let (zero, one) = (dialect.literal(0.0), dialect.literal(1.0));
    match unary {
        Unary::Negate => format!("-{x}"),
        Unary::Reciprocal => format!("{one} / {x}"),
        Unary::Abs => format!("{}({x})", dialect.exact("fabs")),
        Unary::Sqrt => format!("{}({x})", dialect.exact("sqrt")),
        Unary::Floor => format!("{}({x})", dialect.exact("floor")),
        Unary::Step => {
            let rest = dialect.choice(&format!("{x} >= {zero}"), &one, x);
            dialect.choice(&format!("{x} < {zero}"), &zero, &format!("({rest})"))
        }
        // 0 at 0, NaN at NaN.
        _ => {
            let least = dialect.literal(-1.0);
            let rest = dialect.choice(&format!("{x} == {zero}"), &zero, x);
            let rest = dialect.choice(&format!("{x} < {zero}"), &least, &format!("({rest})"));
            dialect.choice(&format!("{x} > {zero}"), &one, &format!("({rest})"))
        }
    }
}

fn two(dialect: &Dialect, binary: Binary, x: &str, y: &str) -> String {
    match binary {
        Binary::Add | Binary::Subtract | Binary::Multiply | Binary::Divide => format!("{x} {} {y}", binary.name()),
        Binary::Power => {
            let (zero, one) = (dialect.literal(0.0), dialect.literal(1.0));
            let power = format!("{}({x}, {y})", dialect.call(MathFunction::Pow));
            dialect.choice(&format!("({x} == {zero}) && ({y} > {one})"), &zero, &power)
        }
        Binary::Atan2 => format!("{}({x}, {y})", dialect.call(MathFunction::Atan2)),
        Binary::Min => dialect.choice(&format!("{y} < {x}"), y, x),
        Binary::Max => dialect.choice(&format!("{y} > {x}"), y, x),
        Binary::Modulo => format!("{x} - ({y} * {}({x} / {y}))", dialect.exact("floor")),
        Binary::Wrap => {
            let half = dialect.literal(0.5);
            format!("{x} + ({y} * {}({half} - ({x} / {y})))", dialect.exact("floor"))
        }
        Binary::LnPlusExp => ln_plus_exp(dialect, x, y),
        Binary::LnExpPlus => ln_plus_exp(dialect, y, x),
    }
}

fn ln_plus_exp(dialect: &Dialect, a: &str, z: &str) -> String {
    let call = |function| dialect.call(function);
    let (exp, log, log1p) = (call(MathFunction::Exp), call(MathFunction::Log), call(MathFunction::Log1p));
    let small = format!("{log}({a} + {exp}({z}))");
    let large = format!("({z} + {log1p}({a} * {exp}(-{z})))");
    dialect.choice(&format!("{z} < {}", dialect.literal(1.0)), &small, &large)
}

/// The functions of a table that are used: its value, its derivative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lookups {
    /// Its value.
    pub value: bool,
    /// Its derivative.
    pub slope: bool,
}

impl Table {
    /// The numbers that it stores.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> {
        let (x, y, slopes) = self.points();
        x.iter().chain(y).chain(slopes.into_iter().flatten()).copied()
    }

    /// Functions for its value and its derivative, those that are `used`: `PREFIXtableK` and `PREFIXslopeK`.
    pub fn source(&self, number: usize, dialect: &Dialect, used: Lookups) -> String {
        let (x, y, slopes) = self.points();
        let count = x.len();
        let (kind, prefix) = (dialect.number(), dialect.prefix);
        let mut text = String::new();
        let c = dialect.language == Language::C;
        let mut list = |name: &str, values: &[f64]| {
            let values = values.iter().map(|value| dialect.literal(*value)).collect::<Vec<_>>().join(", ");
            _ = if c {
                writeln!(text, "static const {kind} {prefix}{name}{number}[{count}] = {{ {values} }};")
            } else {
                writeln!(text, "const {}: [{kind}; {count}] = [{values}];", constant(prefix, name, number))
            };
        };
        list("table_x", x);
        list("table_y", y);
        if let Some(slopes) = slopes {
            list("table_m", slopes);
        }
        let of = |name: &str| if c { format!("{prefix}{name}{number}") } else { constant(prefix, name, number) };
        let (px, py, pm) = (of("table_x"), of("table_y"), of("table_m"));
        let last = count - 1;
        _ = if c {
            writeln!(
                text,
                "\nstatic int {prefix}piece{number}({kind} x)\n{{\n    int k = 0;\n    int end = {last};\n    while ((end - k) > 1) {{\n        const int middle = k + ((end - k) / 2);\n        if (x < {px}[middle]) {{\n            end = middle;\n        }} else {{\n            k = middle;\n        }}\n    }}\n    return k;\n}}\n"
            )
        } else {
            writeln!(
                text,
                "\nfn {prefix}piece{number}(x: {kind}) -> usize {{\n    let (mut k, mut end) = (0, {last});\n    while end - k > 1 {{\n        let middle = k + (end - k) / 2;\n        if x < {px}[middle] {{ end = middle }} else {{ k = middle }}\n    }}\n    k\n}}\n"
            )
        };
        let outer = |end: usize| {
            let k = end.min(count - 2);
            match (self.extrapolation(), slopes) {
                (Extrapolation::Hold, _) => dialect.literal(0.0),
                (Extrapolation::Linear, Some(_)) => format!("{pm}[{end}]"),
                (Extrapolation::Linear, None) => {
                    format!("({py}[{}] - {py}[{k}]) / ({px}[{}] - {px}[{k}])", k + 1, k + 1)
                }
            }
        };
        let beyond = |end: usize| match self.extrapolation() {
            Extrapolation::Hold => format!("{py}[{end}]"),
            Extrapolation::Linear => format!("{py}[{end}] + (({}) * (x - {px}[{end}]))", outer(end)),
        };
        let inner = |name: &str, first: &str, end: &str, inside: &[(&str, String)], result: &str| {
            let mut text = if c {
                format!("static {kind} {prefix}{name}{number}({kind} x)\n{{\n")
            } else {
                format!("fn {prefix}{name}{number}(x: {kind}) -> {kind} {{\n")
            };
            for (sign, at, value) in [("<", 0, first), (">", last, end)] {
                _ = if c {
                    writeln!(text, "    if (x {sign} {px}[{at}]) {{\n        return {value};\n    }}")
                } else {
                    writeln!(text, "    if x {sign} {px}[{at}] {{\n        return {value};\n    }}")
                };
            }
            text.push_str(if c { "    {\n" } else { "" });
            for (variable, value) in inside {
                _ = match (c, *variable) {
                    (true, "k") => writeln!(text, "        const int k = {value};"),
                    (true, variable) => writeln!(text, "        const {kind} {variable} = {value};"),
                    (false, variable) => writeln!(text, "    let {variable} = {value};"),
                };
            }
            _ = if c {
                writeln!(text, "        return {result};\n    }}\n}}")
            } else {
                writeln!(text, "    {result}\n}}")
            };
            text
        };
        let piece = ("k", format!("{prefix}piece{number}(x)"));
        let width = ("width", format!("{px}[k + 1] - {px}[k]"));
        let share = ("share", format!("(x - {px}[k]) / width"));
        let rest = ("rest", format!("{} - share", dialect.literal(1.0)));
        let (rises, secant) = (format!("({py}[k + 1] - {py}[k])"), format!("({py}[k + 1] - {py}[k]) / width"));
        let (value, slope) = if slopes.is_none() {
            (
                inner(
                    "table",
                    &beyond(0),
                    &beyond(last),
                    &[piece.clone(), width.clone(), share],
                    &format!("{py}[k] + ({rises} * share)"),
                ),
                inner("slope", &outer(0), &outer(last), &[piece, width], &secant),
            )
        } else {
            let three = ("three", dialect.literal(3.0));
            let ends = [("first", format!("{pm}[k] * width")), ("second", format!("{pm}[k + 1] * width"))];
            let all: Vec<_> =
                [piece.clone(), width.clone(), share.clone(), rest.clone(), three].into_iter().chain(ends).collect();
            let sum = format!(
                "({py}[k] * rest * rest * rest) + ((({py}[k] * three) + first) * rest * rest * share) + ((({py}[k + 1] * three) - second) * rest * share * share) + ({py}[k + 1] * share * share * share)"
            );
            let value = inner("table", &beyond(0), &beyond(last), &all, &sum);
            let middle = (
                "middle",
                format!("({} * ({secant})) - ({pm}[k] + {pm}[k]) - ({pm}[k + 1] + {pm}[k + 1])", dialect.literal(6.0)),
            );
            let sum = format!("({pm}[k] * rest * rest) + (middle * rest * share) + ({pm}[k + 1] * share * share)");
            (value, inner("slope", &outer(0), &outer(last), &[piece, width, share, rest, middle], &sum))
        };
        let all = [(used.value, value), (used.slope, slope)];
        text + &all.into_iter().filter(|(used, _)| *used).map(|(_, text)| text).collect::<Vec<_>>().join("\n")
    }
}

/// The name of a constant of Rust.
fn constant(prefix: &str, name: &str, number: usize) -> String {
    format!("{prefix}{name}{number}").to_uppercase()
}
