//! Requested poles: conjugate pairs, and the match with the achieved ones.

use luenberger_linalg::internals::RequestedPoles;
use nalgebra::Complex;

fn c(re: f64, im: f64) -> Complex<f64> {
    Complex::new(re, im)
}

#[test]
fn pairs_are_found_in_any_order_and_made_exact() {
    let requested =
        RequestedPoles::new(&[c(-1.0, 2.0), c(-3.0, 0.0), c(-1.0, -2.0 - 2e-16), c(-1.0, -2.0), c(-1.0, 2.0)], 5)
            .unwrap();
    assert_eq!(requested.real, [-3.0]);
    assert_eq!(requested.pairs.len(), 2);
    assert_eq!(requested.poles()[0], requested.poles()[3].conj());
}

#[test]
fn matching_takes_the_nearest_first() {
    let requested = RequestedPoles::new(&[c(-1.0, 0.0), c(-2.0, 0.0), c(0.0, 1.0), c(0.0, -1.0)], 4).unwrap();
    let achieved = [c(0.1, -1.0), c(-2.1, 0.0), c(-1.4, 0.0), c(0.1, 1.0)];
    assert_eq!(requested.matched(&achieved), [2, 1, 3, 0]);
}
