//! The controllability staircase and its estimate of the distance from an uncontrollable pair.

use luenberger_linalg::eigenvalues;
use luenberger_linalg::internals::Staircase;
use nalgebra::{Complex, DMatrix};

/// SLICOT AB01ND, example program: rank 2, `Q'F Q` reachable block similar to [-3 2.2361; 0 -1], `Q'G` = [0
/// -2.2361; 1 0].
#[test]
fn the_example_of_slicot_ab01nd() {
    let a = DMatrix::from_row_slice(3, 3, &[-1.0, 0.0, 0.0, -2.0, -2.0, -2.0, -1.0, 0.0, -3.0]);
    let b = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 0.0, 2.0, 0.0, 1.0]);
    let s = Staircase::new(&a, &b, 1e-14);
    assert_eq!(s.rank, 2);
    // Pivoting takes the longer column of B, (0,2,1) of norm sqrt 5, first: the order of SLICOT's answer.
    let sizes = s.f.map(f64::abs);
    for (entry, printed) in [((0, 0), 3.0), ((0, 1), 2.2361), ((1, 0), 0.0), ((1, 1), 1.0)] {
        assert!((sizes[entry] - printed).abs() < 5e-5, "{entry:?}: {} printed {printed}", sizes[entry]);
    }
    assert!((s.g[(0, 1)].abs() - 2.2361).abs() < 5e-5 && (s.g[(1, 0)].abs() - 1.0).abs() < 1e-14);
    assert!((&s.q * &s.f * s.q.transpose() - &a).norm() < 1e-14 * a.norm() * 3.0);
    assert!((&s.q * &s.g - &b).norm() < 1e-14 * b.norm());
}

#[test]
fn one_input_gives_the_hessenberg_form() {
    let a = DMatrix::from_fn(6, 6, |i, j| ((i * 7 + j * 3) % 11) as f64 - 5.0);
    let b = DMatrix::from_fn(6, 1, |i, _| 1.0 + i as f64);
    let s = Staircase::new(&a, &b, 1e-13);
    assert_eq!(s.rank, 6);
    for j in 0..6 {
        for i in j + 2..6 {
            assert_eq!(s.f[(i, j)], 0.0);
        }
    }
    assert!(s.g.rows(1, 5).iter().all(|x| *x == 0.0));
    assert!((&s.q * &s.f * s.q.transpose() - &a).norm() < 1e-14 * a.norm());
}

#[test]
fn without_inputs_nothing_is_reached() {
    let a = DMatrix::identity(3, 3);
    assert_eq!(Staircase::new(&a, &DMatrix::zeros(3, 0), 0.0).rank, 0);
    assert_eq!(Staircase::new(&a, &DMatrix::zeros(3, 2), 0.0).rank, 0);
    assert_eq!(Staircase::new(&DMatrix::zeros(0, 0), &DMatrix::zeros(0, 2), 0.0).rank, 0);
}

/// For one input and for several: the estimate stays below ten times `min sigma_min([G, F - lambda I])` over the
/// eigenvalues, and is small where that is small.
#[test]
fn the_least_margin_is_no_more_than_ten_times_the_margin() {
    for (n, m, weak) in [(1, 1, 1.0), (2, 1, 1.0), (5, 1, 1.0), (5, 2, 1e-9), (7, 3, 1.0), (4, 6, 1.0), (8, 1, 1e-9)] {
        // The last state is driven through one entry only, and by itself.
        let f = DMatrix::from_fn(n, n, |i, j| match ((3 * i + 7 * j * j + 5 * i * j + 2) as f64).sin() {
            x if i + 1 == n && j + 1 < n => weak * x,
            x => x,
        });
        let g = DMatrix::from_fn(n, m, |i, j| {
            if i + 1 == n && n > 1 && weak < 1.0 { 0.0 } else { ((5 * i + 2 * j + 1) as f64).cos() }
        });
        let estimate = Staircase::new(&f, &g, 1e-14).least_margin();
        let smallest = eigenvalues(&f)
            .unwrap()
            .into_iter()
            .map(|lambda| {
                let shifted = f.map(Complex::from) - DMatrix::identity(n, n) * lambda;
                let pencil =
                    DMatrix::from_fn(
                        n,
                        n + m,
                        |i, j| {
                            if j < m { Complex::from(g[(i, j)]) } else { shifted[(i, j - m)] }
                        },
                    );
                pencil.singular_values().min()
            })
            .fold(f64::INFINITY, f64::min);
        assert!(estimate <= 10.0 * smallest, "n = {n}, m = {m}: {estimate:e} > 10 * {smallest:e}");
        assert!(estimate >= 1e-7 * smallest, "n = {n}, m = {m}: {estimate:e} says nothing of {smallest:e}");
    }
    // If a row has no pivot, the margin is zero.
    let unreachable = Staircase::new(&DMatrix::identity(2, 2), &DMatrix::from_element(2, 1, 1.0), 1e-14);
    assert_eq!(unreachable.least_margin(), 0.0);
}
