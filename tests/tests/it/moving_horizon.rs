//! The moving-horizon estimator of a linear plant with bounds, beside Clarabel: each window's problem as one dense
//! quadratic program.
//!
//! ```text
//! minimise |x_0 - a|^2_(Pi^-1)/2 + sum |y_i - C x_i|^2_(V^-1)/2 + sum |x_(i+1) - A x_i - B u_i|^2_(W^-1)/2
//! subject to lower <= x_i <= upper
//! ```
//!
//! **How near they must be.** With the Hessian H, its least eigenvalue lambda, and for a point (x, z >= 0) of a solver
//! the residual `r = H x + g + G'z`, the products `s'z` of slacks and multipliers and the largest violation v of a
//! bound, the solution x* with multipliers z* has `lambda |x - x*|^2 <= |r| |x - x*| + s'z + v |z*|_1`, so that
//! `|x - x*| <= |r|/lambda + sqrt((s'z + v |z*|_1)/lambda)`. These numbers are computed from the point of Clarabel. The
//! estimator solves its equations exactly, with v = 0, and ends with a mean of s z of `1e3 epsilon` after a step with a
//! tenth of the mean before it: at most ten times that is assumed.

use clarabel::algebra::CscMatrix;
use clarabel::solver::SupportedConeT::NonnegativeConeT;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus};
use luenberger_observers::moving_horizon::{Horizon, MovingHorizonEstimator};
use luenberger_observers::{NoiseModel, SampledObserver};
use luenberger_plants::{LinearPlant, StateSpace};
use nalgebra::{DMatrix, DVector, Dyn, dmatrix, dvector};
use proptest::prelude::*;

use crate::generators::{matrix, partly_measured_plant};

const WINDOW: usize = 4;
const SAMPLES: usize = 9;
/// Requested of Clarabel: gap and residuals.
const PRECISE: f64 = 1e-11;

type Estimator = MovingHorizonEstimator<StateSpace, f64, Dyn, Dyn, Dyn, Dyn, WINDOW>;

/// What the samples before the window say of its first state.
struct Prior {
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// A sample of the window.
struct Sample {
    u: DVector<f64>,
    y: DVector<f64>,
}

/// The problem of one window.
struct Window<'a> {
    plant: &'a StateSpace,
    noises: &'a NoiseModel<f64, Dyn, Dyn>,
    bounds: (&'a DVector<f64>, &'a DVector<f64>),
    prior: &'a Prior,
    samples: &'a [Sample],
}

fn inverse(m: &DMatrix<f64>) -> DMatrix<f64> {
    m.clone().cholesky().unwrap().inverse()
}

impl Window<'_> {
    /// `H` and `g` of `x'H x/2 + g'x`.
    fn objective(&self) -> (DMatrix<f64>, DVector<f64>) {
        let StateSpace { a, b, c, .. } = self.plant;
        let n = a.nrows();
        let order = n * self.samples.len();
        let (mut h, mut g) = (DMatrix::zeros(order, order), DVector::zeros(order));
        // A square |E x - d|^2 with the weight M, for columns of E from `at` on.
        let mut add = |at: usize, e: &DMatrix<f64>, d: &DVector<f64>, weight: &DMatrix<f64>| {
            let columns = e.ncols();
            let mut block = h.view_mut((at, at), (columns, columns));
            block += e.transpose() * weight * e;
            let mut rows = g.rows_mut(at, columns);
            rows -= e.transpose() * weight * d;
        };
        let (one, w, v) = (DMatrix::identity(n, n), inverse(&self.noises.w), inverse(&self.noises.v));
        add(0, &one, &self.prior.mean, &inverse(&self.prior.covariance));
        for (i, Sample { u, y }) in self.samples.iter().enumerate() {
            add(n * i, c, y, &v);
            if i + 1 < self.samples.len() {
                let mut e = DMatrix::zeros(n, 2 * n);
                e.view_mut((0, 0), (n, n)).copy_from(&-a);
                e.view_mut((0, n), (n, n)).copy_from(&one);
                add(n * i, &e, &(b * u), &w);
            }
        }
        (h, g)
    }

    /// The last state of the solution by Clarabel, how far it may be from the exact one, and lambda.
    fn solve(&self) -> (DVector<f64>, f64, f64) {
        let (h, g) = self.objective();
        let (order, n) = (h.nrows(), self.plant.a.nrows());
        let dense = |rows: usize, entry: &dyn Fn(usize, usize) -> f64| {
            let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
            for j in 0..order {
                for i in (0..rows).filter(|i| entry(*i, j) != 0.0) {
                    indices.push(i);
                    values.push(entry(i, j));
                }
                starts.push(values.len());
            }
            CscMatrix::new(rows, order, starts, indices, values)
        };
        // x <= upper, and -x <= -lower.
        let sign = |i: usize| if i < order { 1.0 } else { -1.0 };
        let limits: Vec<f64> = (0..2 * order)
            .map(|i| if i < order { self.bounds.1[i % n] } else { -self.bounds.0[(i - order) % n] })
            .collect();
        let settings = DefaultSettings {
            verbose: false,
            tol_gap_abs: PRECISE,
            tol_gap_rel: PRECISE,
            tol_feas: PRECISE,
            max_threads: 1,
            direct_solve_method: "qdldl".to_owned(),
            ..DefaultSettings::default()
        };
        let upper_triangle = dense(order, &|i, j| if i <= j { h[(i, j)] } else { 0.0 });
        let constraints = dense(2 * order, &|i, j| if i % order == j { sign(i) } else { 0.0 });
        let cones = [NonnegativeConeT(2 * order)];
        let mut solver =
            DefaultSolver::new(&upper_triangle, g.as_slice(), &constraints, &limits, &cones, settings).unwrap();
        solver.solve();
        let found = &solver.solution;
        assert!(matches!(found.status, SolverStatus::Solved | SolverStatus::AlmostSolved), "{:?}", found.status);
        let x = DVector::from_column_slice(&found.x);
        let z = DVector::from_iterator(2 * order, found.z.iter().map(|z| z.max(0.0)));
        let residual = &h * &x + g + z.rows(0, order) - z.rows(order, order);
        let (mut products, mut violation) = (0.0, 0.0f64);
        for i in 0..2 * order {
            let slack = limits[i] - sign(i) * x[i % order];
            products += slack.max(0.0) * z[i];
            violation = violation.max(-slack);
        }
        let least = h.symmetric_eigenvalues().min();
        let multipliers = 2.0 * z.lp_norm(1);
        let distance = residual.norm() / least + ((products + violation * multipliers) / least).sqrt();
        (x.rows(order - n, n).into_owned(), distance, least)
    }
}

impl Prior {
    /// The Kalman filter: the update by a sample and the prediction for the next.
    fn advance(&mut self, plant: &StateSpace, noises: &NoiseModel<f64, Dyn, Dyn>, Sample { u, y }: &Sample) {
        let StateSpace { a, b, c, .. } = plant;
        let s = c * &self.covariance * c.transpose() + &noises.v;
        let gain = &self.covariance * c.transpose() * inverse(&s);
        let mean = &self.mean + &gain * (y - c * &self.mean);
        let covariance = &self.covariance - &gain * c * &self.covariance;
        self.mean = a * mean + b * u;
        let next = a * covariance * a.transpose() + &noises.w;
        self.covariance = (&next + next.transpose()) * 0.5;
    }
}

fn covariance(root: &DMatrix<f64>, least: f64) -> DMatrix<f64> {
    root * root.transpose() + DMatrix::identity(root.nrows(), root.nrows()) * least
}

/// Steps the estimator beside Clarabel; how many estimates end at a bound, and how many within all.
fn beside(
    plant: &StateSpace,
    noises: &NoiseModel<f64, Dyn, Dyn>,
    (lower, upper): (&DVector<f64>, &DVector<f64>),
    samples: &[Sample],
) -> Result<(usize, usize), TestCaseError> {
    let horizon = Horizon { window: WINDOW, iterations: 1 };
    let discrete = LinearPlant::new(plant.a.clone(), plant.b.clone(), plant.c.clone()).unwrap();
    let estimator: Estimator = MovingHorizonEstimator::discrete(discrete, noises.clone(), horizon, 1.0)
        .and_then(|free| free.with_bounds(lower.clone(), upper.clone()))
        .unwrap();
    let n = plant.a.nrows();
    let start = DVector::zeros(n);
    let mut state = estimator.initial(0.0, &start, &samples[0].u, &samples[0].y);
    let mut prior = Prior { mean: start, covariance: noises.p0.clone() };
    let (mut active, mut within) = (0, 0);
    for (k, sample) in samples.iter().enumerate() {
        let first = (k + 1).saturating_sub(WINDOW);
        if first > 0 {
            prior.advance(plant, noises, &samples[first - 1]);
        }
        let updated = estimator.update(0.0, &mut state, &sample.u, &sample.y, |_| true);
        prop_assert!(updated.is_some(), "sample {k}");
        let found = estimator.estimate(&state);
        let window = Window { plant, noises, bounds: (lower, upper), prior: &prior, samples: &samples[first..=k] };
        let (expected, distance, least) = window.solve();
        let products = (2 * n * window.samples.len()) as f64 * 1e4 * f64::EPSILON;
        let tolerance = distance + (products / least).sqrt();
        prop_assert!(tolerance < 1e-3, "sample {k}: the tolerance {tolerance:e} says nothing");
        let difference = (&found - &expected).norm();
        prop_assert!(difference <= tolerance, "sample {k}: {difference:e} apart, at most {tolerance:e} expected");
        let near = |bound: f64, x: f64| (bound - x).abs() <= tolerance;
        if (0..n).any(|i| near(lower[i], found[i]) || near(upper[i], found[i])) {
            active += 1;
        } else {
            within += 1;
        }
        prop_assert!(estimator.predict(0.0, &mut state, &sample.u, 1.0));
    }
    Ok((active, within))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// Random observable plants with two and three states, one or two outputs, correlated noises, and bounds that the
    /// measurements violate.
    #[test]
    fn bounded_estimates_are_those_of_clarabel(
        plant in partly_measured_plant(2..=3),
        roots in [matrix(3, 3), matrix(3, 3), matrix(3, 3)],
        limits in [matrix(3, 1), matrix(3, 1)],
        signals in matrix(SAMPLES, 4),
    ) {
        let (n, m, p) = (plant.a.nrows(), plant.b.ncols(), plant.c.nrows());
        // A contraction: the covariances of the prior stay of the size of W.
        let plant = StateSpace::new(&plant.a * (0.9 / plant.a.norm()), plant.b, plant.c).unwrap();
        let part = |root: &DMatrix<f64>, order: usize, least: f64| covariance(&root.view((0, 0), (order, order)).into_owned(), least);
        let noises = NoiseModel { w: part(&roots[0], n, 0.2), v: part(&roots[1], p, 0.1), p0: part(&roots[2], n, 0.3) };
        let [lower, upper] = [-1.0, 1.0].map(|sign: f64| {
            let row = usize::from(sign > 0.0);
            DVector::from_fn(n, |i, _| sign * (0.25 + 0.2 * limits[row][i]))
        });
        let samples: Vec<Sample> = (0..SAMPLES)
            .map(|k| Sample {
                u: DVector::from_fn(m, |i, _| signals[(k, i % 2)]),
                y: DVector::from_fn(p, |i, _| signals[(k, 2 + i % 2)]),
            })
            .collect();
        beside(&plant, &noises, (&lower, &upper), &samples)?;
    }
}

/// A cart whose position is measured beyond its bound in every other half of the run: estimates at the bound and
/// within.
#[test]
fn bounds_are_active_and_not() {
    let plant = StateSpace::new(dmatrix![1.0, 0.5; 0.0, 0.9], dmatrix![0.0; 0.1], dmatrix![1.0, 0.0]).unwrap();
    let noises =
        NoiseModel { w: dmatrix![0.02, 0.01; 0.01, 0.04], v: dmatrix![0.09], p0: dmatrix![1.0, 0.2; 0.2, 0.5] };
    let sample = |k: usize| Sample { u: dvector![0.1], y: dvector![if k % 10 < 5 { 0.0 } else { 2.0 }] };
    let samples: Vec<Sample> = (0..20).map(sample).collect();
    let (lower, upper) = (dvector![-1.0, -0.6], dvector![1.0, 0.6]);
    let (active, within) = beside(&plant, &noises, (&lower, &upper), &samples).unwrap();
    assert!(active >= 4 && within >= 4, "{active} at a bound, {within} within");
}
