//! Exact decision by fraction-free elimination (Bareiss, Math. Comp. 22, 1968) with diagonal pivoting, on integers.
//!
//! For a positive diagonal D of powers of two, `D M D` and M have the same definiteness, and `D M D` times a power of
//! two is an integer matrix A. After k steps of Bareiss elimination with diagonal pivots, the remaining entry (i, j) is
//! the minor of A with the k pivot rows and columns bordered by i and j. It is an integer, and equals the Schur
//! complement times the minor of the pivots, which is positive while all pivots are. So the remaining entries have the
//! signs of the Schur complement S:
//! - a negative diagonal entry of S refutes semidefiniteness, and so does a zero diagonal entry whose row is not zero;
//! - a zero row of S gives a null vector, which refutes definiteness only; the row is left out of what follows;
//! - if no row remains, M is semidefinite, and definite if no row was left out.
//!
//! A direction w for S is lifted to `v = (-A_II^-1 A_IJ w, w)`, for which `v'Av = w'Sw`; by Cramer's rule v times the
//! minor of the pivots is an integer vector, found by fraction-free back substitution. Every witness is verified
//! against M before it is returned.

use std::cell::Cell;

use dashu_int::ops::BitTest;
use dashu_int::{IBig, Sign};

use super::cholesky::Factor;
use super::{Direction, quadratic_form};
use crate::exact::{Exact, power_of_two};
use crate::matrix::Matrix;
use crate::ring::Ring;

/// Limit of one elimination, in 64-bit word multiplications: some seconds.
const BUDGET: f64 = 3e9;

thread_local! {
    /// Remaining limit for the following eliminations on this thread.
    static ALLOWANCE: Cell<f64> = const { Cell::new(f64::INFINITY) };
}

/// Runs `work` with a common limit for all eliminations in it, on this thread; matrices beyond the limit stay
/// undecided. The work is counted, not timed, so the result is reproducible.
pub(super) fn within<T>(allowance: f64, work: impl FnOnce() -> T) -> T {
    struct Restore(f64);
    impl Drop for Restore {
        fn drop(&mut self) {
            ALLOWANCE.set(self.0);
        }
    }
    let _restore = Restore(ALLOWANCE.replace(allowance));
    work()
}

/// Result of exact elimination.
pub(super) enum Finding {
    /// All pivots are positive. The factor is rounded.
    Definite(Factor),
    /// Semidefinite and singular, with a vector v such that `Mv = 0`.
    Singular(Vec<Exact>),
    /// Indefinite, with a vector v such that `v'Mv < 0`.
    Indefinite(Vec<Exact>),
    /// Exceeds the limit of work.
    TooLarge,
}

/// The matrix as integers with its scaling: `A_ij = M_ij 2^-(k_i + k_j + unit)`.
struct Integers {
    a: Matrix<IBig>,
    exponent: Vec<i64>,
}

fn is_negative(x: &IBig) -> bool {
    x.sign() == Sign::Negative
}

/// A witness without elimination, from a diagonal entry or a 2 x 2 minor. This also excludes matrices whose large
/// off-diagonal entries would give very long integers.
fn obvious(m: &Matrix<Exact>) -> Option<Vec<Exact>> {
    let n = m.rows();
    let vector = |entries: &[(usize, Exact)]| {
        let mut v = vec![Exact::zero(); n];
        for (i, x) in entries {
            v[*i] = x.clone();
        }
        v
    };
    for i in 0..n {
        if m[(i, i)].signum() < 0 {
            return Some(vector(&[(i, Exact::power_of_two(0))]));
        }
    }
    for i in 0..n {
        for j in i + 1..n {
            let (x, a, b) = (&m[(i, j)], &m[(i, i)], &m[(j, j)]);
            let Some(size) = x.magnitude_exponent() else { continue };
            match (a.magnitude_exponent(), b.magnitude_exponent()) {
                (Some(ea), Some(eb)) => {
                    // x^2 >= 2^(2 size), a b < 2^(ea + eb + 2): usually decided without the products.
                    if 2 * size + 2 > ea + eb && x.mul(x) > a.mul(b) {
                        // (x, -a): a x^2 - 2 a x^2 + a^2 b = a (a b - x^2).
                        return Some(vector(&[(i, x.clone()), (j, a.neg())]));
                    }
                }
                (ea, eb) => {
                    // One diagonal entry is 0; t |x| >= the other makes the form -2 t |x| + the other < 0.
                    let t = ea.or(eb).map_or(0, |e| e + 1 - size);
                    let one = Exact::power_of_two(0);
                    let t = Exact::power_of_two(t);
                    let t = if x.signum() > 0 { t.neg() } else { t };
                    return Some(if ea.is_none() { vector(&[(i, t), (j, one)]) } else { vector(&[(i, one), (j, t)]) });
                }
            }
        }
    }
    None
}

fn integers(m: &Matrix<Exact>) -> Integers {
    let n = m.rows();
    let exponent: Vec<i64> = (0..n).map(|i| m[(i, i)].magnitude_exponent().map_or(0, |e| e.div_euclid(2))).collect();
    let scaled = |i: usize, j: usize| m[(i, j)].shifted(-(exponent[i] + exponent[j]));
    let mut unit: Option<i64> = None;
    for i in 0..n {
        for j in i..n {
            if !m[(i, j)].is_zero() {
                let e = scaled(i, j).exponent();
                unit = Some(unit.map_or(e, |u| u.min(e)));
            }
        }
    }
    let unit = unit.unwrap_or(0);
    let a = Matrix::from_fn(n, n, |i, j| {
        let x = scaled(i, j);
        if x.is_zero() { IBig::ZERO } else { x.mantissa().clone() << ((x.exponent() - unit) as usize) }
    });
    Integers { a, exponent }
}

/// Estimated work to eliminate an n x n matrix of integers of `bits` bits: minors of order k have k times the bits,
/// plus log k each, and a product of long integers costs the power 1.6 of their length.
fn work(n: usize, bits: usize) -> f64 {
    let order = n as f64;
    let words = 1.0 + order * (bits as f64 + order.log2().max(0.0)) / 128.0;
    order.powi(3) * words.powf(1.6)
}

/// Decides the definiteness of M by exact elimination.
pub(super) fn judge(m: &Matrix<Exact>) -> Finding {
    let n = m.rows();
    if n > super::REFEREE_ORDER {
        return Finding::TooLarge;
    }
    if let Some(v) = obvious(m) {
        return Finding::Indefinite(v);
    }
    let Integers { mut a, exponent } = integers(m);
    let bits = a.as_slice().iter().map(BitTest::bit_len).max().unwrap_or(0);
    let (cost, left) = (work(n, bits), ALLOWANCE.get());
    if cost > BUDGET.min(left) {
        return Finding::TooLarge;
    }
    ALLOWANCE.set(left - cost);
    let mut elimination = Elimination { order: Vec::with_capacity(n), exponent: &exponent };
    let mut remaining: Vec<usize> = (0..n).collect();
    let mut null: Option<usize> = None;
    let mut minor = IBig::ONE;
    loop {
        if let Some(&i) = remaining.iter().find(|&&i| is_negative(&a[(i, i)])) {
            return Finding::Indefinite(elimination.lift(&a, &minor, &[(i, IBig::ONE)]));
        }
        // Rows with a zero on the diagonal: a witness if another entry is not zero, otherwise a null vector.
        let mut positive = Vec::with_capacity(remaining.len());
        for &i in &remaining {
            if !a[(i, i)].is_zero() {
                positive.push(i);
            } else if let Some(&j) = remaining.iter().find(|&&j| !a[(i, j)].is_zero()) {
                // (t, 1) with 2 t a_ij + a_jj = -2 a_ij^2... t = -a_ij (a_jj + 1): a_jj - 2 a_ij^2 (a_jj + 1) < 0.
                let t = -(&a[(i, j)] * (&a[(j, j)] + IBig::ONE));
                return Finding::Indefinite(elimination.lift(&a, &minor, &[(i, t), (j, IBig::ONE)]));
            } else {
                null.get_or_insert(i);
            }
        }
        // The pivot with the fewest bits keeps the integers short.
        let Some(pivot) = positive.iter().copied().min_by_key(|&i| a[(i, i)].bit_len()) else { break };
        remaining = positive;
        remaining.retain(|&i| i != pivot);
        let p = a[(pivot, pivot)].clone();
        for (k, &i) in remaining.iter().enumerate() {
            for &j in &remaining[k..] {
                let x = (&p * &a[(i, j)] - &a[(i, pivot)] * &a[(pivot, j)]) / &minor;
                a[(j, i)].clone_from(&x);
                a[(i, j)] = x;
            }
        }
        elimination.order.push(pivot);
        minor = p;
    }
    match null {
        Some(i) => Finding::Singular(elimination.lift(&a, &minor, &[(i, IBig::ONE)])),
        None => Finding::Definite(elimination.rounded(&a, m)),
    }
}

struct Elimination<'a> {
    /// The pivots so far. Row k of the triangular factor is stored in row `order[k]` of the matrix.
    order: Vec<usize>,
    exponent: &'a [i64],
}

impl Elimination<'_> {
    /// The direction of M for the direction `w` of the Schur complement.
    fn lift(&self, a: &Matrix<IBig>, minor: &IBig, w: &[(usize, IBig)]) -> Vec<Exact> {
        let mut v = vec![IBig::ZERO; self.exponent.len()];
        for (i, x) in w {
            v[*i] = x * minor;
        }
        for (k, &i) in self.order.iter().enumerate().rev() {
            let mut sum = IBig::ZERO;
            for &j in self.order[k + 1..].iter().chain(w.iter().map(|(j, _)| j)) {
                sum += &a[(i, j)] * &v[j];
            }
            // The division is exact, by Cramer's rule.
            v[i] = -sum / &a[(i, i)];
        }
        v.into_iter().zip(self.exponent).map(|(x, k)| Exact::new(x, -k)).collect()
    }

    /// `L D L'` with rounded L and D, as a Cholesky factor of M.
    fn rounded(&self, a: &Matrix<IBig>, m: &Matrix<Exact>) -> Factor {
        let n = self.order.len();
        let mut r = Matrix::from_fn(n, n, |_, _| 0.0);
        let mut before: Option<&IBig> = None;
        for (k, &i) in self.order.iter().enumerate() {
            let pivot = &a[(i, i)];
            // Relative to the first pivot, the scaled entry of M in [1, 4).
            let d = before.map_or(1.0, |minor| quotient(pivot, &(minor * &a[(self.order[0], self.order[0])])));
            for (l, &j) in self.order.iter().enumerate().skip(k) {
                r[(k, l)] = quotient(&a[(i, j)], pivot) * d.sqrt();
            }
            before = Some(pivot);
        }
        let first = self.order.first().map_or(1.0, |&i| m[(i, i)].shifted(-2 * self.exponent[i]).round_down());
        let r = r.map(|x| x * first.sqrt());
        Factor { r, exponent: self.order.iter().map(|&i| self.exponent[i]).collect(), order: self.order.clone() }
    }
}

/// x / y in floating point, without overflow for long integers.
fn quotient(x: &IBig, y: &IBig) -> f64 {
    let (x, y) = (Exact::new(x.clone(), 0), Exact::new(y.clone(), 0));
    let (Some(ex), Some(ey)) = (x.magnitude_exponent(), y.magnitude_exponent()) else { return 0.0 };
    let ratio = x.shifted(-ex).round_down() / y.shifted(-ey).round_down();
    match ex - ey {
        e @ -1000..=1000 => ratio * power_of_two(e),
        e if e > 0 => f64::INFINITY * ratio,
        _ => 0.0,
    }
}

/// The exact vector as a witness, verified against M; rounded to binary64 if the rounded vector is a witness too.
pub(super) fn witness(m: &Matrix<Exact>, v: &[Exact], strict: bool) -> Option<Direction> {
    let largest = v.iter().filter_map(Exact::magnitude_exponent).max()?;
    let mut v: Vec<Exact> = v.iter().map(|x| x.shifted(-largest)).collect();
    let mut form = quadratic_form(m, &v).ok()?;
    if form.signum() > 0 || (form.signum() == 0 && !strict) {
        return None;
    }
    // Scaled so that a nonzero value does not round to 0.
    if let Some(e) = form.magnitude_exponent().filter(|&e| (-2900..-900).contains(&e)) {
        let k = -e / 2;
        v = v.iter().map(|x| x.shifted(k)).collect();
        form = form.shifted(2 * k);
    }
    let refutes = |form: &Exact| form.signum() < 0 || (strict && form.signum() == 0);
    let rounded: Vec<f64> = v.iter().map(nearest).collect();
    let as_rounded: Option<Vec<Exact>> = rounded.iter().map(|&x| Exact::from_f64(x)).collect();
    if let Some(w) = as_rounded.filter(|w| w.iter().any(|x| !x.is_zero()))
        && let Ok(form) = quadratic_form(m, &w)
        && refutes(&form)
    {
        return Some(Direction { v: rounded, value: form.round_up(), exact: None, is_negated: false });
    }
    Some(Direction { v: rounded, value: form.round_up(), exact: Some(v), is_negated: false })
}

fn nearest(x: &Exact) -> f64 {
    let (below, above) = (x.round_down(), x.round_up());
    let (Some(b), Some(a)) = (Exact::from_f64(below), Exact::from_f64(above)) else {
        return if below.is_finite() { below } else { above };
    };
    if x.sub(&b) <= a.sub(x) { below } else { above }
}

/// Fractions of the estimated smallest eigenvalue that are tried as margins.
const SHARES: [f64; 5] = [1.0 - 1e-9, 1.0 - 1e-4, 0.9, 0.1, 1e-4];

/// As [`margin`], including the elimination of M.
pub(super) fn bettered_margin(m: &Matrix<Exact>, proved: f64) -> f64 {
    match judge(m) {
        Finding::Definite(factor) => margin(m, &factor, proved),
        _ => proved,
    }
}

/// A proven lower bound of the smallest eigenvalue of M, at least `proved`, which is a proven bound already. `factor`
/// is that of a definite M.
pub(super) fn margin(m: &Matrix<Exact>, factor: &Factor, proved: f64) -> f64 {
    let n = m.rows();
    let estimate = factor.smallest_eigenvalue().map_or(0.0, |(estimate, _)| estimate);
    for share in SHARES {
        // Few digits keep the integers short; 36 bits are a relative 1e-11.
        let c = f64::from_bits((share * estimate).to_bits() & !((1 << 16) - 1));
        let Some(exact) = Exact::from_f64(c).filter(|_| c > proved) else { break };
        let shifted = Matrix::from_fn(n, n, |i, j| if i == j { m[(i, j)].sub(&exact) } else { m[(i, j)].clone() });
        if matches!(judge(&shifted), Finding::Definite(_) | Finding::Singular(_)) {
            return c;
        }
    }
    proved
}
