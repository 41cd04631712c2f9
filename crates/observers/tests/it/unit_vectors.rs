//! Filters of unit vectors: against the multiplicative filter of an attitude in coordinates of its rotation error, the
//! polar angle of a direction in the plane, and on bad numbers.

#![cfg(feature = "dual")]

use luenberger_observers::{
    ExtendedKalmanFilter, GaussianEstimate, NoiseModel, ObserverError, SampledObserver, StaticExtendedKalmanFilter,
};
use luenberger_plants::{ByDual, Column, Dimensions, Plant, Shape, plant};
use nalgebra::{
    Const, DMatrix, DVector, Dyn, Matrix1, Matrix2, Matrix3, Matrix6, RealField, SMatrix, SVector, Vector1, Vector2,
    Vector3, convert,
};

const H: f64 = 0.05;

type State = SVector<f64, 7>;

/// The product of two quaternions, scalar first.
fn product<T: RealField + Copy>(a: [T; 4], b: [T; 4]) -> [T; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// A direction of the world, seen by the body.
fn seen<T: RealField + Copy>(q: [T; 4], world: [f64; 3]) -> [T; 3] {
    let conjugate = [q[0], -q[1], -q[2], -q[3]];
    let world = world.map(convert::<f64, T>);
    let found = product(product(conjugate, [T::zero(), world[0], world[1], world[2]]), q);
    [found[1], found[2], found[3]]
}

const DOWN: [f64; 3] = [0.0, 0.0, 1.0];
const NORTH: [f64; 3] = [0.8, 0.0, 0.6];

/// An attitude and the biases of three gyroscopes, whose readings are the input, from sample to sample.
#[derive(Clone, Debug)]
struct Attitude;

fn turned<T: RealField + Copy>(x: &[T], u: &[T]) -> [T; 7] {
    let phi = [0, 1, 2].map(|i| (u[i] - x[4 + i]) * convert::<f64, T>(H));
    let angle = (phi[0] * phi[0] + phi[1] * phi[1] + phi[2] * phi[2]).sqrt();
    let half = angle * convert::<f64, T>(0.5);
    let [c, s] = [half.cos(), half.sin() / angle];
    let q = product([x[0], x[1], x[2], x[3]], [c, s * phi[0], s * phi[1], s * phi[2]]);
    [q[0], q[1], q[2], q[3], x[4], x[5], x[6]]
}

fn directions<T: RealField + Copy>(x: &[T]) -> [T; 6] {
    let q = [x[0], x[1], x[2], x[3]];
    let (down, north) = (seen(q, DOWN), seen(q, NORTH));
    [down[0], down[1], down[2], north[0], north[1], north[2]]
}

impl Shape for Attitude {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: 7, inputs: 3, outputs: 6 }
    }
}

impl ByDual for Attitude {}

impl<T: RealField + Copy> Plant<T> for Attitude {
    type State = SVector<T, 7>;
    type Input = SVector<T, 3>;
    type Output = SVector<T, 6>;

    fn derivative(&self, _t: T, x: &SVector<T, 7>, u: &SVector<T, 3>) -> SVector<T, 7> {
        SVector::from(turned(x.as_slice(), u.as_slice()))
    }

    fn output(&self, _t: T, x: &SVector<T, 7>, _u: &SVector<T, 3>) -> SVector<T, 6> {
        SVector::from(directions(x.as_slice()))
    }
}

/// The same with sizes known at run time.
#[derive(Clone, Debug)]
struct DynamicAttitude;

impl Shape for DynamicAttitude {
    fn dimensions(&self) -> Dimensions {
        Attitude.dimensions()
    }
}

impl ByDual for DynamicAttitude {}

impl<T: RealField + Copy> Plant<T> for DynamicAttitude {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;

    fn derivative(&self, _t: T, x: &DVector<T>, u: &DVector<T>) -> DVector<T> {
        DVector::from_column_slice(&turned(x.as_slice(), u.as_slice()))
    }

    fn output(&self, _t: T, x: &DVector<T>, _u: &DVector<T>) -> DVector<T> {
        DVector::from_column_slice(&directions(x.as_slice()))
    }
}

fn cross(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v[2], v[1], v[2], 0.0, -v[0], -v[1], v[0], 0.0)
}

/// The multiplicative filter: attitude, biases, and the covariance of the rotation error d (q (x) (1, d/2)) and of the
/// biases.
struct Multiplicative {
    q: [f64; 4],
    b: Vector3<f64>,
    p: Matrix6<f64>,
    w: Matrix6<f64>,
    v: f64,
}

impl Multiplicative {
    fn update(&mut self, y: &SVector<f64, 6>) {
        // y + [y]x d for a direction y that the body sees.
        let mut h = SMatrix::<f64, 6, 6>::zeros();
        let mut error = *y;
        for (k, world) in [DOWN, NORTH].into_iter().enumerate() {
            let expected = Vector3::from(seen(self.q, world));
            h.fixed_view_mut::<3, 3>(3 * k, 0).copy_from(&cross(&expected));
            let mut part = error.fixed_rows_mut::<3>(3 * k);
            part -= expected;
        }
        let s = h * self.p * h.transpose() + Matrix6::identity() * self.v;
        let gain = self.p * h.transpose() * s.try_inverse().unwrap();
        let found = gain * error;
        let keep = Matrix6::identity() - gain * h;
        self.p = keep * self.p * keep.transpose() + gain * gain.transpose() * self.v;
        let d = Vector3::new(found[0], found[1], found[2]);
        let q = product(self.q, [1.0, 0.5 * d[0], 0.5 * d[1], 0.5 * d[2]]);
        let square = 1.0 + 0.25 * d.norm_squared();
        self.q = q.map(|entry| entry / square.sqrt());
        self.b += found.fixed_rows::<3>(3);
        // d = 0 from here on.
        let mut reset = Matrix6::identity();
        reset.fixed_view_mut::<3, 3>(0, 0).copy_from(&((Matrix3::identity() - 0.5 * cross(&d)) / square));
        self.p = reset * self.p * reset.transpose();
    }

    fn predict(&mut self, u: &Vector3<f64>) {
        let phi = (u - self.b) * H;
        let angle = phi.norm();
        let axis = cross(&phi);
        let half = 0.5 * angle;
        let s = half.sin() / angle;
        self.q = product(self.q, [half.cos(), s * phi[0], s * phi[1], s * phi[2]]);
        // Rodrigues' formula for the inverse rotation, and the right Jacobian of the exponential.
        let (one, two) = ((1.0 - angle.cos()) / angle.powi(2), (angle - angle.sin()) / angle.powi(3));
        let back = Matrix3::identity() - angle.sin() / angle * axis + one * axis * axis;
        let right = Matrix3::identity() - one * axis + two * axis * axis;
        let mut f = Matrix6::identity();
        f.fixed_view_mut::<3, 3>(0, 0).copy_from(&back);
        f.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-H * right));
        self.p = f * self.p * f.transpose() + self.w;
    }
}

/// `Dq/Dd` for the rotation error d, and the identity for the biases.
fn tangent(q: [f64; 4]) -> SMatrix<f64, 7, 6> {
    let mut g = SMatrix::<f64, 7, 6>::zeros();
    for j in 0..3 {
        let mut d = [0.0; 4];
        d[1 + j] = 0.5;
        for (i, entry) in product(q, d).into_iter().enumerate() {
            g[(i, j)] = entry;
        }
        g[(4 + j, 3 + j)] = 1.0;
    }
    g
}

fn noises() -> NoiseModel<f64, Const<7>, Const<6>> {
    let diagonal = |attitude: f64, bias: f64| {
        SMatrix::<f64, 7, 7>::from_diagonal(&SVector::from([attitude, attitude, attitude, attitude, bias, bias, bias]))
    };
    NoiseModel { w: diagonal(0.25e-4, 1e-8), v: Matrix6::identity() * 4e-4, p0: diagonal(0.25 * 0.09, 1e-3) }
}

const UNIT: [f64; 7] = [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0];

/// The reading of the gyroscopes at sample k, and what is measured there, of a body that turns; numbers of a plain
/// recurrence in place of noise.
fn sample(k: usize, q: &mut [f64; 4], noise: &mut u64) -> (Vector3<f64>, SVector<f64, 6>) {
    let mut next = || {
        *noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*noise >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let t = k as f64 * H;
    let rate = Vector3::new((0.7 * t).sin(), 0.8 * (0.4 * t).cos(), 0.5);
    let y = SVector::from(directions(q.as_slice())).map(|entry: f64| entry + 0.06 * next());
    let x = turned(&[q[0], q[1], q[2], q[3], 0.0, 0.0, 0.0], rate.as_slice());
    q.copy_from_slice(&x[..4]);
    (rate + Vector3::new(0.05, -0.03, 0.02), y)
}

#[test]
fn it_is_the_multiplicative_filter_of_an_attitude() {
    let filter = ExtendedKalmanFilter::discrete(Attitude, noises(), H).unwrap();
    let filter = filter.with_unit_vectors(SVector::from(UNIT)).unwrap();
    let start: [f64; 4] = [0.9, 0.3, -0.3, 0.1];
    let length = start.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
    let first = State::from([start[0], start[1], start[2], start[3], 0.0, 0.0, 0.0]);
    let w = Matrix6::from_diagonal(&SVector::from([1e-4, 1e-4, 1e-4, 1e-8, 1e-8, 1e-8]));
    let p = Matrix6::from_diagonal(&SVector::from([0.09, 0.09, 0.09, 1e-3, 1e-3, 1e-3]));
    // The start has a norm of its own, by which its covariance is scaled.
    let p = Matrix6::from_fn(|i, j| p[(i, j)] / if i < 3 { length * length } else { 1.0 });
    let mut oracle = Multiplicative { q: start.map(|entry| entry / length), b: Vector3::zeros(), p, w, v: 4e-4 };
    let (mut q, mut noise) = ([1.0, 0.0, 0.0, 0.0], 7);
    let (u, y) = sample(0, &mut q.clone(), &mut noise.clone());
    let mut state = filter.initial(0.0, &first, &u, &y);
    for k in 0..400 {
        let (u, y) = sample(k, &mut q, &mut noise);
        filter.update(0.0, &mut state, &u, &y).unwrap();
        oracle.update(&y);
        let (x, p) = (state.estimate(), state.covariance());
        let [q0, q1, q2, q3] = oracle.q;
        let expected = State::from([q0, q1, q2, q3, oracle.b[0], oracle.b[1], oracle.b[2]]);
        assert!((x - expected).norm() < 1e-12, "sample {k}: {x} for {expected}");
        let g = tangent(oracle.q);
        let difference = p - g * oracle.p * g.transpose();
        assert!(difference.norm() < 1e-12 * p.norm(), "sample {k}: {difference}");
        assert!(filter.predict(0.0, &mut state, &u, H));
        oracle.predict(&u);
    }
    // The biases, by which the readings above are off.
    let x = state.estimate();
    let bias = Vector3::new(x[4], x[5], x[6]) - Vector3::new(0.05, -0.03, 0.02);
    assert!(bias.norm() < 0.01, "{bias}");
}

/// A filter without unit vectors counts what cannot be: the norm of its quaternion moves, and it is less accurate.
#[test]
fn without_unit_vectors_the_norm_moves() {
    let plain = ExtendedKalmanFilter::discrete(Attitude, noises(), H).unwrap();
    let unit = plain.clone().with_unit_vectors(SVector::from(UNIT)).unwrap();
    let first = State::from([0.8, 0.4, -0.4, 0.2, 0.0, 0.0, 0.0]);
    let run = |filter: &StaticExtendedKalmanFilter<Attitude, f64, 7, 3, 6>| {
        let (mut q, mut noise) = ([1.0, 0.0, 0.0, 0.0], 7);
        let (u, y) = sample(0, &mut q.clone(), &mut noise.clone());
        let mut state = filter.initial(0.0, &first, &u, &y);
        let mut norms = Vec::new();
        for k in 0..100 {
            let (u, y) = sample(k, &mut q, &mut noise);
            filter.update(0.0, &mut state, &u, &y).unwrap();
            norms.push((state.estimate().fixed_rows::<4>(0).norm() - 1.0).abs());
            assert!(filter.predict(0.0, &mut state, &u, H));
        }
        norms.into_iter().fold(0.0, f64::max)
    };
    assert!(run(&unit) < 1e-15, "{}", run(&unit));
    assert!(run(&plain) > 1e-3, "{}", run(&plain));
}

/// Sizes known at run time have the same bits.
#[test]
fn sizes_at_run_time_have_the_same_bits() {
    let fixed = ExtendedKalmanFilter::discrete(Attitude, noises(), H).unwrap();
    let fixed = fixed.with_unit_vectors(SVector::from(UNIT)).unwrap();
    let of = |matrix: &[f64], n: usize| DMatrix::from_column_slice(n, n, matrix);
    let NoiseModel { w, v, p0 } = noises();
    let dynamic = NoiseModel { w: of(w.as_slice(), 7), v: of(v.as_slice(), 6), p0: of(p0.as_slice(), 7) };
    let dynamic: ExtendedKalmanFilter<_, f64, Dyn, Dyn, Dyn> =
        ExtendedKalmanFilter::discrete(DynamicAttitude, dynamic, H).unwrap();
    let dynamic = dynamic.with_unit_vectors(DVector::from_column_slice(&UNIT)).unwrap();
    let first = State::from([0.9, 0.3, -0.3, 0.1, 0.0, 0.0, 0.0]);
    let (mut q, mut noise) = ([1.0, 0.0, 0.0, 0.0], 3);
    let (u, y) = sample(0, &mut q.clone(), &mut noise.clone());
    let mut state = fixed.initial(0.0, &first, &u, &y);
    let mut column = state.as_slice().to_vec();
    for k in 0..50 {
        let (u, y) = sample(k, &mut q, &mut noise);
        fixed.step(0.0, &mut state, &u, &y);
        assert!(dynamic.step_into(0.0, &mut column, u.as_slice(), y.as_slice(), &[]));
        assert_eq!(state.as_slice(), column.as_slice(), "sample {k}");
    }
}

/// Cosine and sine of an angle at rest, of which the sine is measured.
#[derive(Clone, Debug)]
struct Rest;

plant!(Rest, (2, 0, 1), |plant, _t, x, u| [x[0], x[1]], [x[1]]);

/// By hand: at (1, 0) the angle a has the variance 1, `sin a ~ a` is measured as 0.5 with the variance 1/3: the update
/// of the angle is 0.75 of that, (1, 0.375) divided by its norm, and the variance 0.25 of a along (-sin, cos) times
/// `1/norm^4`, of the two derivatives by which a tangent at (1, 0) becomes one at the end.
#[test]
fn a_direction_in_the_plane_by_hand() {
    let noises = NoiseModel { w: Matrix2::zeros(), v: Matrix1::new(1.0 / 3.0), p0: Matrix2::identity() };
    let filter = StaticExtendedKalmanFilter::<_, f64, 2, 0, 1>::discrete(Rest, noises, 1.0).unwrap();
    let filter = filter.with_unit_vectors(Vector2::new(1.0, 1.0)).unwrap();
    let (u, y) = (SVector::zeros(), Vector1::new(0.5));
    let state = filter.initial(0.0, &Vector2::new(2.0, 0.0), &u, &y);
    assert_eq!(state.as_slice(), [1.0, 0.0, 0.0, 0.0, 0.0, 0.25]);
    let mut state = filter.initial(0.0, &Vector2::new(1.0, 0.0), &u, &y);
    assert_eq!(state.as_slice(), [1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    filter.update(0.0, &mut state, &u, &y).unwrap();
    let square: f64 = 1.0 + 0.375 * 0.375;
    let expected = Vector2::new(1.0, 0.375) / square.sqrt();
    assert!((state.estimate() - expected).norm() < 1e-15);
    let along = Vector2::new(-expected[1], expected[0]);
    let variance = 0.25 / (square * square);
    assert!((state.covariance() - along * along.transpose() * variance).norm() < 1e-15, "{}", state.covariance());
}

#[test]
fn what_is_no_number_of_a_vector_is_refused() {
    let noises = || NoiseModel { w: Matrix3::zeros(), v: Matrix1::new(1.0), p0: Matrix3::identity() };
    plant!(Three, (3, 0, 1), |plant, _t, x, u| [x[0], x[1], x[2]], [x[0]]);
    #[derive(Clone, Debug)]
    struct Three;
    let filter = |numbers: [f64; 3]| -> Result<StaticExtendedKalmanFilter<Three, f64, 3, 0, 1>, ObserverError> {
        StaticExtendedKalmanFilter::discrete(Three, noises(), 1.0)?.with_unit_vectors(SVector::from(numbers))
    };
    for wrong in [[1.0, -1.0, 0.0], [1.0, 0.5, 0.0], [1.0, 3.0, 3.0], [2.0, 2.0, 0.0], [f64::NAN, 1.0, 1.0]] {
        let error = filter(wrong).unwrap_err();
        assert!(matches!(error, ObserverError::NotPositive { what: "the number of a unit vector", .. }), "{error:?}");
    }
    assert!(filter([0.0, 0.0, 0.0]).unwrap().unit_vectors().is_none());
    assert_eq!(filter([2.0, 1.0, 1.0]).unwrap().unit_vectors().unwrap().as_slice(), [2.0, 1.0, 1.0]);
    // A vector that is 0 has no direction.
    let filter = filter([1.0, 1.0, 0.0]).unwrap();
    let (u, y) = (SVector::zeros(), Vector1::new(0.5));
    let zero = filter.initial(0.0, &Vector3::zeros(), &u, &y);
    assert_eq!(zero.estimate().as_slice(), [0.0, 0.0, 0.0]);
    let tiny: GaussianEstimate<f64, Const<3>> = filter.initial(0.0, &Vector3::new(1e-170, 0.0, 0.0), &u, &y);
    assert_eq!(tiny.estimate()[0], 1e-170);
}
