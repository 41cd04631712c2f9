//! The two solvers behind one seam: the same verdicts, by the same proofs.

use std::fmt::Write as _;

use luenberger_lmi::sdpa::{self, NoBoundReason, Status};
use luenberger_lmi::{Problem, Settings, Solver, greatest_parameter_with, he};
use nalgebra::dmatrix;

const CLARABEL: Settings =
    Settings { solver: Solver::Clarabel, iterations: 100, closeness: 1e-6, referee: 400, end: None };

/// minimise x subject to [[x, 1], [1, x]] >= 0: the optimum is 1.
const SWAP: &[u8] = b"1\n1\n2\n1.0\n0 1 1 2 -1.0\n1 1 1 1 1.0\n1 1 2 2 1.0\n";

fn lyapunov(alpha: f64) -> Problem {
    let a = dmatrix![-1.0, 2.0, 0.5; -2.0, -1.0, 0.3; 0.0, 0.0, -3.0];
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", 3);
    lmi.constrain("P > 0", &p >> 0.0);
    lmi.constrain("decay", (he(&p * &a) + 2.0 * alpha * &p) << 0.0);
    lmi
}

#[test]
fn the_default_is_the_solver_of_the_house() {
    assert_eq!(Settings::default().solver, Solver::Interior);
    assert_eq!(sdpa::Settings::default().solver, Solver::Interior);
    assert_eq!([Solver::Interior, Solver::Clarabel].map(Solver::name), ["interior", "clarabel"]);
}

/// minimise x subject to [[x, c], [c, y]] >= 0 and y <= 1: the optimum is c^2; with x <= 1 too, c = 2 is impossible;
/// without y <= 1 the infimum 0 is not attained.
#[test]
fn a_two_by_two_program() {
    let solve = |c: f64, bounded: &[usize]| {
        let mut text = format!(
            "2\n{}\n2 {}\n1 0\n0 1 1 2 {}\n1 1 1 1 1\n2 1 2 2 1\n",
            1 + bounded.len(),
            "1 ".repeat(bounded.len()),
            -c
        );
        for (k, unknown) in bounded.iter().enumerate() {
            let _ = writeln!(text, "0 {0} 1 1 -1\n{unknown} {0} 1 1 -1", k + 2);
        }
        sdpa::solve(&sdpa::read(text.as_bytes()).unwrap(), &sdpa::Settings::default())
    };
    let bounded = solve(0.5, &[2]);
    assert_eq!((bounded.word, bounded.status), ("solved", Status::Bounds));
    // A gap and residuals of 1e-12 were asked for.
    assert!(0.25 - bounded.lower < 1e-10 && bounded.upper - 0.25 < 1e-10, "{bounded:?}");
    assert_eq!(solve(2.0, &[1, 2]).status, Status::PrimalInfeasible);
    assert!(solve(0.5, &[]).upper < 1e-3);
}

#[test]
fn a_cost_without_lower_bound_is_noticed() {
    let open = sdpa::read(&b"1\n1\n1\n-1\n0 1 1 1 1\n1 1 1 1 1\n"[..]).unwrap();
    let found = sdpa::solve(&open, &sdpa::Settings::default());
    assert_eq!((found.word, found.status), ("unbounded", Status::DualInfeasible));
}

#[cfg(not(feature = "clarabel"))]
#[test]
fn a_solver_that_is_left_out_names_its_feature() {
    use luenberger_lmi::{LmiError, NotBuiltIn};

    let error = lyapunov(0.0).solve_with(&CLARABEL).unwrap_err();
    assert_eq!(error, LmiError::NotBuiltIn(NotBuiltIn { solver: Solver::Clarabel, feature: "clarabel" }));
    assert_eq!(
        error.to_string(),
        "the solver clarabel is not part of this build: it needs the feature `clarabel` of luenberger-lmi"
    );
    assert_eq!(greatest_parameter_with(&CLARABEL, 0.0, 1.0, 0.1, lyapunov).unwrap_err(), error);
    let settings = sdpa::Settings { solver: Solver::Clarabel, ..sdpa::Settings::default() };
    let found = sdpa::solve(&sdpa::read(SWAP).unwrap(), &settings);
    assert_eq!(
        (found.status, found.why),
        (Status::Undecided, Some(NoBoundReason::NotBuiltIn { solver: Solver::Clarabel }))
    );
    assert_eq!((found.runs, found.lower, found.upper), (0, f64::NEG_INFINITY, f64::INFINITY));
}

#[cfg(feature = "clarabel")]
mod clarabel {
    use std::f64::consts::PI;
    use std::time::Duration;

    use approx::assert_relative_eq;
    use luenberger_lmi::sdpa::Outcome;
    use luenberger_lmi::{Solution, block, dynamic_matrix, identity};
    use luenberger_proof::Verdict;
    use luenberger_proof::semidefinite::DualBlock;
    use nalgebra::DMatrix;
    use proptest::prelude::*;

    use super::*;

    fn both(lmi: &Problem) -> [Solution; 2] {
        [Settings::default(), CLARABEL].map(|settings| lmi.solve_with(&settings).unwrap())
    }

    /// Neither has proved what the other has refuted; every witness is one.
    fn agree(lmi: &Problem) -> Result<[Solution; 2], TestCaseError> {
        let found = both(lmi);
        let [ours, theirs] = found.each_ref().map(|solution| &solution.verdict);
        let opposite = ours.is_proved() && theirs.is_refuted() || ours.is_refuted() && theirs.is_proved();
        prop_assert!(!opposite, "{ours:?} {theirs:?}");
        for verdict in [ours, theirs] {
            if let Verdict::Refuted { witness } = verdict {
                prop_assert!(lmi.is_refuted_by(witness));
            }
        }
        Ok(found)
    }

    /// P > 0, P < I, A'P + PA - YC - C'Y' + 2 rate P < 0.
    fn gain(a: &DMatrix<f64>, c: &DMatrix<f64>, rate: f64) -> Problem {
        let mut lmi = Problem::new();
        let p = lmi.symmetric("P", a.nrows());
        let y = lmi.rectangular("Y", a.nrows(), c.nrows());
        lmi.constrain("P > 0", &p >> 0.0);
        lmi.constrain("P < I", &p << 1.0);
        lmi.constrain("decrease", (he(&p * a - &y * c) + (2.0 * rate) * &p) << 0.0);
        lmi
    }

    fn entries(rows: usize, columns: usize) -> impl Strategy<Value = DMatrix<f64>> {
        prop::collection::vec(-1.0..1.0, rows * columns).prop_map(move |x| DMatrix::from_vec(rows, columns, x))
    }

    /// A plant of 1 to 5 states and 1 or 2 outputs of which the last `hidden` states have no trace in the outputs; as
    /// the second number, the largest real part of a hidden eigenvalue, where there is one: A is block triangular, and
    /// the hidden block lower triangular.
    fn plant() -> impl Strategy<Value = (DMatrix<f64>, DMatrix<f64>, Option<f64>)> {
        (1usize..=5, 1usize..=2, 0usize..=2).prop_flat_map(|(n, outputs, hidden)| {
            let seen = n.saturating_sub(hidden).max(1);
            (entries(n, n), entries(outputs, n)).prop_map(move |(a, c)| {
                let zero = |i: usize, j: usize| j >= seen && i < j;
                let a = DMatrix::from_fn(n, n, |i, j| if zero(i, j) { 0.0 } else { a[(i, j)] });
                let c = DMatrix::from_fn(outputs, n, |i, j| if j < seen { c[(i, j)] } else { 0.0 });
                let slowest = (seen..n).map(|i| a[(i, i)]).reduce(f64::max);
                (a, c, slowest)
            })
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Feasible iff every hidden mode decays faster than the rate: both solvers may say so, or that they do not
        /// know, and neither the contrary.
        #[test]
        fn no_plant_has_opposite_verdicts((a, c, slowest) in plant(), rate in 0.0..1.0f64) {
            let found = agree(&gain(&a, &c, rate))?;
            let is_feasible = slowest.is_none_or(|hidden| hidden < -rate);
            for solution in &found {
                let is_wrong = if is_feasible { solution.verdict.is_refuted() } else { solution.verdict.is_proved() };
                prop_assert!(!is_wrong, "{:?}", solution.verdict);
            }
        }

        /// At the threshold of a Lyapunov inequality, where one of the two sides is thin.
        #[test]
        fn no_threshold_has_opposite_verdicts(a in entries(3, 3), offset in -1e-3..1e-3f64) {
            let abscissa = a.complex_eigenvalues().iter().map(|z| z.re).fold(f64::NEG_INFINITY, f64::max);
            let mut lmi = Problem::new();
            let p = lmi.symmetric("P", 3);
            lmi.constrain("P > 0", &p >> 0.0);
            lmi.constrain("decay", (he(&p * &a) + (2.0 * (offset - abscissa)) * &p) << 0.0);
            agree(&lmi)?;
        }
    }

    /// Well inside and well outside both of them decide, so that to agree means something.
    #[test]
    fn both_decide_what_is_clear() {
        for alpha in [0.0, 0.5, 0.9, 0.999] {
            let [ours, theirs] = both(&lyapunov(alpha));
            assert!(ours.verdict.is_proved() && theirs.verdict.is_proved(), "{alpha}: {:?}", theirs.verdict);
            assert_ne!(theirs.effort.iterations, 0);
        }
        let hidden = gain(&dmatrix![-1.0, 0.0; 0.5, 0.25], &dmatrix![1.0, 0.0], 0.0);
        let contradiction = |upper: f64| {
            let mut lmi = Problem::new();
            let x = lmi.symmetric("X", 3);
            lmi.constrain("above", &x >> 1.0);
            lmi.constrain("below", &x << upper);
            lmi
        };
        for lmi in [hidden, contradiction(0.5), contradiction(1.0)] {
            for solution in both(&lmi) {
                let Verdict::Refuted { witness } = &solution.verdict else { panic!("{:?}", solution.verdict) };
                assert!(lmi.is_refuted_by(witness));
            }
        }
    }

    /// maximise tr X for |X| < 1, X of order 2: the optimum 2 is not attained, and what is returned is strictly inside.
    #[test]
    fn both_find_the_same_optimum() {
        let mut lmi = Problem::new();
        let x = lmi.rectangular("X", 2, 2);
        lmi.constrain("|X| < 1", block![[identity(2), &x], [x.transpose(), identity(2)]] >> 0.0);
        lmi.maximise(x.trace());
        for solution in both(&lmi) {
            let optimum = solution.objective.unwrap();
            assert!(solution.verdict.is_proved() && optimum.achieved < 2.0);
            assert_relative_eq!(optimum.achieved, 2.0, max_relative = 1e-4);
            assert_relative_eq!(optimum.estimate, 2.0, max_relative = 1e-7);
        }
        let mut lmi = Problem::new();
        let x = lmi.scalar("x");
        lmi.constrain("x > 1", &x >> 1.0);
        lmi.maximise(&x);
        for solution in both(&lmi) {
            assert_eq!(solution.objective.unwrap().estimate, f64::INFINITY);
        }
    }

    #[test]
    fn bisection_asks_the_solver_it_was_given() {
        let [ours, theirs] =
            [Settings::default(), CLARABEL].map(|s| greatest_parameter_with(&s, 0.0, 8.0, 1e-3, lyapunov).unwrap());
        for found in [&ours, &theirs] {
            let (proved, _) = found.proved.as_ref().unwrap();
            assert!(*proved < 1.0 && *proved >= 1.0 - 1e-3, "{proved}");
        }
        assert_ne!(ours.proved.unwrap().1.named("P"), theirs.proved.unwrap().1.named("P"));
    }

    #[test]
    fn programs_of_sdpa_are_bounded_by_either() {
        let program = sdpa::read(SWAP).unwrap();
        let settings = sdpa::Settings { solver: Solver::Clarabel, ..sdpa::Settings::default() };
        let found = sdpa::solve(&program, &settings);
        assert_eq!(found.status, Status::Bounds, "{found:?}");
        assert!(found.lower <= 1.0 && 1.0 <= found.upper && found.upper - found.lower < 1e-6, "{found:?}");
        // x <= 1 and x >= 2.
        let empty = sdpa::read(&b"1\n1\n-2\n1\n0 1 1 1 2\n0 1 2 2 -1\n1 1 1 1 1\n1 1 2 2 -1\n"[..]).unwrap();
        assert_eq!(sdpa::solve(&empty, &settings).status, Status::PrimalInfeasible);
    }

    fn bounds(text: &str, settings: sdpa::Settings) -> Outcome {
        sdpa::solve(&sdpa::read(text.as_bytes()).unwrap(), &sdpa::Settings { solver: Solver::Clarabel, ..settings })
    }

    /// minimise tr X over X >= F = [min(i, j)] of order n: all entries of X are unknowns, and the optimum is tr F.
    fn traces(n: usize) -> String {
        let places: Vec<(usize, usize)> = (1..=n).flat_map(|j| (1..=j).map(move |i| (i, j))).collect();
        let costs: String = places.iter().map(|(i, j)| if i == j { "1 " } else { "0 " }).collect();
        let mut text = format!("{}\n1\n{n}\n{costs}\n", places.len());
        for (k, (i, j)) in places.into_iter().enumerate() {
            let _ = writeln!(text, "0 1 {i} {j} {i}\n{} 1 {i} {j} 1", k + 1);
        }
        text
    }

    /// minimise t over t I >= F: the optimum is the largest eigenvalue.
    fn largest_eigenvalue(n: usize) -> String {
        let mut text = format!("1\n1\n{n}\n1\n");
        for j in 1..=n {
            let _ = writeln!(text, "1 1 {j} {j} 1");
            (1..=j).for_each(|i| _ = writeln!(text, "0 1 {i} {j} {i}"));
        }
        text
    }

    /// The multiplier of `X >= F` is the identity; that of `t I >= F` is v v' with the eigenvector `v_i = sin(i pi / (2
    /// n + 1))`, of the eigenvalue `1 / (4 sin^2(pi / (4 n + 2)))`. Entries off the diagonal count in both.
    #[test]
    fn the_multipliers_are_those_of_the_blocks() {
        for n in [1, 2, 5] {
            let angle = PI / (2 * n + 1) as f64;
            let square = (1..=n).map(|i| (i as f64 * angle).sin().powi(2)).sum::<f64>();
            let eigenvector = |i: usize| ((i + 1) as f64 * angle).sin() / square.sqrt();
            for (text, optimum, multiplier) in [
                (traces(n), (n * (n + 1) / 2) as f64, DMatrix::identity(n, n)),
                (
                    largest_eigenvalue(n),
                    0.25 / (0.5 * angle).sin().powi(2),
                    DMatrix::from_fn(n, n, |i, j| eigenvector(i) * eigenvector(j)),
                ),
            ] {
                let found = bounds(&text, sdpa::Settings::default());
                assert_eq!((found.word, found.status), ("solved", Status::Bounds));
                assert_relative_eq!(found.lower, optimum, max_relative = 1e-7);
                assert_relative_eq!(found.upper, optimum, max_relative = 1e-7);
                let [DualBlock::Dense(y)] = &found.y[..] else { panic!("{:?}", found.y) };
                assert_relative_eq!(dynamic_matrix(y), multiplier, epsilon = 1e-6);
            }
        }
    }

    #[test]
    fn a_program_without_a_point_or_without_a_bound_is_noticed() {
        // x >= 1 and x <= 0; minimise -x over x >= 1.
        let empty = bounds("1\n1\n-2\n1\n0 1 1 1 1\n1 1 1 1 1\n1 1 2 2 -1\n", sdpa::Settings::default());
        assert_eq!((empty.word, empty.status), ("infeasible", Status::PrimalInfeasible));
        let [DualBlock::Diagonal(y)] = &empty.y[..] else { panic!("{:?}", empty.y) };
        assert!(y[0] > 0.0);
        assert_relative_eq!(y[0], y[1], max_relative = 1e-6);
        let open = bounds("1\n1\n1\n-1\n0 1 1 1 1\n1 1 1 1 1\n", sdpa::Settings::default());
        assert_eq!((open.word, open.status), ("unbounded", Status::DualInfeasible));
    }

    /// The deadline is a time limit of the solver: a program that takes far longer ends within it.
    #[test]
    fn the_deadline_is_its_time_limit() {
        let time = Some(Duration::from_millis(2));
        let found = bounds(&traces(60), sdpa::Settings { time, ..sdpa::Settings::default() });
        // Nothing begins where the deadline has passed by then.
        assert!(["time limit", "no proposal"].contains(&found.word), "{}", found.word);
        let found = bounds(&traces(5), sdpa::Settings { iterations: 1, ..sdpa::Settings::default() });
        assert_eq!((found.word, found.iterations as usize), ("iteration limit", found.runs));
    }

    /// A deadline of no time at all begins nothing.
    #[test]
    fn a_deadline_that_is_over_begins_nothing() {
        let program = sdpa::read(SWAP).unwrap();
        let settings =
            sdpa::Settings { solver: Solver::Clarabel, time: Some(Duration::ZERO), ..sdpa::Settings::default() };
        let found = sdpa::solve(&program, &settings);
        assert_eq!((found.why, found.runs), (Some(NoBoundReason::Time), 0));
    }
}
