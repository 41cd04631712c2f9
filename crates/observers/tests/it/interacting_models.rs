//! The interacting multiple model filter beside numpy, and beside the filter of one model; bad input.

use luenberger_observers::{
    CovarianceFilter, ExtendedKalmanFilter, InteractingMultipleModel, NoiseModel, ObserverError, SampledObserver,
};
use luenberger_plants::StateSpace;
use nalgebra::{DMatrix, DVector, dmatrix, dvector};

type Filter = InteractingMultipleModel<StateSpace>;

/// A model of two states without inputs, the first measured.
/// A sample, mode probabilities, estimate, the upper triangle of the covariance.
type Row = (usize, [f64; 3], [f64; 2], [f64; 3]);

fn model(
    a: DMatrix<f64>,
    w: DMatrix<f64>,
    v: f64,
) -> ExtendedKalmanFilter<StateSpace, f64, nalgebra::Dyn, nalgebra::Dyn, nalgebra::Dyn> {
    let plant = StateSpace::new(a, DMatrix::zeros(2, 0), dmatrix![1.0, 0.0]).unwrap();
    let noises = NoiseModel { w, v: dmatrix![v], p0: dmatrix![1.0, 0.0; 0.0, 0.5] };
    ExtendedKalmanFilter::discrete(plant, noises, 1.0).unwrap()
}

/// A target that moves steadily, that manoeuvres, or that stops.
fn target() -> Filter {
    let steady = dmatrix![1.0, 1.0; 0.0, 1.0];
    let force = dmatrix![0.25, 0.5; 0.5, 1.0];
    let models = vec![
        model(steady.clone(), &force * 0.01, 0.5),
        model(steady, force * 4.0, 0.5),
        model(dmatrix![1.0, 0.0; 0.0, 0.0], DMatrix::identity(2, 2) * 0.1, 2.0),
    ];
    let transitions = dmatrix![0.9, 0.06, 0.04; 0.1, 0.8, 0.1; 0.05, 0.15, 0.8];
    Filter::new(models, transitions, dvector![0.5, 0.3, 0.2]).unwrap()
}

fn none() -> DVector<f64> {
    DVector::zeros(0)
}

fn covariance(filter: &Filter, state: &DVector<f64>) -> DMatrix<f64> {
    let mut p = DMatrix::zeros(2, 2);
    assert!(filter.covariance_into(state, p.as_mut_slice()));
    p
}

/// The equations of Blom and Bar-Shalom as filterpy's `IMMEstimator` orders them, computed anew with numpy 2.4: `S^-1`
/// by `numpy.linalg.inv`, densities by `exp` and `det`. After the update of these samples, of which the seventh is
/// missing: mode probabilities, estimate, covariance.
#[test]
fn a_target_that_manoeuvres() {
    let measured = [0.3, 1.1, 2.4, 2.9, 6.0, 9.5, f64::NAN, 13.6, 13.9, 14.0];
    let rows: [Row; 4] = [
        (
            0,
            [0.5299087569653904, 0.31794525417923425, 0.15214598885537525],
            [0.18478540111446243, 1.0],
            [0.38533863882109776, 0.0, 0.5],
        ),
        (
            4,
            [0.714660236387671, 0.24665323407282913, 0.038686529539499845],
            [5.288383963285069, 1.7231604775531153],
            [0.5226426294707422, 0.44976461768328935, 1.0515508805668383],
        ),
        (
            6,
            [0.328525944657203, 0.5791374918734161, 0.09233656346938084],
            [12.078212345742475, 2.9879001990755016],
            [5.092279554322827, 4.4016364881795935, 4.954289061821115],
        ),
        (
            9,
            [0.2828949798802417, 0.3770191619136741, 0.3400858582060841],
            [14.04074766328689, 0.19406775057506467],
            [0.5598454670698669, 0.29574976097986777, 0.9266266233148359],
        ),
    ];
    let filter = target();
    let mut state = filter.initial(0.0, &dvector![0.0, 1.0], &none(), &dvector![0.0]);
    for (k, y) in measured.into_iter().enumerate() {
        let updated = filter.measure(0.0, &mut state, &none(), &dvector![y], &[]);
        assert_eq!(updated.is_some(), y.is_finite(), "{k}");
        if let Some((_, probabilities, xhat, p)) = rows.iter().find(|row| row.0 == k) {
            let mu = filter.probabilities(&state).unwrap();
            assert!((mu - DVector::from_column_slice(probabilities)).amax() < 1e-13, "{k}");
            assert!((filter.estimate(&state) - DVector::from_column_slice(xhat)).amax() < 1e-12, "{k}");
            let expected = dmatrix![p[0], p[1]; p[1], p[2]];
            assert!((covariance(&filter, &state) - expected).amax() < 1e-12, "{k}");
        }
        assert!(filter.advance(0.0, &mut state, &none(), 1.0));
    }
}

/// Equal models are one filter, whatever the mode probabilities do: its estimate, covariance and normalised square.
#[test]
fn equal_models_are_one_filter() {
    let one = || model(dmatrix![1.0, 0.1; -0.2, 0.9], dmatrix![0.1, 0.02; 0.02, 0.3], 0.4);
    let filter = Filter::new(vec![one(), one()], dmatrix![0.7, 0.3; 0.6, 0.4], dvector![0.9, 0.1]).unwrap();
    let alone = one();
    let start = dvector![1.0, -2.0];
    let mut state = filter.initial(0.0, &start, &none(), &dvector![0.0]);
    let mut single = alone.initial(0.0, &start, &none(), &dvector![0.0]);
    for k in 0..50 {
        let y = dvector![f64::from(k).sin()];
        let square = filter.measure(0.0, &mut state, &none(), &y, &[]).unwrap();
        let expected = alone.update(0.0, &mut single, &none(), &y).unwrap();
        assert!((square - expected.normalized_square).abs() < 1e-12 * (1.0 + square));
        assert!((filter.estimate(&state) - single.estimate()).amax() < 1e-13);
        assert!((covariance(&filter, &state) - single.covariance()).amax() < 1e-14);
        let mu = filter.probabilities(&state).unwrap();
        assert!((mu.sum() - 1.0).abs() < 1e-15 && (k == 0 || (mu[0] - 2.0 / 3.0).abs() < 0.3));
        assert!(filter.advance(0.0, &mut state, &none(), 1.0));
        assert!(alone.predict(0.0, &mut single, &none(), 1.0));
    }
    // The stationary distribution of the chain, (2/3, 1/3): no measurement tells the modes apart.
    assert!((filter.probabilities(&state).unwrap()[0] - 2.0 / 3.0).abs() < 1e-12);
}

/// A mode that is certain and stays so is its filter; the others do not matter, even where they are absurd.
#[test]
fn a_certain_mode_is_its_filter() {
    let one = model(dmatrix![1.0, 0.1; -0.2, 0.9], dmatrix![0.1, 0.02; 0.02, 0.3], 0.4);
    let absurd = model(dmatrix![1e200, 0.0; 0.0, 1e200], DMatrix::identity(2, 2) * 1e300, 1e-300);
    let filter = Filter::new(vec![one.clone(), absurd], DMatrix::identity(2, 2), dvector![1.0, 0.0]).unwrap();
    let mut state = filter.initial(0.0, &dvector![1.0, 1.0], &none(), &dvector![0.0]);
    let mut single = one.initial(0.0, &dvector![1.0, 1.0], &none(), &dvector![0.0]);
    for k in 0..20 {
        let y = dvector![0.1 * f64::from(k)];
        filter.step(0.0, &mut state, &none(), &y);
        one.step(0.0, &mut single, &none(), &y);
        assert!((filter.estimate(&state) - single.estimate()).amax() < 1e-13, "{k}");
        assert!((covariance(&filter, &state) - single.covariance()).amax() < 1e-13, "{k}");
        assert_eq!(filter.probabilities(&state).unwrap(), dvector![1.0, 0.0]);
    }
}

/// In units of 1e-12 and 1e12 of state and output the mode probabilities are the same.
#[test]
fn units_do_not_matter() {
    let scaled = |unit: f64| {
        let scale = |w: f64| w * unit * unit;
        let models = [0.01, 4.0].map(|w| {
            let plant = StateSpace::new(dmatrix![1.0], DMatrix::zeros(1, 0), dmatrix![1.0]).unwrap();
            let noises = NoiseModel { w: dmatrix![scale(w)], v: dmatrix![scale(0.5)], p0: dmatrix![scale(1.0)] };
            ExtendedKalmanFilter::discrete(plant, noises, 1.0).unwrap()
        });
        let filter = Filter::new(models.to_vec(), dmatrix![0.9, 0.1; 0.1, 0.9], dvector![0.5, 0.5]).unwrap();
        let mut state = filter.initial(0.0, &dvector![0.0], &none(), &dvector![0.0]);
        for y in [0.2, 0.1, 3.0, 6.0] {
            filter.step(0.0, &mut state, &none(), &dvector![y * unit]);
        }
        filter.probabilities(&state).unwrap()
    };
    for unit in [1e-12, 1e12] {
        assert!((scaled(unit) - scaled(1.0)).amax() < 1e-9);
    }
}

#[test]
fn bad_input_and_bad_samples() {
    let one = || model(DMatrix::identity(2, 2), DMatrix::identity(2, 2), 1.0);
    let half = || dmatrix![0.5, 0.5; 0.5, 0.5];
    let refused = |models, transitions, probabilities| Filter::new(models, transitions, probabilities).unwrap_err();
    assert!(matches!(
        refused(vec![one()], dmatrix![1.0], dvector![1.0]),
        ObserverError::TooFew { what: "models", least: 2, found: 1 }
    ));
    assert!(matches!(refused(vec![one(), one()], dmatrix![1.0], dvector![0.5, 0.5]), ObserverError::Matrix(_)));
    assert!(matches!(refused(vec![one(), one()], half() * f64::NAN, dvector![0.5, 0.5]), ObserverError::Matrix(_)));
    let sum = refused(vec![one(), one()], dmatrix![0.5, 0.5; 0.5, 0.6], dvector![0.5, 0.5]);
    assert!(matches!(sum, ObserverError::Probabilities { row: 1, sum, .. } if sum == 1.1), "{sum}");
    let negative = refused(vec![one(), one()], dmatrix![1.5, -0.5; 0.5, 0.5], dvector![0.5, 0.5]);
    assert!(matches!(negative, ObserverError::Probabilities { row: 0, least, .. } if least == -0.5), "{negative}");
    for start in [dvector![0.5, 0.4], dvector![f64::NAN, 0.5]] {
        assert!(matches!(refused(vec![one(), one()], half(), start), ObserverError::Probabilities { .. }));
    }
    assert!(matches!(refused(vec![one(), one()], half(), dvector![1.0]), ObserverError::Table { expected: 2, .. }));

    let filter = Filter::new(vec![one(), one()], half(), dvector![0.5, 0.5]).unwrap();
    let state = filter.initial(0.0, &dvector![0.0, 0.0], &none(), &dvector![0.0]);
    // Columns of other lengths change nothing, a NaN is no measurement, an impossible sample is passed over.
    for (u, y) in [(dvector![1.0], dvector![1.0]), (none(), dvector![1.0, 2.0])] {
        let mut next = state.clone();
        filter.step(0.0, &mut next, &u, &y);
        assert_eq!(next, state);
    }
    let mut missed = state.clone();
    filter.step(0.0, &mut missed, &none(), &dvector![f64::NAN]);
    let mut predicted = state.clone();
    assert!(filter.advance(0.0, &mut predicted, &none(), 1.0));
    assert_eq!(missed, predicted);
    let mut far = state.clone();
    filter.step(0.0, &mut far, &none(), &dvector![1e300]);
    assert!(filter.probabilities(&far).unwrap().iter().all(|mu| mu.is_finite()));
    assert_eq!(filter.innovation(0.0, &state, &none(), &dvector![2.0]), dvector![2.0]);
    assert!(filter.innovation(0.0, &dvector![0.0], &none(), &dvector![2.0])[0].is_nan());
}
