//! T of low rank: a tensor train from a small part of the grid, by cross approximation.
//!
//! On the grid, T is a tensor of the indices (c, i_1, .., i_N), c the component, and for each k a matrix: rows (c, i_1,
//! .., i_k), columns (i_(k+1), .., i_N). Of a matrix of rank r, r rows R and r columns C are enough:
//! `A = A(:, C) A(R, C)^-1 A(R, :)`. A sweep from the first axis to the last chooses the rows of the next matrix among
//! those that extend the rows of this one, and a sweep back chooses the columns in the same way:
//!
//! 1. the matrix A of these rows and columns, and of some more columns at random, is simulated (every grid point once);
//! 2. its singular value decomposition is cut off where the rest is below the tolerance;
//! 3. of the r left singular vectors U, the rows with the largest volume are kept: no entry of `U U(R, :)^-1` is much
//!    larger than 1. In the last sweep this matrix is the core of the axis.
//!
//! Sweeps end when the error at grid points chosen beforehand is below the tolerance, or falls no more. Each core
//! is then interpolated along its axis by cubic splines, which is the tensor-product spline of the approximated grid.
//!
//! Sources: I. V. Oseledets and E. E. Tyrtyshnikov, TT-cross approximation for multidimensional arrays, Linear Algebra
//! and its Applications 432, 2010; S. A. Goreinov et al., How to find a good submatrix, in Matrix Methods, World
//! Scientific 2010, for the volume.

use std::collections::HashMap;

use luenberger_observers::numerical_kkl::TensorTrain;
use luenberger_observers::numerical_kkl::tensor_train::MOST_RANK;
use luenberger_plants::Differentiable;
use luenberger_random::Purpose;
use nalgebra::{Const, DMatrix, SVector};

use super::interpolation::{along_axis, check_axes};
use super::progress::{Listener, Progress};
use super::{Domain, NumericalKklError, Settings, Tabulated, Transform, white_coordinates};
use crate::check::within;
use crate::golden_sequence::GoldenSequence;

/// A tensor train on the heap.
pub type Train<const N: usize, const Z: usize> = TensorTrain<f64, Vec<f64>, N, Z>;

/// Sweeps there and back, at most.
const MOST_SWEEPS: usize = 12;
/// Grid points at which the approximation is judged.
const JUDGED: usize = 200;
/// Points per state from which mean and covariance of T over the box come.
const WHITENING: usize = 300;
/// Columns at random: at least this many, and half as many as have been chosen.
const LEAST_EXTRA: usize = 4;
/// No entry of `U U(R, :)^-1` is larger.
const VOLUME: f64 = 1.05;

/// Checks that a table of low rank can be made for so many target states.
pub(super) fn check<const N: usize>(settings: &Settings<N>, targets: usize) -> Result<(), NumericalKklError> {
    check_axes(&settings.points)?;
    within("the number of target states of a low-rank table", targets as f64, 1.0, MOST_RANK as f64)?;
    within("the largest rank", settings.rank as f64, 1.0, MOST_RANK as f64)?;
    Ok(within("the tolerance of the rank", settings.rank_tolerance, 1e-12, 0.1)?)
}

/// Trajectories that a table of this rank takes, for an estimate of the time: rows times columns of each axis, the
/// random ones included, and no more than there are grid points.
pub fn low_rank_trajectories(states: usize, points: usize, rank: usize) -> f64 {
    let (n, points, rank) = (states as f64, points as f64, rank as f64);
    WHITENING as f64 * n + points.powf(n).min(1.5 * n * points * rank * rank)
}

/// T of low rank.
pub(super) fn tabulate<S, const N: usize, const M: usize, const P: usize, const Z: usize>(
    transform: &Transform<'_, S, N, M, P, Z>,
    settings: &Settings<N>,
    progress: &mut Listener<'_>,
) -> Result<Tabulated<Train<N, Z>, Z>, NumericalKklError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
{
    let domain = transform.domain();
    let total = WHITENING * N;
    let mut values = Vec::with_capacity(total);
    for share in GoldenSequence::new(N, settings.stream(Purpose::TransformExtent)).take(total) {
        values.push(transform.at(&domain.point(|i| share[i]))?);
        Progress { stage: "extent of T", done: values.len(), total }.tell(progress)?;
    }
    let coordinates = white_coordinates(&values, transform.output_scale())?;
    let (table, evaluated) = approximate(domain, settings, |x| Ok(coordinates.white(&transform.at(x)?)), progress)?;
    Ok(Tabulated { coordinates, table, trajectories: total + evaluated })
}

/// A map on the grid of `settings` over the box of `domain`, with the number of points at which it was evaluated.
///
/// # Errors
/// That of the map, and of a listener that ends the computation.
pub fn approximate<const N: usize, const Z: usize>(
    domain: &Domain<N>,
    settings: &Settings<N>,
    mut map: impl FnMut(&SVector<f64, N>) -> Result<SVector<f64, Z>, NumericalKklError>,
    progress: &mut Listener<'_>,
) -> Result<(Train<N, Z>, usize), NumericalKklError> {
    let points = settings.points;
    let mut sampled =
        Sampled::new(points, |index: &[usize; N]| map(&domain.point(|i| index[i] as f64 / (points[i] - 1) as f64)));
    let cores = cross(&mut sampled, settings, progress)?;
    let evaluated = sampled.values.len();
    Ok((spline(domain, points, &cores)?, evaluated))
}

/// A map on a grid, every point of which is evaluated once.
struct Sampled<F, const N: usize, const Z: usize> {
    points: [usize; N],
    map: F,
    values: HashMap<[usize; N], SVector<f64, Z>>,
}

impl<F, const N: usize, const Z: usize> Sampled<F, N, Z>
where
    F: FnMut(&[usize; N]) -> Result<SVector<f64, Z>, NumericalKklError>,
{
    fn new(points: [usize; N], map: F) -> Self {
        Self { points, map, values: HashMap::new() }
    }

    fn at(&mut self, index: &[usize; N]) -> Result<SVector<f64, Z>, NumericalKklError> {
        if let Some(value) = self.values.get(index) {
            return Ok(*value);
        }
        let value = (self.map)(index)?;
        self.values.insert(*index, value);
        Ok(value)
    }

    /// The matrix of T at all pairs of a row and a column.
    fn matrix(
        &mut self,
        rows: &[Row<N>],
        columns: &[[usize; N]],
        axis: usize,
        alive: &mut dyn FnMut() -> Result<(), NumericalKklError>,
    ) -> Result<DMatrix<f64>, NumericalKklError> {
        let mut matrix = DMatrix::zeros(rows.len(), columns.len());
        for (i, row) in rows.iter().enumerate() {
            alive()?;
            for (j, column) in columns.iter().enumerate() {
                let index = core::array::from_fn(|k| if k < axis { row.index[k] } else { column[k] });
                matrix[(i, j)] = self.at(&index)?[row.component];
            }
        }
        Ok(matrix)
    }
}

/// A row: a component, and indices of the axes before some axis. Those of the other axes are 0.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Row<const N: usize> {
    component: usize,
    index: [usize; N],
}

/// The matrices of one axis: `count` of them, one after the other, each `rows x columns`, row by row.
struct Core {
    count: usize,
    rows: usize,
    columns: usize,
    entries: Vec<f64>,
}

/// Rows extended by all indices of an axis, the axis running fastest.
fn extended<const N: usize>(rows: &[Row<N>], axis: usize, points: usize) -> Vec<Row<N>> {
    let with = |row: &Row<N>, k: usize| {
        let mut index = row.index;
        index[axis] = k;
        Row { index, ..*row }
    };
    rows.iter().flat_map(|row| (0..points).map(move |k| with(row, k))).collect()
}

/// Random choices that depend on the seed alone.
struct Random {
    sequence: GoldenSequence,
}

impl Random {
    /// Indices of the axes that `holds`, 0 for the others.
    fn index<const N: usize>(&mut self, points: &[usize; N], holds: impl Fn(usize) -> bool) -> [usize; N] {
        let share = self.sequence.next().unwrap_or_default();
        core::array::from_fn(|i| if holds(i) { ((share[i] * points[i] as f64) as usize).min(points[i] - 1) } else { 0 })
    }

    fn component<const Z: usize>(&mut self) -> usize {
        let share = self.sequence.next().unwrap_or_default();
        ((share[0] * Z as f64) as usize).min(Z - 1)
    }
}

/// The cores of the approximation with the smallest error at the points where it is judged.
fn cross<F, const N: usize, const Z: usize>(
    sampled: &mut Sampled<F, N, Z>,
    settings: &Settings<N>,
    progress: &mut Listener<'_>,
) -> Result<Vec<Core>, NumericalKklError>
where
    F: FnMut(&[usize; N]) -> Result<SVector<f64, Z>, NumericalKklError>,
{
    let points = sampled.points;
    let mut random = Random { sequence: GoldenSequence::new(N, settings.stream(Purpose::CrossApproximation)) };
    let judged: Vec<[usize; N]> = (0..JUDGED).map(|_| random.index(&points, |_| true)).collect();
    let first: Vec<Row<N>> = (0..Z).map(|component| Row { component, index: [0; N] }).collect();
    // Rows and columns of the matrix before each axis.
    let mut rows: Vec<Vec<Row<N>>> = vec![first; N];
    let mut columns: Vec<Vec<[usize; N]>> = (0..=N)
        .map(|axis| {
            let count = if axis == N { 1 } else { LEAST_EXTRA };
            distinct((0..count).map(|_| random.index(&points, |i| i >= axis)).collect())
        })
        .collect();
    let mut best: Option<(f64, Vec<Core>)> = None;
    let mut stalled = 0;
    for sweep in 0..MOST_SWEEPS {
        let mut alive = || Progress { stage: "T of low rank", done: sweep, total: MOST_SWEEPS }.tell(progress);
        let mut cores = Vec::with_capacity(N);
        for axis in 0..N {
            let tall = extended(&rows[axis], axis, points[axis]);
            let last = axis + 1 == N;
            let mut wide = columns[axis + 1].clone();
            if !last {
                let extra = LEAST_EXTRA.max(wide.len() / 2);
                wide.extend((0..extra).map(|_| random.index(&points, |i| i > axis)));
            }
            let wide = distinct(wide);
            let matrix = sampled.matrix(&tall, &wide, axis + 1, &mut alive)?;
            let (core, chosen) = if last {
                (matrix, Vec::new())
            } else {
                let vectors = singular_vectors(&matrix, settings.rank, settings.rank_tolerance);
                let chosen = largest_volume(&vectors);
                (interpolant(&vectors, &chosen), chosen)
            };
            if !last {
                rows[axis + 1] = chosen.iter().map(|&i| tall[i]).collect();
            }
            cores.push(arranged(&core, points[axis]));
        }
        let mut error = 0.0f64;
        for index in &judged {
            let difference = product::<N, Z>(&cores, index) - sampled.at(index)?;
            error = error.max(difference.amax());
        }
        let improved = best.as_ref().is_none_or(|(least, _)| error < 0.5 * least);
        stalled = if improved { 0 } else { stalled + 1 };
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, cores));
        }
        if error <= settings.rank_tolerance || stalled > 2 {
            break;
        }
        for axis in (1..N).rev() {
            let wide = columns_extended(&columns[axis + 1], axis, points[axis]);
            let mut tall = rows[axis].clone();
            let extra = LEAST_EXTRA.max(tall.len() / 2);
            tall.extend((0..extra).map(|_| {
                let component = random.component::<Z>();
                Row { component, index: random.index(&points, |i| i < axis) }
            }));
            let matrix = sampled.matrix(&tall, &wide, axis, &mut alive)?;
            let vectors = singular_vectors(&matrix.transpose(), settings.rank, settings.rank_tolerance);
            columns[axis] = largest_volume(&vectors).iter().map(|&j| wide[j]).collect();
        }
    }
    Ok(best.map(|(_, cores)| cores).unwrap_or_default())
}

/// Columns extended by all indices of the axis before them.
fn columns_extended<const N: usize>(columns: &[[usize; N]], axis: usize, points: usize) -> Vec<[usize; N]> {
    let with = |column: &[usize; N], k: usize| {
        let mut index = *column;
        index[axis] = k;
        index
    };
    columns.iter().flat_map(|column| (0..points).map(move |k| with(column, k))).collect()
}

fn distinct<const N: usize>(mut columns: Vec<[usize; N]>) -> Vec<[usize; N]> {
    let mut seen = std::collections::HashSet::new();
    columns.retain(|column| seen.insert(*column));
    columns
}

/// The left singular vectors, at most `most` and at least one, without those whose singular values together are below
/// the tolerance, relative to the root mean square of an entry times the root of their number.
fn singular_vectors(matrix: &DMatrix<f64>, most: usize, tolerance: f64) -> DMatrix<f64> {
    let svd = matrix.clone().svd(true, false);
    let u = svd.u.unwrap_or_else(|| DMatrix::identity(matrix.nrows(), 1));
    let mut order: Vec<usize> = (0..svd.singular_values.len()).collect();
    order.sort_by(|a, b| svd.singular_values[*b].total_cmp(&svd.singular_values[*a]));
    let all = svd.singular_values.norm();
    let mut rank = order.len();
    let mut rest = 0.0f64;
    while rank > 1 {
        rest = rest.hypot(svd.singular_values[order[rank - 1]]);
        // The tolerance is that of the sum of all axes.
        if rest > 0.1 * tolerance * all {
            break;
        }
        rank -= 1;
    }
    let rank = rank.min(most).min(matrix.nrows()).max(1);
    DMatrix::from_fn(u.nrows(), rank, |i, j| u[(i, order[j])])
}

/// As many rows of a tall matrix as it has columns, so that no entry of `U U(R, :)^-1` is larger than [`VOLUME`], or
/// after a number of exchanges.
fn largest_volume(u: &DMatrix<f64>) -> Vec<usize> {
    let rank = u.ncols();
    // Gaussian elimination with the pivots of each column chooses the first rows.
    let mut rest = u.clone();
    let mut chosen = Vec::with_capacity(rank);
    for j in 0..rank {
        let is_free = |i: &usize| !chosen.contains(i);
        let pivot = (0..u.nrows()).filter(is_free).max_by(|a, b| rest[(*a, j)].abs().total_cmp(&rest[(*b, j)].abs()));
        let Some(pivot) = pivot else { break };
        chosen.push(pivot);
        let divisor = rest[(pivot, j)];
        if divisor == 0.0 {
            continue;
        }
        let row = rest.row(pivot).into_owned();
        for i in 0..u.nrows() {
            let factor = rest[(i, j)] / divisor;
            for k in j + 1..rank {
                rest[(i, k)] -= factor * row[k];
            }
        }
    }
    let mut quotient = interpolant(u, &chosen);
    for _ in 0..10 * rank {
        let (i, j) = quotient.iamax_full();
        let largest = quotient[(i, j)];
        if largest.abs() <= VOLUME || !largest.is_finite() {
            break;
        }
        // Row i in the place of the j-th chosen one: U(R, :) changes by one row, its inverse by rank 1.
        let mut change = quotient.row(i).into_owned();
        change[j] -= 1.0;
        let column = quotient.column(j) / largest;
        quotient -= column * change;
        chosen[j] = i;
    }
    chosen
}

/// `U U(R, :)^-1`; U where the rows are dependent.
fn interpolant(u: &DMatrix<f64>, chosen: &[usize]) -> DMatrix<f64> {
    let square = DMatrix::from_fn(chosen.len(), u.ncols(), |i, j| u[(chosen[i], j)]);
    // X S = U as S' X' = U'.
    square.transpose().lu().solve(&u.transpose()).map_or_else(|| u.clone(), |x| x.transpose())
}

/// From rows (r, i) and columns to a matrix for each i.
fn arranged(core: &DMatrix<f64>, count: usize) -> Core {
    let (rows, columns) = (core.nrows() / count, core.ncols());
    let entry = |at: usize| {
        let (i, rest) = (at / (rows * columns), at % (rows * columns));
        core[((rest / columns) * count + i, rest % columns)]
    };
    Core { count, rows, columns, entries: (0..count * rows * columns).map(entry).collect() }
}

/// The approximation at a point of the grid.
fn product<const N: usize, const Z: usize>(cores: &[Core], index: &[usize; N]) -> SVector<f64, Z> {
    let mut value = vec![1.0];
    for (core, &k) in cores.iter().zip(index).rev() {
        let Core { rows, columns, ref entries, .. } = *core;
        let matrix = &entries[k * rows * columns..][..rows * columns];
        value = matrix.chunks(columns).map(|row| row.iter().zip(&value).map(|(a, b)| a * b).sum()).collect();
    }
    SVector::from_fn(|z, _| value[z])
}

/// The cores interpolated along their axes.
fn spline<const N: usize, const Z: usize>(
    domain: &Domain<N>,
    points: [usize; N],
    cores: &[Core],
) -> Result<Train<N, Z>, NumericalKklError> {
    let ranks = core::array::from_fn(|axis| cores[axis].rows);
    let along = |core: &Core| along_axis(&core.entries, (1, core.count, core.rows * core.columns));
    let coefficients = cores.iter().flat_map(along).collect();
    Ok(TensorTrain::new(*domain.lower(), *domain.upper(), points, ranks, coefficients)?)
}
