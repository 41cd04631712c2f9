//! KKL candidates over boxes, and Proposition 7's hypotheses along a run: known answers, both kinds of refutation, and
//! bad input.

use luenberger_design::enclosure::EnclosureError;
use luenberger_design::kkl::{KklError, KklReport, KklSettings};
use luenberger_design::kkl_peb::{Excite, SampledRun};
use luenberger_design::{DesignError, KklCandidate, KklDesign, KklPebDesign, Region};
use luenberger_linalg::sylvester;
use luenberger_observers::cascade::Cascade;
use luenberger_observers::estimator::gradient::Gradient;
use luenberger_observers::{KklMap, KklPebObserver, Observer, ObserverDimensions};
use luenberger_plants::{CukConverter, Dimensions, ExponentialCascade, Plant, PlantError, Shape, StateSpace};
use luenberger_proof::Verdict;
use luenberger_proof::certificate::{Certified, verify};
use nalgebra::{
    DMatrix, DVector, Dyn, Matrix1, Matrix2, RealField, SVector, U1, U2, Vector1, Vector2, convert, dmatrix,
};
use proptest::prelude::*;

fn number<T: RealField>(x: f64) -> T {
    convert(x)
}

fn settings() -> KklSettings {
    KklSettings::default()
}

/// The maps of Proposition 6, phi = (x2, x3), Lambda = diag(-1, 0) and `B = (square y^2 + sine sin y, u y + 1/(y^2 +
/// 1))`, where both factors are to be 1.
#[derive(Debug, Clone, Copy)]
struct Sixth {
    square: f64,
    sine: f64,
}

const SIXTH: Sixth = Sixth { square: 1.0, sine: 1.0 };
const WRONG_SIGN: Sixth = Sixth { sine: -1.0, ..SIXTH };

impl<T: RealField + Copy> KklMap<T> for Sixth {
    type Xi = U2;
    type Inputs = U1;
    type Outputs = U1;
    type Estimate = U2;
    fn lambda(&self, _t: T, _u: &Vector1<T>, _y: &Vector1<T>) -> Matrix2<T> {
        Matrix2::from_diagonal(&Vector2::new(-T::one(), T::zero()))
    }
    fn injection(&self, _t: T, _xi: &Vector2<T>, u: &Vector1<T>, y: &Vector1<T>) -> Vector2<T> {
        let square = y[0] * y[0];
        let first = square * number(self.square) + y[0].sin() * number(self.sine);
        Vector2::new(first, u[0] * y[0] + T::one() / (square + T::one()))
    }
    fn left_inverse(&self, _t: T, xi: &Vector2<T>, _y: &Vector1<T>) -> Vector2<T> {
        *xi
    }
    fn image(&self, _t: T, xhat: &Vector2<T>, _y: &Vector1<T>) -> Vector2<T> {
        *xhat
    }
}

fn sixth() -> Region {
    Region::new(&[(-2.0, 2.0), (-3.0, 3.0), (-1.0, 1.0)]).inputs(&[(-2.0, 2.0)])
}

/// phi = (x2, x3), Lambda = diag(-1, 0) and the printed B: both sides of (4) are the same polynomials in the same
/// atoms, and nothing is left.
#[test]
fn proposition_6_is_proved_on_a_box() {
    let report = KklCandidate::new(&ExponentialCascade, &SIXTH, &[1, 2]).unwrap().check(&sixth(), &settings()).unwrap();
    let KklReport { residual, stability, coupling, injectivity, left_inverse } = &report;
    assert!(coupling.verdict.is_proved() && coupling.reads.is_empty());
    assert_eq!((residual.bounds.as_slice(), residual.parts, residual.collected), ([0.0, 0.0].as_slice(), 1, Ok(())));
    assert!(residual.verdict.is_proved());
    // |x2| is 3 and B has x1^2 + sin x1 = 4.9 at most, and the two sides are counted.
    assert!(residual.scales[0] > 6.0 && residual.scales[0] < 16.0, "{:?}", residual.scales);
    // (x2, x3, x1) is a permutation: an affine Phi has the margin 1, of which the prover gives away a part in 1e12.
    let margin = injectivity.verdict.margin().unwrap();
    assert!(margin > 1.0 - 1e-11, "{margin:e}");
    assert!(
        (injectivity.smallest_ratio - 1.0).abs() < 1e-12 && (injectivity.smallest_singular_value - 1.0).abs() < 1e-12
    );
    assert_eq!(left_inverse.as_ref().unwrap().0, 0.0);
    assert!(stability.is_proved() && stability.integrated == [1] && stability.certificate.facts().count() == 3);
    assert_eq!(stability.diagonal.as_ref().unwrap()[0].lo(), -1.0);
    let file = stability.certificate_file("the part that forgets").unwrap().to_json();
    assert_eq!(verify(file.as_bytes()).unwrap().facts[1].inequality, "A'P + PA < 0");
    // The integrated entry is for a parameter estimator: this is no KKLO.
    assert!(!report.is_proved());
    let refused = KklDesign::new(&ExponentialCascade, SIXTH, &[1, 2], &sixth(), &settings());
    assert!(matches!(refused, Err(KklError::NotHurwitz { what: "Lambda", eigenvalue }) if eigenvalue.re == 0.0));
}

#[test]
fn a_wrong_sign_is_refuted_at_a_point() {
    let candidate = KklCandidate::new(&ExponentialCascade, &WRONG_SIGN, &[1, 2]).unwrap();
    let report = candidate.check(&sixth(), &settings()).unwrap();
    let Verdict::Refuted { witness } = &report.residual.verdict else { panic!("{report}") };
    // The residual is 2 sin x1 in row 1, by hand; the enclosure of a point is a few roundings of the terms, 16 at most,
    // wide.
    let truth = 2.0 * witness.place.state[0].sin().abs();
    assert_eq!(witness.row, 0);
    assert!(witness.at_least <= truth * (1.0 + 1e-15) && witness.at_least > truth - 1e-13, "{truth} {witness}");
    // |x1| = pi/2 has the largest, 2, and 300 points see it to a percent.
    assert!(truth > 1.98 && report.residual.bounds[0] >= 2.0, "{:?}", report.residual);
    assert!(report.residual.bounds[1] == 0.0);
    let refused = KklDesign::new(&ExponentialCascade, WRONG_SIGN, &[1, 2], &sixth(), &settings());
    assert!(matches!(refused, Err(KklError::NotASolution(worst)) if worst == *witness));
    assert!(report.to_string().contains("Refuted"));
}

/// `x' = -x, y = g(x)`, with phi = g: `Dphi f = -x g'(x)`.
#[derive(Debug, Clone, Copy)]
enum Scalar {
    /// g = x^2, Lambda = -2.
    Square,
    /// g = x |x|, Lambda = -2.
    SignedSquare,
    /// g = x^3, Lambda = -3.
    Cube,
    /// g = ln x, B = -1 and Lambda = 0 to -1: `Dphi f = -1`.
    Logarithm,
    /// g = x, Lambda = -(1 + u^2), B = u^2 y.
    Varying,
    /// g = x, Lambda = +1, B = -2 y.
    Unstable,
}

impl Scalar {
    fn g<T: RealField + Copy>(self, x: T) -> T {
        match self {
            Self::Square => x * x,
            Self::SignedSquare => x * x.abs(),
            Self::Cube => x * x * x,
            Self::Logarithm => x.ln(),
            Self::Varying | Self::Unstable => x,
        }
    }
}

luenberger_plants::plant!(Scalar, (1, 1, 1), |plant, t, x, u| -x, [plant.g(x[0])]);

impl<T: RealField + Copy> KklMap<T> for Scalar {
    type Xi = U1;
    type Inputs = U1;
    type Outputs = U1;
    type Estimate = U1;
    fn lambda(&self, _t: T, u: &Vector1<T>, _y: &Vector1<T>) -> Matrix1<T> {
        Matrix1::new(match self {
            Self::Square | Self::SignedSquare => number(-2.0),
            Self::Cube => number(-3.0),
            Self::Logarithm => number(-1.0),
            Self::Varying => -(T::one() + u[0] * u[0]),
            Self::Unstable => T::one(),
        })
    }
    fn injection(&self, _t: T, _xi: &Vector1<T>, u: &Vector1<T>, y: &Vector1<T>) -> Vector1<T> {
        Vector1::new(match self {
            Self::Logarithm => y[0] - T::one(),
            Self::Varying => u[0] * u[0] * y[0],
            Self::Unstable => -(y[0] + y[0]),
            _ => T::zero(),
        })
    }
    fn left_inverse(&self, _t: T, xi: &Vector1<T>, _y: &Vector1<T>) -> Vector1<T> {
        Vector1::new(match self {
            Self::Square => xi[0].sqrt(),
            Self::Logarithm => xi[0].exp(),
            _ => xi[0],
        })
    }
    fn image(&self, _t: T, xhat: &Vector1<T>, _y: &Vector1<T>) -> Vector1<T> {
        Vector1::new(self.g(xhat[0]))
    }
}

fn scalar(plant: Scalar, lo: f64, hi: f64) -> Result<KklReport, KklError> {
    let region = Region::new(&[(lo, hi)]).inputs(&[(-1.0, 1.0)]);
    KklCandidate::new(&plant, &plant, &[0])?.check(&region, &settings())
}

/// y = x^2 does not know the sign of x: (4) holds, and no left inverse does.
#[test]
fn an_even_output_is_not_injective() {
    let report = scalar(Scalar::Square, -1.0, 1.0).unwrap();
    assert_eq!(report.residual.bounds, [0.0]);
    assert!(report.stability.is_proved());
    let Verdict::Refuted { witness } = &report.injectivity.verdict else { panic!("{report}") };
    // Two states of opposite sign: by the symmetry of the square, exactly.
    assert!(witness.second[0].is_point() && witness.second[0].lo() == -witness.first[0] && witness.first[0] != 0.0);
    let pair = report.injectivity.near_collision.as_ref().unwrap();
    assert!((pair.first[0] + pair.second[0]).abs() < 1e-7 && pair.distance > 0.2, "{pair:?}");
    let direct = (pair.first[0].powi(2) - pair.second[0].powi(2)).abs() * 2f64.sqrt();
    assert!(direct <= pair.gap * (1.0 + 1e-9) + 1e-15, "{direct} {pair:?}");
    let region = Region::new(&[(-1.0, 1.0)]).inputs(&[(0.0, 0.0)]);
    let refused = KklDesign::new(&Scalar::Square, Scalar::Square, &[0], &region, &settings());
    assert!(matches!(refused, Err(KklError::NotInjective(_))));
    // Where x > 0 it is injective, and phi^L is right there.
    let report = scalar(Scalar::Square, 0.1, 1.0).unwrap();
    assert!(report.is_proved(), "{report}");
    // M J is x over the middle of [0.1, 1]: at least 0.1/0.55.
    let margin = report.injectivity.verdict.margin().unwrap();
    assert!(margin <= 0.1 / 0.55 && margin > 0.1 / 0.55 - 1e-3, "{margin}");
    assert!(report.left_inverse.unwrap().0 < 1e-14);
}

/// x^3 is injective with a singular Jacobian: neither proved nor refuted.
#[test]
fn a_flat_point_is_neither_proved_nor_refuted() {
    let report = scalar(Scalar::Cube, -1.0, 1.0).unwrap();
    assert!(matches!(report.injectivity.verdict, Verdict::Undecided { .. }), "{report}");
    // 0 is the centre, which is sampled.
    assert_eq!((report.injectivity.smallest_singular_value, report.injectivity.flattest[0]), (0.0, 0.0));
    assert!(report.residual.verdict.is_proved());
}

/// |x| has no polynomial: then intervals alone decide, to the accuracy that their parts allow.
#[test]
fn without_a_polynomial_intervals_decide_what_they_can() {
    let plant = Scalar::SignedSquare;
    let region = Region::new(&[(0.5, 1.0)]).inputs(&[(0.0, 0.0)]).subdivisions(2000);
    let candidate = KklCandidate::new(&plant, &plant, &[0]).unwrap();
    let coarse = candidate.check(&region, &KklSettings { tolerance: 0.01, ..settings() }).unwrap();
    assert_eq!(coarse.residual.collected, Err("an absolute value"));
    assert!(coarse.residual.verdict.is_proved() && coarse.residual.parts > 10, "{:?}", coarse.residual);
    assert!(coarse.residual.bounds[0] > 0.0 && coarse.residual.bounds[0] <= 0.01 * coarse.residual.scales[0]);
    let fine = candidate.check(&region.subdivisions(20), &settings()).unwrap();
    assert!(matches!(fine.residual.verdict, Verdict::Undecided { .. }));
    let refused = KklDesign::new(&plant, plant, &[0], &Region::new(&[(0.5, 1.0)]).inputs(&[(0.0, 0.0)]), &settings());
    assert!(matches!(refused, Err(KklError::ResidualUndecided { row: 0, bound, allowed }) if bound > allowed));
    // In sentences rows count from 1.
    assert!(refused.is_err_and(|error| error.to_string().contains("solves row 1 of D phi f")));
}

#[test]
fn lambda_may_vary_and_has_to_forget() {
    let report = scalar(Scalar::Varying, -1.0, 1.0).unwrap();
    let diagonal = report.stability.diagonal.as_ref().unwrap();
    assert!(report.is_proved() && diagonal[0].lo() >= -2.0 - 1e-15 && diagonal[0].hi() <= 0.0, "{report}");
    let region = Region::new(&[(-1.0, 1.0)]).inputs(&[(0.0, 0.0)]);
    let refused = KklDesign::new(&Scalar::Unstable, Scalar::Unstable, &[0], &region, &settings());
    assert!(matches!(refused, Err(KklError::NotHurwitz { what: "Lambda", eigenvalue }) if eigenvalue.re == 1.0));
}

/// `z' = D z + B y`, phi = T x, for matrices of any size.
#[derive(Debug, Clone)]
struct LinearMap {
    d: DMatrix<f64>,
    b: DMatrix<f64>,
    t: DMatrix<f64>,
}

impl<T: RealField + Copy> KklMap<T> for LinearMap {
    type Xi = Dyn;
    type Inputs = Dyn;
    type Outputs = Dyn;
    type Estimate = Dyn;
    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: self.d.nrows(), inputs: 1, outputs: self.b.ncols(), estimate: self.t.ncols() }
    }
    fn lambda(&self, _t: T, _u: &DVector<T>, _y: &DVector<T>) -> DMatrix<T> {
        self.d.map(convert)
    }
    fn injection(&self, _t: T, _xi: &DVector<T>, _u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.b.map(convert::<f64, T>) * y
    }
    fn left_inverse(&self, _t: T, xi: &DVector<T>, _y: &DVector<T>) -> DVector<T> {
        xi.clone()
    }
    fn image(&self, _t: T, xhat: &DVector<T>, _y: &DVector<T>) -> DVector<T> {
        self.t.map(convert::<f64, T>) * xhat
    }
}

/// A Lambda with distinct real poles, and T of `T A = D T + B C`.
fn luenberger(a: &DMatrix<f64>, c: &DMatrix<f64>) -> LinearMap {
    let n = a.nrows();
    let d = DMatrix::from_fn(n, n, |i, j| if i == j { -5.0 - i as f64 } else { 0.0 });
    let b = DMatrix::from_element(n, c.nrows(), 1.0);
    let t = sylvester(&-&d, a, &(&b * c)).unwrap().x;
    LinearMap { d, b, t }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Luenberger, 1964: for spectra apart T exists, solves (4), and is invertible for one output if (A, C) is
    /// observable and (D, B) controllable. A in companion form is observable from its last state, and its eigenvalues
    /// are within 1 + 3 of 0, away from -5.
    #[test]
    fn linear_plants_with_sylvesters_t_are_proved(last in prop::collection::vec(-1.0..1.0f64, 1..=3)) {
        let n = last.len();
        let a = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j + 1)) + if j + 1 == n { last[i] } else { 0.0 });
        let c = DMatrix::from_fn(1, n, |_, j| if j + 1 == n { 1.0 } else { 0.0 });
        let map = luenberger(&a, &c);
        let plant = StateSpace::new(a, DMatrix::zeros(n, 1), c).unwrap();
        let all: Vec<usize> = (0..n).collect();
        let region = Region::new(&vec![(-1.0, 1.0); n]).inputs(&[(0.0, 0.0)]);
        let report = KklCandidate::new(&plant, &map, &all).unwrap().check(&region, &settings()).unwrap();
        prop_assert!(report.is_proved(), "{report}");
        // An affine Phi: the margin is 1 up to the condition of T, some 10^4 here at most.
        prop_assert!(report.injectivity.verdict.margin().unwrap() > 0.999);
        let sigma = report.injectivity.smallest_singular_value;
        let phi = map.t.clone().insert_row(n, 0.0);
        let phi = DMatrix::from_fn(n + 1, n, |i, j| if i < n { phi[(i, j)] } else { plant.c[(0, j)] });
        let expected = phi.singular_values().min();
        prop_assert!((sigma - expected).abs() <= 1e-9 * phi.norm(), "{sigma} {expected}");
    }

    /// Whatever B is, the bound is above the residual `(1 - square) x1^2 + (1 - sine) sin x1` of the first row
    /// everywhere, and not above the sum of what its terms can be; what is said to be attained at the worst point is.
    #[test]
    fn no_point_exceeds_the_bound(square in -2.0..2.0f64, sine in -2.0..2.0f64, hi in 0.1..2.0f64, shares in prop::collection::vec(0.0..=1.0f64, 40)) {
        let slip = Sixth { square, sine };
        let region = Region::new(&[(-1.0, hi), (-1.0, 1.0), (-1.0, 1.0)]).inputs(&[(-1.0, 1.0)]);
        let report = KklCandidate::new(&ExponentialCascade, &slip, &[1, 2]).unwrap().check(&region, &settings()).unwrap();
        let truth = |x: f64| ((1.0 - square) * x * x + (1.0 - sine) * x.sin()).abs();
        let residual = &report.residual;
        // The roundings of this closed form, on numbers up to 15.
        let rounding = 1e-14;
        for share in shares {
            prop_assert!(truth(-1.0 + share * (hi + 1.0)) <= residual.bounds[0] + rounding);
        }
        let most = hi.max(1.0);
        let sum = (1.0 - square).abs() * most * most + (1.0 - sine).abs() * most.sin().max(1f64.sin()).max(if most > 1.57 { 1.0 } else { 0.0 });
        prop_assert!(residual.bounds[0] <= sum + rounding);
        let worst = &residual.worst;
        prop_assert!(worst.at_least <= truth(worst.place.state[0]) + rounding && worst.at_least <= residual.bounds[0]);
    }

    /// The bound is one: a Lambda off by `delta` leaves the residual `delta phi`, whose largest value over the box is
    /// known, and samples are below it.
    #[test]
    fn the_bound_encloses_and_the_sample_is_attained(delta in 1e-6..1.0f64, hi in 0.2..3.0f64) {
        let map = LinearMap { d: dmatrix![-1.0 - delta], b: dmatrix![0.0], t: dmatrix![1.0] };
        let plant = StateSpace::new(dmatrix![-1.0], dmatrix![0.0], dmatrix![1.0]).unwrap();
        let region = Region::new(&[(-0.1, hi)]).inputs(&[(0.0, 0.0)]);
        let report = KklCandidate::new(&plant, &map, &[0]).unwrap().check(&region, &settings()).unwrap();
        let truth = ((-1.0 - delta) + 1.0f64).abs() * hi;
        let residual = &report.residual;
        prop_assert!(residual.verdict.is_refuted());
        // Roundings of terms of size 3, and of the truth itself.
        let rounding = 16.0 * f64::EPSILON * 3.0 * hi;
        prop_assert!(residual.bounds[0] >= truth - rounding && residual.bounds[0] <= truth + rounding);
        // The corner hi is sampled.
        prop_assert!(residual.worst.at_least <= truth + rounding && residual.worst.at_least >= truth - rounding);
    }
}

#[test]
fn an_unobservable_linear_plant_is_not_injective() {
    let (a, c) = (dmatrix![-1.0, 0.0; 0.0, -2.0], dmatrix![1.0, 0.0]);
    let map = luenberger(&a, &c);
    let plant = StateSpace::new(a, DMatrix::zeros(2, 1), c).unwrap();
    let region = Region::new(&[(-1.0, 1.0); 2]).inputs(&[(0.0, 0.0)]);
    let report = KklCandidate::new(&plant, &map, &[0, 1]).unwrap().check(&region, &settings()).unwrap();
    let Verdict::Refuted { witness } = &report.injectivity.verdict else { panic!("{report}") };
    // The column of T for x2 is 0: x1 alone is seen.
    assert!(witness.second[0].contains(witness.first[0]) && !witness.second[1].contains(witness.first[1]));
    assert!(map.t.column(1).iter().all(|entry| *entry == 0.0));
    assert!(report.injectivity.smallest_singular_value < 1e-15);
}

#[test]
fn bad_boxes_indices_and_settings_are_refused() {
    let candidate = KklCandidate::new(&ExponentialCascade, &SIXTH, &[1, 2]).unwrap();
    let states = [(-1.0, 1.0); 3];
    let with = |states: &[(f64, f64)], inputs: &[(f64, f64)]| {
        candidate.check(&Region::new(states).inputs(inputs), &settings()).unwrap_err()
    };
    let bounds = |error: KklError| matches!(error, KklError::Enclosure(EnclosureError::Bounds { .. }));
    assert!(bounds(with(&[(-1.0, 1.0), (f64::NAN, 1.0), (0.0, 1.0)], &[(0.0, 1.0)])));
    assert!(bounds(with(&[(-1.0, 1.0), (1.0, -1.0), (0.0, 1.0)], &[(0.0, 1.0)])));
    let dimension = |error: KklError| matches!(error, KklError::Enclosure(EnclosureError::Dimension { .. }));
    assert!(dimension(with(&[], &[(0.0, 1.0)])) && dimension(with(&states, &[])));
    let unbounded = |error: KklError| matches!(error, KklError::Unbounded { .. });
    assert!(unbounded(with(&[(-1.0, 1.0), (0.0, f64::INFINITY), (0.0, 1.0)], &[(0.0, 1.0)])));
    // Unbounded inputs.
    assert!(unbounded(candidate.check(&Region::new(&states), &settings()).unwrap_err()));
    let region = Region::new(&states).inputs(&[(0.0, 1.0)]);
    for bad in [
        KklSettings { tolerance: f64::NAN, ..settings() },
        KklSettings { tolerance: -1.0, ..settings() },
        KklSettings { samples: 0, ..settings() },
        KklSettings { samples: 5000, ..settings() },
    ] {
        assert!(matches!(candidate.check(&region, &bad), Err(KklError::Design(DesignError::Setting { .. }))));
    }
    for indices in [&[][..], &[1], &[1, 1], &[1, 3], &[0, 1, 2]] {
        let refused = KklCandidate::new(&ExponentialCascade, &SIXTH, indices);
        assert!(matches!(refused, Err(KklError::Estimated { .. })), "{indices:?}");
    }
    let misfit = KklCandidate::new(&CukConverter::default(), &SIXTH, &[1, 2]).map(|_| ());
    assert!(matches!(misfit, Err(KklError::Design(DesignError::Matrix(PlantError::DimensionMismatch { .. })))));
    let empty = LinearMap { d: DMatrix::zeros(0, 0), b: DMatrix::zeros(0, 1), t: DMatrix::zeros(0, 1) };
    let plant = StateSpace::new(dmatrix![-1.0], dmatrix![0.0], dmatrix![1.0]).unwrap();
    assert!(KklCandidate::new(&plant, &empty, &[0]).is_err());
    // A map whose lambda has not the size that it says.
    let crooked = LinearMap { d: dmatrix![-1.0], b: dmatrix![1.0; 1.0], t: dmatrix![1.0] };
    let region = Region::new(&[(-1.0, 1.0)]).inputs(&[(0.0, 0.0)]);
    let refused = KklCandidate::new(&plant, &crooked, &[0]).unwrap().check(&region, &settings());
    assert!(matches!(refused, Err(KklError::Undefined { .. })));
}

/// ln x on a box that holds 0: refused with the point; on one that does not, proved. A box that is one point is a box.
#[test]
fn what_is_not_defined_is_named_and_a_point_is_a_box() {
    let refused = scalar(Scalar::Logarithm, -1.0, 1.0).unwrap_err();
    assert!(matches!(refused, KklError::Undefined { operation: "ln", .. }), "{refused}");
    assert!(scalar(Scalar::Logarithm, 0.5, 2.0).unwrap().is_proved());
    let point = scalar(Scalar::Logarithm, 0.5, 0.5).unwrap();
    assert!(point.residual.verdict.is_proved() && point.injectivity.verdict.is_proved());
    // So narrow that nothing lies between its ends.
    assert!(scalar(Scalar::Logarithm, 0.5, 0.5f64.next_up()).unwrap().residual.verdict.is_proved());
    let huge = scalar(Scalar::Cube, -1e200, 1e200);
    assert!(matches!(huge, Err(KklError::Undefined { .. })));
}

/// Proposition 7's class with blocks of 1, 1 and 2 states: `x1' = -x1 + x3 + u'x4`, `x2' = a x2 + sin x1`,
/// `x3' = -3 x3 + x2 x1`, `x4' = -u x1/2`.
#[derive(Debug, Clone, Copy)]
struct Seventh {
    a2: f64,
    /// What b is multiplied with, in the pieces and in the plant.
    b: [f64; 2],
}

const SEVENTH: Seventh = Seventh { a2: -1.0, b: [1.0, 1.0] };

impl Cascade<f64> for Seventh {
    type Second = U1;
    type Third = U1;
    type Fourth = U2;
    type Inputs = U2;
    type Outputs = U1;
    fn a2(&self) -> Matrix1<f64> {
        Matrix1::new(self.a2)
    }
    fn a3(&self) -> Matrix1<f64> {
        Matrix1::new(-3.0)
    }
    fn k(&self) -> usize {
        0
    }
    fn f1k(&self, y: &Vector1<f64>, _x2: &Vector1<f64>, x3: &Vector1<f64>, _u: &Vector2<f64>) -> f64 {
        x3[0] - y[0]
    }
    fn f2(&self, y: &Vector1<f64>, _u: &Vector2<f64>) -> Vector1<f64> {
        Vector1::new(y[0].sin())
    }
    fn f3(&self, y: &Vector1<f64>, x2: &Vector1<f64>, _u: &Vector2<f64>) -> Vector1<f64> {
        x2 * y[0]
    }
    fn f4(&self, y: &Vector1<f64>, _x2: &Vector1<f64>, _x3: &Vector1<f64>, u: &Vector2<f64>) -> Vector2<f64> {
        u * (-0.5 * y[0])
    }
    fn b(&self, _y: &Vector1<f64>, _x2: &Vector1<f64>, _x3: &Vector1<f64>, u: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(self.b[0] * u[0], self.b[1] * u[1])
    }
}

impl Shape for Seventh {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: 5, inputs: 2, outputs: 1 }
    }
}

impl Plant<f64> for Seventh {
    type State = SVector<f64, 5>;
    type Input = Vector2<f64>;
    type Output = Vector1<f64>;
    fn derivative(&self, _t: f64, x: &SVector<f64, 5>, u: &Vector2<f64>) -> SVector<f64, 5> {
        let seen = self.b[0] * u[0] * x[3] + self.b[1] * u[1] * x[4];
        SVector::from([
            -x[0] + x[2] + seen,
            self.a2 * x[1] + x[0].sin(),
            -3.0 * x[2] + x[1] * x[0],
            -0.5 * u[0] * x[0],
            -0.5 * u[1] * x[0],
        ])
    }
    fn output(&self, _t: f64, x: &SVector<f64, 5>, _u: &Self::Input) -> Vector1<f64> {
        Vector1::new(x[0])
    }
}

const STEP: f64 = 0.01;

fn input(t: f64) -> Vector2<f64> {
    Vector2::new((2.0 * t).sin(), 1.0)
}

/// Classical Runge-Kutta for any columns.
fn runge_kutta<const N: usize>(
    t: f64,
    x: SVector<f64, N>,
    f: impl Fn(f64, &SVector<f64, N>) -> SVector<f64, N>,
) -> SVector<f64, N> {
    let k1 = f(t, &x);
    let k2 = f(t + 0.5 * STEP, &(x + k1 * (0.5 * STEP)));
    let k3 = f(t + 0.5 * STEP, &(x + k2 * (0.5 * STEP)));
    let k4 = f(t + STEP, &(x + k3 * STEP));
    x + (k1 + (k2 + k3) * 2.0 + k4) * (STEP / 6.0)
}

fn start() -> SVector<f64, 5> {
    SVector::from([1.0, 0.5, -0.5, 2.0, -1.0])
}

/// The run of the plant to the time 20, in tables.
fn tables(plant: Seventh) -> (Vec<f64>, DMatrix<f64>, DMatrix<f64>) {
    let t: Vec<f64> = (0..=2000).map(|k| f64::from(k) * STEP).collect();
    let (mut states, mut x) = (Vec::new(), start());
    for &time in &t {
        states.extend_from_slice(x.as_slice());
        x = runge_kutta(time, x, |t, x| plant.derivative(t, x, &input(t)));
    }
    let inputs = DMatrix::from_fn(t.len(), 2, |row, k| input(t[row])[k]);
    let states = DMatrix::from_row_slice(t.len(), 5, &states);
    (t, states, inputs)
}

fn run(plant: Seventh) -> SampledRun {
    let (t, x, u) = tables(plant);
    SampledRun::new(&t, &x, &u).unwrap()
}

fn gradient<K: luenberger_observers::Regression<f64, Parameters = U2, Rows = U1>>(
    map: K,
) -> Result<KklPebObserver<K, Gradient<f64, U2>, f64>, luenberger_observers::ObserverError>
where
    nalgebra::DefaultAllocator: luenberger_observers::kkl::KklSize<K::Xi, K::Inputs, K::Outputs, K::Estimate>
        + luenberger_observers::pebo::PebSize<K::Xi, U1, U2, U2>,
{
    KklPebObserver::new(map, Gradient::new(Matrix2::identity() * 2.0)?, 5.0)
}

fn design(plant: Seventh, excite: &Excite) -> Result<luenberger_design::kkl_peb::KklPebReport, KklError> {
    Ok(KklPebDesign::new(&plant, plant, &run(plant), excite, gradient)?.report)
}

/// u = (sin 2t, 1) over T = pi: `int b b' = diag(pi/2, pi)`, because the sine has whole periods; delta is pi/2, along
/// the first parameter.
#[test]
fn proposition_7_is_checked_and_runs() {
    let window = std::f64::consts::PI;
    let checked = KklPebDesign::new(&SEVENTH, SEVENTH, &run(SEVENTH), &Excite::within(window), gradient).unwrap();
    let report = &checked.report;
    let excitation = &report.excitation;
    // A window ends at the first sample after T: up to a step of excess, on which sin^2 is 1 at most.
    assert!((excitation.delta - 0.5 * window).abs() < 2.0 * STEP, "{excitation:?}");
    assert!(excitation.direction[0].abs() > 0.99 && excitation.windows > 100 && excitation.quadrature < 1e-2);
    assert!(report.blocks.len() == 2 && report.blocks.iter().all(|(_, certificate)| certificate.is_proved()));
    assert_eq!((report.slowest.unwrap().re, report.samples), (-1.0, 2001));
    assert!(report.mismatch < 1e-15 && report.growth < 1.5 && report.greatest.len() == 5);
    println!("{report}");
    // And what Proposition 7 promises: the estimate converges.
    let observer = &checked.observer;
    let mut x = start();
    let mut state = observer.initial(0.0, &SVector::zeros(), &input(0.0), &Vector1::new(x[0]));
    let missed = |estimate: SVector<f64, 4>, x: &SVector<f64, 5>| (estimate - x.fixed_rows::<4>(1)).norm();
    let first = missed(observer.estimate(0.0, &state, &input(0.0), &Vector1::new(x[0])), &x);
    for k in 0..3000 {
        let t = f64::from(k) * STEP;
        // Euler with the plant's middle: the observer's slowest mode has a second.
        let slope = observer.derivative(t, &state, &input(t), &Vector1::new(x[0]));
        state += slope * STEP;
        x = runge_kutta(t, x, |t, x| SEVENTH.derivative(t, x, &input(t)));
    }
    let last = missed(observer.estimate(30.0, &state, &input(30.0), &Vector1::new(x[0])), &x);
    // Euler's error in the filters is of the order of STEP times the signals.
    assert!(first > 2.0 && last < 0.02 * first, "{first} {last}");
}

#[test]
fn each_hypothesis_that_fails_is_an_error_with_numbers() {
    let excite = Excite::within(std::f64::consts::PI);
    // A2 with the eigenvalue 0.25: the run of 20 s is bounded by e^5, and the certificate is not there.
    let refused = design(Seventh { a2: 0.25, ..SEVENTH }, &excite).unwrap_err();
    assert!(matches!(&refused, KklError::NotHurwitz { what: "A2", eigenvalue } if eigenvalue.re == 0.25), "{refused}");
    // b2 = 0: the second parameter is not seen.
    let refused = design(Seventh { b: [1.0, 0.0], ..SEVENTH }, &excite).unwrap_err();
    let KklError::NotExciting { delta, needed, direction, .. } = &refused else { panic!("{refused}") };
    assert!(*delta == 0.0 && *needed < 1e-10 && direction[1].abs() == 1.0, "{refused}");
    // b identically 0.
    let refused = design(Seventh { b: [0.0, 0.0], ..SEVENTH }, &excite).unwrap_err();
    assert!(matches!(&refused, KklError::NotExciting { delta, needed, .. } if *delta == 0.0 && *needed == 0.0));
    // Exciting, and less than is asked for.
    let refused = design(SEVENTH, &Excite { needed: 2.0, ..excite }).unwrap_err();
    assert!(matches!(&refused, KklError::NotExciting { delta, needed, .. } if *delta > 1.5 && *needed == 2.0));
    assert!(refused.to_string().contains("least eigenvalue"));
    // Larger than is allowed: x4 begins at 2, at once.
    let refused = design(SEVENTH, &Excite { bound: 1.5, ..excite }).unwrap_err();
    assert!(
        matches!(refused, KklError::Unbounding { what: "x", index: 3, value, time } if value == 2.0 && time == 0.0)
    );
    // Pieces of another plant.
    let other = Seventh { a2: -1.5, ..SEVENTH };
    let refused = KklPebDesign::new(&SEVENTH, other, &run(SEVENTH), &excite, gradient).map(|_| ()).unwrap_err();
    assert!(
        matches!(&refused, KklError::Mismatch { equation, piece, plant, .. } if equation == "x2'(1)" && piece != plant),
        "{refused}"
    );
}

#[test]
fn runs_that_are_none_are_refused() {
    let (t, x, u) = tables(SEVENTH);
    let kkl = |result: Result<SampledRun, KklError>| match result {
        Err(error) => error,
        other => panic!("{other:?}"),
    };
    let none = DMatrix::zeros(0, 5);
    assert_eq!(
        kkl(SampledRun::new(&[], &none, &DMatrix::zeros(0, 2))),
        KklError::Samples { times: 0, states: 0, inputs: 0 }
    );
    assert!(matches!(
        kkl(SampledRun::new(&t[..5], &x, &u)),
        KklError::Samples { times: 5, states: 2001, inputs: 2001 }
    ));
    let mut back = t.clone();
    back[7] = 0.0;
    assert!(matches!(kkl(SampledRun::new(&back, &x, &u)), KklError::Times { sample: 7, .. }));
    back[7] = f64::NAN;
    assert!(matches!(kkl(SampledRun::new(&back, &x, &u)), KklError::Times { sample: 7, .. }));
    // A run that blew up at 12.34 s.
    let mut blown = x.clone();
    blown[(1234, 2)] = f64::INFINITY;
    let error = kkl(SampledRun::new(&t, &blown, &u));
    assert!(
        matches!(error, KklError::Unbounding { what: "x", index: 2, time, .. } if (time - 12.34).abs() < 1e-12),
        "{error}"
    );
    // Windows that are none, and longer than the run; another plant's run.
    for window in [0.0, -1.0, f64::NAN, 25.0, f64::INFINITY] {
        let refused = design(SEVENTH, &Excite::within(window)).unwrap_err();
        assert!(matches!(refused, KklError::Design(DesignError::Setting { what: "the window", .. })), "{window}");
    }
    let refused = design(SEVENTH, &Excite { needed: f64::NAN, ..Excite::within(1.0) }).unwrap_err();
    assert!(matches!(refused, KklError::Design(DesignError::Setting { .. })));
    let narrow = SampledRun::new(&t, &x.columns(0, 4).into_owned(), &u).unwrap();
    let refused =
        KklPebDesign::new(&SEVENTH, SEVENTH, &narrow, &Excite::within(1.0), gradient).map(|_| ()).unwrap_err();
    assert!(
        matches!(
            refused,
            KklError::Design(DesignError::Matrix(PlantError::DimensionMismatch { what: "x of the run", .. }))
        ),
        "{refused}"
    );
}
