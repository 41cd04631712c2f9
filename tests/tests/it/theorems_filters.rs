//! Bounds of the H-infinity and the H2 norm of the error, and reduced-order observers, as properties of random systems.
//! Statement and proof: docs/theory-cubic.md.

use luenberger_design::{
    DiscreteDesign, GainOptions, GeneralizedPlant, NormFilterDesign, NormTarget, ReducedOrderDesign, SystemNorm,
    TimeDomain,
};
use luenberger_observers::SampledObserver;
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{FilterProblem, H2Filter, HInfinityFilter, Theorem};
use nalgebra::{Complex, DMatrix, DVector};
use proptest::prelude::*;

use crate::generators::{matrix, observable_plant, partly_measured_plant};

/// E with the columns of w that act on the states, and noise of each output, which acts on the states as well.
fn performance(n: usize, p: usize, e: &DMatrix<f64>, h: &DMatrix<f64>, all: bool) -> GeneralizedPlant {
    let acting = e.view((0, 0), (n, 2)).into_owned();
    GeneralizedPlant {
        e: DMatrix::from_fn(n, 2 + p, |i, j| match j {
            0 | 1 => acting[(i, j)] + f64::from(i == j),
            _ => 0.2 * acting[(i, j % 2)],
        }),
        d: DMatrix::from_fn(p, 2 + p, |i, j| if j == 2 + i { 0.5 } else { 0.0 }),
        h: if all { DMatrix::identity(n, n) } else { h.view((0, 0), (1, n)).into_owned() + DMatrix::repeat(1, n, 0.1) },
    }
}

/// F and G, written out here.
fn flow(design: &NormFilterDesign, of: &GeneralizedPlant) -> (DMatrix<f64>, DMatrix<f64>) {
    (&design.plant.a - &design.l * &design.plant.c, &of.e - &design.l * &of.d)
}

/// The largest singular value of the transfer function at a frequency.
fn gain_at(f: &DMatrix<f64>, g: &DMatrix<f64>, h: &DMatrix<f64>, s: Complex<f64>) -> f64 {
    let complex = |m: &DMatrix<f64>| m.map(Complex::from);
    let state = (DMatrix::identity(f.nrows(), f.nrows()) * s - complex(f)).lu().solve(&complex(g)).unwrap();
    (complex(h) * state).svd(false, false).singular_values.max()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    /// No frequency has a gain of gamma or more, in continuous and in discrete time, the certified gamma is attained up
    /// to the margins of the design, and for every w and e(0) the energy of z stays below the bound.
    #[test]
    fn no_disturbance_has_a_gain_above_the_proved_one(
        plant in observable_plant(1..=3), e in matrix(3, 2), h in matrix(1, 3), all in any::<bool>(),
        discrete in any::<bool>(), e0 in matrix(3, 1), w in prop::collection::vec(matrix(5, 1), 40),
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let of = performance(n, p, &e, &h, all);
        let time = if discrete { TimeDomain::Discrete } else { TimeDomain::Continuous };
        let options = GainOptions::default();
        let design = NormFilterDesign::new(&plant, time, SystemNorm::HInfinity, &of, &NormTarget::Least, &options).unwrap();
        prop_assert!(design.certificate.is_proved(), "{}", design.certificate);
        let (f, g) = flow(&design, &of);
        for k in 0..400 {
            let s = if discrete {
                Complex::from_polar(1.0, f64::from(k) * std::f64::consts::PI / 399.0)
            } else {
                Complex::new(0.0, 10f64.powf(f64::from(k) * 0.02 - 4.0))
            };
            let gain = gain_at(&f, &g, &of.h, s);
            prop_assert!(gain < design.gamma * (1.0 + 1e-9) && gain <= design.norm * (1.0 + 1e-6), "{gain} at {s}");
        }
        // A run: V falls by what the inequality says, at every step of a fine discretisation by its own map.
        let Theorem::HInfinityFilter(HInfinityFilter(problem)) = design.certificate.theorems()[0].theorem() else {
            panic!()
        };
        let v = |e: &DVector<f64>| e.dot(&(&design.p * e));
        let mut state = DVector::from_fn(n, |i, _| e0[(i, 0)]);
        let (start, mut spent, mut seen) = (v(&state), 0.0, 0.0);
        for w in &w {
            let w = DVector::from_fn(2 + p, |i, _| w[(i, 0)]);
            let z = &of.h * &state;
            if discrete {
                seen += z.norm_squared();
                spent += w.norm_squared();
                state = &f * &state + &g * &w;
                let allowed = start + problem.gamma.powi(2) * spent;
                prop_assert!(v(&state) + seen <= allowed * (1.0 + 1e-9), "{seen} and {allowed}");
            } else {
                let rise = 2.0 * (&design.p * &state).dot(&(&f * &state + &g * &w));
                let allowed = problem.gamma.powi(2) * w.norm_squared() - z.norm_squared();
                prop_assert!(rise <= allowed + 1e-9 * (rise.abs() + allowed.abs()), "{rise} and {allowed}");
                state = w.rows(0, n.min(w.len())).into_owned().resize_vertically(n, 0.3);
            }
        }
    }

    /// The variance is the sum of the squares of the impulse responses, which is below gamma^2, and no other gain that
    /// is tried has a smaller one.
    #[test]
    fn the_h2_filter_has_the_least_variance(
        plant in observable_plant(1..=3), e in matrix(3, 2), h in matrix(1, 3), all in any::<bool>(),
        discrete in any::<bool>(), step in matrix(3, 3),
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let of = performance(n, p, &e, &h, all);
        let time = if discrete { TimeDomain::Discrete } else { TimeDomain::Continuous };
        let new = |goal: &NormTarget| NormFilterDesign::new(&plant, time, SystemNorm::H2, &of, goal, &GainOptions::default());
        let design = new(&NormTarget::Least).unwrap();
        prop_assert!(design.certificate.is_proved(), "{}", design.certificate);
        let (f, g) = flow(&design, &of);
        // Simpson's rule over steps of exp(F h), or the sum.
        let h_step = 0.01 / (1.0 + f.norm());
        let map = if discrete { f.clone() } else { (&f * h_step).exp() };
        let (mut state, mut sum) = (g.clone(), 0.0);
        let mut has_decayed = false;
        for k in 0..2_000_000 {
            let size = (&of.h * &state).norm_squared();
            sum += if discrete { size } else { h_step * size * if k == 0 { 0.5 } else { 1.0 } };
            if state.norm() < 1e-7 * g.norm() {
                has_decayed = true;
                break;
            }
            state = &map * state;
        }
        prop_assert!(has_decayed);
        prop_assert!((sum.sqrt() / design.norm - 1.0).abs() < 1e-3, "{} and {}", sum.sqrt(), design.norm);
        prop_assert!(sum.sqrt() < design.gamma * 1.001);
        for size in [-1e-2, 1e-2, 0.3] {
            let other = &design.l + step.view((0, 0), (n, p)) * size;
            if let Ok(other) = new(&NormTarget::OfGain(other)) {
                prop_assert!(other.norm >= design.norm * (1.0 - 1e-4), "{} and {}", other.norm, design.norm);
            }
        }
    }

    /// The facts are those of the theorem, no weaker: a gamma below the norm is refuted for every P that is tried.
    #[test]
    fn a_gamma_below_the_norm_is_not_proved(
        plant in observable_plant(1..=3), e in matrix(3, 2), h in matrix(1, 3), all in any::<bool>(),
        discrete in any::<bool>(), h2 in any::<bool>(), scale in 0.2..5.0_f64,
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let of = performance(n, p, &e, &h, all);
        let time = if discrete { TimeDomain::Discrete } else { TimeDomain::Continuous };
        let norm = if h2 { SystemNorm::H2 } else { SystemNorm::HInfinity };
        let design = NormFilterDesign::new(&plant, time, norm, &of, &NormTarget::Least, &GainOptions::default()).unwrap();
        let change = |problem: &FilterProblem, factor: f64| FilterProblem {
            gamma: design.norm * (1.0 - 1e-6),
            p: problem.p.map(|x| x * factor),
            ..problem.clone()
        };
        for factor in [1.0, 1.0 - 1e-5, 1.0 + 1e-5, 0.98, 1.02, scale] {
            let theorem: Theorem = match design.certificate.theorems()[0].theorem() {
                Theorem::HInfinityFilter(HInfinityFilter(problem)) => HInfinityFilter(change(problem, factor)).into(),
                Theorem::H2Filter(H2Filter(problem)) => H2Filter(change(problem, factor)).into(),
                other => panic!("{}", other.name()),
            };
            let facts = theorem.facts().unwrap();
            prop_assert!(facts.iter().any(|fact| fact.verdict.is_refuted()));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// The estimate of a reduced-order observer follows the state of every plant and input, `y = C xhat` at all times,
    /// and the poles are those asked for.
    #[test]
    fn a_reduced_order_observer_follows_the_state(
        plant in partly_measured_plant(2..=5), x0 in matrix(5, 1), w0 in matrix(5, 1), u0 in matrix(5, 1),
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let poles: Vec<f64> = (0..n - p).map(|k| -1.0 - 0.5 * k as f64).collect();
        let design = ReducedOrderDesign::with_poles(&plant, &poles).unwrap();
        prop_assert!(design.certificate.is_proved(), "{}", design.certificate);
        let o = &design.observer;
        let q = n - p;
        let mut found: Vec<f64> = design.poles.iter().map(|pole| pole.re).collect();
        found.sort_by(|a, b| b.total_cmp(a));
        for (found, asked) in found.iter().zip(&poles) {
            prop_assert!((found - asked).abs() < 1e-5, "{found} and {asked}");
        }
        // x and w together, with a constant input.
        let u = DVector::from_fn(plant.b.ncols(), |i, _| u0[(i, 0)]);
        let mut x = DVector::from_fn(n, |i, _| x0[(i, 0)]);
        let mut w = DVector::from_fn(q, |i, _| w0[(i, 0)]);
        let v = |x: &DVector<f64>, w: &DVector<f64>| w - &o.t * x;
        let start = v(&x, &w);
        let (step, steps) = (1e-3, 2000);
        let growth = |x: &DVector<f64>| &plant.a * x + &plant.b * &u;
        let slope = |x: &DVector<f64>, w: &DVector<f64>| &o.f * w + &o.g * (&plant.c * x) + &o.h * &u;
        for _ in 0..steps {
            let (k1, l1) = (growth(&x), slope(&x, &w));
            let (x2, w2) = (&x + &k1 * (step / 2.0), &w + &l1 * (step / 2.0));
            let (k2, l2) = (growth(&x2), slope(&x2, &w2));
            x += &k2 * step;
            w += &l2 * step;
            let seen = &plant.c * (&o.m * &w + &o.n * (&plant.c * &x) - &x);
            prop_assert!(seen.norm() < 1e-8 * (1.0 + x.norm() + w.norm()), "{seen}");
        }
        let expected = (&o.f * (step * f64::from(steps))).exp() * start;
        let found = v(&x, &w);
        let size = 1.0 + x.norm() + w.norm() + o.t.norm();
        prop_assert!((&found - &expected).norm() < 1e-3 * size, "{found} and {expected}");
        let error = &o.m * &w + &o.n * (&plant.c * &x) - &x;
        prop_assert!((&error - &o.m * &found).norm() < 1e-8 * size * (1.0 + o.m.norm()), "{error}");
    }

    /// In discrete time the estimate is that of `w+ = F w + G y + H u`, `xhat = M w + N y` with `w = T xhat(k|k-1)`,
    /// its error falls by the poles asked for, and C xhat = y.
    #[test]
    fn a_reduced_order_observer_of_samples_is_a_filter(
        plant in partly_measured_plant(2..=6), x0 in matrix(6, 1), first in matrix(6, 1), u0 in matrix(6, 1),
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let size = plant.a.norm();
        let plant = StateSpace::new(&plant.a / size, plant.b.clone(), plant.c.clone()).unwrap();
        let poles: Vec<f64> = (0..n - p).map(|k| 0.1 + 0.1 * k as f64).collect();
        let design = DiscreteDesign::reduced_order(&plant, 1.0, &poles).unwrap();
        prop_assert!(design.certificate.is_proved(), "{}", design.certificate);
        let filter = design.filter().unwrap();
        let o = luenberger_linalg::reduced_order_observer(&plant.a, &plant.b, &plant.c, &poles).unwrap();
        let u = DVector::from_fn(plant.b.ncols(), |i, _| u0[(i, 0)]);
        let (mut x, mut state) = (DVector::from_fn(n, |i, _| x0[(i, 0)]), DVector::from_fn(n, |i, _| first[(i, 0)]));
        let mut w = &o.t * &state;
        let rounding = 1e-11 * (1.0 + o.m.norm() * o.t.norm()) * (1.0 + o.n.norm()) * (1.0 + plant.c.norm());
        for _ in 0..20 {
            let y = &plant.c * &x;
            let (found, expected) = (filter.estimate_at(&state, &u, &y), &o.m * &w + &o.n * &y);
            let scale = rounding * (1.0 + x.norm() + w.norm() + state.norm());
            prop_assert!((&found - &expected).norm() <= scale, "{found} and {expected}");
            prop_assert!((&plant.c * &found - &y).norm() <= scale * (1.0 + plant.c.norm()));
            w = &o.f * &w + &o.g * &y + &o.h * &u;
            filter.step(0.0, &mut state, &u, &y);
            x = &plant.a * &x + &plant.b * &u;
        }
    }

    /// Another T with other poles is refuted where the rate is larger than that of F.
    #[test]
    fn a_reduced_order_observer_is_not_faster_than_its_poles(
        plant in partly_measured_plant(2..=4), scale in 0.5..2.0_f64,
    ) {
        let poles: Vec<f64> = (0..plant.a.nrows() - plant.c.nrows()).map(|k| -1.0 - 0.5 * k as f64).collect();
        let design = ReducedOrderDesign::with_poles(&plant, &poles).unwrap();
        let Theorem::ReducedOrderConvergence(theorem) = design.certificate.theorems()[0].theorem() else { panic!() };
        for (rate, expected) in [(1e-6, true), (1.0 + 1e-3, false)] {
            let changed = luenberger_proof::certificate::ReducedOrderConvergence {
                rate,
                p: theorem.p.map(|x| x * scale),
                ..theorem.clone()
            };
            let facts = Theorem::from(changed).facts().unwrap();
            prop_assert_eq!(facts.iter().all(|fact| fact.verdict.is_proved()), expected);
        }
    }
}
