//! What a study file may say: its tables and keys as data.
//!
//! One description serves three ends: files are checked against it ([`crate::read`]), the JSON Schema that editors
//! complete from is written from it ([`json_schema`]), and the guide can list it. A key that is not here does not
//! exist.

mod json;
mod keys;
mod observers;

pub use json::{SCHEMA, json_schema};
pub(crate) use keys::QUANTITIES;
pub use keys::STUDY;

/// A table: what it is for, and its keys.
#[derive(Debug, Clone, Copy)]
pub struct Table {
    /// How messages call it: "the table `[plant]`".
    pub name: &'static str,
    /// What it is for.
    pub about: &'static str,
    /// The keys that every such table may have.
    pub keys: &'static [Key],
    /// The key that says which of several kinds of table this is, with the kinds; none for a table of one kind.
    pub variants: Option<Variants>,
}

/// The kinds of a table.
#[derive(Debug, Clone, Copy)]
pub struct Variants {
    /// The key whose value is the name of the kind.
    pub tag: &'static str,
    /// The kinds.
    pub of: &'static [Variant],
}

/// One kind of a table.
#[derive(Debug, Clone, Copy)]
pub struct Variant {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// The keys that only some kinds have.
    pub keys: &'static [Key],
}

/// A key.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// What its value must be.
    pub kind: Kind,
    /// Whether it must be there.
    pub required: bool,
    /// What it means, with units, and what holds without it.
    pub about: &'static str,
}

/// What a value must be.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// A text.
    Text,
    /// One of these texts, each with what it means.
    Choice(&'static [(&'static str, &'static str)]),
    /// True or false.
    Switch,
    /// A finite number.
    Number(Range),
    /// A whole number of at least this size.
    Count(usize),
    /// A list of finite numbers, not empty.
    Numbers(Range),
    /// A list of texts, not empty.
    Texts,
    /// A list of texts from these.
    Choices(&'static [(&'static str, &'static str)]),
    /// A matrix as a list of rows.
    Rows,
    /// A weight: a number (times the identity), a list (the diagonal) or rows.
    Weight,
    /// A list of poles: numbers, and pairs `[re, im]`.
    Poles,
    /// A list of pairs `[lower, upper]`, of which ends may be infinite.
    Bounds,
    /// A pair `[lower, upper]`, of which ends may be infinite.
    Bound,
    /// A table from names to finite numbers.
    Named,
    /// A table.
    Table(&'static Table),
    /// A list of tables, not empty.
    Tables(&'static Table),
}

/// Which numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// Any.
    Any,
    /// Greater than 0.
    Positive,
    /// 0 and greater.
    NotNegative,
}

impl Range {
    /// Whether `x` is in it.
    pub fn holds(self, x: f64) -> bool {
        x.is_finite()
            && match self {
                Self::Any => true,
                Self::Positive => x > 0.0,
                Self::NotNegative => x >= 0.0,
            }
    }

    /// In words, after "a".
    pub fn words(self) -> &'static str {
        match self {
            Self::Any => "finite number",
            Self::Positive => "positive finite number",
            Self::NotNegative => "finite number that is not negative",
        }
    }
}

impl Kind {
    /// What is expected, after "expected".
    pub fn words(&self) -> String {
        let names = |choices: &[(&str, &str)]| {
            choices.iter().map(|(name, _)| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
        };
        match self {
            Self::Text => "a text".to_owned(),
            Self::Choice(choices) => format!("one of {}", names(choices)),
            Self::Switch => "true or false".to_owned(),
            Self::Number(range) => format!("a {}", range.words()),
            Self::Count(least) => format!("a whole number of at least {least}"),
            Self::Numbers(range) => format!("a list of numbers, each a {}", range.words()),
            Self::Texts => "a list of texts".to_owned(),
            Self::Choices(choices) => format!("a list from {}", names(choices)),
            Self::Rows => "a matrix as a list of rows, [[1, 2], [3, 4]]".to_owned(),
            Self::Weight => "a weight: a number, the list of a diagonal, or a matrix as a list of rows".to_owned(),
            Self::Poles => "a list of poles, numbers or pairs [re, im]".to_owned(),
            Self::Bounds => "a list of pairs [lower, upper]".to_owned(),
            Self::Bound => "a pair [lower, upper]".to_owned(),
            Self::Named => "a table from names to numbers".to_owned(),
            Self::Table(table) => format!("{}, a table", table.name),
            Self::Tables(table) => format!("a list of tables, {}", table.name),
        }
    }
}

impl Table {
    /// The variant of that name.
    pub fn variant(&self, name: &str) -> Option<&'static Variant> {
        self.variants?.of.iter().find(|variant| variant.name == name)
    }
}
