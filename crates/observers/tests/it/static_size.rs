//! Observers with the sizes and the scalar of the target, from designed ones.

use luenberger_observers::{
    CubicObserver, DiscreteLinearObserver, FunctionalObserver, KalmanFilter, KalmanModel, LinearObserver, MatrixName,
    Observer, ObserverError, ProportionalIntegralObserver, SampledCubicGains, SampledCubicObserver,
    SampledIntervalGains, SampledIntervalObserver, SampledObserver, StationaryKalmanFilter, UnknownInputObserver,
    VaryingPeriodObserver, cubic,
};
use luenberger_plants::{Column, StateSpace};
use nalgebra::{DMatrix, DVector, Dyn, RealField, SVector, Vector1, Vector2, convert, dmatrix};
use proptest::prelude::*;

#[test]
fn the_steps_are_those_of_the_designed_observers() -> Result<(), ObserverError> {
    let (ad, bd, c) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1], dmatrix![1.0, 0.0]);
    let (ld, n) = (dmatrix![0.9; 2.0], dmatrix![-1.0; -1.5]);
    let w = cubic::rate(&c, &n);
    let gains = SampledCubicGains { ad, bd, c, ld, n, theta: dmatrix![10.0], w, period: 0.1 };
    let designed = SampledCubicObserver::new(gains.clone())?;
    let (double, single) = (designed.to_static::<f64, 2, 1, 1>()?, designed.to_static::<f32, 2, 1, 1>()?);
    let model = KalmanModel {
        ad: gains.ad,
        bd: gains.bd,
        c: gains.c,
        w: dmatrix![0.0, 0.0; 0.0, 0.01],
        v: dmatrix![0.04],
        p0: DMatrix::identity(2, 2),
        period: 0.1,
    };
    let filter = KalmanFilter::new(model)?;
    let target = filter.to_static::<f64, 2, 1, 1>()?;

    let (mut x, mut on_desk) = (Vector2::zeros(), DVector::zeros(2));
    let mut x32 = nalgebra::Vector2::<f32>::zeros();
    let start = (DVector::zeros(2), DVector::zeros(1), DVector::zeros(1));
    let mut estimate = filter.initial(0.0, &start.0, &start.1, &start.2);
    let mut on_target = target.initial(0.0, &Vector2::zeros(), &Vector1::zeros(), &Vector1::zeros());
    for k in 0..50 {
        let t = 0.1 * f64::from(k);
        let (u, y) = ((0.7 * t).sin(), 1.0 + (0.3 * t).cos());
        let (du, dy) = (DVector::from_element(1, u), DVector::from_element(1, y));
        designed.step(t, &mut on_desk, &du, &dy);
        double.step(t, &mut x, &Vector1::new(u), &Vector1::new(y));
        single.step(t as f32, &mut x32, &Vector1::new(u as f32), &Vector1::new(y as f32));
        filter.step(t, &mut estimate, &du, &dy);
        target.step(t, &mut on_target, &Vector1::new(u), &Vector1::new(y));
        assert!((on_desk[0] - x[0]).abs() + (on_desk[1] - x[1]).abs() < 1e-13);
        assert!((f64::from(x32[0]) - x[0]).abs() + (f64::from(x32[1]) - x[1]).abs() < 1e-4);
        let gap = estimate.estimate() - DVector::from_column_slice(on_target.estimate().as_slice());
        assert!(gap.amax() < 1e-13);
    }
    Ok(())
}

#[test]
fn other_sizes_and_entries_beyond_the_scalar_are_errors() -> Result<(), ObserverError> {
    let plant = luenberger_plants::double_integrator().to_dynamic();
    let observer = LinearObserver::of(plant, dmatrix![7.0; 1e39])?;
    assert!(observer.to_static::<f64, 2, 1, 1>().is_ok());
    let error = observer.to_static::<f64, 2, 0, 1>().unwrap_err();
    assert_eq!(error.to_string(), "B must be 2 x 0, found 2 x 1");
    let error = observer.to_static::<f32, 2, 1, 1>().unwrap_err();
    assert_eq!(error.to_string(), "L(2, 1) is inf, not a finite number");
    Ok(())
}

const STATES: usize = 7;
const PLANT_STATES: usize = 5;
const INPUTS: usize = 2;
const OUTPUTS: usize = 3;
const BLOCKS: usize = 4;
const WITH_BLOCKS: usize = STATES + BLOCKS;
const FUNCTIONS: usize = 6;

type Linear = LinearObserver<f64, Dyn, Dyn, Dyn>;
type Cubic = CubicObserver<f64, Dyn, Dyn, Dyn>;

/// Numbers that are handed out one after the other, for ever.
struct Numbers<'a>(std::iter::Cycle<std::slice::Iter<'a, f64>>);

impl<'a> Numbers<'a> {
    fn new(numbers: &'a [f64]) -> Self {
        Self(numbers.iter().cycle())
    }

    fn matrix(&mut self, rows: usize, columns: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |_, _| *self.0.next().unwrap())
    }

    fn column(&mut self, length: usize) -> DVector<f64> {
        DVector::from_fn(length, |_, _| *self.0.next().unwrap())
    }

    fn plant(&mut self) -> StateSpace {
        let (a, b, c) = (self.matrix(STATES, STATES), self.matrix(STATES, INPUTS), self.matrix(OUTPUTS, STATES));
        StateSpace { a, b, c, d: Some(self.matrix(OUTPUTS, INPUTS)) }
    }

    fn linear(&mut self) -> Linear {
        LinearObserver::of(self.plant(), self.matrix(STATES, OUTPUTS)).unwrap()
    }

    fn cubic(&mut self) -> Cubic {
        let (plant, l, n) = (self.plant(), self.matrix(STATES, OUTPUTS), self.matrix(STATES, OUTPUTS));
        CubicObserver::of(plant, l, n, self.matrix(OUTPUTS, OUTPUTS)).unwrap()
    }

    fn with_disturbance<O: Observer<f64>>(inner: O) -> ProportionalIntegralObserver<O, Dyn> {
        ProportionalIntegralObserver::new(inner, Dyn(PLANT_STATES)).unwrap()
    }

    fn without_disturbance<O: Observer<f64>>(&mut self, inner: O) -> UnknownInputObserver<O, f64, Dyn, Dyn, Dyn> {
        let d = self.matrix(OUTPUTS, INPUTS);
        UnknownInputObserver::new(inner, self.matrix(STATES, OUTPUTS), Some(d)).unwrap()
    }

    fn functional(&mut self) -> FunctionalObserver<f64, Dyn, Dyn, Dyn> {
        let (f, g) = (self.matrix(FUNCTIONS, FUNCTIONS), self.matrix(FUNCTIONS, OUTPUTS));
        FunctionalObserver::new(f, g, self.matrix(FUNCTIONS, INPUTS), self.matrix(FUNCTIONS, OUTPUTS)).unwrap()
    }

    fn interval(&mut self) -> SampledIntervalObserver<f64, Dyn, Dyn, Dyn, Dyn, Dyn> {
        let StateSpace { a: f, b: g, c, .. } = self.plant();
        SampledIntervalObserver::new(SampledIntervalGains {
            f,
            g,
            c,
            l: self.matrix(STATES, OUTPUTS),
            blocks: self.matrix(BLOCKS, BLOCKS).abs(),
            constant: self.column(BLOCKS).abs(),
            of_estimate: self.matrix(BLOCKS, STATES).abs(),
            of_input: self.matrix(BLOCKS, INPUTS).abs(),
            h: self.matrix(STATES, BLOCKS).abs(),
            outward: self.matrix(1, 1)[0].abs(),
            start: self.column(BLOCKS).abs(),
            period: 0.125,
        })
        .unwrap()
    }

    fn stationary(&mut self) -> StationaryKalmanFilter<f64, Dyn, Dyn, Dyn> {
        let predictor = DiscreteLinearObserver::new(self.plant(), self.matrix(STATES, OUTPUTS), 0.125).unwrap();
        StationaryKalmanFilter::new(predictor, self.matrix(STATES, OUTPUTS)).unwrap()
    }

    /// With the rate w of the cubic flow; `C N = -w I` because the outputs are the first states.
    fn varying(&mut self, w: f64) -> VaryingPeriodObserver<f64, Dyn, Dyn, Dyn> {
        let mut n = self.matrix(STATES, OUTPUTS) * w;
        n.rows_mut(0, OUTPUTS).copy_from(&(DMatrix::identity(OUTPUTS, OUTPUTS) * -w));
        let StateSpace { a: ad, b: bd, .. } = self.plant();
        let (c, theta) = (DMatrix::identity(OUTPUTS, STATES), DMatrix::identity(OUTPUTS, OUTPUTS));
        let gains = SampledCubicGains { ad, bd, c, ld: self.matrix(STATES, OUTPUTS), n, theta, w, period: 0.125 };
        let nominal = SampledCubicObserver::new(gains).unwrap().with_feedthrough(self.matrix(OUTPUTS, INPUTS)).unwrap();
        let StateSpace { a, b, .. } = self.plant();
        VaryingPeriodObserver::new(nominal, a, b, self.matrix(STATES, OUTPUTS), 0.375).unwrap()
    }
}

fn column<T: RealField + Copy, C: Column<T>>(entries: &DVector<f64>) -> C {
    C::from_slice(&entries.iter().map(|x| convert(*x)).collect::<Vec<T>>())
}

fn bits<T: RealField + Copy>(entries: &[T]) -> Vec<u64> {
    entries.iter().map(|x| f64::to_bits(x.to_subset_unchecked())).collect()
}

/// The results of a continuous observer: first state, right-hand side and estimate.
fn continuous<T: RealField + Copy, O: Observer<T>>(observer: &O, mut numbers: Numbers<'_>) -> [Vec<u64>; 3] {
    let size = observer.dimensions();
    let mut next = |length| numbers.column(length);
    let (x, estimate, u, y) = (next(size.state), next(size.estimate), next(size.inputs), next(size.outputs));
    let (x, estimate, u, y): (O::State, O::Estimate, _, _) = (column(&x), column(&estimate), column(&u), column(&y));
    [
        bits(observer.initial(T::zero(), &estimate, &u, &y).as_slice()),
        bits(observer.derivative(T::zero(), &x, &u, &y).as_slice()),
        bits(observer.estimate(T::zero(), &x, &u, &y).as_slice()),
    ]
}

/// The results of a sampled observer: first state, next state and estimate at the sample.
fn sampled<T: RealField + Copy, O: SampledObserver<T>>(observer: &O, mut numbers: Numbers<'_>) -> [Vec<u64>; 3] {
    let size = observer.dimensions();
    let mut next = |length| numbers.column(length);
    let (x, estimate, u, y) = (next(size.state), next(size.estimate), next(size.inputs), next(size.outputs));
    let (x, estimate, u, y): (O::State, O::Estimate, _, _) = (column(&x), column(&estimate), column(&u), column(&y));
    let mut after = x.clone();
    observer.step(T::zero(), &mut after, &u, &y);
    [
        bits(observer.initial(T::zero(), &estimate, &u, &y).as_slice()),
        bits(after.as_slice()),
        bits(observer.estimate_at(&x, &u, &y).as_slice()),
    ]
}

/// Asserts that the static observers over `T` have the results of the designed ones, as numbers.
fn same_results<T: RealField + Copy>(numbers: &[f64], w: f64) -> Result<(), ObserverError> {
    let mut next = Numbers::new(numbers);
    let at = || Numbers::new(&numbers[1..]);

    let designed = next.functional();
    let target = designed.to_static::<T, FUNCTIONS, INPUTS, OUTPUTS>()?;
    assert_eq!(continuous(&target, at()), continuous(&designed, at()));
    assert_eq!(continuous(&designed.cast::<T>()?, at()), continuous(&designed, at()));

    let (linear, cubic) = (next.linear(), next.cubic());
    let designed = Numbers::with_disturbance(linear.clone());
    let target = designed.to_static::<T, PLANT_STATES, STATES, INPUTS, OUTPUTS>()?;
    assert_eq!(continuous(&target, at()), continuous(&designed, at()));
    let designed = Numbers::with_disturbance(cubic.clone());
    let target = designed.to_static::<T, PLANT_STATES, STATES, INPUTS, OUTPUTS>()?;
    assert_eq!(continuous(&target, at()), continuous(&designed, at()));

    let designed = next.without_disturbance(linear);
    let target = designed.to_static::<T, STATES, INPUTS, OUTPUTS>()?;
    assert_eq!(continuous(&target, at()), continuous(&designed, at()));
    assert_eq!(continuous(&designed.cast::<T>()?, at()), continuous(&designed, at()));
    let designed = next.without_disturbance(cubic);
    let target = designed.to_static::<T, STATES, INPUTS, OUTPUTS>()?;
    assert_eq!(continuous(&target, at()), continuous(&designed, at()));
    assert_eq!(continuous(&designed.cast::<T>()?, at()), continuous(&designed, at()));

    let designed = next.stationary();
    let target = designed.to_static::<T, STATES, INPUTS, OUTPUTS>()?;
    assert_eq!(sampled(&target, at()), sampled(&designed, at()));
    assert_eq!(sampled(&designed.cast::<T>()?, at()), sampled(&designed, at()));

    let designed = next.interval();
    let target = designed.to_static::<T, STATES, INPUTS, OUTPUTS, BLOCKS, WITH_BLOCKS>()?;
    assert_eq!(sampled(&target, at()), sampled(&designed, at()));
    assert_eq!(sampled(&designed.cast::<T>()?, at()), sampled(&designed, at()));
    let state = at().column(WITH_BLOCKS);
    let on_target: SVector<T, WITH_BLOCKS> = column(&state);
    let widths = target.half_widths(on_target.as_slice());
    assert_eq!(bits(widths.as_slice()), bits(designed.half_widths(state.as_slice()).as_slice()));

    let designed = next.varying(w);
    let target = designed.to_static::<T, STATES, INPUTS, OUTPUTS>()?;
    assert_eq!(continuous(&target, at()), continuous(&designed, at()));
    assert_eq!(continuous(&designed.cast::<T>()?, at()), continuous(&designed, at()));
    let (mut x, u, y) = (next.column(STATES), next.column(INPUTS), next.column(OUTPUTS));
    let (mut on_target, held, measured) = (column(&x), column(&u), column(&y));
    designed.correct(&mut x, &u, &y, 0.25);
    target.correct(&mut on_target, &held, &measured, convert(0.25));
    assert_eq!(bits(on_target.as_slice()), bits(x.as_slice()));
    Ok(())
}

proptest! {
    /// The order of operations does not depend on whether the sizes are known at compile time.
    #[test]
    fn static_results_are_the_designed_ones_bit_for_bit(
        numbers in prop::collection::vec(-1.0..1.0_f64, 997),
        w in 0.1..2.0_f64,
    ) {
        same_results::<f64>(&numbers, w).unwrap();
        let mut next = Numbers::new(&numbers);
        let designed = next.varying(w);
        let target = designed.to_static::<f64, STATES, INPUTS, OUTPUTS>().unwrap();
        let (mut x, u) = (next.column(STATES), next.column(INPUTS));
        let (mut on_target, held) = (column(&x), column(&u));
        designed.predict(&mut x, &u, 0.3);
        target.predict(&mut on_target, &held, 0.3);
        prop_assert_eq!(bits(on_target.as_slice()), bits(x.as_slice()));
    }

    /// With the entries -1, 0 and 1 every sum of these right-hand sides is an integer below 2^24, and exact in
    /// binary32: in the largest one, `N r (r'theta r)` of the unknown-input observer, `|r_i| <= 1 + 7 (1 + 3 (1 + 2)) +
    /// 2 = 73`, and `3 * 73 * 9 * 73^2 < 2^24`. Without cubic part, w = 0, nothing is divided in a correction either.
    #[test]
    fn in_f32_they_are_exact_for_small_integers(numbers in prop::collection::vec((-1..=1).prop_map(f64::from), 997)) {
        same_results::<f32>(&numbers, 0.0).unwrap();
    }
}

/// What is wrong with the sizes.
fn misfit<O>(target: Result<O, ObserverError>) -> String {
    target.err().unwrap().to_string()
}

#[test]
fn wrong_sizes_are_errors() {
    let numbers: Vec<f64> = (0..97_u32).map(f64::from).collect();
    let mut next = Numbers::new(&numbers);
    let functional = next.functional();
    assert_eq!(misfit(functional.to_static::<f64, 5, 2, 3>()), "F must be 5 x 5, found 6 x 6");
    assert_eq!(misfit(functional.to_static::<f64, 6, 1, 3>()), "H must be 6 x 1, found 6 x 2");
    assert_eq!(misfit(functional.to_static::<f64, 6, 2, 2>()), "G must be 6 x 2, found 6 x 3");

    let (linear, cubic) = (next.linear(), next.cubic());
    let designed = Numbers::with_disturbance(linear.clone());
    assert_eq!(misfit(designed.to_static::<f64, 4, 7, 2, 3>()), "the state must be 4 x 1, found 5 x 1");
    assert_eq!(misfit(designed.to_static::<f64, 5, 6, 2, 3>()), "A must be 6 x 6, found 7 x 7");
    let designed = Numbers::with_disturbance(cubic.clone());
    assert_eq!(misfit(designed.to_static::<f64, 7, 7, 2, 3>()), "the state must be 7 x 1, found 5 x 1");
    let designed = next.without_disturbance(linear);
    assert_eq!(misfit(designed.to_static::<f64, 7, 0, 3>()), "D must be 3 x 0, found 3 x 2");
    let designed = next.without_disturbance(cubic);
    assert_eq!(misfit(designed.to_static::<f64, 6, 2, 3>()), "A must be 6 x 6, found 7 x 7");

    let stationary = next.stationary();
    assert_eq!(misfit(stationary.to_static::<f64, 7, 2, 1>()), "C must be 1 x 7, found 3 x 7");
    let varying = next.varying(1.0);
    assert_eq!(misfit(varying.to_static::<f64, 7, 3, 3>()), "Bd must be 7 x 3, found 7 x 2");
    let interval = next.interval();
    assert_eq!(misfit(interval.to_static::<f64, 7, 2, 3, 5, 12>()), "N must be 5 x 5, found 4 x 4");
    let sum = misfit(interval.to_static::<f64, 7, 2, 3, 4, 12>());
    assert_eq!(sum, "(xhat, rho) must be 11 x 1, found 12 x 1");
}

/// Each matrix by its name, in the order of files; the constructor checks what is made of them.
#[test]
fn matrices_are_mapped_by_their_names() {
    let numbers: Vec<f64> = (0..97_u32).map(f64::from).collect();
    let mut next = Numbers::new(&numbers);
    let (linear, varying) = (next.linear(), next.varying(1.0));
    let mut names = Vec::new();
    let same: Linear = linear
        .map(|name, m| {
            names.push(name.text());
            m.clone()
        })
        .unwrap();
    assert_eq!(same, linear);
    assert_eq!(names, ["A", "B", "C", "L", "D"]);
    names.clear();
    let same: VaryingPeriodObserver<f64, Dyn, Dyn, Dyn> = varying
        .map(|name, m| {
            names.push(name.text());
            m.clone()
        })
        .unwrap();
    assert_eq!(same, varying);
    assert_eq!(names, ["Ad", "Bd", "C", "Ld", "N", "theta", "D", "A", "B", "K"]);
    // An input more, which needs a column in D, too.
    let wider = |names: &'static [MatrixName]| {
        move |name, m: &DMatrix<f64>| {
            if names.contains(&name) { m.clone().insert_column(m.ncols(), 0.0) } else { m.clone() }
        }
    };
    let more: Linear = linear.map(wider(&[MatrixName::B, MatrixName::D])).unwrap();
    assert_eq!(more.dimensions().inputs, INPUTS + 1);
    assert_eq!(misfit(linear.map::<f64, Dyn, Dyn, Dyn>(wider(&[MatrixName::B]))), "D must be 3 x 3, found 3 x 2");
}

/// A line for each matrix with entries and for each number; another observer has lines of its own.
#[test]
fn the_text_has_a_line_for_each_number() {
    let plant = StateSpace { a: dmatrix![0.5], b: DMatrix::zeros(1, 0), c: dmatrix![2.0], d: None };
    let observer = DiscreteLinearObserver::new(plant, dmatrix![0.25], 0.1).unwrap();
    assert_eq!(format!("{observer:.2}"), "A = [0.50]\nC = [2.00]\nL = [0.25]\nperiod = 0.10");
    let plant = luenberger_plants::double_integrator().to_dynamic().with_feedthrough(dmatrix![0.5]).unwrap();
    let observer = LinearObserver::of(plant, dmatrix![7.0; 10.0]).unwrap();
    assert_eq!(observer.to_string(), "A = [0, 1; 0, 0]\nB = [0; 1]\nC = [1, 0]\nL = [7; 10]\nD = [0.5]");
    let gains = SampledCubicGains {
        ad: dmatrix![0.5],
        bd: DMatrix::zeros(1, 0),
        c: dmatrix![1.0],
        ld: dmatrix![0.25],
        n: dmatrix![-2.0],
        theta: dmatrix![3.0],
        w: 2.0,
        period: 0.1,
    };
    let nominal = SampledCubicObserver::new(gains).unwrap();
    let varying =
        VaryingPeriodObserver::new(nominal, dmatrix![-7.0], DMatrix::zeros(1, 0), dmatrix![0.5], 0.3).unwrap();
    let nominal = "Ad = [0.5]\nC = [1]\nLd = [0.25]\nN = [-2]\ntheta = [3]\nw = 2\nperiod = 0.1";
    assert_eq!(varying.to_string(), format!("{nominal}\nA = [-7]\nK = [0.5]\nlongest = 0.3"));
}

#[test]
fn a_factor_beyond_the_range_of_the_scalar_is_an_error() -> Result<(), ObserverError> {
    let interval = Numbers::new(&[1.0]).interval();
    let designed = SampledIntervalObserver::new(SampledIntervalGains { outward: 1e39, ..interval.gains().clone() })?;
    let designed: SampledIntervalObserver<f64, Dyn, Dyn, Dyn, Dyn, Dyn> = designed;
    assert!(designed.to_static::<f64, 7, 2, 3, 4, 11>().is_ok());
    assert!(misfit(designed.to_static::<f32, 7, 2, 3, 4, 11>()).starts_with("outward is inf"));
    Ok(())
}
