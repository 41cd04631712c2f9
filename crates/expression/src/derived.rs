//! Parameters that are expressions of other parameters, such as `J = "m*l^2/3"`.

use std::collections::BTreeMap;

use crate::Expression;
use crate::error::ExpressionError;
use crate::scope::{ParameterError, Parameters, Scope};
use crate::undefined::Undefined;

/// The definition of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Definition {
    /// A number.
    Number(f64),
    /// An expression of other parameters.
    Text(String),
}

/// Error in the definitions of parameters; each variant names the parameter.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DerivedError {
    /// A name or a number that cannot be one.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A text that is no expression of parameters.
    #[error("the parameter `{name}`: {error}")]
    Expression {
        /// The parameter.
        name: String,
        /// The error of its text.
        error: ExpressionError,
    },
    /// Parameters that depend on each other in a circle.
    #[error("the parameters depend on each other in a circle: {}", circle(names))]
    Circle {
        /// The parameters, each depending on the next and the last on the first.
        names: Vec<String>,
    },
    /// A value that is not a finite number.
    #[error("the parameter `{name}`: {undefined}")]
    Undefined {
        /// The parameter.
        name: String,
        /// The part of its text that is not finite.
        undefined: Box<Undefined>,
    },
}

impl DerivedError {
    /// The parameter concerned; of a circle the first one.
    pub fn name(&self) -> &str {
        match self {
            Self::Parameter(error) => error.name(),
            Self::Expression { name, .. } | Self::Undefined { name, .. } => name,
            Self::Circle { names } => names.first().map_or("", String::as_str),
        }
    }
}

fn circle(names: &[String]) -> String {
    let around = names.iter().chain(names.first());
    around.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" -> ")
}

/// The values of parameters, in whatever order they depend on each other.
///
/// An expression may use the other parameters, `pi`, `e` and every function, but neither states nor inputs nor the
/// time.
///
/// ```
/// use luenberger_expression::{Definition, derived};
/// let text = |text: &str| Definition::Text(text.to_owned());
/// let definitions = [("J", text("m*l^2/3")), ("m", Definition::Number(0.6)), ("l", text("2*half")), ("half", text("0.5"))]
///     .map(|(name, definition)| (name.to_owned(), definition));
/// let values = derived(&definitions.into())?;
/// assert_eq!(values["J"], 0.6 / 3.0);
/// # Ok::<(), luenberger_expression::DerivedError>(())
/// ```
/// # Errors
/// [`DerivedError`] names the parameter.
pub fn derived(definitions: &BTreeMap<String, Definition>) -> Result<Parameters, DerivedError> {
    // All names are known to every expression; values are put in where they are needed.
    let names: Parameters = definitions.keys().map(|name| (name.clone(), 0.0)).collect();
    let known = Scope::constant().with(&names)?;
    let mut waiting: BTreeMap<&str, (&str, Vec<String>)> = BTreeMap::new();
    let mut values = Parameters::new();
    for (name, definition) in definitions {
        match definition {
            Definition::Number(value) => {
                Scope::constant().with(&Parameters::from([(name.clone(), *value)]))?;
                values.insert(name.clone(), *value);
            }
            Definition::Text(text) => {
                let expression = Expression::parse(text, &known)
                    .map_err(|error| DerivedError::Expression { name: name.clone(), error })?;
                waiting.insert(name, (text, expression.parameters().map(str::to_owned).collect()));
            }
        }
    }
    while !waiting.is_empty() {
        let ready: Vec<&str> = waiting
            .iter()
            .filter(|(_, (_, needs))| needs.iter().all(|need| values.contains_key(need)))
            .map(|(name, _)| *name)
            .collect();
        if ready.is_empty() {
            return Err(DerivedError::Circle { names: around(&waiting) });
        }
        let scope = Scope::constant().with(&values)?;
        for name in ready {
            let Some((text, _)) = waiting.remove(name) else { continue };
            let expression = Expression::parse(text, &scope)
                .map_err(|error| DerivedError::Expression { name: name.to_owned(), error })?;
            let value = expression.examine(0.0, &[], &[]).map_err(|undefined| DerivedError::Undefined {
                name: name.to_owned(),
                undefined: Box::new(undefined),
            })?;
            values.insert(name.to_owned(), value);
        }
    }
    Ok(values)
}

/// A circle among parameters that all wait for another one.
fn around(waiting: &BTreeMap<&str, (&str, Vec<String>)>) -> Vec<String> {
    let mut way: Vec<&str> = waiting.keys().take(1).copied().collect();
    // Each waits for one that waits, so that one comes again at the latest when all have come.
    while let Some((_, needs)) = way.last().and_then(|last| waiting.get(last)) {
        let Some((next, _)) = needs.iter().find_map(|need| waiting.get_key_value(need.as_str())) else { break };
        if let Some(start) = way.iter().position(|name| name == next) {
            return way[start..].iter().map(|name| (*name).to_owned()).collect();
        }
        way.push(*next);
    }
    way.into_iter().map(str::to_owned).collect()
}
