//! Designs on their targets: the observers of `luenberger-observers` run in f32, against the ball that is proved of
//! them.

mod adversary;
mod intermediates;
mod recorded;

use luenberger_design::{LinearDesign, LyapunovWeight, SampledCubicDesign, deployed_linear};
use luenberger_linalg::{place_observer, zero_order_hold};
use luenberger_observers::{LinearObserver, Observer, SampledCubicGains, SampledCubicObserver, SampledObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::statement::{Deployed, Format, NoErrorBallReason, Operation, Running, Step};
use luenberger_proof::{Matrix, Verdict};
use nalgebra::{Complex, DMatrix, DVector, Dyn, dmatrix};

type Columns = DVector<f64>;

fn single(m: &Matrix<f64>) -> DMatrix<f32> {
    DMatrix::from_fn(m.rows(), m.cols(), |i, j| m[(i, j)] as f32)
}

struct Trajectory {
    x: Vec<Columns>,
    u: Vec<Columns>,
}

impl Trajectory {
    /// The plant from 0 under a feedback that keeps it near a moving target, its inputs numbers of f32.
    fn of(plant: &StateSpace, k: &DMatrix<f64>, steps: usize, amplitude: f64) -> Self {
        let (n, m) = plant.b.shape();
        let mut x = Columns::from_element(n, 0.1 * amplitude);
        let mut run = Self { x: Vec::new(), u: Vec::new() };
        for step in 0..steps {
            let target = Columns::from_fn(m, |j, _| amplitude * (0.013 * step as f64 * (1.0 + j as f64)).sin());
            let u = (target - k * &x).map(|u| f64::from(u as f32));
            let next = &plant.a * &x + &plant.b * &u;
            run.x.push(x);
            run.u.push(u);
            x = next;
        }
        run
    }

    /// The promise that this run keeps.
    fn operation(&self, outputs: usize, error: f64) -> Operation {
        let largest = |list: &[Columns]| -> Vec<f64> {
            (0..list[0].len()).map(|i| list.iter().map(|v| v[i].abs()).fold(0.0, f64::max)).collect()
        };
        let state = largest(&self.x);
        Operation {
            error: vec![error; state.len()],
            input: largest(&self.u),
            noise: vec![0.0; outputs],
            state,
            deviation: None,
        }
    }

    /// The largest `|e_i|` of the last half as a share of its bound; the error never exceeds the ball of the start.
    fn compare(
        &self,
        deployed: &Deployed,
        p: &DMatrix<f64>,
        c: &DMatrix<f64>,
        first: &DVector<f32>,
        mut step: impl FnMut(&DVector<f32>, &DVector<f32>, &DVector<f32>) -> DVector<f32>,
    ) -> f64 {
        let ball = deployed.ball().unwrap_or_else(|| panic!("{:?}", deployed.running));
        let mut xhat = first.clone();
        let mut share = 0.0_f64;
        for (k, (x, u)) in self.x.iter().zip(&self.u).enumerate() {
            let e = x - xhat.map(f64::from);
            let norm = (e.transpose() * p * &e)[0].sqrt();
            assert!(norm <= ball.start * (1.0 + 1e-9), "step {k}: |e|_P = {norm:e}, start {:e}", ball.start);
            if 2 * k > self.x.len() {
                share = e.iter().zip(&ball.entries).map(|(e, bound)| e.abs() / bound).fold(share, f64::max);
            }
            let y = (c * x).map(|y| y as f32);
            xhat = step(&xhat, &u.map(|u| u as f32), &y);
        }
        assert!(share <= 1.0, "the error ends at {share} of its bound");
        share
    }
}

/// Sampled plants with a stabilising feedback and a gain: name, plant, K, L.
fn zoo() -> Vec<(&'static str, StateSpace, DMatrix<f64>, DMatrix<f64>)> {
    let sampled = |a: DMatrix<f64>, b: DMatrix<f64>, c: DMatrix<f64>, h: f64, k: DMatrix<f64>, poles: &[f64]| {
        let held = zero_order_hold(&a, &b, h).unwrap();
        let poles: Vec<Complex<f64>> = poles.iter().map(|s| Complex::from((s * h).exp())).collect();
        let l = place_observer(&held.ad, &c, &poles).unwrap().gain;
        (StateSpace::new(held.ad, held.bd, c).unwrap(), k, l)
    };
    let (double, k2, l2) = sampled(
        dmatrix![0.0, 1.0; 0.0, 0.0],
        dmatrix![0.0; 1.0],
        dmatrix![1.0, 0.0],
        0.01,
        dmatrix![1.0, 1.5],
        &[-8.0, -12.0],
    );
    let (motor, k3, l3) = sampled(
        // Position, speed and current of a motor.
        dmatrix![0.0, 1.0, 0.0; 0.0, -0.5, 2.0; 0.0, -1.0, -10.0],
        dmatrix![0.0; 0.0; 10.0],
        dmatrix![1.0, 0.0, 0.0; 0.0, 0.0, 1.0],
        0.005,
        dmatrix![2.0, 0.8, 0.1],
        &[-20.0, -25.0, -40.0],
    );
    let (chain, k4, l4) = sampled(
        // Two masses on springs, the first measured.
        dmatrix![0.0, 0.0, 1.0, 0.0; 0.0, 0.0, 0.0, 1.0; -2.0, 1.0, -0.2, 0.1; 1.0, -1.0, 0.1, -0.1],
        dmatrix![0.0; 0.0; 1.0; 0.0],
        dmatrix![1.0, 0.0, 0.0, 0.0],
        0.05,
        dmatrix![0.0, 0.0, 0.5, 0.2],
        &[-2.0, -2.5, -3.0, -3.5],
    );
    vec![("double integrator", double, k2, l2), ("motor", motor, k3, l3), ("two masses", chain, k4, l4)]
}

#[test]
fn the_linear_observer_in_single_precision_stays_in_its_ball() {
    for (name, plant, k, l) in zoo() {
        let run = Trajectory::of(&plant, &k, 4000, 1.0);
        let operation = run.operation(plant.c.nrows(), 1.0);
        for step in [Step::Innovation, Step::Joined] {
            let found = deployed_linear(&plant, &l, step, Format::Binary32.into(), &operation).unwrap();
            let s = &found.deployed.stored;
            assert!(found.deployed.is_stable());
            // The innovation form is the house's own observer with the sampled matrices: its "derivative" is the next
            // estimate.
            let observer =
                LinearObserver::<f32, Dyn, Dyn, Dyn>::new(single(&s.a), single(&s.b), single(&s.c), single(&s.l));
            let observer = observer.unwrap();
            let first = DVector::zeros(plant.a.nrows());
            let share = run.compare(&found.deployed, &found.p, &plant.c, &first, |xhat, u, y| match step {
                Step::Innovation | Step::Accumulated => observer.derivative(0.0, xhat, u, y),
                Step::Joined => &observer.a * xhat + &observer.b * u + &observer.l * y,
            });
            println!(
                "{name}, {step:?}: the error seen is 1/{:.0} of its bound, {:?}",
                1.0 / share,
                found.deployed.ball().map(|ball| &ball.entries)
            );
            assert!(share > 1e-3, "{name}: the bound is {} times the error seen", 1.0 / share);
        }
    }
}

#[test]
fn the_sampled_cubic_observer_in_single_precision_stays_in_its_ball() {
    let plant = luenberger_plants::double_integrator().to_dynamic();
    let linear = LinearDesign::with_poles_and_weight(&plant, &[-2.0, -5.0], LyapunovWeight::Identity(10.0)).unwrap();
    for (h, w, theta) in [(0.1, 10.0, 1.0), (0.02, 1.0, 10.0), (0.5, 100.0, 0.1)] {
        let design = SampledCubicDesign::new(&linear, &dmatrix![theta], w, h).unwrap();
        assert!(design.certificate.is_proved(), "{}", design.certificate);
        let o = &design.observer;
        let sampled = StateSpace::new(o.ad().clone(), o.bd().clone(), o.c().clone()).unwrap();
        let run = Trajectory::of(&sampled, &dmatrix![0.5, 1.0], 4000, 1.0);
        for error in [1.0, 300.0] {
            let operation = run.operation(1, error);
            let deployed = design.deployed(Format::Binary32.into(), &operation).unwrap();
            assert!(deployed.is_stable());
            let s = &deployed.stored;
            let cubic = s.cubic.as_ref().expect("cubic");
            let observer = SampledCubicObserver::<f32, Dyn, Dyn, Dyn>::new(SampledCubicGains {
                ad: single(&s.a),
                bd: single(&s.b),
                c: single(&s.c),
                ld: single(&s.l),
                n: single(&cubic.n),
                theta: single(&cubic.theta),
                w: cubic.w as f32,
                period: cubic.h as f32,
            })
            .unwrap();
            // As far off as was promised: the flow is stiff at the start.
            let first = run.x[0].map(|x| (x - 0.999 * error) as f32);
            let share = run.compare(&deployed, &design.p, &plant.c, &first, |xhat, u, y| {
                let mut xhat = xhat.clone();
                observer.step(0.0, &mut xhat, u, y);
                xhat
            });
            let entries = deployed.ball().map(|ball| &ball.entries);
            println!("h = {h}, e(0) = {error}: 1/{:.0} of the bound, {entries:?}", 1.0 / share);
            assert!(share > 1e-3, "h = {h}: the bound is {} times the error seen", 1.0 / share);
        }
    }
}

#[test]
fn the_stored_cubic_gain_is_proved_where_the_structure_is_refuted() {
    // In f32 the stored N misses P N = -C'S by 1e-7, and still converges from every error.
    let plant = luenberger_plants::double_integrator().to_dynamic();
    let linear = LinearDesign::with_poles_and_weight(&plant, &[-2.0, -5.0], LyapunovWeight::Identity(10.0)).unwrap();
    let design = SampledCubicDesign::new(&linear, &dmatrix![1.0], 10.0, 0.1).unwrap();
    let operation =
        Operation { state: vec![1.0; 2], input: vec![1.0], noise: vec![0.0], error: vec![1.0; 2], deviation: None };
    let deployed = design.deployed(Format::Binary32.into(), &operation).unwrap();
    let n = deployed.stored.cubic.as_ref().expect("cubic").n.clone();
    let p = Matrix::from_column_major(2, 2, design.p.as_slice()).unwrap();
    let c = Matrix::from_column_major(1, 2, plant.c.as_slice()).unwrap();
    assert!(luenberger_proof::statement::cubic_dissipation(&p, &n, &c).unwrap().is_refuted());
    assert!(deployed.is_stable());
    // Fixed point: 16 bits hold this gain, and the root of the running observer is not specified there.
    let q6_10 = Format::Fixed { integer_bits: 6, fraction_bits: 10 };
    let in_16 = design.deployed(q6_10.into(), &operation).unwrap();
    assert!(in_16.is_stable() && in_16.running == Running::Unproved(NoErrorBallReason::RootInFixedPoint), "{in_16:?}");
}

#[test]
fn a_slow_gain_is_lost_in_a_byte_and_refuted() {
    // Poles near 1: the gain is below the spacing of Q4.4, or rounds to one that does not stabilise.
    let (_, plant, _, _) = zoo().remove(0);
    let poles: Vec<Complex<f64>> = [0.985, 0.98].map(Complex::from).to_vec();
    let l = place_observer(&plant.a, &plant.c, &poles).unwrap().gain;
    let operation =
        Operation { state: vec![1.0; 2], input: vec![1.0], noise: vec![0.0], error: vec![1.0; 2], deviation: None };
    for step in [Step::Innovation, Step::Joined] {
        let judged =
            |format: Format| deployed_linear(&plant, &l, step, format.into(), &operation).unwrap().deployed.clone();
        let byte = judged(Format::Fixed { integer_bits: 4, fraction_bits: 4 });
        assert!(matches!(byte.decrease, Verdict::Refuted { .. }) && byte.ball().is_none(), "{byte:?}");
        assert!(judged(Format::Binary32).ball().is_some());
        assert!(judged(Format::Fixed { integer_bits: 8, fraction_bits: 24 }).ball().is_some());
    }
}
