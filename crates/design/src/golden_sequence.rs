//! Points that fill the unit cube evenly, in an order that fills it evenly from the start: multiples of the
//! n-dimensional golden ratio.
//!
//! Source: M. Roberts, The unreasonable effectiveness of quasirandom sequences, 2018; for n = 1 the golden ratio's.

use luenberger_random::Stream;

/// The points, one after the other, without end.
pub(crate) struct GoldenSequence {
    now: Vec<f64>,
    step: Vec<f64>,
}

impl GoldenSequence {
    /// In `dimensions` coordinates; the stream determines the first point.
    pub(crate) fn new(dimensions: usize, stream: Stream) -> Self {
        // g^(n+1) = g + 1 by fixed-point iteration, which contracts at least by half.
        let golden = (0..64).fold(2.0f64, |g, _| (1.0 + g).powf(1.0 / (dimensions as f64 + 1.0)));
        let mut draws = stream.draws(0);
        Self {
            now: (0..dimensions).map(|_| draws.uniform()).collect(),
            step: (0..dimensions).map(|i| golden.powf(-(i as f64 + 1.0))).collect(),
        }
    }
}

impl Iterator for GoldenSequence {
    type Item = Vec<f64>;

    fn next(&mut self) -> Option<Vec<f64>> {
        for (now, step) in self.now.iter_mut().zip(&self.step) {
            *now = (*now + step).fract();
        }
        Some(self.now.clone())
    }
}
