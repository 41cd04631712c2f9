//! The numerical KKL observer with its sizes erased: two states with three target states, three with four.

use luenberger_expression::{ExpressionPlant, ExpressionPlantError, Fixed};
use luenberger_observers::numerical_kkl::{Branch, Node, PolynomialInverse, PolynomialTree, SampledFilter, SampledKkl};
use luenberger_observers::{ObserverDimensions, ObserverError, SampledObserver};
use nalgebra::{DMatrix, DVector, RealField, SMatrix, SVector};

use crate::program::Scalar;

/// The left inverse, on the heap.
pub type Inverse<T, const N: usize, const Z: usize> = PolynomialInverse<T, Vec<Node<T>>, Vec<T>, N, Z>;

type Sized<T, const N: usize, const Z: usize> = SampledKkl<Fixed<N, 0, 1>, T, Vec<Node<T>>, Vec<T>, N, 0, 1, Z>;

/// A sampled numerical KKL observer of a plant without inputs and with one output.
#[derive(Debug, Clone, PartialEq)]
pub enum Kkl<T: RealField + Copy> {
    /// Two states.
    Two(Box<Sized<T, 2, 3>>),
    /// Three states.
    Three(Box<Sized<T, 3, 4>>),
}

/// The same expression for each size.
macro_rules! each {
    ($kkl:expr, $observer:ident => $expression:expr) => {
        match $kkl {
            Kkl::Two($observer) => $expression,
            Kkl::Three($observer) => $expression,
        }
    };
}

impl Kkl<f64> {
    /// The observer of a plant of two states; the filter has D (3 x 3) and B (3 x 1).
    ///
    /// # Errors
    /// [`ExpressionPlantError::Sizes`] for a plant of other sizes; the errors of [`SampledKkl::new`].
    pub fn two(
        plant: &ExpressionPlant,
        filter: SampledFilter<f64, 1, 3>,
        inverse: Inverse<f64, 2, 3>,
    ) -> Result<Self, KklError> {
        Ok(Self::Two(Box::new(SampledKkl::new(plant.fixed::<2, 0, 1>()?, filter, inverse)?)))
    }

    /// The same of three states, with four target states.
    ///
    /// # Errors
    /// As [`two`](Self::two).
    pub fn three(
        plant: &ExpressionPlant,
        filter: SampledFilter<f64, 1, 4>,
        inverse: Inverse<f64, 3, 4>,
    ) -> Result<Self, KklError> {
        Ok(Self::Three(Box::new(SampledKkl::new(plant.fixed::<3, 0, 1>()?, filter, inverse)?)))
    }

    /// The same over another scalar.
    pub(crate) fn cast<T: RealField + Copy>(&self) -> Result<Kkl<T>, ObserverError> {
        Ok(match self {
            Self::Two(observer) => Kkl::Two(Box::new(cast(observer)?)),
            Self::Three(observer) => Kkl::Three(Box::new(cast(observer)?)),
        })
    }

    pub(crate) fn plant(&self) -> &ExpressionPlant {
        each!(self, observer => observer.plant().plant())
    }

    /// Lengths of its columns.
    pub(crate) fn dimensions(&self) -> ObserverDimensions {
        each!(self, observer => observer.dimensions())
    }

    /// Runge-Kutta steps between two samples.
    pub(crate) fn substeps(&self) -> usize {
        each!(self, observer => observer.filter().substeps)
    }

    pub(crate) fn period(&self) -> f64 {
        each!(self, observer => observer.period())
    }

    /// Matrices of the filter and of the coordinates, and the box of the estimates, with their names in emitted code.
    pub(crate) fn matrices(&self) -> Vec<(&'static str, DMatrix<f64>)> {
        fn dynamic<const R: usize, const C: usize>(m: &SMatrix<f64, R, C>) -> DMatrix<f64> {
            DMatrix::from_fn(R, C, |i, j| m[(i, j)])
        }
        each!(self, observer => {
            let (filter, inverse) = (observer.filter(), observer.inverse());
            let (coordinates, (lower, upper)) = (inverse.coordinates(), inverse.bounds());
            vec![
                ("FILTER", dynamic(&filter.d)),
                ("B", dynamic(&filter.b)),
                ("MEAN", dynamic(coordinates.mean())),
                ("WHITEN", dynamic(coordinates.whiten())),
                ("COLOUR", dynamic(coordinates.colour())),
                ("LOWER", dynamic(lower)),
                ("UPPER", dynamic(upper)),
            ]
        })
    }

    /// The trees: from w to the state, and from the state to w.
    pub(crate) fn trees(&self) -> [(&'static str, Tree); 2] {
        each!(self, observer => {
            [("inverse", Tree::of(observer.inverse().inverse())), ("forward", Tree::of(observer.inverse().forward()))]
        })
    }
}

fn cast<T: RealField + Copy, const N: usize, const Z: usize>(
    observer: &Sized<f64, N, Z>,
) -> Result<Sized<T, N, Z>, ObserverError> {
    let convert = |x: f64| nalgebra::convert::<f64, T>(x);
    let SampledFilter { d, b, period, substeps } = observer.filter();
    let (d, b) = (d.map(convert), b.map(convert));
    let filter = SampledFilter { d, b, period: convert(*period), substeps: *substeps };
    SampledKkl::new(observer.plant().clone(), filter, observer.inverse().cast())
}

impl<T: RealField + Copy> Kkl<T> {
    /// z at the start.
    pub(crate) fn start(&self, estimate: &DVector<T>) -> DVector<T> {
        each!(self, observer => {
            let xhat = SVector::from_fn(|i, _| estimate[i]);
            let z = observer.initial(T::zero(), &xhat, &SVector::zeros(), &SVector::zeros());
            DVector::from_column_slice(z.as_slice())
        })
    }

    pub(crate) fn estimate(&self, z: &DVector<T>) -> DVector<T> {
        each!(self, observer => {
            let z = SVector::from_fn(|i, _| z[i]);
            DVector::from_column_slice(observer.estimate(&z).as_slice())
        })
    }

    pub(crate) fn step(&self, t: T, z: &mut DVector<T>, y: &DVector<T>) {
        each!(self, observer => {
            let mut fixed = SVector::from_fn(|i, _| z[i]);
            observer.step(t, &mut fixed, &SVector::zeros(), &SVector::from_fn(|i, _| y[i]));
            z.copy_from_slice(fixed.as_slice());
        });
    }

    pub(crate) fn period_in_format(&self) -> T {
        each!(self, observer => observer.period())
    }

    pub(crate) fn plant_in_format(&self) -> &ExpressionPlant {
        each!(self, observer => observer.plant().plant())
    }
}

/// Why there is no such observer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum KklError {
    /// A plant of other sizes.
    #[error(transparent)]
    Plant(#[from] ExpressionPlantError),
    /// Matrices that are refused.
    #[error(transparent)]
    Observer(#[from] ObserverError),
}

/// A tree of polynomials as numbers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tree {
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    pub(crate) degree: usize,
    pub(crate) nodes: Vec<Node<f64>>,
    pub(crate) leaves: Vec<f64>,
}

impl Tree {
    fn of<const I: usize, const O: usize>(tree: &PolynomialTree<f64, Vec<Node<f64>>, Vec<f64>, I, O>) -> Self {
        let (nodes, leaves) = (tree.nodes().to_vec(), tree.leaves().to_vec());
        Self { inputs: I, outputs: O, degree: tree.degree(), nodes, leaves }
    }

    /// Coefficients of one polynomial.
    pub(crate) fn coefficients(&self) -> usize {
        luenberger_observers::numerical_kkl::polynomial_tree::monomial_count(self.inputs, self.degree)
    }

    /// Numbers of one leaf.
    pub(crate) fn stride(&self) -> usize {
        2 * (self.inputs + self.outputs) + self.outputs * self.coefficients()
    }

    /// All numbers as the format stores them, comparisons first.
    pub(crate) fn numbers(&self, scalar: Scalar) -> impl Iterator<Item = f64> {
        self.nodes.iter().map(|node| node.threshold).chain(self.leaves.iter().copied()).map(move |x| scalar.round(x))
    }

    /// The number of a branch in emitted code: comparisons from 0 on, leaves from -1 down.
    pub(crate) fn code(branch: Branch) -> i32 {
        match branch {
            Branch::Node(index) => i32::from(index),
            Branch::Leaf(index) => -1 - i32::from(index),
        }
    }

    /// Operations of one evaluation, comparisons included.
    pub(crate) fn operations(&self) -> usize {
        // A walk of half of the comparisons is longer than that of a balanced tree.
        let walk = self.nodes.len().div_ceil(2);
        walk + 4 * self.inputs + self.outputs * (2 * self.coefficients() + 2)
    }
}
