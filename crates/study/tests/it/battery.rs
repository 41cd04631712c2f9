//! The example of a battery on a log with a gap, a failed sensor, outliers and a temperature every 10 s.
//!
//! The numbers are those of filterpy 2.0.0 (`ExtendedKalmanFilter`, predicted by the exact discretisation of the linear
//! dynamics over the time between two rows, with Q by Van Loan's method, updated by the rows of H that were measured)
//! and of scipy 1.17.1 (`chi2.ppf`).

use std::path::Path;

use luenberger_study::{Results, RunOptions, Step, Study, execute};

/// The example, run into a folder.
fn run(folder: &Path) -> Results {
    let _ = std::fs::remove_dir_all(folder);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/studies/battery/battery.toml");
    let study = Study::from_path(&path).unwrap_or_else(|error| panic!("{error}"));
    let options = RunOptions { output: Some(folder.to_owned().into()), ..RunOptions::default() };
    execute(&study, Step::Run, &options).unwrap_or_else(|error| panic!("{error}"))
}

/// Some columns of a trajectory at a time.
fn row(folder: &Path, file: &str, t: f64, names: [&str; 4]) -> [f64; 4] {
    let text = std::fs::read_to_string(folder.join("trajectories").join(file)).unwrap();
    let head: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let cells = text.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let row = cells.into_iter().find(|cells| cells[0].parse::<f64>() == Ok(t)).unwrap();
    names.map(|name| row[head.iter().position(|title| *title == name).unwrap()].parse().unwrap())
}

#[test]
fn the_battery_is_estimated_as_by_filterpy() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("battery");
    let results = run(&folder);
    assert_eq!(results.failures(), Vec::<String>::new());
    let columns = ["soc_hat", "v1_hat", "soc_2sigma", "temp_hat"];
    // Before the gap, after it, at the end of the dropout, at the end.
    for (file, t, expected) in [
        ("log-EKF.csv", 0.0, [0.9828760397155314, -0.0014249074328391933, 0.04622379863973276, 25.0]),
        ("log-EKF.csv", 10.0, [0.9176299344733025, -0.011152946784307245, 0.025238510121803528, 25.002248164465694]),
        ("log-EKF.csv", 700.0, [0.8392356578808265, 0.01378343931068127, 0.0027581977327812476, 25.52103715388262]),
        ("log-EKF.csv", 1500.0, [0.7122673809102372, 0.004531614128755949, 0.00199159386386478, 25.597246337388682]),
        ("log-EKF.csv", 1900.0, [0.6854308991620425, 0.009586047104428808, 0.0020239319472755836, 25.133763872557186]),
        ("log-EKF.csv", 2459.0, [0.5989341921824608, 0.04759814163143932, 0.001818311205146363, 25.758849251325238]),
        ("log-EKF.csv", 3599.0, [0.42958873842546125, 0.015789221479457608, 0.0017652287196048635, 25.594641588372365]),
        (
            "log-EKF-with-gate.csv",
            700.0,
            [0.835495938778139, 0.015173718970915602, 0.0027603615734073657, 25.52103715388262],
        ),
        (
            "log-EKF-with-gate.csv",
            1900.0,
            [0.6856195834757248, 0.009586590062528787, 0.002024761804783611, 25.133763872557186],
        ),
        (
            "log-EKF-with-gate.csv",
            3599.0,
            [0.42901749976453135, 0.01578397306554575, 0.0017662490350464192, 25.594641588372365],
        ),
    ] {
        let found = row(&folder, file, t, columns);
        for ((found, expected), name) in found.iter().zip(expected).zip(columns) {
            assert!((found - expected).abs() < 1e-8, "{file}, t = {t}, {name}: {found} where {expected} was expected");
        }
    }

    let log = results.log.as_ref().unwrap();
    assert_eq!((log.samples, &log.gaps[..], log.median_period), (3201, &[[1500.0, 1900.0]][..], 1.0));
    let [voltage, temperature] = &log.columns[..] else { panic!("{:?}", log.columns) };
    assert_eq!((voltage.samples, temperature.samples, temperature.median_period), (3141, 321, 10.0));
    let gap = "in the log: Gap 1500-1900 s (median Ts 1 s)".to_owned();
    assert!(results.warnings.contains(&gap), "{:?}", results.warnings);
    let [plain, gated] = &log.rows[..] else { panic!("{:?}", log.rows) };
    for (row, mean, low, high, nees, rmse, last) in [
        (plain, 21.14111010872563, 1.02688285, 1.17466097, 0.1908832101049133, 0.00321275555688109, -2.8738425e-5),
        (gated, 1.0769437526120231, 1.02504675, 1.17274645, 0.6072493280779243, 0.003226646737755775, 5.425002355e-4),
    ] {
        let (nis, truth) = (row.nis.as_ref().unwrap(), &row.errors[0]);
        assert!((nis.mean - mean).abs() < 1e-6 * mean, "{nis:?}");
        assert!((nis.region[0] - low).abs() < 1e-8 && (nis.region[1] - high).abs() < 1e-8, "{nis:?}");
        assert!((row.nees.as_ref().unwrap().mean - nees).abs() < 1e-6 * nees, "{:?}", row.nees);
        assert!((truth.rmse - rmse).abs() < 1e-9 && (truth.last - last).abs() < 1e-8, "{truth:?}");
        assert!((truth.peak - 0.03441333590364659).abs() < 1e-8 && truth.samples == 3201);
    }
    // Four of the six outliers are in the second half; with the gate the filter is consistent, without it is not.
    assert_eq!((plain.outputs[0].rejected, gated.outputs[0].rejected, gated.outputs[1].rejected), (0, 4, 0));
    assert!(!plain.nis.as_ref().unwrap().accepted && gated.nis.as_ref().unwrap().accepted);
}
