//! Proposition 7 as a constructor: from the parts of a plant to its [KKL+PEB] observer, with the hypotheses checked as
//! far as possible.
//!
//! ```text
//! x1' = f1(x1, x2, x3, u) + S(x, u),  row k of S is b(x1, x2, x3, u)' x4       y = x1
//! x2' = A2 x2 + f2(x1, u),  x3' = A3 x3 + f3(x1, x2, u),  x4' = f4(x1, x2, x3, u)                     (40), (41)
//! ```
//!
//! The proposition has three hypotheses. The plant has this form: the parts are compared with the plant at every sample
//! of a run. A2 and A3 are Hurwitz: proved. The input keeps the trajectories bounded and b persistently exciting,
//! ```text
//!     int_t^(t+T) b b' ds >= delta I      for all t >= 0,                                             (42)
//! ```
//! which is a property of a trajectory: it is measured along that run. The run is given as data, not simulated here;
//! the exciting input (state feedback, a function of time or a recording) is chosen in `luenberger-sim` or on a test
//! bench.
//!
//! **(42) of b does not suffice**: the estimator sees `psi = F[b]`, `F = alpha/(p + alpha)`. With b = sin t^2 (42)
//! holds, and the integral of psi^2 over all times is 0.27. The proposition holds with (42) for psi, which follows
//! from (42) for b where b' is bounded. A run of finite length cannot tell; see
//! [`NOT_CHECKED`](KklPebReport::NOT_CHECKED).
//!
//! Source: B. Yi, R. Ortega and W. Zhang, IEEE Transactions on Automatic Control, 2018, Proposition 7.

use core::fmt;

use luenberger_linalg::lambda_min;
use luenberger_observers::ObserverError;
use luenberger_observers::cascade::{Cascade, CascadeMap, CascadeSize};
use luenberger_plants::error::check_matrix;
use luenberger_plants::{Column, Plant, PlantError};
use luenberger_proof::certificate::Certificate;
use luenberger_proof::{Interval, Matrix};
use nalgebra::{Complex, DMatrix, DVector, DefaultAllocator, Dim, OMatrix, OVector, SymmetricEigen, U1};

use crate::check::within;
use crate::error::DesignError;
use crate::kkl::KklError;
use crate::kkl::stability::{HurwitzAnalysis, hurwitz, require_decay};
use crate::number::short;

/// A run of the plant: a row of x and of u for each time.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledRun {
    t: Vec<f64>,
    x: DMatrix<f64>,
    u: DMatrix<f64>,
}

impl SampledRun {
    /// The states `x` (a row for each time) and the inputs `u` at the increasing times `t`, as a trajectory of
    /// `luenberger-sim` has them.
    ///
    /// # Errors
    /// [`KklError::Samples`], [`KklError::Times`] for invalid tables; [`KklError::Unbounding`] has the time and the
    /// coordinate of the first value that is not finite.
    pub fn new(t: &[f64], x: &DMatrix<f64>, u: &DMatrix<f64>) -> Result<Self, KklError> {
        if t.len() < 2 || x.nrows() != t.len() || u.nrows() != t.len() {
            return Err(KklError::Samples { times: t.len(), states: x.nrows(), inputs: u.nrows() });
        }
        for (before, pair) in t.windows(2).enumerate() {
            let increases = pair[0] < pair[1] && pair[0].is_finite() && pair[1].is_finite();
            if !increases {
                return Err(KklError::Times { sample: before + 1, before: pair[0], after: pair[1] });
            }
        }
        for (row, &time) in t.iter().enumerate() {
            for (what, table) in [("x", x), ("u", u)] {
                if let Some((index, &value)) = table.row(row).iter().enumerate().find(|(_, value)| !value.is_finite()) {
                    return Err(KklError::Unbounding { what, index, value, time });
                }
            }
        }
        Ok(Self { t: t.to_vec(), x: x.clone(), u: u.clone() })
    }
}

/// Requirements on the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excite {
    /// T of (42), in the units of the run's times.
    pub window: f64,
    /// The required delta of (42); 0 requires only more than the rounding error.
    pub needed: f64,
    /// Bound on |x_i|; infinite if there is none.
    pub bound: f64,
}

impl Excite {
    /// Any positive excitation over windows of this length, and any bounded run.
    pub fn within(window: f64) -> Self {
        Self { window, needed: 0.0, bound: f64::INFINITY }
    }
}

/// (42) along the run.
#[derive(Clone, Debug, PartialEq)]
pub struct Excitation {
    /// T.
    pub window: f64,
    /// The least eigenvalue of `int b b'` over the windows examined, by the trapezoidal rule: delta.
    pub delta: f64,
    /// Start of the worst window.
    pub from: f64,
    /// The least excited direction of x4 in it.
    pub direction: Vec<f64>,
    /// The largest trace over the windows, an upper bound of every eigenvalue: its ratio to delta measures how
    /// differently the directions are excited.
    pub greatest: f64,
    /// Relative change of delta of the worst window if every second sample is omitted: whether the samples are dense
    /// enough.
    pub quadrature: f64,
    /// Number of windows, evenly spread.
    pub windows: usize,
}

/// Results of the checks of the hypotheses of Proposition 7.
#[derive(Clone, Debug, PartialEq)]
pub struct KklPebReport {
    /// A2 and A3 by name, each proved Hurwitz; those that have states.
    pub blocks: Vec<(&'static str, Certificate)>,
    /// The eigenvalue of A2 or A3 with the largest real part; none where both are empty.
    pub slowest: Option<Complex<f64>>,
    /// (42) along the run.
    pub excitation: Excitation,
    /// The largest |x_i| along the run.
    pub greatest: Vec<f64>,
    /// The largest ratio, over the states, of the largest |x_i| of the second half to that of the first: a run that is
    /// bounded and long enough has about 1.
    pub growth: f64,
    /// The largest difference between the given parts and the plant's own equation, relative to the largest value of
    /// the equation along the run.
    pub mismatch: f64,
    /// Samples of the run.
    pub samples: usize,
}

impl KklPebReport {
    /// The hypotheses of Proposition 7 that are not checked here.
    pub const NOT_CHECKED: [&'static str; 4] = [
        "that b' is bounded: (42) is measured for b, and the estimator sees F[b], for which it need not hold otherwise",
        "boundedness and (42) after the run, for other inputs and from other states",
        "the Lipschitz constants of f1, f3, f4 and b in x2 and x3 on the set where the run lives",
        "noise in y",
    ];
}

impl fmt::Display for KklPebReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, certificate) in &self.blocks {
            for fact in certificate.facts() {
                writeln!(f, "{:<9}  {fact}, with A = {name}", fact.verdict.word())?;
            }
        }
        let Excitation { window, delta, from, greatest, windows, .. } = &self.excitation;
        writeln!(
            f,
            "measured   int b b' >= {} I (42) over {window} s, worst from {from}, trace at most {}; {windows} windows",
            short(*delta),
            short(*greatest)
        )?;
        let largest: Vec<String> = self.greatest.iter().map(|x| format!("{x:.3}")).collect();
        writeln!(f, "measured   |x| <= ({}), second half over first {:.2}", largest.join(", "), self.growth)?;
        writeln!(
            f,
            "measured   the pieces are the plant's up to {}, at {} samples",
            short(self.mismatch),
            self.samples
        )?;
        for what in Self::NOT_CHECKED {
            writeln!(f, "not checked  {what}")?;
        }
        Ok(())
    }
}

/// The [KKL+PEB] observer of a plant of Proposition 7's class, with the checked hypotheses.
#[derive(Clone, Debug, PartialEq)]
pub struct KklPebDesign<O> {
    /// The observer, ready to run.
    pub observer: O,
    /// The checked hypotheses.
    pub report: KklPebReport,
}

impl<O> KklPebDesign<O> {
    /// The observer of `plant` with states (x1, x2, x3, x4) and parts `cascade`; `excite` has the requirements on
    /// `run`. `make` chooses the estimator and the filters: it takes the checked maps and returns the observer, usually
    /// a [`KklPebObserver`](luenberger_observers::KklPebObserver).
    ///
    /// `x1' = -x1 + x4 sin t` with u = sin t: b = u, and x4 a constant.
    /// ```
    /// use luenberger_design::KklPebDesign;
    /// use luenberger_design::kkl_peb::{Excite, SampledRun};
    /// use luenberger_observers::KklPebObserver;
    /// use luenberger_observers::cascade::Cascade;
    /// use luenberger_observers::estimator::gradient::Gradient;
    /// use luenberger_plants::plant;
    /// use nalgebra::{DMatrix, Matrix1, SMatrix, SVector, U0, U1, Vector1, Vector2};
    ///
    /// #[derive(Clone, Copy)]
    /// struct Gain;
    /// type Nothing = SVector<f64, 0>;
    /// plant!(Gain, (2, 1, 1), |plant, t, x, u| [x[1] * u[0] - x[0], T::zero()], [x[0]]);
    /// impl Cascade<f64> for Gain {
    ///     type Second = U0;
    ///     type Third = U0;
    ///     type Fourth = U1;
    ///     type Inputs = U1;
    ///     type Outputs = U1;
    ///     fn a2(&self) -> SMatrix<f64, 0, 0> {
    ///         SMatrix::<f64, 0, 0>::zeros()
    ///     }
    ///     fn a3(&self) -> SMatrix<f64, 0, 0> {
    ///         SMatrix::<f64, 0, 0>::zeros()
    ///     }
    ///     fn k(&self) -> usize {
    ///         0
    ///     }
    ///     fn f1k(&self, y: &Vector1<f64>, _x2: &Nothing, _x3: &Nothing, _u: &Vector1<f64>) -> f64 {
    ///         -y[0]
    ///     }
    ///     fn f2(&self, _y: &Vector1<f64>, _u: &Vector1<f64>) -> Nothing {
    ///         Nothing::zeros()
    ///     }
    ///     fn f3(&self, _y: &Vector1<f64>, _x2: &Nothing, _u: &Vector1<f64>) -> Nothing {
    ///         Nothing::zeros()
    ///     }
    ///     fn f4(&self, _y: &Vector1<f64>, _x2: &Nothing, _x3: &Nothing, _u: &Vector1<f64>) -> Vector1<f64> {
    ///         Vector1::zeros()
    ///     }
    ///     fn b(&self, _y: &Vector1<f64>, _x2: &Nothing, _x3: &Nothing, u: &Vector1<f64>) -> Vector1<f64> {
    ///         *u
    ///     }
    /// }
    ///
    /// // The run in closed form, x4 = 2: x1 = sin t - cos t solves x1' = -x1 + 2 sin t.
    /// let t: Vec<f64> = (0..=1000).map(|k| f64::from(k) * 0.02).collect();
    /// let x = DMatrix::from_fn(1001, 2, |row, state| if state == 0 { t[row].sin() - t[row].cos() } else { 2.0 });
    /// let u = DMatrix::from_fn(1001, 1, |row, _| t[row].sin());
    /// let run = SampledRun::new(&t, &x, &u)?;
    /// let window = std::f64::consts::PI;
    /// let estimator = Gradient::new(Matrix1::new(2.0))?;
    /// let design =
    ///     KklPebDesign::new(&Gain, Gain, &run, &Excite::within(window), |map| KklPebObserver::new(map, estimator, 5.0))?;
    /// // The integral of sin^2 over half a period is pi/2; the window ends at the first sample after T, at most 0.01
    /// // later.
    /// let excess = design.report.excitation.delta - 0.5 * window;
    /// assert!(excess > -1e-3 && excess < 0.02);
    /// println!("{}", design.report);
    /// # Ok::<(), luenberger_design::KklError>(())
    /// ```
    ///
    /// Cost: two Lyapunov equations and their proofs; two evaluations of the pieces at each sample; at most 512 windows
    /// of `n4^2` operations for each of their samples.
    ///
    /// # Errors
    /// [`KklError::NotHurwitz`] names the eigenvalue of A2 or A3; [`KklError::Mismatch`] the equation and the time at
    /// which pieces and plant differ; [`KklError::NotExciting`] has the delta achieved, the window and the direction
    /// that it does not show; [`KklError::Unbounding`] the time; [`KklError::NothingToEstimate`];
    /// [`DesignError::Setting`]; [`KklError::Design`] for shapes and entries, and what `make` returns.
    pub fn new<S, C>(
        plant: &S,
        cascade: C,
        run: &SampledRun,
        excite: &Excite,
        make: impl FnOnce(CascadeMap<C>) -> Result<O, ObserverError>,
    ) -> Result<Self, KklError>
    where
        S: Plant<f64>,
        C: Cascade<f64>,
        DefaultAllocator: CascadeSize<C::Second, C::Third, C::Fourth, C::Inputs, C::Outputs>,
    {
        let report = examine(plant, &cascade, run, excite)?;
        Ok(Self { observer: make(CascadeMap::new::<f64>(cascade)?)?, report })
    }
}

/// Verdicts on the hypotheses.
fn examine<S, C>(plant: &S, cascade: &C, run: &SampledRun, excite: &Excite) -> Result<KklPebReport, KklError>
where
    S: Plant<f64>,
    C: Cascade<f64>,
    DefaultAllocator: CascadeSize<C::Second, C::Third, C::Fourth, C::Inputs, C::Outputs>,
{
    let [n2, n3, n4] = cascade.blocks();
    if n4 == 0 {
        return Err(KklError::NothingToEstimate);
    }
    let (inputs, outputs) = cascade.inputs_and_outputs();
    let size = plant.dimensions();
    let expected = (outputs + n2 + n3 + n4, inputs, outputs);
    let (n, m, p) = expected;
    let sizes = [
        ("x", n, size.states, S::State::fixed_len()),
        ("u", m, size.inputs, S::Input::fixed_len()),
        ("y", p, size.outputs, S::Output::fixed_len()),
        ("x of the run", n, run.x.ncols(), None),
        ("u of the run", m, run.u.ncols(), None),
        ("x2", n2, n2, C::Second::try_to_usize()),
        ("x3", n3, n3, C::Third::try_to_usize()),
        ("x4", n4, n4, C::Fourth::try_to_usize()),
        ("u of the pieces", m, m, C::Inputs::try_to_usize()),
        ("y of the pieces", p, p, C::Outputs::try_to_usize()),
    ];
    for (what, expected, found, fixed) in sizes {
        let found = if found == expected { fixed.unwrap_or(found) } else { found };
        if found != expected {
            return Err(PlantError::DimensionMismatch { what, expected: (expected, 1), found: (found, 1) }.into());
        }
    }
    if cascade.k() >= p {
        return Err(ObserverError::Output { output: cascade.k(), outputs: p }.into());
    }
    let length = run.t[run.t.len() - 1] - run.t[0];
    within("the window", excite.window, f64::MIN_POSITIVE, length)?;
    within("the excitation needed", excite.needed, 0.0, f64::MAX)?;
    within("the bound of the states", excite.bound, f64::MIN_POSITIVE, f64::INFINITY)?;
    let (mut blocks, mut slowest) = (Vec::new(), None);
    for (what, order, block) in [("A2", n2, dynamic(&cascade.a2())), ("A3", n3, dynamic(&cascade.a3()))] {
        check_matrix(what, &block, (order, order))?;
        if order == 0 {
            continue;
        }
        let entries = Matrix::from_fn(order, order, |i, j| Interval::of(block[(i, j)]));
        let HurwitzAnalysis { spectrum, certificate, .. } = hurwitz(&entries)?;
        require_decay(what, &spectrum, &certificate)?;
        slowest =
            spectrum.first().copied().into_iter().chain(slowest).max_by(|x: &Complex<f64>, y| x.re.total_cmp(&y.re));
        blocks.push((what, certificate));
    }
    let (greatest, growth) = bounded(run, excite.bound)?;
    let (regressors, mismatch) = compare(plant, cascade, run)?;
    let rows: Vec<DMatrix<f64>> = regressors.iter().map(|b| DMatrix::from_row_slice(1, n4, b.as_slice())).collect();
    let excitation = excitation(&run.t, &rows, excite)?;
    Ok(KklPebReport { blocks, slowest, excitation, greatest, growth, mismatch, samples: run.t.len() })
}

fn dynamic<R: Dim, Q: Dim>(m: &OMatrix<f64, R, Q>) -> DMatrix<f64>
where
    DefaultAllocator: nalgebra::allocator::Allocator<R, Q>,
{
    DMatrix::from_column_slice(m.nrows(), m.ncols(), m.as_slice())
}

/// The largest |x_i|, and their growth from the first to the second half.
fn bounded(run: &SampledRun, bound: f64) -> Result<(Vec<f64>, f64), KklError> {
    let half = 0.5 * (run.t[0] + run.t[run.t.len() - 1]);
    let mut most = vec![[0.0f64; 2]; run.x.ncols()];
    for (row, &time) in run.t.iter().enumerate() {
        for (index, most) in most.iter_mut().enumerate() {
            let value = run.x[(row, index)];
            if value.abs() > bound {
                return Err(KklError::Unbounding { what: "x", index, value, time });
            }
            let part = usize::from(time > half);
            most[part] = most[part].max(value.abs());
        }
    }
    let ratio = |[first, second]: &[f64; 2]| if *second > 0.0 { second / first } else { 0.0 };
    let growth = most.iter().map(ratio).fold(0.0, f64::max);
    Ok((most.iter().map(|[first, second]| first.max(*second)).collect(), growth))
}

/// An equation of the class at one sample: its name, by the pieces, by the plant.
type Equation = (String, f64, f64);

/// b at every sample, and the largest relative difference between the pieces and the plant.
fn compare<S, C>(plant: &S, cascade: &C, run: &SampledRun) -> Result<(Vec<DVector<f64>>, f64), KklError>
where
    S: Plant<f64>,
    C: Cascade<f64>,
    DefaultAllocator: CascadeSize<C::Second, C::Third, C::Fourth, C::Inputs, C::Outputs>,
{
    let [n2, n3, n4] = cascade.blocks();
    let (_, p) = cascade.inputs_and_outputs();
    let mut regressors = Vec::with_capacity(run.t.len());
    let mut samples: Vec<Vec<Equation>> = Vec::with_capacity(run.t.len());
    for (row, &time) in run.t.iter().enumerate() {
        let x: Vec<f64> = run.x.row(row).iter().copied().collect();
        let u: Vec<f64> = run.u.row(row).iter().copied().collect();
        let (state, input) = (S::State::from_slice(&x), S::Input::from_slice(&u));
        let (slope, output) = (plant.derivative(time, &state, &input), plant.output(time, &state, &input));
        let (slope, output) = (slope.as_slice(), output.as_slice());
        let y = OVector::from_fn_generic(C::Outputs::from_usize(p), U1, |i, _| x[i]);
        let x2 = OVector::from_fn_generic(C::Second::from_usize(n2), U1, |i, _| x[p + i]);
        let x3 = OVector::from_fn_generic(C::Third::from_usize(n3), U1, |i, _| x[p + n2 + i]);
        let x4 = &x[p + n2 + n3..];
        let u = OVector::from_fn_generic(C::Inputs::from_usize(u.len()), U1, |i, _| u[i]);
        let b: DVector<f64> = DVector::from_iterator(n4, cascade.b(&y, &x2, &x3, &u).iter().copied());
        let seen = cascade.f1k(&y, &x2, &x3, &u) + b.iter().zip(x4).map(|(b, x4)| b * x4).sum::<f64>();
        let second = cascade.a2() * &x2 + cascade.f2(&y, &u);
        let third = cascade.a3() * &x3 + cascade.f3(&y, &x2, &u);
        let fourth = cascade.f4(&y, &x2, &x3, &u);
        let outputs = (0..p).map(|i| (format!("y({})", i + 1), x[i], output[i]));
        let named = |block: usize, start: usize, entries: &[f64]| -> Vec<Equation> {
            let equation = |(i, entry): (usize, &f64)| (format!("x{block}'({})", i + 1), *entry, slope[start + i]);
            entries.iter().enumerate().map(equation).collect()
        };
        let equations: Vec<Equation> = outputs
            .chain([(format!("x1'({})", cascade.k() + 1), seen, slope[cascade.k()])])
            .chain(named(2, p, second.as_slice()))
            .chain(named(3, p + n2, third.as_slice()))
            .chain(named(4, p + n2 + n3, fourth.as_slice()))
            .collect();
        let undefined = equations.iter().any(|(_, piece, plant)| !(piece.is_finite() && plant.is_finite()));
        if undefined || !b.iter().all(|entry| entry.is_finite()) {
            let input = run.u.row(row).iter().copied().collect();
            return Err(KklError::Undefined { operation: "a piece or the plant", state: x, input });
        }
        regressors.push(b);
        samples.push(equations);
    }
    // Every equation by its own size along the run: rounding is a share of it.
    let count = samples.first().map_or(0, Vec::len);
    let mut mismatch = 0.0f64;
    for equation in 0..count {
        let size =
            samples.iter().map(|sample| sample[equation].1.abs().max(sample[equation].2.abs())).fold(0.0, f64::max);
        for (sample, &time) in samples.iter().zip(&run.t) {
            let (name, piece, plant) = &sample[equation];
            let difference = (piece - plant).abs();
            if difference > f64::EPSILON.sqrt() * size {
                return Err(KklError::Mismatch { equation: name.clone(), piece: *piece, plant: *plant, time });
            }
            mismatch = mismatch.max(if difference > 0.0 { difference / size } else { 0.0 });
        }
    }
    Ok((regressors, mismatch))
}

/// Number of windows.
const WINDOWS: usize = 512;

/// The least eigenvalue of `int M'M` over windows of a run with the regressor M(t), each r x q, at the times `t`.
///
/// ```
/// use luenberger_design::kkl_peb::{Excite, excitation};
/// use nalgebra::DMatrix;
/// // M = (sin t, cos t) over half a period: int M'M = (pi/2) I.
/// let t: Vec<f64> = (0..=1000).map(|k| f64::from(k) * 1e-3 * std::f64::consts::PI).collect();
/// let m: Vec<_> = t.iter().map(|t| DMatrix::from_row_slice(1, 2, &[t.sin(), t.cos()])).collect();
/// let found = excitation(&t, &m, &Excite::within(t[1000]))?;
/// assert!((found.delta - 0.5 * std::f64::consts::PI).abs() < 1e-5);
/// # Ok::<(), luenberger_design::KklError>(())
/// ```
/// # Errors
/// [`KklError::NotExciting`] has the delta achieved, the window and the direction that it does not show;
/// [`DesignError::Setting`] for a window that the run does not hold.
pub fn excitation(t: &[f64], regressors: &[DMatrix<f64>], excite: &Excite) -> Result<Excitation, KklError> {
    let b = regressors;
    let Excite { window, needed, .. } = *excite;
    let last = t[t.len() - 1];
    // The windows that the run holds, from a sample to the first one that is T later.
    let ends = |from: usize| t.iter().skip(from).position(|time| time - t[from] >= window).map(|steps| from + steps);
    let starts: Vec<usize> = (0..t.len()).take_while(|&k| last - t[k] >= window).collect();
    let stride = starts.len().div_ceil(WINDOWS).max(1);
    let order = b.first().map_or(0, DMatrix::ncols);
    let gramian = |from: usize, to: usize, step: usize| {
        let mut sum = DMatrix::zeros(order, order);
        let mut k = from;
        while k < to {
            let next = (k + step).min(to);
            let weight = 0.5 * (t[next] - t[k]);
            sum += (b[k].tr_mul(&b[k]) + b[next].tr_mul(&b[next])) * weight;
            k = next;
        }
        sum
    };
    let mut worst: Option<(f64, Vec<f64>, usize, usize)> = None;
    let (mut greatest, mut windows) = (0.0f64, 0);
    // The last one too, whatever the stride.
    let chosen =
        starts.iter().step_by(stride).chain(starts.last().filter(|_| !(starts.len() - 1).is_multiple_of(stride)));
    for &from in chosen {
        let Some(to) = ends(from) else { continue };
        let gram = gramian(from, to, 1);
        windows += 1;
        greatest = greatest.max(gram.trace());
        let (least, direction) = match SymmetricEigen::try_new(gram.clone(), f64::EPSILON, 1000) {
            Some(eigen) => {
                let k = eigen.eigenvalues.imin();
                (eigen.eigenvalues[k], eigen.eigenvectors.column(k).iter().copied().collect())
            }
            None => (lambda_min(&gram)?, Vec::new()),
        };
        if worst.as_ref().is_none_or(|(most, ..)| least < *most) {
            worst = Some((least, direction, from, to));
        }
    }
    let Some((delta, direction, from, to)) = worst else {
        // The window was checked to fit into the run.
        let (least, most) = (f64::MIN_POSITIVE, last - t[0]);
        return Err(DesignError::Setting { what: "the window", value: window, least, most }.into());
    };
    // A sum of `to - from` terms of which none is larger than the trace, and the eigenvalue of a matrix of that size.
    let rounding = (to - from + order) as f64 * f64::EPSILON * greatest;
    if delta <= rounding.max(needed) {
        let needed = rounding.max(needed);
        return Err(KklError::NotExciting { delta, needed, window, from: t[from], direction });
    }
    let coarse = lambda_min(&gramian(from, to, 2))?;
    let quadrature = (coarse - delta).abs() / delta;
    Ok(Excitation { window, delta, from: t[from], direction, greatest, quadrature, windows })
}
