//! A high-gain observer with given maps:
//! `xi_i' = drift_i + shape_i (alpha_i/r^j) (y_k - head_k)`, `xhat = k(t, xi, u, y)`.

use luenberger_expression::Expression;
use luenberger_observers::ObserverDimensions;
use luenberger_observers::high_gain::{ChainPosition, HighGainMap};
use luenberger_plants::Dimensions;
use nalgebra::{DVector, Dyn, RealField};

/// The maps of a high-gain observer that estimates all states of the plant.
///
/// drift and estimate are evaluated with xi as states and (u, y) as inputs, shape with (u, y), start with x and y.
#[derive(Debug, Clone, PartialEq)]
pub struct HighGainMaps {
    /// n, m, p of the plant.
    pub plant: Dimensions,
    /// The length of the chain of each output.
    pub lengths: Vec<usize>,
    /// The right-hand side without corrections, one expression for each xi.
    pub drift: Vec<Expression>,
    /// Factors of the corrections, likewise.
    pub shape: Vec<Expression>,
    /// xhat, n expressions.
    pub estimate: Vec<Expression>,
    /// xi for an estimate.
    pub start: Vec<Expression>,
}

impl HighGainMaps {
    /// The number of states xi.
    pub fn order(&self) -> usize {
        self.drift.len()
    }

    /// The rows at these values.
    fn column<T: RealField + Copy>(rows: &[Expression], t: T, x: &[T], u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        let known: Vec<T> = u.iter().chain(y.iter()).copied().collect();
        DVector::from_iterator(rows.len(), rows.iter().map(|row| row.evaluate(t, x, &known)))
    }
}

/// The output and the position of entry `i` in chains of these lengths, one behind the other.
pub(crate) fn place(lengths: &[usize], i: usize) -> ChainPosition {
    let mut head = 0;
    for (output, length) in lengths.iter().enumerate() {
        if i < head + length {
            return ChainPosition { output, position: i - head + 1 };
        }
        head += length;
    }
    // Beyond the last chain there is no position, and the constructor of the observer returns an error.
    ChainPosition { output: lengths.len(), position: 0 }
}

impl<T: RealField + Copy> HighGainMap<T> for HighGainMaps {
    type Xi = Dyn;
    type Inputs = Dyn;
    type Outputs = Dyn;
    type Estimate = Dyn;

    fn dimensions(&self) -> ObserverDimensions {
        let Dimensions { states, inputs, outputs } = self.plant;
        ObserverDimensions { state: self.order(), inputs, outputs, estimate: states }
    }

    fn place(&self, i: usize) -> ChainPosition {
        place(&self.lengths, i)
    }

    fn drift(&self, t: T, xi: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        Self::column(&self.drift, t, xi.as_slice(), u, y)
    }

    fn shape(&self, t: T, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        Self::column(&self.shape, t, &[], u, y)
    }

    fn estimate(&self, t: T, xi: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        Self::column(&self.estimate, t, xi.as_slice(), u, y)
    }

    fn start(&self, t: T, estimate: &DVector<T>, _u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        Self::column(&self.start, t, estimate.as_slice(), &DVector::zeros(0), y)
    }
}
