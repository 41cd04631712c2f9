//! The random numbers of a particle filter, from a seed.

use luenberger_observers::ParticleNoise;
use luenberger_random::{Purpose, Stream};

/// Seeded numbers for a [`ParticleFilter`](luenberger_observers::ParticleFilter), none of which a run draws for
/// anything else.
///
/// ```
/// use luenberger_observers::ParticleNoise;
/// use luenberger_sim::SeededParticles;
/// let (mut once, mut again) = ([0.0; 3], [0.0; 3]);
/// SeededParticles::new(4).normals(7, &mut once);
/// SeededParticles::new(4).normals(7, &mut again);
/// assert_eq!(once, again);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SeededParticles {
    motion: Stream,
    resampling: Stream,
}

impl SeededParticles {
    /// Those of a seed.
    pub fn new(seed: u64) -> Self {
        let stream = |index| Stream::new(seed, Purpose::Particles, index);
        Self { motion: stream(0), resampling: stream(1) }
    }
}

impl ParticleNoise for SeededParticles {
    fn normals(&self, k: u64, numbers: &mut [f64]) {
        let mut draws = self.motion.draws(k);
        for number in numbers {
            *number = draws.normal();
        }
    }

    fn uniform(&self, k: u64) -> f64 {
        self.resampling.draws(k).uniform()
    }
}
