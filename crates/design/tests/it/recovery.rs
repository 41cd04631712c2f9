//! Loop transfer recovery on the example of Doyle and Stein, what is not recovered, and mistakes.

use luenberger_design::{
    DesignError, KalmanNoise, LinearDesign, LyapunovWeight, RecoveryObstacle, loop_transfer_recovery, recovery_obstacle,
};
use luenberger_linalg::{FrequencyResponse, LoopTransfer, Realization};
use luenberger_plants::{PlantError, StateSpace};
use nalgebra::{Complex, DMatrix, dmatrix};

/// q squared, L, crossover and phase margin in degrees, difference of the sensitivities.
type Row = (f64, [f64; 2], [f64; 2], f64);

fn near(found: f64, expected: f64, relative: f64) -> bool {
    (found - expected).abs() <= relative * expected.abs()
}

/// The matrices of a plant without feedthrough.
fn matrices(plant: &StateSpace) -> Realization {
    Realization::new(&plant.a, &plant.b, &plant.c, &DMatrix::zeros(plant.c.nrows(), plant.b.ncols())).unwrap()
}

/// The plant `(s + 2)/((s + 1)(s + 3))` with K = [50 10], noise that enters by [35 -61] and q^2 from 100 to 10 000 are
/// those of J. C. Doyle and G. Stein, IEEE Transactions on Automatic Control 24, 1979, as J. L. Crassidis and J. L.
/// Junkins have them, Optimal Estimation of Dynamic Systems, 2nd ed., example 8.3. The numbers are scipy's, 1.17:
/// `solve_continuous_are`, `brentq` for the crossovers, `minimize_scalar` for the largest difference of sensitivities.
#[test]
fn recovery_of_doyle_and_stein() {
    let plant = StateSpace::new(dmatrix![0.0, 1.0; -3.0, -4.0], dmatrix![0.0; 1.0], dmatrix![2.0, 1.0]).unwrap();
    let noise = KalmanNoise::new(&dmatrix![1.0], &dmatrix![1.0]).entering(&dmatrix![35.0; -61.0]);
    let k = dmatrix![50.0, 10.0];
    assert_eq!(recovery_obstacle(&plant).unwrap(), None);
    let rows: [Row; 6] = [
        (0.0, [30.001413786372638, -49.96111558595766], [12.615241644208238, 14.850631367099991], 4.769176480111589),
        (100.0, [26.830149935409736, -40.21166563115878], [13.15813655084721, 19.40280516996861], 3.406750267562773),
        (500.0, [20.381318385627196, -17.747388685911574], [13.722826386877532, 32.37212967808872], 1.6350600902544785),
        (1e3, [16.686983940966513, -1.931869145730161], [13.546613087563166, 42.51268255308747], 1.0008153188518214),
        (1e4, [6.938764124110662, 84.61564330212923], [11.165942328997689, 74.43965936530186], 0.13038666688851958),
        (1e8, [1.061737530312712, 9995.880881112202], [10.583745667011307, 85.8782460656288], 0.0009991018767749969),
    ];
    let found = loop_transfer_recovery(&plant, &noise, &k, &rows.map(|row| row.0.sqrt())).unwrap();
    for (recovery, (squared, l, [crossover, degrees], difference)) in found.iter().zip(rows) {
        let gain = recovery.l.as_slice();
        assert!((gain[0] - l[0]).hypot(gain[1] - l[1]) < 1e-8 * l[0].hypot(l[1]), "{squared}: {gain:?}");
        let margin = recovery.margins.channels[0].phase_margin().unwrap();
        assert!(near(margin.frequency, crossover, 1e-8), "{squared}: {margin:?}");
        assert!(near(margin.angle.to_degrees(), degrees, 1e-8), "{squared}: {margin:?}");
        assert!(near(recovery.difference.norm, difference, 1e-7), "{squared}: {:?}", recovery.difference);
    }
    // The loop itself: K (s I - A)^-1 B at 1 and 10 is 7 - 9j and -0.0772.. - 1.0627..j.
    let transfer = LoopTransfer::new(&matrices(&plant), &found[5].l, &k).unwrap();
    let at = |open: &Realization| FrequencyResponse::continuous(open).unwrap().at(1.0)[(0, 0)];
    assert!((at(&transfer.state_feedback) - Complex::new(7.0, -9.0)).norm() < 1e-13);
    let recovered = at(&transfer.at_inputs);
    assert!((recovered - Complex::new(6.99226757026568, -8.991969514225314)).norm() < 1e-7, "{recovered}");
}

#[test]
fn what_is_not_recovered_is_named() {
    let integrators = dmatrix![0.0, 1.0; 0.0, 0.0];
    // (1 - s)/s^2 has a zero at 1.
    let zero = StateSpace::new(integrators.clone(), dmatrix![0.0; 1.0], dmatrix![1.0, -1.0]).unwrap();
    let Some(RecoveryObstacle::Zero(at)) = recovery_obstacle(&zero).unwrap() else { panic!("no zero") };
    assert!((at - 1.0).norm() < 1e-14, "{at}");
    let wide = StateSpace::new(integrators.clone(), DMatrix::identity(2, 2), dmatrix![1.0, 0.0]).unwrap();
    let expected = Some(RecoveryObstacle::Outputs { inputs: 2, outputs: 1 });
    assert_eq!(recovery_obstacle(&wide).unwrap(), expected);
    let twice = StateSpace::new(integrators, dmatrix![0.0, 0.0; 1.0, 2.0], DMatrix::identity(2, 2)).unwrap();
    assert_eq!(recovery_obstacle(&twice).unwrap(), Some(RecoveryObstacle::Degenerate));
    // With the zero at 1 the difference stays, whatever q is: S - S_t is S_t(1) = 1/(1 + K (1 - A)^-1 B) there or more.
    let noise = KalmanNoise::new(&DMatrix::identity(2, 2), &dmatrix![1.0]);
    let k = dmatrix![1.0, 2.0];
    let found = loop_transfer_recovery(&zero, &noise, &k, &[1e4, 1e6]).unwrap();
    // K (s I - A)^-1 B is (2 s + 1)/s^2, 3 at 1, so that S_t is 1/4; H G vanishes at 1, where S is 1.
    assert!(found.iter().all(|one| one.difference.norm >= 0.75), "{found:?}");
}

#[test]
fn mistakes_are_named() {
    let plant = luenberger_plants::double_integrator().to_dynamic();
    let noise = KalmanNoise::new(&DMatrix::identity(2, 2), &dmatrix![1.0]);
    let k = dmatrix![1.0, 2.0];
    for q in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = loop_transfer_recovery(&plant, &noise, &k, &[q]).unwrap_err();
        assert!(matches!(refused, DesignError::Negative { .. }), "{refused}");
        let filter = LinearDesign::kalman_of(&plant, &noise.clone().recovering(q), LyapunovWeight::default());
        assert!(matches!(filter, Err(DesignError::Negative { .. })));
    }
    let unstable = loop_transfer_recovery(&plant, &noise, &(-&k), &[0.0]).unwrap_err();
    assert!(matches!(unstable, DesignError::NotHurwitz { what: "A - B K", .. }), "{unstable}");
    let shape = loop_transfer_recovery(&plant, &noise, &dmatrix![1.0], &[0.0]).unwrap_err();
    assert!(matches!(shape, DesignError::Matrix(PlantError::DimensionMismatch { what: "K", .. })), "{shape}");
}

/// A filter that recovers is the filter for the larger noise, and with q = 0 the filter as it was, to the bit. In other
/// units of time, input and state the gain is the same one in these units.
#[test]
fn a_filter_that_recovers() {
    let plant = luenberger_plants::double_integrator().to_dynamic();
    let noise = KalmanNoise::new(&DMatrix::identity(2, 2), &dmatrix![0.5]);
    let gain = |plant: &StateSpace, noise: &KalmanNoise| {
        LinearDesign::kalman_of(plant, noise, LyapunovWeight::default()).unwrap().l().clone()
    };
    assert_eq!(gain(&plant, &noise.clone().recovering(0.0)), gain(&plant, &noise));
    let larger = KalmanNoise::new(&dmatrix![1.0, 0.0; 0.0, 10.0], &dmatrix![0.5]);
    assert_eq!(gain(&plant, &noise.clone().recovering(3.0)), gain(&plant, &larger));
    for unit in [1e-12, 1e12] {
        // Inputs in other units: B in the inverse ones, and q for them.
        let scaled = StateSpace { b: &plant.b / unit, ..plant.clone() };
        let (found, expected) = (gain(&scaled, &noise.clone().recovering(3.0 * unit)), gain(&plant, &larger));
        assert!((found - &expected).norm() <= 1e-12 * expected.norm());
    }
}
