//! Radau IIA of order 5, for stiff starts and stiff plants.
//!
//! Three implicit stages at `c = ((4 - sqrt 6)/10, (4 + sqrt 6)/10, 1)`, stiffly accurate and L-stable; simplified
//! Newton on the three stages together, in the coordinates in which `A^-1` is block diagonal; embedded error estimate
//! of order 3, filtered by `(gamma/h I - J)^-1`; dense output by the collocation polynomial. The Jacobian is formed by
//! differences in every step: the systems here have tens of states, and a Jacobian that is never stale leaves nothing
//! to tune.
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

/// The state of a Radau integration.
pub(crate) struct Radau {
    t: f64,
    y: DVector<f64>,
    h: f64,
    /// The last accepted step: its start, its size, and the solution at its start and its three nodes.
    last: Option<Step>,
    /// Size and error of the last accepted step, for the predictive controller.
    memory: Option<(f64, f64)>,
    rejected: bool,
}

struct Step {
    t: f64,
    h: f64,
    nodes: [DVector<f64>; 4],
}

impl Step {
    /// The collocation polynomial.
    fn at(&self, t: f64) -> DVector<f64> {
        let s = (t - self.t) / self.h;
        let nodes = [0.0, C[0], C[1], C[2]];
        let mut value = DVector::zeros(self.nodes[0].len());
        for (i, node) in self.nodes.iter().enumerate() {
            let weight = (0..4).filter(|&j| j != i).map(|j| (s - nodes[j]) / (nodes[i] - nodes[j])).product();
            value.axpy(weight, node, 1.0);
        }
        value
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

    /// The correction of the stages z by their slopes: `(A^-1/h - J) dz = f - A^-1 z/h`, a block for each eigenvalue.
    /// None for singular matrices.
    fn correction(&self, slopes: &[DVector<f64>; 3], z: &[DVector<f64>; 3]) -> Option<[DVector<f64>; 3]> {
        let [f, w] = [slopes, z].map(|stages| combined(&T_INVERSE, stages));
        let mut first = &f[0] - &w[0] * (GAMMA / self.h);
        let mut pair = DVector::from_fn(first.len(), |i, _| {
            Complex::new(f[1][i], f[2][i]) - Complex::new(ALPHA, BETA) / self.h * Complex::new(w[1][i], w[2][i])
        });
        (self.real.solve_mut(&mut first) && self.complex.solve_mut(&mut pair))
            .then(|| combined(&T, &[first, pair.map(|entry| entry.re), pair.map(|entry| entry.im)]))
    }
}

/// `sum_j m_ij x_j` for each i.
fn combined(m: &[[f64; 3]; 3], x: &[DVector<f64>; 3]) -> [DVector<f64>; 3] {
    m.map(|row| &x[0] * row[0] + &x[1] * row[1] + &x[2] * row[2])
}

impl Radau {
    pub(crate) fn new(t: f64, y: &[f64], h: f64) -> Self {
        Self { t, y: DVector::from_column_slice(y), h, last: None, memory: None, rejected: false }
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
        match &self.last {
            Some(step) => value.copy_from_slice(step.at(t).as_slice()),
            None => value.copy_from_slice(self.y.as_slice()),
        }
    }

    /// One attempt at a step of the present size.
    pub(crate) fn attempt(&mut self, f: &RightHandSide<'_>, tolerance: Tolerance) -> Attempt {
        let n = self.y.len();
        let (t, h) = (self.t, self.h);
        let eval = |t: f64, y: &DVector<f64>| {
            let mut slope = DVector::zeros(n);
            f(t, y.as_slice(), slope.as_mut_slice());
            slope
        };
        let scale = self.y.map(|entry| tolerance.atol + tolerance.rtol * entry.abs());
        let norm = |v: &DVector<f64>| (v.component_div(&scale).norm_squared() / n as f64).sqrt();

        let slope = eval(t, &self.y);
        let mut jacobian = DMatrix::zeros(n, n);
        let mut moved = self.y.clone();
        for j in 0..n {
            let delta = (f64::EPSILON * self.y[j].abs().max(1e-5)).sqrt();
            moved[j] = self.y[j] + delta;
            let column = (eval(t, &moved) - &slope) / (moved[j] - self.y[j]);
            jacobian.set_column(j, &column);
            moved[j] = self.y[j];
        }
        if !jacobian.iter().all(|entry| entry.is_finite()) {
            return self.reject(0.5);
        }
        let newton = Newton::new(&jacobian, h);

        // Start: the last polynomial continued.
        let mut z: [DVector<f64>; 3] = std::array::from_fn(|i| match &self.last {
            Some(step) => step.at(t + C[i] * h) - &self.y,
            None => DVector::zeros(n),
        });
        let mut converged = false;
        let (mut previous, mut rate) = (f64::INFINITY, 1.0);
        let mut iterations = 0;
        // Rounding in the stages limits how far Newton can go.
        let floor = 20.0 * f64::EPSILON * self.y.amax() / scale.min();
        for iteration in 0..NEWTON {
            iterations = iteration + 1;
            let slopes: [DVector<f64>; 3] = std::array::from_fn(|i| eval(t + C[i] * h, &(&self.y + &z[i])));
            let Some(correction) = newton.correction(&slopes, &z) else { return self.reject(0.5) };
            let mut squared = 0.0;
            for (stage, part) in z.iter_mut().zip(&correction) {
                squared += norm(part).powi(2);
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

        let mut estimate = z[0].clone() * (D[0] / h) + &z[1] * (D[1] / h) + &z[2] * (D[2] / h);
        let shift = estimate.clone();
        estimate += &slope;
        let Some(mut error) = newton.real.solve(&estimate) else { return self.reject(0.5) };
        let mut err = norm(&error);
        if err >= 1.0 && (self.last.is_none() || self.rejected) {
            // A stiff start: the estimate once more from the corrected point.
            let Some(refined) = newton.real.solve(&(eval(t, &(&self.y + &error)) + shift)) else {
                return self.reject(0.5);
            };
            error = refined;
            err = norm(&error);
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
        let end = &self.y + &z[2];
        let [z1, z2, _] = z;
        self.last = Some(Step { t, h, nodes: [self.y.clone(), &self.y + z1, &self.y + z2, end.clone()] });
        self.t = t + h;
        self.y = end;
        self.h = h * factor;
        Attempt::Accepted
    }

    fn reject(&mut self, factor: f64) -> Attempt {
        self.h *= factor;
        self.rejected = true;
        Attempt::Rejected
    }
}
