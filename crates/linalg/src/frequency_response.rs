//! Frequency response `C (z I - A)^-1 B + D` at `z = jw`, in discrete time at `z = e^{jw}`, in balanced units of the
//! state, from one Schur form.
//!
//! Units of the single outputs and inputs belong to the response; those of the states, a factor common to all inputs
//! and one common to all outputs do not, and are chosen here as powers of two, such that A is balanced and B and C have
//! norms of about one. With `A = Q T Q'` each frequency takes one substitution with the quasi-triangular T, `O(n^2)`
//! for each input. Near `z = 1` and `z = -1` the differences `z - t_kk` are formed as `(z -+ 1) - (t_kk -+ 1)`, so that
//! a pole that is much nearer to the point than one keeps its digits.

use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

use crate::argument::unit_scale;
use crate::balance::are_near;
use crate::rosenbrock::Rosenbrock;
use crate::schur::blocks;
use crate::units::shift;
use crate::{Realization, Result, schur};

/// The frequency response of a plant: `G(jw) = C (jw I - A)^-1 B + D`, in discrete time `G(e^{jw})`.
///
/// One Schur form, `25 n^3` flops, serves all frequencies; each takes `O(n^2)` for an input. The error is that of a
/// plant whose A differs from the one given by a multiple of `n eps |A|` in balanced units of the states: a relative
/// one of eps times the condition of `jw I - A`.
///
/// ```
/// use luenberger_linalg::{FrequencyResponse, Realization};
/// use nalgebra::dmatrix;
/// // 1/(s + 2) at w = 2: 1/(2 + 2j), 3 dB below its value at 0, 45 degrees behind.
/// let plant = Realization::new(&dmatrix![-2.0], &dmatrix![1.0], &dmatrix![1.0], &dmatrix![0.0])?;
/// let at = FrequencyResponse::continuous(&plant)?.at(2.0)[(0, 0)];
/// assert!((at.norm() - 0.125f64.sqrt()).abs() < 1e-15);
/// assert!((at.arg().to_degrees() + 45.0).abs() < 1e-13);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
#[derive(Debug, Clone)]
pub struct FrequencyResponse {
    system: SchurResponse,
    /// D as given.
    d: DMatrix<f64>,
    is_discrete: bool,
}

impl FrequencyResponse {
    /// That of `x' = A x + B u`, `y = C x + D u`.
    ///
    /// # Errors
    /// Those of [`Realization::new`] and of [`schur()`](crate::schur()).
    pub fn continuous(plant: &Realization) -> Result<Self> {
        Self::new(plant, false)
    }

    /// That of `x+ = A x + B u`, `y = C x + D u`; frequencies are angles in radians per sample.
    ///
    /// # Errors
    /// As [`continuous`](Self::continuous).
    pub fn discrete(plant: &Realization) -> Result<Self> {
        Self::new(plant, true)
    }

    fn new(plant: &Realization, is_discrete: bool) -> Result<Self> {
        plant.check()?;
        let Realization { a, b, c, d } = plant;
        Ok(Self { system: SchurResponse::new(a, b, c, d, is_discrete)?, d: d.clone(), is_discrete })
    }

    /// G at a frequency w in radians per unit of time, in discrete time per sample: p x m. At a pole its entries are
    /// not finite; at an infinite w it is D, in continuous time.
    pub fn at(&self, w: f64) -> DMatrix<Complex<f64>> {
        if w.is_infinite() && !self.is_discrete {
            return self.d.map(Complex::from);
        }
        let response = if self.is_discrete {
            // `z - 1 = 2j sin(w/2) e^{jw/2}`, `z + 1 = 2 cos(w/2) e^{jw/2}`: near both ends without cancellation.
            let half = Complex::from_polar(2.0, 0.5 * w);
            let (sin, cos) = (0.5 * w).sin_cos();
            if sin.abs() <= cos.abs() {
                self.system.response(1.0, half * Complex::new(0.0, sin))
            } else {
                self.system.response(-1.0, half * cos)
            }
        } else {
            self.system.response(0.0, Complex::new(0.0, shift(w, -self.system.time)))
        };
        response.map(|z| Complex::new(shift(z.re, self.system.gain), shift(z.im, self.system.gain)))
    }

    /// The singular values of G at a frequency, decreasing, `min(p, m)` of them; infinite at a pole.
    pub fn singular_values(&self, w: f64) -> DVector<f64> {
        let at = self.at(w);
        let count = at.nrows().min(at.ncols());
        if at.iter().any(|z| !(z.re.is_finite() && z.im.is_finite())) {
            return DVector::from_element(count, f64::INFINITY);
        }
        if count <= 1 {
            return DVector::from_element(count, largest(&at));
        }
        // Sorted by nalgebra.
        at.singular_values()
    }

    /// The eigenvalues of A, in the unit of time given.
    pub fn poles(&self) -> Vec<Complex<f64>> {
        let time = self.system.time;
        self.system.poles.iter().map(|pole| Complex::new(shift(pole.re, time), shift(pole.im, time))).collect()
    }

    /// Whether the plant is in discrete time.
    pub fn is_discrete(&self) -> bool {
        self.is_discrete
    }
}

/// The angles of these numbers in radians, each the one that is nearest to that before it, as Bode's diagrams have
/// them. A number that is not finite, as at a pole, has the angle NaN and breaks no curve.
///
/// ```
/// use luenberger_linalg::unwrapped_phase;
/// use nalgebra::Complex;
/// let turns = (0..9).map(|k| Complex::from_polar(2.0, -0.75 * f64::from(k)));
/// assert!((unwrapped_phase(turns)[8] + 6.0).abs() < 1e-15);
/// ```
pub fn unwrapped_phase(values: impl IntoIterator<Item = Complex<f64>>) -> Vec<f64> {
    let mut before: Option<f64> = None;
    let mut next = |z: Complex<f64>| {
        let angle = if z.re.is_finite() && z.im.is_finite() { z.arg() } else { f64::NAN };
        let angle = before.map_or(angle, |before| angle + TAU * ((before - angle) / TAU).round());
        if angle.is_finite() {
            before = Some(angle);
        }
        angle
    };
    values.into_iter().map(&mut next).collect()
}

/// A system `(T, Q'B, C Q, D)` in these units.
#[derive(Debug, Clone)]
pub(crate) struct SchurResponse {
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

impl SchurResponse {
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
        let response = self.response(origin, offset);
        if response.iter().any(|z| !(z.re.is_finite() && z.im.is_finite())) {
            return f64::INFINITY;
        }
        largest(&response)
    }

    /// The response at `z = origin + offset` in these units; not finite at a pole.
    fn response(&self, origin: f64, offset: Complex<f64>) -> DMatrix<Complex<f64>> {
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
        self.c.map(Complex::from) * states + self.d.map(Complex::from)
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
