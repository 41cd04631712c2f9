//! Largest singular value of a frequency response `C (z I - A)^-1 B + D`, in balanced units of the state, from one
//! Schur form.
//!
//! Units of the single outputs and inputs belong to the norm; those of the states, a factor common to all inputs and
//! one common to all outputs do not, and are chosen here as powers of two, such that A is balanced and B and C have
//! norms of about one. With `A = Q T Q'` each frequency takes one substitution with the quasi-triangular T, `O(n^2)`
//! for each input. Near `z = 1` and `z = -1` the differences `z - t_kk` are formed as `(z -+ 1) - (t_kk -+ 1)`, so that
//! a pole that is much nearer to the point than one keeps its digits.

use nalgebra::{Complex, DMatrix};

use crate::argument::unit_scale;
use crate::balance::are_near;
use crate::rosenbrock::Rosenbrock;
use crate::schur::blocks;
use crate::units::shift;
use crate::{Result, schur};

/// A system `(T, Q'B, C Q, D)` in these units.
pub(crate) struct FrequencyResponse {
    pub(crate) t: DMatrix<f64>,
    pub(crate) b: DMatrix<f64>,
    pub(crate) c: DMatrix<f64>,
    pub(crate) d: DMatrix<f64>,
    pub(crate) poles: Vec<Complex<f64>>,
    blocks: Vec<(usize, usize)>,
    /// The unit of time: a frequency here is `2^-time` times the one given. Zero in discrete time.
    pub(crate) time: i32,
    /// The norm given is `2^gain` times the one here.
    pub(crate) gain: i32,
}

impl FrequencyResponse {
    /// Of a plant with at least one state.
    pub(crate) fn new(
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
        c: &DMatrix<f64>,
        d: &DMatrix<f64>,
        discrete: bool,
    ) -> Result<Self> {
        let power = |m: &DMatrix<f64>| unit_scale(m).log2() as i32;
        let scaled = |m: &DMatrix<f64>, power: i32| m.map(|x| shift(x, power));
        // Entries near to each other, whose products stay in range.
        let is_plain = |m: &DMatrix<f64>| are_near(m.iter()) && power(m).abs() < 300;
        let (time, form, b, c) = if [a, b, c, d].into_iter().all(is_plain) {
            // There is nothing to balance but time.
            let time = if discrete { 0 } else { -power(a) };
            (time, schur(&scaled(a, -time))?, scaled(b, -time), c.clone())
        } else {
            let units = Rosenbrock::new(a, b, c, d)?;
            let time = if discrete { 0 } else { units.time() };
            (time, schur(&units.dynamics_of(a, time))?, units.driven_of(b, time), units.seen_of(c))
        };
        let (of_b, of_c) = (power(&b), power(&c));
        let (b, c, d) = (scaled(&b, of_b), scaled(&c, of_c), scaled(d, of_b + of_c));
        Ok(Self {
            poles: form.eigenvalues(),
            blocks: blocks(&form.t),
            b: form.q.tr_mul(&b),
            c: c * &form.q,
            d,
            t: form.t,
            time,
            gain: -of_b - of_c,
        })
    }

    /// The largest singular value at `z = origin + offset`; infinite at a pole.
    pub(crate) fn at(&self, origin: f64, offset: Complex<f64>) -> f64 {
        let mut states = self.b.map(Complex::from);
        let t = &self.t;
        let shifted = |k: usize| offset - (t[(k, k)] - origin);
        for mut x in states.column_iter_mut() {
            for &(k, size) in self.blocks.iter().rev() {
                if size == 1 {
                    x[k] /= shifted(k);
                } else {
                    let (p, q, r, s) = (shifted(k), -t[(k, k + 1)], -t[(k + 1, k)], shifted(k + 1));
                    let determinant = p * s - q * r;
                    let (first, second) = (x[k], x[k + 1]);
                    x[k] = (s * first - second * q) / determinant;
                    x[k + 1] = (p * second - first * r) / determinant;
                }
                for j in k..k + size {
                    let known = x[j];
                    for i in 0..k {
                        x[i] += known * t[(i, j)];
                    }
                }
            }
        }
        let response = self.c.map(Complex::from) * states + self.d.map(Complex::from);
        if response.iter().any(|z| !(z.re.is_finite() && z.im.is_finite())) {
            return f64::INFINITY;
        }
        largest(&response)
    }
}

/// The largest singular value.
pub(crate) fn largest(m: &DMatrix<Complex<f64>>) -> f64 {
    match m.shape() {
        (0, _) | (_, 0) => 0.0,
        // Without squares that under- or overflow.
        (1, _) | (_, 1) => m.iter().fold(0.0, |norm: f64, z| norm.hypot(z.norm())),
        _ => m.clone().svd(false, false).singular_values.max(),
    }
}
