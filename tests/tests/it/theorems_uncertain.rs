//! Observers of uncertain plants with the forcing, as properties of random systems: docs/theory-cubic.md.

use luenberger_design::{CubicDesign, CubicGain, DisturbanceBounds, LinearDesign, UncertainBound, Uncertainty};
use luenberger_linalg::zero_order_hold;
use luenberger_observers::Observer;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use crate::generators::{linear, matrix, observable_plant};

/// What the worst signal `|w_i| <= W_i` makes of each component of `e' = F e + G w`: `sum_i W_i int |exp(Ft) G|`, from
/// below.
fn worst(f: &DMatrix<f64>, g: &DMatrix<f64>, bounds: &[f64]) -> Vec<f64> {
    let (step, mut response) = (2e-3, g.clone());
    let motion = luenberger_linalg::expm(&(f * step)).unwrap();
    let mut sums = vec![0.0; f.nrows()];
    for _ in 0..10_000 {
        let next = &motion * &response;
        for (i, sum) in sums.iter_mut().enumerate() {
            for (j, w) in bounds.iter().enumerate() {
                // Where the sign changes within a step, nothing is counted.
                if response[(i, j)] * next[(i, j)] > 0.0 {
                    *sum += step * w * 0.5 * (response[(i, j)] + next[(i, j)]).abs();
                }
            }
        }
        response = next;
    }
    sums.into_iter().map(|sum| 0.999 * sum).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 30, ..ProptestConfig::default() })]

    /// Every plant within the uncertainty, also one that changes within a period, has a sampled form within the bounds.
    #[test]
    fn the_sampled_plant_is_within_its_deviation(
        plant in observable_plant(2..=3), first in matrix(3, 3), second in matrix(3, 3), h in 0.01..0.3_f64,
        shares in (-1.0..1.0, -1.0..1.0), change in 0.0..1.0_f64, bounded in any::<bool>(),
    ) {
        let n = plant.a.nrows();
        let [first, second] = [first, second].map(|d| d.view((0, 0), (n, n)) * 0.3);
        let (uncertainty, [before, after]) = if bounded {
            let all = [first.clone(), second.clone(), -&first];
            let hull = |share: f64| &first * share + &second * (0.5 * (1.0 - share.abs()));
            (Uncertainty::Polytope(all.to_vec()), [shares.0, shares.1].map(hull))
        } else {
            // M G H with |G| <= 1: a multiple of an orthogonal matrix.
            let turn = second.clone().qr().q();
            let of = |share: f64| &first * (&turn * share) * &second;
            (Uncertainty::NormBounded { m: first.clone(), h: second.clone() }, [shares.0, shares.1].map(of))
        };
        let found = uncertainty.sampled(&plant, h).unwrap();
        let nominal = zero_order_hold(&plant.a, &plant.b, h).unwrap();
        let part = (change * h).max(1e-6 * h);
        let one = zero_order_hold(&(&plant.a + before), &plant.b, part).unwrap();
        let other = zero_order_hold(&(&plant.a + after), &plant.b, h - part + 1e-9 * h).unwrap();
        let (a, b) = (&other.ad * &one.ad, &other.ad * &one.bd + &other.bd);
        // The last part of the period is a billionth too long.
        let slack = 1e-8 * (1.0 + plant.a.norm()) * h;
        for i in 0..n {
            for j in 0..n {
                prop_assert!((a[(i, j)] - nominal.ad[(i, j)]).abs() <= found.a[(i, j)] + slack);
            }
            for j in 0..plant.b.ncols() {
                prop_assert!((b[(i, j)] - nominal.bd[(i, j)]).abs() <= found.b[(i, j)] + slack * plant.b.norm());
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, ..ProptestConfig::default() })]

    /// The bound is proved, and no signal x within its bounds makes a larger error, at any vertex or between; the cubic
    /// term does not increase what is reached either.
    #[test]
    fn no_state_within_its_bounds_makes_a_larger_error(
        plant in observable_plant(2..=3), first in matrix(3, 3), second in matrix(3, 3), share in 0.0..1.0, size in 0.1..3.0,
    ) {
        let n = plant.a.nrows();
        let deviations = [first, second].map(|d| d.view((0, 0), (n, n)) * 0.2);
        let states: Vec<f64> = (0..n).map(|i| size * (1.0 + i as f64)).collect();
        let design = linear(&plant, 1.0);
        let uncertainty = Uncertainty::Polytope(deviations.to_vec());
        let found = UncertainBound::linear(&design, &uncertainty, &states, None).unwrap();
        prop_assert!(found.certificate.is_proved(), "{}", found.certificate);
        let f = &plant.a - design.l() * &plant.c;
        let between = &deviations[0] * share + &deviations[1] * (1.0 - share);
        for deviation in [&deviations[0], &deviations[1], &between] {
            for (i, reached) in worst(&f, deviation, &states).iter().enumerate() {
                prop_assert!(*reached <= found.bound.limsup[i], "e{}: {reached} and {:?}", i + 1, found.bound.limsup);
            }
        }
        // The cubic observer under x that switches with the sign of the error's gradient: it stays in the level of its
        // own bound.
        let p = plant.c.nrows();
        let cubic = CubicDesign::new(&design, &DMatrix::identity(p, p), &CubicGain::Gamma(1.0)).unwrap();
        let found = UncertainBound::cubic(&cubic, &uncertainty, &states, None).unwrap();
        prop_assert!(found.certificate.is_proved(), "{}", found.certificate);
        let (u, y) = (DVector::zeros(1), DVector::zeros(p));
        let mut e = DVector::zeros(n);
        let mut largest = vec![0.0_f64; n];
        let step = 1e-3;
        for k in 0..20_000 {
            let pushed = deviations[k % 2].transpose() * (&found.bound.p * &e);
            let x = DVector::from_fn(n, |i, _| if pushed[i] >= 0.0 { states[i] } else { -states[i] });
            let slope = -cubic.observer.derivative(0.0, &-&e, &u, &y) + &deviations[k % 2] * x;
            e += slope * step;
            for i in 0..n {
                largest[i] = largest[i].max(e[i].abs());
            }
        }
        for i in 0..n {
            prop_assert!(largest[i] <= found.bound.limsup[i] * 1.001, "{largest:?} and {:?}", found.bound.limsup);
        }
    }

    /// Norm-bounded: `Delta = M G H` for any G of norm 1 is a signal within the bound.
    #[test]
    fn a_norm_bounded_deviation_is_covered(
        plant in observable_plant(2..=3), m in matrix(3, 1), h in matrix(2, 3), angle in 0.0..core::f64::consts::TAU,
    ) {
        let n = plant.a.nrows();
        let (m, h) = (m.view((0, 0), (n, 1)) * 0.3, h.view((0, 0), (2, n)).into_owned());
        let states = vec![1.0; n];
        let design = linear(&plant, 1.0);
        let uncertainty = Uncertainty::NormBounded { m: m.clone(), h: h.clone() };
        let found = UncertainBound::linear(&design, &uncertainty, &states, None).unwrap();
        prop_assert!(found.certificate.is_proved(), "{}", found.certificate);
        let f = &plant.a - design.l() * &plant.c;
        // A unit row G, constant: the deviation is one of a polytope of one vertex.
        let g = DMatrix::from_row_slice(1, 2, &[angle.cos(), angle.sin()]);
        for (i, reached) in worst(&f, &(&m * g * h), &states).iter().enumerate() {
            prop_assert!(*reached <= found.bound.limsup[i], "e{}: {reached} and {:?}", i + 1, found.bound.limsup);
        }
    }

    /// The optimal gain has a bound no larger than those of placed poles, by the measure that it minimises.
    #[test]
    fn no_placed_gain_has_a_smaller_bound_than_the_optimal_one(plant in observable_plant(2..=2), d in matrix(2, 2), noise in 0.01..0.3) {
        let p = plant.c.nrows();
        let uncertainty = Uncertainty::Polytope(vec![d.clone() * 0.3, -d * 0.3]);
        let noise = DisturbanceBounds::of_outputs(2, &vec![noise; p]);
        let (states, scale) = ([1.0, 1.0], [1.0, 1.0]);
        let size = |found: &UncertainBound| found.bound.limsup.iter().map(|b| b * b).sum::<f64>();
        let best = UncertainBound::optimal(&plant, &uncertainty, &states, &noise, &scale).unwrap();
        prop_assert!(best.certificate.is_proved(), "{}", best.certificate);
        for speed in [0.5, 1.0, 2.0, 4.0, 8.0] {
            let design = LinearDesign::with_poles(&plant, &[-speed, -1.3 * speed]).unwrap();
            let other = UncertainBound::linear(&design, &uncertainty, &states, Some(&noise)).unwrap();
            // The grid of rates leaves a little.
            prop_assert!(size(&best) <= 1.1 * size(&other), "{} and {} at {speed}", size(&best), size(&other));
        }
    }
}
