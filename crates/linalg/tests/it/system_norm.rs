//! H2 and H-infinity norms: closed forms, every frequency, what has none, and shapes that do not fit.

use luenberger_linalg::internals::product;
use luenberger_linalg::{
    HInfinityNorm, LinalgError, discrete_h_infinity_norm, discrete_h2_norm, eigenvalues, h_infinity_norm, h2_norm,
};
use nalgebra::{Complex, DMatrix, dmatrix};
use proptest::prelude::*;

type H2 = fn(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>) -> Result<f64, LinalgError>;
type HInfinity = fn(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>) -> Result<HInfinityNorm, LinalgError>;

#[test]
fn an_unstable_system_has_no_h2_norm() {
    let one = dmatrix![1.0];
    for (a, refused) in
        [(0.5, h2_norm(&dmatrix![0.5], &one, &one)), (2.0, discrete_h2_norm(&dmatrix![2.0], &one, &one))]
    {
        let error = refused.unwrap_err();
        assert!(
            matches!(error, LinalgError::NotStable { eigenvalue, .. } if eigenvalue == Complex::from(a)),
            "{error}"
        );
    }
}

#[test]
fn shapes_that_do_not_fit_are_named() {
    let (a, b, c, d) = (dmatrix![0.5, 0.0; 0.0, 0.5], dmatrix![1.0; 1.0], dmatrix![1.0, 1.0], dmatrix![0.0]);
    let short = dmatrix![1.0];
    for norm in [(|a, b, c| h2_norm(a, b, c)) as H2, |a, b, c| discrete_h2_norm(a, b, c)] {
        assert!(matches!(norm(&b, &b, &c), Err(LinalgError::NotSquare { what: "A", .. })));
        assert!(matches!(norm(&a, &short, &c), Err(LinalgError::DimensionMismatch { what: "B", .. })));
        assert!(matches!(norm(&a, &b, &short), Err(LinalgError::DimensionMismatch { what: "C", .. })));
    }
    for norm in
        [(|a, b, c, d| h_infinity_norm(a, b, c, d)) as HInfinity, |a, b, c, d| discrete_h_infinity_norm(a, b, c, d)]
    {
        assert!(matches!(norm(&c, &b, &c, &d), Err(LinalgError::NotSquare { what: "A", .. })));
        assert!(matches!(norm(&a, &short, &c, &d), Err(LinalgError::DimensionMismatch { what: "B", .. })));
        assert!(matches!(norm(&a, &b, &short, &d), Err(LinalgError::DimensionMismatch { what: "C", .. })));
        assert!(matches!(norm(&a, &b, &c, &c), Err(LinalgError::DimensionMismatch { what: "D", .. })));
    }
}

/// The resonance `k/(s^2 + 2 z s + 1)` has the peak `k/(2 z sqrt(1 - z^2))` whatever the unit of the output is, and in
/// whatever units of the states.
#[test]
fn the_peak_of_a_resonance_in_any_unit() {
    for z in [0.6, 0.3, 1e-2, 1e-4, 1e-7] {
        for (k, unit) in [(1.0, 1.0), (1e4, 1.0), (1e8, 1e-9), (1e-12, 1e6), (1e5, 1e12)] {
            let (a, b) = (dmatrix![0.0, unit; -1.0 / unit, -2.0 * z], dmatrix![0.0; 1.0 / unit]);
            let found = h_infinity_norm(&a, &b, &dmatrix![k, 0.0], &dmatrix![0.0]).unwrap();
            let exact = k / (2.0 * z * f64::sqrt(1.0 - z * z));
            assert!((found.norm - exact).abs() <= 1e-9 * exact, "{z} {k}: {found:?}, {exact}");
            let peak = f64::sqrt(1.0 - 2.0 * z * z);
            assert!((found.frequency - peak).abs() <= 1e-4 * peak, "{z} {k}: {found:?}, {peak}");
        }
    }
}

/// `1/(z - p)` has the norm `1/(1 - |p|)`; `1/((z - p)(z + p))` has `1/(1 - p^2)`, at 0 and at pi. The numbers are
/// exact in binary, so that nothing of `1 - |p|` is lost.
#[test]
fn discrete_poles_at_the_edge() {
    let one = dmatrix![1.0];
    for power in [-4, -20, -34, -45] {
        let gap = 2f64.powi(power);
        for p in [1.0 - gap, gap - 1.0] {
            let found = discrete_h_infinity_norm(&dmatrix![p], &one, &one, &dmatrix![0.0]).unwrap();
            assert!((found.norm * gap - 1.0).abs() <= 1e-12, "{p}: {found:?}");
            assert!((found.frequency - if p > 0.0 { 0.0 } else { std::f64::consts::PI }).abs() <= gap);
        }
        let p = 1.0 - gap;
        let (a, b, c) = (dmatrix![p, 1.0; 0.0, -p], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]);
        let found = discrete_h_infinity_norm(&a, &b, &c, &dmatrix![0.0]).unwrap();
        assert!((found.norm * gap * (2.0 - gap) - 1.0).abs() <= 1e-9, "{p}: {found:?}");
    }
    let at_the_edge = discrete_h_infinity_norm(&dmatrix![-1.0], &one, &one, &dmatrix![0.0]).unwrap();
    assert!(at_the_edge.norm.is_infinite());
}

/// The largest singular value at `s`, by a solution of its own in the units given, refined with a defect of twice the
/// precision: next to a pole the solution would have an error of eps over the distance. (The pencil itself is rounded.)
fn response([a, b, c, d]: [&DMatrix<f64>; 4], s: Complex<f64>) -> f64 {
    let (n, m) = b.shape();
    // `(s - A) x = b` for real and imaginary parts.
    let mut pencil = DMatrix::zeros(2 * n, 2 * n);
    for corner in [0, n] {
        pencil.view_mut((corner, corner), (n, n)).copy_from(&(DMatrix::identity(n, n) * s.re - a));
    }
    pencil.view_mut((n, 0), (n, n)).fill_diagonal(s.im);
    pencil.view_mut((0, n), (n, n)).fill_diagonal(-s.im);
    let right = b.clone().resize_vertically(2 * n, 0.0);
    let factors = pencil.clone().lu();
    let mut x = factors.solve(&right).unwrap();
    for _ in 0..3 {
        let (high, low) = product(&pencil, &x);
        x += factors.solve(&(&right - high - low)).unwrap();
    }
    let x = DMatrix::from_fn(n, m, |i, j| Complex::new(x[(i, j)], x[(n + i, j)]));
    (c.map(Complex::from) * x + d.map(Complex::from)).svd(false, false).singular_values.max()
}

proptest! {
    /// The value is attained, and none of a grid of frequencies, dense about the poles, exceeds it by 1e-9.
    #[test]
    fn no_frequency_exceeds_the_norm(
        n in 1usize..7, m in 1usize..3, p in 1usize..3, entries in proptest::collection::vec(-1.0..1.0, 100),
        damping in -6.0..0.0f64, discrete: bool, fed: bool,
    ) {
        let mut next = entries.into_iter();
        let mut matrix = |rows, cols| DMatrix::from_fn(rows, cols, |_, _| next.next().unwrap());
        let (mut a, b, c) = (matrix(n, n), matrix(n, m), matrix(p, n));
        let d = if fed { matrix(p, m) } else { DMatrix::zeros(p, m) };
        let poles = eigenvalues(&a).unwrap();
        let damping = 10f64.powf(damping);
        if discrete {
            let radius = poles.iter().map(|l| l.norm()).fold(1e-3, f64::max);
            a *= (1.0 - damping) / radius;
        } else {
            let abscissa = poles.iter().map(|l| l.re).fold(f64::MIN, f64::max);
            a -= DMatrix::identity(n, n) * (abscissa + damping);
        }
        let found = if discrete { discrete_h_infinity_norm(&a, &b, &c, &d) } else { h_infinity_norm(&a, &b, &c, &d) };
        let found = found.unwrap();
        let point = |w: f64| if discrete { Complex::new(0.0, w).exp() } else { Complex::new(0.0, w) };
        let mut tried = vec![0.0, std::f64::consts::PI];
        for pole in eigenvalues(&a).unwrap() {
            let (w, width) = if discrete { (pole.arg().abs(), 1.0 - pole.norm()) } else { (pole.im.abs(), -pole.re) };
            tried.extend((-200..=200).map(|k| w + width * f64::from(k) / 50.0));
        }
        for w in tried {
            let value = response([&a, &b, &c, &d], point(w));
            prop_assert!(value <= found.norm * (1.0 + 2e-9), "{value} at {w}, {found:?}");
        }
        if found.frequency.is_finite() {
            // The frequency is rounded, and the response in units of the test's own has errors of eps over the
            // distance.
            let value = response([&a, &b, &c, &d], point(found.frequency));
            prop_assert!((value - found.norm).abs() <= 1e-6 * found.norm, "{value}, {found:?}");
        }
    }
}
