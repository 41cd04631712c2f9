//! Frequency responses against scipy, at poles and ends, in other units; margins by hand, and as a property.

use luenberger_linalg::{
    FrequencyResponse, LinalgError, Realization, StabilityMargins, discrete_stability_margins, eigenvalues,
    stability_margins,
};
use nalgebra::{Complex, DMatrix, dmatrix};
use proptest::prelude::*;
use std::f64::consts::PI;

/// A frequency, the entries of the response by rows, its singular values.
type Expected = (f64, [(f64, f64); 4], [f64; 2]);

fn plant(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>, d: &DMatrix<f64>) -> Realization {
    Realization::new(a, b, c, d).unwrap()
}

/// `num/(s^n + ..)` in controllable form: coefficients from the lowest power on, the leading one of the denominator
/// left out.
fn transfer(numerator: &[f64], denominator: &[f64]) -> Realization {
    let n = denominator.len();
    let a = DMatrix::from_fn(n, n, |i, j| match i + 1 {
        last if last == n => -denominator[j],
        next => f64::from(u8::from(j == next)),
    });
    let b = DMatrix::from_fn(n, 1, |i, _| f64::from(u8::from(i + 1 == n)));
    let c = DMatrix::from_fn(1, n, |_, j| numerator.get(j).copied().unwrap_or(0.0));
    plant(&a, &b, &c, &dmatrix![0.0])
}

fn near(found: f64, expected: f64, relative: f64) -> bool {
    (found - expected).abs() <= relative * expected.abs()
}

/// scipy 1.17: `signal.freqresp` and `signal.dfreqresp` of each channel of `ss2tf`, compared there with
/// `numpy.linalg.solve(z I - A, B)`; singular values by `numpy.linalg.svd`.
#[test]
fn responses_of_scipy() {
    let a = dmatrix![-0.5, 2.0, 0.0, 1.0; -2.0, -0.5, 1.0, 0.0; 0.0, 0.5, -3.0, 1.0; 0.25, 0.0, 0.0, -1.0];
    let b = dmatrix![1.0, 0.0; 0.0, 1.0; 2.0, -1.0; 0.0, 3.0];
    let (c, d) = (dmatrix![1.0, 0.0, 0.0, 1.0; 0.0, 1.0, -1.0, 0.0], dmatrix![0.0, 0.5; 0.0, 0.0]);
    let continuous = FrequencyResponse::continuous(&plant(&a, &b, &c, &d)).unwrap();
    let a = dmatrix![0.8, 0.3, 0.0; -0.3, 0.8, 0.1; 0.0, 0.05, -0.9];
    let discrete = plant(&a, &b.rows(0, 3).into_owned(), &c.columns(0, 3).into_owned(), &d);
    let discrete = FrequencyResponse::discrete(&discrete).unwrap();
    let rows: [(&FrequencyResponse, Expected); 6] = [
        (
            &continuous,
            (
                0.3,
                [
                    (0.5344072965096113, -0.008163730750704187),
                    (4.614001425144337, -1.0199704676469925),
                    (-1.0650056203751699, 0.13928177151487375),
                    (-1.6484317850473196, 0.8564095332598372),
                ],
                [5.1563999710976995, 0.794321768020857],
            ),
        ),
        (
            &continuous,
            (
                2.0,
                [
                    (0.6869514335868963, -0.9110590988882344),
                    (0.8323581041544837, -3.619660620245751),
                    (-0.03496196606202706, 0.885166764189584),
                    (2.2156231714452805, 0.40696313633705083),
                ],
                [4.532817827480305, 0.6400031934605266],
            ),
        ),
        (
            &continuous,
            (
                7.0,
                [
                    (0.001644974094243837, -0.14474671630251265),
                    (0.45673979853510427, -0.4408675896741067),
                    (-0.09508604223484406, 0.2293733068614246),
                    (0.13780068574369445, -0.24069350041003343),
                ],
                [0.6984668135019586, 0.27322108796173533],
            ),
        ),
        (
            &discrete,
            (
                0.3,
                [
                    (3.48670057139446, -1.0172305361408145),
                    (1.355977528669219, -2.8732429403514033),
                    (-1.5755705476949968, 2.996747928007055),
                    (3.715863866708783, -0.6976180664557544),
                ],
                [6.572639614501681, 2.4173711601601333],
            ),
        ),
        (
            &discrete,
            (
                2.0,
                [
                    (-0.5108289786066887, -0.3661639602582377),
                    (0.5283441285628885, 0.11956627475649609),
                    (-1.0585863576689558, 1.6451032869177937),
                    (0.006729880175108414, -1.2672215024891686),
                ],
                [2.4710587689865102, 0.12328824991002718],
            ),
        ),
        (
            &discrete,
            (
                3.1,
                [
                    (-0.6945313928956609, -0.08667735423397811),
                    (0.6692700979842687, 0.04263353321880033),
                    (18.285874276914974, 7.952946338592352),
                    (-9.99532975559804, -4.113460971119288),
                ],
                [22.700739781082195, 0.2564603536473162],
            ),
        ),
    ];
    for (response, (w, entries, singular)) in rows {
        let at = response.at(w);
        for (k, (re, im)) in entries.into_iter().enumerate() {
            let error = (at[(k / 2, k % 2)] - Complex::new(re, im)).norm();
            assert!(error <= 1e-13 * singular[0], "{w}: {error:e}");
        }
        let found = response.singular_values(w);
        assert!(near(found[0], singular[0], 1e-13) && near(found[1], singular[1], 1e-12), "{w}: {found}");
    }
}

/// `1/s` is infinite at 0 and zero at infinity; `1/(z - 1)` is -1/2 at pi. A single input, states of 1e12 times the
/// size and a clock in picoseconds change no digit.
#[test]
fn at_the_ends_and_in_other_units() {
    let one = dmatrix![1.0];
    let integrator = plant(&dmatrix![0.0], &one, &one, &dmatrix![0.25]);
    let response = FrequencyResponse::continuous(&integrator).unwrap();
    assert!(response.singular_values(0.0)[0].is_infinite());
    assert_eq!(response.at(f64::INFINITY)[(0, 0)], Complex::from(0.25));
    let sum = plant(&one, &one, &one, &dmatrix![0.0]);
    let response = FrequencyResponse::discrete(&sum).unwrap();
    assert!((response.at(PI)[(0, 0)] + 0.5).norm() < 1e-15);
    assert!(!response.at(0.0)[(0, 0)].re.is_finite());

    let resonance = |time: f64, state: f64| {
        let a = dmatrix![0.0, time / state; -time * state, -0.2 * time];
        plant(&a, &dmatrix![0.0; state * time], &dmatrix![1.0, 0.0], &dmatrix![0.0])
    };
    let at =
        |time: f64, state: f64| FrequencyResponse::continuous(&resonance(time, state)).unwrap().at(0.9 * time)[(0, 0)];
    // 1/(1 - w^2 + 0.2 j w) at 0.9.
    let expected = Complex::new(0.19, 0.18).inv();
    for (time, state) in [(1.0, 1.0), (1e12, 1.0), (1e-12, 1e12), (1.0, 1e-12)] {
        let error = (at(time, state) - expected).norm();
        assert!(error <= 1e-14 * expected.norm(), "{time} {state}: {error:e}");
    }
}

#[test]
fn what_is_no_loop_is_refused() {
    let (one, zero) = (dmatrix![1.0], dmatrix![0.0]);
    let nan = Realization { a: dmatrix![f64::NAN], b: one.clone(), c: one.clone(), d: zero.clone() };
    assert!(matches!(FrequencyResponse::continuous(&nan), Err(LinalgError::NotFinite { what: "A", .. })));
    assert!(matches!(stability_margins(&nan), Err(LinalgError::NotFinite { what: "A", .. })));
    let two = plant(&one, &dmatrix![1.0, 1.0], &one, &dmatrix![0.0, 0.0]);
    let refused = discrete_stability_margins(&two);
    assert!(matches!(refused, Err(LinalgError::DimensionMismatch { what: "the loop", found: (1, 2), .. })));
    let algebraic = plant(&one, &one, &one, &dmatrix![-1.0]);
    assert!(matches!(stability_margins(&algebraic), Err(LinalgError::Singular { what: "I + D", .. })));
}

fn only<T: Copy + std::fmt::Debug>(all: &[T]) -> T {
    assert_eq!(all.len(), 1, "{all:?}");
    all[0]
}

/// `4/(s + 1)^3` by hand: -180 degrees at sqrt(3), where it is 1/2; `|L| = 1` where `(1 + w^2)^3 = 16`. In any unit of
/// time.
#[test]
fn three_equal_poles() {
    for unit in [1.0, 1e12, 1e-12, 3e-5] {
        let open = transfer(&[4.0 * unit * unit * unit], &[unit * unit * unit, 3.0 * unit * unit, 3.0 * unit]);
        let found = stability_margins(&open).unwrap();
        assert!(found.is_stable);
        let gain = only(&found.gain);
        assert!(near(gain.factor, 2.0, 1e-12) && near(gain.frequency, unit * 3f64.sqrt(), 1e-12), "{gain:?}");
        let phase = only(&found.phase);
        let crossover = (16f64.cbrt() - 1.0).sqrt();
        let angle = PI - 3.0 * crossover.atan();
        assert!(near(phase.frequency, unit * crossover, 1e-12) && near(phase.angle, angle, 1e-12), "{phase:?}");
        assert!(near(phase.delay, angle / crossover / unit, 1e-12));
    }
}

/// `(s + 1)^2/s^3` is -2 at w = 1: stable for gains above 1/2 alone. `2/(s - 1)` is -2 at w = 0 and 1 at an angle of
/// -120 degrees at sqrt(3). `1/s^2` is real at all frequencies, and its closed loop not stable.
#[test]
fn conditionally_stable_unstable_and_real_loops() {
    let found = stability_margins(&transfer(&[1.0, 2.0, 1.0], &[0.0, 0.0, 0.0])).unwrap();
    assert!(found.is_stable && found.gain_margin().is_none());
    let gain = only(&found.gain);
    assert_eq!(found.gain_reduction(), Some(gain));
    // A triple pole at 0 is computed to the third root of eps, and the response beside it likewise.
    assert!(near(gain.factor, 0.5, 1e-9) && near(gain.frequency, 1.0, 1e-9), "{gain:?}");

    let found = stability_margins(&transfer(&[2.0], &[-1.0])).unwrap();
    let (gain, phase) = (only(&found.gain), only(&found.phase));
    assert!(found.is_stable && gain.frequency == 0.0 && near(gain.factor, 0.5, 1e-15), "{gain:?}");
    assert!(near(phase.angle, PI / 3.0, 1e-14) && near(phase.frequency, 3f64.sqrt(), 1e-14), "{phase:?}");
    // S = (s - 1)/(s + 1) has the modulus 1 everywhere.
    assert!(near(found.modulus_margin().unwrap(), 1.0, 1e-12));

    let found = stability_margins(&transfer(&[1.0], &[0.0, 0.0])).unwrap();
    assert!(!found.is_stable && found.gain.is_empty() && found.sensitivity.is_none());
    assert!(near(only(&found.phase).frequency, 1.0, 1e-12) && only(&found.phase).angle.abs() < 1e-12);
}

/// `0.5/(z - 1)` by hand: `|L| = 1` where `4 sin(w/2) = 1`, at the angle `-90 - w/2` degrees, and -1/4 at pi.
/// `-0.5/(z + 1)` is the same seen from the other end, with a pole at -1.
#[test]
fn discrete_loops_with_poles_on_the_circle() {
    let crossover = 2.0 * 0.25f64.asin();
    let (one, zero) = (dmatrix![1.0], dmatrix![0.0]);
    let found = discrete_stability_margins(&plant(&one, &one, &dmatrix![0.5], &zero)).unwrap();
    let (gain, phase) = (only(&found.gain), only(&found.phase));
    assert!(found.is_stable && gain.frequency == PI && near(gain.factor, 4.0, 1e-15), "{gain:?}");
    let angle = PI / 2.0 - crossover / 2.0;
    assert!(near(phase.angle, angle, 1e-13) && near(phase.frequency, crossover, 1e-13), "{phase:?}");
    assert!(near(phase.delay, angle / crossover, 1e-13));

    let found = discrete_stability_margins(&plant(&-&one, &one, &dmatrix![-0.5], &zero)).unwrap();
    let (gain, phase) = (only(&found.gain), only(&found.phase));
    assert!(found.is_stable && gain.frequency == 0.0 && near(gain.factor, 4.0, 1e-15), "{gain:?}");
    assert!(near(phase.angle, -angle, 1e-13) && near(phase.frequency, PI - crossover, 1e-13), "{phase:?}");
}

/// Number of unstable eigenvalues of `A - k B C`.
fn unstable(open: &Realization, k: f64, discrete: bool) -> usize {
    let poles = eigenvalues(&(&open.a - &open.b * &open.c * k)).unwrap();
    poles.iter().filter(|pole| if discrete { pole.norm() > 1.0 } else { pole.re > 0.0 }).count()
}

proptest! {
    /// Between two neighbouring gain margins the number of unstable poles of the loop does not depend on the gain, and
    /// across one it changes: none is missing, none too many. At a phase margin `|L| = 1`, and between two of them
    /// `|L| - 1` has one sign on a grid.
    #[test]
    fn margins_are_where_poles_cross(
        n in 1usize..6, entries in proptest::collection::vec(-1.0..1.0, 48), discrete: bool, gain in 0.2..5.0f64,
    ) {
        let mut next = entries.into_iter();
        let mut matrix = |rows, cols| DMatrix::from_fn(rows, cols, |_, _| next.next().unwrap());
        let (a, b, c) = (matrix(n, n), matrix(n, 1), matrix(1, n) * gain);
        let open = plant(&a, &b, &c, &dmatrix![0.0]);
        let found: StabilityMargins =
            if discrete { discrete_stability_margins(&open) } else { stability_margins(&open) }.unwrap();
        let mut factors: Vec<f64> = found.gain.iter().map(|margin| margin.factor).collect();
        factors.sort_by(f64::total_cmp);
        let ends = [1e-3 * factors.first().unwrap_or(&1.0), 1e3 * factors.last().unwrap_or(&1.0)];
        let bounds = [&ends[..1], &factors, &ends[1..]].concat();
        let mut counts = Vec::new();
        for pair in bounds.windows(2) {
            let inside = |share: f64| pair[0].powf(1.0 - share) * pair[1].powf(share);
            // Two crossings at nearly the same gain leave nothing to count between them.
            if pair[1] < pair[0] * 1.0001 {
                continue;
            }
            let first = unstable(&open, inside(0.01), discrete);
            for k in 2..100 {
                prop_assert_eq!(unstable(&open, inside(f64::from(k) / 100.0), discrete), first, "{:?}", found);
            }
            counts.push(first);
        }
        prop_assert!(counts.windows(2).all(|pair| pair[0] != pair[1]), "{counts:?} {found:?}");

        let response = if discrete { FrequencyResponse::discrete(&open) } else { FrequencyResponse::continuous(&open) };
        let response = response.unwrap();
        let size = |w: f64| response.at(w)[(0, 0)].norm();
        for margin in &found.phase {
            prop_assert!((size(margin.frequency) - 1.0).abs() < 1e-9, "{margin:?}");
        }
        let mut crossings = 0;
        let grid: Vec<f64> = (1..2000)
            .map(|k| if discrete { PI * f64::from(k) / 2000.0 } else { 1e-3 * 10f64.powf(f64::from(k) / 333.0) })
            .collect();
        for pair in grid.windows(2) {
            let inside = found.phase.iter().filter(|margin| margin.frequency > pair[0] && margin.frequency <= pair[1]);
            let changes = (size(pair[0]) > 1.0) != (size(pair[1]) > 1.0);
            let count = inside.count();
            prop_assert_eq!(changes, count % 2 == 1, "{:?} {:?}", pair, found);
            crossings += count;
        }
        prop_assert!(crossings <= found.phase.len());
    }
}
