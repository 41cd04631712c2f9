//! Conversions between continuous and discrete time, against scipy 1.17.1 (`signal.cont2discrete`, `linalg.logm`) and
//! python-control 0.10.2 (`c2d`), and against each other.

use luenberger_linalg::{
    Discretization, LinalgError, Realization, c2d, c2d_delayed, c2d_matched, continuous_process_noise, d2c,
    discrete_process_noise, expm, logm, measurement_intensity, sampled_measurement_covariance, standard_form,
};
use nalgebra::{Complex, DMatrix, dmatrix};
use proptest::prelude::*;

/// The references have all digits; both sides round in a few products of order 5.
const ROUNDING: f64 = 1e-14;

fn plant() -> Realization {
    Realization::new(
        &dmatrix![0.0, 1.0, 0.0; -2.0, -0.4, 1.0; 0.0, 0.0, -5.0],
        &dmatrix![0.0, 1.0; 1.0, 0.0; 0.0, 2.0],
        &dmatrix![1.0, 0.0, 0.5],
        &dmatrix![0.3, 0.0],
    )
    .unwrap()
}

#[track_caller]
fn near(found: &DMatrix<f64>, expected: &DMatrix<f64>) {
    assert_eq!(found.shape(), expected.shape());
    let error = (found - expected).amax();
    assert!(error <= ROUNDING * expected.amax().max(1.0), "{error:e}: {found}{expected}");
}

/// `e^{Ah}` at h = 0.1, common to three methods.
fn transition() -> DMatrix<f64> {
    dmatrix![
        0.9901484023238073, 0.09769998274526649, 0.004195286844606341;
        -0.19539996549053296, 0.9510684092257007, 0.07672354852223479;
        0.0, 0.0, 0.6065306597126334
    ]
}

#[test]
fn zero_order_hold_as_scipy() {
    let found = c2d(&plant(), 0.1, Discretization::ZeroOrderHold).unwrap();
    near(&found.a, &transition());
    let b = dmatrix![
        0.00492579883809636, 0.09996250707790102; 0.09769998274526648, -0.0014610239869800364; 0.0, 0.15738773611494666
    ];
    near(&found.b, &b);
    near(&found.c, &plant().c);
    near(&found.d, &plant().d);
}

#[test]
fn first_order_hold_as_scipy() {
    let found = c2d(&plant(), 0.1, Discretization::FirstOrderHold).unwrap();
    near(&found.a, &transition());
    let b = dmatrix![
        0.009722063206546928, 0.09979091312686061; 0.09496759640038584, -0.004672457219280078; 0.0, 0.1238544973969404
    ];
    near(&found.b, &b);
    near(&found.c, &plant().c);
    near(&found.d, &dmatrix![0.30164848859747495, 0.0926046335492049]);
}

#[test]
fn impulse_as_scipy() {
    let without_d = Realization { d: dmatrix![0.0, 0.0], ..plant() };
    let found = c2d(&without_d, 0.1, Discretization::Impulse).unwrap();
    near(&found.a, &transition());
    let b = dmatrix![
        0.00976999827452665, 0.099853897601302; 0.09510684092257007, -0.004195286844606338; 0.0, 0.1213061319425267
    ];
    near(&found.b, &b);
    near(&found.d, &dmatrix![0.0, 0.2]);
}

#[test]
fn tustin_as_scipy() {
    let found = c2d(&plant(), 0.1, Discretization::Tustin).unwrap();
    let a = dmatrix![
        0.9902439024390244, 0.0975609756097561, 0.0039024390243902456;
        -0.19512195121951223, 0.951219512195122, 0.0780487804878049;
        0.0, 0.0, 0.6000000000000001
    ];
    near(&found.a, &a);
    let b = dmatrix![
        0.004878048780487806, 0.09990243902439025; 0.09756097560975611, -0.0019512195121951222; 0.0, 0.16000000000000003
    ];
    near(&found.b, &b);
    near(&found.c, &dmatrix![0.9951219512195122, 0.04878048780487806, 0.40195121951219515]);
    near(&found.d, &dmatrix![0.3024390243902439, 0.08995121951219513]);
}

/// python-control's `c2d(sys, 0.1, 'bilinear', prewarp_frequency=1.5)`; and at that frequency the two responses agree.
#[test]
fn tustin_prewarped_as_python_control() {
    let first = Realization { b: plant().b.columns(0, 1).into_owned(), d: dmatrix![0.3], ..plant() };
    let found = c2d(&first, 0.1, Discretization::TustinPrewarped(1.5)).unwrap();
    let a = dmatrix![
        0.9902077388753372, 0.09773893746179861, 0.003915432851360502;
        -0.19547787492359722, 0.9511121638906177, 0.07816177320499611;
        0.0, 0.0, 0.5993988728503568
    ];
    near(&found.a, &a);
    near(&found.b, &dmatrix![0.0048961305623313875; 0.09773893746179861; 0.0]);
    near(&found.c, &dmatrix![0.9951038694376686, 0.048869468730899306, 0.40180743463826946]);
    near(&found.d, &dmatrix![0.3024480652811657]);
    let response = |system: &Realization, s: Complex<f64>| {
        let pencil = DMatrix::identity(3, 3) * s - system.a.map(Complex::from);
        let states = pencil.lu().solve(&system.b.map(Complex::from)).unwrap();
        (system.c.map(Complex::from) * states + system.d.map(Complex::from))[0]
    };
    let continuous = response(&first, Complex::new(0.0, 1.5));
    let discrete = response(&found, Complex::new(0.0, 0.15).exp());
    assert!((continuous - discrete).norm() < 1e-13, "{continuous} {discrete}");
}

/// python-control's `c2d(tf([1, 3], [1, 2, 5, 0.7]), 0.1, 'matched')`.
#[test]
fn matched_as_python_control() {
    let system = Realization::new(
        &dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; -0.7, -5.0, -2.0],
        &dmatrix![0.0; 0.0; 1.0],
        &dmatrix![3.0, 1.0, 0.0],
        &dmatrix![0.0],
    )
    .unwrap();
    let found = c2d_matched(&system, 0.1).unwrap();
    assert!((found.gain - 0.010447243818224225).abs() < 1e-15, "{}", found.gain);
    assert!((found.zeros[0] - 0.7408182206817179).norm() < 1e-14, "{}", found.zeros[0]);
    let model = found.realization();
    near(&model.a.rows(2, 1).into_owned(), &dmatrix![0.8187307530779819, -2.5926379403442334, 2.773275382376503]);
    near(&model.c, &dmatrix![-0.0077395085764449464, 0.010447243818224225, 0.0]);
}

/// The double integrator in other coordinates: `H = c A b / s^2` exactly, and the gain `c A b h^2`. Eigenvalues that
/// are computed as 1e-8, or as 0, must not matter.
#[test]
fn matched_double_integrators_in_any_coordinates() {
    for (a, gain) in [
        (dmatrix![6.0, -4.0; 9.0, -6.0], -0.04),
        (dmatrix![5.0, -25.0; 1.0, -5.0], -0.25),
        (dmatrix![0.1, -0.1; 0.1, -0.1], -0.001),
        (dmatrix![1024.0, -1_073_741_824.0; 0.000_976_562_5, -1024.0], -10_737_418.24),
    ] {
        let system = Realization::new(&a, &dmatrix![0.0; 1.0], &dmatrix![1.0, 0.0], &dmatrix![0.0]).unwrap();
        let found = c2d_matched(&system, 0.1).unwrap();
        assert!((found.gain - gain).abs() <= 1e-14 * f64::abs(gain), "{a}{found:?}");
        assert!(found.poles.iter().all(|pole| *pole == Complex::from(1.0)) && found.zeros.is_empty(), "{a}{found:?}");
    }
}

/// A pole of -1e-3 beside one of -1e10 is no integrator: both at h = 100, mpmath with 40 digits. The gain of
/// `1e10/(s + 1e10) + 1e-3/(s + 1e-3)` at zero is 2.
#[test]
fn matched_keeps_a_slow_pole_beside_a_fast_one() {
    let system =
        Realization::new(&dmatrix![-1e10, 0.0; 0.0, -1e-3], &dmatrix![1e10; 1e-3], &dmatrix![1.0, 1.0], &dmatrix![0.0])
            .unwrap();
    let found = c2d_matched(&system, 100.0).unwrap();
    let mut poles: Vec<f64> = found.poles.iter().map(|pole| pole.re).collect();
    poles.sort_by(f64::total_cmp);
    assert!((poles[1] - 0.904_837_418_035_959_6).abs() < 1e-14 && poles[0] == 0.0, "{poles:?}");
    let at_one = |list: &[Complex<f64>]| list.iter().map(|z| 1.0 - z).product::<Complex<f64>>();
    let gain = at_one(&found.zeros) / at_one(&found.poles) * found.gain;
    assert!((gain.re - 2.0).abs() < 1e-10, "{found:?}");
}

/// `s^2/(s^2 + 2 s + 2)`: a double zero at 0, with `(z - 1)/h` for s; mpmath with 40 digits.
#[test]
fn matched_keeps_the_order_of_a_high_pass() {
    let (a, b) = (dmatrix![-2.0, -2.0; 1.0, 0.0], dmatrix![1.0; 0.0]);
    let system = Realization::new(&a, &b, &dmatrix![-2.0, -2.0], &dmatrix![1.0]).unwrap();
    let found = c2d_matched(&system, 0.1).unwrap();
    assert!((found.gain - 0.904_837_669_379_691_8).abs() < 1e-14, "{found:?}");
    assert!(found.zeros.iter().all(|zero| *zero == Complex::from(1.0)), "{found:?}");
}

/// The double integrator with a zero, `(s + 2)/s^2`: the gain of `s^2 H` at 0 is kept, with `(z - 1)/h` for s. A
/// feedthrough gives as many zeros as poles.
#[test]
fn matched_with_poles_at_zero_and_a_feedthrough() {
    let h: f64 = 0.25;
    let a = dmatrix![0.0, 1.0; 0.0, 0.0];
    let integrators = Realization::new(&a, &dmatrix![0.0; 1.0], &dmatrix![2.0, 1.0], &dmatrix![0.0]).unwrap();
    let found = c2d_matched(&integrators, h).unwrap();
    assert!((found.gain - 2.0 * h * h / (1.0 - (-2.0 * h).exp())).abs() < 1e-14, "{found:?}");
    let lead = Realization::new(&dmatrix![-4.0], &dmatrix![1.0], &dmatrix![-3.0], &dmatrix![1.0]).unwrap();
    let found = c2d_matched(&lead, h).unwrap();
    // (s + 1)/(s + 4).
    let (zero, pole) = ((-h).exp(), (-4.0 * h).exp());
    assert!((found.zeros[0].re - zero).abs() < 1e-14 && (found.poles[0].re - pole).abs() < 1e-14);
    assert!((found.gain - 0.25 * (1.0 - pole) / (1.0 - zero)).abs() < 1e-13);
    near(&found.realization().d, &dmatrix![found.gain]);
    let two = Realization::new(&a, &dmatrix![0.0; 1.0], &DMatrix::identity(2, 2), &dmatrix![0.0; 0.0]).unwrap();
    assert!(matches!(c2d_matched(&two, h), Err(LinalgError::DimensionMismatch { .. })));
    let nothing = Realization::new(&a, &dmatrix![0.0; 1.0], &dmatrix![0.0, 0.0], &dmatrix![0.0]).unwrap();
    assert!(matches!(c2d_matched(&nothing, h), Err(LinalgError::Empty { .. })));
}

#[test]
fn the_logarithm_is_that_of_scipy() {
    let found = logm(&dmatrix![0.9, 0.2, 0.0; -0.3, 0.8, 0.1; 0.0, 0.05, 0.4]).unwrap();
    let expected = dmatrix![
        -0.06666663589439602, 0.23021708628463267, -0.021379927792479724;
        -0.34532562942694867, -0.18712016098483245, 0.16855836262351587;
        0.016034945844359945, 0.08427918131175799, -0.9254933948563356
    ];
    near(&found, &expected);
    for refused in [dmatrix![-1.0, 0.0; 0.0, 2.0], dmatrix![0.0, 0.0; 0.0, 2.0]] {
        assert!(matches!(logm(&refused), Err(LinalgError::NoLogarithm { .. })));
    }
}

/// mpmath, exponentials with 40 digits: the first input 2.5 periods late, the second three periods.
#[test]
fn delays_are_past_inputs() {
    let found = c2d_delayed(&plant(), 0.1, &[0.25, 0.3], &[0.0]).unwrap();
    let mut a = DMatrix::zeros(9, 9);
    a.view_mut((0, 0), (3, 3)).copy_from(&transition());
    // u_1[k-1], u_1[k-2], u_1[k-3], and the same of the second input.
    for (column, entries) in [
        (4, [0.001_241_191_565_857_290_3, 0.049_462_074_556_048_41, 0.0]),
        (5, [0.003_684_607_272_239_069, 0.048_237_908_189_218_06, 0.0]),
        (8, [0.099_962_507_077_901_02, -0.001_461_023_986_980_038_6, 0.157_387_736_114_946_64]),
    ] {
        a.view_mut((0, column), (3, 1)).copy_from_slice(&entries);
    }
    for k in [4, 5, 7, 8] {
        a[(k, k - 1)] = 1.0;
    }
    let mut b = DMatrix::zeros(9, 2);
    (b[(3, 0)], b[(6, 1)]) = (1.0, 1.0);
    near(&found.a, &a);
    assert_eq!(found.b, b);
    // At a sample the output sees the first input of three periods before, which is held until its half.
    assert_eq!(found.c, dmatrix![1.0, 0.0, 0.5, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0]);
    assert_eq!(found.d, dmatrix![0.0, 0.0]);
    // No delay, and one that rounding keeps from being whole.
    let none = c2d_delayed(&plant(), 0.1, &[0.0, 0.0], &[0.0]);
    assert_eq!(none, c2d(&plant(), 0.1, Discretization::ZeroOrderHold));
    assert_eq!(c2d_delayed(&plant(), 0.1, &[0.1 + 0.2, 0.7], &[0.1 + 0.2]).unwrap().a.nrows(), 3 + 3 + 7 + 3);
    let refused = |inputs: &[f64], outputs: &[f64]| c2d_delayed(&plant(), 0.1, inputs, outputs).unwrap_err();
    for wrong in [-0.1, f64::NAN, f64::INFINITY, 101.0] {
        assert!(matches!(refused(&[0.0, wrong], &[0.0]), LinalgError::InvalidDelay { .. }), "{wrong}");
        assert!(matches!(refused(&[0.0, 0.0], &[wrong]), LinalgError::InvalidDelay { .. }), "{wrong}");
    }
    let shaped = |inputs: &[f64], outputs: &[f64]| match refused(inputs, outputs) {
        LinalgError::DimensionMismatch { what, .. } => what,
        other => panic!("{other}"),
    };
    assert_eq!(shaped(&[0.1], &[0.0]), "the delays of the inputs");
    assert_eq!(shaped(&[0.1, 0.1], &[]), "the delays of the outputs");
}

proptest! {
    /// The delayed model, step by step, is the plant without delay at an eighth of the period, whose held input is
    /// late.
    #[test]
    fn a_delayed_model_follows_the_plant_in_short_steps(
        late in prop::collection::vec(0..40_usize, 2),
        inputs in prop::collection::vec(-1.0..1.0_f64, 24),
    ) {
        let (h, short) = (0.4, 0.05);
        let delays: Vec<f64> = late.iter().map(|late| *late as f64 * short).collect();
        let model = c2d_delayed(&plant(), h, &delays, &[0.0]).unwrap();
        let fine = c2d(&plant(), short, Discretization::ZeroOrderHold).unwrap();
        let input = |k: usize, j: usize| inputs[2 * k + j];
        let (mut x, mut z) = (DMatrix::zeros(3, 1), DMatrix::zeros(model.a.nrows(), 1));
        for k in 0..12 {
            // The input at a short step, late by so many.
            let late = |step: usize| {
                DMatrix::from_fn(2, 1, |j, _| step.checked_sub(late[j]).map_or(0.0, |step| input(step / 8, j)))
            };
            let u = DMatrix::from_fn(2, 1, |j, _| input(k, j));
            let (y, expected) = (&model.c * &z + &model.d * &u, &fine.c * &x + &fine.d * late(8 * k));
            prop_assert!((y - expected).amax() < 1e-12);
            z = &model.a * z + &model.b * u;
            for step in 8 * k..8 * (k + 1) {
                x = &fine.a * x + &fine.b * late(step);
            }
            prop_assert!((z.rows(0, 3) - &x).amax() < 1e-12, "{z}{x}");
        }
    }

    /// The outputs as well: each is that of the plant so many short steps before.
    #[test]
    fn late_outputs_are_those_of_short_steps_before(
        late in prop::collection::vec(0..40_usize, 2),
        seen_late in prop::collection::vec(0..40_usize, 2),
        inputs in prop::collection::vec(-1.0..1.0_f64, 24),
    ) {
        let (h, short) = (0.4, 0.05);
        let times = |late: &[usize]| late.iter().map(|late| *late as f64 * short).collect::<Vec<_>>();
        // A second output, with its own feedthrough.
        let Realization { a, b, .. } = plant();
        let two = Realization::new(
            &a, &b, &dmatrix![1.0, 0.0, 0.5; 0.0, -1.0, 2.0], &dmatrix![0.3, 0.0; -0.2, 0.7]).unwrap();
        let model = c2d_delayed(&two, h, &times(&late), &times(&seen_late)).unwrap();
        let fine = c2d(&two, short, Discretization::ZeroOrderHold).unwrap();
        let acting = |step: usize| {
            let of = |j: usize| step.checked_sub(late[j]).map_or(0.0, |step| inputs[2 * (step / 8) + j]);
            DMatrix::from_fn(2, 1, |j, _| of(j))
        };
        let mut x = DMatrix::zeros(3, 1);
        let outputs: Vec<DMatrix<f64>> = (0..96).map(|step| {
            let y = &fine.c * &x + &fine.d * acting(step);
            x = &fine.a * &x + &fine.b * acting(step);
            y
        }).collect();
        let mut z = DMatrix::zeros(model.a.nrows(), 1);
        for k in 0..12 {
            let u = DMatrix::from_fn(2, 1, |j, _| inputs[2 * k + j]);
            let y = &model.c * &z + &model.d * &u;
            for i in 0..2 {
                let expected = (8 * k).checked_sub(seen_late[i]).map_or(0.0, |step| outputs[step][i]);
                prop_assert!((y[i] - expected).abs() < 1e-12, "output {i} of sample {k}: {} {expected}", y[i]);
            }
            z = &model.a * z + &model.b * u;
        }
    }
}

/// Powers of two in the rows and columns of E do not matter: the same A and B, in these units.
#[test]
fn the_standard_form_does_not_depend_on_units() {
    let (e, a, b) = (
        dmatrix![2.0, 1.0, 0.0; 0.5, 3.0, -1.0; 0.0, 1.0, 1.5],
        dmatrix![0.0, 1.0, 0.3; -2.0, -3.0, 0.1; 0.7, 0.2, -1.0],
        dmatrix![1.0; 0.5; -2.0],
    );
    let plain = standard_form(&e, &a, &b).unwrap();
    near(&(&e * &plain.a), &a);
    near(&(&e * &plain.b), &b);
    let (rows, columns) = ([1e0_f64, 2.0_f64.powi(40), 2.0_f64.powi(-33)], [2.0_f64.powi(-38), 1.0, 2.0_f64.powi(29)]);
    let scaled = |m: &DMatrix<f64>| DMatrix::from_fn(3, 3, |i, j| m[(i, j)] * rows[i] * columns[j]);
    let driven = DMatrix::from_fn(3, 1, |i, _| b[(i, 0)] * rows[i]);
    let found = standard_form(&scaled(&e), &scaled(&a), &driven).unwrap();
    near(&DMatrix::from_fn(3, 3, |i, j| found.a[(i, j)] * columns[i] / columns[j]), &plain.a);
    near(&DMatrix::from_fn(3, 1, |i, _| found.b[(i, 0)] * columns[i]), &plain.b);
    let refused = standard_form(&dmatrix![1.0, 2.0; 2.0, 4.0], &DMatrix::identity(2, 2), &DMatrix::zeros(2, 0));
    assert!(matches!(refused, Err(LinalgError::Singular { what: "E", .. })));
}

#[test]
fn conversions_that_do_not_exist_are_errors() {
    let pole = |p: f64| Realization::new(&dmatrix![p], &dmatrix![1.0], &dmatrix![1.0], &dmatrix![0.0]).unwrap();
    // 2/h is a pole.
    assert!(matches!(c2d(&pole(20.0), 0.1, Discretization::Tustin), Err(LinalgError::Singular { .. })));
    assert!(matches!(d2c(&pole(-1.0), 0.1, Discretization::Tustin), Err(LinalgError::Singular { .. })));
    assert!(matches!(d2c(&pole(-0.5), 0.1, Discretization::ZeroOrderHold), Err(LinalgError::NoLogarithm { .. })));
    for frequency in [0.0, 32.0, f64::NAN] {
        let refused = c2d(&pole(-1.0), 0.1, Discretization::TustinPrewarped(frequency));
        assert!(matches!(refused, Err(LinalgError::InvalidFrequency { .. })), "{frequency}");
    }
    for period in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = c2d(&pole(-1.0), period, Discretization::ZeroOrderHold);
        assert!(matches!(refused, Err(LinalgError::InvalidPeriod { .. })), "{period}");
    }
    let misshapen = Realization { d: dmatrix![0.0, 0.0], ..pole(-1.0) };
    let refused = c2d(&misshapen, 0.1, Discretization::Tustin);
    assert!(matches!(refused, Err(LinalgError::DimensionMismatch { what: "D", .. })));
}

/// scipy: Van Loan's exponential, confirmed there by quadrature to 3e-17.
#[test]
fn process_noise_as_van_loan() {
    let w = dmatrix![0.0, 0.0, 0.0; 0.0, 2.0, 0.3; 0.0, 0.3, 1.0];
    let expected = dmatrix![
        0.0006512333987124876, 0.009677050679978472, 0.0011683631472544675;
        0.009677050679978476, 0.1936113038034837, 0.026163796330334964;
        0.0011683631472544681, 0.026163796330334964, 0.06321205588285578
    ];
    near(&discrete_process_noise(&plant().a, &w, 0.1).unwrap(), &expected);
    // A long period of a stable plant ends at the solution of A Q + Q A' + W = 0, and not in an overflow.
    let long = discrete_process_noise(&plant().a, &w, 1e4).unwrap();
    let residual = &plant().a * &long + &long * plant().a.transpose() + &w;
    assert!(residual.amax() < 1e-13, "{residual}");
}

#[test]
fn measurement_noise_is_scaled_by_the_period() {
    let r = dmatrix![4.0, 1.0; 1.0, 9.0];
    let v = measurement_intensity(&r, 0.5).unwrap();
    assert_eq!(v, dmatrix![2.0, 0.5; 0.5, 4.5]);
    assert_eq!(sampled_measurement_covariance(&v, 0.5).unwrap(), r);
    assert!(matches!(measurement_intensity(&dmatrix![1.0, 2.0], 0.5), Err(LinalgError::NotSquare { .. })));
}

/// Eigenvalues of norm below n/2.
fn matrix(n: usize, m: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0_f64, n * m).prop_map(move |entries| DMatrix::from_row_slice(n, m, &entries))
}

fn system() -> impl Strategy<Value = Realization> {
    (1..=5_usize, 1..=2_usize, 1..=2_usize).prop_flat_map(|(n, m, p)| {
        (matrix(n, n), matrix(n, m), matrix(p, n), matrix(p, m)).prop_map(|(a, b, c, d)| Realization { a, b, c, d })
    })
}

proptest! {
    /// Poles within the strip of |Im| < pi/h come back, by every method.
    #[test]
    fn back_and_forth(system in system(), h in 0.01..0.4_f64) {
        for method in [
            Discretization::ZeroOrderHold,
            Discretization::FirstOrderHold,
            Discretization::Impulse,
            Discretization::Tustin,
            Discretization::TustinPrewarped(1.0),
        ] {
            let back = d2c(&c2d(&system, h, method).unwrap(), h, method).unwrap();
            let size = |system: &Realization| {
                system.a.norm().hypot(system.b.norm()).hypot(system.c.norm()).hypot(system.d.norm())
            };
            let difference = Realization {
                a: &back.a - &system.a, b: &back.b - &system.b, c: &back.c - &system.c, d: &back.d - &system.d,
            };
            // Rounding of Ad, divided by h.
            let error = size(&difference) / size(&system);
            prop_assert!(error < 1e-12 / h, "{method:?}: {error:e}");
        }
    }

    #[test]
    fn the_logarithm_inverts_the_exponential(a in matrix(5, 5)) {
        let error = (logm(&expm(&a).unwrap()).unwrap() - &a).norm();
        prop_assert!(error < 1e-12 * a.norm().max(1.0), "{error:e}");
    }

    /// Two periods of h are one of 2 h, and the intensity comes back.
    #[test]
    fn process_noise_adds_up(a in matrix(4, 4), g in matrix(4, 3), h in 0.05..2.0_f64) {
        let w = &g * g.transpose();
        let once = discrete_process_noise(&a, &w, h).unwrap();
        let step = expm(&(&a * h)).unwrap();
        let twice = discrete_process_noise(&a, &w, 2.0 * h).unwrap();
        let error = (&once + &step * &once * step.transpose() - &twice).norm() / twice.norm().max(1e-300);
        prop_assert!(error < 1e-12, "{error:e}");
        let back = continuous_process_noise(&a, &once, h).unwrap();
        let error = (&back - &w).norm() / w.norm().max(1e-300);
        prop_assert!(error < 1e-8, "{error:e}");
    }
}

/// diag(-1e10, -1e-3) over h = 100: `int_0^h (s/h) e^{ls} ds b = b (1 - e^{lh} (1 - lh)) / (h l^2)` for the mode l, and
/// `b (e^{lh} - 1 - lh) / (h l^2)` of the falling part; mpmath with 50 digits.
#[test]
fn the_first_order_hold_of_a_stiff_plant() {
    let plant =
        Realization::new(&dmatrix![-1e10, 0.0; 0.0, -1e-3], &dmatrix![1e10; 1e-3], &dmatrix![1.0, 1.0], &dmatrix![0.0])
            .unwrap();
    let found = c2d(&plant, 100.0, Discretization::FirstOrderHold).unwrap();
    entries_near(&found.b, &dmatrix![1e-12; 0.090_559_170_060_627_15]);
    entries_near(&found.d, &dmatrix![1.048_374_180_358_595_7]);
    // And in another order of the states, coupled: the entry of the fast mode keeps its digits.
    let swapped =
        Realization::new(&dmatrix![-1e-3, 0.0; 0.0, -1e10], &dmatrix![1e-3; 1e10], &dmatrix![1.0, 1.0], &dmatrix![0.0])
            .unwrap();
    let found = c2d(&swapped, 100.0, Discretization::FirstOrderHold).unwrap();
    entries_near(&found.b, &dmatrix![0.090_559_170_060_627_15; 1e-12]);
}

/// Eigenvalues 100 decades apart: the entry beside the diagonal is `(ln p - ln q)/(p - q)` times that of A, the block of
/// the eigenvalues `.5 +- .1 i` has `ln |z|` and `arg z` of `z = .5 + .1 i`.
#[test]
fn a_logarithm_of_eigenvalues_of_any_ratio() {
    // The square roots lose a digit or two beside the diagonal.
    let entries_near = |found: &DMatrix<f64>, expected: &DMatrix<f64>| {
        for (x, y) in found.iter().zip(expected.iter()) {
            assert!((x - y).abs() <= 100.0 * ROUNDING * y.abs(), "{found}{expected}");
        }
    };
    let tiny = 1e-100_f64;
    let (p, q) = (tiny.ln(), 0.5_f64.ln());
    entries_near(&logm(&dmatrix![tiny]).unwrap(), &dmatrix![p]);
    entries_near(&logm(&dmatrix![tiny, 0.0; 0.0, 0.5]).unwrap(), &dmatrix![p, 0.0; 0.0, q]);
    let beside = (p - q) / (tiny - 0.5);
    entries_near(&logm(&dmatrix![tiny, 1.0; 0.0, 0.5]).unwrap(), &dmatrix![p, beside; 0.0, q]);
    entries_near(&logm(&dmatrix![0.5, 0.0; 1.0, tiny]).unwrap(), &dmatrix![q, 0.0; beside, p]);
    let (w, l) = (0.1_f64.atan2(0.5), 0.26_f64.ln() / 2.0);
    let block = dmatrix![tiny, 0.0, 0.0; 0.0, 0.5, 0.1; 0.0, -0.1, 0.5];
    entries_near(&logm(&block).unwrap(), &dmatrix![p, 0.0, 0.0; 0.0, l, w; 0.0, -w, l]);
    // `x' = a x + b u` with `a = ln(1e-100)`: `bd = (e^a - 1) b/a`.
    let model = Realization::new(&dmatrix![tiny], &dmatrix![1.0], &dmatrix![1.0], &dmatrix![0.0]).unwrap();
    let back = d2c(&model, 1.0, Discretization::ZeroOrderHold).unwrap();
    entries_near(&back.a, &dmatrix![p]);
    entries_near(&back.b, &dmatrix![-p]);
}

/// Relative to each entry.
#[track_caller]
fn entries_near(found: &DMatrix<f64>, expected: &DMatrix<f64>) {
    for (x, y) in found.iter().zip(expected.iter()) {
        assert!((x - y).abs() <= ROUNDING * y.abs(), "{found}{expected}");
    }
}

/// A rotation in units nine decades apart: `(I - A h/2)^-1 (I + A h/2) = [.2 .4; -.4 .2]` there.
#[test]
fn tustin_in_other_units() {
    let system =
        Realization::new(&dmatrix![-1.0, 1e9; -1e-9, -1.0], &dmatrix![1e9; 1.0], &dmatrix![1e-9, 0.0], &dmatrix![0.0])
            .unwrap();
    let found = c2d(&system, 1.0, Discretization::Tustin).unwrap();
    entries_near(&found.a, &dmatrix![0.2, 4e8; -4e-10, 0.2]);
    let back = d2c(&found, 1.0, Discretization::Tustin).unwrap();
    entries_near(&back.a, &system.a);
}

/// The logarithm of `[.5 1e6; -1e-8 .5]` is `[l w 1e7; -w 1e-7, l]` with `l = ln |z|, w = arg z` of `z = .5 + .1i`:
/// mpmath with 50 digits.
#[test]
fn to_continuous_time_in_other_units() {
    let a = dmatrix![0.5, 1e6; -1e-8, 0.5];
    let z = Complex::new(0.5, 0.1).ln();
    let expected = dmatrix![z.re, z.im * 1e7; -z.im * 1e-7, z.re];
    entries_near(&logm(&a).unwrap(), &expected);
    let system = Realization::new(&a, &dmatrix![1e7; 1.0], &DMatrix::identity(2, 2), &DMatrix::zeros(2, 1)).unwrap();
    entries_near(&d2c(&system, 1.0, Discretization::ZeroOrderHold).unwrap().a, &expected);
}

/// A stiff plant in its modes: each has its own exponential, and `Bd = (e^{lambda h} - 1)/lambda`.
#[test]
fn a_slow_mode_beside_a_fast_one_keeps_its_digits() {
    for fast in [-1e3, -1e10, -1e15] {
        for h in [1.0, 0.25] {
            let a = dmatrix![fast, 0.0; 0.0, -1.0];
            let held = luenberger_linalg::zero_order_hold(&a, &dmatrix![1.0; 1.0], h).unwrap();
            assert!((held.ad[(1, 1)] - f64::exp(-h)).abs() <= 4.0 * f64::EPSILON, "{fast}: {held:?}");
            assert!((held.bd[1] + f64::exp_m1(-h)).abs() <= 100.0 * f64::EPSILON, "{fast}: {held:?}");
            assert!((held.bd[0] * fast + 1.0).abs() <= 100.0 * f64::EPSILON + f64::exp(fast * h), "{fast}: {held:?}");
            // Coupled, and in another order of the states: `x12 = (e^{-h} - e^{fast h}) / (-1 - fast)`.
            let coupled = expm(&(dmatrix![-1.0, 0.0; 1.0, fast] * h)).unwrap();
            let expected = (f64::exp(-h) - f64::exp(fast * h)) / (-1.0 - fast);
            assert!((coupled[(1, 0)] / expected - 1.0).abs() <= 100.0 * f64::EPSILON, "{fast}: {coupled}");
        }
    }
}

/// `e^(As)` turns by a whole angle within the period: any W of the same trace has this Qd, or none where Qd is no
/// multiple of the identity.
#[test]
fn an_intensity_that_a_covariance_does_not_determine_is_refused() {
    let a = dmatrix![0.0, std::f64::consts::PI; -std::f64::consts::PI, 0.0];
    for qd in [dmatrix![1.0, 0.0; 0.0, 1.0], dmatrix![1.0, 0.2; 0.2, 1.0]] {
        let found = continuous_process_noise(&a, &qd, 1.0);
        assert!(matches!(found, Err(LinalgError::Singular { .. })), "{found:?}");
    }
}
