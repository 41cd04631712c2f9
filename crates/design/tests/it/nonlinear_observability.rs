//! The rank of the derivatives of the output: linear pairs, plants of the books, and what must be refused.

use luenberger_design::nonlinear_observability::{
    InWords, InputTreatment, Instant, LieObservability, LieSettings, ObservabilityError, lie_observability,
};
use luenberger_linalg::observability;
use luenberger_plants::{CukConverter, Dimensions, LinearPlant, Plant, ReverseDuffing, Shape, VanDerPol};
use nalgebra::{DMatrix, DVector, Dyn, RealField, Vector2, convert};
use proptest::prelude::*;

plant!(PendulumByAngle, 2, 1, |_plant, x| [x[1], -x[0].sin()], [x[0]]);
plant!(PendulumBySpeed, 2, 1, |_plant, x| [x[1], -x[0].sin()], [x[1]]);
plant!(Relative, 2, 1, |_plant, x| [(x[0] - x[1]).sin(), -(x[0] - x[1]).tanh()], [x[0] - x[1]]);
plant!(Product, 2, 1, |_plant, x| [x[0] * T::zero(), T::zero()], [x[0] * x[1]]);
plant!(Cube, 2, 1, |_plant, x| [T::zero(), -x[1]], [x[0].powi(3) + x[1]]);
plant!(Steered, (2, 1, 1), |_plant, _t, x, u| [u[0] * x[1], T::zero()], [x[0]]);
plant!(Timed, (2, 0, 1), |_plant, t, x, _u| [t * x[1], T::zero()], [x[0]]);
plant!(Rooted, 2, 1, |_plant, x| [x[1], x[0].sqrt()], [x[0]]);

fn at<S: Plant<luenberger_design::nonlinear_observability::Jet>>(
    plant: &S,
    points: &[[f64; 2]],
    order: usize,
) -> LieObservability {
    let points: Vec<Instant> = points.iter().map(|x| Instant::new(0.0, x)).collect();
    lie_observability(plant, &points, &LieSettings { order: Some(order), ..LieSettings::default() }).unwrap()
}

fn index<S: Plant<luenberger_design::nonlinear_observability::Jet>>(plant: &S, x: [f64; 2]) -> Option<usize> {
    at(plant, &[x], 3).index()
}

#[test]
fn oscillators_and_pendulums_need_as_many_derivatives_as_the_books_say() {
    // Of y and y' one reads x1 and x2.
    for x in [[0.0, 0.0], [2.0, -3.0], [-0.1, 5.0]] {
        assert_eq!(index(&VanDerPol::default(), x), Some(1));
        assert_eq!(index(&PendulumByAngle, x), Some(1));
    }
    // y' = -sin x1 is stationary at the horizontal; y'' = -x2 cos x1 is not while the pendulum moves, and at rest y'''
    // has d/dx1 (x2^2 sin x1 + sin x1 cos x1) = -1.
    let quarter = std::f64::consts::FRAC_PI_2;
    assert_eq!(index(&PendulumBySpeed, [0.3, 0.0]), Some(1));
    assert_eq!(index(&PendulumBySpeed, [quarter, 1.0]), Some(2));
    assert_eq!(index(&PendulumBySpeed, [quarter, 0.0]), Some(3));
    // x1' = x2^3: only y''' = 3 x1^2 x2 + .. sees x2 near 0, and nothing of third order does in the origin.
    assert_eq!(index(&ReverseDuffing, [1.0, 0.5]), Some(1));
    assert_eq!(index(&ReverseDuffing, [1.0, 0.0]), Some(3));
    assert_eq!(index(&ReverseDuffing, [0.0, 0.0]), None);
}

#[test]
fn the_worst_point_of_the_reverse_duffing_oscillator_is_where_it_turns() {
    let points: Vec<[f64; 2]> = (0..=40).map(|k| [1.0, f64::from(k - 20) / 20.0]).collect();
    let seen = at(&ReverseDuffing, &points, 1);
    assert_eq!(seen.worst().unwrap().x, [1.0, 0.0]);
    assert_eq!(seen.points.iter().filter(|point| point.rank < 2).count(), 1);
    let text = seen.to_string();
    assert!(text.contains("not full at 1 of 41") && text.ends_with("unobservable there: x2"), "{text}");
    // O = [1 0; 0 3 x2^2], and the unit of time makes 3 one.
    for (point, x) in seen.points.iter().zip(&points) {
        assert!((point.margin() - x[1] * x[1]).abs() <= 8.0 * f64::EPSILON, "{} at {x:?}", point.margin());
    }
}

#[test]
fn a_symmetry_is_a_direction_that_nothing_sees() {
    let seen = at(&Relative, &[[0.3, 0.1], [2.0, -1.0]], 8);
    for point in &seen.points {
        assert_eq!((point.rank, point.index), (1, None));
        assert!(point.gap(seen.tolerance) > 1e3, "{}", point.gap(seen.tolerance));
        let v = point.unseen.column(0);
        assert!((v[0] - v[1]).abs() <= seen.tolerance * v.norm(), "{v}");
    }
    // The state is measured in units of its largest value; the direction is that of the units given all the same.
    let settings = LieSettings { scales: Some(vec![1.0, 1.0]), ..LieSettings::default() };
    let seen = lie_observability(&Relative, &[Instant::new(0.0, &[0.3, 0.1])], &settings).unwrap();
    assert!(seen.in_words(&["p", "q"]).ends_with("unobservable there: p + q"), "{seen}");
}

#[test]
fn the_rank_drops_where_the_output_is_stationary() {
    let seen = at(&Product, &[[1.0, 1.0], [0.0, 0.0]], 3);
    assert_eq!(seen.points.iter().map(|point| point.rank).collect::<Vec<_>>(), [1, 0]);
    assert!(seen.points[0].unseen.column(0).sum().abs() <= 4.0 * f64::EPSILON);
    assert_eq!((seen.points[1].condition(), seen.points[1].margin()), (f64::INFINITY, 0.0));
    // y = x1^3 + x2 at x1 = 0: injective, but the rank of the derivatives is deficient.
    let seen = at(&Cube, &[[1.0, 1.0], [0.0, 1.0]], 5);
    assert_eq!(seen.points.iter().map(|point| point.rank).collect::<Vec<_>>(), [2, 1]);
    assert!(seen.to_string().ends_with("unobservable there: x1"), "{seen}");
}

#[test]
fn the_input_and_its_derivatives_are_part_of_the_question() {
    let rank = |point: Instant| {
        let seen = lie_observability(&Steered, &[point], &LieSettings::default()).unwrap();
        (seen.points[0].rank, seen.points[0].index, seen.input)
    };
    let point = || Instant::new(0.0, &[1.0, 1.0]);
    assert_eq!(rank(point().constant_input(&[0.0])), (1, None, InputTreatment::Constant));
    assert_eq!(rank(point().constant_input(&[2.0])), (2, Some(1), InputTreatment::Constant));
    // u(t) = t: x1'' = x2.
    assert_eq!(rank(point().input_series(&[vec![0.0], vec![1.0]])), (2, Some(2), InputTreatment::Series));
    // So does a plant that depends on time itself.
    assert_eq!(index(&Timed, [1.0, 1.0]), Some(2));
}

#[test]
fn the_converter_is_observable_while_it_switches() {
    let converter = CukConverter::default();
    let x = converter.equilibrium(5.0);
    let at = |u: f64| {
        lie_observability(&converter, &[Instant::new(0.0, x.as_slice()).constant_input(&[u])], &LieSettings::default())
            .unwrap()
    };
    assert_eq!(at(converter.equilibrium_input(5.0)).index(), Some(1));
    // With w = 1 - u = 0 the input inductor is cut off.
    let seen = at(1.0);
    assert_eq!(seen.points[0].rank, 3);
    assert!(seen.in_words(&["i1", "v2", "i3", "v4"]).ends_with("unobservable there: i1"), "{seen}");
}

/// A pair whose observable part has order r, in coordinates that mix everything: the rank is r by construction.
fn pair() -> impl Strategy<Value = (DMatrix<f64>, DMatrix<f64>, usize)> {
    (1usize..=4, 0usize..=2).prop_flat_map(|(r, hidden)| {
        let n = r + hidden;
        let entries = prop::collection::vec(-2i32..=2, n * n);
        let mixing = prop::collection::vec(-1i32..=1, n * n);
        (Just((r, n)), entries, mixing).prop_map(|((r, n), entries, mixing)| {
            // [A1 0; A21 A2] with the observable companion A1, and C = e1'.
            let a = DMatrix::from_fn(n, n, |i, j| match (i < r, j < r) {
                (true, true) if i + 1 < r => f64::from(u8::from(j == i + 1)),
                (true, false) => 0.0,
                _ => f64::from(entries[i * n + j]),
            });
            let c = DMatrix::from_fn(1, n, |_, j| f64::from(u8::from(j == 0)));
            // Unit triangular: the inverse has whole entries too.
            let t = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
                std::cmp::Ordering::Equal => 1.0,
                std::cmp::Ordering::Greater => f64::from(mixing[i * n + j]),
                std::cmp::Ordering::Less => 0.0,
            });
            let inverse = t.clone().try_inverse().unwrap_or_else(|| DMatrix::identity(n, n)).map(f64::round);
            (&inverse * a * &t, c * t, r)
        })
    })
}

proptest! {
    /// For a linear plant the rank is that of the observability matrix, wherever it is evaluated, and what is not seen
    /// is the unobservable subspace.
    #[test]
    fn linear_plants_have_the_rank_of_their_observability_matrix(
        (a, c, r) in pair(), x in prop::collection::vec(1.0..2.0f64, 6), tau in -3i32..=3,
    ) {
        let n = a.nrows();
        let a = a * 2f64.powi(4 * tau);
        let known = observability(&a, &c).unwrap();
        prop_assert_eq!(known.rank, r);
        let plant = JetPlant { a: a.clone(), c: c.clone() };
        let settings = LieSettings { order: Some(n - 1), ..LieSettings::default() };
        let seen = lie_observability(&plant, &[Instant::new(0.0, &x[..n])], &settings).unwrap();
        let point = &seen.points[0];
        prop_assert_eq!(point.rank, r, "{}", seen);
        // The unseen directions lie in the unobservable subspace: C A^k v = 0.
        for v in point.unseen.column_iter() {
            let mut w: DVector<f64> = v.into_owned();
            for _ in 0..n {
                // Rounding over the gap to the smallest singular value that counts, which is above 1e-4 for these whole
                // numbers.
                let bound = 1e4 * seen.tolerance * c.norm() * w.norm().max(v.norm());
                prop_assert!((&c * &w).norm() <= bound, "{} of {}", &c * &w, bound);
                w = &a * w / a.norm().max(f64::MIN_POSITIVE);
            }
        }
    }

    /// Singular values and ranks do not depend on the units of states, output and time.
    #[test]
    fn nothing_depends_on_units(
        p in -30i32..=30, q in -30i32..=30, y in -30i32..=30, x in prop::array::uniform2(0.25..2.0f64),
    ) {
        let points = [x, [x[1], -x[0]]];
        let first = at(&Rescaled { states: [0, 0], output: 0 }, &points, 4);
        let other = Rescaled { states: [p, q], output: y };
        let scaled = points.map(|x| [x[0] * 2f64.powi(-p), x[1] * 2f64.powi(-q)]);
        let second = at(&other, &scaled, 4);
        for (one, two) in first.points.iter().zip(&second.points) {
            prop_assert_eq!((one.rank, one.index), (two.rank, two.index));
            for (x, y) in one.singular_values.iter().zip(&two.singular_values) {
                // Powers of two are exact; what is left is the iteration of the singular values.
                prop_assert!((x - y).abs() <= 64.0 * f64::EPSILON, "{} against {}", x, y);
            }
        }
    }
}

/// A linear plant whose matrices stay numbers, over any scalar.
struct JetPlant {
    a: DMatrix<f64>,
    c: DMatrix<f64>,
}

impl Shape for JetPlant {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: self.a.nrows(), inputs: 0, outputs: self.c.nrows() }
    }
}

impl<T: RealField + Copy> Plant<T> for JetPlant {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;

    fn derivative(&self, _t: T, x: &DVector<T>, _u: &DVector<T>) -> DVector<T> {
        self.a.map(convert::<f64, T>) * x
    }

    fn output(&self, _t: T, x: &DVector<T>, _u: &Self::Input) -> DVector<T> {
        self.c.map(convert::<f64, T>) * x
    }
}

/// Van der Pol's oscillator with its states and its output in units of powers of two.
struct Rescaled {
    states: [i32; 2],
    output: i32,
}

luenberger_plants::plant!(
    Rescaled,
    (2, 0, 1),
    |plant, t, x, u| {
        let unit = plant.states.map(|power| convert::<f64, T>(2f64.powi(power)));
        let f = VanDerPol::default().derivative(t, &Vector2::new(x[0] * unit[0], x[1] * unit[1]), u);
        [f[0] / unit[0], f[1] / unit[1]]
    },
    [x[0] * convert::<f64, T>(2f64.powi(plant.states[0] + plant.output))]
);

#[test]
fn what_makes_no_sense_is_refused_with_its_numbers() {
    type E = ObservabilityError;
    let refused = |points: &[Instant], settings: LieSettings| {
        lie_observability(&VanDerPol::default(), points, &settings).unwrap_err()
    };
    let plain = LieSettings::default;
    let point = || Instant::new(0.0, &[1.0, 2.0]);
    assert_eq!(refused(&[], plain()), E::NoPoints);
    assert!(matches!(refused(&[Instant::new(0.0, &[1.0])], plain()), E::Length { expected: 2, found: 1, .. }));
    assert!(matches!(
        refused(&[point(), Instant::new(0.5, &[1.0, f64::NAN])], plain()),
        E::NotFinite { index: 1, t: 0.5, .. }
    ));
    assert!(matches!(refused(&[Instant::new(f64::NAN, &[1.0, 1.0])], plain()), E::NotFinite { what: "the time", .. }));
    assert!(matches!(refused(&[point().constant_input(&[1.0])], plain()), E::Length { expected: 0, found: 1, .. }));
    assert_eq!(refused(&[point()], LieSettings { order: Some(16), ..plain() }), E::Order { order: 16, highest: 15 });
    let scales = |scales: Vec<f64>| LieSettings { scales: Some(scales), ..plain() };
    assert_eq!(refused(&[point()], scales(vec![1.0])), E::Scales { expected: 2, found: 1 });
    assert_eq!(refused(&[point()], scales(vec![1.0, 0.0])), E::Scale { index: 1, value: 0.0 });
    assert!(matches!(refused(&[point()], LieSettings { tolerance: Some(1.5), ..plain() }), E::Tolerance { .. }));
    // A missing input is not taken for zero.
    assert!(matches!(
        lie_observability(&Steered, &[point()], &plain()),
        Err(E::Length { what: "the input", expected: 1, found: 0, .. })
    ));
    // The square root has no derivative at 0: y'' = sqrt(x1).
    let error = lie_observability(&Rooted, &[Instant::new(0.0, &[0.0, 1.0])], &plain()).unwrap_err();
    assert!(matches!(error, E::NotDifferentiable { order: 2, output: 0, state: 0, .. }), "{error}");
    assert!(error.to_string().contains("derivative 2 of y1 by x1"));
    // Overflow is no rank either.
    let huge = JetPlant { a: DMatrix::from_element(2, 2, 1e200), c: DMatrix::from_element(1, 2, 1.0) };
    let error = lie_observability(&huge, &[Instant::new(0.0, &[1.0, 2.0])], &plain()).unwrap_err();
    assert!(matches!(error, E::NotDifferentiable { .. }), "{error}");
}

#[test]
fn a_linear_plant_of_the_library_goes_through_the_same_door() {
    // Over jets its matrices are jets: the scalar of a LinearPlant is that of its entries.
    use luenberger_design::nonlinear_observability::Jet;
    let number = |m: DMatrix<f64>| m.map(convert::<f64, Jet>);
    let plant = LinearPlant::<Jet, Dyn, Dyn, Dyn> {
        a: number(DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0])),
        b: number(DMatrix::from_row_slice(2, 1, &[0.0, 1.0])),
        c: number(DMatrix::from_row_slice(1, 2, &[1.0, 0.0])),
        d: None,
    };
    let point = Instant::new(0.0, &[1.0, 1.0]).constant_input(&[3.0]);
    assert_eq!(lie_observability(&plant, &[point], &LieSettings::default()).unwrap().index(), Some(1));
}

#[test]
fn a_linear_pair_in_words() {
    // A decaying state that nothing sees, in units of a millionth, beside a seen pair.
    let a = DMatrix::from_row_slice(3, 3, &[0.0, 1.0, 0.0, -5.0, -2.0, 0.0, 1e6, 0.0, -3.0]);
    let seen = observability(&a, &DMatrix::from_row_slice(1, 3, &[1.0, 0.0, 0.0])).unwrap();
    let text = InWords { seen: &seen, names: &["position", "speed"] }.to_string();
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("rank 2 of 3"), "{text}");
    assert!(lines.iter().any(|line| line.starts_with("mode -1 + 2i: margin") && line.contains(", seen,")), "{text}");
    assert!(
        lines.iter().any(|line| line.starts_with("mode -3: margin") && line.contains(", hidden, least along x3")),
        "{text}"
    );
    assert_eq!(lines[lines.len() - 2..], ["x3 is unobservable", "the unobservable part is stable in continuous time"]);
    let all = observability(&a, &DMatrix::from_row_slice(1, 3, &[0.0, 0.0, 1.0])).unwrap();
    assert!(InWords { seen: &all, names: &[] }.to_string().ends_with("observable"));
}
