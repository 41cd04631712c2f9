//! Small problems whose answers are known in closed form, and the ways a problem can be ill-posed.

use std::time::{Duration, Instant};

use approx::assert_relative_eq;
use luenberger_lmi::{Fault, LmiError, Problem, Settings, block, greatest_parameter, he, identity, trace};
use luenberger_proof::Verdict;
use nalgebra::{DMatrix, dmatrix};

/// Boyd, El Ghaoui, Feron and Balakrishnan, Linear Matrix Inequalities in System and Control Theory (1994), section
/// 2.5: the least trace of P with A'P + PA + I <= 0 is attained by the Lyapunov solution. For A = -diag(1, 2), P =
/// diag(1/2, 1/4), trace 3/4.
#[test]
fn the_least_trace_is_that_of_the_lyapunov_solution() {
    let a = dmatrix![-1.0, 0.0; 0.0, -2.0];
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", 2);
    lmi.constrain("decrease", (he(&p * &a) + identity(2)) << 0.0);
    lmi.minimise(p.trace());
    let solution = lmi.solve().unwrap();
    assert!(solution.verdict.is_proved(), "{:?}", solution.verdict);
    let optimum = solution.objective.unwrap();
    assert!(optimum.achieved > 0.75, "strictly inside is above the infimum: {optimum:?}");
    // The pull inwards costs about 1e-6 of the distance to the centre.
    assert!(optimum.achieved < 0.7501, "{optimum:?}");
    assert_relative_eq!(optimum.estimate, 0.75, max_relative = 1e-7);
    assert_relative_eq!(solution.value(&p).trace(), optimum.achieved, max_relative = 1e-12);
}

/// The largest eigenvalue of M is the least t with tI - M >= 0: for [[2, 1], [1, 2]] it is 3.
#[test]
fn the_largest_eigenvalue_as_an_optimum() {
    let m = dmatrix![2.0, 1.0; 1.0, 2.0];
    let mut lmi = Problem::new();
    let t = lmi.scalar("t");
    lmi.constrain("above M", t.identity(2) >> &m);
    lmi.minimise(&t);
    let solution = lmi.solve().unwrap();
    let t = solution.value(&t)[(0, 0)];
    assert!(solution.verdict.is_proved() && 3.0 < t && t < 3.0 + 1e-4, "{t}");
}

/// The largest singular value of X as a Schur complement: maximise the trace of the 2x2 X under |X| < 1, optimum 2 at X
/// = I.
#[test]
fn the_nuclear_norm_is_dual_to_the_spectral_norm() {
    let mut lmi = Problem::new();
    let x = lmi.rectangular("X", 2, 2);
    lmi.constrain("|X| < 1", block![[identity(2), &x], [x.transpose(), identity(2)]] >> 0.0);
    lmi.maximise(trace(&x));
    let solution = lmi.solve().unwrap();
    let optimum = solution.objective.unwrap();
    assert!(solution.verdict.is_proved());
    assert!(optimum.achieved < 2.0 && optimum.achieved > 2.0 - 1e-4, "{optimum:?}");
    assert_relative_eq!(optimum.estimate, 2.0, max_relative = 5e-8);
}

#[test]
fn an_unbounded_objective_is_reported_at_a_proved_point() {
    let mut lmi = Problem::new();
    let x = lmi.scalar("x");
    lmi.constrain("x > 1", &x >> 1.0);
    lmi.maximise(&x);
    let solution = lmi.solve().unwrap();
    assert!(solution.verdict.is_proved());
    assert_eq!(solution.objective.unwrap().estimate, f64::INFINITY);
}

#[test]
fn an_unstable_matrix_has_no_lyapunov_function_and_the_witness_says_why() {
    let a = dmatrix![1.0, 0.0; 0.0, -2.0];
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", 2);
    lmi.constrain("P > 0", &p >> 0.0);
    lmi.constrain("decrease", he(&p * &a) << 0.0);
    let solution = lmi.solve().unwrap();
    let witness = match &solution.verdict {
        luenberger_proof::Verdict::Refuted { witness } => witness,
        other => panic!("{other:?}"),
    };
    assert!(lmi.is_refuted_by(witness));
    println!("{witness}");
    // The same multipliers say nothing about a stable matrix, nor once one of them is changed.
    let mut other = Problem::new();
    let p = other.symmetric("P", 2);
    other.constrain("P > 0", &p >> 0.0);
    other.constrain("decrease", he(&p * (-&a)) << 0.0);
    assert!(!other.is_refuted_by(witness));
    let mut altered = witness.clone();
    altered.multipliers[0].exact = altered.multipliers[0].exact.negative();
    assert!(!lmi.is_refuted_by(&altered));
}

#[test]
fn contradicting_bounds_are_refuted() {
    let mut lmi = Problem::new();
    let x = lmi.symmetric("X", 3);
    lmi.constrain("above", &x >> 1.0);
    lmi.constrain("below", &x << 0.5);
    let solution = lmi.solve().unwrap();
    assert!(solution.verdict.is_refuted(), "{:?}", solution.verdict);
    // Equal bounds leave no room either: infeasible by nothing at all.
    let mut lmi = Problem::new();
    let x = lmi.symmetric("X", 3);
    lmi.constrain("above", &x >> 1.0);
    lmi.constrain("below", &x << 1.0);
    let solution = lmi.solve().unwrap();
    assert!(solution.verdict.is_refuted(), "{:?}", solution.verdict);
    // And a little room is found.
    let mut lmi = Problem::new();
    let x = lmi.symmetric("X", 3);
    lmi.constrain("above", &x >> 1.0);
    lmi.constrain("below", &x << (1.0 + 1e-6));
    let solution = lmi.solve().unwrap();
    assert!(solution.verdict.is_proved(), "{:?}", solution.verdict);
}

/// X >= 0 with a zero diagonal entry has a zero row: the contradiction needs the whole kernel, not one equation.
#[test]
fn a_contradiction_on_the_boundary_of_the_cone_is_refuted() {
    // [[x, y], [y, 0]] > 0 is impossible for every x, y.
    let mut lmi = Problem::new();
    let (x, y) = (lmi.scalar("x"), lmi.scalar("y"));
    lmi.constrain("impossible", block![[&x, &y], [&y, dmatrix![0.0]]] >> 0.0);
    let solution = lmi.solve().unwrap();
    assert!(solution.verdict.is_refuted(), "{:?}", solution.verdict);
}

#[test]
fn the_zero_solution_of_a_homogeneous_problem_does_not_pass() {
    // P > 0 with A'P + PA < 0 for A = 0: only P = 0 satisfies it with equality.
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", 2);
    lmi.constrain("P > 0", &p >> 0.0);
    lmi.constrain("decrease", he(&p * DMatrix::<f64>::zeros(2, 2)) << 0.0);
    assert!(lmi.solve().unwrap().verdict.is_refuted());
}

#[test]
fn constraints_without_unknowns_are_decided_too() {
    let mut lmi = Problem::new();
    let x = lmi.scalar("x");
    lmi.constrain("x > 0", &x >> 0.0);
    lmi.constrain("false", identity(2) << 0.0);
    assert!(lmi.solve().unwrap().verdict.is_refuted());
}

/// The decay rate of a Lyapunov function reaches minus the spectral abscissa: eigenvalues -1 +- 2i, -3.
#[test]
fn bisection_reaches_minus_the_spectral_abscissa() {
    let a = dmatrix![-1.0, 2.0, 0.5; -2.0, -1.0, 0.3; 0.0, 0.0, -3.0];
    let rate = greatest_parameter(0.0, 8.0, 1e-4, |alpha| {
        let mut lmi = Problem::new();
        let p = lmi.symmetric("P", 3);
        lmi.constrain("P > 0", &p >> 0.0);
        lmi.constrain("decay", (he(&p * &a) + 2.0 * alpha * &p) << 0.0);
        lmi
    })
    .unwrap();
    let (proved, solution) = rate.proved.unwrap();
    let (stopped, verdict) = rate.stopped.unwrap();
    assert!(proved < 1.0 && stopped > 1.0 - 1e-4 && stopped - proved <= 1e-4, "{proved} {stopped} {verdict:?}");
    assert!(solution.named("P").is_some() && rate.solves <= 19);
}

#[test]
fn badly_scaled_data_is_proved_on_the_original_data() {
    // The same companion matrix with states in units from 1e-6 to 1e6.
    let a = dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; -6.0, -11.0, -6.0];
    let t = DMatrix::from_diagonal(&nalgebra::dvector![1e-6, 1.0, 1e6]);
    let inverse = DMatrix::from_diagonal(&nalgebra::dvector![1e6, 1.0, 1e-6]);
    let a = &inverse * a * &t;
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", 3);
    lmi.constrain("P > 0", &p >> 0.0);
    lmi.constrain("decrease", he(&p * &a) << 0.0);
    let solution = lmi.solve().unwrap();
    assert!(solution.verdict.is_proved(), "{:?} {:?}", solution.verdict, solution.margins);
}

#[test]
fn ill_posed_problems_are_errors_that_name_the_place() {
    let a = DMatrix::<f64>::identity(3, 3);
    let new = || {
        let mut lmi = Problem::new();
        let p = lmi.symmetric("P", 2);
        (lmi, p)
    };
    let (mut lmi, p) = new();
    lmi.constrain("decrease", he(&p * &a) << 0.0);
    let fault = Fault::ShapeMismatch { operation: "product", left: (2, 2), right: (3, 3) };
    let error = lmi.solve().unwrap_err();
    assert_eq!(error, LmiError::Malformed { place: "decrease".to_owned(), fault });
    assert_eq!(error.to_string(), "decrease: product of a 2 x 2 and a 3 x 3 matrix");

    let (mut lmi, p) = new();
    lmi.constrain("P", &p >> f64::NAN);
    assert!(matches!(lmi.solve(), Err(LmiError::Malformed { fault: Fault::NotFinite { .. }, .. })));

    let (mut lmi, p) = new();
    lmi.constrain("P", (&p * dmatrix![1.0, 2.0; 3.0, 4.0]) >> 0.0);
    assert!(matches!(lmi.solve(), Err(LmiError::NotSymmetric { row: 1, column: 0, .. })));

    let mut lmi = Problem::new();
    let y = lmi.rectangular("Y", 2, 3);
    lmi.constrain("Y", &y >> 0.0);
    assert!(matches!(
        lmi.solve(),
        Err(LmiError::Malformed { fault: Fault::NotSquare { rows: 2, columns: 3, .. }, .. })
    ));

    assert_eq!(Problem::new().solve().unwrap_err(), LmiError::NothingToSolve { variables: 0, constraints: 0 });
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", 0);
    lmi.constrain("P", &p >> 0.0);
    assert_eq!(lmi.solve().unwrap_err(), LmiError::Empty { name: "P".to_owned(), rows: 0, columns: 0 });

    let (mut lmi, p) = new();
    lmi.symmetric("P", 3);
    lmi.constrain("P", &p >> 0.0);
    assert!(matches!(lmi.solve(), Err(LmiError::DuplicateName { what: "variables", .. })));

    let (mut lmi, _) = new();
    let (_, foreign) = new();
    lmi.constrain("P", &foreign >> 0.0);
    assert!(matches!(lmi.solve(), Err(LmiError::ForeignVariable { .. })));

    let (mut lmi, p) = new();
    lmi.constrain("P", &p >> 0.0);
    lmi.minimise(&p);
    assert_eq!(lmi.solve().unwrap_err(), LmiError::ObjectiveNotScalar { rows: 2, columns: 2 });
    lmi.minimise(p.trace());
    assert_eq!(lmi.solve().unwrap_err(), LmiError::HomogeneousObjective);

    let (mut lmi, p) = new();
    lmi.constrain("P", (1e200 * (1e200 * &p)) >> 0.0);
    assert_eq!(lmi.solve().unwrap_err(), LmiError::Overflow { place: "P".to_owned() });

    assert!(matches!(greatest_parameter(1.0, 0.0, 0.1, |_| Problem::new()), Err(LmiError::BadBracket { .. })));
    assert!(matches!(greatest_parameter(0.0, f64::NAN, 0.1, |_| Problem::new()), Err(LmiError::BadBracket { .. })));
}

#[test]
fn an_unknown_of_another_problem_has_no_value() {
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", 2);
    lmi.constrain("P > 0", &p >> 0.0);
    let solution = lmi.solve().unwrap();
    let mut other = Problem::new();
    assert!(solution.value(&other.symmetric("P", 2)).iter().all(|x| x.is_nan()));
    assert!(solution.value(&p).iter().all(|x| x.is_finite()) && solution.margin("P > 0").unwrap() > 0.0);
}

/// After the time limit nothing is decided, and nothing wrong is said.
#[test]
fn no_iteration_starts_after_the_time_limit() {
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", 2);
    lmi.constrain("decrease", he(&p * dmatrix![-1.0, 0.0; 0.0, -2.0]) << 0.0);
    lmi.constrain("P > 0", &p >> 0.0);
    let at = |end: Instant| lmi.solve_with(&Settings { end: Some(end), ..Settings::default() }).unwrap();
    let stopped = at(Instant::now());
    assert!(matches!(stopped.verdict, Verdict::Undecided { .. }), "{:?}", stopped.verdict);
    assert_eq!(stopped.effort.iterations, 0);
    assert!(at(Instant::now() + Duration::from_secs(3600)).verdict.is_proved());
}
