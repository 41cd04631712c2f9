//! Exact percentiles by nearest rank: each is one of the values.
//!
//! Few values are kept. Of many, the bits of the percentiles are found from the highest on, 16 at a time, by counting
//! the values that begin with the bits known so far: four passes over the values in 1.5 MiB, however many they are.

use crate::statistics::{percentile, rank};

/// The percentiles of a score: the median, and of an ensemble the other two as well.
pub(super) const PERCENT: [u8; 3] = [50, 5, 95];

/// Bits that are found in a pass, and the number of their values.
const BITS: u32 = 16;
const BINS: usize = 1 << BITS;

/// Bytes that the percentiles of one score need where values are not kept.
pub(super) const BYTES: usize = PERCENT.len() * BINS * 8;

/// The values of a score, as far as their percentiles need them.
pub enum Percentiles {
    /// All of them.
    Values(Vec<f64>),
    /// How many have the next bits.
    Counts(Box<Counts>),
}

/// The values that begin with the bits of a percentile that are known, by their next bits.
pub struct Counts {
    /// The number of all values.
    count: u64,
    /// Passes that are done.
    passes: u32,
    /// For each percentile the bits that are known, the number of smaller values, and the counts.
    known: [u64; 3],
    below: [u64; 3],
    bins: [Vec<u64>; 3],
}

impl Percentiles {
    /// Of values that are kept, or counted.
    pub fn new(keeps_values: bool) -> Self {
        if keeps_values {
            return Self::Values(Vec::new());
        }
        let bins = PERCENT.map(|_| vec![0; BINS]);
        Self::Counts(Box::new(Counts { count: 0, passes: 0, known: [0; 3], below: [0; 3], bins }))
    }

    /// Passes over the values.
    pub fn passes(keeps_values: bool) -> u32 {
        if keeps_values { 1 } else { u64::BITS / BITS }
    }

    /// Takes some values in a pass.
    pub fn add(&mut self, values: &[f64]) {
        match self {
            Self::Values(all) => all.extend(values),
            Self::Counts(counts) => values.iter().for_each(|x| counts.add(ordered(*x))),
        }
    }

    /// Ends a pass.
    pub fn end_pass(&mut self) {
        if let Self::Counts(counts) = self {
            counts.end_pass();
        }
    }

    /// The percentiles, in the order of [`PERCENT`], after all passes; NaN without a value.
    pub fn finish(self) -> [f64; 3] {
        match self {
            Self::Values(mut values) => PERCENT.map(|percent| percentile(&mut values, percent).unwrap_or(f64::NAN)),
            Self::Counts(counts) if counts.count == 0 => [f64::NAN; 3],
            Self::Counts(counts) => counts.known.map(number),
        }
    }
}

impl Counts {
    fn add(&mut self, x: u64) {
        let rest = u64::BITS - self.passes * BITS;
        self.count += u64::from(self.passes == 0);
        for (known, bins) in self.known.iter().zip(&mut self.bins) {
            if self.passes == 0 || x >> rest == *known {
                bins[(x >> (rest - BITS)) as usize % BINS] += 1;
            }
        }
    }

    fn end_pass(&mut self) {
        self.passes += 1;
        for (k, percent) in PERCENT.into_iter().enumerate() {
            let Some(rank) = rank(self.count, percent) else { continue };
            let (mut below, mut bin) = (self.below[k], 0);
            // The rank is below the number of values, so that a bin has it.
            while bin + 1 < BINS && below + self.bins[k][bin] <= rank {
                below += self.bins[k][bin];
                bin += 1;
            }
            self.below[k] = below;
            self.known[k] = self.known[k] << BITS | bin as u64;
            self.bins[k].fill(0);
        }
    }
}

/// Bits whose order is that of the numbers, as in [`f64::total_cmp`].
fn ordered(x: f64) -> u64 {
    let bits = x.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

/// The number of such bits.
fn number(ordered: u64) -> f64 {
    f64::from_bits(if ordered >> 63 == 1 { ordered & !(1 << 63) } else { !ordered })
}
