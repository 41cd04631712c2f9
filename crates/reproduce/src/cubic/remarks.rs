//! Minor claims of the paper: the behaviour near 0, Zubov's equation of Remark 2 and the shift of footnote 1.

use luenberger_design::CubicDesign;
use luenberger_design::robust::theorem5_bound;
use luenberger_design::{CubicGain, LinearDesign};
use luenberger_lmi::proof_matrix;
use luenberger_observers::Observer;
use luenberger_plants::StateSpace;
use luenberger_proof::statement::decay_rate;
use luenberger_sim::Scenario;
use nalgebra::{DMatrix, DVector};

use super::random::{Random, SEED};
use super::theorems::{random_designs, seeded};
use crate::claim::{CheckError, Claim, Class, Outcome};
use crate::context::Context;
use crate::evidence::Evidence;

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim::holds(
            Class::Theorem,
            "cubic.near-zero",
            "after (7)",
            "near 0 the cubic observer behaves like the linear one: the difference of the errors is of third order in e(0) (the least and the largest order found)",
            &["random plants; e(0) halved four times; the difference at the time constant of the slowest pole"],
            near_zero,
        )
        .quoting(
            "When the estimation error shrinks as t → ∞, the cubic term in (7) vanishes faster than the linear term. Therefore, the cubic observer (5) has a behavior close to a linear \
             observer (2) in the vicinity of the origin",
            "e_c(t) - e_l(t) = o(|e(0)|) from one e(0); the cubic term makes it O(|e(0)|³)",
        ),
        Claim::holds(
            Class::Theorem,
            "cubic.remark2.zubov",
            "Remark 2",
            "V_CZ solves Zubov's equation ∇V_CZ'e' = -h (1 - V_CZ) with a positive definite h, and 0 < V_CZ < 1 is every e ≠ 0 (largest residual, relative to the size of its terms)",
            &["random plants, general θ and S; h = e'Qe + 2 (y~'θy~) y~'Sy~; |e| up to where 1 - V_CZ is a tenth"],
            zubov,
        )
        .quoting(
            "Theorem 1 can be alternatively established with Lyapunov function V_CZ = 1 - exp(-e'Pe) and the Zubov's equation [34], for which a convergence region is derived as: \
             0 < V_CZ < 1.",
            "the region on which V_CZ < 1 is that of convergence: all of R^n",
        ),
        Claim::holds(
            Class::Theorem,
            "cubic.thm5.footnote",
            "Theorem 5, footnote 1",
            "ε_max ≥ 0 ≥ ε_min costs no generality: with A + ε_min I in the place of A (or A + ε_max I, where both are negative) the theorem covers the interval",
            &["random plants; ε in [1, 1 + b] and in [-1 - b, -1] with b the bound (23) of the shifted plant, at nine points of each"],
            footnote,
        )
        .quoting(
            "If both bounds are positive, we can replace ε by ε' = ε - ε_min with ε'_min = 0, ε'_max = ε_max - ε_min and A by A + ε_min I. Similar arguments hold if both bounds are negative.",
            "L, P and Q of (9) are then those of the shifted A; strictly below the bound",
        ),
    ]
}

/// The errors of both observers from `e0` at time 1, for a plant at rest.
fn errors(design: &CubicDesign, e0: &DVector<f64>) -> Result<[DVector<f64>; 2], CheckError> {
    let o = &design.observer;
    let plant = StateSpace::new(o.a.clone(), o.b.clone(), o.c.clone())?;
    let mut linear = o.clone();
    linear.n.fill(0.0);
    let xhat0: Vec<f64> = e0.iter().map(|e| -e).collect();
    let run = Scenario::new(plant)
        .observer("cubic", o.clone(), &xhat0)
        .observer("linear", linear, &xhat0)
        .times(&[0.0, 1.0])
        .tolerances(1e-13, 1e-16)
        .run()?;
    let [c, l] = ["cubic", "linear"].map(|name| run.observer(name).map(|found| found.error.row(1).transpose()));
    Ok([c?, l?])
}

fn near_zero(_: &Context) -> Result<Outcome, CheckError> {
    let mut random = Random::new();
    let (mut least, mut largest) = (f64::INFINITY, 0.0_f64);
    let mut designs = 0;
    for design in random_designs(|_, _| CubicGain::Gamma(1.0))? {
        designs += 1;
        let e0 = random.vector(design.p.nrows());
        // Small enough for the next order, 5, to be a hundredth, and large enough for the difference to be 1e-6 of e.
        let mut size = 0.02;
        while {
            let [c, l] = errors(&design, &(&e0 * size))?;
            (&c - &l).norm() > 2e-3 * l.norm()
        } {
            size /= 2.0;
        }
        let mut gaps = Vec::new();
        for k in 0..3 {
            let [c, l] = errors(&design, &(&e0 * (size / f64::from(1 << k))))?;
            gaps.push((c - l).norm());
        }
        for pair in gaps.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            (least, largest) = (least.min(order), largest.max(order));
        }
    }
    Ok(Outcome::new(Evidence::holds_by(least > 2.9 && largest < 3.1, [least, largest])).instances(designs).note(seeded(
        "log2 of the quotient of the differences when e(0) is halved. The cubic term is of third order in e, hence so is what it adds to the linear flow.",
    )))
}

fn zubov(_: &Context) -> Result<Outcome, CheckError> {
    let mut random = Random::new();
    let (mut largest, mut holds) = (0.0_f64, true);
    let mut strengths: Vec<DMatrix<f64>> = Vec::new();
    let designs = random_designs(|random, p| {
        let s = random.accretive(p);
        strengths.push(s.clone());
        CubicGain::General(s)
    })?;
    for (design, s) in designs.iter().zip(&strengths) {
        let o = &design.observer;
        for _ in 0..20 {
            // V up to ln 10, so that 1 - V_CZ is not rounding.
            let direction = random.vector(design.p.nrows());
            let v = 10.0_f64.ln() * random.vector(1)[0].abs();
            let e = &direction * (v / direction.dot(&(&design.p * &direction))).sqrt();
            let (u, y) = (DVector::zeros(o.b.ncols()), DVector::zeros(o.c.nrows()));
            // With the plant at rest the error is minus the estimate.
            let slope = -o.derivative(0.0, &-&e, &u, &y);
            let (output, v) = (&o.c * &e, e.dot(&(&design.p * &e)));
            let h = e.dot(&(&design.q * &e)) + 2.0 * output.dot(&(&o.theta * &output)) * output.dot(&(s * &output));
            let rest = (-v).exp();
            let left = rest * 2.0 * (&design.p * &e).dot(&slope);
            let size = rest * 2.0 * (&design.p * &e).norm() * slope.norm() + h * rest;
            largest = largest.max((left + h * rest).abs() / size);
            holds &= h > 0.0 && (0.0..1.0).contains(&(1.0 - rest)) && rest < 1.0;
        }
    }
    // Products of up to five terms, and N that meets P N = -C'S to the rounding of a solve.
    Ok(Outcome::new(Evidence::holds_by(holds && largest < 1e-12, largest))
        .instances(20 * designs.len())
        .note(seeded("h ≥ e'Qe > 0. It proves what V proves, no more and no less: 1 - V_CZ = exp(-V).")))
}

fn footnote(_: &Context) -> Result<Outcome, CheckError> {
    let mut random = Random::new();
    let mut truths = Vec::new();
    for n in 1..=5 {
        for p in 1..=n {
            let plant = random.plant(n, p)?;
            let poles: Vec<f64> = (0..n).map(|k| -1.0 - 0.5 * k as f64).collect();
            // From the end of the interval that is nearer to 0, away from 0.
            for (end, sign) in [(1.0, 1.0), (-1.0, -1.0)] {
                let shifted =
                    StateSpace::new(&plant.a + DMatrix::identity(n, n) * end, plant.b.clone(), plant.c.clone())?;
                let design = LinearDesign::with_poles(&shifted, &poles)?;
                let bound = theorem5_bound(&design.p, &design.q)?;
                for k in 0..9 {
                    let eps = end + sign * bound * 0.999 * f64::from(k) / 8.0;
                    let a = proof_matrix(&(&plant.a + DMatrix::identity(n, n) * eps));
                    let (l, c, p) = (proof_matrix(design.l()), proof_matrix(&plant.c), proof_matrix(&design.p));
                    truths.push(decay_rate(&a, &l, &c, &p, 0.0).map(|verdict| super::theorems::truth(&[verdict]))?);
                }
            }
        }
    }
    Ok(Outcome::new(Evidence::cases(truths)).note(format!(
        "V decreases, proved at each point for A + εI with the L and P of the shifted plant. Negative ε only help. Seed {SEED}."
    )))
}
