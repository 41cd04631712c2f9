//! Observers that are made of another observer: with a disturbance, which is estimated or decoupled, and in deviations.

use luenberger_plants::{PlantError, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, RealField};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Rows, matrix, maybe, rows};
use crate::error::ObserverError;
use crate::observer::Observer;
use crate::{CubicObserver, DeviationObserver, LinearObserver, ProportionalIntegralObserver, UnknownInputObserver};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ProportionalIntegral<O> {
    inner: O,
    states: usize,
}

impl<O: Serialize, N: Dim> Serialize for ProportionalIntegralObserver<O, N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        ProportionalIntegral { inner: self.inner(), states: self.states() }.serialize(serializer)
    }
}

impl<O> ProportionalIntegral<O> {
    fn observer<T, N: Dim>(self) -> Result<ProportionalIntegralObserver<O, N>, ObserverError>
    where
        O: Observer<T>,
    {
        let expected = N::try_to_usize().unwrap_or(self.states);
        if self.states != expected {
            let (expected, found) = ((expected, 1), (self.states, 1));
            return Err(PlantError::DimensionMismatch { what: "the state", expected, found }.into());
        }
        ProportionalIntegralObserver::new(self.inner, N::from_usize(self.states))
    }
}

/// The scalar of the constructor is that of the inner observer, which a type parameter alone does not tell.
macro_rules! read_proportional_integral {
    ($($inner:ident),+) => {$(
        impl<'de, T, N, K, M, P> Deserialize<'de> for ProportionalIntegralObserver<$inner<T, K, M, P>, N>
        where
            T: RealField + Copy + Deserialize<'de>,
            N: Dim,
            K: Dim,
            M: Dim,
            P: Dim,
            DefaultAllocator: Size<K, M, P>,
        {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let form = ProportionalIntegral::<$inner<T, K, M, P>>::deserialize(deserializer)?;
                form.observer::<T, N>().map_err(D::Error::custom)
            }
        }
    )+};
}

read_proportional_integral!(LinearObserver, CubicObserver);

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct UnknownInput<O, T> {
    inner: O,
    h: Rows<T>,
    #[serde(skip_serializing_if = "Option::is_none")]
    d: Option<Rows<T>>,
}

impl<O, T, N: Dim, M: Dim, P: Dim> Serialize for UnknownInputObserver<O, T, N, M, P>
where
    O: Serialize,
    T: RealField + Copy + Serialize,
    DefaultAllocator: Allocator<N, P> + Allocator<P, M> + Allocator<P>,
{
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        UnknownInput { inner: self.inner(), h: rows(self.h()), d: self.d().map(rows) }.serialize(serializer)
    }
}

impl<'de, O, T, N: Dim, M: Dim, P: Dim> Deserialize<'de> for UnknownInputObserver<O, T, N, M, P>
where
    O: Observer<T> + Deserialize<'de>,
    T: RealField + Copy + Deserialize<'de>,
    DefaultAllocator: Allocator<N, P> + Allocator<P, M> + Allocator<P>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let UnknownInput { inner, h, d } = UnknownInput::<O, T>::deserialize(deserializer)?;
        let build = || Self::new(inner, matrix("H", &h)?, maybe(d)?);
        build().map_err(D::Error::custom)
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Deviation<O, T> {
    inner: O,
    x0: Rows<T>,
    u0: Rows<T>,
    y0: Rows<T>,
}

impl<O, T, N: Dim, M: Dim, P: Dim> Serialize for DeviationObserver<O, T, N, M, P>
where
    O: Serialize,
    T: RealField + Copy + Serialize,
    DefaultAllocator: Allocator<N> + Allocator<M> + Allocator<P>,
{
    fn serialize<R: Serializer>(&self, serializer: R) -> Result<R::Ok, R::Error> {
        let (x0, u0, y0) = (rows(self.x0()), rows(self.u0()), rows(self.y0()));
        Deviation { inner: self.inner(), x0, u0, y0 }.serialize(serializer)
    }
}

impl<'de, O, T, N: Dim, M: Dim, P: Dim> Deserialize<'de> for DeviationObserver<O, T, N, M, P>
where
    O: Deserialize<'de>,
    T: RealField + Copy + Deserialize<'de>,
    DefaultAllocator: Allocator<N> + Allocator<M> + Allocator<P>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Deviation { inner, x0, u0, y0 } = Deviation::<O, T>::deserialize(deserializer)?;
        let build = || Self::new(inner, matrix("x0", &x0)?, matrix("u0", &u0)?, matrix("y0", &y0)?);
        build().map_err(D::Error::custom)
    }
}
