//! Kalman filters of correlated noises, and the measurement update, against scipy and properties.

use luenberger_linalg::{
    LinalgError, correlated_kalman_gain, discrete_correlated_kalman_gain, discrete_kalman_gain, measurement_update,
};
use nalgebra::{DMatrix, dmatrix};

/// C, V, `G W G'` and `G S` for G = [1 0; 0.5 2], W = [1 0.2; 0.2 0.5], S = [0.2 0.1; 0.05 -0.1].
fn noises() -> [DMatrix<f64>; 4] {
    let g = dmatrix![1.0, 0.0; 0.5, 2.0];
    let (w, s) = (dmatrix![1.0, 0.2; 0.2, 0.5], dmatrix![0.2, 0.1; 0.05, -0.1]);
    [dmatrix![1.0, 0.0; 1.0, 1.0], dmatrix![0.4, 0.1; 0.1, 0.3], &g * w * g.transpose(), g * s]
}

#[track_caller]
fn near(found: &DMatrix<f64>, expected: &DMatrix<f64>) {
    let error = (found - expected).amax();
    assert!(error <= 1e-13 * expected.amax(), "{error:e}: {found}{expected}");
}

/// scipy 1.17.1, `solve_continuous_are` and `solve_discrete_are` of the transposed plant with `s`.
#[test]
fn gains_are_those_of_scipy() {
    let [c, v, w, s] = noises();
    let found = correlated_kalman_gain(&dmatrix![0.0, 1.0; -2.0, -0.3], &c, &w, &v, &s).unwrap();
    let p =
        dmatrix![0.322_664_740_766_374_8, 0.030_071_848_673_617_45; 0.030_071_848_673_617_45, 0.892_948_075_923_649_2];
    near(&found.p, &p);
    near(
        &found.l,
        &dmatrix![1.013_870_575_326_483_6, 1.171_165_106_357_813_5; -0.075_276_707_796_740_48, 2.601_825_317_923_136_5],
    );
    let a = dmatrix![0.9, 0.2; -0.1, 0.8];
    let found = discrete_correlated_kalman_gain(&a, &c, &w, &v, &s).unwrap();
    let p = dmatrix![0.905_028_842_572_032_1, 0.790_317_327_854_126; 0.790_317_327_854_126, 3.181_765_029_838_915_3];
    near(&found.p, &p);
    near(
        &found.l,
        &dmatrix![0.581_061_552_612_296_5, 0.230_756_243_693_427_7; -0.154_453_886_011_929_44, 0.525_423_881_843_959_2],
    );
    // The update from the matrices of numpy.
    let update = measurement_update(&found.p, &c, &v).unwrap();
    near(
        &update.gain,
        &dmatrix![0.516_379_473_218_236_6, 0.128_743_269_747_926_16; -0.529_116_967_988_111_8, 0.824_815_991_793_589_4],
    );
    near(
        &update.p,
        &dmatrix![0.219_426_116_262_087_3, -0.129_165_188_015_885_6; -0.129_165_188_015_885_6, 0.323_698_288_755_152_05],
    );
    // Without correlation: the gains without s, and L = A M.
    let plain = discrete_kalman_gain(&a, &c, &w, &v).unwrap();
    let none = discrete_correlated_kalman_gain(&a, &c, &w, &v, &DMatrix::zeros(2, 2)).unwrap();
    near(&none.l, &plain.l);
    near(&(&a * measurement_update(&plain.p, &c, &v).unwrap().gain), &plain.l);
}

/// Units of states and outputs by powers of two: the same gains, in these units.
#[test]
fn units_do_not_matter() {
    let [c, v, w, s] = noises();
    let a = dmatrix![0.9, 0.2; -0.1, 0.8];
    let (x, y) = ([2.0_f64.powi(30), 2.0_f64.powi(-25)], [2.0_f64.powi(-20), 2.0_f64.powi(35)]);
    let scaled = |m: &DMatrix<f64>, rows: &[f64], columns: &[f64]| {
        DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * rows[i] * columns[j])
    };
    let back = |units: &[f64]| units.iter().map(|unit| 1.0 / unit).collect::<Vec<_>>();
    let plain = discrete_correlated_kalman_gain(&a, &c, &w, &v, &s).unwrap();
    let (a, c) = (scaled(&a, &x, &back(&x)), scaled(&c, &y, &back(&x)));
    let (w, v, s) = (scaled(&w, &x, &x), scaled(&v, &y, &y), scaled(&s, &x, &y));
    let found = discrete_correlated_kalman_gain(&a, &c, &w, &v, &s).unwrap();
    near(&scaled(&found.l, &back(&x), &y), &plain.l);
    let update = measurement_update(&found.p, &c, &v).unwrap();
    let [c, v, ..] = noises();
    near(&scaled(&update.p, &back(&x), &back(&x)), &measurement_update(&plain.p, &c, &v).unwrap().p);
}

#[test]
fn impossible_noises_are_errors() {
    let (a, one) = (dmatrix![0.5], dmatrix![1.0]);
    let too_much = discrete_correlated_kalman_gain(&a, &one, &one, &one, &dmatrix![1.01]).unwrap_err();
    assert!(
        matches!(too_much, LinalgError::NotPositiveSemidefinite { what: "the joint covariance [W, S; S', V]", .. }),
        "{too_much}"
    );
    let shape = correlated_kalman_gain(&a, &one, &one, &one, &dmatrix![0.5, 0.5]).unwrap_err();
    assert_eq!(shape, LinalgError::DimensionMismatch { what: "S", expected: (1, 1), found: (1, 2) });
    let unseen = correlated_kalman_gain(&one, &dmatrix![0.0], &one, &one, &dmatrix![0.0]).unwrap_err();
    assert!(matches!(unseen, LinalgError::NotDetectable { .. }), "{unseen}");
    let exact = measurement_update(&dmatrix![0.0], &one, &dmatrix![0.0]).unwrap_err();
    assert!(matches!(exact, LinalgError::NotPositiveDefinite { what: "V + C P C'", .. }), "{exact}");
    let negative = measurement_update(&dmatrix![-1.0], &one, &one).unwrap_err();
    assert!(matches!(negative, LinalgError::NotPositiveSemidefinite { what: "P", .. }), "{negative}");
}
