//! Interval observers in continuous time.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, RealField};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Rows, matrix, rows};
use crate::error::ObserverError;
use crate::observer::Observer;
use crate::{ComparisonSystem, IntervalObserver};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Continuous<O, T> {
    inner: O,
    comparison: Comparison<T>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Comparison<T> {
    k: Rows<T>,
    g: Rows<T>,
    h: Rows<T>,
    start: Rows<T>,
}

impl<O, T, N: Dim, Q: Dim, S: Dim> Serialize for IntervalObserver<O, T, N, Q, S>
where
    O: Serialize,
    T: RealField + Copy + Serialize,
    DefaultAllocator: Allocator<Q, Q> + Allocator<Q> + Allocator<N, Q> + Allocator<N> + Allocator<S>,
{
    fn serialize<R: Serializer>(&self, serializer: R) -> Result<R::Ok, R::Error> {
        let ComparisonSystem { k, g, h, start } = self.comparison();
        let comparison = Comparison { k: rows(k), g: rows(g), h: rows(h), start: rows(start) };
        Continuous { inner: self.inner(), comparison }.serialize(serializer)
    }
}

impl<'de, O, T, N: Dim, Q: Dim, S: Dim> Deserialize<'de> for IntervalObserver<O, T, N, Q, S>
where
    O: Observer<T> + Deserialize<'de>,
    T: RealField + Copy + Deserialize<'de>,
    DefaultAllocator: Allocator<Q, Q> + Allocator<Q> + Allocator<N, Q> + Allocator<N> + Allocator<S>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Continuous { inner, comparison } = Continuous::<O, T>::deserialize(deserializer)?;
        let build = || -> Result<Self, ObserverError> {
            let Comparison { k, g, h, start } = comparison;
            let (k, g) = (matrix("K", &k)?, matrix("g", &g)?);
            Self::new(inner, ComparisonSystem { k, g, h: matrix("H", &h)?, start: matrix("rho", &start)? })
        };
        build().map_err(D::Error::custom)
    }
}
