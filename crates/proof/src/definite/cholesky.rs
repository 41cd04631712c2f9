//! Proof of positive definiteness by a completed floating-point Cholesky factorisation whose rounding errors are
//! covered by a shift of the diagonal (Rump, "Verification of positive definiteness", BIT 46, 2006; the bound below is
//! derived here).
//!
//! **Setting.** u = 2^-53, eta = 2^-1075 (half the smallest subnormal). For floats, `fl(x + y) = (x + y)/(1 + e)`,
//! `fl(xy) = xy(1 + e) + f`, `fl(x/y) = (x/y)/(1 + e) + f`, `fl(sqrt x) = sqrt(x)/(1 + e)`, with |e| <= u and |f| <=
//! eta, f other than 0 only when the result underflows. Products of k factors (1 + e)^(+-1) are 1 + t with |t| <= g_k
//! := k u/(1 - k u).
//!
//! **One entry.** Cholesky computes from symmetric B an upper triangular R by
//! `s_0 = b_ij, s_k = fl(s_{k-1} - fl(r_ki r_kj))` for k = 1..m (m = i - 1 <= n - 1, counted from 1), then
//! `r_ij = fl(s_m / r_ii)` for j > i, and `r_ii = fl(sqrt(s_m))`, which needs s_m > 0. From
//! `s_{k-1} = fl(r_ki r_kj) + (1 + e_k) s_k`, unrolled,
//! ```text
//! b_ij = sum_k r_ki r_kj (1 + t_k) + r_ii r_ij (1 + t) + f_ij,
//! |t_k| <= g_k,  |t| <= g_{m+2},  |f_ij| <= (1 + g_n)(m + r_ii) eta:
//! ```
//! the k-th product has its own factor and those of k - 1 sums; the last product has those of m sums and one of the
//! quotient, or two of the root. With g = g_{n+1} and `|r|_i` the Euclidean norm of column i of R, Cauchy-Schwarz gives
//! ```text
//! R'R = B + D,  |d_ij| <= g |r|_i |r|_j + f,    f = 2 (n + max_i r_ii) eta.
//! ```
//! **All entries.** For i = j the first bound gives `|r|_i^2 <= (b_ii + f)/(1 - g)`. So
//! `|d_ij| <= g/(1-g) sqrt((b_ii + f)(b_jj + f)) + f`, and as the matrix `x x'` has the norm `x'x`,
//! ```text
//! |D|_2 <= h := g/(1 - g) (trace B + n f) + n f.
//! ```
//! R has positive diagonal, so `B + D = R'R > 0` and **`B + h I > 0`, strictly**. NaN and infinities are detected: an
//! entry of a column that is not finite makes that column's s_m for the diagonal NaN or -inf, which is not > 0.
//!
//! **Use.** To prove `M - c I > 0` for all M with `|M - mid| <= rad` entrywise:
//! 1. `a_ii`, a lower bound of `mid_ii - rad_ii - c`, must be positive (lowering a diagonal only makes the task
//!    harder);
//! 2. scale rows and columns by powers of two so that the diagonal lies in [1, 4); this is exact but for entries off
//!    the diagonal that underflow, by at most 2^-1074 each, which joins the radius. Then r_ii <= 2 (1 + g) and the
//!    bound h is near its best for matrices of any scaling;
//! 3. by `2 |x_i x_j| <= x_i^2 + x_j^2`, uncertainty `rad_ij` off the diagonal costs at most `rho_i = sum_j rad_ij` on
//!    the diagonal;
//! 4. factor B = scaled - diag(rho_i + h), with the diagonal rounded down.

use crate::exact::power_of_two;
use crate::matrix::Matrix;

/// A symmetric matrix of floats with a nonnegative radius for each entry.
#[derive(Debug, Clone)]
pub(super) struct Ball {
    pub(super) mid: Matrix<f64>,
    /// Radii, nonnegative.
    pub(super) rad: Matrix<f64>,
}

/// Approximate factorisation `D B D ~ R'R` in the row order `order`, with `D = diag(2^-exponent)`.
#[derive(Debug, Clone)]
pub(super) struct Factor {
    /// Upper triangular.
    pub(super) r: Matrix<f64>,
    /// Exponents of D, in the order of the rows of `r`.
    pub(super) exponent: Vec<i64>,
    /// Row k of `r` belongs to row `order[k]` of the matrix.
    pub(super) order: Vec<usize>,
}

/// Result of a Cholesky factorisation.
pub(super) enum Completion {
    /// Completed with positive pivots: definiteness is proved, rounding errors included.
    Certified(Factor),
    /// Stopped at a pivot that is not positive, in row `row`; the rows of `r` before it belong to the factor.
    Stopped { r: Matrix<f64>, exponent: Vec<i64>, row: usize },
    /// No factorisation: a diagonal entry less its radius is not positive, or a number overflows.
    NotTried,
}

/// For positive finite x, the exponent k with `x 2^(-2k)` in [1, 4).
pub fn half_exponent(x: f64) -> i64 {
    let biased = (x.to_bits() >> 52).cast_signed();
    let exponent = if biased == 0 { -1011 - i64::from(x.to_bits().leading_zeros()) } else { biased - 1023 };
    exponent.div_euclid(2)
}

/// `x 2^k` with at most one rounding, for k >= -1022. Infinite on overflow.
pub fn times_power_of_two(x: f64, k: i64) -> f64 {
    if k > 1023 { x * power_of_two(1023) * power_of_two(k - 1023) } else { x * power_of_two(k) }
}

/// Tries to prove `M - c I > 0` for every symmetric M in the ball. Cost: n^3/3 flops.
pub(super) fn certify(ball: &Ball, c: f64) -> Completion {
    let n = ball.mid.rows();
    let mut exponent = Vec::with_capacity(n);
    let mut lowered = Vec::with_capacity(n);
    for i in 0..n {
        let entry = down(down(ball.mid[(i, i)] - ball.rad[(i, i)], ball.rad[(i, i)]) - c, c);
        if !(entry > 0.0 && entry.is_finite()) {
            return Completion::NotTried;
        }
        lowered.push(entry);
        exponent.push(half_exponent(entry));
    }
    let mut b = Matrix::from_fn(n, n, |_, _| 0.0);
    let mut rho = vec![0.0_f64; n];
    for i in 0..n {
        b[(i, i)] = times_power_of_two(lowered[i], -2 * exponent[i]);
        for j in i + 1..n {
            // -(k_i + k_j) >= -1022, because k <= 511.
            let k = -(exponent[i] + exponent[j]);
            let (x, radius) = (ball.mid[(i, j)], ball.rad[(i, j)]);
            let scaled = times_power_of_two(x, k);
            b[(i, j)] = scaled;
            // Scaling by a power of two is exact, except for underflow, where the error is at most 2^-1074.
            let mut error = 0.0;
            if radius > 0.0 {
                error = times_power_of_two(radius, k).next_up();
            }
            if x != 0.0 && scaled.abs() < 2.0 * f64::MIN_POSITIVE {
                error = (error + f64::from_bits(1)).next_up();
            }
            if error > 0.0 {
                rho[i] = (rho[i] + error).next_up();
                rho[j] = (rho[j] + error).next_up();
            }
        }
    }
    let shift = rounding_bound(n, &b);
    for i in 0..n {
        b[(i, i)] = (b[(i, i)] - (rho[i] + shift).next_up()).next_down();
    }
    match factor(b) {
        Ok(r) => Completion::Certified(Factor { r, exponent, order: (0..n).collect() }),
        Err((r, row)) => Completion::Stopped { r, exponent, row },
    }
}

/// `value`, the computed result of subtracting `term`, rounded down; unchanged if `term` is 0.
fn down(value: f64, term: f64) -> f64 {
    if term == 0.0 { value } else { value.next_down() }
}

/// The bound h of the head of this file, for a diagonal in [1, 4), where `2 (n + max r_ii) eta <= (n + 3) 2^-1074`. The
/// result is far above the underflow range; the slack of a few ulps covers the rounding of the operations here.
pub(super) fn rounding_bound(n: usize, b: &Matrix<f64>) -> f64 {
    let slack = 1.0 + 64.0 * f64::EPSILON;
    let ratio = relative_rounding_bound(n);
    // The rounding errors of a sum of n positive numbers are below the factor 1 + 2 n u.
    let trace = (0..n).map(|i| b[(i, i)]).sum::<f64>() * (1.0 + 2.0 * n as f64 * f64::EPSILON);
    let underflow = n as f64 * (n as f64 + 3.0) * f64::MIN_POSITIVE;
    (ratio * (trace + underflow) + underflow) * slack
}

/// `g/(1 - g) = k u / (1 - 2 k u)` for `g = g_k`, k = n + 1, up to a few roundings.
pub(super) fn relative_rounding_bound(n: usize) -> f64 {
    let k_u = (n as f64 + 1.0) * (f64::EPSILON / 2.0);
    k_u / (1.0 - 2.0 * k_u)
}

/// Upper triangular R with `R'R ~ B`, from the upper triangle of B. Each entry undergoes the operations of the head of
/// this file in their order. Rows are processed one by one or, to reduce memory traffic for large matrices, `PANEL` at
/// a time; the order of operations is the same.
/// # Errors
/// On an early stop the partial result and the row of the failed pivot.
pub fn factor(mut b: Matrix<f64>) -> Result<Matrix<f64>, (Matrix<f64>, usize)> {
    let n = b.rows();
    for first in (0..n).step_by(PANEL) {
        let next = (first + PANEL).min(n);
        for k in first..next {
            let pivot = b[(k, k)];
            // The negated test also catches NaN.
            if !(pivot > 0.0 && pivot.is_finite()) {
                // Rows beyond the panel are not updated yet; they are not used after an early stop.
                return Err((b, k));
            }
            let root = pivot.sqrt();
            b[(k, k)] = root;
            for x in &mut b.row_mut(k)[k + 1..] {
                *x /= root;
            }
            let row: Vec<f64> = b.row(k)[k..].to_vec();
            for i in k + 1..next {
                let x = row[i - k];
                for (entry, y) in b.row_mut(i)[i..].iter_mut().zip(&row[i - k..]) {
                    *entry -= x * y;
                }
            }
        }
        let (done, rest) = b.as_mut_slice().split_at_mut(next * n);
        subtract_products(&done[first * n..], rest, n, next);
    }
    Ok(b)
}

/// Rows processed together.
const PANEL: usize = 48;

/// Columns kept in cache while the rows of a panel are processed.
const STRIP: usize = 64;

/// Rows and columns of a tile kept in registers.
const TILE: usize = 4;

/// Updates `b_ij -= r_ki r_kj` for the rows k of the panel in order, and i, j >= `first`, j >= i. `rest` begins with
/// the row `first`.
fn subtract_products(panel: &[f64], rest: &mut [f64], n: usize, first: usize) {
    for strip in (first..n).step_by(STRIP) {
        let end = (strip + STRIP).min(n);
        for i in (first..end).step_by(TILE) {
            let below = (i + TILE).min(n);
            // Complete tiles to the right of the diagonal; the other entries one by one.
            let from = strip.max(below);
            let tiles = if below == i + TILE { end.saturating_sub(from) / TILE } else { 0 };
            for j in (0..tiles).map(|k| from + k * TILE) {
                tile(panel, rest, n, (i, j, first));
            }
            for row in i..below {
                for column in (strip.max(row)..end.min(below)).chain(from + tiles * TILE..end) {
                    single(panel, rest, n, (row, column, first));
                }
            }
        }
    }
}

fn single(panel: &[f64], rest: &mut [f64], n: usize, (i, j, first): (usize, usize, usize)) {
    let entry = &mut rest[(i - first) * n + j];
    let mut sum = *entry;
    for row in panel.chunks_exact(n) {
        sum -= row[i] * row[j];
    }
    *entry = sum;
}

fn tile(panel: &[f64], rest: &mut [f64], n: usize, (i, j, first): (usize, usize, usize)) {
    let mut sums = [[0.0; TILE]; TILE];
    for (row, sums) in sums.iter_mut().enumerate() {
        sums.copy_from_slice(&rest[(i + row - first) * n + j..][..TILE]);
    }
    for row in panel.chunks_exact(n) {
        let (x, y) = (&row[i..i + TILE], &row[j..j + TILE]);
        for (sums, x) in sums.iter_mut().zip(x) {
            for (sum, y) in sums.iter_mut().zip(y) {
                *sum -= x * y;
            }
        }
    }
    for (row, sums) in sums.iter().enumerate() {
        rest[(i + row - first) * n + j..][..TILE].copy_from_slice(sums);
    }
}

impl Factor {
    /// Estimate of the smallest eigenvalue of the factored matrix and its eigenvector, by inverse iteration; not
    /// rigorous, an upper estimate up to rounding. `None` on overflow or underflow.
    pub(super) fn smallest_eigenvalue(&self) -> Option<(f64, Vec<f64>)> {
        let n = self.order.len();
        let least = self.exponent.iter().copied().min()?;
        // Scaled by 2^(2 least), so that the entries of D are at most 1.
        let d: Vec<f64> = self.exponent.iter().map(|k| power_of_two(least - k)).collect();
        // An asymmetric starting vector, unlikely to be orthogonal to the eigenvector.
        let mut x: Vec<f64> = (0..n).map(|i| 1.0 + (i as f64 * 0.618_033_988_75).fract()).collect();
        normalise(&mut x)?;
        let mut estimate = f64::INFINITY;
        for _ in 0..60 {
            let mut y: Vec<f64> = x.iter().zip(&d).map(|(x, d)| x * d).collect();
            self.solve(&mut y);
            for (y, d) in y.iter_mut().zip(&d) {
                *y *= d;
            }
            let xy: f64 = x.iter().zip(&y).map(|(x, y)| x * y).sum();
            let length = normalise(&mut y)?;
            x = y;
            // The Rayleigh quotient of y = M^-1 x is y'x / y'y.
            let quotient = xy / length / length;
            let settled = (estimate - quotient).abs() <= 1e-14 * quotient.abs();
            estimate = quotient;
            if settled {
                break;
            }
        }
        let mut v = vec![0.0; n];
        for (x, &i) in x.iter().zip(&self.order) {
            v[i] = *x;
        }
        let value = estimate * power_of_two(least) * power_of_two(least);
        (value.is_finite() && value > 0.0).then_some((value, v))
    }

    /// Solves `R'R y = b` in place.
    pub(super) fn solve(&self, y: &mut [f64]) {
        let n = y.len();
        for k in 0..n {
            let z = y[k] / self.r[(k, k)];
            y[k] = z;
            for (entry, r) in y[k + 1..].iter_mut().zip(&self.r.row(k)[k + 1..]) {
                *entry -= r * z;
            }
        }
        for k in (0..n).rev() {
            let sum: f64 = y[k + 1..].iter().zip(&self.r.row(k)[k + 1..]).map(|(y, r)| y * r).sum();
            y[k] = (y[k] - sum) / self.r[(k, k)];
        }
    }
}

/// Scales x to length 1 and returns the previous length; `None` if that is 0 or not finite.
fn normalise(x: &mut [f64]) -> Option<f64> {
    let largest = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) || x.iter().any(|x| x.is_nan()) {
        return None;
    }
    let length = x.iter().map(|x| (x / largest) * (x / largest)).sum::<f64>().sqrt();
    for x in x.iter_mut() {
        *x = *x / largest / length;
    }
    Some(length * largest)
}

/// Fractions of the estimated eigenvalue that are tried as margins, in decreasing order.
const SHARES: [f64; 9] = [1.0 - 1e-12, 1.0 - 1e-9, 1.0 - 1e-6, 1.0 - 1e-3, 0.97, 0.75, 0.25, 1e-2, 1e-5];

/// `(margin, estimate)`: a proven lower bound of the smallest eigenvalue over the ball (0 if none is found), and an
/// estimate of it. `factor` must be a certified factorisation. At most a dozen factorisations.
pub(super) fn margin(ball: &Ball, factor: &Factor) -> (f64, f64) {
    let Some((estimate, _)) = factor.smallest_eigenvalue() else { return (0.0, 0.0) };
    let proves = |c: f64| c > 0.0 && matches!(certify(ball, c), Completion::Certified(_));
    let mut failed = estimate;
    for share in SHARES {
        let mut proved = share * estimate;
        if proves(proved) {
            // A few bisection steps between the proved and the failed value.
            for _ in 0..5 {
                if failed - proved <= 0.01 * proved {
                    break;
                }
                let middle =
                    if proved < 0.1 * failed { (proved * failed).sqrt() } else { f64::midpoint(proved, failed) };
                if proves(middle) {
                    proved = middle;
                } else {
                    failed = middle;
                }
            }
            return (proved, estimate);
        }
        failed = share * estimate;
    }
    (0.0, estimate)
}
