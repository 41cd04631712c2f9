//! beta by bounded nonlinear least squares beside the bracketed beta: where they agree, where least squares stops
//! short, and what is refused.

use luenberger_design::lpv::Polytope;
use luenberger_design::mean_value::{ContractingCoordinates, LeastSquares, MeanValueDesign, OutputCoordinates};
use luenberger_design::{DesignError, GainOptions, JacobianEnclosure};
use luenberger_observers::ObserverError;
use luenberger_observers::mean_value::beta::mean_value;
use luenberger_observers::mean_value::{Integral, MeanValueObserver};
use luenberger_plants::counterexamples::Dimple;
use luenberger_plants::{Chaotic, Differentiable, LinearPlant, Plant, StateSpace, flexible_joint};
use luenberger_proof::certificate::Theorem;
use luenberger_proof::{Interval, Matrix};
use nalgebra::{DMatrix, DVector, SMatrix, SVector, Vector1, Vector3, Vector4, dmatrix};
use proptest::prelude::*;

plant!(
    /// `x' = sqrt x`.
    Root,
    1,
    1,
    |_plant, x| [x[0].sqrt()],
    *x
);
plant!(
    /// y = x^2.
    Quadratic,
    1,
    1,
    |_plant, x| -x,
    [x[0] * x[0]]
);

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// The logarithm's slope is monotone along a segment of the chaotic plant, so that its root is unique: both find
    /// it. The rows of products are quadratic along e: X vanishes identically, and least squares stays where it
    /// started.
    #[test]
    fn where_the_root_is_unique_both_find_it(
        xhat in prop::array::uniform3(-2.0f64..2.0), e in prop::array::uniform3(-1.0f64..1.0),
    ) {
        let (xhat, e, u) = (Vector3::from(xhat), Vector3::from(e), SVector::zeros());
        let found = LeastSquares::new().solve(&Chaotic, 0.0, &xhat, &u, &e).unwrap();
        let bracketed = mean_value(&Chaotic, 0.0, &xhat, &u, &e);
        prop_assert!(found.beta.iter().all(|beta| (0.0..=1.0).contains(beta)));
        // Values of f are below 12.
        prop_assert!(found.residual.rows(1, 2).amax() <= 64.0 * 12.0 * f64::EPSILON, "{found:?}");
        // X is differenced to 1e-10 of its size and Newton's steps go on until the gradient is rounding: X falls below
        // 1e-9 of the rise at least.
        let rise = (Plant::<f64>::derivative(&Chaotic, 0.0, &(xhat + e), &u) - Plant::<f64>::derivative(&Chaotic, 0.0, &xhat, &u))[0].abs();
        prop_assert!(found.residual[0].abs() <= 1e-9 * rise.max(1e-3), "{found:?}");
        // A root of X is known as well as X is steep; the gradient, which is what the observer uses, is not sensitive
        // to it.
        prop_assert!((found.jacobian - bracketed.jacobian).amax() <= 1e-3, "{found:?} {bracketed:?}");
    }
}

/// A local minimum of X^2 with X = -1/24: least squares started in the middle stays there, the bracket does not, nor do
/// seven starts.
#[test]
fn least_squares_can_stop_where_x_is_not_zero() {
    let (xhat, u, e) = (Vector1::new(0.0), SVector::zeros(), Vector1::new(1.0));
    let stuck = LeastSquares::new().solve(&Dimple, 0.0, &xhat, &u, &e).unwrap();
    assert!((stuck.beta[0] - 0.5).abs() < 1e-6 && (stuck.residual[0] + 1.0 / 24.0).abs() < 1e-9, "{stuck:?}");
    let root = ((1.0 + (1.0f64 + 40.0 / 24.0).sqrt()) / 20.0).sqrt();
    let near = |beta: f64| ((beta - 0.5).abs() - root).abs() < 1e-7;
    let bracketed = mean_value(&Dimple, 0.0, &xhat, &u, &e);
    assert!(near(bracketed.beta[0]) && bracketed.residual[0].abs() < 1e-15, "{bracketed:?}");
    let many = LeastSquares::new().with_starts(7).solve(&Dimple, 0.0, &xhat, &u, &e).unwrap();
    assert!(near(many.beta[0]) && many.residual[0].abs() < 1e-9, "{many:?}");
}

/// Where the Jacobian does not exist on the segment, the state is named: at 0 the slope of the root is infinite, below
/// it there is none.
#[test]
fn a_jacobian_that_is_not_finite_is_named() {
    let u = SVector::zeros();
    let at = |xhat: f64, e: f64| LeastSquares::new().solve(&Root, 0.0, &Vector1::new(xhat), &u, &Vector1::new(e));
    let Err(DesignError::Observer(ObserverError::JacobianNotFinite { s, point, .. })) = at(0.0, 1.0) else { panic!() };
    assert_eq!((s, point.entries()), (0.0, &[0.0][..]));
    let Err(DesignError::Observer(error @ ObserverError::SlopeNotFinite { s: 1.0, row: 0, .. })) = at(0.25, -1.0)
    else {
        panic!()
    };
    assert!(error.to_string().contains("at the state [-0.75]"), "{error}");
    assert!(at(0.25, 1.0).is_ok());
}

#[test]
fn e_of_zero_is_an_ordinary_case() {
    let (plant, u) = (flexible_joint::classical(), Vector1::new(0.3));
    let found = LeastSquares::new().solve(&plant, 0.0, &Vector4::repeat(1.0), &u, &Vector4::zeros()).unwrap();
    assert_eq!((found.beta, found.residual), (Vector4::repeat(0.5), Vector4::zeros()));
    assert_eq!(found.jacobian, luenberger_plants::state_jacobian(&plant, 0.0, &Vector4::repeat(1.0), &u));
}

/// x1' = x2, x2' = -a x1 - x2 with a between 1 and 2, and the number 0.5 known to two units in the last place.
fn over(c: [f64; 2]) -> MeanValueDesign {
    let between = |lo, hi| Interval::new(lo, hi).unwrap();
    let half = between(0.5f64.next_down(), 0.5f64.next_up());
    let a = Matrix::from_rows([[between(0.0, 0.0), half], [between(-2.0, -1.0), between(-1.0, -1.0)]]);
    let c = Matrix::from_rows([c.map(|x| between(x, x))]);
    let enclosure = JacobianEnclosure { a, c, parts: 1, excess: 0.0, branches: None };
    MeanValueDesign::over(&Polytope::new(enclosure).unwrap(), 0.25, &GainOptions::default()).unwrap()
}

#[test]
fn an_enclosure_goes_into_the_theorem_with_all_its_intervals() {
    let design = over([1.0, 0.0]);
    assert!(design.certificate.is_proved() && design.vertices.len() == 2 && design.overshoot.is_finite());
    let Theorem::JacobianPolytope(theorem) = design.certificate.theorems()[0].theorem() else { panic!() };
    for vertex in &theorem.vertices {
        let half = vertex.a[(0, 1)].interval();
        assert!(half.lo() < 0.5 && half.hi() > 0.5, "{half:?}");
    }
}

/// The theorem speaks of C = [I 0]: whatever the gain, it is not one of a plant that measures something else.
#[test]
fn it_is_not_proved_where_the_outputs_are_not_the_first_states() {
    for c in [[0.0, 1.0], [1.0, 1e-9], [1.0f64.next_up(), 0.0]] {
        let design = over(c);
        assert!(!design.certificate.is_proved(), "{c:?}");
        assert!(design.overshoot.is_infinite());
    }
}

#[test]
fn bad_polytopes_are_refused() {
    assert_eq!(MeanValueDesign::new(&[], 1, 1.0).unwrap_err(), DesignError::NoVertices);
    let vertex = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
    assert!(matches!(MeanValueDesign::new(&[vertex.clone() * f64::NAN], 1, 1.0), Err(DesignError::Matrix(_))));
    assert!(matches!(
        MeanValueDesign::new(std::slice::from_ref(&vertex), 0, 1.0),
        Err(DesignError::OutputCount { .. })
    ));
    assert!(matches!(
        MeanValueDesign::new(std::slice::from_ref(&vertex), 1, f64::INFINITY),
        Err(DesignError::BadRate { .. })
    ));
    let design = MeanValueDesign::new(&[vertex], 1, 1.0).unwrap();
    let plant = flexible_joint::classical();
    assert!(matches!(design.observer(plant, 1.0, LeastSquares::new(), Vector4::zeros()), Err(DesignError::Matrix(_))));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// C T = [I 0], with the least condition there is; the plant in those coordinates has its outputs first, and the
    /// same motion.
    #[test]
    fn every_linear_output_of_full_rank_becomes_the_first_states(
        a in prop::array::uniform16(-2.0f64..2.0), c in prop::array::uniform8(-2.0f64..2.0), z in prop::array::uniform4(-2.0f64..2.0),
        smaller in -3.0f64..0.0, angle in 0.0f64..3.2, unit in prop::sample::select(vec![1e-6, 1.0, 1e9]),
    ) {
        // Singular values 1 and down to 1e-3, times the unit, by construction.
        let rows = SMatrix::<f64, 4, 2>::from_row_slice(&c).qr().q().transpose();
        let turn = nalgebra::Rotation2::new(angle).into_inner();
        let c = turn * nalgebra::Matrix2::from_diagonal(&nalgebra::Vector2::new(1.0, 10f64.powf(smaller))) * rows * unit;
        let sigma = c.svd(false, false).singular_values;
        let plant = LinearPlant { a: SMatrix::<f64, 4, 4>::from_row_slice(&a), b: SMatrix::<f64, 4, 0>::zeros(), c, d: None };
        let change = OutputCoordinates::of(&plant).unwrap();
        let condition = sigma[0] / sigma[1];
        prop_assert!((change.condition / condition - 1.0).abs() < 1e-6, "{} {condition}", change.condition);
        let residual = (&change.c * &change.t - DMatrix::identity(2, 4)).amax();
        prop_assert!(residual <= 64.0 * f64::EPSILON * condition, "{residual:e}");
        let other = change.plant(plant.clone()).unwrap();
        let svd = other.matrix().svd(false, false).singular_values;
        prop_assert!((svd[0] / svd[3] / condition - 1.0).abs() < 1e-6, "{svd}");
        let z = Vector4::from(z);
        prop_assert_eq!(Plant::<f64>::output(&other, 0.0, &z, &SVector::zeros()), z.fixed_rows::<2>(0).into_owned());
        let back = other.matrix() * Plant::<f64>::derivative(&other, 0.0, &z, &SVector::zeros());
        let scale = 1e3 * f64::EPSILON * condition * (other.matrix() * z).norm() * 8.0;
        prop_assert!((back - plant.a * (other.matrix() * z)).amax() <= scale);
        // Dual numbers go through: the Jacobian is T^-1 A T.
        let jacobian = other.state_jacobian(0.0, &z, &SVector::zeros());
        let expected = other.inverse() * plant.a * other.matrix();
        prop_assert!((jacobian - expected).amax() <= 1e3 * f64::EPSILON * condition * 8.0);
        prop_assert!(MeanValueObserver::new(other, 1.0, Integral, Vector4::zeros()).is_ok());
    }
}

#[test]
fn outputs_that_cannot_become_states_are_refused_with_numbers() {
    let deficient = dmatrix![1.0, 2.0, 3.0; 2.0, 4.0, 6.0];
    assert!(
        matches!(OutputCoordinates::of_matrix(&deficient), Err(DesignError::DependentOutputs { sigma_min }) if sigma_min < 1e-7)
    );
    let wide = DMatrix::identity(3, 2);
    assert!(matches!(OutputCoordinates::of_matrix(&wide), Err(DesignError::DependentOutputs { sigma_min: 0.0 })));
    assert!(matches!(OutputCoordinates::of_matrix(&(dmatrix![1.0, 2.0] * f64::NAN)), Err(DesignError::Matrix(_))));
    assert!(matches!(OutputCoordinates::of_matrix(&DMatrix::zeros(0, 2)), Err(DesignError::Matrix(_))));
    // One output of one state: a scale.
    let scale = OutputCoordinates::of_matrix(&dmatrix![4.0]).unwrap();
    assert!((scale.t[(0, 0)] - 0.25).abs() < 1e-16 && scale.condition == 1.0);
    // Nothing to do is said, and done exactly.
    let idle = OutputCoordinates::of(&flexible_joint::classical()).unwrap();
    assert_eq!(idle.t, DMatrix::identity(4, 4));
    assert!(idle.to_string().contains("already"), "{idle}");
    // Sizes known at run time.
    let plant = StateSpace::new(dmatrix![0.0, 1.0; 0.0, 0.0], DMatrix::zeros(2, 0), dmatrix![3.0, 4.0]).unwrap();
    let change = OutputCoordinates::of(&plant).unwrap();
    assert!(change.to_string().contains("of condition 1,"), "{change}");
    let other = change.plant(plant).unwrap();
    assert!(MeanValueObserver::new(other, 1.0, Integral, DVector::zeros(2)).is_ok());

    // C = 1/2 at 1/4; h(1) = 1.
    let refused = OutputCoordinates::of(&Quadratic).unwrap_err();
    let DesignError::NonlinearOutput { output: 0, expected, found, point } = refused else { panic!("{refused}") };
    assert_eq!((expected, found, point), (0.5, 1.0, vec![1.0]));
    let wrong =
        OutputCoordinates::of_matrix(&dmatrix![1.0, 1.0]).unwrap().plant(luenberger_plants::double_integrator());
    assert!(matches!(
        wrong,
        Err(DesignError::Matrix(luenberger_plants::PlantError::OutputNotCoordinate { output: 0, .. }))
    ));
}

/// The unmeasured block of a plant with unobservable unmeasured states cannot be made to contract, which is proved.
#[test]
fn what_no_coordinates_make_contracting_is_refuted() {
    let hidden = dmatrix![-1.0, 0.0; 1.0, 0.5];
    let refused = ContractingCoordinates::new(std::slice::from_ref(&hidden), 1, 0.0).unwrap_err();
    assert!(matches!(refused, DesignError::Infeasible { .. }), "{refused}");
    // Two vertices that each can be, but not both by one K and Q: the unmeasured state enters the measured row with
    // either sign.
    let signs = [dmatrix![0.0, 1.0; 0.0, 1.0], dmatrix![0.0, -1.0; 0.0, 1.0]];
    assert!(signs.iter().all(|vertex| ContractingCoordinates::new(std::slice::from_ref(vertex), 1, 0.0).is_ok()));
    assert!(matches!(ContractingCoordinates::new(&signs, 1, 0.0), Err(DesignError::Infeasible { .. })));
    assert_eq!(ContractingCoordinates::new(&[], 1, 0.0).unwrap_err(), DesignError::NoVertices);
    for outputs in [0, 2, 3] {
        let refused = ContractingCoordinates::new(std::slice::from_ref(&hidden), outputs, 0.0).unwrap_err();
        assert_eq!(refused, DesignError::NothingUnmeasured { states: 2, outputs });
    }
    assert!(matches!(ContractingCoordinates::new(&[hidden], 1, f64::NAN), Err(DesignError::BadRate { .. })));
}
