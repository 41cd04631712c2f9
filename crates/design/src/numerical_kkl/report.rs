//! Accuracy of the observer: errors at validation points.

use std::fmt;

use luenberger_observers::Observer;
use luenberger_plants::Plant;
use nalgebra::SVector;

use crate::check::within;
use crate::number::short;
use crate::numerical_kkl::domain::Domain;
use crate::numerical_kkl::error::NumericalKklError;
use crate::numerical_kkl::extrapolation::{Extrapolation, Halt};
use crate::numerical_kkl::injectivity::Injectivity;

/// Root mean square and largest size of an error, per state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors<const N: usize> {
    /// Root mean square per state; NaN if there is no sample.
    pub rmse: SVector<f64, N>,
    /// Largest size per state.
    pub max: SVector<f64, N>,
    /// Samples.
    pub samples: usize,
}

impl<const N: usize> Errors<N> {
    /// Of these errors.
    pub(crate) fn of(errors: impl Iterator<Item = SVector<f64, N>>) -> Self {
        let (mut squares, mut max, mut samples) = (SVector::<f64, N>::zeros(), SVector::<f64, N>::zeros(), 0);
        for error in errors {
            squares += error.component_mul(&error);
            max = max.zip_map(&error, |max, e| if e.abs() > max || e.is_nan() { e.abs() } else { max });
            samples += 1;
        }
        Self { rmse: squares.map(|sum| (sum / samples as f64).sqrt()), max, samples }
    }
}

/// A validation trajectory, not used in the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial<const N: usize> {
    /// Where the plant begins. The observer begins at z = 0, whatever the plant.
    pub start: [f64; N],
    /// The time before which errors are the transient's, and not counted.
    pub transient: f64,
    /// The time at which it ends.
    pub end: f64,
    /// Samples from `transient` to `end`, both included.
    pub samples: usize,
}

/// Errors along trials, those at states inside the box apart from those outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValidationErrors<const N: usize> {
    /// At states in the box.
    pub inside: Errors<N>,
    /// At states outside, where no estimate can be right: estimates stay in the box.
    pub outside: Errors<N>,
}

/// Runs plant and observer side by side, from z(0) = 0, and compares after the transient.
///
/// The field is the plant's own, not the slowed one. Costs one integration over `end` per trial.
///
/// # Errors
/// [`DesignError::Setting`](crate::DesignError::Setting) for the times and the number of samples;
/// [`NumericalKklError::Escapes`], [`NumericalKklError::Stalled`],
/// [`NumericalKklError::NotFinite`] where the plant cannot be followed *forward*.
pub fn held_out<S, O, const N: usize, const M: usize, const P: usize, const Z: usize>(
    plant: &S,
    observer: &O,
    domain: &Domain<N>,
    input: &SVector<f64, M>,
    trials: &[Trial<N>],
) -> Result<ValidationErrors<N>, NumericalKklError>
where
    S: Plant<f64, State = SVector<f64, N>, Input = SVector<f64, M>, Output = SVector<f64, P>>,
    O: Observer<
            f64,
            State = SVector<f64, Z>,
            Input = SVector<f64, M>,
            Output = SVector<f64, P>,
            Estimate = SVector<f64, N>,
        >,
{
    let (mut inside, mut outside) = (Vec::new(), Vec::new());
    for trial in trials {
        within("the end of a trial", trial.end, f64::MIN_POSITIVE, 1e6)?;
        within("the transient of a trial", trial.transient, 0.0, trial.end)?;
        within("the samples of a trial", trial.samples as f64, 2.0, 1e6)?;
        let mut state = vec![0.0; N + Z];
        state[..N].copy_from_slice(&trial.start);
        let mut scale = vec![1.0; N + Z];
        scale[..N].copy_from_slice(domain.half_width().as_slice());
        let mut stacked = |state: &[f64], slope: &mut [f64]| {
            let x = SVector::<f64, N>::from_column_slice(&state[..N]);
            let z = SVector::<f64, Z>::from_column_slice(&state[N..]);
            slope[..N].copy_from_slice(plant.derivative(0.0, &x, input).as_slice());
            let y = plant.output(0.0, &x, input);
            slope[N..].copy_from_slice(observer.derivative(0.0, &z, input, &y).as_slice());
        };
        let mut method = Extrapolation::new(N + Z, 1e-12);
        let step = (trial.end - trial.transient) / (trial.samples - 1) as f64;
        let from = || trial.start.to_vec();
        for sample in 0..trial.samples {
            let span = if sample == 0 { trial.transient } else { step };
            if span > 0.0 {
                method.advance(&mut stacked, span, &mut state, &scale, N).map_err(|halt| match halt {
                    Halt::NotFinite => NumericalKklError::NotFinite { from: from(), time: 0.0 },
                    Halt::Escape { time, norm } => NumericalKklError::Escapes { from: from(), time, norm },
                    Halt::Stall { time, step, steps } => NumericalKklError::Stalled { from: from(), time, step, steps },
                })?;
            }
            let x = SVector::<f64, N>::from_column_slice(&state[..N]);
            let z = SVector::<f64, Z>::from_column_slice(&state[N..]);
            let error = x - observer.estimate(0.0, &z, input, &plant.output(0.0, &x, input));
            if domain.contains(&x) { inside.push(error) } else { outside.push(error) }
        }
    }
    Ok(ValidationErrors { inside: Errors::of(inside.into_iter()), outside: Errors::of(outside.into_iter()) })
}

/// Cost of one form of the left inverse on the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Footprint {
    /// Numbers stored, those of [`Coordinates`](crate::numerical_kkl::Coordinates) included; what only `initial` needs
    /// is not.
    pub numbers: usize,
    /// Bytes of them in single precision, with four bytes for the axis and the branches of each comparison.
    pub bytes_f32: usize,
    /// Multiply-adds per estimate, at most.
    pub multiply_adds: usize,
    /// Comparisons per estimate, at most.
    pub comparisons: usize,
}

/// The evidence that comes with a numerical KKL design. All errors are at points that were not fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report<const N: usize> {
    /// How far back T looks.
    pub horizon: f64,
    /// Trajectories backward in time that the table of T took.
    pub trajectories: usize,
    /// Error of the interpolated T at the held-out points, in the coordinates in which T(box) is about one wide: root
    /// mean square and largest.
    pub spline: (f64, f64),
    /// `DT f - D T - B h` of the interpolated T at the held-out points, relative to the largest `|B h|`: root mean
    /// square and largest.
    pub residual: (f64, f64),
    /// The same of T by simulation, largest at a few of the points: the accuracy of the simulation itself.
    pub simulated_residual: f64,
    /// How well T separates the states.
    pub injectivity: Injectivity<N>,
    /// `x - T^-L(T(x))` of the embedded form.
    pub embedded: Errors<N>,
    /// `x - T^-L(T(x))` of the interpolated form.
    pub interpolated: Errors<N>,
    /// Evaluations of T that the interpolated form needed per estimate, at those points: mean and largest.
    pub evaluations: (f64, usize),
    /// Cost of the embedded form.
    pub embedded_footprint: Footprint,
    /// Cost of the interpolated form.
    pub interpolated_footprint: Footprint,
}

/// The entries with three digits.
fn list<const N: usize>(v: &SVector<f64, N>) -> String {
    v.iter().map(|x| short(*x)).collect::<Vec<_>>().join(", ")
}

/// What `form` of the left inverse misses over the box.
pub(super) fn write_errors<const N: usize>(f: &mut fmt::Formatter<'_>, form: &str, errors: &Errors<N>) -> fmt::Result {
    writeln!(f, "{form:<12} rmse over the box  {}", list(&errors.rmse))?;
    writeln!(f, "{:<12} max                {}", "", list(&errors.max))
}

impl<const N: usize> fmt::Display for Report<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let i = &self.injectivity;
        writeln!(f, "memory                         {:.2}", self.horizon)?;
        writeln!(f, "trajectories of the table      {}", self.trajectories)?;
        writeln!(f, "spline of T, rms and max       {}, {}", short(self.spline.0), short(self.spline.1))?;
        writeln!(f, "DT f - D T - B h, rms and max  {}, {}", short(self.residual.0), short(self.residual.1))?;
        writeln!(f, "  by simulation, max           {}", short(self.simulated_residual))?;
        writeln!(f, "|T(x) - T(x')| / |x - x'|      {} to {}", short(i.smallest_ratio), short(i.largest_ratio))?;
        writeln!(f, "smallest singular value of DT  {} at ({})", short(i.smallest_singular_value), list(&i.flattest))?;
        for (name, errors, cost) in [
            ("embedded", &self.embedded, &self.embedded_footprint),
            ("interpolated", &self.interpolated, &self.interpolated_footprint),
        ] {
            write_errors(f, name, errors)?;
            writeln!(
                f,
                "{:<12} costs              {} numbers ({} bytes in f32), {} multiply-adds, {} comparisons",
                "", cost.numbers, cost.bytes_f32, cost.multiply_adds, cost.comparisons
            )?;
        }
        let (mean, most) = self.evaluations;
        writeln!(f, "{:<12} evaluations of T   {mean:.1} per estimate, at most {most}", "")
    }
}
