//! The numerical Kazantzis-Kravaris-Luenberger observer: for a plant `x' = f(x)`, `y = h(x)` whose T has no closed
//! form.
//!
//! `z' = D z + B y` ([`TargetSystem`]); T by simulation backward in time ([`Transform`]) over a box or a part of it
//! ([`Domain`]); T^-L in two forms, both of `luenberger-observers`:
//!
//! - *embedded*: xhat straight from z by a tree of small polynomials, for a microcontroller;
//! - *interpolated*: T by cubic splines, xhat by Gauss-Newton steps on `min |T(x) - z|`.
//!
//! | file | subject |
//! |---|---|
//! | `choice` | cut-off, grid and escape that are not given |
//! | `target` | D and B from poles or a Bessel prototype |
//! | `domain` | the box, inequalities in it, and the plant slowed outside |
//! | `extrapolation` | the integrator of the many short trajectories |
//! | `transform` | T and DT by simulation |
//! | `interpolation`, `regression` | splines through a grid; polynomials on a tree |
//! | `injectivity` | injectivity of T |
//! | `held_inputs` | the design for a family of held inputs |
//! | `low_rank` | T of low rank, for more states than a grid can hold |
//! | `progress` | progress of a design, and its cancellation |
//! | `report` | errors at validation points, and costs |
//!
//! The plant has no input, or a constant one; T is then specific to that input. [`HeldInputDesign`] has T for a family
//! of constant inputs.
//!
//! There is no proof: every number in [`Report`] is measured, at validation points not used in the fit.

mod choice;
mod domain;
mod error;
pub(crate) mod extrapolation;
mod held_inputs;
mod injectivity;
pub(crate) mod interpolation;
pub(crate) mod low_rank;
mod progress;
pub(crate) mod regression;
mod report;
mod target;
mod transform;

use std::ops::ControlFlow;

use luenberger_observers::kkl::{KklObserver, LeftInverse, LinearKkl};
use luenberger_observers::numerical_kkl::least_squares::RESTARTS;
use luenberger_observers::numerical_kkl::{
    BoxMap, Coordinates, InterpolatedInverse, Node, NumericalKklObserver, PolynomialInverse, Search, TensorSpline,
};
use luenberger_plants::Differentiable;
use luenberger_random::{Purpose, Stream};
use luenberger_wording::setters;
use nalgebra::{Const, DMatrix, SMatrix, SVector};

use crate::check::within;
use crate::golden_sequence::GoldenSequence;
use progress::Listener;
use regression::{Budget, Samples};

pub use choice::{Candidate, Choice, ChoiceOptions, choose, choose_with_table, searched_tables};
pub use domain::{Domain, Escape, Inequality};
pub use error::NumericalKklError;
pub use held_inputs::{HeldInputDesign, HeldInputReport, HeldInputs, MOST_NODES, without_tables};
pub use injectivity::Injectivity;
pub use low_rank::{Train, low_rank_trajectories};
pub use progress::Progress;
pub use report::{Errors, Footprint, Report, Trial, ValidationErrors, held_out};
pub use target::TargetSystem;
pub use transform::Transform;

/// Limits of a numerical KKL design.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings<const N: usize> {
    /// Accuracy of T by simulation, relative to the size of y (default 1e-11).
    pub tolerance: f64,
    /// Grid points per axis of the spline of T, 4 to 1024 (default 65).
    pub points: [usize; N],
    /// Largest rank of a table of low rank, 1 to 32 (default 24).
    pub rank: usize,
    /// Largest error of a table of low rank at points of its grid, in the coordinates in which T(box) is about one
    /// wide, 1e-12 to 0.1 (default 1e-6).
    pub rank_tolerance: f64,
    /// Total degree of the polynomials of the embedded form, 1 to 12 (default 4).
    pub degree: usize,
    /// Leaves of its tree, 1 to 4096 (default 64). One leaf is the ordinary polynomial regression.
    pub leaves: usize,
    /// Samples of the box that the embedded form is fitted to, 100 to a million (default 20000).
    pub samples: usize,
    /// Ridge of the regression, relative (default 1e-8). A larger ridge makes estimates less sensitive to noise in z.
    pub ridge: f64,
    /// Maximal number of evaluations of T per iteration of the interpolated form (default 40).
    pub max_evaluations: usize,
    /// Points per axis on which the interpolated form seeks other starts when the first fails, 0 (none) to 64 (default
    /// 9).
    pub fallback: usize,
    /// Grid points per axis of the injectivity check, 3 to 64 (default 17).
    pub injectivity_points: usize,
    /// Number of validation points, 10 to 100000 (default 500).
    pub held_out: usize,
    /// Seed of the sequences of sample points.
    pub seed: u64,
}

impl<const N: usize> Default for Settings<N> {
    fn default() -> Self {
        Self {
            tolerance: 1e-11,
            points: [65; N],
            rank: 24,
            rank_tolerance: 1e-6,
            degree: 4,
            leaves: 64,
            samples: 20_000,
            ridge: 1e-8,
            max_evaluations: 40,
            fallback: 9,
            injectivity_points: 17,
            held_out: 500,
            seed: 0,
        }
    }
}

impl<const N: usize> Settings<N> {
    setters! {
        tolerance: f64, points: [usize; N], rank: usize, rank_tolerance: f64, degree: usize, leaves: usize,
        samples: usize, ridge: f64, max_evaluations: usize, fallback: usize, injectivity_points: usize, held_out: usize,
        seed: u64,
    }

    pub(in crate::numerical_kkl) fn stream(&self, purpose: Purpose) -> Stream {
        Stream::new(self.seed, purpose, 0)
    }
}

/// The embedded form, as designed.
pub type Embedded<const N: usize, const Z: usize> = PolynomialInverse<f64, Vec<Node<f64>>, Vec<f64>, N, Z>;
/// The interpolated form, as designed; `W` is its table, [`TensorSpline`] or [`Train`].
pub type Interpolated<const N: usize, const Z: usize, W = TensorSpline<f64, Vec<f64>, N, Z>> =
    InterpolatedInverse<f64, Vec<Node<f64>>, Vec<f64>, N, Z, W>;

/// Both observers, with the measured accuracy; `W` is the table of the interpolated one.
#[derive(Clone, Debug)]
pub struct NumericalKklDesign<
    const N: usize,
    const M: usize,
    const P: usize,
    const Z: usize,
    W = TensorSpline<f64, Vec<f64>, N, Z>,
> {
    /// The observer for a microcontroller.
    pub embedded: NumericalKklObserver<Embedded<N, Z>, f64, N, M, P, Z>,
    /// The observer with the interpolated left inverse: more accurate, and more expensive.
    pub interpolated: NumericalKklObserver<Interpolated<N, Z, W>, f64, N, M, P, Z>,
    /// The measured accuracy.
    pub report: Report<N>,
}

impl<const N: usize, const M: usize, const P: usize, const Z: usize> NumericalKklDesign<N, M, P, Z> {
    /// The observers of `plant` at the constant input `input` on `domain`, with the target `target`.
    ///
    /// `progress` is called after every trajectory and every few samples of the regression, and decides whether the
    /// design continues: it can take minutes, and [`ControlFlow::Break`] ends it within a step. The result depends on
    /// the other arguments only.
    ///
    /// The reverse Duffing oscillator, x1' = x2^3, x2' = -x1, of which x1 is measured:
    /// ```
    /// use luenberger_design::numerical_kkl::{Domain, Escape, NumericalKklDesign, Settings, TargetSystem};
    /// use luenberger_observers::Observer;
    /// use luenberger_plants::ReverseDuffing;
    /// use nalgebra::{SVector, Vector2};
    /// use std::ops::ControlFlow::Continue;
    /// let domain = Domain::new([-1.0; 2], [1.0; 2], Escape::Free)?;
    /// let settings = Settings { points: [33; 2], leaves: 16, samples: 4000, injectivity_points: 9, ..Settings::default() };
    /// let target = TargetSystem::<1, 3>::bessel(2.0)?;
    /// let design = NumericalKklDesign::new(&ReverseDuffing, &target, &domain, SVector::zeros(), &settings, &mut |_| Continue(()))?;
    /// println!("{}", design.report);
    /// // From x to T(x) and back.
    /// let (x, u, y) = (Vector2::new(0.5, 0.5), SVector::zeros(), SVector::zeros());
    /// let z = design.interpolated.initial(0.0, &x, &u, &y);
    /// assert!((design.interpolated.estimate(0.0, &z, &u, &y) - x).norm() < 1e-9);
    /// assert!((design.embedded.estimate(0.0, &z, &u, &y) - x).norm() < 1e-2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`NumericalKklError::NotInjective`] with two states that y does not tell apart; [`NumericalKklError::Escapes`]
    /// for a plant whose past is unbounded and not slowed; [`NumericalKklError::Stalled`],
    /// [`NumericalKklError::NotFinite`]; [`DesignError::Setting`](crate::DesignError::Setting) and
    /// [`NumericalKklError::GridTooLarge`] for the settings; [`NumericalKklError::Unresolved`] when the grid is too
    /// coarse for T; [`NumericalKklError::Stopped`] when `progress` says so.
    pub fn new<S>(
        plant: &S,
        target: &TargetSystem<P, Z>,
        domain: &Domain<N>,
        input: SVector<f64, M>,
        settings: &Settings<N>,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Self, NumericalKklError>
    where
        S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
    {
        Self::with_table(plant, target, domain, input, settings, progress)
    }
}

impl<const N: usize, const M: usize, const P: usize, const Z: usize> NumericalKklDesign<N, M, P, Z, Train<N, Z>> {
    /// As [`new`](NumericalKklDesign::new), with a table of low rank: a [tensor train](Train) of splines, for more
    /// states than a grid of `settings.points` can hold. Its rank is the smallest with which the error at points of the
    /// grid is below `settings.rank_tolerance`, at most `settings.rank`. The time is about that of
    /// [`Report::trajectories`] trajectories.
    ///
    /// A double integrator driven by an unknown constant force, whose position is measured:
    /// ```
    /// use luenberger_design::numerical_kkl::{Domain, Escape, NumericalKklDesign, Settings, TargetSystem};
    /// use luenberger_observers::Observer;
    /// use luenberger_plants::StaticPlant;
    /// use nalgebra::{SMatrix, SVector, matrix, vector};
    /// use std::ops::ControlFlow::Continue;
    /// let a = matrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; 0.0, 0.0, 0.0];
    /// let plant = StaticPlant::new(a, SMatrix::<f64, 3, 0>::zeros(), matrix![1.0, 0.0, 0.0])?;
    /// let domain = Domain::new([-1.0; 3], [1.0; 3], Escape::Free)?;
    /// let settings = Settings { points: [5; 3], samples: 500, leaves: 4, injectivity_points: 5, ..Settings::default() };
    /// let target = TargetSystem::<1, 4>::bessel(4.0)?;
    /// let design = NumericalKklDesign::low_rank(&plant, &target, &domain, SVector::zeros(), &settings, &mut |_| Continue(()))?;
    /// // T of a linear plant is linear: behind a cut there are the linear functions and 1.
    /// assert!(design.interpolated.map().inverse().spline().ranks()[1..].iter().all(|rank| *rank <= 4));
    /// let (x, u, y) = (vector![0.5, -0.3, 0.2], SVector::zeros(), SVector::zeros());
    /// let z = design.interpolated.initial(0.0, &x, &u, &y);
    /// assert!((design.interpolated.estimate(0.0, &z, &u, &y) - x).norm() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// As [`new`](NumericalKklDesign::new), without a limit for the grid as a whole.
    pub fn low_rank<S>(
        plant: &S,
        target: &TargetSystem<P, Z>,
        domain: &Domain<N>,
        input: SVector<f64, M>,
        settings: &Settings<N>,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Self, NumericalKklError>
    where
        S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
    {
        Self::with_table(plant, target, domain, input, settings, progress)
    }
}

impl<const N: usize, const M: usize, const P: usize, const Z: usize, W> NumericalKklDesign<N, M, P, Z, W>
where
    W: Table<N, Z>,
{
    /// As [`new`](NumericalKklDesign::new), with the table `W`.
    ///
    /// # Errors
    /// As [`new`](NumericalKklDesign::new); those of [`Table::check`].
    pub fn with_table<S>(
        plant: &S,
        target: &TargetSystem<P, Z>,
        domain: &Domain<N>,
        input: SVector<f64, M>,
        settings: &Settings<N>,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Self, NumericalKklError>
    where
        S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
    {
        check::<N>(settings)?;
        W::check(settings)?;
        let transform = Transform::new(plant, target, domain, input, settings.tolerance)?;
        let Tabulated { coordinates, table: spline, trajectories } = W::compute(&transform, settings, progress)?;
        let probes: Vec<SVector<f64, N>> = GoldenSequence::new(N, settings.stream(Purpose::HeldOutStates))
            .map(|share| domain.point(|i| share[i]))
            .filter(|x| domain.satisfies(x))
            .take(settings.held_out)
            .collect();
        let mut judged = Judged::default();
        let mut images = Vec::with_capacity(probes.len());
        for (done, x) in probes.iter().enumerate() {
            let z = transform.at(x)?;
            let (w, slope) = spline.with_gradient(x);
            judged.add_spline((w - coordinates.white(&z)).norm());
            let defect = transform.defect_of(x, &coordinates.coloured(&w), &(coordinates.colour() * slope)).norm();
            judged.add_defect(defect, (target.b() * plant.output(0.0, x, transform.input())).norm());
            if done < 20 {
                judged.simulated = judged.simulated.max(transform.defect(x)?.norm());
            }
            images.push(z);
            Progress { stage: "held-out points", done: done + 1, total: probes.len() }.tell(progress)?;
        }
        let (spline_error, residual, simulated_residual) = judged.relative();

        let per_axis = settings.injectivity_points;
        let injectivity = injectivity::injectivity(&transform, (&spline, &coordinates), per_axis, progress)?;
        if spline_error.1.is_nan() || spline_error.1 > UNRESOLVED {
            return Err(NumericalKklError::Unresolved { error: spline_error.1, most: UNRESOLVED });
        }

        let embedded = embed(domain, &coordinates, &spline, settings, progress)?;
        // The largest error seen, with a factor for the points not seen.
        let search = Search {
            max_evaluations: settings.max_evaluations,
            tolerance: 4.0 * spline_error.1,
            fallback: settings.fallback,
        };
        let interpolated = InterpolatedInverse::new(spline, embedded.clone(), search)?;
        let report = Report {
            horizon: transform.horizon(),
            trajectories,
            spline: spline_error,
            residual,
            simulated_residual,
            injectivity,
            embedded: inversion_errors(|z| embedded.state(z), &probes, &images, "embedded form", progress)?,
            interpolated: inversion_errors(|z| interpolated.state(z), &probes, &images, "interpolated form", progress)?,
            evaluations: evaluations(&interpolated, &images, progress)?,
            embedded_footprint: embedded_footprint(&embedded),
            interpolated_footprint: interpolated_footprint(&interpolated),
        };
        let (embedded, interpolated) = (observer(target, embedded)?, observer(target, interpolated)?);
        Ok(Self { embedded, interpolated, report })
    }
}

fn check<const N: usize>(settings: &Settings<N>) -> Result<(), NumericalKklError> {
    within("the degree", settings.degree as f64, 1.0, 12.0)?;
    within("the number of leaves", settings.leaves as f64, 1.0, 4096.0)?;
    within("the number of samples", settings.samples as f64, 100.0, 1e6)?;
    within("the ridge", settings.ridge, 0.0, 1.0)?;
    within("the points per axis of other starts", settings.fallback as f64, 0.0, 64.0)?;
    within("the points of other starts", (settings.fallback as f64).powf(N as f64), 0.0, 1e5)?;
    within("the cap on evaluations", settings.max_evaluations as f64, 1.0, 1e4)?;
    within("the points per axis of the injectivity check", settings.injectivity_points as f64, 3.0, 64.0)?;
    let points = (settings.injectivity_points as f64).powf(N as f64);
    // All pairs are compared.
    within("the points of the injectivity check", points, 3.0, 4096.0)?;
    Ok(within("the number of held-out points", settings.held_out as f64, 10.0, 1e5)?)
}

/// A tensor-product spline on the heap.
pub type Spline<const N: usize, const Z: usize> = TensorSpline<f64, Vec<f64>, N, Z>;

/// T as a table, with its coordinates.
#[derive(Clone, Debug)]
pub struct Tabulated<W, const Z: usize> {
    /// Coordinates in which T(box) is about one wide.
    pub coordinates: Coordinates<f64, Z>,
    /// The table of T in these coordinates.
    pub table: W,
    /// Trajectories backward in time that it took.
    pub trajectories: usize,
}

/// A table of T: splines on a grid ([`TensorSpline`]), or of low rank ([`Train`]).
pub trait Table<const N: usize, const Z: usize>: BoxMap<f64, N, Z> + Sized {
    /// Whether the settings can be used.
    ///
    /// # Errors
    /// [`DesignError::Setting`](crate::DesignError::Setting) for a setting out of its range;
    /// [`NumericalKklError::GridTooLarge`] for more numbers than are computed.
    fn check(settings: &Settings<N>) -> Result<(), NumericalKklError>;

    /// The table by simulation.
    ///
    /// # Errors
    /// As [`Transform::at`]; [`NumericalKklError::Stopped`].
    fn compute<S, const M: usize, const P: usize>(
        transform: &Transform<'_, S, N, M, P, Z>,
        settings: &Settings<N>,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Tabulated<Self, Z>, NumericalKklError>
    where
        S: Differentiable<f64, Const<N>, Const<M>, Const<P>>;

    /// Number of stored coefficients.
    fn numbers(&self) -> usize;

    /// Multiply-adds of one evaluation with its Jacobian.
    fn multiply_adds(&self) -> usize;

    /// The largest rank, of a table of low rank.
    fn rank(&self) -> Option<usize> {
        None
    }
}

impl<const N: usize, const Z: usize> Table<N, Z> for Spline<N, Z> {
    fn check(settings: &Settings<N>) -> Result<(), NumericalKklError> {
        interpolation::check_grid(&settings.points, 1, Z)
    }

    /// T on the grid, white coordinates from its values, and its spline in them.
    fn compute<S, const M: usize, const P: usize>(
        transform: &Transform<'_, S, N, M, P, Z>,
        settings: &Settings<N>,
        progress: &mut Listener<'_>,
    ) -> Result<Tabulated<Self, Z>, NumericalKklError>
    where
        S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
    {
        let points = settings.points;
        let values = on_grid(transform, points, (0, 1), progress)?;
        let coordinates = white_coordinates(&values, transform.output_scale())?;
        let table = spline_of(transform.domain(), points, &coordinates, &values)?;
        Ok(Tabulated { coordinates, table, trajectories: values.len() })
    }

    fn numbers(&self) -> usize {
        self.coefficients().len()
    }

    /// For each of 4^(N-1) lines along the last axis, its value and slope of four terms, N products of N - 1 factors,
    /// and N + 1 times Z multiply-adds.
    fn multiply_adds(&self) -> usize {
        4usize.pow(N as u32 - 1) * ((N + 9) * Z + N * (N - 1))
    }
}

impl<const N: usize, const Z: usize> Table<N, Z> for Train<N, Z> {
    fn check(settings: &Settings<N>) -> Result<(), NumericalKklError> {
        low_rank::check(settings, Z)
    }

    fn compute<S, const M: usize, const P: usize>(
        transform: &Transform<'_, S, N, M, P, Z>,
        settings: &Settings<N>,
        progress: &mut Listener<'_>,
    ) -> Result<Tabulated<Self, Z>, NumericalKklError>
    where
        S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
    {
        low_rank::tabulate(transform, settings, progress)
    }

    fn numbers(&self) -> usize {
        self.coefficients().len()
    }

    fn rank(&self) -> Option<usize> {
        self.ranks().into_iter().skip(1).max().or(Some(1))
    }

    /// For each entry of each matrix its value and slope, and its part in the product and in the derivatives so far.
    fn multiply_adds(&self) -> usize {
        let ranks = self.ranks();
        let columns = |axis: usize| ranks.get(axis + 1).copied().unwrap_or(1);
        (0..N).map(|axis| ranks[axis] * columns(axis) * (10 + N - 1 - axis)).sum()
    }
}

/// T on the grid, of table `table` of so many.
fn on_grid<S, const N: usize, const M: usize, const P: usize, const Z: usize>(
    transform: &Transform<'_, S, N, M, P, Z>,
    points: [usize; N],
    (table, tables): (usize, usize),
    progress: &mut Listener<'_>,
) -> Result<Vec<SVector<f64, Z>>, NumericalKklError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
{
    let domain = transform.domain();
    let count = points.iter().product();
    let mut values = Vec::with_capacity(count);
    for index in 0..count {
        let mut rest = index;
        let mut share = [0.0; N];
        // The last axis runs fastest.
        for axis in (0..N).rev() {
            share[axis] = (rest % points[axis]) as f64 / (points[axis] - 1) as f64;
            rest /= points[axis];
        }
        values.push(transform.at(&domain.point(|i| share[i]))?);
        let (done, total) = (table * count + index + 1, tables * count);
        Progress { stage: "T on the grid", done, total }.tell(progress)?;
    }
    Ok(values)
}

/// The spline of these values on the grid.
fn spline_of<const N: usize, const Z: usize>(
    domain: &Domain<N>,
    points: [usize; N],
    coordinates: &Coordinates<f64, Z>,
    values: &[SVector<f64, Z>],
) -> Result<Spline<N, Z>, NumericalKklError> {
    let table = values.iter().flat_map(|z| coordinates.white(z).data.0[0]).collect();
    interpolation::interpolate(*domain.lower(), *domain.upper(), points, table)
}

/// Coordinates in which these values have mean 0 and covariance I, up to directions of no extent.
fn white_coordinates<const Z: usize>(
    values: &[SVector<f64, Z>],
    scale: f64,
) -> Result<Coordinates<f64, Z>, NumericalKklError> {
    let mean: SVector<f64, Z> = values.iter().sum::<SVector<f64, Z>>() / values.len() as f64;
    // Singular values of the data, not eigenvalues of the covariance: thin directions are not to be squared.
    let data = DMatrix::from_fn(values.len(), Z, |i, j| values[i][j] - mean[j]);
    let triangle = data.qr().r();
    let svd = triangle.svd(false, true);
    let directions = svd.v_t.unwrap_or_else(|| DMatrix::identity(Z, Z));
    let rows = (values.len() as f64).sqrt();
    let widths: Vec<f64> = (0..Z).map(|i| svd.singular_values.get(i).copied().unwrap_or(0.0) / rows).collect();
    let widest = widths.iter().copied().fold(0.0f64, f64::max);
    // Directions thinner than this are left out: what T is in them is noise of the simulation.
    let floor = (THIN * widest).max(f64::MIN_POSITIVE.sqrt() * scale);
    let holds = |i: usize| widths[i] > floor;
    let whiten = SMatrix::from_fn(|i, j| if holds(i) { directions[(i, j)] / widths[i] } else { 0.0 });
    let colour = SMatrix::from_fn(|i, j| if holds(j) { directions[(j, i)] * widths[j] } else { 0.0 });
    Ok(Coordinates::new(mean, whiten, colour)?)
}

/// An interpolation error of this size, where T(box) is about one wide, is no interpolation.
const UNRESOLVED: f64 = 0.2;

/// Widths of T(box) below this share of the largest count as none.
const THIN: f64 = 1e-6;

/// The two trees, fitted to samples of the spline.
fn embed<const N: usize, const Z: usize>(
    domain: &Domain<N>,
    coordinates: &Coordinates<f64, Z>,
    spline: &impl BoxMap<f64, N, Z>,
    settings: &Settings<N>,
    progress: &mut Listener<'_>,
) -> Result<Embedded<N, Z>, NumericalKklError> {
    let (mut states, mut images) = (Vec::new(), Vec::new());
    let samples =
        GoldenSequence::new(N, settings.stream(Purpose::InverseSamples)).map(|share| domain.point(|i| share[i]));
    for x in samples.filter(|x| domain.satisfies(x)).take(settings.samples) {
        states.push(<[f64; N]>::from(x));
        images.push(<[f64; Z]>::from(spline.with_gradient(&x).0));
    }
    let leaves = settings.leaves;
    let budget = Budget { degree: settings.degree, leaves, ridge: settings.ridge };
    let inverse = regression::fit(
        Samples { points: &images, values: &states, scale: domain.half_width().into() },
        budget,
        &mut |done| Progress { stage: "regression", done, total: leaves }.tell(progress),
    )?;
    // T is smooth where its inverse is not: a quarter of the leaves is plenty.
    let backward = leaves.div_ceil(4);
    let forward = regression::fit(
        Samples { points: &states, values: &images, scale: [1.0; Z] },
        Budget { leaves: backward, ..budget },
        &mut |done| Progress { stage: "regression of T", done, total: backward }.tell(progress),
    )?;
    Ok(PolynomialInverse::new(*coordinates, (*domain.lower(), *domain.upper()), inverse, forward)?)
}

/// The target with a left inverse.
fn observer<I, const N: usize, const M: usize, const P: usize, const Z: usize>(
    target: &TargetSystem<P, Z>,
    inverse: I,
) -> Result<NumericalKklObserver<I, f64, N, M, P, Z>, NumericalKklError>
where
    I: LeftInverse<f64, Const<Z>, Const<P>, Const<N>>,
{
    Ok(KklObserver::new(LinearKkl::new(*target.d(), *target.b(), SMatrix::zeros(), inverse)?))
}

fn inversion_errors<const N: usize, I>(
    inverse: impl Fn(&I) -> SVector<f64, N>,
    probes: &[SVector<f64, N>],
    images: &[I],
    stage: &'static str,
    progress: &mut Listener<'_>,
) -> Result<Errors<N>, NumericalKklError> {
    let total = probes.len();
    let mut errors = Vec::with_capacity(total);
    for (done, (x, z)) in probes.iter().zip(images).enumerate() {
        errors.push(x - inverse(z));
        Progress { stage, done: done + 1, total }.tell(progress)?;
    }
    Ok(Errors::of(errors.into_iter()))
}

/// Evaluations of T per estimate, mean and largest.
fn evaluations<const N: usize, const Z: usize>(
    form: &Interpolated<N, Z, impl BoxMap<f64, N, Z>>,
    images: &[SVector<f64, Z>],
    progress: &mut Listener<'_>,
) -> Result<(f64, usize), NumericalKklError> {
    let (mut sum, mut most, total) = (0, 0, images.len());
    for (done, z) in images.iter().enumerate() {
        let found = form.solve(z, &form.start().state(z)).evaluations;
        (sum, most) = (sum + found, most.max(found));
        Progress { stage: "evaluations of T", done: done + 1, total }.tell(progress)?;
    }
    Ok((sum as f64 / total as f64, most))
}

fn embedded_footprint<const N: usize, const Z: usize>(form: &Embedded<N, Z>) -> Footprint {
    let tree = form.inverse();
    let numbers = tree.numbers() + Z + Z * Z + 2 * N;
    Footprint {
        numbers,
        // Two branches and an axis of 16 bits each beside a threshold, padded to four bytes more than two words.
        bytes_f32: 4 * numbers + tree.nodes().len() * (size_of::<Node<f32>>() - 4),
        multiply_adds: Z * Z + tree.multiply_adds(),
        comparisons: tree.depth(),
    }
}

fn interpolated_footprint<const N: usize, const Z: usize, W>(form: &Interpolated<N, Z, W>) -> Footprint
where
    W: Table<N, Z>,
{
    let start = embedded_footprint(form.start());
    let table = form.spline().numbers();
    // Value and gradient, then the normal equations.
    let search = form.search();
    let restarts = if search.fallback == 0 { 0 } else { RESTARTS };
    let evaluations = (1 + restarts) * search.max_evaluations + search.fallback.pow(N as u32);
    let once = form.spline().multiply_adds() + N * (N + 1) * Z + N * N * N;
    Footprint {
        numbers: start.numbers + table,
        bytes_f32: start.bytes_f32 + 4 * table,
        multiply_adds: start.multiply_adds + evaluations * once,
        comparisons: start.comparisons,
    }
}

/// Running sums over the held-out points.
#[derive(Default)]
struct Judged {
    count: usize,
    spline: (f64, f64),
    defect: (f64, f64),
    injection: f64,
    simulated: f64,
}

impl Judged {
    fn add_spline(&mut self, error: f64) {
        self.count += 1;
        self.spline = (self.spline.0 + error * error, self.spline.1.max(error));
    }

    fn add_defect(&mut self, defect: f64, injection: f64) {
        self.defect = (self.defect.0 + defect * defect, self.defect.1.max(defect));
        self.injection = self.injection.max(injection);
    }

    /// Spline, residual and simulated residual; the last two relative to the largest `|B h|`.
    fn relative(&self) -> ((f64, f64), (f64, f64), f64) {
        let count = self.count as f64;
        let unit = if self.injection > 0.0 { self.injection } else { 1.0 };
        (
            ((self.spline.0 / count).sqrt(), self.spline.1),
            ((self.defect.0 / count).sqrt() / unit, self.defect.1 / unit),
            self.simulated / unit,
        )
    }
}
