//! The guaranteed error bound of a KKL observer, `docs/theory-kkl.md`: no simulated trajectory exceeds it.
//!
//! Plants and observers are integrated here with equations of their own, by Runge-Kutta's method of order 4; the
//! certificate has them as expressions.

use luenberger_plants::{CukConverter, ExponentialCascade, Plant, ReverseDuffing, VanDerPol};
use luenberger_proof::certificate::{CertificateFile, KklErrorBound};
use luenberger_tests::kkl_maps::{bound, converter, duffing, exponential_cascade, region, van_der_pol};
use nalgebra::{DMatrix, SVector, Vector1, Vector2, Vector4, dmatrix};
use proptest::prelude::*;

/// A plant with its observer: how both move, `xi - phi(x)`, and `z - zhat`.
struct Pair<const N: usize, F, E, Z> {
    slope: F,
    error: E,
    missed: Z,
    first: SVector<f64, N>,
}

/// What a run showed.
#[derive(Debug, Default)]
struct Seen {
    /// The largest share of the bound of each estimate that was used.
    of_estimates: Vec<f64>,
    /// Samples in the box.
    samples: usize,
}

/// Integration errors: of order 4, at steps that are a hundredth or less of every time constant.
const INTEGRATION: f64 = 1e-7;

/// Compares a run with the theorem as long as the plant, the first `states` entries, and u remain in the box.
fn run<const N: usize, F, E, Z>(
    pair: &Pair<N, F, E, Z>,
    theorem: &KklErrorBound,
    input: impl Fn(f64, &SVector<f64, N>) -> f64,
    (states, step, steps): (usize, f64, usize),
) -> Result<Seen, TestCaseError>
where
    F: Fn(f64, &SVector<f64, N>) -> SVector<f64, N>,
    E: Fn(&SVector<f64, N>) -> Vector2<f64>,
    Z: Fn(f64, &SVector<f64, N>) -> Vec<f64>,
{
    let p = DMatrix::from_fn(2, 2, |i, j| theorem.p[(i, j)]);
    let norm = |e: Vector2<f64>| (e.transpose() * &p * e)[0].sqrt();
    let (mut s, claims) = (pair.first, &theorem.claims);
    let first = norm((pair.error)(&s));
    let mut seen = Seen { of_estimates: vec![0.0; claims.defect.len()], ..Seen::default() };
    for k in 0..steps {
        let t = k as f64 * step;
        let u = input(t, &s);
        let inside = (0..states).all(|i| theorem.region.x[i].contains(s[i]));
        if !inside || theorem.region.u.first().is_some_and(|range| !range.contains(u)) {
            break;
        }
        let v = norm((pair.error)(&s));
        let decay = (-theorem.rate * t).exp();
        let allowed = decay * first + (1.0 - decay) * claims.limit;
        let room = INTEGRATION * (1.0 + first);
        prop_assert!(v <= allowed + room, "V = {v} at t = {t}, and {allowed} is proved");
        if v <= claims.start {
            for (i, missed) in (pair.missed)(u, &s).into_iter().enumerate() {
                let allowed = claims.lipschitz[i] * v + claims.defect[i];
                let room = INTEGRATION * (1.0 + missed.abs()) * (1.0 + claims.lipschitz[i]);
                prop_assert!(missed.abs() <= allowed + room, "entry {i}: {missed} at t = {t}, and {allowed} is proved");
                seen.of_estimates[i] = seen.of_estimates[i].max(missed.abs() / (allowed + room));
            }
        }
        seen.samples += 1;
        let slope = |s: &SVector<f64, N>| (pair.slope)(input(t, s), s);
        let k1 = slope(&s);
        let k2 = slope(&(s + k1 * (step / 2.0)));
        let k3 = slope(&(s + k2 * (step / 2.0)));
        let k4 = slope(&(s + k3 * step));
        s += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (step / 6.0);
    }
    Ok(seen)
}

fn proved(bound: Option<KklErrorBound>) -> KklErrorBound {
    let bound = bound.expect("bounds");
    CertificateFile::prove("a KKL observer", bound.clone()).expect("proved");
    bound
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Van der Pol's oscillator with a B that is wrong by a term: the residual stays, and so does an error, within the
    /// bound. P couples the entries.
    #[test]
    fn the_bound_holds_for_van_der_pol(
        mu in 0.3..2.0f64, slow in 0.6..1.2f64, fast in 1.4..3.0f64, wrong in 0.0..0.05f64, coupling in -0.2..0.2f64,
        x in prop::array::uniform2(-1.5..1.5f64), e in prop::array::uniform2(prop_oneof![-1.0..-0.1f64, 0.1..1.0f64]),
    ) {
        let lambda = [-fast, -slow];
        let box_ = region(&[(-2.5, 2.5), (-5.0, 5.0)], &[]);
        let p = dmatrix![1.0, coupling; coupling, 0.8];
        let theorem = proved(bound(&van_der_pol(mu, lambda, wrong), &box_, &p, 0.8 * slow, 2.0));
        let m = move |y: f64| mu * (y - y * y * y / 3.0);
        let phi = move |x: [f64; 2]| Vector2::from(lambda.map(|l| l * x[0] + x[1] - m(x[0])));
        let plant = VanDerPol { mu };
        let xi = phi(x) + Vector2::from(e);
        let pair = Pair {
            first: Vector4::new(x[0], x[1], xi[0], xi[1]),
            slope: |_: f64, s: &Vector4<f64>| {
                let rate = plant.derivative(0.0, &Vector2::new(s[0], s[1]), &SVector::zeros());
                let b = lambda.map(|l| -s[0] - l * (l * s[0] - m(s[0])));
                Vector4::new(rate[0], rate[1], lambda[0] * s[2] + b[0] + wrong * s[0].sin(), lambda[1] * s[3] + b[1])
            },
            error: |s: &Vector4<f64>| Vector2::new(s[2], s[3]) - phi([s[0], s[1]]),
            missed: |_: f64, s: &Vector4<f64>| {
                let estimate = s[2] - lambda[0] * s[0] + m(s[0]);
                vec![s[1] - estimate, s[0] - (s[2] - s[3]) / (lambda[0] - lambda[1])]
            },
        };
        let seen = run(&pair, &theorem, |_, _| 0.0, (2, 2e-3, 5000))?;
        prop_assert!(seen.samples > 100);
        // The bounds are not ten times what happens.
        prop_assert!(seen.of_estimates.iter().all(|share| *share > 0.1), "{seen:?}");
    }

    /// Proposition 6 with the KKLO of a varying Lambda, from random states and with random inputs: the logarithm of the
    /// estimate included.
    #[test]
    fn the_bound_holds_for_the_exponential_cascade(
        x in (-0.8..1.2f64, -1.0..2.0f64, -0.8..0.8f64), e in prop::array::uniform2(-0.15..0.15f64),
        u in -1.0..1.0f64, frequency in 0.5..5.0f64,
    ) {
        let box_ = region(&[(-1.0, 1.5), (-2.0, 3.0), (-1.0, 1.0)], &[(-1.0, 1.0)]);
        let theorem = proved(bound(&exponential_cascade(3.0), &box_, &DMatrix::identity(2, 2), 0.9, 0.3));
        prop_assert_eq!(theorem.claims.limit, 0.0);
        let k = |y: f64| 3.0 * y + y * y * y;
        let phi = |s: &SVector<f64, 5>| Vector2::new(s[1], s[2].exp() - k(s[0]));
        let mut first = SVector::<f64, 5>::from([x.0, x.1, x.2, 0.0, 0.0]);
        let xi = phi(&first) + Vector2::from(e);
        (first[3], first[4]) = (xi[0], xi[1]);
        let pair = Pair {
            first,
            slope: |u: f64, s: &SVector<f64, 5>| {
                let y = s[0];
                let rate = ExponentialCascade.derivative(0.0, &s.fixed_rows::<3>(0).into_owned(), &Vector1::new(u));
                let a = 1.0 / (y * y + 1.0) + y * u - 3.0 * y * y - 3.0;
                let b = a * k(y) + (3.0 + 3.0 * y * y) * y * y * y;
                SVector::from([rate[0], rate[1], rate[2], -s[3] + y * y + y.sin(), a * s[4] + b])
            },
            error: |s: &SVector<f64, 5>| Vector2::new(s[3], s[4]) - phi(s),
            missed: |_: f64, s: &SVector<f64, 5>| vec![s[1] - s[3], s[2] - (s[4] + k(s[0])).ln()],
        };
        run(&pair, &theorem, |t, _| u * (frequency * t).cos(), (3, 1e-3, 4000))?;
    }

    /// The converter with the KKLO of Table I, switched at random between two duty cycles.
    #[test]
    fn the_bound_holds_for_the_converter(
        vd in 10.0..25.0f64, share in prop::array::uniform4(-0.1..0.1f64), e in (-30.0..30.0f64, -0.02..0.02f64),
        duty in prop::array::uniform2(0.3..0.65f64), period in 0.01..0.03f64,
    ) {
        let plant = CukConverter::default();
        let box_ = region(&[(-3.0, 6.0), (0.0, 60.0), (-5.0, 2.0), (-60.0, 5.0)], &[(0.1, 0.8)]);
        let scales = dmatrix![1.0, 0.0; 0.0, 1e6];
        let theorem = proved(bound(&converter(&plant), &box_, &scales, 19.0, 60.0));
        let x = plant.equilibrium(vd).zip_map(&Vector4::from(share), |x, share| x * (1.0 + share));
        let phi = |s: &SVector<f64, 6>| Vector2::new(s[3], plant.l1 * s[0] - plant.c2 * s[1]);
        let mut first = SVector::<f64, 6>::from([x[0], x[1], x[2], x[3], 0.0, 0.0]);
        let xi = phi(&first) + Vector2::new(e.0, e.1);
        (first[4], first[5]) = (xi[0], xi[1]);
        let pair = Pair {
            first,
            slope: |u: f64, s: &SVector<f64, 6>| {
                let rate = plant.derivative(0.0, &s.fixed_rows::<4>(0).into_owned(), &Vector1::new(u));
                let (w, y) = (1.0 - u, [s[1], s[2]]);
                let xi1 = -(plant.g / plant.c4) * s[4] + y[1] / plant.c4;
                let xi2 = -(w / plant.l1) * s[5] - (1.0 + plant.c2 / plant.l1) * w * y[0] + plant.e - u * y[1];
                SVector::from([rate[0], rate[1], rate[2], rate[3], xi1, xi2])
            },
            error: |s: &SVector<f64, 6>| Vector2::new(s[4], s[5]) - phi(s),
            missed: |_: f64, s: &SVector<f64, 6>| {
                vec![s[0] - (s[5] + plant.c2 * s[1]) / plant.l1, s[3] - s[4]]
            },
        };
        let duty_at = |t: f64, _: &SVector<f64, 6>| duty[usize::from((t / period).fract() > 0.5)];
        run(&pair, &theorem, duty_at, (4, 5e-6, 8000))?;
    }

    /// The reverse Duffing oscillator with a truncated phi: the error does not vanish, and `x2^3` is known within the
    /// eventual bound.
    #[test]
    fn the_bound_holds_for_duffing(angle in 0.0..6.3f64, e in prop::array::uniform2(-0.02..0.02f64)) {
        let poles = [-10.0, -15.0];
        let box_ = region(&[(-0.5, 0.5), (-0.8, 0.8)], &[]);
        let theorem = proved(bound(&duffing(poles), &box_, &DMatrix::identity(2, 2), 9.0, 1.0));
        let phi = |s: &Vector4<f64>| {
            Vector2::from(poles.map(|d| -(s[0] / d + s[1].powi(3) / (d * d) - 3.0 * s[0] * s[1] * s[1] / (d * d * d))))
        };
        let mut first = Vector4::new(0.3 * angle.cos(), 0.5 * angle.sin(), 0.0, 0.0);
        let xi = phi(&first) + Vector2::from(e);
        (first[2], first[3]) = (xi[0], xi[1]);
        let pair = Pair {
            first,
            slope: |_: f64, s: &Vector4<f64>| {
                let rate = ReverseDuffing.derivative(0.0, &Vector2::new(s[0], s[1]), &SVector::zeros());
                Vector4::new(rate[0], rate[1], poles[0] * s[2] + s[0], poles[1] * s[3] + s[0])
            },
            error: |s: &Vector4<f64>| Vector2::new(s[2], s[3]) - phi(s),
            missed: |_: f64, s: &Vector4<f64>| {
                let part = |d: f64, xi: f64| d * d * xi + d * s[0];
                vec![s[1].powi(3) - (2.0 * part(poles[0], s[2]) - 3.0 * part(poles[1], s[3]))]
            },
        };
        let seen = run(&pair, &theorem, |_, _| 0.0, (2, 1e-3, 10_000))?;
        // The oscillator never leaves: 10 s are seen.
        prop_assert_eq!(seen.samples, 10_000);
    }
}
