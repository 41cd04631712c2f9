//! Deployed observers: the proved ball against the arithmetic itself, in every order of summation, and stored gains
//! that stop stabilising.

use luenberger_proof::statement::{
    CubicGains, Deployed, Deviation, Format, Formats, NoErrorBallReason, Operation, Running, SampledPlant, Step,
    deployed_linear, deployed_sampled_cubic, saturated_decrease,
};
use luenberger_proof::{Exact, Matrix, ProofError, Ring};
use luenberger_random::Random;
use proptest::prelude::*;

fn identity(n: usize) -> Matrix<f64> {
    Matrix::from_fn(n, n, |i, j| if i == j { 1.0 } else { 0.0 })
}

/// How a sum of products is computed.
#[derive(Debug, Clone, Copy)]
enum Order {
    Forward,
    Backward,
    Pairwise,
    Fused,
    FusedBackward,
}

const ORDERS: [Order; 5] = [Order::Forward, Order::Backward, Order::Pairwise, Order::Fused, Order::FusedBackward];

/// `sum a_k b_k` in f32.
fn dot(terms: &[(f32, f32)], order: Order) -> f32 {
    let forward = |terms: &mut dyn Iterator<Item = &(f32, f32)>| terms.fold(0.0_f32, |sum, (a, b)| sum + a * b);
    let fused = |terms: &mut dyn Iterator<Item = &(f32, f32)>| terms.fold(0.0_f32, |sum, (a, b)| a.mul_add(*b, sum));
    match order {
        Order::Forward => forward(&mut terms.iter()),
        Order::Backward => forward(&mut terms.iter().rev()),
        Order::Fused => fused(&mut terms.iter()),
        Order::FusedBackward => fused(&mut terms.iter().rev()),
        Order::Pairwise => match terms {
            [] => 0.0,
            [(a, b)] => a * b,
            _ => {
                let (left, right) = terms.split_at(terms.len() / 2);
                dot(left, order) + dot(right, order)
            }
        },
    }
}

/// The same in fixed point, on integers; each product rounded, or the wide sum.
fn dot_fixed(terms: &[(i64, i64)], fraction_bits: u32, wide: bool) -> i64 {
    let nearest = |x: i64| {
        let (floor, half) = (x >> fraction_bits, 1_i64 << (fraction_bits - 1));
        let rest = x - (floor << fraction_bits);
        floor + i64::from(rest > half || (rest == half && floor & 1 == 1))
    };
    if wide { nearest(terms.iter().map(|(a, b)| a * b).sum()) } else { terms.iter().map(|(a, b)| nearest(a * b)).sum() }
}

/// A plant whose states stay within `bound` for inputs within it, and a gain with `|A - LC|_2 < 0.95`: both by the size
/// of the entries.
fn system() -> impl Strategy<Value = (SampledPlant, Matrix<f64>, f64, u64)> {
    (1..=6_usize, 1..=2_usize, 1..=2_usize).prop_flat_map(|(n, m, p)| {
        (prop::collection::vec(-1.0..1.0_f64, n * (n + m + 2 * p)), -2.0..6.0_f64, any::<u64>()).prop_map(
            move |(entries, magnitude, seed)| {
                let mut entries = entries.into_iter();
                let mut matrix = |rows: usize, cols: usize, size: f64| {
                    Matrix::from_fn(rows, cols, |_, _| size * entries.next().unwrap_or(0.5))
                };
                let a = matrix(n, n, 0.75 / n as f64);
                let b = matrix(n, m, 0.25 / m as f64);
                let c = matrix(p, n, 1.0);
                let l = matrix(n, p, 0.2 / (n * p) as f64);
                (SampledPlant { a, b, c }, l, 10.0_f64.powf(magnitude), seed)
            },
        )
    })
}

/// Mostly the ends of [-1, 1], which is where the worst is.
fn noise(random: &mut Random) -> f64 {
    if random.once_in(4) { random.unit() } else { random.sign() }
}

fn apply(m: &Matrix<f64>, x: &[f64]) -> Vec<f64> {
    (0..m.rows()).map(|i| m.row(i).iter().zip(x).map(|(a, b)| a * b).sum()).collect()
}

fn promise(plant: &SampledPlant, bound: f64) -> Operation {
    Operation {
        state: vec![bound; plant.a.rows()],
        input: vec![bound; plant.b.cols()],
        noise: vec![0.0; plant.c.rows()],
        error: vec![bound; plant.a.rows()],
        deviation: None,
    }
}

/// A step of an observer from (estimate, input, measurement), all as numbers of the format.
type Stepper<'a> = dyn Fn(&[f64], &[f64], &[f64]) -> Vec<f64> + 'a;

/// Runs the plant in binary64 and the observer in its own arithmetic; the largest `|e_i|` of the second half as a share
/// of its bound.
fn run(
    plant: &SampledPlant,
    deployed: &Deployed,
    operation: &Operation,
    running: Format,
    seed: u64,
    step: &Stepper<'_>,
) -> Result<f64, TestCaseError> {
    let ball = deployed.ball().expect("proved");
    let n = plant.a.rows();
    let mut random = Random(seed);
    let mut x: Vec<f64> = operation.state.iter().map(|bound| bound * noise(&mut random)).collect();
    let mut xhat = vec![0.0; n];
    let mut share = 0.0_f64;
    let mut transient = ball.start;
    for k in 0..400 {
        let e: Vec<f64> = x.iter().zip(&xhat).map(|(x, xhat)| x - xhat).collect();
        let norm = e.iter().map(|e| e * e).sum::<f64>().sqrt();
        // The plant itself is run in binary64, with an error of 1e-15 of its size and step.
        let slack = 1e-13 * operation.state.iter().fold(0.0, |m: f64, x| m.max(*x));
        prop_assert!(norm <= ball.ultimate + transient + slack, "step {k}: |e| = {norm:e}, {ball:?}");
        for (e, bound) in e.iter().zip(&ball.entries) {
            prop_assert!(e.abs() <= bound + transient + slack, "step {k}: {e:e} for {bound:e}");
            if k >= 200 {
                share = share.max(e.abs() / bound);
            }
        }
        transient *= ball.contraction + ball.relative;
        let u: Vec<f64> =
            operation.input.iter().map(|bound| running.round(bound * noise(&mut random)).expect("in range")).collect();
        let y: Vec<f64> = apply(&plant.c, &x).iter().map(|y| running.round(*y).expect("in range")).collect();
        xhat = step(&xhat, &u, &y);
        let mut moved = |m: &Matrix<f64>, bound: Option<&Matrix<f64>>| match bound {
            Some(bound) => Matrix::from_fn(m.rows(), m.cols(), |i, j| m[(i, j)] + bound[(i, j)] * noise(&mut random)),
            None => m.clone(),
        };
        let a = moved(&plant.a, operation.deviation.as_ref().map(|deviation| &deviation.a));
        let b = moved(&plant.b, operation.deviation.as_ref().map(|deviation| &deviation.b));
        x = apply(&a, &x).iter().zip(apply(&b, &u)).map(|(ax, bu)| ax + bu).collect();
    }
    Ok(share)
}

/// The step in f32, products and sums in the given order: the innovation form sums each product apart or all terms in
/// one sum.
fn single(deployed: &Deployed, step: Step, order: Order, xhat: &[f64], u: &[f64], y: &[f64]) -> Vec<f64> {
    let s = &deployed.stored;
    let row = |m: &Matrix<f64>, i: usize, x: &[f64]| -> Vec<(f32, f32)> {
        m.row(i).iter().zip(x).map(|(a, b)| (*a as f32, *b as f32)).collect()
    };
    let z: Vec<f64> = match step {
        Step::Joined => y.to_vec(),
        Step::Innovation | Step::Accumulated => {
            (0..s.c.rows()).map(|k| f64::from(y[k] as f32 - dot(&row(&s.c, k, xhat), order))).collect()
        }
    };
    (0..s.a.rows())
        .map(|i| {
            let parts = [row(&s.a, i, xhat), row(&s.b, i, u), row(&s.l, i, &z)];
            f64::from(match order {
                Order::Forward | Order::Backward => parts.iter().fold(0.0, |sum, part| sum + dot(part, order)),
                _ => dot(&parts.concat(), order),
            })
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    /// f32, in five orders of summation, in both forms of the step: the error is within the proved ball at every step.
    #[test]
    fn the_error_of_the_single_precision_observer_is_within_its_ball((plant, l, bound, seed) in system(), joined in any::<bool>()) {
        let step = if joined { Step::Joined } else { Step::Innovation };
        let operation = promise(&plant, bound);
        let deployed = deployed_linear(&plant, &l, &identity(plant.a.rows()), step, Format::Binary32.into(), &operation).expect("fits");
        prop_assert!(deployed.is_stable());
        for order in ORDERS {
            run(&plant, &deployed, &operation, Format::Binary32, seed, &|xhat, u, y| single(&deployed, step, order, xhat, u, y))?;
        }
    }

    /// The same while the plant deviates from its A and B in every step, at the bounds of the deviations most of the
    /// time; and without these bounds the ball is too small for it.
    #[test]
    fn the_error_is_within_its_ball_while_the_plant_deviates((plant, l, bound, seed) in system(), joined in any::<bool>(), size in 1e-3..0.1_f64) {
        let step = if joined { Step::Joined } else { Step::Innovation };
        let plant = SampledPlant { a: plant.a.map(|x| 0.8 * x), b: plant.b.map(|x| 0.8 * x), c: plant.c };
        let (n, m) = (plant.a.rows(), plant.b.cols());
        let deviation = Deviation {
            a: Matrix::from_fn(n, n, |_, _| size / n as f64),
            b: Matrix::from_fn(n, m, |_, _| 0.5 * size / m as f64),
        };
        let exactly = promise(&plant, bound);
        let operation = Operation { deviation: Some(deviation), ..exactly.clone() };
        let judged = |operation: &Operation| {
            deployed_linear(&plant, &l, &identity(n), step, Format::Binary32.into(), operation).expect("fits")
        };
        let deployed = judged(&operation);
        let share = run(&plant, &deployed, &operation, Format::Binary32, seed, &|xhat, u, y| single(&deployed, step, Order::Forward, xhat, u, y))?;
        let (with, without) = (deployed.ball().expect("proved"), judged(&exactly).ball().expect("proved").clone());
        // One step alone makes an error of a part of |dA| |x|, a hundred times the rounding at least.
        prop_assert!(with.entries.iter().zip(&without.entries).all(|(with, without)| *with > 10.0 * without));
        prop_assert!(share > 1e-3, "{share}");
    }

    /// Fixed point with 4 to 19 bits after the point, products rounded one by one or in a wide sum.
    #[test]
    fn the_error_of_the_fixed_point_observer_is_within_its_ball((plant, l, _, seed) in system(), fraction_bits in 4..20_u32, form in 0..3_usize, wide in any::<bool>()) {
        let step = [Step::Joined, Step::Innovation, Step::Accumulated][form];
        // Its bound is that of one rounding per sum.
        let wide = wide || step == Step::Accumulated;
        let format = Format::Fixed { integer_bits: 6, fraction_bits };
        let operation = promise(&plant, 1.0);
        let deployed = deployed_linear(&plant, &l, &identity(plant.a.rows()), step, format.into(), &operation).expect("fits");
        // Coarse gains may not stabilise; then there is nothing to run.
        if deployed.ball().is_some() {
            let unit = 2.0_f64.powi(fraction_bits.cast_signed());
            let integers = |x: &[f64]| -> Vec<i64> { x.iter().map(|x| (x * unit) as i64).collect() };
            let s = &deployed.stored;
            run(&plant, &deployed, &operation, format, seed, &|xhat, u, y| {
                let terms = |m: &Matrix<f64>, i: usize, x: &[f64]| -> Vec<(i64, i64)> {
                    integers(m.row(i)).into_iter().zip(integers(x)).collect()
                };
                let z: Vec<f64> = match step {
                    Step::Joined => y.to_vec(),
                    Step::Innovation | Step::Accumulated => (0..y.len()).map(|k| y[k] - dot_fixed(&terms(&s.c, k, xhat), fraction_bits, wide) as f64 / unit).collect(),
                };
                (0..xhat.len()).map(|i| {
                    let all = [terms(&s.a, i, xhat), terms(&s.b, i, u), terms(&s.l, i, &z)].concat();
                    dot_fixed(&all, fraction_bits, wide) as f64 / unit
                }).collect()
            })?;
        }
    }

    /// Q4.4 and a double integrator: what is called stable has its eigenvalues inside the circle, by the closed form
    /// for order 2.
    #[test]
    fn a_gain_in_a_byte_is_never_proved_where_it_does_not_stabilise(h in 0.05..1.0_f64, l1 in 0.0..2.5_f64, l2 in 0.0..4.0_f64) {
        let plant = SampledPlant {
            a: Matrix::from_rows([[1.0, h], [0.0, 1.0]]),
            b: Matrix::from_rows([[0.0], [h]]),
            c: Matrix::from_rows([[1.0, 0.0]]),
        };
        let l = Matrix::from_rows([[l1], [l2]]);
        let byte = Format::Fixed { integer_bits: 4, fraction_bits: 4 };
        let (h, l1, l2) = (byte.round(h).unwrap(), byte.round(l1).unwrap(), byte.round(l2).unwrap());
        // Jury: F = [[1 - l1, h], [-l2, 1]], exact in binary64.
        let (trace, determinant) = (2.0 - l1, 1.0 - l1 + h * l2);
        let stable = determinant.abs() < 1.0 && trace.abs() < 1.0 + determinant;
        for p in [stein2([[1.0 - l1, h], [-l2, 1.0]]), Some(identity(2))].into_iter().flatten() {
            for step in [Step::Joined, Step::Innovation] {
                let deployed = deployed_linear(&plant, &l, &p, step, byte.into(), &promise(&plant, 0.5)).expect("fits");
                prop_assert!(stable || !deployed.is_stable(), "{deployed:?}");
                prop_assert!(stable || deployed.ball().is_none());
            }
        }
    }
}

/// The solution of `F'PF - P + I = 0` of order 2 by Cramer's rule, where there is one.
fn stein2(f: [[f64; 2]; 2]) -> Option<Matrix<f64>> {
    let [[a, b], [c, d]] = f;
    // Unknowns (p11, p12, p22).
    let m = [[a * a - 1.0, 2.0 * a * c, c * c], [a * b, a * d + b * c - 1.0, c * d], [b * b, 2.0 * b * d, d * d - 1.0]];
    let determinant = |m: [[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let all = determinant(m);
    let solved = |k: usize| {
        let mut replaced = m;
        for (row, right) in replaced.iter_mut().zip([-1.0, 0.0, -1.0]) {
            row[k] = right;
        }
        determinant(replaced) / all
    };
    let (p11, p12, p22) = (solved(0), solved(1), solved(2));
    [p11, p12, p22].iter().all(|x| x.is_finite()).then(|| Matrix::from_rows([[p11, p12], [p12, p22]]))
}

#[test]
fn gains_in_a_byte_are_decided_as_the_closed_form_says() {
    // All gains of a grid, before and after rounding: those that cease to stabilise are refuted, the others proved.
    let byte = Format::Fixed { integer_bits: 4, fraction_bits: 4 };
    let h = 0.1;
    let plant = SampledPlant {
        a: Matrix::from_rows([[1.0, h], [0.0, 1.0]]),
        b: Matrix::from_rows([[0.0], [h]]),
        c: Matrix::from_rows([[1.0, 0.0]]),
    };
    let stable = |h: f64, l1: f64, l2: f64| {
        let (trace, determinant) = (2.0 - l1, 1.0 - l1 + h * l2);
        determinant.abs() < 1.0 && trace.abs() < 1.0 + determinant
    };
    let (mut lost, mut kept) = (0, 0);
    let coarse = (0..40).map(|i| f64::from(i) * 0.0517 + 0.003);
    let near_the_edge = (0..20).map(|i| 2.0 + f64::from(i) * 0.003);
    for l1 in coarse.chain(near_the_edge) {
        for j in 0..20 {
            let l2 = f64::from(j) * 0.0471 + 0.002;
            let stored = [h, l1, l2].map(|x| byte.round(x).expect("in range"));
            let (before, after) = (stable(h, l1, l2), stable(stored[0], stored[1], stored[2]));
            lost += usize::from(before && !after);
            kept += usize::from(before && after);
            let l = Matrix::from_rows([[l1], [l2]]);
            // Where F has an eigenvalue 1 its equation has no solution, and any P will do.
            let p = stein2([[1.0 - stored[1], stored[0]], [-stored[2], 1.0]]).unwrap_or_else(|| identity(2));
            let deployed =
                deployed_linear(&plant, &l, &p, Step::Innovation, byte.into(), &promise(&plant, 0.5)).expect("fits");
            assert_eq!(deployed.is_stable(), after, "L = ({l1}, {l2}): {deployed:?}");
        }
    }
    assert!(lost > 40 && kept > 100, "{lost} lost, {kept} kept");
}

#[test]
fn the_ball_is_near_what_the_arithmetic_can_do() {
    // The state kept at its bounds by inputs of changing sign: the ratio of the bound to the error seen.
    let plant = SampledPlant {
        a: Matrix::from_rows([[0.6, 0.3], [-0.2, 0.7]]),
        b: Matrix::from_rows([[0.1], [0.1]]),
        c: Matrix::from_rows([[1.0, 0.3]]),
    };
    let l = Matrix::from_rows([[0.3], [0.1]]);
    let operation = promise(&plant, 1.0);
    let deployed =
        deployed_linear(&plant, &l, &identity(2), Step::Innovation, Format::Binary32.into(), &operation).expect("fits");
    let mut best = 0.0_f64;
    for seed in 0..200 {
        for order in ORDERS {
            let share = run(&plant, &deployed, &operation, Format::Binary32, seed, &|xhat, u, y| {
                single(&deployed, Step::Innovation, order, xhat, u, y)
            });
            best = best.max(share.expect("within the ball"));
        }
    }
    println!("f32: the largest error is 1/{:.1} of its bound", 1.0 / best);
    assert!(best > 0.05, "the bound is {} times the largest error of 1000 runs", 1.0 / best);
}

#[test]
fn a_gain_that_rounds_away_is_refuted() {
    // e+ = (1 - 0.02) e, and 0.02 is 0 in a byte.
    let number = |x: f64| Matrix::from_rows([[x]]);
    let plant = SampledPlant { a: number(1.0), b: Matrix::from_fn(1, 0, |_, _| 0.0), c: number(1.0) };
    let meets = promise(&plant, 1.0);
    let judged = |format: Format, step| {
        deployed_linear(&plant, &number(0.02), &number(1.0), step, format.into(), &meets).expect("fits")
    };
    let byte = Format::Fixed { integer_bits: 4, fraction_bits: 4 };
    for step in [Step::Joined, Step::Innovation] {
        let in_a_byte = judged(byte, step);
        assert!(in_a_byte.decrease.is_refuted() && !in_a_byte.is_stable(), "{in_a_byte:?}");
        assert_eq!(in_a_byte.running, Running::Unproved(NoErrorBallReason::NotStable));
        assert!(judged(Format::Binary32, step).is_stable());
        assert!(judged(Format::Fixed { integer_bits: 4, fraction_bits: 12 }, step).is_stable());
    }
    // A gain of 1.96 in a byte is 2: e+ = -e.
    let at_the_edge = deployed_linear(&plant, &number(1.98), &number(1.0), Step::Joined, byte.into(), &meets);
    assert!(!at_the_edge.expect("fits").is_stable());
}

#[test]
fn saturation_is_excluded_or_named() {
    let number = |x: f64| Matrix::from_rows([[x]]);
    let plant = SampledPlant { a: number(0.9), b: Matrix::from_fn(1, 0, |_, _| 0.0), c: number(2.0) };
    let byte = Format::Fixed { integer_bits: 4, fraction_bits: 4 };
    let judged = |bound| {
        deployed_linear(&plant, &number(0.2), &number(1.0), Step::Innovation, byte.into(), &promise(&plant, bound))
            .expect("fits")
    };
    let small = judged(0.9);
    assert!(small.ball().expect("in range").headroom <= 1.0, "{small:?}");
    // |y| is within the range, and the partial sums of y - C xhat are not: 2.0 * 2.0 + 2.0 * (2.0 + 2.0 + ..).
    let large = judged(2.0);
    assert!(large.is_stable());
    assert!(
        matches!(large.running, Running::Unproved(NoErrorBallReason::Range { size, limit, .. }) if size > limit && limit == 7.9375),
        "{large:?}"
    );
    // And the largest floats overflow.
    let huge = deployed_linear(
        &plant,
        &number(0.2),
        &number(1.0),
        Step::Innovation,
        Format::Binary32.into(),
        &promise(&plant, 1e38),
    );
    assert!(matches!(huge.expect("fits").running, Running::Unproved(NoErrorBallReason::Range { .. })));
}

#[test]
fn more_digits_make_the_ball_smaller_in_proportion() {
    let plant = SampledPlant {
        a: Matrix::from_rows([[0.6, 0.3], [-0.2, 0.7]]),
        b: Matrix::from_rows([[0.1], [0.1]]),
        c: Matrix::from_rows([[1.0, 0.3]]),
    };
    let l = Matrix::from_rows([[0.3], [0.1]]);
    let radius = |format: Format| {
        let deployed =
            deployed_linear(&plant, &l, &identity(2), Step::Innovation, format.into(), &promise(&plant, 1.0));
        deployed.expect("fits").ball().expect("proved").entries[0]
    };
    let ratio = radius(Format::Binary32) / radius(Format::Binary64);
    // The stored matrices are exact in binary64, and not in binary32: the units differ by 2^29, and mismatch comes on
    // top.
    assert!((2.0_f64.powi(28)..2.0_f64.powi(31)).contains(&ratio), "{ratio:e}");
    let fixed = |fraction_bits| radius(Format::Fixed { integer_bits: 8, fraction_bits });
    assert!((100.0..1000.0).contains(&(fixed(8) / fixed(16))), "{}", fixed(8) / fixed(16));
    // Coefficients with more digits than signals: less mismatch.
    let mixed = Formats {
        stored: Format::Fixed { integer_bits: 2, fraction_bits: 30 },
        running: Format::Fixed { integer_bits: 8, fraction_bits: 8 },
    };
    let deployed = deployed_linear(&plant, &l, &identity(2), Step::Innovation, mixed, &promise(&plant, 1.0));
    assert!(deployed.expect("fits").ball().expect("proved").entries[0] < fixed(8));
}

#[test]
fn the_stored_cubic_gain_is_proved_by_two_inequalities() {
    // P with C P^-1 C' = 1: N = -w P^-1 C' has C N = -w. Here P^-1 = [[1, 1/3], [1/3, 2/3]], w = 3.
    let plant = SampledPlant {
        a: Matrix::from_rows([[1.0, 0.1], [0.0, 1.0]]),
        b: Matrix::from_rows([[0.005], [0.1]]),
        c: Matrix::from_rows([[1.0, 0.0]]),
    };
    // F'PF - P = -h I for the poles 0.5 and 0.6, to three digits.
    let l = Matrix::from_rows([[0.9], [2.0]]);
    let p = Matrix::from_rows([[1.3, -0.35], [-0.35, 0.16]]);
    let determinant = 1.3 * 0.16 - 0.35 * 0.35;
    let n = Matrix::from_rows([[-3.0], [-3.0 * 0.35 / 0.16]]);
    let gains = CubicGains { n: n.clone(), theta: Matrix::from_rows([[10.0]]), w: 3.0, h: 0.1 };
    assert!(determinant > 0.0);
    let operation = promise(&plant, 1.0);
    for format in [Format::Binary32, Format::Binary64, Format::Fixed { integer_bits: 5, fraction_bits: 11 }] {
        let deployed = deployed_sampled_cubic(&plant, &l, &gains, &p, format.into(), &operation).expect("fits");
        assert!(deployed.is_stable(), "{deployed:?}");
        match format {
            Format::Fixed { .. } => {
                assert_eq!(deployed.running, Running::Unproved(NoErrorBallReason::RootInFixedPoint));
            }
            _ => assert!(deployed.ball().is_some(), "{deployed:?}"),
        }
    }
    // A gain of the wrong sign, or far too large for its w, is not proved.
    let c = &plant.c;
    assert!(saturated_decrease(&plant.a, c, &n, 3.0, &p).expect("fits").is_proved());
    assert!(saturated_decrease(&plant.a, c, &n.map(|x| -x), 3.0, &p).expect("fits").is_refuted());
    assert!(saturated_decrease(&plant.a, c, &n.map(|x| 3.0 * x), 3.0, &p).expect("fits").is_refuted());
    let wrong = CubicGains { n: n.map(|x| 3.0 * x), ..gains.clone() };
    assert!(
        !deployed_sampled_cubic(&plant, &l, &wrong, &p, Format::Binary32.into(), &operation).expect("fits").is_stable()
    );
    // w that rounds to zero.
    let small = CubicGains { w: 1e-3, ..gains };
    let byte = Format::Fixed { integer_bits: 6, fraction_bits: 4 };
    assert!(matches!(
        deployed_sampled_cubic(&plant, &l, &small, &p, byte.into(), &operation),
        Err(ProofError::Sign { value: 0.0, .. })
    ));
}

#[test]
fn bad_data_are_errors_with_their_numbers() {
    let number = |x: f64| Matrix::from_rows([[x]]);
    let plant = SampledPlant { a: number(0.9), b: Matrix::from_fn(1, 0, |_, _| 0.0), c: number(2.0) };
    let good = promise(&plant, 1.0);
    let judged = |l: f64, p: f64, format: Format, operation: &Operation| {
        deployed_linear(&plant, &number(l), &number(p), Step::Joined, format.into(), operation)
    };
    let byte = Format::Fixed { integer_bits: 4, fraction_bits: 4 };
    assert!(matches!(judged(f64::NAN, 1.0, byte, &good), Err(ProofError::NotFinite { what: "L", .. })));
    assert!(matches!(judged(0.1, f64::INFINITY, byte, &good), Err(ProofError::NotFinite { what: "P", .. })));
    assert!(matches!(judged(9.0, 1.0, byte, &good), Err(ProofError::OutOfRange { what: "L", largest: 7.9375, .. })));
    for (integer_bits, fraction_bits) in [(0, 8), (1, 0), (30, 30), (u32::MAX, u32::MAX)] {
        let format = Format::Fixed { integer_bits, fraction_bits };
        assert!(matches!(judged(0.1, 1.0, format, &good), Err(ProofError::Format { .. })), "{format:?}");
        assert_eq!((format.round(0.5), format.largest()), (None, 0.0));
    }
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        let operation = Operation { state: vec![bad], ..good.clone() };
        assert!(matches!(judged(0.1, 1.0, byte, &operation), Err(ProofError::Sign { .. })));
    }
    let operation = Operation { error: vec![], ..good.clone() };
    assert!(matches!(judged(0.1, 1.0, byte, &operation), Err(ProofError::DimensionMismatch { .. })));
    // A P that is not definite proves nothing; the largest allowed promises neither panic nor prove.
    assert!(!judged(0.1, -1.0, byte, &good).expect("fits").is_stable());
    let vast = Operation { state: vec![f64::MAX], error: vec![f64::MAX], ..good };
    assert!(judged(0.1, 1.0, Format::Binary64, &vast).expect("fits").ball().is_none());
    let empty = Matrix::from_fn(0, 0, |_, _| 0.0);
    let nothing = SampledPlant { a: empty.clone(), b: empty.clone(), c: empty.clone() };
    let none = Operation { state: vec![], input: vec![], noise: vec![], error: vec![], deviation: None };
    assert!(deployed_linear(&nothing, &empty, &empty, Step::Joined, byte.into(), &none).expect("fits").is_stable());
}

/// The multiple of 2^quantum nearest to `x 2^-scale`, ties to even, by integers: the oracle of the next test.
fn nearest(x: i128, scale: u32, quantum: i32) -> f64 {
    let cut = scale.cast_signed() + quantum;
    let unit = 1_i128 << cut;
    let (floor, rest) = (x.div_euclid(unit), x.rem_euclid(unit));
    let up = 2 * rest > unit || (2 * rest == unit && floor & 1 == 1);
    (floor + i128::from(up)) as f64 * 2.0_f64.powi(quantum)
}

#[test]
fn the_joined_matrix_is_rounded_once() {
    // A - LC = (1/2 + 2^-tie) + k 2^-scale with L = -1, C = k 2^-scale: just below, at and above the ties of each
    // format, closer than binary64 can tell.
    let fixed = |integer_bits, fraction_bits| Format::Fixed { integer_bits, fraction_bits };
    let formats = [
        (Format::Binary64, -53),
        (Format::Binary32, -24),
        (fixed(4, 4), -4),
        (fixed(2, 14), -14),
        (fixed(8, 24), -24),
        (fixed(2, 51), -51),
        (fixed(1, 52), -52),
    ];
    let number = |x: f64| Matrix::from_rows([[x]]);
    let mut twice = 0;
    for (format, quantum) in formats {
        for (tie, scale) in [(None, 57_u32), (Some(quantum - 1), 57), (Some(quantum - 1), 90), (Some(quantum), 90)] {
            for k in (1..64).flat_map(|k| [k, -k]) {
                // Numbers that A, in binary64, cannot be.
                if tie.is_some_and(|tie| tie < -53) {
                    continue;
                }
                let a = 0.5 + tie.map_or(0.0, |tie| 2.0_f64.powi(tie));
                let half = 1_i128 << (scale - 1);
                let exact = half + tie.map_or(0, |tie| 1_i128 << (scale.cast_signed() + tie)) + k;
                // Floating-point numbers below 1/2 are twice as close.
                let finer = i32::from(exact < half && !matches!(format, Format::Fixed { .. }));
                let expected = nearest(exact, scale, quantum - finer);
                let plant = SampledPlant {
                    a: number(a),
                    b: Matrix::from_fn(1, 0, |_, _| 0.0),
                    c: number(k as f64 * 2.0_f64.powi(-scale.cast_signed())),
                };
                let meets = promise(&plant, 0.25);
                let found = deployed_linear(&plant, &number(-1.0), &number(1.0), Step::Joined, format.into(), &meets)
                    .expect("fits");
                assert_eq!(found.stored.a[(0, 0)], expected, "{format}, tie {tie:?}, k = {k} of 2^-{scale}");
                twice += usize::from(format.round(a + plant.c[(0, 0)]) != Some(expected));
            }
        }
    }
    assert!(twice > 100, "by way of binary64 {twice} would have been the same");
}

proptest! {
    /// In one rounding or by the casts of the language: a binary64 number has one nearest.
    #[test]
    fn roundings_of_binary64_numbers_agree(
        x in prop_oneof![any::<u64>().prop_map(f64::from_bits), any::<u32>().prop_map(|x| f64::from(f32::from_bits(x))), -9.0..9.0_f64, (-4000..4000_i32).prop_map(|k| f64::from(k) / 512.0)],
        y in -9.0..9.0_f64,
        formats in (1..12_u32, 1..41_u32),
    ) {
        let fixed = Format::Fixed { integer_bits: formats.0, fraction_bits: formats.1 };
        for format in [Format::Binary32, Format::Binary64, fixed] {
            let exact = Exact::from_f64(x);
            prop_assert_eq!(exact.as_ref().and_then(|x| format.round_exact(x)), format.round(x));
            // Between two neighbours, the nearest of a sum is never further away than either rounding of its halves.
            let Some(sum) = exact.map(|x| x.add(&Exact::from_f64(y).expect("finite"))) else { continue };
            if let Some(nearest) = format.round_exact(&sum) {
                let distance = |z: f64| {
                    let difference = sum.sub(&Exact::from_f64(z).expect("finite"));
                    if difference.signum() < 0 { difference.neg() } else { difference }
                };
                for other in [sum.round_down(), sum.round_up()].into_iter().filter_map(|z| format.round(z)) {
                    prop_assert!(distance(nearest) <= distance(other), "{nearest:e} and {other:e}");
                }
            }
        }
    }
}

#[test]
fn a_sum_that_is_rounded_once_has_the_smaller_ball() {
    // xhat+ = 0.5 xhat + 0.25 u + 0.25 z, z = y - xhat, in Q4.8 with all numbers exact: e+ = 0.25 e - s - 0.25 (d + r)
    // with the roundings d of y, r of z (one product) and s of the estimate (three products, or one sum), each at most
    // q/2 = 2^-9.
    let number = |x: f64| Matrix::from_rows([[x]]);
    let plant = SampledPlant { a: number(0.5), b: number(0.25), c: number(1.0) };
    let q4_8 = Format::Fixed { integer_bits: 4, fraction_bits: 8 };
    let limit = |step| {
        let found = deployed_linear(&plant, &number(0.25), &number(1.0), step, q4_8.into(), &promise(&plant, 1.0));
        found.expect("fits").ball().expect("proved").entries[0]
    };
    let half = 2.0_f64.powi(-9);
    for (step, roundings) in [(Step::Innovation, 3.0), (Step::Accumulated, 1.0)] {
        let expected = (roundings + 0.25 * 2.0) * half / 0.75;
        assert!((expected..expected * (1.0 + 1e-9)).contains(&limit(step)), "{step:?}: {}", limit(step));
    }
}
