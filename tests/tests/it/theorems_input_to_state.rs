//! Input-to-state stability of the linear and of the cubic observer with proved constants, as a property of random
//! systems under the worst disturbances that a search finds. Statement and proof: docs/theory-cubic.md.

use luenberger_design::{
    CubicDesign, CubicGain, DecoupledPlant, DesignError, DiscreteDesign, DisturbanceBounds, ErrorBound, LinearDesign,
    TimeDomain, UnknownInputDesign, proportional_integral, with_disturbance,
};
use luenberger_observers::Observer;
use luenberger_plants::{StateSpace, double_integrator};
use luenberger_proof::certificate::{InputToStateStability, Theorem};
use nalgebra::{DMatrix, DVector, dmatrix};
use proptest::prelude::*;

use crate::examples::example_1;
use crate::generators::{accretive, linear, matrix, observable_plant};

/// The error system `e' = F e + G w + (r'theta r) N r`, `r = C e + D w`, written out here.
struct ErrorFlow {
    f: DMatrix<f64>,
    g: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    n: DMatrix<f64>,
    theta: DMatrix<f64>,
    bounds: Vec<f64>,
}

impl ErrorFlow {
    fn of(design: &CubicDesign, acting: &DisturbanceBounds) -> Self {
        let o = &design.observer;
        Self {
            f: &o.a - &o.l * &o.c,
            g: &acting.e - &o.l * &acting.d,
            c: o.c.clone(),
            d: acting.d.clone(),
            n: o.n.clone(),
            theta: o.theta.clone(),
            bounds: acting.bounds.clone(),
        }
    }

    fn slope(&self, e: &DVector<f64>, w: &DVector<f64>) -> DVector<f64> {
        let r = &self.c * e + &self.d * w;
        &self.f * e + &self.g * w + &self.n * &r * r.dot(&(&self.theta * &r))
    }

    /// The corner of the box of disturbances, or a point with some of them at -Ce/4, that raises `e'Pe` most; m is
    /// small, and all are tried.
    fn worst(&self, e: &DVector<f64>, p: &DMatrix<f64>) -> DVector<f64> {
        let m = self.bounds.len();
        let seen = self.d.transpose() * (&self.c * e) * -0.25;
        let points = (0..3_usize.pow(u32::try_from(m).unwrap())).map(|code| {
            DVector::from_fn(m, |i, _| match code / 3_usize.pow(u32::try_from(i).unwrap()) % 3 {
                0 => self.bounds[i],
                1 => -self.bounds[i],
                _ => seen[i].clamp(-self.bounds[i], self.bounds[i]),
            })
        });
        let rise = |w: &DVector<f64>| (p * e).dot(&self.slope(e, w));
        points.max_by(|a, b| rise(a).total_cmp(&rise(b))).unwrap()
    }

    /// Runs under the worst disturbances for the Lyapunov function `metric`, and returns the largest error of each
    /// component after `settled`.
    fn run(&self, mut e: DVector<f64>, bound: &ErrorBound, metric: &DMatrix<f64>, settled: f64) -> Vec<f64> {
        let v = |e: &DVector<f64>| e.dot(&(&bound.p * e));
        let (start, mut time) = (v(&e), 0.0);
        let mut largest = vec![0.0_f64; e.len()];
        for _ in 0..4000 {
            let w = self.worst(&e, metric);
            let r = (&self.c * &e).norm() + (&self.d * &w).norm();
            let h = 0.05 / (self.f.norm() + 3.0 * self.theta.norm() * r * r * self.n.norm() * self.c.norm());
            let k1 = self.slope(&e, &w);
            let k2 = self.slope(&(&e + &k1 * (h / 2.0)), &w);
            let k3 = self.slope(&(&e + &k2 * (h / 2.0)), &w);
            let k4 = self.slope(&(&e + &k3 * h), &w);
            e += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0);
            time += h;
            let allowed = (-2.0 * bound.rate * time).exp() * start + bound.level;
            assert!(v(&e) <= 1.001 * allowed, "V = {} at {time}, where {allowed} is the bound", v(&e));
            if time > settled {
                largest.iter_mut().zip(e.iter()).for_each(|(largest, e)| *largest = largest.max(e.abs()));
            }
        }
        largest
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, ..ProptestConfig::default() })]

    /// For every S with S + S' > 0, every theta > 0 and every disturbance: V(t) <= exp(-2 rate t) V(0) + level, and the
    /// bound of V' is kept at every error.
    #[test]
    fn no_disturbance_exceeds_the_proved_bound(
        plant in observable_plant(1..=3), d in matrix(3, 3), k in matrix(3, 3), weight in matrix(3, 3),
        e in matrix(3, 2), states in 0..3_usize, sizes in prop::collection::vec(-6..3_i32, 5),
        e0 in prop::collection::vec(matrix(3, 1), 6), cubic in any::<bool>(), shared in matrix(3, 1),
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let sizes: Vec<f64> = sizes.into_iter().map(|k| 2.0_f64.powi(k)).collect();
        let e = e.view((0, 0), (n, states.min(2))).into_owned();
        let mut acting = DisturbanceBounds::of_states_and_outputs(&e, &sizes[..states.min(2)], &sizes[2..2 + p]);
        if states > 0 {
            // A disturbance of the states that the outputs have as well.
            acting.d.column_mut(0).copy_from(&shared.rows(0, p));
        }
        let root = weight.view((0, 0), (p, p)).into_owned();
        let product = &root * root.transpose();
        let theta = (&product + product.transpose()) * 0.5 + DMatrix::identity(p, p) * 0.1;
        let linear = linear(&plant, 1.0);
        let design = CubicDesign::new(&linear, &theta, &CubicGain::General(accretive(p, &d, &k))).unwrap();
        let mut flow = ErrorFlow::of(&design, &acting);
        let bound = if cubic {
            ErrorBound::cubic(&design, &acting).unwrap()
        } else {
            flow.n.fill(0.0);
            ErrorBound::linear(&linear.observer, &acting).unwrap()
        };
        prop_assert!(bound.certificate.is_proved(), "{}", bound.certificate);
        for (k, e0) in e0.iter().enumerate() {
            // 3 is beyond the entries of e0: never the zero vector.
            let direction = DVector::from_fn(n, |i, _| e0[(i, 0)] + if i == k % n { 3.0 } else { 0.0 });
            let v = direction.dot(&(&bound.p * &direction));
            // Errors from far below the level to far above it.
            for exponent in [-12.0, -4.0, -1.0, 0.0, 1.0, 4.0, 12.0] {
                let e = &direction * (bound.level / v * f64::exp2(exponent)).sqrt();
                let w = flow.worst(&e, &bound.p);
                let rise = 2.0 * (&bound.p * &e).dot(&flow.slope(&e, &w));
                let allowed = 2.0 * bound.rate * (bound.level - e.dot(&(&bound.p * &e)));
                prop_assert!(rise <= allowed + 1e-9 * (rise.abs() + bound.rate * bound.level), "{rise} and {allowed}");
            }
            if k == 0 {
                let far = &direction * (bound.level / v * 100.0).sqrt();
                let settled = 6.0 / bound.rate;
                let largest = flow.run(far, &bound, &bound.p, settled);
                // What is left of V(0) = 100 level by then.
                let left = (1.0 + 100.0 * (-2.0 * bound.rate * settled).exp()).sqrt();
                for (largest, limsup) in largest.iter().zip(&bound.limsup) {
                    prop_assert!(*largest <= limsup * left * (1.0 + 1e-6), "{largest} beyond {limsup}");
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    /// The inequalities are those of the theorem, no weaker: where a number of a proved bound is made a little smaller,
    /// the fact that it is for is refuted.
    #[test]
    fn no_number_of_the_theorem_can_be_smaller(
        plant in observable_plant(2..=3), d in matrix(3, 3), k in matrix(3, 3), e in matrix(3, 1),
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let linear = linear(&plant, 1.0);
        let s = accretive(p, &d, &k);
        let design = CubicDesign::new(&linear, &DMatrix::identity(p, p), &CubicGain::General(s)).unwrap();
        let acting = DisturbanceBounds::of_states_and_outputs(&e.rows(0, n).into_owned(), &[0.5], &vec![0.25; p]);
        let bound = ErrorBound::cubic(&design, &acting).unwrap();
        let Theorem::InputToStateStability(theorem) = bound.certificate.theorems()[0].theorem().clone() else { panic!() };
        let refuted = |change: &dyn Fn(&mut InputToStateStability), fact: &str| {
            let mut changed = theorem.clone();
            change(&mut changed);
            let facts = Theorem::from(changed).facts().unwrap();
            let of_fact = facts.iter().find(|found| found.inequality.contains(fact)).unwrap();
            assert!(of_fact.verdict.is_refuted(), "{fact}: {}", of_fact.verdict);
        };
        let less = 1.0 - 1e-4;
        refuted(&|theorem| theorem.level *= less, "<= 2 rate level");
        refuted(&|theorem| theorem.cubic.as_mut().unwrap().kappa *= less, "kappa");
        // With one output mu is the least one; with several it is so along the worst signs only.
        let share = if p == 1 { less } else { 0.3 };
        refuted(&|theorem| theorem.cubic.as_mut().unwrap().mu.iter_mut().for_each(|mu| *mu *= share), "mu");
        refuted(&|theorem| theorem.limsup.iter_mut().for_each(|bound| *bound *= less), "limsup |e_1|");
        // The linear inequality is all but an equality.
        refuted(&|theorem| theorem.lambda.iter_mut().for_each(|lambda| *lambda *= 0.98), "lambda");
        refuted(&|theorem| theorem.rate *= 1.02, "lambda");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// The unknown-input observer, linear and cubic: `e' = (TA - LC)e + (r'theta r) N r` whatever d is, T E = 0, and V
    /// falls. E = C'(CC')^-1 R with a regular R: C E = R.
    #[test]
    fn an_unknown_input_does_not_reach_the_error(
        plant in observable_plant(1..=4), root in matrix(4, 4), x in matrix(4, 1), xhat in matrix(4, 1),
        d in matrix(4, 1), size in 0.1..30.0, q in 1..=4_usize,
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let q = q.min(p);
        let gram = (&plant.c * plant.c.transpose()).try_inverse().unwrap();
        let e = plant.c.transpose() * gram * (root.view((0, 0), (p, q)) + DMatrix::identity(p, q) * 2.0);
        let decoupled = match DecoupledPlant::new(&plant, &e) {
            Ok(decoupled) => decoupled,
            // The zeros of a random plant may be anywhere.
            Err(DesignError::UnstableZero { zero, .. }) => {
                prop_assert!(zero.re >= 0.0);
                return Err(TestCaseError::reject("a zero in the right half plane"));
            }
            Err(error) => panic!("{error}"),
        };
        // A zero next to the imaginary axis leaves no room for a proof.
        if decoupled.zeros.iter().any(|zero| zero.re > -1e-3) {
            return Err(TestCaseError::reject("a zero next to the imaginary axis"));
        }
        let h = &decoupled.h;
        let t = DMatrix::identity(n, n) - h * &plant.c;
        let rounding = 1e-10 * (1.0 + h.norm()) * (1.0 + e.norm());
        prop_assert!((&t * &e).norm() <= rounding, "{}", &t * &e);
        let design = LinearDesign::lmi(&decoupled.reduced).unwrap();
        let cubic = CubicDesign::new(&design, &DMatrix::identity(p, p), &CubicGain::Gamma(2.0)).unwrap();
        let observer = UnknownInputDesign::cubic(&decoupled, &cubic).unwrap();
        prop_assert!(observer.certificate.is_proved(), "{}", observer.certificate);
        let column = |m: &DMatrix<f64>, n: usize| DVector::from_fn(n, |i, _| m[(i, 0)] * size);
        let (x, xhat, d) = (column(&x, n), column(&xhat, n), column(&d, q));
        let (u, y) = (DVector::from_element(plant.b.ncols(), 0.7), &plant.c * &x);
        let state = observer.observer.initial(0.0, &xhat, &u, &y);
        let error = &x - &xhat;
        let slope = |d: &DVector<f64>| {
            // xhat = z + Hy.
            let flow = &plant.a * &x + &plant.b * &u + &e * d;
            let z = observer.observer.derivative(0.0, &state, &u, &y);
            &flow - (z + h * (&plant.c * &flow))
        };
        let r = &plant.c * &error;
        let o = &cubic.observer;
        let expected = (&t * &plant.a - &o.l * &plant.c) * &error + &o.n * &r * r.dot(&r);
        let scale = rounding * (1.0 + size) * (1.0 + plant.a.norm() + o.l.norm() + plant.b.norm())
            + 1e-10 * o.n.norm() * r.norm().powi(3);
        prop_assert!((slope(&d) - &expected).norm() <= scale, "{} and {expected}", slope(&d));
        prop_assert!((slope(&d) - slope(&(-3.0 * &d))).norm() <= scale);
        let rise = (&design.p * &error).dot(&expected);
        prop_assert!(rise < 0.0 || error.norm() == 0.0, "V rises: {rise}");
    }

    /// Theorem H': the error of `z' = TA xhat + TBu + J r`, or z+, obeys `e' = (TA - JC)e` whatever d is in the states
    /// and in the outputs, and V falls. With more outputs than unknown inputs a random plant has no zeros; with one
    /// output its zeros are those of A - E C/F, which are made stable.
    #[test]
    fn an_unknown_input_in_the_outputs_does_not_reach_the_error(
        plant in observable_plant(1..=6), e in matrix(6, 1), f in matrix(6, 1), x in matrix(6, 1), xhat in matrix(6, 1),
        d in -20.0..20.0_f64, is_discrete: bool,
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let time = if is_discrete { TimeDomain::Discrete } else { TimeDomain::Continuous };
        let e = e.rows(0, n).into_owned();
        let f = f.rows(0, p).map(|x| if x < 0.0 { x - 0.5 } else { x + 0.5 });
        let size = plant.a.norm() + 0.5;
        let plant = if p == 1 {
            let own = if is_discrete { &plant.a / (2.0 * size) } else { &plant.a - DMatrix::identity(n, n) * size };
            StateSpace::new(own + &e * &plant.c / f[(0, 0)], plant.b.clone(), plant.c.clone()).unwrap()
        } else {
            plant
        };
        let decoupled = DecoupledPlant::of_outputs(&plant, &e, &f, time).unwrap();
        let (w, v) = (DMatrix::identity(n, n), DMatrix::identity(p, p));
        let design = match time {
            TimeDomain::Continuous => {
                UnknownInputDesign::linear(&decoupled, &LinearDesign::kalman(&decoupled.reduced, &w, &v).unwrap())
            }
            TimeDomain::Discrete => {
                let linear = DiscreteDesign::kalman(&decoupled.reduced, 1.0, &w, &v).unwrap();
                UnknownInputDesign::discrete(&decoupled, &linear)
            }
        }
        .unwrap();
        prop_assert!(design.certificate.is_proved(), "{}", design.certificate);
        let (observer, h, j) = (&design.observer, design.observer.h(), design.l());
        let t = DMatrix::identity(n, n) - h * &plant.c;
        let rounding = 1e-9 * (1.0 + h.norm() + j.norm()) * (1.0 + e.norm()) * (1.0 + f.norm()) * (1.0 + plant.c.norm());
        prop_assert!((h * &f).norm() <= rounding && (&t * &e - j * &f).norm() <= rounding);
        let flow_of_error = &t * &plant.a - j * &plant.c;
        let column = |m: &DMatrix<f64>, n: usize| DVector::from_fn(n, |i, _| m[(i, 0)]);
        let (mut x, mut z) = (column(&x, n), column(&xhat, n));
        let u = DVector::from_element(plant.b.ncols(), 0.7);
        // Three steps in discrete time, or the right-hand side at three states.
        for k in 0..3 {
            let d = DVector::from_element(1, d * f64::from(k - 1));
            let y = &plant.c * &x + &f * &d;
            let error = &x - observer.estimate(0.0, &z, &u, &y);
            let flow = &plant.a * &x + &plant.b * &u + &e * &d;
            let next = observer.derivative(0.0, &z, &u, &y);
            let found = &flow - &next - h * (&plant.c * &flow);
            let expected = &flow_of_error * &error;
            let scale = rounding * (1.0 + x.norm() + z.norm() + d.norm()) * (1.0 + plant.a.norm() + plant.b.norm());
            prop_assert!((&found - &expected).norm() <= scale, "{found} and {expected}");
            (x, z) = (flow, next);
        }
    }

    /// The proportional-integral observer estimates any constant disturbance: with x = xhat and d = dhat it rests, and
    /// its error system is Hurwitz.
    #[test]
    fn a_constant_disturbance_is_estimated(plant in observable_plant(1..=4), e in matrix(4, 1), d in -3.0..3.0_f64) {
        let n = plant.a.nrows();
        let e = e.rows(0, n).into_owned();
        let both = match with_disturbance(&plant, &e) {
            Ok(both) => both,
            Err(DesignError::UnseenDisturbance { d, x, .. }) => {
                let (x, d) = (DVector::from_vec(x), DVector::from_vec(d));
                prop_assert!((&plant.a * &x + &e * d).norm() < 1e-9 && (&plant.c * x).norm() < 1e-9);
                return Ok(());
            }
            Err(error) => panic!("{error}"),
        };
        let design = LinearDesign::lmi(&both).unwrap();
        prop_assert!(design.certificate.is_proved());
        let observer = proportional_integral(design.observer.clone(), n).unwrap();
        let x = DVector::from_fn(n, |i, _| 1.0 - i as f64);
        let (u, y) = (DVector::from_element(1, 0.3), &plant.c * &x);
        let state = DVector::from_fn(n + 1, |i, _| if i < n { x[i] } else { d });
        let slope = observer.derivative(0.0, &state, &u, &y);
        let flow = &plant.a * &x + &plant.b * &u + &e * DVector::from_element(1, d);
        prop_assert!((slope.rows(0, n) - flow).norm() <= 1e-12 * (1.0 + design.l().norm()) * 10.0);
        prop_assert!(slope[n].abs() <= 1e-12 * (1.0 + design.l().norm()) * 10.0);
        prop_assert_eq!(observer.disturbance(state.as_slice()), &[d][..]);
    }
}

/// Which condition fails, and by how much.
#[test]
fn the_conditions_that_fail_are_named() {
    let plant = double_integrator().to_dynamic();
    // The velocity's disturbance is in the second derivative of the position only.
    let unmatched = DecoupledPlant::new(&plant, &dmatrix![0.0; 1.0]).unwrap_err().to_string();
    assert_eq!(
        unmatched,
        "rank(C E) is less than the number of unknown inputs, 1: for d = (1) |E d| = 1 and |C E d| = 0, so that no output has this disturbance in its first derivative"
    );
    let dependent = DecoupledPlant::new(&plant, &dmatrix![1.0, 2.0; 0.0, 0.0]).unwrap_err().to_string();
    assert!(dependent.ends_with("the columns of E are linearly dependent: leave one out"), "{dependent}");
    // C (sI - A)^-1 E = (s - 1)/s^2 for E = (1, -1).
    let unstable = DecoupledPlant::new(&plant, &dmatrix![1.0; -1.0]).unwrap_err();
    let DesignError::UnstableZero { zero, .. } = &unstable else { panic!("{unstable}") };
    assert!((zero.re - 1.0).abs() < 1e-12 && zero.im == 0.0, "{unstable}");
    // A drift of the position that the velocity cancels.
    let unseen = with_disturbance(&plant, &dmatrix![1.0; 0.0]).unwrap_err();
    let DesignError::UnseenDisturbance { d, x, outputs: 1, sigma_min, is_discrete: false } = &unseen else {
        panic!("{unseen}")
    };
    assert!((x[1] + d[0]).abs() < 1e-12 && x[0] == 0.0 && *sigma_min < 1e-12, "{unseen}");
}

/// Example 1 of the paper, the constants by hand: noise alone adds lambda v^2 by the linear part and 27/128 theta s v^4
/// by the cubic one, where `P~N = -C's`.
#[test]
fn the_constant_of_the_cubic_part_is_that_of_the_paper() {
    let (_, _, design) = example_1();
    let bound = ErrorBound::cubic(&design, &DisturbanceBounds::of_outputs(2, &[0.5])).unwrap();
    assert!(bound.certificate.is_proved(), "{}", bound.certificate);
    let Theorem::InputToStateStability(theorem) = bound.certificate.theorems()[0].theorem() else { panic!() };
    let term = theorem.cubic.as_ref().unwrap();
    // S~ = s with P~N = -C's: kappa s = theta, mu = s for one output with D = 1.
    let s = -term.x[(0, 0)] * (&design.observer.c * &design.observer.n)[(0, 0)];
    assert!((term.kappa * s - 10.0).abs() < 1e-5 && (term.mu[0] / s - 1.0).abs() < 1e-6, "{} {s}", term.kappa);
    let cubic = 27.0 / 128.0 * 10.0 * s * 0.5_f64.powi(4);
    let spent = theorem.lambda[0] * 0.25 + cubic;
    assert!((spent / (2.0 * bound.rate * bound.level) - 1.0).abs() < 1e-5, "{spent}");
    assert!((bound.cubic_share - cubic / spent).abs() < 1e-5);
    // It is attained at Ce = -v/4.
    let (v, y): (f64, f64) = (0.5, -0.125);
    assert!((-2.0 * 10.0 * (y + v).powi(3) * s * y - cubic).abs() < 1e-9 * cubic);
}

/// For the linear observer the exact peak of each error is `W int |h|`: the proved bound is not below it, and not far
/// above.
#[test]
fn the_bound_of_a_linear_observer_is_near_the_largest_error() {
    // e1' = -7 e1 + e2 - 7 v, e2' = -10 e1 - 10 v: impulse responses of poles -2 and -5, integrated by a fine sum.
    let plant = double_integrator().to_dynamic();
    let linear = LinearDesign::with_poles(&plant, &[-2.0, -5.0]).unwrap();
    let bound = ErrorBound::linear(&linear.observer, &DisturbanceBounds::of_outputs(2, &[0.1])).unwrap();
    let response = |a: f64, b: f64, t: f64| a * (-2.0 * t).exp() + b * (-5.0 * t).exp();
    // G = -(7, 10): e1 = (4/3) exp(-2t) - (25/3) exp(-5t), e2 = (20/3)(exp(-2t) - (5/2) exp(-5t)).
    let peak = |a: f64, b: f64| {
        0.1 * (0..400_000).map(|k| response(a, b, (f64::from(k) + 0.5) * 5e-5).abs() * 5e-5).sum::<f64>()
    };
    let exact = [peak(4.0 / 3.0, -25.0 / 3.0), peak(20.0 / 3.0, -50.0 / 3.0)];
    for (limsup, exact) in bound.limsup.iter().zip(exact) {
        assert!(*limsup > exact && *limsup < 2.0 * exact, "{limsup} and {exact}");
    }
}
