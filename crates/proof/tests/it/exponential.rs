//! Enclosures of matrix exponentials against closed forms and SciPy.

use luenberger_proof::internals::exponential;
use luenberger_proof::{Interval, Matrix};

#[test]
fn exponentials_are_enclosed_tightly() {
    // exp [0 1; -1 0] t is a rotation; the other reference is scipy.linalg.expm([[1, 2], [3, 4]]).
    let rotation = Matrix::from_rows([[0.0, 3.0], [-3.0, 0.0]]).map(|x| Interval::of(*x));
    let found = exponential(&rotation).expect("square").expect("small");
    for (entry, exact) in found.as_slice().iter().zip([3.0_f64.cos(), 3.0_f64.sin(), -3.0_f64.sin(), 3.0_f64.cos()]) {
        assert!((entry.midpoint() - exact).abs() < 1e-13 && entry.width() < 1e-12, "{entry:?} {exact}");
    }
    let full = Matrix::from_rows([[1.0, 2.0], [3.0, 4.0]]).map(|x| Interval::of(*x));
    let found = exponential(&full).expect("square").expect("small");
    let scipy = [51.968_956_198_705, 74.736_564_567_003_2, 112.104_846_850_505, 164.073_803_049_21];
    for (entry, exact) in found.as_slice().iter().zip(scipy) {
        assert!((entry.midpoint() - exact).abs() < 1e-11 * exact && entry.width() < 1e-10, "{entry:?} {exact}");
    }
    let huge = Matrix::from_rows([[1e6]]).map(|x: &f64| Interval::of(*x));
    assert!(exponential(&huge).expect("square").is_none());
}
