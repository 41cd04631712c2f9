//! Radau IIA of order 5, for stiff starts and stiff plants.
//!
//! Three implicit stages at `c = ((4 - sqrt 6)/10, (4 + sqrt 6)/10, 1)`, stiffly accurate and L-stable; simplified
//! Newton on the three stages together, in the coordinates in which `A^-1` is block diagonal; embedded error estimate
//! of order 3, filtered by `(gamma/h I - J)^-1`; dense output by the collocation polynomial. The Jacobian is formed by
//! differences at the start of every step, and kept where an attempt is rejected: the systems here have tens of states,
//! and a Jacobian that is never stale leaves nothing to tune.
//!
//! Source: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996, section IV.8.

use nalgebra::{Complex, DMatrix, DVector, Dyn, LU};

use crate::step::{Attempt, Tolerance};

/// sqrt 6
pub const R6: f64 = 2.449_489_742_783_178;
/// The nodes.
const C: [f64; 3] = [(4.0 - R6) / 10.0, (4.0 + R6) / 10.0, 1.0];
/// Weights of the stages in the error estimate.
const D: [f64; 3] = [-(13.0 + 7.0 * R6) / 3.0, (-13.0 + 7.0 * R6) / 3.0, -1.0 / 3.0];
/// The eigenvalues of A^-1 are gamma and alpha +- i beta.
pub const GAMMA: f64 = 3.637_834_252_744_496;
/// See [`GAMMA`].
pub const ALPHA: f64 = 2.681_082_873_627_752;
/// See [`GAMMA`].
pub const BETA: f64 = 3.050_430_199_247_410_6;
/// `T^-1 A^-1 T` is diag(gamma, [[alpha, -beta], [beta, alpha]]).
pub const T: [[f64; 3]; 3] = [
    [0.091_232_394_870_892_94, -0.141_255_295_020_954_2, -0.030_029_194_105_147_424],
    [0.241_717_932_707_107, 0.204_129_352_293_799_93, 0.382_942_112_757_261_9],
    [0.966_048_182_615_093, 1.0, 0.0],
];
/// The inverse of [`T`].
pub const T_INVERSE: [[f64; 3]; 3] = [
    [4.325_579_890_063_155, 0.339_199_251_815_809_9, 0.541_770_539_935_874_9],
    [-4.178_718_591_551_905, -0.327_682_820_761_062_4, 0.476_623_554_500_550_44],
    [-0.502_872_634_945_786_9, 2.571_926_949_855_605, -0.596_039_204_828_224_9],
];
/// Newton iterations per attempt.
const NEWTON: usize = 10;

/// `f(t, y)` into a column of the same length.
type RightHandSide<'f> = dyn Fn(f64, &[f64], &mut [f64]) + 'f;

/// Three columns, for the stages.
type Stages = [DVector<f64>; 3];

/// The state of a Radau integration. A step takes no memory but for the factorisations of Newton's matrices.
pub(crate) struct Radau {
    t: f64,
    y: DVector<f64>,
    h: f64,
    /// The last accepted step: its start, its size; the solution at its start and its three nodes.
    last: Option<(f64, f64)>,
    nodes: [DVector<f64>; 4],
    /// Size and error of the last accepted step, for the predictive controller.
    memory: Option<(f64, f64)>,
    rejected: bool,
    work: Work,
}

/// The columns of an attempt.
struct Work {
    /// Whether slope and Jacobian are those at y.
    is_at_start: bool,
    slope: DVector<f64>,
    jacobian: DMatrix<f64>,
    scale: DVector<f64>,
    scaled: DVector<f64>,
    z: Stages,
    slopes: Stages,
    /// Stages in the coordinates of the eigenvalues.
    turned: Stages,
    pair: DVector<Complex<f64>>,
    moved: DVector<f64>,
    error: DVector<f64>,
    shift: DVector<f64>,
}

/// The collocation polynomial of a step from t over h, at a time.
fn collocation(nodes: &[DVector<f64>; 4], (t, h): (f64, f64), time: f64, value: &mut DVector<f64>) {
    let s = (time - t) / h;
    let places = [0.0, C[0], C[1], C[2]];
    value.fill(0.0);
    for (i, node) in nodes.iter().enumerate() {
        let weight = (0..4).filter(|&j| j != i).map(|j| (s - places[j]) / (places[i] - places[j])).product();
        value.axpy(weight, node, 1.0);
    }
}

/// The matrices of Newton's method for a step of length h: `gamma/h I - J` and `(alpha + i beta)/h I - J`.
struct Newton {
    h: f64,
    real: LU<f64, Dyn, Dyn>,
    complex: LU<Complex<f64>, Dyn, Dyn>,
}

impl Newton {
    fn new(jacobian: &DMatrix<f64>, h: f64) -> Self {
        let n = jacobian.nrows();
        let mut real = -jacobian;
        let mut complex = real.map(|entry| Complex::new(entry, 0.0));
        for i in 0..n {
            real[(i, i)] += GAMMA / h;
            complex[(i, i)] += Complex::new(ALPHA, BETA) / h;
        }
        Self { h, real: real.lu(), complex: complex.lu() }
    }

    /// The correction of the stages z by their slopes, in their place: `(A^-1/h - J) dz = f - A^-1 z/h`, a block for
    /// each eigenvalue. False for singular matrices.
    fn correction(
        &self,
        slopes: &mut Stages,
        z: &Stages,
        turned: &mut Stages,
        pair: &mut DVector<Complex<f64>>,
    ) -> bool {
        for i in 0..pair.len() {
            let [f, w] = [&*slopes, z].map(|stages| T_INVERSE.map(|row| combined(row, stages, i)));
            turned[0][i] = f[0] - w[0] * (GAMMA / self.h);
            pair[i] = Complex::new(f[1], f[2]) - Complex::new(ALPHA, BETA) / self.h * Complex::new(w[1], w[2]);
        }
        if !(self.real.solve_mut(&mut turned[0]) && self.complex.solve_mut(pair)) {
            return false;
        }
        for i in 0..pair.len() {
            (turned[1][i], turned[2][i]) = (pair[i].re, pair[i].im);
            let corrected = T.map(|row| combined(row, turned, i));
            (0..3).for_each(|k| slopes[k][i] = corrected[k]);
        }
        true
    }
}

/// `sum_j m_j x_j` of the entries i.
fn combined(m: [f64; 3], x: &Stages, i: usize) -> f64 {
    x[0][i] * m[0] + x[1][i] * m[1] + x[2][i] * m[2]
}

impl Work {
    fn new(n: usize) -> Self {
        let column = || DVector::zeros(n);
        let stages = || std::array::from_fn(|_| DVector::zeros(n));
        Self {
            is_at_start: false,
            slope: column(),
            jacobian: DMatrix::zeros(n, n),
            scale: column(),
            scaled: column(),
            z: stages(),
            slopes: stages(),
            turned: stages(),
            pair: DVector::zeros(n),
            moved: column(),
            error: column(),
            shift: column(),
        }
    }

    /// Slope, and Jacobian by differences, at y; false if it is not finite.
    fn start(&mut self, f: &RightHandSide<'_>, t: f64, y: &DVector<f64>) -> bool {
        f(t, y.as_slice(), self.slope.as_mut_slice());
        self.moved.copy_from(y);
        for j in 0..y.len() {
            let delta = (f64::EPSILON * y[j].abs().max(1e-5)).sqrt();
            self.moved[j] = y[j] + delta;
            f(t, self.moved.as_slice(), self.scaled.as_mut_slice());
            for i in 0..y.len() {
                self.jacobian[(i, j)] = (self.scaled[i] - self.slope[i]) / (self.moved[j] - y[j]);
            }
            self.moved[j] = y[j];
        }
        self.is_at_start = true;
        self.jacobian.iter().all(|entry| entry.is_finite())
    }
}

/// The root mean square of a column, in units of the tolerance.
fn norm(v: &DVector<f64>, scale: &DVector<f64>, scaled: &mut DVector<f64>) -> f64 {
    scaled.copy_from(v);
    scaled.component_div_assign(scale);
    (scaled.norm_squared() / v.len() as f64).sqrt()
}

impl Radau {
    pub(crate) fn new(t: f64, y: &[f64], h: f64) -> Self {
        let n = y.len();
        Self {
            t,
            y: DVector::from_column_slice(y),
            h,
            last: None,
            nodes: std::array::from_fn(|_| DVector::zeros(n)),
            memory: None,
            rejected: false,
            work: Work::new(n),
        }
    }

    pub(crate) fn t(&self) -> f64 {
        self.t
    }

    pub(crate) fn y(&self) -> &[f64] {
        self.y.as_slice()
    }

    pub(crate) fn h(&self) -> f64 {
        self.h
    }

    pub(crate) fn set_h(&mut self, h: f64) {
        self.h = h;
    }

    /// The dense output of the last accepted step.
    pub(crate) fn interpolate(&self, t: f64, value: &mut [f64]) {
        let mut found = self.y.clone();
        if let Some(step) = self.last {
            collocation(&self.nodes, step, t, &mut found);
        }
        value.copy_from_slice(found.as_slice());
    }

    /// One attempt at a step of the present size.
    pub(crate) fn attempt(&mut self, f: &RightHandSide<'_>, tolerance: Tolerance) -> Attempt {
        let (t, h) = (self.t, self.h);
        let Self { y, nodes, work, last, .. } = self;
        // After a rejected attempt both stand at y still.
        if !work.is_at_start && !work.start(f, t, y) {
            work.is_at_start = false;
            return self.reject(0.5);
        }
        let Work { slope, jacobian, scale, scaled, z, slopes, turned, pair, moved, error, shift, .. } = work;
        for (scale, entry) in scale.iter_mut().zip(y.iter()) {
            *scale = tolerance.atol + tolerance.rtol * entry.abs();
        }
        let newton = Newton::new(jacobian, h);

        // Start: the last polynomial continued.
        for (i, z) in z.iter_mut().enumerate() {
            match last {
                Some(step) => {
                    collocation(nodes, *step, t + C[i] * h, z);
                    *z -= &*y;
                }
                None => z.fill(0.0),
            }
        }
        let mut converged = false;
        let (mut previous, mut rate) = (f64::INFINITY, 1.0);
        let mut iterations = 0;
        // Rounding in the stages limits how far Newton can go.
        let floor = 20.0 * f64::EPSILON * y.amax() / scale.min();
        for iteration in 0..NEWTON {
            iterations = iteration + 1;
            for (i, slope) in slopes.iter_mut().enumerate() {
                moved.copy_from(y);
                *moved += &z[i];
                f(t + C[i] * h, moved.as_slice(), slope.as_mut_slice());
            }
            if !newton.correction(slopes, z, turned, pair) {
                return self.reject(0.5);
            }
            let mut squared = 0.0;
            for (stage, part) in z.iter_mut().zip(&*slopes) {
                squared += norm(part, scale, scaled).powi(2);
                *stage += part;
            }
            let size = (squared / 3.0).sqrt();
            if !size.is_finite() {
                return self.reject(0.5);
            }
            if iteration > 0 {
                rate = size / previous;
            }
            if size == 0.0 || (iteration > 0 && rate < 1.0 && rate / (1.0 - rate) * size <= 1e-3) || size <= floor {
                converged = true;
                break;
            }
            if iteration > 0 && rate >= 1.0 {
                break;
            }
            previous = size;
        }
        if !converged {
            return self.reject(0.5);
        }

        for i in 0..y.len() {
            shift[i] = z[0][i] * (D[0] / h) + z[1][i] * (D[1] / h) + z[2][i] * (D[2] / h);
            error[i] = shift[i] + slope[i];
        }
        if !newton.real.solve_mut(error) {
            return self.reject(0.5);
        }
        let mut err = norm(error, scale, scaled);
        if err >= 1.0 && (last.is_none() || self.rejected) {
            // A stiff start: the estimate once more from the corrected point.
            moved.copy_from(y);
            *moved += &*error;
            f(t, moved.as_slice(), error.as_mut_slice());
            *error += &*shift;
            if !newton.real.solve_mut(error) {
                return self.reject(0.5);
            }
            err = norm(error, scale, scaled);
        }
        if !err.is_finite() {
            return self.reject(0.1);
        }
        let err = err.max(1e-10);
        let safety = 0.9 * (2 * NEWTON + 1) as f64 / (2 * NEWTON + iterations) as f64;
        let mut factor = safety / err.sqrt().sqrt();
        if err >= 1.0 {
            return self.reject(factor.clamp(0.1, 0.9));
        }
        if let Some((h_last, err_last)) = self.memory {
            factor = factor.min(0.9 * h / h_last * (err_last / (err * err)).sqrt().sqrt());
        }
        let mut factor = factor.clamp(0.2, 8.0);
        if self.rejected {
            factor = factor.min(1.0);
        }
        self.memory = Some((h, err.max(1e-2)));
        self.rejected = false;
        self.nodes[0].copy_from(&self.y);
        for (node, z) in self.nodes[1..].iter_mut().zip(&self.work.z) {
            node.copy_from(&self.y);
            *node += z;
        }
        self.y.copy_from(&self.nodes[3]);
        self.last = Some((t, h));
        self.work.is_at_start = false;
        self.t = t + h;
        self.h = h * factor;
        Attempt::Accepted
    }

    fn reject(&mut self, factor: f64) -> Attempt {
        self.h *= factor;
        self.rejected = true;
        Attempt::Rejected
    }
}
