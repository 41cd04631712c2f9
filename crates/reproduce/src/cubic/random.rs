//! Random plants for the theorems, seeded for reproducibility.

use luenberger_plants::StateSpace;
use luenberger_random::{Draws, Purpose, Stream};
use nalgebra::{DMatrix, DVector};

use crate::claim::CheckError;

/// The seed of every random case of this paper; it is named in the notes.
pub(super) const SEED: u64 = 2019;

/// A source of random matrices.
pub(super) struct Random(Draws);

impl Random {
    pub(super) fn new() -> Self {
        Self(Stream::new(SEED, Purpose::RandomCase, 0).draws(0))
    }

    pub(super) fn matrix(&mut self, rows: usize, columns: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |_, _| self.0.unit())
    }

    pub(super) fn vector(&mut self, n: usize) -> DVector<f64> {
        DVector::from_fn(n, |_, _| self.0.unit())
    }

    /// A plant with n states, one input and p outputs; observable with probability one.
    pub(super) fn plant(&mut self, n: usize, p: usize) -> Result<StateSpace, CheckError> {
        Ok(StateSpace::new(self.matrix(n, n), self.matrix(n, 1), self.matrix(p, n))?)
    }

    /// `S = D D' + I/10 + (K - K')`: `S + S' > 0`, and not symmetric.
    pub(super) fn accretive(&mut self, p: usize) -> DMatrix<f64> {
        let (d, k) = (self.matrix(p, p), self.matrix(p, p));
        &d * d.transpose() + DMatrix::identity(p, p) * 0.1 + &k - k.transpose()
    }

    /// `D D' + I/10`.
    pub(super) fn definite(&mut self, p: usize) -> DMatrix<f64> {
        let d = self.matrix(p, p);
        let product = &d * d.transpose() + DMatrix::identity(p, p) * 0.1;
        (&product + product.transpose()) * 0.5
    }
}
