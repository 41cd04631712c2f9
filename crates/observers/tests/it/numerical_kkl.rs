//! Tables that do not fit are refused, and what runs is bounded.
#![cfg(feature = "alloc")]

use approx::assert_abs_diff_eq;
use luenberger_observers::ObserverError;
use luenberger_observers::numerical_kkl::least_squares::nearest;
use luenberger_observers::numerical_kkl::polynomial_tree::{monomial_count, monomials};
use luenberger_observers::numerical_kkl::{
    BoxMap, Branch, Coordinates, InterpolatedInverse, Node, PolynomialInverse, PolynomialTree, Search, TensorSpline,
    TensorTrain,
};
use nalgebra::{Matrix2, SVector, Vector1, Vector2, Vector3};
use proptest::prelude::*;

type Line = PolynomialTree<f64, Vec<Node<f64>>, Vec<f64>, 1, 1>;

/// The leaf `slope * (x - centre) + value` on [centre - 1, centre + 1], with values from -9 to 9.
fn leaf(centre: f64, slope: f64, value: f64) -> [f64; 6] {
    [centre, 1.0, -9.0, 9.0, slope, value]
}

#[test]
fn a_tree_leads_to_the_leaf_of_the_point() {
    let node = |threshold, below, above| Node { axis: 0, threshold, below, above };
    let nodes = vec![node(0.0, Branch::Leaf(0), Branch::Node(1)), node(2.0, Branch::Leaf(2), Branch::Leaf(1))];
    let leaves = [leaf(-1.0, 0.0, 5.0), leaf(3.0, 1.0, 3.0), leaf(1.0, -1.0, 0.0)].concat();
    let tree = Line::new(1, nodes, leaves).unwrap();
    let at = |x: f64| tree.at(&Vector1::new(x))[0];
    assert_eq!((at(-0.5), at(1.5), at(3.5)), (5.0, -0.5, 3.5));
    // Held a little beyond the samples.
    assert_eq!((at(100.0), at(-1e300)), (3.0 + 1.125, 5.0));
    assert_eq!((tree.leaf_count(), tree.depth(), tree.numbers(), tree.multiply_adds()), (3, 2, 20, 3));
    let single = tree.cast::<f32>();
    assert_eq!(single.at(&Vector1::new(1.5f32))[0], -0.5);
}

#[test]
fn trees_that_do_not_fit_are_refused() {
    let refuse = |nodes: Vec<Node<f64>>, leaves: Vec<f64>| Line::new(1, nodes, leaves).unwrap_err();
    let table = |error: ObserverError| matches!(error, ObserverError::Table { .. });
    let whole = leaf(0.0, 1.0, 0.0).to_vec();
    assert!(table(refuse(vec![], vec![])) && table(refuse(vec![], whole[1..].to_vec())));
    let node = |axis, below, above| vec![Node { axis, threshold: 0.0, below, above }];
    assert!(table(refuse(node(1, Branch::Leaf(0), Branch::Leaf(0)), whole.clone())));
    assert!(table(refuse(node(0, Branch::Leaf(0), Branch::Leaf(1)), whole.clone())));
    // A comparison that leads to itself would never end.
    assert!(table(refuse(node(0, Branch::Node(0), Branch::Leaf(0)), whole.clone())));
    assert!(table(refuse(node(0, Branch::Node(7), Branch::Leaf(0)), whole.clone())));
    let mut nan = whole.clone();
    nan[4] = f64::NAN;
    assert!(matches!(refuse(vec![], nan), ObserverError::TableNotFinite { index: 4, .. }));
    assert!(table(Line::new(usize::MAX, vec![], whole).unwrap_err()));
}

#[test]
fn splines_that_do_not_fit_are_refused() {
    let (zero, one) = (Vector1::new(0.0), Vector1::new(1.0));
    let refuse = |lower, upper, points, table: &[f64]| {
        TensorSpline::<f64, _, 1, 1>::new(lower, upper, points, table.to_vec()).unwrap_err()
    };
    assert!(matches!(refuse(one, zero, [2], &[0.0; 4]), ObserverError::Box { axis: 0, .. }));
    assert!(matches!(refuse(zero, Vector1::new(f64::NAN), [2], &[0.0; 4]), ObserverError::Box { .. }));
    assert!(matches!(refuse(zero, one, [1], &[0.0; 3]), ObserverError::Table { .. }));
    assert!(matches!(refuse(zero, one, [2], &[0.0; 5]), ObserverError::Table { expected: 4, found: 5, .. }));
    assert!(matches!(refuse(zero, one, [usize::MAX], &[0.0; 5]), ObserverError::Table { .. }));
    assert!(matches!(refuse(zero, one, [2], &[f64::INFINITY; 4]), ObserverError::TableNotFinite { .. }));
}

/// T(x) = x on [-1, 1]^2 as a spline: coefficient (i, j) is the point of the grid continued by one cell.
fn identity(points: usize) -> TensorSpline<f64, Vec<f64>, 2, 2> {
    let at = |k: usize| 2.0 * (k as f64 - 1.0) / (points as f64 - 1.0) - 1.0;
    let table = (0..(points + 2) * (points + 2)).flat_map(|k| [at(k / (points + 2)), at(k % (points + 2))]).collect();
    TensorSpline::new(Vector2::repeat(-1.0), Vector2::repeat(1.0), [points; 2], table).unwrap()
}

proptest! {
    /// For T = identity the nearest point of the box is the projection on it.
    #[test]
    fn the_nearest_point_is_the_projection(
        w in prop::array::uniform2(-3.0..3.0f64),
        guess in prop::array::uniform2(-2.0..2.0f64),
    ) {
        let spline = identity(5);
        let found = nearest(&spline, &SVector::from(w), &SVector::from(guess), 30);
        let projection = SVector::from(w).map(|x: f64| x.clamp(-1.0, 1.0));
        // Values of size one, sixteen terms each.
        prop_assert!((found.x - projection).amax() <= 64.0 * f64::EPSILON, "{found:?}");
        prop_assert!(found.converged && found.evaluations <= 30);
    }

    /// Horner consumes the coefficients in the order in which `monomials` names the monomials.
    #[test]
    fn monomials_and_horner_agree(
        x in prop::array::uniform3(-1.0..1.0f64),
        c in prop::collection::vec(-1.0..1.0f64, 20),
    ) {
        let mut terms = Vec::new();
        monomials(&x, 3, 1.0, &mut |m| terms.push(m));
        prop_assert_eq!(terms.len(), monomial_count(3, 3));
        let sum: f64 = terms.iter().zip(&c).map(|(m, c)| m * c).sum();
        let leaf = [&[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, -99.0, 99.0][..], &c].concat();
        let tree = PolynomialTree::<f64, Vec<Node<f64>>, _, 3, 1>::new(3, vec![], leaf).unwrap();
        // Twenty terms below one.
        prop_assert!((tree.at(&SVector::from(x))[0] - sum).abs() <= 40.0 * f64::EPSILON);
    }
}

#[test]
fn a_start_that_fails_is_mended_by_the_coarse_grid_and_nothing_makes_nan() {
    // The embedded form that always says (0.9, 0.9), and T = identity.
    let bad = |values: [f64; 2]| {
        let data = [&[0.0, 0.0, 1.0, 1.0], &values[..], &values[..], &values[..]].concat();
        PolynomialTree::<f64, Vec<Node<f64>>, Vec<f64>, 2, 2>::new(0, vec![], data).unwrap()
    };
    let start = PolynomialInverse::new(
        Coordinates::new(Vector2::zeros(), Matrix2::identity(), Matrix2::identity()).unwrap(),
        (Vector2::repeat(-1.0), Vector2::repeat(1.0)),
        bad([0.9, 0.9]),
        bad([0.0, 0.0]),
    )
    .unwrap();
    let search = Search { max_evaluations: 20, tolerance: 1e-12, fallback: 5 };
    assert!(InterpolatedInverse::new(identity(5), start.clone(), Search { max_evaluations: 0, ..search }).is_err());
    assert!(InterpolatedInverse::new(identity(5), start.clone(), Search { fallback: 1 << 20, ..search }).is_err());
    assert!(InterpolatedInverse::new(identity(5), start.clone(), Search { tolerance: f64::NAN, ..search }).is_err());
    let inverse = InterpolatedInverse::new(identity(5), start, search).unwrap();
    let z = Vector2::new(-0.4, 0.3);
    assert_abs_diff_eq!(inverse.state(&z), z, epsilon = 1e-12);
    assert_abs_diff_eq!(inverse.target(&z), z, epsilon = 1e-12);
    // Out of reach: every start is tried, the end is the projection.
    let far = inverse.solve(&Vector2::new(5.0, 0.0), &Vector2::zeros());
    assert!((far.x - Vector2::new(1.0, 0.0)).amax() < 1e-7 && (far.residual - 4.0).abs() < 1e-12, "{far:?}");
    assert!(far.evaluations <= 25 + 5 * 20);
    for wild in [Vector2::repeat(f64::MAX), Vector2::new(1e300, -1e300), Vector2::new(f64::NAN, 0.0)] {
        let x = inverse.solve(&wild, &Vector2::new(f64::NAN, f64::INFINITY)).x;
        assert!(x.iter().all(|x| (-1.0..=1.0).contains(x)), "{wild}: {x}");
    }
}

/// The coefficients of a tensor train multiplied out are those of a tensor-product spline: the same map, the same
/// slopes.
#[test]
fn a_tensor_train_is_the_spline_with_its_products() {
    let (points, ranks) = ([3, 2, 4], [2, 3, 2]);
    let sizes = [5 * 2 * 3, 4 * 3 * 2, 6 * 2];
    let numbers: Vec<f64> = (0..sizes.iter().sum()).map(|k| (0.37 + 1.9 * k as f64).sin()).collect();
    let (first, rest) = numbers.split_at(sizes[0]);
    let (second, third) = rest.split_at(sizes[1]);
    let mut products = Vec::new();
    for i in 0..5 {
        for j in 0..4 {
            for k in 0..6 {
                for z in 0..2 {
                    let pairs = (0..3).flat_map(|a| (0..2).map(move |b| (a, b)));
                    products.push(
                        pairs
                            .map(|(a, b)| first[6 * i + 3 * z + a] * second[6 * j + 2 * a + b] * third[2 * k + b])
                            .sum(),
                    );
                }
            }
        }
    }
    let (lower, upper) = (Vector3::new(-1.0, 0.0, 2.0), Vector3::new(1.0, 3.0, 2.5));
    let train = TensorTrain::<f64, _, 3, 2>::new(lower, upper, points, ranks, numbers.clone()).unwrap();
    let spline = TensorSpline::<f64, Vec<f64>, 3, 2>::new(lower, upper, points, products).unwrap();
    for k in 0..60 {
        let share = |i: f64| (i * f64::from(k)).fract();
        // The last points are outside: the value at the nearest point of the box.
        let wide = if k > 50 { 3.0 } else { 1.0 };
        let x = lower + (upper - lower).component_mul(&Vector3::new(share(0.618), share(0.755), share(0.57))) * wide;
        let ((value, slope), (exact, exact_slope)) = (train.with_gradient(&x), spline.with_gradient(&x));
        // Some hundred products of numbers below 1; slopes are divided by the spacing, 1/6.
        assert!((value - exact).amax() < 1e-13 && (slope - exact_slope).amax() < 1e-12, "{x}");
    }
    assert!(train.with_gradient(&Vector3::repeat(f64::NAN)).0.iter().all(|entry| entry.is_finite()));
    let single = train.cast::<f32>().with_gradient(&nalgebra::Vector3::new(0.0f32, 1.0, 2.25)).0;
    let double = train.with_gradient(&Vector3::new(0.0, 1.0, 2.25)).0;
    assert!((single.map(f64::from) - double).amax() < 1e-5);

    let refused = |ranks, length: usize| {
        TensorTrain::<f64, _, 3, 2>::new(lower, upper, points, ranks, vec![0.0; length]).unwrap_err().to_string()
    };
    for (said, ranks, length) in [
        ("coefficients of the tensor train", ranks, 65),
        ("the first rank", [3, 3, 2], 66),
        ("the largest rank", [2, 33, 2], 66),
        ("the smallest rank", [2, 0, 2], 66),
    ] {
        assert!(refused(ranks, length).contains(said), "{}", refused(ranks, length));
    }
    let mut broken = numbers;
    broken[7] = f64::NAN;
    assert!(TensorTrain::<f64, _, 3, 2>::new(lower, upper, points, ranks, broken).is_err());
}
