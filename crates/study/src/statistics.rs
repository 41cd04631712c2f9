//! Statistics that scores are summarized and compared by: moments, percentiles, the Pareto front.

/// Count, mean, sum of the squared deviations from it, and extremes of the finite values.
///
/// ```
/// use luenberger_study::statistics::Moments;
/// let moments = Moments::of(&[1.0, 2.0]).merge(Moments::of(&[3.0, f64::INFINITY]));
/// assert_eq!((moments.count(), moments.mean(), moments.deviation()), (3, Some(2.0), Some(1.0)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    count: u64,
    mean: f64,
    squares: f64,
    min: f64,
    max: f64,
}

impl Default for Moments {
    fn default() -> Self {
        Self { count: 0, mean: 0.0, squares: 0.0, min: f64::INFINITY, max: f64::NEG_INFINITY }
    }
}

impl Moments {
    /// Those of some values, by the update of Welford, Technometrics 4, 1962.
    pub fn of(values: &[f64]) -> Self {
        let mut moments = Self::default();
        for &x in values.iter().filter(|x| x.is_finite()) {
            moments.count += 1;
            let before = x - moments.mean;
            moments.mean += before / moments.count as f64;
            moments.squares += before * (x - moments.mean);
            (moments.min, moments.max) = (moments.min.min(x), moments.max.max(x));
        }
        moments
    }

    /// Those of both, by the update of Chan, Golub and LeVeque, The American Statistician 37, 1983. The last bits
    /// depend on the order.
    #[must_use]
    pub fn merge(self, other: Self) -> Self {
        if self.count == 0 || other.count == 0 {
            return if self.count == 0 { other } else { self };
        }
        let count = self.count + other.count;
        let (share, apart) = (other.count as f64 / count as f64, other.mean - self.mean);
        Self {
            count,
            mean: self.mean + apart * share,
            squares: self.squares + other.squares + apart * apart * share * self.count as f64,
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The number of finite values.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The mean; none without a value.
    pub fn mean(&self) -> Option<f64> {
        self.known(self.mean)
    }

    /// The standard deviation with the divisor count - 1; none of less than two values.
    pub fn deviation(&self) -> Option<f64> {
        (self.count > 1).then(|| (self.squares / (self.count - 1) as f64).sqrt())
    }

    /// The smallest value; none without a value.
    pub fn min(&self) -> Option<f64> {
        self.known(self.min)
    }

    /// The largest value; none without a value.
    pub fn max(&self) -> Option<f64> {
        self.known(self.max)
    }

    fn known(&self, x: f64) -> Option<f64> {
        (self.count > 0).then_some(x)
    }
}

/// The percentile by nearest rank: the smallest of the values that at least `percent` percent of them do not exceed;
/// none without a value, or of more than 100 percent. The values are reordered.
///
/// ```
/// use luenberger_study::statistics::percentile;
/// assert_eq!(percentile(&mut [4.0, 1.0, 3.0, f64::INFINITY, 2.0], 50), Some(3.0));
/// ```
pub fn percentile(values: &mut [f64], percent: u8) -> Option<f64> {
    let rank = rank(values.len() as u64, percent)? as usize;
    (rank < values.len()).then(|| *values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// The place, from 0, of the smallest value that at least so many percent of the values do not exceed.
pub(crate) fn rank(count: u64, percent: u8) -> Option<u64> {
    let exact = u128::from(count) * u128::from(percent);
    (count > 0).then(|| (exact.div_ceil(100).max(1) - 1) as u64)
}

/// The Pareto front of points of which less is better in both coordinates: the indices of those that no other one
/// dominates, in their order. A point that is not finite is none of them.
///
/// ```
/// use luenberger_study::statistics::pareto_front;
/// assert_eq!(pareto_front(&[(1.0, 5.0), (2.0, 2.0), (3.0, 3.0)]), [0, 1]);
/// ```
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<usize> {
    let is_known = |(x, y): &(f64, f64)| x.is_finite() && y.is_finite();
    let beats = |(x, y): &(f64, f64), (other_x, other_y): &(f64, f64)| {
        x <= other_x && y <= other_y && (x < other_x || y < other_y)
    };
    (0..points.len())
        .filter(|&i| is_known(&points[i]) && !points.iter().any(|other| beats(other, &points[i])))
        .collect()
}
