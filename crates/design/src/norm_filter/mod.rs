//! H-infinity and H2 filters: linear observers whose error is small in a norm from disturbances and noise.
//!
//! `x' = A x + B u + E w`, `y = C x + D w`; of the error e of the observer with the gain L, the part `z = H e` counts.
//! With `F = A - LC`, `G = E - LD` the transfer function from w to z is `T(s) = H(sI - F)^-1 G`.
//!
//! | norm | what it bounds | optimum |
//! |---|---|---|
//! | H-infinity | the energy of z by `gamma^2` times that of w, whatever w is | by Riccati equation or inequality |
//! | H2 | the variance of z for white noise w of unit intensity | the Kalman filter |
//!
//! The Kalman filter is that of `W = EE'`, `V = DD' > 0` and the covariance `S = ED'` between them:
//! `L = L0 + S V^-1`, L0 the gain for `A - S V^-1 C` and `W - S V^-1 S'`. Whatever H is, no gain has a smaller H2 norm.
//! The H-infinity filter of a gamma is the central one of a Riccati equation (`equations.rs`), as long as the gain has
//! no bound and D has full row rank. Bounds of either norm are linear matrix inequalities in P and Y = P L, in discrete
//! time as well:
//! ```text
//! H-infinity   [he(PA - YC) + H'H, PE - YD; *, -gamma^2 I] < 0
//!              [P - H'H, 0, (PA - YC)'; *, gamma^2 I, (PE - YD)'; *, *, P] > 0                       discrete time
//! H2           [he(PA - YC), PE - YD; *, -I] < 0,    [Z, H; H', P] > 0,    tr Z < gamma^2
//!              [P, PA - YC, PE - YD; *, P, 0; *, *, I] > 0,    likewise                              discrete time
//! ```
//! They are solved in units in which a Kalman filter of this plant has covariances, noise and poles of about one, so
//! that the result does not depend on the units given (`units.rs`). A solution is a gain; that there is none is said
//! only with verified multipliers. The least value of such a program is that of a gain, which is not proved to be the
//! least.
//!
//! The least H-infinity norm is often approached by gains without bound only: the design for it finds the least gamma
//! of the equation by bisection, and takes a gamma that is larger by [`LEAST_NORM_EXCESS`]. The certificate of an H2
//! filter has the P of the observability Gramian, a little enlarged, so that its gamma can be as close to the norm as
//! one likes.
//!
//! Source: S. Boyd, L. El Ghaoui, E. Feron, V. Balakrishnan, Linear Matrix Inequalities in System and Control Theory,
//! SIAM 1994, sections 2.7 and 6.3; C. Scherer, P. Gahinet, M. Chilali, IEEE Transactions on Automatic Control 42,
//! 1997.

mod equations;
mod programs;
mod units;

use luenberger_linalg::{
    HInfinityNorm, LinalgError, discrete_h_infinity_norm, discrete_h2_norm, eigenvalues, h_infinity_norm, h2_norm,
    symmetric_part,
};
use luenberger_lmi::proof_matrix;
use luenberger_observers::{DiscreteLinearObserver, LinearObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::Verdict;
use luenberger_proof::certificate::{Certificate, FilterProblem, H2Filter, HInfinityFilter};
pub use luenberger_proof::statement::TimeDomain;
use nalgebra::{Complex, DMatrix, Dyn};

use crate::certificate::{certified, plant as matrices};
use crate::check;
use crate::error::DesignError;
use crate::gain_options::GainOptions;
use crate::lyapunov_choice::{Equation, coordinates};
use crate::powers::{Powers, shift};
use equations::CentralFilter;
use units::{Reference, Units};

/// By how much the gamma of the design for the least H-infinity norm exceeds it, relative.
pub const LEAST_NORM_EXCESS: f64 = 0.01;
/// By how much the certified bound exceeds the norm of a given gain, and of an H2 filter, relative; more only where
/// this bound of a given gain is not proved.
pub const NORM_BOUND_EXCESS: f64 = 1e-4;

/// How often the noise of the outputs is made smaller in the search for a gain.
const LEVELS: i32 = 13;

/// The norm of an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SystemNorm {
    /// The L2 gain: the peak of the largest singular value over all frequencies.
    HInfinity,
    /// The square root of the stationary variance of z under white noise of unit intensity.
    H2,
}

impl SystemNorm {
    /// `H-infinity` or `H2`.
    pub fn name(self) -> &'static str {
        match self {
            Self::HInfinity => "H-infinity",
            Self::H2 => "H2",
        }
    }
}

/// Disturbances `x' = A x + B u + E w`, `y = C x + D w` and performance output `z = H e` of a filter design.
#[derive(Debug, Clone, PartialEq)]
pub struct GeneralizedPlant {
    /// E, n x q.
    pub e: DMatrix<f64>,
    /// D, p x q.
    pub d: DMatrix<f64>,
    /// H, r x n.
    pub h: DMatrix<f64>,
}

/// Objective of the design.
#[derive(Debug, Clone, PartialEq)]
pub enum NormTarget {
    /// The least norm; for H-infinity larger by [`LEAST_NORM_EXCESS`].
    Least,
    /// A norm below this bound.
    Below(f64),
    /// The norm of this gain L, n x p.
    OfGain(DMatrix<f64>),
}

certified!(NormFilterDesign);

/// A linear observer with a bound of a norm of its error.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct NormFilterDesign {
    /// The plant.
    pub plant: StateSpace,
    /// The time domain of the plant.
    pub time: TimeDomain,
    /// The gain L, n x p.
    pub l: DMatrix<f64>,
    /// Eigenvalues of `A - L C`.
    pub poles: Vec<Complex<f64>>,
    /// P of the certificate.
    pub p: DMatrix<f64>,
    /// The norm of the transfer function from w to z, in floating point.
    pub norm: f64,
    /// The frequency at which the H-infinity norm is attained, in radians per unit of time; none for H2.
    pub frequency: Option<f64>,
    /// The certified bound: the norm is below gamma.
    pub gamma: f64,
    /// The least norm of any gain, to rounding: the H2 norm of the Kalman filter, where the design asked for it.
    pub least: Option<f64>,
    /// The smallest norm of a gain within the bound of the gain that was found, for a design for the least norm of
    /// which there is no formula. Smaller ones are not excluded.
    pub found: Option<f64>,
    /// The certificate.
    pub certificate: Certificate,
}

/// A plant in its time with what acts on it.
pub(crate) struct Task<'a> {
    pub(crate) time: TimeDomain,
    pub(crate) norm: SystemNorm,
    pub(crate) plant: &'a StateSpace,
    pub(crate) of: &'a GeneralizedPlant,
}

impl NormFilterDesign {
    /// The filter of this norm for a plant in continuous or in discrete time.
    ///
    /// `options` can bound the spectral norm of L ([`GainOptions::max_gain`]); its noise has no effect.
    ///
    /// ```
    /// use luenberger_design::{Certified, GainOptions, GeneralizedPlant, NormFilterDesign, NormTarget};
    /// use luenberger_design::{SystemNorm, TimeDomain};
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::{dmatrix, DMatrix};
    /// // x' = -x + w1, y = x + w2: F = -(1 + L), and the norm sqrt(1 + L^2)/(1 + L) is least, sqrt(1/2), at L = 1.
    /// let plant = StateSpace::new(dmatrix![-1.0], DMatrix::zeros(1, 0), dmatrix![1.0])?;
    /// let of = GeneralizedPlant { e: dmatrix![1.0, 0.0], d: dmatrix![0.0, 1.0], h: dmatrix![1.0] };
    /// let options = GainOptions::default();
    /// let filter = NormFilterDesign::new(&plant, TimeDomain::Continuous, SystemNorm::HInfinity, &of, &NormTarget::Least, &options)?;
    /// assert!((filter.found.unwrap() - 0.5f64.sqrt()).abs() < 1e-5);
    /// assert!(filter.certificate.is_proved() && filter.norm < filter.gamma && filter.gamma < 0.715);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// # Errors
    /// [`DesignError::NormTooSmall`] for a gamma that no gain keeps, with multipliers; [`DesignError::NormNotFound`]
    /// where neither a gain nor multipliers are found; for [`NormTarget::Least`] [`DesignError::NoiselessOutput`] where
    /// D has no full row rank and no bound of the gain is given, [`DesignError::NoDisturbance`] for `E = 0` and a stable
    /// A, whose least norm is 0, and [`LinalgError::NotExcited`] for the H2 norm if `E = 0` and A has an eigenvalue on
    /// the stability boundary: smaller and smaller gains then have smaller and smaller norms; a plant that is not detectable; shapes that do not
    /// fit; H = 0; a given gain that does not stabilise.
    pub fn new(
        plant: &StateSpace,
        time: TimeDomain,
        norm: SystemNorm,
        of: &GeneralizedPlant,
        goal: &NormTarget,
        options: &GainOptions,
    ) -> Result<Self, DesignError> {
        check::plant(plant)?;
        let (n, p, q) = (plant.a.nrows(), plant.c.nrows(), of.e.ncols());
        check::matrix("E", &of.e, (n, q))?;
        check::matrix("D", &of.d, (p, q))?;
        check::matrix("H", &of.h, (of.h.nrows(), n))?;
        if of.h.iter().all(|entry| *entry == 0.0) {
            return Err(DesignError::NotPositive {
                what: "the largest entry of H, of the errors z = H e,",
                value: 0.0,
            });
        }
        let task = Task { time, norm, plant, of };
        match goal {
            NormTarget::OfGain(l) => {
                check::matrix("L", l, (n, p))?;
                let found = task.measured(l)?;
                check::positive("the norm of the error", found.norm)?;
                // The norm is that of rounded matrices: a larger bound where this one is not proved.
                let certified = |excess: f64| {
                    let gamma = found.norm * (1.0 + excess);
                    task.certified(l.clone(), None, found.clone(), gamma)
                };
                let first = certified(NORM_BOUND_EXCESS);
                let is_proved = |design: &Result<Self, DesignError>| {
                    design.as_ref().is_ok_and(|design| design.certificate.is_proved())
                };
                if is_proved(&first) {
                    return first;
                }
                [1e-3, 1e-2, 1e-1].into_iter().map(certified).find(is_proved).unwrap_or(first)
            }
            NormTarget::Below(gamma) => {
                check::positive("gamma", *gamma)?;
                task.detectable()?;
                task.below(*gamma, options)
            }
            NormTarget::Least => {
                task.detectable()?;
                task.is_disturbed()?;
                if options.max_gain.is_none() {
                    task.every_output_is_noisy()?;
                }
                task.least(options)
            }
        }
    }

    /// The observer gain L, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        &self.l
    }

    /// The observer of a plant in continuous time.
    ///
    /// # Errors
    /// [`DesignError::OtherTimeDomain`] for a plant in discrete time; [`DesignError::Observer`].
    pub fn observer(&self) -> Result<LinearObserver<f64, Dyn, Dyn, Dyn>, DesignError> {
        if self.time == TimeDomain::Discrete {
            return Err(DesignError::OtherTimeDomain { designed: "discrete" });
        }
        Ok(LinearObserver::of(self.plant.clone(), self.l.clone())?)
    }

    /// The observer of a plant in discrete time with this period.
    ///
    /// # Errors
    /// [`DesignError::OtherTimeDomain`] for a plant in continuous time; [`DesignError::Observer`] for the period.
    pub fn discrete_observer(&self, period: f64) -> Result<DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>, DesignError> {
        if self.time == TimeDomain::Continuous {
            return Err(DesignError::OtherTimeDomain { designed: "continuous" });
        }
        Ok(DiscreteLinearObserver::new(self.plant.clone(), self.l.clone(), period)?)
    }
}

/// The norm of a gain, with its peak and the eigenvalues of `A - L C`.
#[derive(Clone)]
struct Measured {
    poles: Vec<Complex<f64>>,
    norm: f64,
    frequency: Option<f64>,
}

impl Task<'_> {
    fn flow(&self, l: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
        (&self.plant.a - l * &self.plant.c, &self.of.e - l * &self.of.d)
    }

    fn detectable(&self) -> Result<(), DesignError> {
        check::detectable_in(self.time, &self.plant.a, &self.plant.c)
    }

    /// Whether `E = 0` leaves a least norm to be found.
    fn is_disturbed(&self) -> Result<(), DesignError> {
        if self.of.e.iter().any(|entry| *entry != 0.0) {
            return Ok(());
        }
        let a = &self.plant.a;
        let distance = |pole: &Complex<f64>| match self.time {
            TimeDomain::Continuous => -pole.re,
            TimeDomain::Discrete => 1.0 - pole.norm(),
        };
        let poles = eigenvalues(a)?;
        let Some(nearest) = poles.iter().min_by(|x, y| distance(x).total_cmp(&distance(y))) else { return Ok(()) };
        // The rounding of an eigenvalue.
        let size = if self.time == TimeDomain::Discrete { a.norm().max(1.0) } else { a.norm() };
        let rounding = a.nrows() as f64 * f64::EPSILON * size;
        if distance(nearest) > rounding {
            return Err(DesignError::NoDisturbance { norm: self.norm.name() });
        }
        if self.norm == SystemNorm::H2 && distance(nearest) >= -rounding {
            return Err(LinalgError::NotExcited { eigenvalue: *nearest, margin: 0.0 }.into());
        }
        Ok(())
    }

    /// D has full row rank: else the least norm is approached by gains without bound.
    fn every_output_is_noisy(&self) -> Result<(), DesignError> {
        let d = &self.of.d;
        // Whatever the units of the outputs are: of rows of length one.
        let rows = DMatrix::from_fn(d.nrows(), d.ncols(), |i, j| d[(i, j)] / d.row(i).norm().max(f64::MIN_POSITIVE));
        let sigma_min = if d.ncols() < d.nrows() { 0.0 } else { rows.svd(false, false).singular_values.min() };
        if sigma_min > d.ncols() as f64 * f64::EPSILON {
            return Ok(());
        }
        Err(DesignError::NoiselessOutput { outputs: d.nrows(), sigma_min })
    }

    /// The norm of a gain that stabilises.
    fn measured(&self, l: &DMatrix<f64>) -> Result<Measured, DesignError> {
        let (f, g) = self.flow(l);
        let h = &self.of.h;
        let poles = eigenvalues(&f)?;
        let pair = (&self.plant.a, l, &self.plant.c);
        match self.time {
            TimeDomain::Continuous => check::stable_poles("A - L C", &poles, pair)?,
            TimeDomain::Discrete => {
                let radius = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
                check::schur_stable("A - L C", (radius, true), pair)?;
            }
        }
        // The norm is the same in all coordinates of the state, its rounding is not.
        let units = coordinates(self.time, &f).pop().unwrap_or_else(|| Powers::given(f.nrows()));
        let (f, g, h) = (&units.similar(&f), &units.rows(&g), &units.columns(h));
        let (norm, frequency) = match (self.norm, self.time) {
            (SystemNorm::H2, TimeDomain::Continuous) => (h2_norm(f, g, h)?, None),
            (SystemNorm::H2, TimeDomain::Discrete) => (discrete_h2_norm(f, g, h)?, None),
            (SystemNorm::HInfinity, time) => {
                let found = peak(time, f, g, h)?;
                (found.norm, Some(found.frequency))
            }
        };
        Ok(Measured { poles, norm, frequency })
    }

    /// The design for the least norm: the Kalman filter, or what the program finds.
    fn least(&self, options: &GainOptions) -> Result<NormFilterDesign, DesignError> {
        if self.norm == SystemNorm::H2
            && options.max_gain.is_none()
            && let Some(optimal) = self.kalman(None)
            && let Ok(found) = self.measured(&optimal.l)
        {
            let (least, gamma) = (found.norm, found.norm * (1.0 + NORM_BOUND_EXCESS));
            let design = self.certified(optimal.l, None, found, gamma)?;
            return Ok(NormFilterDesign { least: Some(least), ..design });
        }
        if self.norm == SystemNorm::HInfinity
            && options.max_gain.is_none()
            && let Some(filter) = self.kalman(None)
            && let Ok(kalman) = self.measured(&filter.l)
            && let Some(found) = self.least_central(kalman.norm)
        {
            let design = self.below(found * (1.0 + LEAST_NORM_EXCESS), options)?;
            return Ok(NormFilterDesign { found: Some(found), ..design });
        }
        let candidates = self.candidates(f64::INFINITY, options);
        let best = candidates.iter().min_by(|x, y| x.found.norm.total_cmp(&y.found.norm));
        let reference = if best.is_none() { self.reference() } else { None };
        let units = Units::of(self, best.or(reference.as_ref()).map(|best| (&best.of, best.found.norm)));
        let (found, gain) = match (self.least_value(&units, options), best) {
            (Ok(found), _) => found,
            (Err(_), Some(best)) => (best.found.norm, best.of.l.clone()),
            (Err(error), None) => return Err(error),
        };
        let design = match self.norm {
            SystemNorm::HInfinity => self.below(found * (1.0 + LEAST_NORM_EXCESS), options)?,
            SystemNorm::H2 => {
                let measured = self.measured(&gain)?;
                let gamma = measured.norm * (1.0 + NORM_BOUND_EXCESS);
                self.certified(gain, None, measured, gamma)?
            }
        };
        Ok(NormFilterDesign { found: Some(found), ..design })
    }

    /// The gains of Kalman filters for this noise and for noise that is smaller and smaller, up to the first with a
    /// norm below gamma, of those within the bound of the gain.
    fn candidates(&self, gamma: f64, options: &GainOptions) -> Vec<Candidate> {
        let mut all = Vec::new();
        for level in std::iter::once(None).chain((0..LEVELS).map(Some)) {
            let Some(of) = self.kalman(level) else { continue };
            let is_allowed =
                options.max_gain.is_none_or(|bound| of.l.clone().svd(false, false).singular_values.max() <= bound);
            let Some(found) = self.measured(&of.l).ok().filter(|found| is_allowed && found.norm.is_finite()) else {
                continue;
            };
            let is_last = found.norm < gamma;
            all.push(Candidate { of, found });
            if is_last {
                break;
            }
        }
        all
    }

    /// The first Kalman filter that has a norm, within the bound of the gain or not: its units are those of the plant.
    fn reference(&self) -> Option<Candidate> {
        self.candidates(f64::INFINITY, &GainOptions::default()).into_iter().next()
    }

    /// The design for a bound.
    fn below(&self, gamma: f64, options: &GainOptions) -> Result<NormFilterDesign, DesignError> {
        if self.norm == SystemNorm::HInfinity
            && options.max_gain.is_none()
            && let Some(CentralFilter { l, p, found, certificate }) = self.central_filter(gamma)
        {
            return Ok(self.design(l, p, found, gamma, certificate));
        }
        let candidates = self.candidates(gamma, options);
        let best = candidates.into_iter().min_by(|x, y| x.found.norm.total_cmp(&y.found.norm));
        let reference = if best.is_none() { self.reference() } else { None };
        let units = Units::of(self, best.as_ref().or(reference.as_ref()).map(|best| (&best.of, gamma)));
        let solved = self.gain_below(gamma, &units, options)?;
        if let Ok((l, p)) = &solved
            && let Ok(found) = self.measured(l)
            && found.norm < gamma
        {
            let design = self.certified(l.clone(), Some(p), found, gamma)?;
            if design.certificate.is_proved() {
                return Ok(design);
            }
        }
        let best = match best {
            Some(Candidate { of, found }) if found.norm < gamma => return self.certified(of.l, None, found, gamma),
            best => best.map(|best| best.found.norm),
        };
        let programmed = self.least_value(&units, options).ok().map(|(value, _)| value);
        let best = best.into_iter().chain(programmed).min_by(f64::total_cmp);
        let norm = self.norm.name();
        // The bound of the gain is a sufficient condition: its multipliers would not exclude a gain.
        let verdict = match (solved, options.max_gain) {
            (Err(verdict), None) => Some(verdict),
            (_, Some(_)) => self.gain_below(gamma, &units, &GainOptions::from(options.settings))?.err(),
            (Ok(_), None) => None,
        };
        let is_limited = options.max_gain.is_some();
        Err(match verdict {
            Some(Verdict::Refuted { witness }) => DesignError::NormTooSmall { norm, gamma, best, witness },
            Some(Verdict::Undecided { why, .. }) => {
                DesignError::NormNotFound { norm, gamma, best, is_limited, why: Some(why) }
            }
            _ => DesignError::NormNotFound { norm, gamma, best, is_limited, why: None },
        })
    }

    /// `p` is the P of an H-infinity norm below gamma, if it is known.
    fn certified(
        &self,
        l: DMatrix<f64>,
        p: Option<&DMatrix<f64>>,
        found: Measured,
        gamma: f64,
    ) -> Result<NormFilterDesign, DesignError> {
        let (p, certificate) = match (self.norm, p) {
            (SystemNorm::H2, _) => self.with_gramian(&l, gamma)?,
            (SystemNorm::HInfinity, Some(p)) => (p.clone(), self.theorem(&l, p, gamma)?),
            (SystemNorm::HInfinity, None) => {
                if let Some(proved) = self.stored(&l, gamma) {
                    proved
                } else {
                    let p = self.storage(&l, gamma)?;
                    let certificate = self.theorem(&l, &p, gamma)?;
                    (p, certificate)
                }
            }
        };
        Ok(self.design(l, p, found, gamma, certificate))
    }

    fn design(
        &self,
        l: DMatrix<f64>,
        p: DMatrix<f64>,
        found: Measured,
        gamma: f64,
        certificate: Certificate,
    ) -> NormFilterDesign {
        let Measured { poles, norm, frequency } = found;
        let (plant, time) = (self.plant.clone(), self.time);
        NormFilterDesign { plant, time, l, poles, p, norm, frequency, gamma, least: None, found: None, certificate }
    }

    /// The bound of the norm, decided for these numbers.
    fn theorem(&self, l: &DMatrix<f64>, p: &DMatrix<f64>, gamma: f64) -> Result<Certificate, DesignError> {
        let StateSpace { a, b, c, .. } = self.plant;
        let problem = FilterProblem {
            time: self.time,
            plant: matrices((a, b, c)),
            e: proof_matrix(&self.of.e),
            d: proof_matrix(&self.of.d),
            h: proof_matrix(&self.of.h),
            l: proof_matrix(l),
            p: proof_matrix(p),
            gamma,
        };
        Ok(match self.norm {
            SystemNorm::HInfinity => Certificate::of([HInfinityFilter(problem)])?,
            SystemNorm::H2 => Certificate::of([H2Filter(problem)])?,
        })
    }

    /// `P = W + s V` with the Gramians of H and of the identity in some coordinates, and s for half of the room that
    /// gamma leaves: the first that is proved, or the one in the coordinates of the user.
    fn with_gramian(&self, l: &DMatrix<f64>, gamma: f64) -> Result<(DMatrix<f64>, Certificate), DesignError> {
        let f = check::closed_loop((&self.plant.a, l, &self.plant.c))?;
        let (_, g) = self.flow(l);
        let spent = |w: &DMatrix<f64>| (g.transpose() * w * &g).trace();
        let mut first = None;
        for units in std::iter::once(Powers::given(f.nrows())).chain(coordinates(self.time, &f)) {
            for slower in [false, true] {
                let of_h = Equation::new(self.time, &f, &units, false).and_then(|mut of| of.of_output(&self.of.h));
                let of_all = Equation::new(self.time, &f, &units, slower).and_then(|mut of| of.of_identity());
                let (Some(of_h), Some(of_all)) = (of_h, of_all) else { continue };
                let room = (gamma * gamma - spent(&of_h)).max(0.0);
                let spent_by_all = spent(&of_all);
                // Without a disturbance any share leaves room.
                let share = if spent_by_all > 0.0 { 0.5 * room / spent_by_all } else { of_h.norm() / of_all.norm() };
                let p = symmetric_part(&(of_h + of_all * share));
                let Ok(certificate) = self.theorem(l, &p, gamma) else { continue };
                if certificate.is_proved() {
                    return Ok((p, certificate));
                }
                first.get_or_insert((p, certificate));
            }
        }
        first.ok_or(DesignError::StabilityUndecided {
            what: "A - L C",
            size: eigenvalues(&f)?.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max),
            limit: 0.0,
        })
    }
}

/// The H-infinity norm and its frequency, in units of time, states and errors in which all terms are of the size 1.
fn peak(time: TimeDomain, f: &DMatrix<f64>, g: &DMatrix<f64>, h: &DMatrix<f64>) -> Result<HInfinityNorm, DesignError> {
    let none = DMatrix::zeros(h.nrows(), g.ncols());
    let norm = |f: &DMatrix<f64>, g: &DMatrix<f64>, h: &DMatrix<f64>| match time {
        TimeDomain::Continuous => h_infinity_norm(f, g, h, &none),
        TimeDomain::Discrete => discrete_h_infinity_norm(f, g, h, &none),
    };
    let power = |x: f64| if x > 0.0 && x.is_finite() { x.log2().round() as i32 } else { 0 };
    let times = |m: &DMatrix<f64>, by: i32| m.map(|x| shift(x, by));
    let rough = norm(f, g, h)?;
    let tau = if time == TimeDomain::Continuous { -power(f.norm()) } else { 0 };
    let size = power(rough.norm);
    let state = i32::midpoint(power(g.norm()) + tau, size - power(h.norm()));
    Ok(match norm(&times(f, tau), &times(g, tau - state), &times(h, state - size)) {
        Ok(fine) if shift(fine.norm, size) > rough.norm => {
            HInfinityNorm { norm: shift(fine.norm, size), frequency: shift(fine.frequency, tau) }
        }
        _ => rough,
    })
}

/// A gain with its norm.
struct Candidate {
    of: Reference,
    found: Measured,
}
