//! The numbers of each observer, stated once: a list of its matrices and numbers, and how its constructor takes them.
//!
//! From the list follow the observer over another scalar and with other sizes (`map`, `cast`, `to_static`; feature
//! `alloc`, see the head of `static_size.rs`) and its form in files (feature `serde`; see the head of
//! `serialization/mod.rs`). The constructor is called in both, so that what it checks is checked of rounded numbers and
//! of those of a file. Its text has a line for each number.
//!
//! A line of a list is `key: kind = value`, where `value` reads it from the observer `o`; the keys are the variables of
//! the constructor's call, and the names in files, in this order. Documentation before a list is that of `to_static`.
//! Kinds:
//!
//! | kind | value | in a file |
//! |---|---|---|
//! | `matrix(A)` | the matrix [`MatrixName::A`](crate::MatrixName::A), called so in errors | its rows |
//! | `maybe(D)` | a matrix, or none | its rows, or nothing |
//! | `number` | a number of the scalar | a number |
//! | `maybe_number` | one, or none | a number, or nothing |
//! | `plain(usize)` | a value that does not depend on the scalar | the value |
//! | `option(usize)` | one, or none | the value, or nothing |
//! | `whole(Form)` | another observer, whose form is this | its form |

use core::fmt::{self, Display, Formatter};

use luenberger_plants::text::write_matrix;
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, RealField};

/// What is done with a number of each kind.
macro_rules! number {
    // Its type in a file.
    (type matrix $name:ident) => { Rows<T> };
    (type maybe $name:ident) => { Option<Rows<T>> };
    (type number) => { T };
    (type maybe_number) => { Option<T> };
    (type plain $type:ty) => { $type };
    (type option $type:ty) => { Option<$type> };
    (type whole $form:ident) => { $form<T> };
    // What a file has of it, if anything.
    (write matrix $value:expr) => { Some(rows($value)) };
    (write maybe $value:expr) => { $value.map(rows) };
    (write maybe_number $value:expr) => { $value };
    (write option $value:expr) => { $value };
    (write $kind:ident $value:expr) => { Some($value) };
    // Itself, of a file.
    (read matrix $value:expr, $name:ident) => { matrix(crate::MatrixName::$name.text(), &$value)? };
    (read maybe $value:expr, $name:ident) => { $value.map(|rows| matrix(crate::MatrixName::$name.text(), &rows)).transpose()? };
    (read whole $value:expr, $form:ident) => { $value.observer()? };
    (read $kind:ident $value:expr $(, $type:ty)?) => { $value };
    // Itself, over another scalar.
    (map matrix $value:expr, $f:ident, $name:ident) => {
        sized(crate::MatrixName::$name.text(), &$f(crate::MatrixName::$name, &dynamic($value)))?
    };
    (map maybe $value:expr, $f:ident, $name:ident) => {
        $value
            .map(|value| sized(crate::MatrixName::$name.text(), &$f(crate::MatrixName::$name, &dynamic(value))))
            .transpose()?
    };
    (map number $value:expr, $f:ident) => { nalgebra::convert($value) };
    (map maybe_number $value:expr, $f:ident) => { $value.map(nalgebra::convert::<f64, T>) };
    (map whole $value:expr, $f:ident, $form:ident) => { $value.map(&mut $f)? };
    (map $kind:ident $value:expr, $f:ident, $type:ty) => { $value };
    // Itself, in a line of text.
    (show matrix $value:expr, $lines:ident, $key:ident, $name:ident) => { $lines.matrix(crate::MatrixName::$name.text(), $value)? };
    (show maybe $value:expr, $lines:ident, $key:ident, $name:ident) => {
        $value.map_or(Ok(()), |value| $lines.matrix(crate::MatrixName::$name.text(), value))?
    };
    (show number $value:expr, $lines:ident, $key:ident) => { $lines.number(stringify!($key), &$value)? };
    (show whole $value:expr, $lines:ident, $key:ident, $form:ident) => { $lines.whole($value)? };
}

/// The text of an observer, line by line.
struct Lines<'a, 'b> {
    f: &'a mut Formatter<'b>,
    /// What stands before the next line.
    before: &'static str,
}

impl Lines<'_, '_> {
    fn next(&mut self) -> fmt::Result {
        let before = core::mem::replace(&mut self.before, "\n");
        self.f.write_str(before)
    }

    /// A matrix, if it has entries.
    fn matrix<T: RealField + Copy, R: Dim, C: Dim>(&mut self, name: &str, m: &OMatrix<T, R, C>) -> fmt::Result
    where
        DefaultAllocator: Allocator<R, C>,
    {
        if m.is_empty() {
            return Ok(());
        }
        self.next()?;
        write_matrix(self.f, name, m)
    }

    fn number(&mut self, name: &str, value: &impl Display) -> fmt::Result {
        self.next()?;
        write!(self.f, "{name} = ")?;
        value.fmt(self.f)
    }

    fn whole(&mut self, observer: &impl Display) -> fmt::Result {
        self.next()?;
        observer.fmt(self.f)
    }
}

/// A size that is known at run time, for each size.
#[cfg(feature = "alloc")]
macro_rules! at_run_time {
    ($size:ident) => {
        Dyn
    };
}

/// Writes a form; what a file does not have is `None`.
#[cfg(feature = "serde")]
macro_rules! written {
    ($serializer:expr, $form:ident, $($key:ident = $value:expr),+) => {{
        $(let $key = $value;)+
        let count = [$($key.is_some()),+].into_iter().filter(|is_there| *is_there).count();
        let mut form = $serializer.serialize_struct(stringify!($form), count)?;
        $(match &$key {
            Some(value) => form.serialize_field(stringify!($key), value)?,
            None => form.skip_field(stringify!($key))?,
        })+
        form.end()
    }};
}

/// What follows from the list of an observer of matrices alone: `Form<N, M, P> where Size<N, M, P>` are its sizes.
macro_rules! numbers {
    ($(
        $(#[$doc:meta])*
        $observer:ident as $form:ident<$($size:ident),+> where $($bound:path),+;
        |$o:ident| { $($key:ident: $kind:ident $(($argument:tt))? = $value:expr),+ $(,)? }
        $build:expr;
    )+) => {$(
        /// The matrices and numbers, a line each.
        impl<T: RealField + Copy, $($size: Dim),+> Display for $observer<T, $($size),+>
        where
            DefaultAllocator: $($bound +)+,
        {
            fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
                let $o = self;
                let mut lines = Lines { f, before: "" };
                $(number!(show $kind $value, lines, $key $(, $argument)?);)+
                Ok(())
            }
        }

        #[cfg(feature = "alloc")]
        impl $observer<f64, $(at_run_time!($size)),+> {
            /// The same observer over the scalar `T` and with these sizes, of matrices that `f` makes of its own, whose
            /// names it is given. Other numbers are rounded to the nearest of `T`.
            ///
            /// # Errors
            /// [`ObserverError::Matrix`] for matrices of other sizes; those of the constructor.
            pub fn map<T: RealField + Copy, $($size: Dim),+>(
                &self,
                mut f: impl FnMut(crate::MatrixName, &DMatrix<f64>) -> DMatrix<T>,
            ) -> Result<$observer<T, $($size),+>, ObserverError>
            where
                DefaultAllocator: $($bound +)+,
            {
                let $o = self;
                $(let $key = number!(map $kind $value, f $(, $argument)?);)+
                $build
            }

            /// The same observer over the scalar `T`.
            ///
            /// # Errors
            /// [`ObserverError::Matrix`] for an entry beyond the range of `T`; those of the constructor.
            pub fn cast<T: RealField + Copy>(
                &self,
            ) -> Result<$observer<T, $(at_run_time!($size)),+>, ObserverError> {
                self.map(rounded)
            }

            /// The same observer with sizes known at compile time, over the scalar `T`; see the
            /// [module](crate::static_size).
            $(#[$doc])*
            ///
            /// # Errors
            /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`; those of the
            /// constructor for what rounding may destroy.
            pub fn to_static<T: RealField + Copy, $(const $size: usize),+>(
                &self,
            ) -> Result<$observer<T, $(Const<$size>),+>, ObserverError> {
                self.map::<T, $(Const<$size>),+>(rounded)
            }
        }

        #[cfg(feature = "serde")]
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields, bound = "T: Deserialize<'de>")]
        struct $form<T> {
            $($key: number!(type $kind $($argument)?),)+
        }

        #[cfg(feature = "serde")]
        impl<T: RealField + Copy> $form<T> {
            fn observer<$($size: Dim),+>(self) -> Result<$observer<T, $($size),+>, ObserverError>
            where
                DefaultAllocator: $($bound +)+,
            {
                $(let $key = number!(read $kind self.$key $(, $argument)?);)+
                $build
            }
        }

        #[cfg(feature = "serde")]
        impl<T: RealField + Copy + Serialize, $($size: Dim),+> Serialize for $observer<T, $($size),+>
        where
            DefaultAllocator: $($bound +)+,
        {
            fn serialize<W: Serializer>(&self, serializer: W) -> Result<W::Ok, W::Error> {
                let $o = self;
                written!(serializer, $form, $($key = number!(write $kind $value)),+)
            }
        }

        #[cfg(feature = "serde")]
        impl<'de, T: RealField + Copy + Deserialize<'de>, $($size: Dim),+> Deserialize<'de>
            for $observer<T, $($size),+>
        where
            DefaultAllocator: $($bound +)+,
        {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                $form::<T>::deserialize(deserializer)?.observer().map_err(D::Error::custom)
            }
        }
    )+};
}

/// What follows from the list of an observer of a plant of the user's, which is given over the scalar of the target:
/// `Form where S: Bound` are its plants, `designed` its numbers of states and outputs.
#[cfg(feature = "alloc")]
macro_rules! numbers_of_plant {
    ($(
        $(#[$doc:meta])*
        $observer:ident as $form:ident where S: $bound:ident;
        |$o:ident, $plant:ident| { $($key:ident: $kind:ident $(($argument:tt))? = $value:expr),+ $(,)? }
        designed $designed:expr;
        $build:expr;
    )+) => {$(
        impl<S, N0: Dim, M0: Dim, P0: Dim> $observer<S, f64, N0, M0, P0>
        where
            S: $bound<f64, N0, M0, P0>,
            DefaultAllocator: Size<N0, M0, P0>,
        {
            /// The same observer of `plant`, which is the plant of this one over the scalar `T`, with these sizes, of
            /// matrices that `f` makes of its own, whose names it is given. Other numbers are rounded to the nearest of
            /// `T`.
            ///
            /// # Errors
            /// [`ObserverError::Matrix`] for matrices of other sizes; those of the constructor.
            pub fn map<T: RealField + Copy, N: Dim, M: Dim, P: Dim, Q>(
                &self,
                $plant: Q,
                mut f: impl FnMut(crate::MatrixName, &DMatrix<f64>) -> DMatrix<T>,
            ) -> Result<$observer<Q, T, N, M, P>, ObserverError>
            where
                Q: $bound<T, N, M, P>,
                DefaultAllocator: Size<N, M, P>,
            {
                let $o = self;
                $(let $key = number!(map $kind $value, f $(, $argument)?);)+
                $build
            }

            /// The same observer of `plant`, which is the plant of this one over the scalar `T`.
            ///
            /// # Errors
            /// [`ObserverError::Matrix`] for an entry beyond the range of `T`; those of the constructor.
            pub fn cast<T: RealField + Copy, Q>(&self, plant: Q) -> Result<$observer<Q, T, N0, M0, P0>, ObserverError>
            where
                Q: $bound<T, N0, M0, P0>,
            {
                self.map(plant, rounded)
            }

            /// The same observer of `plant`, which is the plant of this one over the scalar `T`, with N states, M
            /// inputs and P outputs; see the [module](crate::static_size).
            $(#[$doc])*
            ///
            /// # Errors
            /// [`ObserverError::Matrix`] for other sizes of the plant or of the matrices, and for an entry beyond the
            /// range of `T`; those of the constructor for what rounding may destroy.
            pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize, Q>(
                &self,
                plant: Q,
            ) -> Result<$observer<Q, T, Const<N>, Const<M>, Const<P>>, ObserverError>
            where
                Q: $bound<T, Const<N>, Const<M>, Const<P>>,
            {
                let $o = self;
                same_sizes::<N, M, P>(plant.dimensions(), $designed)?;
                self.map::<T, Const<N>, Const<M>, Const<P>, Q>(plant, rounded)
            }
        }

        #[cfg(feature = "serde")]
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields, bound = "S: Deserialize<'de>, T: Deserialize<'de>")]
        struct $form<S, T> {
            plant: S,
            $($key: number!(type $kind $($argument)?),)+
        }

        #[cfg(feature = "serde")]
        impl<S, T: RealField + Copy> $form<S, T> {
            fn observer<N: Dim, M: Dim, P: Dim>(self) -> Result<$observer<S, T, N, M, P>, ObserverError>
            where
                S: $bound<T, N, M, P>,
                DefaultAllocator: Size<N, M, P>,
            {
                let $plant = self.plant;
                $(let $key = number!(read $kind self.$key $(, $argument)?);)+
                $build
            }
        }

        #[cfg(feature = "serde")]
        impl<S, T: RealField + Copy + Serialize, N: Dim, M: Dim, P: Dim> Serialize for $observer<S, T, N, M, P>
        where
            S: $bound<T, N, M, P> + Serialize,
            DefaultAllocator: Size<N, M, P>,
        {
            fn serialize<W: Serializer>(&self, serializer: W) -> Result<W::Ok, W::Error> {
                let $o = self;
                written!(serializer, $form, $plant = Some($o.plant()), $($key = number!(write $kind $value)),+)
            }
        }

        #[cfg(feature = "serde")]
        impl<'de, S, T: RealField + Copy + Deserialize<'de>, N: Dim, M: Dim, P: Dim> Deserialize<'de>
            for $observer<S, T, N, M, P>
        where
            S: $bound<T, N, M, P> + Deserialize<'de>,
            DefaultAllocator: Size<N, M, P>,
        {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                $form::<S, T>::deserialize(deserializer)?.observer().map_err(D::Error::custom)
            }
        }
    )+};
}

mod of_matrices;
#[cfg(feature = "alloc")]
mod of_plant;

#[cfg(feature = "alloc")]
pub use of_plant::SizedPlant;
