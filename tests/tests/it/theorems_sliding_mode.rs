//! Sliding-mode observers: exact reaching times, the strict Lyapunov function of the super-twisting observer, the
//! implicit step and its chattering beside that of the explicit one. Statements and proofs: docs/sliding-mode.md.

use luenberger_design::sliding_mode::reaching_time;
use luenberger_design::{SuperTwistingDesign, sliding_mode_gains};
use luenberger_observers::SampledObserver;
use luenberger_observers::sliding_mode::{Discretisation, SlidingModeObserver};
use luenberger_plants::StateSpace;
use nalgebra::{DMatrix, DVector, Dyn};
use proptest::prelude::*;

type Chain = SlidingModeObserver<StateSpace, f64, Dyn, Dyn, Dyn>;

fn chain(n: usize) -> StateSpace {
    let a = DMatrix::from_fn(n, n, |i, j| if j == i + 1 { 1.0 } else { 0.0 });
    StateSpace::new(a, DMatrix::zeros(n, 0), DMatrix::from_fn(1, n, |_, j| if j == 0 { 1.0 } else { 0.0 })).unwrap()
}

fn observer(gains: &[f64], h: f64, rule: Discretisation) -> Chain {
    SlidingModeObserver::new(chain(gains.len()), DVector::from_column_slice(gains), h, rule).unwrap()
}

/// x after a period with a constant d in the last derivative, exactly.
fn moved(x: &DVector<f64>, d: f64, h: f64) -> DVector<f64> {
    let n = x.len();
    DVector::from_fn(n, |i, _| {
        let (mut sum, mut weight) = (x[i], 1.0);
        for (degree, j) in (i + 1..=n).enumerate() {
            weight *= h / (degree + 1) as f64;
            sum += weight * if j < n { x[j] } else { d };
        }
        sum
    })
}

/// A run: the errors before each sample, and the signs s of its corrections.
fn run(of: &Chain, e0: &DVector<f64>, steps: usize, d: impl Fn(usize) -> f64) -> (Vec<DVector<f64>>, Vec<f64>) {
    let (mut x, mut xhat) = (e0.clone(), DVector::zeros(e0.len()));
    let (mut errors, mut signs) = (Vec::new(), Vec::new());
    for k in 0..steps {
        let e = &x - &xhat;
        signs.push(of.resolved(e[0]).1);
        errors.push(e);
        of.step(0.0, &mut xhat, &DVector::zeros(0), &DVector::from_element(1, x[0]));
        x = moved(&x, d(k), of.period());
    }
    (errors, signs)
}

/// Seconds until all errors stay below a tolerance.
fn reached(errors: &[DVector<f64>], h: f64, tolerance: f64) -> f64 {
    errors.iter().rposition(|e| e.amax() > tolerance).map_or(0.0, |k| (k + 1) as f64 * h)
}

/// First order, by hand: `|e|/(k - d)`, 2/(1.5 - 0.5) = 2 and 2/(1.5 + 0.5) = 1.
#[test]
fn the_first_order_mode_reaches_in_its_exact_time() {
    for (d, exact) in [(0.5, 2.0), (-0.5, 1.0), (0.0, 4.0 / 3.0)] {
        assert!((reaching_time::first_order(2.0, 1.5, d) - exact).abs() < 1e-15);
        for h in [1e-2, 1e-3, 1e-4] {
            let (errors, _) =
                run(&observer(&[1.5], h, Discretisation::Implicit), &DVector::from_element(1, 2.0), 30_000, |_| d);
            let found = reached(&errors, h, 1.5 * h);
            assert!((found - exact).abs() <= 3.0 * h, "d = {d}, h = {h}: {found} for {exact}");
        }
    }
}

/// The geometric series of half turns. For k1 = 1.5, k2 = 1.1: w = sqrt(0.55 - 0.140625) = 0.639824, q = exp(-pi
/// 0.375/w) = 0.158614, T = 1.158614/(0.841386 1.1) = 1.251846, by hand.
#[test]
fn the_super_twisting_error_reaches_in_its_exact_time() {
    let exact = reaching_time::super_twisting(1.0, 1.5, 1.1);
    assert!((exact - 1.251_846).abs() < 1e-5, "{exact}");
    // No turn: e2 falls at the rate k2.
    assert!((reaching_time::super_twisting(2.0, 5.0, 1.0) - 2.0).abs() < 1e-15);
    let mut last = f64::INFINITY;
    for h in [1e-2, 1e-3, 1e-4] {
        let of = observer(&[1.5, 1.1], h, Discretisation::Implicit);
        let (errors, _) = run(&of, &DVector::from_vec(vec![0.0, 1.0]), (4.0 / h) as usize, |_| 0.0);
        let found = reached(&errors, h, 4.0 * h);
        assert!((found - exact).abs() < 20.0 * h, "h = {h}: {found} for {exact}");
        assert!((found - exact).abs() < last);
        last = (found - exact).abs() + h;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// The bound of the certificate is above the exact time without a disturbance, and above what simulations with the
    /// worst constant disturbances take.
    #[test]
    fn the_certified_time_is_an_upper_bound(
        bound in 0.1..10.0_f64, c1 in 2.1..4.0_f64, c2 in 1.1..4.0_f64, e2 in 0.1..3.0_f64, side in any::<bool>(),
    ) {
        let (k1, k2) = (c1 * bound.sqrt(), c2 * bound);
        let design = SuperTwistingDesign::new([k1, k2], bound).unwrap();
        let Some(design) = design else {
            // Next to the edge of what the inequality allows.
            prop_assert!(c1 < 2.0 * c2.sqrt() + 0.05, "k = ({c1}, {c2}) D");
            return Ok(());
        };
        prop_assert!(design.certificate.is_proved());
        let e2 = e2 * bound;
        prop_assert!(design.reaching_time(0.0, e2) >= reaching_time::super_twisting(e2, k1, k2));
        let h = 1e-3;
        let d = if side { bound } else { -bound };
        let proved = design.reaching_time(0.0, e2);
        let steps = ((proved / h) as usize + 200).min(60_000);
        let of = observer(&[k1, k2], h, Discretisation::Implicit);
        let (errors, _) = run(&of, &DVector::from_vec(vec![0.0, e2]), steps, |_| d);
        // The prediction before a sample lacks the disturbance over a period.
        let found = reached(&errors, h, 4.0 * h * bound);
        prop_assert!(found <= proved + 20.0 * h, "{found} s, {proved} s are proved");
    }

    /// The bound of the reaching time is when V of its differential inequality `V' = -(alpha/c) V^(1/2)` is 0, which is
    /// integrated here.
    #[test]
    fn the_certified_time_is_that_of_its_differential_inequality(
        bound in 0.1..10.0_f64, e1 in -10.0..10.0_f64, e2 in -10.0..10.0_f64,
    ) {
        let design = SuperTwistingDesign::new([2.1 * bound.sqrt(), 1.1 * bound], bound).unwrap().unwrap();
        let (e1, e2) = (e1 * bound, e2 * bound);
        let z = DVector::from_vec(vec![e1.abs().sqrt() * e1.signum(), e2]);
        let mut v = z.dot(&(&design.p * &z));
        let proved = design.reaching_time(e1, e2);
        let steps = 20_000;
        let h = 1.1 * proved / f64::from(steps);
        let mut time = 0.0;
        while v > 0.0 && time < 2.0 * proved {
            v -= h * design.alpha / design.c * v.sqrt();
            time += h;
        }
        prop_assert!((time / proved - 1.0).abs() < 1e-2, "{time} s, {proved} s are proved");
    }

    /// V falls where the inequality says so: at random errors, the worst disturbance, with the slope written out here.
    #[test]
    fn the_lyapunov_function_falls_at_its_rate(
        bound in 0.1..10.0_f64, c1 in 2.3..4.0_f64, c2 in 1.1..1.3_f64, e1 in 1e-6..10.0_f64, e2 in -10.0..10.0_f64,
        side in any::<bool>(), push in -1.0..1.0_f64,
    ) {
        let (k1, k2) = (c1 * bound.sqrt(), c2 * bound);
        let design = SuperTwistingDesign::new([k1, k2], bound).unwrap().unwrap();
        let e1 = if side { e1 } else { -e1 } * bound;
        let e2 = e2 * bound;
        for f in [bound, -bound, push * bound] {
            let z = DVector::from_vec(vec![e1.abs().sqrt() * e1.signum(), e2]);
            let slope1 = e2 - k1 * e1.abs().sqrt() * e1.signum();
            let slope2 = f - k2 * e1.signum();
            let dz = DVector::from_vec(vec![slope1 / (2.0 * e1.abs().sqrt()), slope2]);
            let v = z.dot(&(&design.p * &z));
            let rate = 2.0 * dz.dot(&(&design.p * &z));
            prop_assert!(rate <= -design.alpha / design.c * v.sqrt() * (1.0 - 1e-9), "V' = {rate}, V = {v}");
        }
    }

    /// Once two innovations in a row are within the layer, they stay there for every disturbance up to k2 and the
    /// estimate after each correction is exact in x1 and within h D/2 in x2: to rounding.
    #[test]
    fn the_sliding_set_is_invariant_in_discrete_time(
        h in 1e-3..0.1_f64, bound in 0.1..10.0_f64, ratio in 1.0..3.0_f64, first in -1.0..1.0_f64, seed in any::<u64>(),
    ) {
        let gains = [2.1 * bound.sqrt(), ratio * bound];
        let of = observer(&gains, h, Discretisation::Implicit);
        // After a correction with sigma = 0 at two samples, e = (0, at most h D/2).
        let (mut x, mut xhat) = (DVector::from_vec(vec![0.0, first * h * bound / 2.0]), DVector::zeros(2));
        for k in 0..200_u64 {
            let mixed = (seed ^ k.wrapping_mul(0x9e37_79b9_7f4a_7c15)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11;
            let d = bound * (mixed as f64 / 2f64.powi(52) - 1.0).clamp(-1.0, 1.0).signum();
            // d changes within the period as well.
            x = moved(&moved(&x, d, 0.3 * h), -d, 0.7 * h);
            xhat = moved(&xhat, 0.0, h);
            let z = x[0] - xhat[0];
            prop_assert!(z.abs() <= h * h * bound * (1.0 + 1e-9), "innovation {z}");
            let (r, s) = of.resolved(z);
            prop_assert!(r == 0.0 && s.abs() <= 1.0);
            // The correction alone: x1 exact, x2 by h k2 s.
            xhat[0] += h * h * gains[1] * s;
            xhat[1] += h * gains[1] * s;
            prop_assert!((x[0] - xhat[0]).abs() <= 1e-12 * (1.0 + x[0].abs()));
            prop_assert!((x[1] - xhat[1]).abs() <= h * bound / 2.0 * (1.0 + 1e-6) + 1e-12);
        }
    }

    /// The implicit equation is solved: `sigma + s (h k_1 r^(n-1) + .. + h^n k_n) = z` for orders 1 to 6, any period.
    #[test]
    fn the_implicit_equation_is_solved(
        n in 1..=5_usize, h in 1e-5..1.0_f64, bound in 1e-3..1e3_f64, size in -12.0..4.0_f64, side in any::<bool>(),
    ) {
        let gains = sliding_mode_gains(n, bound).unwrap();
        let of = observer(&gains, h, Discretisation::Implicit);
        let z = 10f64.powf(size) * if side { 1.0 } else { -1.0 };
        let (r, s) = of.resolved(z);
        let order = i32::try_from(n).unwrap();
        let sum: f64 = (0..order).zip(&gains).map(|(j, gain)| h.powi(j + 1) * gain * r.powi(order - 1 - j)).sum();
        let sigma = s * r.powi(order);
        prop_assert!(s.abs() <= 1.0 && r >= 0.0);
        if r > 0.0 {
            prop_assert!((sigma + s * sum - z).abs() <= 1e-12 * z.abs(), "{} for {z}", sigma + s * sum);
        } else {
            prop_assert!((s * of.boundary_layer() - z).abs() <= 1e-12 * z.abs());
        }
    }
}

/// Total variation of the correction of the last state per second, and the largest error of each state, in the second
/// half of a run against a constant disturbance.
fn chattering(rule: Discretisation, h: f64) -> (f64, [f64; 2]) {
    let of = observer(&[2.1, 1.1], h, rule);
    let steps = (20.0 / h) as usize;
    let (errors, signs) = run(&of, &DVector::from_vec(vec![0.3, 0.5]), steps, |_| 0.6);
    let late = steps / 2;
    let variation: f64 = signs[late..].windows(2).map(|pair| 1.1 * (pair[1] - pair[0]).abs()).sum();
    let largest = |i: usize| errors[late..].iter().map(|e| e[i].abs()).fold(0.0, f64::max);
    (variation / 10.0, [largest(0), largest(1)])
}

/// Chattering, measured: the correction of the explicit method switches at a rate of 1/h, that of the implicit one is
/// constant; the error of the velocity of both is proportional to h, and that of the implicit one is smaller.
#[test]
fn the_implicit_step_does_not_chatter() {
    for h in [0.05, 0.02, 0.01, 0.005] {
        let (switching, [position, velocity]) = chattering(Discretisation::Explicit, h);
        let (calm, [exact, less]) = chattering(Discretisation::Implicit, h);
        println!(
            "{h}: explicit {switching:.3} {position:.3e} {velocity:.3e}; implicit {calm:.3e} {exact:.3e} {less:.3e}"
        );
        // Rounding of x1, which grows, relative to the layer.
        assert!(calm < 1e-5, "h = {h}: {calm}");
        assert!(switching > 0.1 / h, "h = {h}: {switching}");
        // Before a sample the prediction lacks 0.6 h and what is left of it: exactly h^2 0.6 and 0.9 h.
        assert!((exact - 0.6 * h * h).abs() < 1e-9 && (less - 0.9 * h).abs() < 1e-9, "h = {h}: {exact} {less}");
        assert!(position > exact && velocity > less, "h = {h}: {position} {velocity}");
    }
}

/// Levant's differentiator of orders 1 to 4 of a polynomial whose last derivative is constant and unknown: all
/// derivatives after the reaching phase, up to powers of h with the constants of the deadbeat observer, and a sign that
/// rests. For n = 3 and d = 0.7 these are 0.7 (1, 11/6, 2), from a simulation in Python of the formulas of the head of
/// the observer's file.
#[test]
fn derivatives_are_exact_up_to_powers_of_the_period() {
    let constants: [&[f64]; 4] =
        [&[0.7, 1.05], &[0.7, 1.283, 1.4], &[0.7, 1.458, 2.042, 1.75], &[0.7, 1.598, 2.625, 2.975, 2.1]];
    for n in 2..=5_usize {
        for (h, size) in [(0.02, 1.0), (0.02, 0.1), (0.005, 0.1)] {
            let of = observer(&sliding_mode_gains(n, 1.0).unwrap(), h, Discretisation::Implicit);
            let start = DVector::from_fn(n, |i, _| size / (i + 1) as f64);
            let steps = (30.0 / h) as usize;
            let (errors, signs) = run(&of, &start, steps, |_| 0.7);
            let late = steps * 3 / 4;
            for i in 0..n {
                let largest = errors[late..].iter().map(|e| e[i].abs()).fold(0.0, f64::max);
                let expected = constants[n - 2][i] * h.powi(i32::try_from(n - i).unwrap());
                // The trajectory is long: rounding of x1 is divided by powers of the period.
                let rounding = 1e-9 / h.powi(i32::try_from(i).unwrap());
                assert!(
                    (largest - expected).abs() < 2e-3 * expected + rounding,
                    "n = {n}, h = {h}, {i}: {largest} {expected}"
                );
            }
            if n <= 3 {
                let variation: f64 = signs[late..].windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
                assert!(variation < 0.05, "n = {n}, h = {h}: {variation}");
            }
        }
    }
}
