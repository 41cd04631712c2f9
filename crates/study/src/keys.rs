//! The types of the description: tables, keys, and types of values.

/// A table: its description and its keys.
#[derive(Debug, Clone, Copy)]
pub struct Table {
    /// Its name in messages: "the table `[plant]`".
    pub name: &'static str,
    /// Description.
    pub about: &'static str,
    /// The keys common to all kinds of this table.
    pub keys: &'static [Key],
    /// The key that selects the kind of the table, with the kinds; none for a table of one kind.
    pub variants: Option<Variants>,
}

/// The kinds of a table.
#[derive(Debug, Clone, Copy)]
pub struct Variants {
    /// The key that names the kind.
    pub tag: &'static str,
    /// The kinds, in the order of the schema.
    pub of: fn() -> Vec<Variant>,
}

/// One kind of a table.
#[derive(Debug, Clone, Copy)]
pub struct Variant {
    /// Its name.
    pub name: &'static str,
    /// Description.
    pub about: &'static str,
    /// The keys of this kind only, in groups: those that it shares with others, and its own.
    pub keys: &'static [&'static [Key]],
}

impl Variant {
    /// Its keys, one after the other.
    pub fn keys(&self) -> impl Iterator<Item = &'static Key> + use<> {
        self.keys.iter().copied().flatten()
    }
}

/// A key.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// Type of its value.
    pub value: Type,
    /// Whether it is required.
    pub required: bool,
    /// Description, with units and default.
    pub about: &'static str,
}

/// Type of a value.
#[derive(Debug, Clone, Copy)]
pub enum Type {
    /// A text.
    Text,
    /// A name: a text of moderate length without invisible characters.
    Name,
    /// One of these texts, each with its description.
    Choice(&'static [(&'static str, &'static str)]),
    /// A boolean.
    Switch,
    /// A finite number.
    Number(Range),
    /// An integer of at least this value.
    Count(usize),
    /// A list of finite numbers, not empty.
    Numbers(Range),
    /// A list of texts, not empty.
    Texts,
    /// A list of texts, which may be empty.
    Columns,
    /// A list of at least so many names.
    Names(usize),
    /// A list, not empty, of lists of at least so many names.
    NameLists(usize),
    /// A list of texts from this set.
    Choices(&'static [(&'static str, &'static str)]),
    /// A matrix as a list of rows.
    Rows,
    /// A list of expressions: texts, or numbers; not empty.
    Expressions,
    /// A matrix of expressions: rows of texts and numbers, or the list of a diagonal.
    ExpressionRows,
    /// A weight: a number (times the identity), a list (the diagonal) or rows.
    Weight,
    /// A weight, or the list of a diagonal of which entries are expressions.
    Covariance,
    /// A list of poles: numbers, and pairs `[re, im]`.
    Poles,
    /// A list of intervals `[lower, upper]` with possibly infinite ends.
    Bounds,
    /// An interval `[lower, upper]` with possibly infinite ends.
    Bound,
    /// A table from names to finite numbers, or to texts with expressions of them.
    Named,
    /// A table from names to intervals `[lower, upper]`.
    NamedBounds,
    /// A table from names to units, or the list of the units of the states.
    Units,
    /// A table from names to tables.
    NamedTables(&'static Table),
    /// A table.
    Table(&'static Table),
    /// A list of tables, not empty.
    Tables(&'static Table),
}

/// Domain of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// Any.
    Any,
    /// Greater than 0.
    Positive,
    /// 0 or greater.
    NotNegative,
}

impl Range {
    /// Whether `x` is in the domain.
    pub fn holds(self, x: f64) -> bool {
        x.is_finite()
            && match self {
                Self::Any => true,
                Self::Positive => x > 0.0,
                Self::NotNegative => x >= 0.0,
            }
    }

    /// As text, after "a".
    pub fn words(self) -> &'static str {
        match self {
            Self::Any => "finite number",
            Self::Positive => "positive finite number",
            Self::NotNegative => "finite number that is not negative",
        }
    }
}

impl Type {
    /// The expectation as text, after "expected".
    pub fn words(&self) -> String {
        let names = |choices: &[(&str, &str)]| {
            choices.iter().map(|(name, _)| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
        };
        match self {
            Self::Text | Self::Name => "a text".to_owned(),
            Self::Choice(choices) => format!("one of {}", names(choices)),
            Self::Switch => "true or false".to_owned(),
            Self::Number(range) => format!("a {}", range.words()),
            Self::Count(least) => format!("a whole number of at least {least}"),
            Self::Numbers(range) => format!("a list of numbers, each a {}", range.words()),
            Self::Texts | Self::Columns | Self::Names(_) => "a list of texts".to_owned(),
            Self::NameLists(least) => format!("a list of lists of {least} texts or more"),
            Self::Choices(choices) => format!("a list from {}", names(choices)),
            Self::Rows => "a matrix as a list of rows, [[1, 2], [3, 4]]".to_owned(),
            Self::Expressions => "a list of expressions, [\"x1^2\", \"x2\"]".to_owned(),
            Self::ExpressionRows => {
                "a matrix of expressions and numbers as a list of rows, [[-1, 0], [0, \"-u1\"]], or the list of a diagonal"
                    .to_owned()
            }
            Self::Weight => "a weight: a number, the list of a diagonal, or a matrix as a list of rows".to_owned(),
            Self::Covariance => {
                "a number, the list of a diagonal of numbers and expressions, or a matrix as a list of rows".to_owned()
            }
            Self::Poles => "a list of poles, numbers or pairs [re, im]".to_owned(),
            Self::Bounds => "a list of pairs [lower, upper]".to_owned(),
            Self::Bound => "a pair [lower, upper]".to_owned(),
            Self::Named => "a table from names to numbers, or expressions of others".to_owned(),
            Self::NamedBounds => "a table from names to pairs [lower, upper]".to_owned(),
            Self::Units => "a table from names to units, or the list of the units of the states".to_owned(),
            Self::NamedTables(table) => format!("a table from names to {}", table.name),
            Self::Table(table) => format!("{}, a table", table.name),
            Self::Tables(table) => format!("a list of tables, {}", table.name),
        }
    }
}

impl Table {
    /// The variant of that name.
    pub fn variant(&self, name: &str) -> Option<Variant> {
        (self.variants?.of)().into_iter().find(|variant| variant.name == name)
    }
}

/// A key that may be left out.
pub const fn optional(name: &'static str, value: Type, about: &'static str) -> Key {
    Key { name, value, required: false, about }
}

/// A key that has to be there.
pub const fn required(name: &'static str, value: Type, about: &'static str) -> Key {
    Key { name, value, required: true, about }
}
