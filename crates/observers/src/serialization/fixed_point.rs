//! The observer in fixed point: its matrices as integers, and its formats.

use luenberger_plants::Size;
use nalgebra::{DefaultAllocator, Dim};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Rows, matrix, maybe, rows};
use crate::error::ObserverError;
use crate::{FixedPointFormat, FixedPointFormats, FixedPointGains, FixedPointObserver};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FixedPoint {
    a: Rows<i32>,
    b: Rows<i32>,
    c: Rows<i32>,
    l: Rows<i32>,
    formats: Formats,
    #[serde(skip_serializing_if = "Option::is_none")]
    d: Option<Rows<i32>>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Formats {
    gains: Format,
    signals: Format,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Format {
    integer_bits: u32,
    fraction_bits: u32,
}

impl From<FixedPointFormat> for Format {
    fn from(format: FixedPointFormat) -> Self {
        Self { integer_bits: format.integer_bits(), fraction_bits: format.fraction_bits() }
    }
}

impl TryFrom<Format> for FixedPointFormat {
    type Error = ObserverError;

    fn try_from(form: Format) -> Result<Self, ObserverError> {
        Self::new(form.integer_bits, form.fraction_bits)
    }
}

impl<N: Dim, M: Dim, P: Dim> Serialize for FixedPointObserver<N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let FixedPointGains { a, b, c, d, l } = self.gains();
        let FixedPointFormats { gains, signals } = self.formats();
        let formats = Formats { gains: gains.into(), signals: signals.into() };
        let d = d.as_ref().map(rows);
        FixedPoint { a: rows(a), b: rows(b), c: rows(c), l: rows(l), formats, d }.serialize(serializer)
    }
}

impl<'de, N: Dim, M: Dim, P: Dim> Deserialize<'de> for FixedPointObserver<N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let FixedPoint { a, b, c, l, formats, d } = FixedPoint::deserialize(deserializer)?;
        let build = || -> Result<Self, ObserverError> {
            let formats = FixedPointFormats { gains: formats.gains.try_into()?, signals: formats.signals.try_into()? };
            let (a, b, c) = (matrix("A", &a)?, matrix("B", &b)?, matrix("C", &c)?);
            Self::new(FixedPointGains { a, b, c, d: maybe(d)?, l: matrix("L", &l)? }, formats)
        };
        build().map_err(D::Error::custom)
    }
}
