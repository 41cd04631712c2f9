//! Tensor trains from a small part of a grid.

use luenberger_design::internals::approximate;
use luenberger_design::numerical_kkl::{Domain, Escape, Settings, Train};
use luenberger_observers::numerical_kkl::BoxMap;
use luenberger_random::Random;
use nalgebra::SVector;
use std::ops::ControlFlow::Continue;

fn train<const N: usize, const Z: usize>(
    points: [usize; N],
    settings: &Settings<N>,
    map: impl Fn(&[f64; N]) -> SVector<f64, Z>,
) -> (Train<N, Z>, usize) {
    let domain = Domain::new([-1.0; N], [1.0; N], Escape::Free).unwrap();
    let settings = Settings { points, ..*settings };
    approximate(&domain, &settings, |x| Ok(map(&x.data.0[0])), &mut |_| Continue(())).unwrap()
}

/// Cubics of low rank are reproduced with their derivatives, from few of the 8^6 = 262144 points.
#[test]
fn a_polynomial_of_low_rank_is_found_from_few_points() {
    let map = |x: &[f64; 6]| {
        let first = x[0] * x[1] + x[2].powi(3) * x[3] - x[4] * x[5] + 0.5;
        SVector::from([first, x[0] * x[5] - x[3].powi(2) * x[1]])
    };
    let (train, evaluated) = train([8; 6], &Settings::default(), map);
    // Across each cut: 1, the function of one side, that of the other, and products that cross it.
    assert!(train.ranks().iter().all(|rank| *rank <= 8), "{:?}", train.ranks());
    assert!(evaluated < 262_144 / 30, "{evaluated}");
    let mut random = Random(5);
    for _ in 0..50 {
        let x: [f64; 6] = core::array::from_fn(|_| random.unit());
        let (value, slope) = train.with_gradient(&SVector::from(x));
        // Sums of some dozens of products below 10, with errors of interpolation of rank r of (1 + r) EPSILON.
        assert!((value - map(&x)).amax() < 1e-11, "{value} {}", map(&x));
        let exact = [x[1], x[0], 3.0 * x[2].powi(2) * x[3], x[2].powi(3), -x[5], -x[4]];
        for (axis, exact) in exact.into_iter().enumerate() {
            assert!((slope[(0, axis)] - exact).abs() < 1e-10, "{axis} {} {exact}", slope[(0, axis)]);
        }
    }
}

/// The error at the tolerance, or at the largest rank, is what is measured at points off the grid.
#[test]
fn the_rank_follows_the_tolerance() {
    let map = |x: &[f64; 4]| SVector::from([(1.0 + 0.3 * (x[0] + x[1] + x[2] + x[3])).sin() / (4.0 + x[0] * x[3])]);
    let error = |tolerance: f64, rank: usize| {
        let settings = Settings { rank, rank_tolerance: tolerance, ..Settings::default() };
        let (train, _) = train([33; 4], &settings, map);
        let mut random = Random(11);
        let worst = (0..200).map(|_| {
            let x: [f64; 4] = core::array::from_fn(|_| random.unit());
            (train.with_gradient(&SVector::from(x)).0 - map(&x)).amax()
        });
        (worst.fold(0.0f64, f64::max), train.ranks().into_iter().max())
    };
    let ((coarse, few), (fine, more)) = (error(1e-3, 32), error(1e-7, 32));
    // The splines themselves miss this map by about 1e-7.
    assert!(coarse < 1e-2 && fine < 1e-5 && few < more, "{coarse} {fine} {few:?} {more:?}");
    let (poor, two) = error(1e-9, 2);
    assert!(two == Some(2) && poor > 1e-4, "{poor} {two:?}");
}

#[test]
fn constants_and_single_axes_have_rank_one() {
    let (train, _) = train([5; 3], &Settings::default(), |x: &[f64; 3]| SVector::from([2.0 + x[1]]));
    assert!((train.with_gradient(&SVector::from([0.1, 0.2, 0.3])).0[0] - 2.2).abs() < 1e-13);
    assert_eq!(train.ranks()[0], 1);
    let (zero, _) = self::train([4; 3], &Settings::default(), |_: &[f64; 3]| SVector::from([0.0]));
    assert_eq!(zero.with_gradient(&SVector::from([0.1, 0.2, 0.3])).0[0], 0.0);
}
