//! The map `T(x) = int_0^inf e^{D s} B h(X(-s, x)) ds`: the state of the target when the plant has reached x.
//!
//! One pass backward in time. With `E' = D E`, `E(0) = B` beside the plant, `w' = E h(x)` is a stable quadrature:
//! nothing unstable is integrated, neither z backward nor a guess of it forward. The rest of the integral,
//! `e^{D s} T(X(-s, x))`, is below the tolerance at the horizon. DT comes from the same pass with the variational
//! equation along the n directions, derivatives of f and h by [`Differentiable`].
//!
//! This bounds the truncation error if the past is bounded; if it grows at the rate g, and e^{D s} decays at the rate
//! lambda, the truncation error is about the power (lambda - g) / lambda of the tolerance.
//!
//! T exists if h stays bounded along the past, or grows more slowly than e^{D s} decays; it is k times differentiable
//! if the decay rate of e^{D s} exceeds k times the expansion rate of the backward flow.

use luenberger_linalg::expm;
use luenberger_plants::Differentiable;
use nalgebra::{Const, SMatrix, SVector};

use crate::check::within;
use crate::numerical_kkl::domain::Domain;
use crate::numerical_kkl::error::NumericalKklError;
use crate::numerical_kkl::extrapolation::{Extrapolation, Halt};
use crate::numerical_kkl::target::TargetSystem;

/// T of a plant, evaluated by simulation.
pub struct Transform<'p, S, const N: usize, const M: usize, const P: usize, const Z: usize> {
    plant: &'p S,
    target: TargetSystem<P, Z>,
    domain: Domain<N>,
    input: SVector<f64, M>,
    tolerance: f64,
    horizon: f64,
    output_scale: f64,
}

impl<'p, S, const N: usize, const M: usize, const P: usize, const Z: usize> Transform<'p, S, N, M, P, Z>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
{
    /// T of `plant` at the constant input `input`, to about `tolerance` of the size of y (1e-13 to 1e-3), on `domain`.
    ///
    /// The scalar plant x' = -x, y = x with D = -3, B = 3, whose T is `3 x / 2` (from `-T'(x) x = -3 T + 3 x`):
    /// ```
    /// use luenberger_design::numerical_kkl::{Domain, Escape, TargetSystem, Transform};
    /// use luenberger_plants::StaticPlant;
    /// use nalgebra::{SMatrix, SVector, Vector1};
    /// let plant = StaticPlant::new(Vector1::new(-1.0), SMatrix::<f64, 1, 0>::zeros(), Vector1::new(1.0))?;
    /// let target = TargetSystem::<1, 1>::poles(&[-3.0])?;
    /// let domain = Domain::new([-1.0], [1.0], Escape::Free)?;
    /// let t = Transform::new(&plant, &target, &domain, SVector::zeros(), 1e-11)?;
    /// // The past grows like e^s, the weight falls like e^{-3s}: two thirds of the digits of the tolerance.
    /// assert!((t.at(&Vector1::new(0.8))?[0] - 1.2).abs() < 1e-7);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`DesignError::Setting`](crate::DesignError::Setting) for the tolerance, [`NumericalKklError::NotFinite`] when h
    /// is not finite in the box, [`DesignError::Matrix`](crate::DesignError::Matrix) for the input.
    pub fn new(
        plant: &'p S,
        target: &TargetSystem<P, Z>,
        domain: &Domain<N>,
        input: SVector<f64, M>,
        tolerance: f64,
    ) -> Result<Self, NumericalKklError> {
        within("the tolerance", tolerance, 1e-13, 1e-3)?;
        luenberger_plants::error::check_matrix("u", &input, (M, 1))?;
        // Of what size y is: the largest of the corners, the centre, and what lies between.
        let mut output_scale = 0.0f64;
        let probes = 3usize.pow(N.min(8) as u32);
        for probe in 0..probes {
            let x = domain.point(|i| (probe / 3usize.pow(i.min(8) as u32) % 3) as f64 * 0.5);
            let y = plant.output(0.0, &x, &input);
            if !y.iter().all(|entry| entry.is_finite()) {
                return Err(NumericalKklError::NotFinite { from: x.iter().copied().collect(), time: 0.0 });
            }
            output_scale = output_scale.max(y.amax());
        }
        let output_scale = if output_scale > 0.0 { output_scale } else { 1.0 };
        let horizon = horizon(target, tolerance)?;
        Ok(Self { plant, target: target.clone(), domain: domain.clone(), input, tolerance, horizon, output_scale })
    }

    /// How far back the integral goes.
    pub fn horizon(&self) -> f64 {
        self.horizon
    }

    /// The target.
    pub fn target(&self) -> &TargetSystem<P, Z> {
        &self.target
    }

    /// The domain.
    pub fn domain(&self) -> &Domain<N> {
        &self.domain
    }

    /// The tolerance.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The plant.
    pub fn plant(&self) -> &S {
        self.plant
    }

    /// The constant input.
    pub fn input(&self) -> &SVector<f64, M> {
        &self.input
    }

    /// The largest |y| found in the box.
    pub fn output_scale(&self) -> f64 {
        self.output_scale
    }

    /// `T(x)`.
    ///
    /// # Errors
    /// [`NumericalKklError::Escapes`], [`NumericalKklError::Stalled`], [`NumericalKklError::NotFinite`].
    pub fn at(&self, x: &SVector<f64, N>) -> Result<SVector<f64, Z>, NumericalKklError> {
        let mut state = vec![0.0; N + Z * P + Z];
        self.past(x, 0, &mut state)?;
        Ok(SVector::from_column_slice(&state[N + Z * P..]))
    }

    /// `T(x)` and `DT(x)`, Z x N.
    ///
    /// # Errors
    /// As [`at`](Self::at).
    pub fn with_jacobian(
        &self,
        x: &SVector<f64, N>,
    ) -> Result<(SVector<f64, Z>, SMatrix<f64, Z, N>), NumericalKklError> {
        let start = N + Z * P;
        let mut state = vec![0.0; start + Z + N * (N + Z)];
        self.past(x, N, &mut state)?;
        let value = SVector::from_column_slice(&state[start..start + Z]);
        let slopes = &state[start + Z..];
        Ok((value, SMatrix::from_fn(|i, j| slopes[j * (N + Z) + N + i])))
    }

    /// `DT f - D T - B h` at x, with T and DT by simulation: zero up to the tolerance, wherever f is the plant's.
    ///
    /// # Errors
    /// As [`at`](Self::at).
    pub fn defect(&self, x: &SVector<f64, N>) -> Result<SVector<f64, Z>, NumericalKklError> {
        let (value, jacobian) = self.with_jacobian(x)?;
        Ok(self.defect_of(x, &value, &jacobian))
    }

    /// `J f(x) - D z - B h(x)`: the defect of any candidate's value z and Jacobian J at x.
    pub fn defect_of(
        &self,
        x: &SVector<f64, N>,
        z: &SVector<f64, Z>,
        jacobian: &SMatrix<f64, Z, N>,
    ) -> SVector<f64, Z> {
        let f = self.plant.derivative(0.0, x, &self.input) * self.domain.speed(x).0;
        jacobian * f - self.target.d() * z - self.target.b() * self.plant.output(0.0, x, &self.input)
    }

    /// From x backward over the horizon. State: x from the centre of the box, E by columns, w, and for each direction
    /// its tangent and its share of DT.
    fn past(&self, x: &SVector<f64, N>, directions: usize, state: &mut [f64]) -> Result<(), NumericalKklError> {
        let (e, w) = (N, N + Z * P);
        let tangents = w + Z;
        state.fill(0.0);
        let centre = self.domain.centre();
        state[..N].copy_from_slice((x - centre).as_slice());
        state[e..w].copy_from_slice(self.target.b().as_slice());
        let mut scale = vec![1.0; state.len()];
        let half = self.domain.half_width();
        let (b_scale, t_scale) = (self.target.b().amax(), self.output_scale);
        scale[..N].copy_from_slice(half.as_slice());
        scale[e..w].fill(b_scale);
        scale[w..tangents].fill(t_scale);
        for k in 0..directions {
            let at = tangents + k * (N + Z);
            // The tangent of a displacement by one half-width, so that it has the units of its column.
            state[at + k] = half[k];
            scale[at..at + N].copy_from_slice(half.as_slice());
            scale[at + N..at + N + Z].fill(t_scale);
        }
        let d = self.target.d().as_slice();
        let u = self.input.as_slice();
        let (mut f, mut df) = (SVector::<f64, N>::zeros(), SMatrix::<f64, N, N>::zeros());
        let (mut y, mut dy) = (SVector::<f64, P>::zeros(), SMatrix::<f64, P, N>::zeros());
        let mut backward = |state: &[f64], slope: &mut [f64]| {
            let x = centre + SVector::<f64, N>::from_column_slice(&state[..N]);
            let (x, (chi, chi_gradient)) = (x.as_slice(), self.domain.speed(&x));
            let weights = &state[e..w];
            let fits = if directions == 0 {
                self.plant.derivative_into(0.0, x, u, f.as_mut_slice())
                    && self.plant.output_into(0.0, x, u, y.as_mut_slice())
            } else {
                self.plant.motion_into(0.0, x, u, f.as_mut_slice(), df.as_mut_slice())
                    && self.plant.measurement_into(0.0, x, u, y.as_mut_slice(), dy.as_mut_slice())
            };
            if !fits {
                return slope.fill(f64::NAN);
            }
            for i in 0..N {
                slope[i] = if chi == 0.0 { 0.0 } else { -chi * f[i] };
            }
            for k in 0..P {
                times(d, &weights[k * Z..][..Z], &mut slope[e + k * Z..][..Z]);
            }
            times(weights, y.as_slice(), &mut slope[w..tangents]);
            for k in 0..directions {
                let at = tangents + k * (N + Z);
                let v = &state[at..at + N];
                let (mut turn, mut along, mut output_along) = (0.0, [0.0; N], [0.0; P]);
                for i in 0..N {
                    turn += chi_gradient[i] * v[i];
                }
                times(df.as_slice(), v, &mut along);
                times(dy.as_slice(), v, &mut output_along);
                for i in 0..N {
                    slope[at + i] = if chi == 0.0 { 0.0 } else { -(chi * along[i] + turn * f[i]) };
                }
                times(weights, &output_along, &mut slope[at + N..at + N + Z]);
            }
        };
        let from = || x.iter().copied().collect::<Vec<_>>();
        Extrapolation::new(state.len(), self.tolerance)
            .advance(&mut backward, self.horizon, state, &scale, N)
            .map_err(|halt| match halt {
                Halt::NotFinite => NumericalKklError::NotFinite { from: from(), time: 0.0 },
                Halt::Escape { time, norm } => NumericalKklError::Escapes { from: from(), time, norm },
                Halt::Stall { time, step, steps } => NumericalKklError::Stalled { from: from(), time, step, steps },
            })?;
        for k in 0..directions {
            let at = tangents + k * (N + Z);
            for entry in &mut state[at..at + N + Z] {
                *entry /= half[k];
            }
        }
        Ok(())
    }
}

/// `M x` for M by columns. Loops: the adapters of a matrix product are calls at the optimisation of tests.
fn times(m: &[f64], x: &[f64], product: &mut [f64]) {
    product.fill(0.0);
    let rows = product.len();
    for j in 0..x.len() {
        let column = &m[j * rows..][..rows];
        for i in 0..rows {
            product[i] += column[i] * x[j];
        }
    }
}

/// The time after which `|e^{D s} B| <= tolerance |D^-1 B|`.
fn horizon<const P: usize, const Z: usize>(
    target: &TargetSystem<P, Z>,
    tolerance: f64,
) -> Result<f64, NumericalKklError> {
    let d = target.dynamics();
    // In units of the fastest pole, doubled until the norm is small; D is Hurwitz, so that this ends: 2^200 is out of
    // reach of any abscissa that is distinguishable from zero.
    let mut time = 1.0 / d.norm();
    let mut memory = expm(&(&d * time))?;
    for _ in 0..200 {
        if memory.norm() <= tolerance {
            break;
        }
        memory = &memory * &memory;
        time *= 2.0;
    }
    // Between half of it and it: eight bisections are 0.4 percent.
    let (mut low, mut high) = (0.5 * time, time);
    for _ in 0..8 {
        let middle = 0.5 * (low + high);
        if expm(&(&d * middle))?.norm() <= tolerance { high = middle } else { low = middle }
    }
    Ok(high)
}
