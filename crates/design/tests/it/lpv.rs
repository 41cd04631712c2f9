//! The LPV design: known answers, reasons of infeasibility by name, units, and bad input.

use luenberger_design::lpv::{MAX_VARYING, Polytope, VaryingEntries, Vertex};
use luenberger_design::{DesignError, GainOptions, JacobianEnclosure, LpvDesign, LpvError, Region};
use luenberger_lmi::proof_matrix;
use luenberger_plants::{Chaotic, Plant, StateSpace, flexible_joint};
use luenberger_proof::{Interval, Matrix};
use luenberger_random::Random;
use nalgebra::{DMatrix, RealField, SVector, Vector1, Vector2, Vector3, Vector4, convert, dmatrix, dvector};

const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

fn number<T: RealField>(x: f64) -> T {
    convert(x)
}

// A pendulum with the speed in units of its own, and time too.
plant!(
    Pendulum { unit, pace },
    2,
    1,
    |s, x| Vector2::new(number::<T>(s.pace / s.unit) * x[1], number::<T>(-s.pace * s.unit) * x[0].sin()),
    Vector1::new(x[0])
);

// The same with the angle measured by its sine.
plant!(SineOfTheAngle {}, 2, 1, |s, x| Vector2::new(x[1], -x[0].sin()), Vector1::new(x[0].sin()));

// A spring that stiffens, lightly damped and not measured, beside a state that is.
plant!(
    Aside { damping },
    3,
    1,
    |s, x| {
        let force = -number::<T>(2.0) * x[0] - number::<T>(1.5) * x[0].sin();
        Vector3::new(x[1], force - number::<T>(s.damping) * x[1], -x[2])
    },
    Vector1::new(x[2])
);

plant!(Single {}, 1, 1, |s, x| Vector1::new(x[0] + number::<T>(0.5) * x[0].sin()), Vector1::new(x[0]));

// An unmeasured state that decays like exp(-2t) by itself, whatever the gain.
plant!(Slow {}, 2, 1, |s, x| Vector2::new(x[0].sin(), -number::<T>(2.0) * x[1]), Vector1::new(x[0]));

// Sixteen entries that vary.
plant!(
    Full {},
    4,
    1,
    |s, x| {
        let sum = x[0].sin() + x[1].sin() + x[2].sin() + x[3].sin();
        Vector4::new(sum, sum * number(2.0), sum * number(3.0), sum * number(4.0))
    },
    Vector1::new(x[0])
);

// Ten entries that vary, in a chain of which every second link is measured.
plant!(
    Chain {},
    4,
    2,
    |s, x| Vector4::new(
        x[1] + x[0].sin() + x[2].cos(),
        -x[1] + x[0].sin() * number(0.3) + x[1].sin() * number(0.5) + x[2].sin() + x[3].sin() * number(0.2),
        x[3] + x[2].sin() + x[0].tanh(),
        -x[3] + x[2].sin() * number(0.3) + x[3].sin() * number(0.5),
    ),
    Vector2::new(x[0], x[2])
);

// A coefficient that is a quotient, and so known to an interval only.
plant!(
    Quotient { stiffness, mass },
    2,
    1,
    |s, x| {
        let ratio = number::<T>(s.stiffness) / number::<T>(s.mass);
        Vector2::new(x[1], -ratio * x[0] - x[1].tanh())
    },
    Vector1::new(x[0])
);

#[test]
fn both_flexible_joints_have_a_gain_everywhere() {
    for rate in [0.0, 1.0, 5.0] {
        let classical = LpvDesign::new(flexible_joint::classical(), &Region::everywhere(4), rate).unwrap();
        let printed = LpvDesign::new(flexible_joint::printed(), &Region::everywhere(4), rate).unwrap();
        for (certificate, polytope, rates) in [
            (&classical.certificate, &classical.polytope, &classical.vertex_rates),
            (&printed.certificate, &printed.polytope, &printed.vertex_rates),
        ] {
            assert_eq!((polytope.vertices.len(), certificate.facts().count()), (2, 3));
            assert!(certificate.is_proved(), "{certificate}");
            assert!(rates.iter().all(|r| *r > rate), "{rates:?}");
        }
        assert_eq!(
            classical.vertex_rates[classical.limiting],
            classical.vertex_rates.iter().copied().fold(9e9, f64::min)
        );
        assert!(classical.sentence().unwrap().as_str().starts_with("From every x(0) and xhat(0)"));
        assert!(classical.stopped.is_none() && classical.overshoot >= 1.0);
    }
}

/// x1 multiplies x3 in the second row: where x1 can vanish x3 is not seen, and by itself it stays what it is.
#[test]
fn the_chaotic_plant_needs_x1_away_from_0() {
    for x1 in [(-3.0, 3.0), (-3.0, 2.0), (-0.3, 0.1), (0.0, 3.0)] {
        let region = Region::new(&[x1, (-3.0, 3.0), (-3.0, 3.0)]);
        for error in [
            LpvDesign::new(Chaotic, &region, 0.0).unwrap_err(),
            LpvDesign::max_rate(Chaotic, &region, 10.0, 0.1).unwrap_err(),
        ] {
            let LpvError::HiddenMode(mode) = &error else { panic!("{x1:?}: {error}") };
            assert!(mode.eigenvalue.norm() < 1e-9, "{error}");
            assert!((mode.direction[2].norm() - 1.0).abs() < 1e-9, "{error}");
            assert!((&mode.c * mode.direction.map(|v| v.re)).norm() < 1e-9);
            assert!(error.to_string().contains("along (0, 0, 1) is unobservable"), "{error}");
        }
    }
    for x1 in [(-3.0, -0.3), (0.3, 3.0)] {
        let region = Region::new(&[x1, (-3.0, 3.0), (-3.0, 3.0)]);
        let design = LpvDesign::new(Chaotic, &region, 0.5).unwrap();
        assert_eq!(design.polytope.vertices.len(), 64);
        assert!(design.certificate.is_proved());
        assert!(design.sentence().unwrap().as_str().contains(&format!("stay in the box (x1 in [{}, {}]", x1.0, x1.1)));
    }
}

#[test]
fn a_mode_of_its_own_limits_the_rate() {
    let region = Region::everywhere(2);
    assert!(LpvDesign::new(Slow {}, &region, 1.9).unwrap().certificate.is_proved());
    let error = LpvDesign::new(Slow {}, &region, 2.5).unwrap_err();
    let LpvError::HiddenMode(mode) = &error else { panic!("{error}") };
    assert!((mode.eigenvalue.re + 2.0).abs() < 1e-12 && mode.direction[1].norm() > 1.0 - 1e-12);
    let design = LpvDesign::max_rate(Slow {}, &region, 10.0, 1e-3).unwrap();
    assert!(design.rate < 2.0 && design.rate > 1.99 && design.certificate.is_proved(), "{}", design.rate);
    let (rate, why) = design.stopped.as_ref().unwrap();
    assert!(*rate - design.rate <= 1e-3 && matches!(**why, LpvError::HiddenMode(_)), "{design}");
}

/// Every spring between the two is stable, but switching between them pumps energy into a lightly damped one: no common
/// P. For a damping d and stiffnesses between a and b there is one iff d > sqrt b - sqrt a (circle criterion).
#[test]
fn vertices_that_exclude_each_other_are_named() {
    let (region, threshold) = (Region::everywhere(3), 3.5f64.sqrt() - 0.5f64.sqrt());
    let error = LpvDesign::new(Aside { damping: 0.99 * threshold }, &region, 0.0).unwrap_err();
    let LpvError::Conflict(conflict) = &error else { panic!("{error}") };
    assert!(conflict.is_pair && conflict.vertices == [0, 1], "{error}");
    assert!(error.to_string().contains("df2/dx1 = -3.5") && error.to_string().contains("df2/dx1 = -0.5"), "{error}");
    assert!(LpvDesign::new(Aside { damping: 1.01 * threshold }, &region, 0.0).unwrap().certificate.is_proved());
    let error = LpvDesign::certify(Aside { damping: 0.1 }, &region, &DMatrix::zeros(3, 1)).unwrap_err();
    assert!(matches!(&error, LpvError::Conflict(conflict) if conflict.vertices == [0, 1]), "{error}");
}

/// The gain that the paper takes from its reference [16], l42 read as 8.4967, on the joint as printed.
#[test]
fn a_given_gain_gets_its_greatest_rate() {
    let l = dmatrix![0.5409, -0.6315, 0.2392; -10.3506, 21.2355, 22.8782; 1.8370, 3.4444, 10.6638; 15.5282, 8.4967, 62.7550];
    let design = LpvDesign::certify(flexible_joint::printed(), &Region::everywhere(4), &l).unwrap();
    assert!(design.certificate.is_proved());
    assert!((3.0..3.02).contains(&design.rate), "{}", design.rate);
    // No rate beyond what the eigenvalues at a vertex allow, and none far below what the search was stopped at.
    let (stopped, why) = design.stopped.as_ref().unwrap();
    assert!(*stopped > design.rate && *stopped < design.rate * 1.01, "{why}");
    let error = LpvDesign::certify(flexible_joint::classical(), &Region::everywhere(4), &l).unwrap_err();
    assert!(matches!(error, LpvError::Design(DesignError::Matrix(_))), "{error}");
    let error =
        LpvDesign::certify(flexible_joint::printed(), &Region::everywhere(4), &DMatrix::zeros(4, 3)).unwrap_err();
    assert!(matches!(error, LpvError::UnstableVertex { abscissa, .. } if abscissa > 0.0), "{error}");
    let nan = l.map(|x| if x == 8.4967 { f64::NAN } else { x });
    assert!(LpvDesign::certify(flexible_joint::printed(), &Region::everywhere(4), &nan).is_err());
}

/// Units of 1e12 for the speed, or for time, change nothing but the numbers.
#[test]
fn units_do_not_matter() {
    for (unit, pace) in [(1.0, 1.0), (1e12, 1.0), (1e-12, 1.0), (1.0, 1e12), (1.0, 1e-12), (1e6, 1e-6)] {
        let design = LpvDesign::new(Pendulum { unit, pace }, &Region::everywhere(2), pace).unwrap();
        assert!(design.certificate.is_proved(), "{unit:e} {pace:e}: {}", design.certificate);
    }
}

/// The sine of the angle tells the angle as long as the cosine does not vanish, and C is a vertex matrix like A.
#[test]
fn nonlinear_outputs_are_vertices_too() {
    let design = LpvDesign::new(SineOfTheAngle {}, &Region::new(&[(-1.0, 1.0), ANY]), 0.5).unwrap();
    assert_eq!(design.polytope.vertices.len(), 4);
    assert!(design.certificate.is_proved());
    let values: Vec<f64> = design.polytope.vertices.iter().map(|vertex| vertex.c[(0, 0)]).collect();
    assert!(values.iter().any(|c| (c - 1f64.cos()).abs() < 1e-12) && values.contains(&1.0), "{values:?}");
    // At the angle pi/2 the output does not move.
    let error = LpvDesign::new(SineOfTheAngle {}, &Region::new(&[(-2.0, 2.0), ANY]), 0.0).unwrap_err();
    let LpvError::HiddenMode(mode) = &error else { panic!("{error}") };
    assert_eq!(mode.c[(0, 0)], 0.0);
}

#[test]
fn one_state_is_a_plant() {
    let design = LpvDesign::max_rate(Single {}, &Region::everywhere(1), 100.0, 1.0).unwrap();
    assert!(design.certificate.is_proved() && design.stopped.is_none() && design.rate == 100.0);
    assert!(design.l()[(0, 0)] > 101.5);
    assert!((1.0..1.0 + 1e-8).contains(&design.overshoot), "{:e}", design.overshoot);
    assert_eq!(design.excursion(&dvector![2.0]).unwrap().len(), 1);
    approx::assert_abs_diff_eq!(design.excursion(&dvector![2.0]).unwrap()[0], 2.0, epsilon = 1e-12);
    assert!(design.excursion(&dvector![2.0, 1.0]).is_none());
}

/// 0.3/0.7 is known to two units in the last place: that is no varying entry, and the proof is for the interval.
#[test]
fn rounded_coefficients_make_no_vertices() {
    let plant = Quotient { stiffness: 0.3, mass: 0.7 };
    let design = LpvDesign::new(plant, &Region::everywhere(2), 1.0).unwrap();
    assert_eq!(design.polytope.vertices.len(), 2);
    let entry = design.polytope.enclosure.a[(1, 0)];
    assert!(!entry.is_point() && entry.width() < 1e-15);
    assert!(design.certificate.is_proved());
}

#[test]
fn a_linear_plant_has_one_vertex() {
    let plant = StateSpace::new(dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]).unwrap();
    let design = LpvDesign::new(&plant, &Region::everywhere(2), 2.0).unwrap();
    assert_eq!(design.polytope.vertices.len(), 1);
    assert!(design.certificate.is_proved() && design.to_string().contains("the only vertex"));
}

#[test]
fn too_many_varying_entries_are_listed() {
    let error = LpvDesign::new(Full {}, &Region::everywhere(4), 1.0).unwrap_err();
    let LpvError::TooManyVertices { varying: 16, allowed: MAX_VARYING, entries } = &error else { panic!("{error}") };
    assert_eq!(entries.0.len(), 16);
    assert!(error.to_string().ends_with("df4/dx1, df4/dx2, df4/dx3, df4/dx4"), "{error}");
    // At a single point nothing varies.
    let point = Region::new(&[(0.0, 0.0); 4]);
    assert!(!matches!(LpvDesign::new(Full {}, &point, 0.0), Err(LpvError::TooManyVertices { .. })));
}

/// A thousand vertices are proved, though the solver saw a few of them.
#[test]
fn many_vertices_are_proved_one_by_one() {
    let region = Region::everywhere(4);
    let design = LpvDesign::new(Chain {}, &region, 0.1).unwrap();
    assert_eq!((design.polytope.vertices.len(), design.certificate.facts().count()), (1024, 1025));
    assert!(design.certificate.is_proved(), "{design}");
    assert!(
        design.to_string().contains("least of 1024 inequalities at the vertices, of which 1024 are proved"),
        "{design}"
    );
    let l = DMatrix::from_fn(4, 2, |i, j| design.l()[(i, j)]);
    let certified = LpvDesign::certify(Chain {}, &region, &l).unwrap();
    assert!(certified.certificate.is_proved() && certified.rate > 0.1, "{certified}");
}

#[test]
fn bad_numbers_are_refused() {
    let (plant, region) = (flexible_joint::classical(), Region::everywhere(4));
    for rate in [f64::NAN, -1.0, f64::INFINITY] {
        assert!(matches!(
            LpvDesign::new(plant, &region, rate).unwrap_err(),
            LpvError::Design(DesignError::BadRate { .. })
        ));
    }
    for (ceiling, tolerance) in
        [(0.0, 0.1), (f64::NAN, 0.1), (f64::INFINITY, 0.1), (1.0, 0.0), (1.0, f64::NAN), (1.0, -1.0)]
    {
        assert!(matches!(
            LpvDesign::max_rate(plant, &region, ceiling, tolerance),
            Err(LpvError::Design(DesignError::NotPositive { .. }))
        ));
    }
    for region in [Region::everywhere(3), Region::new(&[(f64::NAN, 1.0); 4]), Region::new(&[(2.0, 1.0); 4])] {
        assert!(matches!(LpvDesign::new(plant, &region, 1.0).unwrap_err(), LpvError::Enclosure(_)));
    }
}

// A spring without a linear part: at rest its stiffness is 0, of which an outward rounding leaves 1.5e-323.
plant!(CubicSpring {}, 2, 1, |s, x| Vector2::new(x[1], -x[0].powi(3)), Vector1::new(x[0]));

/// The rate 1 is possible, and so is more with a given gain.
#[test]
fn an_entry_that_is_0_up_to_rounding_hides_nothing() {
    let region = Region::new(&[(-1.0, 1.0), (-1.0, 1.0)]);
    let design = LpvDesign::new(CubicSpring {}, &region, 1.0).unwrap();
    assert!(design.certificate.is_proved(), "{design}");
    let end = design.polytope.enclosure.a[(1, 0)].hi();
    assert!((0.0..1e-300).contains(&end), "{end:e}");
    let design = LpvDesign::certify(CubicSpring {}, &region, &dmatrix![7.0; 12.0]).unwrap();
    assert!(design.certificate.is_proved() && design.rate > 2.8, "{design}");
    assert!(design.to_string().starts_with("L = [7; 12]\n"), "{design}");
}

/// The witness of a hidden mode is exact, and checked against the pair it speaks of.
#[test]
fn a_hidden_mode_carries_its_subspace() {
    let error = LpvDesign::new(Slow {}, &Region::everywhere(2), 2.5).unwrap_err();
    let LpvError::HiddenMode(mode) = &error else { panic!("{error}") };
    assert!(mode.witness.is_of(&proof_matrix(&mode.a), &proof_matrix(&mode.c)).unwrap());
    assert_eq!((mode.witness.decays_at(2.5), mode.witness.decays_at(1.9)), (Some(false), Some(true)));
}

/// `x' = M x + R sin x` in units `d`, component by component: entry (i, j) of Df is anything between `m - r` and
/// `m + r`, times `d_i / d_j`. The first state is measured.
#[derive(Debug, Clone)]
struct Hull {
    m: DMatrix<f64>,
    r: DMatrix<f64>,
}

luenberger_plants::plant!(
    Hull,
    (3, 0, 1),
    |plant, t, x, u| SVector::<T, 3>::from_fn(|i, _| {
        (0..3).fold(T::zero(), |sum, j| {
            let (m, r) = (plant.m[(i, j)], plant.r[(i, j)]);
            let linear = if m == 0.0 { sum } else { sum + number::<T>(m) * x[j] };
            if r == 0.0 { linear } else { linear + number::<T>(r) * x[j].sin() }
        })
    }),
    [x[0]]
);

/// A hull whose unmeasured block decays by itself faster than `exp(-0.1 t)` for P = I, if `decays`: then a large gain
/// on the measured state serves all of it. Else its last state is not seen where an entry is 0, and grows. Units
/// between 1e-12 and 1e12, entries down to 1e-320.
fn hull(random: &mut Random, decays: bool) -> Hull {
    let (mut m, mut r) = (DMatrix::zeros(3, 3), DMatrix::zeros(3, 3));
    for k in 0..9 {
        m[(k / 3, k % 3)] = random.unit();
    }
    for k in [0, 1, 2, 3, 5] {
        if random.unit() > 0.0 {
            r[(k / 3, k % 3)] = random.unit().abs();
        }
    }
    if random.unit() > 0.0 {
        m[(1, 2)] = 1e-320;
        r[(1, 2)] = 0.0;
    }
    for i in 1..3 {
        let across = m[(1, 2)].abs() + r[(1, 2)] + m[(2, 1)].abs() + r[(2, 1)];
        m[(i, i)] = -0.2 - across - random.unit().abs();
        r[(i, i)] = 0.0;
    }
    if !decays {
        // Seen through (0, 2) and (1, 2) only, whose intervals contain 0.
        (m[(2, 0)], m[(2, 1)], m[(2, 2)], r[(2, 0)]) = (0.0, 0.0, 0.5 * random.unit().abs(), 0.0);
        for i in 0..2 {
            (m[(i, 2)], r[(i, 2)]) = (0.0, random.unit().abs() * if random.unit() > 0.5 { 1e-310 } else { 1.0 });
        }
    }
    let units: Vec<f64> = (0..3).map(|_| 10f64.powf(12.0 * random.unit())).collect();
    let scaled = |x: &DMatrix<f64>| DMatrix::from_fn(3, 3, |i, j| x[(i, j)] * (units[i] / units[j]));
    Hull { m: scaled(&m), r: scaled(&r) }
}

/// No gain is said not to exist where one does, and none is proved where a mode is hidden, whatever the units and
/// however small the entries.
#[test]
fn what_is_known_by_construction_is_not_contradicted() {
    let mut random = Random(20_260_101);
    let mut proved = 0;
    for case in 0..80 {
        let plant = hull(&mut random, true);
        match LpvDesign::new(plant.clone(), &Region::everywhere(3), 0.1) {
            Ok(design) => proved += usize::from(design.certificate.is_proved()),
            Err(LpvError::Design(DesignError::Undecided { .. } | DesignError::Linalg(_))) => {}
            Err(error) => panic!("case {case}: {error}\n{plant:?}"),
        }
        let plant = hull(&mut random, false);
        match LpvDesign::new(plant.clone(), &Region::everywhere(3), 0.1) {
            Ok(design) => assert!(!design.certificate.is_proved(), "case {case}: {design}\n{plant:?}"),
            Err(
                LpvError::HiddenMode(_)
                | LpvError::Conflict(_)
                | LpvError::Design(DesignError::Undecided { .. } | DesignError::Linalg(_)),
            ) => {}
            Err(error) => panic!("case {case}: {error}\n{plant:?}"),
        }
    }
    assert!(proved >= 60, "{proved} of 80");
}

// A spring with a kink at x1 = -0.5 and, beyond x1 = 0.5, a push: with it f jumps, without it f is continuous.
plant!(
    KinkedSpring { push },
    2,
    1,
    |s, x| {
        let kink = if x[0] < number(-0.5) { x[0] + number(0.5) } else { T::zero() };
        let push = if x[0] > number(0.5) { number::<T>(s.push) } else { T::zero() };
        Vector2::new(x[1], push - kink - x[0] - x[1] * number(0.1))
    },
    Vector1::new(x[0])
);

/// The bound holds for the plant without a jump, simulated from many starts; the plant with one, for which it fails,
/// gets no bound.
#[test]
fn a_jump_gets_no_bound_and_a_kink_keeps_to_it() {
    let region = Region::new(&[(-2.0, 2.0), (-2.0, 2.0)]);
    for push in [0.5, 1e-3] {
        let error = LpvDesign::new(KinkedSpring { push }, &region, 1.0).unwrap_err();
        assert!(matches!(error, LpvError::Enclosure(_)), "{push}: {error}");
    }
    let plant = KinkedSpring { push: 0.0 };
    let design = LpvDesign::new(plant, &region, 1.0).unwrap();
    assert!(design.certificate.is_proved());
    assert!(
        design.sentence().unwrap().as_str().contains("provided that f and h are continuous where they change branches"),
        "{}",
        design.sentence().unwrap().as_str()
    );
    // The observer of the plant that jumps, with the same gain: the bound of the continuous one is not its.
    let run = |push: f64, x0: Vector2<f64>, z0: Vector2<f64>| {
        let (plant, l) = (KinkedSpring { push }, design.l());
        let none = SVector::<f64, 0>::zeros();
        let slope = |x: &Vector2<f64>, z: &Vector2<f64>| {
            (plant.derivative(0.0, x, &none), plant.derivative(0.0, z, &none) + l * (x[0] - z[0]))
        };
        let (mut x, mut z, h, mut worst) = (x0, z0, 1e-3, 0.0f64);
        for step in 1..=8000 {
            let (a, b) = slope(&x, &z);
            let (c, d) = slope(&(x + a * (0.5 * h)), &(z + b * (0.5 * h)));
            (x, z) = (x + c * h, z + d * h);
            let inside = x.amax() <= 2.0 && z.amax() <= 2.0;
            if !inside {
                break;
            }
            let bound = design.overshoot * (x0 - z0).norm() * (-design.rate * h * f64::from(step)).exp();
            worst = worst.max((x - z).norm() / bound);
        }
        worst
    };
    let mut random = Random(7);
    for _ in 0..40 {
        let mut start = || Vector2::new(random.unit(), random.unit());
        let (x0, z0) = (start(), start());
        let worst = run(0.0, x0, z0);
        assert!(worst <= 1.0 + 1e-3, "{worst} from {x0} and {z0}");
    }
    assert!(run(0.5, Vector2::new(0.5 + 1e-9, 0.0), Vector2::new(0.5 - 1e-9, 0.0)) > 1e4);
}

/// `[-1, kappa; 0, -1]` turned by 0, 120 and 240 degrees, beside a state that is measured. If a P serves all three,
/// so does its mean over the turns, a multiple of the identity; hence kappa < 2 is needed. Two of them alone allow
/// more.
fn turned(kappa: f64) -> Polytope {
    let vertex = |k: u32| {
        let (s, c) = (f64::from(k) * std::f64::consts::TAU / 3.0).sin_cos();
        let turn = dmatrix![c, -s, 0.0; s, c, 0.0; 0.0, 0.0, 1.0];
        let a = dmatrix![-1.0, kappa, 0.0; 0.0, -1.0, 0.0; 0.0, 0.0, -1.0];
        Vertex { a: &turn * a * turn.transpose(), c: dmatrix![0.0, 0.0, 1.0], at: Vec::new() }
    };
    let vertices: Vec<Vertex> = (0..3).map(vertex).collect();
    let hull = |i: usize, j: usize| {
        let entries = vertices.iter().map(|v| v.a[(i, j)]);
        let (lo, hi) = entries.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        Interval::new(lo, hi).unwrap()
    };
    let a = Matrix::from_fn(3, 3, hull);
    let c = Matrix::from_fn(1, 3, |_, j| Interval::new(vertices[0].c[j], vertices[0].c[j]).unwrap());
    let enclosure = JacobianEnclosure { a, c, parts: 1, excess: 0.0, branches: None };
    Polytope { enclosure, varying: VaryingEntries(Vec::new()), vertices }
}

#[test]
fn three_vertices_of_which_no_two_exclude_each_other() {
    let options = GainOptions::default();
    assert!(turned(1.9).common_gain(0.0, &options).is_ok());
    let polytope = turned(2.1);
    let error = polytope.common_gain(0.0, &options).unwrap_err();
    let LpvError::Conflict(conflict) = &error else { panic!("{error}") };
    assert!(!conflict.is_pair && conflict.vertices == [0, 1, 2], "{error}");
    assert!(error.to_string().starts_with("LMI infeasible at decay rate 0; conflicting vertices: 1 ("));
    // Two of them are possible without the third.
    let mut pair = polytope;
    pair.vertices.pop();
    assert!(pair.common_gain(0.0, &options).is_ok());
}
