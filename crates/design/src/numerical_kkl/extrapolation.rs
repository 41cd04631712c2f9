//! Integration of thousands of short trajectories: the midpoint rule, extrapolated to order 10.
//!
//! T(x) is one integral along one backward trajectory, needed at thousands of x but not at intermediate times. Hence
//! there is no dense output, no allocation per step, and a single error estimate. Gragg's modified midpoint rule with
//! 2, 4, ..., 10 substeps, extrapolated by Aitken and Neville in h^2; the difference of the last two columns (order 8)
//! is kept below the tolerance.
//!
//! Source: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993,
//! section II.9.

/// Substeps of the columns.
const SUBSTEPS: [usize; 5] = [2, 4, 6, 8, 10];
/// Order of the error estimate plus one.
const ORDER: f64 = 9.0;
/// Cap on attempted steps of one trajectory.
const MAX_STEPS: usize = 20_000;
/// How far a guarded component may go, in units of its scale: far enough for a stable linear plant, whose past grows
/// like an exponential.
const REACH: f64 = 1e12;
/// A standstill beyond this is an escape in finite time: steps shrink with the time that is left, and time has no more
/// digits.
const RUNNING_OFF: f64 = 1e3;

/// Why a trajectory ends early.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Halt {
    /// The right-hand side is not finite at the start.
    NotFinite,
    /// A guarded component left everything.
    Escape {
        /// When.
        time: f64,
        /// How far, in units of its scale.
        norm: f64,
    },
    /// The steps vanish, or are too many.
    Stall {
        /// When.
        time: f64,
        /// The last step.
        step: f64,
        /// How many there were.
        steps: usize,
    },
}

/// The workspace of one integration after the other.
pub struct Extrapolation {
    tolerance: f64,
    columns: Vec<Vec<f64>>,
    slope: Vec<f64>,
    first: Vec<f64>,
    before: Vec<f64>,
    now: Vec<f64>,
}

impl Extrapolation {
    /// For systems of this size; `tolerance` is per step, relative to the scale of a component plus its size.
    pub fn new(size: usize, tolerance: f64) -> Self {
        let row = || vec![0.0; size];
        Self {
            tolerance,
            columns: SUBSTEPS.iter().map(|_| row()).collect(),
            slope: row(),
            first: row(),
            before: row(),
            now: row(),
        }
    }

    /// `y' = f(y)` over `span > 0`, in place. `scale[i]` is what counts as 1 in component i; the first `guarded`
    /// components must not run off.
    ///
    /// # Errors
    /// Why the trajectory ends before `span`.
    pub fn advance(
        &mut self,
        f: &mut dyn FnMut(&[f64], &mut [f64]),
        span: f64,
        y: &mut [f64],
        scale: &[f64],
        guarded: usize,
    ) -> Result<(), Halt> {
        f(y, &mut self.first);
        let escaped =
            |y: &[f64]| y[..guarded].iter().zip(scale).map(|(y, scale)| (y / scale).abs()).fold(0.0f64, f64::max);
        if !self.first.iter().chain(y.iter()).all(|x| x.is_finite()) {
            return Err(Halt::NotFinite);
        }
        let speed = self.first.iter().zip(scale).map(|(slope, scale)| (slope / scale).abs()).fold(0.0f64, f64::max);
        let mut h = span.min(0.1 / speed.max(1e-3 / span));
        let mut time = 0.0;
        for steps in 0..MAX_STEPS {
            if time >= span {
                return Ok(());
            }
            // A last step may stretch a little, lest a sliver remain.
            let last = time + 1.001 * h >= span;
            let step = if last { span - time } else { h };
            if step.is_nan() || step <= 16.0 * f64::EPSILON * span {
                let norm = escaped(y);
                let runs_off = norm > RUNNING_OFF;
                return Err(if runs_off { Halt::Escape { time, norm } } else { Halt::Stall { time, step, steps } });
            }
            let error = self.attempt(f, step, y, scale);
            let factor = if error.is_finite() { 0.9 * error.max(1e-16).powf(-1.0 / ORDER) } else { 0.1 };
            if error <= 1.0 {
                y.copy_from_slice(&self.columns[0]);
                time = if last { span } else { time + step };
                let norm = escaped(y);
                if norm > REACH {
                    return Err(Halt::Escape { time, norm });
                }
                if !last {
                    f(y, &mut self.first);
                    if !self.first.iter().all(|x| x.is_finite()) {
                        return Err(Halt::Stall { time, step, steps });
                    }
                }
                h = step * factor.clamp(0.2, 4.0);
            } else {
                h = step * factor.clamp(0.1, 0.9);
            }
        }
        Err(Halt::Stall { time, step: h, steps: MAX_STEPS })
    }

    /// One step; the result is left in column 0, its error in units of the tolerance is returned (NaN if it is not
    /// finite).
    fn attempt(&mut self, f: &mut dyn FnMut(&[f64], &mut [f64]), step: f64, y: &[f64], scale: &[f64]) -> f64 {
        let mut error = f64::NAN;
        for (j, &substeps) in SUBSTEPS.iter().enumerate() {
            let h = step / substeps as f64;
            self.before.copy_from_slice(y);
            // Indices, not `zip`, which is a call for each entry at the optimisation of tests.
            let (first, now, before) = (&self.first[..y.len()], &mut self.now[..y.len()], &mut self.before[..y.len()]);
            for i in 0..y.len() {
                now[i] = y[i] + h * first[i];
            }
            for _ in 1..substeps {
                f(now, &mut self.slope);
                let slope = &self.slope[..y.len()];
                for i in 0..y.len() {
                    let next = before[i] + 2.0 * h * slope[i];
                    before[i] = std::mem::replace(&mut now[i], next);
                }
            }
            // Column c of row j overwrites what row j - 1 left there: columns[j - c] holds T(j, c).
            let row_before = j;
            self.columns[row_before].copy_from_slice(&self.now);
            let last = j + 1 == SUBSTEPS.len();
            for c in 1..=j {
                let ratio = (substeps as f64 / SUBSTEPS[j - c] as f64).powi(2) - 1.0;
                let (older, newer) = self.columns.split_at_mut(j - c + 1);
                let (older, newer) = (&mut older[j - c], &newer[0]);
                let mut worst = 0.0f64;
                for i in 0..y.len() {
                    let change = (newer[i] - older[i]) / ratio;
                    if last && c == j {
                        let size = scale[i] + y[i].abs();
                        // f64::max would drop a NaN.
                        let relative = (change / size).abs();
                        worst = if relative > worst || relative.is_nan() { relative } else { worst };
                    }
                    older[i] = newer[i] + change;
                }
                if last && c == j {
                    error = worst / self.tolerance;
                }
            }
        }
        error
    }
}
