//! Random numbers with random access, of which each purpose has its own.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::box_muller;

/// The purposes and their words in the key. Two of the same number do not compile; a number is not used again.
macro_rules! purposes {
    ($($(#[doc = $about:literal])+ $name:ident = $word:literal,)+) => {
        /// What random numbers are drawn for.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u64)]
        pub enum Purpose {
            $($(#[doc = $about])+ $name = $word,)+
        }

        impl Purpose {
            /// Every purpose.
            pub const ALL: &[Self] = &[$(Self::$name),+];
        }
    };
}

purposes! {
    /// Noise of the outputs of a run; k is the period.
    MeasurementNoise = 1,
    /// Noise of a sensor with a period of its own; the index is its output, k the measurement.
    SensorNoise = 2,
    /// Noise in the derivative of a plant, or in its next state; k is the period.
    ProcessNoise = 3,
    /// Whether a measurement arrives; the index is its output, k the measurement or the period.
    Dropout = 4,
    /// Whether a measurement is an outlier, and its sign; the index is its output, k the measurement or the period.
    Outlier = 5,
    /// Instants and misses of samples at varying periods, all from k = 0.
    SampleTimes = 6,
    /// The first estimate of a member of an ensemble; k is 0.
    FirstEstimate = 7,
    /// States at which a condition of a KKL observer is sampled.
    ConditionSamples = 8,
    /// States to which the inverse of a KKL observer is fitted.
    InverseSamples = 9,
    /// States at which a KKL observer is judged, none of them used before.
    HeldOutStates = 10,
    /// States from which the extent of a transformation is measured.
    TransformExtent = 11,
    /// Rows and columns with which an approximation of low rank begins.
    CrossApproximation = 12,
    /// Noise along which a search computes the cost of an observer.
    SearchedCost = 13,
    /// Noise along which the cost of an observer is judged, not that of the search.
    JudgedCost = 14,
    /// Directions of the first errors in a cost.
    ErrorDirections = 15,
    /// Cases at which a claim or a program is checked.
    RandomCase = 16,
    /// Particles of a filter; the index is 0 for their noise and 1 for their resampling, k the number of predictions.
    Particles = 17,
}

/// The stream of a seed, a member, a purpose and an index.
///
/// It is the keystream of `ChaCha8` (Bernstein, `ChaCha`, a variant of Salsa20, 2008) under a key of 256 bits, which is
/// four words of 64 bits, little-endian:
///
/// | word | meaning |
/// |---|---|
/// | 0 | the seed |
/// | 1 | the number of the member in its ensemble, 0 for a run by itself |
/// | 2 | the index of the instance: the output of a sensor, for example |
/// | 3 | the [`Purpose`] |
///
/// The draws of number k, those of a period, a measurement or a case, are the blocks of the nonce k. No two tuples
/// (seed, member, purpose, index, k) have the same key and nonce, because nothing is added or mixed: two purposes share
/// no stream, whatever the seeds are, and neither do two members of ensembles with neighbouring seeds. The draws of k
/// depend on this tuple alone, not on what was drawn before, and are the same on every machine.
///
/// ```
/// use luenberger_random::{Purpose, Stream};
/// let noise = Stream::new(7, Purpose::MeasurementNoise, 0);
/// // The draws of k do not depend on what was drawn before.
/// assert_eq!(noise.draws(12).bits(), noise.draws(12).bits());
/// // Another purpose, another member: other numbers.
/// assert_ne!(noise.draws(12).bits(), Stream::new(7, Purpose::ProcessNoise, 0).draws(12).bits());
/// assert_ne!(noise.draws(12).bits(), noise.member(1).draws(12).bits());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stream {
    seed: u64,
    member: u64,
    index: u64,
    purpose: Purpose,
}

impl Stream {
    /// The stream of member 0: of a run that is part of no ensemble.
    pub fn new(seed: u64, purpose: Purpose, index: u64) -> Self {
        Self { seed, member: 0, index, purpose }
    }

    /// The stream of another member of an ensemble.
    #[must_use]
    pub fn member(self, member: u64) -> Self {
        Self { member, ..self }
    }

    /// The draws of number k.
    pub fn draws(&self, k: u64) -> Draws {
        let mut key = [0; 32];
        let words = [self.seed, self.member, self.index, self.purpose as u64];
        for (bytes, word) in key.chunks_exact_mut(8).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(k);
        Draws(generator)
    }
}

/// Random numbers of a [`Stream`], one after the other.
#[derive(Clone, Debug)]
pub struct Draws(ChaCha8Rng);

impl Draws {
    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in (0, 1), an odd multiple of 2^-53: never 0, so that it has a logarithm, and with mean one half.
    pub fn uniform(&mut self) -> f64 {
        ((self.bits() >> 12) as f64 + 0.5) * 2f64.powi(-52)
    }

    /// Uniform in (-1, 1), with mean 0.
    pub fn unit(&mut self) -> f64 {
        2.0 * self.uniform() - 1.0
    }

    /// Standard normal, from two uniform numbers.
    pub fn normal(&mut self) -> f64 {
        let first = self.uniform();
        box_muller(first, self.uniform())[0]
    }
}
