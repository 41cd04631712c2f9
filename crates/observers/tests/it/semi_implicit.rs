//! The elimination of the semi-implicit step.

use luenberger_observers::internals::eliminate;

#[test]
fn rows_are_exchanged_and_singular_matrices_refused() {
    // [0 2; 3 1] x = [4; 5].
    let (mut a, mut x) = ([0.0, 2.0, 3.0, 1.0], [4.0, 5.0]);
    assert_eq!(eliminate(&mut a, &mut x), 1.0);
    assert_eq!(x, [1.0, 2.0]);
    assert_eq!(eliminate(&mut [1.0, 2.0, 2.0, 4.0], &mut [1.0, 1.0]), 0.0);
    assert_eq!(eliminate(&mut [f64::NAN], &mut [1.0]), 0.0);
    assert_eq!(eliminate::<f64>(&mut [], &mut []), 1.0);
}
