//! One description of the members of an object, from which both reading and writing follow.
//!
//! ```text
//! members! { LinearConvergence {
//!     { plant: PlantWithin = "plant".part(); }
//!     "observer" { l = "L".matrix(plant.gain()); }
//!     "lyapunov" { p = "P".symmetric(plant.a.rows()); rate = "rate".rate(); }
//! } }
//! ```
//!
//! A line has the field of the struct, the name of the member, and the method of [`Field`](super::fields::Field) that
//! reads it; its arguments may use the fields above (whose type is named where they need it). `optional` before the
//! name is for a field that is an `Option`. Lines in braces behind a name are the members of an object, those in braces
//! without a name stand beside it. A part that depends on sizes from outside names them:
//! `members! { Vertex, order: usize { .. } }`.
//!
//! What is read becomes the struct, so that none of its fields can be forgotten, and what is written has the names and
//! the order of the same lines; [`Written`](super::write::Written) has one form for each type. The names of the members
//! are those of the labels of facts: see [`Names`](crate::label::Names).

use super::error::FileError;
use super::fields::Fields;
use super::write::Out;

/// The members of an object. Implemented by [`members!`], and by hand where the members depend on one another's values.
pub(super) trait Members<Sizes = ()>: Sized {
    /// The data, from the members of a file.
    fn read(file: &mut Fields<'_>, sizes: Sizes) -> Result<Self, FileError>;
    /// The data, as members of a file.
    fn write(&self) -> Vec<(&'static str, Out)>;
}

macro_rules! members {
    (@read $fields:ident, [], $body:block) => { $body };
    (@read $fields:ident, [$object:literal], $body:block) => { $fields.object($object, |$fields| Ok($body))? };
    (@member $fields:ident, [], $member:literal, $kind:ident($($argument:expr),*)) => {
        $fields.take($member)?.$kind($($argument),*)?
    };
    (@member $fields:ident, [optional], $member:literal, $kind:ident($($argument:expr),*)) => {
        match $fields.optional($member) {
            Some(field) => Some(field.$kind($($argument),*)?),
            None => None,
        }
    };
    (@write [], [$($lines:tt)*]) => { [$($lines)*].into_iter().flatten().collect::<Vec<_>>() };
    (@write [$object:literal], [$($lines:tt)*]) => {
        vec![($object, $crate::certificate::write::Out::Object([$($lines)*].into_iter().flatten().collect()))]
    };
    (@symmetric symmetric) => { true };
    (@symmetric $kind:ident) => { false };
    (@name [], $value:expr, $member:literal, $kind:ident, $names:ident) => {
        $crate::certificate::write::Written::name_in(&$value, $member, members!(@symmetric $kind), $names)
    };
    (@name [optional], $value:expr, $member:literal, $kind:ident, $names:ident) => {
        match &$value {
            Some(value) => members!(@name [], *value, $member, $kind, $names),
            None => $names,
        }
    };
    (@value [], $value:expr, $member:literal) => { Some(($member, $crate::certificate::write::Written::out(&$value))) };
    (@value [optional], $value:expr, $member:literal) => {
        $value.as_ref().map(|value| ($member, $crate::certificate::write::Written::out(value)))
    };
    ($name:ident { $($lines:tt)* }) => { members! { $name, (): () { $($lines)* } } };
    ($name:ident, $sizes:tt: $type:ty { $($($object:literal)? { $(
        $field:ident $(: $part:ty)? = $($optional:ident)? $member:literal.$kind:ident($($argument:expr),* $(,)?);
    )* })* }) => {
        impl $crate::certificate::members::Members<$type> for $name {
            fn read(
                fields: &mut $crate::certificate::fields::Fields<'_>,
                $sizes: $type,
            ) -> Result<Self, $crate::certificate::FileError> {
                $(let ($($field,)*) = members!(@read fields, [$($object)?], {
                    $(
                        let $field $(: $part)? =
                            members!(@member fields, [$($optional)?], $member, $kind($($argument),*));
                    )*
                    ($($field,)*)
                });)*
                Ok(Self { $($($field),*),* })
            }

            fn write(&self) -> Vec<(&'static str, $crate::certificate::write::Out)> {
                [$(members!(@write [$($object)?], [
                    $(members!(@value [$($optional)?], self.$field, $member)),*
                ])),*].into_iter().flatten().collect()
            }
        }

        impl $crate::certificate::write::Written for $name {
            fn out(&self) -> $crate::certificate::write::Out {
                $crate::certificate::write::Out::Object($crate::certificate::members::Members::<$type>::write(self))
            }

            fn name_in<'a>(
                &'a self,
                _: &'static str,
                _: bool,
                names: $crate::label::Names<'a>,
            ) -> $crate::label::Names<'a> {
                $($(let names = members!(@name [$($optional)?], self.$field, $member, $kind, names);)*)*
                names
            }
        }
    };
}

pub(super) use members;
