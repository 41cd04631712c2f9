//! Linear observers in fixed point: integers on the target, with the sums and the rounding of
//! [`FixedPointObserver`].

use luenberger_observers::{FixedPointFormat, FixedPointFormats, FixedPointObserver, MatrixName, ObserverError};
use nalgebra::{DMatrix, DVector, Dyn};
use sha2::{Digest, Sha256};

use crate::error::ExportError;
use crate::exportable_observer::ExportableObserver;
use crate::golden::Noise;
use crate::{Export, ExportedMatrix, hexadecimal};

/// A linear observer whose numbers are integers, ready to be written as C.
///
/// ```
/// use luenberger_export::{Export, Names, ExportableObserver, Scalar};
/// use luenberger_observers::{DiscreteLinearObserver, FixedPointFormat};
/// use luenberger_plants::StateSpace;
/// use nalgebra::dmatrix;
/// let plant = StateSpace::new(dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1], dmatrix![1.0, 0.0])?;
/// let observer = DiscreteLinearObserver::new(plant, dmatrix![0.9; 2.0], 0.1)?;
/// let names = Names::numbered(2, 1, 1);
/// let export = Export::new("cart", ExportableObserver::Linear(observer), Scalar::Binary64, &[0.0, 0.0], names)?;
/// let files = export.fixed_point(FixedPointFormat::new(16, 16)?.into())?.c();
/// assert!(files[1].text.contains("{ 65536, 6554 }"), "A times 2^16");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FixedPointExport<'a> {
    pub(crate) design: &'a Export,
    pub(crate) observer: FixedPointObserver<Dyn, Dyn, Dyn>,
    pub(crate) initial: DVector<i32>,
}

impl Export {
    /// The observer in these formats.
    ///
    /// # Errors
    /// [`ExportError::FixedPointKind`] for an observer that is not linear; [`ExportError::FilterForm`];
    /// [`ExportError::FixedPoint`] for numbers beyond the range of their format, and for sums of products that could
    /// overflow 64 bits.
    pub fn fixed_point(&self, formats: FixedPointFormats) -> Result<FixedPointExport<'_>, ExportError> {
        let ExportableObserver::Linear(linear) = &self.observer else {
            return Err(ExportError::FixedPointKind { kind: self.kind() });
        };
        if self.is_filter() {
            return Err(ExportError::FilterForm { what: "fixed point".to_owned() });
        }
        let refused = |format, error| ExportError::FixedPoint { format: name(format), error: Box::new(error) };
        let observer = FixedPointObserver::rounded(linear, formats).map_err(|error| refused(formats.gains, error))?;
        let integer = |(row, value): (usize, &f64)| {
            let FixedPointFormats { signals, .. } = formats;
            let (integer_bits, fraction_bits) = (signals.integer_bits(), signals.fraction_bits());
            let what = "the first estimate";
            let error =
                ObserverError::FixedPointRange { what, row, column: 0, value: *value, integer_bits, fraction_bits };
            signals.nearest(*value).ok_or_else(|| refused(signals, error))
        };
        let initial = self.initial.iter().enumerate().map(integer).collect::<Result<Vec<i32>, _>>()?;
        Ok(FixedPointExport { design: self, observer, initial: DVector::from_vec(initial) })
    }
}

/// `Q16.16`.
pub(crate) fn name(format: FixedPointFormat) -> String {
    format!("Q{}.{}", format.integer_bits(), format.fraction_bits())
}

/// Every so many steps of the golden vectors an output is missing.
pub(crate) const PARTIAL_EVERY: usize = 5;

/// A step of the golden vectors, in integers.
pub(crate) struct Step {
    pub(crate) u: Vec<i32>,
    pub(crate) y: Vec<i32>,
    pub(crate) measured: Vec<bool>,
    pub(crate) estimate: Vec<i32>,
    /// Saturations since the start.
    pub(crate) saturations: u32,
}

impl FixedPointExport<'_> {
    /// The observer in integers, which computes the golden vectors.
    pub fn observer(&self) -> &FixedPointObserver<Dyn, Dyn, Dyn> {
        &self.observer
    }

    /// The first estimate, in integers.
    pub fn initial(&self) -> &DVector<i32> {
        &self.initial
    }

    /// The matrices that the step uses, by the names they have in the emitted code.
    pub(crate) fn matrices(&self) -> Vec<(ExportedMatrix, &DMatrix<i32>)> {
        let gains = self.observer.gains();
        let mut all = vec![
            (MatrixName::A, &gains.a),
            (MatrixName::B, &gains.b),
            (MatrixName::C, &gains.c),
            (MatrixName::L, &gains.l),
        ];
        all.extend(gains.d.as_ref().map(|d| (MatrixName::D, d)));
        all.into_iter().map(|(which, matrix)| (which.into(), matrix)).collect()
    }

    /// Products of one step, each of two integers of 32 bits to one of 64.
    pub fn products(&self) -> usize {
        self.matrices().iter().map(|(_, m)| m.len()).sum()
    }

    /// Bytes of the constants and of the state.
    pub fn bytes(&self) -> usize {
        4 * (self.products() + 2 * self.initial.len() + 1)
    }

    /// The SHA-256 of the exported numbers: formats, sizes, gains, period and first estimate.
    pub fn digest(&self) -> String {
        let FixedPointFormats { gains, signals } = self.observer.formats();
        let mut hash = Sha256::new();
        hash.update(format!("{} {}", name(gains), name(signals)));
        for (which, m) in self.matrices() {
            hash.update(format!("{} {} {}", which.name(), m.nrows(), m.ncols()));
            m.iter().for_each(|x| hash.update(x.to_le_bytes()));
        }
        self.initial.iter().for_each(|x| hash.update(x.to_le_bytes()));
        hash.update(self.design.observer.period().to_bits().to_le_bytes());
        hexadecimal(&hash.finalize())
    }

    /// The estimates for given inputs and outputs, one pair for each sample: rounded to the format, and at most its
    /// largest number. Outputs that are NaN are missing.
    pub fn replay(&self, samples: &[(Vec<f64>, Vec<f64>)]) -> Vec<Vec<f64>> {
        self.run(samples).map(|(estimate, _)| estimate).collect()
    }

    /// In how many of these samples an input, an output or a result is beyond the range of the format and cut off at
    /// its end.
    pub fn saturated(&self, samples: &[(Vec<f64>, Vec<f64>)]) -> usize {
        self.run(samples).filter(|(_, is_cut)| *is_cut).count()
    }

    /// The estimate after each sample, and whether something was cut off.
    fn run<'a>(&'a self, samples: &'a [(Vec<f64>, Vec<f64>)]) -> impl Iterator<Item = (Vec<f64>, bool)> + 'a {
        let signals = self.observer.formats().signals;
        let integer = move |x: f64| {
            let ends = if x < 0.0 { signals.smallest() } else { signals.largest() };
            signals.nearest(x).unwrap_or(ends)
        };
        let column = move |values: &[f64]| DVector::from_iterator(values.len(), values.iter().map(|x| integer(*x)));
        let mut state = self.observer.start(self.initial.clone());
        samples.iter().map(move |(u, y)| {
            let measured: Vec<bool> = y.iter().map(|y| !y.is_nan()).collect();
            let before = state.saturations;
            self.observer.step_partial(&mut state, &column(u), &column(y), &measured);
            let given = u.iter().chain(y).any(|x| !x.is_nan() && signals.nearest(*x).is_none());
            let estimate = state.xhat.iter().map(|x| signals.value(*x)).collect();
            (estimate, given || state.saturations > before)
        })
    }

    /// Steps from the first estimate, with numbers of magnitude up to 2, now and then of the whole range, and at its
    /// ends, so that results saturate too; of every fifth an output is missing.
    pub(crate) fn golden(&self, count: usize) -> Vec<Step> {
        let signals = self.observer.formats().signals;
        let size = self.observer.dimensions();
        let (smallest, largest) = (f64::from(signals.smallest()), f64::from(signals.largest()));
        let mut noise = Noise::start();
        let mut state = self.observer.start(self.initial.clone());
        let mut steps = Vec::with_capacity(count);
        for step in 0..count {
            let mut column = |length: usize| -> Vec<i32> {
                let scale = match step % 16 {
                    7 => 0.5 * largest,
                    15 => largest,
                    _ => (1_u64 << signals.fraction_bits()) as f64,
                };
                (0..length).map(|_| (scale * noise.next()).floor().clamp(smallest, largest) as i32).collect()
            };
            let (u, y) = (column(size.inputs), column(size.outputs));
            // One output after the other.
            let missing =
                (step % PARTIAL_EVERY == PARTIAL_EVERY - 1).then(|| step / PARTIAL_EVERY % size.outputs.max(1));
            let measured: Vec<bool> = (0..size.outputs).map(|output| Some(output) != missing).collect();
            let column = DVector::from_column_slice;
            self.observer.step_partial(&mut state, &column(&u), &column(&y), &measured);
            let estimate = state.xhat.as_slice().to_vec();
            steps.push(Step { u, y, measured, estimate, saturations: state.saturations });
        }
        steps
    }
}
