//! Typed serde readers that report each mistake with its position in the text.

use luenberger_proof::wording::entry;
use luenberger_study::nearest;
use nalgebra::{Complex, DMatrix};
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// The matrices of a document, and its poles; no poles without a key for them.
pub(super) type Found<const N: usize> = ([Option<DMatrix<f64>>; N], Vec<Complex<f64>>);

/// Keys of the matrices of one problem, of which the first `required` must be present.
pub(crate) struct Form<'a> {
    pub(crate) keys: &'a [&'static str],
    pub(crate) required: usize,
}

/// Reads an object with the matrices of exactly one of the forms, and a list of poles if `poles` names a key.
///
/// `keys` are those of all forms. Two forms are told apart by the first key of each that the other does not have; it is
/// required.
pub(super) struct Document<'a, const N: usize> {
    pub(super) keys: [&'static str; N],
    pub(super) forms: &'a [Form<'a>],
    pub(super) poles: Option<&'static str>,
}

impl<const N: usize> Document<'_, N> {
    fn known(&self) -> impl Iterator<Item = &'static str> {
        self.keys.into_iter().chain(self.poles)
    }

    /// The keys of a form as a list for messages.
    fn keys_of(&self, form: &Form<'_>) -> String {
        form.keys.iter().copied().chain(self.poles).map(|key| format!("{key:?}")).collect::<Vec<_>>().join(", ")
    }

    /// The keys of every form.
    fn list(&self) -> String {
        self.forms.iter().map(|form| self.keys_of(form)).collect::<Vec<_>>().join(" or ")
    }

    fn unknown(&self, key: &str) -> String {
        let near = nearest(key, self.known());
        let key: String = key.chars().take(40).collect();
        let list = self.list();
        match near {
            Some(near) => format!("the key {key:?} is unknown; did you mean {near:?}? (known: {list})"),
            None => format!("the key {key:?} is unknown (known: {list})"),
        }
    }

    /// The first key of a form that not all forms have; none if there is one form only.
    fn mark(&self, form: &Form<'_>) -> Option<&'static str> {
        form.keys.iter().copied().find(|key| self.forms.iter().any(|other| !other.keys.contains(key)))
    }

    /// Checks that the keys are those of exactly one form.
    fn check(&self, is_given: impl Fn(&'static str) -> bool) -> Result<(), String> {
        let missing =
            |form: &Form<'_>| form.keys[..form.required].iter().copied().chain(self.poles).find(|k| !is_given(k));
        let marks: Vec<_> = self.forms.iter().filter_map(|form| self.mark(form)).collect();
        let given: Vec<_> = marks.iter().copied().filter(|mark| is_given(mark)).collect();
        let quoted = |keys: &[&str], word| keys.iter().map(|key| format!("{key:?}")).collect::<Vec<_>>().join(word);
        if given.len() > 1 {
            let (given, list) = (quoted(&given, " and "), self.list());
            return Err(format!("the keys {given} exclude each other (known: {list})"));
        }
        let chosen = self.forms.iter().find(|form| self.mark(form).is_none_or(|mark| given.contains(&mark)));
        let Some(form) = chosen else {
            let first = missing(&self.forms[0]).filter(|key| !marks.contains(key)).map(|key| format!("{key:?}"));
            let (missing, list) = (first.unwrap_or_else(|| quoted(&marks, " or ")), self.list());
            return Err(format!("the key {missing} is missing (known: {list})"));
        };
        let list = self.keys_of(form);
        if let (Some(foreign), [mark]) =
            (self.keys.into_iter().find(|k| is_given(k) && !form.keys.contains(k)), &given[..])
        {
            return Err(format!(
                "the key {foreign:?} does not belong to the problem with {mark:?}, whose keys are {list}"
            ));
        }
        missing(form).map_or(Ok(()), |missing| Err(format!("the key {missing:?} is missing (known: {list})")))
    }
}

impl<'de, const N: usize> DeserializeSeed<'de> for Document<'_, N> {
    type Value = Found<N>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de, const N: usize> Visitor<'de> for Document<'_, N> {
    type Value = Found<N>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "an object with the keys {}", self.list())
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Self::Value, M::Error> {
        let mut matrices = [const { None }; N];
        let mut poles = None;
        while let Some(key) = map.next_key::<String>()? {
            let again = || M::Error::custom(format!("the key {key:?} occurs twice"));
            if let Some(place) = self.keys.iter().position(|known| *known == key) {
                if matrices[place].is_some() {
                    return Err(again());
                }
                matrices[place] = Some(map.next_value_seed(Matrix { name: self.keys[place] })?);
            } else if self.poles.is_some_and(|known| known == key) {
                if poles.is_some() {
                    return Err(again());
                }
                poles = Some(map.next_value_seed(Poles)?);
            } else {
                return Err(M::Error::custom(self.unknown(&key)));
            }
        }
        let is_given = |key| match self.keys.iter().position(|known| *known == key) {
            Some(place) => matrices[place].is_some(),
            None => poles.is_some(),
        };
        self.check(is_given).map_err(M::Error::custom)?;
        Ok((matrices, poles.unwrap_or_default()))
    }
}

/// A list of rows of equal length.
struct Matrix {
    name: &'static str,
}

impl<'de> DeserializeSeed<'de> for Matrix {
    type Value = DMatrix<f64>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Matrix {
    type Value = DMatrix<f64>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the matrix {:?} as a list of its rows, such as [[1, 2], [3, 4]] or [[1]]", self.name)
    }

    fn visit_seq<S: SeqAccess<'de>>(self, mut rows: S) -> Result<Self::Value, S::Error> {
        let name = self.name;
        let (mut entries, mut columns, mut count) = (Vec::new(), 0, 0);
        while let Some(length) = rows.next_element_seed(Row { name, index: count, entries: &mut entries })? {
            if count == 0 {
                columns = length;
            } else if length != columns {
                return Err(S::Error::custom(format!(
                    "row {} of the matrix {name:?} has length {length}, and row 1 has length {columns}",
                    count + 1
                )));
            }
            count += 1;
        }
        if entries.is_empty() {
            return Err(S::Error::custom(format!("the matrix {name:?} is empty ({count} x {columns})")));
        }
        Ok(DMatrix::from_row_slice(count, columns, &entries))
    }
}

/// One row, whose entries are appended to the vector; returns its length.
struct Row<'a> {
    name: &'static str,
    index: usize,
    entries: &'a mut Vec<f64>,
}

impl<'de> DeserializeSeed<'de> for Row<'_> {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Row<'_> {
    type Value = usize;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "row {} of the matrix {:?} as a list (a column is [[1], [2]], a row is [[1, 2]])",
            self.index + 1,
            self.name
        )
    }

    fn visit_seq<S: SeqAccess<'de>>(self, mut entries: S) -> Result<usize, S::Error> {
        let before = self.entries.len();
        loop {
            let column = self.entries.len() - before;
            let Some(entry) = entries.next_element_seed(Number::entry(self.name, self.index, column))? else {
                return Ok(column);
            };
            self.entries.push(entry);
        }
    }
}

/// One number, with a description of its position.
struct Number<'a> {
    what: &'a str,
    indices: Option<(usize, usize)>,
}

impl<'a> Number<'a> {
    fn entry(name: &'a str, row: usize, column: usize) -> Self {
        Self { what: name, indices: Some((row, column)) }
    }
}

impl<'de> DeserializeSeed<'de> for Number<'_> {
    type Value = f64;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<f64, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl Visitor<'_> for Number<'_> {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.indices {
            Some((row, column)) => write!(f, "a number for {}{}", self.what, entry(row, column)),
            None => write!(f, "{}", self.what),
        }
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<f64, E> {
        if value.is_finite() { Ok(value) } else { Err(E::custom("the number exceeds the range of double precision")) }
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<f64, E> {
        Ok(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<f64, E> {
        Ok(value as f64)
    }
}

/// A list of poles.
struct Poles;

impl<'de> DeserializeSeed<'de> for Poles {
    type Value = Vec<Complex<f64>>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Poles {
    type Value = Vec<Complex<f64>>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the list of \"poles\", such as [-1, -2] or [[-1, 2], [-1, -2]]")
    }

    fn visit_seq<S: SeqAccess<'de>>(self, mut list: S) -> Result<Self::Value, S::Error> {
        let mut poles = Vec::new();
        while let Some(pole) = list.next_element_seed(Pole { index: poles.len() })? {
            poles.push(pole);
        }
        Ok(poles)
    }
}

/// A number, or `[re, im]`.
struct Pole {
    index: usize,
}

impl<'de> DeserializeSeed<'de> for Pole {
    type Value = Complex<f64>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Pole {
    type Value = Complex<f64>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a number or [re, im] for pole {}", self.index + 1)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
        Ok((value as f64).into())
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Self::Value, E> {
        Ok((value as f64).into())
    }

    fn visit_seq<S: SeqAccess<'de>>(self, mut pair: S) -> Result<Self::Value, S::Error> {
        let part = |what| Number { what, indices: None };
        let short = |index| S::Error::custom(format!("pole {} must be a number or [re, im]", index + 1));
        let re = pair.next_element_seed(part("a real part"))?.ok_or_else(|| short(self.index))?;
        let im = pair.next_element_seed(part("an imaginary part"))?.ok_or_else(|| short(self.index))?;
        if pair.next_element::<IgnoredAny>()?.is_some() {
            return Err(short(self.index));
        }
        Ok(Complex::new(re, im))
    }
}
