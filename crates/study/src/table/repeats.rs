//! Outputs that a logger repeats until their sensor measures again.
//!
//! A logger at 50 Hz that writes a sensor of 5 Hz writes each measurement ten times. Counted as ten measurements they
//! would have ten times their weight in a filter. They are recognised by their rhythm: the value changes in every
//! tenth row, by a row more or less, and hardly ever by the same amount. A quantised signal that changes slowly can
//! repeat its values in a rhythm too, but its changes are a few multiples of its quantum.

/// The least number of measurements in which a rhythm is recognised.
const MEASUREMENTS: usize = 10;

/// The rows of an output, of those where it has a value, in which it is measured: the first of each run of equal
/// values. None if it is not repeated in a rhythm.
pub(super) fn measured(values: &[f64]) -> Option<Rhythm> {
    let starts: Vec<usize> =
        (0..values.len()).filter(|&k| k == 0 || values[k].to_bits() != values[k - 1].to_bits()).collect();
    let lengths: Vec<usize> = starts.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if lengths.len() < MEASUREMENTS {
        return None;
    }
    let mut sorted = lengths.clone();
    sorted.sort_unstable();
    let each = sorted[sorted.len() / 2];
    if each < 2 {
        return None;
    }
    // Two equal measurements in a row are a run of twice the length.
    let is_regular = |length: &&usize| {
        let turns = (**length as f64 / each as f64).round().max(1.0);
        (**length as f64 - turns * each as f64).abs() <= 1.0
    };
    // The first run begins before the log.
    let regular = lengths[1..].iter().filter(is_regular).count();
    if 10 * regular < 9 * (lengths.len() - 1) || !differs(values, &starts) {
        return None;
    }
    Some(Rhythm { each, rows: starts })
}

/// How an output is repeated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Rhythm {
    /// Rows from one measurement to the next, in the median.
    pub(super) each: usize,
    /// The rows of the measurements.
    pub(super) rows: Vec<usize>,
}

/// Whether most changes of the value have a size of their own.
fn differs(values: &[f64], starts: &[usize]) -> bool {
    let mut changes: Vec<f64> = starts.windows(2).map(|pair| (values[pair[1]] - values[pair[0]]).abs()).collect();
    changes.sort_by(f64::total_cmp);
    // Equal but for the rounding of a decimal.
    let different = changes.windows(2).filter(|pair| pair[1] - pair[0] > 1e-9 * pair[1]).count() + 1;
    2 * different > changes.len()
}
