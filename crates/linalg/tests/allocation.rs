//! The second solution, and the second Schur form, of the same size takes no memory.
#![allow(unsafe_code, reason = "a counting allocator is an unsafe trait; it only passes on")]

mod counting_allocator;

use counting_allocator::allocations;
use luenberger_linalg::{
    DiscreteSylvesterEquation, LyapunovEquation, Schur, SchurWorkspace, SteinEquation, SylvesterEquation, schur_into,
};
use nalgebra::DMatrix;
use std::hint::black_box;

#[test]
fn the_second_solution_takes_no_memory() {
    for n in [1, 3, 10, 40] {
        let entry = |i: usize, j: usize| ((1 + 31 * i + 17 * j * j + i * i * j) as f64).sin();
        let a = DMatrix::from_fn(n, n, |i, j| entry(i, j) / n as f64 - if i == j { 2.0 } else { 0.0 });
        let q = DMatrix::from_fn(n, n, |i, j| entry(i.min(j), i.max(j)));
        let mut x = DMatrix::zeros(n, n);
        let (other, smaller) = (a.transpose() * 1.5, a.transpose() * 0.1);
        let mut lyapunov = LyapunovEquation::new(&a).unwrap();
        let mut stein = SteinEquation::new(&(&a * 0.2)).unwrap();
        let mut sylvester = SylvesterEquation::new(&a, &a.transpose()).unwrap();
        let mut discrete = DiscreteSylvesterEquation::new(&a, &(a.transpose() * 0.2)).unwrap();
        // The product kernels keep one buffer for each thread, made on the first call.
        lyapunov.solve_into(&q, &mut x).unwrap();
        let found = [
            allocations(|| _ = lyapunov.solve_into(&q, &mut x).unwrap()),
            allocations(|| _ = stein.solve_into(&q, &mut x).unwrap()),
            allocations(|| _ = sylvester.solve_into(&q, &mut x).unwrap()),
            allocations(|| _ = discrete.solve_into(&q, &mut x).unwrap()),
            // Other coefficients of the same order, and back.
            allocations(|| lyapunov.refactor(&other).unwrap()),
            allocations(|| _ = lyapunov.solve_into(&q, &mut x).unwrap()),
            allocations(|| stein.refactor(&smaller).unwrap()),
            allocations(|| _ = stein.solve_into(&q, &mut x).unwrap()),
        ];
        assert_eq!(found, [0; 8], "n = {n}");
        assert_eq!(lyapunov.solve(&q), LyapunovEquation::new(&other).unwrap().solve(&q));
        assert_eq!(stein.solve(&q), SteinEquation::new(&smaller).unwrap().solve(&q));
    }
    assert_eq!(allocations(|| drop(black_box(Box::new(1)))), 1, "the allocator counts");
}

#[test]
fn the_second_schur_form_takes_no_memory() {
    // Orders on all paths: the double shift, multishift on our own and on faer's Hessenberg reduction.
    for n in [2, 6, 31, 90, 150] {
        let a = DMatrix::from_fn(n, n, |i, j| ((i * 7 + j * 13 + i * j) % 17) as f64 - 8.0);
        let (mut found, mut workspace, mut values) = (Schur::default(), SchurWorkspace::new(), Vec::new());
        schur_into(&a, &mut found, &mut workspace).unwrap();
        workspace.eigenvalues(&a, &mut values).unwrap();
        assert_eq!(allocations(|| schur_into(&a, &mut found, &mut workspace).unwrap()), 0, "order {n}");
        assert_eq!(allocations(|| workspace.eigenvalues(&a, &mut values).unwrap()), 0, "eigenvalues, order {n}");
        // Another matrix of the same order, which may meet other windows.
        let a = a.transpose();
        assert_eq!(allocations(|| schur_into(&a, &mut found, &mut workspace).unwrap()), 0, "transposed, order {n}");
    }
}
