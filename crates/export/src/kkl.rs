//! Numerical KKL observers with their sizes erased: two to six states with one target state more, and two or three
//! states with one or two held inputs.

use luenberger_expression::{ExpressionPlant, ExpressionPlantError, Fixed};
use luenberger_observers::numerical_kkl::held_inputs::InverseOnHeap;
use luenberger_observers::numerical_kkl::held_trees::TreesOnHeap;
use luenberger_observers::numerical_kkl::{
    BoxMap, Branch, Coordinates, HeldStateInverse, InterpolatedInverse, Node, PolynomialInverse, PolynomialTree,
    SampledFilter, SampledHeldKkl, SampledKkl, Search, StateInverse, TensorTrain,
};
use luenberger_observers::{MatrixName, ObserverDimensions, ObserverError, SampledObserver};
use nalgebra::{DMatrix, DVector, RealField, SMatrix, SVector};

use crate::matrix::ExportedMatrix;
use crate::scalar::Scalar;

/// The left inverse, on the heap.
pub type Inverse<T, const N: usize, const Z: usize> = PolynomialInverse<T, Vec<Node<T>>, Vec<T>, N, Z>;

/// The interpolated left inverse, on the heap.
pub type Interpolated<T, const N: usize, const Z: usize> = InterpolatedInverse<T, Vec<Node<T>>, Vec<T>, N, Z>;

/// The interpolated left inverse with a table of low rank, on the heap.
pub type LowRank<T, const N: usize, const Z: usize> =
    InterpolatedInverse<T, Vec<Node<T>>, Vec<T>, N, Z, TensorTrain<T, Vec<T>, N, Z>>;

/// A sampled observer of a plant without inputs.
pub type Plain<T, I, const N: usize, const Z: usize> = SampledKkl<Fixed<N, 0, 1>, T, I, N, 0, 1, Z>;

/// A sampled observer for held inputs, with the input at which it starts.
#[derive(Debug, Clone, PartialEq)]
pub struct Held<T, I, const N: usize, const M: usize, const Z: usize, const ZN: usize> {
    observer: SampledHeldKkl<Fixed<N, M, 1>, T, I, N, M, 1, Z, ZN>,
    first: SVector<T, M>,
}

/// The sizes that are offered.
macro_rules! sizes {
    ($($name:ident: $what:literal, $observer:ident<$inverse:ident<$($of:literal),*>, $($size:literal),*>;)*) => {
        /// A sampled numerical KKL observer of a plant with one output.
        #[derive(Debug, Clone, PartialEq)]
        pub enum Kkl<T: RealField + Copy> {
            $(#[doc = $what] $name(Box<$observer<T, $inverse<T, $($of),*>, $($size),*>>),)*
        }

        impl<T: RealField + Copy> Kkl<T> {
            fn any(&self) -> &dyn Erased<T> {
                match self { $(Self::$name(observer) => observer.as_ref(),)* }
            }
        }

        impl Kkl<f64> {
            /// The same over another scalar.
            pub(crate) fn cast<T: RealField + Copy>(&self) -> Result<Kkl<T>, ObserverError> {
                Ok(match self { $(Self::$name(observer) => Kkl::$name(Box::new(observer.over()?)),)* })
            }
        }

        $(impl From<$observer<f64, $inverse<f64, $($of),*>, $($size),*>> for Kkl<f64> {
            fn from(observer: $observer<f64, $inverse<f64, $($of),*>, $($size),*>) -> Self {
                Self::$name(Box::new(observer))
            }
        })*
    };
}

sizes! {
    Two: "Two states, the embedded left inverse.", Plain<Inverse<2, 3>, 2, 3>;
    Three: "Three states.", Plain<Inverse<3, 4>, 3, 4>;
    Four: "Four states.", Plain<Inverse<4, 5>, 4, 5>;
    Five: "Five states.", Plain<Inverse<5, 6>, 5, 6>;
    Six: "Six states.", Plain<Inverse<6, 7>, 6, 7>;
    TwoInterpolated: "Two states, the interpolated left inverse.", Plain<Interpolated<2, 3>, 2, 3>;
    ThreeInterpolated: "Three states.", Plain<Interpolated<3, 4>, 3, 4>;
    FourInterpolated: "Four states.", Plain<Interpolated<4, 5>, 4, 5>;
    FiveInterpolated: "Five states, with a table of low rank.", Plain<LowRank<5, 6>, 5, 6>;
    SixInterpolated: "Six states.", Plain<LowRank<6, 7>, 6, 7>;
    TwoHeld: "Two states and one held input, trees alone.", Held<TreesOnHeap<2, 1, 3, 4, 3>, 2, 1, 3, 5>;
    TwoHeldTwo: "Two states and two held inputs.", Held<TreesOnHeap<2, 2, 3, 5, 4>, 2, 2, 3, 5>;
    ThreeHeld: "Three states and one held input.", Held<TreesOnHeap<3, 1, 4, 5, 4>, 3, 1, 4, 7>;
    ThreeHeldTwo: "Three states and two held inputs.", Held<TreesOnHeap<3, 2, 4, 6, 5>, 3, 2, 4, 7>;
    TwoHeldTables: "Two states and one held input, with tables.", Held<InverseOnHeap<2, 1, 3, 4>, 2, 1, 3, 5>;
    TwoHeldTwoTables: "Two states and two held inputs.", Held<InverseOnHeap<2, 2, 3, 5>, 2, 2, 3, 5>;
    ThreeHeldTables: "Three states and one held input.", Held<InverseOnHeap<3, 1, 4, 5>, 3, 1, 4, 7>;
    ThreeHeldTwoTables: "Three states and two held inputs.", Held<InverseOnHeap<3, 2, 4, 6>, 3, 2, 4, 7>;
}

/// The numbers of a left inverse.
struct Parts {
    /// Coordinates, box and family, of the exported code.
    matrices: Vec<(ExportedMatrix, DMatrix<f64>)>,
    /// From (w, u) to the state, and from the state to w where there is such a tree.
    trees: Vec<(&'static str, Tree)>,
    table: Option<TableOf>,
}

/// A left inverse whose numbers can be written.
trait Numbers {
    fn parts(&self) -> Parts;
}

/// One without inputs, over another scalar.
trait RecastPlain<const N: usize, const Z: usize> {
    type Over<U: RealField + Copy>: StateInverse<U, N, Z>;

    fn over<U: RealField + Copy>(&self) -> Result<Self::Over<U>, ObserverError>;
}

/// One for held inputs, over another scalar.
trait RecastHeld<const N: usize, const M: usize, const Z: usize> {
    type Over<U: RealField + Copy>: HeldStateInverse<U, N, M, Z>;

    fn over<U: RealField + Copy>(&self) -> Result<Self::Over<U>, ObserverError>;
}

/// Rounded or widened to `f64`.
fn number<T: RealField + Copy>(x: &T) -> f64 {
    x.to_subset_unchecked()
}

fn numbers<T: RealField + Copy, const R: usize, const C: usize>(m: &SMatrix<T, R, C>) -> DMatrix<f64> {
    DMatrix::from_fn(R, C, |i, j| number(&m[(i, j)]))
}

/// Coordinates and box.
fn frame<T: RealField + Copy, const N: usize, const Z: usize>(
    coordinates: &Coordinates<T, Z>,
    (lower, upper): (&SVector<T, N>, &SVector<T, N>),
) -> Vec<(ExportedMatrix, DMatrix<f64>)> {
    vec![
        (ExportedMatrix::Mean, numbers(coordinates.mean())),
        (ExportedMatrix::Whiten, numbers(coordinates.whiten())),
        (ExportedMatrix::Colour, numbers(coordinates.colour())),
        (ExportedMatrix::Lower, numbers(lower)),
        (ExportedMatrix::Upper, numbers(upper)),
    ]
}

/// Ends of the family of inputs.
fn family<T: RealField + Copy, const M: usize>(
    (least, most): &(SVector<T, M>, SVector<T, M>),
) -> [(ExportedMatrix, DMatrix<f64>); 2] {
    [(ExportedMatrix::LeastInput, numbers(least)), (ExportedMatrix::MostInput, numbers(most))]
}

impl<const N: usize, const Z: usize> RecastPlain<N, Z> for Inverse<f64, N, Z> {
    type Over<U: RealField + Copy> = Inverse<U, N, Z>;

    fn over<U: RealField + Copy>(&self) -> Result<Inverse<U, N, Z>, ObserverError> {
        Ok(self.cast())
    }
}

impl<T: RealField + Copy, const N: usize, const Z: usize> Numbers for Inverse<T, N, Z> {
    fn parts(&self) -> Parts {
        let trees = vec![("inverse", Tree::of(self.inverse())), ("forward", Tree::of(self.forward()))];
        Parts { matrices: frame(self.coordinates(), self.bounds()), trees, table: None }
    }
}

impl<const N: usize, const Z: usize> RecastPlain<N, Z> for Interpolated<f64, N, Z> {
    type Over<U: RealField + Copy> = Interpolated<U, N, Z>;

    fn over<U: RealField + Copy>(&self) -> Result<Interpolated<U, N, Z>, ObserverError> {
        Ok(self.cast())
    }
}

impl<T: RealField + Copy, const N: usize, const Z: usize> Numbers for Interpolated<T, N, Z> {
    fn parts(&self) -> Parts {
        let spline = self.spline();
        let table = TableOf {
            points: spline.points().to_vec(),
            outputs: Z,
            ranks: Vec::new(),
            nodes: Vec::new(),
            coefficients: spline.coefficients().iter().map(number).collect(),
            search: Some(search(self.search())),
            // Both forms clamp; emitted code has one box.
            is_plain: spline.bounds() == self.start().bounds(),
        };
        Parts { table: Some(table), ..self.start().parts() }
    }
}

impl<const N: usize, const Z: usize> RecastPlain<N, Z> for LowRank<f64, N, Z> {
    type Over<U: RealField + Copy> = LowRank<U, N, Z>;

    fn over<U: RealField + Copy>(&self) -> Result<LowRank<U, N, Z>, ObserverError> {
        Ok(self.cast())
    }
}

impl<T: RealField + Copy, const N: usize, const Z: usize> Numbers for LowRank<T, N, Z> {
    fn parts(&self) -> Parts {
        let train = self.spline();
        let table = TableOf {
            points: train.points().to_vec(),
            outputs: Z,
            ranks: train.ranks().to_vec(),
            nodes: Vec::new(),
            coefficients: train.coefficients().iter().map(number).collect(),
            search: Some(search(self.search())),
            is_plain: train.bounds() == self.start().bounds(),
        };
        Parts { table: Some(table), ..self.start().parts() }
    }
}

impl<const N: usize, const M: usize, const Z: usize, const ZM: usize, const NM: usize> RecastHeld<N, M, Z>
    for TreesOnHeap<f64, N, M, Z, ZM, NM>
{
    type Over<U: RealField + Copy> = TreesOnHeap<U, N, M, Z, ZM, NM>;

    fn over<U: RealField + Copy>(&self) -> Result<TreesOnHeap<U, N, M, Z, ZM, NM>, ObserverError> {
        self.cast()
    }
}

impl<T: RealField + Copy, const N: usize, const M: usize, const Z: usize, const ZM: usize, const NM: usize> Numbers
    for TreesOnHeap<T, N, M, Z, ZM, NM>
{
    fn parts(&self) -> Parts {
        let mut matrices = frame(self.coordinates(), self.bounds());
        matrices.extend(family(&self.family()));
        let trees = vec![("inverse", Tree::of(self.inverse())), ("forward", Tree::of(self.forward()))];
        Parts { matrices, trees, table: None }
    }
}

impl<const N: usize, const M: usize, const Z: usize, const ZM: usize> RecastHeld<N, M, Z>
    for InverseOnHeap<f64, N, M, Z, ZM>
{
    type Over<U: RealField + Copy> = InverseOnHeap<U, N, M, Z, ZM>;

    fn over<U: RealField + Copy>(&self) -> Result<InverseOnHeap<U, N, M, Z, ZM>, ObserverError> {
        self.cast()
    }
}

impl<T: RealField + Copy, const N: usize, const M: usize, const Z: usize, const ZM: usize> Numbers
    for InverseOnHeap<T, N, M, Z, ZM>
{
    fn parts(&self) -> Parts {
        let tables = self.tables();
        // There are at least two tables, on one box.
        let first = &tables.splines()[0];
        let mut matrices = frame(tables.coordinates(), first.bounds());
        matrices.extend(family(&tables.family()));
        let table = TableOf {
            points: first.points().to_vec(),
            outputs: Z,
            ranks: Vec::new(),
            nodes: (0..M).map(|i| tables.nodes(i).iter().map(number).collect()).collect(),
            coefficients: tables.splines().iter().flat_map(|table| table.coefficients().iter().map(number)).collect(),
            search: self.search().map(search),
            is_plain: tables.splines().iter().all(|table| table.points() == first.points()),
        };
        Parts { matrices, trees: vec![("inverse", Tree::of(self.start()))], table: Some(table) }
    }
}

fn search<T: RealField + Copy>(given: &Search<T>) -> Search<f64> {
    let Search { max_evaluations, tolerance, fallback } = given;
    Search { max_evaluations: *max_evaluations, tolerance: number(tolerance), fallback: *fallback }
}

/// What an observer of any size does.
trait Erased<T> {
    fn plant(&self) -> &ExpressionPlant;

    fn dimensions(&self) -> ObserverDimensions;

    /// D, B, the period and the Runge-Kutta steps in it.
    fn filter(&self) -> (DMatrix<f64>, DMatrix<f64>, T, usize);

    fn parts(&self) -> Parts;

    /// The input at the start, of an observer for held inputs.
    fn first(&self) -> &[T];

    /// z with its estimate behind it, at the start.
    fn start(&self, estimate: &DVector<T>) -> DVector<T>;

    fn step(&self, t: T, state: &mut DVector<T>, u: &DVector<T>, y: &DVector<T>);
}

/// An observer over another scalar.
trait Recast {
    type Over<U: RealField + Copy>;

    fn over<U: RealField + Copy>(&self) -> Result<Self::Over<U>, ObserverError>;
}

fn filter_over<U: RealField + Copy, const Z: usize>(filter: &SampledFilter<f64, 1, Z>) -> SampledFilter<U, 1, Z> {
    let cast = nalgebra::convert::<f64, U>;
    let SampledFilter { d, b, period, substeps } = filter;
    SampledFilter { d: d.map(cast), b: b.map(cast), period: cast(*period), substeps: *substeps }
}

fn filter_of<T: RealField + Copy, const Z: usize>(
    filter: &SampledFilter<T, 1, Z>,
) -> (DMatrix<f64>, DMatrix<f64>, T, usize) {
    (numbers(&filter.d), numbers(&filter.b), filter.period, filter.substeps)
}

fn fixed<T: RealField + Copy, const L: usize>(column: &DVector<T>) -> SVector<T, L> {
    SVector::from_fn(|i, _| column[i])
}

/// z with its estimate behind it.
fn joined<T: RealField + Copy, const Z: usize, const N: usize>(z: &SVector<T, Z>, xhat: &SVector<T, N>) -> DVector<T> {
    DVector::from_iterator(Z + N, z.iter().chain(xhat).copied())
}

impl<I, const N: usize, const Z: usize> Recast for Plain<f64, I, N, Z>
where
    I: StateInverse<f64, N, Z> + RecastPlain<N, Z>,
{
    type Over<U: RealField + Copy> = Plain<U, I::Over<U>, N, Z>;

    fn over<U: RealField + Copy>(&self) -> Result<Self::Over<U>, ObserverError> {
        SampledKkl::new(self.plant().clone(), filter_over(self.filter()), self.inverse().over()?)
    }
}

impl<T, I, const N: usize, const Z: usize> Erased<T> for Plain<T, I, N, Z>
where
    T: RealField + Copy,
    I: StateInverse<T, N, Z> + Numbers,
{
    fn plant(&self) -> &ExpressionPlant {
        self.plant().plant()
    }

    fn dimensions(&self) -> ObserverDimensions {
        SampledObserver::dimensions(self)
    }

    fn filter(&self) -> (DMatrix<f64>, DMatrix<f64>, T, usize) {
        filter_of(self.filter())
    }

    fn parts(&self) -> Parts {
        self.inverse().parts()
    }

    fn first(&self) -> &[T] {
        &[]
    }

    fn start(&self, estimate: &DVector<T>) -> DVector<T> {
        let z = self.initial(T::zero(), &fixed(estimate), &SVector::zeros(), &SVector::zeros());
        joined(&z, &self.estimate(&z))
    }

    fn step(&self, t: T, state: &mut DVector<T>, _u: &DVector<T>, y: &DVector<T>) {
        let mut z = fixed(state);
        SampledObserver::step(self, t, &mut z, &SVector::zeros(), &fixed(y));
        *state = joined(&z, &self.estimate(&z));
    }
}

impl<I, const N: usize, const M: usize, const Z: usize, const ZN: usize> Recast for Held<f64, I, N, M, Z, ZN>
where
    I: HeldStateInverse<f64, N, M, Z> + RecastHeld<N, M, Z>,
{
    type Over<U: RealField + Copy> = Held<U, I::Over<U>, N, M, Z, ZN>;

    fn over<U: RealField + Copy>(&self) -> Result<Self::Over<U>, ObserverError> {
        let Self { observer, first } = self;
        let filter = filter_over(observer.filter());
        let observer = SampledHeldKkl::new(observer.plant().clone(), filter, observer.inverse().over()?)?;
        Ok(Held { observer, first: first.map(nalgebra::convert) })
    }
}

impl<T, I, const N: usize, const M: usize, const Z: usize, const ZN: usize> Erased<T> for Held<T, I, N, M, Z, ZN>
where
    T: RealField + Copy,
    I: HeldStateInverse<T, N, M, Z> + Numbers,
{
    fn plant(&self) -> &ExpressionPlant {
        self.observer.plant().plant()
    }

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: Z, ..self.observer.dimensions() }
    }

    fn filter(&self) -> (DMatrix<f64>, DMatrix<f64>, T, usize) {
        filter_of(self.observer.filter())
    }

    fn parts(&self) -> Parts {
        let mut parts = self.observer.inverse().parts();
        parts.matrices.push((ExportedMatrix::FirstInput, numbers(&self.first)));
        parts
    }

    fn first(&self) -> &[T] {
        self.first.as_slice()
    }

    fn start(&self, estimate: &DVector<T>) -> DVector<T> {
        let state = self.observer.initial(T::zero(), &fixed(estimate), &self.first, &SVector::zeros());
        DVector::from_column_slice(state.as_slice())
    }

    fn step(&self, t: T, state: &mut DVector<T>, u: &DVector<T>, y: &DVector<T>) {
        let mut next = fixed(state);
        self.observer.step(t, &mut next, &fixed(u), &fixed(y));
        state.copy_from_slice(next.as_slice());
    }
}

impl Kkl<f64> {
    /// The observer of a plant of N = 2 to 6 states without inputs; the filter has D (Z x Z) and B (Z x 1), Z = N + 1.
    ///
    /// # Errors
    /// [`ExpressionPlantError::Sizes`] for a plant of other sizes; the errors of [`SampledKkl::new`];
    /// [`KklExportError::Large`] for a table that is too large for source code.
    pub fn new<I, const N: usize, const Z: usize>(
        plant: &ExpressionPlant,
        filter: SampledFilter<f64, 1, Z>,
        inverse: I,
    ) -> Result<Self, KklExportError>
    where
        I: StateInverse<f64, N, Z>,
        SampledKkl<Fixed<N, 0, 1>, f64, I, N, 0, 1, Z>: Into<Self>,
    {
        SampledKkl::new(plant.fixed::<N, 0, 1>()?, filter, inverse)?.into().checked()
    }

    /// The observer of a plant of N = 2 or 3 states with M = 1 or 2 held inputs, which starts at the input `first`.
    /// Z = N + 1, ZN = Z + N.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn held<I, const N: usize, const M: usize, const Z: usize, const ZN: usize>(
        plant: &ExpressionPlant,
        filter: SampledFilter<f64, 1, Z>,
        inverse: I,
        first: SVector<f64, M>,
    ) -> Result<Self, KklExportError>
    where
        I: HeldStateInverse<f64, N, M, Z>,
        Held<f64, I, N, M, Z, ZN>: Into<Self>,
    {
        let observer = SampledHeldKkl::new(plant.fixed::<N, M, 1>()?, filter, inverse)?;
        Held { observer, first }.into().checked()
    }

    /// With a table that source code can hold.
    fn checked(self) -> Result<Self, KklExportError> {
        let Some(table) = self.table(Scalar::Binary64) else { return Ok(self) };
        let numbers = table.coefficients.len();
        if numbers > MOST_NUMBERS {
            return Err(KklExportError::Large { numbers, tables: table.tables() });
        }
        if table.is_plain { Ok(self) } else { Err(KklExportError::Boxes) }
    }

    pub(crate) fn plant(&self) -> &ExpressionPlant {
        self.any().plant()
    }

    /// Lengths of its columns; the state is z.
    pub(crate) fn dimensions(&self) -> ObserverDimensions {
        self.any().dimensions()
    }

    /// Runge-Kutta steps between two samples.
    pub fn substeps(&self) -> usize {
        self.any().filter().3
    }

    /// Whether the left inverse is a search in a table.
    pub fn is_interpolated(&self) -> bool {
        self.table(Scalar::Binary64).is_some_and(|table| table.search.is_some())
    }

    pub(crate) fn period(&self) -> f64 {
        self.any().filter().2
    }

    /// Matrices of the filter and of the coordinates, the box of the estimates and the family of the inputs, with their
    /// names in emitted code.
    pub(crate) fn matrices(&self) -> Vec<(ExportedMatrix, DMatrix<f64>)> {
        let (d, b, ..) = self.any().filter();
        [(ExportedMatrix::Filter, d), (MatrixName::B.into(), b)]
            .into_iter()
            .chain(self.any().parts().matrices)
            .collect()
    }

    /// The trees: from (w, u) to the state, and from (x, u) to w where there is no table for that.
    pub(crate) fn trees(&self) -> Vec<(&'static str, Tree)> {
        self.any().parts().trees
    }

    /// The table of the interpolated form, as the format stores it.
    pub(crate) fn table(&self, scalar: Scalar) -> Option<TableOf> {
        let single = match scalar {
            Scalar::Binary32 => self.cast::<f32>().ok().and_then(|kkl| kkl.any().parts().table),
            Scalar::Binary64 => None,
        };
        single.or_else(|| self.any().parts().table)
    }

    /// The number of held inputs.
    pub(crate) fn held_inputs(&self) -> usize {
        self.any().first().len()
    }
}

/// Numbers of a table beyond which it is refused: 2 MiB in f64.
const MOST_NUMBERS: usize = 1 << 18;

impl<T: RealField + Copy> crate::cast::Stepper<T> for Kkl<T> {
    fn period(&self) -> T {
        self.any().filter().2
    }

    fn start(&self, estimate: &DVector<T>) -> DVector<T> {
        self.any().start(estimate)
    }

    fn step(&self, t: T, state: &mut DVector<T>, u: &DVector<T>, y: &DVector<T>) {
        self.any().step(t, state, u, y);
    }

    fn estimate(&self, state: &DVector<T>) -> DVector<T> {
        let order = state.len() - self.any().dimensions().estimate;
        state.rows_range(order..).into_owned()
    }
}

/// Its state is z with the estimate behind it.
impl<T: RealField + Copy> SampledObserver<T> for Kkl<T> {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;
    type Estimate = DVector<T>;

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.any().dimensions();
        ObserverDimensions { state: size.state + size.estimate, ..size }
    }

    fn period(&self) -> T {
        crate::cast::Stepper::period(self)
    }

    fn step(&self, t: T, state: &mut DVector<T>, u: &DVector<T>, y: &DVector<T>) {
        crate::cast::Stepper::step(self, t, state, u, y);
    }

    fn estimate(&self, state: &DVector<T>) -> DVector<T> {
        crate::cast::Stepper::estimate(self, state)
    }

    fn initial(&self, _t: T, estimate: &DVector<T>, _u: &DVector<T>, _y: &DVector<T>) -> DVector<T> {
        crate::cast::Stepper::start(self, estimate)
    }
}

/// Why there is no such observer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum KklExportError {
    /// A plant of other sizes.
    #[error(transparent)]
    Plant(#[from] ExpressionPlantError),
    /// Matrices that are refused.
    #[error(transparent)]
    Observer(#[from] ObserverError),
    /// A table that is too large.
    #[error(
        "{} has {numbers} numbers, {} bytes in f32 and {} in f64, more than the {MOST_NUMBERS} numbers that source code holds: fewer `points`{}, or form = \"embedded\"",
        if *.tables > 1 { format!("the table of the left inverse for {tables} combinations of inputs") } else { "the table of the interpolated left inverse".to_owned() },
        4 * .numbers,
        8 * .numbers,
        if *.tables > 1 { " or `nodes`" } else { "" }
    )]
    Large {
        /// Its numbers.
        numbers: usize,
        /// Combinations of inputs, one without inputs.
        tables: usize,
    },
    /// Parts of a left inverse for different boxes or grids.
    #[error(
        "the tables of the left inverse and the tree from which its search starts are for different boxes or grids"
    )]
    Boxes,
}

/// T as a table of splines, and the search in it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TableOf {
    pub(crate) points: Vec<usize>,
    pub(crate) outputs: usize,
    /// Of a table of low rank, the rows of the matrices of each axis.
    pub(crate) ranks: Vec<usize>,
    /// Of each held input, the values with a table.
    pub(crate) nodes: Vec<Vec<f64>>,
    /// Of all combinations of these values, the last input running fastest.
    pub(crate) coefficients: Vec<f64>,
    pub(crate) search: Option<Search<f64>>,
    /// Whether all parts have one box and one grid.
    is_plain: bool,
}

impl TableOf {
    /// Combinations of held inputs.
    pub(crate) fn tables(&self) -> usize {
        self.nodes.iter().map(Vec::len).product()
    }

    /// Columns of the matrices of an axis of a table of low rank.
    pub(crate) fn columns(&self, axis: usize) -> usize {
        self.ranks.get(axis + 1).copied().unwrap_or(1)
    }

    /// Operations of one evaluation with its Jacobian.
    pub(crate) fn operations(&self) -> usize {
        let (n, z) = (self.points.len(), self.outputs);
        if !self.ranks.is_empty() {
            // Of each entry value and slope, seven operations each, and two for the product and each derivative.
            let entries = |axis: usize| self.ranks[axis] * self.columns(axis);
            return 32 * n + (0..n).map(|axis| entries(axis) * (14 + 2 * (1 + n - axis))).sum::<usize>();
        }
        // Of each line along the last axis value and slope, the n products of its weights, and their part in the sums.
        let lines = 4_usize.pow(n as u32 - 1);
        let sums = 2 * z * (n + 1);
        let of_inputs = if self.nodes.is_empty() { 0 } else { sums };
        32 * n + self.tables() * (lines * (14 * z + n * n.saturating_sub(2) + sums) + of_inputs)
    }

    /// Operations of Lagrange's polynomials.
    pub(crate) fn weighing(&self) -> usize {
        4 * self.tables() * self.nodes.iter().map(|nodes| nodes.len() - 1).sum::<usize>()
    }

    /// Evaluations of a search at most: from the estimate of the tree, and from the best points of the coarse grid.
    pub(crate) fn evaluations(&self) -> usize {
        let restarts = luenberger_observers::numerical_kkl::least_squares::RESTARTS;
        match self.search {
            None => 0,
            Some(Search { max_evaluations, fallback: 0, .. }) => max_evaluations,
            Some(Search { max_evaluations, fallback, .. }) => {
                max_evaluations * (1 + restarts) + fallback.pow(self.points.len() as u32)
            }
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
    fn of<T, const I: usize, const O: usize>(tree: &PolynomialTree<T, Vec<Node<T>>, Vec<T>, I, O>) -> Self
    where
        T: RealField + Copy,
    {
        let node = |node: &Node<T>| {
            let Node { axis, ref threshold, below, above } = *node;
            Node { axis, threshold: number(threshold), below, above }
        };
        let (nodes, leaves) = (tree.nodes().iter().map(node).collect(), tree.leaves().iter().map(number).collect());
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
        // Nested Horner: the variables one after the other.
        let of_output =
            |variables| luenberger_observers::numerical_kkl::polynomial_tree::monomial_count(variables, self.degree);
        let multiply_adds = (1..=self.inputs).map(of_output).sum::<usize>();
        walk + 4 * self.inputs + self.outputs * (2 * multiply_adds + 2)
    }
}
