//! The two examples and their sixteen runs: plants, initial states, and the observer as printed.
//!
//! The following reading reproduces the text: g = Df(c) with c built from the internal e, alpha_k the sum of row and
//! column k of |g| (the diagonal counted twice), e1 the measured errors in the first p rows and the internal ones in
//! the rest, one beta for each row.
//!
//! Example 2 is run on the plant with `a44 = 0` and the printed `C = [I3 0]`: the reading that only corrects its
//! misprint. Two variants are named separately: the classical benchmark with its own `C = [I2 0]`, and `a44 = 3.33` as
//! printed.
//!
//! A run is written as `data/mvt-<system>-eta<1|2>-<e0|e01>.csv` with the columns `t`, `x1..xn`, `x1_hat..xn_hat`,
//! `e1..en`, `beta1..betan`. Here e is the observer's *internal* error; the real one is x - x_hat. States and errors
//! are accurate to 1e-8. beta is as accurate as X determines it, a few units of rounding of f divided by the curvature
//! of f along e: where `X(1/2)` is at rounding level it is 1/2, which is always the case once the internal error is
//! below about 1e-4.

use std::sync::Arc;

use luenberger_observers::mean_value::beta::mean_value;
use luenberger_observers::{Beta, Integral, Mean, MeanValueObserver};
use luenberger_plants::{Chaotic, Differentiable, flexible_joint};
use luenberger_sim::{Scenario, Signal, SimError, Trajectory};
use nalgebra::{Const, DMatrix, SMatrix, SVector};

use crate::claim::CheckError;
use crate::context::Context;
use crate::paper::Dataset;
use crate::table::Table;
use crate::value::Value;

/// The plants of the examples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum System {
    /// Example 1.
    Chaotic,
    /// Example 2 with its misprint corrected: `a44 = 0`, three outputs as printed.
    Corrected,
    /// A variant, the benchmark's own outputs: `a44 = 0`, two outputs.
    Classical,
    /// A variant, the misprint kept: `a44 = 3.33`, three outputs.
    Printed,
}

/// The information about `x(0) - xhat(0)` given to the observer by its e(0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Given {
    /// The paper's e0, which is `x(0) - xhat(0)`.
    E0,
    /// The paper's e01, which is off in its last entry.
    E01,
}

/// The initial state of an experiment.
pub(super) struct Start {
    pub(super) x: &'static [f64],
    pub(super) xhat: &'static [f64],
    pub(super) e0: &'static [f64],
    pub(super) e01: &'static [f64],
}

const CHAOTIC: Start =
    Start { x: &[-2.0, -1.0, -1.0], xhat: &[-1.0, -0.5, -1.5], e0: &[-1.0, -0.5, 0.5], e01: &[-1.0, -0.5, 0.2] };
const JOINT: Start = Start {
    x: &[3.0, 3.0, 3.0, 3.0],
    xhat: &[1.0, 2.0, 0.5, 1.0],
    e0: &[2.0, 1.0, 2.5, 2.0],
    e01: &[2.0, 1.0, 2.5, 2.5],
};

impl System {
    pub(super) const ALL: [Self; 4] = [Self::Chaotic, Self::Corrected, Self::Classical, Self::Printed];
    /// The plants of Example 2, that of the claims first.
    pub(super) const JOINTS: [Self; 3] = [Self::Corrected, Self::Classical, Self::Printed];

    pub(super) fn start(self) -> &'static Start {
        match self {
            Self::Chaotic => &CHAOTIC,
            _ => &JOINT,
        }
    }

    pub(super) fn states(self) -> usize {
        self.start().x.len()
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Chaotic => "Example 1",
            Self::Corrected => "Example 2",
            Self::Classical => "Example 2, variant with the classical outputs",
            Self::Printed => "Example 2, variant with a44 as printed",
        }
    }

    /// The name in columns of data.
    pub(super) fn key(self) -> &'static str {
        match self {
            Self::Chaotic => "ex1",
            Self::Corrected => "ex2",
            Self::Classical => "classical",
            Self::Printed => "printed",
        }
    }

    /// How many of the states are measured.
    pub(super) fn outputs(self) -> usize {
        match self {
            Self::Chaotic | Self::Classical => 2,
            Self::Corrected | Self::Printed => 3,
        }
    }

    /// The horizon; the paper prints none. With a44 as printed the plant of Example 2 is unstable.
    pub(super) fn end(self) -> f64 {
        if self == Self::Printed { 2.0 } else { 10.0 }
    }

    /// Times from 0 to `end`: every 2 ms in the first second, every 10 ms after it, as exact as decimals are.
    fn times(end: f64) -> Vec<f64> {
        let first = (0..500).map(|k| f64::from(k) / 500.0);
        let rest = (100..).map(|k| f64::from(k) / 100.0).take_while(|&t| t <= end);
        first.chain(rest).collect()
    }
}

/// The horizons at which "converges" and "settles" are judged, in seconds, the same for every claim of the examples:
/// the paper prints none. 10 s is that of its figures as far as they can be told; the other is ten times as long.
pub(super) const HORIZONS: [(&str, f64); 2] = [("by T = 10 s", 10.0), ("by T = 100 s", 100.0)];

/// The share of its start below which an error counts as gone.
pub(super) const GONE: f64 = 0.05;

/// Whether an error at these times is below [`GONE`] of its start from some time before each horizon on, and from when
/// at the last; infinite if it is not.
pub(super) fn gone_by(t: &[f64], sizes: &[f64]) -> (Vec<(&'static str, Value)>, f64) {
    let from = |end: f64| {
        let until = t.iter().take_while(|&&t| t <= end).count();
        let last = sizes[..until].iter().rposition(|size| *size > GONE * sizes[0]);
        last.map_or(0.0, |k| if k + 1 < until { t[k + 1] } else { f64::INFINITY })
    };
    let truths = HORIZONS.map(|(name, end)| (name, Value::Truth(from(end).is_finite())));
    (truths.to_vec(), from(HORIZONS[1].1))
}

/// Every 10 ms in the first 10 s, every tenth of a second to the last horizon.
pub(super) fn long_times() -> Vec<f64> {
    (0..1000).map(|k| f64::from(k) / 100.0).chain((100..=1000).map(|k| f64::from(k) / 10.0)).collect()
}

/// One of the sixteen runs.
struct Case {
    id: &'static str,
    system: System,
    eta: f64,
    given: Given,
}

const fn case(id: &'static str, system: System, eta: f64, given: Given) -> Case {
    Case { id, system, eta, given }
}

const CASES: [Case; 16] = [
    case("mvt-ex1-eta1-e0", System::Chaotic, 1.0, Given::E0),
    case("mvt-ex1-eta1-e01", System::Chaotic, 1.0, Given::E01),
    case("mvt-ex1-eta2-e0", System::Chaotic, 2.0, Given::E0),
    case("mvt-ex1-eta2-e01", System::Chaotic, 2.0, Given::E01),
    case("mvt-ex2-eta1-e0", System::Corrected, 1.0, Given::E0),
    case("mvt-ex2-eta1-e01", System::Corrected, 1.0, Given::E01),
    case("mvt-ex2-eta2-e0", System::Corrected, 2.0, Given::E0),
    case("mvt-ex2-eta2-e01", System::Corrected, 2.0, Given::E01),
    case("mvt-ex2-classical-eta1-e0", System::Classical, 1.0, Given::E0),
    case("mvt-ex2-classical-eta1-e01", System::Classical, 1.0, Given::E01),
    case("mvt-ex2-classical-eta2-e0", System::Classical, 2.0, Given::E0),
    case("mvt-ex2-classical-eta2-e01", System::Classical, 2.0, Given::E01),
    case("mvt-ex2-printed-eta1-e0", System::Printed, 1.0, Given::E0),
    case("mvt-ex2-printed-eta1-e01", System::Printed, 1.0, Given::E01),
    case("mvt-ex2-printed-eta2-e0", System::Printed, 2.0, Given::E0),
    case("mvt-ex2-printed-eta2-e01", System::Printed, 2.0, Given::E01),
];

/// A run with the mean value theorem along it. Matrices have one row per time.
pub(super) struct Run {
    pub(super) trajectory: Trajectory,
    /// beta_i in [0, 1].
    pub(super) beta: DMatrix<f64>,
    /// `X_i(beta_i)`.
    pub(super) residual: DMatrix<f64>,
    /// The size of the terms of X_i: `|f_i(xhat)| + |f_i(xhat + e)|`.
    pub(super) terms: DMatrix<f64>,
}

/// The run of that system, eta and e(0), computed once.
pub(super) fn run(context: &Context, system: System, eta: f64, given: Given) -> Result<Arc<Run>, CheckError> {
    let case = CASES
        .iter()
        .find(|case| (case.system, case.given) == (system, given) && case.eta.total_cmp(&eta).is_eq())
        .ok_or("no such run")?;
    context.once(case.id, || {
        let start = system.start();
        let e0 = if given == Given::E0 { start.e0 } else { start.e01 };
        let experiment =
            Experiment { eta, e0, mean: Theorem::Beta, l: None, times: System::times(system.end()), rtol: FINE };
        let trajectory = experiment.on(system)?;
        match system {
            System::Chaotic => along(&Chaotic, trajectory),
            System::Corrected => along(&flexible_joint::corrected(), trajectory),
            System::Classical => along(&flexible_joint::classical(), trajectory),
            System::Printed => along(&flexible_joint::printed(), trajectory),
        }
    })
}

/// Relative tolerance of the runs whose numbers are printed: with it, halving the exponent or another integrator
/// changes no number of theirs by 1e-9.
pub(super) const FINE: f64 = 1e-13;

/// Which mean of the Jacobian an experiment uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Theorem {
    /// The paper's: one beta for each row.
    Beta,
    /// The integral mean.
    Integral,
}

/// One run of the observer, as printed or with output injection, from the initial state of an example.
pub(super) struct Experiment<'a> {
    pub(super) eta: f64,
    /// e(0), the internal error at the start.
    pub(super) e0: &'a [f64],
    pub(super) mean: Theorem,
    /// The gain of the output injection, none as printed.
    pub(super) l: Option<&'a DMatrix<f64>>,
    pub(super) times: Vec<f64>,
    pub(super) rtol: f64,
}

impl Experiment<'_> {
    /// The run.
    pub(super) fn on(self, system: System) -> Result<Trajectory, CheckError> {
        let start = system.start();
        match system {
            System::Chaotic => self.from(Chaotic, start.x, start.xhat),
            System::Corrected => self.from(flexible_joint::corrected(), start.x, start.xhat),
            System::Classical => self.from(flexible_joint::classical(), start.x, start.xhat),
            System::Printed => self.from(flexible_joint::printed(), start.x, start.xhat),
        }
    }

    /// The run on any plant, with u = sin t in every input.
    pub(super) fn from<S, const N: usize, const M: usize, const P: usize>(
        self,
        plant: S,
        x: &[f64],
        xhat: &[f64],
    ) -> Result<Trajectory, CheckError>
    where
        S: Differentiable<f64, Const<N>, Const<M>, Const<P>> + Clone + Send + Sync,
    {
        match self.mean {
            Theorem::Beta => self.with(Beta, plant, x, xhat),
            Theorem::Integral => self.with(Integral, plant, x, xhat),
        }
    }

    fn with<D, S, const N: usize, const M: usize, const P: usize>(
        self,
        mean: D,
        plant: S,
        x: &[f64],
        xhat: &[f64],
    ) -> Result<Trajectory, CheckError>
    where
        S: Differentiable<f64, Const<N>, Const<M>, Const<P>> + Clone + Send + Sync,
        D: Mean<S, f64, Const<N>, Const<M>, Const<P>> + Send + Sync,
    {
        let e0 = column::<N>(self.e0)?;
        let observer = match self.l {
            None => MeanValueObserver::new(plant.clone(), self.eta, mean, e0)?,
            Some(l) => MeanValueObserver::with_output_injection(plant.clone(), self.eta, mean, e0, fixed::<N, P>(l)?)?,
        };
        Ok(Scenario::new(plant)
            .initial_state(x)
            .input(Signal::scalar(f64::sin))
            .observer(OBSERVER, observer, xhat)
            .times(&self.times)
            .tolerances(self.rtol, self.rtol / 10.0)
            .run()?)
    }
}

/// The name of the observer in these runs.
pub(super) const OBSERVER: &str = "mean value";

/// A vector of static length.
pub(super) fn column<const N: usize>(entries: &[f64]) -> Result<SVector<f64, N>, CheckError> {
    if entries.len() == N { Ok(SVector::from_column_slice(entries)) } else { Err("a vector of another length".into()) }
}

/// A gain of static size.
pub(super) fn fixed<const N: usize, const P: usize>(l: &DMatrix<f64>) -> Result<SMatrix<f64, N, P>, CheckError> {
    if l.shape() == (N, P) {
        Ok(SMatrix::from_column_slice(l.as_slice()))
    } else {
        Err(format!("a gain of {} x {} for {N} states and {P} outputs", l.nrows(), l.ncols()).into())
    }
}

/// The mean value theorem along a run.
pub(super) fn along<S, const N: usize, const M: usize, const P: usize>(
    plant: &S,
    trajectory: Trajectory,
) -> Result<Run, CheckError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
{
    let samples = trajectory.t.len();
    let [mut beta, mut residual, mut terms] = [(); 3].map(|()| DMatrix::zeros(samples, N));
    let state = &trajectory.observer(OBSERVER)?.state;
    for (k, &t) in trajectory.t.iter().enumerate() {
        let xhat = SVector::<f64, N>::from_fn(|i, _| state[(k, i)]);
        let e = SVector::<f64, N>::from_fn(|i, _| state[(k, N + i)]);
        let u = SVector::<f64, M>::from_fn(|i, _| trajectory.u[(k, i)]);
        let mean = mean_value(plant, t, &xhat, &u, &e);
        let size = plant.derivative(t, &xhat, &u).abs() + plant.derivative(t, &(xhat + e), &u).abs();
        beta.set_row(k, &mean.beta.transpose());
        residual.set_row(k, &mean.residual.transpose());
        terms.set_row(k, &size.transpose());
    }
    Ok(Run { trajectory, beta, residual, terms })
}

/// x - xhat of a run: the real error.
pub(super) fn real(trajectory: &Trajectory) -> Result<&DMatrix<f64>, SimError> {
    Ok(&trajectory.observer(OBSERVER)?.error)
}

/// e of a run: the internal error.
pub(super) fn internal(trajectory: &Trajectory) -> Result<DMatrix<f64>, SimError> {
    let n = trajectory.x.ncols();
    Ok(trajectory.observer(OBSERVER)?.state.columns(n, n).into_owned())
}

/// `x - xhat - e`: the part of the error that is unknown to the observer.
pub(super) fn not_given(trajectory: &Trajectory) -> Result<DMatrix<f64>, SimError> {
    Ok(real(trajectory)? - internal(trajectory)?)
}

/// The norm of each row.
pub(super) fn norms(rows: &DMatrix<f64>) -> Vec<f64> {
    rows.row_iter().map(|row| row.norm()).collect()
}

/// The last entry.
pub(super) fn last(values: &[f64]) -> f64 {
    values.last().copied().unwrap_or(f64::NAN)
}

pub(super) fn datasets() -> Vec<Dataset> {
    CASES.iter().map(|case| Dataset { id: case.id, tabulate: table }).collect()
}

fn table(context: &Context, id: &str) -> Result<Table, CheckError> {
    let case = CASES.iter().find(|case| case.id == id).ok_or("no such run")?;
    let run = run(context, case.system, case.eta, case.given)?;
    let (trajectory, e) = (&run.trajectory, internal(&run.trajectory)?);
    let estimate = &trajectory.observer(OBSERVER)?.estimate;
    let mut table = Table::new().column("t", trajectory.t.clone());
    for (values, before, after) in
        [(&trajectory.x, "x", ""), (estimate, "x", "_hat"), (&e, "e", ""), (&run.beta, "beta", "")]
    {
        for (i, column) in values.column_iter().enumerate() {
            table = table.column(format!("{before}{}{after}", i + 1), column.iter().copied().collect::<Vec<_>>());
        }
    }
    Ok(table)
}

/// X of (11) at each of `betas`, the same beta in every row: n x number of betas.
pub(super) fn residuals<S, const N: usize, const M: usize, const P: usize>(
    plant: &S,
    t: f64,
    xhat: &SVector<f64, N>,
    u: &SVector<f64, M>,
    e: &SVector<f64, N>,
    betas: &[f64],
) -> DMatrix<f64>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
{
    let rise = plant.derivative(t, &(xhat + e), u) - plant.derivative(t, xhat, u);
    let mut x = DMatrix::zeros(N, betas.len());
    for (mut column, &beta) in x.column_iter_mut().zip(betas) {
        column.copy_from(&(rise - plant.directional(t, &(xhat + e * beta), u, e).1));
    }
    x
}

/// `count` numbers from 0 to 1.
pub(super) fn unit_interval(count: usize) -> Vec<f64> {
    (0..count).map(|k| k as f64 / (count - 1) as f64).collect()
}

/// Whether every beta is in [0, 1] and every `X(beta)` is rounding, and the largest `|X_i|`.
///
/// X is the difference of two values of f and a slope of the same size: three roundings of sums of up to four terms,
/// each below 16 epsilon of them.
pub(super) fn beta_solves(run: &Run) -> (bool, f64) {
    let inside = run.beta.iter().all(|beta| (0.0..=1.0).contains(beta));
    let largest_term = run.terms.amax();
    let solved = run.residual.iter().all(|x| x.abs() <= 16.0 * f64::EPSILON * largest_term);
    (inside && solved, run.residual.amax())
}
