//! Lipschitz observers against closed forms: the greatest constant for one unmeasured state, and for a fixed gain the
//! H-infinity norm.

use approx::assert_abs_diff_eq;
use luenberger_design::lipschitz::{LipschitzDesign, LipschitzPlant, Sector, Split, greatest_factor};
use luenberger_design::{DesignError, InfeasibilityReason, JacobianEnclosure, Pair};
use luenberger_linalg::{lambda_min, place_observer};
use luenberger_lmi::proof_matrix;
use luenberger_plants::{Differentiable, flexible_joint};
use luenberger_proof::certificate::{Certificate, SectorConvergence, SectorTerm, Theorem, Vertex};
use luenberger_proof::{Interval, Matrix};
use nalgebra::{Complex, DMatrix, SVector, Vector1, Vector4, dmatrix};
use proptest::prelude::*;

const TOLERANCE: f64 = 1e-3;

fn joint(a44: f64) -> DMatrix<f64> {
    let mut a = DMatrix::from_column_slice(4, 4, flexible_joint::classical().linear_part().as_slice());
    a[(3, 3)] = a44;
    a
}

/// -3.33 sin(x3) in x4'.
fn sine(gamma: f64) -> Sector {
    Sector::structured(dmatrix![0.0; 0.0; 0.0; 1.0], dmatrix![0.0, 0.0, 1.0, 0.0], gamma)
}

/// `min over s >= 0 of |(A - s I) v|` for the last unit vector v.
fn distance(a: &DMatrix<f64>) -> f64 {
    let column = a.column(a.ncols() - 1);
    let along = column[a.ncols() - 1].max(0.0);
    (column.norm_squared() - along * along).max(0.0).sqrt()
}

/// `min over w of sigma_min(i w I - F)`, the reciprocal of the H-infinity norm of (sI - F)^-1, by a grid refined around
/// its minimum.
fn distance_to_the_axis(f: &DMatrix<f64>) -> f64 {
    let n = f.nrows();
    let sigma = |w: f64| {
        let real = DMatrix::from_fn(2 * n, 2 * n, |i, j| {
            let turn = if i % n == j % n { w } else { 0.0 };
            if i / n == j / n {
                -f[(i % n, j % n)]
            } else if i < n {
                -turn
            } else {
                turn
            }
        });
        lambda_min(&(real.transpose() * &real)).unwrap().max(0.0).sqrt()
    };
    // Beyond 2 |F| the distance exceeds |F|, which is no less than the one at w = 0.
    let (mut low, mut high) = (0.0, 2.0 * f.norm());
    for _ in 0..6 {
        let step = (high - low) / 200.0;
        let best = (0..=200).map(|k| low + step * f64::from(k)).min_by(|x, y| sigma(*x).total_cmp(&sigma(*y))).unwrap();
        (low, high) = ((best - 2.0 * step).max(0.0), best + 2.0 * step);
    }
    sigma(f64::midpoint(low, high))
}

fn square(n: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-2.0f64..2.0, n * n).prop_map(move |entries| DMatrix::from_row_slice(n, n, &entries))
}

/// As [`square`], of order 3, with the unmeasured third state seen through the first two: their coupling has length 0.2
/// at least.
fn coupled() -> impl Strategy<Value = DMatrix<f64>> {
    (square(3), 0.2f64..2.0, 0.0f64..std::f64::consts::TAU).prop_map(|(mut a, length, angle)| {
        (a[(0, 2)], a[(1, 2)]) = (length * angle.cos(), length * angle.sin());
        a
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    /// All states but one measured: the greatest constant over all gains is the distance, and one step beyond is
    /// refuted.
    #[test]
    fn with_one_unmeasured_state_the_greatest_constant_has_a_closed_form(a in (2usize..=4).prop_flat_map(square)) {
        let (n, expected) = (a.nrows(), distance(&a));
        let plant = LipschitzPlant::unstructured(a, DMatrix::identity(n - 1, n), 1.0).unwrap();
        match greatest_factor(&plant, None, 0.0, 8.0, TOLERANCE) {
            Ok(greatest) => {
                prop_assert!(greatest.design.certificate.is_proved());
                // What is proved is true, and the threshold lies within the bracket; a step back at the edge is allowed
                // for.
                prop_assert!(greatest.factor < expected && greatest.factor > expected - 4.0 * TOLERANCE,
                    "{} {expected}", greatest.factor);
                // The closed form is rounded, and the threshold itself is infeasible.
                let refuted_at = greatest.refuted_at.unwrap();
                prop_assert!(refuted_at >= expected * (1.0 - 1e-12) && refuted_at < expected + 8.0 * TOLERANCE,
                    "{refuted_at} {expected}");
            }
            Err(error) => prop_assert!(expected < 4.0 * TOLERANCE, "{error} {expected}"),
        }
    }

    /// For a gain that is given: the reciprocal of the H-infinity norm.
    #[test]
    fn for_a_fixed_gain_the_greatest_constant_is_the_distance_to_the_axis(
        a in coupled(), damping in 0.5f64..3.0, turn in 0.0f64..3.0,
    ) {
        let c = DMatrix::identity(2, 3);
        let poles = [Complex::new(-damping, turn), Complex::new(-damping, -turn), Complex::new(-1.0, 0.0)];
        let l = place_observer(&a, &c, &poles).unwrap().gain;
        let expected = distance_to_the_axis(&(&a - &l * &c));
        let plant = LipschitzPlant::unstructured(a, c, 1.0).unwrap();
        let greatest = greatest_factor(&plant, Some(&l), 0.0, 4.0, TOLERANCE).unwrap();
        prop_assert!(greatest.design.certificate.is_proved());
        prop_assert!(greatest.factor < expected * (1.0 + 1e-9), "{} {expected}", greatest.factor);
        prop_assert!(greatest.factor > expected - 4.0 * TOLERANCE, "{} {expected}", greatest.factor);
    }

    /// A slope in [low, high] is a Lipschitz condition about the middle: same P, same multiplier, same verdict, and the
    /// same greatest factor.
    #[test]
    fn a_sector_is_a_lipschitz_condition_about_its_middle(a in coupled(), middle in -2.0f64..2.0, radius in 0.1f64..1.0) {
        let (c, g, h) = (dmatrix![1.0, 0.0, 0.0; 0.0, 1.0, 0.0], dmatrix![0.0; 0.0; 1.0], dmatrix![0.0, 0.0, 1.0]);
        let slope = Sector::slope(g.clone(), h.clone(), middle - radius, middle + radius);
        let moved = &a + &g * &h * middle;
        let sector = LipschitzPlant::new(a, c.clone(), vec![slope]).unwrap();
        let centred = LipschitzPlant::new(moved, c, vec![Sector::structured(g, h, radius)]).unwrap();
        let greatest = |plant: &LipschitzPlant| greatest_factor(plant, None, 0.0, 2.0, 1e-2).unwrap();
        let (one, other) = (greatest(&sector), greatest(&centred));
        prop_assert!(one.design.certificate.is_proved() && other.design.certificate.is_proved());
        prop_assert!((one.factor - other.factor).abs() <= 2e-2, "{} {}", one.factor, other.factor);
    }
}

/// NOTES: "unstructured with constant 3.33: infeasible". For both plants and both outputs, with the greatest constant
/// beside it, which is 1: x4 enters x3' with the coefficient 1, and in units in which x4 weighs 1, adding 1 there hides
/// x4.
#[test]
fn the_flexible_joint_is_refuted_when_nothing_but_the_constant_is_used() {
    for (a44, outputs) in [(0.0, 2), (0.0, 3), (3.33, 2), (3.33, 3)] {
        let (a, c) = (joint(a44), DMatrix::identity(outputs, 4));
        let crude = LipschitzPlant::unstructured(a.clone(), c.clone(), 3.33).unwrap();
        let refused = LipschitzDesign::new(&crude, 0.0).unwrap_err();
        assert!(matches!(refused, DesignError::Infeasible { reason: InfeasibilityReason::Dual(_), .. }), "{refused}");
        let unit = LipschitzPlant::unstructured(a, c, 1.0).unwrap();
        let greatest = greatest_factor(&unit, None, 0.0, 4.0, TOLERANCE).unwrap();
        assert!(greatest.design.certificate.is_proved());
        // Two outputs of the printed plant: between 0.93 and 0.94. No closed form for two unmeasured states.
        let expected = if a44 > 0.0 && outputs == 2 { 0.934 } else { 1.0 };
        let bracket = (greatest.factor, greatest.refuted_at.unwrap());
        assert!(bracket.0 > expected - 8.0 * TOLERANCE && bracket.1 < expected + 8.0 * TOLERANCE, "{bracket:?}");
        assert!(bracket.0 < expected + 2.0 * TOLERANCE, "{bracket:?}");
    }
}

/// With its structure it is proved, and with x4 in units s the constant is 3.33 / s against a greatest one of s (three
/// outputs): s = 2 suffices, since 2 > sqrt 3.33.
#[test]
fn the_flexible_joint_is_proved_with_structure_and_in_other_units() {
    for (a44, outputs) in [(0.0, 2), (0.0, 3), (3.33, 2), (3.33, 3)] {
        let (a, c) = (joint(a44), DMatrix::identity(outputs, 4));
        let structured = LipschitzPlant::new(a.clone(), c.clone(), vec![sine(3.33)]).unwrap();
        let design = LipschitzDesign::new(&structured, 1.0).unwrap();
        assert!(design.certificate.is_proved(), "{}", design.certificate);
        for s in [2.0f64, 8.0, 64.0] {
            let scales = [1.0, 1.0, 1.0, s];
            let rescaled =
                LipschitzPlant::new(a.clone(), c.clone(), vec![Sector::rescaled(&scales, 3.33 / s)]).unwrap();
            let design = LipschitzDesign::new(&rescaled, 0.0).unwrap();
            assert!(design.certificate.is_proved());
            // The structured condition in disguise: the same P proves it, with tau / s^2.
            let g = Matrix::from_rows([[0.0], [0.0], [0.0], [1.0]]);
            let term = SectorTerm {
                g,
                h: Matrix::from_rows([[0.0, 0.0, 1.0, 0.0]]),
                low: -3.33,
                high: 3.33,
                tau: design.tau[0] / (s * s),
            };
            let Vertex { a, c } = Vertex::exactly(&proof_matrix(&a), &proof_matrix(&c)).unwrap();
            let (l, p) = (proof_matrix(&design.l), proof_matrix(&design.p));
            let theorem = SectorConvergence { a, c, terms: vec![term], l, p, rate: 0.0 };
            let certificate = Certificate::of([theorem]).unwrap();
            assert!(certificate.is_proved(), "{certificate}");
        }
    }
}

/// x4 in units s, three outputs: the greatest constant in those units is s, whatever a44 > 0 is, since column 4 of A is
/// (0, 0, s, a44) there.
#[test]
fn in_other_units_the_greatest_constant_is_another() {
    for s in [0.5, 2.0, 4.0] {
        let sector = Sector::rescaled(&[1.0, 1.0, 1.0, s], 1.0);
        let plant = LipschitzPlant::new(joint(3.33), DMatrix::identity(3, 4), vec![sector]).unwrap();
        let greatest = greatest_factor(&plant, None, 0.0, 8.0, TOLERANCE).unwrap();
        assert!(greatest.factor < s && greatest.factor > s - 8.0 * TOLERANCE, "{s}: {}", greatest.factor);
    }
}

/// With its structure there is no greatest constant: x3 is two integrations away from what is measured, and x4' another
/// one (two outputs), or x3 is measured itself (three), so that a gain high enough serves any constant. Proved up to
/// 10^4 times the plant's own.
#[test]
fn with_structure_the_joint_bears_any_constant() {
    for (a44, outputs) in [(0.0, 2), (0.0, 3), (3.33, 2), (3.33, 3)] {
        let plant = LipschitzPlant::new(joint(a44), DMatrix::identity(outputs, 4), vec![sine(3.33)]).unwrap();
        let greatest = greatest_factor(&plant, None, 0.0, 1e4, 1.0).unwrap();
        assert_eq!((greatest.factor, greatest.refuted_at), (1e4, None));
        assert!(greatest.design.certificate.is_proved(), "{}", greatest.design.certificate);
    }
}

/// x' = x^2 has the slope 2x: the split at 3 has A = 6, and the slope of the rest at 5 is 4.
#[test]
fn a_plant_is_split_at_a_point() {
    plant!(Square, 1, 1, |_plant, x| [x[0] * x[0] + (x[0] - x[0]).sqrt() * T::zero()], *x);
    fn differentiable<S: Differentiable<f64, nalgebra::U1, nalgebra::U0, nalgebra::U1>>(s: S) -> S {
        s
    }
    // The square root of 0 has no slope: its point is named.
    let error = Split::at(&differentiable(Square), 0.0, &Vector1::new(3.0), &SVector::zeros()).unwrap_err();
    assert!(error.to_string().contains("at the state [3.0]"), "{error}");
    let split = Split::at(&flexible_joint::printed(), 0.0, &Vector4::zeros(), &Vector1::zeros()).unwrap();
    assert_eq!(split.a[(3, 2)], -19.5 - 3.33);
    let slope = split.slope(&flexible_joint::printed(), 0.0, &Vector4::repeat(2.0), &Vector1::zeros()).unwrap();
    assert_abs_diff_eq!(slope[(3, 2)], 3.33 * (1.0 - 2f64.cos()), epsilon = 1e-14);
}

/// An entry that does not vary goes into the theorem as an interval. One that varies is a sector, about its middle
/// where that is far from 0.
#[test]
fn the_theorem_has_every_jacobian_of_an_enclosure() {
    let between = |lo, hi| Interval::new(lo, hi).unwrap();
    let third = between(1.0 / 3.0, (1.0 / 3.0f64).next_up());
    let a = Matrix::from_rows([[between(-1e6, -1e6), third], [between(-1.0, 1.0), between(-1e9 - 3.0, -1e9 + 1.0)]]);
    let of = |c: [Interval; 2]| {
        let c = Matrix::from_rows([c]);
        LipschitzPlant::over(&JacobianEnclosure { a: a.clone(), c, parts: 1, excess: 0.0, branches: None })
    };
    let c = [third, between(0.0, 0.0)];
    let design = LipschitzDesign::new(&of(c).unwrap(), 0.5).unwrap();
    assert!(design.certificate.is_proved());
    let theorem = design.certificate.theorems()[0].theorem();
    assert!(theorem.contains_jacobians(&a, &Matrix::from_rows([c])));
    let Theorem::SectorConvergence(sectors) = theorem else { panic!() };
    let ends: Vec<(f64, f64)> = sectors.terms.iter().map(|term| (term.low, term.high)).collect();
    assert_eq!(ends, [(-1.0, 1.0), (-2.0, 2.0)]);
    assert_eq!(sectors.a[(1, 1)].interval(), between(-1e9 - 1.0, -1e9 - 1.0));
    assert_eq!((sectors.a[(0, 1)].interval(), sectors.c[(0, 0)].interval()), (third, third));
    let varying = of([between(0.5, 1.0), between(0.0, 0.0)]).unwrap_err();
    assert_eq!(varying, DesignError::VaryingOutput { output: 0, state: 0, low: 0.5, high: 1.0 });
}

#[test]
fn bad_data_are_named() {
    let (a, c) = (joint(0.0), DMatrix::identity(2, 4));
    let new = |sector| LipschitzPlant::new(a.clone(), c.clone(), vec![sector]);
    let (g, h) = (dmatrix![0.0; 0.0; 0.0; 1.0], dmatrix![0.0, 0.0, 1.0, 0.0]);
    assert!(matches!(new(sine(f64::NAN)), Err(DesignError::BadSector { .. })));
    assert!(matches!(new(sine(-1.0)), Err(DesignError::BadSector { low: 1.0, high: -1.0, .. })));
    assert!(matches!(new(Sector::slope(g.clone(), DMatrix::identity(4, 4), 0.0, 1.0)), Err(DesignError::Matrix(_))));
    assert!(matches!(new(Sector::structured(DMatrix::zeros(3, 1), h, 1.0)), Err(DesignError::Matrix(_))));
    assert!(matches!(
        new(Sector::structured(DMatrix::zeros(4, 0), g.transpose(), 1.0)),
        Err(DesignError::BadSector { .. })
    ));
    assert!(matches!(new(Sector::rescaled(&[1.0, 0.0, 1.0, 1.0], 1.0)), Err(DesignError::Matrix(_))));
    let plant = new(sine(1.0)).unwrap();
    assert!(matches!(LipschitzDesign::new(&plant, -1.0), Err(DesignError::BadRate { .. })));
    assert!(matches!(greatest_factor(&plant, None, 0.0, 0.0, 1e-3), Err(DesignError::NotPositive { .. })));
    assert!(matches!(greatest_factor(&plant, None, 0.0, 1.0, f64::NAN), Err(DesignError::NotPositive { .. })));
    // The trace is positive: no rounding makes it Hurwitz.
    let pushing = -DMatrix::<f64>::identity(4, 2);
    assert!((&a - &pushing * &c).trace() > 0.5);
    assert!(matches!(LipschitzDesign::with_gain(&plant, &pushing, 0.0), Err(DesignError::NotHurwitz { .. })));
    let design = LipschitzDesign::new(&plant, 0.0).unwrap();
    assert!(matches!(design.observer(flexible_joint::printed()), Err(DesignError::Matrix(_))));
    let blind = LipschitzPlant::unstructured(dmatrix![1.0, 0.0; 0.0, 1.0], dmatrix![1.0, 0.0], 0.1).unwrap();
    let hidden = LipschitzDesign::new(&blind, 0.0);
    let Err(DesignError::OfPair { pair: Pair::MiddleOfSectors, error }) = hidden else { panic!("{hidden:?}") };
    assert!(matches!(*error, DesignError::NotDetectable { .. }), "{error}");
}
