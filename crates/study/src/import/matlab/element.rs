//! Tags and data of MAT-file elements.

use crate::import::ImportError;

/// The byte order of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    Little,
    Big,
}

pub(super) const MATRIX: u32 = 14;
pub(super) const COMPRESSED: u32 = 15;

/// One element.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element<'a> {
    /// Its type: `miINT8` is 1, ...
    pub(super) kind: u32,
    pub(super) data: &'a [u8],
    /// The byte offset in the file at which it begins; for a compressed element, that of the compressed data.
    pub(super) at: usize,
}

/// A sequence of elements.
pub(super) struct Elements<'a> {
    rest: &'a [u8],
    at: usize,
    order: Order,
    /// Whether offsets are tracked: not in decompressed data.
    is_counting: bool,
}

impl<'a> Elements<'a> {
    /// The elements in `bytes`, which begin at byte `at` of the file.
    pub(super) fn new(bytes: &'a [u8], at: usize, order: Order) -> Self {
        Self { rest: bytes, at, order, is_counting: true }
    }

    /// The elements in the decompressed data of a compressed element at byte `at`.
    pub(super) fn inside(bytes: &'a [u8], at: usize, order: Order) -> Self {
        Self { rest: bytes, at, order, is_counting: false }
    }

    /// The elements in the data of an element.
    pub(super) fn of(element: Element<'a>, order: Order, is_counting: bool) -> Self {
        Self { rest: element.data, at: element.at, order, is_counting }
    }

    pub(super) fn damaged(&self, what: &'static str) -> ImportError {
        ImportError::Damaged { what, at: self.at }
    }

    fn skip(&mut self, count: usize) {
        let count = count.min(self.rest.len());
        self.rest = &self.rest[count..];
        if self.is_counting {
            self.at += count;
        }
    }

    /// The next element at the top level of a file, where compressed ones are not padded.
    pub(super) fn next_unpadded_if_compressed(&mut self) -> Result<Option<Element<'a>>, ImportError> {
        self.take(|kind| kind != COMPRESSED)
    }

    /// The next element, or none at the end.
    pub(super) fn next_element(&mut self) -> Result<Option<Element<'a>>, ImportError> {
        self.take(|_| true)
    }

    /// The next element; an error at the end.
    pub(super) fn expect(&mut self, what: &'static str) -> Result<Element<'a>, ImportError> {
        match self.next_element()? {
            Some(element) => Ok(element),
            None => Err(self.damaged(what)),
        }
    }

    fn take(&mut self, is_padded: impl Fn(u32) -> bool) -> Result<Option<Element<'a>>, ImportError> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        let at = self.at;
        let Some((tag, after)) = self.rest.split_first_chunk::<8>() else {
            return Err(self.damaged("the end of the file within a tag"));
        };
        let [a, b, c, d, inline @ ..] = *tag;
        let word = self.order.u32([a, b, c, d]);
        // Small elements: at most four bytes of data are in the tag itself, their number beside the type.
        let small = word >> 16;
        if small != 0 {
            if small > 4 {
                return Err(self.damaged("a small element of more than 4 bytes"));
            }
            let data = &self.rest[4..4 + small as usize];
            self.skip(8);
            return Ok(Some(Element { kind: word & 0xffff, data, at }));
        }
        let length = self.order.u32(inline) as usize;
        let Some(data) = after.get(..length) else {
            return Err(self.damaged("an element that is longer than what is left of the file"));
        };
        let padding = if is_padded(word) { length.wrapping_neg() % 8 } else { 0 };
        self.skip(8 + length + padding);
        Ok(Some(Element { kind: word, data, at }))
    }
}

impl Order {
    pub(super) fn u32(self, bytes: [u8; 4]) -> u32 {
        if self == Self::Little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) }
    }

    /// The bytes reordered for `from_ne_bytes`.
    fn native<const N: usize>(self, mut bytes: [u8; N]) -> [u8; N] {
        if (self == Self::Little) != cfg!(target_endian = "little") {
            bytes.reverse();
        }
        bytes
    }
}

impl Element<'_> {
    /// The numbers of an element of any numeric type.
    pub(super) fn numbers(&self, order: Order) -> Result<Vec<f64>, ImportError> {
        macro_rules! each {
            ($number:ty, $width:literal, $as:expr) => {{
                let (whole, rest) = self.data.as_chunks::<$width>();
                if !rest.is_empty() {
                    return Err(ImportError::Damaged { what: "a number cut short", at: self.at });
                }
                whole.iter().map(|bytes| $as(<$number>::from_ne_bytes(order.native(*bytes)))).collect()
            }};
        }
        Ok(match self.kind {
            1 => each!(i8, 1, f64::from),
            2 => each!(u8, 1, f64::from),
            3 => each!(i16, 2, f64::from),
            4 => each!(u16, 2, f64::from),
            5 => each!(i32, 4, f64::from),
            6 => each!(u32, 4, f64::from),
            7 => each!(f32, 4, f64::from),
            9 => each!(f64, 8, f64::from),
            12 => each!(i64, 8, |x: i64| x as f64),
            13 => each!(u64, 8, |x: u64| x as f64),
            _ => return Err(ImportError::Damaged { what: "an element that should hold numbers", at: self.at }),
        })
    }

    /// The numbers, as nonnegative integers.
    pub(super) fn counts(&self, order: Order) -> Result<Vec<u64>, ImportError> {
        let count = |x: f64| {
            let is_count = x >= 0.0 && x <= f64::from(u32::MAX) && x.fract() == 0.0;
            is_count.then_some(x as u64).ok_or(ImportError::Damaged { what: "a count that is none", at: self.at })
        };
        self.numbers(order)?.into_iter().map(count).collect()
    }

    /// The text of a name.
    pub(super) fn name(&self) -> String {
        let end = self.data.iter().position(|byte| *byte == 0).unwrap_or(self.data.len());
        String::from_utf8_lossy(&self.data[..end]).into_owned()
    }
}
