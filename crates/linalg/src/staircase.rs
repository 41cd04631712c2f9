//! Controllability staircase `Q'F Q`, `Q'G` of a pair `(F, G)`, by Householder reflections.
//!
//! ```text
//! Q'G = [B1]    Q'F Q = [F11 F12 ..  F1k  *  ]      B1 and the F_{i+1,i} of full row rank,
//!       [0 ]            [F21 F22 ..  F2k  *  ]      Fu: the block that no input reaches,
//!       [0 ]            [ 0  F32 ..  F3k  *  ]      of order n - rank.
//!                       [ 0   0  ..   0   Fu ]
//! ```
//!
//! For one input this is the Hessenberg form. For the observability of `(A, C)` take `F = A'`, `G = C'`: the last
//! columns of `Q` span the unobservable subspace. Ranks are determined by QR with column pivoting; pivots at or below
//! `tolerance` count as zero. Backward stable, as every step is orthogonal (Paige, IEEE TAC 26, 1981; Varga,
//! Electronics Letters 1981; SLICOT AB01ND). At most 10 n^3 flops.

use nalgebra::DMatrix;

/// The reduced pair and the orthogonal matrix that reduces it.
#[derive(Debug, Clone)]
pub struct Staircase {
    /// Orthogonal, n x n.
    pub q: DMatrix<f64>,
    /// `Q'F Q`, the entries below the stairs exactly zero.
    pub f: DMatrix<f64>,
    /// `Q'G`, the entries below the first stair exactly zero.
    pub g: DMatrix<f64>,
    /// Order of the controllable part.
    pub rank: usize,
    /// The heights of the stairs, which sum up to the rank and do not increase: how many inputs reach a state after so
    /// many integrations.
    pub stairs: Vec<usize>,
}

impl Staircase {
    /// Staircase of `f` (n x n) and `g` (n x m).
    pub fn new(f: &DMatrix<f64>, g: &DMatrix<f64>, tolerance: f64) -> Self {
        let n = f.nrows();
        let mut s = Self { q: DMatrix::identity(n, n), f: f.clone(), g: g.clone(), rank: 0, stairs: Vec::new() };
        let mut block = s.g.clone();
        let mut stair = s.compress(&mut block, tolerance);
        s.g.copy_from(&block);
        // Each pass increases the rank by at least one.
        while stair > 0 {
            let before = s.rank;
            s.rank += stair;
            s.stairs.push(stair);
            let below = n - s.rank;
            if below == 0 {
                break;
            }
            let mut block = s.f.view((s.rank, before), (below, stair)).into_owned();
            stair = s.compress(&mut block, tolerance);
            s.f.view_mut((s.rank, before), (below, block.ncols())).copy_from(&block);
        }
        s
    }

    /// Estimate of `min sigma_min([G, F - lambda I])` over the eigenvalues lambda of F, at most about ten times too
    /// large; zero if a row has no pivot.
    ///
    /// The columns in which the stairs have their pivots form an upper triangular `R(lambda)` with the pivots on its
    /// diagonal; lambda occurs above it only, so `R^-1` is a polynomial in lambda of degree below n. On the spectrum it
    /// is at most its maximum on a circle around the spectrum (maximum principle), and that is at most three times its
    /// maximum at n points (the Lebesgue constant of the roots of unity); half of these are conjugates of the others.
    /// At each point one generic right-hand side is solved for. The radius is `|(F - c I)^8|^(1/8)`. `7 n^3` flops.
    ///
    /// On the circle `R^-1` can grow with n although it does not on the spectrum, like `e^(n/2)` for random matrices:
    /// for orders beyond about thirty the pair seems nearer to uncontrollable than it is.
    pub fn least_margin(&self) -> f64 {
        let (n, m) = self.g.shape();
        let column = |j: usize| if j < m { self.g.column(j) } else { self.f.column(j - m) };
        // The pivot of a row is the last nonzero entry of its column; of several candidates, the largest.
        let mut pivots: Vec<Option<(usize, f64)>> = vec![None; n];
        for j in 0..m + n {
            let Some(last) = column(j).iter().rposition(|x| *x != 0.0) else { continue };
            let size = column(j)[last].abs();
            if (j < m || j - m < last) && pivots[last].is_none_or(|(_, best)| size > best) {
                pivots[last] = Some((j, size));
            }
        }
        let centre = self.f.trace() / n as f64;
        let mut power = self.f.clone();
        for i in 0..n {
            power[(i, i)] -= centre;
        }
        for _ in 0..3 {
            power = &power * &power;
        }
        let radius = power.norm().sqrt().sqrt().sqrt();

        // Row i of the solution at all points: real parts, then imaginary parts.
        let points = n / 2 + 1;
        let mut x = vec![0.0; n * 2 * points];
        for (i, row) in x.chunks_exact_mut(2 * points).enumerate() {
            row[..points].fill(1.0 + 0.5 * ((i as f64 + 1.0) * 2.399_963).cos());
        }
        let angle = |k: usize| core::f64::consts::PI * (2 * k + 1) as f64 / (2 * points) as f64;
        let circle: Vec<(f64, f64)> = (0..points).map(|k| angle(k).sin_cos()).collect();
        for i in (0..n).rev() {
            let Some((j, _)) = pivots[i] else { return 0.0 };
            let entries = column(j);
            let (above, row) = x[..(i + 1) * 2 * points].split_at_mut(i * 2 * points);
            for x in row.iter_mut() {
                *x /= entries[i];
            }
            for (above, entry) in above.chunks_exact_mut(2 * points).zip(entries.iter()) {
                for (above, x) in above.iter_mut().zip(&*row) {
                    *above -= entry * x;
                }
            }
            if let Some(above) = j.checked_sub(m).and_then(|at| above.chunks_exact_mut(2 * points).nth(at)) {
                let ((re, im), (x_re, x_im)) = (above.split_at_mut(points), row.split_at(points));
                for (k, (sin, cos)) in circle.iter().enumerate() {
                    let lambda = (centre + radius * cos, radius * sin);
                    re[k] += lambda.0 * x_re[k] - lambda.1 * x_im[k];
                    im[k] += lambda.0 * x_im[k] + lambda.1 * x_re[k];
                }
            }
        }
        let largest = x.into_iter().fold(0.0, |largest: f64, x| if x.is_nan() { x } else { largest.max(x.abs()) });
        if largest.is_finite() && largest > 0.0 { 1.0 / largest } else { 0.0 }
    }

    /// Reflects the rows `rank..`, given in `block`, so that only the first r of them are nonzero; returns r.
    fn compress(&mut self, block: &mut DMatrix<f64>, tolerance: f64) -> usize {
        let Self { q, f, rank, .. } = self;
        compress_rows(block, tolerance, |reflection, row| {
            let first = *rank + row;
            reflection.act_on_rows(f, first);
            reflection.act_on_columns(f, first);
            reflection.act_on_columns(q, first);
        })
    }
}

/// Reflects the rows of `block` so that its first r rows have full rank and the others are exactly zero, with column
/// pivoting; pivots at or below `tolerance` count as zero. `act` receives each reflection with the first row it acts
/// on. Returns r.
pub(crate) fn compress_rows(
    block: &mut DMatrix<f64>,
    tolerance: f64,
    mut act: impl FnMut(&Reflection, usize),
) -> usize {
    let (rows, columns) = block.shape();
    let mut pivots: Vec<usize> = (0..columns).collect();
    let mut r = 0;
    while r < rows.min(columns) {
        let norm = |j: usize| block.column(j).rows(r, rows - r).norm();
        let Some((at, largest)) =
            (r..columns).map(|at| (at, norm(pivots[at]))).fold(None, |best: Option<(usize, f64)>, x| {
                if best.is_none_or(|b| x.1 > b.1) { Some(x) } else { best }
            })
        else {
            break;
        };
        if largest <= tolerance {
            break;
        }
        pivots.swap(r, at);
        let reflection = Reflection::onto_first(&block.column(pivots[r]).rows(r, rows - r).into_owned());
        reflection.act_on_rows(block, r);
        act(&reflection, r);
        block.view_mut((r + 1, pivots[r]), (rows - r - 1, 1)).fill(0.0);
        r += 1;
    }
    block.view_mut((r, 0), (rows - r, columns)).fill(0.0);
    r
}

/// `I - tau v v'`, `tau = 2/v'v`. Not normalised, so that it is exact for small integers.
pub(crate) struct Reflection {
    v: nalgebra::DVector<f64>,
    tau: f64,
}

impl Reflection {
    /// The reflection that maps `x` to a multiple of the first unit vector; the identity if `x` is such a multiple.
    fn onto_first(x: &nalgebra::DVector<f64>) -> Self {
        let mut v = x.clone();
        // Squares of entries below 1e-154 would underflow.
        if v.amax() < 1e-100 {
            v /= v.amax().max(f64::MIN_POSITIVE);
        }
        if x.iter().skip(1).all(|x| *x == 0.0) {
            return Self { v, tau: 0.0 };
        }
        // Same sign: no cancellation.
        v[0] += v.norm().copysign(v[0]);
        let tau = 2.0 / v.norm_squared();
        Self { v, tau }
    }

    /// Applies the reflection to the rows `first..` of `m`.
    pub(crate) fn act_on_rows(&self, m: &mut DMatrix<f64>, first: usize) {
        let rows = m.nrows();
        if self.tau == 0.0 || rows == 0 {
            return;
        }
        let v = self.v.as_slice();
        for column in m.as_mut_slice().chunks_exact_mut(rows) {
            let column = &mut column[first..first + v.len()];
            let projection = self.tau * dot(column, v);
            subtract(column, projection, v);
        }
    }

    /// Applies the reflection to the columns `first..` of `m`.
    pub(crate) fn act_on_columns(&self, m: &mut DMatrix<f64>, first: usize) {
        let rows = m.nrows();
        if self.tau == 0.0 || rows == 0 {
            return;
        }
        let v = self.v.as_slice();
        let columns = &mut m.as_mut_slice()[first * rows..(first + v.len()) * rows];
        let mut image = vec![0.0; rows];
        for (column, v) in columns.chunks_exact(rows).zip(v) {
            subtract(&mut image, -v, column);
        }
        for (column, v) in columns.chunks_exact_mut(rows).zip(v) {
            subtract(column, self.tau * v, &image);
        }
    }
}

/// `x'y`, in four independent sums.
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    let (x, y) = (x.chunks_exact(4), y.chunks_exact(4));
    let rest: f64 = x.remainder().iter().zip(y.remainder()).map(|(x, y)| x * y).sum();
    let mut sums = [0.0; 4];
    for (x, y) in x.zip(y) {
        for (sum, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
            *sum += x * y;
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// `x := x - factor y`.
pub(crate) fn subtract(x: &mut [f64], factor: f64, y: &[f64]) {
    for (x, y) in x.iter_mut().zip(y) {
        *x -= factor * y;
    }
}
