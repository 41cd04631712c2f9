//! Points that fill the unit cube evenly, in an order that fills it evenly from the start: multiples of the
//! n-dimensional golden ratio.
//!
//! Source: M. Roberts, The unreasonable effectiveness of quasirandom sequences, 2018; for n = 1 the golden ratio's.

/// The points, one after the other, without end.
pub(crate) struct GoldenSequence {
    now: Vec<f64>,
    step: Vec<f64>,
}

impl GoldenSequence {
    /// In `dimensions` coordinates; the seed determines the first point.
    pub(crate) fn new(dimensions: usize, seed: u64) -> Self {
        // g^(n+1) = g + 1 by fixed-point iteration, which contracts at least by half.
        let golden = (0..64).fold(2.0f64, |g, _| (1.0 + g).powf(1.0 / (dimensions as f64 + 1.0)));
        let mut state = seed;
        let mut start = || {
            // SplitMix64 (Steele, Lea, Flood 2014).
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut bits = state;
            bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((bits ^ (bits >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        };
        Self {
            now: (0..dimensions).map(|_| start()).collect(),
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
