//! The kinds of observers of a study, with their specifications.

use crate::keys::{Range, Table, Type, Variant, Variants, optional};
use crate::kinds::{Declaration, registry};

/// `[[observer]]`.
pub(crate) const OBSERVER: Table = Table {
    name: "[[observer]]",
    about: "An observer and its specification.",
    keys: &[
        optional("name", Type::Name, "Name in figures, tables and file names (default: its kind)."),
        optional(
            "initial",
            Type::Numbers(Range::Any),
            "Initial estimate, n numbers (default: the operating point, if there is one, or else 0).",
        ),
    ],
    variants: Some(Variants { tag: "kind", of: kinds }),
};

/// The kinds, in the order of the registry.
fn kinds() -> Vec<Variant> {
    let variant = |kind: &Declaration| Variant { name: kind.name, about: kind.about, keys: kind.keys };
    registry().into_iter().map(variant).collect()
}
