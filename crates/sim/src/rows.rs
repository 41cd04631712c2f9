//! The times at which a run is tabulated.

/// The times of a run from 0 to `end` that are rows of its table, and the end of the run if that is no row: `rows`
/// equally spaced ones, at least two; with a sampled observer of this period its samples, evenly thinned.
///
/// ```
/// use luenberger_sim::row_times;
/// assert_eq!(row_times(1.0, 3, None), (vec![0.0, 0.5, 1.0], None));
/// assert_eq!(row_times(1.0, 3, Some(0.25)), (vec![0.0, 0.5, 1.0], None));
/// assert_eq!(row_times(1.0, 3, Some(0.375)), (vec![0.0, 0.375, 0.75], Some(1.0)));
/// ```
pub fn row_times(end: f64, rows: usize, period: Option<f64>) -> (Vec<f64>, Option<f64>) {
    let intervals = rows.max(2) - 1;
    let Some(period) = period else {
        let step = end / intervals as f64;
        let time = |k: usize| if k == intervals { end } else { step * k as f64 };
        return ((0..=intervals).map(time).collect(), None);
    };
    let samples = (end / period + 1e-9).floor() as usize;
    let every = samples.div_ceil(intervals).max(1);
    let mut times: Vec<f64> = (0..=samples / every).map(|k| (k * every) as f64 * period).collect();
    match times.last_mut() {
        Some(last) if *last >= end - 1e-9 * period => {
            *last = end;
            (times, None)
        }
        _ => (times, Some(end)),
    }
}
