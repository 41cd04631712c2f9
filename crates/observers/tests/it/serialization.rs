//! Observers in files: what is written is read again, and what was changed is read through the constructor.

use luenberger_observers::{
    CubicObserver, DiscreteLinearObserver, KalmanFilter, KalmanModel, LinearObserver, SampledCubicGains,
    SampledCubicObserver, StaticCubicObserver, StationaryKalmanFilter, semi_implicit,
};
use luenberger_plants::LinearPlant;
use nalgebra::{DMatrix, Dyn, Matrix2, dmatrix};
use proptest::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

type Plant = LinearPlant<f64, Dyn, Dyn, Dyn>;
type Linear = LinearObserver<f64, Dyn, Dyn, Dyn>;

fn plant() -> Plant {
    let (a, b, c) = (dmatrix![0.5, 0.1; -0.2, 0.25], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]);
    LinearPlant { a, b, c, d: Some(dmatrix![0.1]) }
}

fn stored<O: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(observer: &O) -> String {
    let text = serde_json::to_string(observer).unwrap();
    assert_eq!(&serde_json::from_str::<O>(&text).unwrap(), observer, "{text}");
    text
}

/// The error of reading `text` with `from` replaced by `to`.
fn refused<O: DeserializeOwned + std::fmt::Debug>(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{text}");
    serde_json::from_str::<O>(&text.replacen(from, to, 1)).unwrap_err().to_string()
}

#[test]
fn every_observer_is_read_as_it_was_written() {
    let l = dmatrix![0.3; 0.1];
    stored(&LinearObserver::of(plant(), l.clone()).unwrap());
    stored(&CubicObserver::of(plant(), l.clone(), dmatrix![-1.0; -0.5], dmatrix![2.0]).unwrap());
    let predictor = DiscreteLinearObserver::new(plant(), l.clone(), 0.1).unwrap();
    stored(&predictor);
    stored(&StationaryKalmanFilter::new(predictor, dmatrix![0.6; 0.2]).unwrap());
    let Plant { a: ad, b: bd, c, .. } = plant();
    let gains = SampledCubicGains {
        ad: ad.clone(),
        bd: bd.clone(),
        c: c.clone(),
        ld: l,
        n: dmatrix![-1.0; -0.5],
        theta: dmatrix![2.0],
        w: 1.0,
        period: 0.1,
    };
    stored(&SampledCubicObserver::new(gains.clone()).unwrap());
    stored(&SampledCubicObserver::new(gains.clone()).unwrap().with_feedthrough(dmatrix![0.1]).unwrap());
    let coupling = semi_implicit::coupling(&gains.c, &gains.n);
    stored(&SampledCubicObserver::semi_implicit(gains, coupling).unwrap());
    let (w, p0) = (DMatrix::identity(2, 2) * 0.01, DMatrix::identity(2, 2));
    let model = KalmanModel { ad, bd, c, w, v: dmatrix![0.04], p0, period: 0.1 };
    stored(&KalmanFilter::new(model.clone()).unwrap());
    stored(&KalmanFilter::new(model).unwrap().with_feedthrough(dmatrix![0.1]).unwrap());
}

#[test]
fn a_changed_file_meets_the_constructor() {
    let observer = LinearObserver::of(plant(), dmatrix![0.3; 0.1]).unwrap();
    let text = stored(&observer);
    assert_eq!(
        refused::<Linear>(&text, r#""l":[[0.3],[0.1]]"#, r#""l":[[0.3]]"#),
        "L is 1x1 where 2x1 fits the other matrices"
    );
    assert_eq!(refused::<Linear>(&text, "[[0.5,0.1]", "[[0.5,0.1,0.0]"), "A is 2x2 where 2x3 fits the other matrices");
    assert!(refused::<Linear>(&text, r#""l":"#, r#""k":"#).starts_with("unknown field `k`"));
    assert!(refused::<Linear>(&text, "0.3", "null").contains("null"));
    let cubic = CubicObserver::of(plant(), dmatrix![0.3; 0.1], dmatrix![-1.0; -0.5], dmatrix![2.0]).unwrap();
    let error = serde_json::from_str::<StaticCubicObserver<f64, 3, 1, 1>>(&stored(&cubic)).unwrap_err();
    assert_eq!(error.to_string(), "A is 2x2 where 3x3 fits the other matrices");
    // A negative rate of the cubic flow would let the estimate escape.
    let (ad, bd) = (Matrix2::new(1.0, 0.1, 0.0, 1.0), Matrix2::zeros().column(0).into_owned());
    let sampled = SampledCubicObserver::new(SampledCubicGains {
        ad: DMatrix::from_column_slice(2, 2, ad.as_slice()),
        bd: DMatrix::from_column_slice(2, 1, bd.as_slice()),
        c: dmatrix![1.0, 0.0],
        ld: dmatrix![0.9; 2.0],
        n: dmatrix![-1.0; -1.5],
        theta: dmatrix![1.0],
        w: 1.0,
        period: 0.1,
    });
    let error =
        refused::<SampledCubicObserver<f64, Dyn, Dyn, Dyn>>(&stored(&sampled.unwrap()), r#""w":1.0"#, r#""w":-1.0"#);
    assert!(error.contains("-1"), "{error}");
}

proptest! {
    /// Any bits of binary64 survive, and so does a plant without inputs.
    #[test]
    fn the_bits_survive(entries in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL, 6)) {
        let a = DMatrix::from_column_slice(2, 2, &entries[..4]);
        let plant = LinearPlant { a, b: DMatrix::zeros(2, 0), c: dmatrix![1.0, 0.0], d: None };
        let l = DMatrix::from_column_slice(2, 1, &entries[4..]);
        stored(&LinearObserver::of(plant, l).unwrap());
    }
}
