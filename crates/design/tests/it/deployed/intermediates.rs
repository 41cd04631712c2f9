//! Every operation of the step that runs is one of the intermediate numbers that are proved to stay in the format: the
//! list is taken from the code, by running it.

use std::collections::BTreeMap;

use luenberger_observers::{LinearObserver, Observer, SampledCubicGains, SampledCubicObserver, SampledObserver};
use luenberger_proof::Matrix;
use luenberger_proof::statement::{
    CubicGains, Deployed, Format, Operation, SampledPlant, Step, deployed_linear, deployed_sampled_cubic,
};
use luenberger_random::Random;
use nalgebra::{DMatrix, DVector, Dyn, RealField};

use super::recorded::{Recorded, record};

/// The scalar in which a format runs.
pub(crate) trait Target: RealField + Copy {
    const FORMAT: Format;

    fn of(x: f64) -> Self;

    fn value(self) -> f64;
}

impl Target for f32 {
    const FORMAT: Format = Format::Binary32;

    fn of(x: f64) -> Self {
        x as Self
    }

    fn value(self) -> f64 {
        f64::from(self)
    }
}

impl Target for f64 {
    const FORMAT: Format = Format::Binary64;

    fn of(x: f64) -> Self {
        x
    }

    fn value(self) -> f64 {
        self
    }
}

fn recorded<T: Target>(m: &Matrix<f64>) -> DMatrix<Recorded<T>> {
    DMatrix::from_fn(m.rows(), m.cols(), |i, j| Recorded(T::of(m[(i, j)])))
}

fn column<T: Target>(x: &[f64]) -> DVector<Recorded<T>> {
    DVector::from_iterator(x.len(), x.iter().map(|x| Recorded(T::of(*x))))
}

/// One step of the observer of the crate `observers` with the stored numbers: what it computes, and the tape.
fn step<T: Target>(deployed: &Deployed, xhat: &[f64], u: &[f64], y: &[f64]) -> (Vec<f64>, Vec<(&'static str, f64)>) {
    let s = &deployed.stored;
    let (a, b, c, l) = (recorded::<T>(&s.a), recorded(&s.b), recorded(&s.c), recorded(&s.l));
    let (mut xhat, u, y) = (column(xhat), column(u), column(y));
    let tape = if let Some(cubic) = &s.cubic {
        let (n, theta) = (recorded(&cubic.n), recorded(&cubic.theta));
        let (w, h) = (Recorded(T::of(cubic.w)), Recorded(T::of(cubic.h)));
        let observer = SampledCubicObserver::<_, Dyn, Dyn, Dyn>::new(SampledCubicGains {
            ad: a,
            bd: b,
            c,
            ld: l,
            n,
            theta,
            w,
            period: h,
        })
        .expect("radial");
        record(|| observer.step(Recorded(T::zero()), &mut xhat, &u, &y)).1
    } else {
        let observer = LinearObserver::<_, Dyn, Dyn, Dyn>::new(a, b, c, l).expect("finite");
        let (next, tape) = record(|| observer.derivative(Recorded(T::zero()), &xhat, &u, &y));
        xhat = next;
        tape
    };
    (xhat.iter().map(|x| x.0.value()).collect(), tape)
}

/// What is known of one operation of the code after many runs.
struct Place {
    operation: &'static str,
    first: f64,
    is_constant: bool,
    /// The intermediate numbers whose bounds held in every run.
    covered_by: Vec<&'static str>,
    /// How many runs there were.
    runs: usize,
}

/// Runs accepted observers of one size, and finds for each operation of the code an intermediate number that bounds it
/// in *every* run.
fn every_operation_is_listed<T: Target>(is_cubic: bool, outputs: usize) {
    let mut random = Random(7 + outputs as u64);
    // The code branches: a place is an operation after the same operations.
    let mut places: BTreeMap<Vec<&'static str>, Vec<Place>> = BTreeMap::new();
    let range = match T::FORMAT {
        Format::Binary32 => 120.0,
        _ => 1000.0,
    };
    let mut accepted = 0;
    // Starts near and far: with `c = sqrt(2 w h z'theta z)` up to 1/epsilon and beyond.
    let mut starts = [0; 2];
    for case in 0..1500 {
        // Powers of two of every size: N = -w/c I exactly, and e+ = 0.25 e. P = I proves it.
        let power = |random: &mut Random, share: f64| 2.0_f64.powi((random.unit() * share * range) as i32);
        let share = [0.05, 0.2, 0.5, 1.0][case % 4];
        let (size, gain) = (power(&mut random, share / 4.0), power(&mut random, share / 4.0));
        let (w, h) = (power(&mut random, share), power(&mut random, share / 2.0));
        // Every other one with c = sqrt(2 w h z'theta z) near 1/epsilon, where the step chooses.
        let near = (w * h).recip() * (T::default_epsilon().value() * size * gain).powi(-2);
        let scale = if case % 8 < 4 { power(&mut random, share) } else { near * power(&mut random, 0.1) };
        let theta: Vec<f64> = (0..outputs).map(|_| (scale * random.unit()).abs()).collect();
        let n = outputs;
        let diagonal = |x: f64| Matrix::from_fn(n, n, |i, j| if i == j { x } else { 0.0 });
        let noise = 0.1 * power(&mut random, share / 4.0);
        let plant = SampledPlant {
            a: diagonal(0.5),
            b: Matrix::from_fn(n, 1, |_, _| power(&mut random, share / 4.0)),
            c: diagonal(gain),
        };
        let l = diagonal(0.25 / gain);
        let meets = Operation {
            state: vec![size; n],
            input: vec![noise],
            noise: vec![noise; n],
            error: vec![size; n],
            deviation: None,
        };
        let p = diagonal(1.0);
        let deployed = if is_cubic {
            // Semidefinite, so that the observer can be made; the largest w of all, and no weight at all.
            let theta = Matrix::from_fn(n, n, |i, j| if i == j { theta[i] } else { 0.0 });
            let theta = if case % 7 == 0 { diagonal(0.0) } else { theta };
            let w = if case % 11 == 0 { 2.0_f64.powi(if range > 500.0 { 1023 } else { 127 }) } else { w };
            let gains = CubicGains { n: diagonal(-w / gain), theta, w, h };
            deployed_sampled_cubic(&plant, &l, &gains, &p, T::FORMAT.into(), &meets)
        } else {
            deployed_linear(&plant, &l, &p, Step::Innovation, T::FORMAT.into(), &meets)
        };
        let Ok(deployed) = deployed else { continue };
        // An N that is 0 makes a linear observer, of fewer operations.
        if deployed.stored.cubic.as_ref().is_some_and(|gains| gains.n.as_slice().iter().all(|x| *x == 0.0)) {
            continue;
        }
        let Some(ball) = deployed.ball() else { continue };
        accepted += 1;
        for worst in [true, false] {
            let mut within = |bound: f64| if worst { bound * random.unit().signum() } else { bound * random.unit() };
            let rounded = |x: f64| T::of(x).value();
            let x: Vec<f64> = (0..n).map(|_| within(size)).collect();
            let xhat: Vec<f64> = x.iter().map(|x| rounded(x - within(size))).collect();
            let u = [rounded(within(noise))];
            let y: Vec<f64> = x.iter().map(|x| rounded(gain * x + within(noise))).collect();
            if let Some(gains) = &deployed.stored.cubic {
                let z: Vec<f64> = (0..n).map(|i| y[i] - deployed.stored.c[(i, i)] * xhat[i]).collect();
                let size = z.iter().fold(0.0, |size: f64, z| size.max(z.abs()));
                let q: f64 = (0..n).map(|i| gains.theta[(i, i)] * (z[i] / size).powi(2)).sum();
                let c = (2.0 * gains.w * gains.h * q).sqrt() * size;
                starts[usize::from(c > T::default_epsilon().value().recip())] += 1;
            }
            let (next, tape) = step::<T>(&deployed, &xhat, &u, &y);
            assert!(next.iter().all(|x| x.is_finite()), "{next:?} from {xhat:?}, {y:?}: {deployed:?}");
            let key: Vec<&'static str> = tape.iter().map(|(operation, _)| *operation).collect();
            let places = places.entry(key).or_insert_with(|| {
                let all: Vec<&'static str> = ball.intermediates.iter().map(|found| found.what).collect();
                let place = |&(operation, first)| Place {
                    operation,
                    first,
                    is_constant: true,
                    covered_by: all.clone(),
                    runs: 0,
                };
                tape.iter().map(place).collect()
            });
            for (place, &(_, value)) in places.iter_mut().zip(&tape) {
                assert!(value.is_finite(), "{} gives {value}: {deployed:?}", place.operation);
                place.is_constant &= value == place.first;
                place.runs += 1;
                let bound = |what: &str| ball.intermediates.iter().find(|found| found.what == what).expect("same list");
                place
                    .covered_by
                    .retain(|what| value.abs() <= bound(what).size && bound(what).size <= bound(what).limit);
            }
        }
    }
    assert!(accepted > 200, "{accepted} of 1500 observers are proved");
    for places in places.values() {
        for (k, place) in places.iter().enumerate() {
            // Constants of the code: 2, epsilon, the root of the largest number.
            let is_constant = place.is_constant && place.runs > 20;
            assert!(
                is_constant || !place.covered_by.is_empty(),
                "operation {k}, {}, is in no stage: {:e} and others in {} runs",
                place.operation,
                place.first,
                place.runs
            );
        }
    }
    let runs: Vec<usize> = places.values().map(|places| places[0].runs).collect();
    println!("{}: {accepted} observers, paths of {runs:?} runs", T::FORMAT);
    // Near and far starts take the same operations: the step chooses between numbers.
    assert!(runs.len() == 1 && runs[0] > 100, "{runs:?}");
    assert!(!is_cubic || starts.iter().all(|starts| *starts > 100), "{starts:?}");
}

#[test]
fn every_operation_of_the_linear_step_is_an_intermediate_number() {
    for outputs in [1, 2] {
        every_operation_is_listed::<f32>(false, outputs);
        every_operation_is_listed::<f64>(false, outputs);
    }
}

#[test]
fn every_operation_of_the_cubic_step_is_an_intermediate_number() {
    for outputs in [1, 2] {
        every_operation_is_listed::<f32>(true, outputs);
        every_operation_is_listed::<f64>(true, outputs);
    }
}

#[test]
fn the_recorded_scalar_computes_as_the_one_it_wraps() {
    let mut random = Random(3);
    for _ in 0..200 {
        let mut x = || (random.unit() * 10.0) as f32;
        let (theta, z, w, h) = (x(), [x(), x()], x().abs(), x().abs());
        let theta = DMatrix::from_row_slice(2, 2, &[theta, 0.5, -0.5, theta * theta]);
        let plain = luenberger_observers::cubic::flow(&theta, w, &DVector::from_row_slice(&z), h);
        let (taped, tape) = record(|| {
            let z = DVector::from_row_slice(&z.map(Recorded));
            luenberger_observers::cubic::flow(&theta.map(Recorded), Recorded(w), &z, Recorded(h))
        });
        assert_eq!(taped.impulse.map(|x| x.0), plain.impulse);
        assert_eq!(taped.innovation.map(|x| x.0), plain.innovation);
        assert!(tape.len() > 15 && tape.iter().any(|(operation, _)| *operation == "sqrt"));
    }
}
