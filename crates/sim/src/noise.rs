//! Measurement noise: seeded, held over a period, seen by the observers only.
//!
//! The value in the k-th period depends only on the seed and on k, not on the order of evaluation: two runs with the
//! same seed have the same noise, whatever their integrators do.

use luenberger_random::box_muller;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::error::{SimError, check_finite, check_positive};

/// How the values are distributed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Distribution {
    Uniform,
    Gaussian,
}

/// Noise added to the outputs that the observers see; piecewise constant in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    distribution: Distribution,
    amplitude: Vec<f64>,
    period: f64,
    seed: u64,
}

impl Noise {
    /// Uniform on `[-amplitude, amplitude]`, one amplitude per output, 0 for none, a new value every `period`.
    ///
    /// A run refuses a negative amplitude ([`SimError::NegativeNoise`]).
    ///
    /// ```
    /// use luenberger_sim::Noise;
    /// let noise = Noise::uniform(&[0.02, 2e-4], 1e-4, 7);
    /// assert_eq!(noise.sample(12), noise.sample(12));
    /// assert!(noise.sample(12)[0].abs() <= 0.02);
    /// ```
    pub fn uniform(amplitude: &[f64], period: f64, seed: u64) -> Self {
        Self { distribution: Distribution::Uniform, amplitude: amplitude.to_vec(), period, seed }
    }

    /// Gaussian with mean 0, one standard deviation per output, 0 for none, a new value every `period`.
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

    /// The same noise with `by` added to its seed.
    #[must_use]
    pub fn reseeded(&self, by: u64) -> Self {
        Self { seed: self.seed.wrapping_add(by), ..self.clone() }
    }

    /// The values in the k-th period, counted from the start of the simulation.
    pub fn sample(&self, k: u64) -> Vec<f64> {
        self.values(k).collect()
    }

    /// [`sample`](Self::sample), one value after the other.
    pub(crate) fn values(&self, k: u64) -> impl Iterator<Item = f64> {
        let mut generator = ChaCha8Rng::seed_from_u64(self.seed);
        generator.set_stream(k);
        // 53 random bits in (0, 1): never 0, so that its logarithm exists.
        let mut unit = move || ((generator.next_u64() >> 11) as f64 + 0.5) * 2f64.powi(-53);
        let value = move |amplitude: &f64| match self.distribution {
            Distribution::Uniform => amplitude * (2.0 * unit() - 1.0),
            Distribution::Gaussian => amplitude * box_muller(unit(), unit())[0],
        };
        self.amplitude.iter().map(value)
    }

    /// Checks amplitudes (one per output, finite, not negative) and period.
    pub(crate) fn check(&self, outputs: usize) -> Result<(), SimError> {
        if self.amplitude.len() != outputs {
            let (expected, found) = (outputs, self.amplitude.len());
            return Err(SimError::Length { what: "the noise".to_owned(), expected, found });
        }
        check_finite("the amplitudes of the noise", &self.amplitude)?;
        if let Some(index) = self.amplitude.iter().position(|amplitude| *amplitude < 0.0) {
            return Err(SimError::NegativeNoise { index, value: self.amplitude[index] });
        }
        check_positive("the period of the noise", self.period)
    }
}
