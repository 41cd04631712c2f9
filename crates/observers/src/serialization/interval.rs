//! Interval observers, in continuous time and sampled.

use luenberger_plants::Size;
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, RealField};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Rows, matrix, rows};
use crate::error::ObserverError;
use crate::observer::Observer;
use crate::{ComparisonSystem, IntervalObserver, SampledIntervalGains, SampledIntervalObserver};

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

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sampled<T> {
    f: Rows<T>,
    g: Rows<T>,
    c: Rows<T>,
    l: Rows<T>,
    blocks: Rows<T>,
    constant: Rows<T>,
    of_estimate: Rows<T>,
    of_input: Rows<T>,
    h: Rows<T>,
    outward: T,
    start: Rows<T>,
    period: T,
}

impl<T, N: Dim, M: Dim, P: Dim, Q: Dim, S: Dim> Serialize for SampledIntervalObserver<T, N, M, P, Q, S>
where
    T: RealField + Copy + Serialize,
    DefaultAllocator: Size<N, M, P>
        + Allocator<Q, Q>
        + Allocator<Q>
        + Allocator<N, Q>
        + Allocator<Q, N>
        + Allocator<Q, M>
        + Allocator<S>,
{
    fn serialize<R: Serializer>(&self, serializer: R) -> Result<R::Ok, R::Error> {
        let SampledIntervalGains { f, g, c, l, blocks, constant, of_estimate, of_input, h, outward, start, period } =
            self.gains();
        let form = Sampled {
            f: rows(f),
            g: rows(g),
            c: rows(c),
            l: rows(l),
            blocks: rows(blocks),
            constant: rows(constant),
            of_estimate: rows(of_estimate),
            of_input: rows(of_input),
            h: rows(h),
            outward: *outward,
            start: rows(start),
            period: *period,
        };
        form.serialize(serializer)
    }
}

impl<'de, T, N: Dim, M: Dim, P: Dim, Q: Dim, S: Dim> Deserialize<'de> for SampledIntervalObserver<T, N, M, P, Q, S>
where
    T: RealField + Copy + Deserialize<'de>,
    DefaultAllocator: Size<N, M, P>
        + Allocator<Q, Q>
        + Allocator<Q>
        + Allocator<N, Q>
        + Allocator<Q, N>
        + Allocator<Q, M>
        + Allocator<S>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let form = Sampled::<T>::deserialize(deserializer)?;
        let build = || {
            Self::new(SampledIntervalGains {
                f: matrix("F", &form.f)?,
                g: matrix("G", &form.g)?,
                c: matrix("C", &form.c)?,
                l: matrix("L", &form.l)?,
                blocks: matrix("N", &form.blocks)?,
                constant: matrix("g", &form.constant)?,
                of_estimate: matrix("Q", &form.of_estimate)?,
                of_input: matrix("U", &form.of_input)?,
                h: matrix("H", &form.h)?,
                outward: form.outward,
                start: matrix("rho", &form.start)?,
                period: form.period,
            })
        };
        build().map_err(D::Error::custom)
    }
}
