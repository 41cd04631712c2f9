//! Observers in files: what is written is read again, and what was changed is read through the constructor.

use luenberger_observers::{
    ComparisonSystem, CubicObserver, DeviationObserver, DiscreteLinearObserver, DiscreteNonlinearObserver,
    ExtendedKalmanFilter, FixedPointFormat, FixedPointFormats, FixedPointObserver, FunctionalObserver,
    IntervalObserver, KalmanFilter, KalmanModel, LinearObserver, NoiseModel, NonlinearLuenbergerObserver,
    ProportionalIntegralObserver, SampledCubicGains, SampledCubicObserver, SampledIntervalGains,
    SampledIntervalObserver, SampledNonlinearObserver, SigmaPoints, StaticCubicObserver, StaticFixedPointObserver,
    StaticFunctionalObserver, StaticIntervalObserver, StaticLinearObserver, StaticProportionalIntegralObserver,
    StaticSampledIntervalObserver, StaticUnknownInputObserver, StaticVaryingPeriodObserver, StationaryKalmanFilter,
    UnknownInputObserver, UnscentedKalmanFilter, VaryingPeriodObserver, semi_implicit,
};
use luenberger_plants::{LinearPlant, StaticPlant};
use nalgebra::{DMatrix, Dyn, Matrix2, dmatrix, dvector};
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

/// The keys of an object, in their order.
fn keys(text: &str) -> Vec<&str> {
    let mut depth = 0;
    let mut found = Vec::new();
    for (part, next) in text.split('"').zip(text.split('"').skip(1)) {
        depth = depth + part.matches(['{', '[']).count() - part.matches(['}', ']']).count();
        found.extend((depth == 1 && part.ends_with(['{', ','])).then_some(next));
    }
    found
}

/// The names and their order are the format of files; of values that may be missing only those that are there.
#[test]
fn files_have_these_names() {
    let of_linear = ["a", "b", "c", "l", "d"];
    let l = dmatrix![0.3; 0.1];
    assert_eq!(keys(&stored(&linear())), of_linear);
    let cubic = CubicObserver::of(plant(), l.clone(), dmatrix![-1.0; -0.5], dmatrix![2.0]).unwrap();
    assert_eq!(keys(&stored(&cubic)), ["a", "b", "c", "l", "n", "theta", "d"]);
    let predictor = DiscreteLinearObserver::new(LinearPlant { d: None, ..plant() }, l.clone(), 0.1).unwrap();
    assert_eq!(keys(&stored(&predictor)), ["a", "b", "c", "l", "period"]);
    let stationary = StationaryKalmanFilter::new(predictor, l.clone()).unwrap();
    assert_eq!(keys(&stored(&stationary)), ["a", "b", "c", "l", "k", "period"]);
    assert_eq!(keys(&stored(&varying())), ["nominal", "a", "b", "k", "longest"]);
    assert_eq!(keys(&stored(varying().nominal())), ["ad", "bd", "c", "ld", "n", "theta", "w", "period", "d"]);
    assert_eq!(keys(&stored(&functional())), ["f", "g", "h", "n"]);
    assert_eq!(keys(&stored(&unknown_input())), ["inner", "h", "d"]);
    let expected =
        ["f", "g", "c", "l", "blocks", "constant", "of_estimate", "of_input", "h", "outward", "start", "period"];
    assert_eq!(keys(&stored(&sampled_interval())), expected);
    assert_eq!(keys(&stored(&interval())), ["inner", "comparison"]);
    assert_eq!(keys(&stored(&NonlinearLuenbergerObserver::new(plant(), l.clone()).unwrap())), ["plant", "l"]);
    let copy = SampledNonlinearObserver::new(plant(), l, 0.1, 3).unwrap();
    assert_eq!(keys(&stored(&copy)), ["plant", "l", "period", "substeps"]);
    let noises = || NoiseModel { w: DMatrix::identity(2, 2), v: dmatrix![0.3], p0: DMatrix::identity(2, 2) };
    let filter = ExtendedKalmanFilter::error_controlled(plant(), noises(), 0.1).unwrap().with_gate(4.0).unwrap();
    assert_eq!(keys(&stored(&filter)), ["plant", "w", "v", "p0", "period", "error_controlled", "gate"]);
    let filter = UnscentedKalmanFilter::new(plant(), noises(), SigmaPoints::default(), 0.1, 2).unwrap();
    assert_eq!(
        keys(&stored(&filter)),
        ["plant", "root_w", "root_v", "root_p0", "alpha", "beta", "kappa", "period", "substeps"]
    );
}

#[test]
fn a_changed_file_meets_the_constructor() {
    let observer = LinearObserver::of(plant(), dmatrix![0.3; 0.1]).unwrap();
    let text = stored(&observer);
    assert_eq!(refused::<Linear>(&text, r#""l":[[0.3],[0.1]]"#, r#""l":[[0.3]]"#), "L must be 2 x 1, found 1 x 1");
    assert_eq!(refused::<Linear>(&text, "[[0.5,0.1]", "[[0.5,0.1,0.0]"), "row 2 of A has 2 entries where row 1 has 3");
    assert!(refused::<Linear>(&text, r#""l":"#, r#""k":"#).starts_with("unknown field `k`"));
    assert!(refused::<Linear>(&text, "0.3", "null").contains("null"));
    let cubic = CubicObserver::of(plant(), dmatrix![0.3; 0.1], dmatrix![-1.0; -0.5], dmatrix![2.0]).unwrap();
    let error = serde_json::from_str::<StaticCubicObserver<f64, 3, 1, 1>>(&stored(&cubic)).unwrap_err();
    assert_eq!(error.to_string(), "A must be 3 x 3, found 2 x 2");
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

type Deviation = DeviationObserver<Linear, f64, Dyn, Dyn, Dyn>;
type Copied = NonlinearLuenbergerObserver<Plant, f64, Dyn, Dyn, Dyn>;
type Sampled = SampledNonlinearObserver<Plant, f64, Dyn, Dyn, Dyn>;
type Filter = ExtendedKalmanFilter<Plant, f64, Dyn, Dyn, Dyn>;
type Functional = FunctionalObserver<f64, Dyn, Dyn, Dyn>;
type WithDisturbance<O> = ProportionalIntegralObserver<O, Dyn>;
type WithoutDisturbance<O> = UnknownInputObserver<O, f64, Dyn, Dyn, Dyn>;
type Interval = IntervalObserver<Linear, f64, Dyn, Dyn, Dyn>;
type SampledInterval = SampledIntervalObserver<f64, Dyn, Dyn, Dyn, Dyn, Dyn>;
type Varying = VaryingPeriodObserver<f64, Dyn, Dyn, Dyn>;
type WithoutDisturbance32 = StaticUnknownInputObserver<StaticLinearObserver<f32, 2, 1, 1>, f32, 2, 1, 1>;
type Interval32 = StaticIntervalObserver<StaticLinearObserver<f32, 2, 1, 1>, f32, 2, 2, 4>;
type SampledInterval32 = StaticSampledIntervalObserver<f32, 2, 1, 1, 1, 3>;
type FixedPoint = FixedPointObserver<Dyn, Dyn, Dyn>;

fn linear() -> Linear {
    LinearObserver::of(plant(), dmatrix![0.3; 0.7]).unwrap()
}

fn functional() -> Functional {
    let (f, g, h) = (dmatrix![-4.0], dmatrix![-16.0, 0.5], dmatrix![1.0]);
    FunctionalObserver::new(f, g, h, dmatrix![4.0, 0.25]).unwrap()
}

fn unknown_input() -> WithoutDisturbance<Linear> {
    UnknownInputObserver::new(linear(), dmatrix![0.75; 0.0], Some(dmatrix![0.125])).unwrap()
}

fn interval() -> Interval {
    let (k, g) = (dmatrix![-2.0, 1.5; 0.0, -1.0], dvector![3.0, 0.125]);
    let comparison = ComparisonSystem { k, g, h: dmatrix![1.0, 0.0; 0.5, 1.0], start: dvector![0.625, 0.25] };
    IntervalObserver::new(linear(), comparison).unwrap()
}

fn sampled_interval() -> SampledInterval {
    let Plant { a: f, b: g, c, .. } = plant();
    SampledIntervalObserver::new(SampledIntervalGains {
        f,
        g,
        c,
        l: dmatrix![0.3; 0.7],
        blocks: dmatrix![0.75],
        constant: dvector![0.0625],
        of_estimate: dmatrix![1e-16, 2e-16],
        of_input: dmatrix![3e-16],
        h: dmatrix![1.0; 2.0],
        outward: 4e-16,
        start: dvector![8.0],
        period: 0.01,
    })
    .unwrap()
}

fn varying() -> Varying {
    let (ad, bd, c) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1], dmatrix![1.0, 0.0]);
    let (ld, n) = (dmatrix![0.9; 2.0], dmatrix![-1.0; -1.5]);
    let gains = SampledCubicGains { ad, bd, c, ld, n, theta: dmatrix![10.0], w: 1.0, period: 0.1 };
    let nominal = SampledCubicObserver::new(gains).unwrap().with_feedthrough(dmatrix![0.25]).unwrap();
    let (a, b) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
    VaryingPeriodObserver::new(nominal, a, b, dmatrix![0.7; 2.0], 0.3).unwrap()
}

fn fixed_point() -> FixedPoint {
    let formats = FixedPointFormats {
        gains: FixedPointFormat::new(2, 14).unwrap(),
        signals: FixedPointFormat::new(8, 8).unwrap(),
    };
    let designed = DiscreteLinearObserver::new(plant(), dmatrix![0.3; 0.7], 0.1).unwrap();
    FixedPointObserver::rounded(&designed, formats).unwrap()
}

#[test]
fn observers_made_of_others_and_of_further_matrices_are_read_as_they_were_written() {
    stored(&functional());
    stored(&ProportionalIntegralObserver::new(linear(), Dyn(1)).unwrap());
    let cubic = CubicObserver::of(plant(), dmatrix![0.3; 0.1], dmatrix![-1.0; -0.5], dmatrix![2.0]).unwrap();
    stored(&ProportionalIntegralObserver::new(cubic.clone(), Dyn(2)).unwrap());
    stored(&unknown_input());
    let text = stored(&WithoutDisturbance::new(cubic, dmatrix![0.75; 0.0], None).unwrap());
    assert!(text.ends_with(r#""h":[[0.75],[0.0]]}"#), "{text}");
    stored(&interval());
    stored(&sampled_interval());
    stored(&varying());
    let text = stored(&fixed_point());
    let formats =
        r#""formats":{"gains":{"integer_bits":2,"fraction_bits":14},"signals":{"integer_bits":8,"fraction_bits":8}}"#;
    assert!(text.contains(formats) && text.starts_with(r#"{"a":[[8192,1638],[-3277,4096]],"b":"#), "{text}");
}

#[test]
fn files_are_read_with_the_sizes_of_the_target() {
    fn read<O: DeserializeOwned + Serialize>(observer: &impl Serialize) {
        let text = serde_json::to_string(observer).unwrap();
        assert_eq!(serde_json::to_string(&serde_json::from_str::<O>(&text).unwrap()).unwrap(), text);
    }
    read::<StaticFunctionalObserver<f64, 1, 1, 2>>(&functional());
    let with_disturbance = ProportionalIntegralObserver::new(linear(), Dyn(1)).unwrap();
    read::<StaticProportionalIntegralObserver<StaticLinearObserver<f64, 2, 1, 1>, 1>>(&with_disturbance);
    read::<StaticUnknownInputObserver<StaticLinearObserver<f64, 2, 1, 1>, f64, 2, 1, 1>>(&unknown_input());
    read::<StaticIntervalObserver<StaticLinearObserver<f64, 2, 1, 1>, f64, 2, 2, 4>>(&interval());
    read::<StaticSampledIntervalObserver<f64, 2, 1, 1, 1, 3>>(&sampled_interval());
    read::<StaticVaryingPeriodObserver<f64, 2, 1, 1>>(&varying());
    read::<StaticFixedPointObserver<2, 1, 1>>(&fixed_point());
}

/// Plants, and observers with a plant next to their own numbers; both may have static sizes.
#[test]
fn observers_with_a_plant_are_read_as_they_were_written() {
    let text = stored(&plant());
    assert_eq!(text, r#"{"a":[[0.5,0.1],[-0.2,0.25]],"b":[[0.0],[1.0]],"c":[[1.0,0.0]],"d":[[0.1]]}"#);
    let read: StaticPlant<f64, 2, 1, 1> = serde_json::from_str(&text).unwrap();
    assert_eq!(read.to_dynamic(), plant());
    assert_eq!(refused::<Plant>(&text, "[[1.0,0.0]]", "[[1.0]]"), "C must be 1 x 2, found 1 x 1");
    assert_eq!(refused::<Plant>(&text, "[[0.1]]", "[[0.1],[0.2]]"), "D must be 1 x 1, found 2 x 1");
    assert_eq!(refused::<Plant>(&text, "[-0.2,0.25]", "[]"), "row 2 of A has 0 entries where row 1 has 2");

    let deviation = Deviation::new(linear(), dvector![1.0, 2.0], dvector![0.5], dvector![1.0]).unwrap();
    let text = stored(&deviation);
    assert!(text.ends_with(r#""x0":[[1.0],[2.0]],"u0":[[0.5]],"y0":[[1.0]]}"#), "{text}");
    assert!(refused::<Deviation>(&text, r#""u0":[[0.5]]"#, r#""u0":[[null]]"#).contains("null"));

    let l = || dmatrix![0.3; 0.7];
    let text = stored(&NonlinearLuenbergerObserver::new(plant(), l()).unwrap());
    assert_eq!(refused::<Copied>(&text, "[[0.3],[0.7]]", "[[0.3]]"), "L must be 2 x 1, found 1 x 1");
    stored(&DiscreteNonlinearObserver::new(plant(), l(), 0.1).unwrap());
    let text = stored(&SampledNonlinearObserver::new(plant(), l(), 0.1, 3).unwrap());
    assert!(refused::<Sampled>(&text, r#""substeps":3"#, r#""substeps":0"#).contains("step"));

    let noises =
        || NoiseModel { w: dmatrix![0.1, 0.05; 0.05, 0.2], v: dmatrix![0.3], p0: dmatrix![1.0, 0.0; 0.0, 2.0] };
    let extended = ExtendedKalmanFilter::new(plant(), noises(), 0.1, 2).unwrap();
    let text = stored(&extended);
    let error = refused::<Filter>(&text, r#""v":[[0.3]]"#, r#""v":[[-0.3]]"#);
    assert!(error.starts_with("V is not a covariance"), "{error}");
    let text = stored(&extended.with_gate(4.0).unwrap());
    assert!(text.ends_with(r#""period":0.1,"substeps":2,"gate":4.0}"#), "{text}");
    assert!(refused::<Filter>(&text, r#""gate":4.0"#, r#""gate":0.0"#).contains("gate"));
    let text = stored(&ExtendedKalmanFilter::discrete(plant(), noises(), 0.1).unwrap().with_iterations(3).unwrap());
    assert!(text.ends_with(r#""period":0.1,"iterations":3}"#), "{text}");
    assert!(refused::<Filter>(&text, r#""iterations":3"#, r#""iterations":0"#).contains("linearisations"));
    let text = stored(&ExtendedKalmanFilter::discrete(plant(), noises(), 0.1).unwrap());
    assert!(text.ends_with(r#""period":0.1}"#), "{text}");
    let sigma = SigmaPoints { alpha: 0.5, ..SigmaPoints::default() };
    stored(&UnscentedKalmanFilter::new(plant(), noises(), sigma, 0.1, 2).unwrap().with_gate(3.0).unwrap());
    stored(&UnscentedKalmanFilter::discrete(plant(), noises(), sigma, 0.1).unwrap());
    let turns = dvector![360.0];
    let angles = ExtendedKalmanFilter::discrete(plant(), noises(), 0.1).unwrap().with_angles(turns.clone()).unwrap();
    let text = stored(&angles);
    assert!(text.ends_with(r#""period":0.1,"turns":[[360.0]]}"#), "{text}");
    assert!(refused::<Filter>(&text, "360.0", "-360.0").contains("a full turn"));
    let vectors = ExtendedKalmanFilter::discrete(plant(), noises(), 0.1).unwrap();
    let text = stored(&vectors.with_unit_vectors(dvector![1.0, 1.0]).unwrap());
    assert!(text.ends_with(r#""period":0.1,"unit_vectors":[[1.0],[1.0]]}"#), "{text}");
    assert!(refused::<Filter>(&text, "[[1.0],[1.0]]", "[[1.0],[-1.0]]").contains("the number of a unit vector"));
    let states = dvector![360.0, 0.0];
    let angles = UnscentedKalmanFilter::discrete(plant(), noises(), sigma, 0.1).unwrap();
    let text = stored(&angles.with_angles(turns, states).unwrap());
    assert!(text.ends_with(r#""period":0.1,"turns":[[360.0]],"state_turns":[[360.0],[0.0]]}"#), "{text}");
}

/// What is wrong with a matrix of another shape, and with NaN, which JSON writes as null.
#[test]
fn damaged_files_of_these_observers_are_errors() {
    let text = stored(&functional());
    let error = refused::<Functional>(&text, "[[-16.0,0.5]]", "[[-16.0]]");
    assert_eq!(error, "N must be 1 x 1, found 1 x 2");
    assert!(refused::<Functional>(&text, "-16.0", "null").contains("null"));
    assert!(refused::<Functional>(&text, r#""n":[[4.0,0.25]]"#, r#""n":[[4.0,0.25]],"d":[[1.0]]"#).contains("`d`"));

    let text = stored(&ProportionalIntegralObserver::new(linear(), Dyn(1)).unwrap());
    let error = refused::<WithDisturbance<Linear>>(&text, r#""states":1"#, r#""states":3"#);
    assert_eq!(error, "the state and the disturbance must be 3 x 1, found 2 x 1");
    let error = refused::<StaticProportionalIntegralObserver<Linear, 1>>(&text, r#""states":1"#, r#""states":2"#);
    assert_eq!(error, "the state must be 1 x 1, found 2 x 1");
    let error = refused::<WithDisturbance<Linear>>(&text, "[[0.3],[0.7]]", "[[0.3]]");
    assert!(error.starts_with("L must be 2 x 1, found 1 x 1"), "{error}");
    assert!(refused::<WithDisturbance<Linear>>(&text, "0.7", "null").contains("null"));

    let text = stored(&unknown_input());
    let error = refused::<WithoutDisturbance<Linear>>(&text, "[[0.75],[0.0]]", "[[0.75]]");
    assert_eq!(error, "H must be 2 x 1, found 1 x 1");
    let error = refused::<WithoutDisturbance<Linear>>(&text, "[[0.125]]", "[[0.125],[0.0]]");
    assert_eq!(error, "D must be 1 x 1, found 2 x 1");
    assert!(refused::<WithoutDisturbance<Linear>>(&text, "0.75", "null").contains("null"));

    let text = stored(&interval());
    let error = refused::<Interval>(&text, "[[3.0],[0.125]]", "[[3.0]]");
    assert_eq!(error, "g must be 2 x 1, found 1 x 1");
    assert!(refused::<Interval>(&text, "0.125", "null").contains("null"));
    // With a negative entry the bounds would not enclose the state; the diagonal of K may be negative.
    for (from, to, expected) in [
        ("1.5", "-1.5", "K(1, 2) is -1.5, and must not be negative"),
        ("0.125", "-0.125", "g(2, 1) is -0.125, and must not be negative"),
        ("0.625", "-0.625", "rho(1, 1) is -0.625, and must not be negative"),
    ] {
        assert_eq!(refused::<Interval>(&text, from, to), expected);
    }
    let text = stored(&sampled_interval());
    let error = refused::<SampledInterval>(&text, "[[8.0]]", "[[8.0,8.0]]");
    assert_eq!(error, "rho must be 1 x 1, found 1 x 2");
    assert!(refused::<SampledInterval>(&text, r#""outward":4e-16"#, r#""outward":null"#).contains("null"));
    for (from, to, expected) in [
        ("[[0.75]]", "[[-0.75]]", "N(1, 1) is -0.75, and must not be negative"),
        ("0.0625", "-0.0625", "g(1, 1) is -0.0625, and must not be negative"),
        ("2e-16", "-2e-16", "Q(1, 2) is -0.0000000000000002, and must not be negative"),
        ("3e-16", "-3e-16", "U(1, 1) is -0.0000000000000003, and must not be negative"),
        ("[2.0]", "[-2.0]", "H(2, 1) is -2, and must not be negative"),
        ("[[8.0]]", "[[-8.0]]", "rho(1, 1) is -8, and must not be negative"),
    ] {
        assert_eq!(refused::<SampledInterval>(&text, from, to), expected);
    }
    assert!(
        refused::<SampledInterval>(&text, "4e-16", "-4e-16").starts_with("outward is -0.0000000000000004; it must")
    );
    let error = refused::<SampledInterval>(&text, r#""period":0.01"#, r#""period":0.0"#);
    assert_eq!(error, "the sampling period is 0; it must be positive and finite");

    let text = stored(&varying());
    let error = refused::<Varying>(&text, "[[0.7],[2.0]]", "[[0.7,2.0]]");
    assert_eq!(error, "K must be 2 x 1, found 1 x 2");
    let error = refused::<Varying>(&text, "[[0.0],[1.0]]", "[[0.0,0.0],[1.0,0.0]]");
    assert_eq!(error, "B must be 2 x 1, found 2 x 2");
    let error = refused::<Varying>(&text, r#""w":1.0"#, r#""w":-1.0"#);
    assert!(error.starts_with("C N = -w I with w = -1e0"), "{error}");
    assert!(refused::<Varying>(&text, r#""longest":0.3"#, r#""longest":null"#).contains("null"));

    let text = stored(&fixed_point());
    let error = refused::<FixedPoint>(&text, r#""integer_bits":2"#, r#""integer_bits":0"#);
    assert_eq!(error, "Q0.14: a format has 2 to 32 bits, at least one of them, the sign, before the point");
    let error = refused::<FixedPoint>(&text, "8192", "65536");
    assert_eq!(error, "A(1, 1) = 4 is beyond the range of Q2.14: it needs 4 bits before the point");
    let error = refused::<FixedPoint>(&text, "[8192,1638]", "[8192]");
    assert_eq!(error, "row 2 of A has 2 entries where row 1 has 1");
    assert!(refused::<FixedPoint>(&text, "8192", "0.5").contains("expected i32"));
}

/// In binary32 a number of `Value` beyond the range is read as infinity: the constructor refuses it.
#[test]
fn numbers_that_are_not_finite_meet_the_constructor() {
    fn beyond<O: DeserializeOwned + std::fmt::Debug>(text: &str, from: &str, to: &str) -> String {
        assert!(text.contains(from), "{text}");
        let value: serde_json::Value = serde_json::from_str(&text.replacen(from, to, 1)).unwrap();
        serde_json::from_value::<O>(value).unwrap_err().to_string()
    }
    let text = stored(&functional());
    let error = beyond::<StaticFunctionalObserver<f32, 1, 1, 2>>(&text, "-16.0", "1e39");
    assert_eq!(error, "G(1, 1) is inf, not a finite number");
    let error = beyond::<WithoutDisturbance32>(&stored(&unknown_input()), "0.75", "1e39");
    assert_eq!(error, "H(1, 1) is inf, not a finite number");
    let error = beyond::<Interval32>(&stored(&interval()), "0.625", "1e39");
    assert_eq!(error, "rho(1, 1) is inf, not a finite number");
    let text = stored(&sampled_interval());
    let error = beyond::<SampledInterval32>(&text, "0.0625", "1e39");
    assert_eq!(error, "g(1, 1) is inf, not a finite number");
    assert!(beyond::<SampledInterval32>(&text, r#""outward":4e-16"#, r#""outward":1e39"#).contains("outward is inf"));
    let error = beyond::<StaticVaryingPeriodObserver<f32, 2, 1, 1>>(&stored(&varying()), "[0.7]", "[1e39]");
    assert_eq!(error, "K(1, 1) is inf, not a finite number");
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
