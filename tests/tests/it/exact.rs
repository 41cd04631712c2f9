//! The exact spectra by which certificates are contradicted.

use dashu_int::IBig;
use luenberger_tests::falsify::exact::{Exact, Inertia};

#[test]
fn spectra_of_known_matrices() {
    let of = |n: usize, x: &[f64]| Exact::from_f64(n, n, x);
    assert!(of(2, &[0.0, 1.0, -2.0, -3.0]).is_hurwitz() && !of(2, &[0.0, 1.0, -2.0, 0.0]).is_hurwitz());
    assert!(!of(2, &[0.0, 1.0, 2.0, -3.0]).is_hurwitz());
    // (s + 1)(s^2 + 1), and with real parts of one unit in the last place.
    assert!(!of(3, &[-1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0]).is_hurwitz());
    let tiny = -f64::EPSILON / 2.0;
    assert!(of(3, &[-1.0, 0.0, 0.0, 0.0, tiny, 1.0, 0.0, -1.0, tiny]).is_hurwitz());
    let below = 1.0_f64.next_down();
    assert!(of(2, &[below, 1e9, 0.0, -below]).is_schur());
    assert!(!of(2, &[1.0, 0.0, 0.0, 0.5]).is_schur() && !of(2, &[-1.0, 0.0, 0.0, 0.5]).is_schur());
    assert!(!of(2, &[0.0, 1.0, -1.0, 0.0]).is_schur() && of(2, &[0.0, below, -below, 0.0]).is_schur());
    assert!(!of(2, &[3.0, 0.0, 0.0, 3.0]).is_schur() && of(3, &[0.0; 9]).is_schur());
    let m = of(2, &[2.0, 1.0, 1.0, 2.0]);
    assert_eq!(m.minus(&Exact::identity(2)).inertia(), Inertia { positive: 1, zero: 1, negative: 0 });
    let x = m.solve(&Exact::from_f64(2, 1, &[1.0, 0.0])).expect("regular");
    let thirds = Exact::rational(IBig::ONE, 0, IBig::from(3));
    assert!(x.at(0, 0).minus(&thirds.plus(&thirds)).is_zero() && x.at(1, 0).plus(&thirds).is_zero());
    assert!(of(2, &[1.0, 2.0, 2.0, 4.0]).solve(&Exact::zeros(2, 1)).is_none());
}
