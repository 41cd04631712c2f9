//! The numerical KKL observer with its sizes erased: two states with three target states, three with four.

use luenberger_expression::{ExpressionPlant, ExpressionPlantError, Fixed};
use luenberger_observers::numerical_kkl::{
    Branch, InterpolatedInverse, Node, PolynomialInverse, PolynomialTree, SampledFilter, SampledKkl, Search,
    StateInverse,
};
use luenberger_observers::{ObserverDimensions, ObserverError, SampledObserver};
use nalgebra::{DMatrix, DVector, RealField, SMatrix, SVector};

use crate::program::Scalar;

/// The left inverse, on the heap.
pub type Inverse<T, const N: usize, const Z: usize> = PolynomialInverse<T, Vec<Node<T>>, Vec<T>, N, Z>;

/// The interpolated left inverse, on the heap.
pub type Interpolated<T, const N: usize, const Z: usize> = InterpolatedInverse<T, Vec<Node<T>>, Vec<T>, N, Z>;

type Sized<T, I, const N: usize, const Z: usize> = SampledKkl<Fixed<N, 0, 1>, T, I, N, 0, 1, Z>;

/// A sampled numerical KKL observer of a plant without inputs and with one output.
#[derive(Debug, Clone, PartialEq)]
pub enum Kkl<T: RealField + Copy> {
    /// Two states, the embedded left inverse.
    Two(Box<Sized<T, Inverse<T, 2, 3>, 2, 3>>),
    /// Three states.
    Three(Box<Sized<T, Inverse<T, 3, 4>, 3, 4>>),
    /// Two states, the interpolated left inverse.
    TwoInterpolated(Box<Sized<T, Interpolated<T, 2, 3>, 2, 3>>),
    /// Three states.
    ThreeInterpolated(Box<Sized<T, Interpolated<T, 3, 4>, 3, 4>>),
}

/// The same expression for each size and form.
macro_rules! each {
    ($kkl:expr, $observer:ident => $expression:expr) => {
        match $kkl {
            Kkl::Two($observer) => $expression,
            Kkl::Three($observer) => $expression,
            Kkl::TwoInterpolated($observer) => $expression,
            Kkl::ThreeInterpolated($observer) => $expression,
        }
    };
}

/// The parts of a left inverse of either form.
trait Parts<T, const N: usize, const Z: usize>: StateInverse<T, N, Z> {
    /// The same over another scalar.
    type Over<U: RealField + Copy>: StateInverse<U, N, Z>;

    fn over<U: RealField + Copy>(&self) -> Self::Over<U>;

    /// The embedded form, from which the search of the interpolated one starts.
    fn embedded(&self) -> &Inverse<T, N, Z>;

    /// The table of the interpolated form.
    fn table(&self) -> Option<TableOf>;
}

impl<T: RealField + Copy, const N: usize, const Z: usize> Parts<T, N, Z> for Inverse<T, N, Z> {
    type Over<U: RealField + Copy> = Inverse<U, N, Z>;

    fn over<U: RealField + Copy>(&self) -> Inverse<U, N, Z> {
        self.cast()
    }

    fn embedded(&self) -> &Inverse<T, N, Z> {
        self
    }

    fn table(&self) -> Option<TableOf> {
        None
    }
}

impl<T: RealField + Copy, const N: usize, const Z: usize> Parts<T, N, Z> for Interpolated<T, N, Z> {
    type Over<U: RealField + Copy> = Interpolated<U, N, Z>;

    fn over<U: RealField + Copy>(&self) -> Interpolated<U, N, Z> {
        self.cast()
    }

    fn embedded(&self) -> &Inverse<T, N, Z> {
        self.start()
    }

    fn table(&self) -> Option<TableOf> {
        let number = |x: &T| x.to_subset_unchecked();
        let Search { max_evaluations, tolerance, fallback } = self.search();
        Some(TableOf {
            points: self.spline().points().to_vec(),
            outputs: Z,
            coefficients: self.spline().coefficients().iter().map(number).collect(),
            max_evaluations: *max_evaluations,
            tolerance: number(tolerance),
            fallback: *fallback,
        })
    }
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

    /// The observer of a plant of two states with the interpolated left inverse.
    ///
    /// # Errors
    /// As [`two`](Self::two); [`KklError::Large`] for a table that is too large for source code.
    pub fn two_interpolated(
        plant: &ExpressionPlant,
        filter: SampledFilter<f64, 1, 3>,
        inverse: Interpolated<f64, 2, 3>,
    ) -> Result<Self, KklError> {
        let inverse = small(inverse)?;
        Ok(Self::TwoInterpolated(Box::new(SampledKkl::new(plant.fixed::<2, 0, 1>()?, filter, inverse)?)))
    }

    /// The same of three states, with four target states.
    ///
    /// # Errors
    /// As [`two_interpolated`](Self::two_interpolated).
    pub fn three_interpolated(
        plant: &ExpressionPlant,
        filter: SampledFilter<f64, 1, 4>,
        inverse: Interpolated<f64, 3, 4>,
    ) -> Result<Self, KklError> {
        let inverse = small(inverse)?;
        Ok(Self::ThreeInterpolated(Box::new(SampledKkl::new(plant.fixed::<3, 0, 1>()?, filter, inverse)?)))
    }

    /// The same over another scalar.
    pub(crate) fn cast<T: RealField + Copy>(&self) -> Result<Kkl<T>, ObserverError> {
        Ok(match self {
            Self::Two(observer) => Kkl::Two(Box::new(cast(observer)?)),
            Self::Three(observer) => Kkl::Three(Box::new(cast(observer)?)),
            Self::TwoInterpolated(observer) => Kkl::TwoInterpolated(Box::new(cast(observer)?)),
            Self::ThreeInterpolated(observer) => Kkl::ThreeInterpolated(Box::new(cast(observer)?)),
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
            let (filter, inverse) = (observer.filter(), observer.inverse().embedded());
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
            let inverse = observer.inverse().embedded();
            [("inverse", Tree::of(inverse.inverse())), ("forward", Tree::of(inverse.forward()))]
        })
    }

    /// The table of the interpolated form, as the format stores it.
    pub(crate) fn table(&self, scalar: Scalar) -> Option<TableOf> {
        let single = match scalar {
            Scalar::Binary32 => {
                self.cast::<f32>().ok().and_then(|kkl| each!(&kkl, observer => observer.inverse().table()))
            }
            Scalar::Binary64 => None,
        };
        single.or_else(|| each!(self, observer => observer.inverse().table()))
    }
}

/// Numbers of a table beyond which it is refused: 2 MiB in f64.
const MOST_NUMBERS: usize = 1 << 18;

/// The interpolated form with a table that source code can hold.
fn small<const N: usize, const Z: usize>(
    inverse: Interpolated<f64, N, Z>,
) -> Result<Interpolated<f64, N, Z>, KklError> {
    let numbers = inverse.spline().coefficients().len();
    if numbers > MOST_NUMBERS {
        return Err(KklError::Large { numbers });
    }
    // Both forms clamp; emitted code has one box.
    let (spline, start) = (inverse.spline().bounds(), inverse.start().bounds());
    if spline == start { Ok(inverse) } else { Err(KklError::Boxes) }
}

fn cast<T: RealField + Copy, I: Parts<f64, N, Z>, const N: usize, const Z: usize>(
    observer: &Sized<f64, I, N, Z>,
) -> Result<Sized<T, I::Over<T>, N, Z>, ObserverError> {
    let convert = |x: f64| nalgebra::convert::<f64, T>(x);
    let SampledFilter { d, b, period, substeps } = observer.filter();
    let (d, b) = (d.map(convert), b.map(convert));
    let filter = SampledFilter { d, b, period: convert(*period), substeps: *substeps };
    SampledKkl::new(observer.plant().clone(), filter, observer.inverse().over())
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
#[non_exhaustive]
pub enum KklError {
    /// A plant of other sizes.
    #[error(transparent)]
    Plant(#[from] ExpressionPlantError),
    /// Matrices that are refused.
    #[error(transparent)]
    Observer(#[from] ObserverError),
    /// A table that is too large.
    #[error(
        "the table of the interpolated left inverse has {numbers} numbers, more than {MOST_NUMBERS}: fewer `points`, or form = \"embedded\""
    )]
    Large {
        /// Its numbers.
        numbers: usize,
    },
    /// Two forms of a left inverse for different boxes.
    #[error("the table of the left inverse and the tree from which its search starts are for different boxes")]
    Boxes,
}

/// T as a table of splines, and the search in it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TableOf {
    pub(crate) points: Vec<usize>,
    pub(crate) outputs: usize,
    pub(crate) coefficients: Vec<f64>,
    pub(crate) max_evaluations: usize,
    pub(crate) tolerance: f64,
    pub(crate) fallback: usize,
}

impl TableOf {
    /// Operations of one evaluation with its Jacobian.
    pub(crate) fn operations(&self) -> usize {
        let n = self.points.len();
        let corners = 4_usize.pow(n as u32);
        32 * n + corners * (n + 1) * (n + 2 * self.outputs)
    }

    /// Evaluations of a search at most: from the estimate of the tree, and from the best points of the coarse grid.
    pub(crate) fn evaluations(&self) -> usize {
        let restarts = luenberger_observers::numerical_kkl::least_squares::RESTARTS;
        match self.fallback {
            0 => self.max_evaluations,
            count => self.max_evaluations * (1 + restarts) + count.pow(self.points.len() as u32),
        }
    }
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
