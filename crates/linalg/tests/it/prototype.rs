//! Poles from specifications, against scipy 1.17.1 (`besselap`, `buttap`, and the settling times of `step` sampled
//! 600 001 times) and the textbook's formulas.

use luenberger_linalg::{LinalgError, PolePattern, damping_from_overshoot, poles_from};
use nalgebra::Complex;

/// Up to order, as sets closed under conjugation; the settling times of the reference are known to 3e-5.
#[track_caller]
fn assert_poles(pattern: PolePattern, order: usize, band: f64, expected: &[(f64, f64)]) {
    let mut found = poles_from(pattern, order, 1.0, band).unwrap();
    assert_eq!(found.len(), order);
    for (re, im) in expected {
        let pole = Complex::new(*re, *im);
        let nearest = (0..found.len()).min_by(|x, y| (found[*x] - pole).norm().total_cmp(&(found[*y] - pole).norm()));
        let nearest = found.swap_remove(nearest.unwrap());
        assert!((nearest - pole).norm() < 3e-5 * pole.norm(), "{pattern:?}: {nearest} where {pole} is expected");
    }
}

#[test]
fn bessel_poles_settle_as_in_scipy() {
    assert_poles(PolePattern::Bessel, 2, 0.02, &[(-3.76305, 2.172597930474021), (-3.76305, -2.172597930474021)]);
    let three =
        [(-3.7748170066456512, 3.601305515196034), (-4.766865986708697, 0.0), (-3.774817006645651, -3.6013055152)];
    assert_poles(PolePattern::Bessel, 3, 0.02, &three);
    let (first, second) = ((-4.082351665297838, 7.289811134598889), (-6.061560378974266, 4.2613894525541065));
    let third = (-6.893387955727895, 1.4076211957852138);
    let conjugate = |(re, im): (f64, f64)| (re, -im);
    let six = [first, second, third].into_iter().flat_map(|pole| [pole, conjugate(pole)]).collect::<Vec<_>>();
    assert_poles(PolePattern::Bessel, 6, 0.02, &six);
}

#[test]
fn butterworth_and_itae_poles_settle_as_in_scipy() {
    let three = [(-2.98275, 5.166274546276068), (-5.9655, 0.0), (-2.98275, -5.166274546276068)];
    assert_poles(PolePattern::Butterworth, 3, 0.05, &three);
    let pair = (-3.9289283447423586, 8.055464173090941);
    assert_poles(PolePattern::Itae, 3, 0.02, &[pair, (pair.0, -pair.1), (-5.340380810515287, 0.0)]);
}

/// All orders have poles in the left half plane, closed under conjugation, on one circle for Butterworth.
#[test]
fn every_order_is_stable() {
    for order in 1..=20 {
        for pattern in [PolePattern::Bessel, PolePattern::Butterworth, PolePattern::Itae] {
            if pattern == PolePattern::Itae && order > 6 {
                assert!(matches!(poles_from(pattern, order, 1.0, 0.02), Err(LinalgError::InvalidSpecification { .. })));
                continue;
            }
            let poles = poles_from(pattern, order, 2.0, 0.02).unwrap();
            assert!(poles.len() == order && poles.iter().all(|pole| pole.re < 0.0), "{pattern:?} {order}");
            let sum: Complex<f64> = poles.iter().sum();
            assert!(sum.im.abs() < 1e-9 * sum.norm(), "{pattern:?} {order}: {sum}");
            if pattern == PolePattern::Butterworth {
                assert!(poles.iter().all(|pole| (pole.norm() / poles[0].norm() - 1.0).abs() < 1e-14));
            }
        }
    }
}

/// The envelope of the pair meets the band at the settling time; Franklin, Powell, Emami-Naeini: 4.6/sigma for 1 %,
/// with the square root neglected.
#[test]
fn a_dominant_pair_has_the_damping_and_the_envelope() {
    let poles = poles_from(PolePattern::Dominant { damping: 0.6, ratio: 5.0 }, 4, 3.0, 0.01).unwrap();
    let (sigma, omega) = (-poles[0].re, poles[0].norm());
    assert!((sigma / omega - 0.6).abs() < 1e-15 && poles[1] == poles[0].conj());
    assert!(((-3.0 * sigma).exp() / 0.8 - 0.01).abs() < 1e-15);
    assert!((3.0 * sigma - 4.6).abs() < 0.25);
    assert!((poles[2].re + 5.0 * sigma).abs() < 1e-14 && (poles[3].re / poles[2].re - 1.1).abs() < 1e-14);
    // A double pole: (1 + w t) e^{-w t} = band; 5.8339 for 2 % (Ogata's curve for zeta = 1).
    let double = poles_from(PolePattern::Dominant { damping: 1.0, ratio: 5.0 }, 2, 1.0, 0.02).unwrap();
    let w = -double[0].re;
    assert!(((1.0 + w) * (-w).exp() - 0.02).abs() < 1e-15 && (w - 5.8339).abs() < 1e-4);
    let single = poles_from(PolePattern::Dominant { damping: 0.5, ratio: 5.0 }, 1, 1.0, 0.02).unwrap();
    assert!((single[0].re - 0.02_f64.ln()).abs() < 1e-15);
}

#[test]
fn specifications_out_of_range_are_errors() {
    // 16.3 % overshoot is a damping of 0.5.
    assert!((damping_from_overshoot((-std::f64::consts::PI / 3.0_f64.sqrt()).exp()).unwrap() - 0.5).abs() < 1e-15);
    assert!(damping_from_overshoot(0.0).is_err() && damping_from_overshoot(1.0).is_err());
    let pair = |damping, ratio| PolePattern::Dominant { damping, ratio };
    for (pattern, order, settling, band) in [
        (pair(0.0, 5.0), 2, 1.0, 0.02),
        (pair(1.1, 5.0), 2, 1.0, 0.02),
        (pair(0.5, 1.0), 2, 1.0, 0.02),
        (PolePattern::Bessel, 0, 1.0, 0.02),
        (PolePattern::Bessel, 21, 1.0, 0.02),
        (PolePattern::Bessel, 2, 0.0, 0.02),
        (PolePattern::Bessel, 2, f64::NAN, 0.02),
        (PolePattern::Bessel, 2, 1.0, 1.0),
    ] {
        let refused = poles_from(pattern, order, settling, band);
        assert!(matches!(refused, Err(LinalgError::InvalidSpecification { .. })), "{pattern:?} {order}");
    }
}
