//! Interval observers: the state of random plants stays within the bounds, with disturbances, noise and first errors at
//! their corners, in continuous time and in the arithmetic of the target. Statement and proof: docs/theory-cubic.md.

use luenberger_design::{
    DesignError, DiscreteDesign, DisturbanceBounds, ErrorCoordinates, IntervalDesign, IntervalRequirements,
    LinearDesign, SampledIntervalDesign,
};
use luenberger_linalg::expm;
use luenberger_lmi::proof_matrix;
use luenberger_observers::{Observer, SampledObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::Matrix;
use luenberger_proof::statement::{Format, held_plant};
use nalgebra::{DMatrix, DVector, dmatrix};
use proptest::prelude::*;

use crate::generators::{matrix, observable_plant};

/// Signs of corners, different for every number.
fn corner(seed: u64, k: usize) -> f64 {
    let mixed = (seed ^ (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    if (mixed >> 33) & 1 == 0 { 1.0 } else { -1.0 }
}

/// Distinct poles, with a complex pair where there is room for one.
fn designed(plant: &StateSpace, oscillates: bool) -> LinearDesign {
    use nalgebra::Complex;
    let n = plant.a.nrows();
    let mut poles: Vec<Complex<f64>> = (0..n).map(|k| Complex::new(-1.0 - 0.6 * k as f64, 0.0)).collect();
    if oscillates && n > 1 {
        poles[0] = Complex::new(-1.2, 2.5);
        poles[1] = poles[0].conj();
    }
    LinearDesign::with_poles(plant, &poles).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    /// `|x_i - xhat_i| <= (H rho)_i` for disturbances that switch between corners, each held for a random share of a
    /// time constant, or at the corner that raises one error most; the solutions between switches are exact.
    #[test]
    fn the_state_stays_within_its_bounds(
        plant in observable_plant(1..=4), e in matrix(4, 2), w in 0.0..2.0_f64, v in 0.01..1.0_f64, seed in any::<u64>(),
        oscillates in any::<bool>(), hold in 0.02..0.5_f64,
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let e = e.rows(0, n).into_owned();
        let acting = DisturbanceBounds::of_states_and_outputs(&e, &[w, 0.5 * w], &vec![v; p]);
        let first: Vec<f64> = (0..n).map(|i| 0.5 + 0.3 * i as f64).collect();
        let linear = designed(&plant, oscillates);
        let design = IntervalDesign::new(&linear.observer, &acting, ErrorCoordinates::Modal, &first).unwrap();
        prop_assert!(design.certificate.is_proved(), "{}", design.certificate);
        prop_assert_eq!(design.blocks.contains(&2), oscillates && n > 1);
        let o = design.observer.comparison();
        let (flow, forcing) = (
            &linear.observer.a - linear.l() * &linear.observer.c,
            &acting.e - linear.l() * &acting.d,
        );
        let moves = |m: &DMatrix<f64>, forced: &DVector<f64>, x: &DVector<f64>, h: f64| {
            // The solution of x' = M x + f with a constant f.
            let size = m.nrows();
            let both = DMatrix::from_fn(size + 1, size + 1, |i, j| match (i < size, j < size) {
                (true, true) => m[(i, j)] * h,
                (true, false) => forced[i] * h,
                _ => 0.0,
            });
            let next = both.exp() * x.push(1.0);
            next.rows(0, size).into_owned()
        };
        for run in 0..6 {
            let mut error = DVector::from_fn(n, |i, _| first[i] * corner(seed, 100 * run + i));
            let mut rho = o.start.clone();
            for k in 0..60 {
                let bounds = &o.h * &rho;
                for i in 0..n {
                    prop_assert!(
                        error[i].abs() <= bounds[i] * (1.0 + 1e-9),
                        "error {} of x{} beyond {}", error[i], i + 1, bounds[i],
                    );
                }
                let raised = DVector::from_fn(n, |i, _| f64::from(u8::from(i == run % n)));
                let worst = forcing.transpose() * flow.transpose().scale(hold).exp() * raised;
                let push = DVector::from_fn(acting.bounds.len(), |j, _| {
                    acting.bounds[j] * if run < 2 { corner(seed, 1000 * run + 7 * k + j) } else { worst[j].signum() }
                });
                error = moves(&flow, &(&forcing * push), &error, hold);
                rho = moves(&o.k, &o.g, &rho, hold);
            }
            // In the end the widths are those of the certificate.
            for (i, bound) in (&o.h * &rho).iter().enumerate() {
                let decay = (-design.rate * 60.0 * hold).exp();
                prop_assert!(*bound <= design.widths[i] * (1.0 + 1e-6) + 1e3 * decay, "{bound} {}", design.widths[i]);
            }
        }
    }

    /// The step in binary32 and in binary64: thousands of samples, the plant at the corners of w, v and x(0), the
    /// computed bounds compared without mercy for rounding.
    #[test]
    fn the_computed_bounds_enclose_the_state(
        plant in observable_plant(1..=3), e in matrix(3, 1), seed in any::<u64>(), oscillates in any::<bool>(),
        single in any::<bool>(), h in 0.02..0.2_f64, quiet in any::<bool>(),
    ) {
        let (n, m, p) = (plant.a.nrows(), plant.b.ncols(), plant.c.nrows());
        let round = |x: f64| if single { f64::from(x as f32) } else { x };
        // The outputs of the format, and the plant in discrete time as it is given.
        let plant = StateSpace::new(plant.a.clone(), plant.b.clone(), plant.c.map(|x| f64::from(x as f32))).unwrap();
        let linear = designed(&plant, oscillates);
        let discrete = DiscreteDesign::sampled(&linear, h).unwrap();
        let e = e.rows(0, n).into_owned();
        // Without disturbances only rounding is left.
        let (w, v) = if quiet { (0.0, if single { 4e-7 } else { 1e-15 }) } else { (0.05, 0.02) };
        let kept = IntervalRequirements {
            initial_error: vec![1.0; n],
            estimates: vec![50.0; n],
            inputs: vec![1.0; m],
            format: if single { Format::Binary32 } else { Format::Binary64 },
        };
        let (sampled, modal) = (discrete.observer.plant(), ErrorCoordinates::Modal);
        let acting = DisturbanceBounds::of_states_and_outputs(&e, &[w], &vec![v; p]);
        let design = SampledIntervalDesign::of_discrete(sampled, h, discrete.l(), &acting, modal, &kept).unwrap();
        prop_assert!(design.certificate.is_proved(), "{}", design.certificate);
        let (mut x, zero) = (DVector::zeros(n), DVector::zeros(m));
        let first = DVector::from_fn(n, |i, _| round(-corner(seed, i)));
        let mut state = design.observer.initial(0.0, &first, &zero, &DVector::zeros(p));
        let cast = SampledRun::of(&design, single);
        let mut entries: Vec<f64> = state.iter().copied().collect();
        for k in 0..250 {
            let (low, high) = cast.bounds(&entries);
            for i in 0..n {
                prop_assert!(low[i] <= x[i] && x[i] <= high[i], "{} is not in [{}, {}]", x[i], low[i], high[i]);
            }
            let u = DVector::from_fn(m, |j, _| round(0.3 * corner(seed, 11 * k + j)));
            let push = DVector::from_element(1, w * corner(seed, 5 * k + 3));
            let ideal = &plant.c * &x;
            let y = DVector::from_fn(p, |i, _| {
                // Rounded towards the ideal output, so that v keeps its bound.
                let noise = v * corner(seed, 13 * k + i);
                let y = round(ideal[i] + 0.9 * noise);
                if (y - ideal[i]).abs() <= v { y } else { round(ideal[i]) }
            });
            if y.iter().zip(&ideal).any(|(y, ideal)| (y - ideal).abs() > v) {
                break;
            }
            entries = cast.step(&entries, &u, &y);
            x = &sampled.a * &x + &sampled.b * &u + &e * push;
            state = DVector::from_vec(entries.clone());
        }
        prop_assert!(state.iter().all(|x| x.is_finite()));
    }
}

/// The observer in its format.
enum SampledRun {
    Single(
        Box<
            luenberger_observers::SampledIntervalObserver<
                f32,
                nalgebra::Dyn,
                nalgebra::Dyn,
                nalgebra::Dyn,
                nalgebra::Dyn,
                nalgebra::Dyn,
            >,
        >,
    ),
    Double(
        Box<
            luenberger_observers::SampledIntervalObserver<
                f64,
                nalgebra::Dyn,
                nalgebra::Dyn,
                nalgebra::Dyn,
                nalgebra::Dyn,
                nalgebra::Dyn,
            >,
        >,
    ),
}

impl SampledRun {
    fn of(design: &SampledIntervalDesign, single: bool) -> Self {
        if !single {
            return Self::Double(Box::new(design.observer.clone()));
        }
        let g = design.observer.gains();
        let cast = |m: &DMatrix<f64>| m.map(|x| x as f32);
        let column = |v: &DVector<f64>| v.map(|x| x as f32);
        let gains = luenberger_observers::SampledIntervalGains {
            f: cast(&g.f),
            g: cast(&g.g),
            c: cast(&g.c),
            l: cast(&g.l),
            blocks: cast(&g.blocks),
            constant: column(&g.constant),
            of_estimate: cast(&g.of_estimate),
            of_input: cast(&g.of_input),
            h: cast(&g.h),
            outward: g.outward as f32,
            start: column(&g.start),
            period: g.period as f32,
        };
        Self::Single(Box::new(luenberger_observers::SampledIntervalObserver::new(gains).unwrap()))
    }

    fn step(&self, state: &[f64], u: &DVector<f64>, y: &DVector<f64>) -> Vec<f64> {
        match self {
            Self::Double(observer) => {
                let mut state = DVector::from_column_slice(state);
                observer.step(0.0, &mut state, u, y);
                state.as_slice().to_vec()
            }
            Self::Single(observer) => {
                let single = |v: &DVector<f64>| v.map(|x| x as f32);
                let mut state = single(&DVector::from_column_slice(state));
                observer.step(0.0, &mut state, &single(u), &single(y));
                state.iter().map(|x| f64::from(*x)).collect()
            }
        }
    }

    fn bounds(&self, state: &[f64]) -> (Vec<f64>, Vec<f64>) {
        match self {
            Self::Double(observer) => {
                let r = observer.half_widths(state);
                (r.iter().zip(state).map(|(r, x)| x - r).collect(), r.iter().zip(state).map(|(r, x)| x + r).collect())
            }
            Self::Single(observer) => {
                let single: Vec<f32> = state.iter().map(|x| *x as f32).collect();
                let r = observer.half_widths(&single);
                let end = |sign: f32| r.iter().zip(&single).map(|(r, x)| f64::from(x + sign * r)).collect();
                (end(-1.0), end(1.0))
            }
        }
    }
}

/// A scalar plant by hand: `x' = -x + w`, `y = x + v`, L = 1: e' = -2e + w - v, and the bound is (W + V)/2, reached by
/// the disturbance that pushes.
#[test]
fn the_bound_of_a_scalar_plant_is_reached() {
    let plant = StateSpace::new(dmatrix![-1.0], dmatrix![1.0], dmatrix![1.0]).unwrap();
    let linear = LinearDesign::with_gain(&plant, &dmatrix![1.0]).unwrap();
    let acting = DisturbanceBounds::of_states_and_outputs(&dmatrix![1.0], &[0.3], &[0.1]);
    for coordinates in [ErrorCoordinates::Modal, ErrorCoordinates::Plant] {
        let design = IntervalDesign::new(&linear.observer, &acting, coordinates, &[1.0]).unwrap();
        assert!((design.widths[0] - 0.2).abs() < 1e-8, "{}", design.widths[0]);
        let (u, y) = (DVector::zeros(1), DVector::from_element(1, 6.0));
        let state = design.observer.initial(0.0, &DVector::from_element(1, 5.0), &u, &y);
        assert!((design.observer.half_widths(state.as_slice())[0] - 1.0).abs() < 1e-12);
        // xhat' = -5 + (6 - 5), rho' = -2 + 0.4.
        let slope = design.observer.derivative(0.0, &state, &u, &y);
        assert!((slope - DVector::from_vec(vec![-4.0, -1.6])).norm() < 1e-9);
    }
}

/// Norms of blocks against numpy.linalg: norm([[1, 2], [3, 4]], 2) = 5.4649857042, eigvalsh of the symmetric part
/// 5.4154759474; rows of T^-1 for T = [[1, 2], [3, 4]], hypot(-2, 1) and hypot(1.5, -0.5).
#[test]
fn norms_of_blocks_are_those_of_numpy() {
    use luenberger_proof::{Interval, Matrix, statement::BlockCoordinates};
    let identity = Matrix::from_rows([[1.0, 0.0], [0.0, 1.0]]);
    let full = Matrix::from_rows([[1.0, 2.0], [3.0, 4.0]]);
    let f = full.map(|x| Interval::of(*x));
    let block = BlockCoordinates::new(&identity, &[2]).unwrap().unwrap();
    assert!((block.norms(&f).unwrap()[(0, 0)] - 5.464_985_704_2).abs() < 1e-9);
    assert!((block.comparison(&f).unwrap()[(0, 0)] - 5.415_475_947_4).abs() < 1e-9);
    let widths = BlockCoordinates::new(&full, &[2]).unwrap().unwrap().widths();
    assert!((widths[(0, 0)] - 5f64.sqrt()).abs() < 1e-12 && (widths[(1, 0)] - 2.5f64.sqrt()).abs() < 1e-12);
    let entries = BlockCoordinates::new(&full, &[1, 1]).unwrap().unwrap();
    // T F T^-1 = F for T = F.
    assert!((entries.norms(&f).unwrap()[(1, 0)] - 3.0).abs() < 1e-12);
    assert!(BlockCoordinates::new(&Matrix::from_rows([[1.0, 2.0], [2.0, 4.0]]), &[1, 1]).unwrap().is_none());
}

/// A plant in continuous time whose disturbance switches within the periods: the bounds of the samples hold.
#[test]
fn a_disturbance_that_switches_between_samples_is_enclosed() {
    let plant = StateSpace::new(dmatrix![0.0, 1.0; -8.0, -0.4], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]).unwrap();
    let linear = LinearDesign::with_poles(&plant, &[-2.0, -3.5]).unwrap();
    let (h, parts, e) = (0.2, 16_usize, dmatrix![0.3; 1.0]);
    let discrete = DiscreteDesign::sampled(&linear, h).unwrap();
    let kept = IntervalRequirements {
        initial_error: vec![0.0; 2],
        estimates: vec![5.0; 2],
        inputs: vec![0.0],
        format: Format::Binary64,
    };
    let acting = DisturbanceBounds::of_states_and_outputs(&e, &[0.7], &[1e-9]);
    let design =
        SampledIntervalDesign::sampled(&plant, h, discrete.l(), &acting, ErrorCoordinates::Modal, &kept).unwrap();
    assert!(design.certificate.is_proved(), "{}", design.certificate);
    let tau = h / parts as f64;
    let step = luenberger_linalg::zero_order_hold(&plant.a, &e, tau).unwrap();
    let (u, zero) = (DVector::zeros(1), DVector::zeros(2));
    let mut largest = 0.0_f64;
    for run in 0..200_u64 {
        let mut x: DVector<f64> = DVector::zeros(2);
        let mut state = design.observer.initial(0.0, &zero, &u, &DVector::zeros(1));
        for k in 0..30_usize {
            let r = design.observer.half_widths(state.as_slice());
            for i in 0..2 {
                assert!(
                    (x[i] - state[i]).abs() <= r[i],
                    "run {run}, sample {k}, x{}: {} {}",
                    i + 1,
                    x[i] - state[i],
                    r[i]
                );
                largest = largest.max((x[i] - state[i]).abs() / r[i]);
            }
            let y = &plant.c * &x;
            design.observer.step(0.0, &mut state, &u, &y);
            for part in 0..parts {
                // Resonance, from some runs, and corners without pattern.
                let t = (k * parts + part) as f64 * tau;
                let w = if run % 2 == 0 {
                    (8f64.sqrt() * t + 0.1 * run as f64).sin().signum()
                } else {
                    corner(run, k * parts + part)
                };
                x = &step.ad * &x + &step.bd * DVector::from_element(1, 0.7 * w);
            }
        }
    }
    assert!(largest > 0.3, "{largest}: the bounds are far from what disturbances reach");
}

/// What a disturbance that switches at will adds to the state in one period, `int_0^h e^{As} E w ds` with |w| <= W,
/// lies in the box of `HeldPlant`: in each direction q the box reaches as far as `W int_0^h |q'e^{As}E| ds`. An
/// oscillator over up to a half-period: a disturbance that is held reaches only along one line.
#[test]
fn the_held_disturbance_covers_every_switching_one() {
    let (plant, bound, cells) = (dmatrix![0.0, 1.0; -8.0, -0.4], 0.7, 20_000);
    let (a, b) = (Matrix::from_rows([[0.0, 1.0], [-8.0, -0.4]]), Matrix::from_rows([[0.0], [1.0]]));
    let e = dmatrix![0.3; 1.0];
    for h in [0.05, 0.2, 0.6, 1.1] {
        let held = held_plant((&a, &b), (&proof_matrix(&e), &[bound]), h).unwrap().unwrap();
        assert_eq!(held.disturbances.len(), 3);
        let ds = h / f64::from(cells);
        let (half, whole) = (expm(&(&plant * (0.5 * ds))).unwrap(), expm(&(&plant * ds)).unwrap());
        for direction in 0..16 {
            let angle = f64::from(direction) * std::f64::consts::PI / 16.0;
            let q = [angle.cos(), angle.sin()];
            let mut moved = &half * &e;
            let mut reached = 0.0;
            for _ in 0..cells {
                reached += bound * (q[0] * moved[0] + q[1] * moved[1]).abs() * ds;
                moved = &whole * moved;
            }
            let covered: f64 =
                (0..3).map(|j| (q[0] * held.e[(0, j)] + q[1] * held.e[(1, j)]).abs() * held.disturbances[j]).sum();
            // The midpoint rule is wrong by less than ds in the cells where the sign changes.
            assert!(covered > reached * (1.0 - 1e-6), "h = {h}, direction {direction}: {covered} {reached}");
        }
    }
}

/// The least width by a linear program, up to one per cent: for an oscillator no gain of a grid is narrower by more.
#[test]
fn the_linear_program_finds_the_least_width() {
    let plant = StateSpace::new(dmatrix![-1.0, 0.4; -0.4, -1.5], DMatrix::zeros(2, 0), dmatrix![1.0, 0.0]).unwrap();
    let acting = DisturbanceBounds::of_states_and_outputs(&dmatrix![1.0; 0.5], &[0.3], &[0.2]);
    let best = IntervalDesign::least_width(&plant, &acting, &[1.0, 1.0]).unwrap();
    assert!(best.certificate.is_proved());
    let total: f64 = best.widths.iter().sum();
    let mut least = f64::INFINITY;
    for i in 0..60 {
        for j in 0..60 {
            let l = dmatrix![-0.9 + 0.1 * f64::from(i); -2.0 + 0.1 * f64::from(j)];
            let Ok(linear) = LinearDesign::with_gain(&plant, &l) else { continue };
            match IntervalDesign::new(&linear.observer, &acting, ErrorCoordinates::Plant, &[1.0, 1.0]) {
                Ok(design) => least = least.min(design.widths.iter().sum()),
                Err(error) => assert!(matches!(error, DesignError::WidthGrows { .. }), "{error}"),
            }
        }
    }
    assert!(total <= least * 1.0101 && total >= 0.9 * least, "{total} {least}");
}

/// A scalar plant whose output has the disturbances of the state: `|E - L D| W/(1 + L)` is least where one of its two
/// terms vanishes, at L = 2 or L = -1/2, and which of them depends on the bounds W.
#[test]
fn the_least_width_depends_on_the_bounds_of_common_disturbances() {
    let plant = StateSpace::new(dmatrix![-1.0], DMatrix::zeros(1, 0), dmatrix![1.0]).unwrap();
    for (bounds, gain, width) in [([1.0, 0.3], 2.0, 0.25), ([0.1, 2.0], -0.5, 0.25)] {
        let acting = DisturbanceBounds { e: dmatrix![1.0, 0.5], d: dmatrix![0.5, -1.0], bounds: bounds.to_vec() };
        let best = IntervalDesign::least_width(&plant, &acting, &[1.0]).unwrap();
        assert!(best.certificate.is_proved());
        let l = best.observer.inner().l[0];
        assert!((l - gain).abs() < 0.02 * gain.abs(), "{l} for W = {bounds:?}");
        assert!((best.widths[0] - width).abs() < 1.01e-2 * width, "{:?} for W = {bounds:?}", best.widths);
    }
}

/// For the scalar plant `x' = w`, `y = x + v` the width `(W + L V)/L` falls with L towards V and has no least value.
/// The gain is the smallest whose width is one per cent above: `L = 100 W/V`.
#[test]
fn a_width_that_only_falls_has_a_moderate_gain() {
    let plant = StateSpace::new(dmatrix![0.0], DMatrix::zeros(1, 0), dmatrix![1.0]).unwrap();
    let acting = DisturbanceBounds::of_states_and_outputs(&dmatrix![1.0], &[0.3], &[0.2]);
    let best = IntervalDesign::least_width(&plant, &acting, &[1.0]).unwrap();
    let l = best.observer.inner().l[0];
    assert!((l / 150.0 - 1.0).abs() < 0.05, "{l}");
    assert!((best.widths[0] / 0.202 - 1.0).abs() < 1e-3, "{:?}", best.widths);
}

/// What is not possible is named.
#[test]
fn refusals_carry_numbers() {
    let plant = luenberger_plants::double_integrator().to_dynamic();
    let acting = DisturbanceBounds::of_states_and_outputs(&dmatrix![0.0; 1.0], &[0.1], &[0.1]);
    let linear = LinearDesign::with_poles(&plant, &[-1.0, -4.0]).unwrap();
    // In its own states no gain makes the integrator's comparison matrix stable: [-l1 1; |l2| 0].
    let grows = IntervalDesign::new(&linear.observer, &acting, ErrorCoordinates::Plant, &[1.0; 2]).unwrap_err();
    assert!(grows.to_string().contains("the width of the interval would grow"), "{grows}");
    let none = IntervalDesign::least_width(&plant, &acting, &[1.0; 2]).unwrap_err();
    assert!(matches!(none, DesignError::NoLeastWidth { .. }), "{none}");
    let quiet = DisturbanceBounds::of_states_and_outputs(&dmatrix![0.0; 1.0], &[0.1], &[0.0]);
    let none = IntervalDesign::least_width(&plant, &quiet, &[1.0; 2]).unwrap_err();
    assert!(none.to_string().contains("y1 has none"), "{none}");
    let double = LinearDesign::with_gain(&plant, &dmatrix![4.0; 4.0]).unwrap();
    let repeated = IntervalDesign::new(&double.observer, &acting, ErrorCoordinates::Modal, &[1.0; 2]).unwrap_err();
    assert!(repeated.to_string().contains("not distinct enough for modal coordinates"), "{repeated}");
    // Poles that are 3 apart, and eigenvectors (1, s, s^2, ..) that are nearly dependent.
    let chain = StateSpace::new(
        DMatrix::from_fn(12, 12, |i, j| if j == i + 1 { 1.0 } else { 0.0 }),
        DMatrix::zeros(12, 0),
        DMatrix::from_fn(1, 12, |_, j| if j == 0 { 1.0 } else { 0.0 }),
    )
    .unwrap();
    let poles: Vec<f64> = (1..=12).map(|k| -3.0 * f64::from(k)).collect();
    let linear = LinearDesign::with_poles(&chain, &poles).unwrap();
    let quiet = DisturbanceBounds::of_outputs(12, &[0.1]);
    let why = IntervalDesign::new(&linear.observer, &quiet, ErrorCoordinates::Modal, &[1.0; 12]).unwrap_err();
    assert!(matches!(why, DesignError::DependentModes { .. }), "{why}");
    assert!(why.to_string().contains("eigenvectors of A - LC") && !why.to_string().contains("inf"), "{why}");
    assert!(!why.to_string().contains("apart"), "{why}");
    // 1/1e-310 is beyond binary64: nothing is known of the width, and no number is named that does not exist.
    let slow = StateSpace::new(dmatrix![-1e-310], DMatrix::zeros(1, 0), dmatrix![1.0]).unwrap();
    let slow = luenberger_observers::LinearObserver::new(slow.a, slow.b, slow.c, dmatrix![0.0]).unwrap();
    let none = DisturbanceBounds::of_outputs(1, &[0.1]);
    let why = IntervalDesign::new(&slow, &none, ErrorCoordinates::Modal, &[1.0]).unwrap_err();
    assert!(matches!(why, DesignError::ComparisonUndecided) && !why.to_string().contains("NaN"), "{why}");
}
