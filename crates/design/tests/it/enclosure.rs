//! Enclosures of Jacobians: random plants, branches, points where there is none, and bad input.

use luenberger_design::enclosure::{Axis, EnclosureError, Entry, enclose};
use luenberger_design::{JacobianEnclosure, Region};
use luenberger_observers::mean_value::integral::gauss_legendre;
use luenberger_plants::{Chaotic, Differentiable, Dimensions, Plant, Shape, flexible_joint, state_jacobian};
use nalgebra::{DMatrix, DVector, RealField, RowVector2, SVector, Vector2, convert};
use proptest::prelude::*;

/// `f_i` is a sum of terms `c g(x_a) k(z)` with z a state, the input or time; `h_i = x_i + c sin x_a`. Two inputs of
/// the zoo are not smooth.
#[derive(Debug, Clone)]
struct Random {
    states: usize,
    smooth: bool,
    /// Row, coefficient, functions and their arguments.
    terms: Vec<(usize, f64, usize, usize, usize, usize)>,
}

fn function<T: RealField + Copy>(which: usize, smooth: bool, x: T) -> T {
    let number = |value: f64| convert::<f64, T>(value);
    match which % if smooth { 12 } else { 16 } {
        0 => T::one(),
        1 => x,
        2 => x.sin(),
        3 => x.cos(),
        4 => x.tanh(),
        5 => x * x,
        6 => x.powi(3),
        7 => (-x * x).exp(),
        8 => (T::one() + x * x).sqrt(),
        9 => x.atan() / (number(2.0) + x.sin()),
        10 => (number(0.1) + x.exp()).ln(),
        11 => (x + T::pi() / number(4.0)).cos() * x.asinh(),
        12 => x.abs(),
        13 => RealField::max(x, x.sin()),
        14 => RealField::clamp(x, -T::one(), number(0.5)),
        _ => {
            if x < number(0.25) {
                x * x
            } else {
                x - number(0.1875)
            }
        }
    }
}

impl luenberger_plants::ByDual for Random {}

impl Shape for Random {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: self.states, inputs: 1, outputs: 1 }
    }
}

impl<T: RealField + Copy> Plant<T> for Random {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;

    fn derivative(&self, t: T, x: &DVector<T>, u: &DVector<T>) -> DVector<T> {
        let mut slope = DVector::repeat(self.states, T::zero());
        let argument = |k: usize| match k % (self.states + 2) {
            k if k < self.states => x[k],
            k if k == self.states => u[0],
            _ => t,
        };
        for &(row, c, g, a, k, z) in &self.terms {
            let product = function(g, self.smooth, x[a % self.states]) * function(k, self.smooth, argument(z));
            slope[row % self.states] += convert::<f64, T>(c) * product;
        }
        slope
    }

    fn output(&self, _t: T, x: &DVector<T>, _u: &Self::Input) -> DVector<T> {
        let last = x[self.states - 1];
        DVector::from_element(1, x[0] + convert::<f64, T>(0.3) * last.sin())
    }
}

prop_compose! {
    fn random(smooth: bool)(
        states in 1usize..4,
        terms in prop::collection::vec((0usize..4, -2.0f64..2.0, 0usize..16, 0usize..4, 0usize..16, 0usize..6), 1..6),
    ) -> Random {
        Random { states, smooth, terms }
    }
}

/// For each coordinate a middle and a half width, and two points as shares of the way.
fn boxes() -> impl Strategy<Value = Vec<(f64, f64, f64, f64)>> {
    prop::collection::vec((-2.0f64..2.0, 0.0f64..1.0, 0.0f64..=1.0, 0.0f64..=1.0), 5)
}

struct Sampled {
    region: Region,
    points: [DVector<f64>; 2],
    u: DVector<f64>,
    t: f64,
}

fn sampled(n: usize, boxes: &[(f64, f64, f64, f64)], subdivisions: usize) -> Sampled {
    let bounds: Vec<(f64, f64)> = boxes.iter().map(|(m, r, ..)| (m - r, m + r)).collect();
    let at = |k: usize, share: f64| (bounds[k].0 + share * (bounds[k].1 - bounds[k].0)).clamp(bounds[k].0, bounds[k].1);
    Sampled {
        region: Region::new(&bounds[..n])
            .inputs(&bounds[3..4])
            .time(bounds[4].0, bounds[4].1)
            .subdivisions(subdivisions),
        points: [DVector::from_fn(n, |k, _| at(k, boxes[k].2)), DVector::from_fn(n, |k, _| at(k, boxes[k].3))],
        u: DVector::from_element(1, at(3, boxes[3].2)),
        t: at(4, boxes[4].2),
    }
}

/// Each entry is inside up to `slack`.
fn assert_inside(jacobian: &DMatrix<f64>, enclosure: &JacobianEnclosure, slack: f64) -> Result<(), TestCaseError> {
    for ((i, j), entry) in
        (0..jacobian.nrows()).flat_map(|i| (0..jacobian.ncols()).map(move |j| (i, j))).map(|k| (k, jacobian[k]))
    {
        let interval = enclosure.a[(i, j)];
        prop_assert!(
            interval.lo() - slack <= entry && entry <= interval.hi() + slack,
            "({i}, {j}): {entry} {interval:?}"
        );
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    /// The Jacobian at a point of the box lies in the enclosure, smooth or not. The dual numbers round: at most five
    /// terms below 2 * 27 * 27, each of a dozen operations.
    #[test]
    fn the_jacobian_at_a_point_is_inside(plant in prop_oneof![random(true), random(false)], boxes in boxes(), budget in prop_oneof![Just(0usize), Just(40)]) {
        let s = sampled(plant.states, &boxes, budget);
        let enclosure = enclose(&plant, &s.region).unwrap();
        for x in &s.points {
            assert_inside(&state_jacobian(&plant, s.t, x, &s.u), &enclosure, 100.0 * f64::EPSILON * 2000.0)?;
            let c = plant.output_jacobian(s.t, x, &s.u);
            for j in 0..plant.states {
                let interval = enclosure.c[(0, j)];
                prop_assert!(interval.lo() - 1e-15 <= c[(0, j)] && c[(0, j)] <= interval.hi() + 1e-15);
            }
        }
    }

    /// Every function that a scalar offers, against dual numbers; their derivatives here are below 2e4 and rounded a
    /// few times.
    #[test]
    fn every_function_encloses_its_derivative(
        (a, b) in (0.05f64..0.95, 0.05f64..0.95), (c, d) in (1.05f64..3.0, 1.05f64..3.0), shares in prop::array::uniform2(0.0f64..=1.0),
    ) {
        let bounds = [(a.min(b), a.max(b)), (c.min(d), c.max(d))];
        let x = Vector2::from_fn(|k, _| (bounds[k].0 + shares[k] * (bounds[k].1 - bounds[k].0)).clamp(bounds[k].0, bounds[k].1));
        for which in 0..ELEMENTARY {
            // num-dual has no floor.
            let of_the_rest = which + 1 < ELEMENTARY;
            let enclosure = enclose(&Elementary(which), &Region::new(&bounds).subdivisions(0)).unwrap();
            let expected = if of_the_rest {
                state_jacobian(&Elementary(which), 0.0, &x, &SVector::zeros()).row(0).into_owned()
            } else {
                RowVector2::new(-std::f64::consts::LN_10, std::f64::consts::FRAC_PI_2)
            };
            for j in 0..2 {
                let (interval, entry) = (enclosure.a[(0, j)], expected[j]);
                let slack = 64.0 * f64::EPSILON * entry.abs().max(1.0);
                prop_assert!(interval.lo() - slack <= entry && entry <= interval.hi() + slack, "{which}: {entry} {interval:?}");
                // Over a single point there is nothing to enclose but rounding.
                let at = [(x[0], x[0]), (x[1], x[1])];
                let point = enclose(&Elementary(which), &Region::new(&at)).unwrap().a[(0, j)];
                prop_assert!(point.width() <= 1e-9 * point.magnitude().max(1.0), "{which}: {point:?}");
            }
        }
    }

    /// So does the integral mean between two points of the box; the quadrature of its halves errs by far less than it
    /// differs from that of the whole.
    #[test]
    fn the_mean_jacobian_is_inside(plant in random(true), boxes in boxes()) {
        let s = sampled(plant.states, &boxes, 20);
        let enclosure = enclose(&plant, &s.region).unwrap();
        let half = (&s.points[1] - &s.points[0]) * 0.5;
        let mean = |from: &DVector<f64>, e: &DVector<f64>| gauss_legendre(&plant, s.t, from, &s.u, e);
        let halves = (mean(&s.points[0], &half) + mean(&(&s.points[0] + &half), &half)) * 0.5;
        let difference = (&halves - mean(&s.points[0], &(&half * 2.0))).amax();
        assert_inside(&halves, &enclosure, difference + 1e-11)?;
    }

    /// Bisection never makes an enclosure wider.
    #[test]
    fn subdivision_tightens(plant in random(false), boxes in boxes()) {
        let whole = enclose(&plant, &sampled(plant.states, &boxes, 0).region).unwrap();
        let parts = enclose(&plant, &sampled(plant.states, &boxes, 60).region).unwrap();
        for (outer, inner) in whole.a.as_slice().iter().zip(parts.a.as_slice()) {
            // Neighbouring values of the library may be out of order by a few units.
            let slack = 1e-12 * outer.magnitude();
            prop_assert!(outer.lo() - slack <= inner.lo() && inner.hi() <= outer.hi() + slack);
        }
    }
}

/// `x1'` is one of the functions that a scalar offers, of x1 in (0, 1) and x2 in (1, 3), where all of them are defined.
struct Elementary(usize);

const ELEMENTARY: usize = 28;

luenberger_plants::plant!(
    Elementary,
    (2, 0, 1),
    |plant, t, x, u| {
        let (x, y) = (x[0], x[1]);
        let f = match plant.0 {
            0 => x.tan(),
            1 => x.asin(),
            2 => x.acos(),
            3 => (-y).sinh(),
            4 => (-y).cosh(),
            5 => x.atanh(),
            6 => y.acosh(),
            7 => (-y).asinh(),
            8 => y.log(y + x),
            9 => x.log2(),
            10 => x.log10(),
            11 => (x - y).exp2(),
            12 => (x - y).exp_m1(),
            13 => (-x).ln_1p(),
            14 => (-y).cbrt(),
            15 => x.hypot(y),
            16 => x.atan2(y),
            17 => y.atan2(-x),
            18 => x.powf(y),
            19 => y.powf(convert(3.0)),
            20 => (-y).powi(-3),
            21 => (x - y).recip(),
            22 => x.mul_add(y, x / y),
            23 => x.abs() * (x - y).signum() + (-y).modulus_squared(),
            24 => RealField::min(x, y - T::one()),
            25 => x.sin_cos().0 * x.sinh_cosh().1 * y.tanh(),
            26 => x.try_sqrt().unwrap_or(y),
            _ => x.floor() + y * T::frac_pi_2() - T::ln_10() * x.fract(),
        };
        [f, -y]
    },
    [x[0]]
);

/// Two states, `x1' = x2`, `x2' = f(x, t)`, `y = x1`.
macro_rules! scalar_plant {
    ($name:ident, |$x:ident, $t:ident| $f:expr) => {
        plant!($name, (2, 0, 1), |_plant, $t, $x, _u| [$x[1], $f], [$x[0]]);
    };
}

scalar_plant!(Reciprocal, |x, _t| T::one() / x[0]);
scalar_plant!(Logarithm, |x, _t| (x[0] - x[1]).ln());
scalar_plant!(Root, |x, _t| x[0].abs().sqrt());
scalar_plant!(Relay, |x, _t| if x[0] > convert(0.7) { x[1] } else { -x[1] });
scalar_plant!(SmallStep, |x, _t| if x[0] > convert(0.7) { x[0] + convert(1e-3) } else { x[0] });
scalar_plant!(Floor, |x, _t| x[0].floor());
scalar_plant!(Square, |x, _t| x[0] * x[0]);
scalar_plant!(Guarded, |x, _t| if x[0] > convert(0.5) {
    x[0].ln()
} else {
    convert::<f64, T>(2.0) * x[0] + convert(-1.0 - std::f64::consts::LN_2)
});
scalar_plant!(Ticking, |x, t| t * x[0]);
scalar_plant!(Looping, |x, _t| {
    let mut y = x[0];
    while y > convert(1.0) {
        y *= convert(0.5);
    }
    y
});
scalar_plant!(Leaking, |x, _t| convert(if x[0].to_subset().is_some_and(|x: f64| x > 0.0) {
    1.0
} else {
    x[0].to_subset_unchecked()
}));

scalar_plant!(Defaulting, |x, _t| convert(x[0].to_subset().unwrap_or(0.0)));

fn at(error: &EnclosureError) -> Vec<f64> {
    match error {
        EnclosureError::Unbounded { place, .. }
        | EnclosureError::Undefined { place, .. }
        | EnclosureError::TooManyBranches { place, .. }
        | EnclosureError::Effort { place, .. } => place.point.iter().map(|(_, x)| *x).collect(),
        _ => Vec::new(),
    }
}

#[test]
fn a_point_without_a_value_is_named() {
    let region = Region::new(&[(-3.0, 4.0), (-1.0, 1.0)]);
    let error = enclose(&Reciprocal, &region).unwrap_err();
    assert!(matches!(error, EnclosureError::Undefined { operation: "division", side: "f", .. }), "{error}");
    assert_eq!(at(&error)[0], 0.0, "{error}");
    assert!(error.to_string().contains("x1 = 0"), "{error}");
    // Away from 0 there is nothing to say; up to 0 there is.
    assert!(enclose(&Reciprocal, &Region::new(&[(0.1, 4.0), (-1.0, 1.0)])).is_ok());
    assert!(enclose(&Reciprocal, &Region::new(&[(0.0, 4.0), (-1.0, 1.0)])).is_err());
    // ln(x1 - x2): somewhere on the diagonal or beyond.
    let error = enclose(&Logarithm, &region).unwrap_err();
    assert!(
        matches!(error, EnclosureError::Undefined { operation: "ln", .. }) && at(&error)[0] <= at(&error)[1] + 1e-9,
        "{error}"
    );
    // sqrt |x1| is defined everywhere, and steep at 0.
    let error = enclose(&Root, &region).unwrap_err();
    let entry = Entry { of_output: false, row: 1, column: 0 };
    assert!(matches!(&error, EnclosureError::Unbounded { entry: found, .. } if *found == entry), "{error}");
    assert!(
        at(&error)[0].abs() < 1e-12 && error.to_string().starts_with("df2/dx1 has no finite bound at x1 = "),
        "{error}"
    );
}

#[test]
fn jumps_are_found() {
    let region = Region::new(&[(-3.0, 4.0), (-1.0, 1.0)]);
    for (name, error) in
        [("relay", enclose(&Relay, &region).unwrap_err()), ("step", enclose(&SmallStep, &region).unwrap_err())]
    {
        assert!(
            matches!(error, EnclosureError::Undefined { operation: "the choice between two branches", .. }),
            "{name}: {error}"
        );
        assert!((at(&error)[0] - 0.7).abs() < 1e-8, "{name}: {error}");
    }
    let error = enclose(&Floor, &region).unwrap_err();
    assert!(
        matches!(error, EnclosureError::Undefined { operation: "floor", .. })
            && (at(&error)[0] - at(&error)[0].round()).abs() < 1e-12,
        "{error}"
    );
    assert!(enclose(&Floor, &Region::new(&[(0.1, 0.9), (0.0, 1.0)])).is_ok());
    // To one side of the jump there is none.
    assert!(enclose(&SmallStep, &Region::new(&[(0.8, 4.0), (-1.0, 1.0)])).is_ok());
}

/// ln is taken only where it is defined: parts that leave the branch open near 0.5 are bisected until they do not reach
/// 0.
#[test]
fn a_guarded_operation_is_no_error() {
    let jacobians = enclose(&Guarded, &Region::new(&[(-3.0, 4.0), (-1.0, 1.0)])).unwrap();
    let slope = jacobians.a[(1, 0)];
    // From 1/4 at x1 = 4 to 2 at and below 1/2; the logarithm's 1/x exceeds 2 on the part that is open.
    assert!(slope.lo() <= 0.25 && slope.lo() > 0.24 && slope.hi() >= 2.0 && slope.hi() < 2.1, "{slope:?}");
}

#[test]
fn unbounded_boxes_work_where_the_jacobian_is_bounded() {
    let everywhere = Region::everywhere(2);
    let error = enclose(&Square, &everywhere).unwrap_err();
    assert!(matches!(error, EnclosureError::Unbounded { .. }) && error.to_string().contains("x1"), "{error}");
    assert!(enclose(&Square, &Region::new(&[(-1.0, 1.0), (f64::NEG_INFINITY, f64::INFINITY)])).is_ok());
    // Time is a coordinate too, unbounded unless bounded.
    assert!(enclose(&Ticking, &everywhere).unwrap_err().to_string().contains('t'));
    let slope = enclose(&Ticking, &everywhere.time(0.0, 2.0)).unwrap().a[(1, 0)];
    assert_eq!((slope.lo(), slope.hi()), (0.0, 2.0));
}

#[test]
fn loops_and_leaks_are_errors() {
    let error = enclose(&Looping, &Region::everywhere(2)).unwrap_err();
    assert!(matches!(error, EnclosureError::TooManyBranches { .. } | EnclosureError::Undefined { .. }), "{error}");
    let region = Region::new(&[(-1.0, 1.0), (0.0, 1.0)]);
    for error in [enclose(&Leaking, &region).unwrap_err(), enclose(&Defaulting, &region).unwrap_err()] {
        assert!(
            matches!(error, EnclosureError::Undefined { operation: "conversion to a single number", .. }),
            "{error}"
        );
    }
}

#[test]
fn bad_boxes_are_named() {
    for (lo, hi) in [
        (f64::NAN, 1.0),
        (0.0, f64::NAN),
        (1.0, 0.0),
        (f64::INFINITY, f64::INFINITY),
        (f64::NEG_INFINITY, f64::NEG_INFINITY),
    ] {
        let error = enclose(&Square, &Region::new(&[(0.0, 1.0), (lo, hi)])).unwrap_err();
        assert!(matches!(error, EnclosureError::Bounds { axis: Axis::State(1), .. }), "{error}");
        assert!(error.to_string().starts_with("x2 has the bounds"));
    }
    for states in [0, 1, 3] {
        let error = enclose(&Square, &Region::everywhere(states)).unwrap_err();
        assert_eq!(error, EnclosureError::Dimension { what: "states", expected: 2, found: states });
    }
    let error = enclose(&Square, &Region::everywhere(2).inputs(&[(0.0, 1.0)])).unwrap_err();
    assert_eq!(error, EnclosureError::Dimension { what: "inputs", expected: 0, found: 1 });
    let error = enclose(&Square, &Region::everywhere(2).time(1.0, 0.0)).unwrap_err();
    assert!(matches!(error, EnclosureError::Bounds { axis: Axis::Time, .. }));
    // A single point is a box.
    let jacobians = enclose(&Square, &Region::new(&[(3.0, 3.0), (1.0, 1.0)])).unwrap();
    assert!(jacobians.a[(1, 0)].is_point() && jacobians.a[(1, 0)].contains(6.0));
}

/// A plant whose columns are not of the length it says.
struct Liar;

impl Shape for Liar {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: 2, inputs: 0, outputs: 1 }
    }
}

impl<T: RealField + Copy> Plant<T> for Liar {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;

    fn derivative(&self, _t: T, x: &DVector<T>, _u: &DVector<T>) -> DVector<T> {
        DVector::from_element(3, x[0])
    }

    fn output(&self, _t: T, x: &DVector<T>, _u: &Self::Input) -> DVector<T> {
        x.clone()
    }
}

#[test]
fn a_plant_of_another_size_than_it_says_is_an_error() {
    let error = enclose(&Liar, &Region::everywhere(2)).unwrap_err();
    assert_eq!(error, EnclosureError::Dimension { what: "rows of f", expected: 2, found: 3 });
}

/// Entries of the chaotic plant: exp(d)/(0.1 + exp(d)) for d = x2 - x1 between -2.7 and 6, and the states themselves.
#[test]
fn the_chaotic_plant_on_a_box() {
    let jacobians =
        enclose(&Chaotic, &Region::new(&[(-3.0, -0.3), (-3.0, 3.0), (-3.0, 3.0)]).subdivisions(3000)).unwrap();
    let (least, most) = (1.0 / (1.0 + 0.1 * 2.7f64.exp()), 1.0 / (1.0 + 0.1 * (-6f64).exp()));
    let slope = jacobians.a[(0, 1)];
    assert!(slope.lo() <= least && slope.hi() >= most, "{slope:?}");
    assert!(slope.width() < 1.1 * (most - least), "{slope:?} {} {}", jacobians.parts, jacobians.excess);
    let ends = |i, j| (jacobians.a[(i, j)].lo(), jacobians.a[(i, j)].hi());
    assert_eq!((ends(1, 0), ends(1, 2), ends(2, 0), ends(2, 1)), ((-3.0, 3.0), (-3.0, -0.3), (-3.0, 3.0), (0.3, 3.0)));
}

#[test]
fn the_flexible_joint_is_bounded_everywhere() {
    let jacobians = enclose(&flexible_joint::printed(), &Region::everywhere(4)).unwrap();
    let varying: Vec<_> = (0..16).filter(|k| !jacobians.a[(k / 4, k % 4)].is_point()).collect();
    assert_eq!(varying, [14]);
    let entry = jacobians.a[(3, 2)];
    assert!(
        (entry.lo() + 22.83).abs() < 1e-13
            && (entry.hi() + 16.17).abs() < 1e-13
            && entry.contains(-22.83)
            && entry.contains(-16.17)
    );
    // Without inputs the box of inputs is all of them.
    assert_eq!(
        jacobians,
        enclose(&flexible_joint::printed(), &Region::everywhere(4).inputs(&[(-1e300, 1e300)])).unwrap()
    );
}

// A kink at x1 = -0.5 and a jump of 0.5 at x1 = 0.5: a search that follows one place of change to its end finds the
// kink.
scalar_plant!(KinkAndJump, |x, _t| {
    let kink = if x[0] < convert(-0.5) { x[0] + convert(0.5) } else { T::zero() };
    let jump = if x[0] > convert(0.5) { convert(0.5) } else { T::zero() };
    kink + jump - x[1]
});

// The jump lies in a branch of a branch, vanishes at x2 = -1, and what the branches have in common varies by far more.
scalar_plant!(NestedJump, |x, _t| {
    let common = convert::<f64, T>(40.0) * x[1].sin() + convert::<f64, T>(25.0) * x[0];
    if x[0] < x[1] {
        common
    } else if x[0] - x[1] < convert(0.75) {
        common + x[0] - x[1]
    } else {
        common + convert::<f64, T>(0.75) + convert::<f64, T>(0.01) * (x[1] + T::one())
    }
});

// Continuous: two kinks that cross, one of them inside a branch.
scalar_plant!(CrossingKinks, |x, _t| {
    let a = if x[0] < T::zero() { -x[0] } else { x[0] };
    let b = if x[1] < x[0] { x[0] - x[1] } else { convert::<f64, T>(3.0) * (x[1] - x[0]) };
    if a < b { b } else { a }
});

plant!(
    /// Four states and an input without bounds: kinks in three states and, where x4 is large as well, a jump.
    ManyKinks { jump },
    (4, 1, 1),
    |plant, _t, x, u| {
        let kink = |x: T| if x > convert(-0.25) { x + convert(0.25) } else { T::zero() };
        let jump = if x[3] > convert(0.5) {
            if x[0] > convert(0.125) { convert(plant.jump) } else { T::zero() }
        } else {
            T::zero()
        };
        [x[1], x[2], x[3] + u[0], kink(x[0]) + kink(x[1]) + kink(x[2]) + jump + u[0]]
    },
    [x[0]]
);

/// All branches are searched, and not one way into them.
#[test]
fn a_jump_beside_a_kink_is_found() {
    let region = Region::new(&[(-1.0, 1.0), (-1.0, 1.0)]);
    let error = enclose(&KinkAndJump, &region).unwrap_err();
    assert!(matches!(error, EnclosureError::Undefined { side: "f", .. }), "{error}");
    assert!((at(&error)[0] - 0.5).abs() < 1e-8, "{error}");
    let error = enclose(&NestedJump, &region).unwrap_err();
    let EnclosureError::Undefined { place, .. } = &error else { panic!("{error}") };
    let point: Vec<f64> = place.part.iter().map(|part| f64::midpoint(part.0, part.1)).collect();
    assert!((point[0] - point[1] - 0.75).abs() < 1e-6, "{error}");
    for jump in [0.5, 1e-3] {
        let error = enclose(&ManyKinks { jump }, &Region::new(&[(-1.0, 1.0); 4])).unwrap_err();
        assert!(matches!(error, EnclosureError::Undefined { side: "f", .. }), "{jump}: {error}");
    }
}

/// What is continuous stays without an error, with a bound of the jumps that were not found; what does not branch has
/// no such hypothesis.
#[test]
fn branches_that_meet_are_a_hypothesis_with_a_number() {
    let region = Region::new(&[(-1.0, 1.0), (-1.0, 1.0)]);
    let found = enclose(&CrossingKinks, &region).unwrap();
    let branches = found.branches.unwrap();
    assert!(branches.parts > 0 && branches.jump < 0.25, "{branches:?}");
    assert!(branches.to_string().contains("continuous where they change branches"), "{branches}");
    let branches = enclose(&ManyKinks { jump: 0.0 }, &Region::new(&[(-1.0, 1.0); 4])).unwrap().branches.unwrap();
    assert!(branches.jump <= 4.0, "{branches:?}");
    assert!(enclose(&Square, &region).unwrap().branches.is_none());
    // To one side of its branch a plant has none.
    assert!(enclose(&Guarded, &Region::new(&[(-3.0, 0.4), (-1.0, 1.0)])).unwrap().branches.is_none());
}
