//! Expressions as formulas: MathML, which browsers draw by themselves, and LaTeX.

use std::fmt::Write;

use luenberger_wording::shortest;

use crate::expression::Expression;
use crate::function::{Binary, Comparison, Unary};
use crate::tree::Node;

/// A formula in two languages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formula {
    /// The content of a `math` element.
    pub mathml: String,
    /// The same in LaTeX, for the mathematical mode.
    pub latex: String,
}

/// A part of a formula, and how tightly it holds together.
type Part = (Formula, Strength);

#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Strength {
    Condition,
    Sum,
    /// With a minus before it.
    Sign,
    Product,
    Power,
    Atom,
}

impl Formula {
    /// A name as it is written by hand: `x1` has an index, `omega_r` a Greek letter and an index, `upper` is a word.
    ///
    /// ```
    /// use luenberger_expression::Formula;
    /// assert_eq!(Formula::name("x12").latex, "x_{12}");
    /// assert_eq!(Formula::name("omega_r").latex, "\\omega_{r}");
    /// assert_eq!(Formula::name("upper").latex, "\\mathrm{upper}");
    /// assert_eq!(Formula::name("x1").mathml, "<msub><mi>x</mi><mn>1</mn></msub>");
    /// ```
    pub fn name(name: &str) -> Self {
        let digits = name.len() - name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let (stem, index) = match name.split_once('_') {
            Some((stem, index)) if !stem.is_empty() && !index.is_empty() => (stem, index),
            _ if digits > 0 && digits < name.len() => name.split_at(name.len() - digits),
            _ => return word(name),
        };
        let (stem, index) = (word(stem), word(index));
        let mathml = format!("<msub>{}{}</msub>", stem.mathml, index.mathml);
        Self { mathml, latex: format!("{}_{{{}}}", stem.latex, index.latex) }
    }

    /// The derivative by time of a name, or its value at the next sample.
    pub fn motion(name: &str, discrete: bool) -> Self {
        let Self { mathml, latex } = Self::name(name);
        if discrete {
            let mathml = format!("<msup><mrow>{mathml}</mrow><mo>+</mo></msup>");
            Self { mathml, latex: format!("{{{latex}}}^{{+}}") }
        } else if latex.starts_with("\\mathrm") {
            // A dot over a word is overlooked.
            let mathml = format!("<mrow><mfrac><mi>d</mi><mrow><mi>d</mi><mi>t</mi></mrow></mfrac>{mathml}</mrow>");
            Self { mathml, latex: format!("\\frac{{d}}{{dt}} {latex}") }
        } else {
            let mathml = format!("<mover><mrow>{mathml}</mrow><mo>˙</mo></mover>");
            Self { mathml, latex: format!("\\dot{{{latex}}}") }
        }
    }

    /// `self = other`.
    #[must_use]
    pub fn equals(&self, other: &Self) -> Self {
        Self {
            mathml: format!("{}<mo>=</mo>{}", self.mathml, other.mathml),
            latex: format!("{} = {}", self.latex, other.latex),
        }
    }

    fn new(mathml: String, latex: String) -> Self {
        Self { mathml, latex }
    }

    /// In parentheses.
    fn held(self) -> Self {
        Self::new(format!("<mrow><mo>(</mo>{}<mo>)</mo></mrow>", self.mathml), format!("\\left({}\\right)", self.latex))
    }
}

impl Expression {
    /// The expression as a formula.
    ///
    /// ```
    /// use luenberger_expression::{Expression, Scope};
    /// let torque = Expression::parse("-2*sin(x1)^2 + u1/(1 + x2)", &Scope::plant(2, 1))?;
    /// assert_eq!(torque.formula().latex, "-2 \\sin\\left(x_{1}\\right)^{2} + \\frac{u_{1}}{1 + x_{2}}");
    /// # Ok::<(), luenberger_expression::ExpressionError>(())
    /// ```
    pub fn formula(&self) -> Formula {
        let mut parts: Vec<Part> = Vec::new();
        for node in self.tree.nodes() {
            // Each node is an operand once, so that its part can be taken.
            let empty = || (Formula::new(String::new(), String::new()), Strength::Atom);
            let mut take =
                |index: usize| parts.get_mut(index).map_or_else(empty, |part| core::mem::replace(part, empty()));
            let part = match node {
                Node::Number(value) => (number(*value), Strength::Atom),
                Node::Symbol(_, name) => (Formula::name(name), Strength::Atom),
                Node::Unary(function, x) => unary(*function, take(*x)),
                Node::Binary(operation, x, y) => binary(*operation, take(*x), take(*y)),
                Node::Saturate(x, low, high) => call("sat", [take(*x), take(*low), take(*high)]),
                Node::Table(_, name, x) => applied(Formula::name(name), [take(*x)]),
                Node::Surface(_, name, x, y) => applied(Formula::name(name), [take(*x), take(*y)]),
                Node::Compare(comparison, x, y) => {
                    let sign = match comparison {
                        Comparison::Less => ("&lt;", "<"),
                        Comparison::LessOrEqual => ("≤", "\\le"),
                        Comparison::Greater => ("&gt;", ">"),
                        Comparison::GreaterOrEqual => ("≥", "\\ge"),
                        Comparison::Equal => ("=", "="),
                        Comparison::NotEqual => ("≠", "\\ne"),
                    };
                    (infix(sign, &least(take(*x), Strength::Sum), &least(take(*y), Strength::Sum)), Strength::Condition)
                }
                Node::And(x, y) => {
                    let (x, y) = (least(take(*x), Strength::Sum), least(take(*y), Strength::Sum));
                    (infix(("∧", "\\land"), &x, &y), Strength::Condition)
                }
                Node::Or(x, y) => {
                    let (x, y) = (least(take(*x), Strength::Sum), least(take(*y), Strength::Sum));
                    (infix(("∨", "\\lor"), &x, &y), Strength::Condition)
                }
                Node::Not(x) => {
                    let x = least(take(*x), Strength::Atom);
                    let not = Formula::new(format!("<mo>¬</mo>{}", x.mathml), format!("\\lnot {}", x.latex));
                    (not, Strength::Condition)
                }
                Node::Then | Node::Else => empty(),
                Node::If(condition, x, y) => (choice(&take(*condition).0, &take(*x).0, &take(*y).0), Strength::Atom),
            };
            parts.push(part);
        }
        parts.pop().map_or_else(|| Formula::new(String::new(), String::new()), |(formula, _)| formula)
    }
}

/// The part, in parentheses if it holds together less than is needed.
fn least((formula, strength): Part, needed: Strength) -> Formula {
    if strength < needed { formula.held() } else { formula }
}

/// A name without an index.
fn word(name: &str) -> Formula {
    if name.chars().all(|c| c.is_ascii_digit()) {
        return Formula::new(format!("<mn>{name}</mn>"), name.to_owned());
    }
    if let Some((_, letter)) = GREEK.iter().find(|(latin, _)| *latin == name) {
        return Formula::new(format!("<mi>{letter}</mi>"), format!("\\{name}"));
    }
    let escaped = name.replace('_', "\\_");
    if name.chars().count() == 1 {
        return Formula::new(format!("<mi>{name}</mi>"), escaped);
    }
    Formula::new(format!("<mi>{name}</mi>"), format!("\\mathrm{{{escaped}}}"))
}

/// Names that are letters of LaTeX; `pi` is one, `e` stays as it is.
const GREEK: [(&str, &str); 22] = [
    ("alpha", "α"),
    ("beta", "β"),
    ("gamma", "γ"),
    ("delta", "δ"),
    ("epsilon", "ε"),
    ("zeta", "ζ"),
    ("eta", "η"),
    ("theta", "θ"),
    ("kappa", "κ"),
    ("lambda", "λ"),
    ("mu", "μ"),
    ("nu", "ν"),
    ("xi", "ξ"),
    ("pi", "π"),
    ("rho", "ρ"),
    ("sigma", "σ"),
    ("tau", "τ"),
    ("phi", "φ"),
    ("chi", "χ"),
    ("psi", "ψ"),
    ("omega", "ω"),
    ("Omega", "Ω"),
];

/// A number, with a power of ten where it is written with an exponent.
fn number(value: f64) -> Formula {
    let text = shortest(value);
    match text.split_once('e') {
        None => Formula::new(format!("<mn>{text}</mn>"), text),
        Some((mantissa, exponent)) => {
            let power = format!("<msup><mn>10</mn><mn>{}</mn></msup>", exponent.replace('-', "−"));
            if mantissa == "1" {
                return Formula::new(power, format!("10^{{{exponent}}}"));
            }
            Formula::new(
                format!("<mrow><mn>{mantissa}</mn><mo>⋅</mo>{power}</mrow>"),
                format!("{mantissa} \\cdot 10^{{{exponent}}}"),
            )
        }
    }
}

fn infix((mathml, latex): (&str, &str), x: &Formula, y: &Formula) -> Formula {
    let mathml = format!("<mrow>{}<mo>{mathml}</mo>{}</mrow>", x.mathml, y.mathml);
    Formula::new(mathml, format!("{} {latex} {}", x.latex, y.latex))
}

/// Functions that LaTeX knows by their name.
const KNOWN: [&str; 8] = ["sin", "cos", "tan", "sinh", "cosh", "tanh", "ln", "exp"];

fn call<const N: usize>(name: &str, arguments: [Part; N]) -> Part {
    let latex = if KNOWN.contains(&name) { format!("\\{name}") } else { format!("\\operatorname{{{name}}}") };
    applied(Formula::new(format!("<mi>{name}</mi>"), latex), arguments)
}

fn applied<const N: usize>(function: Formula, arguments: [Part; N]) -> Part {
    let mut joined = Formula::new(String::new(), String::new());
    for (k, (argument, _)) in arguments.into_iter().enumerate() {
        if k > 0 {
            joined.mathml.push_str("<mo>,</mo>");
            joined.latex.push_str(", ");
        }
        joined.mathml.push_str(&argument.mathml);
        joined.latex.push_str(&argument.latex);
    }
    let inside = joined.held();
    let mathml = format!("<mrow>{}<mo>&#x2061;</mo>{}</mrow>", function.mathml, inside.mathml);
    (Formula::new(mathml, function.latex + &inside.latex), Strength::Atom)
}

fn unary(function: Unary, x: Part) -> Part {
    let around = |left: &str, right: &str, latex: (&str, &str), x: &Formula| {
        let mathml = format!("<mrow><mo>{left}</mo>{}<mo>{right}</mo></mrow>", x.mathml);
        (Formula::new(mathml, format!("{}{}{}", latex.0, x.latex, latex.1)), Strength::Atom)
    };
    match function {
        Unary::Negate => {
            let x = least(x, Strength::Product);
            (Formula::new(format!("<mrow><mo>−</mo>{}</mrow>", x.mathml), format!("-{}", x.latex)), Strength::Sign)
        }
        Unary::Reciprocal => (fraction(&number(1.0), &x.0), Strength::Product),
        Unary::Abs => around("|", "|", ("\\left|", "\\right|"), &x.0),
        Unary::Sqrt => {
            let root = Formula::new(format!("<msqrt>{}</msqrt>", x.0.mathml), format!("\\sqrt{{{}}}", x.0.latex));
            (root, Strength::Atom)
        }
        Unary::Exp => (power(&word("e"), &x.0), Strength::Power),
        Unary::Log10 => {
            let base = Formula::new("<msub><mi>log</mi><mn>10</mn></msub>".to_owned(), "\\log_{10}".to_owned());
            applied(base, [x])
        }
        other => call(other.name(), [x]),
    }
}

fn fraction(x: &Formula, y: &Formula) -> Formula {
    let mathml = format!("<mfrac><mrow>{}</mrow><mrow>{}</mrow></mfrac>", x.mathml, y.mathml);
    Formula::new(mathml, format!("\\frac{{{}}}{{{}}}", x.latex, y.latex))
}

fn power(base: &Formula, exponent: &Formula) -> Formula {
    let mathml = format!("<msup><mrow>{}</mrow><mrow>{}</mrow></msup>", base.mathml, exponent.mathml);
    Formula::new(mathml, format!("{}^{{{}}}", base.latex, exponent.latex))
}

fn binary(operation: Binary, x: Part, y: Part) -> Part {
    match operation {
        Binary::Add => {
            // A sum on the right needs no parentheses, a sign does.
            let y = if y.1 == Strength::Sign { y.0.held() } else { least(y, Strength::Sum) };
            (infix(("+", "+"), &least(x, Strength::Sum), &y), Strength::Sum)
        }
        Binary::Subtract => (infix(("−", "-"), &least(x, Strength::Sum), &least(y, Strength::Product)), Strength::Sum),
        Binary::Multiply => {
            // Juxtaposition after a number, a dot between names: `A lower` would read as one word.
            let digits = |part: &Part| part.0.latex.ends_with(|c: char| c.is_ascii_digit());
            let begins = |part: &Part| part.0.latex.starts_with(|c: char| c.is_ascii_digit());
            let (after, before) = (digits(&x) && !x.0.latex.contains('_'), begins(&y));
            let sign = if after && !before { ("&#x2062;", "") } else { ("⋅", "\\cdot") };
            let product = infix(sign, &least(x, Strength::Sign), &least(y, Strength::Product));
            (Formula { latex: product.latex.replace("  ", " "), ..product }, Strength::Product)
        }
        Binary::Divide => (fraction(&x.0, &y.0), Strength::Product),
        Binary::Power => (power(&least(x, Strength::Atom), &y.0), Strength::Power),
        other => call(other.name(), [x, y]),
    }
}

/// The cases of an `if`.
fn choice(condition: &Formula, x: &Formula, y: &Formula) -> Formula {
    let mut mathml = "<mrow><mo>{</mo><mtable columnalign=\"left\">".to_owned();
    // Writing into a String cannot fail.
    let _ = write!(
        mathml,
        "<mtr><mtd>{}</mtd><mtd><mtext>if&#xA0;</mtext>{}</mtd></mtr><mtr><mtd>{}</mtd><mtd><mtext>else</mtext></mtd></mtr></mtable></mrow>",
        x.mathml, condition.mathml, y.mathml
    );
    let latex = format!(
        "\\begin{{cases}}{} & \\text{{if }} {} \\\\ {} & \\text{{else}}\\end{{cases}}",
        x.latex, condition.latex, y.latex
    );
    Formula { mathml, latex }
}
