//! Exact percentiles by nearest rank: each is one of the values.
//!
//! Few values are kept. Of many, the bits of the percentiles are found from the highest on, 16 at a time, by counting
//! the values that begin with the bits known so far: four passes over the values in 1.5 MiB, however many they are.

/// The percentiles of a score: the median, and of an ensemble the other two as well.
pub(super) const PERCENT: [u8; 3] = [50, 5, 95];

/// Bits that are found in a pass, and the number of their values.
const BITS: u32 = 16;
const BINS: usize = 1 << BITS;

/// Bytes that the percentiles of one score need where values are not kept.
pub(super) const BYTES: usize = PERCENT.len() * BINS * 8;

/// The values of a score, as far as their percentiles need them.
pub(super) enum Percentiles {
    /// All of them.
    Values(Vec<f64>),
    /// How many have the next bits.
    Counts(Box<Counts>),
}

/// The values that begin with the bits of a percentile that are known, by their next bits.
pub(super) struct Counts {
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
    pub(super) fn new(keeps_values: bool) -> Self {
        if keeps_values {
            return Self::Values(Vec::new());
        }
        let bins = PERCENT.map(|_| vec![0; BINS]);
        Self::Counts(Box::new(Counts { count: 0, passes: 0, known: [0; 3], below: [0; 3], bins }))
    }

    /// Passes over the values.
    pub(super) fn passes(keeps_values: bool) -> u32 {
        if keeps_values { 1 } else { u64::BITS / BITS }
    }

    /// Takes some values in a pass.
    pub(super) fn add(&mut self, values: &[f64]) {
        match self {
            Self::Values(all) => all.extend(values),
            Self::Counts(counts) => values.iter().for_each(|x| counts.add(ordered(*x))),
        }
    }

    /// Ends a pass.
    pub(super) fn end_pass(&mut self) {
        if let Self::Counts(counts) = self {
            counts.end_pass();
        }
    }

    /// The percentiles, in the order of [`PERCENT`], after all passes; NaN without a value.
    pub(super) fn finish(self) -> [f64; 3] {
        match self {
            Self::Values(mut values) => PERCENT.map(|percent| match rank(values.len() as u64, percent) {
                Some(rank) => *values.select_nth_unstable_by(rank as usize, f64::total_cmp).1,
                None => f64::NAN,
            }),
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

/// The place, from 0, of the smallest value that at least so many percent of the values do not exceed.
fn rank(count: u64, percent: u8) -> Option<u64> {
    let exact = u128::from(count) * u128::from(percent);
    (count > 0).then(|| (exact.div_ceil(100).max(1) - 1) as u64)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn both(values: &[f64]) -> [f64; 3] {
        let [kept, counted] = [true, false].map(|keeps_values| {
            let mut percentiles = Percentiles::new(keeps_values);
            for _ in 0..Percentiles::passes(keeps_values) {
                for part in values.chunks(7) {
                    percentiles.add(part);
                }
                percentiles.end_pass();
            }
            percentiles.finish()
        });
        assert_eq!(kept.map(f64::to_bits), counted.map(f64::to_bits), "{kept:?} {counted:?}");
        kept
    }

    /// By numpy: percentile(values, q, method="inverted_cdf").
    #[test]
    fn percentiles_are_those_of_numpy() {
        assert_eq!(both(&[3.0, 1.0, 2.0, 5.0, 4.0, 9.0, 7.0, 8.0, 6.0, 10.0]), [5.0, 1.0, 10.0]);
        let values: Vec<f64> = (0..41).rev().map(f64::from).collect();
        assert_eq!(both(&values), [20.0, 2.0, 38.0]);
        assert_eq!(both(&[f64::INFINITY, 1.0, f64::INFINITY])[0], f64::INFINITY);
        assert_eq!(both(&[7.0]), [7.0; 3]);
        assert!(both(&[]).iter().all(|x| x.is_nan()));
    }

    #[test]
    fn counting_finds_each_bit() {
        let values: Vec<f64> =
            (0..5000_i32).map(|k| (f64::from(k * k % 4999) - 2500.0).powi(3).sinh() * 1e-9).collect();
        both(&values);
        both(&values.iter().map(|x| x * 1e-300).collect::<Vec<_>>());
        both(&(0..999).map(|k| 1.0 + f64::from(k % 10) * f64::EPSILON).collect::<Vec<_>>());
        both(&[-0.0, 0.0, 0.0, -0.0, 5e-324, -5e-324, f64::MAX, f64::MIN]);
    }
}
