//! Vectors of small rationals near given numbers.

use luenberger_lmi::internals::near_rational;

#[test]
fn small_rationals_are_found_and_others_are_not() {
    assert_eq!(near_rational(&[0.5 + 1e-9, -1.0 / 3.0, 0.0, 2.0], 1e-6), Some(vec![3, -2, 0, 12]));
    assert_eq!(near_rational(&[1.0, std::f64::consts::SQRT_2], 1e-9), None);
    assert_eq!(near_rational(&[0.0], 1e-6), None);
    assert_eq!(near_rational(&[f64::NAN, 1.0], 1e-6), None);
}
