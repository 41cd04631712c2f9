//! The truth about small symmetric matrices, by a way that shares nothing with the crate's: the characteristic
//! polynomial over the integers, and Descartes' rule.
//!
//! All eigenvalues of a symmetric matrix are real, so that its characteristic polynomial has exactly as many positive
//! zeros as its coefficients change sign, and as many zeros at 0 as coefficients vanish at its end. The eigenvalues of
//! `M - c I` come from the same polynomial, moved by c.
//!
//! The coefficients are those of Faddeev and Le Verrier: `A_1 = A, c_k = -tr(A_k)/k, A_(k+1) = A (A_k + c_k I)`, every
//! division without a remainder.

use dashu_int::{IBig, Sign};
use luenberger_proof::{Exact, Matrix};

/// A matrix of integers times a power of two.
#[derive(Debug, Clone)]
pub(crate) struct Integers {
    rows: usize,
    cols: usize,
    entries: Vec<IBig>,
    exponent: i64,
}

/// The integer and the exponent that a binary64 number is made of.
fn parts(x: f64) -> (IBig, i64) {
    assert!(x.is_finite());
    let (bits, sign) = (x.to_bits() & !(1 << 63), x.is_sign_negative());
    let (biased, fraction) = ((bits >> 52).cast_signed(), bits & ((1 << 52) - 1));
    let (digits, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
    let zeros = if digits == 0 { 0 } else { digits.trailing_zeros() };
    let magnitude = IBig::from(digits >> zeros);
    (if sign { -magnitude } else { magnitude }, exponent + i64::from(zeros))
}

impl Integers {
    fn from_parts(rows: usize, cols: usize, parts: Vec<(IBig, i64)>) -> Self {
        assert_eq!(parts.len(), rows * cols);
        let exponent = parts.iter().filter(|(m, _)| !m.is_zero()).map(|(_, e)| *e).min().unwrap_or(0);
        let entries = parts
            .into_iter()
            .map(|(m, e)| if m.is_zero() { IBig::ZERO } else { m << (e - exponent) as usize })
            .collect();
        Self { rows, cols, entries, exponent }
    }

    pub(crate) fn of(m: &Matrix<f64>) -> Self {
        Self::from_parts(m.rows(), m.cols(), m.as_slice().iter().map(|&x| parts(x)).collect())
    }

    pub(crate) fn scalar(n: usize, x: f64) -> Self {
        let entry = |k: usize| if k / n == k % n { parts(x) } else { (IBig::ZERO, 0) };
        Self::from_parts(n, n, (0..n * n).map(entry).collect())
    }

    pub(crate) fn column(v: &[f64]) -> Self {
        Self::from_parts(v.len(), 1, v.iter().map(|&x| parts(x)).collect())
    }

    pub(crate) fn exact_column(v: &[Exact]) -> Self {
        Self::from_parts(v.len(), 1, v.iter().map(|x| (x.mantissa().clone(), x.exponent())).collect())
    }

    pub(crate) fn at(&self, i: usize, j: usize) -> &IBig {
        &self.entries[i * self.cols + j]
    }

    /// The same numbers with a lower exponent.
    fn refined(&self, exponent: i64) -> Vec<IBig> {
        let shift = (self.exponent - exponent) as usize;
        self.entries.iter().map(|x| x << shift).collect()
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        assert_eq!((self.rows, self.cols), (other.rows, other.cols));
        let exponent = self.exponent.min(other.exponent);
        let entries = self.refined(exponent).into_iter().zip(other.refined(exponent)).map(|(x, y)| x + y).collect();
        Self { entries, exponent, ..*self }
    }

    pub(crate) fn negative(&self) -> Self {
        Self { entries: self.entries.iter().map(|x| -x).collect(), ..*self }
    }

    pub(crate) fn minus(&self, other: &Self) -> Self {
        self.plus(&other.negative())
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        assert_eq!(self.cols, other.rows);
        let mut entries = Vec::with_capacity(self.rows * other.cols);
        for i in 0..self.rows {
            for j in 0..other.cols {
                entries.push((0..self.cols).map(|k| self.at(i, k) * other.at(k, j)).sum());
            }
        }
        Self { rows: self.rows, cols: other.cols, entries, exponent: self.exponent + other.exponent }
    }

    pub(crate) fn transpose(&self) -> Self {
        let entries = (0..self.rows * self.cols).map(|k| self.at(k % self.rows, k / self.rows).clone()).collect();
        Self { rows: self.cols, cols: self.rows, entries, exponent: self.exponent }
    }

    /// `M + M'`.
    pub(crate) fn twice_symmetric(&self) -> Self {
        self.plus(&self.transpose())
    }

    /// The matrix of four blocks.
    pub(crate) fn blocks(a: &Self, b: &Self, c: &Self, d: &Self) -> Self {
        let exponent = [a, b, c, d].map(|m| m.exponent).into_iter().min().unwrap_or(0);
        let (rows, cols) = (a.rows + c.rows, a.cols + b.cols);
        let parts = [a, b, c, d].map(|m| m.refined(exponent));
        let entries = (0..rows * cols)
            .map(|k| {
                let (i, j) = (k / cols, k % cols);
                match (i < a.rows, j < a.cols) {
                    (true, true) => parts[0][i * a.cols + j].clone(),
                    (true, false) => parts[1][i * b.cols + j - a.cols].clone(),
                    (false, true) => parts[2][(i - a.rows) * c.cols + j].clone(),
                    (false, false) => parts[3][(i - a.rows) * d.cols + j - a.cols].clone(),
                }
            })
            .collect();
        Self { rows, cols, entries, exponent }
    }

    /// The sign of the only entry.
    pub(crate) fn sign(&self) -> i32 {
        assert_eq!(self.entries.len(), 1);
        sign(&self.entries[0])
    }

    /// The sign of an entry of a column.
    pub(crate) fn sign_at(&self, i: usize) -> i32 {
        sign(self.at(i, 0))
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.entries.iter().all(IBig::is_zero)
    }
}

fn sign(x: &IBig) -> i32 {
    if x.is_zero() {
        0
    } else if x.sign() == Sign::Negative {
        -1
    } else {
        1
    }
}

/// How many eigenvalues have which sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Inertia {
    pub(crate) positive: usize,
    pub(crate) zero: usize,
    pub(crate) negative: usize,
}

/// The characteristic polynomial `z^n + c_1 z^(n-1) + ... + c_n` of `M 2^-exponent`.
#[derive(Debug, Clone)]
pub(crate) struct Spectrum {
    coefficients: Vec<IBig>,
    exponent: i64,
}

impl Spectrum {
    /// Of a symmetric matrix.
    pub(crate) fn of(m: &Integers) -> Self {
        let n = m.rows;
        let mut coefficients = vec![IBig::ONE];
        // The products are polynomials in M, and so symmetric.
        let mut product = m.entries.clone();
        for k in 1..=n {
            let trace: IBig = (0..n).map(|i| &product[i * n + i]).sum();
            let divisor = IBig::from(k);
            let c = -(&trace / &divisor);
            assert!((&c * &divisor + &trace).is_zero(), "a characteristic polynomial has integer coefficients");
            if k < n {
                for i in 0..n {
                    product[i * n + i] += &c;
                }
                let mut next = vec![IBig::ZERO; n * n];
                for i in 0..n {
                    for j in i..n {
                        let sum: IBig = (0..n).map(|l| m.at(i, l) * &product[l * n + j]).sum();
                        next[j * n + i].clone_from(&sum);
                        next[i * n + j] = sum;
                    }
                }
                product = next;
            }
            coefficients.push(c);
        }
        Self { coefficients, exponent: m.exponent }
    }

    /// Of `-M`.
    pub(crate) fn negative(&self) -> Self {
        let coefficients = self.coefficients.iter().enumerate().map(|(k, c)| if k % 2 == 1 { -c } else { c.clone() });
        Self { coefficients: coefficients.collect(), ..*self }
    }

    /// Of `M - c I`.
    pub(crate) fn lowered(&self, c: f64) -> Self {
        let (digits, exponent) = parts(c);
        if digits.is_zero() {
            return self.clone();
        }
        // With unit 2^e the coefficient c_k is a sum of products of k eigenvalues.
        let unit = self.exponent.min(exponent);
        let finer = (self.exponent - unit) as usize;
        let mut p: Vec<IBig> = self.coefficients.iter().enumerate().map(|(k, c)| c << (finer * k)).collect();
        let step = digits << (exponent - unit) as usize;
        // Horner's scheme, again and again: the coefficients of p(z + step).
        let n = p.len() - 1;
        for last in (1..=n).rev() {
            for k in 1..=last {
                let carried = &p[k - 1] * &step;
                p[k] += carried;
            }
        }
        Self { coefficients: p, exponent: unit }
    }

    pub(crate) fn inertia(&self) -> Inertia {
        let n = self.coefficients.len() - 1;
        let zero = self.coefficients.iter().rev().take_while(|c| c.is_zero()).count();
        let signs: Vec<i32> = self.coefficients.iter().map(sign).filter(|s| *s != 0).collect();
        let positive = signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
        Inertia { positive, zero, negative: n - zero - positive }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_signs_of_known_eigenvalues() {
        // Eigenvalues 3, 0 (twice) of the matrix of ones; 1, 3 of [[2, 1], [1, 2]]; -1, 1.
        let of = |m: &Matrix<f64>| Spectrum::of(&Integers::of(m));
        let inertia = |positive, zero, negative| Inertia { positive, zero, negative };
        let ones = of(&Matrix::from_fn(3, 3, |_, _| 0.125));
        assert_eq!(ones.inertia(), inertia(1, 2, 0));
        assert_eq!(ones.lowered(0.375).inertia(), inertia(0, 1, 2));
        assert_eq!(ones.negative().inertia(), inertia(0, 2, 1));
        let two = of(&Matrix::from_rows([[2.0, 1.0], [1.0, 2.0]]));
        assert_eq!(two.lowered(1.0).inertia(), inertia(1, 1, 0));
        assert_eq!(two.lowered(1.0_f64.next_up()).inertia(), inertia(1, 0, 1));
        assert_eq!(two.lowered(1.0_f64.next_down()).inertia(), inertia(2, 0, 0));
        assert_eq!(two.lowered(f64::from_bits(1)).inertia(), inertia(2, 0, 0));
        assert_eq!(of(&Matrix::from_rows([[0.0, -1e-300], [-1e-300, 0.0]])).inertia(), inertia(1, 0, 1));
    }
}
