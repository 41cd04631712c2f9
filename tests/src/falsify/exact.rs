//! Matrices of rational numbers: integers times a power of two, over a common denominator. Their properties are decided
//! by characteristic polynomials over the integers.
//!
//! Symmetric matrices: all eigenvalues are real, so that Descartes' rule of signs counts the positive ones exactly.
//! Others: Routh's array decides whether all eigenvalues have negative real parts, and with `z = (1 + s)/(1 - s)`
//! whether all lie inside the unit circle. The polynomials are those of Faddeev and Le Verrier. Nothing here is shared
//! with `luenberger-proof`.

use dashu_int::ops::BitTest;
use dashu_int::{IBig, Sign};

/// A matrix of rational numbers.
#[derive(Debug, Clone)]
pub struct Exact {
    pub rows: usize,
    pub cols: usize,
    entries: Vec<IBig>,
    exponent: i64,
    denominator: IBig,
}

/// Number of eigenvalues of each sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Inertia {
    pub positive: usize,
    pub zero: usize,
    pub negative: usize,
}

/// -1, 0 or 1.
pub fn sign(x: &IBig) -> i32 {
    if x.is_zero() {
        0
    } else if x.sign() == Sign::Negative {
        -1
    } else {
        1
    }
}

/// The integer and the exponent of a binary64 number.
fn parts(x: f64) -> (IBig, i64) {
    assert!(x.is_finite(), "{x}");
    let (bits, biased) = (x.to_bits() & ((1 << 52) - 1), (x.to_bits() >> 52) & 0x7ff);
    let (digits, exponent) = if biased == 0 { (bits, -1074) } else { (bits | 1 << 52, biased.cast_signed() - 1075) };
    let zeros = if digits == 0 { 0 } else { digits.trailing_zeros() };
    let magnitude = IBig::from(digits >> zeros);
    (if x.is_sign_negative() { -magnitude } else { magnitude }, exponent + i64::from(zeros))
}

fn shifted(x: &IBig, places: i64) -> IBig {
    x << usize::try_from(places).expect("to a lower exponent")
}

impl Exact {
    /// `numerator 2^exponent / denominator`, with a positive denominator.
    pub fn rational(numerator: IBig, exponent: i64, denominator: IBig) -> Self {
        Self { rows: 1, cols: 1, entries: vec![numerator], exponent, denominator }
    }

    pub fn number(x: f64) -> Self {
        let (digits, exponent) = parts(x);
        Self::rational(digits, exponent, IBig::ONE)
    }

    /// `numerator / 2^places`.
    pub fn dyadic(numerator: i64, places: i64) -> Self {
        Self::rational(IBig::from(numerator), -places, IBig::ONE)
    }

    /// The matrix with these entries, row by row.
    pub fn from_numbers(rows: usize, cols: usize, numbers: &[Self]) -> Self {
        assert_eq!(numbers.len(), rows * cols);
        let exponent = numbers.iter().filter(|x| !x.entries[0].is_zero()).map(|x| x.exponent).min().unwrap_or(0);
        let mut denominator = IBig::ONE;
        for x in numbers {
            if !(&denominator % &x.denominator).is_zero() {
                denominator *= &x.denominator;
            }
        }
        let entry = |x: &Self| {
            if x.entries[0].is_zero() {
                IBig::ZERO
            } else {
                shifted(&x.entries[0], x.exponent - exponent) * (&denominator / &x.denominator)
            }
        };
        Self { rows, cols, entries: numbers.iter().map(entry).collect(), exponent, denominator }
    }

    pub fn from_f64(rows: usize, cols: usize, entries: &[f64]) -> Self {
        let numbers: Vec<Self> = entries.iter().map(|x| Self::number(*x)).collect();
        Self::from_numbers(rows, cols, &numbers)
    }

    pub fn zeros(rows: usize, cols: usize) -> Self {
        Self { rows, cols, entries: vec![IBig::ZERO; rows * cols], exponent: 0, denominator: IBig::ONE }
    }

    pub fn identity(n: usize) -> Self {
        let entries = (0..n * n).map(|k| IBig::from(u8::from(k / n.max(1) == k % n.max(1)))).collect();
        Self { entries, ..Self::zeros(n, n) }
    }

    pub fn at(&self, i: usize, j: usize) -> Self {
        Self::rational(self.entries[i * self.cols + j].clone(), self.exponent, self.denominator.clone())
    }

    /// A float near the only entry.
    pub fn near(&self) -> f64 {
        assert_eq!(self.entries.len(), 1);
        let leading = |x: &IBig| {
            let shift = x.bit_len().saturating_sub(64);
            ((x >> shift).to_f64().value(), i32::try_from(shift).unwrap_or(i32::MAX))
        };
        let ((above, up), (below, down)) = (leading(&self.entries[0]), leading(&self.denominator));
        let exponent = self.exponent + i64::from(up) - i64::from(down);
        // In two steps, of which neither overflows where the result does not.
        let half = i32::try_from(exponent / 2).unwrap_or(0);
        let rest = i32::try_from(exponent - exponent / 2).unwrap_or(0);
        above / below * 2.0_f64.powi(half) * 2.0_f64.powi(rest)
    }

    /// The sign of the only entry.
    pub fn sign(&self) -> i32 {
        assert_eq!(self.entries.len(), 1);
        sign(&self.entries[0])
    }

    pub fn is_zero(&self) -> bool {
        self.entries.iter().all(IBig::is_zero)
    }

    pub fn plus(&self, other: &Self) -> Self {
        assert_eq!((self.rows, self.cols), (other.rows, other.cols));
        let exponent = self.exponent.min(other.exponent);
        let same = self.denominator == other.denominator;
        let term = |x: &IBig, from: &Self, to: &Self| {
            let x = shifted(x, from.exponent - exponent);
            if same { x } else { x * &to.denominator }
        };
        let entries =
            self.entries.iter().zip(&other.entries).map(|(x, y)| term(x, self, other) + term(y, other, self)).collect();
        let denominator = if same { self.denominator.clone() } else { &self.denominator * &other.denominator };
        Self { rows: self.rows, cols: self.cols, entries, exponent, denominator }
    }

    pub fn negative(&self) -> Self {
        Self { entries: self.entries.iter().map(|x| -x).collect(), ..self.clone() }
    }

    pub fn minus(&self, other: &Self) -> Self {
        self.plus(&other.negative())
    }

    pub fn times(&self, other: &Self) -> Self {
        assert_eq!(self.cols, other.rows);
        let mut entries = Vec::with_capacity(self.rows * other.cols);
        for i in 0..self.rows {
            for j in 0..other.cols {
                let terms =
                    (0..self.cols).map(|k| &self.entries[i * self.cols + k] * &other.entries[k * other.cols + j]);
                entries.push(terms.sum());
            }
        }
        let (exponent, denominator) = (self.exponent + other.exponent, &self.denominator * &other.denominator);
        Self { rows: self.rows, cols: other.cols, entries, exponent, denominator }
    }

    /// Each entry times a number.
    pub fn scaled(&self, factor: &Self) -> Self {
        let entries = self.entries.iter().map(|x| x * &factor.entries[0]).collect();
        let (exponent, denominator) = (self.exponent + factor.exponent, &self.denominator * &factor.denominator);
        Self { rows: self.rows, cols: self.cols, entries, exponent, denominator }
    }

    pub fn transposed(&self) -> Self {
        let entries = (0..self.entries.len())
            .map(|k| self.entries[(k % self.rows) * self.cols + k / self.rows].clone())
            .collect();
        Self { rows: self.cols, cols: self.rows, entries, ..self.clone() }
    }

    /// `M + M'`.
    pub fn he(&self) -> Self {
        self.plus(&self.transposed())
    }

    /// `M'P M`.
    pub fn congruent(&self, p: &Self) -> Self {
        self.transposed().times(p).times(self)
    }

    /// The matrix of these rows of blocks.
    pub fn blocks(blocks: &[Vec<Self>]) -> Self {
        let mut numbers = Vec::new();
        let (mut rows, mut cols) = (0, 0);
        for row in blocks {
            let height = row.first().map_or(0, |block| block.rows);
            for i in 0..height {
                numbers.extend(row.iter().flat_map(|block| (0..block.cols).map(move |j| block.at(i, j))));
            }
            rows += height;
            cols = row.iter().map(|block| block.cols).sum();
        }
        Self::from_numbers(rows, cols, &numbers)
    }

    pub fn view(&self, row: usize, col: usize, rows: usize, cols: usize) -> Self {
        let entry = |k: usize| self.entries[(row + k / cols.max(1)) * self.cols + col + k % cols.max(1)].clone();
        Self { rows, cols, entries: (0..rows * cols).map(entry).collect(), ..self.clone() }
    }

    pub fn is_symmetric(&self) -> bool {
        self.rows == self.cols
            && (0..self.entries.len()).all(|k| {
                let (i, j) = (k / self.cols, k % self.cols);
                self.entries[k] == self.entries[j * self.cols + i]
            })
    }

    /// `z^n + c_1 z^(n-1) + ... + c_n` of the matrix of integers, whose eigenvalues are those of this one times a
    /// positive number.
    fn polynomial(&self) -> Vec<IBig> {
        assert_eq!(self.rows, self.cols);
        let n = self.rows;
        let mut coefficients = vec![IBig::ONE];
        let mut product = self.entries.clone();
        for k in 1..=n {
            let trace: IBig = (0..n).map(|i| &product[i * n + i]).sum();
            let divisor = IBig::from(k);
            let c = -(&trace / &divisor);
            assert!((&c * &divisor + &trace).is_zero(), "a characteristic polynomial has integer coefficients");
            if k < n {
                for i in 0..n {
                    product[i * n + i] += &c;
                }
                let mut next = Vec::with_capacity(n * n);
                for i in 0..n {
                    for j in 0..n {
                        next.push((0..n).map(|l| &self.entries[i * n + l] * &product[l * n + j]).sum());
                    }
                }
                product = next;
            }
            coefficients.push(c);
        }
        coefficients
    }

    /// The matrix of A on the largest subspace that C does not see and that A maps into itself, in some basis; its size
    /// is n less the rank of (C, CA, ..).
    pub fn unseen(a: &Self, c: &Self) -> Self {
        let n = a.rows;
        let mut seen = vec![vec![c.clone()]];
        for k in 1..n {
            let next = seen[k - 1][0].times(a);
            // Every block has its own power of two and denominator, which do not change what it does not see.
            seen.push(vec![Self { exponent: 0, denominator: IBig::ONE, ..next }]);
        }
        let mut m: Vec<Vec<IBig>> = Vec::new();
        for block in seen.iter().flatten() {
            m.extend(block.entries.chunks(n.max(1)).map(<[IBig]>::to_vec));
        }
        // Fraction-free elimination to row echelon form, reduced.
        let (mut pivots, mut row) = (Vec::new(), 0);
        for column in 0..n {
            let Some(found) = (row..m.len()).find(|i| !m[*i][column].is_zero()) else { continue };
            m.swap(row, found);
            let pivot = m[row].clone();
            for (i, other) in m.iter_mut().enumerate() {
                if i != row && !other[column].is_zero() {
                    let factor = other[column].clone();
                    other.iter_mut().zip(&pivot).for_each(|(x, y)| *x = &*x * &pivot[column] - &factor * y);
                }
            }
            pivots.push(column);
            row += 1;
        }
        let free: Vec<usize> = (0..n).filter(|j| !pivots.contains(j)).collect();
        // v_l has 1 at its free column, and -m/pivot at the pivots; times the product of the pivots it is whole.
        let common: IBig = pivots.iter().enumerate().map(|(i, j)| m[i][*j].clone()).product();
        let mut basis = Self::zeros(n, free.len());
        for (l, column) in free.iter().enumerate() {
            basis.entries[column * free.len() + l].clone_from(&common);
            for (i, pivot) in pivots.iter().enumerate() {
                basis.entries[pivot * free.len() + l] = -(&m[i][*column] * (&common / &m[i][*pivot]));
            }
        }
        let image = a.times(&basis);
        let positive = sign(&common) > 0;
        let scale = if positive { common } else { -common };
        let entry = |k: usize| {
            let (i, l) = (free[k / free.len().max(1)], k % free.len().max(1));
            let x = image.entries[i * free.len() + l].clone();
            Self::rational(if positive { x } else { -x }, image.exponent, &image.denominator * &scale)
        };
        let entries: Vec<Self> = (0..free.len() * free.len()).map(entry).collect();
        Self::from_numbers(free.len(), free.len(), &entries)
    }

    /// The signs of the eigenvalues of a symmetric matrix.
    pub fn inertia(&self) -> Inertia {
        let coefficients = self.polynomial();
        let n = coefficients.len() - 1;
        let zero = coefficients.iter().rev().take_while(|c| c.is_zero()).count();
        let signs: Vec<i32> = coefficients.iter().map(sign).filter(|s| *s != 0).collect();
        let positive = signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
        Inertia { positive, zero, negative: n - zero - positive }
    }

    /// `M > 0`, of a symmetric matrix.
    pub fn is_positive(&self) -> bool {
        self.is_symmetric() && self.inertia().positive == self.rows
    }

    /// `M >= 0`, of a symmetric matrix.
    pub fn is_semidefinite(&self) -> bool {
        self.is_symmetric() && self.inertia().negative == 0
    }

    /// Whether all eigenvalues have negative real parts.
    pub fn is_hurwitz(&self) -> bool {
        is_hurwitz(&self.polynomial())
    }

    /// Whether all eigenvalues lie inside the unit circle.
    pub fn is_schur(&self) -> bool {
        // Of M = E 2^e/d the polynomial is that of E with c_k times (2^e/d)^k: made integers.
        let n = self.rows;
        let (mut up, mut down) = (IBig::ONE, self.denominator.clone());
        if self.exponent >= 0 {
            up = shifted(&up, self.exponent);
        } else {
            down = shifted(&down, -self.exponent);
        }
        let coefficients: Vec<IBig> =
            self.polynomial().iter().enumerate().map(|(k, c)| c * up.pow(k) * down.pow(n - k)).collect();
        let mut transformed = vec![IBig::ZERO; n + 1];
        for (k, c) in coefficients.iter().enumerate() {
            // c z^(n-k) becomes c (1 + s)^(n-k) (1 - s)^k, coefficients of falling powers.
            let mut factor = vec![c.clone()];
            for step in 0..n {
                let leading = if step < n - k { 1 } else { -1 };
                let mut next = vec![IBig::ZERO; factor.len() + 1];
                for (j, x) in factor.iter().enumerate() {
                    next[j] += x * IBig::from(leading);
                    next[j + 1] += x;
                }
                factor = next;
            }
            transformed.iter_mut().zip(factor).for_each(|(sum, x)| *sum += x);
        }
        if transformed[0].is_zero() {
            return false;
        }
        if sign(&transformed[0]) < 0 {
            for c in &mut transformed {
                *c = -&*c;
            }
        }
        is_hurwitz(&transformed)
    }

    /// The solution X of `M X = B` as numerators over the determinant, with its sign; `None` where M is singular.
    pub fn solve(&self, rhs: &Self) -> Option<Self> {
        assert_eq!((self.rows, rhs.rows), (self.cols, self.rows));
        let (n, width) = (self.rows, self.rows + rhs.cols);
        let joined = Self::blocks(&[vec![self.clone(), rhs.clone()]]);
        let mut m = joined.entries;
        let mut last = IBig::ONE;
        for k in 0..n {
            let pivot = (k..n).find(|i| !m[i * width + k].is_zero())?;
            for j in 0..width {
                m.swap(k * width + j, pivot * width + j);
            }
            let head = m[k * width + k].clone();
            for i in (0..n).filter(|i| *i != k) {
                let factor = m[i * width + k].clone();
                for j in 0..width {
                    let value = (&head * &m[i * width + j] - &factor * &m[k * width + j]) / &last;
                    m[i * width + j] = value;
                }
            }
            last = head;
        }
        // Every diagonal entry is now the determinant, up to its sign.
        let negative = sign(&last) < 0;
        let entry = |k: usize| {
            let x = &m[(k / rhs.cols) * width + n + k % rhs.cols];
            if negative { -x } else { x.clone() }
        };
        let entries = (0..n * rhs.cols).map(entry).collect();
        let denominator = if negative { -last } else { last };
        Some(Self { rows: n, cols: rhs.cols, entries, exponent: 0, denominator })
    }
}

/// Routh's array of a polynomial with a positive leading coefficient, multiplied by positive numbers where it would
/// divide.
fn is_hurwitz(coefficients: &[IBig]) -> bool {
    if coefficients.iter().any(|c| sign(c) <= 0) {
        return false;
    }
    let mut above: Vec<IBig> = coefficients.iter().step_by(2).cloned().collect();
    let mut row: Vec<IBig> = coefficients.iter().skip(1).step_by(2).cloned().collect();
    while let Some(head) = row.first() {
        if sign(head) <= 0 {
            return false;
        }
        let at = |row: &[IBig], k: usize| row.get(k).cloned().unwrap_or(IBig::ZERO);
        let next = (1..above.len()).map(|k| head * &above[k] - &above[0] * at(&row, k)).collect();
        above = std::mem::replace(&mut row, next);
    }
    true
}
