//! Controllability staircase `Q'F Q`, `Q'G` of a pair `(F, G)`, by Householder reflections.
//!
//! ```text
//! Q'G = [B1]    Q'F Q = [F11 F12 ..  F1k  *  ]      B1 and the F_{i+1,i} of full row rank,
//!       [0 ]            [F21 F22 ..  F2k  *  ]      Fu: the block that no input reaches,
//!       [0 ]            [ 0  F32 ..  F3k  *  ]      of order n - rank.
//!                       [ 0   0  ..   0   Fu ]
//! ```
//!
//! For one input this is the Hessenberg form. For the observability of `(A, C)` take `F = A'`, `G = C'`: the last columns of `Q` span
//! the unobservable subspace. Ranks are decided by QR with column pivoting, pivots at or below `tolerance` being zero: backward stable,
//! as every step is orthogonal (Paige, IEEE TAC 26, 1981; Varga, Electronics Letters 1981; SLICOT AB01ND). 10 n^3 flops at most.

use nalgebra::DMatrix;

/// The reduced pair and the orthogonal matrix that reduces it.
#[derive(Debug, Clone)]
pub(crate) struct Staircase {
    /// Orthogonal, n x n.
    pub(crate) q: DMatrix<f64>,
    /// `Q'F Q`, the entries below the stairs exactly zero.
    pub(crate) f: DMatrix<f64>,
    /// `Q'G`, the entries below the first stair exactly zero.
    pub(crate) g: DMatrix<f64>,
    /// Order of the reachable part.
    pub(crate) rank: usize,
}

impl Staircase {
    /// Staircase of `f` (n x n) and `g` (n x m).
    pub(crate) fn new(f: &DMatrix<f64>, g: &DMatrix<f64>, tolerance: f64) -> Self {
        let n = f.nrows();
        let mut s = Self { q: DMatrix::identity(n, n), f: f.clone(), g: g.clone(), rank: 0 };
        let mut block = s.g.clone();
        let mut stair = s.compress(&mut block, tolerance);
        s.g.copy_from(&block);
        // Each turn adds at least one to the rank.
        while stair > 0 {
            let before = s.rank;
            s.rank += stair;
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

    /// Reflects the rows `rank..` so that `block` (these rows) is nonzero in its first r rows only; returns r.
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

/// Reflects the rows of `block` so that its first r rows have full rank and the others are exactly zero, columns with the largest pivots first, pivots at or
/// below `tolerance` being zero. Each reflection is handed to `act` with the first row it acts on. Returns r.
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

/// `I - tau v v'`, `tau = 2/v'v`. Not normalised: on small integers it stays exact.
pub(crate) struct Reflection {
    v: nalgebra::DVector<f64>,
    tau: f64,
}

impl Reflection {
    /// The reflection that takes `x` to a multiple of the first unit vector; the identity if it is one.
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

    /// Rows `first..` of `m`.
    pub(crate) fn act_on_rows(&self, m: &mut DMatrix<f64>, first: usize) {
        if self.tau == 0.0 {
            return;
        }
        let mut rows = m.rows_mut(first, self.v.len());
        for mut column in rows.column_iter_mut() {
            let projection = self.tau * column.dot(&self.v);
            column.axpy(-projection, &self.v, 1.0);
        }
    }

    /// Columns `first..` of `m`.
    pub(crate) fn act_on_columns(&self, m: &mut DMatrix<f64>, first: usize) {
        if self.tau == 0.0 {
            return;
        }
        let mut columns = m.columns_mut(first, self.v.len());
        let image = &columns * &self.v;
        columns.ger(-self.tau, &image, &self.v, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SLICOT AB01ND, example program: rank 2, `Q'F Q` reachable block similar to [-3 2.2361; 0 -1], `Q'G` = [0 -2.2361; 1 0].
    #[test]
    fn the_example_of_slicot_ab01nd() {
        let a = DMatrix::from_row_slice(3, 3, &[-1.0, 0.0, 0.0, -2.0, -2.0, -2.0, -1.0, 0.0, -3.0]);
        let b = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 0.0, 2.0, 0.0, 1.0]);
        let s = Staircase::new(&a, &b, 1e-14);
        assert_eq!(s.rank, 2);
        // Pivoting takes the longer column of B, (0,2,1) of norm sqrt 5, first: the order of SLICOT's answer.
        let sizes = s.f.map(f64::abs);
        for (entry, printed) in [((0, 0), 3.0), ((0, 1), 2.2361), ((1, 0), 0.0), ((1, 1), 1.0)] {
            assert!((sizes[entry] - printed).abs() < 5e-5, "{entry:?}: {} printed {printed}", sizes[entry]);
        }
        assert!((s.g[(0, 1)].abs() - 2.2361).abs() < 5e-5 && (s.g[(1, 0)].abs() - 1.0).abs() < 1e-14);
        assert!((&s.q * &s.f * s.q.transpose() - &a).norm() < 1e-14 * a.norm() * 3.0);
        assert!((&s.q * &s.g - &b).norm() < 1e-14 * b.norm());
    }

    #[test]
    fn one_input_gives_the_hessenberg_form() {
        let a = DMatrix::from_fn(6, 6, |i, j| ((i * 7 + j * 3) % 11) as f64 - 5.0);
        let b = DMatrix::from_fn(6, 1, |i, _| 1.0 + i as f64);
        let s = Staircase::new(&a, &b, 1e-13);
        assert_eq!(s.rank, 6);
        for j in 0..6 {
            for i in j + 2..6 {
                assert_eq!(s.f[(i, j)], 0.0);
            }
        }
        assert!(s.g.rows(1, 5).iter().all(|x| *x == 0.0));
        assert!((&s.q * &s.f * s.q.transpose() - &a).norm() < 1e-14 * a.norm());
    }

    #[test]
    fn without_inputs_nothing_is_reached() {
        let a = DMatrix::identity(3, 3);
        assert_eq!(Staircase::new(&a, &DMatrix::zeros(3, 0), 0.0).rank, 0);
        assert_eq!(Staircase::new(&a, &DMatrix::zeros(3, 2), 0.0).rank, 0);
        assert_eq!(Staircase::new(&DMatrix::zeros(0, 0), &DMatrix::zeros(0, 2), 0.0).rank, 0);
    }
}
