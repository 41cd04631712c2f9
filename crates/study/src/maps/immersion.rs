//! beta, phi and phi^L of an immersion-and-invariance observer as expressions.

use super::kkl::KklMaps;
use luenberger_design::Region;
use luenberger_expression::{Expression, ExpressionPlant};
use luenberger_observers::immersion_invariance::DifferentiableImmersion;
use luenberger_observers::{Immersion, KklMap, ObserverDimensions};
use luenberger_plants::{Differentiable, Dimensions, Plant};
use nalgebra::{DMatrix, DVector, Dyn, RealField};

/// The maps of an I&I observer that estimates all states of the plant.
///
/// Derivatives are symbolic: beta is the output of a plant with the states (chi, y), phi of one with the states x.
#[derive(Debug, Clone, PartialEq)]
pub struct ImmersionMaps {
    /// n, m, p of the plant.
    pub plant: Dimensions,
    /// The number of states chi.
    pub order: usize,
    /// beta(y, chi), as rows h of a plant with the states (chi, y).
    pub beta: ExpressionPlant,
    /// phi(x), as rows h of a plant with the states x.
    pub phi: ExpressionPlant,
    /// phi and phi^L as those of a KKL observer, whose Lambda and B are zero: phi^L reads z as xi.
    pub image: KklMaps,
    /// chi for an estimate, expressions of x as states and y as inputs; none for `phi(x) - beta(y, 0)`.
    pub start: Option<Vec<Expression>>,
    /// Q(y, chi, u), expressions of chi as states and (u, y) as inputs; none for 0.
    pub freedom: Option<Vec<Expression>>,
    /// rho(y, chi, u), likewise.
    pub rho: Option<Vec<Expression>>,
}

/// The maps with the region over which they are checked.
#[derive(Debug, Clone, PartialEq)]
pub struct ImmersionSpec {
    /// The maps.
    pub maps: ImmersionMaps,
    /// The region of states, inputs and time.
    pub region: Region,
}

fn joined<T: RealField + Copy>(first: &DVector<T>, second: &DVector<T>) -> DVector<T> {
    DVector::from_iterator(first.len() + second.len(), first.iter().chain(second.iter()).copied())
}

fn column<T: RealField + Copy>(rows: &[Expression], x: &DVector<T>, known: &DVector<T>) -> DVector<T> {
    let values = rows.iter().map(|row| row.evaluate(T::zero(), x.as_slice(), known.as_slice()));
    DVector::from_iterator(rows.len(), values)
}

impl ImmersionMaps {
    /// The length of beta and phi.
    pub fn rows(&self) -> usize {
        self.beta.h().len()
    }

    /// `[D_chi beta, D_y beta]`.
    pub fn beta_jacobian<T: RealField + Copy>(&self, chi: &DVector<T>, y: &DVector<T>) -> DMatrix<T> {
        self.beta.output_jacobian(T::zero(), &joined(chi, y), &DVector::zeros(0))
    }

    /// `D phi`.
    pub fn phi_jacobian<T: RealField + Copy>(&self, x: &DVector<T>) -> DMatrix<T> {
        self.phi.output_jacobian(T::zero(), x, &DVector::zeros(0))
    }
}

impl<T: RealField + Copy> Immersion<T> for ImmersionMaps {
    type States = Dyn;
    type Inputs = Dyn;
    type Outputs = Dyn;
    type Manifold = Dyn;
    type Extension = Dyn;
    type Estimate = Dyn;

    fn dimensions(&self) -> ObserverDimensions {
        let Dimensions { states, inputs, outputs } = self.plant;
        ObserverDimensions { state: self.order, inputs, outputs, estimate: states }
    }

    fn beta(&self, y: &DVector<T>, chi: &DVector<T>) -> DVector<T> {
        self.beta.output(T::zero(), &joined(chi, y), &DVector::zeros(0))
    }

    fn phi(&self, x: &DVector<T>) -> DVector<T> {
        self.phi.output(T::zero(), x, &DVector::zeros(0))
    }

    fn left_inverse(&self, z: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        KklMap::<T>::left_inverse(&self.image, T::zero(), z, y)
    }

    fn estimate(&self, xhat: &DVector<T>) -> DVector<T> {
        xhat.clone()
    }

    fn start(&self, estimate: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        match &self.start {
            Some(start) => column(start, estimate, y),
            None => Immersion::<T>::phi(self, estimate) - Immersion::<T>::beta(self, y, &DVector::zeros(self.order)),
        }
    }

    fn freedom(&self, y: &DVector<T>, chi: &DVector<T>, u: &DVector<T>) -> DVector<T> {
        self.freedom.as_ref().map_or_else(|| DVector::zeros(self.order), |rows| column(rows, chi, &joined(u, y)))
    }

    fn rho(&self, y: &DVector<T>, chi: &DVector<T>, u: &DVector<T>) -> Option<DVector<T>> {
        self.rho.as_ref().map(|rows| column(rows, chi, &joined(u, y)))
    }
}

impl<T: RealField + Copy> DifferentiableImmersion<T> for ImmersionMaps {
    fn beta_directional(&self, y: &DVector<T>, chi: &DVector<T>, dy: &DVector<T>, dchi: &DVector<T>) -> DVector<T> {
        self.beta_jacobian(chi, y) * joined(dchi, dy)
    }

    fn phi_directional(&self, x: &DVector<T>, dx: &DVector<T>) -> DVector<T> {
        self.phi_jacobian(x) * dx
    }
}
