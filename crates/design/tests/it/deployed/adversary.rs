//! Files of deployed observers, made by the designs, changed in meaning and sealed again: whatever the checker accepts
//! has to survive the step itself, run bit by bit on a plant in exact arithmetic.

use luenberger_design::{LinearDesign, SampledCubicDesign, deployed_linear};
use luenberger_linalg::zero_order_hold;
use luenberger_lmi::dynamic_matrix;
use luenberger_observers::{
    FixedPointFormat, FixedPointFormats, FixedPointGains, FixedPointObserver, LinearObserver, Observer,
    SampledCubicGains, SampledCubicObserver, SampledObserver, cubic,
};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{CertificateFile, Certified, ClaimedBall, DeployedObserver, Theorem, verify};
use luenberger_proof::statement::{self, Deployed, Format, Operation, Step};
use luenberger_proof::{Exact, Matrix, Ring};
use luenberger_random::Random;
use nalgebra::{DMatrix, DVector, Dyn, dmatrix};

use super::intermediates::Target;
use super::recorded::{Recorded, record};

fn power(random: &mut Random, largest: i32) -> f64 {
    2.0_f64.powi((random.unit() * f64::from(largest)) as i32)
}

fn exact(x: f64) -> Exact {
    Exact::from_f64(x).expect("finite")
}

/// `m x`, exactly.
fn apply(m: &Matrix<f64>, x: &[Exact]) -> Vec<Exact> {
    let row = |i| m.row(i).iter().zip(x).fold(Exact::zero(), |sum, (m, x)| sum.add(&exact(*m).mul(x)));
    (0..m.rows()).map(row).collect()
}

fn exceeds(x: &Exact, bound: f64) -> bool {
    let magnitude = if x.signum() < 0 { x.neg() } else { x.clone() };
    magnitude > exact(bound)
}

/// A step from (estimate, input, measurement), numbers of the format that runs; `None` where a result left the format.
type Stepper = dyn Fn(&[f64], &[f64], &[f64]) -> Option<Vec<f64>>;

fn recorded<T: Target>(m: &Matrix<f64>) -> DMatrix<Recorded<T>> {
    DMatrix::from_fn(m.rows(), m.cols(), |i, j| Recorded(T::of(m[(i, j)])))
}

/// The step in floating point: that of `observers`, which refuses to be made from gains that are not radial; its lines
/// then stand here.
fn floating<T: Target>(theorem: &DeployedObserver) -> Box<Stepper> {
    let s = &theorem.stored;
    let (a, b, c, l) = (recorded::<T>(&s.a), recorded(&s.b), recorded(&s.c), recorded(&s.l));
    let column = |x: &[f64]| DVector::from_iterator(x.len(), x.iter().map(|x| Recorded(T::of(*x))));
    let finish = |(next, tape): (DVector<Recorded<T>>, Vec<(&str, f64)>)| {
        let is_finite = tape.iter().all(|(_, x)| x.is_finite());
        is_finite.then(|| next.iter().map(|x| x.0.value()).collect::<Vec<f64>>())
    };
    let Some(gains) = &s.cubic else {
        let observer = LinearObserver::<_, Dyn, Dyn, Dyn>::new(a, b, c, l).expect("finite");
        let is_joined = theorem.step == Step::Joined;
        return Box::new(move |xhat, u, y| {
            let (xhat, u, y) = (column(xhat), column(u), column(y));
            finish(record(|| {
                if is_joined {
                    &observer.a * &xhat + &observer.b * &u + &observer.l * &y
                } else {
                    observer.derivative(Recorded(T::zero()), &xhat, &u, &y)
                }
            }))
        });
    };
    let (n, theta) = (recorded(&gains.n), recorded(&gains.theta));
    let (w, h) = (Recorded(T::of(gains.w)), Recorded(T::of(gains.h)));
    let made = SampledCubicObserver::<_, Dyn, Dyn, Dyn>::new(SampledCubicGains {
        ad: a.clone(),
        bd: b.clone(),
        c: c.clone(),
        ld: l.clone(),
        n: n.clone(),
        theta: theta.clone(),
        w,
        period: h,
    });
    match made {
        Ok(observer) => Box::new(move |xhat, u, y| {
            let (mut xhat, u, y) = (column(xhat), column(u), column(y));
            let ((), tape) = record(|| observer.step(Recorded(T::zero()), &mut xhat, &u, &y));
            finish((xhat, tape))
        }),
        Err(_) => Box::new(move |xhat, u, y| {
            let (xhat, u, y) = (column(xhat), column(u), column(y));
            finish(record(|| {
                let after = cubic::flow(&theta, w, &(y - &c * &xhat), h);
                let moved = &xhat - &n * after.impulse;
                &a * moved + &b * u + &l * after.innovation
            }))
        }),
    }
}

/// The step of `observers::FixedPointObserver`; nothing where it refuses the formats or the matrices.
fn accumulated(theorem: &DeployedObserver) -> Option<Box<Stepper>> {
    let format = |format: Format| match format {
        Format::Fixed { integer_bits, fraction_bits } => FixedPointFormat::new(integer_bits, fraction_bits).ok(),
        _ => None,
    };
    let (stored, signals) = (format(theorem.formats.stored)?, format(theorem.formats.running)?);
    let s = &theorem.stored;
    let integers = |m: &Matrix<f64>| {
        DMatrix::from_row_iterator(m.rows(), m.cols(), m.as_slice().iter().map(|x| stored.nearest(*x).unwrap()))
    };
    let gains = FixedPointGains { a: integers(&s.a), b: integers(&s.b), c: integers(&s.c), d: None, l: integers(&s.l) };
    let observer = FixedPointObserver::new(gains, FixedPointFormats { gains: stored, signals }).ok()?;
    let column = move |x: &[f64]| DVector::from_iterator(x.len(), x.iter().map(|x| signals.nearest(*x).unwrap()));
    Some(Box::new(move |xhat, u, y| {
        let mut state = observer.start(column(xhat));
        observer.step(&mut state, &column(u), &column(y));
        (state.saturations == 0).then(|| state.xhat.iter().map(|x| signals.value(*x)).collect())
    }))
}

/// The step in fixed point, on integers; each product rounded, or each sum if accumulated.
fn fixed(theorem: &DeployedObserver, integer_bits: u32, fraction_bits: u32) -> Box<Stepper> {
    let unit = 2.0_f64.powi(fraction_bits.cast_signed());
    let end = 1_i128 << (integer_bits + fraction_bits - 1);
    let integer = move |x: f64| (x * unit) as i128;
    let in_range = move |x: i128| (-end..end).contains(&x).then_some(x);
    let nearest = move |x: i128| {
        let (floor, rest) = (x >> fraction_bits, x & ((1 << fraction_bits) - 1));
        let half = 1_i128 << (fraction_bits - 1);
        in_range(floor + i128::from(rest > half || (rest == half && floor & 1 == 1)))
    };
    let is_accumulated = theorem.step == Step::Accumulated;
    let sum = move |first: i128, terms: Vec<(i128, i128)>| {
        if is_accumulated {
            return nearest(terms.into_iter().fold(first << fraction_bits, |sum, (x, y)| sum + x * y));
        }
        terms.into_iter().try_fold(first, |sum, (x, y)| in_range(sum + nearest(x * y)?))
    };
    let s = theorem.stored.clone();
    let is_joined = theorem.step == Step::Joined;
    Box::new(move |xhat, u, y| {
        let terms = |m: &Matrix<f64>, i: usize, x: &[f64], sign: i128| -> Vec<(i128, i128)> {
            m.row(i).iter().zip(x).map(|(m, x)| (sign * integer(*m), integer(*x))).collect()
        };
        let z: Vec<f64> = if is_joined {
            y.to_vec()
        } else {
            let innovation = |k: usize| sum(integer(y[k]), terms(&s.c, k, xhat, -1)).map(|z| z as f64 / unit);
            (0..y.len()).map(innovation).collect::<Option<_>>()?
        };
        let next = |i| sum(0, [terms(&s.a, i, xhat, 1), terms(&s.b, i, u, 1), terms(&s.l, i, &z, 1)].concat());
        (0..xhat.len()).map(|i| next(i).map(|x| x as f64 / unit)).collect()
    })
}

/// Runs what was accepted from the worst starts that were promised, with inputs and noise at their bounds, and holds it
/// to the statement.
fn survives(theorem: &DeployedObserver, random: &mut Random) -> Result<usize, String> {
    let Some(claimed) = &theorem.ball else { return Ok(0) };
    let running = theorem.formats.running;
    let deployed = derived(theorem).ok_or("what was proved can be derived")?;
    let ball = deployed.ball().ok_or("a ball was proved")?;
    let step = match running {
        Format::Binary32 => floating::<f32>(theorem),
        Format::Binary64 => floating::<f64>(theorem),
        Format::Fixed { integer_bits, fraction_bits } => {
            let observer = if theorem.step == Step::Accumulated { accumulated(theorem) } else { None };
            observer.unwrap_or_else(|| fixed(theorem, integer_bits, fraction_bits))
        }
    };
    let (plant, meets) = (&theorem.plant, &theorem.operation);
    let n = plant.a.rows();
    let factor = ball.contraction + ball.relative;
    let start = exact(claimed.start);
    let level = start.mul(&start);
    let inverse = DMatrix::from_fn(n, n, |i, j| theorem.p[(i, j)]).try_inverse().ok_or("P > 0")?;
    let mut steps = 0;
    for _ in 0..2 {
        // From a corner, or from where the plant stays within its bounds for longer.
        let share = if random.below(4) == 0 { 1.0 } else { 0.5 };
        let mut x: Vec<Exact> = meets.state.iter().map(|bound| exact(bound * share * random.sign())).collect();
        let mut xhat = Vec::with_capacity(n);
        for (x, bound) in x.iter().zip(&meets.error) {
            // Inwards, so that the rounding keeps the promise.
            let wished = x.add(&exact(bound * random.sign() * 0.999));
            match running.round_exact(&wished) {
                Some(found) if !exceeds(&x.sub(&exact(found)), *bound) => xhat.push(found),
                _ => return Ok(steps),
            }
        }
        let mut transient = claimed.start;
        for k in 0..60 {
            let e: Vec<Exact> = x.iter().zip(&xhat).map(|(x, xhat)| x.sub(&exact(*xhat))).collect();
            let v = e.iter().zip(apply(&theorem.p, &e)).fold(Exact::zero(), |sum, (e, pe)| sum.add(&e.mul(&pe)));
            if v > level {
                return Err(format!("step {k}: V = {:e} for {:e}^2", v.round_up(), claimed.start));
            }
            for (i, e) in e.iter().enumerate() {
                let bound = claimed.entries[i] + 1.001 * inverse[(i, i)].sqrt() * transient;
                if exceeds(e, bound) {
                    return Err(format!("step {k}: e_{i} = {:e} for {bound:e}", e.round_up()));
                }
            }
            transient *= factor;
            steps += 1;
            let u: Option<Vec<f64>> = meets.input.iter().map(|bound| running.round(bound * random.sign())).collect();
            let Some(u) = u.filter(|u| u.iter().zip(&meets.input).all(|(u, bound)| u.abs() <= *bound)) else { break };
            let measured = apply(&plant.c, &x);
            let noisy = measured.iter().zip(&meets.noise).map(|(y, bound)| y.add(&exact(bound * random.sign())));
            let y: Option<Vec<f64>> = noisy.map(|y| running.round_exact(&y)).collect();
            let y = y.ok_or("a measurement left the format")?;
            xhat = step(&xhat, &u, &y).ok_or_else(|| format!("step {k}: a result left the format"))?;
            let u: Vec<Exact> = u.into_iter().map(exact).collect();
            x = apply(&plant.a, &x).iter().zip(apply(&plant.b, &u)).map(|(ax, bu)| ax.add(&bu)).collect();
            // Beyond what was promised nothing is claimed.
            if x.iter().zip(&meets.state).any(|(x, bound)| exceeds(x, *bound)) {
                break;
            }
        }
    }
    Ok(steps)
}

/// The claim in exact arithmetic, for the stored numbers as a plant: V does not grow in a step from errors of every
/// size.
fn decreases(theorem: &DeployedObserver, random: &mut Random) -> Result<(), String> {
    let Some(gains) = &theorem.stored.cubic else { return Ok(()) };
    let s = &theorem.stored;
    let [a, c, l, n, theta, p] = [&s.a, &s.c, &s.l, &gains.n, &gains.theta, &theorem.p].map(dynamic_matrix);
    let square = |e: &DVector<f64>, p: &DMatrix<f64>| e.dot(&(p * e));
    for _ in 0..30 {
        let size = 10.0_f64.powf(8.0 * random.unit());
        let e = DVector::from_fn(a.nrows(), |_, _| size * random.unit());
        let after = cubic::flow(&theta, gains.w, &(&c * &e), gains.h);
        let (moved, injected) = (&n * &after.impulse, &l * &after.innovation);
        let next = &a * (&e + &moved) - &injected;
        // What cancels is lost to 1e-15 of its terms.
        let terms = a.abs() * (e.abs() + moved.abs()) + injected.abs();
        let (before, after, lost) = (square(&e, &p), square(&next, &p), 1e-12 * square(&terms, &p.abs()));
        if after > before + lost {
            return Err(format!("V grows from {before:e} to {after:e} at e = {e}"));
        }
    }
    Ok(())
}

fn derived(theorem: &DeployedObserver) -> Option<Deployed> {
    let DeployedObserver { plant, stored, step, formats, operation, p, .. } = theorem;
    match &stored.cubic {
        Some(gains) => statement::deployed_sampled_cubic(plant, &stored.l, gains, p, *formats, operation).ok(),
        None => statement::deployed_linear(plant, &stored.l, p, *step, *formats, operation).ok(),
    }
}

/// Plants with a bounded state: one measured of two, and both.
fn plants() -> Vec<StateSpace> {
    let turning = dmatrix![-0.5, 1.0; -1.0, -0.5];
    vec![
        StateSpace::new(turning.clone(), dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]).unwrap(),
        StateSpace::new(turning, dmatrix![0.5; 1.0], dmatrix![1.0, 0.25; 0.0, 1.0]).unwrap(),
    ]
}

fn meets(plant: &StateSpace, error: f64, noise: f64) -> Operation {
    let n = plant.a.nrows();
    Operation {
        state: vec![2.0; n],
        input: vec![0.5; plant.b.ncols()],
        noise: vec![noise; plant.c.nrows()],
        error: vec![error; n],
        deviation: None,
    }
}

fn theorem(file: &CertificateFile) -> DeployedObserver {
    let Theorem::DeployedObserver(theorem) = file.theorem() else { panic!("{}", file.theorem().name()) };
    theorem.clone()
}

/// Cubic observers by the designs, in both formats that run them.
fn cubic_files() -> Vec<DeployedObserver> {
    let mut files = Vec::new();
    for plant in plants() {
        let linear = LinearDesign::with_poles(&plant, &[-2.0, -3.0]).unwrap();
        let outputs = plant.c.nrows();
        // Semidefinite of rank 1, with digits that binary32 does not hold.
        let v = DVector::from_fn(outputs, |i, _| 1.0 + 0.3 * (i as f64 + 1.0));
        for (w, h, scale, error, noise) in
            [(1.0, 0.2, 1.0, 2.0, 0.0), (30.0, 0.5, 1e3, 100.0, 1e-3), (1e4, 0.1, 1e-3, 1e3, 0.0)]
        {
            let theta = &v * v.transpose() * scale;
            let design = SampledCubicDesign::new(&linear, &theta, w, h).unwrap();
            for format in [Format::Binary32, Format::Binary64] {
                let meets = meets(&plant, error, noise);
                let file = design.deployed_certificate_file("cubic", format.into(), &meets).unwrap();
                files.push(theorem(&file));
            }
        }
    }
    files
}

/// Linear observers by the designs, in both forms of the step and all formats.
fn linear_files() -> Vec<DeployedObserver> {
    let mut files = Vec::new();
    for plant in plants() {
        let held = zero_order_hold(&plant.a, &plant.b, 0.2).unwrap();
        let sampled = StateSpace::new(held.ad, held.bd, plant.c.clone()).unwrap();
        let l = DMatrix::from_fn(2, sampled.c.nrows(), |i, j| if i == j { 0.61 } else { -0.13 });
        for step in [Step::Innovation, Step::Joined, Step::Accumulated] {
            for format in [Format::Binary32, Format::Binary64, Format::Fixed { integer_bits: 8, fraction_bits: 14 }] {
                if step == Step::Accumulated && !matches!(format, Format::Fixed { .. }) {
                    continue;
                }
                for (error, noise) in [(2.0, 0.0), (4.0, 1e-2)] {
                    let found =
                        deployed_linear(&sampled, &l, step, format.into(), &meets(&sampled, error, noise)).unwrap();
                    files.push(theorem(&found.certificate_file("linear").unwrap()));
                }
            }
        }
    }
    files
}

fn neighbour(x: f64, format: Format, up: bool) -> f64 {
    let direction = if up { 1.0 } else { -1.0 };
    match format {
        Format::Binary32 => f64::from(if up { (x as f32).next_up() } else { (x as f32).next_down() }),
        Format::Fixed { fraction_bits, .. } => x + direction * 2.0_f64.powi(-fraction_bits.cast_signed()),
        Format::Binary64 => {
            if up {
                x.next_up()
            } else {
                x.next_down()
            }
        }
    }
}

/// What a change of meaning must lead to.
enum Expected {
    Anything,
    Refusal,
}

/// One change of meaning. The claims are made anew for it, unless they are what is changed.
fn mutated(of: &DeployedObserver, kind: usize, random: &mut Random) -> (DeployedObserver, Expected) {
    let mut t = of.clone();
    let (n, outputs) = t.stored.l.shape();
    let entry = (random.below(n), random.below(outputs));
    let format = t.formats.stored;
    let rounded = |x: f64| format.round(x).unwrap_or(x);
    match kind {
        0 => {
            // F or A off by one unit in the last place: not the nearest.
            let entry = (random.below(n), random.below(n));
            t.stored.a[entry] = neighbour(t.stored.a[entry], format, random.unit() > 0.0);
            return (t, Expected::Refusal);
        }
        1 => {
            // A claim better than what is proved.
            if let Some(ball) = &mut t.ball {
                match random.below(2) {
                    0 => ball.start = ball.start.next_down(),
                    _ => ball.entries[entry.0] = ball.entries[entry.0].next_down(),
                }
            }
            return (t, Expected::Refusal);
        }
        2 => t.stored.l[entry] = neighbour(t.stored.l[entry], format, random.unit() > 0.0),
        3 => t.stored.l[entry] = rounded(t.stored.l[entry] * 4.0 * random.unit()),
        4 => t.operation.error = t.operation.error.iter().map(|x| x * power(random, 20)).collect(),
        5 => t.operation.noise = t.operation.noise.iter().map(|_| power(random, 20)).collect(),
        6 => t.formats.stored = if format == Format::Binary32 { Format::Binary64 } else { Format::Binary32 },
        7 => t.formats.running = if format == Format::Binary32 { Format::Binary64 } else { Format::Binary32 },
        8 => t.operation.state = t.operation.state.iter().map(|x| x * power(random, 20)).collect(),
        9 => {
            let scale = 1.0 + 0.9 * random.unit();
            t.p = Matrix::from_fn(n, n, |i, j| t.p[(i, j)] * if i == j { 1.0 } else { scale });
        }
        _ => {}
    }
    if let Some(gains) = &mut t.stored.cubic {
        match kind {
            10 => gains.theta = gains.theta.map(|x| -x),
            11 => {
                // Indefinite, and not symmetric.
                let scale = power(random, 30);
                gains.theta = gains.theta.map(|x| rounded(x * scale * random.unit()));
            }
            12 => {
                let scale = random.sign() * power(random, 10);
                gains.n = gains.n.map(|x| rounded(x * scale));
            }
            13 => gains.w = rounded(gains.w * power(random, 40)),
            14 => {
                let scale = power(random, 100);
                gains.w = rounded(gains.w * scale);
                gains.n = gains.n.map(|x| rounded(x * scale));
            }
            15 => gains.h = rounded(gains.h * power(random, 60)),
            16 => {
                let scale = power(random, 60);
                gains.theta = gains.theta.map(|x| rounded(x * scale));
            }
            17 => gains.n[entry] = neighbour(gains.n[entry], format, random.unit() > 0.0),
            18 => {
                let (w, scale) = (gains.w, 2.0_f64.powi(127 - gains.w.log2() as i32));
                gains.w = w * scale;
                gains.n = gains.n.map(|x| rounded(x * scale));
                gains.theta = gains.theta.map(|_| 0.0);
            }
            19 => {
                // By columns: another map of the error, proved or not.
                let n = gains.n.clone();
                gains.n = Matrix::from_fn(n.rows(), n.cols(), |i, j| rounded(n[(i, j)] * (1.0 + 0.3 * random.unit())));
            }
            _ => {}
        }
    }
    // An attacker claims all that can be proved.
    let ball = derived(&t).and_then(|deployed| deployed.ball().map(ClaimedBall::from));
    if ball.is_some() {
        t.ball = ball;
    }
    (t, Expected::Anything)
}

/// Mutates each file in `kinds` ways, `rounds` times.
fn attack(files: &[DeployedObserver], kinds: usize, rounds: usize, seed: u64) -> (usize, usize, usize) {
    let mut random = Random(seed);
    let (mut tried, mut accepted, mut steps) = (0, 0, 0);
    for file in files {
        for kind in 0..kinds {
            for _ in 0..rounds {
                let (mutant, expected) = mutated(file, kind, &mut random);
                tried += 1;
                let Ok(sealed) = CertificateFile::prove("changed", mutant.clone()) else { continue };
                assert!(matches!(expected, Expected::Anything), "kind {kind} is accepted: {mutant:?}");
                assert!(verify(sealed.to_json().as_bytes()).is_ok());
                accepted += 1;
                let found = decreases(&mutant, &mut random).and_then(|()| survives(&mutant, &mut random));
                steps += found.unwrap_or_else(|why| panic!("kind {kind}: {why}: {mutant:?}"));
            }
        }
    }
    (tried, accepted, steps)
}

#[test]
fn accepted_changes_of_cubic_files_hold_when_they_run() {
    let (tried, accepted, steps) = attack(&cubic_files(), 20, 6, 1);
    println!("cubic: {tried} changed, {accepted} accepted, {steps} steps");
    assert!(
        accepted > tried / 5 && accepted < tried && steps > 10 * accepted,
        "{tried} changed, {accepted} accepted, {steps} steps"
    );
}

#[test]
fn accepted_changes_of_linear_files_hold_when_they_run() {
    let (tried, accepted, steps) = attack(&linear_files(), 10, 6, 2);
    println!("linear: {tried} changed, {accepted} accepted, {steps} steps");
    assert!(
        accepted > tried / 5 && accepted < tried && steps > 10 * accepted,
        "{tried} changed, {accepted} accepted, {steps} steps"
    );
}

/// A weight as an attacker would store it: the formula without the maximum takes V up by orders of magnitude, what runs
/// and what the file says does not.
#[test]
fn v_never_grows_for_a_stored_weight_that_is_not_semidefinite() {
    let mut random = Random(5);
    let number = |m: &Matrix<f64>, x: f64| Matrix::from_fn(m.rows(), m.cols(), |_, _| x);
    let mut proved = Vec::new();
    // By hand: theta = -1.
    for file in cubic_files().iter().filter(|file| file.stored.l.cols() == 1) {
        let mut negative = file.clone();
        let gains = negative.stored.cubic.as_mut().expect("cubic");
        gains.theta = number(&gains.theta, -1.0);
        negative.ball = derived(&negative).expect("fits").ball().map(ClaimedBall::from);
        proved.push(negative);
    }
    // By the design itself: v v' is semidefinite in binary64, and what binary32 makes of it is not.
    let plant = plants().remove(1);
    let linear = LinearDesign::with_poles(&plant, &[-2.0, -3.0]).unwrap();
    let mut rounded_off = 0;
    for k in 0..12 {
        let v = dmatrix![4099.0 + f64::from(2 * k); 8191.0 - f64::from(4 * k)];
        let design = SampledCubicDesign::new(&linear, &(&v * v.transpose()), 2.0, 0.2).unwrap();
        let meets = meets(&plant, 1e6, 0.0);
        let stored = theorem(&design.deployed_certificate_file("cubic", Format::Binary32.into(), &meets).unwrap());
        let theta = &stored.stored.cubic.as_ref().expect("cubic").theta;
        let [a, b, c] = [theta[(0, 0)], theta[(0, 1)], theta[(1, 1)]].map(exact);
        if a.mul(&c).sub(&b.mul(&b)).signum() < 0 {
            rounded_off += 1;
            proved.push(stored);
        }
    }
    assert!(rounded_off > 0, "no weight was made indefinite by its rounding");
    let mut without_the_maximum = 0.0_f64;
    for theorem in &proved {
        let file = CertificateFile::prove("an indefinite weight", theorem.clone()).expect("true of what runs");
        let words = verify(file.to_json().as_bytes()).expect("sealed").statement;
        assert!(words.contains("r = 1/sqrt(1 + 2 w h max(z'theta z, 0))"), "{words}");
        for _ in 0..20 {
            decreases(theorem, &mut random).unwrap();
            survives(theorem, &mut random).unwrap();
        }
        // Along a direction of negative weight, as far out as makes r = 1/sqrt(1 - (1 - 1e-9)).
        let gains = theorem.stored.cubic.as_ref().expect("cubic");
        let (theta, s) = (dynamic_matrix(&gains.theta), &theorem.stored);
        let eigen = ((&theta + theta.transpose()) * 0.5).symmetric_eigen();
        let (index, weight) = eigen.eigenvalues.argmin();
        let z = eigen.eigenvectors.column(index) * ((1.0 - 1e-9) / (-2.0 * gains.w * gains.h * weight)).sqrt();
        let r = 1e-9_f64.sqrt().recip();
        let [a, c, l, n, p] = [&s.a, &s.c, &s.l, &gains.n, &theorem.p].map(dynamic_matrix);
        let e = c.clone().pseudo_inverse(1e-12).unwrap() * &z;
        let next = &a * (&e + &n * &z * ((1.0 - r) / gains.w)) - &l * &z * r;
        without_the_maximum = without_the_maximum.max(next.dot(&(&p * &next)) / e.dot(&(&p * &e)));
    }
    assert!(without_the_maximum > 1e3, "V would grow by {without_the_maximum:e}");
    println!("{} files; without the maximum V would grow by {without_the_maximum:e}", proved.len());
}

/// The largest w of binary32, of which 2w is none. N and L are small, so that what underflow takes from the flow counts
/// for little.
#[test]
fn the_largest_rate_of_single_precision_runs() {
    let number = |x: f64| Matrix::from_rows([[x]]);
    let w = 2.0_f64.powi(127);
    for theta in [0.0, 1e-30] {
        let plant = statement::SampledPlant { a: number(0.5), b: Matrix::from_fn(1, 0, |_, _| 0.0), c: number(1.0) };
        let gains = statement::CubicGains { n: number(-1.0), theta: number(theta), w, h: 0.125 };
        let operation =
            Operation { state: vec![1.0], input: vec![], noise: vec![0.0], error: vec![1.0], deviation: None };
        let formats: statement::Formats = Format::Binary32.into();
        let l = number(2.0_f64.powi(-30));
        let found = statement::deployed_sampled_cubic(&plant, &l, &gains, &number(1.0), formats, &operation).unwrap();
        let ball = found.ball().unwrap_or_else(|| panic!("{:?}", found.running));
        let driven = ball.intermediates.iter().find(|found| found.what == "w k").expect("listed");
        assert!(driven.size >= 2.0 * w * 0.125 * theta && driven.size <= driven.limit, "{driven:?}");
        let theorem = DeployedObserver {
            plant,
            ball: Some(ball.into()),
            stored: found.stored,
            step: Step::Innovation,
            formats,
            operation,
            p: number(1.0),
        };
        assert!(CertificateFile::prove("the largest rate", theorem.clone()).is_ok());
        assert!(survives(&theorem, &mut Random(1)).unwrap() > 100);
    }
}
