//! The settings of a kind from one declaration of its keys: their list, the fields, and the reader.

use luenberger_design::Region;
use luenberger_plants::Dimensions;
use luenberger_proof::wording::counted;
use nalgebra::DMatrix;

use crate::keys::{Key, Type, optional};
use crate::reader::tree::Node;
use crate::reader::{Given, Reader, gain, region};

/// Declares the keys of a kind of observer, once: a struct whose fields are the keys, with
///
/// - `KEYS`, their list with types and sentences, of which schema, help and messages are made;
/// - `read`, which collects the mistakes of all keys with their positions, and gives the struct where there are none.
///
/// ```
/// use luenberger_study::keys;
/// use nalgebra::DMatrix;
///
/// keys! { |size|
///     /// Settings of an observer.
///     #[derive(Debug, Clone)]
///     pub struct Settings {
///         /// Sampling period.
///         period: f64 as Number(Positive),
///         /// A gain L, n x p (default: found by the design).
///         gain: Option<DMatrix<f64>>[n, p] as Rows,
///         /// Weights of the states, n numbers (default 1).
///         weights: Vec<f64>[n] as Numbers(Positive) = vec![1.0; size.states],
///     }
/// }
/// assert_eq!(Settings::KEYS.iter().map(|key| (key.name, key.required)).collect::<Vec<_>>(), [
///     ("period", true), ("gain", false), ("weights", false)
/// ]);
/// assert_eq!(Settings::KEYS[1].about, "A gain L, n x p (default: found by the design).");
/// ```
///
/// A line is the sentence of the key, its name, the type of its field, the numbers of entries of the value (n, m and p
/// are those of states, inputs and outputs, `_` is any) and the `Type` of the value in the file.
/// A key without default (`= ..`) is required unless its field is an `Option`. In place of a type stands
///
/// - `&KEY` for a key that other kinds have too;
/// - `[GROUPS]` for the keys that a field is read from together, with the function that reads them;
/// - `Choice` for a field of [`Words`](crate::kinds::Words).
///
/// `=> function` reads a value in another way: from the key, the table and the reader, or for groups from the last two.
/// The fields before it are in scope, as an `Option`. Behind the last field stand, as `..[GROUPS]`, the keys that are
/// read with those of all observers, such as `max_gain`. `|size|` names the sizes of the plant for defaults.
#[macro_export]
macro_rules! keys {
    (
        $(|$plant:ident|)?
        $(#[$meta:meta])*
        $vis:vis struct $name:ident {
            $(
                $(#[doc = $about:literal])*
                $field:ident: $type:ty $([$($size:tt),+])?
                    as $(&$shared:ident)? $([$($group:expr),+])? $($kind:ident $(($($argument:tt)*))?)?
                    $(= $default:expr)? $(=> $read:expr)?,
            )*
            $(..[$($elsewhere:expr),+])?
        }
    ) => {
        $(#[$meta])*
        $vis struct $name {
            $($(#[doc = $about])* $vis $field: $type,)*
        }

        impl $name {
            const GROUPS: &'static [&'static [&'static [$crate::kinds::Key]]] = {
                #[allow(unused_imports, reason = "a kind may have keys without a range, or of no type but its own")]
                use $crate::kinds::{Range::*, Type::*};
                &[
                    $($crate::keys!(
                        @groups [$($about),*] $field: $type;
                        $(&$shared)? $([$($group),+])? $($kind $(($($argument)*))?)? $(= $default)?
                    ),)*
                    $(&[$($elsewhere),+])?
                ]
            };

            /// The keys, in their order.
            $vis const KEYS: &'static [$crate::kinds::Key] =
                &$crate::kinds::flat::<{ $crate::kinds::count($name::GROUPS) }>($name::GROUPS);

            /// The values; none after a mistake, which the reader has.
            #[allow(dead_code, reason = "a kind may read its keys in another way")]
            $vis fn read(
                given: &$crate::kinds::Given<'_>,
                reader: &mut $crate::kinds::Reader,
            ) -> Option<Self> {
                $(let $plant = given.size();)?
                $(
                    let $field: Option<$type> = $crate::keys!(
                        @read (given, reader, $name),
                        $field: $type [$($($size),+)?] $(&$shared)? $([$($group),+])? $($kind)?
                            $(= $default)? $(=> $read)?
                    );
                )*
                Some(Self { $($field: $field?,)* })
            }
        }
    };

    (@groups $about:tt $field:ident: $type:ty; &$shared:ident $(= $default:expr)?) => { &[&[$shared]] };
    (@groups $about:tt $field:ident: $type:ty; [$($group:expr),+]) => { &[$($group),+] };
    (@groups [$($about:literal),+] $field:ident: $type:ty;
        $kind:ident $(($($argument:tt)*))? $(= $default:expr)?) => {
        &[&[$crate::kinds::Key {
            name: stringify!($field),
            value: $crate::keys!(@kind $type, $kind $(($($argument)*))?),
            required: $crate::keys!(@required $type $(, $default)?),
            about: concat!($($about),+).trim_ascii(),
        }]]
    };

    (@kind $type:ty, Choice) => { $crate::kinds::Type::Choice(<$type as $crate::kinds::Words>::WORDS) };
    (@kind $type:ty, $kind:ident) => { $kind };
    (@kind $type:ty, $kind:ident ($($argument:tt)*)) => { $kind($($argument)*) };

    (@required $type:ty) => { <$type as $crate::kinds::KeyValue>::REQUIRED };
    (@required $type:ty, $default:expr) => { false };

    (@size n) => { $crate::kinds::Size::States };
    (@size m) => { $crate::kinds::Size::Inputs };
    (@size p) => { $crate::kinds::Size::Outputs };
    (@size _) => { $crate::kinds::Size::Any };

    // A group; a key by a function; a key.
    (@read ($given:ident, $reader:ident, $name:ident),
        $field:ident: $type:ty [] [$($group:expr),+] => $read:expr) => { $crate::kinds::by_keys($read, $given, $reader) };
    (@read ($given:ident, $reader:ident, $name:ident),
        $field:ident: $type:ty [] &$shared:ident => $read:expr) => {
        $crate::kinds::by_key($read, &$shared, $given, $reader)
    };
    (@read ($given:ident, $reader:ident, $name:ident),
        $field:ident: $type:ty [] $kind:ident => $read:expr) => {
        $crate::kinds::by_key($read, $crate::kinds::of_name($name::KEYS, stringify!($field)), $given, $reader)
    };
    (@read $within:tt, $field:ident: $type:ty [$($size:tt),*] &$shared:ident $(= $default:expr)?) => {
        $crate::keys!(@value $within, &$shared, [$($size),*] $(= $default)?)
    };
    (@read ($given:ident, $reader:ident, $name:ident),
        $field:ident: $type:ty [$($size:tt),*] $kind:ident $(= $default:expr)?) => {
        $crate::keys!(
            @value ($given, $reader, $name),
            $crate::kinds::of_name($name::KEYS, stringify!($field)), [$($size),*] $(= $default)?
        )
    };
    (@value ($given:ident, $reader:ident, $name:ident), $key:expr, [$($size:tt),*]) => {
        $crate::kinds::value($key, &[$($crate::keys!(@size $size)),*], None, $given, $reader)
    };
    (@value ($given:ident, $reader:ident, $name:ident), $key:expr, [$($size:tt),*] = $default:expr) => {
        $crate::kinds::value($key, &[$($crate::keys!(@size $size)),*], Some($default), $given, $reader)
    };
}

/// The values of a key that is one of some words: each with its sentence, `Modal = "modal"`.
#[macro_export]
macro_rules! words {
    ($type:ident { $($(#[doc = $about:literal])* $value:ident = $word:literal,)+ }) => {
        impl $crate::kinds::Words for $type {
            const WORDS: &'static [(&'static str, &'static str)] =
                &[$(($word, concat!($($about),*).trim_ascii())),+];

            fn of_word(word: &str) -> Option<Self> {
                match word {
                    $($word => Some(Self::$value),)+
                    _ => None,
                }
            }
        }

        impl $crate::kinds::KeyValue for $type {
            fn read(of: $crate::kinds::Present<'_>, _reader: &mut $crate::kinds::Reader) -> Option<Self> {
                of.word()
            }
        }
    };
}

/// A size of the plant by which the entries of a value are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// n.
    States,
    /// m.
    Inputs,
    /// p.
    Outputs,
    /// Any number.
    Any,
}

impl Size {
    /// The number with what is counted; none for any.
    fn counted(self, plant: Dimensions) -> Option<(usize, &'static str)> {
        match self {
            Self::States => Some((plant.states, "state")),
            Self::Inputs => Some((plant.inputs, "input")),
            Self::Outputs => Some((plant.outputs, "output")),
            Self::Any => None,
        }
    }
}

/// A key that is in the file, with what its value is read by.
#[derive(Debug, Clone, Copy)]
pub struct Present<'a> {
    pub(super) key: &'a Key,
    pub(super) node: &'a Node,
    sizes: &'a [Size],
    pub(super) given: &'a Given<'a>,
}

impl Present<'_> {
    /// What its word stands for.
    pub fn word<W: Words>(&self) -> Option<W> {
        W::of_word(self.node.text()?)
    }

    /// The number of entries along an axis.
    fn count(&self, axis: usize) -> Option<(usize, &'static str)> {
        self.sizes.get(axis)?.counted(self.given.size())
    }

    /// "the plant has 2 states and 1 output".
    fn why(&self) -> String {
        let mut sizes: Vec<String> = Vec::new();
        for (count, of) in (0..self.sizes.len()).filter_map(|axis| self.count(axis)) {
            let words = counted(count, of);
            if !sizes.contains(&words) {
                sizes.push(words);
            }
        }
        format!("the plant has {}", sizes.join(" and "))
    }
}

/// A value of a key.
pub trait KeyValue: Sized {
    /// Whether the key has to be there, if it has no default.
    const REQUIRED: bool = true;

    /// The value; none if it is wrong, which the reader has then.
    fn read(of: Present<'_>, reader: &mut Reader) -> Option<Self>;

    /// The value without the key.
    fn absent() -> Option<Self> {
        None
    }
}

impl<T: KeyValue> KeyValue for Option<T> {
    const REQUIRED: bool = false;

    fn read(of: Present<'_>, reader: &mut Reader) -> Option<Self> {
        T::read(of, reader).map(Some)
    }

    fn absent() -> Option<Self> {
        Some(None)
    }
}

/// One of some words.
pub trait Words: Sized {
    /// The words, each with its sentence.
    const WORDS: &'static [(&'static str, &'static str)];

    /// The value that a word stands for.
    fn of_word(word: &str) -> Option<Self>;
}

impl<T: Words> Words for Option<T> {
    const WORDS: &'static [(&'static str, &'static str)] = T::WORDS;

    fn of_word(word: &str) -> Option<Self> {
        T::of_word(word).map(Some)
    }
}

/// Values that are read without sizes.
macro_rules! values {
    ($($type:ty: $read:expr,)*) => {
        $(impl KeyValue for $type {
            fn read(of: Present<'_>, _reader: &mut Reader) -> Option<Self> {
                $read(of.node)
            }
        })*
    };
}

values! { f64: Node::number, usize: Node::count, bool: Node::truth, (f64, f64): region::bound, }

impl KeyValue for Vec<f64> {
    fn read(of: Present<'_>, reader: &mut Reader) -> Option<Self> {
        match of.count(0) {
            Some((length, what)) => reader.numbers(of.node, of.key.name, length, what),
            None => of.node.numbers(),
        }
    }
}

impl KeyValue for DMatrix<f64> {
    fn read(of: Present<'_>, reader: &mut Reader) -> Option<Self> {
        let [rows, columns] = [0, 1].map(|axis| of.count(axis).map(|(count, _)| count));
        match (&of.key.value, rows) {
            (Type::Weight, Some(order)) => reader.weight(of.node, of.key.name, order, &of.why()),
            _ => reader.matrix(of.node, of.key.name, (rows, columns), &of.why()),
        }
    }
}

impl KeyValue for Vec<(f64, f64)> {
    fn read(of: Present<'_>, reader: &mut Reader) -> Option<Self> {
        let (length, what) = of.count(0)?;
        region::bounds(of.node, of.key.name, length, what, reader)
    }
}

impl KeyValue for Region {
    fn read(of: Present<'_>, reader: &mut Reader) -> Option<Self> {
        region::of_table(of.node, of.given.size(), reader)
    }
}

/// The list without its entries where the groups are one after the other.
const NO_KEY: Key = optional("", Type::Switch, "");

/// The number of keys.
#[doc(hidden)]
pub const fn count(fields: &[&[&[Key]]]) -> usize {
    let (mut count, mut field) = (0, 0);
    while field < fields.len() {
        let mut group = 0;
        while group < fields[field].len() {
            count += fields[field][group].len();
            group += 1;
        }
        field += 1;
    }
    count
}

/// The keys of all groups of all fields, which are `N`.
#[doc(hidden)]
pub const fn flat<const N: usize>(fields: &[&[&[Key]]]) -> [Key; N] {
    let mut all = [NO_KEY; N];
    let (mut next, mut field, mut group, mut key) = (0, 0, 0, 0);
    while field < fields.len() {
        if group == fields[field].len() {
            (field, group) = (field + 1, 0);
        } else if key == fields[field][group].len() {
            (group, key) = (group + 1, 0);
        } else {
            all[next] = fields[field][group][key];
            (next, key) = (next + 1, key + 1);
        }
    }
    all
}

/// The key of this name, which is there.
#[doc(hidden)]
pub fn of_name<'a>(keys: &'a [Key], name: &str) -> &'a Key {
    keys.iter().find(|key| key.name == name).unwrap_or(&NO_KEY)
}

/// The value of a key; that without it is `otherwise`, if there is one, or else that of its type.
#[doc(hidden)]
pub fn value<T: KeyValue>(
    key: &Key,
    sizes: &[Size],
    otherwise: Option<T>,
    given: &Given<'_>,
    reader: &mut Reader,
) -> Option<T> {
    match given.node.get(key.name) {
        Some(node) => T::read(Present { key, node, sizes, given }, reader),
        None => otherwise.or_else(T::absent),
    }
}

/// What a function reads from the table. A closure that is an argument here needs no types of its own.
#[doc(hidden)]
pub fn by_keys<T>(
    read: impl FnOnce(&Given<'_>, &mut Reader) -> Option<T>,
    given: &Given<'_>,
    reader: &mut Reader,
) -> Option<T> {
    read(given, reader)
}

/// What a function reads from a key.
#[doc(hidden)]
pub fn by_key<T>(
    read: impl FnOnce(&Key, &Given<'_>, &mut Reader) -> Option<T>,
    key: &Key,
    given: &Given<'_>,
    reader: &mut Reader,
) -> Option<T> {
    read(key, given, reader)
}

/// That at most one of these keys is there, or exactly one where one is `needed`.
pub(super) fn one_of(keys: &[Key], given: &Given<'_>, needed: bool, reader: &mut Reader) -> Option<()> {
    let names: Vec<&str> = keys.iter().map(|key| key.name).collect();
    gain::alternatives(given.node, &names, needed, reader)
}
