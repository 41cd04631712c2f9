//! Checks a user-supplied Kazantzis-Kravaris-Luenberger observer: the equation for phi, the stability of Lambda, the
//! injectivity of (phi, h).
//!
//! Proposition 1 of Yi, Ortega and Zhang asks for phi, Lambda and B with
//! ```text
//!     Dphi(x) f(x, u) = Lambda phi(x) + B(h(x), u)          (4)          Lambda Hurwitz, (phi, h) injective
//! ```
//! There is no general method to find them; they are derived by hand, which is error-prone. [`KklCandidate`] takes the
//! plant and the maps as implemented, and checks them over a box of states and inputs:
//!
//! | question | measured | decided |
//! |---|---|---|
//! | (4) | the largest residual over evenly spread points, relative to its terms | bounded on the box by intervals; refuted at a point |
//! | Lambda Hurwitz | eigenvalues | a Lyapunov matrix for every Lambda over the box, by `luenberger-proof` |
//! | B in cascade | - | proved of the derivatives of B by xi, for all xi; refuted where one that has to be 0 is not |
//! | (phi, h) injective | ratios over pairs, singular values | proved by one matrix for all mean Jacobians; refuted by two states whose images coincide, verified |
//! | phi^L(phi(x), h(x)) = x | the largest difference | - |
//!
//! The proofs are statements about real arithmetic with the constants stored in plant and maps, on the box, and where
//! both are smooth. phi is [`KklMap::image`] of the states that the map estimates. Lambda may depend on t, u and y; B
//! may depend on xi in cascade form, and is evaluated at `xi = phi(x)` in (4). Maps and plant are assumed to be pure
//! functions of their arguments: the same operations for every scalar, and no state kept between evaluations.
//!
//! Maps and plant are evaluated over two scalars, [`IntervalDual`] and [`SymbolicPolynomial`], in which the two sides
//! of (4) cancel before they are enclosed; hence they must be generic over the scalar.
//!
//! | file | subject |
//! |---|---|
//! | `candidate` | plant and maps over any scalar |
//! | `residual` | (4) over the box |
//! | `stability` | Lambda over the box |
//! | `coupling` | B as a function of xi |
//! | `attractivity` | Jacobians of the distance of an immersion-and-invariance observer from its manifold |
//! | `injectivity`, `images`, `common_image` | (phi, h) over the box; two states with one image |
//! | `witness`, `error` | witnesses of failed checks; errors |
//!
//! Source: B. Yi, R. Ortega and W. Zhang, IEEE Transactions on Automatic Control, 2018, Propositions 1 and 3.

mod attractivity;
mod bound;
mod candidate;
mod common_image;
mod coupling;
mod error;
mod images;
mod injectivity;
mod residual;
pub(crate) mod stability;
mod witness;

use core::fmt;

use luenberger_observers::kkl::{KklMap, KklObserver, KklSize};
use luenberger_plants::{Dimensions, Plant};
use luenberger_proof::wording::at_most;
use luenberger_proof::{Interval, Matrix, Ring, Verdict};
use luenberger_random::{Purpose, Stream};
use luenberger_wording::setters;
use nalgebra::DefaultAllocator;

use crate::check::within;
use crate::enclosure::paths::explore;
use crate::enclosure::{Axis, IntervalDual, Region};
use crate::golden_sequence::GoldenSequence;
use crate::number::short;
use crate::symbolic_polynomial::{SymbolicPolynomial, collect, evaluate};
use candidate::still;

pub use attractivity::{Attractivity, attractivity};
pub use bound::error_bound;
pub use candidate::{KklCandidate, Pieces};
pub use coupling::Coupling;
pub use error::KklError;
pub use injectivity::Injectivity;
pub use residual::Residual;
pub use stability::Stability;
pub use witness::{
    BoxPoint, CommonImage, CouplingObjection, CouplingWitness, OpenCoupling, ResidualWitness, TwoStates,
};

/// How a candidate is checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KklSettings {
    /// The residual may be this share of its terms, 0 to 1 (default the root of EPSILON). A phi in closed form is far
    /// below it, and so is one whose coefficients come from a well-posed Sylvester equation; a coefficient with four
    /// printed digits is far above.
    pub tolerance: f64,
    /// Points sampled beside the corners and the centre, 1 to 4096 (default 256). Pairs are formed of all of them.
    pub samples: usize,
    /// Where the sequence of points begins.
    pub seed: u64,
}

impl Default for KklSettings {
    fn default() -> Self {
        Self { tolerance: f64::EPSILON.sqrt(), samples: 256, seed: 0 }
    }
}

impl KklSettings {
    setters! { tolerance: f64, samples: usize, seed: u64 }
}

/// Results of the checks of a candidate.
#[derive(Clone, Debug, PartialEq)]
pub struct KklReport {
    /// The residual of (4).
    pub residual: Residual,
    /// The stability of Lambda.
    pub stability: Stability,
    /// Of B as a function of xi: whether it leaves the decay of the error to Lambda.
    pub coupling: Coupling,
    /// The injectivity of (phi, h).
    pub injectivity: Injectivity,
    /// The largest difference between `phi^L(phi(x), h(x))` and the estimated states over the samples, in half-widths
    /// of the box, and where; an error with the first sample at which phi^L has no finite value.
    pub left_inverse: Result<(f64, BoxPoint), BoxPoint>,
}

impl<S, K> KklCandidate<'_, S, K> {
    /// All checks of the candidate on `region`, whose states and inputs must be bounded. A candidate that fails a check
    /// gives a report, not an error.
    ///
    /// Proposition 6's plant `x1' = -x1^3 + exp x3, x2' = -x2 + x1^2 + sin x1, x3' = 1/(x1^2 + 1) + x1 u`, and its phi
    /// = (x2, x3):
    /// ```
    /// use luenberger_design::{KklCandidate, Region, kkl::KklSettings};
    /// use luenberger_observers::KklMap;
    /// use luenberger_plants::ExponentialCascade;
    /// use nalgebra::{Matrix2, RealField, U1, U2, Vector1, Vector2};
    ///
    /// struct Sixth;
    /// impl<T: RealField + Copy> KklMap<T> for Sixth {
    ///     type Xi = U2;
    ///     type Inputs = U1;
    ///     type Outputs = U1;
    ///     type Estimate = U2;
    ///     fn lambda(&self, _t: T, _u: &Vector1<T>, _y: &Vector1<T>) -> Matrix2<T> {
    ///         Matrix2::from_diagonal(&Vector2::new(-T::one(), T::zero()))
    ///     }
    ///     fn injection(&self, _t: T, _xi: &Vector2<T>, u: &Vector1<T>, y: &Vector1<T>) -> Vector2<T> {
    ///         let square = y[0] * y[0];
    ///         Vector2::new(square + y[0].sin(), u[0] * y[0] + T::one() / (square + T::one()))
    ///     }
    ///     fn left_inverse(&self, _t: T, xi: &Vector2<T>, _y: &Vector1<T>) -> Vector2<T> {
    ///         *xi
    ///     }
    ///     fn image(&self, _t: T, xhat: &Vector2<T>, _y: &Vector1<T>) -> Vector2<T> {
    ///         *xhat
    ///     }
    /// }
    ///
    /// let candidate = KklCandidate::new(&ExponentialCascade, &Sixth, &[1, 2])?;
    /// let region = Region::new(&[(-2.0, 2.0), (-2.0, 2.0), (-1.0, 1.0)]).inputs(&[(-3.0, 3.0)]);
    /// let report = candidate.check(&region, &KklSettings::default())?;
    /// assert_eq!(report.residual.bounds, [0.0, 0.0]);
    /// assert!(report.residual.verdict.is_proved() && report.injectivity.verdict.is_proved());
    /// // Lambda = diag(-1, 0): the second entry is only integrated, which is for a parameter estimator to make up for.
    /// assert!(report.stability.is_proved() && report.stability.integrated == [1]);
    /// println!("{report}");
    /// # Ok::<(), luenberger_design::KklError>(())
    /// ```
    ///
    /// Cost: an evaluation of the maps at each sample and for each part of the box, of which there are at most the
    /// region's [subdivisions](Region::subdivisions) and one more; n evaluations of (phi, h) at each sample; a
    /// comparison of all pairs of samples.
    ///
    /// # Errors
    /// [`DesignError::Setting`](crate::DesignError::Setting), [`KklError::Unbounded`], [`KklError::Undefined`] where a
    /// map has no value; [`KklError::Enclosure`] for the box.
    pub fn check(&self, region: &Region, settings: &KklSettings) -> Result<KklReport, KklError>
    where
        Self: Pieces<IntervalDual> + Pieces<SymbolicPolynomial>,
    {
        let (points, axes) = self.prepared(region, settings)?;
        let size = Pieces::<IntervalDual>::plant_dimensions(self);
        let budget = region.budget();
        let residual = residual::residual(self, (&points, &axes), settings.tolerance, budget)?;
        let stability = stability::stability(self.lambda_over(&axes, size))?;
        let of_lambda = (&stability.lambda, stability.integrated.as_slice());
        let coupling = coupling::coupling(self, of_lambda, (&points, &axes));
        let injectivity = injectivity::injectivity(self, self.order, (&points, &axes), budget)?;
        Ok(KklReport {
            residual,
            stability,
            coupling,
            injectivity,
            left_inverse: self.left_inverse_over(&points, &axes, size),
        })
    }

    /// The residual of (4) alone.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn residual(&self, region: &Region, settings: &KklSettings) -> Result<Residual, KklError>
    where
        Self: Pieces<IntervalDual> + Pieces<SymbolicPolynomial>,
    {
        let (points, axes) = self.prepared(region, settings)?;
        residual::residual(self, (&points, &axes), settings.tolerance, region.budget())
    }

    /// The points that are sampled, and the box (states, inputs, time).
    fn prepared(&self, region: &Region, settings: &KklSettings) -> Result<Prepared, KklError>
    where
        Self: Pieces<IntervalDual>,
    {
        within("the tolerance of the residual", settings.tolerance, 0.0, 1.0)?;
        within("the number of samples", settings.samples as f64, 1.0, 4096.0)?;
        let size = Pieces::<IntervalDual>::plant_dimensions(self);
        let axes = region.axes(size)?;
        let unbounded = axes[..size.states + size.inputs].iter().position(|axis| !axis.is_bounded());
        if let Some(k) = unbounded {
            let (axis, lo, hi) = (Axis::of(k, size), axes[k].lo(), axes[k].hi());
            return Err(KklError::Unbounded { axis, lo, hi });
        }
        if let Some(output) = candidate::feedthrough(self, &axes, size) {
            return Err(crate::DesignError::Feedthrough { output }.into());
        }
        Ok((samples(&axes, settings), axes))
    }

    /// Lambda over a box.
    fn lambda_over(&self, axes: &[Interval], size: Dimensions) -> Matrix<Interval>
    where
        Self: Pieces<IntervalDual> + Pieces<SymbolicPolynomial>,
    {
        let (x, u, t) = still(axes, size);
        let order = self.order;
        let ways = explore(|| {
            let y = self.output(t, &x);
            self.lambda(t, &u, &y).iter().map(IntervalDual::value).collect::<Vec<_>>()
        });
        let united = ways.ok().and_then(|ways| {
            ways.into_iter().reduce(|all, one| all.iter().zip(&one).map(|(all, one)| all.hull(one)).collect())
        });
        // Without a value on the whole box nothing is known of it.
        let entries = united.filter(|entries| entries.len() == order * order);
        let mut entries = entries.unwrap_or_else(|| vec![Interval::UNBOUNDED; order * order]);
        // 1 + u^2 is never below 1, which only the collected form knows.
        let form = collect(|| {
            let variables: Vec<SymbolicPolynomial> = (0..axes.len()).map(SymbolicPolynomial::variable).collect();
            let (x, rest) = variables.split_at(size.states);
            let (u, t) = (&rest[..size.inputs], rest[size.inputs]);
            self.lambda(t, u, &self.output(t, x))
        });
        if let Ok((form, arena)) = form
            && let Some(atoms) = arena.atoms_over(axes)
        {
            for (entry, form) in entries.iter_mut().zip(form) {
                let form = arena.value(form).and_then(|form| evaluate(&form, &atoms));
                *entry = form.and_then(|form| entry.intersection(&form)).unwrap_or(*entry);
            }
        }
        Matrix::from_fn(order, order, |i, j| entries[j * order + i])
    }

    fn left_inverse_over(
        &self,
        points: &[Vec<Interval>],
        axes: &[Interval],
        size: Dimensions,
    ) -> Result<(f64, BoxPoint), BoxPoint>
    where
        Self: Pieces<IntervalDual>,
    {
        let time = axes.len() - 1;
        let instants = instants(&axes[time]);
        let mut worst = (0.0, points[0].clone());
        for (k, point) in points.iter().enumerate() {
            match self.missed(point, axes, size) {
                Some(missed) if missed > worst.0 => worst = (missed, point.clone()),
                Some(_) => {}
                None => return Err(BoxPoint::of(point, size)),
            }
            let Some(instant) = instants.get(k % instants.len().max(1)) else { continue };
            let mut point = point.clone();
            point[time] = *instant;
            // Far from 0 a function of the time alone may be beyond the range of numbers.
            if let Some(missed) = self.missed(&point, axes, size).filter(|missed| *missed > worst.0) {
                worst = (missed, point);
            }
        }
        Ok((worst.0, BoxPoint::of(&worst.1, size)))
    }

    /// The largest error of `phi^L(phi(x), h(x))` at a point, in half-widths; none where it has no finite value.
    fn missed(&self, point: &[Interval], axes: &[Interval], size: Dimensions) -> Option<f64>
    where
        Self: Pieces<IntervalDual>,
    {
        let (x, _, t) = still(point, size);
        let ways = explore(|| {
            let y = self.output(t, &x);
            self.left_inverse(t, &self.image(t, &x, &y), &y)
        });
        let estimate = ways.ok()?.into_iter().next()?;
        self.estimated.iter().zip(&estimate).try_fold(0.0f64, |most, (k, found)| {
            let (middle, _) = found.value().midpoint_radius()?;
            let half = 0.5 * axes[*k].width();
            Some(most.max((middle - point[*k].lo()).abs() / if half > 0.0 { half } else { 1.0 }))
        })
    }
}

/// Times of all magnitudes, for a time without bounds, of which the samples have only one.
fn instants(time: &Interval) -> Vec<Interval> {
    let all = (-3..=6).flat_map(|k| [10f64.powi(k), -10f64.powi(k)]);
    all.filter(|t| !time.is_bounded() && time.contains(*t)).filter_map(Interval::from_f64).collect()
}

/// Points, and a box.
type Prepared = (Vec<Vec<Interval>>, Vec<Interval>);

/// Corners are sampled of at most this many coordinates, since there are 2^k of them.
const CORNERS: usize = 6;

/// The centre, corners, and points in between. A time without bounds is 0, or its bound.
fn samples(axes: &[Interval], settings: &KklSettings) -> Vec<Vec<Interval>> {
    let at = |axis: &Interval, share: f64| {
        let (lo, hi) = match (axis.lo().is_finite(), axis.hi().is_finite()) {
            (true, true) => (axis.lo(), axis.hi()),
            (true, false) => (axis.lo().max(0.0), axis.lo().max(0.0)),
            (false, true) => (axis.hi().min(0.0), axis.hi().min(0.0)),
            (false, false) => (0.0, 0.0),
        };
        let x = ((1.0 - share) * lo + share * hi).clamp(lo, hi);
        Interval::from_f64(x).unwrap_or(*axis)
    };
    let varying: Vec<usize> = (0..axes.len()).filter(|&k| axes[k].is_bounded() && !axes[k].is_point()).collect();
    let cornered = &varying[..varying.len().min(CORNERS)];
    let mut points = vec![axes.iter().map(|axis| at(axis, 0.5)).collect()];
    for corner in 0..if varying.is_empty() { 0 } else { 1usize << cornered.len() } {
        let share = |k| cornered.iter().position(|c| *c == k).map_or(0.5, |bit| (corner >> bit & 1) as f64);
        points.push(axes.iter().enumerate().map(|(k, axis)| at(axis, share(k))).collect());
    }
    let stream = Stream::new(settings.seed, Purpose::ConditionSamples, 0);
    for shares in GoldenSequence::new(varying.len(), stream).take(settings.samples) {
        let share = |k| varying.iter().position(|v| *v == k).map_or(0.5, |at| shares[at]);
        points.push(axes.iter().enumerate().map(|(k, axis)| at(axis, share(k))).collect());
    }
    points
}

impl KklReport {
    /// Whether (4), Lambda, the cascade of B and the injectivity are all proved, and nothing of Lambda is only
    /// integrated. Then `xi - phi(x)` decays exponentially from every start of xi, as long as the plant stays in the
    /// box and B is defined where xi goes, up to what the residual drives it to.
    pub fn is_proved(&self) -> bool {
        self.residual.verdict.is_proved()
            && self.stability.integrated.is_empty()
            && self.stability.is_proved()
            && self.coupling.verdict.is_proved()
            && self.injectivity.verdict.is_proved()
    }
}

impl fmt::Display for KklReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { residual, stability, coupling, injectivity, left_inverse } = self;
        let bounds: Vec<String> = residual.bounds.iter().map(|bound| at_most(*bound, 2)).collect();
        write!(f, "{:<9}  D phi f = Lambda phi + B (4): ", residual.verdict.word())?;
        match &residual.verdict {
            Verdict::Refuted { witness } => writeln!(f, "{witness}")?,
            _ => writeln!(f, "residual at most {} by rows, over {} parts", bounds.join(", "), residual.parts)?,
        }
        for fact in stability.certificate.facts() {
            writeln!(f, "{fact}")?;
        }
        if let Some(eigenvalue) = stability.eigenvalues.first() {
            writeln!(f, "           Lambda: slowest eigenvalue {eigenvalue} in the middle of the box")?;
        }
        if !stability.integrated.is_empty() {
            let entries: Vec<String> = stability.integrated.iter().map(|k| format!("xi{}", k + 1)).collect();
            writeln!(f, "           only integrated: {}", entries.join(", "))?;
        }
        write!(
            f,
            "{:<9}  B reads earlier entries of xi only, and leaves the decay to Lambda: ",
            coupling.verdict.word()
        )?;
        match (&coupling.verdict, &coupling.objection) {
            (Verdict::Refuted { witness }, _) => writeln!(f, "{witness}")?,
            (_, Some(objection)) => writeln!(f, "{objection}")?,
            (_, None) if coupling.reads.is_empty() => writeln!(f, "it reads none")?,
            (_, None) => {
                let pairs: Vec<String> = coupling
                    .reads
                    .iter()
                    .map(|(row, entry)| format!("B{} may read xi{}", row + 1, entry + 1))
                    .collect();
                writeln!(f, "{}", pairs.join(", "))?;
            }
        }
        write!(f, "{:<9}  (phi, h) injective: ", injectivity.verdict.word())?;
        match &injectivity.verdict {
            Verdict::Refuted { witness } => writeln!(f, "{witness}")?,
            _ => writeln!(
                f,
                "smallest ratio {} over {} states, smallest singular value {}",
                short(injectivity.smallest_ratio),
                injectivity.points,
                short(injectivity.smallest_singular_value)
            )?,
        }
        if !injectivity.continuous {
            writeln!(f, "           phi or h chooses between branches on the box")?;
        }
        if let Some(pair) = &injectivity.near_collision {
            writeln!(f, "           not to eight digits: {pair}")?;
        }
        match left_inverse {
            Ok((missed, place)) if *missed > 0.0 => {
                writeln!(f, "measured   phi^L(phi(x), h(x)) = x up to {} half-widths, at {place}", short(*missed))
            }
            Ok(_) => writeln!(f, "measured   phi^L(phi(x), h(x)) = x at every sample"),
            Err(place) => writeln!(f, "           phi^L(phi(x), h(x)) has no finite value at {place}"),
        }
    }
}

/// A KKL observer whose maps were checked.
#[derive(Clone, Debug, PartialEq)]
pub struct KklDesign<K> {
    /// The observer, ready to run.
    pub observer: KklObserver<K>,
    /// The report of its checks.
    pub report: KklReport,
}

impl<K> KklDesign<K> {
    /// The observer with these maps, if (4) is proved on the box, Lambda is Hurwitz on it, B reads earlier entries of
    /// xi only, and no two states with one image were found.
    ///
    /// Injectivity that is neither proved nor refuted is accepted, unless two states were found that eight digits do
    /// not tell apart: the report has the numbers.
    ///
    /// `x1' = -x1 + u + y^2, x2' = -x2 + x1, y = x2`, with phi = x1, and a wrong entry of Lambda:
    /// ```
    /// use luenberger_design::kkl::{KklError, KklSettings};
    /// use luenberger_design::{KklDesign, Region};
    /// use luenberger_observers::KklMap;
    /// use luenberger_plants::plant;
    /// use nalgebra::{Matrix1, RealField, U1, Vector1, convert};
    ///
    /// struct Chain;
    /// plant!(Chain, (2, 1, 1), |plant, t, x, u| [u[0] + x[1] * x[1] - x[0], x[0] - x[1]], [x[1]]);
    ///
    /// #[derive(Debug)]
    /// struct First(f64);
    /// impl<T: RealField + Copy> KklMap<T> for First {
    ///     type Xi = U1;
    ///     type Inputs = U1;
    ///     type Outputs = U1;
    ///     type Estimate = U1;
    ///     fn lambda(&self, _t: T, _u: &Vector1<T>, _y: &Vector1<T>) -> Matrix1<T> {
    ///         Matrix1::new(convert(self.0))
    ///     }
    ///     fn injection(&self, _t: T, _xi: &Vector1<T>, u: &Vector1<T>, y: &Vector1<T>) -> Vector1<T> {
    ///         Vector1::new(u[0] + y[0] * y[0])
    ///     }
    ///     fn left_inverse(&self, _t: T, xi: &Vector1<T>, _y: &Vector1<T>) -> Vector1<T> {
    ///         *xi
    ///     }
    ///     fn image(&self, _t: T, xhat: &Vector1<T>, _y: &Vector1<T>) -> Vector1<T> {
    ///         *xhat
    ///     }
    /// }
    ///
    /// let region = Region::new(&[(-1.0, 1.0), (-1.0, 1.0)]).inputs(&[(-1.0, 1.0)]);
    /// let design = KklDesign::new(&Chain, First(-1.0), &[0], &region, &KklSettings::default())?;
    /// assert_eq!(design.report.residual.bounds, [0.0]);
    /// let refused = KklDesign::new(&Chain, First(-2.0), &[0], &region, &KklSettings::default());
    /// // The residual is x1.
    /// assert!(matches!(refused, Err(KklError::NotASolution(worst)) if worst.at_least > 0.99));
    /// # Ok::<(), KklError>(())
    /// ```
    /// # Errors
    /// [`KklError::NotASolution`] has the point at which (4) fails, [`KklError::ResidualUndecided`];
    /// [`KklError::NotHurwitz`] names the eigenvalue, [`KklError::HurwitzUndecided`]; [`KklError::ReadsItself`] and
    /// [`KklError::CouplingUndecided`] name the entries of B and xi; [`KklError::NotInjective`] and
    /// [`KklError::Indistinct`] have the two states; and as [`KklCandidate::check`].
    pub fn new<S>(
        plant: &S,
        map: K,
        estimated: &[usize],
        region: &Region,
        settings: &KklSettings,
    ) -> Result<Self, KklError>
    where
        S: Plant<IntervalDual>,
        K: KklMap<IntervalDual>,
        DefaultAllocator: KklSize<K::Xi, K::Inputs, K::Outputs, K::Estimate>,
        for<'a> KklCandidate<'a, S, K>: Pieces<IntervalDual> + Pieces<SymbolicPolynomial>,
    {
        let report = KklCandidate::new(plant, &map, estimated)?.check(region, settings)?;
        match &report.residual.verdict {
            Verdict::Refuted { witness } => return Err(KklError::NotASolution(witness.clone())),
            Verdict::Undecided { .. } => {
                let allowed = |row: usize| settings.tolerance * report.residual.scales[row];
                let bounds = &report.residual.bounds;
                let excess = |row: usize| bounds[row] - allowed(row);
                let row = (0..bounds.len()).max_by(|&i, &j| excess(i).total_cmp(&excess(j))).unwrap_or(0);
                let bound = bounds.get(row).copied().unwrap_or(f64::INFINITY);
                return Err(KklError::ResidualUndecided { row, bound, allowed: allowed(row) });
            }
            Verdict::Proved { .. } => {}
        }
        report.stability.required()?;
        if let Verdict::Refuted { witness } = &report.coupling.verdict {
            return Err(KklError::ReadsItself(witness.clone()));
        }
        if let Some(objection) = report.coupling.objection {
            return Err(KklError::CouplingUndecided(objection));
        }
        match (&report.injectivity.verdict, &report.injectivity.near_collision) {
            (Verdict::Refuted { witness }, _) => return Err(KklError::NotInjective(witness.clone())),
            (Verdict::Undecided { .. }, Some(pair)) => return Err(KklError::Indistinct(pair.clone())),
            _ => {}
        }
        Ok(Self { observer: KklObserver::new(map), report })
    }
}
