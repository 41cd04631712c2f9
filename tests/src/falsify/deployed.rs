//! Falsification of the deployed observer: the step is executed bit by bit, in binary32, binary64 or two's complement,
//! on a plant with twice the digits of binary64, which deviates from A and B at the bounds of the deviation.
//!
//! Inputs, noise, states and initial errors lie within their bounds, most often on them; the noise is the one that
//! increases the error most. The sums are computed forwards, backwards and with fused operations. Compared with the
//! statement are: the stored numbers, the contraction of the stored matrices, the ball at every step, and at the end
//! the bounds of the limit. The cubic step in floating point is that of `luenberger_observers::SampledCubicObserver`
//! itself, and the accumulated step in fixed point that of `luenberger_observers::FixedPointObserver`.

use luenberger_observers::{
    FixedPointFormat, FixedPointFormats, FixedPointGains, FixedPointObserver, SampledCubicGains, SampledCubicObserver,
    SampledObserver,
};
use luenberger_random::Random;
use nalgebra::{DMatrix, DVector, Dyn, RealField};
use serde_json::Value;

use super::adversary::{Found, ensure, sampled_falls};
use super::document::{binary64, float_matrix, floats, matrix};
use super::exact::Exact;

/// Number of steps.
const STEPS: usize = 240;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Format {
    Binary32,
    Binary64,
    Fixed { integer: i32, fraction: i32 },
}

impl Format {
    fn of(value: &Value) -> Result<Self, String> {
        let word = value.as_str().unwrap_or_default();
        let fixed = || {
            let (integer, fraction) = word.strip_prefix('Q')?.split_once('.')?;
            Some(Self::Fixed { integer: integer.parse().ok()?, fraction: fraction.parse().ok()? })
        };
        match word {
            "binary32" => Ok(Self::Binary32),
            "binary64" => Ok(Self::Binary64),
            _ => fixed().ok_or_else(|| format!("a format {word}")),
        }
    }

    /// To nearest, ties to even.
    fn round(self, x: f64) -> f64 {
        match self {
            Self::Binary32 => f64::from(x as f32),
            Self::Binary64 => x,
            Self::Fixed { fraction, .. } => (x * 2.0_f64.powi(fraction)).round_ties_even() * 2.0_f64.powi(-fraction),
        }
    }

    fn has(self, x: f64) -> bool {
        match self {
            Self::Fixed { integer, fraction } => {
                let bound = 2.0_f64.powi(integer - 1);
                -bound <= x && x <= bound - 2.0_f64.powi(-fraction)
            }
            _ => self.round(x).is_finite(),
        }
    }
}

/// Products and sums of a target.
#[derive(Clone, Copy)]
struct Target {
    format: Format,
    order: usize,
}

impl Target {
    /// `start + sum a_k b_k`; `None` where a number leaves the format.
    fn dot(self, start: f64, terms: &[(f64, f64)]) -> Option<f64> {
        let mut terms = terms.to_vec();
        if self.order % 2 == 1 {
            terms.reverse();
        }
        let fused = self.order >= 2;
        let found = match self.format {
            Format::Binary32 => f64::from(terms.iter().fold(start as f32, |sum, &(a, b)| {
                let (a, b) = (a as f32, b as f32);
                if fused { a.mul_add(b, sum) } else { sum + a * b }
            })),
            Format::Binary64 => {
                terms.iter().fold(start, |sum, &(a, b)| if fused { a.mul_add(b, sum) } else { sum + a * b })
            }
            Format::Fixed { integer, fraction } => {
                let whole = |x: f64| (x * 2.0_f64.powi(fraction)) as i128;
                let nearest = |x: i128| {
                    if fraction == 0 {
                        return x;
                    }
                    let floor = x >> fraction;
                    let (rest, half) = (x - (floor << fraction), 1_i128 << (fraction - 1));
                    floor + i128::from(rest > half || (rest == half && floor & 1 == 1))
                };
                let bound = 1_i128 << (integer - 1 + fraction);
                let mut sum = whole(start);
                let mut wide = sum << fraction;
                for &(a, b) in &terms {
                    let product = whole(a) * whole(b);
                    wide += product;
                    sum += nearest(product);
                    if !(-bound..bound).contains(&sum) {
                        return None;
                    }
                }
                if fused {
                    sum = nearest(wide);
                }
                (-bound..bound).contains(&sum).then_some(sum as f64 * 2.0_f64.powi(-fraction))?
            }
        };
        found.is_finite().then_some(found)
    }

    fn product(self, starts: &[f64], parts: &[(&DMatrix<f64>, f64, &[f64])]) -> Option<Vec<f64>> {
        starts
            .iter()
            .enumerate()
            .map(|(i, start)| {
                let terms: Vec<(f64, f64)> = parts
                    .iter()
                    .flat_map(|(m, sign, x)| x.iter().enumerate().map(move |(j, x)| (sign * m[(i, j)], *x)))
                    .collect();
                self.dot(*start, &terms)
            })
            .collect()
    }
}

/// A sum of two binary64 numbers: twice the digits.
#[derive(Debug, Clone, Copy)]
struct Double(f64, f64);

impl Double {
    fn plus(self, other: Self) -> Self {
        let sum = self.0 + other.0;
        let back = sum - self.0;
        let low = (self.0 - (sum - back)) + (other.0 - back) + self.1 + other.1;
        let high = sum + low;
        Self(high, low - (high - sum))
    }

    fn times(self, factor: f64) -> Self {
        let product = self.0 * factor;
        let low = self.0.mul_add(factor, -product) + self.1 * factor;
        let high = product + low;
        Self(high, low - (high - product))
    }
}

fn applied(m: &DMatrix<f64>, x: &[Double]) -> Vec<Double> {
    (0..m.nrows())
        .map(|i| x.iter().enumerate().fold(Double(0.0, 0.0), |sum, (j, x)| sum.plus(x.times(m[(i, j)]))))
        .collect()
}

/// The stored number is one of the format, and none of its neighbours there is nearer to the exact one.
fn is_nearest(format: Format, stored: f64, exact: &Exact) -> bool {
    let neighbours = match format {
        Format::Binary64 => [stored.next_up(), stored.next_down()],
        Format::Binary32 => [f64::from((stored as f32).next_up()), f64::from((stored as f32).next_down())],
        Format::Fixed { fraction, .. } => [stored + 2.0_f64.powi(-fraction), stored - 2.0_f64.powi(-fraction)],
    };
    let squared = |x: f64| {
        let left = Exact::number(x).minus(exact);
        left.times(&left)
    };
    let own = squared(stored);
    format.round(stored) == stored
        && format.has(stored)
        && neighbours.into_iter().filter(|x| x.is_finite()).all(|x| squared(x).minus(&own).sign() >= 0)
}

fn all_nearest(format: Format, stored: &DMatrix<f64>, exact: &Exact, what: &str) -> Found {
    for i in 0..stored.nrows() {
        for j in 0..stored.ncols() {
            ensure(is_nearest(format, stored[(i, j)], &exact.at(i, j)), || {
                format!("{what}({i}, {j}) = {:e} is not the nearest number of the format", stored[(i, j)])
            })?;
        }
    }
    Ok(())
}

/// The implemented observer.
enum Step {
    Joined { f: DMatrix<f64> },
    Innovation { a: DMatrix<f64>, c: DMatrix<f64> },
    Accumulated(FixedPointObserver<Dyn, Dyn, Dyn>),
    Cubic32(SampledCubicObserver<f32, Dyn, Dyn, Dyn>),
    Cubic64(SampledCubicObserver<f64, Dyn, Dyn, Dyn>),
}

fn cubic<T: RealField + Copy>(
    stored: &Value,
    convert: impl Fn(f64) -> T,
) -> Option<SampledCubicObserver<T, Dyn, Dyn, Dyn>> {
    let read = |name: &str| float_matrix(&stored[name]).map(&convert);
    let a = read("A");
    let b = if a.nrows() > 0 && stored["B"][0].as_array().is_some_and(Vec::is_empty) {
        DMatrix::from_element(a.nrows(), 0, convert(0.0))
    } else {
        read("B")
    };
    let scalar = |name: &str| Some(convert(binary64(&stored[name])));
    let gains = SampledCubicGains {
        ad: a,
        bd: b,
        c: read("C"),
        ld: read("L"),
        n: read("N"),
        theta: read("theta"),
        w: scalar("w")?,
        period: scalar("period")?,
    };
    SampledCubicObserver::new(gains).ok()
}

/// The observer in integers; `None` where it refuses the formats or the matrices, and then does not run.
fn accumulated(
    stored: &Value,
    inputs: usize,
    holds: Format,
    runs: Format,
) -> Option<FixedPointObserver<Dyn, Dyn, Dyn>> {
    let format = |format: Format| match format {
        Format::Fixed { integer, fraction } => {
            FixedPointFormat::new(u32::try_from(integer).ok()?, u32::try_from(fraction).ok()?).ok()
        }
        _ => None,
    };
    let formats = FixedPointFormats { gains: format(holds)?, signals: format(runs)? };
    let integers = |name: &str| {
        let m = float_matrix(&stored[name]);
        let entries: Option<Vec<i32>> = m.iter().map(|x| formats.gains.nearest(*x)).collect();
        Some(DMatrix::from_vec(m.nrows(), m.ncols(), entries?))
    };
    let a = integers("A")?;
    let b = if inputs == 0 { DMatrix::zeros(a.nrows(), 0) } else { integers("B")? };
    let gains = FixedPointGains { a, b, c: integers("C")?, d: None, l: integers("L")? };
    FixedPointObserver::new(gains, formats).ok()
}

/// A step in integers; `None` where a number leaves the format.
fn in_integers(
    observer: &FixedPointObserver<Dyn, Dyn, Dyn>,
    (xhat, u, y): (&[f64], &[f64], &[f64]),
) -> Option<Vec<f64>> {
    let signals = observer.formats().signals;
    let column = |x: &[f64]| {
        let entries: Option<Vec<i32>> = x.iter().map(|x| signals.nearest(*x)).collect();
        entries.map(DVector::from_vec)
    };
    let mut state = observer.start(column(xhat)?);
    observer.step(&mut state, &column(u)?, &column(y)?);
    (state.saturations == 0).then(|| state.xhat.iter().map(|x| signals.value(*x)).collect())
}

fn stepped<T: RealField + Copy>(
    observer: &SampledCubicObserver<T, Dyn, Dyn, Dyn>,
    (xhat, u, y): (&[f64], &[f64], &[f64]),
    convert: impl Fn(f64) -> T,
    back: impl Fn(T) -> f64,
) -> Option<Vec<f64>> {
    let vector = |x: &[f64]| DVector::from_iterator(x.len(), x.iter().map(|x| convert(*x)));
    let mut state = vector(xhat);
    observer.step(convert(0.0), &mut state, &vector(u), &vector(y));
    let next: Vec<f64> = state.iter().map(|x| back(*x)).collect();
    next.iter().all(|x| x.is_finite()).then_some(next)
}

pub(super) fn contradicted(document: &Value, random: &mut Random) -> Found {
    let (plant, stored, operation) = (&document["plant"], &document["stored"], &document["operation"]);
    let (holds, runs) = (Format::of(&document["formats"]["stored"])?, Format::of(&document["formats"]["running"])?);
    let step = document["step"].as_str().unwrap_or_default();
    let (a, c) = (matrix(&plant["A"], random), matrix(&plant["C"], random));
    let inputs = floats(&operation["u"]).len();
    let (n, l) = (a.rows, matrix(&stored["L"], random));
    let p = matrix(&document["lyapunov"]["P"], random);
    ensure(p.is_positive(), || "false: P > 0".to_owned())?;
    // What is stored.
    let read = |name: &str| float_matrix(&stored[name]);
    let itself =
        |name: &str, random: &mut Random| all_nearest(holds, &read(name), &matrix(&stored[name], random), name);
    itself("L", random)?;
    if inputs > 0 {
        all_nearest(holds, &read("B"), &matrix(&plant["B"], random), "B")?;
    }
    let f = if step == "joined" {
        all_nearest(holds, &read("F"), &a.minus(&l.times(&c)), "F")?;
        matrix(&stored["F"], random)
    } else {
        all_nearest(holds, &read("A"), &a, "A")?;
        all_nearest(holds, &read("C"), &c, "C")?;
        matrix(&stored["A"], random).minus(&l.times(&matrix(&stored["C"], random)))
    };
    ensure(f.is_schur() && p.minus(&f.congruent(&p)).is_positive(), || {
        "the stored observer does not contract".to_owned()
    })?;
    let (a, c) = (float_matrix(&plant["A"]), float_matrix(&plant["C"]));
    let b = if inputs == 0 { DMatrix::zeros(n, 0) } else { float_matrix(&plant["B"]) };
    let mut observer = match step {
        "joined" => Some(Step::Joined { f: read("F") }),
        "innovation" => Some(Step::Innovation { a: read("A"), c: read("C") }),
        // In floating point the bound is that of every order of operations.
        "accumulated" if !matches!(runs, Format::Fixed { .. }) => Some(Step::Innovation { a: read("A"), c: read("C") }),
        "accumulated" => accumulated(stored, inputs, holds, runs).map(Step::Accumulated),
        _ => {
            itself("N", random)?;
            itself("theta", random)?;
            let (w, h) = (binary64(&stored["w"]), binary64(&stored["period"]));
            ensure(w > 0.0 && h > 0.0 && holds.round(w) == w && holds.round(h) == h, || {
                "w and h of the format".to_owned()
            })?;
            let [a, c, n] = ["A", "C", "N"].map(|name| matrix(&stored[name], random));
            sampled_falls(&a, &c, &l, &n, &Exact::number(w), &p)?;
            match runs {
                Format::Binary32 => cubic(stored, |x| x as f32).map(Step::Cubic32),
                Format::Binary64 => cubic(stored, |x| x).map(Step::Cubic64),
                Format::Fixed { .. } => None,
            }
        }
    };
    let Some(running) = document.get("running") else { return Ok(()) };
    if matches!(runs, Format::Fixed { integer, fraction } if integer + fraction > 60) {
        return Ok(());
    }
    // An observer that refuses its numbers does not run.
    let Some(observer) = observer.take() else { return Ok(()) };
    let start = binary64(&running["start"]);
    let limits = floats(&running["limsup"]);
    let bounds = ["x", "u", "v", "e(0)"].map(|name| floats(&operation[name]));
    let [states, input_bounds, noises, errors] = &bounds;
    let gains = (read("L"), if inputs == 0 { DMatrix::zeros(n, 0) } else { read("B") });
    let target = Target { format: runs, order: random.below(4) };
    // The error starts within its bounds, as the difference of two numbers of which one is of the format.
    let mut xhat = Vec::new();
    let mut x = Vec::new();
    for i in 0..n {
        let first = states[i] * if random.once_in(2) { random.sign() } else { random.unit() };
        let error = errors[i] * if random.once_in(4) { random.unit() } else { random.sign() };
        let estimate = runs.round(first - error);
        let first = if (first - estimate).abs() <= errors[i] { first } else { estimate };
        if !runs.has(estimate) || first.abs() > states[i] {
            return Ok(());
        }
        xhat.push(estimate);
        x.push(Double(first, 0.0));
    }
    let float_p = float_matrix(&document["lyapunov"]["P"]);
    let float_f = if step == "joined" { read("F") } else { read("A") - read("L") * read("C") };
    let deviations = operation.get("dA").map(|da| {
        let db = if inputs == 0 { DMatrix::zeros(n, 0) } else { float_matrix(&operation["dB"]) };
        (float_matrix(da), db)
    });
    let mut transient = DMatrix::<f64>::identity(n, n);
    for k in 0..STEPS {
        let e: Vec<f64> = x.iter().zip(&xhat).map(|(x, xhat)| x.plus(Double(-xhat, 0.0)).0).collect();
        let e = DVector::from_vec(e);
        let energy = e.dot(&(&float_p * &e)).max(0.0).sqrt();
        let scale = float_p.norm().sqrt() * e.norm();
        ensure(energy <= start + 1e-12 * scale, || format!("sqrt(e'Pe) = {energy:e} above {start:e} at step {k}"))?;
        // The limit is that of all times: what the first error has left of itself is counted apart. For the cubic
        // observer the map is another one while the error is large.
        if k > STEPS / 2 && !matches!(observer, Step::Cubic32(_) | Step::Cubic64(_)) || k + 1 == STEPS {
            let left = transient
                .abs()
                .row_iter()
                .map(|row| row.iter().zip(errors).map(|(f, e)| f * e).sum::<f64>())
                .collect::<Vec<_>>();
            let small = left.iter().zip(&limits).all(|(left, limit)| *left <= 1e-9 * limit);
            for (i, limit) in limits.iter().enumerate().filter(|_| small) {
                ensure(e[i].abs() <= limit * (1.0 + 1e-6), || {
                    format!("|e_{}| = {:e} above {limit:e} at step {k}", i + 1, e[i].abs())
                })?;
            }
        }
        transient = &transient * &float_f;
        // Inputs on their bounds that keep the state within its own; noise that pushes the error outwards.
        let mut next = None;
        for attempt in 0..4 {
            let u: Vec<f64> = input_bounds
                .iter()
                .map(|bound| {
                    let wished = if attempt == 3 {
                        0.0
                    } else {
                        bound * if random.once_in(3) { random.unit() } else { random.sign() }
                    };
                    let rounded = runs.round(wished);
                    if rounded.abs() <= *bound { rounded } else { 0.0 }
                })
                .collect();
            // The plant deviates from A and B, each step in its own way.
            let mut deviates = |m: &DMatrix<f64>, bound: Option<&DMatrix<f64>>| match bound {
                Some(bound) => m + bound.map(|bound| bound * (1.0 - 1e-12) * random.sign()),
                None => m.clone(),
            };
            let a = deviates(&a, deviations.as_ref().map(|(a, _)| a));
            let b = deviates(&b, deviations.as_ref().map(|(_, b)| b));
            let moved = applied(&b, &u.iter().map(|u| Double(*u, 0.0)).collect::<Vec<_>>());
            let following: Vec<Double> = applied(&a, &x).into_iter().zip(moved).map(|(ax, bu)| ax.plus(bu)).collect();
            if following.iter().zip(states).all(|(x, bound)| x.0.abs() <= *bound) {
                next = Some((u, following));
                break;
            }
        }
        let Some((u, following)) = next else { return Ok(()) };
        let outward = gains.0.transpose() * &float_p * &float_f * &e;
        let y: Vec<f64> = applied(&c, &x)
            .into_iter()
            .enumerate()
            .map(|(i, y)| {
                let noise = if random.once_in(6) { random.unit() } else { -outward[i].signum() };
                runs.round(y.plus(Double(noises[i] * noise, 0.0)).0)
            })
            .collect();
        let zeros = vec![0.0; n];
        let estimated = match &observer {
            Step::Joined { f } => target.product(&zeros, &[(f, 1.0, &xhat), (&gains.1, 1.0, &u), (&gains.0, 1.0, &y)]),
            Step::Innovation { a, c } => target
                .product(&y, &[(c, -1.0, &xhat)])
                .and_then(|z| target.product(&zeros, &[(a, 1.0, &xhat), (&gains.1, 1.0, &u), (&gains.0, 1.0, &z)])),
            Step::Accumulated(observer) => in_integers(observer, (&xhat, &u, &y)),
            Step::Cubic32(observer) => stepped(observer, (&xhat, &u, &y), |x| x as f32, f64::from),
            Step::Cubic64(observer) => stepped(observer, (&xhat, &u, &y), |x| x, |x| x),
        };
        xhat = estimated.ok_or_else(|| format!("a number leaves the format at step {k}"))?;
        x = following;
    }
    Ok(())
}
