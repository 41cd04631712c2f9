//! Bounds of the smallest eigenvalue of the Gram matrix of a semidefinite program, against the exact matrix.

use luenberger_proof::internals::{Equations, by_position, from_circles, scales};
use luenberger_proof::semidefinite::{Block, Entry, Program};
use luenberger_proof::{Exact, Interval, Matrix, Ring, positive_semidefinite};
use proptest::prelude::*;

/// A program of dense 4 x 4 constraints with entries that are multiples of 0.1, most of them zero.
fn program() -> impl Strategy<Value = Program> {
    let tenth = prop_oneof![4 => Just(0.0), 1 => (-9..=9_i32).prop_map(|k| f64::from(k) / 10.0)];
    prop::collection::vec(prop::collection::vec(tenth, 10), 1..=5).prop_map(|constraints| {
        let places: Vec<(usize, usize)> = (0..4).flat_map(|i| (i..4).map(move |j| (i, j))).collect();
        let entries = |values: &Vec<f64>| -> Vec<Entry> {
            let pairs = places.iter().zip(values).filter(|(_, x)| **x != 0.0);
            pairs.map(|(&(row, column), x)| Entry { block: 0, row, column, value: Interval::of(*x) }).collect()
        };
        let matrices = std::iter::once(Vec::new()).chain(constraints.iter().map(entries)).collect();
        let costs = vec![Interval::zero(); constraints.len()];
        Program::new(vec![Block::Dense(4)], costs, matrices).expect("well-posed")
    })
}

proptest! {
    /// The Gershgorin bound and the bound finally used are below the smallest eigenvalue of the exact Gram matrix.
    #[test]
    fn the_bounds_of_the_gram_matrix_hold(program in program()) {
        let (scales, all) = (scales(&program), by_position(&program));
        let m = program.unknowns();
        let exact = |x: f64| Exact::from_f64(x).expect("finite");
        let position = |e: &Entry| (e.row, e.column);
        let weight = |e: &Entry| if e.row == e.column { 1.0 } else { 2.0 };
        let mut g = Matrix::from_fn(m, m, |_, _| Exact::zero());
        for (i, x) in &all {
            for (j, y) in all.iter().filter(|(_, y)| position(y) == position(x)) {
                let size = |k: usize, e: &Entry| exact(scales[k]).mul(&exact(e.value.lo()));
                g[(*i, *j)] = g[(*i, *j)].add(&exact(weight(x)).mul(&size(*i, x)).mul(&size(*j, y)));
            }
        }
        let used = Equations::of(&program).expect("small").map(|equations| equations.smallest);
        for bound in [Some(from_circles(&program, &scales, &all)), used].into_iter().flatten() {
            if bound.is_finite() {
                let lowered = g.difference(&Matrix::scalar(m, &exact(bound))).expect("square");
                let holds = positive_semidefinite(&lowered).expect("symmetric").is_proved();
                prop_assert!(holds, "{bound:e}");
            }
        }
    }
}

/// Diagonal unit matrices and the matrix of ones, as in graph partitioning: circles with equal d would touch 0.
#[test]
fn circles_of_their_own_size_see_that_ones_and_units_are_independent() {
    let n = 40;
    let entry = |row, column| Entry { block: 0, row, column, value: Interval::of(1.0) };
    let mut matrices = vec![Vec::new()];
    matrices.extend((0..n).map(|i| vec![entry(i, i)]));
    matrices.push((0..n).flat_map(|i| (i..n).map(move |j| entry(i, j))).collect());
    let program = Program::new(vec![Block::Dense(n)], vec![Interval::zero(); n + 1], matrices).expect("well-posed");
    let bound = from_circles(&program, &scales(&program), &by_position(&program));
    assert!(bound > 0.1, "{bound}");
}
