//! phi, Lambda, B and phi^L as expressions: the maps of `xi' = Lambda(t, u, y) xi + B(t, xi, u, y)`,
//! `xhat = phi^L(t, xi, y)`.

use luenberger_design::Region;
use luenberger_expression::Expression;
use luenberger_observers::ObserverDimensions;
use luenberger_observers::kkl::KklMap;
use luenberger_plants::Dimensions;
use nalgebra::{DMatrix, DVector, Dyn, RealField};

/// The maps of a KKL observer that estimates all states of the plant.
///
/// phi is evaluated with x and y; the other maps with xi as states and (u, y) as inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct KklMaps {
    /// n, m, p of the plant.
    pub plant: Dimensions,
    /// phi, n_z expressions.
    pub phi: Vec<Expression>,
    /// Lambda, n_z x n_z, row by row.
    pub lambda: Vec<Expression>,
    /// B, n_z expressions.
    pub injection: Vec<Expression>,
    /// phi^L, n expressions.
    pub left_inverse: Vec<Expression>,
}

/// The maps with the region over which they are checked.
#[derive(Debug, Clone, PartialEq)]
pub struct KklMapsSpec {
    /// The maps.
    pub maps: KklMaps,
    /// The region of states, inputs and time.
    pub region: Region,
}

impl KklMaps {
    /// The number of states xi.
    pub fn order(&self) -> usize {
        self.phi.len()
    }

    /// (u, y) as one list; u is 0 for maps that do not read it.
    pub(super) fn known<T: RealField + Copy>(&self, u: Option<&DVector<T>>, y: &DVector<T>) -> Vec<T> {
        let inputs = (0..self.plant.inputs).map(|k| u.map_or(T::zero(), |u| u[k]));
        inputs.chain(y.iter().copied()).collect()
    }

    /// Each expression at these values.
    pub(super) fn column<T: RealField + Copy>(rows: &[Expression], t: T, x: &[T], known: &[T]) -> DVector<T> {
        DVector::from_iterator(rows.len(), rows.iter().map(|row| row.evaluate(t, x, known)))
    }
}

impl<T: RealField + Copy> KklMap<T> for KklMaps {
    type Xi = Dyn;
    type Inputs = Dyn;
    type Outputs = Dyn;
    type Estimate = Dyn;

    fn dimensions(&self) -> ObserverDimensions {
        let Dimensions { states, inputs, outputs } = self.plant;
        ObserverDimensions { state: self.order(), inputs, outputs, estimate: states }
    }

    fn lambda(&self, t: T, u: &DVector<T>, y: &DVector<T>) -> DMatrix<T> {
        let (order, known) = (self.order(), self.known(Some(u), y));
        DMatrix::from_fn(order, order, |i, j| self.lambda[i * order + j].evaluate(t, &[], &known))
    }

    fn injection(&self, t: T, xi: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        Self::column(&self.injection, t, xi.as_slice(), &self.known(Some(u), y))
    }

    fn left_inverse(&self, t: T, xi: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        Self::column(&self.left_inverse, t, xi.as_slice(), &self.known(None, y))
    }

    fn image(&self, t: T, xhat: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        Self::column(&self.phi, t, xhat.as_slice(), y.as_slice())
    }
}
