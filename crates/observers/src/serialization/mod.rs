//! Serialisation of observers (feature `serde`), in any format of serde.
//!
//! An observer is written as its matrices, each an array of rows, under the names of its constructor's arguments; one
//! that is made of another has it under `inner` or `nominal`. It is read through its constructor: a file that was
//! changed by hand gives an observer that its constructor accepts, or the constructor's error. Sizes known at compile
//! time must be those of the file.
//!
//! Observers of a plant of the user's have it under `plant`, if its type implements `Serialize` and `Deserialize`: the
//! copies with a constant gain, the extended and the unscented Kalman filter. Feature `serde` of `luenberger-plants`
//! does it for linear plants.
//!
//! The others have no file, because their numbers are not all that they are: the mean-value observer has a mean and the
//! KKL, parameter-estimation, high-gain and immersion-and-invariance observers have maps that are code of the user's,
//! the inter-sample form and the mapped observer are made of them, numerical KKL observers have tables that the design
//! computes, the moving-horizon estimator and the sliding-mode observers have few numbers, which are the arguments of
//! their constructors. For these the study or the certificate file stores the design, from which they are built again.
//!
//! No evidence is stored here: that is a certificate file.
//!
//! ```
//! use luenberger_observers::{LinearObserver, StaticLinearObserver};
//! use nalgebra::Vector2;
//! let plant = luenberger_plants::double_integrator();
//! let observer = LinearObserver::new(plant.a, plant.b, plant.c, Vector2::new(7.0, 10.0))?;
//! let text = serde_json::to_string(&observer)?;
//! assert_eq!(text, r#"{"a":[[0.0,1.0],[0.0,0.0]],"b":[[0.0],[1.0]],"c":[[1.0,0.0]],"l":[[7.0],[10.0]]}"#);
//! let read: StaticLinearObserver<f64, 2, 1, 1> = serde_json::from_str(&text)?;
//! assert_eq!(read, observer);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod fixed_point;
mod interval;
mod with_inner;
mod with_plant;

use luenberger_plants::serialization::{Rows, rows};
use luenberger_plants::{LinearPlant, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, RealField, Scalar};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::ObserverError;
use crate::observer::SampledObserver;
use crate::{
    CubicObserver, DiscreteLinearObserver, FunctionalObserver, KalmanFilter, KalmanModel, LinearObserver,
    SampledCubicGains, SampledCubicObserver, StationaryKalmanFilter, VaryingPeriodObserver,
};

/// The matrix with these rows.
///
/// # Errors
/// [`ObserverError::Matrix`]: rows of different lengths, or another size than the type has.
fn matrix<T: Scalar + Copy, R: Dim, C: Dim>(
    name: &'static str,
    rows: &Rows<T>,
) -> Result<OMatrix<T, R, C>, ObserverError>
where
    DefaultAllocator: Allocator<R, C>,
{
    Ok(luenberger_plants::serialization::matrix(name, rows)?)
}

fn maybe<T: Scalar + Copy, R: Dim, C: Dim>(rows: Option<Rows<T>>) -> Result<Option<OMatrix<T, R, C>>, ObserverError>
where
    DefaultAllocator: Allocator<R, C>,
{
    rows.map(|rows| matrix("D", &rows)).transpose()
}

/// The form in which an observer is stored, and the way there and back; `; d` for one that may have a feedthrough.
macro_rules! stored {
    ($(
        $(#[$doc:meta])*
        $observer:ident as $form:ident { $($(#[$attribute:meta])* $field:ident: $kind:ty),+ $(; $d:ident)? }
        |$this:ident| $write:expr,
        |$read:ident| $build:expr;
    )+) => {$(
        $(#[$doc])*
        #[derive(Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        struct $form<T> {
            $($(#[$attribute])* $field: $kind,)+
            $(
                #[serde(skip_serializing_if = "Option::is_none")]
                $d: Option<Rows<T>>,
            )?
        }

        impl<T: RealField + Copy + Serialize, N: Dim, M: Dim, P: Dim> Serialize for $observer<T, N, M, P>
        where
            DefaultAllocator: Size<N, M, P>,
        {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let $this = self;
                $write.serialize(serializer)
            }
        }

        impl<'de, T: RealField + Copy + Deserialize<'de>, N: Dim, M: Dim, P: Dim> Deserialize<'de>
            for $observer<T, N, M, P>
        where
            DefaultAllocator: Size<N, M, P>,
        {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let $read = $form::<T>::deserialize(deserializer)?;
                let build = || -> Result<Self, ObserverError> { $build };
                build().map_err(D::Error::custom)
            }
        }
    )+};
}

stored! {
    LinearObserver as Linear { a: Rows<T>, b: Rows<T>, c: Rows<T>, l: Rows<T>; d }
    |o| Linear { a: rows(&o.a), b: rows(&o.b), c: rows(&o.c), l: rows(&o.l), d: o.d.as_ref().map(rows) },
    |f| Self::of(plant(&f.a, &f.b, &f.c, f.d)?, matrix("L", &f.l)?);

    CubicObserver as Cubic { a: Rows<T>, b: Rows<T>, c: Rows<T>, l: Rows<T>, n: Rows<T>, theta: Rows<T>; d }
    |o| Cubic {
        a: rows(&o.a),
        b: rows(&o.b),
        c: rows(&o.c),
        l: rows(&o.l),
        n: rows(&o.n),
        theta: rows(&o.theta),
        d: o.d.as_ref().map(rows),
    },
    |f| Self::of(plant(&f.a, &f.b, &f.c, f.d)?, matrix("L", &f.l)?, matrix("N", &f.n)?, matrix("theta", &f.theta)?);

    DiscreteLinearObserver as Discrete { a: Rows<T>, b: Rows<T>, c: Rows<T>, l: Rows<T>, period: T; d }
    |o| discrete(o),
    |f| observer(f);

    /// Fields of the predictor, and K.
    StationaryKalmanFilter as Stationary { a: Rows<T>, b: Rows<T>, c: Rows<T>, l: Rows<T>, k: Rows<T>, period: T; d }
    |o| {
        let Discrete { a, b, c, l, period, d } = discrete(o.predictor());
        Stationary { a, b, c, l, k: rows(o.k()), period, d }
    },
    |f| Self::new(observer(Discrete { a: f.a, b: f.b, c: f.c, l: f.l, period: f.period, d: f.d })?, matrix("K", &f.k)?);

    /// `coupling`, -C N, where the cubic step is semi-implicit.
    SampledCubicObserver as SampledCubic {
        ad: Rows<T>, bd: Rows<T>, c: Rows<T>, ld: Rows<T>, n: Rows<T>, theta: Rows<T>, w: T, period: T,
        #[serde(skip_serializing_if = "Option::is_none")]
        coupling: Option<Rows<T>>; d
    }
    |o| sampled_cubic(o),
    |f| sampled_cubic_observer(f);

    VaryingPeriodObserver as VaryingPeriod {
        nominal: SampledCubic<T>, a: Rows<T>, b: Rows<T>, k: Rows<T>, longest: T
    }
    |o| VaryingPeriod {
        nominal: sampled_cubic(o.nominal()),
        a: rows(o.a()),
        b: rows(o.b()),
        k: rows(o.k()),
        longest: o.longest(),
    },
    |f| {
        let (a, b) = (matrix("A", &f.a)?, matrix("B", &f.b)?);
        Self::new(sampled_cubic_observer(f.nominal)?, a, b, matrix("K", &f.k)?, f.longest)
    };

    FunctionalObserver as Functional { f: Rows<T>, g: Rows<T>, h: Rows<T>, n: Rows<T> }
    |o| Functional { f: rows(o.f()), g: rows(o.g()), h: rows(o.h()), n: rows(o.n()) },
    |f| Self::new(matrix("F", &f.f)?, matrix("G", &f.g)?, matrix("H", &f.h)?, matrix("N", &f.n)?);

    KalmanFilter as Kalman {
        ad: Rows<T>, bd: Rows<T>, c: Rows<T>, w: Rows<T>, v: Rows<T>, p0: Rows<T>, period: T; d
    }
    |o| {
        let KalmanModel { ad, bd, c, w, v, p0, period } = o.model();
        Kalman {
            ad: rows(ad),
            bd: rows(bd),
            c: rows(c),
            w: rows(w),
            v: rows(v),
            p0: rows(p0),
            period: *period,
            d: o.d().map(rows),
        }
    },
    |f| {
        let filter = Self::new(KalmanModel {
            ad: matrix("Ad", &f.ad)?,
            bd: matrix("Bd", &f.bd)?,
            c: matrix("C", &f.c)?,
            w: matrix("W", &f.w)?,
            v: matrix("V", &f.v)?,
            p0: matrix("P(0)", &f.p0)?,
            period: f.period,
        })?;
        match maybe(f.d)? {
            Some(d) => filter.with_feedthrough(d),
            None => Ok(filter),
        }
    };
}

fn plant<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(
    a: &Rows<T>,
    b: &Rows<T>,
    c: &Rows<T>,
    d: Option<Rows<T>>,
) -> Result<LinearPlant<T, N, M, P>, ObserverError>
where
    DefaultAllocator: Size<N, M, P>,
{
    Ok(LinearPlant { a: matrix("A", a)?, b: matrix("B", b)?, c: matrix("C", c)?, d: maybe(d)? })
}

fn discrete<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(o: &DiscreteLinearObserver<T, N, M, P>) -> Discrete<T>
where
    DefaultAllocator: Size<N, M, P>,
{
    let LinearPlant { a, b, c, d } = o.plant();
    Discrete { a: rows(a), b: rows(b), c: rows(c), l: rows(o.l()), period: o.period(), d: d.as_ref().map(rows) }
}

fn observer<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(
    f: Discrete<T>,
) -> Result<DiscreteLinearObserver<T, N, M, P>, ObserverError>
where
    DefaultAllocator: Size<N, M, P>,
{
    DiscreteLinearObserver::new(plant(&f.a, &f.b, &f.c, f.d)?, matrix("L", &f.l)?, f.period)
}

fn sampled_cubic<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(o: &SampledCubicObserver<T, N, M, P>) -> SampledCubic<T>
where
    DefaultAllocator: Size<N, M, P>,
{
    SampledCubic {
        ad: rows(o.ad()),
        bd: rows(o.bd()),
        c: rows(o.c()),
        ld: rows(o.ld()),
        n: rows(o.n()),
        theta: rows(o.theta()),
        w: o.w(),
        period: o.period(),
        coupling: o.coupling().map(rows),
        d: o.d().map(rows),
    }
}

fn sampled_cubic_observer<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(
    f: SampledCubic<T>,
) -> Result<SampledCubicObserver<T, N, M, P>, ObserverError>
where
    DefaultAllocator: Size<N, M, P>,
{
    let gains = SampledCubicGains {
        ad: matrix("Ad", &f.ad)?,
        bd: matrix("Bd", &f.bd)?,
        c: matrix("C", &f.c)?,
        ld: matrix("Ld", &f.ld)?,
        n: matrix("N", &f.n)?,
        theta: matrix("theta", &f.theta)?,
        w: f.w,
        period: f.period,
    };
    let observer = match f.coupling {
        Some(coupling) => SampledCubicObserver::semi_implicit(gains, matrix("-C N", &coupling)?)?,
        None => SampledCubicObserver::new(gains)?,
    };
    match maybe(f.d)? {
        Some(d) => observer.with_feedthrough(d),
        None => Ok(observer),
    }
}
