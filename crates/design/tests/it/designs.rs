//! The designs against closed forms and against each other.

use approx::assert_abs_diff_eq;
use std::cmp::Ordering;

use luenberger_design::robust::{
    PolytopicDesign, certify_gain, fixed_gain_margin, fixed_lyapunov_margin, input_to_state_gain, positive_real_margin,
    redesigned_margin, theorem5_bound,
};
use luenberger_design::{
    CubicDesign, CubicGain, DecoupledPlant, DesignError, FeedbackDesign, LinearDesign, LyapunovWeight,
    SampledCubicDesign, Theorem1, cubic_lmi_design, theta_from_cost_shares,
};
use luenberger_linalg::spectral_abscissa;
use luenberger_plants::{StateSpace, double_integrator, third_order};
use luenberger_proof::Verdict;
use nalgebra::{DMatrix, dmatrix, dvector};

fn example1() -> LinearDesign {
    LinearDesign::with_poles_and_weight(
        &double_integrator().to_dynamic(),
        &[-2.0, -5.0],
        LyapunovWeight::Identity(10.0),
    )
    .unwrap()
}

/// Share Pasand, Example 1: L, P and N as printed.
#[test]
fn example_1_has_its_printed_matrices_and_is_proved_as_stored() {
    let cubic = CubicDesign::new(&example1(), &dmatrix![10.0], &CubicGain::Gamma(2.0)).unwrap();
    assert_abs_diff_eq!(*cubic.l(), dmatrix![7.0; 10.0], epsilon = 1e-12);
    assert_abs_diff_eq!(cubic.p, dmatrix![55.0 / 7.0, -5.0; -5.0, 30.0 / 7.0], epsilon = 1e-13);
    assert_abs_diff_eq!(cubic.observer.n, dmatrix![-168.0 / 17.0; -196.0 / 17.0], epsilon = 1e-12);
    assert!(cubic.certificate.is_proved(), "{}", cubic.certificate);
    assert!(cubic.certificate.converges_from_everywhere(), "{}", cubic.certificate);
}

#[test]
fn the_radial_choice_makes_c_n_a_multiple_of_the_identity() {
    let plant = StateSpace::new(
        dmatrix![0.0, 1.0, 0.2; 0.3, -0.1, 1.0; 1.0, 0.0, 0.5],
        DMatrix::zeros(3, 0),
        dmatrix![1.0, 0.0, 0.3; 0.0, 1.0, -0.4],
    )
    .unwrap();
    let linear = LinearDesign::with_poles(&plant, &[-1.0, -2.0, -3.0]).unwrap();
    let cubic = CubicDesign::new(&linear, &DMatrix::identity(2, 2), &CubicGain::Radial(3.0)).unwrap();
    let cn = &cubic.observer.c * &cubic.observer.n;
    assert!((cn + DMatrix::identity(2, 2) * 3.0).amax() < 1e-12);
    assert!(cubic.certificate.is_proved(), "{}", cubic.certificate);
}

#[test]
fn the_strict_condition_is_refuted_by_the_kernel_of_c() {
    let cubic = CubicDesign::new(&example1(), &dmatrix![10.0], &CubicGain::Gamma(2.0)).unwrap();
    let o = &cubic.observer;
    let conditions = Theorem1::examine(&double_integrator().to_dynamic(), &o.l, &o.n, &o.theta, &cubic.p).unwrap();
    let facts: Vec<_> = conditions.certificate.facts().collect();
    assert!(facts.len() == 4 && facts[..3].iter().all(|fact| fact.verdict.is_proved()), "{facts:?}");
    let Verdict::Refuted { witness } = &conditions.strict else { panic!("{:?}", conditions.strict) };
    assert!(witness.value <= 0.0 || witness.value.abs() < 1e-12, "{witness:?}");
}

#[test]
fn a_decay_rate_is_reached() {
    let plant = third_order::example3().to_dynamic();
    for rate in [0.5, 2.0] {
        let design = LinearDesign::with_decay_rate(&plant, rate).unwrap();
        assert!(design.certificate.is_proved(), "{}", design.certificate);
        let abscissa = spectral_abscissa(&design.error_matrix()).unwrap();
        assert!(abscissa < -rate, "rate {rate}: spectral abscissa {abscissa}");
    }
}

#[test]
fn the_joint_design_is_proved_for_several_outputs() {
    let plant = StateSpace::new(
        dmatrix![0.4, 1.0, 0.0; -0.2, 0.3, 1.0; 0.1, 0.2, -0.5],
        dmatrix![1.0; 0.0; 1.0],
        dmatrix![1.0, 0.0, 0.0; 0.0, 0.0, 1.0],
    )
    .unwrap();
    let design = cubic_lmi_design(&plant, &DMatrix::identity(2, 2), 0.25, 2.0).unwrap();
    assert!(design.certificate.is_proved(), "{}", design.certificate);
    // (9), whichever way P was found.
    let half = &design.p * design.error_matrix();
    assert!((&half + half.transpose() + &design.q).norm() < 1e-13 * half.norm());
    assert!(spectral_abscissa(&design.error_matrix()).unwrap() < -0.25);
}

/// Example 2: (23) is 0.00135, the positive-real margin 4.1367864216 (scipy, by bisection on the minimum of the Nyquist
/// plot), the abscissa 5.
#[test]
fn the_margins_of_example_2_are_ordered_and_right() {
    let plant = third_order::example2().to_dynamic();
    let linear =
        LinearDesign::with_poles_and_weight(&plant, &[-30.0, -10.0, -5.0], LyapunovWeight::Identity(10.0)).unwrap();
    let cubic = CubicDesign::new(&linear, &dmatrix![1.0], &CubicGain::Gamma(1.0)).unwrap();
    let (f, c, n) = (cubic.error_matrix(), &cubic.observer.c, &cubic.observer.n);
    let bound = theorem5_bound(&cubic.p, &cubic.q).unwrap();
    assert_abs_diff_eq!(bound, 0.001_350_411_303, epsilon = 1e-11);
    // Q is a multiple of I: the bound is exact for this P.
    assert_abs_diff_eq!(fixed_lyapunov_margin(&cubic.p, &cubic.q).unwrap(), bound, epsilon = 1e-10);
    let closed = positive_real_margin(&f, c, n).unwrap();
    assert_abs_diff_eq!(closed, 4.136_786_421_6, epsilon = 1e-9);
    let by_lmi = fixed_gain_margin(&plant, cubic.l(), n, 1e-3).unwrap();
    assert!(by_lmi.at_margin.certificate.is_proved() && by_lmi.at_margin.certificate.converges_from_everywhere());
    assert!(by_lmi.margin <= closed && closed - by_lmi.margin < 2e-2, "{} against {closed}", by_lmi.margin);
    assert_abs_diff_eq!(redesigned_margin(&f).unwrap(), 5.0, epsilon = 1e-8);
}

#[test]
fn a_lyapunov_matrix_is_found_for_a_gain_that_came_without_one() {
    let cubic = CubicDesign::new(&example1(), &dmatrix![10.0], &CubicGain::Gamma(2.0)).unwrap();
    let o = &cubic.observer;
    let found = certify_gain(&double_integrator().to_dynamic(), &o.l, &o.n).unwrap();
    assert!(found.certificate.is_proved() && found.certificate.converges_from_everywhere(), "{}", found.certificate);
    let (p, s) = (&found.p, &found.s);
    let miss = p * &o.n + o.c.transpose() * s;
    assert!(miss.norm() < 1e-12 * p.norm() * o.n.norm(), "{miss}");
    assert!(s[(0, 0)] > 0.0);
}

#[test]
fn a_polytope_has_one_gain_for_all_its_vertices() {
    let at = |stiffness: f64| dmatrix![0.0, 1.0; -stiffness, -0.1];
    let plant = StateSpace::new(at(1.0), DMatrix::zeros(2, 0), dmatrix![1.0, 0.0]).unwrap();
    let design = PolytopicDesign::new(&plant, &[at(0.5), at(2.0)], 0.2).unwrap();
    assert!(design.certificate.is_proved(), "{}", design.certificate);
    for stiffness in [0.5, 1.0, 1.3, 2.0] {
        let f = at(stiffness) - design.nominal.l() * &plant.c;
        assert!(spectral_abscissa(&f).unwrap() < -0.2);
    }
}

#[test]
fn the_loop_of_example_3_is_certified_with_the_right_sign() {
    let plant = third_order::example3().to_dynamic();
    let l = dmatrix![0.267; -1.429; 3.904];
    let k = dmatrix![-0.597, 2.004, 2.511; -0.197, 0.757, 7.510];
    let linear = LinearDesign::with_gain(&plant, &l).unwrap();
    let cubic = CubicDesign::new(&linear, &dmatrix![10.0], &CubicGain::Gamma(1.0)).unwrap();
    let feedback = FeedbackDesign::cubic(&cubic, &k).unwrap();
    assert!(feedback.certificate.is_proved(), "{}", feedback.certificate);
}

/// Theorem 6 for slow loops: both poles at -eps, so that P0 grows like 1/eps^3 and the share mu of P0 in (25) has to
/// fall.
#[test]
fn a_slow_loop_is_certified() {
    let cubic = CubicDesign::new(&example1(), &dmatrix![10.0], &CubicGain::Gamma(2.0)).unwrap();
    for eps in [1.0, 0.1, 0.01] {
        let feedback = FeedbackDesign::cubic(&cubic, &dmatrix![eps * eps, 2.0 * eps]).unwrap();
        assert!(feedback.certificate.is_proved(), "{eps}: {}", feedback.certificate);
    }
}

#[test]
fn shares_of_the_cost_add_up_and_an_unseen_error_has_none() {
    let plant = StateSpace::new(dmatrix![-1.0, 0.0; 0.0, -2.0], DMatrix::zeros(2, 0), DMatrix::identity(2, 2)).unwrap();
    let linear = LinearDesign::with_gain(&plant, &DMatrix::zeros(2, 2)).unwrap();
    // J_1 = 1/2 and J_2 = 1/4 per unit of e_i^2.
    let theta = theta_from_cost_shares(&linear, None, 3.0).unwrap();
    assert_abs_diff_eq!(theta, dmatrix![2.0, 0.0; 0.0, 1.0], epsilon = 1e-12);
    let theta = theta_from_cost_shares(&linear, Some(&dvector![1.0, 0.0]), 3.0).unwrap();
    assert_abs_diff_eq!(theta, dmatrix![3.0, 0.0; 0.0, 0.0], epsilon = 1e-12);
    assert!(theta_from_cost_shares(&linear, Some(&dvector![0.0, 0.0]), 3.0).is_err());
}

/// F = [-1 1; 0 -2], C = I: e2 = exp(-2t) e2(0), and e1 gets exp(-t) - exp(-2t) of e2(0). From e(0) = (0, 1), J = (1/2
/// - 2/3 + 1/4, 1/4) = (1, 3)/12; over all directions trace M_1 = 1/2 + 1/12 and trace M_2 = 1/4.
#[test]
fn shares_of_coupled_errors_are_those_along_the_error_equation() {
    let plant = StateSpace::new(dmatrix![-1.0, 1.0; 0.0, -2.0], DMatrix::zeros(2, 0), DMatrix::identity(2, 2)).unwrap();
    let linear = LinearDesign::with_gain(&plant, &DMatrix::zeros(2, 2)).unwrap();
    let theta = theta_from_cost_shares(&linear, Some(&dvector![0.0, 1.0]), 4.0).unwrap();
    assert!((theta - dmatrix![1.0, 0.0; 0.0, 3.0]).amax() < 1e-14);
    let theta = theta_from_cost_shares(&linear, None, 10.0).unwrap();
    assert!((theta - dmatrix![7.0, 0.0; 0.0, 3.0]).amax() < 1e-14);
}

/// With as many outputs as states (13) can hold as printed: C = I, P = I and N = -I give P N C + C'N'P = -2 I, and N =
/// I the contrary.
#[test]
fn the_strict_condition_holds_where_every_direction_is_seen() {
    let identity = DMatrix::identity(2, 2);
    let plant = StateSpace::new(dmatrix![0.0, 1.0; -1.0, 0.0], DMatrix::zeros(2, 0), identity.clone()).unwrap();
    let strict = |n: &DMatrix<f64>| Theorem1::examine(&plant, &identity, n, &identity, &identity).unwrap();
    let admissible = strict(&-&identity);
    assert!(admissible.strict.is_proved() && admissible.certificate.is_proved(), "{:?}", admissible.strict);
    let wrong = strict(&identity);
    assert!(wrong.strict.is_refuted() && !wrong.certificate.is_proved(), "{:?}", wrong.strict);
}

/// P = diag(1, 4) and Q = 2 alpha P, of `e' = -alpha e`: the margin is alpha, and the ultimate bound sqrt(4/1)/alpha.
#[test]
fn the_gain_from_forcing_to_error_is_the_root_of_the_condition_over_the_rate() {
    let p = dmatrix![1.0, 0.0; 0.0, 4.0];
    for alpha in [0.25, 2.0] {
        let q = &p * (2.0 * alpha);
        assert!((fixed_lyapunov_margin(&p, &q).unwrap() - alpha).abs() < 1e-15);
        assert!((input_to_state_gain(&p, &q).unwrap() - 2.0 / alpha).abs() < 1e-14);
    }
}

/// The double integrator, sampled: poles z1 and z2 take Ld = (2 - z1 - z2, (1 - z1)(1 - z2)/h), and Theorem C asks for
/// z = exp(h s). P solves the Stein equation with Q = h I.
#[test]
fn the_sampled_design_has_the_poles_and_the_strength_of_the_continuous_one() {
    let linear = example1();
    let cubic = CubicDesign::new(&linear, &dmatrix![10.0], &CubicGain::Gamma(2.0)).unwrap();
    let h = 0.125;
    let design = SampledCubicDesign::from_cubic(&linear, &cubic, h).unwrap();
    let o = &design.observer;
    let (z1, z2) = ((-2.0 * h).exp(), (-5.0 * h).exp());
    let expected = dmatrix![2.0 - z1 - z2; (1.0 - z1) * (1.0 - z2) / h];
    assert!((o.ld() - expected).amax() < 1e-13, "{}", o.ld());
    // -C N of Example 1.
    assert!((o.w() - 168.0 / 17.0).abs() < 1e-12 && (o.c() * o.n() + dmatrix![o.w()]).amax() < 1e-12);
    let f = o.ad() - o.ld() * o.c();
    let residual = f.transpose() * &design.p * &f - &design.p + DMatrix::identity(2, 2) * h;
    assert!(residual.amax() < 1e-13 * design.p.amax(), "{residual}");
}

/// C = I and N = -[1 10; 0 1]: Hurwitz, but N + N' is indefinite. P = I, which F = -5 I would like best, gives no S
/// with S + S' > 0; P = diag(1, 30) does. S = -P N is not symmetric.
#[test]
fn a_gain_that_is_not_dissipative_gets_a_lyapunov_matrix_of_its_own() {
    let plant = StateSpace::new(DMatrix::zeros(2, 2), DMatrix::zeros(2, 0), DMatrix::identity(2, 2)).unwrap();
    let n = dmatrix![-1.0, -10.0; 0.0, -1.0];
    let found = certify_gain(&plant, &(DMatrix::identity(2, 2) * 5.0), &n).unwrap();
    assert!(found.certificate.is_proved() && found.certificate.converges_from_everywhere(), "{}", found.certificate);
    let (p, s) = (&found.p, &found.s);
    assert!((p * &n + s).norm() < 1e-14 * p.norm() * n.norm(), "{p}{s}");
    assert!((s + s.transpose()).cholesky().is_some(), "{s}");
}

/// x1' = x2 needs L2 > 0 and x1' = -x2 needs L2 < 0: each alone has a gain, and the two have none in common, whichever
/// is the nominal one.
#[test]
fn the_nominal_plant_is_a_vertex_of_its_polytope() {
    let at = |sign: f64| dmatrix![0.0, sign; 0.0, 0.0];
    for nominal in [1.0, -1.0] {
        let plant = StateSpace::new(at(nominal), DMatrix::zeros(2, 0), dmatrix![1.0, 0.0]).unwrap();
        assert!(PolytopicDesign::new(&plant, &[], 0.0).unwrap().certificate.is_proved());
        assert!(PolytopicDesign::new(&plant, &[at(-nominal)], 0.0).is_err());
    }
}

/// F = [0 1; -2 -3], C = [30 1], N = (0, -1): G(s) = (s + 30)/((s + 1)(s + 2)) is positive real only after a shift of
/// -27, far to the left of the size of F.
#[test]
fn a_margin_far_to_the_left_is_found_by_both_methods() {
    let f = dmatrix![0.0, 1.0; -2.0, -3.0];
    let plant = StateSpace::new(f.clone(), DMatrix::zeros(2, 0), dmatrix![30.0, 1.0]).unwrap();
    let (l, n) = (DMatrix::zeros(2, 1), dmatrix![0.0; -1.0]);
    let closed = positive_real_margin(&f, &plant.c, &n).unwrap();
    assert_abs_diff_eq!(closed, -27.0, epsilon = 1e-9);
    let by_lmi = fixed_gain_margin(&plant, &l, &n, 1e-2).unwrap().margin;
    assert!(by_lmi <= closed + 1e-9 && closed - by_lmi < 0.5, "{by_lmi}");
}

/// The joint design at the size at which cvxpy with the same solver is said to fail.
#[test]
fn the_joint_design_of_twenty_states_and_three_outputs_is_proved() {
    // A fixed plant without structure: entries of a quadratic sequence, folded into [-1, 1].
    let entry = |k: usize| ((k * k * 7919 + 104_729 * k) % 2001) as f64 / 1000.0 - 1.0;
    let a = DMatrix::from_fn(20, 20, |i, j| entry(20 * i + j));
    let c = DMatrix::from_fn(3, 20, |i, j| entry(1000 + 20 * i + j));
    let plant = StateSpace::new(a, DMatrix::zeros(20, 0), c).unwrap();
    let design = cubic_lmi_design(&plant, &DMatrix::identity(3, 3), 0.0, 1.0).unwrap();
    assert!(design.certificate.is_proved(), "{}", design.certificate);
    assert!(design.certificate.converges_from_everywhere(), "{}", design.certificate);
}

/// `N = T J T^-1` with T of integers and determinant 1, J a Jordan block with the eigenvalue `eigenvalue`: no rounding.
/// The plant is `x' = 0`, `y = x`.
fn defective(n: usize, seed: usize, eigenvalue: f64) -> (StateSpace, DMatrix<f64>, DMatrix<f64>) {
    let entry = |i: usize, j: usize| ((7919 * (i + 1) * (j + 2) + 104_729 * seed) % 5) as f64 - 2.0;
    let lower = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
        Ordering::Equal => 1.0,
        Ordering::Greater => entry(i, j),
        Ordering::Less => 0.0,
    });
    let upper = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
        Ordering::Equal => 1.0,
        Ordering::Less => entry(i, j),
        Ordering::Greater => 0.0,
    });
    // Triangular with a unit diagonal: substitution has no divisions.
    let inverse = upper
        .clone()
        .solve_upper_triangular(&lower.clone().solve_lower_triangular(&DMatrix::identity(n, n)).unwrap())
        .unwrap();
    let j = DMatrix::from_fn(n, n, |i, k| {
        if i == k {
            eigenvalue
        } else if i + 1 == k {
            1.0
        } else {
            0.0
        }
    });
    let plant = StateSpace::new(DMatrix::zeros(n, n), DMatrix::zeros(n, 0), DMatrix::identity(n, n)).unwrap();
    (plant, DMatrix::identity(n, n) * 5.0, &lower * &upper * j * inverse)
}

/// For the eigenvalue -2^-24 a P exists (a Lyapunov matrix of N, as F = -5 I serves every P), although the eigenvalues
/// of N as computed have positive real parts; for 2^-24 none does.
#[test]
fn a_defective_gain_is_called_infeasible_only_where_it_is() {
    let mut misleading = 0;
    for n in 2..=4 {
        for seed in 0..5 {
            let (plant, l, gain) = defective(n, seed, -(2f64.powi(-24)));
            misleading += usize::from(spectral_abscissa(&gain).unwrap() > 0.0);
            let infeasible = |error| matches!(error, Some(luenberger_design::DesignError::Infeasible { .. }));
            assert!(!infeasible(certify_gain(&plant, &l, &gain).err()), "{n} {seed}");
            if n < 4 {
                assert!(!infeasible(fixed_gain_margin(&plant, &l, &gain, 0.5).err()), "{n} {seed}");
            }
            let (plant, l, gain) = defective(n, seed, 2f64.powi(-24));
            assert!(certify_gain(&plant, &l, &gain).is_err(), "{n} {seed}");
        }
    }
    assert!(misleading >= 3, "{misleading}");
}

/// An entry of 1e-30 or 1e-320 is no zero: what floating point calls hidden is not called undetectable, and where the
/// output sees all of the rest a gain is found.
#[test]
fn tiny_entries_make_no_plant_undetectable() {
    for tiny in [1e-30, 1e-150, 1e-320] {
        let a = dmatrix![0.5, 1.0; tiny, 0.5];
        let plant = |c| StateSpace::new(a.clone(), DMatrix::zeros(2, 0), c).unwrap();
        let design = cubic_lmi_design(&plant(dmatrix![1.0, 0.0]), &dmatrix![1.0], 0.1, 1.0);
        let design = design.unwrap_or_else(|error| panic!("{tiny:e}: {error}"));
        assert!(design.certificate.is_proved(), "{tiny:e}: {}", design.certificate);
        // Through the tiny entry alone, which no arithmetic of sixteen digits can use.
        if let Err(error) = cubic_lmi_design(&plant(dmatrix![0.0, 1.0]), &dmatrix![1.0], 0.1, 1.0) {
            let undecided = matches!(&error, luenberger_design::DesignError::Undecided { seen: Some(_), .. });
            assert!(undecided, "{tiny:e}: {error}");
        }
    }
}

/// The extended-state observer of `y = 1/(s(s + 1)) (u + d)` is the disturbance observer `dhat = Q (s(s + 1) y - u)`
/// with `Q = w^3/(s + w)^3` (Ohnishi, Shibata and Murakami, IEEE/ASME Transactions on Mechatronics 1, 1996).
#[test]
fn an_extended_state_observer_is_a_disturbance_observer() {
    use luenberger_design::{bandwidth_poles, with_disturbance_chain};
    use nalgebra::Complex;
    let plant = StateSpace::new(dmatrix![0.0, 1.0; 0.0, -1.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]).unwrap();
    let w = 7.0;
    let extended = with_disturbance_chain(&plant, &plant.b, 1).unwrap();
    let ramp = with_disturbance_chain(&plant, &plant.b, 2).unwrap();
    let expected = dmatrix![0.0, 1.0, 0.0, 0.0; 0.0, -1.0, 1.0, 0.0; 0.0, 0.0, 0.0, 1.0; 0.0, 0.0, 0.0, 0.0];
    assert_eq!((&ramp.a, ramp.c.ncols(), ramp.b[1]), (&expected, 4, 1.0));
    let design = LinearDesign::with_poles(&extended, &bandwidth_poles(3, 1, w)).unwrap();
    let complex = |m: &nalgebra::DMatrix<f64>| m.map(Complex::from);
    for s in [Complex::new(0.0, 0.3), Complex::new(0.0, 20.0), Complex::new(1.0, -2.0)] {
        // (sI - F) xi = B u + L y; dhat is the last entry.
        let shifted = complex(&nalgebra::DMatrix::identity(3, 3)) * s - complex(&design.error_matrix());
        let lu = shifted.lu();
        let of_u = lu.solve(&complex(&extended.b)).unwrap()[2];
        let of_y = lu.solve(&complex(design.l())).unwrap()[2];
        let q = (Complex::from(w) / (s + w)).powi(3);
        assert!((of_u + q).norm() < 1e-12 && (of_y - q * s * (s + 1.0)).norm() < 1e-10 * (1.0 + of_y.norm()));
    }
}

/// The zero -2 of (A, E, C) is a pole in every unit of time, and -2.001 is not it.
#[test]
fn poles_beside_a_zero_are_refused_in_every_unit_of_time() {
    for unit in [2f64.powi(-40), 1.0, 2f64.powi(40)] {
        let a = dmatrix![0.0, 1.0; -1.0, -2.0] * unit;
        let plant = StateSpace::new(a, dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]).unwrap();
        let decoupled = DecoupledPlant::new(&plant, &dmatrix![1.0; 0.0]).unwrap();
        assert!(decoupled.with_poles(&[-2.0 * unit, -5.0 * unit]).unwrap().certificate.is_proved(), "{unit:e}");
        let beside = decoupled.with_poles(&[-2.001 * unit, -5.0 * unit]);
        assert!(matches!(beside, Err(DesignError::FixedPoles { .. })), "{unit:e}: {beside:?}");
    }
}

/// A hydraulic cylinder in metres and pascals, where the P of `Q = rho I` is proved for some factors and not for
/// others, by its rounding: each factor has a proof, of that Q or of another.
#[test]
fn a_factor_of_the_identity_decides_no_proof() {
    let a = dmatrix![0.0, 1.0, 0.0; 0.0, -5.0, 1.5e-5; 0.0, -2.1e10, -2.0];
    let plant = StateSpace::new(a, dmatrix![0.0; 0.0; 1.4e13], dmatrix![1.0, 0.0, 0.0; 0.0, 0.0, 1.0]).unwrap();
    let mut others = 0;
    for rho in [1e-3, 1.0, 10.0, 1e3] {
        let weight = LyapunovWeight::Identity(rho);
        let design = LinearDesign::with_poles_and_weight(&plant, &[-2.0, -5.0, -6.0], weight).unwrap();
        assert!(design.certificate.is_proved(), "{rho}: {:?}", design.certificate);
        others += usize::from(design.q != DMatrix::identity(3, 3) * rho);
    }
    assert!(others > 0);
}
