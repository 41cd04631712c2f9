//! Corrections by a constant gain of samples with missing outputs: the observer without those columns of its gains.
#![cfg(feature = "alloc")]

use luenberger_observers::{
    DiscreteLinearObserver, DiscreteNonlinearObserver, SampledCubicGains, SampledCubicObserver,
    SampledNonlinearObserver, SampledObserver, StationaryKalmanFilter, VaryingPeriodObserver, VaryingPeriodStep,
};
use luenberger_plants::{Plant, StaticPlant, plant};
use nalgebra::{Matrix2, SMatrix, Vector1, Vector2, convert};

const BAD: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
const MISSING: [[bool; 2]; 3] = [[true, false], [false, true], [true, true]];

/// A pendulum with friction, of which angle and a nonlinear mixture are measured.
#[derive(Clone, Copy, Debug)]
struct Pendulum;

plant!(
    Pendulum,
    (2, 1, 2),
    |this, t, x, u| [x[1], -x[0].sin() - x[1] * convert(0.1) + u[0]],
    [x[0], x[1] + x[0] * x[0] * convert(0.1)]
);

fn gain() -> Matrix2<f64> {
    Matrix2::new(0.4, 0.1, -0.05, 0.3)
}

fn without(missing: [bool; 2]) -> Matrix2<f64> {
    let mut l = gain();
    for (column, _) in missing.iter().enumerate().filter(|(_, missing)| **missing) {
        l.column_mut(column).fill(0.0);
    }
    l
}

/// Steps with a missing output in the third and the fourth of them, next to those of the observer that has no column
/// for it there. `step_partial` has the same numbers, whatever stands in the place of what is missing.
fn leaves_out<O>(observer: &O, others: &dyn Fn([bool; 2]) -> O)
where
    O: SampledObserver<f64, State = Vector2<f64>, Input = Vector1<f64>, Output = Vector2<f64>, Estimate = Vector2<f64>>,
{
    for bad in BAD {
        for missing in MISSING {
            let other = others(missing);
            let mut found = Vector2::new(0.3, -0.2);
            let (mut expected, mut said) = (found, found);
            for k in 0..8 {
                let (t, u) = (0.1 * f64::from(k), Vector1::new(0.1 * f64::from(k)));
                let y = Vector2::new(0.5 - t, 0.2 + t);
                if k == 2 || k == 3 {
                    let lost = Vector2::from_fn(|i, _| if missing[i] { bad } else { y[i] });
                    observer.step(t, &mut found, &u, &lost);
                    other.step(t, &mut expected, &u, &y);
                    observer.step_partial(
                        t,
                        &mut said,
                        &u,
                        &(y * 3.0).zip_map(&lost, |far, y| if y.is_finite() { y } else { far }),
                        &missing.map(|missing| !missing),
                    );
                } else {
                    observer.step(t, &mut found, &u, &y);
                    observer.step(t, &mut expected, &u, &y);
                    observer.step(t, &mut said, &u, &y);
                }
                assert_eq!(found, expected, "{bad}, {missing:?}, sample {k}");
                assert_eq!(found, said, "{bad}, {missing:?}, sample {k}");
            }
        }
    }
}

#[test]
fn a_copy_of_a_nonlinear_plant() {
    let of = |l| SampledNonlinearObserver::new(Pendulum, l, 0.1, 3).unwrap();
    leaves_out(&of(gain()), &|missing| of(without(missing)));
    let of = |l| DiscreteNonlinearObserver::new(Pendulum, l, 0.1).unwrap();
    leaves_out(&of(gain()), &|missing| of(without(missing)));
}

fn linear() -> StaticPlant<f64, 2, 1, 2> {
    let (a, c) = (Matrix2::new(0.9, 0.1, -0.2, 0.8), Matrix2::new(1.0, 0.3, -0.2, 1.0));
    StaticPlant::new(a, Vector2::new(0.0, 0.1), c).unwrap().with_feedthrough(Vector2::new(0.5, -0.25)).unwrap()
}

#[test]
fn a_linear_observer() {
    let of = |l| DiscreteLinearObserver::new(linear(), l, 0.1).unwrap();
    leaves_out(&of(gain()), &|missing| of(without(missing)));
    let form = |l: Matrix2<f64>| StationaryKalmanFilter::new(of(linear().a * l), l).unwrap();
    leaves_out(&form(gain()), &|missing| form(without(missing)));
}

/// `C N = -w I` and theta of full weight, so that both outputs are in the cubic part of each other.
fn cubic() -> SampledCubicObserver<f64, nalgebra::Const<2>, nalgebra::Const<1>, nalgebra::Const<2>> {
    let plant = linear();
    let gains = SampledCubicGains {
        ad: plant.a,
        bd: plant.b,
        c: plant.c,
        ld: gain(),
        n: -plant.c.try_inverse().unwrap() * 0.7,
        theta: Matrix2::new(2.0, 0.5, 0.5, 1.0),
        w: 0.7,
        period: 0.1,
    };
    SampledCubicObserver::new(gains).unwrap().with_feedthrough(plant.d.unwrap()).unwrap()
}

/// The cubic part has the innovation with a 0 where nothing was measured: that of an output as it is predicted. Without
/// any output the step is the plant.
#[test]
fn a_cubic_observer_fixed_and_at_varying_periods() {
    let (observer, u) = (cubic(), Vector1::new(0.4));
    let plant = linear();
    let (a, b) = (Matrix2::new(-1.0, 0.5, -0.3, -2.0), SMatrix::<f64, 2, 1>::new(0.0, 1.0));
    let varying = VaryingPeriodObserver::new(cubic(), a, b, gain(), 0.3).unwrap();
    let xhat = Vector2::new(0.3, -0.2);
    let predicted = plant.output(0.0, &xhat, &u);
    for bad in BAD {
        for missing in MISSING {
            let y = predicted + Vector2::new(0.7, -1.1);
            let lost = Vector2::from_fn(|i, _| if missing[i] { bad } else { y[i] });
            let stand_in = Vector2::from_fn(|i, _| if missing[i] { predicted[i] } else { y[i] });
            let close = |found: Vector2<f64>, expected: Vector2<f64>| (found - expected).amax() < 1e-15;
            let (mut found, mut expected) = (xhat, xhat);
            observer.step(0.0, &mut found, &u, &lost);
            observer.step(0.0, &mut expected, &u, &stand_in);
            assert!(close(found, expected), "{found} {expected}");
            let moved = plant.a * xhat + plant.b * u;
            assert_eq!(close(found, moved), missing == [true, true], "{found} {moved}");
            let (mut found, mut expected) = (xhat, xhat);
            varying.correct(&mut found, &u, &lost, 0.2);
            varying.correct(&mut expected, &u, &stand_in, 0.2);
            assert!(close(found, expected), "{found} {expected}");
            assert_eq!(close(found, xhat), missing == [true, true], "{found} {xhat}");
        }
    }
    // The step takes the time as its last input, which nothing reads.
    let with_time =
        |m: SMatrix<f64, 2, 1>| SMatrix::<f64, 2, 2>::from_columns(&[m.column(0).into_owned(), Vector2::zeros()]);
    let nominal = SampledCubicObserver::new(SampledCubicGains {
        ad: plant.a,
        bd: with_time(plant.b),
        c: plant.c,
        ld: gain(),
        n: -plant.c.try_inverse().unwrap() * 0.7,
        theta: Matrix2::new(2.0, 0.5, 0.5, 1.0),
        w: 0.7,
        period: 0.1,
    })
    .unwrap();
    let step =
        VaryingPeriodStep::new(VaryingPeriodObserver::new(nominal, a, with_time(b), gain(), 0.3).unwrap()).unwrap();
    let (mut found, mut predicted, known) = (xhat, xhat, Vector2::new(0.4, 0.2));
    step.step(0.0, &mut found, &known, &Vector2::repeat(f64::NAN));
    step.observer().predict(&mut predicted, &known, 0.2);
    assert_eq!(found, predicted);
}

/// `estimate_at` and `step` are innovation, update and prediction, with the same bits; measurements that come one after
/// the other are those that come together.
#[test]
fn a_stationary_filter_has_its_halves() {
    let predictor = DiscreteLinearObserver::new(linear(), linear().a * gain(), 0.1).unwrap();
    let filter = StationaryKalmanFilter::new(predictor, gain()).unwrap();
    let (mut state, u) = (Vector2::new(0.3, -0.2), Vector1::new(0.4));
    for k in 0..20 {
        let y = Vector2::new((0.3 * f64::from(k)).sin(), (0.3 * f64::from(k)).cos());
        let [first, second] = [0, 1].map(|i| {
            let one = Vector2::from_fn(|j, _| if i == j { y[j] } else { f64::NAN });
            filter.innovation(&state, &u, &one)
        });
        let (mut predicted, together) = (state, first + second);
        assert!((together - (y - linear().c * state - linear().d.unwrap() * u)).amax() < 1e-15);
        assert_eq!(filter.update(&state, &together), filter.estimate_at(&state, &u, &y));
        assert_eq!(
            filter.update(&state, &first),
            filter.estimate_at_partial(&state, &u, &Vector2::new(y[0], 9.0), &[true, false])
        );
        filter.predict(&mut predicted, &u, &together);
        filter.step(0.0, &mut state, &u, &y);
        assert_eq!(predicted, state);
    }
}
