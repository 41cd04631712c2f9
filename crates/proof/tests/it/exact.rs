//! Exact numbers and intervals against binary64 arithmetic.

use luenberger_proof::{Exact, Interval, Ring};
use proptest::prelude::*;

fn exact(x: f64) -> Exact {
    Exact::from_f64(x).expect("finite")
}

fn finite() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |x| x.is_finite()),
        -4.0..4.0_f64,
        (-50..50_i32).prop_map(f64::from),
        (0..1000_u64).prop_map(f64::from_bits),
    ]
}

proptest! {
    #[test]
    fn binary64_comes_back(x in finite()) {
        prop_assert_eq!(exact(x).round_down(), x);
        prop_assert_eq!(exact(x).round_up(), x);
    }

    /// Rounding is to the two floats on either side, of sums and products of every size.
    #[test]
    fn rounding_brackets_within_one_float(x in finite(), y in finite()) {
        for z in [exact(x).add(&exact(y)), exact(x).mul(&exact(y)), exact(x).mul(&exact(y)).sub(&exact(x))] {
            let (below, above) = (z.round_down(), z.round_up());
            prop_assert!(below == above || below.next_up() == above);
            if below.is_finite() { prop_assert!(exact(below) <= z); }
            if above.is_finite() { prop_assert!(exact(above) >= z); }
            if below == above { prop_assert_eq!(exact(below), z); }
        }
    }

    #[test]
    fn sums_agree_with_the_rounding_of_binary64(x in finite(), y in finite()) {
        let (sum, rounded) = (exact(x).add(&exact(y)), x + y);
        prop_assert!(sum.round_down() <= rounded && rounded <= sum.round_up());
        prop_assert_eq!(exact(x).cmp(&exact(y)), x.partial_cmp(&y).expect("finite"));
    }

    /// The law of intervals: what the numbers may be, the result may be.
    #[test]
    fn intervals_enclose(x in finite(), y in finite(), z in finite(), w in finite()) {
        let (a, b) = (Interval::new(x.min(y), x.max(y)).expect("ordered"), Interval::new(z.min(w), z.max(w)).expect("ordered"));
        for (result, of) in [
            (a.add(&b), [exact(x).add(&exact(z)), exact(y).add(&exact(w)), exact(x).add(&exact(w))]),
            (a.sub(&b), [exact(x).sub(&exact(z)), exact(y).sub(&exact(w)), exact(x).sub(&exact(w))]),
            (a.mul(&b), [exact(x).mul(&exact(z)), exact(y).mul(&exact(w)), exact(x).mul(&exact(w))]),
        ] {
            prop_assert!(!result.lo().is_nan() && !result.hi().is_nan());
            for value in of {
                prop_assert!(!result.lo().is_finite() || exact(result.lo()) <= value);
                prop_assert!(!result.hi().is_finite() || exact(result.hi()) >= value);
            }
        }
        if let Some((middle, radius)) = a.midpoint_radius() {
            prop_assert!(exact(middle).sub(&exact(radius)) <= exact(a.lo()) && exact(middle).add(&exact(radius)) >= exact(a.hi()));
        }
    }
}

#[test]
fn beyond_the_range_the_bounds_are_the_last_numbers() {
    let large = Exact::power_of_two(1024);
    assert_eq!((large.round_down(), large.round_up()), (f64::MAX, f64::INFINITY));
    assert_eq!((large.neg().round_down(), large.neg().round_up()), (f64::NEG_INFINITY, -f64::MAX));
    let small = Exact::power_of_two(-1075);
    assert_eq!((small.round_down(), small.round_up()), (0.0, f64::from_bits(1)));
    assert_eq!(Exact::from_f64(f64::NAN), None);
    assert_eq!(Exact::from_f64(f64::NEG_INFINITY), None);
}
