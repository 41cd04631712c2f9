//! The observer in fixed point against exact integers of 128 bits.

use luenberger_observers::{
    DiscreteLinearObserver, FixedPointFormat, FixedPointFormats, FixedPointGains, FixedPointObserver, ObserverError,
    StaticFixedPointObserver,
};
use luenberger_plants::{StateSpace, StaticPlant};
use nalgebra::{DMatrix, DVector, Dyn, Matrix1, Matrix2, RowVector2, Vector1, Vector2, dmatrix};
use proptest::prelude::*;

fn format(integer_bits: u32, fraction_bits: u32) -> FixedPointFormat {
    FixedPointFormat::new(integer_bits, fraction_bits).unwrap()
}

/// The nearest integer to `sum / 2^bits`, ties upwards, by Euclidean division.
fn nearest(sum: i128, bits: u32) -> i128 {
    (2 * sum + (1 << bits)).div_euclid(2 << bits)
}

/// A step in integers of 128 bits: the result, and how many numbers were cut off.
fn exactly(observer: &FixedPointObserver<Dyn, Dyn, Dyn>, xhat: &[i32], u: &[i32], y: &[i32]) -> (Vec<i128>, u32) {
    let FixedPointFormats { gains, signals } = observer.formats();
    let FixedPointGains { a, b, c, d, l } = observer.gains();
    let (low, high) = (i128::from(signals.smallest()), i128::from(signals.largest()));
    let mut cut = 0;
    let mut limited = |x: i128| {
        cut += u32::from(x < low || x > high);
        x.max(low).min(high)
    };
    let sum = |m: &DMatrix<i32>, i: usize, x: &[i128]| -> i128 {
        x.iter().enumerate().map(|(j, x)| i128::from(m[(i, j)]) * x).sum()
    };
    let wide = |x: &[i32]| x.iter().map(|x| i128::from(*x)).collect::<Vec<_>>();
    let (xhat, u, y) = (wide(xhat), wide(u), wide(y));
    let f = gains.fraction_bits();
    let z: Vec<i128> = (0..y.len())
        .map(|k| {
            let fed = d.as_ref().map_or(0, |d| sum(d, k, &u));
            limited(nearest((y[k] << f) - sum(c, k, &xhat) - fed, f))
        })
        .collect();
    let next = (0..xhat.len()).map(|i| limited(nearest(sum(a, i, &xhat) + sum(b, i, &u) + sum(l, i, &z), f))).collect();
    (next, cut)
}

/// Sizes, formats, and entries up to the ends of the ranges.
fn observer() -> impl Strategy<Value = (FixedPointObserver<Dyn, Dyn, Dyn>, Vec<Vec<i32>>)> {
    let bits = (1..=16_u32).prop_flat_map(|integer| (Just(integer), 1..=32 - integer));
    (1..=4_usize, 0..=2_usize, 1..=3_usize, bits.clone(), bits, any::<bool>()).prop_flat_map(
        |(n, m, p, (gi, gf), (si, sf), fed)| {
            let formats = FixedPointFormats { gains: format(gi, gf), signals: format(si, sf) };
            // A share of the range that keeps every row within 64 bits.
            let most = i64::from(formats.gains.largest()).min((1 << 32) / 12) as i32;
            let gain = (-most..=most).prop_map(|x| x / 2);
            let signal = prop_oneof![
                4 => formats.signals.smallest()..=formats.signals.largest(),
                1 => Just(formats.signals.smallest()),
                1 => Just(formats.signals.largest()),
                // A target may pass integers beyond the range of a short format.
                1 => any::<i32>(),
            ];
            (prop::collection::vec(gain, 40), prop::collection::vec(prop::collection::vec(signal, 9), 12)).prop_map(
                move |(entries, signals)| {
                    let mut entries = entries.into_iter().cycle();
                    let mut matrix = |rows, columns| DMatrix::from_fn(rows, columns, |_, _| entries.next().unwrap());
                    let gains = FixedPointGains {
                        a: matrix(n, n),
                        b: matrix(n, m),
                        c: matrix(p, n),
                        d: fed.then(|| matrix(p, m)),
                        l: matrix(n, p),
                    };
                    (FixedPointObserver::new(gains, formats).unwrap(), signals)
                },
            )
        },
    )
}

proptest! {
    /// Every step is that of exact integers, rounded once per sum and cut off at the ends of the range; nothing
    /// overflows, also for signals beyond the range.
    #[test]
    fn every_step_is_that_of_exact_integers((observer, signals) in observer()) {
        let size = observer.dimensions();
        let mut state = observer.start(DVector::from_column_slice(&signals[0][..size.state]));
        for entries in &signals[1..] {
            let (u, y) = (&entries[..size.inputs], &entries[size.inputs..size.inputs + size.outputs]);
            let (expected, cut) = exactly(&observer, state.xhat.as_slice(), u, y);
            let before = state.saturations;
            observer.step(&mut state, &DVector::from_column_slice(u), &DVector::from_column_slice(y));
            let found: Vec<i128> = state.xhat.iter().map(|x| i128::from(*x)).collect();
            prop_assert_eq!(found, expected);
            prop_assert_eq!(state.saturations - before, cut);
        }
    }

    /// The nearest number, ties to even, for every format.
    #[test]
    fn numbers_are_rounded_to_the_nearest(x in -40.0..40.0_f64, integer in 1..=16_u32, fraction in 1..=16_u32) {
        let q = format(integer, fraction);
        let unit = 2.0_f64.powi(-fraction.cast_signed());
        match q.nearest(x) {
            Some(found) => {
                prop_assert!((q.value(found) - x).abs() <= unit / 2.0);
                prop_assert_eq!(f64::from(found), (x / unit).round_ties_even());
            }
            None => prop_assert!(x > q.value(q.largest()) + unit / 4.0 || x < q.value(q.smallest()) - unit / 4.0),
        }
    }
}

#[test]
fn sizes_known_at_compile_time_give_the_same() {
    let plant = StaticPlant::new(Matrix2::new(1.0, 0.1, -0.2, 0.9), Vector2::new(0.0, 0.5), RowVector2::new(1.0, 0.3));
    let plant = plant.unwrap().with_feedthrough(Matrix1::new(0.25)).unwrap();
    let designed = DiscreteLinearObserver::new(plant, Vector2::new(0.7, 0.4), 0.1).unwrap();
    let formats = FixedPointFormats { gains: format(2, 14), signals: format(8, 8) };
    let observer: StaticFixedPointObserver<2, 1, 1> = FixedPointObserver::rounded(&designed, formats).unwrap();
    // 0.7 2^14 = 11468.8, 0.3 2^14 = 4915.2.
    assert_eq!((observer.gains().l[0], observer.gains().c[1]), (11469, 4915));
    let mut state = observer.start(Vector2::new(100, -300));
    observer.step(&mut state, &Vector1::new(64), &Vector1::new(256));
    // z = (256 2^14 - 16384 100 + 4915 300 - 4096 64)/2^14 = 229.995.., A xhat + B u + L z by hand.
    assert_eq!(state.xhat, Vector2::new(231, -166));
    assert_eq!(state.saturations, 0);
}

#[test]
fn what_does_not_fit_is_an_error() {
    assert!(matches!(FixedPointFormat::new(0, 8), Err(ObserverError::FixedPointFormat { .. })));
    assert!(matches!(FixedPointFormat::new(17, 16), Err(ObserverError::FixedPointFormat { .. })));
    assert!(matches!(FixedPointFormat::new(u32::MAX, 1), Err(ObserverError::FixedPointFormat { .. })));
    assert_eq!((format(1, 31).largest(), format(32, 0).smallest()), (i32::MAX, i32::MIN));
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        assert_eq!(format(16, 16).nearest(x), None);
    }
    let plant = |a: f64| StateSpace::new(dmatrix![a], dmatrix![1.0], dmatrix![1.0]).unwrap();
    let designed = |a: f64| DiscreteLinearObserver::new(plant(a), dmatrix![0.5], 0.1).unwrap();
    let error = FixedPointObserver::rounded(&designed(9.0), format(4, 12).into()).unwrap_err();
    assert_eq!(error.to_string(), "A(1, 1) = 9 is beyond the range of Q4.12: it needs 5 bits before the point");
    // 7.9 + 1 + 0.5 are below 16 = 2^32 2^-28, and 3 * 7 + 0.5 are not.
    assert!(FixedPointObserver::rounded(&designed(7.9), format(4, 28).into()).is_ok());
    let wide =
        StateSpace::new(DMatrix::from_element(3, 3, 7.0), DMatrix::zeros(3, 0), DMatrix::from_element(1, 3, 1.0));
    let designed = DiscreteLinearObserver::new(wide.unwrap(), DMatrix::from_element(3, 1, 0.5), 0.1).unwrap();
    let error = FixedPointObserver::rounded(&designed, format(4, 28).into()).unwrap_err();
    assert!(matches!(error, ObserverError::FixedPointSum { row: 0, .. }), "{error}");
    assert!(FixedPointObserver::rounded(&designed, format(4, 26).into()).is_ok());
    let gains = FixedPointGains { a: dmatrix![1, 2], b: DMatrix::zeros(1, 0), c: dmatrix![1], d: None, l: dmatrix![1] };
    assert!(matches!(FixedPointObserver::new(gains, format(4, 4).into()), Err(ObserverError::Matrix(_))));
    let gains = FixedPointGains { a: dmatrix![300], b: DMatrix::zeros(1, 0), c: dmatrix![1], d: None, l: dmatrix![1] };
    let error = FixedPointObserver::new(gains, format(4, 4).into()).unwrap_err();
    assert_eq!(error.to_string(), "A(1, 1) = 18.75 is beyond the range of Q4.4: it needs 6 bits before the point");
}

#[test]
fn the_count_of_saturations_stays_at_its_largest() {
    let gains = FixedPointGains { a: dmatrix![16], b: DMatrix::zeros(1, 0), c: dmatrix![0], d: None, l: dmatrix![16] };
    let observer = FixedPointObserver::new(gains, format(4, 4).into()).unwrap();
    let mut state = observer.start(DVector::from_element(1, 127));
    state.saturations = u32::MAX - 1;
    for _ in 0..3 {
        observer.step(&mut state, &DVector::zeros(0), &DVector::from_element(1, 127));
        assert_eq!(state.xhat[0], 127);
    }
    assert_eq!(state.saturations, u32::MAX);
}
