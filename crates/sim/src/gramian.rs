//! The empirical observability Gramian: how strongly the output depends on the initial state, by simulation.
//!
//! Each state of `x0` is perturbed by `+-eps s_i`, `s_i` the scale of the state; the simulated outputs are compared:
//! ```text
//! W_ij = 1/(4 eps^2) int_{t0}^{t1} (y^{+i} - y^{-i})' R^-2 (y^{+j} - y^{-j}) dt,    R = diag(output scales).
//! ```
//! As eps goes to 0, `z'W z` is the energy of the change of the output for a change `x0 + S z`, `S = diag(s)`: the
//! Gramian of the linearisation along the solution. For a linear plant it is that for every eps, and over a long
//! horizon, if the plant is stable, `S P S` with the P of the Lyapunov equation `A'P + P A + C'R^-2 C = 0`. A direction
//! with eigenvalue 0 changes no output.
//!
//! The *local unobservability index* `1/lambda_min(W)` says how far apart two initial states can be while their outputs
//! differ little; the *estimation condition number* `lambda_max(W)/lambda_min(W)`, how much better the best direction
//! is seen than the worst.
//!
//! Source: S. Lall, J. Marsden and S. Glavaski, A subspace approach to balanced truncation for model reduction of
//! nonlinear control systems, Int. J. Robust Nonlinear Control 12, 2002; A. J. Krener and K. Ide, Measures of
//! unobservability, IEEE CDC 2009.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::erased::{AnyPlant, Erased};
use crate::error::{SimError, check, check_finite, check_positive};
use crate::integrate::{Settings, solve};
use luenberger_plants::Plant;
use luenberger_wording::setters;

/// Scales, perturbation and integrator of an empirical Gramian.
#[derive(Clone, Debug, PartialEq)]
pub struct GramianSettings {
    /// Scale of each state (default: the magnitude of its initial value, 1 for a state that starts at 0).
    pub scales: Option<Vec<f64>>,
    /// Scale of each output (default 1).
    pub output_scales: Option<Vec<f64>>,
    /// Half the distance of the two starts, in scales (default 1e-3). The truncation error goes with its square, the
    /// error of the integration with its inverse.
    pub perturbation: f64,
    /// The integrator.
    pub integration: Settings,
}

impl Default for GramianSettings {
    fn default() -> Self {
        Self { scales: None, output_scales: None, perturbation: 1e-3, integration: Settings::default() }
    }
}

impl GramianSettings {
    setters! { scales: Vec<f64>, output_scales: Vec<f64>, perturbation: f64, integration: Settings }
}

/// An empirical observability Gramian with its eigenvalues. States are in multiples of [`scales`](Self::scales).
#[derive(Clone, Debug, PartialEq)]
pub struct EmpiricalGramian {
    /// W, n x n, symmetric, in scaled states: `W_x = S^-1 W S^-1` in the units given.
    pub gramian: DMatrix<f64>,
    /// Its eigenvalues, the largest first.
    pub eigenvalues: Vec<f64>,
    /// Its eigenvectors as columns, in the order of the eigenvalues; orthonormal in scaled states, given in the units
    /// of the states.
    pub directions: DMatrix<f64>,
    /// Number of eigenvalues above the tolerance.
    pub rank: usize,
    /// Eigenvalues at or below this share of the largest count as zero: `n (100 rtol + (10 max(rtol, atol)/eps)^2)`.
    /// The first is the error of the integrals, of which n make an eigenvalue; the second that of a difference of two
    /// simulations, squared.
    pub tolerance: f64,
    /// Scale of each state.
    pub scales: Vec<f64>,
    /// Half the distance of the two starts, in scales.
    pub perturbation: f64,
    /// Start and end of the simulations.
    pub span: (f64, f64),
}

impl EmpiricalGramian {
    /// `1/lambda_min`: infinite where an eigenvalue counts as zero.
    pub fn unobservability_index(&self) -> f64 {
        self.smallest().map_or(f64::INFINITY, f64::recip)
    }

    /// `lambda_max/lambda_min`: infinite where an eigenvalue counts as zero.
    pub fn condition(&self) -> f64 {
        self.smallest().zip(self.eigenvalues.first()).map_or(f64::INFINITY, |(smallest, largest)| largest / smallest)
    }

    /// The direction that changes the output least, in the units of the states; none if there is no state.
    pub fn weakest(&self) -> Option<DVector<f64>> {
        let n = self.directions.ncols();
        (n > 0).then(|| self.directions.column(n - 1).into_owned())
    }

    /// The Gramian in the units of the states, `S^-1 W S^-1`.
    pub fn unscaled(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.scales.len(), self.scales.len(), |i, j| {
            self.gramian[(i, j)] / self.scales[i] / self.scales[j]
        })
    }

    /// The smallest eigenvalue, if none counts as zero.
    fn smallest(&self) -> Option<f64> {
        if self.rank == self.scales.len() { self.eigenvalues.last().copied() } else { None }
    }
}

/// The empirical observability Gramian of a plant around the solution from `x0` at `span.0`, with the input
/// `input(t, u)`, which writes u.
///
/// All 2 n simulations and the integrals are one equation for the integrator, so that they share its steps and their
/// differences are smooth.
///
/// # Errors
/// [`SimError::Length`], [`SimError::NotFinite`], [`SimError::NotPositive`] and [`SimError::TimeSpan`] for bad input;
/// those of [`solve`] where one of the simulations cannot be continued.
///
/// # Cost
/// That of 2 n simulations with the steps of the most difficult.
///
/// # Example
/// ```
/// use luenberger_linalg::lyapunov;
/// use luenberger_plants::StateSpace;
/// use luenberger_sim::{GramianSettings, empirical_gramian};
/// use nalgebra::dmatrix;
///
/// let plant = StateSpace::new(dmatrix![0.0, 1.0; -2.0, -3.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0])?;
/// let found = empirical_gramian(&plant, &[1.0, 1.0], |_, u| u.fill(1.0), (0.0, 30.0), &GramianSettings::default())?;
/// // A'P + P A + C'C = 0
/// let p = lyapunov(&plant.a, &(plant.c.transpose() * &plant.c))?.p;
/// println!("difference {:e}, condition {}", (&found.gramian - &p).norm(), found.condition());
/// assert!((&found.gramian - &p).norm() < 1e-7 * p.norm());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn empirical_gramian<P: Plant<f64> + Sync>(
    plant: &P,
    x0: &[f64],
    input: impl Fn(f64, &mut [f64]),
    span: (f64, f64),
    settings: &GramianSettings,
) -> Result<EmpiricalGramian, SimError> {
    let plant = Erased(plant);
    plant.check()?;
    let size = plant.dimensions();
    let (n, p) = (size.states, size.outputs);
    check("the initial state", x0, n)?;
    let eps = settings.perturbation;
    check_positive("the perturbation", eps)?;
    let scales = match &settings.scales {
        Some(scales) => scales.clone(),
        None => x0.iter().map(|x| if *x == 0.0 { 1.0 } else { x.abs() }).collect(),
    };
    let weights = settings.output_scales.clone().unwrap_or_else(|| vec![1.0; p]);
    check("the scales of the states", &scales, n)?;
    check("the scales of the outputs", &weights, p)?;
    for scale in scales.iter().chain(&weights) {
        check_positive("a scale", *scale)?;
    }

    // (z^{+1}, z^{-1}, .., z^{+n}, z^{-n}, W_11, W_21, W_22, W_31, ..), z in scales.
    let pairs = n * (n + 1) / 2;
    let mut start = Vec::with_capacity(2 * n * n + pairs);
    for i in 0..n {
        for sign in [1.0, -1.0] {
            start.extend((0..n).map(|j| x0[j] / scales[j] + if i == j { sign * eps } else { 0.0 }));
        }
    }
    start.resize(2 * n * n + pairs, 0.0);
    check_finite("the initial state in its scales", &start)?;
    let stacked = |t: f64, z: &[f64], slope: &mut [f64]| {
        let mut u = vec![0.0; size.inputs];
        input(t, &mut u);
        let (mut x, mut f) = (vec![0.0; n], vec![0.0; n]);
        let mut outputs = vec![0.0; 2 * n * p];
        for k in 0..2 * n {
            for (x, (z, scale)) in x.iter_mut().zip(z[k * n..].iter().zip(&scales)) {
                *x = z * scale;
            }
            plant.derivative(t, &x, &u, &mut f);
            for (slope, (f, scale)) in slope[k * n..].iter_mut().zip(f.iter().zip(&scales)) {
                *slope = f / scale;
            }
            plant.output(t, &x, &u, &mut outputs[k * p..(k + 1) * p]);
        }
        let change =
            |i: usize, l: usize| (outputs[2 * i * p + l] - outputs[(2 * i + 1) * p + l]) / (2.0 * eps * weights[l]);
        let mut place = 2 * n * n;
        for i in 0..n {
            for j in 0..=i {
                slope[place] = (0..p).map(|l| change(i, l) * change(j, l)).sum();
                place += 1;
            }
        }
    };
    let integration = settings.integration;
    let end = solve(stacked, span.0, span.1, &start, &integration)?.at(span.1)?;

    let entry = |i: usize, j: usize| end[2 * n * n + i * (i + 1) / 2 + j];
    let gramian = DMatrix::from_fn(n, n, |i, j| entry(i.max(j), i.min(j)));
    // At most a few sweeps per eigenvalue are needed.
    let iterations = 100 * n.max(1);
    let eigen = if n == 0 { None } else { SymmetricEigen::try_new(gramian.clone(), f64::EPSILON, iterations) };
    let (values, vectors) = match eigen {
        Some(eigen) => (eigen.eigenvalues, eigen.eigenvectors),
        None if n == 0 => (DVector::zeros(0), DMatrix::zeros(0, 0)),
        None => return Err(SimError::Eigenvalues { iterations, norm: gramian.norm() }),
    };
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| values[j].total_cmp(&values[i]));
    let eigenvalues: Vec<f64> = order.iter().map(|&i| values[i]).collect();
    let difference = 10.0 * integration.rtol.max(integration.atol) / eps;
    let tolerance = n as f64 * (100.0 * integration.rtol + difference * difference);
    let largest = eigenvalues.first().copied().unwrap_or(0.0);
    let rank = eigenvalues.iter().filter(|&&value| value > tolerance * largest).count();
    let directions = DMatrix::from_fn(n, n, |i, j| scales[i] * vectors[(i, order[j])]);
    Ok(EmpiricalGramian { gramian, eigenvalues, directions, rank, tolerance, scales, perturbation: eps, span })
}
