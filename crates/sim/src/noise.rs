//! Noise: seeded, held over a period.
//!
//! The value in the k-th period depends on the seed, the [`Purpose`] and k, not on the order of evaluation: two runs
//! with the same seed have the same noise, whatever their integrators do, and noises of two purposes are independent.

use luenberger_random::{Purpose, Stream};

use crate::error::{SimError, check_finite, check_positive};

/// How the values are distributed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Distribution {
    Uniform,
    Gaussian,
}

/// Noise of outputs that the observers see, or of the derivative of a plant; piecewise constant in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    distribution: Distribution,
    amplitude: Vec<f64>,
    period: f64,
    seed: u64,
}

impl Noise {
    /// Uniform on `[-amplitude, amplitude]`, one amplitude per entry, 0 for none, a new value every `period`.
    ///
    /// A run refuses a negative amplitude ([`SimError::NegativeNoise`]).
    ///
    /// ```
    /// use luenberger_sim::{Noise, Purpose};
    /// let noise = Noise::uniform(&[0.02, 2e-4], 1e-4, 7);
    /// let measured = |k| noise.sample(Purpose::MeasurementNoise, k);
    /// assert_eq!(measured(12), measured(12));
    /// assert!(measured(12)[0].abs() <= 0.02);
    /// assert_ne!(measured(12), noise.sample(Purpose::ProcessNoise, 12));
    /// ```
    pub fn uniform(amplitude: &[f64], period: f64, seed: u64) -> Self {
        Self { distribution: Distribution::Uniform, amplitude: amplitude.to_vec(), period, seed }
    }

    /// Gaussian with mean 0, one standard deviation per entry, 0 for none, a new value every `period`.
    ///
    /// A run refuses a negative deviation ([`SimError::NegativeNoise`]).
    pub fn gaussian(deviation: &[f64], period: f64, seed: u64) -> Self {
        Self { distribution: Distribution::Gaussian, amplitude: deviation.to_vec(), period, seed }
    }

    /// The time each value is held.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// The amplitudes, or the standard deviations.
    pub fn amplitude(&self) -> &[f64] {
        &self.amplitude
    }

    /// Whether it is Gaussian; otherwise it is uniform.
    pub fn is_gaussian(&self) -> bool {
        self.distribution == Distribution::Gaussian
    }

    /// The variance of each entry; that of a uniform distribution on `[-a, a]` is `a^2/3`.
    pub fn variances(&self) -> Vec<f64> {
        let share = match self.distribution {
            Distribution::Uniform => 1.0 / 3.0,
            Distribution::Gaussian => 1.0,
        };
        self.amplitude.iter().map(|amplitude| share * amplitude * amplitude).collect()
    }

    /// The seed.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Its stream for a purpose; the index is that of the instance.
    pub(crate) fn stream(&self, purpose: Purpose, index: u64) -> Stream {
        Stream::new(self.seed, purpose, index)
    }

    /// The values in the k-th period, counted from the start of the simulation, of a run that is part of no ensemble.
    pub fn sample(&self, purpose: Purpose, k: u64) -> Vec<f64> {
        self.values(self.stream(purpose, 0), k).collect()
    }

    /// The values in the k-th period, from a stream.
    pub(crate) fn values(&self, stream: Stream, k: u64) -> impl Iterator<Item = f64> {
        let mut draws = stream.draws(k);
        let value = move |amplitude: &f64| match self.distribution {
            Distribution::Uniform => amplitude * draws.unit(),
            Distribution::Gaussian => amplitude * draws.normal(),
        };
        self.amplitude.iter().map(value)
    }

    /// Checks amplitudes (so many, finite, not negative) and period.
    pub(crate) fn check(&self, entries: usize) -> Result<(), SimError> {
        if self.amplitude.len() != entries {
            let (expected, found) = (entries, self.amplitude.len());
            return Err(SimError::Length { what: "the noise".to_owned(), expected, found });
        }
        check_finite("the amplitudes of the noise", &self.amplitude)?;
        if let Some(index) = self.amplitude.iter().position(|amplitude| *amplitude < 0.0) {
            return Err(SimError::NegativeNoise { index, value: self.amplitude[index] });
        }
        check_positive("the period of the noise", self.period)
    }
}
