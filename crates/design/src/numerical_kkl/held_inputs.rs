//! The numerical KKL observer for a family of held inputs.
//!
//! `T(x, u)` is computed by simulation at the Chebyshev-Lobatto nodes of each input, on one grid of the box and in one
//! set of whitened coordinates, and interpolated between the nodes by Lagrange's polynomials: for T analytic in u the
//! error of K nodes falls like `r^-K`, where r > 1 grows with the distance of T's singularities from the family. The
//! tree of polynomials has z and u as arguments. All errors are measured at pairs (x, u) that were not used in the fit,
//! with an own T by simulation for each u.

use std::fmt;
use std::ops::ControlFlow;

use luenberger_observers::numerical_kkl::held_trees::TreesOnHeap;
use luenberger_observers::numerical_kkl::least_squares::BoxMap;
use luenberger_observers::numerical_kkl::{
    HeldInputInverse, HeldInputObserver, HeldInputTables, HeldInputTrees, Node, Search, TensorSpline,
};
use luenberger_plants::Differentiable;
use luenberger_random::Purpose;
use nalgebra::{Const, SVector};

use super::interpolation::check_grid;
use super::progress::{Listener, Progress};
use super::regression::{self, Budget, Samples};
use super::report::write_errors;
use super::{
    Domain, Errors, Judged, NumericalKklError, Settings, Spline, TargetSystem, Transform, UNRESOLVED, check,
    injectivity, inversion_errors, on_grid, spline_of, white_coordinates,
};
use crate::check::within;
use crate::golden_sequence::GoldenSequence;
use crate::number::short;

/// The most values of an input for which T is tabulated.
pub const MOST_NODES: usize = 33;

/// The left inverse for held inputs, as designed.
type Inverse<const N: usize, const M: usize, const Z: usize, const ZM: usize> =
    HeldInputInverse<f64, Vec<Node<f64>>, Vec<f64>, Vec<Spline<N, Z>>, N, M, Z, ZM>;

/// The observer for held inputs, as designed.
pub type HeldInputs<const N: usize, const M: usize, const P: usize, const Z: usize, const ZM: usize> =
    HeldInputObserver<f64, Vec<Node<f64>>, Vec<f64>, Vec<Spline<N, Z>>, N, M, P, Z, ZM>;

/// An observer for a family of held inputs, with the measured accuracy.
#[derive(Clone, Debug)]
pub struct HeldInputDesign<const N: usize, const M: usize, const P: usize, const Z: usize, const ZM: usize> {
    /// The observer with the interpolated left inverse; `embedded()` of it is the one with the tree alone.
    pub observer: HeldInputs<N, M, P, Z, ZM>,
    /// The measured accuracy.
    pub report: HeldInputReport<N>,
}

/// The evidence that comes with a design for held inputs. The errors are at pairs (x, u) that were not fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldInputReport<const N: usize> {
    /// How far back T looks.
    pub horizon: f64,
    /// Inputs for which T is tabulated.
    pub tables: usize,
    /// Error of the interpolated `T(x, u)`, in the coordinates in which the image of box and family is about one wide:
    /// root mean square and largest.
    pub spline: (f64, f64),
    /// `D_x T f - D T - B h` of the interpolated T, relative to the largest `|B h|`: root mean square and largest.
    pub residual: (f64, f64),
    /// The smallest `|T(x, u) - T(x', u)| / |x - x'|` over the pairs of a grid and the nodes.
    pub smallest_ratio: f64,
    /// `x - T^-L(T(x, u), u)` of the embedded form.
    pub embedded: Errors<N>,
    /// The same of the interpolated form.
    pub interpolated: Errors<N>,
}

impl<const N: usize> fmt::Display for HeldInputReport<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "memory                         {:.2}", self.horizon)?;
        writeln!(f, "inputs with a table            {}", self.tables)?;
        writeln!(f, "spline of T, rms and max       {}, {}", short(self.spline.0), short(self.spline.1))?;
        writeln!(f, "DT f - D T - B h, rms and max  {}, {}", short(self.residual.0), short(self.residual.1))?;
        writeln!(f, "|T(x) - T(x')| / |x - x'|      at least {}", short(self.smallest_ratio))?;
        write_errors(f, "embedded", &self.embedded)?;
        write_errors(f, "interpolated", &self.interpolated)
    }
}

impl<const N: usize, const M: usize, const P: usize, const Z: usize, const ZM: usize> HeldInputDesign<N, M, P, Z, ZM> {
    /// The observer of `plant` for inputs that are held at any values of `family`, with `nodes` values of each input
    /// (2 to 33) for which T is tabulated. `ZM` is `Z + M`.
    ///
    /// # Errors
    /// As [`NumericalKklDesign::new`](super::NumericalKklDesign::new), [`NumericalKklError::HeldInput`] with the input
    /// where T fails; [`NumericalKklError::Family`]. [`NumericalKklError::GridTooLarge`] counts the tables of all
    /// nodes.
    pub fn new<S>(
        plant: &S,
        target: &TargetSystem<P, Z>,
        domain: &Domain<N>,
        (family, nodes): (&[(f64, f64); M], usize),
        settings: &Settings<N>,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Self, NumericalKklError>
    where
        S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
    {
        within("the number of nodes of an input", nodes as f64, 2.0, MOST_NODES as f64)?;
        for (input, &(lower, upper)) in family.iter().enumerate() {
            if !(lower.is_finite() && upper.is_finite() && lower < upper && (upper - lower).is_finite()) {
                return Err(NumericalKklError::Family { input, lower, upper });
            }
        }
        check::<N>(settings)?;
        check_grid(&settings.points, nodes.pow(M as u32), Z)?;
        let transform = |input| Transform::new(plant, target, domain, input, settings.tolerance);
        let axes = family.map(|range| lobatto(range, nodes));
        let tables = tables(&transform, &axes, settings, progress)?;
        let smallest_ratio = smallest_ratio(&transform, &tables, &axes, settings.injectivity_points, progress)?;

        let held_out = settings.stream(Purpose::HeldOutStates);
        let probes: Vec<(SVector<f64, N>, SVector<f64, M>)> = GoldenSequence::new(N + M, held_out)
            .map(|share| (domain.point(|i| share[i]), of_family(family, &share[N..])))
            .filter(|(x, _)| domain.satisfies(x))
            .take(settings.held_out)
            .collect();
        let mut judged = Judged::default();
        let (mut images, mut horizon) = (Vec::with_capacity(probes.len()), 0.0);
        for (done, (x, u)) in probes.iter().enumerate() {
            let transform = transform(*u)?;
            let z = transform.at(x).map_err(|error| at_input(u, error))?;
            let (w, slope) = tables.at(u).with_gradient(x);
            let coordinates = tables.coordinates();
            judged.add_spline((w - coordinates.white(&z)).norm());
            let defect = transform.defect_of(x, &coordinates.coloured(&w), &(coordinates.colour() * slope)).norm();
            judged.add_defect(defect, (target.b() * plant.output(0.0, x, u)).norm());
            horizon = transform.horizon();
            images.push(z);
            Progress { stage: "held-out points", done: done + 1, total: probes.len() }.tell(progress)?;
        }
        let (spline, residual, _) = judged.relative();
        if spline.1.is_nan() || spline.1 > UNRESOLVED {
            return Err(NumericalKklError::Unresolved { error: spline.1, most: UNRESOLVED });
        }

        // The largest error seen, with a factor for the points not seen.
        let search = Search {
            max_evaluations: settings.max_evaluations,
            tolerance: 4.0 * spline.1,
            fallback: settings.fallback,
        };
        let count = tables.splines().len();
        let inverse = with_tree(tables, (domain, family), settings, search, progress)?;
        let embedded = inverse.clone().embedded();
        let errors = |inverse: &Inverse<N, M, Z, ZM>, stage, progress: &mut Listener<'_>| {
            let states: Vec<SVector<f64, N>> = probes.iter().map(|(x, _)| *x).collect();
            let pairs: Vec<_> = images.iter().copied().zip(probes.iter().map(|(_, u)| *u)).collect();
            inversion_errors(|(z, u)| inverse.state(z, u), &states, &pairs, stage, progress)
        };
        let report = HeldInputReport {
            horizon,
            tables: count,
            spline,
            residual,
            smallest_ratio,
            embedded: errors(&embedded, "embedded form", progress)?,
            interpolated: errors(&inverse, "interpolated form", progress)?,
        };
        Ok(Self { observer: HeldInputObserver::new(*target.d(), *target.b(), inverse)?, report })
    }
}

/// The embedded form of a left inverse for held inputs without its tables: its tree from z and u to the state, and one
/// from the state and u to z, fitted to samples of the tables, with which an observer starts.
///
/// # Errors
/// [`NumericalKklError`] of the regression; sizes other than `NM = N + M`.
pub fn without_tables<const N: usize, const M: usize, const Z: usize, const ZM: usize, const NM: usize>(
    inverse: &Inverse<N, M, Z, ZM>,
    settings: &Settings<N>,
) -> Result<TreesOnHeap<f64, N, M, Z, ZM, NM>, NumericalKklError> {
    let tables = inverse.tables();
    let (&lower, &upper) = tables.splines()[0].bounds();
    let (least, most) = tables.family();
    let (mut arguments, mut images) = (Vec::new(), Vec::new());
    for share in GoldenSequence::new(N + M, settings.stream(Purpose::InverseSamples)).take(settings.samples) {
        let x = SVector::<f64, N>::from_fn(|i, _| (1.0 - share[i]) * lower[i] + share[i] * upper[i]);
        let u = SVector::<f64, M>::from_fn(|i, _| (1.0 - share[N + i]) * least[i] + share[N + i] * most[i]);
        arguments.push(std::array::from_fn::<f64, NM, _>(|i| if i < N { x[i] } else { u[i - N] }));
        images.push(<[f64; Z]>::from(tables.at(&u).with_gradient(&x).0));
    }
    let forward = regression::fit(
        Samples { points: &arguments, values: &images, scale: [1.0; Z] },
        // T is smooth where its inverse is not: a quarter of the leaves is plenty.
        Budget { degree: settings.degree, leaves: settings.leaves.div_ceil(4), ridge: settings.ridge },
        &mut |_| Ok(()),
    )?;
    let trees = (inverse.start().clone(), forward);
    Ok(HeldInputTrees::new(*tables.coordinates(), (lower, upper), (least, most), trees)?)
}

/// Chebyshev-Lobatto nodes of an interval, `count` of them.
fn lobatto((low, high): (f64, f64), count: usize) -> Vec<f64> {
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let last = (count - 1) as f64;
    let inner = |k: usize| middle - half * (core::f64::consts::PI * k as f64 / last).cos();
    // The ends are the family's to the last bit.
    (0..count)
        .map(|k| {
            if k == 0 {
                low
            } else if k + 1 == count {
                high
            } else {
                inner(k)
            }
        })
        .collect()
}

/// The input at these shares of the family.
fn of_family<const M: usize>(family: &[(f64, f64); M], share: &[f64]) -> SVector<f64, M> {
    SVector::from_fn(|i, _| (1.0 - share[i]) * family[i].0 + share[i] * family[i].1)
}

/// All combinations of the nodes, the last input running fastest.
fn combinations<const M: usize>(axes: &[Vec<f64>; M]) -> Vec<SVector<f64, M>> {
    let count: usize = axes.iter().map(Vec::len).product();
    let combination = |index: usize| {
        let mut rest = index;
        let mut input = SVector::zeros();
        for i in (0..M).rev() {
            input[i] = axes[i][rest % axes[i].len()];
            rest /= axes[i].len();
        }
        input
    };
    (0..count).map(combination).collect()
}

fn at_input<const M: usize>(input: &SVector<f64, M>, error: NumericalKklError) -> NumericalKklError {
    match error {
        error @ NumericalKklError::Stopped { .. } => error,
        error => NumericalKklError::HeldInput { input: input.iter().copied().collect(), error: Box::new(error) },
    }
}

/// The tables, as designed.
type Tables<const N: usize, const M: usize, const Z: usize> =
    HeldInputTables<f64, Vec<f64>, Vec<TensorSpline<f64, Vec<f64>, N, Z>>, N, M, Z>;

/// T on the grid for all nodes, in coordinates in which all of it together is white.
fn tables<'p, S, const N: usize, const M: usize, const P: usize, const Z: usize>(
    transform: &dyn Fn(SVector<f64, M>) -> Result<Transform<'p, S, N, M, P, Z>, NumericalKklError>,
    axes: &[Vec<f64>; M],
    settings: &Settings<N>,
    progress: &mut Listener<'_>,
) -> Result<Tables<N, M, Z>, NumericalKklError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>> + 'p,
{
    let inputs = combinations(axes);
    let (mut values, mut scale) = (Vec::new(), 0.0f64);
    let mut domain = None;
    for (k, input) in inputs.iter().enumerate() {
        let transform = transform(*input)?;
        let table = on_grid(&transform, settings.points, (k, inputs.len()), progress);
        values.extend(table.map_err(|error| at_input(input, error))?);
        scale = scale.max(transform.output_scale());
        domain = Some(transform.domain().clone());
    }
    let coordinates = white_coordinates(&values, scale)?;
    let points: usize = settings.points.iter().product();
    let splines: Result<Vec<_>, NumericalKklError> = (domain.iter())
        .flat_map(|domain| values.chunks(points).map(|table| spline_of(domain, settings.points, &coordinates, table)))
        .collect();
    Ok(HeldInputTables::new(coordinates, axes.concat(), splines?)?)
}

/// The smallest ratio of distances that T has, over the nodes; two states with one image are an error.
fn smallest_ratio<'p, S, const N: usize, const M: usize, const P: usize, const Z: usize>(
    transform: &dyn Fn(SVector<f64, M>) -> Result<Transform<'p, S, N, M, P, Z>, NumericalKklError>,
    tables: &Tables<N, M, Z>,
    axes: &[Vec<f64>; M],
    per_axis: usize,
    progress: &mut Listener<'_>,
) -> Result<f64, NumericalKklError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>> + 'p,
{
    let mut smallest = f64::INFINITY;
    for (input, spline) in combinations(axes).iter().zip(tables.splines()) {
        let transform = transform(*input)?;
        let found = injectivity::injectivity(&transform, (spline, tables.coordinates()), per_axis, progress);
        smallest = smallest.min(found.map_err(|error| at_input(input, error))?.smallest_ratio);
    }
    Ok(smallest)
}

/// The left inverse, with a tree fitted to samples of the tables.
fn with_tree<const N: usize, const M: usize, const Z: usize, const ZM: usize>(
    tables: Tables<N, M, Z>,
    (domain, family): (&Domain<N>, &[(f64, f64); M]),
    settings: &Settings<N>,
    search: Search<f64>,
    progress: &mut Listener<'_>,
) -> Result<Inverse<N, M, Z, ZM>, NumericalKklError> {
    let (mut states, mut arguments) = (Vec::new(), Vec::new());
    let samples = GoldenSequence::new(N + M, settings.stream(Purpose::InverseSamples))
        .map(|share| (domain.point(|i| share[i]), of_family(family, &share[N..])));
    for (x, u) in samples.filter(|(x, _)| domain.satisfies(x)).take(settings.samples) {
        let w = tables.at(&u).with_gradient(&x).0;
        states.push(<[f64; N]>::from(x));
        arguments.push(std::array::from_fn::<f64, ZM, _>(|i| if i < Z { w[i] } else { u[i - Z] }));
    }
    let leaves = settings.leaves;
    let tree = regression::fit(
        Samples { points: &arguments, values: &states, scale: domain.half_width().into() },
        Budget { degree: settings.degree, leaves, ridge: settings.ridge },
        &mut |done| Progress { stage: "regression", done, total: leaves }.tell(progress),
    )?;
    Ok(HeldInputInverse::new(tables, tree, Some(search))?)
}
