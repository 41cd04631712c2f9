//! The cubic observer of least cost: J against closed forms and scipy, the linear optimum against the Riccati equation
//! and the matrix inequality, the search against grids.

use luenberger_design::{
    CubicDesign, CubicGain, DesignError, DisturbanceBounds, ErrorBound, EstimationProblem, LinearDesign,
    LyapunovWeight, OptimalCubicDesign,
};
use luenberger_lmi::{Problem, block, he, identity, trace};
use luenberger_observers::CubicObserver;
use luenberger_plants::StateSpace;
use nalgebra::{DMatrix, DVector, dmatrix};

fn scalar() -> StateSpace {
    StateSpace::new(dmatrix![0.0], DMatrix::zeros(1, 0), dmatrix![1.0]).unwrap()
}

fn cart() -> StateSpace {
    luenberger_plants::double_integrator().to_dynamic()
}

/// First errors 1 and 2, noise of 0.05 that is held for 0.01, process noise on the velocity, e'Te = e1^2 + e2^2/2.
fn problem() -> EstimationProblem {
    EstimationProblem {
        process: dmatrix![0.0, 0.0; 0.0, 0.003],
        weight: dmatrix![1.0, 0.0; 0.0, 0.5],
        ..EstimationProblem::new(&[1.0, 2.0], &[0.05], 0.01, 20.0)
    }
}

/// A cubic observer of given gains, P from Q, theta = 1, N = -gamma P^-1 C'.
fn cubic(plant: &StateSpace, l: &DMatrix<f64>, q: DMatrix<f64>, gamma: f64) -> CubicDesign {
    let linear = LinearDesign::with_gain_and_weight(plant, l, LyapunovWeight::Matrix(q)).unwrap();
    CubicDesign::new(&linear, &dmatrix![1.0], &CubicGain::Gamma(gamma)).unwrap()
}

/// scipy 1.16: solve_continuous_lyapunov, expm and solve_discrete_lyapunov.
#[test]
fn the_cost_of_a_linear_observer_is_that_of_scipy() {
    let cost = problem().linear(&cart(), &dmatrix![3.0; 2.5]).unwrap();
    assert!((cost.transient / 1.0875 - 1.0).abs() < 1e-12, "{cost:?}");
    assert!((cost.mean_square / 0.001_410_924_629_508_122_3 - 1.0).abs() < 1e-10, "{cost:?}");
    assert!((cost.total / 1.115_718_492_590_162_9 - 1.0).abs() < 1e-12, "{cost:?}");
}

/// A cubic term a hundred times stronger needs a hundred times the steps in a period where the noise is large, more
/// than the search allows: its cost is judged all the same, and is continuous in the strength. Under noise that is held
/// for h the error of `e' = -l e - theta (e + v)^3` is within the noise, as its right-hand side points inwards from
/// there.
#[test]
fn a_strong_cubic_term_is_judged() {
    let problem = EstimationProblem::new(&[1.0], &[0.3], 0.1, 100.0);
    let cost = |gamma: f64| {
        let design = cubic(&scalar(), &dmatrix![1.0], dmatrix![2.0], gamma);
        problem.cubic(&design.observer, 0).unwrap()
    };
    let costs = [1e3, 1.1e3, 1e4, 1.1e4].map(|gamma| cost(gamma).mean_square);
    for pair in costs.chunks(2) {
        assert!((pair[0] / pair[1] - 1.0).abs() < 0.05, "{costs:?}");
    }
    // sigma^2 at most but for the share of the last period.
    assert!(costs.iter().all(|cost| (0.02..0.12).contains(cost)), "{costs:?}");
}

/// scipy 1.16: solve_continuous_are, and minimize (Nelder-Mead) of the cost above. In the limit of short periods J is
/// tau trace(T Sigma), the optimum of a matrix inequality too.
#[test]
fn the_linear_optimum_is_that_of_scipy_and_of_the_matrix_inequality() {
    let found = OptimalCubicDesign::new(&cart(), &problem(), None).unwrap();
    let expected = dmatrix![33.591_285_362_234_345; 64.187_226_143_525_42];
    assert!((&found.kalman_gain - &expected).norm() < 1e-5 * expected.norm(), "{}", found.kalman_gain);
    assert!((found.kalman_cost.total / 0.555_603_419_382_739 - 1.0).abs() < 1e-9, "{:?}", found.kalman_cost);
    // The optimum is flat: its cost is known better than its gain.
    assert!((found.linear_cost.total / 0.555_598_629_372_249_9 - 1.0).abs() < 1e-6, "{:?}", found.linear_cost);
    let expected = dmatrix![34.082_441_699; 65.109_496_320];
    assert!((&found.linear_gain - &expected).norm() < 0.02 * expected.norm(), "{}", found.linear_gain);

    let (plant, n) = (cart(), 2);
    let root = |m: DMatrix<f64>| m.map(f64::sqrt);
    let w = root(dmatrix![1.0 / 40.0, 0.0; 0.0, 4.0 / 40.0 + 0.003]);
    let t = root(dmatrix![1.0, 0.0; 0.0, 0.5]);
    let mut lmi = Problem::new();
    let (p, y, z) = (lmi.symmetric("P", n), lmi.rectangular("Y", n, 1), lmi.symmetric("Z", n));
    let noise = &y * dmatrix![(0.05_f64 * 0.05 * 0.01).sqrt()];
    let first = he(&p * &plant.a - &y * &plant.c);
    let whole = block![
        [first, &p * &w, noise.clone()],
        [(&p * &w).transpose(), -1.0 * identity(n), DMatrix::zeros(n, 1)],
        [noise.transpose(), DMatrix::zeros(1, n), -1.0 * identity(1)]
    ];
    lmi.constrain("covariance", whole << 0.0);
    lmi.constrain("bound", block![[z.clone(), t.clone()], [t.transpose(), p.clone()]] >> 0.0);
    lmi.minimise(trace(&z));
    let solution = lmi.solve().unwrap();
    let least = 20.0 * solution.named("Z").unwrap().trace();
    // What the solver returns satisfies the strict inequalities, a little above the infimum.
    assert!((-1e-8..1e-3).contains(&(least / 0.555_828_500_180_468_5 - 1.0)), "{least}");
}

/// `e' = -l e - gamma e^3` from d: `int e^2 dt = ln(1 + gamma d^2/l)/(2 gamma)`. For the cart: scipy's solve_ivp
/// (DOP853, rtol 1e-11) from the same eight directions.
#[test]
fn the_transient_of_a_cubic_observer_is_that_of_closed_forms() {
    for (l, gamma, d) in [(3.0, 0.5, 1.0), (1.0, 40.0, 2.0), (0.2, 2000.0, 1.0)] {
        // Q = 2 l makes P = 1.
        let design = cubic(&scalar(), &dmatrix![l], dmatrix![2.0 * l], gamma);
        let problem = EstimationProblem { weight: dmatrix![1.0], ..EstimationProblem::new(&[d], &[1e-3], 0.01, 1.0) };
        let found = problem.cubic(&design.observer, 1).unwrap().transient;
        let expected = (gamma * d * d / l).ln_1p() / (2.0 * gamma);
        assert!((found / expected - 1.0).abs() < 5e-4, "{found} {expected}");
    }
    let design = cubic(&cart(), &dmatrix![3.0; 2.5], DMatrix::identity(2, 2), 2.0);
    let found = problem().cubic(&design.observer, 1).unwrap().transient;
    assert!((found / 1.004_498_874_136_935_8 - 1.0).abs() < 5e-4, "{found}");
}

/// A strong cubic term keeps the measured error near 0, which it passes, while the other one is large and slow, or
/// oscillates: the cubic term is not over where the measured error passes 0. scipy's solve_ivp (Radau, rtol 1e-9) from
/// the same eight directions.
#[test]
fn the_transient_goes_on_where_the_measured_error_passes_zero() {
    let cases = [
        ([1.0, 1.0], [7.23399, 16.7102], [-3.347_379_820_126_638_3, -0.041_364_613_487_980_31], 100.0, [1.0, 1.0]),
        ([1.0, 1.0], [6.44219, 14.8769], [-2.055_355_677_995_604_6, -0.019_895_432_280_871_626], 100.0, [1.0, 1.0]),
        (
            [5.795, 1.0],
            [0.0659744, 62.0038],
            [-3.831_196_799_773_783_5, -0.043_619_563_156_793_134],
            1e4,
            [1.0 / 23.18 / 23.18, 1.0 / 16.0],
        ),
    ];
    let expected = [0.228_316_225_675_991_1, 0.248_894_468_544_208_52, 0.007_488_655_511_626_651];
    for ((first, l, n, theta, weight), expected) in cases.into_iter().zip(expected) {
        let StateSpace { a, b, c, .. } = cart();
        let (l, n) = (dmatrix![l[0]; l[1]], dmatrix![n[0]; n[1]]);
        let observer = CubicObserver::new(a, b, c, l, n, dmatrix![theta]).unwrap();
        let weight = DMatrix::from_diagonal(&DVector::from_column_slice(&weight));
        let problem = EstimationProblem { weight, ..EstimationProblem::new(&first, &[0.01], 0.01, 10.0) };
        let found = problem.cubic(&observer, 0).unwrap().transient;
        assert!((found / expected - 1.0).abs() < 5e-4, "{found} {expected}");
    }
}

/// To first order in gamma the cubic term acts on Gaussian noise as the gain `3 gamma rho P^-1 C'` beside L, rho the
/// variance of `y - C xhat`: by Stein's lemma, E r^3 f = 3 rho E r f.
#[test]
fn a_weak_cubic_term_acts_on_noise_like_a_larger_gain() {
    let (plant, l) = (cart(), dmatrix![3.0; 2.5]);
    let problem = EstimationProblem { process: DMatrix::zeros(2, 2), ..problem() };
    let design = cubic(&plant, &l, DMatrix::identity(2, 2), 40.0);
    let found: f64 = (1..=6).map(|seed| problem.cubic(&design.observer, seed).unwrap().mean_square / 6.0).sum();
    // The variance of the noise, and that of e1, which is 2 % of it.
    let larger = &l - &design.observer.n * (3.0 * 0.0025 * 1.02);
    let expected = problem.linear(&plant, &larger).unwrap().mean_square;
    // The mean squares of 200 time units, six times, are known to some 4 %.
    assert!((found / expected - 1.0).abs() < 0.1, "{found} {expected}");
    assert!(expected > 1.2 * problem.linear(&plant, &l).unwrap().mean_square);
}

#[test]
fn no_gain_of_a_grid_is_better_for_a_scalar_plant() {
    let problem = EstimationProblem::new(&[1.0], &[0.1], 0.01, 20.0);
    let found = OptimalCubicDesign::new(&scalar(), &problem, None).unwrap();
    let best = problem.cubic(&found.cubic.as_ref().unwrap().observer, 9).unwrap().total;
    let mut least = f64::INFINITY;
    for i in 0..12 {
        for j in 0..12 {
            let (l, gamma) = (0.5 * 1.5_f64.powi(i), 10.0 * 1.7_f64.powi(j));
            let design = cubic(&scalar(), &dmatrix![l], dmatrix![2.0 * l], gamma);
            least = problem.cubic(&design.observer, 9).map_or(least, |cost| least.min(cost.total));
        }
    }
    // The search has seen another sequence of the noise.
    assert!(best < 1.01 * least && found.cost.total < 0.6 * found.linear_cost.total, "{best} {least}");
    assert!(found.certificate.is_proved() && found.certificate.converges_from_everywhere());
}

#[test]
fn no_gain_of_a_grid_is_better_for_a_cart() {
    let problem = EstimationProblem { period: 0.02, ..problem() };
    let found = OptimalCubicDesign::new(&cart(), &problem, None).unwrap();
    let best = problem.cubic(&found.cubic.as_ref().unwrap().observer, 9).unwrap().total;
    let mut least = f64::INFINITY;
    for (i, j) in (0..5).flat_map(|i| (0..5).map(move |j| (i, j))) {
        for (k, ratio) in (0..5).flat_map(|k| [0.03, 1.0].map(|ratio| (k, ratio))) {
            let l = dmatrix![2.0 * 2.0_f64.powi(i); 2.0 * 3.0_f64.powi(j)];
            let q = dmatrix![1.0, 0.0; 0.0, ratio];
            let design = cubic(&cart(), &l, q, 0.3 * 10.0_f64.powi(k));
            least = problem.cubic(&design.observer, 9).map_or(least, |cost| least.min(cost.total));
        }
    }
    assert!(best < 1.01 * least, "{best} {least}");
    assert!(found.cost.total < found.linear_cost.total && found.cost_reduction() > 0.0);
    assert!(found.certificate.converges_from_everywhere());
}

/// N acts on the position almost alone, so that V decays slowly and P has little freedom: a bound of the error all the
/// same.
#[test]
fn the_optimum_has_a_bound_of_the_error() {
    let weight = LyapunovWeight::Matrix(dmatrix![1.0, 0.000_244_141; 0.000_244_141, 0.000_103_317]);
    let linear = LinearDesign::with_gain_and_weight(&cart(), &dmatrix![7.23399; 16.7102], weight).unwrap();
    let design = CubicDesign::new(&linear, &dmatrix![100.0], &CubicGain::General(dmatrix![0.231_762])).unwrap();
    let bound = ErrorBound::cubic(&design, &DisturbanceBounds::of_outputs(2, &[0.1])).unwrap();
    assert!(bound.certificate.is_proved() && bound.rate > 0.0, "{bound:?}");
    // A noise of 0.1 that stays makes an error of that size.
    assert!(bound.limsup[0] >= 0.1 && bound.limsup[0] < 40.0, "{bound:?}");
}

#[test]
fn where_the_noise_is_as_large_as_the_first_error_the_linear_optimum_is_the_answer() {
    let problem = EstimationProblem::new(&[1.0], &[1.0], 0.1, 20.0);
    let found = OptimalCubicDesign::new(&scalar(), &problem, None).unwrap();
    assert!(found.cubic.is_none() && found.cost_reduction() == 0.0 && found.cost == found.linear_cost);
    assert_eq!(*found.linear.l(), found.linear_gain);
    assert!(found.certificate.is_proved());
}

#[test]
fn two_outputs_share_the_cubic_term() {
    let a = dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; -1.0, -2.0, 0.0];
    let plant = StateSpace::new(a, DMatrix::zeros(3, 0), dmatrix![1.0, 0.0, 0.0; 0.0, 0.0, 1.0]).unwrap();
    let problem = EstimationProblem::new(&[1.0, 1.0, 1.0], &[0.02, 0.05], 0.02, 20.0);
    let found = OptimalCubicDesign::new(&plant, &problem, None).unwrap();
    let cubic = found.cubic.as_ref().unwrap();
    assert!(found.certificate.is_proved() && found.cost_reduction() > 0.01, "{}", found.cost_reduction());
    let s = &cubic.s + cubic.s.transpose();
    assert!(s.symmetric_eigenvalues().min() > 0.0 && cubic.observer.theta.symmetric_eigenvalues().min() > 0.0);
}

#[test]
fn numbers_that_do_not_fit_are_named() {
    let error = |problem: EstimationProblem| OptimalCubicDesign::new(&scalar(), &problem, None).unwrap_err();
    let sound = EstimationProblem::new(&[1.0], &[0.1], 0.01, 20.0);
    let what = |error: DesignError| error.to_string();
    assert_eq!(
        what(error(EstimationProblem { first_errors: vec![0.0], ..sound.clone() })),
        "a first error must be positive and finite; it is 0"
    );
    assert!(
        what(error(EstimationProblem { noise: vec![-1.0], ..sound.clone() })).contains("of the noise of an output")
    );
    assert!(what(error(EstimationProblem { period: f64::NAN, ..sound.clone() })).contains("the period of the noise"));
    assert!(what(error(EstimationProblem { horizon: 0.0, ..sound.clone() })).contains("the horizon"));
    assert!(what(error(EstimationProblem { weight: dmatrix![-1.0], ..sound.clone() })).starts_with("T "));
    assert!(what(error(EstimationProblem { process: dmatrix![-1.0], ..sound.clone() })).starts_with("W "));
    let unseen = StateSpace::new(dmatrix![0.0], DMatrix::zeros(1, 0), dmatrix![0.0]).unwrap();
    assert!(OptimalCubicDesign::new(&unseen, &sound, None).is_err());
    let past = Some(std::time::Instant::now());
    assert!(OptimalCubicDesign::new(&scalar(), &sound, past).is_err());
}
