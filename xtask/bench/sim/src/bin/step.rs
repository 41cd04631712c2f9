//! Time, operations and allocations of one step of each sampled observer, with sizes known at compile time and not, as
//! a table.
//!
//! Each time is the least of many batches, all observers taking turns, so that a busy machine slows all alike.

#[path = "../../../../../crates/linalg/tests/counting_allocator/mod.rs"]
mod counting_allocator;

use counting_allocator::allocations;
use luenberger_export::moving_horizon::MovingHorizon;
use luenberger_export::{Export, ExportableObserver, Names, Scalar};
use luenberger_expression::{ExpressionPlant, Parameters};
use luenberger_observers::kalman::{ExtendedKalmanFilter, NoiseModel};
use luenberger_observers::moving_horizon::state_length;
use luenberger_observers::sliding_mode::Discretisation;
use luenberger_observers::{
    DiscreteLinearObserver, Horizon, KalmanFilter, KalmanModel, MovingHorizonEstimator, SampledCubicGains,
    SampledCubicObserver, SampledIntervalGains, SampledIntervalObserver, SampledNonlinearObserver, SampledObserver,
    SigmaPoints, SlidingModeObserver, UnscentedKalmanFilter, VaryingPeriodObserver, cubic,
};
use luenberger_plants::{Column, StateSpace, StaticPlant, double_integrator};
use multicalc::linear_algebra::{Matrix, Vector};
use nalgebra::{
    Complex, Const, DMatrix, DVector, Dyn, Matrix1, Matrix2, RowVector2, SMatrix, SVector, U1, Vector2, dmatrix,
    dvector,
};
use std::hint::black_box;
use std::time::Instant;

const PERIOD: f64 = 0.1;
const BATCH: usize = 10_000;
/// Of the moving-horizon estimator.
const SHORT_BATCH: usize = 5;
/// Samples in its window.
const WINDOW: usize = 10;
const BATCHES: usize = 60;

/// A line of the table: what runs a batch of steps.
struct Line {
    name: String,
    sizes: &'static str,
    operations: Option<usize>,
    /// Steps of a batch.
    batch: usize,
    run: Box<dyn FnMut(usize)>,
    best: f64,
    allocations: usize,
}

impl Line {
    fn new(name: &str, sizes: &'static str, operations: Option<usize>, run: impl FnMut(usize) + 'static) -> Self {
        let (name, run) = (name.to_owned(), Box::new(run));
        Self { name, sizes, operations, batch: BATCH, run, best: f64::INFINITY, allocations: 0 }
    }

    /// With batches of as many steps.
    fn batches(self, batch: usize) -> Self {
        Self { batch, ..self }
    }

    /// Batches of steps of an observer, each from the state that the one before left.
    fn of<O: SampledObserver<f64> + 'static>(
        name: &str,
        sizes: &'static str,
        operations: Option<usize>,
        observer: O,
        estimate: &[f64],
    ) -> Self
    where
        O::State: 'static,
        O::Input: 'static,
        O::Output: 'static,
    {
        let size = observer.dimensions();
        let u = O::Input::try_from_slice(&vec![0.3; size.inputs]).expect("the length that the observer says");
        let y = O::Output::try_from_slice(&vec![0.3; size.outputs]).expect("the length that the observer says");
        let start = O::Estimate::try_from_slice(estimate).expect("the length that the observer says");
        let mut state = observer.initial(0.0, &start, &u, &y);
        // The window of a moving-horizon estimator is full.
        for k in 0..2 * WINDOW {
            observer.step(k as f64 * PERIOD, &mut state, &u, &y);
        }
        Self::new(name, sizes, operations, move |batch| {
            for k in 0..batch {
                observer.step(k as f64 * PERIOD, black_box(&mut state), black_box(&u), black_box(&y));
            }
        })
    }

    fn measure(&mut self) {
        let start = Instant::now();
        let allocations = allocations(|| (self.run)(self.batch));
        self.best = self.best.min(start.elapsed().as_secs_f64() * 1e9 / self.batch as f64);
        self.allocations = allocations / self.batch;
    }
}

/// Floating-point operations of the exported step.
fn operations(program: ExportableObserver, states: usize) -> Option<usize> {
    let names = Names::numbered(states, program.plant_inputs(), 1);
    let export = Export::new("bench", program, Scalar::Binary64, &vec![0.1; states], names);
    Some(export.expect("it can be exported").operations())
}

/// A chain of n integrators, sampled, with the gains of its predictor and of its cubic observer.
struct Chain {
    ad: DMatrix<f64>,
    bd: DMatrix<f64>,
    c: DMatrix<f64>,
    ld: DMatrix<f64>,
    n: DMatrix<f64>,
}

impl Chain {
    fn new(n: usize) -> Self {
        let a = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(j == i + 1)));
        let b = DMatrix::from_fn(n, 1, |i, _| f64::from(u8::from(i + 1 == n)));
        let c = DMatrix::from_fn(1, n, |_, j| f64::from(u8::from(j == 0)));
        let held = luenberger_linalg::zero_order_hold(&a, &b, PERIOD).expect("a chain can be held");
        let poles: Vec<_> = (0..n).map(|k| Complex::from(0.3 + 0.1 * k as f64)).collect();
        let ld = luenberger_linalg::place_observer(&held.ad, &c, &poles).expect("a chain is observable").gain;
        let closed = &held.ad - &ld * &c;
        let p = luenberger_linalg::stein(&closed, &DMatrix::identity(n, n)).expect("the closed loop is stable").p;
        let gain = -p.try_inverse().expect("P > 0") * c.transpose();
        Self { ad: held.ad, bd: held.bd, c, ld, n: gain }
    }

    fn linear(&self) -> DiscreteLinearObserver<f64, Dyn, Dyn, Dyn> {
        let plant = StateSpace::new(self.ad.clone(), self.bd.clone(), self.c.clone()).expect("shapes fit");
        DiscreteLinearObserver::new(plant, self.ld.clone(), PERIOD).expect("shapes fit")
    }

    fn cubic(&self) -> SampledCubicObserver<f64, Dyn, Dyn, Dyn> {
        let w = cubic::rate(&self.c, &self.n);
        let Self { ad, bd, c, ld, n } = self;
        let (ad, bd, c, ld, n) = (ad.clone(), bd.clone(), c.clone(), ld.clone(), n.clone());
        SampledCubicObserver::new(SampledCubicGains { ad, bd, c, ld, n, theta: dmatrix![10.0], w, period: PERIOD })
            .expect("a radial gain")
    }

    fn lines<const N: usize>(&self, lines: &mut Vec<Line>) {
        let start = [0.1; N];
        let (linear, cubic) = (self.linear(), self.cubic());
        let count = operations(ExportableObserver::Linear(linear.clone()), N);
        let (name, fixed) = (format!("linear, n = {N}"), linear.to_static::<f64, N, 1, 1>().expect("its sizes"));
        lines.push(Line::of(&name, "static", count, fixed, &start));
        lines.push(Line::of(&name, "dynamic", count, linear, &start));
        let count = operations(ExportableObserver::Cubic(cubic.clone()), N);
        let (name, fixed) = (format!("sampled cubic, n = {N}"), cubic.to_static::<f64, N, 1, 1>().expect("its sizes"));
        lines.push(Line::of(&name, "static", count, fixed, &start));
        lines.push(Line::of(&name, "dynamic", count, cubic, &start));
    }

    fn filter<const N: usize>(&self, lines: &mut Vec<Line>)
    where
        KalmanFilter<f64, Const<N>, U1, U1>: SampledObserver<f64, State: 'static, Input: 'static, Output: 'static>,
    {
        let model = KalmanModel {
            ad: SMatrix::<f64, N, N>::from_fn(|i, j| self.ad[(i, j)]),
            bd: SVector::<f64, N>::from_fn(|i, _| self.bd[i]),
            c: SMatrix::<f64, 1, N>::from_fn(|_, j| self.c[j]),
            w: SMatrix::<f64, N, N>::identity() * 0.01,
            v: Matrix1::new(0.1),
            p0: SMatrix::<f64, N, N>::identity(),
            period: PERIOD,
        };
        let filter = KalmanFilter::new(model).expect("shapes fit");
        lines.push(Line::of(&format!("Kalman filter, n = {N}"), "static", None, filter, &[0.1; N]));
        self.peer::<N>(lines);
    }

    /// A filter of the crate multicalc, on the same plant.
    fn peer<const N: usize>(&self, lines: &mut Vec<Line>) {
        let matrix =
            |m: &DMatrix<f64>| Matrix::<N, N>::new(std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)])));
        let model = multicalc::estimation::KalmanModel {
            state_transition: matrix(&self.ad),
            measurement_model: Matrix::new([std::array::from_fn(|j| self.c[j])]),
            process_noise: matrix(&(DMatrix::identity(N, N) * 0.01)),
            measurement_noise: Matrix::new([[0.1]]),
        };
        let (start, doubt) = (Vector::new([0.1; N]), matrix(&DMatrix::identity(N, N)));
        let mut filter = multicalc::estimation::KalmanFilter::new(start, doubt, model);
        lines.push(Line::new(&format!("Kalman filter of multicalc, n = {N}"), "static", None, move |batch| {
            for _ in 0..batch {
                let filter = black_box(&mut filter);
                filter.update(black_box(Vector::new([0.3]))).expect("S > 0");
                filter.predict();
            }
        }));
    }
}

/// A pendulum in expressions.
fn pendulum() -> ExpressionPlant {
    ExpressionPlant::new(&["x2", "-9.81*sin(x1) - 0.1*x2 + u1"], &["x1"], 1, &Parameters::new()).expect("it is one")
}

fn nonlinear(lines: &mut Vec<Line>) {
    let (start, sigma) = ([0.1, 0.0], SigmaPoints::default());
    let fixed = || pendulum().fixed::<2, 1, 1>().expect("its sizes");
    let noises = || NoiseModel { w: DMatrix::identity(2, 2) * 0.01, v: dmatrix![0.1], p0: DMatrix::identity(2, 2) };
    let of_fixed = || NoiseModel { w: Matrix2::identity() * 0.01, v: Matrix1::new(0.1), p0: Matrix2::identity() };
    let copy = SampledNonlinearObserver::new(pendulum(), dmatrix![4.0; 6.0], 0.01, 1).expect("shapes fit");
    let count = operations(ExportableObserver::SampledNonlinear(copy.clone()), 2);
    let name = "copy of a pendulum, one Runge-Kutta step";
    let of_fixed_size =
        SampledNonlinearObserver::<_, f64, Const<2>, U1, U1>::new(fixed(), Vector2::new(4.0, 6.0), 0.01, 1);
    lines.push(Line::of(name, "static", count, of_fixed_size.expect("shapes fit"), &start));
    lines.push(Line::of(name, "dynamic", count, copy, &start));
    let filter = ExtendedKalmanFilter::new(pendulum(), noises(), 0.01, 1).expect("shapes fit");
    let count = operations(ExportableObserver::Kalman(filter.clone()), 2);
    let name = "extended Kalman filter of a pendulum";
    let of_fixed_size = ExtendedKalmanFilter::<_, f64, Const<2>, U1, U1>::new(fixed(), of_fixed(), 0.01, 1);
    lines.push(Line::of(name, "static", count, of_fixed_size.expect("shapes fit"), &start));
    lines.push(Line::of(name, "dynamic", count, filter, &start));
    let filter = UnscentedKalmanFilter::new(pendulum(), noises(), sigma, 0.01, 1).expect("shapes fit");
    let count = operations(ExportableObserver::Unscented(filter.clone()), 2);
    let name = "unscented Kalman filter of a pendulum";
    let of_fixed_size = UnscentedKalmanFilter::<_, f64, Const<2>, U1, U1>::new(fixed(), of_fixed(), sigma, 0.01, 1);
    lines.push(Line::of(name, "static", count, of_fixed_size.expect("shapes fit"), &start));
    lines.push(Line::of(name, "dynamic", count, filter, &start));
}

/// The moving-horizon estimator of a pendulum in expressions, and of a double integrator, with a bound of the first
/// state that the measurements violate and without.
fn moving_horizon(lines: &mut Vec<Line>) {
    const STATE: usize = state_length(2, 1, 1, WINDOW);
    type Fixed = MovingHorizonEstimator<StaticPlant<f64, 2, 1, 1>, f64, Const<2>, U1, U1, Const<STATE>, WINDOW>;
    let horizon = Horizon { window: WINDOW, iterations: 1 };
    let noises = NoiseModel { w: DMatrix::identity(2, 2) * 0.01, v: dmatrix![0.1], p0: DMatrix::identity(2, 2) };
    let free = MovingHorizon::new(pendulum(), noises, horizon, 0.01, 1).expect("shapes fit");
    let far = DVector::from_element(2, f64::INFINITY);
    let bounded = free.clone().with_bounds(-&far, dvector![-0.1, f64::INFINITY]).expect("below");
    let noises = NoiseModel { w: Matrix2::identity() * 0.01, v: Matrix1::new(0.1), p0: Matrix2::identity() };
    let fixed = Fixed::new(double_integrator(), noises, horizon, 0.01, 1).expect("shapes fit");
    let far = Vector2::repeat(f64::INFINITY);
    let fixed_bounded = fixed.clone().with_bounds(-far, Vector2::new(-0.1, f64::INFINITY)).expect("below");
    let start = [0.05, 0.0];
    for (what, estimator, fixed) in [("no bound", free, fixed), ("an active bound", bounded, fixed_bounded)] {
        let count = operations(ExportableObserver::MovingHorizon(estimator.clone()), 2);
        let name = format!("moving-horizon estimator of a pendulum, {WINDOW} samples, {what}");
        lines.push(Line::of(&name, "dynamic", count, estimator, &start).batches(SHORT_BATCH));
        let name = format!("moving-horizon estimator of a double integrator, {WINDOW} samples, {what}");
        lines.push(Line::of(&name, "static", None, fixed, &start).batches(SHORT_BATCH));
    }
}

/// The sampled observers of a double integrator with a step of their own: sliding-mode, interval, varying periods.
fn of_a_double_integrator(chain: &Chain, lines: &mut Vec<Line>) {
    let start = [0.1, 0.0];
    let sliding = SlidingModeObserver::<_, f64, Const<2>, U1, U1>::new(
        double_integrator(),
        Vector2::new(2.1, 1.1),
        PERIOD,
        Discretisation::Implicit,
    );
    lines.push(Line::of("sliding-mode observer, n = 2", "static", None, sliding.expect("shapes fit"), &start));
    let l = Vector2::from_fn(|i, _| chain.ld[i]);
    let c = RowVector2::from_fn(|_, j| chain.c[j]);
    let f = Matrix2::from_fn(|i, j| chain.ad[(i, j)]) - l * c;
    let gains = SampledIntervalGains {
        f,
        g: Vector2::from_fn(|i, _| chain.bd[i]),
        c,
        l,
        blocks: f.abs(),
        constant: Vector2::repeat(1e-3),
        of_estimate: Matrix2::repeat(1e-15),
        of_input: Vector2::repeat(1e-15),
        h: Matrix2::identity(),
        outward: 1e-15,
        start: Vector2::repeat(1.0),
        period: PERIOD,
    };
    let interval = SampledIntervalObserver::<f64, Const<2>, U1, U1, Const<2>, Const<4>>::new(gains);
    lines.push(Line::of("interval observer, n = 2", "static", None, interval.expect("shapes fit"), &start));
    let (a, b) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
    let varying = VaryingPeriodObserver::new(chain.cubic(), a, b, &chain.ld / PERIOD, 3.0 * PERIOD);
    let program = ExportableObserver::varying(&varying.expect("shapes fit")).expect("a step");
    let count = operations(program.clone(), 2);
    if let ExportableObserver::Varying(step) = program {
        lines.push(Line::of("sampled cubic at varying periods, n = 2", "dynamic", count, step, &start));
    }
}

fn main() {
    let mut lines = Vec::new();
    let chains = [2, 3, 6].map(Chain::new);
    chains[0].lines::<2>(&mut lines);
    chains[1].lines::<3>(&mut lines);
    chains[2].lines::<6>(&mut lines);
    chains[0].filter::<2>(&mut lines);
    chains[1].filter::<3>(&mut lines);
    chains[2].filter::<6>(&mut lines);
    of_a_double_integrator(&chains[0], &mut lines);
    nonlinear(&mut lines);
    moving_horizon(&mut lines);
    for _ in 0..BATCHES {
        lines.iter_mut().for_each(Line::measure);
    }
    println!("| step | sizes | ns | operations | allocations |\n|---|---|---:|---:|---:|");
    for Line { name, sizes, operations, best, allocations, .. } in lines {
        let operations = operations.map_or_else(|| "-".to_owned(), |count| count.to_string());
        println!("| {name} | {sizes} | {best:.0} | {operations} | {allocations} |");
    }
}
