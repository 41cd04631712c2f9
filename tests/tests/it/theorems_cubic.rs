//! The theorems of the cubic observer as properties of random systems, in their corrected form, and counterexamples to
//! the false forms. Statements and proofs: docs/theory-cubic.md.

use luenberger_design::robust::{PolytopicDesign, certify_gain, fixed_lyapunov_margin, theorem5_bound};
use luenberger_design::{
    CubicDesign, CubicGain, DesignError, FeedbackDesign, InfeasibilityReason, LinearDesign, LyapunovWeight,
    SampledCubicDesign, Theorem1, cubic_lmi_design, theta_from_importance,
};
use luenberger_linalg::{lqr, spectral_abscissa};
use luenberger_lmi::proof_matrix;
use luenberger_observers::{Observer, SampledObserver, cubic};
use luenberger_plants::{StateSpace, double_integrator, third_order};
use luenberger_proof::Verdict;
use luenberger_proof::certificate::Theorem;
use luenberger_proof::statement::decay_rate;
use luenberger_sim::{Integrand, Scenario, Signal, SimError, metrics};
use nalgebra::{DMatrix, DVector, dmatrix};
use proptest::prelude::*;

use crate::examples::example_1;
use crate::generators::{accretive, linear, matrix, observable_plant};

/// The first `n` entries, times `size`.
fn head(entries: &DMatrix<f64>, n: usize, size: f64) -> DVector<f64> {
    DVector::from_fn(n, |i, _| entries[(i, 0)] * size)
}

/// Any theta = theta' >= 0, the singular ones among them: `D D'` with the first `rank` columns of D in sixteenths, so
/// that no product is rounded and the stored theta is nonnegative itself. The first diagonal entry is at least 1: theta
/// is not 0.
fn importance() -> impl Strategy<Value = (Vec<i32>, usize)> {
    (prop::collection::vec(-4..=4, 36), 1..=6_usize)
}

/// The p x p theta of [`importance`].
fn theta(p: usize, (entries, rank): &(Vec<i32>, usize)) -> DMatrix<f64> {
    let d = DMatrix::from_fn(p, (*rank).min(p), |i, j| {
        f64::from(if i == 0 && j == 0 { 4 } else { entries[6 * i + j] }) / 4.0
    });
    &d * d.transpose()
}

fn assert_proved(design: &CubicDesign) {
    assert!(design.certificate.is_proved(), "{}", design.certificate);
    let theorem = design.certificate.theorems()[0].theorem();
    assert!(matches!(theorem, Theorem::CubicConvergence(_)), "{}", design.certificate);
}

/// The errors of both observers for a plant at rest, so that no growth of x spoils x - xhat.
fn race(design: &CubicDesign, linear: &LinearDesign, e0: &DVector<f64>, end: f64) -> luenberger_sim::Trajectory {
    let xhat0: Vec<f64> = e0.iter().map(|e| -e).collect();
    let o = &design.observer;
    let plant = StateSpace::new(o.a.clone(), o.b.clone(), o.c.clone()).unwrap();
    Scenario::new(plant)
        .observer("cubic", o.clone(), &xhat0)
        .observer("linear", linear.observer.clone(), &xhat0)
        .integral("cubic", Integrand::squared_error("cubic"))
        .until(end, 101)
        .run()
        .unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Theorem 2 with (13'): for every admissible S the conditions are proved, and V never grows.
    #[test]
    fn the_general_cubic_gain_is_admissible(
        plant in observable_plant(1..=6), d in matrix(6, 6), k in matrix(6, 6), e0 in matrix(6, 1), size in 0.1..30.0, weights in importance(),
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let linear = linear(&plant, 1.0);
        let s = accretive(p, &d, &k);
        let design = CubicDesign::new(&linear, &theta(p, &weights), &CubicGain::General(s)).unwrap();
        assert_proved(&design);
        // P N = -C'S with S itself: S' is admissible too, and V cannot tell the two apart.
        let miss = &design.p * &design.observer.n + plant.c.transpose() * &design.s;
        prop_assert!(miss.norm() <= 64.0 * n as f64 * f64::EPSILON * design.p.norm() * design.observer.n.norm(), "{miss}");
        let e0 = head(&e0, n, size);
        let run = race(&design, &linear, &e0, 3.0);
        let v = metrics::lyapunov(&run, "cubic", &design.p).unwrap();
        for pair in v.windows(2) {
            prop_assert!(pair[1] <= pair[0] * (1.0 + 1e-9), "V grew from {} to {}", pair[0], pair[1]);
        }
    }

    /// (5) and (14) with every entry of theta: N = -gamma P^-1 C'theta, and the error moves by F e + (y'theta y) N y,
    /// both written out entry by entry.
    #[test]
    fn the_whole_of_theta_is_in_the_gain_and_in_the_observer(
        plant in observable_plant(1..=6), weights in importance(), e in matrix(6, 1), size in 0.1..30.0, gamma in 2..160,
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        // In sixteenths, so that S = gamma theta is not rounded: a singular S that is fails S + S' >= 0 by its
        // rounding.
        let gamma = f64::from(gamma) / 16.0;
        let (linear, theta) = (linear(&plant, 1.0), theta(p, &weights));
        let design = CubicDesign::new(&linear, &theta, &CubicGain::Gamma(gamma)).unwrap();
        assert_proved(&design);
        let o = &design.observer;
        let pn = &design.p * &o.n;
        let rounding = 64.0 * n as f64 * f64::EPSILON * design.p.norm() * o.n.norm();
        for i in 0..n {
            for j in 0..p {
                let expected: f64 = (0..p).map(|k| -gamma * plant.c[(k, i)] * theta[(k, j)]).sum();
                prop_assert!((pn[(i, j)] - expected).abs() <= rounding, "P N at ({i}, {j}): {} and {expected}", pn[(i, j)]);
            }
        }
        let e = head(&e, n, size);
        let y: Vec<f64> = (0..p).map(|k| (0..n).map(|i| plant.c[(k, i)] * e[i]).sum()).collect();
        let weight: f64 = (0..p).flat_map(|j| (0..p).map(move |k| (j, k))).map(|(j, k)| y[j] * theta[(j, k)] * y[k]).sum();
        // A plant at rest: the error is minus the estimate.
        let slope = -o.derivative(0.0, &-&e, &DVector::zeros(1), &DVector::zeros(p));
        let sizes = (plant.a.norm() + o.l.norm() * plant.c.norm()) * e.norm() + theta.norm() * o.n.norm() * (plant.c.norm() * e.norm()).powi(3);
        for i in 0..n {
            let along: f64 = (0..n).map(|j| plant.a[(i, j)] * e[j]).sum();
            let expected = along + (0..p).map(|k| (weight * o.n[(i, k)] - o.l[(i, k)]) * y[k]).sum::<f64>();
            prop_assert!((slope[i] - expected).abs() <= 64.0 * n as f64 * f64::EPSILON * sizes, "e{}': {} and {expected}", i + 1, slope[i]);
        }
    }

    /// Theorem B: for Q = rho I the accumulated squared error never exceeds e(0)'Pe(0)/rho, which is the linear
    /// observer's.
    #[test]
    fn the_cubic_cost_never_exceeds_the_linear_one(
        plant in observable_plant(1..=5), d in matrix(5, 5), k in matrix(5, 5), e0 in matrix(5, 1), size in 0.1..10.0, rho in 0.1..10.0,
        weights in importance(),
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let linear = linear(&plant, rho);
        let design =
            CubicDesign::new(&linear, &theta(p, &weights), &CubicGain::General(accretive(p, &d, &k))).unwrap();
        let e0 = head(&e0, n, size);
        let run = race(&design, &linear, &e0, 20.0);
        let bound = e0.dot(&(&design.p * &e0)) / rho;
        prop_assert!(run.integral_trace("cubic").unwrap().last() <= bound * (1.0 + 1e-9));
    }

    /// Theorem 3: at equal error norms V_c' <= V_l', from the right-hand side that runs.
    #[test]
    fn the_derivative_of_v_is_never_above_the_linear_one(
        plant in observable_plant(1..=6), d in matrix(6, 6), k in matrix(6, 6), e in matrix(6, 1), size in 0.1..1e3, weights in importance(),
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let (s, theta) = (accretive(p, &d, &k), theta(p, &weights));
        let design = CubicDesign::new(&linear(&plant, 1.0), &theta, &CubicGain::General(s.clone())).unwrap();
        let e = head(&e, n, size);
        let slope = -design.observer.derivative(0.0, &-&e, &DVector::zeros(1), &DVector::zeros(p));
        let pe = &design.p * &e;
        let rounding = 16.0 * n as f64 * f64::EPSILON * pe.norm() * slope.norm().max((&design.q * &e).norm());
        prop_assert!(2.0 * pe.dot(&slope) <= -e.norm_squared() + rounding);
        // By exactly -(y'theta y) y'(S + S')y, with every entry of theta and of S.
        let y = &plant.c * &e;
        let less = 2.0 * y.dot(&(&theta * &y)) * y.dot(&(&s * &y));
        prop_assert!((2.0 * pe.dot(&slope) + e.norm_squared() + less).abs() <= rounding, "{} and {less}", 2.0 * pe.dot(&slope) + e.norm_squared());
    }

    /// Theorem 4: a common P of the vertices decreases V for every plant between them.
    #[test]
    fn a_polytope_is_certified_between_its_vertices(plant in observable_plant(2..=4), spread in matrix(4, 4), share in 0.0..1.0) {
        let n = plant.a.nrows();
        // With F'P + PF = -I the nominal gain and P serve every |step| < 1/(2|P|), so that the inequality is feasible
        // by construction.
        let direction = spread.view((0, 0), (n, n)) + DMatrix::identity(n, n) * 0.01;
        let step = &direction * (0.2 / (linear(&plant, 1.0).p.norm() * direction.norm()));
        let vertices = [&plant.a - &step, &plant.a + &step];
        let design = PolytopicDesign::new(&plant, &vertices, 0.0).unwrap();
        prop_assert!(design.certificate.is_proved(), "{}", design.certificate);
        let a = &vertices[0] * share + &vertices[1] * (1.0 - share);
        let f = a - design.nominal.l() * &plant.c;
        let half: DMatrix<f64> = &design.nominal.p * f;
        prop_assert!(luenberger_linalg::lambda_max(&(&half + half.transpose())).unwrap() < 0.0);
    }

    /// For S = gamma theta two solutions approach each other in the P norm.
    #[test]
    fn the_error_flow_is_a_contraction(
        plant in observable_plant(1..=5), first in matrix(5, 1), second in matrix(5, 1), size in 0.1..10.0, gamma in 0.1..10.0, weights in importance(),
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let linear = linear(&plant, 1.0);
        let design = CubicDesign::new(&linear, &theta(p, &weights), &CubicGain::Gamma(gamma)).unwrap();
        let at = |e: &DMatrix<f64>| head(e, n, size);
        let (one, other) = (race(&design, &linear, &at(&first), 2.0), race(&design, &linear, &at(&second), 2.0));
        let gap = &one.observer("cubic").unwrap().error - &other.observer("cubic").unwrap().error;
        let distance: Vec<f64> = gap.row_iter().map(|g| (g * &design.p * g.transpose())[(0, 0)]).collect();
        for pair in distance.windows(2) {
            prop_assert!(pair[1] <= pair[0] * (1.0 + 1e-7) + 1e-18);
        }
    }

    /// Theorem 5: (23) suffices for its P, and is the supremum for Q = rho I.
    #[test]
    fn the_bound_of_theorem_5_is_sufficient_and_tight_for_its_p(plant in observable_plant(1..=6)) {
        let design = linear(&plant, 1.0);
        let bound = theorem5_bound(&design.p, &design.q).unwrap();
        let exact = fixed_lyapunov_margin(&design.p, &design.q).unwrap();
        prop_assert!((exact - bound).abs() <= 1e-9 * bound * design.p.norm() * design.p.clone().try_inverse().unwrap().norm());
        let n = plant.a.nrows();
        // Strictly below the bound: at it the decay need not be exponential (`at_equality_of_theorem_5_..`), and with a
        // singular theta there may be none.
        let shifted = design.error_matrix() + DMatrix::identity(n, n) * (bound * (1.0 - 1e-6));
        prop_assert!(spectral_abscissa(&shifted).unwrap() < 0.0);
        // For this P it is the supremum: proved below it, refuted above it.
        let o = &design.observer;
        let at = |eps: f64| decay_rate(&proof_matrix(&o.a), &proof_matrix(&o.l), &proof_matrix(&o.c), &proof_matrix(&design.p), eps).unwrap();
        let room = 1e-6;
        prop_assert!(at(bound * (1.0 - room)).is_proved());
        prop_assert!(at(bound * (1.0 + room)).is_refuted());
    }

    /// Theorem 5 for every Q > 0: (23) suffices, below the greatest margin that this P has, and that margin is
    /// `F'P + PF + 2 eps P < 0` exactly.
    #[test]
    fn the_bound_of_theorem_5_suffices_for_every_q(plant in observable_plant(1..=6), root in matrix(6, 6)) {
        let n = plant.a.nrows();
        let root = root.view((0, 0), (n, n));
        let q = root * root.transpose() + DMatrix::identity(n, n) * 0.1;
        let poles: Vec<f64> = (0..n).map(|k| -1.0 - 0.4 * k as f64).collect();
        let design = LinearDesign::with_poles_and_weight(&plant, &poles, LyapunovWeight::Matrix(q)).unwrap();
        let bound = theorem5_bound(&design.p, &design.q).unwrap();
        let margin = fixed_lyapunov_margin(&design.p, &design.q).unwrap();
        prop_assert!(bound <= margin * (1.0 + 1e-9), "{bound} {margin}");
        let o = &design.observer;
        let at = |eps: f64| decay_rate(&proof_matrix(&o.a), &proof_matrix(&o.l), &proof_matrix(&o.c), &proof_matrix(&design.p), eps).unwrap();
        let room = 1e-6;
        prop_assert!(at(bound * (1.0 - room)).is_proved() && at(margin * (1.0 - room)).is_proved());
        prop_assert!(at(margin * (1.0 + room)).is_refuted());
    }

    /// Theorem 6: (25) has a P1 for every stabilising K.
    #[test]
    fn the_loop_is_certified_for_every_stabilising_feedback(
        plant in observable_plant(1..=5), input in matrix(5, 5), weights in importance(), rho in 0.01..10.0,
    ) {
        let n = plant.a.nrows();
        // A full-rank input, so that every plant is stabilisable by construction.
        let b = input.view((0, 0), (n, n)) + DMatrix::identity(n, n) * 3.0;
        let plant = StateSpace::new(plant.a, b, plant.c).unwrap();
        let p = plant.c.nrows();
        let k = lqr(&plant.a, &plant.b, &DMatrix::identity(n, n), &DMatrix::identity(n, n)).unwrap().k;
        let linear = linear(&plant, rho);
        let observer = CubicDesign::new(&linear, &theta(p, &weights), &CubicGain::Gamma(1.0)).unwrap();
        for feedback in [FeedbackDesign::linear(&linear, &k), FeedbackDesign::cubic(&observer, &k)] {
            let feedback = feedback.unwrap();
            prop_assert!(feedback.certificate.is_proved(), "{}", feedback.certificate);
        }
    }

    /// The joint inequality is feasible for every detectable pair, and its solution is proved.
    #[test]
    fn the_joint_inequality_is_feasible_for_every_observable_pair(plant in observable_plant(1..=5), weights in importance()) {
        let p = plant.c.nrows();
        let design = cubic_lmi_design(&plant, &theta(p, &weights), 0.0, 1.0).unwrap();
        assert_proved(&design);
        // S comes out of an inequality that any multiple of it solves; its size is the one asked for.
        prop_assert!((design.s.norm() - 1.0).abs() <= 4.0 * p as f64 * f64::EPSILON, "{}", design.s);
    }

    /// Theorem C: the sampled observer is proved at every period, and its V never grows.
    #[test]
    fn the_sampled_observer_decreases_v_at_every_period(
        plant in observable_plant(1..=4), e0 in matrix(4, 1), size in 1.0..1e3, period in 1e-3..0.3, w in 0.1..100.0, weights in importance(),
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let theta = theta(p, &weights);
        let design = SampledCubicDesign::new(&linear(&plant, 1.0), &theta, w, period).unwrap();
        prop_assert!(design.certificate.is_proved(), "{}", design.certificate);
        // A plant at rest: the error is minus the estimate.
        let mut xhat = head(&e0, n, size);
        let (u, y) = (DVector::zeros(1), DVector::zeros(p));
        let mut v = xhat.dot(&(&design.p * &xhat));
        for step in 0..50 {
            // The flow's closed form with every entry of theta, then the linear step: x at rest, so that y~ = -C xhat.
            let o = &design.observer;
            let innovation = -(o.c() * &xhat);
            let w = o.w();
            let r = 1.0 / (1.0 + 2.0 * w * period * innovation.dot(&(&theta * &innovation))).sqrt();
            let between = &xhat + o.n() * &innovation * ((r - 1.0) / w);
            let expected = o.ad() * &between + o.ld() * (&innovation * r);
            // C xhat may be small beside its terms, which are rounded.
            let measured = o.c().norm() * xhat.norm();
            let size = (o.ad().norm() * (xhat.norm() + o.n().norm() * measured / w) + o.ld().norm() * measured) * 64.0 * n as f64;
            design.observer.step(f64::from(step) * period, &mut xhat, &u, &y);
            prop_assert!((&xhat - &expected).norm() <= f64::EPSILON * size, "step {step}: {xhat} and {expected}");
            let next = xhat.dot(&(&design.p * &xhat));
            prop_assert!(next <= v * (1.0 + 1e-12), "V grew from {v} to {next}");
            v = next;
        }
    }
}

/// The error of an observer with `F + eps I` in the place of F, from `e0`, at these times: a plant at rest, whose
/// observer knows the perturbation.
fn error_at_equality(
    f: &DMatrix<f64>,
    c: &DMatrix<f64>,
    n: &DMatrix<f64>,
    theta: &DMatrix<f64>,
    e0: &[f64],
    times: &[f64],
) -> Vec<f64> {
    let order = f.nrows();
    let plant = StateSpace::new(f + DMatrix::identity(order, order), DMatrix::zeros(order, 0), c.clone()).unwrap();
    let observer = luenberger_observers::CubicObserver::of(
        plant.clone(),
        DMatrix::zeros(order, c.nrows()),
        n.clone(),
        theta.clone(),
    )
    .unwrap();
    let xhat0: Vec<f64> = e0.iter().map(|e| -e).collect();
    let run = Scenario::new(plant).observer("cubic", observer, &xhat0).times(times).run().unwrap();
    run.observer("cubic").unwrap().error.row_iter().map(|row| row.norm()).collect()
}

/// Theorem 5 with equality in (23), here eps = 1 for P = I and Q = 2 I: with (A, C) observable, theta > 0 and S + S' >
/// 0 the error tends to 0 (LaSalle), like 1/sqrt(1 + 3t/4) and not exponentially.
#[test]
fn at_equality_of_theorem_5_the_error_decays_like_a_root() {
    let f = dmatrix![-1.0, 1.0; -1.0, -1.0];
    assert_eq!(theorem5_bound(&DMatrix::identity(2, 2), &(DMatrix::identity(2, 2) * 2.0)).unwrap(), 1.0);
    let sizes = |n: f64| {
        error_at_equality(
            &f,
            &dmatrix![1.0, 0.0],
            &dmatrix![n; 0.0],
            &dmatrix![1.0],
            &[0.0, 1.0],
            &[0.0, 60.0, 1e3, 1e4],
        )
    };
    for (found, expected) in sizes(-1.0)[1..].iter().zip([0.148, 0.0365, 0.0115]) {
        // Three digits.
        assert!((found / expected - 1.0).abs() < 5e-3, "{found}, {expected}");
    }
    // S = 0, which (13') admits, leaves an error that turns for ever.
    assert!((sizes(0.0)[3] - 1.0).abs() < 1e-6, "{:?}", sizes(0.0));
}

/// Within the printed hypotheses, theta >= 0 among them, equality is not enough: C = I, A - LC = -I, P = I, Q = 2 I, N
/// = -I, theta = diag(1, 0).
#[test]
fn at_equality_of_theorem_5_a_singular_theta_leaves_an_error() {
    let (one, theta) = (DMatrix::identity(2, 2), dmatrix![1.0, 0.0; 0.0, 0.0]);
    let stays = error_at_equality(&-&one, &one, &-&one, &theta, &[0.0, 1.0], &[0.0, 60.0]);
    assert_eq!(stays, [1.0, 1.0]);
    // With theta > 0 it goes: e' = -|e|^2 e, |e| = 1/sqrt(1 + 2t).
    let goes = error_at_equality(&-&one, &one, &-&one, &one, &[0.0, 1.0], &[0.0, 60.0]);
    assert!((goes[1] - 1.0 / 121.0_f64.sqrt()).abs() < 1e-9, "{goes:?}");
}

/// (13) as printed: refuted by an unobserved direction (in the kernel of C), for every plant with fewer outputs than
/// states.
#[test]
fn the_strict_condition_has_a_verified_counterexample() {
    let (plant, _, cubic) = example_1();
    let o = &cubic.observer;
    let conditions = Theorem1::examine(&plant, &o.l, &o.n, &o.theta, &cubic.p).unwrap();
    assert!(matches!(conditions.strict, Verdict::Refuted { .. }), "{:?}", conditions.strict);
}

/// "Faster": from e(0) = (-3, 3) the cubic observer of Example 1 settles 0.2 s later.
#[test]
fn the_cubic_observer_is_not_faster_from_everywhere() {
    let (_, linear, cubic) = example_1();
    let run = race(&cubic, &linear, &DVector::from_vec(vec![-3.0, 3.0]), 6.0);
    let settles = |name| metrics::settling_last(&run.error_trace(name, 1).unwrap(), 0.05).unwrap();
    assert!((settles("cubic") - 3.056).abs() < 2e-3, "{}", settles("cubic"));
    assert!((settles("linear") - 2.850).abs() < 2e-3, "{}", settles("linear"));
}

/// Example 3 as printed: no P, and a loop that ends in microseconds; with the other sign both are well.
#[test]
fn example_3_needs_the_other_sign() {
    let plant = third_order::example3().to_dynamic();
    let l = dmatrix![0.267; -1.429; 3.904];
    let k = dmatrix![-0.597, 2.004, 2.511; -0.197, 0.757, 7.510];
    let error = certify_gain(&plant, &l, &(&l * 10.0)).unwrap_err();
    let admissible = certify_gain(&plant, &l, &(&l * -10.0)).unwrap();
    assert!(admissible.certificate.is_proved() && admissible.certificate.converges_from_everywhere());
    let DesignError::Infeasible { reason: InfeasibilityReason::SignOfCn(cn), .. } = error else { panic!("{error}") };
    // 10 (0.267 - 1.429 + 2 * 3.904)
    assert!((cn - 66.46).abs() < 1e-9, "{cn}");
    let close = |factor: f64| {
        let observer =
            luenberger_observers::CubicObserver::of(plant.clone(), l.clone(), &l * factor, dmatrix![10.0]).unwrap();
        Scenario::new(&plant)
            .initial_state(&[1.0; 3])
            .observer("cubic", observer, &[0.0; 3])
            .input(Signal::feedback("cubic", k.clone()))
            .integral("cost", Integrand::quadratic_cost(DMatrix::identity(3, 3), DMatrix::identity(2, 2)))
            .until(30.0, 31)
            .run()
    };
    let SimError::BlowUp { time, .. } = close(10.0).unwrap_err() else { panic!() };
    // scipy's Radau reaches 1e8 at 4.7032e-5.
    assert!((time - 4.7032e-5).abs() < 1e-8, "{time}");
    let cost = close(-10.0).unwrap().integral_trace("cost").unwrap().last();
    // scipy's Radau at rtol 1e-9: 891.3752507.
    assert!((cost - 891.375_25).abs() < 1e-4, "{cost}");
}

/// With a Kalman gain L and P the inverse covariance, S = alpha V^-1 gives N = -alpha L.
#[test]
fn the_kalman_gain_gives_n_proportional_to_l() {
    let plant = double_integrator().to_dynamic();
    let linear = LinearDesign::kalman_with_weight(
        &plant,
        &DMatrix::identity(2, 2),
        &dmatrix![0.5],
        LyapunovWeight::InverseCovariance,
    )
    .unwrap();
    let cubic = CubicDesign::new(&linear, &dmatrix![1.0], &CubicGain::General(dmatrix![3.0 / 0.5])).unwrap();
    assert!((&cubic.observer.n + cubic.l() * 3.0).amax() < 1e-12);
    assert!(cubic.certificate.is_proved() && cubic.certificate.converges_from_everywhere(), "{}", cubic.certificate);
    let poles =
        LinearDesign::with_poles_and_weight(&plant, &[-1.0, -2.0], LyapunovWeight::InverseCovariance).unwrap_err();
    assert_eq!(poles, DesignError::NoCovariance);
}

/// p = 2: the cubic flow for any admissible S, by one quadrature and one root, against the integrator.
#[test]
fn the_flow_of_two_outputs_is_one_quadrature() {
    // y~' = (y~'y~) C N y~ with C N = M: y~ = exp(M sigma) y~0, t = int dsigma / |exp(M sigma) y~0|^2.
    let m = dmatrix![-1.0, 0.7; -0.7, -0.5];
    let y0 = DVector::from_vec(vec![2.0, -1.0]);
    let at = |sigma: f64| luenberger_linalg::expm(&(&m * sigma)).unwrap() * &y0;
    let sigma = 0.8;
    let panels = 400;
    let h = sigma / f64::from(panels);
    let simpson: f64 = (0..panels)
        .map(|k| {
            let s = f64::from(k) * h;
            let g = |s: f64| 1.0 / at(s).norm_squared();
            h / 6.0 * (g(s) + 4.0 * g(s + 0.5 * h) + g(s + h))
        })
        .sum();
    // A = 0, C = I, L = 0: the observer's error is the flow alone.
    let plant = StateSpace::new(DMatrix::zeros(2, 2), DMatrix::zeros(2, 0), DMatrix::identity(2, 2)).unwrap();
    let observer = luenberger_observers::CubicObserver::of(
        plant.clone(),
        DMatrix::zeros(2, 2),
        m.clone(),
        DMatrix::identity(2, 2),
    )
    .unwrap();
    let run = Scenario::new(plant).observer("flow", observer, &[-y0[0], -y0[1]]).until(simpson, 2).run().unwrap();
    let error = run.observer("flow").unwrap().error.row(1).transpose();
    assert!((error - at(sigma)).norm() < 1e-9);
}

/// Remark 1 with many outputs: any nonnegative importance is admissible.
#[test]
fn any_importance_of_the_outputs_is_admissible() {
    let plant = StateSpace::new(
        dmatrix![0.1, 1.0, 0.0; 0.0, 0.2, 1.0; -1.0, 0.0, 0.3],
        DMatrix::zeros(3, 0),
        dmatrix![1.0, 0.0, 0.0; 0.0, 0.0, 1.0],
    )
    .unwrap();
    for importance in [[1.0, 1.0], [5.0, 0.1], [1.0, 0.0]] {
        let theta = theta_from_importance(&importance).unwrap();
        let design = CubicDesign::new(&linear(&plant, 1.0), &theta, &CubicGain::Gamma(1.0)).unwrap();
        assert!(design.certificate.is_proved(), "{}", design.certificate);
    }
    assert!(theta_from_importance(&[1.0, -1.0]).is_err());
}

/// The closed form of the flow for one output: y~(t) = y~0 / sqrt(1 - 2 theta (C N) y~0^2 t).
#[test]
fn the_flow_of_one_output_has_its_closed_form() {
    let plant = double_integrator();
    let n = nalgebra::Vector2::new(-2.0, 1.5);
    let (theta, t, e0) = (3.0, 0.7, nalgebra::Vector2::new(1.5, -4.0));
    let w = cubic::rate(&plant.c, &n);
    let flow = cubic::flow(&nalgebra::Matrix1::new(theta), w, &(plant.c * e0), t);
    let expected = 1.5 / (1.0_f64 + 2.0 * theta * 2.0 * 1.5 * 1.5 * t).sqrt();
    assert!((flow.innovation[0] - expected).abs() < 1e-14);
}
