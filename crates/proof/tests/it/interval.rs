//! Bounds of sums and products: the neighbours of the rounded results, or the results where they are exact.

use luenberger_proof::{Exact, Interval, Ring};
use luenberger_random::Random;

/// Both signs of zero, of the smallest and largest subnormal and normal numbers, of powers of 2 with their
/// neighbours and of infinity; and numbers of all exponents.
fn numbers() -> Vec<f64> {
    let mut all = vec![0.0, f64::INFINITY, f64::MAX, f64::MIN_POSITIVE, f64::from_bits(1), 1.0, 2.5e-310];
    all.extend((-1074..=1023).map(|e| 2f64.powi(e)));
    all.extend(all.clone().into_iter().flat_map(|x| [x.next_up(), x.next_down()]));
    let mut random = Random(1);
    all.extend((0..4000).map(|_| f64::from_bits(random.bits())).filter(|x| !x.is_nan()));
    all.iter().flat_map(|x| [*x, -x]).collect()
}

/// Of a product by 1, which counts as rounded, the neighbours; of a sum, exact or not, its nearest bounds.
#[test]
fn neighbours_are_those_of_the_standard_library() {
    let numbers: Vec<f64> = numbers().into_iter().filter(|x| x.is_finite()).collect();
    for &x in numbers.iter().filter(|x| **x != 0.0) {
        let product = Interval::of(x).mul(&Interval::of(1.0));
        assert_eq!(product.lo().to_bits(), x.next_down().to_bits(), "{x:e}");
        assert_eq!(product.hi().to_bits(), x.next_up().to_bits(), "{x:e}");
    }
    let exact = |x: f64| Exact::from_f64(x).expect("finite");
    for pair in numbers.windows(2).chain([[f64::MAX, f64::MAX].as_slice()]) {
        let (x, y) = (pair[0], pair[1]);
        let sum = Interval::of(x).add(&Interval::of(y));
        assert_eq!(sum, exact(x).add(&exact(y)).enclosure(), "{x:e} + {y:e}");
    }
}

/// The bounds are the extreme products of the bounds, moved outwards, with 0 times infinity defined as 0.
#[test]
fn products_are_the_extreme_ones() {
    let numbers = numbers();
    let bounds = [-f64::INFINITY, -f64::MAX, -3.0, -1e-320, -0.0, 0.0, 1e-320, 0.3, 7.0, f64::MAX, f64::INFINITY];
    let special = bounds.iter().flat_map(|lo| bounds.iter().filter_map(|hi| Interval::new(*lo, *hi)));
    let random = numbers.windows(2).step_by(97).filter_map(|ends| Interval::new(ends[0], ends[1]));
    let intervals: Vec<Interval> = special.chain(random).collect();
    assert!(intervals.len() > 80);
    for x in &intervals {
        for y in &intervals {
            let product = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
            let all = [x.lo(), x.hi()].into_iter().flat_map(|a| [y.lo(), y.hi()].map(|b| product(a, b)));
            let (lo, hi) = all.fold((f64::INFINITY, -f64::INFINITY), |(lo, hi), xy| (lo.min(xy), hi.max(xy)));
            let found = x.mul(y);
            if x.is_zero() || y.is_zero() {
                assert_eq!(found, Interval::zero());
            } else {
                assert_eq!((found.lo(), found.hi()), (lo.next_down(), hi.next_up()), "{x:?} {y:?}");
            }
        }
    }
}
