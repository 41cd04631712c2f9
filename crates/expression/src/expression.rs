//! One expression: parsed, evaluated, differentiated, examined.

use core::fmt;

use nalgebra::RealField;

use crate::error::{ExpressionError, ExpressionErrorKind};
use crate::graph::recording;
use crate::scope::{Scope, Symbol};
use crate::tape::Tape;
use crate::tree::{Node, Tree};
use crate::{affine, parse};

/// A parsed expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    text: String,
    pub(crate) tree: Tree,
    pub(crate) tape: Tape,
}

impl Expression {
    /// The expression in a text of at most 8192 bytes, with at most 64 operations within each other.
    ///
    /// Cost: linear in the length.
    ///
    /// ```
    /// use luenberger_expression::{Expression, Parameters, Scope};
    /// let scope = Scope::plant(2, 1).with(&Parameters::from([("k".to_owned(), 2.0), ("J".to_owned(), 0.5)]))?;
    /// let torque = Expression::parse("-k*sin(x1)^2 + u1/J", &scope)?;
    /// let (x, u) = ([0.3, 0.0], [1.0]);
    /// assert_eq!(torque.evaluate(0.0, &x, &u), -2.0 * 0.3f64.sin().powi(2) + 1.0 / 0.5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`ExpressionError`] with the place in the text.
    pub fn parse(text: &str, scope: &Scope) -> Result<Self, ExpressionError> {
        Self::of(text, parse::parse(text, scope)?)
    }

    /// The difference that is not positive where an inequality holds: of `a <= b` and `a < b` it is `a - b`, of
    /// `a >= b` and `a > b` it is `-(a - b)`. The limits are those of [`parse`](Self::parse).
    ///
    /// ```
    /// use luenberger_expression::{Expression, Scope};
    /// let disk = Expression::parse_inequality("x1^2 + x2^2 <= 4", &Scope::plant(2, 0))?;
    /// assert_eq!(disk.evaluate(0.0, &[1.0, 1.0], &[]), -2.0);
    /// assert!(Expression::parse_inequality("x1^2 + x2^2", &Scope::plant(2, 0)).is_err());
    /// # Ok::<(), luenberger_expression::ExpressionError>(())
    /// ```
    /// # Errors
    /// [`ExpressionError`] with the place in the text; of a text without a comparison, or with more than one.
    pub fn parse_inequality(text: &str, scope: &Scope) -> Result<Self, ExpressionError> {
        Self::of(text, parse::parse_inequality(text, scope)?)
    }

    fn of(text: &str, tree: Tree) -> Result<Self, ExpressionError> {
        let tape = Tape::compile(&tree)
            .map_err(|node| ExpressionError::new(text, tree.span(node), ExpressionErrorKind::TooDeep))?;
        Ok(Self { text: text.to_owned(), tree, tape })
    }

    /// Its value at the time t, the states x and the inputs u, over any scalar; missing entries of x or u are NaN.
    pub fn evaluate<T: RealField + Copy>(&self, t: T, x: &[T], u: &[T]) -> T {
        if let Some(recorded) = recording::expression(&self.tree, &t, x, u) {
            return recorded;
        }
        self.tape.evaluate(t, x, u, |_| ())
    }

    /// Whether it is affine in states and inputs with coefficients that do not depend on time: `a'x + b'u + c`.
    ///
    /// Decided by its form: sums, products with constants, quotients by constants. Affinity that needs
    /// the cancellation of terms, as in `x1*x2 - x2*x1`, is not recognised.
    ///
    /// ```
    /// use luenberger_expression::{Expression, Scope};
    /// let scope = Scope::plant(2, 1);
    /// assert!(Expression::parse("sqrt(2)*x1 - (x2 + u1)/3", &scope)?.affine().is_ok());
    /// assert_eq!(Expression::parse("x1 + 2*(x1*x2)", &scope)?.affine().unwrap_err(), "(x1*x2)");
    /// # Ok::<(), luenberger_expression::ExpressionError>(())
    /// ```
    /// # Errors
    /// The first part of the text that is not.
    pub fn affine(&self) -> Result<(), &str> {
        affine::affine(&self.tree, false).map_err(|node| self.part(node))
    }

    /// Whether it is affine in the states while the inputs are held, and free of the time; decided by its form, as
    /// [`affine`](Self::affine).
    ///
    /// ```
    /// use luenberger_expression::{Expression, Scope};
    /// let is = |text| Expression::parse(text, &Scope::plant(2, 1)).map(|row| row.is_affine_in_states());
    /// assert!(is("-x1*u1 + x2/u1^2 + sin(u1)")?);
    /// assert!(!is("x1*x2")? && !is("x1 + t")? && !is("if(x1 > 0, 1, 2)")?);
    /// # Ok::<(), luenberger_expression::ExpressionError>(())
    /// ```
    pub fn is_affine_in_states(&self) -> bool {
        affine::affine(&self.tree, true).is_ok()
    }

    /// The parameters that occur in it, by name, each as often as it occurs.
    pub fn parameters(&self) -> impl Iterator<Item = &str> {
        self.tree.nodes().filter_map(|node| match node {
            Node::Symbol(Symbol::Parameter(_), name) => Some(name.as_str()),
            _ => None,
        })
    }

    /// Whether the time occurs in it.
    pub fn uses_time(&self) -> bool {
        self.tree.nodes().any(|node| matches!(node, Node::Symbol(Symbol::Time, _)))
    }

    /// Whether an input occurs in it.
    pub fn uses_inputs(&self) -> bool {
        self.tree.nodes().any(|node| matches!(node, Node::Symbol(Symbol::Input(_), _)))
    }

    /// Whether state `k` (from 0) occurs in it, whatever its value there.
    ///
    /// ```
    /// use luenberger_expression::{Expression, Scope};
    /// let rate = Expression::parse("7.2e10*exp(-8750/x1)*x2", &Scope::plant(3, 0))?;
    /// assert!(rate.depends_on_state(1) && !rate.depends_on_state(2));
    /// # Ok::<(), luenberger_expression::ExpressionError>(())
    /// ```
    pub fn depends_on_state(&self, k: usize) -> bool {
        self.tree.nodes().any(|node| matches!(node, Node::Symbol(Symbol::State(state), _) if *state == k))
    }

    /// The text that was parsed.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The part of the text that belongs to a node.
    pub(crate) fn part(&self, node: usize) -> &str {
        self.text.get(self.tree.span(node)).unwrap_or(&self.text)
    }
}

/// As few parentheses as give the same expression.
impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.tree.print())
    }
}
