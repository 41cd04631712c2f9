//! Unobservable subspace and its dynamics, computed in exact arithmetic.
//!
//! The unobservable subspace of `(A, C)` is the kernel of the observability matrix `[C; CA; ..; CA^(n-1)]`. For
//! binary64 data it has an integer basis, found by exact elimination: `C V = 0`, `A V d = V M` with an integer d > 0.
//! An error in that subspace obeys `z' = (M / d) z` for every gain, so no gain gives
//! `(A - LC)'P + P(A - LC) + 2 rate P < 0` unless `M / d + rate I` is Hurwitz. This is decided exactly too: the
//! characteristic polynomial by the Faddeev-Leverrier method, in integers, and the Routh array, whose first column is
//! positive iff all roots lie in the open left half plane. In discrete time, `z+ = (M / d) z`, the same array decides
//! of the polynomial in s with `lambda = (1 + s)/(1 - s)`, which takes the open unit disk to that half plane.
//!
//! Sources: F. R. Gantmacher, The Theory of Matrices, vol. 1, ch. IV, section 5 and vol. 2, ch. XV; M. L. J. Hautus,
//! 1969 (unobservable subspace and modes).

use dashu_int::IBig;
use dashu_int::ops::{Gcd, UnsignedAbs};

use crate::error::ProofError;
use crate::exact::Exact;
use crate::matrix::Matrix;
use crate::ring::Ring;

/// Largest order examined: the characteristic polynomial costs n^4 multiplications of numbers of about 60 n bits, some
/// seconds at this order.
pub const HIDDEN_ORDER: usize = 48;

/// The unobservable part of `x' = A x`, `y = C x`: a basis V of the unobservable subspace and its dynamics M/d,
/// `C V = 0`, `A V d = V M`.
#[derive(Debug, Clone, PartialEq)]
pub struct HiddenMotion {
    /// V, n x k with k > 0, of full column rank.
    pub basis: Matrix<Exact>,
    /// M, k x k.
    pub motion: Matrix<Exact>,
    /// d > 0.
    pub divisor: Exact,
}

impl HiddenMotion {
    /// Whether every unobservable motion decays faster than `exp(-rate t)`: all eigenvalues of `M / d` have real parts
    /// below `-rate`. Exact; `None` for a rate that is not finite.
    pub fn decays_at(&self, rate: f64) -> Option<bool> {
        let shift = Exact::from_f64(rate)?.mul(&self.divisor);
        let m = &self.motion;
        hurwitz_spectrum(&Matrix::from_fn(m.rows(), m.cols(), |i, j| {
            if i == j { m[(i, j)].add(&shift) } else { m[(i, j)].clone() }
        }))
    }

    /// Whether every unobservable motion of `x+ = A x` decays: all eigenvalues of `M / d` are inside the unit circle.
    /// Exact.
    pub fn decays_in_steps(&self) -> Option<bool> {
        inside_circle(&self.motion, &self.divisor)
    }

    /// The same by more than this factor at each step, which is above 0: all eigenvalues of `M / d` are smaller in
    /// modulus.
    pub fn falls_by(&self, factor: f64) -> Option<bool> {
        let factor = Exact::from_f64(factor).filter(|_| factor > 0.0)?;
        inside_circle(&self.motion, &self.divisor.mul(&factor))
    }

    /// Whether these matrices belong to the pair `(A, C)`: `C V = 0`, `A V d = V M` and V of full rank, checked
    /// exactly.
    ///
    /// # Errors
    /// [`ProofError`] for inconsistent shapes or entries that are not finite.
    pub fn is_of(&self, a: &Matrix<f64>, c: &Matrix<f64>) -> Result<bool, ProofError> {
        let n = a.rows();
        let (a, c) = (super::embed::<Exact>(a, "A", (n, n))?, super::embed::<Exact>(c, "C", (c.rows(), n))?);
        self.basis.expect_shape("V", (n, self.motion.rows()))?;
        let motion = a.product(&self.basis)?.scaled(&self.divisor);
        let trace = c.product(&self.basis)?;
        let mut space = RowSpace::new(n);
        let full = (0..self.basis.cols()).all(|j| {
            let column: Vec<Exact> = (0..n).map(|i| self.basis[(i, j)].clone()).collect();
            space.insert(integers(&column)).is_some()
        });
        Ok(full
            && self.divisor.signum() > 0
            && self.basis.cols() > 0
            && trace.as_slice().iter().all(Ring::is_zero)
            && motion == self.basis.product(&self.motion)?)
    }
}

/// The unobservable part of a pair `(A, C)`, A n x n and C p x n, in exact arithmetic; `None` if the pair is
/// observable, or above order [`HIDDEN_ORDER`].
///
/// ```
/// use luenberger_proof::{Matrix, statement::hidden_motion};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // The second state is seen by nothing and decays like exp(-2 t).
/// let a = Matrix::from_rows([[0.5, 0.0], [1.0, -2.0]]);
/// let hidden = hidden_motion(&a, &Matrix::from_rows([[1.0, 0.0]]))?.expect("not observable");
/// assert_eq!((hidden.decays_at(1.5), hidden.decays_at(2.0)), (Some(true), Some(false)));
/// // An entry of 1e-300 is enough to be seen.
/// let a = Matrix::from_rows([[0.5, 1e-300], [1.0, -2.0]]);
/// assert!(hidden_motion(&a, &Matrix::from_rows([[1.0, 0.0]]))?.is_none());
/// # Ok(())
/// # }
/// ```
/// # Errors
/// [`ProofError`] for inconsistent shapes or entries that are not finite.
pub fn hidden_motion(a: &Matrix<f64>, c: &Matrix<f64>) -> Result<Option<HiddenMotion>, ProofError> {
    let n = a.rows();
    let (a, c) = (super::embed::<Exact>(a, "A", (n, n))?, super::embed::<Exact>(c, "C", (c.rows(), n))?);
    if n == 0 || n > HIDDEN_ORDER {
        return Ok(None);
    }
    // The smallest row space that contains the rows of C and, with each row r, also r A.
    let mut space = RowSpace::new(n);
    let mut open: Vec<Vec<IBig>> = (0..c.rows()).map(|i| integers(c.row(i))).collect();
    let scaled = integers(a.as_slice());
    while let Some(row) = open.pop() {
        if let Some(new) = space.insert(row) {
            open.push((0..n).map(|j| (0..n).map(|i| &new[i] * &scaled[i * n + j]).sum()).collect());
        }
        if space.rows.len() == n {
            return Ok(None);
        }
    }
    let (basis, divisor) = space.kernel();
    let image = a.product(&basis)?;
    let free = space.free();
    let motion = Matrix::from_fn(free.len(), free.len(), |i, j| image[(free[i], j)].clone());
    Ok(Some(HiddenMotion { basis, motion, divisor }))
}

/// Whether all eigenvalues of a square matrix lie in the open left half plane, decided exactly. `None` for a matrix
/// that is not square, or above order [`HIDDEN_ORDER`].
///
/// ```
/// use luenberger_proof::{Exact, Matrix, Ring, statement::hurwitz_spectrum};
/// let at = |x: f64| Matrix::from_rows([[x, 1.0], [-1.0, x]]).map(|x| Exact::from_f64(*x).expect("finite"));
/// assert_eq!((hurwitz_spectrum(&at(-1e-300)), hurwitz_spectrum(&at(0.0)), hurwitz_spectrum(&at(1e-300))), (Some(true), Some(false), Some(false)));
/// ```
pub fn hurwitz_spectrum(m: &Matrix<Exact>) -> Option<bool> {
    let n = m.rows();
    if n != m.cols() || n > HIDDEN_ORDER {
        return None;
    }
    // A positive factor does not change the signs.
    Some(all_roots_left(&characteristic_polynomial(&integers(m.as_slice()), n, true)))
}

/// Whether all eigenvalues of a square matrix lie inside the unit circle, decided exactly. `None` for a matrix that is
/// not square, or above order [`HIDDEN_ORDER`].
///
/// ```
/// use luenberger_proof::{Exact, Matrix, Ring, statement::schur_spectrum};
/// let turned = |x: f64| Matrix::from_rows([[0.0, x], [-1.0, 0.0]]).map(|x| Exact::from_f64(*x).expect("finite"));
/// assert_eq!((schur_spectrum(&turned(1.0 - f64::EPSILON)), schur_spectrum(&turned(1.0))), (Some(true), Some(false)));
/// ```
pub fn schur_spectrum(m: &Matrix<Exact>) -> Option<bool> {
    inside_circle(m, &Exact::new(IBig::ONE, 0))
}

/// Whether all eigenvalues of `m` are of modulus below `radius > 0`.
fn inside_circle(m: &Matrix<Exact>, radius: &Exact) -> Option<bool> {
    let n = m.rows();
    if n != m.cols() || n > HIDDEN_ORDER {
        return None;
    }
    let mut numbers = m.as_slice().to_vec();
    numbers.push(radius.clone());
    let mut scaled = integers(&numbers);
    let radius = scaled.pop()?;
    // det(lambda radius I - m), lowest power first.
    let mut powers = characteristic_polynomial(&scaled, n, false);
    powers.reverse();
    let mut factor = IBig::ONE;
    for coefficient in &mut powers {
        *coefficient *= &factor;
        factor *= &radius;
    }
    // The sum of a_j (1 + s)^j (1 - s)^(n - j), lowest power of s first, by Horner's rule.
    let mut transformed = vec![IBig::ZERO; n + 1];
    let mut rest = vec![IBig::ONE];
    for coefficient in powers.iter().rev() {
        let shifted = |k: usize| k.checked_sub(1).map_or(IBig::ZERO, |k| transformed[k].clone());
        transformed = (0..=n).map(|k| &transformed[k] + shifted(k)).collect();
        for (sum, x) in transformed.iter_mut().zip(&rest) {
            *sum += coefficient * x;
        }
        let zero = IBig::ZERO;
        rest = (0..=rest.len())
            .map(|k| rest.get(k).unwrap_or(&zero) - k.checked_sub(1).map_or(&zero, |k| &rest[k]))
            .collect();
    }
    transformed.reverse();
    if transformed.first().is_some_and(|first| *first < IBig::ZERO) {
        for x in &mut transformed {
            *x = -&*x;
        }
    }
    Some(all_roots_left(&transformed))
}

/// The numbers times a common factor, as integers without a common divisor.
fn integers(numbers: &[Exact]) -> Vec<IBig> {
    let lowest = numbers.iter().filter(|x| !x.is_zero()).map(Exact::exponent).min().unwrap_or(0);
    let mut row: Vec<IBig> =
        numbers.iter().map(|x| x.mantissa() << usize::try_from(x.exponent() - lowest).unwrap_or(0)).collect();
    make_primitive(&mut row);
    row
}

/// Divides by the greatest common divisor.
fn make_primitive(row: &mut [IBig]) {
    let zero = IBig::ZERO;
    let mut entries = row.iter().filter(|x| **x != zero);
    let Some(first) = entries.next() else { return };
    let mut divisor = first.clone().unsigned_abs();
    for x in entries {
        if divisor.is_one() {
            return;
        }
        divisor = divisor.gcd(x.clone().unsigned_abs());
    }
    if !divisor.is_one() {
        let divisor = IBig::from(divisor);
        for x in row.iter_mut() {
            *x /= &divisor;
        }
    }
}

/// Integer rows in reduced echelon form: each row has a positive pivot, and all other entries of the pivot's column are
/// 0.
struct RowSpace {
    width: usize,
    rows: Vec<(usize, Vec<IBig>)>,
}

impl RowSpace {
    fn new(width: usize) -> Self {
        Self { width, rows: Vec::new() }
    }

    /// Adds a row; returns its reduced form, or `None` if it is linearly dependent.
    fn insert(&mut self, mut row: Vec<IBig>) -> Option<Vec<IBig>> {
        for (pivot, other) in &self.rows {
            eliminate(&mut row, *pivot, other);
        }
        let pivot = row.iter().position(|x| *x != IBig::ZERO)?;
        if row[pivot] < IBig::ZERO {
            for x in &mut row {
                *x = -&*x;
            }
        }
        for (_, other) in &mut self.rows {
            eliminate(other, pivot, &row);
        }
        self.rows.push((pivot, row.clone()));
        Some(row)
    }

    /// The columns without a pivot.
    fn free(&self) -> Vec<usize> {
        (0..self.width).filter(|j| self.rows.iter().all(|(pivot, _)| pivot != j)).collect()
    }

    /// A basis of the kernel of the rows, with `d I` in the rows of the free coordinates, and d.
    fn kernel(&self) -> (Matrix<Exact>, Exact) {
        let free = self.free();
        let divisor = self.rows.iter().fold(IBig::ONE, |d, (pivot, row)| {
            let common = IBig::from((&d).gcd(&row[*pivot]));
            d / common * &row[*pivot]
        });
        let entry = |i: usize, j: usize| match self.rows.iter().find(|(pivot, _)| *pivot == i) {
            Some((pivot, row)) => -(&divisor / &row[*pivot]) * &row[free[j]],
            None if i == free[j] => divisor.clone(),
            None => IBig::ZERO,
        };
        let basis = Matrix::from_fn(self.width, free.len(), |i, j| Exact::new(entry(i, j), 0));
        (basis, Exact::new(divisor.clone(), 0))
    }
}

/// Makes the entry at `pivot` of a row 0 by a multiple of another row, whose pivot is positive; the row keeps its sign.
fn eliminate(row: &mut [IBig], pivot: usize, other: &[IBig]) {
    if row[pivot] == IBig::ZERO {
        return;
    }
    let (own, factor) = (other[pivot].clone(), row[pivot].clone());
    for (x, y) in row.iter_mut().zip(other) {
        *x = &*x * &own - &factor * y;
    }
    make_primitive(row);
}

/// Coefficients of `det(s I - A)`, highest power first, by `A_1 = A`, `c_k = -tr(A_k)/k`, `A_(k+1) = A (A_k + c_k I)`.
/// The divisions are exact. All coefficients of a Hurwitz polynomial are positive; `only_hurwitz` stops at one that is
/// not.
fn characteristic_polynomial(a: &[IBig], n: usize, only_hurwitz: bool) -> Vec<IBig> {
    let mut coefficients = vec![IBig::ONE];
    let mut power = a.to_vec();
    for k in 1..=n {
        let trace: IBig = (0..n).map(|i| &power[i * n + i]).sum();
        let c = -trace / IBig::from(k);
        for i in 0..n {
            power[i * n + i] += &c;
        }
        let hopeless = only_hurwitz && c <= IBig::ZERO;
        coefficients.push(c);
        if hopeless {
            return coefficients;
        }
        if k < n {
            power = (0..n * n).map(|at| (0..n).map(|l| &a[at / n * n + l] * &power[l * n + at % n]).sum()).collect();
        }
    }
    coefficients
}

/// Routh array of a polynomial with a positive leading coefficient, highest power first.
fn all_roots_left(coefficients: &[IBig]) -> bool {
    if coefficients.iter().any(|c| *c <= IBig::ZERO) {
        return false;
    }
    let every_second = |from: usize| coefficients.iter().skip(from).step_by(2).cloned().collect::<Vec<_>>();
    let (mut above, mut row) = (every_second(0), every_second(1));
    while let Some(first) = row.first() {
        if *first <= IBig::ZERO {
            return false;
        }
        // Multiplied by the positive first entry of `row`, which keeps the signs.
        let zero = IBig::ZERO;
        let mut next: Vec<IBig> =
            (1..above.len()).map(|j| first * &above[j] - &above[0] * row.get(j).unwrap_or(&zero)).collect();
        make_primitive(&mut next);
        above = row;
        row = next;
    }
    true
}
