//! Rings that contain the binary64 numbers, and matrix expressions over them.
//!
//! An expression such as `F'P + PF` with `F = A - LC` is written once over a [`Ring`] and evaluated with outward
//! rounding for speed, or exactly if that is inconclusive. Binary64 itself is not a ring here, since its operations are
//! rounded.

use crate::error::ProofError;
use crate::matrix::Matrix;

/// Rigorous addition, subtraction and multiplication: the result is exact, or encloses the exact result.
pub trait Ring: Clone {
    /// The number 0.
    fn zero() -> Self;
    /// The real number that `x` is, exactly; `None` for NaN and infinities.
    fn from_f64(x: f64) -> Option<Self>;
    /// The sum.
    #[must_use]
    fn add(&self, rhs: &Self) -> Self;
    /// The difference.
    #[must_use]
    fn sub(&self, rhs: &Self) -> Self;
    /// The product.
    #[must_use]
    fn mul(&self, rhs: &Self) -> Self;
    /// The negative.
    #[must_use]
    fn neg(&self) -> Self;
    /// Whether this is known to be exactly 0, so that a product with it may be left out.
    fn is_zero(&self) -> bool;
}

impl<R: Ring> Matrix<R> {
    /// The data as elements of the ring, exactly.
    /// # Errors
    /// [`ProofError::NotFinite`] names the first entry that is NaN or infinite, and `what` it is an entry of.
    pub fn embed(data: &Matrix<f64>, what: &'static str) -> Result<Self, ProofError> {
        let mut entries = Vec::with_capacity(data.as_slice().len());
        for (k, &value) in data.as_slice().iter().enumerate() {
            let (row, column) = (k / data.cols(), k % data.cols());
            entries.push(R::from_f64(value).ok_or(ProofError::NotFinite { what, row, column, value })?);
        }
        Self::from_row_major(data.rows(), data.cols(), entries)
    }

    /// The matrix of zeros.
    pub fn zeros(rows: usize, cols: usize) -> Self {
        Self::from_fn(rows, cols, |_, _| R::zero())
    }

    /// The identity of order n times `x`.
    pub fn scalar(n: usize, x: &R) -> Self {
        Self::from_fn(n, n, |i, j| if i == j { x.clone() } else { R::zero() })
    }

    /// `self * rhs`, 2 rows(self) cols(self) cols(rhs) operations of the ring.
    /// # Errors
    /// [`ProofError::DimensionMismatch`].
    pub fn product(&self, rhs: &Self) -> Result<Self, ProofError> {
        rhs.expect_shape("the right factor", (self.cols(), rhs.cols()))?;
        let mut product = Self::zeros(self.rows(), rhs.cols());
        // Row by row, so that both factors are read in the order of their storage; each sum is taken in the order of k.
        for i in 0..self.rows() {
            for (k, x) in self.row(i).iter().enumerate().filter(|(_, x)| !x.is_zero()) {
                for (sum, y) in product.row_mut(i).iter_mut().zip(rhs.row(k)) {
                    if !y.is_zero() {
                        *sum = sum.add(&x.mul(y));
                    }
                }
            }
        }
        Ok(product)
    }

    /// `self + rhs`.
    /// # Errors
    /// [`ProofError::DimensionMismatch`].
    pub fn sum(&self, rhs: &Self) -> Result<Self, ProofError> {
        rhs.expect_shape("the second term", self.shape())?;
        Ok(Self::from_fn(self.rows(), self.cols(), |i, j| self[(i, j)].add(&rhs[(i, j)])))
    }

    /// `self - rhs`.
    /// # Errors
    /// [`ProofError::DimensionMismatch`].
    pub fn difference(&self, rhs: &Self) -> Result<Self, ProofError> {
        rhs.expect_shape("the second term", self.shape())?;
        Ok(Self::from_fn(self.rows(), self.cols(), |i, j| self[(i, j)].sub(&rhs[(i, j)])))
    }

    /// `-self`.
    #[must_use]
    pub fn negative(&self) -> Self {
        self.map(Ring::neg)
    }

    /// `x * self`.
    #[must_use]
    pub fn scaled(&self, x: &R) -> Self {
        self.map(|y| x.mul(y))
    }

    /// `self + self'`, symmetric entry by entry.
    /// # Errors
    /// [`ProofError::DimensionMismatch`] when the matrix is not square.
    pub fn plus_transpose(&self) -> Result<Self, ProofError> {
        self.expect_shape("a matrix to be added to its transpose", (self.rows(), self.rows()))?;
        Ok(Self::from_fn(self.rows(), self.rows(), |i, j| {
            // The same operands in the same order on both sides of the diagonal.
            let (i, j) = if i < j { (i, j) } else { (j, i) };
            self[(i, j)].add(&self[(j, i)])
        }))
    }

    /// `self' p self` for a symmetric p, symmetric entry by entry.
    /// # Errors
    /// [`ProofError::DimensionMismatch`].
    pub fn congruence(&self, p: &Self) -> Result<Self, ProofError> {
        let full = self.transpose().product(&p.product(self)?)?;
        // Either triangle would do; the two differ by their roundings.
        Ok(Self::from_fn(self.cols(), self.cols(), |i, j| full[(i.max(j), i.min(j))].clone()))
    }

    /// The symmetric matrix `[[self, corner], [corner', last]]`.
    /// # Errors
    /// [`ProofError::DimensionMismatch`] when the blocks do not fit.
    pub fn bordered(&self, corner: &Self, last: &Self) -> Result<Self, ProofError> {
        let (n, m) = (self.rows(), last.rows());
        self.expect_shape("the first diagonal block", (n, n))?;
        last.expect_shape("the last diagonal block", (m, m))?;
        corner.expect_shape("the corner block", (n, m))?;
        Ok(Self::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
            (true, true) => self[(i, j)].clone(),
            (true, false) => corner[(i, j - n)].clone(),
            (false, true) => corner[(j, i - n)].clone(),
            (false, false) => last[(i - n, j - n)].clone(),
        }))
    }
}
