//! KKL, [KKL+PEB] and high-gain observers over maps supplied by the user: constructors, sizes known at run time, states
//! taken apart.
#![cfg(feature = "alloc")]

use luenberger_observers::cascade::{Cascade, CascadeMap};
use luenberger_observers::estimator::gradient::Gradient;
use luenberger_observers::high_gain::{ChainPosition, HighGainMap, HighGainObserver};
use luenberger_observers::{
    KklMap, KklObserver, KklPebObserver, LeftInverse, LinearKkl, Observer, ObserverDimensions, ObserverError,
};
use luenberger_plants::{Plant, PlantError};
use nalgebra::{DMatrix, DVector, Dyn, Matrix1, Matrix2, SMatrix, SVector, U0, U1, U2, Vector1, Vector2, Vector3};
use proptest::prelude::*;

/// `xhat = V^-1 z` for the z of a linear plant, `V A = D V + B C`.
#[derive(Clone, Debug)]
struct Linear {
    v: DMatrix<f64>,
    inverse: DMatrix<f64>,
}

impl LeftInverse<f64, Dyn, Dyn, Dyn> for Linear {
    fn estimate_len(&self) -> usize {
        self.v.ncols()
    }
    fn left_inverse(&self, z: &DVector<f64>, _y: &DVector<f64>) -> DVector<f64> {
        &self.inverse * z
    }
    fn image(&self, xhat: &DVector<f64>, _y: &DVector<f64>) -> DVector<f64> {
        &self.v * xhat
    }
}

/// Luenberger's own: for the double integrator with `D = diag(-1, -2)`, `B = (1, 1)`, `V = [1 -1; 1/2 -1/4]` and the
/// error of z has the poles -1 and -2.
#[test]
fn a_linear_kkl_observer_of_dynamic_size() {
    let v = DMatrix::from_row_slice(2, 2, &[1.0, -1.0, 0.5, -0.25]);
    let inverse = v.clone().try_inverse().unwrap();
    let d = DMatrix::from_diagonal(&DVector::from_vec(vec![-1.0, -2.0]));
    let b = DMatrix::from_element(2, 1, 1.0);
    let plant = luenberger_plants::double_integrator().to_dynamic();
    // V B_plant: how the input enters.
    let e = &v * &plant.b;
    let map =
        LinearKkl::new(d.clone(), b.clone(), e.clone(), Linear { v: v.clone(), inverse: inverse.clone() }).unwrap();
    let observer = KklObserver::new(map);
    let dimensions = Observer::<f64>::dimensions(&observer);
    assert_eq!(dimensions, ObserverDimensions { state: 2, inputs: 1, outputs: 1, estimate: 2 });
    let (x, u) = (DVector::from_vec(vec![0.5, -0.75]), DVector::from_element(1, 0.25));
    let error = DVector::from_vec(vec![0.125, -2.0]);
    let z = &v * &x + &error;
    let y = plant.output(0.0, &x, &u);
    let rate = observer.derivative(0.0, &z, &u, &y) - &v * plant.derivative(0.0, &x, &u);
    // All numbers are dyadic: exact.
    assert_eq!(rate, &d * &error);
    assert!((observer.estimate(0.0, &(&v * &x), &u, &y) - &x).amax() <= 4.0 * f64::EPSILON);
    assert_eq!(observer.initial(0.0, &x, &u, &y), &v * &x);

    let refused = LinearKkl::<f64, Dyn, Dyn, Dyn, Dyn, _>::new(
        d.clone(),
        DMatrix::zeros(3, 1),
        e,
        Linear { v: v.clone(), inverse: inverse.clone() },
    );
    let expected = PlantError::DimensionMismatch { what: "B", expected: (2, 1), found: (3, 1) };
    assert_eq!(refused.err(), Some(ObserverError::Matrix(expected)));
    let refused =
        LinearKkl::<f64, Dyn, Dyn, Dyn, Dyn, _>::new(d * f64::NAN, b, DMatrix::zeros(2, 0), Linear { v, inverse });
    assert!(matches!(refused, Err(ObserverError::Matrix(PlantError::NotFinite { what: "D", .. }))));
}

/// A chain whose states stand where `places` says.
#[derive(Clone, Copy, Debug)]
struct Chain {
    places: [(usize, usize); 3],
}

impl HighGainMap<f64> for Chain {
    type Xi = nalgebra::U3;
    type Inputs = U0;
    type Outputs = U1;
    type Estimate = nalgebra::U3;
    fn place(&self, i: usize) -> ChainPosition {
        ChainPosition { output: self.places[i].0, position: self.places[i].1 }
    }
    fn drift(&self, _t: f64, xi: &Vector3<f64>, _u: &SVector<f64, 0>, _y: &Vector1<f64>) -> Vector3<f64> {
        Vector3::new(xi[1], xi[2], 0.0)
    }
    fn estimate(&self, _t: f64, xi: &Vector3<f64>, _u: &SVector<f64, 0>, _y: &Vector1<f64>) -> Vector3<f64> {
        *xi
    }
    fn start(&self, _t: f64, estimate: &Vector3<f64>, _u: &SVector<f64, 0>, _y: &Vector1<f64>) -> Vector3<f64> {
        *estimate
    }
}

/// `x1' = 2 x2`, `x2' = 0`.
#[derive(Debug)]
struct Doubled;

impl HighGainMap<f64> for Doubled {
    type Xi = U2;
    type Inputs = U0;
    type Outputs = U1;
    type Estimate = U2;
    fn place(&self, i: usize) -> ChainPosition {
        ChainPosition { output: 0, position: i + 1 }
    }
    fn drift(&self, _t: f64, xi: &Vector2<f64>, _u: &SVector<f64, 0>, _y: &Vector1<f64>) -> Vector2<f64> {
        Vector2::new(2.0 * xi[1], 0.0)
    }
    fn shape(&self, _t: f64, _u: &SVector<f64, 0>, _y: &Vector1<f64>) -> Vector2<f64> {
        Vector2::new(1.0, 0.5)
    }
    fn estimate(&self, _t: f64, xi: &Vector2<f64>, _u: &SVector<f64, 0>, _y: &Vector1<f64>) -> Vector2<f64> {
        *xi
    }
    fn start(&self, _t: f64, estimate: &Vector2<f64>, _u: &SVector<f64, 0>, _y: &Vector1<f64>) -> Vector2<f64> {
        *estimate
    }
}

/// A pure chain of three: the error matrix has the roots of `s^3 + a1 s^2 + a2 s + a3` divided by r; and chains that
/// are none.
#[test]
fn a_chain_of_three_has_its_poles() {
    let chain = Chain { places: [(0, 1), (0, 2), (0, 3)] };
    // (s + 1)^3, r = 1/4: (s + 4)^3.
    let observer = HighGainObserver::new(chain, Vector3::new(3.0, 3.0, 1.0), 0.25).unwrap();
    let column = |e: Vector3<f64>| observer.derivative(0.0, &e, &SVector::zeros(), &Vector1::zeros());
    let matrix =
        SMatrix::<f64, 3, 3>::from_columns(&[column(Vector3::x()), column(Vector3::y()), column(Vector3::z())]);
    let shifted = matrix + SMatrix::<f64, 3, 3>::identity() * 4.0;
    assert_eq!(shifted * shifted * shifted, SMatrix::<f64, 3, 3>::zeros());

    // x1' = 2 x2: the state that enters with the factor 2 gets the shape 1/2, and the poles are those of the pure
    // chain.
    let observer = HighGainObserver::new(Doubled, Vector2::new(2.0, 1.0), 0.25).unwrap();
    let column = |e: Vector2<f64>| observer.derivative(0.0, &e, &SVector::zeros(), &Vector1::zeros());
    let shifted = Matrix2::from_columns(&[column(Vector2::x()), column(Vector2::y())]) + Matrix2::identity() * 4.0;
    assert_eq!(shifted * shifted, Matrix2::zeros());

    let refused = |places| HighGainObserver::new(Chain { places }, Vector3::new(3.0, 3.0, 1.0), 0.25).unwrap_err();
    let expected = ObserverError::Chain { state: 1, output: 1, position: 1, heads: 1 };
    assert_eq!(refused([(0, 1), (1, 1), (0, 2)]), expected);
    assert_eq!(refused([(0, 1), (0, 1), (0, 2)]), ObserverError::Chain { state: 0, output: 0, position: 1, heads: 2 });
    assert_eq!(refused([(0, 2), (0, 1), (0, 0)]), ObserverError::Chain { state: 2, output: 0, position: 0, heads: 1 });
}

/// A cascade that measures its output k, with a block of no states.
#[derive(Clone, Copy, Debug)]
struct Short {
    k: usize,
}

impl Cascade<f64> for Short {
    type Second = U1;
    type Third = U0;
    type Fourth = U2;
    type Inputs = U0;
    type Outputs = U1;
    fn a2(&self) -> Matrix1<f64> {
        Matrix1::new(-1.0)
    }
    fn a3(&self) -> SMatrix<f64, 0, 0> {
        SMatrix::zeros()
    }
    fn k(&self) -> usize {
        self.k
    }
    fn f1k(&self, y: &Vector1<f64>, x2: &Vector1<f64>, _x3: &SVector<f64, 0>, _u: &SVector<f64, 0>) -> f64 {
        x2[0] - y[0]
    }
    fn f2(&self, y: &Vector1<f64>, _u: &SVector<f64, 0>) -> Vector1<f64> {
        *y
    }
    fn f3(&self, _y: &Vector1<f64>, _x2: &Vector1<f64>, _u: &SVector<f64, 0>) -> SVector<f64, 0> {
        SVector::zeros()
    }
    fn f4(&self, y: &Vector1<f64>, x2: &Vector1<f64>, _x3: &SVector<f64, 0>, _u: &SVector<f64, 0>) -> Vector2<f64> {
        Vector2::new(y[0], x2[0])
    }
    fn b(&self, y: &Vector1<f64>, _x2: &Vector1<f64>, _x3: &SVector<f64, 0>, _u: &SVector<f64, 0>) -> Vector2<f64> {
        Vector2::new(1.0, y[0])
    }
}

#[test]
fn a_cascade_is_put_together() {
    let map = CascadeMap::new::<f64>(Short { k: 0 }).unwrap();
    let (xi, u, y) = (Vector3::new(2.0, 3.0, 5.0), SVector::<f64, 0>::zeros(), Vector1::new(7.0));
    // (-x2 + y, y, x2); g = x2 - y + (1, y)(3, 5)'; m = (1, y).
    assert_eq!(map.slope(0.0, &xi, &u, &y), Vector3::new(5.0, 7.0, 2.0));
    let observer = KklPebObserver::new(map, Gradient::new(Matrix2::identity()).unwrap(), 1.0).unwrap();
    assert_eq!(observer.dimensions().state, 3 + 4 + 2);
    let slope = observer.derivative(0.0, &SVector::from([2.0, 3.0, 5.0, 7.0, 0.0, 0.0, 0.0, 0.0, 0.0]), &u, &y);
    assert_eq!(slope.as_slice(), [5.0, 7.0, 2.0, 0.0, 33.0, 1.0, 7.0, 0.0, 0.0]);
    assert_eq!(CascadeMap::new::<f64>(Short { k: 1 }).err(), Some(ObserverError::Output { output: 1, outputs: 1 }));
}

proptest! {
    /// Proposition 1 for constant matrices: with phi = V x and y = x, `B = V A - D V` and `E = V B_plant` solve (4) for
    /// every V and D, and the error of z obeys D.
    #[test]
    fn the_error_of_a_linear_kkl_observer_obeys_its_matrix(entries in prop::collection::vec(-2.0..2.0f64, 3 * 9 + 3 * 3)) {
        let matrix = |k: usize| DMatrix::from_column_slice(3, 3, &entries[9 * k..9 * (k + 1)]);
        let column = |k: usize| DVector::from_column_slice(&entries[27 + 3 * k..30 + 3 * k]);
        let (a, d, v) = (matrix(0), matrix(1), matrix(2) + DMatrix::identity(3, 3) * 8.0);
        let (x, error, input) = (column(0), column(1), column(2));
        let inverse = v.clone().try_inverse().unwrap();
        let e = DMatrix::from_columns(&[&v * &input]);
        let map = LinearKkl::new(d.clone(), &v * &a - &d * &v, e, Linear { v: v.clone(), inverse }).unwrap();
        let u = DVector::from_element(1, 0.5);
        let rate = KklObserver::new(map).derivative(0.0, &(&v * &x + &error), &u, &x) - &v * (a * x + input * u[0]);
        // Entries of V up to 10, of V A x up to 400.
        prop_assert!((rate - d * error).amax() <= 64.0 * f64::EPSILON * 1000.0);
    }
}
