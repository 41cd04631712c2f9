//! SDPA's files and rigorous bounds: closed forms, programs with an optimum known by construction, infeasible programs,
//! and invalid files.

use std::f64::consts::PI;
use std::fmt::Write as _;

use luenberger_lmi::sdpa::{Outcome, Settings, Status, read, solve};
use luenberger_proof::Interval;
use luenberger_proof::certificate::{CertificateFile, SemidefiniteEvidence, Theorem, verify};
use luenberger_proof::semidefinite::{Block, DualBlock, Entry, Program};
use proptest::prelude::*;

fn bounds(text: &str) -> Outcome {
    solve(&read(text.as_bytes()).unwrap(), &Settings::default())
}

/// The Lovasz number of the cycle of n vertices: maximise tr(JY), tr Y = 1, Y_ij = 0 on edges.
fn cycle(n: usize) -> String {
    let mut text = format!("{}\n1\n{n}\n1{}\n", n + 1, " 0".repeat(n));
    for i in 1..=n {
        for j in i..=n {
            let _ = writeln!(text, "0 1 {i} {j} 1");
        }
        let _ = writeln!(text, "1 1 {i} {i} 1");
        let next = i % n + 1;
        let _ = writeln!(text, "{} 1 {} {} 1", i + 1, i.min(next), i.max(next));
    }
    text
}

/// L. Lovasz, On the Shannon capacity of a graph, IEEE Transactions on Information Theory 25, 1979: n cos(pi/n)/(1 +
/// cos(pi/n)), n odd.
#[test]
fn the_lovasz_number_of_odd_cycles() {
    for n in [3, 5, 7, 15, 31] {
        let found = bounds(&cycle(n));
        let cosine = (PI / n as f64).cos();
        let expected = if n == 3 { 1.0 } else { n as f64 * cosine / (1.0 + cosine) };
        assert_eq!(found.status, Status::Bounds, "n = {n}: {found:?}");
        // The closed form has its own rounding, of a few units.
        let rounding = 8.0 * f64::EPSILON * expected;
        assert!(found.lower <= expected + rounding && expected - rounding <= found.upper, "n = {n}: {found:?}");
        assert!(found.upper - found.lower <= 1e-8 * expected, "n = {n}: {found:?}");
    }
}

/// A linear program in a diagonal block: minimise x1 + 2 x2 subject to x1 >= 1, x2 >= 3, x1 + x2 <= 10.
#[test]
fn a_linear_program() {
    let found =
        bounds("2\n1\n-3\n1 2\n0 1 1 1 1\n0 1 2 2 3\n0 1 3 3 -10\n1 1 1 1 1\n1 1 3 3 -1\n2 1 2 2 1\n2 1 3 3 -1\n");
    assert_eq!(found.status, Status::Bounds);
    assert!(found.lower <= 7.0 && 7.0 <= found.upper && found.upper - found.lower < 1e-7, "{found:?}");
    assert!(found.primal_margin.unwrap() > 0.0);
}

/// 1 x 1: minimise 3x subject to 2x >= 5, with data that binary64 does not have: 0.3 x 2.5/0.1.
#[test]
fn one_unknown_and_one_row() {
    let found = bounds("1\n1\n1\n3\n0 1 1 1 5\n1 1 1 1 2\n");
    assert!(found.lower <= 7.5 && 7.5 <= found.upper && found.upper - found.lower < 1e-7, "{found:?}");
    let found = bounds("1\n1\n1\n0.3\n0 1 1 1 2.5\n1 1 1 1 0.1\n");
    assert!(found.lower <= 7.5 && 7.5 <= found.upper && found.upper - found.lower < 1e-7, "{found:?}");
}

/// Solved, written, verified; with each bound improved by one unit in the last place, the file is rejected.
fn goes_into_a_file(text: &str) -> Outcome {
    let program = read(text.as_bytes()).unwrap();
    let found = solve(&program, &Settings::default());
    let file = found.certificate_file(&program, "a test").unwrap();
    let proved = verify(file.to_json().as_bytes()).unwrap_or_else(|why| panic!("{why}"));
    assert!(!proved.facts.is_empty() && proved.facts.iter().all(|fact| fact.verdict.is_proved()));
    let Theorem::SemidefiniteProgram(theorem) = file.theorem() else { panic!("{}", file.theorem().name()) };
    let refused = |evidence: SemidefiniteEvidence| {
        let mut forged = theorem.clone();
        forged.evidence = evidence;
        CertificateFile::prove("forged", forged).is_err()
    };
    match &theorem.evidence {
        SemidefiniteEvidence::Bounds { lower, upper } => {
            if let Some((bound, y)) = lower {
                assert_eq!(*bound, found.lower);
                assert!(refused(SemidefiniteEvidence::Bounds {
                    lower: Some((bound.next_up(), y.clone())),
                    upper: None
                }));
            }
            if let Some((bound, x)) = upper {
                assert_eq!(*bound, found.upper);
                assert!(refused(SemidefiniteEvidence::Bounds {
                    lower: None,
                    upper: Some((bound.next_down(), x.clone()))
                }));
            }
        }
        // The opposite ray shows nothing.
        SemidefiniteEvidence::PrimalInfeasible(y) => {
            let opposite = y.iter().map(|block| match block {
                DualBlock::Dense(y) => DualBlock::Dense(y.map(|y| -y)),
                DualBlock::Diagonal(y) => DualBlock::Diagonal(y.iter().map(|y| -y).collect()),
            });
            assert!(refused(SemidefiniteEvidence::PrimalInfeasible(opposite.collect())));
        }
        SemidefiniteEvidence::DualInfeasible(x) => {
            assert!(refused(SemidefiniteEvidence::DualInfeasible(x.iter().map(|x| -x).collect())));
        }
    }
    found
}

/// Bounds in dense and diagonal blocks, with decimals that binary64 does not have; infeasible programs of both kinds;
/// and a bound of one side alone.
#[test]
fn what_is_proved_goes_into_a_file() {
    for n in [3, 15] {
        assert_eq!(goes_into_a_file(&cycle(n)).status, Status::Bounds);
    }
    let linear = "2\n1\n-3\n0.1 2\n0 1 1 1 1\n0 1 2 2 3\n0 1 3 3 -10\n1 1 1 1 1\n1 1 3 3 -1\n2 1 2 2 1\n2 1 3 3 -1\n";
    assert_eq!(goes_into_a_file(linear).status, Status::Bounds);
    // The norm of A, and the largest decay rate that a P shows: several blocks, and one row of numbers beside a matrix.
    let blocks =
        "2\n2\n2 -2\n1 1\n0 1 1 2 -0.3\n0 2 1 1 0.1\n0 2 2 2 -7\n1 1 1 1 1\n2 1 2 2 1\n1 2 1 1 1\n2 2 2 2 -1\n";
    assert_eq!(goes_into_a_file(blocks).status, Status::Bounds);
    for infeasible in
        ["1\n1\n-2\n1\n0 1 1 1 1\n1 1 1 1 1\n1 1 2 2 -1\n", "1\n1\n2\n1\n0 1 1 1 1\n0 1 2 2 1\n1 1 1 1 1\n1 1 2 2 -1\n"]
    {
        assert_eq!(goes_into_a_file(infeasible).status, Status::PrimalInfeasible);
    }
    assert_eq!(goes_into_a_file("1\n1\n1\n-1\n0 1 1 1 1\n1 1 1 1 1\n").status, Status::DualInfeasible);
    assert_eq!(goes_into_a_file("2\n1\n2\n1 1\n0 1 1 2 -1\n1 1 1 1 1\n1 1 2 2 1\n").status, Status::DualInfeasible);
    let one_sided = goes_into_a_file("2\n1\n2\n1 2\n0 1 1 2 -1\n1 1 1 1 1\n1 1 2 2 1\n2 1 1 1 2\n2 1 2 2 2\n");
    assert!(one_sided.upper.is_finite());
}

/// Without a verified result there is no file; and the points of one program do not prove another.
#[test]
fn an_undecided_program_has_no_file() {
    let program = read(cycle(5).as_bytes()).unwrap();
    let not_started = solve(&program, &Settings { memory: 100, ..Settings::default() });
    let error = not_started.certificate_file(&program, "not started").unwrap_err().to_string();
    assert_eq!(error, "no certificate file: no theorem is claimed");
    let (five, seven) = (read(cycle(5).as_bytes()).unwrap(), read(cycle(7).as_bytes()).unwrap());
    let found = solve(&five, &Settings::default());
    assert!(found.certificate_file(&five, "its own").is_ok() && found.certificate_file(&seven, "another's").is_err());
}

#[test]
fn programs_without_feasible_points_are_proved_so() {
    // x >= 1 and -x >= 0; the same inside 2 x 2 matrices.
    assert_eq!(bounds("1\n1\n-2\n1\n0 1 1 1 1\n1 1 1 1 1\n1 1 2 2 -1\n").status, Status::PrimalInfeasible);
    // [[x, 0], [0, -x]] >= [[1, 0], [0, 1]].
    assert_eq!(bounds("1\n1\n2\n1\n0 1 1 1 1\n0 1 2 2 1\n1 1 1 1 1\n1 1 2 2 -1\n").status, Status::PrimalInfeasible);
    // minimise -x subject to x >= 1: no Y with tr(F_1 Y) = -1, and x has no bound.
    let unbounded = bounds("1\n1\n1\n-1\n0 1 1 1 1\n1 1 1 1 1\n");
    assert_eq!(unbounded.status, Status::DualInfeasible);
    assert_eq!(unbounded.lower, f64::NEG_INFINITY);
}

/// [[x, 1], [1, 0]] >= 0 has no solution, but [[x, 1], [1, 1e-9]] has: no ray shows it, and nothing may be claimed.
#[test]
fn what_is_weakly_infeasible_stays_undecided() {
    let found = bounds("1\n1\n2\n1\n0 1 1 2 -1\n1 1 1 1 1\n");
    assert_eq!(found.status, Status::Undecided, "{found:?}");
    assert_eq!(found.upper, f64::INFINITY);
}

/// Dependent constraints, F_2 = 2 F_1: (D) has points, but none that this method can prove; the upper bound stands.
#[test]
fn dependent_constraints_leave_the_lower_bound_open() {
    let found = bounds("2\n1\n2\n1 2\n0 1 1 2 -1\n1 1 1 1 1\n1 1 2 2 1\n2 1 1 1 2\n2 1 2 2 2\n");
    assert!(found.upper >= 1.0 && found.upper < 1.0 + 1e-5, "{found:?}");
    assert!(found.lower <= 1.0, "{found:?}");
}

/// An unknown that occurs nowhere changes nothing; with a cost, it takes the optimum to minus infinity.
#[test]
fn an_unknown_that_occurs_nowhere() {
    let found = bounds("2\n1\n2\n1 0\n0 1 1 2 -1\n1 1 1 1 1\n1 1 2 2 1\n");
    assert!(found.upper >= 1.0 && found.upper < 1.0 + 1e-5 && found.lower <= 1.0, "{found:?}");
    let found = bounds("2\n1\n2\n1 1\n0 1 1 2 -1\n1 1 1 1 1\n1 1 2 2 1\n");
    assert_eq!(found.status, Status::DualInfeasible, "{found:?}");
}

/// Units: costs in 1e12, constants in 1e-9.
#[test]
fn units_change_nothing() {
    let found = bounds("1\n1\n2\n1e12\n0 1 1 2 -1e-9\n1 1 1 1 1\n1 1 2 2 1\n");
    assert_eq!(found.status, Status::Bounds, "{found:?}");
    assert!(found.lower <= 1000.0 * (1.0 + 1e-15) && 1000.0 * (1.0 - 1e-15) <= found.upper);
    assert!(found.upper - found.lower < 1e-5, "{found:?}");
}

#[test]
fn a_program_too_large_for_the_memory_allowed_is_not_started() {
    let program = read(cycle(5).as_bytes()).unwrap();
    let found = solve(&program, &Settings { memory: 100, ..Settings::default() });
    assert_eq!((found.status, found.runs), (Status::Undecided, 0));
}

/// A program and its optimum: with integers v, `Y = v v'` and `X = |v|^2 I - v v'` are complementary, whatever the F_i;
/// the first is I, so that (P) has an interior.
#[derive(Debug, Clone)]
struct Known {
    program: Program,
    x: Vec<f64>,
    y: Vec<f64>,
    optimum: f64,
}

fn known() -> impl Strategy<Value = Known> {
    (2usize..=6, 1usize..=5).prop_flat_map(|(n, m)| {
        (
            prop::collection::vec(prop::collection::vec(-4i32..=4, n * (n + 1) / 2), m - 1),
            prop::collection::vec(prop_oneof![-3i32..=-1, 1i32..=3], n),
            prop::collection::vec(-5i32..=5, m),
        )
            .prop_map(move |(rest, v, x)| build(n, &rest, &v, &x))
    })
}

fn build(n: usize, rest: &[Vec<i32>], v: &[i32], x: &[i32]) -> Known {
    let pairs: Vec<(usize, usize)> = (0..n).flat_map(|i| (i..n).map(move |j| (i, j))).collect();
    let identity: Vec<i32> = pairs.iter().map(|(i, j)| i32::from(i == j)).collect();
    let f: Vec<&Vec<i32>> = std::iter::once(&identity).chain(rest).collect();
    let square: i32 = v.iter().map(|v| v * v).sum();
    let weight = |(i, j): (usize, usize)| if i == j { 1 } else { 2 };
    let costs: Vec<i32> =
        f.iter().map(|f| f.iter().zip(&pairs).map(|(f, &(i, j))| weight((i, j)) * f * v[i] * v[j]).sum()).collect();
    let constant: Vec<i32> = pairs
        .iter()
        .enumerate()
        .map(|(k, &(i, j))| {
            let slack = if i == j { square } else { 0 } - v[i] * v[j];
            f.iter().zip(x).map(|(f, x)| f[k] * x).sum::<i32>() - slack
        })
        .collect();
    let point = |k: i32| Interval::around(f64::from(k), 0.0).unwrap();
    let entries = |f: &Vec<i32>| -> Vec<Entry> {
        f.iter().zip(&pairs).map(|(&f, &(row, column))| Entry { block: 0, row, column, value: point(f) }).collect()
    };
    let matrices = std::iter::once(entries(&constant)).chain(f.iter().map(|f| entries(f))).collect();
    let optimum = costs.iter().zip(x).map(|(c, x)| f64::from(c * x)).sum();
    let program = Program::new(vec![Block::Dense(n)], costs.iter().map(|&c| point(c)).collect(), matrices).unwrap();
    let number = |list: &[i32]| list.iter().map(|&k| f64::from(k)).collect();
    Known { program, x: number(x), y: number(v), optimum }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever is claimed of a program encloses its optimum; and since (P) has an interior, the upper bound is finite
    /// and near.
    #[test]
    fn the_bounds_enclose_the_optimum(case in known()) {
        let found = solve(&case.program, &Settings::default());
        prop_assert!(matches!(found.status, Status::Bounds | Status::Undecided), "{found:?}");
        prop_assert!(found.lower <= case.optimum && case.optimum <= found.upper, "{found:?} {}", case.optimum);
        prop_assert!(found.upper.is_finite(), "{found:?}");
        // More matrices than are independent leave the duals that satisfy the equations without an interior.
        let order = case.y.len();
        let is_independent = case.program.costs().len() <= order * (order + 1) / 2;
        // The solver's accuracy, a thousand times over, in units of the data.
        let near = found.upper - case.optimum <= 1e-5 * (1.0 + case.optimum.abs());
        prop_assert!(near || !is_independent, "{found:?} {}", case.optimum);
    }

    /// Points near the optimal ones: no perturbation makes the prover claim a bound on the wrong side.
    #[test]
    fn no_proposal_proves_a_bound_on_the_wrong_side(
        case in known(), noise in prop::collection::vec(-1.0f64..1.0, 42), size in -16i32..2, shift in -16i32..2,
    ) {
        let (size, shift) = (10f64.powi(size), 10f64.powi(shift));
        let mut x: Vec<f64> = case.x.iter().zip(&noise).map(|(x, e)| x + size * e).collect();
        x[0] += shift;
        if let Some(upper) = case.program.upper_bound(&x) {
            prop_assert!(upper.value >= case.optimum && upper.margin >= 0.0);
        }
        let n = case.y.len();
        let y = luenberger_proof::Matrix::from_fn(n, n, |i, j| {
            let (i, j) = (i.min(j), i.max(j));
            case.y[i] * case.y[j] + size * noise[6 + (i * n + j) % 36] + if i == j { shift } else { 0.0 }
        });
        let y = [DualBlock::Dense(y)];
        if let Some(lower) = case.program.lower_bound(&y) {
            prop_assert!(lower.value <= case.optimum);
        }
        // Both programs have feasible points: neither can be proved to have none.
        prop_assert!(case.program.is_primal_infeasible(&y).is_none());
        prop_assert!(case.program.is_dual_infeasible(&x).is_none());
    }

    /// Any bytes give a program or an error, and never a panic.
    #[test]
    fn any_bytes_are_a_program_or_an_error(mut bytes in prop::collection::vec(any::<u8>(), 0..60), cut in 0usize..400, at in 0usize..400) {
        let _ = read(&bytes[..]);
        // A good file, cut and disturbed.
        let mut text = cycle(5).into_bytes();
        text.truncate(cut);
        let at = at.min(text.len());
        text.splice(at..at, bytes.drain(..));
        let _ = read(&text[..]);
    }
}
