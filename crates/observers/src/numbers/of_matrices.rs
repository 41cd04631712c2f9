//! Observers of matrices alone.

use core::fmt::{self, Display, Formatter};

#[cfg(feature = "alloc")]
use luenberger_plants::LinearPlant;
use luenberger_plants::Size;
#[cfg(feature = "serde")]
use luenberger_plants::serialization::{Rows, rows};
use nalgebra::allocator::Allocator;
#[cfg(feature = "alloc")]
use nalgebra::{Const, DMatrix, Dyn};
use nalgebra::{DefaultAllocator, Dim, RealField};
#[cfg(feature = "serde")]
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _, ser::SerializeStruct as _};

use super::Lines;
#[cfg(feature = "alloc")]
use crate::error::ObserverError;
use crate::observer::SampledObserver as _;
#[cfg(feature = "serde")]
use crate::serialization::matrix;
#[cfg(feature = "alloc")]
use crate::static_size::{dynamic, rounded, sized};
use crate::{
    CubicObserver, DiscreteLinearObserver, FunctionalObserver, KalmanFilter, LinearObserver, SampledCubicObserver,
    SampledIntervalObserver, StationaryKalmanFilter, VaryingPeriodObserver,
};
#[cfg(feature = "alloc")]
use crate::{KalmanModel, SampledCubicGains, SampledIntervalGains};

numbers! {
    LinearObserver as Linear<N, M, P> where Size<N, M, P>;
    |o| {
        a: matrix(A) = &o.a,
        b: matrix(B) = &o.b,
        c: matrix(C) = &o.c,
        l: matrix(L) = &o.l,
        d: maybe(D) = o.d.as_ref(),
    }
    LinearObserver::of(LinearPlant { a, b, c, d }, l);

    CubicObserver as Cubic<N, M, P> where Size<N, M, P>;
    |o| {
        a: matrix(A) = &o.a,
        b: matrix(B) = &o.b,
        c: matrix(C) = &o.c,
        l: matrix(L) = &o.l,
        n: matrix(N) = &o.n,
        theta: matrix(Theta) = &o.theta,
        d: maybe(D) = o.d.as_ref(),
    }
    CubicObserver::of(LinearPlant { a, b, c, d }, l, n, theta);

    DiscreteLinearObserver as Discrete<N, M, P> where Size<N, M, P>;
    |o| {
        a: matrix(A) = &o.plant().a,
        b: matrix(B) = &o.plant().b,
        c: matrix(C) = &o.plant().c,
        l: matrix(L) = o.l(),
        period: number = o.period(),
        d: maybe(D) = o.plant().d.as_ref(),
    }
    DiscreteLinearObserver::new(LinearPlant { a, b, c, d }, l, period);

    StationaryKalmanFilter as Stationary<N, M, P> where Size<N, M, P>;
    |o| {
        a: matrix(A) = &o.predictor().plant().a,
        b: matrix(B) = &o.predictor().plant().b,
        c: matrix(C) = &o.predictor().plant().c,
        l: matrix(L) = o.predictor().l(),
        k: matrix(K) = o.k(),
        period: number = o.period(),
        d: maybe(D) = o.predictor().plant().d.as_ref(),
    }
    StationaryKalmanFilter::new(DiscreteLinearObserver::new(LinearPlant { a, b, c, d }, l, period)?, k);

    SampledCubicObserver as SampledCubic<N, M, P> where Size<N, M, P>;
    |o| {
        ad: matrix(Ad) = o.ad(),
        bd: matrix(Bd) = o.bd(),
        c: matrix(C) = o.c(),
        ld: matrix(Ld) = o.ld(),
        n: matrix(N) = o.n(),
        theta: matrix(Theta) = o.theta(),
        w: number = o.w(),
        period: number = o.period(),
        // Where the cubic step is semi-implicit.
        coupling: maybe(Coupling) = o.coupling(),
        d: maybe(D) = o.d(),
    }
    {
        let gains = SampledCubicGains { ad, bd, c, ld, n, theta, w, period };
        let observer = match coupling {
            Some(coupling) => SampledCubicObserver::semi_implicit(gains, coupling)?,
            None => SampledCubicObserver::new(gains)?,
        };
        match d {
            Some(d) => observer.with_feedthrough(d),
            None => Ok(observer),
        }
    };

    VaryingPeriodObserver as VaryingPeriod<N, M, P> where Size<N, M, P>;
    |o| {
        nominal: whole(SampledCubic) = o.nominal(),
        a: matrix(A) = o.a(),
        b: matrix(B) = o.b(),
        k: matrix(K) = o.k(),
        longest: number = o.longest(),
    }
    VaryingPeriodObserver::new(nominal, a, b, k, longest);

    FunctionalObserver as Functional<R, M, P> where Size<R, M, P>;
    |o| {
        f: matrix(F) = o.f(),
        g: matrix(G) = o.g(),
        h: matrix(H) = o.h(),
        n: matrix(N) = o.n(),
    }
    FunctionalObserver::new(f, g, h, n);

    KalmanFilter as Kalman<N, M, P> where Size<N, M, P>;
    |o| {
        ad: matrix(Ad) = &o.model().ad,
        bd: matrix(Bd) = &o.model().bd,
        c: matrix(C) = &o.model().c,
        w: matrix(W) = &o.model().w,
        v: matrix(V) = &o.model().v,
        p0: matrix(P0) = &o.model().p0,
        period: number = o.model().period,
        d: maybe(D) = o.d(),
    }
    {
        let filter = KalmanFilter::new(KalmanModel { ad, bd, c, w, v, p0, period })?;
        match d {
            Some(d) => filter.with_feedthrough(d),
            None => Ok(filter),
        }
    };

    ///
    /// The enclosure is proved for the format of the design, rounding of the step included: `f64` for binary64, `f32`
    /// for binary32, whose gains `f32` has exactly. In another scalar the bounds need a new proof.
    SampledIntervalObserver as Sampled<N, M, P, Q, S>
    where Size<N, M, P>, Allocator<Q, Q>, Allocator<Q>, Allocator<N, Q>, Allocator<Q, N>, Allocator<Q, M>, Allocator<S>;
    |o| {
        f: matrix(F) = &o.gains().f,
        g: matrix(G) = &o.gains().g,
        c: matrix(C) = &o.gains().c,
        l: matrix(L) = &o.gains().l,
        blocks: matrix(N) = &o.gains().blocks,
        constant: matrix(Constant) = &o.gains().constant,
        of_estimate: matrix(Q) = &o.gains().of_estimate,
        of_input: matrix(U) = &o.gains().of_input,
        h: matrix(H) = &o.gains().h,
        outward: number = o.gains().outward,
        start: matrix(Rho) = &o.gains().start,
        period: number = o.gains().period,
    }
    SampledIntervalObserver::new(SampledIntervalGains {
        f, g, c, l, blocks, constant, of_estimate, of_input, h, outward, start, period,
    });
}
