//! Sampled observers at varying periods with consecutive missed samples: jitter and dropouts.
//!
//! The observer corrects with a fixed gain, `xhat+ = xhat + K (y - C xhat)`, at every sample that it gets, and predicts
//! over the time that really passes. From one correction to the next the error obeys `e+ = exp(A t)(I - K C) e`, where
//! t is a sum of one to `misses + 1` periods. One P with
//!
//! ```text
//! (I - KC)'exp(A t)'P exp(A t)(I - KC) < factor^2 P        for every such t
//! ```
//!
//! proves convergence for all sequences of periods and misses. P comes from linear matrix inequalities on a grid of
//! times with the smallest factor found by bisection; that it serves all times between is proved on cells that cover
//! them (`statement::decrease_over_times`). A cubic term made for the same P does not increase V: see
//! [`sampled`](crate::sampled).
//!
//! A common quadratic V is sufficient, and necessary only for single times: where none is found, a product of the maps
//! with a spectral radius above 1 is sought, which refutes convergence; and smaller ranges of periods are tried.

use luenberger_linalg::{RealMatrixView, expm, spectral_radius};
use luenberger_lmi::{Problem, greatest_parameter, proof_matrix};
use luenberger_observers::VaryingPeriodObserver;
use luenberger_proof::certificate::{Certificate, CubicStep, MOST_MISSES, VaryingPeriodConvergence};
use nalgebra::{DMatrix, Dyn};

use crate::certificate::{certified, plant as matrices};
use crate::check;
use crate::cubic::CubicGain;
use crate::error::DesignError;
use crate::linear::LinearDesign;
use crate::periods::{GrowingTimes, Periods};
use crate::sampled::SampledCubicDesign;

certified!(VaryingPeriodDesign);

/// Times of each number of periods at which the inequality is posed; on a grid four times as fine P is tried.
const GRID: usize = 5;

/// How often the interval of periods is halved in the search for the largest that is proved.
const HALVINGS: usize = 6;

/// A sampled cubic observer whose convergence is proved at varying periods, with its evidence.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct VaryingPeriodDesign {
    /// The observer that corrects at the samples that arrive, and predicts over the time that passes.
    pub observer: VaryingPeriodObserver<f64, Dyn, Dyn, Dyn>,
    /// The observer at its nominal period, with the cubic gain made for the common P.
    pub nominal: SampledCubicDesign,
    /// The gain K of the correction, n x p: `Ld = Ad K` at the nominal period.
    pub k: DMatrix<f64>,
    /// Bounds of the periods, and the largest number of consecutive missed samples.
    pub periods: Periods,
    /// `sqrt(e'Pe)` falls by this factor from correction to correction (without the semi-implicit step).
    pub factor: f64,
    /// The certificate: convergence at varying periods, then at the nominal one.
    pub certificate: Certificate,
}

impl VaryingPeriodDesign {
    /// The observer of [`SampledCubicDesign::with_cubic_gain`] with period h, whose correction gain serves all
    /// `periods`.
    ///
    /// ```
    /// use luenberger_design::{CubicGain, LinearDesign, Periods, VaryingPeriodDesign};
    /// use nalgebra::dmatrix;
    ///
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let linear = LinearDesign::with_poles(&plant, &[-2.0, -5.0])?;
    /// let periods = Periods { shortest: 0.08, longest: 0.13, misses: 1 };
    /// let design = VaryingPeriodDesign::new(&linear, &dmatrix![1.0], &CubicGain::Radial(10.0), 0.1, &periods)?;
    /// assert!(design.certificate.is_proved() && design.factor < 1.0);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// As [`SampledCubicDesign::with_cubic_gain`]; [`DesignError::Setting`] for periods that are not in order, or do
    /// not contain h; [`DesignError::VaryingPeriods`] if nothing is proved, with times for which the error grows, if
    /// some were found, and smaller bounds for which convergence is proved; [`DesignError::Observer`] for a plant too
    /// fast to be predicted over the longest time.
    pub fn new<'a>(
        linear: &LinearDesign,
        theta: impl Into<RealMatrixView<'a>>,
        cubic_gain: &CubicGain,
        h: f64,
        periods: &Periods,
    ) -> Result<Self, DesignError> {
        check_periods(h, periods)?;
        let first = SampledCubicDesign::with_cubic_gain(linear, theta, cubic_gain, h)?;
        Self::of(&first, linear, cubic_gain, h, periods)
    }

    fn of(
        first: &SampledCubicDesign,
        linear: &LinearDesign,
        cubic_gain: &CubicGain,
        h: f64,
        periods: &Periods,
    ) -> Result<Self, DesignError> {
        let o = &first.observer;
        let k = correction_gain(o.ad(), o.ld())?;
        let maps = Maps { a: &linear.observer.a, after: DMatrix::identity(k.nrows(), k.nrows()) - &k * o.c() };
        let Some((p, factor)) = maps.common_lyapunov(periods)? else { return Err(maps.refusal(h, periods)?) };
        // N = -P^-1 C'S depends on the scale of P: that of the design at the nominal period.
        let p = &p * (first.p.trace() / p.trace());
        let nominal = first.with_lyapunov(&p, cubic_gain)?;
        let o = &nominal.observer;
        let (n, weight) = (proof_matrix(o.n()), proof_matrix(o.theta()));
        let step = match cubic_gain {
            CubicGain::Radial(w) => CubicStep::Radial { n, theta: weight, w: *w },
            CubicGain::Gamma(_) | CubicGain::General(_) => {
                CubicStep::SemiImplicit { n, theta: weight, s: proof_matrix(&nominal.s) }
            }
        };
        let plant = &linear.observer;
        let longest = (periods.misses + 1) as f64 * periods.longest;
        let (a, b) = (plant.a.clone(), plant.b.clone());
        let observer = VaryingPeriodObserver::new(nominal.observer.clone(), a, b, k.clone(), longest)?;
        let theorem = VaryingPeriodConvergence {
            plant: matrices((&plant.a, &plant.b, &plant.c)),
            k: proof_matrix(&k),
            step,
            shortest: periods.shortest,
            longest: periods.longest,
            misses: periods.misses,
            p: proof_matrix(&p),
            factor,
        };
        let certificate = Certificate::of([theorem])?.and(nominal.certificate.clone());
        Ok(Self { certificate, observer, nominal, k, periods: *periods, factor })
    }
}

/// The theorem of the linear observer with the correction gain K (n x p) at these periods: `P > 0` and the decrease at
/// every time, with the smallest factor that was found.
///
/// # Errors
/// [`DesignError::Setting`] for periods that are not in order; [`DesignError::VaryingPeriods`] if no P is found.
pub fn at_varying_periods<'a>(
    plant: &luenberger_plants::StateSpace,
    k: impl Into<RealMatrixView<'a>>,
    periods: &Periods,
) -> Result<VaryingPeriodConvergence, DesignError> {
    let k = &check::owned(k);
    check::plant(plant)?;
    let (n, p) = (plant.a.nrows(), plant.c.nrows());
    check::matrix("K", k, (n, p))?;
    check_periods(periods.shortest, periods)?;
    let maps = Maps { a: &plant.a, after: DMatrix::identity(n, n) - k * &plant.c };
    let Some((p, factor)) = maps.common_lyapunov(periods)? else {
        return Err(maps.refusal(0.5 * (periods.shortest + periods.longest), periods)?);
    };
    Ok(VaryingPeriodConvergence {
        plant: matrices((&plant.a, &plant.b, &plant.c)),
        k: proof_matrix(k),
        step: CubicStep::Linear,
        shortest: periods.shortest,
        longest: periods.longest,
        misses: periods.misses,
        p: proof_matrix(&p),
        factor,
    })
}

fn check_periods(h: f64, periods: &Periods) -> Result<(), DesignError> {
    check::positive("the shortest period", periods.shortest)?;
    check::positive("the sampling period h", h)?;
    let within = |what, value, least, most| {
        if (least..=most).contains(&value) { Ok(()) } else { Err(DesignError::Setting { what, value, least, most }) }
    };
    within("the longest period", periods.longest, periods.shortest, f64::MAX)?;
    within("the nominal period", h, periods.shortest, periods.longest)?;
    within("the number of missed samples", periods.misses as f64, 0.0, MOST_MISSES as f64)
}

/// K of `Ld = Ad K`.
fn correction_gain(ad: &DMatrix<f64>, ld: &DMatrix<f64>) -> Result<DMatrix<f64>, DesignError> {
    // The exponential of a matrix is invertible.
    match ad.clone().lu().solve(ld) {
        Some(k) if k.iter().all(|x| x.is_finite()) => Ok(k),
        _ => Err(DesignError::NotPositive { what: "the determinant of Ad", value: 0.0 }),
    }
}

/// The maps of the error from correction to correction.
struct Maps<'a> {
    a: &'a DMatrix<f64>,
    /// `I - K C`.
    after: DMatrix<f64>,
}

impl Maps<'_> {
    /// `exp(A t)(I - KC)`.
    fn at(&self, t: f64) -> Result<DMatrix<f64>, DesignError> {
        Ok(expm(&(self.a * t))? * &self.after)
    }

    /// Times of all numbers of periods, `points` of each, and the maps at them.
    fn grid(&self, periods: &Periods, points: usize) -> Result<Vec<(f64, DMatrix<f64>)>, DesignError> {
        let Periods { shortest, longest, misses } = *periods;
        let points = if longest > shortest { points } else { 1 };
        let mut grid = Vec::with_capacity((misses + 1) * points);
        for count in 1..=misses + 1 {
            for k in 0..points {
                let share = if points > 1 { k as f64 / (points - 1) as f64 } else { 0.0 };
                let t = count as f64 * (shortest + share * (longest - shortest));
                grid.push((t, self.at(t)?));
            }
        }
        Ok(grid)
    }

    /// P and a factor below 1 that it has on a fine grid, with some room; none if there is no P on a coarse one.
    fn common_lyapunov(&self, periods: &Periods) -> Result<Option<(DMatrix<f64>, f64)>, DesignError> {
        let maps = self.grid(periods, GRID)?;
        let mut largest = 0.0_f64;
        for (_, map) in &maps {
            largest = largest.max(spectral_radius(map)?);
        }
        if largest >= 1.0 {
            return Ok(None);
        }
        let family = |share: f64| {
            let square = (1.0 - share * (1.0 - largest)).powi(2);
            let mut lmi = Problem::new();
            let p = lmi.symmetric("P", self.a.nrows());
            lmi.constrain("P > 0", &p >> 0.0);
            for (k, (_, map)) in maps.iter().enumerate() {
                let next = map.transpose() * (&p * map);
                lmi.constrain(&format!("decrease at time {}", k + 1), (next - square * &p) << 0.0);
            }
            lmi
        };
        let found = greatest_parameter(0.02, 1.0, 0.05, family)?.proved;
        let Some((share, _)) = found else { return Ok(None) };
        // Away from the boundary P is better conditioned.
        let solution = family(0.8 * share).solve()?;
        let Some(p) = solution.named("P").filter(|_| solution.verdict.is_proved()) else { return Ok(None) };
        let p = p / p.amax();
        let Some(root) = p.clone().cholesky().map(|factor| factor.l().transpose()) else { return Ok(None) };
        let Some(inverse) = root.clone().try_inverse() else { return Ok(None) };
        let mut factor = 0.0_f64;
        for (_, map) in self.grid(periods, 4 * GRID)? {
            factor = factor.max((&root * map * &inverse).svd(false, false).singular_values.max());
        }
        Ok((factor < 1.0).then_some((p, factor + 0.1 * (1.0 - factor))))
    }

    /// Whether convergence at these periods is proved, for the linear correction.
    fn is_proved(&self, periods: &Periods) -> Result<bool, DesignError> {
        let Some((p, factor)) = self.common_lyapunov(periods)? else { return Ok(false) };
        let (a, p) = (proof_matrix(self.a), proof_matrix(&p));
        let map = proof_matrix(&self.after).map(|x| luenberger_proof::Interval::of(*x));
        for count in 1..=periods.misses + 1 {
            let times = (count as f64 * periods.shortest, count as f64 * periods.longest);
            if !luenberger_proof::statement::decrease_over_times(&a, &map, &p, factor, times)?.is_proved() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Why nothing is proved, and what is.
    fn refusal(&self, h: f64, periods: &Periods) -> Result<DesignError, DesignError> {
        let witness = self.growing(periods)?;
        let mut largest = None;
        for misses in (0..=periods.misses).rev() {
            let (mut low, mut high) = (0.0, 1.0);
            let shrunk = |share: f64| Periods {
                shortest: h - share * (h - periods.shortest),
                longest: h + share * (periods.longest - h),
                misses,
            };
            if misses < periods.misses && self.is_proved(&shrunk(1.0))? {
                largest = Some(shrunk(1.0));
                break;
            }
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if self.is_proved(&shrunk(middle))? {
                    (low, largest) = (middle, Some(shrunk(middle)));
                } else {
                    high = middle;
                }
            }
            if largest.is_some() {
                break;
            }
        }
        Ok(DesignError::VaryingPeriods { periods: Box::new(*periods), witness, largest: largest.map(Box::new) })
    }

    /// Times between corrections whose maps have a product that grows: one time, two, or three of the extreme ones.
    fn growing(&self, periods: &Periods) -> Result<Option<GrowingTimes>, DesignError> {
        let found = |times: &[f64], product: &DMatrix<f64>| {
            let radius = spectral_radius(product).unwrap_or(0.0);
            (radius > 1.0 + 1e-6).then(|| GrowingTimes { times: times.to_vec(), radius })
        };
        let grid = self.grid(periods, 4 * GRID)?;
        for (t, map) in &grid {
            if let Some(growing) = found(&[*t], map) {
                return Ok(Some(growing));
            }
        }
        let coarse = self.grid(periods, GRID)?;
        for (t, map) in &coarse {
            for (s, other) in &coarse {
                if let Some(growing) = found(&[*t, *s], &(other * map)) {
                    return Ok(Some(growing));
                }
            }
        }
        let extreme = self.grid(periods, 2)?;
        for (t, map) in &extreme {
            for (s, other) in &extreme {
                for (r, last) in &extreme {
                    if let Some(growing) = found(&[*t, *s, *r], &(last * other * map)) {
                        return Ok(Some(growing));
                    }
                }
            }
        }
        Ok(None)
    }
}
