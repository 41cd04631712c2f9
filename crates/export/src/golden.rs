//! Golden vectors: inputs, outputs and the estimates of the Rust observer, in the format of the target.

use luenberger_observers::{Innovation, SampledObserver, StationaryKalmanFilter};
use nalgebra::{DMatrix, DVector, Dyn, RealField};

use crate::Export;
use crate::cast::Cast;
use crate::error::ExportError;
use crate::exportable_observer::ExportableObserver;
use crate::scalar::Scalar;

/// Steps of the golden vectors by default.
pub const STEPS: usize = 64;

/// One step: what goes in, and the estimate that comes out.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Inputs; with feedback the references r.
    pub u: Vec<f64>,
    /// Outputs.
    pub y: Vec<f64>,
    /// The estimate for the next sample; in filter form that at this sample.
    pub estimate: Vec<f64>,
    /// With feedback, the input `r - K xhat` that the step computes and applies; empty without.
    pub applied: Vec<f64>,
}

/// `count` steps from the first estimate, with inputs and outputs that are numbers of the format.
///
/// Those of a linear plant have a magnitude up to 2, and a few are large. They are no motion of the plant: every
/// operation gets numbers without pattern. Those of a nonlinear plant are the [samples](Export::samples) of the export,
/// from the first to the last, back to the first, and so on; without samples, inputs up to 0.1, and the outputs that
/// the estimate predicts with as much noise.
///
/// With feedback the outputs of a linear plant are those of the loop plus such numbers, because an observer with its
/// feedback may be unstable where the loop is stable. For a nonlinear plant r is such that u is that of the samples.
///
/// # Errors
/// [`ExportError::NotFinite`] if the estimate leaves the range of the format.
pub fn steps(export: &Export, count: usize) -> Result<Vec<Step>, ExportError> {
    match export.scalar {
        Scalar::Binary32 => run::<f32>(export, count),
        Scalar::Binary64 => run::<f64>(export, count),
    }
}

/// The estimates of the exported observer for given inputs and outputs, one pair for each sample, which are rounded to
/// the format.
///
/// # Errors
/// [`ExportError::Rounded`] if the rounded gains are refused.
pub fn replay(export: &Export, samples: &[(Vec<f64>, Vec<f64>)]) -> Result<Vec<Vec<f64>>, ExportError> {
    match export.scalar {
        Scalar::Binary32 => replay_in::<f32>(export, samples),
        Scalar::Binary64 => replay_in::<f64>(export, samples),
    }
}

fn replay_in<T: RealField + Copy>(
    export: &Export,
    samples: &[(Vec<f64>, Vec<f64>)],
) -> Result<Vec<Vec<f64>>, ExportError> {
    let mut run = Run::<T>::new(export)?;
    Ok(samples.iter().map(|(u, y)| run.step(&run.rounded(u), &run.rounded(y))).collect())
}

/// An exported observer that is stepped sample by sample: the numbers that the emitted code computes.
///
/// ```
/// use luenberger_export::{Export, Names, ExportableObserver, Scalar, golden::Stepper};
/// use luenberger_observers::DiscreteLinearObserver;
/// use luenberger_plants::LinearPlant;
/// use nalgebra::dmatrix;
/// let plant = LinearPlant::new(dmatrix![0.5], dmatrix![1.0], dmatrix![1.0])?;
/// let observer = DiscreteLinearObserver::new(plant, dmatrix![0.25], 0.1)?;
/// let column = |name: &str| vec![name.to_owned()];
/// let names = Names { states: column("x"), inputs: column("u"), outputs: column("y"), ..Names::default() };
/// let export = Export::new("filter", ExportableObserver::Linear(observer), Scalar::Binary64, &[0.0], names)?;
/// let mut stepper = Stepper::new(&export)?;
/// assert_eq!(stepper.step(&[1.0], &[2.0]), [1.5]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Stepper(Formatted);

#[derive(Debug, Clone)]
enum Formatted {
    Binary32(Box<Run<f32>>),
    Binary64(Box<Run<f64>>),
}

/// The same in either format.
macro_rules! of {
    ($formatted:expr, $run:ident => $what:expr) => {
        match $formatted {
            Formatted::Binary32($run) => $what,
            Formatted::Binary64($run) => $what,
        }
    };
}

impl Stepper {
    /// At the first estimate of the export.
    ///
    /// # Errors
    /// [`ExportError::Rounded`] if the rounded gains are refused.
    pub fn new(export: &Export) -> Result<Self, ExportError> {
        Ok(Self(match export.scalar {
            Scalar::Binary32 => Formatted::Binary32(Box::new(Run::new(export)?)),
            Scalar::Binary64 => Formatted::Binary64(Box::new(Run::new(export)?)),
        }))
    }

    /// The estimate for the next sample, from the input and the output of this one (m and p entries).
    pub fn step(&mut self, u: &[f64], y: &[f64]) -> Vec<f64> {
        of!(&mut self.0, run => run.step(&run.rounded(u), &run.rounded(y)))
    }

    /// The estimate for the next sample; after an [`update`](Self::update), that with the measurement.
    pub fn estimate(&self) -> Vec<f64> {
        of!(&self.0, run => numbers(&run.estimate()))
    }

    /// Whether it is a filter with a covariance, whose step is [`update`](Self::update) and [`predict`](Self::predict).
    pub fn is_filter(&self) -> bool {
        of!(&self.0, run => run.observer.halves().is_some())
    }

    /// The covariance of the error of the [estimate](Self::estimate), n x n, of a filter.
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        of!(&self.0, run => run.observer.halves().map(|halves| halves.covariance(&run.state).map(number)))
    }

    /// The update of a filter by the outputs of this sample that are finite; repeated, by those of further sensors at
    /// the same time. Returns false, with the estimate as it was, if it is passed over, and for an observer without a
    /// covariance.
    pub fn update(&mut self, u: &[f64], y: &[f64]) -> bool {
        of!(&mut self.0, run => run.update(&run.rounded(u), &run.rounded(y)))
    }

    /// The prediction of a filter for the next sample. Returns false, with the estimate as it was, if it has no result,
    /// and for an observer without a covariance.
    pub fn predict(&mut self, u: &[f64]) -> bool {
        of!(&mut self.0, run => run.predict(&run.rounded(u)))
    }

    /// Its state, and how many samples it has had: [`resume`](Self::resume) goes on from there.
    pub fn position(&self) -> (Vec<f64>, usize) {
        of!(&self.0, run => (numbers(&run.state), run.sample))
    }

    /// Goes on from the position of another stepper of the same export. False, and nothing changes, if its state has
    /// another length.
    pub fn resume(&mut self, state: &[f64], sample: usize) -> bool {
        of!(&mut self.0, run => {
            let fits = state.len() == run.state.len();
            if fits {
                (run.state, run.sample, run.last) = (convert(state), sample, None);
            }
            fits
        })
    }

    /// The innovation of the last sample of a filter, with its covariance, and how many outputs it used: that of the
    /// last [`step`](Self::step) or [`update`](Self::update). None before the first one, and where it was passed over.
    pub fn innovation(&self) -> Option<(Innovation<f64, Dyn>, usize)> {
        of!(&self.0, run => {
            let (innovation, used) = run.innovation()?;
            let value = innovation.value.map(number);
            let covariance = innovation.covariance.map(number);
            let normalized_square = number(innovation.normalized_square);
            Some((Innovation { value, covariance, normalized_square }, used))
        })
    }
}

/// What an update of a filter was made of.
#[derive(Debug, Clone)]
struct Measured<T> {
    sample: usize,
    /// The state before it.
    state: DVector<T>,
    u: DVector<T>,
    y: DVector<T>,
}

/// An observer on its way.
#[derive(Debug, Clone)]
struct Run<T: RealField + Copy> {
    scalar: Scalar,
    observer: Cast<T>,
    /// In filter form.
    filter: Option<StationaryKalmanFilter<T, Dyn, Dyn, Dyn>>,
    state: DVector<T>,
    sample: usize,
    /// The last update of a filter.
    last: Option<Measured<T>>,
}

fn convert<T: RealField + Copy>(values: &[f64]) -> DVector<T> {
    DVector::from_iterator(values.len(), values.iter().map(|x| nalgebra::convert(*x)))
}

fn number<T: RealField + Copy>(x: T) -> f64 {
    nalgebra::try_convert(x).unwrap_or(f64::NAN)
}

fn numbers<T: RealField + Copy>(column: &DVector<T>) -> Vec<f64> {
    column.iter().map(|x| number(*x)).collect()
}

impl<T: RealField + Copy> Run<T> {
    fn new(export: &Export) -> Result<Self, ExportError> {
        let scalar = export.scalar;
        let rounded = |error| ExportError::Rounded { format: scalar.name(), error };
        let observer = export.observer.cast::<T>().map_err(rounded)?;
        let filter = match (&export.observer, &export.update) {
            (ExportableObserver::Linear(predictor), Some(k)) => {
                let k = k.map(|x| nalgebra::convert::<f64, T>(scalar.round(x)));
                let predictor = predictor.cast().map_err(rounded)?;
                Some(StationaryKalmanFilter::new(predictor, k).map_err(rounded)?)
            }
            _ => None,
        };
        let state = observer.start(&convert(&export.initial));
        Ok(Self { scalar, observer, filter, state, sample: 0, last: None })
    }

    fn rounded(&self, column: &[f64]) -> Vec<f64> {
        column.iter().map(|x| self.scalar.round(*x)).collect()
    }

    fn estimate(&self) -> DVector<T> {
        self.observer.estimate(&self.state)
    }

    /// The output that the estimate predicts, of a nonlinear plant.
    fn output(&self, u: &[f64]) -> Option<Vec<f64>> {
        self.observer.output(self.sample, &self.state, &convert(u)).map(|y| numbers(&y))
    }

    /// The estimate after a sample; in filter form that at the sample.
    fn step(&mut self, u: &[f64], y: &[f64]) -> Vec<f64> {
        let (u, y) = (convert(u), convert(y));
        let corrected = self.filter.as_ref().map(|filter| filter.estimate_at(&self.estimate(), &u, &y));
        self.remember(&u, &y);
        self.observer.step(self.sample, &mut self.state, &u, &y);
        self.sample += 1;
        numbers(&corrected.unwrap_or_else(|| self.estimate()))
    }

    /// Keeps what an update of a filter is made of.
    fn remember(&mut self, u: &DVector<T>, y: &DVector<T>) {
        self.last = self.observer.halves().map(|_| Measured {
            sample: self.sample,
            state: self.state.clone(),
            u: u.clone(),
            y: y.clone(),
        });
    }

    fn update(&mut self, u: &[f64], y: &[f64]) -> bool {
        let (u, y) = (convert(u), convert(y));
        self.remember(&u, &y);
        let halves = self.observer.halves();
        halves.is_some_and(|halves| halves.update(self.observer.time(self.sample), &mut self.state, &u, &y).is_some())
    }

    fn predict(&mut self, u: &[f64]) -> bool {
        let halves = self.observer.halves();
        let is_right =
            halves.is_some_and(|halves| halves.predict(self.observer.time(self.sample), &mut self.state, &convert(u)));
        self.sample += usize::from(is_right);
        is_right
    }

    fn innovation(&self) -> Option<(Innovation<T, Dyn>, usize)> {
        let Measured { sample, state, u, y } = self.last.as_ref()?;
        let (halves, t) = (self.observer.halves()?, self.observer.time(*sample));
        let innovation = halves.update(t, &mut state.clone(), u, y)?;
        Some((innovation, halves.used(t, state, u, y)))
    }
}

fn run<T: RealField + Copy>(export: &Export, count: usize) -> Result<Vec<Step>, ExportError> {
    let (scalar, size) = (export.scalar, export.observer.dimensions());
    let is_nonlinear = export.observer.maps().is_some();
    let recorded = if is_nonlinear { &export.samples[..] } else { &[] };
    let mut run = Run::<T>::new(export)?;
    let gain = export.feedback.as_ref().map(|k| k.map(|x| nalgebra::convert::<f64, T>(scalar.round(x))));
    let mut plant = export.feedback.as_ref().and_then(|_| Loop::new(&export.observer));
    let mut noise = Noise::start();
    let mut steps = Vec::with_capacity(count);
    for step in 0..count {
        let mut column =
            |length: usize, size: f64| -> Vec<f64> { (0..length).map(|_| scalar.round(size * noise.next())).collect() };
        let (u, mut y) = if let Some((u, y)) = recorded.get(there_and_back(step, recorded.len())) {
            (run.rounded(u), run.rounded(y))
        } else if is_nonlinear {
            let (u, disturbance) = (column(size.inputs, 0.05), column(size.outputs, 0.05));
            let predicted = run.output(&u).unwrap_or_default();
            let y = predicted.iter().zip(disturbance).map(|(y, more)| scalar.round(y + more)).collect();
            (u, y)
        } else {
            let magnitude = if step % 16 == 7 { 1e3 } else { 1.0 };
            let (mut u, y) = (column(size.inputs, magnitude), column(size.outputs, magnitude));
            if let (ExportableObserver::Varying(step), Some(time)) = (&export.observer, u.last_mut()) {
                // From a quarter of the longest time to the longest.
                *time = scalar.round(step.observer().longest() * (0.625 + 0.1875 * noise.next()));
            }
            (u, y)
        };
        let (known, input, applied) = match &gain {
            Some(k) => {
                let fed = k * run.estimate();
                let known = if is_nonlinear { run.rounded(&numbers(&(convert::<T>(&u) + &fed))) } else { u };
                let input = numbers(&(convert::<T>(&known) - fed));
                (known, input.clone(), input)
            }
            None => (u.clone(), u, Vec::new()),
        };
        if let Some(plant) = &mut plant {
            for (y, output) in y.iter_mut().zip(&plant.step(&applied)) {
                *y = scalar.round(*y + output);
            }
        }
        let estimate = run.step(&input, &y);
        if run.state.iter().any(|x| !x.is_finite()) {
            return Err(ExportError::NotFinite { step, format: scalar.name() });
        }
        steps.push(Step { u: known, y, estimate, applied });
    }
    Ok(steps)
}

/// 0, 1, .., length - 1, length - 2, .., 1, 0, 1, ..
fn there_and_back(step: usize, length: usize) -> usize {
    let turn = length.saturating_sub(1).max(1);
    let at = step % (2 * turn);
    at.min(2 * turn - at).min(length.saturating_sub(1))
}

/// The linear plant of an observer, from the state 0.
struct Loop<'a> {
    observer: &'a ExportableObserver,
    x: DVector<f64>,
}

impl<'a> Loop<'a> {
    fn new(observer: &'a ExportableObserver) -> Option<Self> {
        let x = DVector::zeros(observer.dimensions().state);
        observer.plant().is_some().then_some(Self { observer, x })
    }

    /// The output at this sample; the state moves to the next.
    fn step(&mut self, u: &[f64]) -> DVector<f64> {
        let u = DVector::from_column_slice(u);
        let Some((a, b, c)) = self.observer.plant() else { return DVector::zeros(0) };
        let mut y = c * &self.x;
        if let Some(d) = self.observer.feedthrough() {
            y += d * &u;
        }
        self.x = a * &self.x + b * u;
        y
    }
}

/// Numbers in [-2, 2) without pattern: xorshift64*, of Marsaglia and Vigna.
pub(crate) struct Noise(u64);

impl Noise {
    pub(crate) fn start() -> Self {
        Self(0x9e37_79b9_7f4a_7c15)
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11;
        bits as f64 * 2f64.powi(-51) - 2.0
    }
}
