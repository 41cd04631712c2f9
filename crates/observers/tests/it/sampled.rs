//! The cubic flow in closed form, and the sampled-data observer: error equation, decrease, overflow, bad data.
#![cfg(feature = "alloc")]

use luenberger_observers::cubic::{self, flow};
use luenberger_observers::{ObserverError, SampledCubicGains, SampledCubicObserver, SampledObserver};
use nalgebra::{DMatrix, DVector, Matrix1, Matrix2, RealField, RowVector2, SMatrix, Vector1, Vector2};
use proptest::prelude::*;

/// A symmetric positive definite matrix `G G' + I/10` of order `n`.
fn definite(n: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0, n * n).prop_map(move |entries| {
        let g = DMatrix::from_vec(n, n, entries);
        &g * g.transpose() + DMatrix::identity(n, n) * 0.1
    })
}

/// Data of a radial cubic gain `N = -P^-1 C' w (C P^-1 C')^-1`, and an error of any size.
#[derive(Debug, Clone)]
struct Radial {
    p: DMatrix<f64>,
    c: DMatrix<f64>,
    n: DMatrix<f64>,
    theta: DMatrix<f64>,
    w: f64,
    e: DVector<f64>,
}

fn radial() -> impl Strategy<Value = Radial> {
    (1usize..=6).prop_flat_map(|states| (Just(states), 1..=states)).prop_flat_map(|(states, outputs)| {
        let c = prop::collection::vec(-1.0..1.0, outputs * states).prop_map(move |entries| {
            DMatrix::from_vec(outputs, states, entries) + DMatrix::identity(outputs, states) * 3.0
        });
        let e = prop::collection::vec(-1.0..1.0, states).prop_map(DVector::from_vec);
        (definite(states), c, definite(outputs), 0.1f64..10.0, e, -3.0f64..6.0).prop_map(
            |(p, c, theta, w, e, decade)| {
                // S = w (C P^-1 C')^-1, N = -P^-1 C' S.
                let inverse = p.clone().cholesky().unwrap().inverse();
                let s = (&c * &inverse * c.transpose()).cholesky().unwrap().inverse() * w;
                let n = -(inverse * c.transpose() * s);
                Radial { p, c, n, theta, w, e: e * 10f64.powf(decade) }
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// The closed form is the solution of e' = (y~' theta y~) N y~: its derivative by differences.
    #[test]
    fn the_flow_solves_its_equation(case in radial(), t in 1e-3f64..10.0) {
        let Radial { c, n, theta, w, e, .. } = case;
        let innovation = &c * &e;
        let at = |t: f64| flow(&theta, w, &innovation, t);
        let now = at(t);
        // C N = -w I, for any number of outputs.
        prop_assert!((cubic::rate(&c, &n) - w).abs() <= 1e-9 * w);
        // The two parts of the answer agree: y~(t) = y~(0) + C N impulse.
        let scale = innovation.amax();
        prop_assert!((&innovation + &c * &n * &now.impulse - &now.innovation).amax() <= 1e-9 * scale);
        // y~' = -w (y~' theta y~) y~, by central differences: truncation 1e-8, rounding 1e-12, both relative.
        let step = 1e-4 * t;
        let slope = (at(t + step).innovation - at(t - step).innovation) / (2.0 * step);
        let rate = w * now.innovation.dot(&(&theta * &now.innovation));
        prop_assert!((slope + &now.innovation * rate).amax() <= 1e-7 * (rate + 1.0 / t) * now.innovation.amax());
        prop_assert_eq!(at(0.0).innovation, &innovation / innovation.amax() * innovation.amax());
    }

    /// One output has a shorter chain of operations: its bits are those of one of two outputs, of which the other is 0.
    #[test]
    fn one_output_has_the_bits_of_one_of_two(
        y in any::<f64>(), theta in any::<f64>(), w in any::<f64>(), t in any::<f64>(), other in 0.0f64..10.0,
    ) {
        fn same<T: RealField + Copy>(
            y: T,
            [theta, w, t, other]: [T; 4],
            bits: impl Fn(T) -> u64,
        ) -> Result<(), TestCaseError> {
            let zero = T::zero();
            let one = flow(&Matrix1::new(theta), w, &Vector1::new(y), t);
            let two = flow(&Matrix2::new(theta, zero, zero, other), w, &Vector2::new(y, zero), t);
            if y.is_finite() {
                prop_assert_eq!(bits(one.innovation[0]), bits(two.innovation[0]));
                prop_assert_eq!(bits(one.impulse[0]), bits(two.impulse[0]));
            } else {
                prop_assert!(!one.innovation[0].is_finite() && !one.impulse[0].is_finite());
            }
            Ok(())
        }
        let gains = [theta, w, t].map(|x| if x.is_finite() { x.abs() } else { 1.0 });
        let [theta, w, t] = gains;
        same(y, [theta, w, t, other], f64::to_bits)?;
        same(y as f32, [theta, w, t, other].map(|x| x as f32), |x| x.to_bits().into())?;
        // Numbers between which nothing overflows or vanishes.
        let near = |x: f64| x.abs().log2() / 100.0;
        same(near(y) * y.signum(), [near(theta).abs(), near(w).abs(), near(t).abs(), other], f64::to_bits)?;
    }

    /// The semigroup property: flowing for t and then for s is flowing for t + s.
    #[test]
    fn the_flow_is_a_flow(case in radial(), t in 1e-6f64..10.0, s in 1e-6f64..10.0) {
        let Radial { c, theta, w, e, .. } = case;
        let innovation = c * e;
        let first = flow(&theta, w, &innovation, t);
        let second = flow(&theta, w, &first.innovation, s);
        let whole = flow(&theta, w, &innovation, t + s);
        prop_assert!((&whole.innovation - &second.innovation).amax() <= 1e-14 * whole.innovation.amax());
        prop_assert!((&whole.impulse - (&first.impulse + &second.impulse)).amax() <= 1e-13 * whole.impulse.amax());
    }

    /// The cubic step never increases V = e'Pe, and the whole step obeys its error equation, at every period.
    #[test]
    fn the_step_decreases_v(case in radial(), decade in -6.0f64..6.0, rho in -0.99f64..0.99) {
        let Radial { p, c, n, theta, w, e } = case;
        let (states, outputs, h) = (p.nrows(), c.nrows(), 10f64.powf(decade));
        // Ad - Ld C = rho I contracts in every norm.
        let ld = DMatrix::from_fn(states, outputs, |i, j| 0.3 * (i as f64 + 1.0) - 0.2 * j as f64);
        let ad = DMatrix::identity(states, states) * rho + &ld * &c;
        let bd = DMatrix::from_element(states, 1, 0.5);
        let observer = SampledCubicObserver::new(SampledCubicGains {
            ad: ad.clone(), bd: bd.clone(), c: c.clone(), ld, n: n.clone(), theta: theta.clone(), w, period: h,
        }).unwrap();
        let x = DVector::from_element(states, 1.0) * e.amax();
        let mut xhat = &x - &e;
        let u = DVector::from_element(1, -2.0);
        observer.step(0.0, &mut xhat, &u, &(&c * &x));
        let after = ad * &x + bd * &u - &xhat;

        let moved = flow(&theta, w, &(&c * &e), h);
        let cubic = &e + &n * moved.impulse;
        let rounding = 1e-9 * e.amax() * (1.0 + n.amax() / w);
        prop_assert!((&after - &cubic * rho).amax() <= rounding);
        let v = |e: &DVector<f64>| e.dot(&(&p * e));
        prop_assert!(v(&cubic).sqrt() <= v(&e).sqrt() * (1.0 + 1e-9));
        prop_assert!(v(&after).sqrt() <= rho.abs() * v(&e).sqrt() * (1.0 + 1e-9) + rounding * p.amax().sqrt() * states as f64);
    }

    /// Finite samples up to 1e150 give a finite estimate; the innovation shrinks and keeps its sign.
    #[test]
    fn huge_samples_stay_finite(exponent in -150.0f64..150.0, h in 1e-6f64..1e6) {
        let y = 10f64.powf(exponent);
        let observer = double_integrator(h);
        let mut xhat = Vector2::zeros();
        observer.step(0.0, &mut xhat, &Vector1::new(0.0), &Vector1::new(y));
        prop_assert!(xhat.iter().all(|entry| entry.is_finite()));
        let after = flow(observer.theta(), observer.w(), &Vector1::new(y), h);
        prop_assert!(after.innovation[0] >= 0.0 && after.innovation[0] <= y * (1.0 + 1e-15));
        prop_assert!(after.impulse[0] >= 0.0 && after.impulse[0] <= y / observer.w() * (1.0 + 1e-12));
    }
}

fn double_integrator(h: f64) -> SampledCubicObserver<f64, nalgebra::Const<2>, nalgebra::Const<1>, nalgebra::Const<1>> {
    let (ad, bd) = (Matrix2::new(1.0, h, 0.0, 1.0), Vector2::new(h * h / 2.0, h));
    let (c, n) = (RowVector2::new(1.0, 0.0), Vector2::new(-168.0 / 17.0, -196.0 / 17.0));
    SampledCubicObserver::new(SampledCubicGains {
        ad,
        bd,
        c,
        ld: Vector2::new(0.9, 0.2 / h),
        n,
        theta: Matrix1::new(10.0),
        w: cubic::rate(&c, &n),
        period: h,
    })
    .unwrap()
}

/// Independent check of the closed form: classical Runge-Kutta on y~' = -w theta y~^3 and its impulse, p = 1.
#[test]
fn the_flow_matches_an_integrator() {
    let (w, theta, y0, t) = (3.0, 0.7, 1.5, 2.0);
    let steps = 20_000;
    let (mut y, mut impulse, h) = (y0, 0.0, t / f64::from(steps));
    for _ in 0..steps {
        let f = |y: f64| -w * theta * y * y * y;
        let (k1, k2) = (f(y), f(y + h / 2.0 * f(y)));
        let k3 = f(y + h / 2.0 * k2);
        let k4 = f(y + h * k3);
        // The impulse grows by -1/w of what y~ loses.
        let next = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        impulse += (y - next) / w;
        y = next;
    }
    let after = flow(&Matrix1::new(theta), w, &Vector1::new(y0), t);
    assert!((after.innovation[0] - y).abs() < 1e-12 && (after.impulse[0] - impulse).abs() < 1e-12);
}

#[test]
fn single_precision_follows_double() {
    let observer = double_integrator(1e-3);
    let single = SampledCubicObserver::new(SampledCubicGains {
        ad: observer.ad().cast::<f32>(),
        bd: observer.bd().cast(),
        c: observer.c().cast(),
        ld: observer.ld().cast(),
        n: observer.n().cast(),
        theta: observer.theta().cast(),
        w: observer.w() as f32,
        period: 1e-3,
    })
    .unwrap();
    let (mut xhat, mut xhat32) = (Vector2::<f64>::zeros(), Vector2::<f32>::zeros());
    for _ in 0..1000 {
        observer.step(0.0, &mut xhat, &Vector1::new(0.0), &Vector1::new(100.0));
        single.step(0.0, &mut xhat32, &Vector1::new(0.0), &Vector1::new(100.0));
    }
    assert!((xhat - xhat32.cast()).norm() < 1e-3 * xhat.norm(), "{xhat} {xhat32}");
}

#[test]
fn an_idle_cubic_part_leaves_the_linear_observer() {
    let ad = SMatrix::<f64, 2, 2>::new(1.0, 0.1, 0.0, 1.0);
    let (c, ld) = (RowVector2::new(1.0, 0.0), Vector2::new(0.5, 0.25));
    let observer = SampledCubicObserver::new(SampledCubicGains {
        ad,
        bd: Vector2::new(0.0, 0.1),
        c,
        ld,
        n: Vector2::zeros(),
        theta: Matrix1::new(1.0),
        w: 0.0,
        period: 0.1,
    });
    let (observer, mut xhat) = (observer.unwrap(), Vector2::new(1.0, 2.0));
    observer.step(0.0, &mut xhat, &Vector1::new(3.0), &Vector1::new(2.0));
    assert!((xhat - Vector2::new(1.2 + 0.5, 2.0 + 0.3 + 0.25)).norm() < 1e-15);
}

#[test]
fn bad_data_are_errors() {
    let make = |theta: SMatrix<f64, 2, 2>, n: SMatrix<f64, 2, 2>, w: f64, h: f64| {
        let identity = SMatrix::<f64, 2, 2>::identity();
        let bd = SMatrix::<f64, 2, 0>::zeros();
        SampledCubicObserver::new(SampledCubicGains {
            ad: identity,
            bd,
            c: identity,
            ld: identity * 0.5,
            n,
            theta,
            w,
            period: h,
        })
        .map(|_| ())
    };
    let identity = SMatrix::<f64, 2, 2>::identity();
    assert_eq!(make(identity, -identity, 1.0, 0.1), Ok(()));
    assert!(matches!(make(identity, -identity, 1.0, 0.0), Err(ObserverError::Period { .. })));
    assert!(matches!(make(identity, -identity, 1.0, f64::NAN), Err(ObserverError::Period { .. })));
    assert!(matches!(make(identity, identity, -1.0, 0.1), Err(ObserverError::Rate { .. })));
    assert!(matches!(make(identity, -identity, 0.0, 0.1), Err(ObserverError::Rate { w: 0.0 })));
    let skewed = SMatrix::<f64, 2, 2>::new(-1.0, 0.1, 0.0, -1.0);
    assert!(matches!(make(identity, skewed, 1.0, 0.1), Err(ObserverError::NotRadial { .. })));
    let indefinite = SMatrix::<f64, 2, 2>::new(1.0, 2.0, 2.0, 1.0);
    assert!(matches!(make(indefinite, -identity, 1.0, 0.1), Err(ObserverError::ThetaIndefinite { row: 1, .. })));
    let hollow = SMatrix::<f64, 2, 2>::new(0.0, 1.0, 1.0, 1.0);
    assert!(matches!(make(hollow, -identity, 1.0, 0.1), Err(ObserverError::ThetaIndefinite { row: 0, .. })));
    // v'theta v is that of the symmetric part, and v1^2 + 4 v1 v2 + v2^2 is indefinite: no pivot of theta itself says
    // so.
    let triangular = SMatrix::<f64, 2, 2>::new(1.0, 4.0, 0.0, 1.0);
    assert!(matches!(make(triangular, -identity, 1.0, 0.1), Err(ObserverError::ThetaIndefinite { row: 1, .. })));
    // Semidefinite, and definite only in its symmetric part, are fine.
    assert_eq!(make(SMatrix::<f64, 2, 2>::new(1.0, 1.0, 1.0, 1.0), -identity, 1.0, 0.1), Ok(()));
    assert_eq!(make(SMatrix::<f64, 2, 2>::new(1.0, 5.0, -5.0, 1.0), -identity, 1.0, 0.1), Ok(()));
    assert_eq!(make(SMatrix::<f64, 2, 2>::from_diagonal(&Vector2::new(0.0, 2.0)), -identity, 1.0, 0.1), Ok(()));
}

proptest! {
    /// theta = D D' >= 0 of every rank and in every order of its rows is admissible, and D D' - v v' with a v outside
    /// the range of D is not.
    #[test]
    fn every_semidefinite_theta_is_admissible(entries in prop::array::uniform16(-4..=4_i32), rank in 0..=4_usize, unit in -300..=300_i32) {
        // In sixteenths: D D' is not rounded. The last row of D is that of an output nobody weighs.
        let d = DMatrix::from_fn(5, rank, |i, j| if i < 4 { f64::from(entries[4 * j + i]) / 4.0 } else { 0.0 });
        let theta = &d * d.transpose();
        let identity = DMatrix::<f64>::identity(5, 5);
        let make = |theta: DMatrix<f64>| {
            SampledCubicObserver::new(SampledCubicGains {
                ad: identity.clone(), bd: DMatrix::zeros(5, 0), c: identity.clone(), ld: &identity * 0.5,
                n: -&identity, theta, w: 1.0, period: 0.1,
            })
        };
        let unit = 10f64.powi(unit);
        prop_assert!(make(&theta * unit).is_ok(), "{theta}");
        for (row, size) in [(4, 0.0), (0, 0.5)] {
            let mut v = DVector::zeros(5);
            (v[4], v[row]) = (0.25, if row == 4 { 0.25 } else { size });
            let refused = make((&theta - &v * v.transpose()) * unit);
            prop_assert!(matches!(refused, Err(ObserverError::ThetaIndefinite { .. })), "{refused:?}");
        }
    }
}

/// What a certificate of the running observer says that it computes, written out for two states and two outputs.
fn formula(theta: [[f32; 2]; 2], w: f32, h: f32, z: [f32; 2]) -> ([f32; 2], [f32; 2]) {
    let s = z[0].abs().max(z[1].abs());
    if s == 0.0 {
        return (z, z);
    }
    let d = [z[0] / s, z[1] / s];
    let weighted = theta.map(|row| row[0] * d[0] + row[1] * d[1]);
    let q = (d[0] * weighted[0] + d[1] * weighted[1]).max(0.0);
    let k = (2.0 * q) * h;
    let b = (w * k).sqrt();
    let c = b * s;
    let a = (1.0 + c * c).sqrt();
    let (p, next) = if c > 8_388_608.0 { (1.0 / b, 1.0 / b) } else { (s / a, s / (1.0 + a)) };
    let pull = ((k * p) * next) * s;
    ([pull * d[0], pull * d[1]], [p * d[0], p * d[1]])
}

proptest! {
    /// Bit by bit, for weights that are semidefinite or not, and for gains and innovations of every size.
    #[test]
    fn the_flow_computes_what_certificates_say(
        theta in prop::array::uniform4((-1.0..1.0_f32, -40..40_i32)),
        z in prop::array::uniform2((-1.0..1.0_f32, 0..60_i32)),
        w in -60..60_i32,
        h in -20..10_i32,
    ) {
        let scaled = |(x, k): (f32, i32)| x * 2.0_f32.powi(k);
        // The impulse is at most |z|/w < 2^62: beyond the root of the largest number the code caps it, which
        // certificates exclude.
        let z = z.map(|(x, below)| (x, 30.min(w + 62) - below));
        let (theta, z, w, h) = (theta.map(scaled), z.map(scaled), 2.0_f32.powi(w), 2.0_f32.powi(h));
        let after = flow(&Matrix2::new(theta[0], theta[1], theta[2], theta[3]), w, &Vector2::new(z[0], z[1]), h);
        let (impulse, innovation) = formula([[theta[0], theta[1]], [theta[2], theta[3]]], w, h, z);
        prop_assert_eq!(after.impulse.as_slice(), &impulse);
        prop_assert_eq!(after.innovation.as_slice(), &innovation);
        // r is in [0, 1], whatever the sign of theta.
        prop_assert!((0..2).all(|i| innovation[i].abs() <= z[i].abs() * (1.0 + 2.0 * f32::EPSILON) && innovation[i] * z[i] >= 0.0));
    }
}

#[test]
fn a_gain_at_the_end_of_the_range_is_no_nan() {
    // 2 w is beyond binary32, and nothing asks for it.
    for theta in [0.0, 1e-30, 1.0] {
        let after = flow(&Matrix1::new(theta), 2.0_f32.powi(127), &Vector1::new(1e-3), 1e-3);
        assert!(after.innovation[0].is_finite() && after.impulse[0].is_finite(), "{after:?}");
    }
}
